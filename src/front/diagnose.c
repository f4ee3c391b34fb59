/*
 * diagnose.c: facts about a contact problem u = W r + q, see delassus/diagnose.h.
 *
 * From here on W is the scaled matrix D^-1/2 W D^-1/2: with r_c = r'_c / sqrt(w_c), u_c = sqrt(w_c)
 * u'_c the laws of contact and friction, and mu, stay the same.
 *
 * How large friction may be
 * -------------------------
 * Above. Let r = (1, mu e), e = -W_nt^T / |W_nt|, at contact c alone, and u_c = (0, -e): slip.
 * Then q_c = u_c - W_cc r_c has q_n = mu |W_nt| - W_nn > 0 for mu > W_nn / |W_nt|, so that r = 0,
 * u_c = q_c is a second solution; large q_n keep all others free in both. Hence friction_critical.
 *
 * Below. Let (r, u) and (r', u') be two solutions for the same q,
 *
 *   y = r_n - r'_n,  x = r_t - r'_t,  p = u_n - u'_n,  v = u_t - u'_t.
 *
 * (DG1) y_c p_c = -r_n u'_n - r'_n u_n <= 0
 * (DG2) x_c . v_c <= mu_c |y_c| |v_c|, for r_t . u_t = -mu r_n |u_t|, r_t . u'_t >= -mu r_n |u'_t|
 *        give x . v <= -mu (r_n - r'_n) (|u_t| - |u'_t|)
 *
 * With T = W_tt^-1, P = W_nt T, Q = T W_tn, S = W_nn - W_nt T W_tn:
 *
 * (DG3) x = T v - Q y,  p = S y + P v
 *
 * Take tau >= 1 times the sum of (DG1) and once that of (DG2), mu = max mu_c, and Cauchy-Schwarz:
 *
 *   mu |y| |v| >= tau y.p + x.v = tau y^T S y + v^T T v + y^T (P - Q^T + (tau - 1) P) v
 *              >= tau s |y|^2 + t |v|^2 - (g + (tau - 1) h) |y| |v|
 *
 *   s = smallest eigenvalue of the symmetric part of S,  g = |P - Q^T|_2 (0 for symmetric W)
 *   t = smallest eigenvalue of the symmetric part of T,  h = |P|_2
 *
 * and tau s |y|^2 + t |v|^2 >= 2 sqrt(tau s t) |y| |v|. So y = v = 0, hence x = 0, if mu is less
 * than
 *
 * (DG4) mu* = max over tau >= 1 of 2 sqrt(tau s t) - (tau - 1) h - g
 *          = 2 k - g            if h >= k = sqrt(s t)     (tau = 1)
 *          = h + k^2 / h - g    if h <  k                 (tau = (k/h)^2)
 *
 * provided s, t > 0. The same lines with the thresholds mu_c b_c, mu_c b'_c in place of mu_c
 * r_n, mu_c r'_n give |y| <= (mu / mu*) |b - b'|: the fixed point on the sliding threshold
 * contracts. Its step is a variational inequality of the operator diag(tau, 1) (W r + q), strongly
 * monotone by the case mu = 0 of the above, and so has one solution: the fixed point exists,
 * whatever q is.
 *
 * Lemke (2D, the form of delassus/lcp.h). A secondary ray gives dz != 0 that solves LCP(M, dz0 d),
 * d > 0, dz0 >= 0: a friction problem with q = dz0 (d_1, d_2) and -mu r_n <= r_t <= mu r_n + dz0
 * d_3, for which (DG1), (DG2) hold all the same. It has the solution r = 0, and so no other:
 * phi_2 = 0, and if dz0 > 0, phi_1 > 0, lambda_2 = 0, that is dz = 0. If dz0 = 0, some dz has
 * lambda_2 > 0 and dy the same lambda_1; by complementarity phi_1 = phi_2 = 0 at the start of the
 * ray, but there phi_1 + phi_2 = 2 mu r_n + d_3 z0 > 0. So there is no ray, and Lemke's method
 * ends at the solution.
 *
 * How sharp mu* is: for one contact in 2D with W_nn W_tt >= 2 W_nt^2 it is W_nn / |W_nt|, the exact
 * value, and never more. For many contacts it decreases as 1 / sqrt(condition number). Projected
 * Gauss-Seidel and Newton may fail below it: data/failures/c13 has mu = 2 < mu* = 2.83, and both
 * cycle. (Gauss-Seidel solved 3600 of 3600 random problems, mu = 0.99 mu*, nc <= 12.)
 *
 * Cost: eigenvalues of an m x m and of some smaller symmetric matrices, one inverse. What can
 * fail: s and t carry rounding errors of eps times the condition number, and so does mu*.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "contact/contact.h"
#include "delassus/diagnose.h"
#include "delassus/solve.h"
#include "linear/blas.h"
#include "linear/dense.h"
#include "linear/pieces.h"

static void flaw_count(dls_flaw *flaw, int index) {
  if (flaw->count++ == 0) flaw->first = index;
}

/* ---- contacts -------------------------------------------------------------------------------- */

