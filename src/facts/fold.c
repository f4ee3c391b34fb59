/*
 * fold.c: the least friction at which the solution folds: at which the matrix of some states of the
 * contacts becomes singular; d = 2, W positive definite.
 *
 * Here W is the scaled matrix D^-1/2 W D^-1/2 (diagnose.c), and mu_c is lambda times s_c, the
 * largest s_c being 1. If contacts K stick, S slip to the sides e_c = +-1, and the others are free,
 * the unknowns are r_n and r_t of K and r_n of S, the equations u_n = 0 of both and u_t = 0 of K:
 *
 *   (FO1)  (A + lambda B) y = 0,  A = W on the rows and columns of the unknowns,
 *          B = its columns t of S times e_c s_c, in place of the columns n of S
 *
 * W is positive definite, so that A is regular. With X = A^-1 B and E its rows of S,
 *
 *   (FO2)  lambda = -1 / g for the real eigenvalues g < 0 of E; y = X z for E z = g z
 *
 * Other sides change signs of the columns of E. All sides reversed turn g into -g: the least lambda
 * over both is 1 / max |g|.
 *
 * For lambda = 0 all determinants are positive. As long as they are, the map from (r, u) in their
 * states to q, piecewise linear, is one to one and onto: each q has one solution (Scholtes,
 * Introduction to piecewise differentiable equations, 2012, coherent orientation). When one
 * determinant changes its sign, it is not, and some q have several solutions.
 *
 * Witness: r = 1 in the scaled normals, u = 1 off the contact and against the slip, so that all
 * states hold strictly; q = u - W r. A short step along y changes only these u: another solution.
 *
 * Beyond DLS_STATES_MAX contacts (FO3): start with all contacts slipping to one side, then from
 * random states. Change the state of one contact as long as that raises max |g|.
 *
 * Source: Hassani, Hild, Ionescu, Sufficient conditions of non-uniqueness for the Coulomb friction
 * problem, Math. Methods Appl. Sci. 27 (2004) 47-67: the eigenvalue problem of one choice of
 * states. This file also searches the states.
 *
 * Cost: 4^nc / 2 eigenvalue problems of up to nc rows; in (FO3) up to 1e8 / nc^3, at least 30 nc.
 * What can fail: (FO3) misses the states of the fold, and returns too large a friction.
 */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "facts/facts.h"
#include "linear/blas.h"
#include "linear/dense.h"
#include "vi/newton/states_matrix.h"

enum { starts = 200 };            /* (FO3) */
enum { least_rounds = 30 };       /* (FO3): changes of each contact, at least */
static const double effort = 1e8; /* (FO3): 4e9 / 40 */
static const double rise = 1e-9;  /* of max |g|: more than rounding */

typedef enum fold_state { FOLD_FREE, FOLD_STICK, FOLD_UP, FOLD_DOWN } fold_state;

typedef struct fold_search {
  int nc, looked;
  double *W;                       /* m x m, scaled */
  double *scale;                   /* nc: 1 / sqrt(w_c) */
  double *share;                   /* nc: s_c */
  double *A, *X, *E, *V;           /* of (FO1), (FO2): m x m, m x nc, nc x nc twice */
  double *real, *imaginary, *work; /* nc, nc, 8 nc */
  int *pivot, *unknown, *slips;    /* m; m: index into r of each; nc: row of X of each S */
  fold_state *state, *best;        /* nc */
  dlsi_branch *branch;             /* nc */
  double largest;                  /* |g| of best */
} fold_search;

/* ---- one matrix ------------------------------------------------------------------------------ */

/* Sets X of (FO2) with all e_c = 1. Returns the number of rows, *slipping: |S|; 0 if A is singular
 * or S is empty. */
