/*
 * states.c: tries all states of a small contact problem, d = 2: finds a solution, or all solutions.
 *
 * A contact is free, sticks, or slips in one of two directions (one for mu = 0). For chosen states
 * the laws become linear equations for numbers that must not be negative:
 *
 *   (ST1)  free    r = 0                                     u_n = x0
 *          stick   r = (x0 + x1) / 2, mu (x0 - x1) / 2       u = 0            edges of the cone
 *          slip s  r = (x0, s mu x0), s = 1 or -1            u = (0, -s x1)
 *   (ST2)  C x = q,  x >= 0:  u = W r + q, without the tangential rows of free contacts
 *
 * One phase of the simplex method finds an x or shows that there is none, to 1e-10
 * (lcp/enumerate.c). If no states have an x, the problem has no solution, as far as rounding can
 * show. All solutions are the union of the polyhedra (ST2) of all states:
 *
 *   (ST3)  u follows from r, and x from both: a polyhedron of dimension 0 is one r, a larger one
 *          holds several r. The u_t of a free contact is no unknown.
 *   (ST4)  Two polyhedra meet if an x has only the unknowns that both their states have: free and
 *          slip share u_t, free and stick none, slip and stick one edge. Connected polyhedra are
 *          one set of solutions.
 *   (ST5)  No solution: for each choice of states a y with y.C <= 0 and y.q > 0, exactly for the
 *          numbers of W, q and mu, in the rows of the user's problem.
 *
 * Cost: 4^nc small linear programs: 65,536 of up to 16 rows for nc = 8.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "contact/exact.h"
#include "delassus/trust.h"
#include "facts/facts.h"
#include "lcp/lcp_internal.h"
#include "vi/vi_internal.h"

enum { most_rows = 2 * dlsi_most_states };
_Static_assert((int)dlsi_most_states == (int)DLS_STATES_MAX, "the enumeration is of these states");
static const double same_solution =
    1e-8; /* difference of two that are one, over the largest entry */

typedef enum state { FREE, STICK, SLIP_LEFT, SLIP_RIGHT } state;

/* Unknowns of a contact: u_n, r on the edges (1, mu) and (1, -mu), u_t > 0, u_t < 0. */
enum { GAP = 1, EDGE_UP = 2, EDGE_DOWN = 4, TO_LEFT = 8, TO_RIGHT = 16, unknown_kinds = 5 };
static const int unknowns_of[] = {[FREE] = GAP,
                                  [STICK] = EDGE_UP | EDGE_DOWN,
                                  [SLIP_LEFT] = EDGE_DOWN | TO_LEFT,
                                  [SLIP_RIGHT] = EDGE_UP | TO_RIGHT};

/* The problem in scaled unknowns: rows d_i u_i, columns d_n r_c, largest entry of W and of q 1. */
typedef struct states {
  int nc;
  double W[most_rows][most_rows], q[most_rows], mu[dlsi_most_states];
  double row[most_rows];         /* scaled row i is row_i times the user's, but for one factor */
  double unit[dlsi_most_states]; /* r_c = unit_c times the scaled r_c */
  state state[dlsi_most_states];
} states;

/* Sets d with d_i d_j |W_ij| <= 1, close to 1 somewhere in each row that is not 0: n and t of a
 * contact apart. */
static void states_balance(const states *s, double *d) {
  const int m = 2 * s->nc, turns = 4; /* one is enough for W >= 0 */
  for (int i = 0; i < m; i++)
    d[i] = s->W[i][i] != 0 ? 1 / sqrt(fabs(s->W[i][i])) : 1;
  for (int k = 0; k < turns * m; k++) {
    const int i = k % m;
    double largest = 0;
    for (int j = 0; j < m; j++)
      largest = fmax(largest, d[i] * d[j] * fmax(fabs(s->W[i][j]), fabs(s->W[j][i])));
    if (largest > 0) d[i] /= sqrt(largest);
  }
}

static void states_scale(const dls_contact *problem, states *s) {
  double d[most_rows], most = 0, largest = 0;
  const int nc = s->nc = problem->nc, m = 2 * nc;
  for (int j = 0; j < m; j++) {
    double e[2] = {j % 2 == 0, j % 2}, column[most_rows] = {0};
    dlsi_contact_add_columns(problem, j / 2, e, column);
    for (int i = 0; i < m; i++) {
      s->W[i][j] = column[i];
      most = fmax(most, fabs(column[i]));
    }
  }
  if (most == 0) most = 1;
  for (int i = 0; i < m; i++) /* over the largest: powers of two change no bit */
    for (int j = 0; j < m; j++)
      s->W[i][j] /= most;
  states_balance(s, d);
  for (int i = 0; i < m; i++) {
    for (int j = 0; j < m; j++)
      s->W[i][j] *= d[i] * d[j - j % 2];
    s->row[i] = d[i];
    s->q[i] = problem->q[i] * d[i];
    largest = fmax(largest, fabs(s->q[i]));
  }
  if (largest == 0) largest = 1;
  for (int j = 0; j < m; j++)
    s->q[j] /= largest;
  for (int c = 0; c < nc; c++) {
    s->unit[c] = d[2 * c] * (largest / most);
    s->mu[c] = problem->mu[c];
  }
}

