/*
 * test_pairs.c: operators from two meshes.
 *
 * Closed forms by hand; the gap's derivative under any motion, which H_N has to be; a search over
 * all faces one by one; the patch test: constant pressure gives both sides the nodal forces of that
 * pressure, equal motions give no slip, and two elastic blocks whose meshes do not match are
 * pressed to one stress.
 */
#include <time.h>

#include "delassus.h"
#include "geometry/geometry.h"
#include "made.h"
#include "run.h"
#include "solids.h"

static const double pi = 3.14159265358979323846;

static double pairs_draw(int *seed) {
  return 2 * dlsi_draw_entry(7, (*seed)++) - 1;
}

/* y (rows) += A x */
static void push(const dls_sparse *A, const double *x, double *y) {
  for (int j = 0; j < A->cols; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      y[A->i[k]] += A->x[k] * x[j];
}

/* Returns column j of A times v. */
static double dot_column(const dls_sparse *A, int j, const double *v) {
  double sum = 0;
  for (int k = A->p[j]; k < A->p[j + 1]; k++)
    sum += A->x[k] * v[A->i[k]];
  return sum;
}

/* Faces on `points` points, each with d unknowns. */
static dls_surfaces surfaces(int d, int points, const double *X, int faces, int corners,
                             const int *face) {
  return (dls_surfaces){.d = d,
                        .n = d * points,
                        .points = points,
                        .X = X,
                        .faces = faces,
                        .corners = corners,
                        .face = face};
}

static dls_pairs pairs_of(const dls_surfaces *s) {
  dls_pairs pairs;
  dls_error error = {0};
  ck_assert_msg(dls_pairs_find(s, &pairs, &error) == DLS_OK, "%s", error.message);
  return pairs;
}

/* ---- by hand --------------------------------------------------------------------------------- */

/* A node at a quarter of the edge (0, 0) - (4, 0), 0.5 above it; nodes count from 1. The body of
 * the edge is below: to the left of 4 -> 0. Its end at 0 is held. */
TEST(edge_by_hand) {
  const double X[] = {0, 0, 4, 0, 1, 0.5};
  const int dof[] = {-1, -1, 7, 3, 0, 5}, node[] = {3}, face[] = {2, 1};
  dls_surfaces s = surfaces(2, 3, X, 1, 2, face);
  s.n = 8;
  s.base = 1, s.dof = dof;
  s.nodes = 1, s.node = node;
  dls_pairs p = pairs_of(&s);
  ck_assert(p.nodes == 1 && p.candidates == 1 && p.node[0] == 3 && p.face[0] == 0 && !p.P.p &&
            !p.measure);
  ck_assert(p.state[0] == DLS_PAIR_FOUND && p.g[0] == 0.5 && p.g[1] == 0);
  const double frame[] = {0, 1, 1, 0}, normal[8] = {0, 0, 0, -0.25, 0, 1},
               tangent[8] = {[0] = 1, [7] = -0.25};
  double HN[8] = {0}, HT[8] = {0};
  push(&p.HN, (double[]){1}, HN);
  push(&p.HT, (double[]){1}, HT);
  assert_close(p.frame, frame, 4, 1e-15);
  assert_close(HN, normal, 8, 1e-15);
  assert_close(HT, tangent, 8, 1e-15);
  ck_assert(p.HN.rows == 8 && p.HN.cols == 1 && p.HT.rows == 8 && p.HT.cols == 1);
  ck_assert(p.HN.p[1] == 2 && p.HT.p[1] == 2); /* no entry where the normal has no part */
  dls_pairs_free(&p);
  ck_assert(!p.g && !p.HN.p);
  dls_pairs_free(&p);
  dls_pairs_free(NULL);
}

/* T3 and Q4 in the plane z = 0, and a node over (1/2, 1/4) of them. Frame: n = z; x is the first of
 * the axes that n leans to least: t = x, s = y. */
TEST_EACH(faces_by_hand, 3, 5) {
  const double X[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.25, -0.125};
  const int node[] = {4}, q4[] = {0, 1, 2, 3}, t3[] = {0, 1, 3};
  const double of_q4[] = {0.375, 0.375, 0.125, 0.125}, of_t3[] = {0.25, 0.5, 0, 0.25};
  dls_surfaces s = surfaces(3, 5, X, 1, _i, _i == 4 ? q4 : t3);
  s.nodes = 1, s.node = node;
  dls_pairs p = pairs_of(&s);
  const double *w = _i == 4 ? of_q4 : of_t3;
  double HN[15] = {0}, expected[15] = {0};
  for (int k = 0; k < 4; k++)
    expected[3 * k + 2] = -w[k];
  expected[14] = 1;
  push(&p.HN, (double[]){1}, HN);
  assert_close(HN, expected, 15, 1e-15);
  const double frame[] = {0, 0, 1, 1, 0, 0, 0, 1, 0};
  assert_close(p.frame, frame, 9, 1e-15);
  ck_assert_double_eq_tol(p.g[0], -0.125, 1e-15);
  double HT[15] = {0};
  push(&p.HT, (double[]){0, 1}, HT);
  for (int k = 0; k < 5; k++)
    ck_assert_double_eq_tol(HT[3 * k + 1], expected[3 * k + 2], 1e-15);
  dls_pairs_free(&p);
}

/* Every state of a node, over the edges (-1, 0) - (0, 0) - (1, -1), whose body is below: a convex
 * corner of 45 degrees at node 1. Node 8 is node 1 itself; node 9 is over an edge that is held, and
 * is held. */
TEST(states) {
  const double a = sin(pi / 8), b = cos(pi / 8);
  const double X[] = {-1, 0,    0,   0,     1,     -1,        -0.5, 0.25,  -0.5,
                      5,  -1.5, 0.1, a / 2, b / 2, -1e-7 - 1, 0.1,  -0.25, 0.1};
  int dof[18];
  for (int k = 0; k < 18; k++)
    dof[k] = k < 4 || k > 15 ? -1 : k;
  const int node[] = {3, 4, 5, 6, 7, 1, 8}, face[] = {1, 0, 2, 1};
  dls_surfaces s = surfaces(2, 9, X, 2, 2, face);
  s.dof = dof;
  s.nodes = 7, s.node = node;
  const dls_pair_state expected[] = {DLS_PAIR_FOUND, DLS_PAIR_FAR,   DLS_PAIR_BESIDE,
                                     DLS_PAIR_FOUND, DLS_PAIR_FOUND, DLS_PAIR_SHARED,
                                     DLS_PAIR_HELD};
  dls_pairs p = pairs_of(&s);
  for (int k = 0; k < 7; k++)
    ck_assert_int_eq(p.state[k], expected[k]);
  ck_assert(p.nodes == 3 && p.node[0] == 3 && p.node[1] == 6 && p.node[2] == 7);
  /* in the middle of the cone: from the corner to the node */
  ck_assert_double_eq_tol(p.g[2], 0.5, 1e-15);
  assert_near(p.frame + 4, (double[]){a, b}, 2, 1e-15);
  dls_pairs_free(&p);
}

/* On the corner itself the normal is the mean of both edges, whatever their order; beyond a
 * straight line of edges, level with one of their nodes, there is nothing; in a concave corner the
 * nearer edge counts. */
TEST(edges_and_corners) {
  const double X[] = {-1, 0, 0, 0, 0, -1, 0, 0};
  const int node[] = {3}, face[2][4] = {{1, 0, 2, 1}, {2, 1, 1, 0}};
  dls_surfaces s = surfaces(2, 4, X, 2, 2, NULL);
  s.nodes = 1, s.node = node;
  for (int order = 0; order < 2; order++) {
    s.face = face[order];
    dls_pairs p = pairs_of(&s);
    ck_assert_int_eq(p.nodes, 1);
    const double n[] = {sqrt(0.5), sqrt(0.5)};
    assert_close(p.frame, n, 2, 1e-15);
    ck_assert_double_eq(p.g[0], 0);
    dls_pairs_free(&p);
  }
  const double flat[] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0, 1, 1.25, 0.1};
  const int end[] = {6}, two[] = {0, 1, 4, 3, 1, 2, 5, 4};
  dls_surfaces f = surfaces(3, 7, flat, 2, 4, two);
  f.nodes = 1, f.node = end;
  dls_pairs p = pairs_of(&f);
  ck_assert(p.nodes == 0 && p.state[0] == DLS_PAIR_BESIDE);
  dls_pairs_free(&p);
  const double valley[] = {0, 2, 0, 0, 2, 0, 0.5, 0.25};
  const int in[] = {3}, walls[] = {1, 0, 2, 1};
  dls_surfaces v = surfaces(2, 4, valley, 2, 2, walls);
  v.nodes = 1, v.node = in;
  p = pairs_of(&v);
  ck_assert(p.nodes == 1 && p.face[0] == 1 && p.g[0] == 0.25 && p.frame[1] == 1);
  dls_pairs_free(&p);
}

