/*
 * local.c: the exact solution of one contact alone, [Jean 1988] (3.3)5-6 for nc = 1.
 *
 *   u = W r + q,  W = (a b^T; c B),  0 <= u_n _|_ r_n >= 0,  |r_t| <= mu r_n,
 *   u_t = 0 where |r_t| < mu r_n,  u_t = -alpha r_t with alpha >= 0 else
 *
 *   free   (LO1)  r = 0                                       if q_n >= 0
 *   u_n = 0 in all that follows, so that r_n = -(q_n + b.r_t) / a and u_t = z + S r_t with
 *          (LO2)  S = B - c b^T / a,  z = q_t - c q_n / a     the Schur complement of a
 *   stick  (LO3)  S r_t = -z                                  if |r_t| <= mu r_n
 *   slip   (LO4)  (S + l I) r_t = -z,  h(l) = |r_t| - mu r_n = 0,  l > 0
 *          (LO5)  r_n = -q_n / (a + mu b.e),  r_t = mu r_n e  with e = r_t / |r_t|
 *
 * 2D: e = +1 or -1, so (LO5) and the sign of u_t decide slip. All four states are tried, which is
 * exact for any W: unsymmetric, singular, with W_nn <= 0, with no solution or with several. If q_n
 * < 0, both slips hold only together with stick: on the segment u_n = 0 between them, which lies in
 * the cone, the affine u_t changes sign. So the order of the two slips does not matter.
 *
 * 3D: if q_n < 0 and no stick, h(0) > 0 > h(inf) = mu q_n / a. So h has a root if S + l I stays
 * regular for l > 0, as for W positive semidefinite. The root is bracketed and found by Newton's
 * method on 1/|r_t| - 1/(mu r_n), almost linear in l (More and Sorensen's secular form), on h if
 * r_n <= 0, and by bisection if a step leaves the bracket. If q_n is so small beside z that S is
 * lost in S + l I, r_t is along -z. (LO5) makes u_n = 0 and |r_t| = mu r_n hold to rounding; the
 * error left is the angle between u_t and -r_t. A singular S needs no care: its stick solutions are
 * the limit l -> 0 of (LO4). r_t(l) follows from Cramer's rule with one division: (LO5) uses only
 * its direction. Stick uses its length, too, so (LO3) takes LU factors of S, which W_cc alone
 * gives.
 *
 * (LO4) squared is a quartic in l, whose positive roots give all slip solutions in 3D and their
 * number. It serves the count, and a W that is not positive semidefinite, whose root may lie
 * outside the bracket.
 *
 * If nothing solves the problem, the answer is the trial point with the smallest |F| of the
 * certificate. Cost and accuracy: see README.md.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "vi/vi_internal.h"

/* Accepts |F| <= rounding (w |r| + |q|) as a solution if every exact test has failed. */
static const double rounding = 1e-12;

/* Two solutions are one if r_n, r_t differ by less than this fraction; an |h| this close to 0 is a
 * root, not a pole. */
static const double same = 1e-8;

/* Size of r above which its fourth power in Newton's steps does not underflow. */
static const double least_size = 0x1p-200;

/* Newton's last step in l, as a fraction of l: the next step would be of its square. */
static const double last_step = 1e-8;

static dlsi_local_state local_set(int d, double *r, double n, double t, dlsi_local_state state) {
  r[0] = n;
  if (d > 1) r[1] = t;
  if (d == 3) r[2] = 0;
  return state;
}

/* ---- the least bad of several points --------------------------------------------------------- */

typedef struct point {
  double r[3];
  dlsi_local_state state;
} point;

static const point apart = {{0, 0, 0}, DLS_LOCAL_NONE}; /* for q_n < 0 */

