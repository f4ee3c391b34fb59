/*
 * solids.h: elastic solids of bilinear quadrilaterals (plane strain) and trilinear cubes, and
 * contacts between their nodes, as a model with sparse K.
 */
#ifndef SOLIDS_H
#define SOLIDS_H

#include "contact/columns.h"
#include "delassus/model.h"

typedef struct solids {
  int d, nodes, contacts;
  dlsi_triplets K, N, T; /* lower triangle of K */
  double *f, *g;         /* d nodes; d contacts */
  dlsi_columns Kc, Nc, Tc;
  dls_model model;
} solids;

/* Makes room for so many nodes and contacts. */
void solids_new(solids *S, int d, int nodes, int contacts);
void solids_free(solids *S);

/* count is nx, ny, nz; nz is not read for d = 2.
 *
 * Adds a block of nx x ny squares of side 1 (d = 2), or nx x ny x nz cubes (d = 3), E = 1 times
 * `stiff`, nu = .3; returns its first node. Node (i, j, k) is first + i + (nx+1) (j + (ny+1) k). */
int solids_block(solids *S, const int count[3], double stiff);

/* Adds a block whose node (i, j) stands at x[2 (i + (nx+1) j)], .. (d = 2). */
int solids_mapped(solids *S, const int count[3], const double *x, double stiff);

/* Integrates the stiffness A (square, d 2^d) of a bilinear or trilinear element by Gauss's
 * 2^d points. x: 2^d corners, d each; bit l of a corner's number is its side in direction l. Adds
 * that of an element with these nodes, nu = .3, times `stiff`. */
void solids_stiffness(int d, const double *x, double E, double nu, double *A);
void solids_element(solids *S, const int *node, const double *x, double stiff);

/* Adds a spring to direction `k` of a node. */
void solids_spring(solids *S, int node, int k, double stiffness);

/* Adds a contact of `node` with `other` (-1: the ground). normal: d, out of the other body; the
 * tangents follow. gap: along the normal. */
void solids_contact(solids *S, int node, int other, const double *normal, double gap);

/* Adds a contact of `node` with a place between `count` others, their shares in part. */
void solids_contact_on(solids *S, int node, int count, const int *other, const double *part,
                       const double *normal, double gap);

/* Compresses and returns the model; again after more was added. */
const dls_model *solids_model(solids *S);

/* surfaces.c: soft strip and plate, and a strip that hangs like a cantilever, lifted, seed 0. */
void solids_pad(solids *S, int nx, int ny);
void solids_plate(solids *S, int nx, int nz);
void solids_strip(solids *S, int nx, int ny);

/* A stack of `count` free blocks of side^d elements on the ground, each with a weight, pushed by
 * `push` times the friction that .3 of all weight above gives. */
void solids_stack(solids *S, int d, int count, int side, double push);

/* A half circle of `stones` deformable voussoirs between two rough ground planes, under its own
 * weight; thickness over mean radius: `thick`. */
void solids_arch(solids *S, int stones, double thick);

/* y := (K + H R H^T) x of solids_model's model, K by its lower triangle; R: diagonal, d nodes. */
void solids_apply(const dls_model *model, const double *R, const double *x, double *y);

#endif
