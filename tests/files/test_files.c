/* test_files.c: FCLIB (HDF5) and Matrix Market files: what is read, what is written, what is
 * refused. */
#define _POSIX_C_SOURCE 200809L

#include <locale.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#ifdef DLS_WITH_HDF5
#include <hdf5.h>
#endif

#include "delassus.h"
#include "reduced.h"
#include "run.h"

static char scratch[] = "/tmp/delassus-files-XXXXXX"; /* a directory, made in main */
static char path[sizeof scratch + 16];

/* ---- helpers --------------------------------------------------------------------------------- */

static void write_bytes(const char *name, const void *bytes, size_t size) {
  FILE *file = fopen(name, "wb");
  ck_assert_ptr_nonnull(file);
  ck_assert_uint_eq(fwrite(bytes, 1, size, file), size);
  ck_assert_int_eq(fclose(file), 0);
}

static void write_text(const char *name, const char *text) {
  write_bytes(name, text, strlen(text));
}

/* the whole file, to be freed */
static char *read_bytes(const char *name, size_t *size) {
  FILE *file = fopen(name, "rb");
  ck_assert_ptr_nonnull(file);
  ck_assert_int_eq(fseek(file, 0, SEEK_END), 0);
  const long length = ftell(file);
  ck_assert_int_gt(length, 0);
  rewind(file);
  char *bytes = malloc((size_t)length);
  ck_assert_ptr_nonnull(bytes);
  ck_assert_uint_eq(fread(bytes, 1, (size_t)length, file), (size_t)length);
  (void)fclose(file);
  *size = (size_t)length;
  return bytes;
}

static int exists(const char *name) {
  return access(name, F_OK) == 0;
}

/* runs `call` with the size of files limited, as a full disk would */
#define ON_A_FULL_DISK(limit, call)                                                                \
  do {                                                                                             \
    struct rlimit before_, now_;                                                                   \
    ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &before_), 0);                                        \
    void (*handler_)(int) = signal(SIGXFSZ, SIG_IGN);                                              \
    now_ = before_;                                                                                \
    now_.rlim_cur = (limit);                                                                       \
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &now_), 0);                                           \
    call;                                                                                          \
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &before_), 0);                                        \
    (void)signal(SIGXFSZ, handler_);                                                               \
  } while (0)

static void check_error(const dls_error *error, dls_status status, dls_status expected,
                        const char *argument, long long index) {
  ck_assert_msg(status == expected, "status %d, expected %d: %s", status, expected, error->message);
  ck_assert_int_eq(error->status, expected);
  ck_assert_str_eq(error->argument, argument);
  ck_assert_msg(error->index == index, "index %lld, expected %lld: %s", error->index, index,
                error->message);
}

/* ---- Matrix Market --------------------------------------------------------------------------- */

TEST(mtx_of_data) {
  int rows = 0, cols = 0;
  double *a = NULL;
  ck_assert_int_eq(dls_mtx_read(TEST_DATA "/lcp/lcp_CPS_1_M.mtx", &rows, &cols, &a, NULL), DLS_OK);
  ck_assert_int_eq(rows, 2);
  ck_assert_int_eq(cols, 2);
  assert_all(a, 4, 1);
  dls_mtx_free(a);
  ck_assert_int_eq(dls_mtx_read(TEST_DATA "/lcp/lcp_CPS_1_q.mtx", &rows, &cols, &a, NULL), DLS_OK);
  ck_assert(rows == 2 && cols == 1 && a[0] == -1 && a[1] == -1);
  dls_mtx_free(a);
  ck_assert_int_eq(dls_mtx_read(TEST_DATA "/lcp/lcp_mmc_M.mtx", &rows, &cols, &a, NULL), DLS_OK);
  ck_assert(rows == 26 && cols == 26 && a[0] == 1.48886559999999998e+05);
  ck_assert(a[1] == -9.27802559999999939e+04 && a[26] == a[1]);
  for (int j = 0; j < 26; j++)
    for (int i = 0; i < 26; i++)
      ck_assert(a[i + 26 * j] == a[j + 26 * i]);
  dls_mtx_free(a);
  ck_assert_int_eq(dls_mtx_read(TEST_DATA "/lcp/lcp_mmc_q.mtx", &rows, &cols, &a, NULL), DLS_OK);
  ck_assert(rows == 26 && cols == 1);
  dls_mtx_free(a);
  /* lcp_trivial: M = diag(1, 2, .. 9), q = -1 */
  ck_assert_int_eq(dls_mtx_read(TEST_DATA "/lcp/lcp_trivial_M.mtx", &rows, &cols, &a, NULL),
                   DLS_OK);
  ck_assert(rows == 9 && cols == 9);
  for (int k = 0; k < 81; k++)
    ck_assert(a[k] == (k % 10 == 0 ? k / 10 + 1 : 0));
  dls_mtx_free(a);
  ck_assert_int_eq(dls_mtx_read(TEST_DATA "/lcp/lcp_trivial_q.mtx", &rows, &cols, &a, NULL),
                   DLS_OK);
  ck_assert(rows == 9 && cols == 1);
  dls_mtx_free(a);
}

static const struct {
  const char *text;
  int rows, cols;
  double a[6];
} good_mtx[] = {
    {"%%MatrixMarket matrix array real general\n2 3\n1\n2\n3\n4\n5\n6\n", 2, 3, {1, 2, 3, 4, 5, 6}},
    {"%%MatrixMarket matrix array real general\r\n% comment\r\n\r\n2 3\r\n1\r\n2\r\n%\r\n3\r\n4 "
     "5\r\n6",
     2,
     3,
     {1, 2, 3, 4, 5, 6}},
    {"%%MatrixMarket MATRIX Array Real Symmetric\n%1 1\n2 2\n1\n-.5\n+3.E0\n",
     2,
     2,
     {1, -.5, -.5, 3}},
    {"%%MatrixMarket matrix array integer skew-symmetric\n2 2\n7\n", 2, 2, {0, 7, -7, 0}},
    {"%%MatrixMarket matrix coordinate real general\n2 3 3\n2 3 1e-3\n1 1 2E+2\n2 3 1\n",
     2,
     3,
     {2e2, 0, 0, 0, 0, 1.001}},
    {"%%MatrixMarket matrix coordinate integer symmetric\n  2 2 2  \n\n\t2 1 4\n% x\n2 2 5\n\n",
     2,
     2,
     {0, 4, 4, 5}},
    {"%%MatrixMarket matrix coordinate real skew-symmetric\n2 2 1\n2 1 4\n", 2, 2, {0, 4, -4, 0}},
    {"%%MatrixMarket matrix coordinate real general\n1 2 0\n", 1, 2, {0, 0}},
    {"%%MatrixMarket matrix array real general\n1 1\n4.9406564584124654e-324\n", 1, 1, {5e-324}},
};

static void read_good_mtx(void) {
  for (size_t k = 0; k < sizeof good_mtx / sizeof good_mtx[0]; k++) {
    write_text(path, good_mtx[k].text);
    int rows = 0, cols = 0;
    double *a = NULL;
    dls_error error = {0};
    const dls_status status = dls_mtx_read(path, &rows, &cols, &a, &error);
    ck_assert_msg(status == DLS_OK, "file %zu: %s", k, error.message);
    ck_assert(rows == good_mtx[k].rows && cols == good_mtx[k].cols);
    for (int e = 0; e < rows * cols; e++)
      ck_assert_msg(a[e] == good_mtx[k].a[e], "file %zu, %d: %g", k, e, a[e]);
    dls_mtx_free(a);
  }
  (void)remove(path);
}

TEST(mtx_variants) {
  read_good_mtx();
}

#define ARRAY      "%%MatrixMarket matrix array real general\n"
#define COORDINATE "%%MatrixMarket matrix coordinate real general\n"

