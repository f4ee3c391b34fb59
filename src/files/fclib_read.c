/*
 * fclib_read.c: reads contact problems from FCLIB files (Acary, Bremond, Koziara, Perignon,
 * "FCLIB: a collection of discrete 3D frictional contact problems", INRIA RT-0444, 2014), in HDF5.
 *
 *   fclib_local/   W, vectors/q, vectors/mu, spacedim, info/title            u = W r + q
 *   fclib_global/  M, H, vectors/f, w, mu, spacedim, info/title   M v = H r + f,  u = H^T v + w
 *                  G, vectors/b: joints     M v = H r + G l + f,  G^T v + b = 0    fclib_joints.c
 *   solution/      v, r, u
 *
 * A matrix is a group m, n, nz, nzmax, p, i, x, as in CSparse:
 *   nz = -1  compressed columns: column j has p[j] <= k < p[j+1], rows i[k]
 *   nz = -2  compressed rows: row i has p[i] <= k < p[i+1], columns i[k]
 *   nz >= 0  nz triplets, row i[k], column p[k]
 * i and x may be longer than needed. Entries of the same place add up. Bilateral constraints of a
 * local problem (V, R, s) are not read. Of a file with both problems the local one is read: it is
 * the global one condensed.
 *
 * A file is not trusted: sizes are checked against each other and against the extents of the data
 * sets before memory is allocated, indices and values before use. HDF5 prints its errors by
 * default; H5E_BEGIN_TRY silences it and restores the host's handler.
 */
#include <hdf5.h>
#include <limits.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "contact/columns.h"
#include "delassus/files.h"
#include "files/fclib_bodies.h"
#include "files/fclib_internal.h"
#include "files/fclib_joints.h"
#include "files/file.h"

struct dls_fclib {
  int global, d, nc, n;
  char *title;
  dlsi_columns W;           /* local: by blocks, x[d d k..] in block row i[k] */
  dlsi_columns M, HN, HT;   /* global */
  dlsi_fclib_bodies bodies; /* global: as rigid bodies, if it is so */
  double *f;                /* global: n */
  double *q, *mu;           /* q: d nc, the w of a global problem; mu: nc */
  double *r, *u;            /* d nc, or NULL */
};

/* ---- data sets ------------------------------------------------------------------------------- */

typedef struct source {
  hid_t group;                    /* where the names of data sets start */
  hsize_t bytes;                  /* of the file */
  hid_t set_access, group_access; /* to open data sets and groups */
  dls_error *error;
} source;

enum { largest_type = 16 }; /* bytes of a number in a file: a double has 8 */

/* Refuses to follow a link into another file. */
static herr_t stay_inside(const char *parent_file, const char *parent_group, const char *child_file,
                          const char *child_name, unsigned *flags, hid_t access, void *data) {
  (void)parent_file, (void)parent_group, (void)child_file, (void)child_name, (void)flags;
  (void)access, (void)data;
  return -1;
}

enum { most_deflated = 1032 }; /* largest number of bytes from one byte of deflate */

enum { free_chunk = 8 << 16 }; /* bytes of a chunk that HDF5 may read whatever is wanted */

/* Returns 1 if the values are in this file, which is large enough for them. HDF5 reads a chunk as a
 * whole: one of more than free_chunk bytes may hold twice the values wanted, no more. held: values
 * of `size` bytes. */
static int is_stored_here(const source *s, hid_t set, hsize_t held, size_t wanted, size_t size) {
  hsize_t chunk[H5S_MAX_RANK], values = 1, most = 2 * (hsize_t)wanted;
  const hid_t create = H5Dget_create_plist(set);
  if (create < 0 || size == 0) return 0;
  const H5D_layout_t layout = H5Pget_layout(create);
  const hsize_t room = s->bytes * (H5Pget_nfilters(create) > 0 ? most_deflated : 1) / size;
  if (most < free_chunk / size) most = free_chunk / size;
  if (most > room) most = room;
  int good =
      held <= room && (layout == H5D_COMPACT || layout == H5D_CONTIGUOUS || layout == H5D_CHUNKED);
  if (good && layout == H5D_CONTIGUOUS) good = H5Pget_external_count(create) == 0;
  if (good && layout == H5D_CHUNKED) {
    const int rank = H5Pget_chunk(create, H5S_MAX_RANK, chunk);
    good = rank > 0;
    for (int k = 0; k < rank && good; k++) {
      good = chunk[k] > 0 && chunk[k] <= most / values;
      values *= chunk[k];
    }
  }
  (void)H5Pclose(create);
  return good;
}

