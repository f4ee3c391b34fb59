/*
 * nlgs.c: projected Gauss-Seidel on the reactions (nonlinear Gauss-Seidel), [Jean 1988] 3.3.
 *
 *   u = W r + q,   0 <= u_n _|_ r_n >= 0,   |r_t| <= mu r_n,   u_t opposed to r_t where it slips
 *
 * u = W r + q is kept up to date by columns. One sweep, for c = 0 .. nc-1:
 *
 *   (G1)  p  = u_c - W_cc r_c                what the others leave to candidate c
 *   (G2)  s  = the solution of candidate c alone, u_c = W_cc s + p            (local.c)
 *   (G3)  s := P_Cmu( r_c + omega (s - r_c) )           only if omega is not 1
 *   (G4)  u += W(:,c) (s - r_c),   r_c := s             only if s is not r_c
 *
 * (G0) A candidate with r_c = 0 and u_n >= 0 stays free: that is (G1)-(G4) for it. The projection in
 * (G3) is the orthogonal one on the cone; for omega <= 1 it changes nothing, the cone being convex.
 * Under omega < 1 a candidate that has left the obstacle is put to exactly 0 once what is left of
 * r_c no longer moves u.
 *
 * Stop: after each sweep the certificate's residual is estimated from the u at hand, O(nc). (G5) When
 * it meets the target, when a sweep changes nothing, and every 50 sweeps, u is recomputed from the
 * user's W and q and the certificate is taken from that; the target is max(tol, 4 floor). A sweep
 * from a fresh u that changes nothing and is not solved can never change anything: DLS_STALLED. The
 * iterate with the smallest residual is kept and is what a call that ends early returns.
 *
 * Accelerated, the sweep g is a fixed-point map x -> r = g(x), and between two sweeps
 *
 *   (G6)  f = D (r - x), D = diag(w_c) 2^k, 2^k |q| about 1;  x := r - DG gamma, u := u - DU gamma by Anderson
 *         (anderson.c), then each x_c := P_Cmu(x_c) with u by columns
 *   (G7)  instead, if the residual of r exceeds 1.1 times that of the g before: back to that g, its u
 *         afresh, history forgotten; the plain sweep that follows is always taken
 *
 * Whatever x is, the certificate of r = g(x) is what is looked at, kept as the best and returned. The
 * rounding of u is not damped by sweeps, and (G6) amplifies it; with u afresh in (G7) and a bound on
 * gamma, estimate and certificate stay within 1 % on the FCLIB files but for BoxesStack1 (1 in 25 of
 * its refreshes finds a factor of 10). Without the two, a call on the cycle of tests/test_nlgs.c returned
 * an r of residual 0.7 for which it had estimated 4e-8.
 *
 * W dense: u receives the changes of four candidates in one pass over their columns (panel.c); whoever
 * is visited before that looks at its own rows with the outstanding ones added. Every u_i still receives
 * them in the order of the candidates: the same bits as one by one.
 *
 * Source: [Jean 1988] 3.3 names Gauss-Seidel on (3.3)5-6; the form with exact local solutions is Jourdan,
 * Alart and Jean 1998. Deviation: u is updated by columns, where the usual code recomputes row c of
 * W r: the same arithmetic, but candidates that do not change cost nothing, and the residual is free.
 * (G6) with two sweeps is what [Chabrand 1998] 4.2 names (Aitken, after Raous, Barbosa and Latil).
 *
 * Cost of a sweep: the columns of W of the candidates that changed, once; besides O(nc). Accelerated:
 * (3 window + 10) m operations or so, and the columns of the candidates that (G6) projects.
 * What can fail: nothing guarantees convergence with friction. It can cycle for ever (W SPD and mu = 1
 * suffice, tests/test_nlgs.c), and needs many sweeps for ill-conditioned W. A candidate without a
 * local solution (W_cc indefinite, or wedged by a large mu) gets the least bad point; the certificate
 * then does not hold.
 */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "vi_internal.h"

enum { most_sweeps = 10000, refresh_every = 50, most_window = 100 };

