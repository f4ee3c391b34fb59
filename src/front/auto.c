/*
 * auto.c: the method "auto": a list of stages. Each stage is another method's solve from the best r
 * so far; the first r that the certificate accepts is the answer.
 *
 *   (AT1)  sweeps     Gauss-Seidel with Anderson acceleration, in an order of the candidates that
 *                     follows from the data
 *   (AT13) push       W by blocks of more than 100 candidates, not of elastic bodies (a fourth of
 *                     all blocks and more: taken as dense): Gauss-Seidel with momentum, in turn
 *                     with Anderson's acceleration (vi/nlgs.c, NL12), after (AT1), which ends
 *                     there when more than 100 sweeps are ahead; beyond 1000, and where each
 *                     candidate has 2 d neighbours or more, in its place. Newton's method then only
 *                     at e <= 1e-5, and after a failure only at a tenth of that: on packings its
 *                     steps lead nowhere before
 *   (AT2)  splitting  ADMM, once, for a dense W after a failure of Newton's method, after two
 *                     where its forecast, 50 max(mu, 1)^2 m / k sweeps, is above twice (AT6); or
 *                     before it where the states still change and a step costs more than 50 sweeps
 *                     or, d = 3, e > .01 and that forecast is below twice (AT7)
 *   (AT12) rest       the convex problem without mu |u_t| (vi/rest.c), for what may be a structure
 *                     at rest: W by blocks, -q in the friction cones, or few neighbours
 *   (AT3)  Newton     from the states that the sweeps have sorted
 *   (AT4)  augmented  the augmented Lagrangian, which sees reactions run away
 *   (AT5)  pivoting   Lemke's method, if small enough; after the first failure of Newton's method
 *                     already, if its table is so small that it takes no longer than the sweeps and
 *                     steps that would follow: on a copy as in (AT11), whose other stages a
 *                     verdict is left to
 *   (AT8)  the last   up to 300 rows an eighth of the interior homotopy's starts and of Newton's
 *                     method from scattered starts (vi/scatter.c), and last of all the rest of
 *                     both: each finds most of what it finds early, and other problems. Between
 *                     them Lemke's method with other covering vectors and, d = 3, facets turned
 *                     (contact_lemke.c, CL6), and up to 3000 rows, from r = 0, plain sweeps in the
 *                     reverse order, ADMM with rho from 1e-8 on, and the augmented Lagrangian once
 *                     more. At last, where the best r is within a hundred times the tolerance, ADMM
 *                     from there: an answer may lie beside it in a basin too narrow for the others
 *   (AT10) proofs     at the end of (AT5) the linear problem that every solution solves (farkas.c):
 *                     it proves that there is no solution, or shows that none could be certified,
 *                     and nothing is searched for then. On a copy nothing is searched for, either,
 *                     where the best r meets the tolerance but for a rounding of W r that is up to
 *                     a hundred times too large: others are about as large
 *   (AT11) copy       up to 300 rows, what (AT1)-(AT3) leave is solved from r = 0 on a copy in an
 *                     order and in units that follow from the data (renumber.c), so that luck does
 *                     not depend on the numbers of the candidates. Frictions above 1e4, infinite
 *                     ones among them, are 1e4 there at first, which pivots and paths can take: an
 *                     answer in which nothing slips there is one of the problem
 *
 * One cost, in sweeps, decides when sweeps give way. With e the residual and e* the one that is
 * asked for, both looked at every 5 sweeps,
 *
 *   (AT6)  sweeps ahead: log(e / e*) / rate, rate: the mean decrease of log e per sweep since the
 *          stage began, sweep k with the weight k, so that the last half counts most
 *   (AT7)  Newton: s steps of min(max(5 + k / 12, k / 6), 50) sweeps, k unknowns, or, W dense,
 *          k^2 / (6 m) if that is more: a step multiplies by W twice and factorises k^3 where a
 *          sweep reads k m; W by blocks, d = 3, (k / 6000)^2 times as many from 6000 on, for the
 *          fill. s = d - 1 for a dense W whose k has not changed since the last look: with the
 *          right states a step is exact in 2D, and two do in 3D; else s = 4. Each failure of
 *          Newton's method doubles s.
 *
 * Sweeps end when (AT6) > (AT7), or > 100 where (AT12) or (AT13) is next, after 10 sweeps (20 for W
 * by blocks, or while e > .05 before any failure; half of that from a warm start whose first sweep
 * ends with e <= 1/4), a number that each failure doubles. Newton's method gives up when 4 steps,
 * or as many as cost half of (AT6) and of (AT2), up to 12, doubled by each failure, have not
 * brought e down by a tenth. A forecast that was wrong is so believed less each time. No clock is
 * read: the same input takes the same stages and gives the same bits.
 *
 * W dense is what an elastic body leaves, regular. W by blocks comes from many bodies, often rigid
 * ones; it is then singular, and Newton's steps converge slowly. The free velocity q of bodies at
 * rest is that of falling, and -q lies in the cones; bodies in motion are far from that. Where
 * (AT12) meets the tolerance but for the rounding of W r, no later stage has less of it, and
 * nothing is tried any more.
 *
 *   (AT14) steps     a warm solve, W dense, may begin with Newton's method, on the factors of the
 *          solve before (vi/newton.c, NE5): a step in which no state changes takes products and
 *          triangular solves alone. It does where the last solve that did not has cost more sweeps
 *          than such a step is expected to: the first time a step of Newton's for two digits of
 *          the tolerance, then five parts of that expectation and one of what the last one took, a
 *          fiftieth less for each solve without. A step counts for 3/2 sweeps, factors with their
 *          border for 3 + k^2 / (10 m), but for the first ones after a solve without. Where it
 *          fails, the next warm solve does not try. From a start (AT15) with e > 1/4 it goes on as
 *          long as those factors serve: more states change there than one new factor puts right.
 *   (AT15) line      where the start of a warm solve is the answer of the one before, the line
 *          through the last two answers is followed: the better one of both starts is taken. While
 *          W stays, their u follow without a product; (AT14) begins with that u.
 *
 *   (AT16) apart     where two in five candidates or more provably cannot touch (apart.c), W
 *          dense, a cold solve begins with the problem of the others, a copy. Its answer is that of
 *          the whole; without one, the whole is solved as if there had been no copy.
 *
 *   (AT9)  verdict. DLS_NO_SOLUTION if (AT10) has a proof. DLS_NO_SOLUTION_LIKELY only where W
 *          shows no reason for a solution (vi/exists.c), and (AT10) shows that none could be
 *          certified, or all of (AT1)-(AT8) have failed and, d = 2 and up to 8 candidates, no
 *          states of the candidates have a solution (states.c), or, d = 3 and up to 2, (AT4) sees
 *          the reactions run away at last and no r is near the tolerance. Else DLS_STALLED: larger
 *          problems whose reactions run away may have a solution that no stage finds.
 *
 * What can fail: every method; then DLS_STALLED with the best r.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "front/front.h"
#include "linear/room.h"
#include "vi/vi_internal.h"

enum {
  look_every = 5,
  first_sweeps = 10,
  first_patience = 4,
  last_patience = 12, /* of vi/newton.c */
  usual_splits = 50,  /* sweeps in all, where m = k and mu <= 1 */
  most_failures = 5,
  most_pushes = 1000000
};
enum { split_unknowns = 100 };   /* (AT2): below, other methods take less than its factorisation */
enum { rest_unknowns = 150 };    /* (AT12): likewise */
enum { dense_splits = 200 };     /* iterations of (AT2): more of them cost more than Newton again */
enum { few_blocks = 4 };         /* of a candidate, its own included */
enum { rest_sweeps = 100 };      /* what (AT12) costs, analysis included, where it arrives */
enum { pivot_rows = 400 };       /* (AT5), early: such a table stays in the cache */
enum { few_push = 100 };         /* (AT13): fewer candidates by blocks are left to (AT1)-(AT5) */
enum { push_candidates = 1000 }; /* ... more are not tried by (AT1) at all */
enum { push_ahead = 100 };       /* (AT13): accelerated sweeps that take as long as it does */
static const double push_near = 1e-5;  /* (AT13) */
static const double few_filled = 6000; /* (AT7): unknowns by blocks, d = 3 */
enum { path_unknowns = 300 };          /* a thousand factorisations then take a few seconds */
_Static_assert(2 * (int)pivot_rows <= 3 * (int)path_unknowns, "(AT5), early, has a copy");
enum { other_unknowns = 3000 };      /* beyond, another way takes too long, and nothing is said */
enum { other_iterations = 2000 };    /* of sweeps and splitting by another way */
enum { settle_iterations = 20000 };  /* up to path_unknowns: a second or two */
static const double near_most = 100; /* (AT9), (AT10): of residual or floor, over the one asked */
enum { sure_starts = 2 }; /* (AT9): candidates, d = 3, whose states scattered starts cover */
static const double most_firm = 1e4;
enum { copy_failures = 3 };                 /* so much is Newton's method believed on a copy */
static const double unsorted = 0.05;        /* e: with more, few states are those of the answer */
static const double unsettled = 0.01;       /* e: ... and with less, most are */
static const double progress = 0.9;         /* of e, below which a step has brought it down */
static const double share_outside = 0.1;    /* of -q outside of the cones, for what may rest */
static const double null_direction = 1e-10; /* |D^-1 W delta| over |delta|: (AT9) */
enum { few_normals = 6 };                   /* whose factorisation is below the cost of a call */
static const double step_sweeps = 1.5, forgotten = 0.98; /* (AT14) */
static const double far_start = 0.25;                    /* e: (AT14), and of sweeps */
static const double small_part = 0.05; /* of a solve, for a look at other answers */
static const double another = 1e-3;    /* difference of two answers, over the largest reaction */
static const double accurate = 1e-4;   /* (AT18): relative error of r that nobody is told of */
enum { most_turns = 3 };               /* (AT18) */
static const double determined =
    1e-13;                          /* ... residual of a factorisation that needs no second one */
