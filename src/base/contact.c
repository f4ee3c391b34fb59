/*
 * contact.c: the contact problem u = W r + q and its certificate, the one measure for every method.
 *
 *   C_mu = { r : |r_t| <= mu r_n }
 *   F_c  = w_c r_c - P_Cmu( w_c r_c - (u_c + mu_c |u_tc| n) ),   w_c = trace(W_cc) / d
 *
 * F = 0 if and only if every candidate meets the contact and friction laws (de Saxce's form:
 * C*_mu contains u + mu |u_t| n, perpendicular to r in C_mu).
 */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/base.h"

/* ---- W, dense or by blocks ------------------------------------------------------------------- */

/* block := the sum of those of column c in row c, W by blocks; n = d d in a parameter of its own for the
 * compiler to see */
static inline void add_diagonal(size_t n, const dls_blocks *B, int c, double *block) {
  for (size_t e = 0; e < n; e++)
    block[e] = 0;
  for (int k = B->p[c]; k < B->p[c + 1]; k++)
    if (B->i[k] == c)
      for (size_t e = 0; e < n; e++)
        block[e] += B->x[n * (size_t)k + e];
}

void dlsi_contact_diagonal(const dls_contact *problem, int c, double *block) {
  const int d = problem->d;
  if (!problem->Wb.x) {
    const size_t ld = (size_t)problem->W.ld, k = (size_t)d * (size_t)c;
    for (int j = 0; j < d; j++)
      for (int i = 0; i < d; i++)
        block[i + d * j] = problem->W.a[k + (size_t)i + (k + (size_t)j) * ld];
  } else if (d == 2)
    add_diagonal(4, &problem->Wb, c, block);
  else
    add_diagonal(9, &problem->Wb, c, block);
}

void dlsi_contact_add_columns(const dls_contact *problem, int c, const double *dr, double *u) {
  const int d = problem->d;
  if (!problem->Wb.x) {
    const size_t m = (size_t)d * (size_t)problem->nc, ld = (size_t)problem->W.ld;
    const double *w = problem->W.a + (size_t)d * (size_t)c * ld;
    if (d == 2)
      for (size_t i = 0; i < m; i++)
        u[i] += w[i] * dr[0] + w[i + ld] * dr[1];
    else
      for (size_t i = 0; i < m; i++)
        u[i] += w[i] * dr[0] + w[i + ld] * dr[1] + w[i + 2 * ld] * dr[2];
    return;
  }
  dlsi_contact_add_blocks(problem, c, dr, u);
}

static int is_zero(size_t d, const double *r) {
  return r[0] == 0 && r[1] == 0 && (d == 2 || r[2] == 0);
}

/* dense: W is read once */
static void multiply_dense(const dls_contact *problem, const int *order, const double *r, double *u,
                           double *a) {
  enum { at_once = 16 };
  const size_t d = (size_t)problem->d;
  int count = 0, c[at_once];
  double dr[3 * at_once];
  for (int i = 0; i < problem->nc; i++) {
    const int k = order ? order[i] : i;
    const double *rk = r + d * (size_t)k;
    if (is_zero(d, rk)) continue; /* W is finite */
    if (a) {
      dlsi_contact_add_both(problem, k, rk, u, a);
      continue;
    }
    memcpy(dr + d * (size_t)count, rk, d * sizeof *dr);
    c[count++] = k;
    if (count < at_once) continue;
    dlsi_contact_add_panel(problem, count, c, dr, u);
    count = 0;
  }
  dlsi_contact_add_panel(problem, count, c, dr, u);
}

/* a += |W(:,c)| |rc|, W by blocks */
static inline void add_magnitudes(size_t d, const dls_blocks *B, size_t c, const double *rc,
                                  double *a) {
  for (int k = B->p[c]; k < B->p[c + 1]; k++) {
    const double *x = B->x + d * d * (size_t)k;
    double *b = a + d * (size_t)B->i[k];
    for (size_t i = 0; i < d; i++) {
      double sum = 0;
      for (size_t j = 0; j < d; j++)
        sum += fabs(x[i + d * j]) * fabs(rc[j]);
      b[i] += sum;
    }
  }
}

