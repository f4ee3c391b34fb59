/*
 * arrays.c: reads matrices and vectors of a host code from files: Matrix Market, NumPy's .npy,
 * plain text columns, and CalculiX's .sti, .mas and .dof. A file tells its kind by its first bytes,
 * CalculiX's by the name.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "arrays.h"
#include "cli.h"

static const char npy_magic[] = "\x93NUMPY";

/* ---- kinds of files -------------------------------------------------------------------------- */

typedef enum array_kind { ARRAY_NONE, ARRAY_MTX, ARRAY_NPY, ARRAY_CALCULIX, ARRAY_TEXT } array_kind;

static int ends_in(const char *path, const char *end) {
  const size_t length = strlen(path), tail = strlen(end);
  return length > tail && strcmp(path + length - tail, end) == 0;
}

int array_is_calculix(const char *path) {
  return ends_in(path, ".sti") || ends_in(path, ".mas");
}

/* Opens a file, past the byte order mark of UTF-8; returns NULL after a complaint. */
static FILE *array_open(const char *path) {
  static const unsigned char mark[3] = {0xef, 0xbb, 0xbf};
  unsigned char first[3];
  FILE *file = fopen(input_path(path), "rb");
  if (!file)
    (void)complain("%s: cannot be opened: %s", path, strerror(errno));
  else if (fread(first, 1, 3, file) != 3 || memcmp(first, mark, 3) != 0)
    rewind(file);
  return file;
}

static array_kind find_kind(const char *path) {
  char first[16] = {0};
  if (array_is_calculix(path)) return ARRAY_CALCULIX;
  FILE *file = array_open(path);
  if (!file) return ARRAY_NONE;
  const size_t got = fread(first, 1, sizeof first - 1, file);
  const int failed = ferror(file);
  (void)fclose(file);
  if (failed) return (array_kind)refuse("%s: cannot be read", path);
  if (got >= 4 && memcmp(first, "PK\3\4", 4) == 0)
    return (array_kind)refuse(
        "%s: is a zip file; of an .npz write each array by numpy.save, a sparse matrix "
        "by scipy.io.mmwrite",
        path);
  if (got >= 8 && memcmp(first, "\x89HDF\r\n\x1a\n", 8) == 0)
    return (array_kind)refuse(
        "%s: is an HDF5 file, no matrix; a problem of FCLIB: delassus solve %s", path, path);
  if (got >= 14 && strncasecmp(first, "%%MatrixMarket", 14) == 0) return ARRAY_MTX;
  return got >= 6 && memcmp(first, npy_magic, 6) == 0 ? ARRAY_NPY : ARRAY_TEXT;
}

/* ---- plain text ------------------------------------------------------------------------------ */

static int is_separator(int c) {
  return c == ' ' || c == '\t' || c == '\r' || c == ',' || c == ';';
}

static int table_add(table *t, size_t count, size_t *room, double x) {
  if (count == *room) {
    *room = *room ? 2 * *room : 256;
    double *more = *room > SIZE_MAX / sizeof *more ? NULL : realloc(t->a, *room * sizeof *more);
    if (!more) return refuse("out of memory");
    t->a = more;
  }
  t->a[count] = x;
  return 1;
}

/* Reads rows of numbers between blanks, commas or semicolons; # or % begins a comment. "inf" is a
 * number here: an infinite friction. */
static int array_read_text(const char *path, FILE *file, table *t) {
  char *line = NULL;
  size_t size = 0, count = 0, room = 0;
  int number = 0, good = 1;
  while (good && getline(&line, &size, file) >= 0) {
    number++;
    int cols = 0;
    for (char *word = line; good;) {
      while (is_separator((unsigned char)*word))
        word++;
      if (*word == '\0' || *word == '\n' || *word == '#' || *word == '%') break;
      char *end;
      const size_t digits = strspn(word, "+-.0123456789"); /* 1D0 is Fortran's 1E0 */
      if (digits && (word[digits] == 'd' || word[digits] == 'D')) word[digits] = 'e';
      const double x = strtod(word, &end);
      good = end > word && (*end == '\0' || *end == '\n' || is_separator((unsigned char)*end)) &&
             !isnan(x);
      if (!good)
        (void)complain("%s: line %d, '%.20s': is no number", path, number, strtok(word, " ,;\n"));
      else
        good = table_add(t, count++, &room, x);
      word = end;
      cols++;
    }
    if (!good || cols == 0) continue;
    if (t->rows++ == 0) t->cols = cols;
    if (cols != t->cols) {
      good = 0;
      (void)complain("%s: line %d has %d number%s, those before have %d", path, number, cols,
                     plural(cols), t->cols);
    }
  }
  free(line);
  if (good && count == 0) return refuse("%s: holds no number", path);
  return good && (count <= INT_MAX || refuse("%s: holds too many numbers", path));
}

/* ---- .npy ------------------------------------------------------------------------------------ */

/* Reads the header: magic, version, length (2 bytes, from version 2 on 4), and a dictionary like
 * {'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }. */
