/*
 * homotopy.c: interior homotopy by arc length, d = 2 and 3, for small problems on which other
 * methods fail.
 *
 * Unknowns: r_c = b k_c (x_n / mu, x_t). k_c gives the blocks of the scaled W a mean diagonal of 1,
 * b makes the largest entry of the scaled q 1. Friction cones become the Lorentz cone K = { x :
 * x_n >= |x_t| }, which is its own dual. With z the scaled u + mu |u_t| n the problem is: x and z
 * in K, x.z = 0, and
 *
 *   (HO1)  W x + q + t p + (s_c - t c) e = z,   s_c = sqrt(|z_t|^2 + (t c)^2),   e = (1, 0[, 0])
 *   (HO2)  x o z = t a b e,                     x o z = (x.z, x_n z_t + z_n x_t)
 *
 * at t = 0. At t = 1 the solution is x = a e, z = b e, which defines p. Under large friction the
 * path between the two has folds: t rises again on parts of it, and methods that only reduce t get
 * stuck there. So the path is followed by its arc length.
 *
 *   (HO3)  scaling of Nesterov and Todd per contact: P symmetric, lambda = P x = P^-1 z
 *   (HO4)  a direction for residuals rho of (HO1), rc of (HO2), G = I - e g', g = (0, z_t / s):
 *          (W + G P^2) dx = G h - rho,  dz = h - P^2 dx,  h = P (lambda \ rc);  LU, one refinement
 *   (HO5)  tangent: (HO4) for the derivatives by log t. t falls while the determinant of (HO4) has
 *          its sign at t = 1, else it rises
 *   (HO6)  predictor along the tangent, up to 0.95 of the distance to the boundary of the cones;
 *          corrector: up to 5 Newton steps for (HO1), (HO2), orthogonal to the tangent in the norm
 *          |P dx|^2 + |P^-1 dz|^2, until rc < t a b / 5 and rho < t |p| / 5. The step is
 *          multiplied by 3 after 0 or 1 corrections, divided by 1.5 after 3 or 4, by 3 on failure
 *   (HO7)  once t < 1e-2, then at every tenth of t, Newton's method (newton.c) starts from x: an
 *          interior point alone ends at a residual of about sqrt(t)
 *
 *   (HO8)  Several starts are tried, because no single one reaches all solutions: ten pairs (a, b),
 *          then x_c = a f_c e, z_c = e / f_c with a near 1 and f_c between 1/64 and 64, drawn for
 *          each contact and start: factors by a rule from the contact's number are too similar. A
 *          path to a solution is usually short, so many starts find more than long paths: the ten
 *          get 500 factorisations each, the others 250. auto takes an eighth of them first, and the
 *          rest after other methods
 *
 * Source: the scaling and the algebra of second-order cones as in Alizadeh and Goldfarb, Math.
 * Program. 95, 2003, 3-51; the turn by the sign of the determinant as in Allgower and Georg,
 * Numerical Continuation Methods, 1990, 2.1.
 * Cost: a LU of m x m per tangent and per correction, some hundred to a thousand of them. Memory:
 * 2 m^2 doubles and those of Newton's method.
 * What can fail: the path returns to t > 1, or x grows without bound, although there is a solution;
 * neither proves anything. For W positive definite x is bounded on 0 <= t <= 1.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "linear/dense.h"
#include "linear/pieces.h"
#include "vi/cone.h"
#include "vi/vi_internal.h"

enum {
  factorisations_per_row = 3000, /* of all starts: more rows have more states */
  least_factorisations = 3000,
  first_factorisations = 500,
  most_factorisations = 250
};
enum { most_cuts = 12, most_corrections = 5 };
static const double most_cubes = 8e10;  /* m^3 times the factorisations of all starts */
static const double smoothing = 0.1;    /* c of (HO1) */
static const double nearness = 0.2;     /* (HO6) */
static const double to_boundary = 0.95; /* (HO6) */
static const double longest = 3;        /* step in log t */
static const double least_t = 1e-14, most_t = 1e8;
static const double finish_t = 1e-2; /* (HO7) */

static const double starts[][2] = {{1, 1},  {0.05, 1}, {1, 0.05}, {1e-3, 1},  {20, 1},
                                   {1, 20}, {0.2, 1},  {5, 1},    {0.1, 0.1}, {10, 10}};
