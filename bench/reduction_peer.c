/*
 * reduction_peer.c: W by CHOLMOD, UMFPACK and MUMPS, which only this file of bench/ uses.
 */
#include "reduction_peer.h"

#include <dmumps_c.h>
#include <metis.h>
#include <stdlib.h>
#include <string.h>
#include <umfpack.h>

#include "cholmod_view.h"
#include "common.h"

void dpotrf_(const char *, const int *, double *, const int *, int *, size_t);
void dpotri_(const char *, const int *, double *, const int *, int *, size_t);

int picked(const dls_model *model, int j) {
  const int d = model->d, node = j / d, k = j % d;
  return k == 0 ? model->HN.i[node] : model->HT.i[(d - 1) * node + k - 1];
}

/* Adds H^T X to W, `batch` columns of X at a time; H picks entries, so that adding is copying. */
int cholmod_columns(const dls_model *model, double *W) {
  enum { batch = 64 };
  const size_t n = (size_t)model->n, m = (size_t)(model->d * model->nodes);
  cholmod_common c;
  cholmod_start(&c);
  c.supernodal = CHOLMOD_SUPERNODAL;
  cholmod_sparse K = cholmod_view(&model->Ks);
  cholmod_factor *L = cholmod_analyze(&K, &c);
  cholmod_dense *B = cholmod_zeros(n, batch, CHOLMOD_REAL, &c), *X = NULL, *Y = NULL, *E = NULL;
  int ok = L && B && cholmod_factorize(&K, L, &c) && c.status == CHOLMOD_OK;
  for (size_t first = 0; ok && first < m; first += batch) {
    double *b = B->x;
    B->ncol = m - first < batch ? m - first : batch;
    for (size_t j = 0; j < B->ncol; j++)
      b[(size_t)picked(model, (int)(first + j)) + j * n] = 1;
    ok = cholmod_solve2(CHOLMOD_A, L, B, NULL, &X, NULL, &Y, &E, &c);
    for (size_t j = 0; ok && j < B->ncol; j++) {
      for (size_t i = 0; i < m; i++)
        W[i + (first + j) * m] = ((double *)X->x)[(size_t)picked(model, (int)i) + j * n];
      b[(size_t)picked(model, (int)(first + j)) + j * n] = 0;
    }
  }
  cholmod_free_dense(&B, &c);
  cholmod_free_dense(&X, &c);
  cholmod_free_dense(&Y, &c);
  cholmod_free_dense(&E, &c);
  cholmod_free_factor(&L, &c);
  cholmod_finish(&c);
  return ok ? 0 : -1;
}

int umfpack_columns(const dls_model *model, double *W) {
  const dls_sparse *K = &model->Ks;
  const int n = model->n, m = model->d * model->nodes;
  void *symbolic = NULL, *numeric = NULL;
  double *b = calloc((size_t)n, sizeof *b), *x = malloc((size_t)n * sizeof *x);
  int ok =
      b && x && umfpack_di_symbolic(n, n, K->p, K->i, K->x, &symbolic, NULL, NULL) == UMFPACK_OK;
  ok = ok && umfpack_di_numeric(K->p, K->i, K->x, symbolic, &numeric, NULL, NULL) == UMFPACK_OK;
  umfpack_di_free_symbolic(&symbolic);
  for (int j = 0; ok && j < m; j++) {
    b[picked(model, j)] = 1;
    ok = umfpack_di_solve(UMFPACK_A, K->p, K->i, K->x, x, b, numeric, NULL, NULL) == UMFPACK_OK;
    b[picked(model, j)] = 0;
    for (int i = 0; i < m; i++)
      W[(size_t)i + (size_t)j * (size_t)m] = x[picked(model, i)];
  }
  umfpack_di_free_numeric(&numeric);
  free(x);
  free(b);
  return ok ? 0 : -1;
}

/* Orders K by nested dissection, the m picked unknowns last. turn: place of each unknown from 1,
 * n. */
