/*
 * schur.c: schur.h by MUMPS (Amestoy, Duff, L'Excellent, Koster, SIAM J. Matrix Anal. Appl. 23, 2001,
 * 15-41).
 *
 *   create  (C1)  order all unknowns by nested dissection, then move c to the end
 *           (C2)  analysis
 *   factor  (F1)  A = R K C, scaled (scale.c); R = C if K is symmetric
 *           (F2)  A_ii = L D L^T without pivoting (positive definite) or L D L^T, L U with threshold
 *                 pivoting; S_A = A_cc - A_ci A_ii^-1 A_ic beside it; more room if pivoting asks for it
 *           (F3)  S_A = L L^T (LAPACK) if K is symmetric and S_A definite, else L U. S_A is definite
 *                 for many an indefinite K: multipliers that tie displacements make it so.
 *           (F4)  |A^-1|_F from two solves with vectors v of +-1: the mean of |A^-1 v|^2 is |A^-1|_F^2;
 *                 and their backward error, which is large where A_ii is nearly singular and A is not
 *   solve   (S1)  x := C A^-1 R b: condense b to c, solve with S_A, expand; without the last for x_c
 *   inverse (I1)  (K^-1)_cc = C_c S_A^-1 R_c
 *
 * The dissection is of the whole graph: contact unknowns that help to cut it are moved last only
 * afterwards. Left alone, MUMPS takes approximate minimum degree beside a Schur complement, which is much
 * dearer in 3D.
 *
 * Singular: 1 / (|A|_1 |A^-1|_F) < 10 eps, as for dense matrices in factor.c, or a pivot that is 0.
 * Cost: that of a multifrontal factorisation, b^3 for S^-1, two passes over the factor per solve, one for x_c.
 */
#include "linear/schur.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/base.h"
#include "linear/blas.h"
#include "linear/dissection.h"
#include "linear/equilibrate.h"
#include "linear/mumps.h"

enum { whole_solve = 0, condense = 1, expand = 2 }; /* ICNTL(26) */
enum { schur_lower = 2, schur_full = 3 };           /* ICNTL(19), by columns */
enum { probes = 2 };                                /* (F4) */

#define RINFOG(k) rinfog[(k)-1] /* as the users' guide numbers it */

struct dlsi_schur {
  DMUMPS_STRUC_C mumps;
  dls_factorization factorization;
  int n, count;
  int *row, *col;    /* entries, 1-based */
  double *x;         /* of A */
  int *order, *keep; /* n, count; 1-based */
  double *R, *C;     /* n */
  double *S;         /* count x count: its factor */
  int *pivot;        /* count */
  int definite;      /* S by Cholesky */
  double *reduced;   /* count x nrhs: right sides and solutions on c */
  size_t reduced_room;
  double norm, inverse_norm; /* |A|_1, |A^-1|_F */
  double error;              /* backward error of the solves of (F4) */
};

int dlsi_schur_available(void) {
  return 1;
}

/* A code of MUMPS as a status. */
static dls_status mumps_failed(const dlsi_schur *s, dls_error *error) {
  const int info = s->mumps.INFOG(1);
  if (info == singular || info == singular_structure)
    return dlsi_fail(error, DLS_E_SINGULAR, "Ks", -1, 0, "singular: a pivot of 0");
  return dlsi_fail(error, DLS_E_MEMORY, "", -1, info, "out of memory in MUMPS, its codes %d, %d",
                   info, s->mumps.INFOG(2));
}

/* ---- create ---------------------------------------------------------------------------------- */

static int symmetric(const dlsi_schur *s) {
  return s->factorization != DLS_LU;
}

/* Entries of Ks that count: for a symmetric K those of the lower triangle. */
static size_t count_entries(const dlsi_schur *s, const dls_sparse *Ks) {
  size_t entries = 0;
  for (int j = 0; j < s->n; j++)
    for (int k = Ks->p[j]; k < Ks->p[j + 1]; k++)
      entries += !symmetric(s) || Ks->i[k] >= j;
  return entries;
}

/* (C1): order[k] is the k-th unknown to be eliminated on entry, the turn of unknown k, from 1, on
 * exit; room (n) */
