/* place.c: the contact problem of a model: reduced to W, or on K. */
#include <stdlib.h>
#include <string.h>

#include "matrices.h"

/* Sets p->contact, p->on_K from p->reduction. */
static dls_status problem_take_contact(problem *p, dls_error *error) {
  dls_reduction_info info;
  const dls_status status = dls_reduction_get_info(p->reduction, &info, error);
  if (status) return status;
  p->on_K = info.on == DLS_ON_K;
  if (!p->on_K) return dls_reduction_contact(p->reduction, p->mu, &p->contact, error);
  p->contact = (dls_contact){.d = p->model.d, .nc = info.contacts, .mu = p->mu};
  return DLS_OK;
}

/* Moves the feet of the springs that hold a body until they carry nothing: the contact problem then
 * has the reactions of the free body. */
static dls_status problem_hold(problem *p, dls_error *error) {
  dls_reduction_info held;
  dls_solver_settings settings;
  dls_solver_settings_init(&settings);
  settings.limits.cpu_seconds = 10;
  settings.limits.progress = show_progress;
  dls_status status = dls_reduction_get_info(p->reduction, &held, error);
  if (status || !held.modes || p->on_K) return status;
  const size_t m = (size_t)p->contact.d * (size_t)p->contact.nc;
  double *r = malloc((2 * m + (size_t)p->model.n) * sizeof *r);
  if (!r) return no_memory(error);
  status = dls_reduction_solve(p->reduction, p->mu, &settings, r, r + m, r + 2 * m, NULL, error);
  progress_end();
  free(r);
  const size_t used = strlen(p->note);
  (void)snprintf(p->note + used, sizeof p->note - used, "%s%d rigid-body mode%s held by springs%s",
                 used ? "; " : "", held.modes, plural(held.modes),
                 is_solved(status) ? " that carry nothing at this load" : "");
  return status < 0 ? status : DLS_OK;
}

dls_status problem_condense(problem *p, const source *from, dls_error *error) {
  dls_reduction_settings settings;
  dls_reduction_settings_init(&settings);
  settings.on = from->solves ? from->matrices.on : DLS_ON_W;
  settings.allow_indefinite = p->matrices != NULL;
  settings.stabilize = from->matrices.stabilize;
  settings.progress = show_reduction;
  const double start = cpu_seconds();
  dls_status status = dls_reduction_create_either(&p->reduction, &p->model, &settings, error);
  if (status == DLS_E_SINGULAR && !from->solves) {
    settings.stabilize = 1;
    status = dls_reduction_create_either(&p->reduction, &p->model, &settings, error);
  }
  if (!status) status = dls_reduction_load(p->reduction, p->f, p->g, error);
  if (!status) status = problem_take_contact(p, error);
  if (!status && !from->solves) status = problem_hold(p, error);
  p->reduction_cpu_seconds = cpu_seconds() - start;
  return status;
}
