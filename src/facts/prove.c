/*
 * prove.c: proves that one solution lies near an answer, and bounds the distance.
 *
 * In the states of the answer a solution has the unknowns y of states_matrix.c (vi): r_c where a
 * contact sticks, a = r_n and, d = 3, b = r.p where it slips, with t and p = t turned fixed:
 *
 * r_t lies on its cone, F = 0 are the laws, and |F'(y) - A| s <= B(delta) in the box |y - y0| <=
 * delta s, s = 1 / w (prove_box.c, PR1 to PR3). Then
 *
 *   (PR4)  |A^-1| |F(y0)| + delta |A^-1| B <= delta s,   |A^-1| B < s
 *
 * By (PR4) y - A^-1 F(y) maps the box into itself and contracts it (Krawczyk): F has one zero in
 * the box. In the whole box, widened by delta s for free contacts, the inequalities of the states
 * hold strictly: a solution in it has these states and is that zero. The error of r is at most |E|
 * (|A^-1| |F| + delta |A^-1| B).
 *
 *   (PR5)  P A = L U, Z = U^-1 L^-1 by substitution:  |P A Z - 1| <= g |L| |U| |Z|,  g = 2 (n + 4)
 *          eps (Higham 2002, 9.3 and 8.5: 3 n eps / 2 for any order of sums). With theta its
 *          largest row sum, |A^-1| v <= |Z| (|P v| + theta / (1 - theta) max |v|)
 *
 * First steps -A^-1 F improve y; if a step changes states, all starts again.
 *
 *   (PR7)  If A is singular up to rounding, pivots on its diagonal choose unknowns that it
 *          determines. The others keep their values, and their equations need not hold: their
 *          residual, at most |F| + delta B, is subtracted from q.
 *
 * Cost: 2 n^3, no product of matrices. What can fail: contacts on a border of states; an A so
 * ill-conditioned that theta or |A^-1| B / s is near 1: from 1e12 or so on.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "facts/prove.h"
#include "linear/blas.h"
#include "linear/pieces.h"

enum { turns = 4, steps = 6, panel = 32 };
static const double most_theta = 0.5;   /* (PR5) */
static const double determined = 1e-10; /* (PR7): pivots over the first one */
static const double most_perturbed = 1e-12;

/* ---- the matrix ------------------------------------------------------------------------------ */

/* J := A of the unknowns in use. */
static void prove_fill(dlsi_prove *work) {
  const size_t n = (size_t)work->n, all = (size_t)work->all;
  double *J = work->J.J;
  dlsi_states_fill(work->problem, work->branch, NULL, work->all, work->row, work->z, J);
  for (size_t j = 0; n < all && j < n; j++) /* keep ascends: nothing is overwritten too early */
    for (size_t i = 0; i < n; i++)
      J[i + j * n] = J[(size_t)work->keep[i] + (size_t)work->keep[j] * all];
}

/* Improves y by steps -A^-1 F, the first from an F in double precision. */
static void prove_improve(dlsi_prove *work, const dlsi_dense *factors) {
  const int d = work->problem->d, nc = work->problem->nc;
  double *x = work->v2, before = INFINITY, now;
  dlsi_prove_put(work);
  dlsi_contact_multiply(work->problem, NULL, work->r, work->u, NULL);
  for (int k = 0; k < steps; k++) {
    dlsi_prove_laws(work);
    now = dlsi_max_abs(work->F, (size_t)work->n);
    if (k && !(now < before / 2 && now > dlsi_max_abs(work->du, (size_t)(d * nc)))) return;
    before = now;
    dlsi_dense_solve(factors, work->F, work->n, 1);
    memset(x, 0, (size_t)work->all * sizeof *x);
    for (int i = 0; i < work->n; i++)
      x[work->keep[i]] = -work->F[i];
    for (int c = 0; c < nc; c++) {
      const dlsi_branch *at = &work->branch[c];
      const int across = at->state == DLS_SLIP && at->count == 2;
      for (int i = 0; i < at->count - across; i++)
        work->r[d * c + i] += x[at->first + i];
      if (across) work->b[c] += x[at->first + 1];
    }
    dlsi_prove_put(work);
    dlsi_prove_positions(work);
  }
  dlsi_prove_laws(work);
}