static void keep_last(dlsi_schur *s, int *room) {
  memcpy(room, s->order, (size_t)s->n * sizeof *room);
  for (int k = 0; k < s->n; k++)
    s->order[k] = 0;
  for (int k = 0; k < s->count; k++)
    s->order[s->keep[k] - 1] = s->n - s->count + k + 1;
  int turn = 0;
  for (int k = 0; k < s->n; k++)
    if (s->order[room[k]] == 0) s->order[room[k]] = ++turn;
}

static dls_status reserve(dlsi_schur *s, size_t entries, dls_error *error) {
  const size_t n = (size_t)s->n, b = (size_t)s->count;
  s->row = dlsi_alloc(entries, sizeof *s->row);
  s->col = dlsi_alloc(entries, sizeof *s->col);
  s->x = dlsi_alloc(entries, sizeof *s->x);
  s->order = dlsi_alloc(n, sizeof *s->order);
  s->keep = dlsi_alloc(b, sizeof *s->keep);
  s->R = dlsi_alloc(n, sizeof *s->R);
  s->C = dlsi_alloc(n, sizeof *s->C);
  s->pivot = dlsi_alloc(b, sizeof *s->pivot);
  const int got = s->row && s->col && s->x && s->order && s->keep && s->R && s->C && s->pivot;
  return got ? DLS_OK : dlsi_no_memory(error);
}

static void take_pattern(dlsi_schur *s, const dls_sparse *Ks, const int *keep) {
  size_t at = 0;
  for (int j = 0; j < s->n; j++)
    for (int k = Ks->p[j]; k < Ks->p[j + 1]; k++) {
      if (symmetric(s) && Ks->i[k] < j) continue;
      s->row[at] = Ks->i[k] + 1;
      s->col[at++] = j + 1;
    }
  for (int k = 0; k < s->count; k++)
    s->keep[k] = keep[k] + 1;
}

static dls_status order_unknowns(dlsi_schur *s, dls_error *error) {
  dls_status status = dlsi_dissection(s->n, (size_t)s->mumps.nnz, s->row, s->col, s->order, error);
  if (status) return status;
  int *room = dlsi_alloc((size_t)s->n, sizeof *room);
  if (!room) return dlsi_no_memory(error);
  keep_last(s, room);
  free(room);
  return DLS_OK;
}

static void set_up(dlsi_schur *s) {
  DMUMPS_STRUC_C *M = &s->mumps;
  M->ICNTL(6) = 0; /* no exchange of columns before the analysis */
  M->ICNTL(7) = 1; /* the order is given */
  M->ICNTL(8) = 0; /* (F1) is ours */
  M->n = s->n;
  M->irn = s->row;
  M->jcn = s->col;
  M->a = s->x;
  M->perm_in = s->order;
  if (s->count == 0) return;
  M->ICNTL(19) = symmetric(s) ? schur_lower : schur_full;
  M->size_schur = s->count;
  M->listvar_schur = s->keep;
  M->nprow = M->npcol = 1;
  M->mblock = M->nblock = 100; /* asked for, of no effect in one process */
  M->schur_lld = s->count;
}

dls_status dlsi_schur_create(dlsi_schur **out, const dls_sparse *Ks,
                             dls_factorization factorization, int count, const int *keep,
                             dls_error *error) {
  *out = NULL;
  dlsi_schur *s = dlsi_alloc(1, sizeof *s);
  if (!s) return dlsi_no_memory(error);
  memset(s, 0, sizeof *s);
  s->factorization = factorization;
  s->n = Ks->cols;
  s->count = count;
  const int sym = factorization == DLS_CHOLESKY ? 1 : factorization == DLS_LDLT ? 2 : 0;
  if (!dlsi_mumps_start(&s->mumps, sym)) {
    free(s);
    return dlsi_fail(error, DLS_E_MEMORY, "", -1, 0, "MUMPS does not start");
  }
  s->mumps.nnz = (MUMPS_INT8)count_entries(s, Ks);
  dls_status status = reserve(s, (size_t)s->mumps.nnz, error);
  if (!status) {
    take_pattern(s, Ks, keep);
    set_up(s);
    status = order_unknowns(s, error);
  }
  if (!status && dlsi_mumps_run(&s->mumps, analyse) < 0) status = mumps_failed(s, error); /* (C2) */
  if (status)
    dlsi_schur_destroy(s);
  else
    *out = s;
  return status;
}