TEST(wall) {
  const double X[] = {3, 4, 1, 1, 2, 2}, plane[] = {0, 0, 0, 0, 0, 2};
  const int node[] = {1, 0};
  dls_surfaces s = {.d = 3, .n = 6, .points = 2, .X = X, .nodes = 2, .node = node, .wall = plane};
  dls_pairs p = pairs_of(&s);
  ck_assert(p.nodes == 2 && p.face[0] == -1 && p.g[0] == 2 && p.g[3] == 1 && p.node[0] == 1);
  ck_assert(p.HN.p[2] == 2 && p.HN.i[0] == 5 && p.HN.x[0] == 1);
  dls_pairs_free(&p);
  s.reach = 1.5;
  p = pairs_of(&s);
  ck_assert(p.nodes == 1 && p.state[0] == DLS_PAIR_FAR && p.node[0] == 0);
  dls_pairs_free(&p);
  const dls_surfaces flat = {.d = 2,
                             .n = 6,
                             .points = 3,
                             .X = X,
                             .nodes = 1,
                             .node = node,
                             .wall = (double[]){0, 0, 0, 3}};
  p = pairs_of(&flat);
  ck_assert(p.g[0] == 1 && p.frame[1] == 1 && p.frame[2] == 1);
  dls_pairs_free(&p);
  const dls_surfaces none = {.d = 2, .n = 6, .points = 3, .X = X, .nodes = 1, .node = node};
  p = pairs_of(&none);
  ck_assert(p.nodes == 0 && p.HN.cols == 0 && p.state[0] == DLS_PAIR_FAR);
  dls_pairs_free(&p);
}