static int schur_order(const dls_model *model, int m, int *turn) {
  const dls_sparse *K = &model->Ks;
  const int n = model->n;
  idx_t N = n, *x = calloc((size_t)n + 2, sizeof *x);
  idx_t *adjacent = malloc(2 * (size_t)K->p[n] * sizeof *adjacent);
  idx_t *by_place = malloc((size_t)n * sizeof *by_place),
        *place = malloc((size_t)n * sizeof *place);
  int ok = x && adjacent && by_place && place;
  for (int fill = 0; ok && fill < 2; fill++) {
    for (int j = 0; j < n; j++)
      for (int k = K->p[j]; k < K->p[j + 1]; k++) {
        const int i = K->i[k];
        if (i == j) continue;
        if (fill) {
          adjacent[x[j + 1]++] = i;
          adjacent[x[i + 1]++] = j;
        } else {
          x[j + 2]++;
          x[i + 2]++;
        }
      }
    for (int j = 0; !fill && j < n; j++)
      x[j + 2] += x[j + 1];
  }
  ok = ok && METIS_NodeND(&N, x, adjacent, NULL, NULL, by_place, place) == METIS_OK;
  if (ok) {
    memset(turn, 0, (size_t)n * sizeof *turn);
    for (int j = 0; j < m; j++)
      turn[picked(model, j)] = n - m + 1 + j;
    for (int k = 0, at = 0; k < n; k++)
      if (turn[by_place[k]] == 0) turn[by_place[k]] = ++at;
  }
  free(place);
  free(by_place);
  free(adjacent);
  free(x);
  return ok;
}

int mumps_schur(const dls_model *model, double *before, double *factor, double *inverse) {
  const dls_sparse *K = &model->Ks;
  const int n = model->n, m = model->d * model->nodes;
  const size_t entries = (size_t)K->p[n], M = (size_t)m;
  int *row = malloc(entries * sizeof *row), *col = malloc(entries * sizeof *col);
  int *turn = malloc((size_t)n * sizeof *turn), *list = malloc(M * sizeof *list);
  double *S = malloc(M * M * sizeof *S);
  double start = bench_seconds();
  if (!row || !col || !turn || !list || !S || !schur_order(model, m, turn)) return -1;
  for (int j = 0; j < n; j++)
    for (int k = K->p[j]; k < K->p[j + 1]; k++) {
      row[k] = K->i[k] + 1;
      col[k] = j + 1;
    }
  for (int j = 0; j < m; j++)
    list[j] = picked(model, j) + 1;
  DMUMPS_STRUC_C s;
  memset(&s, 0, sizeof s);
  s.par = s.sym = 1;
  s.comm_fortran = -987654;
  s.job = -1;
  dmumps_c(&s);
  s.icntl[0] = s.icntl[1] = s.icntl[2] = -1;
  s.icntl[3] = 0;
  s.icntl[6] = 1;
  s.icntl[18] = 2;
  s.n = n;
  s.nnz = (MUMPS_INT8)entries;
  s.irn = row;
  s.jcn = col;
  s.a = (double *)(size_t)K->x;
  s.perm_in = turn;
  s.size_schur = s.schur_lld = m;
  s.listvar_schur = list;
  s.schur = S;
  s.nprow = s.npcol = 1;
  s.mblock = s.nblock = 100;
  s.job = 1;
  dmumps_c(&s);
  *before = bench_seconds() - start;
  start = bench_seconds();
  s.job = 2;
  if (s.infog[0] >= 0) dmumps_c(&s);
  *factor = bench_seconds() - start;
  start = bench_seconds();
  int info = 0;
  dpotrf_("L", &m, S, &m, &info, 1);
  if (info == 0) dpotri_("L", &m, S, &m, &info, 1);
  *inverse = bench_seconds() - start;
  const int ok = s.infog[0] >= 0 && info == 0;
  s.job = -2;
  dmumps_c(&s);
  free(S);
  free(list);
  free(turn);
  free(col);
  free(row);
  return ok ? 0 : -1;
}
