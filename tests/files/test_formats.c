/* test_formats.c: matrices in the formats of other codes, whole, cut short and broken. */
#define _GNU_SOURCE
#include <unistd.h>

#include "delassus/files.h"
#include "files/formats.h"
#include "run.h"

static char path[64];

static void make_matrix(void) {
  (void)snprintf(path, sizeof path, "/tmp/delassus-formats-XXXXXX");
  const int file = mkstemp(path);
  ck_assert_int_ge(file, 0);
  (void)close(file);
}

static void remove_matrix(void) {
  (void)remove(path);
}

static void put_bytes(const void *bytes, size_t size) {
  FILE *file = fopen(path, "w");
  ck_assert_ptr_nonnull(file);
  ck_assert(fwrite(bytes, 1, size, file) == size);
  ck_assert_int_eq(fclose(file), 0);
}

/* The same matrix, 4 -1 0; -1 4 -2; 0 -2 4, in each of the formats. */
static const double wanted[3][3] = {{4, -1, 0}, {-1, 4, -2}, {0, -2, 4}};

#define HB_HEAD                                                                                    \
  "title                                                                   key     \n"             \
  "             3             1             1             1             0\n"
#define HB_FORMATS "(4I2)           (8I2)           (8F4.1)             \n"

static const struct {
  const char *name, *text;
  int triplets, symmetric;
} texts[] = {
    {"triplets from 1", "1 1 4\n1 2 -1\n2 1 -1\n2 2 4\n2 3 -2\n3 2 -2\n3 3 4\n", 1, 0},
    {"triplets from 0", "% c\n0\t0\t4\n0,1,-1\n1;0;-1\n1 1 4\n1 2 -2\n2 1 -2\r\n2 2 4D0\n", 1, 0},
    {"FreeFEM, COO",
     "#  HashMatrix Matrix (COO) 0x1\n#    n       m        nnz     half     fortran   state  \n"
     "3 3 7 0 0 0 0 \n 0 0 4\n 0 1 -1\n 1 0 -1\n 1 1 4\n 1 2 -2\n 2 1 -2\n 2 2 4\n",
     0, 0},
    {"FreeFEM, half",
     "# Sparse Matrix (Morse)  0x1\n# first line: n m (is symmetic) nnz \n# after \n"
     "3 3 1  5\n 1 1 4\n 2 1 -1\n 2 2 4\n 3 2 -2\n 3 3 4\n",
     0, 1},
    {"Octave",
     "# Created by Octave 8.4.0\n# name: K\n# type: sparse matrix\n# nnz: 7\n# rows: 3\n"
     "# columns: 3\n1 1 4\n2 1 -1\n1 2 -1\n2 2 4\n3 2 -2\n2 3 -2\n3 3 4\n\n\n",
     0, 0},
    {"Abaqus, lower",
     "** labels\n5,1, 5,1, 4.\n5,2, 5,1, -1.\n5,2, 5,2, 4.\n7,1, 5,2, -2.\n7,1, 7,1, 4.\n", 0, 1},
    {"Abaqus, both",
     "5,1,5,1,4\n5,2,5,1,-1\n5,1,5,2,-1\n5,2,5,2,4\n7,1,5,2,-2\n5,2,7,1,-2\n7,1,7,1,4\n", 0, 0},
    {"Harwell-Boeing, symmetric",
     HB_HEAD "RSA                        3             3             5             0\n" HB_FORMATS
             " 1 3 5 6\n 1 2 2 3 3\n 4.0-1.0 4.0-2.0 4.0\n",
     0, 1},
    {"Harwell-Boeing",
     HB_HEAD "RUA                        3             3             7             0\n" HB_FORMATS
             " 1 3 6 8\n 1 2 1 2 3 2 3\n  4. -1. -1.  4. -2. -2.  4.\n",
     0, 0},
    {"Harwell-Boeing, numbers at the left of their fields",
     HB_HEAD "RSA                        3             3             5             0\n"
             "(4I3)           (5I2)           (8F4.1)             \n"
             "1  3  5  6  \n1 2 2 3 3 \n 4.0-1.0 4.0-2.0 4.0\n",
     0, 1},
    {"Harwell-Boeing, a right side, lines that end in CR LF, reals by D",
     "title                                                                   key     \r\n"
     "             4             1             1             1             1\r\n"
     "rua                        3             3             7             0\r\n"
     "(4I2)           (8I2)           (1P,8D5.1)            (8F4.1)\r\n"
     "F                          1             0\r\n"
     " 1 3 6 8\r\n 1 2 1 2 3 2 3\r\n 4.D0-1.D0-1.D0 4.D0-2.D0-2.D0 4.D0\r\n",
     0, 0},
    {"table", "4, -1, 0\n-1, 4, -2\n0, -2, 4\n", 0, 0},
    {"Matrix Market",
     "%%MatrixMarket matrix coordinate real symmetric\n3 3 5\n1 1 4\n2 1 -1\n2 2 4\n3 2 -2\n3 3 "
     "4\n",
     0, 1},
};
enum { TEXTS = sizeof texts / sizeof *texts };

