/*
 * joints.c: solves with W + R, R = diag(rho_c), of rigid structures by a matrix of fewer unknowns.
 *
 *   (JO1)  A joint j: contacts with the same neighbours in W, the corners of two faces that
 *          touch. W_jj = L L^T by pivoted Cholesky, L of full rank; Q_j: an orthonormal basis of L.
 *          Two bodies have 3 or 6 motions relative to each other, while the corners of their
 *          faces have 4 or 12 unknowns. W is semidefinite, so that W = Q W' Q^T with W' = Q^T W Q.
 *   (JO2)  B = Q^T R^-1 Q, a block per joint;  W' + B^-1 = L L^T, sparse
 *   (JO3)  (W + R) x = R p - Q g:   (W' + B^-1) s = B^-1 Q^T p - g,
 *                                   x = p - R^-1 Q B^-1 (Q^T p - s)
 *
 * (JO3) uses W x = Q W' Q^T x with s = Q^T x. No term is divided by a small rho alone: the part of
 * x that W maps to 0 is that of p, to its last digit.
 *
 * If every joint has as many motions as unknowns, Q = I, and W' + B^-1 = W + R.
 * Cost: 1/2 of the unknowns of a wall or a tower in 3D, 1/8 of the work to factorise; 3/4 of the
 * unknowns in 2D.
 * What can fail: memory; a W that is not symmetric and semidefinite, which a product detects.
 */
#include "joints.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "linear/dense.h"
#include "linear/dissection.h"
#include "vi/vi_internal.h"

enum { joint_most = 8, joint_unknowns = 3 * joint_most }; /* contacts: a brick has four corners */
static const double joint_rank = 1e-12;    /* of the largest pivot; smaller ones are rounding */
static const double joint_rest = 1e-12;    /* of the largest entry of v; smaller is rounding */
static const double joint_profile = 2;     /* joints_in_order */
static const double joint_mismatch = 1e-8; /* of W, over its entries; the certificate shows less */

/* ---- (JO1) ----------------------------------------------------------------------------------- */

/* Returns a number that columns of W with equal rows share. */
static uint64_t joint_hash(const dls_blocks *W, int c) {
  uint64_t sum = 0;
  for (int k = W->p[c]; k < W->p[c + 1]; k++)
    sum += dlsi_mix((uint64_t)W->i[k] + 1);
  return sum;
}

/* Returns 1 if all rows of column c are marked as those of contact `of`. */
static int joint_alike(const dls_blocks *W, int c, int of, const int *mark) {
  for (int k = W->p[c]; k < W->p[c + 1]; k++)
    if (mark[W->i[k]] != of) return 0;
  return 1;
}

/* Fills count, joint, place, first, list. hash, mark: scratch, nc. */
static void joints_find(dlsi_joints *work, const dls_blocks *W, uint64_t *hash, int *mark) {
  int *size = work->first; /* then shifted by one */
  for (int c = 0; c < work->nc; c++) {
    hash[c] = joint_hash(W, c);
    mark[c] = -1;
  }
  for (int c = 0; c < work->nc; c++) {
    int j = -1;
    for (int k = W->p[c]; k < W->p[c + 1]; k++)
      mark[W->i[k]] = c;
    for (int k = W->p[c]; j < 0 && k < W->p[c + 1]; k++) {
      const int e = W->i[k];
      if (e < c && hash[e] == hash[c] && W->p[e + 1] - W->p[e] == W->p[c + 1] - W->p[c] &&
          size[work->joint[e]] < joint_most && joint_alike(W, e, c, mark))
        j = work->joint[e];
    }
    if (j < 0) size[j = work->count++] = 0;
    work->joint[c] = j;
    work->place[c] = size[j]++;
  }
  for (int j = 0, at = 0; j <= work->count; j++) {
    const int next = j < work->count ? at + size[j] : at;
    work->first[j] = at;
    at = next;
  }
  for (int c = 0; c < work->nc; c++)
    work->list[work->first[work->joint[c]] + work->place[c]] = c;
}

