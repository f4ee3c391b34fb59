/*
 * equilibrium.c: the part of the certificate for balance of forces and for joints.
 *
 *   (EB1)  e = K x - f - H r,   a = |K||x| + |f| + |H||r|
 *   (EB2)  of a connected body     |e| / s,   s = |H||r| + min(|f|, 100 |H||r|), but at least 1e-12
 *          of the largest s; s = |f| + |H||r| if no contact touches the body; the load of before
 *          the split (body->balanced) where f' and |H||r| are below 1e-12 of it. |H||r| is at
 *          most the norm of |K||x| + |f| of all bodies: reactions that cancel where nothing deforms
 *          measure nothing
 *   (EB3)  of a body held by joints, its own rows: the same with s = |f| + |H||r| + |G l|, but at
 *          least 1e-4 of the largest s of the bodies that joints connect to it. G l: of joints, at
 *          most what |H||r| is; both are left out of that bound
 *   (EB4)  of the joints of these bodies   |G^T x - b| / s_l,   s_l = | |G|^T y + |b| |
 *          y_j = max(|x_j|, (|f| + |H||r| + |G l|)_j / K_jj): a displacement, or an indentation
 *   (EB5)  floor_e: eps |a| / s, in (EB3) with the largest |a| of these bodies; eps in (EB4)
 *
 * Loads of more than 100 |H||r| balance in themselves for the most part, and measure no reaction:
 * (EB2) with all of |f| is `loose`. If only that holds, the body's own deformation has to be split
 * off (linear/own.h).
 *
 * A body without any load contains the rounding of others: hence the 1e-12. A joint's row is a
 * length: forces do not measure it. A light body is not hidden by the heavy one that a joint
 * connects to it, but takes over its rounding: hence the 1e-4. Multipliers of redundant joints add
 * up to 0 in G l, and enter no scale. (EB4) is relative to indentations, too, if nothing moves. If
 * the numerator is larger, it replaces the denominator: the part is at most 1.
 *
 * Cost: a product with K; with joints two more passes. Cannot fail.
 */
#include <string.h>

#include "body.h"

static const double least_load = 1e-12; /* (EB2) */
static const double least_share = 1e-4; /* (EB3) */
static const double most_load = 100;    /* (EB2) */

/* e, a, f, |H||r|, G l of a row; e, 0, s_l, 0, 0 of a joint; without joints, 1 in place of G l
 * where a contact touches the unknown */
enum { kinds = 5 };

/* Returns the number of groups of rows that are measured separately. */
static size_t forces_groups(const dlsi_body *body) {
  return (size_t)body->parts + (body->joint ? (size_t)body->pieces : 0);
}

size_t dlsi_forces_scratch(const dlsi_body *body) {
  return (body->joint ? 5 : 3) * (size_t)body->n + (size_t)(2 * kinds) * forces_groups(body) + 1;
}

dlsi_forces dlsi_forces_in(const dlsi_body *body, double *work) {
  const size_t n = (size_t)body->n;
  return (dlsi_forces){.e = work,
                       .ae = work + n,
                       .Hr = work + 2 * n,
                       .pull = work + 3 * n,
                       .reach = work + 4 * n,
                       .sums = work + (body->joint ? 5 : 3) * n,
                       .most = work + dlsi_forces_scratch(body) - 1};
}

/* Sets *m to max(*m, x), keeping NaN. */
static void forces_raise(double *m, double x) {
  if (x > *m || x != x) *m = x;
}

/* Calls for each entry K_ij of a row i and an unknown j, one of which is a multiplier. */
typedef void (*couple_fn)(const dlsi_body *body, const double *x, const dlsi_forces *of, int i,
                          int j, double v);

static void forces_couple(const dlsi_body *body, const double *x, const dlsi_forces *of,
                          couple_fn couple) {
  const int symmetric = body->model->factorization != DLS_LU;
  for (int j = 0; j < body->n; j++) {
    double v;
    for (int at = 0, i; dlsi_body_entry(body->model, j, &at, &i, &v);) {
      couple(body, x, of, i, j, v);
      if (symmetric && i != j) couple(body, x, of, j, i, v);
    }
  }
}

/* Hr -= |G||l|, 0 in rows of joints. */
static void couple_off(const dlsi_body *body, const double *x, const dlsi_forces *of, int i, int j,
                       double v) {
  of->Hr[i] = body->joint[i] ? 0 : body->joint[j] ? of->Hr[i] - fabs(v * x[j]) : of->Hr[i];
}

