/*
 * lanes.c: sweeps of Gauss-Seidel over several small problems at once, one in each lane of the
 * processor's registers.
 *
 * A sweep over one small problem is a chain of roots and divisions, each waiting for the last.
 * Eight problems side by side take little longer than one.
 *
 *   (LA1)  for c = 1 .. nc, in all lanes:
 *            p := u_c - W_cc r_c;  s := the solution of contact c alone;  dr := s - r_c
 *            r_c := s,  u := u + W(:,c) dr
 *   (LA2)  until in each lane |w dr| <= tol |q| / 4 and |dr| <= tol |r| / 4 in a sweep, at most 32
 *          sweeps
 *
 * The local solution is (LO1)-(LO5) of local.c: free, stick by Cramer's rule, else slip, whose l
 * takes two Newton steps from that of the last visit; the sweeps correct the rest. Every lane has
 * d = 3: if d < 3, the missing tangents have a diagonal of their own and q = 0, so they stay 0.
 *
 * Cost: a sweep over nc contacts reads 9 nc^2 doubles a lane, which stay in the cache.
 * What can fail: what fails for Gauss-Seidel, and an l that two steps do not find. The answer has
 * no certificate: the caller measures it.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "vi/vi_internal.h"

enum { lanes = dlsi_lanes, lane_rows = 3 * dlsi_lane_candidates, lane_steps = 2 };
enum { lane_look = 2, lane_sweeps = 32 };
/* Of tol; 1/4 beats 1/16 on boxes with four contacts, and 32 sweeps beat more, up to 96. */
static const double lane_margin = 1. / 4;

typedef double lane[lanes];

/* Data of one contact: W_cc by local.c's names, and l of its last visit. */
typedef struct lane_block {
  lane mu, W[9], inv_a, c[2], S[4], det, inv_det, trace, l;
} lane_block;

struct dlsi_lane_work {
  int nc, rows;
  lane W[lane_rows * lane_rows]; /* rows x rows, column-major */
  lane q[lane_rows], r[lane_rows], u[lane_rows];
  lane w[dlsi_lane_candidates]; /* trace(W_cc) / d */
  lane_block block[dlsi_lane_candidates];
};

dlsi_lane_work *dlsi_lane_create(void) {
  return dlsi_alloc(1, sizeof(dlsi_lane_work));
}

/* ---- in and out ------------------------------------------------------------------------------ */

/* Copies a problem into lane k. */
static void lane_put(dlsi_lane_work *work, int k, const dls_contact *problem) {
  const size_t d = (size_t)problem->d, rows = (size_t)work->rows;
  for (int c = 0; c < work->nc; c++) {
    const dlsi_block_column column = dlsi_contact_column(problem, (size_t)c);
    lane *W = work->W + 3 * (size_t)c * rows, *own = W + 3 * c;
    for (size_t e = 0; e < 3 * rows; e++)
      W[e][k] = 0;
    for (size_t b = column.begin; b < column.end; b++) {
      const double *block = column.x + b * column.step;
      lane *to = W + 3 * dlsi_row(&column, b);
      for (size_t j = 0; j < d; j++)
        for (size_t i = 0; i < d; i++)
          to[i + j * rows][k] += block[i + j * column.ld];
    }
    double trace = 0;
    for (size_t i = 0; i < d; i++)
      trace += own[i + i * rows][k];
    work->w[c][k] = trace / (double)d;
    for (size_t i = d; i < 3; i++)
      own[i + i * rows][k] = work->w[c][k];
    for (size_t i = 0; i < 3; i++) {
      const double q = i < d ? problem->q[d * (size_t)c + i] : 0;
      work->q[3 * (size_t)c + i][k] = work->u[3 * (size_t)c + i][k] = q;
      work->r[3 * (size_t)c + i][k] = 0;
    }
    work->block[c].mu[k] = problem->mu[c];
  }
}

void dlsi_lane_get(const dlsi_lane_work *work, int k, int d, double *r) {
  for (int c = 0; c < work->nc; c++)
    for (int i = 0; i < d; i++)
      *r++ = work->r[3 * c + i][k];
}

