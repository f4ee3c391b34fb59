/*
 * test_rest.c: bodies at rest, where forces cancel: statics is the judge.
 *
 * Rigid bodies, three unknowns each (two displacements, a rotation about the centre), K = 0 or the
 * masses.
 */
#include "contact/contact.h"
#include "delassus.h"
#include "made.h"
#include "run.h"
#include "solids.h"

enum { most_bodies = 12, most_contacts = 40, most = 3 * most_bodies };

/* Rigid bodies in the plane and their contacts. */
typedef struct rigid {
  int bodies, contacts;
  double x[most_bodies], y[most_bodies];
  double K[most * most], f[most];
  double N[2 * most * most_contacts], *T; /* n x contacts each */
} rigid;

static void rigid_body(rigid *R, double x, double y, double mass, double inertia) {
  const int b = R->bodies++;
  R->x[b] = x;
  R->y[b] = y;
  const double m[3] = {mass, mass, inertia};
  for (int i = 0; i < 3; i++)
    R->K[3 * b + i + most * (3 * b + i)] = m[i];
}

/* H of the motion of point (x, y) of body b along (ex, ey), times sign. */
static void rigid_column(const rigid *R, double *H, int b, double x, double y, double ex, double ey,
                         double sign) {
  H[3 * b] += sign * ex;
  H[3 * b + 1] += sign * ey;
  H[3 * b + 2] += sign * ((x - R->x[b]) * ey - (y - R->y[b]) * ex);
}

/* Body a touches body b (-1: the ground) at (x, y); (nx, ny) points to a, (ny, -nx) is tangent. */
static void rigid_contact(rigid *R, int a, int b, double x, double y, double nx, double ny) {
  const size_t at = (size_t)most * (size_t)R->contacts++;
  R->T = R->N + most * most_contacts;
  rigid_column(R, R->N + at, a, x, y, nx, ny, 1);
  rigid_column(R, R->T + at, a, x, y, ny, -nx, 1);
  if (b < 0) return;
  rigid_column(R, R->N + at, b, x, y, nx, ny, -1);
  rigid_column(R, R->T + at, b, x, y, ny, -nx, -1);
}

/* Solves with K = `mass` times the masses; returns the status. r: n, t a contact. */
static dls_status rigid_solve(const rigid *R, double mass, double mu, double *r, double *x,
                              dls_info *info) {
  const int n = 3 * R->bodies, nc = R->contacts;
  double *K = calloc((size_t)(n * n), sizeof *K), friction[most_contacts];
  int p[most_contacts + 1], *i = calloc((size_t)(n * nc), sizeof *i);
  double *N = calloc(2 * (size_t)(n * nc), sizeof *N), *T = N + n * nc;
  for (int k = 0; k < n; k++)
    K[k + n * k] = mass * R->K[k + most * k];
  for (int c = 0; c <= nc; c++)
    p[c] = n * c;
  for (int c = 0; c < nc; c++) {
    friction[c] = mu;
    for (int k = 0; k < n; k++) {
      i[k + n * c] = k;
      N[k + n * c] = R->N[k + most * c];
      T[k + n * c] = R->T[k + most * c];
    }
  }
  const dls_model model = {.d = 2,
                           .n = n,
                           .nodes = nc,
                           .operator_kind = DLS_STIFFNESS_DENSE,
                           .factorization = DLS_CHOLESKY,
                           .K = {n, n, n, K},
                           .HN = {n, nc, p, i, N},
                           .HT = {n, nc, p, i, T}};
  dls_reduction *reduction;
  dls_error e;
  dls_status status = dls_reduction_create(&reduction, &model, NULL, &e);
  if (!status) status = dls_reduction_load(reduction, R->f, NULL, &e);
  ck_assert_msg(status == DLS_OK, "%s", e.message);
  status = dls_reduction_solve(reduction, friction, NULL, r, NULL, x, info, &e);
  dls_certificate again;
  ck_assert_int_eq(dls_reduction_certify(reduction, friction, r, x, NULL, &again, NULL), DLS_OK);
  if (status == DLS_OK) ck_assert_int_eq(dls_certificate_verdict(&again, 1e-8), DLS_OK);
  dls_reduction_destroy(reduction);
  free(K);
  free(N);
  free(i);
  return status;
}

