/*
 * admm.c: splitting with a factorisation, d = 2 and 3.
 *
 * The problem is 0 in A(r) + B(r) with the affine A(r) = W r + q and the law of contact and
 * friction,
 *
 *   B(r) = { -u :  0 <= u_n _|_ r_n >= 0,  |r_t| <= mu r_n,  u_t = -alpha r_t, alpha >= 0, and
 *                  u_t = 0 where |r_t| < mu r_n }
 *
 * Douglas and Rachford's splitting applies the resolvents of B and A in turn, in the metric rho D:
 * D = diag(w_c) has the weights of the certificate, rho > 0 has no unit.
 *
 *   (AD1)  z = (I + (rho D)^-1 B)^-1 v:  z_n = max(v_n, 0), z_t = v_t put on the disc |.| <= mu z_n
 *   (AD2)  x = (I + (rho D)^-1 A)^-1 (2 z - v):     (W + rho D) x = rho D (2 z - v) - q
 *   (AD3)  u = rho D (2 z - v - x)                  which is W x + q
 *   (AD4)  v := v + 1.6 (x - z)                     over-relaxed; 1 for 1.6 is ADMM
 *
 * (AD1) is exact. It asks for a z that the law joins to the displacement y = rho D (z - v). There
 * z_n - v_n >= 0 is complementary to z_n >= 0 for any friction: z_n = max(v_n, 0). With z_n known,
 * z_t - v_t is opposed to z_t, and zero inside the disc: z_t is the projection of v_t. The solution
 * is unique because the metric is a multiple of I for each contact. The symmetric form of the law
 * would need a projection with a lagged mu |u_t|; this form does not. If x = z, then u = y, and the
 * law and u = W r + q hold together.
 *
 *   (AD5)  rho is checked after 20, 40, 80, .. iterations. If the least residual has halved since
 *          the last check, rho := rho sqrt( |x - z| / |z - z'| ), |.| = |D^1/2 .|, z' the z before,
 *          if that changes rho by more than sqrt(5). If it has not halved, rho may be too large or
 *          too small: rho / 10, 10 rho, rho / 100, .. are tried. 1e-8 <= rho <= 100. Then
 *          v := z - (rho_old / rho) (z - v), which keeps z and y. One factorisation.
 *   (AD6)  The next v by Anderson's acceleration of (AD4) (anderson.c), in the norm |.|.
 *   (AD7)  If an accelerated v has more than twice the |x - z| of the v before, the step is undone:
 *          v := (AD4) of the v before, and the history is cleared.
 *
 * (AD3) gives the certificate's residual of x without a product with W. Before "solved" is
 * returned, the certificate is recomputed from W and q.
 *
 * Source: Lions and Mercier, SIAM J. Numer. Anal. 16, 1979, 964-979, for monotone A and B. (AD5)
 * balances |x - z| against the change of z, as Boyd et al., Found. Trends Mach. Learn. 3, 2011,
 * 3.4.1; the doubled intervals allow 9 factorisations in 5000 iterations. Start: v = 0, or
 * warm v = r - (W r + q) / (rho D), whose z is r and whose y is u if they meet the law.
 *
 * Cost: per rho a factorisation, m^3 / 3 dense (2/3 m^3 for an unsymmetric W); per iteration a
 * solve with it, 2 m^2, and O(m). What can fail: if mu = 0 or thresholds of friction are given, and
 * W + W^T is positive semidefinite, B and A are monotone and the plain iteration converges from
 * anywhere. Coulomb's B is not monotone: the iteration can cycle at large mu, and converges slowly
 * if a singular W meets slip. (AD5) and (AD6) cure most of that and prove nothing. If there is no
 * solution, v runs away until the limit of iterations.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "linear/dense.h"
#include "linear/sparse_lu.h"
#include "vi/vi_internal.h"

enum {
  most_iterations = 5000,
  dense_limit = 250,
  window = 10,
  first_look = 20,
  refresh_every = 50,
  most_doublings = 5
};

static const double admm_relaxation = 1.6, admm_growth = 2;
static const double off = 2.2360679774997896; /* sqrt(5) */
static const double least_rho = 1e-8, most_rho = 100;

/* First rho of a cold solve in auto: so small that the first x is nearly the smallest r with W r =
 * -q. */
static const double other_rho = 1e-8;

