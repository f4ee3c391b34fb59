/*
 * auto.c: the method "auto": one method after the other, each from the best r so far, until the
 * certificate holds.
 *
 *   (S1)  accelerated sweeps of Gauss-Seidel (Anderson), in the order of order.c; W dense, up to 130
 *         unknowns: the first ones plain, until they are looked at (C1)
 *   (S3)  ADMM, (F5) below (F1) and (F2). W dense, k >= 150: up to 200 iterations. W by blocks, m >= 150,
 *         perhaps a stack at rest: up to 40, from r = 0 with rho = 1e-7
 *   (S2)  Newton's method
 *         (S3) if not before; (S1) and (S2) three times more
 *   (S4)  the augmented Lagrangian
 *   (S5)  Lemke's method, up to DLS_AUTO_LEMKE_2D or _3D candidates
 *         (S1), (S2), (S1), (S2), (S1)
 *
 * They give way to each other by what they expect to cost yet, in sweeps. With e the residual of the
 * certificate and e* the one that is asked for:
 *
 *   (F1)  sweeps:  log(e / e*) / rate; rate: the mean of the decrease of log e per sweep since the
 *         stage began, sweep k with the weight k, so that it is the last half that counts
 *   (F2)  Newton's method, not begun: s steps, doubled by each failure. W dense: s = d - 1 + min(n / 2, 5),
 *         n the candidates that have changed their state in the last 5 sweeps; else, and when it
 *         has just failed: s = 4
 *   (F3)  Newton's method, under way: log(e / e*) over the last decrease of log e; W dense: the
 *         steps in which a decrease that doubles each time gets there. 6 steps if the first one went
 *         up, which it does where W is singular or the states are not sorted yet
 *   (F4)  a step costs max(5 + k / 12, k / 6) sweeps, 50 at most, k being the unknowns that the states of
 *         r leave; W dense: 5 + 40 k / m at most, because sweeps through a W beyond the cache wait for the
 *         memory, and not less than k^2 / (50 m): k^3 of an LU over k m of a sweep
 *   (F5)  ADMM: 100 + 2 (F4), (F4) as in the cache: some 50 iterations of two sweeps, one to three
 *         factorisations. W by blocks: 3 (F4): a factorisation and a few solves
 *
 *   (C1)  From sweep 10 on (warm: 5; W by blocks: 20, 10; doubled by each failure) sweeps end when
 *         (F1) > (F2) or (F5). After a failure and before they have cost half of (F2), it takes four
 *         times as much: the start of an acceleration is its slowest part.
 *   (C2)  Steps end when p of them brought no new least e of their stage, p = 2, 4, 8, 12, ..
 *         after 0, 1, 2, 3, .. failures; before any failure also when (F3) > (F1) as it was at the
 *         end of the sweeps.
 *   (C3)  W by blocks: ADMM ends when e >= 1 after two iterations, or 16 of them did not halve e.
 *
 * So a wrong forecast costs a few steps first, and is believed less each time. Nothing is measured
 * by a clock: the same input takes the same stages to the same bits.
 *
 * W dense is what an elastic body leaves, regular: the step of Newton's method with the right states
 * is exact in 2D, and two do in 3D. W by blocks comes from many bodies, often rigid ones; it is then
 * singular, and steps converge slowly. Both only bear on the order of the stages.
 *
 * ADMM with a small rho asks first for reactions under which nothing moves, W r = -q, the smallest ones where
 * W is singular, then puts them on their cones: a stack at rest takes it three iterations or a few more,
 * however high. The free velocity q of bodies at rest is that of falling, and -q lies in the cones:
 * here, to a tenth of its size. Bodies in motion are far from that.
 *
 * If (S4) sees the reactions run away and (S5), where there is room for it, finds no solution, the
 * answer is DLS_NO_SOLUTION_LIKELY; DLS_NO_SOLUTION if (S5) has a proof.
 *
 * (F4) was measured up to m = 14004: README.md of this folder, with the command. Of the steps
 * expected, 4 lies between the 2 that Newton's method takes where W is regular and the states are
 * right and the 6 that it takes in all where W is singular and it converges (6 to 8: vi/README.md);
 * n / 2 and 5 were set on the blocks and cubes of bench/solvers. Where (S3) is quicker than more of
 * the others: vi/README.md, and README.md of this folder.
 * What can fail: every method; then DLS_STALLED with the best r.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "front/front.h"

enum { look_every = 5 }; /* sweeps */
enum { steps_expected = 4, steps_after_rise = 6, most_steps_to_sort = 5, most_failures = 5 };
enum { split_unknowns = 150, split_iterations = 200, rest_iterations = 40 }; /* (S3) */
enum { rest_patience = 16 };                                                 /* (C3) */

