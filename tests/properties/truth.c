/*
 * truth.c: rule 8. The true answer of the stored numbers, in long double, and its condition.
 *
 * With the states of the candidates chosen, the laws are linear but for the direction of slip in 3D
 * (e = r_t / |r_t|, e' normal to it). Unknowns z and equations of
 *
 *   stick  r (d)                                       u = 0
 *   slip   r_n, with r_t = mu r_n e                    u_n = 0
 *          3D: force along e', which turns r_t         u_t.e' = 0, turned: + |u_t| / (mu r_n)
 *
 * (T1) r := Newton's method on them from the planted answer; the states are those of measure.c at
 *      every step. r is the truth where its F is 0 to long double precision and it is next to the
 *      planted one: else the rounding of q has moved the answer, and nothing is known.
 * (T2) dr = G A^-1 H' du: G the columns, H the rows, A = H' W G + the turns. With the residuals of
 *      the certificate, |du| <= tol |q| and |D^-1 du| <= tol |r|: the condition is the smaller one of
 *      |G A^-1 H'| |q| / |r| and |G A^-1 H' D|, that of positions |W G A^-1 H'|. Norms by power
 *      iteration.
 * (T3) An answer far from the truth may be near another one: Newton's method from there tells.
 *
 * (T4) An answer whose error is too large is judged once more with the candidates closed, and stuck,
 *      that are on the border of their state as far as the tolerance can tell.
 *
 * Source: first-order perturbation of the active equations, as in any book on complementarity.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "problem.h"

typedef long double real;

enum { most_rows = 1300, most_steps = 12, norm_steps = 8 };

typedef struct unknown {
  int c, tangent;  /* candidate; 1: its scale is that of w_t */
  real g[3], h[3]; /* column of G and of H, d entries */
  real turn;
} unknown;

typedef struct active {
  const problem *p;
  int n;
  real *w, *r, *u, *a; /* weights 2 nc; m each; a = |W||r| + |q| */
  int *branch, *pivot; /* nc; n */
  int singular;        /* after (T4) */
  unknown *z;          /* m */
  real *A;             /* n x n: its LU */
  real *x, *y, *b;     /* scratch: m, m, n */
} active;

