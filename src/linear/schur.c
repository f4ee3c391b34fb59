/*
 * schur.c: the Schur complement of a sparse matrix: by cholesky.c if the matrix is positive
 * definite, else by MUMPS (Amestoy, Duff, L'Excellent, Koster, SIAM J. Matrix Anal. Appl. 23, 2001,
 * 15-41).
 *
 *   create  (SH1)  order all unknowns by nested dissection, then move c to the end
 *           (SH2)  analyse
 *   factor  (SH3)  A = R K C, scaled (equilibrate.c); R = C if K is symmetric
 *           (SH4)  A_ii = L L^T (positive definite), or L D L^T, L U with threshold pivoting;
 *                  S_A = A_cc - A_ci A_ii^-1 A_ic as well; more room if pivoting asks for it
 *           (SH5)  S_A = L L^T if K is symmetric and S_A definite, else L U (dense.c). S_A is
 *                  definite for many an indefinite K: if multipliers tie displacements.
 *           (SH6)  |A^-1|_F from two solves with vectors v of +-1: the mean of |A^-1 v|^2 is
 *                  |A^-1|_F^2; and their backward error, which is large if A_ii is nearly singular
 *                  and A is not
 *   solve   (SH7)  x := C A^-1 R b: condense b to c, solve with S_A, expand; x_c needs no
 *                  expansion
 *   inverse (SH8)  (K^-1)_cc = C_c S_A^-1 R_c
 *   halves  (SH9)  condense b to c, and keep what (SH10) needs; (K^-1 b)_c from S_A
 *           (SH10) x := K^-1 (b + h), h on c: add h to the condensed b, solve with S_A, expand
 *
 * The dissection is of the whole graph: contact unknowns first help to cut it, and are then moved
 * to the end. By itself MUMPS uses approximate minimum degree with a Schur complement, which costs
 * much more in 3D.
 *
 * Singular: 1 / (|A|_1 |A^-1|_F) < 10 eps, as for dense matrices in reduction/factor.c, or a pivot
 * of 0. Cost: that of a multifrontal factorisation, b^3 for S^-1; two passes over the factor for a
 * solve, one for each half.
 */
#include "linear/schur.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "linear/cholesky.h"
#include "linear/dense.h"
#include "linear/dissection.h"
#include "linear/equilibrate.h"
#include "linear/mumps.h"
#include "linear/pieces.h"

enum { whole_solve = 0, condense = 1, expand = 2 }; /* ICNTL(26) */
enum { schur_lower = 2, schur_full = 3 };           /* ICNTL(19), by columns */
enum { probes = 2 };                                /* (SH6) */

#define RINFOG(k) rinfog[(k)-1] /* as the users' guide numbers it */

struct dlsi_schur {
  DMUMPS_STRUC_C mumps;    /* not started if K is positive definite */
  dlsi_cholesky *definite; /* NULL if K is not */
  dls_factorization factorization;
  dlsi_schur_measures measures;
  int n;
  size_t entries;
  int *row, *col;    /* entries, counted from 1 */
  double *x;         /* entries of A */
  int *order, *keep; /* n, count; counted from 1 */
  double *R, *C;     /* n */
  dlsi_dense S; /* count x count: S_A, then its factor; A belongs to `definite` if that is there */
  double *reduced;     /* count x nrhs: right-hand sides and solutions on c */
  double *before;      /* count: kept by dlsi_schur_condense for expand */
  int held;            /* 1: the forward pass of dlsi_schur_condense is there */
  size_t reduced_size; /* doubles */
  double norm;         /* |A|_1 */
  dlsi_watch *watch;   /* the caller's, or NULL */
};

int dlsi_schur_available(void) {
  return 1;
}

const dlsi_schur_measures *dlsi_schur_measured(const dlsi_schur *work) {
  return &work->measures;
}

/* ---- create ---------------------------------------------------------------------------------- */

static int schur_symmetric(const dlsi_schur *work) {
  return work->factorization != DLS_LU;
}

/* Returns 1 if entry k of column j of Ks is read: all, or those of the lower triangle. */
static int schur_reads(const dlsi_schur *work, const dls_sparse *Ks, int k, int j) {
  return !schur_symmetric(work) || Ks->i[k] >= j;
}

static size_t schur_entries(const dlsi_schur *work, const dls_sparse *Ks) {
  size_t entries = 0;
  for (int j = 0; j < work->n; j++)
    for (int k = Ks->p[j]; k < Ks->p[j + 1]; k++)
      entries += (size_t)schur_reads(work, Ks, k, j);
  return entries;
}