static const double on_cone = 1e-9; /* a reaction that lacks no more than this share slips */

/* Each method once, and some once more for another way. */
typedef enum part {
  SWEEPS,
  SPLITTING,
  REST,
  NEWTON,
  AUGMENTED,
  PIVOTING,
  OTHER_SWEEPS,
  OTHER_SPLITTING,
  HOMOTOPY,
  SCATTER,
  PUSH,
  SETTLE,
  parts
} part;

typedef struct auto_answer {
  double *r, *Wr; /* m */
} auto_answer;

typedef struct dlsi_auto {
  dlsi_options options;
  int d, nc;
  void *part[parts];  /* workspace of each method, NULL before it is needed, or by its home_of */
  dlsi_room room;     /* for their matrices: none keeps factors from one stage to the next */
  double *r, *best;   /* m: of the stage under way, of the best answer so far */
  double *w;          /* nc: compliances of the contacts */
  double *weights;    /* 2 nc: of the certificate */
  double *v[4];       /* m: scratch; the last one up to path_unknowns */
  dlsi_formed formed; /* of a problem of bodies: scratch, W by blocks for all but (AT13) */
  dlsi_renumber copy; /* (AT11), up to path_unknowns */
  double *kept;       /* m: the best r before the copy */
  double *direction;  /* m: the vectors of a verdict on the copy, in the order of the problem */
  double *farkas;     /* nc */
  int *touching;      /* (AT16) those of the problem of the others; NULL in between */
  double *shown;      /* m: then, r of all candidates for the caller's callback */

  /* of the solves before: (AT14), (AT15) */
  int failed_to_step, in_steps;
  double swept;   /* what the last one without (AT14) took, in sweeps */
  double of_step; /* what one with (AT14) is expected to take, 0: as the first */
  int answers;    /* so many of the next two are there, of last_nc candidates */
  int last_nc;
  double amplified;         /* (AT18): error over residual of the last answer looked at */
  auto_answer last, former; /* of the solve before, and of the one before that */

  /* of the solve under way */
  const dls_contact *problem; /* the caller's, or the copy */
  int has_copy, has_direction, has_farkas;
  int touches;        /* (AT16): candidates of the problem of the others; 0: the whole is solved */
  int whole;          /* candidates of the caller's problem */
  int bonded;         /* a candidate has infinite friction: no pivoting, path or verdict */
  int firm;           /* (AT11): copies have frictions up to most_firm, and decide nothing */
  int excluded;       /* (AT10): no r can be certified */
  dls_info info;      /* its certificate is that of best */
  dls_status stopped; /* by the caller's callback or time limit; DLS_OK: by neither */
  int limited;        /* by max_iterations */
  int rounded;        /* only the rounding of W r stands against the best r */
  double begun;       /* CPU seconds when the solve began; -1: nobody asks */
  int failures;       /* of Newton's method */
  int has_split;      /* (AT2) has been tried */
  int may_rest;       /* (AT12) is worth a try, and has not been tried */
  int has_pushed;     /* (AT13) got nowhere */
  int has_augmented;  /* (AT4) has been tried */
  int known;          /* v[0] is u of the start as it follows from (AT15) */
  int far;            /* e of that start is above far_start */
  int stepped;        /* began with (AT14) */

  /* of the stage under way */
  double target, least; /* logarithms of e* and of the least e that counts */
  double rate;          /* (AT6) */
  int near;             /* a warm start, e at most far_start after a sweep */
  double unknowns;      /* k of (AT7) at the last look */
  double step;          /* (AT7) a Newton step */
  double ahead;         /* (AT6) at the last look */
  int patience;         /* steps of Newton's method without progress */
  int costly;           /* Newton's steps, beside (AT2) */
  int since;            /* iteration of the least e; of (AT13): of the last look */
} dlsi_auto;

/* ---- (AT13) ---------------------------------------------------------------------------------- */

static int is_packing(const dlsi_auto *work) {
  return work->problem->nc > few_push && !dlsi_is_elastic(work->problem);
}

static int may_push(const dlsi_auto *work) {
  return is_packing(work) && !work->has_pushed;
}

/* Returns 1 for bodies with d + 1 contacts each or more, as many as hold them with friction, that
 * are not at rest: each candidate then has 2 d neighbours. Looser packings settle in some ten
 * sweeps, and structures at rest need few before (AT12). */
static int is_tight(const dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  if (!problem->Wb.x || work->may_rest) return 0;
  return problem->Wb.p[problem->nc] / (2 * problem->d + 1) >= problem->nc;
}

/* Not where (AT13) has got nowhere, but for once the augmented Lagrangian has failed, too. */
static int may_sweep(const dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  if (!is_packing(work)) return 1;
  if (problem->nc > push_candidates) return 0;
  return work->has_augmented || (work->info.stages == 0 && !is_tight(work));
}

static int is_near(const dlsi_auto *work, double residual) {
  return residual <= push_near * pow(10, -work->failures);
}

static int may_step(const dlsi_auto *work) {
  return !is_packing(work) || is_near(work, work->info.certificate.residual) || work->has_augmented;
}

/* ---- when a stage gives up ------------------------------------------------------------------- */

/* all := r of the candidates that may touch, 0 for the others. */
static void put_among_all(const dlsi_auto *work, const double *r, double *all) {
  const size_t d = (size_t)work->d;
  memset(all, 0, d * (size_t)work->whole * sizeof *all);
  for (size_t k = 0; k < (size_t)work->touches; k++)
    memcpy(all + d * (size_t)work->touching[k], r + d * k, d * sizeof *all);
}

