/* test_slabs.c: slabs (vi/sweep/slabs.c), and sweeps on several threads. */
#include "cases.h"
#include "delassus.h"
#include "made.h"
#include "rigid.h"
#include "run.h"
#include "vi/vi_internal.h"

static rigid s;

static void slabs_make(const char *kind, int candidates, uint64_t number) {
  ck_assert_int_eq(rigid_create(&s, kind, candidates, .5, number), 0);
}

/* Each candidate stands in one slab; no row of u, or no body, is changed by two slabs of a
 * parity. */
TEST_EACH(slabs_of_a_parity_share_nothing, 0, 8) {
  static const char *const kind[] = {"packing-flow", "wall-rest", "chain", "tower"};
  slabs_make(kind[_i / 2], 1500, 3);
  const dls_contact *p = _i % 2 ? &s.factored : &s.contact;
  const int rows = _i % 2 ? s.bodies : p->nc;
  dlsi_slabs slabs = {.memory = NULL};
  ck_assert_int_eq(dlsi_slabs_set(&slabs, p, NULL), DLS_OK);
  int *owner = malloc(2 * (size_t)rows * sizeof *owner),
      *seen = calloc((size_t)p->nc, sizeof *seen);
  ck_assert(owner && seen);
  for (int k = 0; k < 2 * rows; k++)
    owner[k] = -1;
  ck_assert_int_gt(slabs.set.slabs, 3);
  ck_assert_int_eq(slabs.set.start[slabs.set.slabs], p->nc);
  for (int k = 0; k < slabs.set.slabs; k++)
    for (int at = slabs.set.start[k]; at < slabs.set.start[k + 1]; at++) {
      const int c = slabs.set.list[at], first = _i % 2 ? 2 * c : p->Wb.p[c];
      const int end = _i % 2 ? 2 * c + 2 : p->Wb.p[c + 1];
      ck_assert_int_eq(seen[c]++, 0);
      for (int e = first; e < end; e++) {
        const int row = _i % 2 ? p->bodies.body[e] : p->Wb.i[e];
        if (row < 0) continue;
        int *of = &owner[2 * row + k % 2];
        ck_assert(*of < 0 || *of == k);
        *of = k;
      }
    }
  free(owner);
  free(seen);
  dlsi_slabs_free(&slabs);
  rigid_free(&s);
}

/* A loop goes in pieces of 512 or more, at most 64. */
TEST(pieces_of_a_loop) {
  static const int cases[][2] = {{1023, 1},   {1024, 2},   {1535, 2},  {1536, 3},
                                 {32767, 63}, {32768, 64}, {33280, 64}};
  for (int k = 0; k < 7; k++)
    ck_assert_int_eq(dlsi_pieces(cases[k][0]), cases[k][1]);
  ck_assert_int_eq(dlsi_piece(10, 3, 0), 0);
  ck_assert_int_eq(dlsi_piece(10, 3, 1), 3);
  ck_assert_int_eq(dlsi_piece(10, 3, 2), 6);
  ck_assert_int_eq(dlsi_piece(10, 3, 3), 10);
}

enum { chain_most = 140 };

/* A chain, candidate c coupled with c - 1 and c + 1 but for a gap before candidate `gap`; 0: none.
 * By blocks, or candidate c between the bodies c - 1 and c. */
static dls_contact slabs_chain(int nc, int gap, int of_bodies) {
  static int p[chain_most + 1], i[3 * chain_most], body[2 * chain_most];
  static double x[3 * chain_most], q[chain_most], mu[chain_most], H[6 * chain_most];
  int count = 0;
  for (int c = 0; c < nc; c++) {
    p[c] = count;
    for (int b = c - 1; b <= c + 1; b++)
      if (b >= 0 && b < nc && (b <= c || b != gap) && (b >= c || c != gap)) i[count++] = b;
    body[2 * c] = c == gap ? -1 : c - 1;
    body[2 * c + 1] = c;
  }
  p[nc] = count;
  if (!of_bodies) return (dls_contact){.d = 1, .nc = nc, .Wb = {1, nc, p, i, x}, .q = q, .mu = mu};
  return (dls_contact){.d = 1, .nc = nc, .q = q, .mu = mu, .bodies = {3, nc, body, H, NULL}};
}

/* Slabs of a chain of 130 begin at its far end, 129. By blocks a level is what shares a row with
 * the one before: 129; 128, 127; 126, 125; .. A slab ends with the level that makes it 64: 1 + 2 *
 * 32 candidates, 2 * 32, and 0. Between bodies each level is one candidate. A chain of 70 and
 * another of 70: the second slab holds what is left of the first, 4 .. 0, and 139 .. 81. */
