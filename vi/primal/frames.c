/*
 * frames.c: the stiffness in the local frames of the contact nodes.
 *
 * Contact node c acts on its two unknowns only: u_c = B_c^T x_c + g_c, forces B_c r_c, with
 * B_c = (n, t) regular, 2 x 2. In the unknowns x' with x_c = T_c x'_c, T_c = B_c^-T, and x' = x
 * elsewhere,
 *
 *   K x = f + H r   becomes   K' x' = f' + r,   K' = T^T K T,   f' = T^T f,   x'_c = u_c - g_c
 *
 * A frame along the axes only renumbers two unknowns, and K' has the entries of K. An inclined
 * frame mixes two columns and two rows and unites their patterns.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "vi/vi_internal.h"

/* ---- the frames ------------------------------------------------------------------------------ */

/* v := the entries of column c of H in the rows unknown[0..1], which are filled as they are found
 * (-1: not yet). Returns 0 if there is a third row. */
static int frames_gather(const dls_sparse *H, int c, int unknown[2], double v[2]) {
  v[0] = v[1] = 0;
  for (int k = H->p[c]; k < H->p[c + 1]; k++) {
    if (H->x[k] == 0) continue;
    int s = 0;
    while (s < 2 && unknown[s] >= 0 && unknown[s] != H->i[k])
      s++;
    if (s == 2) return 0;
    unknown[s] = H->i[k];
    v[s] += H->x[k];
  }
  return 1;
}

static dls_status frames_refuse(const char *argument, int c, const char *why, dls_error *error) {
  return dlsi_fail(error, DLS_E_UNSUPPORTED, argument, c, 0, "%s; condense this model", why);
}

static dls_status frames_find(dlsi_frames *a, const dls_model *model, dls_error *error) {
  for (int i = 0; i < a->n; i++)
    a->node[i] = -1;
  for (int c = 0; c < a->nodes; c++) {
    int unknown[2] = {-1, -1};
    double n[2], t[2];
    if (!frames_gather(&model->HN, c, unknown, n))
      return frames_refuse("HN", c, "acts on more than two unknowns", error);
    if (unknown[0] < 0) return frames_refuse("HN", c, "acts on no unknown", error);
    if (!frames_gather(&model->HT, c, unknown, t))
      return frames_refuse("HT", c, "acts, with HN, on more than two unknowns", error);
    const double det = n[0] * t[1] - n[1] * t[0];
    if (unknown[1] < 0 || !(fabs(det) > 1e-8 * hypot(n[0], n[1]) * hypot(t[0], t[1])))
      return frames_refuse("HT", c, "is parallel to HN", error);
    for (int s = 0; s < 2; s++) {
      if (a->node[unknown[s]] >= 0)
        return frames_refuse(n[s] != 0 ? "HN" : "HT", c,
                             "acts on an unknown of another contact node", error);
      a->node[unknown[s]] = c;
    }
    a->normal[c] = unknown[0];
    a->tangent[c] = unknown[1];
    double *T = a->T + 4 * (size_t)c; /* B^-T */
    T[0] = t[1] / det;
    T[1] = -t[0] / det;
    T[2] = -n[1] / det;
    T[3] = n[0] / det;
  }
  return DLS_OK;
}

/* Finds the one or two entries of row i of T. Returns how many are not zero. */
static int frames_row_of_T(const dlsi_frames *a, int i, int column[2], double coefficient[2]) {
  const int c = a->node[i];
  column[0] = i;
  coefficient[0] = 1;
  if (c < 0) return 1;
  const double *T = a->T + 4 * (size_t)c + (i == a->normal[c] ? 0 : 1);
  int count = 0;
  for (int s = 0; s < 2; s++)
    if (T[2 * s] != 0) {
      column[count] = s == 0 ? a->normal[c] : a->tangent[c];
      coefficient[count++] = T[2 * s];
    }
  return count;
}

/* ---- K' -------------------------------------------------------------------------------------- */