static double sum(const double *r, int from, int to, int i) {
  double all = 0;
  for (int c = from; c < to; c++)
    all += r[2 * c + i];
  return all;
}

static const double masses[] = {0, 1, 1e-6, 1e6};

/* A square of side 1 on a slope of .2 rad, mu .5: r balances 10, with its moment. */
TEST_EACH(box_on_a_slope, 0, 4) {
  rigid R = {0};
  double r[4], x[3];
  dls_info info;
  rigid_body(&R, 0, .5, 1, 1. / 6);
  rigid_contact(&R, 0, -1, -.5, 0, 0, 1);
  rigid_contact(&R, 0, -1, .5, 0, 0, 1);
  R.f[0] = 10 * sin(.2);
  R.f[1] = -10 * cos(.2);
  ck_assert_int_eq(rigid_solve(&R, masses[_i], .5, r, x, &info), DLS_OK);
  ck_assert_double_eq_tol(r[0], 5 * cos(.2) - 5 * sin(.2), 1e-7);
  ck_assert_double_eq_tol(r[2], 5 * cos(.2) + 5 * sin(.2), 1e-7);
  ck_assert_double_eq_tol(r[1] + r[3], -10 * sin(.2), 1e-7);
  for (int k = 0; masses[_i] > 0 && k < 3; k++)
    ck_assert_double_eq_tol(x[k], 0, 1e-7 * 10 / masses[_i]);
  R.f[0] = 10 * sin(.6); /* beyond tan .6 > .5 it slides: no equilibrium without mass */
  R.f[1] = -10 * cos(.6);
  const dls_status status = rigid_solve(&R, masses[_i], .5, r, x, &info);
  ck_assert(masses[_i] > 0 ? status == DLS_OK && x[0] > 0 : status == DLS_NO_SOLUTION);
}

/* Five boxes of side 1 and weight 9.81, the top one pushed by 4: each storey carries what is above
 * it. */
TEST_EACH(stack_that_is_pushed, 0, 4) {
  rigid R = {0};
  double r[20], x[15];
  dls_info info;
  for (int k = 0; k < 5; k++) {
    rigid_body(&R, 0, k + .5, 1, 1. / 6);
    rigid_contact(&R, k, k - 1, -.5, k, 0, 1);
    rigid_contact(&R, k, k - 1, .5, k, 0, 1);
    R.f[3 * k + 1] = -9.81;
  }
  R.f[12] = 4;
  ck_assert_int_eq(rigid_solve(&R, masses[_i], .5, r, x, &info), DLS_OK);
  for (int k = 0; k < 5; k++) {
    ck_assert_double_eq_tol(sum(r, 2 * k, 2 * k + 2, 0), 9.81 * (5 - k), 1e-6);
    ck_assert_double_eq_tol(sum(r, 2 * k, 2 * k + 2, 1), -4, 1e-6);
  }
}

/* Fingers squeeze a ball of weight 1 by forces of s each: it is held where 2 mu s > 1. */
TEST_EACH(grasp, 0, 4) {
  static const double squeeze[] = {.9, 1.1, 1e3, 1e6};
  rigid R = {0};
  double r[4], x[9];
  dls_info info;
  rigid_body(&R, 0, 0, 1, .4);
  rigid_body(&R, -1.5, 0, 1, .1);
  rigid_body(&R, 1.5, 0, 1, .1);
  rigid_contact(&R, 0, 1, -1, 0, 1, 0);
  rigid_contact(&R, 0, 2, 1, 0, -1, 0);
  R.f[1] = -1;
  R.f[4] = R.f[7] = .5; /* the arms carry the ball */
  for (int k = 0; k < 4; k++) {
    const double s = squeeze[k];
    R.f[3] = s;
    R.f[6] = -s;
    R.f[5] = .25; /* the moments of friction on the arms */
    R.f[8] = -.25;
    const dls_status status = rigid_solve(&R, masses[_i], .5, r, x, &info);
    if (s > 1) {
      ck_assert_int_eq(status, DLS_OK);
      ck_assert_double_eq_tol(r[0], s, 1e-7 * s);
      ck_assert_double_eq_tol(r[2], s, 1e-7 * s);
      ck_assert_double_eq_tol(fabs(r[1]), .5, 1e-7 * s);
    } else
      ck_assert(masses[_i] > 0 || status != DLS_OK);
  }
}

