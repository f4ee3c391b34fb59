/*
 * nlgs_estimate.c: estimates the residual after a sweep of Gauss-Seidel (nlgs.c) from its u.
 *
 * The certificate (delassus/contact.h) takes products with W. Sweeps keep u up to date, so both
 * parts of the residual cost O(nc) here. F_c is the misfit of the contact law, D = diag(w_c) has
 * the weights, q' and r' are q and r of the contacts that are not free:
 *
 *   position residual   |F| / |q'|
 *   force residual      |D^-1 F| / |r'|
 *
 * It is an estimate because u carries the rounding of the sweeps since it was computed afresh;
 * nlgs_loop.c computes the certificate before it stops. If q' = 0, the certificate divides by
 * |W| |r|, the estimate by |q|.
 *
 * Sums go by pieces, which depend on the number of contacts, not on the threads: any number of
 * threads gives the same bits. Cost: 1/7 of a sweep by blocks, 1/2 of one of bodies.
 */
#include <math.h>

#include "nlgs_work.h"

/* Sums of squares for the estimate, without unit: lengths times scale = 1 / |q|, forces times scale
 * w_0. r and q are those of the contacts that are not free. */
typedef struct nlgs_squares {
  double F, force, r, q; /* D^1/2 F', D^-1/2 F', r, q */
} nlgs_squares;

/* Returns the sums from the current u, d = 1 or 2, inlined for a constant d. */
static DLSI_INLINE nlgs_squares nlgs_squares_flat(const int d, const dls_nlgs *work,
                                                  const dls_contact *problem, const double *r,
                                                  const int *list, double scale, int begin,
                                                  int end) {
  nlgs_squares sum = {0};
  const double unit = work->it.w[0];
  for (int k = begin; k < end; k++) {
    const int c = list ? list[k] : k;
    const size_t o = (size_t)d * (size_t)c;
    const double *rc = r + o, *uc = work->it.u + o, *qc = problem->q + o;
    if (rc[0] == 0 && uc[0] >= 0) continue; /* F_c = 0, r_c = 0 */
    const double *w = work->it.weights + 2 * (size_t)c;
    double F[3];
    const int touches = dlsi_contact_misfit(d, problem->mu[c], w, rc, uc, F) != DLS_FREE;
    for (int i = 0; i < d; i++) {
      const double f = F[i] * scale, soft = unit / w[i > 0] * f;
      sum.F += f * f;
      sum.force += soft * soft;
      if (!touches) continue;
      sum.r += (scale * unit * rc[i]) * (scale * unit * rc[i]);
      sum.q += (scale * qc[i]) * (scale * qc[i]);
    }
  }
  return sum;
}

static nlgs_squares nlgs_squares_1d(const dls_nlgs *work, const dls_contact *problem,
                                    const double *r, const int *list, double scale, int begin,
                                    int end) {
  return nlgs_squares_flat(1, work, problem, r, list, scale, begin, end);
}

static nlgs_squares nlgs_squares_2d(const dls_nlgs *work, const dls_contact *problem,
                                    const double *r, const int *list, double scale, int begin,
                                    int end) {
  return nlgs_squares_flat(2, work, problem, r, list, scale, begin, end);
}

/* Returns those sums for d = 3, several contacts at once: their roots and divisions take as long as
 * those of one. */
