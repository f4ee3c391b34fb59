/*
 * derive_body.c: derivatives of an answer (x, r) on K, with the notation of derive.c.
 *
 *   (DB1)  M = (K, -H E; R H^T, L):   M (dx; y) = (df - dK x + H s; -R dg)
 *   (DB2)  dr = E y + s,   du = H^T dx + dg
 *   (DB3)  M^T (b; l) = (g_x + H g_u; E^T g_r),   a = g_u - R^T l
 *   (DB4)  dL/df = b,   dL/dg = P a,   dL/dK = -b x^T,   dL/dmu_c = r_n t.(g_r + H^T b)_c
 *
 * If K is regular, eliminating x gives (DR2) and (DR3): b = K^-T (H a + g_x). M is regular, too, if
 * only contact holds a body. Rows of K x = f + H r that are joints are as all others; the
 * multipliers of redundant joints stay 0.
 *
 * Cost: a sparse LU of M, of the size of K and the contacts that touch. What can fail: bodies that
 * nothing holds; a build without MUMPS beyond 8000 unknowns.
 */
#include <stdlib.h>
#include <string.h>

#include "contact/body.h"
#include "facts/derive.h"
#include "linear/blas.h"
#include "linear/equilibrate.h"
#include "linear/redundant.h"

static int derive_is_symmetric(const dls_model *K) {
  return K->factorization != DLS_LU;
}

size_t dlsi_derive_values(const dls_model *K) {
  const size_t n = (size_t)K->n;
  return K->operator_kind == DLS_STIFFNESS_DENSE ? n * n : (size_t)K->Ks.p[n];
}

void dlsi_derive_look(const dls_derive *work, const double *x, double *y) {
  const dlsi_columns *Ht = &work->body.H->Ht;
  for (int i = 0; i < work->n; i++)
    for (int e = Ht->p[i]; e < Ht->p[i + 1]; e++)
      y[Ht->i[e]] += Ht->x[e] * x[i];
}

void dlsi_derive_push(const dls_derive *work, const double *r, double *x) {
  const dlsi_columns *Ht = &work->body.H->Ht;
  for (int i = 0; i < work->n; i++)
    for (int e = Ht->p[i]; e < Ht->p[i + 1]; e++)
      x[i] += Ht->x[e] * r[Ht->i[e]];
}

void dlsi_derive_gaps(const dls_derive *work, int back, double *nodes, double *contacts) {
  const dlsi_operator *H = work->body.H;
  const int d = H->d, space = work->body.space;
  for (int k = 0; back && k < space * work->body.nodes; k++)
    nodes[k] = 0;
  for (int c = 0; c < H->candidates; c++)
    for (int i = 0; i < d; i++) {
      double *of = contacts + d * c + i;
      if (!back) *of = 0;
      for (int k = H->P.p[c]; (i == 0 || dlsi_has_tangents(H, c)) && k < H->P.p[c + 1]; k++) {
        double *at = nodes + (size_t)space * (size_t)H->P.i[k] + i;
        if (back)
          *at += H->P.x[k] * *of;
        else
          *of += H->P.x[k] * *at;
      }
    }
}

/* ---- the system ------------------------------------------------------------------------------ */

static void derive_add(dlsi_triplets *t, int row, int col, double x) {
  if (x != 0) dlsi_triplets_add(t, row, col, x);
}

/* Adds H E, R H^T and L for the entry h of H in row i and column k. */
static void derive_add_contact(const dls_derive *work, int i, int k, double h, dlsi_triplets *t) {
  const int d = work->problem.d;
  const dlsi_branch *at = &work->branch[k / d];
  for (int j = 0; j < at->count; j++) {
    const int y = work->n + at->first + j;
    double e[3], unit[3] = {0};
    unit[k % d] = h;
    dlsi_branch_direction(at, j, e);
    derive_add(t, i, y, -h * e[k % d]);
    derive_add(t, y, i, dlsi_branch_row(at, j, unit));
  }
}

/* (DB1) t := M for this K. */
static dls_status derive_assemble(const dls_derive *work, const dls_model *K, dlsi_triplets *t,
                                  dls_error *error) {
  const dlsi_columns *Ht = &work->body.H->Ht;
  const int all = work->n + work->rows;
  const size_t most =
      2 * dlsi_derive_values(K) + 6 * (size_t)Ht->p[work->n] + (size_t)work->problem.nc;
  const dls_status status = dlsi_triplets_alloc(all, all, most, t, error);
  for (int j = 0; !status && j < work->n; j++) {
    int i;
    double v;
    for (int at = 0; dlsi_body_entry(K, j, &at, &i, &v);) {
      derive_add(t, i, j, v);
      if (derive_is_symmetric(K) && i != j) derive_add(t, j, i, v);
    }
    for (int e = Ht->p[j]; e < Ht->p[j + 1]; e++)
      derive_add_contact(work, j, Ht->i[e], Ht->x[e], t);
  }
  for (int c = 0; !status && c < work->problem.nc; c++) {
    const int across = work->n + work->branch[c].first + 1;
    if (work->branch[c].state == DLS_SLIP && work->branch[c].count == 2)
      derive_add(t, across, across, work->branch[c].l);
  }
  return status;
}

