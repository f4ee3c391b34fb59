/*
 * crash.c: guesses a complementary basis of LCP(M, q) by block pivots, many pairs at a time, before
 * Lemke's method pivots one pair at a time.
 *
 *   y = M z + q,   y >= 0,  z >= 0,  y^T z = 0
 *
 * A basis is a set A of indices: z_i = 0 outside of A, y_i = 0 inside. One round:
 *
 *   (CR1)  M_AA z_A = -q_A,  y = M z + q;   M_AA singular: give up
 *   (CR2)  out = { i in A : z_i < 0 },  in = { i not in A : y_i < 0 };  both empty: a solution
 *   (CR3)  give up if (|M||z|)_i > 1000 |q_i| in most rows of A with q_i != 0, or after `patience`
 *          rounds in a row with |out| + |in| > 3/4 of the least before
 *   (CR4)  A := A \ out u in;  then remove each j with M_Aj = 0
 *
 * principal.c iterates in the same way with all of H, but removes nothing in (CR4). An index j with
 * M_jj = 0, as of a multiplier in the forms with friction, can enter a basis only with others.
 *
 * The guess can fail. It costs a few factorisations and is usually right if M is well conditioned,
 * as for elastic bodies: each round leaves 10 % to 50 % of the wrong signs. Near-singular bases, as
 * of statically indeterminate bodies, soon end by (CR3). There are at most 4 (1 + log_4/3 2n)
 * rounds. A change of units changes only rounding errors.
 *
 * Fewer and fewer indices change from round to round. If M_00 = P L U is known for an earlier basis
 * A_0, and A = A_0 \ D u E, then M_AA x = b is solved by
 *
 *   (CR5)  Y = M_00^-1 ( M_0E  I_D ),   x' = M_00^-1 b_0,
 *          ( M_E0 Y - ( M_EE 0 ) )       ( M_E0 x' - b_E )
 *          ( Y_D                 ) w  =  ( x'_D          ),    x_0 = x' - Y w,   x_E = w_E
 *
 * A column of Y costs 2 |A_0|^2 flops and is kept for later rounds. A factorisation costs
 * 2 |A|^3 / 3. M_AA is factorised again if Y would have more than |A_0| / 4 columns.
 *
 * Sources: Kostreva 1978; Judice and Pires 1994 (full references in principal.c).
 */
#include <math.h>
#include <string.h>

#include "lcp_internal.h"
#include "linear/pieces.h"

enum { patience = 4 };                      /* (CR3) */
static const double most_growth = 1e3;      /* (CR3) */
static const double crash_zero = 1e-13;     /* (CR2): relative to (|q| + |M||z|)_i */
static const double singular_pivot = 1e-12; /* relative to the terms of the pivot's sum */

void dlsi_crash_carve(dlsi_crash *work, dlsi_arena *arena, size_t n, size_t ld) {
  double **vectors[] = {&work->z, &work->y, &work->a, &work->b, &work->x, &work->v};
  int **indices[] = {&work->in,   &work->wrong,  &work->base,         &work->factors.pivot,
                     &work->slot, &work->differ, &work->change.pivot, &work->place};
  for (size_t k = 0; k < sizeof vectors / sizeof vectors[0]; k++)
    *vectors[k] = dlsi_take(arena, ld, sizeof(double));
  for (size_t k = 0; k < sizeof indices / sizeof indices[0]; k++)
    *indices[k] = dlsi_take(arena, n, sizeof(int));
}

/* Copies rows i[] and columns j[] of M to A (rows x columns, column-major). */
static void crash_gather(const dls_lcp *lcp, int rows, const int *i, int columns, const int *j,
                         double *A) {
  for (int l = 0; l < columns; l++) {
    const double *m = dlsi_lcp_column(lcp, j[l]);
    for (int k = 0; k < rows; k++)
      *A++ = m[i[k]];
  }
}

/* ---- the factors ----------------------------------------------------------------------------- */

/* Factorises f->A. Returns 1, or 0 if a pivot is only rounding error: at most 1e-12 times the sum
 * of |l_cl| |u_lc| that it was computed from, a test that units do not change. The loops run in
 * tiles because u_lc lies along a row. d: scratch, f->n. */