/* Checks space and type of a data set that must hold `count` numbers, or at least as many if
 * `longer`. */
static dls_status check_set(const source *s, const char *name, hid_t set, hid_t space, hid_t type,
                            size_t count, int longer) {
  const hid_t stored = H5Dget_type(set);
  const H5T_class_t kind = stored < 0 ? H5T_NO_CLASS : H5Tget_class(stored);
  const size_t size = stored < 0 ? 0 : H5Tget_size(stored);
  if (stored >= 0) (void)H5Tclose(stored);
  if ((kind != H5T_INTEGER && (kind != H5T_FLOAT || H5Tget_class(type) != H5T_FLOAT)) ||
      size > largest_type)
    return dlsi_fail(s->error, DLS_E_FORMAT, name, -1, 0, "has the wrong type");
  const hssize_t held = H5Sget_simple_extent_npoints(space);
  if (held < 0 || (size_t)held < count || ((size_t)held > count && !longer))
    return dlsi_fail(s->error, DLS_E_FORMAT, name, -1, (double)held,
                     "holds %lld values, must hold %s%zu", (long long)held,
                     longer ? "at least " : "", count);
  if ((size_t)held > count && H5Sget_simple_extent_ndims(space) != 1)
    return dlsi_fail(s->error, DLS_E_FORMAT, name, -1, 0, "must have one dimension");
  if (count && H5Dget_storage_size(set) == 0)
    return dlsi_fail(s->error, DLS_E_FORMAT, name, -1, 0, "was never written");
  if (held && !is_stored_here(s, set, (hsize_t)held, count, size))
    return dlsi_fail(
        s->error, DLS_E_FORMAT, name, -1, (double)held,
        "claims more values than the file has room for, or is in pieces out of proportion");
  return DLS_OK;
}

/* Reads the first `count` values of the data set into x, converted to `type`. */
static herr_t read_first(hid_t set, hid_t space, hid_t type, size_t count, void *x) {
  if (!count) return 0;
  const hsize_t start = 0, n = count;
  if (H5Sget_simple_extent_npoints(space) == (hssize_t)count)
    return H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, x);
  const hid_t memory = H5Screate_simple(1, &n, NULL);
  herr_t done = H5Sselect_hyperslab(space, H5S_SELECT_SET, &start, NULL, &n, NULL);
  if (done >= 0) done = H5Dread(set, type, memory, space, H5P_DEFAULT, x); /* < 0 if memory is */
  if (memory >= 0) (void)H5Sclose(memory);
  return done;
}

/* Reads `count` numbers of `type` from data set `name` into a new array *out, NULL on error.
 * Integers that do not fit an int become INT_MAX, which fails every check. */
static dls_status read_set(const source *s, const char *name, hid_t type, size_t count, int longer,
                           void **out) {
  *out = NULL;
  const hid_t set = H5Dopen2(s->group, name, s->set_access);
  if (set < 0) return dlsi_fail(s->error, DLS_E_FORMAT, name, -1, 0, "no such data set");
  const hid_t space = H5Dget_space(set);
  dls_status status = check_set(s, name, set, space, type, count, longer);
  void *x = status ? NULL : dlsi_alloc(count, H5Tget_size(type));
  if (!status && !x) status = dlsi_no_memory(s->error);
  if (!status && read_first(set, space, type, count, x) < 0)
    status = dlsi_fail(s->error, DLS_E_FORMAT, name, -1, 0, "cannot be read");
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
  if (v < least || v == INT_MAX) return dlsi_fail(s->error, DLS_E_FORMAT, name, -1, v, "is %d", v);
  *value = v;
  return DLS_OK;
}

