/*
 * nlgs_ways.c: what happens between two sweeps of Gauss-Seidel (nlgs.c) to need fewer of them.
 *
 * The sweep g is a fixed-point map x -> r = g(x). Accelerated (history, anderson.c):
 *
 *   (NL6)  f = D (r - x), D = diag(w_c) 2^k, 2^k |q| about 1;  x := r - DG gamma, u := u - DU gamma
 *          by Anderson, then each x_c := P_Cmu(x_c) with u by columns
 *   (NL7)  instead, if the residual of r exceeds 1.1 times that of the g before: back to that g,
 *          its u afresh, history forgotten; the plain sweep that follows is always taken. Such
 *          returns can repeat without end. From return 100 since the residual of g last halved on,
 *          one plain sweep more follows each return than followed the one before. A stage of auto
 *          goes without these, and without (AN4): Newton's method is next there
 *
 * With momentum (momentum.c), p being the last step; W by blocks or of bodies also (NL9):
 *
 *   (NL8)  x := r + b p, u likewise, b at most 1
 *   (NL10) where the residual takes too long to halve, b is at most 1/2 from the best r on, then 0;
 *          where b is 0 already a stage of auto ends. Too long: more sweeps than until the last
 *          halving, and 300; three times as many for b = 0 below 1000 candidates. While (NL12) has
 *          several ways and b is 1: 800 for 300, from 1000 candidates on times nc / 1000 to the
 *          power 1/d, and a fifth less is enough for a halving
 *   (NL12) beyond 1000 candidates another way is (NL8) HELD, restarted every 10 sweeps in which
 *          the residual has not fallen by a tenth: some large packings at rest need it. A stage of
 *          auto has (NL6) as a way, too, in place of (NL8) and (NL9): in 2D as the first one, in 3D
 *          beyond 1000 candidates as the second one. turns.c finds which way goes on: the one that
 *          halves the residual at the lowest cost; another one begins from the best r
 *
 * Whatever x is, r = g(x) is the iterate that is measured, kept as the best and returned. Sweeps do
 * not damp the rounding of u, and (NL6) amplifies it; with u afresh in (NL7) and a bound on gamma,
 * estimate and certificate stay within 1 % on the FCLIB files but for BoxesStack1 (1 in 25 of its
 * refreshes finds a factor of 10). Without the two, a call on the cycle of tests/method/test_nlgs.c
 * estimated 4e-8 for an r of residual 0.7.
 *
 * Source: (NL6) with two sweeps is what [Chabrand 1998] 4.2 names (Aitken, after Raous, Barbosa and
 * Latil). Cost: (NL6) (3 window + 10) m operations or so, and the columns of the candidates that it
 * projects; (NL8) O(m).
 */
#include <math.h>
#include <string.h>

#include "nlgs_work.h"

/* (NL7) Growth of the residual that an accelerated iterate may show: on nine FCLIB files together
 * (Anderson, 1e-8) a growth of 2 takes 19335 sweeps where 1.1 takes 11758. */
static const double nlgs_growth = 1.1;

enum { most_returns = 100 };                                    /* (NL7) */
enum { local_every = 10, local_first = 50 };                    /* (NL9), in sweeps */
enum { slow_first = 300, slow_turns = 800, last_patience = 3 }; /* (NL10) */
static const double slow_momentum = 0.5;                        /* (NL10) */
static const double turns_fall = 0.8;       /* (NL10): of the residual, with several ways */
static const double falls = 0.9;            /* HELD: of the residual, in local_every sweeps */
static const double price_of_history = 1.5; /* a sweep with (NL6), in sweeps with (NL8) */

/* ---- acceleration ---------------------------------------------------------------------------- */

/* Returns the power of two next to x > 0, which scales f without rounding: the last digit of |q|
 * depends on the numbers of the candidates. */
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

/* Begins momentum again at r, which u (or v) belongs to. */
static void nlgs_start_momentum(dls_nlgs *work, const dls_contact *problem, const double *r) {
  const dlsi_set all = {.count = problem->nc};
  const int n = work->motions, d = problem->d;
  dlsi_momentum_start(&work->momentum, d, n ? n : d, all, dlsi_nlgs_rows(work, problem), r,
                      dlsi_nlgs_kept(work));
}

/* (NL10) Returns 1 when the residual has not been halved for as many sweeps as before and 300, or,
 * below 1000 candidates without momentum, three times as many: what follows is as expensive. While
 * there are several ways, one that takes a fifth off will do, and 300 is 800, from 1000 candidates
 * on times their number across: so many sweeps a reaction takes to get through. */
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

/* (NL8) r := the start of the next sweep k, with local sweeps before it now and then. Returns 0 if
 * a stage of auto has no smaller momentum left to try. */
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

/* ---- several ways ---------------------------------------------------------------------------- */

/* (NL12) Lists the ways, the first of which is taken. */
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

/* Begins the way now, from r, which u (or v) belongs to. */
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

/* (NL12) after so many sweeps that have led to r, of this residual. Returns 1 if another way
 * begins, from the best r where this one is a tenth worse. */
int dlsi_nlgs_change_way(dls_nlgs *work, const dls_contact *problem, double residual, int sweeps,
                         double *r) {
  if (work->largest < 1) return 0; /* (NL10) has ended the turns */
  const double price = work->now == DLSI_WAY_ANDERSON ? price_of_history : 1;
  const int turn = dlsi_turns_advance(&work->turns, residual, price * sweeps);
  dlsi_nlgs_way next = turn ? work->way[work->turns.now] : work->now;
  if (next == DLSI_WAY_ANDERSON && nlgs_is_slow(work, problem, residual))
    next = DLSI_WAY_FREE; /* (NL10) is next */
  if (next == work->now) return 0;
  work->now = next;
  if (residual > nlgs_growth * work->turns.least) dlsi_nlgs_return(work, problem, work->it.best, r);
  nlgs_start_way(work, problem, r);
  return 1;
}
