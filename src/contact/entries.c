/*
 * entries.c: K of a model, dense or sparse, entry by entry, and products with it; rows of H^T x and
 * r that other ranks have.
 *
 * Cost: that of the entries. Cannot fail.
 */
#include <string.h>

#include "body.h"

int dlsi_body_entry(const dls_model *model, int j, int *at, int *row, double *value) {
  const int lower = model->factorization != DLS_LU;
  if (model->operator_kind == DLS_STIFFNESS_DENSE) {
    if (lower && *at < j) *at = j;
    if (*at >= model->n) return 0;
    *row = *at;
    *value = model->K.a[(size_t)*at + (size_t)j * (size_t)model->K.ld];
    ++*at;
    return 1;
  }
  const dls_sparse *K = &model->Ks;
  while (lower && K->p[j] + *at < K->p[j + 1] && K->i[K->p[j] + *at] < j)
    ++*at;
  if (K->p[j] + *at >= K->p[j + 1]) return 0;
  *row = K->i[K->p[j] + *at];
  *value = K->x[K->p[j] + *at];
  ++*at;
  return 1;
}

double dlsi_body_diagonal(const dls_model *model, int j) {
  double v, sum = 0;
  for (int at = 0, i; dlsi_body_entry(model, j, &at, &i, &v);)
    sum += i == j ? v : 0;
  return sum;
}

void dlsi_body_multiply(const dls_model *model, const double *x, double *y, double *a) {
  const size_t n = (size_t)model->n;
  const int symmetric = model->factorization != DLS_LU;
  memset(y, 0, n * sizeof *y);
  if (a) memset(a, 0, n * sizeof *a);
  for (int j = 0; j < model->n; j++) {
    double sum = 0, size = 0, v;
    for (int at = 0, i; dlsi_body_entry(model, j, &at, &i, &v);) {
      y[i] += v * x[j];
      if (a) a[i] += fabs(v * x[j]);
      if (!symmetric || i == j) continue;
      sum += v * x[i];
      size += fabs(v * x[i]);
    }
    y[j] += sum;
    if (a) a[j] += size;
  }
}

/* ---- rows of other ranks --------------------------------------------------------------------- */

const double *dlsi_body_fetch(const dlsi_body *body, const double *r) {
  if (!body->ranks) return r;
  double *all = body->ranks->scratch;
  memcpy(all, r, (size_t)(body->d * body->nc) * sizeof *r);
  body->ranks->fetch(body->ranks->data, all);
  return all;
}

double *dlsi_body_reach(const dlsi_body *body, double *u) {
  if (!body->ranks) return u;
  double *all = body->ranks->scratch;
  memset(all, 0, body->ranks->reach * sizeof *all);
  memcpy(all, u, (size_t)(body->d * body->nc) * sizeof *u);
  return all;
}

void dlsi_body_give(const dlsi_body *body, dlsi_how how, double *all, double *u) {
  if (!body->ranks) return;
  body->ranks->give(body->ranks->data, how, all);
  if (all != u) memcpy(u, all, (size_t)(body->d * body->nc) * sizeof *u);
}
