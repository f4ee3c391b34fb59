/*
 * truth.c: rule 8. The true answer of the stored numbers, in long double, and its condition.
 *
 * (T1) r := Newton's method of active.h from the planted answer. r is the truth if it is next to
 *      the planted answer. If not, the rounding of q has moved the answer, and nothing is known.
 * (T2) dr = G A^-1 H' du. With the residuals of the certificate, |du| <= tol |q| and |D^-1 du| <=
 *      tol |r|: the condition is the smaller one of |G A^-1 H'| |q| / |r| and |G A^-1 H' D|, at
 *      least 1; that of positions is |W G A^-1 H'|. Norms by power iteration.
 * (T3) An answer far from the truth may be near another solution: Newton's method from there shows.
 * (T4) An answer whose error is too large is judged again with contacts closed, and stuck, that are
 *      on the border of their state as far as the tolerance can show.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "active.h"

enum { most_rows = 1300, norm_steps = 8 };

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

/* x (m) := G A^-1 H' D x (OF_R), G A^-1 H' x, or W G A^-1 H' x (OF_U); or the transposed. */
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
  active_solve(s, transposed, s->b);
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
    const real size = active_length(s->x, s->p->m);
    if (!(size > 0)) return norm;
    for (int i = 0; i < s->p->m; i++)
      s->x[i] /= size;
    apply_map(s, of, 0, s->x);
    norm = fmaxl(norm, active_length(s->x, s->p->m));
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
  active_list(s);
  s->singular = !active_factor(s);
  return 1;
}

/* ---- the judge ------------------------------------------------------------------------------- */

/* Fills the errors of r against the answer that s holds, and judges them. moved: how far this
 * answer is from the planted one, relative to it; no farther than the rounding of q may move it. */
static void truth_compare(active *s, const double *r, double tol, int capped, real moved,
                          truth *out) {
  const int d = s->p->d, m = s->p->m;
  real rr = active_length(s->r, m), top = 0, far = 0, sum = 0, uu = 0, du = 0, own = 0;
  for (int i = 0; i < m; i++) {
    const real e = r[i] - s->r[i];
    top = fmaxl(top, fabsl(s->r[i]));
    far = fmaxl(far, fabsl(e));
    sum += e * e;
    own += (real)r[i] * r[i];
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
  out->size = (double)(own == 0 ? 0 : sqrtl(own) / rr);
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
    out->condition = (double)fmaxl(1, fminl(by_r, by_q));
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
  const int found = active_find(s);
  for (int i = 0; i < s->p->m; i++)
    s->x[i] = s->r[i] - r[i];
  const real size = active_length(s->r, s->p->m), step = active_length(s->x, s->p->m);
  *moved = step == 0 ? 0 : size == 0 ? INFINITY : step / size;
  return found;
}

/* (T3) Judges an answer that is not the planted one by the nearest other one: Newton's method
 * starts from it, and from it without reactions that the tolerance hides. */
static void look_beside(active *s, const double *r, double tol, int capped, truth *out) {
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
    if (found == 1) truth_compare(s, r, tol, capped, 0, &other);
    if (found == 1 && other.verdict == TRUTH_HOLDS) other.verdict = TRUTH_OTHER;
    const int better = other.verdict != TRUTH_UNKNOWN && other.error < out->error;
    other.tol = tol;
    if (found == 1 && better && out->verdict != TRUTH_OTHER) *out = other;
    if (found == -1 && out->verdict != TRUTH_OTHER) out->verdict = TRUTH_UNKNOWN;
  }
  free(start);
}

void judge_truth(const problem *p, const double *r, double tol, int capped, truth *out) {
  memset(out, 0, sizeof *out);
  out->tol = tol;
  out->verdict = TRUTH_UNKNOWN;
  if (p->kind != SOLVABLE || p->m > most_rows) return;
  active *s = active_create(p);
  real moved;
  if (start_from(s, p->r, &moved) == 1 && moved <= 1e-3L) {
    truth_compare(s, r, tol, capped, moved, out);
    const int wrong = out->verdict == TRUTH_WRONG_R || out->verdict == TRUTH_WRONG_U;
    if (wrong) look_beside(s, r, tol, capped, out);
  }
  active_destroy(s);
}
