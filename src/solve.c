/*
 * solve.c: the front door. Chooses the method, and has the last word: whatever a method says of
 * itself, "solved" is what the certificate of the returned r says.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/admm.h"
#include "delassus/augmented.h"
#include "delassus/facets.h"
#include "delassus/lcp.h"
#include "delassus/newton.h"
#include "delassus/nlgs.h"
#include "delassus/solve.h"
#include "dlsi.h"

enum {
  default_facets = 8,
  most_fallback_rows = 4000, /* d = 2: of a 4-row form that create still has room for */
  polish_sweeps = 30,
  polish_rounds = 3
};

struct dls_solver {
  dls_solver_settings settings;
  int d, nc;
  dls_nlgs *nlgs;            /* DLS_NLGS; DLS_LEMKE: sweeps between Newton steps */
  dls_augmented *augmented;  /* DLS_AUGMENTED_LAGRANGIAN, DLS_PENALTY */
  dls_newton *newton;        /* DLS_NEWTON; DLS_LEMKE: those steps */
  dls_admm *admm;            /* DLS_ADMM */
  dls_lemke *lemke;          /* DLS_LEMKE, with the LCP that it solves: */
  int facets;                /* of the cone; d = 2: 2 */
  int n;                     /* rows there is room for */
  void *memory;              /* of the arrays below */
  double *M, *q;             /* n x n, n */
  double *z;                 /* n */
  double *s;                 /* scales r_c = s_c r'_c, nc */
  double *r, *u, *a, *F, *w; /* m, m, m, m, nc */
  double *best;              /* m */
};

static const struct {
  dls_method method;
  const char *name;
} methods[] = {{DLS_NLGS, "nlgs"},
               {DLS_LEMKE, "lemke"},
               {DLS_NEWTON, "newton"},
               {DLS_ADMM, "admm"},
               {DLS_AUGMENTED_LAGRANGIAN, "augmented-lagrangian"},
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
  if (s->facets && (s->facets < 4 || s->facets > DLS_FACETS_MAX || s->facets % 2))
    return dlsi_fail(error, DLS_E_ARGUMENT, function, "settings.facets", -1, s->facets,
                     "is %d, must be even, 4 to %d, or 0", s->facets, DLS_FACETS_MAX);
  if (s->acceleration && s->method != DLS_NLGS)
    return dlsi_fail(error, DLS_E_ARGUMENT, function, "settings.acceleration", -1, s->acceleration,
                     "is for nlgs");
  return DLS_OK;
}

static void carve(dls_solver *solver, dlsi_arena *arena) {
  const size_t D = sizeof(double), n = (size_t)solver->n, nc = (size_t)solver->nc;
  const size_t m = (size_t)solver->d * nc;
  solver->M = dlsi_take(arena, n, n * D);
  solver->q = dlsi_take(arena, n, D);
  solver->z = dlsi_take(arena, n, D);
  solver->s = dlsi_take(arena, nc, D);
  solver->r = dlsi_take(arena, m, D);
  solver->u = dlsi_take(arena, m, D);
  solver->a = dlsi_take(arena, m, D);
  solver->F = dlsi_take(arena, m, D);
  solver->w = dlsi_take(arena, nc, D);
  solver->best = dlsi_take(arena, m, D);
}

static dls_status create_lemke(dls_solver *solver, dls_error *error) {
  const long long nc = solver->nc;
  const int given = solver->settings.facets;
  solver->facets = solver->d == 2 ? 2 : given ? given : default_facets;
  long long n = (solver->facets + 2) * nc;
  if (solver->d == 2 && n > most_fallback_rows) n = 3 * nc; /* no room for the 4-row form */
  if (n > INT32_MAX / 4)
    return dlsi_fail(error, DLS_E_SIZE, "dls_solver_create", "nc", -1, solver->nc, "is too large");
  solver->n = (int)n;
  dlsi_arena arena = {0};
  carve(solver, &arena);
  arena.size = arena.used;
  solver->memory = arena.failed ? NULL : dlsi_alloc(arena.size, 1);
  if (!solver->memory)
    return dlsi_fail(error, DLS_E_MEMORY, "dls_solver_create", "", -1, 0, "out of memory");
  arena.base = solver->memory;
  arena.used = 0;
  carve(solver, &arena);
  dls_lemke_settings s;
  dls_lemke_settings_init(&s);
  s.tol = solver->settings.tol;
  s.max_iterations = solver->settings.max_iterations;
  s.warm_start = solver->settings.warm_start;
  s.progress = solver->settings.progress;
  s.progress_data = solver->settings.progress_data;
  const dls_status status = dls_lemke_create(&solver->lemke, solver->n, &s, error);
  if (status) return status;
  dls_nlgs_settings sweeps;
  dls_nlgs_settings_init(&sweeps);
  sweeps.tol = solver->settings.tol;
  sweeps.max_iterations = polish_sweeps;
  sweeps.warm_start = 1;
  const dls_status created = dls_nlgs_create(&solver->nlgs, solver->d, solver->nc, &sweeps, error);
  if (created) return created;
  dls_newton_settings steps;
  dls_newton_settings_init(&steps);
  steps.tol = solver->settings.tol;
  steps.sweeps = 0;
  steps.warm_start = 1;
  return dls_newton_create(&solver->newton, solver->d, solver->nc, &steps, error);
}