/* Reads `count` indices, each in 0 .. bound-1. */
static dls_status read_indices(const source *s, const char *name, int count, int bound, int **out) {
  void *x;
  const dls_status status = read_set(s, name, H5T_NATIVE_INT, (size_t)count, 1, &x);
  if (!x) return status;
  *out = x;
  for (int k = 0; k < count; k++)
    if ((*out)[k] < 0 || (*out)[k] >= bound)
      return dlsi_fail(s->error, DLS_E_FORMAT, name, k, (*out)[k], "is %d, must be in 0 .. %d",
                       (*out)[k], bound - 1);
  return DLS_OK;
}

static dls_status read_doubles(const source *s, const char *name, size_t count, int longer,
                               double **out) {
  void *x;
  const dls_status status = read_set(s, name, H5T_NATIVE_DOUBLE, count, longer, &x);
  if (!x) return status;
  *out = x;
  const long long k = dlsi_first_not_finite(*out, count);
  if (k >= 0) return dlsi_fail(s->error, DLS_E_FORMAT, name, k, (*out)[k], "is not finite");
  return DLS_OK;
}

/* ---- matrices -------------------------------------------------------------------------------- */

/* Reads compressed lines, columns or rows. *major, *minor: line of each entry, and position in
 * that line, *count each. */
static dls_status read_compressed(const source *s, const matrix_names *name, int lines, int bound,
                                  int nzmax, int *count, int **minor, int **major) {
  int *p = NULL;
  dls_status status = read_indices(s, name->p, lines + 1, nzmax + 1, &p);
  // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): status 0 vouches for it
  if (!status && p[0] != 0)
    status = dlsi_fail(s->error, DLS_E_FORMAT, name->p, 0, p[0], "must be 0");
  for (int j = 0; !status && j < lines; j++)
    if (p[j + 1] < p[j])
      status = dlsi_fail(s->error, DLS_E_FORMAT, name->p, j + 1, p[j + 1],
                         "is less than the one before it");
  if (!status) {
    *count = p[lines];
    status = read_indices(s, name->i, *count, bound, minor);
  }
  if (!status) {
    *major = dlsi_alloc((size_t)*count, sizeof **major);
    if (!*major) status = dlsi_no_memory(s->error);
  }
  for (int j = 0; !status && j < lines; j++)
    for (int k = p[j]; k < p[j + 1]; k++)
      (*major)[k] = j;
  free(p);
  return status;
}

/* Reads a matrix in any of the three formats. On error, too, the caller frees t. */
static dls_status read_matrix(const source *s, const matrix_names *name, dlsi_triplets *t) {
  int nz = 0, nzmax = 0;
  dls_status status = read_int(s, name->m, 0, &t->rows);
  if (!status) status = read_int(s, name->n, 0, &t->cols);
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

static dls_status read_square(const source *s, const matrix_names *name, dlsi_triplets *t) {
  const dls_status status = read_matrix(s, name, t);
  if (status || t->rows == t->cols) return status;
  return dlsi_fail(s->error, DLS_E_FORMAT, name->n, -1, t->cols, "is %d, %c has %d row%s", t->cols,
                   *name->n, t->rows, t->rows == 1 ? "" : "s");
}

/* Gathers A (d nc x d nc) by blocks into B: one block wherever A has an entry. */
static dls_status gather_blocks(const dlsi_columns *A, int d, dlsi_columns *B, dls_error *error) {
  const int nc = A->cols / d;
  const size_t dd = (size_t)d * (size_t)d;
  int *block = dlsi_alloc((size_t)nc, sizeof *block); /* latest block of each block row */
  B->p = dlsi_alloc((size_t)nc + 1, sizeof *B->p);
  dls_status status = block && B->p ? DLS_OK : dlsi_no_memory(error);
  for (int pass = 0; !status && pass < 2; pass++) { /* count, fill */
    int count = 0;
    for (int b = 0; b < nc; b++)
      block[b] = -1;
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
    B->x = calloc(count ? (size_t)count : 1, dd * sizeof *B->x);
    if (!B->i || !B->x) status = dlsi_no_memory(error);
  }
  free(block);
  return status;
}

/* ---- reading --------------------------------------------------------------------------------- */

/* Returns 1 if the link `name`, one step from the group, exists. */
static int has_link(const source *s, const char *name) {
  return H5Lexists(s->group, name, H5P_DEFAULT) > 0;
}

/* Copies a string of fixed length into a new *text; leaves NULL if HDF5 cannot convert it. */
static dls_status read_fixed_text(hid_t set, hid_t stored, char **text, dls_error *error) {
  const size_t length = H5Tget_size(stored);
  const hid_t type = H5Tcopy(stored);
  if (type < 0) return DLS_OK;
  const int usable = length > 0 && length < SIZE_MAX && H5Tset_size(type, length + 1) >= 0 &&
                     H5Tset_strpad(type, H5T_STR_NULLTERM) >= 0;
  if (usable) *text = dlsi_alloc(length + 1, 1);
  if (*text) {
    const herr_t done = H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, *text);
    (*text)[done < 0 ? 0 : length] = '\0';
  }
  (void)H5Tclose(type);
  return *text || !usable ? DLS_OK : dlsi_no_memory(error);
}

