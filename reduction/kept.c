/*
 * kept.c: the copy of the host's model that a reduction keeps for the certificate of the body: K,
 * the weights of the contacts, the connected bodies, the given loads and gaps.
 *
 * The factor cannot replace it: K x is a product with K itself.
 * Cost: the entries of K, and O(entries) operations.
 */
#include <stdlib.h>
#include <string.h>

#include "reduction_internal.h"

/* Copies a dense K without gaps. */
static dls_status kept_dense(dlsi_kept *kept, const dls_model *model, dls_error *error) {
  const size_t n = (size_t)model->n;
  double *a = kept->x = dlsi_alloc(n, n * sizeof *a);
  if (!a) return dlsi_no_memory(error);
  for (size_t j = 0; j < n; j++)
    memcpy(a + j * n, model->K.a + j * (size_t)model->K.ld, n * sizeof *a);
  kept->model.K = (dls_dense){model->n, model->n, model->n, a};
  return DLS_OK;
}

static dls_status kept_sparse(dlsi_kept *kept, const dls_model *model, dls_error *error) {
  const size_t n = (size_t)model->n, entries = (size_t)model->Ks.p[n];
  kept->x = dlsi_alloc(entries, sizeof *kept->x);
  kept->index = dlsi_alloc(n + 1 + entries, sizeof *kept->index);
  if (!kept->x || !kept->index) return dlsi_no_memory(error);
  memcpy(kept->index, model->Ks.p, (n + 1) * sizeof *kept->index);
  memcpy(kept->index + n + 1, model->Ks.i, entries * sizeof *kept->index);
  memcpy(kept->x, model->Ks.x, entries * sizeof *kept->x);
  kept->model.Ks = (dls_sparse){model->n, model->n, kept->index, kept->index + n + 1, kept->x};
  return DLS_OK;
}

/* Sets the weights from K and H by columns. */
static dls_status kept_weights(dlsi_kept *kept, const dlsi_operator *H, dls_error *error) {
  dlsi_columns columns;
  dls_status status = dlsi_operator_columns(H, H->d, DLSI_ALL, &columns, error);
  const dls_sparse view = dlsi_columns_view(&columns);
  if (!status) status = dlsi_body_weights(&kept->model, &view, H->d, kept->w, error);
  dlsi_columns_free(&columns);
  return status;
}

/* Finds the connected bodies and the joints between them. */
static void kept_parts(dlsi_kept *kept) {
  dlsi_body *body = &kept->body;
  const size_t n = (size_t)body->n;
  int *joint = kept->part + n, *piece = joint + n;
  body->parts = dlsi_body_parts(&kept->model, kept->part);
  if (!dlsi_body_joints(&kept->model, &body->Ht, joint)) return;
  body->joint = joint;
  body->piece = piece;
  body->pieces = dlsi_body_pieces(&kept->model, joint, piece);
}

static dls_status kept_scratch(dlsi_kept *kept, dls_error *error) {
  kept->scratch = dlsi_alloc(dlsi_body_scratch(&kept->body), sizeof *kept->scratch);
  return kept->scratch ? DLS_OK : dlsi_no_memory(error);
}

/* Fills all but the copy of K. */
static dls_status kept_contacts(dlsi_kept *kept, int has_K, const dlsi_operator *H,
                                dls_error *error) {
  const size_t n = (size_t)kept->model.n, nc = (size_t)H->candidates, m = (size_t)H->d * nc;
  kept->body = (dlsi_body){.n = kept->model.n, .Ht = dlsi_columns_view(&H->Ht), .d = H->d};
  kept->body.nc = H->candidates;
  kept->memory = dlsi_alloc(2 * n + 2 * m + 2 * nc, sizeof(double));
  kept->part = dlsi_alloc(3 * n, sizeof *kept->part);
  if (!kept->memory || !kept->part) return dlsi_no_memory(error);
  kept->f = kept->memory;
  kept->gap = kept->f + n;
  kept->u = kept->gap + m;
  kept->w = kept->u + m;
  kept->body.w = kept->w;
  kept->body.part = kept->part;
  memset(kept->f, 0, (n + m) * sizeof *kept->f);
  for (size_t k = 0; k < 2 * nc; k++)
    kept->w[k] = 1;
  if (!has_K) return kept_scratch(kept, error);
  kept_parts(kept);
  dls_status status = kept_weights(kept, H, error);
  if (!status) status = kept_scratch(kept, error);
  if (!status) {
    dlsi_body_shares(&kept->model, kept->w + 2 * nc);
    kept->body.share = kept->w + 2 * nc;
  }
  kept->has_K = !status;
  return status;
}

