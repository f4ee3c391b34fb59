/* cases.c: implements cases.h. */
#include "cases.h"

#include <check.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/solve.h"
#include "malloc_fails.h"

static uint64_t seed;

void set_seed(uint64_t s) {
  seed = s;
}

double uniform(void) {
  seed ^= seed << 13;
  seed ^= seed >> 7;
  seed ^= seed << 17;
  return ((double)(seed >> 11) + 0.5) * 0x1p-52 - 1;
}

double norm_of(const double *x, int n) {
  double s = 0;
  for (int i = 0; i < n; i++)
    s += x[i] * x[i];
  return sqrt(s);
}

/* ---- problems -------------------------------------------------------------------------------- */

void set_model(model *a, int d, int nc) {
  const int m = d * nc;
  memset(a, 0, sizeof *a);
  a->p = (dls_contact){.d = d, .nc = nc, .W = {m, m, m, a->W}, .q = a->q, .mu = a->mu};
}

void copy_model(model *a, const model *b) {
  *a = *b;
  a->p.W.a = a->W;
  a->p.q = a->q;
  a->p.mu = a->mu;
}

void gram(int m, const double *A, double shift, double *W) {
  for (int j = 0; j < m; j++)
    for (int i = 0; i <= j; i++) {
      double s = i == j ? shift : 0;
      for (int k = 0; k < m; k++)
        s += A[i + m * k] * A[j + m * k] / m;
      W[i + m * j] = W[j + m * i] = s;
    }
}

void gram_and_skew(int m, double (*draw)(void), double shift, double skew, double *W, double *q) {
  double *A = malloc((size_t)(m * m) * sizeof *A);
  ck_assert_ptr_nonnull(A);
  for (int k = 0; k < m * m; k++)
    A[k] = draw();
  gram(m, A, shift, W);
  for (int j = 0; j < m; j++)
    for (int i = 0; i < j; i++) {
      const double s = skew * draw();
      W[i + m * j] += s;
      W[j + m * i] -= s;
    }
  for (int i = 0; i < m; i++)
    q[i] = draw();
  free(A);
}

void random_model(model *a, int d, int nc, double mu) {
  static double A[most * most];
  const int m = d * nc;
  set_model(a, d, nc);
  for (int k = 0; k < m * m; k++)
    A[k] = uniform();
  gram(m, A, 0.1, a->W);
  for (int i = 0; i < m; i++)
    a->q[i] = uniform() - (i % d == 0 ? 0.5 : 0);
  for (int c = 0; c < nc; c++)
    a->mu[c] = mu;
}

void numbered_model(model *a, int i) {
  const double mu[] = {0, 0.1, 0.3, 0.6};
  set_seed(88172645463325252u + (uint64_t)i);
  if (i >= normal_models)
    random_model(a, 1, 1 + i % 20, 0);
  else
    random_model(a, 2 + i % 2, 1 + i % 20, mu[i % 4]);
}

void deficient_model(model *a, int number) {
  static double B[most * most];
  const int d = 2 + number % 2, nc = 4 + number % 12, m = d * nc, rank = m / 2;
  set_seed(88172645463325252u + 77 * (uint64_t)number);
  set_model(a, d, nc);
  for (int k = 0; k < m * rank; k++)
    B[k] = uniform();
  double r[most] = {0}, u[most] = {0};
  for (int c = 0; c < nc; c++) {
    double *rc = r + d * c, *uc = u + d * c;
    const double angle = 3 * uniform(), mu = 0.3;
    const double t[2] = {d == 2 ? copysign(1, angle) : cos(angle), sin(angle)};
    a->mu[c] = mu;
    for (int i = 1; i < d; i++) {
      uc[i] = c % 3 == 0 ? uniform() : c % 3 == 1 ? -t[i - 1] : 0; /* free, slip, stick */
      rc[i] = c % 3 == 0 ? 0 : mu * t[i - 1] * (c % 3 == 1 ? 1 : 0.5);
    }
    rc[0] = c % 3 > 0;
    uc[0] = c % 3 == 0;
  }
  for (int i = 0; i < m; i++) {
    for (int j = 0; j < m; j++)
      for (int k = 0; k < rank; k++)
        a->W[i + m * j] += B[i + m * k] * B[j + m * k] / rank;
    a->q[i] = u[i];
    for (int j = 0; j < m; j++)
      a->q[i] -= a->W[i + m * j] * r[j];
  }
}

void scale_model(model *a, const model *b, double length, double force) {
  const int m = b->p.d * b->p.nc;
  copy_model(a, b);
  for (int k = 0; k < m; k++)
    a->q[k] *= length;
  for (int k = 0; k < m * m; k++)
    a->W[k] *= length / force;
}

