/*
 * test_rigid.c: contacts between rigid bodies. The reference is the mass matrix itself: H^T H is
 * J^T M^-1 J, q is the velocity of the contact point, impulses change momentum and spin as Newton
 * says.
 */
#include "contact/contact.h"
#include "delassus.h"
#include "geometry/geometry.h"
#include "made.h"
#include "run.h"

static double rigid_draw(int *seed) {
  return 2 * dlsi_draw_entry(3, (*seed)++) - 1;
}

/* A body of any pose, speed and inertia (A A^T + 1/2). */
static dls_rigid any_body(int *seed) {
  dls_rigid of = {.mass = 2 + rigid_draw(seed)};
  double A[9], a = rigid_draw(seed), b = rigid_draw(seed), c = rigid_draw(seed),
               d = rigid_draw(seed);
  for (int k = 0; k < 9; k++)
    A[k] = rigid_draw(seed);
  for (int i = 0; i < 3; i++) {
    of.x[i] = rigid_draw(seed);
    of.v[i] = rigid_draw(seed);
    of.w[i] = rigid_draw(seed);
    for (int j = 0; j < 3; j++) {
      of.inertia[3 * i + j] = i == j ? 0.5 : 0;
      for (int k = 0; k < 3; k++)
        of.inertia[3 * i + j] += A[3 * i + k] * A[3 * j + k];
    }
  }
  const double s = sqrt(a * a + b * b + c * c + d * d);
  a /= s, b /= s, c /= s, d /= s; /* a quaternion */
  const double R[] = {1 - 2 * (c * c + d * d), 2 * (b * c - a * d),     2 * (b * d + a * c),
                      2 * (b * c + a * d),     1 - 2 * (b * b + d * d), 2 * (c * d - a * b),
                      2 * (b * d - a * c),     2 * (c * d + a * b),     1 - 2 * (b * b + c * c)};
  memcpy(of.R, R, sizeof R);
  return of;
}

/* y := R I R^T x, the angular momentum of spin x */
static void momentum(const dls_rigid *of, const double *x, double *y) {
  double a[3], b[3];
  for (int i = 0; i < 3; i++)
    a[i] = of->R[i] * x[0] + of->R[3 + i] * x[1] + of->R[6 + i] * x[2];
  for (int i = 0; i < 3; i++)
    b[i] =
        of->inertia[3 * i] * a[0] + of->inertia[3 * i + 1] * a[1] + of->inertia[3 * i + 2] * a[2];
  for (int i = 0; i < 3; i++)
    y[i] = of->R[3 * i] * b[0] + of->R[3 * i + 1] * b[1] + of->R[3 * i + 2] * b[2];
}

/* Two contacts of two bodies: impulses r change linear momentum by the impulse and angular momentum
 * by its moment, oppositely for the other body; u = H^T H r + q is the relative velocity
 * afterwards. */
TEST_EACH(newton, 0, 20) {
  int seed = 100 * _i;
  dls_rigid bodies[2] = {any_body(&seed), any_body(&seed)}, after[2];
  double point[2][3], normal[2][3], frame[2][9], H[72], q[6], r[6], gap[2];
  int body[4];
  for (int k = 0; k < 2; k++) {
    gap[k] = rigid_draw(&seed);
    for (int i = 0; i < 3; i++) {
      point[k][i] = rigid_draw(&seed);
      normal[k][i] = rigid_draw(&seed);
      r[3 * k + i] = rigid_draw(&seed);
    }
    ck_assert_int_eq(dls_rigid_contact(2, bodies, 0, 1, point[k], normal[k], gap[k], k, body, H, q,
                                       frame[k], NULL),
                     DLS_OK);
    ck_assert(body[2 * k] == 0 && body[2 * k + 1] == 1);
  }
  memcpy(after, bodies, sizeof bodies);
  ck_assert_int_eq(dls_rigid_apply(2, after, 2, body, H, r, NULL), DLS_OK);
  for (int b = 0; b < 2; b++) {
    double push[3] = {0}, turn[3] = {0}, spin[3], old[3];
    for (int k = 0; k < 2; k++) {
      double F[3] = {0}, arm[3], M[3];
      for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
          F[i] += (b ? -1 : 1) * frame[k][3 * j + i] * r[3 * k + j];
        arm[i] = point[k][i] - bodies[b].x[i];
      }
      dlsi_cross3(arm, F, M);
      for (int i = 0; i < 3; i++) {
        push[i] += F[i];
        turn[i] += M[i];
      }
    }
    momentum(&after[b], after[b].w, spin);
    momentum(&bodies[b], bodies[b].w, old);
    for (int i = 0; i < 3; i++) {
      ck_assert_double_eq_tol(bodies[b].mass * (after[b].v[i] - bodies[b].v[i]), push[i], 1e-13);
      ck_assert_double_eq_tol(spin[i] - old[i], turn[i], 1e-12);
    }
  }
  const double mu[2] = {0};
  const dls_contact problem = {.d = 3, .nc = 2, .q = q, .mu = mu, .bodies = {6, 2, body, H, NULL}};
  double u[6];
  dls_certificate certificate;
  ck_assert_int_eq(dls_contact_certify(&problem, r, u, &certificate, NULL), DLS_OK);
  for (int k = 0; k < 2; k++) {
    double v[3] = {0};
    for (int b = 0; b < 2; b++) {
      double arm[3], turned[3];
      for (int i = 0; i < 3; i++)
        arm[i] = point[k][i] - after[b].x[i];
      dlsi_cross3(after[b].w, arm, turned);
      for (int i = 0; i < 3; i++)
        v[i] += (b ? -1 : 1) * (after[b].v[i] + turned[i]);
    }
    for (int j = 0; j < 3; j++) {
      const double *e = frame[k] + 3 * j;
      ck_assert_double_eq_tol(u[3 * k + j],
                              e[0] * v[0] + e[1] * v[1] + e[2] * v[2] + (j ? 0 : gap[k]), 1e-12);
    }
    const double length = sqrt(normal[k][0] * normal[k][0] + normal[k][1] * normal[k][1] +
                               normal[k][2] * normal[k][2]);
    for (int i = 0; i < 3; i++)
      ck_assert_double_eq_tol(frame[k][i], normal[k][i] / length, 1e-15);
  }
}

