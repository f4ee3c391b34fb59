/*
 * delassus/limits.h: the limits of each iterative method, and the progress callback.
 */
#ifndef DELASSUS_LIMITS_H
#define DELASSUS_LIMITS_H

#include "delassus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The state of a solve for the progress callback; valid during the call only. */
typedef struct dls_progress {
  const char *method; /* method that was called: "auto", "nlgs", "newton", "lemke", "admm", ...;
                         "reduction" (delassus/reduction.h has its stages) */
  const char *stage;  /* running stage: of auto the method of the stage, of newton "nlgs" in its
                         first sweeps, of lemke "newton" at the end; else as method */
  int iteration;      /* sweeps, pivots, steps, augmentations of this stage so far */
  int max_iterations; /* of the stage; 0: no limit */
  double residual;    /* estimate of the certificate's max(residual_u, residual_r) for r; -1:
                         unknown */
  const double *r;    /* the reactions of that residual, m; z (n) of an LCP; or NULL */
  double cpu_seconds; /* of this thread since the solve began */
  int last;           /* 1: the last call of a solve that has no error: iteration is that of all
                         stages, residual the final one, exactly, r the answer; the return value
                         is ignored */
} dls_progress;

/* A function of the host that a solve calls repeatedly, and once at its end (`last`). A return
 * value other than 0 cancels the solve (DLS_CANCELLED, best answer so far). Without contacts, and
 * if auto solves the contacts one by one, only the last call takes place. Use it for log lines,
 * progress bars, histories and Ctrl-C. */
typedef int (*dls_progress_fn)(void *data, const dls_progress *progress);

/* The first member of the settings of every iterative method. */
typedef struct dls_limits {
  double tol;         /* on both parts of the certificate; >= 0, finite; 1e-8 */
  int max_iterations; /* in the method's own unit; 0: the method's own limit; 0 */
  int warm_start;     /* 1: start from r (z, x) as passed in; 0: from zero; 0 */
  int blocks; /* storage of W for which create allocates: 0: dense; > 0: up to so many blocks, also
                 of blocks that are formed from bodies (dls_bodies_count); 0. Methods that form no
                 matrix of W's size ignore it. */
  dls_progress_fn progress; /* NULL for none; NULL */
  void *progress_data;
  double cpu_seconds; /* > 0: limit on the CPU time of this thread; the solve then ends after its
                         current iteration with DLS_TIME_LIMIT and the best answer so far; 0: no
                         limit; 0. With 0 and no callback no clock is read. */
  int threads; /* threads of a sweep over a large W (the guide, "Threads"); the bits do not depend
                  on the number of threads or cores; 1 (0: the same) */
} dls_limits;

#ifdef __cplusplus
}
#endif

#endif
