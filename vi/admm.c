/*
 * admm.c: splitting with a factorisation, d = 2 and 3.
 *
 * The problem is 0 in A(r) + B(r) with the affine A(r) = W r + q and the law of contact and
 * friction,
 *
 *   B(r) = { -u :  0 <= u_n _|_ r_n >= 0,  |r_t| <= mu r_n,  u_t = -alpha r_t, alpha >= 0, and
 *                  u_t = 0 where |r_t| < mu r_n }
 *
 * Douglas and Rachford's splitting takes the two in turn, each by its resolvent in the metric
 * rho D, D = diag(w_c) with the weights of the certificate, rho > 0 without unit:
 *
 *   (D1)  z = (I + (rho D)^-1 B)^-1 v:     z_n = max(v_n, 0), z_t = v_t put on the disc |.| <= mu z_n
 *   (D2)  x = (I + (rho D)^-1 A)^-1 (2 z - v):     (W + rho D) x = rho D (2 z - v) - q
 *   (D3)  u = rho D (2 z - v - x)                  which is W x + q
 *   (D4)  v := v + 1.6 (x - z)                     over-relaxed; 1 in the place of 1.6 is ADMM
 *
 * (D1) is exact: it asks for a z that the law joins to the displacement y = rho D (z - v). There,
 * z_n - v_n >= 0 is complementary to z_n >= 0, whatever the friction: max(v_n, 0). With z_n known,
 * z_t - v_t is opposed to z_t, and zero inside the disc: the projection of v_t. It has one
 * solution, the metric being the same multiple of I for all of a candidate. No projection on the
 * cone with a lagged mu |u_t|, as the symmetric form of the law needs it, stands in between. Where
 * x = z, u = y: the law and u = W r + q hold together.
 *
 *   (D5)  rho is looked at after 20, 40, 80, .. iterations. Where the smallest residual has halved
 *         since, rho := rho sqrt( |x - z| / |z - z'| ), |.| = |D^1/2 .|, z' the z before, if that
 *         changes it by more than sqrt(5). Where it has not, rho may be wrong, and nothing says on
 *         which side: both are tried, farther and farther, rho / 10, 10 rho, rho / 100, .., inside
 *         of 1e-4 .. 100. v := z - (rho_old / rho) (z - v) then keeps z and y. One factorisation.
 *   (D6)  The next v by Anderson's acceleration of (D4) (anderson.c), in the norm |.|.
 *   (D7)  Where an accelerated v has more than twice the |x - z| of the v before, the step is taken
 *         back: v := (D4) of the v before, and the history is forgotten.
 *
 * (D3) gives the certificate's residual of x without a product with W; the certificate itself is
 * recomputed from W and q before "solved" is said.
 *
 * Source: Lions and Mercier, SIAM J. Numer. Anal. 16, 1979, 964-979, for monotone A and B. (D5)
 * balances what z and x lack of each other against the change of z, as Boyd et al., Found. Trends
 * Mach. Learn. 3, 2011, 3.4.1; the doubled intervals bound the factorisations, to 9 in 5000
 * iterations. Start: v = 0, or warm v = r - (W r + q) / (rho D), whose z is r and whose y is u if
 * they meet the law.
 *
 * Cost: per rho a factorisation, m^3 / 3 dense (2/3 m^3 for an unsymmetric W); per iteration a
 * solve with it, 2 m^2, and O(m).
 * What can fail: with mu = 0 or given friction thresholds, and W + W^T positive semidefinite, B and
 * A are monotone and the plain iteration converges from anywhere. Coulomb's B is not: it can cycle
 * at large mu, and crawls where a singular W meets slip. (D5) and (D6) cure most of that and prove
 * nothing. Where there is no solution, v runs away until the limit of iterations.
 */
#include "delassus/admm.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/base.h"
#include "linear/blas.h"
#include "linear/dense.h"
#include "linear/sparse_lu.h"
#include "vi_internal.h"

