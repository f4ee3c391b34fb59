/*
 * sensitivity.c: what the residual of an answer means for its reactions.
 *
 * Where the states of the contacts stay, F = J (r - r*) to first order, J the derivative of the
 * laws. With A and E of vi/newton/states_matrix.c, the columns of E over their length:
 *
 *   (SN1)  r - r* = E y;  a slip has the column (1, mu t) / sqrt(1 + mu^2)
 *   (SN2)  A y = F of the rows of A
 *   (SN3)  |r - r*| = |y| <= |A^-1| |F|,   |F| = residual_u |q|
 *          |r - r*| <= |A^-1 D| |D^-1 F|,  |D^-1 F| = residual_r |r|,  D = diag(w) of the rows
 *
 * The rank is that of D^-1/2 A D^-1/2, in which units do not matter.
 *
 *   (SN4)  to first order r - r* is E A^-1 (row.u), since row.u = 0 at r*, where r lies on its
 *          cone: one factorisation, no bound. Slips and gaps up to 1000 |F|, but for an |F| of
 *          1e-8 |q| and more 1e-5 |q| or |F|, count as stick
 *   (SN5)  where that step takes contacts out of their cones, once more from there, these on their
 *          cones and slipping
 *   (SN7)  on the border of two states r is determined only if the matrices of both have
 *          determinants of the same sign. With A where contact c sticks, B = (A^-1)_cc, and the
 *          direction t of r_t, or of B_nt if r_c = 0, the determinants over that of A are
 *          free: det B,   slip: t.B_tt t - mu B_nt t
 *   (SN8)  and the error is at least that of u = W r + q rounded: eps (|W||r| + |q|)
 *   (SN6)  W of more than 60 rows may hide an error if it has few large eigenvalues:
 *          (tr S)^2 / |S|^2 < max(12, m / 16), S = D^-1/2 W D^-1/2, |S| Frobenius' norm, D the
 *          weights of the certificate. For k equal eigenvalues and no others the left side is k;
 *          two bodies on soft springs have 12. The error of ordinary elastic bodies is 1 to 100
 *          times their residual. And an answer that took so long that its prediction is at most a
 *          twentieth of the work may hide an error, too
 *
 * Cost: three times the singular values of a matrix of |rows|; of (SN4) one LU, and d solves for
 * each contact on a border. What can fail: states that change between r and r*; two contacts that
 * change from one border together.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "facts/facts.h"
#include "linear/blas.h"
#include "linear/dense.h"
#include "vi/newton/states_matrix.h"

static const double border =
    1e-6; /* share of the largest w r and u, within which a state is on it */

static const double within = 1000, small_u = 1e-5;               /* (SN4) */
enum { prediction_turns = 3 };                                   /* (SN5) */
static const double few_F = 10, few_roundings = 16;              /* (SN7) width of a border */
static const double few_directions = 12, rows_of_direction = 16; /* (SN6) */
static const double small_part = .05;                            /* of the work of a solve */

typedef struct sensitivity_work {
  const dls_contact *problem;
  const double *r;
  int rows;
  dlsi_branch *branch;      /* nc */
  double *w, *u, *x;        /* weights, 2 nc; m each: u = W r + q, one column */
  int *row;                 /* m: scratch */
  dls_contact_state *state; /* nc */
} sensitivity_work;

/* ---- borders --------------------------------------------------------------------------------- */

double dlsi_border_width(const dls_contact *problem, const double *w, const double *r,
                         const double *u, double residual) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  double most = 0;
  for (size_t k = 0; k < m; k++)
    most = fmax(most, fmax(fabs(u[k]), w[2 * (k / d) + (k % d > 0)] * fabs(r[k])));
  return fmax(border, 10 * residual) * most;
}

dls_contact_state dlsi_border_state(int d, double mu, dls_contact_state state, const double *w,
                                    const double *r, const double *u, double close) {
  const double slip = dlsi_tangent_norm(d, u);
  if (state == DLS_FREE && !(u[0] <= close)) return DLS_FREE;
  if (state == DLS_FREE) return mu > 0 && slip > close ? DLS_SLIP : DLS_STICK;
  if (w[0] * r[0] <= close) return DLS_FREE;
  if (!(mu > 0)) return state;
  if (state == DLS_SLIP) return slip <= close ? DLS_STICK : DLS_SLIP;
  return w[1] * (mu * r[0] - dlsi_tangent_norm(d, r)) <= close ? DLS_SLIP : DLS_STICK;
}

