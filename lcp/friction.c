/*
 * friction.c: states the contact problem as an LCP, for a friction cone spanned by directions, and
 * in 2D for the form with three rows, [Chabrand 1998] (39) with the sign of (21).
 *
 * A contact with mu > 0 has the unknowns z = (r_n, beta_0 .. beta_(m-1), lambda), with directions
 * e_k in the tangent plane and
 *
 *   (FI1)  r_t = sum_k beta_k e_k - shift mu r_n e_0
 *   (FI2)  y   = ( u_n,  e_k.u_t + lambda,  (1 + shift) mu r_n - sum_k beta_k )
 *
 * A contact with mu = 0 has z = r_n, y = u_n. shift = 0 gives the cones of facets.c. shift = 1
 * and m = 1 give the three rows in 2D,
 *
 *   phi_1 = mu r_n - r_t >= 0,   phi_2 = mu r_n + r_t >= 0,   u_t = lambda_1 - lambda_2
 *   lambda_m >= 0,  lambda_m phi_m = 0,   0 <= u_n _|_ r_n >= 0
 *
 * with r_t = phi_2 - mu r_n, z = (r_n, phi_2, lambda_2) and y = (u_n, lambda_1, phi_1):
 *
 *   u_n      = (W_nn - mu W_nt) r_n + W_nt phi_2            + q_n
 *   lambda_1 = (W_tn - mu W_tt) r_n + W_tt phi_2 + lambda_2 + q_t       (u_t + lambda_2)
 *   phi_1    =             2 mu r_n -      phi_2                        (2 mu r_n - (mu r_n + r_t))
 *
 * The mu of a column is that of the contact whose reaction the column multiplies. Scaling:
 *
 *   (FI3)  r_c = s_c r'_c,  u_c = u'_c / s_c,  so that  W'_ab = s_a W_ab s_b,  q'_a = s_a q_a
 *
 * The laws are homogeneous in r and in u, so the LCP keeps its form.
 */
#include <limits.h>
#include <math.h>
#include <string.h>

#include "lcp_internal.h"

/* ---- the LCP of any form --------------------------------------------------------------------- */

static int form_rows(const dls_contact *problem, int directions, int c) {
  return problem->mu[c] > 0 ? directions + 2 : 1;
}

int dlsi_form_size(const dls_contact *problem, int directions) {
  int n = 0;
  for (int c = 0; c < problem->nc; c++) {
    if (n > INT_MAX - directions - 2) return 0;
    n += form_rows(problem, directions, c);
  }
  return n;
}

/* Checks that the LCP has a size, *n, and that the scales s are finite and positive. */
static dls_status form_check(const dls_contact *problem, const dlsi_form *form, const double *s,
                             int *n, dls_error *error) {
  if (problem->nc == 0) return dlsi_fail(error, DLS_E_SIZE, "nc", -1, 0, "is 0: no LCP is left");
  *n = dlsi_form_size(problem, form->directions);
  if (*n < 1) return dlsi_fail(error, DLS_E_SIZE, "nc", -1, problem->nc, "is too large");
  return s ? dlsi_check_positive("s", s, problem->nc, error) : DLS_OK;
}

/* c0 := column r_n of (FI1) for contact b: n - shift mu e_0. */
static void form_normal(const dls_contact *problem, const dlsi_form *form, int b, double c0[3]) {
  for (int i = 0; i < 3; i++)
    c0[i] = form->c[0][i] - (problem->mu[b] > 0 ? form->shift * problem->mu[b] * form->c[1][i] : 0);
}

/* M += C_rows^T (scale W) C_columns; c0: column 0 of the second C; W: d x d, leading
 * dimension ldw. */
static DLSI_INLINE void form_add_block(int d, const dlsi_form *form, double scale, const double *W,
                                       size_t ldw, const double *c0, int rows, int columns,
                                       double *M, size_t ldm) {
  double S[3][3], g[3] = {0};
  for (int j = 0; j < d; j++)
    for (int i = 0; i < d; i++)
      S[j][i] = scale * W[(size_t)i + (size_t)j * ldw];
  for (int k = 0; k < columns; k++, M += ldm) {
    const double *c = k ? form->c[k] : c0;
    for (int i = 0; i < d; i++)
      g[i] = S[0][i] * c[0] + (d > 1 ? S[1][i] * c[1] : 0) + (d == 3 ? S[2][i] * c[2] : 0);
    M[0] += g[0];
    for (int i = 1; i < rows; i++)
      M[i] += form->c[i][1] * g[1] + (d == 3 ? form->c[i][2] * g[2] : 0);
  }
}

/* Writes the entries of M that do not come from W: the column and the row of lambda. own: the
 * contact's diagonal block of M. */
static void form_add_multiplier(double mu, const dlsi_form *form, double *own, size_t ldm) {
  const size_t last = (size_t)form->directions + 1;
  own[last] = (1 + form->shift) * mu;
  for (size_t k = 1; k < last; k++) {
    own[last + k * ldm] = -1;
    own[k + last * ldm] = 1;
  }
}

