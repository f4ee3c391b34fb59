/*
 * measure.c: one solve in a process of its own, so that a crash, an exit() or a run without end costs
 * one row of the table.
 */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "solvers.h"

static const double short_call = 20e-3;    /* s: repeated, the smallest counts */
static const double least_reading = 50e-6; /* s: two in a row are 0.4 to 1 us apart */
enum { most_readings = 40, exit_done = 7 };

/* RLIMIT_CPU counts whole seconds, the timer the fractions. */
static void set_limit(double limit) {
  const rlim_t seconds = (rlim_t)limit + 2;
  const struct rlimit cpu = {seconds, seconds};
  const struct itimerval timer = {
      .it_value = {(time_t)limit, (suseconds_t)(1e6 * (limit - floor(limit)))}};
  (void)setrlimit(RLIMIT_CPU, &cpu);
  (void)setitimer(ITIMER_PROF, &timer, NULL);
}

/* The peer prints where it should not. */
static void be_silent(void) {
  const int null = open("/dev/null", O_WRONLY);
  if (null < 0) return;
  (void)dup2(null, 1);
  (void)dup2(null, 2);
}

/* The least CPU time of a call, and of a call with its setup; each reading of the clock spans as many
 * calls as make it long enough. */
static void run_child(const scene *s, solve_fn solve, const void *how, double tol, double *r,
                      outcome *o) {
  double cpu = INFINITY, both = INFINITY, total = 0;
  int calls = 1;
  for (int k = 0; k < most_readings && total < short_call;) {
    outcome one = {.cpu = 0};
    solve(how, s, tol, calls, r, &one);
    *o = one;
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
  o->calls = calls;
  o->cpu = cpu;
  o->setup = fmax(both - cpu, 0);
}

outcome measure(const scene *s, solve_fn solve, const void *how, double tol, double limit) {
  const size_t m = (size_t)s->contact.d * (size_t)s->contact.nc;
  const size_t bytes = sizeof(outcome) + m * sizeof(double);
  outcome result = {.ended = CRASH, .iterations = -1, .certificate = {.residual = INFINITY}};
  outcome *o = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (o == MAP_FAILED) return result;
  double *r = (double *)(o + 1);
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    be_silent();
    set_limit(limit);
    run_child(s, solve, how, tol, r, o);
    _exit(exit_done);
  }
  int status = 0;
  pid_t ended;
  do
    ended = waitpid(child, &status, 0);
  while (ended < 0 && errno == EINTR);
  if (child > 0 && ended == child) {
    if (WIFEXITED(status) && WEXITSTATUS(status) == exit_done) result = *o;
    if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGPROF || WTERMSIG(status) == SIGXCPU))
      result.ended = LIMIT;
  }
  result.certificate.residual = INFINITY;
  if (result.ended == ENDED &&
      dls_contact_certify(&s->contact, r, NULL, &result.certificate, NULL) != DLS_OK)
    result.certificate.residual = INFINITY;
  munmap(o, bytes);
  return result;
}
