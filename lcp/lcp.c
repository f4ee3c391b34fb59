/*
 * lcp.c: checks a linear complementarity problem, certifies its answers, and checks the two proofs
 * that Lemke's method can end with.
 *
 *   y = M z + q,   y >= 0,  z >= 0,  y^T z = 0                    [Chabrand 1998] (40)
 *   F_i = min( s_i z_i, y_i ),  s_i = |M_ii|              F = 0 if and only if z is a solution
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "contact/exact.h"
#include "lcp_internal.h"

dls_status dlsi_check_lcp(const dls_lcp *lcp, dls_error *error) {
  if (!lcp) return dlsi_is_null(error, "lcp");
  const int n = lcp->n;
  if (n < 1 || n > INT_MAX / 4) return dlsi_fail(error, DLS_E_SIZE, "n", -1, n, "is %d", n);
  if (lcp->Ms.p && lcp->M.a)
    return dlsi_fail(error, DLS_E_ARGUMENT, "Ms", -1, 0, "is given beside M");
  const dls_status status = lcp->Ms.p ? dlsi_check_sparse("Ms", &lcp->Ms, n, n, error)
                                      : dlsi_check_dense("M", &lcp->M, n, n, error);
  if (status) return status;
  return dlsi_check_vector("q", lcp->q, (size_t)n, error);
}

dls_status dlsi_check_dense_lcp(const dls_lcp *lcp, dls_error *error) {
  if (lcp && lcp->Ms.p)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "Ms", -1, 0,
                     "is for dls_principal_solve; a dense M is wanted");
  return dlsi_check_lcp(lcp, error);
}

dls_status dlsi_check_lcp_solve(int most, const dls_lcp *lcp, const double *z, int warm_start,
                                dls_error *error) {
  if (lcp->n > most)
    return dlsi_fail(error, DLS_E_SIZE, "n", -1, lcp->n, "is more than the workspace's %d", most);
  if (!z) return dlsi_is_null(error, "z");
  return warm_start ? dlsi_check_vector("z", z, (size_t)lcp->n, error) : DLS_OK;
}

dls_status dlsi_check_positive(const char *argument, const double *x, int n, dls_error *error) {
  dls_status status = dlsi_check_vector(argument, x, (size_t)n, error);
  for (int i = 0; !status && i < n; i++)
    if (!(x[i] > 0))
      status = dlsi_fail(error, DLS_E_ARGUMENT, argument, i, x[i], "must be positive");
  return status;
}

dls_status dls_lcp_check(const dls_lcp *lcp, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, dlsi_check_lcp(lcp, error), error);
}

/* ---- the certificate ------------------------------------------------------------------------- */

/* Adds Ms z to y and |Ms||z| to a. */
static void lcp_add_sparse(const dls_sparse *Ms, const double *z, double *y, double *a) {
  for (int j = 0; j < Ms->cols; j++)
    for (int k = Ms->p[j]; z[j] != 0 && k < Ms->p[j + 1]; k++) {
      const double p = Ms->x[k] * z[j];
      y[Ms->i[k]] += p;
      a[Ms->i[k]] += fabs(p);
    }
}

void dlsi_lcp_multiply(const dls_lcp *lcp, const double *q, const double *z, double *y, double *a) {
  const size_t n = (size_t)lcp->n, ld = (size_t)lcp->M.ld;
  for (size_t i = 0; i < n; i++) {
    y[i] = q ? q[i] : 0;
    a[i] = 0;
  }
  if (lcp->Ms.p) {
    lcp_add_sparse(&lcp->Ms, z, y, a);
    return;
  }
  for (size_t j = 0; j < n; j++) {
    const double *m = lcp->M.a + j * ld, zj = z[j];
    if (zj == 0) continue; /* M is finite */
    for (size_t i = 0; i < n; i++) {
      const double p = m[i] * zj;
      y[i] += p;
      a[i] += fabs(p);
    }
  }
}

double dlsi_lcp_diagonal(const dls_lcp *lcp, size_t j) {
  if (!lcp->Ms.p) return lcp->M.a[j + j * (size_t)lcp->M.ld];
  double sum = 0;
  for (int k = lcp->Ms.p[j]; k < lcp->Ms.p[j + 1]; k++)
    if ((size_t)lcp->Ms.i[k] == j) sum += lcp->Ms.x[k];
  return sum;
}

