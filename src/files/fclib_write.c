/*
 * fclib_write.c: contact problems to FCLIB files; layout: fclib_read.c.
 *
 * The file is built in HDF5's memory and written in one piece, so that a failure leaves no half file and
 * no handle behind, and the same problem gives the same bytes.
 */
#include <hdf5.h>
#include <limits.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/columns.h"
#include "delassus/files.h"
#include "files/fclib_internal.h"
#include "files/file.h"

/* ---- matrices to write ----------------------------------------------------------------------- */

static dls_status too_many(const char *argument, dls_error *error) {
  return dlsi_fail(error, DLS_E_SIZE, argument, -1, 0, "has more entries than an int can count");
}

/* C := the entries of A that are not zero; with `lower`, the upper triangle is the lower one's */
static dls_status columns_of_dense(const char *argument, const dls_dense *A, int lower,
                                   dlsi_columns *C, dls_error *error) {
  const size_t ld = (size_t)A->ld;
  long long count = 0;
  for (int pass = 0; pass < 2; pass++) {
    if (pass == 1) {
      if (count > INT_MAX) return too_many(argument, error);
      const dls_status status = dlsi_columns_alloc(A->rows, A->cols, (int)count, C, error);
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
static dls_status columns_of_blocks(const dls_blocks *B, dlsi_columns *C, dls_error *error) {
  const int d = B->d, m = d * B->n;
  if (B->p[B->n] > INT_MAX / (d * d)) return too_many("Wb", error);
  const dls_status status = dlsi_columns_alloc(m, m, d * d * B->p[B->n], C, error);
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
static dls_status columns_of_lower(const dls_sparse *K, dlsi_columns *C, dls_error *error) {
  long long count = 0;
  for (int j = 0; j < K->cols; j++)
    for (int k = K->p[j]; k < K->p[j + 1]; k++)
      count += K->i[k] > j ? 2 : K->i[k] == j;
  if (count > INT_MAX) return too_many("Ks", error);
  dlsi_triplets t = {K->rows,
                     K->cols,
                     0,
                     dlsi_alloc((size_t)count, sizeof *t.row),
                     dlsi_alloc((size_t)count, sizeof *t.col),
                     dlsi_alloc((size_t)count, sizeof *t.x)};
  dls_status status = t.row && t.col && t.x ? DLS_OK : dlsi_no_memory(error);
  for (int j = 0; !status && j < K->cols; j++)
    for (int k = K->p[j]; k < K->p[j + 1]; k++) {
      const int i = K->i[k];
      for (int mirror = 0; mirror < (i > j ? 2 : i == j); mirror++) {
        t.row[t.count] = mirror ? j : i;
        t.col[t.count] = mirror ? i : j;
        t.x[t.count++] = K->x[k];
      }
    }
  if (!status) status = dlsi_columns_compress(&t, 1, DLSI_ALL, C, error);
  dlsi_triplets_free(&t);
  return status;
}

/* C := H, the columns of H_N and H_T candidate by candidate */
static dls_status columns_of_operators(const dls_model *model, dlsi_columns *C, dls_error *error) {
  const int d = model->d, nc = model->nodes;
  const dls_sparse *HN = &model->HN, *HT = &model->HT;
  const int tangents = (d - 1) * nc;
  if (HN->p[nc] > INT_MAX - HT->p[tangents]) return too_many("HT", error);
  const dls_status status =
      dlsi_columns_alloc(model->n, d * nc, HN->p[nc] + HT->p[tangents], C, error);
  if (status) return status;
  int count = 0;
  for (int col = 0; col < d * nc; col++) {
    const dls_sparse *A = col % d == 0 ? HN : HT;
    const int j = dlsi_column_of(d, col % d == 0 ? DLSI_NORMALS : DLSI_TANGENTS, col);
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
static dls_status save(sink *s, const char *path, dls_error *error) {
  ssize_t size = -1;
  if (!s->failed && H5Fflush(s->file, H5F_SCOPE_GLOBAL) >= 0)
    size = H5Fget_file_image(s->file, NULL, 0);
  if (size <= 0) return dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "HDF5 cannot build the file");
  char *image = dlsi_alloc((size_t)size, 1);
  if (!image) return dlsi_no_memory(error);
  dls_status status = DLS_OK;
  FILE *file = NULL;
  if (H5Fget_file_image(s->file, image, (size_t)size) != size)
    status = dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "HDF5 cannot build the file");
  if (!status) {
    file = fopen(path, "wb");
    if (!file) status = dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "cannot be opened for writing");
  }
  if (file) {
    (void)fwrite(image, 1, (size_t)size, file); /* a short count sets the file's error */
    status = dlsi_file_finish(path, file, error);
  }
  free(image);
  return status;
}

/* r and u of m values each, or neither */
static dls_status check_solution(const double *r, const double *u, size_t m, dls_error *error) {
  if (!r && !u) return DLS_OK;
  const dls_status status = dlsi_check_vector("r", r, m, error);
  return status ? status : dlsi_check_vector("u", u, m, error);
}

static dls_status write_local(const char *path, const dls_contact *problem, const char *title,
                              const double *r, const double *u, dls_error *error) {
  const int m = problem->d * problem->nc;
  dlsi_columns W = {0};
  dls_status status = problem->Wb.x ? columns_of_blocks(&problem->Wb, &W, error)
                                    : columns_of_dense("W", &problem->W, 0, &W, error);
  if (!status) {
    const dls_sparse A = dlsi_columns_view(&W);
    sink s;
    sink_open(&s, path);
    put_common(&s, &names_local, problem->d, problem->nc, problem->mu, title);
    put_matrix(&s, &local_W, &A);
    put_doubles(&s, "fclib_local/vectors/q", (size_t)m, problem->q);
    put_solution(&s, 0, NULL, m, r, u);
    status = save(&s, path, error);
    sink_close(&s);
  }
  dlsi_columns_free(&W);
  return status;
}

dls_status dls_fclib_write_local(const char *path, const dls_contact *problem, const char *title,
                                 const double *r, const double *u, dls_error *error) {
  if (!path) return dlsi_at(__func__, dlsi_is_null(error, "path"), error);
  dls_status status = dlsi_check_contact(problem, error);
  if (status) return dlsi_at(__func__, status, error);
  status = check_solution(r, u, (size_t)problem->d * (size_t)problem->nc, error);
  if (status) return dlsi_at(__func__, status, error);
  H5E_BEGIN_TRY {
    status = write_local(path, problem, title, r, u, error);
  }
  H5E_END_TRY;
  return dlsi_at(__func__, status, error);
}

static dls_status write_global(const char *path, const dls_model *model, const double *f,
                               const double *g, const double *mu, const char *title,
                               const double *x, const double *r, const double *u,
                               dls_error *error) {
  const int m = model->d * model->nodes, symmetric = model->factorization != DLS_LU;
  dlsi_columns K = {0}, H = {0}; /* K: unless the model's own columns serve as they are */
  dls_status status = DLS_OK;
  if (model->operator_kind == DLS_STIFFNESS_DENSE)
    status = columns_of_dense("K", &model->K, symmetric, &K, error);
  else if (symmetric)
    status = columns_of_lower(&model->Ks, &K, error);
  if (!status) status = columns_of_operators(model, &H, error);
  if (!status) {
    const dls_sparse M = K.p ? dlsi_columns_view(&K) : model->Ks, A = dlsi_columns_view(&H);
    sink s;
    sink_open(&s, path);
    put_common(&s, &names_global, model->d, model->nodes, mu, title);
    put_matrix(&s, &global_M, &M);
    put_matrix(&s, &global_H, &A);
    put_doubles(&s, "fclib_global/vectors/f", (size_t)model->n, f);
    put_doubles(&s, "fclib_global/vectors/w", (size_t)m, g);
    put_solution(&s, model->n, x, m, r, u);
    status = save(&s, path, error);
    sink_close(&s);
  }
  dlsi_columns_free(&K);
  dlsi_columns_free(&H);
  return status;
}

/* What this file can hold of a model: no P, no operator but K itself. */
static dls_status check_model(const dls_model *model, dls_error *error) {
  if (!model) return dlsi_is_null(error, "model");
  const int d = model->d, n = model->n, nodes = model->nodes;
  if (d != 2 && d != 3)
    return dlsi_fail(error, DLS_E_ARGUMENT, "d", -1, d, "is %d, must be 2 or 3", d);
  if (n < 1) return dlsi_fail(error, DLS_E_SIZE, "n", -1, n, "is %d", n);
  if (nodes < 1 || nodes > INT_MAX / d)
    return dlsi_fail(error, DLS_E_SIZE, "nodes", -1, nodes, "is %d", nodes);
  if (model->P.p) return dlsi_fail(error, DLS_E_UNSUPPORTED, "P", -1, 0, "FCLIB has no weighting");
  if (model->active)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "active", -1, 0,
                     "FCLIB has no candidates that are left out");
  if (model->operator_kind != DLS_STIFFNESS_DENSE && model->operator_kind != DLS_STIFFNESS_SPARSE)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "operator_kind", -1, model->operator_kind,
                     "FCLIB holds K only");
  dls_status status = model->operator_kind == DLS_STIFFNESS_DENSE
                          ? dlsi_check_dense("K", &model->K, n, n, error)
                          : dlsi_check_sparse("Ks", &model->Ks, n, n, error);
  if (!status) status = dlsi_check_sparse("HN", &model->HN, n, nodes, error);
  if (!status) status = dlsi_check_sparse("HT", &model->HT, n, (d - 1) * nodes, error);
  return status;
}

dls_status dls_fclib_write_global(const char *path, const dls_model *model, const double *f,
                                  const double *g, const double *mu, const char *title,
                                  const double *x, const double *r, const double *u,
                                  dls_error *error) {
  if (!path) return dlsi_at(__func__, dlsi_is_null(error, "path"), error);
  dls_status status = check_model(model, error);
  if (status) return dlsi_at(__func__, status, error);
  const size_t n = (size_t)model->n, nc = (size_t)model->nodes, m = (size_t)model->d * nc;
  status = dlsi_check_vector("f", f, n, error);
  if (!status) status = dlsi_check_vector("g", g, m, error);
  if (!status) status = dlsi_check_vector("mu", mu, nc, error);
  if (!status && x) status = dlsi_check_vector("x", x, n, error);
  if (!status) status = check_solution(r, u, m, error);
  if (status) return dlsi_at(__func__, status, error);
  for (size_t c = 0; c < nc; c++)
    if (mu[c] < 0)
      return dlsi_at(__func__,
                     dlsi_fail(error, DLS_E_ARGUMENT, "mu", (long long)c, mu[c], "is negative"),
                     error);
  H5E_BEGIN_TRY {
    status = write_global(path, model, f, g, mu, title, x, r, u, error);
  }
  H5E_END_TRY;
  return dlsi_at(__func__, status, error);
}
