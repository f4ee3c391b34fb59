/*
 * newton.c: nonsmooth Newton on the friction law, d = 2 and 3.
 *
 * With w_c of the certificate, x = w r_n - u_n and tau = w r_t - u_t per contact, u = W r + q,
 * the law is AC(r, u) = 0,
 *
 *   AC_c = w r_c - ( max(0, x),  tau put on the disc of radius R ),   R = mu max(0, x)
 *
 * (Alart and Curnier, Comp. Meth. Appl. Mech. Eng. 92, 1991, 353-375). Its generalised derivative
 * is reduced by hand: the branch of a contact fixes a part of its new r, and only the rest is
 * unknown. With r0 = r + known part, u0 = W r0 + q, t = tau / |tau| and, in 3D, p = t turned by 90
 * degrees, one step is
 *
 *   (NE1)  free   x <= 0        r0_c = 0                               nothing unknown
 *          stick  |tau| <= R    r0_c = r_c                             dr_c:  u0_c + W_c dr = 0
 *          slip   otherwise     r0_c = r_c + (0, k t), k = (mu u_n + R) / w - t.r_t
 *                               dr_c = (a, mu a t + b p), unknown a:   u0_n + W_n dr = 0
 *                               and, 3D, b:  p.(u0_t + W_t dr) + l (p.r_t + b) = 0
 *                               l = w (|tau| - R) / R
 *          slip, mu = 0         r0_c = (r_n, 0), unknown a:            u0_n + W_n dr = 0
 *   (NE2)  these rows and columns of W + eps diag(w), and l on the rows of b: one factorisation,
 *          one solve. The matrix and its factors stay while no state changes and, in 3D, nothing
 *          slips. Dense: Cholesky if the matrix is symmetric (all stick, or mu = 0, and W is
 *          symmetric), else LU; if few contacts have changed, the old factors serve (border.c).
 *   (NE3)  r := r0 + dr
 *
 * k and mu a are the linearised row of AC along t. The row of b is the row along p divided by
 * R / |tau|, with p.tau = 0. eps = 1e-6 keeps the matrix regular if W is not, and does not change
 * AC: a step then multiplies the error by about eps cond(W) instead of squaring it. If no state has
 * changed since the last step and the factors are dense, a second solve corrects for eps, if that
 * is small. eps grows a hundredfold, from 1e-8 on, if the matrix is singular all the same, and
 * tenfold, up to 1e-2, after each 4 steps in a row that did not halve the residual: on a W of low
 * rank eps divides the rounding of W r + q, and shorter steps cycle among states less often.
 *
 * With springs, u = (W + diag(E)) r + q (augmented.c), E is added to eps diag(w) in (NE2).
 *
 *   (NE0)  First, sweeps of Gauss-Seidel (nlgs.c) find the states: from r = 0 full steps alone
 *          cycle among states too often.
 *   (NE4)  Line search, for starts without sweeps: r + s (r' - r), s = 1, 1/2, .. 1/64, until |AC|
 *          is below the largest of its last five values (Grippo, Lampariello and Lucidi, SIAM J.
 *          Numer. Anal. 23, 1986, 707-716). u is affine in r, so that a trial costs O(m).
 *
 *   (NE5)  In a sequence of problems a solve begins with the factors of the one before, which serve
 *          loosely (border.c, BO7): while the states stay, directions of slip may turn and l may
 *          change. Right sides are exact, so only the rate suffers (a chord method). For slips
 *          r0 - r is of second order; its product is omitted if it is at most 10 % of the error. W
 *          may have changed, too: if a step leaves more than 25 % of the right side of (NE2), new
 *          factors are made.
 *   (NE6)  d = 3: steps by the same factors in the same states are combined (anderson.c, with f =
 *          w (next - r), 5 differences): if directions have turned so far that a step leaves 1/6 of
 *          the error, the combination leaves 1/10.
 *
 * Stop: the certificate holds (its F is de Saxce's; both vanish together), the limit of steps, or
 * 12 steps that did not halve the residual. Uphill steps are taken, too; the best r is kept.
 *
 * Deviation: the full method has m unknowns in any states. Only arithmetic is saved; the iterates
 * differ by eps alone.
 * Cost of a step: a product with W, another one for (NE1), and an LU of the k unknowns: 2/3 k^3
 * dense, half of that by Cholesky, much less sparse.
 * What can fail: it need not converge from afar, and states may cycle without end (cycle in
 * tests/method/test_newton.c): DLS_STALLED.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "border.h"
#include "states_matrix.h"
#include "vi/vi_internal.h"

enum { most_steps = 30, patience = 12, impatience = 4, memory = 5, halvings = 6 };
enum { window = 5 }; /* (NE6) */