/* Solves `model` for f; r: 2 contacts, x: n. */
static dls_status solve_for(const dls_model *model, const double *f, double friction, double *r,
                            double *x, dls_certificate *again) {
  dls_reduction *reduction;
  dls_error e;
  double mu[64];
  for (int c = 0; c < model->nodes; c++)
    mu[c] = friction;
  dls_status status = dls_reduction_create(&reduction, model, NULL, &e);
  if (!status) status = dls_reduction_load(reduction, f, NULL, &e);
  ck_assert_msg(status == DLS_OK, "%s", e.message);
  status = dls_reduction_solve(reduction, mu, NULL, r, NULL, x, NULL, &e);
  ck_assert_int_eq(dls_reduction_certify(reduction, mu, r, x, NULL, again, NULL), DLS_OK);
  dls_reduction_destroy(reduction);
  return status;
}

/* A free block on a table, of 4 x 4 squares, its weight 1e-3, pushed sideways by `push` of what
 * friction holds. Heat expands it freely by (x, y) h: f = h K (x, y), which balances in itself and
 * is up to 1e8 times the weight. */
TEST_EACH(warm_block, 0, 30) {
  static const double pushes[] = {0, .5, .9, .99, 1.01, 1.3}, heats[] = {0, 1, 1e2, 1e4, 1e5};
  const double push = pushes[_i % 6], heat = heats[_i / 6] * 1e-3, mu = .3;
  solids S;
  solids_stack(&S, 2, 1, 4, push);
  const dls_model *model = solids_model(&S);
  const int n = model->n, nc = model->nodes;
  double *x = calloc(4 * (size_t)n, sizeof *x), *free_x = x + n, *f = free_x + n, *R = f + n, r[64];
  for (int k = 0; k < n / 2; k++) {
    free_x[2 * k] = heat * (k % 5);
    free_x[2 * k + 1] = heat * (k / 5);
  }
  solids_apply(model, R, free_x, f);
  for (int k = 0; k < n; k++)
    f[k] += S.f[k];
  dls_certificate again;
  const dls_status status = solve_for(model, f, mu, r, x, &again);
  if (push < 1) {
    ck_assert_msg(dls_solved(status), "%d: push %g heat %g", status, push, heat);
    ck_assert_double_eq_tol(sum(r, 0, nc, 0), 1e-3, 1e-3 * 1e-6);
    ck_assert_double_eq_tol(sum(r, 0, nc, 1), -push * mu * 1e-3, 1e-3 * 1e-6);
    ck_assert(dls_certificate_verdict(&again, 1e-8) != DLS_STALLED);
  } else
    ck_assert_msg(!dls_solved(status), "%d: push %g heat %g", status, push, heat);
  free(x);
  solids_free(&S);
}

/* A box of weight 1 between two walls: r_t = .5 at both holds it, with any r_n >= 1 at both. An
 * answer presses in by no .01, however large r_n, and lacks no 1e-6 of the weight. */
TEST_EACH(walls_that_press, 0, 3) {
  static const double presses[] = {1, 1e3, 1e6};
  static const int none[] = {0, 0}, p[] = {0, 1, 2}, x_row[] = {0, 0}, y_row[] = {1, 1};
  const double no = 0, n[] = {1, -1}, t[] = {1, 1}, f[2] = {0, -1}, mu[2] = {.5, .5};
  const double rn = presses[_i];
  const dls_model model = {.d = 2,
                           .n = 2,
                           .nodes = 2,
                           .operator_kind = DLS_STIFFNESS_SPARSE,
                           .factorization = DLS_CHOLESKY,
                           .Ks = {2, 2, (int[]){0, 0, 0}, none, &no},
                           .HN = {2, 2, p, x_row, n},
                           .HT = {2, 2, p, y_row, t}};
  dls_reduction *reduction;
  dls_certificate c;
  double r[4] = {rn, .5, rn, .5}, x[2] = {0, 0};
  ck_assert(!dls_reduction_create(&reduction, &model, NULL, NULL));
  ck_assert(!dls_reduction_load(reduction, f, NULL, NULL));
  ck_assert(!dls_reduction_certify(reduction, mu, r, x, NULL, &c, NULL));
  ck_assert_int_eq(dls_certificate_verdict(&c, 1e-8), DLS_OK);
  if (_i == 0) { /* which r_n is not determined, and said so */
    double by[4] = {0}, at[2];
    dls_info info;
    ck_assert(dls_solved(dls_reduction_solve(reduction, mu, NULL, by, NULL, at, &info, NULL)));
    ck_assert_double_eq_tol(by[1] + by[3], 1, 1e-7);
    ck_assert(info.error > DBL_MAX);
  }
  x[0] = -.01;
  ck_assert(!dls_reduction_certify(reduction, mu, r, x, NULL, &c, NULL));
  ck_assert_int_eq(dls_certificate_verdict(&c, 1e-8), DLS_STALLED);
  x[0] = 0;
  r[1] += 1e-6;
  ck_assert(!dls_reduction_certify(reduction, mu, r, x, NULL, &c, NULL));
  ck_assert_int_eq(dls_certificate_verdict(&c, 1e-8), DLS_STALLED);
  dls_reduction_destroy(reduction);
}