/* Copies a string of variable length, which HDF5 allocates, into a new *text. */
static dls_status read_variable_text(hid_t set, hid_t stored, hid_t space, char **text,
                                     dls_error *error) {
  char *held = NULL;
  if (H5Dread(set, stored, H5S_ALL, H5S_ALL, H5P_DEFAULT, &held) < 0 || !held) return DLS_OK;
  const size_t size = strlen(held) + 1;
  *text = dlsi_alloc(size, 1);
  if (*text) memcpy(*text, held, size);
  (void)H5Dvlen_reclaim(stored, space, H5P_DEFAULT, &held);
  return *text ? DLS_OK : dlsi_no_memory(error);
}

/* Reads the title; a title that is missing or not one string is no error. */
static dls_status read_title(const source *s, char **title) {
  const hid_t set = H5Dopen2(s->group, "info/title", s->set_access);
  if (set < 0) return DLS_OK;
  dls_status status = DLS_OK;
  const hid_t stored = H5Dget_type(set), space = H5Dget_space(set);
  if (stored >= 0 && space >= 0 && H5Tget_class(stored) == H5T_STRING &&
      H5Sget_simple_extent_npoints(space) == 1 && H5Dget_storage_size(set) > 0 &&
      is_stored_here(s, set, 1, 1, H5Tget_size(stored)))
    status = H5Tis_variable_str(stored) > 0
                 ? read_variable_text(set, stored, space, title, s->error)
                 : read_fixed_text(set, stored, title, s->error);
  if (space >= 0) (void)H5Sclose(space);
  if (stored >= 0) (void)H5Tclose(stored);
  (void)H5Dclose(set);
  return status;
}

/* Returns DLS_E_UNSUPPORTED if the matrix or the vector of bilateral constraints exists and is not
 * empty. */
static dls_status refuse_bilateral(const source *s, const char *matrix, const char *m,
                                   const char *n) {
  int rows = 0, cols = 0;
  dls_status status = DLS_OK;
  if (has_link(s, matrix)) {
    status = read_int(s, m, 0, &rows);
    if (!status) status = read_int(s, n, 0, &cols);
  }
  const hid_t set = status ? -1 : H5Dopen2(s->group, "vectors/s", s->set_access);
  const hid_t space = set < 0 ? -1 : H5Dget_space(set);
  const hssize_t held = space < 0 ? 0 : H5Sget_simple_extent_npoints(space);
  if (space >= 0) (void)H5Sclose(space);
  if (set >= 0) (void)H5Dclose(set);
  const int empty = rows < 1 || cols < 1;
  if (status || (empty && held < 1)) return status;
  return dlsi_fail(s->error, DLS_E_UNSUPPORTED, empty ? "vectors/s" : matrix, -1, (double)held,
                   "bilateral constraints are not read");
}

/* Sets file->nc from the size of the local space, given by data set `name`. */
static dls_status set_candidates(const source *s, const char *name, int size, dls_fclib *file) {
  // NOLINTNEXTLINE(clang-analyzer-core.DivideZero): status 0 vouches for it
  if (size % file->d != 0)
    return dlsi_fail(s->error, DLS_E_FORMAT, name, -1, size,
                     "is %d, must be a multiple of spacedim = %d", size, file->d);
  file->nc = size / file->d;
  return DLS_OK;
}

