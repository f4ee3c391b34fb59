/*
 * border.c: a Newton step (newton.c, NE2) with the factors of an earlier step, after some states
 * have changed.
 *
 * M = R W C + diag is factorised for the base states. The columns of C are the directions of its n
 * unknowns, R are their rows. A contact c that has changed has d positions j in a frame of its own:
 * the first `count` are its unknowns in M, the others the directions G that complete them in dr_c.
 * Slacks replace the old rows of M at some of these positions, and the components along G become
 * unknowns. With y the slacks and components,
 *
 *   (BO1)  M z + B y = b             b: right side of the rows that stay, else 0
 *                                    B: a unit vector for a slack, R W g for a direction g
 *   (BO2)  dr = C z + G y            G y: y times g, 0 for slacks
 *   (BO3)  X = M^-1 B,  Q = rows of (G - C X) of the changed c:  dr = C M^-1 b + (G - C X) y
 *   (BO4)  V = (W C)^T on their rows,  T = W (G - C X) on their rows = -V^T X + W G
 *   (BO5)  S y = g, in Q and T: for each changed c the rows of (NE2) in its new state, and w_c
 *          times "dr_c lies in its directions"; on the right C z and V^T z of z = M^-1 b
 *   (BO6)  z := z - X y
 *
 * Three forms choose the positions and rows, each at the lowest cost:
 *
 *   WHOLE     all d positions (without friction the first alone), rows and components of r: holds
 *             every state
 *   TANGENTS  all but the first: pressed before and now. Row n stays in M
 *   FRAMED    from slip to free and back, and, where the direction stays, from free to slip:
 *             positions, rows n and across, and coefficients of that slip. If free in M, its
 *             directions are G, and their components its unknowns
 *
 * If the form of a contact cannot represent its next state, its columns are dropped (their y is 0
 * from then on), and it becomes WHOLE.
 *
 * X, V, Q and T do not depend on the new states. Another change of the same contacts costs the LU
 * of S, no change costs nothing, and each additional unknown costs 2 n^2 + 4 n k operations. A
 * solve costs 4 n k + 2 k^2 more than with M. Up to k = n / 6 that is less than the factorisation
 * of a new M, 2/3 n^3.
 *
 * (BO7)  Loose factors may serve a slip, d = 3, whose direction and l have changed. Its row across
 *        is multiplied by (w + l of the factors) / (w + l), which is right if its own entry, about
 *        w + l, outweighs the others. The solution is inexact, as it is if W has changed since M
 *        was factored; the caller sees that.
 */
#include "border.h"

#include <string.h>

#include "linear/pieces.h"
#include "vi/vi_internal.h"

enum { share = 6 };

typedef enum border_form { WHOLE, TANGENTS, FRAMED } border_form;

static const double least_cosine = 0.8; /* of the angle by which a direction may turn */

/* e (3) := direction j >= count, of G, which completes those of the unknowns to a basis. */
static void border_complement(int d, const dlsi_branch *b, int j, double *e) {
  e[0] = e[1] = e[2] = 0;
  if (d == 3 && b->count == 2) {
    e[1] = b->t[0];
    e[2] = b->t[1];
  } else
    e[j] = 1;
}

void dlsi_border_begin(dlsi_border *b, int d, int nc, const dlsi_branch *branch, int n,
                       double *spare, size_t size) {
  const size_t N = (size_t)n, m = (size_t)d * (size_t)nc;
  const size_t branches = sizeof *b->base / sizeof *spare, each = 4 + 2 * branches;
  const size_t fixed = m + (size_t)nc + (size_t)nc * branches;
  size_t rows = 0, most = N / share;
  for (int c = 0; c < nc; c++)
    rows += branch[c].mu > 0 ? (size_t)d : 1;
  /* room left by a matrix of these rows, as if contacts without friction had no tangents */
  const size_t left = rows * rows - N * N + (m - rows), room = size < left ? size : left;
  while (most && fixed + most * (each + 2 * N + 3 * most) > room)
    most--;
  b->d = d;
  b->nc = nc;
  b->n = n;
  b->k = b->held = 0;
  b->most = (int)most;
  b->X = spare;
  b->V = b->X + N * most;
  b->Q = b->V + N * most;
  b->T = b->Q + most * most;
  b->S = b->T + most * most;
  b->v = b->S + most * most;
  b->y = b->v + most;
  b->of = (int *)(b->y + most);
  b->form = b->of + most;
  b->pivot = (int *)(b->y + 2 * most);
  b->z = b->y + 3 * most;
  b->base = (dlsi_branch *)(b->z + m);
  b->frame = b->base + nc;
  b->now = b->frame + most;
  b->slot = (int *)(b->now + most);
  if (most) memcpy(b->base, branch, (size_t)nc * sizeof *branch);
  for (int c = 0; most && c < nc; c++)
    b->slot[c] = -1;
}

