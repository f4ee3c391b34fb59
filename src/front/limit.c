/*
 * limit.c: the largest load that is carried, between a certified answer and a proof (limit.h).
 *
 *   (LL1)  trial lambda: f = f0 + lambda f1, friction mu + lambda mu1, dls_reduction_solve, once
 *          something is refused warm from the answer at `carried`, cold if that has no verdict
 *   (LL2)  certified: carried := lambda. Nothing refused yet: 16 times as far next
 *   (LL3)  a motion b: it proves for every lambda with b.f0 + lambda b.f1 > margin, which gives
 *          `refused`; next trial inside its zero, by 3/4 tol
 *   (LL4)  neither: 8 times as far from `refused`, then half way between `carried` and the trial
 *
 * (LL3) is Newton's method on the concave function that the motions bound from above: few trials,
 * as each gives the facet of the admissible loads behind it. Cost: a solve a trial. Fails where
 * trials near the limit have no verdict: both sides stand, further apart.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/limit.h"
#include "front/front.h"
#include "reduction/reduced.h"

static const double margin = 2e-9;   /* of |b|.|f|: 20 times what a proof asks */
static const double farthest = 1e12; /* of the first step */
static const double stride = 16;

typedef struct limit_work {
  dls_reduction *reduction;
  size_t n, m, nc;
  const double *f0, *f1, *g, *mu, *mu1;
  dls_limit_settings settings;
  double side;                      /* 1: upwards, -1: downwards */
  double *f, *friction, *r, *x, *b; /* of a trial; b: the motion of the last proof */
  double *r_best, *x_best;          /* at carried */
  dls_info info;                    /* of the trial */
  dls_limit found;
} limit_work;

void dls_limit_settings_init(dls_limit_settings *settings) {
  *settings =
      (dls_limit_settings){.size = sizeof *settings, .to = INFINITY, .tol = 1e-6, .most = 100};
  dlsi_limits_init(&settings->limits);
}

static dls_status limit_check(const limit_work *l, const double *r, const dls_limit *limit,
                              dls_error *error) {
  const dls_limit_settings *s = &l->settings;
  const dlsi_setting own[] = {{"from", s->from, -DBL_MAX, DBL_MAX, 0},
                              {"tol", s->tol, 0, 1, 1},
                              {"most", s->most, 2, 1e9, 0}};
  dls_status status =
      dlsi_check_settings(&s->limits, s->size, sizeof *s, sizeof own / sizeof own[0], own, error);
  if (status) return status;
  if (isnan(s->to) || s->to == s->from)
    return dlsi_fail(error, DLS_E_ARGUMENT, "to", -1, s->to, "is %g, with from = %g", s->to,
                     s->from);
  if (!l->mu || !r || !limit) return dlsi_is_null(error, !l->mu ? "mu" : !r ? "r" : "limit");
  if (l->f0) status = dlsi_check_vector("f0", l->f0, l->n, error);
  if (!status && l->f1) status = dlsi_check_vector("f1", l->f1, l->n, error);
  if (!status) status = dlsi_check_friction(l->mu, l->nc, error);
  if (!status && l->mu1) status = dlsi_check_vector("mu1", l->mu1, l->nc, error);
  if (!status && !l->f1 && !l->mu1)
    return dlsi_fail(error, DLS_E_ARGUMENT, "f1", -1, 0, "is NULL, and so is mu1: nothing changes");
  return status;
}

/* Returns the zero of b.(f0 + lambda f1); *beyond: the lambda from which on b proves. NAN if b does
 * not turn to the side. */
static double limit_cut(const limit_work *l, const double *b, double *beyond) {
  long double w0 = 0, w1 = 0;
  double s0 = 0, s1 = 0;
  for (size_t i = 0; i < l->n; i++) {
    const double f0 = l->f0 ? l->f0[i] : 0, f1 = l->f1 ? l->f1[i] : 0;
    w0 += (long double)b[i] * f0;
    w1 += (long double)b[i] * f1;
    s0 += fabs(b[i] * f0);
    s1 += fabs(b[i] * f1);
  }
  const double slope = l->side * (double)w1, zero = (double)(-w0 / w1);
  if (!(slope > margin * s1)) return NAN;
  *beyond = zero + l->side * margin * (s0 + fabs(zero) * s1) / slope;
  return zero;
}

