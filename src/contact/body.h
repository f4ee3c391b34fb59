/*
 * body.h: the certificate of a pair (x, r) on the body itself:
 *
 *   K x = f + H r,   u = H^T x + g,   the law of contact and friction between u and r
 *
 * delassus/contact.h has the fields. Names: n unknowns, m = d nc.
 */
#ifndef DLSI_BODY_H
#define DLSI_BODY_H

#include "contact.h"

/* The body. A view; everything is borrowed. */
typedef struct dlsi_body {
  int n;
  const dls_model
      *model; /* K: DLS_STIFFNESS_DENSE or _SPARSE, as dls_model_check takes it; NULL: see multiply
               */
  void (*multiply)(void *data, const double *x, double *y, double *a); /* dlsi_body_multiply for a K
                             that is elsewhere, instead of model. If both are NULL, K is not known,
                             and equilibrium is not measured */
  void *data;
  const dlsi_ranks *ranks; /* n, m: of this rank, as f, x, g, mu, r, u; NULL: one process */
  dls_sparse Ht;           /* H^T: m x n, reach x n with ranks */
  int d, nc;
  const double *w;     /* 2 nc: w_n and w_t of each contact, dlsi_body_weights */
  const double *share; /* n: dlsi_body_shares; NULL: 1 */
  const int *part;     /* n: the connected body of each unknown, dlsi_body_parts */
  const int *joint;    /* n: dlsi_body_joints; NULL: no unknown is a multiplier */
  const int *piece;    /* n, where there are joints: dlsi_body_pieces */
  int parts, pieces;
  const double *balanced; /* parts: the load (dlsi_own_balanced) of a body whose loads balance in
                             themselves and have been split off, the scale of its rounding while no
                             contact presses it; NULL: 0 */
  const double *blur;     /* m: size of the positions split off, whose rounding g has; NULL: 0 */
} dlsi_body;

/* Returns r with the rows of others that H touches, in the scratch of the ranks: for v + H r. */
const double *dlsi_body_fetch(const dlsi_body *body, const double *r);

/* Returns where H^T x is to be added up, before which it is u; then give joins it in u. */
double *dlsi_body_reach(const dlsi_body *body, double *u);
void dlsi_body_give(const dlsi_body *body, dlsi_how how, double *all, double *u);

/* Finds entry *at = 0, 1, .. of column j that counts: all, or those of the lower triangle of a
 * symmetric K. Sets *at to the next entry; returns 0 past the last. */
int dlsi_body_entry(const dls_model *model, int j, int *at, int *row, double *value);

/* Returns K_jj. */
double dlsi_body_diagonal(const dls_model *model, int j);

/* Computes y := K x and, if a is not NULL, a := |K||x|. x, y, a: n, apart. */
void dlsi_body_multiply(const dls_model *model, const double *x, double *y, double *a);

/* Finds the connected bodies: the components of the graph of the entries of K that are not 0,
 * numbered by their first unknown. part: receives the number of each unknown, n. Returns how many
 * there are. */
int dlsi_body_parts(const dls_model *model, int *part);

/* dlsi_body_parts step by step. From part[i] = i: join connects i and j of one body; number turns
 * `part` into numbers and returns how many there are. */
void dlsi_body_join(int *part, int i, int j);
int dlsi_body_number(int n, int *part);

/* Finds the multipliers among the unknowns (joints.c): joint[i] := 1 if row i of K x = f + H r is a
 * joint, a length (velocity), 0 if it is an equilibrium. Ht: m x n; NULL: not known. joint: n.
 * Returns how many there are. */
int dlsi_body_joints(const dls_model *model, const dls_sparse *Ht, int *joint);

/* Finds the connected bodies without their joints. piece: receives the number of each unknown, -1
 * for a multiplier, n. Returns how many there are. */
int dlsi_body_pieces(const dls_model *model, const int *joint, int *piece);

/* Computes the weights: the compliance of the contact with its neighbours held. J: the unknowns
 * that H_c touches; C = H_c^T K[J,J]^-1 H_c; w_n = C_nn, w_t = trace(C_tt) / (d-1). If J has more
 * than 24 unknowns, or C is not positive, the diagonal of K replaces K[J,J]; then the mean of the
 * positive weights of its kind; then 1. w_t = w_n if there are no tangents. H: n x m. w: 2 nc.
 * DLS_E_MEMORY. */
dls_status dlsi_body_weights(const dls_model *model, const dls_sparse *H, int d, double *w,
                             dls_error *error);

/* Computes the share of a row's rounding that goes on to other rows, n: the sum of its |K_ij|, j !=
 * i, over K_ii, at most 1. A penalty keeps its own. */
void dlsi_body_shares(const dls_model *model, double *share);

/* ---- equilibrium.c --------------------------------------------------------------------------- */

/* Arrays of the measure of equilibrium, n unless said otherwise. */
typedef struct dlsi_forces {
  double *e, *ae; /* K x - f - H r and the size of its terms */
  double *Hr;     /* |H||r| */
  double *pull;   /* joints: minus the forces of joints on positions */
  double *reach;  /* joints: K_jj, then the lengths at positions and in joints */
  double *sums;   /* 10 for each piece and each part: largest numbers, then sums of squares */
  double *most;   /* 1: the most that |H||r| of a body measures */
} dlsi_forces;

/* Returns the doubles of the arrays; places them in work. */
size_t dlsi_forces_scratch(const dlsi_body *body);
dlsi_forces dlsi_forces_in(const dlsi_body *body, double *work);

/* Sets Hr := |H||r|, e := K x - f - H r, ae := |K||x| + |f| + |H||r|, most. */
void dlsi_forces_sum(const dlsi_body *body, const double *f, const double *r, const double *x,
                     const dlsi_forces *of);

/* Sets equilibrium, floor_e, unbalanced and body of *found, after dlsi_forces_sum. */
void dlsi_forces_measure(const dlsi_body *body, const double *f, const double *x,
                         const dlsi_forces *of, dls_certificate *found);

/* Returns 1 if the loads of some body are more than 100 times its contact forces; after
 * dlsi_body_measure with this `work`. */
int dlsi_forces_dwarf(const dlsi_body *body, double *work);

/* Replaces equilibrium and floor_e of *found by (EB2) with all of |f| in the scale, after
 * dlsi_body_measure with this `work`. Does nothing with joints. */
void dlsi_forces_loose(const dlsi_body *body, double *work, dls_certificate *found);

/* ---- the measure ----------------------------------------------------------------------------- */

/* Returns the doubles of `work` for dlsi_body_measure. */
size_t dlsi_body_scratch(const dlsi_body *body);

/* Measures the pair (x, r). f: n or NULL for 0; g: m or NULL for 0; mu: nc; r, u: m, u receives
 * H^T x + g; x: n; work: dlsi_body_scratch. One product with K. */
void dlsi_body_measure(const dlsi_body *body, const double *f, const double *g, const double *mu,
                       const double *r, const double *x, double *u, double *work,
                       dls_certificate *certificate);

/* Returns the measure by which pairs are compared, smaller is better: the largest of the parts and
 * of 4 times their floors; NaN stays NaN. */
double dlsi_body_badness(const dls_certificate *certificate);

#endif