struct dls_admm {
  dls_admm_settings settings;
  int d, nc;
  int stage;              /* of auto: cold solves begin with other_rho */
  dlsi_iterate it;        /* its u is that of x */
  double *metric;         /* sqrt(w), scaled so that |metric v| has no unit: nc */
  double *v, *z, *before; /* before: z': m */
  double *x;              /* m */
  double *first;          /* start: m */
  dlsi_anderson history;
  int sparse;       /* 1: this run factorises sparse */
  dlsi_dense dense; /* else: factors of W + rho D */
  int *pivot;       /* m */
  int *p;           /* starts of the columns of the sparse matrix: m + 1 */
  dlsi_room *room;  /* of the matrix: `own`, or the caller's */
  dlsi_room own;
  dlsi_formed formed; /* W of bodies by blocks */
};

void dls_admm_settings_init(dls_admm_settings *settings) {
  if (!settings) return;
  *settings = (dls_admm_settings){.size = sizeof *settings, .rho = 1};
  dlsi_limits_init(&settings->limits);
}

static void admm_carve(void *workspace, dlsi_arena *arena) {
  dls_admm *work = workspace;
  const size_t n = (size_t)work->nc, m = (size_t)work->d * n;
  double **const vectors[] = {&work->v, &work->z, &work->before, &work->x, &work->first};
  dlsi_iterate_carve(&work->it, arena, work->d, work->nc, &work->settings.limits);
  work->metric = dlsi_take(arena, n, sizeof *work->metric);
  dlsi_take_vectors(arena, m, 5, vectors);
  dlsi_anderson_carve(&work->history, arena, m, window, 0);
  work->pivot = dlsi_take(arena, m, sizeof *work->pivot);
  work->p = dlsi_take(arena, m + 1, sizeof *work->p);
}

/* Makes room for the matrix of nc contacts, W dense (blocks = 0) or in `blocks` blocks. */
static dls_status admm_reserve(dls_admm *work, int nc, int blocks, dls_error *error) {
  const size_t m = (size_t)work->d * (size_t)nc;
  work->sparse = blocks && m > dense_limit;
  return work->sparse ? dlsi_room_sparse(work->room, work->d, nc, blocks, error)
                      : dlsi_room_dense(work->room, m, error);
}

static dls_status admm_create(void **out, int d, int nc, const dls_admm_settings *settings,
                              const dlsi_options *options, dls_error *error) {
  dls_admm filled = {.d = d, .nc = nc, .stage = options->stage}, *work;
  dls_admm_settings *s = &filled.settings;
  dls_admm_settings_init(s);
  if (settings) *s = *settings;
  const dlsi_setting own[] = {{"rho", s->rho, 0, INFINITY, 1}};
  dls_error why;
  *out = NULL;
  dls_status status = dlsi_check_sizes(d, nc, error);
  if (!status) status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 1, own, error);
  if (!status) status = dlsi_workspace(out, &filled, sizeof filled, admm_carve, nc, error);
  if (status) return status;
  work = *out;
  work->room = options->room ? options->room : &work->own;
  status = admm_reserve(work, nc, s->limits.blocks, &why);
  if (!status || status == DLS_E_UNSUPPORTED) return DLS_OK; /* a solve of many blocks reports it */
  if (error) *error = why;
  dls_admm_destroy(work);
  *out = NULL;
  return status;
}

dls_status dls_admm_create(dls_admm **out, int d, int nc, const dls_admm_settings *settings,
                           dls_error *error) {
  DLSI_DOOR;
  void *work = NULL;
  const dls_status status = out ? admm_create(&work, d, nc, settings, &(dlsi_options){0}, error)
                                : dlsi_is_null(error, "out");
  if (out) *out = work;
  return dlsi_at(__func__, status, error);
}

void dls_admm_destroy(dls_admm *workspace) {
  if (!workspace) return;
  dlsi_room_free(&workspace->own);
  dlsi_formed_free(&workspace->formed);
  free(workspace);
}

void dlsi_admm_share(dls_admm *work, const dlsi_shared *shared) {
  work->it.shared = shared;
}

/* ---- W + rho D ------------------------------------------------------------------------------- */

/* J := W + rho D. */
static void admm_build_dense(dls_admm *work, const dls_contact *problem, double rho) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  work->room->owner = work;
  for (size_t j = 0; j < m; j++) {
    const size_t c = j / d;
    double *column = work->room->J + j * m;
    if (problem->W.a)
      memcpy(column, problem->W.a + j * (size_t)problem->W.ld, m * sizeof *column);
    else {
      double e[3] = {0};
      e[j % d] = 1;
      memset(column, 0, m * sizeof *column);
      dlsi_contact_add_columns(problem, (int)c, e, column);
    }
    column[j] += rho * work->it.w[c];
  }
}

