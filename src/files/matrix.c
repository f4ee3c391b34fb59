/*
 * matrix.c: reads matrices and tables in any format that is known, from text:
 *
 *   triplets   lines "row column value", from 0 if there is an index 0, else from 1
 *   Octave     save -text: "# type: sparse matrix", "# rows: 3", "# columns: 3", triplets from 1
 *   FreeFEM    "#  HashMatrix Matrix (COO)": rows columns entries half fortran .., triplets from
 *              `fortran`; "# Sparse Matrix (Morse)": rows columns half entries, triplets from 1
 *   Abaqus     *MATRIX OUTPUT, FORMAT=MATRIX INPUT: lines "node,direction, node,direction, value"
 *              of one or both triangles
 *
 * and from the binary formats of numpy.c and petsc.c and the fixed columns of boeing.c.
 */
#define _GNU_SOURCE
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "files/formats.h"

/* ---- the table of formats -------------------------------------------------------------------- */

/* A format by its first bytes. advice: what to do with one that is not read. */
typedef struct format_row {
  dlsi_format format;
  const char *name, *magic;
  size_t length; /* of magic */
  const char *advice;
} format_row;

#define MAGIC(text) text, sizeof text - 1
static const char mat_advice[] =
    "in MATLAB [i,j,x] = find(K); writematrix([i j x], 'K.txt'), and here --triplets";

/* The first that fits counts. */
static const format_row formats[] = {
    {DLSI_MTX, "a Matrix Market file", MAGIC("%%MatrixMarket"), NULL},
    {DLSI_NPY, "an array of NumPy", MAGIC("\x93NUMPY"), NULL},
    {DLSI_UNKNOWN, "a spreadsheet", MAGIC("PK\3\4\x14\0\6\0"), "export it as CSV"},
    {DLSI_NPZ, "a zip file of NumPy", MAGIC("PK\3\4"), NULL},
    {DLSI_PETSC, "a binary file of PETSc", MAGIC("\0\x12\x7b\x50"), NULL},
    {DLSI_PETSC, "a binary file of PETSc", MAGIC("\0\x12\x7b\x4e"), NULL},
    {DLSI_PETSC, "a binary file of PETSc", MAGIC("\0\0\0\0\0\x12\x7b\x50"), NULL},
    {DLSI_PETSC, "a binary file of PETSc", MAGIC("\0\0\0\0\0\x12\x7b\x4e"), NULL},
    {DLSI_FREEFEM, "a matrix of FreeFEM", MAGIC("#  HashMatrix"), NULL},
    {DLSI_FREEFEM, "a matrix of FreeFEM", MAGIC("# Sparse Matrix (Morse)"), NULL},
    {DLSI_UNKNOWN, "a MATLAB file (.mat)", MAGIC("MATLAB 5.0 MAT-file"), mat_advice},
    {DLSI_UNKNOWN, "a MATLAB file (.mat)", MAGIC("MATLAB 7.3 MAT-file"), mat_advice},
    {DLSI_UNKNOWN, "a binary file of Octave", MAGIC("Octave-1-"), "save it with save -text"},
    {DLSI_UNKNOWN, "an HDF5 file, no matrix", MAGIC("\x89HDF\r\n\x1a\n"),
     "a problem of FCLIB goes as delassus solve FILE"},
    {DLSI_UNKNOWN, "a gzip file", MAGIC("\x1f\x8b"), "gunzip it first"},
    {DLSI_UNKNOWN, "a pickle of Python", MAGIC("\x80\4\x95"),
     "write a sparse matrix by scipy.sparse.save_npz, an array by numpy.save"},
    {DLSI_UNKNOWN, "a matrix of Nastran (DMIG)", MAGIC("DMIG"),
     "write lines 'row column value', unknowns counted from 1, and use --triplets"},
    {DLSI_UNKNOWN, "a file of VTK or another XML", MAGIC("<?xml"), "K is needed, no mesh"},
    {DLSI_UNKNOWN, "a file of VTK or another XML", MAGIC("<VTK"), "K is needed, no mesh"},
};
static const char *const other_names[] = {[DLSI_UNKNOWN] = "a file",
                                          [DLSI_BOEING] = "a Harwell-Boeing file",
                                          [DLSI_OCTAVE] = "a matrix of Octave",
                                          [DLSI_ABAQUS] = "a matrix of Abaqus",
                                          [DLSI_CALCULIX] = "a matrix of CalculiX",
                                          [DLSI_TEXT] = "a table of numbers"};