static int fold_condense(fold_search *f, const fold_state *state, int *slipping) {
  const int m = 2 * f->nc;
  const dls_contact scaled = {.d = 2, .nc = f->nc, .W = {m, m, m, f->W}};
  int k = 0, s = 0;
  for (int c = 0; c < f->nc; c++) { /* (FO1): A is that of slip without friction */
    const short stick = state[c] == FOLD_STICK;
    const short count = (short)(state[c] == FOLD_FREE ? 0 : 1 + stick);
    f->branch[c] = (dlsi_branch){.state = stick ? DLS_STICK : DLS_SLIP, .count = count, .first = k};
    if (count && !stick) f->slips[s++] = k;
    k += count;
  }
  *slipping = s;
  if (!s) return 0;
  dlsi_states_fill(&scaled, f->branch, NULL, k, f->unknown, NULL, f->A);
  for (int j = 0; j < s; j++) {
    const int n = f->unknown[f->slips[j]];
    double *X = f->X + (size_t)j * (size_t)k;
    dlsi_branches_rows(2, f->nc, f->branch, f->W + (size_t)(n + 1) * (size_t)m, X);
    for (int i = 0; i < k; i++)
      X[i] *= f->share[n / 2];
  }
  dlsi_dense factors = {.n = k, .A = f->A, .pivot = f->pivot};
  if (dlsi_dense_lu(&factors)) return 0;
  dlsi_dense_solve(&factors, f->X, k, s);
  return k;
}

/* Returns the real eigenvalue g of (FO2) with the largest |g|, 0 if there is none; z (|S|, or NULL)
 * := its vector. */
static double fold_eigenvalue(fold_search *f, const fold_state *state, int k, int s, double *z) {
  const int room = 8 * f->nc;
  int info, at = -1;
  for (int j = 0; j < s; j++) {
    const double side = state[f->unknown[f->slips[j]] / 2] == FOLD_DOWN ? -1 : 1;
    for (int i = 0; i < s; i++)
      f->E[(size_t)i + (size_t)j * (size_t)s] =
          side * f->X[(size_t)f->slips[i] + (size_t)j * (size_t)k];
  }
  f->looked++;
  if (dlsi_first_not_finite(f->E, (size_t)s * (size_t)s) >= 0) return 0; /* LAPACK would print */
  dgeev_("N", z ? "V" : "N", &s, f->E, &s, f->real, f->imaginary, NULL, &s, f->V, &s, f->work,
         &room, &info, 1, 1);
  for (int i = 0; !info && i < s; i++)
    if (f->imaginary[i] == 0 && (at < 0 || fabs(f->real[i]) > fabs(f->real[at]))) at = i;
  if (z && at >= 0) memcpy(z, f->V + (size_t)at * (size_t)s, (size_t)s * sizeof *z);
  return at < 0 ? 0 : f->real[at];
}

static void fold_offer(fold_search *f, const fold_state *state, double value) {
  if (!(value > f->largest * (1 + rise))) return;
  f->largest = value;
  memcpy(f->best, state, (size_t)f->nc * sizeof *state);
}

/* ---- all states ------------------------------------------------------------------------------ */

/* Tries all sides of the contacts that slip; the first of them keeps its side. */
static void fold_all_sides(fold_search *f) {
  int s;
  const int k = fold_condense(f, f->state, &s);
  for (unsigned long sides = 0; k && sides < 1UL << (s - 1); sides++) {
    for (int j = 0; j < s; j++)
      f->state[f->unknown[f->slips[j]] / 2] = j && sides >> (j - 1) & 1 ? FOLD_DOWN : FOLD_UP;
    fold_offer(f, f->state, fabs(fold_eigenvalue(f, f->state, k, s, NULL)));
  }
  for (int j = 0; j < s; j++)
    f->state[f->unknown[f->slips[j]] / 2] = FOLD_UP;
}

static void fold_all(fold_search *f) {
  memset(f->state, 0, (size_t)f->nc * sizeof *f->state);
  for (int c = 0; c < f->nc;) {
    fold_all_sides(f);
    for (c = 0; c < f->nc; c++) { /* the next states, all sides up */
      const int next = (int)f->state[c] + (f->share[c] > 0 ? 1 : 2);
      f->state[c] = next <= FOLD_UP ? (fold_state)next : FOLD_FREE;
      if (next <= FOLD_UP) break;
    }
  }
}