/* The equations (ST2) of chosen states. */
typedef struct equations {
  int n;              /* rows, and columns, the last ones 0 if there are fewer */
  int row[most_rows]; /* of u = W r + q */
  int candidate[most_rows], kind[most_rows]; /* of each unknown; kind 0: none */
  double C[most_rows * (most_rows + 1)];     /* (C | q) by rows */
} equations;

/* Returns the unknowns that both states have (ST4); *tangential: 1 if the tangential row counts. */
static int states_unknowns(double mu, state a, state b, int *tangential) {
  const int free_a = a == FREE && a != b, free_b = b == FREE && a != b;
  *tangential = mu > 0 && (a != FREE || b != FREE);
  const int both = (unknowns_of[a] | (free_a ? TO_LEFT | TO_RIGHT : 0)) &
                   (unknowns_of[b] | (free_b ? TO_LEFT | TO_RIGHT : 0));
  if (mu > 0) return both;
  return both & GAP ? GAP : both & (EDGE_UP | EDGE_DOWN) ? EDGE_DOWN : 0;
}

/* Sets the equations of the polyhedron that states a and b have in common. */
static void states_equations(const states *s, const state *a, const state *b, equations *e) {
  int n = 0, rows = 0;
  memset(e, 0, sizeof *e);
  for (int c = 0; c < s->nc; c++) {
    int tangential;
    const int unknowns = states_unknowns(s->mu[c], a[c], b[c], &tangential);
    e->row[rows++] = 2 * c;
    if (tangential) e->row[rows++] = 2 * c + 1;
    for (int bit = 0; bit < unknown_kinds; bit++) {
      if (!(unknowns >> bit & 1)) continue;
      e->candidate[n] = c;
      e->kind[n++] = 1 << bit;
    }
  }
  e->n = rows;
  for (int i = 0; i < rows; i++) {
    double *line = e->C + i * (rows + 1);
    for (int j = 0; j < n; j++) {
      const int c = e->candidate[j], kind = e->kind[j], own = e->row[i] == 2 * c;
      const double mu = kind == EDGE_UP ? s->mu[c] : -s->mu[c];
      if (kind == GAP)
        line[j] = own;
      else if (kind == TO_LEFT || kind == TO_RIGHT)
        line[j] = e->row[i] != 2 * c + 1 ? 0 : kind == TO_LEFT ? 1 : -1;
      else
        line[j] = -(s->W[e->row[i]][2 * c] + s->W[e->row[i]][2 * c + 1] * mu);
    }
    line[rows] = s->q[e->row[i]];
  }
}

/* Returns r_k of the user's problem as a linear function of x: its coefficient of x_j. */
static double states_reaction(const states *s, const equations *e, int k, int j) {
  const int c = k / 2, edge = e->kind[j] & (EDGE_UP | EDGE_DOWN);
  if (!edge || e->candidate[j] != c) return 0;
  return s->unit[c] * (k % 2 == 0 ? 1 : edge == EDGE_UP ? s->mu[c] : -s->mu[c]);
}

/* Solves (ST2). Returns 1 with r (m), 0 if there is none, -1 if rounding leaves it open. */
static int states_solve(const states *s, equations *e, double *r) {
  double x[most_rows];
  states_equations(s, s->state, s->state, e);
  const int found = dlsi_find_vertex(e->n, e->C, x);
  if (found < 1) return found;
  for (int k = 0; k < 2 * s->nc; k++) {
    r[k] = 0;
    for (int j = 0; j < e->n; j++)
      r[k] += states_reaction(s, e, k, j) * x[j];
  }
  return 1;
}

/* Sets the next states; returns 0 after the last ones. */
static int states_next(states *s) {
  for (int c = 0; c < s->nc; c++) {
    const state after = s->mu[c] > 0          ? s->state[c] + 1
                        : s->state[c] == FREE ? SLIP_LEFT
                                              : SLIP_RIGHT + 1;
    s->state[c] = after <= SLIP_RIGHT ? after : FREE;
    if (after <= SLIP_RIGHT && !(s->mu[c] == 0 && after == SLIP_RIGHT)) return 1;
    s->state[c] = FREE;
  }
  return 0;
}