/* (PR5) Z := U^-1 L^-1. L^-1 is lower triangular: its columns from j on need only those rows. */
static void prove_invert(dlsi_prove *work) {
  const int n = work->n, alone = dlsi_is_small((size_t)n * (size_t)n);
  double *Z = work->Z.J, *LU = work->J.J;
  memset(Z, 0, (size_t)n * (size_t)n * sizeof *Z);
  for (int j = 0; j < n; j += panel) {
    const int some = n - j < panel ? n - j : panel;
    const size_t corner = (size_t)j * ((size_t)n + 1);
    for (int k = j; k < j + some; k++)
      Z[(size_t)k * ((size_t)n + 1)] = 1;
    dlsi_trsm(alone, 'L', 'L', 'N', 'U', n - j, some, LU + corner, n, Z + corner, n);
    dlsi_trsm(alone, 'L', 'U', 'N', 'N', n, some, LU, n, Z + (size_t)j * (size_t)n, n);
  }
}

/* y := |M| x for the whole of M (part 0), its upper triangle (1), or the lower one with a unit
 * diagonal (2), times up. */
static void prove_matrix_times(const dlsi_prove *work, const double *M, int part, const double *x,
                               double *y) {
  const size_t n = (size_t)work->n;
  for (size_t i = 0; i < n; i++)
    y[i] = part == 2 ? x[i] : 0;
  for (size_t j = 0; j < n; j++) {
    const double *column = M + j * n, by = x[j];
    for (size_t i = part == 2 ? j + 1 : 0; i < (part == 1 ? j + 1 : n); i++)
      y[i] += fabs(column[i]) * by;
  }
  for (size_t i = 0; i < n; i++)
    y[i] *= work->up;
}

/* Returns theta of (PR5). */
static double prove_theta(dlsi_prove *work) {
  const int n = work->n;
  for (int i = 0; i < n; i++)
    work->B[i] = 1;
  prove_matrix_times(work, work->Z.J, 0, work->B, work->g);
  prove_matrix_times(work, work->J.J, 1, work->g, work->B);
  prove_matrix_times(work, work->J.J, 2, work->B, work->g);
  return 2 * (n + 4) * DBL_EPSILON * dlsi_max_abs(work->g, (size_t)n) * work->up;
}

/* (PR5) y (n) := an upper bound of |A^-1| v. */
static void prove_solve(dlsi_prove *work, double theta, const double *v, double *y) {
  const size_t n = (size_t)work->n;
  const double more = theta / (1 - theta) * dlsi_max_abs(v, n) * work->up;
  memcpy(work->z, v, n * sizeof *v);
  for (size_t k = 0; k < n; k++) {
    const size_t p = (size_t)work->pivot[k] - 1;
    const double x = work->z[k];
    work->z[k] = work->z[p];
    work->z[p] = x;
  }
  for (size_t k = 0; k < n; k++)
    work->z[k] += more;
  prove_matrix_times(work, work->Z.J, 0, work->z, y);
}

/* ---- the proof ------------------------------------------------------------------------------- */

/* (PR4) for the unknowns in use. Returns the delta for which it holds, with v := the bound on |y* -
 * y|; 0 for none. */
static double prove_contraction(dlsi_prove *work) {
  const size_t n = (size_t)work->n;
  double least = 0;
  const double theta = n ? prove_theta(work) : 0;
  if (!(theta <= most_theta)) return 0;
  prove_solve(work, theta, work->v, work->g);
  for (int c = 0, k = 0; c < work->problem->nc; c++) /* F := the scales of the unknowns */
    for (; k < work->n && work->keep[k] < work->branch[c].first + work->branch[c].count; k++) {
      work->F[k] = work->s[c];
      least = fmax(least, work->g[k] / work->s[c]);
    }
  const double first = 2 * least + DBL_MIN, last = 200 * first;
  if (!(last <= DBL_MAX)) return 0;
  for (double delta = first; delta <= last; delta *= 10) {
    double *y = work->v, holds = 1;
    if (!dlsi_prove_slopes(work, delta)) return 0;
    prove_solve(work, theta, work->B, y);
    for (size_t k = 0; k < n; k++) {
      if (!(y[k] < work->F[k] / 2)) holds = 0;
      y[k] = (work->g[k] + delta * y[k]) * work->up;
      if (!(y[k] <= delta * work->F[k])) holds = 0;
    }
    if (holds > 0) return delta;
  }
  return 0;
}

