/* test_beyond.c: more than 300 rows, W dense: Lemke's method after all else has failed, and its
 * proofs. */
#include "delassus.h"
#include "made.h"
#include "run.h"

enum { n = 310 };

static double W[n * n], q[n], mu[n], planted[n], r[n];

static double draw_entry(unsigned *seed) {
  *seed = *seed * 1664525u + 1013904223u;
  return (double)(*seed >> 8) / (1 << 23) - 1;
}

/* d = 1: an antisymmetric matrix beside a hundredth of the identity, and q of a planted answer. */
static dls_contact definite(unsigned seed) {
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < i; j++)
      W[j + n * i] = -(W[i + n * j] = draw_entry(&seed));
    W[i + n * i] = 0.01;
    planted[i] = draw_entry(&seed);
  }
  for (int i = 0; i < n; i++) {
    q[i] = planted[i] < 0 ? -planted[i] : 0;
    for (int j = 0; j < n; j++)
      q[i] -= planted[j] > 0 ? W[i + n * j] * planted[j] : 0;
  }
  return (dls_contact){.d = 1, .nc = n, .W = {n, n, n, W}, .q = q, .mu = mu};
}

static dls_solver_settings at_1e_8(void) {
  dls_solver_settings settings = settings_with(DLS_AUTO, default_tol);
  return settings;
}

/* The answer is the planted one: W is definite. */
TEST_EACH(pivots_solve_it, 0, 3) {
  const dls_contact p = definite(2 + 2 * (unsigned)_i);
  const dls_solver_settings settings = at_1e_8();
  dls_info info;
  ck_assert_int_eq(dls_solve(&p, &settings, r, NULL, &info, NULL), DLS_OK);
  ck_assert_int_eq(info.stage[info.stages - 1].method, DLS_LEMKE);
  for (int i = 0; i < n; i++)
    ck_assert_double_eq_tol(r[i], planted[i] > 0 ? planted[i] : 0, 1e-5);
}

/* Candidate 7 cannot be pushed up: row 7 of W is 0, q_7 < 0. The proof is that row. */
TEST(pivots_prove_it) {
  dls_contact p = definite(2);
  const dls_solver_settings settings = at_1e_8();
  for (int j = 0; j < n; j++)
    W[7 + n * j] = W[j + n * 7] = 0;
  q[7] = -1;
  dls_solver *solver = solver_of(1, n, &settings);
  ck_assert_int_eq(dls_solver_solve(solver, &p, r, NULL, NULL, NULL), DLS_NO_SOLUTION);
  const double *v = dls_solver_farkas(solver);
  ck_assert_ptr_nonnull(v);
  for (int c = 0; c < n; c++)
    ck_assert(c == 7 ? v[c] > 0 : v[c] == 0);
  p = definite(2);
  ck_assert_int_eq(dls_solver_solve(solver, &p, r, NULL, NULL, NULL), DLS_OK);
  ck_assert_ptr_null(dls_solver_farkas(solver));
  dls_solver_destroy(solver);
}

/* Its table is allocated in the solve; without memory the error says so, and r stays. Without
 * memory for the list of what may touch (apart.c) the whole is solved. */
TEST(no_memory_for_the_table) {
  const dls_contact p = definite(2);
  const dls_solver_settings settings = at_1e_8();
  int refused = 0;
  long calls = 1;
  for (long k = 0; k <= calls; k++) {
    dls_error error = {0};
    dls_solver *solver = solver_of(1, n, &settings);
    for (int i = 0; i < n; i++)
      r[i] = -7;
    malloc_fails_at(k);
    const dls_status status = dls_solver_solve(solver, &p, r, NULL, NULL, &error);
    if (k == 0) calls = malloc_calls();
    malloc_fails_at(0);
    ck_assert(status == DLS_OK || (k > 0 && status == DLS_E_MEMORY));
    for (int i = 0; status && i < n; i++)
      ck_assert(r[i] == -7);
    if (status) ck_assert_str_eq(error.function, "dls_solver_solve");
    refused += status != DLS_OK;
    dls_solver_destroy(solver);
  }
  ck_assert_int_ge(refused, 2);
}