enum { format_count = sizeof formats / sizeof *formats, first_bytes = 1024 };

const char *dlsi_format_name(dlsi_format format) {
  for (int k = 0; k < format_count && format; k++)
    if (formats[k].format == format) return formats[k].name;
  return other_names[format];
}

/* Returns line k = 0, 1, .. of a text that ends in 0; NULL beyond it. */
static const char *line_of(const char *text, int k) {
  for (; text && k > 0; k--) {
    text = strchr(text, '\n');
    text = text ? text + 1 : NULL;
  }
  return text;
}

/* Returns 1 for line 3 of a Harwell-Boeing file: a type such as RSA, blanks, sizes. */
static int is_boeing(const char *text) {
  const char *type = line_of(text, 2);
  return type && strlen(type) > 14 && strchr("RCPrcp", type[0]) && strchr("SUHZRsuhzr", type[1]) &&
         strchr("AEae", type[2]) && strspn(type + 3, " ") >= 8;
}

/* Returns 1 for node,direction, node,direction, value on the diagonal, past lines that begin with
 * an asterisk. */
static int is_abaqus(const char *text) {
  int label[4];
  while (text && *text == '*')
    text = line_of(text, 1);
  for (int k = 0; text && k < 4; k++) {
    text += strspn(text, " ");
    if (*text == '-' && k % 2 == 0) text++; /* Abaqus's own nodes */
    if (!dlsi_read_whole(&text, 1, INT_MAX, &label[k])) return 0;
    text += strspn(text, " ");
    if (*text++ != ',') return 0;
  }
  return text && label[0] == label[2] && label[1] == label[3];
}

static int ends_in(const char *path, const char *end) {
  const size_t length = strlen(path), tail = strlen(end);
  return length > tail && strcmp(path + length - tail, end) == 0;
}

static dls_status find_in_bytes(const char *first, size_t got, dlsi_format *format,
                                dls_error *error) {
  for (int k = 0; k < format_count; k++) {
    const format_row *row = &formats[k];
    if (got < row->length || (row->format == DLSI_MTX ? strncasecmp(first, row->magic, row->length)
                                                      : memcmp(first, row->magic, row->length)))
      continue;
    *format = row->format;
    if (!row->advice) return DLS_OK;
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "path", -1, 0, "this is %s: %s", row->name,
                     row->advice);
  }
  const char *type = strstr(first, "# type: ");
  *format = *first == '#' && type && strncmp(type + 8, "sparse matrix", 13) == 0 ? DLSI_OCTAVE
            : is_boeing(first)                                                   ? DLSI_BOEING
            : is_abaqus(first)                                                   ? DLSI_ABAQUS
                                                                                 : DLSI_TEXT;
  return DLS_OK;
}

dls_status dlsi_format_find(const char *path, dlsi_format *format, dls_error *error) {
  char first[first_bytes + 1] = {0};
  *format = DLSI_UNKNOWN;
  FILE *file = dlsi_file_open(path, error);
  if (!file) return DLS_E_FILE;
  const size_t got = fread(first, 1, first_bytes, file);
  (void)fclose(file);
  if (ends_in(path, ".sti") || ends_in(path, ".mas")) {
    *format = DLSI_CALCULIX;
    return DLS_OK;
  }
  return find_in_bytes(first, got, format, error);
}

/* ---- numbers in text ------------------------------------------------------------------------- */

/* The words of a text that ends in 0: numbers between blanks, commas or semicolons. # and % begin a
 * comment, an asterisk at the start of a line, too. */
