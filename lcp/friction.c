/*
 * friction.c: the 2D contact problem as an LCP, [Chabrand 1998] (39) with the sign of (21).
 *
 *   phi_1 = mu r_n - r_t >= 0,   phi_2 = mu r_n + r_t >= 0,   u_t = lambda_1 - lambda_2
 *   lambda_m >= 0,  lambda_m phi_m = 0,   0 <= u_n _|_ r_n >= 0
 *
 * With r_t = phi_2 - mu r_n, z = (r_n, phi_2, lambda_2) and y = (u_n, lambda_1, phi_1):
 *
 *   u_n      = (W_nn - mu W_nt) r_n + W_nt phi_2            + q_n
 *   lambda_1 = (W_tn - mu W_tt) r_n + W_tt phi_2 + lambda_2 + q_t       (u_t + lambda_2)
 *   phi_1    =             2 mu r_n -      phi_2                        (2 mu r_n - (mu r_n + r_t))
 *
 * mu = 0 leaves r_t = 0 and the normal row alone. The mu of a column belongs to the candidate whose
 * reaction it multiplies. Scaling: r_c = s_c r'_c, u_c = u'_c / s_c, so W'_ab = s_a W_ab s_b,
 * q'_a = s_a q_a: the laws are homogeneous in r and in u, the LCP keeps its form.
 */
#include <limits.h>
#include <math.h>
#include <string.h>

#include "base/base.h"
#include "lcp_internal.h"

static int rows_of(const dls_contact *problem, int c) {
  return problem->mu[c] > 0 ? 3 : 1;
}

int dls_contact_lcp_size(const dls_contact *problem) {
  if (!problem || problem->d != 2 || !problem->mu) return 0;
  int n = 0;
  for (int c = 0; c < problem->nc; c++) {
    if (n > INT_MAX - 3) return 0;
    n += rows_of(problem, c);
  }
  return n;
}

static dls_status check(const dls_contact *problem, const double *s, int *n, dls_error *error) {
  dls_status status = dlsi_check_contact(problem, error);
  if (status) return status;
  if (problem->d != 2)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "d", -1, problem->d,
                     "is %d; only d = 2 has this form", problem->d);
  *n = dls_contact_lcp_size(problem);
  if (*n < 1) return dlsi_fail(error, DLS_E_SIZE, "nc", -1, problem->nc, "is too large");
  if (!s) return DLS_OK;
  status = dlsi_check_vector("s", s, (size_t)problem->nc, error);
  for (int c = 0; !status && c < problem->nc; c++)
    if (!(s[c] > 0)) return dlsi_fail(error, DLS_E_ARGUMENT, "s", c, s[c], "must be positive");
  return status;
}

/* Adds the block scale * w (column-major), w of row candidate a and column candidate b, at M. */
static void add_block(const dls_contact *problem, int a, int b, double scale, const double *w,
                      double *M, size_t ldm) {
  const double mu = problem->mu[b]; /* of the column */
  const double nn = scale * w[0], tn = scale * w[1], nt = scale * w[2], tt = scale * w[3];
  M[0] += nn - mu * nt;
  if (problem->mu[a] > 0) M[1] += tn - mu * tt;
  if (mu > 0) M[ldm] += nt;
  if (mu > 0 && problem->mu[a] > 0) M[1 + ldm] += tt;
}

dls_status dls_contact_to_lcp(const dls_contact *problem, const double *s, double *M, int ldm,
                              double *q, dls_error *error) {
  int n = 0;
  const dls_status status = check(problem, s, &n, error);
  if (status) return dlsi_at(__func__, status, error);
  if (!M) return dlsi_at(__func__, dlsi_is_null(error, "M"), error);
  if (ldm < n)
    return dlsi_at(__func__, dlsi_fail(error, DLS_E_SIZE, "ldm", -1, ldm, "must be at least %d", n),
                   error);
  if (!q) return dlsi_at(__func__, dlsi_is_null(error, "q"), error);

  const int nc = problem->nc;
  const size_t L = (size_t)ldm, ldw = (size_t)problem->W.ld;
  for (size_t j = 0; j < (size_t)n; j++)
    memset(M + j * L, 0, (size_t)n * sizeof *M);
  double *first = q; /* first row of each candidate; q itself is filled last */
  for (int c = 0, i = 0; c < nc; i += rows_of(problem, c), c++)
    first[c] = i;
  for (int b = 0; b < nc; b++) {
    const double sb = s ? s[b] : 1;
    double *column = M + (size_t)first[b] * L;
    if (problem->Wb.x)
      for (int k = problem->Wb.p[b]; k < problem->Wb.p[b + 1]; k++) {
        const int a = problem->Wb.i[k];
        add_block(problem, a, b, sb * (s ? s[a] : 1), problem->Wb.x + 4 * (size_t)k,
                  column + (size_t)first[a], L);
      }
    else
      for (int a = 0; a < nc; a++) {
        const double *w = problem->W.a + 2 * (size_t)a + 2 * (size_t)b * ldw;
        const double block[4] = {w[0], w[1], w[ldw], w[ldw + 1]};
        add_block(problem, a, b, sb * (s ? s[a] : 1), block, column + (size_t)first[a], L);
      }
    if (problem->mu[b] > 0) {
      double *own = column + (size_t)first[b];
      own[2] = 2 * problem->mu[b]; /* phi_1 = 2 mu r_n - phi_2 */
      own[2 + L] = -1;
      own[1 + 2 * L] = 1; /* lambda_1 = u_t + lambda_2 */
    }
  }
  for (int c = 0, i = 0; c < nc; i += rows_of(problem, c), c++) {
    const double sc = s ? s[c] : 1;
    q[i] = sc * problem->q[2 * c];
    if (problem->mu[c] > 0) {
      q[i + 1] = sc * problem->q[2 * c + 1];
      q[i + 2] = 0;
    }
  }
  return DLS_OK;
}

dls_status dls_contact_from_lcp(const dls_contact *problem, const double *s, const double *z,
                                double *r, dls_error *error) {
  int n = 0;
  dls_status status = check(problem, s, &n, error);
  if (!status) status = dlsi_check_vector("z", z, (size_t)n, error);
  if (status) return dlsi_at(__func__, status, error);
  if (!r) return dlsi_at(__func__, dlsi_is_null(error, "r"), error);
  for (int c = 0, i = 0; c < problem->nc; i += rows_of(problem, c), c++) {
    const double sc = s ? s[c] : 1, mu = problem->mu[c];
    r[2 * c] = sc * z[i];
    r[2 * c + 1] = mu > 0 ? sc * (z[i + 1] - mu * z[i]) : 0;
  }
  return DLS_OK;
}

/* The states of the candidates say which unknowns are positive: stick (r_n, phi_2), slip in +t
 * (r_n), slip in -t (r_n, phi_2, lambda_2), free none but lambda_2 where u_t < 0. */
void dlsi_friction_start(const dls_contact *problem, const double *w, const double *r,
                         const double *u, double *z) {
  for (int c = 0, i = 0; c < problem->nc; i += rows_of(problem, c), c++) {
    const double mu = problem->mu[c], *uc = u + 2 * (size_t)c;
    double F[2] = {0};
    const dls_contact_state state = dlsi_contact_residual(2, mu, w[c], r + 2 * (size_t)c, uc, F);
    z[i] = state != DLS_FREE;
    if (!(mu > 0)) continue;
    const int back = uc[1] < 0;
    z[i + 1] = state == DLS_STICK || (state == DLS_SLIP && back);
    z[i + 2] = state != DLS_STICK && back;
  }
}