/* (LL1) Returns 1: certified, -1: no answer (proved), 0: neither; or an error in *status. */
static int limit_try(limit_work *l, double lambda, int warm, dls_status *status, dls_error *error) {
  for (size_t i = 0; i < l->n; i++)
    l->f[i] = (l->f0 ? l->f0[i] : 0) + (l->f1 ? lambda * l->f1[i] : 0);
  for (size_t c = 0; c < l->nc; c++) {
    l->friction[c] = l->mu[c] + (l->mu1 ? lambda * l->mu1[c] : 0);
    if (!(l->friction[c] >= 0)) {
      *status = dlsi_fail(error, DLS_E_ARGUMENT, "mu1", (long long)c, l->friction[c],
                          "is negative as friction, %g, at lambda = %g", l->friction[c], lambda);
      return 0;
    }
  }
  *status = dls_reduction_load(l->reduction, l->f, l->g, error);
  if (*status) return 0;
  dls_solver_settings settings;
  dls_solver_settings_init(&settings);
  settings.limits = l->settings.limits;
  settings.limits.warm_start = warm;
  if (warm) memcpy(l->r, l->r_best, l->m * sizeof *l->r);
  if (warm) memcpy(l->x, l->x_best, l->n * sizeof *l->x);
  l->found.solves++;
  const dls_status verdict =
      dls_reduction_solve(l->reduction, l->friction, &settings, l->r, NULL, l->x, &l->info, error);
  if (verdict < 0 || verdict == DLS_CANCELLED) {
    *status = verdict;
    return 0;
  }
  return dls_solved(verdict) ? 1 : verdict == DLS_NO_SOLUTION ? -1 : 0;
}

/* (LL2) */
static void limit_carry(limit_work *l, double lambda) {
  l->found.carried = lambda;
  l->found.unique = l->info.unique;
  memcpy(l->r_best, l->r, l->m * sizeof *l->r);
  memcpy(l->x_best, l->x, l->n * sizeof *l->x);
}

/* (LL3) Takes the proof at lambda; returns the next trial. */
static double limit_refuse(limit_work *l, double lambda) {
  dls_limit *found = &l->found;
  const double *b = dls_reduction_motion(l->reduction, NULL);
  double beyond = lambda, zero = b && !l->mu1 ? limit_cut(l, b, &beyond) : NAN;
  /* a cut that leaves the trial out says nothing new: the proof at the trial stands */
  if (!(l->side * (lambda - beyond) >= 0)) zero = NAN, beyond = lambda;
  if (b)
    memcpy(l->b, b, l->n * sizeof *l->b);
  else
    memset(l->b, 0, l->n * sizeof *l->b);
  found->refused = beyond;
  found->proved = 1;
  const double inside = zero - l->side * 0.75 * l->settings.tol * fabs(zero);
  return l->side * (inside - found->carried) > 0 ? inside : (found->carried + beyond) / 2;
}

/* Returns 1 if b lies within tol of a. */
static int limit_meets(double a, double b, double tol) {
  return isfinite(b) && fabs(b - a) <= tol * fmax(fabs(a), fabs(b));
}

/* Returns |f0| / |f1|, the first step. */
static double limit_step(const limit_work *l) {
  const double f0 = l->f0 ? dlsi_norm2(l->f0, l->n) : 0, f1 = l->f1 ? dlsi_norm2(l->f1, l->n) : 0;
  return f0 > 0 && f1 > 0 && !l->mu1 ? f0 / f1 : 1;
}

/* Takes the verdict of a trial and returns the next one; *step: of the last one, from `from`. */
static double limit_next(limit_work *l, int verdict, double trial, double *step) {
  dls_limit *found = &l->found;
  if (verdict < 0) {
    trial = limit_refuse(l, trial);
    if (l->side * (found->refused - found->open) <= 0) found->open = NAN;
    return trial;
  }
  const double back = 8 * fabs(found->refused - trial); /* (LL4); not finite: nothing refused */
  if (verdict > 0) {
    limit_carry(l, trial);
    *step *= stride;
  } else {
    found->open = trial;
    if (back < l->side * (found->refused - found->carried) / 2)
      return found->refused - l->side * back;
  }
  const double end = isnan(found->open) ? found->refused : found->open;
  return isfinite(end) && (found->proved || !isnan(found->open))
             ? (found->carried + end) / 2
             : l->settings.from + l->side * *step;
}

