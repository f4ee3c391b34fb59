/*
 * active.c: solves LCP(M, q), M in compressed columns, by block pivots on a sparse factor, and by a
 * smoothing path where they fail. dls_principal_solve calls it.
 *
 *   y = M z + q,   y >= 0,  z >= 0,  y^T z = 0
 *
 * A basis is a set A of indices: z_i = 0 outside of A, y_i = 0 inside. Rounds:
 *
 *   (AS1)  M_AA z_A = -q_A,   y = M z + q;   M_AA singular: the path
 *   (AS2)  H = { i in A : z_i < 0 } u { i not in A : y_i < 0 };   H empty: z is the solution
 *   (AS3)  |H| less than ever before: chances := block_steps; else one chance less; none: the path
 *   (AS4)  z := max(z, 0), then `sweeps` projected Gauss-Seidel sweeps;  A := { i : s_i z_i > y_i }
 *
 * Without the sweeps (AS4) is A := A xor H, and the border of A moves by one layer of a mesh in a
 * round: a membrane of 40,000 unknowns (side 200 in tests/lcp/test_active.c) takes 37 rounds, with
 * 30 sweeps 6. Sweeps need M_ii > 0 and skip other rows. They only choose A: where they diverge,
 * A := A xor H.
 *
 * The path, from the best z so far, with t = max |min(s z, y)| at first:
 *
 *   (AS5)  Phi_i = a_i + y_i - ( (a_i - y_i)^2 + 4 t^2 )^1/2,   a = s z    (s: the certificate's)
 *          V = D_a S + D_y M,   D_a, D_y the derivatives of Phi by a and y, both in (0, 2)
 *   (AS6)  V dz = -Phi,   z := z + l dz,   l = 1, 1/2, .. until |Phi|_2 falls
 *   (AS7)  max |Phi_i| <= t:  a round (AS1), (AS2) with A = { s z > y };  then t := t / 10
 *   (AS8)  t below the rounding level or tol / 1000 of |q|:  the certificate of max(z, 0) decides
 *
 * Why it ends for a P-matrix: V is regular for t > 0 (D_a, D_y > 0; also for a semidefinite M), and
 * { z : |Phi| <= c } is bounded, so that (AS6) reaches Phi = 0 for each t. As t -> 0, z -> the
 * solution z*. From some t on { z* > 0 } is in A and A in { y* = 0 }, and (AS1) returns z*. The
 * number of steps hardly depends on n (16 for optimal stopping in 1D with 20,000 unknowns), where
 * block pivots can take a round for each node that the border passes.
 *
 * Sources: the rounds, M. Kostreva 1978 (principal.c), and as a Newton method M. Hintermueller, K.
 * Ito, K. Kunisch, SIAM J. Optim. 13 (2003) 865-888; Phi, C. Kanzow, SIAM J. Matrix Anal. Appl. 17
 * (1996) 851-868; the path, J. V. Burke and S. Xu, Math. Oper. Res. 23 (1998) 719-734.
 *
 * Deviations: (AS4) and the rounds of (AS7). Cost: a factorisation of M_AA or V a round or step.
 * Can fail: no P-matrix: V singular, or |Phi| stays; no memory.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lcp_internal.h"
#include "linear/general.h"

enum { sweeps = 30 };                       /* (AS4): the work of 30 products with M */
static const double shrink = 0.1;           /* (AS7) */
static const double descent = 1e-4;         /* (AS6): relative fall of |Phi|^2, times l */
static const double shortest = 0x1p-40;     /* (AS6): less is rounding */
static const double fraction_of_tol = 1e-3; /* (AS8) */

struct dlsi_active {
  int n;
  dlsi_triplets matrix; /* that is factored; room for the entries of M and n more */
  dlsi_general factors;
  double *s, *diagonal;            /* weights of the certificate; M_ii, n */
  double *z, *y, *a;               /* the point, M z + q, |M||z|, n */
  double *v;                       /* the point of the path, n */
  double *f;                       /* Phi, n */
  double *x;                       /* a solution; scratch, n */
  double *da, *dy;                 /* D_a, D_y, n */
  double *best;                    /* z >= 0 of least residual, n */
  int *place;                      /* number of an unknown in A, n */
  char *in, *infeasible;           /* 1 for i in A; in H, n */
  dls_lcp_certificate certificate; /* of best */
  void *memory;
};

/* ---- create ---------------------------------------------------------------------------------- */

