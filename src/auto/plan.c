/*
 * plan.c: recognises the kind of the problem; the plan of each kind; the steps that it allows.
 *
 * A dense W usually comes from an elastic body, and is regular. W by blocks usually comes from many
 * bodies, often rigid ones; it is then singular, and Newton's method converges slowly.
 *
 *   elastic   W dense, or by blocks with at least 25 % of all blocks (up to 100
 *             contacts: all blocks)
 *   few       W by blocks, but not all blocks, up to 100 contacts
 *   packing   W by blocks, more than 100 contacts
 *   tight     a packing of more than 1000 contacts; or one that is not at rest and whose bodies
 *             have at least d + 1 contacts each, as many as hold them with friction, so that each
 *             contact has 2 d neighbours. Looser packings converge in about ten sweeps
 *
 * At rest: -q lies in the friction cones up to 10 % of its length, as the velocity of a free fall,
 * or contacts have at most three neighbours on average: a factorisation costs a few sweeps then.
 */
#include <limits.h>
#include <math.h>

#include "auto/auto.h"

_Static_assert(2 * (int)dlsi_auto_early_rows <= 3 * (int)dlsi_auto_small,
               "early pivots work on a copy");

int dlsi_auto_is_packing(const dlsi_auto *work) {
  return work->problem->nc > dlsi_auto_few && !dlsi_is_elastic(work->problem);
}

int dlsi_auto_is_few(const dlsi_auto *work) {
  const dls_blocks *W = &work->problem->Wb;
  const int nc = work->problem->nc;
  return W->x && nc <= dlsi_auto_few && W->p[nc] < nc * nc;
}

static int may_push(const dlsi_auto *work) {
  return !dlsi_is_elastic(work->problem) && !dlsi_auto_has_pushed(work);
}

static int is_tight(const dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  return problem->Wb.x && problem->Wb.p[problem->nc] / (2 * problem->d + 1) >= problem->nc &&
         !dlsi_auto_looks_at_rest(work);
}

/* On a packing only first of all, or once the augmented Lagrangian has failed, too. */
int dlsi_auto_may_sweep(const dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  if (!dlsi_auto_is_packing(work)) return 1;
  if (problem->nc > dlsi_auto_many) return 0;
  return work->history.taken[AUGMENTED] || (work->info.stages == 0 && !is_tight(work));
}

dls_regime dlsi_auto_regime(const dlsi_auto *work) {
  if (dlsi_auto_has_plan(work)) return DLS_REGIME_GIVEN;
  if (dlsi_auto_is_packing(work))
    return dlsi_auto_may_sweep(work) ? DLS_REGIME_PACKING : DLS_REGIME_TIGHT;
  return dlsi_auto_is_few(work) ? DLS_REGIME_FEW : DLS_REGIME_ELASTIC;
}

int dlsi_auto_is_near(const dlsi_auto *work, double residual) {
  return residual <= dlsi_auto_push_near * pow(10, -dlsi_auto_failures(work));
}

static int may_step(const dlsi_auto *work) {
  return !dlsi_auto_is_packing(work) || dlsi_auto_is_near(work, work->info.certificate.residual) ||
         work->history.taken[AUGMENTED];
}

int dlsi_auto_looks_at_rest(const dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const int d = problem->d;
  const double *q = problem->q;
  double all = 0, outside = 0;
  if (problem->W.a || d * problem->nc < dlsi_auto_rest_least) return 0;
  if (dlsi_auto_is_left_out(work, REST)) return 0;
  const int told = work->options.limits.blocks; /* of bodies */
  const int blocks = problem->Wb.x ? problem->Wb.p[problem->nc] : told > 1 ? told : INT_MAX;
  if (blocks / problem->nc <= dlsi_auto_loose_blocks) return 1;
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
  return outside <= dlsi_auto_share_outside * dlsi_auto_share_outside * all;
}

/* Returns the sweeps that a factorisation takes in the order of the numbers, from the mean width of
 * its columns: few for rows of bodies, far too many for a packing. W by blocks. */
static double fill_as_numbered(const dls_contact *problem) {
  const dls_blocks *W = &problem->Wb;
  double sum = 0;
  for (int c = 0; c < problem->nc; c++) {
    int first = c;
    for (int k = W->p[c]; k < W->p[c + 1]; k++)
      first = W->i[k] < first ? W->i[k] : first;
    sum += c - first;
  }
  return problem->d * sum * (sum / problem->nc) / (2. * W->p[problem->nc]);
}