enum {
  most_iterations = 5000,
  dense_limit = 250,
  window = 10,
  first_look = 20,
  refresh_every = 50,
  most_doublings = 5
};

static const double relaxation = 1.6, growth = 2;
static const double off = 2.2360679774997896; /* sqrt(5) */
static const double least_rho = 1e-4, most_rho = 100;
static const double most_floor = 1e-6; /* of an r that is kept */

typedef enum solver { CHOLESKY, LU, SPARSE_LU } solver;

struct dls_admm {
  dls_admm_settings settings;
  int d, nc;
  double *w;              /* nc  weights of the certificate */
  double *metric;         /* nc  sqrt(w), scaled so that |metric v| has no unit */
  double *v, *z, *before; /* m   before: z' */
  double *x, *u;          /* m */
  double *f, *a;          /* m   f: (D6), and F */
  double *first, *best;   /* m */
  dlsi_anderson history;
  solver solver;
  int *pivot;      /* m */
  int *p;          /* m + 1  of the sparse matrix */
  dlsi_room *room; /* of the matrix: the one given, or */
  dlsi_room own;
};

void dls_admm_settings_init(dls_admm_settings *settings) {
  if (!settings) return;
  *settings = (dls_admm_settings){.size = sizeof *settings, .rho = 1};
  dlsi_limits_init(&settings->limits);
}

static dls_status check_settings(const dls_admm_settings *s, dls_error *error) {
  const dlsi_setting own[] = {{"rho", s->rho, 0, INFINITY, 1}};
  return dlsi_check_settings(&s->limits, s->size, sizeof *s, 1, own, error);
}

/* the workspace and its arrays but for the matrix, in one piece */
static dls_admm *carve(dlsi_arena *arena, int d, int nc) {
  const size_t n = (size_t)nc, m = (size_t)d * n, D = sizeof(double);
  dls_admm *s = dlsi_take(arena, 1, sizeof *s);
  dls_admm filled = {.d = d, .nc = nc};
  filled.w = dlsi_take(arena, n, D);
  filled.metric = dlsi_take(arena, n, D);
  double **const vectors[] = {&filled.v, &filled.z, &filled.before, &filled.x,   &filled.u,
                              &filled.f, &filled.a, &filled.first,  &filled.best};
  for (size_t e = 0; e < sizeof vectors / sizeof vectors[0]; e++)
    *vectors[e] = dlsi_take(arena, m, D);
  dlsi_anderson_carve(&filled.history, arena, m, window, 0);
  filled.pivot = dlsi_take(arena, m, sizeof *filled.pivot);
  filled.p = dlsi_take(arena, m + 1, sizeof *filled.p);
  if (arena->failed || !arena->base) return NULL;
  *s = filled;
  return s;
}

/* ---- room for the matrix --------------------------------------------------------------------- */

static int is_dense(const dls_contact *problem) {
  return problem->W.a != NULL || problem->d * problem->nc <= dense_limit;
}

static dls_status make_room(dls_admm *work, const dls_contact *problem, dls_error *error) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  if (is_dense(problem)) return dlsi_room_dense(work->room, m, error);
  return dlsi_room_sparse(work->room, problem->d, problem->nc, problem->Wb.p[problem->nc], error);
}

/* What W is announced to be. Without MUMPS a solve of many blocks says so, not create. */
static dls_status announce(dls_admm *work, dls_error *error) {
  const size_t m = (size_t)work->d * (size_t)work->nc;
  const int blocks = work->settings.limits.blocks;
  if (!blocks || m <= dense_limit) return dlsi_room_dense(work->room, m, error);
  dls_error why;
  const dls_status status = dlsi_room_sparse(work->room, work->d, work->nc, blocks, &why);
  if (!status || status == DLS_E_UNSUPPORTED) return DLS_OK;
  if (error) *error = why;
  return status;
}

