/*
 * delassus/lcp.h: the linear complementarity problem LCP(M, q), Lemke's method, and the 2D contact
 * problem as an LCP.
 *
 *     y = M z + q,   y >= 0,  z >= 0,  y^T z = 0                    [Chabrand 1998] (40)
 *
 * ([C] writes W for y.) M is n x n, of any kind: dense for all functions; in compressed columns for
 * dls_lcp_check, dls_lcp_certify and dls_principal_solve (pivoting.h).
 */
#ifndef DELASSUS_LCP_H
#define DELASSUS_LCP_H

#include "delassus/contact.h"
#include "delassus/limits.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A view; everything is borrowed. */
typedef struct dls_lcp {
  int n;
  dls_dense M;     /* n x n; M.a = NULL if Ms is given */
  const double *q; /* n */
  dls_sparse Ms;   /* n x n, in place of M; Ms.p = NULL for none */
} dls_lcp;

/* Checks sizes, pointers, indices and finite values. DLS_E_ARGUMENT (also for both M and Ms),
 * DLS_E_SIZE, DLS_E_NOT_FINITE. */
DLS_API DLS_MUST_USE dls_status dls_lcp_check(const dls_lcp *lcp, dls_error *error);

/* The certificate of z, with s_i = |M_ii|, or max_j |M_ij| where M_ii = 0 (of Ms the largest stored
 * entry), or 1 for a zero row:
 *
 *   F_i = min( s_i z_i, y_i ),   y = M z + q recomputed,   residual = |F|_2 / |q|_2
 *
 * floor = eps | |M||z| | / |q|. Where q = 0, | |M||z| | takes the place of |q|; z = 0 has
 * residual 0. */
typedef struct dls_lcp_certificate {
  double residual;
  double floor;
  double negative_z;      /* max(0, -z_i) */
  double negative_y;      /* max(0, -y_i) */
  double complementarity; /* max |y_i z_i| */
  int worst;              /* index of the largest |F_i| */
} dls_lcp_certificate;

/* Certifies z (n). y (n, or NULL) := M z + q. Allocates 3 n doubles. */
DLS_API DLS_MUST_USE dls_status dls_lcp_certify(const dls_lcp *lcp, const double *z, double *y,
                                                dls_lcp_certificate *certificate, dls_error *error);

/* Returns 1 if residual <= max(tol, 4 floor) and 4 floor <= max(tol, 1e-8), else 0; NaN gives 0.
 * (If z has grown without bound, rounding hides y, and nothing is certified.) */
DLS_API int dls_lcp_certificate_holds(const dls_lcp_certificate *certificate, double tol);

/* ---- Lemke ----------------------------------------------------------------------------------- */

/* Lemke's method follows y = M z + d z0 + q from large z0 down to z0 = 0, one pivot at a time, with
 * y_i = 0 or z_i = 0 for each i. d > 0 is the covering vector ([C] (42) has d = 1). The pivots are
 * lexicographic; therefore the method ends: at z0 = 0, which is a solution, or in a ray, which
 * decides nothing. */
typedef struct dls_lemke_settings {
  /* max_iterations: pivots, and rounds of `crash`; the method's own limit: 50 n + 1000. warm_start:
   * start from the basis of z as passed in (z_i is basic where z_i > 0, else y_i), for example the
   * last time step; if that fails, start cold. progress: called every 50 pivots and each round of
   * `crash` */
  dls_limits limits;
  size_t size; /* set by init; settings without it are refused */
  /* d, n of create, each > 0; copied. NULL, the default: the norms of the rows of M C, with column
   * factors C that (with row factors) bring the entries of M near 1. If this d ends in a ray
   * without a proof, up to nine more are tried: d times factors between 1/32 and 32 */
  const double *cover;
  /* 1, the default, and no cover: pivot many pairs at once first. A round costs at most a
   * factorisation of the basis, 2/3 (n/2)^3 flops if half of the z_i are basic. If that
   * ends at a solution, usually after 5 to 10 rounds, no path is followed. Otherwise it gives up,
   * usually after one to six rounds, at the latest after 14 log(2 n) + 4, and the path starts
   * without it. Of several solutions it may find another one than the path. 0, or with a `cover`:
   * the path alone */
  int crash;
} dls_lemke_settings;

/* Sets each field to its default. */
DLS_API void dls_lemke_settings_init(dls_lemke_settings *settings);

typedef struct dls_lemke_info {
  dls_status status;
  int pivots;                      /* of all starts together */
  dls_lcp_certificate certificate; /* of the z that is returned */
  int starts;       /* paths: 1, or more when an answer could not be certified, or 0 */
  int refreshes;    /* number of times that the table was recomputed from M */
  int crash_rounds; /* before the first path, see `crash`; not in pivots */
} dls_lemke_info;

typedef struct dls_lemke dls_lemke; /* workspace for n <= the n of create */

/* Creates a workspace: *out, NULL on error. The settings and the cover are copied. It holds
 * about n (n + 1) + 330 n doubles. DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_NOT_FINITE (cover),
 * DLS_E_SETTINGS, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_lemke_create(dls_lemke **out, int n,
                                                 const dls_lemke_settings *settings,
                                                 dls_error *error);

/* Solves the LCP. z (n): in, the start if warm_start, else ignored; out, z >= 0. y (n, or NULL) :=
 * M z + q, recomputed; neither may overlap the other or the problem. Allocates nothing.
 *   DLS_OK              z is a solution: dls_lcp_certificate_holds
 *   DLS_NO_SOLUTION     no z >= 0 has M z + q >= 0; dls_lemke_farkas gives the proof, which holds
 *                       exactly for the numbers of M and q
 *   DLS_RAY             the path ended in a ray, which dls_lemke_ray returns, right to 1e-14 (n +
 *                       10). A solution may or may not exist. Up to rounding there is none if M is
 *                       copositive-plus (for example positive semidefinite), or if dz is within
 *                       1e-14 (n + 10) of a proof by dls_lcp_check_farkas
 *   DLS_MAX_ITERATIONS, DLS_CANCELLED
 *   DLS_STALLED         rounding: an answer or a ray was reached that cannot be confirmed
 * or an error of dls_lcp_check; DLS_E_UNSUPPORTED for Ms. With a status > 0, z is the point found
 * with the smallest residual. */