/* r := the point with the smallest |F| of n points; the first is r = 0, and NaN never wins. */
static dlsi_local_state least_bad(int d, const double *W, const double *q, double mu,
                                  const point *points, int n, double *r) {
  double trace = 0, largest = 0;
  for (int i = 0; i < d; i++)
    trace += W[i + d * i];
  for (int e = 0; e < d * d; e++)
    if (fabs(W[e]) > largest) largest = fabs(W[e]);
  const double w = trace > 0 ? trace / d : largest > 0 ? largest : 1;
  double best = INFINITY;
  dlsi_local_state state = DLS_LOCAL_NONE;
  local_set(d, r, 0, 0, state);
  for (int k = 0; k < n; k++) {
    const double *p = points[k].r;
    double u[3] = {0}, F[3] = {0};
    for (int i = 0; i < d; i++) {
      u[i] = q[i];
      for (int j = 0; j < d; j++)
        u[i] += W[i + d * j] * p[j];
    }
    dlsi_contact_misfit(d, mu, (const double[]){w, w}, p, u, F);
    const double f = dlsi_norm2(F, (size_t)d);
    if (!(f < best)) continue;
    best = f;
    for (int i = 0; i < d; i++)
      r[i] = p[i];
    const double size = w * dlsi_norm2(p, (size_t)d) + dlsi_norm2(q, (size_t)d);
    state = f <= rounding * size ? points[k].state : DLS_LOCAL_NONE;
  }
  return state;
}

/* ---- 2D -------------------------------------------------------------------------------------- */

void dlsi_block_2d_set(dlsi_block_2d *b, const double *W, double mu) {
  memcpy(b->W, W, sizeof b->W);
  b->mu = mu;
  b->p = fabs(W[1]) > fabs(W[0]); /* the pivot row; the other one is 1 - p */
  b->inv_pivot = 1 / W[b->p];
  b->f = W[1 - b->p] * b->inv_pivot;
  b->inv_s = 1 / (W[3 - b->p] - b->f * W[2 + b->p]);
  b->inv_slip[0] = 1 / (W[0] - mu * W[2]);
  b->inv_slip[1] = 1 / (W[0] + mu * W[2]);
}

/* Solves W r = -q by elimination. Returns 1 if r is in the cone and not 0. */
static int stick_2d(const dlsi_block_2d *b, const double *q, double *r) {
  const int p = b->p;
  const double z = q[1 - p] - b->f * q[p];
  r[1] = z == 0 ? 0 : -z * b->inv_s; /* of a line of solutions, the one without friction */
  r[0] = -(q[p] + b->W[2 + p] * r[1]) * b->inv_pivot;
  return r[0] > 0 && r[0] <= DBL_MAX && fabs(r[1]) <= b->mu * r[0];
}

/* (LO5) with e = sign. Returns 1 if u_t opposes it. */
static int slip_2d(const dlsi_block_2d *b, const double *q, int sign, double *r) {
  r[0] = -q[0] * b->inv_slip[sign > 0];
  r[1] = sign * b->mu * r[0];
  return r[0] > 0 && r[0] <= DBL_MAX && fabs(r[1]) <= DBL_MAX &&
         sign * (q[1] + b->W[1] * r[0] + b->W[3] * r[1]) <= 0;
}

/* Solves for mu = 0, where the tangential rows only separate stick from slip. */
static dlsi_local_state frictionless(int d, const double *W, const double *q, double *r) {
  if (!(W[0] > 0)) return least_bad(d, W, q, 0, &apart, 1, r);
  local_set(d, r, -q[0] / W[0], 0, DLS_LOCAL_SLIP);
  if (!(r[0] <= DBL_MAX)) return least_bad(d, W, q, 0, &apart, 1, r);
  const int still = (d < 2 || q[1] + W[1] * r[0] == 0) && (d < 3 || q[2] + W[2] * r[0] == 0);
  return still ? DLS_LOCAL_STICK : DLS_LOCAL_SLIP;
}

dlsi_local_state dlsi_local_1d(double W, const double *q, double *r) {
  if (q[0] >= 0) return local_set(1, r, 0, 0, DLS_LOCAL_FREE); /* (LO1) */
  return frictionless(1, &W, q, r);
}

