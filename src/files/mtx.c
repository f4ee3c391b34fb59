/*
 * mtx.c: dense matrices as Matrix Market files (Boisvert, Pozo, Remington, NISTIR 5935, 1996).
 *
 *   %%MatrixMarket matrix array|coordinate real|integer general|symmetric|skew-symmetric
 *   rows cols [entries]
 *   array: the values column by column (symmetric: on and below the diagonal; skew: below it)
 *   coordinate: row column value, 1-based
 *
 * Comments (%) and blank lines may stand anywhere, lines may end in CR LF. Entries of the same place
 * add up. Numbers are read and written with a decimal point whatever the host's locale says.
 */
#include <ctype.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/files.h"
#include "files/file.h"

/* ---- words ----------------------------------------------------------------------------------- */

enum { longest = 64 }; /* of a word; a double needs 24 characters */

typedef struct scanner {
  FILE *file;
  long long next; /* line of the next character, 1-based */
  long long line; /* line of the word */
  size_t length;  /* of the word, 0 at the end of the file; more than it holds if it was cut */
  char word[longest + 1];
} scanner;

static int is_space(int c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

static int is_digit(int c) {
  return c >= '0' && c <= '9';
}

/* The next word; a line whose first word starts with % is a comment, but for the banner. */
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

static dls_status bad(const scanner *s, dls_error *error, dls_status status, const char *what) {
  const char *word = s->length ? s->word : "end of file";
  (void)dlsi_fail(error, status, "path", s->line, 0, "line %lld, '%.20s': %s", s->line, word, what);
  return status;
}

/* s->word is `text`, of lower case, in any case */
static int says(const scanner *s, const char *text) {
  if (s->length != strlen(text)) return 0;
  for (size_t k = 0; k < s->length; k++)
    if (tolower((unsigned char)s->word[k]) != text[k]) return 0;
  return 1;
}

/* ---- numbers --------------------------------------------------------------------------------- */

/* word = digits, at most INT_MAX */
static int to_int(const scanner *s, int *value) {
  long long v = 0;
  if (s->length < 1 || s->length > 10) return 0;
  for (size_t k = 0; k < s->length; k++) {
    if (!is_digit(s->word[k])) return 0;
    v = 10 * v + (s->word[k] - '0');
  }
  if (v > INT_MAX) return 0;
  *value = (int)v;
  return 1;
}

/* word = [+-] digits [. digits] [e [+-] digits], finite. strtod reads the decimal point of the
 * locale, which is what printf puts between the digits of 0.5. */
static int to_double(const scanner *s, double *value) {
  const char *w = s->word;
  if (s->length > longest) return 0;
  size_t digits = 0, point = SIZE_MAX, k = w[0] == '+' || w[0] == '-';
  for (; is_digit(w[k]) || (w[k] == '.' && point == SIZE_MAX); k++) {
    if (w[k] == '.')
      point = k;
    else
      digits++;
  }
  if (!digits) return 0;
  if (w[k] == 'e' || w[k] == 'E') {
    k += w[k + 1] == '+' || w[k + 1] == '-' ? 2 : 1;
    if (!is_digit(w[k])) return 0;
    while (is_digit(w[k]))
      k++;
  }
  if (w[k] != '\0' || k != s->length) return 0;
  char half[16], text[longest + sizeof half];
  if (snprintf(half, sizeof half, "%.1f", 0.5) < 3) return 0;
  const int point_length = (int)strlen(half) - 2;
  if (point == SIZE_MAX)
    (void)snprintf(text, sizeof text, "%s", w);
  else
    (void)snprintf(text, sizeof text, "%.*s%.*s%s", (int)point, w, point_length, half + 1,
                   w + point + 1);
  char *end;
  *value = strtod(text, &end);
  return *end == '\0' && isfinite(*value);
}

/* x with 17 significant digits, which read back to the same bits */
static void print_double(FILE *file, double x) {
  char text[longest];
  if (snprintf(text, sizeof text, "%.16e", x) < 0) return;
  const size_t head = text[0] == '-' ? 2 : 1;
  size_t tail = head; /* past the locale's decimal point */
  while (text[tail] && !is_digit(text[tail]))
    tail++;
  (void)fprintf(file, "%.*s.%s\n", (int)head, text, text + tail);
}

/* ---- reading --------------------------------------------------------------------------------- */

typedef enum symmetry { GENERAL, SYMMETRIC, SKEW } symmetry;

typedef struct layout {
  int coordinate;
  symmetry kind;
  int rows, cols, entries; /* entries: of the coordinate form */
} layout;

static dls_status read_banner(scanner *s, layout *form, dls_error *error) {
  scan(s);
  if (s->line != 1 || !says(s, "%%matrixmarket"))
    return bad(s, error, DLS_E_FORMAT, "is not %%MatrixMarket");
  scan(s);
  if (s->line != 1 || !says(s, "matrix")) return bad(s, error, DLS_E_FORMAT, "must be 'matrix'");
  scan(s);
  form->coordinate = says(s, "coordinate");
  if (s->line != 1 || (!form->coordinate && !says(s, "array")))
    return bad(s, error, DLS_E_FORMAT, "must be 'array' or 'coordinate'");
  scan(s);
  if (s->line == 1 && (says(s, "complex") || says(s, "pattern")))
    return bad(s, error, DLS_E_UNSUPPORTED, "only real matrices are read");
  if (s->line != 1 || (!says(s, "real") && !says(s, "integer")))
    return bad(s, error, DLS_E_FORMAT, "must be 'real' or 'integer'");
  scan(s);
  form->kind = says(s, "symmetric") ? SYMMETRIC : says(s, "skew-symmetric") ? SKEW : GENERAL;
  if (s->line != 1 || (form->kind == GENERAL && !says(s, "general")))
    return bad(s, error, DLS_E_FORMAT, "must be general, symmetric or skew-symmetric");
  return DLS_OK;
}

static dls_status read_sizes(scanner *s, layout *form, dls_error *error) {
  scan(s);
  if (!to_int(s, &form->rows) || form->rows < 1)
    return bad(s, error, DLS_E_FORMAT, "is no number of rows");
  if (s->line == 1) return bad(s, error, DLS_E_FORMAT, "is too much for the first line");
  const long long line = s->line;
  scan(s);
  if (s->line != line || !to_int(s, &form->cols) || form->cols < 1)
    return bad(s, error, DLS_E_FORMAT, "is no number of columns");
  if (form->kind != GENERAL && form->rows != form->cols)
    return bad(s, error, DLS_E_FORMAT, "a symmetric matrix must be square");
  if ((size_t)form->rows > PTRDIFF_MAX / sizeof(double) / (size_t)form->cols)
    return bad(s, error, DLS_E_SIZE, "rows * cols is too large to address");
  if (!form->coordinate) return DLS_OK;
  scan(s);
  if (s->line != line || !to_int(s, &form->entries))
    return bad(s, error, DLS_E_FORMAT, "is no number of entries");
  return DLS_OK;
}

/* *sum += x, where 0 + x is x itself, -0.0 too */
static void add(double *sum, double x) {
  *sum = *sum == 0 ? x : *sum + x;
}

static void put(const layout *form, double *a, int i, int j, double x) {
  const size_t rows = (size_t)form->rows;
  add(&a[(size_t)i + (size_t)j * rows], x);
  if (form->kind != GENERAL && i != j)
    add(&a[(size_t)j + (size_t)i * rows], form->kind == SKEW ? -x : x);
}

static dls_status read_array(scanner *s, const layout *form, double *a, dls_error *error) {
  for (int j = 0; j < form->cols; j++)
    for (int i = form->kind == GENERAL ? 0 : form->kind == SKEW ? j + 1 : j; i < form->rows; i++) {
      double x;
      scan(s);
      if (!s->length) return bad(s, error, DLS_E_FORMAT, "there are too few values");
      if (!to_double(s, &x)) return bad(s, error, DLS_E_FORMAT, "is no finite number");
      put(form, a, i, j, x);
    }
  return DLS_OK;
}

static dls_status read_coordinates(scanner *s, const layout *form, double *a, dls_error *error) {
  for (int k = 0; k < form->entries; k++) {
    int i, j;
    double x;
    scan(s);
    if (!s->length) return bad(s, error, DLS_E_FORMAT, "there are too few entries");
    if (!to_int(s, &i) || i < 1 || i > form->rows)
      return bad(s, error, DLS_E_FORMAT, "is no row of the matrix");
    const long long line = s->line;
    scan(s);
    if (s->line != line || !to_int(s, &j) || j < 1 || j > form->cols)
      return bad(s, error, DLS_E_FORMAT, "is no column of the matrix");
    if ((form->kind != GENERAL && i < j) || (form->kind == SKEW && i == j))
      return bad(s, error, DLS_E_FORMAT, "must be in the lower triangle");
    scan(s);
    if (s->line != line || !to_double(s, &x))
      return bad(s, error, DLS_E_FORMAT, "is no finite number");
    put(form, a, i - 1, j - 1, x);
  }
  return DLS_OK;
}

static dls_status read_matrix(FILE *file, layout *form, double **a, dls_error *error) {
  scanner s = {.file = file, .next = 1};
  dls_status status = read_banner(&s, form, error);
  if (!status) status = read_sizes(&s, form, error);
  if (status) return status;
  /* calloc, not malloc: a short file that claims a large matrix touches no memory */
  *a = calloc((size_t)form->rows * (size_t)form->cols, sizeof **a);
  if (!*a) return dlsi_no_memory(error);
  status = (form->coordinate ? read_coordinates : read_array)(&s, form, *a, error);
  if (status) return status;
  scan(&s);
  if (s.length) return bad(&s, error, DLS_E_FORMAT, "comes after the last entry");
  if (ferror(file)) return dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "cannot be read");
  /* entries of the same place may add up beyond the range */
  const long long over = dlsi_first_not_finite(*a, (size_t)form->rows * (size_t)form->cols);
  if (over >= 0) return bad(&s, error, DLS_E_FORMAT, "entries of one place overflow");
  return DLS_OK;
}