static dls_status read_friction(const source *s, dls_fclib *file) {
  const dls_status status = read_doubles(s, "vectors/mu", (size_t)file->nc, 0, &file->mu);
  if (status) return status;
  for (int c = 0; c < file->nc; c++)
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): status 0 vouches for it
    if (file->mu[c] < 0)
      return dlsi_fail(s->error, DLS_E_FORMAT, "vectors/mu", c, file->mu[c], "is negative");
  return DLS_OK;
}

static dls_status read_local(const source *s, dls_fclib *file) {
  dlsi_triplets W = {0};
  dlsi_columns A = {0};
  dls_status status = refuse_bilateral(s, "V", "V/m", "V/n");
  if (!status) status = refuse_bilateral(s, "R", "R/m", "R/n");
  if (!status) status = read_square(s, &names_W, &W);
  if (!status) status = set_candidates(s, "W/m", W.rows, file);
  /* read q before memory is allocated: a vector of m values is more than a claim of m rows */
  if (!status) status = read_doubles(s, "vectors/q", (size_t)W.rows, 0, &file->q);
  if (!status) status = dlsi_columns_compress(&W, file->d, DLSI_ALL, &A, s->error);
  if (!status) status = gather_blocks(&A, file->d, &file->W, s->error);
  dlsi_columns_free(&A);
  dlsi_triplets_free(&W);
  return status;
}

/* Reads G into t, without columns if the file has none. n: rows of M. On error, too, the caller
 * frees t. */
static dls_status read_joints(const source *s, int n, dlsi_triplets *t) {
  int rows = 0, cols = 0;
  if (!has_link(s, "G")) return DLS_OK;
  dls_status status = read_int(s, names_G.m, 0, &rows);
  if (!status) status = read_int(s, names_G.n, 0, &cols);
  if (status || rows == 0 || cols == 0) return status;
  status = read_matrix(s, &names_G, t);
  if (status || t->rows == n) return status;
  return dlsi_fail(s->error, DLS_E_FORMAT, names_G.m, -1, t->rows, "is %d, M has %d row%s", t->rows,
                   n, n == 1 ? "" : "s");
}

/* Reads f, and b below it, into a new file->f. */
static dls_status read_loads(const source *s, int n, int joints, dls_fclib *file) {
  double *f = NULL, *b = NULL;
  dls_status status = read_doubles(s, "vectors/f", (size_t)n, 0, &f);
  if (!status && (joints > 0 || has_link(s, "vectors/b")))
    status = read_doubles(s, "vectors/b", (size_t)joints, 0, &b);
  if (!status) file->f = dlsi_alloc((size_t)n + (size_t)joints, sizeof *f);
  if (!status && !file->f) status = dlsi_no_memory(s->error);
  if (!status) memcpy(file->f, f, (size_t)n * sizeof *f);
  if (!status && joints > 0) memcpy(file->f + n, b, (size_t)joints * sizeof *b);
  free(f);
  free(b);
  return status;
}

static dls_status read_global(const source *s, dls_fclib *file) {
  dlsi_triplets M = {0}, H = {0}, G = {0};
  dls_status status = read_square(s, &names_M, &M);
  if (!status && M.rows < 1)
    status = dlsi_fail(s->error, DLS_E_FORMAT, names_M.m, -1, M.rows, "is %d", M.rows);
  if (!status) status = read_joints(s, M.rows, &G);
  if (!status) status = read_matrix(s, &names_H, &H);
  if (!status && H.rows != M.rows)
    status = dlsi_fail(s->error, DLS_E_FORMAT, "H/m", -1, H.rows, "is %d, M has %d row%s", H.rows,
                       M.rows, M.rows == 1 ? "" : "s");
  if (!status) status = set_candidates(s, "H/n", H.cols, file);
  if (!status) status = read_loads(s, M.rows, G.cols, file);
  if (!status) status = read_doubles(s, "vectors/w", (size_t)H.cols, 0, &file->q);
  if (!status && G.cols > 0) status = dlsi_fclib_join(&M, &G, s->error);
  file->n = H.rows = M.rows;
  if (!status) status = dlsi_columns_compress(&M, file->d, DLSI_ALL, &file->M, s->error);
  if (!status) status = dlsi_columns_compress(&H, file->d, DLSI_NORMALS, &file->HN, s->error);
  if (!status) status = dlsi_columns_compress(&H, file->d, DLSI_TANGENTS, &file->HT, s->error);
  const int joints = G.cols;
  dlsi_triplets_free(&M);
  dlsi_triplets_free(&H);
  dlsi_triplets_free(&G);
  if (status || joints > 0) return status;
  const dlsi_fclib_global of = {.d = file->d,
                                .nc = file->nc,
                                .M = dlsi_columns_view(&file->M),
                                .HN = dlsi_columns_view(&file->HN),
                                .HT = dlsi_columns_view(&file->HT),
                                .f = file->f,
                                .w = file->q};
  return dlsi_fclib_bodies_create(&file->bodies, &of, s->error);
}

