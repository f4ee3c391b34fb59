/*
 * crash.c: a complementary basis for LCP(M, q) by exchanging many pairs at once, before Lemke's method
 * goes one pair at a time.
 *
 *   y = M z + q,   y >= 0,  z >= 0,  y^T z = 0
 *
 * A basis is a set A of indices: z_i = 0 outside of A, y_i = 0 inside. From the A given:
 *
 *   (K1)  M_AA z_A = -q_A,   y = M z + q;   M_AA singular: give up
 *   (K2)  out = { i in A : z_i < 0 },  in = { i not in A : y_i < 0 };  both empty: z is a solution
 *   (K3)  give up if (|M||z|)_i > 1000 |q_i| in most rows of A with q_i != 0, or after `patience` rounds
 *         in a row in which |out| + |in| was more than 3/4 of the least before
 *   (K4)  A := A \ out u in, without those j for which then M_Aj = 0
 *
 * This is (G1)-(G4) of principal.c with all of H, but for the last words: where M_jj = 0, as for the
 * multipliers in the forms with friction, j has no place in a basis but together with others.
 *
 * Nothing is promised. It is a guess that costs a few factorisations and is right as a rule where M is
 * well conditioned, as of elastic bodies: from round to round a half to a tenth of the wrong signs are
 * left. Near-singular bases, as of statically indeterminate bodies, show in (K3) soon; at the latest it
 * ends after 4 (1 + log_4/3 2n) rounds. A change of units changes nothing but roundings.
 *
 * The rounds differ in fewer and fewer indices. With M_00 = P L U for a former basis A_0, and now
 * A = A_0 \ D u E, M_AA x = b is solved by
 *
 *   (K5)  Y = M_00^-1 ( M_0E  I_D ),   x' = M_00^-1 b_0,
 *         ( M_E0 Y - ( M_EE 0 ) )       ( M_E0 x' - b_E )
 *         ( Y_D                 ) w  =  ( x'_D          ),    x_0 = x' - Y w,   x_E = w_E
 *
 * where 2 |A_0|^2 flops a column of Y replace 2 |A|^3 / 3; the columns stay for later rounds. M_AA is
 * factorised anew when they would be more than |A_0| / 4.
 */
#include <math.h>
#include <string.h>

#include "base/base.h"
#include "lcp_internal.h"
#include "linear/blas.h"

enum { patience = 4 };                      /* (K3) */
static const double most_growth = 1e3;      /* (K3) */
static const double zero_tolerance = 1e-13; /* (K2): to (|q| + |M||z|)_i */
static const double singular = 1e-12;       /* a pivot, to what it is the difference of */
static const double zero = 0, one = 1;
static const int unit = 1;

static const double *column(const dls_lcp *lcp, int j) {
  return lcp->M.a + (size_t)j * (size_t)lcp->M.ld;
}

/* A (rows x columns, column-major) := M of the rows i[] and columns j[] */
static void gather(const dls_lcp *lcp, int rows, const int *i, int columns, const int *j,
                   double *A) {
  for (int l = 0; l < columns; l++) {
    const double *m = column(lcp, j[l]);
    for (int k = 0; k < rows; k++)
      *A++ = m[i[k]];
  }
}

/* ---- LU -------------------------------------------------------------------------------------- */

enum { small = 24 }; /* where a call of LAPACK costs more than the arithmetic */

/* 1 if no pivot is what rounding leaves of 0: |u_cc| > 1e-12 sum_l |l_cl| |u_lc|, which units do not
 * change. Tile by tile, since u_lc runs along a row. d: k */
static int lu_is_regular(int k, const double *A, double *d) {
  const size_t n = (size_t)k, tile = 32;
  memset(d, 0, n * sizeof *d);
  for (size_t c0 = 0; c0 < n; c0 += tile)
    for (size_t l0 = 0; l0 <= c0; l0 += tile)
      for (size_t l = l0; l < l0 + tile && l < n; l++)
        for (size_t c = l < c0 ? c0 : l + 1; c < c0 + tile && c < n; c++)
          d[c] += fabs(A[c + l * n] * A[l + c * n]);
  for (size_t c = 0; c < n; c++)
    if (!(fabs(A[c + c * n]) > singular * d[c])) return 0;
  return 1;
}

