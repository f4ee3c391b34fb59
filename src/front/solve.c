/*
 * solve.c: the front door. Chooses the method, and has the last word: whatever a method says of
 * itself, "solved" is what the certificate of the returned r says.
 */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/admm.h"
#include "delassus/augmented.h"
#include "delassus/facets.h"
#include "delassus/newton.h"
#include "delassus/nlgs.h"
#include "front/front.h"

struct dls_solver {
  dls_solver_settings settings;
  int d, nc;
  int runaway; /* the last solve ended in DLS_NO_SOLUTION_LIKELY */
  /* the one of the method */
  dls_nlgs *nlgs;
  dls_newton *newton;
  dls_admm *admm;
  dls_augmented *augmented; /* DLS_AUGMENTED_LAGRANGIAN, DLS_PENALTY */
  dlsi_pivoting *pivoting;  /* DLS_LEMKE */
  dlsi_auto *automatic;     /* DLS_AUTO */
};

static const struct {
  dls_method method;
  const char *name;
} methods[] = {{DLS_AUTO, "auto"},      {DLS_NLGS, "nlgs"},
               {DLS_LEMKE, "lemke"},    {DLS_NEWTON, "newton"},
               {DLS_ADMM, "admm"},      {DLS_AUGMENTED_LAGRANGIAN, "augmented-lagrangian"},
               {DLS_PENALTY, "penalty"}};

const char *dls_method_name(dls_method method) {
  for (size_t k = 0; k < sizeof methods / sizeof methods[0]; k++)
    if (methods[k].method == method) return methods[k].name;
  return NULL;
}

int dls_method_find(const char *name, dls_method *method) {
  for (size_t k = 0; name && method && k < sizeof methods / sizeof methods[0]; k++)
    if (strcmp(methods[k].name, name) == 0) {
      *method = methods[k].method;
      return 1;
    }
  return 0;
}

int dls_acceleration_find(const char *name, dls_acceleration *acceleration) {
  static const char *const names[] = {[DLS_ACCELERATION_NONE] = "none",
                                      [DLS_ACCELERATION_AITKEN] = "aitken",
                                      [DLS_ACCELERATION_ANDERSON] = "anderson"};
  for (int k = 0; name && acceleration && k < (int)(sizeof names / sizeof names[0]); k++)
    if (strcmp(names[k], name) == 0) {
      *acceleration = (dls_acceleration)k;
      return 1;
    }
  return 0;
}

void dls_solver_settings_init(dls_solver_settings *settings) {
  if (!settings) return;
  *settings = (dls_solver_settings){.size = sizeof *settings};
  dlsi_limits_init(&settings->limits);
}

static dls_status check_settings(const dls_solver_settings *s, dls_error *error) {
  const dlsi_setting own[] = {{"positive_definite", s->positive_definite, 0, 1, 0}};
  const dls_status status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 1, own, error);
  if (status) return status;
  if (!dls_method_name(s->method))
    return dlsi_fail(error, DLS_E_ARGUMENT, "method", -1, s->method, "%d is no method",
                     (int)s->method);
  if (s->facets && (s->facets < 4 || s->facets > DLS_FACETS_MAX || s->facets % 2))
    return dlsi_fail(error, DLS_E_ARGUMENT, "facets", -1, s->facets,
                     "is %d, must be even, 4 to %d, or 0", s->facets, DLS_FACETS_MAX);
  if (s->acceleration && s->method != DLS_NLGS)
    return dlsi_fail(error, DLS_E_ARGUMENT, "acceleration", -1, s->acceleration, "is for nlgs");
  return DLS_OK;
}

static dls_status create_newton(dls_solver *solver, dls_error *error) {
  dls_newton_settings s;
  dls_newton_settings_init(&s);
  s.limits.tol = solver->settings.limits.tol;
  if (solver->settings.limits.max_iterations)
    s.limits.max_iterations = solver->settings.limits.max_iterations;
  s.limits.blocks = solver->settings.limits.blocks;
  if (solver->settings.positive_definite) s.regularization = 0;
  s.limits.warm_start = solver->settings.limits.warm_start;
  s.limits.progress = solver->settings.limits.progress;
  s.limits.progress_data = solver->settings.limits.progress_data;
  return dls_newton_create(&solver->newton, solver->d, solver->nc, &s, error);
}

