/* solvers_own.c: a method of delassus, or a step of auto, under measure() (solvers.h). */
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "solvers.h"

void own_settings(dls_solver_settings *settings, const own_method *w, const dls_contact *problem,
                  double tol) {
  dls_solver_settings_init(settings);
  settings->limits.tol = tol;
  settings->limits.cpu_seconds = w->limit;
  if (problem->Wb.x) settings->limits.blocks = problem->Wb.p[problem->nc];
  if (!dls_method_find(w->method, &settings->method) ||
      !dls_acceleration_find(w->acceleration, &settings->acceleration))
    abort(); /* a name in a table is wrong */
  settings->plan = w->step;
  if (settings->method == DLS_NLGS) settings->limits.max_iterations = 100000000; /* CPU ends it */
}

/* Reduces a global problem, which counts as part of the solve. */
static dls_status own_reduce(const scene *s, dls_reduction **reduction, dls_contact *contact) {
  dls_status status = bench_reduce(reduction, s->model, NULL);
  if (!status) status = dls_reduction_load(*reduction, s->f, s->g, NULL);
  if (!status) status = dls_reduction_contact(*reduction, s->contact.mu, contact, NULL);
  return status;
}

/* Solves `calls` times from r = 0, by the solver, or by dls_solve where solver is NULL. */
static dls_status own_calls(const scene *s, dls_solver *solver, const dls_solver_settings *settings,
                            int calls, double *r, dls_info *info, double *cpu) {
  dls_status status = DLS_OK;
  const double start = bench_seconds();
  for (int k = 0; k < calls && status >= 0; k++) {
    dls_reduction *reduction = NULL;
    dls_contact reduced;
    const dls_contact *contact = s->model ? &reduced : &s->contact;
    status = s->model ? own_reduce(s, &reduction, &reduced) : DLS_OK;
    memset(r, 0, (size_t)s->contact.d * (size_t)s->contact.nc * sizeof *r);
    if (!status)
      status = solver ? dls_solver_solve(solver, contact, r, NULL, info, NULL)
                      : dls_solve(contact, settings, r, NULL, info, NULL);
    if (s->model) dls_reduction_destroy(reduction);
  }
  *cpu = (bench_seconds() - start) / calls;
  return status;
}

void own_solve(const void *how, const scene *s, double tol, int calls, double *r, outcome *o) {
  const own_method *w = how;
  dls_solver_settings settings;
  dls_solver *solver = NULL;
  dls_info info = {.iterations = -1}, *filled = w->no_info ? NULL : &info;
  own_settings(&settings, w, &s->contact, tol);
  if (calls > 1) settings.limits.cpu_seconds = 0; /* short ones: a clock read would be half of it */
  const double start = bench_seconds();
  dls_status status = dls_solver_create(&solver, s->contact.d, s->contact.nc, &settings, NULL);
  const double created = bench_seconds();
  if (!status) status = own_calls(s, solver, &settings, calls, r, filled, &o->cpu);
  const double solved = bench_seconds();
  dls_solver_destroy(solver);
  o->setup = created - start + bench_seconds() - solved;
  if (w->setup && calls > 1 && status >= 0) {
    double single;
    status = own_calls(s, NULL, &settings, calls, r, filled, &single);
    o->setup = single - o->cpu;
  }
  o->ended = status < 0 ? REFUSED : ENDED;
  o->claim = status == DLS_OK;
  o->status = status, o->iterations = info.iterations;
}