/* Tells the caller's callback and keeps to the caller's limits. Returns 1 to stop. */
static int must_stop(dlsi_auto *work, const dls_progress *p) {
  const dls_limits *limits = &work->options.limits;
  dls_progress mine = *p;
  mine.method = "auto";
  if (work->problem == &work->copy.problem && limits->progress && p->r) { /* the caller's r */
    const dlsi_renumber *copy = &work->copy;
    dlsi_renumber_back(copy, work->d, copy->power_q - copy->power_W, p->r, work->v[3]);
    mine.r = work->v[3];
  }
  if (work->touches && limits->progress && mine.r) {
    put_among_all(work, mine.r, work->shown);
    mine.r = work->shown;
  }
  work->stopped = dlsi_tell(limits, work->begun, &mine);
  if (work->stopped) return 1;
  if (limits->max_iterations && work->info.iterations + p->iteration >= limits->max_iterations)
    return work->limited = 1;
  return 0;
}

/* Returns k of (AT7): the unknowns that the states of r leave to a Newton step. */
static double count_unknowns(const dls_contact *problem, const double *r) {
  const int d = problem->d;
  double k = 0;
  for (int c = 0; c < problem->nc; c++, r += d) {
    const double mu = problem->mu[c];
    if (!(r[0] > 0)) continue;
    k += dlsi_tangent_norm(d, r) < (1 - on_cone) * mu * r[0] ? d : mu > 0 ? d - 1 : 1;
  }
  return k;
}

/* Returns the mean friction of the candidates with a reaction in r. */
static double mean_friction(const dls_contact *problem, const double *r) {
  double sum = 0, count = 0;
  for (int c = 0; c < problem->nc; c++, r += problem->d) {
    if (!(r[0] > 0)) continue;
    sum += problem->mu[c];
    count++;
  }
  return count > 0 ? sum / count : 0;
}

/* Returns the sweeps that (AT2) costs, its factorisation included: its iterations read m^2 where a
 * sweep reads k m, and grow with the square of friction. */
static double cost_of_split(const dlsi_auto *work) {
  const double mu = fmax(mean_friction(work->problem, work->r), 1);
  const double m = (double)work->problem->d * work->problem->nc;
  return usual_splits * mu * mu * m / fmax(work->unknowns, 1);
}

/* (AT7) */
static double cost_of_newton(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const int dense = problem->W.a != NULL;
  const double k = count_unknowns(problem, work->r), m = (double)problem->d * problem->nc;
  const int settled = dense && k == work->unknowns;
  const double fill = !dense && problem->d == 3 && k > few_filled ? k / few_filled : 1;
  const double step = fmin(fmax(5 + k / 12, k / 6), 50) * fill * fill;
  const double dense_step = fmax(step, k * k / (6 * m));
  work->unknowns = k;
  work->step = dense ? dense_step : step;
  work->costly = dense && !settled && dense_step > 50;
  return (settled ? problem->d - 1 : 4) * (1 << work->failures) * work->step;
}

static int watch_sweeps(void *data, const dls_progress *p) {
  DLSI_DOOR;
  dlsi_auto *work = data;
  if (must_stop(work, p)) return 1;
  const double now = log(p->residual);
  if (p->iteration == 1) {
    work->least = now;
    work->near = work->options.limits.warm_start && p->residual <= far_start;
  }
  const double gain = now < work->least ? work->least - now : 0;
  work->least -= gain;
  work->rate += 2. / (p->iteration + 1) * (gain - work->rate);
  if (p->iteration % look_every) return 0;
  const double newton = cost_of_newton(work), ahead = (work->least - work->target) / work->rate;
  const double other = may_push(work) ? push_ahead : newton;
  const double next = work->may_rest ? fmin(other, rest_sweeps) : other;
  if (work->d == 3 && p->residual > unsettled && cost_of_split(work) < 2 * newton) work->costly = 1;
  work->ahead = ahead;
  const int sorted = work->failures || p->residual <= unsorted;
  const int twice = !work->problem->W.a || !sorted;
  const int first = (twice + 1) * first_sweeps / (work->near + 1);
  return p->iteration >= first << work->failures && ahead > next;
}

static int watch_newton(void *data, const dls_progress *p) {
  DLSI_DOOR;
  dlsi_auto *work = data;
  if (must_stop(work, p)) return 1;
  const double now = log(p->residual);
  if (now < work->least + log(progress)) {
    work->least = now;
    work->since = p->iteration;
  }
  return p->iteration - work->since >= work->patience << work->failures;
}

/* (AT13) Stops when (AT12) is to be tried. Sweeps that get nowhere stop by themselves. */
static int watch_push(void *data, const dls_progress *p) {
  DLSI_DOOR;
  dlsi_auto *work = data;
  if (must_stop(work, p)) return 1;
  const double now = log(p->residual);
  if (!work->since) work->least = now;
  const double gain = now < work->least ? work->least - now : 0;
  const int sweeps = p->iteration - work->since; /* of bodies some in one go */
  work->least -= gain;
  work->rate += 2. * sweeps / (p->iteration + sweeps) * (gain / sweeps - work->rate);
  work->since = p->iteration;
  if (p->iteration % look_every || p->iteration < 2 * first_sweeps) return 0;
  const double ahead = (now - work->target) / work->rate;
  if (work->may_rest && ahead > rest_sweeps) return 1;
  return is_near(work, p->residual) && ahead > cost_of_newton(work);
}

static int watch_limits(void *data, const dls_progress *p) {
  DLSI_DOOR;
  return must_stop(data, p);
}

/* ---- stages ---------------------------------------------------------------------------------- */

/* Returns 1 if -q lies in the friction cones, but for a tenth of it, or if candidates have at most
 * three neighbours on average, so that a factorisation costs what a few sweeps do; (AT12). */
static int looks_at_rest(const dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const int d = problem->d;
  const double *q = problem->q;
  double all = 0, outside = 0;
  if (problem->W.a || d * problem->nc < rest_unknowns) return 0;
  const int told = work->options.limits.blocks; /* of bodies */
  const int blocks = problem->Wb.x ? problem->Wb.p[problem->nc] : told > 1 ? told : INT_MAX;
  if (blocks / problem->nc <= few_blocks) return 1;
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
  return outside <= share_outside * share_outside * all;
}

static int may_rest(const dlsi_auto *work) {
  return work->may_rest;
}

/* Returns 1 if (AT2) is there for this problem, and has not been tried. */
static int has_splitting(const dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  return problem->W.a && !work->has_split && problem->d * problem->nc >= split_unknowns;
}

static int may_split(const dlsi_auto *work) {
  if (!has_splitting(work)) return 0;
  const int dear = work->ahead > 0 && cost_of_split(work) > 2 * work->ahead;
  return work->costly || work->failures > dear;
}

/* Of bodies W by blocks is then formed only where a stage asks for it. */
static int is_large(const dlsi_auto *work) {
  return is_packing(work) && work->problem->nc > push_candidates;
}

static int may_copy(const dlsi_auto *work) {
  return work->problem->d * work->problem->nc <= path_unknowns;
}

/* Returns 1 if an infinite friction keeps pivots and paths away. */
static int is_bonded(const dlsi_auto *work) {
  return work->bonded && !work->firm;
}

static int may_pivot(const dlsi_auto *work) {
  if (is_bonded(work)) return 0;
  return work->nc <= (work->d <= 2 ? DLS_AUTO_LEMKE_2D : DLS_AUTO_LEMKE_3D);
}

/* Returns 1 if the table of (AT5) is small: 3 rows a candidate in 2D, 10 in 3D. */
static int may_pivot_early(const dlsi_auto *work) {
  return (work->d == 2 ? 3 : 10) * work->nc <= pivot_rows;
}