/* Tries to prove a solution near the point given by r and its states. */
static dls_status prove_try(dlsi_prove *work, dls_proof *proof, dls_error *error) {
  dls_status status = dlsi_room_dense(&work->J, (size_t)work->all, error);
  if (!status) status = dlsi_room_dense(&work->Z, (size_t)work->n, error);
  if (status) return status;
  dlsi_dense factors = {.n = work->n, .A = work->J.J, .pivot = work->pivot};
  proof->border = 0;
  if (work->n) prove_fill(work);
  if (work->n && dlsi_dense_lu(&factors)) return DLS_OK;
  prove_improve(work, &factors);
  if (work->n) prove_invert(work);
  const double delta = prove_contraction(work);
  if (!(delta > 0)) return DLS_OK;
  const double lack = dlsi_prove_lack(work, delta);
  if (!(lack <= most_perturbed)) return DLS_OK;
  dlsi_prove_states(work, delta, proof);
  if (proof->border) return DLS_OK;
  proof->box = 0.7 * delta; /* |b| <= sqrt(2) max |r_t| */
  proof->perturbed = lack;
  dlsi_prove_radii(work, delta, proof);
  proof->kind = work->n < work->all ? DLS_PROVED_POSITIONS : DLS_PROVED;
  return DLS_OK;
}

/* Sets the states of r. Returns 1 if a state has changed. */
static int prove_choose(dlsi_prove *work) {
  const dls_contact *problem = work->problem;
  const int d = problem->d;
  int changed = 0;
  double F[3];
  memset(work->turned, 0, (size_t)d * (size_t)problem->nc * sizeof *work->turned);
  dlsi_contact_multiply(problem, NULL, work->r, work->u, NULL);
  for (int c = 0; c < problem->nc; c++) {
    const dls_contact_state before = work->state[c];
    work->state[c] = dlsi_contact_misfit(d, problem->mu[c], work->weights + 2 * c, work->r + d * c,
                                         work->u + d * c, F);
    changed += work->state[c] != before;
    work->b[c] = 0;
  }
  work->all = work->n = dlsi_branches_set(problem, work->state, work->r, work->u, work->branch);
  for (int k = 0; k < work->n; k++)
    work->keep[k] = k;
  return changed;
}

static int prove_ascending(const void *a, const void *b) {
  return *(const int *)a - *(const int *)b;
}

/* Factors A (n x n, its diagonal scaled to 1) by pivots on its diagonal, the largest one first:
 * order (n) receives them. Returns how many are more than `least` of the first one. */
static int pivot_diagonal(int n, double *A, double least, int *order) {
  double first = 0;
  for (int k = 0; k < n; k++)
    order[k] = k;
  for (int k = 0; k < n; k++) {
    int p = k;
    for (int i = k + 1; i < n; i++)
      if (fabs(A[order[i] * (n + 1)]) > fabs(A[order[p] * (n + 1)])) p = i;
    const int pivot = order[p];
    order[p] = order[k];
    order[k] = pivot;
    const double a = A[pivot * (n + 1)];
    if (k == 0) first = fabs(a);
    if (!(fabs(a) > least * first)) return k;
    for (int l = k + 1; l < n; l++) {
      double *column = A + (size_t)order[l] * (size_t)n;
      const double factor = column[pivot] / a;
      if (factor == 0) continue;
      const double *by = A + (size_t)pivot * (size_t)n;
      for (int i = k + 1; i < n; i++)
        column[order[i]] -= by[order[i]] * factor;
    }
  }
  return n;
}

/* (PR7) Selects the unknowns that A determines. Returns 0 if these are all of them, or none. */
static dls_status prove_reduce(dlsi_prove *work, int *reduced, dls_error *error) {
  const size_t n = (size_t)work->all;
  *reduced = 0;
  const dls_status status = dlsi_room_dense(&work->J, n, error);
  if (status || !n) return status;
  work->n = work->all;
  prove_fill(work);
  for (int c = 0; c < work->problem->nc; c++)
    for (int k = work->branch[c].first; k < work->branch[c].first + work->branch[c].count; k++)
      work->v[k] = work->s[c];
  for (size_t j = 0; j < n; j++)
    for (size_t i = 0; i < n; i++)
      work->J.J[i + j * n] *= work->v[i];
  if (dlsi_first_not_finite(work->J.J, n * n) >= 0) return DLS_OK;
  work->n = pivot_diagonal((int)n, work->J.J, determined, work->keep);
  qsort(work->keep, (size_t)work->n, sizeof *work->keep, prove_ascending);
  *reduced = work->n < work->all;
  return DLS_OK;
}

static dls_status prove_run(dlsi_prove *work, dls_proof *proof, dls_error *error) {
  const size_t m = (size_t)work->problem->d * (size_t)work->problem->nc;
  dls_status status = DLS_OK;
  int reduced = 0;
  for (int turn = 0; !status && turn < turns; turn++) {
    const int changed = prove_choose(work), again = turn == 1 && !proof->border;
    proof->rows = work->all;
    if (turn && !changed && !again) break; /* again: directions of slip are better now */
    status = prove_try(work, proof, error);
    if (proof->kind) return status;
  }
  if (status || proof->border) return status;
  memcpy(work->r, work->given, m * sizeof *work->r);
  (void)prove_choose(work);
  status = prove_reduce(work, &reduced, error);
  if (!status && reduced) {
    proof->freedom = work->all - work->n;
    status = prove_try(work, proof, error);
  }
  return status;
}