static const int patience[] = {2, 4, 8, 12, 12, 12}; /* (C2) */

static const double rounding = 1e-9; /* a reaction on its cone but for this much slips */
static const double rest_rho = 1e-7, rest_share = 0.1; /* (S3), (C3) */

struct dlsi_auto {
  dls_solver_settings settings;
  dls_nlgs *sweeps;
  dls_newton *newton;
  dls_admm *admm; /* NULL: m < 150 */
  dls_augmented *augmented;
  dlsi_room room;          /* of the three */
  dlsi_pivoting *pivoting; /* NULL: too large */
  double *r, *best;        /* m each: of the stage, the best so far */

  /* of the solve under way */
  const dls_contact *problem;
  dls_info info;          /* its certificate is that of best */
  int cancelled, limited; /* by the caller's callback, by settings.max_iterations */
  int failures;           /* of Newton's method */
  int has_split;          /* (S3) has been tried */
  int *order, *scratch;   /* nc each: the visits of the sweeps, order.c */
  double steps;           /* of Newton's method, (F2) */
  double ahead;           /* (F1) at the end of the last sweeps */
  dls_status verdict;     /* DLS_NO_SOLUTION_LIKELY, DLS_NO_SOLUTION, or DLS_OK for none */
  /* of the stage under way: */
  double target;        /* the residual */
  double least, last;   /* logarithms of residuals */
  double rate;          /* (F1) */
  int since;            /* step of the least */
  unsigned char *state; /* nc: as r showed them at the last look */

  double memory[]; /* of r and best */
};

/* ---- forecasts ------------------------------------------------------------------------------- */

/* the state of a candidate as its r shows it */
static dls_contact_state state_of(int d, double mu, const double *r) {
  if (!(r[0] > 0)) return DLS_FREE;
  return dlsi_tangent_norm(d, r) < (1 - rounding) * mu * r[0] ? DLS_STICK : DLS_SLIP;
}

/* k of (F4) */
static double unknowns(const dls_contact *problem, const double *r) {
  const int d = problem->d;
  double k = 0;
  for (int c = 0; c < problem->nc; c++, r += d) {
    const dls_contact_state state = state_of(d, problem->mu[c], r);
    k += state == DLS_STICK ? d : state == DLS_FREE ? 0 : problem->mu[c] > 0 ? d - 1 : 1;
  }
  return k;
}

/* how many candidates have changed their state since the last look */
static int look(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const double *r = work->r;
  int changed = 0;
  for (int c = 0; c < problem->nc; c++, r += problem->d) {
    const dls_contact_state state = state_of(problem->d, problem->mu[c], r);
    changed += state != work->state[c];
    work->state[c] = (unsigned char)state;
  }
  return changed;
}

/* (F4); in_cache: without the bound for sweeps that are not */
static double cost_of_step(const dls_contact *problem, const double *r, int in_cache) {
  const double k = unknowns(problem, r), m = (double)problem->d * problem->nc;
  const double cost = fmin(fmax(k / 6, 5 + k / 12), 50);
  if (!problem->W.a) return cost;
  return fmax(in_cache ? cost : fmin(cost, 5 + 40 * k / m), k * k / (50 * m));
}

static double step_cost(const dls_contact *problem, const double *r) {
  return cost_of_step(problem, r, 0);
}