/* Computes Q of a joint from its A = W_jj, n x n, which it overwrites. Returns the rank. */
static int joint_range(int n, double *A, double *Q) {
  int rank = 0;
  double largest = 0;
  for (; rank < n; rank++) {
    int p = 0;
    for (int i = 1; i < n; i++)
      if (A[i * (n + 1)] > A[p * (n + 1)]) p = i;
    const double pivot = A[p * (n + 1)];
    if (rank == 0) largest = pivot;
    if (!(pivot > joint_rank * largest)) break;
    double *q = Q + rank * n;
    for (int i = 0; i < n; i++)
      q[i] = A[i + n * p] / sqrt(pivot);
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++)
        A[i + n * j] -= q[i] * q[j];
  }
  for (int k = 0; k < rank; k++) { /* Gram-Schmidt, twice, which is enough */
    double *q = Q + k * n, size = 0;
    for (int twice = 0; twice < 2; twice++)
      for (int l = 0; l < k; l++) {
        const double *p = Q + l * n;
        double dot = 0;
        for (int i = 0; i < n; i++)
          dot += p[i] * q[i];
        for (int i = 0; i < n; i++)
          q[i] -= dot * p[i];
      }
    for (int i = 0; i < n; i++)
      size += q[i] * q[i];
    for (int i = 0; i < n; i++)
      q[i] /= sqrt(size);
  }
  for (int i = 0; rank == n && i < n * n; i++)
    Q[i] = i % (n + 1) == 0;
  return rank;
}

static int joint_size(const dlsi_joints *work, int j) {
  return work->d * (work->first[j + 1] - work->first[j]);
}

/* The blocks of W between a joint and its neighbours: a panel of side^2 for each. */
typedef struct joints_row {
  int count, side; /* side: unknowns of the largest joint */
  int *joint;      /* of each panel */
  int *slot;       /* count of all joints: the panel of a joint */
  double *panel;
} joints_row;

/* Gathers S W S / unit of joint J with itself and the joints after it. */
static void joints_gather(const dlsi_joints *work, const dls_contact *problem, const double *S,
                          double unit, int J, joints_row *to) {
  const int d = work->d, ld = to->side;
  const dls_blocks *W = &problem->Wb;
  const size_t panel_size = (size_t)(ld * ld);
  to->count = 0;
  for (int l = work->first[J]; l < work->first[J + 1]; l++) {
    const int c = work->list[l];
    for (int k = W->p[c]; k < W->p[c + 1]; k++) {
      const int e = W->i[k], I = work->joint[e];
      if (I < J) continue;
      if (to->slot[I] >= to->count || to->joint[to->slot[I]] != I) {
        to->slot[I] = to->count;
        to->joint[to->count] = I;
        memset(to->panel + panel_size * (size_t)to->count++, 0, panel_size * sizeof *to->panel);
      }
      double *A = to->panel + panel_size * (size_t)to->slot[I];
      const double *x = W->x + (size_t)(d * d) * (size_t)k;
      for (int j = 0; j < d; j++)
        for (int i = 0; i < d; i++)
          A[d * work->place[e] + i + ld * (d * work->place[c] + j)] +=
              S[d * e + i] * (S[d * c + j] / unit) * x[i + d * j];
    }
  }
}

/* Computes Q of all joints. */
static void joints_bases(dlsi_joints *work, const dls_contact *problem, const double *S,
                         double unit, joints_row *scratch) {
  const int ld = scratch->side;
  size_t basis = 0, inverse = 0;
  for (int J = 0; J < work->count; J++) {
    const int n = joint_size(work, J);
    double A[joint_unknowns * joint_unknowns];
    joints_gather(work, problem, S, unit, J, scratch);
    const double *own = scratch->panel + (size_t)scratch->slot[J] * (size_t)(ld * ld);
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++)
        A[i + n * j] = own[i + ld * j];
    work->basis[J] = basis;
    work->inverse[J] = inverse;
    work->at[J] = work->n;
    work->rank[J] = joint_range(n, A, work->Q + basis);
    work->n += work->rank[J];
    basis += (size_t)(n * work->rank[J]);
    inverse += (size_t)(work->rank[J] * work->rank[J]);
  }
}

static void joints_put(dlsi_joints *work, int i, int j, double value) {
  work->row[work->entries] = i + 1;
  work->col[work->entries] = j + 1;
  work->value[work->entries++] = value;
}