/* ---- random surfaces ------------------------------------------------------------------------- */

enum { side = 24, grid = side * side, above = 300, all = grid + above };

/* A wavy sheet of side^2 nodes over [0, side - 1]^2, in triangles or quadrilaterals, and nodes near
 * it; in 2D its first row, and edges. */
typedef struct sheet {
  double X[3 * all];
  int face[6 * grid], node[above];
  dls_surfaces s;
} sheet;

static void sheet_make(sheet *S, int d, int corners, double unit) {
  int seed = 1, faces = 0;
  const int wide = d == 2 ? 1 : side, points = wide * side;
  for (int j = 0; j < wide; j++)
    for (int i = 0; i < side; i++) {
      double *x = S->X + d * (i + side * j);
      x[0] = i + 0.2 * pairs_draw(&seed);
      if (d == 3) x[1] = j + 0.2 * pairs_draw(&seed);
      x[d - 1] = sin(0.4 * i) * cos(0.3 * j) + 0.1 * pairs_draw(&seed);
    }
  for (int j = 0; j < (d == 2 ? 1 : side - 1); j++)
    for (int i = 0; i < side - 1; i++) {
      const int a = i + side * j, q[] = {a, a + 1, a + 1 + side, a + side},
                t[] = {a, a + 1, a + 1 + side, a, a + 1 + side, a + side};
      const int e[4] = {a + 1, a}, count = corners == 3 ? 2 : 1;
      const int *from = d == 2 ? e : corners == 3 ? t : q;
      for (int k = 0; k < corners * count; k++)
        S->face[corners * faces + k] = from[k];
      faces += count;
    }
  for (int k = 0; k < above; k++) {
    double *x = S->X + d * (points + k);
    for (int i = 0; i < d - 1; i++)
      x[i] = (side - 1) * (pairs_draw(&seed) + 1) / 2;
    x[d - 1] = 1.5 * pairs_draw(&seed);
    S->node[k] = points + k;
  }
  for (int k = 0; k < d * (points + above); k++)
    S->X[k] *= unit;
  S->s = surfaces(d, points + above, S->X, faces, corners, S->face);
  S->s.nodes = above, S->s.node = S->node;
}

/* d, corners of three kinds */
static const int kinds[3][2] = {{2, 2}, {3, 3}, {3, 4}};

/* The gap of each pair changes as H_N says under any motion of both bodies, by central differences;
 * the sliding velocity is that of the node relative to its face. */