enum { start_count = sizeof starts / sizeof starts[0], most_starts = 10000 };

typedef struct homotopy {
  dls_limits limits;
  int d, nc;
  dls_newton *newton;
  double *W, *M;             /* m x m: the scaled W; the matrix of (HO4) and its factors */
  int *pivot;                /* m */
  double *S;                 /* m: scales, r = b S x */
  double *q, *p;             /* m: scaled q; (HO1) */
  double *x, *z, *tx, *tz;   /* m: point of the path, its tangent */
  double *x1, *z1;           /* m: point of the corrector */
  double *cx, *cz, *vx, *vz; /* m: correction, derivative by log t */
  double *w, *eta;           /* m, nc: (HO3), P is that of w times eta */
  double *lambda, *g;        /* m: (HO3), (HO4) */
  double *rho, *rc;          /* m */
  double *h, *y, *right;     /* m: scratch of (HO4) */
  double *r;                 /* m */
  double b, t, t1, tau;      /* tau: a b of the start */
  int sign;                  /* of the determinant of the matrix factorised last */
  int factorisations;
  dlsi_iterate it;
} homotopy;

/* ---- the matrix ------------------------------------------------------------------------------ */

/* y := alpha W x + beta y */
static void multiply_W(const homotopy *work, int m, double alpha, const double *x, double beta,
                       double *y) {
  dlsi_gemv(dlsi_is_small((size_t)m * (size_t)m), m, m, alpha, work->W, x, beta, y);
}

/* y := M x = W x + G P^2 x */
static void multiply_matrix(const homotopy *work, int nc, const double *x, double *y) {
  const int d = work->d, m = d * nc;
  multiply_W(work, m, 1, x, 0, y);
  for (int c = 0; c < nc; c++) {
    const double *w = work->w + d * c;
    double v[3], Pv[3];
    dlsi_cone_scale(d, work->eta[c], w, 0, x + d * c, v);
    dlsi_cone_scale(d, work->eta[c], w, 0, v, Pv);
    Pv[0] -= dlsi_cone_dot(d, work->g + d * c, Pv);
    for (int i = 0; i < d; i++)
      y[d * c + i] += Pv[i];
  }
}

/* (HO3) for the point (x, z); returns 0 if it is not inside the cones. */
static int scale_point(homotopy *work, const dls_contact *problem, const double *x,
                       const double *z) {
  const int d = work->d;
  for (int c = 0; c < problem->nc; c++) {
    const double *xc = x + d * c, *zc = z + d * c;
    double *w = work->w + d * c;
    if (!dlsi_cone_between(d, xc, zc, &work->eta[c], w)) return 0;
    dlsi_cone_scale(d, work->eta[c], w, 0, xc, work->lambda + d * c);
  }
  return 1;
}

/* Factorises the matrix of (HO4) at (x, z, t). Returns 0 if it cannot. */
static int factorise(homotopy *work, const dls_contact *problem, const double *x, const double *z,
                     double t) {
  const int d = work->d, m = d * problem->nc;
  const size_t n = (size_t)m;
  if (!scale_point(work, problem, x, z)) return 0;
  memcpy(work->M, work->W, n * n * sizeof *work->M);
  for (int c = 0; c < problem->nc; c++) {
    const double *zc = z + d * c, zt = dlsi_tangent_norm(d, zc), s = hypot(zt, t * smoothing);
    double *g = work->g + d * c;
    g[0] = 0;
    for (int i = 1; i < d; i++)
      g[i] = problem->mu[c] > 0 ? zc[i] / s : 0;
    for (int j = 0; j < d; j++) {
      double e[3] = {0}, v[3], column[3];
      e[j] = 1;
      dlsi_cone_scale(d, work->eta[c], work->w + d * c, 0, e, v);
      dlsi_cone_scale(d, work->eta[c], work->w + d * c, 0, v, column);
      column[0] -= dlsi_cone_dot(d, g, column);
      for (int i = 0; i < d; i++)
        work->M[(size_t)(d * c + i) + (size_t)(d * c + j) * n] += column[i];
    }
  }
  dlsi_dense factors = {.n = m, .A = work->M, .pivot = work->pivot};
  work->factorisations++;
  if (dlsi_dense_lu(&factors)) return 0;
  work->sign = 1;
  for (int i = 0; i < m; i++) {
    const double u = work->M[(size_t)i * (n + 1)];
    if (!isfinite(u)) return 0;
    if ((u < 0) != (work->pivot[i] != i + 1)) work->sign = -work->sign;
  }
  return 1;
}

