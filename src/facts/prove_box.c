/*
 * prove_box.c: bounds on the laws and their slopes in a box of reactions, for prove.c.
 *
 *   (PR1)  r_t = x t + b p,   x = (mu^2 a^2 - b^2)^1/2          on the cone
 *   (PR2)  F = 0:  u if it sticks;  u_n and, d = 3, p.u - (b / x) t.u if it slips
 *   (PR3)  F is A y + c except for b / x and x; in the box |y - y0| <= delta s, the rounding of A
 *          included, |F'(y) - A| s <= B(delta)
 *   (PR6)  u = W r + q in extended precision: |error| <= (m + 8) eps (|W| |r| + |q|), and |W|
 *          times the rounding of (PR1)
 *
 * All bounds are sums of positive numbers, times `up` for their own rounding.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "facts/prove.h"

static const double most_turned = 0.3; /* b / x of (PR1) */

/* ---- the point ------------------------------------------------------------------------------- */

static int prove_slips(const dlsi_prove *work, int c) {
  return work->branch[c].state == DLS_SLIP && work->branch[c].mu > 0;
}

/* Returns (R^2 - b^2)^1/2, in the unit of R, a power of two: its square may leave the range of
 * numbers. */
static double prove_along(double R, double b) {
  const int unit = R > 0 ? ilogb(R) : 0;
  const double less = ldexp(R - b, -unit), more = ldexp(R + b, -unit);
  return ldexp(sqrt(fmax(0, less * more)), unit);
}

/* (PR1) r := the point with r_n and b; turned := the rounding of its r_t. */
void dlsi_prove_put(dlsi_prove *work) {
  const int d = work->problem->d;
  for (int c = 0; c < work->problem->nc; c++) {
    const dlsi_branch *at = &work->branch[c];
    double *r = work->r + d * c, *turned = work->turned + d * c;
    memset(turned, 0, (size_t)d * sizeof *turned);
    if (!at->count) memset(r, 0, (size_t)d * sizeof *r);
    if (!at->count || at->state == DLS_STICK) continue;
    const double R = at->mu * r[0], b = work->b[c], x = prove_along(R, b);
    for (int i = 1; i < d; i++) {
      const double p = i == 1 ? -at->t[1] : at->t[0], t = at->t[i - 1];
      r[i] = at->mu > 0 ? x * t + b * p : 0;
      turned[i] = 16 * DBL_EPSILON * (x * fabs(t) + fabs(b * p));
    }
  }
}

/* sum += W x (or NULL), a += |W| |x|. */
static void prove_multiply(const dls_contact *problem, const double *x, long double *sum,
                           double *a) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  for (size_t c = 0; c < (size_t)problem->nc; c++, x += d) {
    const dlsi_block_column W = dlsi_contact_column(problem, c);
    const size_t rows = W.row ? d : m, end = W.row ? W.end : W.begin + 1; /* dense: one block */
    if (dlsi_max_abs(x, d) == 0) continue;
    for (size_t k = W.begin; k < end; k++) {
      const double *block = W.x + k * W.step;
      const size_t o = W.row ? d * (size_t)W.row[k] : 0;
      for (size_t j = 0; j < d; j++)
        for (size_t i = 0; i < rows; i++)
          a[o + i] += fabs(block[i + j * W.ld]) * fabs(x[j]);
      for (size_t i = 0; sum && i < rows; i++)
        for (size_t j = 0; j < d; j++)
          sum[o + i] += (long double)block[i + j * W.ld] * x[j];
    }
  }
}

/* y (m) := an upper bound of |W| x, x >= 0. */
static void prove_bound(const dlsi_prove *work, const double *x, double *y) {
  const size_t m = (size_t)work->problem->d * (size_t)work->problem->nc;
  memset(y, 0, m * sizeof *y);
  prove_multiply(work->problem, x, NULL, y);
  for (size_t i = 0; i < m; i++)
    y[i] *= work->up;
}

