/*
 * fclib.c: contact problems as FCLIB files (Acary, Bremond, Koziara, Perignon, "FCLIB: a collection
 * of discrete 3D frictional contact problems", INRIA RT-0444, 2014), in HDF5.
 *
 *   fclib_local/   W, vectors/q, vectors/mu, spacedim, info/title            u = W r + q
 *   fclib_global/  M, H, vectors/f, w, mu, spacedim, info/title   M v = H r + f,  u = H^T v + w
 *   solution/      v, r, u
 *
 * A matrix is a group m, n, nz, nzmax, p, i, x, as in CSparse:
 *   nz = -1  compressed columns: those of column j stand at p[j] <= k < p[j+1], rows i[k]
 *   nz = -2  compressed rows: the same, transposed
 *   nz >= 0  nz triplets, row i[k], column p[k]
 * i and x may be longer than what is used. Entries of the same place add up. Bilateral constraints
 * (V, R, s of a local problem, G, b of a global one) are not read. A file that holds both problems
 * is read as the local one, which is the same condensed.
 *
 * A file is not to be trusted: sizes are checked against each other and against the extents of the
 * data sets before memory is taken, indices and values before they are used. HDF5 prints its
 * errors unless told not to; H5E_BEGIN_TRY silences it and gives the host its handler back.
 */
#include "delassus/files.h"
#include "file.h"

#ifdef DLS_WITH_HDF5

#include <hdf5.h>
#include <limits.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* compressed columns that own their arrays */
typedef struct columns {
  int rows, cols;
  int *p, *i;
  double *x;
} columns;

/* compressed columns of d x d blocks, likewise */
typedef struct block_columns {
  int *p, *i;
  double *x;
} block_columns;

struct dls_fclib {
  int global, d, nc, n;
  char *title;
  block_columns W;   /* local */
  columns M, HN, HT; /* global */
  double *f;         /* global: n */
  double *q, *mu;    /* q: d nc, the w of a global problem; mu: nc */
  double *r, *u;     /* d nc, or NULL */
};

static void free_columns(columns *A) {
  free(A->p);
  free(A->i);
  free(A->x);
}

static dls_status no_memory(const char *function, dls_error *error) {
  (void)dlsi_fail(error, DLS_E_MEMORY, function, "", -1, 0, "out of memory");
  return DLS_E_MEMORY;
}

static dls_status alloc_columns(const char *function, int rows, int cols, int entries, columns *A,
                                dls_error *error) {
  A->rows = rows;
  A->cols = cols;
  A->p = dlsi_alloc((size_t)cols + 1, sizeof *A->p);
  A->i = dlsi_alloc((size_t)entries, sizeof *A->i);
  A->x = dlsi_alloc((size_t)entries, sizeof *A->x);
  return A->p && A->i && A->x ? DLS_OK : no_memory(function, error);
}

/* ---- data sets ------------------------------------------------------------------------------- */

static const char reading[] = "dls_fclib_read";

typedef struct source {
  hid_t group; /* the names of data sets start here */
  dls_error *error;
} source;

static dls_status bad(const source *s, const char *name, long long index, double value,
                      const char *format, ...) DLSI_PRINTF(5, 6);

static dls_status bad(const source *s, const char *name, long long index, double value,
                      const char *format, ...) {
  char text[120];
  va_list args;
  va_start(args, format);
  if (vsnprintf(text, sizeof text, format, args) < 0) text[0] = '\0';
  va_end(args);
  (void)dlsi_fail(s->error, DLS_E_FORMAT, reading, name, index, value, "%s", text);
  return DLS_E_FORMAT;
}

/* Space and type of a data set that is to give `count` numbers, more if `longer`. */
static dls_status check_set(const source *s, const char *name, hid_t set, hid_t space, hid_t type,
                            size_t count, int longer) {
  const hid_t stored = H5Dget_type(set);
  const H5T_class_t kind = stored < 0 ? H5T_NO_CLASS : H5Tget_class(stored);
  if (stored >= 0) (void)H5Tclose(stored);
  if (kind != H5T_INTEGER && (kind != H5T_FLOAT || H5Tget_class(type) != H5T_FLOAT))
    return bad(s, name, -1, 0, "has the wrong type");
  const hssize_t held = H5Sget_simple_extent_npoints(space);
  if (held < 0 || (size_t)held < count || ((size_t)held > count && !longer))
    return bad(s, name, -1, (double)held, "holds %lld values, must hold %s%zu", (long long)held,
               longer ? "at least " : "", count);
  if ((size_t)held > count && H5Sget_simple_extent_ndims(space) != 1)
    return bad(s, name, -1, 0, "must have one dimension");
  if (count && H5Dget_storage_size(set) == 0) return bad(s, name, -1, 0, "was never written");
  return DLS_OK;
}

/* x := the first `count` values of the data set, converted to `type` */
static herr_t read_values(hid_t set, hid_t space, hid_t type, size_t count, void *x) {
  if (!count) return 0;
  const hsize_t start = 0, n = count;
  if (H5Sget_simple_extent_npoints(space) == (hssize_t)count)
    return H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, x);
  const hid_t memory = H5Screate_simple(1, &n, NULL);
  if (memory < 0) return -1;
  herr_t done = H5Sselect_hyperslab(space, H5S_SELECT_SET, &start, NULL, &n, NULL);
  if (done >= 0) done = H5Dread(set, type, memory, space, H5P_DEFAULT, x);
  (void)H5Sclose(memory);
  return done;
}

/* *out = a new array of `count` numbers of `type` from data set `name`, NULL on error. Integers that do not fit
 * an int arrive as INT_MAX, which no check lets pass. */
