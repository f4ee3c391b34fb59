/*
 * subset.c: some contacts of a contact problem as a smaller problem.
 *
 *   W' = W(s, s),  q' = q(s),  mu' = mu(s), weights alike     for the list s, which ascends
 *
 * Cost: O(d^2 count^2), or O(blocks in the columns of s, times log count), after the check of the
 * whole problem. Fails: on its arguments only.
 */
#include <string.h>

#include "contact.h"

/* Checks that the list ascends within 0 .. nc-1. */
static dls_status subset_check(const dls_contact *problem, int count, const int *candidate,
                               dls_error *error) {
  if (count < 0 || count > problem->nc)
    return dlsi_fail(error, DLS_E_SIZE, "count", -1, count, "is %d, must be from 0 to %d", count,
                     problem->nc);
  if (count > 0 && !candidate) return dlsi_is_null(error, "candidate");
  for (int k = 0; k < count; k++) {
    if (candidate[k] < 0 || candidate[k] >= problem->nc)
      return dlsi_fail(error, DLS_E_ARGUMENT, "candidate", k, candidate[k], "is outside of 0 .. %d",
                       problem->nc - 1);
    if (k > 0 && candidate[k] <= candidate[k - 1])
      return dlsi_fail(error, DLS_E_ARGUMENT, "candidate", k, candidate[k],
                       "does not ascend: comes after %d", candidate[k - 1]);
  }
  return DLS_OK;
}

/* Copies W(s, s) to W', (d count) x (d count), and returns the end of it. */
static double *subset_dense(const dls_contact *problem, int count, const int *candidate,
                            double *W) {
  const size_t d = (size_t)problem->d, ld = (size_t)problem->W.ld;
  for (int b = 0; b < count; b++)
    for (size_t j = 0; j < d; j++) {
      const double *column = problem->W.a + (d * (size_t)candidate[b] + j) * ld;
      for (int a = 0; a < count; a++, W += d)
        memcpy(W, column + d * (size_t)candidate[a], d * sizeof *W);
    }
  return W;
}

/* Copies the blocks of W(s, s), in the order of W, and returns the end of the values. index: count
 * + 1 starts, then the block rows. */
static double *subset_blocks(const dls_contact *problem, int count, const int *candidate, double *x,
                             int *index, dls_blocks *B) {
  const dls_blocks *all = &problem->Wb;
  const size_t entries = (size_t)(problem->d * problem->d);
  int *row = index + count + 1, blocks = 0;
  *B = (dls_blocks){.d = problem->d, .n = count, .p = index, .i = row, .x = x};
  for (int b = 0; b < count; b++) {
    index[b] = blocks;
    for (int k = all->p[candidate[b]]; k < all->p[candidate[b] + 1]; k++) {
      const int place = dlsi_find(candidate, count, all->i[k]);
      if (place < 0) continue;
      row[blocks++] = place;
      memcpy(x, all->x + entries * (size_t)k, entries * sizeof *x);
      x += entries;
    }
  }
  index[count] = blocks;
  return x;
}

/* Copies the bodies of the contacts and their H, and returns the end of the values. */
static double *subset_bodies(const dls_contact *problem, int count, const int *candidate, double *x,
                             int *index, dls_bodies *B) {
  const size_t size = 2 * (size_t)problem->bodies.n * (size_t)problem->d;
  *B = problem->bodies;
  B->body = index;
  B->H = x;
  for (int k = 0; k < count; k++) {
    memcpy(index + 2 * k, problem->bodies.body + 2 * (size_t)candidate[k], 2 * sizeof *index);
    memcpy(x + size * (size_t)k, problem->bodies.H + size * (size_t)candidate[k], size * sizeof *x);
  }
  return x + size * (size_t)count;
}

void dlsi_subset(const dls_contact *problem, int count, const int *candidate, double *values,
                 int *index, dls_contact *subset) {
  const size_t d = (size_t)problem->d, n = (size_t)count;
  const int m = problem->d * count, of_bodies = problem->bodies.H != NULL;
  dls_contact made = {.d = problem->d, .nc = count};
  double *q = of_bodies ? subset_bodies(problem, count, candidate, values, index, &made.bodies)
              : problem->Wb.x ? subset_blocks(problem, count, candidate, values, index, &made.Wb)
                              : subset_dense(problem, count, candidate, values);
  if (!problem->Wb.x && !of_bodies) made.W = (dls_dense){m, m, m, values};
  double *mu = q + d * n;
  for (size_t k = 0; k < n; k++) {
    memcpy(q + d * k, problem->q + d * (size_t)candidate[k], d * sizeof *q);
    mu[k] = problem->mu[candidate[k]];
  }
  made.q = q;
  made.mu = mu;
  made.weights = problem->weights ? mu + n : NULL;
  for (size_t k = 0; k < n && made.weights; k++)
    memcpy(mu + n + 2 * k, problem->weights + 2 * (size_t)candidate[k], 2 * sizeof *mu);
  *subset = made;
}

static dls_status contact_subset(const dls_contact *problem, int count, const int *candidate,
                                 double *values, int *index, dls_contact *subset,
                                 dls_error *error) {
  dls_status status = dlsi_check_contact(problem, error);
  if (!status) status = subset_check(problem, count, candidate, error);
  if (status) return status;
  const int by_blocks = problem->Wb.x != NULL, of_bodies = problem->bodies.H != NULL;
  if (count > 0 && !values) return dlsi_is_null(error, "values");
  if (count > 0 && (by_blocks || of_bodies) && !index) return dlsi_is_null(error, "index");
  if (!subset) return dlsi_is_null(error, "subset");
  if (count > 0)
    dlsi_subset(problem, count, candidate, values, index, subset);
  else
    *subset = (dls_contact){.d = problem->d};
  return DLS_OK;
}

dls_status dls_contact_subset(const dls_contact *problem, int count, const int *candidate,
                              double *values, int *index, dls_contact *subset, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, contact_subset(problem, count, candidate, values, index, subset, error),
                 error);
}