TEST_EACH(gap_moves_as_normals_say, 0, 3) {
  static sheet S, moved;
  static double v[3 * all];
  const int d = kinds[_i][0];
  int seed = 5000, compared = 0;
  sheet_make(&S, d, kinds[_i][1], 1);
  for (int k = 0; k < S.s.n; k++)
    v[k] = pairs_draw(&seed);
  dls_pairs p = pairs_of(&S.s);
  ck_assert_int_ge(p.nodes, 200);
  const double h = 1e-6;
  static double g[2][all];
  static int face[2][all], which[2][all];
  int count[2];
  for (int turn = 0; turn < 2; turn++) {
    moved = S;
    moved.s.X = moved.X;
    for (int k = 0; k < S.s.n; k++)
      moved.X[k] += (turn ? h : -h) * v[k];
    dls_pairs q = pairs_of(&moved.s);
    count[turn] = q.nodes;
    for (int c = 0; c < q.nodes; c++) {
      g[turn][c] = q.g[d * c];
      face[turn][c] = q.face[c];
      which[turn][c] = q.node[c];
    }
    dls_pairs_free(&q);
  }
  ck_assert(count[0] >= p.nodes - 2 && count[1] >= p.nodes - 2);
  for (int c = 0; c < p.nodes && c < count[0] && c < count[1]; c++) {
    if (which[0][c] != p.node[c] || which[1][c] != p.node[c]) break;
    if (face[0][c] != p.face[c] || face[1][c] != p.face[c]) continue; /* it changed its face */
    ck_assert_double_eq_tol((g[1][c] - g[0][c]) / (2 * h), dot_column(&p.HN, c, v), 2e-6);
    compared++;
  }
  ck_assert_int_ge(compared, 150);
  for (int c = 0; c < d * p.nodes; c++) /* a rigid translation moves nothing */
    for (int k = 0; k < d; k++) {
      double u = 0;
      const dls_sparse *H = c % d ? &p.HT : &p.HN;
      const int j = c % d ? (d - 1) * (c / d) + c % d - 1 : c / d;
      for (int e = H->p[j]; e < H->p[j + 1]; e++)
        u += H->i[e] % d == k ? H->x[e] : 0;
      ck_assert_double_eq_tol(u, 0, 1e-14);
    }
  dls_pairs_free(&p);
}

/* The tree finds what a search over all faces finds. */
TEST_EACH(as_one_by_one, 0, 3) {
  static sheet S;
  const int d = kinds[_i][0], corners = kinds[_i][1];
  sheet_make(&S, d, corners, 1);
  S.s.reach = INFINITY;
  dls_pairs p = pairs_of(&S.s);
  for (int c = 0; c < p.nodes; c++) {
    double P[3] = {0}, least = INFINITY;
    memcpy(P, S.X + d * p.node[c], (size_t)d * sizeof *P);
    for (int f = 0; f < S.s.faces; f++) {
      double C[4][3], w[4], x[3], n[3];
      const dlsi_faces faces = {d, S.s.faces, corners, 0, S.X, S.face};
      dlsi_face_corners(&faces, f, C);
      dlsi_face_nearest(d, corners, C, P, w, x, n);
      least = fmin(least, sqrt(pow(P[0] - x[0], 2) + pow(P[1] - x[1], 2) + pow(P[2] - x[2], 2)));
    }
    ck_assert_double_le(least, fabs(p.g[d * c]) + 1e-12);
    if (p.g[d * c] > 0 && p.g[d * c] < 0.1) ck_assert_double_eq_tol(p.g[d * c], least, 1e-12);
  }
  dls_pairs_free(&p);
}

/* Other units; faces in another order. */
TEST_EACH(units_and_order, 0, 3) {
  static sheet S, T;
  const int d = kinds[_i][0], corners = kinds[_i][1];
  sheet_make(&S, d, corners, 1);
  dls_pairs p = pairs_of(&S.s);
  for (int power = -30; power <= 30; power += 60) {
    sheet_make(&T, d, corners, ldexp(1, power));
    T.s.reach = 0;
    dls_pairs q = pairs_of(&T.s);
    ck_assert_int_eq(q.nodes, p.nodes);
    ck_assert_mem_eq(q.face, p.face, (size_t)p.nodes * sizeof *p.face);
    ck_assert_mem_eq(q.HN.x, p.HN.x, (size_t)p.HN.p[p.nodes] * sizeof *p.HN.x);
    ck_assert_mem_eq(q.HT.x, p.HT.x, (size_t)p.HT.p[p.HT.cols] * sizeof *p.HT.x);
    for (int c = 0; c < d * p.nodes; c++)
      ck_assert_double_eq(ldexp(p.g[c], power), q.g[c]);
    dls_pairs_free(&q);
  }
  T = S;
  T.s.X = T.X;
  T.s.face = T.face;
  T.s.node = T.node;
  for (int f = 0; f < S.s.faces; f++)
    memcpy(T.face + corners * f, S.face + corners * (S.s.faces - 1 - f),
           (size_t)corners * sizeof(int));
  dls_pairs q = pairs_of(&T.s);
  ck_assert_int_eq(q.nodes, p.nodes);
  static double v[3 * all];
  int seed = 9000, same = 0;
  for (int k = 0; k < S.s.n; k++)
    v[k] = pairs_draw(&seed);
  for (int c = 0; c < p.nodes; c++) { /* on an edge it is the first of the faces that meet there */
    same += q.face[c] == S.s.faces - 1 - p.face[c];
    ck_assert_double_eq_tol(dot_column(&q.HN, c, v), dot_column(&p.HN, c, v), 1e-12);
    ck_assert_double_eq_tol(dot_column(&q.HT, c, v), dot_column(&p.HT, c, v), 1e-12);
  }
  ck_assert_int_ge(same, 3 * p.nodes / 4);
  assert_close(q.g, p.g, d * p.nodes, 1e-15);
  dls_pairs_free(&q);
  dls_pairs_free(&p);
}

