/*
 * solve.c: the front door. Chooses the method, and has the last word: whatever a method says of
 * itself, "solved" is what the certificate of the returned r says.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/lcp.h"
#include "delassus/nlgs.h"
#include "delassus/solve.h"
#include "dlsi.h"

struct dls_solver {
  dls_solver_settings settings;
  int d, nc;
  dls_nlgs *nlgs;            /* DLS_NLGS */
  dls_lemke *lemke;          /* DLS_LEMKE, with the LCP that it solves: */
  void *memory;              /* of the arrays below */
  double *M, *q;             /* n x n, n; n = 3 nc */
  double *z;                 /* n */
  double *s;                 /* scales r_c = s_c r'_c, nc */
  double *r, *u, *a, *F, *w; /* m, m, m, m, nc */
};

static const struct {
  dls_method method;
  const char *name;
} methods[] = {{DLS_NLGS, "nlgs"}, {DLS_LEMKE, "lemke"}};

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

void dls_solver_settings_init(dls_solver_settings *settings) {
  if (!settings) return;
  memset(settings, 0, sizeof *settings);
  settings->size = sizeof *settings;
  settings->method = DLS_NLGS;
  settings->tol = 1e-8;
}

static dls_status check_settings(const char *function, const dls_solver_settings *s,
                                 dls_error *error) {
  if (!s) return dlsi_fail(error, DLS_E_ARGUMENT, function, "settings", -1, 0, "is NULL");
  if (s->size != sizeof *s)
    return dlsi_fail(error, DLS_E_SETTINGS, function, "settings", -1, 0,
                     "must be filled by dls_solver_settings_init first");
  if (!dls_method_name(s->method))
    return dlsi_fail(error, DLS_E_ARGUMENT, function, "settings.method", -1, s->method,
                     "%d is no method", (int)s->method);
  if (!(s->tol >= 0 && isfinite(s->tol)))
    return dlsi_fail(error, DLS_E_ARGUMENT, function, "settings.tol", -1, s->tol,
                     "must be finite and not negative");
  if (s->max_iterations < 0)
    return dlsi_fail(error, DLS_E_ARGUMENT, function, "settings.max_iterations", -1,
                     s->max_iterations, "is negative");
  return DLS_OK;
}

static void carve(dls_solver *solver, size_t m, size_t n, size_t nc, dlsi_arena *arena) {
  const size_t D = sizeof(double);
  solver->M = dlsi_take(arena, n, n * D);
  solver->q = dlsi_take(arena, n, D);
  solver->z = dlsi_take(arena, n, D);
  solver->s = dlsi_take(arena, nc, D);
  solver->r = dlsi_take(arena, m, D);
  solver->u = dlsi_take(arena, m, D);
  solver->a = dlsi_take(arena, m, D);
  solver->F = dlsi_take(arena, m, D);
  solver->w = dlsi_take(arena, nc, D);
}

static dls_status create_lemke(dls_solver *solver, dls_error *error) {
  const size_t nc = (size_t)solver->nc, m = 2 * nc, n = 3 * nc;
  if (solver->d != 2)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "dls_solver_create", "settings.method", -1, 0,
                     "lemke is for d = 2");
  if (n > INT32_MAX)
    return dlsi_fail(error, DLS_E_SIZE, "dls_solver_create", "nc", -1, solver->nc, "is too large");
  dlsi_arena arena = {0};
  carve(solver, m, n, nc, &arena);
  arena.size = arena.used;
  solver->memory = arena.failed ? NULL : dlsi_alloc(arena.size, 1);
  if (!solver->memory)
    return dlsi_fail(error, DLS_E_MEMORY, "dls_solver_create", "", -1, 0, "out of memory");
  arena.base = solver->memory;
  arena.used = 0;
  carve(solver, m, n, nc, &arena);
  dls_lemke_settings s;
  dls_lemke_settings_init(&s);
  s.tol = solver->settings.tol;
  s.max_iterations = solver->settings.max_iterations;
  s.progress = solver->settings.progress;
  s.progress_data = solver->settings.progress_data;
  return dls_lemke_create(&solver->lemke, (int)n, &s, error);
}

static dls_status create_nlgs(dls_solver *solver, dls_error *error) {
  dls_nlgs_settings s;
  dls_nlgs_settings_init(&s);
  s.tol = solver->settings.tol;
  if (solver->settings.max_iterations) s.max_iterations = solver->settings.max_iterations;
  s.warm_start = solver->settings.warm_start;
  s.progress = solver->settings.progress;
  s.progress_data = solver->settings.progress_data;
  return dls_nlgs_create(&solver->nlgs, solver->d, solver->nc, &s, error);
}

