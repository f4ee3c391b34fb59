/* check.c: checks the arguments of public functions, in O(nnz), naming the wrong argument and
 * index. */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>

#include "base/base.h"

/* ---- numbers and vectors --------------------------------------------------------------------- */

dls_status dlsi_check_dimension(const char *argument, int d, dls_error *error) {
  if (d >= 1 && d <= 3) return DLS_OK;
  return dlsi_fail(error, DLS_E_ARGUMENT, argument, -1, d, "is %d, must be 1, 2 or 3", d);
}

dls_status dlsi_check_sizes(int d, int nc, dls_error *error) {
  const dls_status status = dlsi_check_dimension("d", d, error);
  if (status) return status;
  if (nc < 0) return dlsi_fail(error, DLS_E_SIZE, "nc", -1, nc, "is %d, must not be negative", nc);
  if (nc > INT32_MAX / d)
    return dlsi_fail(error, DLS_E_SIZE, "nc", -1, nc, "is %d, which is too large", nc);
  return DLS_OK;
}

dls_status dlsi_check_vector(const char *argument, const double *x, size_t n, dls_error *error) {
  if (n == 0) return DLS_OK;
  if (!x) return dlsi_is_null(error, argument);
  const long long bad = dlsi_first_not_finite(x, n);
  if (bad < 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_NOT_FINITE, argument, bad, x[bad], "is not finite");
}

dls_status dlsi_check_friction(const double *mu, size_t n, dls_error *error) {
  if (!mu && n > 0) return dlsi_is_null(error, "mu");
  for (size_t c = 0; c < n; c++) {
    if (mu[c] != mu[c] || mu[c] < -DBL_MAX)
      return dlsi_fail(error, DLS_E_NOT_FINITE, "mu", (long long)c, mu[c], "is not finite");
    if (mu[c] < 0)
      return dlsi_fail(error, DLS_E_ARGUMENT, "mu", (long long)c, mu[c], "is negative");
  }
  return DLS_OK;
}

int dlsi_first_bonded(const dls_contact *problem) {
  for (int c = 0; c < problem->nc; c++)
    if (dlsi_is_bonded(problem->mu[c])) return c;
  return -1;
}

dls_status dlsi_refuse_bonded(const dls_contact *problem, dls_error *error) {
  const int c = dlsi_first_bonded(problem);
  if (c < 0) return DLS_OK;
  return dlsi_fail(
      error, DLS_E_UNSUPPORTED, "mu", c, problem->mu[c],
      "is infinite, which auto, nlgs, newton, admm, augmented-lagrangian and penalty take");
}

/* ---- matrices -------------------------------------------------------------------------------- */

static dls_status check_shape(const char *argument, int rows, int cols, int rows_wanted,
                              int cols_wanted, dls_error *error) {
  if (rows == rows_wanted && cols == cols_wanted) return DLS_OK;
  return dlsi_fail(error, DLS_E_SIZE, argument, -1, rows, "is %d x %d, must be %d x %d", rows, cols,
                   rows_wanted, cols_wanted);
}

dls_status dlsi_check_dense(const char *argument, const dls_dense *A, int rows, int cols,
                            dls_error *error) {
  if (!A->a) return dlsi_is_null(error, argument);
  const dls_status status = check_shape(argument, A->rows, A->cols, rows, cols, error);
  if (status) return status;
  if (A->ld < rows || A->ld < 1)
    return dlsi_fail(error, DLS_E_SIZE, argument, -1, A->ld, "leading dimension %d is less than %d",
                     A->ld, rows > 1 ? rows : 1);
  for (int j = 0; j < cols; j++) {
    const size_t start = (size_t)j * (size_t)A->ld;
    const long long bad = dlsi_first_not_finite(A->a + start, (size_t)rows);
    if (bad >= 0)
      return dlsi_fail(error, DLS_E_NOT_FINITE, argument, bad + (long long)start,
                       A->a[start + (size_t)bad], "is not finite (row %lld, column %d)", bad, j);
  }
  return DLS_OK;
}

/* Checks the arrays of a compressed column format. name: of p, i, x. p: cols + 1. i: p[cols]
 * indices below rows. x: p[cols] entries of `size` doubles. */