/* The caller's callback, and his limit: 1 to stop. */
static int must_stop(dlsi_auto *work, const dls_progress *p) {
  const dls_solver_settings *s = &work->settings;
  if (s->limits.progress && s->limits.progress(s->limits.progress_data, p))
    return work->cancelled = 1;
  if (s->limits.max_iterations && work->info.iterations + p->iteration >= s->limits.max_iterations)
    return work->limited = 1;
  return 0;
}

/* (F2); changed: how many candidates have changed their state of late */
static double newton_steps(const dlsi_auto *work, int changed) {
  const dls_contact *problem = work->problem;
  if (!problem->W.a) return steps_expected << work->failures;
  return (problem->d - 1 + fmin(0.5 * changed, most_steps_to_sort)) * (1 << work->failures);
}

/* may it be a stack at rest: is -q in the cones */
static int may_rest(const dls_contact *problem) {
  const int d = problem->d;
  const double *q = problem->q;
  double all = 0, outside = 0;
  for (int c = 0; c < problem->nc; c++, q += d) {
    double v[3] = {0}, p[3] = {0};
    for (int i = 0; i < d; i++)
      v[i] = -q[i];
    dlsi_project_cone(d, problem->mu[c], v, p);
    for (int i = 0; i < d; i++) {
      all += v[i] * v[i];
      outside += (v[i] - p[i]) * (v[i] - p[i]);
    }
  }
  return outside <= rest_share * rest_share * all;
}

/* (F5), infinite if ADMM is not to be tried */
static double split_cost(const dlsi_auto *work, const double *r) {
  const dls_contact *problem = work->problem;
  const int foreseen = !work->settings.limits.blocks == !problem->Wb.x;
  const double size = problem->W.a ? unknowns(problem, r) : problem->d * problem->nc;
  if (!foreseen || work->has_split || size < split_unknowns) return INFINITY;
  if (problem->W.a) return 100 + 2 * cost_of_step(problem, r, 1);
  return may_rest(problem) ? 3 * step_cost(problem, r) : INFINITY;
}

/* (C1), before any failure */
static int first_look(const dlsi_auto *work) {
  return (work->problem->W.a ? 5 : 10) << !work->settings.limits.warm_start;
}

/* After a sweep: 1 to leave the rest to another method. */
static int watch_sweeps(void *data, const dls_progress *p) {
  dlsi_auto *work = data;
  if (must_stop(work, p)) return 1;
  const double now = log(p->residual);
  if (p->iteration == 1) work->least = now;
  const double gain = now < work->least ? work->least - now : 0;
  work->least -= gain;
  work->rate += 2. / (p->iteration + 1) * (gain - work->rate);
  if (p->iteration % look_every) return 0;
  const int changed = look(work);
  if (p->iteration < first_look(work) << work->failures) return 0;
  work->ahead = (work->least - log(work->target)) / work->rate; /* (F1) */
  work->steps = newton_steps(work, changed);
  const double newton = work->steps * step_cost(work->problem, work->r); /* (F2) */
  const int early = work->failures && 2 * p->iteration < newton;
  return work->ahead > (early ? 4 : 1) * fmin(newton, split_cost(work, work->r)); /* (C1) */
}

/* After a step: 1 to go back to the sweeps. */
static int watch_steps(void *data, const dls_progress *p) {
  dlsi_auto *work = data;
  if (must_stop(work, p)) return 1;
  const double now = log(p->residual), drop = work->last - now;
  const int first = p->iteration == 1;
  if (first || now < work->least) {
    work->least = now;
    work->since = p->iteration;
  }
  work->last = now;
  if (p->iteration - work->since >= patience[work->failures]) return 1; /* (C2) */
  if (work->failures || (drop <= 0 && !first)) return 0;
  const double alike = (now - log(work->target)) / drop;
  const double steps = drop <= 0            ? steps_after_rise
                       : work->problem->W.a ? ceil(log2(alike + 2) - 1)
                                            : ceil(alike); /* (F3) */
  return steps * step_cost(work->problem, work->best) > work->ahead;
}

