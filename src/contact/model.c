/* model.c: the checks of a model: sizes, pointers, indices, finite values, signs of P. */
#include <limits.h>

#include "contact.h"

/* Checks the lower triangle of a symmetric K; the entries above may not even be set. */
static dls_status model_check_lower(const dls_dense *K, int n, dls_error *error) {
  if (!K->a) return dlsi_is_null(error, "K");
  if (K->rows != n || K->cols != n)
    return dlsi_fail(error, DLS_E_SIZE, "K", -1, K->rows, "is %d x %d, must be %d x %d", K->rows,
                     K->cols, n, n);
  if (K->ld < n)
    return dlsi_fail(error, DLS_E_SIZE, "K", -1, K->ld, "leading dimension %d is less than %d",
                     K->ld, n);
  for (int j = 0; j < n; j++) {
    const size_t diagonal = (size_t)j * ((size_t)K->ld + 1);
    const long long bad = dlsi_first_not_finite(K->a + diagonal, (size_t)(n - j));
    if (bad >= 0)
      return dlsi_fail(error, DLS_E_NOT_FINITE, "K", bad + (long long)diagonal,
                       K->a[diagonal + (size_t)bad], "is not finite (row %lld, column %d)", bad + j,
                       j);
  }
  return DLS_OK;
}

/* Refuses a symmetric Ks given by its upper triangle: only its diagonal would be read. */
static dls_status model_check_triangle(const dls_sparse *Ks, dls_error *error) {
  int upper = -1;
  for (int j = 0; j < Ks->cols; j++)
    for (int k = Ks->p[j]; k < Ks->p[j + 1]; k++) {
      if (Ks->i[k] > j) return DLS_OK;
      if (Ks->i[k] < j) upper = k;
    }
  if (upper < 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_ARGUMENT, "Ks", upper, Ks->x[upper],
                   "is an upper triangle; the lower one or both are wanted");
}

/* Refuses a lower triangle under DLS_LU, which reads all of K: half of a symmetric matrix, as in
 * files. below, above: an entry other than 0, or -1. */
static dls_status model_check_whole(const char *argument, long long below, long long above,
                                    dls_error *error) {
  if (below < 0 || above >= 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_ARGUMENT, argument, below, 0,
                   "is a lower triangle; DLS_LU wants all entries");
}

static dls_status model_check_whole_dense(const dls_dense *K, dls_error *error) {
  long long below = -1, above = -1;
  for (int j = 0; j < K->cols && (below < 0 || above < 0); j++)
    for (int i = 0; i < K->rows; i++) {
      const size_t k = (size_t)i + (size_t)j * (size_t)K->ld;
      if (K->a[k] == 0 || i == j) continue;
      *(i > j ? &below : &above) = (long long)k;
    }
  return model_check_whole("K", below, above, error);
}

static dls_status model_check_whole_sparse(const dls_sparse *Ks, dls_error *error) {
  long long below = -1, above = -1;
  for (int j = 0; j < Ks->cols && (below < 0 || above < 0); j++)
    for (int k = Ks->p[j]; k < Ks->p[j + 1]; k++)
      if (Ks->x[k] != 0 && Ks->i[k] != j) *(Ks->i[k] > j ? &below : &above) = k;
  return model_check_whole("Ks", below, above, error);
}

