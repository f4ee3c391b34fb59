/*
 * redundant.c: takes out of K the joints that follow from other joints.
 *
 *   K = (A  G; G^T  0);  a joint j is redundant if its column of G is a combination of others.
 *
 * The multipliers of such joints are not determined: any l with G l = 0 may be added to them. They
 * make K singular, and nothing is wrong with the bodies. Here the multiplier of a redundant joint
 * is set to 0; its row of G^T x = b then holds by the others, or the certificate shows that it
 * contradicts them.
 *
 *   (RJ1)  scale rows, then columns of G to a largest entry of 1
 *   (RJ2)  subtract from column j its components along the pivots of earlier columns, in order
 *   (RJ3)  redundant if at most 1e-12 of the largest entry on the way is left; else the largest
 *          remaining entry becomes the pivot of j
 *
 * That is elimination with partial pivoting, column by column (Gilbert and Peierls, SIAM J. Sci.
 * Stat. Comput. 9, 1988, 862-874), with a heap for the order of the pivots. G has all rows of the
 * columns of the multipliers. If K is not symmetric, their rows stand below, transposed: a joint is
 * redundant if both depend on other joints in the same way.
 *
 * Cost: that of the fill, two passes over K. Fails: no memory.
 */
#include "linear/redundant.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "contact/body.h"

static const double rounding = 1e-12; /* (RJ3) */

/* ---- elimination ----------------------------------------------------------------------------- */

/* Columns of L and the arrays for one column. */
typedef struct elimination {
  int rows, cols;
  int *owner;      /* rows: the column whose pivot it is, -1 */
  int *pivot;      /* cols: the row, -1 of a redundant one */
  int *mark, *met; /* rows: the last column that has met it; the rows that this one has met */
  int *heap;       /* cols: pivots still to be subtracted, least first */
  double *v;       /* rows */
  int met_count, heap_count;
  size_t *first; /* cols + 1: L by columns */
  size_t room;
  int *row;
  double *x;
} elimination;

static void elimination_free(elimination *E) {
  free(E->owner);
  free(E->v);
  free(E->first);
  free(E->row);
  free(E->x);
}

static dls_status elimination_alloc(elimination *E, int rows, int cols, dls_error *error) {
  *E = (elimination){.rows = rows, .cols = cols};
  const size_t r = (size_t)rows, c = (size_t)cols;
  E->owner = dlsi_alloc(3 * r + 2 * c, sizeof *E->owner);
  E->v = dlsi_alloc(r, sizeof *E->v);
  E->first = dlsi_alloc(c + 1, sizeof *E->first);
  if (!E->owner || !E->v || !E->first) return dlsi_no_memory(error);
  E->mark = E->owner + r;
  E->met = E->mark + r;
  E->pivot = E->met + r;
  E->heap = E->pivot + c;
  for (int i = 0; i < rows; i++)
    E->owner[i] = E->mark[i] = -1;
  E->first[0] = 0;
  return DLS_OK;
}

static void heap_push(elimination *E, int k) {
  int at = E->heap_count++;
  for (; at > 0 && E->heap[(at - 1) / 2] > k; at = (at - 1) / 2)
    E->heap[at] = E->heap[(at - 1) / 2];
  E->heap[at] = k;
}

static int heap_pop(elimination *E) {
  const int least = E->heap[0], last = E->heap[--E->heap_count];
  int at = 0;
  for (int child; (child = 2 * at + 1) < E->heap_count; at = child) {
    if (child + 1 < E->heap_count && E->heap[child + 1] < E->heap[child]) child++;
    if (E->heap[child] >= last) break;
    E->heap[at] = E->heap[child];
  }
  E->heap[at] = last;
  return least;
}

/* v_i += x of column j. */
static void elimination_add(elimination *E, int j, int i, double x) {
  if (E->mark[i] != j) {
    E->mark[i] = j;
    E->v[i] = 0;
    E->met[E->met_count++] = i;
    if (E->owner[i] >= 0) heap_push(E, E->owner[i]);
  }
  E->v[i] += x;
}

/* Makes room for `more` entries of L. */
static dls_status elimination_grow(elimination *E, size_t at, size_t more, dls_error *error) {
  if (at + more <= E->room) return DLS_OK;
  const size_t room = 2 * (at + more);
  int *row = dlsi_alloc(room, sizeof *row);
  double *x = dlsi_alloc(room, sizeof *x);
  if (!row || !x) {
    free(row);
    free(x);
    return dlsi_no_memory(error);
  }
  if (at > 0) {
    memcpy(row, E->row, at * sizeof *row);
    memcpy(x, E->x, at * sizeof *x);
  }
  free(E->row);
  free(E->x);
  E->row = row;
  E->x = x;
  E->room = room;
  return DLS_OK;
}