/* ---- the local search ------------------------------------------------------------------------ */

static double fold_value(fold_search *f, const fold_state *state) {
  int s;
  const int k = fold_condense(f, state, &s);
  return k ? fabs(fold_eigenvalue(f, state, k, s, NULL)) : 0;
}

/* (FO3) from f->state, with at most `most` matrices. */
static void fold_climb(fold_search *f, int most) {
  double value = fold_value(f, f->state);
  for (int c = 0, since = 0; since < f->nc && f->looked < most; c = (c + 1) % f->nc, since++) {
    const fold_state old = f->state[c];
    fold_state to = old;
    for (fold_state next = FOLD_FREE; next <= FOLD_DOWN; next++) {
      if (next == old || (!(f->share[c] > 0) && next != FOLD_FREE && next != FOLD_UP)) continue;
      f->state[c] = next;
      const double now = fold_value(f, f->state);
      if (!(now > value * (1 + rise))) continue;
      value = now;
      to = next;
      since = -1;
    }
    f->state[c] = to;
  }
  fold_offer(f, f->state, value);
}

/* Sets start number `start`: all slip to one side, then the halves to two sides, then random
 * states: equally likely ones, or nearly all slipping. */
static void fold_start(fold_search *f, int start, uint32_t *seed) {
  for (int c = 0; c < f->nc; c++) {
    *seed = *seed * 1664525u + 1013904223u;
    const uint32_t drawn = *seed >> 16, few = drawn % 16;
    fold_state state = start % 2 || few < 2 ? (fold_state)(drawn >> 4 & 3)
                       : start % 4          ? FOLD_UP
                                            : (fold_state)(FOLD_UP + (drawn >> 4 & 1));
    if (start < 2) state = start && 2 * c > f->nc ? FOLD_DOWN : FOLD_UP;
    f->state[c] = state != FOLD_FREE && !(f->share[c] > 0) ? FOLD_UP : state;
  }
}

static void fold_search_states(fold_search *f) {
  const double nc = f->nc;
  const int most = (int)fmax(least_rounds * nc, effort / (nc * nc * nc));
  uint32_t seed = 1;
  for (int start = 0; start < starts && f->looked < most; start++) {
    fold_start(f, start, &seed);
    fold_climb(f, most);
  }
}

/* ---- the witness ----------------------------------------------------------------------------- */

/* q, r, other := the witness of the best states, in the user's units. y: that of (FO1), m, scaled;
 * Wy: scratch, m. */
static void fold_witness(const fold_search *f, const double *y, double *Wy, double friction,
                         double *q, double *r, double *other) {
  const size_t m = 2 * (size_t)f->nc;
  double step = INFINITY;
  for (size_t i = 0; i < m; i++) {
    Wy[i] = 0;
    for (size_t j = 0; j < m; j++)
      Wy[i] += f->W[i + j * m] * y[j];
  }
  for (int c = 0; c < f->nc; c++) { /* no state is left */
    const fold_state s = f->state[c];
    const double n = s == FOLD_FREE ? Wy[2 * c] : y[2 * c];
    const double t = s == FOLD_FREE ? 0 : s == FOLD_STICK ? y[2 * c + 1] : Wy[2 * c + 1];
    const double limit = s == FOLD_STICK ? 0.4 * friction * f->share[c] : 0.5;
    if (n != 0) step = fmin(step, 0.5 / fabs(n));
    if (t != 0) step = fmin(step, limit / fabs(t));
  }
  for (int c = 0; c < f->nc; c++) {
    const fold_state s = f->state[c];
    const double side = s == FOLD_UP ? 1 : s == FOLD_DOWN ? -1 : 0;
    r[2 * c] = s != FOLD_FREE;
    r[2 * c + 1] = side * friction * f->share[c];
    q[2 * c] = s == FOLD_FREE;
    q[2 * c + 1] = -side;
  }
  for (size_t i = 0; i < m; i++)
    for (size_t j = 0; j < m; j++)
      q[i] -= f->W[i + j * m] * r[j];
  for (size_t i = 0; i < m; i++) {
    q[i] /= f->scale[i / 2];
    other[i] = f->scale[i / 2] * (r[i] + step * y[i]);
    r[i] *= f->scale[i / 2];
  }
}