void dlsi_contact_multiply(const dls_contact *problem, const int *order, const double *r, double *u,
                           double *a) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  memcpy(u, problem->q, m * sizeof *u);
  if (a) memset(a, 0, m * sizeof *a);
  if (!problem->Wb.x) {
    multiply_dense(problem, order, r, u, a);
    return;
  }
  for (int i = 0; i < problem->nc; i++) {
    const int c = order ? order[i] : i;
    const double *rc = r + d * (size_t)c;
    if (is_zero(d, rc)) continue;
    dlsi_contact_add_blocks(problem, c, rc, u);
    if (!a) continue;
    if (d == 2)
      add_magnitudes(2, &problem->Wb, (size_t)c, rc, a);
    else
      add_magnitudes(3, &problem->Wb, (size_t)c, rc, a);
  }
}

/* ---- blocks by component --------------------------------------------------------------------- */

/* local rows of a component: first one within the candidate, and how many */
static int first_of(dls_component component) {
  return component == DLS_NORMAL ? 0 : 1;
}
static int count_of(int d, dls_component component) {
  return component == DLS_NORMAL ? 1 : d - 1;
}

static dls_status check_components(dls_component row, dls_component col, dls_error *error) {
  if (row != DLS_NORMAL && row != DLS_TANGENT)
    return dlsi_fail(error, DLS_E_ARGUMENT, "row", -1, row, "is no component");
  if (col != DLS_NORMAL && col != DLS_TANGENT)
    return dlsi_fail(error, DLS_E_ARGUMENT, "col", -1, col, "is no component");
  return DLS_OK;
}

dls_status dls_contact_get_block(const dls_contact *problem, dls_component row, dls_component col,
                                 double *block, int ld, dls_error *error) {
  dls_status status = dlsi_check_contact(problem, error);
  if (!status) status = check_components(row, col, error);
  if (status) return dlsi_at(__func__, status, error);
  const int d = problem->d, nc = problem->nc;
  const int nr = count_of(d, row), nk = count_of(d, col), i0 = first_of(row), j0 = first_of(col);
  if (!block) return dlsi_at(__func__, dlsi_is_null(error, "block"), error);
  if (ld < nr * nc)
    return dlsi_at(__func__,
                   dlsi_fail(error, DLS_E_SIZE, "ld", -1, ld, "must be at least %d", nr * nc),
                   error);
  for (int b = 0; b < nc; b++) {
    const dlsi_block_column column = dlsi_contact_column(problem, (size_t)b);
    for (int j = 0; j < nk; j++) {
      double *out = block + (size_t)(b * nk + j) * (size_t)ld;
      memset(out, 0, (size_t)(nr * nc) * sizeof *out);
      for (size_t k = column.begin; k < column.end; k++) {
        const double *w = column.x + k * column.step + (size_t)(j0 + j) * column.ld;
        for (int i = 0; i < nr; i++)
          out[dlsi_row(&column, k) * (size_t)nr + (size_t)i] += w[i0 + i];
      }
    }
  }
  return DLS_OK;
}

dls_status dls_contact_set_block(int d, int nc, dls_component row, dls_component col,
                                 const double *block, int ld, double *W, int ldw,
                                 dls_error *error) {
  dls_status status = dlsi_check_sizes(d, nc, error);
  if (!status) status = check_components(row, col, error);
  if (status) return dlsi_at(__func__, status, error);
  const int nr = count_of(d, row), nk = count_of(d, col), i0 = first_of(row), j0 = first_of(col);
  const dls_dense B = {nr * nc, nk * nc, ld, block};
  const dls_status bad = dlsi_check_dense("block", &B, nr * nc, nk * nc, error);
  if (bad) return dlsi_at(__func__, bad, error);
  if (!W) return dlsi_at(__func__, dlsi_is_null(error, "W"), error);
  if (ldw < d * nc)
    return dlsi_at(__func__,
                   dlsi_fail(error, DLS_E_SIZE, "ldw", -1, ldw, "must be at least %d", d * nc),
                   error);
  for (int b = 0; b < nc; b++)
    for (int j = 0; j < nk; j++) {
      const double *in = block + (size_t)(b * nk + j) * (size_t)ld;
      double *w = W + (size_t)(d * b + j0 + j) * (size_t)ldw + i0;
      for (int a = 0; a < nc; a++)
        for (int i = 0; i < nr; i++)
          w[d * a + i] = in[a * nr + i];
    }
  return DLS_OK;
}

