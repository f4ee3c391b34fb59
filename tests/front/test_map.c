/* test_map.c: dls_solver_map: contacts that appear, vanish and change their places. */
#include "delassus.h"
#include "front_cases.h"
#include "half_space.h"
#include "made.h"
#include "rigid.h"
#include "run.h"

static dls_solver *warm_solver(dls_method method, int d, int nc, double tol, int blocks) {
  dls_solver_settings s = settings_of(method);
  s.limits.tol = tol;
  s.limits.warm_start = 1;
  s.limits.blocks = blocks;
  dls_solver *solver = solver_of(d, nc, &s);
  return solver;
}

/* ---- arguments ------------------------------------------------------------------------------- */

enum { NC = 12, M = 2 * NC };

static double W[M * M], q[M], mu[NC];

static void refused(dls_solver *solver, int nc, const int *from, double *r, dls_status status,
                    const char *argument, long index) {
  dls_error e = {0};
  ck_assert_int_eq(dls_solver_map(solver, nc, from, r, &e), status);
  ck_assert_int_eq(e.status, status);
  ck_assert_str_eq(e.function, "dls_solver_map");
  ck_assert_str_eq(e.argument, argument);
  ck_assert_int_eq(e.index, index);
  for (int k = 0; r && k < M; k++)
    ck_assert_double_eq(r[k], 7);
}

/* Each bad argument has its error, and r and the solver stay as they are. */
TEST(bad_arguments) {
  double r[M], old[M] = {0};
  int from[NC + 1];
  const dls_contact p = coupled(W, q, mu, 2, NC, 0.5, 0.3, 1);
  dls_solver *solver = warm_solver(DLS_AUTO, 2, NC, 1e-10, 0);
  for (int c = 0; c <= NC; c++)
    from[c] = -1;
  for (int k = 0; k < M; k++)
    r[k] = 7;
  from[2] = 0;
  refused(solver, NC, from, r, DLS_E_ARGUMENT, "from", 2); /* there was no solve */
  ck_assert_int_eq(dls_solver_solve(solver, &p, old, NULL, NULL, NULL), DLS_OK);
  refused(NULL, NC, from, r, DLS_E_ARGUMENT, "solver", -1);
  refused(solver, NC, NULL, r, DLS_E_ARGUMENT, "from", -1);
  refused(solver, NC, from, NULL, DLS_E_ARGUMENT, "r", -1);
  refused(solver, -1, from, r, DLS_E_SIZE, "nc", -1);
  refused(solver, NC + 1, from, r, DLS_E_SIZE, "nc", -1);
  from[5] = NC;
  refused(solver, NC, from, r, DLS_E_ARGUMENT, "from", 5);
  from[5] = -2;
  refused(solver, NC, from, r, DLS_E_ARGUMENT, "from", 5);
  from[5] = 0;
  refused(solver, NC, from, r, DLS_E_ARGUMENT, "from", 5); /* as from[2] */
  from[5] = 1;
  ck_assert_int_eq(dls_solver_map(solver, NC, from, r, NULL), DLS_OK);
  for (int k = 0; k < M; k++)
    ck_assert_double_eq(r[k], k / 2 == 2 ? old[k % 2] : k / 2 == 5 ? old[2 + k % 2] : 0);
  ck_assert_int_eq(dls_solver_map(solver, 0, NULL, NULL, NULL), DLS_OK);
  dls_solver_destroy(solver);
}

/* A solve that is refused leaves the last answer, and a map of another number of contacts is no
 * map: the bits are those of a solver that was never told. */