static const struct {
  const char *text;
  dls_status status;
  long long line;
} bad_mtx[] = {
    {"", DLS_E_FORMAT, 1},
    {"\n\n" ARRAY "1 1\n1\n", DLS_E_FORMAT, 3},
    {"hello", DLS_E_FORMAT, 1},
    {"%%MatrixMarket\n", DLS_E_FORMAT, 2},
    {"%%MatrixMarket vector array real general\n1 1\n1\n", DLS_E_FORMAT, 1},
    {"%%MatrixMarket matrix sparse real general\n1 1\n1\n", DLS_E_FORMAT, 1},
    {"%%MatrixMarket matrix array complex general\n1 1\n1 0\n", DLS_E_UNSUPPORTED, 1},
    {"%%MatrixMarket matrix coordinate pattern general\n1 1 1\n1 1\n", DLS_E_UNSUPPORTED, 1},
    {"%%MatrixMarket matrix array real hermitian\n1 1\n1\n", DLS_E_FORMAT, 1},
    {"%%MatrixMarket matrix array real\ngeneral\n1 1\n1\n", DLS_E_FORMAT, 2},
    {"%%MatrixMarket matrix array real general 1 1\n1\n", DLS_E_FORMAT, 1},
    {ARRAY, DLS_E_FORMAT, 2},
    {ARRAY "2\n", DLS_E_FORMAT, 3},
    {ARRAY "2\n1\n1\n1\n", DLS_E_FORMAT, 3},
    {ARRAY "0 1\n", DLS_E_FORMAT, 2},
    {ARRAY "1 0\n", DLS_E_FORMAT, 2},
    {ARRAY "-1 1\n1\n", DLS_E_FORMAT, 2},
    {ARRAY "1 x\n1\n", DLS_E_FORMAT, 2},
    {ARRAY "2147483648 1\n1\n", DLS_E_FORMAT, 2},
    {ARRAY "99999999999999999999 1\n1\n", DLS_E_FORMAT, 2},
    {ARRAY "2147483647 2147483647\n1\n", DLS_E_SIZE, 2},
    {ARRAY "4000 4000\n1\n", DLS_E_FORMAT, 2}, /* claims 128 MB, holds one value */
    {COORDINATE "2 2 46000\n1 1 1\n", DLS_E_FORMAT, 2},
    {COORDINATE "2 2 12\n1 1 1\n", DLS_E_FORMAT, 2},      /* 72 characters at least */
    {COORDINATE "46000 46000 1\n1 1 1\n", DLS_E_SIZE, 2}, /* 17 GB dense */
    {COORDINATE "2147483647 1 1\n1 1 1\n", DLS_E_SIZE, 2},
    {ARRAY "2 1\n1\n", DLS_E_FORMAT, 4},
    {ARRAY "2 1\n1\n2\n3\n", DLS_E_FORMAT, 5},
    {ARRAY "2 1\n% a\n\n1\nnan\n", DLS_E_FORMAT, 6},
    {ARRAY "1 1\ninf\n", DLS_E_FORMAT, 3},
    {ARRAY "1 1\n1e999\n", DLS_E_FORMAT, 3},
    {ARRAY "1 1\n0x10\n", DLS_E_FORMAT, 3},
    {ARRAY "1 1\n1,5\n", DLS_E_FORMAT, 3},
    {ARRAY "1 1\n1.5.2\n", DLS_E_FORMAT, 3},
    {ARRAY "1 1\n1e\n", DLS_E_FORMAT, 3},
    {ARRAY "1 1\n1e+\n", DLS_E_FORMAT, 3},
    {ARRAY "1 1\n.\n", DLS_E_FORMAT, 3},
    {ARRAY "1 1\n-\n", DLS_E_FORMAT, 3},
    {ARRAY "1 1\n1junk\n", DLS_E_FORMAT, 3},
    {ARRAY "1 1\n1 junk\n", DLS_E_FORMAT, 3},
    {ARRAY "1 1\n0.00000000000000000000000000000000000000000000000000000000000000001\n",
     DLS_E_FORMAT, 3},
    {COORDINATE "2 2\n1 1 1\n", DLS_E_FORMAT, 3},
    {COORDINATE "2 2 -1\n", DLS_E_FORMAT, 2},
    {COORDINATE "2 2 2\n1 1 1\n", DLS_E_FORMAT, 4},
    {COORDINATE "2 2 1\n1 1 1\n2 2 2\n", DLS_E_FORMAT, 4},
    {COORDINATE "2 2 1\n0 1 1\n", DLS_E_FORMAT, 3},
    {COORDINATE "2 2 1\n3 1 1\n", DLS_E_FORMAT, 3},
    {COORDINATE "2 2 1\n1 0 1\n", DLS_E_FORMAT, 3},
    {COORDINATE "2 2 1\n1 3 1\n", DLS_E_FORMAT, 3},
    {COORDINATE "2 2 1\n1 1.5 1\n", DLS_E_FORMAT, 3},
    {COORDINATE "2 2 2\n1 1\n2 2 3 4\n", DLS_E_FORMAT, 4},
    {COORDINATE "2 2 2\n1\n2 2 3 4\n", DLS_E_FORMAT, 4},
    {COORDINATE "2 2 1\n1 1 NaN\n", DLS_E_FORMAT, 3},
    {COORDINATE "1 1 2\n1 1 1e308\n1 1 1e308\n", DLS_E_FORMAT, 5},
    {"%%MatrixMarket matrix array real symmetric\n2 3\n1\n", DLS_E_FORMAT, 2},
    {"%%MatrixMarket matrix coordinate real symmetric\n2 2 1\n1 2 1\n", DLS_E_FORMAT, 3},
    {"%%MatrixMarket matrix coordinate real skew-symmetric\n2 2 1\n1 1 1\n", DLS_E_FORMAT, 3},
    {"%%MatrixMarket matrix array real symmetric\n2 2\n1\n2\n3\n4\n", DLS_E_FORMAT, 6},
};

TEST(mtx_broken) {
  for (size_t k = 0; k < sizeof bad_mtx / sizeof bad_mtx[0]; k++) {
    write_text(path, bad_mtx[k].text);
    int rows = -7, cols = -8;
    double *a = &(double){0};
    dls_error error = {0};
    const dls_status status = dls_mtx_read(path, &rows, &cols, &a, &error);
    ck_assert_msg(status == bad_mtx[k].status && error.index == bad_mtx[k].line,
                  "file %zu: status %d, %s", k, status, error.message);
    check_error(&error, status, bad_mtx[k].status, "path", bad_mtx[k].line);
    ck_assert(a == NULL && rows == -7 && cols == -8);
  }
  (void)remove(path);
}

TEST(mtx_arguments) {
  int rows = -7, cols = -8;
  double *a = &(double){0};
  dls_error error = {0};
  REFUSES(ARGUMENT, "path", -1, dls_mtx_read, NULL, &rows, &cols, &a);
  ck_assert_ptr_null(a);
  REFUSES(ARGUMENT, "rows", -1, dls_mtx_read, path, NULL, &cols, &a);
  REFUSES(ARGUMENT, "cols", -1, dls_mtx_read, path, &rows, NULL, &a);
  REFUSES(ARGUMENT, "a", -1, dls_mtx_read, path, &rows, &cols, NULL);
  a = &(double){0};
  REFUSES(FILE, "path", -1, dls_mtx_read, path, &rows, &cols, &a);
  ck_assert_ptr_null(a);
  REFUSES(FILE, "path", -1, dls_mtx_read, scratch, &rows, &cols, &a);
  ck_assert(rows == -7 && cols == -8);
  dls_mtx_free(NULL);

  const double x[4] = {1, 2, NAN, 4};
  const dls_dense A = {2, 2, 2, x}, no_rows = {0, 2, 2, x}, no_cols = {2, 0, 2, x},
                  short_ld = {2, 1, 1, x}, null = {2, 2, 2, NULL}, good = {2, 1, 2, x};
  REFUSES(ARGUMENT, "path", -1, dls_mtx_write, NULL, &good);
  REFUSES(ARGUMENT, "A", -1, dls_mtx_write, path, NULL);
  REFUSES(ARGUMENT, "A", -1, dls_mtx_write, path, &null);
  REFUSES(NOT_FINITE, "A", 2, dls_mtx_write, path, &A);
  REFUSES(SIZE, "A", -1, dls_mtx_write, path, &no_rows);
  REFUSES(SIZE, "A", -1, dls_mtx_write, path, &no_cols);
  REFUSES(SIZE, "A", -1, dls_mtx_write, path, &short_ld);
  REFUSES(ARGUMENT, "comment", -1, dls_mtx_write_commented, path, &good, "two\nlines");
  ck_assert(!exists(path));
  ck_assert_int_eq(dls_mtx_write_commented(path, &good, "one line", &error), DLS_OK);
  ck_assert_int_eq(dls_mtx_read(path, &rows, &cols, &a, &error), DLS_OK);
  ck_assert(rows == 2 && cols == 1 && a[1] == 2);
  dls_mtx_free(a);
  (void)remove(path);
  REFUSES(FILE, "path", -1, dls_mtx_write, scratch, &good);
  dls_status status = DLS_OK;
  ON_A_FULL_DISK(20, status = dls_mtx_write(path, &good, &error));
  check_error(&error, status, DLS_E_FILE, "path", -1);
  ck_assert(!exists(path));
}

static void round_trip_mtx(void) {
  /* a 3 x 2 view with leading dimension 4; the gaps must not be written */
  const double x[8] = {1.0 / 3, -1e-308, 5e-324, NAN, 1.7976931348623157e308, -0.0, 0.1, NAN};
  const double dense[6] = {x[0], x[1], x[2], x[4], x[5], x[6]};
  const dls_dense A = {3, 2, 4, x};
  /* NaN between the columns is not looked at */
  ck_assert_int_eq(dls_mtx_write(path, &A, NULL), DLS_OK);
  int rows = 0, cols = 0;
  double *a = NULL;
  ck_assert_int_eq(dls_mtx_read(path, &rows, &cols, &a, NULL), DLS_OK);
  ck_assert(rows == 3 && cols == 2);
  for (int k = 0; k < 6; k++)
    ck_assert(a[k] == dense[k] && !signbit(a[k]) == !signbit(dense[k]));
  dls_mtx_free(a);
  size_t size = 0;
  char *text = read_bytes(path, &size);
  ck_assert_ptr_null(memchr(text, ',', size));
  free(text);
  (void)remove(path);
}

TEST(mtx_round_trip) {
  round_trip_mtx();
}

/* Runs where some locale with a decimal comma is installed. */
TEST(mtx_under_another_locale) {
  static const char *const names[] = {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE.utf8", "fr_FR.utf8",
                                      "de_DE",       "fr_FR",       "it_IT.UTF-8"};
  for (size_t k = 0; k < sizeof names / sizeof names[0]; k++)
    if (setlocale(LC_NUMERIC, names[k])) {
      ck_assert_str_eq(localeconv()->decimal_point, ",");
      read_good_mtx();
      round_trip_mtx();
      ck_assert_ptr_nonnull(setlocale(LC_NUMERIC, "C"));
      return;
    }
}

/* An error that tells of memory, and of no argument. */
static int of_memory(const dls_error *e) {
  check_error(e, e->status, DLS_E_MEMORY, "", -1);
  return 1;
}

TEST(mtx_malloc_fails) {
  write_text(path, good_mtx[0].text);
  int rows = -7, cols = -8;
  double *a = NULL;
  dls_error e = {0};
  MALLOCS_FAIL(dls_mtx_read(path, &rows, &cols, &a, &e),
               !a && rows == -7 && cols == -8 && of_memory(&e), DLS_OK, 1);
  ck_assert_int_eq(mallocs_failed, 1); /* one allocation of our own */
  dls_mtx_free(a);
  (void)remove(path);
}

/* ---- FCLIB ----------------------------------------------------------------------------------- */

#ifdef DLS_WITH_HDF5

/* a 2D problem of 2 candidates with an unsymmetric full W */
static const double W4[16] = {4, 1, -1, .5, 1, 3, .25, -2, -1, .125, 5, 1, .75, -2, 1.0 / 3, 6};
static const double q4[4] = {-1, .1, -2, 1e-20}, mu2[2] = {.3, 0}, r4[4] = {1, .3, 2, -0.0},
                    u4[4] = {0, -1.0 / 7, 0, 3};
static const dls_contact local2 = {.d = 2, .nc = 2, .W = {4, 4, 4, W4}, .q = q4, .mu = mu2};

/* a 3D model of 2 contact nodes and 3 unknowns, K unsymmetric */
static const int Kp[4] = {0, 2, 3, 5}, Ki[5] = {0, 2, 1, 0, 2};
static const double Kx[5] = {2, -1, 3, .5, 4};
static const int Np[3] = {0, 1, 2}, Ni[2] = {0, 2}, Tp[5] = {0, 1, 1, 3, 4}, Ti[4] = {1, 0, 1, 2};
static const double Nx[2] = {1, -1}, Tx[4] = {1, .5, -.5, .1}, f3[3] = {1, 2, -3},
                    g6[6] = {0, .1, .2, 1, -.3, 1.0 / 3}, mu3[2] = {.5, .25}, x3[3] = {7, 8, 9},
                    r6[6] = {1, 2, 3, 4, 5, 6}, u6[6] = {-1, -2, -3, -4, -5, -6};