static int may_follow_path(const dlsi_auto *work) {
  return !is_bonded(work) && may_copy(work);
}

static int may_go_another_way(const dlsi_auto *work) {
  return work->problem->d * work->problem->nc <= other_unknowns;
}

/* Returns 1 for a residual so near the tolerance that an answer may lie beside it. */
static int is_nearly_met(const dlsi_auto *work, double residual) {
  return residual <= near_most * fmax(work->options.limits.tol, 1e-8);
}

static int may_settle(const dlsi_auto *work) {
  return is_nearly_met(work, work->info.certificate.residual);
}

static dls_status verdict_of(const dlsi_auto *work) {
  return dls_certificate_verdict(&work->info.certificate, work->options.limits.tol);
}

/* Method, its progress callback, when it is taken (NULL: always), its limit of iterations (0: its
 * own). */
static const struct {
  const dlsi_method *method;
  dls_progress_fn watch;
  int (*may)(const dlsi_auto *work);
  int most;
} part_of[] = {
    [SWEEPS] = {&dlsi_nlgs_method, watch_sweeps, may_sweep, 0},
    [SPLITTING] = {&dlsi_admm_method, watch_limits, may_split, dense_splits},
    [REST] = {&dlsi_rest_method, watch_limits, may_rest, 0},
    [NEWTON] = {&dlsi_newton_method, watch_newton, may_step, 0},
    [AUGMENTED] = {&dlsi_augmented_method, watch_limits, NULL, 0},
    [PIVOTING] = {&dlsi_lemke_method, watch_limits, may_pivot, 0},
    [OTHER_SWEEPS] = {&dlsi_nlgs_method, watch_limits, NULL, other_iterations},
    [OTHER_SPLITTING] = {&dlsi_admm_method, watch_limits, NULL, other_iterations},
    [HOMOTOPY] = {&dlsi_homotopy_method, watch_limits, may_follow_path, 0},
    [SCATTER] = {&dlsi_scatter_method, watch_limits, may_follow_path, 0},
    [PUSH] = {&dlsi_nlgs_method, watch_push, may_push, most_pushes},
    [SETTLE] = {&dlsi_admm_method, watch_limits, may_settle, settle_iterations},
};

/* The stages; cold: from r = 0, whatever was found before; copy: on a copy only (AT11); rest: a
 * search that goes on after its first part. */
static const struct {
  part part;
  int cold, copy, rest;
} stages[] = {
    {SWEEPS, 0, 0, 0},       {REST, 0, 0, 0},      {SPLITTING, 0, 0, 0},       {PUSH, 0, 0, 0},
    {NEWTON, 0, 0, 0},       {PIVOTING, 0, 0, 0},  {SPLITTING, 0, 0, 0},       {SWEEPS, 0, 0, 0},
    {NEWTON, 0, 0, 0},       {SPLITTING, 0, 0, 0}, {SWEEPS, 0, 0, 0},          {NEWTON, 0, 0, 0},
    {SWEEPS, 0, 0, 0},       {NEWTON, 0, 0, 0},    {SWEEPS, 0, 1, 0},          {NEWTON, 0, 1, 0},
    {PIVOTING, 0, 1, 0},     {AUGMENTED, 0, 0, 0}, {HOMOTOPY, 1, 1, 0},        {SCATTER, 0, 1, 0},
    {PIVOTING, 0, 1, 1},     {SWEEPS, 0, 0, 0},    {NEWTON, 0, 0, 0},          {SWEEPS, 0, 0, 0},
    {OTHER_SWEEPS, 1, 0, 0}, {NEWTON, 0, 0, 0},    {OTHER_SPLITTING, 1, 0, 0}, {NEWTON, 0, 0, 0},
    {AUGMENTED, 1, 0, 0},    {HOMOTOPY, 1, 1, 1},  {SCATTER, 0, 1, 1},         {SETTLE, 0, 1, 0}};
enum { quick_count = 14, stage_count = sizeof stages / sizeof stages[0] };
_Static_assert((int)stage_count - 1 + 3 <= (int)DLS_STAGES_MAX,
               "a line for each in the report, SPLITTING once, (AT14), the states, after the copy");

static dls_limits limits_of(dlsi_auto *work, part k) {
  const int blocks = work->options.limits.blocks;
  return (dls_limits){.tol = work->options.limits.tol,
                      .max_iterations = part_of[k].most,
                      .warm_start = k != PIVOTING && k != OTHER_SPLITTING,
                      .blocks = blocks,
                      .progress = part_of[k].watch,
                      .progress_data = work,
                      .cpu_seconds = dlsi_clock_left(&work->options.limits, work->begun),
                      .threads = work->options.limits.threads};
}

/* Returns the part whose workspace part k takes. */
static part home_of(part k) {
  return k == OTHER_SPLITTING || k == SETTLE ? SPLITTING : k;
}

static dls_status create_part(dlsi_auto *work, part k, dls_error *error) {
  dlsi_options options = work->options;
  if (work->part[k]) return DLS_OK;
  options.limits = limits_of(work, k);
  options.limits.cpu_seconds = 0; /* take_stage sets it */
  options.stage = k == OTHER_SWEEPS ? 2 : k == PUSH ? 3 : 1;
  options.room = &work->room;
  return part_of[k].method->create(&work->part[k], work->d, work->nc, &options, error);
}

/* Forms W of a problem of bodies by blocks. Errors of dlsi_form_blocks. */
static dls_status form_blocks(dlsi_auto *work, dls_error *error) {
  if (!dlsi_is_factored(work->problem)) return DLS_OK;
  const dls_status status = dlsi_form_blocks(&work->formed, &work->problem, error);
  if (status) return status;
  const int blocks = work->problem->Wb.p[work->problem->nc];
  if (blocks > work->options.limits.blocks) work->options.limits.blocks = blocks;
  return DLS_OK;
}

/* Returns how many steps without progress Newton's method may take: half of what comes after it. */
static int patience_of_newton(const dlsi_auto *work) {
  const double other = has_splitting(work) ? fmin(work->ahead, cost_of_split(work)) : work->ahead;
  return (int)fmin(fmax(other / (2 * work->step), first_patience), last_patience);
}

/* Takes one stage: its line in the report, and best := r if that is better. */
static dls_status take_stage(dlsi_auto *work, part k, int cold, dls_error *error) {
  dls_error why = {0};
  dls_status status = k == PUSH ? DLS_OK : form_blocks(work, &why);
  if (status == DLS_E_SIZE) return DLS_STALLED; /* too many blocks: sweeps on bodies alone */
  const dls_contact *problem = work->problem;
  const dls_certificate *best = &work->info.certificate;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  dls_info info = {.status = DLS_OK}, *all = &work->info;
  if (!status) status = create_part(work, home_of(k), &why);
  const dls_limits limits = limits_of(work, k);
  if (cold)
    memset(work->r, 0, m * sizeof *work->r);
  else
    memcpy(work->r, work->best, m * sizeof *work->r);
  const int measured = best->floor_u <= DBL_MAX; /* not at the first stage of all, or of a copy */
  work->target = log(measured ? dlsi_certificate_target(best, limits.tol) : limits.tol);
  work->least = log(best->residual);
  work->rate = 0;
  work->unknowns = count_unknowns(problem, work->r);
  work->since = 0;
  work->patience = patience_of_newton(work);
  if (!status) {
    dls_contact of_bodies = *problem; /* (AT13) takes the factors even where there are blocks */
    if (k == PUSH && problem->bodies.H) of_bodies.Wb = (dls_blocks){0};
    void *const home = work->part[home_of(k)];
    part_of[k].method->set_limits(home, &limits);
    status = part_of[k].method->solve(home, &of_bodies, work->r, NULL, &info, &why);
  }
  if (k == SPLITTING) work->has_split = 1;
  if (k == REST) work->may_rest = 0;
  if (k == PUSH && status == DLS_STALLED) work->has_pushed = 1;
  if (k == AUGMENTED) work->has_augmented = 1;
  if ((k == SPLITTING || k == OTHER_SPLITTING || k == REST) && status == DLS_E_UNSUPPORTED)
    return DLS_STALLED; /* a build without MUMPS */
  if (status < 0) {
    if (error) *error = why;
    return status;
  }
  if (work->stepped && !all->stages && status == DLS_STALLED && !info.iterations)
    return status;                                  /* (AT14) without a step */
  if (all->stages == DLS_STAGES_MAX) all->stages--; /* the last line is that of the last stage */
  all->stage[all->stages++] = (dls_stage){part_of[k].method->method, info.iterations,
                                          info.factorisations, info.certificate.residual};
  all->iterations += info.iterations;
  all->factorisations += info.factorisations;
  if (k == NEWTON && work->failures < most_failures) work->failures++;
  if (!dlsi_is_better(&info.certificate, best)) return status;
  all->certificate = info.certificate;
  memcpy(work->best, work->r, m * sizeof *work->best);
  return status;
}