/* Factors M and finds its scales. */
static dls_status derive_factor(dls_derive *work, dls_error *error) {
  const size_t all = (size_t)work->n + (size_t)work->rows;
  const dls_sparse Ht = dlsi_columns_view(&work->body.H->Ht);
  dlsi_triplets t = {0};
  dlsi_columns M = {0};
  dlsi_apart apart;
  double *scratch = dlsi_alloc(2 * all, sizeof *scratch);
  dls_status status = dlsi_apart_create(&apart, &work->body.K, &Ht, error);
  if (!status) status = derive_assemble(work, &apart.model, &t, error);
  if (!status)
    status = scratch ? dlsi_columns_compress(&t, 1, DLSI_ALL, &M, error) : dlsi_no_memory(error);
  if (!status) {
    const dls_sparse view = dlsi_columns_view(&M);
    dlsi_find_scales(&view, 0, work->row, work->col, scratch);
    status = dlsi_general_factor(&work->M, &t, error);
  }
  work->fixed = apart.count;
  work->redundant = apart.redundant;
  apart.redundant = NULL;
  dlsi_apart_free(&apart);
  dlsi_triplets_free(&t);
  dlsi_columns_free(&M);
  free(scratch);
  return dlsi_derive_judge(work, status, error);
}

/* ---- create ---------------------------------------------------------------------------------- */

static dls_status derive_body(dls_derive *work, const double *r, const double *x, int side,
                              double residual, dls_error *error) {
  const size_t nc = (size_t)work->problem.nc, m = (size_t)work->problem.d * nc;
  if (r) memcpy(work->r, r, m * sizeof *r);
  memcpy(work->x, x, (size_t)work->n * sizeof *x);
  memcpy(work->w, work->body.w, 2 * nc * sizeof *work->w);
  memcpy(work->u, work->body.gap, m * sizeof *work->u);
  dlsi_derive_look(work, x, work->u);
  const dls_status status = dlsi_derive_choose(work, side, residual, error);
  return status ? status : derive_factor(work, error);
}

static dls_status derive_create_body(dls_derive **out, dls_reduction *reduction, const double *mu,
                                     const double *r, const double *x, int side, dls_error *error) {
  dls_certificate found;
  dls_status status = dls_reduction_certify(reduction, mu, r, x, NULL, &found, error);
  if (status) return status;
  const dlsi_reduced body = dlsi_reduction_body(reduction);
  const dls_contact sizes = {.d = body.H->d, .nc = body.H->candidates, .mu = mu ? mu : body.mu};
  if (!body.has_K)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "reduction", -1, 0,
                     "has no K: it was made of a flexibility or of a host's solver");
  for (int c = 0; c < sizes.nc; c++)
    if (sizes.mu[c] > 0 && (sizes.d == 1 || !dlsi_has_tangents(body.H, c)))
      return dlsi_fail(error, DLS_E_ARGUMENT, "mu", c, sizes.mu[c],
                       "is %g, must be 0 where the tangents were left out", sizes.mu[c]);
  status = dlsi_derive_new(out, &sizes, body.K.n, error);
  if (status) return status;
  (*out)->body = body;
  status = derive_body(*out, r, x, side, found.residual, error);
  if (!status) return DLS_OK;
  dls_derive_destroy(*out);
  *out = NULL;
  return status;
}

dls_status dls_derive_create_body(dls_derive **out, dls_reduction *reduction, const double *mu,
                                  const double *r, const double *x, int side, dls_error *error) {
  DLSI_DOOR;
  if (out) *out = NULL;
  dls_status status = out ? dlsi_check_blas(error) : dlsi_is_null(error, "out");
  if (!status) status = derive_create_body(out, reduction, mu, r, x, side, error);
  return dlsi_at(__func__, status, error);
}

/* ---- products -------------------------------------------------------------------------------- */

void dlsi_derive_stored(const dls_derive *work, const double *b, double *value) {
  const dls_model *K = &work->body.K;
  const int dense = K->operator_kind == DLS_STIFFNESS_DENSE, lower = derive_is_symmetric(K);
  const double *x = work->x;
  for (int j = 0; j < work->n; j++)
    for (int k = dense ? 0 : K->Ks.p[j]; k < (dense ? work->n : K->Ks.p[j + 1]); k++) {
      const int i = dense ? k : K->Ks.i[k];
      double *v = value + k + (dense ? (size_t)j * (size_t)work->n : 0);
      *v = lower && i < j ? 0 : -b[i] * x[j];
      if (lower && i > j) *v -= b[j] * x[i];
    }
}

void dlsi_derive_apply(const dls_derive *work, const double *dK, double *y) {
  dls_model changed = work->body.K;
  *(changed.operator_kind == DLS_STIFFNESS_DENSE ? &changed.K.a : &changed.Ks.x) = dK;
  dlsi_body_multiply(&changed, work->x, y, NULL);
}