/* Returns 1 if B (d x d, not 0) is singular to rounding. Gauss elimination with complete
 * pivoting. */
static int is_singular_block(int d, double *B) {
  const size_t D = (size_t)d;
  const double tol = 8 * DBL_EPSILON * dlsi_max_abs(B, D * D);
  for (int k = 0; k < d; k++) {
    int pi = k, pj = k;
    for (int j = k; j < d; j++)
      for (int i = k; i < d; i++)
        if (fabs(B[i + d * j]) > fabs(B[pi + d * pj])) pi = i, pj = j;
    const double pivot = B[pi + d * pj];
    if (!(fabs(pivot) > tol)) return 1;
    for (int l = 0; l < d; l++) {
      const double x = B[k + d * l];
      B[k + d * l] = B[pi + d * l];
      B[pi + d * l] = x;
    }
    for (int l = 0; l < d; l++) {
      const double x = B[l + d * k];
      B[l + d * k] = B[l + d * pj];
      B[l + d * pj] = x;
    }
    for (int i = k + 1; i < d; i++)
      for (int j = k + 1; j < d; j++)
        B[i + d * j] -= B[i + d * k] / pivot * B[k + d * j];
  }
  return 0;
}

static void look_at_candidates(const dls_contact *problem, dls_diagnosis *g) {
  const int d = problem->d;
  const size_t D = (size_t)d;
  g->friction_min = g->friction_max = problem->mu[0];
  for (int c = 0; c < problem->nc; c++) {
    const double mu = problem->mu[c];
    if (mu < g->friction_min) g->friction_min = mu;
    if (mu > g->friction_max) g->friction_max = mu;
    g->closing += problem->q[D * (size_t)c] < 0;

    double B[9] = {0}, trace = 0;
    dlsi_contact_diagonal(problem, c, B);
    for (int i = 0; i < d; i++)
      trace += B[i + d * i];
    const double weight = trace / d, normal = B[0];
    if (weight > 0) {
      if (!(g->weight_min > 0) || weight < g->weight_min) g->weight_min = weight;
      if (weight > g->weight_max) g->weight_max = weight;
    }
    const double coupling = d == 2 ? fabs(B[2]) : hypot(B[3], B[6]);
    const double critical = !(normal > 0)                     ? 0
                            : coupling > DBL_EPSILON * normal ? normal / coupling
                                                              : INFINITY;
    if (mu > critical) flaw_count(&g->wedged, c);
    if (critical < g->friction_critical) {
      g->friction_critical = critical;
      g->critical = c;
    }
    if (!(dlsi_max_abs(B, D * D) > 0)) {
      flaw_count(&g->zero_block, c);
      continue;
    }
    if (!(weight > 0)) flaw_count(&g->no_weight, c);
    if (!(normal > 0)) flaw_count(&g->no_normal, c);
    if (is_singular_block(d, B)) flaw_count(&g->singular_block, c);
  }
}

/* ---- symmetry, columns without effect -------------------------------------------------------- */

/* The largest difference so far, and the largest entry of each column (m), all scaled. */
typedef struct comparison {
  const double *scale; /* nc: 1 / sqrt(w_c) */
  double difference, *column;
  int row, col;
} comparison;

static void differ(comparison *k, double difference, int i, int j) {
  if (!(difference > k->difference)) return;
  k->difference = difference;
  k->row = i < j ? i : j;
  k->col = i < j ? j : i;
}

static void raise_column(comparison *k, int j, double entry) {
  if (entry > k->column[j]) k->column[j] = entry;
}