static void active_carve(dlsi_active *work, dlsi_arena *arena) {
  const size_t n = (size_t)work->n;
  double **vectors[] = {&work->s, &work->diagonal, &work->z,  &work->y,  &work->a,   &work->v,
                        &work->f, &work->x,        &work->da, &work->dy, &work->best};
  for (size_t k = 0; k < sizeof vectors / sizeof vectors[0]; k++)
    *vectors[k] = dlsi_take(arena, n, sizeof(double));
  work->place = dlsi_take(arena, n, sizeof *work->place);
  work->in = dlsi_take(arena, n, sizeof *work->in);
  work->infeasible = dlsi_take(arena, n, sizeof *work->infeasible);
}

dls_status dlsi_active_create(dlsi_active **out, int n, int entries, dls_error *error) {
  *out = NULL;
  if (entries > INT_MAX - n)
    return dlsi_fail(error, DLS_E_SIZE, "blocks", -1, entries, "is %d, too many", entries);
  dlsi_active *work = dlsi_alloc(1, sizeof *work);
  if (!work) return dlsi_no_memory(error);
  *work = (dlsi_active){.n = n};
  dlsi_arena arena = {0};
  active_carve(work, &arena);
  dls_status status = dlsi_arena_allocate(&arena, "n", n, error);
  if (!status) {
    work->memory = arena.base;
    active_carve(work, &arena);
    status = dlsi_triplets_alloc(n, n, (size_t)entries + (size_t)n, &work->matrix, error);
  }
  if (status)
    dlsi_active_destroy(work);
  else
    *out = work;
  return status;
}

void dlsi_active_destroy(dlsi_active *work) {
  if (!work) return;
  dlsi_general_free(&work->factors);
  dlsi_triplets_free(&work->matrix);
  free(work->memory);
  free(work);
}

/* ---- one basis ------------------------------------------------------------------------------- */

/* Sets the matrix to M_AA; returns |A|. */
static int active_gather(dlsi_active *work, const dls_sparse *M) {
  int k = 0;
  for (int i = 0; i < work->n; i++)
    work->place[i] = work->in[i] ? k++ : -1;
  dlsi_triplets *t = &work->matrix;
  t->rows = t->cols = k;
  t->count = 0;
  for (int j = 0; j < work->n; j++)
    for (int e = M->p[j]; work->in[j] && e < M->p[j + 1]; e++)
      if (work->in[M->i[e]]) dlsi_triplets_add(t, work->place[M->i[e]], work->place[j], M->x[e]);
  return k;
}

/* (AS1) Sets z, y, a. DLS_E_SINGULAR and the other errors of dlsi_general_factor. */
static dls_status active_solve_basis(dlsi_active *work, const dls_lcp *lcp,
                                     dls_principal_info *info, dls_error *error) {
  const int n = lcp->n, k = active_gather(work, &lcp->Ms);
  dls_status status = DLS_OK;
  memset(work->z, 0, (size_t)n * sizeof *work->z);
  info->factorizations += k > 0;
  if (k > 0) status = dlsi_general_factor(&work->factors, &work->matrix, error);
  for (int pass = 0; pass < 2 && k > 0 && !status; pass++) { /* solution, correction */
    dlsi_lcp_multiply(lcp, lcp->q, work->z, work->y, work->a);
    for (int i = 0; i < n; i++)
      if (work->in[i]) work->x[work->place[i]] = -work->y[i];
    status = dlsi_general_solve(&work->factors, 0, work->x, error);
    for (int i = 0; !status && i < n; i++)
      if (work->in[i]) work->z[i] += work->x[work->place[i]];
  }
  dlsi_lcp_multiply(lcp, lcp->q, work->z, work->y, work->a);
  return status;
}

/* (AS2) Returns |H|. */
static int active_find_infeasible(dlsi_active *work, const dls_lcp *lcp) {
  int count = 0;
  for (int i = 0; i < lcp->n; i++) {
    const double v = work->in[i] ? work->s[i] * work->z[i] : work->y[i];
    const int holds = v >= -4 * DBL_EPSILON * (fabs(lcp->q[i]) + work->a[i]); /* NaN does not */
    work->infeasible[i] = (char)!holds;
    count += !holds;
  }
  return count;
}

/* z := max(z, 0), with its y and a; keeps z where its residual is the least so far. */
static void active_keep(dlsi_active *work, const dls_lcp *lcp) {
  const size_t n = (size_t)lcp->n;
  dls_lcp_certificate c;
  for (size_t i = 0; i < n; i++)
    work->z[i] = work->z[i] > 0 ? work->z[i] : 0;
  dlsi_lcp_multiply(lcp, lcp->q, work->z, work->y, work->a);
  dlsi_lcp_measure(lcp, work->z, work->y, work->a, work->s, &c);
  if (!(c.residual < work->certificate.residual)) return;
  work->certificate = c;
  memcpy(work->best, work->z, n * sizeof *work->best);
}