static dls_status limit_search(limit_work *l, dls_error *error) {
  const dls_limit_settings *s = &l->settings;
  dls_limit *found = &l->found;
  const double first = limit_step(l);
  dls_status status = DLS_OK;
  double step = first, trial = s->from + l->side * step;
  while (!(found->proved && limit_meets(found->carried, found->refused, s->tol))) {
    if (limit_meets(found->carried, found->open, s->tol / 8)) return DLS_STALLED;
    if (found->solves >= s->most) return DLS_MAX_ITERATIONS;
    if (l->side * (trial - s->to) > 0) trial = s->to;
    if (!found->proved && isnan(found->open) && step > farthest * first) return DLS_OK;
    int verdict = limit_try(l, trial, found->proved, &status, error);
    if (!status && !verdict) verdict = limit_try(l, trial, !found->proved, &status, error);
    if (status) return status;
    if (verdict > 0 && trial == s->to) return limit_carry(l, trial), DLS_OK;
    trial = limit_next(l, verdict, trial, &step);
  }
  return DLS_OK;
}

static dls_status limit_run(limit_work *l, dls_error *error) {
  dls_limit *found = &l->found;
  *found = (dls_limit){.carried = NAN, .refused = l->settings.to, .open = NAN};
  dls_status status = DLS_OK;
  const int verdict = limit_try(l, l->settings.from, l->settings.limits.warm_start, &status, error);
  if (status) return status;
  limit_carry(l, l->settings.from);
  if (verdict > 0) return limit_search(l, error);
  found->carried = NAN;
  if (verdict < 0) {
    (void)limit_refuse(l, l->settings.from);
    found->refused = l->settings.from;
  }
  return l->info.status;
}

dls_status dls_limit_load(dls_reduction *reduction, const double *f0, const double *f1,
                          const double *g, const double *mu, const double *mu1,
                          const dls_limit_settings *settings, double *r, double *x, double *motion,
                          dls_limit *limit, dls_error *error) {
  DLSI_DOOR;
  if (!reduction) return dlsi_at(__func__, dlsi_is_null(error, "reduction"), error);
  const dlsi_reduced of = dlsi_reduction_body(reduction);
  limit_work l = {.reduction = reduction, .f0 = f0, .f1 = f1, .g = g, .mu = mu, .mu1 = mu1};
  l.n = (size_t)of.K.n;
  l.nc = (size_t)of.H->candidates;
  l.m = l.nc * (size_t)of.H->d;
  dls_limit_settings_init(&l.settings);
  if (settings) l.settings = *settings;
  l.side = l.settings.to > l.settings.from ? 1 : -1;
  dls_status status = limit_check(&l, r, limit, error);
  if (status) return dlsi_at(__func__, status, error);
  double *memory = dlsi_alloc(4 * l.n + 2 * l.m + l.nc, sizeof *memory);
  if (!memory) return dlsi_at(__func__, dlsi_no_memory(error), error);
  l.f = memory, l.x = l.f + l.n, l.b = l.x + l.n, l.x_best = l.b + l.n;
  l.r = l.x_best + l.n, l.r_best = l.r + l.m, l.friction = l.r_best + l.m;
  memset(memory, 0, (4 * l.n + 2 * l.m + l.nc) * sizeof *memory);
  if (l.settings.limits.warm_start) memcpy(l.r_best, r, l.m * sizeof *r);
  status = limit_run(&l, error);
  if (status >= 0) {
    memcpy(r, l.r_best, l.m * sizeof *r);
    if (x) memcpy(x, l.x_best, l.n * sizeof *x);
    if (motion) memcpy(motion, l.b, l.n * sizeof *motion);
    *limit = l.found;
  }
  free(memory);
  return dlsi_at(__func__, status, error);
}
