/*
 * mtx.c: reads dense and sparse matrices from Matrix Market files (Boisvert, Pozo, Remington,
 * NISTIR 5935, 1996) and sparse ones from CalculiX's; writes dense ones.
 *
 *   %%MatrixMarket matrix array|coordinate real|integer general|symmetric|skew-symmetric
 *   rows cols [entries]
 *   array: the values column by column (symmetric: on and below the diagonal; skew: below it)
 *   coordinate: row column value, 1-based
 *
 * CalculiX (*FREQUENCY, SOLVER=MATRIXSTORAGE): lines "row column value" of the upper triangle of a
 * symmetric matrix, 1-based, without a banner and without sizes.
 *
 * Comments (%) and blank lines may be anywhere, lines may end in CR LF. Entries of the same place
 * add up. Numbers are read and written with a decimal point in every locale of the host.
 */
#define _XOPEN_SOURCE 700
#include <ctype.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "contact/columns.h"
#include "delassus/files.h"
#include "files/file.h"
#include "files/output.h"

/* ---- words ----------------------------------------------------------------------------------- */

enum { longest = dlsi_longest_number }; /* of a word */

typedef struct scanner {
  FILE *file;
  long long next; /* line of the next character, 1-based */
  long long line; /* line of the word */
  size_t length;  /* of the word, 0 at the end of the file; if the word was cut, its full length */
  char word[longest + 1];
  dls_status status; /* of the first error */
  dls_error *error;
} scanner;

