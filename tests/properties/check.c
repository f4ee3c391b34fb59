/*
 * check.c: the runs of one problem, and the rules that their answers must keep.
 *
 * Every run is judged alone (rules 1, 2, 3, 7) and against runs of the same problem (4, 5, 6).
 * Every problem is solved by auto at two tolerances; storages, scales, orders, starts, single
 * methods and the two forms of the LCP take turns, drawn by the seed: a minute covers thousands of
 * problems. If auto takes k > 1000 factorisations, the others run 1000 / k times as often.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

const char *const rule_text[RULES] = {"kept",
                                      "an error for a sound problem",
                                      "solvable, and \"no solution likely\"",
                                      "solvable, and \"no solution\"",
                                      "solved, and the positions do not hold",
                                      "solved, and the forces do not hold",
                                      "not solved, and the answer holds",
                                      "no solution, and another run has one",
                                      "powers of four change the answer",
                                      "odd powers of two change the answer",
                                      "odd powers of two change the verdict",
                                      "the order of candidates changes the verdict",
                                      "no solution, without an exact proof",
                                      "solved, and the reactions are not the true ones",
                                      "solved, and the positions are not the true ones"};

void describe_run(const run *how, char *text) {
  const int n = how->rows ? snprintf(text, 200, "LCP of %d rows, crash %d", how->rows, how->crash)
                          : snprintf(text, 200, "%s", dls_method_name(how->method));
  const size_t at = (size_t)n;
  snprintf(text + at, 200 - at, ", tol %g%s%s%s%s", how->tol, how->blocks ? ", blocks" : "",
           how->front ? ", dls_solve" : "",
           how->warm == 2 ? ", warm from the first"
           : how->warm    ? ", warm"
                          : "",
           how->shuffle ? ", shuffled" : "");
  const size_t end = strlen(text);
  if (how->power_W || how->power_q)
    snprintf(text + end, 200 - end, ", W 2^%d, q 2^%d", how->power_W, how->power_q);
}

/* ---- rules ----------------------------------------------------------------------------------- */

/* Returns 1 if the planted answer is certified with room to spare, so that rounding cannot hide
 * it. */
static int is_visible(const problem *p, double tol) {
  measure planted;
  if (p->kind != SOLVABLE) return 0;
  measure_answer(p, p->r, &planted);
  return measure_holds(&planted, tol, 0.25, 1e-8, 1);
}

/* Returns 1 if an answer that the library certified, with floors up to `most`, is within its
 * tolerance: positions, or forces. The sums of the library are rounded: one floor and a thousandth
 * are spared; the cap on the floor counts fourfold. */
static int is_within(const measure *a, double tol, double most, int forces) {
  const double x = forces ? a->r : a->u, floor = forces ? a->floor_r : a->floor_u;
  const double bar = 4 * floor > tol ? 4 * floor : tol, cap = tol > most ? tol : most;
  return x - floor <= 1.001 * bar && floor <= cap;
}

/* Rule 8 of one outcome: the error that the library predicts, relative to its own |r|, counts ten
 * times. */
static rule judge_error(const outcome *o) {
  const truth *t = &o->is_true;
  if (o->status != DLS_OK) return KEPT;
  if (t->verdict != TRUTH_WRONG_R && t->verdict != TRUTH_WRONG_U) return KEPT;
  const double least = t->verdict == TRUTH_WRONG_R ? fmin(t->error, t->largest) : t->error;
  const double of_r = t->verdict == TRUTH_WRONG_R ? t->size : 1;
  if (10 * o->error * of_r >= least) return KEPT;
  return t->verdict == TRUTH_WRONG_R ? TRUE_R : TRUE_U;
}

/* Returns 0 where W = 0: no unit of W can be told from the numbers then, nor one of r. */
static int has_unit(const problem *p) {
  for (int k = 0; k < p->m * p->m; k++)
    if (p->W[k] != 0) return 1;
  return 0;
}

/* The first rule that one outcome breaks alone. */
static rule judge_alone(const problem *p, const run *how, const outcome *o) {
  if (o->status < 0) return REFUSED;
  const int visible = p->kind == SURE || is_visible(p, how->tol);
  if (o->status == DLS_NO_SOLUTION && !o->proof)
    return visible ? PROVED : how->rows && o->lcp_proof ? KEPT : NO_PROOF;
  if (o->status == DLS_NO_SOLUTION && (p->exact || p->kind == SURE)) {
    fprintf(stderr, "properties: an answer that exists and a proof against it are both exact\n");
    abort();
  }
  if (o->status == DLS_NO_SOLUTION_LIKELY && visible) return LIKELY;
  if (how->rows && o->status == DLS_OK && !o->lcp_holds) return NOT_HELD;
  const int in_own_unit = has_unit(p) || (how->power_W == 0 && how->power_q == 0);
  const int rounded = o->status == DLS_TO_ROUNDING;
  const int judged = (o->status == DLS_OK || rounded) && !how->rows && in_own_unit;
  const double most = o->is_proved ? INFINITY : rounded ? 1e-4 : 1e-8;
  if (judged && !is_within(&o->is, how->tol, most, 0)) return NOT_HELD;
  if (judged && !is_within(&o->is, how->tol, most, 1)) return NOT_HELD_R;
  const int gave_up = o->status == DLS_STALLED || o->status == DLS_NO_SOLUTION_LIKELY;
  const int held = how->rows ? o->lcp_holds : o->holds;
  if ((gave_up || rounded) && held) return UNSEEN;
  if (gave_up && !how->rows && o->holds_to_rounding) return UNSEEN;
  if (o->status == DLS_NO_SOLUTION_LIKELY && o->residual == 0) return UNSEEN;
  return KEPT;
}