dls_status dlsi_admm_create(dls_admm **out, int d, int nc, const dls_admm_settings *settings,
                            dlsi_room *room, dls_error *error) {
  if (!out) return dlsi_is_null(error, "out");
  *out = NULL;
  dls_status status = dlsi_check_sizes(d, nc, error);
  dls_admm_settings defaults;
  dls_admm_settings_init(&defaults);
  if (!settings) settings = &defaults;
  if (!status) status = check_settings(settings, error);
  if (status) return status;

  dlsi_arena arena = {0};
  (void)carve(&arena, d, nc);
  if (arena.failed) return dlsi_fail(error, DLS_E_SIZE, "nc", -1, nc, "is too large");
  arena.size = arena.used;
  arena.used = 0;
  arena.base = dlsi_alloc(1, arena.size);
  if (!arena.base) return dlsi_no_memory(error);
  dls_admm *work = carve(&arena, d, nc);
  work->settings = *settings;
  work->room = room ? room : &work->own;
  status = announce(work, error);
  if (status) {
    dls_admm_destroy(work);
    return status;
  }
  *out = work;
  return DLS_OK;
}

dls_status dls_admm_create(dls_admm **out, int d, int nc, const dls_admm_settings *settings,
                           dls_error *error) {
  return dlsi_at(__func__, dlsi_admm_create(out, d, nc, settings, NULL, error), error);
}

void dls_admm_destroy(dls_admm *workspace) {
  if (!workspace) return;
  dlsi_room_free(&workspace->own);
  free(workspace); /* first in its one piece */
}

/* ---- W + rho D ------------------------------------------------------------------------------- */

/* J := W + rho D */
static void build_dense(dls_admm *work, const dls_contact *problem, double rho) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
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
    column[j] += rho * work->w[c];
  }
}

/* J := its factors, Cholesky's if it has any; DLS_E_SINGULAR */
static dls_status factor_dense(dls_admm *work, const dls_contact *problem, double rho) {
  const int m = problem->d * problem->nc;
  double *J = work->room->J;
  int info;
  build_dense(work, problem, rho);
  if (dlsi_is_symmetric(J, (size_t)m)) {
    work->solver = CHOLESKY;
    dpotrf_("L", &m, J, &m, &info, 1);
    if (!info) return DLS_OK;
    build_dense(work, problem, rho);
  }
  work->solver = LU;
  dgetrf_(&m, &m, J, &m, work->pivot, &info);
  return info ? DLS_E_SINGULAR : DLS_OK;
}

static dls_sparse build_sparse(dls_admm *work, const dls_contact *problem, double rho) {
  const int d = problem->d;
  const dls_blocks *W = &problem->Wb;
  int entries = 0, *row = work->room->i;
  double *value = work->room->v;
  for (int b = 0; b < problem->nc; b++)
    for (int j = 0; j < d; j++) {
      const int column = d * b + j;
      work->p[column] = entries;
      row[entries] = column;
      value[entries++] = rho * work->w[b];
      for (int s = W->p[b]; s < W->p[b + 1]; s++) {
        const double *x = W->x + (size_t)(d * d) * (size_t)s + d * j;
        for (int i = 0; i < d; i++) {
          row[entries] = d * W->i[s] + i;
          value[entries++] = x[i];
        }
      }
    }
  const int m = d * problem->nc;
  work->p[m] = entries;
  return (dls_sparse){m, m, work->p, row, value};
}

/* Factors W + rho D. Where it is singular, which few rho can do, rho is doubled; DLS_E_SINGULAR if
 * that does not help. *done counts. */
static dls_status factor(dls_admm *work, const dls_contact *problem, double *rho, int *done,
                         dls_error *error) {
  for (int k = 0; k <= most_doublings; k++) {
    dls_status status;
    dls_error why = {0};
    if (is_dense(problem))
      status = factor_dense(work, problem, *rho);
    else {
      const dls_sparse A = build_sparse(work, problem, *rho);
      work->solver = SPARSE_LU;
      status = dlsi_sparse_lu_factor(work->room->lu, &A, &why);
    }
    ++*done;
    if (status && status != DLS_E_SINGULAR && error) *error = why;
    if (status != DLS_E_SINGULAR) return status;
    *rho *= 2;
  }
  return DLS_E_SINGULAR;
}

