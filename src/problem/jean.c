/*
 * jean.c: computes what [Jean 1988] prints beside the solution: its sweeps up to its own stopping
 * rule, and the weighted reactions equivalent to concentrated ones.
 *
 * (JE1)  r_t := the projection of r_t - u_t / W_tt on [-mu r_n, mu r_n]
 * (JE2)  r_n := max(0, r_n - u_n / W_nn),   u = W r + q of the newest r in both
 * (JE3)  stop when a sweep changes no reaction by more than 1e-4 of the largest
 *
 * The paper names Gauss-Seidel, (3.3)5-6, and 1e-4, and prints the counts of sweeps IS. The rest
 * follows from its tables. Concentrated: (JE1) of all candidates, then (JE2) of all. Weighted:
 * (JE1) and (JE2) of one candidate after the other. These give the printed counts and the printed
 * digits of the reactions; with (JE2) before (JE1), with the exact solution of each candidate, from
 * the last candidate to the first, or in the 2-norm no way gives both counts of its kind.
 */
#include <math.h>

#include "problem.h"

static const double printed_accuracy = 1e-4;

/* Does (JE1) or (JE2) of a candidate; returns the change of its reaction. */
static double jean_visit(const dls_contact *p, int c, int normal, double *r) {
  const int m = 2 * p->nc, i = 2 * c + !normal;
  const double *W = p->W.a + i;
  const size_t ld = (size_t)p->W.ld;
  double u = p->q[i];
  for (int j = 0; j < m; j++)
    u += W[(size_t)j * ld] * r[j];
  const double bound = p->mu[c] * r[2 * c], old = r[i], x = old - u / W[(size_t)i * ld];
  r[i] = normal ? fmax(0, x) : fmax(-bound, fmin(bound, x));
  return fabs(r[i] - old);
}

/* Does one sweep; returns the largest change. */
static double jean_sweep(const dls_contact *p, int weighted, double *r) {
  double change = 0;
  for (int k = 0; k < 2 * p->nc; k++) {
    const int c = weighted ? k / 2 : k % p->nc, normal = weighted ? k % 2 : k / p->nc;
    const double moved = jean_visit(p, c, normal, r);
    if (!(moved <= change)) change = moved; /* keeps a NaN */
  }
  return change;
}

int jean_sweeps(const dls_contact *p, int weighted, int most, double *r) {
  const int m = 2 * p->nc;
  for (int i = 0; i < m; i++)
    r[i] = 0;
  for (int k = 1; k <= most; k++) {
    const double change = jean_sweep(p, weighted, r), largest = largest_entry(r, m);
    if (change <= printed_accuracy * largest) return k; /* (JE3) */
    const dls_progress now = {
        .method = "jean", .stage = "jean", .iteration = k, .max_iterations = most, .residual = -1};
    if (show_progress(NULL, &now)) return -1 - k;
  }
  return -1 - most;
}

/* Returns P(i,j). */
static double jean_weight(const dls_sparse *P, int i, int j) {
  double sum = 0;
  for (int k = P->p[j]; k < P->p[j + 1]; k++)
    sum += P->i[k] == i ? P->x[k] : 0;
  return sum;
}

/* Eliminates without exchanges of rows: each column of P has more on the diagonal than beside it.
 */
void jean_unweight(const dls_sparse *P, const double *r, int i, double *work, double *w) {
  const int n = P->cols;
  for (int c = 0; c < n; c++) {
    const double below = c ? jean_weight(P, c, c - 1) / work[c - 1] : 0;
    work[c] = jean_weight(P, c, c) - (c ? below * jean_weight(P, c - 1, c) : 0);
    w[c] = r[2 * c + i] - (c ? below * w[c - 1] : 0);
  }
  for (int c = n - 1; c >= 0; c--)
    w[c] = (w[c] - (c + 1 < n ? jean_weight(P, c, c + 1) * w[c + 1] : 0)) / work[c];
}