static dls_status read_set(const source *s, const char *name, hid_t type, size_t count, int longer,
                           void **out) {
  *out = NULL;
  const hid_t set = H5Dopen2(s->group, name, H5P_DEFAULT);
  if (set < 0) return bad(s, name, -1, 0, "no such data set");
  const hid_t space = H5Dget_space(set);
  dls_status status = check_set(s, name, set, space, type, count, longer);
  void *x = NULL;
  if (!status) {
    x = dlsi_alloc(count, H5Tget_size(type));
    if (!x) status = no_memory(reading, s->error);
  }
  if (!status && read_values(set, space, type, count, x) < 0)
    status = bad(s, name, -1, 0, "cannot be read");
  if (space >= 0) (void)H5Sclose(space);
  (void)H5Dclose(set);
  if (status)
    free(x);
  else
    *out = x;
  return status;
}

static dls_status read_int(const source *s, const char *name, int least, int *value) {
  void *x;
  const dls_status status = read_set(s, name, H5T_NATIVE_INT, 1, 0, &x);
  if (!x) return status;
  const int v = *(int *)x;
  free(x);
  if (v < least || v == INT_MAX) return bad(s, name, -1, v, "is %d", v);
  *value = v;
  return DLS_OK;
}

/* *out = `count` indices, each in 0 .. bound-1 */
static dls_status read_indices(const source *s, const char *name, int count, int bound, int **out) {
  void *x;
  const dls_status status = read_set(s, name, H5T_NATIVE_INT, (size_t)count, 1, &x);
  if (!x) return status;
  *out = x;
  for (int k = 0; k < count; k++)
    if ((*out)[k] < 0 || (*out)[k] >= bound)
      return bad(s, name, k, (*out)[k], "is %d, must be in 0 .. %d", (*out)[k], bound - 1);
  return DLS_OK;
}

static dls_status read_doubles(const source *s, const char *name, size_t count, int longer,
                               double **out) {
  void *x;
  const dls_status status = read_set(s, name, H5T_NATIVE_DOUBLE, count, longer, &x);
  if (!x) return status;
  *out = x;
  const long long k = dlsi_first_not_finite(*out, count);
  if (k >= 0) return bad(s, name, k, (*out)[k], "is not finite");
  return DLS_OK;
}

/* ---- matrices -------------------------------------------------------------------------------- */

typedef struct matrix_names {
  const char *m, *n, *nz, *nzmax, *p, *i, *x;
} matrix_names;

#define MATRIX(a)                                                                                  \
  { a "/m", a "/n", a "/nz", a "/nzmax", a "/p", a "/i", a "/x" }
static const matrix_names names_W = MATRIX("W"), names_M = MATRIX("M"), names_H = MATRIX("H");

/* triplets, in the order of the file */
typedef struct triplets {
  int rows, cols, count;
  int *row, *col;
  double *x;
} triplets;

static void free_triplets(triplets *t) {
  free(t->row);
  free(t->col);
  free(t->x);
}

/* *p (lines + 1): where the compressed lines begin */
static dls_status read_lines(const source *s, const char *name, int lines, int nzmax, int **p) {
  const dls_status status = read_indices(s, name, lines + 1, nzmax + 1, p);
  if (status) return status;
  // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): status 0 vouches for it
  if ((*p)[0] != 0) return bad(s, name, 0, (*p)[0], "must be 0");
  for (int j = 0; j < lines; j++)
    if ((*p)[j + 1] < (*p)[j])
      return bad(s, name, j + 1, (*p)[j + 1], "is less than the one before it");
  return DLS_OK;
}

/* *minor, *major := position within the line, and line, of each of *count entries */
static dls_status read_compressed(const source *s, const matrix_names *name, int lines, int bound,
                                  int nzmax, int *count, int **minor, int **major) {
  int *p = NULL;
  dls_status status = read_lines(s, name->p, lines, nzmax, &p);
  if (!status) {
    *count = p[lines];
    status = read_indices(s, name->i, *count, bound, minor);
  }
  if (!status) {
    *major = dlsi_alloc((size_t)*count, sizeof **major);
    if (!*major) status = no_memory(reading, s->error);
  }
  for (int j = 0; !status && j < lines; j++)
    for (int k = p[j]; k < p[j + 1]; k++)
      (*major)[k] = j;
  free(p);
  return status;
}

/* Leaves to the caller what it has read, on error too. */
static dls_status read_matrix(const source *s, const matrix_names *name, triplets *t) {
  int nz = 0, nzmax = 0;
  dls_status status = read_int(s, name->m, 1, &t->rows);
  if (!status) status = read_int(s, name->n, 1, &t->cols);
  if (!status) status = read_int(s, name->nz, -2, &nz);
  if (!status) status = read_int(s, name->nzmax, nz > 0 ? nz : 0, &nzmax);
  if (status) return status;
  if (nz >= 0) {
    t->count = nz;
    status = read_indices(s, name->p, nz, t->cols, &t->col);
    if (!status) status = read_indices(s, name->i, nz, t->rows, &t->row);
  } else if (nz == -1)
    status = read_compressed(s, name, t->cols, t->rows, nzmax, &t->count, &t->row, &t->col);
  else
    status = read_compressed(s, name, t->rows, t->cols, nzmax, &t->count, &t->col, &t->row);
  if (!status) status = read_doubles(s, name->x, (size_t)t->count, 1, &t->x);
  return status;
}

/* Which columns of a matrix of local columns (n, t[, s], n, ...), and how they are numbered. */
typedef enum part { ALL, NORMALS, TANGENTS } part;

static int column_of(int d, part which, int col) {
  const int c = col / d, k = col % d;
  if (which == ALL) return col;
  if (which == NORMALS) return k == 0 ? c : -1;
  return k == 0 ? -1 : (d - 1) * c + k - 1;
}

