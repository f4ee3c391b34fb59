/*
 * lemke_problems.c: the LCPs of bench/lemke. Deterministic: one linear congruential generator, one
 * elastic model.
 *
 * Random: M = S + K, S = (3/n) G G^T + 0.1 I symmetric with eigenvalues from 0.1 to about 4.1, K
 * skew with entries in 0.02 [-1, 1]; G and q have entries in [-1, 1]. M is positive definite, so
 * there is one solution; half of q is negative, which takes Lemke about n/2 pivots.
 *
 * Friction: a lining, the flat elastic box of nx x 8 squares (reduction_boxes.c), glued with its
 * top to a rigid back. Its nx + 1 bottom nodes are candidates to contact with a rigid wavy track,
 * mu = 0.3. The back is pushed down by `press` and along by `shear`. Without reactions the lining
 * follows its back as a rigid body, so that
 *
 *   q_n = wave(x) - press,   q_t = shear;      W = H^T K^-1 H,
 *
 * and some candidates are free, some slip, some stick. W decays along the surface.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "lemke.h"
#include "reduction_boxes.h"

void dsyrk_(const char *uplo, const char *trans, const int *n, const int *k, const double *alpha,
            const double *a, const int *lda, const double *beta, double *c, const int *ldc, size_t,
            size_t);
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

int lining_create(lining *l, int nc) {
  box b;
  memset(l, 0, sizeof *l);
  l->q = zeros(2 * (size_t)nc);
  l->mu = zeros((size_t)nc);
  if (!l->q || !l->mu || box_create_glued(&b, 2, nc - 1, 8)) {
    lining_free(l);
    return -1;
  }
  const double press = 0.016, shear = 0.005;
  for (int c = 0; c < nc; c++) { /* two waves, of 41 and 13 elements' length */
    l->q[2 * c] = 0.008 * (1 - cos(c / 6.5)) + 0.002 * (1 - cos(c / 2.1)) - press;
    l->q[2 * c + 1] = shear;
    l->mu[c] = 0.3;
  }
  const int bad = bench_reduce(&l->reduction, &b.model, NULL) ||
                  dls_reduction_contact(l->reduction, l->mu, &l->contact, NULL);
  l->contact.q = l->q;
  box_free(&b);
  if (bad) lining_free(l);
  return bad ? -1 : 0;
}

void lining_free(lining *l) {
  dls_reduction_destroy(l->reduction);
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