void slow_model(model *a, int i) {
  const int d = 2 + i % 2;
  set_seed(88172645463325252u + (uint64_t)i);
  random_model(a, d, most / d, 0.5);
  for (int k = 0; k < most; k++) {
    a->W[k + most * k] += 1e-3 - 0.1;
    if (k % d == 0) a->q[k] -= 4;
  }
}

int reversed(const model *a, int k) {
  const int d = a->p.d;
  return d * (a->p.nc - 1 - k / d) + k % d;
}

void reverse_model(model *a, const model *b) {
  const int m = b->p.d * b->p.nc;
  set_model(a, b->p.d, b->p.nc);
  for (int k = 0; k < m; k++) {
    const int to = reversed(b, k);
    a->q[to] = b->q[k];
    a->mu[to / b->p.d] = b->mu[k / b->p.d];
    for (int l = 0; l < m; l++)
      a->W[to + m * reversed(b, l)] = b->W[k + m * l];
  }
}

void turn_vector(const model *a, const double *angle, double *v) {
  for (int c = 0; c < a->p.nc; c++) {
    const double co = cos(angle[c]), si = sin(angle[c]), x = v[3 * c + 1], y = v[3 * c + 2];
    v[3 * c + 1] = co * x + si * y;
    v[3 * c + 2] = co * y - si * x;
  }
}

void turn_model(model *a, const model *b, const double *angle) {
  const int m = 3 * b->p.nc;
  copy_model(a, b);
  turn_vector(a, angle, a->q);
  for (int k = 0; k < m; k++)
    turn_vector(a, angle, a->W + m * k);
  for (int k = 0; k < m; k++) {
    double row[most];
    for (int l = 0; l < m; l++)
      row[l] = a->W[k + m * l];
    turn_vector(a, angle, row);
    for (int l = 0; l < m; l++)
      a->W[k + m * l] = row[l];
  }
}

dls_contact by_blocks(const model *a, block_storage *B) {
  dls_contact p = a->p;
  int count;
  ck_assert_int_eq(dls_blocks_count(&p.W, p.d, &count, NULL), DLS_OK);
  ck_assert_int_le(count, (int)(sizeof B->i / sizeof B->i[0]));
  ck_assert_int_eq(dls_blocks_from_dense(&p.W, p.d, B->p, B->i, B->x, &p.Wb, NULL), DLS_OK);
  memset(&p.W, 0, sizeof p.W);
  return p;
}

/* Candidate c pushes on the new body c, and on an older one or on a fixed one. */
void bodies_model(model *a, bodies_storage *B, dls_contact *factored, int i) {
  const double mu[] = {0, 0.1, 0.3, 0.6};
  const int d = 1 + i % 3, n = d == 1 ? 3 + 3 * (i / 3 % 2) : 3 * (d - 1), nc = 1 + i % 10;
  const int m = d * nc;
  set_seed(88172645463325252u + 13 * (uint64_t)i);
  set_model(a, d, nc);
  for (int c = 0; c < nc; c++) {
    const int other = (int)((uniform() + 1) / 2 * (c + 1)) - 1;
    B->body[2 * c + i % 2] = c;
    B->body[2 * c + 1 - i % 2] = other;
    a->mu[c] = d == 1 ? 0 : mu[i / 3 % 4];
  }
  for (int k = 0; k < 2 * n * m; k++)
    B->H[k] = B->body[k / (n * d)] < 0 ? NAN : uniform();
  for (int k = 0; k < m; k++)
    a->q[k] = uniform() - (k % d == 0 ? 0.5 : 0);
  for (int j = 0; j < 2 * m; j++)
    for (int k = 0; k < 2 * m; k++) {
      const int b = B->body[j / d];
      for (int l = 0; b >= 0 && b == B->body[k / d] && l < n; l++)
        a->W[j / (2 * d) * d + j % d + m * (k / (2 * d) * d + k % d)] +=
            B->H[n * j + l] * B->H[n * k + l];
    }
  *factored = a->p;
  factored->W = (dls_dense){0, 0, 0, NULL};
  factored->bodies = (dls_bodies){n, nc, B->body, B->H, NULL};
}