/* ---- 10^5 against 10^5 -------------------------------------------------------------------------
 * */

/* Nodes of a sphere against the faces of another one, CPU seconds; half a second is usual. */
TEST(a_hundred_thousand) {
  enum { n = 317, m = 316, count = n * n };
  double *X = malloc(2 * count * 3 * sizeof *X);
  int *node = malloc(count * sizeof *node), *face = malloc(4 * m * m * sizeof *face);
  ck_assert(X && node && face);
  for (int body = 0; body < 2; body++)
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++) { /* a quarter of it, from 45 to 135 degrees */
        const double a = pi * (0.25 + 0.5 * (i + (body ? 0.3 : 0) * (i > 0 && i < m)) / m);
        const double b = pi * (0.25 + 0.5 * (j + (body ? 0.4 : 0) * (j > 0 && j < m)) / m),
                     r = body ? 1.001 : 1;
        double *x = X + 3 * (count * body + i + n * j);
        x[0] = r * sin(a) * cos(b);
        x[1] = r * sin(a) * sin(b);
        x[2] = r * cos(a);
      }
  for (int k = 0; k < count; k++)
    node[k] = count + k;
  for (int j = 0; j < m; j++)
    for (int i = 0; i < m; i++) {
      const int q = i + n * j, corner[] = {q, q + 1, q + 1 + n, q + n};
      memcpy(face + 4 * (i + m * j), corner, sizeof corner);
    }
  dls_surfaces s = surfaces(3, 2 * count, X, m * m, 4, face);
  s.n = 6 * count;
  s.nodes = count, s.node = node;
  const clock_t begun = clock();
  dls_pairs p = pairs_of(&s);
  const double seconds = (double)(clock() - begun) / CLOCKS_PER_SEC;
  printf("pairs: %d nodes, %d faces: %d pairs, %.2f s\n", count, m * m, p.nodes, seconds);
  ck_assert_int_eq(p.nodes, count - 4 * m); /* the border has none below */
  for (int c = 0; c < p.nodes; c++)
    ck_assert(p.g[3 * c] > 0.0009 && p.g[3 * c] < 0.0011);
  ck_assert_double_le(seconds, 10);
  dls_pairs_free(&p);
  free(X);
  free(node);
  free(face);
}

/* ---- mortar ---------------------------------------------------------------------------------- */

/* Two grids over [0, 1] or [0, 1]^2 that do not match, moved by any affine map, gap .01 along the
 * normal. The other one in quadrilaterals or triangles, the own one too. */
typedef struct patch {
  double X[3 * 100], map[3][3];
  int count[2], first[2], face[200], own[200];
  dls_surfaces s;
} patch;

static void patch_make(patch *M, int d, int own_corners, int corners) {
  int seed = 90, points = 0;
  *M = (patch){.count = {4, 5}};
  double line[2][3][6] = {{{0}}};
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++)
      M->map[i][k] = (i == k) + 0.3 * pairs_draw(&seed);
  for (int i = 0; d == 2 && i < 3; i++)
    M->map[i][2] = M->map[2][i] = i == 2;
  double n[3];
  for (int k = 0; k < 3; k++) { /* of the plane: in 2D y is the first image's turn */
    const int a = (k + 1) % 3, b = (k + 2) % 3;
    n[k] = M->map[a][0] * M->map[b][1] - M->map[b][0] * M->map[a][1];
  }
  if (d == 2) n[0] = -M->map[1][0], n[1] = M->map[0][0], n[2] = 0;
  const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  for (int body = 0; body < 2; body++) {
    const int cells = M->count[body], nodes = cells + 1;
    M->first[body] = points;
    for (int i = 0; i < 2; i++)
      for (int k = 0; k <= cells; k++)
        line[body][i][k] = k == 0 || k == cells ? k / cells : (k + 0.3 * pairs_draw(&seed)) / cells;
    for (int j = 0; j < (d == 2 ? 1 : nodes); j++)
      for (int i = 0; i < nodes; i++, points++)
        for (int k = 0; k < d; k++)
          M->X[d * points + k] = M->map[k][0] * line[body][0][i] +
                                 (d == 3) * M->map[k][1] * line[body][1][j] +
                                 (body ? 0 : 0.01) * n[k] / length;
    int *to = body ? M->face : M->own, faces = 0;
    const int kind = body ? corners : own_corners;
    for (int j = 0; j < (d == 2 ? 1 : cells); j++)
      for (int i = 0; i < cells; i++) {
        const int a = M->first[body] + i + nodes * j, b = a + nodes;
        const int up[] = {a, a + 1, b + 1, b}, down[] = {a, b, b + 1, a + 1},
                  edge[2][2] = {{a, a + 1}, {a + 1, a}};
        const int *q = body ? up : down, t[] = {q[0], q[1], q[2], q[0], q[2], q[3]},
                  per = kind == 3 ? 2 : 1;
        const int *from = d == 2 ? edge[body] : kind == 3 ? t : q;
        for (int k = 0; k < kind * per; k++)
          to[kind * faces + k] = from[k];
        faces += per;
      }
    if (body)
      M->s.faces = faces;
    else
      M->s.own_faces = faces;
  }
  M->s.d = d;
  M->s.n = d * points;
  M->s.points = points;
  M->s.X = M->X;
  M->s.corners = corners;
  M->s.own_corners = own_corners;
  M->s.face = M->face;
  M->s.own = M->own;
}

