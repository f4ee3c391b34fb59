/*
 * host_two_bodies.c: two elastic bodies whose nodes do not match. The lower one, 7 nodes at 0, 1 ..
 * 6, stands on springs; the upper one, 5 nodes at 0, 1.5 .. 6, lies on it and nothing but contact
 * holds it. Each node of the upper one is a candidate: its place relative to the
 * straight line between two nodes below. Pressed by 10, more so at the right, then sheared, mu .5.
 *
 * Output:
 *   shear 0.0: stick stick stick stick stick carries 10.0000, holds back 0.0000
 *   shear 2.4: stick stick stick stick stick carries 10.0000, holds back 2.4000
 *   shear 4.8: slip slip slip slip stick carries 10.0000, holds back 4.8000
 */
#include <stdio.h>

#include "delassus/motion.h"

enum { lower = 7, upper = 5, n = 2 * (lower + upper) };

static int pk[n + 1], ik[2 * n], ph[upper + 1], ih[2][3 * upper];
static double xk[2 * n], xh[3 * upper];

int main(void) {
  for (int j = 0; j < n; j++) { /* K: springs between neighbours; below, springs to the ground */
    const int node = j / 2, first = node < lower ? 0 : lower, last = node < lower ? lower : n / 2;
    pk[j + 1] = 2 * (j + 1);
    ik[2 * j] = j;
    xk[2 * j] = 100 * ((node > first) + (node + 1 < last)) + (node < lower ? 20 : 0);
    ik[2 * j + 1] = node + 1 < last ? j + 2 : j; /* the lower triangle */
    xk[2 * j + 1] = node + 1 < last ? -100 : 0;
  }
  for (int c = 0; c < upper; c++) { /* H: node c above against the line from left to left + 1 */
    const int left = c < upper - 1 ? 3 * c / 2 : lower - 2;
    const double x[] = {1, 1.5 * c - left - 1, left - 1.5 * c};
    ph[c + 1] = 3 * (c + 1);
    for (int e = 0; e < 3; e++) {
      const int node = e == 0 ? lower + c : left + e - 1;
      xh[3 * c + e] = x[e];
      ih[0][3 * c + e] = 2 * node;
      ih[1][3 * c + e] = 2 * node + 1;
    }
  }
  dls_motion_model model = {.d = 2, .n = n, .nodes = upper, .factorization = DLS_CHOLESKY};
  model.K = (dls_sparse){n, n, pk, ik, xk};
  model.HT = (dls_sparse){n, upper, ph, ih[0], xh};
  model.HN = (dls_sparse){n, upper, ph, ih[1], xh};
  dls_motion_settings settings;
  dls_motion_settings_init(&settings);
  settings.law = DLS_MOTION_PATH;
  settings.h = 1;
  dls_error error;
  dls_motion *motion;
  dls_motion_state s;
  const double mu[] = {0.5, 0.5, 0.5, 0.5, 0.5};
  dls_status status = dls_motion_create(&motion, &model, &settings, &error);
  for (int step = 0; !status && step < 3; step++) {
    double f[n] = {0}, up = 0, back = 0;
    for (int c = 0; c < upper; c++) {
      f[2 * (lower + c)] = 0.48 * step; /* in all 2.4, 4.8 */
      f[2 * (lower + c) + 1] = -1 - 0.5 * c;
    }
    status = dls_motion_step(motion, f, NULL, mu, NULL, &error);
    if (!status) status = dls_motion_get_state(motion, &s, &error);
    if (status) break;
    printf("shear %.1f: ", 2.4 * step);
    for (int c = 0; c < upper; c++) {
      printf("%s ", s.state[c] == DLS_STICK ? "stick" : "slip");
      up += s.p[2 * c];
      back -= s.p[2 * c + 1];
    }
    printf("carries %.4f, holds back %.4f\n", up, back);
  }
  dls_motion_destroy(motion);
  if (status) fprintf(stderr, "%s\n", status < 0 ? error.message : dls_status_text(status));
  return status != 0;
}
