/*
 * extremes.c: problems with numbers of very different sizes, as in users' models; uniform random
 * numbers do not contain them.
 *
 *   OPEN     contacts that are open, their gaps 1 to 1e15 and their W_cc 1e-12 to 1e12 of others'
 *   SPRINGS  W = C C' + 2^k B B', B the rigid motions of a body on soft springs, k = 13 .. 46
 *   ASPECT   W = S V S, S 10^(-5 .. 5) on tangents: W_tt / W_nn up to 1e10 and down to 1e-10
 *   MASSES   W = H' M^-1 H of stacked bodies whose masses are up to 1e12 apart
 *   BONDED   friction up to 1e9, and infinite
 *   HEAVY    a reaction 1e2 to 1e12 times the others
 *   SIZES    W = B B' + D, B of few columns, as many contacts or rows as a limit of the library
 *
 * The planted r, u and the stored W are known; plant_q makes q of them without rounding.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "generate.h"

/* W += B B' with B of this many columns and numbers of the recipe's kind */
static void add_random(dice *g, const recipe *of, problem *p, int columns) {
  factor f = {columns, problem_alloc((size_t)p->m * (size_t)columns * sizeof(double)), NULL};
  draw_factor(g, of, p, f.B, columns);
  add_product(p, 1, &f, f.B);
  free(f.B);
}

/* Full rank mostly, else from half of it. */
static int draw_columns(dice *g, const problem *p) {
  return dice_below(g, 4) ? p->m + 2 : (p->m + 1) / 2 + dice_below(g, (p->m + 1) / 2);
}

static void draw_frictions(dice *g, const recipe *of, problem *p) {
  const int none = dice_below(g, 6) == 0, one = dice_below(g, 2);
  const double mu = of->bits ? (1 + dice_below(g, 8)) / 8.0 : dice_between(g, 0.05, of->mu);
  for (int c = 0; c < p->nc && p->d > 1; c++)
    p->mu[c] = none ? 0 : one || of->bits ? mu : dice_between(g, 0.05, of->mu);
}

/* States free, stick or slip; a third of all is free at most. */
static void plant_states(dice *g, const recipe *of, problem *p, double ratio) {
  const double free = dice_between(g, 0, 1) / 3, slip = dice_between(g, 0, 1);
  for (int c = 0; c < p->nc; c++) {
    const double luck = dice_between(g, 0, 1);
    plant_candidate(g, of, p, c, luck < free ? 0 : luck < free + slip * (1 - free) ? 2 : 1, ratio);
  }
}

/* Row and column of entry i of W, and u_i, times s; r_i over s: another unit. */
static void scale_entry(problem *p, int i, double s, int answer) {
  const size_t m = (size_t)p->m;
  for (size_t j = 0; j < m; j++) {
    p->W[(size_t)i + j * m] *= s;
    p->W[j + (size_t)i * m] *= s;
  }
  if (answer) p->r[i] /= s;
  if (answer) p->u[i] *= s;
}

static void draw_open(dice *g, const recipe *of, problem *p) {
  const double far = dice_between(g, 0, 15), soft = dice_between(g, -6, 6);
  problem_resize(p, 1 + dice_below(g, 3), 2 + dice_below(g, dice_below(g, 8) ? 7 : 25));
  draw_frictions(g, of, p);
  plant_states(g, of, p, dice_power(g, -1, 1));
  add_random(g, of, p, draw_columns(g, p));
  const int open = dice_below(g, p->nc), closed = (open + 1 + dice_below(g, p->nc - 1)) % p->nc;
  if (p->r[p->d * closed] == 0) plant_candidate(g, of, p, closed, 1, 1);
  for (int c = 0; c < p->nc; c++) {
    if (c != open && p->r[p->d * c] != 0) continue;
    plant_candidate(g, of, p, c, 0, pow(10, far * dice_between(g, 0.5, 1)));
    const double s = pow(10, soft * dice_between(g, 0.5, 1));
    for (int k = 0; k < p->d; k++)
      scale_entry(p, p->d * c + k, s, 0);
  }
}

