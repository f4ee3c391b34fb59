/*
 * fold.c: the least friction at which the solution folds: at which the matrix of some states of the
 * contacts becomes singular; W positive definite.
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
 * d = 3: e_c is a unit vector, and there is a fifth state. To first order slip obeys dr_t = mu e
 * dr_n - k p (p.du_t), p normal to e, k = mu r_n / |u_t| >= 0. The determinant is affine in each
 * k / (1 + k), so that it changes its sign first at an end: k = 0 (slips) or k = infinity (turns):
 *
 *   (FO4)  turns: u_n = 0, p.u_t = 0, r_t = mu e r_n + p r_p
 *
 * (FO3) finds states and directions, in steps of an angle that is halved from 90 degrees on:
 * friction is an upper bound. Witness: let y be that of (FO1), v = W y, and sign it at each contact
 * so that y_n > 0. Of the two answers r, r + y the one with the smaller normal force is
 *
 *   (FO5)  r = 0 (slips), r = R (1, mu v_t / |v_t|) (turns), r = R (1, 0) (sticks);  u = -v
 *
 * and the other one has u = 0: exact for `turns` and R large once friction exceeds the fold by a
 * fraction, 1e-6. Both are certified, or there is no bound.
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
enum { starts_3d = 20 };          /* found what 200 do in 12 problems of 2 to 16 contacts */
enum { least_rounds = 30 };       /* (FO3): changes of each contact, at least */
static const double effort = 1e8; /* (FO3): 4e9 / 40 */
static const double rise = 1e-9;  /* of max |g|: more than rounding */
static const double half_turn = 3.14159265358979323846;
static const double least_angle = 1e-5; /* max |g| is flat in the angles: 1e-10 of it */
static const double certified = 1e-12;  /* (FO5) */

typedef enum fold_kind { FOLD_FREE, FOLD_STICK, FOLD_SLIP, FOLD_TURN } fold_kind;

typedef struct fold_state {
  fold_kind kind;
  double angle; /* of e_c; d = 2: 0 or half_turn */
} fold_state;

typedef struct fold_search {
  int d, nc, looked;
  double *W;                       /* m x m, scaled */
  double *column;                  /* m: scratch */
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
  const int d = f->d, m = d * f->nc;
  const dls_contact scaled = {.d = d, .nc = f->nc, .W = {m, m, m, f->W}};
  int k = 0, s = 0;
  for (int c = 0; c < f->nc; c++) { /* (FO1): A is that of slip without friction */
    const int counts[] = {0, d, 1, 2}, stick = state[c].kind == FOLD_STICK;
    const short count = (short)counts[state[c].kind];
    f->branch[c] = (dlsi_branch){.state = stick ? DLS_STICK : DLS_SLIP,
                                 .count = count,
                                 .first = k,
                                 .t = {cos(state[c].angle), sin(state[c].angle)}};
    if (count && !stick) f->slips[s++] = k;
    k += count;
  }
  *slipping = s;
  if (!s) return 0;
  dlsi_states_fill(&scaled, f->branch, NULL, k, f->unknown, f->column, f->A);
  for (int j = 0; j < s; j++) {
    const int n = f->unknown[f->slips[j]], c = n / d;
    const double e[3] = {0, d == 2 ? 1 : f->branch[c].t[0], f->branch[c].t[1]};
    double *X = f->X + (size_t)j * (size_t)k;
    memset(f->column, 0, (size_t)m * sizeof *f->column);
    dlsi_contact_add_columns(&scaled, c, e, f->column);
    dlsi_branches_rows(d, f->nc, f->branch, f->column, X);
    for (int i = 0; i < k; i++)
      X[i] *= f->share[c];
  }
  dlsi_dense factors = {.n = k, .A = f->A, .pivot = f->pivot};
  if (dlsi_dense_lu(&factors)) return 0;
  dlsi_dense_solve(&factors, f->X, k, s);
  return k;
}