/* ---- the matrix ------------------------------------------------------------------------------ */

/* Fills A of (SN2), rows times w^a and columns times w^b over their length. scale: 2 rows, what
 * rows and columns were multiplied by. */
static void sensitivity_fill(sensitivity_work *work, double a, double b, double *A, double *scale) {
  const size_t n = (size_t)work->rows;
  for (int c = 0; c < work->problem->nc; c++) {
    const dlsi_branch *at = &work->branch[c];
    for (int i = 0; i < at->count; i++) {
      double e[3], *s = scale + at->first + i;
      const double w = work->w[2 * c + (i > 0)];
      dlsi_branch_direction(at, i, e);
      s[0] = a == 0 ? 1 : a == -0.5 ? 1 / sqrt(w) : 1 / w;
      s[n] = (b == 0 ? 1 : s[0]) / dlsi_norm2(e, 3);
    }
  }
  dlsi_states_fill(work->problem, work->branch, NULL, work->rows, work->row, work->x, A);
  for (size_t j = 0; j < n; j++)
    for (size_t i = 0; i < n; i++)
      A[i + j * n] = scale[i] * A[i + j * n] * scale[n + j];
}

/* value (rows) := the singular values of A, descending, which is lost. Returns 0 if it has an
 * entry beyond the range of numbers or LAPACK did not converge. */
static int sensitivity_singular_values(int n, double *A, double *value, double *lapack, int room) {
  const int one = 1;
  int info;
  double none[1];
  value[0] = 0;
  if (dlsi_first_not_finite(A, (size_t)n * (size_t)n) >= 0) return 0; /* LAPACK would print */
  dgesvd_("N", "N", &n, &n, A, &n, value, none, &one, none, &one, lapack, &room, &info, 1, 1);
  return info == 0;
}

/* Returns how much a residual of these scales counts in r: 1 / the least singular value. */
static double sensitivity_norm(sensitivity_work *work, double a, double *A, double *value,
                               double *lapack, int room) {
  const int n = work->rows;
  sensitivity_fill(work, a, 0, A, lapack);
  const int ok = sensitivity_singular_values(n, A, value, lapack, room);
  return ok && value[n - 1] > 0 ? 1 / value[n - 1] : INFINITY;
}

/* Returns |q| of the contacts that touch, which residual_u is relative to. */
static double touching_q(const sensitivity_work *work) {
  const size_t d = (size_t)work->problem->d;
  double q = 0;
  for (size_t c = 0; c < (size_t)work->problem->nc; c++)
    if (work->state[c] != DLS_FREE) q = hypot(q, dlsi_norm2(work->problem->q + d * c, d));
  return q;
}

/* Returns the rank of A, but for rounding; A: lost. value, lapack, room: as above. */
static int sensitivity_rank(sensitivity_work *work, double *A, double *value, double *lapack,
                            int room) {
  const int n = work->rows;
  int rank = 0;
  sensitivity_fill(work, -0.5, -0.5, A, lapack);
  const int ok = sensitivity_singular_values(n, A, value, lapack, room);
  for (int i = 0; ok && i < n; i++)
    rank += value[i] > 4 * n * DBL_EPSILON * value[0];
  return rank;
}

/* ---- the calls ------------------------------------------------------------------------------- */

/* Fills all of *s from the certificate and the rows. A: rows x rows. value: m. lapack: 8 m. */
static void sensitivity_measure(sensitivity_work *work, const dls_certificate *c, double *A,
                                double *value, double *lapack, dls_sensitivity *s) {
  const size_t m = (size_t)work->problem->d * (size_t)work->problem->nc;
  const int n = work->rows, room = 8 * (int)m;
  const double size_r = dlsi_norm2(work->r, m);
  s->rows = n;
  s->rank = n ? sensitivity_rank(work, A, value, lapack, room) : 0;
  s->isolated = s->border ? -1 : s->rank == n;
  if (s->rank < n)
    s->amplification = s->amplification_r = INFINITY;
  else if (n) {
    s->amplification =
        sensitivity_norm(work, 0, A, value, lapack, room) * touching_q(work) / size_r;
    s->amplification_r = sensitivity_norm(work, -1, A, value, lapack, room);
  }
  const double by_u = s->amplification * fmax(c->residual_u, c->floor_u);
  const double by_r = s->amplification_r * fmax(c->residual_r, c->floor_r);
  s->error = s->rank < n ? INFINITY : n ? fmin(by_u, by_r) : 0;
}

