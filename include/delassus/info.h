/*
 * delassus/info.h: the methods, and what a solve reports.
 */
#ifndef DELASSUS_INFO_H
#define DELASSUS_INFO_H

#include "delassus/contact.h"
#include "delassus/limits.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The methods for a contact problem, numbered without gaps; dls_method_find() finds one by name. */
typedef enum dls_method {
  DLS_AUTO = 0,   /* the other methods in turn, chosen by the problem and by progress */
  DLS_NLGS = 1,   /* projected Gauss-Seidel on the reactions, d = 2 and 3 */
  DLS_LEMKE = 2,  /* complementary pivoting on the LCP; d = 3 on facets, then Newton steps */
  DLS_NEWTON = 3, /* sweeps, then nonsmooth Newton, d = 2 and 3 */
  DLS_ADMM = 4,   /* splitting with a factorisation, d = 2 and 3 */
  DLS_AUGMENTED_LAGRANGIAN = 5, /* Simo and Laursen's, the proximal point method; d = 2 and 3 */
  DLS_PENALTY = 6,              /* one augmentation with large penalties: has an error */
  DLS_HOMOTOPY = 7 /* interior homotopy, up to some 300 rows, where all others fail; d = 2 and 3 */
} dls_method;

/* A step of auto: a method, in one of its forms. The names of dls_step_name() are the words of
 * dls_solver_settings.plan and .without. */
typedef enum dls_step {
  DLS_STEP_SWEEPS = 0,    /* "sweeps": plain Gauss-Seidel; in a plan, anderson or momentum, as auto
                             chooses for the problem */
  DLS_STEP_ANDERSON = 1,  /* "anderson": sweeps with Anderson's acceleration */
  DLS_STEP_MOMENTUM = 2,  /* "momentum": sweeps with momentum, in turn with anderson */
  DLS_STEP_CONVEX = 3,    /* "convex": the convex problem without mu |u_t|, by splitting */
  DLS_STEP_INTERIOR = 4,  /* "interior-point": the same, an interior point after it; in no plan */
  DLS_STEP_NEWTON = 5,    /* "newton" */
  DLS_STEP_SPLITTING = 6, /* "splitting": ADMM */
  DLS_STEP_COLD_SPLITTING = 7, /* "cold-splitting": ADMM from r = 0, rho from 1e-8 on */
  DLS_STEP_NEAR_SPLITTING = 8, /* "near-splitting": ADMM from an r near the tolerance */
  DLS_STEP_AUGMENTED = 9,      /* "augmented-lagrangian" */
  DLS_STEP_LEMKE = 10,         /* "lemke" */
  DLS_STEP_HOMOTOPY = 11,      /* "homotopy": interior homotopy */
  DLS_STEP_SCATTER = 12,       /* "scatter": Newton's method from scattered starts */
  DLS_STEP_ON_K = 13 /* "on-K": the problem on K itself, of dls_reduction_solve; in no plan */
} dls_step;

/* Returns the name of a step; NULL for a number that is none. Steps are numbered without gaps. */
DLS_API const char *dls_step_name(dls_step step);

/* Why a step of auto ended. */
typedef enum dls_reason {
  DLS_REASON_SOLVED = 0,         /* the certificate holds */
  DLS_REASON_COSTLIER = 1,       /* the next step is expected to cost less */
  DLS_REASON_NO_PROGRESS = 2,    /* the residual did not fall */
  DLS_REASON_SPENT = 3,          /* the step's own limit of iterations */
  DLS_REASON_TIME = 4,           /* limits.cpu_seconds */
  DLS_REASON_ITERATIONS = 5,     /* limits.max_iterations, of all steps */
  DLS_REASON_CANCELLED = 6,      /* the callback */
  DLS_REASON_NOT_APPLICABLE = 7, /* not for this problem, or not in this build (MUMPS) */
  DLS_REASON_NO_SOLUTION = 8,    /* the step proved that there is no solution */
  DLS_REASON_EXCLUDED = 9,       /* the step showed that no solution could be certified */
  DLS_REASON_RUNS_AWAY = 10 /* reactions grow without bound, as along a ray of Lemke's method */
} dls_reason;

/* Returns a reason in words, "no progress"; NULL for a number that is none. */
DLS_API const char *dls_reason_text(dls_reason reason);

