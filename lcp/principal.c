/*
 * principal.c: solves LCP(M, q), M a P-matrix, by block principal pivoting. A sparse M goes to
 * active.c.
 *
 *   y = M z + q,   y >= 0,  z >= 0,  y^T z = 0
 *
 * A basis is a set A of indices: z_i = 0 outside of A, y_i = 0 inside.
 *
 *   (PP1)  M_AA z_A = -q_A,   y = M z + q
 *   (PP2)  H = { i in A : z_i < 0 } u { i not in A : y_i < 0 };   H empty: z is the solution
 *   (PP3)  |H| less than ever before:  chances := block_steps
 *   (PP4)  chances > 0:  A := A xor H, one chance less;   else  A := A xor { min H }
 *
 * Sources: (PP4) with all of H, M. M. Kostreva, Block pivot methods for solving the complementarity
 * problem, Linear Algebra Appl. 21 (1978); with min H, K. G. Murty, Note on a Bard-type scheme for
 * solving the complementarity problem, Opsearch 11 (1974); the two together, (PP3), J. J. Judice
 * and F. M. Pires, A block principal pivoting algorithm for large-scale strictly monotone linear
 * complementarity problems, Computers Oper. Res. 21 (1994).
 *
 * It ends for every P-matrix. |H| reaches a new minimum at most n times, with at most block_steps
 * block pivots between two minima. Pivots of min H alone meet no basis twice (Murty), so they end
 * with H empty from any basis. Pivots of all of H alone can cycle (data/failures/l03, l04); those
 * of min H alone can take 2^n - 1 steps (murty-*, fathi-*).
 *
 * In floating point < 0 in (PP2) means s_i z_i, y_i < -4 eps (|q| + |M||z|)_i. This bounds the
 * rounding of a zero once (PP1) has been corrected by its residual from the user's M (Skeel). If
 * rounding makes z_i = 0 more negative than that, i leaves A, and y_i then passes the test.
 *
 * M_AA is equilibrated by powers of two, without rounding. Factors: Cholesky if M is symmetric to
 * the last bit, else LU: |A|^3/3 or 2|A|^3/3 flops per basis, n |A| for the rest. If Cholesky fails
 * on a symmetric M, M is no P-matrix; LU then continues, and may fail.
 *
 * Can fail: M_AA singular (a hyperstatic W) is reported; M no P-matrix may run to max_iterations.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/pivoting.h"
#include "lcp_internal.h"
#include "linear/blas.h"

struct dls_principal {
  dls_principal_settings settings;
  int n; /* of create */
  atomic_int busy;
  int symmetric;       /* 1: M = M^T, and Cholesky has not failed on it */
  int *A;              /* the basis, ascending, factors.n = |A| of n */
  char *in;            /* 1 for i in A, n */
  char *infeasible;    /* 1 for i in H, n */
  int *iwork;          /* scratch, 2 n */
  dlsi_dense factors;  /* R_A M_AA C_A */
  double *R, *C;       /* powers of two, n */
  double *x;           /* right-hand side, n */
  double *z, *y;       /* of (PP1), n */
  double *a;           /* |M||z|, n */
  double *s;           /* weights of the certificate, n */
  double *best;        /* z of least residual, n */
  dlsi_active *sparse; /* for Ms; NULL: for a dense M, and the next arrays are there */
  double *work;        /* scratch, 9 n */
  double begun;        /* CPU seconds when the solve began; -1: not needed */
};

void dls_principal_settings_init(dls_principal_settings *settings) {
  if (!settings) return;
  *settings = (dls_principal_settings){.size = sizeof *settings, .block_steps = 10};
  dlsi_limits_init(&settings->limits);
}

static void principal_carve(void *workspace, dlsi_arena *arena) {
  dls_principal *work = workspace;
  const size_t n = (size_t)work->n;
  double **vectors[] = {&work->R, &work->C, &work->x, &work->z,
                        &work->y, &work->a, &work->s, &work->best};
  for (size_t k = 0; k < sizeof vectors / sizeof vectors[0]; k++)
    *vectors[k] = dlsi_take(arena, n, sizeof(double));
  work->A = dlsi_take(arena, n, sizeof *work->A);
  work->in = dlsi_take(arena, n, sizeof *work->in);
  work->infeasible = dlsi_take(arena, n, sizeof *work->infeasible);
  work->iwork = dlsi_take(arena, 2 * n, sizeof *work->iwork);
  if (work->settings.limits.blocks > 0) return;
  work->work = dlsi_take(arena, 9 * n, sizeof *work->work);
  work->factors.pivot = dlsi_take(arena, n, sizeof *work->factors.pivot);
  work->factors.A = dlsi_take(arena, n, n * sizeof *work->factors.A);
}