/* ---- prediction ------------------------------------------------------------------------------ */

/* sum := sum + s x^2, n each: of rows, so that no sum waits for itself. */
static void add_squares(size_t n, double s, const double *restrict x, double *restrict sum) {
  for (size_t i = 0; i < n; i++)
    sum[i] += s * x[i] * x[i];
}

int dlsi_is_small_part(double cost, const dls_info *info, double m) {
  const double spent = 2 * m * m * info->iterations + m * m * m / 3 * info->factorisations;
  return cost <= small_part * spent;
}

int dlsi_may_hide_error(const dls_contact *problem, const double *w, const dls_info *info) {
  const size_t d = (size_t)problem->d;
  const int nc = problem->nc;
  const double m = (double)d * nc;
  if (d * (size_t)nc <= dlsi_predicted_of_blocks) return 1;
  if (dlsi_is_small_part(m * m * m, info, m)) return 1;
  const dls_blocks *W = &problem->Wb;
  const size_t ld = (size_t)problem->W.ld, rows = (size_t)m;
  double inverse[dlsi_predicted_rows], sum[dlsi_predicted_rows] = {0}, trace = 0, square = 0;
  for (size_t i = 0; i < rows; i++)
    inverse[i] = 1 / w[2 * (i / d) + (i % d > 0)];
  for (size_t j = 0; j < rows && problem->W.a; j++) {
    add_squares(rows, inverse[j], problem->W.a + ld * j, sum);
    trace += problem->W.a[(ld + 1) * j] * inverse[j];
  }
  for (int c = 0; c < nc && !problem->W.a; c++)
    for (int k = W->p[c]; k < W->p[c + 1]; k++)
      for (size_t j = 0; j < d; j++) {
        const size_t column = d * (size_t)c + j;
        const double *x = W->x + d * (d * (size_t)k + j);
        add_squares(d, inverse[column], x, sum + d * (size_t)W->i[k]);
        if (W->i[k] == c) trace += x[j] * inverse[column];
      }
  for (size_t i = 0; i < rows; i++)
    square += sum[i] * inverse[i];
  return !(trace * trace >= fmax(few_directions, m / rows_of_direction) * square);
}

/* Returns 0 where a pivot of the factors is the rounding of the largest one. */
static int prediction_is_regular(const dlsi_dense *f) {
  const size_t n = (size_t)f->n;
  double most = 0, least = INFINITY;
  for (size_t k = 0; k < n; k++) {
    most = fmax(most, fabs(f->A[k * (n + 1)]));
    least = fmin(least, fabs(f->A[k * (n + 1)]));
  }
  return least > 4 * f->n * DBL_EPSILON * most;
}

/* y := the rows of v over their weights. */
static void prediction_rows(const sensitivity_work *work, const double *v, double *y) {
  dlsi_branches_rows(work->problem->d, work->problem->nc, work->branch, v, y);
  for (int c = 0; c < work->problem->nc; c++)
    for (int i = 0; i < work->branch[c].count; i++)
      y[work->branch[c].first + i] /= work->w[2 * c + (i > 0)];
}

/* y := A^-1 y and x := E y. scale: of the columns of A. */
static void prediction_solve(const sensitivity_work *work, const dlsi_dense *f, const double *scale,
                             double *y, double *x) {
  dlsi_dense_solve(f, y, f->n, 1);
  for (int j = 0; j < f->n; j++)
    y[j] *= scale[j];
  memset(x, 0, (size_t)work->problem->d * (size_t)work->problem->nc * sizeof *x);
  dlsi_branches_add_directions(work->problem->d, work->problem->nc, work->branch, y, x);
}

/* (SN8) Returns |E A^-1 e| for e = +-eps a, with the signs for which Hager's estimate of |A^-1| is
 * largest (Higham, Accuracy and Stability of Numerical Algorithms, 15.3). x: scratch, m. */
