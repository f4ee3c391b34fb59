/*
 * nearest.c: the face over which a node stands, by a tree of boxes.
 *
 *   (NE1)  order the faces along Morton's curve through their middles; halves of this order are the
 *          nodes of a tree, a box each
 *   (NE2)  keep of the faces in reach the nearest one over which the node stands (over), and the
 *          nearest point of all others (edge); faces that meet in one point count together
 *   (NE3)  a convex edge: the node is within the cone of the normals that meet there, and nearer
 *          than `over`
 *
 * Cost: O(faces log faces), then O(log faces) a node; a node beside the surface looks at all faces
 * in reach.
 */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "geometry.h"

/* ---- the tree (NE1) -------------------------------------------------------------------------- */

typedef struct tree_key {
  uint64_t key;
  int face;
} tree_key;

static int tree_compare(const void *a, const void *b) {
  const tree_key *l = a, *r = b;
  if (l->key != r->key) return l->key < r->key ? -1 : 1;
  return (l->face > r->face) - (l->face < r->face);
}

static void tree_grow(double box[2][3], const double low[3], const double high[3]) {
  for (int i = 0; i < 3; i++) {
    if (low[i] < box[0][i]) box[0][i] = low[i];
    if (high[i] > box[1][i]) box[1][i] = high[i];
  }
}

static void tree_empty(double box[2][3]) {
  for (int i = 0; i < 3; i++) {
    box[0][i] = INFINITY;
    box[1][i] = -INFINITY;
  }
}

static void tree_of_face(const dlsi_tree *tree, int face, double box[2][3]) {
  double C[4][3];
  dlsi_face_corners(&tree->faces, face, C);
  tree_empty(box);
  for (int k = 0; k < tree->faces.corners; k++)
    tree_grow(box, C[k], C[k]);
}

/* Fills the boxes of the faces first .. end-1 of the order, from node on. */
static void tree_fill(dlsi_tree *tree, int node, int first, int end) {
  if (end - first == 1) {
    tree_of_face(tree, tree->order[first], tree->box[node]);
    return;
  }
  const int middle = first + (end - first) / 2, right = node + 2 * (middle - first);
  tree_fill(tree, node + 1, first, middle);
  tree_fill(tree, right, middle, end);
  tree_empty(tree->box[node]);
  tree_grow(tree->box[node], tree->box[node + 1][0], tree->box[node + 1][1]);
  tree_grow(tree->box[node], tree->box[right][0], tree->box[right][1]);
}

dls_status dlsi_tree_create(dlsi_tree *tree, const dlsi_faces *faces, dls_error *error) {
  const size_t count = (size_t)faces->count;
  *tree = (dlsi_tree){.faces = *faces};
  tree->order = dlsi_alloc(count, sizeof *tree->order);
  tree->box = dlsi_alloc(2 * count, sizeof *tree->box);
  tree_key *keys = dlsi_alloc(count, sizeof *keys);
  if (!tree->order || !tree->box || !keys) {
    free(keys);
    return dlsi_no_memory(error);
  }
  double whole[2][3], box[2][3], size = 0;
  tree_empty(whole);
  for (int f = 0; f < faces->count; f++) {
    tree_of_face(tree, f, box);
    tree_grow(whole, box[0], box[1]);
  }
  for (int i = 0; i < 3; i++)
    size = fmax(size, whole[1][i] - whole[0][i]);
  for (int f = 0; f < faces->count; f++) {
    tree_of_face(tree, f, box);
    keys[f] = (tree_key){0, f};
    for (int i = 0; i < 3; i++) {
      const double middle = (box[0][i] / 2 + box[1][i] / 2 - whole[0][i]) / size;
      const uint64_t cell = middle > 0 ? (uint64_t)(middle * 0x1fffff) : 0;
      for (int bit = 0; bit < 21; bit++)
        keys[f].key |= (cell >> bit & 1) << (3 * bit + i);
    }
  }
  qsort(keys, count, sizeof *keys, tree_compare);
  for (size_t k = 0; k < count; k++)
    tree->order[k] = keys[k].face;
  free(keys);
  tree_fill(tree, 0, 0, faces->count);
  return DLS_OK;
}

void dlsi_tree_free(dlsi_tree *tree) {
  free(tree->order);
  free(tree->box);
  *tree = (dlsi_tree){.order = NULL};
}

/* What dlsi_tree_search hands down. */
typedef struct tree_walk {
  const dlsi_tree *tree;
  const double *low, *high, *reach;
  void (*visit)(void *, int);
  void *data;
} tree_walk;

/* Returns the distance of a box of the tree from the box of the search. */
static double tree_distance(const tree_walk *walk, int node) {
  double(*box)[3] = walk->tree->box[node], sum = 0;
  for (int i = 0; i < 3; i++) {
    const double below = box[0][i] - walk->high[i], above = walk->low[i] - box[1][i];
    const double v = below > 0 ? below : above > 0 ? above : 0;
    sum += v * v;
  }
  return sqrt(sum);
}