/* A := a part of the columns; a counting sort, so that each keeps the order of the file */
static dls_status compress(const char *function, const triplets *t, int d, part which, columns *A,
                           dls_error *error) {
  const int cols = which == ALL ? t->cols : t->cols / d * (which == NORMALS ? 1 : d - 1);
  int entries = 0;
  for (int k = 0; k < t->count; k++)
    entries += column_of(d, which, t->col[k]) >= 0;
  const dls_status status = alloc_columns(function, t->rows, cols, entries, A, error);
  if (status) return status;
  memset(A->p, 0, ((size_t)cols + 1) * sizeof *A->p);
  for (int k = 0; k < t->count; k++) {
    const int j = column_of(d, which, t->col[k]);
    if (j >= 0) A->p[j + 1]++;
  }
  for (int j = 0; j < cols; j++)
    A->p[j + 1] += A->p[j];
  for (int k = 0; k < t->count; k++) {
    const int j = column_of(d, which, t->col[k]);
    if (j < 0) continue;
    A->i[A->p[j]] = t->row[k];
    A->x[A->p[j]++] = t->x[k];
  }
  for (int j = cols; j > 0; j--) /* each p[j] has moved to the end of its column */
    A->p[j] = A->p[j - 1];
  A->p[0] = 0;
  return DLS_OK;
}

/* B := A (d nc x d nc) by blocks: one block wherever A has an entry */
static dls_status gather_blocks(const columns *A, int d, block_columns *B, dls_error *error) {
  const int nc = A->cols / d;
  const size_t dd = (size_t)d * (size_t)d;
  int *block = dlsi_alloc((size_t)nc, sizeof *block); /* the latest block of each block row */
  B->p = dlsi_alloc((size_t)nc + 1, sizeof *B->p);
  if (!block || !B->p) {
    free(block);
    return no_memory(reading, error);
  }
  for (int pass = 0; pass < 2; pass++) { /* count, fill */
    for (int b = 0; b < nc; b++)
      block[b] = -1;
    int count = 0;
    for (int c = 0; c < nc; c++) {
      B->p[c] = count;
      for (int j = 0; j < d; j++)
        for (int k = A->p[d * c + j]; k < A->p[d * c + j + 1]; k++) {
          const int b = A->i[k] / d;
          if (block[b] < B->p[c]) block[b] = count++;
          if (pass == 0) continue;
          B->i[block[b]] = b;
          double *sum = &B->x[(size_t)block[b] * dd + (size_t)(A->i[k] % d + d * j)];
          *sum = *sum == 0 ? A->x[k] : *sum + A->x[k]; /* 0 + -0.0 would be 0 */
        }
    }
    B->p[nc] = count;
    if (pass == 1) break;
    B->i = dlsi_alloc((size_t)count, sizeof *B->i);
    B->x = dlsi_alloc((size_t)count, dd * sizeof *B->x);
    if (!B->i || !B->x) {
      free(block);
      return no_memory(reading, error);
    }
    for (size_t e = 0; e < (size_t)count * dd; e++)
      B->x[e] = 0;
  }
  free(block);
  return DLS_OK;
}

/* ---- reading --------------------------------------------------------------------------------- */

/* 1 if the link `name`, one step from the group, is there */
static int has(const source *s, const char *name) {
  return H5Lexists(s->group, name, H5P_DEFAULT) > 0;
}

/* *text = a new copy of a string of fixed length, NULL if that cannot be read */
static dls_status read_fixed_text(hid_t set, hid_t stored, char **text, dls_error *error) {
  const size_t length = H5Tget_size(stored);
  const hid_t type = H5Tcopy(stored);
  if (type < 0) return DLS_OK;
  dls_status status = DLS_OK;
  if (length > 0 && length < SIZE_MAX && H5Tset_size(type, length + 1) >= 0 &&
      H5Tset_strpad(type, H5T_STR_NULLTERM) >= 0) {
    *text = dlsi_alloc(length + 1, 1);
    if (!*text)
      status = no_memory(reading, error);
    else if (H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, *text) < 0)
      (*text)[0] = '\0';
    else
      (*text)[length] = '\0';
  }
  (void)H5Tclose(type);
  return status;
}

/* the same for a string of variable length, which HDF5 allocates */
static dls_status read_variable_text(hid_t set, hid_t stored, hid_t space, char **text,
                                     dls_error *error) {
  char *held = NULL;
  if (H5Dread(set, stored, H5S_ALL, H5S_ALL, H5P_DEFAULT, &held) < 0 || !held) return DLS_OK;
  const size_t size = strlen(held) + 1;
  *text = dlsi_alloc(size, 1);
  if (*text) memcpy(*text, held, size);
  (void)H5Dvlen_reclaim(stored, space, H5P_DEFAULT, &held);
  return *text ? DLS_OK : no_memory(reading, error);
}

/* A title that is not there or is not one string is no error. */
static dls_status read_title(const source *s, char **title) {
  const hid_t set = H5Dopen2(s->group, "info/title", H5P_DEFAULT);
  if (set < 0) return DLS_OK;
  dls_status status = DLS_OK;
  const hid_t stored = H5Dget_type(set), space = H5Dget_space(set);
  if (stored >= 0 && space >= 0 && H5Tget_class(stored) == H5T_STRING &&
      H5Sget_simple_extent_npoints(space) == 1 && H5Dget_storage_size(set) > 0)
    status = H5Tis_variable_str(stored) > 0
                 ? read_variable_text(set, stored, space, title, s->error)
                 : read_fixed_text(set, stored, title, s->error);
  if (space >= 0) (void)H5Sclose(space);
  if (stored >= 0) (void)H5Tclose(stored);
  (void)H5Dclose(set);
  return status;
}

