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
 * Below: dlsi_unique_below, facts/bound.c.
 *
 * Cost: that of facts/bound.c.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "contact/contact.h"
#include "delassus/diagnose.h"
#include "delassus/solve.h"
#include "facts/facts.h"
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

static dls_status look_at_spectrum(const dls_contact *problem, const double *scale,
                                   dls_diagnosis *g) {
  const int m = problem->d * problem->nc;
  double *value = dlsi_alloc((size_t)m, sizeof *value);
  if (!value) return DLS_E_MEMORY;
  const dls_status status = dlsi_unique_below(problem, scale, value, &g->friction_unique);
  if (!status && !isnan(value[0])) look_at_eigenvalues(m, value, g);
  free(value);
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