/* Returns e_c of unknown j of S where fold_condense has left it out: d = 2. */
static double fold_side(const fold_search *f, const fold_state *state, int j) {
  return f->d == 2 ? cos(state[f->unknown[f->slips[j]] / 2].angle) : 1;
}

/* Returns the real eigenvalue g of (FO2) with the largest |g|, 0 if there is none; z (|S|, or NULL)
 * := its vector. */
static double fold_eigenvalue(fold_search *f, const fold_state *state, int k, int s, double *z) {
  const int room = 8 * f->nc;
  int info, at = -1;
  for (int j = 0; j < s; j++) {
    const double side = fold_side(f, state, j);
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
      f->state[f->unknown[f->slips[j]] / 2].angle = j && sides >> (j - 1) & 1 ? half_turn : 0;
    fold_offer(f, f->state, fabs(fold_eigenvalue(f, f->state, k, s, NULL)));
  }
  for (int j = 0; j < s; j++)
    f->state[f->unknown[f->slips[j]] / 2].angle = 0;
}

static void fold_all(fold_search *f) {
  memset(f->state, 0, (size_t)f->nc * sizeof *f->state);
  for (int c = 0; c < f->nc;) {
    fold_all_sides(f);
    for (c = 0; c < f->nc; c++) { /* the next states, all sides up */
      const int next = (int)f->state[c].kind + (f->share[c] > 0 ? 1 : 2);
      f->state[c].kind = next <= FOLD_SLIP ? (fold_kind)next : FOLD_FREE;
      if (next <= FOLD_SLIP) break;
    }
  }
}

/* ---- the local search ------------------------------------------------------------------------ */

static double fold_value(fold_search *f, const fold_state *state) {
  int s;
  const int k = fold_condense(f, state, &s);
  return k ? fabs(fold_eigenvalue(f, state, k, s, NULL)) : 0;
}

/* Returns number `move` of the states that (FO3) tries in place of `old`; angle: its step. */
static fold_state fold_move(const fold_search *f, fold_state old, double angle, int move) {
  if (move < 2) return (fold_state){move ? FOLD_STICK : FOLD_FREE, old.angle};
  if (f->d == 2) return (fold_state){FOLD_SLIP, move == 2 ? 0 : half_turn};
  return (fold_state){move % 2 ? FOLD_TURN : FOLD_SLIP, old.angle + angle * (move / 2 - 2)};
}

/* Changes the states of one contact after the other as long as that raises *value. */
static void fold_climb_by(fold_search *f, int most, double angle, double *value) {
  const int moves = f->d == 2 ? 4 : 8;
  for (int c = 0, since = 0; since < f->nc && f->looked < most; c = (c + 1) % f->nc, since++) {
    const fold_state old = f->state[c];
    fold_state to = old;
    for (int move = 0; move < moves; move++) {
      const fold_state next = fold_move(f, old, angle, move);
      if (next.kind == old.kind && next.angle == old.angle) continue;
      if (!(f->share[c] > 0) && (next.kind == FOLD_STICK || next.angle != 0)) continue;
      f->state[c] = next;
      const double now = fold_value(f, f->state);
      if (!(now > *value * (1 + rise))) continue;
      *value = now;
      to = next;
      since = -1;
    }
    f->state[c] = to;
  }
}

/* (FO3) from f->state, with at most `most` matrices. */
static void fold_climb(fold_search *f, int most) {
  double value = fold_value(f, f->state), angle = half_turn / 2;
  fold_climb_by(f, most, angle, &value);
  while (f->d == 3 && (angle /= 2) > least_angle)
    fold_climb_by(f, most, angle, &value);
  fold_offer(f, f->state, value);
}

/* Sets start number `start`: all slip to one side, then the halves to two sides, then random
 * states: equally likely ones, or nearly all slipping. d = 3: to random sides. */