dls_status dlsi_form_matrix(const dls_contact *problem, const dlsi_form *form, const double *s,
                            double *M, int ldm, double *q, dls_error *error) {
  int n;
  const dls_status status = form_check(problem, form, s, &n, error);
  if (status) return status;
  if (!M) return dlsi_is_null(error, "M");
  if (ldm < n) return dlsi_fail(error, DLS_E_SIZE, "ldm", -1, ldm, "must be at least %d", n);
  if (!q) return dlsi_is_null(error, "q");

  const int d = problem->d, nc = problem->nc, all = form->directions + 1;
  const size_t ld = (size_t)ldm;
  double *first = q; /* first row of each contact; the entries of q are written last */
  for (int c = 0, i = 0; c < nc; i += form_rows(problem, form->directions, c), c++)
    first[c] = i;
  for (size_t j = 0; j < (size_t)n; j++)
    memset(M + j * ld, 0, (size_t)n * sizeof *M);
  for (int b = 0; b < nc; b++) {
    const dlsi_block_column column = dlsi_contact_column(problem, (size_t)b);
    const double sb = s ? s[b] : 1, mu = problem->mu[b];
    double *own = M + (size_t)first[b] * ld, c0[3];
    form_normal(problem, form, b, c0);
    for (size_t k = column.begin; k < column.end; k++) {
      const size_t a = dlsi_row(&column, k);
      const int rows = problem->mu[a] > 0 ? all : 1, columns = mu > 0 ? all : 1;
      const double scale = sb * (s ? s[a] : 1), *W = column.x + k * column.step;
      double *block = own + (size_t)first[a];
      if (d == 1) /* the loops unrolled */
        block[0] += scale * W[0];
      else if (d == 2)
        form_add_block(2, form, scale, W, column.ld, c0, rows, columns, block, ld);
      else
        form_add_block(3, form, scale, W, column.ld, c0, rows, columns, block, ld);
    }
    if (mu > 0) form_add_multiplier(mu, form, own + (size_t)first[b], ld);
  }
  for (int c = 0; c < nc; c++) {
    const double sc = s ? s[c] : 1, *qc = problem->q + (size_t)d * (size_t)c;
    for (int k = 0, rows = form_rows(problem, form->directions, c); k < rows; k++, q++) {
      *q = 0;
      for (int j = 0; j < d && k < all; j++)
        *q += sc * qc[j] * form->c[k][j];
    }
  }
  return DLS_OK;
}

dls_status dlsi_form_reactions(const dls_contact *problem, const dlsi_form *form, const double *s,
                               const double *z, double *r, dls_error *error) {
  int n;
  dls_status status = form_check(problem, form, s, &n, error);
  if (!status) status = dlsi_check_vector("z", z, (size_t)n, error);
  if (status) return status;
  if (!r) return dlsi_is_null(error, "r");
  for (int c = 0; c < problem->nc; c++) {
    const int rows = form_rows(problem, form->directions, c);
    double c0[3], sum[3] = {0};
    form_normal(problem, form, c, c0);
    for (int k = 0; k == 0 || k < rows - 1; k++)
      for (int i = 0; i < problem->d; i++)
        sum[i] += z[k] * (k ? form->c[k] : c0)[i];
    for (int i = 0; i < problem->d; i++)
      *r++ = (s ? s[c] : 1) * sum[i];
    z += rows;
  }
  return DLS_OK;
}

/* ---- three rows in 2D ------------------------------------------------------------------------ */

static const dlsi_form three_rows = {.directions = 1, .shift = 1, .c = {{1, 0, 0}, {0, 1, 0}}};

int dls_contact_lcp_size(const dls_contact *problem) {
  return problem && problem->d <= 2 && problem->mu ? dlsi_form_size(problem, 1) : 0;
}

static dls_status friction_check(const dls_contact *problem, dls_error *error) {
  dls_status status = dlsi_check_contact(problem, error);
  if (!status) status = dlsi_refuse_bonded(problem, error);
  if (status || problem->d <= 2) return status;
  return dlsi_fail(error, DLS_E_UNSUPPORTED, "d", -1, problem->d,
                   "is %d; only d = 1 and 2 have this form", problem->d);
}

dls_status dls_contact_to_lcp(const dls_contact *problem, const double *s, double *M, int ldm,
                              double *q, dls_error *error) {
  DLSI_DOOR;
  dlsi_formed formed = {.work = NULL};
  dls_status status = friction_check(problem, error);
  if (!status) status = dlsi_form_blocks(&formed, &problem, error);
  if (!status) status = dlsi_form_matrix(problem, &three_rows, s, M, ldm, q, error);
  dlsi_formed_free(&formed);
  return dlsi_at(__func__, status, error);
}

dls_status dls_contact_from_lcp(const dls_contact *problem, const double *s, const double *z,
                                double *r, dls_error *error) {
  DLSI_DOOR;
  dls_status status = friction_check(problem, error);
  if (!status) status = dlsi_form_reactions(problem, &three_rows, s, z, r, error);
  return dlsi_at(__func__, status, error);
}

/* Positive unknowns by state: stick (r_n, phi_2); slip in +t (r_n), in -t (r_n, phi_2, lambda_2);
 * free: none, or lambda_2 if u_t < 0. */
void dlsi_friction_start(const dls_contact *problem, const double *w, const double *r,
                         const double *u, double *z) {
  for (int c = 0; c < problem->nc; z += form_rows(problem, 1, c), c++) {
    const size_t d = (size_t)problem->d;
    const double mu = problem->mu[c], *rc = r + d * (size_t)c, *uc = u + d * (size_t)c;
    double F[2] = {0};
    const double both[2] = {w[c], w[c]};
    const dls_contact_state state = dlsi_contact_misfit((int)d, mu, both, rc, uc, F);
    z[0] = state != DLS_FREE;
    if (!(mu > 0)) continue;
    const int back = uc[1] < 0;
    z[1] = state == DLS_STICK || (state == DLS_SLIP && back);
    z[2] = state != DLS_STICK && back;
  }
}