static dls_status principal_create(dls_principal **out, int n,
                                   const dls_principal_settings *settings, dls_error *error) {
  if (!out) return dlsi_is_null(error, "out");
  *out = NULL;
  if (n < 1) return dlsi_fail(error, DLS_E_SIZE, "n", -1, n, "is %d, must be at least 1", n);
  dls_principal work = {.n = n};
  dls_principal_settings_init(&work.settings);
  if (settings) work.settings = *settings;
  const dls_principal_settings *s = &work.settings;
  const dlsi_setting own[] = {{"block_steps", s->block_steps, 0, INT_MAX, 0}};
  dls_status status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 1, own, error);
  void *made = NULL;
  if (!status) status = dlsi_check_blas(error);
  if (!status && s->limits.blocks > 0)
    status = dlsi_active_create(&work.sparse, n, s->limits.blocks, error);
  if (!status)
    status = dlsi_carve_workspace(&made, &work, sizeof work, principal_carve, "n", n, error);
  if (status) dlsi_active_destroy(work.sparse);
  *out = made;
  return status;
}

dls_status dls_principal_create(dls_principal **out, int n, const dls_principal_settings *settings,
                                dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, principal_create(out, n, settings, error), error);
}

void dls_principal_destroy(dls_principal *workspace) {
  if (workspace) dlsi_active_destroy(workspace->sparse);
  free(workspace);
}

/* ---- one basis ------------------------------------------------------------------------------- */

static int principal_is_symmetric(const dls_lcp *lcp) {
  for (int j = 0; j < lcp->n; j++)
    for (int i = 0; i < j; i++)
      if (dlsi_lcp_column(lcp, j)[i] != dlsi_lcp_column(lcp, i)[j]) return 0;
  return 1;
}

/* Finds R and C; R = C if M is symmetric. */
static void principal_scale(dls_principal *work, const dls_lcp *lcp) {
  dlsi_lcp_equilibrate(lcp, work->R, work->C, work->work);
  for (int i = 0; i < lcp->n; i++) {
    const double rho = work->R[i], gamma = work->C[i], mean = (rho + gamma) / 2;
    work->R[i] = dlsi_power_of_two(work->symmetric ? mean : rho);
    work->C[i] = dlsi_power_of_two(work->symmetric ? mean : gamma);
  }
}

/* factors.A := R_A M_AA C_A; returns its largest column sum. */
static double principal_gather(dls_principal *work, const dls_lcp *lcp) {
  const int k = work->factors.n;
  double norm = 0, *entry = work->factors.A;
  for (int j = 0; j < k; j++) {
    const double *m = dlsi_lcp_column(lcp, work->A[j]), c = work->C[work->A[j]];
    double sum = 0;
    for (int i = 0; i < k; i++, entry++) {
      *entry = work->R[work->A[i]] * m[work->A[i]] * c;
      sum += fabs(*entry);
    }
    if (!(sum <= norm)) norm = sum;
  }
  return norm;
}

/* Factorises R_A M_AA C_A; returns 0 if its condition number is not below 1 / (|A| eps). */
static int principal_factor(dls_principal *work, const dls_lcp *lcp) {
  dlsi_dense *f = &work->factors;
  const int k = f->n;
  int info;
  double norm = principal_gather(work, lcp), rcond = 0;
  if (work->symmetric && dlsi_dense_cholesky(f)) {
    work->symmetric = 0;
    norm = principal_gather(work, lcp);
  }
  if (work->symmetric)
    dpocon_("L", &k, f->A, &k, &norm, &rcond, work->work, work->iwork, &info, 1);
  else if (!dlsi_dense_lu(f))
    dgecon_("1", &k, f->A, &k, &norm, &rcond, work->work, work->iwork, &info, 1);
  return rcond > k * DBL_EPSILON;
}

/* (PP1) Returns 0 if M_AA is singular. */
static int principal_solve_basis(dls_principal *work, const dls_lcp *lcp,
                                 dls_principal_info *info) {
  int k = 0;
  for (int i = 0; i < lcp->n; i++)
    if (work->in[i]) work->A[k++] = i;
  work->factors.n = k;
  memset(work->z, 0, (size_t)lcp->n * sizeof *work->z);
  info->factorizations += k > 0;
  if (k > 0 && !principal_factor(work, lcp)) return 0;
  for (int pass = 0; pass < 2 && k > 0; pass++) { /* solution, correction */
    dlsi_lcp_multiply(lcp, lcp->q, work->z, work->y, work->a);
    for (int i = 0; i < k; i++)
      work->x[i] = -work->y[work->A[i]] * work->R[work->A[i]];
    dlsi_dense_solve(&work->factors, work->x, k, 1);
    for (int i = 0; i < k; i++)
      work->z[work->A[i]] += work->C[work->A[i]] * work->x[i];
  }
  dlsi_lcp_multiply(lcp, lcp->q, work->z, work->y, work->a);
  return 1;
}

/* (PP2) Returns |H|; *residual := that of the negative parts. */
static int principal_find_infeasible(dls_principal *work, const dls_lcp *lcp, double *residual) {
  const int n = lcp->n;
  int count = 0;
  for (int i = 0; i < n; i++) {
    const double v = work->in[i] ? work->s[i] * work->z[i] : work->y[i];
    const int holds = v >= -4 * DBL_EPSILON * (fabs(lcp->q[i]) + work->a[i]); /* NaN does not */
    work->infeasible[i] = (char)!holds;
    count += !holds;
    work->x[i] = v < 0 ? v : v != v ? v : 0;
  }
  const double norm = dlsi_norm2(work->x, (size_t)n);
  *residual = norm == 0 ? 0 : norm / dlsi_norm2(lcp->q, (size_t)n);
  return count;
}

