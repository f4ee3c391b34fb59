/*
 * test_assemble.c: tests the sparse stiffness and mass of both elements, the small-strain element
 * of four nodes, and collections of files.
 */
#define _XOPEN_SOURCE 700 /* mkdtemp */

#include <unistd.h>

#include "delassus/fe.h"
#include "run.h"

enum { nx = 5, ny = 4, nodes = (nx + 1) * (ny + 1), n = 2 * nodes };
static const double lx = 3, ly = 2, E0 = 2.75, nu0 = 0.375; /* G = 1, l = 3 */
static const double eps = DBL_EPSILON;
static dls_error error;

/* A block of triangles (kind 3) or four-node elements (4), nodes inside moved off the lattice. */
static dls_fe_mesh crooked(int kind) {
  dls_fe_mesh mesh;
  ck_assert_int_eq((kind == 3 ? dls_fe_mesh_block : dls_fe_mesh_quads)(&mesh, lx, ly, nx, ny, NULL),
                   DLS_OK);
  ck_assert_int_eq(mesh.nodes, nodes);
  for (int i = 0; i < nodes; i++) {
    const int column = i % (nx + 1), row = i / (nx + 1);
    if (column > 0 && column < nx) mesh.xy[2 * i] += 0.12 * sin(3.0 * i);
    if (row > 0 && row < ny) mesh.xy[2 * i + 1] += 0.1 * cos(5.0 * i);
  }
  return mesh;
}