/* Lists B^-1 and W'. */
static void joints_list(dlsi_joints *work, const dls_contact *problem, const double *S, double unit,
                        joints_row *scratch) {
  const int ld = scratch->side;
  work->entries = 0;
  for (int J = 0; J < work->count; J++)
    for (int j = 0; j < work->rank[J]; j++)
      for (int i = j; i < work->rank[J]; i++)
        joints_put(work, work->at[J] + i, work->at[J] + j, 0);
  for (int J = 0; J < work->count; J++) {
    const int nJ = joint_size(work, J), rJ = work->rank[J];
    const double *QJ = work->Q + work->basis[J];
    joints_gather(work, problem, S, unit, J, scratch);
    for (int s = 0; s < scratch->count; s++) {
      const int I = scratch->joint[s], nI = joint_size(work, I), rI = work->rank[I];
      const double *A = scratch->panel + (size_t)s * (size_t)(ld * ld),
                   *QI = work->Q + work->basis[I];
      for (int j = 0; j < rJ; j++) {
        double v[joint_unknowns] = {0};
        for (int k = 0; k < nJ; k++)
          for (int i = 0; i < nI; i++)
            v[i] += A[i + ld * k] * QJ[k + nJ * j];
        for (int i = I == J ? j : 0; i < rI; i++) {
          double sum = 0;
          for (int k = 0; k < nI; k++)
            sum += QI[k + nI * i] * v[k];
          joints_put(work, work->at[I] + i, work->at[J] + j, sum);
        }
      }
    }
  }
}

/* ---- products with Q ------------------------------------------------------------------------- */

/* motions := Q^T v */
static void joints_fold(const dlsi_joints *work, const double *v, double *motions) {
  const int d = work->d;
  for (int J = 0; J < work->count; J++) {
    const int n = joint_size(work, J), *list = work->list + work->first[J];
    const double *q = work->Q + work->basis[J];
    for (int k = 0; k < work->rank[J]; k++) {
      double sum = 0;
      for (int i = 0; i < n; i++)
        sum += *q++ * v[d * list[i / d] + i % d];
      motions[work->at[J] + k] = sum;
    }
  }
}

/* v := v - Q motions, entries of contact c over rho_c; rho NULL: 1 */
static void joints_unfold(const dlsi_joints *work, const double *motions, const double *rho,
                          double *v) {
  const int d = work->d;
  for (int J = 0; J < work->count; J++) {
    const int n = joint_size(work, J), *list = work->list + work->first[J];
    const double *Q = work->Q + work->basis[J], *y = motions + work->at[J];
    for (int i = 0; i < n; i++) {
      const int c = list[i / d];
      double sum = 0;
      for (int k = 0; k < work->rank[J]; k++)
        sum += Q[i + n * k] * y[k];
      v[d * c + i % d] -= rho ? sum / rho[c] : sum;
    }
  }
}

void dlsi_joints_split(const dlsi_joints *work, double *v, double *motions) {
  const size_t m = (size_t)(work->d * work->nc);
  const double size = dlsi_max_abs(v, m);
  joints_fold(work, v, motions);
  joints_unfold(work, motions, NULL, v);
  for (size_t i = 0; i < m; i++)
    if (fabs(v[i]) <= joint_rest * size) v[i] = 0;
}

/* Returns 1 if W g = Q W' Q^T g for a patternless g, with W' from its lower triangle.
 * scratch: 3 m. */
static int joints_match(const dlsi_joints *work, const dls_contact *problem, const double *S,
                        double unit, double *scratch) {
  const int m = work->d * work->nc;
  double *g = scratch, *Sg = g + m, *Wg = Sg + m;
  for (int i = 0; i < m; i++) {
    const double golden = 0.6180339887498949 * (i + 1);
    g[i] = golden - floor(golden) - 0.5;
    Sg[i] = S[i] * g[i];
  }
  dlsi_contact_apply(problem, Sg, Wg);
  for (int i = 0; i < m; i++)
    Wg[i] *= S[i] / unit;
  const double size = dlsi_max_abs(Wg, (size_t)m);
  joints_fold(work, g, work->c);
  memset(work->s, 0, (size_t)work->n * sizeof *work->s);
  for (size_t k = 0; k < work->entries; k++) { /* the values of B^-1 are still 0 */
    const int i = work->row[k] - 1, j = work->col[k] - 1;
    work->s[i] += work->value[k] * work->c[j];
    if (i != j) work->s[j] += work->value[k] * work->c[i];
  }
  joints_unfold(work, work->s, NULL, Wg);
  return dlsi_max_abs(Wg, (size_t)m) <= joint_mismatch * size;
}