/* DLS_E_UNSUPPORTED if matrix or vector of bilateral constraints are there and not empty */
static dls_status refuse_bilateral(const source *s, const char *matrix, const char *m,
                                   const char *n, const char *vector) {
  int rows = 0, cols = 0;
  if (has(s, matrix)) {
    dls_status status = read_int(s, m, 0, &rows);
    if (!status) status = read_int(s, n, 0, &cols);
    if (status) return status;
    if (rows > 0 && cols > 0)
      return dlsi_fail(s->error, DLS_E_UNSUPPORTED, reading, matrix, -1, 0,
                       "bilateral constraints are not read");
  }
  const hid_t set = H5Dopen2(s->group, vector, H5P_DEFAULT);
  if (set < 0) return DLS_OK;
  const hid_t space = H5Dget_space(set);
  const hssize_t held = space < 0 ? 0 : H5Sget_simple_extent_npoints(space);
  if (space >= 0) (void)H5Sclose(space);
  (void)H5Dclose(set);
  if (held > 0)
    return dlsi_fail(s->error, DLS_E_UNSUPPORTED, reading, vector, -1, (double)held,
                     "bilateral constraints are not read");
  return DLS_OK;
}

/* file->nc from the size of the local space, which `name` gives */
static dls_status set_candidates(const source *s, const char *name, int size, dls_fclib *file) {
  // NOLINTNEXTLINE(clang-analyzer-core.DivideZero): status 0 vouches for it
  if (size % file->d != 0)
    return bad(s, name, -1, size, "is %d, must be a multiple of spacedim = %d", size, file->d);
  file->nc = size / file->d;
  return DLS_OK;
}

static dls_status read_friction(const source *s, dls_fclib *file) {
  const dls_status status = read_doubles(s, "vectors/mu", (size_t)file->nc, 0, &file->mu);
  if (status) return status;
  for (int c = 0; c < file->nc; c++)
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): status 0 vouches for it
    if (file->mu[c] < 0) return bad(s, "vectors/mu", c, file->mu[c], "is negative");
  return DLS_OK;
}

static dls_status read_local(const source *s, dls_fclib *file) {
  triplets W = {0};
  columns A = {0};
  dls_status status = refuse_bilateral(s, "V", "V/m", "V/n", "vectors/s");
  if (!status) status = refuse_bilateral(s, "R", "R/m", "R/n", "vectors/s");
  if (!status) status = read_matrix(s, &names_W, &W);
  if (!status && W.rows != W.cols)
    status = bad(s, "W/n", -1, W.cols, "is %d, W has %d rows", W.cols, W.rows);
  if (!status) status = set_candidates(s, "W/m", W.rows, file);
  /* before memory is taken: a vector of m values is more than a claim that there are m rows */
  if (!status) status = read_doubles(s, "vectors/q", (size_t)W.rows, 0, &file->q);
  if (!status) status = compress(reading, &W, file->d, ALL, &A, s->error);
  if (!status) status = gather_blocks(&A, file->d, &file->W, s->error);
  free_columns(&A);
  free_triplets(&W);
  return status;
}

static dls_status read_global(const source *s, dls_fclib *file) {
  triplets M = {0}, H = {0};
  dls_status status = refuse_bilateral(s, "G", "G/m", "G/n", "vectors/b");
  if (!status) status = read_matrix(s, &names_M, &M);
  if (!status && M.rows != M.cols)
    status = bad(s, "M/n", -1, M.cols, "is %d, M has %d rows", M.cols, M.rows);
  file->n = M.rows;
  if (!status) status = read_matrix(s, &names_H, &H);
  if (!status && H.rows != M.rows)
    status = bad(s, "H/m", -1, H.rows, "is %d, M has %d rows", H.rows, M.rows);
  if (!status) status = set_candidates(s, "H/n", H.cols, file);
  if (!status) status = read_doubles(s, "vectors/f", (size_t)M.rows, 0, &file->f);
  if (!status) status = read_doubles(s, "vectors/w", (size_t)H.cols, 0, &file->q);
  if (!status) status = compress(reading, &M, file->d, ALL, &file->M, s->error);
  if (!status) status = compress(reading, &H, file->d, NORMALS, &file->HN, s->error);
  if (!status) status = compress(reading, &H, file->d, TANGENTS, &file->HT, s->error);
  free_triplets(&M);
  free_triplets(&H);
  return status;
}

static dls_status read_problem(const source *s, dls_fclib *file) {
  dls_status status = read_int(s, "spacedim", 2, &file->d);
  if (status) return status;
  if (file->d > 3) return bad(s, "spacedim", -1, file->d, "is %d, must be 2 or 3", file->d);
  status = file->global ? read_global(s, file) : read_local(s, file);
  if (!status) status = read_friction(s, file);
  if (!status) status = read_title(s, &file->title);
  return status;
}

static dls_status read_solution(const source *s, dls_fclib *file) {
  const size_t m = (size_t)file->d * (size_t)file->nc;
  dls_status status = DLS_OK;
  if (!has(s, "solution")) return DLS_OK;
  const source in = {H5Gopen2(s->group, "solution", H5P_DEFAULT), s->error};
  if (in.group < 0) return bad(s, "solution", -1, 0, "is no group");
  if (has(&in, "r")) status = read_doubles(&in, "r", m, 0, &file->r);
  if (!status && has(&in, "u")) status = read_doubles(&in, "u", m, 0, &file->u);
  (void)H5Gclose(in.group);
  return status;
}

