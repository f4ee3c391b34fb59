/*
 * least.c: the smallest of all reactions that belong to the same positions.
 *
 * If W is singular, u = W r + q may belong to many r. For a given u the laws leave a convex set:
 *
 *   (LS1)  W r = W r*,  r_c in K_c:   K_c = 0                       where u_n > 0
 *                                           the ray (1, -mu u_t / |u_t|)   where u_t is not 0
 *                                           the friction cone              where u = 0
 *
 * One r of this set has the least |r|, |r|^2 = sum of w_c |r_c|^2: the reactions of rigid bodies on
 * springs of compliance w_c. P is the projection on all K_c, D = diag(w_c), s the force of the
 * springs without the laws, y = 0 at first. The proximal method of multipliers:
 *
 *   (LS2)  r = P(s),  s = y - D^-1 W (r - r*) / eps              then y := s, until W r = W r*
 *
 * as y stays in the range of D^-1 W and r = P(y) solves (LS1) at the end. Newton's method finds an
 * s of (LS2) from g(z) = z - (r - r*), s = y - D^-1 W z / eps, r = P(s). With B B^T the derivative
 * of P in the scale D^1/2, and E its columns B in (SM3) of vi/newton/states_matrix.c,
 *
 *   (LS3)  (E^T W E + eps diag(w) + L) t = -E^T W g,   dz = -g - E t,   l = eps w (1/tau - 1),
 *          tau = |r_t| / |s_t| at the surface of a cone, d = 3
 *   (LS4)  z + a dz, a = 1, 1/2, ...: psi = z.W z / (2 eps) + |r|^2 / 2 + r*.W z / eps, whose
 *          gradient is W g / eps, has to fall
 *   (LS5)  before: r* := r* - E A^-1 R u in the states of u reduces R u to rounding; after:
 *          r := P(r - E A^-1 E^T W (r - r*)) does the same for W (r - r*)
 *
 * A semismooth Newton method for a proximal point is that of Li, Sun and Toh (SIAM J. Optim. 28,
 * 2018, 433-458).
 *
 * Cost: 2 to 15 steps, each one Cholesky factorisation of the unknowns of contacts that carry; less
 * for a step that changes no branch. What can fail: positions so near a border of states that their
 * rounding decides; then r stays unchanged.
 */
#include "facts/least.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "facts/facts.h"
#include "vi/newton/states_matrix.h"

enum { outer_steps = 10, newton_steps = 100, most_halvings = 30, refinements = 4 };
static const double eps = 1e-6;        /* of (LS2): its rounding is DBL_EPSILON / eps */
static const double inner = 1e-9;      /* |g| over |r*| */
static const double outer = 1e-7;      /* |W (r - r*)| over |W r*|, before (LS5) */
static const double slack = 1e-10;     /* rounding of psi */
static const double symmetric = 1e-10; /* of W */
static const double closeness[] = {1e-6, 1e-9};

struct dlsi_least {
  int d, nc;
  const dls_contact *problem;
  dlsi_states_matrix A;
  dlsi_room room;
  double *w, *weights, *shift;    /* nc; 2 nc, of the certificate; nc: eps w */
  double *given, *r;              /* m each: r*; r = P(s) */
  double *u, *a, *y, *s, *z, *Wz; /* m each */
  double *g, *dz, *Wdz, *t, *x;   /* m each; t: of the unknowns; x: scratch */
  double psi;
  int n;                    /* unknowns of `at` */
  dls_contact_state *state; /* nc: of u */
  dlsi_branch *ray, *at;    /* nc: where u_t is not 0; of s */
};

static double least_dot(size_t m, const double *x, const double *y) {
  double sum = 0;
  for (size_t k = 0; k < m; k++)
    sum += x[k] * y[k];
  return sum;
}

static size_t least_rows(const dlsi_least *work) {
  return (size_t)work->problem->d * (size_t)work->problem->nc;
}

