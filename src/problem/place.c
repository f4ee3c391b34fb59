/* place.c: the contact problem of a model: reduced to W, or on K. */
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

dls_status problem_take_load(problem *p, dls_error *error) {
  const dls_status status = dls_reduction_load(p->reduction, p->f, p->g, error);
  return status ? status : problem_take_contact(p, error);
}

dls_status reduce_to_W(dls_reduction **out, const dls_model *model, dls_error *error) {
  dls_reduction_settings settings;
  dls_reduction_settings_init(&settings);
  settings.on = DLS_ON_W;
  return dls_reduction_create(out, model, &settings, error);
}

dls_status problem_condense(problem *p, const source *from, dls_error *error) {
  dls_reduction_settings settings;
  dls_reduction_settings_init(&settings);
  settings.on = from->solves ? from->matrices.on : DLS_ON_W;
  settings.allow_indefinite = p->matrices != NULL;
  settings.progress = show_reduction;
  const double start = cpu_seconds();
  const dls_model *model = &p->model;
  if (from->engine && model->operator_kind == DLS_STIFFNESS_SPARSE && !model->P.p &&
      model->nodes > 0) {
    p->engine = from->engine;
    settings.on = DLS_ON_K;
  }
  dls_status status = dls_reduction_create(&p->reduction, &p->model, &settings, error);
  if (!status) status = problem_take_load(p, error);
  if (!status && p->engine) status = p->engine->take(p, from->matrices.on, error);
  p->reduction_cpu_seconds = cpu_seconds() - start;
  return status;
}