static void compare_dense(const dls_contact *problem, comparison *k) {
  const int d = problem->d, m = d * problem->nc;
  const size_t ld = (size_t)problem->W.ld;
  const double *W = problem->W.a;
  for (int j = 0; j < m; j++)
    for (int i = 0; i < m; i++) {
      const double s = k->scale[i / d] * k->scale[j / d], x = s * W[(size_t)i + (size_t)j * ld];
      raise_column(k, j, fabs(x));
      if (i < j) differ(k, fabs(x - s * W[(size_t)j + (size_t)i * ld]), i, j);
    }
}

/* Lists the blocks by rows: those of block row a are at[k], in block column col[k], for first[a]
 * <= k < first[a+1]. */
typedef struct block_rows {
  int *first, *at, *col;
} block_rows;

static void list_rows(const dls_blocks *B, const block_rows *rows) {
  int *first = rows->first;
  for (int a = 0; a <= B->n; a++)
    first[a] = 0;
  for (int e = 0; e < B->p[B->n]; e++)
    first[B->i[e] + 1]++;
  for (int a = 0; a < B->n; a++)
    first[a + 1] += first[a];
  for (int c = 0; c < B->n; c++)
    for (int e = B->p[c]; e < B->p[c + 1]; e++) {
      const int place = first[B->i[e]]++; /* in the end first[a] is what first[a+1] was */
      rows->at[place] = e;
      rows->col[place] = c;
    }
  for (int a = B->n; a > 0; a--)
    first[a] = first[a - 1];
  first[0] = 0;
}

/* Compares x (d x d) = W_ac - W_ca^T with zero, and clears it for the next c. */
static void compare_block(comparison *k, int d, int a, int c, double *x) {
  for (int l = 0; l < d * d; l++) {
    differ(k, k->scale[a] * k->scale[c] * fabs(x[l]), d * a + l % d, d * c + l / d);
    x[l] = 0;
  }
}

/* Forms, for each c, block column c minus block row c transposed. X: scratch, nc blocks of d x d,
 * all 0. */
static void compare_blocks(const dls_blocks *B, const block_rows *rows, comparison *k, double *X) {
  const int d = B->d;
  const size_t D = (size_t)d, size = D * D;
  for (int c = 0; c < B->n; c++) {
    const int *end = B->i + B->p[c + 1], begin = rows->first[c], stop = rows->first[c + 1];
    for (int e = B->p[c]; e < B->p[c + 1]; e++)
      for (size_t l = 0; l < size; l++)
        X[(size_t)B->i[e] * size + l] += B->x[(size_t)e * size + l];
    for (const int *a = B->i + B->p[c]; a < end; a++)
      for (int l = 0; l < d * d; l++)
        raise_column(k, d * c + l / d,
                     k->scale[*a] * k->scale[c] * fabs(X[(size_t)*a * size + (size_t)l]));
    for (int f = begin; f < stop; f++)
      for (int l = 0; l < d * d; l++)
        X[(size_t)rows->col[f] * size + (size_t)l] -=
            B->x[(size_t)rows->at[f] * size + (size_t)(l / d + d * (l % d))];
    for (const int *a = B->i + B->p[c]; a < end; a++)
      compare_block(k, d, *a, c, X + (size_t)*a * size);
    for (int f = begin; f < stop; f++)
      compare_block(k, d, rows->col[f], c, X + (size_t)rows->col[f] * size);
  }
}

static dls_status look_at_symmetry(const dls_contact *problem, const double *scale,
                                   dls_diagnosis *g) {
  const size_t d = (size_t)problem->d, nc = (size_t)problem->nc, m = d * nc;
  const int blocks = problem->Wb.x != NULL;
  const size_t entries = blocks ? (size_t)problem->Wb.p[nc] : 0;
  double *work = dlsi_alloc(m + (blocks ? d * m : 0), sizeof *work);
  int *lists = dlsi_alloc(blocks ? nc + 1 + 2 * entries : 1, sizeof *lists);
  dls_status status = DLS_E_MEMORY;
  if (work && lists) {
    comparison k = {.scale = scale, .column = work, .row = -1, .col = -1};
    for (size_t i = 0; i < m + (blocks ? d * m : 0); i++)
      work[i] = 0;
    if (blocks) {
      const block_rows rows = {lists, lists + nc + 1, lists + nc + 1 + entries};
      list_rows(&problem->Wb, &rows);
      compare_blocks(&problem->Wb, &rows, &k, work + m);
    } else
      compare_dense(problem, &k);
    const double largest = dlsi_max_abs(k.column, m);
    g->asymmetry = k.difference > 0 ? k.difference / largest : 0;
    g->row = k.row;
    g->col = k.col;
    for (size_t j = 0; j < m; j++)
      if (!(k.column[j] > DBL_EPSILON * largest)) flaw_count(&g->no_effect, (int)j);
    status = DLS_OK;
  }
  free(work);
  free(lists);
  return status;
}