/* Returns the root of the sum of w_c |x_c|^2. */
static double least_norm(const dlsi_least *work, const double *x) {
  double sum = 0;
  for (size_t k = 0; k < least_rows(work); k++)
    sum += work->w[k / (size_t)work->problem->d] * x[k] * x[k];
  return sqrt(sum);
}

/* ---- the projection -------------------------------------------------------------------------- */

/* r (d) := P(s) of contact c. Returns its branch, (SM3). */
static dlsi_branch least_project(const dlsi_least *work, int c, const double *s, double *r) {
  const int d = work->problem->d;
  const double mu = work->problem->mu[c], *t = work->ray[c].t;
  dlsi_branch b = {.state = DLS_FREE, .symmetric = 1, .mu = mu};
  memset(r, 0, (size_t)d * sizeof *r);
  if (work->state[c] == DLS_FREE) return b;
  if (work->state[c] == DLS_SLIP || mu == 0 || d == 1) {
    double along = s[0];
    for (int i = 1; i < d; i++)
      along += mu * t[i - 1] * s[i];
    if (!(along > 0)) return b;
    b.state = DLS_SLIP;
    b.count = 1;
    r[0] = along / (1 + mu * mu);
    for (int i = 1; i < d; i++) {
      b.t[i - 1] = t[i - 1];
      r[i] = mu * r[0] * t[i - 1];
    }
    return b;
  }
  b.state = (short)dlsi_project_cone(d, mu, s, r);
  b.count = b.state == DLS_STICK ? (short)d : b.state == DLS_SLIP ? (short)(d - 1) : 0;
  if (b.state != DLS_SLIP) return b;
  const double size = dlsi_tangent_norm(d, s);
  for (int i = 1; i < d; i++)
    b.t[i - 1] = s[i] / size;
  b.l = work->shift[c] * (size / (mu * r[0]) - 1);
  return b;
}

/* r := P(s) with its branches in `at`. */
static void least_project_all(dlsi_least *work, const double *s, double *r) {
  const int d = work->problem->d;
  work->n = 0;
  for (int c = 0; c < work->problem->nc; c++) {
    work->at[c] = least_project(work, c, s + d * c, r + d * c);
    work->at[c].first = work->n;
    work->n += work->at[c].count;
  }
}

/* Sets s, r, g and psi of z and Wz. */
static void least_look(dlsi_least *work) {
  const size_t m = least_rows(work), d = (size_t)work->problem->d;
  for (size_t k = 0; k < m; k++)
    work->s[k] = work->y[k] - work->Wz[k] / work->shift[k / d];
  least_project_all(work, work->s, work->r);
  for (size_t k = 0; k < m; k++)
    work->g[k] = work->z[k] - work->r[k] + work->given[k];
  const double size = least_norm(work, work->r);
  work->psi = (least_dot(m, work->z, work->Wz) / 2 + least_dot(m, work->given, work->Wz)) / eps +
              size * size / 2;
}

/* ---- steps ----------------------------------------------------------------------------------- */

/* Factors the matrix of the unknowns of `at`, or keeps the present factors. */
static dls_status least_factor(dlsi_least *work, dls_error *error) {
  dlsi_states_matrix *A = &work->A;
  int same = A->factors != DLSI_NO_FACTORS && A->n == work->n;
  for (int c = 0; same && c < work->problem->nc; c++)
    same = dlsi_branch_is_same(&A->branch[c], &work->at[c]);
  if (same) return DLS_OK;
  memcpy(A->branch, work->at, (size_t)work->problem->nc * sizeof *work->at);
  A->n = work->n;
  return dlsi_states_factor(A, work->problem, work->shift, work->x, error);
}

/* x (m) -= E A^-1 t: t: n, lost. */
static dls_status least_correct(dlsi_least *work, double *x, dls_error *error) {
  const dls_status status = dlsi_states_solve(&work->A, 0, work->t, error);
  for (int k = 0; k < work->A.n; k++)
    work->t[k] = -work->t[k];
  dlsi_branches_add_directions(work->problem->d, work->problem->nc, work->A.branch, work->t, x);
  return status;
}