static const dls_model model3 = {
    .d = 3,
    .n = 3,
    .nodes = 2,
    .operator_kind = DLS_STIFFNESS_SPARSE,
    .factorization = DLS_LU,
    .Ks = {3, 3, Kp, Ki, Kx},
    .HN = {3, 2, Np, Ni, Nx},
    .HT = {3, 4, Tp, Ti, Tx},
};

static dls_status write_local2(dls_error *error) {
  return dls_fclib_write_local(path, &local2, "two candidates", r4, u4, error);
}

static dls_status write_model3(dls_error *error) {
  return dls_fclib_write_global(path, &model3, f3, g6, mu3, "three unknowns", x3, r6, u6, error);
}

static void no_handle_is_open(void) {
  ck_assert_int_eq(H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_ALL), 0);
}

static dls_fclib *read_well(const char *name) {
  dls_fclib *file = NULL;
  dls_error error = {0};
  const dls_status status = dls_fclib_read(&file, name, &error);
  ck_assert_msg(status == DLS_OK, "%s: %s", name, error.message);
  no_handle_is_open();
  return file;
}

/* Returns the value that the error tells of. */
static double check_refused(const char *name, dls_status expected, const char *argument,
                            long long index) {
  dls_fclib *file = (dls_fclib *)&file;
  dls_error error = {0};
  const dls_status status = dls_fclib_read(&file, name, &error);
  ck_assert_ptr_null(file);
  check_error(&error, status, expected, argument, index);
  no_handle_is_open();
  return error.value;
}

/* dense := W by blocks */
static void expand(const dls_contact *problem, double *dense) {
  const int d = problem->d, m = d * problem->nc;
  memset(dense, 0, (size_t)(m * m) * sizeof *dense);
  for (int c = 0; c < problem->nc; c++)
    for (int k = problem->Wb.p[c]; k < problem->Wb.p[c + 1]; k++)
      for (int j = 0; j < d; j++)
        for (int i = 0; i < d; i++)
          dense[d * problem->Wb.i[k] + i + m * (d * c + j)] += problem->Wb.x[d * d * k + i + d * j];
}