/* A box falls flat on a belt that runs with speed 1: it stops falling, and friction speeds it up by
 * mu times the impulse over the mass. In any unit of mass, length and time. */
TEST_EACH(box_on_a_belt, 0, 4) {
  const double units[][3] = {{1, 1, 1}, {1e-3, 1e3, 1}, {1e6, 1e-6, 1e3}, {1e-9, 1e9, 1e-9}};
  const double kg = units[_i][0], m = units[_i][1], s = units[_i][2], speed = m / s;
  dls_rigid bodies[2] = {
      {.mass = 3 * kg, .R = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .x = {0, 0, m}, .v = {0, 0, -2 * speed}},
      {.mass = INFINITY, .R = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .v = {speed}}};
  for (int i = 0; i < 3; i++)
    bodies[0].inertia[4 * i] = 2 * kg * m * m;
  double H[144], q[12], r[12], mu[4] = {0.1, 0.1, 0.1, 0.1};
  int body[8];
  for (int k = 0; k < 4; k++) {
    const double p[] = {m * (k % 2 ? 1 : -1), m * (k / 2 ? 1 : -1), 0}, n[] = {0, 0, 7};
    ck_assert_int_eq(dls_rigid_contact(2, bodies, 0, 1, p, n, 0, k, body, H, q, NULL, NULL),
                     DLS_OK);
    ck_assert(body[2 * k] == 0 && body[2 * k + 1] == -1);
  }
  const dls_contact problem = {.d = 3, .nc = 4, .q = q, .mu = mu, .bodies = {6, 2, body, H, NULL}};
  dls_solver_settings settings = settings_with(DLS_AUTO, 1e-12);
  ck_assert_int_ge(dls_solve(&problem, &settings, r, NULL, NULL, NULL), 0);
  ck_assert_int_eq(dls_rigid_apply(2, bodies, 4, body, H, r, NULL), DLS_OK);
  const double v[] = {0.2 * speed, 0, 0}, belt[] = {speed, 0, 0};
  for (int i = 0; i < 3; i++) {
    ck_assert_double_eq_tol(bodies[0].v[i], v[i], 1e-9 * speed);
    ck_assert_double_eq(bodies[1].v[i], belt[i]);
  }
  ck_assert_double_eq_tol(r[0] + r[3] + r[6] + r[9], 6 * kg * speed, 1e-9 * kg * speed);
}