/* (HO4) Solves for work->rho, work->rc with the matrix factorised last. */
static void solve_direction(homotopy *work, int nc, double *dx, double *dz) {
  const int d = work->d, m = d * nc;
  const dlsi_dense factors = {.n = m, .A = work->M, .pivot = work->pivot};
  double *h = work->h, *right = work->right, *y = work->y;
  for (int c = 0; c < nc; c++) {
    const int o = d * c;
    double v[3];
    dlsi_cone_divide(d, work->lambda + o, work->rc + o, v);
    dlsi_cone_scale(d, work->eta[c], work->w + o, 0, v, h + o);
    for (int i = 0; i < d; i++)
      right[o + i] = h[o + i] - work->rho[o + i];
    right[o] -= dlsi_cone_dot(d, work->g + o, h + o);
  }
  memcpy(dx, right, (size_t)m * sizeof *dx);
  dlsi_dense_solve(&factors, dx, m, 1);
  multiply_matrix(work, nc, dx, y);
  for (int i = 0; i < m; i++)
    y[i] = right[i] - y[i];
  dlsi_dense_solve(&factors, y, m, 1);
  for (int i = 0; i < m; i++)
    dx[i] += y[i];
  for (int c = 0; c < nc; c++) {
    const int o = d * c;
    double v[3], Pv[3];
    dlsi_cone_scale(d, work->eta[c], work->w + o, 0, dx + o, v);
    dlsi_cone_scale(d, work->eta[c], work->w + o, 0, v, Pv);
    for (int i = 0; i < d; i++)
      dz[o + i] = h[o + i] - Pv[i];
  }
}

/* Sets rho, rc to the residuals of (HO1), (HO2) at (x1, z1, t1), for which the matrix was
 * factorised. Returns the larger relative one, as (HO6) compares it; NaN stays. */
static double set_residuals(homotopy *work, const dls_contact *problem) {
  const int d = work->d, m = d * problem->nc;
  const double t = work->t1, product = t * work->tau;
  double *rho = work->rho, *rc = work->rc;
  for (int i = 0; i < m; i++)
    rho[i] = work->q[i] + t * work->p[i] - work->z1[i];
  multiply_W(work, m, 1, work->x1, 1, rho);
  for (int c = 0; c < problem->nc; c++) {
    const int o = d * c;
    const double zt = dlsi_tangent_norm(d, work->z1 + o);
    if (problem->mu[c] > 0) rho[o] += hypot(zt, t * smoothing) - t * smoothing;
    dlsi_cone_product(d, work->lambda + o, work->lambda + o, rc + o);
    for (int i = 0; i < d; i++)
      rc[o + i] = (i ? 0 : product) - rc[o + i];
  }
  const double size = fmax(dlsi_max_abs(work->p, (size_t)m), 1e-3);
  const double a = dlsi_max_abs(rho, (size_t)m) / (t * size);
  const double b = dlsi_max_abs(rc, (size_t)m) / product;
  return a != a || a > b ? a : b;
}

/* Sets rho, rc to the derivatives by log t of (HO1), (HO2) at a point (.., z, t). */
static void set_derivatives(homotopy *work, const dls_contact *problem, const double *z, double t) {
  const int d = work->d;
  for (int c = 0; c < problem->nc; c++) {
    const int o = d * c;
    const double s = hypot(dlsi_tangent_norm(d, z + o), t * smoothing);
    for (int i = 0; i < d; i++) {
      work->rho[o + i] = t * work->p[o + i];
      work->rc[o + i] = i ? 0 : t * work->tau;
    }
    if (problem->mu[c] > 0) work->rho[o] += t * smoothing * (t * smoothing / s - 1);
  }
}

