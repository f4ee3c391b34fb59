/*
 * nlgs.c: projected Gauss-Seidel on the reactions (nonlinear Gauss-Seidel), [Jean 1988] 3.3.
 *
 *   u = W r + q,   0 <= u_n _|_ r_n >= 0,   |r_t| <= mu r_n,   u_t opposed to r_t where it slips
 *
 * u = W r + q is kept up to date by columns. One sweep, for c = 0 .. nc-1:
 *
 *   (NL1)  p  = u_c - W_cc r_c                what the others leave to candidate c
 *   (NL2)  s  = the solution of candidate c alone, u_c = W_cc s + p            (local.c)
 *   (NL3)  s := P_Cmu( r_c + omega (s - r_c) )           only if omega is not 1
 *   (NL4)  u += W(:,c) (s - r_c),   r_c := s             only if s is not r_c
 *
 * (NL0) A candidate with r_c = 0 and u_n >= 0 stays free: (NL1)-(NL4) give nothing else. The
 * projection in (NL3) is the orthogonal one on the cone; for omega <= 1 it changes nothing, the
 * cone being convex. Under omega < 1 the r_c of a candidate that has left the obstacle is put to
 * exactly 0 once it is too small to move u.
 *
 * Stop: each sweep ends with an estimate of both parts of the certificate's residual from the u at
 * hand, O(nc); from 1000 candidates on, W not dense and without (NL6), every fifth one: it costs a
 * seventh of a sweep by blocks, and half of one of bodies. (NL5) When each meets its target,
 * max(tol, 4 floor), when a sweep changes nothing, and every 50 sweeps, u and the certificate are
 * recomputed from the user's W and q. A sweep from such a fresh u that changes nothing and is not
 * solved can never change anything: DLS_STALLED. A call that ends early returns the best r met.
 *
 * Accelerated, the sweep g is a fixed-point map x -> r = g(x). Between two sweeps,
 *
 *   (NL6)  f = D (r - x), D = diag(w_c) 2^k, 2^k |q| about 1;  x := r - DG gamma, u := u - DU gamma
 *          by Anderson (anderson.c), then each x_c := P_Cmu(x_c) with u by columns
 *   (NL7)  instead, if the residual of r exceeds 1.1 times that of the g before: back to that g,
 *          its u afresh, history forgotten; the plain sweep that follows is always taken
 *
 * With momentum (momentum.c) instead, where W is by blocks,
 *
 *   (NL8)  x := r + b p, u likewise, between two sweeps
 *   (NL9)  from sweep 50 on, every 10: the fewest candidates that hold nine tenths of |F|^2, and
 *          three layers of what W couples with them, if that is not a third of all, get up to 300
 *          sweeps of their own, until |F| on them is 0.3 of what it was; (NL8) begins anew then.
 *          Where it is a third and more, the next 1, 2, 4 .. 16 looks are left out
 *   (NL12) beyond 1000 candidates another way is (NL8) HELD, begun anew every 10 sweeps in which
 *          the residual has not fallen by a tenth: some large packings at rest need it. A stage of
 *          auto has (NL6) as a way, too, in place of (NL8) and (NL9): in 2D as the first one, in 3D
 *          beyond 1000 candidates as the second one. Which way goes on is told by the price of a
 *          halving of the residual (race.c); another one begins from the best r
 *
 * Of rigid bodies, W = H^T H, a sweep keeps v = H r up to date in place of u:
 *
 *   (NL11) u_c = q_c + H_c^T v in (NL1);  v += H_c (s - r_c) in (NL4); u of all candidates is made
 *          for the estimate alone
 *
 * With several threads W by blocks and bodies are swept in slabs, two colours of them (slabs.c), a
 * dense W row by row: to the bits of one thread.
 *
 * Whatever x is, r = g(x) is the iterate that is measured, kept as the best and returned. Sweeps do
 * not damp the rounding of u, and (NL6) amplifies it; with u afresh in (NL7) and a bound on gamma,
 * estimate and certificate stay within 1 % on the FCLIB files but for BoxesStack1 (1 in 25 of its
 * refreshes finds a factor of 10). Without the two, a call on the cycle of tests/method/test_nlgs.c
 * estimated 4e-8 for an r of residual 0.7.
 *
 * W dense: u receives the changes of four candidates in one pass over their columns (products.c); a
 * candidate that is visited before that pass adds the outstanding changes to its own rows. Every
 * u_i still receives them in the order of the candidates: the bits are those of one by one.
 *
 * Source: [Jean 1988] 3.3 names Gauss-Seidel on (3.3)5-6; the form with exact local solutions is
 * Jourdan, Alart and Jean 1998. Deviation: u is updated by columns, where the usual code recomputes
 * row c of W r: the same arithmetic, but candidates that do not change cost nothing, and the
 * residual is free. (NL6) with two sweeps is what [Chabrand 1998] 4.2 names (Aitken, after Raous,
 * Barbosa and Latil).
 *
 * Cost of a sweep: the columns of W of the candidates that changed, once; besides O(nc).
 * Accelerated: (3 window + 10) m operations or so, and the columns of the candidates that (NL6)
 * projects.
 * What can fail: nothing guarantees convergence with friction. It can cycle for ever (W SPD and mu
 * = 1 suffice, tests/method/test_nlgs.c), and needs many sweeps for ill-conditioned W. A candidate
 * without a local solution (W_cc indefinite, or wedged by a large mu) gets the least bad point; the
 * certificate then does not hold.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "vi_internal.h"

enum { most_sweeps = 10000, refresh_every = 50, most_window = 100 };
enum { few_candidates = 1000, seldom = 5 }; /* sweeps from one estimate to the next */

/* (NL7) Growth of the residual that an accelerated iterate may show: on nine FCLIB files together
 * (Anderson, 1e-8) a growth of 2 takes 19335 sweeps where 1.1 takes 11758. */
static const double nlgs_growth = 1.1;

/* What momentum needs for a problem of bodies; memory is kept from one to the next. */
typedef struct nlgs_bodies {
  double *moved; /* u and pu of momentum, then u and DU of the history: n count each column */
  int *some;     /* bodies of (NL9), then a mark for each: 2 count */
  size_t moved_room, some_room;
} nlgs_bodies;

/* (NL12) */
typedef enum nlgs_way { FREE, HELD, ANDERSON } nlgs_way;

struct dls_nlgs {
  dls_nlgs_settings settings;
  int d, nc;
  int stage;               /* of auto: from r as given, in an order of its own, no ambiguous */
  int *own_order;          /* of a stage: nc; else NULL */
  int *scratch;            /* of a stage: nc; else NULL */
  const int *order;        /* of the visits in this run: nc; NULL: 0, 1, .. */
  double *carved[4];       /* u, pu of momentum; u, DU of the history: where not of bodies */
  double *block_1d;        /* W_cc (+ E_c): nc; for d = 1, else NULL */
  dlsi_block_2d *block_2d; /* the same for d = 2 */
  dlsi_block_3d *block_3d; /* the same for d = 3 */
  dlsi_iterate it;         /* its u is kept up to date by the sweeps */
  dlsi_formed formed;      /* of a problem of bodies: scratch, W by blocks */
  int motions;             /* of a body; 0 where u is kept up to date */
  double *v;               /* H r of bodies, kept up to date by the sweeps in place of u */
  nlgs_bodies bodies;
  dlsi_slabs slabs; /* more than one thread */
  dlsi_team *team;  /* that help in this run; NULL: none */
  double *x;        /* r that the sweep started from, if accelerated: m */
  dlsi_anderson history;
  dlsi_momentum momentum;
  int *near; /* of momentum: nc, layer of (NL9) of each candidate, from 1 on; 0: not in a set */
  int *some, *rows; /* of momentum: nc, the sets of (NL9) */
  double largest;   /* b of momentum, (NL10) */
  double halved;    /* (NL10): the residual that was last half of the one before it ... */
  double since;     /* ... and the sweeps until then, those on a set by its share */
  double looked;    /* the residual when (NL9) was due last */
  int pause, wait;  /* (NL9): looks left out after a set that was too large; of them to come */
  double sweeps;
  dlsi_race race; /* (NL12) */
  nlgs_way way[dlsi_most_ways], now;
};

