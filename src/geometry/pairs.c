/*
 * pairs.c: H_N, H_T, P and gaps from two surfaces.
 *
 *   (PA1)  check; mark the corners of the faces
 *   (PA2)  find places: one over which each node stands (nearest.c), or points of quadrature on the
 *          intersections of faces (overlap.c)
 *   (PA3)  write the rows of H and P, without unknowns that are held
 */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "contact/columns.h"
#include "geometry.h"

enum { pairs_corner = 1, pairs_twice = 2 }; /* marks of a node */

/* What is at hand while pairs are found. */
typedef struct pairs_work {
  const dls_surfaces *in;
  dlsi_faces faces, own;
  dlsi_tree tree;
  dlsi_places places;
  double reach;
  unsigned char *mark; /* points */
  dlsi_columns HN, HT, P;
  dls_pairs out;
} pairs_work;

/* ---- checks (PA1) ---------------------------------------------------------------------------- */

static dls_status pairs_numbers(const char *argument, const int *number, size_t count, int low,
                                int high, dls_error *error) {
  if (count > 0 && !number) return dlsi_is_null(error, argument);
  for (size_t k = 0; k < count; k++)
    if (number[k] < low || number[k] > high)
      return dlsi_fail(error, DLS_E_ARGUMENT, argument, (long long)k, number[k],
                       "is %d, outside of %d to %d", number[k], low, high);
  return DLS_OK;
}

static dls_status pairs_faces(const char *argument, const char *corners, const dls_surfaces *in,
                              const dlsi_faces *faces, dls_error *error) {
  if (faces->count == 0) return DLS_OK;
  if (in->d == 2 ? faces->corners != 2 : faces->corners != 3 && faces->corners != 4)
    return dlsi_fail(error, DLS_E_ARGUMENT, corners, -1, faces->corners, "is %d, must be %s",
                     faces->corners, in->d == 2 ? "2" : "3 or 4");
  dls_status status =
      pairs_numbers(argument, faces->face, (size_t)faces->corners * (size_t)faces->count, in->base,
                    in->base + in->points - 1, error);
  for (int f = 0; !status && f < faces->count; f++) {
    double C[4][3], n[3];
    dlsi_face_corners(faces, f, C);
    if (!dlsi_face_normal(in->d, faces->corners, C, n))
      status = dlsi_fail(error, DLS_E_ARGUMENT, argument, (long long)faces->corners * f,
                         faces->face[(size_t)faces->corners * (size_t)f], "face %d has no area", f);
  }
  return status;
}

static dls_status pairs_wall(const dls_surfaces *in, dls_error *error) {
  dls_status status = dlsi_check_vector("wall", in->wall, 2 * (size_t)in->d, error);
  double frame[3][3] = {{0}};
  for (int i = 0; !status && i < in->d; i++)
    frame[0][i] = in->wall[in->d + i];
  if (!status && !dlsi_frame(in->d, frame))
    status = dlsi_fail(error, DLS_E_ARGUMENT, "wall", -1, frame[0][0], "has no normal");
  if (!status && (in->faces > 0 || in->own))
    status = dlsi_fail(error, DLS_E_ARGUMENT, "wall", -1, in->faces, "with faces or own");
  return status;
}

static dls_status pairs_check(const dls_surfaces *in, dls_error *error) {
  const struct {
    const char *name;
    int value;
  } sizes[] = {{"n", in->n},
               {"points", in->points},
               {"nodes", in->nodes},
               {"faces", in->faces},
               {"own_faces", in->own_faces}};
  if (in->d != 2 && in->d != 3)
    return dlsi_fail(error, DLS_E_ARGUMENT, "d", -1, in->d, "is %d, must be 2 or 3", in->d);
  if (in->base != 0 && in->base != 1)
    return dlsi_fail(error, DLS_E_ARGUMENT, "base", -1, in->base, "is %d, must be 0 or 1",
                     in->base);
  for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++)
    if (sizes[k].value < 0 || sizes[k].value == INT_MAX)
      return dlsi_fail(error, DLS_E_SIZE, sizes[k].name, -1, sizes[k].value, "is %d",
                       sizes[k].value);
  if (isnan(in->reach)) return dlsi_fail(error, DLS_E_NOT_FINITE, "reach", -1, in->reach, "is NaN");
  if (in->reach < 0)
    return dlsi_fail(error, DLS_E_ARGUMENT, "reach", -1, in->reach, "is %g", in->reach);
  const size_t entries = (size_t)in->d * (size_t)in->points;
  dls_status status = dlsi_check_vector("X", in->X, entries, error);
  if (!status && in->dof) status = pairs_numbers("dof", in->dof, entries, -1, in->n - 1, error);
  if (!status && !in->dof && entries > (size_t)in->n)
    status = dlsi_fail(error, DLS_E_SIZE, "n", -1, in->n, "is %d, less than d points without dof",
                       in->n);
  if (!status && in->wall) status = pairs_wall(in, error);
  return status;
}