TEST(wrong_input) {
  const dls_rigid sound = {
      .mass = 1, .inertia = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .R = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  dls_rigid bodies[2] = {sound, sound};
  double p[] = {0, 0, 0}, n[] = {0, 0, 1}, H[36], q[3] = {9}, r[3] = {1}, frame[9] = {9};
  int body[2] = {5, 5};
  dls_error e;
#define EXPECT(call, status, function, name, index)                                                \
  do {                                                                                             \
    expect_error(call, &e, status, function, name, index);                                         \
    ck_assert(q[0] == 9 && frame[0] == 9 && body[0] == 5);                                         \
  } while (0)
#define CONTACT(count, bodies, a, b, p, n, gap, k, body, H, q)                                     \
  dls_rigid_contact(count, bodies, a, b, p, n, gap, k, body, H, q, frame, &e)
#define WRONG(status, name, index, ...)                                                            \
  EXPECT(CONTACT(__VA_ARGS__), status, "dls_rigid_contact", name, index)
  WRONG(DLS_E_SIZE, "count", -1, -1, bodies, 0, 1, p, n, 0, 0, body, H, q);
  WRONG(DLS_E_ARGUMENT, "bodies", -1, 2, NULL, 0, 1, p, n, 0, 0, body, H, q);
  WRONG(DLS_E_ARGUMENT, "a", -1, 2, bodies, -2, 1, p, n, 0, 0, body, H, q);
  WRONG(DLS_E_ARGUMENT, "b", -1, 2, bodies, 0, 2, p, n, 0, 0, body, H, q);
  WRONG(DLS_E_ARGUMENT, "b", -1, 2, bodies, 1, 1, p, n, 0, 0, body, H, q);
  WRONG(DLS_E_ARGUMENT, "b", -1, 2, bodies, -1, -1, p, n, 0, 0, body, H, q);
  WRONG(DLS_E_ARGUMENT, "point", -1, 2, bodies, 0, 1, NULL, n, 0, 0, body, H, q);
  WRONG(DLS_E_ARGUMENT, "normal", -1, 2, bodies, 0, 1, p, NULL, 0, 0, body, H, q);
  WRONG(DLS_E_ARGUMENT, "normal", -1, 2, bodies, 0, 1, p, p, 0, 0, body, H, q);
  WRONG(DLS_E_NOT_FINITE, "gap", -1, 2, bodies, 0, 1, p, n, NAN, 0, body, H, q);
  WRONG(DLS_E_ARGUMENT, "k", -1, 2, bodies, 0, 1, p, n, 0, -1, body, H, q);
  WRONG(DLS_E_ARGUMENT, "body", -1, 2, bodies, 0, 1, p, n, 0, 0, NULL, H, q);
  WRONG(DLS_E_ARGUMENT, "H", -1, 2, bodies, 0, 1, p, n, 0, 0, body, NULL, q);
  WRONG(DLS_E_ARGUMENT, "q", -1, 2, bodies, 0, 1, p, n, 0, 0, body, H, NULL);
  p[1] = INFINITY;
  WRONG(DLS_E_NOT_FINITE, "point", 1, 2, bodies, 0, 1, p, n, 0, 0, body, H, q);
  p[1] = 0;
  n[0] = NAN;
  WRONG(DLS_E_NOT_FINITE, "normal", 0, 2, bodies, 0, 1, p, n, 0, 0, body, H, q);
  n[0] = 0;
  const struct {
    size_t at;
    double value;
    dls_status status;
  } bad[] = {{offsetof(dls_rigid, mass), 0, DLS_E_ARGUMENT},
             {offsetof(dls_rigid, mass), NAN, DLS_E_ARGUMENT},
             {offsetof(dls_rigid, inertia) + 4 * sizeof(double), -1, DLS_E_ARGUMENT},
             {offsetof(dls_rigid, inertia) + sizeof(double), 0.5, DLS_E_ARGUMENT},
             {offsetof(dls_rigid, inertia) + sizeof(double), NAN, DLS_E_ARGUMENT},
             {offsetof(dls_rigid, R), 2, DLS_E_ARGUMENT},
             {offsetof(dls_rigid, R), NAN, DLS_E_NOT_FINITE},
             {offsetof(dls_rigid, x), NAN, DLS_E_NOT_FINITE},
             {offsetof(dls_rigid, v), INFINITY, DLS_E_NOT_FINITE},
             {offsetof(dls_rigid, w), NAN, DLS_E_NOT_FINITE}};
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
    memcpy((char *)&bodies[1] + bad[k].at, &bad[k].value, sizeof(double));
    WRONG(bad[k].status, "bodies", 1, 2, bodies, 0, 1, p, n, 0, 0, body, H, q);
    EXPECT(dls_rigid_apply(2, bodies, 0, NULL, NULL, NULL, &e), bad[k].status, "dls_rigid_apply",
           "bodies", 1);
    bodies[1] = sound;
  }
  ck_assert_int_eq(dls_rigid_contact(2, bodies, 0, 1, p, n, 0, 0, body, H, q, NULL, NULL), DLS_OK);
#define APPLY(status, name, index, ...)                                                            \
  expect_error(dls_rigid_apply(__VA_ARGS__, &e), &e, status, "dls_rigid_apply", name, index)
  APPLY(DLS_E_SIZE, "nc", -1, 2, bodies, -1, body, H, r);
  APPLY(DLS_E_ARGUMENT, "bodies", -1, 2, NULL, 1, body, H, r);
  APPLY(DLS_E_ARGUMENT, "body", -1, 2, bodies, 1, NULL, H, r);
  APPLY(DLS_E_ARGUMENT, "H", -1, 2, bodies, 1, body, NULL, r);
  APPLY(DLS_E_ARGUMENT, "r", -1, 2, bodies, 1, body, H, NULL);
  APPLY(DLS_E_ARGUMENT, "body", 1, 1, bodies, 1, body, H, r);
  r[2] = NAN;
  APPLY(DLS_E_NOT_FINITE, "r", 2, 2, bodies, 1, body, H, r);
  r[2] = 0;
  H[20] = NAN;
  APPLY(DLS_E_NOT_FINITE, "H", 18, 2, bodies, 1, body, H, r);
  ck_assert_mem_eq(bodies, ((dls_rigid[]){sound, sound}), sizeof bodies);
}
