/*
 * solvers_call.c: one measured solve in a child process: a crash, an exit() or a run without end
 * costs one row of the table.
 */
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include "common.h"
#include "solvers.h"

static const double short_call = 20e-3;     /* s: repeated, the smallest counts */
static const double least_reading = 500e-6; /* s: two in a row are 0.4 to 1 us apart */
enum { most_readings = 40 };

/* Meets no tolerance in any part. */
static const dls_certificate no_answer = {.residual = INFINITY,
                                          .residual_u = INFINITY,
                                          .residual_r = INFINITY,
                                          .floor_u = INFINITY,
                                          .floor_r = INFINITY};

/* Limits the CPU of this process: RLIMIT_CPU counts whole seconds, the timer fractions. */
static void limit_cpu(double limit) {
  const rlim_t seconds = (rlim_t)limit + 2;
  const struct rlimit cpu = {seconds, seconds};
  const struct itimerval timer = {
      .it_value = {(time_t)limit, (suseconds_t)(1e6 * (limit - floor(limit)))}};
  (void)setrlimit(RLIMIT_CPU, &cpu);
  (void)setitimer(ITIMER_PROF, &timer, NULL);
}

/* Discards what solvers of the peer print. */
static void be_silent(void) {
  const int null = open("/dev/null", O_WRONLY);
  if (null < 0) return;
  (void)dup2(null, 1);
  (void)dup2(null, 2);
}

/* A call, as the child process sees it; r and o are shared. */
typedef struct task {
  const scene *s;
  solve_fn solve;
  const void *how;
  double tol, limit;
  double *r;
  outcome *o;
} task;

/* Finds the least CPU time of a call, alone and with its setup. Each reading of the clock spans as
 * many calls as make it long enough. */
static void run_task(void *data) {
  const task *t = data;
  double cpu = INFINITY, both = INFINITY, total = 0;
  int calls = 1;
  be_silent();
  limit_cpu(t->limit);
  for (int k = 0; k < most_readings && total < short_call;) {
    outcome one = {.cpu = 0};
    t->solve(t->how, t->s, t->tol, calls, t->r, &one);
    *t->o = one;
    if (one.ended != ENDED) return;
    if (calls * one.cpu < least_reading) {
      calls = one.cpu > 0 ? (int)(1.2 * least_reading / one.cpu) + 1 : 10 * calls;
      continue;
    }
    total += calls * one.cpu;
    cpu = fmin(cpu, one.cpu);
    both = fmin(both, one.cpu + one.setup);
    k++;
  }
  t->o->calls = calls;
  t->o->cpu = cpu;
  t->o->setup = fmax(both - cpu, 0);
}

double outcome_seconds(const outcome *o, double tol) {
  const dls_status verdict = dls_certificate_verdict(&o->certificate, tol);
  return o->ended == ENDED && dls_solved(verdict) ? o->cpu : INFINITY;
}

outcome measure(const scene *s, solve_fn solve, const void *how, double tol, double limit) {
  const size_t m = (size_t)s->contact.d * (size_t)s->contact.nc;
  const size_t bytes = sizeof(outcome) + m * sizeof(double);
  outcome result = {.ended = CRASH, .iterations = -1, .certificate = no_answer};
  outcome *o = bench_shared(bytes);
  if (!o) return result;
  task t = {s, solve, how, tol, limit, (double *)(o + 1), o};
  const int ended = bench_child(run_task, &t);
  if (ended == 0) result = *o;
  if (ended == SIGPROF || ended == SIGXCPU) result.ended = LIMIT;
  result.certificate = no_answer;
  if (result.ended == ENDED &&
      dls_contact_certify(&s->contact, t.r, NULL, &result.certificate, NULL) != DLS_OK)
    result.certificate = no_answer; /* NaN, say: refused, with nothing written */
  munmap(o, bytes);
  return result;
}
