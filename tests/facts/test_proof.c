/*
 * test_proof.c: the meaning of "no solution": exact sums, vectors near a proof, LCPs and contact
 * problems without a solution, with a far solution, and with one hidden by rounding.
 *
 *   test_proof print COUNT    prints so many verdicts with their proofs for tests/exact_farkas.py
 */
#include "cases.h"
#include "contact/exact.h"
#include "delassus.h"
#include "lcp/lcp_internal.h"
#include "made.h"
#include "run.h"

/* ---- random problems ------------------------------------------------------------------------- */

enum { most_rows = 8 };

static int whole(int from, int to) {
  return from + (int)((uniform() + 1) / 2 * (to - from + 1) * 0.999999);
}

typedef struct lcp_case {
  int n;
  double M[most_rows * most_rows], q[most_rows], z[most_rows], v[most_rows];
  dls_lcp lcp;
} lcp_case;

/* Small whole numbers; times 1/10, 1/7 or factors of rows and columns, rounded, if unit is 1, 2, 3.
 */
static void draw_lcp(lcp_case *a, int unit) {
  const int n = a->n = whole(2, most_rows), wide = whole(1, 3);
  double row[most_rows], column[most_rows];
  for (int i = 0; i < n; i++) {
    row[i] = unit == 3 ? exp(4 * uniform()) : unit == 2 ? 1. / 7 : unit == 1 ? .1 : 1;
    column[i] = unit == 3 ? exp(4 * uniform()) : 1;
  }
  for (int i = 0; i < n; i++) {
    a->q[i] = row[i] * whole(-4, 3);
    for (int j = 0; j < n; j++)
      a->M[i + n * j] = row[i] * column[j] * whole(-wide, wide);
  }
  a->lcp = (dls_lcp){.n = n, .M = {n, n, n, a->M}, .q = a->q};
}

/* Solves with the given crash start; asserts that OK means the certificate at tol; a->v := the
 * proof of DLS_NO_SOLUTION, asserted. */
static dls_status proof_of_lcp(lcp_case *a, int crash, double tol) {
  dls_lemke_settings settings;
  dls_lemke *work;
  dls_lcp_certificate c;
  dls_lemke_settings_init(&settings);
  settings.crash = crash;
  settings.limits.tol = tol;
  ck_assert_int_eq(dls_lemke_create(&work, a->n, &settings, NULL), DLS_OK);
  const dls_status status = dls_lemke_solve(work, &a->lcp, a->z, NULL, NULL, NULL);
  ck_assert_int_ge(status, 0);
  ck_assert_int_eq(dls_lcp_certify(&a->lcp, a->z, NULL, &c, NULL), DLS_OK);
  ck_assert_int_eq(status == DLS_OK, dls_lcp_certificate_holds(&c, tol));
  if (status == DLS_NO_SOLUTION) {
    double scratch[most_rows], kept[most_rows];
    ck_assert_int_eq(dls_lemke_farkas(work, a->v, NULL), DLS_OK);
    memcpy(kept, a->v, sizeof kept);
    ck_assert_int_eq(dlsi_lcp_find_proof(&a->lcp, a->v, scratch), 1);
    ck_assert_int_eq(memcmp(kept, a->v, (size_t)a->n * sizeof *kept), 0); /* at once */
  }
  dls_lemke_destroy(work);
  return status;
}

/* Up to four candidates, W = B B' of whole numbers and any rank; unit as above. */
static void draw_contact(model *a, int d, int unit) {
  const int nc = whole(1, 4), m = d * nc, rank = whole(1, m);
  const double mu[] = {0, 0.5, 1, 2, 3}, common = unit == 1 ? .1 : unit == 2 ? 1. / 7 : 1;
  double B[12][12], row[12];
  set_model(a, d, nc);
  for (int i = 0; i < m; i++) {
    row[i] = unit == 3 ? (i % d ? row[i - 1] : exp(4 * uniform())) : 1;
    for (int k = 0; k < rank; k++)
      B[i][k] = whole(-3, 3);
    a->q[i] = row[i] * common * whole(-4, i % d ? 4 : 2);
  }
  for (int c = 0; c < nc; c++)
    a->mu[c] = mu[whole(0, 4)];
  for (int i = 0; i < m; i++)
    for (int j = 0; j < m; j++) {
      double sum = 0;
      for (int k = 0; k < rank; k++)
        sum += B[i][k] * B[j][k];
      a->W[i + a->p.W.ld * j] = row[i] * row[j] * common * sum;
    }
}

/* v (nc) := what the solver says after its status, which is returned. Asserts that a proof holds
 * exactly, and that there is one exactly after DLS_NO_SOLUTION. */