static dls_status read_file(dls_fclib *file, const char *path, dls_error *error) {
  const source top = {H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), error};
  if (top.group < 0) return bad(&top, "path", -1, 0, "is not an HDF5 file, or not a whole one");
  file->global = !has(&top, "fclib_local");
  const source s = {H5Gopen2(top.group, file->global ? "fclib_global" : "fclib_local", H5P_DEFAULT),
                    error};
  dls_status status;
  if (s.group < 0)
    status = bad(&top, "path", -1, 0, "has no group fclib_local or fclib_global");
  else {
    status = read_problem(&s, file);
    (void)H5Gclose(s.group);
  }
  if (!status) status = read_solution(&top, file);
  (void)H5Fclose(top.group);
  return status;
}

dls_status dls_fclib_read(dls_fclib **out, const char *path, dls_error *error) {
  if (!out) return dlsi_fail(error, DLS_E_ARGUMENT, reading, "out", -1, 0, "is NULL");
  *out = NULL;
  if (!path) return dlsi_fail(error, DLS_E_ARGUMENT, reading, "path", -1, 0, "is NULL");
  FILE *probe = dlsi_file_open(reading, path, error);
  if (!probe) return DLS_E_FILE;
  (void)fclose(probe);
  dls_fclib *file = dlsi_alloc(1, sizeof *file);
  if (!file) return no_memory(reading, error);
  *file = (dls_fclib){0};
  dls_status status;
  H5E_BEGIN_TRY {
    status = read_file(file, path, error);
  }
  H5E_END_TRY;
  if (status)
    dls_fclib_destroy(file);
  else
    *out = file;
  return status;
}

/* ---- what was read --------------------------------------------------------------------------- */

int dls_fclib_is_global(const dls_fclib *file) {
  return file && file->global;
}

const char *dls_fclib_title(const dls_fclib *file) {
  return file && file->title ? file->title : "";
}

dls_status dls_fclib_contact(const dls_fclib *file, dls_contact *problem, dls_error *error) {
  if (!file || file->global)
    return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "file", -1, 0,
                     file ? "holds a global problem" : "is NULL");
  if (!problem) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "problem", -1, 0, "is NULL");
  *problem = (dls_contact){
      .d = file->d,
      .nc = file->nc,
      .Wb = {file->d, file->nc, file->W.p, file->W.i, file->W.x},
      .q = file->q,
      .mu = file->mu,
  };
  return DLS_OK;
}

static dls_sparse view(const columns *A) {
  return (dls_sparse){A->rows, A->cols, A->p, A->i, A->x};
}

dls_status dls_fclib_model(const dls_fclib *file, dls_model *model, const double **f,
                           const double **g, const double **mu, dls_error *error) {
  if (!file || !file->global)
    return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "file", -1, 0,
                     file ? "holds a local problem" : "is NULL");
  if (!model) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "model", -1, 0, "is NULL");
  if (!f) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "f", -1, 0, "is NULL");
  if (!g) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "g", -1, 0, "is NULL");
  if (!mu) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "mu", -1, 0, "is NULL");
  *model = (dls_model){
      .d = file->d,
      .n = file->n,
      .nodes = file->nc,
      .operator_kind = DLS_STIFFNESS_SPARSE,
      .factorization = DLS_LU,
      .Ks = view(&file->M),
      .HN = view(&file->HN),
      .HT = view(&file->HT),
  };
  *f = file->f;
  *g = file->q;
  *mu = file->mu;
  return DLS_OK;
}

dls_status dls_fclib_solution(const dls_fclib *file, const double **r, const double **u,
                              dls_error *error) {
  if (!file) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "file", -1, 0, "is NULL");
  if (!r) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "r", -1, 0, "is NULL");
  if (!u) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "u", -1, 0, "is NULL");
  *r = file->r;
  *u = file->u;
  return DLS_OK;
}

void dls_fclib_destroy(dls_fclib *file) {
  if (!file) return;
  free(file->title);
  free(file->W.p);
  free(file->W.i);
  free(file->W.x);
  free_columns(&file->M);
  free_columns(&file->HN);
  free_columns(&file->HT);
  free(file->f);
  free(file->q);
  free(file->mu);
  free(file->r);
  free(file->u);
  free(file);
}

/* ---- matrices to write ----------------------------------------------------------------------- */

static dls_status too_many(const char *function, const char *argument, dls_error *error) {
  return dlsi_fail(error, DLS_E_SIZE, function, argument, -1, 0,
                   "has more entries than an int can count");
}

/* C := the entries of A that are not zero; with `lower`, the upper triangle is the lower one's */
static dls_status columns_of_dense(const char *function, const char *argument, const dls_dense *A,
                                   int lower, columns *C, dls_error *error) {
  const size_t ld = (size_t)A->ld;
  long long count = 0;
  for (int pass = 0; pass < 2; pass++) {
    if (pass == 1) {
      if (count > INT_MAX) return too_many(function, argument, error);
      const dls_status status = alloc_columns(function, A->rows, A->cols, (int)count, C, error);
      if (status) return status;
      C->p[0] = 0;
      count = 0;
    }
    for (int j = 0; j < A->cols; j++) {
      for (int i = 0; i < A->rows; i++) {
        const int upper = lower && i < j;
        const double x =
            upper ? A->a[(size_t)j + (size_t)i * ld] : A->a[(size_t)i + (size_t)j * ld];
        if (x == 0) continue;
        if (pass == 1) {
          C->i[count] = i;
          C->x[count] = x;
        }
        count++;
      }
      if (pass == 1) C->p[j + 1] = (int)count;
    }
  }
  return DLS_OK;
}

