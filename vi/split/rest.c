/*
 * rest.c: structures at rest, d = 2 and 3: walls, arches, chains, towers; a stage of auto.
 *
 * If nothing slides and opens at the same time, s_c = mu |u_t| may be omitted from the law, and the
 * rest is convex: with the scales of cone.h and the largest entry of q as a unit,
 *
 *   (AR1)  W x + q = z,   x_c and z_c in the Lorentz cone,  x_c.z_c = 0
 *
 * Its answer is that of the law if |z_t| is 0, which the certificate tests. From r = 0, the law
 * with s_c leads large structures away from the answer, and they return late or never.
 *
 *   (AR2)  z = P(v), the projection on the cones
 *   (AR3)  (W + R) x = R (2 z - v) - q,   R = diag(rho_c)
 *   (AR4)  v := v + (x - z), from iteration 10 on v + 1.4 (x - z). The first x is almost the
 *          smallest one with W x = -q: if it lies in the cones, it is the answer.
 *   (AR5)  rho_c = 1e-8: below the nonzero eigenvalues of W, so that the number of iterations does
 *          not grow with them, and above its rounding, of which eps / rho enters x. If no pivot of
 *          W + R is below 100 rho, W is regular and rho_c = 1e-12: x is then almost the answer of
 *          W x = -q. Else, after 10 and after 20 iterations, rho_c = 1e-6 / |z_c| with the mean of
 *          |z| as a unit, at most 1e-3, and v such that z and R (z - v) stay. Balancing residuals
 *          does not find such a rho: they look balanced at 1000 times as much.
 *   (AR6)  ends if 50 iterations have not halved the residual. An interior point follows, unless
 *          only the rounding of W r stands against the answer:
 *
 *   (AR7)  P of cone.h with lambda = P x = P^-1 z. A direction for a right-hand side rc:
 *          (W + P^2 + delta) dx = h - (W x + q - z),  dz = h - P^2 dx,  h = P (lambda \ rc)
 *   (AR8)  affine:   rc = - lambda o lambda, largest step a; sigma = max((1 - a)^3, 1e-3)
 *          combined: rc = sigma tau e - lambda o lambda - (P dx) o (P^-1 dz), dx and dz the affine
 *          ones, tau = x.z / nc. If its step is below .1: without the last term, sigma >= .5
 *   (AR9)  x, z += .99 times the largest step, at most 1
 *   (AR10) ends if the residual is far above what tau leaves, tau < 0.01 and < 0.03 residual^2:
 *          something slides. This point is a good start for the stages that follow.
 *
 *   (AR11) ends before a factorisation of W + R or of W + P^2 that takes more operations than 1000
 *          sweeps: pyramids in 3D, whose fill grows faster than their contacts. Walls, domes and
 *          towers of 40,000 contacts take up to 350 sweeps.
 *
 *   (AR12) auto lets the splitting try a problem that does not look at rest, too, once sweeps have
 *          cost much (dlsi_rest_allow). (AR11) then has that number in place of 1000, (AR6) 15 in
 *          place of 50 iterations once it has cost half as much, and no interior point follows
 *
 * Source: (AR2)-(AR4) Lions and Mercier, SIAM J. Numer. Anal. 16, 1979; (AR7)-(AR9) Mehrotra's
 * predictor and corrector for cones, Andersen, Roos and Terlaky, Math. Program. 95, 2003, 249-277.
 * delta = 1e-10 keeps the factorisation definite if W is singular and P small.
 * Cost of the splitting: W + R by joints.c, 1 to 3 factorisations and 1 to 250 solves; of the
 * interior point: W + P^2 by cholesky.c, 11 to 20 factorisations, up to 60 for long chains, three
 * solves each. The blocks of P^2 range from tau to 1 / tau and would be lost in those of a joint.
 * Each of the two is analysed once. Each solve allocates the matrices and their factors.
 * What can fail: W not symmetric, or a contact without W_cc: DLS_STALLED at once. If something
 * slides, the answer of (AR1) opens there.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "joints.h"
#include "linear/dissection.h"
#include "linear/pieces.h"
#include "vi/cone.h"
#include "vi/vi_internal.h"

enum { measured_every = 5, metric_after = 10, most_points = 80 };
enum { rest_patience = 50, short_patience = 15 };                                /* (AR6), (AR12) */
static const double singular_rho = 1e-8, regular_rho = 1e-12, metric_rho = 1e-6; /* (AR5) */
static const double regular_pivot = 100, least_share = 1e-3;                     /* (AR5) */
static const double rest_relaxation = 1.4;
static const double proximal = 1e-10; /* delta of (AR7) */
static const double to_boundary = 0.99, short_step = 0.1, least_step = 1e-6;
static const double slides_tau = 1e-2, slides = 0.03; /* (AR10) */
static const double most_fill = 1000;                 /* (AR11), sweeps */