typedef struct words {
  const char *next, *word, *begin;
  size_t length;
  long long line; /* of the word, from 1 */
  dls_error *error;
} words;

static int is_separator(int c) {
  return c == ' ' || c == '\t' || c == '\r' || c == ',' || c == ';';
}

/* Takes the next word of this line; returns 0 at its end. */
static int take_word(words *w) {
  while (is_separator(*w->next))
    w->next++;
  w->word = w->next;
  if (*w->next == '#' || *w->next == '%' || (*w->next == '*' && w->next == w->begin))
    w->next = strchrnul(w->next, '\n');
  else
    while (*w->next && *w->next != '\n' && !is_separator(*w->next))
      w->next++;
  w->length = (size_t)(w->next - w->word);
  return w->length > 0 && *w->word != '#' && *w->word != '%' &&
         !(*w->word == '*' && w->word == w->begin);
}

/* Goes to the next line; returns 0 at the end of the text. */
static int take_line(words *w) {
  if (w->line > 0) {
    w->next = strchrnul(w->next, '\n');
    if (*w->next) w->next++;
  }
  w->begin = w->next;
  w->line++;
  return *w->next != '\0';
}

static dls_status blame_word(const words *w, const char *what) {
  const int length = w->length < 20 ? (int)w->length : 20;
  return dlsi_fail(w->error, DLS_E_FORMAT, "path", w->line, 0, "line %lld, '%.*s': %s", w->line,
                   length, w->length ? w->word : "end of line", what);
}

/* Counts words of this line in which one comma stands between digits, as in 0,5; -1 if another word
 * is there, a point, or a semicolon: *semicolon := 1. */
static int count_commas(const char *text, int *semicolon) {
  int count = 0;
  *semicolon = 0;
  while (*text && !strchr("\n#%", *text)) {
    const size_t blank = strspn(text, " \t\r;"), length = strcspn(text + blank, " \t\r;\n#%");
    *semicolon |= memchr(text, ';', blank) != NULL;
    const char *word = text + blank, *comma = memchr(word, ',', length);
    if (length) {
      const int between = comma && comma > word && dlsi_is_digit(comma[-1]) &&
                          dlsi_is_digit(comma[1]) && comma + 1 < word + length;
      if (!between || memchr(comma + 1, ',', (size_t)(word + length - comma - 1)) ||
          memchr(word, '.', length))
        return -1;
      count++;
    }
    text = word + length;
  }
  return count;
}

/* Reads a number, or inf, which a friction may be. */
static int read_value(const words *w, double *x) {
  const size_t sign = *w->word == '+' || *w->word == '-';
  if (dlsi_read_number(w->word, w->length, x)) return 1;
  if (w->length != 3 + sign || strncasecmp(w->word + sign, "inf", 3) != 0) return 0;
  *x = *w->word == '-' ? -INFINITY : INFINITY;
  return 1;
}

/* A growing array of doubles. */
typedef struct numbers {
  double *x;
  size_t count, room;
} numbers;

static dls_status add_number(numbers *to, double x, dls_error *error) {
  if (to->count == to->room) {
    const size_t room = 2 * to->room + 256;
    double *more = room > SIZE_MAX / 4 / sizeof *more ? NULL : dlsi_alloc(room, sizeof *more);
    if (!more) return dlsi_no_memory(error);
    if (to->count) memcpy(more, to->x, to->count * sizeof *more);
    free(to->x);
    to->x = more;
    to->room = room;
  }
  to->x[to->count++] = x;
  return DLS_OK;
}

/* Adds the numbers of this line; *cols: how many. */
static dls_status take_numbers(words *w, numbers *to, int *cols, int *commas) {
  int semicolon;
  const int count = count_commas(w->next, &semicolon);
  if (count > 1 || (count == 1 && semicolon)) {
    w->word = w->next;
    w->length = strcspn(w->next, "\n");
    return blame_word(w, "has decimal commas; numbers have a point");
  }
  *commas &= count == 1;
  for (*cols = 0; take_word(w); ++*cols) {
    double x = 0;
    if (!read_value(w, &x)) return blame_word(w, "is no number");
    const dls_status status = add_number(to, x, w->error);
    if (status) return status;
  }
  return DLS_OK;
}

