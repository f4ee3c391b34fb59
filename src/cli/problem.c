/* problem.c: loads FCLIB problems, and condenses them if they are global. */
#include "cli.h"

dls_status problem_load(const char *path, problem *p, dls_error *error) {
  dls_status status = dls_fclib_read(&p->file, path, error);
  if (status) return status;
  if (!dls_fclib_is_global(p->file)) return dls_fclib_contact(p->file, &p->contact, error);
  status = dls_fclib_model(p->file, &p->model, &p->f, &p->g, &p->mu, error);
  if (status) return status;
  const double start = cpu_seconds();
  status = dls_reduction_create(&p->reduction, &p->model, error);
  if (!status) status = dls_reduction_load(p->reduction, p->f, p->g, error);
  if (!status) status = dls_reduction_contact(p->reduction, p->mu, &p->contact, error);
  p->reduction_cpu_seconds = cpu_seconds() - start;
  return status;
}

void problem_free(problem *p) {
  dls_reduction_destroy(p->reduction);
  dls_fclib_destroy(p->file);
}

void problem_print(const char *path, const problem *p) {
  printf("%s: %dD, %d contacts, %s\n", path, p->contact.d, p->contact.nc,
         p->reduction ? "global" : "local");
  if (p->reduction)
    printf("  reduced from %d unknowns in %.3g s of CPU\n", p->model.n, p->reduction_cpu_seconds);
}