/* (EB1) */
void dlsi_forces_sum(const dlsi_body *body, const double *f, const double *r, const double *x,
                     const dlsi_forces *of) {
  const dls_sparse *Ht = &body->Ht;
  if (body->multiply)
    body->multiply(body->data, x, of->e, of->ae);
  else
    dlsi_body_multiply(body->model, x, of->e, of->ae);
  for (int j = 0; j < body->n; j++) {
    of->ae[j] += f ? fabs(f[j]) : 0;
    of->Hr[j] = of->ae[j];
  }
  if (body->joint) forces_couple(body, x, of, couple_off);
  *of->most = dlsi_joined_norm(body->ranks, of->Hr, (size_t)body->n);
  r = dlsi_body_fetch(body, r);
  for (int j = 0; j < body->n; j++) {
    double sum = 0, size = 0; /* reactions that cancel press all the same */
    for (int k = Ht->p[j]; k < Ht->p[j + 1]; k++) {
      sum += Ht->x[k] * r[Ht->i[k]];
      size += fabs(Ht->x[k] * r[Ht->i[k]]);
    }
    of->Hr[j] = size;
    of->e[j] -= (f ? f[j] : 0) + sum;
    of->ae[j] += size;
  }
}

/* pull += G l, reach := diagonal. */
static void couple_forces(const dlsi_body *body, const double *x, const dlsi_forces *of, int i,
                          int j, double v) {
  if (!body->joint[i] && body->joint[j]) of->pull[i] += v * x[j];
  if (i == j && !body->joint[i]) of->reach[i] += v;
}

/* reach += |G|^T y in rows of joints. */
static void couple_lengths(const dlsi_body *body, const double *x, const dlsi_forces *of, int i,
                           int j, double v) {
  (void)x;
  if (body->joint[i] && !body->joint[j]) of->reach[i] += fabs(v) * of->reach[j];
}

/* Sets pull and, in rows of joints, reach := s_l of (EB4). */
static void forces_of_joints(const dlsi_body *body, const double *f, const double *x,
                             const dlsi_forces *of) {
  memset(of->pull, 0, 2 * (size_t)body->n * sizeof *of->pull);
  forces_couple(body, x, of, couple_forces);
  for (int j = 0; j < body->n; j++) {
    const double load = f ? fabs(f[j]) : 0;
    if (body->joint[j]) {
      of->reach[j] = load;
      continue;
    }
    const double stiffness = of->reach[j];
    of->reach[j] = fabs(x[j]);
    if (stiffness > 0)
      forces_raise(&of->reach[j],
                   (load + fmin(fabs(of->Hr[j]), *of->most) + fmin(fabs(of->pull[j]), *of->most)) /
                       stiffness);
  }
  forces_couple(body, x, of, couple_lengths);
}

/* The measures of a group of rows. load: with all of |f|; held: s of (EB2). */
typedef struct group {
  double e, a, load, held;
} group;

/* Sums up norms of all groups in of->sums: pieces first, then the joints of each part. */
static void forces_collect(const dlsi_body *body, const double *f, const dlsi_forces *of) {
  const size_t first = body->joint ? (size_t)body->pieces : 0, groups = forces_groups(body);
  double *most = of->sums, *sum = of->sums + kinds * groups;
  memset(of->sums, 0, 2 * kinds * groups * sizeof *of->sums);
  for (int pass = 0; pass < 2; pass++) {
    for (int j = 0; j < body->n; j++) {
      const int joint = body->joint && body->joint[j];
      const size_t part = (size_t)body->part[j];
      const size_t g = kinds * (joint || !body->joint ? first + part : (size_t)body->piece[j]);
      const double row[kinds] = {of->e[j], of->ae[j], f ? f[j] : 0, of->Hr[j],
                                 body->joint ? of->pull[j] : body->Ht.p[j] < body->Ht.p[j + 1]};
      const double length[kinds] = {of->e[j], 0, joint ? of->reach[j] : 0, 0, 0};
      const double *v = joint ? length : row;
      for (size_t k = 0; k < kinds; k++) {
        if (!pass)
          forces_raise(&most[g + k], fabs(v[k]));
        else if (most[g + k] > 0)
          sum[g + k] += (v[k] / most[g + k]) * (v[k] / most[g + k]);
      }
    }
    dlsi_join(body->ranks, pass ? DLSI_SUM : DLSI_MOST, pass ? sum : most, kinds * groups);
  }
}

static group forces_group(const dlsi_body *body, const dlsi_forces *of, size_t g) {
  const double *most = of->sums + kinds * g, *sum = most + kinds * forces_groups(body);
  double norm[kinds];
  for (size_t k = 0; k < kinds; k++)
    norm[k] = most[k] > 0 ? most[k] * sqrt(sum[k]) : most[k];
  for (int k = 3; k < kinds && (k == 3 || body->joint); k++)
    if (norm[k] > *of->most) norm[k] = *of->most;
  if (body->joint)
    return (group){norm[0], norm[1], norm[2] + norm[3] + norm[4], norm[2] + norm[3] + norm[4]};
  const double load = norm[2] + norm[3], itself = body->balanced ? body->balanced[g] : 0;
  double held = norm[4] > 0 ? norm[3] + fmin(norm[2], most_load * norm[3]) : load;
  if (load <= least_load * itself) held = itself;
  return (group){norm[0], norm[1], load, held};
}