/* Rigid motions of the points of a flat foot, in the candidate's order (n, t) or (n, t, s). */
static void draw_springs(dice *g, const recipe *of, problem *p) {
  problem_resize(p, 2 + dice_below(g, 2), 2 + dice_below(g, 5));
  draw_frictions(g, of, p);
  plant_states(g, of, p, 1);
  add_random(g, of, p, p->m + 1);
  const int m = p->m, motions = 3 * (p->d - 1), height = dice_below(g, 3);
  factor f = {motions, problem_alloc((size_t)m * (size_t)motions * sizeof(double)), NULL};
  for (int c = 0; c < p->nc; c++) {
    const double x = dice_below(g, 9) - 4, y = dice_below(g, 9) - 4;
    double *n = f.B + p->d * c, *t = n + 1, *s = n + 2;
    n[0] = t[m] = 1;
    n[2 * m] = x;
    t[2 * m] = -height;
    if (p->d == 2) continue;
    s[3 * m] = 1;
    n[4 * m] = y;
    s[4 * m] = -height;
    t[5 * m] = y;
    s[5 * m] = -x;
  }
  add_product(p, exp2(13 + dice_below(g, 34)), &f, f.B);
  free(f.B);
}

/* Of half of the problems the friction stays, of the others the cone in the units of S. */
static void draw_aspect(dice *g, const recipe *of, problem *p) {
  const int one = dice_below(g, 2), plain = dice_below(g, 2);
  double e = dice_between(g, -5, 5);
  problem_resize(p, 2 + dice_below(g, 2), 1 + dice_below(g, 8));
  draw_frictions(g, of, p);
  plant_states(g, of, p, dice_power(g, -of->ratio, of->ratio));
  add_random(g, of, p, draw_columns(g, p));
  for (int c = 0; c < p->nc; c++) {
    if (!one) e = dice_between(g, -5, 5);
    for (int k = 1; k < p->d; k++)
      scale_entry(p, p->d * c + k, pow(10, e), !plain);
    if (!plain) p->mu[c] *= pow(10, -e);
  }
}

/* H of candidate c: body[0] above, body[1] below (-1: the ground), R its frame in the columns. */
typedef struct joint {
  int body[2];
  double R[9];
} joint;

static void draw_frame(dice *g, int d, int turned, double *R) {
  const double a = turned ? dice_between(g, -1, 1) : 0, b = turned ? dice_between(g, -1, 1) : 0;
  const double two[4] = {cos(a), sin(a), -sin(a), cos(a)};
  const double three[9] = {cos(a) * cos(b),  sin(a) * cos(b),  sin(b), -sin(a), cos(a), 0,
                           -cos(a) * sin(b), -sin(a) * sin(b), cos(b)};
  memcpy(R, d == 2 ? two : three, (size_t)(d * d) * sizeof *R);
}

/* masses := powers of two, or of ten; grows: up the stack, down, in no order, or the last alone */
static void draw_masses(dice *g, int bodies, double *mass) {
  const int way = dice_below(g, 4), dyadic = dice_below(g, 2);
  const double range = dice_between(g, 0, 12);
  for (int b = 0; b < bodies; b++) {
    const double at = bodies > 1 ? (double)b / (bodies - 1) : 1;
    const double part = way == 0   ? at
                        : way == 1 ? 1 - at
                        : way == 2 ? dice_between(g, 0, 1)
                                   : b == bodies - 1;
    mass[b] = pow(10, range * part);
    if (dyadic) mass[b] = exp2(nearbyint(log2(mass[b])));
  }
}

static void draw_stack(dice *g, const recipe *of, problem *p) {
  joint at[40];
  double mass[20], above[20] = {0};
  const int bodies = 1 + dice_below(g, 12), more = dice_below(g, 3) ? 0 : dice_below(g, bodies + 1);
  const int turned = dice_below(g, 2), loads = dice_below(g, 3) > 0;
  problem_resize(p, 2 + dice_below(g, 2), bodies + more);
  draw_masses(g, bodies, mass);
  for (int c = 0; c < p->nc; c++) {
    const int up = c < bodies ? c : dice_below(g, bodies);
    at[c].body[0] = up;
    at[c].body[1] =
        (c < bodies && dice_below(g, 4)) || up == 0 ? up - 1 : dice_below(g, up + 1) - 1;
    draw_frame(g, p->d, turned, at[c].R);
  }
  for (int b = bodies - 1; b >= 0; b--) {
    above[b] += mass[b];
    if (at[b].body[1] >= 0) above[at[b].body[1]] += above[b];
  }
  draw_frictions(g, of, p);
  plant_states(g, of, p, dice_power(g, -2, 2));
  for (int i = 0; loads && i < p->m; i++)
    p->r[i] *= above[at[i / p->d].body[0]];
  for (int j = 0; j < p->m; j++)
    for (int i = 0; i < p->m; i++) {
      const joint *a = &at[i / p->d], *b = &at[j / p->d];
      double dot = 0;
      for (int k = 0; k < p->d; k++)
        dot += a->R[k + p->d * (i % p->d)] * b->R[k + p->d * (j % p->d)];
      for (int k = 0; k < 4; k++) {
        const int same = a->body[k & 1] == b->body[k >> 1] && a->body[k & 1] >= 0;
        if (same) p->W[i + j * p->m] += ((k & 1) == k >> 1 ? 1 : -1) * (dot / mass[a->body[k & 1]]);
      }
    }
}

