/*
 * momentum.c: momentum on a fixed-point iteration x := g(x), here sweeps of Gauss-Seidel.
 *
 *   r_k  the start of sweep k, r' = g(r_k) its end;  e = r_k - r',  G = sum_c w_c |e_c|^2
 *
 *   (MO1)  k := k + 1,  b = (k - 1) / (k + 10)
 *   (MO2)  k := 0, b := 0 if sum_c w_c e_c . p_c > 0 (the last step was uphill) or G > 2 G*
 *   (MO3)  G* := G if G < G* or b = 0
 *   (MO4)  r_k+1 = r' + b p,  u_k+1 = u' + b p_u;   p := r_k+1 - r_k,  p_u := u_k+1 - u_k
 *
 * u = W r + q is affine in r, so (MO4) costs no product with W. r_k+1 may lie outside the cones,
 * which the next sweep allows.
 *
 * Source: Nesterov 1983 with the restart of O'Donoghue and Candes 2015. Deviations: + 10 for + 2 in
 * (MO1), and the second rule of (MO2). On packings of rigid bodies friction makes the sweep a map
 * that is no gradient, and larger extrapolations cycle.
 *
 * Cost of a step: 10 m operations. What can fail: if the sweep has complex eigenvalues of modulus
 * near 1, a b near 1 makes them larger than 1; the caller then bounds b.
 */
#include <math.h>
#include <string.h>

#include "vi/vi_internal.h"

static const double momentum_growth = 2;    /* (MO2) */
static const double momentum_slowness = 10; /* (MO1) */

void dlsi_momentum_carve(dlsi_momentum *mo, dlsi_arena *arena, size_t m) {
  double **const vectors[] = {&mo->r, &mo->u, &mo->p, &mo->pu};
  dlsi_take_vectors(arena, m, 4, vectors);
}

/* v[at] := from[at] (0 where from is NULL) for d entries each of the contacts of a set. */
static void momentum_copy(size_t d, dlsi_set set, const double *from, double *v) {
  if (!set.list && from) memcpy(v, from, d * (size_t)set.count * sizeof *v);
  if (!set.list && !from) memset(v, 0, d * (size_t)set.count * sizeof *v);
  for (int k = 0; set.list && k < set.count; k++)
    for (size_t i = 0, at = d * (size_t)set.list[k]; i < d; i++)
      v[at + i] = from ? from[at + i] : 0;
}

void dlsi_momentum_start(dlsi_momentum *mo, int d, int e, dlsi_set changes, dlsi_set rows,
                         const double *r, const double *u) {
  mo->k = 0;
  mo->reference = INFINITY;
  momentum_copy((size_t)d, changes, r, mo->r);
  momentum_copy((size_t)d, changes, NULL, mo->p);
  momentum_copy((size_t)e, rows, u, mo->u);
  momentum_copy((size_t)e, rows, NULL, mo->pu);
}

/* One step, by pieces of its two sets. */
typedef struct momentum_step {
  const dlsi_momentum *mo;
  size_t d, e;
  const double *w;
  dlsi_set changes, rows;
  double *r, *u;
  double b;
  int pieces, row_pieces;
  double G[dlsi_most_pieces], uphill[dlsi_most_pieces];
} momentum_step;

static void momentum_measure(void *data, int piece) {
  momentum_step *s = data;
  const int end = dlsi_piece(s->changes.count, s->pieces, piece + 1);
  const size_t d = s->d;
  double G = 0, uphill = 0;
  for (int k = dlsi_piece(s->changes.count, s->pieces, piece); k < end; k++) {
    const size_t c = s->changes.list ? (size_t)s->changes.list[k] : (size_t)k;
    double ee = 0, ep = 0;
    for (size_t i = d * c; i < d * (c + 1); i++) {
      const double e = s->mo->r[i] - s->r[i];
      ee += e * e;
      ep += e * s->mo->p[i];
    }
    G += s->w[c] * ee;
    uphill += s->w[c] * ep;
  }
  s->G[piece] = G;
  s->uphill[piece] = uphill;
}

/* (MO4) for one vector, entries first .. end-1 of the set: v := v + b p, p := v - old, old := v. */
static void momentum_extrapolate(size_t d, dlsi_set set, int first, int end, double b, double *p,
                                 double *old, double *v) {
  if (!set.list) {
    for (size_t i = d * (size_t)first; i < d * (size_t)end; i++) {
      v[i] += b * p[i];
      p[i] = v[i] - old[i];
      old[i] = v[i];
    }
    return;
  }
  for (int k = first; k < end; k++)
    for (size_t j = 0, i = d * (size_t)set.list[k]; j < d; j++, i++) {
      v[i] += b * p[i];
      p[i] = v[i] - old[i];
      old[i] = v[i];
    }
}

/* (MO4) for a piece of r or, after those, of u. */
static void momentum_push(void *data, int piece) {
  momentum_step *s = data;
  const int of_u = piece >= s->pieces, k = of_u ? piece - s->pieces : piece;
  const int pieces = of_u ? s->row_pieces : s->pieces;
  const dlsi_set set = of_u ? s->rows : s->changes;
  momentum_extrapolate(of_u ? s->e : s->d, set, dlsi_piece(set.count, pieces, k),
                       dlsi_piece(set.count, pieces, k + 1), s->b, of_u ? s->mo->pu : s->mo->p,
                       of_u ? s->mo->u : s->mo->r, of_u ? s->u : s->r);
}

double dlsi_momentum_step(dlsi_momentum *mo, int d, int e, const double *w, double largest,
                          dlsi_set changes, dlsi_set rows, double *r, double *u) {
  momentum_step s = {.mo = mo,
                     .d = (size_t)d,
                     .e = (size_t)e,
                     .w = w,
                     .changes = changes,
                     .rows = rows,
                     .r = r,
                     .u = u,
                     .pieces = dlsi_pieces(changes.count),
                     .row_pieces = dlsi_pieces(rows.count)};
  double G = 0, uphill = 0;
  dlsi_parallel(mo->team, s.pieces, momentum_measure, &s);
  for (int k = 0; k < s.pieces; k++) {
    G += s.G[k];
    uphill += s.uphill[k];
  }
  mo->k++;
  s.b = fmin((mo->k - 1) / (mo->k + momentum_slowness), largest);
  if (uphill > 0 || G > momentum_growth * mo->reference) mo->k = 0, s.b = 0;
  if (G < mo->reference || s.b == 0) mo->reference = G;
  dlsi_parallel(mo->team, s.pieces + s.row_pieces, momentum_push, &s);
  return G;
}