double dlsi_auto_first_try(const dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  if (work->info.at_rest) return 0;
  const int out = problem->W.a || dlsi_auto_is_left_out(work, REST) || dlsi_auto_has_plan(work);
  if (out || problem->d * problem->nc < dlsi_auto_rest_least) return INFINITY;
  if (!problem->Wb.x) return dlsi_auto_sweeps_before;
  const double fill = fill_as_numbered(problem);
  return fmin(fmax(4 * fill, 2 * dlsi_auto_first_sweeps), dlsi_auto_sweeps_before);
}

static int may_rest(const dlsi_auto *work) {
  const dls_info *info = &work->info;
  const dlsi_auto_history *h = &work->history;
  if (dlsi_auto_sweeps(work) < work->convex_from || work->convex_from == 0 || info->stages == 0)
    return work->convex_from == 0;
  const int yields = h->taken[h->last] && h->ended[h->last] == DLS_REASON_COSTLIER;
  return (yields || dlsi_auto_has_pushed(work)) &&
         !dlsi_auto_is_near(work, info->certificate.residual);
}

int dlsi_auto_may_take_turn(const dlsi_auto *work) {
  return !dlsi_auto_has_augmented(work) &&
         (dlsi_auto_has_pushed(work) || (work->turn > 0 && dlsi_auto_sweeps(work) >= work->turn));
}

int dlsi_auto_may_augment_early(const dlsi_auto *work) {
  return work->d == 3 && work->problem->W.a && 3 * work->problem->nc <= dlsi_auto_few_rows;
}

int dlsi_auto_has_splitting(const dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  return problem->W.a && !work->history.taken[SPLITTING] &&
         problem->d * problem->nc >= dlsi_auto_split_least;
}

static int may_split(const dlsi_auto *work) {
  if (!dlsi_auto_has_splitting(work)) return 0;
  const int dear = work->ahead > 0 && dlsi_auto_cost_of_split(work) > 2 * work->ahead;
  return work->costly || dlsi_auto_failures(work) > dear;
}

int dlsi_auto_may_copy(const dlsi_auto *work) {
  return work->problem->d * work->problem->nc <= dlsi_auto_small;
}

/* Returns 1 if an infinite friction keeps pivots and paths away. */
static int is_bonded(const dlsi_auto *work) {
  return work->bonded && !work->firm;
}

int dlsi_auto_may_pivot(const dlsi_auto *work) {
  const int late = work->d * work->nc > dlsi_auto_small;
  const int rows = (work->d == 1 ? 2 : work->d == 2 ? 4 : 10) * work->nc; /* of the LCP */
  if (late && !work->problem->W.a) return 0; /* of bodies: far too many pivots */
  return !is_bonded(work) && rows <= (late ? dlsi_auto_large : DLS_AUTO_LEMKE_ROWS);
}

/* Returns 1 for pivots and, in 3D, for the homotopy if the table of the pivots is small: 3 rows a
 * contact in 2D, 10 in 3D. The facets of Lemke's method in 3D take a hundred times the homotopy's
 * iterations. */
int dlsi_auto_may_go_early(const dlsi_auto *work, part k) {
  return (k == HOMOTOPY) == (work->d == 3) &&
         (work->d == 2 ? 3 : 10) * work->nc <= dlsi_auto_early_rows;
}

int dlsi_auto_may_follow_path(const dlsi_auto *work) {
  return !is_bonded(work) && dlsi_auto_may_copy(work);
}

int dlsi_auto_may_go_another_way(const dlsi_auto *work) {
  return work->problem->d * work->problem->nc <= dlsi_auto_large;
}

int dlsi_auto_may_settle(const dlsi_auto *work) {
  return work->info.certificate.residual <= 100 * fmax(work->options.limits.tol, 1e-8);
}

/* Not: what a method alone refuses; the convex problem of a dense W; searches without end. */
int dlsi_auto_can_take(const dlsi_auto *work, part k) {
  const int searches = k == HOMOTOPY || k == SCATTER;
  if (k == REST) return !work->problem->W.a;
  if (searches && !dlsi_auto_may_go_another_way(work)) return 0;
  return !is_bonded(work) || !(searches || k == PIVOTING);
}

/* ---- the plans: the first r that the certificate accepts ends them --------------------------- */

