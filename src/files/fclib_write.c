/*
 * fclib_write.c: writes contact problems to FCLIB files; fclib_read.c describes the layout.
 *
 * HDF5 builds the file in memory, then one write puts it on the disk: a failure leaves no half file
 * and no handle behind, and the same problem gives the same bytes.
 */
#include <hdf5.h>
#include <limits.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "contact/columns.h"
#include "delassus/files.h"
#include "files/fclib_internal.h"
#include "files/fclib_joints.h"
#include "files/file.h"
#include "files/output.h"

/* ---- matrices to write ----------------------------------------------------------------------- */

static dls_status too_many(const char *argument, dls_error *error) {
  return dlsi_fail(error, DLS_E_SIZE, argument, -1, 0, "has more entries than an int can count");
}

/* The columns of a matrix, which a column_fn adds entry by entry: twice, to count and to fill. */
typedef struct builder {
  dlsi_columns *C; /* C->i: NULL while counting */
  long long count;
} builder;

typedef void (*column_fn)(const void *source, int j, builder *b);

static void add_entry(builder *b, int i, double x) {
  if (b->C->i) {
    b->C->i[b->count] = i;
    b->C->x[b->count] = x;
  }
  b->count++;
}

/* Builds C (rows x cols) column by column. Errors call the source `argument`. */
static dls_status build_columns(const char *argument, int rows, int cols, column_fn column,
                                const void *source, dlsi_columns *C, dls_error *error) {
  builder count = {.C = C}, fill = {.C = C};
  for (int j = 0; j < cols; j++)
    column(source, j, &count);
  if (count.count > INT_MAX) return too_many(argument, error);
  const dls_status status = dlsi_columns_alloc(rows, cols, (int)count.count, C, error);
  if (status) return status;
  for (int j = 0; j < cols; j++) {
    C->p[j] = (int)fill.count;
    column(source, j, &fill);
  }
  C->p[cols] = (int)fill.count;
  return DLS_OK;
}

/* Adds the entries of column j of a dense matrix that are not 0. */
static void column_of_dense(const void *source, int j, builder *b) {
  const dls_dense *A = source;
  for (int i = 0; i < A->rows; i++) {
    const double x = A->a[(size_t)i + (size_t)j * (size_t)A->ld];
    if (x != 0) add_entry(b, i, x);
  }
}

/* Adds the entries of column j that are not 0 of a symmetric dense matrix, reading its lower
 * triangle. */
static void column_of_symmetric(const void *source, int j, builder *b) {
  const dls_dense *A = source;
  for (int i = 0; i < A->rows; i++) {
    const size_t row = (size_t)(i < j ? j : i), col = (size_t)(i < j ? i : j);
    const double x = A->a[row + col * (size_t)A->ld];
    if (x != 0) add_entry(b, i, x);
  }
}

/* Adds every entry of every block in column j. */
static void column_of_blocks(const void *source, int j, builder *b) {
  const dls_blocks *B = source;
  const int d = B->d;
  for (int k = B->p[j / d]; k < B->p[j / d + 1]; k++)
    for (int i = 0; i < d; i++)
      add_entry(b, d * B->i[k] + i, B->x[(size_t)k * (size_t)(d * d) + (size_t)(i + d * (j % d))]);
}

/* Adds column j of H, whose columns are those of H_N and H_T contact by contact. */
static void column_of_operators(const void *source, int j, builder *b) {
  const dls_model *model = source;
  const int normal = j % model->d == 0;
  const dls_sparse *A = normal ? &model->HN : &model->HT;
  const int col = dlsi_column_of(model->d, normal ? DLSI_NORMALS : DLSI_TANGENTS, j);
  for (int k = A->p[col]; k < A->p[col + 1]; k++)
    add_entry(b, A->i[k], A->x[k]);
}