void dls_nlgs_settings_init(dls_nlgs_settings *settings) {
  if (!settings) return;
  *settings = (dls_nlgs_settings){.size = sizeof *settings, .relaxation = 1, .window = 10};
  dlsi_limits_init(&settings->limits);
}

/* Returns 1 for (NL6). */
static int nlgs_has_history(const dls_nlgs_settings *s) {
  return s->acceleration == DLS_ACCELERATION_AITKEN || s->acceleration == DLS_ACCELERATION_ANDERSON;
}

/* Returns 1 if (NL6) is one of the ways of (NL12). */
static int nlgs_may_turn(const dls_nlgs *work) {
  const int pushed = work->settings.acceleration == DLS_ACCELERATION_MOMENTUM;
  return work->stage && pushed && (work->d == 2 || work->nc > few_candidates);
}

static void nlgs_carve(void *workspace, dlsi_arena *arena) {
  dls_nlgs *work = workspace;
  const dls_nlgs_settings *s = &work->settings;
  const size_t n = (size_t)work->nc, m = (size_t)work->d * n;
  if (work->d == 1)
    work->block_1d = dlsi_take(arena, n, sizeof *work->block_1d);
  else if (work->d == 2)
    work->block_2d = dlsi_take(arena, n, sizeof *work->block_2d);
  else
    work->block_3d = dlsi_take(arena, n, sizeof *work->block_3d);
  dlsi_iterate_carve(&work->it, arena, work->d, work->nc, &work->settings.limits);
  if (work->stage) {
    work->own_order = dlsi_take(arena, n, sizeof *work->own_order);
    work->scratch = dlsi_take(arena, n, sizeof *work->scratch);
  }
  if (s->acceleration == DLS_ACCELERATION_MOMENTUM) {
    dlsi_momentum_carve(&work->momentum, arena, m);
    work->carved[0] = work->momentum.u;
    work->carved[1] = work->momentum.pu;
    work->near = dlsi_take(arena, n, sizeof *work->near);
    work->some = dlsi_take(arena, n, sizeof *work->some);
    work->rows = dlsi_take(arena, n, sizeof *work->rows);
  }
  if (!nlgs_has_history(s) && !nlgs_may_turn(work)) return;
  work->x = dlsi_take(arena, m, sizeof *work->x);
  dlsi_anderson_carve(&work->history, arena, m,
                      s->acceleration == DLS_ACCELERATION_AITKEN ? 1 : s->window, m);
  work->carved[2] = work->history.u;
  work->carved[3] = work->history.DU;
}

static dls_status nlgs_create(void **out, int d, int nc, int stage,
                              const dls_nlgs_settings *settings, dls_error *error) {
  dls_nlgs work = {.d = d, .nc = nc, .stage = stage};
  dls_nlgs_settings *s = &work.settings;
  dls_nlgs_settings_init(s);
  if (settings) *s = *settings;
  const dlsi_setting own[] = {{"relaxation", s->relaxation, 0, 2, 1},
                              {"acceleration", s->acceleration, 0, DLS_ACCELERATION_MOMENTUM, 0},
                              {"window", s->window, 1, most_window, 0}};
  *out = NULL;
  dls_status status = dlsi_check_sizes(d, nc, error);
  if (!status) status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 3, own, error);
  return status ? status : dlsi_workspace(out, &work, sizeof work, nlgs_carve, nc, error);
}

dls_status dls_nlgs_create(dls_nlgs **out, int d, int nc, const dls_nlgs_settings *settings,
                           dls_error *error) {
  DLSI_DOOR;
  void *work = NULL;
  const dls_status status =
      out ? nlgs_create(&work, d, nc, 0, settings, error) : dlsi_is_null(error, "out");
  if (out) *out = work;
  return dlsi_at(__func__, status, error);
}

void dls_nlgs_destroy(dls_nlgs *workspace) {
  if (!workspace) return;
  dlsi_formed_free(&workspace->formed);
  dlsi_slabs_free(&workspace->slabs);
  free(workspace->bodies.moved);
  free(workspace->bodies.some);
  free(workspace);
}

/* ---- the sweep ------------------------------------------------------------------------------- */

enum { batch_size = 4 };
enum { large_panel = 2000 }; /* rows: W is 32 MB then, and a panel takes longer than a barrier */

/* W dense: changes of r that u is still to receive, all rows of u in one go. */
typedef struct nlgs_batch {
  int count, c[batch_size];
  int normal; /* 1: no change of a tangent, so that W's columns of tangents are not read */
  double dr[3 * batch_size];
} nlgs_batch;

/* v := u_c with the changes of the batch. b is NULL for W by blocks. */
static inline void nlgs_look(int d, const dls_contact *problem, const nlgs_batch *b, int c,
                             const double *u, double *v) {
  const size_t D = (size_t)d, ld = (size_t)problem->W.ld, row = D * (size_t)c;
  for (size_t i = 0; i < D; i++)
    v[i] = u[row + i];
  for (int k = 0; b && k < b->count; k++) {
    const double *w = problem->W.a + row + D * (size_t)b->c[k] * ld, *dr = b->dr + d * k;
    for (size_t i = 0; i < D; i++) {
      double sum = w[i] * dr[0];
      for (size_t j = 1; j < D; j++)
        sum += w[i + j * ld] * dr[j];
      v[i] += sum;
    }
  }
}

/* Adds E_c dr to u_c. */
static inline void nlgs_add_springs(const dls_nlgs *work, int d, int c, const double *dr) {
  double *uc = work->it.u + (size_t)d * (size_t)c;
  for (int i = 0; work->it.E && i < d; i++)
    uc[i] += work->it.E[c] * dr[i];
}

/* A batch and the rows of u that one thread adds it to. */
typedef struct nlgs_panel {
  const dls_nlgs *work;
  const dls_contact *problem;
  const nlgs_batch *b;
  int pieces;
} nlgs_panel;

static void nlgs_add_rows(void *data, int piece) {
  const nlgs_panel *s = data;
  const int first = dlsi_piece(s->problem->nc, s->pieces, piece);
  const size_t row = (size_t)s->problem->d * (size_t)first;
  dls_contact part = *s->problem;
  part.nc = dlsi_piece(s->problem->nc, s->pieces, piece + 1) - first;
  part.W.a += row;
  dlsi_contact_add_panel(&part, s->b->count, s->b->c, s->b->dr, s->work->it.u + row);
}

static void nlgs_flush(const dls_nlgs *work, const dls_contact *problem, nlgs_batch *b) {
  if (work->team && b->count) {
    nlgs_panel s = {work, problem, b, work->settings.limits.threads};
    dlsi_parallel(work->team, s.pieces, nlgs_add_rows, &s);
  } else
    dlsi_contact_add_panel(problem, b->count, b->c, b->dr, work->it.u);
  for (int k = 0; k < b->count; k++)
    nlgs_add_springs(work, problem->d, b->c[k], b->dr + problem->d * k);
  b->count = 0;
}

/* (NL4) for one candidate: into the batch, or at once (b NULL, W by blocks). With springs the batch
 * is flushed at once, since E_c comes after W_cc. */
