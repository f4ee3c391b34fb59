/*
 * principal.c: block principal pivoting for LCP(M, q), M a P-matrix.
 *
 *   y = M z + q,   y >= 0,  z >= 0,  y^T z = 0
 *
 * A basis is a set A of indices: z_i = 0 outside of A, y_i = 0 inside.
 *
 *   (G1)  M_AA z_A = -q_A,   y = M z + q
 *   (G2)  H = { i in A : z_i < 0 } u { i not in A : y_i < 0 };   H empty: z is the solution
 *   (G3)  |H| less than ever before:  chances := block_steps
 *   (G4)  chances > 0:  A := A xor H, one chance less;   else  A := A xor { min H }
 *
 * Sources: (G4) with all of H, M. M. Kostreva, Block pivot methods for solving the complementarity
 * problem, Linear Algebra Appl. 21 (1978); with min H, K. G. Murty, Note on a Bard-type scheme for
 * solving the complementarity problem, Opsearch 11 (1974); the two together, (G3), J. J. Judice and
 * F. M. Pires, A block principal pivoting algorithm for large-scale strictly monotone linear
 * complementarity problems, Computers Oper. Res. 21 (1994).
 *
 * It ends for every P-matrix: |H| can become less than ever before n times at most; between two
 * such times there are at most block_steps block exchanges; and the exchanges of min H alone, from
 * whatever basis, meet no basis twice (Murty) and so end with H empty if not before. Exchanges of H
 * alone can cycle (data/failures/l03, l04), those of min H alone can need 2^n - 1 steps (murty-*,
 * fathi-*).
 *
 * In floating point: < 0 in (G2) means s_i z_i, y_i < -4 eps (|q| + |M||z|)_i, a bound for what
 * rounding leaves of a zero after (G1) has been corrected once by its residual from the user's M
 * (Skeel). A z_i = 0 that rounding makes negative beyond that leaves A, and its y_i then stands the
 * test.
 *
 * M_AA is equilibrated by powers of two, which round nothing. Cholesky if M is symmetric to the
 * last bit, else LU. |A|^3/3 or 2|A|^3/3 flops per basis, n |A| for the rest. A symmetric M on
 * which Cholesky fails is no P-matrix; LU goes on with it, without promise.
 *
 * What can fail: M_AA singular (a hyperstatic W), reported; M no P-matrix, max_iterations.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/base.h"
#include "delassus/pivoting.h"
#include "lcp_internal.h"
#include "linear/blas.h"

struct dls_principal {
  dls_principal_settings settings;
  int n;            /* largest size */
  int k;            /* |A| */
  int symmetric;    /* M = M^T, and Cholesky has not failed on it */
  int cholesky;     /* S holds L, else L U */
  int *A;           /* n: the indices of the basis, ascending */
  char *in;         /* n: 1 for those in A */
  char *infeasible; /* n: 1 for those in H */
  int *pivots;      /* n */
  int *iwork;       /* 2 n */
  double *R, *C;    /* n: powers of two; what is factorised is R_A M_AA C_A */
  double *S;        /* k x k: M_AA, factorised */
  double *x;        /* n: right-hand side */
  double *z, *y;    /* n: (G1) */
  double *a;        /* n: |M||z| */
  double *s;        /* n: weights of the certificate */
  double *best;     /* n: z of least residual */
  double *work;     /* 9 n */
};

void dls_principal_settings_init(dls_principal_settings *settings) {
  if (!settings) return;
  *settings = (dls_principal_settings){.size = sizeof *settings, .block_steps = 10};
  dlsi_limits_init(&settings->limits);
}

static dls_status check_settings(const dls_principal_settings *s, dls_error *error) {
  const dlsi_setting own[] = {{"block_steps", s->block_steps, 0, INT_MAX, 0}};
  return dlsi_check_settings(&s->limits, s->size, sizeof *s, 1, own, error);
}

/* The workspace and its arrays, one after the other; *w is a copy of the head with the pointers. */
static dls_principal *carve(dlsi_arena *arena, dls_principal *w, int n) {
  const size_t N = (size_t)n;
  dls_principal *head = dlsi_take(arena, 1, sizeof *head);
  w->n = n;
  w->A = dlsi_take(arena, N, sizeof *w->A);
  w->in = dlsi_take(arena, N, sizeof *w->in);
  w->infeasible = dlsi_take(arena, N, sizeof *w->infeasible);
  w->pivots = dlsi_take(arena, N, sizeof *w->pivots);
  w->iwork = dlsi_take(arena, 2 * N, sizeof *w->iwork);
  w->R = dlsi_take(arena, N, sizeof *w->R);
  w->C = dlsi_take(arena, N, sizeof *w->C);
  w->S = dlsi_take(arena, N, N * sizeof *w->S);
  w->x = dlsi_take(arena, N, sizeof *w->x);
  w->z = dlsi_take(arena, N, sizeof *w->z);
  w->y = dlsi_take(arena, N, sizeof *w->y);
  w->a = dlsi_take(arena, N, sizeof *w->a);
  w->s = dlsi_take(arena, N, sizeof *w->s);
  w->best = dlsi_take(arena, N, sizeof *w->best);
  w->work = dlsi_take(arena, 9 * N, sizeof *w->work);
  return head;
}

