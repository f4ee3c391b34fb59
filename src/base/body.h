/*
 * body.h: the certificate of a pair (x, r) on the body itself:
 *
 *   K x = f + H r,   u = H^T x + g,   the law of contact and friction between u and r
 *
 * delassus/contact.h has the fields. Names: n unknowns, m = d nc.
 */
#ifndef DLSI_BODY_H
#define DLSI_BODY_H

#include "base/base.h"

/* The body. A view; everything is borrowed. */
typedef struct dlsi_body {
  int n;
  const dls_model
      *model; /* K: DLS_STIFFNESS_DENSE or _SPARSE, as dls_model_check takes it; NULL: see multiply
               */
  void (*multiply)(void *data, const double *x, double *y, double *a); /* dlsi_body_multiply of a K
                             that is elsewhere, in the place of model. Where both are NULL, K is not
                             known, and equilibrium is not measured */
  void *data;
  dls_sparse Ht; /* H^T: m x n */
  int d, nc;
  const double *w; /* 2 nc: w_n and w_t of each contact, dlsi_body_weights */
  const int *part; /* n: the connected body of each unknown, dlsi_body_parts */
  int parts;
} dlsi_body;

/* Computes y := K x and, if a is not NULL, a := |K||x|. x, y, a: n, apart. */
void dlsi_body_multiply(const dls_model *model, const double *x, double *y, double *a);

/* Finds the connected bodies: the components of the graph of the entries of K that are not 0,
 * numbered by their first unknown. part: receives the number of each unknown, n. Returns how many
 * there are. */
int dlsi_body_parts(const dls_model *model, int *part);

/* dlsi_body_parts step by step. From part[i] = i: join puts i and j, of one body, together; number
 * turns `part` into numbers and returns how many there are. */
void dlsi_body_join(int *part, int i, int j);
int dlsi_body_number(int n, int *part);

/* Computes the weights: the compliance of the contact with its neighbours held. J: the unknowns
 * that H_c touches; C = H_c^T K[J,J]^-1 H_c; w_n = C_nn, w_t = trace(C_tt) / (d-1). If J has more
 * than 24 unknowns, or C is not positive, the diagonal of K stands for K[J,J]; then the mean of the
 * positive weights of its kind; then 1. w_t = w_n where there are no tangents. H: n x m. w: 2 nc.
 * DLS_E_MEMORY. */
dls_status dlsi_body_weights(const dls_model *model, const dls_sparse *H, int d, double *w,
                             dls_error *error);

/* Returns the doubles of `work` for dlsi_body_measure. */
size_t dlsi_body_scratch(const dlsi_body *body);

/* Measures the pair (x, r). f: n or NULL for 0; g: m or NULL for 0; mu: nc; r, u: m, u receives
 * H^T x + g; x: n; work: dlsi_body_scratch. One product with K. */
void dlsi_body_measure(const dlsi_body *body, const double *f, const double *g, const double *mu,
                       const double *r, const double *x, double *u, double *work,
                       dls_certificate *certificate);

/* Returns the measure by which the better one of two pairs is found: the largest of the parts and
 * of 4 times their floors; NaN stays NaN. */
double dlsi_body_badness(const dls_certificate *certificate);

#endif
