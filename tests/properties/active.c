/*
 * active.c: the equations of active.h: their unknowns, their matrix, Newton's method.
 *
 * Source: first-order perturbation of the active equations, as in any book on complementarity.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "active.h"

enum { most_steps = 12 };

active *active_create(const problem *p) {
  active *s = problem_alloc(sizeof *s);
  const size_t m = (size_t)p->m, nc = (size_t)p->nc;
  s->p = p;
  s->w = problem_alloc((2 * nc + 7 * m) * sizeof(real));
  s->r = s->w + 2 * nc, s->u = s->r + m, s->a = s->u + m;
  s->x = s->a + m, s->y = s->x + m, s->b = s->y + m;
  s->branch = problem_alloc((nc + m) * sizeof(int));
  s->pivot = s->branch + nc;
  s->z = problem_alloc(m * sizeof *s->z);
  measure_weights(p, s->w);
  return s;
}

void active_destroy(active *s) {
  free(s->w);
  free(s->branch);
  free(s->z);
  free(s->A);
  free(s);
}

/* ---- states ---------------------------------------------------------------------------------- */

/* u := W r + q, a := |W||r| + |q| */
static void find_positions(active *s) {
  const problem *p = s->p;
  const size_t m = (size_t)p->m;
  for (size_t i = 0; i < m; i++) {
    s->u[i] = p->q[i];
    s->a[i] = fabsl(s->u[i]);
  }
  for (size_t j = 0; j < m; j++)
    for (size_t i = 0; s->r[j] != 0 && i < m; i++) {
      const real t = p->W[i + j * m] * s->r[j];
      s->u[i] += t;
      s->a[i] += fabsl(t);
    }
}

static void find_states(active *s) {
  for (int c = 0; c < s->p->nc; c++)
    s->branch[c] = measure_branch(s->p, c, s->w, s->r + s->p->d * c, s->u + s->p->d * c, NULL);
}

real active_length(const real *x, int n) {
  real sum = 0;
  for (int i = 0; i < n; i++)
    sum += x[i] * x[i];
  return sqrtl(sum);
}

/* r_c := what its state allows; e (2) := the direction of its friction. */
static void project(const active *s, int c, real *e) {
  const int d = s->p->d;
  const real mu = s->p->mu[c], wt = s->w[2 * c + 1];
  real *r = s->r + d * c, *u = s->u + d * c, x[2] = {0};
  e[0] = e[1] = 0;
  if (s->branch[c] == 1) return;
  if (s->branch[c] == 0) {
    for (int k = 0; k < d; k++)
      r[k] = 0;
    return;
  }
  for (int k = 1; k < d; k++)
    x[k - 1] = wt * r[k] - u[k];
  const real norm = hypotl(x[0], x[1]);
  for (int k = 1; k < d; k++) {
    e[k - 1] = norm > 0 ? x[k - 1] / norm : 0;
    r[k] = mu * r[0] * e[k - 1];
  }
}

static unknown *add_unknown(active *s, int c, int tangent) {
  unknown *z = &s->z[s->n++];
  *z = (unknown){.c = c, .tangent = tangent};
  return z;
}

void active_list(active *s) {
  const int d = s->p->d;
  real e[2];
  s->n = 0;
  for (int c = 0; c < s->p->nc; c++) {
    const real mu = s->p->mu[c], *r = s->r + d * c, *u = s->u + d * c;
    project(s, c, e);
    for (int k = 0; s->branch[c] == 1 && k < d; k++) {
      unknown *z = add_unknown(s, c, k > 0);
      z->g[k] = z->h[k] = 1;
    }
    if (s->branch[c] != 2) continue;
    unknown *z = add_unknown(s, c, 0);
    z->g[0] = z->h[0] = 1;
    for (int k = 1; k < d; k++)
      z->g[k] = mu * e[k - 1];
    if (d < 3 || mu == 0) continue;
    z = add_unknown(s, c, 1);
    z->g[1] = z->h[1] = -e[1];
    z->g[2] = z->h[2] = e[0];
    z->turn = -(u[1] * e[0] + u[2] * e[1]) / (mu * r[0]);
  }
}

static real scale_of(const active *s, const unknown *z) {
  return sqrtl(s->w[2 * z->c + z->tangent]);
}

/* A in units in which its diagonal is about 1. */
static void form_matrix(active *s) {
  const int d = s->p->d, n = s->n;
  const size_t m = (size_t)s->p->m;
  free(s->A);
  s->A = problem_alloc((size_t)n * (size_t)n * sizeof(real));
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) {
      const unknown *row = &s->z[i], *column = &s->z[j];
      real sum = i == j ? row->turn : 0;
      for (int l = 0; l < d; l++)
        for (int k = 0; column->g[l] != 0 && k < d; k++)
          sum += row->h[k] * column->g[l] *
                 s->p->W[(size_t)(d * row->c + k) + (size_t)(d * column->c + l) * m];
      s->A[(size_t)i + (size_t)j * (size_t)n] = sum / (scale_of(s, row) * scale_of(s, column));
    }
}