typedef struct rest {
  dls_limits limits;
  int d, nc;
  double *S, *q;             /* m: r = b S x; (AR1) */
  double unit, b;            /* W of (AR1) is S W S / unit */
  double *x, *z, *v;         /* m */
  double *dx, *dz, *ax, *az; /* m: combined and affine direction */
  double *w, *lambda, *rc;   /* m: (AR7) */
  double *h, *right;         /* m: h; W x + q - z */
  double *r;                 /* m: scratch */
  double *rho, *eta;         /* nc */
  int *row, *col;            /* of the lower triangle of W, counted from 1; before these entries */
  double *value;             /* ... a triangle per contact of what is added to W */
  size_t entries;
  dlsi_cholesky *factor;
  dlsi_joints *joints; /* W + R of (AR3) */
  double allowed;      /* sweeps, (AR12); 0: it looks at rest */
  double refused;   /* sweeps that a factorisation would have taken, (AR11); 0: none was refused */
  dlsi_watch watch; /* the clock of a factorisation */
  dlsi_iterate it;
} rest;

/* ---- W + a block per contact ----------------------------------------------------------------- */

static size_t added_entries(int d, int nc) {
  return (size_t)(d * (d + 1) / 2) * (size_t)nc;
}

/* y := W x */
static void rest_multiply(const rest *work, int nc, const double *x, double *y) {
  memset(y, 0, (size_t)(work->d * nc) * sizeof *y);
  for (size_t k = added_entries(work->d, nc); k < work->entries; k++) {
    const int i = work->row[k] - 1, j = work->col[k] - 1;
    y[i] += work->value[k] * x[j];
    if (i != j) y[j] += work->value[k] * x[i];
  }
}

static void rest_put(rest *work, int i, int j, double value) {
  work->row[work->entries] = i + 1;
  work->col[work->entries] = j + 1;
  work->value[work->entries++] = value;
}

static void rest_list(rest *work, const dls_contact *problem) {
  const int d = problem->d;
  const dls_blocks *W = &problem->Wb;
  work->entries = 0;
  for (int c = 0; c < problem->nc; c++)
    for (int j = 0; j < d; j++)
      for (int i = j; i < d; i++)
        rest_put(work, d * c + i, d * c + j, 0);
  for (int c = 0; c < problem->nc; c++)
    for (int k = W->p[c]; k < W->p[c + 1]; k++)
      for (int j = 0; j < d && W->i[k] >= c; j++)
        for (int i = W->i[k] == c ? j : 0; i < d; i++) {
          const int row = d * W->i[k] + i, col = d * c + j;
          const double x = W->x[(size_t)(d * d) * (size_t)k + (size_t)(i + d * j)];
          rest_put(work, row, col, work->S[row] * (work->S[col] / work->unit) * x);
        }
}

static void rest_forget_matrix(rest *work) {
  dlsi_joints_destroy(work->joints);
  work->joints = NULL;
  dlsi_cholesky_destroy(work->factor);
  free(work->row);
  free(work->value);
  work->factor = NULL;
  work->row = NULL;
  work->value = NULL;
}

/* Orders and analyses the matrix. DLS_E_MEMORY. */
static dls_status rest_analyse(rest *work, int nc, dls_error *error) {
  const size_t m = (size_t)(work->d * nc);
  int *order = dlsi_alloc(2 * m, sizeof *order), *turn = order + m;
  if (!order) return dlsi_no_memory(error);
  dls_status status = dlsi_dissection((int)m, work->entries, work->row, work->col, order, error);
  for (size_t i = 0; !status && i < m; i++)
    turn[order[i]] = (int)i + 1;
  if (!status)
    status = dlsi_cholesky_create(&work->factor, (int)m, work->entries, work->row, work->col, turn,
                                  0, error);
  free(order);
  return status;
}