/* ---- create ---------------------------------------------------------------------------------- */

/* Returns 1 if the numbers of the joints are a good order already: the rows of the factor, from
 * their first entries on, have at most twice the entries of W'. first: scratch, n. */
static int joints_in_order(const dlsi_joints *work, int *first) {
  double profile = 0;
  for (int i = 0; i < work->n; i++)
    first[i] = i;
  for (size_t k = 0; k < work->entries; k++)
    if (work->col[k] - 1 < first[work->row[k] - 1]) first[work->row[k] - 1] = work->col[k] - 1;
  for (int i = 0; i < work->n; i++)
    profile += i - first[i] + 1;
  return profile <= joint_profile * (double)work->entries;
}

/* Orders and analyses the matrix of (JO2). A chain, a tower or an arch is in a good order, which
 * METIS would take as long to find as all the rest takes. DLS_E_MEMORY. */
static dls_status joints_analyse(dlsi_joints *work, dls_error *error) {
  const size_t n = (size_t)work->n;
  int *order = dlsi_alloc(2 * n, sizeof *order), *turn = order + n;
  if (!order) return dlsi_no_memory(error);
  dls_status status = DLS_OK;
  if (joints_in_order(work, order))
    for (size_t i = 0; i < n; i++)
      order[i] = (int)i;
  else
    status = dlsi_dissection(work->n, work->entries, work->row, work->col, order, error);
  for (size_t i = 0; !status && i < n; i++)
    turn[order[i]] = (int)i + 1;
  if (!status)
    status = dlsi_cholesky_create(&work->factor, work->n, work->entries, work->row, work->col, turn,
                                  0, error);
  free(order);
  return status;
}

static dls_status joints_fill(dlsi_joints *work, const dls_contact *problem, const double *S,
                              double unit, dls_error *error) {
  const size_t nc = (size_t)work->nc, d = (size_t)work->d, m = d * nc;
  const size_t blocks = (size_t)problem->Wb.p[work->nc], most = d * d * (blocks + nc);
  int degree = 0;
  for (int c = 0; c < work->nc; c++) {
    const int now = problem->Wb.p[c + 1] - problem->Wb.p[c];
    degree = now > degree ? now : degree;
  }
  int *const ints = dlsi_alloc(8 * nc + 1, sizeof *ints);
  double *const doubles = dlsi_alloc(3 * m, sizeof *doubles);
  work->first = ints;
  work->c = doubles;
  work->basis = dlsi_alloc(2 * nc, sizeof *work->basis);
  work->Q = dlsi_alloc(most, sizeof *work->Q);
  work->inverses = dlsi_alloc(most, sizeof *work->inverses);
  work->row = dlsi_alloc(4 * most, sizeof *work->row);
  work->value = dlsi_alloc(2 * most, sizeof *work->value);
  const size_t panels = (size_t)degree * joint_unknowns * joint_unknowns; /* few are touched */
  double *scratch = dlsi_alloc(panels + nc + 3 * m, sizeof *scratch);
  if (!ints || !doubles || !work->basis || !work->Q || !work->inverses || !work->row ||
      !work->value || !scratch) {
    free(scratch);
    return dlsi_no_memory(error);
  }
  int **const pieces[] = {&work->list, &work->joint, &work->place, &work->rank, &work->at};
  for (size_t k = 0; k < 5; k++)
    *pieces[k] = ints + nc + 1 + k * nc;
  work->inverse = work->basis + nc;
  work->s = work->c + m;
  work->t = work->s + m;
  work->col = work->row + 2 * most;
  joints_find(work, &problem->Wb, (uint64_t *)(void *)(scratch + panels), ints + 6 * nc + 1);
  joints_row row = {.joint = ints + 6 * nc + 1, .slot = ints + 7 * nc + 1, .panel = scratch};
  memset(row.slot, 0, nc * sizeof *row.slot);
  for (int J = 0; J < work->count; J++)
    if (joint_size(work, J) > row.side) row.side = joint_size(work, J);
  joints_bases(work, problem, S, unit, &row);
  joints_list(work, problem, S, unit, &row);
  const int match = joints_match(work, problem, S, unit, scratch + panels + nc);
  free(scratch);
  return match ? joints_analyse(work, error) : DLS_STALLED;
}