/* (PR6) */
void dlsi_prove_positions(dlsi_prove *work) {
  const size_t m = (size_t)work->problem->d * (size_t)work->problem->nc;
  const volatile long double one = 1, half = LDBL_EPSILON; /* some run with 53 bits: valgrind */
  const double eps = one + half > one ? (double)LDBL_EPSILON : DBL_EPSILON;
  const double unit = (double)(m + 8) * eps;
  for (size_t i = 0; i < m; i++) {
    work->sum[i] = work->problem->q[i];
    work->a[i] = fabs(work->problem->q[i]);
  }
  prove_multiply(work->problem, work->r, work->sum, work->a);
  prove_bound(work, work->turned, work->du);
  for (size_t i = 0; i < m; i++) {
    work->u[i] = (double)work->sum[i];
    work->du[i] =
        (work->du[i] + unit * work->a[i] + DBL_EPSILON * fabs(work->u[i])) * work->up + DBL_MIN;
  }
}

/* Returns the largest b / x of a contact c that slips, d = 3, for |b| and x within delta s; *x :=
 * the least x. */
static double prove_turn(const dlsi_prove *work, int c, double delta, double *x) {
  const double mu = work->branch[c].mu, s = delta * work->s[c];
  const double a = work->r[work->problem->d * c], b = fabs(work->b[c]) + s;
  *x = mu * (a - s) * (1 - 1e-12) - b;
  return *x > 0 ? b / *x * (1 + 1e-12) : INFINITY;
}

/* (PR2) F := the laws, v := |F| with the error of u; both of the n unknowns in use. */
void dlsi_prove_laws(dlsi_prove *work) {
  const int d = work->problem->d;
  double *F = work->z, *v = work->v2;
  for (int c = 0; c < work->problem->nc; c++) {
    const dlsi_branch *at = &work->branch[c];
    const double *u = work->u + d * c, *du = work->du + d * c, *t = at->t;
    for (int i = 0; i < at->count; i++) {
      F[at->first + i] = u[i];
      v[at->first + i] = fabs(u[i]) + du[i];
    }
    if (at->state != DLS_SLIP || at->count != 2) continue;
    const double R = at->mu * work->r[d * c], b = work->b[c];
    const double k = b / prove_along(R, b), turn = fabs(k);
    const double p = t[0] * u[2] - t[1] * u[1], along = t[0] * u[1] + t[1] * u[2];
    const double size =
        fabs(t[0] * u[2]) + fabs(t[1] * u[1]) + turn * (fabs(t[0] * u[1]) + fabs(t[1] * u[2]));
    F[at->first + 1] = p - k * along;
    v[at->first + 1] = fabs(p - k * along) + 16 * DBL_EPSILON * size +
                       (fabs(t[0]) + fabs(t[1])) * (1 + turn) * (du[1] + du[2]);
  }
  for (int k = 0; k < work->n; k++) {
    work->F[k] = F[work->keep[k]];
    work->v[k] = v[work->keep[k]] * work->up;
  }
}

/* ---- the box --------------------------------------------------------------------------------- */

/* h := |E| y, extra := |E' - E| y and the rounding of A over W, for E' anywhere in the box; y: of
 * all unknowns. Returns 0 if a slip turns too far. */
static int prove_spread(dlsi_prove *work, double delta, const double *y) {
  const int d = work->problem->d;
  double x;
  memset(work->h, 0, (size_t)d * (size_t)work->problem->nc * sizeof *work->h);
  memset(work->extra, 0, (size_t)d * (size_t)work->problem->nc * sizeof *work->h);
  for (int c = 0; c < work->problem->nc; c++) {
    const dlsi_branch *at = &work->branch[c];
    double *h = work->h + d * c, *extra = work->extra + d * c, e[3];
    for (int j = 0; j < at->count; j++) {
      dlsi_branch_direction(at, j, e);
      for (int i = 0; i < d; i++) { /* the entries of A for a slip are rounded */
        h[i] += fabs(e[i]) * y[at->first + j];
        if (prove_slips(work, c)) extra[i] += 8 * DBL_EPSILON * fabs(e[i]) * y[at->first + j];
      }
    }
    if (at->state != DLS_SLIP || at->count != 2) continue;
    const double turn = prove_turn(work, c, delta, &x);
    if (!(turn <= most_turned)) return 0;
    const double by = at->mu * (turn * turn + 8 * DBL_EPSILON) * y[at->first] +
                      (turn + 8 * DBL_EPSILON) * y[at->first + 1];
    for (int i = 1; i < d; i++)
      extra[i] += fabs(at->t[i - 1]) * by;
  }
  return 1;
}