/* Fills (AR1). DLS_STALLED if there is no such problem. */
static dls_status rest_set(rest *work, const dls_contact *problem) {
  const size_t m = (size_t)(work->d * problem->nc);
  work->unit = dlsi_cone_scales(problem, work->eta, work->S);
  for (size_t i = 0; i < m; i++)
    work->q[i] = work->S[i] * problem->q[i];
  const double size = dlsi_max_abs(work->q, m);
  for (int c = 0; c < problem->nc; c++)
    if (!(work->eta[c] > 0)) return DLS_STALLED;
  if (!(size > 0)) return DLS_STALLED;
  for (size_t i = 0; i < m; i++)
    work->q[i] /= size;
  work->b = size / work->unit;
  return DLS_OK;
}

/* Lists and analyses the matrix of (AR7). DLS_E_MEMORY. */
static dls_status rest_set_point(rest *work, const dls_contact *problem, dls_error *error) {
  const size_t d = (size_t)work->d;
  const size_t most =
      added_entries(work->d, problem->nc) + d * d * (size_t)problem->Wb.p[problem->nc];
  work->row = dlsi_alloc(2 * most, sizeof *work->row);
  work->value = dlsi_alloc(most, sizeof *work->value);
  if (!work->row || !work->value) return dlsi_no_memory(error);
  work->col = work->row + most;
  rest_list(work, problem);
  return rest_analyse(work, problem->nc, error);
}

/* A dls_progress_fn: returns 1 when the time is over. */
static int rest_is_over(void *data, const dls_progress *progress) {
  const rest *work = data;
  (void)progress;
  return dlsi_clock_is_over(&work->limits, work->it.begun);
}

/* (AR11) Makes the clock watch the factorisations. DLS_STALLED if they take too long. */
static dls_status rest_foresee(rest *work, const dls_contact *problem, dlsi_cholesky *factor) {
  const double sweep = 2. * problem->d * problem->d * problem->Wb.p[problem->nc];
  work->watch = (dlsi_watch){.begun = work->it.begun};
  if (work->limits.cpu_seconds > 0) {
    work->watch.limits.progress = rest_is_over;
    work->watch.limits.progress_data = work;
  }
  factor->watch = &work->watch;
  const double most = work->allowed > 0 ? work->allowed : most_fill;
  if (!(factor->flops > most * sweep)) return DLS_OK;
  work->refused = factor->flops / sweep;
  return DLS_STALLED;
}

/* Returns the status of a factorisation: DLS_STALLED if the matrix is not definite,
 * DLS_TIME_LIMIT, DLS_E_MEMORY. */
static dls_status rest_status(int failed, dls_error *error) {
  if (failed == dlsi_stopped) return DLS_TIME_LIMIT;
  return failed < 0 ? dlsi_no_memory(error) : failed ? DLS_STALLED : DLS_OK;
}

static dls_status rest_factor(rest *work, dls_info *outcome, dls_error *error) {
  double pivot;
  outcome->factorisations++;
  return rest_status(dlsi_cholesky_factor(work->factor, work->value, &pivot), error);
}

/* Measures and keeps r = b S x. Returns its residual. */
static double rest_offer(rest *work, const dls_contact *problem, const double *x) {
  const size_t m = (size_t)(work->d * problem->nc);
  for (size_t i = 0; i < m; i++)
    work->r[i] = work->b * work->S[i] * x[i];
  return dlsi_iterate_offer(&work->it, problem, work->r).residual;
}

/* Reports an iteration. Returns DLS_OK to go on. */
static dls_status rest_tell(rest *work, dls_info *outcome) {
  outcome->iterations++;
  return dlsi_iterate_tell(&work->it, "rest", outcome->iterations, 0, work->it.certificate.residual,
                           work->it.best);
}

/* ---- splitting ------------------------------------------------------------------------------- */

