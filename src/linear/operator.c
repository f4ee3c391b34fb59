/*
 * operator.c: builds H = L P without what the scene does not need: inactive contacts, and the
 * tangents of contacts without friction. In a scene without friction each contact has one row.
 *
 * H^T is kept by columns, one for each unknown: a part of K then finds its rows of H without a
 * search. Cost: O(nnz H). Fails: no memory, more than INT_MAX entries.
 */
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "linear/operator.h"

/* Copies P and mu of the active contacts. */
static dls_status operator_candidates(dlsi_operator *H, const dls_model *model, int frictionless,
                                      dls_error *error) {
  const dls_sparse *P = &model->P;
  const int all = dlsi_model_candidates(model);
  int entries = 0;
  for (int a = 0; a < all; a++) {
    if (model->active && !model->active[a]) continue;
    if (frictionless && model->mu && model->mu[a] > 0)
      return dlsi_fail(error, DLS_E_ARGUMENT, "mu", a, model->mu[a],
                       "is %g, must be 0 with settings.frictionless", model->mu[a]);
    entries += P->p ? P->p[a + 1] - P->p[a] : 1;
    H->candidates++;
  }
  const int has_mu = frictionless || model->mu;
  H->d = frictionless ? 1 : model->d;
  if (has_mu) H->mu = dlsi_alloc((size_t)H->candidates, sizeof *H->mu);
  const dls_status status = dlsi_columns_alloc(model->nodes, H->candidates, entries, &H->P, error);
  if (status) return status;
  if (has_mu && !H->mu) return dlsi_no_memory(error);
  int c = 0, to = 0;
  for (int a = 0; a < all; a++) {
    if (model->active && !model->active[a]) continue;
    H->P.p[c] = to;
    for (int k = P->p ? P->p[a] : a; k < (P->p ? P->p[a + 1] : a + 1); k++) {
      H->P.i[to] = P->p ? P->i[k] : a;
      H->P.x[to++] = P->p ? P->x[k] : 1;
    }
    if (H->mu) H->mu[c] = frictionless ? 0 : model->mu[a];
    c++;
  }
  H->P.p[c] = to;
  return DLS_OK;
}

/* Lists the entries of H^T column by column of H; returns their number. t: receives them, with
 * enough room; NULL to count only. Sets columns. */
static size_t operator_list(dlsi_operator *H, const dls_model *model, dlsi_triplets *t) {
  const int d = model->d;
  size_t entries = 0;
  H->columns = 0;
  for (int c = 0; c < H->candidates; c++)
    for (int i = 0; i < (dlsi_has_tangents(H, c) ? d : 1); i++) { /* n, then the tangents */
      const dls_sparse *L = i == 0 ? &model->HN : &model->HT;
      const size_t before = entries;
      for (int k = H->P.p[c]; k < H->P.p[c + 1]; k++) {
        const int column = i == 0 ? H->P.i[k] : (d - 1) * H->P.i[k] + i - 1;
        entries += (size_t)(L->p[column + 1] - L->p[column]);
        for (int e = L->p[column]; t && e < L->p[column + 1]; e++)
          dlsi_triplets_add(t, H->d * c + i, L->i[e], H->P.x[k] * L->x[e]);
      }
      H->columns += entries > before;
    }
  return entries;
}

dls_status dlsi_operator_create(dlsi_operator *H, const dls_model *model, int frictionless,
                                dls_error *error) {
  *H = (dlsi_operator){0};
  dls_status status = operator_candidates(H, model, frictionless, error);
  if (status) return status;
  const size_t entries = operator_list(H, model, NULL);
  dlsi_triplets t;
  status = dlsi_triplets_alloc(H->d * H->candidates, model->n, entries, &t, error);
  if (!status) {
    (void)operator_list(H, model, &t);
    status = dlsi_columns_compress(&t, 1, DLSI_ALL, &H->Ht, error);
  }
  dlsi_triplets_free(&t);
  H->keep = dlsi_alloc((size_t)model->n, sizeof *H->keep);
  if (status) return status;
  if (!H->keep) return dlsi_no_memory(error);
  for (int i = 0; i < model->n; i++)
    if (H->Ht.p[i] < H->Ht.p[i + 1]) H->keep[H->kept++] = i;
  return DLS_OK;
}

dls_status dlsi_operator_columns(const dlsi_operator *H, int d, dlsi_part which, dlsi_columns *out,
                                 dls_error *error) {
  const dlsi_columns *Ht = &H->Ht;
  const int n = Ht->cols;
  dlsi_triplets t;
  *out = (dlsi_columns){0};
  dls_status status = dlsi_triplets_alloc(n, d * H->candidates, (size_t)Ht->p[n], &t, error);
  for (int j = 0; !status && j < n; j++)
    for (int e = Ht->p[j]; e < Ht->p[j + 1]; e++)
      dlsi_triplets_add(&t, j, d * (Ht->i[e] / H->d) + Ht->i[e] % H->d, Ht->x[e]);
  if (!status) status = dlsi_columns_compress(&t, d, which, out, error);
  dlsi_triplets_free(&t);
  return status;
}

void dlsi_operator_free(dlsi_operator *H) {
  dlsi_columns_free(&H->P);
  dlsi_columns_free(&H->Ht);
  free(H->mu);
  free(H->keep);
  *H = (dlsi_operator){0};
}

void dlsi_operator_add(const dlsi_operator *H, const int *unknown, size_t s, const double *x,
                       double *y) {
  for (size_t i = 0; i < s; i++)
    for (int e = H->Ht.p[unknown[i]]; e < H->Ht.p[unknown[i] + 1]; e++)
      y[H->Ht.i[e]] += H->Ht.x[e] * x[i];
}