static dls_status create_newton(dls_solver *solver, dls_error *error) {
  dls_newton_settings s;
  dls_newton_settings_init(&s);
  s.tol = solver->settings.tol;
  if (solver->settings.max_iterations) s.max_iterations = solver->settings.max_iterations;
  s.warm_start = solver->settings.warm_start;
  s.progress = solver->settings.progress;
  s.progress_data = solver->settings.progress_data;
  return dls_newton_create(&solver->newton, solver->d, solver->nc, &s, error);
}

static dls_status create_nlgs(dls_solver *solver, dls_error *error) {
  dls_nlgs_settings s;
  dls_nlgs_settings_init(&s);
  s.tol = solver->settings.tol;
  if (solver->settings.max_iterations) s.max_iterations = solver->settings.max_iterations;
  s.warm_start = solver->settings.warm_start;
  s.progress = solver->settings.progress;
  s.progress_data = solver->settings.progress_data;
  s.acceleration = solver->settings.acceleration;
  return dls_nlgs_create(&solver->nlgs, solver->d, solver->nc, &s, error);
}

static const double large_penalty = 1e6; /* of the penalty method, in 1 / w_c */

static dls_status create_augmented(dls_solver *solver, dls_error *error) {
  dls_augmented_settings s;
  dls_augmented_settings_init(&s);
  s.tol = solver->settings.tol;
  if (solver->settings.max_iterations) s.max_iterations = solver->settings.max_iterations;
  s.warm_start = solver->settings.warm_start;
  s.progress = solver->settings.progress;
  s.progress_data = solver->settings.progress_data;
  if (solver->settings.method == DLS_PENALTY) {
    s.max_iterations = 1;
    s.factor = large_penalty;
    s.adaptive = 0;
    s.warm_start = 0;
  }
  return dls_augmented_create(&solver->augmented, solver->d, solver->nc, &s, error);
}

static dls_status create_admm(dls_solver *solver, dls_error *error) {
  dls_admm_settings s;
  dls_admm_settings_init(&s);
  s.tol = solver->settings.tol;
  if (solver->settings.max_iterations) s.max_iterations = solver->settings.max_iterations;
  s.blocks = 1; /* the storage of W is not known yet: the first solve takes the room */
  s.warm_start = solver->settings.warm_start;
  s.progress = solver->settings.progress;
  s.progress_data = solver->settings.progress_data;
  return dls_admm_create(&solver->admm, solver->d, solver->nc, &s, error);
}

static dls_status create_method(dls_solver *solver, dls_error *error) {
  switch (solver->settings.method) {
  case DLS_LEMKE:
    return create_lemke(solver, error);
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
  status = create_method(solver, error);
  if (status) {
    dls_solver_destroy(solver);
    return status;
  }
  *out = solver;
  return DLS_OK;
}

/* Measures solver->r; *best and solver->best keep the one with the smallest residual. */
static void offer(dls_solver *solver, const dls_contact *problem, dls_certificate *best) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  dls_certificate certificate;
  dlsi_contact_multiply(problem, solver->r, solver->u, solver->a);
  dlsi_contact_measure(problem, solver->r, solver->u, solver->a, solver->w, solver->F,
                       &certificate);
  if (!(certificate.residual < best->residual)) return;
  *best = certificate;
  memcpy(solver->best, solver->r, m * sizeof *solver->r);
}

/* Solves the LCP of facets (0: the 3-row form) in scaled unknowns, starting (warm) from the states
 * of solver->z, and offers its reactions. Returns the status of the LCP, or an error. */
static dls_status pivot(dls_solver *solver, const dls_contact *problem, int facets, int *pivots,
                        dls_certificate *best, dls_error *error) {
  const double *s = solver->s;
  const int n = facets ? dls_contact_facets_size(problem, facets) : dls_contact_lcp_size(problem);
  dls_status status =
      facets ? dls_contact_to_facets_lcp(problem, facets, s, solver->M, n, solver->q, error)
             : dls_contact_to_lcp(problem, s, solver->M, n, solver->q, error);
  if (status) return status;
  if (facets) memset(solver->z, 0, (size_t)n * sizeof *solver->z);
  const dls_lcp lcp = {n, {n, n, n, solver->M}, solver->q};
  dls_lemke_info info;
  status = dls_lemke_solve(solver->lemke, &lcp, solver->z, NULL, &info, error);
  if (status < 0) return status;
  *pivots += info.pivots;
  const dls_status mapped =
      facets ? dls_contact_from_facets_lcp(problem, facets, s, solver->z, solver->r, error)
             : dls_contact_from_lcp(problem, s, solver->z, solver->r, error);
  if (mapped) return mapped;
  offer(solver, problem, best);
  return status;
}

