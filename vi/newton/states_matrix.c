/*
 * states_matrix.c: the matrix of a contact problem whose states are chosen.
 *
 * Given the states, the laws are equations for the reactions that are not zero. To first order
 * dr = E y, and the equations are rows R of u = W r + q. Per contact, with t the direction of r_t
 * (of -u_t where r_t = 0), and p = t turned by 90 degrees (d = 3):
 *
 *   (SM1)  free           no unknown                  r = 0
 *          stick          E = R = 1                   u = 0
 *          slip           E = (1, mu t),  R = n       u_n = 0,  r_t = mu r_n t
 *          slip, d = 3    and E = R = p, L = l        p.u + l p.r = 0,  l = |u_t| / |r_t|
 *          mu = 0         E = R = n                   u_n = 0
 *   (SM2)  A = R W E + L:  A y = -(right side of these rows)
 *   (SM3)  where r is projected on the cones (facts/least.c) R = E^T: at the surface (1, mu t)
 *
 * Newton's method (newton.c) solves with A + eps diag(w); the sensitivity of an answer is |A^-1|
 * (facts/sensitivity.c); friction folds where A is singular (facts/fold.c); a proof bounds
 * |1 - A^-1 A| (facts/prove.c); the derivative of r with respect to q is -E A^-1 R
 * (facts/derive.c).
 *
 * Cost: 2/3 n^3 for the factors, half of that by Cholesky (all stick, or mu = 0, and W symmetric),
 * much less sparse. What can fail: A is singular if W does not determine r, and holds on one side
 * only if a contact is on the border of two states.
 */
#include "states_matrix.h"

#include <stdlib.h>
#include <string.h>

#include "linear/sparse_lu.h"

enum { dense_limit = 250 }; /* of 50, 150, 250, 400 the fastest on FCLIB files by blocks */

/* ---- one contact ----------------------------------------------------------------------------- */

void dlsi_branch_direction(const dlsi_branch *b, int j, double *e) {
  e[0] = e[1] = e[2] = 0;
  if (b->state == DLS_STICK)
    e[j] = 1;
  else if (j == 0) {
    e[0] = 1;
    e[1] = b->mu * b->t[0];
    e[2] = b->mu * b->t[1];
  } else {
    e[1] = -b->t[1];
    e[2] = b->t[0];
  }
}

double dlsi_branch_row(const dlsi_branch *b, int i, const double *v) {
  if (b->state == DLS_STICK) return i == 0 ? v[0] : i == 1 ? v[1] : v[2];
  if (i == 0) return v[0] + (b->symmetric ? b->mu * (b->t[0] * v[1] + b->t[1] * v[2]) : 0);
  return b->t[0] * v[2] - b->t[1] * v[1];
}

void dlsi_branch_block(int d, const double *x, size_t ld, const double *e, double *v) {
  v[0] = v[1] = v[2] = 0;
  for (int i = 0; i < d; i++)
    v[i] = x[i] * e[0] + (d > 1 ? x[(size_t)i + ld] * e[1] : 0) +
           (d == 3 ? x[(size_t)i + 2 * ld] * e[2] : 0);
}

int dlsi_branch_is_same(const dlsi_branch *a, const dlsi_branch *b) {
  return a->state == b->state && a->symmetric == b->symmetric && a->count == b->count &&
         a->mu == b->mu && a->t[0] == b->t[0] && a->t[1] == b->t[1] &&
         (a->count == 1 || a->l == b->l);
}

/* Returns (SM1) for r and u of a contact. */
static dlsi_branch branch_of(int d, double mu, dls_contact_state state, const double *r,
                             const double *u) {
  dlsi_branch b = {.state = (short)state, .mu = mu};
  if (state == DLS_FREE) return b;
  b.count = state == DLS_STICK && mu > 0 ? (short)d : 1;
  if (b.count > 1 || d == 1) return b;
  b.state = DLS_SLIP;
  const double t = dlsi_tangent_norm(d, r), slip = dlsi_tangent_norm(d, u);
  for (int i = 1; mu > 0 && (t > 0 || slip > 0) && i < d; i++)
    b.t[i - 1] = t > 0 ? r[i] / t : -u[i] / slip;
  if (!(d == 3 && mu > 0 && t > 0)) return b; /* l = INFINITY: nothing along p */
  b.count = 2;
  b.l = slip / t;
  return b;
}