/* A stage of auto: a step that started from the best r of the stages before it. */
typedef struct dls_stage {
  dls_method method;  /* method of the step; DLS_NLGS here means accelerated sweeps */
  int iterations;     /* sweeps; steps; iterations; augmentations; pivots */
  int factorisations; /* newton, augmented Lagrangian: at most one per Newton step; admm */
  double residual;    /* certificate of the last r of the stage */
  dls_step step;      /* step that ran */
  dls_reason reason;  /* why it ended */
  int on_copy;        /* 1: on a renumbered and scaled copy of the problem */
  double ahead; /* DLS_REASON_COSTLIER: expected remaining cost of the step, in sweeps; else 0 */
  double next;  /* DLS_REASON_COSTLIER: expected cost of the next step, in sweeps; else 0 */
  double cpu_seconds; /* of this thread; 0 unless the limits have a callback other than
                         dls_progress_paced, or cpu_seconds > 0 */
} dls_stage;

/* The kind of a problem, from which auto takes its plan. */
typedef enum dls_regime {
  DLS_REGIME_NONE = 0,    /* another method; or auto needed no plan */
  DLS_REGIME_ELASTIC = 1, /* W dense, or by blocks with at least 25 % of all blocks (up to 100
                             contacts: all blocks) */
  DLS_REGIME_FEW = 2,     /* W by fewer blocks, up to 100 contacts */
  DLS_REGIME_PACKING = 3, /* W by blocks, more than 100 contacts */
  DLS_REGIME_TIGHT = 4,   /* a packing of more than 1000 contacts or with many neighbours: momentum
                             from the first sweep */
  DLS_REGIME_GIVEN = 5    /* the plan is settings.plan */
} dls_regime;

/* Returns "elastic", "packing", ...; NULL for a number that is no regime. */
DLS_API const char *dls_regime_name(dls_regime regime);

enum { DLS_STAGES_MAX = 40 };

/* Largest number of rows n of the LCP (dls_solver_create) for which the workspace of auto has room
 * for Lemke's method. */
enum { DLS_AUTO_LEMKE_ROWS = 600 };

/* Result of an inexpensive search for other answers to the same problem. dls_contact_diagnose finds
 * out more. */
typedef enum dls_uniqueness {
  DLS_UNIQUE_UNKNOWN = 0,
  DLS_UNIQUE_YES = 1, /* proved: W definite without friction, or dominant beside it */
  DLS_UNIQUE_NO = 2   /* a second certified answer was found */
} dls_uniqueness;

/* The reactions to return if W does not determine them (trust.h, dls_contact_freedom). All have the
 * same positions u. */
typedef enum dls_forces {
  DLS_FORCES_ANY = 0,  /* those that the method finds; they depend on the order of the contacts */
  DLS_FORCES_LEAST = 1 /* those with the least sum of w_c |r_c|^2, w_c = trace(W_cc) / d: there is
                          one such r, and it is as symmetric as the problem */
} dls_forces;

/* The outcome of a solve. */
typedef struct dls_info {
  dls_status status; /* as returned */
  dls_method method;
  int iterations; /* sweeps; pivots and crash rounds of all LCPs; steps; augmentations; iterations;
                     auto: of all stages */
  dls_certificate certificate; /* of the r that is returned */
  double error;  /* predicted |r - r*| / |r|, to first order and at least that of rounding, if W has
                   up to 60 rows, or if a dense W of up to 300 rows has few large eigenvalues, as
                   for bodies on soft springs, or on K up to 1,000 unknowns and reactions, where the
                   step that predicts it improves r and x, too: without info they meet tol alone;
                   INFINITY: r is not determined, or on the border of two states their matrices
                   differ in sign; 0: not predicted. The error of elastic bodies is 1 to 100 times
                   the residual */
  int ambiguous; /* nlgs, auto: contacts with several solutions if the others are frozen */
  dls_uniqueness unique; /* auto: of a certified answer */
  int factorisations; /* admm; newton, augmented Lagrangian, penalty, auto: at most one per Newton
                         step */
  int sweeps;         /* newton: before the first step */
  int stages;         /* auto: number of stages in stage[], in the order of time */
  dls_stage stage[DLS_STAGES_MAX];
  dls_regime regime; /* auto */
  int at_rest;       /* auto: 1: the bodies seem at rest, and the plan has the convex problem */
  int candidates;    /* auto: contacts of the problem */
  int blocks;   /* auto: blocks of W; 0: W is dense; -1: W of bodies, not formed at the start */
  int left_out; /* auto: contacts that provably stay open, which the stages leave out */
  dls_forces forces; /* DLS_FORCES_LEAST: r is the least one; only if the settings ask for it */
} dls_info;

#ifdef __cplusplus
}
#endif

#endif
