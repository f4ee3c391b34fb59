/*
 * host_rigid.c: rigid bodies as they are. Three discs stand upon each other on the floor, the top
 * one is pushed to the right; one step of time. The host does not form W = H^T M^-1 H.
 *
 * Output:
 *   solved: impulses 0.5886 0.3924 0.1962, friction -0.0020 0.0061 -0.0343, top at 0.0828 m/s
 */
#include <delassus.h>
#include <math.h>
#include <stdio.h>

enum { discs = 3, n = 3, d = 2 }; /* motions of a body: x, y and spin */

int main(void) {
  const double mass = 2, radius = 0.1, step = 0.01, gravity = 9.81, push = 0.1;
  const double a = 1 / sqrt(mass), spin = radius / sqrt(mass * radius * radius / 2);
  double H[2 * discs * d * n], q[d * discs] = {0}, mu[discs], r[d * discs];
  int body[2 * discs];
  for (int c = 0; c < discs; c++) { /* candidate c: disc c on disc c - 1, -1 is the floor */
    /* how the normal, then the tangent reaction moves the upper disc, then the lower one */
    const double both[2 * d * n] = {0, a, 0, a, 0, spin, 0, -a, 0, -a, 0, spin};
    for (int k = 0; k < 2 * d * n; k++)
      H[2 * d * n * c + k] = both[k];
    body[2 * c] = c;
    body[2 * c + 1] = c - 1;
    mu[c] = 0.3;
  }
  q[0] = -gravity * step; /* all fall, so that only the lowest candidate closes */
  q[d * (discs - 1) + 1] = push;
  dls_contact problem = {.d = d, .nc = discs, .q = q, .mu = mu};
  problem.bodies = (dls_bodies){n, discs, body, H, NULL};
  dls_error error;
  const dls_status status = dls_solve(&problem, NULL, r, NULL, NULL, &error);
  if (status < 0) return fprintf(stderr, "%s\n", error.message);
  printf("%s: impulses %.4f %.4f %.4f, friction %.4f %.4f %.4f, top at %.4f m/s\n",
         dls_status_text(status), r[0], r[2], r[4], r[1], r[3], r[5], push + r[5] / mass);
  return 0;
}