static const double least_eps = 1e-8;   /* first eps for a singular matrix */
static const double most_eps = 1e-2;    /* bound of eps without progress */
static const double not_known = -1;     /* friction of a contact that is new to the factors */
static const double stale = 0.25;       /* (NE5) */
static const double slight = 0.1;       /* (NE5): |w (r0 - r)| over |F| */
static const double small_part = 0.1;   /* of a solution: the largest correction for eps */
static const double least_beta = 1e-10; /* R / |tau|: l stays finite where R vanishes */

struct dls_newton {
  dls_newton_settings settings;
  int d, nc;
  int stage;            /* of auto: from the given r */
  dls_nlgs *nlgs;       /* NULL without sweeps */
  dlsi_iterate it;      /* its u is that of r */
  dlsi_states_matrix A; /* (NE2) for the base states of the border */
  double *r;            /* iterate: m */
  double *next, *unext; /* r0, then r0 + dr, and their u: m */
  double *x;            /* right side and solution of (NE2): m */
  double right;         /* its size, before the solution */
  double error;         /* |F| of r; 0: not measured */
  int settled;          /* 1: (NE2) is that of the step before */
  int same;             /* 1: the states are those of the step before */
  dlsi_border border;
  dlsi_anderson steps; /* (NE6): d = 3, where no blocks are announced */
  int keeps, kept_nc;  /* (NE5): 1 if the next run may; contacts of the factors */
  int no_more;         /* 1: that run ends before it factorises */
  int anew;            /* 1: changed states are factorised again, as for W by blocks */
  const double *known; /* u of the start of the next run, NULL: unknown */
  dlsi_room own;       /* of the matrix, unless the caller has one */
  dlsi_formed formed;  /* W of bodies by blocks */
};

void dls_newton_settings_init(dls_newton_settings *settings) {
  if (!settings) return;
  *settings = (dls_newton_settings){.size = sizeof *settings, .sweeps = 20, .regularization = 1e-6};
  dlsi_limits_init(&settings->limits);
}

static dls_status newton_check(int d, int nc, const dls_newton_settings *s, dls_error *error) {
  const dlsi_setting own[] = {{"sweeps", s->sweeps, 0, INT_MAX, 0},
                              {"line_search", s->line_search, 0, 1, 0},
                              {"regularization", s->regularization, 0, 1 - DBL_EPSILON, 0}};
  dls_status status = dlsi_check_sizes(d, nc, error);
  if (!status) status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 3, own, error);
  if (status) return status;
  const size_t m = (size_t)d * (size_t)nc;
  if (!s->limits.blocks && m > 0 && m > SIZE_MAX / sizeof(double) / m)
    return dlsi_fail(error, DLS_E_SIZE, "nc", -1, nc, "is too large");
  return DLS_OK;
}

static void newton_carve(void *workspace, dlsi_arena *arena) {
  dls_newton *work = workspace;
  const size_t m = (size_t)work->d * (size_t)work->nc;
  double **const vectors[] = {&work->r, &work->next, &work->unext, &work->x};
  dlsi_iterate_carve(&work->it, arena, work->d, work->nc, &work->settings.limits);
  dlsi_take_vectors(arena, m, 4, vectors);
  dlsi_states_carve(&work->A, arena);
  if (work->d == 3 && !work->settings.limits.blocks)
    dlsi_anderson_carve(&work->steps, arena, m, window, 0);
}