/* A warm start from r alone takes its states, and x from them: no iteration of the splitting. */
TEST(warm_from_r) {
  solids S;
  solids_stack(&S, 2, 1, 4, .5);
  const dls_model *model = solids_model(&S);
  double *x = calloc(2 * (size_t)model->n, sizeof *x), *again = x + model->n, mu[64], r[64];
  dls_reduction_settings how;
  dls_reduction_settings_init(&how);
  how.on = DLS_ON_K;
  for (int c = 0; c < model->nodes; c++)
    mu[c] = .3;
  for (int warm = 0; warm < 2; warm++) {
    dls_reduction *reduction;
    dls_info info;
    dls_solver_settings settings = settings_with(DLS_AUTO, default_tol);
    settings.limits.warm_start = warm;
    ck_assert(!dls_reduction_create(&reduction, model, &how, NULL));
    ck_assert(!dls_reduction_load(reduction, S.f, NULL, NULL));
    ck_assert_int_eq(
        dls_reduction_solve(reduction, mu, &settings, r, NULL, warm ? again : x, &info, NULL),
        DLS_OK);
    ck_assert_int_eq(info.iterations == 0, warm);
    dls_reduction_destroy(reduction);
  }
  for (int k = 0; k < model->n; k++)
    ck_assert_double_eq_tol(again[k], x[k], 1e-7 * (1 + fabs(x[k])));
  free(x);
  solids_free(&S);
}

/* The error of a loose answer on K, beside a sharp one. */
TEST(error_on_K) {
  solids S;
  solids_stack(&S, 2, 1, 4, .5);
  const dls_model *model = solids_model(&S);
  double *x = calloc((size_t)model->n, sizeof *x), mu[64], r[2][64] = {{0}}, largest = 0, apart = 0;
  dls_reduction *reduction;
  dls_reduction_settings how;
  dls_info info[2];
  dls_reduction_settings_init(&how);
  how.on = DLS_ON_K;
  ck_assert(!dls_reduction_create(&reduction, model, &how, NULL));
  ck_assert(!dls_reduction_load(reduction, S.f, NULL, NULL));
  for (int c = 0; c < model->nodes; c++)
    mu[c] = .3;
  for (int k = 0; k < 2; k++) {
    dls_solver_settings settings = settings_with(DLS_AUTO, k ? 1e-13 : 1e-3);
    ck_assert(
        dls_solved(dls_reduction_solve(reduction, mu, &settings, r[k], NULL, x, &info[k], NULL)));
  }
  for (int k = 0; k < 2 * model->nodes; k++) {
    largest = fmax(largest, fabs(r[1][k]));
    apart = fmax(apart, fabs(r[1][k] - r[0][k]));
  }
  ck_assert_double_gt(info[0].error, apart / largest / 30);
  ck_assert_double_lt(info[0].error, 1e-3);
  ck_assert_double_gt(info[1].error, 0);
  ck_assert_double_lt(info[1].error, 1e-10);
  dls_reduction_destroy(reduction);
  free(x);
  solids_free(&S);
}