void row_problem(int singular, dls_contact *dense, dls_contact *blocks) {
  static double W[row_m * row_m], x[3 * row_nc * 4], q[row_m], mu[row_nc];
  static int p[row_nc + 1], i[3 * row_nc];
  set_seed(2463534242);
  int k = 0;
  memset(W, 0, sizeof W);
  for (int b = 0; b < row_nc; b++) {
    p[b] = k;
    for (int a = b - 1; a <= b + 1; a++) {
      if (a < 0 || a >= row_nc) continue;
      const double near = singular ? (a / 2 == b / 2) : 0.4; /* singular: by pairs, of rank 1 */
      const double block[4] = {a == b ? 1 : near, a == b || singular ? 0 : .1 * (a - b),
                               a == b || singular ? 0 : .1 * (b - a), a == b ? 1 : near};
      memcpy(x + 4 * k, block, sizeof block);
      i[k++] = a;
      for (int e = 0; e < 4; e++)
        W[2 * a + e % 2 + row_m * (2 * b + e / 2)] = block[e];
    }
    q[2 * b] = singular ? -1 : -1 + 0.2 * uniform();
    q[2 * b + 1] = singular ? 0.1 : 0.2 * uniform();
    mu[b] = 1;
  }
  p[row_nc] = k;
  *dense = (dls_contact){.d = 2, .nc = row_nc, .W = {row_m, row_m, row_m, W}, .q = q, .mu = mu};
  *blocks = *dense;
  memset(&blocks->W, 0, sizeof blocks->W);
  blocks->Wb = (dls_blocks){2, row_nc, p, i, x};
}

/* ---- by hand --------------------------------------------------------------------------------- */

const hand_case hand[hand_count] = {
    {"separate", 2, 1, {2, 1, 1, 2}, {1, -3}, 1, {0, 0}},
    {"q = 0", 2, 1, {2, 1, 1, 2}, {0, 0}, 1, {0, 0}},
    {"stick", 2, 1, {2, 0, 0, 1}, {-2, .5}, 1, {1, -.5}},
    {"slip right", 2, 1, {2, 0, 0, 1}, {-2, 5}, 1, {1, -1}},
    {"slip left", 2, 1, {2, 0, 0, 1}, {-2, -5}, 1, {1, 1}},
    {"coupled stick", 2, 1, {2, 1, 1, 2}, {-3.5, -1}, .5, {2, -.5}},
    {"coupled slip left", 2, 1, {2, 1, 1, 2}, {-5, -6}, .5, {2, 1}},
    {"coupled slip right", 2, 1, {2, 1, 1, 2}, {-3, 1}, .5, {2, -1}},
    {"no friction", 2, 1, {2, 1, 1, 2}, {-4, 3}, 0, {2, 0}},
    {"C3 below", 2, 1, {1, 1, 1, 1}, {-2, 0}, .5, {4, -2}},
    {"C6", 2, 1, {2, -1, -1, 1}, {-1, 1}, 1, {1. / 3, -1. / 3}},
    {"C7", 2, 1, {1, -1, -1, 2}, {-1, -3}, 2, {5, 4}},
    {"C9", 2, 1, {1, -1, -1, 2}, {-1, 0}, 3, {2, 1}},
    {"C10", 2, 1, {2, -1, -1, 1}, {-1, 1}, 4, {1. / 6, -2. / 3}},
    {"C12a", 2, 1, {5, 2, 2, 1}, {-1, 0}, 3, {1, -2}},
    /* normals coupled: 2 r_1 + r_2 = 3, r_1 + 2 r_2 = 3; one sticks, one slips left */
    {"two",
     2,
     2,
     {2, 0, 1, 0, 0, 1, 0, 0, 1, 0, 2, 0, 0, 0, 0, 1},
     {-3, .25, -3, -3},
     .5,
     {1, -.25, 1, .5}},
    /* the second is lifted off by the first: u_n2 = 1 - 0.5 */
    {"one lifts off",
     2,
     2,
     {2, 0, 1, 0, 0, 1, 0, 0, 1, 0, 2, 0, 0, 0, 0, 1},
     {-2, 0, -.5, 9},
     1,
     {1, 0, 0, 0}},
    {"C11",
     2,
     2,
     {1, 1, 0, -1, 1, 2, 1, -2, 0, 1, 3, 0, -1, -2, 0, 3},
     {-1, 1, -1, 0},
     1,
     {3, -3, 4. / 3, -1}},
    {"C12b",
     2,
     2,
     {3, 1, 0, 1, 1, 2, 2, 0, 0, 2, 3, 0, 1, 0, 0, 1},
     {-2, 0, -1, 0},
     2,
     {6, -10, 7, -6}},
    {"C13",
     2,
     2,
     {4, 1, 0, -1, 1, 1, -1, 0, 0, -1, 4, -1, -1, 0, -1, 1},
     {0, 1, -1, -1},
     2,
     {.25, -.5, .25, .5}},
    {"C14",
     2,
     2,
     {3, 0, -2, 0, 0, 2, 0, -1, -2, 0, 3, -2, 0, -1, -2, 3},
     {0, 0, -1, -2},
     1,
     {26, 16, 39, 32}},
    {"C15",
     2,
     2,
     {3, 0, -1, 1, 0, 3, -2, 1, -1, -2, 2, 0, 1, 1, 0, 4},
     {-2, 0, -2, -1},
     2,
     {34, 59, 77, -23}},
    {"C7 in 3D", 3, 1, {1, -1, 0, -1, 2, 0, 0, 0, 2}, {-1, -3, 0}, 2, {5, 4, 0}},
    {"C16", 3, 1, {2, -1, 2, -1, 2, 0, 2, 0, 3}, {-1, 4, 3}, 1, {6, 1, -5}},
    {"slip in 3D", 3, 1, {2, 0, 0, 0, 1, 0, 0, 0, 1}, {-2, 3, 4}, 1, {1, -.6, -.8}},
};

