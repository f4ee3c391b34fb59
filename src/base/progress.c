/*
 * progress.c: calls the caller's progress callback and keeps the time limit, in the same way for
 * every method.
 */
#define _POSIX_C_SOURCE 200809L
#include <time.h>

#include "base/base.h"
#include "delassus/paced.h"

/* Returns the CPU seconds that this thread has spent. */
static double thread_seconds(void) {
  struct timespec t;
  if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t)) return 0;
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double dlsi_clock_start(const dls_limits *limits) {
  const int is_told = limits->progress && limits->progress != dls_progress_paced;
  const int asked = limits->cpu_seconds > 0 || (is_told && limits->cpu_seconds == 0);
  return asked ? thread_seconds() : -1;
}

double dlsi_clock_since(double begun) {
  return begun < 0 ? 0 : thread_seconds() - begun;
}

int dlsi_clock_is_over(const dls_limits *limits, double begun) {
  return limits->cpu_seconds > 0 && thread_seconds() - begun >= limits->cpu_seconds;
}

double dlsi_clock_left(const dls_limits *limits, double begun) {
  if (!(limits->cpu_seconds > 0)) return dlsi_no_clock;
  const double left = limits->cpu_seconds - (thread_seconds() - begun);
  return left > 1e-9 ? left : 1e-9;
}

dls_status dlsi_tell(const dls_limits *limits, double begun, dls_progress *progress) {
  progress->cpu_seconds = dlsi_clock_since(begun);
  if (limits->progress) {
    dlsi_host own;
    dlsi_go_out(&own);
    const int stop = limits->progress(limits->progress_data, progress);
    dlsi_come_in(&own);
    if (stop) return DLS_CANCELLED;
  }
  const int over = limits->cpu_seconds > 0 && progress->cpu_seconds >= limits->cpu_seconds;
  return over ? DLS_TIME_LIMIT : DLS_OK;
}

void dlsi_tell_last(const dls_limits *limits, double begun, const char *method, const char *stage,
                    int iterations, double residual, const double *r) {
  dls_progress progress = {.method = method,
                           .stage = stage,
                           .iteration = iterations,
                           .max_iterations = limits->max_iterations,
                           .residual = residual,
                           .r = r,
                           .last = 1};
  if (limits->progress) (void)dlsi_tell(limits, begun, &progress);
}

/* ---- work that is no solve ------------------------------------------------------------------- */

static const double watch_flops = 1e7; /* about a millisecond of a dense kernel */

/* Calls the host. */
static int watch_call(dlsi_watch *watch, int last) {
  dls_progress progress = {.method = watch->method,
                           .stage = watch->stage,
                           .iteration = watch->done,
                           .max_iterations = watch->all,
                           .residual = -1,
                           .last = last};
  watch->flops = 0;
  const int stop = dlsi_tell(&watch->limits, watch->begun, &progress) == DLS_CANCELLED;
  if (!last) watch->is_cancelled |= stop;
  return watch->is_cancelled;
}

dls_status dlsi_watch_stage(dlsi_watch *watch, const char *stage, int all) {
  if (!watch || !watch->limits.progress) return DLS_OK;
  watch->stage = stage;
  watch->done = 0;
  watch->all = all;
  return watch->is_cancelled || watch_call(watch, 0) ? DLS_CANCELLED : DLS_OK;
}

int dlsi_watch_stops(dlsi_watch *watch, int done, double flops) {
  if (!watch || !watch->limits.progress) return 0;
  watch->done = done;
  watch->flops += flops;
  return watch->is_cancelled || (watch->flops >= watch_flops && watch_call(watch, 0));
}

void dlsi_watch_end(dlsi_watch *watch) {
  if (watch->limits.progress) (void)watch_call(watch, 1);
}
