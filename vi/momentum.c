/*
 * momentum.c: momentum on a fixed-point iteration x := g(x), here sweeps of Gauss-Seidel.
 *
 *   r_k  the start of sweep k, r' = g(r_k) its end;  e = r_k - r',  G = sum_c w_c |e_c|^2
 *
 *   (MO1)  k := k + 1,  b = (k - 1) / (k + 10)
 *   (MO2)  k := 0, b := 0 if sum_c w_c e_c . p_c > 0, the last step was uphill, or G > 2 G*
 *   (MO3)  G* := G if G < G* or b = 0
 *   (MO4)  r_k+1 = r' + b p,  u_k+1 = u' + b p_u;   p := r_k+1 - r_k,  p_u := u_k+1 - u_k
 *
 * u = W r + q is affine in r, so that (MO4) costs no product with W. r_k+1 may lie outside of the
 * cones; the sweep that follows does not mind.
 *
 * Source: Nesterov 1983 with the restart of O'Donoghue and Candes 2015. Deviation: + 10 in place of
 * + 2 in (MO1), and the second rule of (MO2): on packings of rigid bodies, whose friction makes the
 * sweep a map that is not the gradient of anything, larger extrapolations cycle.
 *
 * Cost of a step: 10 m operations. What can fail: where the sweep has eigenvalues of modulus near 1
 * that are not real, a b near 1 makes them larger than 1; the caller bounds b then.
 */
#include <math.h>
#include <string.h>

#include "vi_internal.h"

static const double momentum_growth = 2;    /* (MO2) */
static const double momentum_slowness = 10; /* (MO1) */

void dlsi_momentum_carve(dlsi_momentum *mo, dlsi_arena *arena, size_t m) {
  double **const vectors[] = {&mo->r, &mo->u, &mo->p, &mo->pu};
  dlsi_take_vectors(arena, m, 4, vectors);
}

/* v[at] := from[at] (0 where from is NULL) for d entries each of the candidates of a set. */
static void momentum_copy(size_t d, dlsi_set set, const double *from, double *v) {
  if (!set.list && from) memcpy(v, from, d * (size_t)set.count * sizeof *v);
  if (!set.list && !from) memset(v, 0, d * (size_t)set.count * sizeof *v);
  for (int k = 0; set.list && k < set.count; k++)
    for (size_t i = 0, at = d * (size_t)set.list[k]; i < d; i++)
      v[at + i] = from ? from[at + i] : 0;
}

void dlsi_momentum_start(dlsi_momentum *mo, int d, dlsi_set changes, dlsi_set rows, const double *r,
                         const double *u) {
  mo->k = 0;
  mo->reference = INFINITY;
  momentum_copy((size_t)d, changes, r, mo->r);
  momentum_copy((size_t)d, changes, NULL, mo->p);
  momentum_copy((size_t)d, rows, u, mo->u);
  momentum_copy((size_t)d, rows, NULL, mo->pu);
}

/* (MO4) for one vector: v := v + b p, p := v - old, old := v. */
static void momentum_extrapolate(size_t d, dlsi_set set, double b, double *p, double *old,
                                 double *v) {
  if (!set.list) {
    for (size_t i = 0; i < d * (size_t)set.count; i++) {
      v[i] += b * p[i];
      p[i] = v[i] - old[i];
      old[i] = v[i];
    }
    return;
  }
  for (int k = 0; k < set.count; k++)
    for (size_t j = 0, i = d * (size_t)set.list[k]; j < d; j++, i++) {
      v[i] += b * p[i];
      p[i] = v[i] - old[i];
      old[i] = v[i];
    }
}

double dlsi_momentum_step(dlsi_momentum *mo, int d, const double *w, double largest,
                          dlsi_set changes, dlsi_set rows, double *r, double *u) {
  const size_t D = (size_t)d;
  double G = 0, uphill = 0;
  for (int k = 0; k < changes.count; k++) {
    const size_t c = changes.list ? (size_t)changes.list[k] : (size_t)k;
    double ee = 0, ep = 0;
    for (size_t i = D * c; i < D * (c + 1); i++) {
      const double e = mo->r[i] - r[i];
      ee += e * e;
      ep += e * mo->p[i];
    }
    G += w[c] * ee;
    uphill += w[c] * ep;
  }
  mo->k++;
  double b = fmin((mo->k - 1) / (mo->k + momentum_slowness), largest);
  if (uphill > 0 || G > momentum_growth * mo->reference) mo->k = 0, b = 0;
  if (G < mo->reference || b == 0) mo->reference = G;
  momentum_extrapolate(D, changes, b, mo->p, mo->r, r);
  momentum_extrapolate(D, rows, b, mo->pu, mo->u, u);
  return G;
}