dls_status dlsi_newton_create(dls_newton **out, int d, int nc, const dls_newton_settings *settings,
                              dlsi_room *room, dls_error *error) {
  dls_newton filled = {.d = d, .nc = nc, .A = {.d = d, .nc = nc}}, *work;
  void *made;
  dls_newton_settings_init(&filled.settings);
  if (settings) filled.settings = *settings;
  if (!out) return dlsi_is_null(error, "out");
  *out = NULL;
  dls_status status = newton_check(d, nc, &filled.settings, error);
  if (!status) status = dlsi_workspace(&made, &filled, sizeof filled, newton_carve, nc, error);
  if (status) return status;
  work = made;
  work->A.room = room ? room : &work->own;
  if (work->settings.sweeps) status = dls_nlgs_create(&work->nlgs, d, nc, NULL, error);
  const int blocks = work->settings.limits.blocks;
  if (!status) status = dlsi_states_reserve(&work->A, nc, blocks, blocks, error);
  if (status)
    dls_newton_destroy(work);
  else
    *out = work;
  return status;
}

dls_status dls_newton_create(dls_newton **out, int d, int nc, const dls_newton_settings *settings,
                             dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, dlsi_newton_create(out, d, nc, settings, NULL, error), error);
}

void dls_newton_destroy(dls_newton *workspace) {
  if (!workspace) return;
  dls_nlgs_destroy(workspace->nlgs);
  dlsi_room_free(&workspace->own);
  dlsi_formed_free(&workspace->formed);
  free(workspace);
}

/* ---- the matrix of a step -------------------------------------------------------------------- */

/* Factorises (NE2). it.F, it.a: scratch. DLS_E_SINGULAR, DLS_E_MEMORY. */
static dls_status newton_factor(dls_newton *work, const dls_contact *problem, double eps, int k,
                                dls_error *error) {
  dlsi_room *room = work->A.room;
  double *shift = work->it.F;
  for (int c = 0; c < problem->nc; c++)
    shift[c] = eps * work->it.w[c] + (work->it.E ? work->it.E[c] : 0);
  const size_t used = problem->W.a ? (size_t)k * (size_t)k : 0;
  dlsi_border_begin(&work->border, problem->d, problem->nc, work->A.branch, k, room->J + used,
                    problem->W.a && !work->anew ? room->side * room->side - used : 0);
  room->owner = work;
  work->A.n = k;
  return dlsi_states_factor(&work->A, problem, shift, work->it.a, error);
}

/* Solves (NE2) once more for the error by eps of the solution x, k unknowns, and adds the result if
 * it is small beside x. it.F: scratch. */
static void newton_refine(dls_newton *work, const dls_contact *problem, double eps, int k) {
  double *x0 = work->it.F;
  const size_t n = (size_t)k;
  memcpy(x0, work->x, n * sizeof *x0);
  for (int c = 0; c < problem->nc; c++)
    for (int i = 0; i < work->A.branch[c].count; i++)
      work->x[work->A.branch[c].first + i] *= eps * work->it.w[c];
  const int solved = dlsi_border_solve(&work->border, &work->A.dense, work->A.branch, work->it.w,
                                       work->it.E, eps, work->x);
  const int small = solved && dlsi_norm2(work->x, n) <= small_part * dlsi_norm2(x0, n);
  for (size_t i = 0; i < n; i++)
    work->x[i] = x0[i] + (small ? work->x[i] : 0);
}

/* x := the solution of (NE2) with right side x; *done counts the factorisations. DLS_STALLED if one
 * is needed but no_more is set, DLS_E_SINGULAR, DLS_E_MEMORY. */
