/*
 * global_peer.c: the splitting on K with CHOLMOD, which only this file of the bench uses.
 *
 *   R = 1/w,  w = 4 sum_i h_i^2 / K_ii of the normal: the local compliance of the node
 *   (K + H R H^T) x := f + H (r + R (z - s - g)),  u := H^T x + g,  s := mu |u_t| n,  v := u + s
 *   r := the projection of r - R v on the cone,    z := v - (r_old - r) / R
 *
 * Every 20 iterations x := K^-1 (f + H r) gives the residual. Supernodal factors of K and of K + H
 * R H^T, one analysis if H picks unknowns, so that patterns agree.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cholmod_view.h"
#include "global_ways.h"

enum { look_every = 20, most = 20000 };

typedef struct peer {
  cholmod_common c;
  cholmod_factor *of_K, *of_A;
  cholmod_dense *b, *x, *y, *e; /* x: solution; y, e: CHOLMOD's scratch */
  double *h, *u, *z, *s, *w;    /* d nc, of (n, t ..): scratch, u, z; nc: s, w */
} peer;

static int column_of(int d, int k) {
  return k % d ? (d - 1) * (k / d) + k % d - 1 : k / d;
}

/* A := K + H R H^T */
static cholmod_sparse *peer_A(const scene *S, cholmod_sparse *K, const double *w,
                              cholmod_common *c) {
  const int d = S->d, m = d * S->nc;
  const size_t entries = (size_t)(S->model.HN.p[S->nc] + S->model.HT.p[(d - 1) * S->nc]);
  cholmod_sparse *H =
      cholmod_allocate_sparse((size_t)S->n, (size_t)m, entries, 0, 1, 0, CHOLMOD_REAL, c);
  if (!H) return NULL;
  int *p = H->p, *i = H->i, at = 0;
  double *x = H->x;
  for (int k = 0; k < m; k++) {
    const dls_sparse *L = k % d ? &S->model.HT : &S->model.HN;
    const int column = column_of(d, k);
    p[k] = at;
    for (int e = L->p[column]; e < L->p[column + 1]; e++) {
      i[at] = L->i[e];
      x[at++] = L->x[e] / sqrt(w[k / d]);
    }
  }
  p[m] = at;
  cholmod_sparse *HH = cholmod_aat(H, NULL, 0, 1, c);
  cholmod_sparse *lower = HH ? cholmod_copy(HH, -1, 1, c) : NULL;
  double one[2] = {1, 0};
  cholmod_sparse *A = lower ? cholmod_add(K, lower, one, one, 1, 1, c) : NULL;
  cholmod_free_sparse(&H, c);
  cholmod_free_sparse(&HH, c);
  cholmod_free_sparse(&lower, c);
  return A;
}

/* u := H^T x + g, or y += H r. */
static void peer_look(const scene *S, const double *x, double *u) {
  const int d = S->d;
  for (int k = 0; k < d * S->nc; k++) {
    const dls_sparse *L = k % d ? &S->model.HT : &S->model.HN;
    u[k] = S->g[k];
    for (int e = L->p[column_of(d, k)]; e < L->p[column_of(d, k) + 1]; e++)
      u[k] += L->x[e] * x[L->i[e]];
  }
}

static void peer_push(const scene *S, const double *r, double *y) {
  const int d = S->d;
  for (int k = 0; k < d * S->nc; k++) {
    const dls_sparse *L = k % d ? &S->model.HT : &S->model.HN;
    for (int e = L->p[column_of(d, k)]; e < L->p[column_of(d, k) + 1]; e++)
      y[L->i[e]] += L->x[e] * r[k];
  }
}

/* Projects p (d) on Coulomb's cone. */
static void peer_project(int d, double mu, double *p) {
  const double t = d == 3 ? hypot(p[1], p[2]) : fabs(p[1]);
  if (t <= mu * p[0]) return;
  const double n = mu * t <= -p[0] ? 0 : (p[0] + mu * t) / (1 + mu * mu);
  p[0] = n;
  for (int k = 1; k < d; k++)
    p[k] *= t > 0 ? mu * n / t : 0;
}

static int peer_step(peer *P, cholmod_factor *L) {
  return cholmod_solve2(CHOLMOD_A, L, P->b, NULL, &P->x, NULL, &P->y, &P->e, &P->c) ? 0 : -1;
}

/* Returns the larger one of both residuals of r; scale: |H^T K^-1 f + g|, set at first. */
static double peer_residual(peer *P, const scene *S, double mu, const double *r, double *scale) {
  const int d = S->d;
  double *b = P->b->x, of_u = 0, of_r = 0, size = 0, size_u = 0;
  memcpy(b, S->f, (size_t)S->n * sizeof *b);
  peer_push(S, r, b);
  if (peer_step(P, P->of_K)) return NAN;
  peer_look(S, P->x->x, P->h);
  for (int c = 0; c < S->nc; c++) {
    const double *u = P->h + d * c, *rc = r + d * c, w = P->w[c];
    double p[3] = {0};
    for (int k = 0; k < d; k++)
      p[k] = w * rc[k] - u[k];
    p[0] -= mu * (d == 3 ? hypot(u[1], u[2]) : fabs(u[1]));
    peer_project(d, mu, p);
    for (int k = 0; k < d; k++) {
      const double F = w * rc[k] - p[k];
      of_u += F * F;
      of_r += F * F / (w * w);
      size += rc[k] * rc[k];
      size_u += u[k] * u[k];
    }
  }
  if (*scale == 0) *scale = sqrt(size_u);
  return fmax(sqrt(of_u) / *scale, size > 0 ? sqrt(of_r / size) : 1);
}

