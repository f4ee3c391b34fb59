/*
 * nlgs_ways.c: acceleration between the sweeps of Gauss-Seidel (nlgs.c).
 *
 * The sweep g is a fixed-point map x -> r = g(x). Accelerated (history, anderson.c):
 *
 *   (NL6)  f = D (r - x), D = diag(w_c) 2^k, 2^k |q| about 1;  x := r - DG gamma, u := u - DU gamma
 *          by Anderson, then each x_c := P_Cmu(x_c) with u by columns
 *   (NL7)  instead, if the residual of r exceeds 1.1 times that of the last g: return to that g,
 *          recompute u, clear the history; the next sweep is plain and always accepted. Returns can
 *          repeat without end: after return 100 since the residual of g last halved, each return is
 *          followed by one more plain sweep than the last one. A stage of auto omits these sweeps,
 *          and (AN4): Newton's method follows there
 *
 * With momentum (momentum.c), p the last step; for W by blocks or of bodies also (NL9):
 *
 *   (NL8)  x := r + b p, u likewise, b at most 1
 *   (NL10) if the residual does not halve in time, the sweeps return to the best r with b <= 1/2,
 *          next with b = 0; after that a stage of auto ends. Time: s + 300 sweeps, s the sweeps
 *          until the last halving; 3 times that if b = 0 and nc < 1000. While (NL12) has several
 *          variants and b <= 1: s + 800 max(1, nc / 1000)^(1/d), and 20 % less counts as a halving
 *   (NL12) variants: FREE is (NL8). HELD, beyond 1000 contacts, is (NL8) restarted every 10 sweeps
 *          in which the residual has not fallen by 10 %: some large packings at rest need it.
 *          ANDERSON, in a stage of auto, is (NL6) in place of (NL8) and (NL9): the first one in 2D,
 *          the second one in 3D beyond 1000 contacts. turns.c continues the variant that halves the
 *          residual at the lowest cost; another one begins from the best r
 *   (NL14) a stage that auto ends early, for another step or for its own limit, keeps the last
 *          sweep, p, b, the variants and what (NL10) knows. The next one goes on from there, unless
 *          its start has less than 1/10 of the residual. Begun again, momentum takes up to four
 *          times as many sweeps. A variant with momentum goes on likewise after one with (NL6)
 *
 * For any x the iterate that is measured, kept as the best and returned is r = g(x). Sweeps do not
 * damp the rounding of u, and (NL6) amplifies it. With a fresh u in (NL7) and a bound on gamma,
 * estimate and certificate stay within 1 % on the FCLIB files except BoxesStack1 (1 in 25 of its
 * refreshes finds a factor of 10). Without the two, a call on the cycle of tests/method/test_nlgs.c
 * estimated 4e-8 for an r of residual 0.7.
 *
 * Source: [Chabrand 1998] 4.2 names (NL6) with two sweeps (Aitken, after Raous, Barbosa and Latil).
 * Cost: (NL6) about (3 window + 10) m operations, and the columns of the contacts that it projects;
 * (NL8) O(m).
 */
#include <math.h>
#include <string.h>

#include "nlgs_work.h"

/* (NL7) Largest growth of the residual by an accelerated iterate: on nine FCLIB files together
 * (Anderson, 1e-8) 2 takes 19335 sweeps, 1.1 takes 11758. */
static const double nlgs_growth = 1.1;

enum { most_returns = 100 };                                    /* (NL7) */
enum { local_every = 10, local_first = 50 };                    /* (NL9), in sweeps */
enum { slow_first = 300, slow_turns = 800, last_patience = 3 }; /* (NL10) */
static const double slow_momentum = 0.5;                        /* (NL10) */
static const double turns_fall = 0.8;       /* (NL10): of the residual, with several variants */
static const double falls = 0.9;            /* HELD: of the residual, in local_every sweeps */
static const double far_better = 0.1;       /* (NL14) */
static const double price_of_history = 1.5; /* a sweep with (NL6), in sweeps with (NL8) */

/* ---- acceleration ---------------------------------------------------------------------------- */

/* Returns the power of two next above x > 0, which scales f without rounding: the last digit of |q|
 * depends on the numbers of the contacts. */
static double nlgs_power_of_two(double x) {
  int e;
  (void)frexp(x, &e);
  return ldexp(1, e);
}