/* ---- eigenvalues ----------------------------------------------------------------------------- */

enum { eigen_work = 34 }; /* dsyev: (block size 32 + 2) n doubles */

/* Fills A (m x m) with the scaled W, the normal rows and columns of all contacts first. */
static void scaled_matrix(const dls_contact *problem, const double *scale, double *A) {
  const size_t d = (size_t)problem->d, nc = (size_t)problem->nc, m = d * nc;
  for (size_t e = 0; e < m * m; e++)
    A[e] = 0;
  for (size_t b = 0; b < nc; b++) {
    const dlsi_block_column blocks = dlsi_contact_column(problem, b);
    for (size_t j = 0; j < d; j++) {
      double *column = A + (j ? nc + (d - 1) * b + j - 1 : b) * m;
      for (size_t k = blocks.begin; k < blocks.end; k++) {
        const size_t a = dlsi_row(&blocks, k);
        const double *w = blocks.x + k * blocks.step + j * blocks.ld;
        for (size_t i = 0; i < d; i++)
          column[i ? nc + (d - 1) * a + i - 1 : a] += scale[a] * scale[b] * w[i];
      }
    }
  }
}

/* Finds the eigenvalues, ascending, of the symmetric part of X (n x n, leading dimension ld).
 * Returns 0 if an entry of it overflows or LAPACK did not converge. H: scratch, n x n. value: n.
 * work: scratch, 34 n. */
static int eigenvalues(int n, const double *X, int ld, double *H, double *value, double *work) {
  const size_t N = (size_t)n, L = (size_t)ld;
  for (size_t j = 0; j < N; j++)
    for (size_t i = j; i < N; i++)
      H[i + j * N] = 0.5 * X[i + j * L] + 0.5 * X[j + i * L];
  const int room = eigen_work * n;
  int info;
  for (size_t j = 0; j < N; j++) /* LAPACK would print */
    if (dlsi_first_not_finite(H + j + j * N, N - j) >= 0) return 0;
  dsyev_("N", "L", &n, H, &n, value, work, &room, &info, 1, 1);
  return info == 0;
}

static void look_at_eigenvalues(int m, const double *value, dls_diagnosis *g) {
  const double low = value[0], high = value[m - 1];
  const double size = -low > high ? -low : high;
  g->spectrum = 1;
  g->largest = high;
  g->smallest = low;
  g->noise = 4 * m * DBL_EPSILON;
  const double ratio = size > 0 ? -low / size : 0;
  if (ratio <= 1e-5 && 10 * ratio > g->noise) g->noise = 10 * ratio;
  g->rank = g->negative = 0;
  for (int i = m - 1; i >= 0; i--) {
    g->rank += fabs(value[i]) > g->noise * size;
    g->negative += value[i] < -g->noise * size;
    if (value[i] > g->noise * size) g->smallest_positive = value[i];
  }
}

/* Finds |X|_2, X being rows x cols, from X X^T. Returns 0 if LAPACK did not converge. */
static int spectral_norm(int rows, int cols, const double *X, double *XXt, double *H, double *value,
                         double *work, double *norm) {
  const size_t entries = (size_t)rows * (size_t)(rows + cols);
  dlsi_gemm(dlsi_is_small(entries), 'N', 'T', rows, rows, cols, 1, X, rows, X, rows, 0, XXt, rows);
  const int ok = eigenvalues(rows, XXt, rows, H, value, work);
  *norm = ok && value[rows - 1] > 0 ? sqrt(value[rows - 1]) : 0;
  return ok;
}

/* Returns mu* of (DG4), 0 if there is none. A: (W_nn W_nt; W_tn W_tt), m x m, overwritten. H, V:
 * scratch, m x m; V has room for T, P and Q: nt^2 + 2 nn nt < m^2. value: m. work: 34 m. */
