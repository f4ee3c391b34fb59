/* test_bodies.c: W = H^T H of rigid bodies: its blocks, products, certificate, subsets. */
#include "cases.h"
#include "contact/contact.h"
#include "delassus.h"
#include "rigid.h"
#include "run.h"

static model a;
static bodies_storage B;
static dls_contact p;

/* Blocks, rows increasing, symmetric to the last bit, are those of W dense. */
TEST_EACH(blocks_are_those_of_dense, 0, 60) {
  bodies_model(&a, &B, &p, _i);
  const int d = a.p.d, nc = a.p.nc, m = d * nc;
  int count = -1, expected, start[most + 1], row[most * most];
  static double x[most * most], W[most * most];
  dls_blocks blocks;
  ck_assert_int_eq(dls_bodies_count(&p, &count, NULL), DLS_OK);
  ck_assert_int_eq(dls_blocks_count(&a.p.W, d, &expected, NULL), DLS_OK);
  ck_assert_int_eq(count, expected);
  ck_assert_int_eq(dls_blocks_from_bodies(&p, start, row, x, &blocks, NULL), DLS_OK);
  ck_assert_int_eq(blocks.p[nc], count);
  for (int c = 0; c < nc; c++)
    for (int k = start[c] + 1; k < start[c + 1]; k++)
      ck_assert_int_gt(row[k], row[k - 1]);
  ck_assert_int_eq(dls_blocks_to_dense(&blocks, W, m, NULL), DLS_OK);
  for (int j = 0; j < m; j++)
    for (int i = 0; i < m; i++) {
      ck_assert(fabs(W[i + m * j] - a.W[i + m * j]) <= 1e-15 * 12);
      ck_assert(W[i + m * j] == W[j + m * i]);
    }
}

/* Everything that takes a problem says of bodies what it says of W dense. */
TEST_EACH(doors_agree_with_dense, 0, 60) {
  bodies_model(&a, &B, &p, _i);
  const int d = a.p.d, nc = a.p.nc, m = d * nc;
  double r[most], u[2][most];
  dls_certificate c[2];
  dls_contact_state state[2][most];
  const dls_contact *const both[2] = {&a.p, &p};
  for (int k = 0; k < m; k++)
    r[k] = fabs(uniform());
  for (int k = 0; k < 2; k++) {
    ck_assert_int_eq(dls_contact_certify(both[k], r, u[k], &c[k], NULL), DLS_OK);
    ck_assert_int_eq(dls_contact_states(both[k], r, u[k], state[k], NULL), DLS_OK);
  }
  const double size = norm_of(u[0], m);
  for (int k = 0; k < m; k++)
    ck_assert(fabs(u[0][k] - u[1][k]) <= 1e-14 * size);
  ck_assert_mem_eq(state[0], state[1], (size_t)nc * sizeof state[0][0]);
  ck_assert(fabs(c[0].residual - c[1].residual) <= 1e-12 * c[0].residual);
  ck_assert(c[1].floor_u >= c[0].floor_u * (1 - 1e-12)); /* |H|^T |H| |r| >= |W| |r| */
  dls_diagnosis g[2];
  dls_sensitivity s[2];
  for (int k = 0; k < 2; k++) {
    ck_assert_int_eq(dls_contact_diagnose(both[k], 100, &g[k], NULL), DLS_OK);
    ck_assert_int_eq(dls_contact_sensitivity(both[k], r, &s[k], NULL), DLS_OK);
  }
  ck_assert(g[0].rank == g[1].rank && g[1].asymmetry == 0);
  ck_assert(fabs(g[0].largest - g[1].largest) <= 1e-12 * g[0].largest);
  ck_assert(s[0].rank == s[1].rank && s[0].border == s[1].border);
  if (d > 2) return;
  static double M[2][9 * most * most], q[2][3 * most];
  const int n = dls_contact_lcp_size(&p);
  for (int k = 0; k < 2; k++)
    ck_assert_int_eq(dls_contact_to_lcp(both[k], NULL, M[k], n, q[k], NULL), DLS_OK);
  for (int k = 0; k < n * n; k++)
    ck_assert(fabs(M[0][k] - M[1][k]) <= 1e-13);
}

