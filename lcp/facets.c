/*
 * facets.c: the contact problem on a friction cone with facets, as an LCP.
 *
 *   r_t = sum_k beta_k e_k,   0 <= u_n                   _|_  r_n     >= 0
 *                             0 <= e_k.u_t + lambda      _|_  beta_k  >= 0     k = 0 .. facets-1
 *                             0 <= mu r_n - sum_k beta_k _|_  lambda  >= 0
 *
 * If sum beta < mu r_n, lambda = 0 and e_k.u_t >= 0 for every k: u_t = 0, as e_k and -e_k are both
 * there. If lambda > 0, only the e_k with the least e_k.u_t = -lambda push: friction opposes slip
 * as well as the polygon lets it (Stewart and Trinkle, reference in facets.h).
 *
 * With the columns c_0 = n, c_(k+1) = e_k of C, the rows of candidate a in the columns of b are
 * C^T W_ab C; besides, 1 in the column of lambda and (mu, -1 .. -1) in its row. So for z >= 0
 *
 *   z^T M z = r^T W r + sum_c mu_c r_nc lambda_c
 *
 * and M is copositive if W is positive semidefinite. No ray where W is positive definite: then
 * only z = (0, 0, lambda) solves LCP(M, 0), and it has q^T z = 0; that suffices (Cottle, Pang,
 * Stone, The Linear Complementarity Problem, 1992, theorem 4.4.12).
 *
 * Corners are on the circle (the polygon is inscribed): r stays in the round cone. Where W = w I
 * and slip goes through the middle of a facet, the certificate has
 *
 *   |F_c| = w mu r_n (1 - cos(pi / facets)) / sqrt(1 + mu^2),   1 - cos(pi / facets) ~ 5 / facets^2
 *
 * Scaling as in friction.c. The mu of a row belongs to that row's candidate.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "base/base.h"
#include "delassus/facets.h"

static int allowed(int d, int facets) {
  if (d == 2) return facets == 2;
  return d == 3 && facets >= 4 && facets <= DLS_FACETS_MAX && facets % 2 == 0;
}

static int rows_of(const dls_contact *problem, int facets, int c) {
  return problem->mu[c] > 0 ? facets + 2 : 1;
}

int dls_contact_facets_size(const dls_contact *problem, int facets) {
  if (!problem || !allowed(problem->d, facets) || !problem->mu) return 0;
  int n = 0;
  for (int c = 0; c < problem->nc; c++) {
    if (n > INT_MAX - facets - 2) return 0;
    n += rows_of(problem, facets, c);
  }
  return n;
}

/* C (d x (facets + 1), leading dimension 3): n, then the directions e_k; the second half is the
 * first one turned round. */
static void directions(int d, int facets, double C[][3]) {
  memset(C, 0, (size_t)(facets + 1) * sizeof *C);
  C[0][0] = 1;
  for (int k = 0; k < facets / 2; k++) {
    const double angle = 2 * acos(-1) * k / facets;
    C[1 + k][1] = cos(angle);
    C[1 + k][2] = d == 3 ? sin(angle) : 0;
    for (int i = 1; i < 3; i++)
      C[1 + k + facets / 2][i] = -C[1 + k][i];
  }
}

static dls_status check(const dls_contact *problem, int facets, const double *s, int *n,
                        dls_error *error) {
  dls_status status = dlsi_check_contact(problem, error);
  if (status) return status;
  if (!allowed(problem->d, facets))
    return dlsi_fail(error, DLS_E_ARGUMENT, "facets", -1, facets, "is %d, must be %s", facets,
                     problem->d == 2 ? "2 where d = 2" : "even, 4 to 64, where d = 3");
  *n = dls_contact_facets_size(problem, facets);
  if (*n < 1) return dlsi_fail(error, DLS_E_SIZE, "nc", -1, problem->nc, "is too large");
  if (!s) return DLS_OK;
  status = dlsi_check_vector("s", s, (size_t)problem->nc, error);
  for (int c = 0; !status && c < problem->nc; c++)
    if (!(s[c] > 0)) return dlsi_fail(error, DLS_E_ARGUMENT, "s", c, s[c], "must be positive");
  return status;
}