/* Computes the terms that depend on the blocks W_cc alone. */
DLSI_CLONES static void lane_prepare(dlsi_lane_work *work) {
  for (int c = 0; c < work->nc; c++) {
    lane_block *b = &work->block[c];
    for (int j = 0; j < 3; j++)
      for (int i = 0; i < 3; i++)
        memcpy(b->W[i + 3 * j], work->W[3 * c + i + (3 * c + j) * work->rows], sizeof(lane));
    for (int k = 0; k < lanes; k++) {
      const double inv_a = 1 / b->W[0][k], c0 = b->W[1][k] * inv_a, c1 = b->W[2][k] * inv_a;
      const double S0 = b->W[4][k] - c0 * b->W[3][k], S1 = b->W[5][k] - c1 * b->W[3][k];
      const double S2 = b->W[7][k] - c0 * b->W[6][k], S3 = b->W[8][k] - c1 * b->W[6][k];
      b->inv_a[k] = inv_a;
      b->c[0][k] = c0, b->c[1][k] = c1;
      b->S[0][k] = S0, b->S[1][k] = S1, b->S[2][k] = S2, b->S[3][k] = S3;
      b->det[k] = S0 * S3 - S1 * S2;
      b->inv_det[k] = 1 / b->det[k];
      b->trace[k] = S0 + S3;
      b->l[k] = 0;
    }
  }
}

/* ---- one contact ----------------------------------------------------------------------------- */

/* The local problem of all lanes: p, (LO2), adj(S) z; s: the solution. */
typedef struct lane_local {
  lane p, z[2], N[2], s[3];
} lane_local;

/* s := free or stick. Returns 1 if some lane has to slip; slips: 1 in these. */
static DLSI_INLINE int lane_stick(const lane_block *b, lane *u, lane *r, lane_local *at,
                                  lane slips) {
  double any = 0;
  for (int k = 0; k < lanes; k++) {
    const double r0 = r[0][k], r1 = r[1][k], r2 = r[2][k];
    const double p0 = u[0][k] - (b->W[0][k] * r0 + b->W[3][k] * r1 + b->W[6][k] * r2);
    const double p1 = u[1][k] - (b->W[1][k] * r0 + b->W[4][k] * r1 + b->W[7][k] * r2);
    const double p2 = u[2][k] - (b->W[2][k] * r0 + b->W[5][k] * r1 + b->W[8][k] * r2);
    const double z0 = p1 - b->c[0][k] * p0, z1 = p2 - b->c[1][k] * p0;
    const double N0 = b->S[3][k] * z0 - b->S[2][k] * z1, N1 = b->S[0][k] * z1 - b->S[1][k] * z0;
    const double t0 = -N0 * b->inv_det[k], t1 = -N1 * b->inv_det[k];
    const double n = -(p0 + b->W[3][k] * t0 + b->W[6][k] * t1) * b->inv_a[k], R = b->mu[k] * n;
    const double closed = p0 < 0 ? 1 : 0, inside = t0 * t0 + t1 * t1 <= R * R ? closed : 0;
    const double sticks = n > 0 ? inside : 0;
    at->p[k] = p0;
    at->z[0][k] = z0, at->z[1][k] = z1;
    at->N[0][k] = N0, at->N[1][k] = N1;
    at->s[0][k] = sticks > 0 ? n : 0;
    at->s[1][k] = sticks > 0 ? t0 : 0;
    at->s[2][k] = sticks > 0 ? t1 : 0;
    slips[k] = closed - sticks;
  }
  for (int k = 0; k < lanes; k++)
    any += slips[k];
  return any > 0;
}

