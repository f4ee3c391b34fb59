/*
 * test_derive.c: derivatives against closed forms and central differences of answers that are
 * improved to rounding, extrapolated (Romberg) from steps that keep the states; kinks against
 * one-sided differences.
 *
 *   build/tests/facts/test_derive FILE.hdf5 ...
 *
 * prints the relative difference for each FCLIB file, or why there is no derivative.
 */
#include "cases.h"
#include "delassus.h"
#include "delassus/forming.h"
#include "differences.h"
#include "fclib_file.h"
#include "made.h"
#include "reduced.h"
#include "run.h"

static const double tol = 1e-7; /* of a derivative against differences */

/* ---- contact problems ------------------------------------------------------------------------ */

/* A problem and a direction of its data. */
typedef struct moved {
  dls_contact p;
  size_t m, nc, values;
  const double *W;               /* stored values */
  double *dW, *dq, *dmu, *start; /* r at 0 */
  double *now;                   /* W, q, mu moved */
} moved;

static size_t stored(const dls_contact *p, const double **W) {
  const size_t m = (size_t)p->d * (size_t)p->nc;
  *W = p->W.a ? p->W.a : p->Wb.x ? p->Wb.x : p->bodies.H;
  return p->W.a    ? (size_t)p->W.ld * m
         : p->Wb.x ? (size_t)p->d * (size_t)p->d * (size_t)p->Wb.p[p->nc]
                   : 2 * (size_t)p->bodies.n * m;
}

static void moved_free(moved *v) {
  free(v->dW);
  free(v->dq);
  free(v->dmu);
  free(v->start);
  free(v->now);
}

/* Draws a direction, relative to the data; mu = 0 stays. */
static void move(moved *v, const dls_contact *p) {
  *v = (moved){.p = *p, .nc = (size_t)p->nc, .m = (size_t)p->d * (size_t)p->nc};
  v->values = stored(p, &v->W);
  v->dW = numbers(v->values);
  v->dq = numbers(v->m);
  v->dmu = numbers(v->nc);
  v->start = numbers(v->m);
  v->now = numbers(v->values + v->m + v->nc);
  const double q = norm_of(p->q, (int)v->m) / sqrt((double)v->m);
  for (size_t k = 0; k < v->values; k++)
    v->dW[k] = isnan(v->W[k]) ? 0 : v->W[k] * uniform() / sqrt((double)v->m); /* beyond m rows */
  for (size_t k = 0; k < v->m; k++)
    v->dq[k] = q * uniform();
  for (size_t c = 0; c < v->nc; c++)
    v->dmu[c] = p->mu[c] < INFINITY ? p->mu[c] * uniform() : 0;
}