/* Returns 1 if factors for a serve for b. loose: two slips, d = 3, may differ in l, and in
 * direction by up to 37 degrees; the solution is then inexact. */
static int branch_serves(const dlsi_branch *a, const dlsi_branch *b, int loose) {
  if (!loose || a->state != DLS_SLIP || b->state != DLS_SLIP || a->count == 1 || b->count == 1)
    return dlsi_branch_is_same(a, b);
  return a->mu == b->mu && a->t[0] * b->t[0] + a->t[1] * b->t[1] >= least_cosine;
}

/* Returns the form for a change to this state. again: an earlier form does not fit. */
static border_form border_choose(const dlsi_border *b, int c, const dlsi_branch *now, int again) {
  const dlsi_branch *base = &b->base[c];
  if (again) return WHOLE;
  if (base->state == DLS_FREE)
    return now->state == DLS_SLIP && (now->count == 1 || b->loose) ? FRAMED : WHOLE;
  if (now->state == DLS_FREE) return base->state == DLS_SLIP ? FRAMED : WHOLE;
  return TANGENTS;
}

/* Returns the number of unknowns that a form adds. slip: the frame of FRAMED. */
static int border_width_of(const dlsi_border *b, int c, border_form form, const dlsi_branch *slip) {
  if (form == FRAMED) return slip->count;
  return form == TANGENTS ? b->d - 1 : b->base[c].mu > 0 ? b->d : 1;
}

/* Returns the slip of FRAMED for a change to this state. */
static const dlsi_branch *border_frame(const dlsi_border *b, int c, const dlsi_branch *now) {
  return b->base[c].state == DLS_FREE ? now : &b->base[c];
}

static int border_is(const dlsi_border *b, int c, border_form form) {
  return b->form[b->slot[c]] == (int)form;
}

static int border_width(const dlsi_border *b, int c) {
  const int at = b->slot[c];
  return border_width_of(b, c, (border_form)b->form[at], &b->frame[at]);
}

/* Returns the position, 0 to d - 1, of the first unknown that a contact adds. */
static int border_first(const dlsi_border *b, int c) {
  return border_is(b, c, TANGENTS);
}

static int border_fits(const dlsi_border *b, int c, const dlsi_branch *now) {
  if (b->slot[c] < 0) return branch_serves(&b->base[c], now, b->loose);
  if (border_is(b, c, WHOLE)) return 1;
  if (border_is(b, c, TANGENTS)) return now->state != DLS_FREE;
  return now->state == DLS_FREE || branch_serves(&b->frame[b->slot[c]], now, b->loose);
}

/* e (3) := the direction at position j of a changed contact: of an unknown of the factored
 * matrix, or of G. */
static void border_direction(const dlsi_border *b, int c, int j, double *e) {
  if (border_is(b, c, FRAMED))
    dlsi_branch_direction(&b->frame[b->slot[c]], j, e);
  else if (j < b->base[c].count)
    dlsi_branch_direction(&b->base[c], j, e);
  else
    border_complement(b->d, &b->base[c], j, e);
}

/* Returns row i of a changed contact times v (3): component i, or that of its frame. */
static double border_row(const dlsi_border *b, int c, int i, const double *v) {
  if (border_is(b, c, FRAMED)) return dlsi_branch_row(&b->frame[b->slot[c]], i, v);
  return i == 0 ? v[0] : i == 1 ? v[1] : v[2];
}