/* A subset keeps the storage, and is that of W dense. */
TEST_EACH(subset_of_bodies, 0, 3) {
  bodies_model(&a, &B, &p, 27 + _i);
  const int d = p.d, n = p.bodies.n;
  const int some[] = {0, 2, 3, 6}, count = 4;
  double values[2][2000], u[2][most], r[most];
  int index[8];
  dls_contact part[2];
  dls_certificate c;
  ck_assert_int_eq(dls_contact_subset(&a.p, count, some, values[0], NULL, &part[0], NULL), DLS_OK);
  memset(values[1], 0x55, sizeof values[1]);
  ck_assert_int_eq(dls_contact_subset(&p, count, some, values[1], index, &part[1], NULL), DLS_OK);
  ck_assert(part[1].bodies.H == values[1] && part[1].bodies.body == index && !part[1].W.a);
  ck_assert_ptr_eq(part[1].mu + count, values[1] + (2 * n * d + d + 1) * count);
  for (int k = 0; k < d * count; k++)
    r[k] = uniform();
  for (int k = 0; k < 2; k++)
    ck_assert_int_eq(dls_contact_certify(&part[k], r, u[k], &c, NULL), DLS_OK);
  for (int k = 0; k < d * count; k++)
    ck_assert(fabs(u[0][k] - u[1][k]) <= 1e-13);
  dls_error error;
  dls_contact out;
  const dls_status status = dls_contact_subset(&p, count, some, values[1], NULL, &out, &error);
  expect_error(status, &error, DLS_E_ARGUMENT, "dls_contact_subset", "index", -1);
}

