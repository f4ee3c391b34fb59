/*
 * test_move.c: contact that moves on a body that stays (dls_reduction_move). The reference is
 * another reduction, created with the new contacts: the same W, q, answer and certificate. K is
 * neither read nor factorised again.
 */
#include "delassus/solve.h"
#include "made.h"
#include "run.h"
#include "solids.h"

enum { wide = 6, high = 5, line = wide + 1, nodes = line * line * (high + 1), n = 3 * nodes };

static solids S;
static double dense[n * n];
static double loads[n];
static int counted; /* solves of the host */

/* A cube of 6 x 6 x 5 elements, clamped at its bottom, with loads at its top. */
static void cube_setup(void) {
  solids_new(&S, 3, nodes, 0);
  const int first = solids_block(&S, (int[]){wide, wide, high}, 1);
  for (int k = 0; k < line * line; k++)
    for (int i = 0; i < 3; i++) {
      solids_spring(&S, first + k, i, 100);
      loads[3 * (first + k + line * line * high) + i] = i == 2 ? -0.01 : 0.002;
    }
}

static void cube_teardown(void) {
  solids_free(&S);
}

/* Contacts of `count` points on the top, each between a node and the next one, from `from` on. */
typedef struct contacts {
  int Np[41], Ni[80], Tp[81], Ti[160], Pp[41], Pi[80], active[40];
  double Nx[80], Tx[160], Px[80], mu[40], g[120];
} contacts;

static void contacts_fill(contacts *c, dls_model *model, int count, int from) {
  const int top = line * line * high;
  memset(c, 0, sizeof *c);
  for (int k = 0; k < count; k++) {
    const int node = top + from + k;
    for (int l = 0; l < 2; l++) {
      const double share = l ? 0.4 : 0.6;
      c->Ni[2 * k + l] = 3 * (node + l) + 2;
      c->Nx[2 * k + l] = share;
      for (int t = 0; t < 2; t++) {
        c->Ti[4 * k + 2 * t + l] = 3 * (node + l) + t;
        c->Tx[4 * k + 2 * t + l] = share;
      }
      c->Pi[2 * k + l] = (k + l) % count;
      c->Px[2 * k + l] = l ? 0.25 : 0.75;
    }
    c->Np[k + 1] = c->Pp[k + 1] = 2 * k + 2;
    c->Tp[2 * k + 1] = 4 * k + 2;
    c->Tp[2 * k + 2] = 4 * k + 4;
    c->mu[k] = k % 3 ? 0.3 : 0;
    c->active[k] = k != 1;
    c->g[3 * k] = 1e-3 * (k % 2);
  }
  model->nodes = count;
  model->HN = (dls_sparse){n, count, c->Np, c->Ni, c->Nx};
  model->HT = (dls_sparse){n, 2 * count, c->Tp, c->Ti, c->Tx};
}

/* The host's solver: the inverse, by columns. */
static int cube_inverse(void *user, double *X, int rows, int nrhs) {
  const double *inverse = user;
  double *y = malloc((size_t)rows * sizeof *y);
  if (!y) return 1;
  for (int j = 0; j < nrhs; j++) {
    double *x = X + (size_t)j * (size_t)rows;
    memset(y, 0, (size_t)rows * sizeof *y);
    for (int k = 0; k < rows; k++)
      for (int i = 0; i < rows && x[k] != 0; i++)
        y[i] += inverse[i + k * rows] * x[k];
    memcpy(x, y, (size_t)rows * sizeof *y);
  }
  free(y);
  counted += nrhs;
  return 0;
}

/* The kinds of K: sparse by supernodes and by MUMPS, dense, its inverse, the host's, and on K. */
enum { cholesky, ldlt, lu, full, flexibility, host, on_K, kinds };

static double inverse[n * n], columns[n * 64];

