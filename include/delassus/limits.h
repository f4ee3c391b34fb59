/*
 * delassus/limits.h: the limits with which the settings of every iterative method begin, and the
 * progress callback.
 */
#ifndef DELASSUS_LIMITS_H
#define DELASSUS_LIMITS_H

#include "delassus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The state of a solve for the progress callback; valid during the call only. */
typedef struct dls_progress {
  const char *method; /* that was called: "auto", "nlgs", "newton", "lemke", "admm", ...;
                         "reduction" (delassus/reduction.h has its stages) */
  const char *stage;  /* the part at work: of auto the method of the stage, of newton "nlgs" in its
                         first sweeps, of lemke "newton" at last; else as method */
  int iteration;      /* sweeps, pivots, steps, augmentations: done so far in this stage */
  int max_iterations; /* of the stage; 0: no limit */
  double residual;    /* the certificate's, max(residual_u, residual_r) in every method for contact
                         problems, as the iteration estimates it for r; -1 if unknown */
  const double *r;    /* the reactions of that residual, m; z (n) of an LCP; NULL if not there */
  double cpu_seconds; /* of this thread since the solve began */
  int last;           /* 1: the last call of a solve, whatever its end but an error: iteration: of
                         all stages; residual: the final one, exactly; r: the answer; the return
                         value is not read */
} dls_progress;

/* A function of the host that a solve calls now and then, and once at its end (`last`); a return
 * other than 0 cancels the solve (DLS_CANCELLED, best answer so far). Where there is no candidate,
 * and where auto answers without a workspace, the last call is the only one. Serves log lines,
 * progress bars, histories and Ctrl-C. */
typedef int (*dls_progress_fn)(void *data, const dls_progress *progress);

/* The first member of the settings of every iterative method. */
typedef struct dls_limits {
  double tol;         /* on both parts of the certificate; >= 0, finite; 1e-8 */
  int max_iterations; /* in the method's own unit; 0: the method's own limit; 0 */
  int warm_start;     /* 1: start from r (z, x) as passed in; 0: from zero; 0 */
  int blocks; /* storage that create makes room for: 0: W dense; > 0: W by up to so many blocks,
                 also where they are formed of bodies (dls_bodies_count); 0. Methods that form no
                 matrix of W's size do not read it. */
  dls_progress_fn progress; /* NULL for none; NULL */
  void *progress_data;
  double cpu_seconds; /* > 0: a solve that this thread has spent so much time in ends with the best
                         answer so far, DLS_TIME_LIMIT, after its current iteration; 0: no limit; 0.
                         No clock is read for 0 without a callback. */
  int threads; /* of sweeps, from 1 on: more than 1 sweep over a large W in slabs, two colours
                         of them, at the same time (docs/threads.md); the bits do not depend on how
                         many there are, nor on how many cores; 1 (0: the same) */
} dls_limits;

#ifdef __cplusplus
}
#endif

#endif
