/* arrays.c: matrices and vectors of a host code, in the formats of src/files/matrix.c; finds
 * out if one is half of a symmetric matrix. */
#define _GNU_SOURCE
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arrays.h"
#include "problem.h"

/* Text that is no better than a dense table holds triplets: --triplets. */
static int of_triplets;

void arrays_of_triplets(int on) {
  of_triplets = on;
}

/* Returns the format of a file; DLSI_UNKNOWN after a complaint. */
static dlsi_format find_format(const char *path) {
  dls_error error = {0};
  dlsi_format format;
  if (!dlsi_format_find(array_is_calculix(path) ? path : input_path(path), &format, &error))
    return format;
  (void)complain_of(path, &error);
  return DLSI_UNKNOWN;
}

int array_is_calculix(const char *path) {
  const size_t length = strlen(path);
  return length > 4 && (!strcmp(path + length - 4, ".sti") || !strcmp(path + length - 4, ".mas"));
}

int table_read(const char *path, table *t) {
  dls_error error = {0};
  *t = (table){0};
  if (dlsi_table_read(input_path(path), t, &error)) return complain_of(path, &error), 0;
  if (t->commas && !is_quiet())
    (void)complain("hint: %s: its commas are read as separators; a decimal has a point", path);
  return 1;
}

int table_is_triplets(const table *t) {
  int whole = t->cols == 3 && t->rows > 3;
  for (int i = 0; whole && i < t->rows; i++)
    for (int j = 0; j < 2; j++) {
      const double x = t->a[3 * (size_t)i + (size_t)j];
      whole &= x >= 0 && x < INT_MAX && x == (int)x;
    }
  return whole;
}

double *table_by_columns(const char *path, const table *t) {
  const size_t rows = (size_t)t->rows, cols = (size_t)t->cols;
  double *x = malloc(rows * cols * sizeof *x);
  for (size_t e = 0; x && e < rows * cols; e++)
    x[e % cols * rows + e / cols] = t->a[e];
  if (!x) (void)complain("%s: out of memory", path);
  return x;
}

int sparse_alloc(int rows, int cols, size_t count, sparse *A) {
  A->p = malloc(((size_t)cols + 1) * sizeof *A->p);
  A->i = malloc((count ? count : 1) * sizeof *A->i);
  A->x = malloc((count ? count : 1) * sizeof *A->x);
  A->view = (dls_sparse){rows, cols, A->p, A->i, A->x};
  return (A->p && A->i && A->x) || refuse("out of memory");
}

int sparse_read(const char *path, sparse *A) {
  dls_error error = {0};
  *A = (sparse){0};
  if (dls_matrix_read(array_is_calculix(path) ? path : input_path(path), of_triplets, &A->view,
                      NULL, &A->labels, &error))
    return complain_of(path, &error), 0;
  if (A->labels || of_triplets || A->view.cols != 3 || find_format(path) != DLSI_TEXT) return 1;
  table t;
  const int mistaken = table_read(path, &t) && table_is_triplets(&t);
  free(t.a);
  return !mistaken || refuse_triplets(path);
}

int refuse_triplets(const char *path) {
  return refuse("%s: looks like triplets 'row column value' (MATLAB, Abaqus COORDINATE): use "
                "--triplets",
                path);
}

void sparse_free(sparse *A) {
  if (A->p || A->i || A->x) {
    free(A->p);
    free(A->i);
    free(A->x);
  } else
    dls_mtx_free_sparse(&A->view);
  dls_matrix_free_labels(A->labels);
  *A = (sparse){0};
}

int array_is_sparse(const char *path) {
  char line[128] = "";
  const dlsi_format format = find_format(path);
  if (format == DLSI_MTX) {
    FILE *file = fopen(input_path(path), "rb");
    const char *got = file ? fgets(line, sizeof line, file) : NULL;
    if (file) (void)fclose(file);
    return got && strcasestr(line, "coordinate");
  }
  if (format == DLSI_UNKNOWN) return -1;
  return format == DLSI_TEXT ? of_triplets : format != DLSI_NPY;
}

/* ---- symmetry -------------------------------------------------------------------------------- */

/* Two entries are the same but for the rounding of an assembly. */
static int is_same(double a, double b, double ii, double jj) {
  return a == b || fabs(a - b) <= 1e-12 * sqrt(fabs(ii)) * sqrt(fabs(jj));
}

int dense_is_symmetric(int n, const double *a) {
  const size_t ld = (size_t)n;
  for (size_t j = 0; j < ld; j++)
    for (size_t i = 0; i < j; i++)
      if (!is_same(a[i + j * ld], a[j + i * ld], a[i + i * ld], a[j + j * ld])) return 0;
  return 1;
}

/* Writes A^T into T, whose arrays have the sizes of A's. */
static void transpose(const dls_sparse *A, sparse *T) {
  const int n = A->rows;
  memset(T->p, 0, ((size_t)n + 1) * sizeof *T->p);
  for (int k = 0; k < A->p[A->cols]; k++)
    T->p[A->i[k] + 1]++;
  for (int i = 0; i < n; i++)
    T->p[i + 1] += T->p[i];
  for (int j = 0; j < A->cols; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++) {
      const int place = T->p[A->i[k]]++;
      T->i[place] = j;
      T->x[place] = A->x[k];
    }
  for (int i = n; i > 0; i--) /* each p[i] stands at the end of its row */
    T->p[i] = T->p[i - 1];
  T->p[0] = 0;
}

int sparse_is_symmetric(const dls_sparse *A) {
  const int n = A->rows;
  sparse T = {0};
  double *column = calloc(3 * (size_t)n, sizeof *column), *row = column + n, *diagonal = row + n;
  if (!column) return complain("out of memory"), -1;
  int same = sparse_alloc(n, n, (size_t)A->p[n], &T) ? 1 : -1;
  if (same > 0) transpose(A, &T);
  for (int j = 0; j < n && same > 0; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      if (A->i[k] == j) diagonal[j] += A->x[k];
  for (int j = 0; j < n && same > 0; j++) {
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      column[A->i[k]] += A->x[k];
    for (int k = T.p[j]; k < T.p[j + 1]; k++)
      row[T.i[k]] += T.x[k];
    for (int k = A->p[j]; k < A->p[j + 1]; k++) {
      const int i = A->i[k];
      if (!is_same(column[i], row[i], diagonal[i], diagonal[j])) same = 0;
    }
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      column[A->i[k]] = row[A->i[k]] = 0;
    for (int k = T.p[j]; k < T.p[j + 1]; k++) {
      const int i = T.i[k];
      if (!is_same(0, row[i], diagonal[i], diagonal[j])) same = 0; /* no entry in column j */
      row[i] = 0;
    }
  }
  free(column);
  sparse_free(&T);
  return same;
}

static const char *triangle_word(int below, int above) {
  return below == above ? NULL : below ? "a lower" : "an upper";
}

const char *dense_triangle(int n, const double *a) {
  const size_t ld = (size_t)n;
  int below = 0, above = 0;
  for (size_t j = 0; j < ld; j++)
    for (size_t i = 0; i < j; i++) {
      below |= a[j + i * ld] != 0;
      above |= a[i + j * ld] != 0;
    }
  return triangle_word(below, above);
}

const char *sparse_triangle(const dls_sparse *A) {
  int below = 0, above = 0;
  for (int j = 0; j < A->cols; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++) {
      below |= A->x[k] != 0 && A->i[k] > j;
      above |= A->x[k] != 0 && A->i[k] < j;
    }
  return triangle_word(below, above);
}