/* The generator of the benchmarks forms W by blocks in another way. */
TEST_EACH(packing_by_another_way, 0, 3) {
  static const char *const kind[] = {"packing-flow", "wall-pushed", "tower"};
  rigid s;
  ck_assert_int_eq(rigid_create(&s, kind[_i], 400, .5, 3), 0);
  const int m = s.d * s.contact.nc;
  int count;
  double *r = calloc((size_t)m, sizeof *r), *u = calloc(2 * (size_t)m, sizeof *u);
  ck_assert(r && u);
  dls_certificate c[2];
  ck_assert_int_eq(dls_bodies_count(&s.factored, &count, NULL), DLS_OK);
  ck_assert_int_eq(count, s.p[s.contact.nc]);
  set_seed(4711);
  for (int k = 0; k < m; k++)
    r[k] = uniform();
  ck_assert_int_eq(dls_contact_certify(&s.contact, r, u, &c[0], NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_certify(&s.factored, r, u + m, &c[1], NULL), DLS_OK);
  const double size = norm_of(u, m);
  assert_near(u, u + m, m, 1e-14 * size);
  ck_assert(fabs(c[0].residual - c[1].residual) <= 1e-12 * c[0].residual);
  free(r);
  free(u);
  rigid_free(&s);
}

TEST(bad_input_and_no_memory) {
  int count = 5, start[most], row[most];
  double x[most * most], r[most] = {0};
  dls_blocks blocks = {.d = 7};
  dls_certificate c;
  dls_error error;
  bodies_model(&a, &B, &p, 8);
  REFUSES(ARGUMENT, "problem", -1, dls_bodies_count, NULL, &count);
  REFUSES(ARGUMENT, "bodies.H", -1, dls_bodies_count, &a.p, &count);
  REFUSES(ARGUMENT, "count", -1, dls_bodies_count, &p, NULL);
  const char *const slot[] = {"p", "i", "x", "B"};
  for (int k = 0; k < 4; k++)
    REFUSES(ARGUMENT, slot[k], -1, dls_blocks_from_bodies, &p, k == 0 ? NULL : start,
            k == 1 ? NULL : row, k == 2 ? NULL : x, k == 3 ? NULL : &blocks);
  REFUSES(ARGUMENT, "u", -1, dls_contact_certify, &p, r, B.H, &c);
  ck_assert(count == 5 && blocks.d == 7);
  MALLOCS_FAIL(dls_bodies_count(&p, &count, &error), count == 5, DLS_OK, 1);
  MALLOCS_FAIL(dls_blocks_from_bodies(&p, start, row, x, &blocks, &error), blocks.d == 7, DLS_OK,
               1);
  MALLOCS_FAIL(dls_contact_certify(&p, r, NULL, &c, &error), 1, DLS_OK, 1);
  dls_contact none = {.d = 2, .nc = 0};
  ck_assert_int_eq(dls_bodies_count(&none, &count, NULL), DLS_OK);
  ck_assert_int_eq(count, 0);
}

/* u = H^T H r and what rounds in it, |H|^T |H| |r|, of two candidates that share a body; the other
 * body of the second one is fixed. */
TEST(products_by_hand) {
  const int body[4] = {0, 1, 1, -1};
  const double H[24] = {1, -2, 0, 0, 1, 3, -1, 2, 0, 0, -1, 2, 4, 0, -1, 1, 1, 0};
  const double r[4] = {2, -1, 1, -3}, q[4] = {0}, mu[2] = {0};
  double room[12], u[4], rounds[4];
  const dls_contact problem = {.d = 2, .nc = 2, .q = q, .mu = mu, .bodies = {3, 2, body, H, room}};
  dlsi_contact_multiply(&problem, NULL, r, u, rounds);
  /* H r: body 0 (2, -5, -3), body 1 (-2 + 1, 5 - 3, -2 - 1); |H| |r|: (2, 5, 3), (9, 8, 3) */
  const double v[2][3] = {{2, -5, -3}, {-1, 2, -3}}, w[2][3] = {{2, 5, 3}, {9, 8, 3}};
  for (int i = 0; i < 4; i++) {
    double sum = 0, size = 0;
    for (int k = 0; k < 2; k++)
      for (int l = 0; l < 3; l++) {
        const int side = 2 * (i / 2) + k;
        const double h = body[side] < 0 ? 0 : H[6 * side + 3 * (i % 2) + l];
        sum += h * v[body[side] < 0 ? 0 : body[side]][l];
        size += fabs(h) * w[body[side] < 0 ? 0 : body[side]][l];
      }
    ck_assert(u[i] == sum && rounds[i] == size);
  }
}

/* Finite numbers whose squares are none; and no candidate at all. */
TEST(overflow_and_nothing) {
  const int two[2] = {0, 1}, fixed[2] = {0, -1};
  double H[12] = {1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 1e160}, q[2] = {-1, 0}, mu = 0.5, r[32] = {0};
  dls_contact problem = {.d = 2, .nc = 1, .q = q, .mu = &mu, .bodies = {3, 2, two, H, NULL}};
  dls_certificate c;
  dls_solution_set found;
  dls_error error;
  REFUSES(NOT_FINITE, "bodies.H", 0, dls_contact_certify, &problem, r, NULL, &c);
  problem.bodies.body = fixed; /* of a fixed body H is not read */
  ck_assert_int_eq(dls_contact_certify(&problem, r, NULL, &c, &error), DLS_OK);
  problem.nc = 0;
  ck_assert_int_eq(dls_contact_certify(&problem, r, NULL, &c, &error), DLS_OK);
  ck_assert_int_eq(dls_contact_enumerate(&problem, 1e-8, 4, r, NULL, NULL, &found, &error), DLS_OK);
  ck_assert(found.isolated == 1 && found.continua == 0);
  dls_derive *derive;
  const dls_derive_data none = {0};
  const dls_derive_answer moved = {.r = r};
  ck_assert_int_eq(dls_derive_create(&derive, &problem, r, -1, &error), DLS_OK);
  ck_assert_int_eq(dls_derive_jvp(derive, &none, &moved, &error), DLS_OK);
  dls_derive_destroy(derive);
}
