/*
 * test_weighting.c: P of four-node and nine-node faces, the Kronecker product of two lines.
 *
 * The reference is the definition, P_ij = (1 / M_j) int N_i chi_j, by Gauss points on the faces
 * with the shape functions of the faces themselves. A point belongs to the cell of its nearest node
 * in the coordinates of the face, -1 <= xi, eta <= 1. Sixteenths of a face lie in one cell each,
 * and three points a direction are exact for degree 5.
 */
#include "delassus.h"
#include "made.h"
#include "reduced.h"
#include "run.h"

enum { most_line = 7, most = most_line * most_line };

/* A grid of faces of one order: A x B nodes. */
typedef struct faces {
  int order, A, B, count; /* count: A B */
  double s[2][most_line];
} faces;

/* Integrals over the faces: of N_i chi_j, of chi_j, of N_i N_j, of N_i. */
typedef struct integrals {
  double P[most][most], M[most], mass[most][most], N[most];
} integrals;

/* Faces of 1, 0.5, 2.5 by 2, 1; of order 2 the middle nodes between. Any unit. */
static faces grid_of(int order, double unit) {
  static const double corner[2][4] = {{0, 1, 1.5, 4}, {0, 2, 3}};
  const int edges[] = {3, 2};
  faces g = {.order = order, .A = 3 * order + 1, .B = 2 * order + 1};
  g.count = g.A * g.B;
  for (int k = 0; k < 2; k++)
    for (int n = 0; n <= order * edges[k]; n++) {
      const int e = n / order, inside = n % order;
      g.s[k][n] = unit * (inside ? (corner[k][e] + corner[k][e + 1]) / 2 : corner[k][e]) - unit;
    }
  return g;
}

/* Returns the shape function of the node at (x, y), each -1, 0 or 1, of a face of this order. */
static double face_shape(int order, int x, int y, double xi, double eta) {
  if (order == 1) return (1 + x * xi) * (1 + y * eta) / 4;
  if (x == 0 && y == 0) return (1 - xi * xi) * (1 - eta * eta);
  if (x == 0) return (1 - xi * xi) * (eta * eta + y * eta) / 2;
  if (y == 0) return (xi * xi + x * xi) * (1 - eta * eta) / 2;
  return (xi * xi + x * xi) * (eta * eta + y * eta) / 4;
}

/* Returns the place 0 .. order of the node nearest to xi. */
static int nearest_node(int order, double xi) {
  return order == 1 ? xi > 0 : 1 + (xi > 0.5) - (xi < -0.5);
}

/* Adds what a point of weight w, an area, has on the face whose first nodes are (a, b). */
static void integrate_point(const faces *g, int a, int b, double xi, double eta, double w,
                            integrals *sum) {
  int node[9], count = 0;
  double N[9];
  for (int y = 0; y <= g->order; y++)
    for (int x = 0; x <= g->order; x++) {
      const int step = 3 - g->order; /* places are -1, 1; or -1, 0, 1 */
      node[count] = a + x + g->A * (b + y);
      N[count++] = face_shape(g->order, step * x - 1, step * y - 1, xi, eta);
    }
  const int j = a + nearest_node(g->order, xi) + g->A * (b + nearest_node(g->order, eta));
  sum->M[j] += w;
  for (int k = 0; k < count; k++) {
    sum->P[node[k]][j] += w * N[k];
    sum->N[node[k]] += w * N[k];
    for (int l = 0; l < count; l++)
      sum->mass[node[k]][node[l]] += w * N[k] * N[l];
  }
}

/* Fills P and the other integrals of the grid. */
static void integrate(const faces *g, integrals *sum) {
  const double at[] = {-sqrt(0.6), 0, sqrt(0.6)}, weight[] = {5. / 18, 8. / 18, 5. / 18};
  *sum = (integrals){0};
  for (int b = 0; b + g->order < g->B; b += g->order)
    for (int a = 0; a + g->order < g->A; a += g->order) {
      const double area =
          (g->s[0][a + g->order] - g->s[0][a]) * (g->s[1][b + g->order] - g->s[1][b]);
      for (int part = 0; part < 16; part++)
        for (int k = 0; k < 9; k++) {
          const double xi = (part % 4 - 1.5 + at[k % 3] / 2) / 2;
          const double eta = (part / 4 - 1.5 + at[k / 3] / 2) / 2;
          integrate_point(g, a, b, xi, eta, area / 16 * weight[k % 3] * weight[k / 3], sum);
        }
    }
  for (int i = 0; i < g->count; i++)
    for (int j = 0; j < g->count; j++)
      sum->P[i][j] /= sum->M[j];
}