dls_status dls_principal_create(dls_principal **out, int n, const dls_principal_settings *settings,
                                dls_error *error) {
  if (!out) return dlsi_at(__func__, dlsi_is_null(error, "out"), error);
  *out = NULL;
  if (n < 1)
    return dlsi_at(__func__,
                   dlsi_fail(error, DLS_E_SIZE, "n", -1, n, "is %d, must be at least 1", n), error);
  dls_principal_settings defaults;
  dls_principal_settings_init(&defaults);
  if (!settings) settings = &defaults;
  const dls_status status = check_settings(settings, error);
  if (status) return dlsi_at(__func__, status, error);
  dlsi_arena arena = {0};
  dls_principal w = {.settings = *settings};
  carve(&arena, &w, n);
  if (arena.failed)
    return dlsi_at(__func__, dlsi_fail(error, DLS_E_SIZE, "n", -1, n, "is too large"), error);
  void *memory = dlsi_alloc(arena.used, 1);
  if (!memory) return dlsi_at(__func__, dlsi_no_memory(error), error);
  arena = (dlsi_arena){.base = memory, .size = arena.used};
  dls_principal *head = carve(&arena, &w, n);
  *head = w;
  *out = head;
  return DLS_OK;
}

void dls_principal_destroy(dls_principal *workspace) {
  free(workspace);
}

/* ---- one basis ------------------------------------------------------------------------------- */

static int is_symmetric(const dls_lcp *lcp) {
  const size_t n = (size_t)lcp->n, ld = (size_t)lcp->M.ld;
  for (size_t j = 0; j < n; j++)
    for (size_t i = 0; i < j; i++)
      if (lcp->M.a[i + j * ld] != lcp->M.a[j + i * ld]) return 0;
  return 1;
}

/* R, C of S = R_A M_AA C_A; R = C if M is symmetric */
static void scale(dls_principal *w, const dls_lcp *lcp) {
  const int n = lcp->n;
  dlsi_lcp_equilibrate(lcp, w->R, w->C, w->work);
  for (int i = 0; i < n; i++) {
    const double rho = w->R[i], gamma = w->C[i], mean = (rho + gamma) / 2;
    w->R[i] = exp2(round(w->symmetric ? mean : rho));
    w->C[i] = exp2(round(w->symmetric ? mean : gamma));
  }
}

/* S := R_A M_AA C_A; returns its largest column sum */
static double gather(dls_principal *w, const dls_lcp *lcp) {
  const int k = w->k;
  double norm = 0;
  for (int j = 0; j < k; j++) {
    const double *m = lcp->M.a + (size_t)w->A[j] * (size_t)lcp->M.ld, c = w->C[w->A[j]];
    double *column = w->S + (size_t)j * (size_t)k, sum = 0;
    for (int i = 0; i < k; i++) {
      column[i] = w->R[w->A[i]] * m[w->A[i]] * c;
      sum += fabs(column[i]);
    }
    if (!(sum <= norm)) norm = sum;
  }
  return norm;
}

/* 1 if R_A M_AA C_A = L L^T or P L U is done and its condition number is below 1 / (k eps) */
static int factorise(dls_principal *w, const dls_lcp *lcp) {
  const int k = w->k;
  int info = 0;
  double norm = gather(w, lcp), rcond = 0;
  if (w->symmetric) {
    dpotrf_("L", &k, w->S, &k, &info, 1);
    w->cholesky = info == 0;
    if (w->cholesky)
      dpocon_("L", &k, w->S, &k, &norm, &rcond, w->work, w->iwork, &info, 1);
    else {
      w->symmetric = 0;
      norm = gather(w, lcp);
    }
  }
  if (!w->symmetric) {
    w->cholesky = 0;
    dgetrf_(&k, &k, w->S, &k, w->pivots, &info);
    if (info == 0) dgecon_("1", &k, w->S, &k, &norm, &rcond, w->work, w->iwork, &info, 1);
  }
  return rcond > k * DBL_EPSILON;
}

/* z_A += M_AA^-1 x */
static void correct(dls_principal *w) {
  const int k = w->k, one = 1;
  int info;
  for (int i = 0; i < k; i++)
    w->x[i] *= w->R[w->A[i]];
  if (w->cholesky)
    dpotrs_("L", &k, &one, w->S, &k, w->x, &k, &info, 1);
  else
    dgetrs_("N", &k, &one, w->S, &k, w->pivots, w->x, &k, &info, 1);
  for (int i = 0; i < k; i++)
    w->z[w->A[i]] += w->C[w->A[i]] * w->x[i];
}

