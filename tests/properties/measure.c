/*
 * measure.c: the certificate of docs/certificate.md in long double, from its formulas and not from
 * the library.
 *
 *   D_c = diag(w_n, w_t, ..),  v = D r - u,  R = mu (w_t/w_n) max(0, v_n),  u = W r + q
 *   F_n = w_n r_n - max(0, v_n),  F_t = D r_t - P(v_t), P on the disc of radius R, 0 where v_n <= 0
 *   positions  |F| / |q|,   forces  |D^-1 F| / |r|,  at most 1
 *
 * w_n = W_nn, w_t = trace(W_tt) / (d-1); if one is not positive, the mean of the positive ones of
 * its kind; if its kind has none, that of the other kind; else the largest entry of the diagonal
 * blocks, else 1. |q| and |r| are those of the contacts that touch, v_n > 0.
 *
 * The floors are eps |e| / |q| and eps |D^-1 e| / |r|, e the size of what rounds in F of a contact
 * that touches, with a = |W||r| + |q| by entries:
 *
 *   stick, bonded  e = a
 *   slip           e_n = a_n,  e_t = w_t |r_t| + mu (w_t/w_n) (a_n + w_n r_n), and in 3D the turn
 *                  of the slip, w_t |r_t| |a_t| / |w_t r_t - u_t|
 *   stick that would slip with another rounding, 4 eps of (a_n + w_n r_n)
 *                  e_n = a_n,  e_t = a_t + mu (w_t/w_n) (a_n + w_n r_n)
 */
#include <float.h>
#include <math.h>

#include "problem.h"

/* Completes the entries that are not positive of every second weight; 0: none is positive. */
static int complete_kind(const problem *p, long double *w) {
  long double sum = 0;
  int positive = 0;
  for (int c = 0; c < p->nc; c++)
    if (w[2 * c] > 0) sum += w[2 * c], positive++;
  for (int c = 0; c < p->nc; c++)
    if (positive && !(w[2 * c] > 0)) w[2 * c] = sum / positive;
  return positive;
}

void measure_weights(const problem *p, long double *w) {
  long double largest = 0;
  for (int c = 0; c < p->nc; c++) {
    const double *W = p->W + (size_t)(p->d * c) * (size_t)(p->m + 1);
    w[2 * c] = W[0];
    w[2 * c + 1] = p->d == 1 ? W[0] : 0;
    for (int k = 1; k < p->d; k++)
      w[2 * c + 1] += (long double)W[k * (p->m + 1)] / (p->d - 1);
    for (int e = 0; e < p->d * p->d; e++)
      largest = fmaxl(largest, fabsl((long double)W[e % p->d + e / p->d * p->m]));
  }
  if (!(largest > 0)) largest = 1;
  const int normals = complete_kind(p, w), tangents = complete_kind(p, w + 1);
  for (int c = 0; c < p->nc; c++) {
    if (!normals) w[2 * c] = tangents ? w[2 * c + 1] : largest;
    if (!tangents) w[2 * c + 1] = w[2 * c];
  }
}

static long double tangent(int d, const long double *x) {
  return d == 1 ? 0 : d == 2 ? fabsl(x[1]) : hypotl(x[1], x[2]);
}

int measure_branch(const problem *p, int c, const long double *weights, const long double *r,
                   const long double *u, long double *F) {
  const int d = p->d;
  const long double *w = weights + 2 * c;
  long double v[3] = {0}, P[3] = {0};
  for (int k = 0; k < d; k++)
    v[k] = w[k > 0] * r[k] - u[k];
  const long double R = isinf(p->mu[c]) ? INFINITY : d == 1 ? 0 : p->mu[c] * (w[1] / w[0]) * v[0];
  const long double t = tangent(d, v);
  const int branch = v[0] < 0 || (isinf(p->mu[c]) && v[0] == 0) ? 0 : t <= R ? 1 : 2;
  for (int k = 0; branch && k < d; k++)
    P[k] = k == 0 || branch == 1 ? v[k] : R * (v[k] / t);
  for (int k = 0; F && k < d; k++)
    F[k] = w[k > 0] * r[k] - P[k];
  return branch;
}

void measure_rounding(const problem *p, int c, int branch, const long double *weights,
                      const long double *r, const long double *u, const long double *a,
                      long double *e) {
  const int d = p->d;
  const long double *w = weights + 2 * c;
  long double push[3] = {0}, v[3] = {0};
  for (int k = 0; k < d; k++) {
    push[k] = w[k > 0] * fabsl(r[k]);
    v[k] = w[k > 0] * r[k] - u[k];
    e[k] = branch ? a[k] : 0;
  }
  if (d == 1 || branch == 0 || isinf(p->mu[c])) return;
  const long double per_n = p->mu[c] * (w[1] / w[0]), radius = per_n * (a[0] + push[0]);
  const long double at = tangent(d, a), drag = tangent(d, push), t = tangent(d, v);
  const long double turn = branch == 2 && d == 3 && at > 0 ? drag * (at / t) : 0;
  const int sticks = branch == 1 && !(t > per_n * v[0] - 4 * DBL_EPSILON * radius);
  for (int k = 1; !sticks && k < d; k++)
    e[k] = (branch == 1 ? a[k] : push[k]) + radius + turn;
}

