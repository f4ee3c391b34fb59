/*
 * delassus/info.h: the methods, and the outcome that every one of them reports.
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
  DLS_AUTO = 0,   /* the other methods in turn, as the problem needs them, d = 2 and 3 */
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
  DLS_STEP_SWEEPS = 0,    /* "sweeps": of Gauss-Seidel, plain; in a plan, anderson or momentum,
                             whichever auto takes for such a problem */
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
  DLS_REASON_COSTLIER = 1,       /* foreseen: more of it costs more than the next step */
  DLS_REASON_NO_PROGRESS = 2,    /* it came no nearer */
  DLS_REASON_SPENT = 3,          /* its own limit of iterations */
  DLS_REASON_TIME = 4,           /* the caller's limits: cpu_seconds, */
  DLS_REASON_ITERATIONS = 5,     /* max_iterations of all steps, */
  DLS_REASON_CANCELLED = 6,      /* the callback */
  DLS_REASON_NOT_APPLICABLE = 7, /* not for this problem, or not in this build (MUMPS) */
  DLS_REASON_NO_SOLUTION = 8,    /* it proved that there is none */
  DLS_REASON_EXCLUDED = 9,       /* it showed that no solution could be certified */
  DLS_REASON_RUNS_AWAY = 10      /* the reactions run away, as along a ray of Lemke's method */
} dls_reason;

/* Returns a reason in words, "no progress"; NULL for a number that is none. */
DLS_API const char *dls_reason_text(dls_reason reason);

/* A stage of auto: a step that started from the best r of the stages before. */
typedef struct dls_stage {
  dls_method method;  /* that the step is made of; DLS_NLGS here means accelerated sweeps */
  int iterations;     /* sweeps; steps; iterations; augmentations; pivots */
  int factorisations; /* newton, augmented Lagrangian: at most one per Newton step; admm */
  double residual;    /* of the certificate of the r that the stage ended with */
  dls_step step;      /* what really ran */
  dls_reason reason;  /* why it ended */
  int on_copy;        /* 1: on a copy in an order and in units of its own (src/auto/canonical.c) */
  double ahead;       /* DLS_REASON_COSTLIER: sweeps that were still foreseen, and ... */
  double next;        /* ... what the next step was foreseen to cost, in sweeps; else 0 */
  double cpu_seconds; /* of this thread, where the limits have a callback (dls_progress_paced
                         apart) or cpu_seconds > 0; else no clock is read: 0 */
} dls_stage;

/* The kind of a problem for auto, src/auto/regime.c: its plan follows from it. */
typedef enum dls_regime {
  DLS_REGIME_NONE = 0,    /* another method; or auto has answered without a plan */
  DLS_REGIME_ELASTIC = 1, /* W dense, or by blocks with a fourth of all and more; up to 100
                             contacts all */
  DLS_REGIME_FEW = 2,     /* W by fewer blocks, up to 100 contacts */
  DLS_REGIME_PACKING = 3, /* W by blocks, more than 100 candidates */
  DLS_REGIME_TIGHT = 4,   /* a packing beyond 1000 candidates or with many neighbours: momentum
                             from the first sweep on */
  DLS_REGIME_GIVEN = 5    /* the plan is settings.plan */
} dls_regime;

/* Returns "elastic", "packing", ...; NULL for a number that is no regime. */
DLS_API const char *dls_regime_name(dls_regime regime);

enum { DLS_STAGES_MAX = 40 };

/* Up to how many rows n of the LCP (dls_solver_create) auto has Lemke's method in its workspace. */
enum { DLS_AUTO_LEMKE_ROWS = 600 };

/* What is known of other answers to the same problem. A cheap look: dls_contact_diagnose knows
 * more. */
typedef enum dls_uniqueness {
  DLS_UNIQUE_UNKNOWN = 0,
  DLS_UNIQUE_YES = 1, /* proved: W definite without friction, or dominant beside it */
  DLS_UNIQUE_NO = 2   /* a second certified answer was found */
} dls_uniqueness;

/* Which of the reactions of the same positions u, where W does not determine them (trust.h,
 * dls_contact_freedom). */
typedef enum dls_forces {
  DLS_FORCES_ANY = 0,  /* as the method finds them: they depend on the order of the contacts */
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
  double error;  /* dense W of up to 300 rows, or up to 60 by blocks: predicted |r - r*| / |r|,
                   to first order; INFINITY: W does not determine r; 0: not asked */
  int ambiguous; /* nlgs, auto: candidates with several solutions when the others stay */
  dls_uniqueness unique; /* auto: of a certified answer */
  int factorisations; /* admm; newton, augmented Lagrangian, penalty, auto: at most one per Newton
                         step */
  int sweeps;         /* newton: before the first step */
  int stages;         /* auto: how many of stage[] are set, in the order of time */
  dls_stage stage[DLS_STAGES_MAX];
  dls_regime regime; /* auto */
  int at_rest;       /* auto: 1: looked at rest, so that its plan has the convex problem */
  int candidates;    /* auto: of the problem */
  int blocks;        /* auto: of W; 0: W is dense; -1: W of bodies, not formed as the solve began */
  int left_out;      /* auto: so many candidates provably cannot touch, and the stages are without
                        them; 0 where the whole was solved */
  dls_forces forces; /* DLS_FORCES_LEAST: r is known to be the least one; only where asked for */
} dls_info;

#ifdef __cplusplus
}
#endif

#endif