static int watch_limits(void *data, const dls_progress *p) {
  return must_stop(data, p);
}

/* (C3) */
static int watch_rest(void *data, const dls_progress *p) {
  dlsi_auto *work = data;
  if (must_stop(work, p)) return 1;
  const double now = log(p->residual);
  if (p->iteration == 1 || now < work->least - log(2)) {
    work->least = now;
    work->since = p->iteration;
  }
  if (p->iteration == 2) return p->residual >= 1;
  return p->iteration - work->since >= rest_patience;
}

/* ---- stages ---------------------------------------------------------------------------------- */

/* A stage begins at r = best. */
static void begin(dlsi_auto *work) {
  const size_t m = (size_t)work->problem->d * (size_t)work->problem->nc;
  const dls_certificate *best = &work->info.certificate;
  const double tol = work->settings.limits.tol, floor = 4 * best->floor;
  memcpy(work->r, work->best, m * sizeof *work->r);
  work->target = floor > tol ? floor : tol;
  work->rate = 0;
  (void)look(work);
}

/* It has ended with r: its line in the report, and best := r if that is better. */
static void end(dlsi_auto *work, dls_method method, int iterations, int factorisations,
                const dls_certificate *now) {
  dls_info *info = &work->info;
  const size_t m = (size_t)work->problem->d * (size_t)work->problem->nc;
  info->stage[info->stages++] = (dls_stage){method, iterations, factorisations, now->residual};
  info->iterations += iterations;
  info->factorisations += factorisations;
  if (!(now->residual < info->certificate.residual)) return;
  info->certificate = *now;
  memcpy(work->best, work->r, m * sizeof *work->r);
}

/* (S1); a warm start for which W r overflows is dropped */
static dls_status sweep(dlsi_auto *work, dls_error *error) {
  (void)error;
  const size_t m = (size_t)work->problem->d * (size_t)work->problem->nc;
  dls_info info;
  begin(work);
  const dls_status status =
      dlsi_nlgs_run(work->sweeps, work->problem, work->order, NULL, work->r, NULL, &info);
  end(work, DLS_NLGS, info.iterations, 0, &info.certificate);
  if (work->info.certificate.residual <= DBL_MAX || work->info.stages > 1) return status;
  memset(work->best, 0, m * sizeof *work->best);
  return sweep(work, error);
}

/* (S2) */
static dls_status newton(dlsi_auto *work, dls_error *error) {
  dls_info info;
  begin(work);
  work->last = log(work->info.certificate.residual);
  const dls_status status =
      dlsi_newton_run(work->newton, work->problem, NULL, work->r, NULL, &info, error);
  if (status < 0) return status;
  end(work, DLS_NEWTON, info.iterations, info.factorisations, &info.certificate);
  if (work->failures < most_failures) work->failures++;
  work->steps = steps_expected << work->failures;
  return status;
}

/* (S3): where it promises to cost less than more of the others */
static dls_status split(dlsi_auto *work, dls_error *error) {
  dls_info info;
  const double cost = split_cost(work, work->best);
  const double newton = work->steps * step_cost(work->problem, work->best);
  if (!(work->ahead > cost && newton > cost)) return DLS_STALLED;
  dls_error why;
  work->has_split = 1;
  begin(work);
  const dls_status status = dlsi_admm_solve(work->admm, work->problem, work->r, NULL, &info, &why);
  if (status == DLS_E_UNSUPPORTED) return DLS_STALLED; /* a build without MUMPS */
  if (status < 0) {
    if (error) *error = why;
    return status;
  }
  end(work, DLS_ADMM, info.iterations, info.factorisations, &info.certificate);
  return status;
}

/* (S4) */
static dls_status augment(dlsi_auto *work, dls_error *error) {
  dls_info info;
  begin(work);
  const dls_status status =
      dlsi_augmented_solve(work->augmented, work->problem, work->r, NULL, &info, error);
  if (status < 0) return status;
  end(work, DLS_AUGMENTED_LAGRANGIAN, info.iterations, info.factorisations, &info.certificate);
  if (status == DLS_STALLED && dls_augmented_direction(work->augmented))
    work->verdict = DLS_NO_SOLUTION_LIKELY;
  return status;
}