static dls_status proof_of_contact(const model *a, dls_method method, double *v) {
  dls_info info;
  double r[most];
  dls_solver_settings settings = settings_with(method, default_tol);
  dls_solver *solver = solver_of(a->p.d, a->p.nc, &settings);
  ck_assert_ptr_null(dls_solver_farkas(solver));
  const dls_status status = dls_solver_solve(solver, &a->p, r, NULL, &info, NULL);
  ck_assert_int_ge(status, 0);
  const double *found = dls_solver_farkas(solver);
  if (status == DLS_NO_SOLUTION) {
    ck_assert_ptr_nonnull(found);
    ck_assert_int_eq(dlsi_contact_is_infeasible(&a->p, found), 1);
    memcpy(v, found, (size_t)a->p.nc * sizeof *v);
  } else if (found) {
    ck_assert_int_ne(status, DLS_OK);
    ck_assert_int_eq(dlsi_contact_is_infeasible(&a->p, found), 0);
  }
  const double *direction = dls_solver_direction(solver);
  if (method == DLS_LEMKE && status != DLS_RAY) ck_assert_ptr_null(direction);
  if (status == DLS_RAY) ck_assert(direction || found);
  for (int i = 0; direction && i < a->p.d * a->p.nc; i++)
    ck_assert(isfinite(direction[i]));
  dls_solver_destroy(solver);
  return status;
}

/* ---- exact sums ------------------------------------------------------------------------------ */

static int sign_of(int n, double terms[][3]) {
  dlsi_exact sum;
  dlsi_exact_clear(&sum);
  for (int i = 0; i < n; i++)
    dlsi_exact_add(&sum, terms[i][0], terms[i][1], terms[i][2]);
  const int sign = dlsi_exact_sign(&sum);
  ck_assert_int_eq(dlsi_exact_sign(&sum), sign);
  return sign;
}

TEST(sums_are_exact) {
  const double tiny = 0x1p-1074, huge = 0x1.fffffffffffffp1023, e = 0x1p-52;
  ck_assert_int_eq(sign_of(0, NULL), 0);
  ck_assert_int_eq(sign_of(1, (double[][3]){{tiny, tiny, tiny}}), 1);
  ck_assert_int_eq(sign_of(1, (double[][3]){{huge, -huge, huge}}), -1);
  ck_assert_int_eq(
      sign_of(3, (double[][3]){{huge, huge, huge}, {tiny, -tiny, tiny}, {huge, -huge, huge}}), -1);
  ck_assert_int_eq(sign_of(2, (double[][3]){{huge, tiny, 3}, {3 * tiny, -1, huge}}), 0);
  /* (1 + e)(1 - e) = 1 - e^2 */
  ck_assert_int_eq(sign_of(2, (double[][3]){{1 + e, 1 - e, 1}, {-1, 1, 1}}), -1);
  ck_assert_int_eq(sign_of(3, (double[][3]){{1 + e, 1 - e, 1}, {-1, 1, 1}, {e, e, 1}}), 0);
  ck_assert_int_eq(
      sign_of(4, (double[][3]){{1 + e, 1 - e, 1}, {-1, 1, 1}, {e, e, 1}, {tiny, tiny, 1}}), 1);
}

/* One candidate with g = v (-n, t, s), mu = m: g_n + mu |g_t| <= 0 is decided without rounding, and
 * alike for the least, the largest and any other v, with squares from 2^-6444 on. */
static int round_cone(double n, double t, double s, double m) {
  const double W[9] = {-n, 0, 0, t, 1, 0, s, 0, 1}, q[3] = {-1, 0, 0};
  const double v[3] = {1, 0x1p-1074, 0x1.fffffffffffffp1023};
  const dls_contact p = {.d = 3, .nc = 1, .W = {3, 3, 3, W}, .q = q, .mu = &m};
  const int holds = dlsi_contact_is_infeasible(&p, v);
  for (int k = 1; k < 3; k++)
    ck_assert_int_eq(dlsi_contact_is_infeasible(&p, v + k), holds);
  return holds;
}