/* M += C^T (scale W) C, `rows` x `cols`; W is d x d with leading dimension ldw. */
static void add_block(int d, double scale, const double *W, size_t ldw, double C[][3], int rows,
                      int cols, double *M, size_t ldm) {
  for (int k = 0; k < cols; k++) {
    double g[3] = {0};
    for (int j = 0; j < d; j++)
      for (int i = 0; i < d; i++)
        g[i] += scale * W[(size_t)i + (size_t)j * ldw] * C[k][j];
    for (int i = 0; i < rows; i++)
      M[(size_t)i + (size_t)k * ldm] += C[i][0] * g[0] + C[i][1] * g[1] + C[i][2] * g[2];
  }
}

dls_status dls_contact_to_facets_lcp(const dls_contact *problem, int facets, const double *s,
                                     double *M, int ldm, double *q, dls_error *error) {
  int n = 0;
  const dls_status status = check(problem, facets, s, &n, error);
  if (status) return dlsi_at(__func__, status, error);
  if (!M) return dlsi_at(__func__, dlsi_is_null(error, "M"), error);
  if (ldm < n)
    return dlsi_at(__func__, dlsi_fail(error, DLS_E_SIZE, "ldm", -1, ldm, "must be at least %d", n),
                   error);
  if (!q) return dlsi_at(__func__, dlsi_is_null(error, "q"), error);

  const int d = problem->d, nc = problem->nc;
  const size_t L = (size_t)ldm, D = (size_t)d, ldw = (size_t)problem->W.ld;
  double C[DLS_FACETS_MAX + 1][3];
  directions(d, facets, C);
  for (size_t j = 0; j < (size_t)n; j++)
    memset(M + j * L, 0, (size_t)n * sizeof *M);
  double *first = q; /* first row of each candidate; q itself is filled last */
  for (int c = 0, i = 0; c < nc; i += rows_of(problem, facets, c), c++)
    first[c] = i;
  for (int b = 0; b < nc; b++) {
    const double sb = s ? s[b] : 1;
    const int cols = problem->mu[b] > 0 ? facets + 1 : 1;
    double *column = M + (size_t)first[b] * L;
    const int *p = problem->Wb.p;
    const int start = problem->Wb.x ? p[b] : 0, end = problem->Wb.x ? p[b + 1] : nc;
    for (int k = start; k < end; k++) {
      const int a = problem->Wb.x ? problem->Wb.i[k] : k;
      const double *W = problem->Wb.x ? problem->Wb.x + D * D * (size_t)k
                                      : problem->W.a + D * (size_t)a + D * (size_t)b * ldw;
      add_block(d, sb * (s ? s[a] : 1), W, problem->Wb.x ? D : ldw, C,
                problem->mu[a] > 0 ? facets + 1 : 1, cols, column + (size_t)first[a], L);
    }
    if (problem->mu[b] > 0) {
      double *own = column + (size_t)first[b];
      const size_t last = (size_t)facets + 1; /* of lambda */
      own[last] = problem->mu[b];
      for (size_t k = 1; k < last; k++) {
        own[last + k * L] = -1;
        own[k + last * L] = 1;
      }
    }
  }
  for (int c = 0, i = 0; c < nc; c++) {
    const double sc = s ? s[c] : 1, *qc = problem->q + D * (size_t)c;
    const int rows = rows_of(problem, facets, c);
    for (int k = 0; k < rows; k++, i++) {
      q[i] = 0;
      for (int j = 0; j < d && k <= facets; j++)
        q[i] += sc * qc[j] * C[k][j];
    }
  }
  return DLS_OK;
}

dls_status dls_contact_from_facets_lcp(const dls_contact *problem, int facets, const double *s,
                                       const double *z, double *r, dls_error *error) {
  int n = 0;
  dls_status status = check(problem, facets, s, &n, error);
  if (!status) status = dlsi_check_vector("z", z, (size_t)n, error);
  if (status) return dlsi_at(__func__, status, error);
  if (!r) return dlsi_at(__func__, dlsi_is_null(error, "r"), error);
  const int d = problem->d;
  double C[DLS_FACETS_MAX + 1][3];
  directions(d, facets, C);
  for (int c = 0; c < problem->nc; c++) {
    const int rows = rows_of(problem, facets, c), columns = rows > 1 ? facets + 1 : 1;
    double *rc = r + (size_t)d * (size_t)c;
    for (int i = 0; i < d; i++)
      rc[i] = 0;
    for (int k = 0; k < columns; k++)
      for (int i = 0; i < d; i++)
        rc[i] += (s ? s[c] : 1) * z[k] * C[k][i];
    z += rows;
  }
  return DLS_OK;
}