dls_status dls_mtx_read(const char *path, int *rows, int *cols, double **a, dls_error *error) {
  if (!a) return dlsi_at(__func__, dlsi_is_null(error, "a"), error);
  *a = NULL;
  if (!path) return dlsi_at(__func__, dlsi_is_null(error, "path"), error);
  if (!rows) return dlsi_at(__func__, dlsi_is_null(error, "rows"), error);
  if (!cols) return dlsi_at(__func__, dlsi_is_null(error, "cols"), error);
  FILE *file = dlsi_file_open(path, error);
  if (!file) return dlsi_at(__func__, DLS_E_FILE, error);
  layout form = {0};
  double *values = NULL;
  const dls_status status = read_matrix(file, &form, &values, error);
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

dls_status dls_mtx_write(const char *path, const dls_dense *A, dls_error *error) {
  if (!path) return dlsi_at(__func__, dlsi_is_null(error, "path"), error);
  if (!A) return dlsi_at(__func__, dlsi_is_null(error, "A"), error);
  if (A->rows < 1 || A->cols < 1)
    return dlsi_at(__func__,
                   dlsi_fail(error, DLS_E_SIZE, "A", -1, A->rows, "is %d x %d", A->rows, A->cols),
                   error);
  const dls_status status = dlsi_check_dense("A", A, A->rows, A->cols, error);
  if (status) return dlsi_at(__func__, status, error);
  FILE *file = fopen(path, "w");
  if (!file)
    return dlsi_at(__func__,
                   dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "cannot be opened for writing"),
                   error);
  (void)fprintf(file, "%%%%MatrixMarket matrix array real general\n%d %d\n", A->rows, A->cols);
  for (int j = 0; j < A->cols; j++)
    for (int i = 0; i < A->rows; i++)
      print_double(file, A->a[(size_t)i + (size_t)j * (size_t)A->ld]);
  return dlsi_at(__func__, dlsi_file_finish(path, file, error), error);
}