/* Gathers K into C from its lower triangle, mirrored. */
static dls_status columns_of_lower(const dls_sparse *K, dlsi_columns *C, dls_error *error) {
  long long count = 0;
  for (int j = 0; j < K->cols; j++)
    for (int k = K->p[j]; k < K->p[j + 1]; k++)
      count += K->i[k] > j ? 2 : K->i[k] == j;
  if (count > INT_MAX) return too_many("Ks", error);
  dlsi_triplets t = {.rows = K->rows, .cols = K->cols};
  t.row = dlsi_alloc((size_t)count, sizeof *t.row);
  t.col = dlsi_alloc((size_t)count, sizeof *t.col);
  t.x = dlsi_alloc((size_t)count, sizeof *t.x);
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

/* ---- writing --------------------------------------------------------------------------------- */

/* A file under construction, in memory: HDF5 does not recover well from a full disk. */
typedef struct sink {
  hid_t file, link, create;
  const char *group; /* for data sets: "fclib_local/", .. */
  int failed;        /* 1: a step failed, and the others do nothing */
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

/* Puts a data set of type `stored` into the group, from values x of type `type`; x NULL: no
 * values. */
static void put_set(sink *s, const char *name, hid_t stored, hid_t type, hid_t space,
                    const void *x) {
  char path[64];
  (void)snprintf(path, sizeof path, "%s%s", s->group, name);
  if (s->failed) return;
  s->failed = 1;
  const hid_t set = H5Dcreate2(s->file, path, stored, space, s->link, s->create, H5P_DEFAULT);
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

/* Puts a text with its terminating zero, which FCLIB's own reader needs. */
static void put_text(sink *s, const char *name, const char *text) {
  const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  if (H5Tset_size(type, strlen(text) + 1) < 0) s->failed = 1;
  put_set(s, name, type, type, space, text);
  if (type >= 0) (void)H5Tclose(type);
  if (space >= 0) (void)H5Sclose(space);
}

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

/* Saves the image of the file from memory to `path`. */
static dls_status save_image(sink *s, const char *path, dls_error *error) {
  ssize_t size = -1;
  if (!s->failed && H5Fflush(s->file, H5F_SCOPE_GLOBAL) >= 0)
    size = H5Fget_file_image(s->file, NULL, 0);
  char *image = size > 0 ? dlsi_alloc((size_t)size, 1) : NULL;
  if (size > 0 && !image) return dlsi_no_memory(error);
  dls_status status = DLS_OK;
  if (!image || H5Fget_file_image(s->file, image, (size_t)size) != size)
    status = dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "HDF5 cannot build the file");
  dlsi_output out;
  if (!status) status = dlsi_output_open(&out, path, error);
  if (!status) {
    (void)fwrite(image, 1, (size_t)size, out.file); /* a short count sets the file's error */
    status = dlsi_output_finish(&out, error);
  }
  free(image);
  return status;
}

/* A problem and its solution, as written to a file. */
typedef struct contents {
  const char *path, *group, *title;
  const char *name_of_q; /* in the file */
  const double *q;       /* d nc */
  const double *mu;      /* nc */
  const double *x, *f;   /* n each; NULL: none */
  const double *l, *b;   /* joints each; NULL: none */
  const double *r, *u;   /* d nc each; NULL: none */
  int d, nc, n, joints;  /* n: length of x and f */
} contents;

/* Writes the contents and `count` matrices. */
static dls_status write_contents(const contents *c, int count, const matrix_names *const *name,
                                 const dls_sparse *A, dls_error *error) {
  const size_t n = (size_t)c->n, nc = (size_t)c->nc, m = (size_t)c->d * nc;
  sink s = {.group = c->group};
  sink_open(&s, c->path);
  put_ints(&s, "spacedim", 1, &c->d);
  put_doubles(&s, "vectors/mu", nc, c->mu);
  if (c->title && c->title[0]) put_text(&s, "info/title", c->title);
  put_text(&s, "info/description", "written by delassus " DLS_VERSION);
  put_text(&s, "info/math_info", "unknown");
  for (int k = 0; k < count; k++)
    put_matrix(&s, name[k], &A[k]);
  if (c->f) put_doubles(&s, "vectors/f", n, c->f);
  if (c->b) put_doubles(&s, "vectors/b", (size_t)c->joints, c->b);
  put_doubles(&s, c->name_of_q, m, c->q);
  s.group = "solution/";
  if (c->x) put_doubles(&s, "v", n, c->x);
  if (c->l) put_doubles(&s, "l", (size_t)c->joints, c->l);
  if (c->r) put_doubles(&s, "r", m, c->r);
  if (c->u) put_doubles(&s, "u", m, c->u);
  const dls_status status = save_image(&s, c->path, error);
  sink_close(&s);
  return status;
}

/* Checks r and u, of m values each; both may be NULL. */
static dls_status check_solution(const double *r, const double *u, size_t m, dls_error *error) {
  if (!r && !u) return DLS_OK;
  const dls_status status = dlsi_check_vector("r", r, m, error);
  return status ? status : dlsi_check_vector("u", u, m, error);
}

static dls_status write_local(contents *c, const dls_contact *problem, dls_error *error) {
  static const matrix_names *const name = &names_W;
  if (!c->path) return dlsi_is_null(error, "path");
  dls_status status = dlsi_check_contact(problem, error);
  if (!status) status = dlsi_check_vector("mu", problem->mu, (size_t)problem->nc, error);
  if (status) return status;
  if (problem->d == 1)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "d", -1, 1, "is 1; the format knows 2 and 3");
  c->d = problem->d, c->nc = problem->nc, c->q = problem->q, c->mu = problem->mu;
  const int m = c->d * c->nc;
  status = check_solution(c->r, c->u, (size_t)m, error);
  if (status) return status;
  dlsi_columns W = {0};
  status = problem->Wb.x ? build_columns("Wb", m, m, column_of_blocks, &problem->Wb, &W, error)
                         : build_columns("W", m, m, column_of_dense, &problem->W, &W, error);
  const dls_sparse A = dlsi_columns_view(&W);
  if (!status) status = write_contents(c, 1, &name, &A, error);
  dlsi_columns_free(&W);
  return status;
}

dls_status dls_fclib_write_local(const char *path, const dls_contact *problem, const char *title,
                                 const double *r, const double *u, dls_error *error) {
  DLSI_DOOR;
  contents c = {path, "fclib_local/", title, "vectors/q", .r = r, .u = u};
  dlsi_formed formed = {.work = NULL};
  dls_status status = dlsi_form_blocks(&formed, &problem, error);
  dlsi_lock();
  H5E_BEGIN_TRY {
    if (!status) status = write_local(&c, problem, error);
  }
  H5E_END_TRY;
  dlsi_unlock();
  dlsi_formed_free(&formed);
  return dlsi_at(__func__, status, error);
}

/* Checks a model, and refuses models that an FCLIB file cannot hold: with P, inactive contacts, or
 * no K. */
static dls_status check_storable(const dls_model *model, dls_error *error) {
  if (!model) return dlsi_is_null(error, "model");
  const int kind = (int)model->operator_kind;
  if (model->P.p) return dlsi_fail(error, DLS_E_UNSUPPORTED, "P", -1, 0, "FCLIB has no weighting");
  if (model->active)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "active", -1, 0,
                     "FCLIB cannot leave candidates out");
  if (kind != DLS_STIFFNESS_DENSE && kind != DLS_STIFFNESS_SPARSE)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "operator_kind", -1, kind, "FCLIB holds K only");
  return dlsi_check_model(model, error);
}