static dls_status newton_solve_matrix(dls_newton *work, const dls_contact *problem, double eps,
                                      int k, int *done, dls_error *error) {
  dlsi_border *border = &work->border;
  if (k == 0) return DLS_OK;
  if (work->A.factors && !dlsi_border_add(border, problem, &work->A.dense, work->A.branch))
    work->A.factors = DLSI_NO_FACTORS;
  for (int again = 0; again < 2; again++) {
    if (!work->A.factors) {
      if (work->no_more) return DLS_STALLED;
      const dls_status status = newton_factor(work, problem, eps, k, error);
      ++*done;
      if (status) return status;
    }
    if (work->A.factors == DLSI_SPARSE_FACTORS)
      return dlsi_states_solve(&work->A, 0, work->x, error);
    if (dlsi_border_solve(border, &work->A.dense, work->A.branch, work->it.w, work->it.E, eps,
                          work->x))
      break;
    work->A.factors = DLSI_NO_FACTORS;
  }
  if (eps > 0 && work->settled) newton_refine(work, problem, eps, k);
  return DLS_OK;
}

/* ---- the step -------------------------------------------------------------------------------- */

/* Returns (NE1) for one contact; r := r0. */
static dlsi_branch newton_branch_of(int d, double mu, double w, const double *u, double *r) {
  dlsi_branch b = {.state = DLS_FREE, .mu = mu};
  const double x = w * r[0] - u[0];
  if (!(x > 0)) {
    memset(r, 0, (size_t)d * sizeof *r);
    return b;
  }
  const double R = mu * x, tau[2] = {d > 1 ? w * r[1] - u[1] : 0, d == 3 ? w * r[2] - u[2] : 0};
  const double size = hypot(tau[0], tau[1]);
  if (mu > 0 && size <= R) {
    b.state = DLS_STICK;
    b.count = (short)d;
    return b;
  }
  b.state = DLS_SLIP;
  b.count = 1;
  if (!(mu > 0)) {
    memset(r + 1, 0, (size_t)(d - 1) * sizeof *r);
    return b;
  }
  const double beta = R > least_beta * size ? R / size : least_beta;
  b.count = (short)(d - 1);
  b.t[0] = tau[0] / size;
  b.t[1] = tau[1] / size;
  b.l = w * ((1 - beta) / beta);
  const double along = b.t[0] * r[1] + (d == 3 ? b.t[1] * r[2] : 0);
  const double k = (mu * u[0] + R) / w - along;
  for (int i = 1; i < d; i++)
    r[i] += k * b.t[i - 1];
  return b;
}

/* Returns 1 if r0 of a contact is r up to the rounding of a product. */
static int newton_stays(int d, const double *r, const double *r0) {
  double size = 0, change = 0;
  for (int i = 0; i < d; i++) {
    size = fmax(size, fabs(r[i]));
    change = fmax(change, fabs(r0[i] - r[i]));
  }
  return change <= 4 * DBL_EPSILON * size;
}

/* unext := w (next - r) */
static void newton_weigh_step(dls_newton *work, const dls_contact *problem) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  for (size_t k = 0; k < m; k++)
    work->unext[k] = work->it.w[k / d] * (work->next[k] - work->r[k]);
}

/* Returns 1 if r0 - r may be omitted (NE5). unext: scratch. */
static int newton_is_slight(dls_newton *work, const dls_contact *problem) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  newton_weigh_step(work, problem);
  return dlsi_norm2(work->unext, m) <= slight * work->error;
}

/* unext := u0 = u + W (r0 - r): a product for what differs. */
static void newton_known(dls_newton *work, const dls_contact *problem) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  int moved = 0;
  for (int c = 0; c < problem->nc; c++)
    moved += !newton_stays(problem->d, work->r + d * (size_t)c, work->next + d * (size_t)c);
  if (work->border.loose && moved && newton_is_slight(work, problem)) moved = 0;
  if (2 * moved > problem->nc) {
    dlsi_multiply(problem, NULL, work->it.E, work->next, work->unext, NULL);
    return;
  }
  memcpy(work->unext, work->it.u, m * sizeof *work->unext);
  if (!moved) return;
  for (int c = 0; c < problem->nc; c++) {
    const double *r = work->r + d * (size_t)c, *r0 = work->next + d * (size_t)c;
    double dr[3];
    if (newton_stays(problem->d, r, r0)) continue;
    for (size_t i = 0; i < d; i++) {
      dr[i] = r0[i] - r[i];
      if (work->it.E) work->unext[d * (size_t)c + i] += work->it.E[c] * dr[i];
    }
    dlsi_contact_add_columns(problem, c, dr, work->unext);
  }
}

