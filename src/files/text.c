/*
 * text.c: reads small problems as people write them: a line is a key and its text, a matrix follows
 * its key row by row. data/failures/README.md has the format.
 *
 * Numbers are decimals or fractions p/q, with a decimal point in every locale of the host. The file
 * is read in one piece; the lines point into it.
 */
#include <limits.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/files.h"
#include "files/file.h"

typedef struct text_line {
  char *key, *text; /* of a line that is not part of the problem */
} text_line;

struct dls_text {
  char *content; /* the file; a line ends in 0 after it has been read */
  int d, nc, n;  /* d = 0: an LCP of n unknowns; n = 0: not known yet */
  double *M, *q; /* n x n by columns; n */
  double *mu;    /* nc */
  const char *title;
  text_line *line;
  int lines, room;
};

/* The position while reading. */
typedef struct text_reader {
  dls_text *to;
  char *next;       /* after the line */
  long long number; /* of the line, from 1 */
  dls_error *error;
} text_reader;

static dls_status text_blame(const text_reader *reader, const char *word, const char *what) {
  return dlsi_fail(reader->error, DLS_E_FORMAT, "path", reader->number, 0, "line %lld, '%.20s': %s",
                   reader->number, word, what);
}

/* ---- words ----------------------------------------------------------------------------------- */

static int is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

static char *skip_blanks(char *text) {
  while (is_blank(*text))
    text++;
  return text;
}

/* Reads a decimal or a fraction of `length` characters; returns 0 for any other word. */
static int read_fraction(const char *word, size_t length, double *x) {
  const char *bar = memchr(word, '/', length);
  const size_t head = bar ? (size_t)(bar - word) : length;
  double below = 1;
  if (!dlsi_read_number(word, head, x)) return 0;
  if (bar && !dlsi_read_number(bar + 1, length - head - 1, &below)) return 0;
  *x /= below;
  return isfinite(*x);
}

int dlsi_text_numbers(const char *text, int count, double *x) {
  if (!text || (count > 0 && !x)) return 0;
  for (int i = 0;; i++) {
    while (is_blank(*text))
      text++;
    if (!*text) return i == count;
    size_t length = 0;
    while (text[length] && !is_blank(text[length]))
      length++;
    if (i == count || !read_fraction(text, length, x + i)) return 0;
    text += length;
  }
}

/* Cuts the next line out of the content; NULL at the end. */
static char *next_line(text_reader *reader) {
  char *line = reader->next;
  if (!*line) return NULL;
  char *end = strchr(line, '\n');
  reader->next = end ? end + 1 : line + strlen(line);
  if (end) *end = '\0';
  for (char *last = line + strlen(line); last > line && is_blank(last[-1]);)
    *--last = '\0';
  reader->number++;
  return line;
}

/* ---- lines ----------------------------------------------------------------------------------- */

static dls_status take_sizes(text_reader *reader, int contact, const char *key, const char *text) {
  dls_text *to = reader->to;
  double v[2] = {0, 0};
  if (to->n) return text_blame(reader, key, "stands there twice");
  if (!dlsi_text_numbers(text, contact ? 2 : 1, v)) return text_blame(reader, key, "needs sizes");
  const double d = contact ? v[0] : 0, count = v[contact], n = contact ? d * count : count;
  if (count != floor(count) || !(count >= 1 && n <= INT_MAX) ||
      (contact && d != 1 && d != 2 && d != 3))
    return text_blame(reader, key, contact ? "needs d = 1, 2 or 3 and nc >= 1" : "needs n >= 1");
  to->d = (int)d;
  to->nc = contact ? (int)count : 0;
  to->n = (int)n;
  return DLS_OK;
}

static dls_status take_vector(text_reader *reader, const char *key, const char *text, int count,
                              double **x) {
  if (!reader->to->n) return text_blame(reader, key, "stands before the sizes");
  if (*x) return text_blame(reader, key, "stands there twice");
  /* numbers have blanks between them: a claim of more takes no memory */
  if (count > 0 && (size_t)count - 1 > strlen(text) / 2)
    return text_blame(reader, key, "has too few numbers");
  *x = dlsi_alloc((size_t)count, sizeof **x);
  if (!*x) return dlsi_no_memory(reader->error);
  if (dlsi_text_numbers(text, count, *x)) return DLS_OK;
  return text_blame(reader, key, "has too few numbers, too many, or one that is none");
}

/* The matrix is the n lines after its key. */
static dls_status take_matrix(text_reader *reader, const char *key, const char *text) {
  dls_text *to = reader->to;
  const size_t n = (size_t)to->n;
  if (!n) return text_blame(reader, key, "stands before the sizes");
  if (to->M) return text_blame(reader, key, "stands there twice");
  if (*text) return text_blame(reader, text, "belongs under its key");
  if (n - 1 > strlen(reader->next) / 2 / n) return text_blame(reader, key, "has too few rows");
  double *row = dlsi_alloc(n, sizeof *row);
  to->M = dlsi_alloc(n * n, sizeof *to->M);
  dls_status status = row && to->M ? DLS_OK : dlsi_no_memory(reader->error);
  for (size_t i = 0; !status && i < n; i++) {
    const char *line = next_line(reader);
    if (!line)
      status = text_blame(reader, key, "has too few rows");
    else if (!dlsi_text_numbers(line, to->n, row))
      status = text_blame(reader, line, "has too few numbers, too many, or one that is none");
    for (size_t j = 0; !status && j < n; j++)
      to->M[i + j * n] = row[j];
  }
  free(row);
  return status;
}

