/*
 * delassus/lcp.h: the linear complementarity problem LCP(M, q), Lemke's method, and the 2D contact
 * problem as an LCP.
 *
 *     y = M z + q,   y >= 0,  z >= 0,  y^T z = 0                    [Chabrand 1998] (40)
 *
 * ([C] writes W for y.) M is n x n, dense, of any kind.
 */
#ifndef DELASSUS_LCP_H
#define DELASSUS_LCP_H

#include "delassus/info.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A view; everything is borrowed. */
typedef struct dls_lcp {
  int n;
  dls_dense M;     /* n x n */
  const double *q; /* n */
} dls_lcp;

/* Sizes, pointers, finite values. DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_NOT_FINITE. */
DLS_API DLS_MUST_USE dls_status dls_lcp_check(const dls_lcp *lcp, dls_error *error);

/* With s_i = |M_ii|, or max_j |M_ij| where M_ii = 0, or 1 for a zero row:
 *
 *   F_i = min( s_i z_i, y_i ),   y = M z + q recomputed,   residual = |F|_2 / |q|_2
 *
 * floor = eps | |M||z| | / |q|. Where q = 0, | |M||z| | takes the place of |q|; z = 0 has residual 0. */
typedef struct dls_lcp_certificate {
  double residual;
  double floor;
  double negative_z;      /* max(0, -z_i) */
  double negative_y;      /* max(0, -y_i) */
  double complementarity; /* max |y_i z_i| */
  int worst;              /* index of the largest |F_i| */
} dls_lcp_certificate;

/* y (n, or NULL) receives M z + q. Allocates 2 n doubles. */
DLS_API DLS_MUST_USE dls_status dls_lcp_certify(const dls_lcp *lcp, const double *z, double *y,
                                                dls_lcp_certificate *certificate, dls_error *error);

/* 1 if residual <= max(tol, 4 floor), else 0; NaN gives 0. */
DLS_API int dls_lcp_certificate_holds(const dls_lcp_certificate *certificate, double tol);

/* ---- Lemke ---------------------------------------------------------------------------------- */

typedef struct dls_lemke_settings {
  size_t size;              /* set by init; settings without it are refused */
  double tol;               /* on the certificate's residual; 1e-8 */
  int max_iterations;       /* pivots; 0: 50 n + 1000; 0 */
  dls_progress_fn progress; /* NULL for none */
  void *progress_data;
} dls_lemke_settings;

DLS_API void dls_lemke_settings_init(dls_lemke_settings *settings);

typedef struct dls_lemke_info {
  dls_status status;
  int pivots;
  dls_lcp_certificate certificate; /* of the z that is returned */
} dls_lemke_info;

typedef struct dls_lemke dls_lemke; /* workspace for n <= the n of create */

/* *out = new workspace, NULL on error; the settings are copied. */
DLS_API DLS_MUST_USE dls_status dls_lemke_create(dls_lemke **out, int n,
                                                 const dls_lemke_settings *settings,
                                                 dls_error *error);

/* z (n) and y (n, or NULL): the solution, y = M z + q. On DLS_RAY and the other statuses > 0: the
 * last iterate. Allocates nothing.
 * DLS_OK, DLS_MAX_ITERATIONS, DLS_CANCELLED, DLS_STALLED, DLS_RAY, or an error of dls_lcp_check. */
DLS_API DLS_MUST_USE dls_status dls_lemke_solve(dls_lemke *workspace, const dls_lcp *lcp, double *z,
                                                double *y, dls_lemke_info *info, dls_error *error);

/* NULL is fine. */
DLS_API void dls_lemke_destroy(dls_lemke *workspace);

/* ---- 2D contact as an LCP -------------------------------------------------------------------- */

/* Rows of the LCP of a 2D contact problem: 3 for a candidate with mu > 0, 1 for one with mu = 0;
 * per candidate, z = (r_n, phi_2, lambda_2), y = (u_n, lambda_1, phi_1), with
 *
 *   phi_1 = mu r_n - r_t,  phi_2 = mu r_n + r_t,  u_t = lambda_1 - lambda_2   ([C] (39), sign of (21))
 *
 * so that M_cc = ( W_nn - mu W_nt   W_nt   0 ;  W_tn - mu W_tt   W_tt   1 ;  2 mu   -1   0 ) and
 * q_c = (q_n, q_t, 0). A frictionless problem is LCP(W_nn, q_n). Returns 0 unless d = 2. */
DLS_API int dls_contact_lcp_size(const dls_contact *problem);

/* M (n x n, leading dimension ldm >= n) and q (n) := the LCP above, n = dls_contact_lcp_size, in
 * scaled unknowns r_c = s_c r'_c, u_c = u'_c / s_c; s (nc, each > 0) or NULL for none.
 * s_c = 1 / sqrt(w_c) makes the diagonal blocks of W of size 1. DLS_E_UNSUPPORTED unless d = 2. */
DLS_API DLS_MUST_USE dls_status dls_contact_to_lcp(const dls_contact *problem, const double *s,
                                                   double *M, int ldm, double *q, dls_error *error);

/* r (m) := the reactions that z (n) stands for; the same s as above. */
DLS_API DLS_MUST_USE dls_status dls_contact_from_lcp(const dls_contact *problem, const double *s,
                                                     const double *z, double *r, dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