static dls_status check_columns(const char *const name[3], const int *p, const int *i,
                                const double *x, int size, int rows, int cols, dls_error *error) {
  if (!p) return dlsi_is_null(error, name[0]);
  const int count = p[cols];
  if (!i && count > 0) return dlsi_is_null(error, name[1]);
  if (p[0] != 0) return dlsi_fail(error, DLS_E_ARGUMENT, name[0], 0, p[0], "must be 0");
  for (int j = 0; j < cols; j++)
    if (p[j + 1] < p[j])
      return dlsi_fail(error, DLS_E_ARGUMENT, name[0], j + 1, p[j + 1],
                       "is less than the one before it");
  for (int k = 0; k < count; k++)
    if (i[k] < 0 || i[k] >= rows)
      return dlsi_fail(error, DLS_E_ARGUMENT, name[1], k, i[k], "is outside of 0 .. %d", rows - 1);
  return count ? dlsi_check_vector(name[2], x, (size_t)count * (size_t)size, error) : DLS_OK;
}

dls_status dlsi_check_sparse(const char *argument, const dls_sparse *A, int rows, int cols,
                             dls_error *error) {
  const char *const names[3] = {argument, argument, argument};
  const dls_status status = check_shape(argument, A->rows, A->cols, rows, cols, error);
  return status ? status : check_columns(names, A->p, A->i, A->x, 1, rows, cols, error);
}

dls_status dlsi_check_blocks(const dls_blocks *B, dls_error *error) {
  static const char *const names[3] = {"B.p", "B.i", "B.x"};
  if (!B) return dlsi_is_null(error, "B");
  const dls_status status = dlsi_check_dimension("B.d", B->d, error);
  if (status) return status;
  if (B->n < 0 || B->n > INT32_MAX / B->d)
    return dlsi_fail(error, DLS_E_SIZE, "B.n", -1, B->n, "is %d", B->n);
  return check_columns(names, B->p, B->i, B->x, B->d * B->d, B->n, B->n, error);
}

/* ---- the contact problem --------------------------------------------------------------------- */

static dls_status check_Wb(const dls_contact *problem, dls_error *error) {
  static const char *const names[3] = {"Wb.p", "Wb.i", "Wb.x"};
  const dls_blocks *B = &problem->Wb;
  if (B->d != problem->d)
    return dlsi_fail(error, DLS_E_SIZE, "Wb.d", -1, B->d, "must be %d", problem->d);
  if (B->n != problem->nc)
    return dlsi_fail(error, DLS_E_SIZE, "Wb.n", -1, B->n, "must be %d", problem->nc);
  return check_columns(names, B->p, B->i, B->x, B->d * B->d, B->n, B->n, error);
}

/* Checks the bodies of a contact and its blocks of H. Their squares may not overflow: then no entry
 * of W does. */
static dls_status check_bodies_of(const dls_contact *problem, size_t c, dls_error *error) {
  const dls_bodies *B = &problem->bodies;
  const size_t size = (size_t)B->n * (size_t)problem->d;
  double squares = 0;
  for (size_t k = 2 * c; k < 2 * c + 2; k++) {
    const int b = B->body[k];
    if (b < -1 || b >= B->count)
      return dlsi_fail(error, DLS_E_ARGUMENT, "bodies.body", (long long)k, b,
                       "is %d, must be from -1 to %d", b, B->count - 1);
    const long long at = b < 0 ? -1 : dlsi_first_not_finite(B->H + k * size, size);
    if (at >= 0)
      return dlsi_fail(error, DLS_E_NOT_FINITE, "bodies.H", (long long)(k * size) + at,
                       B->H[k * size + (size_t)at], "is not finite");
    for (size_t e = k * size; b >= 0 && e < (k + 1) * size; e++)
      squares += B->H[e] * B->H[e];
  }
  if (!isfinite(squares))
    return dlsi_fail(error, DLS_E_NOT_FINITE, "bodies.H", (long long)(2 * c * size), squares,
                     "gives a W that is not finite");
  if (B->body[2 * c] < 0 || B->body[2 * c] != B->body[2 * c + 1]) return DLS_OK;
  return dlsi_fail(error, DLS_E_ARGUMENT, "bodies.body", (long long)(2 * c + 1), B->body[2 * c + 1],
                   "is %d, as the other body of candidate %zu", B->body[2 * c + 1], c);
}