static inline void nlgs_change(const dls_nlgs *work, const dls_contact *problem, int c,
                               const double *dr, nlgs_batch *b) {
  const size_t d = (size_t)problem->d;
  if (b) {
    const int normal = d < 2 || (dr[1] == 0 && (d < 3 || dr[2] == 0));
    if (b->count && normal != b->normal) nlgs_flush(work, problem, b); /* half of the columns */
    b->normal = normal;
    memcpy(b->dr + d * (size_t)b->count, dr, d * sizeof *dr);
    b->c[b->count++] = c;
    if (b->count == batch_size || work->it.E) nlgs_flush(work, problem, b);
    return;
  }
  dlsi_contact_add_columns(problem, c, dr, work->it.u);
  nlgs_add_springs(work, problem->d, c, dr);
}

enum { ahead = 3, line = 8 }; /* candidates; doubles of a line of the cache */

/* Asks for H and the own block of a candidate that is visited soon. */
static DLSI_INLINE void nlgs_fetch(const int d, const int n, const dls_nlgs *work,
                                   const dls_contact *problem, size_t c) {
  const double *H = problem->bodies.H + c * 2 * (size_t)(n * d);
  for (int k = 0; k < 2 * n * d; k += line)
    __builtin_prefetch(H + k);
  if (d != 3) return;
  const double *own = (const double *)(const void *)(work->block_3d + c);
  for (int k = 0; k < (int)(sizeof *work->block_3d / sizeof *own); k += line)
    __builtin_prefetch(own + k);
}

/* (NL0)-(NL4) for the candidates of a set, inlined for constants d and n, motions of a body or 0.
 * Returns how many changed. */
static DLSI_INLINE int nlgs_visit(const int d, const int n, const dls_nlgs *work,
                                  const dls_contact *problem, dlsi_set set, nlgs_batch *b,
                                  double *r) {
  const double omega = work->settings.relaxation;
  int changed = 0;
  for (int k = 0; k < set.count; k++) {
    const int c = set.list ? set.list[k] : k;
    double *rc = r + (size_t)d * (size_t)c, uc[3] = {0}, p[3] = {0}, s[3] = {0}, v[3], dr[3];
    const double *W = d == 1   ? work->block_1d + c
                      : d == 2 ? work->block_2d[c].W
                               : work->block_3d[c].W;
    dlsi_pair_of_bodies of;
    if (n && set.list && k + ahead < set.count) /* a slab steps over memory */
      nlgs_fetch(d, n, work, problem, (size_t)set.list[k + ahead]);
    if (n) {
      of = dlsi_bodies_of(&problem->bodies, (size_t)d * (size_t)n, (size_t)c, work->v);
      dlsi_bodies_look(d, n, &of, problem->q + (size_t)d * (size_t)c, uc);
    } else
      nlgs_look(d, problem, b, c, work->it.u, uc);
    if (rc[0] == 0 && uc[0] >= 0 && (d < 2 || rc[1] == 0) && (d < 3 || rc[2] == 0))
      continue;                   /* (NL0) */
    for (int i = 0; i < d; i++) { /* (NL1) */
      double sum = W[i] * rc[0];
      for (int j = 1; j < d; j++)
        sum += W[i + d * j] * rc[j];
      p[i] = uc[i] - sum;
    }
    dls_local_state state; /* (NL2) */
    if (d == 1)
      state = dlsi_local_1d(*W, p, s);
    else if (d == 2)
      state = dlsi_local_2d(work->block_2d + c, p, s);
    else { /* u_t = -guess r_t; NaN for none */
      const double guess = -(uc[1] * rc[1] + uc[2] * rc[2]) / (rc[1] * rc[1] + rc[2] * rc[2]);
      state = dlsi_local_3d(work->block_3d + c, p, guess, s);
    }
    if (omega != 1) { /* (NL3) */
      for (int i = 0; i < d; i++)
        v[i] = rc[i] + omega * (s[i] - rc[i]);
      if (state != DLS_LOCAL_FREE || work->it.w[c] * v[0] > DBL_EPSILON * p[0])
        dlsi_project_cone(d, problem->mu[c], v, s);
    }
    int moves = 0;
    for (int i = 0; i < d; i++) {
      dr[i] = s[i] - rc[i];
      moves |= dr[i] != 0;
    }
    if (!moves) continue;
    if (n) /* (NL4) */
      dlsi_bodies_push(d, n, &of, dr);
    else
      nlgs_change(work, problem, c, dr, b);
    for (int i = 0; i < d; i++)
      rc[i] = s[i];
    changed++;
  }
  return changed;
}

/* One sweep over a list; returns how many candidates changed. */
static int nlgs_sweep_list(const dls_nlgs *work, const dls_contact *problem, dlsi_set set,
                           double *r) {
  if (work->motions)
    return problem->d == 3      ? nlgs_visit(3, 6, work, problem, set, NULL, r)
           : problem->d == 2    ? nlgs_visit(2, 3, work, problem, set, NULL, r)
           : work->motions == 3 ? nlgs_visit(1, 3, work, problem, set, NULL, r)
                                : nlgs_visit(1, 6, work, problem, set, NULL, r);
  nlgs_batch dense = {0}, *b = problem->Wb.x ? NULL : &dense;
  const int changed = problem->d == 1   ? nlgs_visit(1, 0, work, problem, set, b, r)
                      : problem->d == 2 ? nlgs_visit(2, 0, work, problem, set, b, r)
                                        : nlgs_visit(3, 0, work, problem, set, b, r);
  if (b) nlgs_flush(work, problem, b);
  return changed;
}

/* The slabs of one parity in a sweep. */
typedef struct nlgs_slabs {
  const dls_nlgs *work;
  const dls_contact *problem;
  dlsi_set set;
  double *r;
  int parity;
} nlgs_slabs;

static void nlgs_sweep_slab(void *data, int k) {
  const nlgs_slabs *s = data;
  const int slab = 2 * k + s->parity, first = s->set.start[slab];
  const dlsi_set part = {.list = s->set.list + first, .count = s->set.start[slab + 1] - first};
  s->work->slabs.changed[slab] = nlgs_sweep_list(s->work, s->problem, part, s->r);
}

/* One sweep over a set; returns how many candidates changed. */
static int nlgs_sweep(const dls_nlgs *work, const dls_contact *problem, dlsi_set set, double *r) {
  if (!set.slabs) return nlgs_sweep_list(work, problem, set, r);
  nlgs_slabs s = {work, problem, set, r, 0};
  int changed = 0;
  for (; s.parity < 2; s.parity++)
    dlsi_parallel(work->team, (set.slabs + 1 - s.parity) / 2, nlgs_sweep_slab, &s);
  for (int k = 0; k < set.slabs; k++)
    changed += work->slabs.changed[k];
  return changed;
}

/* ---- the residual ---------------------------------------------------------------------------- */

/* Sums of squares for the estimate, without unit: lengths times scale = 1 / |q|, forces times scale
 * w_0. r and q are those of the contacts that are not free. */
typedef struct nlgs_squares {
  double F, force, r, q; /* D^1/2 F', D^-1/2 F', r, q */
} nlgs_squares;

/* Returns the sums from the u at hand, d = 1 or 2, inlined for a constant d. */
static DLSI_INLINE nlgs_squares nlgs_squares_flat(const int d, const dls_nlgs *work,
                                                  const dls_contact *problem, const double *r,
                                                  double scale, int begin, int end) {
  nlgs_squares sum = {0};
  const double unit = work->it.w[0];
  for (int c = begin; c < end; c++) {
    const size_t o = (size_t)d * (size_t)c;
    const double *rc = r + o, *uc = work->it.u + o, *qc = problem->q + o;
    if (rc[0] == 0 && uc[0] >= 0) continue; /* F_c = 0, r_c = 0 */
    const double *w = work->it.weights + 2 * (size_t)c;
    double F[3];
    const int touches = dlsi_contact_misfit(d, problem->mu[c], w, rc, uc, F) != DLS_FREE;
    for (int i = 0; i < d; i++) {
      const double f = F[i] * scale, soft = unit / w[i > 0] * f;
      sum.F += f * f;
      sum.force += soft * soft;
      if (!touches) continue;
      sum.r += (scale * unit * rc[i]) * (scale * unit * rc[i]);
      sum.q += (scale * qc[i]) * (scale * qc[i]);
    }
  }
  return sum;
}