/* C := W by blocks, every entry of every block */
static dls_status columns_of_blocks(const char *function, const dls_blocks *B, columns *C,
                                    dls_error *error) {
  const int d = B->d, m = d * B->n;
  if (B->p[B->n] > INT_MAX / (d * d)) return too_many(function, "Wb", error);
  const dls_status status = alloc_columns(function, m, m, d * d * B->p[B->n], C, error);
  if (status) return status;
  int count = 0;
  for (int c = 0; c < B->n; c++)
    for (int j = 0; j < d; j++) {
      C->p[d * c + j] = count;
      for (int k = B->p[c]; k < B->p[c + 1]; k++)
        for (int i = 0; i < d; i++) {
          C->i[count] = d * B->i[k] + i;
          C->x[count++] = B->x[(size_t)k * (size_t)(d * d) + (size_t)(i + d * j)];
        }
    }
  C->p[m] = count;
  return DLS_OK;
}

/* C := K from its lower triangle */
static dls_status columns_of_lower(const char *function, const dls_sparse *K, columns *C,
                                   dls_error *error) {
  long long count = 0;
  for (int j = 0; j < K->cols; j++)
    for (int k = K->p[j]; k < K->p[j + 1]; k++)
      count += K->i[k] > j ? 2 : K->i[k] == j;
  if (count > INT_MAX) return too_many(function, "Ks", error);
  triplets t = {K->rows,
                K->cols,
                0,
                dlsi_alloc((size_t)count, sizeof *t.row),
                dlsi_alloc((size_t)count, sizeof *t.col),
                dlsi_alloc((size_t)count, sizeof *t.x)};
  dls_status status = t.row && t.col && t.x ? DLS_OK : no_memory(function, error);
  for (int j = 0; !status && j < K->cols; j++)
    for (int k = K->p[j]; k < K->p[j + 1]; k++) {
      const int i = K->i[k];
      for (int mirror = 0; mirror < (i > j ? 2 : i == j); mirror++) {
        t.row[t.count] = mirror ? j : i;
        t.col[t.count] = mirror ? i : j;
        t.x[t.count++] = K->x[k];
      }
    }
  if (!status) status = compress(function, &t, 1, ALL, C, error);
  free_triplets(&t);
  return status;
}

/* C := H, the columns of H_N and H_T candidate by candidate */
static dls_status columns_of_operators(const char *function, const dls_model *model, columns *C,
                                       dls_error *error) {
  const int d = model->d, nc = model->nodes;
  const dls_sparse *HN = &model->HN, *HT = &model->HT;
  const int tangents = (d - 1) * nc;
  if (HN->p[nc] > INT_MAX - HT->p[tangents]) return too_many(function, "HT", error);
  const dls_status status =
      alloc_columns(function, model->n, d * nc, HN->p[nc] + HT->p[tangents], C, error);
  if (status) return status;
  int count = 0;
  for (int col = 0; col < d * nc; col++) {
    const dls_sparse *A = col % d == 0 ? HN : HT;
    const int j = column_of(d, col % d == 0 ? NORMALS : TANGENTS, col);
    C->p[col] = count;
    for (int k = A->p[j]; k < A->p[j + 1]; k++) {
      C->i[count] = A->i[k];
      C->x[count++] = A->x[k];
    }
  }
  C->p[d * nc] = count;
  return DLS_OK;
}

/* ---- writing --------------------------------------------------------------------------------- */

/* A file under construction, in memory: HDF5 does not recover well from a full disk. */
typedef struct sink {
  hid_t file, link, create;
  int failed; /* some step failed: the rest does nothing */
} sink;

static void sink_open(sink *s, const char *path) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  s->link = H5Pcreate(H5P_LINK_CREATE);
  s->create = H5Pcreate(H5P_DATASET_CREATE);
  s->file = H5Pset_fapl_core(access, (size_t)1 << 20, 0) < 0
                ? -1
                : H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, access);
  /* groups appear with their data sets; no time stamps: same problem, same bytes */
  s->failed = s->file < 0 || H5Pset_create_intermediate_group(s->link, 1) < 0 ||
              H5Pset_obj_track_times(s->create, 0) < 0;
  if (access >= 0) (void)H5Pclose(access);
}

static void sink_close(sink *s) {
  if (s->link >= 0) (void)H5Pclose(s->link);
  if (s->create >= 0) (void)H5Pclose(s->create);
  if (s->file >= 0) (void)H5Fclose(s->file);
}

/* a data set of type `stored`, from values x of type `type` in memory */
static void put_set(sink *s, const char *name, hid_t stored, hid_t type, hid_t space,
                    const void *x) {
  if (s->failed) return;
  s->failed = 1;
  const hid_t set = H5Dcreate2(s->file, name, stored, space, s->link, s->create, H5P_DEFAULT);
  if (set < 0) return;
  const herr_t done = !x ? 0 : H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, x);
  s->failed = H5Dclose(set) < 0 || done < 0;
}

static void put_vector(sink *s, const char *name, hid_t stored, hid_t type, size_t count,
                       const void *x) {
  const hsize_t n = count;
  const hid_t space = H5Screate_simple(1, &n, NULL);
  put_set(s, name, stored, type, space, count ? x : NULL);
  if (space >= 0) (void)H5Sclose(space);
}

static void put_ints(sink *s, const char *name, size_t count, const int *x) {
  put_vector(s, name, H5T_STD_I32LE, H5T_NATIVE_INT, count, x);
}

static void put_doubles(sink *s, const char *name, size_t count, const double *x) {
  put_vector(s, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, count, x);
}