const hand_case jammed[jammed_count] = {
    {"C3", 2, 1, {1, 1, 1, 1}, {-2, 0}, 1, {1, -1}},
    {"C3 above", 2, 1, {1, 1, 1, 1}, {-2, 0}, 2, {1, -1}},
    {"C4",
     2,
     2,
     {1, 0, -1, 0, 0, 1, 0, 1, -1, 0, 1, 0, 0, 1, 0, 1},
     {-1, 0, -1, 0},
     .3,
     {1, 0, 1, 0}},
    {"C3 in 3D", 3, 1, {1, 1, 0, 1, 1, 0, 0, 0, 1}, {-2, 0, 0}, 2, {1, -1, 0}},
    {"W = 0", 2, 1, {0}, {-1, 0}, 1, {1, 0}},
};

const hand_case ambiguous_case = {"C1", 2, 1, {1, 1, 1, 2}, {1, 4}, 2, {2, -3}};
const hand_case hyperstatic_case = {
    "C5", 2, 2, {1, 0, 1, 0, 0, 1, 0, 1, 1, 0, 1, 0, 0, 1, 0, 1}, {-1, .25, -1, .25}, .5, {0}};

const hand_case *hand_named(const char *name) {
  for (int k = 0; k < hand_count; k++)
    if (strcmp(hand[k].name, name) == 0) return &hand[k];
  ck_abort_msg("no case %s", name);
  return NULL;
}

void set_hand(model *a, const hand_case *k) {
  const int m = k->d * k->nc;
  set_model(a, k->d, k->nc);
  for (int i = 0; i < m; i++) {
    a->q[i] = k->q[i];
    for (int j = 0; j < m; j++)
      a->W[i + m * j] = k->W[m * i + j];
  }
  for (int c = 0; c < k->nc; c++)
    a->mu[c] = k->mu;
}

/* ---- what every solver owes ------------------------------------------------------------------ */

typedef union settings {
  char bytes[256];
  double alignment;
  void *pointer;
} settings;

static void init(const tested_solver *s, settings *to, double tol, int warm_start) {
  ck_assert(s->settings_size <= sizeof *to);
  s->init(s, to, tol, warm_start);
}

dls_status run_in(const tested_solver *s, void *work, const dls_contact *p, double tol, double *r,
                  double *u, dls_info *info) {
  dls_error error;
  const dls_status status = s->solve(work, p, r, u, info, &error);
  ck_assert_int_ge(status, 0);
  ck_assert_int_eq(info->status, status);
  ck_assert_int_eq(info->method, s->method);
  dls_certificate c;
  double v[most];
  ck_assert_int_eq(dls_contact_certify(p, r, v, &c, &error), DLS_OK);
  ck_assert(c.residual_u == info->certificate.residual_u && c.floor_u == info->certificate.floor_u);
  ck_assert(c.residual_r == info->certificate.residual_r && c.floor_r == info->certificate.floor_r);
  ck_assert(info->certificate.residual == fmax(c.residual_u, c.residual_r));
  ck_assert_int_eq(status == DLS_OK, dls_certificate_holds(&c, tol));
  if (u) ck_assert_mem_eq(u, v, (size_t)(p->d * p->nc) * sizeof *u);
  return status;
}

dls_status run_with(const tested_solver *s, const dls_contact *p, const void *given, double tol,
                    double *r, double *u, dls_info *info) {
  void *work;
  ck_assert_int_eq(s->create(&work, p->d, p->nc, given, NULL), DLS_OK);
  const dls_status status = run_in(s, work, p, tol, r, u, info);
  s->destroy(work);
  return status;
}

static void same_work(const dls_info *a, const dls_info *b) {
  ck_assert_int_eq(a->iterations, b->iterations);
  ck_assert_int_eq(a->factorisations, b->factorisations);
  ck_assert_int_eq(a->sweeps, b->sweeps);
}