DLS_API DLS_MUST_USE dls_status dls_lemke_solve(dls_lemke *workspace, const dls_lcp *lcp, double *z,
                                                double *y, dls_lemke_info *info, dls_error *error);

/* Returns the ray after DLS_RAY or DLS_NO_SOLUTION: z + t dz, z0 + t dz0, t >= 0, [C] (49), with
 * the largest dz_j = 1, and its covering vector. z, dz, cover: n of the last problem; each of them,
 * z0 and dz0 may be NULL. DLS_E_ARGUMENT after another status. */
DLS_API DLS_MUST_USE dls_status dls_lemke_ray(const dls_lemke *workspace, double *z, double *z0,
                                              double *dz, double *dz0, double *cover,
                                              dls_error *error);

/* Returns the proof after DLS_NO_SOLUTION: v (n) with v >= 0, M^T v <= 0, q^T v < 0 in exact
 * arithmetic, often of integers. DLS_E_ARGUMENT after another status. */
DLS_API DLS_MUST_USE dls_status dls_lemke_farkas(const dls_lemke *workspace, double *v,
                                                 dls_error *error);

/* Frees the object; NULL is fine. */
DLS_API void dls_lemke_destroy(dls_lemke *workspace);

/* ---- proofs, checked in O(n^2); DLS_E_UNSUPPORTED for Ms ------------------------------------- */

/* Measures in *violation how far (z, z0), (dz, dz0) is from a secondary ray of LCP(M, q) with the
 * covering vector `cover` (n, > 0). With y = M z + d z0 + q, dy = M dz + d dz0, a ray has
 *
 *   z, y, dz, dy >= 0,  dz0 >= 0,  z_i y_i = z_i dy_i = dz_i y_i = dz_i dy_i = 0,  z0 > 0,
 *   dz != 0.
 *
 * (With dz = 0 it would be the primary ray, which every problem has; with z0 = 0, z is a
 * solution.) With s_i of the certificate, y_i and s_i z_i are measured against max( s_i |z_i|,
 * (|M||z| + d z0 + |q|)_i ), dy_i and s_i dz_i against max( s_i |dz_i|, (|M||dz| + d dz0)_i ), a
 * product a b as min(a, b); the largest counts. 0 for a perfect ray, about 1e-15 for one in
 * double precision, infinite if z0 <= 0, dz0 < 0 or dz = 0. Allocates 6 n doubles. */
DLS_API DLS_MUST_USE dls_status dls_lcp_check_ray(const dls_lcp *lcp, const double *cover,
                                                  const double *z, double z0, const double *dz,
                                                  double dz0, double *violation, dls_error *error);

/* Measures in *violation how far v (n) is from a proof (Farkas) that no z >= 0 has M z + q >= 0:
 *
 *   v >= 0,  M^T v <= 0,  q^T v < 0;   then  v^T (M z + q) = (M^T v)^T z + q^T v < 0.
 *
 *   violation = max_j (M^T v)_j / (|M|^T v)_j  /  ( -q^T v / |q|^T v ),
 *
 * or 0 if that is negative; infinite if some v_j < 0 or q^T v >= 0. A z with M z + q >= 0 must then
 * have some z_j >= ( |q|^T v / n (|M|^T v)_j ) / violation. */
DLS_API DLS_MUST_USE dls_status dls_lcp_check_farkas(const dls_lcp *lcp, const double *v,
                                                     double *violation, dls_error *error);

/* ---- 2D contact as an LCP -------------------------------------------------------------------- */

/* Counts the rows of the LCP of a 2D contact problem: 3 for a contact with mu > 0, 1 for one with
 * mu = 0. Per contact, z = (r_n, phi_2, lambda_2), y = (u_n, lambda_1, phi_1), with
 *
 *   phi_1 = mu r_n - r_t,  phi_2 = mu r_n + r_t,  u_t = lambda_1 - lambda_2   [C] (39), (21)
 *
 * so that M_cc = ( W_nn - mu W_nt   W_nt   0 ;  W_tn - mu W_tt   W_tt   1 ;  2 mu   -1   0 ) and
 * q_c = (q_n, q_t, 0). A frictionless problem is LCP(W_nn, q_n). Returns 0 for NULL,
 * unless d is 1 or 2, and where the size does not fit an int. */
DLS_API int dls_contact_lcp_size(const dls_contact *problem);

/* Forms M (n x n, leading dimension ldm >= n) and q (n) of the LCP above, n = dls_contact_lcp_size,
 * in scaled unknowns r_c = s_c r'_c, u_c = u'_c / s_c; s (nc, each > 0) or NULL for none. s_c = 1 /
 * sqrt(w_c) makes the diagonal blocks of W of size 1. M and q must not overlap each other, s or the
 * problem; rows n .. ldm-1 of M are left alone. DLS_E_UNSUPPORTED for d = 3. */
DLS_API DLS_MUST_USE dls_status dls_contact_to_lcp(const dls_contact *problem, const double *s,
                                                   double *M, int ldm, double *q, dls_error *error);

/* Computes the reactions r (m) of z (n); s as above. */
DLS_API DLS_MUST_USE dls_status dls_contact_from_lcp(const dls_contact *problem, const double *s,
                                                     const double *z, double *r, dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