static nlgs_squares nlgs_squares_1d(const dls_nlgs *work, const dls_contact *problem,
                                    const double *r, double scale, int begin, int end) {
  return nlgs_squares_flat(1, work, problem, r, scale, begin, end);
}

static nlgs_squares nlgs_squares_2d(const dls_nlgs *work, const dls_contact *problem,
                                    const double *r, double scale, int begin, int end) {
  return nlgs_squares_flat(2, work, problem, r, scale, begin, end);
}

/* Returns those sums for d = 3, several contacts at once: their roots and divisions take as long as
 * those of one. */
DLSI_CLONES static nlgs_squares nlgs_squares_3d(const dls_nlgs *work, const dls_contact *problem,
                                                const double *r, double scale, int begin, int end) {
  enum { lanes = 16 };
  nlgs_squares sum = {0};
  const double unit = work->it.w[0];
  for (int first = begin; first < end; first += lanes) {
    const int count = end - first < lanes ? end - first : lanes;
    double v[3][lanes] = {{0}}, u[3][lanes] = {{0}}, q2[lanes] = {0};
    double mu[lanes] = {0}, wn[lanes], wt[lanes], F2[lanes], G2[lanes], r2[lanes];
    int moves = 0, bonded = 0;
    for (int k = 0; k < lanes; k++)
      wn[k] = wt[k] = 1;
    for (int k = 0; k < count; k++) {
      const size_t c = (size_t)(first + k), o = 3 * c;
      const double *rc = r + o, *uc = work->it.u + o, *qc = problem->q + o;
      moves |= !(rc[0] == 0 && uc[0] >= 0);
      mu[k] = problem->mu[c];
      bonded |= dlsi_is_bonded(mu[k]);
      wn[k] = work->it.weights[2 * c];
      wt[k] = work->it.weights[2 * c + 1];
      for (int i = 0; i < 3; i++) {
        u[i][k] = scale * uc[i];
        v[i][k] = scale * (i ? wt[k] : wn[k]) * rc[i];
        q2[k] += (scale * qc[i]) * (scale * qc[i]);
      }
    }
    if (!moves) continue;
    /* All branches of dlsi_contact_misfit */
    for (int k = 0; k < lanes; k++) {
      const double n = v[0][k] - u[0][k], x = v[1][k] - u[1][k], y = v[2][k] - u[2][k];
      const double t = sqrt(x * x + y * y), R = mu[k] * (wt[k] / wn[k]) * n;
      const int polar = n < 0, inside = t <= R;
      const double f = polar ? 0 : inside ? 1 : R / t;
      const double F[3] = {polar ? v[0][k] : u[0][k], v[1][k] - f * x, v[2][k] - f * y};
      const double a = unit / wn[k], b = unit / wt[k];
      const double Ft = F[1] * F[1] + F[2] * F[2], vt = v[1][k] * v[1][k] + v[2][k] * v[2][k];
      F2[k] = F[0] * F[0] + Ft;
      G2[k] = a * a * (F[0] * F[0]) + b * b * Ft;
      r2[k] = polar ? 0 : a * a * (v[0][k] * v[0][k]) + b * b * vt;
      q2[k] = polar ? 0 : q2[k];
    }
    for (int k = 0; k < count && bonded; k++) { /* infinite friction has no part in the above */
      if (!dlsi_is_bonded(mu[k])) continue;
      const size_t o = 3 * (size_t)(first + k);
      F2[k] = G2[k] = r2[k] = q2[k] = 0;
      const int touches = v[0][k] > u[0][k];
      for (int i = 0; i < 3; i++) {
        const double soft = unit / (i ? wt[k] : wn[k]), F = touches ? u[i][k] : v[i][k];
        F2[k] += F * F;
        G2[k] += soft * soft * (F * F);
        r2[k] += touches ? soft * soft * (v[i][k] * v[i][k]) : 0;
        q2[k] +=
            touches ? scale * scale * (problem->q[o + (size_t)i] * problem->q[o + (size_t)i]) : 0;
      }
    }
    for (int k = 0; k < count; k++) {
      sum.F += F2[k];
      sum.force += G2[k];
      sum.r += r2[k];
      sum.q += q2[k];
    }
  }
  return sum;
}

/* The sums by pieces. */
typedef struct nlgs_estimates {
  const dls_nlgs *work;
  const dls_contact *problem;
  const double *r;
  double scale;
  int pieces;
  nlgs_squares sum[dlsi_most_pieces];
} nlgs_estimates;

static void nlgs_sum_piece(void *data, int k) {
  nlgs_estimates *s = data;
  const dls_contact *problem = s->problem;
  const int d = problem->d, begin = dlsi_piece(problem->nc, s->pieces, k);
  const int end = dlsi_piece(problem->nc, s->pieces, k + 1);
  if (s->work->motions) dlsi_bodies_unfold(problem, begin, end, s->work->it.u);
  s->sum[k] = (d == 1   ? nlgs_squares_1d
               : d == 2 ? nlgs_squares_2d
                        : nlgs_squares_3d)(s->work, problem, s->r, s->scale, begin, end);
}

/* Estimates the residuals of the certificate from the u at hand, of bodies from their motions. */
static void nlgs_estimate(const dls_nlgs *work, const dls_contact *problem, const double *r,
                          double scale, dls_certificate *now) {
  const int threads = work->settings.limits.threads;
  nlgs_estimates s = {work, problem, r, scale, dlsi_pieces(threads, problem->nc), {{0, 0, 0, 0}}};
  nlgs_squares sum = {0};
  dlsi_parallel(work->team, s.pieces, nlgs_sum_piece, &s);
  for (int k = 0; k < s.pieces; k++) {
    sum.F += s.sum[k].F;
    sum.force += s.sum[k].force;
    sum.r += s.sum[k].r;
    sum.q += s.sum[k].q;
  }
  const double f = sqrt(sum.F), q = sqrt(sum.q); /* q = 0: the certificate takes |W||r| */
  dlsi_set_residuals(now, q > 0 ? f / q : f, sqrt(sum.force), sqrt(sum.r));
}

/* Returns what the sweeps keep up to date: u, or v of bodies. */
static double *nlgs_kept(const dls_nlgs *work) {
  return work->motions ? work->v : work->it.u;
}

/* Brings u to the bits that belong to the order of the visits, not to the numbers: sweeps go on
 * from it. */
static void nlgs_resume(const dls_nlgs *work, const dls_contact *problem, const double *r) {
  if (work->order) dlsi_multiply(problem, work->order, work->it.E, r, work->it.u, NULL);
}

/* Returns to an r met before, u afresh. */
static void nlgs_return(const dls_nlgs *work, const dls_contact *problem, const double *from,
                        double *r) {
  memcpy(r, from, (size_t)problem->d * (size_t)problem->nc * sizeof *r);
  dlsi_multiply(problem, work->order, work->it.E, r, work->it.u, NULL);
}

/* ---- back on the cones ----------------------------------------------------------------------- */

