/*
 * plan.c: the plans of auto, one for each regime (regime.c): lists of steps. A step is a solve by
 * another method from the best r so far. A step that the problem does not allow is left out
 * (kind.may). The first r that the certificate accepts ends the plan.
 */
#include "auto/auto.h"

const step_kind dlsi_auto_kind[parts] = {
    [SWEEPS] = {DLS_STEP_ANDERSON, &dlsi_nlgs_method, dlsi_auto_may_sweep, 0},
    [SPLITTING] = {DLS_STEP_SPLITTING, &dlsi_admm_method, dlsi_auto_may_split, dlsi_auto_splits},
    [REST] = {DLS_STEP_CONVEX, &dlsi_rest_method, dlsi_auto_may_rest, 0},
    [NEWTON] = {DLS_STEP_NEWTON, &dlsi_newton_method, dlsi_auto_may_step, 0},
    [AUGMENTED] = {DLS_STEP_AUGMENTED, &dlsi_augmented_method, NULL, 0},
    [PIVOTING] = {DLS_STEP_LEMKE, &dlsi_lemke_method, dlsi_auto_may_pivot, 0},
    [COLD_SPLITTING] = {DLS_STEP_COLD_SPLITTING, &dlsi_admm_method, NULL, 2000},
    [HOMOTOPY] = {DLS_STEP_HOMOTOPY, &dlsi_homotopy_method, dlsi_auto_may_follow_path, 0},
    [SCATTER] = {DLS_STEP_SCATTER, &dlsi_scatter_method, dlsi_auto_may_follow_path, 0},
    [PUSH] = {DLS_STEP_MOMENTUM, &dlsi_nlgs_method, dlsi_auto_may_push, 1000000},
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
 * or pivots, cheap in 2D; Newton's method seldom. */
static const step few[] = {{SWEEPS, 0, 0},       {REST, 0, 0},
                           {NEWTON, 0, 0},       {PUSH, COLD, dlsi_auto_few_pushes},
                           {REST, 0, 0},         {NEWTON, 0, 0},
                           {PIVOTING, EARLY, 0}, {HOMOTOPY, EARLY, 20},
                           {NEWTON, 0, 0},       {PUSH, 0, dlsi_auto_long_pushes},
                           {NEWTON, 0, 0},       {COLD_SPLITTING, COLD, dlsi_auto_splits},
                           {NEWTON, 0, 0},       {END, 0, 0}};

/* Momentum, in turn with Newton's method, which leads nowhere far from the answer (regime.c), and
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
    {PIVOTING, 0, 0}, {AUGMENTED, 0, 0},         {PUSH, 0, 0},   {SWEEPS, 0, 0},
    {NEWTON, 0, 0},   {COLD_SPLITTING, COLD, 0}, {NEWTON, 0, 0}, {END, 0, 0}};

const step *dlsi_auto_first_plan(const dlsi_auto *work) {
  if (dlsi_auto_has_plan(work)) return work->given->step;
  if (dlsi_auto_is_few(work)) return few;
  if (!dlsi_auto_is_packing(work)) return elastic;
  return dlsi_auto_may_sweep(work) ? packing : tight;
}