/* Returns the right side of (NE2) in row i of a contact with u0 = u and r0 = r. */
static double newton_right(const dlsi_branch *b, int i, const double *u, const double *r) {
  const double l = b->state == DLS_SLIP && i == 1 ? b->l : 0;
  return -dlsi_branch_row(b, i, u) - (l > 0 ? l * dlsi_branch_row(b, 1, r) : 0);
}

/* x (NULL: not wanted) := the right side of (NE2) for u and r. Returns its norm. */
static double newton_rights(const dls_newton *work, const dls_contact *problem, const double *u,
                            const double *r, double *x) {
  const size_t d = (size_t)problem->d;
  double sum = 0;
  for (int c = 0; c < problem->nc; c++, u += d, r += d) {
    const dlsi_branch *b = &work->A.branch[c];
    double v[3] = {0}, s[3] = {0};
    memcpy(v, u, d * sizeof *v);
    memcpy(s, r, d * sizeof *s);
    for (int i = 0; i < b->count; i++) {
      const double row = newton_right(b, i, v, s);
      if (x) x[b->first + i] = row;
      sum += row * row;
    }
  }
  return sqrt(sum);
}

/* (NE1) for all contacts: next := r0, x := right side. Returns how many unknowns there are. */
static int newton_linearise(dls_newton *work, const dls_contact *problem) {
  const int d = problem->d;
  const size_t m = (size_t)d * (size_t)problem->nc;
  int k = 0, changed = 0;
  work->same = 1;
  memcpy(work->next, work->r, m * sizeof *work->r);
  for (int c = 0; c < problem->nc; c++) {
    const size_t o = (size_t)d * (size_t)c;
    dlsi_branch *b = &work->A.branch[c];
    const dlsi_branch before = *b;
    *b = newton_branch_of(d, problem->mu[c], work->it.w[c], work->it.u + o, work->next + o);
    changed += !work->A.factors || !dlsi_branch_is_same(b, &before);
    if (!work->A.factors || b->state != before.state) work->same = 0;
    b->first = k;
    k += b->count;
  }
  if (changed && !work->border.most) work->A.factors = DLSI_NO_FACTORS;
  work->settled = !changed;
  newton_known(work, problem);
  (void)newton_rights(work, problem, work->unext, work->next, work->x);
  work->right = dlsi_norm2(work->x, (size_t)k);
  return k;
}

/* Returns |AC| of r and u = W r + q. */
static double newton_merit(dls_newton *work, const dls_contact *problem, const double *r,
                           const double *u) {
  const int d = problem->d;
  for (int c = 0; c < problem->nc; c++) {
    const size_t o = (size_t)d * (size_t)c;
    const double w = work->it.w[c], x = w * r[o] - u[o], R = x > 0 ? problem->mu[c] * x : 0;
    double tau[2] = {0};
    for (int i = 1; i < d; i++)
      tau[i - 1] = w * r[o + (size_t)i] - u[o + (size_t)i];
    const double size = hypot(tau[0], tau[1]), beta = size > R ? R / size : 1;
    work->it.F[o] = x > 0 ? u[o] : w * r[o];
    for (int i = 1; i < d; i++)
      work->it.F[o + (size_t)i] = w * r[o + (size_t)i] - beta * tau[i - 1];
  }
  return dlsi_norm2(work->it.F, (size_t)d * (size_t)problem->nc);
}