/* Projects r on its cones, so that r_n = 0 means r_c = 0 (NL0). Returns 1 if r was outside. */
static int nlgs_project_start(const dls_contact *problem, double *r) {
  const size_t d = (size_t)problem->d;
  int outside = 0;
  for (int c = 0; c < problem->nc; c++) {
    double *rc = r + d * (size_t)c, v[3];
    memcpy(v, rc, d * sizeof *v);
    outside |= dlsi_project_cone(problem->d, problem->mu[c], v, rc) != DLS_STICK;
  }
  return outside;
}

/* dr := P_Cmu(rc) - rc. Returns 0 if that is mere rounding, as it is for most r_c that slip. */
static inline int nlgs_lack(int d, double mu, const double *rc, double *dr) {
  double p[3] = {0}, size = 0, moved = 0;
  if (dlsi_project_cone(d, mu, rc, p) == DLS_STICK) return 0;
  for (int i = 0; i < d; i++) {
    dr[i] = p[i] - rc[i];
    size += fabs(rc[i]);
    moved += fabs(dr[i]);
  }
  return !(moved <= 8 * DBL_EPSILON * size);
}

/* Projects every r_c on its cone, u by columns, v of bodies. */
static void nlgs_repair(const dls_nlgs *work, const dls_contact *problem, double *r) {
  const int d = problem->d, n = work->motions;
  nlgs_batch dense = {0}, *b = problem->W.a ? &dense : NULL;
  for (int k = 0; k < problem->nc; k++) {
    const int c = work->order ? work->order[k] : k;
    double *rc = r + (size_t)d * (size_t)c, dr[3] = {0};
    if (!nlgs_lack(d, problem->mu[c], rc, dr)) continue;
    if (n) {
      const dlsi_pair_of_bodies of =
          dlsi_bodies_of(&problem->bodies, (size_t)d * (size_t)n, (size_t)c, work->v);
      dlsi_bodies_push(d, n, &of, dr);
    } else
      nlgs_change(work, problem, c, dr, b);
    for (int i = 0; i < d; i++)
      rc[i] += dr[i];
  }
  if (b) nlgs_flush(work, problem, b);
}

/* ---- accelerated ----------------------------------------------------------------------------- */

/* Returns the power of two next to x > 0, which scales f without rounding: the last digit of |q|
 * depends on the numbers of the candidates. */
static double nlgs_power_of_two(double x) {
  int e;
  (void)frexp(x, &e);
  return ldexp(1, e);
}

/* (NL6) r := the start of the next sweep. r = g(x) has the estimated residual `residual`, the g of
 * the sweep before had *accepted; scale = 1 / |q|. */
static void nlgs_accelerate(dls_nlgs *work, const dls_contact *problem, double residual,
                            double scale, double *accepted, double *r) {
  dlsi_anderson *history = &work->history;
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  if (history->columns && !(residual <= nlgs_growth * *accepted)) { /* (NL7) */
    nlgs_return(work, problem, history->g, r);
    dlsi_anderson_clear(history);
  } else {
    *accepted = residual;
    const double unit = nlgs_power_of_two(scale);
    double *f = work->it.F; /* in the order of the visits, as all sums of the history */
    for (size_t k = 0; k < m / d; k++) {
      const size_t c = work->order ? (size_t)work->order[k] : k;
      for (size_t i = d * c; i < d * (c + 1); i++)
        *f++ = unit * work->it.w[c] * (r[i] - work->x[i]);
    }
    if (dlsi_anderson_step(history, (int)m, work->it.F, r, nlgs_kept(work)))
      nlgs_repair(work, problem, r);
  }
  memcpy(work->x, r, m * sizeof *r);
}

/* ---- momentum -------------------------------------------------------------------------------- */

enum { local_every = 10, local_first = 50, local_sweeps = 300, local_looks = 5, local_layers = 3 };
enum { slow_first = 300, slow_race = 800, last_patience = 3 };
static const double slow_momentum = 0.5; /* (NL10) */
static const double racing_falls = 0.8;  /* (NL10): of the residual, with several ways */
static const double local_share = 0.9;   /* of |F|^2 that the worst candidates hold */
static const double local_size = 1. / 3; /* of the candidates: a larger set is no gain */
static const double local_end = 0.3;     /* of |F| on the set */
static const double falls = 0.9;         /* HELD: of the residual, in local_every sweeps */
enum { longest_pause = 16 };
static const double price_of_history = 1.5; /* a sweep with (NL6), in sweeps with (NL8) */

/* All candidates, in the order of the visits. */
static dlsi_set nlgs_all(const dls_nlgs *work, const dls_contact *problem) {
  if (work->slabs.set.slabs) return work->slabs.set;
  return (dlsi_set){.list = work->order, .count = problem->nc};
}

/* Begins momentum anew at r, which u (or v) belongs to. */
static void nlgs_start_momentum(dls_nlgs *work, const dls_contact *problem, const double *r) {
  const dlsi_set all = {.count = problem->nc}, bodies = {.count = problem->bodies.count};
  const int n = work->motions, d = problem->d;
  dlsi_momentum_start(&work->momentum, d, n ? n : d, all, n ? bodies : all, r, nlgs_kept(work));
}

/* A sum of |F_c|^2 by pieces. */
typedef struct nlgs_measures {
  const dls_nlgs *work;
  const dls_contact *problem;
  dlsi_set set;
  const double *r;
  double *F2; /* nc, NULL for none */
  int pieces;
  double sum[dlsi_most_pieces];
} nlgs_measures;

static void nlgs_measure_piece(void *data, int piece) {
  nlgs_measures *s = data;
  const dls_nlgs *work = s->work;
  const int d = s->problem->d, n = work->motions;
  const int end = dlsi_piece(s->set.count, s->pieces, piece + 1);
  double sum = 0;
  for (int k = dlsi_piece(s->set.count, s->pieces, piece); k < end; k++) {
    const int c = s->set.list ? s->set.list[k] : k;
    double F[3] = {0}, u[3] = {0};
    if (n) {
      const dlsi_pair_of_bodies of =
          dlsi_bodies_of(&s->problem->bodies, (size_t)n * (size_t)d, (size_t)c, work->v);
      dlsi_bodies_look(d, n, &of, s->problem->q + d * c, u);
    }
    (void)dlsi_contact_misfit(d, s->problem->mu[c], work->it.weights + 2 * (size_t)c, s->r + d * c,
                              n ? u : work->it.u + d * c, F);
    const double square = F[0] * F[0] + F[1] * F[1] + F[2] * F[2];
    if (s->F2) s->F2[c] = square;
    sum += square;
  }
  s->sum[piece] = sum;
}

/* Returns the sum of |F_c|^2 over a set; F2 (nc, NULL for none): each of them. */
static double nlgs_measure(const dls_nlgs *work, const dls_contact *problem, dlsi_set set,
                           const double *r, double *F2) {
  const int threads = work->settings.limits.threads;
  nlgs_measures s = {work, problem, set, r, F2, dlsi_pieces(threads, set.count), {0}};
  double sum = 0;
  dlsi_parallel(work->team, s.pieces, nlgs_measure_piece, &s);
  for (int k = 0; k < s.pieces; k++)
    sum += s.sum[k];
  return sum;
}

/* Returns 2^-k of the largest F2, the largest for which the candidates above it hold their
 * share. */
static double nlgs_threshold(const dls_contact *problem, const double *F2, double sum) {
  double bound = 0, held = 0;
  for (int c = 0; c < problem->nc; c++)
    bound = fmax(bound, F2[c]);
  while (bound > 0 && bound <= DBL_MAX && held < local_share * sum) {
    bound /= 2;
    held = 0;
    for (int c = 0; c < problem->nc; c++)
      if (F2[c] > bound) held += F2[c];
  }
  return bound;
}