/* (S5) */
static dls_status pivot(dlsi_auto *work, dls_error *error) {
  dls_info info;
  if (!work->pivoting) return DLS_STALLED;
  begin(work);
  const dls_status status =
      dlsi_pivoting_solve(work->pivoting, work->problem, work->r, NULL, &info, error);
  if (status < 0) return status;
  end(work, DLS_LEMKE, info.iterations, 0, &info.certificate);
  if (status == DLS_NO_SOLUTION) work->verdict = status;
  return status;
}

typedef dls_status stage(dlsi_auto *work, dls_error *error);

static stage *const stages[] = {sweep, split,  newton, split,  sweep,   newton,
                                sweep, newton, sweep,  newton, augment, pivot,
                                sweep, newton, sweep,  newton, sweep};
_Static_assert(sizeof stages / sizeof stages[0] <= DLS_STAGES_MAX, "a line for each in the report");

static dls_status create_rest(dlsi_auto *work, int d, int nc, dls_error *error);

/* The stages in turn: DLS_OK, an error, or the reason for the end. */
static dls_status run(dlsi_auto *work, dls_error *error) {
  for (size_t k = 0; k < sizeof stages / sizeof stages[0]; k++) {
    dls_status status = DLS_OK;
    if (k == 1 && !work->newton)
      status = create_rest(work, work->problem->d, work->problem->nc, error);
    if (!status) status = stages[k](work, error);
    if (status < 0) return status;
    if (dls_certificate_holds(&work->info.certificate, work->settings.limits.tol)) return DLS_OK;
    if (work->cancelled) return DLS_CANCELLED;
    if (work->limited) return DLS_MAX_ITERATIONS;
    if (stages[k] == pivot && work->verdict) return work->verdict;
  }
  return DLS_STALLED;
}

dls_status dlsi_auto_solve(dlsi_auto *work, const dls_contact *problem, double *r, double *u,
                           dls_info *info, dls_error *error) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const dls_info nothing = {.method = DLS_AUTO, .certificate = {.residual = INFINITY}};
  work->problem = problem;
  work->info = nothing;
  work->cancelled = work->limited = work->failures = work->has_split = 0;
  work->verdict = DLS_OK;
  work->ahead = INFINITY; /* of sweeps that end before they can tell */
  work->steps = newton_steps(work, 0);
  double *const key[] = {work->memory, work->memory + problem->nc, work->memory + 2 * problem->nc};
  dlsi_order_candidates(problem, key, work->scratch, work->order);
  if (work->settings.limits.warm_start)
    memcpy(work->best, r, m * sizeof *r);
  else
    memset(work->best, 0, m * sizeof *r);
  const dls_status status = run(work, error);
  if (status < 0) return status;
  memcpy(r, work->best, m * sizeof *r);
  if (u) dlsi_contact_multiply(problem, NULL, r, u, NULL);
  work->info.status = status;
  if (info) *info = work->info;
  return status;
}

const double *dlsi_auto_direction(const dlsi_auto *work) {
  return dls_augmented_direction(work->augmented);
}

/* ---- create ---------------------------------------------------------------------------------- */

static dls_status create_sweeps(dlsi_auto *work, int d, int nc, dls_error *error) {
  dls_nlgs_settings s;
  dls_nlgs_settings_init(&s);
  s.limits.tol = work->settings.limits.tol;
  s.limits.warm_start = 1;
  s.acceleration = DLS_ACCELERATION_ANDERSON;
  s.limits.progress = watch_sweeps;
  s.limits.progress_data = work;
  return dls_nlgs_create(&work->sweeps, d, nc, &s, error);
}