/* x := (W + rho D)^-1 x */
static dls_status back(dls_admm *work, int m, double *x, dls_error *error) {
  const int one = 1;
  int info;
  if (work->solver == CHOLESKY) {
    dlsi_solve_lower(m, work->room->J, x);
    dlsi_solve_upper(m, work->room->J, x);
  } else if (work->solver == LU)
    dgetrs_("N", &m, &one, work->room->J, &m, work->pivot, x, &m, &info, 1);
  else
    return dlsi_sparse_lu_solve(work->room->lu, x, error);
  return DLS_OK;
}

/* ---- the iteration --------------------------------------------------------------------------- */

/* (D1) */
static void resolvent(const dls_contact *problem, const double *v, double *z) {
  const size_t d = (size_t)problem->d;
  for (int c = 0; c < problem->nc; c++) {
    const double *vc = v + d * (size_t)c;
    double *zc = z + d * (size_t)c;
    zc[0] = vc[0] > 0 ? vc[0] : 0;
    const double R = problem->mu[c] * zc[0], size = d == 2 ? fabs(vc[1]) : hypot(vc[1], vc[2]);
    for (size_t i = 1; i < d; i++)
      zc[i] = size > R ? R * (vc[i] / size) : vc[i];
  }
}

/* (D2), (D3) */
static dls_status solve_linear(dls_admm *work, const dls_contact *problem, double rho,
                               dls_error *error) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  double *x = work->x, *u = work->u;
  for (size_t k = 0; k < m; k++)
    x[k] = rho * work->w[k / d] * (2 * work->z[k] - work->v[k]) - problem->q[k];
  const dls_status status = back(work, (int)m, x, error);
  for (size_t k = 0; k < m; k++)
    u[k] = rho * work->w[k / d] * (2 * work->z[k] - work->v[k] - x[k]);
  return status;
}

/* The certificate's residual of x, from the u at hand. */
static double estimate(const dls_admm *work, const dls_contact *problem, double q) {
  const size_t d = (size_t)problem->d;
  for (int c = 0; c < problem->nc; c++) {
    const size_t o = d * (size_t)c;
    dlsi_contact_residual(problem->d, problem->mu[c], work->w[c], work->x + o, work->u + o,
                          work->f + o);
  }
  return dlsi_norm2(work->f, d * (size_t)problem->nc) / q;
}

/* The certificate of r; work->u := W r + q. */
static dls_certificate measure(dls_admm *work, const dls_contact *problem, const double *r) {
  dls_certificate certificate;
  dlsi_contact_multiply(problem, NULL, r, work->u, work->a);
  dlsi_contact_measure(problem, r, work->u, work->a, work->w, work->f, &certificate);
  return certificate;
}

/* | D^1/2 (a - b) |, without unit */
static double distance(dls_admm *work, const dls_contact *problem, const double *a,
                       const double *b) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  for (size_t k = 0; k < m; k++)
    work->f[k] = work->metric[k / d] * (a[k] - b[k]);
  return dlsi_norm2(work->f, m);
}

/* w and metric = D^1/2 / |D^-1/2 q|; q != 0 */
static void set_metric(dls_admm *work, const dls_contact *problem) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  dlsi_contact_weights(problem, work->w);
  for (size_t k = 0; k < m; k++)
    work->f[k] = problem->q[k] / sqrt(work->w[k / d]);
  const double scale = dlsi_norm2(work->f, m);
  for (size_t c = 0; c < m / d; c++)
    work->metric[c] = sqrt(work->w[c]) / scale;
}