/* Returns W + rho D in compressed columns. */
static dls_sparse admm_build_sparse(dls_admm *work, const dls_contact *problem, double rho) {
  const int d = problem->d;
  const dls_blocks *W = &problem->Wb;
  int entries = 0, *row = work->room->i;
  double *value = work->room->v;
  for (int b = 0; b < problem->nc; b++)
    for (int j = 0; j < d; j++) {
      const int column = d * b + j;
      work->p[column] = entries;
      row[entries] = column;
      value[entries++] = rho * work->it.w[b];
      for (int s = W->p[b]; s < W->p[b + 1]; s++) {
        const double *x = W->x + (size_t)(d * d) * (size_t)s + d * j;
        for (int i = 0; i < d; i++) {
          row[entries] = d * W->i[s] + i;
          value[entries++] = x[i]; /* W is by blocks: NOLINT(clang-analyzer-core.NullDereference) */
        }
      }
    }
  const int m = d * problem->nc;
  work->p[m] = entries;
  return (dls_sparse){m, m, work->p, row, value};
}

/* Factorises W + rho D. If it is singular, as for few rho, rho is doubled; DLS_E_SINGULAR if that
 * does not help. *done counts factorisations. */
static dls_status admm_factor(dls_admm *work, const dls_contact *problem, double *rho, int *done,
                              dls_error *error) {
  for (int k = 0; k <= most_doublings; k++, *rho *= 2) {
    dls_status status;
    dls_error why = {0};
    const dlsi_shared *shared = work->it.shared;
    if (shared)
      status = shared->factor(shared->data, *rho, work->it.w, &why);
    else if (work->sparse) {
      const dls_sparse A = admm_build_sparse(work, problem, *rho);
      status = dlsi_sparse_lu_factor(work->room->lu, &A, &why);
    } else {
      admm_build_dense(work, problem, *rho);
      work->dense =
          (dlsi_dense){.n = problem->d * problem->nc, .A = work->room->J, .pivot = work->pivot};
      status = dlsi_dense_factor(&work->dense, work->it.a) ? DLS_E_SINGULAR : DLS_OK;
    }
    ++*done;
    if (status && status != DLS_E_SINGULAR && error) *error = why;
    if (status != DLS_E_SINGULAR) return status;
  }
  return DLS_E_SINGULAR;
}

/* ---- the iteration --------------------------------------------------------------------------- */

/* (AD2), (AD3) */
static dls_status admm_solve_linear(dls_admm *work, const dls_contact *problem, double rho,
                                    dls_error *error) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  const double *w = work->it.w;
  double *x = work->x, *u = work->it.u;
  dls_status status = DLS_OK;
  for (size_t k = 0; k < m; k++)
    x[k] = rho * w[k / d] * (2 * work->z[k] - work->v[k]) - problem->q[k];
  if (work->it.shared)
    work->it.shared->solve(work->it.shared->data, x);
  else if (work->sparse)
    status = dlsi_sparse_lu_solve(work->room->lu, x, error);
  else
    dlsi_dense_solve(&work->dense, x, (int)m, 1);
  for (size_t k = 0; k < m; k++)
    u[k] = rho * w[k / d] * (2 * work->z[k] - work->v[k] - x[k]);
  return status;
}

/* Estimates the residuals of the certificate of x from the u of (AD3). */
static void admm_estimate(const dls_admm *work, const dls_contact *problem, dls_certificate *now) {
  const dlsi_iterate *it = &work->it;
  const double unit = it->w[0],
               scale = 1 / dlsi_max_abs(problem->q, (size_t)(problem->d * problem->nc));
  double f = 0, force = 0, r = 0, q = 0; /* squares, as in vi/sweep/nlgs.c */
  for (int c = 0; c < problem->nc; c++) {
    const size_t o = (size_t)problem->d * (size_t)c;
    const double *w = it->weights + 2 * (size_t)c, *rc = work->x + o, *uc = it->u + o;
    double F[3];
    const int touches = dlsi_contact_misfit(problem->d, problem->mu[c], w, rc, uc, F) != DLS_FREE;
    for (int i = 0; i < problem->d; i++) {
      const double Fi = scale * F[i], Gi = unit / w[i > 0] * Fi;
      f += Fi * Fi;
      force += Gi * Gi;
      if (!touches) continue;
      r += (scale * unit * rc[i]) * (scale * unit * rc[i]);
      q += (scale * problem->q[o + (size_t)i]) * (scale * problem->q[o + (size_t)i]);
    }
  }
  dlsi_set_residuals(now, q > 0 ? sqrt(f / q) : sqrt(f), sqrt(force), sqrt(r));
}