TEST(maps_that_are_not_used) {
  double r[2][M] = {{0}}, kept[M], bad[M];
  int from[NC];
  const dls_contact p = coupled(W, q, mu, 2, NC, 0.5, 0.3, 2);
  dls_contact wrong = p;
  dls_solver *solver[2];
  for (int k = 0; k < 2; k++) {
    solver[k] = warm_solver(DLS_AUTO, 2, NC, 1e-10, 0);
    ck_assert_int_eq(dls_solver_solve(solver[k], &p, r[k], NULL, NULL, NULL), DLS_OK);
  }
  for (int c = 0; c < NC; c++)
    from[c] = NC - 1 - c;
  memcpy(bad, q, sizeof bad);
  bad[3] = NAN;
  wrong.q = bad;
  ck_assert_int_eq(dls_solver_solve(solver[0], &wrong, kept, NULL, NULL, NULL), DLS_E_NOT_FINITE);
  ck_assert_int_eq(dls_solver_map(solver[0], NC - 1, from, kept, NULL), DLS_OK);
  for (int k = 0; k < M - 2; k++)
    ck_assert_double_eq(kept[k], r[0][M - 2 - 2 * (k / 2) + k % 2]);
  for (int k = 0; k < M; k++)
    q[k] *= 1 + 0.01 * k;
  for (int k = 0; k < 2; k++)
    ck_assert_int_eq(dls_solver_solve(solver[k], &p, r[k], NULL, NULL, NULL), DLS_OK);
  ck_assert_mem_eq(r[0], r[1], sizeof r[0]);
  dls_solver_destroy(solver[0]);
  dls_solver_destroy(solver[1]);
}

/* Each method takes a map, and solves what it solves without. */
TEST(each_method) {
  double r[M] = {0}, s[M] = {0};
  int from[NC];
  for (int c = 0; c < NC; c++)
    from[c] = c == 4 ? -1 : (c + 5) % NC;
  for (int k = 0; dls_method_name((dls_method)k); k++) {
    if (k == DLS_PENALTY) continue;
    const dls_contact p = coupled(W, q, mu, 2, NC, 0.5, 0.3, 3);
    dls_solver *solver = warm_solver((dls_method)k, 2, NC, 1e-10, 0);
    ck_assert_int_eq(dls_solver_solve(solver, &p, r, NULL, NULL, NULL), DLS_OK);
    memcpy(s, r, sizeof s);
    for (int turn = 0; turn < 3; turn++) {
      ck_assert_int_eq(dls_solver_map(solver, NC, from, r, NULL), DLS_OK);
      ck_assert_int_eq(dls_solver_solve(solver, &p, r, NULL, NULL, NULL), DLS_OK);
      assert_close(r, s, M, 1e-6);
    }
    dls_solver_destroy(solver);
  }
}

/* ---- many rigid bodies ----------------------------------------------------------------------- */

/* Some contacts of a packing in an order of their own. */
typedef struct shuffled {
  rigid all;
  int *place, *body; /* its contact c is place[c] of the packing */
  double *H, *q, *mu, *r;
  dls_contact p;
} shuffled;

static void shuffled_create(shuffled *a, const char *kind, int contacts, uint64_t seed) {
  ck_assert_int_eq(rigid_create(&a->all, kind, contacts, 0.5, seed), 0);
  const size_t nc = (size_t)a->all.contact.nc;
  a->place = calloc(3 * nc, sizeof *a->place);
  a->H = calloc((36 + 3 + 1 + 3) * nc, sizeof *a->H);
  ck_assert(a->place && a->H && a->all.d == 3);
  a->body = a->place + nc;
  a->q = a->H + 36 * nc;
  a->mu = a->q + 3 * nc;
  a->r = a->mu + nc;
}

static void shuffled_free(shuffled *a) {
  rigid_free(&a->all);
  free(a->place);
  free(a->H);
}

/* Takes the contacts of the packing in steps of `stride` through them, but not each fiftieth from
 * leave_out on (-1: all), and changes the velocities of the bodies by the fraction `load`. */
