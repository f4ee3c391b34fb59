/* paced.c: delassus/paced.h. */
#define _POSIX_C_SOURCE 200809L
#include "delassus/paced.h"

#include <time.h>

int dls_progress_paced(void *paced, const dls_progress *progress) {
  dls_paced *p = paced;
  struct timespec t;
  if (progress->last || clock_gettime(CLOCK_MONOTONIC, &t)) return 0;
  const double now = (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
  const int due = p->next > 0 && now >= p->next;
  if (due || !(p->next > 0)) p->next = now + p->seconds;
  return due ? p->progress(p->progress_data, progress) : 0;
}