/* ---- the certificate ------------------------------------------------------------------------- */

/* w where trace(W_cc) is not positive, for all such c */
static double common_weight(const dls_contact *problem, const double *w) {
  const int entries = problem->d * problem->d;
  double block[9] = {0}, sum = 0, largest = 0;
  int positive = 0;
  for (int c = 0; c < problem->nc; c++) {
    dlsi_contact_diagonal(problem, c, block);
    for (int e = 0; e < entries; e++)
      if (fabs(block[e]) > largest) largest = fabs(block[e]);
    if (w[c] > 0) {
      sum += w[c];
      positive++;
    }
  }
  return positive ? sum / positive : largest > 0 ? largest : 1;
}

void dlsi_contact_complete_weights(const dls_contact *problem, double *w) {
  int positive = 0;
  for (int c = 0; c < problem->nc; c++)
    positive += w[c] > 0;
  if (positive == problem->nc) return;
  const double common = common_weight(problem, w);
  for (int c = 0; c < problem->nc; c++)
    if (!(w[c] > 0)) w[c] = common;
}

void dlsi_contact_weights(const dls_contact *problem, double *w) {
  for (int c = 0; c < problem->nc; c++) {
    double block[9] = {0};
    dlsi_contact_diagonal(problem, c, block);
    w[c] = dlsi_block_weight(problem->d, block);
  }
  dlsi_contact_complete_weights(problem, w);
}

/* m := max(m, x), keeping NaN */
static void raise(double *m, double x) {
  if (x > *m || x != x) *m = x;
}

/* max(a, w |r|) for one row: what F is computed from, and so what its rounding is relative to */
static inline double magnitude(double a, double w, double r) {
  const double wr = w * fabs(r);
  return a > wr || a != a ? a : wr;
}

/* | magnitude |_2, where a plain sum of squares does not tell */
static double norm_of_magnitudes(const dls_contact *problem, const double *r, const double *a,
                                 const double *w) {
  const size_t d = (size_t)problem->d, nc = (size_t)problem->nc;
  double largest = 0, sum = 0;
  for (int pass = 0; pass < 2; pass++) {
    const double scale = largest;
    for (size_t c = 0, e = 0; c < nc; c++)
      for (size_t i = 0; i < d; i++, e++) {
        const double x = magnitude(a[e], w[c], r[e]);
        raise(&largest, x);
        if (pass) sum += (x / scale) * (x / scale);
      }
    if (!(largest > 0)) return largest;
  }
  return largest * sqrt(sum);
}

/* The candidate with the largest |F_c|, where plain sums of squares do not tell. */
static int find_worst(const dls_contact *problem, const double *F) {
  const size_t d = (size_t)problem->d;
  double worst = -1;
  int at = 0;
  for (int k = 0; k < problem->nc; k++) {
    const double size = dlsi_norm2(F + d * (size_t)k, d);
    if (!(size > worst) && size == size) continue;
    worst = size != size ? INFINITY : size;
    at = k;
  }
  return at;
}

/* F (m), c but for residual and floor; returns sum |F_c|^2; *rounded: that of the magnitudes. d in a
 * parameter of its own for the compiler to see. */
static inline double measure_each(int d, const dls_contact *problem, const double *r,
                                  const double *u, const double *a, const double *w, double *F,
                                  dls_certificate *c, double *rounded) {
  double worst = 0, sum = 0;
  *rounded = 0;
  for (int k = 0; k < problem->nc; k++) {
    const size_t o = (size_t)d * (size_t)k;
    const double mu = problem->mu[k], *rc = r + o, *uc = u + o;
    const double ut = dlsi_tangent_norm(d, uc);
    double *Fc = F + o, size = 0;
    for (int i = 0; i < d; i++) {
      const double x = magnitude(a[o + (size_t)i], w[k], rc[i]);
      *rounded += x * x;
    }
    if (is_zero((size_t)d, rc) && uc[0] >= 0 && uc[0] + ut <= DBL_MAX) { /* all of it is 0 */
      for (int i = 0; i < d; i++)
        Fc[i] = 0;
      continue;
    }
    const double rt = dlsi_tangent_norm(d, rc);
    dlsi_contact_residual(d, mu, w[k], rc, uc, Fc);
    for (int i = 0; i < d; i++) {
      const double square = Fc[i] * Fc[i];
      size += square;
      sum += square;
    }
    if (size > worst) {
      worst = size;
      c->worst = k;
    }
    raise(&c->penetration, -uc[0]);
    raise(&c->adhesion, -rc[0]);
    raise(&c->cone_violation, rt - mu * (rc[0] > 0 ? rc[0] : 0));
    raise(&c->complementarity, fabs(uc[0] * rc[0]));
    if (rt > 0) {
      double e[3] = {0};
      for (int i = 1; i < d; i++)
        e[i] = uc[i] + ut * (rc[i] / rt);
      raise(&c->slip_direction, dlsi_tangent_norm(d, e));
    } else if (mu * rc[0] > 0)
      raise(&c->slip_direction, ut);
  }
  return sum;
}

