/* fclib_none.c: returns DLS_E_UNSUPPORTED in a build without HDF5. */
#include "delassus/files.h"
#include "files/file.h"

#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

#define UNSUPPORTED(error)                                                                         \
  dlsi_at(__func__, dlsi_fail(error, DLS_E_UNSUPPORTED, "", -1, 0, "built without HDF5"), error)

dls_status dls_fclib_read(dls_fclib **out, const char *path, dls_error *error) {
  if (out) *out = NULL;
  FILE *file = path ? dlsi_file_open(path, error) : NULL; /* no such file: that is told first */
  if (path && !file) return dlsi_at(__func__, DLS_E_FILE, error);
  if (file) (void)fclose(file);
  return UNSUPPORTED(error);
}

int dls_fclib_is_global(const dls_fclib *file) {
  return 0;
}

const char *dls_fclib_title(const dls_fclib *file) {
  return "";
}

dls_status dls_fclib_contact(const dls_fclib *file, dls_contact *problem, dls_error *error) {
  return UNSUPPORTED(error);
}

dls_status dls_fclib_model(const dls_fclib *file, dls_model *model, const double **f,
                           const double **g, const double **mu, dls_error *error) {
  return UNSUPPORTED(error);
}

dls_status dls_fclib_bodies(const dls_fclib *file, dls_contact *problem, dls_error *error) {
  return UNSUPPORTED(error);
}

dls_status dls_fclib_solution(const dls_fclib *file, const double **r, const double **u,
                              dls_error *error) {
  return UNSUPPORTED(error);
}

void dls_fclib_destroy(dls_fclib *file) {}

dls_status dls_fclib_write_local(const char *path, const dls_contact *problem, const char *title,
                                 const double *r, const double *u, dls_error *error) {
  return UNSUPPORTED(error);
}

dls_status dls_fclib_write_global(const char *path, const dls_model *model, const double *f,
                                  const double *g, const double *mu, const char *title,
                                  const double *x, const double *r, const double *u,
                                  dls_error *error) {
  return UNSUPPORTED(error);
}
