/*
 * test_judges.c: tests the judges of tests/properties: right answers made by hand pass; answers
 * that are only a little worse than allowed fail.
 */
#include "bodies.h"
#include "check.h"
#include "generate.h"
#include "problem.h"
#include "rest.h"
#include "run.h"

/* ---- contact problems ------------------------------------------------------------------------ */

/* d = 1, three candidates, the last one open and far away: r = (1, 2, 0) to the last bit. */
static void fill_open(problem *p, double far) {
  static const double W[9] = {1, 0.5, 0, 0.5, 1, 0, 0, 0, 0x1p-40};
  problem_resize(p, 1, 3);
  memcpy(p->W, W, sizeof W);
  p->kind = SOLVABLE;
  p->r[0] = 1, p->r[1] = 2, p->r[2] = 0;
  p->u[2] = far;
  plant_q(p);
}

TEST(an_open_candidate_hides_no_wrong_answer) {
  problem p = {0};
  measure is;
  truth t;
  fill_open(&p, 1e15);
  ck_assert_int_eq(p.exact, 1);
  measure_answer(&p, p.r, &is);
  ck_assert_double_eq(is.u, 0);
  ck_assert_double_eq(is.r, 0);
  ck_assert(measure_holds(&is, 1e-12, 1, 1e-8, 1));
  judge_truth(&p, p.r, 1e-8, 1, &t);
  ck_assert_int_eq(t.verdict, TRUTH_HOLDS);
  const double wrong[3] = {1, 2.03, 0}; /* by more than a per cent */
  measure_answer(&p, wrong, &is);
  ck_assert(!measure_holds(&is, 1e-8, 1, 1e-8, 1));
  judge_truth(&p, wrong, 1e-8, 1, &t);
  ck_assert_int_eq(t.verdict, TRUTH_WRONG_R);
  ck_assert_double_eq_tol(t.error, 0.03 / sqrt(5), 1e-6);
  const double near[3] = {1, 2 + 1e-5, 0}; /* the condition is about 2 */
  judge_truth(&p, near, 1e-8, 1, &t);
  ck_assert_int_eq(t.verdict, TRUTH_HOLDS);
  judge_truth(&p, near, 1e-10, 1, &t);
  ck_assert_int_eq(t.verdict, TRUTH_WRONG_R);
  free(p.W);
}

/* W = diag(1e-8, 1), q = (-1, .3): r = (1e8, -.3) sticks, and rounding hides nothing of it. */
TEST(weights_of_normal_and_tangent) {
  problem p = {0};
  measure is;
  const double r[2] = {1e8, -0.3};
  problem_resize(&p, 2, 1);
  p.W[0] = 1e-8;
  p.W[3] = 1;
  p.q[0] = -1, p.q[1] = 0.3;
  p.mu[0] = 0.5;
  measure_answer(&p, r, &is);
  ck_assert(measure_holds(&is, 1e-14, 1, 1e-14, 1));
  free(p.W);
}

/* A bonded candidate sticks whatever its drag, and has no reaction where it is open. */
TEST(infinite_friction) {
  problem p = {0};
  measure is;
  truth t;
  problem_resize(&p, 2, 2);
  for (int i = 0; i < 4; i++)
    p.W[5 * i] = 1;
  p.kind = SOLVABLE;
  p.mu[0] = p.mu[1] = INFINITY;
  p.r[0] = 1, p.r[1] = 1000;
  p.u[2] = 1, p.u[3] = 5;
  plant_q(&p);
  ck_assert_int_eq(p.exact, 1);
  measure_answer(&p, p.r, &is);
  ck_assert_double_eq(is.u, 0);
  judge_truth(&p, p.r, 1e-8, 1, &t);
  ck_assert_int_eq(t.verdict, TRUTH_HOLDS);
  const double wrong[4] = {1, 985, 0, 0};
  measure_answer(&p, wrong, &is);
  ck_assert_double_ge(is.u, 0.01);
  judge_truth(&p, wrong, 1e-8, 1, &t);
  ck_assert_int_eq(t.verdict, TRUTH_WRONG_R);
  free(p.W);
}

/* r determined by nothing: two candidates that press at the same place. */
TEST(an_answer_that_is_not_determined_is_no_error) {
  problem p = {0};
  truth t;
  problem_resize(&p, 1, 2);
  for (int i = 0; i < 4; i++)
    p.W[i] = 1;
  p.kind = SOLVABLE;
  p.r[0] = 1, p.r[1] = 2;
  plant_q(&p);
  const double other[2] = {2, 1};
  judge_truth(&p, other, 1e-8, 1, &t);
  ck_assert_int_eq(t.verdict, TRUTH_UNKNOWN);
  free(p.W);
}

/* A second answer is as true as the planted one: mu = 3 and W_nt lift the body where it sticks. */
TEST(another_answer_is_true_too) {
  problem p = {0};
  truth t;
  static const double W[4] = {1, -1, -1, 2};
  problem_resize(&p, 2, 1);
  memcpy(p.W, W, sizeof W);
  p.kind = SOLVABLE;
  p.mu[0] = 3;
  p.r[0] = 1, p.r[1] = 2; /* sticks: q = (1, -3) */
  plant_q(&p);
  const double open[2] = {0, 0}; /* u = q: u_n = 1 > 0 */
  judge_truth(&p, open, 1e-8, 1, &t);
  ck_assert_int_eq(t.verdict, TRUTH_OTHER);
  free(p.W);
}