static double unique_below(int nn, int nt, double *A, double *H, double *V, int *pivot,
                           double *value, double *work) {
  if (nt == 0) /* without tangents a positive definite W_nn is enough */
    return eigenvalues(nn, A, nn, H, value, work) && value[0] > 0 ? INFINITY : 0;
  const int m = nn + nt;
  const size_t N = (size_t)nn, L = (size_t)nt, M = (size_t)m;
  double *Wnn = A, *Wtn = A + N, *Wnt = A + N * M, *Wtt = Wnt + N;
  double *T = V, *P = T + L * L, *Q = P + N * L;

  for (size_t j = 0; j < L; j++)
    for (size_t i = 0; i < L; i++) {
      H[i + j * L] = Wtt[i + j * M];
      T[i + j * L] = i == j;
    }
  dlsi_dense factors = {.n = nt, .A = H, .pivot = pivot};
  if (dlsi_dense_lu(&factors)) return 0;
  dlsi_dense_solve(&factors, T, nt, nt); /* (DG3) */
  const int alone = dlsi_is_small(M * M);
  dlsi_gemm(alone, 'N', 'N', nn, nt, nt, 1, Wnt, m, T, nt, 0, P, nn);
  dlsi_gemm(alone, 'N', 'N', nt, nn, nt, 1, T, nt, Wtn, m, 0, Q, nt);
  dlsi_gemm(alone, 'N', 'N', nn, nn, nt, -1, P, nn, Wtn, m, 1, Wnn, m); /* S */

  double g, h;
  if (!eigenvalues(nn, Wnn, m, H, value, work)) return 0;
  const double s = value[0];
  if (!eigenvalues(nt, T, nt, H, value, work)) return 0;
  const double t = value[0];
  if (!(s > 0) || !(t > 0)) return 0;
  double *XXt = A; /* nn x nn; A is not needed any more */
  if (!spectral_norm(nn, nt, P, XXt, H, value, work, &h)) return 0;
  for (size_t j = 0; j < L; j++)
    for (size_t i = 0; i < N; i++)
      P[i + j * N] -= Q[j + i * L];
  if (!spectral_norm(nn, nt, P, XXt, H, value, work, &g)) return 0;

  const double k = sqrt(s * t); /* (DG4) */
  const double bound = (h >= k ? 2 * k : h + k * (k / h)) - g;
  return bound > 0 ? bound : 0;
}

static dls_status look_at_spectrum(const dls_contact *problem, const double *scale,
                                   dls_diagnosis *g) {
  const int nc = problem->nc, m = problem->d * nc;
  const size_t M = (size_t)m;
  double *A = dlsi_alloc(M * M, sizeof *A), *H = dlsi_alloc(M * M, sizeof *H);
  double *V = dlsi_alloc(M * M, sizeof *V);
  double *work = dlsi_alloc((eigen_work + 1) * M, sizeof *work);
  int *pivot = dlsi_alloc(M, sizeof *pivot);
  dls_status status = DLS_E_MEMORY;
  if (A && H && V && work && pivot) {
    double *value = work + eigen_work * M;
    scaled_matrix(problem, scale, A);
    if (eigenvalues(m, A, m, H, value, work)) {
      look_at_eigenvalues(m, value, g);
      if (g->rank == m && g->negative == 0)
        g->friction_unique = unique_below(nc, m - nc, A, H, V, pivot, value, work);
    }
    status = DLS_OK;
  }
  free(A);
  free(H);
  free(V);
  free(work);
  free(pivot);
  return status;
}

/* ---- hints ----------------------------------------------------------------------------------- */

/* Returns 1 if every q_n > 0. */
static int every_one_opens(const dls_contact *problem) {
  for (int c = 0; c < problem->nc; c++)
    if (!(problem->q[(size_t)problem->d * (size_t)c] > 0)) return 0;
  return 1;
}

/* Returns 1 if sweeps solve u = W r + q, W as given or a dense copy of it; 0 if not; -1 without
 * memory. r: scratch, m. */
static int sweeps_solve(const dls_contact *problem, double *r) {
  dls_solver_settings settings;
  dls_solver_settings_init(&settings);
  settings.method = DLS_NLGS;
  settings.acceleration = DLS_ACCELERATION_ANDERSON;
  settings.limits.max_iterations = 300;
  const dls_status status = dls_solve(problem, &settings, r, NULL, NULL, NULL);
  return status < 0 ? -1 : status == DLS_OK;
}

