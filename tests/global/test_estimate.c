/* test_estimate.c: the estimated cost of a problem on K against counts by elimination, entry by
 * entry, and against the bytes that a solve allocates. */
#include "global/global_internal.h"
#include "run.h"
#include "solids.h"

/* Flops of an elimination entry by entry: squares of the columns' entries, without the diagonal and
 * with it. */
typedef struct counts {
  double least, most;
} counts;

/* Gives all columns of supernode s the rows of each. */
static void pad(const dlsi_cholesky *L, int s, char *full) {
  const size_t n = (size_t)L->n, first = (size_t)L->first[s], end = (size_t)L->first[s + 1];
  for (size_t i = first; i < n; i++) {
    int any = i < end;
    for (size_t j = first; j < end; j++)
      any |= full[i + n * j];
    for (size_t j = first; any && j < end; j++)
      full[i + n * j] = 1;
  }
}

/* padded: with the zeros that supernodes bring in, (CH5) of src/linear/cholesky_analyse.c. column:
 * entries of each column of L, n. */
static counts counts_of(const dlsi_system *A, const dlsi_cholesky *L, int padded, double *column) {
  const int n = A->n;
  char *full = calloc((size_t)n, (size_t)n); /* column j of L: full[i + n j] */
  int *below = calloc((size_t)n, sizeof *below);
  counts all = {0};
  ck_assert(full && below);
  for (size_t k = 0; k < A->entries; k++) {
    const int i = L->place[A->row[k] - 1], j = L->place[A->col[k] - 1];
    full[(size_t)(i > j ? i : j) + (size_t)n * (size_t)(i > j ? j : i)] = 1;
  }
  for (int j = 0, s = 0; j < n; j++) {
    if (padded && j == L->first[s]) pad(L, s++, full);
    const char *rows = full + (size_t)n * (size_t)j;
    int count = 0;
    for (int i = j + 1; i < n; i++)
      if (rows[i]) below[count++] = i;
    for (int a = 0; a < count; a++)
      for (int b = a; b < count; b++)
        full[(size_t)below[b] + (size_t)n * (size_t)below[a]] = 1;
    column[j] = 1 + count;
    all.least += (double)count * count;
    all.most += (1. + count) * (1. + count);
  }
  free(full);
  free(below);
  return all;
}

/* K is whole where kind is 3, for DLS_LU. */
static void scene(solids *S, int kind) {
  if (kind == 0 || kind == 3)
    solids_pad(S, 60, 4);
  else if (kind == 1)
    solids_plate(S, 10, 3);
  else
    solids_stack(S, 2, 10, 4, .9);
  if (kind != 3) return;
  dlsi_triplets t;
  const dlsi_columns K = S->Kc;
  ck_assert(!dlsi_triplets_alloc(K.rows, K.cols, 2 * (size_t)K.p[K.cols], &t, NULL));
  for (int j = 0; j < K.cols; j++)
    for (int k = K.p[j]; k < K.p[j + 1]; k++) {
      dlsi_triplets_add(&t, K.i[k], j, K.x[k]);
      if (K.i[k] != j) dlsi_triplets_add(&t, j, K.i[k], K.x[k]);
    }
  dlsi_columns_free(&S->Kc);
  ck_assert(!dlsi_columns_compress(&t, 1, DLSI_ALL, &S->Kc, NULL));
  dlsi_triplets_free(&t);
  S->model.Ks = dlsi_columns_view(&S->Kc);
  S->model.factorization = DLS_LU;
}

/* A supernode of c columns with r rows below it takes the integral of (r + x)^2 from 0 to c, which
 * two sums over its columns enclose, and stores the upper half of its triangle. The zeros that it
 * stores are a third of it at most. */