/* Returns | D^1/2 (a - b) |, without unit. */
static double admm_distance(dls_admm *work, const dls_contact *problem, const double *a,
                            const double *b) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  for (size_t k = 0; k < m; k++)
    work->it.F[k] = work->metric[k / d] * (a[k] - b[k]);
  return dlsi_norm2(work->it.F, m);
}

/* metric := D^1/2 / |D^-1/2 q|; q != 0. Takes roots of w / max w: then a change of units by an odd
 * power of two, whose root is rounded, changes no bit. */
static void admm_set_metric(dls_admm *work, const dls_contact *problem) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  const double most = dlsi_max_abs(work->it.w, m / d);
  for (size_t c = 0; c < m / d; c++)
    work->metric[c] = sqrt(work->it.w[c] / most);
  for (size_t k = 0; k < m; k++)
    work->it.F[k] = problem->q[k] / work->metric[k / d];
  const double scale = dlsi_norm2(work->it.F, m) / most;
  for (size_t c = 0; c < m / d; c++)
    work->metric[c] /= scale;
}

/* State of (AD5). */
typedef struct admm_schedule {
  double rho;
  double jump;     /* next factor if the residual has not halved */
  double residual; /* smallest one at the last check */
  int look;        /* iteration of the next check */
} admm_schedule;

/* Returns the next rho by (AD5). gap = |x - z|; residual: the smallest so far. */
static double admm_next_rho(dls_admm *work, const dls_contact *problem, double gap, double residual,
                            admm_schedule *s) {
  const int moves = residual <= s->residual / 2;
  double change = s->jump;
  if (moves) {
    change =
        sqrt(gap / admm_distance(work, problem, work->z, work->before)); /* infinite: most_rho */
    if (change <= off && change >= 1 / off) change = 1;
  } else
    s->jump = s->jump < 1 ? 10 / s->jump : 0.1 / s->jump;
  s->residual = residual;
  if (s->look <= INT_MAX / 2) s->look *= 2;
  const double rho = s->rho * change;
  return rho > most_rho ? most_rho : rho < least_rho ? least_rho : rho;
}

/* (AD5) Changes rho and keeps z and y. DLS_E_SINGULAR, DLS_E_MEMORY. */
static dls_status admm_change_rho(dls_admm *work, const dls_contact *problem, double rho,
                                  admm_schedule *s, int *factorisations, dls_error *error) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const double old = s->rho;
  s->rho = rho;
  const dls_status status = admm_factor(work, problem, &s->rho, factorisations, error);
  for (size_t k = 0; k < m; k++)
    work->v[k] = work->z[k] - old / s->rho * (work->z[k] - work->v[k]);
  dlsi_anderson_clear(&work->history);
  return status;
}

/* (AD4), (AD6), (AD7) gap = |x - z|; *accepted: that of the v before. */
static void admm_advance(dls_admm *work, const dls_contact *problem, double gap, double *accepted) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  dlsi_anderson *history = &work->history;
  if (history->columns && !(gap <= admm_growth * *accepted)) {
    memcpy(work->v, history->g, m * sizeof *work->v);
    dlsi_anderson_clear(history);
    return;
  }
  *accepted = gap;
  for (size_t k = 0; k < m; k++) {
    const double step = admm_relaxation * (work->x[k] - work->z[k]);
    work->v[k] += step;
    work->it.F[k] = work->metric[k / d] * step;
  }
  (void)dlsi_anderson_step(history, (int)m, work->it.F, work->v, NULL);
}

/* Returns 1 if a solve starts from the given r, 0 if from v = 0. */
static int admm_is_warm(const dls_admm *work) {
  return work->settings.limits.warm_start;
}

/* Iterates from work->first, measured last, until the certificate of an x holds. Returns DLS_OK, or
 * the reason to stop before. */