static void shuffled_set(shuffled *a, int stride, int leave_out, double load) {
  const int all = a->all.contact.nc;
  int nc = 0;
  for (int k = 0; k < all; k++) {
    const int c = (int)((long long)k * stride % all);
    if (leave_out >= 0 && c % 50 == leave_out) continue;
    a->place[nc] = c;
    memcpy(a->body + 2 * nc, a->all.body + 2 * c, 2 * sizeof *a->body);
    memcpy(a->H + (size_t)36 * (size_t)nc, a->all.H + (size_t)36 * (size_t)c, 36 * sizeof *a->H);
    for (int i = 0; i < 3; i++) { /* H^T v of other velocities: bounds of bodies can be met */
      double sum = 0;
      for (int e = 0; e < 12; e++) {
        const int b = a->body[2 * nc + e / 6], j = 6 * b + e % 6;
        const double *H = a->H + 36 * (size_t)nc + 18 * (size_t)(e / 6);
        if (b >= 0) sum += H[e % 6 + 6 * i] * a->all.v[j] * (1 + load * sin(j));
      }
      a->q[3 * nc + i] = sum;
    }
    a->mu[nc] = a->all.mu[c];
    nc++;
  }
  a->p = (dls_contact){.d = 3, .nc = nc, .q = a->q, .mu = a->mu};
  a->p.bodies = (dls_bodies){6, a->all.bodies, a->body, a->H, NULL};
}

static int coprime(int stride, int n) {
  while (n) {
    const int rest = stride % n;
    stride = n;
    n = rest;
  }
  return stride == 1;
}

/* Solves a packing, and then three times a changed one with its contacts in another order each
 * time. Returns the sweeps of these. told: whether the solver gets the map, or r alone. */
static int sweeps_of_orders(shuffled *a, dls_method method, int shuffle, int told) {
  const int nc = a->all.contact.nc;
  dls_solver *solver = warm_solver(method, 3, nc, 1e-6, a->all.contact.Wb.p[nc]);
  int *from = calloc(2 * (size_t)nc, sizeof *from), *at = from + nc, sweeps = 0, stride = 1;
  double *r = calloc(3 * (size_t)nc, sizeof *r);
  ck_assert(from && r);
  for (int turn = 0; turn < 4; turn++) {
    for (int c = 0; c < nc; c++)
      at[turn ? a->place[c] : c] = c;
    stride += 37 * shuffle;
    while (!coprime(stride, nc))
      stride++;
    shuffled_set(a, stride, -1, 0.03 * turn);
    for (int c = 0; c < nc; c++)
      from[c] = turn ? at[a->place[c]] : -1;
    ck_assert_int_eq(dls_solver_map(solver, nc, from, r, NULL), DLS_OK);
    for (int c = 0; c < nc; c++)
      from[c] = -1;
    if (!told) ck_assert_int_eq(dls_solver_map(solver, 0, from, NULL, NULL), DLS_OK);
    dls_info info;
    ck_assert_int_eq(dls_solver_solve(solver, &a->p, r, NULL, &info, NULL), DLS_OK);
    const dls_certificate now = certificate_of(&a->p, r);
    ck_assert(dls_certificate_holds(&now, 1e-6));
    sweeps += turn ? info.iterations : 0;
  }
  dls_solver_destroy(solver);
  free(from);
  free(r);
  return sweeps;
}

/* Contacts in another order each time cost what they cost as they were numbered first. */
TEST_EACH(other_orders_cost_the_same, 0, 2) {
  static const dls_method methods[] = {DLS_AUTO, DLS_NLGS};
  shuffled a;
  shuffled_create(&a, "packing-flow", 1500, 2);
  const int numbered = sweeps_of_orders(&a, methods[_i], 0, 1);
  const int mapped = sweeps_of_orders(&a, methods[_i], 1, 1);
  ck_assert_int_ge(numbered, 20);
  ck_assert_int_le(abs(mapped - numbered), numbered / 10); /* untold they take a fifth more */
  shuffled_free(&a);
}

/* Contacts come and go, in an order of their own each time: every answer is certified, and all of
 * it gives the same bits again, on two threads those of three. */