static int crash_lu(dlsi_dense *f, double *d) {
  const size_t n = (size_t)f->n, tile = 32;
  const double *A = f->A;
  if (n == 0) return 1;
  if (dlsi_dense_lu(f)) return 0;
  memset(d, 0, n * sizeof *d);
  for (size_t c0 = 0; c0 < n; c0 += tile)
    for (size_t l0 = 0; l0 <= c0; l0 += tile)
      for (size_t l = l0; l < l0 + tile && l < n; l++)
        for (size_t c = l < c0 ? c0 : l + 1; c < c0 + tile && c < n; c++)
          d[c] += fabs(A[c + l * n] * A[l + c * n]);
  for (size_t c = 0; c < n; c++)
    if (!(fabs(A[c + c * n]) > singular_pivot * d[c])) return 0;
  return 1;
}

/* Sets A_0 := A and factorises M_AA; returns 0 if it is singular. */
static int crash_start_anew(const dls_lcp *lcp, dlsi_crash *work) {
  int k = 0;
  for (int i = 0; i < lcp->n; i++) {
    work->slot[i] = -1;
    work->place[i] = work->in[i] ? k : -1;
    if (work->in[i]) work->base[k++] = i;
  }
  work->columns = work->change.n = 0;
  work->factors.n = k;
  crash_gather(lcp, k, work->base, k, work->base, work->factors.A);
  return crash_lu(&work->factors, work->x);
}

/* Returns 1 if i is in exactly one of A and A_0. */
static int crash_changed(const dlsi_crash *work, int i) {
  return work->in[i] != (work->place[i] >= 0);
}

/* Extends Y of (CR5) by the indices that have changed since A_0 and have no column yet; returns 0
 * if Y would have too many. */
static int crash_add_columns(const dls_lcp *lcp, dlsi_crash *work) {
  const size_t k = (size_t)work->factors.n, n = (size_t)lcp->n;
  size_t c = (size_t)work->columns;
  for (int i = 0; i < lcp->n; i++)
    c += crash_changed(work, i) && work->slot[i] < 0;
  if (4 * c > k || k * k + 2 * k * c + 2 * c * c > n * n) return 0;
  const int before = work->columns;
  double *added = work->factors.A + k * (k + (size_t)before), *y = added;
  for (int i = 0; i < lcp->n; i++) {
    if (!crash_changed(work, i) || work->slot[i] >= 0) continue;
    work->slot[i] = work->columns++;
    memset(y, 0, k * sizeof *y);
    if (work->in[i])
      crash_gather(lcp, (int)k, work->base, 1, &i, y);
    else
      y[work->place[i]] = 1;
    y += k;
  }
  dlsi_dense_solve(&work->factors, added, (int)k, work->columns - before);
  return 1;
}

/* Forms and factorises the matrix of (CR5); returns 0 if it is singular. */
static int crash_factor_changes(const dls_lcp *lcp, dlsi_crash *work) {
  const int K = work->factors.n;
  const size_t k = (size_t)K;
  const double *Y = work->factors.A + k * k;
  int e = 0, count = 0;
  for (int entering = 1; entering >= 0; entering--) { /* E before D */
    for (int i = 0; i < lcp->n; i++)
      if (crash_changed(work, i) && work->in[i] == entering) work->differ[count++] = i;
    if (entering) e = count;
  }
  const size_t h = (size_t)count;
  work->change.n = count;
  work->e = e;
  work->G = work->factors.A + k * (k + (size_t)work->columns);
  work->change.A = work->G + (size_t)e * k;
  double *product = work->change.A + h * h;
  crash_gather(lcp, e, work->differ, K, work->base, work->G);
  if (e > 0)
    dlsi_gemm(dlsi_is_small(k * k), 'N', 'N', e, work->columns, K, 1, work->G, e, Y, K, 0, product,
              e);
  for (size_t l = 0; l < h; l++) {
    const int j = work->differ[l];
    const double *y = Y + (size_t)work->slot[j] * k,
                 *p = product + (size_t)work->slot[j] * (size_t)e;
    double *t = work->change.A + l * h;
    for (int r = 0; r < e; r++)
      t[r] = p[r] - (work->in[j] ? dlsi_lcp_column(lcp, j)[work->differ[r]] : 0);
    for (int r = e; r < count; r++)
      t[r] = y[work->place[work->differ[r]]];
  }
  return crash_lu(&work->change, work->x);
}