/* A := L U, rows exchanged */
int active_factor(active *s) {
  form_matrix(s);
  const size_t n = (size_t)s->n;
  real largest = 0;
  for (size_t k = 0; k < n * n; k++)
    largest = fmaxl(largest, fabsl(s->A[k]));
  for (size_t k = 0; k < n; k++) {
    real *column = s->A + k * n;
    size_t at = k;
    for (size_t i = k + 1; i < n; i++)
      if (fabsl(column[i]) > fabsl(column[at])) at = i;
    s->pivot[k] = (int)at;
    if (!(fabsl(column[at]) > 16 * (real)n * LDBL_EPSILON * largest)) return 0;
    for (size_t j = 0; at != k && j < n; j++) {
      const real t = s->A[k + j * n];
      s->A[k + j * n] = s->A[at + j * n];
      s->A[at + j * n] = t;
    }
    for (size_t i = k + 1; i < n; i++)
      column[i] /= column[k];
    for (size_t j = k + 1; j < n; j++) {
      real *other = s->A + j * n;
      for (size_t i = k + 1; other[k] != 0 && i < n; i++)
        other[i] -= column[i] * other[k];
    }
  }
  return 1;
}

/* A is in other units than the user's. */
void active_solve(active *s, int transposed, real *b) {
  const size_t n = (size_t)s->n;
  for (size_t i = 0; i < n; i++)
    b[i] /= scale_of(s, &s->z[i]);
  for (size_t k = 0; !transposed && k < n; k++) {
    const size_t at = (size_t)s->pivot[k];
    const real t = b[at];
    b[at] = b[k];
    b[k] = t;
  }
  if (!transposed) {
    for (size_t k = 0; k < n; k++)
      for (size_t i = k + 1; i < n; i++)
        b[i] -= s->A[i + k * n] * b[k];
    for (size_t k = n; k-- > 0;) {
      b[k] /= s->A[k + k * n];
      for (size_t i = 0; i < k; i++)
        b[i] -= s->A[i + k * n] * b[k];
    }
  } else {
    for (size_t k = 0; k < n; k++) {
      for (size_t i = 0; i < k; i++)
        b[k] -= s->A[i + k * n] * b[i];
      b[k] /= s->A[k + k * n];
    }
    for (size_t k = n; k-- > 0;)
      for (size_t i = k + 1; i < n; i++)
        b[k] -= s->A[i + k * n] * b[i];
  }
  for (size_t k = n; transposed && k-- > 0;) {
    const size_t at = (size_t)s->pivot[k];
    const real t = b[at];
    b[at] = b[k];
    b[k] = t;
  }
  for (size_t i = 0; i < n; i++)
    b[i] /= scale_of(s, &s->z[i]);
}

/* ---- Newton's method ------------------------------------------------------------------------ */

/* Returns 1 if F of r is 0 to long double precision. */
static int is_true(const active *s) {
  const int d = s->p->d;
  real FF = 0, aa = 0, forces = 0, bb = 0;
  for (int c = 0; c < s->p->nc; c++) {
    const real *w = s->w + 2 * c, *r = s->r + d * c, *u = s->u + d * c;
    real F[3] = {0}, e[3] = {0};
    const int branch = measure_branch(s->p, c, s->w, r, u, F);
    measure_rounding(s->p, c, branch, s->w, r, u, s->a + d * c, e);
    for (int k = 0; k < d; k++) {
      FF += F[k] * F[k];
      forces += F[k] / w[k > 0] * (F[k] / w[k > 0]);
      aa += e[k] * e[k];
      bb += e[k] / w[k > 0] * (e[k] / w[k > 0]);
    }
  }
  return sqrtl(FF) <= 1e3L * LDBL_EPSILON * sqrtl(aa) &&
         sqrtl(forces) <= 1e3L * LDBL_EPSILON * sqrtl(bb);
}

int active_find(active *s) {
  const problem *p = s->p;
  const int d = p->d;
  real last = INFINITY;
  s->singular = 0;
  for (int step = 0; step < most_steps; step++) {
    find_positions(s);
    find_states(s);
    active_list(s);
    find_positions(s);
    if (!active_factor(s)) return -1;
    if (step > 1 && last <= 1e-6L * active_length(s->r, p->m) && is_true(s)) return 1;
    for (int i = 0; i < s->n; i++) {
      s->b[i] = 0;
      for (int k = 0; k < d; k++)
        s->b[i] -= s->z[i].h[k] * s->u[d * s->z[i].c + k];
    }
    active_solve(s, 0, s->b);
    for (int i = 0; i < p->m; i++)
      s->x[i] = 0;
    for (int i = 0; i < s->n; i++)
      for (int k = 0; k < d; k++)
        s->x[d * s->z[i].c + k] += s->b[i] * s->z[i].g[k];
    last = active_length(s->x, p->m);
    for (int i = 0; i < p->m; i++)
      s->r[i] += s->x[i];
    if (!(last <= LDBL_MAX)) return 0;
  }
  return 0;
}
