/* fuzz_files.c: files of any bytes through every reader, and FCLIB files that HDF5 has made with
 * odd types, sizes and layouts. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>
#ifdef DLS_WITH_HDF5
#include <hdf5.h>
#endif

#include "delassus.h"
#include "files/file.h"
#include "fuzz.h"

/* ---- FCLIB ----------------------------------------------------------------------------------- */

static void read_fclib(const char *path) {
  dls_fclib *file;
  dls_error error;
  dls_contact contact;
  dls_model model;
  const double *f, *g, *mu, *r, *u;
  const dls_status status = dls_fclib_read(&file, path, &error);
  FUZZ_CHECK((status == DLS_OK) == (file != NULL));
  if (status) {
    FUZZ_CHECK(error.status == status && error.message[0] != '\0');
    return;
  }
  FUZZ_CHECK(strlen(dls_fclib_title(file)) < 2 * fuzz_most);
  FUZZ_CHECK(dls_fclib_solution(file, &r, &u, &error) == DLS_OK);
  if (dls_fclib_is_global(file)) {
    FUZZ_CHECK(dls_fclib_model(file, &model, &f, &g, &mu, &error) == DLS_OK);
    if (model.n > 0) FUZZ_CHECK(dls_model_check(&model, &error) == DLS_OK);
  } else {
    FUZZ_CHECK(dls_fclib_contact(file, &contact, &error) == DLS_OK);
    if (contact.nc > 0) FUZZ_CHECK(dls_contact_check(&contact, &error) == DLS_OK);
  }
  dls_fclib_destroy(file);
}

void fuzz_fclib(const unsigned char *data, size_t size) {
  read_fclib(fuzz_file(data, size));
}

#ifdef DLS_WITH_HDF5

/* Makes the type that a data set is stored with, mostly `usual`. */
static hid_t odd_type(fuzz_bytes *b, hid_t usual) {
  const int kind = take_byte(b);
  hid_t type = H5Tcopy(usual);
  if (kind < 200) return type;
  (void)H5Tclose(type);
  switch (kind % 9) {
  case 0:
    return H5Tcopy(H5T_STD_I8BE);
  case 1:
    return H5Tcopy(H5T_STD_U64BE);
  case 2:
    return H5Tcopy(H5T_IEEE_F32BE);
  case 3: {
    type = H5Tcopy(H5T_STD_I32LE);
    (void)H5Tset_size(type, (size_t)take_int(b, 1, 600));
    return type;
  }
  case 4: {
    type = H5Tcopy(H5T_C_S1);
    (void)H5Tset_size(type, take_byte(b) < 128 ? H5T_VARIABLE : (size_t)take_int(b, 1, 300));
    return type;
  }
  case 5:
    return H5Tvlen_create(H5T_STD_I32LE);
  case 6: {
    const hsize_t n = (hsize_t)take_int(b, 1, 9);
    return H5Tarray_create2(usual, 1, &n);
  }
  case 7:
    return H5Tenum_create(H5T_STD_I32LE);
  default:
    return H5Tcreate(H5T_OPAQUE, (size_t)take_int(b, 1, 40));
  }
}

/* Creates a data set of `count` values x, or of an odd type, size or layout. */
static void put_odd(hid_t file, const char *name, fuzz_bytes *b, hid_t usual, hid_t memory,
                    int count, const void *x) {
  if (take_byte(b) < 6) return; /* it is not there */
  hsize_t n[2] = {(hsize_t)count, 1}, most[2] = {H5S_UNLIMITED, H5S_UNLIMITED}, chunk[2] = {1, 1};
  const int odd = take_byte(b), layout = take_byte(b), written = take_byte(b) >= 8;
  if (odd < 10) n[0] = (hsize_t)take_int(b, 0, 3000);
  if (odd < 2) n[0] = (hsize_t)1 << take_int(b, 20, 62);
  const int rank = odd >= 250 ? 2 : odd >= 246 && count == 1 ? 0 : 1;
  const hid_t create = H5Pcreate(H5P_DATASET_CREATE), link = H5Pcreate(H5P_LINK_CREATE);
  (void)H5Pset_create_intermediate_group(link, 1);
  if (layout < 40 && rank > 0) {
    chunk[0] = layout < 4 ? (hsize_t)1 << take_int(b, 10, 18) : (hsize_t)take_int(b, 1, 64);
    (void)H5Pset_chunk(create, rank, chunk);
    if (layout % 2) (void)H5Pset_deflate(create, 1);
  } else if (layout < 60)
    (void)H5Pset_layout(create, H5D_COMPACT);
  const hid_t type = odd_type(b, usual);
  const hid_t space =
      rank ? H5Screate_simple(rank, n, layout < 40 ? most : NULL) : H5Screate(H5S_SCALAR);
  const hid_t set = H5Dcreate2(file, name, type, space, link, create, H5P_DEFAULT);
  /* values are written where the set has as many as there are */
  if (set >= 0 && written && (odd >= 10 || n[0] == (hsize_t)count))
    (void)H5Dwrite(set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, x);
  if (set >= 0) (void)H5Dclose(set);
  if (space >= 0) (void)H5Sclose(space);
  if (type >= 0) (void)H5Tclose(type);
  (void)H5Pclose(create);
  (void)H5Pclose(link);
}