static int is_space(int c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

/* Scans the next word. A line whose first word starts with % is a comment, except the banner. */
static void scan(scanner *s) {
  int c = getc(s->file);
  for (int banner = s->length == 0 && s->line == 0;; banner = 0) {
    while (is_space(c)) {
      s->next += c == '\n';
      c = getc(s->file);
    }
    if (c != '%' || banner || s->line == s->next) break;
    while (c != '\n' && c != EOF)
      c = getc(s->file);
  }
  s->line = s->next;
  s->length = 0;
  for (; c != EOF && !is_space(c); c = getc(s->file), s->length++)
    if (s->length < longest) s->word[s->length] = (char)c;
  s->word[s->length < longest ? s->length : longest] = '\0';
  if (c != EOF) (void)ungetc(c, s->file);
}

/* Reports an error in the word, unless there was one before. */
static void blame(scanner *s, dls_status status, const char *text) {
  const char *word = s->length ? s->word : "end of file";
  if (s->status) return;
  (void)dlsi_fail(s->error, status, "path", s->line, 0, "line %lld, '%.20s': %s", s->line, word,
                  text);
  s->status = status;
}

/* Reports the word as a wrong format unless `holds`. */
static void require(scanner *s, int holds, const char *text) {
  if (!holds) blame(s, DLS_E_FORMAT, text);
}

/* Requires that the word, which is `here`, is a number, *x. */
static void require_number(scanner *s, int here, double *x) {
  if (here && dlsi_read_number(s->word, s->length, x)) return;
  blame(s, DLS_E_FORMAT,
        here && strchr(s->word, ',') ? "has a comma, decimals have a point"
                                     : "is no finite number");
}

/* Returns 1 if the word is `text`, which is in lower case, in any mix of cases. */
static int says(const scanner *s, const char *text) {
  if (s->length != strlen(text)) return 0;
  for (size_t k = 0; k < s->length; k++)
    if (tolower((unsigned char)s->word[k]) != text[k]) return 0;
  return 1;
}

/* ---- numbers --------------------------------------------------------------------------------- */

/* Reads word = digits, at most INT_MAX; returns 0 for any other word. */
static int to_int(const scanner *s, int *value) {
  const char *end = s->word;
  return dlsi_read_whole(&end, 0, INT_MAX, value) && (size_t)(end - s->word) == s->length;
}

/* Prints x with 17 significant digits, which read back to the same bits. */
static void print_double(FILE *file, double x) {
  char text[longest];
  if (snprintf(text, sizeof text, "%.16e", x) < 0) return;
  const size_t head = text[0] == '-' ? 2 : 1;
  size_t tail = head; /* past the locale's decimal point */
  while (text[tail] && !dlsi_is_digit(text[tail]))
    tail++;
  (void)fprintf(file, "%.*s.%s\n", (int)head, text, text + tail);
}

/* ---- reading --------------------------------------------------------------------------------- */

/* Up to this many rows and columns, or values of a dense matrix, the sizes in a file are trusted. A
 * larger matrix must have at least an entry for each row and each column: without them it is
 * singular, and a few bytes could ask for all memory. */
enum { free_lines = 1 << 22, free_values = 1 << 23 };

typedef enum symmetry { GENERAL, SYMMETRIC, SKEW } symmetry;

typedef struct layout {
  int coordinate;
  symmetry kind;
  int rows, cols, entries; /* entries: of the coordinate form */
} layout;

/* Scans the next word, which must be on line `line`. */
static int scan_on(scanner *s, long long line) {
  scan(s);
  return s->line == line;
}

static void read_banner(scanner *s, layout *form) {
  require(s, scan_on(s, 1) && says(s, "%%matrixmarket"), "is not %%MatrixMarket");
  require(s, scan_on(s, 1) && says(s, "matrix"), "must be 'matrix'");
  int here = scan_on(s, 1);
  form->coordinate = says(s, "coordinate");
  require(s, here && (form->coordinate || says(s, "array")), "must be 'array' or 'coordinate'");
  here = scan_on(s, 1);
  if (here && (says(s, "complex") || says(s, "pattern")))
    blame(s, DLS_E_UNSUPPORTED, "only real matrices are read");
  require(s, here && (says(s, "real") || says(s, "integer")), "must be 'real' or 'integer'");
  here = scan_on(s, 1);
  form->kind = says(s, "symmetric") ? SYMMETRIC : says(s, "skew-symmetric") ? SKEW : GENERAL;
  require(s, here && (form->kind != GENERAL || says(s, "general")),
          "must be general, symmetric or skew-symmetric");
}

/* Requires that the rest of a file of `bytes` can hold `count` items of `least` characters. */
static void require_bytes(scanner *s, size_t count, size_t least) {
  const long long bytes = dlsi_file_size(s->file);
  if (bytes >= 0 && count > (size_t)bytes / least)
    blame(s, DLS_E_FORMAT, "claims more values than the file has room for");
}

/* Compares what a file claims with its size; dense = 1: for the dense form. */
static void check_sizes(scanner *s, const layout *form, int dense) {
  const size_t rows = (size_t)form->rows, cols = (size_t)form->cols;
  const size_t lines = rows > cols ? rows : cols, entries = (size_t)form->entries;
  if (!form->coordinate)
    require_bytes(s, form->kind == GENERAL ? rows * cols : rows * (rows - 1) / 2, 2);
  else
    require_bytes(s, entries, 6); /* "1 1 1\n" */
  if (form->coordinate && entries < lines &&
      (lines > free_lines || (dense && rows * cols > free_values)))
    blame(s, DLS_E_SIZE, "are too few entries for a matrix of this size");
}

static void read_sizes(scanner *s, layout *form, int dense) {
  scan(s);
  const long long line = s->line;
  require(s, to_int(s, &form->rows) && form->rows > 0, "is no number of rows");
  require(s, line > 1, "is too much for the first line");
  require(s, scan_on(s, line) && to_int(s, &form->cols) && form->cols > 0,
          "is no number of columns");
  require(s, form->kind == GENERAL || form->rows == form->cols,
          "a symmetric matrix must be square");
  if (s->status) return;
  if ((size_t)form->rows > PTRDIFF_MAX / sizeof(double) / (size_t)form->cols)
    blame(s, DLS_E_SIZE, "rows * cols is too large to address");
  if (form->coordinate)
    require(s, scan_on(s, line) && to_int(s, &form->entries), "is no number of entries");
  if (!s->status) check_sizes(s, form, dense);
}

/* Adds x to *sum; 0 + x is x itself, even for -0.0. */
static void add_value(double *sum, double x) {
  *sum = *sum == 0 ? x : *sum + x;
}

/* The matrix to read: dense a (rows x cols), or triplets if a is NULL. */
typedef struct target {
  double *a;
  dlsi_triplets *t;
} target;

static void put_entry(const layout *form, const target *to, int i, int j, double x) {
  if (to->a)
    add_value(&to->a[(size_t)i + (size_t)j * (size_t)form->rows], x);
  else
    dlsi_triplets_add(to->t, i, j, x);
}

static void put_value(const layout *form, const target *to, int i, int j, double x) {
  put_entry(form, to, i, j, x);
  if (form->kind != GENERAL && i != j) put_entry(form, to, j, i, form->kind == SKEW ? -x : x);
}

static void read_array(scanner *s, const layout *form, const target *to) {
  for (int j = 0; j < form->cols; j++)
    for (int i = form->kind == GENERAL ? 0 : form->kind == SKEW ? j + 1 : j; i < form->rows; i++) {
      double x = 0;
      scan(s);
      require(s, s->length > 0, "there are too few values");
      require_number(s, 1, &x);
      if (s->status) return;
      put_value(form, to, i, j, x);
    }
}

static void read_coordinates(scanner *s, const layout *form, const target *to) {
  for (int k = 0; k < form->entries; k++) {
    int i = 0, j = 0;
    double x = 0;
    scan(s);
    const long long line = s->line;
    require(s, s->length > 0, "there are too few entries");
    require(s, to_int(s, &i) && i >= 1 && i <= form->rows, "is no row of the matrix");
    require(s, scan_on(s, line) && to_int(s, &j) && j >= 1 && j <= form->cols,
            "is no column of the matrix");
    require(s, form->kind == GENERAL || (form->kind == SKEW ? i > j : i >= j),
            "must be in the lower triangle");
    require_number(s, scan_on(s, line), &x);
    if (s->status) return;
    put_value(form, to, i - 1, j - 1, x);
  }
}

/* Reads the entries, which must be the rest of the file. */
static dls_status read_entries(scanner *s, const layout *form, const target *to) {
  (form->coordinate ? read_coordinates : read_array)(s, form, to);
  if (s->status) return s->status;
  scan(s);
  require(s, !s->length, "comes after the last entry");
  if (!s->status && ferror(s->file))
    return dlsi_fail(s->error, DLS_E_FILE, "path", -1, 0, "cannot be read");
  return s->status;
}

/* Reads a dense matrix into a new array *a, after its banner and sizes. */
static dls_status read_dense(scanner *s, const layout *form, double **a) {
  /* calloc, not malloc: a short file that claims a large matrix touches no memory */
  const size_t size = (size_t)form->rows * (size_t)form->cols;
  *a = calloc(size, sizeof **a);
  if (!*a) return dlsi_no_memory(s->error);
  const dls_status status = read_entries(s, form, &(target){.a = *a});
  if (status) return status;
  /* entries of the same place may add up beyond the range */
  require(s, dlsi_first_not_finite(*a, size) < 0, "entries of one place overflow");
  return s->status;
}

/* Turns the entries of a dense matrix that are not 0 into triplets. */
static dls_status triplets_of_dense(const layout *form, const double *a, dlsi_triplets *t,
                                    dls_error *error) {
  const size_t rows = (size_t)form->rows, size = rows * (size_t)form->cols;
  size_t count = 0;
  for (size_t e = 0; e < size; e++)
    count += a[e] != 0;
  const dls_status status = dlsi_triplets_alloc(form->rows, form->cols, count, t, error);
  for (size_t e = 0; !status && e < size; e++)
    if (a[e] != 0) dlsi_triplets_add(t, (int)(e % rows), (int)(e / rows), a[e]);
  return status;
}

/* Reads a matrix into triplets, after its banner and sizes. On error, too, the caller frees t. */
static dls_status read_triplets(scanner *s, const layout *form, dlsi_triplets *t) {
  if (!form->coordinate) {
    double *a = NULL;
    dls_status status = read_dense(s, form, &a);
    if (!status) status = triplets_of_dense(form, a, t, s->error);
    free(a);
    return status;
  }
  const size_t most = (size_t)form->entries * (form->kind == GENERAL ? 1 : 2);
  const dls_status status = dlsi_triplets_alloc(form->rows, form->cols, most, t, s->error);
  return status ? status : read_entries(s, form, &(target){.t = t});
}

/* Reads the place of an entry of CalculiX's matrix, from 1, and goes to its value. */
static void read_place(scanner *s, int *row, int *col) {
  require(s, to_int(s, row) && *row >= 1, "is no row of CalculiX's matrix");
  scan(s);
  require(s, to_int(s, col) && *col >= *row, "is no column on or above the diagonal");
  scan(s);
}

/* Counts the entries of CalculiX's matrix; its size is the largest column. Goes back to its
 * start. */
static void count_calculix(scanner *s, layout *form) {
  const off_t start = ftello(s->file); /* behind a byte order mark */
  for (scan(s); s->length && !s->status; scan(s)) {
    int row = 0, col = 0;
    read_place(s, &row, &col);
    if (col > form->cols) form->cols = col;
    require(s, ++form->entries < INT_MAX, "there are too many entries");
  }
  require(s, form->entries > 0, "there are no entries");
  if (form->cols > free_lines && form->entries < form->cols)
    blame(s, DLS_E_SIZE, "there are too few entries for a matrix of this size");
  form->rows = form->cols;
  if (fseeko(s->file, start, SEEK_SET)) blame(s, DLS_E_FILE, "cannot be read twice");
  *s = (scanner){.file = s->file, .next = 1, .status = s->status, .error = s->error};
}

static dls_status read_calculix(scanner *s, dlsi_triplets *t) {
  layout form = {.coordinate = 1, .kind = SYMMETRIC};
  count_calculix(s, &form);
  if (s->status) return s->status;
  const dls_status status =
      dlsi_triplets_alloc(form.rows, form.cols, 2 * (size_t)form.entries, t, s->error);
  if (status) return status;
  for (int k = 0; k < form.entries && !s->status; k++) {
    int row = 0, col = 0;
    double x = 0;
    scan(s);
    read_place(s, &row, &col);
    require(s, col <= form.cols, "has changed meanwhile");
    require_number(s, 1, &x);
    if (!s->status) put_value(&form, &(target){.t = t}, row - 1, col - 1, x);
  }
  return s->status;
}

dls_status dlsi_mtx_columns(const dlsi_triplets *t, dls_sparse *A, dls_error *error) {
  dlsi_columns columns = {0};
  const dls_status status = dlsi_columns_compress(t, 1, DLSI_ALL, &columns, error);
  if (status)
    dlsi_columns_free(&columns);
  else
    *A = dlsi_columns_view(&columns);
  return status;
}

dls_status dlsi_mtx_read_file(const char *path, int calculix, dlsi_triplets *t, int *symmetric,
                              dls_error *error) {
  FILE *file = dlsi_file_open(path, error);
  if (!file) return DLS_E_FILE;
  scanner s = {.file = file, .next = 1, .error = error};
  layout form = {.kind = SYMMETRIC};
  dls_status status;
  if (calculix)
    status = read_calculix(&s, t);
  else {
    read_banner(&s, &form);
    if (!s.status) read_sizes(&s, &form, 0);
    status = s.status ? s.status : read_triplets(&s, &form, t);
  }
  (void)fclose(file);
  if (!status && symmetric) *symmetric = form.kind == SYMMETRIC;
  return status;
}

void dls_mtx_free_sparse(dls_sparse *A) {
  if (!A) return;
  dlsi_columns own = {A->rows, A->cols, (int *)(uintptr_t)A->p, (int *)(uintptr_t)A->i,
                      (double *)(uintptr_t)A->x};
  dlsi_columns_free(&own);
  *A = (dls_sparse){0};
}

dls_status dls_mtx_read(const char *path, int *rows, int *cols, double **a, dls_error *error) {
  DLSI_DOOR;
  dls_status status = a ? DLS_OK : dlsi_is_null(error, "a");
  if (a) *a = NULL;
  if (!status && !path) status = dlsi_is_null(error, "path");
  if (!status && !rows) status = dlsi_is_null(error, "rows");
  if (!status && !cols) status = dlsi_is_null(error, "cols");
  FILE *file = status ? NULL : dlsi_file_open(path, error);
  if (!file) return dlsi_at(__func__, status ? status : DLS_E_FILE, error);
  scanner s = {.file = file, .next = 1, .error = error};
  layout form = {0};
  double *values = NULL;
  read_banner(&s, &form);
  if (!s.status) read_sizes(&s, &form, 1);
  status = s.status ? s.status : read_dense(&s, &form, &values);
  (void)fclose(file);
  if (status) {
    free(values);
    return dlsi_at(__func__, status, error);
  }
  *rows = form.rows;
  *cols = form.cols;
  *a = values;
  return DLS_OK;
}

void dls_mtx_free(double *a) {
  free(a);
}

/* ---- writing --------------------------------------------------------------------------------- */

static dls_status write_dense(const char *path, const dls_dense *A, const char *comment,
                              dls_error *error) {
  if (!path) return dlsi_is_null(error, "path");
  if (!A) return dlsi_is_null(error, "A");
  if (A->rows < 1 || A->cols < 1)
    return dlsi_fail(error, DLS_E_SIZE, "A", -1, A->rows, "is %d x %d", A->rows, A->cols);
  dls_status status = dlsi_check_dense("A", A, A->rows, A->cols, error);
  if (status) return status;
  if (comment && strpbrk(comment, "\r\n"))
    return dlsi_fail(error, DLS_E_ARGUMENT, "comment", -1, 0, "has more than one line");
  dlsi_output out;
  status = dlsi_output_open(&out, path, error);
  if (status) return status;
  (void)fprintf(out.file, "%%%%MatrixMarket matrix array real general\n");
  if (comment && comment[0]) (void)fprintf(out.file, "%% %s\n", comment);
  (void)fprintf(out.file, "%d %d\n", A->rows, A->cols);
  for (int j = 0; j < A->cols; j++)
    for (int i = 0; i < A->rows; i++)
      print_double(out.file, A->a[(size_t)i + (size_t)j * (size_t)A->ld]);
  return dlsi_output_finish(&out, error);
}

dls_status dls_mtx_write(const char *path, const dls_dense *A, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, write_dense(path, A, NULL, error), error);
}

dls_status dls_mtx_write_commented(const char *path, const dls_dense *A, const char *comment,
                                   dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, write_dense(path, A, comment, error), error);
}
