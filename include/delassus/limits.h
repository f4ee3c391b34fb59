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
  const char *method; /* "nlgs", "lemke", "newton", "admm", "augmented-lagrangian", ... */
  int iteration;      /* sweeps, pivots, steps, augmentations: done so far */
  int max_iterations;
  double residual; /* the certificate's, the larger part, as the iteration estimates it; -1 if
                      unknown */
} dls_progress;

/* A function of the host that a solve calls now and then; a return other than 0 cancels the solve
 * (DLS_CANCELLED, best answer so far). Where there is no candidate, and where auto answers without
 * a workspace, it is called once, with the answer, which it cannot cancel. Serves log lines,
 * progress bars, time limits and Ctrl-C. */
typedef int (*dls_progress_fn)(void *data, const dls_progress *progress);

/* The first member of the settings of every iterative method. */
typedef struct dls_limits {
  double tol;         /* on both parts of the certificate; >= 0, finite; 1e-8 */
  int max_iterations; /* in the method's own unit; 0: the method's own limit; 0 */
  int warm_start;     /* 1: start from r (z, x) as passed in; 0: from zero; 0 */
  int blocks; /* storage that create makes room for: 0: W dense; > 0: W by up to so many blocks; 0.
                 Methods that form no matrix of W's size do not read it. */
  dls_progress_fn progress; /* NULL for none; NULL */
  void *progress_data;
} dls_limits;

#ifdef __cplusplus
}
#endif

#endif