static void check_local2(const char *name) {
  dls_fclib *file = read_well(name);
  dls_contact problem;
  double W[16];
  ck_assert_int_eq(dls_fclib_is_global(file), 0);
  ck_assert_int_eq(dls_fclib_contact(file, &problem, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  ck_assert(problem.d == 2 && problem.nc == 2 && problem.Wb.p[2] == 4);
  expand(&problem, W);
  ck_assert_mem_eq(W, W4, sizeof W);
  ck_assert_mem_eq(problem.q, q4, sizeof q4);
  ck_assert_mem_eq(problem.mu, mu2, sizeof mu2);
  dls_fclib_destroy(file);
}

TEST(local_files_of_data) {
  dls_fclib *file = read_well(TEST_DATA "/fclib/FC3D_Example1.hdf5");
  dls_contact problem;
  ck_assert_str_eq(dls_fclib_title(file), "FC3D_Example1");
  ck_assert_int_eq(dls_fclib_contact(file, &problem, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  ck_assert(problem.d == 3 && problem.nc == 3 && problem.W.a == NULL);
  for (int c = 0; c < 3; c++)
    ck_assert(problem.Wb.p[c + 1] == c + 1 && problem.Wb.i[c] == c);
  const double *r = q4, *u = q4;
  ck_assert_int_eq(dls_fclib_solution(file, &r, &u, NULL), DLS_OK);
  ck_assert(r == NULL && u == NULL);
  dls_fclib_destroy(file);

  file = read_well(TEST_DATA "/fclib/FC2D_SliderCrankLagrangian00000.hdf5");
  ck_assert_int_eq(dls_fclib_contact(file, &problem, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  ck_assert(problem.d == 2 && problem.nc == 2 && problem.Wb.p[2] == 4);
  /* the first entries of the file: W_00, W_10 | W_20 */
  ck_assert(problem.Wb.x[0] == 936.56100222535702 && problem.Wb.x[1] == -464.2665883420583);
  ck_assert(problem.Wb.x[4] == -915.29084962649517);
  dls_fclib_destroy(file);

  file = read_well(TEST_DATA "/fclib/Confeti-ex13-4contact-Fc3D-SBM.hdf5");
  ck_assert_int_eq(dls_fclib_contact(file, &problem, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  ck_assert(problem.d == 3 && problem.nc == 4 && problem.Wb.p[4] == 16);
  dls_fclib_destroy(file);
}

TEST(global_files_of_data) {
  /* M = 1, the candidate's three columns join unknowns 0 and 6, 1 and 7, 2 and 8 */
  dls_fclib *file = read_well(TEST_DATA "/fclib/GFC3D_Example0.hdf5");
  dls_model model;
  const double *f = NULL, *g = NULL, *mu = NULL;
  ck_assert_int_eq(dls_fclib_is_global(file), 1);
  ck_assert_str_eq(dls_fclib_title(file), "GFC3D_Example0");
  ck_assert_int_eq(dls_fclib_model(file, &model, &f, &g, &mu, NULL), DLS_OK);
  ck_assert(model.d == 3 && model.n == 9 && model.nodes == 1 && model.P.p == NULL);
  ck_assert(model.operator_kind == DLS_STIFFNESS_SPARSE && model.factorization == DLS_LU);
  for (int j = 0; j < 9; j++)
    ck_assert(model.Ks.p[j + 1] == j + 1 && model.Ks.i[j] == j && model.Ks.x[j] == 1);
  ck_assert(model.HN.rows == 9 && model.HN.cols == 1 && model.HN.p[1] == 2);
  ck_assert(model.HN.i[0] == 0 && model.HN.x[0] == 1 && model.HN.i[1] == 6 && model.HN.x[1] == -1);
  ck_assert(model.HT.rows == 9 && model.HT.cols == 2 && model.HT.p[1] == 2 && model.HT.p[2] == 4);
  ck_assert(model.HT.i[0] == 1 && model.HT.i[1] == 7 && model.HT.i[2] == 2 && model.HT.i[3] == 8);
  ck_assert(f[0] == -3 && f[8] == 3 && g[0] == 0 && g[2] == 0 && mu[0] == .1);
  dls_fclib_destroy(file);

  file = read_well(TEST_DATA "/fclib/GFC3D_OneContact.hdf5");
  ck_assert_int_eq(dls_fclib_model(file, &model, &f, &g, &mu, NULL), DLS_OK);
  ck_assert(model.d == 3 && model.n == 39 && model.nodes == 1 && model.Ks.p[39] == 39 * 39);
  dls_fclib_destroy(file);

  file = read_well(TEST_DATA "/fclib/gfc2d_granularflowonwall_00069_00350.hdf5");
  ck_assert_int_eq(dls_fclib_model(file, &model, &f, &g, &mu, NULL), DLS_OK);
  ck_assert(model.d == 2 && model.n == 900 && model.nodes == 69);
  ck_assert(model.HN.cols == 69 && model.HT.cols == 69);
  dls_fclib_destroy(file);
}

/* A global problem of rigid bodies is W = H^T H with the u of its reduction; v = M^-1 (H r + f) of
 * another one, or of none, is refused. */
TEST_EACH(bodies_of_data, 0, 4) {
  static const char *const name[] = {"gfc2d_granularflowonwall_00069_00350", "GFC3D_OneContact",
                                     "GFC3D_Example0", "FC3D_Example1"};
  static const dls_status expected[] = {DLS_OK, DLS_E_UNSUPPORTED, DLS_E_UNSUPPORTED,
                                        DLS_E_ARGUMENT};
  char file_name[200];
  (void)snprintf(file_name, sizeof file_name, TEST_DATA "/fclib/%s.hdf5", name[_i]);
  dls_fclib *file = read_well(file_name);
  dls_contact p = {.d = 77}, reduced;
  dls_error error;
  ck_assert_int_eq(dls_fclib_bodies(file, &p, &error), expected[_i]);
  ck_assert(expected[_i] || dls_fclib_bodies(file, NULL, &error) == DLS_E_ARGUMENT);
  ck_assert(!expected[_i] || (p.d == 77 && strcmp(error.argument, "file") == 0));
  if (!expected[_i]) {
    dls_model model;
    const double *f, *g, *mu;
    dls_reduction *reduction;
    ck_assert(p.d == 2 && p.nc == 69 && p.bodies.n == 3 && p.bodies.count == 300);
    ck_assert_int_eq(dls_fclib_model(file, &model, &f, &g, &mu, NULL), DLS_OK);
    ck_assert_int_eq(reduce_on_W(&reduction, &model, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_load(reduction, f, g, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_contact(reduction, mu, &reduced, NULL), DLS_OK);
    double r[138], u[2][138], size = 0;
    dls_certificate c;
    for (int k = 0; k < 138; k++)
      r[k] = sin(k + 1.);
    ck_assert_int_eq(dls_contact_certify(&p, r, u[0], &c, NULL), DLS_OK);
    ck_assert_int_eq(dls_contact_certify(&reduced, r, u[1], &c, NULL), DLS_OK);
    for (int k = 0; k < 138; k++)
      size = fmax(size, fabs(u[1][k]));
    for (int k = 0; k < 138; k++)
      ck_assert(fabs(u[0][k] - u[1][k]) <= 1e-13 * size);
    dls_reduction_destroy(reduction);
  }
  dls_fclib_destroy(file);
}

/* M of CubeH8 is a lower triangle, and all of it counts. */
TEST(matrix_of_a_file_is_whole) {
  dls_fclib *file = read_well(TEST_DATA "/fclib/CubeH8.hdf5");
  dls_model model;
  const double *f, *g, *mu;
  ck_assert_int_eq(dls_fclib_model(file, &model, &f, &g, &mu, NULL), DLS_OK);
  ck_assert(model.n == 162 && model.nodes == 1);
  ck_assert_int_eq(dls_model_check(&model, NULL), DLS_OK);
  model.triangular = 0;
  ck_assert_int_eq(dls_model_check(&model, NULL), DLS_E_ARGUMENT);
  dls_fclib_destroy(file);
}

/* every problem of data/, written and read again, has the same numbers in the same places */
TEST(data_round_trip) {
  static const char *const locals[] = {"FC3D_Example1", "FC2D_SliderCrankLagrangian00000",
                                       "Confeti-ex13-4contact-Fc3D-SBM"};
  static const char *const globals[] = {"GFC3D_Example0", "GFC3D_OneContact",
                                        "gfc2d_granularflowonwall_00069_00350"};
  char name[200];
  for (size_t k = 0; k < 3; k++) {
    (void)snprintf(name, sizeof name, TEST_DATA "/fclib/%s.hdf5", locals[k]);
    dls_fclib *one = read_well(name);
    dls_contact a, b;
    ck_assert_int_eq(dls_fclib_contact(one, &a, NULL), DLS_OK);
    ck_assert_int_eq(dls_fclib_write_local(path, &a, dls_fclib_title(one), NULL, NULL, NULL),
                     DLS_OK);
    no_handle_is_open();
    dls_fclib *two = read_well(path);
    ck_assert_int_eq(dls_fclib_contact(two, &b, NULL), DLS_OK);
    const size_t nc = (size_t)a.nc, d = (size_t)a.d, blocks = (size_t)a.Wb.p[nc];
    ck_assert(a.d == b.d && a.nc == b.nc);
    ck_assert_mem_eq(a.Wb.p, b.Wb.p, (nc + 1) * sizeof(int));
    ck_assert_mem_eq(a.Wb.i, b.Wb.i, blocks * sizeof(int));
    ck_assert_mem_eq(a.Wb.x, b.Wb.x, d * d * blocks * sizeof(double));
    ck_assert_mem_eq(a.q, b.q, d * nc * sizeof(double));
    ck_assert_mem_eq(a.mu, b.mu, nc * sizeof(double));
    ck_assert_str_eq(dls_fclib_title(two), locals[k]);
    dls_fclib_destroy(one);
    dls_fclib_destroy(two);
  }
  for (size_t k = 0; k < 3; k++) {
    (void)snprintf(name, sizeof name, TEST_DATA "/fclib/%s.hdf5", globals[k]);
    dls_fclib *one = read_well(name);
    dls_model a, b;
    const double *fa, *fb, *ga, *gb, *ma, *mb;
    ck_assert_int_eq(dls_fclib_model(one, &a, &fa, &ga, &ma, NULL), DLS_OK);
    ck_assert_int_eq(dls_fclib_write_global(path, &a, fa, ga, ma, NULL, NULL, NULL, NULL, NULL),
                     DLS_OK);
    no_handle_is_open();
    dls_fclib *two = read_well(path);
    ck_assert_int_eq(dls_fclib_model(two, &b, &fb, &gb, &mb, NULL), DLS_OK);
    ck_assert(a.d == b.d && a.n == b.n && a.nodes == b.nodes);
    const size_t n = (size_t)a.n, nc = (size_t)a.nodes, d = (size_t)a.d;
    const dls_sparse *A[3] = {&a.Ks, &a.HN, &a.HT}, *B[3] = {&b.Ks, &b.HN, &b.HT};
    for (int part = 0; part < 3; part++) {
      const size_t cols = (size_t)A[part]->cols, entries = (size_t)A[part]->p[cols];
      ck_assert(A[part]->rows == B[part]->rows && A[part]->cols == B[part]->cols);
      ck_assert_mem_eq(A[part]->p, B[part]->p, (cols + 1) * sizeof(int));
      ck_assert_mem_eq(A[part]->i, B[part]->i, entries * sizeof(int));
      ck_assert_mem_eq(A[part]->x, B[part]->x, entries * sizeof(double));
    }
    ck_assert_mem_eq(fa, fb, n * sizeof(double));
    ck_assert_mem_eq(ga, gb, d * nc * sizeof(double));
    ck_assert_mem_eq(ma, mb, nc * sizeof(double));
    ck_assert_str_eq(dls_fclib_title(two), "");
    dls_fclib_destroy(one);
    dls_fclib_destroy(two);
  }
  (void)remove(path);
}

TEST(local_round_trip) {
  ck_assert_int_eq(write_local2(NULL), DLS_OK);
  check_local2(path);
  dls_fclib *file = read_well(path);
  const double *r = NULL, *u = NULL;
  ck_assert_str_eq(dls_fclib_title(file), "two candidates");
  ck_assert_int_eq(dls_fclib_solution(file, &r, &u, NULL), DLS_OK);
  ck_assert_mem_eq(r, r4, sizeof r4);
  ck_assert_mem_eq(u, u4, sizeof u4);
  dls_fclib_destroy(file);

  /* the same bytes again, and over an old file that is longer */
  size_t size = 0, again = 0;
  char *bytes = read_bytes(path, &size), longer[20000] = {0};
  write_bytes(path, longer, sizeof longer);
  ck_assert_int_eq(write_local2(NULL), DLS_OK);
  char *second = read_bytes(path, &again);
  ck_assert_uint_eq(size, again);
  ck_assert_mem_eq(bytes, second, size);
  free(bytes);
  free(second);

  /* leading dimension 5; entries that are zero make no block */
  double padded[20];
  for (int j = 0; j < 4; j++)
    for (int i = 0; i < 5; i++)
      padded[i + 5 * j] = i == 4 ? NAN : i / 2 == j / 2 ? W4[i + 4 * j] : 0;
  dls_contact problem = local2;
  problem.W = (dls_dense){4, 4, 5, padded};
  ck_assert_int_eq(dls_fclib_write_local(path, &problem, NULL, NULL, NULL, NULL), DLS_OK);
  file = read_well(path);
  ck_assert_int_eq(dls_fclib_contact(file, &problem, NULL), DLS_OK);
  ck_assert(problem.Wb.p[1] == 1 && problem.Wb.p[2] == 2 && problem.Wb.i[0] == 0);
  ck_assert(problem.Wb.i[1] == 1 && problem.Wb.x[7] == W4[15] && problem.Wb.x[1] == W4[1]);
  dls_fclib_destroy(file);

  /* W = 0 is a problem too */
  double zero[16] = {0}, W[16];
  problem = local2;
  problem.W.a = zero;
  ck_assert_int_eq(dls_fclib_write_local(path, &problem, "", NULL, NULL, NULL), DLS_OK);
  file = read_well(path);
  ck_assert_int_eq(dls_fclib_contact(file, &problem, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  expand(&problem, W);
  ck_assert_mem_eq(W, zero, sizeof W);
  dls_fclib_destroy(file);
  (void)remove(path);
}

TEST(global_round_trip) {
  dls_model model;
  const double *f, *g, *mu, *r, *u;
  ck_assert_int_eq(write_model3(NULL), DLS_OK);
  dls_fclib *file = read_well(path);
  ck_assert_int_eq(dls_fclib_is_global(file), 1);
  ck_assert_str_eq(dls_fclib_title(file), "three unknowns");
  ck_assert_int_eq(dls_fclib_model(file, &model, &f, &g, &mu, NULL), DLS_OK);
  ck_assert(model.d == 3 && model.n == 3 && model.nodes == 2);
  ck_assert_mem_eq(model.Ks.p, Kp, sizeof Kp);
  ck_assert_mem_eq(model.Ks.i, Ki, sizeof Ki);
  ck_assert_mem_eq(model.Ks.x, Kx, sizeof Kx);
  ck_assert_mem_eq(model.HN.p, Np, sizeof Np);
  ck_assert_mem_eq(model.HN.i, Ni, sizeof Ni);
  ck_assert_mem_eq(model.HN.x, Nx, sizeof Nx);
  ck_assert_mem_eq(model.HT.p, Tp, sizeof Tp);
  ck_assert_mem_eq(model.HT.i, Ti, sizeof Ti);
  ck_assert_mem_eq(model.HT.x, Tx, sizeof Tx);
  ck_assert_mem_eq(f, f3, sizeof f3);
  ck_assert_mem_eq(g, g6, sizeof g6);
  ck_assert_mem_eq(mu, mu3, sizeof mu3);
  ck_assert_int_eq(dls_fclib_solution(file, &r, &u, NULL), DLS_OK);
  ck_assert_mem_eq(r, r6, sizeof r6);
  ck_assert_mem_eq(u, u6, sizeof u6);
  dls_fclib_destroy(file);

  /* x is there for other readers */
  double v[3] = {0};
  const hid_t h5 = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t set = H5Dopen2(h5, "solution/v", H5P_DEFAULT);
  ck_assert_int_ge(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, v), 0);
  (void)H5Dclose(set);
  (void)H5Fclose(h5);
  ck_assert_mem_eq(v, x3, sizeof x3);

  /* the four ways to give one symmetric K: only the lower triangle counts with Cholesky */
  const double full[9] = {4, 1, 0, 1, 5, 2, 0, 2, 6}, low[9] = {4, 1, 0, 99, 5, 2, 98, 97, 6};
  const int p[4] = {0, 2, 5, 7}, i[7] = {0, 1, 0, 1, 2, 1, 2};
  const double x[7] = {4, 1, 1, 5, 2, 2, 6}, xlow[7] = {4, 1, 99, 5, 2, 98, 6};
  for (int k = 0; k < 4; k++) {
    model = model3;
    model.operator_kind = k < 2 ? DLS_STIFFNESS_DENSE : DLS_STIFFNESS_SPARSE;
    model.factorization = k % 2 ? DLS_CHOLESKY : DLS_LU;
    model.K = (dls_dense){3, 3, 3, k % 2 ? low : full};
    model.Ks = (dls_sparse){3, 3, p, i, k % 2 ? xlow : x};
    ck_assert_int_eq(
        dls_fclib_write_global(path, &model, f3, g6, mu3, NULL, NULL, NULL, NULL, NULL), DLS_OK);
    file = read_well(path);
    ck_assert_int_eq(dls_fclib_model(file, &model, &f, &g, &mu, NULL), DLS_OK);
    double K[9] = {0};
    for (int j = 0; j < 3; j++)
      for (int e = model.Ks.p[j]; e < model.Ks.p[j + 1]; e++)
        K[model.Ks.i[e] + 3 * j] += model.Ks.x[e];
    ck_assert_mem_eq(K, full, sizeof K);
    dls_fclib_destroy(file);
  }
  (void)remove(path);
}

/* ---- files that HDF5 itself makes ------------------------------------------------------------ */

typedef enum action { DELETE, INTS, LONGS, REALS, FLOATS, TEXT, UNWRITTEN } action;

/* In file `path`: data set `name`, if there, deleted, and made again from v */
static void patch(const char *name, action what, size_t count, const double *v) {
  const hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t link = H5Pcreate(H5P_LINK_CREATE);
  ck_assert_int_ge(file, 0);
  ck_assert_int_ge(H5Pset_create_intermediate_group(link, 1), 0);
  H5E_BEGIN_TRY {
    (void)H5Ldelete(file, name, H5P_DEFAULT);
  }
  H5E_END_TRY;
  if (what != DELETE) {
    const hsize_t n = count;
    const hid_t text = H5Tcopy(H5T_C_S1);
    ck_assert_int_ge(H5Tset_size(text, 6), 0);
    const hid_t type = what == INTS     ? H5T_STD_I32BE
                       : what == LONGS  ? H5T_STD_I64LE
                       : what == FLOATS ? H5T_IEEE_F32LE
                       : what == TEXT   ? text
                                        : H5T_IEEE_F64LE;
    const hid_t space = H5Screate_simple(1, &n, NULL);
    const hid_t set = H5Dcreate2(file, name, type, space, link, H5P_DEFAULT, H5P_DEFAULT);
    ck_assert_int_ge(set, 0);
    if (what != UNWRITTEN)
      ck_assert_int_ge(H5Dwrite(set, what == TEXT ? text : H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL,
                                H5P_DEFAULT, what == TEXT ? (const void *)"three" : v),
                       0);
    (void)H5Dclose(set);
    (void)H5Sclose(space);
    (void)H5Tclose(text);
  }
  (void)H5Pclose(link);
  ck_assert_int_ge(H5Fclose(file), 0);
}

#define VALUES(...)                                                                                \
  (sizeof((const double[]){__VA_ARGS__}) / sizeof(double)), (const double[]) {                     \
    __VA_ARGS__                                                                                    \
  }

/* In file `path`: the size that is claimed for a matrix */
static void patch_size(const char *matrix, double rows, double cols) {
  char name[64];
  (void)snprintf(name, sizeof name, "%s/m", matrix);
  patch(name, INTS, VALUES(rows));
  (void)snprintf(name, sizeof name, "%s/n", matrix);
  patch(name, INTS, VALUES(cols));
}

/* Without candidates a file comes back, and its problem is solved. */
TEST(no_candidates_round_trip) {
  double xx[2] = {2, 3}, f[2] = {4, 6}, x[2] = {0};
  const int pp[3] = {0, 1, 2}, ii[2] = {0, 1};
  const dls_contact none = {.d = 3};
  dls_model model = {.d = 2,
                     .n = 2,
                     .operator_kind = DLS_STIFFNESS_SPARSE,
                     .factorization = DLS_CHOLESKY,
                     .Ks = {2, 2, pp, ii, xx}};
  dls_fclib *file;
  ck_assert_int_eq(dls_fclib_write_local(path, &none, NULL, NULL, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_fclib_read(&file, path, NULL), DLS_OK);
  dls_contact p;
  ck_assert_int_eq(dls_fclib_contact(file, &p, NULL), DLS_OK);
  ck_assert(p.d == 3 && p.nc == 0);
  ck_assert_int_eq(dls_solve(&p, NULL, NULL, NULL, NULL, NULL), DLS_OK);
  dls_fclib_destroy(file);

  for (int n = 1; n <= 2; n++) { /* one unknown is a model, too */
    model.n = model.Ks.rows = model.Ks.cols = n;
    ck_assert_int_eq(
        dls_fclib_write_global(path, &model, f, NULL, NULL, NULL, NULL, NULL, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_fclib_read(&file, path, NULL), DLS_OK);
    dls_model read;
    const double *load, *g, *mu;
    ck_assert_int_eq(dls_fclib_model(file, &read, &load, &g, &mu, NULL), DLS_OK);
    ck_assert(read.n == n && read.nodes == 0);
    dls_reduction *R;
    ck_assert_int_eq(reduce_on_W(&R, &read, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_load(R, load, g, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_recover(R, NULL, x, NULL), DLS_OK);
    ck_assert(x[0] == 2 && x[n - 1] == 2);
    dls_reduction_destroy(R);
    dls_fclib_destroy(file);
  }
}

static const char *other_file(void) {
  static char name[sizeof path];
  (void)snprintf(name, sizeof name, "%s/other", scratch);
  return name;
}

/* Makes data set `name` of file `path` again: `count` integers of `size` bytes, in chunks (0: in
 * one piece), deflated, or in another file. */
static void patch_odd(const char *name, size_t count, size_t size, size_t chunk, int outside) {
  const hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t create = H5Pcreate(H5P_DATASET_CREATE), type = H5Tcopy(H5T_STD_I32LE);
  const hsize_t n = count, piece = chunk, most = H5S_UNLIMITED;
  const hid_t space = H5Screate_simple(1, &n, chunk ? &most : NULL);
  ck_assert_int_ge(H5Tset_size(type, size), 0);
  if (chunk) ck_assert_int_ge(H5Pset_chunk(create, 1, &piece), 0);
  if (chunk) ck_assert_int_ge(H5Pset_deflate(create, 9), 0);
  if (outside) ck_assert_int_ge(H5Pset_external(create, other_file(), 0, 4 * n), 0);
  ck_assert_int_ge(H5Ldelete(file, name, H5P_DEFAULT), 0);
  const hid_t set = H5Dcreate2(file, name, type, space, H5P_DEFAULT, create, H5P_DEFAULT);
  ck_assert_int_ge(set, 0);
  void *zeros = calloc(count, size);
  ck_assert_int_ge(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, zeros), 0);
  free(zeros);
  (void)H5Dclose(set);
  (void)H5Sclose(space);
  (void)H5Tclose(type);
  (void)H5Pclose(create);
  ck_assert_int_ge(H5Fclose(file), 0);
}

/* Gives data set `name` of file `path` the extent `count`; nothing more is written. */
static void stretch_set(const char *name, size_t count) {
  const hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
  const hsize_t n = count;
  ck_assert_int_ge(H5Dset_extent(set, &n), 0);
  (void)H5Dclose(set);
  ck_assert_int_ge(H5Fclose(file), 0);
}

/* A file must not take more memory than its size explains, nor open another file. */
TEST(fclib_claims) {
  static const char *const room = "claims more values than the file has room for";
  static const struct {
    size_t count, size, chunk;
    int outside;
    const char *text;
  } odd[] = {{64, 17, 0, 0, "has the wrong type"},
             {64, 4096, 0, 0, "has the wrong type"},
             {64, 4, 0, 1, room}};
  for (size_t k = 0; k < sizeof odd / sizeof odd[0]; k++) {
    dls_fclib *file;
    ck_assert_int_eq(write_local2(NULL), DLS_OK);
    patch_odd("fclib_local/W/i", odd[k].count, odd[k].size, odd[k].chunk, odd[k].outside);
    REFUSES(FORMAT, "W/i", -1, dls_fclib_read, &file, path);
    ck_assert_msg(strstr(last_refusal.message, odd[k].text) != NULL, "%zu: %s", k,
                  last_refusal.message);
  }
  /* extents far beyond the few values that were written */
  dls_fclib *file;
  ck_assert_int_eq(write_local2(NULL), DLS_OK);
  patch_odd("fclib_local/W/i", 64, 4, 8, 0);
  stretch_set("fclib_local/W/i", 1000000000);
  REFUSES(FORMAT, "W/i", -1, dls_fclib_read, &file, path);
  ck_assert_msg(strstr(last_refusal.message, room) != NULL, "%s", last_refusal.message);
  (void)remove(other_file());
}

/* Deflate holds more values than bytes: as many as it can. */
TEST(fclib_deflated) {
  static const struct {
    size_t count, chunk;
  } sets[] = {{64, 1}, {64, 65536}, {4000000, 65536}, {4000000, 1000}};
  for (size_t k = 0; k < sizeof sets / sizeof sets[0]; k++) {
    dls_fclib *file;
    dls_error error = {0};
    ck_assert_int_eq(write_local2(NULL), DLS_OK);
    patch_odd("fclib_local/W/i", sets[k].count, 4, sets[k].chunk, 0);
    ck_assert_msg(dls_fclib_read(&file, path, &error) == DLS_OK, "%zu: %s", k, error.message);
    dls_fclib_destroy(file);
  }
}

/* Lets this process have so many megabytes more than it has; -1: all. Not under the address
 * sanitizer, which takes terabytes of addresses. */
static void allow_memory(int megabytes) {
#ifndef __SANITIZE_ADDRESS__
  unsigned long pages = 0;
  FILE *file = fopen("/proc/self/statm", "r");
  if (!file) return; /* not on this system */
  ck_assert_int_eq(fscanf(file, "%lu", &pages), 1);
  (void)fclose(file);
  struct rlimit most;
  ck_assert_int_eq(getrlimit(RLIMIT_AS, &most), 0);
  most.rlim_cur = most.rlim_max;
  if (megabytes >= 0)
    most.rlim_cur = pages * (rlim_t)sysconf(_SC_PAGESIZE) + ((rlim_t)megabytes << 20);
  ck_assert_int_eq(setrlimit(RLIMIT_AS, &most), 0);
#else
  (void)megabytes;
#endif
}

/* SECURITY.md: a few values in one large chunk, here of 120 MB, take no memory out of proportion,
 * nor do many values of which a few are wanted. */
TEST(fclib_takes_memory_in_proportion) {
  static const struct {
    size_t count, chunk;
    dls_status status;
  } sets[] = {{64, 30000000, DLS_E_FORMAT},
              {30000000, 30000000, DLS_E_FORMAT},
              {64, 131073, DLS_E_FORMAT},
              {64, 131072, DLS_OK}};
  for (size_t k = 0; k < sizeof sets / sizeof sets[0]; k++) {
    dls_fclib *file;
    dls_error error = {0};
    ck_assert_int_eq(write_local2(NULL), DLS_OK);
    patch_odd("fclib_local/W/i", sets[k].count, 4, sets[k].chunk, 0);
    allow_memory(64);
    ck_assert_int_eq(dls_fclib_read(&file, path, &error), sets[k].status);
    allow_memory(-1);
    if (file)
      dls_fclib_destroy(file);
    else
      ck_assert_str_eq(error.argument, "W/i");
  }
}

/* Links into another file are not followed, neither to a group nor to a data set. */
TEST(fclib_links_stay_inside) {
  static const char *const names[] = {"fclib_local", "fclib_local/vectors/q"};
  for (int k = 0; k < 2; k++) {
    dls_fclib *file;
    ck_assert_int_eq(write_local2(NULL), DLS_OK);
    ck_assert_int_eq(rename(path, other_file()), 0);
    ck_assert_int_eq(write_local2(NULL), DLS_OK);
    const hid_t h5 = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
    ck_assert_int_ge(H5Ldelete(h5, names[k], H5P_DEFAULT), 0);
    ck_assert_int_ge(
        H5Lcreate_external(other_file(), names[k], h5, names[k], H5P_DEFAULT, H5P_DEFAULT), 0);
    ck_assert_int_ge(H5Fclose(h5), 0);
    ck_assert_int_eq(dls_fclib_read(&file, path, NULL), DLS_E_FORMAT);
    (void)remove(other_file());
  }
}

TEST(other_layouts) {
  /* by rows, 64-bit indices, arrays longer than used, big-endian */
  double rows[20] = {0};
  for (int k = 0; k < 16; k++)
    rows[k] = W4[k / 4 + 4 * (k % 4)];
  rows[16] = NAN;
  ck_assert_int_eq(write_local2(NULL), DLS_OK);
  patch("fclib_local/W/nz", INTS, VALUES(-2));
  patch("fclib_local/W/nzmax", LONGS, VALUES(20));
  patch("fclib_local/W/p", LONGS, VALUES(0, 4, 8, 12, 16));
  patch("fclib_local/W/i", INTS,
        VALUES(0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, -9, -9, -9, -9));
  patch("fclib_local/W/x", REALS, 20, rows);
  check_local2(path);

  /* triplets from the last to the first, W_00 = 4 in three parts (5 - 3 + 2) */
  double row[18], col[18], x[18];
  for (int k = 0; k < 16; k++) {
    const int e = 15 - k, j = e / 4;
    row[k] = e % 4;
    col[k] = j;
    x[k] = W4[e];
  }
  row[16] = row[17] = col[16] = col[17] = 0;
  x[15] = 5;
  x[16] = -3;
  x[17] = 2;
  patch("fclib_local/W/nz", INTS, VALUES(18));
  patch("fclib_local/W/nzmax", INTS, VALUES(18));
  patch("fclib_local/W/p", LONGS, 18, col);
  patch("fclib_local/W/i", INTS, 18, row);
  patch("fclib_local/W/x", REALS, 18, x);
  check_local2(path);

  /* single precision is read as what it is */
  ck_assert_int_eq(write_local2(NULL), DLS_OK);
  patch("fclib_local/vectors/mu", FLOATS, VALUES(.3, 0));
  dls_fclib *file = read_well(path);
  dls_contact problem;
  ck_assert_int_eq(dls_fclib_contact(file, &problem, NULL), DLS_OK);
  ck_assert(problem.mu[0] == (double).3f && problem.mu[1] == 0);
  dls_fclib_destroy(file);

  /* no info at all, no bilateral constraint */
  patch("fclib_local/info", DELETE, 0, NULL);
  patch_size("fclib_local/V", 0, 4);
  patch("fclib_local/vectors/s", REALS, 0, NULL);
  file = read_well(path);
  ck_assert_str_eq(dls_fclib_title(file), "");
  dls_fclib_destroy(file);

  /* a title that is a number; half a solution */
  patch("fclib_local/info/title", REALS, VALUES(1));
  patch("solution/u", DELETE, 0, NULL);
  file = read_well(path);
  const double *r = NULL, *u = q4;
  ck_assert_str_eq(dls_fclib_title(file), "");
  ck_assert_int_eq(dls_fclib_solution(file, &r, &u, NULL), DLS_OK);
  ck_assert(r && !u);
  dls_fclib_destroy(file);

  /* a title of variable length */
  const hid_t h5 = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  const char *title = "of variable length";
  ck_assert_int_ge(H5Ldelete(h5, "fclib_local/info/title", H5P_DEFAULT), 0);
  ck_assert_int_ge(H5Tset_size(type, H5T_VARIABLE), 0);
  const hid_t set =
      H5Dcreate2(h5, "fclib_local/info/title", type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  ck_assert_int_ge(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, &title), 0);
  (void)H5Dclose(set);
  (void)H5Sclose(space);
  (void)H5Tclose(type);
  ck_assert_int_ge(H5Fclose(h5), 0);
  file = read_well(path);
  ck_assert_str_eq(dls_fclib_title(file), title);
  dls_fclib_destroy(file);

  /* both problems in one file: the local one */
  patch("fclib_local/vectors/mu", REALS, 2, mu2);
  patch("fclib_global/spacedim", INTS, VALUES(3));
  check_local2(path);
  (void)remove(path);
}

#define LIST(...)                                                                                  \
  sizeof((double[]){__VA_ARGS__}) / sizeof(double), {                                              \
    __VA_ARGS__                                                                                    \
  }
#define MISSING(set, argument)                                                                     \
  { set, DELETE, DLS_E_FORMAT, 0, {0}, argument, -1 }
#define W_I 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2
#define W_X 4, 1, -1, .5, 1, 3, .25, -2, -1, .125, 5, 1, .75, -2, 0

static const struct broken {
  const char *set; /* below the problem's group */
  action what;
  dls_status status;
  size_t count;
  double v[20];
  const char *argument;
  long long index;
} broken_local[] = {
    MISSING("spacedim", "spacedim"),
    MISSING("vectors/q", "vectors/q"),
    MISSING("vectors/mu", "vectors/mu"),
    MISSING("vectors", "vectors/q"),
    MISSING("W", "W/m"),
    MISSING("W/m", "W/m"),
    MISSING("W/n", "W/n"),
    MISSING("W/nz", "W/nz"),
    MISSING("W/nzmax", "W/nzmax"),
    MISSING("W/p", "W/p"),
    MISSING("W/i", "W/i"),
    MISSING("W/x", "W/x"),
    {"spacedim", INTS, DLS_E_FORMAT, LIST(1), "spacedim", -1},
    {"spacedim", INTS, DLS_E_FORMAT, LIST(4), "spacedim", -1},
    {"spacedim", INTS, DLS_E_FORMAT, LIST(2, 2), "spacedim", -1},
    {"spacedim", INTS, DLS_E_FORMAT, 0, {0}, "spacedim", -1},
    {"spacedim", TEXT, DLS_E_FORMAT, LIST(0), "spacedim", -1},
    {"spacedim", REALS, DLS_E_FORMAT, LIST(2), "spacedim", -1},
    {"spacedim/x", INTS, DLS_E_FORMAT, LIST(2), "spacedim", -1}, /* a group */
    {"spacedim", INTS, DLS_E_FORMAT, LIST(3), "W/m", -1},        /* m = 4 is no multiple of 3 */
    {"W/m", INTS, DLS_E_FORMAT, LIST(-1), "W/m", -1},
    {"W/m", INTS, DLS_E_FORMAT, LIST(0), "W/i", 0},
    {"W/m", INTS, DLS_E_FORMAT, LIST(3), "W/i", 3},
    {"W/m", INTS, DLS_E_FORMAT, LIST(6), "W/n", -1},
    {"W/m", INTS, DLS_E_FORMAT, LIST(INT_MAX), "W/m", -1},
    {"W/m", LONGS, DLS_E_FORMAT, LIST(1e15), "W/m", -1},
    {"W/n", INTS, DLS_E_FORMAT, LIST(-4), "W/n", -1},
    {"W/n", INTS, DLS_E_FORMAT, LIST(5), "W/p", -1},
    {"W/n", INTS, DLS_E_FORMAT, LIST(2000000000), "W/p", -1},
    {"W/n", INTS, DLS_E_FORMAT, LIST(3), "W/n", -1},
    {"W/nz", INTS, DLS_E_FORMAT, LIST(-3), "W/nz", -1},
    {"W/nz", INTS, DLS_E_FORMAT, LIST(16), "W/p", -1}, /* triplets: 16 column indices needed */
    {"W/nz", INTS, DLS_E_FORMAT, LIST(17), "W/nzmax", -1},
    {"W/nzmax", INTS, DLS_E_FORMAT, LIST(-1), "W/nzmax", -1},
    {"W/nzmax", INTS, DLS_E_FORMAT, LIST(10), "W/p", 3},
    {"W/p", INTS, DLS_E_FORMAT, LIST(1, 4, 8, 12, 16), "W/p", 0},
    {"W/p", INTS, DLS_E_FORMAT, LIST(0, 8, 4, 12, 16), "W/p", 2},
    {"W/p", INTS, DLS_E_FORMAT, LIST(0, 4, -8, 12, 16), "W/p", 2},
    {"W/p", INTS, DLS_E_FORMAT, LIST(0, 4, 8, 12, 17), "W/p", 4},
    {"W/p", LONGS, DLS_E_FORMAT, LIST(0, 4, 8, 12, 4294967312.), "W/p", 4},
    {"W/i", INTS, DLS_E_FORMAT, LIST(W_I, 4), "W/i", 15},
    {"W/i", INTS, DLS_E_FORMAT, LIST(W_I, -1), "W/i", 15},
    {"W/i", LONGS, DLS_E_FORMAT, LIST(W_I, 4294967296.), "W/i", 15},
    {"W/i", INTS, DLS_E_FORMAT, LIST(W_I), "W/i", -1},
    {"W/i", REALS, DLS_E_FORMAT, LIST(W_I, 3), "W/i", -1},
    {"W/x", REALS, DLS_E_FORMAT, LIST(W_X), "W/x", -1},
    {"W/x", REALS, DLS_E_FORMAT, LIST(W_X, NAN), "W/x", 15},
    {"W/x", REALS, DLS_E_FORMAT, LIST(W_X, INFINITY), "W/x", 15},
    {"W/x", TEXT, DLS_E_FORMAT, LIST(0), "W/x", -1},
    {"vectors/q", REALS, DLS_E_FORMAT, LIST(1, 2, 3), "vectors/q", -1},
    {"vectors/q", REALS, DLS_E_FORMAT, LIST(1, 2, 3, 4, 5), "vectors/q", -1},
    {"vectors/q", REALS, DLS_E_FORMAT, LIST(1, 2, NAN, 4), "vectors/q", 2},
    {"vectors/q", UNWRITTEN, DLS_E_FORMAT, 4, {0}, "vectors/q", -1},
    {"vectors/mu", REALS, DLS_E_FORMAT, LIST(.1), "vectors/mu", -1},
    {"vectors/mu", REALS, DLS_E_FORMAT, LIST(.1, -.1), "vectors/mu", 1},
    {"vectors/mu", REALS, DLS_E_FORMAT, LIST(NAN, .1), "vectors/mu", 0},
    {"vectors/s", REALS, DLS_E_UNSUPPORTED, LIST(1), "vectors/s", -1},
    {"V/m", INTS, DLS_E_FORMAT, LIST(1), "V/n", -1},
    {"../solution/r", REALS, DLS_E_FORMAT, LIST(1, 2, 3), "r", -1},
    {"../solution/r", REALS, DLS_E_FORMAT, LIST(1, 2, 3, NAN), "r", 3},
    {"../solution/u", REALS, DLS_E_FORMAT, LIST(1, 2, 3, NAN), "u", 3},
    {"../solution", REALS, DLS_E_FORMAT, LIST(1, 2, 3, 4), "solution", -1},
};

static const struct broken broken_global[] = {
    {"spacedim", INTS, DLS_E_FORMAT, LIST(2), "vectors/mu", -1}, /* 3 candidates in 2D */
    MISSING("vectors/f", "vectors/f"),
    MISSING("vectors/w", "vectors/w"),
    MISSING("vectors/mu", "vectors/mu"),
    MISSING("M", "M/m"),
    MISSING("H", "H/m"),
    {"M/m", INTS, DLS_E_FORMAT, LIST(4), "M/n", -1},
    {"M/x", REALS, DLS_E_FORMAT, LIST(1, NAN, 1, 1, 1), "M/x", 1},
    {"M/i", INTS, DLS_E_FORMAT, LIST(0, 2, 1, 0, 3), "M/i", 4},
    {"H/m", INTS, DLS_E_FORMAT, LIST(4), "H/m", -1},
    {"H/n", INTS, DLS_E_FORMAT, LIST(5), "H/n", -1}, /* no multiple of 3 */
    {"H/i", INTS, DLS_E_FORMAT, LIST(0, 1, 2, 0, 1, 3), "H/i", 5},
    {"vectors/f", REALS, DLS_E_FORMAT, LIST(1, 2), "vectors/f", -1},
    {"vectors/f", REALS, DLS_E_FORMAT, LIST(1, 2, -INFINITY), "vectors/f", 2},
    {"vectors/w", REALS, DLS_E_FORMAT, LIST(1, 2, 3, 4, 5), "vectors/w", -1},
    {"vectors/w", REALS, DLS_E_FORMAT, LIST(1, 2, 3, 4, NAN, 6), "vectors/w", 4},
    {"vectors/mu", REALS, DLS_E_FORMAT, LIST(-1, 0), "vectors/mu", 0},
    {"vectors/b", REALS, DLS_E_FORMAT, LIST(1), "vectors/b", -1}, /* without G */
    {"../solution/u", REALS, DLS_E_FORMAT, LIST(1, 2), "u", -1},
};

static void apply(const char *group, const struct broken *b) {
  char name[64];
  if (strncmp(b->set, "../", 3) == 0)
    (void)snprintf(name, sizeof name, "%s", b->set + 3);
  else
    (void)snprintf(name, sizeof name, "%s/%s", group, b->set);
  if (strcmp(b->set, "spacedim/x") == 0) patch("fclib_local/spacedim", DELETE, 0, NULL);
  patch(name, b->what, b->count, b->v);
}

/* Where an entry of what was patched is refused, the error tells its value. */
static void check_broken(const struct broken *b) {
  const double told = check_refused(path, b->status, b->argument, b->index);
  const char *last = strrchr(b->set, '/');
  if (strcmp(b->argument, b->set) != 0 && strcmp(b->argument, last ? last + 1 : b->set) != 0)
    return;
  if (b->index < 0 || b->what == LONGS) return; /* an int tells of those as far as it goes */
  ck_assert_int_lt(b->index, (long long)b->count);
  const double value = b->v[b->index];
  ck_assert_msg(told == value || (told != told && value != value), "%s: %g", b->set, told);
}

TEST_EACH(broken_local_file, 0, (int)(sizeof broken_local / sizeof broken_local[0])) {
  ck_assert_int_eq(write_local2(NULL), DLS_OK);
  apply("fclib_local", &broken_local[_i]);
  check_broken(&broken_local[_i]);
  (void)remove(path);
}

TEST_EACH(broken_global_file, 0, (int)(sizeof broken_global / sizeof broken_global[0])) {
  ck_assert_int_eq(write_model3(NULL), DLS_OK);
  apply("fclib_global", &broken_global[_i]);
  check_broken(&broken_global[_i]);
  (void)remove(path);
}

TEST(broken_together) {
  /* two thousand million rows without an entry: nothing vouches for them but q, which is short */
  ck_assert_int_eq(write_local2(NULL), DLS_OK);
  patch_size("fclib_local/W", 2e9, 2e9);
  patch("fclib_local/W/nz", INTS, VALUES(0));
  check_refused(path, DLS_E_FORMAT, "vectors/q", -1);
  patch("fclib_local/vectors/q", UNWRITTEN, (size_t)2e9, NULL);
  check_refused(path, DLS_E_FORMAT, "vectors/q", -1);
  /* two thousand million entries in column 3, of which i has 16 */
  ck_assert_int_eq(write_local2(NULL), DLS_OK);
  patch("fclib_local/W/nzmax", INTS, VALUES(2e9));
  patch("fclib_local/W/p", INTS, VALUES(0, 4, 8, 12, 2e9));
  check_refused(path, DLS_E_FORMAT, "W/i", -1);

  ck_assert_int_eq(write_local2(NULL), DLS_OK);
  patch_size("fclib_local/R", 1, 1);
  check_refused(path, DLS_E_UNSUPPORTED, "R", -1);
  patch_size("fclib_local/V", 4, 1);
  check_refused(path, DLS_E_UNSUPPORTED, "V", -1);
  patch("fclib_local", DELETE, 0, NULL);
  check_refused(path, DLS_E_FORMAT, "path", -1);
  patch("fclib_local", INTS, VALUES(1));
  check_refused(path, DLS_E_FORMAT, "path", -1);

  ck_assert_int_eq(write_model3(NULL), DLS_OK);
  patch_size("fclib_global/M", 0, 0);
  patch("fclib_global/M/p", INTS, VALUES(0));
  check_refused(path, DLS_E_FORMAT, "M/m", -1);

  ck_assert_int_eq(write_model3(NULL), DLS_OK);
  patch_size("fclib_global/G", 3, 1);
  check_refused(path, DLS_E_FORMAT, "G/nz", -1);
  patch("fclib_global/G/nz", INTS, VALUES(1));
  patch("fclib_global/G/nzmax", INTS, VALUES(1));
  patch("fclib_global/G/p", INTS, VALUES(0));
  patch("fclib_global/G/i", INTS, VALUES(3));
  patch("fclib_global/G/x", REALS, VALUES(1));
  check_refused(path, DLS_E_FORMAT, "G/i", 0);
  patch("fclib_global/G/i", INTS, VALUES(2));
  check_refused(path, DLS_E_FORMAT, "vectors/b", -1);
  patch("fclib_global/vectors/b", REALS, VALUES(1, 2));
  check_refused(path, DLS_E_FORMAT, "vectors/b", -1);
  patch("fclib_global/vectors/b", REALS, VALUES(NAN));
  check_refused(path, DLS_E_FORMAT, "vectors/b", 0);
  patch("fclib_global/vectors/b", REALS, VALUES(1));
  patch("fclib_global/G/m", INTS, VALUES(4));
  check_refused(path, DLS_E_FORMAT, "G/m", -1);
  patch("fclib_global/G/m", INTS, VALUES(3));
  dls_fclib_destroy(read_well(path));
  patch("fclib_global/G/n", INTS, VALUES(0));
  patch("fclib_global/vectors/b", DELETE, 0, NULL);
  dls_fclib_destroy(read_well(path));
  (void)remove(path);
}

static int handler_calls;

static herr_t count_calls(hid_t stack, void *data) {
  (void)stack;
  (void)data;
  handler_calls++;
  return 0;
}

TEST(no_whole_hdf5_file) {
  check_refused(path, DLS_E_FILE, "path", -1); /* missing */
  check_refused(scratch, DLS_E_FILE, "path", -1);
  write_text(path, "");
  check_refused(path, DLS_E_FORMAT, "path", -1);
  write_text(path, good_mtx[0].text);
  check_refused(path, DLS_E_FORMAT, "path", -1);

  /* cut short at any length */
  size_t size = 0;
  ck_assert_int_eq(write_local2(NULL), DLS_OK);
  char *bytes = read_bytes(path, &size);
  for (size_t length = 1; length < size; length += 97) {
    write_bytes(path, bytes, length);
    check_refused(path, DLS_E_FORMAT, "path", -1);
  }
  write_bytes(path, bytes, size);
  free(bytes);

  /* the host's error handler hears nothing and stays */
  H5E_auto2_t before = NULL, after = NULL;
  void *data = NULL;
  handler_calls = 0;
  ck_assert_int_ge(H5Eget_auto2(H5E_DEFAULT, &before, &data), 0);
  ck_assert_int_ge(H5Eset_auto2(H5E_DEFAULT, count_calls, path), 0);
  patch("fclib_local/W/x", DELETE, 0, NULL);
  handler_calls = 0;
  check_refused(path, DLS_E_FORMAT, "W/x", -1);
  (void)remove(path);
  check_refused(path, DLS_E_FILE, "path", -1);
  ck_assert_int_eq(write_local2(NULL), DLS_OK);
  check_local2(path);
  ck_assert_int_eq(handler_calls, 0);
  void *kept = NULL;
  ck_assert_int_ge(H5Eget_auto2(H5E_DEFAULT, &after, &kept), 0);
  ck_assert(after == count_calls && kept == path);
  ck_assert_int_ge(H5Eset_auto2(H5E_DEFAULT, before, data), 0);
  (void)remove(path);
}

TEST(fclib_arguments) {
  dls_fclib *local = NULL, *global = NULL;
  REFUSES(ARGUMENT, "out", -1, dls_fclib_read, NULL, path);
  local = (dls_fclib *)&local;
  REFUSES(ARGUMENT, "path", -1, dls_fclib_read, &local, NULL);
  ck_assert_ptr_null(local);
  dls_fclib_destroy(NULL);
  ck_assert_int_eq(dls_fclib_is_global(NULL), 0);
  ck_assert_str_eq(dls_fclib_title(NULL), "");

  ck_assert_int_eq(write_local2(NULL), DLS_OK);
  local = read_well(path);
  ck_assert_int_eq(write_model3(NULL), DLS_OK);
  global = read_well(path);
  dls_contact problem = {.d = 77};
  dls_model model = {.d = 77};
  const double *f = q4, *g = q4, *mu = q4, *r = q4, *u = q4;
  REFUSES(ARGUMENT, "file", -1, dls_fclib_contact, NULL, &problem);
  REFUSES(ARGUMENT, "file", -1, dls_fclib_contact, global, &problem);
  REFUSES(ARGUMENT, "problem", -1, dls_fclib_contact, local, NULL);
  REFUSES(ARGUMENT, "file", -1, dls_fclib_model, NULL, &model, &f, &g, &mu);
  REFUSES(ARGUMENT, "file", -1, dls_fclib_model, local, &model, &f, &g, &mu);
  REFUSES(ARGUMENT, "model", -1, dls_fclib_model, global, NULL, &f, &g, &mu);
  REFUSES(ARGUMENT, "f", -1, dls_fclib_model, global, &model, NULL, &g, &mu);
  REFUSES(ARGUMENT, "g", -1, dls_fclib_model, global, &model, &f, NULL, &mu);
  REFUSES(ARGUMENT, "mu", -1, dls_fclib_model, global, &model, &f, &g, NULL);
  REFUSES(ARGUMENT, "file", -1, dls_fclib_solution, NULL, &r, &u);
  REFUSES(ARGUMENT, "r", -1, dls_fclib_solution, local, NULL, &u);
  REFUSES(ARGUMENT, "u", -1, dls_fclib_solution, local, &r, NULL);
  ck_assert(problem.d == 77 && model.d == 77 && f == q4 && g == q4 && mu == q4 && r == q4 &&
            u == q4);
  dls_fclib_destroy(local);
  dls_fclib_destroy(global);
  (void)remove(path);
}

/* status of writing `problem` and `model`, with one argument after the other spoilt */
TEST(write_arguments) {
  dls_error error = {0};
  const double bad4[4] = {1, 2, NAN, 4}, bad5[5] = {1, 2, NAN, 4, 5},
               bad6[6] = {0, 1, 2, 3, 4, INFINITY}, minus[2] = {1, -1};
  dls_contact problem = local2;
  REFUSES(ARGUMENT, "path", -1, dls_fclib_write_local, NULL, &problem, "", r4, u4);
  REFUSES(ARGUMENT, "problem", -1, dls_fclib_write_local, path, NULL, "", r4, u4);
  REFUSES(ARGUMENT, "r", -1, dls_fclib_write_local, path, &problem, "", NULL, u4);
  REFUSES(ARGUMENT, "u", -1, dls_fclib_write_local, path, &problem, "", r4, NULL);
  REFUSES(NOT_FINITE, "r", 2, dls_fclib_write_local, path, &problem, "", bad4, u4);
  REFUSES(NOT_FINITE, "u", 2, dls_fclib_write_local, path, &problem, "", r4, bad4);
  problem.q = bad4;
  REFUSES(NOT_FINITE, "q", 2, dls_fclib_write_local, path, &problem, "", r4, u4);

  const double one[1] = {1}, free_of[1] = {0}, bonded[2] = {0.5, INFINITY};
  const dls_contact line = {.d = 1, .nc = 1, .W = {1, 1, 1, one}, .q = one, .mu = free_of};
  REFUSES(UNSUPPORTED, "d", -1, dls_fclib_write_local, path, &line, "", NULL, NULL);
  ck_assert(last_refusal.value == 1);
  problem = local2;
  problem.mu = bonded;
  REFUSES(NOT_FINITE, "mu", 1, dls_fclib_write_local, path, &problem, "", r4, u4);
  const int active[3] = {1, 1, 1};
  dls_model some = model3;
  some.active = active;
  REFUSES(UNSUPPORTED, "active", -1, dls_fclib_write_global, path, &some, f3, g6, mu3, "", x3, r6,
          u6);
  ck_assert(last_refusal.value == 0);

  static const struct {
    const char *argument;
    dls_status status;
    long long index;
  } expected[] = {
      {"d", DLS_E_ARGUMENT, -1},    {"n", DLS_E_SIZE, -1},
      {"nodes", DLS_E_SIZE, -1},    {"nodes", DLS_E_SIZE, -1},
      {"P", DLS_E_UNSUPPORTED, -1}, {"operator_kind", DLS_E_UNSUPPORTED, -1},
      {"K", DLS_E_ARGUMENT, -1},    {"Ks", DLS_E_SIZE, -1},
      {"Ks", DLS_E_NOT_FINITE, 2},  {"HN", DLS_E_SIZE, -1},
      {"HT", DLS_E_ARGUMENT, -1},
  };
  for (int k = 0; k < (int)(sizeof expected / sizeof expected[0]); k++) {
    dls_model model = model3;
    if (k == 0) model.d = 4;
    if (k == 1) model.n = 0;
    if (k == 2) model.nodes = -1;
    if (k == 3) model.nodes = INT_MAX / 3 + 1;
    if (k == 4) model.P = model.HN;
    if (k == 5) model.operator_kind = DLS_FLEXIBILITY;
    if (k == 6) model.operator_kind = DLS_STIFFNESS_DENSE;
    if (k == 7) model.Ks.rows = 2;
    if (k == 8) model.Ks.x = bad5;
    if (k == 9) model.HN.cols = 3;
    if (k == 10) model.HT.p = NULL;
    check_error(&error, dls_fclib_write_global(path, &model, f3, g6, mu3, "", x3, r6, u6, &error),
                expected[k].status, expected[k].argument, expected[k].index);
  }
#define WRITE(f, g, mu, x, r, u)                                                                   \
  dls_fclib_write_global(path, &model3, f, g, mu, "", x, r, u, &error)
  REFUSES(ARGUMENT, "path", -1, dls_fclib_write_global, NULL, &model3, f3, g6, mu3, "", x3, r6, u6);
  REFUSES(ARGUMENT, "model", -1, dls_fclib_write_global, path, NULL, f3, g6, mu3, "", x3, r6, u6);
  check_error(&error, WRITE(NULL, g6, mu3, x3, r6, u6), DLS_E_ARGUMENT, "f", -1);
  check_error(&error, WRITE(bad4, g6, mu3, x3, r6, u6), DLS_E_NOT_FINITE, "f", 2);
  check_error(&error, WRITE(f3, NULL, mu3, x3, r6, u6), DLS_E_ARGUMENT, "g", -1);
  check_error(&error, WRITE(f3, bad6, mu3, x3, r6, u6), DLS_E_NOT_FINITE, "g", 5);
  check_error(&error, WRITE(f3, g6, NULL, x3, r6, u6), DLS_E_ARGUMENT, "mu", -1);
  check_error(&error, WRITE(f3, g6, bad4 + 2, x3, r6, u6), DLS_E_NOT_FINITE, "mu", 0);
  check_error(&error, WRITE(f3, g6, minus, x3, r6, u6), DLS_E_ARGUMENT, "mu", 1);
  check_error(&error, WRITE(f3, g6, mu3, bad4, r6, u6), DLS_E_NOT_FINITE, "x", 2);
  check_error(&error, WRITE(f3, g6, mu3, x3, bad6, u6), DLS_E_NOT_FINITE, "r", 5);
  check_error(&error, WRITE(f3, g6, mu3, x3, r6, bad6), DLS_E_NOT_FINITE, "u", 5);
  check_error(&error, WRITE(f3, g6, mu3, x3, r6, NULL), DLS_E_ARGUMENT, "u", -1);
  ck_assert(!exists(path));

  /* what the file system refuses */
  REFUSES(FILE, "path", -1, dls_fclib_write_local, scratch, &local2, "", r4, u4);
  char other[sizeof scratch + 16];
  (void)snprintf(other, sizeof other, "%s/no/file", scratch);
  REFUSES(FILE, "path", -1, dls_fclib_write_local, other, &local2, "", r4, u4);
  dls_status status = DLS_OK;
  ON_A_FULL_DISK(5000, status = write_local2(&error));
  check_error(&error, status, DLS_E_FILE, "path", -1);
  ck_assert(!exists(path));
  ON_A_FULL_DISK(5000, status = write_model3(&error));
  check_error(&error, status, DLS_E_FILE, "path", -1);
  ck_assert(!exists(path));
  no_handle_is_open();
}

TEST(fclib_malloc_fails) {
  dls_error e = {0};
  for (int global = 0; global < 2; global++) {
    ck_assert_int_eq(global ? write_model3(NULL) : write_local2(NULL), DLS_OK);
    dls_fclib *file;
    MALLOCS_FAIL((file = (dls_fclib *)&file, dls_fclib_read(&file, path, &e)),
                 (no_handle_is_open(), !file && of_memory(&e)), DLS_OK, 15);
    no_handle_is_open();
    dls_fclib_destroy(file);
    (void)remove(path);
    MALLOCS_FAIL(global ? write_model3(&e) : write_local2(&e),
                 (no_handle_is_open(), !exists(path) && of_memory(&e)), DLS_OK, 4);
    no_handle_is_open();
  }
  /* the mirrored lower triangle takes memory of its own */
  dls_model model = model3;
  model.factorization = DLS_CHOLESKY;
  (void)remove(path);
  MALLOCS_FAIL(dls_fclib_write_global(path, &model, f3, g6, mu3, NULL, NULL, NULL, NULL, &e),
               !exists(path) && of_memory(&e), DLS_OK, 10);
  (void)remove(path);
}

#else

TEST(without_hdf5) {
  dls_fclib *file = (dls_fclib *)&file;
  const double *v = NULL;
  REFUSES(FILE, "path", -1, dls_fclib_read, &file, path);
  ck_assert_ptr_null(file);
  REFUSES(UNSUPPORTED, "", -1, dls_fclib_read, &file, TEST_DATA "/fclib/FC3D_Example1.hdf5");
  ck_assert_ptr_null(file);
  ck_assert_int_eq(dls_fclib_is_global(NULL), 0);
  ck_assert_str_eq(dls_fclib_title(NULL), "");
  REFUSES(UNSUPPORTED, "", -1, dls_fclib_contact, NULL, NULL);
  REFUSES(UNSUPPORTED, "", -1, dls_fclib_model, NULL, NULL, &v, &v, &v);
  REFUSES(UNSUPPORTED, "", -1, dls_fclib_solution, NULL, &v, &v);
  REFUSES(UNSUPPORTED, "", -1, dls_fclib_write_local, path, NULL, NULL, NULL, NULL);
  REFUSES(UNSUPPORTED, "", -1, dls_fclib_write_global, path, NULL, NULL, NULL, NULL, NULL, NULL,
          NULL, NULL);
  dls_fclib_destroy(NULL);
  ck_assert(!exists(path));
}

#endif

int main(void) {
  if (!mkdtemp(scratch)) return EXIT_FAILURE;
  (void)snprintf(path, sizeof path, "%s/file", scratch);
  const int status = run_tests("files", NULL, NULL);
  (void)remove(path);
  (void)rmdir(scratch);
  return status;
}
