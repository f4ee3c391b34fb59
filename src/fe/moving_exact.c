/*
 * moving_exact.c: the closed forms of the bars that meet a wall [Doyen, Ern, Piperno 2011], by
 * waves F up and G down the bar, u' = F(t - x/c) + G(t + x/c), force = rho c (F - G) at the wall.
 */
#include <math.h>

#include "moving_internal.h"

/* E 900, rho 1, L 10: c = 30, rho c = 30, a wave is back after 2 L / c = 2/3. */
static const double back = 2.0 / 3;

/* The bar falls from 5 with velocity 10: contact from 1/2 until the wave is back, then flight
 * without stress. */
void dlsi_exact_impact(double t, double *gap, double *force) {
  const double first = 0.5, last = first + back;
  *gap = t < first ? 10 * (first - t) : t > last ? 10 * (t - last) : 0;
  *force = t > first && t < last ? 300 : 0;
}

/* The bar falls from 5 under g = 10. In the frame that falls with it, s after the first contact at
 * t = 1, the wall moves at 10 + 10 s. G(s) = F(s - 2/3); F = G where the end is free.
 *
 *   contact   s in [0, 2/3]     F = 10 + 10 s, G = 0                     force 300 + 300 s
 *   flight    s in [2/3, 8/3]   F = 10 + 10 mod(s, 2/3), gap' = 2 F - 10 - 10 s
 *   contact   s in [8/3, 10/3]  with s' = s - 8/3: G = 10 + 10 s', F = 80/3   force 500 - 300 s'
 *   flight    from 10/3 on, without stress, at 10 - 10 (s - 10/3): at rest at 5 at t = 16/3
 */
void dlsi_exact_bounce(double t, double *gap, double *force) {
  const double period = 16.0 / 3, s = fmod(t, period) - 1;
  *gap = *force = 0;
  if (s < 0)
    *gap = 5 - 5 * (s + 1) * (s + 1);
  else if (s < back)
    *force = 300 + 300 * s;
  else if (s < 4 * back) {
    /* the integral of F over a whole back is 10 back + 5 back^2 */
    const double turns = floor(s / back), rest = s - turns * back;
    const double way = (turns - 1) * (10 * back + 5 * back * back) + 10 * rest + 5 * rest * rest;
    *gap = 2 * way - 10 * (s - back) - 5 * (s * s - back * back);
  } else if (s < 5 * back)
    *force = 500 - 300 * (s - 4 * back);
  else
    *gap = 10 * (s - 5 * back) - 5 * (s - 5 * back) * (s - 5 * back);
}

/* E = rho = L = 1, held at the top, released at u = (1 - x) / 2: the lower end moves at -1/2, rests
 * on the wall for one unit of time at the force 1/2, goes back; the period is 3. */
void dlsi_exact_fixed(double t, double *gap, double *force) {
  const double s = fmod(t, 3);
  *gap = s < 1 ? (1 - s) / 2 : s > 2 ? (s - 2) / 2 : 0;
  *force = s > 1 && s < 2 ? 0.5 : 0;
}