static void put_odd_ints(hid_t file, const char *name, fuzz_bytes *b, int count, int *x) {
  if (take_byte(b) < 16 && count > 0) x[take_byte(b) % count] = take_int(b, -3, 100000);
  put_odd(file, name, b, H5T_STD_I32LE, H5T_NATIVE_INT, count, x);
}

static void put_odd_doubles(hid_t file, const char *name, fuzz_bytes *b, int count) {
  double x[64];
  for (int k = 0; k < count; k++)
    x[k] = take_value(b);
  put_odd(file, name, b, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, count, x);
}

/* Puts a matrix rows x cols of a few entries in one of the three forms. */
static void put_odd_matrix(hid_t file, const char *group, fuzz_bytes *b, int rows, int cols) {
  char name[64];
  int form = take_int(b, -2, 0), entries = take_int(b, 0, 20), p[64], i[64];
  const int lines = form == -2 ? rows : cols, bound = form == -2 ? cols : rows;
  if (form == 0) form = entries;
  for (int k = 0; k < entries; k++)
    i[k] = bound ? take_byte(b) % bound : 0;
  for (int k = 0; k <= lines; k++)
    p[k] = k * entries / (lines ? lines : 1);
  for (int k = 0; form >= 0 && k < entries; k++)
    p[k] = cols ? take_byte(b) % cols : 0;
#define PUT(what, count, x)                                                                        \
  ((void)snprintf(name, sizeof name, "%s/" what, group), put_odd_ints(file, name, b, count, x))
  PUT("m", 1, &rows);
  PUT("n", 1, &cols);
  PUT("nz", 1, &form);
  PUT("p", form >= 0 ? entries : lines + 1, p);
  PUT("i", entries, i);
  PUT("nzmax", 1, &entries);
#undef PUT
  (void)snprintf(name, sizeof name, "%s/x", group);
  if (entries > 20 || entries < 0) entries = 20; /* put_odd_ints may have changed it */
  put_odd_doubles(file, name, b, entries);
}

/* Builds a file in memory and reads it. */
static void read_odd_file(fuzz_bytes *b) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  (void)H5Pset_fapl_core(access, (size_t)1 << 16, 0);
  if (take_byte(b) < 60) (void)H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  const hid_t file = H5Fcreate("fuzz-in-memory", H5F_ACC_TRUNC, H5P_DEFAULT, access);
  if (file < 0) abort();
  int d = take_int(b, 2, 3), nc = take_int(b, 0, 4);
  const int m = d * nc, n = take_int(b, 0, 9), global = take_byte(b) & 1;
  put_odd_ints(file, global ? "fclib_global/spacedim" : "fclib_local/spacedim", b, 1, &d);
  if (global) {
    put_odd_matrix(file, "fclib_global/M", b, n, n);
    put_odd_matrix(file, "fclib_global/H", b, n, m);
    put_odd_doubles(file, "fclib_global/vectors/f", b, n);
    put_odd_doubles(file, "fclib_global/vectors/w", b, m);
    put_odd_doubles(file, "fclib_global/vectors/mu", b, nc);
  } else {
    put_odd_matrix(file, "fclib_local/W", b, m, m);
    put_odd_doubles(file, "fclib_local/vectors/q", b, m);
    put_odd_doubles(file, "fclib_local/vectors/mu", b, nc);
    if (take_byte(b) < 20) put_odd_matrix(file, "fclib_local/V", b, m, take_int(b, 0, 3));
  }
  if (take_byte(b) < 100) {
    put_odd_doubles(file, "solution/r", b, m);
    put_odd_doubles(file, "solution/u", b, m);
  }
  if (take_byte(b) < 100)
    put_odd(file, global ? "fclib_global/info/title" : "fclib_local/info/title", b, H5T_C_S1,
            H5T_C_S1, 1, "t");
  (void)H5Fflush(file, H5F_SCOPE_GLOBAL);
  const ssize_t size = H5Fget_file_image(file, NULL, 0);
  /* what HDF5 itself makes large is no small file */
  unsigned char *image = size > 0 && size < (1 << 20) ? malloc((size_t)size) : NULL;
  if (image) (void)H5Fget_file_image(file, image, (size_t)size);
  (void)H5Fclose(file);
  (void)H5Pclose(access);
  if (image) read_fclib(fuzz_file(image, (size_t)size));
  free(image);
}

