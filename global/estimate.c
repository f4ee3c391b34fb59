/*
 * estimate.c: estimates the cost of a problem on K from the analysis of A.
 *
 * An iteration reads the factor twice (forward, backward), the vectors of n and m some times, and
 * the history of the acceleration three times. It does two flops per number read, so that memory
 * limits its speed. A factorisation does thousands, and runs at the speed of dgemm.
 * LU on the pattern of A + A^T: twice the flops and entries of a Cholesky factor.
 */
#include "global_internal.h"

/* Vectors of n and of m that an iteration reads or writes, besides the history. */
enum { vectors = 12, passes = 3 };

/* Returns the bytes of the analysis and the factor. */
static double cholesky_bytes(const dlsi_cholesky *L) {
  const double n = L->n, supernodes = L->count;
  return sizeof(double) * ((double)L->panel[L->count] + (double)L->update + 3 * n + L->longest) +
         sizeof(int) * (7 * n + (double)L->start[L->count]) +
         sizeof(size_t) * ((double)L->entries + 3 * supernodes);
}

/* Returns the bytes of an operator by columns. */
static double columns_bytes(const dlsi_columns *A) {
  return (sizeof(double) + sizeof(int)) * (double)A->p[A->cols] + sizeof(int) * (double)A->cols;
}

static dls_status global_get_info(dls_global *work, dls_global_info *info, dls_error *error) {
  const dlsi_system *A = work->system;
  dlsi_cholesky *fresh = NULL;
  if (!info) return dlsi_is_null(error, "info");
  if (!A)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "global", -1, 0,
                     "has the host's solver in the place of a factor");
  const dls_status status = A->cholesky ? DLS_OK : dlsi_system_analyse(A, &fresh, error);
  if (status) return status;
  const dlsi_cholesky *L = fresh ? fresh : A->cholesky;
  const double n = work->n, m = work->m, twice = A->symmetric ? 1 : 2;
  const double entries = twice * (double)L->panel[L->count];
  *info = (dls_global_info){.flops = twice * L->flops, .factor_bytes = sizeof(double) * entries};
  info->step_bytes = 2 * info->factor_bytes +
                     sizeof(double) * (vectors * (n + m) + passes * work->history.window * m);
  info->bytes = (double)work->bytes + columns_bytes(&work->K) + 2 * columns_bytes(&work->H) +
                (work->apart.K.p ? columns_bytes(&work->apart.K) : 0) +
                sizeof(double) * (3 * m + 2 * n + (double)dlsi_body_scratch(&work->body)) +
                sizeof(int) * 3 * n + (sizeof(double) + 2 * sizeof(int)) * (double)A->entries +
                sizeof(double) * (double)A->of_H + cholesky_bytes(L) +
                (twice - 1) * sizeof(double) * (double)L->panel[L->count];
  dlsi_cholesky_destroy(fresh);
  return DLS_OK;
}

dls_status dls_global_get_info(dls_global *global, dls_global_info *info, dls_error *error) {
  DLSI_DOOR;
  dls_status status =
      global ? dlsi_enter(&global->busy, "global", error) : dlsi_is_null(error, "global");
  if (!status) status = dlsi_leave(&global->busy, global_get_info(global, info, error));
  return dlsi_at(__func__, status, error);
}

static dls_status global_estimate(const dls_model *model, dls_global_info *info, dls_error *error) {
  dls_global *work;
  if (!info) return dlsi_is_null(error, "info");
  dls_status status = dls_global_create(&work, model, error);
  if (!status) status = global_get_info(work, info, error);
  dls_global_destroy(work);
  return status;
}

dls_status dls_global_estimate(const dls_model *model, dls_global_info *info, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, global_estimate(model, info, error), error);
}
