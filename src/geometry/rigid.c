/*
 * rigid.c: contacts between rigid bodies as factors H of W = H^T H; velocities from impulses.
 *
 *   I = L L^T in the body's frame,   B = diag(m^-1/2, R L^-T),   B B^T = M^-1
 *   H = B^T J: J_v / sqrt(m) and L^-1 R^T J_w
 *   (v; w) += B H r: sum of H_v r / sqrt(m), and R L^-T times that of H_w r
 *
 * Cost: O(1) a contact: the factor L of both bodies is found anew, 30 operations.
 */
#include <math.h>
#include <string.h>

#include "delassus/rigid.h"
#include "geometry.h"

/* How far R^T R may be from the unit matrix: bodies of engines in single precision drift. */
static const double most_turned = 1e-3;

/* L := Cholesky's factor of the inertia, row-major; returns 0 if that is not positive definite, or
 * not symmetric to single precision. */
static int rigid_factor(const dls_rigid *of, double L[3][3]) {
  memset(L, 0, 9 * sizeof(double));
  for (int j = 0; j < 3; j++)
    for (int i = j; i < 3; i++) {
      double sum = of->inertia[3 * i + j];
      const double other = of->inertia[3 * j + i], size = of->inertia[4 * i] + of->inertia[4 * j];
      if (!(fabs(sum - other) <= 1e-6 * size)) return 0;
      for (int k = 0; k < j; k++)
        sum -= L[i][k] * L[j][k];
      if (i == j && !(sum > 1e-14 * of->inertia[4 * i] && isfinite(sum))) return 0;
      L[i][j] = i == j ? sqrt(sum) : sum / L[j][j];
    }
  return 1;
}

static dls_status rigid_check(const dls_rigid *bodies, int k, dls_error *error) {
  const dls_rigid *of = &bodies[k];
  double L[3][3];
  if (!(of->mass > 0))
    return dlsi_fail(error, DLS_E_ARGUMENT, "bodies", k, of->mass, "body %d: mass is %g", k,
                     of->mass);
  if (dlsi_first_not_finite(of->R, 9) >= 0 || dlsi_first_not_finite(of->x, 3) >= 0 ||
      dlsi_first_not_finite(of->v, 3) >= 0 || dlsi_first_not_finite(of->w, 3) >= 0)
    return dlsi_fail(error, DLS_E_NOT_FINITE, "bodies", k, NAN,
                     "body %d: R, x, v or w is not finite", k);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const double *R = of->R, dot = R[i] * R[j] + R[3 + i] * R[3 + j] + R[6 + i] * R[6 + j];
      if (!(fabs(dot - (i == j)) <= most_turned))
        return dlsi_fail(error, DLS_E_ARGUMENT, "bodies", k, dot, "body %d: R is no rotation", k);
    }
  if (isinf(of->mass) || rigid_factor(of, L)) return DLS_OK;
  return dlsi_fail(error, DLS_E_ARGUMENT, "bodies", k, of->inertia[0],
                   "body %d: inertia is not positive definite", k);
}

/* z := L^-1 R^T turn */
static void rigid_turn(const dls_rigid *of, const double turn[3], double z[3]) {
  double L[3][3];
  (void)rigid_factor(of, L);
  for (int i = 0; i < 3; i++) {
    z[i] = of->R[i] * turn[0] + of->R[3 + i] * turn[1] + of->R[6 + i] * turn[2];
    for (int k = 0; k < i; k++)
      z[i] -= L[i][k] * z[k];
    z[i] /= L[i][i];
  }
}

static dls_status rigid_given(int count, const dls_rigid *bodies, const double *point,
                              const double *normal, double gap, dls_error *error) {
  if (count < 0) return dlsi_fail(error, DLS_E_SIZE, "count", -1, count, "is %d", count);
  if (count > 0 && !bodies) return dlsi_is_null(error, "bodies");
  dls_status status = dlsi_check_vector("point", point, 3, error);
  if (!status) status = dlsi_check_vector("normal", normal, 3, error);
  if (!status && !isfinite(gap))
    status = dlsi_fail(error, DLS_E_NOT_FINITE, "gap", -1, gap, "is %g", gap);
  return status;
}