/* A wrong reaction, by 1e-5 of the weight, and a body that flies are seen behind the heat. */
TEST(wrong_behind_heat) {
  solids S;
  solids_stack(&S, 2, 1, 4, 0);
  const dls_model *model = solids_model(&S);
  const int n = model->n, nc = model->nodes;
  double *x = calloc(4 * (size_t)n, sizeof *x), *free_x = x + n, *f = free_x + n, *R = f + n, r[64];
  for (int k = 0; k < n; k++)
    free_x[k] = 10 * (k % 2 ? k / 2 / 5 : k / 2 % 5);
  solids_apply(model, R, free_x, f);
  for (int k = 0; k < n; k++)
    f[k] += S.f[k];
  dls_certificate again;
  dls_reduction *reduction;
  double mu[64];
  ck_assert(dls_solved(solve_for(model, f, .3, r, x, &again)));
  for (int c = 0; c < nc; c++)
    mu[c] = .3;
  ck_assert(!dls_reduction_create(&reduction, model, NULL, NULL));
  ck_assert(!dls_reduction_load(reduction, f, NULL, NULL));
  r[0] += 1e-5 * 1e-3;
  ck_assert(!dls_reduction_certify(reduction, mu, r, x, NULL, &again, NULL));
  ck_assert_int_eq(dls_certificate_verdict(&again, 1e-8), DLS_STALLED);
  ck_assert_double_eq_tol(again.unbalanced, 1e-8, 1e-9);
  memset(r, 0, sizeof r); /* it hovers */
  for (int k = 0; k < n; k++)
    x[k] = free_x[k] + (k % 2 ? 1 : 0);
  ck_assert(!dls_reduction_certify(reduction, mu, r, x, NULL, &again, NULL));
  ck_assert_int_eq(dls_certificate_verdict(&again, 1e-8), DLS_STALLED);
  dls_reduction_destroy(reduction);
  free(x);
  solids_free(&S);
}

/* Fails if K x - f - H r is more than `part` of the largest load, or a gap more than 1e-5 of the
 * largest length. */
static void at_rest(const dls_model *model, const double *f, const double *g, const double *x,
                    const double *r, double part, double ulps) {
  double *e = calloc(2 * (size_t)model->n, sizeof *e), *size = e + model->n, u[64], R[64] = {0},
         load = 0, length = 0;
  solids_apply(model, R, x, e);
  for (int j = 0; j < model->n; j++) {
    e[j] -= f[j];
    load = fmax(load, fabs(f[j]));
    length = fmax(length, fabs(x[j]));
  }
  for (int c = 0; c < model->nodes; c++) {
    const dls_sparse *H[2] = {&model->HN, &model->HT};
    for (int i = 0; i < 2; i++) {
      u[2 * c + i] = g[2 * c + i];
      for (int k = H[i]->p[c]; k < H[i]->p[c + 1]; k++) {
        e[H[i]->i[k]] -= H[i]->x[k] * r[2 * c + i];
        size[H[i]->i[k]] += fabs(H[i]->x[k] * r[2 * c + i]);
        u[2 * c + i] += H[i]->x[k] * x[H[i]->i[k]];
      }
    }
    ck_assert_double_ge(u[2 * c], -1e-5 * length);
  }
  for (int j = 0; j < model->n; j++)
    ck_assert_double_le(fabs(e[j]), part * load + ulps * DBL_EPSILON * size[j]);
  free(e);
}

/* A free block between two walls, a floor and a ceiling, with much friction; x, r and states are
 * planted at random. Splitting and Newton's method find few of the answers, scattered states most
 * (global/scatter.c). Here the planted loads are the judge: an answer leaves no more than 1e-5 of
 * them, although reactions beyond 1e8 of them may cancel at an edge; one that is solved to rounding
 * alone no more than it says, up to 1e-4, and than a unit in the last place of each reaction. */