static active *active_create(const problem *p) {
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

static void active_destroy(active *s) {
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

static real length(const real *x, int n) {
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

/* The unknowns in these states; r, u: on them. */
static void list_unknowns(active *s) {
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

/* A := L U, rows exchanged; returns 0 where a pivot is rounding. */
static int factor_matrix(active *s) {
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

/* b := A^-1 b, or A^-T b, in the user's units. */
static void solve_matrix(active *s, int transposed, real *b) {
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

/* ---- Newton's method (T1) -------------------------------------------------------------------- */

/* Returns 1 if F of r is 0 to long double precision. */
static int is_true(const active *s) {
  const int d = s->p->d;
  real FF = 0, aa = 0, forces = 0, bb = 0;
  for (int c = 0; c < s->p->nc; c++) {
    const real *w = s->w + 2 * c, *r = s->r + d * c, *a = s->a + d * c;
    const real mu = isinf(s->p->mu[c]) ? 0 : s->p->mu[c];
    real F[3] = {0}, e[3] = {0};
    const int touches = measure_branch(s->p, c, s->w, r, s->u + d * c, F);
    for (int k = 0; touches && k < d; k++) {
      e[k] += a[k] + w[k > 0] * fabsl(r[k]);
      if (k) e[0] += mu * (a[k] + w[1] * fabsl(r[k]));
    }
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

/* r: a start, overwritten. Returns 1: r is an answer, A its factor; 0: none found; -1: A singular. */
static int find_truth(active *s) {
  const problem *p = s->p;
  const int d = p->d;
  real last = INFINITY;
  s->singular = 0;
  for (int step = 0; step < most_steps; step++) {
    find_positions(s);
    find_states(s);
    list_unknowns(s);
    find_positions(s);
    form_matrix(s);
    if (!factor_matrix(s)) return -1;
    if (step > 1 && last <= 1e-6L * length(s->r, p->m) && is_true(s)) return 1;
    for (int i = 0; i < s->n; i++) {
      s->b[i] = 0;
      for (int k = 0; k < d; k++)
        s->b[i] -= s->z[i].h[k] * s->u[d * s->z[i].c + k];
    }
    solve_matrix(s, 0, s->b);
    for (int i = 0; i < p->m; i++)
      s->x[i] = 0;
    for (int i = 0; i < s->n; i++)
      for (int k = 0; k < d; k++)
        s->x[d * s->z[i].c + k] += s->b[i] * s->z[i].g[k];
    last = length(s->x, p->m);
    for (int i = 0; i < p->m; i++)
      s->r[i] += s->x[i];
    if (!(last <= LDBL_MAX)) return 0;
  }
  return 0;
}

/* ---- condition (T2) -------------------------------------------------------------------------- */

/* x (m) := W x, or W' x, of the candidates that touch */
static void multiply_touching(active *s, int transposed, real *x) {
  const problem *p = s->p;
  const size_t m = (size_t)p->m;
  for (size_t i = 0; i < m; i++)
    s->y[i] = 0;
  for (size_t j = 0; j < m; j++)
    for (size_t i = 0; s->branch[j / (size_t)p->d] && i < m; i++)
      if (s->branch[i / (size_t)p->d]) {
        if (transposed)
          s->y[j] += p->W[i + j * m] * x[i];
        else
          s->y[i] += p->W[i + j * m] * x[j];
      }
  memcpy(x, s->y, m * sizeof *x);
}

/* x (m) := G A^-1 H' D x (of_r), G A^-1 H' x, or W G A^-1 H' x (of_u); or the transposed product. */
typedef enum map_kind { OF_Q, OF_R, OF_U } map_kind;

static void apply_map(active *s, map_kind of, int transposed, real *x) {
  const int d = s->p->d;
  if (of == OF_U && transposed) multiply_touching(s, 1, x);
  for (int i = 0; of == OF_R && !transposed && i < s->p->m; i++)
    x[i] *= s->w[2 * (i / d) + (i % d > 0)];
  for (int i = 0; i < s->n; i++) {
    const real *v = transposed ? s->z[i].g : s->z[i].h;
    s->b[i] = 0;
    for (int k = 0; k < d; k++)
      s->b[i] += v[k] * x[d * s->z[i].c + k];
  }
  solve_matrix(s, transposed, s->b);
  for (int i = 0; i < s->p->m; i++)
    x[i] = 0;
  for (int i = 0; i < s->n; i++)
    for (int k = 0; k < d; k++)
      x[d * s->z[i].c + k] += s->b[i] * (transposed ? s->z[i].h[k] : s->z[i].g[k]);
  for (int i = 0; of == OF_R && transposed && i < s->p->m; i++)
    x[i] *= s->w[2 * (i / d) + (i % d > 0)];
  if (of == OF_U && !transposed) multiply_touching(s, 0, x);
}

static real norm_of_map(active *s, map_kind of) {
  dice g = {12345};
  real norm = 0;
  if (s->singular) return INFINITY;
  for (int i = 0; i < s->p->m; i++)
    s->x[i] = dice_between(&g, -1, 1);
  for (int step = 0; step < norm_steps; step++) {
    const real size = length(s->x, s->p->m);
    if (!(size > 0)) return norm;
    for (int i = 0; i < s->p->m; i++)
      s->x[i] /= size;
    apply_map(s, of, 0, s->x);
    norm = fmaxl(norm, length(s->x, s->p->m));
    apply_map(s, of, 1, s->x);
  }
  return norm;
}

/* |q| of the candidates that touch */
static real load_of(const active *s) {
  real sum = 0;
  for (int i = 0; i < s->p->m; i++)
    if (s->branch[i / s->p->d]) sum += (real)s->p->q[i] * s->p->q[i];
  return sqrtl(sum);
}

/* (T4) Closes the candidates that are open by less than `gap` and sticks those that slip by less.
 * Returns 0 where there is none; A is then as before. A singular: its norms are infinite. */
static int widen_states(active *s, real gap) {
  const int d = s->p->d;
  int changed = 0;
  for (int c = 0; c < s->p->nc; c++) {
    const real *u = s->u + d * c;
    const real ut = d == 1 ? 0 : d == 2 ? fabsl(u[1]) : hypotl(u[1], u[2]);
    const int near = s->branch[c] == 0 ? u[0] <= gap : s->branch[c] == 2 && ut <= gap;
    if (!near || (s->branch[c] == 2 && s->p->mu[c] == 0)) continue;
    s->branch[c] = 1;
    changed = 1;
  }
  if (!changed) return 0;
  list_unknowns(s);
  form_matrix(s);
  s->singular = !factor_matrix(s);
  return 1;
}

/* ---- the judge ------------------------------------------------------------------------------- */

/* Fills the errors of r against the answer that s holds, and judges them. moved: how far this answer
 * is from the one that was planted, relative to it; no farther than the rounding of q may move it. */
static void compare(active *s, const double *r, double tol, int capped, real moved, truth *out) {
  const int d = s->p->d, m = s->p->m;
  real rr = length(s->r, m), top = 0, far = 0, sum = 0, uu = 0, du = 0;
  for (int i = 0; i < m; i++) {
    const real e = r[i] - s->r[i];
    top = fmaxl(top, fabsl(s->r[i]));
    far = fmaxl(far, fabsl(e));
    sum += e * e;
    s->x[i] = e;
  }
  for (int c = 0; c < s->p->nc; c++)
    for (int k = 0; k < d; k++) {
      const int i = d * c + k;
      real e = 0;
      for (int j = 0; s->branch[c] && j < m; j++)
        e += s->p->W[(size_t)i + (size_t)j * (size_t)m] * s->x[j];
      du += e * e;
      uu += s->branch[c] ? s->u[i] * s->u[i] : 0;
    }
  const real load = load_of(s), most = capped ? 1e-2L : LDBL_MAX;
  out->error = (double)(sum == 0 ? 0 : sqrtl(sum) / rr);
  out->largest = (double)(far == 0 ? 0 : far / top);
  const real error_u = du == 0 ? 0 : sqrtl(du) / (load + sqrtl(uu));
  out->verdict = TRUTH_HOLDS;
  if (rr == 0 && sum > 0) { /* r_true = 0: no scale, the certificate has none either */
    out->verdict = TRUTH_UNKNOWN;
    return;
  }
  if (out->error <= tol && error_u <= tol) return;
  for (int wide = 0; wide < 2; wide++) {
    if (wide && !widen_states(s, 1000 * (real)tol * load)) break;
    const real by_r = norm_of_map(s, OF_R), by_q = norm_of_map(s, OF_Q) * load / rr;
    const real worst = fmaxl(by_r, by_q);
    out->condition = (double)fminl(by_r, by_q);
    const real by_u = fmaxl(fmaxl(1, out->condition), norm_of_map(s, OF_U));
    out->verdict = TRUTH_UNKNOWN;
    if (worst * LDBL_EPSILON > 1e-6L || moved > 1e3L * DBL_EPSILON * fmaxl(1, worst)) return;
    out->verdict = TRUTH_WRONG_R;
    if (!(out->error <= fminl(1000 * (real)tol * out->condition, most))) continue;
    out->verdict = TRUTH_WRONG_U;
    if (!(error_u <= fminl(1000 * (real)tol * by_u, most))) continue;
    out->verdict = TRUTH_HOLDS;
    return;
  }
  if (out->verdict == TRUTH_WRONG_U) out->error = (double)error_u;
}

/* (T1) from r (m). *moved: how far the answer is from it, relative to it. */
static int start_from(active *s, const double *r, real *moved) {
  for (int i = 0; i < s->p->m; i++)
    s->r[i] = r[i];
  const int found = find_truth(s);
  for (int i = 0; i < s->p->m; i++)
    s->x[i] = s->r[i] - r[i];
  const real size = length(s->r, s->p->m), step = length(s->x, s->p->m);
  *moved = step == 0 ? 0 : size == 0 ? INFINITY : step / size;
  return found;
}

/* (T3) Returns what the verdict on an answer that is not the planted one comes to: Newton's method
 * starts from it, and from it without reactions that the tolerance hides. */
static truth_verdict look_beside(active *s, const double *r, double tol, int capped,
                                 truth_verdict verdict) {
  const int d = s->p->d, m = s->p->m;
  double *start = problem_alloc((size_t)m * sizeof *start), size = 0;
  for (int i = 0; i < m; i++)
    size += r[i] * r[i];
  for (int without = 0; without < 2; without++) {
    truth other = {.verdict = TRUTH_UNKNOWN};
    real moved;
    for (int i = 0; i < m; i++) {
      const int tiny = fabs(r[d * (i / d)]) <= 1000 * tol * sqrt(size);
      start[i] = without && tiny ? 0 : r[i];
    }
    const int found = start_from(s, start, &moved);
    if (found == 1) compare(s, r, tol, capped, 0, &other);
    if (found == 1 && other.verdict == TRUTH_HOLDS) verdict = TRUTH_OTHER;
    if (found == -1 && verdict != TRUTH_OTHER) verdict = TRUTH_UNKNOWN;
  }
  free(start);
  return verdict;
}

void judge_truth(const problem *p, const double *r, double tol, int capped, truth *out) {
  memset(out, 0, sizeof *out);
  out->tol = tol;
  out->verdict = TRUTH_UNKNOWN;
  if (p->kind != SOLVABLE || p->m > most_rows) return;
  active *s = active_create(p);
  real moved;
  if (start_from(s, p->r, &moved) == 1 && moved <= 1e-3L) {
    compare(s, r, tol, capped, moved, out);
    const int wrong = out->verdict == TRUTH_WRONG_R || out->verdict == TRUTH_WRONG_U;
    if (wrong) out->verdict = look_beside(s, r, tol, capped, out->verdict);
  }
  active_destroy(s);
}