/* MUMPS counts in millions what does not fit an int, and says so by the sign. */
static double large(int count) {
  return count < 0 ? -1e6 * count : count;
}

void dlsi_schur_estimate(const dlsi_schur *s, double *factor_bytes, double *bytes, double *flops) {
  const double b = s->count, entries = (double)s->mumps.nnz;
  *factor_bytes = (double)sizeof(double) * large(s->mumps.INFOG(3));
  *bytes = 1e6 * s->mumps.INFOG(16) + (2 * sizeof(int) + sizeof(double)) * entries +
           sizeof(double) * b * b;
  *flops = s->mumps.RINFOG(1) + (symmetric(s) ? 1 : 2) * b * b * b;
}

/* ---- factor ---------------------------------------------------------------------------------- */

dls_status dlsi_schur_same(const dlsi_schur *s, const dls_sparse *Ks, dls_error *error) {
  size_t at = 0;
  const size_t entries = (size_t)s->mumps.nnz;
  for (int j = 0; j < s->n; j++)
    for (int k = Ks->p[j]; k < Ks->p[j + 1]; k++) {
      if (symmetric(s) && Ks->i[k] < j) continue;
      if (at == entries || s->row[at] != Ks->i[k] + 1 || s->col[at] != j + 1)
        return dlsi_fail(error, DLS_E_ARGUMENT, "Ks", k, Ks->i[k],
                         "the pattern is not the one of create");
      at++;
    }
  if (at == entries) return DLS_OK;
  return dlsi_fail(error, DLS_E_ARGUMENT, "Ks", -1, (double)at,
                   "the pattern is not the one of create");
}

static void take_values(dlsi_schur *s, const dls_sparse *Ks) {
  size_t at = 0;
  for (int j = 0; j < s->n; j++)
    for (int k = Ks->p[j]; k < Ks->p[j + 1]; k++)
      if (!symmetric(s) || Ks->i[k] >= j) s->x[at++] = Ks->x[k];
}

/* (F1): x := entries of A, those of Ks at first; norm := |A|_1; room (2 n) */
static dls_status scale(dlsi_schur *s, const dls_sparse *Ks, double *room, dls_error *error) {
  dlsi_find_scales(Ks, symmetric(s), s->R, s->C, room);
  memset(room, 0, (size_t)s->n * sizeof *room);
  for (MUMPS_INT8 k = 0; k < s->mumps.nnz; k++) {
    const int i = s->row[k] - 1, j = s->col[k] - 1;
    s->x[k] *= s->R[i] * s->C[j];
    room[j] += fabs(s->x[k]);
    if (symmetric(s) && i != j) room[i] += fabs(s->x[k]);
  }
  s->norm = dlsi_max_abs(room, (size_t)s->n);
  if (s->norm <= DBL_MAX) return DLS_OK; /* false for NaN */
  return dlsi_fail(error, DLS_E_NOT_FINITE, "Ks", -1, s->norm, "overflow");
}

/* (F2) */
static dls_status eliminate(dlsi_schur *s, dls_error *error) {
  s->mumps.schur = s->S;
  const int info = dlsi_mumps_factor(&s->mumps);
  if (info < 0) return mumps_failed(s, error);
  const int negative = s->mumps.INFOG(12);
  if (s->factorization == DLS_CHOLESKY && negative > 0)
    return dlsi_fail(error, DLS_E_NOT_POSITIVE_DEFINITE, "Ks", -1, negative,
                     "not positive definite: %d negative pivots", negative);
  return DLS_OK;
}

/* The triangle above the diagonal := the one below; in tiles, for the cache's sake. */
static void mirror(double *A, size_t n) {
  enum { tile = 32 };
  for (size_t J = 0; J < n; J += tile)
    for (size_t I = J; I < n; I += tile)
      for (size_t j = J; j < n && j < J + tile; j++)
        for (size_t i = I > j ? I : j + 1; i < n && i < I + tile; i++)
          A[j + i * n] = A[i + j * n];
}

