/* doors.c: implements doors.h. */
#include "doors.h"

#include <check.h>

/* Defines what DECLARE_DOOR declares, from the public functions of a method. */
#define DOOR(NAME, METHOD)                                                                         \
  dls_##NAME##_settings NAME##_tol(double tol) {                                                   \
    dls_##NAME##_settings s;                                                                       \
    dls_##NAME##_settings_init(&s);                                                                \
    s.limits.tol = tol;                                                                            \
    return s;                                                                                      \
  }                                                                                                \
  static void NAME##_init(const tested_solver *self, void *settings, double tol, int warm_start) { \
    (void)self;                                                                                    \
    dls_##NAME##_settings *s = settings;                                                           \
    *s = NAME##_tol(tol);                                                                          \
    s->limits.warm_start = warm_start;                                                             \
  }                                                                                                \
  static dls_limits *NAME##_limits(void *settings) {                                               \
    return &((dls_##NAME##_settings *)settings)->limits;                                           \
  }                                                                                                \
  static dls_status NAME##_create(void **work, int d, int nc, const void *settings,                \
                                  dls_error *error) {                                              \
    dls_##NAME *own;                                                                               \
    const dls_status status = dls_##NAME##_create(work ? &own : NULL, d, nc, settings, error);     \
    if (work) *work = own;                                                                         \
    return status;                                                                                 \
  }                                                                                                \
  static dls_status NAME##_solve(void *work, const dls_contact *p, double *r, double *u,           \
                                 dls_info *info, dls_error *error) {                               \
    return dls_##NAME##_solve(work, p, r, u, info, error);                                         \
  }                                                                                                \
  static void NAME##_destroy(void *work) {                                                         \
    dls_##NAME##_destroy(work);                                                                    \
  }                                                                                                \
  const tested_solver the_##NAME = {.name = "dls_" #NAME,                                          \
                                    .workspace = "workspace",                                      \
                                    .method = METHOD,                                              \
                                    .settings_size = sizeof(dls_##NAME##_settings),                \
                                    .init = NAME##_init,                                           \
                                    .limits = NAME##_limits,                                       \
                                    .create = NAME##_create,                                       \
                                    .solve = NAME##_solve,                                         \
                                    .destroy = NAME##_destroy};                                    \
  dls_status run_##NAME(const dls_contact *p, const dls_##NAME##_settings *settings, double *r,    \
                        double *u, dls_info *info) {                                               \
    return run_with(&the_##NAME, p, settings, settings->limits.tol, r, u, info);                   \
  }

DOOR(nlgs, DLS_NLGS)
DOOR(newton, DLS_NEWTON)
DOOR(admm, DLS_ADMM)
DOOR(augmented, DLS_AUGMENTED_LAGRANGIAN)

/* ---- dls_solver ------------------------------------------------------------------------------ */

static void front_init(const tested_solver *self, void *settings, double tol, int warm_start) {
  dls_solver_settings *s = settings;
  dls_solver_settings_init(s);
  s->method = self->method;
  s->limits.tol = tol;
  s->limits.warm_start = warm_start;
}

static dls_limits *front_limits(void *settings) {
  return &((dls_solver_settings *)settings)->limits;
}

static dls_status front_create(void **work, int d, int nc, const void *settings, dls_error *error) {
  dls_solver *own;
  const dls_status status = dls_solver_create(work ? &own : NULL, d, nc, settings, error);
  if (work) *work = own;
  return status;
}

static dls_status front_solve(void *work, const dls_contact *p, double *r, double *u,
                              dls_info *info, dls_error *error) {
  return dls_solver_solve(work, p, r, u, info, error);
}

static void front_destroy(void *work) {
  dls_solver_destroy(work);
}

/* ---- all of them ----------------------------------------------------------------------------- */

int method_count(void) {
  int count = 0;
  while (dls_method_name((dls_method)count))
    count++;
  return count;
}

tested_solver door(int k) {
  const tested_solver *const direct[direct_doors] = {&the_nlgs, &the_newton, &the_admm,
                                                     &the_augmented};
  if (k < direct_doors) return *direct[k];
  const dls_method method = (dls_method)(k - direct_doors);
  ck_assert_ptr_nonnull(dls_method_name(method));
  return (tested_solver){.name = "dls_solver",
                         .workspace = "solver",
                         .method = method,
                         .restarts = method == DLS_LEMKE || method == DLS_PENALTY,
                         .tol = method == DLS_PENALTY ? 1e-4 : 0,
                         .settings_size = sizeof(dls_solver_settings),
                         .init = front_init,
                         .limits = front_limits,
                         .create = front_create,
                         .solve = front_solve,
                         .destroy = front_destroy};
}
