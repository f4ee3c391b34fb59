/* test_contact.c: statuses, views, the contact problem, its blocks and its certificate. */
#define _POSIX_C_SOURCE 200809L /* pthread_barrier */
#include "contact/contact.h"

#include <math.h>
#include <pthread.h>

#include "delassus.h"
#include "run.h"

/* Two candidates in 2D, coupled: W symmetric positive definite. */
static double W2[16] = {4, 1, 1, 0, 1, 3, 0, 1, 1, 0, 4, -1, 0, 1, -1, 3};
static double q2[4] = {-1, 2, 3, -4};
static double mu2[2] = {0.5, 0.25};

static dls_contact dense2(void) {
  return (dls_contact){.d = 2, .nc = 2, .W = {4, 4, 4, W2}, .q = q2, .mu = mu2};
}

/* The same W by blocks, its first column's blocks in descending order, one split in two. */
static int p2[3] = {0, 3, 5};
static int i2[5] = {1, 0, 0, 0, 1};
static double x2[20] = {1, 0, 0, 1, 3, 1, 0, 3, 1, 0, 1, 0, 1, 0, 0, 1, 4, -1, -1, 3};

static dls_contact blocks2(void) {
  return (dls_contact){.d = 2, .nc = 2, .Wb = {2, 2, p2, i2, x2}, .q = q2, .mu = mu2};
}

TEST(statuses_have_names_and_words) {
  for (int s = DLS_E_NO_DERIVATIVE; s <= 5; s++) {
    ck_assert_str_ne(dls_status_name((dls_status)s), "unknown status");
    ck_assert_str_ne(dls_status_text((dls_status)s), "unknown status");
  }
  ck_assert_str_eq(dls_status_name((dls_status)77), "unknown status");
  ck_assert_str_eq(dls_status_name(DLS_E_SIZE), "DLS_E_SIZE");
  ck_assert_str_eq(dls_version(), DLS_VERSION);
  char text[16];
  snprintf(text, sizeof text, "%d.%d.%d", DLS_VERSION_NUMBER / 10000,
           DLS_VERSION_NUMBER / 100 % 100, DLS_VERSION_NUMBER % 100);
  ck_assert_str_eq(text, DLS_VERSION);
#if DLS_VERSION_NUMBER < 100
#error DLS_VERSION_NUMBER serves #if
#endif
}

TEST(an_error_says_where) {
  dls_error e;
  dls_status s = dlsi_fail(&e, DLS_E_NOT_FINITE, "q", 3, -2.5, "is %s", "odd");
  ck_assert_str_eq(e.message, "q[3]: is odd");
  s = dlsi_at("dls_f", s, &e);
  ck_assert_int_eq(s, DLS_E_NOT_FINITE);
  ck_assert_int_eq(e.status, DLS_E_NOT_FINITE);
  ck_assert_str_eq(e.function, "dls_f");
  ck_assert_str_eq(e.argument, "q");
  ck_assert_int_eq(e.index, 3);
  ck_assert(e.value == -2.5);
  ck_assert_str_eq(e.message, "dls_f: q[3]: is odd");
  ck_assert_int_eq(dlsi_at("dls_outer", s, &e), DLS_E_NOT_FINITE);
  ck_assert_str_eq(e.function, "dls_outer");
  ck_assert_str_eq(e.message, "dls_outer: q[3]: is odd");
  ck_assert_int_eq(dlsi_at("dls_f", DLS_STALLED, &e), DLS_STALLED); /* no error: all stays */
  ck_assert(e.status == DLS_E_NOT_FINITE && e.index == 3 && e.value == -2.5);
  ck_assert_str_eq(e.function, "dls_outer");
  ck_assert_str_eq(e.argument, "q");
  ck_assert_str_eq(e.message, "dls_outer: q[3]: is odd");
  ck_assert_int_eq(dlsi_fail(NULL, DLS_E_SIZE, "", -1, 0, "x"), DLS_E_SIZE);
  ck_assert_int_eq(dlsi_at("dls_f", DLS_E_SIZE, NULL), DLS_E_SIZE);
}

TEST(arena_counts_carves_and_refuses) {
  dlsi_arena a = {0};
  ck_assert_ptr_null(dlsi_take(&a, 3, 8));
  ck_assert_ptr_null(dlsi_take(&a, 0, 8));
  ck_assert_ptr_null(dlsi_take(&a, 100, 1));
  ck_assert_uint_eq(a.used, 64 + 0 + 128);
  char memory[192];
  dlsi_arena b = {.base = memory, .size = sizeof memory};
  ck_assert_ptr_eq(dlsi_take(&b, 3, 8), memory);
  ck_assert_ptr_eq(dlsi_take(&b, 100, 1), memory + 64);
  ck_assert_ptr_null(dlsi_take(&b, 1, 1));
  ck_assert_int_eq(b.failed, 1);
  ck_assert_ptr_null(dlsi_take(&b, 0, 1));
  dlsi_arena c = {0};
  ck_assert_ptr_null(dlsi_take(&c, SIZE_MAX / 4, 8));
  ck_assert_int_eq(c.failed, 1);
  ck_assert_ptr_null(dlsi_alloc(SIZE_MAX / 4, 8));
}

/* Takes two pieces, and returns the second. */
static double *carve_two(dlsi_arena *arena) {
  (void)dlsi_take(arena, 3, 8);
  return dlsi_take(arena, 5, sizeof(double));
}

TEST(arena_allocates_what_it_counted) {
  dls_error error = {0};
  dlsi_arena a = {0};
  ck_assert_ptr_null(carve_two(&a));
  malloc_fails_at(1);
  ck_assert_int_eq(dlsi_arena_allocate(&a, "nc", 7, &error), DLS_E_MEMORY);
  malloc_fails_at(0);
  ck_assert_int_eq(dlsi_arena_allocate(&a, "nc", 7, &error), DLS_OK);
  ck_assert_uint_eq(a.size, 128);
  ck_assert_ptr_eq(carve_two(&a), a.base + 64);
  ck_assert_int_eq(a.failed, 0);
  free(a.base);
  dlsi_arena b = {0};
  (void)dlsi_take(&b, SIZE_MAX / 4, 8);
  ck_assert_int_eq(dlsi_arena_allocate(&b, "nc", 7, &error), DLS_E_SIZE);
  ck_assert_str_eq(error.argument, "nc");
  ck_assert(error.value == 7);
  ck_assert_ptr_null(b.base);
}

TEST(norms_keep_nan_and_range) {
  const double big[3] = {3e200, 4e200, 0}, small[2] = {3e-200, 4e-200};
  const double with_nan[3] = {1, NAN, 2}, tiny[1] = {5e-324};
  ck_assert_double_eq_tol(dlsi_norm2(big, 3) / 5e200, 1, 4 * DBL_EPSILON);
  ck_assert_double_eq_tol(dlsi_norm2(small, 2) / 5e-200, 1, 4 * DBL_EPSILON);
  ck_assert(dlsi_norm2(tiny, 1) > 0);
  ck_assert_double_nan(dlsi_norm2(with_nan, 3));
  ck_assert_double_nan(dlsi_max_abs(with_nan, 3));
  ck_assert(dlsi_norm2(big, 0) == 0);
  double x[21] = {0};
  for (int k = 0; k < 21; k++) {
    ck_assert_int_eq(dlsi_first_not_finite(x, 21), -1);
    x[k] = k % 2 ? INFINITY : NAN;
    ck_assert_int_eq(dlsi_first_not_finite(x, 21), k);
    x[k] = -DBL_MAX;
  }
}

TEST(vectors_of_any_length_are_finite) {
  const double bad[4] = {NAN, -NAN, INFINITY, -INFINITY};
  const double good[] = {DBL_MAX, -DBL_MAX, 0, -0.0, 5e-324, -5e-324, 1};
  double x[40];
  for (size_t n = 0; n <= 40; n++) {
    for (size_t k = 0; k < 40; k++)
      x[k] = k < n ? good[k % 7] : NAN; /* those past n are not looked at */
    ck_assert_int_eq(dlsi_check_vector("x", x, n, NULL), DLS_OK);
    for (size_t k = 0; k < n; k++) {
      dls_error e = {0};
      const double kept = x[k];
      x[k] = bad[(n + k) % 4];
      ck_assert_int_eq(dlsi_check_vector("x", x, n, &e), DLS_E_NOT_FINITE);
      ck_assert_int_eq(e.index, (long long)k);
      x[k] = kept;
    }
  }
}

/* ---- checks: every slot of the problem ------------------------------------------------------- */

static void refuses(const dls_contact *p, dls_status status, const char *argument,
                    long long index) {
  dls_error e = {0};
  ck_assert_int_eq(dls_contact_check(p, &e), status);
  ck_assert_int_eq(e.status, status);
  ck_assert_str_eq(e.argument, argument);
  ck_assert_int_eq(e.index, index);
  ck_assert_str_eq(e.function, "dls_contact_check");
}