/* Solves to rounding from the start. Returns 0 if that fails. out: r, then u. */
static int moved_answer(void *of, double h, double *out, dls_contact_state *state) {
  moved *v = of;
  dls_contact p = v->p;
  double *W = v->now, *q = W + v->values, *mu = q + v->m, *r = out, *u = out + v->m;
  for (size_t k = 0; k < v->values; k++)
    W[k] = v->W[k] + h * v->dW[k];
  for (size_t k = 0; k < v->m; k++)
    q[k] = p.q[k] + h * v->dq[k];
  for (size_t c = 0; c < v->nc; c++)
    mu[c] = h == 0 ? p.mu[c] : p.mu[c] + h * v->dmu[c];
  *(p.W.a ? &p.W.a : p.Wb.x ? &p.Wb.x : &p.bodies.H) = W;
  p.q = q;
  p.mu = mu;
  dls_solver_settings s = settings_with(DLS_AUTO, default_tol);
  s.limits.warm_start = 1;
  s.limits.tol = 1e-12;
  memcpy(r, v->start, v->m * sizeof *r);
  dls_status status = dls_solve(&p, &s, r, u, NULL, NULL);
  if (status != DLS_OK && status != DLS_TO_ROUNDING) return 0;
  dls_proof proof;
  ck_assert_int_eq(dls_contact_prove(&p, r, &proof, r, NULL), DLS_OK);
  dls_certificate c;
  ck_assert_int_eq(dls_contact_certify(&p, r, u, &c, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_states(&p, r, u, state, NULL), DLS_OK);
  for (size_t k = 0; k < v->nc; k++) /* without friction stick is slip */
    if (mu[k] == 0 && state[k] == DLS_STICK) state[k] = DLS_SLIP;
  return 1;
}

/* Returns the larger difference of jvp and vjp of this direction to D (r and u), and asserts that
 * the two agree. */
static double judge_both(const moved *v, dls_derive *derive, const double *D) {
  const size_t m = v->m;
  double *g = numbers(2 * m), *dr = garbage(2 * m), *gq = garbage(m), *gmu = garbage(v->nc);
  double *gW = garbage(v->values);
  dls_error e;
  ck_assert_msg(!dls_derive_jvp(derive, &(dls_derive_data){.q = v->dq, .mu = v->dmu, .W = v->dW},
                                &(dls_derive_answer){.r = dr, .u = dr + m}, &e),
                "%s", e.message);
  const double of_r = norm_of(D, (int)m), of_u = norm_of(D + m, (int)m);
  double worst = apart(dr, D, m, 0);
  worst = fmax(worst, apart(dr + m, D + m, m, norm_of(v->dq, (int)m)));
  for (size_t k = 0; k < 2 * m; k++)
    g[k] = uniform() / (k < m ? of_r > 0 ? of_r : 1 : of_u > 0 ? of_u : 1);
  ck_assert_int_eq(dls_derive_vjp(derive, &(dls_derive_answer){.r = g, .u = g + m},
                                  &(dls_derive_data){.q = gq, .mu = gmu, .W = gW}, NULL),
                   DLS_OK);
  double L = scalar(gq, v->dq, m) + scalar(gmu, v->dmu, v->nc) + scalar(gW, v->dW, v->values);
  const double size = norm_of(g, (int)(2 * m));
  ck_assert_double_le(fabs(L - scalar(g, dr, 2 * m)), 1e-9 * size);
  worst = fmax(worst, fabs(L - scalar(g, D, 2 * m)) / size);
  free(g);
  free(dr);
  free(gq);
  free(gmu);
  free(gW);
  return worst;
}

/* Compares at the answer of p. Returns the difference; -1: no derivative. *why: of that. */
static double judge(const dls_contact *p, dls_error *why) {
  moved v;
  move(&v, p);
  double *at = numbers(2 * v.m), *D = numbers(2 * v.m), worst = -1;
  dls_contact_state *state = malloc((v.nc + 1) * sizeof *state);
  dls_derive *derive;
  ck_assert_int_ge(dls_solve(p, NULL, v.start, NULL, NULL, NULL), 0);
  ck_assert(moved_answer(&v, 0, at, state));
  memcpy(v.start, at, v.m * sizeof *at);
  const dls_status status = dls_derive_create(&derive, p, v.start, -1, why);
  if (status == DLS_OK) {
    ck_assert(differentiate(moved_answer, &v, 0, 2 * (int)v.m, p->nc, D));
    worst = judge_both(&v, derive, D);
    dls_derive_destroy(derive);
  } else {
    ck_assert_msg(status == DLS_E_NO_DERIVATIVE, "%s", why->message);
    ck_assert_ptr_null(derive);
  }
  free(at);
  free(D);
  free(state);
  moved_free(&v);
  return worst;
}

/* ---- closed forms ---------------------------------------------------------------------------- */

/* W = I in 3D, q = (-1, q_t): slips with r_t = -mu q_t / |q_t| while |q_t| > mu, and turns with
 * q_t: dr_t / dq_t = -mu (1 - t t^T) / |q_t|. */
TEST(slip_turns) {
  static model a;
  double r[3], dr[3], du[3], q[3], mu[1];
  dls_derive *derive;
  set_model(&a, 3, 1);
  for (int i = 0; i < 3; i++)
    a.W[4 * i] = 1;
  a.q[0] = -1;
  a.q[1] = 3;
  a.q[2] = 4;
  a.mu[0] = 0.5;
  r[0] = 1;
  r[1] = -0.3;
  r[2] = -0.4;
  ck_assert_int_eq(dls_derive_create(&derive, &a.p, r, -1, NULL), DLS_OK);
  ck_assert_int_eq(dls_derive_jvp(derive, &(dls_derive_data){.q = (double[]){0.5, 1, 0}},
                                  &(dls_derive_answer){dr, du, NULL}, NULL),
                   DLS_OK);
  ck_assert_double_eq_tol(dr[0], -0.5, 1e-15);
  assert_near(dr + 1, (double[]){-0.1 * 16 / 25 + 0.5 * 0.3, 0.1 * 12 / 25 + 0.5 * 0.4}, 2, 1e-15);
  assert_near(du, (double[]){0, 1 + dr[1]}, 2, 1e-15);
  ck_assert_int_eq(dls_derive_vjp(derive, &(dls_derive_answer){.r = (double[]){0, 1, 0}},
                                  &(dls_derive_data){.q = q, .mu = mu}, NULL),
                   DLS_OK);
  assert_near(q, (double[]){0.3, -0.1 * 16 / 25}, 2, 1e-15);
  ck_assert_double_eq_tol(mu[0], -0.6, 1e-15);
  dls_derive_destroy(derive);
}

/* The derivative to the right at mu = 0: r_t = -mu u_t / |u_t| r_n. Stick and free do not know
 * mu. */
TEST(friction_from_zero) {
  static model a;
  double r[8] = {1, 0, 1, 0, 0, 0, 1, -0.25}, dr[8], mu[4];
  dls_derive *derive;
  set_model(&a, 2, 4);
  for (int i = 0; i < 8; i++)
    a.W[9 * i] = 1;
  memcpy(a.q, (double[]){-1, 2, -1, 0, 1, 5, -1, 0.25}, 8 * sizeof *a.q);
  a.mu[2] = 0.5;
  a.mu[3] = INFINITY;
  ck_assert_int_eq(dls_derive_create(&derive, &a.p, r, -1, NULL), DLS_OK);
  ck_assert_int_eq(dls_derive_jvp(derive, &(dls_derive_data){.mu = (double[]){1, 1, 1, 1}},
                                  &(dls_derive_answer){.r = dr}, NULL),
                   DLS_OK);
  for (int i = 0; i < 8; i++)
    ck_assert_double_eq_tol(dr[i], i == 1 ? -1 : 0, 1e-15);
  ck_assert_int_eq(dls_derive_vjp(derive,
                                  &(dls_derive_answer){.r = (double[]){0, 1, 0, 1, 0, 1, 0, 1}},
                                  &(dls_derive_data){.mu = mu}, NULL),
                   DLS_OK);
  for (int c = 0; c < 4; c++)
    ck_assert_double_eq_tol(mu[c], c == 0 ? -1 : 0, 1e-15);
  dls_derive_destroy(derive);
}

/* ---- random problems, files ------------------------------------------------------------------ */

enum { most_m = 300 };

/* W dense with a leading dimension beyond m; every third one unsymmetric. */
static dls_contact random_contacts(int i, double **memory) {
  static const int sizes[] = {1, 2, 4, 10, 30, 60, 100};
  set_seed((uint64_t)(i + 1));
  const int d = 1 + i % 3, nc = sizes[i / 3 % 7], m = d * nc, ld = m + 2;
  double *W = *memory = numbers((size_t)ld * (size_t)m + 2 * (size_t)m * (size_t)m + 2 * most_m);
  double *A = W + ld * m, *G = A + m * m, *q = G + m * m, *mu = q + m;
  for (int k = 0; k < m * m; k++)
    A[k] = uniform();
  gram(m, A, 0.1, G);
  for (int j = 0; j < m; j++)
    for (int k = 0; k < ld; k++)
      W[k + j * ld] = k < m ? G[k + j * m] * (i % 4 == 3 ? 1 + 0.05 * uniform() : 1) : NAN;
  for (int k = 0; k < m; k++)
    q[k] = uniform() - (k % d ? 0 : 0.3);
  for (int c = 0; c < nc; c++)
    mu[c] = d == 1 || c % 7 == 6 ? 0 : 0.45 + 0.35 * uniform();
  return (dls_contact){.d = d, .nc = nc, .W = {m, m, ld, W}, .q = q, .mu = mu};
}

TEST_EACH(random_dense, 0, 42) {
  double *memory;
  dls_error why;
  dls_contact p = random_contacts(_i, &memory);
  const double worst = judge(&p, &why);
  ck_assert_msg(worst <= tol, "%d: %g", _i, worst);
  if (worst < 0) ck_assert_int_ge(why.index, 0);
  free(memory);
}

/* By blocks, of rigid bodies: the gradient of what is stored. */
TEST_EACH(random_storages, 0, 18) {
  const int number = _i < 12 ? _i : _i + 88;
  static model a;
  static block_storage B;
  static bodies_storage S;
  dls_contact p;
  dls_error why;
  if (number < 100) {
    numbered_model(&a, number);
    p = by_blocks(&a, &B);
  } else
    bodies_model(&a, &S, &p, number);
  const double worst = judge(&p, &why);
  ck_assert_msg(worst <= tol, "%d: %g", number, worst);
}

/* 150 contacts in a row, by blocks: factors of MUMPS where there is MUMPS. */
TEST(sparse_blocks) {
  dls_contact dense, blocks;
  dls_derive *of[2];
  static double r[row_m], g[row_m], q[2][row_m];
  row_problem(0, &dense, &blocks);
  ck_assert_int_eq(dls_solve(&dense, NULL, r, NULL, NULL, NULL), DLS_OK);
  for (int k = 0; k < row_m; k++)
    g[k] = cos(k);
  for (int k = 0; k < 2; k++) {
    ck_assert_int_eq(dls_derive_create(&of[k], k ? &blocks : &dense, r, -1, NULL), DLS_OK);
    ck_assert_int_eq(dls_derive_vjp(of[k], &(dls_derive_answer){.r = g, .u = g},
                                    &(dls_derive_data){.q = q[k]}, NULL),
                     DLS_OK);
    dls_derive_destroy(of[k]);
  }
  ck_assert_double_le(apart(q[1], q[0], row_m, 0), 1e-12);
  dls_error why;
  const double worst = judge(&blocks, &why);
  ck_assert_msg(worst >= 0 && worst <= tol, "%g", worst);
}

static char **named; /* of the command line */

/* Judges a file; -2: auto has no answer of it. *nc: contacts. */
static double judge_file(const dls_fclib *file, int *nc, dls_error *why) {
  dls_contact p;
  dls_model body;
  dls_reduction *R = NULL;
  const double *f, *g, *mu;
  dls_status status = DLS_OK;
  if (dls_fclib_is_global(file)) {
    status = dls_fclib_model(file, &body, &f, &g, &mu, why);
    if (!status) status = reduce_on_W(&R, &body, NULL, why);
    if (!status) status = dls_reduction_load(R, f, g, why);
    if (!status) status = dls_reduction_contact(R, mu, &p, why);
  } else
    status = dls_fclib_contact(file, &p, why);
  ck_assert_msg(!status, "%s", why->message);
  *nc = p.nc;
  double *r = numbers((size_t)p.d * (size_t)p.nc);
  const int solved = dls_solve(&p, NULL, r, NULL, NULL, NULL) == DLS_OK;
  const double worst = solved ? judge(&p, why) : -2;
  free(r);
  dls_reduction_destroy(R);
  return worst;
}

TEST_EACH(every_file, 0, fclib_count) {
  dls_fclib *file = read_fclib_file(fclib_files[_i]);
  if (!file) return;
  dls_error why;
  int nc;
  const double worst = judge_file(file, &nc, &why);
  ck_assert_msg(worst >= 0 && worst <= tol, "%s: %g", fclib_files[_i], worst);
  dls_fclib_destroy(file);
}

/* ---- borders --------------------------------------------------------------------------------- */

/* Puts contact c of a problem with the answer r, u on a border: of stick and slip by mu_c, or of
 * free and slip by q_n; then *side is the sign of the data that leads to the higher state. Returns
 * 0 where c cannot. */
static int put_on_border(dls_contact *p, double *q, double *mu, int c, const double *r,
                         const double *u, const dls_contact_state *state, moved *v, int *side) {
  const int d = p->d;
  const double t = d == 1 ? 0 : d == 2 ? fabs(r[d * c + 1]) : hypot(r[d * c + 1], r[d * c + 2]);
  memset(v->dW, 0, v->values * sizeof(double));
  memset(v->dq, 0, v->m * sizeof(double));
  memset(v->dmu, 0, v->nc * sizeof(double));
  if (state[c] == DLS_STICK && mu[c] > 0 && t > 0) {
    mu[c] = t / r[d * c];
    v->dmu[c] = 1;
    *side = 1;
  } else if (state[c] == DLS_FREE) {
    q[d * c] -= u[d * c];
    v->dq[d * c] = 1;
    *side = -1;
  } else
    return 0;
  return 1;
}

/* On a border the error names the contact and both states; the two derivatives are those to the
 * right and to the left, and they differ. */
TEST_EACH(kinks, 0, 21) {
  double *memory;
  dls_contact p = random_contacts(_i, &memory);
  const size_t m = (size_t)p.d * (size_t)p.nc;
  double *q = numbers(m), *mu = numbers((size_t)p.nc), *at = numbers(2 * m), *D = numbers(2 * m);
  double *dr[2] = {numbers(2 * m), numbers(2 * m)};
  dls_contact_state *state = malloc(((size_t)p.nc + 1) * sizeof *state);
  dls_derive *derive;
  dls_error why;
  moved v;
  memcpy(q, p.q, m * sizeof *q);
  memcpy(mu, p.mu, (size_t)p.nc * sizeof *mu);
  p.q = q;
  p.mu = mu;
  move(&v, &p);
  ck_assert_int_ge(dls_solve(&p, NULL, v.start, NULL, NULL, NULL), 0);
  ck_assert(moved_answer(&v, 0, at, state));
  memcpy(v.start, at, m * sizeof *at);
  for (int c = 0, found = 0; c < p.nc && found < 4; c++) {
    int higher = 0;
    const double old_q = q[p.d * c], old_mu = mu[c];
    if (!put_on_border(&p, q, mu, c, v.start, at + m, state, &v, &higher)) continue;
    found++;
    ck_assert_int_eq(dls_derive_create(&derive, &p, v.start, -1, &why), DLS_E_NO_DERIVATIVE);
    ck_assert_ptr_null(derive);
    ck_assert_str_eq(why.argument, "contact");
    ck_assert_int_eq(why.index, c);
    ck_assert_ptr_nonnull(strstr(why.message, state[c] == DLS_FREE ? "free" : "stick"));
    for (int side = 0; side < 2; side++) {
      const int sign = side ? -higher : higher;
      ck_assert_int_eq(dls_derive_create(&derive, &p, v.start, side, &why), DLS_OK);
      ck_assert(differentiate(moved_answer, &v, sign, 2 * (int)m, p.nc, D));
      ck_assert_int_eq(dls_derive_jvp(derive, &(dls_derive_data){.q = v.dq, .mu = v.dmu},
                                      &(dls_derive_answer){.r = dr[side], .u = dr[side] + m}, NULL),
                       DLS_OK);
      ck_assert_msg(apart(dr[side], D, m, norm_of(v.start, (int)m)) <= tol,
                    "%d, contact %d, side %d: %g", _i, c, side,
                    apart(dr[side], D, m, norm_of(v.start, (int)m)));
      dls_derive_destroy(derive);
    }
    ck_assert_double_gt(apart(dr[0], dr[1], m, 0), 1e-3); /* a kink */
    q[p.d * c] = old_q;
    mu[c] = old_mu;
  }
  free(q);
  free(mu);
  free(at);
  free(D);
  free(dr[0]);
  free(dr[1]);
  free(state);
  free(memory);
  moved_free(&v);
}

/* A table on four legs: its reactions are not determined. */
TEST(four_legs) {
  static model a;
  static const double H[3][4] = {{1, 1, 1, 1}, {1, -1, 1, -1}, {1, 1, -1, -1}};
  dls_derive *derive;
  set_model(&a, 1, 4);
  for (int i = 0; i < 4; i++) {
    a.q[i] = -2;
    for (int j = 0; j < 4; j++)
      for (int k = 0; k < 3; k++)
        a.W[i + 4 * j] += H[k][i] * H[k][j] * (k ? 0.3 : 1);
  }
  REFUSES(NO_DERIVATIVE, "r", -1, dls_derive_create, &derive, &a.p,
          (double[]){0.75, 0.25, 0.25, 0.75}, -1);
}

/* Two rows that differ by 1e-8 determine r, and its derivative -W^-1, to eight digits. */
TEST(nearly_parallel_rows) {
  static model a;
  const double e = 1e-8;
  double dr[2];
  dls_derive *derive;
  set_model(&a, 1, 2);
  for (int k = 0; k < 4; k++)
    a.W[k] = k % 3 ? 1 - e : 1;
  a.q[0] = -3 + 2 * e;
  a.q[1] = -3 + e;
  ck_assert_int_eq(dls_derive_create(&derive, &a.p, (double[]){1, 2}, -1, NULL), DLS_OK);
  ck_assert_int_eq(dls_derive_jvp(derive, &(dls_derive_data){.q = (double[]){e, 0}},
                                  &(dls_derive_answer){.r = dr}, NULL),
                   DLS_OK);
  assert_near(dr, (double[]){-1 / (2 - e), (1 - e) / (2 - e)}, 2, 1e-7);
  dls_derive_destroy(derive);
}

/* The linearised contact problem of one load step of the indentation of Chabrand et al. */
TEST_EACH(indentation, 0, 6) {
  dls_forming_settings s;
  dls_forming *forming;
  dls_contact p;
  dls_error why;
  dls_forming_settings_init(&s);
  s.nx = 10;
  s.ny = 5;
  s.steps = 10;
  ck_assert_int_eq(dls_forming_create(&forming, "indentation", &s, NULL), DLS_OK);
  for (int k = 0; k <= _i; k++)
    ck_assert_int_eq(dls_forming_step(forming, NULL), DLS_OK);
  ck_assert_int_eq(dls_forming_problem(forming, &p, NULL), DLS_OK);
  const double worst = judge(&p, &why);
  ck_assert_msg(worst >= 0 && worst <= tol, "%g %s", worst, worst < 0 ? why.message : "");
  dls_forming_destroy(forming);
}

/* ---- nothing wrong --------------------------------------------------------------------------- */

/* A contact that slips beside one that sticks; all that may be wrong with a call is named. */
TEST(bad_calls) {
  double W[16] = {4, 0, 0.5, 0, 0, 2, 0, 0, 0.5, 0, 4, 0, 0, 0, 0, 2};
  double q[4] = {-4, -0.25, -4, 3}, mu[2] = {0.5, 0.5}, r[4], out[4] = {7, 7, 7, 7};
  const dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu};
  dls_derive *derive, *out_of[1];
  dls_error e;
  ck_assert_int_eq(dls_solve(&p, NULL, r, NULL, NULL, NULL), DLS_OK);
  REFUSES(ARGUMENT, "out", -1, dls_derive_create, NULL, &p, r, -1);
  REFUSES(ARGUMENT, "problem", -1, dls_derive_create, out_of, NULL, r, -1);
  REFUSES(ARGUMENT, "r", -1, dls_derive_create, out_of, &p, NULL, -1);
  REFUSES(ARGUMENT, "side", -1, dls_derive_create, out_of, &p, r, 2);
  r[2] += 0.1;
  REFUSES(ARGUMENT, "r", -1, dls_derive_create, out_of, &p, r, -1);
  r[2] = NAN;
  REFUSES(NOT_FINITE, "r", 2, dls_derive_create, out_of, &p, r, -1);
  ck_assert_int_eq(dls_solve(&p, NULL, r, NULL, NULL, NULL), DLS_OK);
  REFUSES(ARGUMENT, "reduction", -1, dls_derive_create_body, out_of, NULL, mu, r, r, -1);
  MALLOCS_FAIL(dls_derive_create(&derive, &p, r, -1, NULL), !derive, DLS_OK, 3);
  double g[4] = {1, 0, 0, NAN};
  const dls_derive_answer loss = {.r = g};
  const dls_derive_data gradient = {.q = out};
  REFUSES(ARGUMENT, "derive", -1, dls_derive_vjp, NULL, &loss, &gradient);
  REFUSES(ARGUMENT, "loss", -1, dls_derive_vjp, derive, NULL, &gradient);
  REFUSES(ARGUMENT, "gradient", -1, dls_derive_vjp, derive, &loss, NULL);
  REFUSES(NOT_FINITE, "r", 3, dls_derive_vjp, derive, &loss, &gradient);
  REFUSES(ARGUMENT, "derive", -1, dls_derive_vjp, derive, &loss, &(dls_derive_data){.f = out});
  REFUSES(NOT_FINITE, "q", 3, dls_derive_jvp, derive, &(dls_derive_data){.q = g}, &loss);
  double dW[16] = {0};
  dW[5] = INFINITY;
  REFUSES(NOT_FINITE, "W", 5, dls_derive_jvp, derive, &(dls_derive_data){.W = dW},
          &(dls_derive_answer){.r = out});
  assert_all(out, 4, 7);
  g[3] = 0;
  malloc_fails_at(0);
  const dls_status status = dls_derive_vjp(derive, &loss, &gradient, NULL);
  const long allocated = malloc_calls();
  ck_assert_int_eq(status, DLS_OK);
  ck_assert_int_eq(allocated, 0);
  /* dr_n(0) = l.(A^-1 ..): the first contact sticks, the second slips to the left */
  ck_assert_double_eq_tol(out[0], -1 / (4 - 0.25 / 4), 1e-15);
  dls_derive_destroy(derive);
  dls_derive_destroy(NULL);
  ck_assert_int_eq(dls_derive_create(&derive, &(dls_contact){.d = 2}, NULL, -1, &e), DLS_OK);
  ck_assert_int_eq(dls_derive_vjp(derive, &(dls_derive_answer){NULL, NULL, NULL}, &gradient, NULL),
                   DLS_OK);
  dls_derive_destroy(derive);
}

TEST_ALONE(named_file) {
  dls_fclib *file;
  dls_error why;
  int nc;
  ck_assert_int_eq(dls_fclib_read(&file, named[_i], &why), DLS_OK);
  const double worst = judge_file(file, &nc, &why);
  printf("%s: %d contacts, ", strrchr(named[_i], '/') ? strrchr(named[_i], '/') + 1 : named[_i],
         nc);
  if (worst >= 0)
    printf("%.1e\n", worst);
  else
    printf("%s\n", worst == -1 ? why.message : "not solved");
  (void)fflush(stdout);
  dls_fclib_destroy(file);
}

int main(int argc, char **argv) {
  if (argc > 1) {
    named = argv + 1;
    return run_alone(named_file, 0, argc - 1);
  }
  return run_tests("derive", NULL, NULL);
}