static dls_status schur_allocate(dlsi_schur *work, dls_error *error) {
  const size_t n = (size_t)work->n, b = (size_t)work->S.n, entries = work->entries;
  work->row = dlsi_alloc(entries, sizeof *work->row);
  work->col = dlsi_alloc(entries, sizeof *work->col);
  work->x = dlsi_alloc(entries, sizeof *work->x);
  work->order = dlsi_alloc(n, sizeof *work->order);
  work->keep = dlsi_alloc(b, sizeof *work->keep);
  work->R = dlsi_alloc(2 * n, sizeof *work->R);
  work->S.pivot = dlsi_alloc(b, sizeof *work->S.pivot);
  work->reduced = dlsi_alloc(b, sizeof *work->reduced);
  work->before = dlsi_alloc(b, sizeof *work->before);
  if (!work->row || !work->col || !work->x || !work->order || !work->keep || !work->R ||
      !work->S.pivot || !work->reduced || !work->before)
    return dlsi_no_memory(error);
  work->reduced_size = b;
  work->C = work->R + n;
  return DLS_OK;
}

static void schur_take_pattern(dlsi_schur *work, const dls_sparse *Ks, const int *keep) {
  size_t at = 0;
  for (int j = 0; j < work->n; j++)
    for (int k = Ks->p[j]; k < Ks->p[j + 1]; k++) {
      if (!schur_reads(work, Ks, k, j)) continue;
      work->row[at] = Ks->i[k] + 1;
      work->col[at++] = j + 1;
    }
  for (int k = 0; k < work->S.n; k++)
    work->keep[k] = keep[k] + 1;
}

/* (SH1) Fills order with the place of each unknown, counted from 1. */
static dls_status schur_order(dlsi_schur *work, dls_error *error) {
  const int n = work->n, b = work->S.n;
  int *sequence = dlsi_alloc((size_t)n, sizeof *sequence), turn = 0;
  if (!sequence) return dlsi_no_memory(error);
  const dls_status status =
      dlsi_dissection(n, work->entries, work->row, work->col, sequence, error);
  memset(work->order, 0, (size_t)n * sizeof *work->order);
  for (int k = 0; k < b; k++)
    work->order[work->keep[k] - 1] = n - b + k + 1;
  for (int k = 0; !status && k < n; k++)
    if (work->order[sequence[k]] == 0) work->order[sequence[k]] = ++turn;
  free(sequence);
  return status;
}

static void schur_set_up(dlsi_schur *work) {
  DMUMPS_STRUC_C *M = &work->mumps;
  M->ICNTL(6) = 0; /* no exchange of columns before the analysis */
  M->ICNTL(7) = 1; /* the order is given */
  M->ICNTL(8) = 0; /* (SH3) replaces the scaling of MUMPS */
  M->n = work->n;
  M->nnz = (MUMPS_INT8)work->entries;
  M->irn = work->row;
  M->jcn = work->col;
  M->a = work->x;
  M->perm_in = work->order;
  if (work->S.n == 0) return;
  M->ICNTL(19) = schur_symmetric(work) ? schur_lower : schur_full;
  M->size_schur = M->schur_lld = work->S.n;
  M->listvar_schur = work->keep;
  M->nprow = M->npcol = 1;
  M->mblock = M->nblock = 100; /* required, without effect in one process */
}

/* Converts a count of MUMPS: a negative one is in millions, as the count does not fit an int. */
static double schur_large(int count) {
  return count < 0 ? -1e6 * count : count;
}

static void schur_foresee(dlsi_schur *work) {
  const double b = work->S.n, entries = (double)work->entries;
  const dlsi_cholesky *L = work->definite;
  dlsi_schur_measures *measures = &work->measures;
  const double kept = (double)(2 * sizeof(int) + sizeof(double)) * entries;
  if (L) {
    measures->factor_bytes = (double)sizeof(double) * (double)L->panel[L->count];
    measures->bytes = measures->factor_bytes + (double)sizeof(double) * (double)L->update +
                      (double)sizeof(size_t) * entries + kept;
    measures->flops = L->flops + b * b * b;
    measures->fronts = L->count;
    return;
  }
  measures->factor_bytes = (double)sizeof(double) * schur_large(work->mumps.INFOG(3));
  measures->bytes = 1e6 * work->mumps.INFOG(16) + kept + sizeof(double) * b * b;
  measures->flops = work->mumps.RINFOG(1) + (schur_symmetric(work) ? 1 : 2) * b * b * b;
}