/* Returns the largest load of the groups `from` <= g < `end`. */
static double forces_largest(const dlsi_body *body, const dlsi_forces *of, size_t from,
                             size_t end) {
  double most = 0;
  for (size_t g = from; g < end; g++)
    forces_raise(&most, forces_group(body, of, g).load);
  return most;
}

/* Offers |e| over s, with the rounding level eps a / s. Returns 1 if it is the largest so far. */
static int forces_take(double e, double a, double load, dls_certificate *found) {
  const double s = load > e ? load : e, part = e / s;
  if (s == 0) return 0;
  forces_raise(&found->floor_e, DBL_EPSILON * (a / s));
  if (!(part > found->equilibrium || part != part)) return 0;
  found->equilibrium = part;
  return 1;
}

/* (EB2), with all of |f| if loose. */
static void forces_of_bodies(const dlsi_body *body, const dlsi_forces *of, int loose,
                             dls_certificate *found) {
  const size_t parts = (size_t)body->parts;
  double least = 0;
  for (size_t p = 0; p < parts; p++) {
    const group of_body = forces_group(body, of, p);
    forces_raise(&least, least_load * (loose ? of_body.load : of_body.held));
  }
  for (size_t p = 0; p < parts; p++) {
    const group of_body = forces_group(body, of, p);
    const double s = fmax(loose ? of_body.load : of_body.held, least);
    if (!forces_take(of_body.e, of_body.a, s, found)) continue;
    found->unbalanced = of_body.e;
    found->body = (int)p;
  }
}

int dlsi_forces_dwarf(const dlsi_body *body, double *work) {
  const dlsi_forces of = dlsi_forces_in(body, work);
  for (int p = 0; p < body->parts && !body->joint; p++) {
    const group g = forces_group(body, &of, (size_t)p);
    if (g.held < g.load) return 1;
  }
  return 0;
}

void dlsi_forces_loose(const dlsi_body *body, double *work, dls_certificate *found) {
  const dlsi_forces of = dlsi_forces_in(body, work);
  if (body->joint || !(body->model || body->multiply)) return;
  found->equilibrium = found->floor_e = 0;
  forces_of_bodies(body, &of, 1, found);
  found->residual = fmax(fmax(found->residual_u, found->residual_r), found->equilibrium);
}

/* (EB3), (EB4) First sets the largest load and a of each part, in place of the pieces' sums. */
static void forces_of_pieces(const dlsi_body *body, const dlsi_forces *of, dls_certificate *found) {
  const size_t pieces = (size_t)body->pieces;
  double *load = of->pull, *a = of->reach; /* by parts; both are spent */
  const double least = least_load * forces_largest(body, of, 0, pieces);
  const double shortest = least_load * forces_largest(body, of, pieces, forces_groups(body));
  for (int p = 0; p < body->parts; p++)
    load[p] = a[p] = 0;
  for (int j = 0; j < body->n; j++) {
    if (body->joint[j]) continue;
    const group g = forces_group(body, of, (size_t)body->piece[j]);
    forces_raise(&load[body->part[j]], g.load);
    forces_raise(&a[body->part[j]], g.a);
  }
  for (int j = 0, next = 0; j < body->n; j++) { /* pieces are numbered by their first unknown */
    if (body->joint[j] || body->piece[j] < next) continue;
    const int p = body->part[j];
    const group g = forces_group(body, of, (size_t)next++);
    const double s = fmax(g.load, fmax(least_share * load[p], least));
    if (!forces_take(g.e, a[p], s, found)) continue;
    found->unbalanced = g.e;
    found->body = p;
  }
  for (int p = 0; p < body->parts; p++) {
    const group g = forces_group(body, of, pieces + (size_t)p);
    if (!forces_take(g.e, g.load, fmax(g.load, shortest), found)) continue;
    found->unbalanced = 0;
    found->body = p;
  }
}

void dlsi_forces_measure(const dlsi_body *body, const double *f, const double *x,
                         const dlsi_forces *of, dls_certificate *found) {
  if (body->joint) forces_of_joints(body, f, x, of);
  forces_collect(body, f, of);
  found->body = -1;
  if (body->joint)
    forces_of_pieces(body, of, found);
  else
    forces_of_bodies(body, of, 0, found);
}