/* Adds the entries that K_ij = K_ji = v (i >= j) gives to K' = T^T K T: counts them in next[column]
 * while row is NULL, then puts them at next[column]. */
static void frames_emit(const dlsi_frames *a, int i, int j, double v, size_t *next) {
  int p[2], q[2];
  double s[2], t[2];
  const int rows = frames_row_of_T(a, i, p, s), columns = frames_row_of_T(a, j, q, t);
  for (int k = 0; k < rows; k++)
    for (int l = 0; l < columns; l++)
      for (int mirror = 0; mirror < (i == j ? 1 : 2); mirror++) {
        const size_t at = next[mirror ? p[k] : q[l]]++;
        if (!a->row) continue;
        a->row[at] = mirror ? q[l] : p[k];
        a->value[at] = v * (s[k] * t[l]);
      }
}

static void frames_emit_all(const dlsi_frames *a, const dls_model *model, size_t *next) {
  const dls_sparse *S = &model->Ks;
  const dls_dense *K = &model->K;
  if (model->operator_kind == DLS_STIFFNESS_SPARSE) {
    for (int j = 0; j < a->n; j++)
      for (int k = S->p[j]; k < S->p[j + 1]; k++)
        if (S->i[k] >= j && S->x[k] != 0) frames_emit(a, S->i[k], j, S->x[k], next);
    return;
  }
  for (int j = 0; j < a->n; j++)
    for (int i = j; i < a->n; i++) {
      const double v = K->a[(size_t)i + (size_t)j * (size_t)K->ld];
      if (v != 0) frames_emit(a, i, j, v, next);
    }
}

/* Sums entries of one place, column by column, and stores the diagonal. place: scratch, n. */
static void frames_merge(dlsi_frames *a, size_t *place) {
  size_t end = 0; /* of the merged entries */
  memset(place, 0, (size_t)a->n * sizeof *place);
  for (int j = 0; j < a->n; j++) {
    const size_t begin = end;
    for (size_t k = a->start[j]; k < a->start[j + 1]; k++) {
      const int i = a->row[k];
      if (place[i] > begin) { /* position + 1, in this column */
        a->value[place[i] - 1] += a->value[k];
        continue;
      }
      a->row[end] = i;
      a->value[end] = a->value[k];
      place[i] = ++end;
    }
    a->start[j] = begin;
    a->diagonal[j] = place[j] > begin ? a->value[place[j] - 1] : 0;
  }
  a->start[a->n] = end;
}

double dlsi_frames_coupling(const dlsi_frames *frames, int c) {
  const int i = frames->normal[c];
  double coupling = 0;
  for (size_t k = frames->start[i]; k < frames->start[i + 1]; k++)
    if (frames->row[k] == frames->tangent[c]) coupling = frames->value[k];
  return coupling;
}

/* Checks the pivots of K' that the sweeps divide by. K: its name. */
static dls_status frames_check_pivots(const dlsi_frames *a, const char *K, dls_error *error) {
  const long long bad = dlsi_first_not_finite(a->value, a->start[a->n]);
  if (bad >= 0)
    return dlsi_fail(error, DLS_E_NOT_FINITE, K, -1, a->value[bad],
                     "entries add up to a number that is not finite");
  for (int i = 0; i < a->n; i++)
    if (!(a->diagonal[i] > 0))
      return dlsi_fail(error, DLS_E_NOT_POSITIVE_DEFINITE, K, i, a->diagonal[i],
                       "the diagonal entry of unknown %d is %g", i, a->diagonal[i]);
  for (int c = 0; c < a->nodes; c++) {
    const int i = a->normal[c], j = a->tangent[c];
    const double coupling = dlsi_frames_coupling(a, c);
    const double pivot = a->diagonal[j] - coupling * (coupling / a->diagonal[i]);
    if (!(pivot > 0))
      return dlsi_fail(error, DLS_E_NOT_POSITIVE_DEFINITE, K, j, pivot,
                       "the pivot of unknown %d within contact node %d is %g", j, c, pivot);
  }
  return DLS_OK;
}