/* Returns the product of (ax, az) and (bx, bz) in the local norm of (HO6), over t a b nc. */
static double local_product(const homotopy *work, int nc, double t, const double *ax,
                            const double *az, const double *bx, const double *bz) {
  const int d = work->d;
  double sum = 0;
  for (int c = 0; c < nc; c++) {
    const int o = d * c;
    const double eta = work->eta[c], *w = work->w + o;
    double u[3], v[3];
    dlsi_cone_scale(d, eta, w, 0, ax + o, u);
    dlsi_cone_scale(d, eta, w, 0, bx + o, v);
    sum += dlsi_cone_dot(d, u, v);
    dlsi_cone_scale(d, eta, w, 1, az + o, u);
    dlsi_cone_scale(d, eta, w, 1, bz + o, v);
    sum += dlsi_cone_dot(d, u, v);
  }
  return sum / (t * work->tau * nc);
}

/* Returns the largest step along (dx, dz) that stays in the cones. */
static double largest_step(const homotopy *work, int nc, const double *x, const double *dx,
                           const double *z, const double *dz) {
  double a = INFINITY;
  for (int c = 0; c < nc; c++) {
    const int o = work->d * c;
    a = fmin(a,
             fmin(dlsi_cone_step(work->d, x + o, dx + o), dlsi_cone_step(work->d, z + o, dz + o)));
  }
  return a;
}

/* ---- the path -------------------------------------------------------------------------------- */

/* Fills W, q, S, b. Returns 0 if W has no diagonal or q = 0. */
static int scale_problem(homotopy *work, const dls_contact *problem) {
  const int d = work->d, nc = problem->nc, m = d * nc;
  const double unit = dlsi_cone_scales(problem, work->eta, work->S);
  memset(work->W, 0, (size_t)m * (size_t)m * sizeof *work->W);
  for (int c = 0; c < nc; c++)
    for (int j = 0; j < d; j++) {
      double e[3] = {0}, *column = work->W + (size_t)(d * c + j) * (size_t)m;
      e[j] = work->S[d * c + j];
      dlsi_contact_add_columns(problem, c, e, column);
      for (int i = 0; i < m; i++)
        column[i] *= work->S[i] / unit;
    }
  for (int i = 0; i < m; i++)
    work->q[i] = work->S[i] * problem->q[i];
  const double size = dlsi_max_abs(work->q, (size_t)m);
  if (!(size > 0 && unit > 0)) return 0;
  for (int i = 0; i < m; i++)
    work->q[i] /= size;
  work->b = size / unit;
  return 1;
}

/* Sets the point at t = 1 for start k (HO8), and p by (HO1). */
static void begin_path(homotopy *work, int nc, int k) {
  const int d = work->d, m = d * nc;
  const int drawn = k >= start_count;
  const double a = drawn ? pow(10, dlsi_draw_entry(k, nc) - 0.5) : starts[k][0];
  const double b = drawn ? 1 : starts[k][1];
  for (int i = 0; i < m; i++) {
    const double f = drawn ? exp2(12 * dlsi_draw_entry(k, i / d) - 6) : 1;
    work->x[i] = i % d ? 0 : a * f;
    work->z[i] = i % d ? 0 : b / f;
    work->p[i] = work->z[i] - work->q[i];
  }
  multiply_W(work, m, -1, work->x, 1, work->p);
  work->tau = a * b;
  work->t = 1;
}

/* Corrector of (HO6), from (x1, z1, t1). Returns the number of corrections, -1 if it failed; then
 * the matrix is not that of the point. */
static int correct(homotopy *work, const dls_contact *problem, double tt) {
  const int nc = problem->nc, m = work->d * nc;
  double before = INFINITY;
  for (int k = 0; k < most_corrections; k++) {
    if (!factorise(work, problem, work->x1, work->z1, work->t1)) return -1;
    const double now = set_residuals(work, problem);
    if (!isfinite(now) || (k > 0 && now > 2 * before)) return -1;
    if (now < nearness) return k;
    before = now;
    solve_direction(work, nc, work->cx, work->cz);
    set_derivatives(work, problem, work->z1, work->t1);
    solve_direction(work, nc, work->vx, work->vz);
    const double t = work->t1;
    const double c = local_product(work, nc, t, work->cx, work->cz, work->tx, work->tz);
    const double v = local_product(work, nc, t, work->vx, work->vz, work->tx, work->tz) + tt;
    const double dl = v == 0 ? 0 : fmax(-.5, fmin(.5, -c / v));
    for (int i = 0; i < m; i++) {
      work->cx[i] += dl * work->vx[i];
      work->cz[i] += dl * work->vz[i];
    }
    const double most = largest_step(work, nc, work->x1, work->cx, work->z1, work->cz);
    const double a = fmin(1, to_boundary * most);
    for (int i = 0; i < m; i++) {
      work->x1[i] += a * work->cx[i];
      work->z1[i] += a * work->cz[i];
    }
    work->t1 *= 1 + a * dl;
  }
  return -1;
}