/* Forces of the unit pressure at the nodes of faces: a part of each face's area, by its shape. */
static void patch_forces(const patch *M, int count, int corners, const int *face, double *F) {
  for (int f = 0; f < count; f++) {
    double e[2][3] = {{0}};
    for (int k = 0; k < M->s.d; k++) {
      const double *X = M->X;
      const int d = M->s.d, *q = face + corners * f;
      e[0][k] = X[d * q[1] + k] - X[d * q[0] + k];
      e[1][k] = X[d * q[corners - 1] + k] - X[d * q[0] + k];
    }
    double c[3], area = 0;
    for (int k = 0; k < 3; k++) {
      c[k] = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
      area = hypot(area, M->s.d == 2 ? e[0][k] : c[k]);
    }
    for (int k = 0; k < corners; k++)
      F[face[corners * f + k]] += area / (corners == 3 ? 6 : corners);
  }
}

static const int patches[5][3] = {{2, 2, 2}, {3, 4, 4}, {3, 3, 3}, {3, 3, 4}, {3, 4, 3}};

TEST_EACH(patch_test, 0, 5) {
  static patch M;
  const int d = patches[_i][0];
  patch_make(&M, d, patches[_i][1], patches[_i][2]);
  dls_pairs p = pairs_of(&M.s);
  const int own = M.first[1];
  ck_assert(p.candidates == own && p.P.rows == p.nodes && p.P.cols == own && !p.state);
  double F[100] = {0}, R[300] = {0};
  static double nodal[20000];
  patch_forces(&M, M.s.own_faces, M.s.own_corners, M.own, F);
  for (int c = 0; c < own; c++) {
    ck_assert_int_eq(p.node[c], c);
    ck_assert_double_eq_tol(p.measure[c], F[c], 1e-13);
    double sum = 0;
    for (int k = p.P.p[c]; k < p.P.p[c + 1]; k++)
      sum += p.P.x[k];
    ck_assert_double_eq_tol(sum, 1, 1e-13);
  }
  for (int q = 0; q < p.nodes; q++)
    ck_assert_double_eq_tol(p.g[d * q], 0.01, 1e-14);
  /* constant pressure: r = A, loads H_N P r on both sides */
  ck_assert_int_le(p.nodes, 20000);
  memset(nodal, 0, sizeof nodal);
  push(&p.P, p.measure, nodal);
  push(&p.HN, nodal, R);
  patch_forces(&M, M.s.faces, M.s.corners, M.face, F);
  for (int k = 0; k < M.s.points; k++)
    for (int i = 0; i < d; i++)
      ck_assert_double_eq_tol(R[d * k + i], (k < own ? 1 : -1) * F[k] * p.frame[i], 1e-13);
  /* one affine motion of both sides: no relative motion but that of the gap */
  double v[300];
  for (int k = 0; k < M.s.points; k++)
    for (int i = 0; i < d; i++) {
      double x = 0.5 + i;
      for (int l = 0; l < d; l++)
        x += (1 + i - 2 * l) * (M.X[d * k + l] - (k < own ? 0.01 * p.frame[l] : 0));
      v[d * k + i] = x;
    }
  for (int j = 0; j < d * p.nodes; j++)
    ck_assert_double_eq_tol(
        j < p.nodes ? dot_column(&p.HN, j, v) : dot_column(&p.HT, j - p.nodes, v), 0, 1e-13);
  dls_pairs_free(&p);
}

/* Two elastic blocks, 3 and 4 squares wide, 3 high: pressed by 1 to one stress, on rollers at the
 * left and at the bottom. Plane strain: the displacements are linear. */
