/*
 * overlap.c: points of quadrature on the intersection of an own face with faces of another body.
 *
 *   (OV1)  project the corners of both faces on the plane through the middle of the own face
 *   (OV2)  cut the own polygon by the edges of the other one (Sutherland and Hodgman, CACM 1974);
 *          in 2D cut intervals
 *   (OV3)  points by Gauss on its triangles; both shape functions at the point of the plane
 *
 * The products of shape functions of flat faces have degree 2 on triangles and edges, 4 on
 * parallelograms: the rules are exact for that (Strang and Fix 1973: 3 points and 6).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "geometry.h"

enum { overlap_most = 8 }; /* corners of the intersection of two convex quadrilaterals */

typedef struct overlap_polygon {
  int count;
  double x[overlap_most][2];
} overlap_polygon;

/* What the visits of one own face share. */
typedef struct overlap_search {
  const dlsi_tree *tree;
  const dlsi_faces *own;
  int face;
  double C[4][3], frame[3][3], middle[3], reach;
  dlsi_places *places;
  int failed;
} overlap_search;

dlsi_place *dlsi_place_add(dlsi_places *places) {
  if (places->count == places->room) {
    const size_t room = 2 * places->room + 64;
    dlsi_place *at = realloc(places->at, room * sizeof *at); /* half of it is there */
    if (!at) return NULL;
    places->at = at;
    places->room = room;
  }
  dlsi_place *place = &places->at[places->count++];
  *place = (dlsi_place){.face = -1};
  return place;
}

/* (OV1) flat: corners in the plane, z = 0. */
static void overlap_flatten(const overlap_search *s, int corners, double C[4][3],
                            double flat[4][3]) {
  for (int k = 0; k < corners; k++) {
    double v[3];
    for (int i = 0; i < 3; i++)
      v[i] = C[k][i] - s->middle[i];
    flat[k][0] = dlsi_dot3(s->frame[1], v);
    flat[k][1] = s->own->d == 2 ? 0 : dlsi_dot3(s->frame[2], v);
    flat[k][2] = 0;
  }
}

static double overlap_area(const overlap_polygon *p) {
  double area = 0;
  for (int k = 1; k + 1 < p->count; k++)
    area += (p->x[k][0] - p->x[0][0]) * (p->x[k + 1][1] - p->x[0][1]) -
            (p->x[k][1] - p->x[0][1]) * (p->x[k + 1][0] - p->x[0][0]);
  return area / 2;
}

/* (OV2) keeps what is to the right of a -> b. */
static void overlap_cut(overlap_polygon *p, const double a[3], const double b[3]) {
  const overlap_polygon old = *p;
  double side[overlap_most];
  for (int k = 0; k < old.count; k++)
    side[k] = (b[1] - a[1]) * (old.x[k][0] - a[0]) - (b[0] - a[0]) * (old.x[k][1] - a[1]);
  p->count = 0;
  for (int k = 0; k < old.count; k++) {
    const int l = (k + 1) % old.count;
    if (side[k] >= 0 && p->count < overlap_most)
      memcpy(p->x[p->count++], old.x[k], sizeof old.x[k]);
    if ((side[k] >= 0) == (side[l] >= 0) || p->count == overlap_most) continue;
    const double t = side[k] / (side[k] - side[l]);
    for (int i = 0; i < 2; i++)
      p->x[p->count][i] = old.x[k][i] + t * (old.x[l][i] - old.x[k][i]);
    p->count++;
  }
}

/* (OV3) adds the point y of the plane. */
static void overlap_point(overlap_search *s, int face, double flat[4][3], double other[4][3],
                          double C[4][3], const double y[3], double weight) {
  const dlsi_faces *own = s->own, *faces = &s->tree->faces;
  dlsi_place p = {.owns = own->corners, .face = face, .weight = weight};
  double c[3];
  dlsi_face_nearest(own->d, own->corners, flat, y, p.a, c, NULL);
  dlsi_face_nearest(own->d, faces->corners, other, y, p.w, c, NULL);
  for (int i = 0; i < 3; i++) {
    double apart = 0;
    for (int k = 0; k < own->corners; k++)
      apart += p.a[k] * s->C[k][i];
    for (int k = 0; k < faces->corners; k++)
      apart -= p.w[k] * C[k][i];
    p.n[i] = -s->frame[0][i];
    p.gap += p.n[i] * apart;
  }
  if (!(fabs(p.gap) <= s->reach)) return;
  for (int k = 0; k < own->corners; k++)
    p.own[k] = own->face[(size_t)own->corners * (size_t)s->face + (size_t)k] - own->base;
  dlsi_place *place = dlsi_place_add(s->places);
  if (place)
    *place = p;
  else
    s->failed = 1;
}

