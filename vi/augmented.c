/*
 * augmented.c: the augmented Lagrangian of Simo and Laursen, [Chabrand 1998] 4.1, on the reactions.
 *
 *   u = W r + q,   0 <= u_n _|_ r_n >= 0,   |r_t| <= mu r_n,   u_t opposed to r_t where it slips
 *
 * With penalties eps_c > 0 and multipliers lambda, reactions follow from u by the return mapping
 *
 *   r_n = < lambda_n - eps u_n >                                                          (32)
 *   r_t = tau put on the disc of radius mu r_n,   tau = lambda_t - eps u_t          (33), (34)
 *
 * The regularised problem is u = W r + q with this r; lambda := r after it is (35), (36).
 *
 * It is the proximal point method. Put v = u + (r - lambda) / eps. Then lambda - eps u = r - eps v,
 * and (32)-(34) read r_n = < r_n - eps v_n >, r_t = r_t - eps v_t put on the disc of radius mu r_n.
 * These are the laws of contact and friction for r and v, whatever eps > 0. So the regularised
 * problem is a contact problem again,
 *
 *   v = (W + E) r + (q - E lambda),   E = diag(1 / eps_c),
 *
 * with eps_c = 1 / (alpha w_c) the step W + alpha D, q - alpha D lambda of the proximal point
 * method, D = diag(w_c). E > 0 makes a singular W regular and calms cycles. One augmentation:
 *
 *   (A1)  A = W + s E,   b = q - s E lambda
 *   (A2)  x = the solution of v = A x + b: newton.c from lambda, that is up to 20 sweeps of
 *         Gauss-Seidel, then Newton steps
 *   (A3)  lambda := x  if (A2) succeeded, or if x has half the residual of lambda, W and q given
 *   (A4)  s := 0.2 s   as long as (A2) has never failed, then 0.8 s, after each failure 2 s;
 *         1e-7 <= s <= 1e3, from s = 1; only if adaptive
 *
 * (A2) is asked for a residual of a thousandth of lambda's, and not for less than a tenth of what
 * is wanted in the end; in the last augmentation allowed, for this tenth. One augmentation from
 * lambda = 0 is the penalty method; its r is off by about E r.
 *
 * Stop: the certificate of x from the user's W and q holds. Else DLS_STALLED: (A2) failed and s may
 * not grow, or cannot and lambda stayed; or 150 augmentations did not bring the residual down by a
 * tenth; or 10 times running, failures of (A2) not counted,
 *
 *   (A5)  |W delta| < 1e-4 |delta|, q.delta < -1e-4 |q| |delta|,   delta = x - lambda of (A2),
 *         |D^-1/2 u| and |D^1/2 r| being the norms. Without a solution lambda grows along such a
 *         delta for ever. Seldom, lambda on its way to a far solution does so, too: hence 10.
 * A warm start for which W r overflows is dropped.
 *
 * Source: [Chabrand 1998] 4.1. Slips there: with Delta xi = f_s / eps_T as printed, (34) must take
 * eps_T Delta xi off, as (31) says; in (36) that makes lambda_t the r_t of (34). (33)'s increments
 * add up to lambda_t - eps u_t with u_t the whole slip of the step. Deviations: the unknown of
 * Newton's method is r, not the displacement: the same solution, and a large eps does not spoil the
 * conditioning. eps_T = eps_N = eps_c: w_c is the mean over both directions. The schedule (A4): of
 * eps the paper says that it needs precautions; too small an s fails in (A2), too large a one crawls.
 *
 * Cost of an augmentation: up to 20 sweeps, and 0 to 30 Newton steps, an LU of the unknowns each.
 * What can fail: (A2), for every s, where friction makes even W + s E cycle, or W is indefinite.
 * Nothing guarantees that the augmentations converge with friction; without, and with W positive
 * semidefinite, they do.
 */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/base.h"
#include "delassus/augmented.h"
#include "vi_internal.h"

enum { most_augmentations = 400, sweeps = 20, patience = 150, escapes_to_believe = 10 };

static const double shrink_at_first = 0.2, shrink = 0.8, grow = 2, smallest = 1e-7, largest = 1e3;

