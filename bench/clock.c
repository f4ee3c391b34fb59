/* clock.c: what clock.h says. */
#include "clock.h"

#include <time.h>

/* Linux brings the clock of a process with a CPU limit up to date at a tick (1 ms), or when the clock of the
 * calling thread is read: so that is read first. */
double cpu_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