/* ---- the call -------------------------------------------------------------------------------- */

/* Fills the scaled W. Returns 1 if its symmetric part is positive definite. H: scratch, m x m. */
static int fold_load(const dls_contact *problem, fold_search *f, double *H) {
  const size_t m = 2 * (size_t)f->nc;
  const int rows = (int)m, room = 8 * f->nc;
  int info;
  double most = 0;
  dlsi_contact_weights(problem, f->scale);
  for (int c = 0; c < f->nc; c++) {
    f->scale[c] = 1 / sqrt(f->scale[c]);
    most = fmax(most, problem->mu[c]);
  }
  for (int c = 0; c < f->nc; c++)
    f->share[c] = most > 0 ? problem->mu[c] / most : 1;
  memset(f->W, 0, m * m * sizeof *f->W);
  for (size_t j = 0; j < m; j++) {
    const double e[2] = {j % 2 == 0, j % 2 == 1};
    double *W = f->W + j * m;
    dlsi_contact_add_columns(problem, (int)(j / 2), e, W);
    for (size_t i = 0; i < m; i++)
      W[i] *= f->scale[i / 2] * f->scale[j / 2];
  }
  for (size_t j = 0; j < m; j++)
    for (size_t i = j; i < m; i++)
      H[i + j * m] = 0.5 * (f->W[i + j * m] + f->W[j + i * m]);
  for (size_t j = 0; j < m; j++) /* LAPACK would print */
    if (dlsi_first_not_finite(H + j + j * m, m - j) >= 0) return 0;
  double *value = f->X; /* m <= m nc */
  dsyev_("N", "L", &rows, H, &rows, value, f->work, &room, &info, 1, 1);
  return !info && value[0] > 4 * (double)m * DBL_EPSILON * value[m - 1];
}

static void fold_carve(void *search, dlsi_arena *arena) {
  fold_search *f = search;
  const size_t n = (size_t)f->nc, m = 2 * n, D = sizeof(double);
  f->W = dlsi_take(arena, m, m * D);
  f->A = dlsi_take(arena, m, m * D);
  f->X = dlsi_take(arena, m, n * D);
  f->E = dlsi_take(arena, n, n * D);
  f->V = dlsi_take(arena, n, n * D);
  f->scale = dlsi_take(arena, n, D);
  f->share = dlsi_take(arena, n, D);
  f->real = dlsi_take(arena, n, D);
  f->imaginary = dlsi_take(arena, n, D);
  f->work = dlsi_take(arena, 8 * n, D);
  f->pivot = dlsi_take(arena, m, sizeof *f->pivot);
  f->unknown = dlsi_take(arena, m, sizeof *f->unknown);
  f->slips = dlsi_take(arena, n, sizeof *f->slips);
  f->state = dlsi_take(arena, n, sizeof *f->state);
  f->best = dlsi_take(arena, n, sizeof *f->best);
  f->branch = dlsi_take(arena, n, sizeof *f->branch);
}

