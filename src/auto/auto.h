/*
 * auto.h: what the files of the method auto share: its steps, its plans, and the state of a solve.
 */
#ifndef DLSI_AUTO_H
#define DLSI_AUTO_H

#include <stdint.h>

#include "auto/constants.h"
#include "facts/facts.h"
#include "linear/room.h"
#include "vi/vi_internal.h"

/* Each method once, and some once more for another way. */
typedef enum part {
  SWEEPS,         /* Gauss-Seidel with Anderson's acceleration */
  SPLITTING,      /* ADMM, once, for a dense W */
  REST,           /* the convex problem without mu |u_t|, for what may be at rest */
  NEWTON,         /* from the states that the steps before have sorted */
  AUGMENTED,      /* the augmented Lagrangian, which sees reactions run away */
  PIVOTING,       /* Lemke's method, and its proof that there is no solution */
  COLD_SPLITTING, /* ADMM with rho from 1e-8 on */
  HOMOTOPY,       /* interior homotopy */
  SCATTER,        /* Newton's method from scattered starts */
  PUSH,           /* Gauss-Seidel with momentum, in turn with Anderson's acceleration */
  SETTLE,         /* ADMM from a near r: an answer may lie beside it in a narrow basin */
  parts,
  END = parts,
  AGAIN /* back by `most` steps, while one of them has given way to another */
} part;

/* A step of a plan. */
typedef enum step_flags {
  COLD = 1,        /* from r = 0, whatever was found before */
  EARLY = 2,       /* on a copy of its own, and only if that is cheap for so few contacts */
  IN_TURN = 4,     /* in turns of equal cost with momentum (plan.c) */
  SORTED = 8,      /* only where most states are those of the answer: e <= dlsi_auto_unsorted */
  ANY_SWEEPS = 16, /* SWEEPS, or PUSH where those are not open */
  SMALL = 32       /* only where W is dense and has few rows: dlsi_auto_may_augment_early */
} step_flags;

typedef struct step {
  part part;
  unsigned flags; /* of step_flags */
  int most;       /* iterations; 0: those of its kind */
} step;

/* What the caller has named: dls_solver_settings.plan, .without. */
typedef struct dlsi_auto_given {
  int steps;                     /* of the plan; 0: it is auto's own */
  step step[DLS_STAGES_MAX + 1]; /* ends with END */
  unsigned without;              /* bit k: part k is left out */
} dlsi_auto_given;

/* A copy of a problem in an order and in units of its own (renumber.c). */
typedef struct dlsi_renumber {
  dls_contact problem;  /* the copy, W dense */
  double *W, *q, *mu;   /* its arrays: m x m, m, nc */
  double *weights;      /* 2 nc, where the problem has weights */
  int *from;            /* its candidate c is from[c] of the problem; 3 nc, the rest scratch */
  int power_W, power_q; /* W and q of the problem are 2 to these powers times those of the copy */
  double *key[3];       /* scratch, nc each */
  uint64_t *code;       /* scratch, 2 nc */
} dlsi_renumber;

void dlsi_renumber_carve(dlsi_renumber *copy, dlsi_arena *arena, int d, int nc);

/* most_mu: larger frictions become this one. */
void dlsi_renumber_set(dlsi_renumber *copy, const dls_contact *problem, double most_mu);

/* back := x, `entries` numbers per candidate, in the order of the problem, times 2^power. */
void dlsi_renumber_back(const dlsi_renumber *copy, int entries, int power, const double *x,
                        double *back);

typedef struct auto_answer {
  double *r, *Wr; /* m */
} auto_answer;

/* What the steps of the solve have done so far. The conditions of later steps read it. */
typedef struct dlsi_auto_history {
  int taken[parts];        /* times */
  int iterations[parts];   /* of all these */
  dls_reason ended[parts]; /* the last time */
  part last;               /* the last of all steps */
} dlsi_auto_history;