/* Marks the bodies of the candidates with near = `layer`, and puts those that share them and are in
 * no layer into the next. */
static void nlgs_add_layer_of_bodies(const dls_nlgs *work, const dls_contact *problem, int layer) {
  const int *body = problem->bodies.body;
  int *mark = work->bodies.some + problem->bodies.count;
  for (int k = 0; k < 2 * problem->nc; k++)
    if (work->near[k / 2] == layer && body[k] >= 0) mark[body[k]] = 1;
  for (int k = 0; k < 2 * problem->nc; k++)
    if (!work->near[k / 2] && body[k] >= 0 && mark[body[k]]) work->near[k / 2] = layer + 1;
}

/* near := `layer` + 1 for what W couples with candidates of that layer and is in none. */
static void nlgs_add_layer(const dls_nlgs *work, const dls_contact *problem, int layer) {
  const dls_blocks *W = &problem->Wb;
  if (work->motions) nlgs_add_layer_of_bodies(work, problem, layer);
  for (int c = 0; !work->motions && c < problem->nc; c++)
    for (int k = W->p[c]; work->near[c] == layer && k < W->p[c + 1]; k++)
      if (!work->near[W->i[k]]) work->near[W->i[k]] = layer + 1;
}

/* list := the candidates with near up to `layer`, in the order of the visits; start: of the slabs,
 * if there are any, in the list. */
static dlsi_set nlgs_list(const dls_nlgs *work, const dls_contact *problem, int layer, int *list,
                          int *start) {
  const dlsi_set all = nlgs_all(work, problem);
  int count = 0, slab = 0;
  for (int k = 0; k < problem->nc; k++) {
    const int c = all.list ? all.list[k] : k;
    while (slab < all.slabs && all.start[slab] <= k)
      start[slab++] = count;
    if (work->near[c] && work->near[c] <= layer) list[count++] = c;
  }
  if (all.slabs) start[all.slabs] = count;
  return (dlsi_set){.list = list, .count = count, .slabs = all.slabs, .start = start};
}

/* Lists the bodies that have a mark. */
static dlsi_set nlgs_list_bodies(const dls_nlgs *work, const dls_contact *problem) {
  int *list = work->bodies.some, count = 0;
  for (int b = 0; b < problem->bodies.count; b++)
    if (list[problem->bodies.count + b]) list[count++] = b;
  return (dlsi_set){.list = list, .count = count};
}

/* (NL9) Sweeps where the residual is. u belongs to r. Returns 0 if that is nearly everywhere. */
static int nlgs_sweep_locally(dls_nlgs *work, const dls_contact *problem, double *r) {
  const int d = problem->d, n = work->motions;
  double *F2 = work->it.F, *const u = nlgs_kept(work);
  const double sum = nlgs_measure(work, problem, nlgs_all(work, problem), r, F2);
  const double bound = nlgs_threshold(problem, F2, sum);
  for (int c = 0; c < problem->nc; c++)
    work->near[c] = F2[c] > bound;
  for (int b = 0; n && b < problem->bodies.count; b++)
    work->bodies.some[problem->bodies.count + b] = 0;
  for (int layer = 1; layer <= local_layers + 1; layer++)
    nlgs_add_layer(work, problem, layer);
  const dlsi_set set = nlgs_list(work, problem, local_layers + 1, work->some, work->slabs.some);
  if (set.count == 0 || set.count > local_size * problem->nc) return 0;
  dlsi_set rows;
  if (n)
    rows = nlgs_list_bodies(work, problem);
  else
    rows = nlgs_list(work, problem, local_layers + 2, work->rows, work->slabs.changed);
  const double end = local_end * local_end * nlgs_measure(work, problem, set, r, NULL);
  dlsi_momentum *mo = &work->momentum;
  dlsi_momentum_start(mo, d, n ? n : d, set, rows, r, u);
  for (int k = 1; k <= local_sweeps; k++) {
    work->sweeps += (double)set.count / problem->nc;
    if (!nlgs_sweep(work, problem, set, r)) break;
    if (k % local_looks == 0 && nlgs_measure(work, problem, set, r, NULL) <= end) break;
    if (k < local_sweeps)
      (void)dlsi_momentum_step(mo, d, n ? n : d, work->it.w, work->largest, set, rows, r, u);
  }
  return 1;
}

/* (NL9), less and less often where the sets are too large. Returns 1 if r has changed. */
static int nlgs_look_locally(dls_nlgs *work, const dls_contact *problem, double *r) {
  if (work->wait > 0) {
    work->wait--;
    return 0;
  }
  const int swept = nlgs_sweep_locally(work, problem, r);
  const int longer = work->pause ? 2 * work->pause : 1;
  work->pause = swept ? 0 : longer < longest_pause ? longer : longest_pause;
  work->wait = work->pause;
  return swept;
}

/* (NL10) Returns 1 when the residual has not been halved for as many sweeps as before and 300, or,
 * below 1000 candidates without momentum, three times as many: what follows is as expensive. While
 * there are several ways, one that takes a fifth off will do, and 300 is 800, from 1000 candidates
 * on times their number across: so many sweeps a reaction takes to get through. */
static int nlgs_is_slow(dls_nlgs *work, const dls_contact *problem, double residual) {
  const int racing = work->largest == 1 && work->race.ways > 1;
  if (residual <= (racing ? racing_falls : 0.5) * work->halved) {
    work->halved = residual;
    work->since = work->sweeps;
  }
  const int patience = work->largest == 0 && problem->nc < few_candidates ? last_patience : 1;
  const double across = pow(fmax(1, (double)problem->nc / few_candidates), 1. / problem->d);
  const double first = racing ? slow_race * across : slow_first;
  return work->sweeps - work->since >= patience * (first + work->since);
}

/* (NL8) r := the start of the next sweep k, with local sweeps before it now and then. Returns 0 if
 * a stage of auto has no smaller momentum left to try. */
static int nlgs_push(dls_nlgs *work, const dls_contact *problem, int k, double residual,
                     double *r) {
  const int slow = nlgs_is_slow(work, problem, residual), n = work->motions;
  if (slow && work->largest == 0 && work->stage) return 0;
  if (slow && work->largest > 0) {
    work->largest = work->largest > slow_momentum ? slow_momentum : 0;
    work->now = problem->nc > few_candidates ? HELD : FREE;
    work->since = work->sweeps;
    nlgs_return(work, problem, work->it.best, r);
    nlgs_start_momentum(work, problem, r);
    return 1;
  }
  const int at = k - 1; /* the sweep that `residual` belongs to */
  if (!problem->W.a && at >= local_first && at % local_every == 0) {
    const int held = work->now == HELD && !(residual <= falls * work->looked);
    work->looked = residual;
    if (nlgs_look_locally(work, problem, r) || held) {
      nlgs_start_momentum(work, problem, r);
      return 1;
    }
  }
  const dlsi_set all = {.count = problem->nc}, bodies = {.count = problem->bodies.count};
  (void)dlsi_momentum_step(&work->momentum, problem->d, n ? n : problem->d, work->it.w,
                           work->largest, nlgs_all(work, problem), n ? bodies : all, r,
                           nlgs_kept(work));
  return 1;
}

/* ---- several ways ---------------------------------------------------------------------------- */

/* (NL12) Lists the ways, the first of which is taken. */
static void nlgs_list_ways(dls_nlgs *work, const dls_contact *problem) {
  const int blocks = !problem->W.a, plane = problem->d == 2, many = problem->nc > few_candidates;
  const int turns = blocks && nlgs_may_turn(work) && (plane || many);
  int ways = 0;
  if (turns && plane) work->way[ways++] = ANDERSON;
  work->way[ways++] = FREE;
  if (turns && !plane) work->way[ways++] = ANDERSON;
  if (blocks && many) work->way[ways++] = HELD;
  dlsi_race_start(&work->race, ways);
  work->now = work->way[0];
}