dlsi_local_state dlsi_local_2d(const dlsi_block_2d *b, const double *q, double *r) {
  if (q[0] >= 0) return local_set(2, r, 0, 0, DLS_LOCAL_FREE); /* (LO1) */
  if (b->mu == 0) return frictionless(2, b->W, q, r);
  if (stick_2d(b, q, r)) return DLS_LOCAL_STICK; /* (LO3) */
  double plus[2], minus[2];                      /* (LO5) */
  if (slip_2d(b, q, 1, plus)) return local_set(2, r, plus[0], plus[1], DLS_LOCAL_SLIP);
  if (slip_2d(b, q, -1, minus)) return local_set(2, r, minus[0], minus[1], DLS_LOCAL_SLIP);
  const point points[] = {apart,
                          {{r[0], r[1], 0}, DLS_LOCAL_STICK},
                          {{plus[0], plus[1], 0}, DLS_LOCAL_SLIP},
                          {{minus[0], minus[1], 0}, DLS_LOCAL_SLIP}};
  return least_bad(2, b->W, q, b->mu, points, 4, r);
}

static int count_2d(const dlsi_block_2d *b, const double *q) {
  int n = q[0] >= 0;
  if (b->mu == 0) return n + (-q[0] / b->W[0] > 0);
  double stick[2], slip[2];
  const int sticks = stick_2d(b, q, stick);
  n += sticks;
  for (int sign = -1; sign <= 1; sign += 2)
    if (slip_2d(b, q, sign, slip) && !(sticks && fabs(slip[0] - stick[0]) <= same * fabs(slip[0]) &&
                                       fabs(slip[1] - stick[1]) <= same * fabs(slip[1])))
      n++;
  return n;
}

/* ---- 3D -------------------------------------------------------------------------------------- */

void dlsi_block_3d_set(dlsi_block_3d *b, const double *W, double mu) {
  double *S = b->S, *c = b->c;
  memcpy(b->W, W, sizeof b->W);
  b->mu = mu;
  b->inv_a = 1 / W[0];
  for (int i = 0; i < 2; i++) {
    c[i] = W[1 + i] * b->inv_a;
    S[i] = W[4 + i] - c[i] * W[3];
    S[2 + i] = W[7 + i] - c[i] * W[6];
  }
  b->det = S[0] * S[3] - S[1] * S[2];
  b->trace = S[0] + S[3];
  b->p = fabs(S[1]) > fabs(S[0]);
  b->inv0 = 1 / S[b->p];
  b->f = S[1 - b->p] * b->inv0;
  b->u01 = S[2 + b->p];
  b->inv1 = 1 / (S[3 - b->p] - b->f * b->u01);
  b->scale = 0.5 * (fabs(W[4]) + fabs(W[8]));
  if (!(b->scale > 0)) b->scale = W[0];
}

/* (LO2), and the terms of (LO4) that do not depend on l. */
typedef struct schur {
  const dlsi_block_3d *block;
  double a, b[2], qn, mu, z[2];
  double N[2]; /* adj(S) z */
} schur;

static schur local_schur(const dlsi_block_3d *block, const double *q) {
  const double *W = block->W, *S = block->S;
  const double z0 = q[1] - block->c[0] * q[0], z1 = q[2] - block->c[1] * q[0];
  const schur s = {.block = block,
                   .a = W[0],
                   .b = {W[3], W[6]},
                   .qn = q[0],
                   .mu = block->mu,
                   .z = {z0, z1},
                   .N = {S[3] * z0 - S[2] * z1, S[0] * z1 - S[1] * z0}};
  return s;
}

/* x := -S^-1 z. */
static void local_solve_schur(const dlsi_block_3d *k, const double *z, double *x) {
  x[1] = -(z[1 - k->p] - k->f * z[k->p]) * k->inv1;
  x[0] = -(z[k->p] + k->u01 * x[1]) * k->inv0;
}

