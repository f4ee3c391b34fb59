/*
 * lagrangian.c: the augmented Lagrangian on K, d = 2 and 3, for slender bodies: their contacts move
 * by far more than the local compliance.
 *
 * In round variables, with multipliers r and bounds R = mu max(0, r_n) of the previous step:
 *
 *   (AL1)  r+(x): r+_n = max(q_n, 0), r+_t = q_t put on the disc |.| <= R, q = r - rho u(x)
 *   (AL2)  x := argmin of  x^T K x / 2 - f^T x + (|r+_n|^2 + psi(q_t)) / (2 rho),
 *          psi = |q_t|^2 inside of the disc, 2 R |q_t| - R^2 outside
 *   (AL3)  r := r+(x), R := mu max(0, r_n), rho := 3 rho up to 100, and again until (x, r) is
 *          solved. rho starts at .03 of the local stiffness: soft contacts let edges move far
 *          in one step.
 *
 * (AL2) is convex, with the gradient K x - f - H r+. Newton steps with a line search solve it from
 * any start:
 *
 *   (AL4)  (K + H M H^T + E) dx = -gradient, M = -dr+/du: rho where q_n > 0, else 0, for the
 *          normal; rho inside of the disc, rho R/|q_t| (1 - t t^T), t = q_t/|q_t|, outside
 *   (AL5)  x := x + t dx, t <= 1 where the slope along dx vanishes; the slope grows with t, and
 *          costs only products with H
 *   (AL6)  Ends if three steps go down forever: nothing holds the body, or not with these bounds.
 *
 * A is factored when M has changed: in most steps until the states stand still. Open contacts have
 * no spring in (AL4) and move at once. The splitting needs the more iterations the softer they are:
 * this method is for that case.
 *
 * Source: Simo and Laursen, Comput. Struct. 42, 1992, 97-116. Unlike theirs the bounds are lagged,
 * which keeps (AL4) symmetric; augmented.c is the same on W. Also ends after 200 steps, or when
 * three multipliers in a row have not halved the residual. Needs K symmetric and A definite.
 * Cost: a factor a step, 40 to 60 for strips of 1,000 elements, 120 for 3,000.
 */
#include <stdlib.h>
#include <string.h>

#include "global_internal.h"

enum { most_steps = 200, patience = 3, most_cuts = 60 };

static const double first_rho = 0.03, growth = 3, most_rho = 100; /* (AL3) */
static const double enough = 0.1;   /* (AL2) ends at |gradient| below this fraction of tol .. */
static const double inexact = 0.01; /* .. or of the last residual */
static const double flat = 1e-3;    /* (AL5): slope over the one at t = 0 */
static const double far = 1e3;      /* (AL6) */

typedef struct lagrangian {
  dls_global *global;
  int most, steps;
  int runs; /* steps that (AL6) counts */
  double rho;
  double *r, *R;               /* multipliers, m; bounds, nc */
  double *M, *old;             /* (AL4) now and of the factor, 4 nc */
  double *plus;                /* r+, m */
  double *gradient, *dx, *Kdx; /* n */
  double *du;                  /* m */
} lagrangian;

/* (AL1), and (AL4) if M is not NULL. */
static void lagrangian_react(const lagrangian *L, const double *u, double *plus, double *M) {
  const dls_global *work = L->global;
  const int d = work->d;
  for (int c = 0; c < work->nc; c++) {
    const double *r = L->r + d * c, *uc = u + d * c, R = L->R[c];
    double q[3] = {0}, *to = plus + d * c;
    for (int i = 0; i < d; i++)
      q[i] = r[i] - L->rho * uc[i];
    const double size = dlsi_tangent_norm(d, q), scale = size > R ? R / size : 1;
    to[0] = q[0] > 0 ? q[0] : 0;
    for (int i = 1; i < d; i++)
      to[i] = scale * q[i];
    if (!M) continue;
    const int slips = size > R;
    double *block = M + 4 * c;
    block[0] = q[0] > 0 ? L->rho : 0;
    for (int i = 1; i < 3; i++)
      block[i] = L->rho * scale * (slips ? 1 - q[i] / size * (q[i] / size) : 1);
    if (slips && d == 2) block[1] = 0;
    block[3] = slips ? -L->rho * scale * (q[1] / size) * (q[2] / size) : 0;
  }
}

/* gradient := K x - f - H r+; returns its size over that of f and H r+. */
static double lagrangian_gradient(lagrangian *L) {
  dls_global *work = L->global;
  const size_t n = (size_t)work->n;
  double *y = work->y;
  for (size_t j = 0; j < n; j++)
    y[j] = work->f ? work->f[j] : 0;
  const double load = dlsi_norm2(y, n);
  memset(L->dx, 0, n * sizeof *y);
  dlsi_global_push(work, L->plus, L->dx);
  const double pushed = dlsi_norm2(L->dx, n);
  dlsi_body_multiply(&work->model, work->x, L->gradient, NULL);
  for (size_t j = 0; j < n; j++)
    L->gradient[j] -= y[j] + L->dx[j];
  return dlsi_norm2(L->gradient, n) / (load + pushed);
}

static double inner(const double *a, const double *b, int n) {
  double sum = 0;
  for (int k = 0; k < n; k++)
    sum += a[k] * b[k];
  return sum;
}

/* Returns the slope along dx at t: gradient^T dx + t dx^T K dx - (r+(u + t du) - r+(u))^T du. */
static double lagrangian_slope(const lagrangian *L, double t) {
  const dls_global *work = L->global;
  for (int k = 0; k < work->m; k++)
    work->look[k] = work->u[k] + t * L->du[k];
  lagrangian_react(L, work->look, work->before, NULL);
  return inner(L->gradient, L->dx, work->n) + t * inner(L->Kdx, L->dx, work->n) -
         (inner(work->before, L->du, work->m) - inner(L->plus, L->du, work->m));
}

