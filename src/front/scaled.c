/*
 * scaled.c: a solve in units of its own (base/units.c), between the caller's problem and the
 * method. The caller sees r, u, the certificate and the r of each progress in the units of the
 * problem. An answer that those cannot hold, because it leaves the range of numbers or loses bits
 * there, is measured again as it is returned.
 */
#include <string.h>

#include "front/front.h"

/* Shows the host r in its own units. */
static int scaled_tell(void *data, const dls_progress *progress) {
  const dlsi_scaled *s = data;
  const dlsi_units *units = s->units;
  dls_progress shown = *progress;
  if (progress->r) {
    dlsi_shift(s->m, units->q - units->W, progress->r, units->shown);
    shown.r = units->shown;
  }
  return s->host.progress(s->host.progress_data, &shown);
}

dls_status dlsi_scaled_begin(dlsi_scaled *s, dlsi_units *units, const dls_contact **problem,
                             double **r, double **u, dls_info **info, dls_limits *limits,
                             dls_error *error) {
  *s = (dlsi_scaled){.given = *problem, .r = *r, .u = *u, .info = *info, .host = *limits};
  const dls_status status = dlsi_take_units(units, problem, error);
  if (status || *problem == s->given) return status;
  s->units = units;
  s->m = (size_t)s->given->d * (size_t)s->given->nc;
  if (limits->warm_start) dlsi_shift(s->m, units->W - units->q, *r, units->r);
  if (limits->warm_start && dlsi_first_not_finite(units->r, s->m) >= 0)
    memset(units->r, 0, s->m * sizeof *units->r);
  if (limits->progress) {
    limits->progress = scaled_tell;
    limits->progress_data = s;
  }
  *r = units->r;
  *u = units->u;
  *info = &s->own;
  return DLS_OK;
}

/* Measures the answer that the caller's units have rounded. Returns the status of the solve. */
static dls_status scaled_measure(dlsi_scaled *s, dls_error *error) {
  if (dlsi_first_not_finite(s->r, s->m) >= 0) memset(s->r, 0, s->m * sizeof *s->r);
  dls_status status = dls_contact_certify(s->given, s->r, s->u, &s->own.certificate, error);
  if (!status) status = dlsi_settled(&s->own.certificate, s->host.tol, DLS_STALLED);
  s->own.error = 0;
  s->own.unique = DLS_UNIQUE_UNKNOWN;
  s->own.status = status;
  return status;
}

dls_status dlsi_scaled_end(dlsi_scaled *s, dls_status status, dls_error *error) {
  const dlsi_units *units = s->units;
  if (!units || status < 0) return status;
  const int exact = dlsi_shift_exactly(s->m, units->q - units->W, units->r, s->r);
  if (s->u) dlsi_shift(s->m, units->q, units->u, s->u);
  dlsi_certificate_from_units(units, &s->own.certificate);
  if (!exact) status = scaled_measure(s, error);
  if (s->info && status >= 0) *s->info = s->own;
  return status;
}