/* Checks the arrays of a global problem. */
static dls_status check_global(const contents *c, dls_error *error) {
  const size_t n = (size_t)c->n, nc = (size_t)c->nc, m = (size_t)c->d * nc;
  dls_status status = dlsi_check_vector("f", c->f, n, error);
  if (!status) status = dlsi_check_vector("g", c->q, m, error);
  if (!status) status = dlsi_check_vector("mu", c->mu, nc, error);
  if (!status) status = dlsi_check_friction(c->mu, nc, error);
  if (!status && c->x) status = dlsi_check_vector("x", c->x, n, error);
  return status ? status : check_solution(c->r, c->u, m, error);
}

/* Sets f and x to those of positions, b and l to those of multipliers, in values (2 n). */
static void split_contents(contents *c, const dlsi_fclib_split *split, double *values) {
  const size_t n = (size_t)c->n, positions = (size_t)split->positions;
  for (size_t k = 0; k < n; k++) {
    values[k] = c->f[split->order[k]];
    values[n + k] = c->x ? c->x[split->order[k]] : 0;
  }
  c->f = values;
  c->b = values + positions;
  c->l = c->x ? values + n + positions : NULL;
  c->x = c->x ? values + n : NULL;
  c->n = split->positions;
  c->joints = split->joints;
}

