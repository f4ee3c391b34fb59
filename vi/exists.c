/*
 * exists.c: two conditions that prove that a contact problem has a solution, and one under which a
 * failed method proves nothing.
 *
 *   (XS1)  the symmetric part of W is positive definite
 *   (XS2)  some W x has (W x)_n > mu |(W x)_t| at every contact: velocities that open all of them,
 *          with a margin, are possible
 *
 * For W with a positive semidefinite symmetric part each of them guarantees a solution: the cones
 * have no direction delta != 0 with W delta = 0, along which reactions could run away (Klarbring
 * and Pang, SIAM J. Optim. 8, 1998, 414-442, for W positive definite; Acary, Cadoux, Lemarechal and
 * Malick, Z. Angew. Math. Mech. 91, 2011, 155-175, for the second).
 *
 * (XS2) solves W x = e, e = 1 in every normal row and 0 in the others, by conjugate gradients. Only
 * the W x that results counts, so that neither symmetry nor convergence is needed.
 *
 *   (XS3)  If the symmetric part has a negative eigenvalue there is no theory, and methods fail on
 *          problems with solutions: their failure proves nothing.
 *
 * Rounding makes some singular W look definite: that can suppress a verdict, not falsify it.
 *
 * Cost: two L D L^T factorisations, up to 2 m products with W.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "vi_internal.h"

/* Shift of W, relative to its weights, that makes a semidefinite W definite despite rounding. */
static const double rounding = 1e-10;

/* Returns 1 if the symmetric part of W + shift diag(w) has pivots > 0 in L D L^T. Without square
 * roots powers of two change no bit, and a singular W of small integers gives an exact 0. J:
 * scratch, m x m. */
static int has_pivots(const dls_contact *problem, const double *w, double shift, double *J) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  memset(J, 0, m * m * sizeof *J);
  for (size_t j = 0; j < m; j++) {
    double e[3] = {0};
    e[j % d] = 1;
    dlsi_contact_add_columns(problem, (int)(j / d), e, J + j * m);
  }
  for (size_t j = 0; j < m; j++) {
    for (size_t i = j; i < m; i++)
      J[i + j * m] = J[i + j * m] / 2 + J[j + i * m] / 2;
    J[j + j * m] += shift * w[j / d];
  }
  for (size_t k = 0; k < m; k++) {
    const double *pivot = J + k * (m + 1);
    if (!(*pivot > 0 && *pivot <= DBL_MAX)) return 0;
    for (size_t j = k + 1; j < m; j++) {
      const double l = J[j + k * m] / *pivot;
      for (size_t i = j; i < m; i++)
        J[i + j * m] -= l * J[i + k * m];
    }
  }
  return 1;
}

static double dot(size_t m, const double *x, const double *y) {
  double sum = 0;
  for (size_t i = 0; i < m; i++)
    sum += x[i] * y[i];
  return sum;
}

/* Returns 1 if v = W x opens every contact by more than rounding. */
static int keeps_apart(const dls_contact *problem, const double *v) {
  const int d = problem->d;
  for (int c = 0; c < problem->nc; c++, v += d)
    if (!(v[0] > 1e-6 + problem->mu[c] * dlsi_tangent_norm(d, v))) return 0;
  return 1;
}

/* (XS2) */
static int can_keep_apart(const dls_contact *problem, const double *w, double *const v[4]) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  double *Wx = v[0], *residual = v[1], *p = v[2], *Wp = v[3];
  memset(Wx, 0, m * sizeof *Wx);
  for (size_t i = 0; i < m; i++) {
    residual[i] = i % d == 0;
    p[i] = residual[i] / w[i / d];
  }
  double rho = dot(m, residual, p);
  for (size_t k = 0; k < 2 * m; k++) {
    dlsi_contact_apply(problem, p, Wp);
    const double curvature = dot(m, p, Wp);
    if (!(curvature > 0 && curvature <= DBL_MAX)) return 0;
    const double step = rho / curvature;
    for (size_t i = 0; i < m; i++) {
      Wx[i] += step * Wp[i];
      residual[i] -= step * Wp[i];
      Wp[i] = residual[i] / w[i / d];
    }
    if (keeps_apart(problem, Wx)) return 1;
    const double next = dot(m, residual, Wp);
    for (size_t i = 0; i < m; i++)
      p[i] = Wp[i] + next / rho * p[i];
    rho = next;
  }
  return 0;
}

int dlsi_solution_exists(const dls_contact *problem, const double *w, double *J,
                         double *const v[4]) {
  return has_pivots(problem, w, 0, J) || can_keep_apart(problem, w, v);
}

int dlsi_is_semidefinite(const dls_contact *problem, const double *w, double *J) {
  return has_pivots(problem, w, rounding, J);
}