TEST_EACH(beside_elimination, 0, 4) {
  solids S;
  dls_global *G;
  dls_global_info info, again;
  scene(&S, _i);
  dls_error e = {0};
  ck_assert_msg(!dls_global_estimate(&S.model, &info, &e), "%s", e.message);
  ck_assert(!dls_global_create(&G, &S.model, NULL));
  ck_assert(!dls_global_get_info(G, &again, NULL));
  ck_assert_mem_eq(&info, &again, sizeof info);
  dlsi_cholesky *L = G->system->cholesky;
  if (_i == 3) ck_assert(!dlsi_system_analyse(G->system, &L, NULL));
  double *is = calloc(2 * (size_t)L->n, sizeof *is), *padded = is + L->n, stored = 0;
  ck_assert_ptr_nonnull(is);
  (void)counts_of(G->system, L, 0, is);
  const counts panels = counts_of(G->system, L, 1, padded);
  const double twice = _i == 3 ? 2 : 1;
  ck_assert_msg(info.flops >= twice * panels.least && info.flops <= twice * panels.most,
                "%g to %g flops, foreseen %g", twice * panels.least, twice * panels.most,
                info.flops);
  for (int s = 0; s < L->count; s++) {
    double zeros = 0;
    for (int j = L->first[s]; j < L->first[s + 1]; j++)
      zeros += padded[j] - is[j];
    const double panel = padded[L->first[s]] * (L->first[s + 1] - L->first[s]);
    ck_assert_msg(zeros >= 0 && zeros <= panel / 3, "%g zeros in a panel of %g", zeros, panel);
    stored += panel;
  }
  ck_assert(info.factor_bytes == 8 * twice * stored);
  free(is);
  ck_assert(info.step_bytes >= 2 * info.factor_bytes && info.bytes >= info.factor_bytes);
  if (_i == 3) dlsi_cholesky_destroy(L);
  dls_global_destroy(G);
  solids_free(&S);
}

/* Create and the first solve ask for what stays, and for a moment for the arrays of the copy, of
 * the analysis, and of a factorisation. */
TEST_EACH(beside_malloc, 0, 3) {
  solids S;
  dls_global *G;
  dls_global_info info;
  scene(&S, _i);
  const size_t n = (size_t)S.model.n, nc = (size_t)S.contacts;
  double *mu = calloc(nc, sizeof *mu), *x = calloc(n, sizeof *x);
  double *r = calloc(nc * (size_t)S.d, sizeof *r);
  malloc_fails_at(0);
  ck_assert(!dls_global_create(&G, &S.model, NULL));
  const dls_limits few = {.tol = 1e-8, .max_iterations = 15};
  ck_assert_int_ge(dls_global_solve(G, S.f, S.g, mu, &few, r, x, NULL, NULL), 0);
  const double asked = (double)malloc_bytes();
  ck_assert(!dls_global_get_info(G, &info, NULL));
  ck_assert_msg(info.bytes <= asked && info.bytes >= .5 * asked, "%g bytes asked, foreseen %g",
                asked, info.bytes);
  dls_global_destroy(G);
  free(mu);
  free(x);
  free(r);
  solids_free(&S);
}

TEST(errors_named) {
  solids S;
  dls_global *G;
  dls_global_info info = {.flops = -1};
  scene(&S, 0);
  REFUSES(ARGUMENT, "model", -1, dls_global_estimate, NULL, &info);
  REFUSES(ARGUMENT, "info", -1, dls_global_estimate, &S.model, NULL);
  REFUSES(ARGUMENT, "global", -1, dls_global_get_info, NULL, &info);
  ck_assert(!dls_global_create(&G, &S.model, NULL));
  REFUSES(ARGUMENT, "info", -1, dls_global_get_info, G, NULL);
  G->busy = 1;
  REFUSES(BUSY, "global", -1, dls_global_get_info, G, &info);
  G->busy = 0;
  dls_global_destroy(G);
  solids_free(&S);
  scene(&S, 3);
  MALLOCS_FAIL(dls_global_estimate(&S.model, &info, NULL), info.flops == -1, DLS_OK, 19);
  solids_free(&S);
}