/* ---- all contacts ---------------------------------------------------------------------------- */

int dlsi_branches_set(const dls_contact *problem, const dls_contact_state *state, const double *r,
                      const double *u, dlsi_branch *branch) {
  const int d = problem->d;
  int n = 0;
  for (int c = 0; c < problem->nc; c++) {
    const size_t o = (size_t)d * (size_t)c;
    branch[c] = branch_of(d, problem->mu[c], state[c], r + o, u + o);
    branch[c].first = n;
    n += branch[c].count;
  }
  return n;
}

void dlsi_branches_rows(int d, int nc, const dlsi_branch *branch, const double *v, double *y) {
  for (int c = 0; c < nc; c++, v += d)
    for (int i = 0; i < branch[c].count; i++) {
      double own[3] = {0};
      memcpy(own, v, (size_t)d * sizeof *own);
      y[branch[c].first + i] = dlsi_branch_row(&branch[c], i, own);
    }
}

void dlsi_branches_directions(int d, int nc, const dlsi_branch *branch, const double *v,
                              double *y) {
  double e[3];
  for (int c = 0; c < nc; c++, v += d)
    for (int j = 0; j < branch[c].count; j++) {
      dlsi_branch_direction(&branch[c], j, e);
      y[branch[c].first + j] = v[0] * e[0] + (d > 1 ? v[1] * e[1] : 0) + (d == 3 ? v[2] * e[2] : 0);
    }
}

/* v += E y or, rows = 1, R^T y. The columns of both differ only where a contact slips: j = 0. */
static void branches_add(int d, int nc, const dlsi_branch *branch, int rows, const double *y,
                         double *v) {
  double e[3];
  for (int c = 0; c < nc; c++, v += d)
    for (int j = 0; j < branch[c].count; j++) {
      const double x = y[branch[c].first + j];
      dlsi_branch_direction(&branch[c], j, e);
      if (rows && j == 0 && !branch[c].symmetric) e[1] = e[2] = 0;
      for (int i = 0; i < d; i++)
        v[i] += x * e[i];
    }
}

void dlsi_branches_add_directions(int d, int nc, const dlsi_branch *branch, const double *y,
                                  double *v) {
  branches_add(d, nc, branch, 0, y, v);
}

void dlsi_branches_add_rows(int d, int nc, const dlsi_branch *branch, const double *y, double *v) {
  branches_add(d, nc, branch, 1, y, v);
}

/* ---- the matrix ------------------------------------------------------------------------------ */

/* Returns L plus the shift of unknown j of contact c. R E is the unit matrix except the tangential
 * part of (1, mu t), which is orthogonal to the row across: the diagonal suffices. */
static double states_diagonal(const dlsi_branch *b, const double *shift, int c, int j) {
  const double RE = b[c].symmetric && b[c].state == DLS_SLIP && j == 0 ? 1 + b[c].mu * b[c].mu : 1;
  return (shift ? shift[c] * RE : 0) + (b[c].state == DLS_SLIP && j == 1 ? b[c].l : 0);
}

/* Returns W(:,c) times the direction of unknown j of contact c, m; W dense. scratch: m. */
static const double *states_column(const dls_contact *problem, const dlsi_branch *b, int c, int j,
                                   double *scratch) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  double e[3];
  if (b->state == DLS_STICK || problem->d == 1 || (b->mu == 0 && j == 0))
    return problem->W.a + (d * (size_t)c + (size_t)j) * (size_t)problem->W.ld;
  dlsi_branch_direction(b, j, e);
  memset(scratch, 0, m * sizeof *scratch);
  dlsi_contact_add_panel(problem, 1, &c, e, scratch);
  return scratch;
}

