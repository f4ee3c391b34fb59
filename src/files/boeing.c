/*
 * boeing.c: Harwell-Boeing files (Duff, Grimes, Lewis, Users' guide for the Harwell-Boeing sparse
 * matrix collection, 1992), which Ansys (HBMAT) and scipy.io.hb_write write:
 *
 *   title, key
 *   TOTCRD PTRCRD INDCRD VALCRD RHSCRD     lines of the parts
 *   MXTYPE NROW NCOL NNZERO NELTVL         R, C, P; S, U, H, Z, R; A, E
 *   PTRFMT INDFMT VALFMT RHSFMT            formats of Fortran, such as (16I5), (1P,4D20.12)
 *   [RHSTYP NRHS NRHSIX]                   where RHSCRD > 0
 *   column pointers, row indices, values   from 1; symmetric: the lower triangle
 */
#include <ctype.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "files/formats.h"

typedef struct cards {
  const char *next, *end;
  long long line;
} cards;

/* Returns the next line and its length without its end; NULL after the last one. */
static const char *next_card(cards *c, size_t *length) {
  if (c->next == c->end) return NULL;
  const char *begin = c->next, *stop = memchr(begin, '\n', (size_t)(c->end - begin));
  *length = (size_t)((stop ? stop : c->end) - begin);
  if (*length && begin[*length - 1] == '\r') --*length;
  c->next = stop ? stop + 1 : c->end;
  c->line++;
  return begin;
}

static dls_status boeing_wrong(const cards *c, const char *what, dls_error *error) {
  return dlsi_fail(error, DLS_E_FORMAT, "path", c->line, 0,
                   "line %lld of a Harwell-Boeing file: %s", c->line, what);
}

/* Reads up to `most` whole numbers between blanks; returns how many there are. */
static int read_wholes(const char *text, size_t length, int *value, int most) {
  int count = 0;
  for (const char *end = text + length; count < most; count++) {
    while (text < end && *text == ' ')
      text++;
    if (text == end || !dlsi_read_whole(&text, 0, INT_MAX, &value[count])) break;
  }
  return count;
}

/* Reads a format of Fortran: how many numbers a line holds, and their width. */
static int read_format(const char *text, size_t length, int *count, int *width) {
  for (size_t k = 0; k + 1 < length && text[k] != ')'; k++) {
    if (!strchr("IEDFGiedfg", text[k]) || !dlsi_is_digit(text[k + 1])) continue;
    size_t digits = k;
    while (digits > 0 && dlsi_is_digit(text[digits - 1]))
      digits--;
    const char *before = text + digits, *after = text + k + 1;
    *count = 1;
    if (digits < k && !dlsi_read_whole(&before, 1, 200, count)) return 0;
    return dlsi_read_whole(&after, 1, 64, width);
  }
  return 0;
}

/* Reads exactly `count` numbers between blanks; returns 0 if the line holds others. */
static int read_between_blanks(const char *line, size_t length, int count, double *x) {
  for (const char *end = line + length;; count--, x++) {
    while (line < end && *line == ' ')
      line++;
    if (line == end || count == 0) return line == end && count == 0;
    const char *blank = memchr(line, ' ', (size_t)(end - line)), *stop = blank ? blank : end;
    if (!dlsi_read_number(line, (size_t)(stop - line), x)) return 0;
    line = stop;
  }
}

static int read_field(const char *line, size_t length, size_t from, size_t width, double *x) {
  size_t to = from + width < length ? from + width : length;
  while (from < to && line[from] == ' ')
    from++;
  while (to > from && line[to - 1] == ' ')
    to--;
  return from < to && dlsi_read_number(line + from, to - from, x);
}

/* Reads n numbers in fields of a width, `count` a line. Values (real = 1) between blanks need not
 * keep to their fields: SciPy writes narrower ones than it says. */
static dls_status read_fields(cards *c, int n, int count, int width, int real, double *x,
                              dls_error *error) {
  for (int k = 0; k < n; k += count) {
    size_t length;
    const char *line = next_card(c, &length);
    if (!line) return boeing_wrong(c, "there are too few lines", error);
    const int here = n - k < count ? n - k : count;
    if (real && read_between_blanks(line, length, here, x + k)) continue;
    for (int f = 0; f < here; f++)
      if (!read_field(line, length, (size_t)(f * width), (size_t)width, &x[k + f]))
        return boeing_wrong(c, "a field holds no number", error);
  }
  return DLS_OK;
}

