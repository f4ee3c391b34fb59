/* frame.c: completes the frame (n, t[, s]) of a normal, as docs/files.md defines it. */
#include <math.h>

#include "contact.h"

int dlsi_frame(int d, double frame[3][3]) {
  double *a = frame[0], *t = frame[1], *s = frame[2], size = 0;
  for (int k = 0; k < d; k++)
    size = hypot(size, a[k]);
  if (!(size > 0 && isfinite(size))) return 0;
  for (int k = 0; k < d; k++)
    a[k] /= size;
  if (d == 2) {
    t[0] = a[1];
    t[1] = -a[0];
    return 1;
  }
  int least = 0;
  for (int k = 1; k < 3; k++)
    if (fabs(a[k]) < fabs(a[least])) least = k;
  for (int k = 0; k < 3; k++)
    t[k] = (k == least) - a[least] * a[k];
  const double length = sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
  for (int k = 0; k < 3; k++)
    t[k] /= length;
  for (int k = 0; k < 3; k++)
    s[k] = a[(k + 1) % 3] * t[(k + 2) % 3] - a[(k + 2) % 3] * t[(k + 1) % 3];
  return 1;
}