DLSI_CLONES static nlgs_squares nlgs_squares_3d(const dls_nlgs *work, const dls_contact *problem,
                                                const double *r, const int *list, double scale,
                                                int begin, int end) {
  enum { lanes = 16 };
  nlgs_squares sum = {0};
  const double unit = work->it.w[0];
  for (int first = begin; first < end; first += lanes) {
    const int count = end - first < lanes ? end - first : lanes;
    double v[3][lanes] = {{0}}, u[3][lanes] = {{0}}, q2[lanes] = {0};
    double mu[lanes] = {0}, wn[lanes], wt[lanes], F2[lanes], G2[lanes], r2[lanes];
    int moves = 0, bonded = 0;
    for (int k = 0; k < lanes; k++)
      wn[k] = wt[k] = 1;
    for (int k = 0; k < count; k++) {
      const size_t c = (size_t)(list ? list[first + k] : first + k), o = 3 * c;
      const double *rc = r + o, *uc = work->it.u + o, *qc = problem->q + o;
      moves |= !(rc[0] == 0 && uc[0] >= 0);
      mu[k] = problem->mu[c];
      bonded |= dlsi_is_bonded(mu[k]);
      wn[k] = work->it.weights[2 * c];
      wt[k] = work->it.weights[2 * c + 1];
      for (int i = 0; i < 3; i++) {
        u[i][k] = scale * uc[i];
        v[i][k] = scale * (i ? wt[k] : wn[k]) * rc[i];
        q2[k] += (scale * qc[i]) * (scale * qc[i]);
      }
    }
    if (!moves) continue;
    /* All branches of dlsi_contact_misfit */
    for (int k = 0; k < lanes; k++) {
      const double n = v[0][k] - u[0][k], x = v[1][k] - u[1][k], y = v[2][k] - u[2][k];
      const double t = sqrt(x * x + y * y), R = mu[k] * (wt[k] / wn[k]) * n;
      const int polar = n < 0, inside = t <= R;
      const double f = polar ? 0 : inside ? 1 : R / t;
      const double F[3] = {polar ? v[0][k] : u[0][k], v[1][k] - f * x, v[2][k] - f * y};
      const double a = unit / wn[k], b = unit / wt[k];
      const double Ft = F[1] * F[1] + F[2] * F[2], vt = v[1][k] * v[1][k] + v[2][k] * v[2][k];
      F2[k] = F[0] * F[0] + Ft;
      G2[k] = a * a * (F[0] * F[0]) + b * b * Ft;
      r2[k] = polar ? 0 : a * a * (v[0][k] * v[0][k]) + b * b * vt;
      q2[k] = polar ? 0 : q2[k];
    }
    for (int k = 0; k < count && bonded; k++) { /* not for infinite friction above */
      if (!dlsi_is_bonded(mu[k])) continue;
      const size_t o = 3 * (size_t)(list ? list[first + k] : first + k);
      F2[k] = G2[k] = r2[k] = q2[k] = 0;
      const int touches = v[0][k] > u[0][k];
      for (int i = 0; i < 3; i++) {
        const double soft = unit / (i ? wt[k] : wn[k]), F = touches ? u[i][k] : v[i][k];
        F2[k] += F * F;
        G2[k] += soft * soft * (F * F);
        r2[k] += touches ? soft * soft * (v[i][k] * v[i][k]) : 0;
        q2[k] +=
            touches ? scale * scale * (problem->q[o + (size_t)i] * problem->q[o + (size_t)i]) : 0;
      }
    }
    for (int k = 0; k < count; k++) {
      sum.F += F2[k];
      sum.force += G2[k];
      sum.r += r2[k];
      sum.q += q2[k];
    }
  }
  return sum;
}

/* The sums by pieces. */
typedef struct nlgs_estimates {
  const dls_nlgs *work;
  const dls_contact *problem;
  const double *r;
  double scale;
  dlsi_set of;
  int pieces;
  nlgs_squares sum[dlsi_most_pieces];
} nlgs_estimates;

static void nlgs_sum_piece(void *data, int k) {
  nlgs_estimates *s = data;
  const dls_contact *problem = s->problem;
  const int d = problem->d, begin = dlsi_piece(s->of.count, s->pieces, k);
  const int end = dlsi_piece(s->of.count, s->pieces, k + 1);
  if (s->work->motions && !s->of.groups) dlsi_bodies_unfold(problem, begin, end, s->work->it.u);
  s->sum[k] =
      (d == 1   ? nlgs_squares_1d
       : d == 2 ? nlgs_squares_2d
                : nlgs_squares_3d)(s->work, problem, s->r, s->of.list, s->scale, begin, end);
}

/* Estimates the residuals of the certificate from the current u, of bodies from their motions. */
void dlsi_nlgs_estimate(const dls_nlgs *work, const dls_contact *problem, const double *r,
                        double scale, int everywhere, dls_certificate *now) {
  dlsi_set of = {.count = problem->nc, .groups = work->whole ? &work->groups : NULL};
  if (work->narrow && !everywhere) of = dlsi_nlgs_all(work, problem);
  nlgs_estimates s = {work, problem, r, scale, of, dlsi_pieces(of.count), {{0, 0, 0, 0}}};
  nlgs_squares sum = {0};
  if (of.groups) dlsi_groups_look(of.groups, work->team, r, work->v, work->it.u);
  dlsi_parallel(work->team, s.pieces, nlgs_sum_piece, &s);
  for (int k = 0; k < s.pieces; k++) {
    sum.F += s.sum[k].F;
    sum.force += s.sum[k].force;
    sum.r += s.sum[k].r;
    sum.q += s.sum[k].q;
  }
  const double f = sqrt(sum.F), q = sqrt(sum.q); /* q = 0: the certificate takes |W||r| */
  dlsi_set_residuals(now, q > 0 ? f / q : f, sqrt(sum.force), sqrt(sum.r));
}