double close_of(const model *a) { /* |W^-1| (|F| + |F'|) or so, W >= I / 10 */
  return 1000 * 1e-12 * norm_of(a->q, a->p.d * a->p.nc);
}

void expect_answer_of(const tested_solver *s, int i, dls_method other) {
  static model a;
  numbered_model(&a, i);
  const double tol = s->tol > 0 ? s->tol : 1e-12;
  settings own;
  init(s, &own, tol, 0);
  dls_solver_settings others;
  dls_solver_settings_init(&others);
  others.method = other;
  others.limits.tol = tol;
  double r[most], u[most], r2[most];
  dls_info info;
  ck_assert_int_eq(run_with(s, &a.p, &own, tol, r, u, &info), DLS_OK);
  ck_assert_int_eq(dls_solve(&a.p, &others, r2, NULL, NULL, NULL), DLS_OK);
  for (int k = 0; k < a.p.d * a.p.nc; k++)
    ck_assert(fabs(r[k] - r2[k]) <= close_of(&a) * (tol / 1e-12));
}

void expect_same_answer(const tested_solver *s, int i, const void *given) {
  static model a;
  numbered_model(&a, i);
  settings own;
  init(s, &own, 1e-12, 0);
  double r[most], r2[most];
  dls_info info;
  ck_assert_int_eq(run_with(s, &a.p, &own, 1e-12, r, NULL, &info), DLS_OK);
  ck_assert_int_eq(run_with(s, &a.p, given, 1e-12, r2, NULL, &info), DLS_OK);
  for (int k = 0; k < a.p.d * a.p.nc; k++)
    ck_assert(fabs(r[k] - r2[k]) <= close_of(&a));
}

void expect_solved(const tested_solver *s, int i) {
  static model a, b;
  static block_storage B;
  numbered_model(&a, i);
  const double tol = s->tol > 0 ? s->tol : 1e-12;
  const int m = a.p.d * a.p.nc;
  const size_t bytes = (size_t)m * sizeof(double);
  const double close = close_of(&a) * (tol / 1e-12);
  settings cold, warm;
  init(s, &cold, tol, 0);
  init(s, &warm, tol, 1);
  double r[most], u[most], r2[most];
  dls_info info, info2;
  ck_assert_int_eq(run_with(s, &a.p, &cold, tol, r, u, &info), DLS_OK);
  ck_assert(info.certificate.residual <= tol);

  /* again: the same bits */
  ck_assert_int_eq(run_with(s, &a.p, &cold, tol, r2, NULL, &info2), DLS_OK);
  ck_assert_mem_eq(r, r2, bytes);
  same_work(&info, &info2);

  /* from the answer: nothing to do */
  ck_assert_int_eq(run_with(s, &a.p, &warm, tol, r2, NULL, &info2), DLS_OK);
  for (int k = 0; s->restarts && k < m; k++)
    ck_assert(fabs(r[k] - r2[k]) <= close);
  if (!s->restarts) {
    ck_assert_mem_eq(r, r2, bytes);
    ck_assert(info2.iterations == 0 && info2.sweeps == 0 && info2.factorisations == 0);
  }

  /* from anywhere, off the cone too */
  for (int k = 0; k < m; k++)
    r2[k] = 5 * uniform();
  ck_assert_int_eq(run_with(s, &a.p, &warm, tol, r2, NULL, &info2), DLS_OK);
  for (int k = 0; k < m; k++)
    ck_assert(fabs(r[k] - r2[k]) <= close);

  /* W by blocks: the same bits, but for auto, which may take other steps */
  const dls_contact blockwise = by_blocks(&a, &B);
  ck_assert_int_eq(run_with(s, &blockwise, &cold, tol, r2, NULL, &info2), DLS_OK);
  for (int k = 0; k < m; k++)
    ck_assert(fabs(r[k] - r2[k]) <= close);
  if (s->method != DLS_AUTO) ck_assert_mem_eq(r, r2, bytes);

  /* candidates in reverse order: the same answer */
  reverse_model(&b, &a);
  ck_assert_int_eq(run_with(s, &b.p, &cold, tol, r2, NULL, &info2), DLS_OK);
  for (int k = 0; k < m; k++)
    ck_assert(fabs(r[k] - r2[reversed(&a, k)]) <= close);
}