typedef struct boeing {
  char kind;
  int rows, cols, entries, rhs, count[3], width[3];
} boeing;

static dls_status read_head(cards *c, boeing *b, dls_error *error) {
  size_t length = 0;
  int lines[5] = {0}, size[4] = {0};
  (void)next_card(c, &length);
  const char *line = next_card(c, &length);
  if (!line || read_wholes(line, length, lines, 5) < 4)
    return boeing_wrong(c, "needs the numbers of lines", error);
  line = next_card(c, &length);
  if (!line || length < 4 || read_wholes(line + 3, length - 3, size, 4) < 3)
    return boeing_wrong(c, "needs rows, columns and entries", error);
  const char number = (char)toupper((unsigned char)line[0]),
             form = (char)toupper((unsigned char)line[2]);
  b->kind = (char)toupper((unsigned char)line[1]);
  b->rows = size[0];
  b->cols = size[1];
  b->entries = size[2];
  b->rhs = lines[4];
  if (number != 'R' || form != 'A' || !strchr("SUZR", b->kind))
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "path", c->line, 0,
                     "line %lld: only real, assembled matrices (RSA, RUA, RRA, RZA) are read",
                     c->line);
  if (b->rows < 1 || b->cols < 1 || b->cols == INT_MAX ||
      (strchr("SZ", b->kind) && b->rows != b->cols))
    return boeing_wrong(c, "has sizes that cannot be", error);
  line = next_card(c, &length);
  for (size_t k = 0; k < 3; k++) {
    const size_t at = 16 * k, width = k < 2 ? 16 : 20;
    if (!line || length <= at ||
        !read_format(line + at, length - at < width ? length - at : width, &b->count[k],
                     &b->width[k]))
      return boeing_wrong(c, "needs formats such as (16I5)", error);
  }
  if (b->rhs > 0) (void)next_card(c, &length);
  /* a claim of more than the file holds takes no memory */
  const size_t rest = (size_t)(c->end - c->next);
  if ((size_t)b->cols > rest || (size_t)b->entries > rest / 2)
    return boeing_wrong(c, "claims more numbers than the file has room for", error);
  return DLS_OK;
}

static dls_status take_entries(const cards *c, const boeing *b, const double *p, const double *i,
                               const double *x, dlsi_triplets *t, dls_error *error) {
  double at = 1;
  for (int j = 0; j < b->cols; j++) {
    if (p[j] != at || !(p[j + 1] >= at && p[j + 1] <= b->entries + 1.0) ||
        p[j + 1] != (int)p[j + 1])
      return boeing_wrong(c, "a pointer is out of order", error);
    for (; at < p[j + 1]; at++) {
      const size_t k = (size_t)at - 1;
      const int row = i[k] >= 1 && i[k] <= b->rows ? (int)i[k] - 1 : -1;
      if (row < 0 || (strchr("SZ", b->kind) && row < j))
        return boeing_wrong(c, "a row is out of range", error);
      dlsi_triplets_add(t, row, j, x[k]);
      if (strchr("SZ", b->kind) && row != j)
        dlsi_triplets_add(t, j, row, b->kind == 'S' ? x[k] : -x[k]);
    }
  }
  return at == b->entries + 1.0 ? DLS_OK
                                : boeing_wrong(c, "there are more entries than pointers", error);
}

dls_status dlsi_boeing_read(const dlsi_bytes *file, dlsi_triplets *t, int *symmetric,
                            dls_error *error) {
  cards c = {(const char *)file->at, (const char *)file->at + file->size, 0};
  boeing b = {0};
  dls_status status = read_head(&c, &b, error);
  if (status) return status;
  const size_t entries = (size_t)b.entries, heads = (size_t)b.cols + 1;
  double *p = dlsi_alloc(heads + 2 * entries, sizeof *p);
  if (!p) return dlsi_no_memory(error);
  double *i = p + heads, *x = i + entries;
  status = read_fields(&c, b.cols + 1, b.count[0], b.width[0], 0, p, error);
  if (!status) status = read_fields(&c, b.entries, b.count[1], b.width[1], 0, i, error);
  if (!status) status = read_fields(&c, b.entries, b.count[2], b.width[2], 1, x, error);
  if (!status) status = dlsi_triplets_alloc(b.rows, b.cols, 2 * entries, t, error);
  if (!status) status = take_entries(&c, &b, p, i, x, t, error);
  *symmetric = b.kind == 'S';
  free(p);
  return status;
}