static integrals exact; /* too large for a stack */

/* Both orders and three units; nodes of the last column are candidates or not. */
TEST_EACH(product_is_the_integral, 0, 12) {
  const int order = 1 + _i % 2, all = _i / 2 % 2;
  const double unit = (double[]){1, 1e-9, 1e9}[_i / 4];
  const faces g = grid_of(order, unit);
  int candidate[most_line], p[most + 1], i[16 * most];
  double x[16 * most], area[most];
  for (int k = 0; k < g.A; k++)
    candidate[k] = all || k < g.A - 1;
  const int columns = g.A - !all;
  int count;
  ck_assert_int_eq(dls_weighting_face(order, g.A, g.s[0], candidate, g.B, g.s[1], NULL, p, i, x,
                                      area, &count, NULL),
                   DLS_OK);
  ck_assert_int_eq(count, columns * g.B);
  integrate(&g, &exact);
  int negative = 0;
  for (int c = 0; c < columns * g.B; c++) {
    const int j = c % columns + g.A * (c / columns);
    double column[most] = {0}, sum = 0;
    for (int k = p[c]; k < p[c + 1]; k++) {
      ck_assert_double_eq(column[i[k]], 0); /* one entry a place */
      column[i[k]] = x[k];
      sum += x[k];
      negative += x[k] < 0;
    }
    for (int n = 0; n < g.count; n++)
      ck_assert_double_eq_tol(column[n], exact.P[n][j], 64 * DBL_EPSILON);
    ck_assert_double_eq_tol(sum, 1, 8 * DBL_EPSILON);
    ck_assert_double_eq_tol(area[c] / exact.M[j], 1, 64 * DBL_EPSILON);
  }
  ck_assert_int_eq(negative > 0, order == 2);
}

/* Equal faces: the figures of docs/theory.md, section 6. */
TEST(equal_faces_by_hand) {
  const double s[] = {0, 1, 2, 3, 4};
  int p[26], i[400], count;
  double x[400], area[25];
  ck_assert(!dls_weighting_face(1, 3, s, NULL, 3, s, NULL, p, i, x, area, &count, NULL));
  ck_assert_int_eq(count, 9);
  ck_assert_int_eq(p[5] - p[4], 9); /* of the node in the middle */
  const double a = 1. / 64, b = 3. / 32;
  assert_close(x + p[4], (double[]){a, b, a, b, 9. / 16, b, a, b, a}, 9, DBL_EPSILON);
  ck_assert_double_eq(area[4], 1);
  ck_assert(!dls_weighting_face(2, 5, s, NULL, 5, s, NULL, p, i, x, area, &count, NULL));
  ck_assert_int_eq(count, 25);
  ck_assert_int_eq(p[13] - p[12], 25); /* of the corner in the middle */
  const double line[] = {-1. / 24, 5. / 24, 2. / 3, 5. / 24, -1. / 24};
  for (int k = 0; k < 25; k++) {
    ck_assert_int_eq(i[p[12] + k], k);
    ck_assert_double_eq_tol(x[p[12] + k], line[k % 5] * line[k / 5], DBL_EPSILON);
  }
  ck_assert_double_eq(area[12], 1);
}