TEST(check_names_the_slot) {
  dls_contact p = dense2();
  ck_assert_int_eq(dls_contact_check(&p, NULL), DLS_OK);
  refuses(NULL, DLS_E_ARGUMENT, "problem", -1);
  p.d = 4;
  refuses(&p, DLS_E_ARGUMENT, "d", -1);
  p = dense2(), p.nc = -1;
  refuses(&p, DLS_E_SIZE, "nc", -1);
  p = dense2(), p.nc = INT32_MAX;
  refuses(&p, DLS_E_SIZE, "nc", -1);
  p = dense2(), p.W.a = NULL;
  refuses(&p, DLS_E_ARGUMENT, "W", -1);
  p = dense2(), p.W.rows = 3;
  refuses(&p, DLS_E_SIZE, "W", -1);
  p = dense2(), p.W.ld = 3;
  refuses(&p, DLS_E_SIZE, "W", -1);
  p = dense2(), p.q = NULL;
  refuses(&p, DLS_E_ARGUMENT, "q", -1);
  p = dense2(), p.mu = NULL;
  refuses(&p, DLS_E_ARGUMENT, "mu", -1);
  p = dense2(), p.Wb = blocks2().Wb;
  refuses(&p, DLS_E_ARGUMENT, "Wb", -1);

  const double bad[3] = {NAN, INFINITY, -INFINITY};
  for (int b = 0; b < 3; b++) {
    double W[16], q[4], mu[2];
    for (int k = 0; k < 16; k++) {
      memcpy(W, W2, sizeof W);
      W[k] = bad[b];
      p = dense2(), p.W.a = W;
      refuses(&p, DLS_E_NOT_FINITE, "W", k);
    }
    for (int k = 0; k < 4; k++) {
      memcpy(q, q2, sizeof q);
      q[k] = bad[b];
      p = dense2(), p.q = q;
      refuses(&p, DLS_E_NOT_FINITE, "q", k);
    }
    for (int k = 0; k < 2; k++) {
      memcpy(mu, mu2, sizeof mu);
      if (b == 1) continue; /* an infinite friction is one */
      mu[k] = bad[b];
      p = dense2(), p.mu = mu;
      refuses(&p, DLS_E_NOT_FINITE, "mu", k);
      mu[k] = -1e-300;
      refuses(&p, DLS_E_ARGUMENT, "mu", k);
    }
  }
}

TEST(check_names_the_slot_of_blocks) {
  dls_contact p = blocks2();
  ck_assert_int_eq(dls_contact_check(&p, NULL), DLS_OK);
  p.Wb.d = 3;
  refuses(&p, DLS_E_SIZE, "Wb.d", -1);
  p = blocks2(), p.Wb.n = 1;
  refuses(&p, DLS_E_SIZE, "Wb.n", -1);
  p = blocks2(), p.Wb.p = NULL;
  refuses(&p, DLS_E_ARGUMENT, "Wb.p", -1);
  p = blocks2(), p.Wb.i = NULL;
  refuses(&p, DLS_E_ARGUMENT, "Wb.i", -1);
  int shifted[3] = {1, 3, 5}, falling[3] = {0, 5, 3}, row[5] = {1, 0, 0, 2, 1};
  p = blocks2(), p.Wb.p = shifted;
  refuses(&p, DLS_E_ARGUMENT, "Wb.p", 0);
  p.Wb.p = falling;
  refuses(&p, DLS_E_ARGUMENT, "Wb.p", 2);
  p = blocks2(), p.Wb.i = row;
  refuses(&p, DLS_E_ARGUMENT, "Wb.i", 3);
  row[3] = -1;
  refuses(&p, DLS_E_ARGUMENT, "Wb.i", 3);
  double x[20];
  memcpy(x, x2, sizeof x);
  x[19] = NAN;
  p = blocks2(), p.Wb.x = x;
  refuses(&p, DLS_E_NOT_FINITE, "Wb.x", 19);
}

/* Every byte of W, q and mu is kept from r and u, in each storage, and none beside it. */
TEST(outputs_stay_off_each_byte) {
  enum { d = 3, nc = 4, m = d * nc, motions = 6, room = 2 * motions * m + 2 * m };
  static double arrays[4][room];
  const int p[nc + 1] = {0, 1, 3, 4, 6}, i[] = {0, 0, 1, 2, 1, 3}, body[2 * nc] = {0};
  for (int storage = 0; storage < 3; storage++) {
    double *const W = arrays[0] + m, *const q = arrays[1] + m, *const mu = arrays[2] + m;
    const dls_contact a = {.d = d,
                           .nc = nc,
                           .W = {m, m, m + 1, storage == 0 ? W : NULL},
                           .Wb = {d, nc, p, i, storage == 1 ? W : NULL},
                           .bodies = {motions, 1, body, storage == 2 ? W : NULL, NULL},
                           .q = q,
                           .mu = mu};
    const int size_W = storage == 0   ? (m + 1) * (m - 1) + m
                       : storage == 1 ? d * d * p[nc]
                                      : 2 * motions * m;
    double *const start[] = {W, q, mu, arrays[3] + m};
    const int size[] = {size_W, m, nc, m};
    for (int k = 0; k < 4; k++) {
      double *const other = arrays[3] + m; /* u, or r where u is tried */
      double *const end = start[k] + size[k];
      dls_error error;
      ck_assert_int_eq(dlsi_check_apart(&a, end - 1, other, &error), DLS_E_ARGUMENT);
      ck_assert_str_eq(error.argument, "r");
      ck_assert_int_eq(dlsi_check_apart(&a, start[k] - m + 1, other, NULL), DLS_E_ARGUMENT);
      ck_assert_int_eq(dlsi_check_apart(&a, end, other, NULL), DLS_OK);
      ck_assert_int_eq(dlsi_check_apart(&a, start[k] - m, other, NULL), DLS_OK);
      ck_assert_int_eq(dlsi_check_apart(&a, other, end - 1, NULL), DLS_E_ARGUMENT);
      ck_assert_int_eq(dlsi_check_apart(&a, other, start[k] - m + 1, &error), DLS_E_ARGUMENT);
      ck_assert_str_eq(error.argument, k == 3 ? "r" : "u");
      ck_assert_int_eq(dlsi_check_apart(&a, other, end, NULL), DLS_OK);
      ck_assert_int_eq(dlsi_check_apart(&a, other, start[k] - m, NULL), DLS_OK);
    }
  }
}

/* ---- the certificate ------------------------------------------------------------------------- */

static dls_certificate certified(const dls_contact *p, const double *r, double *u) {
  dls_certificate c;
  dls_error e;
  const dls_status s = dls_contact_certify(p, r, u, &c, &e);
  ck_assert_msg(s == DLS_OK, "%s", e.message);
  return c;
}

/* One contact, W = diag(2, 4) so that w_n = 2, w_t = 4, k = 2, |q| = 5, mu = 1/2; residuals by
 * hand. */
TEST(certificate_by_hand) {
  double W[4] = {2, 0, 0, 4}, q[2] = {-3, 4}, mu[1] = {0.5}, r[2] = {0, 0}, u[2];
  const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  /* r = 0: u = q, v = -u = (3, -4), R = mu k 3 = 3: slip, F = (u_n, R) = (-3, 3) */
  dls_certificate c = certified(&p, r, u);
  ck_assert_double_eq_tol(c.residual_u, sqrt(18) / 5, 1e-15);
  ck_assert(c.residual_r == 1 && c.residual == 1);
  ck_assert_double_eq_tol(c.floor_u, DBL_EPSILON * sqrt(18) / 5, 1e-20);
  ck_assert_double_eq_tol(c.floor_r, DBL_EPSILON, 1e-20);
  ck_assert(c.penetration == 3 && c.adhesion == 0 && c.complementarity == 0);
  ck_assert(u[0] == -3 && u[1] == 4);
  /* the solution: slip in +t, u_n = 0: r = (3/2, -3/4), u_t = 4 - 3 = 1 */
  r[0] = 1.5, r[1] = -0.75;
  c = certified(&p, r, u);
  ck_assert(c.residual == 0 && c.penetration == 0 && c.cone_violation == 0);
  ck_assert(c.slip_direction == 0 && u[0] == 0 && u[1] == 1);
  /* |W||r| + |q| = (6, 7), D |r| = (3, 3): F_n rounds as 6 does, F_t as 3 + mu k (6 + 3) */
  ck_assert_double_eq_tol(c.floor_u, DBL_EPSILON * hypot(6, 12) / 5, 1e-20);
  ck_assert_double_eq_tol(c.floor_r, DBL_EPSILON * hypot(3, 3) / hypot(1.5, .75), 1e-20);
  ck_assert_int_eq(dls_certificate_holds(&c, 0), 1);
  /* outside the cone, pulling, slip that friction drives: each readable part by hand */
  r[0] = -1, r[1] = 2;
  c = certified(&p, r, u);
  ck_assert(u[0] == -5 && u[1] == 12);
  ck_assert(c.penetration == 5 && c.adhesion == 1 && c.cone_violation == 2);
  ck_assert(c.complementarity == 5 && c.slip_direction == 24);
  /* v = (-2 + 5, 8 - 12), R = 3: F = (-5, 8 + 3); over D (2.5, 2.75), more than |r| */
  ck_assert_double_eq_tol(c.residual_u, hypot(5, 11) / 5, 1e-15);
  ck_assert(c.residual_r == 1);
  ck_assert_int_eq(dls_certificate_holds(&c, 1e-8), 0);
}