/* Returns 1 if the augmented Lagrangian has ended with a direction delta along which W delta is 0
 * but for rounding: w: weights, set already. */
static int runs_away(const dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  const double *delta = dlsi_augmented_method.direction(work->part[AUGMENTED]);
  double *v = work->v[0];
  if (!delta) return 0;
  dlsi_contact_apply(problem, delta, v);
  for (size_t k = 0; k < m; k++)
    v[k] /= work->w[k / d];
  return dlsi_max_abs(v, m) <= null_direction * dlsi_max_abs(delta, m);
}

/* (AT9) for a problem that no stage has solved. Returns DLS_OK, DLS_NO_SOLUTION_LIKELY,
 * DLS_STALLED, or an error. */
static dls_status judge(dlsi_auto *work, dls_error *error) {
  const dls_contact *problem = work->problem;
  const double tol = work->options.limits.tol;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const int sure = work->excluded, few = problem->d == 2 && problem->nc <= dlsi_most_states;
  double *J = work->room.J;
  if (work->bonded || work->firm) return DLS_STALLED;
  work->room.owner = work;
  if (few && !sure) {
    const int found = dlsi_contact_find_states(problem, &work->options.limits, work->begun, work->r,
                                               work->best, &work->info.certificate);
    if (dlsi_clock_is_over(&work->options.limits, work->begun)) return DLS_TIME_LIMIT;
    const dls_status status = found ? take_stage(work, NEWTON, 0, error) : DLS_STALLED;
    if (status < 0) return status;
    if (dls_certificate_holds(&work->info.certificate, tol)) return DLS_OK;
    if (found) return DLS_STALLED;
  }
  if (!few && !sure &&
      (problem->nc > sure_starts || is_nearly_met(work, work->info.certificate.residual)))
    return DLS_STALLED;
  if (!may_follow_path(work) || work->room.side < m) return DLS_STALLED;
  dlsi_contact_weights(problem, work->w);
  if (!few && !sure && !runs_away(work)) return DLS_STALLED;
  if (!few && !sure && !dlsi_is_semidefinite(problem, work->w, J)) return DLS_STALLED;
  if (dlsi_solution_exists(problem, work->w, J, work->v)) return DLS_STALLED;
  return DLS_NO_SOLUTION_LIKELY;
}

/* Returns 1 if only rounding stands against the best r at the end of (AT12). */
static int is_rounded(const dlsi_auto *work, part now) {
  return now == REST && dlsi_certificate_meets(&work->info.certificate, work->options.limits.tol);
}

/* (AT17) The best r holds to rounding. Its self-stress, a part of r that W does not feel, may be
 * what rounds: ADMM from r = 0 finds reactions with little of it. Returns the verdict of the better
 * one, or an error. */
static dls_status take_less_stress(dlsi_auto *work, part now, dls_error *error) {
  if (now == OTHER_SPLITTING || !may_go_another_way(work)) return verdict_of(work);
  const dls_status status = take_stage(work, OTHER_SPLITTING, 1, error);
  return status < 0 ? status : work->stopped ? work->stopped : verdict_of(work);
}

/* Tells a search that its next solve is its first part, or the rest. Errors of create_part. */
static dls_status share_search(dlsi_auto *work, part k, int rest, dls_error *error) {
  void (*const share)(void *, int) = k == HOMOTOPY   ? dlsi_homotopy_share
                                     : k == SCATTER  ? dlsi_scatter_share
                                     : k == PIVOTING ? dlsi_contact_lemke_search
                                                     : NULL;
  const dls_status status = share ? create_part(work, k, error) : DLS_OK;
  if (share && !status) share(work->part[k], rest);
  return status;
}

/* Sets the compliances of the contacts and the weights of the certificate. */
static void set_weights(dlsi_auto *work) {
  dlsi_both_weights(work->problem, work->w, work->weights);
}

/* Turns to a copy of the problem, with r = 0 as the best. Returns the certificate of the best r of
 * the problem, which is work->kept then. */
static dls_certificate enter_copy(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const dls_certificate kept = work->info.certificate;
  memcpy(work->kept, work->best, m * sizeof *work->kept);
  memset(work->best, 0, m * sizeof *work->best);
  dlsi_renumber_set(&work->copy, problem, work->firm ? most_firm : INFINITY);
  work->problem = &work->copy.problem;
  work->info.certificate = dlsi_no_certificate;
  return kept;
}

/* Takes the vectors of the verdict back from the copy. */
static void take_back_vectors(dlsi_auto *work, dls_status status) {
  const dlsi_renumber *copy = &work->copy;
  const double *delta = work->part[AUGMENTED] && !work->excluded && status != DLS_NO_SOLUTION
                            ? dlsi_augmented_method.direction(work->part[AUGMENTED])
                            : NULL;
  work->has_direction = delta != NULL;
  const double *v = status == DLS_NO_SOLUTION || work->excluded
                        ? dlsi_lemke_method.farkas(work->part[PIVOTING])
                        : NULL;
  work->has_farkas = v != NULL;
  if (delta) dlsi_renumber_back(copy, copy->problem.d, 0, delta, work->direction);
  if (v) dlsi_renumber_back(copy, 1, 0, v, work->farkas);
}

/* Takes the best r back from the copy if it is better than the one kept. Returns the status for the
 * problem. */
static dls_status leave_copy(dlsi_auto *work, const dls_contact *problem,
                             const dls_certificate *kept, dls_status status) {
  const dlsi_renumber *copy = &work->copy;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  dls_certificate *best = &work->info.certificate;
  work->problem = problem;
  dlsi_renumber_back(copy, problem->d, copy->power_q - copy->power_W, work->best, work->r);
  dlsi_contact_multiply(problem, NULL, work->r, work->v[0], work->v[1]);
  set_weights(work);
  dlsi_contact_measure(problem, work->r, work->v[0], work->v[1], work->weights, work->v[2], best);
  /* forces beyond the range of numbers: an answer to the copy is none to the problem */
  const int in_range = best->residual <= DBL_MAX;
  if ((status == DLS_OK && in_range) || dlsi_is_better(best, kept)) {
    memcpy(work->best, work->r, m * sizeof *work->best);
  } else {
    memcpy(work->best, work->kept, m * sizeof *work->best);
    *best = *kept;
  }
  if (status == DLS_NO_SOLUTION_LIKELY && best->residual <= work->options.limits.tol)
    return DLS_STALLED; /* only rounding speaks against this answer */
  return status;
}