static double local_normal(const schur *s, const double *t) {
  return -(s->qn + s->b[0] * t[0] + s->b[1] * t[1]) * s->block->inv_a;
}

/* (LO3); returns 1 if r is in the cone. */
static inline int stick_3d(const schur *s, double *r) {
  local_solve_schur(s->block, s->z, r + 1);
  r[0] = local_normal(s, r + 1);
  return r[0] > 0 && r[0] <= DBL_MAX && sqrt(r[1] * r[1] + r[2] * r[2]) <= s->mu * r[0];
}

/* (LO4) at l: r_t = -y / D, y = N + l z, D = det(S + l I), and r_n = (b.y - q_n D) / (a D) by u_n =
 * 0 */
typedef struct local_trial {
  double y[2], inv, dD; /* 1 / D, D' */
  double size, n, m;    /* |y|, |r_t|, mu r_n */
} local_trial;

/* Evaluates (LO4) at l, with few operations after the division: a sweep is a chain of these. */
static inline local_trial local_evaluate(const schur *s, double l) {
  const dlsi_block_3d *k = s->block;
  const double D = k->det + (k->trace + l) * l, inv = 1 / D;
  const double x = s->N[0] + l * s->z[0], y = s->N[1] + l * s->z[1], sum = x * x + y * y;
  const double size = dlsi_is_plain(sum) ? sqrt(sum) : hypot(x, y);
  const double m = s->mu * k->inv_a * (s->b[0] * x + s->b[1] * y - s->qn * D) * inv;
  return (local_trial){{x, y}, inv, k->trace + 2 * l, size, size * fabs(inv), m};
}

/* (LO5) along r_t, k = r_n / |y|. Returns 1 if r_n > 0 and all is finite. */
static inline int on_cone(const schur *s, const local_trial *c, double *r) {
  const double sign = copysign(1, -c->inv), x = sign * c->y[0], y = sign * c->y[1];
  const double k = -s->qn / (s->a * c->size + s->mu * (s->b[0] * x + s->b[1] * y));
  r[0] = k * c->size;
  r[1] = s->mu * k * x;
  r[2] = s->mu * k * y;
  return r[0] > 0 && s->mu * r[0] <= DBL_MAX && r[0] <= DBL_MAX && c->size <= DBL_MAX;
}

/* Returns Newton's step from l for 1/n - 1/m, or for h = n - m if m <= 0. */
static inline double local_newton(const schur *s, const local_trial *c) {
  const double *y = c->y, *z = s->z, *b = s->b;
  const double n = c->n, m = c->m, h = n - m, inv2 = c->inv * c->inv, turn = c->dD * c->inv;
  const double n2 = (y[0] * y[0] + y[1] * y[1]) * inv2;
  const double ndn = (y[0] * z[0] + y[1] * z[1]) * inv2 - n2 * turn; /* n n' */
  const double dE = b[0] * z[0] + b[1] * z[1] - s->qn * c->dD;       /* m = mu E / (a D) */
  const double dm = s->mu * s->block->inv_a * dE * c->inv - m * turn;
  return m > 0 ? h * (n2 * m) / (dm * n2 * n - ndn * (m * m)) : h * n / (dm * n - ndn);
}

static dlsi_local_state slip_3d_small(const schur *s, double guess, double *r);

/* Solves (LO4) for q_n < 0 from guess, or from 0 if guess is not > 0. Returns DLS_LOCAL_NONE if
 * it finds no root. */