/* Two candidates without coupling, w = 1 and 2^-20, without friction: u_n = w r_n + q_n. */
static dls_certificate two_apart(double q_soft, double q_stiff, double r_soft, double r_stiff) {
  const double w = 0x1p-20, mu[2] = {0, 0}, q[4] = {q_soft, 0, q_stiff, 0};
  const double W[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, w, 0, 0, 0, 0, w};
  const double r[4] = {r_soft, 0, r_stiff, 0};
  const dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu};
  return certified(&p, r, NULL);
}

/* Each part sees errors that the other does not. */
TEST(either_part_can_fail_alone) {
  /* stiff: r_n = 2^10 is the answer, 2 % more the error: 1e-6 of |q| = 20 */
  dls_certificate c = two_apart(-20, -0x1p-10, 20, 0x1p10 * 1.02);
  ck_assert_double_eq_tol(c.residual_u, 0.02 * 0x1p-10 / 20, 1e-12);
  ck_assert_double_eq_tol(c.residual_r, 0.02 / 1.02, 1e-3);
  ck_assert(c.residual == c.residual_r);
  ck_assert_int_eq(dls_certificate_holds(&c, 1e-5), 0);
  /* soft: 10 % of r_n = 1, which is 1e-7 of the large force beside it */
  c = two_apart(-1, -1, 1.1, 0x1p20);
  ck_assert_double_eq_tol(c.residual_u, 0.1 / sqrt(2), 1e-15);
  ck_assert_double_eq_tol(c.residual_r, 0.1 * 0x1p-20, 1e-12);
  ck_assert(c.residual == c.residual_u);
  ck_assert_int_eq(dls_certificate_holds(&c, 1e-5), 0);
  c = two_apart(-1, -1, 1, 0x1p20);
  ck_assert(c.residual == 0);
  ck_assert_int_eq(dls_certificate_holds(&c, 0), 1);
}

/* Residuals and floors, where squares of forces and positions are no numbers, too: w = 1 and 2^-20,
 * both candidates off. */
TEST(norms_of_any_size) {
  const double unit[2] = {0x1p-700, 0x1p700};
  const dls_certificate c = two_apart(-1, -3, 1.25, 0x1p21);
  ck_assert_double_eq_tol(c.residual_u, hypot(0.25, 1) / sqrt(10), 1e-15);
  ck_assert_double_eq_tol(c.residual_r, hypot(0.25, 0x1p20) / hypot(1.25, 0x1p21), 1e-15);
  ck_assert_double_eq_tol(c.floor_u, DBL_EPSILON * hypot(2.25, 5) / sqrt(10), 1e-30);
  ck_assert_double_eq_tol(c.floor_r, DBL_EPSILON * hypot(2.25, 5 * 0x1p20) / hypot(1.25, 0x1p21),
                          1e-30);
  for (int k = 0; k < 2; k++) {
    const double s = unit[k];
    const dls_certificate b = two_apart(-s, -3 * s, 1.25 * s, 0x1p21 * s);
    ck_assert_double_eq_tol(b.residual_u, c.residual_u, 1e-15);
    ck_assert_double_eq_tol(b.residual_r, c.residual_r, 1e-15);
    ck_assert_double_eq_tol(b.floor_u, c.floor_u, 1e-30);
    ck_assert_double_eq_tol(b.floor_r, c.floor_r, 1e-30);
    ck_assert_int_eq(b.worst, 1);
  }
}

/* r = 0 under a pressure, however small, is no answer: it is wrong by all of the forces. A contact
 * that is open does not hide that, at whatever distance. */
TEST(no_forces_under_pressure) {
  static const double gap[] = {1, 1e20};
  for (int k = 0; k < 2; k++) {
    dls_certificate c = two_apart(gap[k], -1e-12, 0, 0);
    ck_assert(c.residual_u == 1 && c.residual_r == 1);
    ck_assert_int_eq(dls_certificate_holds(&c, 1e-8), 0);
    c = two_apart(gap[k], -1e-12, 0, 1e-12 * 0x1p20);
    ck_assert(c.residual == 0 && c.floor_u < 4 * DBL_EPSILON && c.floor_r < 4 * DBL_EPSILON);
    c = two_apart(gap[k], -1e-12, 0, 1.01e-12 * 0x1p20); /* 1 % off */
    ck_assert_double_eq_tol(c.residual_u, 0.01, 1e-6);
    ck_assert_double_eq_tol(c.residual_r, 0.01 / 1.01, 1e-6);
    c = two_apart(gap[k], -1e-12, 1e-9, 1e-12 * 0x1p20); /* and pushed where it is open */
    ck_assert_int_eq(dls_certificate_holds(&c, 1e-8), 0);
  }
}

/* Normal and tangent have weights of their own, from W or from the caller. */
TEST(weights_of_normal_and_tangent) {
  const double W[4] = {1e-8, 0, 0, 1}, q[2] = {-1, 0.3}, mu[1] = {0.5}, r[2] = {1e8, -0.3};
  const double given[2] = {1, 2}, bad[2] = {1, 0};
  dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  dls_certificate c = certified(&p, r, NULL);
  ck_assert(c.residual <= 4 * DBL_EPSILON);
  ck_assert_int_eq(dls_certificate_holds(&c, 1e-8), 1); /* one weight for both: floor_u = 1e-8 */
  double w[2];
  dlsi_certificate_weights(&p, w);
  ck_assert(w[0] == 1e-8 && w[1] == 1);
  const double off[2] = {1.01e8, -0.3};
  c = certified(&p, off, NULL); /* stick: F = u = (.01, 0) */
  ck_assert_double_eq_tol(c.residual_u, 0.01 / hypot(1, 0.3), 1e-9);
  ck_assert_double_eq_tol(c.residual_r, 0.01 / 1.01, 1e-9);
  p.weights = given;
  dlsi_certificate_weights(&p, w);
  ck_assert(w[0] == 1 && w[1] == 2);
  c = certified(&p, off, NULL); /* the same positions over weights that are not those of W */
  ck_assert_double_eq_tol(c.residual_r, 0.01 / 1.01e8, 1e-18);
  p.weights = bad;
  REFUSES(ARGUMENT, "weights", 1, dls_contact_check, &p);
}

/* Stick at a large mu: F = u, which mu does not multiply. */
TEST(rounding_of_a_large_friction) {
  const double W[4] = {3, 1, 1, 2}, third = 1. / 3;
  for (double size = 1; size < 1e13; size *= 1e4) {
    const double q[2] = {-(3 * third + 1 * 0.1), -(1 * third + 2 * 0.1)}, r[2] = {third, 0.1};
    const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = &size};
    const dls_certificate c = certified(&p, r, NULL);
    ck_assert(c.residual <= 4 * fmax(c.floor_u, c.floor_r));
    ck_assert_int_eq(dls_certificate_verdict(&c, 1e-12), DLS_OK);
  }
}

/* A penetration is seen whatever the friction: W = diag(6, 7e7), right r = (.4, -.4). */
TEST(penetration_beside_a_large_friction) {
  const double W[4] = {6, 0, 0, 7e7}, q[2] = {-2.4, 28000000.7}, mu[1] = {1};
  const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  const double right[2] = {0.4, -0.4}, wrong[2] = {0.3836, -0.3836};
  dls_certificate c = certified(&p, right, NULL);
  ck_assert_int_eq(dls_certificate_holds(&c, 1e-12), 1);
  c = certified(&p, wrong, NULL);
  ck_assert(c.penetration > 0.09 && c.residual_r > 0.01);
  ck_assert_int_eq(dls_certificate_holds(&c, 1e-3), 0);
}

/* What sticks at the border of slip has the rounding of slip: u_n = r_n - 1e8 + q_n rounds, and mu
 * times that is in the friction. Well inside it has not. */
TEST(rounding_at_the_border_of_slip) {
  double W[16] = {1, 0, -0.5, 0, 0, 1, 0, 0, -0.5, 0, 1, 0, 0, 0, 0, 1};
  double q[4] = {1e8 - 1, 0, 0.5 - 2e8, 0}, mu[2] = {1e4, 0}, r[4] = {1, 0, 2e8, 0}, u[4];
  dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu};
  dls_certificate c;
  for (int inside = 0; inside < 2; inside++) {
    r[1] = inside ? 5e3 : 1e4;
    q[1] = -r[1];
    ck_assert_int_eq(dls_contact_certify(&p, r, u, &c, NULL), DLS_OK);
    ck_assert_double_eq(c.residual, 0);
    const double a = 2e8, friction = inside ? 0 : 1e4 * a; /* |W||r| + |q| of contact 0 */
    const double size = hypot(hypot(a, 2 * a), friction) / hypot(q[0], q[2]);
    ck_assert_double_eq_tol(c.floor_u, DBL_EPSILON * size, 1e-3 * DBL_EPSILON * size);
  }
}

