/*
 * operators.c: products with M, C, K, H = L P, and A = M + h theta C + h^2 theta^2 K.
 *
 * Cost: O(nnz) each. Nothing fails but the memory of A.
 */
#include <limits.h>
#include <math.h>
#include <string.h>

#include "motion/motion_internal.h"

void dlsi_motion_multiply(const dls_motion *motion, const dls_sparse *A, const double *x, double *y,
                          double *a) {
  const int symmetric = motion->model.factorization != DLS_LU;
  memset(y, 0, motion->n * sizeof *y);
  if (a) memset(a, 0, motion->n * sizeof *a);
  if (!dlsi_motion_has(A)) return;
  for (int j = 0; j < A->cols; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++) {
      const int i = A->i[k];
      if (symmetric && i < j) continue;
      const double down = A->x[k] * x[j], up = A->x[k] * x[i];
      const int both = symmetric && i > j;
      y[i] += down;
      if (both) y[j] += up;
      if (!a) continue;
      a[i] += fabs(down);
      if (both) a[j] += fabs(up);
    }
}

/* Returns column k of L: of H_N for the normal of a node, of H_T for its tangents. */
static const dls_sparse *operators_column(const dls_motion_model *model, int k, int *column) {
  const int node = k / model->d, i = k % model->d;
  *column = i == 0 ? node : (model->d - 1) * node + i - 1;
  return i == 0 ? &model->HN : &model->HT;
}

void dlsi_motion_local(const dls_motion *motion, const double *x, double *local) {
  const dls_motion_model *model = &motion->model;
  for (int k = 0; k < model->d * model->nodes; k++) {
    int j;
    const dls_sparse *L = operators_column(model, k, &j);
    local[k] = 0;
    for (int e = L->p[j]; e < L->p[j + 1]; e++)
      local[k] += L->x[e] * x[L->i[e]];
  }
}

void dlsi_motion_gather(const dls_motion *motion, const double *local, double *c) {
  const dls_sparse *P = &motion->model.P;
  const size_t d = (size_t)motion->model.d;
  if (!P->p) {
    memcpy(c, local, motion->m * sizeof *c);
    return;
  }
  for (size_t a = 0; a < motion->candidates; a++)
    for (size_t i = 0; i < d; i++) {
      double sum = 0;
      for (int k = P->p[a]; k < P->p[a + 1]; k++)
        sum += P->x[k] * local[d * (size_t)P->i[k] + i];
      c[d * a + i] = sum;
    }
}

void dlsi_motion_push(const dls_motion *motion, const double *p, double *y, double *a) {
  const dls_motion_model *model = &motion->model;
  const dls_sparse *P = &model->P;
  const int d = model->d;
  for (int c = 0; c < (int)motion->candidates; c++)
    for (int k = P->p ? P->p[c] : c; k < (P->p ? P->p[c + 1] : c + 1); k++)
      for (int i = 0; i < d; i++) {
        const double share = (P->p ? P->x[k] : 1) * p[d * c + i];
        int j;
        const dls_sparse *L = operators_column(model, d * (P->p ? P->i[k] : k) + i, &j);
        for (int e = L->p[j]; share != 0 && e < L->p[j + 1]; e++) {
          y[L->i[e]] += L->x[e] * share;
          if (a) a[L->i[e]] += fabs(L->x[e] * share);
        }
      }
}

/* ---- A --------------------------------------------------------------------------------------- */

/* Copies column j of B to A, whose column is full up to `to`; returns the new end. */
static int operators_append(dlsi_columns *A, const dls_sparse *B, int j, int to) {
  if (!dlsi_motion_has(B)) return to;
  const int count = B->p[j + 1] - B->p[j];
  if (count > 0) memcpy(A->i + to, B->i + B->p[j], (size_t)count * sizeof *A->i);
  return to + count;
}

dls_status dlsi_motion_lay(dls_motion *motion, dls_error *error) {
  const dls_motion_model *model = &motion->model;
  const dls_sparse *const part[3] = {&model->M, &model->C, &model->K};
  long long entries = 0;
  for (int k = 0; k < 3; k++)
    if (dlsi_motion_has(part[k])) entries += part[k]->p[model->n];
  if (entries > INT_MAX)
    return dlsi_fail(error, DLS_E_SIZE, "A", -1, (double)entries, "%lld entries are too many",
                     entries);
  dlsi_columns *A = &motion->A;
  const dls_status status = dlsi_columns_alloc(model->n, model->n, (int)entries, A, error);
  if (status) return status;
  A->p[0] = 0;
  for (int j = 0; j < model->n; j++) {
    int to = A->p[j];
    for (int k = 0; k < 3; k++)
      to = operators_append(A, part[k], j, to);
    A->p[j + 1] = to;
  }
  return DLS_OK;
}

void dlsi_motion_form(dls_motion *motion, double h) {
  const dls_motion_model *model = &motion->model;
  const int path = motion->settings.law == DLS_MOTION_PATH;
  const double ht = h * motion->settings.theta;
  const dls_sparse *const part[3] = {&model->M, &model->C, &model->K};
  const double factor[3] = {1, ht, path ? 1 : ht * ht};
  int to = 0;
  for (int j = 0; j < model->n; j++)
    for (int k = 0; k < 3; k++)
      for (int e = dlsi_motion_has(part[k]) ? part[k]->p[j] : 0;
           e < (dlsi_motion_has(part[k]) ? part[k]->p[j + 1] : 0); e++)
        motion->A.x[to++] = factor[k] * part[k]->x[e];
}
