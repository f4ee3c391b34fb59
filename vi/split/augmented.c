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
 * The regularised problem is u = W r + q with this r; then lambda := r, (35), (36).
 *
 * It is the proximal point method. Put v = u + (r - lambda) / eps. Then lambda - eps u = r - eps v,
 * and (32)-(34) read r_n = < r_n - eps v_n >, r_t = r_t - eps v_t put on the disc of radius mu r_n.
 * These are the laws of contact and friction for r and v, whatever eps > 0. So the regularised
 * problem is a contact problem again,
 *
 *   v = (W + E) r + (q - E lambda),   E = diag(1 / eps_c),
 *
 * which for eps_c = 1 / (alpha w_c) is the step W + alpha D, q - alpha D lambda of that method, D =
 * diag(w_c). E > 0 makes a singular W regular and damps cycles. One augmentation:
 *
 *   (AU1)  A = W + s E,   b = q - s E lambda
 *   (AU2)  x = the solution of v = A x + b: newton.c from lambda, that is up to 20 sweeps of
 *          Gauss-Seidel, then Newton steps
 *   (AU3)  lambda := x  if (AU2) succeeded, or if x halves the residual of lambda for W and q
 *   (AU4)  if adaptive:  s := 2 s    if (AU2) failed;   0.8 s  if it has failed before;
 *                        0.2 s  else;  from s = 1, 1e-7 <= s <= 1e3
 *
 * Target of (AU2), for both parts of the residual: 1/1000 of the residual of lambda, but at least
 * 1/10 of the final target; in the last augmentation allowed, that 1/10. One augmentation from
 * lambda = 0 is the penalty method; its r is off by about E r.
 *
 * Stop: the certificate of x for the user's W and q holds. DLS_STALLED: (AU2) failed while s was
 * fixed, or while s was at its bound and lambda stayed; or 150 augmentations reduced the residual
 * by less than 10 %; or 10 times in a row, failures of (AU2) not counted,
 *
 *   (AU5)  |W delta| < 1e-4 |delta|, q.delta < -1e-4 |q| |delta|,   delta = x - lambda of (AU2),
 *          in the norms |D^-1/2 u| and |D^1/2 r|. Without a solution lambda grows along such a
 *          delta without end. It seldom does so on its way to a far solution: hence 10.
 *
 *   (AU6)  a stage that auto ends early keeps lambda, s and whether (AU2) has failed. The next one
 *          goes on from there, unless its start has less than 1/10 of the residual. auto bounds
 *          the factorisations of such a stage
 *
 * A warm start for which W r overflows is dropped.
 *
 * Source: [Chabrand 1998] 4.1. Errors there: with Delta xi = f_s / eps_T as printed, (34) must
 * subtract eps_T Delta xi, as in (31); (36) then makes lambda_t the r_t of (34). The increments of
 * (33) add up to lambda_t - eps u_t, u_t the whole slip of the step. Deviations: Newton's unknown
 * is r, not the displacement: the solution is the same, and a large eps does not spoil the
 * conditioning. eps_T = eps_N = eps_c: w_c is the mean over both directions. Schedule (AU4): the
 * paper says of eps that it needs precautions; too small an s fails in (AU2), too large an s
 * converges slowly.
 *
 * Cost of an augmentation: up to 20 sweeps, and 0 to 30 Newton steps, each an LU of the unknowns.
 * What can fail: (AU2) for every s, if friction makes even W + s E cycle, or W is indefinite. With
 * friction convergence is not guaranteed. Without friction, and with W positive semidefinite, the
 * augmentations converge.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "vi/vi_internal.h"

enum { newton_steps = 30 }; /* more than (AU2) takes */
enum { most_augmentations = 400, augmented_patience = 150, escapes_to_believe = 10 };

static const double far_better = 0.1; /* (AU6) */
static const double shrink_at_first = 0.2, shrink = 0.8, grow = 2, smallest = 1e-7, largest = 1e3;

/* Factor of the penalty method: eps_c in 1 / w_c. */
static const double large_penalty = 1e6;

struct dls_augmented {
  dls_augmented_settings settings;
  int d, nc;
  dls_method method;      /* DLS_PENALTY: one augmentation, from r = 0 */
  int stage;              /* of auto: from the given r */
  int factorisations;     /* of this run so far */
  int most_factors;       /* of a run; 0: any number */
  double left, s;         /* (AU6): residual when the last run ended, 0: nothing is left; factor */
  int failed;             /* (AU4): some (AU2) failed */
  int escaped;            /* 1: `direction` holds one that (AU5) accepted */
  dlsi_iterate it;        /* its u is that of x */
  double *penalty;        /* eps_c as given, if settings.penalty: nc */
  double *E, *sE;         /* 1 / eps_c at s = 1, (AU1): nc */
  double *b, *lambda, *x; /* (AU1): m */
  double *delta;          /* x - lambda: m */
  double *direction;      /* m */
  dls_newton *newton;     /* (AU2) */
  dlsi_formed formed;     /* W of bodies by blocks */
};

