/*
 * host_dynamics.c: two motions of a mass 1 in the plane, unknowns (x, y), normal y, tangent x.
 * A ball falls from 1 m, e = 1/2: the flights halve, and it rests after 3 sqrt(2/g) = 1.3546 s.
 * A block on a belt that runs with .1, held by a spring 1 and pressed by 10, sticks up to mu = .5
 * and slips with .3: it swings with the period 40 + pi + 2 atan(.05) = 43.2415.
 *
 * Output:
 *   ball: rests from 1.354 s, impulse per step m g h: yes
 *   belt: period 43.24, 40.00 of it sticking
 *   energy identity to rounding in every step: yes
 */
#include <math.h>
#include <stdio.h>

#include "delassus/motion.h"

static dls_error error;
static int exact = 1;

static dls_motion *begin(double spring, double h, double e, double height) {
  static const int p[] = {0, 1, 2}, i[] = {0, 1}, column[] = {0, 1}, y[] = {1};
  static const double ones[] = {1, 1};
  static double k[2];
  k[0] = spring;
  dls_motion_model model = {.d = 2, .n = 2, .nodes = 1, .factorization = DLS_CHOLESKY};
  model.M = (dls_sparse){2, 2, p, i, ones};
  model.K = (dls_sparse){2, 2, p, i, k};
  model.HN = (dls_sparse){2, 1, column, y, ones};
  model.HT = (dls_sparse){2, 1, column, i, ones};
  dls_motion_settings settings;
  dls_motion_settings_init(&settings);
  settings.h = h;
  settings.restitution = e;
  dls_motion *motion = NULL;
  const double x[] = {0, height};
  if (dls_motion_create(&motion, &model, &settings, &error) ||
      dls_motion_start(motion, x, NULL, 0, &error))
    fprintf(stderr, "%s\n", error.message);
  return motion;
}

/* Takes a step; returns 1 if that went well, with the state in *s. */
static int step(dls_motion *motion, double fy, double belt, double mu, dls_motion_state *s) {
  const double f[] = {0, fy}, y[] = {0, belt};
  dls_motion_energies e;
  dls_status status = dls_motion_step(motion, f, y, &mu, NULL, &error);
  if (!status) status = dls_motion_get_state(motion, s, &error);
  if (!status) status = dls_motion_get_energies(motion, &e, &error);
  if (status) fprintf(stderr, "%s\n", status < 0 ? error.message : dls_status_text(status));
  exact = exact && !status && e.residual <= 1e-13 * e.scale;
  return !status;
}

int main(void) {
  const double h = 1e-4;
  dls_motion *ball = begin(0, h, 0.5, 1);
  dls_motion_state s = {.t = 0};
  double rest = 0, p = 0, slips[3] = {0}, sticks = 0;
  while (s.t < 2 && step(ball, -9.81, 0, 0, &s)) {
    if (fabs(s.v[1]) > 1e-4 * 9.81 * h) rest = s.t + h;
    p = s.p[0];
  }
  printf("ball: rests from %.3f s, impulse per step m g h: %s\n", rest,
         fabs(p - 9.81 * h) < 1e-9 * h ? "yes" : "no");
  dls_motion_destroy(ball);

  dls_motion *block = begin(1, 1e-3, 0, 0);
  int count = 0, holds = 0, sticking = 0;
  s.t = 0;
  while (count < 2 && s.t < 150 && step(block, -10, 0.1, holds ? 0.5 : 0.3, &s)) {
    if (s.state[0] == DLS_STICK && !sticking) sticks = s.t;
    if (s.state[0] == DLS_SLIP && sticking) slips[count++] = s.t;
    sticking = s.state[0] == DLS_STICK;
    holds = sticking && s.x[0] + 1e-4 <= 5; /* the spring, at the end of the next step */
  }
  printf("belt: period %.2f, %.2f of it sticking\n", slips[1] - slips[0], slips[1] - sticks);
  printf("energy identity to rounding in every step: %s\n", exact ? "yes" : "no");
  dls_motion_destroy(block);
  return !exact;
}
