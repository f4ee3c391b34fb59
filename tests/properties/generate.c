/*
 * generate.c: contact problems whose answer, or whose lack of one, is known in advance.
 *
 *   SOLVABLE    states first (free, stick, slip, and the two edges: grazing, stick on the cone),
 *               then r and u that meet the law, then W, then q = u - W r
 *   UNSOLVABLE  y >= 0 on the normals with y' W_n = 0 and q_n.y < 0, so that y'(W r + q)_n < 0
 *               whatever r is
 *   SURE        y' B_n = 0 and q_n.y < 0 as above, but W = B B' + 2^-k I: definite, nearly singular
 *   BORDERLINE  any q; or one of the two above, moved by a power of two of its size
 *
 * Classes with short numbers (whole numbers and few bits) are exact: rounding does not change the
 * statement.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "generate.h"

/* ---- memory ---------------------------------------------------------------------------------- */

void *problem_alloc(size_t size) {
  void *out = calloc(size ? size : 1, 1);
  if (out) return out;
  fprintf(stderr, "properties: no memory\n");
  exit(2);
}

void problem_resize(problem *p, int d, int nc) {
  free(p->W);
  p->d = d, p->nc = nc, p->m = d * nc;
  p->W = problem_alloc((size_t)p->m * (size_t)p->m * sizeof *p->W);
}

void problem_copy(problem *to, const problem *from) {
  double *W = to->W;
  if (to == from) return;
  *to = *from;
  to->W = W;
  problem_resize(to, from->d, from->nc);
  memcpy(to->W, from->W, (size_t)from->m * (size_t)from->m * sizeof *to->W);
}

int problem_is_bonded(const problem *p) {
  for (int c = 0; c < p->nc; c++)
    if (isinf(p->mu[c])) return 1;
  return 0;
}

/* ---- classes --------------------------------------------------------------------------------- */

static const recipe recipes[CLASSES] = {
    {"integers", SOLVABLE, FACTOR, 1, 0, 3, 0, 0, 61},
    {"dyadic", SOLVABLE, FACTOR, 4, 0, 2, 1, 2, 61},
    {"definite", SOLVABLE, FACTOR, 0, 1, 1, 1, 0, 61},
    {"rank", SOLVABLE, FACTOR, 0, 0, 1, 1, 0, 61},
    {"condition", SOLVABLE, DIAGONAL, 0, 1, 1, 1, 0, 61},
    {"chain", SOLVABLE, CHAIN, 0, 0, 1, 1, 0, 61},
    {"friction", SOLVABLE, FACTOR, 0, 0, 8, 1, 0, 61},
    {"scales", SOLVABLE, FACTOR, 0, 0, 1, 1, 6, 61},
    {"ratio", SOLVABLE, FACTOR, 0, 0, 1, 6, 0, 61},
    {"self-stress", SOLVABLE, STRESS, 0, 0, 1, 0, 0, 61},
    {"zero-blocks", SOLVABLE, NO_BLOCKS, 0, 0, 1, 1, 0, 12},
    {"slight", SOLVABLE, SLIGHT, 0, 0, 2, 1, 0, 55},
    {"skew", SOLVABLE, SKEW, 0, 0, 1, 1, 0, 55},
    {"product", SOLVABLE, PRODUCT, 4, 0, 2, 1, 0, 6},
    {"mixed", SOLVABLE, ANY_FORM, 0, 0, 8, 6, 6, 20},
    {"unsolvable", UNSOLVABLE, FACTOR, 1, 0, 3, 0, 0, 18},
    {"unsolvable-rounded", UNSOLVABLE, FACTOR, 0, 0, 2, 0, 2, 8},
    {"unsolvable-product", UNSOLVABLE, PRODUCT, 4, 0, 2, 0, 0, 8},
    {"borderline", BORDERLINE, FACTOR, 4, 0, 2, 0, 0, 18},
    {"random", BORDERLINE, ANY_FORM, 0, 0, 3, 1, 1, 20},
    {"far", SURE, FACTOR, 1, 0, 3, 0, 0, 10},
    {"open", SOLVABLE, OPEN, 0, 0, 1, 1, 0, 25},
    {"springs", SOLVABLE, SPRINGS, 1, 0, 1, 0, 0, 25},
    {"aspect", SOLVABLE, ASPECT, 0, 0, 1, 1, 0, 25},
    {"masses", SOLVABLE, MASSES, 0, 0, 1, 1, 0, 25},
    {"bonded", SOLVABLE, BONDED, 0, 0, 1, 1, 0, 25},
    {"heavy", SOLVABLE, HEAVY, 0, 0, 1, 1, 0, 30},
    {"sizes", SOLVABLE, SIZES, 0, 0, 1, 1, 0, 5},
};