/* (AT5), early: on a copy, because paths depend on the order of the candidates. */
static dls_status pivot_early(dlsi_auto *work, dls_error *error) {
  const dls_contact *problem = work->problem;
  const dls_certificate kept = enter_copy(work);
  const dls_status status = take_stage(work, PIVOTING, 0, error);
  return status < 0 ? status : leave_copy(work, problem, &kept, status);
}

/* Takes the stages first .. end-1 in turn. Returns DLS_OK, DLS_TO_ROUNDING, DLS_NO_SOLUTION, an
 * error, DLS_CANCELLED or DLS_MAX_ITERATIONS; DLS_STALLED if nothing is decided, or `excluded`
 * is. */
static dls_status take_some(dlsi_auto *work, int first, int end, dls_error *error) {
  for (int k = first; k < end; k++) {
    const part listed = stages[k].part;
    const part now = listed == SWEEPS && !may_sweep(work) && may_push(work) ? PUSH : listed;
    if (listed == PUSH && is_near(work, work->info.certificate.residual)) continue;
    if (stages[k].copy && !work->has_copy) continue;
    if (part_of[now].may && !part_of[now].may(work)) continue;
    const int early = now == PIVOTING && k < quick_count;
    if (early && !may_pivot_early(work)) continue;
    if (stages[k].cold && !may_go_another_way(work)) continue;
    dls_status status = share_search(work, now, stages[k].rest, error);
    if (!status)
      status = early ? pivot_early(work, error) : take_stage(work, now, stages[k].cold, error);
    if (status < 0) return status;
    if (verdict_of(work) == DLS_OK) return DLS_OK;
    if (work->stopped) return work->stopped;
    if (verdict_of(work) == DLS_TO_ROUNDING) return take_less_stress(work, now, error);
    work->rounded = is_rounded(work, now);
    if (work->rounded) return DLS_STALLED;
    if (status == DLS_TIME_LIMIT) return status;
    if (work->limited) return DLS_MAX_ITERATIONS;
    const int excluded = now == PIVOTING && dlsi_contact_lemke_excludes(work->part[now]);
    if (work->firm && (status == DLS_NO_SOLUTION || excluded)) continue; /* of the copy alone */
    if (early && (status == DLS_NO_SOLUTION || excluded))
      return DLS_STALLED; /* (AT11) finds it again, for any order of the candidates */
    if (status == DLS_NO_SOLUTION) return status;
    work->excluded = excluded;
    if (excluded) return DLS_STALLED;
  }
  return DLS_STALLED;
}

/* (AT11) Takes the stages after the quick ones on a copy, from r = 0. */
static dls_status take_copy(dlsi_auto *work, dls_error *error) {
  const dls_contact *problem = work->problem;
  const dls_certificate kept = enter_copy(work);
  work->has_copy = 1;
  work->failures = copy_failures;
  dls_status status = take_some(work, quick_count, stage_count, error);
  if (status == DLS_STALLED) status = judge(work, error);
  if (status < 0) return status;
  take_back_vectors(work, status);
  status = leave_copy(work, problem, &kept, status);
  if ((status != DLS_OK && status != DLS_TO_ROUNDING) || verdict_of(work) != DLS_STALLED)
    return status == DLS_OK ? verdict_of(work) : status;
  status = take_stage(work, NEWTON, 0, error); /* sums in another order round otherwise */
  return status < 0 ? status : verdict_of(work);
}

/* Returns the sweeps that a solve with (AT14) is expected to take. */
static double expect_of_step(const dlsi_auto *work) {
  if (work->of_step > 0) return work->of_step;
  return fmax(-log10(work->options.limits.tol) / 2, 1) * step_sweeps;
}

/* Returns 1 if a warm solve begins with Newton's method (AT14). */
static int may_begin_with_step(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const int failed = work->failed_to_step;
  work->failed_to_step = 0;
  if (!work->options.limits.warm_start || failed || !problem->W.a) return 0;
  return work->swept > expect_of_step(work);
}

/* Measures r, and keeps it as the best one if it is better. Scratch: v. */
static void offer(dlsi_auto *work, const double *r) {
  const dls_contact *problem = work->problem;
  dls_certificate now;
  dlsi_contact_multiply(problem, NULL, r, work->v[0], work->v[1]);
  dlsi_contact_measure(problem, r, work->v[0], work->v[1], work->weights, work->v[2], &now);
  if (!dlsi_is_better(&now, &work->info.certificate)) return;
  work->info.certificate = now;
  memcpy(work->best, r, (size_t)problem->d * (size_t)problem->nc * sizeof *r);
}

/* Returns the residual of r with v[0] as its u. */
static double expect(dlsi_auto *work, const double *r) {
  const dls_contact *problem = work->problem;
  dls_certificate now;
  memset(work->v[1], 0, (size_t)problem->d * (size_t)problem->nc * sizeof *r);
  dlsi_contact_measure(problem, r, work->v[0], work->v[1], work->weights, work->v[2], &now);
  return now.residual;
}

/* (AT15) Returns 1 if the certificate of the start holds already. With the same W both starts are
 * measured without a product, since W r is linear in r; with another one this is a guess. */
static int predict(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const auto_answer *a = &work->last, *b = &work->former;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  work->known = work->far = 0;
  if (work->answers < 2 || work->last_nc != problem->nc ||
      memcmp(a->r, work->best, m * sizeof *a->r) != 0)
    return 0;
  set_weights(work);
  for (size_t k = 0; k < m; k++)
    work->v[0][k] = a->Wr[k] + problem->q[k];
  double residual = expect(work, a->r);
  for (size_t k = 0; k < m; k++) {
    work->r[k] = 2 * a->r[k] - b->r[k];
    work->v[0][k] = 2 * a->Wr[k] - b->Wr[k] + problem->q[k];
  }
  const double of_line = expect(work, work->r);
  if (of_line < residual) {
    residual = of_line;
    memcpy(work->best, work->r, m * sizeof *work->best);
  } else
    for (size_t k = 0; k < m; k++)
      work->v[0][k] = a->Wr[k] + problem->q[k];
  work->known = residual > work->options.limits.tol;
  work->far = residual > far_start;
  if (work->known) return 0;
  memcpy(work->r, work->best, m * sizeof *work->r);
  offer(work, work->r);
  return dls_certificate_holds(&work->info.certificate, work->options.limits.tol);
}

/* Remembers the answer of a warm solve. u: that of r, NULL: not known. */
static void remember_answer(dlsi_auto *work, const double *r, const double *u) {
  const dls_contact *problem = work->problem;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const auto_answer oldest = work->former;
  const int last = work->info.stages - 1;
  if (!u && work->info.status == DLS_OK && !work->has_copy && last >= 0 &&
      work->info.stage[last].method == DLS_NEWTON)
    u = dlsi_newton_gap(work->part[NEWTON]);
  work->answers = work->answers && work->last_nc == problem->nc ? 2 : 1;
  work->last_nc = problem->nc;
  work->former = work->last;
  work->last = oldest;
  memcpy(oldest.r, r, m * sizeof *r);
  if (!u) dlsi_contact_multiply(problem, NULL, r, work->v[0], NULL);
  if (!u) u = work->v[0];
  for (size_t k = 0; k < m; k++)
    oldest.Wr[k] = u[k] - problem->q[k];
}

