/*
 * hard_solve.c: one method on one problem, and the reason of its end.
 *
 *   | status of the method                  | ending                                          |
 *   |---------------------------------------|-------------------------------------------------|
 *   | any, and the certificate holds        | solved                                          |
 *   | DLS_RAY                               | ray                                             |
 *   | DLS_NO_SOLUTION, _LIKELY              | wrong: the problems have a solution             |
 *   | DLS_STALLED                           | no progress                                     |
 *   | limit of time or iterations           | cycle, if r came back to an earlier r to 1e-9   |
 *   |                                       | while it moved by more than that between;       |
 *   |                                       | otherwise tried again with ten times the limit. |
 *   |                                       | Then no progress, if the best residual fell by  |
 *   |                                       | less than half in the second half of the        |
 *   |                                       | iterations, and not decided, if by more; auto,  |
 *   |                                       | which changes its method, is not decided        |
 *   | an error                              | refused                                         |
 *
 * Cycles are found as by Brent: r is kept at iterations 1, 2, 4, 8, ...; later r are compared with
 * it.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "hard.h"
#include "solvers.h"

enum { all_iterations = 100000000, watched = 64 /* kept residuals */ };

static const double tolerance = 1e-8, same = 1e-9;

enum { all = 100000 };
static const own_method methods[] = {
    {"auto", "auto", "none", .most = {all, all}},
    {"nlgs", "nlgs", "none", .most = {all, all}},
    {"nlgs+aitken", "nlgs", "aitken", .most = {all, all}},
    {"nlgs+anderson", "nlgs", "anderson", .most = {all, all}},
    {"nlgs+momentum", "nlgs", "momentum", .most = {all, all}},
    {"newton", "newton", "none", .most = {all, all}},
    {"admm", "admm", "none", .most = {all, all}},
    {"augmented-lagrangian", "augmented-lagrangian", "none", .most = {all, all}},
    {"lemke", "lemke", "none", .most = {60, 60}},
    {"homotopy", "homotopy", "none", .most = {100, 100}}};
enum { method_count = sizeof methods / sizeof *methods };

const char *hard_method_name(int k) {
  return k < method_count ? methods[k].name : NULL;
}

const char *hard_end_name(hard_end end) {
  static const char *const name[HARD_ENDS] = {"solved", "cycle",       "ray",    "no progress",
                                              "wrong",  "not decided", "refused"};
  return name[end];
}

typedef struct hard_watch {
  size_t m;
  double *kept, moved;  /* r of iteration `at`; the most that r moved away from it since */
  int at, last, period; /* period: of a cycle, 0: none */
  double best[watched]; /* least residual of each slice of iterations, slices double in size */
  double least;
} hard_watch;

static int hard_follow(void *data, const dls_progress *now) {
  hard_watch *w = data;
  if (now->last || now->iteration <= w->last) return 0;
  w->last = now->iteration;
  if (now->residual > 0) w->least = fmin(w->least, now->residual);
  const int slice = (int)fmin(watched - 1, floor(2 * log2((double)now->iteration)));
  w->best[slice] = w->least;
  if (!now->r) return 0;
  double far = 0, size = 0;
  for (size_t i = 0; i < w->m; i++) {
    far = fmax(far, fabs(now->r[i] - w->kept[i]));
    size = fmax(size, fabs(now->r[i]));
  }
  if (w->at && far <= same * size && w->moved > 1e3 * same * size && now->residual > tolerance) {
    w->period = now->iteration - w->at;
    return 1;
  }
  w->moved = fmax(w->moved, far);
  if (now->iteration >= 2 * w->at) {
    memcpy(w->kept, now->r, w->m * sizeof *w->kept);
    w->at = now->iteration;
    w->moved = 0;
  }
  return 0;
}

/* Returns 1 if the residual fell by less than half in the second half of the iterations. */
static int is_stuck(const hard_watch *w) {
  if (w->last < 8) return 0;
  const int slice = (int)fmin(watched - 1, floor(2 * log2((double)w->last)));
  return w->least > 0.5 * w->best[slice - 2];
}

static hard_end hard_once(const regret_problem *p, int k, double seconds, int last, double *cpu) {
  const size_t m = 3 * (size_t)p->contact.nc;
  if (p->contact.nc > methods[k].most[1]) return HARD_REFUSED;
  dls_solver_settings s;
  hard_watch watch = {.m = m, .kept = calloc(2 * m, sizeof(double)), .least = INFINITY};
  if (!watch.kept) abort();
  for (int i = 0; i < watched; i++)
    watch.best[i] = INFINITY;
  own_settings(&s, &methods[k], &p->contact, tolerance);
  s.limits.cpu_seconds = seconds;
  s.limits.progress = hard_follow;
  s.limits.progress_data = &watch;
  if (s.method == DLS_ADMM) s.limits.max_iterations = all_iterations;
  double *r = watch.kept + m;
  const double start = bench_seconds();
  const dls_status status = dls_solve(&p->contact, &s, r, NULL, NULL, NULL);
  *cpu = bench_seconds() - start;
  dls_certificate c = {0};
  hard_end end = HARD_REFUSED;
  if (status >= 0 && dls_contact_certify(&p->contact, r, NULL, &c, NULL) == DLS_OK) {
    const dls_status verdict = dls_certificate_verdict(&c, tolerance);
    if (dls_solved(verdict))
      end = HARD_SOLVED;
    else if (status == DLS_RAY)
      end = HARD_RAY;
    else if (status == DLS_NO_SOLUTION || status == DLS_NO_SOLUTION_LIKELY)
      end = HARD_WRONG;
    else if (watch.period)
      end = HARD_CYCLE;
    else if (status == DLS_STALLED || (last && k > 0 && is_stuck(&watch)))
      end = HARD_STUCK;
    else
      end = HARD_UNDECIDED;
  }
  free(watch.kept);
  return end;
}

hard_end hard_run(const regret_problem *p, int k, double seconds, double *cpu) {
  const hard_end end = hard_once(p, k, seconds, 0, cpu);
  return end == HARD_UNDECIDED ? hard_once(p, k, 10 * seconds, 1, cpu) : end;
}