void dls_augmented_settings_init(dls_augmented_settings *settings) {
  if (!settings) return;
  *settings = (dls_augmented_settings){.size = sizeof *settings, .factor = 100, .adaptive = 1};
  dlsi_limits_init(&settings->limits);
}

static dls_status augmented_check(int d, int nc, const dls_augmented_settings *s,
                                  dls_error *error) {
  const dlsi_setting own[] = {{"factor", s->factor, 1 / DBL_MAX, DBL_MAX, 0},
                              {"adaptive", s->adaptive, 0, 1, 0}};
  dls_status status = dlsi_check_sizes(d, nc, error);
  if (!status) status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 2, own, error);
  if (!status && s->penalty) status = dlsi_check_vector("penalty", s->penalty, (size_t)nc, error);
  for (int c = 0; !status && s->penalty && c < nc; c++) /* > 0 with a reciprocal */
    if (!(s->penalty[c] > 0 && 1 / s->penalty[c] <= DBL_MAX))
      return dlsi_fail(error, DLS_E_ARGUMENT, "penalty", c, s->penalty[c], "is %g, must be > 0",
                       s->penalty[c]);
  return status;
}

static void augmented_carve(void *workspace, dlsi_arena *arena) {
  dls_augmented *work = workspace;
  const size_t n = (size_t)work->nc;
  double **const of_candidates[] = {&work->penalty, &work->E, &work->sE};
  double **const vectors[] = {&work->b, &work->lambda, &work->x, &work->delta, &work->direction};
  dlsi_iterate_carve(&work->it, arena, work->d, work->nc, &work->settings.limits);
  dlsi_take_vectors(arena, n, 3, of_candidates);
  dlsi_take_vectors(arena, (size_t)work->d * n, 5, vectors);
}

static dls_status augmented_create(void **out, int d, int nc,
                                   const dls_augmented_settings *settings, dls_method method,
                                   const dlsi_options *options, dls_error *error) {
  dls_augmented filled = {.d = d, .nc = nc, .method = method, .stage = options->stage}, *work;
  dls_newton_settings newton;
  dls_newton_settings_init(&newton);
  dls_augmented_settings_init(&filled.settings);
  if (settings) filled.settings = *settings;
  newton.limits.blocks = filled.settings.limits.blocks;
  *out = NULL;
  dls_status status = augmented_check(d, nc, &filled.settings, error);
  if (!status) status = dlsi_newton_create(&filled.newton, d, nc, &newton, options->room, error);
  if (!status) status = dlsi_workspace(out, &filled, sizeof filled, augmented_carve, nc, error);
  if (status) {
    dls_newton_destroy(filled.newton);
    return status;
  }
  work = *out;
  if (!work->settings.penalty) return DLS_OK;
  memcpy(work->penalty, work->settings.penalty, (size_t)nc * sizeof *work->penalty);
  work->settings.penalty = work->penalty;
  return DLS_OK;
}

dls_status dls_augmented_create(dls_augmented **out, int d, int nc,
                                const dls_augmented_settings *settings, dls_error *error) {
  DLSI_DOOR;
  void *work = NULL;
  const dls_status status = out ? augmented_create(&work, d, nc, settings, DLS_AUGMENTED_LAGRANGIAN,
                                                   &(dlsi_options){0}, error)
                                : dlsi_is_null(error, "out");
  if (out) *out = work;
  return dlsi_at(__func__, status, error);
}

void dls_augmented_destroy(dls_augmented *workspace) {
  if (!workspace) return;
  dls_newton_destroy(workspace->newton);
  dlsi_formed_free(&workspace->formed);
  free(workspace);
}

const double *dlsi_augmented_direction(const void *workspace) {
  const dls_augmented *work = workspace;
  return work && work->escaped ? work->direction : NULL;
}

/* ---- one augmentation ------------------------------------------------------------------------ */

/* Returns how many steps Newton's method may take; 0: as many as it does. */
static int augmented_steps(const dls_augmented *work, int factorisations) {
  const int left = work->most_factors - factorisations;
  return !work->most_factors || left >= newton_steps ? 0 : left > 1 ? left : 1;
}