static dls_status admm_iterate(dls_admm *work, const dls_contact *problem, dls_info *outcome,
                               dls_error *error) {
  const dls_limits *limits = &work->settings.limits;
  dlsi_iterate *it = &work->it;
  const int most = dlsi_most_iterations(limits, most_iterations);
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  int *factorisations = &outcome->factorisations;
  const int other = work->stage && !admm_is_warm(work);
  admm_schedule s = {other ? other_rho : work->settings.rho, 0.1, INFINITY, first_look};
  dls_certificate now = it->certificate;
  double accepted = 0;
  dls_status status = admm_factor(work, problem, &s.rho, factorisations, error);
  for (size_t k = 0; k < m; k++)
    work->v[k] = admm_is_warm(work) ? work->first[k] - it->u[k] / (s.rho * it->w[k / d]) : 0;
  memset(work->z, 0, m * sizeof *work->z);
  dlsi_anderson_clear(&work->history);
  for (int k = 1; !status && k <= most; k++) {
    memcpy(work->before, work->z, m * sizeof *work->z);
    dlsi_put_on_discs(problem->d, problem->nc, problem->mu, work->v, work->z); /* (AD1) */
    status = admm_solve_linear(work, problem, s.rho, error);                   /* (AD2), (AD3) */
    if (status) break;
    outcome->iterations = k;
    admm_estimate(work, problem, &now);
    if (dlsi_certificate_meets(&now, it->tol) || k % refresh_every == 0)
      now = dlsi_iterate_measure(it, problem, work->x);
    if (dlsi_iterate_keep(it, problem, work->x, &now)) return DLS_OK;
    const dls_status stop = dlsi_iterate_tell(it, "admm", k, most, now.residual, work->x);
    if (stop) return stop;
    const double gap = admm_distance(work, problem, work->x, work->z);
    if (!(gap > 0 && gap <= DBL_MAX) || dlsi_iterate_is_lost(now.residual)) return DLS_STALLED;
    const double rho = k == s.look ? admm_next_rho(work, problem, gap, it->certificate.residual, &s)
                                   : s.rho; /* (AD5) */
    if (rho != s.rho)
      status = admm_change_rho(work, problem, rho, &s, factorisations, error);
    else
      admm_advance(work, problem, gap, &accepted); /* (AD4), (AD6), (AD7) */
  }
  return status == DLS_E_SINGULAR ? DLS_STALLED : status ? status : DLS_MAX_ITERATIONS;
}

static dls_status admm_solve(void *workspace, const dls_contact *problem, double *r, double *u,
                             dls_info *info, dls_error *error) {
  dls_admm *work = workspace;
  dlsi_iterate *it = &work->it;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const int blocks = problem->Wb.x ? problem->Wb.p[problem->nc] : 0;
  dls_info outcome = {.method = DLS_ADMM};
  dls_status status = it->shared ? DLS_OK : admm_reserve(work, problem->nc, blocks, error);
  if (status) return status;
  dlsi_iterate_begin(it, problem, NULL, work->settings.limits.tol, admm_is_warm(work), r,
                     work->first);
  if (!dlsi_iterate_start(it, problem, work->first)) {
    const dls_certificate at_first = it->certificate;
    admm_set_metric(work, problem);
    status = admm_iterate(work, problem, &outcome, error);
    if (status < 0) return status;
    status = dlsi_iterate_settle(it, problem, status);
    if (status && !dlsi_is_better(&it->certificate, &at_first)) {
      memcpy(it->best, work->first, m * sizeof *it->best);
      it->certificate = at_first;
    }
  }
  return dlsi_iterate_end(it, problem, status, &outcome, r, u, info);
}

dls_status dls_admm_solve(dls_admm *workspace, const dls_contact *problem, double *r, double *u,
                          dls_info *info, dls_error *error) {
  DLSI_DOOR;
  dls_status status = dlsi_iterate_enter(workspace ? &workspace->it : NULL, problem, r, u, error);
  if (status) return dlsi_at(__func__, status, error);
  if (dlsi_is_empty(problem, &workspace->settings.limits, DLS_ADMM, "admm", info))
    return dlsi_leave(&workspace->it.busy, DLS_OK);
  status = dlsi_form_blocks(&workspace->formed, &problem, error);
  if (!status) status = admm_solve(workspace, problem, r, u, info, error);
  status = dlsi_iterate_leave(&workspace->it, "admm", status, r);
  return dlsi_at(__func__, status, error);
}

/* ---- in the table of methods ----------------------------------------------------------------- */

static dls_status admm_create_by(void **out, int d, int nc, const dlsi_options *options,
                                 dls_error *error) {
  dls_admm_settings s;
  dls_admm_settings_init(&s);
  s.limits = options->limits;
  return admm_create(out, d, nc, &s, options, error);
}

static void admm_destroy(void *work) {
  dls_admm_destroy(work);
}

const dlsi_method dlsi_admm_method = {
    .method = DLS_ADMM,
    .name = "admm",
    .summary = "splitting, one factorisation: large dense W, stacks at rest",
    .create = admm_create_by,
    .solve = admm_solve,
    .destroy = admm_destroy,
    .limits = offsetof(dls_admm, settings.limits),
};