static void states_fill_dense(const dls_contact *problem, const dlsi_branch *branch,
                              const double *shift, int n, int *row, double *column, double *A) {
  const int d = problem->d;
  for (int c = 0; c < problem->nc; c++)
    for (int i = 0; i < branch[c].count; i++)
      row[branch[c].first + i] = d * c + i;
  for (int b = 0; b < problem->nc; b++)
    for (int j = 0; j < branch[b].count; j++) {
      const int col = branch[b].first + j;
      const double *v = states_column(problem, &branch[b], b, j, column);
      double *J = A + (size_t)col * (size_t)n;
      for (int i = 0; i < n; i++)
        J[i] = v[row[i]];
      for (int c = 0; d > 1 && c < problem->nc; c++) { /* rows that are no row of W */
        const dlsi_branch *at = &branch[c];
        double own[3] = {0};
        if (at->state != DLS_SLIP || !(at->symmetric || at->count == 2)) continue;
        memcpy(own, v + d * c, (size_t)d * sizeof *own);
        for (int i = at->symmetric ? 0 : 1; i < at->count; i++)
          J[at->first + i] = dlsi_branch_row(at, i, own);
      }
      J[col] += states_diagonal(branch, shift, b, j);
    }
}

/* Fills A (n x n) or, if NULL, the sparse arrays of the room, with the starts of columns in p. */
static void states_fill_blocks(const dls_contact *problem, const dlsi_branch *branch,
                               const double *shift, int n, int *p, dlsi_room *room, double *A) {
  int entries = 0;
  if (A) memset(A, 0, (size_t)n * (size_t)n * sizeof *A);
  for (int b = 0; b < problem->nc; b++) {
    const dlsi_block_column W = dlsi_contact_column(problem, (size_t)b);
    for (int j = 0; j < branch[b].count; j++) {
      const int col = branch[b].first + j;
      const double diagonal = states_diagonal(branch, shift, b, j);
      double e[3], v[3], *J = A ? A + (size_t)n * (size_t)col : NULL;
      dlsi_branch_direction(&branch[b], j, e);
      p[col] = entries;
      if (J)
        J[col] = diagonal;
      else {
        room->i[entries] = col;
        room->v[entries++] = diagonal;
      }
      for (size_t s = W.begin; s < W.end; s++) {
        const dlsi_branch *at = &branch[dlsi_row(&W, s)];
        if (!at->count) continue;
        dlsi_branch_block(problem->d, W.x + s * W.step, W.ld, e, v);
        for (int i = 0; i < at->count; i++)
          if (J)
            J[at->first + i] += dlsi_branch_row(at, i, v);
          else {
            room->i[entries] = at->first + i;
            room->v[entries++] = dlsi_branch_row(at, i, v);
          }
      }
    }
  }
  if (!A) p[n] = entries;
}

void dlsi_states_fill(const dls_contact *problem, const dlsi_branch *branch, const double *shift,
                      int n, int *row, double *column, double *A) {
  if (problem->Wb.x)
    states_fill_blocks(problem, branch, shift, n, row, NULL, A);
  else
    states_fill_dense(problem, branch, shift, n, row, column, A);
}

/* ---- its factors ----------------------------------------------------------------------------- */

void dlsi_states_carve(dlsi_states_matrix *A, dlsi_arena *arena) {
  const size_t nc = (size_t)A->nc, m = (size_t)A->d * nc;
  A->branch = dlsi_take(arena, nc, sizeof *A->branch);
  A->pivot = dlsi_take(arena, m, sizeof *A->pivot);
  A->p = dlsi_take(arena, m + 1, sizeof *A->p);
}