/* Slip that is fast beside what the forces move adds no rounding to them. */
TEST(fast_slip_rounds_nothing) {
  for (int d = 2; d <= 3; d++) {
    const double mu = 0.3, W[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const double flat[4] = {1, 0, 0, 1}, q[3] = {-1e-7, -10, 0}, r[3] = {1e-7, 0.3e-7, 0};
    const dls_contact p = {.d = d, .nc = 1, .W = {d, d, d, d == 2 ? flat : W}, .q = q, .mu = &mu};
    const dls_certificate c = certified(&p, r, NULL);
    ck_assert(c.residual_r <= 4 * DBL_EPSILON && c.floor_r <= 8 * DBL_EPSILON);
    ck_assert_int_eq(dls_certificate_holds(&c, 1e-12), 1);
  }
}

/* A free candidate whose reaction is rounding shows no friction law broken. */
TEST(rounding_has_no_direction) {
  double W[4] = {2, 0, 0, 4}, q[2] = {3, 4}, mu[1] = {0.5}, r[2] = {1e-17, 1e-17};
  const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  dls_certificate c = certified(&p, r, NULL);
  ck_assert(c.slip_direction == 0 && c.cone_violation == 0 && c.complementarity == 0);
  ck_assert_int_eq(dls_certificate_holds(&c, 1e-8), 0); /* r = 0 is the answer */
  r[0] = r[1] = 0x1p-30; /* free, and w r_n < u_n: friction has no say, the other laws do */
  c = certified(&p, r, NULL);
  ck_assert(c.slip_direction == 0 && c.cone_violation > 0 && c.complementarity > 0);
  q[0] = r[0] = r[1] = 1; /* free: u_n = 3, w r_n = 2 */
  ck_assert(certified(&p, r, NULL).slip_direction == 0);
  r[0] = r[1] = 0x1p-30;
  q[0] = -0x1p-29; /* closed: u_n = 0, u_t = 4 along r_t */
  c = certified(&p, r, NULL);
  ck_assert_double_eq_tol(c.slip_direction, 8, 1e-7);
}

TEST(certificate_of_q_zero_and_frictionless) {
  double W[4] = {2, 0, 0, 4}, q[2] = {0, 0}, mu[1] = {0}, r[2] = {0, 0};
  const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  dls_certificate c = certified(&p, r, NULL);
  ck_assert(c.residual == 0 && c.floor_u == 0);
  r[0] = 1; /* u_n = 2 > 0 with r_n > 0: v_n = 2 - 2, free, though r is not 0 */
  c = certified(&p, r, NULL);
  ck_assert(c.residual_u == 1 && c.residual_r == 1);
  const double own[2] = {1, 1}; /* v_n = 2 - 1 > 0: nothing presses, |q| and |W||r| are empty */
  dls_contact weighted = p;
  weighted.weights = own;
  c = certified(&weighted, r, NULL);
  ck_assert(c.residual_u == 1 && c.residual_r == 1);
  q[0] = -2; /* now u_n = 0: the frictionless solution, though u_t = 0 has no say */
  q[1] = 7;
  c = certified(&p, r, NULL);
  ck_assert(c.residual == 0 && c.slip_direction == 0);
}

/* One row and one candidate are no plural. */
TEST(errors_count_one_and_more) {
  const double W[16] = {0}, q[4] = {0}, mu[2] = {0};
  dls_error e;
  int count;
  for (int n = 1; n <= 2; n++) {
    const dls_dense A = {2 * n - 1, 2 * n - 1, 4, W};
    const dls_contact p = {.d = 2, .nc = n, .W = {2 * n, 2 * n, 4, W}, .q = q, .mu = mu};
    ck_assert_int_eq(dls_blocks_count(&A, 2, &count, &e), DLS_E_SIZE);
    ck_assert_ptr_nonnull(strstr(e.message, n == 1 ? "1 row, not" : "3 rows, not"));
    ck_assert_int_eq(dlsi_check_solve(2, n - 1, &p, q, NULL, 0, &e), DLS_E_SIZE);
    ck_assert_ptr_nonnull(strstr(e.message, n == 1 ? "1 candidate, the" : "2 candidates, the"));
  }
}

/* r = 0 leaves u = q, where nothing rounds, though |q| is no number. */
TEST(no_forces_beside_a_norm_beyond_numbers) {
  double W[36] = {0}, q[6], mu[3] = {1, 1, 1}, r[6] = {0};
  const dls_contact p = {.d = 2, .nc = 3, .W = {6, 6, 6, W}, .q = q, .mu = mu};
  for (int k = 0; k < 6; k++) {
    W[7 * k] = 1;
    q[k] = 1e308;
  }
  dls_certificate c = certified(&p, r, NULL);
  ck_assert(c.residual == 0 && c.floor_u == 0);
  ck_assert_int_eq(dls_certificate_holds(&c, 0), 1);
  q[2] = -1e308;
  c = certified(&p, r, NULL);
  ck_assert_int_eq(dls_certificate_holds(&c, 1e-2), 0);
}

/* w_c falls back to the mean of the positive traces, then to the largest entry, then to 1. */
TEST(weights_fall_back) {
  double W[16] = {0}, w[2];
  dls_contact p = dense2();
  p.W.a = W;
  W[0] = 6, W[5] = 2, W[10] = -1, W[15] = -1;
  dlsi_contact_weights(&p, w);
  ck_assert(w[0] == 4 && w[1] == 4);
  W[0] = -6, W[5] = 0;
  dlsi_contact_weights(&p, w);
  ck_assert(w[0] == 6 && w[1] == 6);
  W[11] = -7; /* beside the diagonal */
  dlsi_contact_weights(&p, w);
  ck_assert(w[0] == 7 && w[1] == 7);
  memset(W, 0, sizeof W);
  dlsi_contact_weights(&p, w);
  ck_assert(w[0] == 1 && w[1] == 1);
  W[0] = -0.25, W[10] = 0.125; /* -1/4 + 0 and 1/8 - 1/8 are no weights */
  W[15] = -0.125;
  dlsi_contact_weights(&p, w);
  ck_assert(w[0] == 0.25 && w[1] == 0.25);
  const double many[16] = {[0] = 3, [5] = 5, [15] = 10}; /* d = 1 */
  double v[4];
  p = (dls_contact){.d = 1, .nc = 4, .W = {4, 4, 4, many}, .q = q2, .mu = mu2};
  dlsi_contact_weights(&p, v);
  ck_assert(v[0] == 3 && v[1] == 5 && v[2] == 6 && v[3] == 10);
  const int start[5] = {0, 2, 3, 4, 5}, row[5] = {0, 0, 1, 0, 3};
  const double entry[5] = {1, 2, 5, 7, 10};
  p = (dls_contact){.d = 1, .nc = 4, .Wb = {1, 4, start, row, entry}, .q = q2, .mu = mu2};
  dlsi_contact_weights(&p, v);
  ck_assert(v[0] == 3 && v[1] == 5 && v[2] == 6 && v[3] == 10);
}

/* Of equal misfits the first one is the worst, where their squares are no numbers, too. */
TEST(worst_of_equal_ones) {
  const double unit[3] = {1, 0x1p-700, 0x1p700};
  for (int k = 0; k < 3; k++) {
    const double s = unit[k];
    const dls_certificate c = two_apart(-s, -s, 0, 0), b = two_apart(s, -s, 0, 0);
    ck_assert(c.worst == 0 && b.worst == 1);
  }
  const dls_contact none = {.d = 3};
  ck_assert_int_eq(certified(&none, NULL, NULL).worst, 0);
}

/* W = 1, w = 1: from w r_n = u_n on friction has no say; reactions up to 4 roundings of the largest
 * number beside them break no law. */
TEST(borders_of_the_laws) {
  double W[4] = {1, 0, 0, 1}, q[2] = {0, 1}, mu[1] = {0.5}, r[2] = {1, 0.25};
  const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  ck_assert(certified(&p, r, NULL).slip_direction == 0);
  q[0] = -0x1p-40;
  ck_assert(certified(&p, r, NULL).slip_direction > 0);
  q[0] = 1, q[1] = 0, r[1] = 0;
  for (int k = 6; k <= 9; k++) {
    r[0] = k * DBL_EPSILON / 2;
    ck_assert_int_eq(certified(&p, r, NULL).complementarity > 0, k == 9);
  }
  q[0] = 3, r[0] = -1; /* one that pulls, u_n = 2 */
  ck_assert(certified(&p, r, NULL).complementarity == 2);
}

TEST(projection_is_nearest) {
  /* P(v) in C, v - P(v) in the polar cone, orthogonal to P(v): that characterises the projection */
  unsigned seed = 1;
  for (int k = 0; k < 2000; k++) {
    double v[3], p[3];
    for (int i = 0; i < 3; i++) {
      seed = seed * 1664525u + 1013904223u;
      v[i] = (double)(seed >> 8) / (1 << 23) - 1;
    }
    const double mu = k % 5 * 0.7;
    const int d = 2 + k % 2;
    (void)dlsi_project_cone(d, mu, v, p);
    const double pt = d == 2 ? fabs(p[1]) : hypot(p[1], p[2]);
    ck_assert(pt <= mu * p[0] * (1 + 4 * DBL_EPSILON));
    double e[3] = {v[0] - p[0], v[1] - p[1], d == 3 ? v[2] - p[2] : 0};
    ck_assert(e[0] + mu * hypot(e[1], e[2]) <= 1e-15);
    ck_assert_double_eq_tol(e[0] * p[0] + e[1] * p[1] + (d == 3 ? e[2] * p[2] : 0), 0, 1e-14);
  }
}

/* r -> b r, (u, q) -> a u, W -> a/b W: the residual and the floor stay. */
TEST(certificate_ignores_units) {
  const double r[4] = {0.1, -0.25, 0.125, 0.5};
  dls_contact p = dense2();
  const dls_certificate c = certified(&p, r, NULL);
  ck_assert(c.residual > 0.01);
  const double factor[] = {1e-9, 1e-3, 1, 1e3, 1e9};
  for (int i = 0; i < 5; i++)
    for (int j = 0; j < 5; j++) {
      const double a = factor[i], b = factor[j];
      double W[16], q[4], s[4];
      for (int k = 0; k < 16; k++)
        W[k] = W2[k] * (a / b);
      for (int k = 0; k < 4; k++)
        q[k] = q2[k] * a, s[k] = r[k] * b;
      p = dense2(), p.W.a = W, p.q = q;
      const dls_certificate e = certified(&p, s, NULL);
      ck_assert_double_eq_tol(e.residual / c.residual, 1, 1e-14);
      ck_assert_double_eq_tol(e.residual_u / c.residual_u, 1, 1e-14);
      ck_assert_double_eq_tol(e.residual_r / c.residual_r, 1, 1e-14);
      ck_assert_double_eq_tol(e.floor_u / c.floor_u, 1, 1e-14);
      ck_assert_double_eq_tol(e.floor_r / c.floor_r, 1, 1e-14);
      ck_assert_double_eq_tol(e.penetration / (a * c.penetration), 1, 1e-14);
    }
}

TEST(certificate_ignores_order_and_tangent_frame) {
  enum { NC = 4, M = 3 * NC };
  double A[M * M], W[M * M], q[M], r[M], mu[NC], V[M * M], qv[M], rv[M], muv[NC];
  unsigned seed = 7;
  for (int k = 0; k < M * M + 2 * M + NC; k++) {
    seed = seed * 1664525u + 1013904223u;
    const double v = (double)(seed >> 8) / (1 << 23) - 1;
    if (k < M * M)
      A[k] = v;
    else if (k < M * M + M)
      q[k - M * M] = v;
    else if (k < M * M + 2 * M)
      r[k - M * M - M] = v;
    else
      mu[k - M * M - 2 * M] = fabs(v);
  }
  for (int i = 0; i < M; i++)
    for (int j = 0; j < M; j++) {
      W[i + M * j] = i == j;
      for (int k = 0; k < M; k++)
        W[i + M * j] += A[k + M * i] * A[k + M * j];
    }
  const dls_contact p = {.d = 3, .nc = NC, .W = {M, M, M, W}, .q = q, .mu = mu};
  const dls_certificate c = certified(&p, r, NULL);

  /* T: candidates reversed, each tangent frame turned by 0.3 (c + 1) */
  double T[M * M] = {0};
  for (int a = 0; a < NC; a++) {
    const int b = NC - 1 - a;
    const double co = cos(0.3 * (a + 1)), si = sin(0.3 * (a + 1));
    T[3 * b + M * (3 * a)] = 1;
    T[3 * b + 1 + M * (3 * a + 1)] = co;
    T[3 * b + 1 + M * (3 * a + 2)] = si;
    T[3 * b + 2 + M * (3 * a + 1)] = -si;
    T[3 * b + 2 + M * (3 * a + 2)] = co;
    muv[b] = mu[a];
  }
  for (int i = 0; i < M; i++) {
    qv[i] = rv[i] = 0;
    for (int k = 0; k < M; k++)
      qv[i] += T[i + M * k] * q[k], rv[i] += T[i + M * k] * r[k];
    for (int j = 0; j < M; j++) {
      V[i + M * j] = 0;
      for (int k = 0; k < M; k++)
        for (int l = 0; l < M; l++)
          V[i + M * j] += T[i + M * k] * W[k + M * l] * T[j + M * l];
    }
  }
  const dls_contact t = {.d = 3, .nc = NC, .W = {M, M, M, V}, .q = qv, .mu = muv};
  const dls_certificate e = certified(&t, rv, NULL);
  ck_assert_double_eq_tol(e.residual_u / c.residual_u, 1, 1e-13);
  ck_assert_double_eq_tol(e.residual_r / c.residual_r, 1, 1e-13);
  ck_assert_double_eq_tol(e.slip_direction / c.slip_direction, 1, 1e-13);
  ck_assert_int_eq(e.worst, NC - 1 - c.worst);
}

TEST(dense_and_blocks_agree) {
  const dls_contact d = dense2(), s = blocks2();
  const double r[4] = {0.75, -0.25, 0.125, 0.5};
  double ud[4], us[4];
  const dls_certificate a = certified(&d, r, ud), b = certified(&s, r, us);
  assert_near(ud, us, 4, 1e-15);
  ck_assert_double_eq_tol(a.residual_u, b.residual_u, 1e-15);
  ck_assert_double_eq_tol(a.residual_r, b.residual_r, 1e-15);
}

TEST(states_of_the_three_kinds) {
  double W[36] = {0}, q[6] = {1, 5, -1, 0.25, -1, 4}, mu[3] = {0.5, 0.5, 0.5}, u[6];
  for (int k = 0; k < 6; k++)
    W[7 * k] = 1;
  const dls_contact p = {.d = 2, .nc = 3, .W = {6, 6, 6, W}, .q = q, .mu = mu};
  const double r[6] = {0, 0, 1, -0.25, 1, -0.5};
  const dls_certificate c = certified(&p, r, u);
  ck_assert(c.residual == 0);
  dls_contact_state state[3];
  ck_assert_int_eq(dls_contact_states(&p, r, u, state, NULL), DLS_OK);
  ck_assert_int_eq(state[0], DLS_FREE);
  ck_assert_int_eq(state[1], DLS_STICK);
  ck_assert_int_eq(state[2], DLS_SLIP);
}

/* They add up to the residual, and the largest is where the certificate says. */
TEST(misfits_are_the_residual) {
  const dls_contact p = dense2();
  const double r[4] = {0.5, 0.1, 0.2, 0.4};
  double u[4], misfit[2];
  const dls_certificate c = certified(&p, r, u);
  ck_assert_int_eq(dls_contact_misfits(&p, r, u, misfit, NULL), DLS_OK);
  ck_assert(misfit[0] > 0 && misfit[1] > 0);
  dls_contact_state state[2];
  ck_assert_int_eq(dls_contact_states(&p, r, u, state, NULL), DLS_OK);
  double q = 0;
  for (int k = 0; k < 4; k++)
    q = hypot(q, state[k / 2] == DLS_FREE ? 0 : p.q[k]);
  ck_assert(q > 0);
  ck_assert_double_eq_tol(hypot(misfit[0], misfit[1]) / q, c.residual_u, 1e-15);
  ck_assert_int_eq(misfit[1] > misfit[0], c.worst);
}

/* Changes of normal reactions alone leave the columns of tangents unread, one by one or four at
 * once. */
TEST(panels_of_normals) {
  enum { nc = 6, most = 3 * nc };
  for (int d = 2; d <= 3; d++) {
    double W[most * most], u[most], expected[most], dr[most] = {0};
    const int m = d * nc, c[nc] = {4, 1, 5, 0, 2, 3};
    const dls_contact p = {.d = d, .nc = nc, .W = {m, m, m, W}};
    for (int i = 0; i < m; i++)
      u[i] = expected[i] = i;
    for (int k = 0; k < m * m; k++)
      W[k] = k / m % d ? NAN : sin(k);
    for (int k = 0; k < nc; k++) {
      dr[d * k] = 1 + k;
      for (int i = 0; i < m; i++)
        expected[i] += dr[d * k] * W[i + m * d * c[k]];
    }
    dlsi_contact_add_panel(&p, nc, c, dr, u);
    assert_near(u, expected, m, 1e-13 * (m + nc));
    dr[1] = 1;
    dlsi_contact_add_panel(&p, nc, c, dr, u);
    ck_assert(u[0] != u[0]);
  }
}

TEST(certify_refuses_and_leaves_outputs) {
  const dls_contact p = dense2();
  double r[4] = {0, 0, 0, 0}, u[4] = {9, 9, 9, 9};
  dls_certificate c = {.residual = 9};
  dls_contact_state state[2] = {DLS_SLIP, DLS_SLIP};
  dls_error e;
  ck_assert_int_eq(dls_contact_certify(NULL, r, u, &c, &e), DLS_E_ARGUMENT);
  REFUSES(ARGUMENT, "r", -1, dls_contact_certify, &p, NULL, u, &c);
  REFUSES(ARGUMENT, "certificate", -1, dls_contact_certify, &p, r, u, NULL);
  r[3] = NAN;
  ck_assert_int_eq(dls_contact_certify(&p, r, u, &c, &e), DLS_E_NOT_FINITE);
  ck_assert_int_eq(e.index, 3);
  ck_assert_int_eq(dls_contact_states(&p, r, u, state, &e), DLS_E_NOT_FINITE);
  r[3] = 0;
  ck_assert_int_eq(dls_contact_states(&p, r, NULL, state, &e), DLS_E_ARGUMENT);
  REFUSES(ARGUMENT, "state", -1, dls_contact_states, &p, r, u, NULL);
  REFUSES(ARGUMENT, "misfit", -1, dls_contact_misfits, &p, r, u, NULL);
  malloc_fails_at(1);
  ck_assert_int_eq(dls_contact_certify(&p, r, u, &c, &e), DLS_E_MEMORY);
  malloc_fails_at(1);
  ck_assert_int_eq(dls_contact_states(&p, r, u, state, &e), DLS_E_MEMORY);
  malloc_fails_at(0);
  ck_assert(u[0] == 9 && u[3] == 9 && c.residual == 9 && state[1] == DLS_SLIP);
}

TEST(nan_is_never_certified) {
  dls_certificate c = {.residual_u = NAN, .floor_u = 0};
  ck_assert_int_eq(dls_certificate_holds(&c, INFINITY), 0);
  c = (dls_certificate){.residual_r = NAN};
  ck_assert_int_eq(dls_certificate_holds(&c, INFINITY), 0);
  c = (dls_certificate){.floor_u = NAN};
  ck_assert_int_eq(dls_certificate_holds(&c, NAN), 0);
  ck_assert_int_eq(dls_certificate_holds(&c, 1), 0);
  c = (dls_certificate){.floor_r = NAN};
  ck_assert_int_eq(dls_certificate_holds(&c, 1), 0);
  ck_assert_int_eq(dls_certificate_holds(NULL, 1), 0);
  c = (dls_certificate){.residual_u = 3e-16, .floor_u = 1e-16};
  ck_assert_int_eq(dls_certificate_holds(&c, 0), 1);
  c.residual_u = 5e-16;
  ck_assert_int_eq(dls_certificate_holds(&c, 0), 0);
  c.residual_u = NAN;
  ck_assert_int_eq(dls_certificate_verdict(&c, 1), DLS_STALLED);
  ck_assert_int_eq(dls_certificate_verdict(NULL, 1), DLS_STALLED);
}

/* Each part of the residual is met within 4 of its own rounding levels: solved up to 1e-8 of them,
 * solved to rounding up to 1e-4. */
TEST(verdict_of_each_part) {
  for (int part = 0; part < 3; part++)
    for (double floor = 1e-12; floor < 1e-2; floor *= 10) {
      dls_certificate c = {0};
      double *const residual[] = {&c.residual_u, &c.residual_r, &c.equilibrium};
      double *const level[] = {&c.floor_u, &c.floor_r, &c.floor_e};
      *level[part] = floor;
      for (int k = 3; k <= 5; k += 2) {
        *residual[part] = k * floor;
        const int met = k == 3 || 5 * floor <= 1e-8;
        const dls_status right = !met || 4 * floor > 1e-4 ? DLS_STALLED
                                 : 4 * floor > 1e-8       ? DLS_TO_ROUNDING
                                                          : DLS_OK;
        ck_assert_int_eq(dls_certificate_verdict(&c, 1e-8), right);
        ck_assert_int_eq(dls_certificate_holds(&c, 1e-8), right == DLS_OK);
      }
    }
}

/* r so large that W r + q has lost q says nothing, small as its residual looks. */
TEST(a_runaway_is_never_certified) {
  double W[4] = {1, 1, 1, 1}, q[2] = {-2, 0}, mu[1] = {2}, r[2] = {1e20, -1e20};
  dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  dls_certificate c = certified(&p, r, NULL); /* the wedge c03 of data/failures: no solution */
  ck_assert(c.floor_u > 1e3);
  ck_assert_int_eq(dls_certificate_holds(&c, 1e-8), 0);
  ck_assert_int_eq(dls_certificate_holds(&c, 1e-2), 0);
  const double zero[4] = {0};
  p.W.a = zero; /* u = q whatever r is: u_n = -2 */
  c = certified(&p, r, NULL);
  ck_assert(c.residual_u == 1 && c.penetration == 2);
  ck_assert_int_eq(dls_certificate_holds(&c, 1e-8), 0);
  c = (dls_certificate){.residual_u = 1e-9, .floor_u = 2e-9};
  ck_assert_int_eq(dls_certificate_holds(&c, 0), 1);
  c.floor_u = 2.4e-9;
  ck_assert_int_eq(dls_certificate_holds(&c, 0), 1);
  c.floor_u = 3e-9; /* 4 floor > 1e-8: only for who asks for less */
  ck_assert_int_eq(dls_certificate_holds(&c, 0), 0);
  ck_assert_int_eq(dls_certificate_holds(&c, 1e-6), 1);
}

/* ---- dense and by blocks --------------------------------------------------------------------- */

/* n x n blocks, a third of them zero, some by one entry only; with room between the columns */
enum { many = 7, wide = 3 * many + 2 };

static void sparse_matrix(int d, double *a) {
  for (int k = 0; k < wide * wide; k++)
    a[k] = NAN; /* beyond the matrix: never looked at */
  for (int j = 0; j < d * many; j++)
    for (int i = 0; i < d * many; i++) {
      const int c = (3 * (i / d) + 5 * (j / d)) % 6;
      const int one = i % d == d - 1 && j % d == 0;
      a[i + wide * j] = c < 2 ? (c ? -0.0 : 0) : c == 2 && !one ? 0 : 1 + i + 100 * j;
    }
}

TEST_EACH(there_and_back, 2, 4) {
  const int d = _i;
  double a[wide * wide], b[wide * wide], x[9 * many * many];
  int p[many + 1], i[many * many], count;
  dls_blocks B;
  sparse_matrix(d, a);
  const dls_dense A = {d * many, d * many, wide, a};
  ck_assert_int_eq(dls_blocks_count(&A, d, &count, NULL), DLS_OK);
  ck_assert_int_eq(dls_blocks_from_dense(&A, d, p, i, x, &B, NULL), DLS_OK);
  ck_assert(B.d == d && B.n == many && B.p == p && B.i == i && B.x == x);
  ck_assert(p[0] == 0 && p[many] == count && count > many * many / 2 && count < many * many);
  for (int c = 0; c < many; c++)
    for (int k = p[c]; k < p[c + 1]; k++) {
      int zeros = 0;
      ck_assert(k == p[c] || i[k - 1] < i[k]);
      for (int e = 0; e < d * d; e++)
        zeros += x[d * d * k + e] == 0;
      ck_assert_int_lt(zeros, d * d);
    }
  for (int k = 0; k < wide * wide; k++)
    b[k] = 7;
  ck_assert_int_eq(dls_blocks_to_dense(&B, b, wide, NULL), DLS_OK);
  for (int l = 0; l < wide; l++)
    for (int k = 0; k < wide; k++) {
      const int within = k < d * many && l < d * many;
      ck_assert(b[k + wide * l] == (within ? a[k + wide * l] : l < d * many || !within ? 7 : 0));
    }

  /* blocks of the same place add up; nothing is nothing */
  const int two[2] = {0, 2}, same[2] = {0, 0};
  double twice[18];
  for (int e = 0; e < 2 * d * d; e++)
    twice[e] = e + 1;
  const dls_blocks C = {d, 1, two, same, twice};
  ck_assert_int_eq(dls_blocks_to_dense(&C, b, d, NULL), DLS_OK);
  for (int e = 0; e < d * d; e++)
    ck_assert(b[e] == 2 * (e + 1) + d * d);
  for (int k = 0; k < wide * wide; k++)
    a[k] = 0;
  ck_assert_int_eq(dls_blocks_from_dense(&A, d, p, i, x, &B, NULL), DLS_OK);
  ck_assert_int_eq(p[many], 0);
  ck_assert_int_eq(dls_blocks_to_dense(&B, b, wide, NULL), DLS_OK);
  assert_all(b, d * many, 0);
}

/* u = W r + q and the certificate do not depend on the storage */
TEST_EACH(storages_agree, 2, 4) {
  const int d = _i, m = d * many;
  double a[wide * wide], x[9 * many * many], r[3 * many], q[3 * many], mu[many], u[2][3 * many];
  int p[many + 1], i[many * many];
  sparse_matrix(d, a);
  for (int k = 0; k < m; k++) {
    r[k] = k % 4 ? 1. / (k + 1) : 0;
    q[k] = k - 5;
    mu[k / d] = 0.5;
  }
  dls_contact problem = {.d = d, .nc = many, .W = {m, m, wide, a}, .q = q, .mu = mu};
  dls_certificate c[2];
  ck_assert_int_eq(dls_contact_certify(&problem, r, u[0], &c[0], NULL), DLS_OK);
  ck_assert_int_eq(dls_blocks_from_dense(&problem.W, d, p, i, x, &problem.Wb, NULL), DLS_OK);
  problem.W = (dls_dense){0};
  ck_assert_int_eq(dls_contact_certify(&problem, r, u[1], &c[1], NULL), DLS_OK);
  ck_assert_mem_eq(u[0], u[1], (size_t)m * sizeof(double));
  /* |W||r| is added up in another order */
  ck_assert(fabs(c[1].floor_u - c[0].floor_u) <= 4 * DBL_EPSILON * c[0].floor_u);
  ck_assert(fabs(c[1].floor_r - c[0].floor_r) <= 4 * DBL_EPSILON * c[0].floor_r);
  c[1].floor_u = c[0].floor_u;
  c[1].floor_r = c[0].floor_r;
  ck_assert_mem_eq(&c[0], &c[1], offsetof(dls_certificate, worst)); /* padding follows */
  ck_assert_int_eq(c[0].worst, c[1].worst);
}

static void refuses_conversion(dls_status status, const char *argument, const dls_dense *A, int d,
                               const dls_blocks *B, int ld) {
  int p[many + 1] = {7}, i[many * many] = {7}, count = 7;
  double x[9 * many * many] = {7};
  dls_error error;
  if (A) {
    dls_blocks out = {.d = 7};
    ck_assert_int_eq(dls_blocks_count(A, d, &count, &error), status);
    ck_assert_str_eq(error.argument, argument);
    ck_assert_int_eq(dls_blocks_from_dense(A, d, p, i, x, &out, &error), status);
    ck_assert(p[0] == 7 && i[0] == 7 && x[0] == 7 && count == 7 && out.d == 7);
  } else
    ck_assert_int_eq(dls_blocks_to_dense(B, x, ld, &error), status);
  ck_assert(x[0] == 7);
  ck_assert_str_eq(error.argument, argument);
}

TEST(bad_conversion) {
  double a[16] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
  int p[3], i[4], count;
  double x[16];
  dls_blocks B;
  dls_error error;
  dls_dense A = {4, 4, 4, a};
  REFUSES(ARGUMENT, "A", -1, dls_blocks_count, NULL, 2, &count);
  REFUSES(ARGUMENT, "count", -1, dls_blocks_count, &A, 2, NULL);
  refuses_conversion(DLS_E_ARGUMENT, "d", &A, 4, NULL, 0);
  refuses_conversion(DLS_E_SIZE, "A", &A, 3, NULL, 0);
  A.cols = 2;
  refuses_conversion(DLS_E_SIZE, "A", &A, 2, NULL, 0);
  A = (dls_dense){4, 4, 3, a};
  refuses_conversion(DLS_E_SIZE, "A", &A, 2, NULL, 0);
  A = (dls_dense){4, 4, 4, NULL};
  refuses_conversion(DLS_E_ARGUMENT, "A", &A, 2, NULL, 0);
  A.a = a;
  a[9] = NAN;
  refuses_conversion(DLS_E_NOT_FINITE, "A", &A, 2, NULL, 0);
  a[9] = 10;
  REFUSES(ARGUMENT, "p", -1, dls_blocks_from_dense, &A, 2, NULL, i, x, &B);
  REFUSES(ARGUMENT, "i", -1, dls_blocks_from_dense, &A, 2, p, NULL, x, &B);
  REFUSES(ARGUMENT, "x", -1, dls_blocks_from_dense, &A, 2, p, i, NULL, &B);
  REFUSES(ARGUMENT, "B", -1, dls_blocks_from_dense, &A, 2, p, i, x, NULL);

  ck_assert_int_eq(dls_blocks_from_dense(&A, 2, p, i, x, &B, &error), DLS_OK);
  refuses_conversion(DLS_E_ARGUMENT, "B", NULL, 0, NULL, 4);
  refuses_conversion(DLS_E_SIZE, "ld", NULL, 0, &B, 3);
  dls_blocks bad = B;
  bad.d = 4;
  refuses_conversion(DLS_E_ARGUMENT, "B.d", NULL, 0, &bad, 4);
  bad = B;
  bad.n = -1;
  refuses_conversion(DLS_E_SIZE, "B.n", NULL, 0, &bad, 4);
  bad = B;
  bad.p = NULL;
  refuses_conversion(DLS_E_ARGUMENT, "B.p", NULL, 0, &bad, 4);
  bad = B;
  bad.i = NULL;
  refuses_conversion(DLS_E_ARGUMENT, "B.i", NULL, 0, &bad, 4);
  i[2] = 2;
  refuses_conversion(DLS_E_ARGUMENT, "B.i", NULL, 0, &B, 4);
  i[2] = 0;
  x[5] = INFINITY;
  refuses_conversion(DLS_E_NOT_FINITE, "B.x", NULL, 0, &B, 4);
  ck_assert_int_eq(dls_blocks_to_dense(&bad, NULL, 4, &error), DLS_E_ARGUMENT);
}

/* ---- subsets --------------------------------------------------------------------------------- */

/* A problem of 4 candidates, d = 2 or 3, whose entries say where they stand; by blocks every block
 * stands twice, in halves, rows descending, and the column of candidate 1 is empty. */
typedef struct quad {
  double W[144], x[32 * 9], q[12], mu[4];
  int p[5], i[32];
  dls_contact dense, blocks;
} quad;

static void set_quad(quad *a, int d) {
  const int m = 4 * d, ld = m;
  int k = 0;
  *a = (quad){.p = {0}};
  for (int c = 0; c < 4; c++) {
    for (int half = 0; c != 1 && half < 2; half++)
      for (int b = 3; b >= 0; b--, k++) {
        a->i[k] = b;
        for (int e = 0; e < d * d; e++) {
          const double w = 1 + 100 * b + 10 * c + e;
          a->x[d * d * k + e] = w / 2;
          a->W[d * b + e % d + (d * c + e / d) * ld] = w;
        }
      }
    a->p[c + 1] = k;
    a->mu[c] = 0.1 * c;
  }
  for (int e = 0; e < m; e++)
    a->q[e] = -e;
  a->dense = (dls_contact){.d = d, .nc = 4, .W = {m, m, ld, a->W}, .q = a->q, .mu = a->mu};
  a->blocks = a->dense;
  a->blocks.W = (dls_dense){0};
  a->blocks.Wb = (dls_blocks){d, 4, a->p, a->i, a->x};
}

/* W' r' + q' of a subset are the rows s of W r + q, where r is 0 but at s. */
TEST_EACH(a_subset_is_rows_and_columns, 0, 24) {
  const int d = 2 + _i % 2, list = _i / 2 % 6, blocks = _i / 12;
  static const int candidate[6][4] = {{0, 1, 2, 3}, {1, 3}, {0}, {1}, {2, 3}, {0}};
  static const int counts[6] = {4, 2, 1, 1, 2, 0};
  const int count = counts[list], *s = candidate[list];
  quad a;
  set_quad(&a, d);
  const dls_contact *p = blocks ? &a.blocks : &a.dense;
  double values[32 * 9 + 16], r[12] = {0}, u[12], rs[12], us[12];
  int index[4 + 1 + 32];
  dls_contact sub;
  ck_assert_int_eq(dls_contact_subset(p, count, s, values, blocks ? index : NULL, &sub, NULL),
                   DLS_OK);
  ck_assert_int_eq(sub.d, d);
  ck_assert_int_eq(sub.nc, count);
  ck_assert_int_eq(dls_contact_check(&sub, NULL), DLS_OK);
  ck_assert_int_eq(sub.Wb.x != NULL, blocks && count > 0);
  for (int k = 0; k < d * count; k++)
    r[d * s[k / d] + k % d] = rs[k] = 1 + k;
  dls_certificate c;
  ck_assert_int_eq(dls_contact_certify(p, r, u, &c, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_certify(&sub, rs, us, &c, NULL), DLS_OK);
  for (int k = 0; k < d * count; k++) {
    ck_assert(us[k] == u[d * s[k / d] + k % d]);
    ck_assert(sub.q[k] == a.q[d * s[k / d] + k % d]);
    ck_assert(sub.mu[k / d] == a.mu[s[k / d]]);
  }
  if (count == 0) ck_assert(dls_certificate_holds(&c, 0) && c.residual == 0);
}

/* u and what rounds in it, |W| |r|, of signs that differ. */
TEST_EACH(products_round_alike_in_both_storages, 1, 4) {
  const int d = _i, m = 4 * d;
  quad a;
  set_quad(&a, d);
  double r[12], u[12], v[12], rounds[12], same[12];
  for (int k = 0; k < m; k++) {
    r[k] = k % 2 ? -1 - k : 2 * k;
    for (int j = 0; j < m; j++)
      a.W[j + m * k] *= (j + k) % 3 ? 1 : -1;
  }
  for (int c = 0; c < 4; c++)
    for (int k = a.p[c]; k < a.p[c + 1]; k++)
      for (int e = 0; e < d * d; e++) /* the same signs */
        a.x[d * d * k + e] *= (d * a.i[k] + e % d + d * c + e / d) % 3 ? 1 : -1;
  dlsi_contact_multiply(&a.dense, NULL, r, u, rounds);
  dlsi_contact_multiply(&a.blocks, NULL, r, v, same);
  for (int i = 0; i < m; i++) {
    double sum = 0;
    for (int j = 0; j < m; j++)
      sum += fabs(a.W[i + m * j]) * fabs(r[j]);
    ck_assert_double_eq_tol(rounds[i], sum, 1e-12 * sum);
    ck_assert_double_eq_tol(same[i], sum, 1e-12 * sum);
    ck_assert_double_eq_tol(u[i], v[i], 1e-12 * sum);
  }
}

/* A dense W takes the memory that the header says, to the last double. */
TEST(a_subset_stays_in_its_memory) {
  quad a;
  set_quad(&a, 3);
  enum { count = 2, doubles = (3 * count) * (3 * count) + 4 * count };
  double values[doubles + 1];
  values[doubles] = 77;
  dls_contact sub;
  ck_assert_int_eq(
      dls_contact_subset(&a.dense, count, (const int[]){1, 2}, values, NULL, &sub, NULL), DLS_OK);
  ck_assert(values[doubles] == 77 && sub.mu + count == values + doubles);
}

TEST(a_bad_subset_is_named) {
  quad a;
  set_quad(&a, 2);
  double values[256], *v = values;
  int index[64], s[] = {0, 2, 3};
  dls_contact sub, before;
  memset(&sub, 0x33, sizeof sub);
  before = sub;
  dls_error e;
  const char *name = "dls_contact_subset";
#define SUBSET(p, count, s_, v_, i_, out, status, argument, index_)                                \
  expect_error(dls_contact_subset(p, count, s_, v_, i_, out, &e), &e, status, name, argument,      \
               index_)
  SUBSET(NULL, 1, s, v, index, &sub, DLS_E_ARGUMENT, "problem", -1);
  SUBSET(&a.dense, -1, s, v, NULL, &sub, DLS_E_SIZE, "count", -1);
  SUBSET(&a.dense, 5, s, v, NULL, &sub, DLS_E_SIZE, "count", -1);
  SUBSET(&a.dense, 1, NULL, v, NULL, &sub, DLS_E_ARGUMENT, "candidate", -1);
  SUBSET(&a.dense, 1, s, NULL, NULL, &sub, DLS_E_ARGUMENT, "values", -1);
  SUBSET(&a.blocks, 1, s, v, NULL, &sub, DLS_E_ARGUMENT, "index", -1);
  SUBSET(&a.dense, 1, s, v, NULL, NULL, DLS_E_ARGUMENT, "subset", -1);
  s[2] = 2;
  SUBSET(&a.blocks, 3, s, v, index, &sub, DLS_E_ARGUMENT, "candidate", 2);
  s[2] = 1;
  SUBSET(&a.dense, 3, s, v, NULL, &sub, DLS_E_ARGUMENT, "candidate", 2);
  ck_assert_ptr_nonnull(strstr(e.message, "after 2"));
  s[2] = 4;
  SUBSET(&a.dense, 3, s, v, NULL, &sub, DLS_E_ARGUMENT, "candidate", 2);
  s[0] = -1;
  SUBSET(&a.dense, 3, s, v, NULL, &sub, DLS_E_ARGUMENT, "candidate", 0);
  a.q[7] = NAN;
  SUBSET(&a.dense, 0, s, v, NULL, &sub, DLS_E_NOT_FINITE, "q", 7);
  ck_assert_mem_eq(&sub, &before, sizeof sub);
}

/* mu = 0, u_t = 0: a pull is no answer, and a candidate apart is free, not stuck. */
TEST(frictionless_adhesion_is_refused) {
  const double W[] = {1, 0, 0, 1}, mu[] = {0}, pull[] = {-1, 0}, none[] = {0, 0};
  const double apart[] = {1, 0}, press[] = {-1, 0};
  dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = apart, .mu = mu};
  dls_certificate c;
  double u[2];
  ck_assert_int_eq(dls_contact_certify(&p, pull, u, &c, NULL), DLS_OK);
  ck_assert_int_eq(dls_certificate_holds(&c, 1e-8), 0);
  ck_assert_double_ge(c.residual, 0.5);
  dls_contact_state state;
  ck_assert_int_eq(dls_contact_states(&p, none, apart, &state, NULL), DLS_OK);
  ck_assert_int_eq(state, DLS_FREE);
  p.q = press;
  const double r[] = {1, 0};
  ck_assert_int_eq(dls_contact_states(&p, r, none, &state, NULL), DLS_OK);
  ck_assert_int_eq(state, DLS_STICK);
}

/* ---- contacts on two ranks, here two threads ------------------------------------------------- */

enum { rank_nc = 12, rank_first = 5, rank_m = 3 * rank_nc };

typedef struct half {
  dlsi_laws of;
  dlsi_ranks ranks;
  dls_certificate c;
  int rank;
} half;

static pthread_barrier_t both;
static double brought[2][32];

static void join_halves(void *data, dlsi_how how, double *x, size_t count) {
  const half *h = data;
  memcpy(brought[h->rank], x, count * sizeof *x);
  (void)pthread_barrier_wait(&both);
  for (size_t k = 0; k < count; k++) {
    const double a = brought[0][k], b = brought[1][k];
    x[k] = how == DLSI_SUM ? a + b : how == DLSI_NORM ? hypot(a, b) : a > b || a != a ? a : b;
  }
  (void)pthread_barrier_wait(&both);
}

static void *measure_half(void *data) {
  half *h = data;
  dlsi_laws_measure(&h->of, &h->c);
  return NULL;
}

/* Five contacts on one rank and seven on the other have the certificate of all twelve, both the
 * same bits; so, too, where squares overflow, and where the worst contact is there twice. */
TEST_EACH(certificate_of_two_ranks, 0, 9) {
  const int d = 1 + _i % 3, m = d * rank_nc;
  const double unit = _i / 3 == 1 ? 1e170 : 1;
  double mu[rank_nc], w[2 * rank_nc], r[rank_m], u[rank_m], a[rank_m], q[rank_m], F[rank_m];
  for (int k = 0; k < m; k++) {
    r[k] = sin(k + 1) + (k % d == 0);
    u[k] = unit * sin(3 * k + _i);
    a[k] = unit * (1 + fabs(sin(5 * k)));
    q[k] = unit * sin(7 * k);
  }
  for (int c = 0; c < rank_nc; c++) {
    mu[c] = d == 1 ? 0 : 0.1 * (c % 4);
    w[2 * c] = unit * (1 + 0.1 * c);
    w[2 * c + 1] = unit * (1 + 0.2 * c);
  }
  const dlsi_laws all = {
      .d = d, .nc = rank_nc, .mu = mu, .r = r, .u = u, .w = w, .a = a, .b = q, .scale = q, .F = F};
  dls_certificate c;
  dlsi_laws_measure(&all, &c);
  if (_i / 3 == 2) { /* on either rank */
    const int from = c.worst, to = from < rank_first ? rank_nc - 1 : 0;
    for (int i = 0; i < d; i++) {
      r[d * to + i] = r[d * from + i];
      u[d * to + i] = u[d * from + i];
    }
    mu[to] = mu[from];
    w[2 * to] = w[2 * from];
    w[2 * to + 1] = w[2 * from + 1];
    dlsi_laws_measure(&all, &c);
    ck_assert_int_eq(c.worst, from < to ? from : to);
  }
  half h[2];
  pthread_t other;
  ck_assert_int_eq(pthread_barrier_init(&both, NULL, 2), 0);
  for (int k = 0; k < 2; k++) {
    const int first = k ? rank_first : 0, at = d * first;
    h[k] = (half){.of = all, .ranks = {&h[k], join_halves, .first = first}, .rank = k};
    h[k].of.nc = k ? rank_nc - rank_first : rank_first;
    h[k].of.mu = mu + first;
    h[k].of.w = w + 2 * first;
    h[k].of.r = r + at, h[k].of.u = u + at, h[k].of.a = a + at, h[k].of.F = F + at;
    h[k].of.b = h[k].of.scale = q + at;
    h[k].of.ranks = &h[k].ranks;
  }
  ck_assert_int_eq(pthread_create(&other, NULL, measure_half, &h[1]), 0);
  (void)measure_half(&h[0]);
  ck_assert_int_eq(pthread_join(other, NULL), 0);
  (void)pthread_barrier_destroy(&both);
  const dls_certificate *b = &h[0].c;
  ck_assert_mem_eq(b, &h[1].c, sizeof *b);
  ck_assert_int_eq(b->worst, c.worst);
  const double one[] = {c.residual_u,     c.residual_r,     c.floor_u,
                        c.floor_r,        c.penetration,    c.adhesion,
                        c.cone_violation, c.slip_direction, c.complementarity};
  const double two[] = {b->residual_u,     b->residual_r,     b->floor_u,
                        b->floor_r,        b->penetration,    b->adhesion,
                        b->cone_violation, b->slip_direction, b->complementarity};
  for (size_t k = 0; k < sizeof one / sizeof *one; k++)
    ck_assert_msg(fabs(two[k] - one[k]) <= 1e-14 * one[k], "%zu: %g, not %g", k, two[k], one[k]);
}