static double prediction_rounding(const sensitivity_work *work, const dlsi_dense *f,
                                  const double *scale, const double *a, double *x) {
  enum { most = dlsi_predicted_rows };
  const size_t m = (size_t)work->problem->d * (size_t)work->problem->nc;
  double e[most], y[most];
  prediction_rows(work, a, e);
  for (int j = 0; j < f->n; j++)
    y[j] = (j % 2 ? -e[j] : e[j]) * (1 + (double)j / f->n);
  prediction_solve(work, f, scale, y, x);
  for (int j = 0; j < f->n; j++)
    y[j] = y[j] < 0 ? -scale[j] : scale[j];
  dlsi_dense_solve_transposed(f, y);
  for (int j = 0; j < f->n; j++)
    y[j] = y[j] < 0 ? -e[j] : e[j];
  prediction_solve(work, f, scale, y, x);
  return DBL_EPSILON * dlsi_norm2(x, m);
}

static double determinant(int n, const double (*B)[3]) {
  if (n == 1) return B[0][0];
  if (n == 2) return B[0][0] * B[1][1] - B[0][1] * B[1][0];
  return B[0][0] * (B[1][1] * B[2][2] - B[1][2] * B[2][1]) -
         B[0][1] * (B[1][0] * B[2][2] - B[1][2] * B[2][0]) +
         B[0][2] * (B[1][0] * B[2][1] - B[1][1] * B[2][0]);
}

/* (SN7) Returns 0 if contact c, within `close` of the border of two states, has matrices whose
 * determinants differ in sign. */
static int prediction_has_one_side(const sensitivity_work *work, const dlsi_dense *f, int c,
                                   double close) {
  enum { most = dlsi_predicted_rows };
  const dlsi_branch *at = &work->branch[c];
  const int d = work->problem->d, n = at->count;
  const double *w = work->w + 2 * c, *r = work->r + d * c, *u = work->u + d * c;
  const double size = dlsi_tangent_norm(d, r), slip = dlsi_tangent_norm(d, u), mu = at->mu;
  const int opens = w[0] * r[0] <= close && u[0] <= close;
  const int slips = mu > 0 && at->state == DLS_STICK && n > 1 && !dlsi_is_bonded(mu) &&
                    slip <= close && w[1] * (mu * r[0] - size) <= close;
  double B[3][3] = {{0}}, y[most], t[2] = {0, 0}, tBt = 0, nBt = 0;
  if (n == 0 || !(opens || slips)) return 1;
  for (int j = 0; j < n; j++) {
    memset(y, 0, (size_t)f->n * sizeof *y);
    y[at->first + j] = 1 / w[j > 0];
    dlsi_dense_solve(f, y, f->n, 1);
    for (int i = 0; i < n; i++)
      B[i][j] = y[at->first + i];
  }
  if (opens && !(determinant(n, (const double(*)[3])B) > 0)) return 0;
  if (!slips) return 1;
  const double *from = opens ? B[0] : r, length = opens ? dlsi_tangent_norm(d, B[0]) : size;
  for (int i = 1; i < n; i++)
    t[i - 1] = length > 0 ? from[i] / length : i == 1;
  for (int i = 1; i < n; i++) {
    nBt += B[0][i] * t[i - 1];
    for (int j = 1; j < n; j++)
      tBt += t[i - 1] * B[i][j] * t[j - 1];
  }
  return tBt - mu * nBt > 0;
}

/* (SN4) x := the step from r to r*. slips: contacts that slip, whatever they look like. a: |W||r|
 * + |q|, or NULL after the first step; rounding: (SN8), 0 without a. Returns 0 where r is not
 * determined. */