/* (G7) how much worse than the one before an accelerated iterate may be; 2 takes 19335 sweeps where 1.1
 * takes 11758 (Anderson, 1e-8, nine of the files of README.md together) */
static const double growth = 1.1;

struct dls_nlgs {
  dls_nlgs_settings settings;
  int d, nc;
  double tol; /* of this run, and what comes with it */
  dlsi_sweeps sweeps;
  dlsi_block_2d *block_2d; /* nc  the W_cc (+ E_c), NULL for d = 3 */
  dlsi_block_3d *block_3d; /* nc  NULL for d = 2 */
  double *w;               /* nc      weights of the certificate */
  double *u;               /* m       W r + q */
  double *a;               /* m       |W| |r|, for the floor */
  double *F;               /* m       */
  double *best;            /* m       the r with the smallest residual so far */
  double *x;               /* m       the r that the sweep started from, if accelerated */
  dlsi_anderson history;
};

void dls_nlgs_settings_init(dls_nlgs_settings *settings) {
  if (!settings) return;
  *settings = (dls_nlgs_settings){.size = sizeof *settings, .relaxation = 1, .window = 10};
  dlsi_limits_init(&settings->limits);
}

static dls_status check_settings(const dls_nlgs_settings *s, dls_error *error) {
  const dlsi_setting own[] = {{"relaxation", s->relaxation, 0, 2, 1},
                              {"acceleration", s->acceleration, 0, DLS_ACCELERATION_ANDERSON, 0},
                              {"window", s->window, 1, most_window, 0}};
  return dlsi_check_settings(&s->limits, s->size, sizeof *s, 3, own, error);
}

/* the workspace and all its arrays, in one piece */
static dls_nlgs *carve(dlsi_arena *arena, int d, int nc, const dls_nlgs_settings *settings) {
  const size_t D = (size_t)d, n = (size_t)nc, m = D * n;
  dls_nlgs *s = dlsi_take(arena, 1, sizeof *s);
  dlsi_block_2d *block_2d = d == 2 ? dlsi_take(arena, n, sizeof *block_2d) : NULL;
  dlsi_block_3d *block_3d = d == 3 ? dlsi_take(arena, n, sizeof *block_3d) : NULL;
  double *w = dlsi_take(arena, n, sizeof *w), *u = dlsi_take(arena, m, sizeof *u);
  double *a = dlsi_take(arena, m, sizeof *a), *F = dlsi_take(arena, m, sizeof *F);
  double *best = dlsi_take(arena, m, sizeof *best);
  double *x = NULL;
  dlsi_anderson history = {0};
  if (settings->acceleration != DLS_ACCELERATION_NONE) {
    x = dlsi_take(arena, m, sizeof *x);
    dlsi_anderson_carve(&history, arena, m,
                        settings->acceleration == DLS_ACCELERATION_AITKEN ? 1 : settings->window,
                        1);
  }
  if (arena->failed || !arena->base) return NULL;
  const dls_nlgs filled = {.settings = *settings,
                           .d = d,
                           .nc = nc,
                           .block_2d = block_2d,
                           .block_3d = block_3d,
                           .w = w,
                           .u = u,
                           .a = a,
                           .F = F,
                           .best = best,
                           .x = x,
                           .history = history};
  *s = filled;
  return s;
}

dls_status dls_nlgs_create(dls_nlgs **out, int d, int nc, const dls_nlgs_settings *settings,
                           dls_error *error) {
  if (!out) return dlsi_at(__func__, dlsi_is_null(error, "out"), error);
  *out = NULL;
  dls_status status = dlsi_check_sizes(d, nc, error);
  dls_nlgs_settings defaults;
  dls_nlgs_settings_init(&defaults);
  if (!settings) settings = &defaults;
  if (!status) status = check_settings(settings, error);
  if (status) return dlsi_at(__func__, status, error);

  dlsi_arena arena = {0};
  (void)carve(&arena, d, nc, settings);
  if (arena.failed)
    return dlsi_at(__func__, dlsi_fail(error, DLS_E_SIZE, "nc", -1, nc, "is too large"), error);
  arena.size = arena.used;
  arena.used = 0;
  arena.base = dlsi_alloc(1, arena.size);
  if (!arena.base) return dlsi_at(__func__, dlsi_no_memory(error), error);
  *out = carve(&arena, d, nc, settings);
  return DLS_OK;
}