/* what (D5) knows */
typedef struct schedule {
  double rho;
  double jump;     /* the next factor where the residual stands still */
  double residual; /* the smallest one at the last look */
  int look;        /* iteration of the next */
} schedule;

/* The rho that (D5) asks for; gap = |x - z|, residual: the smallest so far. */
static double next_rho(dls_admm *work, const dls_contact *problem, double gap, double residual,
                       schedule *s) {
  const int moves = residual <= s->residual / 2;
  double change = s->jump;
  if (moves) {
    change = sqrt(gap / distance(work, problem, work->z, work->before)); /* infinite: most_rho */
    if (change <= off && change >= 1 / off) change = 1;
  } else
    s->jump = s->jump < 1 ? 10 / s->jump : 0.1 / s->jump;
  s->residual = residual;
  if (s->look <= INT_MAX / 2) s->look *= 2;
  const double rho = s->rho * change;
  return rho > most_rho ? most_rho : rho < least_rho ? least_rho : rho;
}

/* (D5): to rho, with the same z and y. DLS_E_SINGULAR, DLS_E_MEMORY */
static dls_status change_rho(dls_admm *work, const dls_contact *problem, double rho, schedule *s,
                             int *factorisations, dls_error *error) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const double old = s->rho;
  s->rho = rho;
  const dls_status status = factor(work, problem, &s->rho, factorisations, error);
  for (size_t k = 0; k < m; k++)
    work->v[k] = work->z[k] - old / s->rho * (work->z[k] - work->v[k]);
  dlsi_anderson_clear(&work->history);
  return status;
}

/* (D4), (D6), (D7); gap = |x - z|, *accepted that of the v before */
static void advance(dls_admm *work, const dls_contact *problem, double gap, double *accepted) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  dlsi_anderson *history = &work->history;
  if (history->columns && !(gap <= growth * *accepted)) {
    memcpy(work->v, history->g, m * sizeof *work->v);
    dlsi_anderson_clear(history);
    return;
  }
  *accepted = gap;
  for (size_t k = 0; k < m; k++) {
    const double step = relaxation * (work->x[k] - work->z[k]);
    work->v[k] += step;
    work->f[k] = work->metric[k / d] * step;
  }
  (void)dlsi_anderson_step(history, (int)m, work->f, work->v, NULL);
}

/* The v of r = work->best, to which work->u belongs. */
static void start(dls_admm *work, const dls_contact *problem, double rho) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  for (size_t k = 0; k < m; k++)
    work->v[k] =
        work->settings.limits.warm_start ? work->best[k] - work->u[k] / (rho * work->w[k / d]) : 0;
  memset(work->z, 0, m * sizeof *work->z);
  dlsi_anderson_clear(&work->history);
}

/* Iterates from work->best, whose residual is `best`, until the certificate of an x holds or there
 * is a reason to stop, which is returned. work->best: the x of the smallest residual. */
static dls_status iterate(dls_admm *work, const dls_contact *problem, double best, int *iterations,
                          int *factorisations, dls_error *error) {
  const dls_admm_settings *settings = &work->settings;
  const int most = dlsi_most_iterations(&settings->limits, most_iterations);
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const double q = dlsi_norm2(problem->q, m);
  schedule s = {settings->rho, 0.1, INFINITY, first_look};
  double target = settings->limits.tol, accepted = 0;
  dls_status status = factor(work, problem, &s.rho, factorisations, error);
  start(work, problem, s.rho);
  for (int k = 1; !status && k <= most; k++) {
    memcpy(work->before, work->z, m * sizeof *work->z);
    resolvent(problem, work->v, work->z);               /* (D1) */
    status = solve_linear(work, problem, s.rho, error); /* (D2), (D3) */
    if (status) break;
    *iterations = k;
    double residual = estimate(work, problem, q);
    int solved = 0;
    if (residual <= target || k % refresh_every == 0) {
      const dls_certificate now = measure(work, problem, work->x);
      solved = dls_certificate_holds(&now, settings->limits.tol);
      residual = now.residual;
      target = 4 * now.floor > settings->limits.tol ? 4 * now.floor : settings->limits.tol;
    }
    if (solved || residual < best) {
      best = residual;
      memcpy(work->best, work->x, m * sizeof *work->x);
    }
    if (solved) return DLS_OK;
    const dls_progress progress = {"admm", k, most, residual};
    if (settings->limits.progress &&
        settings->limits.progress(settings->limits.progress_data, &progress))
      return DLS_CANCELLED;
    const double gap = distance(work, problem, work->x, work->z);
    if (!(gap > 0 && gap <= DBL_MAX)) return DLS_STALLED;
    const double rho = k == s.look ? next_rho(work, problem, gap, best, &s) : s.rho; /* (D5) */
    if (rho != s.rho) {
      status = change_rho(work, problem, rho, &s, factorisations, error);
      continue;
    }
    advance(work, problem, gap, &accepted); /* (D4), (D6), (D7) */
  }
  return status == DLS_E_SINGULAR ? DLS_STALLED : status ? status : DLS_MAX_ITERATIONS;
}