/* From the LCP's reactions to the round cone by Newton's method; where the states of the candidates
 * cycle, Gauss-Seidel sweeps sort them out, and again. (Not from the best r so far: r = 0 may have
 * the smaller residual, but not the states.) */
static dls_status polish(dls_solver *solver, const dls_contact *problem, dls_certificate *best,
                         dls_error *error) {
  const double tol = solver->settings.tol;
  for (int round = 1; !dls_certificate_holds(best, tol) && round <= polish_rounds; round++) {
    if (round > 1) {
      const dls_status status = dls_nlgs_solve(solver->nlgs, problem, solver->r, NULL, NULL, error);
      if (status < 0) return status;
      offer(solver, problem, best);
    }
    dls_error why;
    const dls_status status =
        dls_newton_solve(solver->newton, problem, solver->r, NULL, NULL, &why);
    if (status == DLS_E_UNSUPPORTED) return DLS_OK; /* many blocks, no MUMPS: left as it is */
    if (status < 0) {
      if (error) *error = why;
      return status;
    }
    offer(solver, problem, best);
  }
  return DLS_OK;
}

/* d = 2: the 3-row form, after a ray the 4-row form. d = 3: the faceted cone. Then what the LCP
 * left is polished away. The certificate decides. */
static dls_status solve_by_lemke(dls_solver *solver, const dls_contact *problem, double *r,
                                 double *u, dls_info *info, dls_error *error) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const int flat = problem->d == 2;
  int pivots = 0;
  dls_certificate best = {.residual = INFINITY};
  dlsi_contact_weights(problem, solver->w);
  if (solver->settings.warm_start) {
    memcpy(solver->r, r, m * sizeof *r);
    offer(solver, problem, &best);
    if (flat) dlsi_friction_start(problem, solver->w, solver->r, solver->u, solver->z);
  }
  memset(solver->r, 0, m * sizeof *r);
  offer(solver, problem, &best);
  for (int c = 0; c < problem->nc; c++)
    solver->s[c] = 1 / sqrt(solver->w[c]);
  dls_status status = pivot(solver, problem, flat ? 0 : solver->facets, &pivots, &best, error);
  if (flat && status == DLS_RAY && dls_contact_facets_size(problem, 2) <= solver->n)
    status = pivot(solver, problem, 2, &pivots, &best, error);
  if (status < 0) return status;
  if (!flat && status == DLS_NO_SOLUTION) status = DLS_RAY; /* the round cone holds more */
  if (status == DLS_OK || status == DLS_RAY || status == DLS_STALLED) {
    const dls_status polished = polish(solver, problem, &best, error);
    if (polished) return polished;
  }
  if (dls_certificate_holds(&best, solver->settings.tol))
    status = DLS_OK;
  else if (status == DLS_OK)
    status = DLS_STALLED;
  memcpy(r, solver->best, m * sizeof *r);
  if (u) dlsi_contact_multiply(problem, r, u, NULL);
  if (info) {
    memset(info, 0, sizeof *info);
    info->status = status;
    info->method = DLS_LEMKE;
    info->iterations = pivots;
    info->certificate = best;
  }
  return status;
}

dls_status dls_solver_solve(dls_solver *solver, const dls_contact *problem, double *r, double *u,
                            dls_info *info, dls_error *error) {
  if (!solver) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "solver", -1, 0, "is NULL");
  const dls_status status = dlsi_check_solve(__func__, solver->d, solver->nc, problem, r,
                                             solver->settings.warm_start, error);
  if (status) return status;
  if (solver->settings.method == DLS_LEMKE)
    return solve_by_lemke(solver, problem, r, u, info, error);
  if (solver->augmented) {
    const dls_status outcome = dls_augmented_solve(solver->augmented, problem, r, u, info, error);
    if (info && outcome >= 0) info->method = solver->settings.method;
    return outcome;
  }
  if (solver->settings.method == DLS_NEWTON)
    return dls_newton_solve(solver->newton, problem, r, u, info, error);
  if (solver->settings.method == DLS_ADMM)
    return dls_admm_solve(solver->admm, problem, r, u, info, error);
  return dls_nlgs_solve(solver->nlgs, problem, r, u, info, error);
}

void dls_solver_destroy(dls_solver *solver) {
  if (!solver) return;
  dls_nlgs_destroy(solver->nlgs);
  dls_augmented_destroy(solver->augmented);
  dls_newton_destroy(solver->newton);
  dls_admm_destroy(solver->admm);
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