static int prediction_step(sensitivity_work *work, const unsigned char *slips, const double *a,
                           double *J, double *rounding) {
  enum { most = dlsi_predicted_rows };
  const dls_contact *problem = work->problem;
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  double scale[2 * most], beside[most], *x = work->x;
  int pivot[most];
  for (int c = 0; c < problem->nc; c++) {
    const size_t o = d * (size_t)c;
    work->state[c] = dlsi_contact_misfit(problem->d, problem->mu[c], work->w + 2 * c, work->r + o,
                                         work->u + o, x + o);
  }
  const double F = dlsi_norm2(x, m), q = dlsi_norm2(problem->q, m);
  const double small = fmin(within * F, fmax(F, small_u * q)); /* F would hide less than these u */
  for (int c = 0; c < problem->nc; c++) {
    const double *uc = work->u + d * (size_t)c, slip = dlsi_tangent_norm(problem->d, uc);
    double size = 0;
    for (size_t i = 0; a && i < d; i++)
      size = fmax(size, a[d * (size_t)c + i]);
    beside[c] = fmax(few_F * F, few_roundings * DBL_EPSILON * size);
    const double close = a ? fmax(small, beside[c]) : small;
    if (work->state[c] == DLS_SLIP && slip <= close) work->state[c] = DLS_STICK;
    if (work->state[c] == DLS_FREE && uc[0] <= close) work->state[c] = DLS_STICK;
    if (slips[c] && work->state[c] == DLS_STICK) work->state[c] = DLS_SLIP;
  }
  work->rows = dlsi_branches_set(problem, work->state, work->r, work->u, work->branch);
  memset(x, 0, m * sizeof *x);
  *rounding = 0;
  const size_t n = (size_t)work->rows;
  if (n == 0) return 1;
  sensitivity_fill(work, -1, 0, J, scale); /* no roots: units of two keep all bits */
  dlsi_dense f = {.n = work->rows, .A = J, .pivot = pivot};
  if (dlsi_first_not_finite(J, n * n) >= 0 || dlsi_dense_lu(&f)) return 0;
  if (!prediction_is_regular(&f)) return 0;
  for (int c = 0; a && c < problem->nc; c++)
    if (!prediction_has_one_side(work, &f, c, beside[c])) return 0;
  if (a) *rounding = prediction_rounding(work, &f, scale + n, a, x);
  prediction_rows(work, work->u, beside);
  prediction_solve(work, &f, scale + n, beside, x);
  return 1;
}

/* next (m) := r - x, put back on the cones that it leaves. slips: set for these contacts. Returns
 * how many are new. */
static int prediction_return(const sensitivity_work *work, unsigned char *slips, double *next) {
  const dls_contact *problem = work->problem;
  const int d = problem->d;
  int left = 0;
  for (int c = 0; c < problem->nc; c++) {
    double *r = next + d * c;
    for (int i = 0; i < d; i++)
      r[i] = work->r[d * c + i] - work->x[d * c + i];
    r[0] = fmax(r[0], 0);
    const double t = dlsi_tangent_norm(d, r), bound = dlsi_friction_bound(problem->mu[c], r[0]);
    if (t <= bound) continue;
    for (int i = 1; i < d; i++)
      r[i] *= bound / t;
    left += !slips[c] && work->state[c] == DLS_STICK;
    slips[c] = 1;
  }
  return left;
}

double dlsi_predict_error(const dls_contact *problem, const double *r, double *w, double *J,
                          double *x) {
  enum { most = dlsi_predicted_rows };
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  dlsi_branch branch[most];
  dls_contact_state state[most];
  int row[most];
  unsigned char slips[most] = {0};
  double next[2][most], u[most], a[most], error = 0, size = dlsi_norm2(r, m);
  sensitivity_work work = {problem, r, 0, branch, w, u, x, row, state};
  dlsi_contact_multiply(problem, NULL, r, u, a);
  for (size_t i = 0; i < m; i++)
    a[i] += fabs(problem->q[i]);
  for (int turn = 0; turn < prediction_turns; turn++) {
    double far[most], rounding;
    if (!prediction_step(&work, slips, turn ? NULL : a, J, &rounding)) return turn ? error : -1;
    for (size_t i = 0; i < m; i++)
      far[i] = r[i] - (work.r[i] - x[i]);
    error = fmax(error, fmax(rounding, dlsi_norm2(far, m)) / size);
    if (!prediction_return(&work, slips, next[turn % 2])) return error;
    work.r = next[turn % 2];
    dlsi_contact_multiply(problem, NULL, work.r, u, NULL);
  }
  return error;
}