int dlsi_contact_find_states(const dls_contact *problem, const dls_limits *limits, double begun,
                             double *r, double *best, dls_certificate *certificate) {
  states s;
  equations e;
  int result = 0;
  memset(&s, 0, sizeof s);
  states_scale(problem, &s);
  do {
    dls_certificate now;
    const int found = states_solve(&s, &e, r);
    if (dlsi_clock_is_over(limits, begun)) return -1;
    if (found) result = -1; /* rounding decides, unless r is nearly certified */
    if (found < 1 || dls_contact_certify(problem, r, NULL, &now, NULL)) continue;
    if (dlsi_is_better(&now, certificate)) {
      *certificate = now;
      memcpy(best, r, 2 * (size_t)problem->nc * sizeof *r);
    }
    if (dls_certificate_holds(certificate, limits->tol)) return 1;
  } while (states_next(&s));
  return result;
}

/* ---- all solutions --------------------------------------------------------------------------- */

/* A polyhedron (ST2) that is not empty. */
typedef struct piece {
  state state[dlsi_most_states];
  int dimension, set; /* set: the piece with the least number that it is connected to */
  double r[most_rows], low[most_rows], high[most_rows];
} piece;

typedef struct pieces {
  const dls_contact *problem;
  double tol, w[2 * dlsi_most_states]; /* weights of the certificate */
  states s;
  int count, room;
  piece *of;
} pieces;

/* Returns 1 if the scaled reactions of two pieces are the same. */
static int pieces_agree(const pieces *p, const piece *a, const piece *b) {
  double difference = 0, size = 0;
  for (int k = 0; k < 2 * p->s.nc; k++) {
    const double unit = p->s.unit[k / 2];
    difference = fmax(difference, fabs(a->r[k] - b->r[k]) / unit);
    size = fmax(size, fmax(fabs(a->r[k]), fabs(b->r[k])) / unit);
  }
  return difference <= same_solution * size;
}

/* (ST4) */
static int pieces_meet(const pieces *p, const piece *a, const piece *b) {
  if (!a->dimension && !b->dimension) return pieces_agree(p, a, b);
  equations e;
  double x[most_rows];
  states_equations(&p->s, a->state, b->state, &e);
  return dlsi_find_vertex(e.n, e.C, x) == 1;
}

/* Joins the set of the last piece with those that it meets. */
static void pieces_join(pieces *p) {
  const int last = p->count - 1;
  p->of[last].set = last;
  for (int k = 0; k < last; k++) {
    const int mine = p->of[last].set, other = p->of[k].set;
    if (mine == other || !pieces_meet(p, &p->of[k], &p->of[last])) continue;
    const int least = mine < other ? mine : other;
    for (int l = 0; l <= last; l++)
      if (p->of[l].set == mine || p->of[l].set == other) p->of[l].set = least;
  }
}

/* Adds the polyhedron of the states s to the list if its vertex r is certified. Returns 0 if not, 1
 * if it is; < 0: DLS_E_MEMORY. *hidden := 1 if rounding leaves it open. */
static int pieces_take(pieces *p, const equations *e, const double *r, int *hidden) {
  const int m = 2 * p->s.nc, n = e->n;
  dls_certificate now;
  double a[most_rows * most_rows];
  double u[most_rows], sizes[most_rows], F[most_rows];
  dlsi_contact_multiply(p->problem, NULL, r, u, sizes);
  dlsi_contact_measure(p->problem, r, u, sizes, p->w, F, &now);
  if (!dls_certificate_holds(&now, p->tol)) {
    *hidden = 1;
    return 0;
  }
  if (p->count == p->room) {
    const int room = 2 * p->room + 16;
    piece *more = dlsi_alloc((size_t)room, sizeof *more);
    if (!more) return DLS_E_MEMORY;
    if (p->count) memcpy(more, p->of, (size_t)p->count * sizeof *more);
    free(p->of);
    p->of = more;
    p->room = room;
  }
  piece *now_taken = &p->of[p->count++];
  memcpy(now_taken->state, p->s.state, sizeof now_taken->state);
  memcpy(now_taken->r, r, (size_t)m * sizeof *r);
  for (int k = 0; k < m; k++)
    for (int j = 0; j < n; j++) /* in scaled units */
      a[k * n + j] = states_reaction(&p->s, e, k, j) / p->s.unit[k / 2];
  now_taken->dimension = dlsi_spread(n, e->C, m, a, now_taken->low, now_taken->high);
  if (now_taken->dimension < 0) *hidden = 1;
  for (int k = 0; k < m; k++) {
    now_taken->low[k] = now_taken->dimension > 0 ? now_taken->low[k] * p->s.unit[k / 2] : r[k];
    now_taken->high[k] = now_taken->dimension > 0 ? now_taken->high[k] * p->s.unit[k / 2] : r[k];
  }
  pieces_join(p);
  return 1;
}

