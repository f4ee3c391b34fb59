/*
 * polish.c: Newton's method on the friction law, for an answer that is nearly right; d = 2 and 3.
 *
 * With w_c of the certificate and v = w_c r_c - u_c, u = W r + q, the law is F = 0,
 *
 *   F_c = w_c r_c - P(v),   P(v) = ( max(0, v_n),  v_t put on the disc of radius R )
 *                                  R = mu max(0, v_n)
 *
 * (Alart and Curnier, Comp. Meth. Appl. Mech. Eng. 92, 1991, 353-375). One step, D = diag(w_c I):
 *
 *   (N1)  P' per candidate:  free  v_n <= 0     0
 *                            stick |v_t| <= R   I
 *                            slip  otherwise    ( 1     0                )   t = v_t / |v_t|
 *                                               ( mu t  R/|v_t| (I - tt^T) )
 *   (N2)  J = D + P' (W - (1 - eps) D),   J dr = -F              that is F' for eps = 0
 *   (N3)  r += dr
 *
 * eps = 1e-6 keeps J regular where W is not, and leaves F alone: the steps shrink by about eps cond
 * instead of quadratically. If J is singular all the same, eps grows a hundredfold.
 * Stop: the certificate holds (its F is de Saxce's; both vanish together), or 30 steps, or 12 steps
 * that did not halve the residual. Full steps only, uphill ones too; the best r is kept.
 *
 * Cost of a step: an LU of m x m. What can fail: from far away the states may cycle.
 */
#include <math.h>
#include <string.h>

#include "blas.h"
#include "dlsi.h"

enum { most_steps = 30, patience = 12 };

/* v_c := P'_c v_c in place, P' given by its state; (N1) */
static void apply_slope(int d, double mu, const dlsi_slope *P, double *v) {
  if (P->state == DLS_STICK) return;
  const double n = P->state == DLS_SLIP ? v[0] : 0;
  double along = 0; /* t.v_t */
  for (int i = 1; i < d; i++)
    along += P->t[i - 1] * v[i];
  v[0] = n;
  for (int i = 1; i < d; i++)
    v[i] = mu * n * P->t[i - 1] + P->shrink * (v[i] - along * P->t[i - 1]);
}

/* The slope of P at one candidate; minus_F := -F_c */
static dlsi_slope slope_of(int d, double mu, double w, const double *r, const double *u,
                           double *minus_F) {
  double v[3] = {0};
  for (int i = 0; i < d; i++)
    v[i] = w * r[i] - u[i];
  const double R = v[0] > 0 ? mu * v[0] : 0, size = hypot(v[1], v[2]);
  dlsi_slope P = {.state = DLS_FREE};
  if (v[0] > 0 && size <= R && mu > 0)
    P.state = DLS_STICK;
  else if (v[0] > 0) {
    P.state = DLS_SLIP;
    if (size > 0) {
      P.t[0] = v[1] / size;
      P.t[1] = v[2] / size;
      P.shrink = R / size;
    }
  }
  minus_F[0] = v[0] > 0 ? -u[0] : -w * r[0];
  for (int i = 1; i < d; i++)
    minus_F[i] = P.state == DLS_STICK ? -u[i] : R * P.t[i - 1] - w * r[i];
  return P;
}

/* (N2) */
static void build_jacobian(const dls_contact *problem, const double *w, double eps,
                           const dlsi_slope *P, double *J) {
  const size_t d = (size_t)problem->d, nc = (size_t)problem->nc, m = d * nc;
  for (size_t b = 0; b < nc; b++)
    for (size_t j = 0; j < d; j++) {
      double *column = J + (d * b + j) * m;
      double unit[3] = {0};
      unit[j] = 1;
      memset(column, 0, m * sizeof *column);
      dlsi_contact_add_columns(problem, (int)b, unit, column);
      column[d * b + j] -= (1 - eps) * w[b];
      for (size_t a = 0; a < nc; a++)
        apply_slope((int)d, problem->mu[a], P + a, column + d * a);
      column[d * b + j] += w[b];
    }
}

static dls_certificate measure(const dls_contact *problem, const double *w,
                               const dlsi_polish_work *work, const double *r) {
  dls_certificate certificate;
  dlsi_contact_multiply(problem, r, work->u, work->a);
  dlsi_contact_measure(problem, r, work->u, work->a, w, work->x, &certificate);
  return certificate;
}

int dlsi_polish(const dls_contact *problem, double tol, const double *w,
                const dlsi_polish_work *work, double *r) {
  const size_t d = (size_t)problem->d, nc = (size_t)problem->nc, m = d * nc;
  const int order = (int)m, one = 1;
  double eps = 1e-6;
  dls_certificate now = measure(problem, w, work, r);
  double best = now.residual, halved = best;
  memcpy(work->best, r, m * sizeof *r);
  int k = 0;
  for (int last = 0; k < most_steps && k - last < patience && eps < 1; k++) {
    if (dls_certificate_holds(&now, tol)) break;
    for (size_t c = 0; c < nc; c++) /* (N1), x = -F */
      work->slope[c] =
          slope_of((int)d, problem->mu[c], w[c], r + d * c, work->u + d * c, work->x + d * c);
    int info;
    build_jacobian(problem, w, eps, work->slope, work->J); /* (N2) */
    dgetrf_(&order, &order, work->J, &order, work->pivot, &info);
    if (info) {
      eps *= 100;
      continue;
    }
    dgetrs_("N", &order, &one, work->J, &order, work->pivot, work->x, &order, &info, 1);
    for (size_t i = 0; i < m; i++) /* (N3) */
      r[i] += work->x[i];
    now = measure(problem, w, work, r);
    if (!isfinite(now.residual)) break;
    if (now.residual < best) {
      best = now.residual;
      memcpy(work->best, r, m * sizeof *r);
    }
    if (now.residual <= halved / 2) {
      halved = now.residual;
      last = k;
    }
  }
  memcpy(r, work->best, m * sizeof *r);
  return k;
}