static int read_npy_header(FILE *file, int *by_columns, table *t) {
  unsigned char fixed[12];
  char text[1024] = {0};
  if (fread(fixed, 1, 10, file) != 10) return 0;
  size_t length = fixed[8] + 256u * fixed[9];
  if (fixed[6] < 1 || fixed[6] > 3 || fixed[7]) return 0; /* the versions that there are */
  if (fixed[6] > 1 && (fread(fixed + 10, 1, 2, file) != 2 || fixed[10] || fixed[11])) return 0;
  if (length >= sizeof text || fread(text, 1, length, file) != length) return 0;
  const char *order = strstr(text, "'fortran_order': "), *shape = strstr(text, "'shape': (");
  if (!strstr(text, "'descr': '<f8'") || !order || !shape) return 0;
  *by_columns = strncmp(order + 17, "True", 4) == 0;
  shape += strlen("'shape': (");
  t->cols = 1;
  if (!dlsi_read_whole(&shape, 1, INT_MAX, &t->rows) || *shape++ != ',') return 0;
  if (*shape == ' ' && shape++ && !dlsi_read_whole(&shape, 1, INT_MAX / t->rows, &t->cols))
    return 0;
  return *shape == ')';
}

static int read_npy(const char *path, FILE *file, table *t) {
  static const union {
    uint16_t word;
    unsigned char first;
  } order = {1};
  int by_columns = 0;
  if (!order.first) return refuse("%s: .npy is read on little-endian machines", path);
  if (!read_npy_header(file, &by_columns, t))
    return refuse("%s: is no .npy of float64 in one or two dimensions", path);
  const size_t rows = (size_t)t->rows, cols = (size_t)t->cols, size = rows * cols;
  struct stat entry; /* a claim of more than the file holds takes no memory */
  if (fstat(fileno(file), &entry) || size > (size_t)entry.st_size / sizeof *t->a)
    return refuse("%s: holds less than %zu numbers", path, size);
  t->a = calloc(size, sizeof *t->a);
  double *x = calloc(size, sizeof *x);
  const int good = t->a && x && fread(x, sizeof *x, size, file) == size && getc(file) == EOF;
  for (size_t e = 0; good && e < size; e++)
    t->a[e] = by_columns ? x[e / cols + e % cols * rows] : x[e];
  if (!good)
    (void)(t->a && x ? complain("%s: holds more or less than %zu number%s", path, size,
                                plural((long long)size))
                     : complain("%s: out of memory", path));
  free(x);
  return good;
}

/* ---- tables and matrices --------------------------------------------------------------------- */

static int read_mtx_table(const char *path, table *t) {
  dls_error error = {0};
  double *x = NULL;
  if (dls_mtx_read(input_path(path), &t->rows, &t->cols, &x, &error))
    return complain_of(path, &error), 0;
  const size_t rows = (size_t)t->rows, cols = (size_t)t->cols;
  t->a = malloc(rows * cols * sizeof *t->a);
  for (size_t e = 0; t->a && e < rows * cols; e++)
    t->a[e] = x[e / cols + e % cols * rows];
  dls_mtx_free(x);
  return t->a || refuse("%s: out of memory", path);
}

int table_read(const char *path, table *t) {
  *t = (table){0};
  const array_kind kind = find_kind(path);
  if (kind == ARRAY_NONE) return 0;
  if (kind == ARRAY_MTX) return read_mtx_table(path, t);
  if (kind == ARRAY_CALCULIX) return refuse("%s: is a sparse matrix", path);
  FILE *file = array_open(path);
  if (!file) return 0;
  const int good = (kind == ARRAY_NPY ? read_npy : array_read_text)(path, file, t);
  (void)fclose(file);
  return good;
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

static int sparse_of_table(const table *t, sparse *A) {
  size_t count = 0;
  for (size_t e = 0; e < (size_t)t->rows * (size_t)t->cols; e++)
    count += t->a[e] != 0;
  if (!sparse_alloc(t->rows, t->cols, count, A)) return 0;
  int k = 0;
  for (int j = 0; j < t->cols; j++) {
    A->p[j] = k;
    for (int i = 0; i < t->rows; i++) {
      const double x = t->a[(size_t)i * (size_t)t->cols + (size_t)j];
      if (x == 0) continue;
      A->i[k] = i;
      A->x[k++] = x;
    }
  }
  A->p[t->cols] = k;
  return 1;
}

int sparse_read(const char *path, sparse *A) {
  *A = (sparse){0};
  dls_error error = {0};
  const array_kind kind = find_kind(path);
  if (kind == ARRAY_NONE) return 0;
  if (kind == ARRAY_MTX || kind == ARRAY_CALCULIX) {
    const dls_status status = kind == ARRAY_MTX
                                  ? dls_mtx_read_sparse(input_path(path), &A->view, NULL, &error)
                                  : dls_calculix_read(path, &A->view, &error);
    return !status || (complain_of(path, &error), 0);
  }
  table t;
  const int good = table_read(path, &t) && sparse_of_table(&t, A);
  free(t.a);
  return good;
}

void sparse_free(sparse *A) {
  if (A->p || A->i || A->x) {
    free(A->p);
    free(A->i);
    free(A->x);
  } else
    dls_mtx_free_sparse(&A->view);
  *A = (sparse){0};
}

int array_is_sparse(const char *path) {
  char line[128] = "";
  if (array_is_calculix(path)) return 1;
  FILE *file = array_open(path);
  const char *got = file ? fgets(line, sizeof line, file) : NULL;
  if (file) (void)fclose(file);
  return got && strncasecmp(line, "%%MatrixMarket", 14) == 0 && strcasestr(line, "coordinate");
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