/* (AU1), (AU2) Computes x from lambda; DLS_OK if its residual is <= target for the user's |q|. */
static dls_status augmented_regularise(dls_augmented *work, const dls_contact *problem, double s,
                                       double target, int *factorisations, dls_error *error) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  for (size_t c = 0; c < m / d; c++)
    work->sE[c] = s * work->E[c];
  for (size_t k = 0; k < m; k++)
    work->b[k] = problem->q[k] - work->sE[k / d] * work->lambda[k];
  const double size_q = dlsi_norm2(problem->q, m), size_b = dlsi_norm2(work->b, m);
  dls_contact regularised = *problem;
  regularised.q = work->b;
  memcpy(work->x, work->lambda, m * sizeof *work->x);
  /* |F| <= target |q|; the force residual stays relative to |x| */
  const double share = size_b > size_q ? size_q / size_b : 1;
  const dls_limits limits = {.tol = target * share,
                             .warm_start = 1,
                             .max_iterations = augmented_steps(work, *factorisations),
                             .cpu_seconds =
                                 dlsi_clock_left(&work->settings.limits, work->it.begun)};
  dls_info info;
  dlsi_set_limits(&dlsi_newton_method, work->newton, &limits);
  const dls_status status =
      dlsi_newton_run(work->newton, &regularised, work->sE, work->x, NULL, &info, error);
  if (status >= 0) *factorisations += info.factorisations;
  return status;
}

/* (AU5) delta := x - lambda, its largest entry +-1. Returns 1 if the reactions run away along it.
 * Scratch: all arrays of `it` except best. */
static int augmented_escapes(const dls_augmented *work, const dls_contact *problem) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  double *delta = work->delta, *v = work->it.u;
  for (size_t k = 0; k < m; k++)
    delta[k] = work->x[k] - work->lambda[k];
  const double size = dlsi_max_abs(delta, m);
  if (!(size > 0 && size <= DBL_MAX)) return 0;
  for (size_t k = 0; k < m; k++)
    delta[k] /= size;
  dlsi_contact_apply(problem, delta, v);
  const double most = dlsi_max_abs(work->it.w, m / d);
  double gain = 0; /* q.delta */
  for (size_t k = 0; k < m; k++) {
    const double root = sqrt(work->it.w[k / d] / most); /* powers of two change no bit */
    gain += problem->q[k] * delta[k];
    v[k] /= root;
    work->it.a[k] = problem->q[k] / root;
    work->it.F[k] = delta[k] * root;
  }
  const double length = dlsi_norm2(work->it.F, m);
  return dlsi_norm2(v, m) < 1e-4 * length * most &&
         gain < -1e-4 * length * dlsi_norm2(work->it.a, m);
}

/* ---- the augmentations ----------------------------------------------------------------------- */

static const char *augmented_name(const dls_augmented *work) {
  return work->method == DLS_PENALTY ? "penalty" : "augmented-lagrangian";
}

/* Augments from lambda, measured last, until the certificate holds. Returns DLS_OK, or the reason
 * to stop before. */
static dls_status augmented_iterate(dls_augmented *work, const dls_contact *problem,
                                    dls_info *outcome, dls_error *error) {
  const dls_augmented_settings *settings = &work->settings;
  const dls_limits *limits = &settings->limits;
  dlsi_iterate *it = &work->it;
  const dls_certificate *best = &it->certificate;
  const int most =
      work->method == DLS_PENALTY ? 1 : dlsi_most_iterations(limits, most_augmentations);
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  double residual = best->residual, milestone = residual;
  int passed = 0, escaping = 0; /* augmentation of the milestone; (AU5) so often in a row */
  for (int k = 1; !dls_certificate_holds(best, it->tol); k++) {
    if (k > most) return DLS_MAX_ITERATIONS;
    const double wanted = 0.1 * dlsi_target(it->tol, fmin(best->floor_u, best->floor_r));
    const double target = k < most && 1e-3 * residual > wanted ? 1e-3 * residual : wanted;
    const dls_status status =
        augmented_regularise(work, problem, work->s, target, &outcome->factorisations, error);
    if (status < 0) return status;
    const int solved = status == DLS_OK;
    outcome->iterations = k;
    work->factorisations = outcome->factorisations;
    const dls_certificate now = dlsi_iterate_offer(it, problem, work->x);
    if (solved) { /* (AU5) */
      escaping = augmented_escapes(work, problem) ? escaping + 1 : 0;
      work->escaped = escaping > 0;
      if (escaping) memcpy(work->direction, work->delta, m * sizeof *work->direction);
    }
    const int moved = solved || now.residual < residual / 2;
    if (moved) { /* (AU3) */
      memcpy(work->lambda, work->x, m * sizeof *work->lambda);
      residual = now.residual;
    }
    const int stuck = !solved && (!settings->adaptive || (!moved && work->s >= largest));
    if (settings->adaptive) { /* (AU4) */
      work->failed |= !solved;
      work->s *= !solved ? grow : work->failed ? shrink : shrink_at_first;
      work->s = work->s < smallest ? smallest : work->s > largest ? largest : work->s;
    }
    if (best->residual < 0.9 * milestone) {
      milestone = best->residual;
      passed = k;
    }
    const dls_status stop =
        dlsi_iterate_tell(it, augmented_name(work), k, most, now.residual, work->x);
    if (dls_certificate_holds(best, it->tol)) break;
    if (stop) work->left = best->residual; /* (AU6) */
    if (stop) return stop;
    if (stuck || k - passed >= augmented_patience || escaping >= escapes_to_believe)
      return DLS_STALLED;
  }
  return DLS_OK;
}