static dls_status rigid_contact(int count, const dls_rigid *bodies, const int pair[2],
                                const double *point, const double *normal, double gap, int k,
                                int *body, double *H, double *q, double *frame, dls_error *error) {
  static const char *const name[] = {"a", "b"};
  dls_status status = rigid_given(count, bodies, point, normal, gap, error);
  if (!status && k < 0) status = dlsi_fail(error, DLS_E_ARGUMENT, "k", -1, k, "is %d", k);
  if (!status && (!body || !H || !q)) status = dlsi_is_null(error, !body ? "body" : !H ? "H" : "q");
  for (int side = 0; !status && side < 2; side++) {
    if (pair[side] < -1 || pair[side] >= count)
      status = dlsi_fail(error, DLS_E_ARGUMENT, name[side], -1, pair[side], "is %d of %d bodies",
                         pair[side], count);
    else if (pair[side] >= 0)
      status = rigid_check(bodies, pair[side], error);
  }
  if (!status && pair[0] == pair[1])
    status = dlsi_fail(error, DLS_E_ARGUMENT, "b", -1, pair[1], "is %d, as a", pair[1]);
  double e[3][3] = {{0}};
  if (!status) memcpy(e[0], normal, sizeof e[0]);
  if (!status && !dlsi_frame(3, e))
    status = dlsi_fail(error, DLS_E_ARGUMENT, "normal", -1, 0, "is zero");
  if (status) return status;
  double *h = H + 36 * (size_t)k, *u = q + 3 * (size_t)k;
  memset(h, 0, 36 * sizeof *h);
  for (int j = 0; j < 3; j++)
    u[j] = j ? 0 : gap;
  for (int side = 0; side < 2; side++, h += 18) {
    const dls_rigid *of = pair[side] < 0 ? NULL : &bodies[pair[side]];
    const double sign = side ? -1 : 1;
    body[2 * (size_t)k + (size_t)side] = of && isfinite(of->mass) ? pair[side] : -1;
    for (int j = 0; of && j < 3; j++) {
      const double arm[3] = {point[0] - of->x[0], point[1] - of->x[1], point[2] - of->x[2]};
      double turn[3], z[3];
      dlsi_cross3(arm, e[j], turn);
      u[j] += sign * (dlsi_dot3(e[j], of->v) + dlsi_dot3(turn, of->w));
      if (isinf(of->mass)) continue;
      rigid_turn(of, turn, z);
      for (int i = 0; i < 3; i++) {
        h[6 * j + i] = sign * e[j][i] / sqrt(of->mass);
        h[6 * j + 3 + i] = sign * z[i];
      }
    }
  }
  if (frame) memcpy(frame, e, sizeof e);
  return DLS_OK;
}

dls_status dls_rigid_contact(int count, const dls_rigid *bodies, int a, int b, const double *point,
                             const double *normal, double gap, int k, int *body, double *H,
                             double *q, double *frame, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__,
                 rigid_contact(count, bodies, (const int[2]){a, b}, point, normal, gap, k, body, H,
                               q, frame, error),
                 error);
}

static dls_status rigid_apply(int count, dls_rigid *bodies, int nc, const int *body,
                              const double *H, const double *r, dls_error *error) {
  if (nc < 0) return dlsi_fail(error, DLS_E_SIZE, "nc", -1, nc, "is %d", nc);
  static const double none[3] = {0};
  dls_status status = rigid_given(count, bodies, none, none, 0, error);
  if (!status && nc > 0 && (!body || !H)) status = dlsi_is_null(error, !body ? "body" : "H");
  if (!status) status = dlsi_check_vector("r", r, 3 * (size_t)nc, error);
  for (int k = 0; !status && k < count; k++)
    status = rigid_check(bodies, k, error);
  for (size_t k = 0; !status && k < 2 * (size_t)nc; k++) {
    if (body[k] < -1 || body[k] >= count || (body[k] >= 0 && isinf(bodies[body[k]].mass)))
      status = dlsi_fail(error, DLS_E_ARGUMENT, "body", (long long)k, body[k],
                         "is %d, outside of -1 to %d, or of infinite mass", body[k], count - 1);
    else if (body[k] >= 0 && dlsi_first_not_finite(H + 18 * k, 18) >= 0)
      status = dlsi_fail(error, DLS_E_NOT_FINITE, "H", (long long)(18 * k), NAN, "is not finite");
  }
  for (size_t k = 0; !status && k < 2 * (size_t)nc; k++) {
    if (body[k] < 0) continue;
    dls_rigid *of = &bodies[body[k]];
    double L[3][3], z[6] = {0};
    for (int j = 0; j < 3; j++)
      for (int i = 0; i < 6; i++)
        z[i] += H[18 * k + (size_t)(6 * j + i)] * r[3 * (k / 2) + (size_t)j];
    (void)rigid_factor(of, L);
    for (int i = 2; i >= 0; i--) { /* L^-T */
      for (int l = i + 1; l < 3; l++)
        z[3 + i] -= L[l][i] * z[3 + l];
      z[3 + i] /= L[i][i];
    }
    for (int i = 0; i < 3; i++) {
      of->v[i] += z[i] / sqrt(of->mass);
      of->w[i] += dlsi_dot3(of->R + 3 * i, z + 3);
    }
  }
  return status;
}

dls_status dls_rigid_apply(int count, dls_rigid *bodies, int nc, const int *body, const double *H,
                           const double *r, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, rigid_apply(count, bodies, nc, body, H, r, error), error);
}