TEST(slabs_of_chains) {
  static const struct {
    int nc, gap, of_bodies, start[4];
    int range[4][2]; /* of candidates, ascending, one after the other */
  } cases[] = {
      {130, 0, 0, {0, 65, 129, 130}, {{65, 129}, {1, 64}, {0, 0}, {1, 0}}},
      {130, 0, 1, {0, 64, 128, 130}, {{66, 129}, {2, 65}, {0, 1}, {1, 0}}},
      {140, 70, 0, {0, 65, 129, 140}, {{5, 69}, {0, 4}, {81, 139}, {70, 80}}},
      {140, 70, 1, {0, 64, 128, 140}, {{6, 69}, {0, 5}, {82, 139}, {70, 81}}},
      {70, 64, 1, {0, 64, 70}, {{0, 63}, {64, 69}, {1, 0}, {1, 0}}},
      {70, 1, 1, {0, 64, 70}, {{0, 0}, {7, 69}, {1, 6}, {1, 0}}}, /* 0 stands alone */
      {64, 0, 1, {0, 64}, {{0, 63}, {1, 0}, {1, 0}, {1, 0}}},
      {1, 0, 0, {0, 1}, {{0, 0}, {1, 0}, {1, 0}, {1, 0}}},
  };
  dlsi_slabs slabs = {.memory = NULL};
  for (int k = 0; k < 8; k++) {
    const int nc = cases[k].nc, count = k < 4 ? 3 : k < 6 ? 2 : 1;
    const dls_contact p = slabs_chain(nc, cases[k].gap, cases[k].of_bodies);
    ck_assert_int_eq(dlsi_slabs_set(&slabs, &p, NULL), DLS_OK);
    ck_assert(slabs.set.slabs == count && slabs.set.count == nc);
    ck_assert_mem_eq(slabs.set.start, cases[k].start, (size_t)(count + 1) * sizeof(int));
    const int *list = slabs.set.list;
    for (int part = 0; part < 4; part++)
      for (int c = cases[k].range[part][0]; c <= cases[k].range[part][1]; c++)
        ck_assert_int_eq(*list++, c);
    ck_assert_ptr_eq(list, slabs.set.list + nc);
  }
  dlsi_slabs_free(&slabs);
}

/* Solves with so many threads; r is the caller's, m. */
static dls_info solve_with(const dls_contact *p, int threads, dls_acceleration acceleration,
                           dls_method method, double *r) {
  dls_info info;
  dls_solver_settings settings = settings_with(DLS_AUTO, default_tol);
  ck_assert_int_eq(settings.limits.threads, 1);
  settings.limits.threads = threads;
  settings.limits.tol = 1e-3;
  settings.limits.max_iterations = 2000;
  settings.method = method;
  settings.acceleration = acceleration;
  ck_assert_int_eq(dls_solve(p, &settings, r, NULL, &info, NULL), DLS_OK);
  ck_assert_double_le(info.certificate.residual, 1e-3);
  return info;
}

/* One, two, three and seven threads give the same bits, plain and with momentum, by blocks and of
 * bodies, with slabs and, below 4,000 contacts, without. */
TEST_EACH(bits_do_not_depend_on_threads, 0, 12) {
  slabs_make("packing-flow", _i < 6 ? 6000 : 1200, 3);
  const dls_contact *p = _i % 2 ? &s.factored : &s.contact;
  const int kind = _i / 2 % 3;
  const dls_method method = kind == 2 ? DLS_AUTO : DLS_NLGS;
  const dls_acceleration acceleration =
      kind == 1 ? DLS_ACCELERATION_MOMENTUM : DLS_ACCELERATION_NONE;
  const size_t m = (size_t)(s.d * p->nc);
  double *r = malloc(2 * m * sizeof *r);
  ck_assert_ptr_nonnull(r);
  ck_assert((p->nc >= 4000) == (_i < 6));
  const dls_info one = solve_with(p, 1, acceleration, method, r);
  for (int threads = 2; threads <= 7; threads += threads) {
    const dls_info many = solve_with(p, threads - (threads > 3), acceleration, method, r + m);
    ck_assert_mem_eq(r, r + m, (size_t)m * sizeof *r);
    ck_assert_int_eq(one.iterations, many.iterations);
  }
  free(r);
  rigid_free(&s);
}