static dls_status check_bodies(const dls_contact *problem, dls_error *error) {
  const dls_bodies *B = &problem->bodies;
  const int d = problem->d;
  if (!(B->n == 3 || B->n == 6) || (d > 1 && B->n != 3 * (d - 1)))
    return dlsi_fail(error, DLS_E_SIZE, "bodies.n", -1, B->n, "is %d, must be %s", B->n,
                     d == 1   ? "3 or 6"
                     : d == 2 ? "3"
                              : "6");
  if (B->count < 0 || B->count > INT32_MAX / 12)
    return dlsi_fail(error, DLS_E_SIZE, "bodies.count", -1, B->count, "is %d", B->count);
  if (!B->body) return dlsi_is_null(error, "bodies.body");
  if (B->work && !problem->Wb.x)
    return dlsi_fail(error, DLS_E_ARGUMENT, "bodies.work", -1, 0, "must be NULL");
  dls_status status = DLS_OK;
  for (size_t c = 0; !status && c < (size_t)problem->nc; c++)
    status = check_bodies_of(problem, c, error);
  return status;
}

dls_status dlsi_check_contact(const dls_contact *problem, dls_error *error) {
  if (!problem) return dlsi_is_null(error, "problem");
  dls_status status = dlsi_check_sizes(problem->d, problem->nc, error);
  if (status || problem->nc == 0) return status;
  const int m = problem->d * problem->nc;
  if (problem->W.a && problem->Wb.x)
    return dlsi_fail(error, DLS_E_ARGUMENT, "Wb", -1, 0, "W and Wb are both given");
  const int formed = problem->bodies.work && problem->Wb.x; /* by dlsi_form_blocks */
  if (problem->bodies.H && !formed && (problem->W.a || problem->Wb.x))
    return dlsi_fail(error, DLS_E_ARGUMENT, "bodies", -1, 0, "%s and bodies are both given",
                     problem->W.a ? "W" : "Wb");
  status = problem->bodies.H ? check_bodies(problem, error)
           : problem->Wb.x   ? check_Wb(problem, error)
                             : dlsi_check_dense("W", &problem->W, m, m, error);
  if (!status) status = dlsi_check_vector("q", problem->q, (size_t)m, error);
  if (!status) status = dlsi_check_friction(problem->mu, (size_t)problem->nc, error);
  const size_t weights = problem->weights ? 2 * (size_t)problem->nc : 0;
  if (!status && weights) status = dlsi_check_vector("weights", problem->weights, weights, error);
  for (size_t k = 0; !status && k < weights; k++)
    if (!(problem->weights[k] > 0))
      return dlsi_fail(error, DLS_E_ARGUMENT, "weights", (long long)k, problem->weights[k],
                       "is %g, must be > 0", problem->weights[k]);
  for (int c = 0; !status && problem->d == 1 && c < problem->nc; c++)
    if (problem->mu[c] > 0)
      return dlsi_fail(error, DLS_E_ARGUMENT, "mu", c, problem->mu[c],
                       "is %g, must be 0 where d = 1: there are no tangents", problem->mu[c]);
  return status;
}

/* A named array. */
typedef struct span {
  const char *name;
  const void *start;
  size_t bytes;
} span;

static int spans_overlap(const span *a, const span *b) {
  const uintptr_t p = (uintptr_t)a->start, q = (uintptr_t)b->start;
  return a->start && b->start && p < q + b->bytes && q < p + a->bytes;
}