struct dls_augmented {
  dls_augmented_settings settings;
  int d, nc;
  int escaped;     /* direction holds one that (A5) accepted */
  double *penalty; /* nc      eps_c as given, if settings.penalty */
  double *w;       /* nc      weights of the certificate */
  double *E;       /* nc      1 / eps_c at s = 1 */
  double *sE;      /* nc      (A1) */
  double *b;       /* m       (A1) */
  double *lambda;  /* m */
  double *x;       /* m */
  double *best;    /* m       the x with the smallest residual so far */
  double *delta;   /* m       x - lambda */
  double *direction;
  double *u, *a, *F;  /* m each */
  dls_newton *newton; /* (A2) */
};

void dls_augmented_settings_init(dls_augmented_settings *settings) {
  if (!settings) return;
  *settings = (dls_augmented_settings){.size = sizeof *settings, .factor = 100, .adaptive = 1};
  dlsi_limits_init(&settings->limits);
}

/* x > 0 with a reciprocal */
static int is_penalty(double x) {
  return x > 0 && x <= DBL_MAX && 1 / x <= DBL_MAX;
}

static dls_status check_penalty(const double *penalty, int nc, dls_error *error) {
  const dls_status status = dlsi_check_vector("penalty", penalty, (size_t)nc, error);
  if (status) return status;
  for (int c = 0; c < nc; c++)
    if (!is_penalty(penalty[c]))
      return dlsi_fail(error, DLS_E_ARGUMENT, "penalty", c, penalty[c], "is %g, must be > 0",
                       penalty[c]);
  return DLS_OK;
}

static dls_status check_settings(const dls_augmented_settings *s, int nc, dls_error *error) {
  const dlsi_setting own[] = {{"factor", s->factor, 1 / DBL_MAX, DBL_MAX, 0},
                              {"adaptive", s->adaptive, 0, 1, 0}};
  const dls_status status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 2, own, error);
  return status || !s->penalty ? status : check_penalty(s->penalty, nc, error);
}

/* the workspace and all its arrays, in one piece */
static dls_augmented *carve(dlsi_arena *arena, int d, int nc) {
  const size_t D = sizeof(double), n = (size_t)nc, m = (size_t)d * n;
  dls_augmented *s = dlsi_take(arena, 1, sizeof *s);
  dls_augmented filled = {.d = d, .nc = nc};
  double **const per_candidate[] = {&filled.penalty, &filled.w, &filled.E, &filled.sE};
  for (size_t e = 0; e < sizeof per_candidate / sizeof per_candidate[0]; e++)
    *per_candidate[e] = dlsi_take(arena, n, D);
  double **const vectors[] = {&filled.b,    &filled.lambda, &filled.x,
                              &filled.best, &filled.delta,  &filled.direction,
                              &filled.u,    &filled.a,      &filled.F};
  for (size_t e = 0; e < sizeof vectors / sizeof vectors[0]; e++)
    *vectors[e] = dlsi_take(arena, m, D);
  if (arena->failed || !arena->base) return NULL;
  *s = filled;
  return s;
}

/* 20 sweeps and Newton steps, from the r given */
static dls_status create_newton(dls_newton **out, int d, int nc, int blocks, dlsi_room *room,
                                dls_error *error) {
  dls_newton_settings s;
  dls_newton_settings_init(&s);
  s.sweeps = sweeps;
  s.limits.warm_start = 1;
  s.limits.blocks = blocks;
  return dlsi_newton_create(out, d, nc, &s, room, error);
}

dls_status dlsi_augmented_create(dls_augmented **out, int d, int nc,
                                 const dls_augmented_settings *settings, dlsi_room *room,
                                 dls_error *error) {
  if (!out) return dlsi_is_null(error, "out");
  *out = NULL;
  dls_status status = dlsi_check_sizes(d, nc, error);
  dls_augmented_settings defaults;
  dls_augmented_settings_init(&defaults);
  if (!settings) settings = &defaults;
  if (!status) status = check_settings(settings, nc, error);
  if (status) return status;

  dls_newton *newton;
  status = create_newton(&newton, d, nc, settings->limits.blocks, room, error);
  if (status) return status;
  dlsi_arena arena = {0};
  (void)carve(&arena, d, nc); /* smaller than what Newton has got: no overflow */
  arena.size = arena.used;
  arena.used = 0;
  arena.base = dlsi_alloc(1, arena.size);
  if (!arena.base) {
    dls_newton_destroy(newton);
    return dlsi_no_memory(error);
  }
  dls_augmented *work = carve(&arena, d, nc);
  work->settings = *settings;
  if (settings->penalty) {
    memcpy(work->penalty, settings->penalty, (size_t)nc * sizeof *work->penalty);
    work->settings.penalty = work->penalty;
  }
  work->newton = newton;
  *out = work;
  return DLS_OK;
}