const step_kind dlsi_auto_kind[parts] = {
    [SWEEPS] = {DLS_STEP_ANDERSON, &dlsi_nlgs_method, dlsi_auto_may_sweep, 0},
    [SPLITTING] = {DLS_STEP_SPLITTING, &dlsi_admm_method, may_split, dlsi_auto_splits},
    [REST] = {DLS_STEP_CONVEX, &dlsi_rest_method, may_rest, 0},
    [NEWTON] = {DLS_STEP_NEWTON, &dlsi_newton_method, may_step, 0},
    [AUGMENTED] = {DLS_STEP_AUGMENTED, &dlsi_augmented_method, NULL, 0},
    [PIVOTING] = {DLS_STEP_LEMKE, &dlsi_lemke_method, dlsi_auto_may_pivot, 0},
    [COLD_SPLITTING] = {DLS_STEP_COLD_SPLITTING, &dlsi_admm_method, NULL, 2000},
    [HOMOTOPY] = {DLS_STEP_HOMOTOPY, &dlsi_homotopy_method, dlsi_auto_may_follow_path, 0},
    [SCATTER] = {DLS_STEP_SCATTER, &dlsi_scatter_method, dlsi_auto_may_follow_path, 0},
    [PUSH] = {DLS_STEP_MOMENTUM, &dlsi_nlgs_method, may_push, 1000000},
    [SETTLE] = {DLS_STEP_NEAR_SPLITTING, &dlsi_admm_method, dlsi_auto_may_settle, 20000},
};

/* Elastic bodies. */
static const step elastic[] = {{SWEEPS, 0, 0},
                               {REST, 0, 0},
                               {SPLITTING, 0, 0},
                               {NEWTON, 0, 0},
                               {AUGMENTED, SMALL, 12},
                               {PIVOTING, EARLY, 0},
                               {HOMOTOPY, EARLY, 20},
                               {SPLITTING, 0, 0},
                               {SWEEPS, 0, 0},
                               {NEWTON, 0, 0},
                               {END, 0, 0}};

/* Few contacts of many bodies: sweeps mostly come in. Where they do not, momentum from r = 0 does,
 * or pivots, cheap in 2D; Newton's method seldom. Then turns as for a packing. */
static const step few[] = {
    {SWEEPS, 0, 0}, {REST, 0, 0},   {NEWTON, 0, 0},       {PUSH, COLD, dlsi_auto_few_pushes},
    {REST, 0, 0},   {NEWTON, 0, 0}, {PIVOTING, EARLY, 0}, {HOMOTOPY, EARLY, 20},
    {PUSH, 0, 0},   {REST, 0, 0},   {NEWTON, 0, 0},       {AUGMENTED, IN_TURN, 0},
    {AGAIN, 0, 4},  {END, 0, 0}};

/* Momentum, in turn with Newton's method, which leads nowhere far from the answer (above), and
 * with the augmented Lagrangian, which ends chains through which a reaction takes thousands of
 * sweeps. The convex problem is taken when sweeps have cost as much (FC5). */
static const step packing[] = {{SWEEPS, 0, 0},          {REST, 0, 0},  {NEWTON, 0, 0}, {PUSH, 0, 0},
                               {AUGMENTED, IN_TURN, 0}, {AGAIN, 0, 4}, {END, 0, 0}};

static const step tight[] = {{PUSH, 0, 0},  {REST, 0, 0}, {NEWTON, 0, 0}, {AUGMENTED, IN_TURN, 0},
                             {AGAIN, 0, 4}, {END, 0, 0}};

/* What the first plan leaves, up to 300 rows. Pivots prove that there is no solution, or end it;
 * the rest searches. Beside a short path the augmented Lagrangian and ADMM improve its r, before
 * many paths are followed. The augmented Lagrangian tells at last of reactions that run away. */
const step dlsi_auto_plan_on_copy[] = {{SWEEPS, 0, 0},
                                       {NEWTON, 0, 0},
                                       {PIVOTING, 0, 0},
                                       {HOMOTOPY, COLD, 100},
                                       {AUGMENTED, SORTED, 0},
                                       {SETTLE, 0, 2000},
                                       {HOMOTOPY, COLD, 0},
                                       {SCATTER, 0, 0},
                                       {COLD_SPLITTING, COLD, 0},
                                       {NEWTON, 0, 0},
                                       {SETTLE, 0, 0},
                                       {AUGMENTED, COLD, 0},
                                       {END, 0, 0}};

/* ... and beyond. */
const step dlsi_auto_plan_beyond[] = {
    {AUGMENTED, 0, 0}, {PIVOTING, 0, 0},          {PUSH, 0, 0},   {SWEEPS, 0, 0},
    {NEWTON, 0, 0},    {COLD_SPLITTING, COLD, 0}, {NEWTON, 0, 0}, {END, 0, 0}};

const step *dlsi_auto_first_plan(const dlsi_auto *work) {
  if (dlsi_auto_has_plan(work)) return work->given->step;
  if (dlsi_auto_is_few(work)) return few;
  if (!dlsi_auto_is_packing(work)) return elastic;
  return dlsi_auto_may_sweep(work) ? packing : tight;
}
