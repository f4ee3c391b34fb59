/*
 * delassus/pairs.h: H_N, H_T and gaps from the meshes of two bodies: nodes of one against faces of
 * the other, or both surfaces by mortar. No collision detection: you give both surfaces, and call
 * again when they have moved.
 *
 *   dls_pairs pairs;
 *   status = dls_pairs_find(&surfaces, &pairs, &error);
 *   model.nodes = pairs.nodes;   model.HN = pairs.HN;   model.HT = pairs.HT;   model.P = pairs.P;
 *   ... solve with g = pairs.g ...
 *   dls_pairs_free(&pairs);
 *
 * A node X, its nearest point C = sum_k w_k X_k on a face of corners X_k and shape functions w:
 *
 *   u_j = e_j . (x - sum_k w_k x_k) + g_j,   g = (n . (X - C), 0[, 0]),   e = (n, t[, s])
 *
 * n points out of the face, from the other body into yours; in 2D t is n turned by -90 degrees; in
 * 3D t is the part across n of the axis that n leans to least, the first of equals, and s = n x t.
 *
 *   the node stands over                n, C
 *   a face                              the face's
 *   a convex edge or corner             n from the nearest point C to the node
 *   and on it, within 1e-6 of a face    n the mean of the faces that meet there
 *   two faces of a concave edge         the nearer face; of equals the first. For contact with both
 *                                       call twice, with the faces of each side
 *   nothing, beyond the border          none: DLS_PAIR_BESIDE
 *
 * 1e-6 of a face beyond its border still counts as over it. A hanging node is no unknown: leave it
 * out of `node`. It may be a corner of a face: H becomes T^T H with the T of x = T x' that
 * eliminates it, as K becomes T^T K T.
 *
 * Mortar. With `own`, the faces of your body, the contact nodes are points of quadrature, and the
 * candidates are nodes i of these faces. P averages over the hat functions phi_i of the nodes:
 *
 *   P_qi = w_q phi_i(q) / A_i,   A_i = sum_q w_q phi_i(q),   r_i / A_i the pressure at i
 *
 * The points are exact on the intersections of flat faces (edges, triangles, parallelograms), so
 * that a constant pressure passes between meshes that do not match without an error (the patch
 * test); nodes against faces leave an error of per cents near the surface. n is minus the normal of
 * the own face. Corners of a face should form a convex polygon.
 */
#ifndef DELASSUS_PAIRS_H
#define DELASSUS_PAIRS_H

#include "delassus/matrix.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The surfaces: a view, all borrowed. Both bodies are in one numbering of the mesh. */
typedef struct dls_surfaces {
  int d;           /* 2 or 3 */
  int n;           /* unknowns of the host: rows of H */
  int points;      /* nodes of the mesh */
  int base;        /* the number of its first node: 0 or 1 */
  const double *X; /* d points: where they are now, node after node                      length */
  const int *dof;  /* d points: the unknown, from 0, of each direction of each node; -1: held. NULL:
                       unknown d k + i is direction i of the k-th node */
  int nodes;       /* of your body that may touch; not read with own */
  const int *node; /* nodes: their numbers, each once */
  int faces;       /* of the other body */
  int corners;     /* of a face: 2 if d = 2 (edges); 3 or 4 if d = 3 (T3, Q4) */
  const int *face; /* corners faces: numbers of the corners; the face looks out of its body.
                       d = 2: the body is to the left of a -> b; d = 3: they go counterclockwise
                       as seen from outside */
  const double
      *wall;       /* 2 d: a point and the normal of a fixed plane in place of the faces; or NULL */
  int own_faces;   /* mortar: faces of your body */
  int own_corners; /* as corners */
  const int *own;  /* own_corners own_faces, as face; NULL: no mortar */
  double reach;    /* a pair with |gap| > reach is none; 0: the largest extent of a face, and no
                         limit for a wall; INFINITY: no limit                              length */
} dls_surfaces;

/* What became of a node. */
typedef enum dls_pair_state {
  DLS_PAIR_FOUND = 0,
  DLS_PAIR_FAR = 1,    /* no face within reach */
  DLS_PAIR_BESIDE = 2, /* faces are within reach, but the node is beyond their border */
  DLS_PAIR_SHARED = 3, /* the node is a corner of one of the faces */
  DLS_PAIR_HELD = 4    /* nothing moves along n: node and face are held */
} dls_pair_state;

/* What was found. Read-only; dls_pairs_free frees it. */
typedef struct dls_pairs {
  int nodes;      /* contact nodes: columns of HN; a pair each, or a point of quadrature */
  int candidates; /* contacts: nodes, or the columns of P */
  dls_sparse HN, HT,
      P;               /* n x nodes, n x (d-1) nodes; mortar: nodes x candidates, else P.p = NULL */
  const double *g;     /* d nodes: gap, 0[, 0] */
  const double *frame; /* d d nodes: rows n, t[, s] */
  const int *face;     /* nodes: the face, from 0; -1: the wall */
  const int *node;     /* candidates: the number of the node; ascending with mortar */
  const double *measure; /* candidates: A_i of mortar; else NULL            length or its square */
  const dls_pair_state *state; /* surfaces.nodes: of each node; NULL with mortar */
} dls_pairs;

/* Finds the pairs, in the order of `node`. About 1 s for 10^5 nodes against 10^5 faces; memory
 * O(nodes + faces). *out is zero after an error.
 *
 *   DLS_E_ARGUMENT     out, X, node, face NULL; d, base, corners, own_corners; a number of a node
 *                      that is none; an unknown that is none; a node twice; a face without area; a
 *                      wall and faces; a wall and own; a wall without normal; reach < 0. Names the
 *                      field and the index
 *   DLS_E_NOT_FINITE   X, wall, reach NaN
 *   DLS_E_SIZE         negative sizes; more than INT_MAX entries
 *   DLS_E_MEMORY */
DLS_API DLS_MUST_USE dls_status dls_pairs_find(const dls_surfaces *surfaces, dls_pairs *out,
                                               dls_error *error);

/* Frees what dls_pairs_find has filled, and sets it to zero; NULL and zero are fine. */
DLS_API void dls_pairs_free(dls_pairs *pairs);

#ifdef __cplusplus
}
#endif

#endif