dls_status dls_augmented_create(dls_augmented **out, int d, int nc,
                                const dls_augmented_settings *settings, dls_error *error) {
  return dlsi_at(__func__, dlsi_augmented_create(out, d, nc, settings, NULL, error), error);
}

void dls_augmented_destroy(dls_augmented *workspace) {
  if (!workspace) return;
  dls_newton_destroy(workspace->newton);
  free(workspace); /* first in its one piece */
}

const double *dls_augmented_direction(const dls_augmented *workspace) {
  return workspace && workspace->escaped ? workspace->direction : NULL;
}

/* ---- one augmentation ------------------------------------------------------------------------ */

static void prepare(dls_augmented *work, const dls_contact *problem) {
  const dls_augmented_settings *s = &work->settings;
  work->escaped = 0;
  dlsi_contact_weights(problem, work->w);
  for (int c = 0; c < problem->nc; c++)
    work->E[c] = s->penalty ? 1 / s->penalty[c] : work->w[c] / s->factor;
}

/* (A1), (A2): x from lambda; DLS_OK if its residual is <= target in units of |q|, q the user's. *now:
 * the certificate of x for the problem as given. */
static dls_status solve_regularised(dls_augmented *work, const dls_contact *problem, double s,
                                    double target, dls_certificate *now, int *factorisations,
                                    dls_error *error) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  for (size_t c = 0; c < m / d; c++)
    work->sE[c] = s * work->E[c];
  for (size_t k = 0; k < m; k++)
    work->b[k] = problem->q[k] - work->sE[k / d] * work->lambda[k];
  const double size_q = dlsi_norm2(problem->q, m), size_b = dlsi_norm2(work->b, m);
  dls_contact regularised = *problem;
  regularised.q = work->b;
  memcpy(work->x, work->lambda, m * sizeof *work->x);
  dlsi_newton_count count;
  dls_certificate certificate;
  const dls_status status = dlsi_newton_run(work->newton, &regularised, work->sE,
                                            size_b > 0 ? target * (size_q / size_b) : target,
                                            work->x, NULL, &certificate, &count, error);
  if (status < 0) return status;
  *factorisations += count.factorisations;
  dlsi_contact_multiply(problem, NULL, work->x, work->u, work->a);
  dlsi_contact_measure(problem, work->x, work->u, work->a, work->w, work->F, now);
  return status;
}

/* (A5) for delta = x - lambda, put into work->delta with its largest entry +-1 */
static int escapes(const dls_augmented *work, const dls_contact *problem) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  double *delta = work->delta, *v = work->u;
  for (size_t k = 0; k < m; k++)
    delta[k] = work->x[k] - work->lambda[k];
  const double size = dlsi_max_abs(delta, m);
  if (!(size > 0 && size <= DBL_MAX)) return 0;
  for (size_t k = 0; k < m; k++)
    delta[k] /= size;
  memset(v, 0, m * sizeof *v);
  for (int c = 0; c < problem->nc; c++)
    dlsi_contact_add_columns(problem, c, delta + d * (size_t)c, v);
  double gain = 0; /* q.delta */
  for (size_t k = 0; k < m; k++) {
    const double root = sqrt(work->w[k / d]);
    gain += problem->q[k] * delta[k];
    v[k] /= root;
    work->a[k] = problem->q[k] / root;
    work->F[k] = delta[k] * root;
  }
  const double length = dlsi_norm2(work->F, m);
  return dlsi_norm2(v, m) < 1e-4 * length && gain < -1e-4 * length * dlsi_norm2(work->a, m);
}

/* ---- the augmentations ----------------------------------------------------------------------- */

/* Augmentations from work->lambda until the certificate holds or there is a reason to stop, which
 * is returned; work->best is then the best iterate and outcome->certificate belongs to it. */