/* with its terminating zero, on which FCLIB's own reader relies */
static void put_text(sink *s, const char *name, const char *text) {
  const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  if (H5Tset_size(type, strlen(text) + 1) < 0) s->failed = 1;
  put_set(s, name, type, type, space, text);
  if (type >= 0) (void)H5Tclose(type);
  if (space >= 0) (void)H5Sclose(space);
}

typedef struct group_names {
  const char *spacedim, *title, *description, *math_info, *mu;
} group_names;

#define GROUP(a)                                                                                   \
  { a "/spacedim", a "/info/title", a "/info/description", a "/info/math_info", a "/vectors/mu" }
static const group_names names_local = GROUP("fclib_local"), names_global = GROUP("fclib_global");
static const matrix_names local_W = MATRIX("fclib_local/W"), global_M = MATRIX("fclib_global/M"),
                          global_H = MATRIX("fclib_global/H");

static void put_matrix(sink *s, const matrix_names *name, const dls_sparse *A) {
  // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): status 0 vouches for it
  const int entries = A->p[A->cols], compressed_columns = -1;
  put_ints(s, name->m, 1, &A->rows);
  put_ints(s, name->n, 1, &A->cols);
  put_ints(s, name->nz, 1, &compressed_columns);
  put_ints(s, name->nzmax, 1, &entries);
  put_ints(s, name->p, (size_t)A->cols + 1, A->p);
  put_ints(s, name->i, (size_t)entries, A->i);
  put_doubles(s, name->x, (size_t)entries, A->x);
}

static void put_common(sink *s, const group_names *name, int d, int nc, const double *mu,
                       const char *title) {
  put_ints(s, name->spacedim, 1, &d);
  put_doubles(s, name->mu, (size_t)nc, mu);
  if (title && title[0]) put_text(s, name->title, title);
  put_text(s, name->description, "written by delassus " DLS_VERSION);
  put_text(s, name->math_info, "unknown");
}

static void put_solution(sink *s, int n, const double *x, int m, const double *r, const double *u) {
  if (x) put_doubles(s, "solution/v", (size_t)n, x);
  if (r) put_doubles(s, "solution/r", (size_t)m, r);
  if (u) put_doubles(s, "solution/u", (size_t)m, u);
}

/* The image of the file, from memory to `path`. */
static dls_status save(sink *s, const char *function, const char *path, dls_error *error) {
  ssize_t size = -1;
  if (!s->failed && H5Fflush(s->file, H5F_SCOPE_GLOBAL) >= 0)
    size = H5Fget_file_image(s->file, NULL, 0);
  if (size <= 0)
    return dlsi_fail(error, DLS_E_FILE, function, "path", -1, 0, "HDF5 cannot build the file");
  char *image = dlsi_alloc((size_t)size, 1);
  if (!image) return no_memory(function, error);
  dls_status status = DLS_OK;
  FILE *file = NULL;
  if (H5Fget_file_image(s->file, image, (size_t)size) != size)
    status = dlsi_fail(error, DLS_E_FILE, function, "path", -1, 0, "HDF5 cannot build the file");
  if (!status) {
    file = fopen(path, "wb");
    if (!file)
      status =
          dlsi_fail(error, DLS_E_FILE, function, "path", -1, 0, "cannot be opened for writing");
  }
  if (file) {
    (void)fwrite(image, 1, (size_t)size, file); /* a short count sets the file's error */
    status = dlsi_file_finish(function, path, file, error);
  }
  free(image);
  return status;
}

/* r and u of m values each, or neither */
static dls_status check_solution(const char *function, const double *r, const double *u, size_t m,
                                 dls_error *error) {
  if (!r && !u) return DLS_OK;
  const dls_status status = dlsi_check_vector(function, "r", r, m, error);
  return status ? status : dlsi_check_vector(function, "u", u, m, error);
}

static dls_status write_local(const char *function, const char *path, const dls_contact *problem,
                              const char *title, const double *r, const double *u,
                              dls_error *error) {
  const int m = problem->d * problem->nc;
  columns W = {0};
  dls_status status = problem->Wb.x ? columns_of_blocks(function, &problem->Wb, &W, error)
                                    : columns_of_dense(function, "W", &problem->W, 0, &W, error);
  if (!status) {
    const dls_sparse A = view(&W);
    sink s;
    sink_open(&s, path);
    put_common(&s, &names_local, problem->d, problem->nc, problem->mu, title);
    put_matrix(&s, &local_W, &A);
    put_doubles(&s, "fclib_local/vectors/q", (size_t)m, problem->q);
    put_solution(&s, 0, NULL, m, r, u);
    status = save(&s, function, path, error);
    sink_close(&s);
  }
  free_columns(&W);
  return status;
}

dls_status dls_fclib_write_local(const char *path, const dls_contact *problem, const char *title,
                                 const double *r, const double *u, dls_error *error) {
  if (!path) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "path", -1, 0, "is NULL");
  dls_status status = dlsi_check_contact(__func__, problem, error);
  if (status) return status;
  status = check_solution(__func__, r, u, (size_t)problem->d * (size_t)problem->nc, error);
  if (status) return status;
  H5E_BEGIN_TRY {
    status = write_local(__func__, path, problem, title, r, u, error);
  }
  H5E_END_TRY;
  return status;
}

