/* test_linkage.c: moving bodies held by joints, given twice: multipliers in K or in M. */
#include "delassus/motion.h"
#include "linkage.h"
#include "run.h"

static linkage L;
static dlsi_columns M, K;
static const double angle = .6, weight = 10;

static void forget(void) {
  linkage_free(&L);
  dlsi_columns_free(&M);
  dlsi_columns_free(&K);
}

/* Two bars of length 1 lean on each other, hinged at the top twice. Masses go to M, joints to M too
 * where `velocities`, else to K. */
static dls_motion_model lean(int velocities) {
  const double c = cos(angle) / 2, s = sin(angle) / 2;
  linkage_new(&L, 2);
  const int a = linkage_body(&L, 1, 1. / 12, weight), b = linkage_body(&L, 1, 1. / 12, weight);
  for (int k = 0; k < 2; k++)
    linkage_pin(&L, a, (double[]){c, s}, b, (double[]){-c, s});
  linkage_contact(&L, a, (double[]){-c, -s});
  linkage_contact(&L, b, (double[]){c, -s});
  const dls_model *model = linkage_model(&L, DLS_CHOLESKY, 1);
  for (int half = 0; half < 2; half++) {
    dlsi_triplets part = L.K;
    part.x = malloc((size_t)part.count * sizeof *part.x);
    ck_assert_ptr_nonnull(part.x);
    for (int k = 0; k < part.count; k++)
      part.x[k] = (part.row[k] < 6 || velocities) == !half ? L.K.x[k] : 0;
    ck_assert(!dlsi_columns_compress(&part, 1, DLSI_ALL, half ? &K : &M, NULL));
    free(part.x);
  }
  return (dls_motion_model){.d = 2,
                            .n = L.n,
                            .nodes = 2,
                            .factorization = DLS_CHOLESKY,
                            .M = dlsi_columns_view(&M),
                            .K = dlsi_columns_view(&K),
                            .HN = model->HN,
                            .HT = model->HT};
}

/* Feet stick at friction .8 and slip at .3; the joint stays closed to rounding all along, for theta
 * = 1/2 and 1, with a K tagged DLS_CHOLESKY. Where M holds the multipliers, velocities are held,
 * and positions drift by their rounding. */
TEST_EACH(leans, 0, 8) {
  const int slips = _i & 1, velocities = _i & 2;
  const double h = 1e-3, mu[2] = {slips ? .3 : .8, slips ? .3 : .8};
  const double thrust = weight / tan(angle) / 2;
  dls_motion *motion;
  dls_motion_settings settings;
  dls_motion_state s;
  dls_motion_energies energies;
  dls_error e = {0};
  dls_motion_settings_init(&settings);
  settings.h = h;
  settings.theta = _i & 4 ? 1 : .5;
  settings.activation = 1e-6;
  const dls_motion_model model = lean(velocities);
  ck_assert_msg(!dls_motion_create(&motion, &model, &settings, &e), "%s", e.message);
  double before = 0, mean = 0;
  for (int k = 1; k <= 200; k++) {
    ck_assert_msg(!dls_motion_step(motion, L.f, NULL, mu, NULL, &e), "%s", e.message);
    ck_assert(!dls_motion_get_state(motion, &s, NULL));
    ck_assert(!dls_motion_get_energies(motion, &energies, NULL));
    if (!velocities) ck_assert(energies.residual <= 1e-13 * energies.scale);
    double x[linkage_most], v[linkage_most] = {0};
    memcpy(x, s.x, (size_t)L.n * sizeof *x);
    memcpy(v, s.v, 6 * sizeof *v);
    ck_assert_msg(!velocities || linkage_apart(&L, v) <= 1e-14, "velocities %g",
                  linkage_apart(&L, v));
    const double sum = s.x[6] + s.x[8];
    mean = (sum + before) / 2;
    before = sum;
    for (int j = 6; j < L.n; j++)
      x[j] = 0;
    double way = 0;
    for (int j = 0; j < 6; j++)
      way = fmax(way, fabs(x[j]));
    const double open = linkage_apart(&L, x) * fmax(way, weight) / fmax(way, weight * h * h);
    ck_assert_msg(velocities || open <= 1e-14, "positions %g", open);
  }
  if (!slips) {
    ck_assert_double_eq_tol(s.p[0] / h, weight, 1e-9);
    ck_assert_double_eq_tol(s.p[1] / h, thrust, 1e-9);
    for (int j = 0; j < 6; j++)
      ck_assert_double_le(fabs(s.x[j]), 1e-12);
    /* the force of the hinge: of the positions' joint, the mean of two steps where theta = 1/2 */
    if (!velocities) ck_assert_double_eq_tol(settings.theta == 1 ? before : mean, thrust, 1e-6);
  } else
    ck_assert(s.x[1] < -.01 && fabs(s.x[1] - s.x[4]) <= 1e-12);
  dls_motion_destroy(motion);
}

TEST(failing_mallocs) {
  dls_motion_settings settings;
  dls_motion_settings_init(&settings);
  settings.h = 1e-3;
  const dls_motion_model model = lean(0);
  dls_motion *motion;
  MALLOCS_FAIL(dls_motion_create(&motion, &model, &settings, NULL), !motion, DLS_OK, 1);
  dls_motion_destroy(motion);
}

int main(void) {
  return run_tests("linkage", NULL, forget);
}