dls_status dlsi_check_apart(const dls_contact *problem, const double *r, const double *u,
                            dls_error *error) {
  const size_t d = (size_t)problem->d, nc = (size_t)problem->nc, m = d * nc, D = sizeof(double);
  if (m == 0) return DLS_OK;
  const dls_blocks *B = &problem->Wb;
  const dls_bodies *H = &problem->bodies;
  const span W = H->H   ? (span){"bodies.H", H->H, 2 * (size_t)H->n * m * D}
                 : B->x ? (span){"Wb.x", B->x, d * d * (size_t)B->p[nc] * D}
                        : (span){"W", problem->W.a, ((size_t)problem->W.ld * (m - 1) + m) * D};
  const span other[] = {W,
                        {"q", problem->q, m * D},
                        {"mu", problem->mu, nc * D},
                        {"weights", problem->weights, 2 * nc * D},
                        {"u", u, m * D}};
  const span own[] = {{"r", r, m * D}, {"u", u, m * D}};
  for (size_t k = 0; k < 2; k++)
    for (size_t j = 0; j < 5 - k; j++)
      if (spans_overlap(&own[k], &other[j]))
        return dlsi_fail(error, DLS_E_ARGUMENT, own[k].name, -1, 0, "overlaps %s", other[j].name);
  return DLS_OK;
}

dls_status dlsi_check_start(const dls_contact *problem, const double *r, const double *u,
                            int warm_start, dls_error *error) {
  if (!r && problem->nc > 0) return dlsi_is_null(error, "r");
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const dls_status status = dlsi_check_apart(problem, r, u, error);
  if (status) return status;
  return warm_start ? dlsi_check_vector("r", r, m, error) : DLS_OK;
}

dls_status dlsi_check_solve(int d, int nc, const dls_contact *problem, const double *r,
                            const double *u, int warm_start, dls_error *error) {
  const dls_status status = dlsi_check_contact(problem, error);
  if (status) return status;
  if (problem->d != d)
    return dlsi_fail(error, DLS_E_SIZE, "problem", -1, problem->d,
                     "has d = %d, the workspace is for %d", problem->d, d);
  if (problem->nc > nc)
    return dlsi_fail(error, DLS_E_SIZE, "problem", -1, problem->nc,
                     "has %d candidate%s, the workspace is for %d", problem->nc,
                     problem->nc == 1 ? "" : "s", nc);
  return dlsi_check_start(problem, r, u, warm_start, error);
}

dls_status dls_contact_check(const dls_contact *problem, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, dlsi_check_contact(problem, error), error);
}

/* ---- settings -------------------------------------------------------------------------------- */

void dlsi_limits_init(dls_limits *limits) {
  *limits = (dls_limits){.tol = 1e-8, .threads = 1};
}

static dls_status check_setting(const dlsi_setting *s, dls_error *error) {
  const double x = s->value;
  const int inside = s->open ? x > s->lowest && x < s->highest : x >= s->lowest && x <= s->highest;
  if (inside) return DLS_OK;
  if (s->highest >= INT_MAX)
    return dlsi_fail(error, DLS_E_ARGUMENT, s->name, -1, x, "is %g, must be %s %g, finite", x,
                     s->open ? ">" : ">=", s->lowest);
  return dlsi_fail(error, DLS_E_ARGUMENT, s->name, -1, x, "is %g, must be %s %g %s %g", x,
                   s->open ? "between" : "from", s->lowest, s->open ? "and" : "to", s->highest);
}

dls_status dlsi_check_each(int count, const dlsi_setting *setting, dls_error *error) {
  dls_status status = DLS_OK;
  for (int k = 0; !status && k < count; k++)
    status = check_setting(&setting[k], error);
  return status;
}

dls_status dlsi_check_limits(const dls_limits *limits, dls_error *error) {
  const dlsi_setting shared[] = {{"tol", limits->tol, 0, DBL_MAX, 0},
                                 {"max_iterations", limits->max_iterations, 0, INT_MAX, 0},
                                 {"warm_start", limits->warm_start, 0, 1, 0},
                                 {"blocks", limits->blocks, 0, INT_MAX, 0},
                                 {"threads", limits->threads, 0, dlsi_most_threads, 0},
                                 {"cpu_seconds", limits->cpu_seconds, 0, DBL_MAX, 0}};
  return dlsi_check_each((int)(sizeof shared / sizeof shared[0]), shared, error);
}

dls_status dlsi_check_settings(const dls_limits *limits, size_t size, size_t wanted, int count,
                               const dlsi_setting *own, dls_error *error) {
  if (size != wanted)
    return dlsi_fail(error, DLS_E_SETTINGS, "settings", -1, (double)size,
                     "are not filled by their init function");
  const dls_status status = dlsi_check_limits(limits, error);
  return status ? status : dlsi_check_each(count, own, error);
}