/* (LS3), (LS4): a step from z. Returns 1, 0 if there is no step, or an error. */
static int least_step(dlsi_least *work, dls_error *error) {
  const dls_contact *problem = work->problem;
  const size_t m = least_rows(work);
  const double psi = work->psi;
  dls_status status = least_factor(work, error);
  if (status) return status == DLS_E_SINGULAR ? 0 : status;
  for (size_t k = 0; k < m; k++)
    work->dz[k] = -work->g[k];
  dlsi_contact_apply(problem, work->dz, work->Wdz); /* -W g */
  dlsi_branches_directions(problem->d, problem->nc, work->A.branch, work->Wdz, work->t);
  status = least_correct(work, work->dz, error);
  if (status) return status;
  const double slope = -least_dot(m, work->Wdz, work->dz) / eps;
  dlsi_contact_apply(problem, work->dz, work->Wdz);
  double a = 1, before = 0;
  for (int k = 0; k < most_halvings; k++, before = a, a /= 2) {
    for (size_t i = 0; i < m; i++) {
      work->z[i] += (a - before) * work->dz[i];
      work->Wz[i] += (a - before) * work->Wdz[i];
    }
    least_look(work);
    if (work->psi <= psi + 1e-4 * a * slope + slack * fabs(psi)) return 1;
  }
  return 1;
}

/* (LS5) Reduces the rows of r* in the states of u to rounding. */
static dls_status least_improve(dlsi_least *work, dls_error *error) {
  const dls_contact *problem = work->problem;
  const int d = problem->d, nc = problem->nc;
  const size_t m = least_rows(work);
  double before = INFINITY;
  memcpy(work->r, work->given, m * sizeof *work->r);
  for (int k = 0; k <= refinements; k++) {
    dlsi_contact_multiply(problem, NULL, work->r, work->u, NULL);
    work->n = dlsi_branches_set(problem, work->state, work->r, work->u, work->at);
    dlsi_branches_rows(d, nc, work->at, work->u, work->t);
    const double now = dlsi_max_abs(work->t, (size_t)work->n);
    if (!(now < before)) return DLS_OK;
    memcpy(work->given, work->r, m * sizeof *work->r);
    if (k == 0) {
      const dls_status status = least_factor(work, error);
      if (status) return status;
    }
    if (now == 0 || now > before / 2 || k == refinements || work->n != work->A.n) return DLS_OK;
    before = now;
    const dls_status status = least_correct(work, work->r, error);
    if (status) return status;
    for (int c = 0; c < nc; c++) { /* back on the cone, along its new direction */
      double *r = work->r + d * c;
      const double t = dlsi_tangent_norm(d, r);
      for (int i = 1; work->at[c].state == DLS_SLIP && t > 0 && i < d; i++)
        r[i] *= problem->mu[c] * r[0] / t;
    }
  }
  return DLS_OK;
}

/* (LS5) Reduces W (r - r*) to rounding, with r in the cones. */
static dls_status least_refine(dlsi_least *work, dls_error *error) {
  const dls_contact *problem = work->problem;
  const size_t m = least_rows(work);
  double before = INFINITY;
  for (int k = 0; k <= refinements; k++) {
    for (size_t i = 0; i < m; i++)
      work->z[i] = work->r[i] - work->given[i];
    dlsi_contact_apply(problem, work->z, work->Wz);
    const double now = dlsi_max_abs(work->Wz, m);
    if (!(now < before)) {
      memcpy(work->r, work->y, m * sizeof *work->r);
      return DLS_OK;
    }
    before = now;
    memcpy(work->y, work->r, m * sizeof *work->r);
    if (now == 0 || k == refinements) return DLS_OK;
    dlsi_branches_directions(problem->d, problem->nc, work->A.branch, work->Wz, work->t);
    memcpy(work->s, work->r, m * sizeof *work->s);
    const dls_status status = least_correct(work, work->s, error);
    if (status) return status;
    least_project_all(work, work->s, work->r);
  }
  return DLS_OK;
}

