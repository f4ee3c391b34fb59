/*
 * linkage.h: rigid bodies and joints between them, as a model with masses and a multiplier for each
 * row of a joint in K. x are velocities after an impulse; if nothing moves, r and the multipliers
 * are those of statics.
 */
#ifndef LINKAGE_H
#define LINKAGE_H

#include "contact/columns.h"
#include "delassus/model.h"

enum { linkage_most = 400 }; /* unknowns */

typedef struct linkage {
  int d, each; /* 2 or 3; unknowns of a body: (v, turn), 3 or 6 */
  int bodies, n, contacts;
  dlsi_triplets K, N, T; /* lower triangle of K */
  double f[linkage_most];
  dlsi_columns Kc, Nc, Tc;
  double *dense;
  dls_model model;
} linkage;

void linkage_new(linkage *L, int d);

/* Frees all and sets *L to zero, of which free takes any number. */
void linkage_free(linkage *L);

/* Adds a body at rest with `weight`, along -y in the plane and -z in space; returns its number. All
 * bodies come before all joints. */
int linkage_body(linkage *L, double mass, double inertia, double weight);

/* Adds the joint e . (velocity of a at the offset A - velocity of b at B) = value; body -1: the
 * ground. A, B, e: d. Returns its unknown. */
int linkage_tie(linkage *L, int a, const double *A, int b, const double *B, const double *e,
                double value);

/* Adds e . (turn of a - turn of b) = 0; e: 3 in space, not read in the plane. */
int linkage_turn(linkage *L, int a, int b, const double *e);

/* Adds the d ties of a pin at A of a and B of b. */
void linkage_pin(linkage *L, int a, const double *A, int b, const double *B);

/* Adds a contact of body a at the offset A with the ground, the normal up. */
void linkage_contact(linkage *L, int a, const double *A);

/* Makes the model; factorization DLS_LU: with both triangles. */
const dls_model *linkage_model(linkage *L, dls_factorization factorization, int is_sparse);

/* Returns the largest |G^T x - b| over the largest displacement that there is: |x_j| or
 * |f_j| / K_jj of a position, or that of a multiplier on the largest K_jj: multipliers are large
 * where a linkage is jammed, and which answer is found then depends on the BLAS. */
double linkage_apart(const linkage *L, const double *x);

#endif