dls_status dlsi_joints_create(dlsi_joints **out, const dls_contact *problem, const double *S,
                              double unit, dls_error *error) {
  *out = NULL;
  dlsi_joints *work = calloc(1, sizeof *work);
  if (!work) return dlsi_no_memory(error);
  work->d = problem->d;
  work->nc = problem->nc;
  const dls_status status = joints_fill(work, problem, S, unit, error);
  if (status)
    dlsi_joints_destroy(work);
  else
    *out = work;
  return status;
}

void dlsi_joints_destroy(dlsi_joints *work) {
  if (!work) return;
  dlsi_cholesky_destroy(work->factor);
  free(work->first);
  free(work->c);
  free(work->basis);
  free(work->Q);
  free(work->inverses);
  free(work->row);
  free(work->value);
  free(work);
}

/* ---- factor and solve ------------------------------------------------------------------------ */

/* Computes B_j^-1 of a joint. Returns 0, or k > 0 if pivot k is not positive. */
static int joint_invert(const dlsi_joints *work, int J, const double *rho, double *inverse) {
  const int n = joint_size(work, J), rank = work->rank[J], d = work->d;
  const int *list = work->list + work->first[J];
  const double *Q = work->Q + work->basis[J];
  double sums[joint_unknowns * joint_unknowns];
  int even = 1;
  for (int i = d; i < n; i += d)
    even = even && rho[list[i / d]] == rho[list[0]];
  const int direct = even || rank == n; /* no inverse is needed */
  double *B = direct ? inverse : sums;
  for (int j = 0; j < rank; j++)
    for (int i = 0; i < rank; i++) {
      double sum = even ? (i == j) * rho[list[0]] : 0;
      for (int k = 0; !even && i >= j && k < n; k++)
        sum += rank == n ? (i == k && j == k) * rho[list[k / d]]
                         : Q[k + n * i] * Q[k + n * j] / rho[list[k / d]];
      B[i + rank * j] = sum;
    }
  if (direct) return 0;
  dlsi_dense factors = {.n = rank, .A = B};
  const int failed = dlsi_dense_cholesky(&factors);
  if (failed) return failed;
  (void)dlsi_dense_inverse(&factors, inverse, NULL);
  for (int j = 0; j < rank; j++)
    for (int i = 0; i < j; i++)
      inverse[i + rank * j] = inverse[j + rank * i];
  return 0;
}

int dlsi_joints_factor(dlsi_joints *work, const double *rho) {
  double *value = work->value, pivot;
  for (int J = 0; J < work->count; J++) {
    const int rank = work->rank[J];
    double *inverse = work->inverses + work->inverse[J];
    const int failed = joint_invert(work, J, rho, inverse);
    if (failed) return work->at[J] + failed;
    for (int j = 0; j < rank; j++)
      for (int i = j; i < rank; i++)
        *value++ = inverse[i + rank * j];
  }
  return dlsi_cholesky_factor(work->factor, work->value, &pivot);
}

/* y := B^-1 v */
static void joints_weigh(const dlsi_joints *work, const double *v, double *y) {
  for (int J = 0; J < work->count; J++) {
    const int rank = work->rank[J], at = work->at[J];
    const double *inverse = work->inverses + work->inverse[J];
    for (int i = 0; i < rank; i++) {
      double sum = 0;
      for (int j = 0; j < rank; j++)
        sum += inverse[i + rank * j] * v[at + j];
      y[at + i] = sum;
    }
  }
}

dls_status dlsi_joints_solve(dlsi_joints *work, const double *rho, const double *p, const double *g,
                             double *x, dls_error *error) {
  joints_fold(work, p, work->c);
  joints_weigh(work, work->c, work->s);
  for (int i = 0; i < work->n; i++)
    work->s[i] -= g[i];
  const dls_status status = dlsi_cholesky_solve(work->factor, work->s, 1, error);
  if (status) return status;
  for (int i = 0; i < work->n; i++)
    work->c[i] -= work->s[i];
  joints_weigh(work, work->c, work->t);
  memcpy(x, p, (size_t)(work->d * work->nc) * sizeof *x);
  joints_unfold(work, work->t, rho, x);
  return DLS_OK;
}