/* From work->first; afterwards work->best is the best r, to which work->u and *certificate belong.
 * */
static dls_status run(dls_admm *work, const dls_contact *problem, dls_certificate *certificate,
                      int *iterations, int *factorisations, dls_error *error) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  *certificate = measure(work, problem, work->first);
  if (!(certificate->residual <= DBL_MAX)) { /* W r overflows */
    memset(work->first, 0, m * sizeof *work->first);
    *certificate = measure(work, problem, work->first);
  }
  memcpy(work->best, work->first, m * sizeof *work->best);
  if (dls_certificate_holds(certificate, work->settings.limits.tol)) return DLS_OK;
  const dls_certificate at_first = *certificate;
  const dls_status status =
      iterate(work, problem, at_first.residual, iterations, factorisations, error);
  if (status < 0) return status;
  *certificate = measure(work, problem, work->best);
  /* an r that has run away in the null space of W has a residual of nothing but rounding */
  if (!(certificate->residual <= at_first.residual && certificate->floor <= most_floor)) {
    memcpy(work->best, work->first, m * sizeof *work->best);
    *certificate = measure(work, problem, work->best);
  }
  return dls_certificate_holds(certificate, work->settings.limits.tol) ? DLS_OK : status;
}

dls_status dlsi_admm_solve(dls_admm *work, const dls_contact *problem, double *r, double *u,
                           dls_info *info, dls_error *error) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  dls_status status = make_room(work, problem, error);
  if (status) return status;

  if (!work->settings.limits.warm_start || dlsi_max_abs(problem->q, m) == 0) /* q = 0: r = 0 */
    memset(work->first, 0, m * sizeof *r);
  else
    memcpy(work->first, r, m * sizeof *r);
  set_metric(work, problem);
  int iterations = 0, factorisations = 0;
  dls_certificate certificate;
  status = run(work, problem, &certificate, &iterations, &factorisations, error);
  if (status < 0) return status;
  memcpy(r, work->best, m * sizeof *r);
  if (u) memcpy(u, work->u, m * sizeof *u);
  if (info) {
    const dls_info outcome = {.status = status,
                              .method = DLS_ADMM,
                              .iterations = iterations,
                              .certificate = certificate,
                              .factorisations = factorisations};
    *info = outcome;
  }
  return status;
}

dls_status dls_admm_solve(dls_admm *workspace, const dls_contact *problem, double *r, double *u,
                          dls_info *info, dls_error *error) {
  if (!workspace) return dlsi_at(__func__, dlsi_is_null(error, "workspace"), error);
  const dls_status status = dlsi_check_solve(workspace->d, workspace->nc, problem, r,
                                             workspace->settings.limits.warm_start, error);
  return dlsi_at(__func__, status ? status : dlsi_admm_solve(workspace, problem, r, u, info, error),
                 error);
}