/* Writes set `first`, if it is a continuum as asked, as entry number `at` of the lists. */
static int pieces_write(const pieces *p, int first, int continuum, int at, int capacity, double *r,
                        double *low, double *high) {
  const size_t m = 2 * (size_t)p->s.nc;
  int largest = 0;
  for (int k = 0; k < p->count; k++)
    if (p->of[k].set == first && p->of[k].dimension > largest) largest = p->of[k].dimension;
  if (p->of[first].set != first || (largest > 0) != continuum) return 0;
  if (at >= capacity) return 1;
  memcpy(r + (size_t)at * m, p->of[first].r, m * sizeof *r);
  for (size_t i = 0; low && i < m; i++) {
    double *l = low + (size_t)at * m + i, *h = high + (size_t)at * m + i;
    *l = *h = p->of[first].r[i];
    for (int k = first; continuum && k < p->count; k++) {
      if (p->of[k].set != first) continue;
      *l = fmin(*l, p->of[k].low[i]);
      *h = fmax(*h, p->of[k].high[i]);
    }
  }
  return 1;
}

/* ---- no solution ----------------------------------------------------------------------------- */

/* The states that a y has to show empty. */
typedef struct refutation {
  const dls_contact *problem;
  const equations *e;
} refutation;

/* Returns the sign of sum_i y_i (W r)_i for r = (1, side mu) at contact c, without rounding. */
static int refutation_edge(const refutation *f, int c, double side, const double *y) {
  const dls_contact *p = f->problem;
  const dlsi_block_column W = dlsi_contact_column(p, (size_t)c);
  const double mu = side * p->mu[c];
  dlsi_exact sum;
  dlsi_exact_clear(&sum);
  for (size_t k = W.begin; k < W.end; k++) {
    const double *block = W.x + k * W.step, *v = y + 2 * dlsi_row(&W, k);
    for (int i = 0; i < 2; i++) {
      dlsi_exact_add(&sum, v[i], block[i], 1);
      dlsi_exact_add(&sum, v[i], block[(size_t)i + W.ld], mu);
    }
  }
  return dlsi_exact_sign(&sum);
}

/* (ST5) y = v_i - v_(m+i), both >= 0: exactly. */
static int refutation_holds(const void *states_of, const double *v) {
  const refutation *f = states_of;
  const equations *e = f->e;
  const int m = 2 * f->problem->nc;
  double y[most_rows];
  dlsi_exact sum;
  dlsi_exact_clear(&sum);
  for (int i = 0; i < m; i++) {
    y[i] = v[i] > 0 ? v[i] : -v[m + i];
    dlsi_exact_add(&sum, y[i], f->problem->q[i], 1);
  }
  if (dlsi_exact_sign(&sum) <= 0) return 0;
  for (int j = 0; j < e->n; j++) {
    const int c = e->candidate[j], kind = e->kind[j];
    const double u = y[2 * c + (kind != GAP)];
    if (kind & (GAP | TO_LEFT) ? u > 0 : kind == TO_RIGHT && u < 0) return 0;
    if (kind == EDGE_UP && refutation_edge(f, c, 1, y) < 0) return 0;
    if (kind == EDGE_DOWN && refutation_edge(f, c, -1, y) < 0) return 0;
  }
  return 1;
}

/* (ST5) Returns 1 if all states are refuted exactly. */
static int states_refute(const dls_contact *problem, states *s) {
  const int m = 2 * problem->nc;
  memset(s->state, 0, sizeof s->state);
  do {
    equations e;
    static const double slack[] = {0, 1e-12, 1e-9, 1e-6, 1e-3}; /* equations hold only near y */
    const refutation f = {problem, &e};
    int holds = 0;
    states_equations(s, s->state, s->state, &e);
    for (size_t k = 0; !holds && k < sizeof slack / sizeof slack[0]; k++) {
      double y[most_rows], v[2 * most_rows] = {0}, work[2 * most_rows];
      if (!dlsi_refute_vertex(e.n, e.C, slack[k], y)) return 0;
      for (int i = 0; i < e.n; i++) {
        const double x = y[i] * s->row[e.row[i]];
        v[e.row[i] + (x < 0 ? m : 0)] = fabs(x);
      }
      holds = dlsi_find_exact(2 * (size_t)m, v, work, refutation_holds, &f);
    }
    if (!holds) return 0;
  } while (states_next(s));
  return 1;
}