const char *const class_name[CLASSES] = {"integers",
                                         "dyadic",
                                         "definite",
                                         "rank",
                                         "condition",
                                         "chain",
                                         "friction",
                                         "scales",
                                         "ratio",
                                         "self-stress",
                                         "zero-blocks",
                                         "slight",
                                         "skew",
                                         "product",
                                         "mixed",
                                         "unsolvable",
                                         "unsolvable-rounded",
                                         "unsolvable-product",
                                         "borderline",
                                         "random",
                                         "far",
                                         "open",
                                         "springs",
                                         "aspect",
                                         "masses",
                                         "bonded",
                                         "heavy",
                                         "sizes"};

int class_is_dear(int class) {
  return recipes[class].share < 10;
}

int class_of_seed(uint64_t seed) {
  dice g = {seed ^ 0x632be59bd9b4e019u};
  int luck = dice_below(&g, 1000), class = 0;
  while (class < CLASSES - 1 && luck >= recipes[class].share)
    luck -= recipes[class ++].share;
  return class;
}

double draw_number(dice *g, const recipe *of) {
  if (of->bits == 0) return dice_normal(g);
  if (of->bits == 1) return dice_below(g, 7) - 3;
  return (dice_below(g, 65) - 32) / 16.0;
}

/* 10^(-range .. range), a power of two for short numbers */
static double draw_scale(dice *g, const recipe *of, double range) {
  const double scale = dice_power(g, -range, range);
  return of->bits ? exp2(nearbyint(log2(scale))) : scale;
}

/* ---- the answer ------------------------------------------------------------------------------ */

/* unit (2) := a direction of the tangent plane; with short numbers whole multiples of 1 / *whole.
 * */
static void draw_direction(dice *g, int d, int bits, double *unit, int *whole) {
  static const int triple[4][3] = {{3, 4, 5}, {5, 12, 13}, {1, 0, 1}, {0, 1, 1}};
  *whole = 1;
  unit[0] = dice_sign(g);
  unit[1] = 0;
  if (d == 2) return;
  if (bits) {
    const int *t = triple[dice_below(g, 4)];
    *whole = t[2];
    unit[0] = dice_sign(g) * t[0];
    unit[1] = dice_sign(g) * t[1];
    return;
  }
  const double angle = dice_between(g, 0, 6.283185307179586);
  unit[0] = cos(angle);
  unit[1] = sin(angle);
}

void plant_candidate(dice *g, const recipe *of, problem *p, int c, int state, double ratio) {
  double *r = p->r + p->d * c, *u = p->u + p->d * c, unit[2], push = 1 + dice_below(g, 4);
  int whole;
  draw_direction(g, p->d, of->bits, unit, &whole);
  if (!of->bits) push = dice_power(g, -1, 1);
  const double slide = of->bits ? 1 + dice_below(g, 4) : dice_power(g, -1, 1);
  const double part = state != 1 ? 1 : of->bits ? dice_below(g, 4) / 4.0 : dice_between(g, 0, 1);
  for (int k = 0; k < p->d; k++)
    r[k] = u[k] = 0;
  if (state == 0) {
    u[0] = ratio * slide;
    for (int k = 1; k < p->d; k++)
      u[k] = ratio * draw_number(g, of);
    return;
  }
  if (state == 3) return;
  r[0] = push * whole;
  for (int k = 1; k < p->d; k++) {
    r[k] = part * push * p->mu[c] * unit[k - 1];
    if (state == 2) u[k] = -ratio * slide * unit[k - 1];
  }
}

static void plant_answer(dice *g, const recipe *of, problem *p) {
  const double free = dice_between(g, 0, 1), slip = dice_between(g, 0, 1);
  const double edges = dice_below(g, 3) ? 0 : dice_between(g, 0, 0.5);
  const double ratio = draw_scale(g, of, of->ratio);
  for (int c = 0; c < p->nc; c++) {
    int state = dice_between(g, 0, 1) < free * 0.8 ? 0 : dice_between(g, 0, 1) < slip ? 2 : 1;
    if (dice_between(g, 0, 1) < edges) state = 3 + dice_below(g, 2);
    plant_candidate(g, of, p, c, state, ratio);
  }
}