/* y := A x */
static void multiply(const dls_sparse *A, const double *x, double *y) {
  memset(y, 0, (size_t)A->rows * sizeof *y);
  for (int j = 0; j < A->cols; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      y[A->i[k]] += A->x[k] * x[j];
}

static double dot(const double *x, const double *y, int count) {
  double sum = 0;
  for (int i = 0; i < count; i++)
    sum += x[i] * y[i];
  return sum;
}

/* Writes A as a full matrix; rows must increase in each column. */
static void expand(const dls_sparse *A, double *full) {
  memset(full, 0, (size_t)A->rows * (size_t)A->cols * sizeof *full);
  for (int j = 0; j < A->cols; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++) {
      ck_assert(k == A->p[j] || A->i[k] > A->i[k - 1]);
      full[A->i[k] + A->rows * j] = A->x[k];
    }
}

TEST_EACH(sparse_is_dense, 3, 5) {
  const int kind = _i;
  dls_fe_mesh mesh = crooked(kind);
  static double K[n * n], S[n * n];
  dls_fe_matrix sparse;
  ck_assert_int_eq(dls_fe_stiffness(&mesh, E0, nu0, K, n, NULL), DLS_OK);
  ck_assert_int_eq(dls_fe_sparse_stiffness(&mesh, E0, nu0, NULL, 0, &sparse, NULL), DLS_OK);
  ck_assert(sparse.A.rows == n && sparse.A.cols == n);
  expand(&sparse.A, S);
  for (int k = 0; k < n * n; k++) {
    ck_assert(S[k] == K[k]); /* the same sums in the same order */
    ck_assert(K[k] == K[k / n + n * (k % n)]);
  }
  dls_fe_matrix_free(&sparse);
  ck_assert(!sparse.memory && !sparse.A.p);
  dls_fe_matrix_free(&sparse);
  dls_fe_matrix_free(NULL);
  dls_fe_mesh_free(&mesh);
}

/* Supports are left out; unknowns that share a number add up: Z^T K Z with the 0/1 matrix Z. */
TEST_EACH(numbered, 0, 6) {
  const int kind = _i % 2 + 3, mass = _i / 2;
  dls_fe_mesh mesh = crooked(kind);
  static double whole[n * n], part[n * n];
  int unknown[n];
  for (int k = 0; k < n; k++)
    unknown[k] = k < 6 ? -1 : (k - 6) / 3;
  const int count = (n - 7) / 3 + 1;
  dls_fe_matrix all, few;
  if (mass == 0) {
    ck_assert_int_eq(dls_fe_sparse_stiffness(&mesh, E0, nu0, NULL, 0, &all, NULL), DLS_OK);
    ck_assert_int_eq(dls_fe_sparse_stiffness(&mesh, E0, nu0, unknown, count, &few, NULL), DLS_OK);
  } else {
    const dls_fe_mass_kind how = mass == 1 ? DLS_FE_CONSISTENT : DLS_FE_LUMPED;
    ck_assert_int_eq(dls_fe_mass(&mesh, 7, how, NULL, 0, &all, NULL), DLS_OK);
    ck_assert_int_eq(dls_fe_mass(&mesh, 7, how, unknown, count, &few, NULL), DLS_OK);
  }
  ck_assert_int_eq(few.A.rows, count);
  expand(&all.A, whole);
  expand(&few.A, part);
  for (int j = 0; j < count; j++)
    for (int i = 0; i < count; i++) {
      double sum = 0, size = 0;
      for (int l = 0; l < n; l++)
        for (int k = 0; k < n; k++)
          if (unknown[k] == i && unknown[l] == j) {
            sum += whole[k + n * l];
            size += fabs(whole[k + n * l]);
          }
      ck_assert_double_le(fabs(part[i + count * j] - sum), 8 * eps * size);
    }
  dls_fe_matrix_free(&all);
  dls_fe_matrix_free(&few);
  dls_fe_mesh_free(&mesh);
}

/* Integrals of rho times products of linear fields over the rectangle: exact on every mesh for the
 * consistent mass; the lumped one has the mass and the centre of mass. */
TEST_EACH(mass_of_a_rectangle, 0, 4) {
  const int kind = _i % 2 + 3, lumped = _i / 2;
  const double rho = 7, area = lx * ly;
  dls_fe_mesh mesh = crooked(kind);
  dls_fe_matrix M;
  ck_assert_int_eq(
      dls_fe_mass(&mesh, rho, lumped ? DLS_FE_LUMPED : DLS_FE_CONSISTENT, NULL, 0, &M, NULL),
      DLS_OK);
  if (lumped) ck_assert_int_eq(M.A.p[n], n);
  double field[4][n] = {{0}}, y[n];
  for (int i = 0; i < nodes; i++) {
    field[0][2 * i] = 1;
    field[1][2 * i] = mesh.xy[2 * i];
    field[2][2 * i] = mesh.xy[2 * i + 1];
    field[3][2 * i + 1] = 1;
  }
  /* 1, x, y in the x component; 1 in y */
  const double moments[4][4] = {{1, lx / 2, ly / 2, 0},
                                {lx / 2, lx * lx / 3, lx * ly / 4, 0},
                                {ly / 2, lx * ly / 4, ly * ly / 3, 0},
                                {0, 0, 0, 1}};
  for (int a = 0; a < 4; a++) {
    multiply(&M.A, field[a], y);
    for (int b = 0; b < 4; b++)
      if (!lumped || a == 0 || b == 0 || a == 3 || b == 3)
        ck_assert_double_le(fabs(dot(y, field[b], n) - rho * area * moments[a][b]),
                            1e-14 * rho * area * lx * lx);
  }
  dls_fe_matrix_free(&M);
  dls_fe_mesh_free(&mesh);
}

/* One square [0,1]^2, rho = 36: M_ab = 4, 2, 1 for a = b, an edge, a diagonal; lumped 9. */
TEST(mass_by_hand) {
  dls_fe_mesh mesh;
  dls_fe_matrix M;
  double full[64];
  ck_assert_int_eq(dls_fe_mesh_quads(&mesh, 1, 1, 1, 1, NULL), DLS_OK);
  ck_assert_int_eq(dls_fe_mass(&mesh, 36, DLS_FE_CONSISTENT, NULL, 0, &M, NULL), DLS_OK);
  expand(&M.A, full);
  const double wanted[4][4] = {{4, 2, 2, 1}, {2, 4, 1, 2}, {2, 1, 4, 2}, {1, 2, 2, 4}};
  for (int i = 0; i < 8; i++)
    for (int j = 0; j < 8; j++)
      ck_assert_double_eq_tol(full[i + 8 * j], i % 2 == j % 2 ? wanted[i / 2][j / 2] : 0, 1e-14);
  dls_fe_matrix_free(&M);
  ck_assert_int_eq(dls_fe_mass(&mesh, 36, DLS_FE_LUMPED, NULL, 0, &M, NULL), DLS_OK);
  for (int k = 0; k < 8; k++)
    ck_assert_double_eq_tol(M.A.x[k], 9, 1e-14);
  dls_fe_matrix_free(&M);
  dls_fe_mesh_free(&mesh);
}

/* u = (x + 2y, 3x - y/2): e = (1, -1/2, 5), s = (3.5, 0.5, 5): no forces inside, no forces and no
 * stress of rigid motions. */
TEST(quad_patch) {
  dls_fe_mesh mesh = crooked(4);
  dls_fe_matrix K;
  double u[n], f[n], stress[3 * nx * ny];
  ck_assert_int_eq(dls_fe_sparse_stiffness(&mesh, E0, nu0, NULL, 0, &K, NULL), DLS_OK);
  for (int rigid = 0; rigid < 2; rigid++) {
    for (int i = 0; i < nodes; i++) {
      const double x = mesh.xy[2 * i], y = mesh.xy[2 * i + 1];
      u[2 * i] = rigid ? 1 - 2 * y : x + 2 * y;
      u[2 * i + 1] = rigid ? 3 + 2 * x : 3 * x - y / 2;
    }
    multiply(&K.A, u, f);
    ck_assert_int_eq(dls_fe_stress(&mesh, E0, nu0, u, stress, NULL), DLS_OK);
    for (int e = 0; e < nx * ny; e++) {
      ck_assert_double_eq_tol(stress[3 * e], rigid ? 0 : 3.5, 1e-12);
      assert_near(stress + 3 * e + 1, (double[]){rigid ? 0 : 0.5, rigid ? 0 : 5}, 2, 1e-12);
    }
    for (int i = 0; i < nodes; i++) {
      const int column = i % (nx + 1), row = i / (nx + 1);
      const int inside = column > 0 && column < nx && row > 0 && row < ny;
      if (inside || rigid) ck_assert_double_le(fabs(f[2 * i]) + fabs(f[2 * i + 1]), 1e-12);
    }
  }
  dls_fe_matrix_free(&K);
  dls_fe_mesh_free(&mesh);
}

TEST(bad_input) {
  dls_fe_mesh mesh = crooked(4), bad = mesh;
  dls_fe_matrix A = {.memory = &mesh}, before = A;
  int unknown[n];
  for (int k = 0; k < n; k++)
    unknown[k] = k;
  const char *f = "dls_fe_mass", *g = "dls_fe_sparse_stiffness";
  const dls_fe_mass_kind kind = DLS_FE_CONSISTENT;
#define MASS(mesh, rho, kind, unknown, count, M)                                                   \
  dls_fe_mass(mesh, rho, kind, unknown, count, M, &error)
  expect_error(MASS(NULL, 1, kind, NULL, 0, &A), &error, DLS_E_ARGUMENT, f, "mesh", -1);
  expect_error(MASS(&mesh, 0, kind, NULL, 0, &A), &error, DLS_E_ARGUMENT, f, "rho", -1);
  expect_error(MASS(&mesh, NAN, kind, NULL, 0, &A), &error, DLS_E_ARGUMENT, f, "rho", -1);
  expect_error(MASS(&mesh, 1, (dls_fe_mass_kind)3, NULL, 0, &A), &error, DLS_E_ARGUMENT, f, "kind",
               -1);
  expect_error(MASS(&mesh, 1, kind, NULL, 0, NULL), &error, DLS_E_ARGUMENT, f, "M", -1);
  expect_error(MASS(&mesh, 1, kind, unknown, 0, &A), &error, DLS_E_SIZE, f, "unknowns", -1);
  expect_error(MASS(&mesh, 1, kind, unknown, n + 1, &A), &error, DLS_E_SIZE, f, "unknowns", -1);
  expect_error(MASS(&mesh, 1, kind, unknown, n - 1, &A), &error, DLS_E_ARGUMENT, f, "unknown",
               n - 1);
  unknown[5] = -2;
  expect_error(MASS(&mesh, 1, kind, unknown, n, &A), &error, DLS_E_ARGUMENT, f, "unknown", 5);
  unknown[5] = 4; /* no unknown has the number 5 */
  expect_error(MASS(&mesh, 1, kind, unknown, n, &A), &error, DLS_E_ARGUMENT, f, "unknown", 5);
#undef MASS
#define STIFFNESS(mesh, E, nu, K) dls_fe_sparse_stiffness(mesh, E, nu, NULL, 0, K, &error)
  expect_error(STIFFNESS(&mesh, 0, 0, &A), &error, DLS_E_ARGUMENT, g, "E", -1);
  expect_error(STIFFNESS(&mesh, 1, 0.5, &A), &error, DLS_E_ARGUMENT, g, "nu", -1);
  expect_error(STIFFNESS(&mesh, 1, 0, NULL), &error, DLS_E_ARGUMENT, g, "K", -1);
  bad.quads = -1;
  expect_error(STIFFNESS(&bad, 1, 0, &A), &error, DLS_E_SIZE, g, "quads", -1);
  bad.quads = mesh.quads;
  bad.triangles = 1; /* not both */
  expect_error(STIFFNESS(&bad, 1, 0, &A), &error, DLS_E_SIZE, g, "quads", -1);
  bad.triangles = 0;
  bad.quad = NULL;
  expect_error(STIFFNESS(&bad, 1, 0, &A), &error, DLS_E_ARGUMENT, g, "quad", -1);
  mesh.quad[7] += nodes;
  expect_error(STIFFNESS(&mesh, 1, 0, &A), &error, DLS_E_ARGUMENT, g, "quad", 7);
  mesh.quad[7] -= nodes;
  for (int k = 0; k < 2; k++) { /* clockwise, then not convex */
    const double x = mesh.xy[0], y = mesh.xy[1];
    const int first = mesh.quad[1];
    if (k == 0) {
      mesh.quad[1] = mesh.quad[3];
      mesh.quad[3] = first;
    } else {
      mesh.xy[0] = mesh.xy[2 * mesh.quad[2]];
      mesh.xy[1] = mesh.xy[2 * mesh.quad[2] + 1];
    }
    expect_error(STIFFNESS(&mesh, 1, 0, &A), &error, DLS_E_ARGUMENT, g, "quad", 0);
    if (k == 0) {
      mesh.quad[3] = mesh.quad[1];
      mesh.quad[1] = first;
    }
    mesh.xy[0] = x;
    mesh.xy[1] = y;
  }
#undef STIFFNESS
  ck_assert(memcmp(&A, &before, sizeof A) == 0);
  for (int k = 1; k <= 4; k++) { /* every allocation in turn */
    malloc_fails_at(k);
    REFUSES(MEMORY, "", -1, dls_fe_mass, &mesh, 1, kind, NULL, 0, &A);
  }
  malloc_fails_at(0);
  ck_assert(memcmp(&A, &before, sizeof A) == 0);
  dls_fe_mesh_free(&mesh);
}

/* ---- collections ----------------------------------------------------------------------------- */

static char folder[256], path[300];

static void make_folder(void) {
  const char *place = getenv("TMPDIR");
  (void)snprintf(folder, sizeof folder, "%.200s/test_assemble-XXXXXX", place ? place : "/tmp");
  ck_assert_ptr_nonnull(mkdtemp(folder));
  (void)snprintf(path, sizeof path, "%s/series.pvd", folder);
}
static void remove_folder(void) {
  (void)remove(path);
  ck_assert_int_eq(rmdir(folder), 0);
}

static void expect_text(const char *wanted) {
  char text[1000] = "";
  FILE *file = fopen(path, "r");
  ck_assert_ptr_nonnull(file);
  text[fread(text, 1, sizeof text - 1, file)] = '\0';
  ck_assert_int_eq(fclose(file), 0);
  ck_assert_str_eq(text, wanted);
}

#define HEAD                                                                                       \
  "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n"
#define ROW  "<DataSet timestep=\"0.25\" part=\"0\" file=\"step_0001.vtu\"/>\n"
#define TAIL "</Collection>\n</VTKFile>\n"

TEST(series) {
  dls_fe_series *s;
  ck_assert_int_eq(dls_fe_series_create(&s, path, NULL), DLS_OK);
  ck_assert_int_eq(dls_fe_series_add(s, 0.25, 0, "step_0001.vtu", NULL), DLS_OK);
  expect_text(HEAD ROW TAIL); /* whole before it is closed */
  ck_assert_int_eq(dls_fe_series_add(s, 1, 0, "b.vtu", NULL), DLS_OK);
  ck_assert_int_eq(dls_fe_series_finish(s, NULL), DLS_OK);
  expect_text(HEAD ROW "<DataSet timestep=\"1\" part=\"0\" file=\"b.vtu\"/>\n" TAIL);
  ck_assert_int_eq(dls_fe_series_finish(NULL, NULL), DLS_OK);
}

TEST(series_bad_input) {
  dls_fe_series *s;
  REFUSES(ARGUMENT, "out", -1, dls_fe_series_create, NULL, path);
  REFUSES(ARGUMENT, "path", -1, dls_fe_series_create, &s, NULL);
  REFUSES(FILE, "path", -1, dls_fe_series_create, &s, folder);
  for (int k = 1; k <= 2; k++) {
    malloc_fails_at(k);
    REFUSES(MEMORY, "", -1, dls_fe_series_create, &s, path);
    ck_assert_ptr_null(s);
  }
  malloc_fails_at(0);
  ck_assert_int_eq(dls_fe_series_create(&s, path, NULL), DLS_OK);
  REFUSES(ARGUMENT, "series", -1, dls_fe_series_add, NULL, 0, 0, "a");
  REFUSES(NOT_FINITE, "time", -1, dls_fe_series_add, s, NAN, 0, "a");
  REFUSES(ARGUMENT, "part", -1, dls_fe_series_add, s, 0, -1, "a");
  REFUSES(ARGUMENT, "file", -1, dls_fe_series_add, s, 0, 0, NULL);
  REFUSES(ARGUMENT, "file", 1, dls_fe_series_add, s, 0, 0, "a&b");
  static const char *const no_xml[] = {"\n",   "\x7f",         "\xff",
                                       "\xc3", "\xed\xa0\x80", "\xef\xbf\xbf"};
  for (size_t k = 0; k < sizeof no_xml / sizeof no_xml[0]; k++) {
    char name[8] = "\xc3\xa9";
    strcat(name, no_xml[k]);
    REFUSES(ARGUMENT, "file", 2, dls_fe_series_add, s, 0, 0, name);
  }
  ck_assert_int_eq(dls_fe_series_finish(s, NULL), DLS_OK);
  expect_text(HEAD TAIL);
}

/* f^T K x of triangles and quadrilaterals: its slopes by E and nu beside differences of K. */
TEST_EACH(slopes_of_material, 0, 2) {
  enum { all = 24 };
  dls_fe_mesh mesh;
  dls_error e;
  double K[all * all], f[all], x[all], of_E = 7, of_nu = 7, form[4];
  const double E = 3, nu = 0.3, h = 1e-5;
  ck_assert_int_eq((_i ? dls_fe_mesh_quads : dls_fe_mesh_block)(&mesh, 2, 1, 3, 2, &e), DLS_OK);
  for (int k = 0; k < all; k++) {
    f[k] = cos(k);
    x[k] = sin(3 * k);
  }
  for (int k = 0; k < 4; k++) {
    ck_assert_int_eq(dls_fe_stiffness(&mesh, E * (1 + (k == 0) * h - (k == 1) * h),
                                      nu + (k == 2) * h - (k == 3) * h, K, all, &e),
                     DLS_OK);
    form[k] = 0;
    for (int j = 0; j < all; j++)
      for (int i = 0; i < all; i++)
        form[k] += f[i] * K[i + all * j] * x[j];
  }
  REFUSES(ARGUMENT, "mesh", -1, dls_fe_material_gradient, NULL, E, nu, f, x, &of_E, &of_nu);
  REFUSES(ARGUMENT, "E", -1, dls_fe_material_gradient, &mesh, 0, nu, f, x, &of_E, &of_nu);
  REFUSES(ARGUMENT, "f", -1, dls_fe_material_gradient, &mesh, E, nu, NULL, x, &of_E, &of_nu);
  REFUSES(ARGUMENT, "displacement", -1, dls_fe_material_gradient, &mesh, E, nu, f, NULL, &of_E,
          &of_nu);
  REFUSES(ARGUMENT, "of_E", -1, dls_fe_material_gradient, &mesh, E, nu, f, x, NULL, &of_nu);
  REFUSES(ARGUMENT, "of_nu", -1, dls_fe_material_gradient, &mesh, E, nu, f, x, &of_E, NULL);
  ck_assert(of_E == 7 && of_nu == 7);
  ck_assert_int_eq(dls_fe_material_gradient(&mesh, E, nu, f, x, &of_E, &of_nu, &e), DLS_OK);
  ck_assert_double_eq_tol(of_E, -(form[0] - form[1]) / (2 * h * E), 1e-9 * fabs(of_E));
  ck_assert_double_eq_tol(of_nu, -(form[2] - form[3]) / (2 * h), 1e-7 * fabs(of_nu));
  dls_fe_mesh_free(&mesh);
}

int main(void) {
  return run_tests("assemble", make_folder, remove_folder);
}