/* (LS2) Returns 1 if r is the least one, 0 if it is not found, or an error. */
static int least_project_on_set(dlsi_least *work, const dls_limits *limits, double begun,
                                dls_error *error) {
  const size_t m = least_rows(work);
  const double size = least_norm(work, work->given);
  dlsi_contact_apply(work->problem, work->given, work->x);
  const double target = outer * dlsi_max_abs(work->x, m);
  memset(work->y, 0, m * sizeof *work->y);
  for (int k = 0; k < outer_steps; k++) {
    memset(work->z, 0, m * sizeof *work->z);
    memset(work->Wz, 0, m * sizeof *work->Wz);
    least_look(work);
    for (int steps = 0; least_norm(work, work->g) > inner * size; steps++) {
      if (steps == newton_steps || dlsi_clock_is_over(limits, begun)) return 0;
      const int moved = least_step(work, error);
      if (moved <= 0) return moved;
    }
    memcpy(work->y, work->s, m * sizeof *work->y);
    for (size_t i = 0; i < m; i++)
      work->x[i] = work->r[i] - work->given[i];
    dlsi_contact_apply(work->problem, work->x, work->Wdz);
    if (!(dlsi_max_abs(work->Wdz, m) <= target)) continue;
    const dls_status status = least_factor(work, error);
    return status == DLS_E_SINGULAR ? 0 : status ? status : 1;
  }
  return 0;
}

/* ---- the call -------------------------------------------------------------------------------- */

/* Returns 1 if x.W y = y.W x for two drawn x and y. */
static int least_is_symmetric(dlsi_least *work) {
  const size_t m = least_rows(work), d = (size_t)work->problem->d;
  double *x = work->x, *y = work->y;
  for (size_t k = 0; k < m; k++) {
    const double by = 1 / sqrt(work->w[k / d]);
    x[k] = by * (dlsi_draw_entry(0, (int)k) - 0.5);
    y[k] = by * (dlsi_draw_entry(1, (int)k) - 0.5);
  }
  dlsi_contact_apply(work->problem, x, work->Wz);
  dlsi_contact_apply(work->problem, y, work->Wdz);
  const double one = least_dot(m, y, work->Wz), other = least_dot(m, x, work->Wdz);
  return fabs(one - other) <= symmetric * (least_dot(m, x, work->Wz) + least_dot(m, y, work->Wdz));
}

/* Sets the states of u and the directions of its slips, `close` as in dlsi_contact_touch. r* := 0
 * for free contacts. */
static void least_choose(dlsi_least *work, double close) {
  const int d = work->problem->d;
  dlsi_contact_touch(work->problem, work->u, close, work->state);
  for (int c = 0; c < work->problem->nc; c++) {
    const double *u = work->u + d * c, slip = dlsi_tangent_norm(d, u);
    work->ray[c] = (dlsi_branch){0};
    for (int i = 0; work->state[c] == DLS_FREE && i < d; i++)
      work->given[d * c + i] = 0;
    for (int i = 1; work->state[c] == DLS_SLIP && i < d; i++)
      work->ray[c].t[i - 1] = -u[i] / slip;
  }
}

/* Tries the contacts within `close` of touching as touching. Returns 1 if work->r is the least r,
 * 0, or an error. */
static int least_try(dlsi_least *work, double close, const dls_limits *limits, double begun,
                     dls_error *error) {
  least_choose(work, close);
  work->A.factors = DLSI_NO_FACTORS;
  dls_status status = least_improve(work, error);
  if (status) return status == DLS_E_SINGULAR ? 0 : status;
  const int found = least_project_on_set(work, limits, begun, error);
  if (found <= 0) return found;
  status = least_refine(work, error);
  return status ? status : 1;
}