/* P A = L U in place of A (k x k); 0 if A is singular. d: k */
static int lu_factorise(int k, double *A, int *pivots, double *d) {
  int info = 0;
  if (k > small) {
    dgetrf_(&k, &k, A, &k, pivots, &info);
    return info == 0 && lu_is_regular(k, A, d);
  }
  for (int c = 0; c < k; c++) {
    double *a = A + c * k;
    int p = c;
    for (int i = c + 1; i < k; i++)
      p = fabs(a[i]) > fabs(a[p]) ? i : p;
    pivots[c] = p + 1;
    if (a[p] == 0) return 0;
    for (int j = 0; j < k && p != c; j++) {
      const double x = A[c + j * k];
      A[c + j * k] = A[p + j * k];
      A[p + j * k] = x;
    }
    for (int i = c + 1; i < k; i++)
      a[i] /= a[c];
    for (int j = c + 1; j < k; j++) {
      double *b = A + j * k;
      for (int i = c + 1; i < k; i++)
        b[i] -= a[i] * b[c];
    }
  }
  return lu_is_regular(k, A, d);
}

/* B (k x columns) := A^-1 B */
static void lu_solve(int k, const double *A, const int *pivots, int columns, double *B) {
  int info;
  if (k > small) {
    dgetrs_("N", &k, &columns, A, &k, pivots, B, &k, &info, 1);
    return;
  }
  for (int l = 0; l < columns; l++) {
    double *b = B + l * k;
    for (int c = 0; c < k; c++) {
      const double x = b[pivots[c] - 1];
      b[pivots[c] - 1] = b[c];
      b[c] = x;
    }
    for (int c = 0; c < k; c++)
      for (int i = c + 1; i < k; i++)
        b[i] -= A[i + c * k] * b[c];
    for (int c = k - 1; c >= 0; c--) {
      b[c] /= A[c + c * k];
      for (int i = 0; i < c; i++)
        b[i] -= A[i + c * k] * b[c];
    }
  }
}

/* ---- the factors ----------------------------------------------------------------------------- */

/* A_0 := A; 0 if M_AA is singular */
static int factorise(const dls_lcp *lcp, dlsi_crash *w) {
  w->k = w->columns = w->h = 0;
  for (int i = 0; i < lcp->n; i++) {
    w->place[i] = w->slot[i] = -1;
    if (!w->in[i]) continue;
    w->place[i] = w->k;
    w->base[w->k++] = i;
  }
  gather(lcp, w->k, w->base, w->k, w->base, w->S);
  return lu_factorise(w->k, w->S, w->pivots, w->x);
}

static int changed(const dlsi_crash *w, int i) {
  return w->in[i] != (w->place[i] >= 0);
}

/* (K5) Y for what has changed since A_0 and has no column yet; 0 if that would be too many */
static int add_columns(const dls_lcp *lcp, dlsi_crash *w) {
  const size_t k = (size_t)w->k, n = (size_t)lcp->n;
  int added = 0;
  for (int i = 0; i < lcp->n; i++)
    added += changed(w, i) && w->slot[i] < 0;
  const size_t c = (size_t)w->columns + (size_t)added;
  if (4 * c > k || k * k + 2 * k * c + 2 * c * c > n * n) return 0;
  double *Y = w->S + k * (k + (size_t)w->columns);
  for (int i = 0, l = 0; i < lcp->n; i++) {
    if (!changed(w, i) || w->slot[i] >= 0) continue;
    double *y = Y + (size_t)l++ * k;
    w->slot[i] = w->columns++;
    if (w->in[i]) {
      gather(lcp, w->k, w->base, 1, &i, y);
    } else {
      memset(y, 0, k * sizeof *y);
      y[w->place[i]] = 1;
    }
  }
  if (added > 0) lu_solve(w->k, w->S, w->pivots, added, Y);
  return 1;
}

/* The matrix of (K5), factorised; 0 if it is singular. */
static int factorise_changes(const dls_lcp *lcp, dlsi_crash *w) {
  const size_t k = (size_t)w->k;
  const double *Y = w->S + k * k;
  int e = 0;
  w->h = 0;
  for (int entering = 1; entering >= 0; entering--) { /* E before D */
    for (int i = 0; i < lcp->n; i++)
      if (changed(w, i) && w->in[i] == entering) w->differ[w->h++] = i;
    if (entering) e = w->h;
  }
  const size_t h = (size_t)w->h;
  w->e = e;
  w->G = w->S + k * (k + (size_t)w->columns);
  w->T = w->G + (size_t)e * k;
  double *product = w->T + h * h;
  gather(lcp, e, w->differ, w->k, w->base, w->G);
  if (e > 0)
    dgemm_("N", "N", &e, &w->columns, &w->k, &one, w->G, &e, Y, &w->k, &zero, product, &e, 1, 1);
  for (size_t l = 0; l < h; l++) {
    const int j = w->differ[l];
    const double *y = Y + (size_t)w->slot[j] * k, *p = product + (size_t)w->slot[j] * (size_t)e;
    double *t = w->T + l * h;
    for (int r = 0; r < e; r++)
      t[r] = p[r] - (w->in[j] ? column(lcp, j)[w->differ[r]] : 0);
    for (int r = e; r < w->h; r++)
      t[r] = y[w->place[w->differ[r]]];
  }
  return lu_factorise(w->h, w->T, w->differ_pivots, w->x);
}

