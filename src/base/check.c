/* check.c: the checks of the views, once, O(nnz), naming argument and index. */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "base/base.h"

static inline dls_status check_vector(const char *argument, const double *x, size_t n,
                                      dls_error *error) {
  if (!x) return dlsi_is_null(error, argument);
  const long long bad = dlsi_first_not_finite(x, n);
  if (bad < 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_NOT_FINITE, argument, bad, x[bad], "is not finite");
}

dls_status dlsi_check_vector(const char *argument, const double *x, size_t n, dls_error *error) {
  return check_vector(argument, x, n, error);
}

dls_status dlsi_check_dense(const char *argument, const dls_dense *A, int rows, int cols,
                            dls_error *error) {
  if (!A->a) return dlsi_is_null(error, argument);
  if (A->rows != rows || A->cols != cols)
    return dlsi_fail(error, DLS_E_SIZE, argument, -1, A->rows, "is %d x %d, must be %d x %d",
                     A->rows, A->cols, rows, cols);
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

/* p and i of a compressed column format with `cols` columns; where = name of the array at fault */
static dls_status check_pattern(const char *name_p, const char *name_i, const int *p, const int *i,
                                int rows, int cols, dls_error *error) {
  if (!p) return dlsi_is_null(error, name_p);
  const int count = p[cols];
  if (!i && count > 0) return dlsi_is_null(error, name_i);
  if (p[0] != 0) return dlsi_fail(error, DLS_E_ARGUMENT, name_p, 0, p[0], "must be 0");
  for (int j = 0; j < cols; j++)
    if (p[j + 1] < p[j])
      return dlsi_fail(error, DLS_E_ARGUMENT, name_p, j + 1, p[j + 1],
                       "is less than the one before it");
  for (int k = 0; k < count; k++)
    if (i[k] < 0 || i[k] >= rows)
      return dlsi_fail(error, DLS_E_ARGUMENT, name_i, k, i[k], "is outside of 0 .. %d", rows - 1);
  return DLS_OK;
}

dls_status dlsi_check_sparse(const char *argument, const dls_sparse *A, int rows, int cols,
                             dls_error *error) {
  if (A->rows != rows || A->cols != cols)
    return dlsi_fail(error, DLS_E_SIZE, argument, -1, A->rows, "is %d x %d, must be %d x %d",
                     A->rows, A->cols, rows, cols);
  const dls_status status = check_pattern(argument, argument, A->p, A->i, rows, cols, error);
  if (status) return status;
  if (A->p[cols] == 0) return DLS_OK;
  return check_vector(argument, A->x, (size_t)A->p[cols], error);
}

/* names: of p, i, x */
static dls_status check_blocks(const char *const names[3], const dls_blocks *B, dls_error *error) {
  const dls_status status = check_pattern(names[0], names[1], B->p, B->i, B->n, B->n, error);
  if (status || B->p[B->n] == 0) return status;
  return check_vector(names[2], B->x, (size_t)B->p[B->n] * (size_t)(B->d * B->d), error);
}

dls_status dlsi_check_blocks(const dls_blocks *B, dls_error *error) {
  static const char *const names[3] = {"B.p", "B.i", "B.x"};
  if (!B) return dlsi_is_null(error, "B");
  if (B->d != 2 && B->d != 3)
    return dlsi_fail(error, DLS_E_ARGUMENT, "B.d", -1, B->d, "is %d, must be 2 or 3", B->d);
  if (B->n < 0 || B->n > INT32_MAX / B->d)
    return dlsi_fail(error, DLS_E_SIZE, "B.n", -1, B->n, "is %d", B->n);
  return check_blocks(names, B, error);
}

static dls_status check_Wb(const dls_contact *problem, dls_error *error) {
  static const char *const names[3] = {"Wb.p", "Wb.i", "Wb.x"};
  const dls_blocks *B = &problem->Wb;
  if (B->d != problem->d)
    return dlsi_fail(error, DLS_E_SIZE, "Wb.d", -1, B->d, "must be %d", problem->d);
  if (B->n != problem->nc)
    return dlsi_fail(error, DLS_E_SIZE, "Wb.n", -1, B->n, "must be %d", problem->nc);
  return check_blocks(names, B, error);
}

dls_status dlsi_check_contact(const dls_contact *problem, dls_error *error) {
  if (!problem) return dlsi_is_null(error, "problem");
  const int d = problem->d, nc = problem->nc;
  dls_status status = dlsi_check_sizes(d, nc, error);
  if (status) return status;
  const int m = d * nc;
  if (problem->W.a && problem->Wb.x)
    return dlsi_fail(error, DLS_E_ARGUMENT, "Wb", -1, 0, "W and Wb are both given");
  status =
      problem->Wb.x ? check_Wb(problem, error) : dlsi_check_dense("W", &problem->W, m, m, error);
  if (status) return status;
  status = check_vector("q", problem->q, (size_t)m, error);
  if (status) return status;
  status = check_vector("mu", problem->mu, (size_t)nc, error);
  if (status) return status;
  for (int c = 0; c < nc; c++)
    if (problem->mu[c] < 0)
      return dlsi_fail(error, DLS_E_ARGUMENT, "mu", c, problem->mu[c], "is negative");
  return DLS_OK;
}

dls_status dlsi_check_sizes(int d, int nc, dls_error *error) {
  if (d != 2 && d != 3)
    return dlsi_fail(error, DLS_E_ARGUMENT, "d", -1, d, "is %d, must be 2 or 3", d);
  if (nc < 1) return dlsi_fail(error, DLS_E_SIZE, "nc", -1, nc, "is %d, must be at least 1", nc);
  if (nc > INT32_MAX / d)
    return dlsi_fail(error, DLS_E_SIZE, "nc", -1, nc, "is %d, which is too large", nc);
  return DLS_OK;
}

void dlsi_limits_init(dls_limits *limits) {
  *limits = (dls_limits){.tol = 1e-8};
}

static dls_status check_setting(const dlsi_setting *s, dls_error *error) {
  const double x = s->value;
  const int inside = s->open ? x > s->lowest && x < s->highest : x >= s->lowest && x <= s->highest;
  if (inside) return DLS_OK;
  if (s->highest >= INT_MAX)
    return dlsi_fail(error, DLS_E_ARGUMENT, s->name, -1, x, "is %g, must be %s %g, finite", x,
                     s->open ? ">" : ">=", s->lowest);
  return dlsi_fail(error, DLS_E_ARGUMENT, s->name, -1, x, "is %g, must be %s %g and %g", x,
                   s->open ? "between" : "from", s->lowest, s->highest);
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
                                 {"blocks", limits->blocks, 0, INT_MAX, 0}};
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

dls_status dlsi_check_start(const dls_contact *problem, const double *r, int warm_start,
                            dls_error *error) {
  if (!r) return dlsi_is_null(error, "r");
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  return warm_start ? check_vector("r", r, m, error) : DLS_OK;
}

dls_status dlsi_check_solve(int d, int nc, const dls_contact *problem, const double *r,
                            int warm_start, dls_error *error) {
  const dls_status status = dlsi_check_contact(problem, error);
  if (status) return status;
  if (problem->d != d)
    return dlsi_fail(error, DLS_E_SIZE, "problem", -1, problem->d,
                     "has d = %d, the workspace is for %d", problem->d, d);
  if (problem->nc > nc)
    return dlsi_fail(error, DLS_E_SIZE, "problem", -1, problem->nc,
                     "has %d candidates, the workspace is for %d", problem->nc, nc);
  return dlsi_check_start(problem, r, warm_start, error);
}

dls_status dls_contact_check(const dls_contact *problem, dls_error *error) {
  return dlsi_at(__func__, dlsi_check_contact(problem, error), error);
}
