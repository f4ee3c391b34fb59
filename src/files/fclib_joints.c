/*
 * fclib_joints.c: joints of FCLIB's global problem as multipliers among the unknowns.
 *
 *   M v = H r + G l + f,  G^T v + b = 0        (M  -G; -G^T  0) (v; l) = (f; b) + (H; 0) r
 *
 * Writing takes the multipliers from K (base/joints.c). K has this form if it is symmetric between
 * positions and multipliers and has no entries between multipliers, and H has none at multipliers.
 *
 * Cost: the entries. Fails: no memory.
 */
#include "files/fclib_joints.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "contact/body.h"

dls_status dlsi_fclib_join(dlsi_triplets *M, const dlsi_triplets *G, dls_error *error) {
  const int n = M->rows, p = G->cols;
  if (p > INT_MAX - n)
    return dlsi_fail(error, DLS_E_SIZE, "G/n", -1, p, "%d and %d unknowns are too many", n, p);
  dlsi_triplets K;
  const dls_status status =
      dlsi_triplets_alloc(n + p, n + p, (size_t)M->count + 2 * (size_t)G->count, &K, error);
  for (int k = 0; !status && k < M->count; k++)
    dlsi_triplets_add(&K, M->row[k], M->col[k], M->x[k]);
  for (int k = 0; !status && k < G->count; k++) {
    dlsi_triplets_add(&K, G->row[k], n + G->col[k], -G->x[k]);
    dlsi_triplets_add(&K, n + G->col[k], G->row[k], -G->x[k]);
  }
  if (status) {
    dlsi_triplets_free(&K);
    return status;
  }
  dlsi_triplets_free(M);
  *M = K;
  return DLS_OK;
}

/* A block of K, and where its entries go. */
typedef struct block {
  int of_rows, of_columns; /* 1: multipliers, 0: positions */
  double sign;
  int transposed;
} block;

/* Gathers a block of A; columns of A that are not unknowns (of H) count as positions. */
static dls_status split_gather(const dlsi_fclib_split *of, const int *joint, const int *place,
                               const dls_sparse *A, int square, block b, dlsi_columns *out,
                               dls_error *error) {
  dlsi_triplets t;
  const int rows = b.of_rows ? of->joints : of->positions;
  const int cols = !square ? A->cols : b.of_columns ? of->joints : of->positions;
  dls_status status = dlsi_triplets_alloc(b.transposed ? cols : rows, b.transposed ? rows : cols,
                                          (size_t)A->p[A->cols], &t, error);
  for (int j = 0; !status && j < A->cols; j++) {
    if (square && joint[j] != b.of_columns) continue;
    const int col = square ? place[j] : j;
    for (int k = A->p[j]; k < A->p[j + 1]; k++) {
      const int row = place[A->i[k]];
      if (joint[A->i[k]] == b.of_rows)
        dlsi_triplets_add(&t, b.transposed ? col : row, b.transposed ? row : col, b.sign * A->x[k]);
    }
  }
  if (!status) status = dlsi_columns_compress(&t, 1, DLSI_ALL, out, error);
  dlsi_triplets_free(&t);
  return status;
}

/* Returns 1 if the columns add up to the same matrix. sum: 0 on entry and exit, rows. */
static int split_equal(const dlsi_columns *A, const dlsi_columns *B, double *sum) {
  int equal = 1;
  for (int j = 0; j < A->cols; j++) {
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      sum[A->i[k]] += A->x[k];
    for (int k = B->p[j]; k < B->p[j + 1]; k++)
      sum[B->i[k]] -= B->x[k];
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      equal &= sum[A->i[k]] == 0;
    for (int k = B->p[j]; k < B->p[j + 1]; k++)
      equal &= sum[B->i[k]] == 0;
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      sum[A->i[k]] = 0;
    for (int k = B->p[j]; k < B->p[j + 1]; k++)
      sum[B->i[k]] = 0;
  }
  return equal;
}

/* Returns 1 if A has an entry other than 0 in a row of a multiplier or, if `square`, in a column of
 * one. */
static int split_touches(const dls_sparse *A, const int *joint, int square) {
  for (int j = 0; j < A->cols; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      if (A->x[k] != 0 && joint[A->i[k]] && (!square || joint[j])) return 1;
  return 0;
}

static dls_status split_fill(dlsi_fclib_split *out, const dls_sparse *K, const dls_sparse *H,
                             const int *joint, int *place, dls_error *error) {
  const int n = K->cols;
  for (int turn = 0, at = 0; turn < 2; turn++)
    for (int j = 0; j < n; j++)
      if (joint[j] == turn) {
        place[j] = at - (turn ? out->positions : 0);
        out->order[at++] = j;
      }
  dlsi_columns mirror = {0};
  double *sum = calloc((size_t)out->positions, sizeof *sum);
  const block of_M = {0, 0, 1, 0}, of_G = {0, 1, -1, 0}, of_mirror = {1, 0, -1, 1};
  dls_status status = sum ? DLS_OK : dlsi_no_memory(error);
  if (!status) status = split_gather(out, joint, place, K, 1, of_M, &out->M, error);
  if (!status) status = split_gather(out, joint, place, K, 1, of_G, &out->G, error);
  if (!status) status = split_gather(out, joint, place, K, 1, of_mirror, &mirror, error);
  if (!status) status = split_gather(out, joint, place, H, 0, of_M, &out->H, error);
  if (!status && !split_equal(&out->G, &mirror, sum)) out->joints = 0;
  dlsi_columns_free(&mirror);
  free(sum);
  return status;
}

dls_status dlsi_fclib_split_create(dlsi_fclib_split *out, const dls_sparse *K, const dls_sparse *H,
                                   dls_error *error) {
  const size_t n = (size_t)K->cols;
  const dls_model model = {
      .n = K->cols, .operator_kind = DLS_STIFFNESS_SPARSE, .factorization = DLS_LU, .Ks = *K};
  *out = (dlsi_fclib_split){.joints = 0};
  int *joint = dlsi_alloc(2 * n, sizeof *joint);
  out->order = dlsi_alloc(n, sizeof *out->order);
  dls_status status = joint && out->order ? DLS_OK : dlsi_no_memory(error);
  if (!status) {
    out->joints = dlsi_body_joints(&model, NULL, joint);
    out->positions = K->cols - out->joints;
    if (out->positions == 0 || split_touches(K, joint, 1) || split_touches(H, joint, 0))
      out->joints = 0;
    if (out->joints > 0) status = split_fill(out, K, H, joint, joint + n, error);
  }
  free(joint);
  return status;
}

void dlsi_fclib_split_free(dlsi_fclib_split *split) {
  free(split->order);
  dlsi_columns_free(&split->M);
  dlsi_columns_free(&split->G);
  dlsi_columns_free(&split->H);
}