/* Begins the way now, from r, which u (or v) belongs to. */
static void nlgs_start_way(dls_nlgs *work, const dls_contact *problem, const double *r) {
  if (work->now != ANDERSON) {
    nlgs_start_momentum(work, problem, r);
    return;
  }
  dlsi_anderson_clear(&work->history);
  memcpy(work->x, r, (size_t)problem->d * (size_t)problem->nc * sizeof *r);
}

/* (NL12) after so many sweeps that have led to r, of this residual. Returns 1 if another way
 * begins, from the best r where this one is a tenth worse. */
static int nlgs_change_way(dls_nlgs *work, const dls_contact *problem, double residual, int sweeps,
                           double *r) {
  if (work->largest < 1) return 0; /* (NL10) has ended the race */
  const double price = work->now == ANDERSON ? price_of_history : 1;
  const int turn = dlsi_race_advance(&work->race, residual, price * sweeps);
  nlgs_way next = turn ? work->way[work->race.now] : work->now;
  if (next == ANDERSON && nlgs_is_slow(work, problem, residual)) next = FREE; /* (NL10) is next */
  if (next == work->now) return 0;
  work->now = next;
  if (residual > nlgs_growth * work->race.least) nlgs_return(work, problem, work->it.best, r);
  nlgs_start_way(work, problem, r);
  return 1;
}

/* ---- the solve ------------------------------------------------------------------------------- */

/* Sweeps from r until the certificate holds or there is a reason to stop, which is returned; it.u
 * belongs to it.best then. *iterations: sweeps done. */
static dls_status nlgs_iterate(dls_nlgs *work, const dls_contact *problem, double *r,
                               int *iterations) {
  const dls_limits *limits = &work->settings.limits;
  dlsi_iterate *it = &work->it;
  const int most = dlsi_most_iterations(limits, most_sweeps);
  const int pushed = work->settings.acceleration == DLS_ACCELERATION_MOMENTUM;
  const dlsi_set all = nlgs_all(work, problem);
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const double scale = 1 / dlsi_norm2(problem->q, m);
  if (dlsi_iterate_start(it, problem, r)) return DLS_OK;
  dls_certificate now = it->certificate;
  if (nlgs_project_start(problem, r)) now = dlsi_iterate_offer(it, problem, r);
  if (dls_certificate_holds(&now, it->tol)) return DLS_OK;
  nlgs_resume(work, problem, r);
  work->now = nlgs_has_history(&work->settings) ? ANDERSON : FREE;
  if (pushed) {
    work->largest = 1;
    work->halved = work->looked = INFINITY;
    work->since = work->sweeps = 0;
    work->pause = work->wait = 0;
    nlgs_list_ways(work, problem);
  }
  if (pushed || work->now == ANDERSON) nlgs_start_way(work, problem, r);
  const int often = problem->W.a || problem->nc < few_candidates;
  double accepted = now.residual;
  int fresh = 1, changed = 0; /* fresh: u carries no rounding of earlier sweeps */
  dls_status reason = DLS_MAX_ITERATIONS;
  for (int k = 1; k <= most && reason == DLS_MAX_ITERATIONS; k++) {
    const int looks = often || work->now == ANDERSON ? 1 : seldom;
    if (work->now == ANDERSON && changed) {
      nlgs_accelerate(work, problem, now.residual, scale, &accepted, r);
      fresh = 0;
    }
    if (pushed && work->now != ANDERSON && changed) { /* (NL8), (NL9) */
      if (!nlgs_push(work, problem, k, now.residual, r)) {
        reason = DLS_STALLED;
        break;
      }
      fresh = 0;
    }
    changed = nlgs_sweep(work, problem, all, r);
    work->sweeps++;
    *iterations = k;
    if (changed && k % looks && k < most) {
      fresh = 0;
      continue;
    }
    nlgs_estimate(work, problem, r, scale, &now);
    const int was_fresh = fresh;
    fresh = !changed || dlsi_certificate_meets(&now, it->tol) || k % refresh_every == 0;
    if (fresh) now = dlsi_iterate_measure(it, problem, r); /* (NL5) */
    if (dlsi_iterate_keep(it, problem, r, &now)) return DLS_OK;
    if (fresh) nlgs_resume(work, problem, r);
    const dls_status stop = dlsi_iterate_tell(it, "nlgs", k, most, now.residual, r);
    if (stop)
      reason = stop;
    else if ((!changed && was_fresh) || dlsi_iterate_is_lost(now.residual))
      reason = DLS_STALLED;
    else if (pushed && nlgs_change_way(work, problem, now.residual, looks, r)) {
      accepted = INFINITY;
      changed = fresh = 0;
    }
  }
  return dlsi_iterate_settle(it, problem, reason);
}

static const double unsymmetric = 1e-9; /* of the Schur complement, which margins of 1 % outweigh */

/* Returns 1 if a candidate with this W_cc (d x d) has one solution by itself whatever q is: W_cc
 * symmetric but for rounding, positive definite, and mu below the bound (DG4) of
 * src/front/diagnose.c by a margin that rounding does not use up. */
static int has_one_solution(int d, const double *W, double mu) {
  if (d == 1) return W[0] > 0;
  double a[2] = {W[d], d == 3 ? W[6] : 0}, x[2], most; /* W_nt; W_nt W_tt^-1; largest eigenvalue */
  double skew = fabs(W[1] - a[0]);
  if (d == 3) skew = fmax(skew, fmax(fabs(W[2] - a[1]), fabs(W[5] - W[7])));
  if (d == 2) {
    most = W[3];
    x[0] = a[0] / most;
    x[1] = 0;
  } else {
    const double det = W[4] * W[8] - W[7] * W[7], half = (W[4] + W[8]) / 2;
    if (!(det > 0 && half > 0)) return 0;
    most = half + hypot((W[4] - W[8]) / 2, W[7]);
    x[0] = (W[8] * a[0] - W[7] * a[1]) / det;
    x[1] = (W[4] * a[1] - W[7] * a[0]) / det;
  }
  const double s = W[0] - a[0] * x[0] - a[1] * x[1], h = hypot(x[0], x[1]);
  if (!(most > 0 && s > 0 && skew <= unsymmetric * s)) return 0;
  const double k = sqrt(s / most);
  return mu < 0.99 * (h < k ? h + k * (k / h) : 2 * k);
}

int dlsi_may_be_ambiguous(const dls_contact *problem) {
  double W[9];
  for (int c = 0; c < problem->nc; c++) {
    dlsi_contact_diagonal(problem, c, W);
    if (!has_one_solution(problem->d, W, problem->mu[c])) return 1;
  }
  return 0;
}

int dlsi_count_ambiguous(const dls_contact *problem, const double *r, const double *u,
                         double *other) {
  const int d = problem->d;
  int ambiguous = 0;
  for (int c = 0; c < problem->nc; c++) {
    const double *rc = r + (size_t)d * (size_t)c, *uc = u + (size_t)d * (size_t)c;
    double W[9], p[3], s[3];
    dlsi_contact_diagonal(problem, c, W);
    for (int i = 0; other && i < d; i++)
      other[d * c + i] = rc[i];
    if (has_one_solution(d, W, problem->mu[c])) continue;
    for (int i = 0; i < d; i++) {
      p[i] = uc[i];
      for (int j = 0; j < d; j++)
        p[i] -= W[i + d * j] * rc[j];
    }
    if (dlsi_local_count(d, W, p, problem->mu[c]) < 2) continue;
    if (dls_nlgs_local(d, W, p, problem->mu[c], s, NULL) == DLS_LOCAL_NONE) continue;
    ambiguous++;
    for (int i = 0; other && i < d; i++)
      other[d * c + i] = s[i];
  }
  return ambiguous;
}