static dls_status iterate(dls_augmented *work, const dls_contact *problem, dls_info *outcome,
                          dls_error *error) {
  const dls_augmented_settings *settings = &work->settings;
  const int most = dlsi_most_iterations(&settings->limits, most_augmentations);
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  dls_certificate *best = &outcome->certificate;
  for (int cold = 0; cold < 2; cold++) {
    dlsi_contact_multiply(problem, NULL, work->lambda, work->u, work->a);
    dlsi_contact_measure(problem, work->lambda, work->u, work->a, work->w, work->F, best);
    if (best->residual <= DBL_MAX) break;
    memset(work->lambda, 0, m * sizeof *work->lambda);
  }
  memcpy(work->best, work->lambda, m * sizeof *work->best);
  double s = 1, residual = best->residual, milestone = residual;
  int failed = 0;               /* some (A2) did */
  int passed = 0, escaping = 0; /* augmentation of the milestone; (A5) that many times running */
  for (int k = 1; !dls_certificate_holds(best, settings->limits.tol); k++) {
    if (k > most) return DLS_MAX_ITERATIONS;
    const double floor = 4 * best->floor;
    const double wanted = 0.1 * (floor > settings->limits.tol ? floor : settings->limits.tol);
    const int last = k == most;
    const double target = !last && 1e-3 * residual > wanted ? 1e-3 * residual : wanted;

    dls_certificate now; /* (A1), (A2) */
    const dls_status status =
        solve_regularised(work, problem, s, target, &now, &outcome->factorisations, error);
    if (status < 0) return status;
    const int solved = status == DLS_OK;
    outcome->iterations = k;
    if (solved) { /* (A5) */
      escaping = escapes(work, problem) ? escaping + 1 : 0;
      work->escaped = escaping > 0;
      if (escaping) memcpy(work->direction, work->delta, m * sizeof *work->direction);
    }
    if (now.residual < best->residual) {
      *best = now;
      memcpy(work->best, work->x, m * sizeof *work->best);
    }
    const int moved = solved || now.residual < residual / 2;
    if (moved) { /* (A3) */
      memcpy(work->lambda, work->x, m * sizeof *work->lambda);
      residual = now.residual;
    }
    const int stuck = !solved && (!settings->adaptive || (!moved && s >= largest));
    if (settings->adaptive) { /* (A4) */
      failed |= !solved;
      s *= !solved ? grow : failed ? shrink : shrink_at_first;
      s = s < smallest ? smallest : s > largest ? largest : s;
    }
    if (best->residual < 0.9 * milestone) {
      milestone = best->residual;
      passed = k;
    }
    if (settings->limits.progress) {
      const dls_progress progress = {"augmented-lagrangian", k, most, now.residual};
      if (settings->limits.progress(settings->limits.progress_data, &progress) &&
          !dls_certificate_holds(best, settings->limits.tol))
        return DLS_CANCELLED;
    }
    if ((stuck || k - passed >= patience || escaping >= escapes_to_believe) &&
        !dls_certificate_holds(best, settings->limits.tol))
      return DLS_STALLED;
  }
  return DLS_OK;
}

dls_status dlsi_augmented_solve(dls_augmented *work, const dls_contact *problem, double *r,
                                double *u, dls_info *info, dls_error *error) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  prepare(work, problem);
  if (work->settings.limits.warm_start && dlsi_max_abs(problem->q, m) > 0)
    memcpy(work->lambda, r, m * sizeof *r);
  else /* q = 0: r = 0 */
    memset(work->lambda, 0, m * sizeof *r);
  dls_info outcome = {.method = DLS_AUGMENTED_LAGRANGIAN};
  const dls_status status = outcome.status = iterate(work, problem, &outcome, error);
  if (status < 0) return status;
  if (status == DLS_OK) work->escaped = 0;
  memcpy(r, work->best, m * sizeof *r);
  if (u) dlsi_contact_multiply(problem, NULL, r, u, NULL);
  if (info) *info = outcome;
  return status;
}

dls_status dls_augmented_solve(dls_augmented *workspace, const dls_contact *problem, double *r,
                               double *u, dls_info *info, dls_error *error) {
  if (!workspace) return dlsi_at(__func__, dlsi_is_null(error, "workspace"), error);
  const dls_status status = dlsi_check_solve(workspace->d, workspace->nc, problem, r,
                                             workspace->settings.limits.warm_start, error);
  return dlsi_at(__func__,
                 status ? status : dlsi_augmented_solve(workspace, problem, r, u, info, error),
                 error);
}