/* (RJ2), (RJ3) G: scaled. */
static dls_status elimination_column(elimination *E, const dlsi_columns *G, int j,
                                     dls_error *error) {
  double most = 0, left = 0;
  int pivot = -1;
  E->met_count = 0;
  for (int e = G->p[j]; e < G->p[j + 1]; e++)
    elimination_add(E, j, G->i[e], G->x[e]);
  for (int k = 0; k < E->met_count; k++)
    most = fmax(most, fabs(E->v[E->met[k]]));
  while (E->heap_count > 0) {
    const int k = heap_pop(E);
    const double part = E->v[E->pivot[k]];
    for (size_t e = E->first[k]; e < E->first[k + 1]; e++) {
      elimination_add(E, j, E->row[e], -part * E->x[e]);
      most = fmax(most, fabs(E->v[E->row[e]]));
    }
  }
  for (int k = 0; k < E->met_count; k++) {
    const int i = E->met[k];
    if (E->owner[i] >= 0 || !(fabs(E->v[i]) > left)) continue;
    left = fabs(E->v[i]);
    pivot = i;
  }
  size_t at = E->first[j];
  if (!(left > rounding * most)) pivot = -1;
  const dls_status status =
      pivot < 0 ? DLS_OK : elimination_grow(E, at, (size_t)E->met_count, error);
  for (int k = 0; !status && pivot >= 0 && k < E->met_count; k++) {
    const int i = E->met[k];
    if (E->owner[i] >= 0 || i == pivot || !(fabs(E->v[i]) > DBL_EPSILON * most)) continue;
    E->row[at] = i;
    E->x[at++] = E->v[i] / E->v[pivot];
  }
  if (pivot >= 0) E->owner[pivot] = j;
  E->pivot[j] = pivot;
  E->first[j + 1] = at;
  return status;
}

/* (RJ1) R: rows. */
static void scale_joints(dlsi_columns *G, double *R) {
  memset(R, 0, (size_t)G->rows * sizeof *R);
  for (int e = 0; e < G->p[G->cols]; e++)
    R[G->i[e]] = fmax(R[G->i[e]], fabs(G->x[e]));
  for (int j = 0; j < G->cols; j++) {
    double most = 0;
    for (int e = G->p[j]; e < G->p[j + 1]; e++) {
      if (R[G->i[e]] > 0) G->x[e] /= R[G->i[e]];
      most = fmax(most, fabs(G->x[e]));
    }
    for (int e = G->p[j]; most > 0 && e < G->p[j + 1]; e++)
      G->x[e] /= most;
  }
}

/* ---- joints ---------------------------------------------------------------------------------- */

/* Gathers G: column k is that of unknown list[k]; place: n, k of a multiplier, -1 elsewhere. */
static dls_status joints_gather(const dls_model *model, const int *place, int count,
                                dlsi_columns *G, dls_error *error) {
  const int n = model->n, symmetric = model->factorization != DLS_LU;
  dlsi_triplets t = {.count = 0};
  dls_status status = DLS_OK;
  for (int turn = 0; !status && turn < 2; turn++) { /* count, fill */
    size_t entries = 0;
    for (int j = 0; j < n; j++) {
      double v;
      for (int at = 0, i; dlsi_body_entry(model, j, &at, &i, &v);) {
        if (v == 0) continue;
        if (place[j] >= 0 && entries++ < INT_MAX && turn) dlsi_triplets_add(&t, i, place[j], v);
        if (place[i] >= 0 && (!symmetric || i != j) && entries++ < INT_MAX && turn)
          dlsi_triplets_add(&t, symmetric ? j : n + j, place[i], v);
      }
    }
    if (!turn) status = dlsi_triplets_alloc(symmetric ? n : 2 * n, count, entries, &t, error);
  }
  if (!status) status = dlsi_columns_compress(&t, 1, DLSI_ALL, G, error);
  dlsi_triplets_free(&t);
  return status;
}