/* A dense W beyond the cache: the bits of one thread. */
TEST(dense_on_threads) {
  enum { nc = 700, m = 3 * nc };
  double *W = calloc((size_t)m * (size_t)m, sizeof *W);
  double *q = malloc(3 * sizeof *q * (size_t)m), *r = q + m;
  static double mu[nc];
  ck_assert(W && q);
  set_seed(20011);
  for (int k = 0; k < m; k++) {
    q[k] = uniform() - (k % 3 == 0 ? 1 : 0);
    mu[k / 3] = .3;
    for (int j = 0; j < m; j++)
      W[(size_t)k + (size_t)m * (size_t)j] = (k == j ? 1 : .2) / (1 + (k > j ? k - j : j - k));
  }
  const dls_contact p = {.d = 3, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
  (void)solve_with(&p, 1, DLS_ACCELERATION_NONE, DLS_NLGS, r);
  (void)solve_with(&p, 3, DLS_ACCELERATION_NONE, DLS_NLGS, r + m);
  ck_assert_mem_eq(r, r + m, (size_t)m * sizeof *r);
  free(W);
  free(q);
}

/* From 1000 candidates on sweeps on bodies look every 5: what they say holds, and they keep to the
 * limit and to a callback. */
TEST(bodies_stop_in_time) {
  slabs_make("packing-rest", 2400, 3);
  const dls_contact *p = &s.factored;
  double *r = malloc((size_t)(s.d * p->nc) * sizeof *r);
  ck_assert_ptr_nonnull(r);
  for (int most_sweeps = 1; most_sweeps <= 13; most_sweeps += 3) {
    dls_nlgs_settings settings = {.size = 0};
    dls_nlgs_settings_init(&settings);
    settings.limits.max_iterations = most_sweeps;
    settings.acceleration = most_sweeps % 2 ? DLS_ACCELERATION_NONE : DLS_ACCELERATION_MOMENTUM;
    dls_nlgs *work;
    dls_info info;
    ck_assert_int_eq(dls_nlgs_create(&work, s.d, p->nc, &settings, NULL), DLS_OK);
    ck_assert_int_eq(dls_nlgs_solve(work, p, r, NULL, &info, NULL), DLS_MAX_ITERATIONS);
    ck_assert_int_eq(info.iterations, most_sweeps);
    const dls_certificate c = certificate_of(p, r);
    ck_assert(c.residual == info.certificate.residual && c.residual < 1);
    dls_nlgs_destroy(work);
  }
  watch w = {NULL, 0, 1e300, 0, 2};
  dls_info info;
  dls_solver_settings settings = settings_with(DLS_NLGS, default_tol);
  settings.limits.progress = look;
  settings.limits.progress_data = &w;
  ck_assert_int_eq(dls_solve(p, &settings, r, NULL, &info, NULL), DLS_CANCELLED);
  ck_assert_int_eq(info.iterations, 10);
  free(r);
  rigid_free(&s);
}

/* Auto solves a packing at rest to 1e-8, where sweeps on the factors are not its last stage; and
 * what all candidates of one body leave of W is refused by those that form it, and swept. */
TEST(bodies_beyond_sweeps) {
  slabs_make("wall-pushed", TEST_SMALL ? 600 : 1300, 3);
  double *r = malloc((size_t)(s.d * s.contact.nc) * sizeof *r);
  dls_info info;
  ck_assert_ptr_nonnull(r);
  dls_solver_settings settings = settings_with(DLS_AUTO, default_tol);
  ck_assert_int_eq(dls_solve(&s.factored, &settings, r, NULL, &info, NULL), DLS_OK);
  ck_assert(info.stages > 1 && info.factorisations > 0);
  free(r);
  rigid_free(&s);

  enum { nc = 50000 };
  int *body = malloc(2 * nc * sizeof *body), count = 7;
  double *H = calloc(12 * nc, sizeof *H), *q = calloc(2 * nc, sizeof *q);
  double *mu = calloc(nc, sizeof *mu), *x = calloc(2 * nc, sizeof *x);
  ck_assert(body && H && q && mu && x);
  for (int c = 0; c < nc; c++) { /* masses on a body that is as heavy as all of them */
    body[2 * c] = c + 1;
    body[2 * c + 1] = 0;
    H[12 * c] = H[12 * c + 4] = 1;
    H[12 * c + 6] = H[12 * c + 10] = -1 / sqrt((double)nc);
    q[2 * c] = c % 3 ? -1 : 1;
    q[2 * c + 1] = .5;
    mu[c] = .3;
  }
  const dls_contact hub = {
      .d = 2, .nc = nc, .q = q, .mu = mu, .bodies = {3, nc + 1, body, H, NULL}};
  dls_error error;
  ck_assert_int_eq(dls_bodies_count(&hub, &count, &error), DLS_E_SIZE);
  ck_assert(count == 7 && strcmp(error.argument, "bodies") == 0);
  settings.method = DLS_NEWTON;
  ck_assert_int_eq(dls_solve(&hub, &settings, x, NULL, NULL, NULL), DLS_E_SIZE);
  settings.limits.tol = 1e-3;
  for (int k = 0; k < 2; k++) {
    settings.method = k ? DLS_AUTO : DLS_NLGS;
    ck_assert_int_eq(dls_solve(&hub, &settings, x, NULL, &info, NULL), DLS_OK);
    ck_assert_double_le(info.certificate.residual, 1e-3);
  }
  free(body);
  free(H);
  free(q);
  free(mu);
  free(x);
}

/* Each malloc of a first solve with threads and momentum may fail. */
TEST_EACH(memory_of_threads, 0, 2) {
  slabs_make("packing-flow", 6000, 3);
  const dls_contact *p = _i ? &s.factored : &s.contact;
  double *r = calloc((size_t)(s.d * p->nc), sizeof *r);
  dls_solver_settings settings = settings_with(DLS_NLGS, default_tol);
  settings.acceleration = DLS_ACCELERATION_MOMENTUM;
  settings.limits.threads = 2;
  settings.limits.max_iterations = 1;
  MALLOCS_FAIL(dls_solve(p, &settings, r, NULL, NULL, NULL), r[0] == 0, DLS_MAX_ITERATIONS, 3);
  settings.limits.threads = -1;
  REFUSES(ARGUMENT, "threads", -1, dls_solve, p, &settings, r, NULL, NULL);
  free(r);
  rigid_free(&s);
}
