/*
 * parallel.c: tasks on several threads, the only file that uses OpenMP. A compiler without OpenMP
 * runs them one after the other, to the same bits.
 *
 * A team lives as long as a solve. Its tasks take microseconds to milliseconds. On a busy machine a
 * thread may wait for its core much longer than that: so nobody waits for a thread that has not
 * started. The caller takes tasks itself, the others take what is left, and the caller waits only
 * for tasks that they have taken.
 *
 *   word    number of tasks (upper half), the next one (lower half); taken by atomic exchange
 *   done    tasks that have ended
 *
 * A thread that takes a task finds its function and data unchanged: the next job starts after all
 * tasks of this one have ended.
 */
#define _POSIX_C_SOURCE 200809L
#include <sched.h>
#include <stdatomic.h>
#include <stdint.h>

#ifdef _OPENMP
#include <omp.h>
#endif

#include "base/base.h"

struct dlsi_team {
  _Atomic uint64_t word;
  atomic_int done, over;
  dlsi_task *task;
  void *data;
};

/* Takes and does the next task; returns 0 if there is none. */
static int team_take(dlsi_team *team) {
  uint64_t word = atomic_load(&team->word);
  do {
    if ((uint32_t)word >= word >> 32) return 0;
  } while (!atomic_compare_exchange_weak(&team->word, &word, word + 1));
  team->task(team->data, (int)(uint32_t)word);
  atomic_fetch_add(&team->done, 1);
  return 1;
}

void dlsi_parallel(dlsi_team *team, int tasks, dlsi_task *task, void *data) {
  if (!team || tasks < 2) {
    for (int k = 0; k < tasks; k++)
      task(data, k);
    return;
  }
  team->task = task;
  team->data = data;
  atomic_store(&team->done, 0);
  atomic_store(&team->word, (uint64_t)tasks << 32);
  while (team_take(team))
    continue;
  for (int k = 0; atomic_load(&team->done) < tasks; k++)
    if (k > 1000) (void)sched_yield();
}

#ifdef _OPENMP
/* Takes tasks until the solve is over. Polls briefly, then yields the core between polls. */
static void team_help(dlsi_team *team) {
  DLSI_DOOR; /* a thread inherits the environment of its creator, at that time */
  for (int idle = 0; !atomic_load(&team->over);)
    if (team_take(team))
      idle = 0;
    else if (++idle > 1000)
      (void)sched_yield();
}
#endif

void dlsi_team_run(int threads, void (*body)(dlsi_team *team, void *data), void *data) {
#ifdef _OPENMP
  if (threads > 1) {
    dlsi_team team = {.task = NULL};
    atomic_init(&team.word, 0);
    atomic_init(&team.done, 0);
    atomic_init(&team.over, 0);
#pragma omp parallel num_threads(threads)
    if (omp_get_thread_num() > 0)
      team_help(&team);
    else {
      body(&team, data);
      atomic_store(&team.over, 1);
    }
    return;
  }
#else
  (void)threads;
#endif
  body(NULL, data);
}