/* (NE4) next := r + s (next - r). last: |AC| of the last iterates, next included: memory. */
static void newton_search(dls_newton *work, const dls_contact *problem, int step, double *last) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  double bound = last[0];
  for (int k = 1; k < memory; k++)
    if (last[k] > bound) bound = last[k];
  dlsi_multiply(problem, NULL, work->it.E, work->next, work->unext, NULL);
  double now = newton_merit(work, problem, work->next, work->unext);
  for (int k = 0; k < halvings && !(now < bound); k++) {
    for (size_t i = 0; i < m; i++) {
      work->next[i] = 0.5 * (work->r[i] + work->next[i]);
      work->unext[i] = 0.5 * (work->it.u[i] + work->unext[i]);
    }
    now = newton_merit(work, problem, work->next, work->unext);
  }
  last[step % memory] = now;
}

/* ---- the iteration --------------------------------------------------------------------------- */

/* (NE1)-(NE3) next := the step from r. If the matrix is singular, eps grows. DLS_E_SINGULAR: it is
 * for every eps; DLS_STALLED, DLS_E_MEMORY as in newton_solve_matrix. */
static dls_status newton_step(dls_newton *work, const dls_contact *problem, double *eps,
                              int *factorisations, dls_error *error) {
  dls_error why = {0};
  dls_status status;
  do {
    const int k = newton_linearise(work, problem);
    status = newton_solve_matrix(work, problem, *eps, k, factorisations, &why);
    if (status == DLS_E_SINGULAR) *eps = *eps > least_eps ? 100 * *eps : least_eps;
  } while (status == DLS_E_SINGULAR && *eps < 1);
  if (!status) /* (NE3) */
    dlsi_branches_add_directions(problem->d, problem->nc, work->A.branch, work->x, work->next);
  if (status < 0 && status != DLS_E_SINGULAR && error) *error = why;
  return status;
}

/* (NE6) next := the step combined with earlier ones; anew: 1 to drop those. unext: scratch. */
static void newton_combine(dls_newton *work, const dls_contact *problem, int anew) {
  const int m = problem->d * problem->nc;
  if (anew || !work->same) dlsi_anderson_clear(&work->steps);
  newton_weigh_step(work, problem);
  (void)dlsi_anderson_step(&work->steps, m, work->unext, work->next, NULL);
}

/* Returns 1 if the factors of the last run serve this one (NE5). */
static int newton_keeps(const dls_newton *work, const dls_contact *problem) {
  return work->keeps && work->A.factors == DLSI_DENSE_FACTORS && work->kept_nc == problem->nc &&
         !work->it.E && work->A.room->owner == work;
}

/* Sets the friction of the contacts that a map has added to the factors, where they are free. */
static void newton_meet(dls_newton *work, const dls_contact *problem) {
  for (int c = 0; work->border.most && c < problem->nc; c++)
    if (work->border.base[c].mu == not_known)
      work->border.base[c].mu = work->A.branch[c].mu = problem->mu[c];
}

/* Steps from r, measured last, until the certificate holds. Returns DLS_OK, or the reason to stop
 * before. */