/* K^-1 by a reduction that recovers unit loads. */
static void cube_invert(const dls_model *model) {
  dls_reduction *all = reduction_of(model, NULL);
  for (int j = 0; j < n; j++) {
    memset(columns, 0, n * sizeof *columns);
    columns[j] = 1;
    ck_assert_int_eq(dls_reduction_load(all, columns, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_recover(all, columns, inverse + (size_t)j * n, NULL), DLS_OK);
  }
  dls_reduction_destroy(all);
}

static dls_model cube_model(int kind) {
  dls_model model = *solids_model(&S);
  const dls_sparse K = model.Ks;
  model.nodes = 0;
  if (kind == ldlt) model.factorization = DLS_LDLT;
  if (kind == lu || kind == full) {
    memset(dense, 0, sizeof dense);
    for (int j = 0; j < n; j++)
      for (int k = K.p[j]; k < K.p[j + 1]; k++) {
        dense[K.i[k] + n * j] += K.x[k];
        if (K.i[k] != j) dense[j + n * K.i[k]] += K.x[k];
      }
  }
  if (kind == full) {
    model.operator_kind = DLS_STIFFNESS_DENSE;
    model.K = (dls_dense){n, n, n, dense};
  }
  if (kind == lu) { /* both triangles */
    static int p[n + 1], i[100 * n];
    static double x[100 * n];
    int to = 0;
    for (int j = 0; j < n; j++) {
      for (int k = 0; k < n; k++)
        if (dense[k + n * j] != 0) {
          i[to] = k;
          x[to++] = dense[k + n * j];
        }
      p[j + 1] = to;
    }
    model.factorization = DLS_LU;
    model.Ks = (dls_sparse){n, n, p, i, x};
  }
  if (kind == flexibility || kind == host) {
    cube_invert(&model);
    model.operator_kind = kind == host ? DLS_HOST_SOLVER : DLS_FLEXIBILITY;
    model.K = (dls_dense){n, n, n, inverse};
    model.solve = cube_inverse;
    model.user = inverse;
  }
  return model;
}

static int stages_seen;

static int cube_stage(void *data, const dls_progress *progress) {
  (void)data;
  stages_seen += strcmp(progress->stage, "factor") == 0;
  return 0;
}

/* The surface: all of the top. */
static dls_reduction_settings cube_settings(int kind) {
  static int surface[3 * line * line];
  dls_reduction_settings s;
  dls_reduction_settings_init(&s);
  for (int k = 0; k < 3 * line * line; k++)
    surface[k] = 3 * line * line * high + 3 * line * line - 1 - k;
  s.surface = surface;
  s.surface_count = 3 * line * line;
  s.on = kind == on_K ? DLS_ON_K : DLS_ON_W;
  s.progress = cube_stage;
  return s;
}

/* Compares a reduction that has moved with one that was made there. */
static void cube_compare(dls_reduction *moved, dls_reduction *made, int m, int on,
                         const double *mu) {
  static double r[2][120], x[2][n], u[2][120];
  dls_contact a, b;
  dls_certificate certificate[2];
  dls_solver_settings settings = settings_with(DLS_AUTO, 1e-12);
  if (on != on_K) {
    ck_assert_int_eq(dls_reduction_contact(moved, mu, &a, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_contact(made, mu, &b, NULL), DLS_OK);
    ck_assert(a.nc == b.nc && a.d == b.d && a.d * a.nc == m);
    if (m > 0) {
      assert_close(a.W.a, b.W.a, m * m, 1e-10);
      assert_close(a.q, b.q, m, 1e-10);
      assert_close(a.weights ? a.weights : a.q, b.weights ? b.weights : b.q,
                   a.weights ? 2 * a.nc : m, 1e-10);
    }
  }
  for (int k = 0; k < 2; k++) {
    memset(r[k], 0, sizeof r[k]);
    dls_reduction *of = k ? made : moved;
    const dls_status status = dls_reduction_solve(of, mu, &settings, r[k], u[k], x[k], NULL, NULL);
    ck_assert_msg(status == DLS_OK || status == DLS_TO_ROUNDING, "%d", status);
    ck_assert_int_eq(dls_reduction_certify(of, mu, r[k], x[k], NULL, &certificate[k], NULL),
                     DLS_OK);
    ck_assert_double_le(certificate[k].residual, 1e-8);
  }
  if (m > 0) assert_close(r[0], r[1], m, 1e-7);
  assert_close(x[0], x[1], n, 1e-7);
}

static void cube_walk(int kind, int with_P, int with_mu, int with_active, int frictionless,
                      int is_free) {
  static contacts c;
  static double x_free[n];
  dls_model model = cube_model(kind), nothing = model;
  dls_reduction_settings s = cube_settings(kind);
  s.frictionless = frictionless;
  dls_reduction *moved, *made;
  dls_error e;
  if (is_free) {
    ck_assert_int_eq(dls_reduction_create(&made, &model, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_load(made, loads, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_recover(made, x_free, x_free, NULL), DLS_OK);
    dls_reduction_destroy(made);
  }
  ck_assert_msg(dls_reduction_create(&moved, &model, &s, &e) == DLS_OK, "%s", e.message);
  ck_assert_int_eq(is_free ? dls_reduction_load_free(moved, x_free, NULL, NULL)
                           : dls_reduction_load(moved, loads, NULL, NULL),
                   DLS_OK);
  /* no K from now on */
  nothing.Ks = (dls_sparse){0};
  nothing.K = (dls_dense){0};
  nothing.solve = NULL;
  stages_seen = 0;
  const int steps[][2] = {{10, 0}, {10, 7}, {25, 3}, {0, 0}, {4, 20}};
  for (size_t k = 0; k < sizeof steps / sizeof steps[0]; k++) {
    const int count = steps[k][0], rows = frictionless ? 1 : 3,
              held = count - (with_active && count > 1);
    contacts_fill(&c, &nothing, count, steps[k][1]);
    nothing.P =
        with_P && count > 0 ? (dls_sparse){count, count, c.Pp, c.Pi, c.Px} : (dls_sparse){0};
    nothing.mu = with_mu && count > 0 ? c.mu : NULL;
    nothing.active = with_active && count > 0 ? c.active : NULL;
    const double none[40] = {0}, *mu = nothing.mu ? NULL : none;
    ck_assert_msg(dls_reduction_move(moved, &nothing, k % 2 ? NULL : c.g, &e) == DLS_OK, "%s",
                  e.message);
    ck_assert_int_eq(stages_seen, 0);
    dls_model whole = model;
    whole.nodes = nothing.nodes;
    whole.HN = nothing.HN;
    whole.HT = nothing.HT;
    whole.P = nothing.P;
    whole.mu = nothing.mu;
    whole.active = nothing.active;
    dls_reduction_settings plain = s;
    plain.surface_count = 0;
    plain.progress = NULL;
    ck_assert_int_eq(dls_reduction_create(&made, &whole, &plain, NULL), DLS_OK);
    ck_assert_int_eq(is_free ? dls_reduction_load_free(made, x_free, k % 2 ? NULL : c.g, NULL)
                             : dls_reduction_load(made, loads, k % 2 ? NULL : c.g, NULL),
                     DLS_OK);
    cube_compare(moved, made, rows * held, kind, mu);
    if (k == 2) { /* a new load, and new values of K, where it stands */
      ck_assert_int_eq(dls_reduction_update(moved, &whole, &e), DLS_OK);
      ck_assert_int_eq(is_free ? dls_reduction_load_free(moved, x_free, NULL, NULL)
                               : dls_reduction_load(moved, loads, NULL, NULL),
                       DLS_OK);
      ck_assert_int_eq(is_free ? dls_reduction_load_free(made, x_free, NULL, NULL)
                               : dls_reduction_load(made, loads, NULL, NULL),
                       DLS_OK);
      cube_compare(moved, made, rows * held, kind, mu);
      stages_seen = 0;
    }
    dls_reduction_destroy(made);
  }
  dls_reduction_destroy(moved);
}

TEST_EACH(as_made_there, 0, kinds) {
  if (!WITH_MUMPS && (_i == ldlt || _i == lu)) return;
  cube_walk(_i, 0, 0, 0, 0, 0);
}

TEST(options_move_too) {
  cube_walk(cholesky, 1, 0, 0, 0, 0);
  cube_walk(cholesky, 0, 1, 1, 0, 0);
  cube_walk(cholesky, 0, 0, 0, 1, 0);
  cube_walk(cholesky, 1, 1, 1, 0, 1);
  cube_walk(full, 1, 1, 1, 0, 1);
}

/* Without settings.surface H may touch what H of create touches. */
TEST(surface_of_create) {
  static contacts c, d;
  dls_model model = cube_model(cholesky);
  dls_error e;
  contacts_fill(&c, &model, 12, 0);
  dls_reduction *moved = reduction_of(&model, NULL);
  contacts_fill(&d, &model, 5, 3);
  ck_assert_int_eq(dls_reduction_move(moved, &model, NULL, &e), DLS_OK);
  contacts_fill(&d, &model, 5, 9);
  if (WITH_MUMPS) /* a whole factor takes any unknown */
    REFUSES(ARGUMENT, "HN", -1, dls_reduction_move, moved, &model, NULL);
  contacts_fill(&d, &model, 12, 0);
  ck_assert_int_eq(dls_reduction_move(moved, &model, NULL, &e), DLS_OK);
  dls_reduction_destroy(moved);
}

TEST(wrong_input_changes_nothing) {
  static contacts c;
  dls_model model = cube_model(cholesky);
  dls_reduction_settings s = cube_settings(cholesky);
  dls_error e;
  contacts_fill(&c, &model, 6, 2);
  dls_reduction *moved = reduction_of(&model, &s);
  ck_assert_int_eq(dls_reduction_load(moved, loads, c.g, NULL), DLS_OK);
  static double before[n], after[n], r[18];
  ck_assert_int_eq(dls_reduction_recover(moved, r, before, NULL), DLS_OK);
  dls_contact was, now;
  const double mu[6] = {0};
  ck_assert_int_eq(dls_reduction_contact(moved, mu, &was, NULL), DLS_OK);
#define WRONG(change, status, name, index)                                                         \
  do {                                                                                             \
    dls_model m = model;                                                                           \
    const double *g = c.g;                                                                         \
    change;                                                                                        \
    expect_error(dls_reduction_move(moved, &m, g, &e), &e, status, "dls_reduction_move", name,     \
                 index);                                                                           \
    (void)g;                                                                                       \
  } while (0)
  WRONG(m.d = 2, DLS_E_SIZE, "HT", -1);
  WRONG((m.d = 2, m.nodes = 0), DLS_E_SIZE, "d", -1);
  WRONG((m.n = n - 1, m.nodes = 0), DLS_E_SIZE, "n", -1);
  WRONG(m.nodes = -1, DLS_E_SIZE, "nodes", -1);
  WRONG(m.HN.p = NULL, DLS_E_ARGUMENT, "HN", -1);
  WRONG((m.P = (dls_sparse){6, 6, c.Pp, c.Pi, c.Nx}, c.Nx[0] = c.Nx[1] = -1), DLS_E_ARGUMENT, "P",
        0);
  contacts_fill(&c, &model, 6, 2);
  WRONG((m.mu = c.mu, c.mu[3] = -1), DLS_E_ARGUMENT, "mu", 3);
  WRONG(c.g[4] = NAN, DLS_E_NOT_FINITE, "g", 4);
  contacts_fill(&c, &model, 6, 2);
  if (WITH_MUMPS) WRONG(c.Ni[3] = 5, DLS_E_ARGUMENT, "HN", -1);
  contacts_fill(&c, &model, 6, 2);
  REFUSES(ARGUMENT, "reduction", -1, dls_reduction_move, NULL, &model, NULL);
  REFUSES(ARGUMENT, "model", -1, dls_reduction_move, moved, NULL, NULL);
  ck_assert_int_eq(dls_reduction_contact(moved, mu, &now, NULL), DLS_OK);
  ck_assert(now.W.a == was.W.a && now.q == was.q && now.nc == 6);
  ck_assert_int_eq(dls_reduction_recover(moved, r, after, NULL), DLS_OK);
  ck_assert_mem_eq(before, after, sizeof before);
  dls_reduction_destroy(moved);
  const int beyond[] = {4, n}, below[] = {-1};
  s.surface = beyond;
  s.surface_count = 2;
  REFUSES(ARGUMENT, "surface", 1, dls_reduction_create, &moved, &model, &s);
  s.surface = below;
  s.surface_count = 1;
  REFUSES(ARGUMENT, "surface", 0, dls_reduction_create, &moved, &model, &s);
  s.surface = NULL;
  REFUSES(ARGUMENT, "surface", -1, dls_reduction_create, &moved, &model, &s);
  s.surface_count = -1;
  REFUSES(ARGUMENT, "surface_count", -1, dls_reduction_create, &moved, &model, &s);
}

TEST(every_failing_malloc_unwinds) {
  static contacts c, d;
  dls_model model = cube_model(cholesky);
  dls_reduction_settings s = cube_settings(cholesky);
  contacts_fill(&c, &model, 6, 2);
  dls_reduction *moved = reduction_of(&model, &s);
  ck_assert_int_eq(dls_reduction_load(moved, loads, c.g, NULL), DLS_OK);
  static double before[n], after[n], r[18];
  r[0] = 1;
  ck_assert_int_eq(dls_reduction_recover(moved, r, before, NULL), DLS_OK);
  contacts_fill(&d, &model, 9, 20);
  dls_status status = DLS_E_MEMORY;
  int failed = 0;
  for (long at = 1; status == DLS_E_MEMORY; at++) {
    malloc_fails_at(at);
    status = dls_reduction_move(moved, &model, d.g, NULL);
    malloc_fails_at(0);
    if (!status) break;
    failed++;
    ck_assert_int_eq(dls_reduction_recover(moved, r, after, NULL), DLS_OK);
    ck_assert_mem_eq(before, after, sizeof before);
  }
  ck_assert_int_eq(status, DLS_OK);
  ck_assert_int_ge(failed, 10);
  dls_reduction_info info;
  ck_assert_int_eq(dls_reduction_get_info(moved, &info, NULL), DLS_OK);
  ck_assert_int_eq(info.contacts, 9);
  dls_reduction_destroy(moved);
}

/* The multiplier of a joint is no unknown of contact: u = x of two masses, tied by x_0 = x_1. */
TEST(joints_stay_joints) {
  const int Kp[] = {0, 2, 4, 5}, Ki[] = {0, 2, 1, 2, 2}, Np[] = {0, 1}, Tp[] = {0, 0};
  const double Kx[] = {1, 1, 1, -1, 0}, one[] = {1};
  int Ni[] = {0};
  dls_model model = {.d = 2,
                     .n = 3,
                     .nodes = 1,
                     .operator_kind = DLS_STIFFNESS_SPARSE,
                     .factorization = DLS_LDLT,
                     .Ks = {3, 3, Kp, Ki, Kx},
                     .HN = {3, 1, Np, Ni, one},
                     .HT = {3, 1, Tp, Ni, one}};
  dls_error e;
  dls_reduction *moved = reduction_of(&model, NULL);
  Ni[0] = 1;
  ck_assert_int_eq(dls_reduction_move(moved, &model, NULL, &e), DLS_OK);
  Ni[0] = 2;
  REFUSES(ARGUMENT, "HN", -1, dls_reduction_move, moved, &model, NULL);
  dls_reduction_destroy(moved);
}

int main(void) {
  return run_tests("move", cube_setup, cube_teardown);
}