/* Fills column j of contact c in X with B, for (BO3). v: scratch, d nc. */
static void border_column(dlsi_border *b, const dls_contact *problem, int c, int j, double *x,
                          double *v) {
  const size_t m = (size_t)b->d * (size_t)b->nc;
  const dlsi_branch *own = &b->base[c];
  double e[3];
  memset(x, 0, (size_t)b->n * sizeof *x);
  if (j < own->count) {
    x[own->first + j] = 1;
    return;
  }
  border_direction(b, c, j, e);
  memset(v, 0, m * sizeof *v);
  dlsi_contact_add_panel(problem, 1, &c, e, v);
  dlsi_branches_rows(b->d, b->nc, b->base, v, x);
}

/* v (3) := the block of W in row c and column a times e. */
static void border_block(const dls_contact *problem, int c, int a, const double *e, double *v) {
  const size_t d = (size_t)problem->d, ld = (size_t)problem->W.ld;
  dlsi_branch_block(problem->d, problem->W.a + d * (size_t)c + d * (size_t)a * ld, ld, e, v);
}

/* Fills the columns of V for contact c. */
static void border_rows(dlsi_border *b, const dls_contact *problem, int c, double *V) {
  const int first = border_first(b, c), width = border_width(b, c);
  for (int a = 0; a < b->nc; a++)
    for (int j = 0; j < b->base[a].count; j++) {
      double e[3], v[3], *at = V + b->base[a].first + j;
      dlsi_branch_direction(&b->base[a], j, e);
      border_block(problem, c, a, e, v);
      for (int i = 0; i < width; i++)
        at[(size_t)i * (size_t)b->n] = border_row(b, c, first + i, v);
    }
}

static int border_alone(const dlsi_border *b) {
  return dlsi_is_small((size_t)b->n * (size_t)b->n);
}

/* Computes Q and T in rows row .. row + rows - 1 and columns col .. col + cols - 1. */
static void border_products(dlsi_border *b, const dls_contact *problem, int row, int rows, int col,
                            int cols) {
  const size_t n = (size_t)b->n, most = (size_t)b->most;
  double e[3], g[3], v[3];
  if (!rows || !cols) return;
  dlsi_gemm(border_alone(b), 'T', 'N', rows, cols, b->n, -1, b->V + n * (size_t)row, b->n,
            b->X + n * (size_t)col, b->n, 0, b->T + (size_t)row + most * (size_t)col, b->most);
  for (int k = col; k < col + cols; k++) {
    const int of = b->of[k];
    if (of < 0) continue; /* its y is 0 */
    const int j = border_first(b, of) + k - b->slot[of], added = j >= b->base[of].count;
    const double *x = b->X + n * (size_t)k;
    double *t = b->T + most * (size_t)k, *q = b->Q + most * (size_t)k;
    border_direction(b, of, j, e);
    for (int i = row; i < row + rows; i++) {
      const int c = b->of[i];
      if (c < 0) continue;
      const int l = border_first(b, c) + i - b->slot[c];
      const dlsi_branch *base = &b->base[c];
      if (added) border_block(problem, c, of, e, v);
      if (added) t[i] += border_row(b, c, l, v);
      if (border_is(b, c, FRAMED)) {
        q[i] = base->count ? -x[base->first + l] : i == k;
        continue;
      }
      q[i] = added && c == of ? e[l] : 0;
      for (int a = 0; a < base->count; a++) {
        dlsi_branch_direction(base, a, g);
        q[i] -= x[base->first + a] * g[l];
      }
    }
  }
}

/* Drops the unknowns of a contact whose form does not fit its state. */
static void border_give_up(dlsi_border *b, int c) {
  const int first = b->slot[c], end = first + border_width(b, c);
  for (int k = first; k < end; k++)
    b->of[k] = -1;
  b->slot[c] = -1;
  b->held = 0;
}

