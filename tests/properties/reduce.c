/*
 * reduce.c: shrinks a problem that breaks a rule as far as possible, and writes it as text.
 *
 * Contacts are dropped, pairs of entries of W set to 0, numbers rounded to fewer digits; each
 * change stays if the rule is still broken. A planted answer is kept by q = u - W r after each
 * change, a W that is positive semidefinite stays so, and a proof y is dropped (it is not needed to
 * break the rule).
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "check.h"

typedef struct reducer {
  problem *p, *trial;
  const finding *found;
  double until;
} reducer;

/* Returns 1 if the symmetric W is positive semidefinite up to rounding: Cholesky, largest pivot
 * first. a: scratch, m x m. */
static int is_semidefinite_in(const problem *p, long double *a) {
  const int m = p->m;
  long double first = 0;
  for (int i = 0; i < m * m; i++)
    a[i] = p->W[i];
  for (int i = 0; i < m; i++)
    if (a[i * (m + 1)] > first) first = a[i * (m + 1)];
  for (int step = 0; step < m; step++) {
    int k = -1;
    for (int i = 0; i < m; i++) {
      if (a[i * (m + 1)] < -1e-13L * first) return 0;
      if (a[i * (m + 1)] > 1e-15L * first && (k < 0 || a[i * (m + 1)] > a[k * (m + 1)])) k = i;
    }
    if (k < 0) break;
    const long double pivot = a[k * (m + 1)];
    for (int j = 0; j < m; j++)
      for (int i = 0; i < m; i++)
        if (i != k && j != k) a[i + j * m] -= a[i + k * m] * a[k + j * m] / pivot;
    for (int i = 0; i < m; i++)
      a[i + k * m] = a[k + i * m] = 0;
  }
  for (int i = 0; i < m * m; i++)
    if (fabsl(a[i]) > 1e-12L * first) return 0;
  return 1;
}

static int is_semidefinite(const problem *p) {
  long double *a = problem_alloc((size_t)p->m * (size_t)p->m * sizeof *a);
  const int good = is_semidefinite_in(p, a);
  free(a);
  return good;
}

/* Takes r->trial for r->p if the finding stands; else r->trial is as before. */
static int reducer_keep(reducer *r) {
  if ((double)clock() / CLOCKS_PER_SEC > r->until) return 0;
  problem *t = r->trial;
  if (t->kind == SOLVABLE) plant_q(t);
  const int good = (!t->symmetric || is_semidefinite(t)) && finding_stands(t, r->found);
  problem_copy(good ? r->p : t, good ? t : r->p);
  return good;
}

/* trial := p without candidate c */
static void drop_candidate(const problem *p, int c, problem *t) {
  problem_copy(t, p);
  problem_resize(t, p->d, p->nc - 1);
  for (int j = 0; j < t->m; j++) {
    const int fj = j < p->d * c ? j : j + p->d;
    t->q[j] = p->q[fj];
    t->r[j] = p->r[fj];
    t->u[j] = p->u[fj];
    t->mu[j / p->d] = p->mu[fj / p->d];
    t->y[j / p->d] = p->y[fj / p->d];
    for (int i = 0; i < t->m; i++)
      t->W[i + j * t->m] = p->W[(i < p->d * c ? i : i + p->d) + fj * p->m];
  }
}

static void reduce_candidates(reducer *r) {
  for (int c = r->p->nc - 1; c >= 0 && r->p->nc > 1; c--) {
    drop_candidate(r->p, c, r->trial);
    reducer_keep(r);
  }
  problem_copy(r->trial, r->p);
}

static void reduce_entries(reducer *r) {
  for (int j = 0; j < r->p->m; j++)
    for (int i = 0; i <= j; i++) {
      const int m = r->p->m;
      if (r->p->W[i + j * m] == 0 && r->p->W[j + i * m] == 0) continue;
      r->trial->W[i + j * m] = r->trial->W[j + i * m] = 0;
      reducer_keep(r);
    }
  for (int i = 0; i < r->p->m; i++) {
    double *x = r->p->kind == SOLVABLE ? r->trial->u : r->trial->q;
    if (x[i] == 0) continue;
    x[i] = 0;
    if (r->p->kind != SOLVABLE || r->trial->r[r->p->d * (i / r->p->d)] == 0 ||
        r->p->mu[i / r->p->d] == 0)
      reducer_keep(r);
    problem_copy(r->trial, r->p);
  }
}