void dlsi_lcp_weights(const dls_lcp *lcp, double *s) {
  const size_t n = (size_t)lcp->n, ld = (size_t)lcp->M.ld;
  size_t zeros = 0;
  for (size_t i = 0; i < n; i++) {
    s[i] = fabs(dlsi_lcp_diagonal(lcp, i));
    zeros += s[i] == 0;
  }
  if (zeros == 0) return;
  /* s_i <= 0: minus the largest entry so far of a row with M_ii = 0 */
  for (int j = 0; lcp->Ms.p && j < lcp->n; j++)
    for (int k = lcp->Ms.p[j]; k < lcp->Ms.p[j + 1]; k++) {
      double *si = &s[lcp->Ms.i[k]];
      if (*si <= 0 && fabs(lcp->Ms.x[k]) > -*si) *si = -fabs(lcp->Ms.x[k]);
    }
  for (size_t j = 0; !lcp->Ms.p && j < n; j++)
    for (size_t i = 0; i < n; i++)
      if (s[i] <= 0 && fabs(lcp->M.a[i + j * ld]) > -s[i]) s[i] = -fabs(lcp->M.a[i + j * ld]);
  for (size_t i = 0; i < n; i++)
    s[i] = s[i] < 0 ? -s[i] : s[i] > 0 ? s[i] : 1;
}

/* m := max(m, x), keeping NaN. */
static void lcp_raise(double *m, double x) {
  if (x > *m || x != x) *m = x;
}

/* Returns the smaller of a and b; NaN if either is. */
static double lcp_least(double a, double b) {
  return a != a || a < b ? a : b;
}

void dlsi_lcp_measure(const dls_lcp *lcp, const double *z, const double *y, const double *a,
                      const double *s, dls_lcp_certificate *certificate) {
  const size_t n = (size_t)lcp->n;
  dls_lcp_certificate c = {0};
  const double az = dlsi_norm2(a, n), q = dlsi_norm2(lcp->q, n), scale = q > 0 ? q : az;
  double largest = -1, FF = 0, unit = 1;
  for (size_t i = 0; i < n; i++) {
    const double F = fabs(lcp_least(s[i] * z[i], y[i]));
    if (F > largest || F != F) {
      largest = F;
      c.worst = (int)i;
    }
    FF += F * F;
    lcp_raise(&c.negative_z, -z[i]);
    lcp_raise(&c.negative_y, -y[i]);
    lcp_raise(&c.complementarity, fabs(y[i] * z[i]));
  }
  if (largest > 0 && !dlsi_is_plain(FF)) { /* |F| without overflow or underflow */
    unit = largest;
    FF = 0;
    for (size_t i = 0; i < n; i++) {
      const double F = lcp_least(s[i] * z[i], y[i]) / unit;
      FF += F * F;
    }
  }
  /* beside a norm that overflows, every F is small: that certifies nothing */
  c.residual = largest == 0 ? 0 : scale <= DBL_MAX ? unit * sqrt(FF) / scale : INFINITY;
  c.floor = az == 0 ? 0 : DBL_EPSILON * (az / scale);
  *certificate = c;
}

static dls_status lcp_certify(const dls_lcp *lcp, const double *z, double *y,
                              dls_lcp_certificate *certificate, dls_error *error) {
  dls_status status = dlsi_check_lcp(lcp, error);
  if (!status) status = dlsi_check_vector("z", z, (size_t)lcp->n, error);
  if (status) return status;
  if (!certificate) return dlsi_is_null(error, "certificate");
  const size_t n = (size_t)lcp->n;
  double *work = dlsi_alloc(3 * n, sizeof *work);
  if (!work) return dlsi_no_memory(error);
  double *v = work, *a = work + n, *s = work + 2 * n;
  dlsi_lcp_multiply(lcp, lcp->q, z, v, a);
  dlsi_lcp_weights(lcp, s);
  dlsi_lcp_measure(lcp, z, v, a, s, certificate);
  if (y) memcpy(y, v, n * sizeof *y);
  free(work);
  return DLS_OK;
}

dls_status dls_lcp_certify(const dls_lcp *lcp, const double *z, double *y,
                           dls_lcp_certificate *certificate, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, lcp_certify(lcp, z, y, certificate, error), error);
}

int dls_lcp_certificate_holds(const dls_lcp_certificate *certificate, double tol) {
  DLSI_DOOR;
  if (!certificate) return 0;
  const double four = 4 * certificate->floor, coarsest = tol > 1e-8 ? tol : 1e-8;
  return certificate->residual <= (four > tol ? four : tol) && four <= coarsest;
}

/* ---- the ray --------------------------------------------------------------------------------- */

/* y += d z0, a := max(a + |d z0|, |s z|); then v := s z / a, y := y / a, 0 where a is 0. */
static void ray_relative(size_t n, const double *d, double z0, const double *s, const double *z,
                         double *y, double *a, double *v) {
  for (size_t i = 0; i < n; i++) {
    y[i] += d[i] * z0;
    a[i] += fabs(d[i] * z0);
    lcp_raise(&a[i], fabs(s[i] * z[i]));
    v[i] = a[i] == 0 ? 0 : s[i] * z[i] / a[i];
    y[i] = a[i] == 0 ? 0 : y[i] / a[i];
  }
}