static void draw_friction(dice *g, const recipe *of, problem *p) {
  const int way = dice_below(g, 4);
  const double one = of->bits ? dice_below(g, (int)(8 * of->mu)) / 8.0 : dice_between(g, 0, of->mu);
  for (int c = 0; c < p->nc; c++) {
    p->mu[c] = one; /* ways 0, 1 */
    if (way > 1 && of->bits) p->mu[c] = dice_below(g, (int)(8 * of->mu) + 1) / 8.0;
    if (way > 1 && !of->bits) p->mu[c] = dice_between(g, 0, of->mu);
    if (way == 3 && dice_below(g, 3) == 0) p->mu[c] = 0;
  }
}

/* ---- W --------------------------------------------------------------------------------------- */

void add_product(problem *p, double weight, const factor *f, const double *C) {
  for (int j = 0; j < p->m; j++)
    for (int i = 0; i < p->m; i++) {
      double sum = 0;
      for (int k = 0; k < f->columns; k++)
        sum += f->B[i + k * p->m] * C[j + k * p->m];
      p->W[i + j * p->m] += weight * sum;
    }
}

void draw_factor(dice *g, const recipe *of, const problem *p, double *B, int columns) {
  for (int k = 0; k < columns * p->m; k++)
    B[k] = draw_number(g, of);
}

/* Columns of B := orthonormal, times the roots of 1 down to the inverse condition number. */
static void shape_spectrum(dice *g, const problem *p, factor *f) {
  const double worst = dice_between(g, 0, 12);
  for (int k = 0; k < f->columns; k++) {
    double *b = f->B + k * p->m, norm = 0;
    for (int twice = 0; twice < 2; twice++)
      for (int j = 0; j < k; j++) {
        const double *a = f->C + j * p->m;
        double dot = 0;
        for (int i = 0; i < p->m; i++)
          dot += a[i] * b[i];
        for (int i = 0; i < p->m; i++)
          b[i] -= dot * a[i];
      }
    for (int i = 0; i < p->m; i++)
      norm += b[i] * b[i];
    for (int i = 0; i < p->m; i++)
      f->C[i + k * p->m] = b[i] / sqrt(norm);
  }
  for (int k = 0; k < f->columns; k++)
    for (int i = 0; i < p->m; i++)
      f->B[i + k * p->m] = f->C[i + k * p->m] * pow(10, -worst / 2 * k / fmax(1, f->columns - 1));
}

/* B' r := left B' r, so that the reactions press against each other and W r is small. */
static void shape_stress(dice *g, const problem *p, factor *f) {
  const double left = dice_power(g, -6, 0);
  double rr = 0;
  for (int i = 0; i < p->m; i++)
    rr += p->r[i] * p->r[i];
  if (rr == 0) return;
  for (int k = 0; k < f->columns; k++) {
    double dot = 0;
    for (int i = 0; i < p->m; i++)
      dot += p->r[i] * f->B[i + k * p->m];
    for (int i = 0; i < p->m; i++)
      f->B[i + k * p->m] -= (1 - left) * dot / rr * p->r[i];
  }
}

/* Rows of B of some candidates := 0 (the rows of C too, one time in two). */
static void shape_zero_blocks(dice *g, problem *p, factor *f) {
  const int both = p->symmetric || dice_below(g, 2);
  for (int c = 0; c < p->nc; c++) {
    if (dice_below(g, 4)) continue;
    for (int k = 0; k < f->columns; k++)
      for (int i = p->d * c; i < p->d * (c + 1); i++) {
        f->B[i + k * p->m] = 0;
        if (both) f->C[i + k * p->m] = 0;
      }
  }
}

static void shape_chain(const problem *p, factor *f) {
  for (int k = 0; k < f->columns; k++)
    for (int i = 0; i < p->m; i++) {
      const int far = i / p->d - k / p->d;
      if (far != 0 && far != 1) f->B[i + k * p->m] = 0;
    }
}

