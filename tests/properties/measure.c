/*
 * measure.c: the certificate of DESIGN.md in long double, written from its formulas and not from
 * the library.
 *
 *   F_c = w_c r_c - P( w_c r_c - (u_c + mu_c |u_tc| n) ),   u = W r + q
 *   positions  sqrt( sum |F_c|^2 ) / |q|,   forces  sqrt( sum |F_c / w_c|^2 ) / |r|,  at most 1
 *
 * P projects on the cone |r_t| <= mu r_n; w_c = trace(W_cc) / d; where that is not positive, the
 * mean of the positive ones, or the largest entry of the diagonal blocks where there is none.
 * Rounding a = |W||r| + |q| + w |r| by entries gives the floors eps |a| / |q|, eps |a / w| / |r|.
 */
#include <float.h>
#include <math.h>

#include "problem.h"

static void measure_weights(const problem *p, long double *w) {
  long double sum = 0, largest = 0;
  int positive = 0;
  for (int c = 0; c < p->nc; c++) {
    w[c] = 0;
    for (int k = 0; k < p->d; k++)
      w[c] += p->W[(p->d * c + k) * (p->m + 1)];
    for (int e = 0; e < p->d * p->d; e++)
      largest = fmaxl(largest, fabsl(p->W[p->d * c + e % p->d + (p->d * c + e / p->d) * p->m]));
    w[c] /= p->d;
    if (w[c] > 0) sum += w[c], positive++;
  }
  for (int c = 0; c < p->nc; c++)
    if (!(w[c] > 0)) w[c] = positive ? sum / positive : largest > 0 ? largest : 1;
}

/* F := w r - P(w r - (u + mu |u_t| n)) of one candidate; d entries each. */
static void measure_candidate(int d, long double w, double mu, const double *r,
                              const long double *u, long double *F) {
  long double x[3] = {0}, ut = 0, xt = 0;
  for (int k = 1; k < d; k++)
    ut = hypotl(ut, u[k]);
  for (int k = 0; k < d; k++)
    x[k] = w * r[k] - u[k] - (k == 0 ? mu * ut : 0);
  for (int k = 1; k < d; k++)
    xt = hypotl(xt, x[k]);
  long double normal = 1,
              tangent = 1; /* P(x) = (normal x_n, tangent x_t) or, on the edge, as below */
  if (x[0] < 0 || xt > mu * x[0]) {
    const long double edge = (x[0] + mu * xt) / (1 + (long double)mu * mu);
    if (edge > 0) {
      x[0] = edge;
      tangent = xt > 0 ? mu * edge / xt : 0;
    } else {
      normal = tangent = 0;
    }
  }
  F[0] = w * r[0] - normal * x[0];
  for (int k = 1; k < d; k++)
    F[k] = w * r[k] - tangent * x[k];
}

void measure_answer(const problem *p, const double *r, measure *out) {
  const int d = p->d, m = p->m;
  long double w[NC_MAX], u[M_MAX], a[M_MAX], F[3];
  long double FF = 0, GG = 0, aa = 0, bb = 0, qq = 0, rr = 0, WW = 0;
  measure_weights(p, w);
  for (int i = 0; i < m; i++) {
    u[i] = p->q[i];
    a[i] = 0;
    for (int j = 0; j < m; j++) {
      const long double t = (long double)p->W[i + j * m] * r[j];
      u[i] += t;
      a[i] += fabsl(t);
    }
    WW += a[i] * a[i];
    a[i] += fabsl((long double)p->q[i]) + w[i / d] * fabsl((long double)r[i]);
    qq += (long double)p->q[i] * p->q[i];
    rr += (long double)r[i] * r[i];
    aa += a[i] * a[i];
    bb += a[i] * a[i] / (w[i / d] * w[i / d]);
  }
  for (int c = 0; c < p->nc; c++) {
    measure_candidate(d, w[c], p->mu[c], r + d * c, u + d * c, F);
    for (int k = 0; k < d; k++) {
      FF += F[k] * F[k];
      GG += F[k] * F[k] / (w[c] * w[c]);
    }
  }
  const long double size = qq > 0 ? qq : WW;
  out->u = (double)(FF == 0 ? 0 : sqrtl(FF / size));
  const long double forces = GG > rr ? GG : rr; /* r = 0 is wrong by all of its forces: 1 */
  out->r = (double)(GG == 0 ? 0 : sqrtl(GG / forces));
  out->floor_u = (double)(aa == 0 ? 0 : DBL_EPSILON * sqrtl(aa / size));
  out->floor_r = (double)(forces == 0 ? 0 : DBL_EPSILON * sqrtl(bb / forces));
}

int measure_holds(const measure *a, double tol, double slack, int forces) {
  const double cap = tol > 1e-8 ? tol : 1e-8;
  const double bar_u = 4 * a->floor_u > tol ? 4 * a->floor_u : tol;
  const double bar_r = 4 * a->floor_r > tol ? 4 * a->floor_r : tol;
  return a->u <= slack * bar_u && 4 * a->floor_u <= slack * cap &&
         (!forces || a->r <= slack * bar_r);
}