void expect_any_units(const tested_solver *s, const model *a, const void *given, double tol,
                      int two) {
  static model b;
  const int m = a->p.d * a->p.nc;
  double r[most], r2[most];
  dls_info info, info2;
  ck_assert_int_eq(run_with(s, &a->p, given, tol, r, NULL, &info), DLS_OK);
  const double size = 1 + norm_of(r, m);
  for (int length = -1; length <= 1; length++)
    for (int force = -1; force <= 1; force++) {
      /* W in units of 2^-62, 2^-31, 2^-1, 1, 2^30, 2^60: even powers and odd ones, whose square
       * roots are rounded */
      const double al = two ? ldexp(1, length < 0 ? -31 : 30 * length) : pow(10, 9 * length);
      const double be = two ? ldexp(1, force > 0 ? 31 : 30 * force) : pow(10, 9 * force);
      scale_model(&b, a, al, be);
      ck_assert_int_eq(run_with(s, &b.p, given, tol, r2, NULL, &info2), DLS_OK);
      same_work(&info, &info2);
      for (int k = 0; k < m; k++)
        ck_assert(fabs(r2[k] - be * r[k]) <= (two ? 0 : 1e-9 * be * size));
    }
}

void expect_any_tangents(const tested_solver *s, int i) {
  static model a, b;
  numbered_model(&a, 2 * i + 1);
  ck_assert_int_eq(a.p.d, 3);
  double angle[most], r[most], r2[most];
  for (int c = 0; c < a.p.nc; c++)
    angle[c] = 3 * uniform();
  turn_model(&b, &a, angle);
  const double tol = s->tol > 0 ? s->tol : 1e-10;
  settings cold;
  init(s, &cold, tol, 0);
  dls_info info, info2;
  ck_assert_int_eq(run_with(s, &a.p, &cold, tol, r, NULL, &info), DLS_OK);
  ck_assert_int_eq(run_with(s, &b.p, &cold, tol, r2, NULL, &info2), DLS_OK);
  if (s->method != DLS_LEMKE) same_work(&info, &info2); /* facets do not turn along */
  const double close = close_of(&a) * (tol / 1e-12);
  turn_vector(&a, angle, r);
  for (int k = 0; k < 3 * a.p.nc; k++)
    ck_assert(fabs(r2[k] - r[k]) <= (s->method == DLS_LEMKE ? close : 1e-11));
}

void expect_floor(const tested_solver *s, int i) {
  static model a;
  numbered_model(&a, i);
  settings exact;
  init(s, &exact, 0, 0);
  double r[most];
  dls_info info;
  ck_assert_int_eq(run_with(s, &a.p, &exact, 0, r, NULL, &info), DLS_OK);
  ck_assert(info.certificate.residual_u <= 4 * info.certificate.floor_u);
  ck_assert(info.certificate.residual_r <= 4 * info.certificate.floor_r);
}

void expect_reuse(const tested_solver *s, const model *a, const model *b) {
  ck_assert(a->p.d == b->p.d && a->p.nc > b->p.nc);
  const double tol = s->tol > 0 ? s->tol : 1e-10;
  settings cold;
  init(s, &cold, tol, 0);
  void *work;
  double r[most], r2[most];
  dls_info info;
  ck_assert_int_eq(s->create(&work, a->p.d, a->p.nc, &cold, NULL), DLS_OK);
  malloc_fails_at(0);
  const dls_status first = s->solve(work, &a->p, r, NULL, NULL, NULL);
  const dls_status second = s->solve(work, &b->p, r, NULL, NULL, NULL);
  const long calls = malloc_calls(); /* Check allocates, too */
  ck_assert(first == DLS_OK && second == DLS_OK && calls == 0);
  ck_assert_int_eq(run_with(s, &b->p, &cold, tol, r2, NULL, &info), DLS_OK);
  ck_assert_mem_eq(r, r2, (size_t)(b->p.d * b->p.nc) * sizeof *r);
  s->destroy(work);
}

void expect_memory(const tested_solver *s, int d, int nc, const void *given, double bytes,
                   double slack) {
  dls_error error;
  void *work;
  long k = 1;
  for (;; k++) {
    malloc_fails_at(k);
    const dls_status status = s->create(&work, d, nc, given, &error);
    const double got = (double)malloc_bytes();
    malloc_fails_at(0);
    if (status == DLS_OK) {
      ck_assert_msg(got >= bytes && got <= bytes + slack, "%.0f bytes, not %.0f", got, bytes);
      break;
    }
    ck_assert_int_eq(status, DLS_E_MEMORY);
    ck_assert_ptr_null(work);
  }
  ck_assert_int_gt(k, 1);
  s->destroy(work);
}

