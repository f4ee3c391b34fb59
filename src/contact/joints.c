/*
 * joints.c: connected bodies, and joints between them: multipliers among the unknowns of K.
 *
 *   K = (A  G; G^T  0):   A x + G l = f + H r,   G^T x = b    l: multipliers, b: their part of f
 *
 * Row j of G^T x = b is a joint. The diagonal of K shows which unknowns are multipliers:
 *
 *   (JO1)  K_jj > 0, or H touches unknown j    position
 *          K_jj < 0                            multiplier of a joint that gives way
 *          K_jj = 0, a neighbour of a position multiplier
 *          K_jj = 0, a neighbour of these      position without stiffness: a rigid body at rest
 *          .. and so on in turns
 *   (JO2)  of unknowns that this does not reach, those without an earlier neighbour are positions;
 *          (JO1) goes on: bodies without any stiffness come before the joints between them
 *
 * Cost: a pass over K, and one for each turn where a diagonal entry is 0. Cannot fail.
 */
#include "body.h"

/* Returns the root of i, the smallest unknown of its tree; halves the path on the way. */
static int body_root(int *parent, int i) {
  while (parent[i] != i) {
    parent[i] = parent[parent[i]];
    i = parent[i];
  }
  return i;
}

void dlsi_body_join(int *part, int i, int j) {
  const int a = body_root(part, i), b = body_root(part, j);
  part[a < b ? b : a] = a < b ? a : b;
}

int dlsi_body_number(int n, int *part) {
  int parts = 0;
  for (int i = 0; i < n; i++) /* every parent comes before its children: it is numbered */
    part[i] = part[i] == i ? parts++ : part[part[i]];
  return parts;
}

int dlsi_body_parts(const dls_model *model, int *part) {
  for (int i = 0; i < model->n; i++)
    part[i] = i;
  for (int j = 0; j < model->n; j++) {
    double v;
    for (int at = 0, i; dlsi_body_entry(model, j, &at, &i, &v);)
      if (v != 0 && i != j) dlsi_body_join(part, i, j);
  }
  return dlsi_body_number(model->n, part);
}

int dlsi_body_pieces(const dls_model *model, const int *joint, int *piece) {
  int pieces = 0;
  for (int i = 0; i < model->n; i++)
    piece[i] = i;
  for (int j = 0; j < model->n; j++) {
    double v;
    for (int at = 0, i; dlsi_body_entry(model, j, &at, &i, &v);)
      if (v != 0 && i != j && !joint[i] && !joint[j]) dlsi_body_join(piece, i, j);
  }
  for (int i = 0; i < model->n; i++)
    piece[i] = joint[i] ? -1 : piece[i] == i ? pieces++ : piece[piece[i]];
  return pieces;
}

/* ---- multipliers ----------------------------------------------------------------------------- */

/* Sets turn[j] := 1 for a position and 2 for a multiplier, -1 if the diagonal leaves it open.
 * Returns how many are open. */
static int joints_begin(const dls_model *model, const dls_sparse *Ht, int *turn) {
  int open = 0;
  double v;
  for (int j = 0; j < model->n; j++) {
    double diagonal = 0;
    for (int at = 0, i; dlsi_body_entry(model, j, &at, &i, &v);)
      if (i == j) diagonal += v;
    const int touched = Ht && Ht->p[j] < Ht->p[j + 1];
    turn[j] = diagonal > 0 || touched ? 1 : diagonal < 0 ? 2 : 0;
    open += turn[j] == 0;
  }
  if (open == 0) return 0;
  for (int j = 0; j < model->n; j++)
    for (int at = 0, i; dlsi_body_entry(model, j, &at, &i, &v);) {
      if (v == 0 || i == j) continue;
      if (turn[i] == 0) turn[i] = -1;
      if (turn[j] == 0) turn[j] = -1;
    }
  open = 0;
  for (int j = 0; j < model->n; j++) {
    if (turn[j] == 0) turn[j] = 1; /* nothing beside it */
    open += turn[j] < 0;
  }
  return open;
}

/* Sets turn := now + 1 for the open neighbours of those of turn `now`; returns how many. */
static int joints_wave(const dls_model *model, int *turn, int now) {
  int found = 0;
  for (int j = 0; j < model->n; j++) {
    double v;
    for (int at = 0, i; dlsi_body_entry(model, j, &at, &i, &v);) {
      if (v == 0 || (turn[i] < 0) == (turn[j] < 0)) continue;
      const int old = turn[i] < 0 ? j : i, other = turn[i] < 0 ? i : j;
      if (turn[old] != now) continue;
      turn[other] = now + 1;
      found++;
    }
  }
  return found;
}

/* Sets turn := now for open unknowns that have no earlier open neighbour; returns how many. */
static int joints_seed(const dls_model *model, int *turn, int now) {
  int found = 0;
  for (int j = 0; j < model->n; j++) {
    double v;
    for (int at = 0, i; dlsi_body_entry(model, j, &at, &i, &v);)
      if (v != 0 && i != j && turn[i] < 0 && turn[j] < 0) turn[i > j ? i : j] = -2;
  }
  for (int j = 0; j < model->n; j++) {
    found += turn[j] == -1;
    if (turn[j] < 0) turn[j] = turn[j] == -1 ? now : -1;
  }
  return found;
}

int dlsi_body_joints(const dls_model *model, const dls_sparse *Ht, int *joint) {
  int *turn = joint, open = joints_begin(model, Ht, turn), count = 0;
  for (int now = 1, idle = 0; open > 0; now++) { /* odd: positions; even: multipliers */
    const int found = joints_wave(model, turn, now);
    idle = found ? 0 : idle + 1;
    open -= found;
    if (open == 0 || idle < 2) continue;
    now += now % 2; /* the next turn is odd */
    open -= joints_seed(model, turn, now + 1);
    idle = 0;
  }
  for (int j = 0; j < model->n; j++) {
    joint[j] = turn[j] % 2 == 0;
    count += joint[j];
  }
  return count;
}