/* Tangents 1e9 times softer than normals: what rounds in u_n rounds 1e9 times in the friction. */
TEST(another_answer_with_soft_tangents) {
  problem p = {0};
  truth t;
  measure is;
  static const double W[16] = {2.98,   -33900, -0.448, -6290,  -33900, 4.37e9, 59200,  0,
                               -0.448, 59200,  8.97,   -49300, -6290,  0,      -49300, 4.37e9};
  static const double q[4] = {-10991.275459999999, 1417199238.6999998, 19227.67746,
                              -2656334.6999999997};
  static const double r[4] = {0.47, -0.3243, 0.13, 0.00061};
  problem_resize(&p, 2, 2);
  memcpy(p.W, W, sizeof W);
  p.kind = SOLVABLE;
  p.mu[0] = 0.69, p.mu[1] = 0.9;
  for (int load = 1; load <= 20; load++) { /* loads, so that other digits round */
    for (int i = 0; i < 4; i++) {
      p.q[i] = load / 3. * q[i];
      p.r[i] = load / 3. * r[i];
    }
    /* contact 1 open; contact 0 slips: (2.98 + 0.69 33900) r_n = -q_n */
    const double n = -p.q[0] / (2.98 + 0.69 * 33900), other[4] = {n, -0.69 * n, 0, 0};
    measure_answer(&p, other, &is);
    ck_assert(measure_holds(&is, 1e-12, 1, 1e-8, 1));
    judge_truth(&p, other, 1e-8, 1, &t);
    ck_assert_int_eq(t.verdict, TRUTH_OTHER);
  }
  free(p.W);
}

TEST(sums_are_rounded_once) {
  exact sum;
  exact_clear(&sum);
  exact_add(&sum, 1e300, 1, 1);
  exact_add(&sum, 3, -7, 0.5);
  exact_add(&sum, -1e300, 1, 1);
  ck_assert_double_eq(exact_round(&sum), -10.5);
  exact_clear(&sum);
  exact_add(&sum, 1, 1, 1);
  exact_add(&sum, 0x1p-80, 1, 1);
  ck_assert_double_eq(exact_round(&sum), 1);
}

/* ---- stacks ---------------------------------------------------------------------------------- */

/* x, r of a stack whose candidates all stick: K x - H r = f, H' x = 0, by Gauss's elimination. */
static void solve_stuck(const stack *s, double *x, double *r) {
  const int m = s->n + 2 * s->nc;
  long double *A = problem_alloc((size_t)m * (size_t)(m + 1) * sizeof *A);
#define AT(i, j) A[(size_t)(i) + (size_t)(j) * (size_t)m]
  for (int j = 0; j < s->n; j++) {
    AT(j, m) = s->f[j];
    for (int k = s->K.p[j]; k < s->K.p[j + 1]; k++)
      AT(s->K.i[k], j) += s->K.x[k];
  }
  for (int c = 0; c < s->nc; c++)
    for (int t = 0; t < 2; t++) {
      const dls_sparse *H = t ? &s->HT : &s->HN;
      for (int k = H->p[c]; k < H->p[c + 1]; k++) {
        AT(H->i[k], s->n + 2 * c + t) = -H->x[k];
        AT(s->n + 2 * c + t, H->i[k]) = H->x[k];
      }
    }
  for (int k = 0; k < m; k++) {
    int at = k;
    for (int i = k; i < m; i++)
      if (fabsl(AT(i, k)) > fabsl(AT(at, k))) at = i;
    for (int j = 0; j <= m; j++) {
      const long double t = AT(k, j);
      AT(k, j) = AT(at, j);
      AT(at, j) = t;
    }
    for (int i = 0; i < m; i++)
      for (int j = m; i != k && AT(i, k) != 0 && j >= k; j--)
        AT(i, j) -= AT(i, k) / AT(k, k) * AT(k, j);
  }
  for (int i = 0; i < m; i++)
    (i < s->n ? x : r - s->n)[i] = (double)(AT(i, m) / AT(i, i));
#undef AT
  free(A);
}

/* Returns 1 if no candidate pulls or leaves its cone. */
static int is_inside(const stack *s, const double *r) {
  for (int c = 0; c < s->nc; c++)
    if (!(r[2 * c] > 0 && fabs(r[2 * c + 1]) <= s->mu[c] * r[2 * c])) return 0;
  return 1;
}