static void overlap_visit(void *data, int face) {
  /* the share of one corner in a point, and the weight of each of three points */
  static const double rule[3][2] = {{2. / 3, 1. / 3},
                                    {0.816847572980459, 0.109951743655322},
                                    {0.108103018168070, 0.223381589678011}};
  overlap_search *s = data;
  const dlsi_faces *own = s->own, *faces = &s->tree->faces;
  const int d = own->d, quads = own->corners == 4 || faces->corners == 4;
  double C[4][3], n[3], flat[4][3], other[4][3];
  dlsi_face_corners(faces, face, C);
  (void)dlsi_face_normal(d, faces->corners, C, n);
  if (!(dlsi_dot3(n, s->frame[0]) < 0)) return; /* it looks away */
  overlap_flatten(s, own->corners, s->C, flat);
  overlap_flatten(s, faces->corners, C, other);
  if (d == 2) {
    const double low = fmax(fmin(flat[0][0], flat[1][0]), fmin(other[0][0], other[1][0]));
    const double high = fmin(fmax(flat[0][0], flat[1][0]), fmax(other[0][0], other[1][0]));
    const double half = (high - low) / 2;
    if (!(half > 1e-12 * fabs(flat[1][0] - flat[0][0]))) return;
    for (int point = -1; point <= 1; point += 2)
      overlap_point(s, face, flat, other, C, (const double[3]){low + half + point * half / sqrt(3)},
                    half);
    return;
  }
  overlap_polygon p = {.count = own->corners};
  for (int k = 0; k < own->corners; k++)
    memcpy(p.x[k], flat[k], sizeof p.x[k]);
  const double whole = overlap_area(&p);
  for (int k = 0; k < faces->corners && p.count > 2; k++)
    overlap_cut(&p, other[k], other[(k + 1) % faces->corners]);
  if (!(p.count > 2 && overlap_area(&p) > 1e-12 * whole)) return;
  for (int k = 1; k + 1 < p.count; k++) { /* a fan of triangles */
    const double *const corner[3] = {p.x[0], p.x[k], p.x[k + 1]};
    const overlap_polygon triangle = {
        3, {{p.x[0][0], p.x[0][1]}, {p.x[k][0], p.x[k][1]}, {p.x[k + 1][0], p.x[k + 1][1]}}};
    const double area = overlap_area(&triangle);
    for (int point = 0; point < (quads ? 6 : 3); point++) {
      const double *one = rule[quads ? 1 + point / 3 : 0], rest = (1 - one[0]) / 2;
      double y[3] = {0};
      for (int i = 0; i < 2; i++)
        for (int l = 0; l < 3; l++)
          y[i] += (l == point % 3 ? one[0] : rest) * corner[l][i];
      if (area > 0) overlap_point(s, face, flat, other, C, y, one[1] * area);
    }
  }
}

dls_status dlsi_overlap(const dlsi_tree *tree, const dlsi_faces *own, int face, double reach,
                        dlsi_places *places, dls_error *error) {
  overlap_search s = {.tree = tree, .own = own, .face = face, .reach = reach, .places = places};
  double low[3], high[3];
  dlsi_face_corners(own, face, s.C);
  (void)dlsi_face_normal(own->d, own->corners, s.C, s.frame[0]);
  (void)dlsi_frame(own->d, s.frame);
  for (int i = 0; i < 3; i++) {
    low[i] = high[i] = s.C[0][i];
    for (int k = 0; k < own->corners; k++) {
      low[i] = fmin(low[i], s.C[k][i]);
      high[i] = fmax(high[i], s.C[k][i]);
      s.middle[i] += s.C[k][i] / own->corners;
    }
  }
  dlsi_tree_search(tree, low, high, &reach, overlap_visit, &s);
  return s.failed ? dlsi_no_memory(error) : DLS_OK;
}