/* Marks the corners of the faces, and finds nodes that are given twice. */
static dls_status pairs_mark(pairs_work *work, dls_error *error) {
  const dls_surfaces *in = work->in;
  work->mark = calloc((size_t)in->points + 1, 1);
  if (!work->mark) return dlsi_no_memory(error);
  for (size_t k = 0; k < (size_t)in->corners * (size_t)in->faces; k++)
    work->mark[in->face[k] - in->base] |= pairs_corner;
  for (int k = 0; !in->own && k < in->nodes; k++) {
    unsigned char *mark = &work->mark[in->node[k] - in->base];
    if (*mark & pairs_twice)
      return dlsi_fail(error, DLS_E_ARGUMENT, "node", k, in->node[k], "is there twice");
    *mark |= pairs_twice;
  }
  return DLS_OK;
}

/* ---- places (PA2) ---------------------------------------------------------------------------- */

static int pairs_unknown(const dls_surfaces *in, int node, int i) {
  const size_t at = (size_t)in->d * (size_t)node + (size_t)i;
  return in->dof ? in->dof[at] : (int)at;
}

/* Returns node k of a place, own ones first, and its weight in u; -1 past the last. */
static int pairs_node(const pairs_work *work, const dlsi_place *place, int k, double *weight) {
  *weight = k < place->owns ? place->a[k] : 0;
  if (k < place->owns) return place->own[k];
  k -= place->owns;
  if (place->face < 0 || k >= work->faces.corners) return -1;
  *weight = -place->w[k];
  return work->faces.face[(size_t)work->faces.corners * (size_t)place->face + (size_t)k] -
         work->faces.base;
}

static int pairs_is_held(const pairs_work *work, const dlsi_place *place) {
  double weight;
  for (int k = 0, node; (node = pairs_node(work, place, k, &weight)) >= 0; k++)
    for (int i = 0; i < work->in->d; i++)
      if (weight * place->n[i] != 0 && pairs_unknown(work->in, node, i) >= 0) return 0;
  return 1;
}

/* Finds the place of a node on the faces or the wall. */
static dls_pair_state pairs_find_node(const pairs_work *work, int node, dlsi_place *place) {
  const dls_surfaces *in = work->in;
  dls_pair_state state = DLS_PAIR_FOUND;
  double P[3] = {0}, frame[3][3] = {{0}};
  *place = (dlsi_place){.own = {node}, .owns = 1, .face = -1, .a = {1}};
  for (int i = 0; i < in->d; i++)
    P[i] = in->X[(size_t)in->d * (size_t)node + (size_t)i];
  if (work->mark[node] & pairs_corner) return DLS_PAIR_SHARED;
  if (in->wall) {
    for (int i = 0; i < in->d; i++)
      frame[0][i] = in->wall[in->d + i];
    (void)dlsi_frame(in->d, frame);
    memcpy(place->n, frame[0], sizeof place->n);
    for (int i = 0; i < in->d; i++)
      place->gap += place->n[i] * (P[i] - in->wall[i]);
    if (!(fabs(place->gap) <= work->reach)) state = DLS_PAIR_FAR;
  } else
    state = in->faces > 0 ? dlsi_nearest(&work->tree, work->reach, P, place) : DLS_PAIR_FAR;
  return state == DLS_PAIR_FOUND && pairs_is_held(work, place) ? DLS_PAIR_HELD : state;
}

