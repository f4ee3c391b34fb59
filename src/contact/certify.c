/* certify.c: dls_contact_certify, in any unit: on a copy in plain units where it needs one. */
#include <stdlib.h>
#include <string.h>

#include "contact.h"

static dls_status contact_certify(const dls_contact *problem, const double *r, double *u,
                                  dls_certificate *certificate, dls_error *error) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  double *work = dlsi_alloc(3 * m + 2 * (size_t)problem->nc, sizeof *work);
  if (!work) return dlsi_no_memory(error);
  double *v = work, *a = work + m, *F = work + 2 * m, *w = work + 3 * m;
  dlsi_contact_multiply(problem, NULL, r, v, a);
  dlsi_certificate_weights(problem, w);
  dlsi_contact_measure(problem, r, v, a, w, F, certificate);
  if (u) memcpy(u, v, m * sizeof *u);
  free(work);
  return DLS_OK;
}

dls_status dls_contact_certify(const dls_contact *problem, const double *r, double *u,
                               dls_certificate *certificate, dls_error *error) {
  DLSI_DOOR;
  dlsi_formed formed = {.work = NULL};
  dlsi_units units = {.W = 0};
  dls_status status = dlsi_check_contact(problem, error);
  const size_t m = status ? 0 : (size_t)problem->d * (size_t)problem->nc;
  if (!status) status = dlsi_check_vector("r", r, m, error);
  if (!status && !certificate) status = dlsi_is_null(error, "certificate");
  if (!status) status = dlsi_check_apart(problem, r, u, error);
  if (!status) status = dlsi_take_answer(&units, &problem, &r, error);
  if (!status) status = dlsi_lend(&formed, &problem, error);
  if (!status) status = contact_certify(problem, r, u, certificate, error);
  if (!status && u) dlsi_shift(units.q ? m : 0, units.q, u, u);
  if (!status) dlsi_certificate_from_units(&units, certificate);
  dlsi_formed_free(&formed);
  dlsi_units_free(&units);
  return dlsi_at(__func__, status, error);
}