/* (PR3) B. Returns 0 if it is not known. z: scratch. */
int dlsi_prove_slopes(dlsi_prove *work, double delta) {
  const int d = work->problem->d, nc = work->problem->nc;
  double *s = work->z, *B = work->v2, x;
  memset(s, 0, (size_t)work->all * sizeof *s);
  for (int c = 0, k = 0; c < nc; c++)
    for (; k < work->n && work->keep[k] < work->branch[c].first + work->branch[c].count; k++)
      s[work->keep[k]] = work->s[c];
  if (!prove_spread(work, delta, s)) return 0;
  prove_bound(work, work->h, work->Wh);
  prove_bound(work, work->extra, work->We);
  for (int c = 0; c < nc; c++) {
    const dlsi_branch *at = &work->branch[c];
    const double *Wh = work->Wh + d * c, *We = work->We + d * c, *u = work->u + d * c;
    for (int i = 0; i < at->count; i++)
      B[at->first + i] = We[i];
    if (at->state != DLS_SLIP || at->count != 2) continue;
    const double t[2] = {fabs(at->t[0]), fabs(at->t[1])}, turn = prove_turn(work, c, delta, &x);
    const double h[2] = {Wh[1] + We[1], Wh[2] + We[2]};
    /* t.u, and its error with that of the box */
    const double along = at->t[0] * u[1] + at->t[1] * u[2];
    const double off = t[0] * (work->du[d * c + 1] + delta * h[0]) +
                       t[1] * (work->du[d * c + 2] + delta * h[1]) +
                       8 * DBL_EPSILON * (fabs(u[1]) + fabs(u[2]));
    const double most = at->mu * (work->r[d * c] + delta * work->s[c]) * (1 + 1e-12);
    const double high = (fabs(along) + off) / x * (1 + turn * turn);
    const double low = -along > off ? (-along - off) / most : -high;
    const double l = fmax(fabs(at->l - low), fabs(high - at->l));
    B[at->first + 1] = 16 * DBL_EPSILON * (t[1] * Wh[1] + t[0] * Wh[2] + at->l * work->s[c]) +
                       t[1] * We[1] + t[0] * We[2] + turn * (t[0] * h[0] + t[1] * h[1]) +
                       l * s[at->first + 1] +
                       turn / x * 2 * at->mu * (fabs(along) + off) * s[at->first];
  }
  for (int k = 0; k < work->n; k++)
    work->B[k] = B[work->keep[k]] * work->up;
  return 1;
}