TEST(blocks_pressed_to_one_stress) {
  enum { wide = 12, high = 2 };
  solids S;
  double X[2 * 100], lower[2 * 4 * 3], upper[2 * 5 * 3];
  for (int j = 0; j <= high; j++)
    for (int i = 0; i <= 4; i++) {
      if (i < 4) {
        lower[2 * (i + 4 * j)] = wide * i / 3.;
        lower[2 * (i + 4 * j) + 1] = 4 * j;
      }
      upper[2 * (i + 5 * j)] = wide * i / 4.;
      upper[2 * (i + 5 * j) + 1] = 8 + 4 * j;
    }
  solids_new(&S, 2, 27, 0);
  const int a = solids_mapped(&S, (int[]){3, high, 0}, lower, 1),
            b = solids_mapped(&S, (int[]){4, high, 0}, upper, 1);
  memcpy(X, lower, sizeof lower);
  memcpy(X + 2 * b, upper, sizeof upper);
  const double stiff = 1e9; /* rollers */
  for (int j = 0; j <= high; j++) {
    solids_spring(&S, a + 4 * j, 0, stiff);
    solids_spring(&S, b + 5 * j, 0, stiff);
  }
  for (int i = 0; i < 4; i++)
    solids_spring(&S, a + i, 1, stiff * wide / 3 * (i % 3 ? 1 : 0.5));
  int own[8], face[6];
  for (int i = 0; i < 4; i++) {
    own[2 * i] = b + i;
    own[2 * i + 1] = b + i + 1;
    if (i == 3) break;
    face[2 * i] = a + 4 * high + i + 1;
    face[2 * i + 1] = a + 4 * high + i;
  }
  dls_surfaces s = surfaces(2, 27, X, 3, 2, face);
  s.own_faces = 4, s.own_corners = 2, s.own = own;
  dls_pairs p = pairs_of(&s);
  double f[54] = {0}, x[54], r[10], u[10];
  for (int i = 0; i < 5; i++)
    f[2 * (b + 5 * high + i) + 1] = -wide / 4. * (i % 4 ? 1 : 0.5);
  dls_model model = *solids_model(&S);
  model.nodes = p.nodes;
  model.HN = p.HN;
  model.HT = p.HT;
  model.P = p.P;
  dls_solver_settings settings = settings_with(DLS_AUTO, 1e-13);
  const double mu[5] = {0};
  ck_assert_int_eq(p.candidates, 5);
  dls_reduction *reduction = reduction_of(&model, NULL);
  ck_assert_int_eq(dls_reduction_load(reduction, f, p.g, NULL), DLS_OK);
  ck_assert_int_ge(dls_reduction_solve(reduction, mu, &settings, r, u, x, NULL, NULL), 0);
  for (int c = 0; c < 5; c++)
    ck_assert_double_eq_tol(r[2 * c] / p.measure[c], 1, 1e-8);
  for (int k = 0; k < 27; k++) { /* E = 1, nu = .3: eps_y = -(1 - nu^2), eps_x = nu (1 + nu) */
    assert_near(x + 2 * k, (double[]){0.39 * X[2 * k], -0.91 * X[2 * k + 1]}, 2, 1e-7 * wide);
  }
  dls_reduction_destroy(reduction);
  dls_pairs_free(&p);
  solids_free(&S);
}

/* Faces that look away, beyond reach or without a common part give nothing; a node of both sides is
 * no candidate. */
TEST(mortar_leaves_out) {
  const double X[] = {0, 0, 1, 0, 0.5, 0.1, 1.5, 0.1};
  int face[] = {1, 0}, own[] = {2, 3};
  dls_surfaces s = surfaces(2, 4, X, 1, 2, face);
  s.own_faces = 1, s.own_corners = 2, s.own = own;
  dls_pairs p = pairs_of(&s);
  ck_assert(p.nodes == 2 && p.candidates == 2 && p.node[0] == 2);
  assert_near(p.measure, (double[]){0.375, 0.125}, 2, 1e-15); /* of the half that is covered */
  dls_pairs_free(&p);
  s.reach = 0.05;
  p = pairs_of(&s);
  ck_assert(p.nodes == 0 && p.candidates == 0 && p.P.cols == 0);
  dls_pairs_free(&p);
  s.reach = 0;
  own[0] = 3, own[1] = 2;
  p = pairs_of(&s);
  ck_assert_int_eq(p.nodes, 0);
  dls_pairs_free(&p);
  own[0] = 0, own[1] = 3;
  p = pairs_of(&s);
  ck_assert(p.candidates == 1 && p.node[0] == 3);
  dls_pairs_free(&p);
}

/* ---- wrong input, no memory --------------------------------------------------------------------
 * */