/* A slip with a large friction: one time in four, with r_n or with r_t of the usual size. */
static void plant_bond(dice *g, const recipe *of, problem *p, int c) {
  double *r = p->r + p->d * c;
  const double mu = p->mu[c];
  const int slips = mu <= 8 ? dice_below(g, 3) == 0 : isfinite(mu) && dice_below(g, 16) == 0;
  const int state = dice_below(g, 5) == 0 ? 0 : slips ? 2 : 1;
  p->mu[c] = fmin(mu, 3);
  plant_candidate(g, of, p, c, state, 1);
  p->mu[c] = mu;
  if (mu <= 3) return;
  const double long_drag = dice_below(g, 2) ? dice_power(g, 0, fmin(3, log10(mu / 3))) : 1;
  for (int k = 1; k < p->d; k++)
    r[k] *= state == 2 ? mu / 3 : long_drag;
  for (int k = 0; k < p->d && state == 2 && dice_below(g, 2); k++)
    r[k] /= mu;
}

static void draw_bonded(dice *g, const recipe *of, problem *p) {
  problem_resize(p, 2 + dice_below(g, 2), 1 + dice_below(g, 10));
  const int way = dice_below(g, 4); /* all infinite, all large, mixed */
  for (int c = 0; c < p->nc; c++) {
    const int sort = way == 0 ? 0 : way == 1 ? 1 : dice_below(g, 3);
    p->mu[c] = sort == 0 ? INFINITY : sort == 1 ? dice_power(g, 0, 9) : dice_between(g, 0, 1);
    plant_bond(g, of, p, c);
  }
  add_random(g, of, p, draw_columns(g, p));
}

static void draw_heavy(dice *g, const recipe *of, problem *p) {
  problem_resize(p, 1 + dice_below(g, 3), 3 + dice_below(g, 18));
  draw_frictions(g, of, p);
  plant_states(g, of, p, dice_power(g, -1, 1));
  add_random(g, of, p, draw_columns(g, p));
  const int heavy = dice_below(g, p->nc), stiff = dice_below(g, 2);
  const double times = dice_power(g, 2, 12);
  if (p->r[p->d * heavy] == 0) plant_candidate(g, of, p, heavy, 1, 1);
  for (int k = 0; k < p->d; k++) {
    if (stiff) scale_entry(p, p->d * heavy + k, 1 / sqrt(times), 0);
    p->r[p->d * heavy + k] *= times;
  }
}

/* Candidates or rows on both sides of a limit, the smaller limits more often. */
static void draw_size(dice *g, problem *p) {
  static const int limit[] = {8, 20, 30, 60, 71, 100, 150, 250, 300, 400, 1000};
  const int luck = dice_below(g, 1000), d = 2 + dice_below(g, 2), side = dice_below(g, 3) - 1;
  const int k = luck < 940   ? dice_below(g, 6)
                : luck < 990 ? 6 + dice_below(g, 3)
                : luck < 998 ? 9
                             : 10;
  const int rows = dice_below(g, 2), want = limit[k] + side;
  problem_resize(p, d, rows ? (want + d - 1) / d : want);
}

static void draw_limits(dice *g, const recipe *of, problem *p) {
  draw_size(g, p);
  draw_frictions(g, of, p);
  plant_states(g, of, p, dice_power(g, -of->ratio, of->ratio));
  const int columns = 1 + dice_below(g, p->m < 12 ? p->m : 12);
  add_random(g, of, p, columns);
  for (int i = 0; i < p->m; i++)
    p->W[(size_t)i * (size_t)(p->m + 1)] += columns * dice_power(g, -2, 0);
}

void draw_extreme(dice *g, const recipe *of, problem *p) {
  p->symmetric = 1;
  if (of->form == OPEN) draw_open(g, of, p);
  if (of->form == SPRINGS) draw_springs(g, of, p);
  if (of->form == ASPECT) draw_aspect(g, of, p);
  if (of->form == MASSES) draw_stack(g, of, p);
  if (of->form == BONDED) draw_bonded(g, of, p);
  if (of->form == HEAVY) draw_heavy(g, of, p);
  if (of->form == SIZES) draw_limits(g, of, p);
}