/* Reads rows of numbers. Rows of all lengths behind a line with their number are a vector of
 * FreeFEM. */
static dls_status text_table(words *w, dlsi_table *t) {
  numbers all = {0};
  long long uneven = 0;
  int first = 0, other = 0;
  dls_status status = DLS_OK;
  t->commas = 1;
  while (!status && take_line(w)) {
    int cols = 0;
    status = take_numbers(w, &all, &cols, &t->commas);
    if (status || cols == 0) continue;
    if (t->rows++ == 0) t->cols = first = cols;
    if (cols != first && !uneven) {
      uneven = w->line;
      other = cols;
    }
  }
  t->a = all.x;
  if (status) return status;
  if (!all.count) return dlsi_fail(w->error, DLS_E_FORMAT, "path", -1, 0, "holds no number");
  if (all.count > INT_MAX)
    return dlsi_fail(w->error, DLS_E_SIZE, "path", -1, 0, "holds too many numbers");
  if (uneven && first == 1 && all.x[0] == (double)(all.count - 1)) {
    memmove(all.x, all.x + 1, (all.count - 1) * sizeof *all.x);
    t->rows = (int)all.count - 1;
  } else if (uneven)
    return dlsi_fail(w->error, DLS_E_FORMAT, "path", uneven, 0,
                     "line %lld has %d number%s, those before have %d", uneven, other,
                     other == 1 ? "" : "s", first);
  return DLS_OK;
}

/* ---- triplets in text ------------------------------------------------------------------------ */

/* How lines are meant. base: of the indices, -1: 0 if there is one, else 1. */
typedef struct meaning {
  int rows, cols; /* 0: the largest index */
  int base, half, labels;
  size_t entries; /* SIZE_MAX: as many as there are */
} meaning;

static int is_whole(double x, double least) {
  return x >= least && x < INT_MAX && x == (int)x;
}

/* Takes the numbers behind the first comment lines of FreeFEM or Octave into m. */
static dls_status take_head(words *w, dlsi_format format, meaning *m) {
  const char *rows = strstr(w->next, "# rows: "), *cols = strstr(w->next, "# columns: ");
  if (format == DLSI_OCTAVE) {
    const char *name = strstr(w->next, "# name: ");
    if (rows) rows += 8;
    if (cols) cols += 11;
    if (!rows || !cols || !dlsi_read_whole(&rows, 1, INT_MAX, &m->rows) ||
        !dlsi_read_whole(&cols, 1, INT_MAX, &m->cols))
      return blame_word(w, "is a matrix of Octave without its rows and columns");
    if (name && strstr(name + 1, "# name: "))
      return dlsi_fail(w->error, DLS_E_UNSUPPORTED, "path", -1, 0,
                       "holds several variables of Octave: save -text K.txt K");
    m->base = 1;
    return DLS_OK;
  }
  const int morse = strncmp(w->next, "# Sparse", 8) == 0;
  numbers head = {0};
  int count = 0, commas = 0;
  dls_status status = DLS_OK;
  while (!status && !count && take_line(w))
    status = take_numbers(w, &head, &count, &commas);
  int good = !status && count >= 4;
  for (int k = 0; good && k < (morse ? 4 : 5) && k < count; k++)
    good = is_whole(head.x[k], k < 2);
  if (good) {
    m->rows = (int)head.x[0];
    m->cols = (int)head.x[1];
    m->entries = (size_t)head.x[morse ? 3 : 2];
    m->half = head.x[morse ? 2 : 3] != 0;
    m->base = morse || (count > 4 && head.x[4] != 0);
  }
  free(head.x);
  return good || status ? status : blame_word(w, "is no first line of a matrix of FreeFEM");
}