/* (F3); copy (count x count): room for a symmetric S that may be indefinite, else NULL */
static dls_status factor_dense(dlsi_schur *s, double *copy, dls_error *error) {
  const int b = s->count;
  const size_t entries = (size_t)b * (size_t)b;
  int info = 0;
  s->definite = 0;
  if (b == 0) return DLS_OK;
  if (copy) memcpy(copy, s->S, entries * sizeof *copy);
  if (symmetric(s)) {
    dpotrf_("L", &b, s->S, &b, &info, 1);
    s->definite = info == 0;
    if (s->definite) return DLS_OK;
    if (!copy) {
      const int unknown = s->keep[info - 1] - 1;
      const double pivot = s->S[(size_t)(info - 1) * ((size_t)b + 1)];
      return dlsi_fail(error, DLS_E_NOT_POSITIVE_DEFINITE, "Ks", unknown, pivot,
                       "not positive definite: pivot %.3g (scaled)", pivot);
    }
    memcpy(s->S, copy, entries * sizeof *copy);
    mirror(s->S, (size_t)b);
  }
  dgetrf_(&b, &b, s->S, &b, s->pivot, &info);
  if (info == 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_SINGULAR, "Ks", s->keep[info - 1] - 1, 0, "singular: a pivot of 0");
}

/* reduced (count x nrhs) := the values of A^-1 X on c. X is on loan to MUMPS until `expand`. */
static dls_status solve_kept(dlsi_schur *s, double *X, int nrhs, dls_error *error) {
  const int b = s->count;
  const size_t room = (size_t)b * (size_t)nrhs;
  if (room > s->reduced_room) {
    free(s->reduced);
    s->reduced = dlsi_alloc(room, sizeof *s->reduced);
    s->reduced_room = s->reduced ? room : 0;
    if (!s->reduced) return dlsi_no_memory(error);
  }
  s->mumps.rhs = X;
  s->mumps.nrhs = nrhs;
  s->mumps.lrhs = s->n;
  s->mumps.redrhs = s->reduced;
  s->mumps.lredrhs = b;
  s->mumps.ICNTL(26) = condense;
  if (dlsi_mumps_run(&s->mumps, solve) < 0) return mumps_failed(s, error);
  int unused;
  if (s->definite)
    dpotrs_("L", &b, &nrhs, s->S, &b, s->reduced, &b, &unused, 1);
  else
    dgetrs_("N", &b, &nrhs, s->S, &b, s->pivot, s->reduced, &b, &unused, 1);
  return DLS_OK;
}

/* X (n x nrhs) := A^-1 X */
static dls_status solve_scaled(dlsi_schur *s, double *X, int nrhs, dls_error *error) {
  if (s->count > 0) {
    const dls_status status = solve_kept(s, X, nrhs, error);
    if (status) return status;
  }
  s->mumps.rhs = X;
  s->mumps.nrhs = nrhs;
  s->mumps.lrhs = s->n;
  s->mumps.ICNTL(26) = s->count > 0 ? expand : whole_solve;
  return dlsi_mumps_run(&s->mumps, solve) < 0 ? mumps_failed(s, error) : DLS_OK;
}

/* (F4): the vectors v; the same each time */
static void make_probes(double *v, size_t entries) {
  unsigned long long seed = 1;
  for (size_t k = 0; k < entries; k++) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    v[k] = seed >> 63 ? 1 : -1;
  }
}

/* |v - A x| / (|A|_1 |x|), v becoming the difference */
static double backward_error(const dlsi_schur *s, const double *x, double *v) {
  const size_t n = (size_t)s->n;
  for (MUMPS_INT8 k = 0; k < s->mumps.nnz; k++) {
    const int i = s->row[k] - 1, j = s->col[k] - 1;
    v[i] -= s->x[k] * x[j];
    if (symmetric(s) && i != j) v[j] -= s->x[k] * x[i];
  }
  return dlsi_norm2(v, n) / (s->norm * dlsi_norm2(x, n));
}