/* (SH2) The order is known. */
static dls_status schur_analyse(dlsi_schur *work, dls_error *error) {
  if (work->factorization == DLS_CHOLESKY)
    return dlsi_cholesky_create(&work->definite, work->n, work->entries, work->row, work->col,
                                work->order, work->S.n, error);
  const dls_status status =
      dlsi_mumps_start(&work->mumps, work->factorization == DLS_LDLT ? 2 : 0, mumps_alone, error);
  if (status) return status;
  schur_set_up(work);
  return dlsi_mumps_run(&work->mumps, analyse, "Ks", error);
}

dls_status dlsi_schur_create(dlsi_schur **out, const dls_sparse *Ks,
                             dls_factorization factorization, int count, const int *keep,
                             dls_error *error) {
  *out = NULL;
  dlsi_schur *work = calloc(1, sizeof *work);
  if (!work) return dlsi_no_memory(error);
  work->factorization = factorization;
  work->n = Ks->cols;
  work->S.n = count;
  work->entries = schur_entries(work, Ks);
  dls_status status = schur_allocate(work, error);
  if (!status) {
    schur_take_pattern(work, Ks, keep);
    status = schur_order(work, error);
  }
  if (!status) status = schur_analyse(work, error);
  if (status) {
    dlsi_schur_destroy(work);
    return status;
  }
  schur_foresee(work);
  *out = work;
  return DLS_OK;
}

/* ---- factor ---------------------------------------------------------------------------------- */

dls_status dlsi_schur_same(const dlsi_schur *work, const dls_sparse *Ks, dls_error *error) {
  size_t at = 0;
  const size_t entries = work->entries;
  for (int j = 0; j < work->n; j++)
    for (int k = Ks->p[j]; k < Ks->p[j + 1]; k++) {
      if (!schur_reads(work, Ks, k, j)) continue;
      if (at == entries || work->row[at] != Ks->i[k] + 1 || work->col[at] != j + 1)
        return dlsi_fail(error, DLS_E_ARGUMENT, "Ks", k, Ks->i[k],
                         "the pattern is not the one of create");
      at++;
    }
  if (at == entries) return DLS_OK;
  return dlsi_fail(error, DLS_E_ARGUMENT, "Ks", -1, (double)at,
                   "has %zu entries that are read, of %zu in create", at, entries);
}

/* (SH3) Fills x with the entries of A. scratch: 2 n. */
static dls_status schur_take_values(dlsi_schur *work, const dls_sparse *Ks, double *scratch,
                                    dls_error *error) {
  const int symmetric = schur_symmetric(work);
  size_t at = 0;
  dlsi_find_scales(Ks, symmetric, work->R, work->C, scratch);
  memset(scratch, 0, (size_t)work->n * sizeof *scratch);
  for (int j = 0; j < work->n; j++)
    for (int k = Ks->p[j]; k < Ks->p[j + 1]; k++) {
      const int i = Ks->i[k];
      if (!schur_reads(work, Ks, k, j)) continue;
      const double a = Ks->x[k] * (work->R[i] * work->C[j]);
      work->x[at++] = a;
      scratch[j] += fabs(a);
      if (symmetric && i != j) scratch[i] += fabs(a);
    }
  work->norm = dlsi_max_abs(scratch, (size_t)work->n);
  if (work->norm <= DBL_MAX) return DLS_OK; /* false for NaN */
  return dlsi_fail(error, DLS_E_NOT_FINITE, "Ks", -1, work->norm, "sums of entries overflow");
}

/* (SH4), (SH5) if K is positive definite. */
static dls_status schur_factor_definite(dlsi_schur *work, dls_error *error) {
  double pivot = 0;
  const int failed = dlsi_cholesky_factor(work->definite, work->x, &pivot);
  if (failed == dlsi_stopped) return DLS_CANCELLED;
  if (failed < 0) return dlsi_no_memory(error);
  if (failed > 0)
    return dlsi_fail(error, DLS_E_NOT_POSITIVE_DEFINITE, "Ks", work->definite->unknown[failed - 1],
                     pivot, "not positive definite: pivot %.3g (scaled)", pivot);
  work->S.A = dlsi_cholesky_of_kept(work->definite);
  work->S.cholesky = 1;
  return DLS_OK;
}

/* (SH4) */
static dls_status schur_eliminate(dlsi_schur *work, dls_error *error) {
  const size_t b = (size_t)work->S.n;
  if (!work->S.A) work->S.A = dlsi_alloc(b, b * sizeof *work->S.A);
  if (!work->S.A) return dlsi_no_memory(error);
  work->mumps.schur = work->S.A;
  return dlsi_mumps_factor(&work->mumps, "Ks", error);
}