/* Takes one step of (HO6) of length *step, which is adapted. Returns 0 if none could be taken. */
static int take_step(homotopy *work, const dls_contact *problem, double tt, double norm,
                     double *step) {
  const int nc = problem->nc, m = work->d * nc;
  const double most = largest_step(work, nc, work->x, work->tx, work->z, work->tz);
  *step = fmin(*step, longest * norm);
  for (int cut = 0; cut < most_cuts; cut++) {
    const double a = fmin(fmin(*step / norm, 0.9 * most), longest);
    const double f = fmin(fabs(exp(tt * a) - 1), to_boundary * most);
    for (int i = 0; i < m; i++) {
      work->x1[i] = work->x[i] + f * work->tx[i];
      work->z1[i] = work->z[i] + f * work->tz[i];
    }
    work->t1 = work->t * (1 + tt * f);
    const int corrections = correct(work, problem, tt);
    if (corrections >= 0) {
      memcpy(work->x, work->x1, (size_t)m * sizeof *work->x);
      memcpy(work->z, work->z1, (size_t)m * sizeof *work->z);
      work->t = work->t1;
      *step *= corrections <= 1 ? 3 : corrections >= 3 ? 1 / 1.5 : 1;
      return 1;
    }
    *step = fmin(*step, a * norm) / 3;
  }
  return 0;
}

/* Offers the r of the point and, once t < 1e-2, the result of Newton's method from it (HO7). */
static dls_status offer_point(homotopy *work, const dls_contact *problem, double *tried,
                              dls_error *error) {
  const int m = work->d * problem->nc;
  for (int i = 0; i < m; i++)
    work->r[i] = work->b * work->S[i] * work->x[i];
  (void)dlsi_iterate_offer(&work->it, problem, work->r);
  if (!(work->t < finish_t && work->t < *tried / 10)) return DLS_OK;
  *tried = work->t;
  dls_info info = {.factorisations = 0};
  const dls_limits steps = {.tol = work->limits.tol,
                            .warm_start = 1,
                            .cpu_seconds = dlsi_clock_left(&work->limits, work->it.begun)};
  dlsi_set_limits(&dlsi_newton_method, work->newton, &steps);
  const dls_status status =
      dlsi_newton_method.solve(work->newton, problem, work->r, NULL, &info, error);
  if (status < 0) return status;
  work->factorisations += info.factorisations;
  (void)dlsi_iterate_offer(&work->it, problem, work->r);
  return DLS_OK;
}

/* Follows the path of start k. Returns DLS_OK if the certificate holds, DLS_STALLED,
 * DLS_CANCELLED, an error. */
static dls_status follow_path(homotopy *work, const dls_contact *problem, int k, dls_info *outcome,
                              dls_error *error) {
  const int nc = problem->nc, m = work->d * nc;
  double step = 0.5, tried = INFINITY;
  int first = 0;
  const int most = k < start_count ? first_factorisations : most_factorisations;
  const int budget = work->factorisations + most;
  begin_path(work, nc, k);
  if (!factorise(work, problem, work->x, work->z, work->t)) return DLS_STALLED;
  while (work->factorisations < budget) {
    set_derivatives(work, problem, work->z, work->t); /* (HO5) */
    solve_direction(work, nc, work->tx, work->tz);
    if (!first) first = work->sign;
    const double tt = work->sign == first ? -1 : 1;
    for (int i = 0; i < m; i++) {
      work->tx[i] *= tt;
      work->tz[i] *= tt;
    }
    const double norm =
        sqrt(1 + local_product(work, nc, work->t, work->tx, work->tz, work->tx, work->tz));
    if (!isfinite(norm) || !take_step(work, problem, tt, norm, &step)) return DLS_STALLED;
    outcome->iterations++;
    const dls_status status = offer_point(work, problem, &tried, error);
    if (status) return status;
    const dls_certificate *best = &work->it.certificate;
    if (dls_certificate_holds(best, work->limits.tol)) return DLS_OK;
    const dls_status stop = dlsi_iterate_tell(&work->it, "homotopy", outcome->iterations, 0,
                                              best->residual, work->it.best);
    if (stop) return stop;
    if (work->limits.max_iterations && outcome->iterations >= work->limits.max_iterations)
      return DLS_MAX_ITERATIONS;
    if (!(work->t > least_t && work->t < most_t)) return DLS_STALLED;
  }
  return DLS_STALLED;
}