/* *status := DLS_NO_SOLUTION with a proof: (ST5), or that of Lemke's method if even u_n >= 0 is
 * impossible. Else DLS_NO_SOLUTION_LIKELY. Returns DLS_OK, or DLS_E_MEMORY. */
static dls_status states_prove(const dls_contact *problem, states *s, dls_status *status,
                               dls_error *error) {
  double r[most_rows];
  void *lemke;
  dlsi_options options = {.limits = {.tol = 1e-8}};
  *status = DLS_NO_SOLUTION;
  if (states_refute(problem, s)) return DLS_OK;
  const dls_status made = dlsi_lemke_method.create(&lemke, 2, problem->nc, &options, error);
  if (made) return made;
  const dls_status end = dlsi_lemke_method.solve(lemke, problem, r, NULL, NULL, error);
  dlsi_lemke_method.destroy(lemke);
  *status = end == DLS_NO_SOLUTION ? end : DLS_NO_SOLUTION_LIKELY;
  return end < 0 ? end : DLS_OK;
}

/* ---- the call -------------------------------------------------------------------------------- */

static dls_status enumerate_check(const dls_contact *problem, double tol, int capacity,
                                  const double *r, const double *low, const double *high,
                                  const dls_solution_set *found, dls_error *error) {
  const dlsi_setting own[] = {{"tol", tol, 0, DBL_MAX, 0}, {"capacity", capacity, 1, INT_MAX, 0}};
  const dls_status status = dlsi_check_contact(problem, error);
  if (status) return status;
  if (problem->d != 2)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "d", -1, problem->d, "is %d, must be 2", problem->d);
  const dls_status bonded = dlsi_refuse_bonded(problem, error);
  if (bonded) return bonded;
  if (problem->nc > DLS_STATES_MAX)
    return dlsi_fail(error, DLS_E_SIZE, "nc", -1, problem->nc, "is %d, must be at most %d",
                     problem->nc, DLS_STATES_MAX);
  if (!r) return dlsi_is_null(error, "r");
  if (low && !high) return dlsi_is_null(error, "high");
  if (high && !low) return dlsi_is_null(error, "low");
  if (!found) return dlsi_is_null(error, "found");
  return dlsi_check_each(2, own, error);
}

static dls_status contact_enumerate(const dls_contact *problem, double tol, int capacity, double *r,
                                    double *low, double *high, dls_solution_set *found,
                                    dls_error *error) {
  const dls_status wrong = enumerate_check(problem, tol, capacity, r, low, high, found, error);
  if (wrong) return wrong;
  pieces p = {.problem = problem, .tol = tol};
  dls_solution_set set = {0, 0, 0};
  int hidden = 0, taken = 0;
  dlsi_certificate_weights(problem, p.w);
  states_scale(problem, &p.s);
  do {
    equations e;
    double at[most_rows];
    const int solved = states_solve(&p.s, &e, at);
    hidden |= solved < 0;
    if (solved == 1) taken = pieces_take(&p, &e, at, &hidden);
  } while (taken >= 0 && states_next(&p.s));
  if (taken < 0) {
    free(p.of);
    return dlsi_no_memory(error);
  }
  set.states = p.count;
  for (int k = 0; k < p.count; k++)
    set.isolated += pieces_write(&p, k, 0, set.isolated, capacity, r, low, high);
  for (int k = 0; k < p.count; k++)
    set.continua += pieces_write(&p, k, 1, set.isolated + set.continua, capacity, r, low, high);
  free(p.of);
  dls_status none = DLS_OK;
  if (!set.states && !hidden) {
    const dls_status failed = states_prove(problem, &p.s, &none, error);
    if (failed) return failed;
  }
  *found = set;
  if (set.isolated + set.continua > capacity) return DLS_MAX_ITERATIONS;
  if (hidden) return DLS_STALLED;
  return none;
}

dls_status dls_contact_enumerate(const dls_contact *problem, double tol, int capacity, double *r,
                                 double *low, double *high, dls_solution_set *found,
                                 dls_error *error) {
  DLSI_DOOR;
  dlsi_formed formed = {.work = NULL};
  dls_status status = dlsi_form_blocks(&formed, &problem, error);
  if (!status) status = contact_enumerate(problem, tol, capacity, r, low, high, found, error);
  dlsi_formed_free(&formed);
  return dlsi_at(__func__, status, error);
}