/* (SH5) MUMPS leaves the lower triangle of a symmetric S. diagonal: scratch, count. */
static dls_status schur_factor_dense(dlsi_schur *work, double *diagonal, dls_error *error) {
  dlsi_dense *S = &work->S;
  if (S->n == 0) return DLS_OK;
  if (work->factorization == DLS_LDLT) dlsi_make_symmetric(S->A, (size_t)S->n, 0);
  const int failed =
      work->factorization == DLS_LDLT ? dlsi_dense_factor(S, diagonal) : dlsi_dense_lu(S);
  if (!failed) return DLS_OK;
  return dlsi_fail(error, DLS_E_SINGULAR, "Ks", work->keep[failed - 1] - 1, 0, "singular: pivot 0");
}

/* Computes the values of A^-1 X on c. reduced: receives them, count x nrhs. MUMPS keeps X until
 * `expand`. */
static dls_status schur_solve_kept(dlsi_schur *work, double *X, int nrhs, dls_error *error) {
  const int b = work->S.n;
  const size_t size = (size_t)b * (size_t)nrhs;
  work->held = 0;
  if (size > work->reduced_size) {
    free(work->reduced);
    work->reduced = dlsi_alloc(size, sizeof *work->reduced);
    work->reduced_size = work->reduced ? size : 0;
    if (!work->reduced) return dlsi_no_memory(error);
  }
  work->mumps.redrhs = work->reduced;
  work->mumps.lredrhs = b;
  work->mumps.ICNTL(26) = condense;
  const dls_status status = dlsi_mumps_solve(&work->mumps, X, nrhs, error);
  if (!status) dlsi_dense_solve(&work->S, work->reduced, b, nrhs);
  return status;
}

/* Solves X := A^-1 X. X: n x nrhs. */
static dls_status schur_solve_scaled(dlsi_schur *work, double *X, int nrhs, dls_error *error) {
  if (work->definite) return dlsi_cholesky_solve(work->definite, X, nrhs, error);
  if (work->S.n > 0) {
    const dls_status status = schur_solve_kept(work, X, nrhs, error);
    if (status) return status;
  }
  work->mumps.ICNTL(26) = work->S.n > 0 ? expand : whole_solve;
  return dlsi_mumps_solve(&work->mumps, X, nrhs, error);
}

/* Returns |v - A x| / (|A|_1 |x|); v becomes the difference. */
static double schur_backward_error(const dlsi_schur *work, const double *x, double *v) {
  const size_t n = (size_t)work->n;
  for (size_t k = 0; k < work->entries; k++) {
    const int i = work->row[k] - 1, j = work->col[k] - 1;
    v[i] -= work->x[k] * x[j];
    if (schur_symmetric(work) && i != j) v[j] -= work->x[k] * x[i];
  }
  return dlsi_norm2(v, n) / (work->norm * dlsi_norm2(x, n));
}

/* (SH6) x, v: scratch, n x probes. */
static dls_status schur_estimate_inverse(dlsi_schur *work, double *x, double *v, dls_error *error) {
  const size_t n = (size_t)work->n;
  dlsi_schur_measures *measures = &work->measures;
  unsigned long long seed = 1; /* equal vectors each time */
  for (size_t k = 0; k < probes * n; k++) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    x[k] = v[k] = seed >> 63 ? 1 : -1;
  }
  const dls_status status = schur_solve_scaled(work, x, probes, error);
  if (status) return status;
  measures->rcond = 1 / (work->norm * (dlsi_norm2(x, probes * n) / sqrt(probes)));
  measures->error = 0;
  for (size_t k = 0; k < probes; k++) {
    const double e = schur_backward_error(work, x + k * n, v + k * n);
    if (!(e <= measures->error)) measures->error = e;
  }
  if (measures->rcond >= 10 * DBL_EPSILON) return DLS_OK; /* false for NaN */
  size_t worst = 0;
  for (size_t i = 1; i < n; i++)
    if (fabs(x[i]) > fabs(x[worst])) worst = i;
  return dlsi_fail(error, DLS_E_SINGULAR, "Ks", (long long)worst, measures->rcond,
                   "singular: condition %.3g (scaled)", 1 / measures->rcond);
}

