/*
 * order.c: an order of the candidates that follows from the data and not from their numbers.
 *
 * Gauss-Seidel, and after it everything that starts from its answer, depends on the order of the
 * candidates. In this one a permuted problem takes the same sweeps.
 *
 *   (O1)  by q_n / w, |q_t| / w, w, mu, the smaller first: what approaches fastest; then as numbered
 *   (O2)  W dense: the first of (O1); then always the candidate j with the largest sum |W_nn(j, c)|
 *         over the c that have their place; of several the first of (O1)
 *
 * w are the weights of the certificate. Numbers count to 26 bits: other units, other tangents or the
 * two halves of a symmetric body must not be told apart by their rounding.
 *
 * What (O1) does not tell apart, the bricks of a wall for instance, keeps its order: there a permuted
 * problem may take other sweeps. (O2) walks from neighbour to neighbour, as meshes are numbered.
 *
 * Cost: a sort; (O2): nc^2 / 2 entries of W are read.
 */
#include <math.h>
#include <string.h>

#include "front/front.h"

/* the first 26 bits (Dekker) */
static double rounded(double x) {
  const double c = 0x1.000002p+27 * x;
  return c - (c - x);
}

/* of (O1), nc each */
typedef struct ranks {
  double *approach, *slip, *weight;
  const double *mu;
} ranks;

static void make_ranks(const dls_contact *problem, const ranks *key) {
  dlsi_contact_weights(problem, key->weight);
  const double *q = problem->q;
  for (int c = 0; c < problem->nc; c++, q += problem->d) {
    const double w = key->weight[c];
    key->approach[c] = rounded(q[0] / w);
    key->slip[c] = rounded(dlsi_tangent_norm(problem->d, q) / w);
    key->weight[c] = rounded(w);
  }
}

/* a before b */
static int precedes(const ranks *key, int a, int b) {
  if (key->approach[a] != key->approach[b]) return key->approach[a] < key->approach[b];
  if (key->slip[a] != key->slip[b]) return key->slip[a] < key->slip[b];
  if (key->weight[a] != key->weight[b]) return key->weight[a] < key->weight[b];
  return key->mu[a] < key->mu[b];
}

/* order (n) sorted, equals as they are; scratch (n). qsort may allocate, and is not stable. */
static void merge_sort(const ranks *key, int n, int *order, int *scratch) {
  if (n < 2) return;
  const int half = n / 2;
  merge_sort(key, half, order, scratch);
  merge_sort(key, n - half, order + half, scratch);
  memcpy(scratch, order, (size_t)half * sizeof *order);
  for (int a = 0, b = half, k = 0; a < half; k++)
    order[k] = b < n && precedes(key, order[b], scratch[a]) ? order[b++] : scratch[a++];
}

/* (O2); order in: (O1). coupling_k (nc) belongs to candidate order[k], as long as it has no place. */
static void walk(const dls_contact *problem, double *coupling, int *order) {
  const size_t d = (size_t)problem->d, ld = (size_t)problem->W.ld;
  const int nc = problem->nc;
  memset(coupling, 0, (size_t)nc * sizeof *coupling);
  for (int k = 1; k < nc; k++) { /* order[0 .. k-1] have their places */
    const double *W = problem->W.a + d * (size_t)order[k - 1] * ld;
    double most = -1;
    int next = k;
    for (int j = k; j < nc; j++) {
      coupling[j] += fabs(W[d * (size_t)order[j]]);
      const double x = rounded(coupling[j]);
      if (!(x > most)) continue;
      most = x;
      next = j;
    }
    const int c = order[next];
    const size_t moved = (size_t)(next - k);
    memmove(order + k + 1, order + k, moved * sizeof *order);
    memmove(coupling + k + 1, coupling + k, moved * sizeof *coupling);
    order[k] = c;
  }
}

void dlsi_order_candidates(const dls_contact *problem, double *work, int *scratch, int *order) {
  const size_t nc = (size_t)problem->nc;
  const ranks key = {work, work + nc, work + 2 * nc, problem->mu};
  for (int c = 0; c < problem->nc; c++)
    order[c] = c;
  if (nc == 1) return;
  make_ranks(problem, &key);
  merge_sort(&key, problem->nc, order, scratch);
  if (!problem->Wb.x) walk(problem, work, order);
}
