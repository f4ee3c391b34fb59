/*
 * delassus/paced.h: a progress callback that calls yours at most every `seconds`.
 */
#ifndef DELASSUS_PACED_H
#define DELASSUS_PACED_H

#include "delassus/limits.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A callback that costs more than an iteration, such as that of an interpreter, and the seconds
 * between its calls. One solve at a time may use it. */
typedef struct dls_paced {
  dls_progress_fn progress; /* called with progress_data; the last call of a solve is left out */
  void *progress_data;
  double seconds; /* at least between two calls, on the wall clock; > 0 */
  double next;    /* 0 before the first use; the library's own from then on */
} dls_paced;

/* Calls paced->progress if `seconds` have gone by since the last time (at first: since the first
 * use) and returns its value, else 0. Give it as limits.progress with the dls_paced as
 * limits.progress_data. It reads the wall clock. The clock of the thread, which is expensive, is
 * read for limits.cpu_seconds alone; without that progress->cpu_seconds is 0. */
DLS_API int dls_progress_paced(void *paced, const dls_progress *progress);

#ifdef __cplusplus
}
#endif

#endif
