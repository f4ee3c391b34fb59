/* operator.h: builds H = L P of a model without what the scene does not need. */
#ifndef DLSI_OPERATOR_H
#define DLSI_OPERATOR_H

#include "contact/columns.h"
#include "contact/contact.h"

/* H = L P. */
typedef struct dlsi_operator {
  int d;           /* rows of H^T per candidate: 1 where H = H_N */
  int candidates;  /* active ones */
  dlsi_columns P;  /* nodes x candidates; the unit matrix if the model has no P */
  double *mu;      /* candidates; NULL if the model has none */
  dlsi_columns Ht; /* H^T, m x n; entries of one place are not added up */
  int *keep, kept; /* n: the unknowns that H touches, ascending, and their number */
  int columns;     /* of H that are not empty */
} dlsi_operator;

/* Builds the operator of a checked model, H_N alone if frictionless is 1. The caller calls
 * dlsi_operator_free, also after an error.
 * DLS_E_MEMORY, DLS_E_SIZE (more than INT_MAX entries), DLS_E_ARGUMENT (mu > 0, frictionless). */
dls_status dlsi_operator_create(dlsi_operator *H, const dls_model *model, int frictionless,
                                dls_error *error);
void dlsi_operator_free(dlsi_operator *H);

/* *out := a part of H by columns, n x m, with d >= H->d columns a contact; columns that H does not
 * have are empty. DLS_E_MEMORY; free *out then, too. */
dls_status dlsi_operator_columns(const dlsi_operator *H, int d, dlsi_part which, dlsi_columns *out,
                                 dls_error *error);

/* Returns 0 if the tangents of contact c are left out. */
static inline int dlsi_has_tangents(const dlsi_operator *H, int c) {
  return !H->mu || H->mu[c] > 0;
}

/* Adds H^T x to y for an x that is 0 except at s unknowns. unknown: these, s; x: its values there,
 * s; y: m. */
void dlsi_operator_add(const dlsi_operator *H, const int *unknown, size_t s, const double *x,
                       double *y);

#endif
