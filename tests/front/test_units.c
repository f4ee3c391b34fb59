/*
 * test_units.c: r -> 2^b r, u and q -> 2^a u and 2^a q, W -> 2^(a-b) W change nothing but these
 * powers: the same status, facts and bits for a, b from -480 to 480.
 */
#include "cases.h"
#include "delassus.h"
#include "made.h"
#include "run.h"

/* What the library says of a problem; lengths and forces in units of the first one. */
typedef struct said {
  dls_status status;
  dls_info info;
  dls_proof proof;
  dls_sensitivity sensitivity;
  dls_certificate certificate;
  int freedom;
  double r[most], u[most], improved[most];
} said;

static void shift(double *x, int n, int power) {
  for (int i = 0; i < n; i++)
    x[i] = ldexp(x[i], power);
}

static void shift_certificate(dls_certificate *c, int a, int b) {
  c->penetration = ldexp(c->penetration, a);
  c->slip_direction = ldexp(c->slip_direction, a);
  c->adhesion = ldexp(c->adhesion, b);
  c->cone_violation = ldexp(c->cone_violation, b);
  c->complementarity = ldexp(c->complementarity, a + b);
}

static void ask(const dls_contact *p, dls_method method, int least, int a, int b, said *s) {
  const int m = p->d * p->nc;
  dls_solver_settings settings = settings_with(method, default_tol);
  settings.forces = least ? DLS_FORCES_LEAST : DLS_FORCES_ANY;
  memset(s, 0, sizeof *s);
  s->status = dls_solve(p, &settings, s->r, s->u, &s->info, NULL);
  ck_assert_int_ge(s->status, 0);
  ck_assert_int_eq(dls_contact_certify(p, s->r, NULL, &s->certificate, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_prove(p, s->r, &s->proof, s->improved, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_sensitivity(p, s->r, &s->sensitivity, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_freedom(p, s->r, &s->freedom, NULL), DLS_OK);
  shift(s->r, m, -b);
  shift(s->improved, m, -b);
  shift(s->u, m, -a);
  shift(&s->proof.box, 1, -a);
  shift_certificate(&s->certificate, -a, -b);
  shift_certificate(&s->info.certificate, -a, -b);
}

static void same_in_units(const said *one, const said *two, int m, const char *what) {
  const dls_certificate *c = &one->certificate, *d = &two->certificate;
  const dls_proof *p = &one->proof, *o = &two->proof;
  ck_assert_msg(one->status == two->status && one->info.unique == two->info.unique &&
                    one->info.forces == two->info.forces && one->freedom == two->freedom,
                "%s: status %d %d, unique %d %d, freedom %d %d", what, one->status, two->status,
                (int)one->info.unique, (int)two->info.unique, one->freedom, two->freedom);
  ck_assert_msg(one->info.error == two->info.error && c->residual_u == d->residual_u &&
                    c->residual_r == d->residual_r && c->floor_u == d->floor_u &&
                    c->floor_r == d->floor_r && c->worst == d->worst,
                "%s: error %g %g, residuals %g %g, %g %g", what, one->info.error, two->info.error,
                c->residual_u, d->residual_u, c->residual_r, d->residual_r);
  ck_assert_msg(c->penetration == d->penetration && c->cone_violation == d->cone_violation &&
                    c->slip_direction == d->slip_direction &&
                    c->complementarity == d->complementarity,
                "%s: laws", what);
  ck_assert_msg(p->kind == o->kind && p->freedom == o->freedom && p->border == o->border &&
                    fabs(p->radius - o->radius) <= 1e-6 * p->radius &&
                    fabs(p->error - o->error) <= 1e-6 * p->error,
                "%s: proof %d %d, radius %g %g", what, (int)p->kind, (int)o->kind, p->radius,
                o->radius);
  ck_assert_msg(one->sensitivity.rank == two->sensitivity.rank &&
                    one->sensitivity.border == two->sensitivity.border,
                "%s: sensitivity", what);
  ck_assert_msg(!memcmp(one->r, two->r, (size_t)m * sizeof(double)) &&
                    !memcmp(one->u, two->u, (size_t)m * sizeof(double)) &&
                    !memcmp(one->improved, two->improved, (size_t)m * sizeof(double)),
                "%s: bits", what);
}

static const int powers[][2] = {{480, -480}, {-480, 480}, {480, 480},   {-480, -480},
                                {65, 0},     {0, -65},    {-301, -250}, {129, -480}};
enum { power_count = sizeof powers / sizeof *powers };

/* W := 2^(a-b) W, q := 2^a q, in each storage: dense, by blocks, of bodies (an even power). */
static void one_problem(const model *a, dls_method method, int least, const char *what) {
  static model b;
  static block_storage B;
  said one, two;
  const int m = a->p.d * a->p.nc;
  ask(&a->p, method, least, 0, 0, &one);
  for (int k = 0; k < power_count; k++) {
    copy_model(&b, a);
    shift(b.W, m * m, powers[k][0] - powers[k][1]);
    shift(b.q, m, powers[k][0]);
    ask(&b.p, method, least, powers[k][0], powers[k][1], &two);
    same_in_units(&one, &two, m, what);
  }
  const dls_contact blocks = by_blocks(a, &B);
  ask(&blocks, method, least, 0, 0, &one);
  const dls_contact other = by_blocks(&b, &B);
  ask(&other, method, least, powers[power_count - 1][0], powers[power_count - 1][1], &two);
  same_in_units(&one, &two, m, what);
}

TEST_EACH(any_units, 0, 60) {
  static model a;
  if (_i % 2)
    deficient_model(&a, _i);
  else
    numbered_model(&a, _i);
  one_problem(&a, _i % 3 ? DLS_AUTO : (dls_method)(_i / 3 % 8), _i % 5 == 0, "drawn");
}

TEST_EACH(bodies_in_any_units, 0, 12) {
  static model a;
  static bodies_storage S;
  dls_contact p;
  said one, two;
  bodies_model(&a, &S, &p, _i);
  const int m = p.d * p.nc;
  ask(&p, DLS_AUTO, 0, 0, 0, &one);
  shift(S.H, (int)(sizeof S.H / sizeof *S.H), -200);
  double q[most];
  memcpy(q, p.q, (size_t)m * sizeof *q);
  shift(q, m, -70);
  p.q = q;
  ask(&p, DLS_AUTO, 0, -70, 330, &two);
  same_in_units(&one, &two, m, "bodies");
}

/* Two exact answers: never "proved unique", however small W is in its units. */
TEST(no_false_proof_of_uniqueness) {
  static const double W0[16] = {1, 0, -1, -1, 0, 1, -2, 0, -1, -2, 5, 1, -1, 0, 1, 1};
  for (int k = 0; k <= 700; k += 20) {
    double W[16], q[4] = {2, 10, -22, -2}, mu[2] = {0, .3}, r[4];
    dls_info info;
    memcpy(W, W0, sizeof W);
    shift(W, 16, -k);
    const dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu};
    ck_assert_int_eq(dls_solve(&p, NULL, r, NULL, &info, NULL), DLS_OK);
    ck_assert_int_ne(info.unique, DLS_UNIQUE_YES);
  }
}

/* Nothing is proved, or solved, of an r that the caller's units cannot hold. */
TEST(answers_out_of_range) {
  static const double size[][2] = {{0x1p-900, 0x1p900}, {0x1p900, 0x1p-900}, {0x1p-60, 0x1p1000}};
  for (int k = 0; k < 3; k++) {
    double W[4] = {size[k][0], 0, 0, size[k][0]}, q[2] = {-size[k][1] * 1.7, .3 * size[k][1]};
    double mu = .1, r[2], u[2];
    dls_info info;
    dls_proof proof;
    const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = &mu};
    const dls_status status = dls_solve(&p, NULL, r, u, &info, NULL);
    ck_assert_int_ge(status, 0);
    ck_assert(isfinite(r[0]) && isfinite(r[1]));
    ck_assert_int_ne(status, DLS_OK);
    ck_assert(!(info.certificate.residual <= 1e-8));
    ck_assert_int_eq(dls_contact_prove(&p, r, &proof, NULL, NULL), DLS_OK);
    ck_assert_int_eq(proof.kind, DLS_NOT_PROVED);
  }
}

static const dls_contact *watched;

static int see_progress(void *data, const dls_progress *progress) {
  dls_certificate c;
  int *calls = data;
  if (!progress->r) return 0;
  if (dls_contact_certify(watched, progress->r, NULL, &c, NULL))
    return 0;               /* no memory, on purpose */
  *calls += c.residual < 1; /* in other units r would be nothing, or everything */
  return 0;
}

/* A progress shows r in the units of the caller; a warm start begins in them; each malloc may
 * fail. */
TEST(progress_warm_start_and_memory) {
  static model a;
  double r[most], again[most];
  dls_info info;
  int calls = 0;
  numbered_model(&a, 4);
  const int m = a.p.d * a.p.nc;
  shift(a.W, m * m, 700);
  shift(a.q, m, 300);
  dls_solver_settings s = settings_with(DLS_AUTO, default_tol);
  s.limits.progress = see_progress;
  s.limits.progress_data = &calls;
  s.limits.warm_start = 1;
  watched = &a.p;
  memset(r, 0, sizeof r);
  dls_solver *solver = solver_of(a.p.d, a.p.nc, &s);
  dls_status status = DLS_E_MEMORY;
  for (long k = 1; status; k++) {
    malloc_fails_at(k);
    status = dls_solver_solve(solver, &a.p, r, NULL, &info, NULL);
    malloc_fails_at(0);
    ck_assert(status == DLS_OK || status == DLS_E_MEMORY);
    for (int i = 0; i < m && status; i++)
      ck_assert(r[i] == 0);
  }
  ck_assert_int_gt(calls, 0);
  memcpy(again, r, sizeof r);
  ck_assert_int_eq(dls_solver_solve(solver, &a.p, again, NULL, &info, NULL), DLS_OK);
  ck_assert_int_le(info.iterations, 1);
  ck_assert_double_le(info.certificate.residual, 1e-8);
  dls_solver_destroy(solver);
}