static void frames_carve(dlsi_arena *arena, dlsi_frames *a) {
  const size_t n = (size_t)a->n, nodes = (size_t)a->nodes;
  a->start = dlsi_take(arena, n + 1, sizeof *a->start);
  a->diagonal = dlsi_take(arena, n, sizeof *a->diagonal);
  a->node = dlsi_take(arena, n, sizeof *a->node);
  a->normal = dlsi_take(arena, nodes, sizeof *a->normal);
  a->tangent = dlsi_take(arena, nodes, sizeof *a->tangent);
  a->T = dlsi_take(arena, 4 * nodes, sizeof *a->T);
}

dls_status dlsi_frames_create(dlsi_frames *frames, const dls_model *model, dls_error *error) {
  dlsi_frames *a = frames;
  *a = (dlsi_frames){.n = model->n, .nodes = model->nodes};
  const size_t n = (size_t)a->n;
  dlsi_arena arena = {0};
  frames_carve(&arena, a);
  dls_status status = dlsi_arena_allocate(&arena, "n", model->n, error);
  if (status) return status;
  a->memory = arena.base;
  frames_carve(&arena, a);
  status = frames_find(a, model, error);
  if (status) return status;

  size_t *next = dlsi_alloc(n, sizeof *next);
  if (!next) return dlsi_no_memory(error);
  memset(next, 0, n * sizeof *next);
  frames_emit_all(a, model, next); /* counts */
  a->start[0] = 0;
  for (size_t j = 0; j < n; j++) {
    a->start[j + 1] = a->start[j] + next[j];
    next[j] = a->start[j];
  }
  a->row = dlsi_alloc(a->start[n], sizeof *a->row);
  a->value = dlsi_alloc(a->start[n], sizeof *a->value);
  if (a->row && a->value) {
    frames_emit_all(a, model, next);
    frames_merge(a, next);
    const int sparse = model->operator_kind == DLS_STIFFNESS_SPARSE;
    status = frames_check_pivots(a, sparse ? "Ks" : "K", error);
  } else
    status = dlsi_no_memory(error);
  free(next);
  return status;
}

void dlsi_frames_free(dlsi_frames *frames) {
  free(frames->row);
  free(frames->value);
  free(frames->memory);
}

/* ---- vectors --------------------------------------------------------------------------------- */

typedef enum frames_turn { FORCES, UNKNOWNS, POSITIONS } frames_turn;

/* to := T^T from, T from or T^-1 from at the contact nodes, else from. */
static void frames_apply(const dlsi_frames *frames, frames_turn how, const double *from,
                         double *to) {
  if (to != from) memcpy(to, from, (size_t)frames->n * sizeof *from);
  for (int c = 0; c < frames->nodes; c++) {
    const double *T = frames->T + 4 * (size_t)c;
    const int i = frames->normal[c], j = frames->tangent[c];
    const double M[3][4] = {
        {T[0], T[1], T[2], T[3]}, {T[0], T[2], T[1], T[3]}, {T[3], -T[2], -T[1], T[0]}};
    const double a = from[i], b = from[j], det = how == POSITIONS ? T[0] * T[3] - T[2] * T[1] : 1;
    to[i] = (M[how][0] * a + M[how][1] * b) / det;
    to[j] = (M[how][2] * a + M[how][3] * b) / det;
  }
}

void dlsi_frames_forces(const dlsi_frames *frames, const double *f, double *local) {
  frames_apply(frames, FORCES, f, local);
}

void dlsi_frames_unknowns(const dlsi_frames *frames, const double *local, double *x) {
  frames_apply(frames, UNKNOWNS, local, x);
}

void dlsi_frames_positions(const dlsi_frames *frames, const double *x, double *local) {
  frames_apply(frames, POSITIONS, x, local);
}