typedef struct dlsi_auto {
  dlsi_options options;
  int d, nc;
  void *part[parts];  /* workspace of each method, NULL before it is needed, or by its home_of */
  dlsi_room room;     /* for their matrices: none keeps factors from one step to the next */
  double *r, *best;   /* m: of the step under way, of the best answer so far */
  double *w;          /* nc: compliances of the contacts */
  double *weights;    /* 2 nc: of the certificate */
  double *v[4];       /* m: scratch; the last one up to dlsi_auto_small rows */
  dlsi_formed formed; /* of a problem of bodies: scratch, W by blocks for all but momentum */
  dlsi_renumber copy; /* up to dlsi_auto_small rows */
  double *kept;       /* m: the best r before the copy */
  double *direction;  /* m: the vectors of a verdict on the copy, in the order of the problem */
  double *farkas;     /* nc */
  int *touching;      /* those of the problem of the others; NULL in between */
  double *shown;      /* m: then, r of all candidates for the caller's callback */
  dlsi_auto_given *given; /* what the caller has named; NULL: nothing */

  /* of the solves before; sequence.c */
  int failed_to_step, in_steps;
  double swept;   /* what the last one without (SQ2) took, in sweeps */
  double of_step; /* what one with (SQ2) is expected to take, 0: as the first */
  int answers;    /* so many of the next two are there, of last_nc candidates */
  int last_nc;
  int mapped;               /* contacts have come or gone since: W r is not known */
  double amplified;         /* error over residual of the last answer looked at */
  auto_answer last, former; /* of the solve before, and of the one before that */

  /* of the solve under way */
  const dls_contact *problem; /* the caller's, or the copy */
  int has_copy, has_direction, has_farkas;
  int touches;        /* candidates of the problem of the others; 0: the whole is solved */
  int whole;          /* candidates of the caller's problem */
  int bonded;         /* a candidate has infinite friction: no pivoting, path or verdict */
  int firm;           /* copies have frictions up to dlsi_auto_firm, and decide nothing */
  int excluded;       /* no r can be certified */
  dls_info info;      /* its certificate is that of best */
  dls_status stopped; /* by a limit of the caller; DLS_OK: by none */
  double begun;       /* CPU seconds when the solve began; -1: nobody asks */
  dlsi_auto_history history;
  double convex_from; /* sweeps from which the convex problem is worth a try; INFINITY: never */
  double turn;  /* sweeps of momentum in this turn, then as much of the augmented Lagrangian */
  double start; /* e of the start with v[0] as its u, (SQ1); 0: v[0] is no u */
  int stepped;  /* began with (SQ2) */

  /* of the step under way */
  int in_turn;          /* the augmented Lagrangian ends when it has cost `turn` */
  int counted;          /* of a plan that the caller has named: no forecast ends the step, */
  int most;             /* ... but so many iterations do, if not 0 */
  dls_reason why;       /* why its watch has ended it, and ... */
  double foreseen[2];   /* ... what that foresaw, dls_stage.ahead and .next */
  double target, least; /* logarithms of e* and of the least e that counts */
  double rate;          /* of (FC1) */
  int near;             /* a warm start, e at most far_start after a sweep */
  double unknowns;      /* k of (PR2) at the last look */
  double step;          /* a step of Newton's method, in sweeps */
  double ahead;         /* (FC1) at the last look */
  int patience;         /* steps of Newton's method without progress */
  int costly;           /* Newton's steps, beside splitting */
  int since;            /* iteration of the least e; of momentum: of the last look */
} dlsi_auto;

/* Sets the compliances and the weights of the certificate. */
static inline void dlsi_auto_set_weights(dlsi_auto *work) {
  dlsi_both_weights(work->problem, work->w, work->weights);
}

static inline dls_status dlsi_auto_verdict_of(const dlsi_auto *work) {
  return dls_certificate_verdict(&work->info.certificate, work->options.limits.tol);
}

/* Returns the sweeps of the steps that have ended. */
static inline int dlsi_auto_sweeps(const dlsi_auto *work) {
  return work->history.iterations[SWEEPS] + work->history.iterations[PUSH];
}

/* Returns how often Newton's method has failed, up to the number that counts. */
static inline int dlsi_auto_failures(const dlsi_auto *work) {
  const int taken = work->history.taken[NEWTON];
  return work->has_copy || taken > dlsi_auto_most_failures ? dlsi_auto_most_failures : taken;
}

/* Returns 1 if momentum got nowhere. */
static inline int dlsi_auto_has_pushed(const dlsi_auto *work) {
  return work->history.taken[PUSH] && work->history.ended[PUSH] == DLS_REASON_NO_PROGRESS;
}