static dls_status read_problem(const source *s, dls_fclib *file) {
  dls_status status = read_int(s, "spacedim", 2, &file->d);
  if (status) return status;
  if (file->d > 3)
    return dlsi_fail(s->error, DLS_E_FORMAT, "spacedim", -1, file->d, "is %d, must be 2 or 3",
                     file->d);
  status = file->global ? read_global(s, file) : read_local(s, file);
  if (!status) status = read_friction(s, file);
  if (!status) status = read_title(s, &file->title);
  return status;
}

static dls_status read_solution(const source *s, dls_fclib *file) {
  const size_t m = (size_t)file->d * (size_t)file->nc;
  dls_status status = DLS_OK;
  if (!has_link(s, "solution")) return DLS_OK;
  source in = *s;
  in.group = H5Gopen2(s->group, "solution", s->group_access);
  if (in.group < 0) return dlsi_fail(s->error, DLS_E_FORMAT, "solution", -1, 0, "is no group");
  if (has_link(&in, "r")) status = read_doubles(&in, "r", m, 0, &file->r);
  if (!status && has_link(&in, "u")) status = read_doubles(&in, "u", m, 0, &file->u);
  (void)H5Gclose(in.group);
  return status;
}

static dls_status read_open_file(const source *top, dls_fclib *file) {
  source s = *top;
  file->global = !has_link(top, "fclib_local");
  s.group = H5Gopen2(top->group, file->global ? "fclib_global" : "fclib_local", top->group_access);
  if (s.group < 0)
    return dlsi_fail(s.error, DLS_E_FORMAT, "path", -1, 0,
                     "has no group fclib_local or fclib_global");
  dls_status status = read_problem(&s, file);
  (void)H5Gclose(s.group);
  if (!status) status = read_solution(top, file);
  return status;
}

static dls_status read_file(dls_fclib *file, const char *path, dls_error *error) {
  source top = {H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), .error = error};
  if (top.group < 0)
    return dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0, "is not an HDF5 file, or not a whole one");
  dls_status status;
  top.set_access = H5Pcreate(H5P_DATASET_ACCESS);
  top.group_access = H5Pcreate(H5P_GROUP_ACCESS);
  if (top.set_access < 0 || H5Pset_elink_cb(top.set_access, stay_inside, NULL) < 0 ||
      top.group_access < 0 || H5Pset_elink_cb(top.group_access, stay_inside, NULL) < 0 ||
      H5Fget_filesize(top.group, &top.bytes) < 0)
    status = dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0, "HDF5 cannot tell its size");
  else
    status = read_open_file(&top, file);
  if (top.set_access >= 0) (void)H5Pclose(top.set_access);
  if (top.group_access >= 0) (void)H5Pclose(top.group_access);
  (void)H5Fclose(top.group);
  return status;
}

static dls_status read_new(dls_fclib **out, const char *path, dls_error *error) {
  if (!out) return dlsi_is_null(error, "out");
  *out = NULL;
  if (!path) return dlsi_is_null(error, "path");
  FILE *probe = dlsi_file_open(path, error);
  if (!probe) return DLS_E_FILE;
  (void)fclose(probe);
  dls_fclib *file = dlsi_alloc(1, sizeof *file);
  if (!file) return dlsi_no_memory(error);
  *file = (dls_fclib){0};
  const dls_status status = read_file(file, path, error);
  if (status)
    dls_fclib_destroy(file);
  else
    *out = file;
  return status;
}

dls_status dls_fclib_read(dls_fclib **out, const char *path, dls_error *error) {
  DLSI_DOOR;
  dls_status status;
  dlsi_lock();
  H5E_BEGIN_TRY {
    status = read_new(out, path, error);
  }
  H5E_END_TRY;
  dlsi_unlock();
  return dlsi_at(__func__, status, error);
}

