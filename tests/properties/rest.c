/*
 * rest.c: planted problems of bodies at rest, and their judge: rest.h.
 */
#include "rest.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/reduction.h"
#include "delassus/solve.h"
#include "problem.h"

static const char *const kind_name[REST_KINDS] = {"statics", "falls", "impulse", "joints",
                                                  "free",    "heat",  "held",    "penalty"};
static const char *const verdict_text[REST_VERDICTS] = {"right",
                                                        "refused",
                                                        "solved, and there is no answer",
                                                        "no solution, although there is one",
                                                        "a body is not in balance",
                                                        "K x = f + H r does not hold",
                                                        "a reaction is not in its cone",
                                                        "positions do not meet the laws"};

static int is_rigid(rest_kind of) {
  return of <= REST_JOINTS;
}

/* ---- bodies ---------------------------------------------------------------------------------- */

/* Adds a rigid body: unknowns of its centre and its turn. */
static void add_rigid(dice *g, rest *p) {
  const int o = p->n, b = p->bodies++;
  for (int i = 0; i < 3; i++) {
    p->body[o + i] = b;
    p->motion[i][o + i] = 1;
    if (p->kind == REST_IMPULSE || p->kind == REST_JOINTS)
      p->K[o + i][o + i] = exp2(dice_below(g, 7) - 3 - 2 * (i == 2));
  }
  p->motions[b] = p->kind < REST_IMPULSE ? 3 : 0;
  p->n += 3;
}

