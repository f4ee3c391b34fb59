/*
 * lemke_problems.c: the LCPs of bench/lemke. Deterministic: one linear congruential generator, one
 * elastic model.
 *
 * Random: M = S + K, S = (3/n) G G^T + 0.1 I symmetric with eigenvalues from 0.1 to about 4.1, K
 * skew with entries in 0.02 [-1, 1]; G and q have entries in [-1, 1]. M is positive definite, so
 * there is one solution; half of q is negative, which takes Lemke about n/2 pivots.
 *
 * Friction: a lining, the flat elastic block of nx x 8 square elements (two T3 each, plane strain,
 * E = 1, nu = 0.3, element size 1), glued with its top to a rigid back. Its nx + 1 bottom nodes are
 * candidates to contact with a rigid wavy track, mu = 0.3. The back is pushed down by `press` and
 * along by `shear`. Without reactions the lining follows its back as a rigid body, so that
 *
 *   q_n = wave(x) - press,   q_t = shear;      W = H^T K^-1 H,
 *
 * and some candidates are free, some slip, some stick. W decays along the surface, from 6 to 3e-69
 * at n = 3999. K of the nodes below the back, numbered column by column, is a band of half width
 * 19: dpbtrf, then dpbtrs with some columns of H at a time. No dense K of 16 nx unknowns is formed.
 * Cost: 4 * 19 * 16 nx * 2 nc flops.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus/fe.h"
#include "lemke.h"

void dsyrk_(const char *uplo, const char *trans, const int *n, const int *k, const double *alpha,
            const double *a, const int *lda, const double *beta, double *c, const int *ldc, size_t,
            size_t);
void dpbtrf_(const char *uplo, const int *n, const int *kd, double *ab, const int *ldab, int *info,
             size_t);
void dpbtrs_(const char *uplo, const int *n, const int *kd, const int *nrhs, const double *ab,
             const int *ldab, double *b, const int *ldb, int *info, size_t);

static double *zeros(size_t count) {
  return calloc(count, sizeof(double));
}

/* ---- LCPs ------------------------------------------------------------------------------------ */

static int problem_create(problem *p, const char *name, int n) {
  memset(p, 0, sizeof *p);
  snprintf(p->name, sizeof p->name, "%s", name);
  p->n = n;
  p->M = zeros((size_t)n * (size_t)n);
  p->q = zeros((size_t)n);
  if (p->M && p->q) return 0;
  problem_free(p);
  return -1;
}

void problem_free(problem *p) {
  free(p->M);
  free(p->q);
  memset(p, 0, sizeof *p);
}

dls_lcp problem_view(const problem *p) {
  return (dls_lcp){.n = p->n, .M = {p->n, p->n, p->n, p->M}, .q = p->q};
}

int problem_random(problem *p, int n) {
  const size_t N = (size_t)n;
  double *G = zeros(N * N);
  if (!G || problem_create(p, "random", n)) {
    free(G);
    return -1;
  }
  uint64_t state = 2026;
  for (size_t k = 0; k < N * N; k++)
    G[k] = bench_draw(&state);
  const double scale = 3.0 / n, zero = 0;
  dsyrk_("L", "N", &n, &n, &scale, G, &n, &zero, p->M, &n, 1, 1);
  free(G);
  for (size_t j = 0; j < N; j++) {
    p->M[j + j * N] += 0.1;
    for (size_t i = j + 1; i < N; i++) {
      const double s = p->M[i + j * N], k = 0.02 * bench_draw(&state);
      p->M[i + j * N] = s + k;
      p->M[j + i * N] = s - k;
    }
    p->q[j] = bench_draw(&state);
  }
  return 0;
}

int problem_read(problem *p, const char *directory, const char *name) {
  char path[1024];
  dls_error error = {0};
  int rows = 0, columns = 0, length = 0, one = 0, status = -1;
  double *M = NULL, *q = NULL;
  snprintf(path, sizeof path, "%s/%s_M.mtx", directory, name);
  if (dls_mtx_read(path, &rows, &columns, &M, &error)) goto end;
  snprintf(path, sizeof path, "%s/%s_q.mtx", directory, name);
  if (dls_mtx_read(path, &length, &one, &q, &error)) goto end;
  snprintf(error.message, sizeof error.message, "%.100s: M is %d x %d, q has %d x %d", name, rows,
           columns, length, one);
  if (rows != columns || length != rows || one != 1) goto end;
  snprintf(error.message, sizeof error.message, "out of memory");
  if (problem_create(p, name, rows)) goto end;
  memcpy(p->M, M, (size_t)rows * (size_t)rows * sizeof *M);
  memcpy(p->q, q, (size_t)rows * sizeof *q);
  status = 0;
end:
  if (status) fprintf(stderr, "%s\n", error.message);
  dls_mtx_free(M);
  dls_mtx_free(q);
  return status;
}

