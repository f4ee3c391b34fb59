/*
 * ambiguous.c: counts contacts with several solutions for given reactions of all others.
 *
 *   u_c = W_cc s + p,   p = u_c - W_cc r_c,   s by the law of contact and friction of contact c
 *
 * Two tests. The first looks at W_cc and mu alone: below a bound of mu there is one s for every p.
 * Above the bound dlsi_local_count (local.c) counts the solutions for the given p.
 *
 * The whole problem may still have one solution, or several although no contact has two: see
 * unique.c. Cost: O(nc). What can fail: if rounding decides the first test, the count follows,
 * which omits double roots.
 */
#include <math.h>
#include <stddef.h>

#include "vi/vi_internal.h"

static const double unsymmetric = 1e-9; /* of the Schur complement: far below the 1 % margin */

/* Returns 1 if a contact with this W_cc (d x d) has one solution for every q: W_cc is symmetric up
 * to rounding and positive definite, and mu is below the bound (DG4) of src/facts/bound.c by a
 * margin above rounding. */
static int has_one_solution(int d, const double *W, double mu) {
  if (d == 1) return W[0] > 0;
  double a[2] = {W[d], d == 3 ? W[6] : 0}, x[2], most; /* W_nt; W_nt W_tt^-1; largest eigenvalue */
  double skew = fabs(W[1] - a[0]);
  if (d == 3) skew = fmax(skew, fmax(fabs(W[2] - a[1]), fabs(W[5] - W[7])));
  if (d == 2) {
    most = W[3];
    x[0] = a[0] / most;
    x[1] = 0;
  } else {
    const double det = W[4] * W[8] - W[7] * W[7], half = (W[4] + W[8]) / 2;
    if (!(det > 0 && half > 0)) return 0;
    most = half + hypot((W[4] - W[8]) / 2, W[7]);
    x[0] = (W[8] * a[0] - W[7] * a[1]) / det;
    x[1] = (W[4] * a[1] - W[7] * a[0]) / det;
  }
  const double s = W[0] - a[0] * x[0] - a[1] * x[1], h = hypot(x[0], x[1]);
  if (!(most > 0 && s > 0 && skew <= unsymmetric * s)) return 0;
  const double k = sqrt(s / most);
  return mu < 0.99 * (h < k ? h + k * (k / h) : 2 * k);
}

int dlsi_may_be_ambiguous(const dls_contact *problem) {
  double W[9];
  for (int c = 0; c < problem->nc; c++) {
    dlsi_contact_diagonal(problem, c, W);
    if (!has_one_solution(problem->d, W, problem->mu[c])) return 1;
  }
  return 0;
}

int dlsi_count_ambiguous(const dls_contact *problem, const double *r, const double *u,
                         double *other) {
  const int d = problem->d;
  int ambiguous = 0;
  for (int c = 0; c < problem->nc; c++) {
    const double *rc = r + (size_t)d * (size_t)c, *uc = u + (size_t)d * (size_t)c;
    double W[9], p[3], s[3];
    dlsi_contact_diagonal(problem, c, W);
    for (int i = 0; other && i < d; i++)
      other[d * c + i] = rc[i];
    if (has_one_solution(d, W, problem->mu[c])) continue;
    for (int i = 0; i < d; i++) {
      p[i] = uc[i];
      for (int j = 0; j < d; j++)
        p[i] -= W[i + d * j] * rc[j];
    }
    if (dlsi_local_count(d, W, p, problem->mu[c]) < 2) continue;
    if (dlsi_nlgs_local(d, W, p, problem->mu[c], s, NULL) == DLS_LOCAL_NONE) continue;
    ambiguous++;
    for (int i = 0; other && i < d; i++)
      other[d * c + i] = s[i];
  }
  return ambiguous;
}