static void is_the_matrix(const char *name, const dls_sparse *A) {
  double a[3][3] = {{0}};
  ck_assert_msg(A->rows == 3 && A->cols == 3, "%s: %d x %d", name, A->rows, A->cols);
  for (int j = 0; j < 3; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      a[A->i[k]][j] += A->x[k];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      ck_assert_msg(a[i][j] == wanted[i][j], "%s: (%d, %d) is %g", name, i, j, a[i][j]);
}

/* Reads every beginning of the file (it must not crash), then with every allocation failing. */
static void is_robust(const char *name, const char *bytes, size_t size, int triplets) {
  dls_sparse A, old = {7, 7, NULL, NULL, NULL};
  for (size_t cut = 0; cut < size; cut++) {
    put_bytes(bytes, cut);
    A = old;
    if (dls_matrix_read(path, triplets, &A, NULL, NULL, NULL) == DLS_OK)
      dls_mtx_free_sparse(&A);
    else
      ck_assert_int_eq(A.rows, 7);
  }
  put_bytes(bytes, size);
  for (long k = 1;; k++) {
    int *labels = NULL;
    A = old;
    malloc_fails_at(k);
    const dls_status status = dls_matrix_read(path, triplets, &A, NULL, &labels, NULL);
    const int ended = malloc_calls() < k;
    malloc_fails_at(0);
    if (!ended) ck_assert_msg(status == DLS_E_MEMORY && A.rows == 7, "%s, %ld", name, k);
    if (!ended) continue;
    ck_assert_int_eq(status, DLS_OK);
    is_the_matrix(name, &A);
    dls_mtx_free_sparse(&A);
    dls_matrix_free_labels(labels);
    return;
  }
}

TEST_EACH(text_formats, 0, TEXTS) {
  int symmetric = -1;
  dls_sparse A;
  put_bytes(texts[_i].text, strlen(texts[_i].text));
  dls_error error = {0};
  const dls_status status = dls_matrix_read(path, texts[_i].triplets, &A, &symmetric, NULL, &error);
  ck_assert_msg(status == DLS_OK, "%s: %s", texts[_i].name, error.message);
  ck_assert_msg(symmetric == texts[_i].symmetric, "%s", texts[_i].name);
  dls_mtx_free_sparse(&A);
  is_robust(texts[_i].name, texts[_i].text, strlen(texts[_i].text), texts[_i].triplets);
}

TEST(labels_of_abaqus) {
  dls_sparse A;
  int *labels = NULL;
  const char *text = "7,1, 7,1, 4\n7,1, 5,2, -2\n5,2, 5,2, 4\n5,2, 5,1, -1\n5,1, 5,1, 4\n";
  put_bytes(text, strlen(text));
  ck_assert_int_eq(dls_matrix_read(path, 0, &A, NULL, &labels, NULL), DLS_OK);
  is_the_matrix("Abaqus", &A);
  static const int expected[] = {5, 1, 5, 2, 7, 1};
  ck_assert_mem_eq(labels, expected, sizeof expected);
  dls_matrix_free_labels(labels);
  dls_matrix_free_labels(NULL);
  dls_mtx_free_sparse(&A);
}

/* ---- binary ---------------------------------------------------------------------------------- */

static char bytes[8000];
static size_t size;

static void add(const void *from, size_t count) {
  memcpy(bytes + size, from, count);
  size += count;
}

static void add_big(unsigned long long value, int width) {
  for (int k = width; k-- > 0;)
    bytes[size++] = (char)(value >> (8 * k) & 255);
}

static void add_little(unsigned long value, int width) {
  for (int k = 0; k < width; k++)
    bytes[size++] = (char)(value >> (8 * k) & 255);
}

static const int columns[] = {0, 1, 0, 1, 2, 1, 2}, starts[] = {0, 2, 5, 7};
static const double values[] = {4, -1, -1, 4, -2, -2, 4};

static void add_big_number(double value) {
  unsigned long long bits;
  memcpy(&bits, &value, 8);
  add_big(bits, 8);
}

static void add_big_values(void) {
  for (int k = 0; k < 7; k++)
    add_big_number(values[k]);
}

TEST(petsc) {
  for (int width = 4; width <= 8; width += 4) {
    size = 0;
    add_big(1211216, width);
    add_big(3, width);
    add_big(3, width);
    add_big(7, width);
    for (int i = 0; i < 3; i++)
      add_big((unsigned long long)(starts[i + 1] - starts[i]), width);
    for (int k = 0; k < 7; k++)
      add_big((unsigned long long)columns[k], width);
    add_big_values();
    is_robust("PETSc", bytes, size, 0);
  }
  size = 0; /* dense, by rows */
  add_big(1211216, 4);
  add_big(3, 4);
  add_big(3, 4);
  add_big(0xffffffff, 4);
  for (int k = 0; k < 9; k++)
    add_big_number(wanted[k / 3][k % 3]);
  is_robust("PETSc, dense", bytes, size, 0);
}

TEST(petsc_vectors) {
  dlsi_table t = {0};
  dls_sparse A;
  dls_error error;
  size = 0;
  add_big(1211214, 4);
  add_big(7, 4);
  add_big_values();
  put_bytes(bytes, size);
  ck_assert_int_eq(dls_matrix_read(path, 0, &A, NULL, NULL, &error), DLS_E_FORMAT);
  ck_assert_ptr_nonnull(strstr(error.message, "is a vector, no matrix"));
  ck_assert_int_eq(dlsi_table_read(path, &t, &error), DLS_OK);
  ck_assert(t.rows == 7 && t.cols == 1);
  ck_assert_mem_eq(t.a, values, sizeof values);
  free(t.a);
  put_bytes(bytes, size - 1);
  t.a = NULL;
  ck_assert_int_eq(dlsi_table_read(path, &t, &error), DLS_E_FORMAT);
  ck_assert_ptr_nonnull(strstr(error.message, "its size is not what its first numbers say"));
  free(t.a);
}

/* A member of a zip file, and its entry in the directory. deflated: in one block that is stored. */
static char entries[2000];
static size_t entries_size;
static int deflated;

static unsigned long sum_of(const char *x, size_t count) {
  unsigned long sum = 0xffffffff;
  for (size_t k = 0; k < count; k++) {
    sum ^= (unsigned char)x[k];
    for (int bit = 0; bit < 8; bit++)
      sum = sum & 1 ? sum >> 1 ^ 0xedb88320 : sum >> 1;
  }
  return sum ^ 0xffffffff;
}

static void add_member(const char *name, const char *type, const char *shape, const void *data,
                       size_t count) {
  char member[1000] = "\x93NUMPY\1\0\x76\0", dictionary[200];
  const int length =
      snprintf(dictionary, sizeof dictionary,
               "{'descr': '%s', 'fortran_order': False, 'shape': (%s), }", type, shape);
  memset(member + 10, ' ', 118);
  memcpy(member + 10, dictionary, (size_t)length);
  memcpy(member + 128, data, count);
  const size_t all = 128 + count, at = size, packed = deflated ? all + 5 : all;
  add("PK\3\4\x14\0\0\0\0\0\0\0\0\0", 14);
  bytes[size - 6] = deflated ? 8 : 0;
  add_little(sum_of(member, all), 4);
  add_little(packed, 4);
  add_little(all, 4);
  add_little(strlen(name), 2);
  add_little(0, 2);
  add(name, strlen(name));
  if (deflated) {
    add_little(1, 1);
    add_little(all, 2);
    add_little(~all, 2);
  }
  add(member, all);
  const size_t end = size; /* the entry is written behind, and moved */
  add("PK\1\2\x14\0\x14\0\0\0\0\0\0\0\0\0", 16);
  bytes[size - 6] = deflated ? 8 : 0;
  add_little(sum_of(member, all), 4);
  add_little(packed, 4);
  add_little(all, 4);
  add_little(strlen(name), 2);
  add("\0\0\0\0\0\0\0\0\0\0\0\0", 12);
  add_little(at, 4);
  add(name, strlen(name));
  memcpy(entries + entries_size, bytes + end, size - end);
  entries_size += size - end;
  size = end;
}

static void add_directory(int count) {
  const size_t begin = size;
  add(entries, entries_size);
  add("PK\5\6\0\0\0\0", 8);
  add_little((unsigned long)count, 2);
  add_little((unsigned long)count, 2);
  add_little(entries_size, 4);
  add_little(begin, 4);
  add_little(0, 2);
}

TEST(npz) {
  static const long long shape[] = {3, 3};
  size = entries_size = 0;
  add_member("indices.npy", "<i4", "7,", columns, sizeof columns);
  add_member("indptr.npy", "<i4", "4,", starts, sizeof starts);
  add_member("format.npy", "|S3", "", "csr", 3);
  add_member("shape.npy", "<i8", "2,", shape, sizeof shape);
  add_member("data.npy", "<f8", "7,", values, sizeof values);
  add_directory(5);
  is_robust(".npz", bytes, size, 0);
  for (size_t k = 0; k < size; k++) { /* each byte wrong: an error, or what it does not concern */
    dls_sparse A;
    bytes[k] ^= 1;
    put_bytes(bytes, size);
    if (dls_matrix_read(path, 0, &A, NULL, NULL, NULL) == DLS_OK) dls_mtx_free_sparse(&A);
    bytes[k] ^= 1;
  }
}

/* Heads of .npy files; version and bytes of data; rows, cols 0: refused. */
static const struct {
  int version;
  const char *head;
  size_t data;
  int rows, cols;
} npy_heads[] = {
    {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }", 24, 3, 1},
    {2, "{'descr': '<f8', 'fortran_order': True, 'shape': (1, 3), }", 24, 1, 3},
    {3, "{'descr': '|b1', 'fortran_order': False, 'shape': (2, 1), }", 2, 2, 1},
    {1, "{'descr': '<i2', 'fortran_order': False, 'shape': (), }", 2, 1, 1},
    {4, "{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }", 24, 0, 0},
    {1, "{'descr': '>f8', 'fortran_order': False, 'shape': (3,), }", 24, 0, 0},
    {1, "{'descr': '<f2', 'fortran_order': False, 'shape': (3,), }", 6, 0, 0},
    {1, "{'descr': '<f16', 'fortran_order': False, 'shape': (3,), }", 48, 0, 0},
    {1, "{'descr': '<i16', 'fortran_order': False, 'shape': (1,), }", 16, 0, 0},
    {1, "{'descr': '<c8', 'fortran_order': False, 'shape': (3,), }", 24, 0, 0},
    {1, "{'descr': '<fx', 'fortran_order': False, 'shape': (3,), }", 24, 0, 0},
    {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 1, 3), }", 24, 0, 0},
    {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (n,), }", 24, 0, 0},
    {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (3,", 24, 0, 0},
    {1, "{'descr': '<f8', 'fortran_order': False, }", 24, 0, 0},
    {1, "{'descr': '<f8', 'shape': (3,), }", 24, 0, 0},
    {1, "{'fortran_order': False, 'shape': (3,), }", 24, 0, 0},
    {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (0, 3), }", 0, 0, 0},
    {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 0), }", 0, 0, 0},
    {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (4,), }", 24, 0, 0},
    {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }", 24, 0, 0},
    {1, "{'descr': '<f8', 'fortran_order': False, 'shape': (2147483647, 2147483647), }", 24, 0, 0},
};

TEST_EACH(npy_heads_of_any_kind, 0, (int)(sizeof npy_heads / sizeof *npy_heads)) {
  const size_t length = strlen(npy_heads[_i].head);
  static const char zeros[64];
  dlsi_table t;
  size = 0;
  add("\x93NUMPY", 6);
  add_little((unsigned long)npy_heads[_i].version, 2);
  add_little(length, npy_heads[_i].version == 1 ? 2 : 4);
  add(npy_heads[_i].head, length);
  add(zeros, npy_heads[_i].data);
  put_bytes(bytes, size);
  const dls_status status = dlsi_table_read(path, &t, NULL);
  ck_assert_int_eq(status, npy_heads[_i].cols ? DLS_OK : DLS_E_FORMAT);
  ck_assert(status || (t.rows == npy_heads[_i].rows && t.cols == npy_heads[_i].cols));
  free(t.a);
}

/* A member in place of one of the matrix, or none of that name; what the error says. */
static const struct {
  const char *member, *type, *shape, *data;
  size_t bytes;
  const char *says;
} wrong_members[] = {
    {"format.npy", "|S3", "", "bsr", 3, "a sparse matrix of another kind"},
    {"format.npy", "<U3", "", "c\0\0\0s\0\0\0r\0\0\0", 12, NULL},
    {"format.npy", "|S2", "", "cs", 2, "a sparse matrix of another kind"},
    {"format.npy", "", "", NULL, 0, "no matrix of scipy.sparse.save_npz"},
    {"indptr.npy", "", "", NULL, 0, "a sparse matrix of another kind"},
    {"shape.npy", "|u1", "3,", "\3\3\3", 3, "sizes that do not fit"},
    {"shape.npy", "|u1", "2,", "\0\3", 2, "sizes that do not fit"},
    {"shape.npy", "|u1", "2,", "\3\2", 2, "out of range"},
    {"shape.npy", "|u1", "2,", "\2\3", 2, "out of range"},
    {"indptr.npy", "|u1", "4,", "\1\2\5\7", 4, "out of range"},
    {"indptr.npy", "|u1", "4,", "\0\5\2\7", 4, "out of range"},
    {"indptr.npy", "|u1", "4,", "\0\x9\5\7", 4, "out of range"},
    {"indptr.npy", "|u1", "4,", "\0\2\5\6", 4, "out of range"},
    {"indices.npy", "|u1", "6,", "\0\1\0\1\2\1", 6, "sizes that do not fit"},
    {"indices.npy", "<c8", "1,", "\0\1\0\1\2\1\0\0", 8, "no array of real numbers"},
};

TEST_EACH(npz_with_a_wrong_member, 0, (int)(sizeof wrong_members / sizeof *wrong_members)) {
  static const long long shape[] = {3, 3};
  const struct {
    const char *name, *type, *shape;
    const void *data;
    size_t bytes;
  } right[] = {{"indices.npy", "<i4", "7,", columns, sizeof columns},
               {"indptr.npy", "<i4", "4,", starts, sizeof starts},
               {"format.npy", "|S3", "", "csr", 3},
               {"shape.npy", "<i8", "2,", shape, sizeof shape},
               {"data.npy", "<f8", "7,", values, sizeof values}};
  int count = 0;
  size = entries_size = 0;
  for (int k = 0; k < 5; k++) {
    const int wrong = strcmp(right[k].name, wrong_members[_i].member) == 0;
    if (wrong && !wrong_members[_i].data) continue;
    if (wrong)
      add_member(right[k].name, wrong_members[_i].type, wrong_members[_i].shape,
                 wrong_members[_i].data, wrong_members[_i].bytes);
    else
      add_member(right[k].name, right[k].type, right[k].shape, right[k].data, right[k].bytes);
    count++;
  }
  add_directory(count);
  put_bytes(bytes, size);
  dls_sparse A;
  dls_error error;
  const dls_status status = dls_matrix_read(path, 0, &A, NULL, NULL, &error);
  if (wrong_members[_i].says) {
    ck_assert_int_lt(status, 0);
    ck_assert_msg(strstr(error.message, wrong_members[_i].says), "%s", error.message);
    return;
  }
  ck_assert_int_eq(status, DLS_OK);
  is_the_matrix("unicode", &A);
  dls_mtx_free_sparse(&A);
}

/* A table in each format that holds one, with every allocation failing in turn. */
TEST(tables_without_memory) {
  static const char *const table[] = {"%%MatrixMarket matrix array real general\n2 2\n1\n3\n2\n4\n",
                                      "1 2\n3 4\n", "4\n1 2\n3 4\n# their number first\n"};
  dlsi_table t = {.a = NULL};
  for (int k = 0; k < 3; k++) {
    put_bytes(table[k], strlen(table[k]));
    for (long call = 1, ended = 0; !ended; call++) {
      malloc_fails_at(call);
      const dls_status status = dlsi_table_read(path, &t, NULL);
      ended = malloc_calls() < call;
      malloc_fails_at(0);
      ck_assert_int_eq(status, ended ? DLS_OK : DLS_E_MEMORY);
      if (!ended) free(t.a);
    }
    for (int i = 0; i < 4; i++)
      ck_assert(t.a[i] == i + 1);
    free(t.a);
  }
}

/* By coordinates, as scipy.sparse.save_npz writes it: packed, numbers of other types. */
TEST_EACH(npz_of_coordinates, 0, 4) {
  static const long long shape[] = {3, 3};
  static const unsigned char rows[] = {0, 0, 1, 1, 1, 2, 2};
  long long cols[7];
  float x[7];
  for (int k = 0; k < 7; k++) {
    cols[k] = columns[k];
    x[k] = (float)values[k];
  }
  if (_i > 0) cols[4] = _i == 1 ? 3 : -1;
  size = entries_size = 0;
  deflated = 1;
  add_member("row.npy", "|u1", _i == 3 ? "6," : "7,", rows, _i == 3 ? 6 : 7);
  add_member("col.npy", "<i8", "7,", cols, sizeof cols);
  add_member("format.npy", "|S3", "", "coo", 3);
  add_member("shape.npy", "<i8", "2,", shape, sizeof shape);
  add_member("data.npy", "<f4", "7,", x, sizeof x);
  add_directory(5);
  deflated = 0;
  if (_i == 0) {
    is_robust("coo", bytes, size, 0);
    return;
  }
  dls_sparse A;
  dls_error error;
  put_bytes(bytes, size);
  ck_assert_int_eq(dls_matrix_read(path, 0, &A, NULL, NULL, &error), DLS_E_FORMAT);
  ck_assert_ptr_nonnull(strstr(error.message, _i == 3 ? "its arrays have sizes that do not fit"
                                                      : "has an index that is out of range"));
}

/* What is known and not read says what to do. */
static const struct {
  const char *bytes;
  size_t size;
  const char *says;
} foreign[] = {
    {"MATLAB 5.0 MAT-file, Platform: GLNXA64", 38, "in MATLAB [i,j,x] = find(K)"},
    {"MATLAB 7.3 MAT-file, Platform: GLNXA64", 38, "in MATLAB [i,j,x] = find(K)"},
    {"DMIG    KAAX           0       6\n", 33, "Nastran (DMIG): write lines 'row column value'"},
    {"\x1f\x8b\x08\0", 4, "gunzip"},
    {"\x80\4\x95 pickled", 11, "scipy.sparse.save_npz"},
    {"Octave-1-L\0", 11, "save -text"},
    {"\x89HDF\r\n\x1a\n", 8, "delassus solve FILE"},
    {"<?xml version=\"1.0\"?>", 21, "K is needed"},
    {"\1\2\0\3", 4, "neither text nor"},
};

TEST_EACH(foreign_formats, 0, (int)(sizeof foreign / sizeof *foreign)) {
  dls_sparse A = {7, 7, NULL, NULL, NULL};
  dls_error error = {0};
  put_bytes(foreign[_i].bytes, foreign[_i].size);
  ck_assert_int_lt(dls_matrix_read(path, 0, &A, NULL, NULL, &error), 0);
  ck_assert_msg(strstr(error.message, foreign[_i].says), "%s", error.message);
  ck_assert_str_eq(error.argument, "path");
  ck_assert_int_eq(A.rows, 7);
}

TEST(wrong_lines) {
  static const char *const wrong[][2] = {
      {"0,5;1,2\n1,2;3,4\n", "has decimal commas; numbers have a point"},
      {"1 2\n3\n", "line 2 has 1 number, those before have 2"},
      {"1 2\n3 x4\n", "line 2, 'x4': is no number"},
      {"%%MatrixMarket matrix coordinate real general\n2 2 1\n1 1 0,5\n",
       "has a comma, decimals have a point"},
      {"# Created by Octave\n# name: K\n# type: sparse matrix\n# rows: 2\n# columns: 2\n1 1 4\n"
       "# name: L\n",
       "several variables of Octave"},
      {"# Sparse Matrix (Morse)\n3 3 0 9\n1 1 4\n", "holds 1 entries, not 9"},
      {"1 inf\n2 3\n", "entry (1, 2) is not finite"},
      {HB_HEAD
       "RSE                        3             3             5             0\n" HB_FORMATS,
       "line 3: only real, assembled matrices"},
      {HB_HEAD
       "RHA                        3             3             5             0\n" HB_FORMATS,
       "line 3: only real, assembled matrices"},
      {HB_HEAD
       "RUA                        0             3             5             0\n" HB_FORMATS,
       "has sizes that cannot be"},
      {HB_HEAD "RUA                        3             3\n" HB_FORMATS,
       "needs rows, columns and entries"},
      {HB_HEAD "RSA                        3             3             5             0\n(4I2)\n",
       "needs formats such as (16I5)"},
      {HB_HEAD "RSA                        3             3             5             0\n"
               "(4I2)           (8X2)           (8F4.1)\n",
       "needs formats such as (16I5)"},
      {HB_HEAD "RSA                        3             3             5             0\n"
               "(4I2)           (999I2)         (8F4.1)\n",
       "needs formats such as (16I5)"},
      {HB_HEAD "RSA                        3             3           500             0\n" HB_FORMATS
               " 1 3 5 6\n",
       "claims more numbers than the file has room for"},
      {HB_HEAD "RSA                        3             3             5             0\n" HB_FORMATS
               " 1 3 5 6\n 1 2 2 3 3\n",
       "there are too few lines"},
      {HB_HEAD "RSA                        3             3             5             0\n" HB_FORMATS
               " 1 3 x 6\n 1 2 2 3 3\n 4.0-1.0 4.0-2.0 4.0\n",
       "a field holds no number"},
      {HB_HEAD "RSA                        3             3             5             0\n" HB_FORMATS
               " 1 3 5 5\n 1 2 2 3 3\n 4.0-1.0 4.0-2.0 4.0\n",
       "there are more entries than pointers"},
      {HB_HEAD "RSA                        3             3             5             0\n" HB_FORMATS
               " 1 3 5 6\n 1 2 1 3 3\n 4.0-1.0 4.0-2.0 4.0\n",
       "a row is out of range"},
      {"# Created by Octave\n# type: sparse matrix\n# columns: 2\n1 1 4\n",
       "is a matrix of Octave without its rows and columns"},
      {"# Created by Octave\n# type: sparse matrix\n# rows: 2\n1 1 4\n",
       "is a matrix of Octave without its rows and columns"},
      {"# Created by Octave\n# type: sparse matrix\n# rows: x\n# columns: 2\n1 1 4\n",
       "is a matrix of Octave without its rows and columns"},
      {"# Created by Octave\n# type: sparse matrix\n# rows: 2\n# columns: 0\n1 1 4\n",
       "is a matrix of Octave without its rows and columns"},
      {"# Sparse Matrix (Morse)\n3 3 0\n1 1 4\n", "is no first line of a matrix of FreeFEM"},
      {"# Sparse Matrix (Morse)\n3 .5 0 1\n1 1 4\n", "is no first line of a matrix of FreeFEM"},
      {"# Sparse Matrix (Morse)\n3 3 0 -1\n1 1 4\n", "is no first line of a matrix of FreeFEM"},
      {"# Sparse Matrix (Morse)\n# nothing\n", "is no first line of a matrix of FreeFEM"},
      {"# Sparse Matrix (Morse)\n3 3 x\n", "is no number"},
      {"# Sparse Matrix (Morse)\n3 3 0 1\n0 1 4\n", "an index is beyond 3 x 3"},
      {"# Sparse Matrix (Morse)\n3 3 0 1\n1 4 4\n", "an index is beyond 3 x 3"},
      {"1 -inf\n2 3\n", "entry (1, 2) is not finite"},
      {"1 +INF\n2 3\n", "entry (1, 2) is not finite"},
      {"1 *inf\n2 3\n", "is no number"},
      {"1 info\n2 3\n", "is no number"},
      {"# nothing\n", "holds no number"},
      {"\n", "holds no number"},
      {"# Sparse Matrix (Morse)\n3 3 0 1\n9 1 4\n", "an index is beyond 3 x 3"},
      {"# Sparse Matrix (Morse)\n9000000 9000000 0 1\n1 1 4\n", "has too few entries for its size"},
      {HB_HEAD
       "CSA                        3             3             5             0\n" HB_FORMATS,
       "line 3: only real, assembled matrices"},
      {HB_HEAD
       "RSA                        3             4             5             0\n" HB_FORMATS,
       "has sizes that cannot be"},
      {HB_HEAD "RSA                        3             3             5             0\n" HB_FORMATS
               " 1 5 3 6\n 1 2 2 3 3\n 4.0-1.0 4.0-2.0 4.0\n",
       "a pointer is out of order"},
      {HB_HEAD "RSA                        3             3             5             0\n" HB_FORMATS
               " 1 3 5 6\n 1 2 2 9 3\n 4.0-1.0 4.0-2.0 4.0\n",
       "a row is out of range"},
  };
  for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
    dls_sparse A;
    dls_error error = {0};
    put_bytes(wrong[k][0], strlen(wrong[k][0]));
    ck_assert_int_lt(dls_matrix_read(path, 0, &A, NULL, NULL, &error), 0);
    ck_assert_msg(strstr(error.message, wrong[k][1]), "%s", error.message);
  }
  dls_sparse A;
  dls_error error = {0};
  put_bytes("1 1 4\n1.5 2 3\n", 14);
  ck_assert_int_eq(dls_matrix_read(path, 1, &A, NULL, NULL, &error), DLS_E_FORMAT);
  ck_assert_ptr_nonnull(strstr(error.message, "1.5 is no index"));
  ck_assert_int_eq(dls_matrix_read(NULL, 1, &A, NULL, NULL, &error), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_matrix_read(path, 1, NULL, NULL, NULL, &error), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_matrix_read("no/such", 1, &A, NULL, NULL, &error), DLS_E_FILE);
  ck_assert_ptr_nonnull(strstr(error.message, "does not exist"));
}

int main(void) {
  return run_tests("formats", make_matrix, remove_matrix);
}