/* The contact nodes are nodes. */
static dls_status pairs_of_nodes(pairs_work *work, dls_error *error) {
  const size_t count = (size_t)work->in->nodes;
  dls_pair_state *state = dlsi_alloc(count, sizeof *state);
  int *node = dlsi_alloc(count, sizeof *node);
  work->out.state = state;
  work->out.node = node;
  if (!state || !node) return dlsi_no_memory(error);
  for (size_t k = 0; k < count; k++) {
    dlsi_place place;
    state[k] = pairs_find_node(work, work->in->node[k] - work->in->base, &place);
    if (state[k]) continue;
    dlsi_place *to = dlsi_place_add(&work->places);
    if (!to) return dlsi_no_memory(error);
    *to = place;
    node[work->out.candidates++] = work->in->node[k];
  }
  return DLS_OK;
}

/* The contact nodes are points of quadrature: fills P, node, measure. */
static dls_status pairs_of_points(pairs_work *work, dls_error *error) {
  const size_t points = (size_t)work->in->points;
  const int base = work->in->base;
  dls_status status = DLS_OK;
  for (int f = 0; !status && work->in->faces > 0 && f < work->own.count; f++)
    status = dlsi_overlap(&work->tree, &work->own, f, work->reach, &work->places, error);
  if (status) return status;
  size_t count = 0;
  for (size_t q = 0; q < work->places.count; q++)
    if (!pairs_is_held(work, &work->places.at[q])) work->places.at[count++] = work->places.at[q];
  work->places.count = count;
  dlsi_triplets t = {0};
  double *area = calloc(points + 1, sizeof *area), *measure = dlsi_alloc(points, sizeof *measure);
  int *node = dlsi_alloc(points, sizeof *node), *column = dlsi_alloc(points, sizeof *column);
  work->out.measure = measure;
  work->out.node = node;
  status = area && measure && node && column ? DLS_OK : dlsi_no_memory(error);
  for (size_t q = 0; !status && q < count; q++) {
    const dlsi_place *place = &work->places.at[q];
    for (int k = 0; k < place->owns; k++)
      if (!(work->mark[place->own[k]] & pairs_corner))
        area[place->own[k]] += place->weight * place->a[k];
  }
  for (size_t k = 0; !status && k < points; k++) {
    if (!(area[k] > 0)) continue;
    column[k] = work->out.candidates;
    measure[work->out.candidates] = area[k];
    node[work->out.candidates++] = (int)k + base;
  }
  if (!status)
    status =
        count < INT_MAX
            ? dlsi_triplets_alloc((int)count, work->out.candidates, 4 * count, &t, error)
            : dlsi_fail(error, DLS_E_SIZE, "own_faces", -1, (double)count, "%zu points", count);
  for (size_t q = 0; !status && q < count; q++) {
    const dlsi_place *place = &work->places.at[q];
    for (int k = 0; k < place->owns; k++)
      if (place->a[k] != 0 && area[place->own[k]] > 0)
        dlsi_triplets_add(&t, (int)q, column[place->own[k]],
                          place->weight * place->a[k] / area[place->own[k]]);
  }
  if (!status) status = dlsi_columns_compress(&t, 1, DLSI_ALL, &work->P, error);
  dlsi_triplets_free(&t);
  free(area);
  free(column);
  return status;
}

/* ---- operators (PA3) ------------------------------------------------------------------------- */