static dls_status create_nlgs(dls_solver *solver, dls_error *error) {
  dls_nlgs_settings s;
  dls_nlgs_settings_init(&s);
  s.limits.tol = solver->settings.limits.tol;
  if (solver->settings.limits.max_iterations)
    s.limits.max_iterations = solver->settings.limits.max_iterations;
  s.limits.warm_start = solver->settings.limits.warm_start;
  s.limits.progress = solver->settings.limits.progress;
  s.limits.progress_data = solver->settings.limits.progress_data;
  s.acceleration = solver->settings.acceleration;
  return dls_nlgs_create(&solver->nlgs, solver->d, solver->nc, &s, error);
}

static const double large_penalty = 1e6; /* of the penalty method, in 1 / w_c */

static dls_status create_augmented(dls_solver *solver, dls_error *error) {
  dls_augmented_settings s;
  dls_augmented_settings_init(&s);
  s.limits.blocks = solver->settings.limits.blocks;
  s.limits.tol = solver->settings.limits.tol;
  if (solver->settings.limits.max_iterations)
    s.limits.max_iterations = solver->settings.limits.max_iterations;
  s.limits.warm_start = solver->settings.limits.warm_start;
  s.limits.progress = solver->settings.limits.progress;
  s.limits.progress_data = solver->settings.limits.progress_data;
  if (solver->settings.method == DLS_PENALTY) {
    s.limits.max_iterations = 1;
    s.factor = large_penalty;
    s.adaptive = 0;
    s.limits.warm_start = 0;
  }
  return dls_augmented_create(&solver->augmented, solver->d, solver->nc, &s, error);
}

static dls_status create_admm(dls_solver *solver, dls_error *error) {
  dls_admm_settings s;
  dls_admm_settings_init(&s);
  s.limits.tol = solver->settings.limits.tol;
  if (solver->settings.limits.max_iterations)
    s.limits.max_iterations = solver->settings.limits.max_iterations;
  s.limits.blocks = solver->settings.limits.blocks;
  s.limits.warm_start = solver->settings.limits.warm_start;
  s.limits.progress = solver->settings.limits.progress;
  s.limits.progress_data = solver->settings.limits.progress_data;
  return dls_admm_create(&solver->admm, solver->d, solver->nc, &s, error);
}

/* complete = 0: see dlsi_auto_create */
static dls_status create_method(dls_solver *solver, int complete, dls_error *error) {
  switch (solver->settings.method) {
  case DLS_AUTO:
    return dlsi_auto_create(&solver->automatic, solver->d, solver->nc, &solver->settings, complete,
                            error);
  case DLS_LEMKE:
    return dlsi_pivoting_create(&solver->pivoting, solver->d, solver->nc, &solver->settings, error);
  case DLS_NEWTON:
    return create_newton(solver, error);
  case DLS_ADMM:
    return create_admm(solver, error);
  case DLS_AUGMENTED_LAGRANGIAN:
  case DLS_PENALTY:
    return create_augmented(solver, error);
  default:
    return create_nlgs(solver, error);
  }
}

dls_status dls_solver_create(dls_solver **out, int d, int nc, const dls_solver_settings *settings,
                             dls_error *error) {
  if (!out) return dlsi_at(__func__, dlsi_is_null(error, "out"), error);
  *out = NULL;
  dls_solver_settings defaults;
  dls_solver_settings_init(&defaults);
  if (!settings) settings = &defaults;
  dls_status status = check_settings(settings, error);
  if (!status) status = dlsi_check_sizes(d, nc, error);
  if (status) return dlsi_at(__func__, status, error);
  dls_solver *solver = dlsi_alloc(1, sizeof *solver);
  if (!solver) return dlsi_at(__func__, dlsi_no_memory(error), error);
  memset(solver, 0, sizeof *solver);
  solver->settings = *settings;
  solver->d = d;
  solver->nc = nc;
  status = create_method(solver, 1, error);
  if (status) {
    dls_solver_destroy(solver);
    return dlsi_at(__func__, status, error);
  }
  *out = solver;
  return DLS_OK;
}