/* z_A += M_AA^-1 b_A */
static void correct(dlsi_crash *w, const double *b) {
  const int k = w->k, h = w->h, e = w->e;
  const double *Y = w->S + (size_t)k * (size_t)k;
  double *x = w->x, *v = w->v;
  for (int l = 0; l < k; l++)
    x[l] = w->in[w->base[l]] ? b[w->base[l]] : 0;
  lu_solve(k, w->S, w->pivots, 1, x);
  if (h > 0) {
    for (int r = 0; r < h; r++)
      v[r] = r < e ? -b[w->differ[r]] : x[w->place[w->differ[r]]];
    if (e > 0) dgemv_("N", &e, &k, &one, w->G, &e, x, &unit, &one, v, &unit, 1);
    lu_solve(h, w->T, w->differ_pivots, 1, v);
    for (int r = 0; r < h; r++) {
      const double *y = Y + (size_t)w->slot[w->differ[r]] * (size_t)k;
      for (int l = 0; l < k; l++)
        x[l] -= y[l] * v[r];
      if (r < e) w->z[w->differ[r]] += v[r];
    }
  }
  for (int l = 0; l < k; l++)
    if (w->in[w->base[l]]) w->z[w->base[l]] += x[l];
}

/* (K4) */
static void exchange(const dls_lcp *lcp, dlsi_crash *w) {
  const int n = lcp->n;
  for (int i = 0; i < n; i++)
    w->in[i] ^= w->wrong[i];
  for (int j = 0; j < n; j++) {
    const double *m = column(lcp, j);
    int i = 0;
    while (w->in[j] && i < n && (!w->in[i] || m[i] == 0))
      i++;
    if (i == n) w->in[j] = 0;
  }
}

/* ---- the iteration --------------------------------------------------------------------------- */

void dlsi_crash_begin(const dls_lcp *lcp, dlsi_crash *w) {
  w->rounds = w->k = w->h = w->columns = 0;
  w->fewest = 2 * lcp->n; /* anything is less */
  w->chances = patience;
  for (int i = 0; i < lcp->n; i++)
    w->place[i] = w->slot[i] = -1;
}

int dlsi_crash_round(const dls_lcp *lcp, dlsi_crash *w) {
  const int n = lcp->n;
  const double *q = lcp->q;
  w->rounds++;
  if (add_columns(lcp, w) ? !factorise_changes(lcp, w) : !factorise(lcp, w)) return -1; /* (K1) */
  memset(w->z, 0, (size_t)n * sizeof *w->z);
  for (int i = 0; i < n; i++)
    w->b[i] = -q[i];
  correct(w, w->b);
  dlsi_lcp_multiply(lcp, q, w->z, w->y, w->a);
  int wrong = 0, loaded = 0, grown = 0;
  for (int i = 0; i < n; i++) { /* (K2) */
    const double v = w->in[i] ? w->s[i] * w->z[i] : w->y[i];
    w->wrong[i] = !(v >= -zero_tolerance * (fabs(q[i]) + w->a[i]));
    wrong += w->wrong[i];
    loaded += w->in[i] && q[i] != 0;
    grown += w->in[i] && q[i] != 0 && !(w->a[i] <= most_growth * fabs(q[i]));
  }
  if (2 * grown > loaded) return -1; /* (K3) */
  if (wrong == 0) {
    for (int i = 0; i < n; i++)
      w->b[i] = -w->y[i];
    correct(w, w->b);
    return 1;
  }
  if (4 * wrong <= 3 * w->fewest)
    w->chances = patience;
  else if (--w->chances == 0)
    return -1;
  if (wrong < w->fewest) w->fewest = wrong;
  exchange(lcp, w); /* (K4) */
  return 0;
}