static dls_status newton_iterate(dls_newton *work, const dls_contact *problem, dls_info *outcome,
                                 dls_error *error) {
  const dls_newton_settings *settings = &work->settings;
  const int most = dlsi_most_iterations(&settings->limits, most_steps);
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  double eps = settings->regularization, halved = work->it.certificate.residual, last[memory] = {0};
  if (!newton_keeps(work, problem)) work->A.factors = DLSI_NO_FACTORS;
  if (work->A.factors) newton_meet(work, problem);
  work->border.loose = work->keeps;
  work->error = 0;
  work->kept_nc = work->it.E ? 0 : problem->nc;
  if (settings->line_search) last[0] = newton_merit(work, problem, work->r, work->it.u);
  for (int k = 1, since = 0; k <= most; k++) {
    const int made = outcome->factorisations;
    const dls_status status =
        newton_step(work, problem, &eps, &outcome->factorisations, error); /* (NE1)-(NE3) */
    if (status) return status == DLS_E_SINGULAR ? DLS_STALLED : status;
    if (work->keeps && work->steps.window)
      newton_combine(work, problem, k == 1 || outcome->factorisations > made);
    if (settings->line_search) newton_search(work, problem, k, last); /* (NE4) */
    memcpy(work->r, work->next, m * sizeof *work->r);
    outcome->iterations = k;
    const dls_certificate now = dlsi_iterate_measure(&work->it, problem, work->r);
    if (dlsi_iterate_keep(&work->it, problem, work->r, &now)) return DLS_OK;
    work->error = dlsi_norm2(work->it.F, m);
    const dls_status stop = dlsi_iterate_tell(&work->it, "newton", k, most, now.residual, work->r);
    if (stop) return stop;
    if (now.residual <= halved / 2) {
      halved = now.residual;
      since = k;
    }
    if (work->keeps &&
        !(newton_rights(work, problem, work->it.u, work->r, NULL) <= stale * work->right))
      work->A.factors = DLSI_NO_FACTORS; /* (NE5) */
    if (k > since && (k - since) % impatience == 0 && eps < most_eps) {
      eps *= 10;
      work->A.factors = DLSI_NO_FACTORS;
    }
    if (k - since >= patience || dlsi_iterate_is_lost(now.residual)) return DLS_STALLED;
  }
  return DLS_MAX_ITERATIONS;
}

/* Reports a sweep to the caller as a stage of this method. */
static int newton_tell_of_sweep(void *newton, const dls_progress *of_sweep) {
  DLSI_DOOR;
  const dls_newton *work = newton;
  dls_progress progress = *of_sweep;
  progress.method = "newton";
  return dlsi_tell(&work->settings.limits, work->it.begun, &progress) == DLS_CANCELLED;
}

/* (NE0) Sweeps from r, with the limits of the workspace except their number. */
static dls_status newton_sweep(dls_newton *work, const dls_contact *problem, int *sweeps) {
  dls_limits limits = work->settings.limits;
  dls_info info;
  limits.max_iterations = work->settings.sweeps;
  limits.warm_start = 1;
  limits.cpu_seconds = dlsi_clock_left(&work->settings.limits, work->it.begun);
  if (limits.progress) limits.progress = newton_tell_of_sweep;
  limits.progress_data = work;
  dlsi_set_limits(&dlsi_nlgs_method, work->nlgs, &limits);
  const dls_status status =
      dlsi_nlgs_run(work->nlgs, problem, NULL, work->it.E, work->r, NULL, &info);
  *sweeps = info.iterations;
  return status;
}

dls_status dlsi_newton_run(dls_newton *work, const dls_contact *problem, const double *E, double *r,
                           double *u, dls_info *info, dls_error *error) {
  const dls_limits *limits = &work->settings.limits;
  const int blocks = problem->Wb.x ? problem->Wb.p[problem->nc] : 0;
  dls_info outcome = {.method = DLS_NEWTON};
  dls_status status = dlsi_states_reserve(&work->A, problem->nc, blocks, limits->blocks, error);
  if (status) return status;
  dlsi_iterate_begin(&work->it, problem, E, limits->tol, work->stage || limits->warm_start, r,
                     work->r);
  if (work->nlgs) status = newton_sweep(work, problem, &outcome.sweeps);
  if (work->known)
    memcpy(work->it.u, work->known, (size_t)problem->d * (size_t)problem->nc * sizeof *work->it.u);
  if (!work->known && dlsi_iterate_start(&work->it, problem, work->r))
    status = DLS_OK;
  else if (status != DLS_CANCELLED && status != DLS_TIME_LIMIT)
    status = newton_iterate(work, problem, &outcome, error);
  work->keeps = work->no_more = 0;
  work->known = NULL;
  return dlsi_iterate_end(&work->it, problem, status, &outcome, r, u, info);
}

