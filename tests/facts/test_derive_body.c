/*
 * test_derive_body.c: derivatives of answers (x, r) on K against central differences and closed
 * forms: the block of Jean, free bodies, joints, weighted reactions, E and nu.
 */
#include "cases.h"
#include "delassus.h"
#include "delassus/fe.h"
#include "differences.h"
#include "made.h"
#include "reduced.h"
#include "run.h"
#include "solids.h"

static const double tol = 1e-7; /* of a derivative against differences */

/* A model, its loads, and a direction of its data. */
typedef struct moved_body {
  dls_model model;
  dls_on on;
  const double *f, *g, *mu;
  int d, nc;
  size_t n, m, nodes, values; /* nodes: entries of g */
  const double *K;
  double *dK, *df, *dg, *dmu, *now;
} moved_body;

static void body_free(moved_body *v) {
  free(v->dK);
  free(v->df);
  free(v->dg);
  free(v->dmu);
  free(v->now);
}

/* Draws a direction, symmetric as K is read; loads and gaps that are 0 change, too, unless they
 * belong to a joint. */
static void move_body(moved_body *v, const dls_model *of, dls_on on, const double *f,
                      const double *g, const double *mu) {
  const int dense = of->operator_kind == DLS_STIFFNESS_DENSE;
  const int all = of->P.p ? of->P.cols : of->nodes;
  int candidates = 0;
  for (int c = 0; c < all; c++)
    candidates += !of->active || of->active[c];
  *v = (moved_body){.model = *of, .on = on, .f = f, .g = g, .mu = mu, .d = of->d};
  v->nc = candidates;
  v->n = (size_t)of->n;
  v->m = (size_t)v->d * (size_t)v->nc;
  v->nodes = (size_t)of->d * (size_t)of->nodes;
  v->values = dense ? v->n * v->n : (size_t)of->Ks.p[of->n];
  v->K = dense ? of->K.a : of->Ks.x;
  ck_assert(!dense || of->K.ld == of->n);
  v->dK = numbers(v->values);
  v->df = numbers(v->n);
  v->dg = numbers(v->nodes);
  v->dmu = numbers((size_t)v->nc);
  v->now = numbers(v->values + v->n + v->nodes + (size_t)v->nc);
  const double load = norm_of(f, of->n) / sqrt((double)v->n);
  for (size_t k = 0; k < v->values; k++)
    v->dK[k] = 0.03 * v->K[k] * uniform();
  for (size_t k = 0; k < v->n; k++)
    v->df[k] = load * uniform();
  for (int c = 0; c < v->nc; c++)
    v->dmu[c] = mu[c] * uniform();
}