static void tree_walk_down(const tree_walk *walk, int node, int first, int end) {
  if (end - first == 1) {
    walk->visit(walk->data, walk->tree->order[first]);
    return;
  }
  const int middle = first + (end - first) / 2, left = node + 1,
            right = node + 2 * (middle - first);
  const double of_left = tree_distance(walk, left), of_right = tree_distance(walk, right);
  for (int k = 0; k < 2; k++) {
    const int go_left = (of_left <= of_right) == (k == 0);
    if (!((go_left ? of_left : of_right) <= *walk->reach)) continue;
    if (go_left)
      tree_walk_down(walk, left, first, middle);
    else
      tree_walk_down(walk, right, middle, end);
  }
}

void dlsi_tree_search(const dlsi_tree *tree, const double low[3], const double high[3],
                      const double *reach, void visit(void *data, int face), void *data) {
  const tree_walk walk = {tree, low, high, reach, visit, data};
  if (tree_distance(&walk, 0) <= *reach) tree_walk_down(&walk, 0, 0, tree->faces.count);
}

/* ---- the face over which a node stands (NE2), (NE3) --------------------------------------------
 * */

/* The nearest point so far; faces that meet there. */
typedef struct nearest_point {
  int face; /* the first of them; -1: none */
  double distance, size, w[4], c[3], n[3];
  double sum[3], cosine; /* of the normals that meet; the least n . (another normal) */
} nearest_point;

typedef struct nearest_search {
  const dlsi_tree *tree;
  const double *P;
  double reach; /* shrinks to that of `over` */
  nearest_point over, edge;
} nearest_search;

/* Takes in a point: the nearer one, or one more face at the same place. */
static void nearest_take(nearest_point *best, const nearest_point *it) {
  const double same = 1e-9 * it->size;
  double apart = 0;
  for (int i = 0; i < 3; i++)
    apart = fmax(apart, fabs(it->c[i] - best->c[i]));
  const int level = best->face >= 0 && fabs(it->distance - best->distance) <= same;
  if (level && apart <= same) {
    for (int i = 0; i < 3; i++)
      best->sum[i] += it->n[i];
    best->cosine = fmin(best->cosine, dlsi_dot3(best->n, it->n));
    if (it->face > best->face) return;
    best->face = it->face;
    memcpy(best->w, it->w, sizeof it->w);
  } else if (best->face < 0 || (level ? it->face < best->face : it->distance < best->distance))
    *best = *it;
}

static void nearest_visit(void *data, int face) {
  nearest_search *search = data;
  const dlsi_faces *faces = &search->tree->faces;
  double C[4][3], v[3], miss = 0;
  nearest_point it = {.face = face, .cosine = 1};
  dlsi_face_corners(faces, face, C);
  dlsi_face_nearest(faces->d, faces->corners, C, search->P, it.w, it.c, it.n);
  for (int i = 0; i < 3; i++)
    v[i] = search->P[i] - it.c[i];
  it.size = dlsi_face_size(faces->corners, C);
  it.distance = sqrt(dlsi_dot3(v, v));
  if (!(it.distance <= search->reach)) return;
  memcpy(it.sum, it.n, sizeof it.n);
  for (int i = 0; i < 3; i++)
    miss = hypot(miss, v[i] - dlsi_dot3(v, it.n) * it.n[i]);
  if (miss > dlsi_beside * it.size) {
    nearest_take(&search->edge, &it);
    return;
  }
  nearest_take(&search->over, &it);
  search->reach = fmin(search->reach, it.distance + 1e-9 * it.size);
}

dls_pair_state dlsi_nearest(const dlsi_tree *tree, double reach, const double P[3],
                            dlsi_place *place) {
  nearest_search search = {.tree = tree, .P = P, .reach = reach, .over.face = -1, .edge.face = -1};
  dlsi_tree_search(tree, P, P, &search.reach, nearest_visit, &search);
  const nearest_point *edge = &search.edge, *it = &search.over;
  double v[3], along = 0;
  for (int i = 0; i < 3; i++)
    v[i] = P[i] - edge->c[i];
  if (edge->face >= 0) along = dlsi_dot3(v, edge->n);
  const int is_edge = edge->face >= 0 && (it->face < 0 || edge->distance < it->distance) &&
                      fabs(along) >= (edge->cosine - 1e-9) * edge->distance &&
                      edge->cosine < 1 - 1e-9;
  if (is_edge) it = edge;
  if (it->face < 0) return edge->face < 0 ? DLS_PAIR_FAR : DLS_PAIR_BESIDE;
  const double length = sqrt(dlsi_dot3(it->sum, it->sum));
  place->face = it->face;
  memcpy(place->w, it->w, sizeof it->w);
  for (int i = 0; i < 3; i++) {
    place->n[i] = length > 1e-6 ? it->sum[i] / length : it->n[i];
    v[i] = P[i] - it->c[i];
  }
  for (int i = 0; is_edge && i < 3; i++)
    place->n[i] = (along < 0 ? -v[i] : v[i]) / it->distance;
  place->gap = dlsi_dot3(v, place->n);
  return DLS_PAIR_FOUND;
}