void expect_solve_unwinds(const tested_solver *s, void *work, const dls_contact *p, double *r) {
  dls_error error;
  r[0] = 9;
  long k = 1;
  for (;; k++) {
    malloc_fails_at(k);
    const dls_status status = s->solve(work, p, r, NULL, NULL, &error);
    malloc_fails_at(0);
    if (status == DLS_OK) break;
    ck_assert_int_eq(status, DLS_E_MEMORY);
    ck_assert_mem_eq(error.function, s->name, strlen(s->name));
    ck_assert_str_eq(error.function + strlen(s->name), "_solve");
    ck_assert(r[0] == 9);
  }
  ck_assert_int_gt(k, 1);
}

void expect_sparse_is_dense(const tested_solver *s, void *work, int singular, double tol, double *r,
                            dls_info info[2]) {
  dls_contact dense, blocks;
  row_problem(singular, &dense, &blocks);
  double r2[row_m], r3[row_m];
  ck_assert_int_eq(s->solve(work, &dense, r, NULL, &info[0], NULL), DLS_OK);
  ck_assert_int_eq(s->solve(work, &blocks, r2, NULL, &info[1], NULL), DLS_OK);
  for (int k = 0; !singular && k < row_m; k++)
    ck_assert(fabs(r[k] - r2[k]) <= tol);
  ck_assert_int_eq(s->solve(work, &blocks, r3, NULL, NULL, NULL), DLS_OK);
  ck_assert_mem_eq(r2, r3, sizeof r2);

  /* W in a unit that is an odd power of two */
  double x[3 * row_nc * 4];
  for (int k = 0; k < 4 * blocks.Wb.p[row_nc]; k++)
    x[k] = 8 * blocks.Wb.x[k];
  blocks.Wb.x = x;
  ck_assert_int_eq(s->solve(work, &blocks, r3, NULL, NULL, NULL), DLS_OK);
  for (int k = 0; k < row_m; k++)
    ck_assert(8 * r3[k] == r2[k]);
}

void expect_no_allocation(const tested_solver *s, void *work, const dls_contact *p, double *r) {
  malloc_fails_at(0);
  const dls_status status = s->solve(work, p, r, NULL, NULL, NULL);
  const long calls = malloc_calls(); /* Check allocates, too */
  ck_assert(status == DLS_OK && calls == 0);
}

void expect_no_answer(const tested_solver *s, const dls_contact *p, const void *given) {
  double r[most];
  dls_info info;
  const dls_status status = run_with(s, p, given, 1e-8, r, NULL, &info);
  ck_assert_msg(status == DLS_STALLED || status == DLS_MAX_ITERATIONS, "%s: %d, %g", s->name,
                (int)status, info.certificate.residual);
  ck_assert(info.certificate.residual > 0.1 && info.certificate.residual <= 1 + 1e-15);
}

/* ---- bad input ------------------------------------------------------------------------------- */

void refuses_to_create(const tested_solver *s, dls_status status, const char *argument,
                       long long index, int d, int nc, const void *given) {
  dls_error error = {0};
  void *work = &error; /* must become NULL */
  ck_assert_int_eq(s->create(&work, d, nc, given, &error), status);
  ck_assert_ptr_null(work);
  ck_assert_int_eq(error.status, status);
  ck_assert_mem_eq(error.function, s->name, strlen(s->name));
  ck_assert_str_eq(error.function + strlen(s->name), "_create");
  ck_assert_str_eq(error.argument, argument);
  ck_assert(error.index == index);
  ck_assert_int_eq(s->create(&work, d, nc, given, NULL), status);
}

void expect_bad_create(const tested_solver *s) {
  settings good, bad;
  init(s, &good, 1e-8, 0);
  dls_error error;
  ck_assert_int_eq(s->create(NULL, 2, 1, &good, &error), DLS_E_ARGUMENT);
  ck_assert_str_eq(error.argument, "out");
  refuses_to_create(s, DLS_E_ARGUMENT, "d", -1, 0, 1, &good);
  refuses_to_create(s, DLS_E_ARGUMENT, "d", -1, 4, 1, &good);
  refuses_to_create(s, DLS_E_SIZE, "nc", -1, 2, -1, &good);
  refuses_to_create(s, DLS_E_SIZE, "nc", -1, 3, INT_MAX, &good);
  void *work;
  ck_assert_int_eq(s->create(&work, 2, 1, NULL, &error), DLS_OK); /* the defaults */
  s->destroy(work);
  memset(&bad, 0, sizeof bad);
  refuses_to_create(s, DLS_E_SETTINGS, "settings", -1, 2, 1, &bad);
  const double bad_tol[] = {-1, NAN, INFINITY};
  for (int k = 0; k < 3; k++) {
    init(s, &bad, bad_tol[k], 0);
    refuses_to_create(s, DLS_E_ARGUMENT, "tol", -1, 2, 1, &bad);
  }
  init(s, &bad, 1e-8, 2);
  refuses_to_create(s, DLS_E_ARGUMENT, "warm_start", -1, 2, 1, &bad);
  init(s, &bad, 1e-8, 0);
  s->limits(&bad)->max_iterations = -1;
  refuses_to_create(s, DLS_E_ARGUMENT, "max_iterations", -1, 2, 1, &bad);
  init(s, &bad, 1e-8, 0);
  s->limits(&bad)->blocks = -1;
  refuses_to_create(s, DLS_E_ARGUMENT, "blocks", -1, 2, 1, &bad);
  s->destroy(NULL);
}