/* A contact of a point of body b with an obstacle or, b2 >= 0, with the other rigid body. */
static void touch_rigid(dice *g, rest *p, int b, int b2) {
  static const int normals[8][2] = {{1, 0}, {0, 1},  {-1, 0},  {0, -1},
                                    {1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
  const int *n = normals[dice_below(g, 8)], t[2] = {n[1], -n[0]}, c = p->nc++;
  for (int side = 0; side < 2; side++) {
    const int o = 3 * (side ? b2 : b), sign = side ? -1 : 1;
    const int arm[2] = {dice_below(g, 9) - 4, dice_below(g, 9) - 4};
    if (o < 0) continue;
    for (int i = 0; i < 2; i++) {
      p->H[o + i][2 * c] = sign * n[i];
      p->H[o + i][2 * c + 1] = sign * t[i];
    }
    p->H[o + 2][2 * c] = sign * (arm[0] * n[1] - arm[1] * n[0]);
    p->H[o + 2][2 * c + 1] = sign * (arm[0] * t[1] - arm[1] * t[0]);
  }
}

/* A hinge of two bodies: two rows G' x = b, forces among the unknowns. */
static void add_hinge(dice *g, rest *p, int one, int two) {
  for (int i = 0; i < 2; i++) {
    const int l = p->n++;
    p->body[l] = -1;
    for (int side = 0; side < 2; side++) {
      const int o = 3 * (side ? two : one), sign = side ? -1 : 1;
      p->K[l][o + i] = p->K[o + i][l] = sign;
      p->K[l][o + 2] = p->K[o + 2][l] = sign * (dice_below(g, 5) - 2);
    }
  }
}

static void add_bar(rest *p, double k, int one, int two, int dx, int dy) {
  const int at[4] = {one, one + 1, two, two + 1}, e[4] = {dx, dy, -dx, -dy};
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++)
      p->K[at[i]][at[j]] += k / (dx * dx + dy * dy) * e[i] * e[j];
}

/* Adds an elastic body, braced squares w x h, that may touch with its lowest nodes and, on its
 * sides, with walls. */
static void add_lattice(dice *g, rest *p) {
  const int w = 1 + dice_below(g, 5), h = 1 + dice_below(g, 2), b = p->bodies++;
  const double k = exp2(4 + dice_below(g, 8));
  for (int y = 0; y <= h; y++)
    for (int x = 0; x <= w; x++) {
      const int o = p->n;
      p->body[o] = p->body[o + 1] = b;
      p->motion[0][o] = p->motion[1][o + 1] = 1;
      p->motion[2][o] = -y;
      p->motion[2][o + 1] = x;
      p->n += 2;
      const int left = o - 2, below = o - 2 * (w + 1);
      if (x > 0) add_bar(p, k, o, left, 1, 0);
      if (y > 0) add_bar(p, k, o, below, 0, 1);
      if (x > 0 && y > 0) add_bar(p, k, o, below - 2, 1, 1);
      if (x < w && y > 0) add_bar(p, k, o, below + 2, -1, 1);
      const int bottom = y == 0, wall = y > 0 && (x == 0 || x == w) && dice_below(g, 4) == 0;
      if (!(bottom || wall) || p->nc >= REST_CONTACTS) continue;
      const int c = p->nc++, n[2] = {bottom ? 0 : x == 0 ? 1 : -1, bottom};
      for (int i = 0; i < 2; i++) {
        p->H[o + i][2 * c] = n[i];
        p->H[o + i][2 * c + 1] = i ? -n[0] : n[1];
      }
    }
  p->motions[b] = p->kind == REST_FREE || p->kind == REST_HEAT ? 3 : 0;
  if (p->motions[b]) return;
  for (int i = 0; i < 2; i++) {
    const int one = p->n - 2 + i, two = p->n - 2 - 2 * w + i; /* corners above */
    p->fixed[one] = p->kind == REST_PENALTY;
    p->K[one][one] += p->kind == REST_PENALTY ? exp2(27 + dice_below(g, 74)) : k;
    if (p->kind == REST_HELD) p->K[two][two] += k;
  }
}

/* ---- answers --------------------------------------------------------------------------------- */

/* Draws the state of contact c: r and u that meet the laws. */
static void draw_contact(dice *g, rest *p, int c, double *u) {
  const double mu = p->mu[c], rn = (1 + dice_below(g, 32)) / 4.0;
  const int luck = dice_below(g, 20), sign = dice_sign(g);
  double *r = p->r + 2 * c;
  r[0] = r[1] = u[0] = u[1] = 0;
  if (luck < 4) {
    u[0] = (1 + dice_below(g, 8)) / 8.0;
    u[1] = (dice_below(g, 9) - 4) / 8.0;
  } else if (luck < 18 || p->kind == REST_HELD) {
    r[0] = rn;
    r[1] = mu * rn * (dice_below(g, 15) - 7) / 8;
    if (luck < 12) return;
    r[1] = sign * mu * rn;
    u[1] = -sign * (1 + dice_below(g, 8)) / 8.0;
  } /* else u = r = 0 */
}

/* g := u - H' x and f := K x - H r; all sums are exact. */
static void plant_load(dice *g, rest *p) {
  double u[2 * REST_CONTACTS];
  for (int c = 0; c < p->nc; c++)
    draw_contact(g, p, c, u + 2 * c);
  for (int i = 0; i < p->n; i++) {
    double Hr = 0;
    for (int k = 0; k < 2 * p->nc; k++)
      Hr += p->H[i][k] * p->r[k];
    for (int j = 0; j < p->n; j++)
      p->own[i] += p->K[i][j] * p->x[j];
    p->f[i] = p->own[i] - Hr;
    if (is_rigid(p->kind)) p->own[i] = 0;
  }
  for (int k = 0; k < 2 * p->nc; k++) {
    p->g[k] = u[k];
    for (int i = 0; i < p->n; i++)
      p->g[k] -= p->H[i][k] * p->x[i];
  }
}

/* Turns the normals so that the motion x opens every contact, and f so that it drives x. */
static void let_fall(dice *g, rest *p) {
  double work = 0;
  for (int c = 0; c < p->nc; c++) {
    double v[2] = {0, 0};
    for (int i = 0; i < p->n; i++)
      for (int k = 0; k < 2; k++)
        v[k] += p->H[i][2 * c + k] * p->x[i];
    const int swap = fabs(v[0]) < p->mu[c] * fabs(v[1]);
    for (int i = 0; i < p->n; i++) {
      const double n = p->H[i][2 * c + swap], t = p->H[i][2 * c + !swap];
      p->H[i][2 * c] = v[swap] < 0 ? -n : n;
      p->H[i][2 * c + 1] = t;
    }
  }
  for (int i = 0; i < p->n; i++) {
    p->f[i] = dice_below(g, 17) - 8;
    work += p->f[i] * p->x[i];
  }
  for (int i = 0; i < p->n && work == 0; i++) {
    p->f[i] += p->x[i];
    work += p->x[i] * p->x[i];
  }
  for (int i = 0; i < p->n; i++)
    p->f[i] = work < 0 ? -p->f[i] : p->f[i];
}

static double draw_friction(dice *g, rest_kind of) {
  const double small = dice_below(g, 8) / 8.0;
  if (of == REST_JOINTS) return 1 + dice_below(g, 17) / 8.0;
  if (of == REST_FREE && dice_below(g, 4) == 0) return exp2(dice_below(g, 7));
  return small;
}

void rest_generate(rest_kind of, uint64_t seed, rest *p) {
  dice g = {seed ^ (0xa54ff53a5f1d36f1u + (uint64_t)of)};
  *p = (rest){.kind = of};
  const int bodies =
      is_rigid(of) ? 1 + dice_below(&g, REST_BODIES) : 1 + (of == REST_FREE && dice_below(&g, 2));
  for (int b = 0; b < bodies; b++) {
    if (is_rigid(of))
      add_rigid(&g, p);
    else
      add_lattice(&g, p);
  }
  for (int b = 0; b < bodies && is_rigid(of); b++) {
    const int contacts = 1 + dice_below(&g, 4);
    if (of == REST_JOINTS && b > 0) add_hinge(&g, p, b - 1, b);
    for (int k = 0; k < contacts; k++)
      touch_rigid(&g, p, b, b && dice_below(&g, 2) ? dice_below(&g, b) : -1);
  }
  const double mu = draw_friction(&g, of);
  for (int c = 0; c < p->nc; c++)
    p->mu[c] = mu;
  const double size = of == REST_HEAT || of == REST_HELD ? exp2(dice_below(&g, 28) - 6) : 0.125;
  for (int i = 0; i < p->n; i++)
    if (of != REST_STATICS) p->x[i] = size * (dice_below(&g, 17) - 8);
  if (of == REST_FALLS)
    let_fall(&g, p);
  else
    plant_load(&g, p);
}

/* ---- the judge ------------------------------------------------------------------------------- */

typedef long double real;

static const double balanced = 1e-6, of_rows = 1e-4, of_laws = 1e-5, rounding = 1e-14;
static const double tol = 4e-8; /* of the solver, over the norm of a few indentations r_k / K_ii */
static const double unit = 0.125; /* of planted lengths; the least planted force */

/* Rows of f + H r - K x and their sizes; size: of the body of a row, or of a joint. The loads of a
 * body that no other force touches are its scale, to 1e-8. */
static rest_verdict judge_balance(const rest *p, const double *x, const double *r) {
  real left[REST_UNKNOWNS], load[REST_UNKNOWNS], inner[REST_UNKNOWNS] = {0};
  real size[REST_BODIES] = {0}, lengths = unit;
  int alone[REST_BODIES];
  for (int b = 0; b < p->bodies; b++) {
    size[b] = unit;
    alone[b] = 1;
  }
  for (int i = 0; i < p->n; i++)
    lengths = fmaxl(lengths, fabsl((real)x[i]));
  for (int i = 0; i < p->n; i++) {
    const real outer = (real)p->f[i] - p->own[i];
    left[i] = p->f[i];
    load[i] = fabsl(outer);
    if (p->body[i] >= 0 && outer != 0) alone[p->body[i]] = 0;
    for (int k = 0; k < 2 * p->nc; k++) {
      const real t = (real)p->H[i][k] * r[k];
      left[i] += t;
      load[i] += fabsl(t);
    }
    for (int j = 0; j < p->n; j++) {
      const real t = (real)p->K[i][j] * x[j];
      left[i] -= t;
      inner[i] += fabsl(t);
      if (is_rigid(p->kind) && p->body[i] >= 0) load[i] += fabsl(t);
    }
    if (p->body[i] >= 0 && !p->fixed[i]) size[p->body[i]] = fmaxl(size[p->body[i]], load[i]);
  }
  for (int i = 0; i < p->n; i++) {
    const int b = p->body[i];
    if (b >= 0 && alone[b]) size[b] = fmaxl(size[b], 1e-8 / of_rows * fabs(p->own[i]));
  }
  for (int i = 0; i < p->n; i++) {
    const int b = p->body[i];
    if (p->fixed[i] && !(fabsl((real)x[i] - p->x[i]) <= balanced * lengths)) return REST_ROWS;
    if (p->fixed[i]) continue;
    const real limit = is_rigid(p->kind) ? balanced : of_rows;
    if (!(fabsl(left[i]) <= limit * (b < 0 ? lengths : size[b]) + rounding * inner[i]))
      return REST_ROWS;
  }
  for (int b = 0; b < p->bodies; b++)
    for (int k = 0; k < p->motions[b]; k++) {
      real sum = 0;
      for (int i = 0; i < p->n; i++) {
        real outer = (real)p->f[i] - p->own[i];
        for (int j = 0; j < 2 * p->nc; j++)
          outer += (real)p->H[i][j] * r[j];
        if (p->body[i] == b) sum += p->motion[k][i] * outer;
      }
      if (!(fabsl(sum) <= (alone[b] ? of_rows : balanced) * size[b])) return REST_MOTION;
    }
  return REST_RIGHT;
}

static rest_verdict judge_laws(const rest *p, const double *x, const double *r) {
  real most = unit, far = unit, dent = 0, load = 0;
  for (int i = 0; i < p->n; i++)
    load = fmaxl(load, fabs(p->f[i]));
  for (int k = 0; k < 2 * p->nc; k++) {
    real size = fabs(p->g[k]);
    for (int i = 0; i < p->n; i++) {
      const real push = fabsl((real)p->H[i][k] * r[k]);
      size += fabsl((real)p->H[i][k] * x[i]);
      if (p->K[i][i] > 0) dent = fmaxl(dent, fminl(push, load) / p->K[i][i]);
    }
    most = fmaxl(most, fabs(r[k]));
    far = fmaxl(far, size);
  }
  const real small_r = of_laws * most, small_u = of_laws * far + tol * dent;
  for (int c = 0; c < p->nc; c++) {
    real u[2] = {p->g[2 * c], p->g[2 * c + 1]};
    const real rn = r[2 * c], rt = r[2 * c + 1], mu = p->mu[c];
    for (int i = 0; i < p->n; i++)
      for (int k = 0; k < 2; k++)
        u[k] += (real)p->H[i][2 * c + k] * x[i];
    if (!(rn >= -small_r && fabsl(rt) <= mu * rn + (1 + mu) * small_r)) return REST_CONE;
    if (!(u[0] >= -small_u && (u[0] <= small_u || rn <= small_r))) return REST_LAW;
    if (fabsl(u[1]) <= small_u || rn <= small_r) continue;
    if (!(fabsl(rt) >= mu * rn - (1 + mu) * small_r && rt * u[1] <= small_r * fabsl(u[1])))
      return REST_LAW;
  }
  return REST_RIGHT;
}

rest_verdict rest_judge(const rest *p, dls_status status, const double *x, const double *r) {
  const int solved = status == DLS_OK || status == DLS_TO_ROUNDING;
  if (p->kind == REST_FALLS) return solved ? REST_CLAIMED : REST_RIGHT;
  if (status == DLS_NO_SOLUTION) return REST_DENIED;
  if (!solved) return REST_REFUSED;
  const rest_verdict verdict = judge_balance(p, x, r);
  return verdict ? verdict : judge_laws(p, x, r);
}

/* ---- a run ----------------------------------------------------------------------------------- */

typedef struct columns {
  int p[2 * REST_CONTACTS + REST_UNKNOWNS + 1], i[REST_UNKNOWNS * REST_UNKNOWNS];
  double x[REST_UNKNOWNS * REST_UNKNOWNS];
} columns;

/* Columns first, first + step, .. of an array of rows `ld` long. */
static dls_sparse compress(const double *A, int ld, int rows, int cols, int first, int step,
                           columns *to) {
  int count = 0;
  for (int j = 0; j < cols; j++) {
    to->p[j] = count;
    for (int i = 0; i < rows; i++) {
      const double v = A[(size_t)i * (size_t)ld + (size_t)(first + step * j)];
      if (v == 0) continue;
      to->i[count] = i;
      to->x[count++] = v;
    }
  }
  to->p[cols] = count;
  return (dls_sparse){rows, cols, to->p, to->i, to->x};
}

static dls_status solve_rest(const rest *p, double *x, double *r) {
  static columns K, N, T;
  double u[2 * REST_CONTACTS];
  dls_reduction *reduction;
  dls_reduction_settings how;
  dls_solver_settings settings;
  dls_reduction_settings_init(&how);
  dls_solver_settings_init(&settings);
  how.allow_indefinite = 1;
  const dls_model model = {.d = 2,
                           .n = p->n,
                           .nodes = p->nc,
                           .operator_kind = DLS_STIFFNESS_SPARSE,
                           .factorization = p->kind == REST_JOINTS ? DLS_LDLT : DLS_CHOLESKY,
                           .Ks = compress(&p->K[0][0], REST_UNKNOWNS, p->n, p->n, 0, 1, &K),
                           .HN = compress(&p->H[0][0], 2 * REST_CONTACTS, p->n, p->nc, 0, 2, &N),
                           .HT = compress(&p->H[0][0], 2 * REST_CONTACTS, p->n, p->nc, 1, 2, &T)};
  memset(r, 0, 2 * (size_t)p->nc * sizeof *r);
  dls_status status = dls_reduction_create(&reduction, &model, &how, NULL);
  if (!status) status = dls_reduction_load(reduction, p->f, p->g, NULL);
  if (!status) status = dls_reduction_solve(reduction, p->mu, &settings, r, u, x, NULL, NULL);
  dls_reduction_destroy(reduction);
  return status;
}

int rest_kind_of(const char *name) {
  for (int k = 0; k < REST_KINDS; k++)
    if (!strcmp(name, kind_name[k])) return k;
  return strcmp(name, "rest") ? -1 : REST_KINDS;
}

int rest_run(uint64_t seed, uint64_t step, long count, int which) {
  static rest p;
  int good = 1;
  double x[REST_UNKNOWNS], r[2 * REST_CONTACTS];
  for (int k = 0; k < REST_KINDS; k++) {
    long tally[REST_VERDICTS] = {0}, untrue = 0;
    for (long i = 0; (which == REST_KINDS || k == which) && i < count; i++) {
      const uint64_t own = seed + step * (uint64_t)i;
      rest_generate((rest_kind)k, own, &p);
      const dls_status status = solve_rest(&p, x, r);
      const rest_verdict verdict = status < 0 ? REST_REFUSED : rest_judge(&p, status, x, r);
      tally[verdict]++;
      if (verdict <= REST_REFUSED) continue;
      if (untrue++ < 3)
        printf("--seed %llu --count 1 --class %s: %s (%s)\n", (unsigned long long)own, kind_name[k],
               verdict_text[verdict], dls_status_text(status));
    }
    if (which != REST_KINDS && k != which) continue;
    printf("%-8s right %ld, refused %ld, untrue %ld", kind_name[k], tally[REST_RIGHT],
           tally[REST_REFUSED], untrue);
    for (int v = REST_CLAIMED; v < REST_VERDICTS; v++)
      if (tally[v]) printf("; %s %ld", verdict_text[v], tally[v]);
    printf("\n");
    good &= !untrue;
  }
  return good;
}