/* Returns CONTRADICTION if one outcome denies, without an exact proof, what the other one has. */
static rule judge_claims(const outcome *a, const outcome *b) {
  const int denied = a->holds && b->status == DLS_NO_SOLUTION && !b->proof;
  const int denies = b->holds && a->status == DLS_NO_SOLUTION && !a->proof;
  return denied || denies ? CONTRADICTION : KEPT;
}

/* Returns 1 if all reactions are the same; below the normal numbers another unit rounds them. */
static int have_same_bits(const problem *p, const outcome *a, const outcome *b) {
  for (int k = 0; k < p->m; k++)
    if (!(a->r[k] == b->r[k] || (fabs(a->r[k]) < DBL_MIN && fabs(b->r[k]) < DBL_MIN))) return 0;
  return 1;
}

/* The rule that a run and the one it is a copy of, but for scales or order, break together. An
 * exact proof against a solution and an answer that holds to rounding are both true. */
static rule judge_copy(const problem *p, const run *one, const outcome *a, const run *two,
                       const outcome *b) {
  const int scaled = one->power_W != two->power_W || one->power_q != two->power_q;
  const int odd = (two->power_W - one->power_W) % 2 != 0;
  const int both_true = (a->holds && b->proof) || (b->holds && a->proof);
  const int other = !both_true && (a->status == DLS_OK) != (b->status == DLS_OK);
  if (scaled && odd && other) return UNITS;
  const int alike = a->status < 0 || !has_unit(p) || have_same_bits(p, a, b);
  if (scaled && (a->status != b->status || !alike)) return odd ? ODD_BITS : BITS;
  if (one->shuffle != two->shuffle && other) return ORDER;
  return KEPT;
}

/* ---- the runs of a problem ------------------------------------------------------------------- */

/* Factorisations of auto's first run, beyond which other runs are rarer in proportion. */
static const double dear = 1000;

typedef struct plan {
  int count;
  run run[RUNS_MAX];
  int against
      [RUNS_MAX]; /* the run that this one is compared with, bit by bit or in its verdict; -1 */
} plan;

static run *plan_add(plan *all, int against) {
  run *how = &all->run[all->count];
  *how = all->run[against < 0 ? 0 : against];
  all->against[all->count++] = against;
  return how;
}

static void plan_powers(dice *g, run *how) {
  const int way = dice_below(g, 4), k = 1 + dice_below(g, 30);
  const int power = dice_below(g, 2) ? k : -k;
  how->power_W = way == 1 ? 0 : power;
  how->power_q = way == 0 ? 0 : way == 3 ? dice_below(g, 61) - 30 : power;
}

/* auto: another tolerance, always where the first run has an answer; storage, entry, start, order,
 * scale, each of them at `share` times its usual rate. */
static void plan_auto(dice *g, const problem *p, int answered, double share, plan *all) {
  if (answered || dice_between(g, 0, 1) < share) {
    plan_add(all, 0)->tol /= 100;
    all->against[1] = -1;
  }
  if (dice_between(g, 0, 2) < share) plan_add(all, -1)->blocks = 1;
  if (dice_between(g, 0, 2) < share) plan_add(all, -1)->front = 1;
  if (dice_between(g, 0, 4) < share) plan_add(all, -1)->warm = 1;
  if (dice_between(g, 0, 4) < share) plan_add(all, -1)->warm = 2;
  if (dice_between(g, 0, 2) < share) plan_powers(g, plan_add(all, 0));
  if (p->nc > 1 && dice_between(g, 0, 2) < share) plan_add(all, 0)->shuffle = 1;
}

/* every method one time in eight, else one; the homotopy, which takes all its starts where there is
 * no solution, one time in forty; each may be scaled, or by blocks */
static void plan_methods(dice *g, const problem *p, plan *all) {
  const int every = dice_below(g, 8) == 0, one = 1 + dice_below(g, 6);
  const int path = dice_below(g, 5) == 0, bonded = problem_is_bonded(p);
  for (int method = 1; dls_method_name((dls_method)method); method++) {
    if (!every && method != one) continue;
    if (method == DLS_HOMOTOPY && !path) continue;
    if (bonded && (method == DLS_HOMOTOPY || method == DLS_LEMKE)) continue;
    const int own = all->count;
    plan_add(all, -1)->method = (dls_method)method;
    if (dice_below(g, 3) == 0) plan_powers(g, plan_add(all, own));
    if (dice_below(g, 6) == 0) {
      run *blocks = plan_add(all, own);
      blocks->blocks = 1;
      all->against[all->count - 1] = -1;
    }
  }
}

