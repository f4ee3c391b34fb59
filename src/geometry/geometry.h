/* geometry.h: declares what the files of src/geometry share. Points have three entries; those in
 * the plane z = 0. A face has its corners from 0. */
#ifndef DLSI_GEOMETRY_H
#define DLSI_GEOMETRY_H

#include "contact/contact.h"
#include "delassus/pairs.h"

static inline double dlsi_dot3(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* c := a x b; c may not overlap them. */
static inline void dlsi_cross3(const double a[3], const double b[3], double c[3]) {
  for (int k = 0; k < 3; k++)
    c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* Beyond the border of a face by so much of its size, a node still stands over it. */
static const double dlsi_beside = 1e-6;

/* Faces of one kind, d = 2: edges. */
typedef struct dlsi_faces {
  int d, count, corners, base;
  const double *X;
  const int *face;
} dlsi_faces;

/* Copies the corners of a face. */
void dlsi_face_corners(const dlsi_faces *faces, int face, double C[4][3]);

/* Returns the largest distance of two corners. */
double dlsi_face_size(int corners, double C[4][3]);

/* n := the unit normal in the middle; returns 0 if the face has no area. */
int dlsi_face_normal(int d, int corners, double C[4][3], double n[3]);

/* Finds the point c of the face nearest to P: w (corners): its shape functions; n: the unit normal
 * there, or NULL. */
void dlsi_face_nearest(int d, int corners, double C[4][3], const double P[3], double w[4],
                       double c[3], double n[3]);

/* A tree of boxes over faces. */
typedef struct dlsi_tree {
  dlsi_faces faces;
  int *order;          /* count: faces along a curve that fills space */
  double (*box)[2][3]; /* 2 count - 1: least and largest coordinates, a node before its halves */
} dlsi_tree;

/* Builds the tree of at least one face. The caller calls dlsi_tree_free, also after an error:
 * DLS_E_MEMORY. */
dls_status dlsi_tree_create(dlsi_tree *tree, const dlsi_faces *faces, dls_error *error);
void dlsi_tree_free(dlsi_tree *tree);

/* Calls visit(data, face) for each face whose box is within *reach of the box (low, high). visit
 * may reduce *reach. */
void dlsi_tree_search(const dlsi_tree *tree, const double low[3], const double high[3],
                      const double *reach, void visit(void *data, int face), void *data);

/* A place of contact between your body and the other one. */
typedef struct dlsi_place {
  int own[4], owns;  /* nodes of your body, from 0, and their number */
  int face;          /* of the other body; -1: the wall */
  double a[4], w[4]; /* shape functions of own, and of the corners of the face */
  double n[3], gap;  /* from the other body into yours; along n */
  double weight;     /* of quadrature */
} dlsi_place;

/* A list of places that grows. */
typedef struct dlsi_places {
  dlsi_place *at;
  size_t count, room;
} dlsi_places;

/* Returns a new place at the end, of which face is -1 and all else 0; NULL without memory. */
dlsi_place *dlsi_place_add(dlsi_places *places);

/* Finds the place over which P stands. *place is complete but for own. */
dls_pair_state dlsi_nearest(const dlsi_tree *tree, double reach, const double P[3],
                            dlsi_place *place);

/* Adds the points of quadrature on the intersections of one own face with the faces of the tree.
 * DLS_E_MEMORY. */
dls_status dlsi_overlap(const dlsi_tree *tree, const dlsi_faces *own, int face, double reach,
                        dlsi_places *places, dls_error *error);

#endif