static int peer_iterate(peer *P, const scene *S, double mu, double tol, double *r, double *x,
                        int *iterations) {
  const int d = S->d, m = d * S->nc;
  double *b = P->b->x, scale = 0;
  for (int k = 0; k <= most; k++) {
    *iterations = k;
    if (k % look_every == 0) {
      const double residual = peer_residual(P, S, mu, r, &scale);
      memcpy(x, P->x->x, (size_t)S->n * sizeof *x);
      if (residual <= tol || isnan(residual)) return isnan(residual) ? -1 : 0;
    }
    for (int i = 0; i < m; i++) {
      const double w = P->w[i / d];
      P->h[i] = r[i] + (P->z[i] - (i % d ? 0 : P->s[i / d]) - S->g[i]) / w;
    }
    memcpy(b, S->f, (size_t)S->n * sizeof *b);
    peer_push(S, P->h, b);
    if (peer_step(P, P->of_A)) return -1;
    peer_look(S, P->x->x, P->u);
    for (int c = 0; c < S->nc; c++) {
      double *rc = r + d * c, *z = P->z + d * c, *u = P->u + d * c, p[3] = {0};
      const double w = P->w[c];
      P->s[c] = mu * (d == 3 ? hypot(u[1], u[2]) : fabs(u[1]));
      u[0] += P->s[c];
      for (int i = 0; i < d; i++)
        p[i] = rc[i] - u[i] / w;
      peer_project(d, mu, p);
      for (int i = 0; i < d; i++) {
        z[i] = u[i] - (rc[i] - p[i]) * w;
        rc[i] = p[i];
      }
    }
  }
  return 1;
}

int peer_solve(const scene *S, double mu, double tol, double *r, double *x, int *iterations) {
  const size_t m = (size_t)(S->d * S->nc), nc = (size_t)S->nc, n = (size_t)S->n;
  peer P = {.of_K = NULL};
  const dls_sparse *K = &S->model.Ks;
  cholmod_start(&P.c);
  P.c.supernodal = CHOLMOD_SUPERNODAL;
  P.c.print = 0;
  double *all = calloc(3 * m + 2 * nc + n, sizeof *all), *diagonal = all + 3 * m + 2 * nc;
  cholmod_sparse view = cholmod_view(&S->model.Ks), *stiffness = &view, *A = NULL;
  int status = all ? 0 : -1;
  if (!status) {
    P.h = all;
    P.u = P.h + m;
    P.z = P.u + m;
    P.s = P.z + m;
    P.w = P.s + nc;
    for (int j = 0; j < K->cols; j++)
      for (int k = K->p[j]; k < K->p[j + 1]; k++)
        if (K->i[k] == j) diagonal[j] += K->x[k];
    for (int c = 0; c < S->nc; c++)
      for (int e = S->model.HN.p[c]; e < S->model.HN.p[c + 1]; e++)
        P.w[c] += 4 * S->model.HN.x[e] * S->model.HN.x[e] / diagonal[S->model.HN.i[e]];
    P.of_K = cholmod_analyze(stiffness, &P.c);
    A = peer_A(S, stiffness, P.w, &P.c);
    const int same = A && cholmod_nnz(A, &P.c) == cholmod_nnz(stiffness, &P.c);
    P.of_A = !P.of_K || !A ? NULL
             : same        ? cholmod_copy_factor(P.of_K, &P.c)
                           : cholmod_analyze(A, &P.c);
    P.b = cholmod_zeros(n, 1, CHOLMOD_REAL, &P.c);
    const int made = P.of_A && P.b && cholmod_factorize(stiffness, P.of_K, &P.c) &&
                     cholmod_factorize(A, P.of_A, &P.c) && P.c.status == CHOLMOD_OK;
    memset(r, 0, m * sizeof *r);
    status = made ? peer_iterate(&P, S, mu, tol, r, x, iterations) : -1;
  }
  cholmod_free_sparse(&A, &P.c);
  cholmod_free_factor(&P.of_K, &P.c);
  cholmod_free_factor(&P.of_A, &P.c);
  cholmod_free_dense(&P.b, &P.c);
  cholmod_free_dense(&P.x, &P.c);
  cholmod_free_dense(&P.y, &P.c);
  cholmod_free_dense(&P.e, &P.c);
  cholmod_finish(&P.c);
  free(all);
  return status;
}