static dls_status pairs_operators(pairs_work *work, dls_error *error) {
  const dls_surfaces *in = work->in;
  const size_t d = (size_t)in->d, count = work->places.count;
  const size_t most =
      count * d * d * (size_t)((in->own ? in->own_corners : 1) + work->faces.corners);
  if (d * count > INT_MAX)
    return dlsi_fail(error, DLS_E_SIZE, "nodes", -1, (double)count, "%zu pairs are too many",
                     count);
  dlsi_triplets t = {0};
  double *g = calloc(d * count + 1, sizeof *g), *frames = dlsi_alloc(count, d * d * sizeof *frames);
  int *face = dlsi_alloc(count, sizeof *face);
  work->out.g = g;
  work->out.frame = frames;
  work->out.face = face;
  work->out.nodes = (int)count;
  dls_status status = g && frames && face
                          ? dlsi_triplets_alloc(in->n, (int)(d * count), most, &t, error)
                          : dlsi_no_memory(error);
  for (size_t c = 0; !status && c < count; c++) {
    const dlsi_place *place = &work->places.at[c];
    double frame[3][3], weight;
    memcpy(frame[0], place->n, sizeof place->n);
    (void)dlsi_frame(in->d, frame);
    g[d * c] = place->gap;
    face[c] = place->face;
    for (size_t j = 0; j < d; j++)
      memcpy(frames + d * (d * c + j), frame[j], d * sizeof *frames);
    for (int k = 0, node; (node = pairs_node(work, place, k, &weight)) >= 0; k++)
      for (size_t j = 0; j < d; j++)
        for (int i = 0; i < in->d; i++) {
          const int unknown = pairs_unknown(in, node, i);
          if (unknown >= 0 && weight * frame[j][i] != 0)
            dlsi_triplets_add(&t, unknown, (int)(d * c + j), weight * frame[j][i]);
        }
  }
  if (!status) status = dlsi_columns_compress(&t, in->d, DLSI_NORMALS, &work->HN, error);
  if (!status) status = dlsi_columns_compress(&t, in->d, DLSI_TANGENTS, &work->HT, error);
  dlsi_triplets_free(&t);
  return status;
}

static dls_status pairs_find(pairs_work *work, dls_error *error) {
  const dls_surfaces *in = work->in;
  dls_status status = pairs_check(in, error);
  if (status) return status;
  work->faces = (dlsi_faces){in->d, in->faces, in->corners, in->base, in->X, in->face};
  work->own = (dlsi_faces){in->d, in->own_faces, in->own_corners, in->base, in->X, in->own};
  status = pairs_faces("face", "corners", in, &work->faces, error);
  if (!status && in->own) status = pairs_faces("own", "own_corners", in, &work->own, error);
  if (!status && !in->own)
    status = pairs_numbers("node", in->node, (size_t)in->nodes, in->base, in->base + in->points - 1,
                           error);
  if (!status) status = pairs_mark(work, error);
  work->reach = in->reach > 0 ? in->reach : in->wall ? INFINITY : 0;
  for (int f = 0; !status && in->reach == 0 && f < in->faces; f++) {
    double C[4][3];
    dlsi_face_corners(&work->faces, f, C);
    work->reach = fmax(work->reach, dlsi_face_size(in->corners, C));
  }
  if (!status && in->faces > 0) status = dlsi_tree_create(&work->tree, &work->faces, error);
  if (!status) status = in->own ? pairs_of_points(work, error) : pairs_of_nodes(work, error);
  return status ? status : pairs_operators(work, error);
}

/* ---- the door -------------------------------------------------------------------------------- */

dls_status dls_pairs_find(const dls_surfaces *surfaces, dls_pairs *out, dls_error *error) {
  DLSI_DOOR;
  dls_status status = out ? DLS_OK : dlsi_is_null(error, "out");
  if (out) *out = (dls_pairs){.nodes = 0};
  if (!status && !surfaces) status = dlsi_is_null(error, "surfaces");
  if (status) return dlsi_at(__func__, status, error);
  pairs_work work = {.in = surfaces};
  status = pairs_find(&work, error);
  work.out.HN = dlsi_columns_view(&work.HN);
  work.out.HT = dlsi_columns_view(&work.HT);
  work.out.P = dlsi_columns_view(&work.P);
  if (!status && !surfaces->own) work.out.candidates = work.out.nodes;
  dlsi_tree_free(&work.tree);
  free(work.places.at);
  free(work.mark);
  if (status)
    dls_pairs_free(&work.out);
  else
    *out = work.out;
  return dlsi_at(__func__, status, error);
}

void dls_pairs_free(dls_pairs *pairs) {
  if (!pairs) return;
  const dls_sparse *const all[] = {&pairs->HN, &pairs->HT, &pairs->P};
  for (int k = 0; k < 3; k++) {
    free((void *)(uintptr_t)all[k]->p);
    free((void *)(uintptr_t)all[k]->i);
    free((void *)(uintptr_t)all[k]->x);
  }
  const void *const arrays[] = {pairs->g,    pairs->frame,   pairs->face,
                                pairs->node, pairs->measure, pairs->state};
  for (int k = 0; k < 6; k++)
    free((void *)(uintptr_t)arrays[k]);
  *pairs = (dls_pairs){.nodes = 0};
}