void fuzz_fclib_sets(const unsigned char *data, size_t size) {
  fuzz_bytes b = {data, size};
  H5E_BEGIN_TRY {
    read_odd_file(&b);
  }
  H5E_END_TRY;
}

#else

void fuzz_fclib_sets(const unsigned char *data, size_t size) {
  (void)data, (void)size;
}

#endif

/* ---- text ------------------------------------------------------------------------------------ */

static void check_columns(const dls_sparse *A) {
  FUZZ_CHECK(A->rows > 0 && A->cols > 0 && A->p[0] == 0);
  for (int j = 0; j < A->cols; j++)
    FUZZ_CHECK(A->p[j] <= A->p[j + 1]);
  for (int k = 0; k < A->p[A->cols]; k++)
    FUZZ_CHECK(A->i[k] >= 0 && A->i[k] < A->rows && A->x[k] - A->x[k] == 0);
}

void fuzz_mtx(const unsigned char *data, size_t size) {
  const char *path = fuzz_file(data, size);
  int rows = -1, cols = -1, symmetric = 0;
  double *a;
  dls_sparse A = {0};
  const dls_status status = dls_mtx_read(path, &rows, &cols, &a, NULL);
  FUZZ_CHECK((status == DLS_OK) == (a != NULL) && (status == DLS_OK) == (rows > 0 && cols > 0));
  if (!status)
    for (size_t k = 0; k < (size_t)rows * (size_t)cols; k++)
      FUZZ_CHECK(a[k] - a[k] == 0);
  dls_mtx_free(a);
  for (int triplets = 0; triplets < 2; triplets++) { /* of whatever format */
    int *labels = NULL;
    if (dls_matrix_read(path, triplets, &A, &symmetric, &labels, NULL) == DLS_OK) check_columns(&A);
    dls_mtx_free_sparse(&A);
    dls_matrix_free_labels(labels);
  }
}

void fuzz_calculix(const unsigned char *data, size_t size) {
  dls_sparse A = {0};
  dlsi_triplets t = {0};
  if (dlsi_mtx_read_file(fuzz_file(data, size), 1, &t, NULL, NULL) == DLS_OK &&
      dlsi_mtx_columns(&t, &A, NULL) == DLS_OK)
    check_columns(&A);
  dlsi_triplets_free(&t);
  dls_mtx_free_sparse(&A);
}

/* Reads a problem and solves it where it is small. */
void fuzz_text(const unsigned char *data, size_t size) {
  dls_text *text;
  dls_contact contact;
  if (dls_text_read(&text, fuzz_file(data, size), NULL)) return;
  const char *key;
  for (int k = 0; dlsi_text_line(text, k, &key); k++)
    FUZZ_CHECK(strlen(key) < size);
  if (dls_text_is_lcp(text)) {
    int n;
    const double *M, *q;
    FUZZ_CHECK(dls_text_lcp(text, &n, &M, &q, NULL) == DLS_OK && n > 0);
    const dls_lcp lcp = {.n = n, .M = {n, n, n, M}, .q = q};
    FUZZ_CHECK(dls_lcp_check(&lcp, NULL) == DLS_OK);
  } else {
    FUZZ_CHECK(dls_text_contact(text, &contact, NULL) == DLS_OK);
    FUZZ_CHECK(dls_contact_check(&contact, NULL) == DLS_OK);
    fuzz_bytes end = {data, 0};
    if (contact.nc <= 6) fuzz_solve(&contact, &end);
  }
  dls_text_destroy(text);
}
