#include "linkage.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

void linkage_new(linkage *L, int d) {
  memset(L, 0, sizeof *L);
  L->d = d;
  L->each = d == 2 ? 3 : 6;
  ck_assert(!dlsi_triplets_alloc(linkage_most, linkage_most, 20000, &L->K, NULL));
  ck_assert(!dlsi_triplets_alloc(linkage_most, 100, 1000, &L->N, NULL));
  ck_assert(!dlsi_triplets_alloc(linkage_most, 200, 2000, &L->T, NULL));
}

void linkage_free(linkage *L) {
  dlsi_triplets_free(&L->K);
  dlsi_triplets_free(&L->N);
  dlsi_triplets_free(&L->T);
  dlsi_columns_free(&L->Kc);
  dlsi_columns_free(&L->Nc);
  dlsi_columns_free(&L->Tc);
  free(L->dense);
  memset(L, 0, sizeof *L);
}

int linkage_body(linkage *L, double mass, double inertia, double weight) {
  const int first = L->n;
  for (int k = 0; k < L->each; k++)
    dlsi_triplets_add(&L->K, first + k, first + k, k < L->d ? mass : inertia);
  L->f[first + L->d - 1] = -weight;
  L->n += L->each;
  return L->bodies++;
}

/* Adds e . (velocity of body b at the offset B), times `sign`, to row or column `at` of t. */
static void add_point(linkage *L, dlsi_triplets *t, int at, int b, const double *B, const double *e,
                      double sign, int by_rows) {
  double row[6] = {0};
  if (b < 0) return;
  for (int k = 0; k < L->d; k++)
    row[k] = e[k];
  if (L->d == 2) row[2] = e[1] * B[0] - e[0] * B[1];
  for (int k = 0; L->d == 3 && k < 3; k++) /* e . (w x B) = w . (B x e) */
    row[3 + k] = B[(k + 1) % 3] * e[(k + 2) % 3] - B[(k + 2) % 3] * e[(k + 1) % 3];
  for (int k = 0; k < L->each; k++) {
    const int j = L->each * b + k;
    if (row[k] != 0) dlsi_triplets_add(t, by_rows ? at : j, by_rows ? j : at, sign * row[k]);
  }
}

int linkage_tie(linkage *L, int a, const double *A, int b, const double *B, const double *e,
                double value) {
  add_point(L, &L->K, L->n, a, A, e, 1, 1);
  add_point(L, &L->K, L->n, b, B, e, -1, 1);
  L->f[L->n] = value;
  return L->n++;
}

int linkage_turn(linkage *L, int a, int b, const double *e) {
  const int body[2] = {a, b};
  for (int s = 0; s < 2; s++)
    for (int k = 0; body[s] >= 0 && k < L->each - L->d; k++)
      dlsi_triplets_add(&L->K, L->n, L->each * body[s] + L->d + k,
                        (s ? -1 : 1) * (L->d == 2 ? 1 : e[k]));
  return L->n++;
}

void linkage_pin(linkage *L, int a, const double *A, int b, const double *B) {
  for (int k = 0; k < L->d; k++) {
    const double e[3] = {k == 0, k == 1, k == 2};
    (void)linkage_tie(L, a, A, b, B, e, 0);
  }
}

void linkage_contact(linkage *L, int a, const double *A) {
  const double up[2][3] = {{0, 1, 0}, {0, 0, 1}}, t[3] = {1, 0, 0}, s[3] = {0, 1, 0};
  const int c = L->contacts++;
  add_point(L, &L->N, c, a, A, up[L->d - 2], 1, 0);
  add_point(L, &L->T, (L->d - 1) * c, a, A, t, 1, 0);
  if (L->d == 3) add_point(L, &L->T, 2 * c + 1, a, A, s, 1, 0);
}

const dls_model *linkage_model(linkage *L, dls_factorization factorization, int is_sparse) {
  const size_t n = (size_t)L->n;
  const int lower = L->K.count;
  ck_assert_int_le(L->n, linkage_most);
  for (int k = 0; k < lower && factorization == DLS_LU; k++)
    if (L->K.row[k] != L->K.col[k]) dlsi_triplets_add(&L->K, L->K.col[k], L->K.row[k], L->K.x[k]);
  L->K.rows = L->K.cols = L->N.rows = L->T.rows = L->n;
  L->N.cols = L->contacts;
  L->T.cols = (L->d - 1) * L->contacts;
  ck_assert(!dlsi_columns_compress(&L->K, 1, DLSI_ALL, &L->Kc, NULL));
  ck_assert(!dlsi_columns_compress(&L->N, 1, DLSI_ALL, &L->Nc, NULL));
  ck_assert(!dlsi_columns_compress(&L->T, 1, DLSI_ALL, &L->Tc, NULL));
  L->dense = calloc(n * n, sizeof *L->dense);
  ck_assert_ptr_nonnull(L->dense);
  for (int k = 0; k < L->K.count; k++)
    L->dense[(size_t)L->K.row[k] + n * (size_t)L->K.col[k]] += L->K.x[k];
  L->K.count = lower;
  L->model = (dls_model){.d = L->d,
                         .n = L->n,
                         .nodes = L->contacts,
                         .operator_kind = is_sparse ? DLS_STIFFNESS_SPARSE : DLS_STIFFNESS_DENSE,
                         .factorization = factorization,
                         .K = {L->n, L->n, L->n, L->dense},
                         .Ks = dlsi_columns_view(&L->Kc),
                         .HN = dlsi_columns_view(&L->Nc),
                         .HT = dlsi_columns_view(&L->Tc)};
  return &L->model;
}

double linkage_apart(const linkage *L, const double *x) {
  const int positions = L->each * L->bodies;
  double e[linkage_most], mass[linkage_most] = {0}, heaviest = 0, scale = 0, worst = 0;
  for (int j = 0; j < L->n; j++)
    e[j] = -L->f[j];
  for (int k = 0; k < L->K.count; k++) {
    if (L->K.row[k] >= positions) e[L->K.row[k]] += L->K.x[k] * x[L->K.col[k]];
    if (L->K.row[k] == L->K.col[k]) mass[L->K.row[k]] += L->K.x[k];
  }
  for (int j = 0; j < positions; j++)
    scale = fmax(scale, fmax(fabs(x[j]), fabs(L->f[j]) / mass[j]));
  for (int j = 0; j < positions; j++)
    heaviest = fmax(heaviest, mass[j]);
  for (int j = positions; j < L->n; j++) {
    scale = fmax(scale, fabs(x[j]) / heaviest); /* large where a linkage is jammed */
    worst = fmax(worst, fabs(e[j]));
  }
  return worst / scale;
}