static dls_status solve_by_augmented(dls_solver *solver, const dls_contact *problem, double *r,
                                     double *u, dls_info *info, dls_error *error) {
  dls_status status = dlsi_augmented_solve(solver->augmented, problem, r, u, info, error);
  if (status == DLS_STALLED && dls_augmented_direction(solver->augmented))
    status = DLS_NO_SOLUTION_LIKELY;
  if (info && status >= 0) {
    info->status = status;
    info->method = solver->settings.method;
  }
  return status;
}

static dls_status solve_by_method(dls_solver *solver, const dls_contact *problem, double *r,
                                  double *u, dls_info *info, dls_error *error) {
  switch (solver->settings.method) {
  case DLS_AUTO:
    return dlsi_auto_solve(solver->automatic, problem, r, u, info, error);
  case DLS_LEMKE:
    return dlsi_pivoting_solve(solver->pivoting, problem, r, u, info, error);
  case DLS_NEWTON:
    return dlsi_newton_run(solver->newton, problem, NULL, r, u, info, error);
  case DLS_ADMM:
    return dlsi_admm_solve(solver->admm, problem, r, u, info, error);
  case DLS_AUGMENTED_LAGRANGIAN:
  case DLS_PENALTY:
    return solve_by_augmented(solver, problem, r, u, info, error);
  default:
    return dls_nlgs_solve(solver->nlgs, problem, r, u, info, error);
  }
}

/* ---- short calls, of which checks and calls by themselves are the larger part ------------------ */

/* Finite numbers have a finite sum, or one that has overflown; others never have. */
static inline dlsi_pair add(dlsi_pair sum, const double *x, int n) {
  int i = 0;
  for (; i + 4 <= n; i += 4)
    sum += dlsi_load(x + i) + dlsi_load(x + i + 2);
  if (n & 2) sum += dlsi_load(x + i);
  if (n & 1) sum[0] += x[n - 1];
  return sum;
}

/* ... and without more blocks than there are places */
static DLSI_NOINLINE int is_pattern(const int *p, const int *i, int n) {
  if (!p || !i || p[0] != 0 || p[n] > n * n) return 0;
  for (int j = 0; j < n; j++)
    if (p[j + 1] < p[j]) return 0;
  for (int k = 0; k < p[n]; k++)
    if (i[k] < 0 || i[k] >= n) return 0;
  return 1;
}

/* 1 if dlsi_check_contact finds nothing amiss: told sooner, because nothing has to be named; 0: ask that.
 * *pressed: whether q_n < 0 somewhere. */
static inline int is_sound(const dls_contact *problem, int *pressed) {
  const int d = problem->d, nc = problem->nc;
  const dls_dense *W = &problem->W;
  const dls_blocks *B = &problem->Wb;
  const double *q = problem->q, *mu = problem->mu;
  if ((d != 2 && d != 3) || nc < 1 || nc > DLSI_FEW || !q || !mu) return 0;
  const int m = d * nc;
  dlsi_pair sum = {0, 0};
  if (!B->x && W->a && W->rows == m && W->cols == m && W->ld == m)
    sum = add(sum, W->a, m * m);
  else if (B->x && !W->a && B->d == d && B->n == nc && is_pattern(B->p, B->i, nc))
    sum = add(sum, B->x, B->p[nc] * d * d);
  else
    return 0;
  sum = add(sum, q, m);
  double all = sum[0] + sum[1];
  *pressed = 0;
  for (int c = 0; c < nc; c++, q += d) {
    if (mu[c] < 0) return 0;
    all += mu[c];
    *pressed |= *q < 0;
  }
  return fabs(all) <= DBL_MAX;
}

static int is_pressed(const dls_contact *problem) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  size_t i = 0;
  while (i < m && problem->q[i] >= 0)
    i += d;
  return i < m;
}

/* r = 0, the answer where nobody is pressed: F is 0, and no bit of it rounded */
static inline void answer_free(const dls_contact *problem, double *r, double *u, dls_info *info) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  const double *q = problem->q;
  for (size_t i = 0; i < m; i += d) {
    r[i] = r[i + 1] = 0;
    if (d == 3) r[i + 2] = 0;
    if (!u) continue;
    memcpy(u + i, q + i, 2 * sizeof *u);
    if (d == 3) u[i + 2] = q[i + 2];
  }
  if (info) dlsi_alone_report(info, 0, &(dls_certificate){0});
}