/* Returns 1 if the augmented Lagrangian has ended, and not to give way. */
static inline int dlsi_auto_has_augmented(const dlsi_auto *work) {
  return work->history.taken[AUGMENTED] && work->history.ended[AUGMENTED] != DLS_REASON_COSTLIER;
}

/* ---- plan.c: which steps are open to this problem, now --------------------------------------- */

int dlsi_auto_is_packing(const dlsi_auto *work);
int dlsi_auto_is_few(const dlsi_auto *work);
dls_regime dlsi_auto_regime(const dlsi_auto *work);
int dlsi_auto_is_near(const dlsi_auto *work, double residual); /* for Newton's steps on a packing */
int dlsi_auto_looks_at_rest(const dlsi_auto *work); /* and the convex problem is allowed */
double dlsi_auto_first_try(const dlsi_auto *work);  /* of the convex problem: convex_from */
int dlsi_auto_has_splitting(const dlsi_auto *work);
int dlsi_auto_may_sweep(const dlsi_auto *work);
int dlsi_auto_may_take_turn(const dlsi_auto *work);     /* IN_TURN */
int dlsi_auto_may_augment_early(const dlsi_auto *work); /* SMALL */
int dlsi_auto_may_pivot(const dlsi_auto *work);
int dlsi_auto_may_go_early(const dlsi_auto *work, part k); /* EARLY */
int dlsi_auto_may_follow_path(const dlsi_auto *work);
int dlsi_auto_may_settle(const dlsi_auto *work); /* an answer may lie beside the best r */
int dlsi_auto_may_copy(const dlsi_auto *work);
int dlsi_auto_may_go_another_way(const dlsi_auto *work);

/* Returns 1 if a step that the caller has named can be taken at all. */
int dlsi_auto_can_take(const dlsi_auto *work, part k);

/* What a step runs: its name, its method, whether it is open (NULL: always), its limit of
 * iterations (0: that of the method). */
typedef struct step_kind {
  dls_step step;
  const dlsi_method *method;
  int (*may)(const dlsi_auto *work);
  int most;
} step_kind;

extern const step_kind dlsi_auto_kind[parts];

const step *dlsi_auto_first_plan(const dlsi_auto *work);
extern const step dlsi_auto_plan_on_copy[], dlsi_auto_plan_beyond[];

/* ---- price.c --------------------------------------------------------------------------------- */

/* Returns the unknowns that the states of r leave to a step of Newton's method. */
double dlsi_auto_count_unknowns(const dls_contact *problem, const double *r);
double dlsi_auto_cost_of_newton(dlsi_auto *work);      /* (PR2), sweeps */
double dlsi_auto_cost_of_split(const dlsi_auto *work); /* (PR3), sweeps */

double dlsi_auto_cost_of_augmented(const dlsi_auto *work); /* (PR5), sweeps */
int dlsi_auto_factors_of_turn(const dlsi_auto *work);

/* (PR4) Returns what a line of the report has cost, in sweeps; k: unknowns. */
double dlsi_auto_price_of(const dls_contact *problem, double k, const dls_stage *stage);

/* ---- forecast.c: progress callbacks of the steps --------------------------------------------- */

/* Returns the callback of the step under way, of part k. */
dls_progress_fn dlsi_auto_watch_of(const dlsi_auto *work, part k);

/* Sets what it watches the step by, from work->r. */
void dlsi_auto_begin_watch(dlsi_auto *work);

/* The methods that auto is made of, beside Lemke's; vi/. */
extern const dlsi_method dlsi_nlgs_method, dlsi_newton_method, dlsi_admm_method,
    dlsi_augmented_method, dlsi_homotopy_method, dlsi_scatter_method, dlsi_rest_method;

/* ---- words.c --------------------------------------------------------------------------------- */

/* *given := what these name; NULL: nothing. DLS_E_ARGUMENT. */
dls_status dlsi_auto_read_words(const char *plan, const char *without, dlsi_auto_given *given,
                                dls_error *error);

static inline int dlsi_auto_has_plan(const dlsi_auto *work) {
  return work->given && work->given->steps > 0;
}

static inline int dlsi_auto_is_left_out(const dlsi_auto *work, part k) {
  return work->given && (work->given->without >> k & 1U);
}

/* ---- step.c ---------------------------------------------------------------------------------- */