static dls_status write_global(const char *function, const char *path, const dls_model *model,
                               const double *f, const double *g, const double *mu,
                               const char *title, const double *x, const double *r, const double *u,
                               dls_error *error) {
  const int m = model->d * model->nodes, cholesky = model->factorization == DLS_CHOLESKY;
  columns K = {0}, H = {0}; /* K: unless the model's own columns serve as they are */
  dls_status status = DLS_OK;
  if (model->operator_kind == DLS_STIFFNESS_DENSE)
    status = columns_of_dense(function, "K", &model->K, cholesky, &K, error);
  else if (cholesky)
    status = columns_of_lower(function, &model->Ks, &K, error);
  if (!status) status = columns_of_operators(function, model, &H, error);
  if (!status) {
    const dls_sparse M = K.p ? view(&K) : model->Ks, A = view(&H);
    sink s;
    sink_open(&s, path);
    put_common(&s, &names_global, model->d, model->nodes, mu, title);
    put_matrix(&s, &global_M, &M);
    put_matrix(&s, &global_H, &A);
    put_doubles(&s, "fclib_global/vectors/f", (size_t)model->n, f);
    put_doubles(&s, "fclib_global/vectors/w", (size_t)m, g);
    put_solution(&s, model->n, x, m, r, u);
    status = save(&s, function, path, error);
    sink_close(&s);
  }
  free_columns(&K);
  free_columns(&H);
  return status;
}

/* What this file can hold of a model: no P, no operator but K itself. */
static dls_status check_model(const char *function, const dls_model *model, dls_error *error) {
  if (!model) return dlsi_fail(error, DLS_E_ARGUMENT, function, "model", -1, 0, "is NULL");
  const int d = model->d, n = model->n, nodes = model->nodes;
  if (d != 2 && d != 3)
    return dlsi_fail(error, DLS_E_ARGUMENT, function, "d", -1, d, "is %d, must be 2 or 3", d);
  if (n < 1) return dlsi_fail(error, DLS_E_SIZE, function, "n", -1, n, "is %d", n);
  if (nodes < 1 || nodes > INT_MAX / d)
    return dlsi_fail(error, DLS_E_SIZE, function, "nodes", -1, nodes, "is %d", nodes);
  if (model->P.p)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, function, "P", -1, 0, "FCLIB has no weighting");
  if (model->operator_kind != DLS_STIFFNESS_DENSE && model->operator_kind != DLS_STIFFNESS_SPARSE)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, function, "operator_kind", -1, model->operator_kind,
                     "FCLIB holds K only");
  dls_status status = model->operator_kind == DLS_STIFFNESS_DENSE
                          ? dlsi_check_dense(function, "K", &model->K, n, n, error)
                          : dlsi_check_sparse(function, "Ks", &model->Ks, n, n, error);
  if (!status) status = dlsi_check_sparse(function, "HN", &model->HN, n, nodes, error);
  if (!status) status = dlsi_check_sparse(function, "HT", &model->HT, n, (d - 1) * nodes, error);
  return status;
}

dls_status dls_fclib_write_global(const char *path, const dls_model *model, const double *f,
                                  const double *g, const double *mu, const char *title,
                                  const double *x, const double *r, const double *u,
                                  dls_error *error) {
  if (!path) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "path", -1, 0, "is NULL");
  dls_status status = check_model(__func__, model, error);
  if (status) return status;
  const size_t n = (size_t)model->n, nc = (size_t)model->nodes, m = (size_t)model->d * nc;
  status = dlsi_check_vector(__func__, "f", f, n, error);
  if (!status) status = dlsi_check_vector(__func__, "g", g, m, error);
  if (!status) status = dlsi_check_vector(__func__, "mu", mu, nc, error);
  if (!status && x) status = dlsi_check_vector(__func__, "x", x, n, error);
  if (!status) status = check_solution(__func__, r, u, m, error);
  if (status) return status;
  for (size_t c = 0; c < nc; c++)
    if (mu[c] < 0)
      return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "mu", (long long)c, mu[c], "is negative");
  H5E_BEGIN_TRY {
    status = write_global(__func__, path, model, f, g, mu, title, x, r, u, error);
  }
  H5E_END_TRY;
  return status;
}

#else /* without HDF5 */

static dls_status unsupported(const char *function, dls_error *error) {
  return dlsi_fail(error, DLS_E_UNSUPPORTED, function, "", -1, 0, "built without HDF5");
}

dls_status dls_fclib_read(dls_fclib **out, const char *path, dls_error *error) {
  (void)path;
  if (out) *out = NULL;
  return unsupported(__func__, error);
}

int dls_fclib_is_global(const dls_fclib *file) {
  (void)file;
  return 0;
}

const char *dls_fclib_title(const dls_fclib *file) {
  (void)file;
  return "";
}

dls_status dls_fclib_contact(const dls_fclib *file, dls_contact *problem, dls_error *error) {
  (void)file;
  (void)problem;
  return unsupported(__func__, error);
}

dls_status dls_fclib_model(const dls_fclib *file, dls_model *model, const double **f,
                           const double **g, const double **mu, dls_error *error) {
  (void)file;
  (void)model;
  (void)f;
  (void)g;
  (void)mu;
  return unsupported(__func__, error);
}

dls_status dls_fclib_solution(const dls_fclib *file, const double **r, const double **u,
                              dls_error *error) {
  (void)file;
  (void)r;
  (void)u;
  return unsupported(__func__, error);
}

void dls_fclib_destroy(dls_fclib *file) {
  (void)file;
}

dls_status dls_fclib_write_local(const char *path, const dls_contact *problem, const char *title,
                                 const double *r, const double *u, dls_error *error) {
  (void)path;
  (void)problem;
  (void)title;
  (void)r;
  (void)u;
  return unsupported(__func__, error);
}

dls_status dls_fclib_write_global(const char *path, const dls_model *model, const double *f,
                                  const double *g, const double *mu, const char *title,
                                  const double *x, const double *r, const double *u,
                                  dls_error *error) {
  (void)path;
  (void)model;
  (void)f;
  (void)g;
  (void)mu;
  (void)title;
  (void)x;
  (void)r;
  (void)u;
  return unsupported(__func__, error);
}

#endif