static dlsi_local_state slip_3d(const schur *s, double guess, double *r) {
  enum { most_steps = 100 };
  const double *S = s->block->S, far = s->a * (fabs(s->z[0]) + fabs(s->z[1]));
  const double unit = (far * s->block->inv_a - s->qn) * s->block->inv_a;
  const double stiff = fabs(S[0]) + fabs(S[1]) + fabs(S[2]) + fabs(S[3]);
  if (unit < least_size && unit > 0) return slip_3d_small(s, guess, r);
  if (-s->mu * s->qn * stiff <= DBL_EPSILON * far) { /* S + l I = l I to rounding */
    const local_trial c = {.y = {s->z[0], s->z[1]}, .inv = 1, .size = hypot(s->z[0], s->z[1])};
    if (on_cone(s, &c, r)) return DLS_LOCAL_SLIP;
  }
  double l = guess > 0 && guess <= DBL_MAX ? guess : 0, lo = 0, hi = INFINITY;
  for (int step = 0; step < most_steps; step++) {
    const local_trial c = local_evaluate(s, l);
    const double n = c.n, m = c.m, h = n - m, size = n + fabs(m);
    /* u_t = -l r_t is below the rounding of z: (LO3) on the edge of the cone */
    if (h <= 0 && m <= DBL_MAX && l * n <= 4 * DBL_EPSILON * (fabs(s->z[0]) + fabs(s->z[1]))) {
      r[1] = -c.y[0] * c.inv;
      r[2] = -c.y[1] * c.inv;
      r[0] = local_normal(s, r + 1);
      return DLS_LOCAL_STICK;
    }
    if (fabs(h) <= 4 * DBL_EPSILON * size || hi - lo <= 2 * DBL_EPSILON * l) {
      const int root = fabs(h) <= same * size; /* and not a pole of r_t */
      return on_cone(s, &c, r) && root ? DLS_LOCAL_SLIP : DLS_LOCAL_NONE;
    }
    if (h <= 0)
      hi = l;
    else
      lo = l; /* also if S is singular and r_t is not finite */
    const double next = l + local_newton(s, &c);
    if (fabs(next - l) <= last_step * l && fabs(h) <= same * size) {
      const local_trial last = local_evaluate(s, next);
      return on_cone(s, &last, r) ? DLS_LOCAL_SLIP : DLS_LOCAL_NONE;
    }
    if (next > lo && next < hi)
      l = next;
    else if (!(hi < INFINITY))
      l = 8 * l > s->block->scale ? 8 * l : s->block->scale;
    else
      l = lo > 0 ? lo * sqrt(hi / lo) : hi / 64; /* powers of two keep every bit */
  }
  return DLS_LOCAL_NONE;
}

/* The same in a larger unit of q: in the first sweep over stacked bodies r halves from one to the
 * next, and bisection of what underflows takes longer than all the rest. */
static dlsi_local_state slip_3d_small(const schur *s, double guess, double *r) {
  const double up = 1 / least_size;
  const schur larger = {.block = s->block,
                        .a = s->a,
                        .b = {s->b[0], s->b[1]},
                        .qn = up * s->qn,
                        .mu = s->mu,
                        .z = {up * s->z[0], up * s->z[1]},
                        .N = {up * s->N[0], up * s->N[1]}};
  const dlsi_local_state state = slip_3d(&larger, guess, r);
  for (int i = 0; i < 3; i++)
    r[i] *= least_size;
  return state;
}

/* Finds the positive roots, in increasing order, of p[0] + .. + p[n] x^n, p[n] != 0. Between the
 * roots of its derivative p is monotonic, so bisection finds all. All roots are below 1 + max
 * |p_i/p_n|, and so are those of the derivatives (Gauss-Lucas). */