dls_status dls_newton_solve(dls_newton *workspace, const dls_contact *problem, double *r, double *u,
                            dls_info *info, dls_error *error) {
  DLSI_DOOR;
  dls_status status = dlsi_iterate_enter(workspace ? &workspace->it : NULL, problem, r, u, error);
  if (status) return dlsi_at(__func__, status, error);
  if (dlsi_is_empty(problem, &workspace->settings.limits, DLS_NEWTON, "newton", info))
    return dlsi_leave(&workspace->it.busy, DLS_OK);
  status = dlsi_form_blocks(&workspace->formed, &problem, error);
  if (!status) status = dlsi_newton_run(workspace, problem, NULL, r, u, info, error);
  status = dlsi_iterate_leave(&workspace->it, "newton", status, r);
  return dlsi_at(__func__, status, error);
}

void dlsi_newton_keep(void *newton, const double *u, int no_more) {
  dls_newton *work = newton;
  work->keeps = 1;
  work->no_more = no_more;
  work->known = u;
}

/* A.branch (nc) := the states of the factors under their new numbers; new contacts are free.
 * Returns 0 if contacts do not stay in their order, or one with unknowns has vanished. */
static int newton_rename(dls_newton *work, int nc, const int *from) {
  const dlsi_branch *base = work->border.base, opened = {.state = DLS_FREE, .mu = not_known};
  int last = -1, unknowns = 0;
  for (int c = 0; c < nc; c++) {
    if (from[c] >= 0 && (from[c] <= last || from[c] >= work->kept_nc)) return 0;
    if (from[c] >= 0) last = from[c];
    work->A.branch[c] = from[c] < 0 ? opened : base[from[c]];
    unknowns += work->A.branch[c].count;
  }
  return unknowns == work->border.n;
}

void dlsi_newton_map(void *newton, int nc, const int *from) {
  dls_newton *work = newton;
  const dlsi_room *room = work->A.room;
  if (!from || work->A.factors == DLSI_NO_FACTORS) return;
  int moved = nc != work->kept_nc;
  for (int c = 0; c < nc; c++)
    moved |= from[c] != c;
  if (!moved) return;
  const int serve = work->A.factors == DLSI_DENSE_FACTORS && room->owner == work &&
                    work->border.most > 0 && newton_rename(work, nc, from);
  if (!serve) work->A.factors = DLSI_NO_FACTORS;
  if (!serve) return;
  const size_t used = (size_t)work->border.n * (size_t)work->border.n;
  dlsi_border_begin(&work->border, work->d, nc, work->A.branch, work->border.n, room->J + used,
                    room->side * room->side - used);
  work->kept_nc = nc;
}

void dlsi_newton_anew(dls_newton *work) {
  work->anew = 1;
}

const double *dlsi_newton_gap(const void *work) {
  return ((const dls_newton *)work)->it.u;
}

/* ---- in the table of methods ----------------------------------------------------------------- */

static dls_status newton_create_by(void **out, int d, int nc, const dlsi_options *options,
                                   dls_error *error) {
  dls_newton_settings s;
  dls_newton_settings_init(&s);
  s.limits = options->limits;
  if (options->positive_definite) s.regularization = 0;
  if (options->stage) s.sweeps = 0;
  dls_newton *work;
  const dls_status status = dlsi_newton_create(&work, d, nc, &s, options->room, error);
  if (work) work->stage = options->stage;
  *out = work;
  return status;
}

static dls_status newton_solve(void *work, const dls_contact *problem, double *r, double *u,
                               dls_info *info, dls_error *error) {
  return dlsi_newton_run(work, problem, NULL, r, u, info, error);
}

static void newton_destroy(void *work) {
  dls_newton_destroy(work);
}

const dlsi_method dlsi_newton_method = {
    .method = DLS_NEWTON,
    .name = "newton",
    .summary = "nonsmooth Newton steps after sweeps: 1e-8 and better, ill-conditioned W",
    .create = newton_create_by,
    .solve = newton_solve,
    .destroy = newton_destroy,
    .limits = offsetof(dls_newton, settings.limits),
    .map = dlsi_newton_map,
};