/* (PP4) */
static void principal_exchange(dls_principal *work, int n, int all) {
  for (int i = 0; i < n; i++)
    if (work->infeasible[i]) {
      work->in[i] = !work->in[i];
      if (!all) return;
    }
}

/* ---- the iteration --------------------------------------------------------------------------- */

static dls_status principal_report(const dls_principal *work, int iteration, int limit,
                                   double residual) {
  dls_progress progress = {"principal", "principal", iteration, limit, residual, work->z, 0, 0};
  return dlsi_tell(&work->settings.limits, work->begun, &progress);
}

static dls_status principal_iterate(dls_principal *work, const dls_lcp *lcp,
                                    dls_principal_info *info) {
  const int n = lcp->n, limit = dlsi_most_iterations(&work->settings.limits, 10 * n + 1000);
  int fewest = n + 1, chances = 0;
  double residual, least = INFINITY;
  for (;;) {
    if (!principal_solve_basis(work, lcp, info)) return DLS_STALLED;   /* (PP1) */
    const int count = principal_find_infeasible(work, lcp, &residual); /* (PP2) */
    if (residual < least || count == 0) {
      least = residual;
      memcpy(work->best, work->z, (size_t)n * sizeof *work->best);
    }
    if (count == 0) return DLS_OK;
    const dls_status stop = principal_report(work, info->iterations, limit, residual);
    if (stop) return stop;
    if (info->iterations == limit) return DLS_MAX_ITERATIONS;
    if (count < fewest) { /* (PP3) */
      fewest = count;
      chances = work->settings.block_steps;
    }
    principal_exchange(work, n, chances > 0); /* (PP4) */
    info->single_exchanges += chances == 0;
    if (chances > 0) chances--;
    info->iterations++;
  }
}

/* Checks that create was told of this kind of M. */
static dls_status principal_check_room(const dls_principal *work, const dls_lcp *lcp,
                                       dls_error *error) {
  const int most = work->settings.limits.blocks, has = lcp->Ms.p ? lcp->Ms.p[lcp->n] : 0;
  if (lcp->Ms.p ? most > 0 && has <= most : most == 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_SIZE, lcp->Ms.p ? "Ms" : "M", -1, has,
                   lcp->Ms.p ? "has %d entries, limits.blocks of create was %d"
                             : "is dense (%d entries of Ms), limits.blocks of create was %d",
                   has, most);
}

/* Checks the arguments of a solve and enters the workspace. */
static dls_status principal_enter(dls_principal *work, const dls_lcp *lcp, const double *z,
                                  dls_error *error) {
  if (!work) return dlsi_is_null(error, "workspace");
  dls_status status = dlsi_check_lcp(lcp, error);
  if (!status)
    status = dlsi_check_lcp_solve(work->n, lcp, z, work->settings.limits.warm_start, error);
  if (!status) status = principal_check_room(work, lcp, error);
  return status ? status : dlsi_enter(&work->busy, "workspace", error);
}

dls_status dls_principal_solve(dls_principal *workspace, const dls_lcp *lcp, double *z, double *y,
                               dls_principal_info *info, dls_error *error) {
  DLSI_DOOR;
  dls_principal *work = workspace;
  dls_status status = principal_enter(work, lcp, z, error);
  if (status) return dlsi_at(__func__, status, error);
  const int n = lcp->n;
  dls_principal_info result = {0};
  work->begun = dlsi_clock_start(&work->settings.limits);
  dlsi_lcp_weights(lcp, work->s);
  if (work->sparse) {
    memcpy(work->best, z, (size_t)n * sizeof *z);
    status = dlsi_active_run(work->sparse, lcp, &work->settings, work->begun, work->best, &result,
                             error);
    if (status < 0) return dlsi_at(__func__, dlsi_leave(&work->busy, status), error);
  } else {
    work->symmetric = principal_is_symmetric(lcp);
    principal_scale(work, lcp);
    for (int i = 0; i < n; i++)
      work->in[i] = work->settings.limits.warm_start && z[i] > 0;
    memset(work->best, 0, (size_t)n * sizeof *work->best);
    result.status = principal_iterate(work, lcp, &result);
  }
  for (int i = 0; i < n; i++)
    z[i] = work->best[i] > 0 ? work->best[i] : 0;
  dlsi_lcp_multiply(lcp, lcp->q, z, work->y, work->a);
  dlsi_lcp_measure(lcp, z, work->y, work->a, work->s, &result.certificate);
  if (y) memcpy(y, work->y, (size_t)n * sizeof *y);
  if (result.status == DLS_OK &&
      !dls_lcp_certificate_holds(&result.certificate, work->settings.limits.tol))
    result.status = DLS_STALLED;
  if (info) *info = result;
  dlsi_tell_last(&work->settings.limits, work->begun, "principal", "principal", result.iterations,
                 result.certificate.residual, z);
  return dlsi_leave(&work->busy, result.status);
}
