/*
 * parallel.c: tasks on several threads, the one place that knows of OpenMP. A compiler without it
 * runs them one after the other, to the same bits.
 */
#include "base/base.h"

void dlsi_parallel(int threads, int tasks, dlsi_task *task, void *data) {
#ifdef _OPENMP
  if (threads > 1 && tasks > 1) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (int k = 0; k < tasks; k++)
      task(data, k);
    return;
  }
#else
  (void)threads;
#endif
  for (int k = 0; k < tasks; k++)
    task(data, k);
}