/* (NL7) Returns to the g of the sweep before, whose residual is `accepted`. */
static void nlgs_take_back(dls_nlgs *work, const dls_contact *problem, double accepted, double *r) {
  dlsi_nlgs_return(work, problem, work->history.g, r);
  dlsi_anderson_clear(&work->history);
  if (accepted <= 0.5 * work->residual_then) {
    work->residual_then = accepted;
    work->returns = 0;
  }
  work->returns++;
  if (work->returns > most_returns && !work->stage) work->plain = work->returns - most_returns;
}

/* (NL6) r := the start of the next sweep. r = g(x) has the estimated residual `residual`, the g of
 * the sweep before had *accepted; scale = 1 / |q|. */
void dlsi_nlgs_accelerate(dls_nlgs *work, const dls_contact *problem, double residual, double scale,
                          double *accepted, double *r) {
  dlsi_anderson *history = &work->history;
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  if (history->columns && !(residual <= nlgs_growth * *accepted)) { /* (NL7) */
    nlgs_take_back(work, problem, *accepted, r);
  } else if (work->plain > 0) {
    *accepted = residual;
    work->plain--;
  } else {
    *accepted = residual;
    const double unit = nlgs_power_of_two(scale);
    double *f = work->it.F; /* in the order of the visits, as all sums of the history */
    for (size_t k = 0; k < m / d; k++) {
      const size_t c = work->order ? (size_t)work->order[k] : k;
      for (size_t i = d * c; i < d * (c + 1); i++)
        *f++ = unit * work->it.w[c] * (r[i] - work->x[i]);
    }
    if (dlsi_anderson_step(history, (int)m, work->it.F, r, dlsi_nlgs_kept(work)))
      dlsi_nlgs_repair(work, problem, r);
  }
  memcpy(work->x, r, m * sizeof *r);
}

/* ---- momentum -------------------------------------------------------------------------------- */

/* Restarts momentum at r, to which u (or v) belongs. */
static void nlgs_start_momentum(dls_nlgs *work, const dls_contact *problem, const double *r) {
  const dlsi_set all = {.count = problem->nc};
  const int n = work->motions, d = problem->d;
  work->left.residual = 0;
  dlsi_momentum_start(&work->momentum, d, n ? n : d, all, dlsi_nlgs_rows(work, problem), r,
                      dlsi_nlgs_kept(work));
}

/* (NL10) Returns 1 if the residual has not halved in time. Below 1000 contacts without momentum the
 * time is three times as long: what follows is as expensive. With several variants it grows with
 * the number of contacts across, which a reaction takes that many sweeps to cross. */
static int nlgs_is_slow(dls_nlgs *work, const dls_contact *problem, double residual) {
  const int turns = work->largest == 1 && work->turns.ways > 1;
  if (residual <= (turns ? turns_fall : 0.5) * work->halved) {
    work->halved = residual;
    work->since = work->sweeps;
  }
  const int patience = work->largest == 0 && problem->nc < dlsi_few_candidates ? last_patience : 1;
  const double across = pow(fmax(1, (double)problem->nc / dlsi_few_candidates), 1. / problem->d);
  const double first = turns ? slow_turns * across : slow_first;
  return work->sweeps - work->since >= patience * (first + work->since);
}

/* (NL8) r := the start of the next sweep k, every 10 sweeps after local sweeps. Returns 0 if a
 * stage of auto has no smaller momentum left. */
int dlsi_nlgs_push(dls_nlgs *work, const dls_contact *problem, int k, double residual, double *r) {
  const int slow = nlgs_is_slow(work, problem, residual), n = work->motions;
  if (slow && work->largest == 0 && work->stage) return 0;
  if (slow && work->largest > 0) {
    work->largest = work->largest > slow_momentum ? slow_momentum : 0;
    work->now = problem->nc > dlsi_few_candidates ? DLSI_WAY_HELD : DLSI_WAY_FREE;
    work->since = work->sweeps;
    dlsi_nlgs_return(work, problem, work->it.best, r);
    nlgs_start_momentum(work, problem, r);
    return 1;
  }
  const int at = k - 1; /* the sweep that `residual` belongs to */
  if (!problem->W.a && at >= local_first && at % local_every == 0) {
    const int held = work->now == DLSI_WAY_HELD && !(residual <= falls * work->looked);
    work->looked = residual;
    if (dlsi_nlgs_look_locally(work, problem, r) || held) {
      nlgs_start_momentum(work, problem, r);
      return 1;
    }
  }
  (void)dlsi_momentum_step(&work->momentum, problem->d, n ? n : problem->d, work->it.w,
                           work->largest, dlsi_nlgs_all(work, problem),
                           dlsi_nlgs_rows(work, problem), r, dlsi_nlgs_kept(work));
  return 1;
}