static dls_status create_newton(dlsi_auto *work, int d, int nc, dls_error *error) {
  dls_newton_settings s;
  dls_newton_settings_init(&s);
  s.limits.tol = work->settings.limits.tol;
  s.limits.warm_start = 1;
  s.sweeps = 0;
  s.limits.blocks = work->settings.limits.blocks;
  if (work->settings.positive_definite) s.regularization = 0;
  s.limits.progress = watch_steps;
  s.limits.progress_data = work;
  return dlsi_newton_create(&work->newton, d, nc, &s, &work->room, error);
}

static dls_status create_admm(dlsi_auto *work, int d, int nc, dls_error *error) {
  if (d * nc < split_unknowns) return DLS_OK;
  const int blocks = work->settings.limits.blocks;
  dls_admm_settings s;
  dls_admm_settings_init(&s);
  s.limits.tol = work->settings.limits.tol;
  s.limits.max_iterations = blocks ? rest_iterations : split_iterations;
  s.limits.warm_start = !blocks;
  s.limits.blocks = blocks;
  if (blocks) s.rho = rest_rho;
  s.limits.progress = blocks ? watch_rest : watch_limits;
  s.limits.progress_data = work;
  return dlsi_admm_create(&work->admm, d, nc, &s, &work->room, error);
}

static dls_status create_augmented(dlsi_auto *work, int d, int nc, dls_error *error) {
  dls_augmented_settings s;
  dls_augmented_settings_init(&s);
  s.limits.tol = work->settings.limits.tol;
  s.limits.blocks = work->settings.limits.blocks;
  s.limits.warm_start = 1;
  s.limits.progress = watch_limits;
  s.limits.progress_data = work;
  return dlsi_augmented_create(&work->augmented, d, nc, &s, &work->room, error);
}

static dls_status create_pivoting(dlsi_auto *work, int d, int nc, dls_error *error) {
  if (nc > (d == 2 ? DLS_AUTO_LEMKE_2D : DLS_AUTO_LEMKE_3D)) return DLS_OK;
  dls_solver_settings s = work->settings;
  s.limits.max_iterations = 0;
  s.limits.warm_start = 0;
  s.limits.progress = watch_limits;
  s.limits.progress_data = work;
  return dlsi_pivoting_create(&work->pivoting, d, nc, &s, error);
}

/* What the stages after the first need. */
static dls_status create_rest(dlsi_auto *work, int d, int nc, dls_error *error) {
  dls_status status = create_newton(work, d, nc, error);
  if (!status) status = create_admm(work, d, nc, error);
  if (!status) status = create_augmented(work, d, nc, error);
  if (!status) status = create_pivoting(work, d, nc, error);
  return status;
}

dls_status dlsi_auto_create(dlsi_auto **out, int d, int nc, const dls_solver_settings *settings,
                            int complete, dls_error *error) {
  *out = NULL;
  const size_t m = (size_t)d * (size_t)nc;
  const size_t n = (size_t)nc;
  dlsi_auto *work = dlsi_alloc(1, sizeof *work + 2 * m * sizeof *work->memory +
                                      n * (2 * sizeof *work->order + sizeof *work->state));
  if (!work) return dlsi_no_memory(error);
  memset(work, 0, sizeof *work);
  work->settings = *settings;
  work->r = work->memory;
  work->best = work->memory + m;
  work->order = (void *)(work->memory + 2 * m);
  work->scratch = work->order + n;
  work->state = (unsigned char *)(work->scratch + n);
  dls_status status = create_sweeps(work, d, nc, error);
  if (!status && complete) status = create_rest(work, d, nc, error);
  if (status) {
    dlsi_auto_destroy(work);
    return status;
  }
  *out = work;
  return DLS_OK;
}

void dlsi_auto_destroy(dlsi_auto *work) {
  if (!work) return;
  dls_nlgs_destroy(work->sweeps);
  dls_newton_destroy(work->newton);
  dls_admm_destroy(work->admm);
  dls_augmented_destroy(work->augmented);
  dlsi_pivoting_destroy(work->pivoting);
  dlsi_room_free(&work->room);
  free(work);
}