TEST(the_round_cone_is_exact) {
  const double e = 0x1p-52, tiny = 0x1p-1074, huge = 0x1p1023;
  ck_assert_int_eq(round_cone(5, 3, 4, 1), 1);
  ck_assert_int_eq(round_cone(5 * (1 - e), 3, 4, 1), 0);
  ck_assert_int_eq(round_cone(5, -3, 4 * (1 + e), 1), 0);
  ck_assert_int_eq(round_cone(65, -3, -4, 13), 1);
  ck_assert_int_eq(round_cone(65, -3 * (1 + e), -4, 13), 0);
  ck_assert_int_eq(round_cone(-5, 3, 4, 1), 0);
  ck_assert_int_eq(round_cone(0, 0, 0, 1), 1);
  ck_assert_int_eq(round_cone(0, tiny, 0, tiny), 0);
  ck_assert_int_eq(round_cone(5 * tiny, 3 * tiny, -4 * tiny, 1), 1);
  ck_assert_int_eq(round_cone(huge, huge, tiny, 1), 0);
  ck_assert_int_eq(round_cone(huge, huge, 0, 1), 1);
}

/* ---- vectors near a proof -------------------------------------------------------------------- */

static int is_third(const void *none, const double *v) {
  (void)none;
  return v[0] == 3 * v[1] && v[2] == 0 && 7 * v[0] == 3 * v[3] && v[0] > 0;
}

static int is_never(const void *none, const double *v) {
  (void)none;
  return v[0] < 0;
}

TEST(whole_numbers_are_found) {
  const double root2 = sqrt(2);
  double v[4] = {3. / 7, 1. / 7 * (1 + 1e-15), 1e-15, 1}, work[4];
  ck_assert_int_eq(dlsi_find_exact(4, v, work, is_third, NULL), 1);
  ck_assert_double_eq(v[0], 3);
  ck_assert_double_eq(v[3], 7);
  double kept[4] = {1, root2, 1e-3, 0};
  ck_assert_int_eq(dlsi_find_exact(4, kept, work, is_never, NULL), 0);
  ck_assert_double_eq(kept[1], root2); /* left alone */
  double none[2] = {0, 0}, bad[2] = {1, NAN};
  ck_assert_int_eq(dlsi_find_exact(2, none, work, is_third, NULL), 0);
  ck_assert_int_eq(dlsi_find_exact(2, bad, work, is_never, NULL), 0);
}

/* ---- LCPs ------------------------------------------------------------------------------------ */

/* Of 2000 LCPs of whole numbers and 2000 of rounded ones: neither start says that there is no
 * solution where the other one has it. */
TEST(crash_and_path_agree) {
  int proved = 0, solved = 0, alone = 0;
  static lcp_case a;
  set_seed(15);
  for (int k = 0; k < 4000; k++) {
    draw_lcp(&a, k < 2000 ? 0 : 1 + k % 3);
    const dls_status path = proof_of_lcp(&a, 0, 1e-8), crash = proof_of_lcp(&a, 1, 1e-8);
    ck_assert(!(path == DLS_NO_SOLUTION && crash == DLS_OK));
    ck_assert(!(crash == DLS_NO_SOLUTION && path == DLS_OK));
    proved += path == DLS_NO_SOLUTION;
    solved += path == DLS_OK;
    alone += k < 2000 && (path == DLS_NO_SOLUTION) != (crash == DLS_NO_SOLUTION);
  }
  ck_assert_int_gt(proved, 400);
  ck_assert_int_gt(solved, 400);
  ck_assert_int_eq(alone, 0);
}

/* tol = 0: proof_of_lcp asserts that DLS_OK is what the certificate says */
TEST(tolerance_zero_is_kept) {
  int solved = 0;
  static lcp_case a;
  set_seed(16);
  for (int k = 0; k < 2000; k++) {
    draw_lcp(&a, k % 4);
    solved += proof_of_lcp(&a, k / 4 % 2, 0) == DLS_OK;
  }
  ck_assert_int_gt(solved, 400);
}

/* ---- contact problems ------------------------------------------------------------------------ */

/* y_0 + y_1 = -2 + e z_1: no solution for e = 0, and positive definite for e > 0 */
TEST(positive_definite_is_never_refuted) {
  for (int k = 0; k <= 50; k++) {
    model a;
    double v[2];
    set_model(&a, 2, 2);
    for (int c = 0; c < 2; c++)
      a.q[2 * c] = -1;
    const double W[4] = {1, -1, -1, 1 + (k < 50 ? ldexp(1, -k) : 0)};
    for (int i = 0; i < 4; i++) {
      a.W[2 * (i % 2) + a.p.W.ld * 2 * (i / 2)] = W[i];
      a.W[2 * (i % 2) + 1 + a.p.W.ld * (2 * (i / 2) + 1)] = i % 3 == 0;
    }
    for (dls_method method = DLS_AUTO; dls_method_name(method); method++) {
      const dls_status status = proof_of_contact(&a, method, v);
      if (k < 50) ck_assert_int_ne(status, DLS_NO_SOLUTION);
      if (k == 50) ck_assert_int_ne(status, DLS_OK);
      if (k == 50 && method == DLS_LEMKE) {
        ck_assert_int_eq(status, DLS_NO_SOLUTION);
        ck_assert_double_eq(v[0], v[1]);
      }
    }
  }
}

