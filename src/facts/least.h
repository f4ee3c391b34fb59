/* least.h: the least reactions of an answer's positions. */
#ifndef DLSI_LEAST_H
#define DLSI_LEAST_H

#include "contact/contact.h"

/* A workspace for problems of dimension d with at most nc contacts. */
typedef struct dlsi_least dlsi_least;

/* *out := new workspace, W dense (blocks = 0) or with at most so many blocks. Memory: m^2 doubles,
 * or O(blocks) if W is sparse (vi/newton/states_matrix.h), and O(m). DLS_E_MEMORY, DLS_E_SIZE. */
dls_status dlsi_least_create(dlsi_least **out, int d, int nc, int blocks, dls_error *error);

/* Replaces r (m), an answer of `status`, DLS_OK or DLS_TO_ROUNDING, by the reactions of its
 * positions with the least sum of w_c |r_c|^2; also u (m, or NULL) and the certificate; *done := 1.
 * Changes nothing, *done = 0, if W is not symmetric to 1e-10, a friction is infinite, the time of a
 * solve that began at `begun` is over, or no such r is certified. W dense or by blocks.
 * DLS_E_MEMORY. */
dls_status dlsi_least_take(dlsi_least *work, const dls_contact *problem, const dls_limits *limits,
                           double begun, dls_status status, double *r, double *u,
                           dls_certificate *certificate, int *done, dls_error *error);

/* NULL is fine. */
void dlsi_least_destroy(dlsi_least *work);

#endif
