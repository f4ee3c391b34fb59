/*
 * unique.c: tests whether a contact problem has at most one answer, d = 1, 2, 3; any W.
 *
 * Let delta be the difference of two answers and v = W delta. By the normal law delta_n v_n <= 0.
 * The discs of r_t have radii mu r_n, which differ by mu |delta_n|, and -u_t is normal to them. So
 * for each contact
 *
 *   (UN1)  delta_c.v_c <= mu_c |delta_n| |v_t|
 *
 *   (UN2)  Without friction delta_n.W_nn delta_n <= 0: there is one answer if the symmetric part of
 *          W_nn is positive definite.
 *   (UN3)  With |v_t| <= sum_j |W_tc,j| |delta_j| in (UN1): there is one answer if, in rows and
 *          columns scaled by 1/sqrt(w_c), the symmetric part of N is diagonally dominant,
 *            N_cc = least eigenvalue of W_cc - mu_c |W_tc,c|,   N_cj = -(|W_cj| + mu_c |W_tc,j|).
 *
 * |.| of a block is Frobenius' norm. Source: (UN2) Cottle, Pang, Stone, The Linear Complementarity
 * Problem, 1992, 3.3; (UN1) and (UN3) from the law as above.
 * Cost: (UN3) a product with W at most; (UN2) n^3/3 for n contacts.
 * What can fail: (UN3) usually proves nothing if many contacts touch one body.
 */
#include <math.h>
#include <string.h>

#include "vi_internal.h"

/* Share of the diagonal that rounding may take. */
static const double rounding = 1e-10;

/* Returns the least eigenvalue of [a g; g b]. */
static double least_of_two(double a, double b, double g) {
  return (a + b) / 2 - hypot((a - b) / 2, g);
}

/* Returns a lower bound of the least eigenvalue of the symmetric part of W, d x d. */
static double least_eigenvalue(int d, const double *W) {
  if (d == 1) return W[0];
  if (d == 2) return least_of_two(W[0], W[3], (W[1] + W[2]) / 2);
  const double along = least_of_two(W[4], W[8], (W[5] + W[7]) / 2);
  return least_of_two(W[0], along, hypot(W[1] + W[3], W[2] + W[6]) / 2);
}

/* Sets *all and *tangents to the norm of a block, and of its rows of tangents, times `scale`: first
 * the unit, then the squares. */
static void measure_block(int d, const double *block, size_t ld, double scale, double *all,
                          double *tangents) {
  double x[9], t[6];
  size_t n = 0, k = 0;
  for (int j = 0; j < d; j++)
    for (int i = 0; i < d; i++) {
      x[n] = scale * block[(size_t)i + (size_t)j * ld];
      if (i) t[k++] = x[n];
      n++;
    }
  *all = dlsi_norm2(x, n);
  *tangents = dlsi_norm2(t, k);
}

/* Returns the geometric mean, to the same bits in any unit where the product is in range. */
static double mean_weight(double a, double b) {
  return dlsi_is_plain(a * b) ? sqrt(a * b) : sqrt(a) * sqrt(b);
}

/* (UN3). row: scratch, nc. Ends with the first row that is not dominant. */
static int is_dominant(const dls_contact *problem, const double *w, double *row) {
  const int d = problem->d;
  double all, tangents, own[9];
  for (int c = 0; c < problem->nc; c++) {
    dlsi_contact_diagonal(problem, c, own);
    measure_block(d, own, (size_t)d, 1 / w[c], &all, &tangents);
    row[c] = least_eigenvalue(d, own) / w[c] - problem->mu[c] * tangents;
    if (!(row[c] > rounding)) return 0;
  }
  for (int c = 0; c < problem->nc; c++) {
    const dlsi_block_column W = dlsi_contact_column(problem, (size_t)c);
    for (size_t k = W.begin; k < W.end; k++) {
      const size_t i = dlsi_row(&W, k);
      if (i == (size_t)c) continue;
      measure_block(d, W.x + k * W.step, W.ld, 1 / mean_weight(w[i], w[c]), &all, &tangents);
      if (all == 0) continue;
      const double half = (all + problem->mu[i] * tangents) / 2;
      row[i] -= half;
      row[c] -= half;
      if (!(row[i] > rounding && row[c] > rounding)) return 0;
    }
  }
  return 1;
}

/* (UN2). J: scratch, nc x nc. */
static int is_definite(const dls_contact *problem, const double *w, double *J) {
  const size_t n = (size_t)problem->nc;
  memset(J, 0, n * n * sizeof *J);
  for (size_t c = 0; c < n; c++) {
    const dlsi_block_column W = dlsi_contact_column(problem, c);
    for (size_t k = W.begin; k < W.end; k++) {
      const size_t i = dlsi_row(&W, k);
      const double half = W.x[k * W.step] / mean_weight(w[i], w[c]) / 2;
      J[i + c * n] += half;
      J[c + i * n] += half;
    }
  }
  for (size_t k = 0; k < n; k++) {
    const double pivot = J[k * (n + 1)];
    if (!(pivot > rounding)) return 0;
    for (size_t j = k + 1; j < n; j++) {
      const double l = J[j + k * n] / pivot;
      for (size_t i = j; i < n; i++)
        J[i + j * n] -= l * J[i + k * n];
    }
  }
  return 1;
}

int dlsi_is_unique(const dls_contact *problem, const double *w, double *row, double *J) {
  if (dlsi_is_factored(problem)) return 0;
  return is_dominant(problem, w, row) || (J && is_definite(problem, w, J));
}