dls_status dlsi_kept_create(dlsi_kept *kept, const dls_model *model, const dlsi_operator *H,
                            dls_error *error) {
  const int dense = model->operator_kind == DLS_STIFFNESS_DENSE;
  const int has_K = dense || model->operator_kind == DLS_STIFFNESS_SPARSE;
  *kept = (dlsi_kept){.model = {.n = model->n,
                                .operator_kind = model->operator_kind,
                                .factorization = model->factorization,
                                .triangular = model->triangular}};
  dls_status status = DLS_OK;
  if (has_K) status = dense ? kept_dense(kept, model, error) : kept_sparse(kept, model, error);
  return status ? status : kept_contacts(kept, has_K, H, error);
}

dls_status dlsi_kept_again(const dlsi_kept *kept, const dlsi_operator *H, dlsi_kept *next,
                           dls_error *error) {
  *next = (dlsi_kept){.model = kept->model};
  const dls_status status = kept_contacts(next, kept->has_K, H, error);
  if (!status) memcpy(next->f, kept->f, (size_t)kept->model.n * sizeof *next->f);
  return status;
}

void dlsi_kept_take(dlsi_kept *kept, const dlsi_kept *next) {
  double *const x = kept->x;
  int *const index = kept->index;
  kept->x = NULL;
  kept->index = NULL;
  dlsi_kept_free(kept);
  *kept = *next;
  kept->x = x;
  kept->index = index;
}

void dlsi_kept_free(dlsi_kept *kept) {
  dlsi_system_destroy(kept->system);
  dlsi_columns_free(&kept->K);
  dlsi_columns_free(&kept->H);
  free(kept->x);
  free(kept->scratch);
  free(kept->index);
  free(kept->part);
  free(kept->memory);
  *kept = (dlsi_kept){.x = NULL};
}

/* Returns the body, which lives where *kept does. */
static const dlsi_body *kept_body(dlsi_kept *kept) {
  kept->body.model = kept->has_K ? &kept->model : NULL;
  return &kept->body;
}

/* ---- certify --------------------------------------------------------------------------------- */

/* Makes the factor of K with weak contacts, once. */
static dls_status kept_factor(dlsi_kept *kept, const dlsi_operator *H, dls_error *error) {
  if (kept->system) return DLS_OK;
  const int d = H->d;
  dls_status status = dlsi_stiffness_columns(&kept->model, &kept->K, error);
  if (!status) status = dlsi_operator_columns(H, d, DLSI_ALL, &kept->H, error);
  for (int k = 0; !status && k < kept->H.cols; k++)
    for (int e = kept->H.p[k]; e < kept->H.p[k + 1]; e++)
      kept->H.x[e] /= sqrt(kept->w[2 * (k / d) + (k % d > 0)]);
  dls_model K = kept->model;
  K.operator_kind = DLS_STIFFNESS_SPARSE;
  K.Ks = dlsi_columns_view(&kept->K);
  const dls_sparse round = dlsi_columns_view(&kept->H);
  if (!status) status = dlsi_system_create(&kept->system, &K, &round, d, NULL, error);
  if (!status) status = dlsi_system_factor_apart(kept->system, dlsi_own_share, kept->part, error);
  if (!status) return DLS_OK;
  dlsi_system_destroy(kept->system);
  dlsi_columns_free(&kept->K);
  dlsi_columns_free(&kept->H);
  kept->system = NULL;
  kept->K = kept->H = (dlsi_columns){0};
  return status;
}

static dls_status kept_solve(void *data, double *x, dls_error *error) {
  return dlsi_system_solve(((dlsi_kept *)data)->system, x, error);
}

/* Returns 1 if a second look may show that the pair holds, or that it does not. */
static int kept_is_open(dlsi_kept *kept, double tol, const dls_certificate *found) {
  if (4 * found->floor_e > fmax(tol, 1e-8)) return 1;
  if (dlsi_certificate_verdict(found, tol) != DLS_STALLED) return 0;
  dls_certificate loose = *found;
  dlsi_forces_loose(&kept->body, kept->scratch, &loose);
  return dlsi_certificate_verdict(&loose, tol) != DLS_STALLED;
}

dls_status dlsi_kept_certify(dlsi_kept *kept, const dlsi_operator *H, const double *mu,
                             const double *r, const double *x, double tol, int regular,
                             dls_certificate *certificate, dls_error *error) {
  const dlsi_body *body = kept_body(kept);
  dls_certificate found;
  dlsi_body_measure(body, kept->f, kept->gap, mu, r, x, kept->u, kept->scratch, &found);
  const int none = dlsi_max_abs(r, (size_t)H->d * (size_t)H->candidates) == 0;
  if (kept->has_K && regular && none)
    dlsi_forces_loose(body, kept->scratch, &found); /* K x = f alone */
  else if (kept->has_K && !body->joint && kept_is_open(kept, tol, &found)) {
    const dlsi_own of = {body, kept_solve, kept};
    dls_status status = kept_factor(kept, H, error);
    if (!status)
      status = dlsi_own_measure(&of, kept->f, kept->gap, mu, r, x, kept->u, kept->scratch, &found,
                                error);
    if (status) return status;
  }
  *certificate = found;
  return DLS_OK;
}