dls_status dlsi_schur_factor(dlsi_schur *work, const dls_sparse *Ks, dls_error *error) {
  const size_t n = (size_t)work->n;
  double *scratch = dlsi_alloc(2 * probes * n, sizeof *scratch);
  work->held = 0;
  dls_status status = scratch ? DLS_OK : dlsi_no_memory(error);
  if (!status) status = schur_take_values(work, Ks, scratch, error);
  if (!status && work->definite)
    status = schur_factor_definite(work, error);
  else if (!status) {
    status = schur_eliminate(work, error);
    if (!status && dlsi_watch_stops(work->watch, 0, DBL_MAX)) status = DLS_CANCELLED;
    if (!status) status = schur_factor_dense(work, scratch, error);
  }
  if (!status) status = schur_estimate_inverse(work, scratch, scratch + probes * n, error);
  free(scratch);
  return status;
}

/* ---- solve, inverse, destroy ----------------------------------------------------------------- */

dls_status dlsi_schur_solve(dlsi_schur *work, double *X, int nrhs, dls_error *error) {
  dlsi_scale_rows(work->R, (size_t)work->n, X, nrhs);
  const dls_status status = schur_solve_scaled(work, X, nrhs, error);
  if (!status) dlsi_scale_rows(work->C, (size_t)work->n, X, nrhs);
  return status;
}

/* (SH9) */
dls_status dlsi_schur_condense(dlsi_schur *work, double *x, double *z, dls_error *error) {
  const size_t b = (size_t)work->S.n;
  dls_status status = DLS_OK;
  work->held = 0;
  dlsi_scale_rows(work->R, (size_t)work->n, x, 1);
  if (work->definite)
    dlsi_cholesky_condense(work->definite, x, work->before);
  else {
    work->mumps.redrhs = work->before;
    work->mumps.lredrhs = work->S.n;
    work->mumps.ICNTL(26) = condense;
    status = dlsi_mumps_solve(&work->mumps, x, 1, error);
  }
  if (status) return status;
  work->held = 1;
  memcpy(z, work->before, b * sizeof *z);
  dlsi_dense_solve(&work->S, z, work->S.n, 1);
  for (size_t k = 0; k < b; k++)
    z[k] *= work->C[work->keep[k] - 1];
  return DLS_OK;
}

int dlsi_schur_holds(const dlsi_schur *work) {
  return work->held;
}

/* (SH10) MUMPS overwrites its forward pass with the expansion. */
dls_status dlsi_schur_expand(dlsi_schur *work, const double *h, double *x, dls_error *error) {
  const size_t b = (size_t)work->S.n;
  double *xc = work->reduced;
  for (size_t k = 0; k < b; k++)
    xc[k] = work->before[k] + work->R[work->keep[k] - 1] * h[k];
  dlsi_dense_solve(&work->S, xc, work->S.n, 1);
  dls_status status = DLS_OK;
  if (work->definite)
    dlsi_cholesky_expand(work->definite, xc, x);
  else {
    work->held = 0;
    work->mumps.redrhs = xc;
    work->mumps.lredrhs = work->S.n;
    work->mumps.ICNTL(26) = expand;
    status = dlsi_mumps_solve(&work->mumps, x, 1, error);
  }
  if (!status) dlsi_scale_rows(work->C, (size_t)work->n, x, 1);
  return status;
}

void dlsi_schur_watch(dlsi_schur *work, dlsi_watch *watch) {
  work->watch = watch;
  if (work->definite) work->definite->watch = watch;
}

dls_status dlsi_schur_inverse(const dlsi_schur *work, double *Z) {
  const size_t n = (size_t)work->S.n;
  if (dlsi_dense_inverse(&work->S, Z, work->watch)) return DLS_CANCELLED;
  for (size_t j = 0; j < n; j++) /* (SH8) */
    for (size_t i = work->S.cholesky ? j : 0; i < n; i++)
      Z[i + j * n] *= work->C[work->keep[i] - 1] * work->R[work->keep[j] - 1];
  if (schur_symmetric(work)) dlsi_make_symmetric(Z, n, 0);
  return DLS_OK;
}

void dlsi_schur_destroy(dlsi_schur *work) {
  if (!work) return;
  if (work->definite)
    dlsi_cholesky_destroy(work->definite);
  else
    free(work->S.A);
  if (work->mumps.n > 0) dlsi_mumps_end(&work->mumps);
  void *const owned[] = {work->row, work->col,     work->x,       work->order,  work->keep,
                         work->R,   work->S.pivot, work->reduced, work->before, work};
  for (size_t k = 0; k < sizeof owned / sizeof owned[0]; k++)
    free(owned[k]);
}
