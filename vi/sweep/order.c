/*
 * order.c: orders the contacts by the data, not by their numbers.
 *
 * Gauss-Seidel depends on the order of the contacts, and so does every method that starts from its
 * answer. Visited in this order, a permuted problem takes the same sweeps.
 *
 *   (OR1)  by q_n / w, |q_t| / w, w, mu, the smaller first: the fastest approach first; equals as
 *          numbered
 *   (OR2)  W of elastic bodies: the first of (OR1); then always the contact j with the largest
 *          sum |W_nn(j, c)| over the c already placed; of equals the first of (OR1)
 *
 * w are the weights of the certificate. Numbers count to 26 bits, so that rounding does not
 * separate other units, other tangents or the two halves of a symmetric body.
 *
 * Contacts that are equal by (OR1), such as the bricks of a wall, keep their order: a permuted
 * problem may then take other sweeps. (OR2) walks from neighbour to neighbour, as meshes are
 * numbered.
 *
 * Cost: a sort; (OR2) reads nc^2 / 2 entries of W.
 */
#include <math.h>
#include <string.h>

#include "vi/vi_internal.h"

enum { few_candidates = 100 }; /* one rigid body couples all its contacts */

/* Returns x rounded to 26 bits (Dekker). */
static double order_rounded(double x) {
  const double c = 0x1.000002p+27 * x;
  return c - (c - x);
}

/* Keys of (OR1). */
typedef struct order_keys {
  double *approach, *slip, *weight; /* q_n / w, |q_t| / w, w: nc each */
  const double *mu;                 /* nc */
} order_keys;

static void order_set_keys(const dls_contact *problem, const order_keys *key) {
  dlsi_contact_weights(problem, key->weight);
  const double *q = problem->q;
  for (int c = 0; c < problem->nc; c++, q += problem->d) {
    const double w = key->weight[c];
    key->approach[c] = order_rounded(q[0] / w);
    key->slip[c] = order_rounded(dlsi_tangent_norm(problem->d, q) / w);
    key->weight[c] = order_rounded(w);
  }
}

/* Returns 1 if contact a comes before b by (OR1). */
static int order_precedes(const order_keys *key, int a, int b) {
  if (key->approach[a] != key->approach[b]) return key->approach[a] < key->approach[b];
  if (key->slip[a] != key->slip[b]) return key->slip[a] < key->slip[b];
  if (key->weight[a] != key->weight[b]) return key->weight[a] < key->weight[b];
  return key->mu[a] < key->mu[b];
}

/* Sorts order (n) and is stable; qsort is not, and may allocate. scratch: n. */
static void order_sort(const order_keys *key, int n, int *order, int *scratch) {
  if (n < 2) return;
  const int half = n / 2;
  order_sort(key, half, order, scratch);
  order_sort(key, n - half, order + half, scratch);
  memcpy(scratch, order, (size_t)half * sizeof *order);
  for (int a = 0, b = half, k = 0; a < half; k++)
    order[k] = b < n && order_precedes(key, order[b], scratch[a]) ? order[b++] : scratch[a++];
}

/* Adds |W_nn(j, c)| to coupling[j] for all j, or for those of order[from], order[from + 1], .. */
static void order_couple(const dls_contact *problem, int c, const int *order, int from,
                         double *coupling) {
  const size_t d = (size_t)problem->d;
  const dls_blocks *B = &problem->Wb;
  if (B->x) {
    for (int k = B->p[c]; k < B->p[c + 1]; k++)
      coupling[B->i[k]] += fabs(B->x[d * d * (size_t)k]);
    return;
  }
  const double *W = problem->W.a + d * (size_t)c * (size_t)problem->W.ld;
  for (int j = from; j < problem->nc; j++)
    coupling[order[j]] += fabs(W[d * (size_t)order[j]]);
}

/* Turns order from (OR1) into (OR2). coupling: scratch, nc. */
static void order_walk(const dls_contact *problem, double *coupling, int *order) {
  const int nc = problem->nc;
  memset(coupling, 0, (size_t)nc * sizeof *coupling);
  for (int k = 1; k < nc; k++) { /* order[0 .. k-1] have their places */
    double most = -1;
    int next = k;
    order_couple(problem, order[k - 1], order, k, coupling);
    for (int j = k; j < nc; j++) {
      const double x = order_rounded(coupling[order[j]]);
      if (!(x > most)) continue;
      most = x;
      next = j;
    }
    const int c = order[next];
    memmove(order + k + 1, order + k, (size_t)(next - k) * sizeof *order);
    order[k] = c;
  }
}

/* Returns 1 if W is dense, or has at least 25 % of all blocks. */
static int is_full(const dls_contact *problem) {
  const double nc = problem->nc;
  return problem->W.a || (problem->Wb.x && problem->Wb.p[problem->nc] >= nc * nc / 4);
}

int dlsi_is_elastic(const dls_contact *problem) {
  return problem->W.a || (problem->nc > few_candidates && is_full(problem));
}

void dlsi_order_candidates(const dls_contact *problem, double *const key[3], int *scratch,
                           int *order) {
  const order_keys keys = {key[0], key[1], key[2], problem->mu};
  for (int c = 0; c < problem->nc; c++)
    order[c] = c;
  if (problem->nc == 1) return;
  order_set_keys(problem, &keys);
  order_sort(&keys, problem->nc, order, scratch);
  if (dlsi_is_elastic(problem)) order_walk(problem, key[0], order);
}
