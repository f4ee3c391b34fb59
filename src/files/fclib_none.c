/* fclib_none.c: a build without HDF5 answers DLS_E_UNSUPPORTED. */
#include "delassus/files.h"
#include "files/file.h"

static dls_status unsupported(dls_error *error) {
  return dlsi_fail(error, DLS_E_UNSUPPORTED, "", -1, 0, "built without HDF5");
}

dls_status dls_fclib_read(dls_fclib **out, const char *path, dls_error *error) {
  (void)path;
  if (out) *out = NULL;
  return dlsi_at(__func__, unsupported(error), error);
}

int dls_fclib_is_global(const dls_fclib *file) {
  (void)file;
  return 0;
}

const char *dls_fclib_title(const dls_fclib *file) {
  (void)file;
  return "";
}

dls_status dls_fclib_contact(const dls_fclib *file, dls_contact *problem, dls_error *error) {
  (void)file;
  (void)problem;
  return dlsi_at(__func__, unsupported(error), error);
}

dls_status dls_fclib_model(const dls_fclib *file, dls_model *model, const double **f,
                           const double **g, const double **mu, dls_error *error) {
  (void)file;
  (void)model;
  (void)f;
  (void)g;
  (void)mu;
  return dlsi_at(__func__, unsupported(error), error);
}

dls_status dls_fclib_solution(const dls_fclib *file, const double **r, const double **u,
                              dls_error *error) {
  (void)file;
  (void)r;
  (void)u;
  return dlsi_at(__func__, unsupported(error), error);
}

void dls_fclib_destroy(dls_fclib *file) {
  (void)file;
}

dls_status dls_fclib_write_local(const char *path, const dls_contact *problem, const char *title,
                                 const double *r, const double *u, dls_error *error) {
  (void)path;
  (void)problem;
  (void)title;
  (void)r;
  (void)u;
  return dlsi_at(__func__, unsupported(error), error);
}

dls_status dls_fclib_write_global(const char *path, const dls_model *model, const double *f,
                                  const double *g, const double *mu, const char *title,
                                  const double *x, const double *r, const double *u,
                                  dls_error *error) {
  (void)path;
  (void)model;
  (void)f;
  (void)g;
  (void)mu;
  (void)title;
  (void)x;
  (void)r;
  (void)u;
  return dlsi_at(__func__, unsupported(error), error);
}