/* proof_of_contact asserts that each proof holds; here: proofs are found, no answer beside one. */
TEST(contact_proofs_hold) {
  int proved[4] = {0}, round = 0, rays = 0;
  set_seed(17);
  for (int k = 0; k < 3000; k++) {
    model a;
    double v[4];
    draw_contact(&a, k % 16 < 12 ? 2 : 3, k % 4);
    const dls_status lemke = proof_of_contact(&a, DLS_LEMKE, v);
    proved[k % 4] += lemke == DLS_NO_SOLUTION;
    rays += lemke == DLS_RAY;
    round += lemke == DLS_NO_SOLUTION && a.p.d == 3;
    if (k % 8 >= 4) continue;
    const dls_status any = proof_of_contact(&a, DLS_AUTO, v);
    ck_assert(!(lemke == DLS_NO_SOLUTION && any == DLS_OK));
    ck_assert(!(any == DLS_NO_SOLUTION && lemke == DLS_OK));
  }
  ck_assert_int_gt(proved[0], 50);
  ck_assert_int_gt(proved[3], 5);
  ck_assert_int_gt(round, 20);
  ck_assert_int_gt(rays, 20);
}

TEST(farkas_is_given_only_then) {
  dls_solver *solver;
  model a;
  double r[2];
  ck_assert_ptr_null(dls_solver_farkas(NULL));
  set_model(&a, 2, 1);
  a.q[0] = -1; /* W = 0 */
  for (dls_method method = DLS_AUTO; dls_method_name(method); method++) {
    dls_solver_settings settings = settings_with(method, default_tol);
    ck_assert_int_eq(dls_solver_create(&solver, 2, 1, &settings, NULL), DLS_OK);
    ck_assert_ptr_null(dls_solver_farkas(solver));
    const dls_status status = dls_solver_solve(solver, &a.p, r, NULL, NULL, NULL);
    ck_assert_int_eq(status == DLS_NO_SOLUTION, dls_solver_farkas(solver) != NULL);
    if (method == DLS_LEMKE) ck_assert_double_gt(dls_solver_farkas(solver)[0], 0);
    a.q[0] = 1;
    ck_assert_int_eq(dls_solver_solve(solver, &a.p, r, NULL, NULL, NULL), DLS_OK);
    ck_assert_ptr_null(dls_solver_farkas(solver));
    ck_assert_ptr_null(dls_solver_direction(solver));
    a.q[0] = -1;
    dls_solver_destroy(solver);
  }
}

/* ---- print ----------------------------------------------------------------------------------- */

static void print_numbers(int n, const double *x) {
  for (int i = 0; i < n; i++)
    printf(" %a", x[i]);
}

static int verdicts; /* to print */

/* "lcp n", M by columns, q, v; "contact nc", W by columns, q, mu, v: one verdict a line. */
TEST_ALONE(print_verdicts) {
  static lcp_case a;
  static model b;
  double v[4];
  set_seed(18);
  for (int k = 0, count = verdicts; count > 0; k++) {
    draw_lcp(&a, k % 4);
    if (proof_of_lcp(&a, k / 4 % 2, 1e-8) == DLS_NO_SOLUTION) {
      printf("lcp %d", a.n);
      print_numbers(a.n * a.n, a.M);
      print_numbers(a.n, a.q);
      print_numbers(a.n, a.v);
      putchar('\n');
      count--;
    }
    draw_contact(&b, k % 16 < 12 ? 2 : 3, k % 4);
    if (count > 0 && proof_of_contact(&b, k / 4 % 2 ? DLS_AUTO : DLS_LEMKE, v) == DLS_NO_SOLUTION) {
      const int m = b.p.d * b.p.nc;
      printf("contact%d %d", b.p.d, b.p.nc);
      for (int j = 0; j < m; j++)
        print_numbers(m, b.W + b.p.W.ld * j);
      print_numbers(m, b.q);
      print_numbers(b.p.nc, b.mu);
      print_numbers(b.p.nc, v);
      putchar('\n');
      count--;
    }
  }
}

int main(int argc, char **argv) {
  if (argc == 3 && !strcmp(argv[1], "print")) {
    verdicts = atoi(argv[2]);
    return run_alone(print_verdicts, 0, 1);
  }
  return run_tests("proof", NULL, NULL);
}