/* Factorises W + R. */
static dls_status rest_factor_metric(rest *work, dls_info *outcome, dls_error *error) {
  outcome->factorisations++;
  return rest_status(dlsi_joints_factor(work->joints, work->rho), error);
}

/* (AR5) before the first iteration. *regular: 1 if W is. */
static dls_status rest_first_metric(rest *work, int nc, int *regular, dls_info *outcome,
                                    dls_error *error) {
  for (int c = 0; c < nc; c++)
    work->rho[c] = singular_rho;
  const dls_status status = rest_factor_metric(work, outcome, error);
  if (status) return status;
  const double root = dlsi_max_abs(work->joints->factor->pivot, (size_t)work->joints->n);
  *regular = regular_pivot * singular_rho * root * root < 1;
  for (int c = 0; *regular && c < nc; c++)
    work->rho[c] = regular_rho;
  return *regular ? rest_factor_metric(work, outcome, error) : DLS_OK;
}

/* (AR5) from z. */
static dls_status rest_next_metric(rest *work, int nc, dls_info *outcome, dls_error *error) {
  const int d = work->d;
  double mean = 0;
  for (int c = 0; c < nc; c++)
    mean += sqrt(dlsi_cone_dot(d, work->z + d * c, work->z + d * c)) / nc;
  if (!(mean > 0)) return DLS_OK;
  for (int c = 0; c < nc; c++) {
    const double *z = work->z + d * c, old = work->rho[c];
    work->rho[c] = metric_rho / fmax(sqrt(dlsi_cone_dot(d, z, z)) / mean, least_share);
    for (int i = 0; i < d; i++)
      work->v[d * c + i] = z[i] - old / work->rho[c] * (z[i] - work->v[d * c + i]);
  }
  return rest_factor_metric(work, outcome, error);
}

/* Returns how many iterations may pass without a halving, (AR6) and (AR12), after k of them. */
static int rest_patience_at(const rest *work, const dls_contact *problem, int factors, int k) {
  const dlsi_cholesky *L = work->joints->factor;
  const double sweep = 2. * problem->d * problem->d * problem->Wb.p[problem->nc];
  const double spent = factors * L->flops + k * (4. * (double)L->panel[L->count] + 2 * sweep);
  return work->allowed > 0 && spent > work->allowed / 2 * sweep ? short_patience : rest_patience;
}

/* (AR2)-(AR6). Returns DLS_OK if the certificate of an x holds, DLS_STALLED, the reason for an end
 * by the caller, or an error. */
static dls_status rest_split(rest *work, const dls_contact *problem, dls_info *outcome,
                             dls_error *error) {
  const int d = work->d, nc = problem->nc, m = d * nc;
  double residual = INFINITY, *g = work->right, *apart = work->h;
  int regular, since = 0;
  dls_status status = dlsi_joints_create(&work->joints, problem, work->S, work->unit, error);
  if (!status) status = rest_foresee(work, problem, work->joints->factor);
  if (status) return status;
  memcpy(apart, work->q, (size_t)m * sizeof *apart);
  dlsi_joints_split(work->joints, apart, g);
  status = rest_first_metric(work, nc, &regular, outcome, error);
  memset(work->v, 0, (size_t)m * sizeof *work->v);
  for (int k = 0; !status; k++) {
    for (int c = 0; c < nc; c++) /* (AR2) */
      (void)dlsi_project_cone(d, 1, work->v + d * c, work->z + d * c);
    if (k > 0 && (k < measured_every || k % measured_every == 0)) {
      const double now = rest_offer(work, problem, work->z);
      if (dls_certificate_holds(&work->it.certificate, work->it.tol)) return DLS_OK;
      if (now < residual / 2) {
        residual = now;
        since = k;
      }
      if (k - since >= rest_patience_at(work, problem, outcome->factorisations, k) ||
          dlsi_certificate_meets(&work->it.certificate, work->it.tol))
        return DLS_STALLED; /* (AR6) */
    }
    if ((k == metric_after || k == 2 * metric_after) && !regular)
      status = rest_next_metric(work, nc, outcome, error);
    if (status) return status;
    for (int i = 0; i < m; i++) /* (AR3) */
      work->r[i] = 2 * work->z[i] - work->v[i] - apart[i] / work->rho[i / d];
    status = dlsi_joints_solve(work->joints, work->rho, work->r, g, work->x, error);
    for (int i = 0; i < m; i++) /* (AR4) */
      work->v[i] += (k < metric_after ? 1 : rest_relaxation) * (work->x[i] - work->z[i]);
    if (!status) status = rest_tell(work, outcome);
  }
  return status;
}