/* Writes K and H, or their parts if K contains multipliers of joints. */
static dls_status write_matrices(contents *c, const dls_sparse *K, const dls_sparse *H,
                                 dls_error *error) {
  static const matrix_names *const name[3] = {&names_M, &names_H, &names_G};
  dlsi_fclib_split split;
  dls_status status = dlsi_fclib_split_create(&split, K, H, error);
  double *values = dlsi_alloc(2 * (size_t)c->n, sizeof *values);
  if (!status && !values) status = dlsi_no_memory(error);
  if (!status && split.joints > 0) {
    const dls_sparse A[3] = {dlsi_columns_view(&split.M), dlsi_columns_view(&split.H),
                             dlsi_columns_view(&split.G)};
    split_contents(c, &split, values);
    status = write_contents(c, 3, name, A, error);
  } else if (!status) {
    const dls_sparse A[2] = {*K, *H};
    status = write_contents(c, 2, name, A, error);
  }
  free(values);
  dlsi_fclib_split_free(&split);
  return status;
}

static dls_status write_global(contents *c, const dls_model *model, dls_error *error) {
  if (!c->path) return dlsi_is_null(error, "path");
  dls_status status = check_storable(model, error);
  if (status) return status;
  c->d = model->d, c->nc = model->nodes, c->n = model->n;
  status = check_global(c, error);
  if (status) return status;
  dlsi_columns K = {0}, H = {0}; /* K: unless the model's own columns can be written */
  const int n = c->n, symmetric = model->factorization != DLS_LU;
  if (model->operator_kind == DLS_STIFFNESS_DENSE)
    status = build_columns("K", n, n, symmetric ? column_of_symmetric : column_of_dense, &model->K,
                           &K, error);
  else if (symmetric)
    status = columns_of_lower(&model->Ks, &K, error);
  if (!status) status = build_columns("HT", n, c->d * c->nc, column_of_operators, model, &H, error);
  const dls_sparse of_K = K.p ? dlsi_columns_view(&K) : model->Ks, of_H = dlsi_columns_view(&H);
  if (!status) status = write_matrices(c, &of_K, &of_H, error);
  dlsi_columns_free(&K);
  dlsi_columns_free(&H);
  return status;
}

dls_status dls_fclib_write_global(const char *path, const dls_model *model, const double *f,
                                  const double *g, const double *mu, const char *title,
                                  const double *x, const double *r, const double *u,
                                  dls_error *error) {
  DLSI_DOOR;
  contents c = {.path = path,
                .group = "fclib_global/",
                .title = title,
                .name_of_q = "vectors/w",
                .q = g,
                .mu = mu,
                .x = x,
                .f = f,
                .r = r,
                .u = u};
  dls_status status;
  dlsi_lock();
  H5E_BEGIN_TRY {
    status = write_global(&c, model, error);
  }
  H5E_END_TRY;
  dlsi_unlock();
  return dlsi_at(__func__, status, error);
}