TEST_EACH(large_friction, 0, 2) {
  solids S;
  static const int count[3] = {2, 3, 1};
  const double walls[4][2] = {{cos(.3), sin(.3)}, {-cos(.3), sin(.3)}, {0, 1}, {0, -1}};
  solids_new(&S, 2, 12, 14);
  (void)solids_block(&S, count, 1);
  for (int k = 0; k < 12; k++) {
    if (k % 3 != 1) solids_contact(&S, k, -1, walls[k % 3 / 2], 0);
    if (k < 3 || k > 8) solids_contact(&S, k, -1, walls[k < 3 ? 2 : 3], 0);
  }
  const dls_model *model = solids_model(&S);
  const int n = model->n, nc = model->nodes;
  double *x = calloc(5 * (size_t)n, sizeof *x), *planted = x + n, *f = planted + n, *R = f + n;
  double r[64], force[64], u[64], friction[32];
  const double mu = _i ? 100 : 30;
  int scattered = 0, refused = 0;
  for (int seed = 0; seed < 20; seed++) {
    const int k = 20 * _i + seed;
    for (int j = 0; j < n; j++)
      planted[j] = dlsi_draw_entry(k, j) - .5;
    solids_apply(model, R, planted, f);
    for (int c = 0; c < nc; c++) {
      const double open = dlsi_draw_entry(k, n + c), slip = dlsi_draw_entry(k, n + nc + c);
      const double push = dlsi_draw_entry(k, n + 2 * nc + c), side = slip < .5 ? -1 : 1;
      double *rc = force + 2 * c, *uc = u + 2 * c;
      friction[c] = mu;
      rc[0] = rc[1] = uc[0] = uc[1] = 0;
      if (open < .3)
        uc[0] = push;
      else {
        rc[0] = .1 + push;
        rc[1] = side * rc[0] * (open < .7 ? mu : push);
        if (open < .7) uc[1] = -side * push;
      }
      const dls_sparse *H[2] = {&model->HN, &model->HT};
      for (int i = 0; i < 2; i++)
        for (int e = H[i]->p[c]; e < H[i]->p[c + 1]; e++) {
          f[H[i]->i[e]] -= H[i]->x[e] * rc[i];
          uc[i] -= H[i]->x[e] * planted[H[i]->i[e]];
        }
    }
    dls_reduction *reduction;
    dls_info info;
    dls_certificate again;
    ck_assert(!dls_reduction_create(&reduction, model, NULL, NULL));
    ck_assert(!dls_reduction_load(reduction, f, u, NULL));
    const dls_status status =
        dls_reduction_solve(reduction, friction, NULL, r, NULL, x, &info, NULL);
    refused += !dls_solved(status);
    const int rounded = status != DLS_OK;
    const double said = rounded ? 4 * info.certificate.floor_e : 0;
    ck_assert(!dls_solved(status) || said <= 1e-4);
    if (dls_solved(status)) at_rest(model, f, u, x, r, fmax(1e-5, said), rounded);
    ck_assert(!dls_reduction_certify(reduction, friction, r, x, NULL, &again, NULL));
    ck_assert_int_eq(dls_certificate_verdict(&again, 2e-8) == DLS_STALLED, !dls_solved(status));
    char text[2000];
    ck_assert_uint_lt(dls_explain(&info, text, sizeof text), sizeof text);
    ck_assert(!strstr(text, "scatter") == !(info.stage[info.stages - 1].step == DLS_STEP_SCATTER));
    scattered += info.stage[info.stages - 1].step == DLS_STEP_SCATTER;
    dls_reduction_destroy(reduction);
  }
  ck_assert_int_gt(scattered, 0);
  ck_assert_int_le(refused, 4);
  free(x);
  solids_free(&S);
}

/* Each allocation of a solve that splits, and of the certificate of its answer, fails in turn:
 * outputs stay as they were. */
TEST(failing_mallocs_of_a_split) {
  solids S;
  solids_stack(&S, 2, 1, 4, .5);
  const dls_model *model = solids_model(&S);
  const int n = model->n, nc = model->nodes;
  double *x = calloc(4 * (size_t)n, sizeof *x), *free_x = x + n, *f = free_x + n, *R = f + n, r[64];
  double mu[64];
  for (int k = 0; k < n; k++)
    free_x[k] = 1e6 * (k % 2 ? k / 2 / 5 : k / 2 % 5);
  solids_apply(model, R, free_x, f);
  for (int k = 0; k < n; k++)
    f[k] += S.f[k];
  for (int c = 0; c < nc; c++)
    mu[c] = .3;
  dls_reduction *reduction;
  ck_assert(!dls_reduction_create(&reduction, model, NULL, NULL));
  ck_assert(!dls_reduction_load(reduction, f, NULL, NULL));
  for (int what = 0; what < 2; what++) {
    long k = 1;
    for (dls_status status = DLS_E_MEMORY; status == DLS_E_MEMORY; k++) {
      dls_certificate c = {.residual = 7};
      if (!what) r[0] = x[0] = 7;
      malloc_fails_at(k);
      status = what ? dls_reduction_certify(reduction, mu, r, x, NULL, &c, NULL)
                    : dls_reduction_solve(reduction, mu, NULL, r, NULL, x, NULL, NULL);
      malloc_fails_at(0);
      if (status == DLS_E_MEMORY)
        ck_assert(what ? c.residual == 7 : r[0] == 7 && x[0] == 7);
      else
        ck_assert(what ? status == DLS_OK && c.residual < 1 : dls_solved(status));
    }
    ck_assert_int_gt(k, 8);
  }
  dls_reduction_destroy(reduction);
  free(x);
  solids_free(&S);
}