/* Takes the open steps of the plan in turn. Returns DLS_OK, DLS_TO_ROUNDING, DLS_NO_SOLUTION, an
 * error, DLS_CANCELLED, DLS_TIME_LIMIT or DLS_MAX_ITERATIONS; DLS_STALLED if nothing is decided, or
 * `excluded` is. */
dls_status dlsi_auto_follow(dlsi_auto *work, const step *plan, dls_error *error);

/* (ST2) Returns 1 if only the rounding of W r stands against the best r. */
int dlsi_auto_is_rounded(const dlsi_auto *work);

/* Takes one step: its line in the report, and best := r if that is better. */
dls_status dlsi_auto_take_step(dlsi_auto *work, step s, dls_error *error);

dls_status dlsi_auto_create_part(dlsi_auto *work, part k, dls_error *error);
part dlsi_auto_home_of(part k); /* the part whose workspace part k takes */
dls_status dlsi_auto_form_blocks(dlsi_auto *work, dls_error *error);

/* ---- sequence.c ------------------------------------------------------------------------------ */

/* (SQ1) Returns 1 if the certificate of the start holds already. */
int dlsi_auto_predict(dlsi_auto *work);

/* (SQ2) Returns DLS_OK, an error, the reason for the end, or DLS_STALLED to go on. */
dls_status dlsi_auto_begin_with_newton(dlsi_auto *work, dls_error *error);

void dlsi_auto_map(void *automatic, int nc, const int *from); /* (SQ3) */

void dlsi_auto_remember_cost(dlsi_auto *work, const double *r);
void dlsi_auto_remember_answer(dlsi_auto *work, const double *r, const double *u);

/* ---- renumber.c, apart.c: another problem in the place of the caller's ---------------------- */

typedef dls_status (*dlsi_auto_run_fn)(dlsi_auto *work, const step *plan, dls_error *error);
typedef dls_status (*dlsi_auto_solve_fn)(dlsi_auto *work, const dls_contact *problem,
                                         dls_error *error);

/* Runs from r = 0 on a copy of the problem; the best r is that of the problem afterwards. Returns
 * what holds of the problem. */
dls_status dlsi_auto_on_copy(dlsi_auto *work, dlsi_auto_run_fn run, const step *plan,
                             dls_error *error);

/* *list := the candidates of a problem that may touch, ascending, where W is dense and at least two
 * in five of the candidates provably cannot; the caller frees it. Returns how many; 0, *list NULL,
 * where that is not so. */
int dlsi_list_touching(const dls_contact *problem, int **list);

/* Solves the problem of the candidates that may touch, if that pays. Returns DLS_OK, an error, the
 * reason for an end by the caller, or DLS_STALLED to go on. */
dls_status dlsi_auto_take_touching(dlsi_auto *work, const dls_contact *problem,
                                   dlsi_auto_solve_fn solve, dls_error *error);

/* all := r of the candidates that may touch, 0 for the others. */
void dlsi_auto_put_among_all(const dlsi_auto *work, const double *r, double *all);

/* ---- verdict.c, accuracy.c ------------------------------------------------------------------- */

/* For a problem that no step has solved. Returns DLS_OK, DLS_NO_SOLUTION_LIKELY, DLS_STALLED, or
 * an error. */
dls_status dlsi_auto_judge(dlsi_auto *work, dls_error *error);

/* Where `status` is DLS_STALLED or DLS_NO_SOLUTION_LIKELY: tries to prove the best r. If that
 * succeeds the best r is the improved one, and the status DLS_OK or DLS_TO_ROUNDING. */
dls_status dlsi_auto_prove(dlsi_auto *work, const dls_contact *problem, dls_status status);

/* asked: the caller reads info. */
dls_status dlsi_auto_take_to_accuracy(dlsi_auto *work, int asked, dls_status status,
                                      dls_error *error);

/* Sets info.ambiguous and info.unique. u: of r; NULL: not known. */
void dlsi_auto_look_for_others(dlsi_auto *work, const double *r, const double *u);

/* Returns 1 if r, u (or NULL), info (or NULL) hold the certified answer of a problem whose
 * candidates are free or stand alone (alone.c), else 0, and they are untouched. From r = 0,
 * without a workspace. */
int dlsi_alone_solve(const dls_contact *problem, double tol, double *r, double *u, dls_info *info);

#endif