static dls_status take_other(text_reader *reader, char *key, char *text) {
  dls_text *to = reader->to;
  if (to->lines == to->room) {
    const int room = 2 * to->room + 16;
    text_line *line = dlsi_alloc((size_t)room, sizeof *line);
    if (!line) return dlsi_no_memory(reader->error);
    if (to->lines) memcpy(line, to->line, (size_t)to->lines * sizeof *line);
    free(to->line);
    to->line = line;
    to->room = room;
  }
  to->line[to->lines++] = (text_line){key, text};
  if (!to->title && strcmp(key, "title") == 0) to->title = text;
  return DLS_OK;
}

static dls_status take_line(text_reader *reader, char *key) {
  dls_text *to = reader->to;
  size_t length = 0;
  while (key[length] && !is_blank(key[length]))
    length++;
  char *text = skip_blanks(key + length);
  key[length] = '\0';
  if (strcmp(key, "contact") == 0 || strcmp(key, "lcp") == 0)
    return take_sizes(reader, *key == 'c', key, text);
  if (strcmp(key, to->d ? "W" : "M") == 0) return take_matrix(reader, key, text);
  if (strcmp(key, "q") == 0) return take_vector(reader, key, text, to->n, &to->q);
  if (strcmp(key, "mu") == 0 && (to->d || !to->n))
    return take_vector(reader, key, text, to->nc, &to->mu);
  return take_other(reader, key, text);
}

/* ---- the file -------------------------------------------------------------------------------- */

static dls_status text_parse(dls_text *to, dls_error *error) {
  text_reader reader = {.to = to, .next = to->content, .error = error};
  for (char *line; (line = next_line(&reader));) {
    line = skip_blanks(line);
    if (!*line || *line == '#') continue;
    const dls_status status = take_line(&reader, line);
    if (status) return status;
  }
  const char *missing = !to->n             ? "contact or lcp"
                        : !to->M           ? (to->d ? "W" : "M")
                        : !to->q           ? "q"
                        : to->d && !to->mu ? "mu"
                                           : NULL;
  if (missing)
    return dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0, "is no problem in text: %s is missing",
                     missing);
  for (int c = 0; c < to->nc; c++)
    if (to->mu[c] < 0)
      return dlsi_fail(error, DLS_E_FORMAT, "path", -1, to->mu[c], "mu of candidate %d is negative",
                       c);
  return DLS_OK;
}

dls_status dls_text_read(dls_text **out, const char *path, dls_error *error) {
  DLSI_DOOR;
  if (!out) return dlsi_at(__func__, dlsi_is_null(error, "out"), error);
  *out = NULL;
  if (!path) return dlsi_at(__func__, dlsi_is_null(error, "path"), error);
  FILE *file = dlsi_file_open(path, error);
  if (!file) return dlsi_at(__func__, DLS_E_FILE, error);
  size_t size = 0;
  dls_text *text = dlsi_alloc(1, sizeof *text);
  dls_status status = text ? DLS_OK : dlsi_no_memory(error);
  if (text) {
    *text = (dls_text){.n = 0};
    status = dlsi_file_content(file, &text->content, &size, error);
    if (!status && strlen(text->content) != size)
      status = dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0, "is neither text nor an HDF5 file");
  }
  (void)fclose(file);
  if (!status) status = text_parse(text, error);
  if (status)
    dls_text_destroy(text);
  else
    *out = text;
  return dlsi_at(__func__, status, error);
}

void dls_text_destroy(dls_text *text) {
  if (!text) return;
  free(text->content);
  free(text->M);
  free(text->q);
  free(text->mu);
  free(text->line);
  free(text);
}

/* ---- contents -------------------------------------------------------------------------------- */

int dls_text_is_lcp(const dls_text *text) {
  return text && !text->d;
}

const char *dls_text_title(const dls_text *text) {
  return text && text->title ? text->title : "";
}

const char *dlsi_text_line(const dls_text *text, int k, const char **key) {
  if (!text || k < 0 || k >= text->lines) return NULL;
  if (key) *key = text->line[k].key;
  return text->line[k].text;
}

dls_status dls_text_contact(const dls_text *text, dls_contact *problem, dls_error *error) {
  DLSI_DOOR;
  dls_status status = !text      ? dlsi_is_null(error, "text")
                      : !problem ? dlsi_is_null(error, "problem")
                                 : DLS_OK;
  if (!status && !text->d) status = dlsi_fail(error, DLS_E_ARGUMENT, "text", -1, 0, "holds an LCP");
  if (status) return dlsi_at(__func__, status, error);
  const int m = text->n;
  *problem = (dls_contact){
      .d = text->d, .nc = text->nc, .W = {m, m, m, text->M}, .q = text->q, .mu = text->mu};
  return DLS_OK;
}

dls_status dls_text_lcp(const dls_text *text, int *n, const double **M, const double **q,
                        dls_error *error) {
  DLSI_DOOR;
  dls_status status = !text ? dlsi_is_null(error, "text")
                      : !n  ? dlsi_is_null(error, "n")
                      : !M  ? dlsi_is_null(error, "M")
                      : !q  ? dlsi_is_null(error, "q")
                            : DLS_OK;
  if (!status && text->d)
    status = dlsi_fail(error, DLS_E_ARGUMENT, "text", -1, 0, "holds a contact problem");
  if (status) return dlsi_at(__func__, status, error);
  *n = text->n;
  *M = text->M;
  *q = text->q;
  return DLS_OK;
}