/* ---- interior point -------------------------------------------------------------------------- */

/* y := P^2 x for contact c; y is not x. */
static void rest_square(const rest *work, int c, const double *x, double *y) {
  const double *w = work->w + work->d * c;
  double v[3];
  dlsi_cone_scale(work->d, work->eta[c], w, 0, x, v);
  dlsi_cone_scale(work->d, work->eta[c], w, 0, v, y);
}

/* Factorises W + P^2 + delta at (x, z). DLS_STALLED if that fails. */
static dls_status rest_factor_point(rest *work, int nc, dls_info *outcome, dls_error *error) {
  const int d = work->d;
  size_t k = 0;
  for (int c = 0; c < nc; c++) {
    const double *x = work->x + d * c;
    double *w = work->w + d * c;
    if (!dlsi_cone_between(d, x, work->z + d * c, &work->eta[c], w)) return DLS_STALLED;
    dlsi_cone_scale(d, work->eta[c], w, 0, x, work->lambda + d * c);
    for (int j = 0; j < d; j++) {
      static const double e[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
      double column[3];
      rest_square(work, c, e[j], column);
      for (int i = j; i < d; i++)
        work->value[k++] = column[i] + (i == j ? proximal : 0);
    }
  }
  return rest_factor(work, outcome, error);
}

/* (AR7) Returns the largest step, at most 1e300. */
static dls_status rest_direction(rest *work, int nc, double *dx, double *dz, double *step,
                                 dls_error *error) {
  const int d = work->d;
  for (int c = 0; c < nc; c++) {
    const int o = d * c;
    double v[3];
    dlsi_cone_divide(d, work->lambda + o, work->rc + o, v);
    dlsi_cone_scale(d, work->eta[c], work->w + o, 0, v, work->h + o);
    for (int i = 0; i < d; i++)
      dx[o + i] = work->h[o + i] - work->right[o + i];
  }
  const dls_status status = dlsi_cholesky_solve(work->factor, dx, 1, error);
  *step = INFINITY;
  for (int c = 0; c < nc; c++) {
    const int o = d * c;
    rest_square(work, c, dx + o, dz + o);
    for (int i = 0; i < d; i++)
      dz[o + i] = work->h[o + i] - dz[o + i];
    *step = fmin(*step, fmin(dlsi_cone_step(d, work->x + o, dx + o),
                             dlsi_cone_step(d, work->z + o, dz + o)));
  }
  return status;
}

/* Sets rc of (AR8): second: 1 with the product of the affine direction. */
static void rest_set_target(rest *work, int nc, double target, int second) {
  dlsi_cone_target(work->d, nc, work->eta, work->w, work->lambda, target, second ? work->ax : NULL,
                   work->az, work->rc);
}

/* (AR8) */
static dls_status rest_step(rest *work, int nc, double tau, double *step, dls_error *error) {
  rest_set_target(work, nc, 0, 0);
  dls_status status = rest_direction(work, nc, work->ax, work->az, step, error);
  double sigma = fmax(pow(1 - fmin(*step, 1), 3), 1e-3);
  *step = 0;
  for (int second = 1; !status && second >= 0 && *step < short_step; second--) {
    if (!second) sigma = fmax(sigma, 0.5);
    rest_set_target(work, nc, sigma * tau, second);
    status = rest_direction(work, nc, work->dx, work->dz, step, error);
  }
  return status;
}

/* (AR7)-(AR10). Returns as rest_split does. */
static dls_status rest_interior(rest *work, const dls_contact *problem, dls_info *outcome,
                                dls_error *error) {
  const int d = work->d, nc = problem->nc, m = d * nc;
  dls_status status = rest_set_point(work, problem, error);
  if (!status) status = rest_foresee(work, problem, work->factor);
  for (int i = 0; i < m; i++)
    work->x[i] = work->z[i] = i % d == 0;
  for (int k = 0; !status && k < most_points; k++) {
    double tau = 0, step;
    for (int i = 0; i < m; i++)
      tau += work->x[i] * work->z[i] / nc;
    const double residual = rest_offer(work, problem, work->x);
    if (dls_certificate_holds(&work->it.certificate, work->it.tol)) return DLS_OK;
    if (!(tau > 0) || dlsi_certificate_meets(&work->it.certificate, work->it.tol))
      return DLS_STALLED;
    if (tau < slides_tau && tau < slides * residual * residual) return DLS_STALLED; /* (AR10) */
    rest_multiply(work, nc, work->x, work->right);
    for (int i = 0; i < m; i++)
      work->right[i] += work->q[i] - work->z[i];
    status = rest_factor_point(work, nc, outcome, error);
    if (!status) status = rest_step(work, nc, tau, &step, error);
    if (status) return status;
    if (!(step > least_step)) return DLS_STALLED;
    for (int i = 0; i < m; i++) { /* (AR9) */
      work->x[i] += fmin(1, to_boundary * step) * work->dx[i];
      work->z[i] += fmin(1, to_boundary * step) * work->dz[i];
    }
    status = rest_tell(work, outcome);
  }
  return status ? status : DLS_STALLED;
}

/* ---- in the table of auto -------------------------------------------------------------------- */

static dls_status rest_solve(void *rest_work, const dls_contact *problem, double *r, double *u,
                             dls_info *info, dls_error *error) {
  rest *work = rest_work;
  dlsi_iterate *it = &work->it;
  dls_info outcome = {.method = DLS_ADMM};
  dls_status status = DLS_OK;
  work->refused = 0;
  dlsi_iterate_begin(it, problem, NULL, work->limits.tol, work->limits.warm_start, r, work->r);
  if (!dlsi_iterate_start(it, problem, work->r)) {
    status = rest_set(work, problem);
    if (!status) status = rest_split(work, problem, &outcome, error);
    if (status == DLS_STALLED && outcome.factorisations > 0 && !(work->allowed > 0) &&
        !dlsi_certificate_meets(&it->certificate, it->tol)) {
      outcome.stages = 1; /* auto's report takes the name from here */
      outcome.stage[0].step = DLS_STEP_INTERIOR;
      status = rest_interior(work, problem, &outcome, error);
    }
    rest_forget_matrix(work);
  }
  return dlsi_iterate_end(it, problem, status, &outcome, r, u, info);
}

static void rest_carve(void *rest_work, dlsi_arena *arena) {
  rest *work = rest_work;
  const size_t nc = (size_t)work->nc, m = (size_t)work->d * nc;
  double **const vectors[] = {&work->S,  &work->q,  &work->x,      &work->z,  &work->v,
                              &work->dx, &work->dz, &work->ax,     &work->az, &work->w,
                              &work->h,  &work->rc, &work->lambda, &work->r,  &work->right};
  work->rho = dlsi_take(arena, nc, sizeof *work->rho);
  work->eta = dlsi_take(arena, nc, sizeof *work->eta);
  dlsi_take_vectors(arena, m, (int)(sizeof vectors / sizeof vectors[0]), vectors);
  dlsi_iterate_carve(&work->it, arena, work->d, work->nc, &work->limits);
}

static void rest_destroy(void *rest_work) {
  free(rest_work);
}

static dls_status rest_create(void **out, int d, int nc, const dlsi_options *options,
                              dls_error *error) {
  rest filled = {.limits = options->limits, .d = d, .nc = nc};
  return dlsi_workspace(out, &filled, sizeof filled, rest_carve, nc, error);
}

void dlsi_rest_allow(void *work, double sweeps) {
  ((rest *)work)->allowed = sweeps;
}

double dlsi_rest_refused(const void *work) {
  return ((const rest *)work)->refused;
}

/* A stage of auto only, without a number among the methods: it begins as a splitting. */
const dlsi_method dlsi_rest_method = {
    .method = DLS_ADMM,
    .name = "rest",
    .summary = "2D, 3D, W by blocks: structures at rest",
    .create = rest_create,
    .solve = rest_solve,
    .destroy = rest_destroy,
    .limits = offsetof(rest, limits),
};
