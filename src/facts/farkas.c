/*
 * farkas.c: proves early that a contact problem has no solution, by a linear problem that each
 * solution satisfies.
 *
 * A solution has r in the friction cones and u_n = (W r + q)_n >= 0. With the edges of the cones in
 * the columns of E, E_n = W_n E and r = E x, the smallest such r and its dual are
 *
 *   (FA1)  min sum_k w_k x_k,  x >= 0,  E_n x + q_n >= 0;   max -v.q_n,  v >= 0,  E_n' v <= w
 *
 * w_k: weight of the contact. They are the LCP in z = (v, x)
 *
 *   (FA2)  M = (0, E_n; -E_n', 0),  q = (q_n, w)
 *
 * M is skew. Therefore Lemke's method either solves the LCP or ends in a ray with E_n' v <= 0 and
 * v.q_n < 0: a Farkas vector, the proof of base/exact.h. For d = 2, E has the two edges of the
 * cone; for d = 3 the 8 edges of a polygonal cone around the round one, so that a proof also holds
 * for the round cone. The LCP uses the scaled unknowns of contact_lemke.c, where w = 1, and
 * multiplies w by the size of q_n.
 *
 * The dual v bounds the size of a solution from below; so does a v that is a Farkas vector up to
 * rounding. With g_c = sum_a v_a (row n of W_ac), every r has v.u_n = g.r + v.q_n, and e_c = max(0,
 * g_cn + mu |g_ct|) bounds g_c.r_c / r_cn in the cone. If the certificate of r holds, its floor is
 * at most C / 4, C = max(tol, 1e-8), and |F| <= C |q|. Hence |w r| <= R = C |q| / (4 eps), u_n >=
 * -sqrt(1 + mu^2) |F_c|, and r is in the cones up to |F_c / w_c|:
 *
 *   (FA3)  -v.q_n  >  |e / w| (R + C |q|) + C |q| (|v sqrt(1 + mu^2)| + |g / w| + (m + 2) |v| / 4)
 *
 * shows that no r can be certified; the last term is the rounding of u. Norms are over contacts.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "facts/facts.h"

enum { round_edges = 8 };
static const double circumscribed = 1.0823922002923943; /* 1 / cos(pi / 8), rounded up */

static int farkas_edges(const dls_contact *problem, int c) {
  return !(problem->mu[c] > 0) ? 1 : problem->d == 2 ? 2 : round_edges;
}

/* edge := edge k of the cone of contact c. */
static void farkas_edge(const dls_contact *problem, int c, int k, double edge[3]) {
  const double mu = problem->mu[c], a = 2 * 3.141592653589793 / round_edges * k;
  edge[0] = 1;
  edge[1] = problem->d == 2 ? (k ? -mu : mu) : mu * circumscribed * cos(a);
  edge[2] = mu * circumscribed * sin(a);
}

int dlsi_farkas_size(const dls_contact *problem) {
  int n = problem->nc;
  for (int c = 0; c < problem->nc; c++)
    n += farkas_edges(problem, c);
  return n;
}

void dlsi_farkas_lcp(const dls_contact *problem, const double *s, double unit, double *M, double *q,
                     double *column) {
  const size_t d = (size_t)problem->d, nc = (size_t)problem->nc, m = d * nc;
  const size_t n = (size_t)dlsi_farkas_size(problem);
  memset(M, 0, n * n * sizeof *M);
  memset(q, 0, n * sizeof *q);
  for (size_t a = 0; a < nc; a++)
    q[a] = s[a] * problem->q[d * a] / unit;
  const double size = dlsi_max_abs(q, nc);
  for (size_t j = nc; j < n; j++)
    q[j] = size;
  for (size_t b = 0, j = nc; b < nc; b++)
    for (int k = 0; k < farkas_edges(problem, (int)b); k++, j++) {
      double edge[3];
      farkas_edge(problem, (int)b, k, edge);
      memset(column, 0, m * sizeof *column);
      dlsi_contact_add_columns(problem, (int)b, edge, column);
      for (size_t a = 0; a < nc; a++) {
        M[a + j * n] = s[a] * column[d * a] * s[b] / unit;
        M[j + a * n] = -M[a + j * n];
      }
    }
}

/* Adds the square of x to *sum. */
static void farkas_add(double *sum, double x) {
  *sum += x * x;
}

int dlsi_farkas_excludes(const dls_contact *problem, const double *w, const double *v, double tol) {
  const int d = problem->d, nc = problem->nc, m = d * nc;
  const double C = fmax(tol, 1e-8), size = C * dlsi_norm2(problem->q, (size_t)m);
  double gain = 0, lost = 0, e2 = 0, g2 = 0, v2 = 0, vmu2 = 0;
  for (int c = 0; c < nc; c++) {
    const dlsi_block_column W = dlsi_contact_column(problem, (size_t)c);
    const double mu = problem->mu[c], vq = v[c] * problem->q[(size_t)d * (size_t)c];
    double g[3] = {0}, rounded = 0;
    for (size_t k = W.begin; k < W.end; k++) {
      const double *block = W.x + k * W.step, va = v[dlsi_row(&W, k)];
      for (int i = 0; i < d; i++) {
        g[i] += va * block[(size_t)i * W.ld];
        rounded += (i ? mu : 1) * fabs(va * block[(size_t)i * W.ld]);
      }
    }
    const double e = g[0] + mu * dlsi_tangent_norm(d, g) + (nc + 4) * DBL_EPSILON * rounded;
    farkas_add(&e2, fmax(e, 0) / w[c]);
    farkas_add(&g2, dlsi_norm2(g, 3) / w[c]);
    farkas_add(&v2, v[c]);
    farkas_add(&vmu2, v[c] * sqrt(1 + mu * mu));
    gain -= vq;
    lost += fabs(vq);
  }
  const double far = sqrt(e2) * (size / (4 * DBL_EPSILON) + size);
  const double near = size * (sqrt(vmu2) + sqrt(g2) + (m + 2) * sqrt(v2) / 4);
  return gain - (nc + 4) * DBL_EPSILON * lost > 1.001 * (far + near); /* 1.001: of these sums */
}
