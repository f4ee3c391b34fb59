/* test_fe.c: tests mesh, T3, scenes and vtu files of the finite element module. */
#define _XOPEN_SOURCE 700 /* mkdtemp, setrlimit */

#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include "delassus/fe.h"
#include "run.h"

/* Makes a call that must fail; checks status, argument and index of the error. */
#define REJECTED(call, wanted, name, place)                                                        \
  do {                                                                                             \
    memset(&error, 0, sizeof error);                                                               \
    ck_assert_int_eq(call, wanted);                                                                \
    ck_assert_int_eq(error.status, wanted);                                                        \
    ck_assert_str_eq(error.argument, name);                                                        \
    ck_assert_int_eq(error.index, place);                                                          \
  } while (0)

static dls_error error;

static double *new_doubles(size_t n) {
  double *x = malloc(n * sizeof *x);
  ck_assert_ptr_nonnull(x);
  for (size_t i = 0; i < n; i++)
    x[i] = -7;
  return x;
}

/* y := K x, a := |K||x| (n); K with leading dimension n */
static void multiply_full(const double *K, const double *x, int n, double *y, double *a) {
  for (int i = 0; i < n; i++)
    y[i] = a[i] = 0;
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) {
      y[i] += K[i + j * n] * x[j];
      a[i] += fabs(K[i + j * n] * x[j]);
    }
}

