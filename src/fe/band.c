/*
 * band.c: assembles, supports, factors and solves banded matrices in LAPACK's storage.
 *
 * Entry (i, j), |i - j| <= k, is at a[2k + i - j + (3k + 1) j]; the first k rows are room for the
 * fill of row exchanges. Prescribed unknowns stay in the matrix as decoupled rows: numbering and
 * storage are made once.
 * Cost of the LU: 4 n k^2 operations at most, of a solve: 6 n k. What can fail: a singular matrix.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "linear/blas.h"
#include "solid.h"

int dlsi_band_create(dlsi_band *band, int n, int k) {
  const size_t entries = (3 * (size_t)k + 1) * (size_t)n;
  *band = (dlsi_band){.n = n, .k = k};
  band->a = dlsi_alloc(entries, sizeof *band->a);
  band->lu = dlsi_alloc(entries, sizeof *band->lu);
  band->pivot = dlsi_alloc((size_t)n, sizeof *band->pivot);
  return band->a && band->lu && band->pivot;
}

void dlsi_band_free(dlsi_band *band) {
  free(band->a);
  free(band->lu);
  free(band->pivot);
  *band = (dlsi_band){0};
}

void dlsi_band_clear(dlsi_band *band) {
  memset(band->a, 0, (3 * (size_t)band->k + 1) * (size_t)band->n * sizeof *band->a);
}

void dlsi_band_support(dlsi_band *band, int j, double value, double *f) {
  const int first = j > band->k ? j - band->k : 0;
  const int last = j + band->k < band->n - 1 ? j + band->k : band->n - 1;
  double *a = band->a;
  const double diagonal = fabs(a[dlsi_band_at(band, j, j)]);
  for (int i = first; i <= last; i++) {
    f[i] -= a[dlsi_band_at(band, i, j)] * value;
    a[dlsi_band_at(band, i, j)] = a[dlsi_band_at(band, j, i)] = 0;
  }
  a[dlsi_band_at(band, j, j)] = diagonal;
  f[j] = diagonal * value;
}

void dlsi_band_load(dlsi_band *band) {
  memcpy(band->lu, band->a, (3 * (size_t)band->k + 1) * (size_t)band->n * sizeof *band->a);
}

int dlsi_band_factor(dlsi_band *band) {
  const int n = band->n, k = band->k, ld = 3 * k + 1;
  int info = 0;
  dgbtrf_(&n, &n, &k, &k, band->lu, &ld, band->pivot, &info);
  return info == 0;
}

int dlsi_band_solve(void *band_, double *X, int n, int count) {
  const dlsi_band *band = band_;
  const int k = band->k, ld = 3 * k + 1;
  int info = 0;
  dgbtrs_("N", &n, &k, &k, &count, band->lu, &ld, band->pivot, X, &n, &info, 1);
  return info;
}