/* (G1): 0 if M_AA is singular */
static int basic_solution(dls_principal *w, const dls_lcp *lcp, dls_principal_info *info) {
  const size_t n = (size_t)lcp->n;
  w->k = 0;
  for (int i = 0; i < lcp->n; i++)
    if (w->in[i]) w->A[w->k++] = i;
  memset(w->z, 0, n * sizeof *w->z);
  info->factorizations += w->k > 0;
  if (w->k > 0 && !factorise(w, lcp)) return 0;
  for (int pass = 0; pass < 2 && w->k > 0; pass++) { /* solution, correction */
    dlsi_lcp_multiply(lcp, lcp->q, w->z, w->y, w->a);
    for (int i = 0; i < w->k; i++)
      w->x[i] = -w->y[w->A[i]];
    correct(w);
  }
  dlsi_lcp_multiply(lcp, lcp->q, w->z, w->y, w->a);
  return 1;
}

/* (G2): |H|, and the residual of the basis, that of its negative parts */
static int find_infeasible(dls_principal *w, const dls_lcp *lcp, double *residual) {
  const int n = lcp->n;
  int count = 0;
  for (int i = 0; i < n; i++) {
    const double v = w->in[i] ? w->s[i] * w->z[i] : w->y[i];
    const int holds = v >= -4 * DBL_EPSILON * (fabs(lcp->q[i]) + w->a[i]); /* NaN does not */
    w->infeasible[i] = (char)!holds;
    count += !holds;
    w->x[i] = v < 0 ? v : v != v ? v : 0;
  }
  const double norm = dlsi_norm2(w->x, (size_t)n);
  *residual = norm == 0 ? 0 : norm / dlsi_norm2(lcp->q, (size_t)n);
  return count;
}

/* (G4) */
static void exchange(dls_principal *w, int n, int all) {
  for (int i = 0; i < n; i++)
    if (w->infeasible[i]) {
      w->in[i] = !w->in[i];
      if (!all) return;
    }
}

/* ---- the iteration --------------------------------------------------------------------------- */

static int cancelled(const dls_principal *w, int iteration, int limit, double residual) {
  if (!w->settings.limits.progress) return 0;
  const dls_progress p = {
      .method = "principal", .iteration = iteration, .max_iterations = limit, .residual = residual};
  return w->settings.limits.progress(w->settings.limits.progress_data, &p) != 0;
}

static dls_status iterate(dls_principal *w, const dls_lcp *lcp, dls_principal_info *info) {
  const dls_principal_settings *set = &w->settings;
  const int n = lcp->n;
  const int limit = set->limits.max_iterations ? set->limits.max_iterations : 10 * n + 1000;
  int fewest = n + 1, chances = 0;
  double residual, least = INFINITY;
  for (;;) {
    if (!basic_solution(w, lcp, info)) return DLS_STALLED; /* (G1) */
    const int count = find_infeasible(w, lcp, &residual);  /* (G2) */
    if (residual < least || count == 0) {
      least = residual;
      memcpy(w->best, w->z, (size_t)n * sizeof *w->best);
    }
    if (count == 0) return DLS_OK;
    if (cancelled(w, info->iterations, limit, residual)) return DLS_CANCELLED;
    if (info->iterations == limit) return DLS_MAX_ITERATIONS;
    if (count < fewest) { /* (G3) */
      fewest = count;
      chances = set->block_steps;
    }
    exchange(w, n, chances > 0); /* (G4) */
    info->single_exchanges += chances == 0;
    if (chances > 0) chances--;
    info->iterations++;
  }
}

dls_status dls_principal_solve(dls_principal *workspace, const dls_lcp *lcp, double *z, double *y,
                               dls_principal_info *info, dls_error *error) {
  dls_principal *w = workspace;
  if (!w) return dlsi_at(__func__, dlsi_is_null(error, "workspace"), error);
  dls_status status = dlsi_check_lcp(lcp, error);
  if (status) return dlsi_at(__func__, status, error);
  const int n = lcp->n;
  if (n > w->n)
    return dlsi_at(
        __func__, dlsi_fail(error, DLS_E_SIZE, "n", -1, n, "is more than the workspace's %d", w->n),
        error);
  if (!z) return dlsi_at(__func__, dlsi_is_null(error, "z"), error);
  if (w->settings.limits.warm_start) {
    status = dlsi_check_vector("z", z, (size_t)n, error);
    if (status) return dlsi_at(__func__, status, error);
  }
  dls_principal_info result = {0};
  w->symmetric = is_symmetric(lcp);
  scale(w, lcp);
  dlsi_lcp_weights(lcp, w->s);
  for (int i = 0; i < n; i++)
    w->in[i] = w->settings.limits.warm_start && z[i] > 0;
  memset(w->best, 0, (size_t)n * sizeof *w->best);

  status = iterate(w, lcp, &result);
  for (int i = 0; i < n; i++)
    z[i] = w->best[i] > 0 ? w->best[i] : 0;
  dlsi_lcp_multiply(lcp, lcp->q, z, w->y, w->a);
  dlsi_lcp_measure(lcp, z, w->y, w->a, w->s, &result.certificate);
  if (y) memcpy(y, w->y, (size_t)n * sizeof *y);
  const int holds = dls_lcp_certificate_holds(&result.certificate, w->settings.limits.tol);
  if (status == DLS_OK && !holds) status = DLS_STALLED;
  result.status = status;
  if (info) *info = result;
  return dlsi_at(__func__, status, error);
}