/* out: r, u, x */
static int body_answer(void *of, double h, double *out, dls_contact_state *state) {
  moved_body *v = of;
  dls_model body = v->model;
  double *K = v->now, *f = K + v->values, *g = f + v->n, *mu = g + v->nodes;
  double *r = out, *u = r + v->m, *x = u + v->m;
  dls_reduction *R;
  dls_error e;
  for (size_t k = 0; k < v->values; k++)
    K[k] = v->K[k] + h * v->dK[k];
  for (size_t k = 0; k < v->n; k++)
    f[k] = v->f[k] + h * v->df[k];
  for (size_t k = 0; k < v->nodes; k++)
    g[k] = (v->g ? v->g[k] : 0) + h * v->dg[k];
  for (int c = 0; c < v->nc; c++)
    mu[c] = v->mu[c] + h * v->dmu[c];
  *(body.operator_kind == DLS_STIFFNESS_DENSE ? &body.K.a : &body.Ks.x) = K;
  dls_reduction_settings on;
  dls_reduction_settings_init(&on);
  on.on = v->on;
  ck_assert_msg(!dls_reduction_create(&R, &body, &on, &e), "%s", e.message);
  ck_assert_int_eq(dls_reduction_load(R, f, g, NULL), DLS_OK);
  dls_solver_settings s = settings_with(DLS_AUTO, v->on == DLS_ON_K ? 1e-13 : 1e-12);
  dls_status status = dls_reduction_solve(R, mu, &s, r, u, x, NULL, &e);
  ck_assert_msg(status >= 0, "%s", e.message);
  int solved = status == DLS_OK || status == DLS_TO_ROUNDING;
  if (solved && v->on == DLS_ON_W) {
    dls_contact p;
    dls_proof proof;
    dls_certificate c;
    ck_assert_int_eq(dls_reduction_contact(R, mu, &p, NULL), DLS_OK);
    ck_assert_int_eq(dls_contact_prove(&p, r, &proof, r, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_recover(R, r, x, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_certify(R, mu, r, x, u, &c, NULL), DLS_OK);
  }
  ck_assert_int_eq(dls_reduction_states(R, mu, r, u, state, NULL), DLS_OK);
  dls_reduction_destroy(R);
  return solved;
}

/* Returns the larger difference of the two products to differences; -1: no derivative. */
static double judge_body(moved_body *v, dls_error *why) {
  const size_t m = v->m, n = v->n, all = 2 * m + n;
  double *at = numbers(all), *D = numbers(all), *d = numbers(all), *g = numbers(all), worst = -1;
  double *gf = garbage(n), *gg = garbage(v->nodes), *gmu = garbage((size_t)v->nc);
  double *gK = garbage(v->values);
  dls_contact_state *state = malloc(((size_t)v->nc + 1) * sizeof *state);
  dls_derive *derive;
  ck_assert(body_answer(v, 0, at, state));
  dls_reduction_settings on;
  dls_reduction_settings_init(&on);
  on.on = v->on;
  dls_reduction *R = reduction_of(&v->model, &on);
  ck_assert_int_eq(dls_reduction_load(R, v->f, v->g, NULL), DLS_OK);
  const double length = norm_of(at + 2 * m, (int)n) / sqrt((double)n);
  for (size_t k = 0; k < v->nodes; k++)
    v->dg[k] = 0.1 * length * uniform();
  const dls_status status = dls_derive_create_body(&derive, R, v->mu, at, at + 2 * m, -1, why);
  if (status == DLS_OK) {
    ck_assert(differentiate(body_answer, v, 0, (int)all, v->nc, D));
    ck_assert_int_eq(
        dls_derive_jvp(derive, &(dls_derive_data){.f = v->df, .g = v->dg, .mu = v->dmu, .K = v->dK},
                       &(dls_derive_answer){d, d + m, d + 2 * m}, NULL),
        DLS_OK);
    const double of_x = norm_of(D + 2 * m, (int)n);
    worst = fmax(apart(d, D, m, 0), apart(d + 2 * m, D + 2 * m, n, 0));
    worst = fmax(worst, apart(d + m, D + m, m, of_x / sqrt((double)n)));
    const double of_r = norm_of(D, (int)m);
    for (size_t k = 0; k < all; k++)
      g[k] = uniform() / (k >= m ? of_x : of_r > 0 ? of_r : 1);
    ck_assert_int_eq(dls_derive_vjp(derive, &(dls_derive_answer){g, g + m, g + 2 * m},
                                    &(dls_derive_data){.f = gf, .g = gg, .mu = gmu, .K = gK}, NULL),
                     DLS_OK);
    const double L = scalar(gf, v->df, n) + scalar(gg, v->dg, v->nodes) +
                     scalar(gmu, v->dmu, (size_t)v->nc) + scalar(gK, v->dK, v->values);
    const double size = norm_of(g, (int)all);
    ck_assert_double_le(fabs(L - scalar(g, d, all)), 1e-9 * size);
    worst = fmax(worst, fabs(L - scalar(g, D, all)) / size);
    dls_derive_destroy(derive);
  } else
    ck_assert_msg(status == DLS_E_NO_DERIVATIVE, "%s", why->message);
  dls_reduction_destroy(R);
  free(at);
  free(D);
  free(d);
  free(g);
  free(gf);
  free(gg);
  free(gmu);
  free(gK);
  free(state);
  return worst;
}

/* Jean's block: concentrated and weighted, dense and sparse, on W and on K. */
TEST_EACH(block_of_jean, 0, 16) {
  static const char *const names[] = {"jean-fig3", "jean-fig4"};
  dls_fe_scene *scene;
  dls_fe_scene_settings s;
  dls_fe_scene_data data;
  moved_body v;
  dls_error why;
  dls_fe_scene_settings_init(&s);
  s.nx = _i & 4 ? 32 : 8;
  s.ny = _i & 4 ? 16 : 4;
  ck_assert_int_eq(dls_fe_scene_create_with(&scene, names[_i & 1], _i >> 1 & 1, &s, NULL), DLS_OK);
  dls_fe_scene_get(scene, &data);
  move_body(&v, &data.model, _i & 8 ? DLS_ON_K : DLS_ON_W, data.f, data.g, data.mu);
  const double worst = judge_body(&v, &why);
  ck_assert_msg(worst >= 0 && worst <= tol, "%g %s", worst, worst < 0 ? why.message : "");
  body_free(&v);
  dls_fe_scene_destroy(scene);
}

/* Free blocks on the ground, K singular; in 2D and 3D. */
TEST_EACH(free_blocks, 0, 4) {
  solids S;
  moved_body v;
  dls_error why;
  solids_stack(&S, 2 + _i % 2, 1 + _i / 2, 3, 0.5);
  const dls_model *body = &S.model;
  double *mu = numbers((size_t)body->nodes);
  for (int c = 0; c < body->nodes; c++)
    mu[c] = 0.3;
  move_body(&v, body, DLS_ON_K, S.f, S.g, mu);
  memset(v.dK, 0, v.values * sizeof *v.dK); /* rigid motions stay those of K */
  const double worst = judge_body(&v, &why);
  ck_assert_msg(worst <= tol, "%g", worst);
  free(mu);
  body_free(&v);
  solids_free(&S);
}

enum { small_n = 14, small_nodes = 4, small_joints = 2 };

/* Makes the last two joints the ones before, in f and in the lower triangle of K. */
static void alike(double *f, double *K) {
  for (int k = small_n - small_joints; k < small_n; k++) {
    f[k] = f[k - small_joints];
    for (int j = 0; j < small_n - 2 * small_joints; j++)
      K[k + small_n * j] = K[k - small_joints + small_n * j];
  }
}

/* Dense random bodies, 2D and 3D: with joints or unsymmetric (_i & 2), weighted (4), with a contact
 * without tangents and one left out (8), all joints given twice (16). */
TEST_EACH(random_bodies, 0, 20) {
  const int number = _i < 18 ? _i : _i + 2;
  double K[small_n * small_n] = {0}, N[small_n * small_nodes], T[2 * small_n * small_nodes];
  double f[small_n], g[3 * small_nodes], W[small_n * small_n], A[small_n * small_n];
  int p[2 * small_nodes + 1], row[2 * small_n * small_nodes];
  const double weight[] = {0.75, 0.25, 0.125, 0.75, 0.125, 0.25, 0.75}, mus[] = {0.4, 0, 0.7, 0.3};
  const int at[] = {0, 2, 5, 7}, node[] = {0, 1, 0, 1, 2, 2, 3}, active[] = {1, 1, 0, 1};
  const int d = 2 + (number & 1), twice = number / 16;
  const int joints = number & 2 ? 0 : small_joints * (1 + twice), own = small_n - joints;
  set_seed((uint64_t)number + 7);
  for (int k = 0; k < own * own; k++)
    A[k] = uniform();
  gram(own, A, 0.5, W);
  for (int j = 0; j < small_n; j++)
    for (int i = 0; i < small_n; i++)
      K[i + small_n * j] = i < own && j < own
                               ? W[i + own * j] * (number & 2 ? 1 + 0.1 * uniform() : 1)
                           : i < own || j < own ? 0.5 * cos(i * j)
                                                : 0;
  for (int k = 0; k <= 2 * small_nodes; k++)
    p[k] = own * k;
  for (int k = 0; k < 2 * own * small_nodes; k++) {
    row[k] = k % own;
    T[k] = uniform() * (k % 3 == 0);
    if (k < own * small_nodes) N[k] = uniform() * (k % 3 == 1);
  }
  for (int k = 0; k < small_n; k++)
    f[k] = uniform();
  for (int k = 0; k < 3 * small_nodes; k++)
    g[k] = k % d == 0 ? -0.4 : 0.1 * uniform();
  dls_model body = {.d = d,
                    .n = small_n,
                    .nodes = small_nodes,
                    .operator_kind = DLS_STIFFNESS_DENSE,
                    .factorization = number & 2 ? DLS_LU : DLS_LDLT,
                    .K = {small_n, small_n, small_n, K},
                    .HN = {small_n, small_nodes, p, row, N},
                    .HT = {small_n, (d - 1) * small_nodes, p, row, T}};
  double mu[small_nodes], few[small_nodes];
  for (int c = 0; c < small_nodes; c++)
    mu[c] = few[c] = number & 8 ? mus[c] : 0.4;
  if (number & 4) body.P = (dls_sparse){small_nodes, 3, at, node, weight};
  if (number & 8) {
    body.active = active;
    body.mu = mu;
    few[2] = mu[3];
  }
  if (twice) alike(f, K);
  moved_body v;
  dls_error why;
  move_body(&v, &body, DLS_ON_W, f, g, few);
  if (twice) alike(v.df, v.dK);
  const double worst = judge_body(&v, &why);
  ck_assert_msg(worst >= 0 && worst <= tol, "%g %s", worst, worst < 0 ? why.message : "");
  body_free(&v);
}

/* E and nu of triangles and of quadrilaterals, by differences of the reduction of the scene; the
 * loss is a sum of all nodes' displacements. */
static double loss_of(double E, double nu, int weighted, double *of_E, double *of_nu) {
  dls_fe_scene *scene;
  dls_fe_scene_settings s;
  dls_fe_scene_data data;
  dls_reduction *R;
  dls_contact p;
  dls_proof proof;
  dls_fe_scene_settings_init(&s);
  s.nx = 8;
  s.ny = 4;
  s.E = E;
  s.nu = nu;
  ck_assert_int_eq(dls_fe_scene_create_with(&scene, "jean-fig3", weighted, &s, NULL), DLS_OK);
  dls_fe_scene_get(scene, &data);
  const size_t n = (size_t)data.model.n, all = 2 * (size_t)data.mesh->nodes;
  double *x = numbers(n), *b = numbers(n), *on_mesh = numbers(2 * all), loss = 0;
  ck_assert_int_eq(reduce_on_W(&R, &data.model, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(R, data.f, data.g, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_contact(R, data.mu, &p, NULL), DLS_OK);
  double *r = numbers(2 * (size_t)p.nc);
  ck_assert_int_ge(dls_solve(&p, NULL, r, NULL, NULL, NULL), 0);
  ck_assert_int_eq(dls_contact_prove(&p, r, &proof, r, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_recover(R, r, x, NULL), DLS_OK);
  for (size_t k = 0; k < n; k++)
    loss += x[k] * cos((double)k);
  if (of_E) {
    dls_derive *derive;
    double *gx = numbers(n);
    for (size_t k = 0; k < n; k++)
      gx[k] = cos((double)k);
    ck_assert_int_eq(dls_derive_create_body(&derive, R, data.mu, r, x, -1, NULL), DLS_OK);
    ck_assert_int_eq(
        dls_derive_vjp(derive, &(dls_derive_answer){.x = gx}, &(dls_derive_data){.f = b}, NULL),
        DLS_OK);
    dls_derive_destroy(derive);
    free(gx);
    ck_assert_int_eq(dls_fe_scene_displacement(scene, x, on_mesh, NULL), DLS_OK);
    ck_assert_int_eq(dls_fe_scene_displacement(scene, b, on_mesh + all, NULL), DLS_OK);
    ck_assert_int_eq(dls_fe_material_gradient(data.mesh, data.E, data.nu, on_mesh + all, on_mesh,
                                              of_E, of_nu, NULL),
                     DLS_OK);
  }
  dls_reduction_destroy(R);
  dls_fe_scene_destroy(scene);
  free(x);
  free(b);
  free(r);
  free(on_mesh);
  return loss;
}

TEST_EACH(material, 0, 2) {
  double of_E, of_nu;
  const double E = 1.3e11, nu = 0.27;
  (void)loss_of(E, nu, _i, &of_E, &of_nu);
  double D[2][2];
  for (int k = 0; k < 2; k++) {
    const double h = 1e-3 / (k + 1);
    D[0][k] =
        (loss_of(E * (1 + h), nu, _i, NULL, NULL) - loss_of(E * (1 - h), nu, _i, NULL, NULL)) /
        (2 * h * E);
    D[1][k] = (loss_of(E, nu + h, _i, NULL, NULL) - loss_of(E, nu - h, _i, NULL, NULL)) / (2 * h);
  }
  ck_assert_double_eq_tol(of_E / (D[0][1] + (D[0][1] - D[0][0]) / 3), 1, tol);
  ck_assert_double_eq_tol(of_nu / (D[1][1] + (D[1][1] - D[1][0]) / 3), 1, tol);
}

/* Of a reduction: no K, a body that nothing holds, a border, memory. */
TEST(bad_bodies) {
  const double K[4] = {3, 1, 1, 2}, F[4] = {0.4, -0.2, -0.2, 0.6}, one[] = {1}, mu[] = {0.2};
  const int p[] = {0, 1}, along[] = {0}, up[] = {1};
  double r[2] = {10.9375, -2.1875}, x[2] = {0.9375, 0}, load[2] = {5, -10}, out[2];
  dls_model body = {.d = 2, .n = 2, .nodes = 1, .K = {2, 2, 2, K}};
  dls_derive *derive;
  body.HN = (dls_sparse){2, 1, p, up, one};
  body.HT = (dls_sparse){2, 1, p, along, one};
  body.operator_kind = DLS_FLEXIBILITY;
  body.K.a = F;
  dls_reduction *R = reduction_of(&body, NULL);
  ck_assert_int_eq(dls_reduction_load(R, load, NULL, NULL), DLS_OK);
  REFUSES(UNSUPPORTED, "reduction", -1, dls_derive_create_body, &derive, R, mu, r, x, -1);
  dls_reduction_destroy(R);
  body.K.a = K;
  body.operator_kind = DLS_STIFFNESS_DENSE;
  body.factorization = DLS_CHOLESKY;
  ck_assert_int_eq(dls_reduction_create(&R, &body, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(R, load, NULL, NULL), DLS_OK);
  REFUSES(ARGUMENT, "mu", -1, dls_derive_create_body, &derive, R, NULL, r, x, -1);
  x[0] = NAN;
  REFUSES(NOT_FINITE, "x", 0, dls_derive_create_body, &derive, R, mu, r, x, -1);
  x[0] = 0.9375;
  MALLOCS_FAIL(dls_derive_create_body(&derive, R, mu, r, x, -1, NULL), !derive, DLS_OK, 8);
  /* docs/tour.md, 8: u_n = .64 r_n - 7 = 0, r_t = -mu r_n */
  ck_assert_int_eq(dls_derive_vjp(derive, &(dls_derive_answer){.r = (double[]){1, 0}},
                                  &(dls_derive_data){.f = out}, NULL),
                   DLS_OK);
  assert_near(out, (double[]){0.2 / 0.64, -0.6 / 0.64}, 2, 1e-14);
  ck_assert_int_eq(dls_derive_vjp(derive, &(dls_derive_answer){.r = (double[]){1, 0}},
                                  &(dls_derive_data){.mu = out}, NULL),
                   DLS_OK);
  ck_assert_double_eq_tol(out[0], -7 * 0.2 / (0.64 * 0.64), 1e-13); /* r_n = 7 / (.6 + .2 mu) */
  REFUSES(ARGUMENT, "derive", -1, dls_derive_vjp, derive, &(dls_derive_answer){.r = r},
          &(dls_derive_data){.q = out});
  dls_derive_destroy(derive);
  dls_reduction_destroy(R);
}