/* 1 if auto's answer needs no workspace */
static int answer(const dls_solver_settings *settings, const dls_contact *problem, double *r,
                  double *u, dls_info *info) {
  if (settings->method != DLS_AUTO || settings->limits.warm_start) return 0;
  if (is_pressed(problem))
    return problem->nc <= DLSI_FEW && dlsi_alone_solve(problem, settings->limits.tol, r, u, info);
  answer_free(problem, r, u, info);
  return 1;
}

/* ---- solve ----------------------------------------------------------------------------------- */

/* What has been checked. This and the next stay out of dls_solver_solve, for its few registers. */
static DLSI_NOINLINE dls_status solve(dls_solver *solver, const dls_contact *problem, double *r,
                                      double *u, dls_info *info, dls_error *error) {
  solver->runaway = 0;
  if (answer(&solver->settings, problem, r, u, info)) return DLS_OK;
  const dls_status status = solve_by_method(solver, problem, r, u, info, error);
  solver->runaway = status == DLS_NO_SOLUTION_LIKELY;
  return status;
}

static DLSI_NOINLINE dls_status check_and_solve(dls_solver *solver, const dls_contact *problem,
                                                double *r, double *u, dls_info *info,
                                                dls_error *error) {
  if (!solver) return dlsi_is_null(error, "solver");
  if (!problem) return dlsi_check_contact(NULL, error);
  const dls_status status = dlsi_check_solve(solver->d, solver->nc, problem, r,
                                             solver->settings.limits.warm_start, error);
  return status ? status : solve(solver, problem, r, u, info, error);
}

dls_status dls_solver_solve(dls_solver *solver, const dls_contact *problem, double *r, double *u,
                            dls_info *info, dls_error *error) {
  int pressed;
  if (!solver || !problem || !r || solver->settings.method != DLS_AUTO ||
      solver->settings.limits.warm_start || problem->d != solver->d || problem->nc > solver->nc ||
      !is_sound(problem, &pressed))
    return dlsi_at(__func__, check_and_solve(solver, problem, r, u, info, error), error);
  if (pressed) return dlsi_at(__func__, solve(solver, problem, r, u, info, error), error);
  answer_free(problem, r, u, info);
  solver->runaway = 0;
  return DLS_OK;
}

const double *dls_solver_direction(const dls_solver *solver) {
  if (!solver || !solver->runaway) return NULL;
  return solver->automatic ? dlsi_auto_direction(solver->automatic)
                           : dls_augmented_direction(solver->augmented);
}

static void destroy_method(dls_solver *solver) {
  dls_nlgs_destroy(solver->nlgs);
  dls_newton_destroy(solver->newton);
  dls_admm_destroy(solver->admm);
  dls_augmented_destroy(solver->augmented);
  dlsi_pivoting_destroy(solver->pivoting);
  dlsi_auto_destroy(solver->automatic);
}

void dls_solver_destroy(dls_solver *solver) {
  if (!solver) return;
  destroy_method(solver);
  free(solver);
}

dls_status dls_solve(const dls_contact *problem, const dls_solver_settings *settings, double *r,
                     double *u, dls_info *info, dls_error *error) {
  int pressed;
  if (!problem) return dlsi_at(__func__, dlsi_check_contact(NULL, error), error);
  dls_status status = is_sound(problem, &pressed) ? DLS_OK : dlsi_check_contact(problem, error);
  if (!status && settings) status = check_settings(settings, error);
  if (status) return dlsi_at(__func__, status, error);
  dls_solver_settings s;
  if (!settings) dls_solver_settings_init(&s);
  const dls_solver_settings *given = settings ? settings : &s;
  status = dlsi_check_start(problem, r, given->limits.warm_start, error);
  if (status) return dlsi_at(__func__, status, error);
  if (answer(given, problem, r, u, info)) return DLS_OK;
  if (settings) s = *settings;
  s.limits.blocks = problem->Wb.x ? problem->Wb.p[problem->nc] : 0;
  dls_solver solver = {.settings = s, .d = problem->d, .nc = problem->nc};
  status = create_method(&solver, 0, error);
  if (!status) status = solve_by_method(&solver, problem, r, u, info, error);
  destroy_method(&solver);
  return dlsi_at(__func__, status, error);
}
