/*
 * host_path.c: a path of equilibria: press, shear, shear back. A point on springs (1 along, 2
 * across) is pressed by 6 on a rough plane, mu = 1/2: friction holds up to 3. Sheared by 4 it
 * slips until the spring takes 1; without the shear it springs back only if that frees more than
 * friction holds, so it stays; then the plane itself moves away under it, and drags it along.
 * Forces of the same size leave different answers behind: they depend on the path.
 *
 * Output:
 *   load         x      r_n     r_t   slip  state
 *   press     0.00     6.00    0.00   0.00  stick
 *   shear 4   1.00     6.00   -3.00   1.00  slip
 *   shear 0   1.00     6.00    1.00   1.00  stick
 *   plane +1  2.00     6.00    2.00   1.00  stick
 *   plane +2  3.00     6.00    3.00   0.00  slip
 *   work: friction -6.00, plane 8.00, loads 4.00
 */
#include <math.h>
#include <stdio.h>

#include "delassus/motion.h"

/* no "-0.00" */
static double tidy(double x) {
  return fabs(x) < 5e-3 ? 0 : x;
}

int main(void) {
  /* unknowns x, y; K = diag(1, 2); the normal is y, the tangent x */
  const int p[] = {0, 1, 2}, i[] = {0, 1}, one_column[] = {0, 1}, y[] = {1};
  const double k[] = {1, 2}, one[] = {1};
  dls_motion_model model = {.d = 2, .n = 2, .nodes = 1, .factorization = DLS_CHOLESKY};
  model.K = (dls_sparse){2, 2, p, i, k};
  model.HN = (dls_sparse){2, 1, one_column, y, one};
  model.HT = (dls_sparse){2, 1, one_column, i, one};
  dls_motion_settings settings;
  dls_motion_settings_init(&settings);
  settings.law = DLS_MOTION_PATH;
  settings.h = 1; /* so that a velocity of the plane is its way in a step */

  const struct {
    const char *name;
    double f[2], plane[2];
  } steps[] = {{"press", {0, -6}, {0, 0}},
               {"shear 4", {4, -6}, {0, 0}},
               {"shear 0", {0, -6}, {0, 0}},
               {"plane +1", {0, -6}, {0, 1}},
               {"plane +2", {0, -6}, {0, 2}}};
  const char *const names[] = {"free", "slip", "stick"};
  const double mu = 0.5;
  dls_error error;
  dls_motion *motion;
  dls_motion_state s;
  dls_motion_energies e;
  dls_status status = dls_motion_create(&motion, &model, &settings, &error);
  printf("load         x      r_n     r_t   slip  state\n");
  for (int t = 0; !status && t < 5; t++) {
    status = dls_motion_step(motion, steps[t].f, steps[t].plane, &mu, NULL, &error);
    if (!status) status = dls_motion_get_state(motion, &s, &error);
    if (!status)
      printf("%-8s %5.2f %8.2f %7.2f %6.2f  %s\n", steps[t].name, s.x[0], s.p[0], tidy(s.p[1]),
             tidy(s.slip[0]), names[s.state[0]]);
  }
  if (!status) status = dls_motion_get_energies(motion, &e, &error);
  if (!status)
    printf("work: friction %.2f, plane %.2f, loads %.2f\n", e.friction, e.obstacle, e.load);
  dls_motion_destroy(motion);
  if (status) fprintf(stderr, "%s\n", status < 0 ? error.message : dls_status_text(status));
  return status != 0;
}