static int positive_roots(int n, const double *p, double *x) {
  double last = 1;
  for (int i = 0; i < n; i++)
    if (1 + fabs(p[i] / p[n]) > last) last = 1 + fabs(p[i] / p[n]);
  int count = 0;
  for (int k = 1; k <= n; k++) { /* the derivative of order n - k, of degree k */
    double c[5], ends[6], y[4];
    for (int j = 0; j <= k; j++) {
      c[j] = p[j + n - k];
      for (int f = j + 1; f <= j + n - k; f++)
        c[j] *= f;
    }
    ends[0] = 0;
    for (int i = 0; i < count; i++)
      ends[i + 1] = x[i];
    ends[count + 1] = last;
    int found = 0;
    for (int i = 0; i <= count; i++) {
      double lo = ends[i], hi = ends[i + 1], at_lo = 0;
      for (int j = k; j >= 0; j--)
        at_lo = at_lo * lo + c[j];
      double at_hi = 0;
      for (int j = k; j >= 0; j--)
        at_hi = at_hi * hi + c[j];
      if (!(at_lo < 0 && at_hi > 0) && !(at_lo > 0 && at_hi < 0)) continue;
      for (int step = 0; step < 120; step++) {
        const double mid = 0.5 * (lo + hi);
        if (!(mid > lo && mid < hi)) break;
        double at = 0;
        for (int j = k; j >= 0; j--)
          at = at * mid + c[j];
        if ((at > 0) == (at_lo > 0))
          lo = mid;
        else
          hi = mid;
      }
      y[found++] = 0.5 * (lo + hi);
    }
    count = found;
    for (int i = 0; i < count; i++)
      x[i] = y[i];
  }
  return count;
}

/* All slip solutions: with N = adj(S + l I) z, D = det(S + l I), r_t = -N / D and (LO4) squared is
 * a^2 |N|^2 = mu^2 E^2, E = q_n D - b.N, a quartic p in x = l / scale. What remains to be tested is
 * r_n = -E / (a D) > 0. */
typedef struct slip_quartic {
  double p[5], E[3];    /* powers of x */
  double N[2], z[2];    /* N = N(0) + x z */
  double a, det, trace; /* D = det + trace x + x^2 */
} slip_quartic;

static slip_quartic slip_quartic_of(const schur *s) {
  double S[4];
  for (int e = 0; e < 4; e++)
    S[e] = s->block->S[e] / s->block->scale;
  const double a = s->a / s->block->scale, b0 = s->b[0] / s->block->scale,
               b1 = s->b[1] / s->block->scale;
  const double size = fabs(s->qn) + fabs(s->z[0]) + fabs(s->z[1]);
  const double qn = s->qn / size, z0 = s->z[0] / size, z1 = s->z[1] / size, m2 = s->mu * s->mu;
  const double N0 = S[3] * z0 - S[2] * z1, N1 = S[0] * z1 - S[1] * z0; /* at x = 0; N' = z */
  const double det = S[0] * S[3] - S[1] * S[2], trace = S[0] + S[3];
  const double E[3] = {qn * det - b0 * N0 - b1 * N1, qn * trace - b0 * z0 - b1 * z1, qn};
  return (slip_quartic){.p = {a * a * (N0 * N0 + N1 * N1) - m2 * E[0] * E[0],
                              2 * (a * a * (N0 * z0 + N1 * z1) - m2 * E[0] * E[1]),
                              a * a * (z0 * z0 + z1 * z1) - m2 * (E[1] * E[1] + 2 * E[0] * E[2]),
                              -2 * m2 * E[1] * E[2], -m2 * E[2] * E[2]},
                        .E = {E[0], E[1], E[2]},
                        .N = {N0, N1},
                        .z = {z0, z1},
                        .a = a,
                        .det = det,
                        .trace = trace};
}

/* Returns the largest number of slip solutions: by Descartes' rule, the changes of sign. */
static int most_slips(const slip_quartic *k) {
  int changes = 0;
  double last = 0;
  for (int i = 0; i < 5; i++) {
    if (!(k->p[i] != 0)) continue;
    changes += (last < 0 && k->p[i] > 0) || (last > 0 && k->p[i] < 0);
    last = k->p[i];
  }
  return changes;
}