static dls_status augmented_run(void *workspace, const dls_contact *problem, double *r, double *u,
                                dls_info *info, dls_error *error) {
  dls_augmented *work = workspace;
  const dls_augmented_settings *s = &work->settings;
  const int warm = work->stage || (s->limits.warm_start && work->method != DLS_PENALTY);
  dls_info outcome = {.method = work->method};
  work->escaped = work->factorisations = 0;
  dlsi_iterate_begin(&work->it, problem, NULL, s->limits.tol, warm, r, work->x);
  for (int c = 0; c < problem->nc; c++)
    work->E[c] = s->penalty ? 1 / s->penalty[c] : work->it.w[c] / s->factor;
  (void)dlsi_iterate_start(&work->it, problem, work->x);
  if (!(work->left > 0 && work->it.certificate.residual >= far_better * work->left)) { /* (AU6) */
    memcpy(work->lambda, work->x, (size_t)problem->d * (size_t)problem->nc * sizeof *work->x);
    work->s = 1;
    work->failed = 0;
  }
  work->left = 0;
  const dls_status status = augmented_iterate(work, problem, &outcome, error);
  if (status == DLS_OK) work->escaped = 0;
  return dlsi_iterate_end(&work->it, problem, status, &outcome, r, u, info);
}

dls_status dls_augmented_solve(dls_augmented *workspace, const dls_contact *problem, double *r,
                               double *u, dls_info *info, dls_error *error) {
  DLSI_DOOR;
  dls_status status = dlsi_iterate_enter(workspace ? &workspace->it : NULL, problem, r, u, error);
  if (status) return dlsi_at(__func__, status, error);
  if (dlsi_is_empty(problem, &workspace->settings.limits, DLS_AUGMENTED_LAGRANGIAN,
                    "augmented-lagrangian", info))
    return dlsi_leave(&workspace->it.busy, DLS_OK);
  status = dlsi_form_blocks(&workspace->formed, &problem, error);
  if (!status) status = augmented_run(workspace, problem, r, u, info, error);
  status = dlsi_iterate_leave(&workspace->it, augmented_name(workspace), status, r);
  return dlsi_at(__func__, status, error);
}

/* ---- in the table of methods ----------------------------------------------------------------- */

static dls_status augmented_create_by(void **out, int d, int nc, const dlsi_options *options,
                                      dls_error *error) {
  dls_augmented_settings s;
  dls_augmented_settings_init(&s);
  s.limits = options->limits;
  return augmented_create(out, d, nc, &s, DLS_AUGMENTED_LAGRANGIAN, options, error);
}

/* Creates for one augmentation from r = 0 with a large, fixed penalty. */
static dls_status penalty_create_by(void **out, int d, int nc, const dlsi_options *options,
                                    dls_error *error) {
  dls_augmented_settings s;
  dls_augmented_settings_init(&s);
  s.limits = options->limits;
  s.factor = large_penalty;
  s.adaptive = 0;
  return augmented_create(out, d, nc, &s, DLS_PENALTY, options, error);
}

static void augmented_destroy(void *work) {
  dls_augmented_destroy(work);
}

void dlsi_augmented_forget(void *work) {
  ((dls_augmented *)work)->left = 0;
}

void dlsi_augmented_allow(void *work, int factorisations) {
  ((dls_augmented *)work)->most_factors = factorisations;
}

int dlsi_augmented_factorisations(const void *work) {
  return ((const dls_augmented *)work)->factorisations;
}

const dlsi_method dlsi_augmented_method = {
    .method = DLS_AUGMENTED_LAGRANGIAN,
    .name = "augmented-lagrangian",
    .summary = "proximal point method: where the others cycle or crawl",
    .create = augmented_create_by,
    .solve = augmented_run,
    .destroy = augmented_destroy,
    .limits = offsetof(dls_augmented, settings.limits),
    .direction = dlsi_augmented_direction,
};

const dlsi_method dlsi_penalty_method = {
    .method = DLS_PENALTY,
    .name = "penalty",
    .summary = "its first step with large penalties: to see its error",
    .create = penalty_create_by,
    .solve = augmented_run,
    .destroy = augmented_destroy,
    .limits = offsetof(dls_augmented, settings.limits),
    .direction = dlsi_augmented_direction,
};