/* Returns 1 if a W of `blocks` blocks is factorised sparse. From 1/4 of all blocks on, the sparse
 * matrix takes the room of the dense one, and MUMPS takes 1 to 2.5 times as long as LAPACK (d = 3,
 * 200 and 500 contacts, band or scattered; at 1/8 0.4 to 1.1 times). */
static int states_are_sparse(int nc, int blocks) {
  return blocks < 0.25 * nc * nc;
}

dls_status dlsi_states_reserve(dlsi_states_matrix *A, int nc, int blocks, int told,
                               dls_error *error) {
  const size_t m = (size_t)A->d * (size_t)nc;
  A->sparse = 0;
  if (blocks && m > dense_limit &&
      (told ? states_are_sparse(A->nc, told) : states_are_sparse(nc, blocks))) {
    dls_error why;
    const dls_status status = dlsi_room_sparse(A->room, A->d, nc, blocks, &why);
    if (status && status != DLS_E_UNSUPPORTED) {
      if (error) *error = why;
      return status;
    }
    A->sparse = !status;
  }
  return dlsi_room_dense(A->room, A->sparse ? dense_limit : m, error);
}

dls_status dlsi_states_factor(dlsi_states_matrix *A, const dls_contact *problem,
                              const double *shift, double *scratch, dls_error *error) {
  dlsi_room *room = A->room;
  dls_status status;
  A->factors = DLSI_NO_FACTORS;
  if (A->sparse && A->n > dense_limit) {
    states_fill_blocks(problem, A->branch, shift, A->n, A->p, room, NULL);
    const dls_sparse sparse = {A->n, A->n, A->p, room->i, room->v};
    status = dlsi_sparse_lu_factor(room->lu, &sparse, error);
    if (!status) A->factors = DLSI_SPARSE_FACTORS;
    return status;
  }
  dlsi_states_fill(problem, A->branch, shift, A->n, A->p, scratch, room->J);
  A->dense = (dlsi_dense){.n = A->n, .A = room->J, .pivot = A->pivot};
  if (dlsi_dense_factor(&A->dense, scratch)) return DLS_E_SINGULAR;
  A->factors = DLSI_DENSE_FACTORS;
  return DLS_OK;
}

dls_status dlsi_states_solve(const dlsi_states_matrix *A, int transposed, double *x,
                             dls_error *error) {
  if (A->factors == DLSI_SPARSE_FACTORS)
    return (transposed ? dlsi_sparse_lu_solve_transposed : dlsi_sparse_lu_solve)(A->room->lu, x,
                                                                                 error);
  if (transposed)
    dlsi_dense_solve_transposed(&A->dense, x);
  else
    dlsi_dense_solve(&A->dense, x, A->n, 1);
  return DLS_OK;
}

/* ---- a matrix of its own --------------------------------------------------------------------- */

typedef struct states_alone {
  dlsi_states_matrix A; /* first: the two have one address */
  dlsi_room room;
} states_alone;

static void states_alone_carve(void *workspace, dlsi_arena *arena) {
  states_alone *work = workspace;
  dlsi_states_carve(&work->A, arena);
}

dls_status dlsi_states_create(dlsi_states_matrix **out, const dls_contact *problem,
                              dls_error *error) {
  states_alone filled = {.A = {.d = problem->d, .nc = problem->nc}}, *work;
  void *made;
  *out = NULL;
  dls_status status = dlsi_carve_workspace(&made, &filled, sizeof filled, states_alone_carve, "nc",
                                           problem->nc, error);
  if (status) return status;
  work = made;
  work->A.room = &work->room;
  const int blocks = problem->Wb.x ? problem->Wb.p[problem->nc] : 0;
  status = dlsi_states_reserve(&work->A, problem->nc, blocks, 0, error);
  if (status)
    dlsi_states_destroy(&work->A);
  else
    *out = &work->A;
  return status;
}

void dlsi_states_destroy(dlsi_states_matrix *A) {
  if (!A) return;
  dlsi_room_free(A->room);
  free(A);
}