dls_status dlsi_nlgs_run(dls_nlgs *work, const dls_contact *problem, const int *order,
                         const double *E, double *r, double *u, dls_info *info) {
  const dls_limits *limits = &work->settings.limits;
  const size_t d = (size_t)problem->d;
  for (int c = 0; c < problem->nc; c++) {
    double W[9];
    dlsi_contact_diagonal(problem, c, W);
    for (size_t i = 0; E && i < d; i++)
      W[(d + 1) * i] += E[c];
    if (d == 1)
      work->block_1d[c] = W[0];
    else if (d == 2)
      dlsi_block_2d_set(&work->block_2d[c], W, problem->mu[c]);
    else
      dlsi_block_3d_set(&work->block_3d[c], W, problem->mu[c]);
  }
  work->order = order;
  dlsi_iterate_begin(&work->it, problem, E, limits->tol, work->stage || limits->warm_start, r, r);
  dls_info outcome = {.method = DLS_NLGS};
  const dls_status status = nlgs_iterate(work, problem, r, &outcome.iterations);
  return dlsi_iterate_end(&work->it, problem, status, &outcome, r, u, info);
}

/* Makes room for the motions of bodies and what momentum needs of them. DLS_E_MEMORY. */
static dls_status nlgs_take_bodies(dls_nlgs *work, const dls_contact *problem, dls_error *error) {
  nlgs_bodies *of = &work->bodies;
  const size_t count = (size_t)problem->bodies.count, all = (size_t)problem->bodies.n * count;
  const int pushed = work->settings.acceleration == DLS_ACCELERATION_MOMENTUM;
  work->motions = problem->bodies.n;
  work->v = problem->bodies.work;
  if (!pushed) return DLS_OK;
  const size_t columns = nlgs_may_turn(work) ? (size_t)work->history.window + 1 : 0;
  double *moved = dlsi_make_room(of->moved, &of->moved_room, (2 + columns) * all, sizeof *moved);
  if (!moved) return dlsi_no_memory(error);
  of->moved = moved;
  int *some = dlsi_make_room(of->some, &of->some_room, 2 * count, sizeof *some);
  if (!some) return dlsi_no_memory(error);
  of->some = some;
  work->momentum.u = moved;
  work->momentum.pu = moved + all;
  if (columns) {
    work->history.of_u = all;
    work->history.u = moved + 2 * all;
    work->history.DU = moved + 3 * all;
  }
  return DLS_OK;
}

/* Prepares the workspace for the storage and the threads. Bodies keep their factors (NL11), but
 * for (NL6), which combines u. DLS_E_MEMORY, DLS_E_SIZE. */
static dls_status nlgs_prepare(dls_nlgs *work, const dls_contact **problem, const int *order,
                               dls_error *error) {
  work->motions = 0;
  work->momentum.threads = work->settings.limits.threads;
  work->momentum.u = work->carved[0];
  work->momentum.pu = work->carved[1];
  work->history.u = work->carved[2];
  work->history.DU = work->carved[3];
  work->history.of_u = (size_t)work->d * (size_t)(*problem)->nc;
  work->slabs.set.slabs = 0;
  dls_status status = nlgs_has_history(&work->settings)
                          ? dlsi_form_blocks(&work->formed, problem, error)
                          : dlsi_lend(&work->formed, problem, error);
  if (!status && dlsi_is_factored(*problem)) status = nlgs_take_bodies(work, *problem, error);
  const int threads = work->settings.limits.threads > 1 && (*problem)->nc >= few_candidates;
  if (!status && threads && !order && !(*problem)->W.a)
    status = dlsi_slabs_set(&work->slabs, *problem, error);
  return status;
}

/* The arguments of dlsi_nlgs_run, for a team. */
typedef struct nlgs_run {
  dls_nlgs *work;
  const dls_contact *problem;
  const int *order;
  double *r, *u;
  dls_info *info;
  dls_status status;
} nlgs_run;

static void nlgs_run_in_team(dlsi_team *team, void *data) {
  nlgs_run *run = data;
  run->work->team = run->work->momentum.team = team;
  run->status = dlsi_nlgs_run(run->work, run->problem, run->order, NULL, run->r, run->u, run->info);
  run->work->team = run->work->momentum.team = NULL;
}

static dls_status nlgs_solve(void *workspace, const dls_contact *problem, double *r, double *u,
                             dls_info *info, dls_error *error) {
  dls_nlgs *work = workspace;
  double *const key[] = {work->it.u, work->it.a, work->it.F};
  /* momentum is for large problems, whose neighbours stand side by side as they are numbered */
  const int *order = work->stage && work->stage != 3 ? work->own_order : NULL;
  dls_status status = nlgs_prepare(work, &problem, order, error);
  if (status) return status;
  if (order) dlsi_order_candidates(problem, key, work->scratch, work->own_order);
  for (int c = 0, e = problem->nc - 1; work->stage == 2 && c < e; c++, e--) {
    const int last = work->own_order[e];
    work->own_order[e] = work->own_order[c];
    work->own_order[c] = last;
  }
  nlgs_run run = {work, problem, order, r, u, info, DLS_OK};
  const int large =
      work->slabs.set.slabs || (problem->W.a && problem->d * problem->nc >= large_panel);
  dlsi_team_run(large ? work->settings.limits.threads : 1, nlgs_run_in_team, &run);
  status = run.status;
  if (info && !work->stage) info->ambiguous = dlsi_count_ambiguous(problem, r, work->it.u, NULL);
  return status;
}

dls_status dls_nlgs_solve(dls_nlgs *workspace, const dls_contact *problem, double *r, double *u,
                          dls_info *info, dls_error *error) {
  DLSI_DOOR;
  dls_status status = dlsi_iterate_enter(workspace ? &workspace->it : NULL, problem, r, u, error);
  if (status) return dlsi_at(__func__, status, error);
  if (dlsi_is_empty(problem, &workspace->settings.limits, DLS_NLGS, "nlgs", info))
    return dlsi_leave(&workspace->it.busy, DLS_OK);
  status = nlgs_solve(workspace, problem, r, u, info, error);
  status = dlsi_iterate_leave(&workspace->it, "nlgs", status, r);
  return dlsi_at(__func__, status, error);
}

/* ---- in the table of methods ----------------------------------------------------------------- */

static dls_status nlgs_create_by(void **out, int d, int nc, const dlsi_options *options,
                                 dls_error *error) {
  dls_nlgs_settings s;
  dls_nlgs_settings_init(&s);
  s.limits = options->limits;
  s.acceleration = (dls_acceleration)options->acceleration;
  static const dls_acceleration of_stage[] = {[1] = DLS_ACCELERATION_ANDERSON,
                                              [2] = DLS_ACCELERATION_NONE, /* in reverse order */
                                              [3] = DLS_ACCELERATION_MOMENTUM};
  if (options->stage) s.acceleration = of_stage[options->stage];
  return nlgs_create(out, d, nc, options->stage, &s, error);
}

static void nlgs_destroy(void *work) {
  dls_nlgs_destroy(work);
}

static void nlgs_set_limits(void *work, const dls_limits *limits) {
  dlsi_set_limits(&((dls_nlgs *)work)->settings.limits, limits);
}

const dlsi_method dlsi_nlgs_method = {
    DLS_NLGS,
    "nlgs",
    "sweeps of Gauss-Seidel: any W, 1e-4 to 1e-8; accelerated, more",
    nlgs_create_by,
    nlgs_solve,
    nlgs_destroy,
    nlgs_set_limits,
    NULL,
    NULL,
    1};