/* y'B_n := 0: the normal row of the last candidate with y = 1 balances the others. */
static void shape_farkas(dice *g, const recipe *of, problem *p, factor *f) {
  const int last = dice_below(g, p->nc);
  const double some = dice_between(g, 0.2, 1);
  for (int c = 0; c < p->nc; c++)
    p->y[c] = c == last ? 1 : dice_between(g, 0, 1) > some ? 0 : 1 + dice_below(g, 3);
  for (int k = 0; k < f->columns; k++) {
    double *b = f->B + k * p->m, sum = 0;
    for (int c = 0; c < p->nc; c++)
      if (c != last) sum += p->y[c] * b[p->d * c];
    b[p->d * last] = -sum;
  }
  double dot = 0;
  for (int i = 0; i < p->m; i++)
    p->q[i] = 4 * draw_number(g, of);
  for (int c = 0; c < p->nc; c++)
    if (c != last) dot += p->y[c] * p->q[p->d * c];
  p->q[p->d * last] = -dot - (of->bits ? 1 + dice_below(g, 8) : dice_power(g, -3, 1));
}

static form draw_form(dice *g, const recipe *of) {
  return of->form == ANY_FORM ? (form)dice_below(g, ANY_FORM) : of->form;
}

/* W += 2^-k I, with a k that rounds no diagonal entry: a semidefinite W is definite after it. */
static void shift_diagonal(dice *g, problem *p) {
  double shift = exp2(-10 - dice_below(g, 31));
  for (int i = 0; i < p->m; i++)
    while (p->W[i * (p->m + 1)] + shift - p->W[i * (p->m + 1)] != shift)
      shift *= 2;
  for (int i = 0; i < p->m; i++)
    p->W[i * (p->m + 1)] += shift;
}

static void draw_matrix(dice *g, const recipe *of, problem *p) {
  const size_t square = (size_t)p->m * (size_t)p->m * sizeof(double);
  factor f = {0, problem_alloc(square), problem_alloc(square)};
  const form way = draw_form(g, of);
  const int full = of->full || way == DIAGONAL || way == CHAIN;
  f.columns = full ? p->m : (int)ceil(p->m * dice_between(g, 0.15, 1));
  draw_factor(g, of, p, f.B, f.columns);
  p->symmetric = way <= STRESS || (way == NO_BLOCKS && dice_below(g, 2));
  if (way == DIAGONAL) shape_spectrum(g, p, &f);
  if (way == CHAIN) shape_chain(p, &f);
  if (way == STRESS) shape_stress(g, p, &f);
  if (p->symmetric || way == SLIGHT || way == SKEW)
    memcpy(f.C, f.B, square);
  else
    draw_factor(g, of, p, f.C, f.columns);
  if (way == NO_BLOCKS) shape_zero_blocks(g, p, &f);
  if (of->kind == UNSOLVABLE || of->kind == SURE) shape_farkas(g, of, p, &f);
  add_product(p, way == SKEW ? dice_power(g, -6, 0) : 1, &f,
              p->symmetric && way != NO_BLOCKS ? f.B : f.C);
  if (of->kind == SURE) shift_diagonal(g, p);
  free(f.B);
  free(f.C);
  const double part = way == SLIGHT ? dice_power(g, -12, -1) : way == SKEW ? 1 : 0;
  for (int j = 0; part > 0 && j < p->m; j++)
    for (int i = 0; i < j; i++) {
      const double a = part * dice_normal(g);
      p->W[i + j * p->m] += a;
      p->W[j + i * p->m] -= a;
    }
}

/* Gives each candidate a unit of its own: W_ij s_i s_j, u_i s_i (q of an unsolvable one too), r_i
 * / s_i. */
static void draw_scales(dice *g, const recipe *of, problem *p) {
  double s[NC_MAX] = {0};
  for (int c = 0; c < p->nc; c++) {
    s[c] = draw_scale(g, of, of->scales / 2);
    p->y[c] /= s[c];
  }
  const int forces =
      dice_below(g, 4) > 0; /* else W alone: reactions of one size on all candidates */
  for (int i = 0; i < p->m; i++) {
    for (int j = 0; j < p->m; j++)
      p->W[i + j * p->m] *= s[i / p->d] * s[j / p->d];
    p->q[i] *= s[i / p->d];
    p->u[i] *= s[i / p->d];
    if (forces) p->r[i] /= s[i / p->d];
  }
}

/* ---- q --------------------------------------------------------------------------------------- */

/* Returns the sign of a b - c d without rounding. */
static int sign_of(double a, double b, double c, double d) {
  exact sum;
  exact_clear(&sum);
  exact_add(&sum, a, b, 1);
  exact_add(&sum, c, -d, 1);
  return exact_sign(&sum);
}