/* s := slip in the lanes that slip; l is kept for the next visit. */
static DLSI_INLINE void lane_slip(lane_block *b, const lane slips, lane_local *at) {
  for (int k = 0; k < lanes; k++) {
    const double p0 = at->p[k], z0 = at->z[0][k], z1 = at->z[1][k], mu = b->mu[k];
    const double b0 = b->W[3][k], b1 = b->W[6][k], inv_a = b->inv_a[k];
    const double det = b->det[k], trace = b->trace[k];
    const double scale = 0.5 * (fabs(b->W[4][k]) + fabs(b->W[8][k]));
    double l = b->l[k];
    for (int step = 0; step < lane_steps; step++) {
      const double inv = 1 / (det + (trace + l) * l), dD = trace + 2 * l, turn = dD * inv;
      const double x = at->N[0][k] + l * z0, y = at->N[1][k] + l * z1;
      const double n = sqrt(x * x + y * y) * fabs(inv), n2 = n * n;
      const double m = mu * inv_a * ((b0 * x + b1 * y) * inv - p0), h = n - m;
      const double ndn = (x * z0 + y * z1) * inv * inv - n2 * turn;
      const double dm = mu * inv_a * (b0 * z0 + b1 * z1 - p0 * dD) * inv - m * turn;
      const double above = m > 0 ? h * n2 * m : h * n;
      const double below = m > 0 ? dm * n2 * n - ndn * (m * m) : dm * n - ndn;
      const double next = l + above / below, up = 8 * l > scale ? 8 * l : scale, down = l / 8;
      const double higher = next >= l ? next : up, lower = next > 0 && next <= l ? next : down;
      l = h > 0 ? higher : lower; /* n falls and m grows with l */
    }
    const double D = det + (trace + l) * l, turn = D > 0 ? -1 : 1;
    const double x = turn * (at->N[0][k] + l * z0), y = turn * (at->N[1][k] + l * z1);
    const double size = sqrt(x * x + y * y);
    const double f = -p0 / (b->W[0][k] * size + mu * (b0 * x + b1 * y));
    const double r0 = f * size, flat = -p0 * inv_a; /* mu = 0: along the normal alone */
    const double n = mu > 0 ? r0 : flat, t = mu > 0 ? mu * f : 0, good = n > 0 ? slips[k] : 0;
    b->l[k] = slips[k] > 0 ? l : b->l[k];
    at->s[0][k] = good > 0 ? n : at->s[0][k];
    at->s[1][k] = good > 0 ? t * x : at->s[1][k];
    at->s[2][k] = good > 0 ? t * y : at->s[2][k];
  }
}

/* ---- sweeps ---------------------------------------------------------------------------------- */

/* Takes one sweep, (LA1). moved, forces: |w dr|^2 and |dr|^2. */
DLSI_CLONES static void lane_sweep(dlsi_lane_work *work, lane moved, lane forces) {
  const int rows = work->rows;
  memset(moved, 0, sizeof(lane));
  memset(forces, 0, sizeof(lane));
  for (int c = 0; c < work->nc; c++) {
    lane_block *b = &work->block[c];
    lane *r = work->r + 3 * c, slips, dr[3];
    lane_local at;
    if (lane_stick(b, work->u + 3 * c, r, &at, slips)) lane_slip(b, slips, &at);
    for (int k = 0; k < lanes; k++) {
      double sum = 0;
      for (int i = 0; i < 3; i++) {
        dr[i][k] = at.s[i][k] - r[i][k];
        r[i][k] = at.s[i][k];
        sum += dr[i][k] * dr[i][k];
      }
      forces[k] += sum;
      moved[k] += work->w[c][k] * work->w[c][k] * sum;
    }
    lane *W0 = work->W + 3 * c * rows, *W1 = W0 + rows, *W2 = W1 + rows;
    for (int i = 0; i < rows; i++)
      for (int k = 0; k < lanes; k++)
        work->u[i][k] += W0[i][k] * dr[0][k] + W1[i][k] * dr[1][k] + W2[i][k] * dr[2][k];
  }
}

/* Returns 1 if (LA2) ends the sweeps. */
static int lane_is_done(const dlsi_lane_work *work, double tol, const double *moved,
                        const double *forces) {
  lane q = {0}, r = {0};
  for (int i = 0; i < work->rows; i++)
    for (int k = 0; k < lanes; k++) {
      q[k] += work->q[i][k] * work->q[i][k];
      r[k] += work->r[i][k] * work->r[i][k];
    }
  int done = 1;
  for (int k = 0; k < lanes; k++)
    done &= moved[k] <= lane_margin * lane_margin * tol * tol * q[k] &&
            forces[k] <= lane_margin * lane_margin * tol * tol * r[k];
  return done;
}

int dlsi_lane_solve(dlsi_lane_work *work, int count, const dls_contact *problem, double tol) {
  lane moved, forces;
  int sweeps = 0;
  work->nc = problem->nc;
  work->rows = 3 * problem->nc;
  for (int k = 0; k < lanes; k++)
    lane_put(work, k, problem + (k < count ? k : 0));
  lane_prepare(work);
  do
    lane_sweep(work, moved, forces);
  while (++sweeps < lane_sweeps && (sweeps % lane_look || !lane_is_done(work, tol, moved, forces)));
  return sweeps;
}