/* (F4); room (2 probes n) */
static dls_status estimate_inverse(dlsi_schur *s, double *room, dls_error *error) {
  const size_t n = (size_t)s->n;
  double *x = room, *v = room + probes * n;
  make_probes(x, probes * n);
  make_probes(v, probes * n);
  const dls_status status = solve_scaled(s, x, probes, error);
  if (status) return status;
  s->inverse_norm = dlsi_norm2(x, probes * n) / sqrt(probes);
  s->error = 0;
  for (size_t k = 0; k < probes; k++) {
    const double e = backward_error(s, x + k * n, v + k * n);
    if (!(e <= s->error)) s->error = e;
  }
  if (dlsi_schur_rcond(s) >= 10 * DBL_EPSILON) return DLS_OK; /* false for NaN */
  size_t worst = 0;
  for (size_t i = 1; i < n; i++)
    if (fabs(x[i]) > fabs(x[worst])) worst = i;
  return dlsi_fail(error, DLS_E_SINGULAR, "Ks", (long long)worst, dlsi_schur_rcond(s),
                   "singular: condition %.3g (scaled)", 1 / dlsi_schur_rcond(s));
}

dls_status dlsi_schur_factor(dlsi_schur *s, const dls_sparse *Ks, dls_error *error) {
  const size_t n = (size_t)s->n, b = (size_t)s->count;
  const int copied = s->factorization == DLS_LDLT;
  double *room = dlsi_alloc(2 * probes * n, sizeof *room);
  double *copy = copied ? dlsi_alloc(b, b * sizeof *copy) : NULL;
  if (!s->S) s->S = dlsi_alloc(b, b * sizeof *s->S);
  dls_status status;
  if (room && s->S && (copy || !copied)) {
    take_values(s, Ks);
    status = scale(s, Ks, room, error);
    if (!status) status = eliminate(s, error);
    if (!status) status = factor_dense(s, copy, error);
    if (!status) status = estimate_inverse(s, room, error);
  } else
    status = dlsi_no_memory(error);
  free(copy);
  free(room);
  return status;
}

double dlsi_schur_error(const dlsi_schur *s) {
  return s->error;
}

double dlsi_schur_rcond(const dlsi_schur *s) {
  return 1 / (s->norm * s->inverse_norm);
}

/* ---- solve, inverse, destroy ----------------------------------------------------------------- */

static void scale_rows(const double *diagonal, size_t n, double *X, int nrhs) {
  for (int j = 0; j < nrhs; j++)
    for (size_t i = 0; i < n; i++)
      X[i + (size_t)j * n] *= diagonal[i];
}

dls_status dlsi_schur_solve(dlsi_schur *s, double *X, int nrhs, dls_error *error) {
  scale_rows(s->R, (size_t)s->n, X, nrhs);
  const dls_status status = solve_scaled(s, X, nrhs, error);
  if (!status) scale_rows(s->C, (size_t)s->n, X, nrhs);
  return status;
}

dls_status dlsi_schur_kept(dlsi_schur *s, double *x, double *z, dls_error *error) {
  scale_rows(s->R, (size_t)s->n, x, 1);
  const dls_status status = solve_kept(s, x, 1, error);
  for (int k = 0; !status && k < s->count; k++)
    z[k] = s->C[s->keep[k] - 1] * s->reduced[k];
  return status;
}

dls_status dlsi_schur_inverse(const dlsi_schur *s, double *Z, dls_error *error) {
  const int b = s->count;
  const size_t n = (size_t)b;
  int info;
  memcpy(Z, s->S, n * n * sizeof *Z);
  if (s->definite) {
    dpotri_("L", &b, Z, &b, &info, 1);
  } else {
    double best;
    const int ask = -1;
    dgetri_(&b, Z, &b, s->pivot, &best, &ask, &info);
    const int size = (int)best;
    double *work = dlsi_alloc((size_t)size, sizeof *work);
    if (!work) return dlsi_no_memory(error);
    dgetri_(&b, Z, &b, s->pivot, work, &size, &info);
    free(work);
  }
  for (size_t j = 0; j < n; j++) /* (I1) */
    for (size_t i = s->definite ? j : 0; i < n; i++)
      Z[i + j * n] *= s->C[s->keep[i] - 1] * s->R[s->keep[j] - 1];
  if (symmetric(s)) mirror(Z, n);
  return DLS_OK;
}

void dlsi_schur_destroy(dlsi_schur *s) {
  if (!s) return;
  (void)dlsi_mumps_run(&s->mumps, end);
  free(s->row);
  free(s->col);
  free(s->x);
  free(s->order);
  free(s->keep);
  free(s->R);
  free(s->C);
  free(s->S);
  free(s->pivot);
  free(s->reduced);
  free(s);
}