static dls_status homotopy_solve(void *homotopy_work, const dls_contact *problem, double *r,
                                 double *u, dls_info *info, dls_error *error) {
  homotopy *work = homotopy_work;
  dls_info outcome = {.method = DLS_HOMOTOPY};
  work->factorisations = 0;
  dlsi_iterate_begin(&work->it, problem, NULL, work->limits.tol, work->limits.warm_start, r,
                     work->r);
  dls_status status = dlsi_iterate_start(&work->it, problem, work->r) ? DLS_OK : DLS_STALLED;
  const int begins = status && scale_problem(work, problem);
  const double m = (double)work->d * problem->nc;
  const double most =
      fmax(least_factorisations, fmin(factorisations_per_row * m, most_cubes / (m * m * m)));
  for (int k = 0; begins && status == DLS_STALLED && k < most_starts && work->factorisations < most;
       k++)
    status = follow_path(work, problem, k, &outcome, error);
  if (status < 0) return status;
  outcome.factorisations = work->factorisations;
  return dlsi_iterate_end(&work->it, problem, status, &outcome, r, u, info);
}

/* ---- create ---------------------------------------------------------------------------------- */

static void homotopy_carve(void *homotopy_work, dlsi_arena *arena) {
  homotopy *work = homotopy_work;
  const size_t D = sizeof(double), nc = (size_t)work->nc, m = (size_t)work->d * nc;
  double **const vectors[] = {&work->S,  &work->q,  &work->p,      &work->x,  &work->z,   &work->tx,
                              &work->tz, &work->x1, &work->z1,     &work->cx, &work->cz,  &work->vx,
                              &work->vz, &work->w,  &work->lambda, &work->g,  &work->rho, &work->rc,
                              &work->h,  &work->y,  &work->right,  &work->r};
  work->W = dlsi_take(arena, m, m * D);
  work->M = dlsi_take(arena, m, m * D);
  work->pivot = dlsi_take(arena, m, sizeof *work->pivot);
  work->eta = dlsi_take(arena, nc, D);
  dlsi_take_vectors(arena, m, (int)(sizeof vectors / sizeof vectors[0]), vectors);
  dlsi_iterate_carve(&work->it, arena, work->d, work->nc, &work->limits);
}

static void homotopy_destroy(void *homotopy_work) {
  homotopy *work = homotopy_work;
  if (!work) return;
  dls_newton_destroy(work->newton);
  free(work);
}

static dls_status homotopy_create(void **out, int d, int nc, const dlsi_options *options,
                                  dls_error *error) {
  homotopy filled = {.limits = options->limits, .d = d, .nc = nc};
  void *memory;
  dls_status status = dlsi_workspace(&memory, &filled, sizeof filled, homotopy_carve, nc, error);
  if (status) return status;
  homotopy *work = memory;
  dls_newton_settings steps;
  dls_newton_settings_init(&steps);
  steps.sweeps = 0;
  steps.line_search = 1;
  steps.limits.warm_start = 1;
  steps.limits.blocks = options->limits.blocks;
  status = dlsi_newton_create(&work->newton, d, nc, &steps, options->room, error);
  if (status) {
    homotopy_destroy(work);
    return status;
  }
  dlsi_newton_anew(work->newton);
  *out = work;
  return DLS_OK;
}

const dlsi_method dlsi_homotopy_method = {
    .method = DLS_HOMOTOPY,
    .name = "homotopy",
    .summary = "2D, 3D, up to some 300 rows: where all others fail; slow",
    .create = homotopy_create,
    .solve = homotopy_solve,
    .destroy = homotopy_destroy,
    .limits = offsetof(homotopy, limits),
};