/* seen (d) := e, or what rounds where double precision may see slip for stick, or stick for slip,
 * if that is more. */
static void measure_seen(const problem *p, int c, int branch, const long double *weights,
                         const long double *r, const long double *u, const long double *a,
                         const long double *e, long double *seen) {
  const int d = p->d;
  const long double *w = weights + 2 * c;
  long double v[3] = {0}, other[3] = {0}, size = 0;
  for (int k = 0; k < d; k++) {
    v[k] = w[k > 0] * r[k] - u[k];
    seen[k] = e[k];
    size += k ? a[k] + w[1] * fabsl(r[k]) : 0;
  }
  if (d == 1 || branch == 0 || isinf(p->mu[c])) return;
  const long double per_n = p->mu[c] * (w[1] / w[0]);
  size += per_n * (a[0] + w[0] * fabsl(r[0]));
  if (fabsl(tangent(d, v) - per_n * v[0]) > 4 * DBL_EPSILON * size) return;
  measure_rounding(p, c, 3 - branch, weights, r, u, a, other);
  for (int k = 0; k < d; k++)
    seen[k] = fmaxl(e[k], other[k]);
}

typedef struct sums {
  long double F, forces, e, e_forces, seen, seen_forces, q, r, W;
} sums;

/* u := W r + q, a := |W||r|; m each */
static void multiply(const problem *p, const double *r, long double *u, long double *a) {
  const size_t m = (size_t)p->m;
  for (size_t i = 0; i < m; i++) {
    u[i] = p->q[i];
    a[i] = 0;
  }
  for (size_t j = 0; j < m; j++)
    for (size_t i = 0; r[j] != 0 && i < m; i++) {
      const long double t = (long double)p->W[i + j * m] * r[j];
      u[i] += t;
      a[i] += fabsl(t);
    }
}

void measure_answer(const problem *p, const double *r, measure *out) {
  const int d = p->d;
  static long double w[2 * NC_MAX], u[M_MAX], a[M_MAX];
  sums s = {0};
  measure_weights(p, w);
  multiply(p, r, u, a);
  for (int c = 0; c < p->nc; c++) {
    const int o = d * c;
    long double rc[3] = {0}, F[3] = {0}, e[3] = {0}, all[3] = {0}, seen[3];
    for (int k = 0; k < d; k++) {
      rc[k] = r[o + k];
      all[k] = a[o + k] + fabsl((long double)p->q[o + k]);
    }
    const int branch = measure_branch(p, c, w, rc, u + o, F);
    measure_rounding(p, c, branch, w, rc, u + o, all, e);
    measure_seen(p, c, branch, w, rc, u + o, all, e, seen);
    for (int k = 0; k < d; k++) {
      const long double own = w[2 * c + (k > 0)];
      s.F += F[k] * F[k];
      s.forces += F[k] / own * (F[k] / own);
      if (!branch) continue;
      s.e += e[k] * e[k];
      s.e_forces += e[k] / own * (e[k] / own);
      s.seen += seen[k] * seen[k];
      s.seen_forces += seen[k] / own * (seen[k] / own);
      s.q += (long double)p->q[o + k] * p->q[o + k];
      s.r += rc[k] * rc[k];
      s.W += a[o + k] * a[o + k];
    }
  }
  const long double size = s.q > 0 ? s.q : s.W, forces = s.forces > s.r ? s.forces : s.r;
  /* nothing touches, though r is not 0: 1 */
  out->u = (double)(s.F == 0 ? 0 : size > 0 ? sqrtl(s.F / size) : 1);
  out->r = (double)(s.forces == 0 ? 0 : sqrtl(s.forces / forces));
  out->floor_u = (double)(s.e == 0 ? 0 : DBL_EPSILON * sqrtl(s.e / size));
  out->floor_r = (double)(s.e_forces == 0 ? 0 : DBL_EPSILON * sqrtl(s.e_forces / forces));
  out->seen_u = (double)(s.seen == 0 ? 0 : DBL_EPSILON * sqrtl(s.seen / size));
  out->seen_r = (double)(s.seen_forces == 0 ? 0 : DBL_EPSILON * sqrtl(s.seen_forces / forces));
}

int measure_holds(const measure *a, double tol, double slack, double most, int forces) {
  const double cap = tol > most ? tol : most;
  const double bar_u = 4 * a->floor_u > tol ? 4 * a->floor_u : tol;
  const double bar_r = 4 * a->floor_r > tol ? 4 * a->floor_r : tol;
  return a->u <= slack * bar_u && 4 * a->seen_u <= slack * cap &&
         (!forces || (a->r <= slack * bar_r && 4 * a->seen_r <= slack * cap));
}