static dls_status model_check_operator(const dls_model *model, dls_error *error) {
  const int n = model->n;
  const int stiffness =
      model->operator_kind == DLS_STIFFNESS_DENSE || model->operator_kind == DLS_STIFFNESS_SPARSE;
  const int symmetric = model->factorization == DLS_CHOLESKY || model->factorization == DLS_LDLT;
  if (stiffness && !symmetric && model->factorization != DLS_LU)
    return dlsi_fail(error, DLS_E_ARGUMENT, "factorization", -1, model->factorization,
                     "is not DLS_CHOLESKY, DLS_LU or DLS_LDLT");
  switch (model->operator_kind) {
  case DLS_STIFFNESS_DENSE:
    if (symmetric) return model_check_lower(&model->K, n, error);
    {
      const dls_status status = dlsi_check_dense("K", &model->K, n, n, error);
      if (status || model->triangular) return status;
      return model_check_whole_dense(&model->K, error);
    }
  case DLS_STIFFNESS_SPARSE: {
    const dls_status status = dlsi_check_sparse("Ks", &model->Ks, n, n, error);
    if (status) return status;
    if (symmetric) return model_check_triangle(&model->Ks, error);
    return model->triangular ? DLS_OK : model_check_whole_sparse(&model->Ks, error);
  }
  case DLS_FLEXIBILITY:
    return dlsi_check_dense("K", &model->K, n, n, error);
  case DLS_HOST_SOLVER:
    if (!model->solve) return dlsi_is_null(error, "solve");
    return DLS_OK;
  }
  return dlsi_fail(error, DLS_E_ARGUMENT, "operator_kind", -1, model->operator_kind,
                   "is no kind of operator");
}

/* Checks that each column of P adds up to more than 0, as the integrals of a density over its cell
 * do. Entries >= 0 also keep P r >= 0 and in Coulomb's cone, [J] 4.4, proposition 2; the method
 * itself needs only densities that obey the laws, and quadratic edges have entries < 0
 * (weighting.c). */
static dls_status model_check_weighting(const dls_model *model, dls_error *error) {
  const dls_sparse *P = &model->P;
  if (P->cols < 0 || P->cols > INT_MAX / model->d)
    return dlsi_fail(error, DLS_E_SIZE, "P", -1, P->cols, "has %d columns", P->cols);
  const dls_status status = dlsi_check_sparse("P", P, model->nodes, P->cols, error);
  if (status) return status;
  for (int j = 0; j < P->cols; j++) {
    double sum = 0;
    for (int k = P->p[j]; k < P->p[j + 1]; k++)
      sum += P->x[k];
    if (!(sum > 0))
      return dlsi_fail(error, DLS_E_ARGUMENT, "P", j, sum, "column %d adds up to %g", j, sum);
  }
  return DLS_OK;
}

static dls_status model_check_sizes(const dls_model *model, dls_error *error) {
  if (!model) return dlsi_is_null(error, "model");
  const int d = model->d, n = model->n, nodes = model->nodes;
  if (d != 2 && d != 3)
    return dlsi_fail(error, DLS_E_ARGUMENT, "d", -1, d, "is %d, must be 2 or 3", d);
  if (n < 1) return dlsi_fail(error, DLS_E_SIZE, "n", -1, n, "is %d", n);
  if (nodes < 0 || nodes > INT_MAX / d)
    return dlsi_fail(error, DLS_E_SIZE, "nodes", -1, nodes, "is %d", nodes);
  return DLS_OK;
}

/* Checks H, P and mu. */
static dls_status model_check_contacts(const dls_model *model, dls_error *error) {
  const int d = model->d, n = model->n, nodes = model->nodes;
  dls_status status = DLS_OK;
  if (nodes > 0) status = dlsi_check_sparse("HN", &model->HN, n, nodes, error);
  if (!status && nodes > 0) status = dlsi_check_sparse("HT", &model->HT, n, (d - 1) * nodes, error);
  if (!status && model->P.p) status = model_check_weighting(model, error);
  if (status || !model->mu) return status;
  return dlsi_check_friction(model->mu, (size_t)dlsi_model_candidates(model), error);
}

dls_status dlsi_check_model(const dls_model *model, dls_error *error) {
  dls_status status = model_check_sizes(model, error);
  if (!status) status = model_check_operator(model, error);
  return status ? status : model_check_contacts(model, error);
}

dls_status dlsi_check_model_contacts(const dls_model *model, dls_error *error) {
  const dls_status status = model_check_sizes(model, error);
  return status ? status : model_check_contacts(model, error);
}

int dlsi_model_candidates(const dls_model *model) {
  return model->P.p ? model->P.cols : model->nodes;
}

dls_status dls_model_check(const dls_model *model, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, dlsi_check_model(model, error), error);
}