/* z_A += M_AA^-1 b_A */
static void crash_correct(dlsi_crash *work, const double *b) {
  const int k = work->factors.n, h = work->change.n, e = work->e;
  const double *Y = work->factors.A + (size_t)k * (size_t)k;
  double *x = work->x, *v = work->v;
  for (int l = 0; l < k; l++)
    x[l] = work->in[work->base[l]] ? b[work->base[l]] : 0;
  dlsi_dense_solve(&work->factors, x, k, 1);
  for (int r = 0; r < h; r++)
    v[r] = r < e ? -b[work->differ[r]] : x[work->place[work->differ[r]]];
  if (h > 0 && e > 0 && k > 0)
    dlsi_gemv(dlsi_is_small((size_t)k * (size_t)k), e, k, 1, work->G, x, 1, v);
  dlsi_dense_solve(&work->change, v, h, 1);
  for (int r = 0; r < h; r++) {
    const double *y = Y + (size_t)work->slot[work->differ[r]] * (size_t)k;
    for (int l = 0; l < k; l++)
      x[l] -= y[l] * v[r];
    if (r < e) work->z[work->differ[r]] += v[r];
  }
  for (int l = 0; l < k; l++)
    if (work->in[work->base[l]]) work->z[work->base[l]] += x[l];
}

/* ---- the iteration --------------------------------------------------------------------------- */

/* Marks the wrong signs of (CR2) and returns their number; *hopeless := 1 if (CR3) gives up by
 * growth. */
static int crash_find_wrong(const dls_lcp *lcp, dlsi_crash *work, int *hopeless) {
  const double *q = lcp->q;
  int wrong = 0, loaded = 0, grown = 0;
  for (int i = 0; i < lcp->n; i++) {
    const double v = work->in[i] ? work->s[i] * work->z[i] : work->y[i];
    work->wrong[i] = !(v >= -crash_zero * (fabs(q[i]) + work->a[i])); /* 1 for NaN, too */
    wrong += work->wrong[i];
    loaded += work->in[i] && q[i] != 0;
    grown += work->in[i] && q[i] != 0 && !(work->a[i] <= most_growth * fabs(q[i]));
  }
  *hopeless = 2 * grown > loaded;
  return wrong;
}

/* (CR4) */
static void crash_exchange(const dls_lcp *lcp, dlsi_crash *work) {
  const int n = lcp->n;
  for (int i = 0; i < n; i++)
    work->in[i] ^= work->wrong[i];
  for (int j = 0; j < n; j++) {
    const double *m = dlsi_lcp_column(lcp, j);
    int i = 0;
    while (work->in[j] && i < n && (!work->in[i] || m[i] == 0))
      i++;
    if (i == n) work->in[j] = 0;
  }
}

void dlsi_crash_begin(const dls_lcp *lcp, const double *z, dlsi_crash *work) {
  work->rounds = work->factors.n = work->change.n = work->columns = 0;
  work->fewest = 2 * lcp->n; /* above any count */
  work->chances = patience;
  memset(work->z, 0, (size_t)lcp->n * sizeof *work->z); /* reported if round 1 fails */
  for (int i = 0; i < lcp->n; i++) {
    work->in[i] = z && z[i] > 0;
    work->place[i] = work->slot[i] = -1;
  }
}

int dlsi_crash_round(const dls_lcp *lcp, dlsi_crash *work) {
  const size_t n = (size_t)lcp->n;
  int hopeless;
  work->rounds++;
  if (crash_add_columns(lcp, work) ? !crash_factor_changes(lcp, work)
                                   : !crash_start_anew(lcp, work))
    return -1; /* (CR1) */
  memset(work->z, 0, n * sizeof *work->z);
  for (size_t i = 0; i < n; i++)
    work->b[i] = -lcp->q[i];
  crash_correct(work, work->b);
  dlsi_lcp_multiply(lcp, lcp->q, work->z, work->y, work->a);
  const int wrong = crash_find_wrong(lcp, work, &hopeless); /* (CR2) */
  if (hopeless) return -1;                                  /* (CR3) */
  if (wrong == 0) {                                         /* one step of refinement */
    for (size_t i = 0; i < n; i++)
      work->b[i] = -work->y[i];
    crash_correct(work, work->b);
    return 1;
  }
  if (4 * wrong <= 3 * work->fewest)
    work->chances = patience;
  else if (--work->chances == 0)
    return -1;
  if (wrong < work->fewest) work->fewest = wrong;
  crash_exchange(lcp, work); /* (CR4) */
  return 0;
}