double dlsi_lcp_ray_violation(const dls_lcp *lcp, const double *cover, const double *z, double z0,
                              const double *dz, double dz0, double *work) {
  const size_t n = (size_t)lcp->n;
  double *a = work, *s = work + n, *y = work + 2 * n, *dy = work + 3 * n, *v = work + 4 * n,
         *dv = work + 5 * n;
  if (!(z0 > 0) || !(dz0 >= 0) || !(dlsi_max_abs(dz, n) > 0)) return INFINITY;
  dlsi_lcp_weights(lcp, s);
  dlsi_lcp_multiply(lcp, lcp->q, z, y, a);
  for (size_t i = 0; i < n; i++)
    a[i] += fabs(lcp->q[i]);
  ray_relative(n, cover, z0, s, z, y, a, v);
  dlsi_lcp_multiply(lcp, NULL, dz, dy, a);
  ray_relative(n, cover, dz0, s, dz, dy, a, dv);
  double violation = 0;
  for (size_t i = 0; i < n; i++) {
    lcp_raise(&violation, -v[i]);
    lcp_raise(&violation, -y[i]);
    lcp_raise(&violation, -dv[i]);
    lcp_raise(&violation, -dy[i]);
    lcp_raise(&violation, lcp_least(v[i] > dv[i] ? v[i] : dv[i], y[i] > dy[i] ? y[i] : dy[i]));
    if (violation != violation) return violation;
  }
  return violation;
}

static dls_status ray_check(const dls_lcp *lcp, const double *cover, const double *z, double z0,
                            const double *dz, double dz0, double *violation, dls_error *error) {
  dls_status status = dlsi_check_dense_lcp(lcp, error);
  if (status) return status;
  const size_t n = (size_t)lcp->n;
  status = dlsi_check_positive("cover", cover, lcp->n, error);
  if (!status) status = dlsi_check_vector("z", z, n, error);
  if (!status) status = dlsi_check_vector("z0", &z0, 1, error);
  if (!status) status = dlsi_check_vector("dz", dz, n, error);
  if (!status) status = dlsi_check_vector("dz0", &dz0, 1, error);
  if (status) return status;
  if (!violation) return dlsi_is_null(error, "violation");
  double *work = dlsi_alloc(6 * n, sizeof *work);
  if (!work) return dlsi_no_memory(error);
  *violation = dlsi_lcp_ray_violation(lcp, cover, z, z0, dz, dz0, work);
  free(work);
  return DLS_OK;
}

dls_status dls_lcp_check_ray(const dls_lcp *lcp, const double *cover, const double *z, double z0,
                             const double *dz, double dz0, double *violation, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, ray_check(lcp, cover, z, z0, dz, dz0, violation, error), error);
}

/* ---- Farkas ---------------------------------------------------------------------------------- */

double dlsi_lcp_farkas_violation(const dls_lcp *lcp, const double *v) {
  const size_t n = (size_t)lcp->n, ld = (size_t)lcp->M.ld;
  double qv = 0, aqv = 0, worst = 0;
  for (size_t i = 0; i < n; i++) {
    if (!(v[i] >= 0)) return INFINITY;
    qv += lcp->q[i] * v[i];
    aqv += fabs(lcp->q[i]) * v[i];
  }
  if (!(qv < 0)) return INFINITY;
  for (size_t j = 0; j < n; j++) {
    const double *m = lcp->M.a + j * ld;
    double p = 0, a = 0;
    for (size_t i = 0; i < n; i++) {
      p += m[i] * v[i];
      a += fabs(m[i] * v[i]);
    }
    lcp_raise(&worst, a == 0 ? 0 : p / a);
    if (worst != worst) return worst;
  }
  return worst / (-qv / aqv);
}

static int farkas_holds(const void *problem, const double *v) {
  const dls_lcp *lcp = problem;
  dlsi_exact sum;
  dlsi_exact_clear(&sum);
  for (int i = 0; i < lcp->n; i++) {
    if (!(v[i] >= 0 && isfinite(v[i]))) return 0;
    dlsi_exact_add(&sum, lcp->q[i], v[i], 1);
  }
  if (dlsi_exact_sign(&sum) >= 0) return 0;
  for (int j = 0; j < lcp->n; j++) {
    const double *m = dlsi_lcp_column(lcp, j);
    dlsi_exact_clear(&sum);
    for (int i = 0; i < lcp->n; i++)
      dlsi_exact_add(&sum, m[i], v[i], 1);
    if (dlsi_exact_sign(&sum) > 0) return 0;
  }
  return 1;
}

int dlsi_lcp_find_proof(const dls_lcp *lcp, double *v, double *work) {
  return dlsi_find_exact((size_t)lcp->n, v, work, farkas_holds, lcp);
}

dls_status dls_lcp_check_farkas(const dls_lcp *lcp, const double *v, double *violation,
                                dls_error *error) {
  DLSI_DOOR;
  dls_status status = dlsi_check_dense_lcp(lcp, error);
  if (!status) status = dlsi_check_vector("v", v, (size_t)lcp->n, error);
  if (!status && !violation) status = dlsi_is_null(error, "violation");
  if (!status) *violation = dlsi_lcp_farkas_violation(lcp, v);
  return dlsi_at(__func__, status, error);
}