/* ---- the call -------------------------------------------------------------------------------- */

static void prove_carve(void *workspace, dlsi_arena *arena) {
  dlsi_prove *work = workspace;
  const size_t nc = (size_t)work->problem->nc, m = (size_t)work->problem->d * nc;
  double **const of_contacts[] = {&work->w, &work->s, &work->b};
  double **const vectors[] = {
      &work->r,  &work->given,  &work->u, &work->a, &work->du, &work->h, &work->extra, &work->Wh,
      &work->We, &work->turned, &work->F, &work->B, &work->g,  &work->z, &work->v,     &work->v2};
  work->sum = dlsi_take(arena, m, sizeof *work->sum);
  for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++)
    *vectors[k] = dlsi_take(arena, m, sizeof(double));
  for (size_t k = 0; k < sizeof of_contacts / sizeof *of_contacts; k++)
    *of_contacts[k] = dlsi_take(arena, nc, sizeof(double));
  work->weights = dlsi_take(arena, 2 * nc, sizeof *work->weights);
  work->branch = dlsi_take(arena, nc, sizeof *work->branch);
  work->state = dlsi_take(arena, nc, sizeof *work->state);
  work->row = dlsi_take(arena, m, sizeof *work->row);
  work->pivot = dlsi_take(arena, m, sizeof *work->pivot);
  work->keep = dlsi_take(arena, m, sizeof *work->keep);
}

dls_status dlsi_contact_prove(const dls_contact *problem, const double *r, dls_proof *proof,
                              double *improved, dls_error *error) {
  const size_t nc = (size_t)problem->nc, m = (size_t)problem->d * nc;
  dls_proof found = {.contact = -1};
  void *memory;
  dlsi_prove filled = {.problem = problem, .up = 1 + 4 * (double)(m + 16) * DBL_EPSILON};
  dls_status status =
      dlsi_carve_workspace(&memory, &filled, sizeof filled, prove_carve, "nc", problem->nc, error);
  if (status) return status;
  dlsi_prove *work = memory;
  dlsi_both_weights(problem, work->w, work->weights);
  for (size_t c = 0; c < nc; c++)
    work->s[c] = 1 / work->w[c];
  memcpy(work->r, r, m * sizeof *r);
  memcpy(work->given, r, m * sizeof *r);
  status = prove_run(work, &found, error);
  if (!status) *proof = found;
  if (!status && improved) memcpy(improved, found.kind ? work->r : work->given, m * sizeof *r);
  dlsi_room_free(&work->J);
  dlsi_room_free(&work->Z);
  free(work);
  return status;
}

/* Takes the proof and the improved r (m, or NULL) back to the caller's units. Nothing is proved
 * of an r that these units round. */
static void prove_leave_units(dlsi_units *units, size_t m, dls_proof *proof, double *improved) {
  const int power = units->q - units->W;
  proof->box = ldexp(proof->box, units->q);
  if (!improved || (!units->q && !units->W)) return;
  if (dlsi_shift_exactly(m, power, improved, improved)) return;
  dlsi_shift(m, power, units->r, improved);
  *proof = (dls_proof){.contact = -1, .rows = proof->rows};
}

dls_status dls_contact_prove(const dls_contact *problem, const double *r, dls_proof *proof,
                             double *improved, dls_error *error) {
  DLSI_DOOR;
  dlsi_formed formed = {.work = NULL};
  dlsi_units units = {.W = 0};
  dls_status status = dlsi_check_blas(error);
  if (!status) status = dlsi_check_contact(problem, error);
  if (!status) status = dlsi_check_vector("r", r, (size_t)problem->d * (size_t)problem->nc, error);
  if (!status && !proof) status = dlsi_is_null(error, "proof");
  const size_t m = status ? 0 : (size_t)problem->d * (size_t)problem->nc;
  if (!status) status = dlsi_take_answer(&units, &problem, &r, error);
  if (!status) status = dlsi_form_blocks(&formed, &problem, error);
  if (!improved) improved = units.shown; /* NULL for no copy */
  if (!status) status = dlsi_contact_prove(problem, r, proof, improved, error);
  if (!status) prove_leave_units(&units, m, proof, improved);
  dlsi_formed_free(&formed);
  dlsi_units_free(&units);
  return dlsi_at(__func__, status, error);
}