/* ---- what was read --------------------------------------------------------------------------- */

int dls_fclib_is_global(const dls_fclib *file) {
  return file && file->global;
}

const char *dls_fclib_title(const dls_fclib *file) {
  return file && file->title ? file->title : "";
}

/* Checks that the file holds a problem of the wanted kind. */
static dls_status check_kind(const dls_fclib *file, int global, dls_error *error) {
  if (!file) return dlsi_is_null(error, "file");
  if (file->global == global) return DLS_OK;
  return dlsi_fail(error, DLS_E_ARGUMENT, "file", -1, 0, "holds a %s problem",
                   file->global ? "global" : "local");
}

dls_status dls_fclib_contact(const dls_fclib *file, dls_contact *problem, dls_error *error) {
  DLSI_DOOR;
  dls_status status = check_kind(file, 0, error);
  if (!status && !problem) status = dlsi_is_null(error, "problem");
  if (status) return dlsi_at(__func__, status, error);
  *problem = (dls_contact){.d = file->d, .nc = file->nc, .q = file->q, .mu = file->mu};
  problem->Wb = (dls_blocks){file->d, file->nc, file->W.p, file->W.i, file->W.x};
  return DLS_OK;
}

dls_status dls_fclib_model(const dls_fclib *file, dls_model *model, const double **f,
                           const double **g, const double **mu, dls_error *error) {
  DLSI_DOOR;
  dls_status status = check_kind(file, 1, error);
  if (!status && !model) status = dlsi_is_null(error, "model");
  if (!status && !f) status = dlsi_is_null(error, "f");
  if (!status && !g) status = dlsi_is_null(error, "g");
  if (!status && !mu) status = dlsi_is_null(error, "mu");
  if (status) return dlsi_at(__func__, status, error);
  *model = (dls_model){.d = file->d, .n = file->n, .nodes = file->nc};
  model->operator_kind = DLS_STIFFNESS_SPARSE;
  model->factorization = DLS_LU;
  model->triangular = 1; /* a file holds the whole of M */
  model->Ks = dlsi_columns_view(&file->M);
  model->HN = dlsi_columns_view(&file->HN);
  model->HT = dlsi_columns_view(&file->HT);
  *f = file->f;
  *g = file->q;
  *mu = file->mu;
  return DLS_OK;
}

dls_status dls_fclib_bodies(const dls_fclib *file, dls_contact *problem, dls_error *error) {
  DLSI_DOOR;
  dls_status status = check_kind(file, 1, error);
  if (!status && !problem) status = dlsi_is_null(error, "problem");
  if (!status && !file->bodies.body)
    status = dlsi_fail(error, DLS_E_UNSUPPORTED, "file", -1, 0,
                       "holds no problem of rigid bodies; dls_fclib_model hands it out");
  if (status) return dlsi_at(__func__, status, error);
  const dlsi_fclib_bodies *B = &file->bodies;
  *problem = (dls_contact){.d = file->d, .nc = file->nc, .q = B->q, .mu = file->mu};
  problem->bodies = (dls_bodies){B->n, B->count, B->body, B->H, NULL};
  return DLS_OK;
}

dls_status dls_fclib_solution(const dls_fclib *file, const double **r, const double **u,
                              dls_error *error) {
  DLSI_DOOR;
  dls_status status = file ? DLS_OK : dlsi_is_null(error, "file");
  if (!status && !r) status = dlsi_is_null(error, "r");
  if (!status && !u) status = dlsi_is_null(error, "u");
  if (status) return dlsi_at(__func__, status, error);
  *r = file->r;
  *u = file->u;
  return DLS_OK;
}

void dls_fclib_destroy(dls_fclib *file) {
  if (!file) return;
  free(file->title);
  dlsi_columns_free(&file->W);
  dlsi_columns_free(&file->M);
  dlsi_columns_free(&file->HN);
  dlsi_columns_free(&file->HT);
  dlsi_fclib_bodies_free(&file->bodies);
  free(file->f);
  free(file->q);
  free(file->mu);
  free(file->r);
  free(file->u);
  free(file);
}