static void fold_start(fold_search *f, int start, uint32_t *seed) {
  for (int c = 0; c < f->nc; c++) {
    *seed = *seed * 1664525u + 1013904223u;
    const uint32_t drawn = *seed >> 16, few = drawn % 16;
    unsigned of = start % 2 || few < 2 ? drawn >> 4 & 3 : start % 4 ? 2 : 2 + (drawn >> 4 & 1);
    if (start < 2) of = start && 2 * c > f->nc ? 3 : 2;
    if (of && !(f->share[c] > 0)) of = 2;
    f->state[c] = (fold_state){(fold_kind)of, 0};
    if (f->d == 2 && of == 3) f->state[c] = (fold_state){FOLD_SLIP, half_turn};
    if (f->d == 3 && f->share[c] > 0) f->state[c].angle = half_turn / 128 * (drawn >> 6 & 255);
  }
}

static void fold_search_states(fold_search *f) {
  const double nc = f->nc;
  const int most = (int)fmax(least_rounds * nc, effort / (nc * nc * nc));
  uint32_t seed = 1;
  for (int start = 0; start < (f->d == 2 ? starts : starts_3d) && f->looked < most; start++) {
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
    const fold_kind s = f->state[c].kind;
    const double n = s == FOLD_FREE ? Wy[2 * c] : y[2 * c];
    const double t = s == FOLD_FREE ? 0 : s == FOLD_STICK ? y[2 * c + 1] : Wy[2 * c + 1];
    const double limit = s == FOLD_STICK ? 0.4 * friction * f->share[c] : 0.5;
    if (n != 0) step = fmin(step, 0.5 / fabs(n));
    if (t != 0) step = fmin(step, limit / fabs(t));
  }
  for (int c = 0; c < f->nc; c++) {
    const fold_kind s = f->state[c].kind;
    const double side = s == FOLD_SLIP ? cos(f->state[c].angle) : 0;
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

/* (FO5) Sets r, other and q, in the user's units, for the friction `at` of the largest share;
 * excess: its fraction above the fold. v: W y. */
static void fold_two(const fold_search *f, const double *y, const double *v, double at,
                     double excess, double *q, double *r, double *other) {
  const size_t m = 3 * (size_t)f->nc;
  const double room = dlsi_max_abs(v, m);
  for (int c = 0; c < f->nc; c++) {
    const int o = 3 * c, up = !(y[o] < 0);
    const double mu = at * f->share[c], n = fabs(y[o]), vt = hypot(v[o + 1], v[o + 2]);
    const double a = f->state[c].angle, across = cos(a) * y[o + 2] - sin(a) * y[o + 1];
    double least[3] = {0}, R = 0;
    if (f->state[c].kind == FOLD_STICK) R = 2 * (n + hypot(y[o + 1], y[o + 2]) / mu);
    if (f->state[c].kind == FOLD_TURN && across != 0) R = across * across / (mu * mu * excess * n);
    least[0] = R;
    for (int i = 1; i < 3 && f->state[c].kind == FOLD_TURN && vt > 0; i++)
      least[i] = (up ? 1 : -1) * mu * R * v[o + i] / vt;
    for (int i = 0; i < 3; i++) {
      r[o + i] = up ? least[i] : least[i] - y[o + i];
      other[o + i] = up ? least[i] + y[o + i] : least[i];
      q[o + i] = f->state[c].kind != FOLD_STICK && up && i ? -v[o + i] : 0; /* u of r */
    }
    if (f->state[c].kind == FOLD_FREE) q[o] = 2 * room;
  }
  for (size_t j = 0; j < m; j++)
    for (size_t i = 0; i < m; i++)
      q[i] -= f->W[i + j * m] * r[j];
  for (size_t i = 0; i < m; i++) {
    q[i] /= f->scale[i / 3];
    other[i] *= f->scale[i / 3];
    r[i] *= f->scale[i / 3];
  }
}

/* (FO5) Raises *friction, the fold, to one at which r and other are certified answers of q;
 * INFINITY if there is none. mu: scratch, nc. Without memory, DLS_E_MEMORY. */
static dls_status fold_pair(const fold_search *f, const dls_contact *problem, const double *y,
                            double *friction, double *q, double *r, double *other, double *mu) {
  const size_t m = 3 * (size_t)f->nc;
  const double fold = *friction;
  double *v = f->column;
  memset(v, 0, m * sizeof *v);
  for (size_t j = 0; j < m; j++)
    for (size_t i = 0; i < m; i++)
      v[i] += f->W[i + j * m] * y[j];
  dls_contact p = *problem;
  p.q = q;
  p.mu = mu;
  for (double excess = 1e-6; excess < 0.1; excess *= 10) {
    int good = 0;
    *friction = fold * (1 + excess);
    for (int c = 0; c < f->nc; c++)
      mu[c] = *friction * f->share[c];
    fold_two(f, y, v, *friction, excess, q, r, other);
    for (int k = 0; k < 2; k++) {
      dls_certificate found;
      const dls_status status = dls_contact_certify(&p, k ? other : r, NULL, &found, NULL);
      if (status == DLS_E_MEMORY) return status;
      good += !status && dls_certificate_holds(&found, certified);
    }
    if (good == 2) return DLS_OK;
  }
  *friction = INFINITY;
  return DLS_OK;
}

/* ---- the call -------------------------------------------------------------------------------- */

/* Fills the scaled W, and *unique with the bound of bound.c. scratch: m. */
static dls_status fold_load(const dls_contact *problem, fold_search *f, double *unique,
                            double *value, dls_error *error) {
  const size_t d = (size_t)f->d, m = d * (size_t)f->nc;
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
    const double e[3] = {j % d == 0, j % d == 1, j % d == 2};
    double *W = f->W + j * m;
    dlsi_contact_add_columns(problem, (int)(j / d), e, W);
    for (size_t i = 0; i < m; i++)
      W[i] *= f->scale[i / d] * f->scale[j / d];
  }
  if (dlsi_unique_below(problem, f->scale, value, unique)) return dlsi_no_memory(error);
  if (!(value[0] > 4 * (double)m * DBL_EPSILON * value[m - 1]))
    return dlsi_fail(error, DLS_E_NOT_POSITIVE_DEFINITE, "W", -1, 0, "is not positive definite");
  return DLS_OK;
}

static void fold_carve(void *search, dlsi_arena *arena) {
  fold_search *f = search;
  const size_t n = (size_t)f->nc, m = (size_t)f->d * n, D = sizeof(double);
  f->W = dlsi_take(arena, m, m * D);
  f->A = dlsi_take(arena, m, m * D);
  f->X = dlsi_take(arena, m, n * D);
  f->E = dlsi_take(arena, n, n * D);
  f->V = dlsi_take(arena, n, n * D);
  f->column = dlsi_take(arena, m, D);
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

/* Sets y (m) to that of (FO1) for the best states, with the sides that make lambda positive. z: nc.
 */
static void fold_vector(fold_search *f, double *y, double *z) {
  const int d = f->d;
  int s;
  memcpy(f->state, f->best, (size_t)f->nc * sizeof *f->state);
  const int k = fold_condense(f, f->state, &s);
  const double g = fold_eigenvalue(f, f->state, k, s, z), lambda = 1 / fabs(g);
  double *own = f->column;
  for (int i = 0; i < k; i++) { /* up to a factor: y = X z, X with the sides */
    own[i] = 0;
    for (int j = 0; j < s; j++)
      own[i] += fold_side(f, f->best, j) * f->X[(size_t)i + (size_t)j * (size_t)k] * z[j] / g;
  }
  memset(y, 0, (size_t)(d * f->nc) * sizeof *y);
  dlsi_branches_add_directions(d, f->nc, f->branch, own, y);
  for (int c = 0; c < f->nc; c++) {
    fold_state *at = &f->state[c];
    if (at->kind < FOLD_SLIP) continue;
    if (g > 0) at->angle = d == 2 ? half_turn - at->angle : half_turn + at->angle; /* other side */
    y[d * c + 1] += lambda * f->share[c] * y[d * c] * cos(at->angle);
    if (d == 3) y[d * c + 2] += lambda * f->share[c] * y[d * c] * sin(at->angle);
  }
}

/* Writes states and witness to the caller's arrays, and the friction that the witness has.
 * scratch: 4 m + nc. DLS_OK or DLS_E_MEMORY. */
static dls_status fold_hand_over(fold_search *f, const dls_contact *problem, double *friction,
                                 dls_contact_state *state, double *q, double *r, double *other,
                                 double *scratch) {
  const size_t m = (size_t)f->d * (size_t)f->nc;
  double *y = scratch, *own[3] = {scratch + m, scratch + 2 * m, scratch + 3 * m};
  fold_vector(f, y, scratch + 4 * m);
  if (f->d == 2)
    fold_witness(f, y, f->A, *friction, own[0], own[1], own[2]);
  else if (fold_pair(f, problem, y, friction, own[0], own[1], own[2], scratch + 4 * m))
    return DLS_E_MEMORY;
  if (isinf(*friction)) return DLS_OK;
  for (int c = 0; state && c < f->nc; c++)
    state[c] = f->state[c].kind == FOLD_FREE    ? DLS_FREE
               : f->state[c].kind == FOLD_STICK ? DLS_STICK
                                                : DLS_SLIP;
  if (q) memcpy(q, own[0], m * sizeof *q);
  if (r) memcpy(r, own[1], m * sizeof *r);
  if (other) memcpy(other, own[2], m * sizeof *other);
  return DLS_OK;
}

dls_status dlsi_contact_fold(const dls_contact *problem, int search, dls_fold *fold,
                             dls_contact_state *state, double *q, double *r, double *other,
                             dls_error *error) {
  dls_status status = dlsi_check_contact(problem, error);
  if (status) return status;
  if (problem->d == 1)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "d", -1, 1, "is 1, must be 2 or 3");
  if (!fold) return dlsi_is_null(error, "fold");
  status = dlsi_refuse_bonded(problem, error);
  if (status) return status;
  if (problem->nc == 0) {
    *fold = (dls_fold){INFINITY, INFINITY, 1, 0};
    return DLS_OK;
  }
  fold_search filled = {.d = problem->d, .nc = problem->nc};
  const size_t m = (size_t)filled.d * (size_t)filled.nc;
  void *memory;
  status =
      dlsi_carve_workspace(&memory, &filled, sizeof filled, fold_carve, "nc", problem->nc, error);
  if (status) return status;
  fold_search *f = memory;
  double *scratch = dlsi_alloc(5 * m, sizeof *scratch), unique;
  status = scratch ? fold_load(problem, f, &unique, scratch, error) : dlsi_no_memory(error);
  if (!status) {
    if (search)
      fold_search_states(f);
    else
      fold_all(f);
    double friction = f->largest > 0 ? 1 / f->largest : INFINITY;
    if (f->largest > 0 && fold_hand_over(f, problem, &friction, state, q, r, other, scratch))
      status = dlsi_no_memory(error);
    else
      *fold = (dls_fold){friction, search ? unique : friction, !search, f->looked};
  }
  free(scratch);
  free(f);
  return status;
}

dls_status dls_contact_fold(const dls_contact *problem, dls_fold *fold, dls_contact_state *state,
                            double *q, double *r, double *other, dls_error *error) {
  DLSI_DOOR;
  const int search = problem && (problem->d == 3 || problem->nc > DLS_STATES_MAX);
  dlsi_formed formed = {.work = NULL};
  dls_status status = dlsi_check_blas(error);
  if (!status) status = dlsi_form_blocks(&formed, &problem, error);
  if (!status) status = dlsi_contact_fold(problem, search, fold, state, q, r, other, error);
  dlsi_formed_free(&formed);
  return dlsi_at(__func__, status, error);
}
