/*
 * host_joints.c: joints beside contact. A crank turns about the ground, a rod hangs between it and
 * a slider, which lies on the floor (friction .5) and must not turn; a couple of -2 on the crank
 * pushes the slider to the right. The host writes each row of a joint below K: the multipliers are
 * unknowns. All joints are given twice, as models drawn by hand often have them.
 * By hand: the rod carries S = 2 / (R sin(a + b)), the slider stands with 20 + S sin b, and
 * friction holds S cos b.
 *
 * Output:
 *   solved: r_n 21.1696, r_t -4.0026; by hand 21.1696, -4.0026
 *   14 joints, 7 of them redundant; the rod carries 4.1700, by hand 4.1700
 *   joints open by less than 1e-14 of the displacement that the loads would cause: yes
 */
#include <delassus.h>
#include <math.h>
#include <stdio.h>

enum { bodies = 9, joints = 7, n = bodies + 2 * joints }; /* crank, rod, slider: x, y, turn each */

static double K[n * n], f[n];
static int rows = bodies;

/* Adds the velocity of a body's point (X, Y) along (ex, ey), times sign, to the joint `rows`. */
static void point(int body, double X, double Y, double ex, double ey, double sign) {
  const double of[3] = {ex, ey, ey * X - ex * Y};
  for (int k = 0; k < 3; k++)
    K[rows + n * (3 * body + k)] += sign * of[k];
}

/* A pin holds point (X, Y) of a body on point (Z, T) of another one, -1: on the ground. */
static void pin(int body, double X, double Y, int other, double Z, double T) {
  for (int k = 0; k < 2; k++, rows++) {
    point(body, X, Y, k == 0, k == 1, 1);
    if (other >= 0) point(other, Z, T, k == 0, k == 1, -1);
  }
}

int main(void) {
  const double R = 0.5, length = 1.5, a = 1, b = asin(R * sin(a) / length), mu[] = {0.5};
  const double mass[] = {2, 2, 0.1, 1, 1, 0.2, 3, 3, 1}; /* one step of 1 s: x are velocities */
  const double cx = R * cos(a) / 2, cy = R * sin(a) / 2;
  const double lx = length * cos(b) / 2, ly = length * sin(b) / 2;
  for (int k = 0; k < bodies; k++)
    K[k * (n + 1)] = mass[k];
  for (int twice = 0; twice < 2; twice++) {
    pin(0, -cx, -cy, -1, 0, 0);
    pin(0, cx, cy, 1, -lx, ly);
    pin(1, lx, -ly, 2, 0, 0);
    K[rows++ + n * 8] = 1; /* the slider does not turn */
  }
  f[2] = -2;
  f[7] = -20;
  const int p[] = {0, 1}, across[] = {6}, up[] = {7};
  const double one[] = {1};
  dls_model model = {.d = 2, .n = n, .nodes = 1, .K = {n, n, n, K}}; /* the lower triangle */
  model.operator_kind = DLS_STIFFNESS_DENSE;
  model.factorization = DLS_LDLT;
  model.HN = (dls_sparse){n, 1, p, up, one};
  model.HT = (dls_sparse){n, 1, p, across, one};
  dls_reduction *reduction;
  dls_reduction_info info;
  dls_error error;
  double r[2], x[n];
  dls_status status = dls_reduction_create(&reduction, &model, NULL, &error);
  if (!status) status = dls_reduction_load(reduction, f, NULL, &error);
  if (!status) status = dls_reduction_get_info(reduction, &info, &error);
  if (!status) status = dls_reduction_solve(reduction, mu, NULL, r, NULL, x, NULL, &error);
  dls_reduction_destroy(reduction);
  if (status < 0) return fprintf(stderr, "%s\n", error.message);
  const double S = 2 / (R * sin(a + b));
  double force[2] = {0}, open = 0;
  for (int j = bodies; j < n; j++) {
    double gap = -f[j];
    for (int k = 0; k < bodies; k++)
      gap += K[j + n * k] * x[k];
    open = fmax(open, fabs(gap));
  }
  for (int twice = 0; twice < 2; twice++) /* the pin of rod and slider: rows 4 and 5 */
    for (int k = 0; k < 2; k++)
      force[k] += x[bodies + joints * twice + 4 + k];
  printf("%s: r_n %.4f, r_t %.4f; by hand %.4f, %.4f\n", dls_status_text(status), r[0], r[1],
         20 + S * sin(b), -S * cos(b));
  printf("%d joints, %d of them redundant; the rod carries %.4f, by hand %.4f\n", info.joints,
         info.redundant, hypot(force[0], force[1]), S);
  printf("joints open by less than 1e-14 of the displacement that the loads would cause: %s\n",
         open <= 1e-14 * 20 / 3 ? "yes" : "no");
  return 0;
}