int dlsi_border_add(dlsi_border *b, const dls_contact *problem, const dlsi_dense *factors,
                    const dlsi_branch *branch) {
  const int before = b->k;
  const size_t n = (size_t)b->n;
  int k = before;
  for (int c = 0; b->most && c < b->nc; c++) {
    const dlsi_branch *now = &branch[c];
    if (now->mu > 0 && !(b->base[c].mu > 0)) return 0;
    if (border_fits(b, c, now)) continue;
    const border_form form = border_choose(b, c, now, b->slot[c] >= 0);
    k += border_width_of(b, c, form, border_frame(b, c, now));
  }
  if (k == before) return 1;
  if (k > b->most) return 0;
  for (int c = 0; c < b->nc; c++) {
    const dlsi_branch *now = &branch[c];
    if (border_fits(b, c, now)) continue;
    const int again = b->slot[c] >= 0;
    if (again) border_give_up(b, c);
    b->slot[c] = b->k;
    b->form[b->k] = (int)border_choose(b, c, now, again);
    b->frame[b->k] = *border_frame(b, c, now);
    const int width = border_width(b, c), first = border_first(b, c);
    for (int j = 0; j < width; j++) {
      border_column(b, problem, c, first + j, b->X + n * (size_t)(b->k + j), b->z);
      b->of[b->k + j] = c;
    }
    border_rows(b, problem, c, b->V + n * (size_t)b->k);
    b->k += width;
  }
  const int added = b->k - before;
  dlsi_dense_solve(factors, b->X + n * (size_t)before, b->n, added);
  border_products(b, problem, 0, before, before, added);
  border_products(b, problem, before, added, 0, b->k);
  return 1;
}

/* (BO5) Returns equation i of contact c in the state `now`. r, u (3): its dr and W dr, in its frame
 * if it has one. */
static double border_equation(const dlsi_border *b, int c, const dlsi_branch *now, int i, double w,
                              double diagonal, const double *r, const double *u) {
  const int across = now->state == DLS_SLIP && i == 1;
  const double spring = diagonal + (across ? now->l : 0);
  if (border_is(b, c, FRAMED)) return now->state == DLS_FREE ? w * r[i] : u[i] + spring * r[i];
  if (i < now->count)
    return dlsi_branch_row(now, i, u) + spring * (across ? dlsi_branch_row(now, 1, r) : r[i]);
  if (now->state == DLS_FREE || !(now->mu > 0)) return w * r[i];
  return w * (now->t[0] * r[1] + now->t[1] * r[2] - now->mu * r[0]);
}

/* dr (3) := (BO2) of contact c from z and, if y is not NULL, its part of y; in its frame, if it
 * has one. */
static void border_part(const dlsi_border *b, int c, const double *z, const double *y, double *dr) {
  const dlsi_branch *base = &b->base[c];
  const int first = border_first(b, c), end = first + border_width(b, c);
  double e[3];
  dr[0] = dr[1] = dr[2] = 0;
  if (border_is(b, c, FRAMED)) {
    for (int j = 0; j < end; j++)
      dr[j] = base->count ? z[base->first + j] : y ? y[j] : 0;
    return;
  }
  for (int j = 0; j < (end > base->count ? end : base->count); j++) {
    if (j >= base->count && !y) break;
    border_direction(b, c, j, e);
    for (int l = 0; l < 3; l++)
      dr[l] += (j < base->count ? z[base->first + j] : y[j - first]) * e[l];
  }
}

/* (BO5) Computes row `row` of S. */
static void border_fill(dlsi_border *b, int row, const dlsi_branch *branch, const double *w,
                        const double *E, double eps) {
  const size_t n = (size_t)b->n, most = (size_t)b->most;
  const int c = b->of[row];
  double *S = b->S + row;
  for (size_t k = 0; c < 0 && k < (size_t)b->k; k++)
    S[k * most] = k == (size_t)row;
  if (c < 0) return;
  const int at = b->slot[c], first = border_first(b, c), width = border_width(b, c);
  const double diagonal = eps * w[c] + (E ? E[c] : 0);
  b->now[at] = branch[c];
  for (size_t k = 0; k < (size_t)b->k; k++) {
    const double *Q = b->Q + at + k * most, *T = b->T + at + k * most;
    double r[3] = {0}, u[3] = {0};
    if (first) r[0] = -b->X[(size_t)b->base[c].first + n * k];
    memcpy(r + first, Q, (size_t)width * sizeof *r);
    memcpy(u + first, T, (size_t)width * sizeof *u);
    S[k * most] = b->of[k] < 0
                      ? 0
                      : border_equation(b, c, &branch[c], first + row - at, w[c], diagonal, r, u);
  }
}