TEST(contacts_come_and_go) {
  shuffled a;
  shuffled_create(&a, "balls-flow", 1200, 4);
  const int all = a.all.contact.nc;
  double *r[4];
  for (int k = 0; k < 4; k++)
    ck_assert_ptr_nonnull(r[k] = calloc(3 * (size_t)all, sizeof *r[k]));
  int *from = calloc(2 * (size_t)all, sizeof *from), *at = from + all;
  ck_assert_ptr_nonnull(from);
  for (int again = 0; again < 4; again++) {
    dls_solver *solver = warm_solver(DLS_AUTO, 3, all, 1e-4, a.all.contact.Wb.p[all]);
    const dls_limits limits = {.tol = 1e-4, .warm_start = 1, .threads = again > 1 ? again : 1};
    ck_assert_int_eq(dls_solver_set_limits(solver, &limits, NULL), DLS_OK);
    int kept = 0;
    for (int turn = 0; turn < 6; turn++) {
      for (int c = 0; c < all; c++)
        at[c] = -1;
      for (int c = 0; turn && c < a.p.nc; c++)
        at[a.place[c]] = c;
      int stride = 1 + 13 * (turn % 3);
      while (!coprime(stride, all))
        stride++;
      shuffled_set(&a, stride, turn % 4 * 7, 0.02 * turn);
      for (int c = 0; c < a.p.nc; c++) {
        from[c] = at[a.place[c]];
        kept += from[c] >= 0;
      }
      ck_assert_int_eq(dls_solver_map(solver, a.p.nc, from, r[again], NULL), DLS_OK);
      ck_assert_int_eq(dls_solver_solve(solver, &a.p, r[again], NULL, NULL, NULL), DLS_OK);
      const dls_certificate now = certificate_of(&a.p, r[again]);
      ck_assert(dls_certificate_holds(&now, 1e-4));
    }
    ck_assert_int_gt(kept, 4 * all);
    dls_solver_destroy(solver);
  }
  ck_assert_mem_eq(r[0], r[1], 3 * (size_t)a.p.nc * sizeof *r[0]);
  ck_assert_mem_eq(r[2], r[3], 3 * (size_t)a.p.nc * sizeof *r[0]);
  for (int k = 0; k < 4; k++)
    free(r[k]);
  free(from);
  shuffled_free(&a);
}

/* ---- an elastic body ------------------------------------------------------------------------- */

enum { LINE = 60, ROWS = 2 * LINE, STEPS = 20 };

/* Walks a load path on which open contacts at both ends leave the problem in every other step, or
 * (turns) all contacts are numbered from the other end. Returns the factorisations of the steps. */