TEST(stacks_and_their_statics) {
  stack s = {0};
  int solved = 0, kinds[5] = {0};
  for (uint64_t seed = 2; seed < 400; seed += 2) {
    stack_generate(seed, &s);
    kinds[s.kind]++;
    if (s.n > 120) continue;
    double *x = problem_alloc((size_t)s.n * sizeof *x);
    double *r = problem_alloc(2 * (size_t)s.nc * sizeof *r);
    solve_stuck(&s, x, r);
    const int inside = is_inside(&s, r);
    /* an answer that meets the laws: statics has to agree */
    if (inside) ck_assert(s.kind == STANDS || s.kind == ON_EDGE);
    if (!inside || s.kind != STANDS) {
      free(x);
      free(r);
      continue;
    }
    solved++;
    ck_assert_int_eq(stack_judge(&s, DLS_OK, x, r, 1e-8), STACK_GOOD);
    ck_assert_int_eq(stack_judge(&s, DLS_STALLED, x, r, 1e-8), STACK_DENIED);
    ck_assert_int_eq(stack_judge(&s, DLS_NOT_IN_EQUILIBRIUM, x, r, 1e-8), STACK_DENIED);
    for (int c = 0; c < 2 * s.nc; c++) /* a spring carries the rest */
      r[c] *= 0.999;
    ck_assert_int_eq(stack_judge(&s, DLS_OK, x, r, 1e-8), STACK_BLOCK);
    for (int c = 0; c < 2 * s.nc; c++)
      r[c] /= 0.999;
    x[0] += 1e-3 * (1 + fabs(x[0]));
    ck_assert_int_eq(stack_judge(&s, DLS_OK, x, r, 1e-8), STACK_NODES);
    free(x);
    free(r);
  }
  ck_assert_int_ge(solved, 10);
  for (int k = 0; k < 5; k++)
    ck_assert_int_gt(kinds[k], 3);
  stack_free(&s);
}

TEST(what_cannot_stand_is_not_solved) {
  stack s = {0};
  for (uint64_t seed = 2; seed < 100; seed += 2) {
    stack_generate(seed, &s);
    if (s.kind == STANDS || s.kind == ON_EDGE) continue;
    double *x = problem_alloc((size_t)s.n * sizeof *x);
    double *r = problem_alloc(2 * (size_t)s.nc * sizeof *r);
    ck_assert_int_eq(stack_judge(&s, DLS_OK, x, r, 1e-8), STACK_CLAIMED);
    ck_assert_int_eq(stack_judge(&s, DLS_NOT_IN_EQUILIBRIUM, x, r, 1e-8), STACK_GOOD);
    free(x);
    free(r);
  }
  stack_free(&s);
}

/* 21 contacts in 3D, on which all but the homotopy fails: the residual of its answer is below 1e-8,
 * and the reactions are off by a tenth. The library has to say so. */
TEST(a_hard_solve_tells_its_error) {
  static problem p;
  static verdict v;
  const options ask = {1e-8};
  int class = 0;
  while (strcmp(class_name[class], "slight") != 0)
    class ++;
  generate(class, 5300002725, &p);
  check_problem(&p, 5300002725, &ask, &v);
  ck_assert_int_eq(v.solved, 1);
  ck_assert_int_eq(v.findings, 0);
}

/* ---- bodies at rest -------------------------------------------------------------------------- */

/* Planted answers pass, and fail with 1e-3 of a force, of a place of a contact that carries, or of
 * the motion of a free body against another; what falls is never solved. */
TEST(bodies_at_rest) {
  static rest p;
  int moved = 0, forced = 0;
  for (int of = 0; of < REST_KINDS; of++)
    for (uint64_t seed = 1; seed <= 200; seed++) {
      rest_generate((rest_kind)of, seed, &p);
      if (of == REST_FALLS) {
        ck_assert_int_eq(rest_judge(&p, DLS_OK, p.x, p.r), REST_CLAIMED);
        ck_assert_int_eq(rest_judge(&p, DLS_STALLED, p.x, p.r), REST_RIGHT);
        for (int c = 0; c < p.nc; c++) { /* Farkas' motion */
          double v[2] = {0, 0};
          for (int i = 0; i < p.n; i++)
            for (int k = 0; k < 2; k++)
              v[k] += p.H[i][2 * c + k] * p.x[i];
          ck_assert(v[0] >= p.mu[c] * fabs(v[1]));
        }
        continue;
      }
      ck_assert_int_eq(rest_judge(&p, DLS_OK, p.x, p.r), REST_RIGHT);
      ck_assert_int_eq(rest_judge(&p, DLS_NO_SOLUTION, p.x, p.r), REST_DENIED);
      ck_assert_int_eq(rest_judge(&p, DLS_STALLED, p.x, p.r), REST_REFUSED);
      double r[2 * REST_CONTACTS], x[REST_UNKNOWNS];
      memcpy(r, p.r, sizeof r);
      memcpy(x, p.x, sizeof x);
      int c = 0;
      while (c < p.nc && !(r[2 * c] > 0))
        c++;
      if (c == p.nc) continue;
      r[2 * c] *= 1.01;
      forced += rest_judge(&p, DLS_OK, x, r) > REST_REFUSED;
      r[2 * c] = p.r[2 * c];
      for (int i = 0; i < p.n; i++)
        x[i] += p.H[i][2 * c] / 64;
      ck_assert_int_gt(rest_judge(&p, DLS_OK, x, r), REST_REFUSED);
      moved++;
    }
  ck_assert_int_gt(moved, 1000);
  ck_assert_int_ge(forced, moved * 9 / 10);
}
