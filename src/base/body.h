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
  const dls_model *model; /* n and K: DLS_STIFFNESS_DENSE or _SPARSE, as dls_model_check takes it */
  dls_sparse Ht;          /* H^T: m x n */
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

/* Computes the weights: the compliance of the contact with its neighbours held. J: the unknowns
 * that H_c touches; C = H_c^T K[J,J]^-1 H_c; w_n = C_nn, w_t = trace(C_tt) / (d-1). If J has more
 * than 24 unknowns, or C is not positive, the diagonal of K stands for K[J,J]; then the mean of the
 * positive weights of its kind; then 1. w_t = w_n where there are no tangents. H: n x m. w: 2 nc.
 * DLS_E_MEMORY. */
dls_status dlsi_body_weights(const dls_model *model, const dls_sparse *H, int d, double *w,
                             dls_error *error);

/* Computes F' = r' - P_mu'(r' - u' - mu' |u'_t| n) of one contact in its round variables
 * r' = D^1/2 r, u' = D^-1/2 u, mu' = mu (w_t/w_n)^1/2, D = diag(w_n, w_t, ..); returns the branch
 * of the projection. With an infinite friction F' = u' where w_n r_n > u_n, else r'. */
static inline dls_contact_state dlsi_body_residual(int d, double mu, double wn, double wt,
                                                   const double *r, const double *u, double *F) {
  double r1[3] = {0}, v[3] = {0}, p[3] = {0};
  const double sn = sqrt(wn), st = sqrt(wt);
  if (dlsi_is_bonded(mu)) {
    const int pressed = wn * r[0] > u[0];
    for (int i = 0; i < d; i++)
      F[i] = pressed ? u[i] / (i ? st : sn) : r[i] * (i ? st : sn);
    return pressed ? DLS_STICK : DLS_FREE;
  }
  for (int i = 0; i < d; i++) {
    const double s = i ? st : sn;
    r1[i] = s * r[i];
    v[i] = r1[i] - u[i] / s;
  }
  v[0] -= mu * dlsi_tangent_norm(d, u) / sn;
  const dls_contact_state state = dlsi_project_cone(d, mu * (st / sn), v, p);
  for (int i = 0; i < d; i++)
    F[i] = r1[i] - p[i];
  return state;
}

/* Returns 1 if r_c = 0 and F'_c = 0: an open contact enters no scale, no norm, no floor. */
static inline int dlsi_body_is_open(int d, const double *r, const double *u) {
  for (int i = 0; i < d; i++)
    if (r[i] != 0) return 0;
  return u[0] >= 0;
}

/* Returns the doubles of `work` for dlsi_body_measure. */
size_t dlsi_body_scratch(const dlsi_body *body);

/* Measures the pair (x, r). f: n or NULL for 0; g: m or NULL for 0; mu: nc; r, u: m, u receives
 * H^T x + g; x: n; work: dlsi_body_scratch. One product with K. */
void dlsi_body_measure(const dlsi_body *body, const double *f, const double *g, const double *mu,
                       const double *r, const double *x, double *u, double *work,
                       dls_certificate *certificate);

/* Returns 1 if each part is at most max(tol, 4 floor) and 4 floor at most max(tol, cap), for each
 * of the three; NaN gives 0. */
int dlsi_body_holds(const dls_certificate *certificate, double tol, double cap);

/* Returns the measure by which the better one of two pairs is found: the largest of the parts and
 * of 4 times their floors; NaN stays NaN. */
double dlsi_body_badness(const dls_certificate *certificate);

#endif