static int factorisations_of_path(int turns, int told) {
  static double V[ROWS * ROWS], g0[ROWS], friction[LINE], g[ROWS], values[ROWS * ROWS + 3 * LINE];
  static double turned[ROWS * ROWS];
  dls_contact p = half_plane(V, g0, friction, LINE, 3, 0, .5, .3);
  dls_solver *solver = warm_solver(DLS_AUTO, 2, LINE, 1e-10, 0);
  int made = 0, was[LINE], count_was = 0;
  for (int k = 0; k < STEPS; k++) {
    const double t = 0.2 * k / STEPS;
    int list[LINE], from[LINE], count = 0;
    for (int c = 0; c < LINE; c++) {
      g[2 * c] = g0[2 * c] - .2 * t;
      g[2 * c + 1] = .1 * t * t;
      if (turns || k % 2 == 0 || (c > 3 && c < LINE - 3)) list[count++] = c;
    }
    dls_contact some = p;
    p.q = g;
    ck_assert_int_eq(dls_contact_subset(&p, count, list, values, NULL, &some, NULL), DLS_OK);
    if (turns && k % 2) { /* the same problem from its end to its beginning */
      double *const gap = values + ROWS * ROWS;
      for (int c = 0; c < LINE; c++) {
        list[c] = LINE - 1 - c;
        memcpy(gap + 2 * c, g + 2 * list[c], 2 * sizeof *g);
      }
      for (int i = 0; i < ROWS; i++)
        for (int j = 0; j < ROWS; j++)
          turned[i + ROWS * j] = V[2 * list[i / 2] + i % 2 + ROWS * (2 * list[j / 2] + j % 2)];
      some.W.a = turned;
      some.q = gap;
    }
    for (int c = 0; c < count; c++) {
      from[c] = -1;
      for (int e = 0; e < count_was; e++)
        if (was[e] == list[c]) from[c] = e;
    }
    double r[ROWS];
    dls_info info;
    ck_assert_int_eq(dls_solver_map(solver, count, from, r, NULL), DLS_OK);
    if (!told) ck_assert_int_eq(dls_solver_map(solver, 0, NULL, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_solver_solve(solver, &some, r, NULL, &info, NULL), DLS_OK);
    const dls_certificate now = certificate_of(&some, r);
    ck_assert(dls_certificate_holds(&now, 1e-10));
    made += info.factorisations;
    memcpy(was, list, sizeof was);
    count_was = count;
  }
  dls_solver_destroy(solver);
  return made;
}

/* Of a packing two contacts in three are lifted after the first solve: sweeps with momentum over
 * those that act, of a solve that knows them again, find the answer of a cold one. */
TEST_EACH(sweeps_over_what_acts, 0, 2) {
  rigid a;
  ck_assert_int_eq(rigid_create(&a, "packing-rest", 700, 0.3, 5), 0);
  dls_contact p = _i ? a.factored : a.contact;
  const int nc = p.nc, m = 3 * nc;
  double *r = calloc((size_t)(3 * m), sizeof *r), *s = r + m, *lifted = s + m, size = 0, off = 0;
  int *from = calloc((size_t)nc, sizeof *from);
  dls_info info;
  dls_solver_settings settings = settings_with(DLS_NLGS, 1e-8);
  settings.acceleration = DLS_ACCELERATION_MOMENTUM;
  settings.limits.blocks = _i ? 0 : p.Wb.p[nc];
  settings.limits.warm_start = 1;
  settings.limits.max_iterations = 20000;
  dls_solver *warm = solver_of(3, nc, &settings), *cold = solver_of(3, nc, &settings);
  ck_assert_int_ge(nc, 500);
  ck_assert_int_ge(dls_solver_solve(warm, &p, r, NULL, NULL, NULL), 0);
  for (int c = 0; c < nc; c++) {
    from[c] = c;
    lifted[3 * c] = p.q[3 * c] + (c % 3 ? 10 : 0);
    lifted[3 * c + 1] = p.q[3 * c + 1];
    lifted[3 * c + 2] = p.q[3 * c + 2];
  }
  p.q = lifted;
  ck_assert_int_eq(dls_solver_map(warm, nc, from, r, NULL), DLS_OK);
  for (int c = 0; c < nc; c++)
    for (int k = 0; k < 3 && c % 3; k++)
      r[3 * c + k] = 0;
  ck_assert_int_eq(dls_solver_solve(warm, &p, r, NULL, &info, NULL), DLS_OK);
  ck_assert(dls_certificate_holds(&info.certificate, 1e-8));
  ck_assert_int_eq(dls_solver_solve(cold, &p, s, NULL, &info, NULL), DLS_OK);
  for (int k = 0; k < m; k++) {
    off = fmax(off, fabs(r[k] - s[k]));
    size = fmax(size, fabs(s[k]));
  }
  ck_assert_msg(off <= 1e-5 * size, "%g of %g", off, size);
  dls_solver_destroy(warm);
  dls_solver_destroy(cold);
  free(from);
  free(r);
  rigid_free(&a);
}

/* Where only open contacts come and go, Newton's factors stay, which without a map are lost. Where
 * contacts change their places, they are lost, and no answer is wrong. */
TEST(factors_stay) {
  const int told = factorisations_of_path(0, 1), untold = factorisations_of_path(0, 0);
  ck_assert_int_le(4 * told, untold); /* 2, 19 */
  ck_assert_int_gt(factorisations_of_path(1, 1), 0);
}