/* (AT14) Returns DLS_OK, an error, the reason for the end, or DLS_STALLED to go on. */
static dls_status take_step(dlsi_auto *work, dls_error *error) {
  dls_status status = create_part(work, NEWTON, error);
  if (status) return status;
  work->stepped = 1;
  work->of_step = expect_of_step(work);
  dlsi_newton_keep(work->part[NEWTON], work->known ? work->v[0] : NULL, work->far);
  status = take_stage(work, NEWTON, 0, error);
  work->failures = 0;
  if (!work->info.stages && status >= 0) { /* without a step */
    work->stepped = 0;
    return DLS_STALLED;
  }
  if (status < 0) return status;
  if (verdict_of(work) != DLS_STALLED) return verdict_of(work);
  work->failed_to_step = 1;
  if (work->known) offer(work, work->last.r); /* what the step has begun with has no certificate */
  if (work->stopped) return work->stopped;
  if (status == DLS_TIME_LIMIT) return status;
  return work->limited ? DLS_MAX_ITERATIONS : DLS_STALLED;
}

/* Takes the stages in turn. Returns DLS_OK, an error, or the reason for the end. */
static dls_status take_stages(dlsi_auto *work, dls_error *error) {
  if (work->options.limits.warm_start && predict(work)) return DLS_OK;
  dls_status status = may_begin_with_step(work) ? take_step(work, error) : DLS_STALLED;
  if (status != DLS_STALLED) return status;
  status = take_some(work, 0, quick_count, error);
  if (status != DLS_STALLED || work->rounded) return status;
  if (!may_copy(work)) {
    status = take_some(work, quick_count, stage_count, error);
    return status == DLS_STALLED ? judge(work, error) : status;
  }
  status = take_copy(work, error);
  if (status != DLS_STALLED || !work->firm) return status;
  work->firm = 0;
  return take_copy(work, error);
}

/* (AT18) An answer of little residual may have a large error where W is nearly singular: soft
 * springs under a body. Solves to a smaller tolerance as long as that makes the predicted error
 * less. In a sequence of warm solves the last answer that was looked at tells how much a residual
 * means. */
static dls_status take_to_accuracy(dlsi_auto *work, dls_error *error) {
  const dls_contact *problem = work->problem;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const double tol = work->options.limits.tol, enough = fmax(accurate, 100 * tol);
  const dls_certificate *best = &work->info.certificate;
  dls_status status = DLS_OK;
  const int rows = problem->W.a ? dlsi_predicted_rows : dlsi_predicted_of_blocks;
  const dls_info *info = &work->info;
  const int direct = m > dlsi_predicted_of_blocks && info->stages &&
                     info->stage[info->stages - 1].method != DLS_NLGS;
  if (m > (size_t)rows || best->residual == 0 || (direct && best->residual <= determined))
    return status;
  const int known = work->amplified > 0 && work->last_nc == problem->nc;
  if (work->options.limits.warm_start && known && work->amplified * best->residual <= enough) {
    work->info.error = work->amplified * best->residual;
    return status;
  }
  double before = INFINITY;
  for (int turn = 0; status == DLS_OK; turn++) {
    if (work->options.lazy && dlsi_room_dense(&work->room, m, NULL)) break;
    set_weights(work);
    work->room.owner = work;
    dlsi_contact_multiply(problem, NULL, work->best, work->v[0], NULL);
    const double predicted = dlsi_predict_error(problem, work->best, work->v[0], work->weights,
                                                work->room.J, work->v[1]);
    work->info.error = predicted < 0 ? INFINITY : predicted; /* not determined */
    work->amplified = work->info.error / best->residual;
    if (!(predicted > enough && predicted < before / 2) || turn == most_turns) break;
    before = predicted;
    work->options.limits.tol = fmax(best->residual * enough / before / 2, DBL_EPSILON);
    status = take_some(work, 0, quick_count, error);
    work->options.limits.tol = tol;
    if (status >= 0) status = work->stopped ? work->stopped : verdict_of(work);
  }
  return status;
}

/* Returns room for W_nn, or NULL where there is friction, its factorisation would be more than a
 * small part of what the solve took, or the room keeps factors for the next solve. */
static double *room_of_normals(dlsi_auto *work) {
  const size_t n = (size_t)work->problem->nc;
  const double m = (double)n * work->problem->d, cost = (double)n * (double)n * (double)n / 3;
  double spent = 0;
  for (size_t c = 0; c < n; c++)
    if (work->problem->mu[c] > 0) return NULL;
  for (int k = 0; k < work->info.stages; k++)
    spent += 2 * m * m * work->info.stage[k].iterations +
             m * m * m / 3 * work->info.stage[k].factorisations;
  if (work->options.limits.warm_start || (n > few_normals && cost > small_part * spent))
    return NULL;
  if (work->options.lazy && dlsi_room_dense(&work->room, n, NULL)) return NULL;
  if (work->room.side < n) return NULL;
  work->room.owner = work;
  return work->room.J;
}

/* Counts the ambiguous candidates. Sets unique to no if as many sweeps as the answer r took, from
 * where these have another solution by themselves, end at another answer. */
static void sweep_to_another(dlsi_auto *work, const double *r) {
  const dls_contact *problem = work->problem;
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  double *other = work->v[1];
  dls_limits limits = {.tol = work->options.limits.tol, .warm_start = 1};
  dls_info info;
  dlsi_contact_multiply(problem, NULL, r, work->v[0], NULL);
  work->info.ambiguous = dlsi_count_ambiguous(problem, r, work->v[0], other);
  if (!work->info.ambiguous || !work->part[SWEEPS]) return;
  limits.cpu_seconds = dlsi_clock_left(&work->options.limits, work->begun);
  limits.max_iterations = work->info.iterations > 10 ? work->info.iterations : 10;
  dlsi_nlgs_method.set_limits(work->part[SWEEPS], &limits);
  if (dlsi_nlgs_method.solve(work->part[SWEEPS], problem, other, NULL, &info, NULL)) return;
  double difference = 0, size = 0;
  for (size_t k = 0; k < m; k++) {
    const double w = work->w[k / d];
    difference = fmax(difference, fabs(w * (other[k] - r[k])));
    size = fmax(size, fabs(w * r[k]));
  }
  if (difference > another * size) work->info.unique = DLS_UNIQUE_NO;
}

/* Fills ambiguous and unique for the answer r. */
static void look_for_others(dlsi_auto *work, const double *r) {
  const dls_contact *problem = work->problem;
  set_weights(work);
  if (dlsi_may_be_ambiguous(problem))
    sweep_to_another(work, r);
  else if (dlsi_is_unique(problem, work->w, work->v[2], room_of_normals(work)))
    work->info.unique = DLS_UNIQUE_YES;
}

/* Remembers for (AT14) what the solve took. */
static void remember_cost(dlsi_auto *work, const double *r) {
  const dls_info *info = &work->info;
  if (!info->stages) return; /* it had nothing to do */
  const double k = info->factorisations ? count_unknowns(work->problem, r) : 0;
  const double factors = 3 + k * k / (10. * work->problem->d * work->problem->nc);
  double cost = 0;
  for (int s = 0; s < info->stages; s++) {
    const int newton = info->stage[s].method == DLS_NEWTON;
    cost += (newton ? step_sweeps : 1) * info->stage[s].iterations;
    cost += newton ? factors * info->stage[s].factorisations : 0;
  }
  if (!work->stepped) {
    work->of_step *= forgotten;
    work->swept = cost;
  } else {
    if (!work->in_steps && info->factorisations) cost -= factors;
    work->of_step += (cost - work->of_step) / 6;
  }
  work->in_steps = work->stepped;
}

/* Prepares a solve of this problem from r = 0. Errors of dlsi_form_blocks. */
static dls_status begin_solve(dlsi_auto *work, const dls_contact *problem, dls_error *error) {
  work->problem = problem;
  const dls_status status = is_large(work) ? DLS_OK : form_blocks(work, error);
  if (status) return status;
  problem = work->problem;
  work->bonded = dlsi_first_bonded(problem) >= 0;
  work->firm = may_copy(work) && dlsi_max_abs(problem->mu, (size_t)problem->nc) > most_firm;
  work->info = (dls_info){.method = DLS_AUTO, .certificate = dlsi_no_certificate};
  work->stopped = DLS_OK;
  work->limited = work->failures = work->has_split = work->costly = work->rounded = 0;
  work->has_copy = work->has_direction = work->has_farkas = work->excluded = 0;
  work->may_rest = looks_at_rest(work);
  work->has_pushed = work->has_augmented = work->stepped = 0;
  work->ahead = 0;
  work->step = 1;
  memset(work->best, 0, (size_t)problem->d * (size_t)problem->nc * sizeof *work->best);
  return DLS_OK;
}