/* Compares node, direction of two unknowns. */
static int by_label(const void *a, const void *b) {
  const double *x = a, *y = b;
  if (x[0] != y[0]) return x[0] < y[0] ? -1 : 1;
  return (x[1] > y[1]) - (x[1] < y[1]);
}

/* Makes rows (row, column, value) of rows (node, direction, node, direction, value), in place.
 * *label: new, n rows (node, direction), sorted; unknown k is that of row k. */
static dls_status number_labels(numbers *all, double **label, int *n, dls_error *error) {
  const size_t rows = all->count / 5;
  double *sorted = dlsi_alloc(4 * rows, sizeof *sorted);
  if (!sorted) return dlsi_no_memory(error);
  for (size_t k = 0; k < rows; k++)
    memcpy(sorted + 4 * k, all->x + 5 * k, 4 * sizeof *sorted);
  qsort(sorted, 2 * rows, 2 * sizeof *sorted, by_label);
  size_t count = 1; /* of different ones, in front */
  for (size_t k = 1; k < 2 * rows; k++)
    if (by_label(sorted + 2 * k, sorted + 2 * count - 2) != 0)
      memmove(sorted + 2 * count++, sorted + 2 * k, 2 * sizeof *sorted);
  for (size_t k = 0; k < rows; k++) {
    const double *from = all->x + 5 * k;
    double to[3] = {0, 0, from[4]};
    for (int side = 0; side < 2; side++) {
      const double *place = bsearch(from + 2 * side, sorted, count, 2 * sizeof *sorted, by_label);
      to[side] = (double)((place ? place - sorted : 0) / 2);
    }
    memcpy(all->x + 3 * k, to, sizeof to);
  }
  all->count = 3 * rows;
  *label = sorted;
  *n = (int)count;
  return DLS_OK;
}

/* Turns rows (row, column, value) into triplets. */
static dls_status fill_triplets(const numbers *all, meaning *m, dlsi_triplets *t,
                                dls_error *error) {
  const size_t count = all->count / 3;
  double least = INFINITY, most[2] = {0, 0};
  int below = 0, above = 0;
  for (size_t k = 0; k < count; k++)
    for (int side = 0; side < 2; side++) {
      const double index = all->x[3 * k + (size_t)side];
      if (!is_whole(index, 0))
        return dlsi_fail(error, DLS_E_FORMAT, "path", -1, index, "entry %zu: %g is no index", k + 1,
                         index);
      least = index < least ? index : least;
      most[side] = index > most[side] ? index : most[side];
    }
  if (m->base < 0) m->base = least > 0;
  if (!m->rows) m->rows = (int)most[0] + !m->base;
  if (!m->cols) m->cols = (int)most[1] + !m->base;
  const double size = m->rows > m->cols ? m->rows : m->cols;
  if (most[0] - m->base >= m->rows || most[1] - m->base >= m->cols || least < m->base)
    return dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0, "an index is beyond %d x %d", m->rows,
                     m->cols);
  if (size > (1 << 22) && (double)count < size)
    return dlsi_fail(error, DLS_E_SIZE, "path", -1, 0, "has too few entries for its size");
  if (m->entries != SIZE_MAX && m->entries != count)
    return dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0, "holds %zu entries, not %zu", count,
                     m->entries);
  const dls_status status = dlsi_triplets_alloc(m->rows, m->cols, 2 * count, t, error);
  if (status) return status;
  for (size_t k = 0; k < count; k++) {
    const int i = (int)all->x[3 * k] - m->base, j = (int)all->x[3 * k + 1] - m->base;
    below |= i > j;
    above |= i < j;
    dlsi_triplets_add(t, i, j, all->x[3 * k + 2]);
  }
  m->half = m->half || (m->labels && below != above);
  for (size_t k = 0; m->half && k < count; k++)
    if (t->row[k] != t->col[k]) dlsi_triplets_add(t, t->col[k], t->row[k], t->x[k]);
  return DLS_OK;
}