void dlsi_contact_measure(const dls_contact *problem, const double *r, const double *u,
                          const double *a, const double *w, double *F,
                          dls_certificate *certificate) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  dls_certificate c = {0};
  double rounded;
  const double sum = problem->d == 2 ? measure_each(2, problem, r, u, a, w, F, &c, &rounded)
                                     : measure_each(3, problem, r, u, a, w, F, &c, &rounded);
  const int plain = dlsi_is_plain(sum);
  if (!plain) c.worst = find_worst(problem, F);
  const double f = plain ? sqrt(sum) : dlsi_norm2(F, m), q = dlsi_norm2(problem->q, m);
  const double scale = q > 0 ? q : dlsi_norm2(a, m);
  c.residual = f == 0 ? 0 : f / scale;
  rounded = dlsi_is_plain(rounded) ? sqrt(rounded) : norm_of_magnitudes(problem, r, a, w);
  c.floor = rounded == 0 ? 0 : DBL_EPSILON * (rounded / scale);
  *certificate = c;
}

dls_status dls_contact_certify(const dls_contact *problem, const double *r, double *u,
                               dls_certificate *certificate, dls_error *error) {
  dls_status status = dlsi_check_contact(problem, error);
  if (status) return dlsi_at(__func__, status, error);
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  status = dlsi_check_vector("r", r, m, error);
  if (status) return dlsi_at(__func__, status, error);
  if (!certificate) return dlsi_at(__func__, dlsi_is_null(error, "certificate"), error);
  double *work = dlsi_alloc(4 * m, sizeof *work);
  if (!work) return dlsi_at(__func__, dlsi_no_memory(error), error);
  double *v = work, *a = work + m, *w = work + 2 * m, *F = work + 3 * m;
  dlsi_contact_multiply(problem, NULL, r, v, a);
  dlsi_contact_weights(problem, w);
  dlsi_contact_measure(problem, r, v, a, w, F, certificate);
  if (u) memcpy(u, v, m * sizeof *u);
  free(work);
  return DLS_OK;
}

int dls_certificate_holds(const dls_certificate *certificate, double tol) {
  if (!certificate) return 0;
  const double four = 4 * certificate->floor, coarsest = tol > 1e-8 ? tol : 1e-8;
  return certificate->residual <= (four > tol ? four : tol) && four <= coarsest;
}

dls_status dls_contact_states(const dls_contact *problem, const double *r, const double *u,
                              dls_contact_state *state, dls_error *error) {
  dls_status status = dlsi_check_contact(problem, error);
  if (status) return dlsi_at(__func__, status, error);
  const int d = problem->d;
  const size_t m = (size_t)d * (size_t)problem->nc;
  status = dlsi_check_vector("r", r, m, error);
  if (!status) status = dlsi_check_vector("u", u, m, error);
  if (status) return dlsi_at(__func__, status, error);
  if (!state) return dlsi_at(__func__, dlsi_is_null(error, "state"), error);
  double *w = dlsi_alloc((size_t)problem->nc, sizeof *w), F[3];
  if (!w) return dlsi_at(__func__, dlsi_no_memory(error), error);
  dlsi_contact_weights(problem, w);
  for (int c = 0; c < problem->nc; c++) {
    const size_t o = (size_t)d * (size_t)c;
    state[c] = dlsi_contact_residual(d, problem->mu[c], w[c], r + o, u + o, F);
  }
  free(w);
  return DLS_OK;
}