/* (AT16) Solves the problem of `count` candidates that may touch. values: memory of the copy.
 * Returns as take_touching does. */
static dls_status take_others(dlsi_auto *work, const dls_contact *problem, int count,
                              double *values, dls_error *error) {
  dls_contact others;
  dlsi_subset(problem, count, work->touching, values, NULL, &others);
  dls_status status = begin_solve(work, &others, error);
  if (status) return status;
  work->touches = count;
  status = take_stages(work, error);
  memcpy(work->r, work->best, (size_t)problem->d * (size_t)count * sizeof *work->r);
  put_among_all(work, work->r, work->best);
  work->touches = 0;
  work->problem = problem;
  if (status < 0) return status;
  set_weights(work);
  dlsi_contact_multiply(problem, NULL, work->best, work->v[0], work->v[1]);
  dlsi_contact_measure(problem, work->best, work->v[0], work->v[1], work->weights, work->v[2],
                       &work->info.certificate);
  if (verdict_of(work) != DLS_STALLED) return verdict_of(work);
  return work->stopped || work->limited || status == DLS_TIME_LIMIT ? status : DLS_STALLED;
}

/* (AT16) Returns DLS_OK, an error, the reason for an end by the caller, or DLS_STALLED to go on. */
static dls_status take_touching(dlsi_auto *work, const dls_contact *problem, dls_error *error) {
  const int count = dlsi_list_touching(problem, &work->touching);
  const size_t d = (size_t)problem->d, n = (size_t)count, m = d * n;
  dls_status status = DLS_STALLED;
  if (count == 0) return status;
  double *values = dlsi_alloc(m * m + m + n + d * (size_t)problem->nc, sizeof *values);
  if (values) { /* else the whole, which needs no copy */
    work->shown = values + m * m + m + n;
    status = take_others(work, problem, count, values, error);
  }
  free(values);
  free(work->touching);
  work->touching = NULL;
  return status;
}

static dls_status auto_solve(void *automatic, const dls_contact *problem, double *r, double *u,
                             dls_info *info, dls_error *error) {
  dlsi_auto *work = automatic;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const int warm = work->options.limits.warm_start;
  work->begun = dlsi_clock_start(&work->options.limits);
  work->whole = problem->nc;
  dls_status status = dlsi_lend(&work->formed, &problem, error);
  if (status) return status;
  status = warm ? DLS_STALLED : take_touching(work, problem, error);
  if (status == DLS_STALLED) {
    status = begin_solve(work, problem, error);
    if (status) return status;
    if (warm) memcpy(work->best, r, m * sizeof *r);
    status = take_stages(work, error);
  }
  if (status < 0) return status;
  status = dlsi_settled(&work->info.certificate, work->options.limits.tol, status);
  if (status == DLS_OK) status = take_to_accuracy(work, error);
  if (status < 0) return status;
  problem = work->problem;
  memcpy(r, work->best, m * sizeof *r);
  if (u) dlsi_contact_multiply(problem, NULL, r, work->v[0], NULL);
  if (u) memcpy(u, work->v[0], m * sizeof *u);
  work->info.status = status;
  remember_cost(work, r);
  if (warm) remember_answer(work, r, u);
  if (info && status == DLS_OK) look_for_others(work, r);
  if (info) *info = work->info;
  return status;
}

static const double *auto_direction(const void *automatic) {
  const dlsi_auto *work = automatic;
  if (work->has_copy) return work->has_direction ? work->direction : NULL;
  return dlsi_augmented_method.direction(work->part[AUGMENTED]);
}

static const double *auto_farkas(const void *automatic) {
  const dlsi_auto *work = automatic;
  return work->has_farkas ? work->farkas : NULL;
}

static void auto_set_limits(void *automatic, const dls_limits *limits) {
  dlsi_set_limits(&((dlsi_auto *)automatic)->options.limits, limits);
}

/* ---- create ---------------------------------------------------------------------------------- */

static void auto_destroy(void *automatic) {
  dlsi_auto *work = automatic;
  if (!work) return;
  for (part k = 0; k < parts; k++)
    part_of[k].method->destroy(work->part[k]);
  dlsi_room_free(&work->room);
  dlsi_formed_free(&work->formed);
  free(work);
}

static void auto_carve(void *automatic, dlsi_arena *arena) {
  dlsi_auto *work = automatic;
  const size_t m = (size_t)work->d * (size_t)work->nc;
  work->r = dlsi_take(arena, m, sizeof *work->r);
  work->best = dlsi_take(arena, m, sizeof *work->best);
  work->w = dlsi_take(arena, (size_t)work->nc, sizeof *work->w);
  work->weights = dlsi_take(arena, 2 * (size_t)work->nc, sizeof *work->weights);
  double **const answers[] = {&work->last.r, &work->last.Wr, &work->former.r, &work->former.Wr};
  dlsi_take_vectors(arena, m, 4, answers);
  for (int k = 0; k < 3; k++)
    work->v[k] = dlsi_take(arena, m, sizeof *work->v[k]);
  if (m > path_unknowns) return;
  work->v[3] = dlsi_take(arena, m, sizeof *work->v[3]);
  dlsi_renumber_carve(&work->copy, arena, work->d, work->nc);
  work->kept = dlsi_take(arena, m, sizeof *work->kept);
  work->direction = dlsi_take(arena, m, sizeof *work->direction);
  work->farkas = dlsi_take(arena, (size_t)work->nc, sizeof *work->farkas);
}

static dls_status auto_create(void **out, int d, int nc, const dlsi_options *options,
                              dls_error *error) {
  dlsi_auto filled = {.options = *options, .d = d, .nc = nc};
  void *memory;
  dls_status status = dlsi_workspace(&memory, &filled, sizeof filled, auto_carve, nc, error);
  if (status) return status;
  dlsi_auto *work = memory;
  for (part k = 0; !status && !options->lazy && k < parts; k++) {
    const int m = d * nc, large = m > other_unknowns;
    if (home_of(k) != k) continue;
    if (k == REST && m < rest_unknowns) continue;
    if (k == PUSH && (nc <= few_push || !options->limits.blocks)) continue;
    const int blocks = options->limits.blocks;
    if (k == SWEEPS && nc > push_candidates && blocks && blocks / nc < nc / 4) continue;
    if (k == PIVOTING && !may_pivot(work)) continue;
    if ((k == HOMOTOPY || k == SCATTER) && m > path_unknowns) continue;
    if (k == OTHER_SWEEPS && large) continue;
    status = create_part(work, k, error);
  }
  if (!status && !options->lazy && d * nc <= path_unknowns) /* (AT11) is dense */
    status = dlsi_room_dense(&work->room, (size_t)(d * nc), error);
  if (status)
    auto_destroy(work);
  else
    *out = work;
  return status;
}

const dlsi_method dlsi_auto_method = {
    .method = DLS_AUTO,
    .name = "auto",
    .summary = "2D, 3D, any W: the default; the others in turn, as their progress and cost tell",
    .create = auto_create,
    .solve = auto_solve,
    .destroy = auto_destroy,
    .set_limits = auto_set_limits,
    .direction = auto_direction,
    .farkas = auto_farkas,
    .takes_bodies = 1,
};