/* ---- the lining ------------------------------------------------------------------------------ */

enum { layers = 8, kd = 2 * layers + 3, chunk = 64 };

/* Returns the unknown of node (i, j), component c (0: x, 1: y), j = 0 at the bottom; -1 on the
 * back. */
static int lining_unknown(int i, int j, int c) {
  return j == layers ? -1 : 2 * (i * layers + j) + c;
}

/* Adds up the lower band of K, in which K(a, b) stands at band[a - b + b * (kd + 1)], from the one
 * 8 x 8 matrix of a square of two triangles. */
static int lining_stiffness(double *band, int nx) {
  dls_fe_mesh square;
  double S[64];
  if (dls_fe_mesh_block(&square, 1, 1, 1, 1, NULL)) return -1;
  const dls_status status = dls_fe_stiffness(&square, 1, 0.3, S, 8, NULL);
  dls_fe_mesh_free(&square);
  if (status) return -1;
  for (int i = 0; i < nx; i++)
    for (int j = 0; j < layers; j++)
      for (int p = 0; p < 8; p++)
        for (int q = 0; q < 8; q++) { /* local node k stands at (k % 2, k / 2) */
          const int a = lining_unknown(i + p / 2 % 2, j + p / 4, p % 2);
          const int b = lining_unknown(i + q / 2 % 2, j + q / 4, q % 2);
          if (b >= 0 && a >= b) band[(size_t)(a - b) + (size_t)b * (kd + 1)] += S[p + 8 * q];
        }
  return 0;
}

/* Returns the unknown that column k of H picks for candidate k / 2: y for even k, x for odd k. */
static int lining_contact(int k) {
  return lining_unknown(k / 2, 0, k % 2 == 0);
}

static int lining_condense(double *W, int nc) {
  const int n = 2 * layers * nc, m = 2 * nc, ldab = kd + 1, half_width = kd;
  double *band = zeros((size_t)ldab * (size_t)n), *X = zeros((size_t)n * chunk);
  int info = !band || !X || lining_stiffness(band, nc - 1);
  if (!info) dpbtrf_("L", &n, &half_width, band, &ldab, &info, 1);
  for (int first = 0; first < m && !info; first += chunk) {
    const int columns = m - first < chunk ? m - first : chunk;
    memset(X, 0, (size_t)n * chunk * sizeof *X);
    for (int k = 0; k < columns; k++)
      X[(size_t)lining_contact(first + k) + (size_t)k * (size_t)n] = 1;
    dpbtrs_("L", &n, &half_width, &columns, band, &ldab, X, &n, &info, 1);
    for (int k = 0; k < columns; k++)
      for (int i = 0; i < m; i++)
        W[(size_t)i + (size_t)(first + k) * (size_t)m] =
            X[(size_t)lining_contact(i) + (size_t)k * (size_t)n];
  }
  free(band);
  free(X);
  return info ? -1 : 0;
}

int lining_create(lining *l, int nc) {
  const size_t m = 2 * (size_t)nc;
  memset(l, 0, sizeof *l);
  l->W = zeros(m * m);
  l->q = zeros(m);
  l->mu = zeros((size_t)nc);
  if (!l->W || !l->q || !l->mu || lining_condense(l->W, nc)) {
    lining_free(l);
    return -1;
  }
  const double press = 0.016, shear = 0.005;
  for (int c = 0; c < nc; c++) { /* two waves, of 41 and 13 elements' length */
    l->q[2 * c] = 0.008 * (1 - cos(c / 6.5)) + 0.002 * (1 - cos(c / 2.1)) - press;
    l->q[2 * c + 1] = shear;
    l->mu[c] = 0.3;
  }
  l->contact =
      (dls_contact){.d = 2, .nc = nc, .W = {(int)m, (int)m, (int)m, l->W}, .q = l->q, .mu = l->mu};
  return 0;
}

void lining_free(lining *l) {
  free(l->W);
  free(l->q);
  free(l->mu);
  memset(l, 0, sizeof *l);
}

int problem_from_lining(problem *p, const lining *l) {
  const int n = dls_contact_lcp_size(&l->contact);
  if (problem_create(p, "friction", n)) return -1;
  if (dls_contact_to_lcp(&l->contact, NULL, p->M, n, p->q, NULL) == DLS_OK) return 0;
  problem_free(p);
  return -1;
}
