/* moving.c: bodies that move, put together entry by entry, and steps that check themselves. */
#include "moving.h"

#include <check.h>
#include <math.h>
#include <string.h>

void moving_begin(moving_parts *parts, int n) {
  memset(parts, 0, sizeof *parts);
  parts->n = n;
}

/* Begins columns up to j. */
static void moving_reach(moving_matrix *A, int j) {
  ck_assert_int_lt(j, moving_columns);
  for (; A->columns <= j; A->columns++)
    A->p[A->columns + 1] = A->p[A->columns];
}

void moving_add(moving_matrix *A, int i, int j, double x) {
  ck_assert_int_ge(j, A->columns - 1);
  moving_reach(A, j);
  const int k = A->p[j + 1]++;
  ck_assert_int_lt(k, moving_entries);
  A->i[k] = i;
  A->x[k] = x;
}

void moving_add_dense(moving_matrix *A, int n, const double *dense) {
  for (int j = 0; j < n; j++)
    for (int i = j; i < n; i++)
      if (i == j || dense[i + j * n] != 0) moving_add(A, i, j, dense[i + j * n]);
}

void moving_touch(moving_parts *parts, int i, int j, double gap) {
  const int c = parts->nodes++;
  moving_reach(&parts->HN, c);
  moving_reach(&parts->HT, c);
  if (i >= 0) moving_add(&parts->HN, i, c, 1);
  if (j >= 0) moving_add(&parts->HT, j, c, 1);
  parts->gap[c] = gap;
}

void moving_body(moving_parts *parts, int b, double x, double y, double mass, double inertia) {
  parts->centre[2 * b] = x;
  parts->centre[2 * b + 1] = y;
  for (int k = 0; k < 3; k++)
    moving_add(&parts->M, 3 * b + k, 3 * b + k, k < 2 ? mass : inertia);
}

/* Adds the velocity along w of the point X of body b, times sign. */
static void moving_arm(moving_parts *parts, moving_matrix *A, int c, int b, const double *X,
                       const double *w, double sign) {
  const double rx = X[0] - parts->centre[2 * b], ry = X[1] - parts->centre[2 * b + 1];
  moving_add(A, 3 * b, c, sign * w[0]);
  moving_add(A, 3 * b + 1, c, sign * w[1]);
  moving_add(A, 3 * b + 2, c, sign * (w[1] * rx - w[0] * ry));
}

void moving_joint(moving_parts *parts, int a, int b, const double *X, double angle, double gap) {
  const double normal[2] = {cos(angle), sin(angle)}, tangent[2] = {normal[1], -normal[0]};
  const int c = parts->nodes++;
  moving_arm(parts, &parts->HN, c, a, X, normal, 1);
  moving_arm(parts, &parts->HT, c, a, X, tangent, 1);
  if (b >= 0) {
    moving_arm(parts, &parts->HN, c, b, X, normal, -1);
    moving_arm(parts, &parts->HT, c, b, X, tangent, -1);
  }
  parts->gap[c] = gap;
}

/* Completes A to `columns` columns. */
static dls_sparse moving_view(moving_matrix *A, int rows, int columns) {
  moving_reach(A, columns - 1);
  return (dls_sparse){rows, columns, A->p, A->i, A->x};
}

dls_motion_model moving_model(moving_parts *parts) {
  const int n = parts->n;
  dls_motion_model model = {
      .d = 2, .n = n, .nodes = parts->nodes, .factorization = DLS_CHOLESKY, .gap = parts->gap};
  if (parts->M.columns) model.M = moving_view(&parts->M, n, n);
  if (parts->C.columns) model.C = moving_view(&parts->C, n, n);
  if (parts->K.columns) model.K = moving_view(&parts->K, n, n);
  model.HN = moving_view(&parts->HN, n, parts->nodes);
  model.HT = moving_view(&parts->HT, n, parts->nodes);
  return model;
}

dls_motion_settings moving_settings(dls_motion_law law, double h) {
  dls_motion_settings settings;
  dls_motion_settings_init(&settings);
  settings.law = law;
  settings.h = h;
  if (law == DLS_MOTION_GAP) settings.theta = 1;
  return settings;
}

dls_motion *moving_create(const dls_motion_model *model, const dls_motion_settings *settings,
                          const double *x, const double *v) {
  dls_motion *motion;
  dls_error error;
  dls_status status = dls_motion_create(&motion, model, settings, &error);
  ck_assert_msg(status == DLS_OK, "%s", error.message);
  status = dls_motion_start(motion, x, v, 0, &error);
  ck_assert_msg(status == DLS_OK, "%s", error.message);
  return motion;
}

dls_motion_state moving_state(const dls_motion *motion) {
  dls_motion_state state;
  ck_assert_int_eq(dls_motion_get_state(motion, &state, NULL), DLS_OK);
  return state;
}

dls_motion_energies moving_energies(const dls_motion *motion) {
  dls_motion_energies energies;
  ck_assert_int_eq(dls_motion_get_energies(motion, &energies, NULL), DLS_OK);
  return energies;
}

dls_motion_state moving_step(dls_motion *motion, const double *f, const double *y,
                             const double *mu) {
  dls_error error = {0};
  dls_info info = {0};
  const dls_status status = dls_motion_step(motion, f, y, mu, &info, &error);
  const dls_motion_state now = moving_state(motion);
  const dls_motion_energies e = moving_energies(motion);
  ck_assert_msg(status == DLS_OK, "step %lld: %s %s, residual %g", now.steps,
                dls_status_text(status), error.message, info.certificate.residual);
  ck_assert_msg(e.residual <= 1e-13 * e.scale && e.momentum <= 1e-11,
                "step %lld: energy %g of %g, momentum %g", now.steps, e.residual, e.scale,
                e.momentum);
  return now;
}