/* Reads the lines of triplets in text; *label (or NULL): new, for Abaqus. */
static dls_status text_triplets(words *w, dlsi_format format, dlsi_triplets *t, int *symmetric,
                                double **label) {
  meaning m = {.base = -1, .labels = format == DLSI_ABAQUS, .entries = SIZE_MAX};
  numbers all = {0};
  int commas = 0, n = 0;
  const int wanted = m.labels ? 5 : 3;
  dls_status status = DLS_OK;
  if (format == DLSI_OCTAVE || format == DLSI_FREEFEM) status = take_head(w, format, &m);
  while (!status && take_line(w)) {
    int cols = 0;
    status = take_numbers(w, &all, &cols, &commas);
    if (!status && cols && cols != wanted) {
      w->length = 0;
      status = blame_word(w, m.labels ? "is no 'node,direction, node,direction, value'"
                                      : "is no 'row column value'");
    }
  }
  if (!status && !all.count)
    status = dlsi_fail(w->error, DLS_E_FORMAT, "path", -1, 0, "holds no entry");
  if (!status && m.labels) status = number_labels(&all, label, &n, w->error);
  if (!status && m.labels) {
    m.rows = m.cols = n;
    m.base = 0;
  }
  if (!status) status = fill_triplets(&all, &m, t, w->error);
  *symmetric = m.half;
  free(all.x);
  return status;
}

/* ---- files ----------------------------------------------------------------------------------- */

/* Reads all of a file, which ends in 0. Free *content after an error, too. */
static dls_status read_bytes(const char *path, char **content, dlsi_bytes *bytes,
                             dls_error *error) {
  FILE *file = dlsi_file_open(path, error);
  if (!file) return DLS_E_FILE;
  size_t size = 0;
  const dls_status status = dlsi_file_content(file, content, &size, error);
  (void)fclose(file);
  *bytes = (dlsi_bytes){(unsigned char *)*content, size};
  return status;
}

static dls_status check_text(const dlsi_bytes *bytes, dls_error *error) {
  if (strlen((const char *)bytes->at) == bytes->size) return DLS_OK;
  return dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0,
                   "is neither text nor in a binary format that is known");
}

static dls_status read_table_bytes(const dlsi_bytes *bytes, dlsi_format format, dlsi_table *t,
                                   dls_error *error) {
  if (format == DLSI_NPY) return dlsi_npy_read(bytes, t, error);
  if (format == DLSI_PETSC) return dlsi_petsc_vector(bytes, t, error);
  const dls_status status = check_text(bytes, error);
  words w = {.next = (const char *)bytes->at, .error = error};
  return status ? status : text_table(&w, t);
}

static dls_status mtx_table(const char *path, dlsi_table *t, dls_error *error) {
  double *x = NULL;
  dls_status status = dls_mtx_read(path, &t->rows, &t->cols, &x, error);
  if (status) return status;
  const size_t rows = (size_t)t->rows, cols = (size_t)t->cols;
  t->a = dlsi_alloc(rows * cols, sizeof *t->a);
  for (size_t e = 0; t->a && e < rows * cols; e++)
    t->a[e] = x[e / cols + e % cols * rows];
  dls_mtx_free(x);
  return t->a ? DLS_OK : dlsi_no_memory(error);
}

dls_status dlsi_table_read(const char *path, dlsi_table *t, dls_error *error) {
  *t = (dlsi_table){0};
  dlsi_format format;
  dls_status status = dlsi_format_find(path, &format, error);
  if (status) return status;
  if (format == DLSI_MTX) return mtx_table(path, t, error);
  if (format != DLSI_NPY && format != DLSI_PETSC && format != DLSI_TEXT)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "path", -1, 0,
                     "this is %s: a sparse matrix, no vector", dlsi_format_name(format));
  char *content = NULL;
  dlsi_bytes bytes;
  status = read_bytes(path, &content, &bytes, error);
  if (!status) status = read_table_bytes(&bytes, format, t, error);
  if (!status && t->rows < 1)
    status = dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0, "holds no number");
  free(content);
  return status;
}