/* A := { i : s_i z_i > y_i }. */
static void active_guess(dlsi_active *work, const double *z) {
  for (int i = 0; i < work->n; i++)
    work->in[i] = work->s[i] * z[i] > work->y[i];
}

/* (AS4) from z >= 0 and its y. */
static void active_sweep(dlsi_active *work, const dls_sparse *M) {
  const int n = work->n;
  double *z = work->z, *y = work->y;
  for (int sweep = 0; sweep < sweeps; sweep++)
    for (int k = 0; k < n; k++) {
      const int j = sweep % 2 ? n - 1 - k : k;
      if (!(work->diagonal[j] > 0)) continue;
      const double to = z[j] - y[j] / work->diagonal[j], dz = (to > 0 ? to : 0) - z[j];
      if (dz == 0) continue;
      z[j] += dz;
      for (int e = M->p[j]; e < M->p[j + 1]; e++)
        y[M->i[e]] += M->x[e] * dz;
    }
  if (dlsi_first_not_finite(y, (size_t)n) < 0)
    active_guess(work, z);
  else
    for (int i = 0; i < n; i++)
      work->in[i] = (char)(work->in[i] != work->infeasible[i]);
}

/* ---- rounds ---------------------------------------------------------------------------------- */

/* A solve: what its steps need. */
typedef struct active_run {
  const dls_lcp *lcp;
  const dls_principal_settings *settings;
  int limit;
  double begun;
  dls_principal_info *info;
  dls_error *error;
} active_run;

/* Counts a round or step, after it. Returns a reason to end, or DLS_OK. */
static dls_status active_count(const dlsi_active *work, const active_run *run, const char *stage) {
  dls_progress progress = {
      "principal", stage, run->info->iterations, run->limit, work->certificate.residual, work->best,
      0,           0};
  const dls_status stop = dlsi_tell(&run->settings->limits, run->begun, &progress);
  if (stop) return stop;
  if (run->info->iterations == run->limit) return DLS_MAX_ITERATIONS;
  run->info->iterations++;
  return DLS_OK;
}

/* Runs (AS1) and (AS2); sets *count := |H|, n + 1 for a singular M_AA. Returns an error or
 * DLS_OK. */
static dls_status active_try(dlsi_active *work, const active_run *run, int *count) {
  dls_error why = {0};
  const dls_status status = active_solve_basis(work, run->lcp, run->info, &why);
  *count = status ? run->lcp->n + 1 : active_find_infeasible(work, run->lcp);
  if (status && status != DLS_E_SINGULAR) {
    if (run->error) *run->error = why;
    return status;
  }
  if (!status) active_keep(work, run->lcp);
  return DLS_OK;
}

/* Runs rounds. Returns DLS_STALLED where the path is to go on. */
static dls_status active_rounds(dlsi_active *work, const active_run *run) {
  int count, fewest = run->lcp->n + 1, chances = 0;
  for (;;) {
    dls_status status = active_try(work, run, &count);
    if (status || count == 0) return status;
    chances = count < fewest ? run->settings->block_steps : chances - 1; /* (AS3) */
    if (chances <= 0) return DLS_STALLED;
    fewest = count < fewest ? count : fewest;
    status = active_count(work, run, "principal");
    if (status) return status;
    active_sweep(work, &run->lcp->Ms);
  }
}

/* ---- the path -------------------------------------------------------------------------------- */

/* (AS5) Sets f, da and dy for z and its y; returns |Phi|_2, *largest := max |Phi_i|. */
static double path_measure(dlsi_active *work, const double *z, double t, double *largest) {
  const size_t n = (size_t)work->n;
  for (size_t i = 0; i < n; i++) {
    const double a = work->s[i] * z[i], y = work->y[i], gap = fabs(a - y), d = hypot(gap, 2 * t);
    const double rest = 2 * t * (2 * t / (d + gap)); /* d - gap without cancellation */
    work->f[i] = 2 * (a < y ? a : y) - rest;
    work->da[i] = a > y ? rest / d : (d + gap) / d;
    work->dy[i] = a > y ? (d + gap) / d : rest / d;
  }
  *largest = dlsi_max_abs(work->f, n);
  return dlsi_norm2(work->f, n);
}

