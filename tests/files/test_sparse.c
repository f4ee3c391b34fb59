/* test_sparse.c: sparse matrices from Matrix Market and CalculiX files. */
#define _GNU_SOURCE
#include <unistd.h>

#include "delassus/files.h"
#include "run.h"

static char path[64], as_mtx[64]; /* one file; the name of the first is CalculiX's */

static void make_file(void) {
  (void)snprintf(path, sizeof path, "/tmp/delassus-sparse-XXXXXX.sti");
  const int file = mkstemps(path, 4);
  ck_assert_int_ge(file, 0);
  (void)close(file);
  (void)snprintf(as_mtx, sizeof as_mtx, "%.*s", (int)strlen(path) - 4, path);
  ck_assert_int_eq(symlink(path, as_mtx), 0);
}

static void remove_file(void) {
  (void)remove(path);
  (void)remove(as_mtx);
}

static void put(const char *text) {
  FILE *file = fopen(path, "w");
  ck_assert_ptr_nonnull(file);
  fputs(text, file);
  ck_assert_int_eq(fclose(file), 0);
}

/* The sum of the entries of A at (i, j). */
static double at(const dls_sparse *A, int i, int j) {
  double sum = 0;
  for (int k = A->p[j]; k < A->p[j + 1]; k++)
    if (A->i[k] == i) sum += A->x[k];
  return sum;
}

/* A is the matrix a (rows x cols, row by row) with `entries` stored. */
static void is_matrix(const dls_sparse *A, int rows, int cols, int entries, const double *a) {
  ck_assert_int_eq(A->rows, rows);
  ck_assert_int_eq(A->cols, cols);
  ck_assert_int_eq(A->p[cols], entries);
  for (int i = 0; i < rows; i++)
    for (int j = 0; j < cols; j++)
      ck_assert_double_eq(at(A, i, j), a[i * cols + j]);
}

TEST(matrix_market) {
  dls_sparse A;
  int symmetric = -1;
  put("%%MatrixMarket matrix coordinate real general\n% c\n2 3 3\n1 1 1.5\n2 3 -2\n2 3 -1\n");
  ck_assert_int_eq(dls_matrix_read(as_mtx, 0, &A, &symmetric, NULL, NULL), DLS_OK);
  is_matrix(&A, 2, 3, 3, (const double[]){1.5, 0, 0, 0, 0, -3});
  ck_assert_int_eq(symmetric, 0);
  dls_mtx_free_sparse(&A);
  ck_assert(!A.p && !A.i && !A.x && !A.rows);
  put("%%MatrixMarket matrix coordinate integer symmetric\n2 2 2\n1 1 4\n2 1 7\n");
  ck_assert_int_eq(dls_matrix_read(as_mtx, 0, &A, &symmetric, NULL, NULL), DLS_OK);
  is_matrix(&A, 2, 2, 3, (const double[]){4, 7, 7, 0});
  ck_assert_int_eq(symmetric, 1);
  dls_mtx_free_sparse(&A);
  put("%%MatrixMarket matrix coordinate real skew-symmetric\n2 2 1\n2 1 7\n");
  ck_assert_int_eq(dls_matrix_read(as_mtx, 0, &A, NULL, NULL, NULL), DLS_OK);
  is_matrix(&A, 2, 2, 2, (const double[]){0, -7, 7, 0});
  dls_mtx_free_sparse(&A);
  put("%%MatrixMarket matrix array real general\n2 2\n1\n0\n0\n3\n");
  ck_assert_int_eq(dls_matrix_read(as_mtx, 0, &A, &symmetric, NULL, NULL), DLS_OK);
  is_matrix(&A, 2, 2, 2, (const double[]){1, 0, 0, 3});
  dls_mtx_free_sparse(&A);
  dls_mtx_free_sparse(NULL);
}

/* Every entry of a dense matrix has its place: none is 0. */
TEST(full_array) {
  enum { n = 60 };
  static char text[64 + 8 * n * n];
  static double a[n * n];
  int end = sprintf(text, "%%%%MatrixMarket matrix array integer general\n%d %d\n", n, n);
  for (int k = 0; k < n * n; k++) {
    a[k % n * n + k / n] = k + 1;
    end += sprintf(text + end, "%d\n", k + 1);
  }
  put(text);
  dls_sparse A;
  ck_assert_int_eq(dls_matrix_read(as_mtx, 0, &A, NULL, NULL, NULL), DLS_OK);
  is_matrix(&A, n, n, n * n, a);
  dls_mtx_free_sparse(&A);
}

TEST(of_calculix) {
  static const char *const marks[] = {"", "\xef\xbb\xbf"}; /* of the order of bytes */
  for (int k = 0; k < 2; k++) {
    dls_sparse A;
    char text[80];
    (void)snprintf(text, sizeof text, "%s%s", marks[k],
                   "1 1  3.0000000000000e+00\n1 2 -1.0e+00\n2 2 2\n3 3 5\n");
    put(text);
    ck_assert_int_eq(dls_matrix_read(path, 0, &A, NULL, NULL, NULL), DLS_OK);
    is_matrix(&A, 3, 3, 5, (const double[]){3, -1, 0, -1, 2, 0, 0, 0, 5});
    dls_mtx_free_sparse(&A);
  }
}

