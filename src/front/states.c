/*
 * states.c: all states of a small contact problem, d = 2, one after the other.
 *
 * A candidate is free, sticks, or slips in one of two directions (one for mu = 0). With the states
 * chosen, what is left of the laws are linear equations for numbers that must not be negative:
 *
 *   (ST1)  free    r = 0                                     u_n = x0
 *          stick   r = (x0 + x1) / 2, mu (x0 - x1) / 2       u = 0            edges of the cone
 *          slip s  r = (x0, s mu x0), s = 1 or -1            u = (0, -s x1)
 *   (ST2)  C x = q,  x >= 0:  u = W r + q, without the tangential rows of those that are free
 *
 * One phase of the simplex method finds an x or shows that there is none, to 1e-10
 * (lcp/enumerate.c). If no states have one the problem has no solution, as far as rounding can
 * tell.
 *
 * Cost: 4^nc small linear programs: 65,536 of up to 16 rows for nc = 8.
 */
#include <math.h>
#include <string.h>

#include "front/front.h"
#include "lcp/lcp_internal.h"
#include "vi/vi_internal.h"

enum { most_rows = 2 * dlsi_most_states };

typedef enum state { FREE, STICK, SLIP_LEFT, SLIP_RIGHT } state;

/* The problem in scaled unknowns: W_ij / sqrt(w_i w_j), q / sqrt(w), its largest entry being 1. */
typedef struct states {
  int nc;
  double W[most_rows][most_rows], q[most_rows], mu[dlsi_most_states];
  double unit[dlsi_most_states]; /* r_c = unit_c times the scaled r_c */
  state state[dlsi_most_states];
} states;

static void states_scale(const dls_contact *problem, states *s) {
  double w[dlsi_most_states], most = 0, largest = 0;
  const int nc = s->nc = problem->nc, m = 2 * nc;
  dlsi_contact_weights(problem, w);
  for (int c = 0; c < nc; c++)
    most = fmax(most, w[c]);
  for (int c = 0; c < nc; c++) { /* scales over the largest: powers of two change no bit */
    s->unit[c] = sqrt(most / w[c]);
    s->mu[c] = problem->mu[c];
  }
  for (int j = 0; j < m; j++) {
    double e[2] = {j % 2 == 0, j % 2}, column[most_rows] = {0};
    dlsi_contact_add_columns(problem, j / 2, e, column);
    for (int i = 0; i < m; i++)
      s->W[i][j] = column[i] * s->unit[i / 2] * s->unit[j / 2] / most;
    s->q[j] = problem->q[j] * s->unit[j / 2];
    largest = fmax(largest, fabs(s->q[j]));
  }
  for (int c = 0; c < nc; c++)
    s->unit[c] *= largest / most;
  for (int j = 0; j < m; j++)
    s->q[j] /= largest;
}

/* Returns how many unknowns a candidate has, and in edge[] the r of each (ST1). */
static int states_edges(const states *s, int c, double edge[2][2]) {
  const double mu = s->mu[c];
  memset(edge, 0, 4 * sizeof edge[0][0]);
  switch (s->state[c]) {
  case FREE:
    return 1;
  case STICK:
    edge[0][0] = edge[1][0] = 0.5;
    edge[0][1] = 0.5 * mu;
    edge[1][1] = -0.5 * mu;
    return 2;
  default:
    edge[0][0] = 1;
    edge[0][1] = s->state[c] == SLIP_LEFT ? -mu : mu;
    return mu > 0 ? 2 : 1;
  }
}

/* Solves (ST2). Returns 1 with r (m), 0 if there is none, -1 if rounding does not tell. */
static int states_solve(const states *s, double *r) {
  int row[most_rows], rows = 0, n = 0, first[dlsi_most_states];
  double C[most_rows * (most_rows + 1)], x[most_rows], edge[2][2];
  for (int c = 0; c < s->nc; c++) {
    const int both = s->state[c] != FREE && s->mu[c] > 0;
    first[c] = n;
    n += states_edges(s, c, edge);
    row[rows++] = 2 * c;
    if (both) row[rows++] = 2 * c + 1;
  }
  for (int c = 0; c < s->nc; c++) {
    const int count = states_edges(s, c, edge), free = s->state[c] == FREE;
    const int slips = s->state[c] == SLIP_LEFT || s->state[c] == SLIP_RIGHT;
    for (int k = 0; k < count; k++)
      for (int i = 0; i < rows; i++) {
        double *at = &C[i * (n + 1) + first[c] + k];
        *at = -(s->W[row[i]][2 * c] * edge[k][0] + s->W[row[i]][2 * c + 1] * edge[k][1]);
        if (free && row[i] == 2 * c) *at = 1;
        if (slips && k == 1) *at = row[i] != 2 * c + 1 ? 0 : s->state[c] == SLIP_LEFT ? 1 : -1;
      }
  }
  for (int i = 0; i < rows; i++)
    C[i * (n + 1) + n] = s->q[row[i]];
  const int found = dlsi_find_vertex(n, C, x);
  if (found < 1) return found;
  for (int c = 0; c < s->nc; c++) {
    const int count = states_edges(s, c, edge);
    r[2 * c] = r[2 * c + 1] = 0;
    for (int k = 0; k < count; k++)
      for (int i = 0; i < 2; i++)
        r[2 * c + i] += s->unit[c] * edge[k][i] * x[first[c] + k];
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

int dlsi_contact_find_states(const dls_contact *problem, double tol, double *r, double *best,
                             dls_certificate *certificate) {
  states s;
  int result = 0;
  memset(&s, 0, sizeof s);
  states_scale(problem, &s);
  do {
    dls_certificate now;
    const int found = states_solve(&s, r);
    if (found < 0) result = -1;
    if (found < 1 || dls_contact_certify(problem, r, NULL, &now, NULL)) continue;
    result = -1; /* unless it is as good as certified, rounding has the say */
    if (dlsi_is_better(&now, certificate)) {
      *certificate = now;
      memcpy(best, r, 2 * (size_t)problem->nc * sizeof *r);
    }
    if (dls_certificate_holds(certificate, tol)) return 1;
  } while (states_next(&s));
  return result;
}