/* Checks if the transpose of an unsymmetric W has an answer where W has none. DLS_E_MEMORY. */
static dls_status look_at_transpose(const dls_contact *problem, dls_diagnosis *g) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  if (!(g->asymmetry > 1e-10) || g->closing == 0) return DLS_OK;
  double *r = dlsi_alloc(m, sizeof *r), *T = dlsi_alloc(m * m, sizeof *T);
  int solved = r && T ? sweeps_solve(problem, r) : -1;
  if (solved == 0) {
    dls_contact turned = *problem;
    turned.W = (dls_dense){(int)m, (int)m, (int)m, T};
    turned.Wb = (dls_blocks){0};
    turned.bodies = (dls_bodies){0};
    const dls_dense *W = &problem->W;
    if (problem->Wb.x && dls_blocks_to_dense(&problem->Wb, T, (int)m, NULL)) solved = -1;
    for (size_t j = 0; j < m && solved == 0; j++)
      for (size_t i = 0; i < j; i++) {
        const double lower = W->a ? W->a[j + i * (size_t)W->ld] : T[j + i * m];
        T[j + i * m] = W->a ? W->a[i + j * (size_t)W->ld] : T[i + j * m];
        T[i + j * m] = lower;
      }
    for (size_t i = 0; i < m && W->a; i++)
      T[i + i * m] = W->a[i + i * (size_t)W->ld];
    if (solved == 0 && (solved = sweeps_solve(&turned, r)) > 0) g->hints |= DLS_HINT_TRANSPOSED;
  }
  free(r);
  free(T);
  return solved < 0 ? DLS_E_MEMORY : DLS_OK;
}

/* ---- all ------------------------------------------------------------------------------------- */

static dls_status diagnose(const dls_contact *problem, int limit, dls_diagnosis *diagnosis,
                           dls_error *error) {
  dls_status status = dlsi_check_contact(problem, error);
  if (status) return status;
  if (limit < 0) return dlsi_fail(error, DLS_E_ARGUMENT, "limit", -1, limit, "is %d", limit);
  if (!diagnosis) return dlsi_is_null(error, "diagnosis");
  const dls_flaw none = {0, -1};
  dls_diagnosis g = {.row = -1,
                     .col = -1,
                     .zero_block = none,
                     .no_weight = none,
                     .no_normal = none,
                     .singular_block = none,
                     .no_effect = none,
                     .rank = -1,
                     .negative = -1,
                     .friction_critical = INFINITY,
                     .critical = -1,
                     .wedged = none};
  if (problem->nc == 0) { /* one answer, without entries */
    g.spectrum = 1;
    g.rank = g.negative = 0;
    g.friction_unique = INFINITY;
    *diagnosis = g;
    return DLS_OK;
  }
  double *scale = dlsi_alloc((size_t)problem->nc, sizeof *scale);
  if (!scale) return dlsi_no_memory(error);
  dlsi_contact_weights(problem, scale);
  for (int c = 0; c < problem->nc; c++)
    scale[c] = 1 / sqrt(scale[c]);

  const int m = problem->d * problem->nc;
  g.q_norm = dlsi_norm2(problem->q, (size_t)m);
  look_at_candidates(problem, &g);
  status = look_at_symmetry(problem, scale, &g);
  if (!status && m <= limit) status = look_at_spectrum(problem, scale, &g);
  if (!status && m <= limit) status = look_at_transpose(problem, &g);
  if (every_one_opens(problem)) g.hints |= DLS_HINT_OUTWARD;
  free(scale);
  if (status) return dlsi_no_memory(error);
  *diagnosis = g;
  return DLS_OK;
}

dls_status dls_contact_diagnose(const dls_contact *problem, int limit, dls_diagnosis *diagnosis,
                                dls_error *error) {
  DLSI_DOOR;
  dlsi_formed formed = {.work = NULL};
  dls_status status = dlsi_check_blas(error);
  if (!status) status = dlsi_form_blocks(&formed, &problem, error);
  if (!status) status = diagnose(problem, limit, diagnosis, error);
  dlsi_formed_free(&formed);
  return dlsi_at(__func__, status, error);
}