TEST(wrong_input) {
  double X[] = {0, 0, 4, 0, 1, 0.5}, plane[] = {0, 0, 0, 1};
  int dof[] = {-1, -1, 7, 3, 0, 5}, node[] = {3, 1}, face[] = {2, 1}, own[] = {1, 3};
  dls_surfaces good = surfaces(2, 3, X, 1, 2, face);
  good.n = 8;
  good.base = 1, good.dof = dof;
  good.nodes = 1, good.node = node;
  dls_pairs out;
  dls_error e;
#define EXPECT(change, status, name, index)                                                        \
  do {                                                                                             \
    dls_surfaces s = good;                                                                         \
    change;                                                                                        \
    memset(&out, 1, sizeof out);                                                                   \
    expect_error(dls_pairs_find(&s, &out, &e), &e, status, "dls_pairs_find", name, index);         \
    ck_assert(!out.g && !out.HN.p && out.nodes == 0);                                              \
  } while (0)
  EXPECT(s.d = 1, DLS_E_ARGUMENT, "d", -1);
  EXPECT(s.base = 2, DLS_E_ARGUMENT, "base", -1);
  EXPECT(s.n = -1, DLS_E_SIZE, "n", -1);
  EXPECT(s.n = 7, DLS_E_ARGUMENT, "dof", 2);
  EXPECT((s.dof = NULL, s.n = 5), DLS_E_SIZE, "n", -1);
  EXPECT(s.points = -1, DLS_E_SIZE, "points", -1);
  EXPECT(s.points = 2, DLS_E_ARGUMENT, "node", 0);
  EXPECT(s.X = NULL, DLS_E_ARGUMENT, "X", -1);
  EXPECT(s.nodes = -1, DLS_E_SIZE, "nodes", -1);
  EXPECT(s.node = NULL, DLS_E_ARGUMENT, "node", -1);
  EXPECT(s.faces = -1, DLS_E_SIZE, "faces", -1);
  EXPECT(s.face = NULL, DLS_E_ARGUMENT, "face", -1);
  EXPECT(s.corners = 3, DLS_E_ARGUMENT, "corners", -1);
  EXPECT((s.own = own, s.own_faces = 1, s.own_corners = 4), DLS_E_ARGUMENT, "own_corners", -1);
  EXPECT((s.own = own, s.own_faces = -1), DLS_E_SIZE, "own_faces", -1);
  EXPECT(s.reach = -1, DLS_E_ARGUMENT, "reach", -1);
  EXPECT(s.reach = NAN, DLS_E_NOT_FINITE, "reach", -1);
  EXPECT(s.wall = plane, DLS_E_ARGUMENT, "wall", -1);
  EXPECT((s.wall = plane, s.faces = 0, s.own = own), DLS_E_ARGUMENT, "wall", -1);
  X[3] = NAN;
  EXPECT((void)0, DLS_E_NOT_FINITE, "X", 3);
  X[3] = 0;
  dof[4] = 8;
  EXPECT((void)0, DLS_E_ARGUMENT, "dof", 4);
  dof[4] = -2;
  EXPECT((void)0, DLS_E_ARGUMENT, "dof", 4);
  dof[4] = 0;
  node[1] = 3;
  EXPECT(s.nodes = 2, DLS_E_ARGUMENT, "node", 1);
  node[1] = 0;
  EXPECT(s.nodes = 2, DLS_E_ARGUMENT, "node", 1);
  face[1] = 4;
  EXPECT((void)0, DLS_E_ARGUMENT, "face", 1);
  face[1] = 2;
  EXPECT((void)0, DLS_E_ARGUMENT, "face", 0);
  face[1] = 1;
  own[1] = 1;
  EXPECT((s.own = own, s.own_faces = 1, s.own_corners = 2), DLS_E_ARGUMENT, "own", 0);
  own[1] = 4;
  EXPECT((s.own = own, s.own_faces = 1, s.own_corners = 2), DLS_E_ARGUMENT, "own", 1);
  plane[3] = 0;
  EXPECT((s.wall = plane, s.faces = 0), DLS_E_ARGUMENT, "wall", -1);
  plane[0] = INFINITY;
  EXPECT((s.wall = plane, s.faces = 0), DLS_E_NOT_FINITE, "wall", 0);
#undef EXPECT
  REFUSES(ARGUMENT, "surfaces", -1, dls_pairs_find, NULL, &out);
  REFUSES(ARGUMENT, "out", -1, dls_pairs_find, &good, NULL);
  ck_assert_int_eq(dls_pairs_find(NULL, NULL, NULL), DLS_E_ARGUMENT);
}

TEST(every_failing_malloc_unwinds) {
  static sheet S;
  static patch M;
  sheet_make(&S, 3, 4, 1);
  patch_make(&M, 3, 3, 4);
  for (int mortar = 0; mortar < 2; mortar++) {
    dls_pairs p;
    dls_error e = {0};
    MALLOCS_FAIL(dls_pairs_find(mortar ? &M.s : &S.s, &p, &e), !p.g && e.status == DLS_E_MEMORY,
                 DLS_OK, 15);
    dls_pairs_free(&p);
  }
}