dls_status dls_solver_create(dls_solver **out, int d, int nc, const dls_solver_settings *settings,
                             dls_error *error) {
  if (!out) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "out", -1, 0, "is NULL");
  *out = NULL;
  dls_status status = check_settings(__func__, settings, error);
  if (status) return status;
  if (d != 2 && d != 3)
    return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "d", -1, d, "is %d, must be 2 or 3", d);
  if (nc < 1 || nc > INT32_MAX / d)
    return dlsi_fail(error, DLS_E_SIZE, __func__, "nc", -1, nc, "is %d", nc);
  dls_solver *solver = dlsi_alloc(1, sizeof *solver);
  if (!solver) return dlsi_fail(error, DLS_E_MEMORY, __func__, "", -1, 0, "out of memory");
  memset(solver, 0, sizeof *solver);
  solver->settings = *settings;
  solver->d = d;
  solver->nc = nc;
  status = settings->method == DLS_LEMKE ? create_lemke(solver, error) : create_nlgs(solver, error);
  if (status) {
    dls_solver_destroy(solver);
    return status;
  }
  *out = solver;
  return DLS_OK;
}

/* The contact problem through its LCP in scaled unknowns; the certificate of r decides. */
static dls_status solve_by_lemke(dls_solver *solver, const dls_contact *problem, double *r,
                                 double *u, dls_info *info, dls_error *error) {
  const size_t m = 2 * (size_t)problem->nc;
  const int n = dls_contact_lcp_size(problem);
  dlsi_contact_weights(problem, solver->w);
  for (int c = 0; c < problem->nc; c++)
    solver->s[c] = 1 / sqrt(solver->w[c]);
  dls_status status = dls_contact_to_lcp(problem, solver->s, solver->M, n, solver->q, error);
  if (status) return status;
  const dls_lcp lcp = {n, {n, n, n, solver->M}, solver->q};
  dls_lemke_info pivoting;
  status = dls_lemke_solve(solver->lemke, &lcp, solver->z, NULL, &pivoting, error);
  if (status < 0) return status;
  const dls_status mapped = dls_contact_from_lcp(problem, solver->s, solver->z, solver->r, error);
  if (mapped) return mapped;
  dlsi_contact_multiply(problem, solver->r, solver->u, solver->a);
  dls_certificate certificate;
  dlsi_contact_measure(problem, solver->r, solver->u, solver->a, solver->w, solver->F,
                       &certificate);
  if (dls_certificate_holds(&certificate, solver->settings.tol))
    status = DLS_OK;
  else if (status == DLS_OK)
    status = DLS_STALLED;
  memcpy(r, solver->r, m * sizeof *r);
  if (u) memcpy(u, solver->u, m * sizeof *u);
  if (info) {
    memset(info, 0, sizeof *info);
    info->status = status;
    info->method = DLS_LEMKE;
    info->iterations = pivoting.pivots;
    info->certificate = certificate;
  }
  return status;
}

dls_status dls_solver_solve(dls_solver *solver, const dls_contact *problem, double *r, double *u,
                            dls_info *info, dls_error *error) {
  if (!solver) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "solver", -1, 0, "is NULL");
  const dls_status status = dlsi_check_contact(__func__, problem, error);
  if (status) return status;
  if (problem->d != solver->d || problem->nc > solver->nc)
    return dlsi_fail(error, DLS_E_SIZE, __func__, "problem", -1, problem->nc,
                     "has d = %d, nc = %d; the solver was made for d = %d, nc <= %d", problem->d,
                     problem->nc, solver->d, solver->nc);
  if (!r) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "r", -1, 0, "is NULL");
  if (solver->settings.method == DLS_LEMKE)
    return solve_by_lemke(solver, problem, r, u, info, error);
  return dls_nlgs_solve(solver->nlgs, problem, r, u, info, error);
}

void dls_solver_destroy(dls_solver *solver) {
  if (!solver) return;
  dls_nlgs_destroy(solver->nlgs);
  dls_lemke_destroy(solver->lemke);
  free(solver->memory);
  free(solver);
}

dls_status dls_solve(const dls_contact *problem, const dls_solver_settings *settings, double *r,
                     double *u, dls_info *info, dls_error *error) {
  dls_solver_settings defaults;
  dls_solver_settings_init(&defaults);
  dls_status status = dlsi_check_contact(__func__, problem, error);
  if (status) return status;
  dls_solver *solver;
  status =
      dls_solver_create(&solver, problem->d, problem->nc, settings ? settings : &defaults, error);
  if (status) return status;
  status = dls_solver_solve(solver, problem, r, u, info, error);
  dls_solver_destroy(solver);
  return status;
}