/* A bar of stiffness k, one end put to v by a penalty P on the diagonal of K, the other pressed
 * onto the ground: r = k (-v) - w, for a penalty of any size. */
TEST_EACH(penalty, 0, 8) {
  static const double sizes[] = {1e8, 1e10, 1e12, 1e14, 1e16, 1e20, 1e25, 1e30};
  const double k = 3, v = -.01, w = .002, P = sizes[_i];
  const double K[4] = {k + P, -k, -k, k}, f[2] = {P * v, w}, one[1] = {1};
  const int p[] = {0, 1}, none[] = {0, 0}, row[] = {1};
  const dls_model model = {.d = 2,
                           .n = 2,
                           .nodes = 1,
                           .operator_kind = DLS_STIFFNESS_DENSE,
                           .factorization = DLS_CHOLESKY,
                           .K = {2, 2, 2, K},
                           .HN = {2, 1, p, row, one},
                           .HT = {2, 1, none, row, one}};
  double r[2], x[2];
  dls_certificate again;
  ck_assert_int_eq(solve_for(&model, f, 0, r, x, &again), DLS_OK);
  ck_assert_double_eq_tol(r[0], -k * v - w, 1e-7 + 1e2 / P);
  ck_assert_int_eq(dls_certificate_verdict(&again, 1e-8), DLS_OK);
}

/* A block whose upper corner penalties of unlike size move: pressed down and along the ground, its
 * side on a wall that the corner just touches. The reactions are those of moderate penalties, and
 * that of the wall, rounding beside the penalty, is in its cone. */
TEST(unlike_penalties) {
  static const double sizes[][2] = {
      {1e8, 1e8}, {7e13, 1e9}, {1e11, 1e10}, {1e12, 3e12}, {3e18, 2e18}};
  static const int count[3] = {4, 2, 1};
  const double up[2] = {0, 1}, back[2] = {-1, 0}, v[2] = {.125, -.0625};
  double r[5][16], x[64], mu[6];
  for (int k = 0; k < 5; k++) {
    solids S;
    dls_reduction *reduction;
    solids_new(&S, 2, 15, 6);
    (void)solids_block(&S, count, 1);
    for (int c = 0; c < 5; c++)
      solids_contact(&S, c, -1, up, 0);
    solids_contact(&S, 14, -1, back, .125);
    for (int i = 0; i < 2; i++)
      solids_spring(&S, 14, i, sizes[k][i]);
    const dls_model *model = solids_model(&S);
    for (int i = 0; i < 2; i++)
      S.f[28 + i] = sizes[k][i] * v[i];
    for (int c = 0; c < 6; c++)
      mu[c] = .3;
    ck_assert(!dls_reduction_create(&reduction, model, NULL, NULL));
    ck_assert(!dls_reduction_load(reduction, S.f, S.g, NULL));
    ck_assert_int_eq(dls_reduction_solve(reduction, mu, NULL, r[k], NULL, x, NULL, NULL), DLS_OK);
    ck_assert_double_gt(r[k][0] + r[k][2] + r[k][4] + r[k][6] + r[k][8], 1e-3);
    for (int c = 0; c < 5; c++)
      assert_near(r[k] + 2 * c, r[0] + 2 * c, 2, 1e-7);
    ck_assert_double_ge(r[k][10], 0);
    ck_assert_double_le(fabs(r[k][11]), .3 * r[k][10] * (1 + 1e-9));
    dls_reduction_destroy(reduction);
    solids_free(&S);
  }
}