static void refuses_to_solve(const tested_solver *s, void *work, dls_status status,
                             const char *argument, long long index, const dls_contact *p,
                             double *r) {
  dls_error error = {0};
  dls_info info, same_info;
  double u[most], same_u[most], same_r[most];
  memset(&info, 7, sizeof info);
  memset(u, 7, sizeof u);
  same_info = info;
  memcpy(same_u, u, sizeof u);
  if (r) memcpy(same_r, r, sizeof same_r);
  ck_assert_int_eq(s->solve(work, p, r, u, &info, &error), status);
  ck_assert_mem_eq(error.function, s->name, strlen(s->name));
  ck_assert_str_eq(error.function + strlen(s->name), "_solve");
  ck_assert_str_eq(error.argument, argument);
  ck_assert(error.index == index);
  ck_assert_mem_eq(&info, &same_info, sizeof info);
  ck_assert_mem_eq(u, same_u, sizeof u);
  if (r) ck_assert_mem_eq(r, same_r, sizeof same_r);
}

void expect_bad_solve(const tested_solver *s) {
  static model a, b;
  numbered_model(&a, 6); /* 2D, 7 candidates */
  settings warm;
  init(s, &warm, 1e-8, 1);
  void *work, *small, *other;
  ck_assert_int_eq(s->create(&work, 2, 7, &warm, NULL), DLS_OK);
  ck_assert_int_eq(s->create(&small, 2, 6, &warm, NULL), DLS_OK);
  ck_assert_int_eq(s->create(&other, 3, 7, &warm, NULL), DLS_OK);
  double r[most] = {0};
  refuses_to_solve(s, NULL, DLS_E_ARGUMENT, s->workspace, -1, &a.p, r);
  refuses_to_solve(s, work, DLS_E_ARGUMENT, "problem", -1, NULL, r);
  refuses_to_solve(s, small, DLS_E_SIZE, "problem", -1, &a.p, r);
  refuses_to_solve(s, other, DLS_E_SIZE, "problem", -1, &a.p, r);
  refuses_to_solve(s, work, DLS_E_ARGUMENT, "r", -1, &a.p, NULL);
  r[3] = INFINITY;
  refuses_to_solve(s, work, DLS_E_NOT_FINITE, "r", 3, &a.p, r);
  r[3] = 0;
#define WITH(change, status, argument, index)                                                      \
  do {                                                                                             \
    copy_model(&b, &a);                                                                            \
    change;                                                                                        \
    refuses_to_solve(s, work, status, argument, index, &b.p, r);                                   \
  } while (0)
  WITH(b.W[15] = NAN, DLS_E_NOT_FINITE, "W", 15);
  WITH(b.q[2] = -INFINITY, DLS_E_NOT_FINITE, "q", 2);
  WITH(b.mu[4] = NAN, DLS_E_NOT_FINITE, "mu", 4);
  WITH(b.mu[4] = -1, DLS_E_ARGUMENT, "mu", 4);
  WITH(b.p.q = NULL, DLS_E_ARGUMENT, "q", -1);
  WITH(b.p.mu = NULL, DLS_E_ARGUMENT, "mu", -1);
  WITH(b.p.W.a = NULL, DLS_E_ARGUMENT, "W", -1);
  WITH(b.p.W.ld = 3, DLS_E_SIZE, "W", -1);
  WITH(b.p.nc = -1, DLS_E_SIZE, "nc", -1);
  WITH(b.p.d = 5, DLS_E_ARGUMENT, "d", -1);
#undef WITH
  s->destroy(work);
  s->destroy(small);
  s->destroy(other);
}

int look(void *data, const dls_progress *progress) {
  watch *w = data;
  if (progress->last) return 0;
  w->calls++;
  if (w->method) {
    ck_assert_int_eq(progress->iteration, w->calls);
    ck_assert_str_eq(progress->method, w->method);
    ck_assert_str_eq(progress->stage, w->method);
    ck_assert_int_eq(progress->max_iterations, w->max_iterations);
  }
  if (progress->residual >= 0 && progress->residual < w->least) w->least = progress->residual;
  return w->calls == w->cancel_at;
}