/* Writes the best states and the witness to the caller's arrays. scratch: 4 m. */
static void fold_hand_over(fold_search *f, double friction, dls_contact_state *state, double *q,
                           double *r, double *other, double *scratch) {
  const size_t m = 2 * (size_t)f->nc;
  double *y = scratch, *own[3] = {scratch + m, scratch + 2 * m, scratch + 3 * m};
  double *z = f->real;
  int s;
  memcpy(f->state, f->best, (size_t)f->nc * sizeof *f->state);
  const int k = fold_condense(f, f->state, &s);
  const double g = fold_eigenvalue(f, f->state, k, s, own[0]);
  memcpy(z, own[0], (size_t)s * sizeof *z);
  if (g > 0) /* the other side */
    for (int c = 0; c < f->nc; c++)
      if (f->state[c] == FOLD_UP || f->state[c] == FOLD_DOWN)
        f->state[c] = f->state[c] == FOLD_UP ? FOLD_DOWN : FOLD_UP;
  memset(y, 0, m * sizeof *y);
  for (int i = 0; i < k; i++) /* up to a factor: y = X z, X with the sides */
    for (int j = 0; j < s; j++) {
      const double side = f->best[f->unknown[f->slips[j]] / 2] == FOLD_DOWN ? -1 : 1;
      y[f->unknown[i]] += side * f->X[(size_t)i + (size_t)j * (size_t)k] * z[j] / g;
    }
  for (int j = 0; j < s; j++) {
    const int n = f->unknown[f->slips[j]], up = f->state[n / 2] == FOLD_UP;
    y[n + 1] = (up ? 1 : -1) * friction * f->share[n / 2] * y[n];
  }
  for (int c = 0; state && c < f->nc; c++)
    state[c] = f->state[c] == FOLD_FREE    ? DLS_FREE
               : f->state[c] == FOLD_STICK ? DLS_STICK
                                           : DLS_SLIP;
  if (!q && !r && !other) return;
  double *Wy = f->A;
  fold_witness(f, y, Wy, friction, own[0], own[1], own[2]);
  if (q) memcpy(q, own[0], m * sizeof *q);
  if (r) memcpy(r, own[1], m * sizeof *r);
  if (other) memcpy(other, own[2], m * sizeof *other);
}

dls_status dlsi_contact_fold(const dls_contact *problem, int search, dls_fold *fold,
                             dls_contact_state *state, double *q, double *r, double *other,
                             dls_error *error) {
  dls_status status = dlsi_check_contact(problem, error);
  if (status) return status;
  if (problem->d != 2)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "d", -1, problem->d, "is %d, must be 2", problem->d);
  if (!fold) return dlsi_is_null(error, "fold");
  status = dlsi_refuse_bonded(problem, error);
  if (status) return status;
  if (problem->nc == 0) {
    *fold = (dls_fold){INFINITY, 1, 0};
    return DLS_OK;
  }
  fold_search filled = {.nc = problem->nc};
  void *memory;
  status =
      dlsi_carve_workspace(&memory, &filled, sizeof filled, fold_carve, "nc", problem->nc, error);
  if (status) return status;
  fold_search *f = memory;
  double *scratch = dlsi_alloc(8 * (size_t)f->nc, sizeof *scratch);
  if (!scratch) {
    free(f);
    return dlsi_no_memory(error);
  }
  if (!fold_load(problem, f, f->A))
    status = dlsi_fail(error, DLS_E_NOT_POSITIVE_DEFINITE, "W", -1, 0, "is not positive definite");
  else {
    if (search)
      fold_search_states(f);
    else
      fold_all(f);
    const double friction = f->largest > 0 ? 1 / f->largest : INFINITY;
    if (f->largest > 0) fold_hand_over(f, friction, state, q, r, other, scratch);
    *fold = (dls_fold){friction, !search, f->looked};
  }
  free(scratch);
  free(f);
  return status;
}

dls_status dls_contact_fold(const dls_contact *problem, dls_fold *fold, dls_contact_state *state,
                            double *q, double *r, double *other, dls_error *error) {
  DLSI_DOOR;
  const int search = problem && problem->nc > DLS_STATES_MAX;
  dlsi_formed formed = {.work = NULL};
  dls_status status = dlsi_check_blas(error);
  if (!status) status = dlsi_form_blocks(&formed, &problem, error);
  if (!status) status = dlsi_contact_fold(problem, search, fold, state, q, r, other, error);
  dlsi_formed_free(&formed);
  return dlsi_at(__func__, status, error);
}