static int all_slips(const schur *s, const slip_quartic *k, point *points) {
  const double *E = k->E;
  int n = 4, found = 0;
  while (n > 0 && !(k->p[n] != 0))
    n--;
  double x[4];
  const int roots = positive_roots(n, k->p, x);
  for (int i = 0; i < roots; i++) {
    if (!(x[i] > rounding)) continue; /* stick on the edge of the cone */
    const double D = k->det + (k->trace + x[i]) * x[i];
    const double y[2] = {k->N[0] + x[i] * k->z[0], k->N[1] + x[i] * k->z[1]};
    const local_trial c = {.y = {y[0], y[1]}, .inv = 1 / D, .size = hypot(y[0], y[1])};
    if (-(E[0] + (E[1] + E[2] * x[i]) * x[i]) / (k->a * D) > 0 && on_cone(s, &c, points[found].r))
      points[found++].state = DLS_LOCAL_SLIP;
  }
  return found;
}

dlsi_local_state dlsi_local_3d(const dlsi_block_3d *b, const double *q, double guess, double *r) {
  if (q[0] >= 0) return local_set(3, r, 0, 0, DLS_LOCAL_FREE); /* (LO1) */
  if (b->mu == 0) return frictionless(3, b->W, q, r);
  if (!(b->W[0] > 0)) return least_bad(3, b->W, q, b->mu, &apart, 1, r);
  const schur s = local_schur(b, q);
  if (stick_3d(&s, r)) return DLS_LOCAL_STICK;
  if (dlsi_is_bonded(b->mu)) return least_bad(3, b->W, q, b->mu, &apart, 1, r);
  const dlsi_local_state state = slip_3d(&s, guess, r);
  if (state != DLS_LOCAL_NONE) return state;
  point points[6] = {apart, {.state = DLS_LOCAL_STICK}};
  (void)stick_3d(&s, points[1].r);
  const slip_quartic quartic = slip_quartic_of(&s);
  const int n = 2 + all_slips(&s, &quartic, points + 2);
  return least_bad(3, b->W, q, b->mu, points, n, r);
}

/* A solution with r != 0 has u_n = 0, hence a r_n <= mu |b| r_n - q_n: none for q_n >= 0 unless
 * mu |b| > a. */
static int count_3d(const dlsi_block_3d *b, const double *q) {
  const double *W = b->W, mu = b->mu;
  int n = q[0] >= 0;
  if (!(W[0] > 0)) return n;
  if (dlsi_is_bonded(mu)) return 1;
  if (n && !(mu * hypot(W[3], W[6]) > W[0])) return n;
  if (mu == 0) return n + (q[0] < 0);
  const schur s = local_schur(b, q);
  point slip[4];
  double stick[3];
  n += stick_3d(&s, stick);
  const slip_quartic quartic = slip_quartic_of(&s);
  const int most = n + most_slips(&quartic); /* at most one: the known answer */
  return most <= 1 ? most : n + all_slips(&s, &quartic, slip);
}

int dlsi_local_count(int d, const double *W, const double *q, double mu) {
  if (d == 1) return (q[0] >= 0) + (-q[0] / W[0] > 0);
  if (d == 2) {
    dlsi_block_2d b;
    dlsi_block_2d_set(&b, W, mu);
    return count_2d(&b, q);
  }
  dlsi_block_3d b = {0};
  dlsi_block_3d_set(&b, W, mu);
  return count_3d(&b, q);
}

dlsi_local_state dlsi_nlgs_local(int d, const double *W, const double *q, double mu, double *r,
                                 int *count) {
  DLSI_DOOR;
  double p[3] = {0};
  dlsi_local_state state;
  if (d == 1)
    state = dlsi_local_1d(W[0], q, p);
  else if (d == 2) {
    dlsi_block_2d b;
    dlsi_block_2d_set(&b, W, mu);
    state = dlsi_local_2d(&b, q, p);
  } else {
    dlsi_block_3d b = {0};
    dlsi_block_3d_set(&b, W, mu);
    state = dlsi_local_3d(&b, q, 0, p);
  }
  if (count) {
    *count = state == DLS_LOCAL_NONE ? 0 : dlsi_local_count(d, W, q, mu);
    /* if rounding makes the two tests differ, the answer counts */
    if (state != DLS_LOCAL_NONE && *count < 1) *count = 1;
  }
  memcpy(r, p, (size_t)d * sizeof *r);
  return state;
}
