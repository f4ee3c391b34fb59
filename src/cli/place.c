/* place.c: the contact problem of a model that has been reduced to W, or is solved on K. */
#include "cli.h"

dls_status problem_take_contact(problem *p, dls_error *error) {
  dls_reduction_info info;
  const dls_status status = dls_reduction_get_info(p->reduction, &info, error);
  if (status) return status;
  p->on_K = info.on == DLS_ON_K;
  if (!p->on_K) return dls_reduction_contact(p->reduction, p->mu, &p->contact, error);
  p->contact = (dls_contact){.d = p->model.d, .nc = info.contacts, .mu = p->mu};
  return DLS_OK;
}