/* A dense matrix of more than 2^23 values has an entry for each row, or is refused. */
TEST(few_entries) {
  enum { n = 2897 }; /* n n = 8392609 */
  for (int entries = n; entries >= n - 1; entries--) {
    int rows = 77, cols = 77;
    double *a;
    dls_error e;
    FILE *file = fopen(path, "w");
    ck_assert_ptr_nonnull(file);
    (void)fprintf(file, "%%%%MatrixMarket matrix coordinate real general\n%d %d %d\n", n, n,
                  entries);
    for (int k = 1; k <= entries; k++)
      (void)fprintf(file, "%d %d 2\n", k, k);
    ck_assert_int_eq(fclose(file), 0);
    const dls_status status = dls_mtx_read(path, &rows, &cols, &a, &e);
    ck_assert_int_eq(status, entries == n ? DLS_OK : DLS_E_SIZE);
    if (entries == n) ck_assert(rows == n && cols == n && a[(size_t)n * n - 1] == 2 && a[1] == 0);
    if (entries < n) ck_assert(rows == 77 && cols == 77 && !a && e.index == 2);
    dls_mtx_free(a);
    dls_sparse A;
    ck_assert_int_eq(dls_matrix_read(as_mtx, 0, &A, NULL, NULL, NULL), DLS_OK);
    dls_mtx_free_sparse(&A);
  }
}

TEST(bad_files) {
  static const struct {
    int calculix;
    const char *text;
    dls_status status;
    long long line;
  } bad[] = {
      {0, "", DLS_E_FORMAT, -1}, /* text */
      {0, "%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 1\n", DLS_E_FORMAT, 4},
      {0, "%%MatrixMarket matrix coordinate real general\n2 2 1\n1 3 1\n", DLS_E_FORMAT, 3},
      {0, "%%MatrixMarket matrix coordinate real general\n2 2 1\n1 1 nan\n", DLS_E_FORMAT, 3},
      {0, "%%MatrixMarket matrix coordinate pattern general\n2 2 1\n1 1\n", DLS_E_UNSUPPORTED, 1},
      {0, "%%MatrixMarket matrix coordinate real symmetric\n2 2 2000000000\n", DLS_E_FORMAT, 2},
      {0, "%%MatrixMarket matrix coordinate real general\n9 2147483647 1\n1 1 1\n", DLS_E_SIZE, 2},
      {0, /* a row of 66 characters, more than a word holds */
       "%%MatrixMarket matrix coordinate real general\n2 2 1\n"
       "1'aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa 1 1\n",
       DLS_E_FORMAT, 3},
      {1, "1 2147483647 2\n", DLS_E_SIZE, 2},
      {1, "", DLS_E_FORMAT, 1},
      {1, "1 1 2\n2 1 3\n", DLS_E_FORMAT, 2},
      {1, "1 1 inf\n", DLS_E_FORMAT, 1},
      {1, "1 1 2\n2 2\n", DLS_E_FORMAT, 3},
      {1, "0 1 2\n", DLS_E_FORMAT, 1},
  };
  for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
    dls_sparse A = {.rows = 77};
    dls_error error = {0};
    put(bad[k].text);
    const dls_status status = bad[k].calculix ? dls_matrix_read(path, 0, &A, NULL, NULL, &error)
                                              : dls_matrix_read(as_mtx, 0, &A, NULL, NULL, &error);
    ck_assert_msg(status == bad[k].status, "%zu: %s", k, error.message);
    ck_assert_msg(error.index == bad[k].line, "%zu: %s", k, error.message);
    ck_assert_int_eq(A.rows, 77);
  }
  dls_sparse A;
  dls_error error;
  ck_assert_int_eq(dls_matrix_read("/nowhere/at/all", 0, &A, NULL, NULL, &error), DLS_E_FILE);
  ck_assert_str_eq(error.function, "dls_matrix_read");
  REFUSES(ARGUMENT, "path", -1, dls_matrix_read, NULL, 0, &A, NULL, NULL);
  REFUSES(ARGUMENT, "A", -1, dls_matrix_read, path, 0, NULL, NULL, NULL);
}

TEST(failing_mallocs) {
  static const char *const texts[] = {"%%MatrixMarket matrix array real general\n2 2\n1\n0\n0\n3\n",
                                      "1 1 3\n"};
  for (int calculix = 0; calculix < 2; calculix++) {
    dls_sparse A = {.rows = 77};
    put(texts[calculix]);
    MALLOCS_FAIL(dls_matrix_read(calculix ? path : as_mtx, 0, &A, NULL, NULL, NULL), A.rows == 77,
                 DLS_OK, 1);
    ck_assert_int_lt(mallocs_failed, 19);
    dls_mtx_free_sparse(&A);
  }
}

int main(void) {
  return run_tests("sparse", make_file, remove_file);
}