/* ---- several variants ------------------------------------------------------------------------ */

/* (NL12) Lists the variants and takes the first. */
static void nlgs_list_ways(dls_nlgs *work, const dls_contact *problem) {
  const int blocks = !problem->W.a, plane = problem->d == 2;
  const int many = problem->nc > dlsi_few_candidates;
  const int turns = blocks && dlsi_nlgs_may_turn(work) && (plane || many);
  int ways = 0;
  if (turns && plane) work->way[ways++] = DLSI_WAY_ANDERSON;
  work->way[ways++] = DLSI_WAY_FREE;
  if (turns && !plane) work->way[ways++] = DLSI_WAY_ANDERSON;
  if (blocks && many) work->way[ways++] = DLSI_WAY_HELD;
  dlsi_turns_start(&work->turns, ways);
  work->now = work->way[0];
}

/* Begins the variant `now` from r, to which u (or v) belongs. */
static void nlgs_start_way(dls_nlgs *work, const dls_contact *problem, const double *r) {
  if (work->now != DLSI_WAY_ANDERSON) {
    nlgs_start_momentum(work, problem, r);
    return;
  }
  dlsi_anderson_clear(&work->history);
  work->residual_then = INFINITY;
  work->returns = work->plain = 0;
  memcpy(work->x, r, (size_t)problem->d * (size_t)problem->nc * sizeof *r);
}

void dlsi_nlgs_leave(dls_nlgs *work, const dls_contact *problem, int k, int changed,
                     double accepted, const double *r) {
  if (!work->left.r || !work->stage) return;
  work->left.sweeps = k;
  work->left.changed = changed;
  work->left.accepted = accepted;
  work->left.residual = work->it.certificate.residual;
  memcpy(work->left.r, r, (size_t)problem->d * (size_t)problem->nc * sizeof *r);
}

int dlsi_nlgs_resume(dls_nlgs *work, const dls_contact *problem, double *r) {
  const double then = work->left.residual;
  work->left.residual = 0;
  if (!(work->it.certificate.residual >= far_better * then && then > 0)) return 0;
  dlsi_nlgs_return(work, problem, work->left.r, r);
  work->narrow = work->knows = 0;
  return work->left.sweeps;
}

void dlsi_nlgs_begin_ways(dls_nlgs *work, const dls_contact *problem, const double *r) {
  const int pushed = work->settings.acceleration == DLS_ACCELERATION_MOMENTUM;
  work->now = dlsi_nlgs_has_history(&work->settings) ? DLSI_WAY_ANDERSON : DLSI_WAY_FREE;
  if (pushed) {
    work->largest = 1;
    work->narrow = work->acting_count = 0;
    memset(work->acts, 0, (size_t)problem->nc * sizeof *work->acts);
    work->halved = work->looked = INFINITY;
    work->since = work->sweeps = 0;
    work->pause = work->wait = 0;
    nlgs_list_ways(work, problem);
  }
  if (pushed || work->now == DLSI_WAY_ANDERSON) nlgs_start_way(work, problem, r);
}

/* (NL12) after `sweeps` sweeps, which gave r with this residual. Returns 1 if another variant
 * begins, from the best r if r is 10 % worse; 2 if one goes on from where it was (NL14). */
int dlsi_nlgs_change_way(dls_nlgs *work, const dls_contact *problem, double residual, int sweeps,
                         double *r) {
  if (work->largest < 1) return 0; /* (NL10) has ended the turns */
  const double price = work->now == DLSI_WAY_ANDERSON ? price_of_history : 1;
  const int turn = dlsi_turns_advance(&work->turns, residual, price * sweeps);
  dlsi_nlgs_way next = turn ? work->way[work->turns.now] : work->now;
  if (next == DLSI_WAY_ANDERSON && nlgs_is_slow(work, problem, residual))
    next = DLSI_WAY_FREE; /* (NL10) is next */
  if (next == work->now) return 0;
  if (work->now == DLSI_WAY_FREE) dlsi_nlgs_leave(work, problem, 1, 1, INFINITY, r);
  work->now = next;
  if (next == DLSI_WAY_FREE && dlsi_nlgs_resume(work, problem, r)) return 2;
  if (residual > nlgs_growth * work->turns.least) dlsi_nlgs_return(work, problem, work->it.best, r);
  nlgs_start_way(work, problem, r);
  return 1;
}