void dlsi_contact_touch(const dls_contact *problem, const double *u, double close,
                        dls_contact_state *state) {
  for (int c = 0; c < problem->nc; c++) {
    const double *uc = u + (size_t)problem->d * (size_t)c;
    const int slips = problem->mu[c] > 0 && dlsi_tangent_norm(problem->d, uc) > close;
    state[c] = uc[0] > close ? DLS_FREE : slips ? DLS_SLIP : DLS_STICK;
  }
}

/* Does the work of both calls; the one not asked for has NULL. */
static dls_status sensitivity_run(const dls_contact *problem, const double *r,
                                  dls_sensitivity *sensitivity, int *freedom, dls_error *error) {
  const size_t nc = (size_t)problem->nc, m = (size_t)problem->d * nc;
  if (m > INT_MAX / 8) return dlsi_fail(error, DLS_E_SIZE, "nc", -1, problem->nc, "is too large");
  sensitivity_work work = {.problem = problem, .r = r};
  dls_certificate certificate;
  double *memory = dlsi_alloc(2 * nc + 11 * m, sizeof *memory), *A = NULL;
  work.state = dlsi_alloc(nc, sizeof *work.state);
  work.branch = dlsi_alloc(nc, sizeof *work.branch);
  work.row = dlsi_alloc(m, sizeof *work.row);
  dls_status status =
      memory && work.state && work.branch && work.row ? DLS_OK : dlsi_no_memory(error);
  if (!status) {
    work.w = memory;
    work.u = memory + 2 * nc;
    work.x = work.u + m;
    status = dls_contact_certify(problem, r, work.u, &certificate, error);
  }
  if (!status && sensitivity) status = dls_contact_states(problem, r, work.u, work.state, error);
  if (!status) {
    const int d = problem->d;
    dlsi_certificate_weights(problem, work.w);
    const double close = dlsi_border_width(problem, work.w, r, work.u, certificate.residual);
    if (freedom) dlsi_contact_touch(problem, work.u, close, work.state);
    dls_sensitivity s = {0};
    for (int c = 0; sensitivity && c < problem->nc; c++)
      s.border += work.state[c] != dlsi_border_state(d, problem->mu[c], work.state[c],
                                                     work.w + 2 * (size_t)c, r + d * c,
                                                     work.u + d * c, close);
    work.rows = dlsi_branches_set(problem, work.state, r, work.u, work.branch);
    const size_t n = (size_t)work.rows;
    double *value = work.x + m, *lapack = value + m;
    A = dlsi_alloc(n, n * sizeof *A);
    if (!A) status = dlsi_no_memory(error);
    if (!status && sensitivity) {
      sensitivity_measure(&work, &certificate, A, value, lapack, &s);
      *sensitivity = s;
    }
    if (!status && freedom)
      *freedom = n ? work.rows - sensitivity_rank(&work, A, value, lapack, 8 * (int)m) : 0;
  }
  free(A);
  free(memory);
  free(work.state);
  free(work.branch);
  free(work.row);
  return status;
}

/* name: of the argument asked for. */
static dls_status sensitivity_call(const dls_contact *problem, const double *r, const char *name,
                                   dls_sensitivity *sensitivity, int *freedom, dls_error *error) {
  dlsi_formed formed = {.work = NULL};
  dlsi_units units = {.W = 0};
  dls_status status = dlsi_check_blas(error);
  if (!status) status = dlsi_check_contact(problem, error);
  if (!status) status = dlsi_check_vector("r", r, (size_t)problem->d * (size_t)problem->nc, error);
  if (!status && !sensitivity && !freedom) status = dlsi_is_null(error, name);
  if (!status) status = dlsi_take_answer(&units, &problem, &r, error);
  if (!status) status = dlsi_form_blocks(&formed, &problem, error);
  if (!status) status = sensitivity_run(problem, r, sensitivity, freedom, error);
  dlsi_formed_free(&formed);
  dlsi_units_free(&units);
  return status;
}

dls_status dls_contact_sensitivity(const dls_contact *problem, const double *r,
                                   dls_sensitivity *sensitivity, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, sensitivity_call(problem, r, "sensitivity", sensitivity, NULL, error),
                 error);
}

dls_status dls_contact_freedom(const dls_contact *problem, const double *r, int *freedom,
                               dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, sensitivity_call(problem, r, "freedom", NULL, freedom, error), error);
}