/* A line of one node leaves the other line as it is; lines that are no lines are refused. */
TEST(lines_alone) {
  const double s[] = {0, 1, 4, 6}, back[] = {1, 0, 2}, even[] = {0, 1, 2, 3};
  int p[5], i[64], q[5], rows[12], columns;
  double x[64], area[4], y[12], length[4];
  dls_error error;
  ck_assert_int_eq(dls_weighting_line(4, s, NULL, q, rows, y, length, &columns, NULL), DLS_OK);
  for (int k = 0; k < 2; k++) {
    const int A = k ? 1 : 4;
    ck_assert(!dls_weighting_face(1, A, s, NULL, 5 - A, s, NULL, p, i, x, area, &columns, NULL));
    ck_assert_int_eq(columns, 4);
    ck_assert_mem_eq(p, q, sizeof p);
    ck_assert_mem_eq(i, rows, (size_t)q[4] * sizeof *i);
    ck_assert_mem_eq(x, y, (size_t)q[4] * sizeof *x);
    ck_assert_mem_eq(area, length, sizeof area);
    REFUSES(ARGUMENT, k ? "s" : "t", 1, dls_weighting_face, 1, 3, k ? back : s, NULL, 3,
            k ? s : back, NULL, p, i, x, area, &columns);
  }
  const struct {
    int order, A, B;
    const char *argument;
  } refused[] = {{3, 3, 3, "order"},    {0, 3, 3, "order"},   {1, 0, 3, "nodes_s"},
                 {1, 3, -1, "nodes_t"}, {2, 4, 3, "nodes_s"}, {2, 3, 4, "nodes_t"}};
  for (size_t k = 0; k < sizeof refused / sizeof *refused; k++) {
    columns = -7;
    ck_assert_int_lt(dls_weighting_face(refused[k].order, refused[k].A, even, NULL, refused[k].B,
                                        even, NULL, p, i, x, area, &columns, &error),
                     0);
    ck_assert_str_eq(error.argument, refused[k].argument);
    ck_assert_int_eq(columns, -7);
  }
}

/* The nodes lie on a bed of springs, K = bed int N_i N_j in each direction, a gap above the plane,
 * and a uniform pressure is on them. By hand: all move down by the gap, the bed takes bed * gap,
 * contact the rest, as one pressure on all cells; u = 0 and no tangent. */
TEST_EACH(uniform_pressure_stays_uniform, 0, 2) {
  enum { d = 3, n = d * most };
  static double K[n * n], one[n], f[n], gap[n], r[n], mu[most], x[n];
  static int Np[most + 1], Ni[most], Tp[2 * most + 1], Ti[2 * most], p[most + 1], i[16 * most];
  static double Px[16 * most], area[most];
  const double bed = 7, lift = 0.25, pressure = 5, expected = pressure - bed * lift;
  const faces g = grid_of(1 + _i, 1);
  const int rows = d * g.count;
  int columns;
  ck_assert(!dls_weighting_face(g.order, g.A, g.s[0], NULL, g.B, g.s[1], NULL, p, i, Px, area,
                                &columns, NULL));
  ck_assert_int_eq(columns, g.count);
  integrate(&g, &exact);
  memset(K, 0, sizeof K); /* another call may have been in this process */
  for (int a = 0; a < g.count; a++) {
    for (int b = 0; b < g.count; b++)
      for (int k = 0; k < d; k++)
        K[d * a + k + rows * (d * b + k)] = bed * exact.mass[a][b];
    f[d * a] = -pressure * exact.N[a];
    gap[d * a] = lift;
    mu[a] = 0.3;
    Ni[a] = d * a;
    Ti[2 * a] = d * a + 1;
    Ti[2 * a + 1] = d * a + 2;
    Np[a + 1] = a + 1;
    Tp[2 * a + 1] = 2 * a + 1;
    Tp[2 * a + 2] = 2 * a + 2;
  }
  for (int k = 0; k < rows; k++)
    one[k] = 1;
  const dls_model model = {.d = d,
                           .n = rows,
                           .nodes = g.count,
                           .operator_kind = DLS_STIFFNESS_DENSE,
                           .factorization = DLS_CHOLESKY,
                           .K = {rows, rows, rows, K},
                           .HN = {rows, g.count, Np, Ni, one},
                           .HT = {rows, 2 * g.count, Tp, Ti, one},
                           .P = {g.count, g.count, p, i, Px}};
  dls_reduction *reduction;
  dls_contact problem;
  dls_solver_settings settings = settings_with(DLS_AUTO, 1e-13);
  ck_assert_int_eq(reduce_on_W(&reduction, &model, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(reduction, f, gap, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_contact(reduction, mu, &problem, NULL), DLS_OK);
  ck_assert_int_eq(dls_solve(&problem, &settings, r, NULL, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_recover(reduction, r, x, NULL), DLS_OK);
  for (int c = 0; c < g.count; c++) {
    ck_assert_double_eq_tol(r[d * c] / area[c], expected, 1e-11 * expected);
    ck_assert_double_eq_tol(hypot(r[d * c + 1], r[d * c + 2]) / area[c], 0, 1e-11 * expected);
    ck_assert_double_eq_tol(x[d * c], -lift, 1e-11 * lift);
  }
  dls_reduction_destroy(reduction);
}