/* Turns the numbers of a table that are not 0 into triplets. */
static dls_status triplets_of_table(const dlsi_table *table, dlsi_triplets *t, dls_error *error) {
  const size_t cols = (size_t)table->cols, size = (size_t)table->rows * cols;
  size_t count = 0;
  for (size_t e = 0; e < size; e++)
    count += table->a[e] != 0;
  const dls_status status = dlsi_triplets_alloc(table->rows, table->cols, count, t, error);
  for (size_t e = 0; !status && e < size; e++)
    if (table->a[e] != 0) dlsi_triplets_add(t, (int)(e / cols), (int)(e % cols), table->a[e]);
  return status;
}

static dls_status read_triplets_of(const dlsi_bytes *bytes, dlsi_format format, int triplets,
                                   dlsi_triplets *t, int *symmetric, double **label,
                                   dls_error *error) {
  if (format == DLSI_NPZ) return dlsi_npz_read(bytes, t, error);
  if (format == DLSI_PETSC) return dlsi_petsc_read(bytes, t, error);
  if (format == DLSI_BOEING) return dlsi_boeing_read(bytes, t, symmetric, error);
  if (format == DLSI_NPY || (format == DLSI_TEXT && !triplets)) {
    dlsi_table table = {0};
    dls_status status = read_table_bytes(bytes, format, &table, error);
    if (!status && table.rows < 1)
      status = dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0, "holds no number");
    if (!status) status = triplets_of_table(&table, t, error);
    free(table.a);
    return status;
  }
  const dls_status status = check_text(bytes, error);
  words w = {.next = (const char *)bytes->at, .error = error};
  return status ? status : text_triplets(&w, format, t, symmetric, label);
}

static dls_status read_matrix(const char *path, int triplets, dls_sparse *A, int *symmetric,
                              int **labels, dls_error *error) {
  if (!path) return dlsi_is_null(error, "path");
  if (!A) return dlsi_is_null(error, "A");
  dlsi_format format;
  dlsi_triplets t = {0};
  dlsi_bytes bytes = {0};
  char *content = NULL;
  double *label = NULL;
  int is_symmetric = 0, *made_labels = NULL;
  dls_sparse made = {0};
  dls_status status = dlsi_format_find(path, &format, error);
  if (status) return status;
  if (format == DLSI_MTX || format == DLSI_CALCULIX)
    status = dlsi_mtx_read_file(path, format == DLSI_CALCULIX, &t, &is_symmetric, error);
  else
    status = read_bytes(path, &content, &bytes, error);
  if (!status && content)
    status = read_triplets_of(&bytes, format, triplets, &t, &is_symmetric, &label, error);
  free(content);
  if (!status) {
    const long long bad = dlsi_first_not_finite(t.x, (size_t)t.count);
    if (bad >= 0)
      status = dlsi_fail(error, DLS_E_FORMAT, "path", -1, t.x[bad], "entry (%d, %d) is not finite",
                         t.row[bad] + 1, t.col[bad] + 1);
  }
  const size_t n = (size_t)(t.rows > 0 ? t.rows : 1);
  if (!status && label && labels && !(made_labels = dlsi_alloc(2 * n, sizeof *made_labels)))
    status = dlsi_no_memory(error);
  for (size_t k = 0; made_labels && k < 2 * n; k++)
    made_labels[k] = (int)label[k];
  free(label);
  if (!status) status = dlsi_mtx_columns(&t, &made, error);
  dlsi_triplets_free(&t);
  if (status) {
    free(made_labels);
    return status;
  }
  *A = made;
  if (symmetric) *symmetric = is_symmetric;
  if (labels) *labels = made_labels;
  return DLS_OK;
}

dls_status dls_matrix_read(const char *path, int triplets, dls_sparse *A, int *symmetric,
                           int **labels, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, read_matrix(path, triplets, A, symmetric, labels, error), error);
}

void dls_matrix_free_labels(int *labels) {
  free(labels);
}