void dls_nlgs_destroy(dls_nlgs *workspace) {
  free(workspace); /* first in its one piece */
}

/* ---- the iteration --------------------------------------------------------------------------- */

/* W dense: changes that u is still to receive, all rows of it in one go. */
enum { batch_size = 4 };

typedef struct batch {
  int far; /* W leaves the cache from one sweep to the next */
  int count, c[batch_size];
  double dr[3 * batch_size];
} batch;

static batch new_batch(const dls_contact *problem) {
  const size_t cached = (size_t)1 << 17; /* numbers: 1 MB */
  return (batch){.far = (size_t)problem->W.ld * (size_t)problem->W.cols > cached};
}

/* v := u_c with the changes of the batch; b is NULL for W by blocks */
static inline void look(int d, const dls_contact *problem, const batch *b, int c, const double *u,
                        double *v) {
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

/* Ahead of the pass over the columns of c, while its local solution is computed: the first lines of each
 * column, where the processor does not look ahead itself. */
static inline void fetch(int d, const dls_contact *problem, int c) {
  enum { lines = 6, line = 8 };
  const size_t ld = (size_t)problem->W.ld;
  const double *w = problem->W.a + (size_t)d * (size_t)c * ld;
  for (size_t i = 0; i < lines * line && i < ld; i += line)
    for (size_t j = 0; j < (size_t)d; j++)
      __builtin_prefetch(w + i + j * ld);
}

/* u_c += E_c dr */
static inline void add_springs(const dls_nlgs *work, int d, int c, const double *dr) {
  double *uc = work->u + (size_t)d * (size_t)c;
  for (int i = 0; work->sweeps.E && i < d; i++)
    uc[i] += work->sweeps.E[c] * dr[i];
}

static void flush(const dls_nlgs *work, const dls_contact *problem, batch *b) {
  dlsi_contact_add_panel(problem, b->count, b->c, b->dr, work->u);
  for (int k = 0; k < b->count; k++)
    add_springs(work, problem->d, b->c[k], b->dr + problem->d * k);
  b->count = 0;
}

/* (G4) for one candidate; in the batch, or at once (b NULL, W by blocks) */
static inline void change(const dls_nlgs *work, const dls_contact *problem, int c, const double *dr,
                          batch *b) {
  const size_t d = (size_t)problem->d;
  if (b) {
    memcpy(b->dr + d * (size_t)b->count, dr, d * sizeof *dr);
    b->c[b->count++] = c;
    if (b->count == batch_size || work->sweeps.E)
      flush(work, problem, b); /* E_c comes after W_cc */
    return;
  }
  dlsi_contact_add_columns(problem, c, dr, work->u);
  add_springs(work, problem->d, c, dr);
}

/* (G0)-(G4) for all candidates; returns how many changed. */
static int sweep_2d(const dls_nlgs *work, const dls_contact *problem, batch *b, double *r) {
  const double omega = work->settings.relaxation;
  int changed = 0;
  for (int k = 0; k < problem->nc; k++) {
    const int c = work->sweeps.order ? work->sweeps.order[k] : k;
    double *rc = r + 2 * (size_t)c;
    const dlsi_block_2d *block = work->block_2d + c;
    const double *W = block->W;
    double uc[2];
    look(2, problem, b, c, work->u, uc);
    if (rc[0] == 0 && uc[0] >= 0) continue; /* (G0) */
    if (b && b->far) fetch(2, problem, c);
    const double p[2] = {uc[0] - (W[0] * rc[0] + W[2] * rc[1]),
                         uc[1] - (W[1] * rc[0] + W[3] * rc[1])}; /* (G1) */
    double s[2];
    const dls_local_state state = dlsi_local_2d(block, p, s); /* (G2) */
    if (omega != 1) {                                         /* (G3) */
      const double v[2] = {rc[0] + omega * (s[0] - rc[0]), rc[1] + omega * (s[1] - rc[1])};
      if (state != DLS_LOCAL_FREE || work->w[c] * v[0] > DBL_EPSILON * p[0])
        dlsi_project_cone(2, block->mu, v, s);
    }
    const double dr[2] = {s[0] - rc[0], s[1] - rc[1]};
    if (dr[0] == 0 && dr[1] == 0) continue;
    change(work, problem, c, dr, b); /* (G4) */
    rc[0] = s[0];
    rc[1] = s[1];
    changed++;
  }
  return changed;
}

static int sweep_3d(const dls_nlgs *work, const dls_contact *problem, batch *b, double *r) {
  const double omega = work->settings.relaxation;
  int changed = 0;
  for (int k = 0; k < problem->nc; k++) {
    const int c = work->sweeps.order ? work->sweeps.order[k] : k;
    double *rc = r + 3 * (size_t)c;
    const dlsi_block_3d *block = work->block_3d + c;
    const double *W = block->W;
    double uc[3];
    look(3, problem, b, c, work->u, uc);
    if (rc[0] == 0 && uc[0] >= 0) continue; /* (G0) */
    if (b && b->far) fetch(3, problem, c);
    double p[3], s[3], v[3], dr[3];
    for (int i = 0; i < 3; i++)
      p[i] = uc[i] - (W[i] * rc[0] + W[i + 3] * rc[1] + W[i + 6] * rc[2]); /* (G1) */
    const double rt2 = rc[1] * rc[1] + rc[2] * rc[2];
    const double guess = -(uc[1] * rc[1] + uc[2] * rc[2]) / rt2;     /* u_t = -l r_t; NaN: none */
    const dls_local_state state = dlsi_local_3d(block, p, guess, s); /* (G2) */
    if (omega != 1) {                                                /* (G3) */
      for (int i = 0; i < 3; i++)
        v[i] = rc[i] + omega * (s[i] - rc[i]);
      if (state != DLS_LOCAL_FREE || work->w[c] * v[0] > DBL_EPSILON * p[0])
        dlsi_project_cone(3, block->mu, v, s);
    }
    for (int i = 0; i < 3; i++)
      dr[i] = s[i] - rc[i];
    if (dr[0] == 0 && dr[1] == 0 && dr[2] == 0) continue;
    change(work, problem, c, dr, b); /* (G4) */
    for (int i = 0; i < 3; i++)
      rc[i] = s[i];
    changed++;
  }
  return changed;
}

/* One sweep; returns how many candidates changed. */
static int sweep(const dls_nlgs *work, const dls_contact *problem, double *r) {
  batch dense = new_batch(problem), *b = problem->Wb.x ? NULL : &dense;
  const int changed = (problem->d == 2 ? sweep_2d : sweep_3d)(work, problem, b, r);
  if (b) flush(work, problem, b);
  return changed;
}

/* sum_c |F_c|^2 / |q|^2, scale = 1 / |q| */
static double squares_2d(const dls_nlgs *work, const dls_contact *problem, const double *r,
                         double scale) {
  double sum = 0;
  for (int c = 0; c < problem->nc; c++) {
    const double *rc = r + 2 * (size_t)c, *uc = work->u + 2 * (size_t)c;
    if (rc[0] == 0 && uc[0] >= 0) continue; /* F_c = 0 */
    double F[2];
    dlsi_contact_residual(2, problem->mu[c], work->w[c], rc, uc, F);
    for (int i = 0; i < 2; i++)
      sum += (F[i] * scale) * (F[i] * scale);
  }
  return sum;
}

/* The same, several candidates at once: their roots and divisions take as long as those of one. */
DLSI_CLONES static double squares_3d(const dls_nlgs *work, const dls_contact *problem,
                                     const double *r, double scale) {
  enum { lanes = 16 };
  double sum = 0;
  for (int first = 0; first < problem->nc; first += lanes) {
    const int count = problem->nc - first < lanes ? problem->nc - first : lanes;
    double v[3][lanes] = {{0}}, u[3][lanes] = {{0}}, mu[lanes] = {0}, F2[lanes];
    int moves = 0;
    for (int k = 0; k < count; k++) {
      const int c = first + k;
      const double *rc = r + 3 * (size_t)c, *uc = work->u + 3 * (size_t)c;
      moves |= !(rc[0] == 0 && uc[0] >= 0);
      mu[k] = problem->mu[c];
      for (int i = 0; i < 3; i++) {
        u[i][k] = scale * uc[i];
        v[i][k] = scale * work->w[c] * rc[i];
      }
    }
    if (!moves) continue;
    /* dlsi_contact_residual, all its branches; where t = 0 and `part` is NaN, one of the first two holds */
    for (int k = 0; k < lanes; k++) {
      const double n = v[0][k] - u[0][k] - mu[k] * sqrt(u[1][k] * u[1][k] + u[2][k] * u[2][k]);
      const double x = v[1][k] - u[1][k], y = v[2][k] - u[2][k], t = sqrt(x * x + y * y);
      const double on = (n + mu[k] * t) / (1 + mu[k] * mu[k]), part = mu[k] * on / t;
      const int inside = t <= mu[k] * n, polar = mu[k] * t <= -n;
      const double p = inside ? n : polar ? 0 : on, f = inside ? 1 : polar ? 0 : part;
      const double F[3] = {v[0][k] - p, v[1][k] - f * x, v[2][k] - f * y};
      F2[k] = F[0] * F[0] + F[1] * F[1] + F[2] * F[2];
    }
    for (int k = 0; k < count; k++)
      sum += F2[k];
  }
  return sum;
}

/* The certificate's residual from the u at hand. */
static double estimate(const dls_nlgs *work, const dls_contact *problem, const double *r,
                       double scale) {
  return sqrt((problem->d == 2 ? squares_2d : squares_3d)(work, problem, r, scale));
}

/* (G5) u := W r + q afresh, and the certificate */
static dls_certificate measure(const dls_nlgs *work, const dls_contact *problem, const double *r) {
  dls_certificate certificate;
  dlsi_multiply(problem, NULL, work->sweeps.E, r, work->u, work->a);
  dlsi_contact_measure(problem, r, work->u, work->a, work->w, work->F, &certificate);
  return certificate;
}

/* What sweeps go on with after a measure(): u to the bits that belong to their order, not to the numbering */
static void resume(const dls_nlgs *work, const dls_contact *problem, const double *r) {
  if (work->sweeps.order)
    dlsi_multiply(problem, work->sweeps.order, work->sweeps.E, r, work->u, NULL);
}

/* A warm start put on the cone, so that r_n = 0 means r_c = 0 (G0); cold starts are. 1 if it was not. */
static int project_start(const dls_contact *problem, double *r) {
  const size_t d = (size_t)problem->d;
  int outside = 0;
  for (int c = 0; c < problem->nc; c++) {
    double *rc = r + d * (size_t)c, v[3];
    memcpy(v, rc, d * sizeof *v);
    outside |= dlsi_project_cone(problem->d, problem->mu[c], v, rc) != DLS_STICK;
  }
  return outside;
}

/* dr := what r_c lacks to be on its cone; 0 if that is nothing but rounding, as it is for most of
 * those that slip */
static inline int lack(int d, double mu, const double *rc, double *dr) {
  double p[3], size = 0, moved = 0;
  if (dlsi_project_cone(d, mu, rc, p) == DLS_STICK) return 0;
  for (int i = 0; i < d; i++) {
    dr[i] = p[i] - rc[i];
    size += fabs(rc[i]);
    moved += fabs(dr[i]);
  }
  return !(moved <= 8 * DBL_EPSILON * size);
}

/* Every r_c back on its cone, u by columns. */
static void repair(const dls_nlgs *work, const dls_contact *problem, double *r) {
  const int d = problem->d;
  batch dense = new_batch(problem), *b = problem->Wb.x ? NULL : &dense;
  for (int k = 0; k < problem->nc; k++) {
    const int c = work->sweeps.order ? work->sweeps.order[k] : k;
    double *rc = r + (size_t)d * (size_t)c, dr[3] = {0};
    if (!(d == 2 ? lack(2, problem->mu[c], rc, dr) : lack(3, problem->mu[c], rc, dr))) continue;
    change(work, problem, c, dr, b);
    for (int i = 0; i < d; i++)
      rc[i] += dr[i];
  }
  if (b) flush(work, problem, b);
}

/* The power of two next to x > 0, by which f is scaled without rounding: the last digit of |q| hangs on the
 * numbering of the candidates. */
static double power_of_two(double x) {
  int e;
  (void)frexp(x, &e);
  return ldexp(1, e);
}

/* (G6) r := where the next sweep starts; r = g(x) has the estimated residual `residual`, the g of the
 * sweep before it *accepted. scale = 1 / |q|. */
static void accelerate(dls_nlgs *work, const dls_contact *problem, double residual, double scale,
                       double *accepted, double *r) {
  dlsi_anderson *history = &work->history;
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  if (history->columns && !(residual <= growth * *accepted)) { /* (G7) */
    memcpy(r, history->g, m * sizeof *r);
    dlsi_multiply(problem, work->sweeps.order, work->sweeps.E, r, work->u, NULL);
    dlsi_anderson_clear(history);
  } else {
    *accepted = residual;
    const double unit = power_of_two(scale);
    double *f = work->F; /* in the order of the visits, as all sums of this */
    for (size_t k = 0; k < m / d; k++) {
      const size_t c = work->sweeps.order ? (size_t)work->sweeps.order[k] : k;
      for (size_t i = d * c; i < d * (c + 1); i++)
        *f++ = unit * work->w[c] * (r[i] - work->x[i]);
    }
    if (dlsi_anderson_step(history, (int)m, work->F, r, work->u)) repair(work, problem, r);
  }
  memcpy(work->x, r, m * sizeof *r);
}

static void keep_best(const dls_nlgs *work, size_t m, const double *r, double residual,
                      double *best) {
  if (!(residual < *best) && *best == *best) return;
  *best = residual;
  memcpy(work->best, r, m * sizeof *r);
}

/* Sweeps until the certificate holds or there is a reason to stop, which is returned; r is then the
 * best iterate, work->u belongs to it and so does *certificate. *iterations: sweeps done. */
static dls_status iterate(dls_nlgs *work, const dls_contact *problem, double *r,
                          dls_certificate *certificate, int *iterations) {
  const dls_nlgs_settings *settings = &work->settings;
  const int most = dlsi_most_iterations(&settings->limits, most_sweeps);
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  const double scale = 1 / dlsi_norm2(problem->q, m);

  const int cold =
      dlsi_max_abs(r, m) == 0; /* u = q, and nothing is rounded: the estimate will do */
  if (cold) memcpy(work->u, problem->q, m * sizeof *work->u);
  double residual = cold ? estimate(work, problem, r, scale) : INFINITY, best = NAN;
  if (!cold || residual <= work->tol) {
    *certificate = measure(work, problem, r);
    if (dls_certificate_holds(certificate, work->tol)) return DLS_OK;
    residual = certificate->residual;
  }
  keep_best(work, m, r, residual, &best);
  if (!cold && settings->limits.warm_start && project_start(problem, r)) {
    *certificate = measure(work, problem, r);
    residual = certificate->residual;
    keep_best(work, m, r, residual, &best);
  }
  if (!cold) resume(work, problem, r);
  double target = work->tol, accepted = residual;
  dls_status reason = DLS_MAX_ITERATIONS;
  int fresh = 1; /* u carries no rounding of earlier sweeps */
  const int accelerated = settings->acceleration != DLS_ACCELERATION_NONE;
  const int first = work->sweeps.plain + 1; /* of which the acceleration knows */
  if (accelerated) dlsi_anderson_clear(&work->history);
  int changed = 0;
  for (int k = 1; k <= most; k++) {
    if (accelerated && k == first) memcpy(work->x, r, m * sizeof *r);
    if (accelerated && k > first && changed) {
      accelerate(work, problem, residual, scale, &accepted, r);
      fresh = 0;
    }
    changed = sweep(work, problem, r);
    *iterations = k;
    residual = estimate(work, problem, r, scale);
    const int was_fresh = fresh;
    fresh = !changed || residual <= target || k % refresh_every == 0;
    if (fresh) { /* (G5) */
      *certificate = measure(work, problem, r);
      if (dls_certificate_holds(certificate, work->tol)) return DLS_OK;
      residual = certificate->residual;
      resume(work, problem, r);
      target = 4 * certificate->floor > work->tol ? 4 * certificate->floor : work->tol;
    }
    keep_best(work, m, r, residual, &best);
    const dls_progress progress = {"nlgs", k, most, residual};
    if (settings->limits.progress &&
        settings->limits.progress(settings->limits.progress_data, &progress)) {
      reason = DLS_CANCELLED;
      break;
    }
    if ((!changed && was_fresh) || !(residual <= DBL_MAX)) {
      reason = DLS_STALLED;
      break;
    }
  }
  if (!(residual <= best)) memcpy(r, work->best, m * sizeof *r);
  *certificate = measure(work, problem, r);
  return dls_certificate_holds(certificate, work->tol) ? DLS_OK : reason;
}

/* how many candidates have several solutions when the others stay at r; u = W r + q */
static int count_ambiguous(const dls_nlgs *work, const dls_contact *problem, const double *r,
                           const double *u) {
  const int d = problem->d;
  int ambiguous = 0;
  for (int c = 0; c < problem->nc; c++) {
    const double *W = d == 2 ? work->block_2d[c].W : work->block_3d[c].W;
    const double *rc = r + (size_t)d * (size_t)c, *uc = u + (size_t)d * (size_t)c;
    double p[3], s[3];
    for (int i = 0; i < d; i++) {
      p[i] = uc[i];
      for (int j = 0; j < d; j++)
        p[i] -= W[i + d * j] * rc[j];
    }
    int count;
    (void)dls_nlgs_local(d, W, p, problem->mu[c], s, &count);
    ambiguous += count > 1;
  }
  return ambiguous;
}

dls_status dlsi_nlgs_run(dls_nlgs *work, const dls_contact *problem, dlsi_sweeps sweeps, double tol,
                         double *r, double *u, dls_certificate *certificate, int *iterations) {
  const double *E = sweeps.E;
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  work->sweeps = sweeps;
  work->tol = tol;
  for (size_t c = 0; c < m / d; c++) {
    double W[9];
    dlsi_contact_diagonal(problem, (int)c, W);
    work->w[c] = dlsi_block_weight(problem->d, W);
    for (size_t i = 0; E && i < d; i++)
      W[(d + 1) * i] += E[c];
    if (d == 2)
      dlsi_block_2d_set(&work->block_2d[c], W, problem->mu[c]);
    else
      dlsi_block_3d_set(&work->block_3d[c], W, problem->mu[c]);
  }
  dlsi_contact_complete_weights(problem, work->w);
  if (!work->settings.limits.warm_start || dlsi_max_abs(problem->q, m) == 0) /* q = 0: r = 0 */
    memset(r, 0, m * sizeof *r);
  *iterations = 0;
  const dls_status status = iterate(work, problem, r, certificate, iterations);
  if (u) memcpy(u, work->u, m * sizeof *u);
  return status;
}

dls_status dls_nlgs_solve(dls_nlgs *workspace, const dls_contact *problem, double *r, double *u,
                          dls_info *info, dls_error *error) {
  if (!workspace) return dlsi_at(__func__, dlsi_is_null(error, "workspace"), error);
  dls_nlgs *work = workspace;
  dls_status status =
      dlsi_check_solve(work->d, work->nc, problem, r, work->settings.limits.warm_start, error);
  if (status) return dlsi_at(__func__, status, error);
  int iterations;
  dls_certificate certificate;
  status = dlsi_nlgs_run(work, problem, (dlsi_sweeps){0}, work->settings.limits.tol, r, u,
                         &certificate, &iterations);
  if (info) {
    const dls_info outcome = {.status = status,
                              .method = DLS_NLGS,
                              .iterations = iterations,
                              .certificate = certificate,
                              .ambiguous = count_ambiguous(work, problem, r, work->u)};
    *info = outcome;
  }
  return dlsi_at(__func__, status, error);
}