/* Factorises S for these states, unless its factors serve. Returns 0 if S is singular. */
static int border_factor(dlsi_border *b, const dlsi_branch *branch, const double *w,
                         const double *E, double eps) {
  int serves = b->held == b->k;
  for (int k = 0; serves && k < b->k; k++) {
    const int c = b->of[k];
    serves = c < 0 || branch_serves(&b->now[b->slot[c]], &branch[c], b->loose);
  }
  if (serves) return 1;
  b->held = 0;
  for (int row = 0; row < b->k; row++)
    border_fill(b, row, branch, w, E, eps);
  if (dlsi_getrf(border_alone(b), b->k, b->S, b->most, b->pivot)) return 0;
  b->held = b->k;
  return 1;
}

/* (BO7) Returns the factor of the row across if factors for `old` serve for `now`. */
static double border_scale(const dlsi_branch *old, const dlsi_branch *now, double w) {
  const int both = now->count == 2 && old->state == DLS_SLIP && now->state == DLS_SLIP;
  return both ? (w + old->l) / (w + now->l) : 1;
}

/* (BO5) y := the right side, from x and z. */
static void border_right(dlsi_border *b, const dlsi_branch *branch, const double *w,
                         const double *E, double eps, const double *x) {
  dlsi_panel_dot((size_t)b->n, b->k, b->V, b->z, b->v);
  for (int row = 0; row < b->k; row++) {
    const int c = b->of[row];
    b->y[row] = 0;
    if (c < 0) continue;
    const int at = b->slot[c], first = border_first(b, c), i = first + row - at;
    const dlsi_branch *now = &branch[c];
    const double diagonal = eps * w[c] + (E ? E[c] : 0);
    double r[3], u[3] = {0};
    border_part(b, c, b->z, NULL, r);
    memcpy(u + first, b->v + at, (size_t)border_width(b, c) * sizeof *u);
    b->y[row] = (i < now->count ? x[now->first + i] : 0) -
                border_equation(b, c, now, i, w[c], diagonal, r, u);
    if (i == 1) b->y[row] *= border_scale(&b->now[at], now, w[c]);
  }
}

int dlsi_border_solve(dlsi_border *b, const dlsi_dense *factors, const dlsi_branch *branch,
                      const double *w, const double *E, double eps, double *x) {
  const int k = b->k;
  double dr[3];
  if (!b->most) {
    dlsi_dense_solve(factors, x, b->n, 1);
    return 1;
  }
  if (k && !border_factor(b, branch, w, E, eps)) return 0;
  memset(b->z, 0, (size_t)b->n * sizeof *b->z);
  for (int c = 0; c < b->nc; c++) {
    const int tangents = b->slot[c] >= 0 && border_is(b, c, TANGENTS);
    const int rows = tangents ? 1 : b->slot[c] < 0 ? branch[c].count : 0;
    for (int i = 0; i < rows; i++) {
      const double scale = i == 1 ? border_scale(&b->base[c], &branch[c], w[c]) : 1;
      b->z[b->base[c].first + i] = scale * x[branch[c].first + i];
    }
  }
  dlsi_dense_solve(factors, b->z, b->n, 1);
  if (k) {
    border_right(b, branch, w, E, eps, x);
    dlsi_getrs(border_alone(b), k, 1, b->S, b->most, b->pivot, b->y, b->most);
    dlsi_panel_subtract((size_t)b->n, k, b->X, b->y, b->z);
  }
  for (int c = 0; c < b->nc; c++) {
    const dlsi_branch *now = &branch[c];
    const int s = b->slot[c], across = s >= 0 && now->state == DLS_SLIP && !border_is(b, c, FRAMED);
    if (s >= 0) border_part(b, c, b->z, b->y + s, dr);
    for (int i = 0; i < now->count; i++)
      x[now->first + i] = s < 0              ? b->z[b->base[c].first + i]
                          : across && i == 1 ? dlsi_branch_row(now, 1, dr)
                                             : dr[i];
  }
  return 1;
}