/* Returns 1 if u and r of candidate c meet the law without rounding. */
static int law_holds(const problem *p, int c) {
  const double *r = p->r + p->d * c, *u = p->u + p->d * c, most = p->mu[c] * r[0];
  const double rt = p->d > 1 ? r[1] : 0, ut = p->d > 1 ? u[1] : 0;
  const double rs = p->d == 3 ? r[2] : 0, us = p->d == 3 ? u[2] : 0;
  exact edge; /* (mu r_n)^2 - |r_t|^2 */
  if (!(u[0] >= 0 && r[0] >= 0 && (u[0] == 0 || r[0] == 0))) return 0;
  if (isinf(p->mu[c])) return r[0] > 0 ? ut == 0 && us == 0 : rt == 0 && rs == 0;
  if (sign_of(p->mu[c], r[0], most, 1) != 0) return 0;
  exact_clear(&edge);
  exact_add(&edge, most, most, 1);
  exact_add(&edge, rt, -rt, 1);
  exact_add(&edge, rs, -rs, 1);
  const int inside = exact_sign(&edge);
  if (inside < 0 || (inside > 0 && (ut != 0 || us != 0))) return 0;
  if (ut == 0 && us == 0) return 1;
  return sign_of(ut, rs, us, rt) == 0 && sign_of(ut, rt, us, -rs) <= 0;
}

/* sum := u_i - q_i - (W r)_i */
static void sum_row(const problem *p, int i, double q, exact *sum) {
  exact_clear(sum);
  exact_add(sum, p->u[i], 1, 1);
  exact_add(sum, q, -1, 1);
  for (size_t j = 0; j < (size_t)p->m; j++)
    exact_add(sum, p->W[(size_t)i + j * (size_t)p->m], -p->r[j], 1);
}

void plant_q(problem *p) {
  p->exact = 1;
  for (int i = 0; i < p->m; i++) {
    long double sum = p->u[i], size = fabsl(sum);
    exact rest;
    for (size_t j = 0; j < (size_t)p->m; j++) {
      const long double t = (long double)p->W[(size_t)i + j * (size_t)p->m] * p->r[j];
      sum -= t;
      size += fabsl(t);
    }
    p->q[i] = (double)sum;
    if (p->m * LDBL_EPSILON * size > DBL_EPSILON / 8 * fabsl(sum)) {
      sum_row(p, i, 0, &rest);
      p->q[i] = exact_round(&rest);
    }
    if (!p->exact) continue;
    sum_row(p, i, p->q[i], &rest);
    p->exact = exact_sign(&rest) == 0 && law_holds(p, i / p->d);
  }
}

/* BORDERLINE: a planted answer, exactly on the edge or moved off it by a power of two; or any q. */
static void draw_border(dice *g, const recipe *of, problem *p) {
  const int way = dice_below(g, 3);
  double most = 0;
  plant_q(p);
  p->exact = 0;
  for (int i = 0; i < p->m; i++)
    most = fmax(most, fabs(p->q[i]));
  const double far = ldexp(most, -10 - dice_below(g, 50));
  for (int i = 0; i < p->m; i++) {
    if (way == 0) p->q[i] += far * draw_number(g, of);
    if (way == 1) p->q[i] = 4 * draw_number(g, of);
    if (way == 2 && i % p->d == 0) p->q[i] -= far;
  }
}

/* Size: 1 to 8 mostly, some to 30, few of 60. */
static int draw_candidates(dice *g) {
  const int luck = dice_below(g, 1000);
  return luck < 880 ? 1 + dice_below(g, 8) : luck < 997 ? 9 + dice_below(g, 22) : 60;
}

void generate(int class, uint64_t seed, problem *p) {
  const recipe *of = &recipes[class];
  dice g = {seed * 1000003u + (uint64_t) class * 7919u};
  double *W = p->W;
  memset(p, 0, sizeof *p);
  p->W = W;
  (void)dice_bits(&g);
  p->kind = of->kind;
  if (of->form > ANY_FORM) {
    draw_extreme(&g, of, p);
    plant_q(p);
    return;
  }
  int nc = draw_candidates(&g);
  const int shaped = of->kind == UNSOLVABLE || of->kind == SURE;
  if (shaped && nc == 1) nc = 2;
  problem_resize(p, shaped ? 2 + (dice_below(&g, 4) == 0) : 2 + dice_below(&g, 2), nc);
  draw_friction(&g, of, p);
  if (!shaped) plant_answer(&g, of, p);
  draw_matrix(&g, of, p);
  draw_scales(&g, of, p);
  if (of->kind == SOLVABLE) plant_q(p);
  if (of->kind == BORDERLINE) draw_border(&g, of, p);
}