/* Sets the matrix to V. */
static void path_gather(dlsi_active *work, const dls_sparse *M) {
  dlsi_triplets *t = &work->matrix;
  t->rows = t->cols = work->n;
  t->count = 0;
  for (int j = 0; j < work->n; j++) {
    dlsi_triplets_add(t, j, j, work->da[j] * work->s[j]);
    for (int e = M->p[j]; e < M->p[j + 1]; e++)
      dlsi_triplets_add(t, M->i[e], j, work->dy[M->i[e]] * M->x[e]);
  }
}

/* (AS6) from v, f and its norm to the next v, f; *largest := max |Phi_i| there. Returns DLS_STALLED
 * if |Phi| does not fall, or an error. */
static dls_status path_step(dlsi_active *work, const active_run *run, double t, double norm,
                            double *largest) {
  const dls_lcp *lcp = run->lcp;
  const size_t n = (size_t)lcp->n;
  path_gather(work, &lcp->Ms);
  run->info->factorizations++;
  run->info->path_steps++;
  dls_status status = dlsi_general_factor(&work->factors, &work->matrix, run->error);
  for (size_t i = 0; i < n; i++)
    work->x[i] = -work->f[i];
  if (!status) status = dlsi_general_solve(&work->factors, 0, work->x, run->error);
  if (status) return status == DLS_E_SINGULAR ? DLS_STALLED : status;
  for (double l = 1; l >= shortest; l /= 2) {
    for (size_t i = 0; i < n; i++)
      work->z[i] = work->v[i] + l * work->x[i];
    dlsi_lcp_multiply(lcp, lcp->q, work->z, work->y, work->a);
    if (!(path_measure(work, work->z, t, largest) <= (1 - descent * l) * norm)) continue;
    memcpy(work->v, work->z, n * sizeof *work->v);
    return DLS_OK;
  }
  return DLS_STALLED;
}

static dls_status path_follow(dlsi_active *work, const active_run *run) {
  const dls_lcp *lcp = run->lcp;
  const size_t n = (size_t)lcp->n;
  const double tol = run->settings->limits.tol, finest = fraction_of_tol * tol;
  const double last = (finest > DBL_EPSILON ? finest : DBL_EPSILON) * dlsi_max_abs(lcp->q, n);
  double t = 0, largest;
  memcpy(work->v, work->best, n * sizeof *work->v);
  dlsi_lcp_multiply(lcp, lcp->q, work->v, work->y, work->a);
  for (size_t i = 0; i < n; i++) {
    const double a = work->s[i] * work->v[i], F = fabs(a < work->y[i] ? a : work->y[i]);
    if (!(F <= t)) t = F;
  }
  while (t > last) {
    dlsi_lcp_multiply(lcp, lcp->q, work->v, work->y, work->a);
    const double norm = path_measure(work, work->v, t, &largest);
    dls_status status = path_step(work, run, t, norm, &largest);
    if (status) return status;
    memcpy(work->z, work->v, n * sizeof *work->z);
    active_guess(work, work->v);
    active_keep(work, lcp);
    status = active_count(work, run, "path");
    if (status) return status;
    if (!(largest <= t)) continue; /* (AS7) */
    int count;
    status = active_try(work, run, &count);
    if (status || count == 0) return status;
    t *= shrink;
  }
  return DLS_STALLED; /* (AS8) */
}

/* ---- the door -------------------------------------------------------------------------------- */

dls_status dlsi_active_run(dlsi_active *work, const dls_lcp *lcp,
                           const dls_principal_settings *settings, double begun, double *z,
                           dls_principal_info *info, dls_error *error) {
  const size_t n = (size_t)lcp->n;
  const dls_limits *limits = &settings->limits;
  active_run run = {.lcp = lcp, .settings = settings, .begun = begun, .info = info, .error = error};
  work->n = lcp->n;
  run.limit = dlsi_most_iterations(limits, 10 * lcp->n + 1000);
  dlsi_lcp_weights(lcp, work->s);
  for (size_t i = 0; i < n; i++) {
    work->in[i] = limits->warm_start && z[i] > 0;
    work->diagonal[i] = dlsi_lcp_diagonal(lcp, i);
  }
  memset(work->best, 0, n * sizeof *work->best);
  work->certificate = (dls_lcp_certificate){.residual = INFINITY};
  dls_status status = active_rounds(work, &run);
  if (status == DLS_STALLED) status = path_follow(work, &run);
  if (status == DLS_STALLED && dls_lcp_certificate_holds(&work->certificate, limits->tol))
    status = DLS_OK;
  if (status < 0) return status;
  memcpy(z, work->best, n * sizeof *z);
  return info->status = status;
}