/* (AL5) Returns t, at most 1. */
static double lagrangian_search(lagrangian *L) {
  const double small = flat * fabs(inner(L->gradient, L->dx, L->global->n));
  double low = 0, high = 1, t = 1;
  for (int cut = 0; cut < most_cuts; cut++) {
    const double slope = lagrangian_slope(L, t);
    if (fabs(slope) <= small) break;
    if (slope < 0 && t == 1) { /* downhill to the end of the step */
      L->runs += lagrangian_slope(L, far) < -small;
      break;
    }
    *(slope < 0 ? &low : &high) = t;
    t = (low + high) / 2;
  }
  return t;
}

/* (AL4), (AL5) */
static dls_status lagrangian_step(lagrangian *L, dls_error *error) {
  dls_global *work = L->global;
  const size_t n = (size_t)work->n, m = (size_t)work->m, blocks = 4 * (size_t)work->nc;
  if (L->steps == 0 || memcmp(L->M, L->old, blocks * sizeof *L->M) != 0) {
    memcpy(L->old, L->M, blocks * sizeof *L->M);
    work->factorisations++;
    const dls_status status = dlsi_system_factor_weighted(work->system, L->M, error);
    if (status) return status;
  }
  for (size_t j = 0; j < n; j++)
    L->dx[j] = -L->gradient[j];
  const dls_status status = dlsi_system_solve(work->system, L->dx, error);
  if (status) return status;
  dlsi_body_multiply(&work->model, L->dx, L->Kdx, NULL);
  dlsi_global_look(work, L->dx, L->du);
  for (size_t k = 0; k < m; k++)
    L->du[k] -= work->g[k];
  const double t = lagrangian_search(L);
  for (size_t j = 0; j < n; j++)
    work->x[j] += t * L->dx[j];
  dlsi_global_look(work, work->x, work->u);
  return DLS_OK;
}

/* Reports a step. */
static dls_status lagrangian_tell(const lagrangian *L) {
  const dls_global *work = L->global;
  return dlsi_tell(work->limits, work->begun,
                   &(dls_progress){.method = "global",
                                   .stage = "lagrangian",
                                   .iteration = L->steps,
                                   .max_iterations = L->most,
                                   .residual = work->best.residual,
                                   .r = work->best_r});
}

/* (AL2) until the gradient is at most `goal`. */
static dls_status lagrangian_minimise(lagrangian *L, double goal, dls_error *error) {
  dls_global *work = L->global;
  while (L->steps < L->most && L->runs < patience) {
    lagrangian_react(L, work->u, L->plus, L->M);
    if (lagrangian_gradient(L) <= goal) return DLS_OK;
    dls_status status = lagrangian_step(L, error);
    L->steps++;
    work->iterations++;
    if (!status) status = lagrangian_tell(L);
    if (status) return status;
  }
  lagrangian_react(L, work->u, L->plus, L->M);
  return DLS_OK;
}

static dls_status lagrangian_iterate(lagrangian *L, dls_error *error) {
  dls_global *work = L->global;
  const int d = work->d;
  double least = INFINITY, last = 1;
  for (int slow = 0; slow < patience && L->steps < L->most && L->runs < patience;) {
    for (int c = 0; c < work->nc; c++)
      L->R[c] = dlsi_friction_bound(work->bend[c], L->r[d * c]);
    dls_certificate now;
    dls_status status =
        lagrangian_minimise(L, fmax(enough * work->limits->tol, inexact * last), error);
    if (status) return status;
    memcpy(L->r, L->plus, (size_t)work->m * sizeof *L->r);
    dlsi_put_on_discs(d, work->nc, work->bend, L->r, work->before);
    status = dlsi_global_measure(work, work->before, &now);
    if (status != DLS_STALLED) return status;
    const double badness = dlsi_body_badness(&now);
    if (!(badness <= DBL_MAX)) break;
    slow = badness < least / 2 ? 0 : slow + 1;
    least = fmin(badness, least);
    last = fmin(badness, 1);
    L->rho = fmin(growth * L->rho, most_rho);
  }
  return DLS_STALLED;
}

dls_status dlsi_global_lagrangian(dls_global *work, const double *r, int most, dls_error *error) {
  const size_t n = (size_t)work->n, m = (size_t)work->m;
  double *all = dlsi_alloc(3 * n + 3 * m + 9 * (size_t)work->nc, sizeof *all);
  if (!all) return dlsi_no_memory(error);
  double *const of_m = all + 3 * n;
  lagrangian L = {.global = work,
                  .most = most < most_steps ? most : most_steps,
                  .dx = all,
                  .Kdx = all + n,
                  .gradient = all + 2 * n,
                  .rho = first_rho,
                  .r = of_m,
                  .plus = of_m + m,
                  .du = of_m + 2 * m,
                  .M = of_m + 3 * m,
                  .old = of_m + 3 * m + 4 * (size_t)work->nc,
                  .R = of_m + 3 * m + 8 * (size_t)work->nc};
  dls_error why = {0};
  memcpy(L.r, r, m * sizeof *L.r);
  dlsi_global_look(work, work->x, work->u);
  dls_status status = lagrangian_iterate(&L, &why);
  free(all);
  if (status == DLS_E_SINGULAR) return DLS_STALLED;
  if (status < 0 && error) *error = why;
  return status;
}