/* Counts the contacts whose inequalities fail somewhere in the box; records the first. */
void dlsi_prove_states(dlsi_prove *work, double delta, dls_proof *proof) {
  const dls_contact *problem = work->problem;
  const int d = problem->d, nc = problem->nc;
  for (int c = 0; c < nc; c++)
    for (int i = 0; i < d; i++) { /* h := the box of r, of free contacts too */
      const double h = work->h[d * c + i] + work->extra[d * c + i];
      work->h[d * c + i] = delta * fmax(h, work->s[c]) * work->up + work->turned[d * c + i];
    }
  prove_bound(work, work->h, work->Wh);
  for (int c = 0; c < nc; c++) {
    const double *r = work->r + d * c, *h = work->h + d * c, *u = work->u + d * c;
    const dlsi_branch *at = &work->branch[c];
    double du[3] = {0}, t = 0, along = 0, off = 0;
    for (int i = 0; i < d; i++)
      du[i] = (work->du[d * c + i] + work->Wh[d * c + i]) * work->up;
    for (int i = 1; i < d; i++) {
      t = hypot(t, fabs(r[i]) + h[i]);
      along -= r[i] * u[i];
      off += h[i] * (fabs(u[i]) + du[i]) + fabs(r[i]) * du[i] + 4 * DBL_EPSILON * fabs(r[i] * u[i]);
    }
    dls_contact_state other = work->state[c];
    if (!at->count)
      other = u[0] - du[0] > 0 ? DLS_FREE : problem->mu[c] > 0 ? DLS_SLIP : DLS_STICK;
    else if (!(r[0] - h[0] > 0))
      other = DLS_FREE;
    else if (at->mu > 0 && at->state == DLS_STICK && !(t * (1 + 1e-12) < at->mu * (r[0] - h[0])))
      other = DLS_SLIP;
    else if (prove_slips(work, c) && !(at->count == d - 1 && along - off * work->up > 0))
      other = DLS_STICK;
    if (other == work->state[c]) continue;
    if (!proof->border++) {
      proof->contact = c;
      proof->state = work->state[c];
      proof->other = other;
    }
  }
}

/* Fills radii, from v: bounds on |y* - y|; radius_u from all of the box. */
void dlsi_prove_radii(dlsi_prove *work, double delta, dls_proof *proof) {
  const size_t m = (size_t)work->problem->d * (size_t)work->problem->nc;
  double *all = work->v2, off = 0, most = 0;
  memset(all, 0, (size_t)work->all * sizeof *all);
  for (int k = 0; k < work->n; k++)
    all[work->keep[k]] = work->v[k];
  (void)prove_spread(work, delta, all);
  for (size_t i = 0; i < m; i++) {
    work->h[i] = (work->h[i] + work->extra[i]) * work->up + work->turned[i];
    off = fmax(off, work->du[i] + work->Wh[i]);
    most = fmax(most, fmax(fabs(work->u[i]), fabs(work->problem->q[i])));
    work->extra[i] = work->given[i] - work->r[i];
  }
  const double size = dlsi_norm2(work->r, m), radius = dlsi_norm2(work->h, m);
  proof->radius = size > 0 ? radius / size * work->up : 0;
  proof->radius_u = most > 0 ? off / most * work->up : 0;
  const double given = dlsi_norm2(work->given, m);
  proof->error = given > 0 ? (dlsi_norm2(work->extra, m) + radius) / given * work->up : 0;
}

/* Returns the residual of the equations that do not count, over the largest |q| (PR7). */
double dlsi_prove_lack(dlsi_prove *work, double delta) {
  double most = 0, lack = 0;
  for (int i = 0; i < work->problem->d * work->problem->nc; i++)
    most = fmax(most, fabs(work->problem->q[i]));
  if (work->n == work->all) return 0;
  for (int c = 0; c < work->problem->nc; c++)
    for (int i = 0; i < work->branch[c].count; i++) {
      const int o = work->problem->d * c, k = work->branch[c].first + i;
      const int across = work->branch[c].state == DLS_SLIP && i == 1;
      const double *u = work->u + o, *t = work->branch[c].t;
      double off = 0, size = fabs(u[i]), x;
      for (int l = across; l <= i + across; l++) {
        const double du = work->du[o + l] + delta * (work->Wh[o + l] + work->We[o + l]);
        off = across ? off + 2 * du : du;
      }
      if (across)
        size = fabs(t[0] * u[2] - t[1] * u[1]) +
               prove_turn(work, c, delta, &x) * (fabs(u[1]) + fabs(u[2]));
      int kept = 0;
      for (int j = 0; j < work->n && !kept; j++)
        kept = work->keep[j] == k;
      if (!kept) lack = fmax(lack, size + off);
    }
  return most > 0 ? lack / most * work->up : INFINITY;
}
