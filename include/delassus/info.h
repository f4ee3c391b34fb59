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

/* A stage of auto: a method that started from the best r of the stages before. */
typedef struct dls_stage {
  dls_method method;  /* DLS_NLGS here means accelerated sweeps */
  int iterations;     /* sweeps; steps; iterations; augmentations; pivots */
  int factorisations; /* newton, augmented Lagrangian: at most one per Newton step; admm */
  double residual;    /* of the certificate of the r that the stage ended with */
} dls_stage;

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
} dls_info;

#ifdef __cplusplus
}
#endif

#endif