static void plan_lcp(dice *g, const problem *p, plan *all) {
  if (p->d != 2 || p->nc > 30 || problem_is_bonded(p) || dice_below(g, 3)) return;
  const int rows = 3 + dice_below(g, 2);
  for (int k = 0; k < 3; k++) {
    run *how = plan_add(all, -1);
    how->rows = rows;
    how->crash = k > 0;
    if (k == 2) how->tol /= 100;
  }
}

static void note_finding(verdict *v, rule broken, int pair, const run *first, const run *second,
                         const outcome *o) {
  if (!broken) return;
  for (int k = 0; k < v->findings; k++)
    if (v->finding[k].rule == broken) return;
  if (v->findings == RULES) return;
  v->finding[v->findings++] = (finding){.rule = broken,
                                        .pair = pair,
                                        .is_true = o->is_true,
                                        .predicted = o->error,
                                        .first = *first,
                                        .second = *second};
}

static void compare_all(const problem *p, const plan *all, const outcome *o, verdict *v) {
  int held = 0, likely = 0, proved = 0, who = 0;
  for (int k = 0; k < all->count; k++) {
    const int with = all->against[k];
    if (o[k].holds) held = 1, who = k;
    if (with >= 0)
      note_finding(v, judge_copy(p, &all->run[with], &o[with], &all->run[k], &o[k]), 1,
                   &all->run[with], &all->run[k], &o[k]);
    likely |= o[k].status == DLS_NO_SOLUTION_LIKELY;
    proved |= o[k].status == DLS_NO_SOLUTION && o[k].proof;
  }
  for (int k = 0; held && k < all->count; k++)
    if (!v->visible)
      note_finding(v, judge_claims(&o[who], &o[k]), 1, &all->run[who], &all->run[k], &o[k]);
  v->both_true = proved && (held || v->visible);
  v->doubtful = likely && held && !v->visible;
}

void check_problem(const problem *p, uint64_t seed, const options *ask, verdict *v) {
  static outcome o[RUNS_MAX];
  plan all = {.count = 1, .against = {-1}};
  dice g = {seed ^ 0x2545f4914f6cdd1du};
  memset(v, 0, sizeof *v);
  v->visible = is_visible(p, ask->tol);
  all.run[0] = (run){.method = DLS_AUTO, .tol = ask->tol, .seed = seed};
  solve_run(p, &all.run[0], NULL, &o[0]);
  plan_auto(&g, p, o[0].status == DLS_OK, dear / fmax(dear, o[0].factorisations), &all);
  plan_methods(&g, p, &all);
  plan_lcp(&g, p, &all);
  for (int k = 0; k < all.count; k++) {
    if (k) solve_run(p, &all.run[k], &o[0], &o[k]);
    if (all.run[k].warm == 2)
      note_finding(v, judge_alone(p, &all.run[k], &o[k]), 1, &all.run[0], &all.run[k], &o[k]);
    else
      note_finding(v, judge_alone(p, &all.run[k], &o[k]), 0, &all.run[k], &all.run[k], &o[k]);
  }
  for (int k = 0; k < all.count; k++)
    note_finding(v, judge_error(&o[k]), all.run[k].warm == 2,
                 &all.run[all.run[k].warm == 2 ? 0 : k], &all.run[k], &o[k]);
  compare_all(p, &all, o, v);
  v->runs = all.count;
  v->status = o[0].status;
  v->solved = o[0].status == DLS_OK;
  v->solved_fine = v->solved && o[1].status == DLS_OK;
  v->forces = v->solved ? o[0].is.r : 0;
  for (int k = 0; k < all.count; k++) {
    const truth *t = &o[k].is_true;
    v->unknown += t->verdict == TRUTH_UNKNOWN;
    v->other += t->verdict == TRUTH_OTHER;
    if (t->verdict == TRUTH_UNKNOWN || t->verdict == TRUTH_OTHER || !(t->condition > 0)) continue;
    v->amplified = fmax(v->amplified, t->error / t->tol / t->condition);
  }
}

int finding_stands(const problem *p, const finding *found) {
  static outcome a, b;
  solve_run(p, &found->first, NULL, &a);
  const int error = found->rule == TRUE_R || found->rule == TRUE_U;
  if (error && !found->pair) return judge_error(&a) == found->rule;
  if (!found->pair) return judge_alone(p, &found->first, &a) == found->rule;
  solve_run(p, &found->second, &a, &b);
  if (error) return judge_error(&b) == found->rule;
  if (found->rule == CONTRADICTION) return judge_claims(&a, &b) == found->rule;
  return judge_alone(p, &found->second, &b) == found->rule ||
         judge_copy(p, &found->first, &a, &found->second, &b) == found->rule;
}