/* Lists in apart->redundant which of the multipliers list[0 .. count-1] are redundant. */
static dls_status joints_find(dlsi_apart *apart, const dls_model *model, const int *place,
                              const int *list, int count, dls_error *error) {
  dlsi_columns G = {0};
  elimination E = {.owner = NULL};
  dls_status status = joints_gather(model, place, count, &G, error);
  if (!status) status = elimination_alloc(&E, G.rows, count, error);
  if (!status) scale_joints(&G, E.v);
  for (int k = 0; !status && k < count; k++) {
    status = elimination_column(&E, &G, k, error);
    if (!status && E.pivot[k] < 0) apart->redundant[apart->count++] = list[k];
  }
  elimination_free(&E);
  dlsi_columns_free(&G);
  return status;
}

/* ---- the new K ------------------------------------------------------------------------------- */

static dls_status apart_dense(dlsi_apart *apart, dls_error *error) {
  dls_dense *K = &apart->model.K;
  const size_t n = (size_t)K->rows;
  if (apart->count == 0) return DLS_OK;
  double *x = apart->K.x = dlsi_alloc(n, n * sizeof *x);
  if (!x) return dlsi_no_memory(error);
  for (size_t j = 0; j < n; j++)
    memcpy(x + j * n, K->a + j * (size_t)K->ld, n * sizeof *x);
  for (int c = 0; c < apart->count; c++) {
    const size_t u = (size_t)apart->redundant[c];
    for (size_t k = 0; k < n; k++)
      x[k + u * n] = x[u + k * n] = k == u;
  }
  *K = (dls_dense){K->rows, K->cols, K->rows, x};
  return DLS_OK;
}

/* place: n, -1 unless a multiplier with a zero diagonal; becomes -2 for a redundant one. */
static dls_status apart_sparse(dlsi_apart *apart, int *place, int count, dls_error *error) {
  dls_sparse *Ks = &apart->model.Ks;
  dlsi_triplets t;
  for (int c = 0; c < apart->count; c++)
    place[apart->redundant[c]] = -2;
  dls_status status =
      dlsi_triplets_alloc(Ks->rows, Ks->cols, (size_t)Ks->p[Ks->cols] + (size_t)count, &t, error);
  for (int j = 0; !status && j < Ks->cols; j++) {
    if (place[j] != -1) dlsi_triplets_add(&t, j, j, place[j] == -2);
    for (int e = Ks->p[j]; e < Ks->p[j + 1]; e++) {
      const int gone = place[j] == -2 || place[Ks->i[e]] == -2;
      dlsi_triplets_add(&t, Ks->i[e], j, gone ? 0 : Ks->x[e]);
    }
  }
  if (!status) status = dlsi_columns_compress(&t, 1, DLSI_ALL, &apart->K, error);
  dlsi_triplets_free(&t);
  if (!status) *Ks = dlsi_columns_view(&apart->K);
  return status;
}

/* ---- create, free ---------------------------------------------------------------------------- */

/* Numbers the multipliers without a diagonal entry. place: in, dlsi_body_joints; out, number or -1,
 * n; list: these multipliers, n. Returns how many there are. */
static int apart_number(const dls_model *model, int *place, int *list) {
  int count = 0;
  for (int j = 0; j < model->n; j++) {
    double diagonal = 0, v;
    for (int at = 0, i; place[j] && dlsi_body_entry(model, j, &at, &i, &v);)
      if (i == j) diagonal += v;
    if (place[j] && diagonal == 0) list[count] = j;
    place[j] = place[j] && diagonal == 0 ? count++ : -1;
  }
  return count;
}

dls_status dlsi_apart_create(dlsi_apart *apart, const dls_model *model, const dls_sparse *Ht,
                             dls_error *error) {
  *apart = (dlsi_apart){.model = *model};
  if (model->operator_kind != DLS_STIFFNESS_DENSE && model->operator_kind != DLS_STIFFNESS_SPARSE)
    return DLS_OK;
  const size_t n = (size_t)model->n;
  int *place = dlsi_alloc(2 * n, sizeof *place), *list = place ? place + n : NULL;
  if (!place) return dlsi_no_memory(error);
  dls_status status = DLS_OK;
  apart->joints = dlsi_body_joints(model, Ht, place);
  const int count = apart->joints ? apart_number(model, place, list) : 0;
  if (count > 0) {
    apart->redundant = dlsi_alloc((size_t)count, sizeof *apart->redundant);
    status = apart->redundant ? joints_find(apart, model, place, list, count, error)
                              : dlsi_no_memory(error);
    if (!status)
      status = model->operator_kind == DLS_STIFFNESS_DENSE
                   ? apart_dense(apart, error)
                   : apart_sparse(apart, place, count, error);
  }
  free(place);
  return status;
}

void dlsi_apart_free(dlsi_apart *apart) {
  dlsi_columns_free(&apart->K);
  free(apart->redundant);
}