static double area2(const dls_fe_mesh *mesh, int e) {
  const double *p[3];
  for (int i = 0; i < 3; i++)
    p[i] = mesh->xy + 2 * mesh->node[3 * e + i];
  return (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
}

/* a 5 x 4 block whose nodes are moved off their lattice, boundary nodes along the boundary */
enum { cx = 5, cy = 4, crooked_n = 2 * (cx + 1) * (cy + 1) };
static const double lx = 3, ly = 2;
static dls_fe_mesh crooked(void) {
  dls_fe_mesh mesh;
  ck_assert_int_eq(dls_fe_mesh_block(&mesh, lx, ly, cx, cy, NULL), DLS_OK);
  for (int i = 0; i < mesh.nodes; i++) {
    const int column = i % (cx + 1), row = i / (cx + 1);
    if (column > 0 && column < cx) mesh.xy[2 * i] += 0.12 * sin(3.0 * i);
    if (row > 0 && row < cy) mesh.xy[2 * i + 1] += 0.1 * cos(5.0 * i);
  }
  return mesh;
}

/* nu = 3/8, E = 11/4: G = 1, l = 3, exactly */
static const double E0 = 2.75, nu0 = 0.375;

/* ---- mesh ------------------------------------------------------------------------------------ */

TEST(block) {
  dls_fe_mesh mesh;
  ck_assert_int_eq(dls_fe_mesh_block(&mesh, 6, 2, 3, 2, NULL), DLS_OK);
  ck_assert_int_eq(mesh.nodes, 12);
  ck_assert_int_eq(mesh.triangles, 12);
  for (int j = 0; j <= 2; j++)
    for (int i = 0; i <= 3; i++) {
      assert_near(mesh.xy + 2 * (i + 4 * j), (double[]){2.0 * i, 1.0 * j}, 2, 0);
    }
  for (int e = 0; e < mesh.triangles; e++)
    ck_assert_double_eq(area2(&mesh, e), 2);
  /* the diagonal of the first rectangle joins node 1 (bottom right) and node 4 (top left) */
  for (int e = 0; e < 2; e++) {
    int on_diagonal = 0;
    for (int i = 0; i < 3; i++)
      on_diagonal += mesh.node[3 * e + i] == 1 || mesh.node[3 * e + i] == 4;
    ck_assert_int_eq(on_diagonal, 2);
  }
  dls_fe_mesh_free(&mesh);
  ck_assert_ptr_null(mesh.xy);
  ck_assert_ptr_null(mesh.node);
  ck_assert_int_eq(mesh.nodes + mesh.triangles, 0);
  dls_fe_mesh_free(&mesh);
  dls_fe_mesh_free(NULL);
}

TEST(block_ends_at_its_lengths) {
  dls_fe_mesh mesh;
  for (int n = 1; n < 60; n++) {
    ck_assert_int_eq(dls_fe_mesh_block(&mesh, 0.1, 4e-3, n, 1, NULL), DLS_OK);
    ck_assert(mesh.xy[2 * n] == 0.1 && mesh.xy[4 * n + 3] == 4e-3);
    dls_fe_mesh_free(&mesh);
  }
}

TEST(block_bad_input) {
  dls_fe_mesh mesh, before;
  memset(&mesh, 42, sizeof mesh);
  before = mesh;
  const double bad[] = {0, -1, NAN, INFINITY, -INFINITY};
  REJECTED(dls_fe_mesh_block(NULL, 1, 1, 1, 1, &error), DLS_E_ARGUMENT, "mesh", -1);
  for (int k = 0; k < 5; k++) {
    REJECTED(dls_fe_mesh_block(&mesh, bad[k], 1, 1, 1, &error), DLS_E_ARGUMENT, "lx", -1);
    REJECTED(dls_fe_mesh_block(&mesh, 1, bad[k], 1, 1, &error), DLS_E_ARGUMENT, "ly", -1);
  }
  REJECTED(dls_fe_mesh_block(&mesh, 1, 1, 0, 1, &error), DLS_E_SIZE, "nx", -1);
  REJECTED(dls_fe_mesh_block(&mesh, 1, 1, 1, -3, &error), DLS_E_SIZE, "ny", -1);
  REJECTED(dls_fe_mesh_block(&mesh, 1, 1, 1 << 15, 1 << 15, &error), DLS_E_SIZE, "ny", -1);
  REJECTED(dls_fe_mesh_block(&mesh, 1, 1, INT_MAX, INT_MAX, &error), DLS_E_SIZE, "ny", -1);
  for (long k = 1; k <= 2; k++) {
    malloc_fails_at(k);
    REJECTED(dls_fe_mesh_block(&mesh, 1, 1, 2, 2, &error), DLS_E_MEMORY, "", -1);
  }
  malloc_fails_at(0);
  ck_assert(memcmp(&mesh, &before, sizeof mesh) == 0);
}

/* ---- T3 -------------------------------------------------------------------------------------- */

TEST(one_triangle_by_hand) {
  /* (0,0) (1,0) (0,1): b = (-1, 1, 0), c = (-1, 0, 1), 1/4A = 1/2, G = 1, l = 3 */
  double xy[] = {0, 0, 1, 0, 0, 1}, K[6 * 7];
  int node[] = {0, 1, 2};
  const dls_fe_mesh mesh = {.nodes = 3, .xy = xy, .triangles = 1, .node = node};
  const double by_hand[6][6] = {{3, 2, -2.5, -0.5, -0.5, -1.5}, {2, 3, -1.5, -0.5, -0.5, -2.5},
                                {-2.5, -1.5, 2.5, 0, 0, 1.5},   {-0.5, -0.5, 0, 0.5, 0.5, 0},
                                {-0.5, -0.5, 0, 0.5, 0.5, 0},   {-1.5, -2.5, 1.5, 0, 0, 2.5}};
  for (int k = 0; k < 42; k++)
    K[k] = -7;
  ck_assert_int_eq(dls_fe_stiffness(&mesh, E0, nu0, K, 7, NULL), DLS_OK);
  for (int j = 0; j < 6; j++) {
    for (int i = 0; i < 6; i++)
      ck_assert_double_eq(K[i + 7 * j], by_hand[i][j]);
    ck_assert_double_eq(K[6 + 7 * j], -7); /* what lies past the rows is not touched */
  }
  /* u_x = x: e_xx = 1; u_y = y: e_yy = 1; u_x = y: 2 e_xy = 1 */
  const double u[3][6] = {{0, 0, 1, 0, 0, 0}, {0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 1, 0}};
  const double s[3][3] = {{5, 3, 0}, {3, 5, 0}, {0, 0, 1}};
  for (int k = 0; k < 3; k++) {
    double stress[3];
    ck_assert_int_eq(dls_fe_stress(&mesh, E0, nu0, u[k], stress, NULL), DLS_OK);
    for (int i = 0; i < 3; i++)
      ck_assert_double_eq(stress[i], s[k][i]);
  }
}

TEST(patch) {
  /* u = (x + 2y, 3x - y/2): e = (1, -1/2, 5), s = (3.5, 0.5, 5). The forces K u are those of the
   * tractions s n on the boundary, nothing inside. */
  const double s[3] = {3.5, 0.5, 5};
  dls_fe_mesh mesh = crooked();
  double *K = new_doubles((size_t)crooked_n * crooked_n), u[crooked_n], f[crooked_n] = {0};
  double Ku[crooked_n], size[crooked_n];
  for (int i = 0; i < mesh.nodes; i++) {
    const double x = mesh.xy[2 * i], y = mesh.xy[2 * i + 1];
    u[2 * i] = x + 2 * y;
    u[2 * i + 1] = 3 * x - y / 2;
  }
  double *stress = new_doubles(3 * (size_t)mesh.triangles);
  ck_assert_int_eq(dls_fe_stress(&mesh, E0, nu0, u, stress, NULL), DLS_OK);
  for (int e = 0; e < mesh.triangles; e++) {
    ck_assert(area2(&mesh, e) > 0);
    assert_near(stress + 3 * e, s, 3, 1000 * DBL_EPSILON);
  }

  dls_status status = DLS_OK;
  for (int i = 0; i < cx; i++) {
    const int top = cy * (cx + 1) + i;
    status |= dls_fe_edge_load(&mesh, i, i + 1, -s[2], -s[1], f, NULL);
    status |= dls_fe_edge_load(&mesh, top, top + 1, s[2], s[1], f, NULL);
  }
  for (int j = 0; j < cy; j++) {
    const int left = j * (cx + 1), right = left + cx;
    status |= dls_fe_edge_load(&mesh, left, left + cx + 1, -s[0], -s[2], f, NULL);
    status |= dls_fe_edge_load(&mesh, right, right + cx + 1, s[0], s[2], f, NULL);
  }
  ck_assert_int_eq(status, DLS_OK);
  ck_assert_int_eq(dls_fe_stiffness(&mesh, E0, nu0, K, crooked_n, NULL), DLS_OK);
  multiply_full(K, u, crooked_n, Ku, size);
  for (int i = 0; i < crooked_n; i++)
    ck_assert_double_eq_tol(Ku[i], f[i], 16 * DBL_EPSILON * size[i]);
  free(stress);
  free(K);
  dls_fe_mesh_free(&mesh);
}

TEST(symmetric_and_rigid) {
  dls_fe_mesh mesh = crooked();
  double *K = new_doubles((size_t)crooked_n * crooked_n);
  ck_assert_int_eq(dls_fe_stiffness(&mesh, 0.13e12, 0.2, K, crooked_n, NULL), DLS_OK);
  for (int j = 0; j < crooked_n; j++)
    for (int i = 0; i < j; i++)
      ck_assert(K[i + j * crooked_n] == K[j + i * crooked_n]);
  for (int mode = 0; mode < 3; mode++) {
    double u[crooked_n], Ku[crooked_n], size[crooked_n];
    for (int i = 0; i < mesh.nodes; i++) {
      u[2 * i] = mode == 0 ? 1 : mode == 1 ? 0 : -mesh.xy[2 * i + 1];
      u[2 * i + 1] = mode == 0 ? 0 : mode == 1 ? 1 : mesh.xy[2 * i];
    }
    multiply_full(K, u, crooked_n, Ku, size);
    for (int i = 0; i < crooked_n; i++)
      ck_assert_double_eq_tol(Ku[i], 0, 16 * DBL_EPSILON * size[i]);
  }
  free(K);
  dls_fe_mesh_free(&mesh);
}

TEST(units) {
  /* K per unit thickness does not depend on the unit of length; powers of two change no bit */
  dls_fe_mesh mesh = crooked();
  const size_t size = (size_t)crooked_n * crooked_n;
  double *K = new_doubles(size), *K1 = new_doubles(size);
  const double force = ldexp(1, 30);
  ck_assert_int_eq(dls_fe_stiffness(&mesh, E0, nu0, K, crooked_n, NULL), DLS_OK);
  for (int e = -30; e <= 30; e += 60) {
    dls_fe_mesh scaled = crooked();
    for (int i = 0; i < crooked_n; i++)
      scaled.xy[i] = ldexp(scaled.xy[i], e);
    ck_assert_int_eq(dls_fe_stiffness(&scaled, force * E0, nu0, K1, crooked_n, NULL), DLS_OK);
    for (size_t k = 0; k < size; k++)
      ck_assert(K1[k] == force * K[k]);
    dls_fe_mesh_free(&scaled);
  }
  free(K);
  free(K1);
  dls_fe_mesh_free(&mesh);
}

TEST(flat_triangles) {
  int node[] = {0, 1, 2, 0, 2, 3};
  double K[64], untouched[64];
  for (int k = 0; k < 64; k++)
    K[k] = untouched[k] = -7;
  for (int e = -30; e <= 30; e += 30) {
    const double h = ldexp(1, e);
    double xy[] = {0, 0, h, 0, h, 1e-6 * h, 0, 1e-6 * h};
    const dls_fe_mesh mesh = {.nodes = 4, .xy = xy, .triangles = 2, .node = node};
    double fine[64];
    ck_assert_int_eq(dls_fe_stiffness(&mesh, 1, 0.2, fine, 8, NULL), DLS_OK); /* thin only */
    xy[6] = -h; /* nodes 0, 2, 3 on one line */
    xy[7] = -1e-6 * h;
    REJECTED(dls_fe_stiffness(&mesh, 1, 0.2, K, 8, &error), DLS_E_ARGUMENT, "node", 3);
    xy[6] = 2 * h; /* twice the triangle's area is 2e-16 h^2, a rounding error */
    xy[7] = 2e-6 * h * (1 + 1e-10);
    REJECTED(dls_fe_stiffness(&mesh, 1, 0.2, K, 8, &error), DLS_E_ARGUMENT, "node", 3);
    xy[6] = 0;
    xy[7] = -h; /* clockwise */
    REJECTED(dls_fe_stiffness(&mesh, 1, 0.2, K, 8, &error), DLS_E_ARGUMENT, "node", 3);
    REJECTED(dls_fe_stress(&mesh, 1, 0.2, xy, K, &error), DLS_E_ARGUMENT, "node", 3);
  }
  ck_assert(memcmp(K, untouched, sizeof K) == 0);
}

TEST(edge_load) {
  dls_fe_mesh mesh;
  double f[2 * 6] = {0};
  ck_assert_int_eq(dls_fe_mesh_block(&mesh, 6, 8, 2, 1, NULL), DLS_OK);
  f[0] = 100;
  /* from (0, 0) to (3, 8) and, the other way round, from (6, 0) to (3, 0): lengths sqrt(73), 3 */
  ck_assert_int_eq(dls_fe_edge_load(&mesh, 2, 1, 4, -2, f, NULL), DLS_OK);
  ck_assert_int_eq(dls_fe_edge_load(&mesh, 0, 4, 4, -2, f, NULL), DLS_OK);
  const double d = sqrt(73) / 2;
  const double by_hand[12] = {100 + 4 * d, -2 * d, 6, -3, 6, -3, 0, 0, 4 * d, -2 * d, 0, 0};
  for (int i = 0; i < 12; i++)
    ck_assert_double_le(fabs(f[i] - by_hand[i]), 4 * DBL_EPSILON * fabs(by_hand[i]));
  dls_fe_mesh_free(&mesh);
}

static dls_status write_vtu(const char *to, const dls_fe_mesh *mesh, const double *u,
                            const double *R, const double *stress, dls_error *e) {
  const dls_fe_fields fields = {.displacement = u, .reaction = R, .stress = stress, .nu = nu0};
  return dls_fe_write_fields(to, mesh, &fields, e);
}

/* Hands a wrong mesh to every function that reads whole meshes. */
typedef dls_status reader(const dls_fe_mesh *mesh);
static double scratch[12 * 12];
static dls_status by_stiffness(const dls_fe_mesh *mesh) {
  return dls_fe_stiffness(mesh, 1, 0.2, scratch, 12, &error);
}
static dls_status by_stress(const dls_fe_mesh *mesh) {
  const double u[12] = {0};
  return dls_fe_stress(mesh, 1, 0.2, u, scratch, &error);
}
static dls_status by_vtu(const dls_fe_mesh *mesh) {
  return write_vtu("no/such/directory.vtu", mesh, NULL, NULL, NULL, &error);
}

TEST_EACH(mesh_bad_input, 0, 3) {
  reader *const readers[] = {by_stiffness, by_stress, by_vtu};
  reader *read = readers[_i];
  dls_fe_mesh mesh;
  ck_assert_int_eq(dls_fe_mesh_block(&mesh, 6, 8, 2, 1, NULL), DLS_OK);
  for (int k = 0; k < 12 * 12; k++)
    scratch[k] = -7;
  REJECTED(read(NULL), DLS_E_ARGUMENT, "mesh", -1);
  dls_fe_mesh bad = mesh;
  bad.nodes = 0;
  REJECTED(read(&bad), DLS_E_SIZE, "nodes", -1);
  bad.nodes = INT_MAX;
  REJECTED(read(&bad), DLS_E_SIZE, "nodes", -1);
  bad = mesh;
  bad.triangles = 0;
  REJECTED(read(&bad), DLS_E_SIZE, "triangles", -1);
  bad.triangles = INT_MAX;
  REJECTED(read(&bad), DLS_E_SIZE, "triangles", -1);
  bad = mesh;
  bad.xy = NULL;
  REJECTED(read(&bad), DLS_E_ARGUMENT, "xy", -1);
  bad = mesh;
  bad.node = NULL;
  REJECTED(read(&bad), DLS_E_ARGUMENT, "node", -1);
  const double values[] = {NAN, INFINITY, -INFINITY};
  for (int i = 0; i < 2 * mesh.nodes; i++)
    for (int k = 0; k < 3; k++) {
      const double good = mesh.xy[i];
      mesh.xy[i] = values[k];
      REJECTED(read(&mesh), DLS_E_NOT_FINITE, "xy", i);
      mesh.xy[i] = good;
    }
  for (int i = 0; i < 3 * mesh.triangles; i++) {
    const int good = mesh.node[i];
    mesh.node[i] = -1;
    REJECTED(read(&mesh), DLS_E_ARGUMENT, "node", i);
    mesh.node[i] = mesh.nodes;
    REJECTED(read(&mesh), DLS_E_ARGUMENT, "node", i);
    mesh.node[i] = good;
  }
  assert_all(scratch, 12 * 12, -7);
  dls_fe_mesh_free(&mesh);
}

TEST(t3_bad_input) {
  dls_fe_mesh mesh;
  ck_assert_int_eq(dls_fe_mesh_block(&mesh, 6, 8, 2, 1, NULL), DLS_OK);
  double K[144], f[12], s[12], u[12] = {0};
  for (int k = 0; k < 144; k++)
    K[k] = -7;
  for (int k = 0; k < 12; k++)
    f[k] = s[k] = -7;
  const double bad_E[] = {0, -1, NAN, INFINITY}, bad_nu[] = {-1, 0.5, 2, NAN};
  for (int k = 0; k < 4; k++) {
    const double E = bad_E[k], nu = bad_nu[k];
    REJECTED(dls_fe_stiffness(&mesh, E, 0.2, K, 12, &error), DLS_E_ARGUMENT, "E", -1);
    REJECTED(dls_fe_stiffness(&mesh, 1, nu, K, 12, &error), DLS_E_ARGUMENT, "nu", -1);
    REJECTED(dls_fe_stress(&mesh, E, 0.2, u, s, &error), DLS_E_ARGUMENT, "E", -1);
    REJECTED(dls_fe_stress(&mesh, 1, nu, u, s, &error), DLS_E_ARGUMENT, "nu", -1);
  }
  REJECTED(dls_fe_stiffness(&mesh, 1, 0.2, NULL, 12, &error), DLS_E_ARGUMENT, "K", -1);
  REJECTED(dls_fe_stiffness(&mesh, 1, 0.2, K, 11, &error), DLS_E_SIZE, "ldk", -1);
  REJECTED(dls_fe_stress(&mesh, 1, 0.2, NULL, s, &error), DLS_E_ARGUMENT, "displacement", -1);
  REJECTED(dls_fe_stress(&mesh, 1, 0.2, u, NULL, &error), DLS_E_ARGUMENT, "stress", -1);
  for (int i = 0; i < 12; i++) {
    u[i] = NAN;
    REJECTED(dls_fe_stress(&mesh, 1, 0.2, u, s, &error), DLS_E_NOT_FINITE, "displacement", i);
    u[i] = 0;
  }

  REJECTED(dls_fe_edge_load(NULL, 0, 1, 1, 1, f, &error), DLS_E_ARGUMENT, "mesh", -1);
  REJECTED(dls_fe_edge_load(&mesh, -1, 1, 1, 1, f, &error), DLS_E_ARGUMENT, "a", -1);
  REJECTED(dls_fe_edge_load(&mesh, 6, 1, 1, 1, f, &error), DLS_E_ARGUMENT, "a", -1);
  REJECTED(dls_fe_edge_load(&mesh, 0, -1, 1, 1, f, &error), DLS_E_ARGUMENT, "b", -1);
  REJECTED(dls_fe_edge_load(&mesh, 0, 6, 1, 1, f, &error), DLS_E_ARGUMENT, "b", -1);
  REJECTED(dls_fe_edge_load(&mesh, 2, 2, 1, 1, f, &error), DLS_E_ARGUMENT, "b", -1);
  REJECTED(dls_fe_edge_load(&mesh, 0, 1, NAN, 1, f, &error), DLS_E_NOT_FINITE, "tx", -1);
  REJECTED(dls_fe_edge_load(&mesh, 0, 1, 1, INFINITY, f, &error), DLS_E_NOT_FINITE, "ty", -1);
  REJECTED(dls_fe_edge_load(&mesh, 0, 1, 1, 1, NULL, &error), DLS_E_ARGUMENT, "f", -1);
  mesh.xy[3] = NAN;
  REJECTED(dls_fe_edge_load(&mesh, 0, 1, 1, 1, f, &error), DLS_E_NOT_FINITE, "xy", 2);
  REJECTED(dls_fe_edge_load(&mesh, 1, 0, 1, 1, f, &error), DLS_E_NOT_FINITE, "xy", 2);
  dls_fe_mesh without = mesh;
  without.xy = NULL;
  REJECTED(dls_fe_edge_load(&without, 0, 1, 1, 1, f, &error), DLS_E_ARGUMENT, "xy", -1);

  assert_all(K, 144, -7);
  for (int k = 0; k < 12; k++)
    ck_assert(f[k] == -7 && s[k] == -7);
  dls_fe_mesh_free(&mesh);
}

/* ---- scenes ---------------------------------------------------------------------------------- */

TEST(scene_names) {
  ck_assert_str_eq(dls_fe_scene_name(0), "jean-fig3");
  ck_assert_str_eq(dls_fe_scene_name(1), "jean-fig4");
  ck_assert_ptr_nonnull(strstr(dls_fe_scene_description(0), "Fig. 3"));
  ck_assert_ptr_nonnull(strstr(dls_fe_scene_description(1), "Fig. 4"));
  const int none[] = {-1, 2, INT_MAX, INT_MIN};
  for (int k = 0; k < 4; k++) {
    ck_assert_ptr_null(dls_fe_scene_name(none[k]));
    ck_assert_ptr_null(dls_fe_scene_description(none[k]));
  }
}

/* _i: 2 * scene + weighted */
TEST_EACH(scene, 0, 4) {
  const int fig4 = _i / 2, weighted = _i % 2, nodes = weighted ? 17 : 16;
  dls_fe_scene *s;
  dls_fe_scene_data data;
  ck_assert_int_eq(dls_fe_scene_create(&s, dls_fe_scene_name(fig4), weighted, NULL), DLS_OK);
  dls_fe_scene_get(s, &data);
  const dls_model *m = &data.model;
  ck_assert(data.mesh->nodes == 153 && data.mesh->triangles == 256);
  ck_assert(m->d == 2 && m->n == 296 && m->nodes == nodes && data.candidates == 16);
  ck_assert(m->operator_kind == DLS_STIFFNESS_DENSE && m->factorization == DLS_CHOLESKY);
  ck_assert(data.E == 0.13e12 && data.nu == 0.2);

  /* place[i]: number in the model + 1 of unknown i of the mesh, 0 if supported */
  double x[296], place[306];
  for (int i = 0; i < 296; i++)
    x[i] = i + 1;
  ck_assert_int_eq(dls_fe_scene_displacement(s, x, place, NULL), DLS_OK);
  for (int i = 0; i < 153; i++) {
    const int on_symmetry_face = data.mesh->xy[2 * i] == 4e-3;
    const int corner = on_symmetry_face && data.mesh->xy[2 * i + 1] == 0;
    ck_assert_int_eq(place[2 * i] == 0, on_symmetry_face);
    ck_assert_int_eq(place[2 * i + 1] == 0, corner);
  }

  /* K is the stiffness without the supported rows and columns */
  double *K = new_doubles((size_t)306 * 306);
  ck_assert_int_eq(dls_fe_stiffness(data.mesh, data.E, data.nu, K, 306, NULL), DLS_OK);
  ck_assert(m->K.rows == 296 && m->K.cols == 296 && m->K.ld == 296);
  for (int j = 0; j < 306; j++)
    for (int i = 0; i < 306; i++)
      if (place[i] > 0 && place[j] > 0)
        ck_assert(m->K.a[(int)place[i] - 1 + ((int)place[j] - 1) * 296] == K[i + j * 306]);
  free(K);

  /* resultants per metre: top 4e-3 m of 5e8 Pa; side segments of 5e-4 m: (10 + 12 + .. + 24) 1e8
   * Pa, or 8 times 5e8 Pa. Moments about (0, 0), counterclockwise. */
  double F[306], sum[3] = {0};
  ck_assert_int_eq(dls_fe_scene_displacement(s, data.f, F, NULL), DLS_OK);
  for (int i = 0; i < 153; i++) {
    const double *p = data.mesh->xy + 2 * i;
    sum[0] += F[2 * i];
    sum[1] += F[2 * i + 1];
    sum[2] += p[0] * F[2 * i + 1] - p[1] * F[2 * i];
  }
  double push = 0, moment = -2e6 * 2e-3;
  for (int k = 0; k < 8; k++) {
    const double force = (fig4 ? 5e8 : (10 + 2 * k) * 1e8) * 5e-4;
    push += force;
    moment -= force * (k + 0.5) * 5e-4;
  }
  ck_assert_double_eq_tol(push, fig4 ? 2e6 : 6.8e6, 1e-8);
  ck_assert_double_eq_tol(sum[0], push, 100 * DBL_EPSILON * push);
  ck_assert_double_eq_tol(sum[1], -2e6, 100 * DBL_EPSILON * 2e6);
  ck_assert_double_eq_tol(sum[2], moment, 100 * DBL_EPSILON * fabs(moment));

  /* H_N picks u_y and H_T u_x of the bottom nodes, from the free face on; node 17 has neither */
  ck_assert(m->HN.rows == 296 && m->HN.cols == nodes && m->HT.rows == 296 && m->HT.cols == nodes);
  for (int c = 0; c < nodes; c++) {
    const int node = data.contact_node[c];
    ck_assert_double_eq_tol(data.mesh->xy[2 * node], c * 2.5e-4, 1e-18);
    ck_assert(data.mesh->xy[2 * node + 1] == 0);
    ck_assert_int_eq(m->HN.p[c + 1] - m->HN.p[c], c < 16);
    ck_assert_int_eq(m->HT.p[c + 1] - m->HT.p[c], c < 16);
    ck_assert(data.g[2 * c] == 0 && data.g[2 * c + 1] == 0);
    if (c == 16) continue;
    ck_assert_int_eq(m->HN.i[m->HN.p[c]] + 1, (int)place[2 * node + 1]);
    ck_assert_int_eq(m->HT.i[m->HT.p[c]] + 1, (int)place[2 * node]);
    ck_assert(m->HN.x[m->HN.p[c]] == 1 && m->HT.x[m->HT.p[c]] == 1);
    ck_assert_int_eq(data.candidate_node[c], c);
    ck_assert(data.mu[c] == (fig4 ? 0.1 : 1.0));
  }

  if (!weighted)
    ck_assert_ptr_null(m->P.p);
  else { /* (3/4, 1/4) at the surface's end, (1/8, 3/4, 1/8) inside; candidate 16 is inside */
    ck_assert(m->P.rows == 17 && m->P.cols == 16);
    for (int c = 0; c < 16; c++) {
      double column[17] = {0};
      for (int k = m->P.p[c]; k < m->P.p[c + 1]; k++)
        column[m->P.i[k]] += m->P.x[k];
      for (int i = 0; i < 17; i++) {
        const double end = i == 0 ? 0.75 : i == 1 ? 0.25 : 0;
        const double inside = i == c ? 0.75 : abs(i - c) == 1 ? 0.125 : 0;
        ck_assert_double_eq_tol(column[i], c == 0 ? end : inside, 1e-13); /* of spacings 2.5e-4 */
      }
    }
  }
  dls_fe_scene_destroy(s);
}

TEST(scene_twice) {
  dls_fe_scene *s[2];
  dls_fe_scene_data data[2];
  for (int k = 0; k < 2; k++) {
    ck_assert_int_eq(dls_fe_scene_create(&s[k], "jean-fig3", 1, NULL), DLS_OK);
    dls_fe_scene_get(s[k], &data[k]);
  }
  ck_assert(memcmp(data[0].model.K.a, data[1].model.K.a, 296 * 296 * sizeof(double)) == 0);
  ck_assert(memcmp(data[0].f, data[1].f, 296 * sizeof(double)) == 0);
  for (int k = 0; k < 2; k++)
    dls_fe_scene_destroy(s[k]);
}

TEST(scene_bad_input) {
  int dummy = 0;
  dls_fe_scene *s = (dls_fe_scene *)(void *)&dummy;
  REJECTED(dls_fe_scene_create(NULL, "jean-fig3", 0, &error), DLS_E_ARGUMENT, "out", -1);
  REJECTED(dls_fe_scene_create(&s, NULL, 0, &error), DLS_E_ARGUMENT, "name", -1);
  ck_assert_ptr_null(s);
  s = (dls_fe_scene *)(void *)&dummy;
  REJECTED(dls_fe_scene_create(&s, "jean-fig", 0, &error), DLS_E_ARGUMENT, "name", -1);
  ck_assert_ptr_null(s);
  dls_fe_scene_destroy(NULL);

  dls_fe_scene_data data;
  memset(&data, 42, sizeof data);
  dls_fe_scene_get(NULL, &data);
  ck_assert(data.f == NULL && data.model.n == 0 && data.candidates == 0);

  ck_assert_int_eq(dls_fe_scene_create(&s, "jean-fig3", 0, NULL), DLS_OK);
  dls_fe_scene_get(s, NULL);
  double x[296] = {0}, displacement[306];
  displacement[0] = displacement[305] = -7;
  REJECTED(dls_fe_scene_displacement(NULL, x, displacement, &error), DLS_E_ARGUMENT, "scene", -1);
  REJECTED(dls_fe_scene_displacement(s, NULL, displacement, &error), DLS_E_ARGUMENT, "x", -1);
  REJECTED(dls_fe_scene_displacement(s, x, NULL, &error), DLS_E_ARGUMENT, "displacement", -1);
  for (int i = 0; i < 296; i++) {
    x[i] = NAN;
    REJECTED(dls_fe_scene_displacement(s, x, displacement, &error), DLS_E_NOT_FINITE, "x", i);
    x[i] = 0;
  }
  ck_assert(displacement[0] == -7 && displacement[305] == -7);
  dls_fe_scene_destroy(s);
}

static dls_fe_scene_settings scene_settings(int nx, int ny) {
  dls_fe_scene_settings s;
  dls_fe_scene_settings_init(&s);
  s.nx = nx;
  s.ny = ny;
  return s;
}

/* The settings' own values give the scene of no settings, bit by bit. */
TEST(scene_settings_by_default) {
  dls_fe_scene *s[3];
  dls_fe_scene_data d[3];
  dls_fe_scene_settings given = scene_settings(16, 8), none = scene_settings(0, 0);
  given.mu = 1;
  given.E = 0.13e12;
  given.nu = 0.2;
  given.has_load = 1;
  given.top = 5e8;
  given.side = 9e8;
  given.side_top = 25e8;
  const dls_fe_scene_settings *settings[] = {NULL, &none, &given};
  for (int k = 0; k < 3; k++) {
    ck_assert_int_eq(dls_fe_scene_create_with(&s[k], "jean-fig3", 1, settings[k], NULL), DLS_OK);
    dls_fe_scene_get(s[k], &d[k]);
    ck_assert(memcmp(d[0].model.K.a, d[k].model.K.a, 296 * 296 * sizeof(double)) == 0);
    ck_assert(memcmp(d[0].f, d[k].f, 296 * sizeof(double)) == 0);
    ck_assert(memcmp(d[0].mu, d[k].mu, 16 * sizeof(double)) == 0);
    ck_assert_ptr_null(d[k].f_first);
    ck_assert(d[k].weighting.rows == 17 && d[k].weighting.cols == 16);
    ck_assert(d[k].cell[0] == 2e-3 / 16 || fabs(d[k].cell[0] - 2e-3 / 16) < 1e-18);
    ck_assert_double_eq_tol(d[k].cell[15], 4e-3 / 16, 1e-18);
  }
  for (int k = 0; k < 3; k++)
    dls_fe_scene_destroy(s[k]);
}

/* K of a finer mesh is sparse, and is the stiffness without the supported rows and columns; loads
 * have the resultants of the coarse one. */
TEST(scene_of_a_finer_mesh) {
  const int nx = 24, ny = 22, nodes = (nx + 1) * (ny + 1), all = 2 * nodes, n = all - ny - 2;
  dls_fe_scene *s;
  dls_fe_scene_data data;
  const dls_fe_scene_settings settings = scene_settings(nx, ny);
  ck_assert_int_eq(dls_fe_scene_create_with(&s, "jean-fig3", 1, &settings, NULL), DLS_OK);
  dls_fe_scene_get(s, &data);
  ck_assert(data.model.n == n && data.candidates == nx && data.model.nodes == nx + 1);
  ck_assert(data.model.operator_kind == DLS_STIFFNESS_SPARSE && data.mesh->nodes == nodes);
  ck_assert_int_eq(dls_model_check(&data.model, NULL), DLS_OK);

  double *x = new_doubles((size_t)n), *place = new_doubles((size_t)all);
  double *K = new_doubles((size_t)all * (size_t)all), *Ks = new_doubles((size_t)n * (size_t)n);
  memset(Ks, 0, (size_t)n * (size_t)n * sizeof *Ks);
  for (int j = 0; j < n; j++) {
    x[j] = j + 1;
    for (int k = data.model.Ks.p[j]; k < data.model.Ks.p[j + 1]; k++)
      Ks[(size_t)data.model.Ks.i[k] + (size_t)j * (size_t)n] += data.model.Ks.x[k];
  }
  ck_assert_int_eq(dls_fe_scene_displacement(s, x, place, NULL), DLS_OK);
  ck_assert_int_eq(dls_fe_stiffness(data.mesh, data.E, data.nu, K, all, NULL), DLS_OK);
  for (int j = 0; j < all; j++)
    for (int i = 0; i < all; i++)
      if (place[i] > 0 && place[j] > 0)
        ck_assert(Ks[(size_t)place[i] - 1 + ((size_t)place[j] - 1) * (size_t)n] ==
                  K[(size_t)i + (size_t)j * (size_t)all]);
  double sum[2] = {0};
  ck_assert_int_eq(dls_fe_scene_displacement(s, data.f, place, NULL), DLS_OK);
  for (int i = 0; i < nodes; i++) {
    sum[0] += place[2 * i];
    sum[1] += place[2 * i + 1];
  }
  ck_assert_double_eq_tol(sum[0], 6.8e6, 1e3 * DBL_EPSILON * 6.8e6);
  ck_assert_double_eq_tol(sum[1], -2e6, 1e3 * DBL_EPSILON * 2e6);
  free(x);
  free(place);
  free(K);
  free(Ks);
  dls_fe_scene_destroy(s);
}

/* The loads of the first step and the rest of them add up to f. */
TEST(scene_loads_in_order) {
  dls_fe_scene *s[2];
  dls_fe_scene_data d[2];
  for (int k = 0; k < 2; k++) {
    dls_fe_scene_settings settings = scene_settings(4, 3);
    settings.order = k ? DLS_FE_SIDE_FIRST : DLS_FE_TOP_FIRST;
    ck_assert_int_eq(dls_fe_scene_create_with(&s[k], "jean-fig3", 0, &settings, NULL), DLS_OK);
    dls_fe_scene_get(s[k], &d[k]);
    ck_assert_ptr_nonnull(d[k].f_first);
  }
  int tops = 0, sides = 0;
  for (int i = 0; i < d[0].model.n; i++) {
    ck_assert(d[0].f[i] == d[1].f[i]);
    ck_assert(d[0].f_first[i] + d[1].f_first[i] == d[0].f[i]);
    ck_assert(d[0].f_first[i] <= 0 && d[1].f_first[i] >= 0);
    tops += d[0].f_first[i] < 0;
    sides += d[1].f_first[i] > 0;
  }
  ck_assert(tops == 5 && sides == 4);
  for (int k = 0; k < 2; k++)
    dls_fe_scene_destroy(s[k]);
}

TEST(scene_bad_settings) {
  dls_fe_scene *s;
  dls_fe_scene_settings x;
#define REFUSED(field, value, code, name)                                                          \
  do {                                                                                             \
    x = scene_settings(4, 3);                                                                      \
    x.field = value;                                                                               \
    REJECTED(dls_fe_scene_create_with(&s, "jean-fig3", 0, &x, &error), code, name, -1);            \
    ck_assert_ptr_null(s);                                                                         \
  } while (0)
  REFUSED(size, 0, DLS_E_SETTINGS, "settings");
  REFUSED(nx, -1, DLS_E_ARGUMENT, "nx");
  REFUSED(ny, -1, DLS_E_ARGUMENT, "ny");
  REFUSED(ny, INT_MAX, DLS_E_SIZE, "ny");
  REFUSED(ny, INT_MAX / 100, DLS_E_SIZE, "ny");
  REFUSED(mu, NAN, DLS_E_ARGUMENT, "mu");
  REFUSED(mu, INFINITY, DLS_E_ARGUMENT, "mu");
  REFUSED(E, -1, DLS_E_ARGUMENT, "E");
  REFUSED(E, NAN, DLS_E_ARGUMENT, "E");
  REFUSED(nu, 0.5, DLS_E_ARGUMENT, "nu");
  REFUSED(nu, -1.1, DLS_E_ARGUMENT, "nu");
  REFUSED(nu, NAN, DLS_E_ARGUMENT, "nu");
  REFUSED(has_load, 2, DLS_E_ARGUMENT, "has_load");
  REFUSED(top, NAN, DLS_E_ARGUMENT, "top");
  REFUSED(side, INFINITY, DLS_E_ARGUMENT, "side");
  REFUSED(side_top, -INFINITY, DLS_E_ARGUMENT, "side_top");
  REFUSED(order, (dls_fe_order)3, DLS_E_ARGUMENT, "order");
#undef REFUSED
  x = scene_settings(4, 3);
  REJECTED(dls_fe_scene_create_with(NULL, "jean-fig3", 0, &x, &error), DLS_E_ARGUMENT, "out", -1);
  REJECTED(dls_fe_scene_create_with(&s, NULL, 0, &x, &error), DLS_E_ARGUMENT, "name", -1);
  REJECTED(dls_fe_scene_create_with(&s, "x", 0, &x, &error), DLS_E_ARGUMENT, "name", -1);
  dls_fe_scene_settings_init(NULL);
}

TEST(scene_without_memory) {
  int dummy = 0;
  dls_fe_scene_settings settings[] = {scene_settings(0, 0),
                                      scene_settings(24, 22)}; /* K dense, sparse */
  settings[1].order = DLS_FE_TOP_FIRST;
  for (int weighted = 0; weighted < 2; weighted++) {
    dls_fe_scene *s; /* with scene, mesh (2), arrays, loads, abscissae */
    MALLOCS_FAIL((s = (dls_fe_scene *)(void *)&dummy,
                  dls_fe_scene_create_with(&s, "jean-fig4", weighted, &settings[weighted], &error)),
                 !s && error.status == DLS_E_MEMORY, DLS_OK, 6);
    dls_fe_scene_destroy(s);
  }
}

/* ---- vtu ------------------------------------------------------------------------------------- */

static char folder[256], path[300];

static void make_folder(void) {
  const char *place = getenv("TMPDIR");
  (void)snprintf(folder, sizeof folder, "%.200s/test_fe-XXXXXX", place ? place : "/tmp");
  ck_assert_ptr_nonnull(mkdtemp(folder));
  (void)snprintf(path, sizeof path, "%s/file.vtu", folder);
}
static void remove_folder(void) {
  (void)remove(path);
  ck_assert_int_eq(rmdir(folder), 0);
}

static char *contents(void) {
  FILE *file = fopen(path, "rb");
  ck_assert_ptr_nonnull(file);
  char *text = calloc(1 << 20, 1);
  ck_assert_ptr_nonnull(text);
  const size_t size = fread(text, 1, (1 << 20) - 1, file);
  ck_assert(size > 0 && feof(file));
  ck_assert_int_eq(fclose(file), 0);
  return text;
}

/* Every tag opens and closes in turn, and there is nothing but tags and numbers. */
static void check_nesting(const char *text) {
  char open[16][32];
  int depth = 0, roots = 0;
  for (const char *p = strchr(text, '<'); p; p = strchr(p + 1, '<')) {
    char name[32];
    ck_assert_ptr_nonnull(strchr(p, '>'));
    if (p[1] == '?') {
      ck_assert_ptr_eq(p, text); /* the declaration stands first */
      continue;
    }
    ck_assert_int_eq(sscanf(p[1] == '/' ? p + 2 : p + 1, "%31[A-Za-z]", name), 1);
    if (p[1] != '/') {
      ck_assert_int_lt(depth, 16);
      roots += depth == 0;
      memcpy(open[depth++], name, sizeof name);
    } else {
      ck_assert_int_gt(depth, 0);
      ck_assert_str_eq(open[--depth], name);
    }
  }
  ck_assert_int_eq(depth, 0);
  ck_assert_int_eq(roots, 1);
}

/* The numbers of the array `name`, at most `room`, and their count; -1 without such an array. */
static int numbers(const char *text, const char *name, double *x, int room) {
  char key[64];
  (void)snprintf(key, sizeof key, "Name=\"%s\"", name);
  const char *p = strstr(text, key);
  if (!p) return -1;
  p = strchr(p, '>') + 1;
  int n = 0;
  for (;;) {
    char *end;
    const double value = strtod(p, &end);
    if (end == p) break;
    ck_assert_int_lt(n, room);
    x[n++] = value;
    p = end;
  }
  ck_assert_int_eq(strncmp(p + strspn(p, " \n"), "</DataArray>", 12), 0);
  return n;
}

TEST(vtu) {
  dls_fe_mesh mesh = crooked();
  const int nodes = mesh.nodes, cells = mesh.triangles;
  double u[crooked_n], R[crooked_n], x[1000];
  double *stress = new_doubles(3 * (size_t)cells);
  for (int i = 0; i < crooked_n; i++) {
    u[i] = 1e-5 * sin(i);
    R[i] = -1e300 * cos(i);
  }
  R[0] = DBL_TRUE_MIN;
  ck_assert_int_eq(dls_fe_stress(&mesh, E0, nu0, u, stress, NULL), DLS_OK);
  ck_assert_int_eq(write_vtu(path, &mesh, u, R, stress, NULL), DLS_OK);
  char *text = contents();
  check_nesting(text);
  char counts[80];
  (void)snprintf(counts, sizeof counts, "NumberOfPoints=\"%d\" NumberOfCells=\"%d\"", nodes, cells);
  ck_assert_ptr_nonnull(strstr(text, counts));
  const char *names[] = {"displacement", "reaction", "points"};
  const double *values[] = {u, R, mesh.xy};
  for (int k = 0; k < 3; k++) {
    ck_assert_int_eq(numbers(text, names[k], x, 1000), 3 * nodes);
    for (int i = 0; i < nodes; i++) /* 17 digits: the same bits */
      ck_assert(x[3 * i] == values[k][2 * i] && x[3 * i + 1] == values[k][2 * i + 1] &&
                x[3 * i + 2] == 0);
  }
  ck_assert_int_eq(numbers(text, "stress", x, 1000), 9 * cells);
  for (int e = 0; e < cells; e++)
    ck_assert(x[9 * e] == stress[3 * e] && x[9 * e + 4] == stress[3 * e + 1] &&
              x[9 * e + 1] == stress[3 * e + 2]);
  ck_assert_int_eq(numbers(text, "connectivity", x, 1000), 3 * cells);
  for (int k = 0; k < 3 * cells; k++)
    ck_assert_double_eq(x[k], mesh.node[k]);
  ck_assert_int_eq(numbers(text, "offsets", x, 1000), cells);
  for (int e = 0; e < cells; e++)
    ck_assert_double_eq(x[e], 3 * (e + 1));
  ck_assert_int_eq(numbers(text, "types", x, 1000), cells);
  assert_all(x, cells, 5);
  free(text);

  ck_assert_int_eq(write_vtu(path, &mesh, NULL, NULL, NULL, NULL), DLS_OK);
  text = contents();
  check_nesting(text);
  ck_assert_int_eq(numbers(text, "displacement", x, 1000), -1);
  ck_assert_int_eq(numbers(text, "reaction", x, 1000), -1);
  ck_assert_int_eq(numbers(text, "stress", x, 1000), -1);
  ck_assert_int_eq(numbers(text, "points", x, 1000), 3 * nodes);
  free(text);
  free(stress);
  dls_fe_mesh_free(&mesh);
}

/* The stress as a tensor, and the state, gap and slip of two contacts at their nodes. */
TEST(vtu_of_fields) {
  dls_fe_mesh mesh = crooked();
  const int cells = mesh.triangles;
  double u[crooked_n], x[1000];
  double *stress = new_doubles(3 * (size_t)cells);
  for (int i = 0; i < crooked_n; i++)
    u[i] = 1e-5 * sin(i);
  ck_assert_int_eq(dls_fe_stress(&mesh, E0, nu0, u, stress, NULL), DLS_OK);
  int node[] = {2, 0};
  const dls_contact_state state[] = {DLS_SLIP, DLS_STICK};
  double gap[] = {0.1, -1e-17}, slip[] = {3, 4};
  const dls_fe_fields fields = {.displacement = u,
                                .stress = stress,
                                .nu = nu0,
                                .candidates = 2,
                                .node = node,
                                .state = state,
                                .gap = gap,
                                .slip = slip};
  ck_assert_int_eq(dls_fe_write_fields(path, &mesh, &fields, NULL), DLS_OK);
  char *text = contents();
  check_nesting(text);
  ck_assert_int_eq(numbers(text, "stress", x, 1000), 9 * cells);
  for (int e = 0; e < cells; e++) {
    const double *s = stress + 3 * e, zz = nu0 * (s[0] + s[1]);
    const double tensor[] = {s[0], s[2], 0, s[2], s[1], 0, 0, 0, zz};
    assert_near(x + 9 * e, tensor, 9, 0);
  }
  ck_assert_int_eq(numbers(text, "contact", x, 1000), mesh.nodes);
  for (int i = 0; i < mesh.nodes; i++)
    ck_assert_double_eq(x[i], i == 2 ? DLS_SLIP : i == 0 ? DLS_STICK : -1);
  ck_assert_int_eq(numbers(text, "gap", x, 1000), mesh.nodes);
  ck_assert(x[2] == gap[0] && x[0] == gap[1] && x[1] == 0);
  ck_assert_int_eq(numbers(text, "slip", x, 1000), mesh.nodes);
  ck_assert(x[2] == slip[0] && x[0] == slip[1] && x[1] == 0);
  free(text);
  REJECTED(dls_fe_write_fields(path, &mesh, NULL, &error), DLS_E_ARGUMENT, "fields", -1);
  node[1] = mesh.nodes;
  REJECTED(dls_fe_write_fields(path, &mesh, &fields, &error), DLS_E_ARGUMENT, "node", 1);
  node[1] = 0;
  gap[1] = NAN;
  REJECTED(dls_fe_write_fields(path, &mesh, &fields, &error), DLS_E_NOT_FINITE, "gap", 1);
  gap[1] = 0;
  slip[0] = INFINITY;
  REJECTED(dls_fe_write_fields(path, &mesh, &fields, &error), DLS_E_NOT_FINITE, "slip", 0);
  free(stress);
  dls_fe_mesh_free(&mesh);
}

TEST(vtu_bad_input) {
  dls_fe_mesh mesh;
  ck_assert_int_eq(dls_fe_mesh_block(&mesh, 1, 1, 1, 1, NULL), DLS_OK);
  double u[8] = {0}, stress[6] = {0};
  REJECTED(write_vtu(NULL, &mesh, u, u, stress, &error), DLS_E_ARGUMENT, "path", -1);
  for (int i = 0; i < 8; i++) {
    u[i] = NAN;
    REJECTED(write_vtu(path, &mesh, u, NULL, stress, &error), DLS_E_NOT_FINITE, "displacement", i);
    REJECTED(write_vtu(path, &mesh, NULL, u, stress, &error), DLS_E_NOT_FINITE, "reaction", i);
    u[i] = 0;
  }
  for (int i = 0; i < 6; i++) {
    stress[i] = INFINITY;
    REJECTED(write_vtu(path, &mesh, u, u, stress, &error), DLS_E_NOT_FINITE, "stress", i);
    stress[i] = 0;
  }
  ck_assert_int_ne(access(path, F_OK), 0); /* nothing was opened */
  REJECTED(write_vtu(folder, &mesh, u, u, stress, &error), DLS_E_FILE, "path", -1);
  dls_fe_mesh_free(&mesh);
}

TEST(vtu_disk_full) {
  dls_fe_mesh mesh = crooked();
  struct rlimit limit, before;
  ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &before), 0);
  limit = before;
  limit.rlim_cur = 1000; /* bytes; a longer file fails to be written as on a full disk */
  void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
  ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
  memset(&error, 0, sizeof error);
  const dls_status status = write_vtu(path, &mesh, NULL, NULL, NULL, &error);
  ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &before), 0);
  (void)signal(SIGXFSZ, handler);
  ck_assert_int_eq(status, DLS_E_FILE);
  ck_assert_str_eq(error.argument, "path");
  ck_assert_int_ne(access(path, F_OK), 0);
  if (access("/dev/full", W_OK) == 0) { /* only files are removed: here a link to a device */
    ck_assert_int_eq(symlink("/dev/full", path), 0);
    ck_assert_int_eq(write_vtu(path, &mesh, NULL, NULL, NULL, &error), DLS_E_FILE);
    ck_assert_int_eq(unlink(path), 0); /* it is still there */
  }
  dls_fe_mesh_free(&mesh);
}

int main(void) {
  return run_tests("fe", make_folder, remove_folder);
}