/* x to `digits` decimal digits */
static double to_digits(double x, int digits) {
  char text[40];
  snprintf(text, sizeof text, "%.*e", digits - 1, x);
  return strtod(text, NULL);
}

/* W to fewer digits */
static int reduce_matrix(reducer *r, int digits) {
  for (int k = 0; k < r->p->m * r->p->m; k++)
    r->trial->W[k] = to_digits(r->trial->W[k], digits);
  return reducer_keep(r);
}

/* The other numbers to fewer digits; a planted slip keeps r_t on the cone (d = 3 keeps r, u and
 * mu). */
static int reduce_vectors(reducer *r, int digits) {
  problem *t = r->trial;
  for (int c = 0; c < t->nc; c++) {
    double *push = t->r + t->d * c, *u = t->u + t->d * c, most = t->mu[c] * push[0];
    const int edge = t->d == 2 && fabs(push[1]) >= most;
    for (int k = 0; k < t->d; k++)
      t->q[t->d * c + k] = to_digits(t->q[t->d * c + k], digits);
    if (t->d != 2 || isinf(t->mu[c])) continue;
    t->mu[c] = to_digits(t->mu[c], digits);
    for (int k = 0; k < 2; k++) {
      push[k] = to_digits(push[k], digits);
      u[k] = to_digits(u[k], digits);
    }
    most = t->mu[c] * push[0];
    if (edge || fabs(push[1]) > most) push[1] = copysign(most, push[1]);
  }
  return reducer_keep(r);
}

void reduce_problem(problem *p, const finding *found, double seconds) {
  static problem trial;
  reducer r = {p, &trial, found, (double)clock() / CLOCKS_PER_SEC + seconds};
  problem_copy(&trial, p);
  for (int before = p->nc + 1; p->nc < before;) {
    before = p->nc;
    reduce_candidates(&r);
  }
  if (p->kind == SURE) return; /* other changes may lose what makes it sure */
  reduce_entries(&r);
  for (int digits = 1; digits < 12; digits += digits < 4 ? 1 : 2)
    if (reduce_matrix(&r, digits)) break;
  for (int digits = 1; digits < 12; digits += digits < 4 ? 1 : 2)
    if (reduce_vectors(&r, digits)) break;
  reduce_entries(&r);
}

/* ---- text ------------------------------------------------------------------------------------ */

/* x with as few digits as give it back */
static void write_number(FILE *out, double x) {
  char text[40];
  if (fabs(x) < 1e6 && x == nearbyint(x)) {
    fprintf(out, " %.0f", x);
    return;
  }
  for (int digits = 1; digits <= 17; digits++) {
    snprintf(text, sizeof text, "%.*g", digits, x);
    if (strtod(text, NULL) == x) break;
  }
  fprintf(out, " %s", text);
}

static void write_numbers(FILE *out, const char *key, const double *x, int count, int stride) {
  fprintf(out, "%-9s", key);
  for (int i = 0; i < count; i++)
    write_number(out, x[i * stride]);
  fprintf(out, "\n");
}

int write_problem(const char *path, const problem *p, const finding *found, const char *title,
                  const char *source) {
  char first[200], second[200];
  FILE *out = fopen(path, "w");
  if (!out) return 0;
  describe_run(&found->first, first);
  describe_run(&found->second, second);
  fprintf(out, "title     %s\nshows     %s: %s%s%s\nsource    %s\n\ncontact   %d %d\nW\n", title,
          rule_text[found->rule], first, found->pair ? "; and " : "", found->pair ? second : "",
          source, p->d, p->nc);
  for (int i = 0; i < p->m; i++)
    write_numbers(out, "", p->W + i, p->m, p->m);
  write_numbers(out, "q", p->q, p->m, 1);
  write_numbers(out, "mu", p->mu, p->nc, 1);
  fprintf(out, "\n");
  if (p->kind == SOLVABLE)
    fprintf(out, "# planted%s; there may be others\n", p->exact ? ", exact" : " to rounding");
  if (p->kind == SOLVABLE) write_numbers(out, "solution", p->r, p->m, 1);
  if (p->kind == UNSOLVABLE && farkas_holds(p, p->y)) {
    write_numbers(out, "# proof:", p->y, p->nc, 1);
    fprintf(out, "none\n");
  } else if (p->kind == SURE) {
    fprintf(out, "# W is positive definite: there are solutions\n");
  } else if (p->kind != SOLVABLE) {
    fprintf(out, "# not known: the line none, or the solutions\n");
  }
  return fclose(out) == 0;
}