dls_status dlsi_least_take(dlsi_least *work, const dls_contact *problem, const dls_limits *limits,
                           double begun, dls_status status, double *r, double *u,
                           dls_certificate *certificate, int *done, dls_error *error) {
  const size_t d = (size_t)problem->d, nc = (size_t)problem->nc, m = d * nc;
  dls_certificate now;
  *done = 0;
  if (m == 0 || dlsi_first_bonded(problem) >= 0) return DLS_OK;
  work->problem = problem;
  dlsi_both_weights(problem, work->w, work->weights);
  for (size_t c = 0; c < nc; c++)
    work->shift[c] = eps * work->w[c];
  if (!least_is_symmetric(work)) return DLS_OK;
  dls_status failed =
      dlsi_states_reserve(&work->A, problem->nc, problem->Wb.x ? problem->Wb.p[nc] : 0, 0, error);
  for (int k = 0; !failed && k < 2; k++) {
    memcpy(work->given, r, m * sizeof *r);
    dlsi_contact_multiply(problem, NULL, r, work->u, work->a);
    dlsi_contact_measure(problem, r, work->u, work->a, work->weights, work->x, &now);
    double most = dlsi_max_abs(work->u, m);
    for (size_t i = 0; i < m; i++)
      most = fmax(most, work->w[i / d] * fabs(r[i]));
    const double close = fmax(closeness[k], 10 * now.residual) * most;
    const int found = least_try(work, close, limits, begun, error);
    if (found < 0) failed = (dls_status)found;
    if (found <= 0) continue;
    dlsi_contact_multiply(problem, NULL, work->r, work->u, work->a);
    dlsi_contact_measure(problem, work->r, work->u, work->a, work->weights, work->x, &now);
    const dls_status verdict = dlsi_certificate_verdict(&now, limits->tol);
    if (verdict != DLS_OK && verdict != status) continue;
    *done = 1;
    *certificate = now;
    memcpy(r, work->r, m * sizeof *r);
    if (u) memcpy(u, work->u, m * sizeof *u);
    break;
  }
  return failed;
}

static void least_carve(void *workspace, dlsi_arena *arena) {
  dlsi_least *work = workspace;
  const size_t nc = (size_t)work->nc, m = (size_t)work->d * nc;
  double **const vectors[] = {&work->given, &work->r, &work->u,  &work->a, &work->y,
                              &work->s,     &work->z, &work->Wz, &work->g, &work->dz,
                              &work->Wdz,   &work->t, &work->x};
  for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++)
    *vectors[k] = dlsi_take(arena, m, sizeof(double));
  work->w = dlsi_take(arena, nc, sizeof *work->w);
  work->weights = dlsi_take(arena, 2 * nc, sizeof *work->weights);
  work->shift = dlsi_take(arena, nc, sizeof *work->shift);
  work->state = dlsi_take(arena, nc, sizeof *work->state);
  work->ray = dlsi_take(arena, nc, sizeof *work->ray);
  work->at = dlsi_take(arena, nc, sizeof *work->at);
  dlsi_states_carve(&work->A, arena);
}

dls_status dlsi_least_create(dlsi_least **out, int d, int nc, int blocks, dls_error *error) {
  dlsi_least filled = {.d = d, .nc = nc, .A = {.d = d, .nc = nc}}, *work;
  void *made;
  *out = NULL;
  dls_status status =
      dlsi_carve_workspace(&made, &filled, sizeof filled, least_carve, "nc", nc, error);
  if (status) return status;
  work = made;
  work->A.room = &work->room;
  status = dlsi_states_reserve(&work->A, nc, blocks, blocks, error);
  if (status)
    dlsi_least_destroy(work);
  else
    *out = work;
  return status;
}

void dlsi_least_destroy(dlsi_least *work) {
  if (!work) return;
  dlsi_room_free(&work->room);
  free(work);
}
