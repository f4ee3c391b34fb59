/* fuzz_calls.c: sequences of calls on one solver, and all that is asked of an answer, with every
 * array as long as the headers say; the words of a plan; tables of numbers of any format. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "delassus.h"
#include "fuzz.h"
#include "problem/arrays.h"

static const char *const words[] = {"newton",
                                    "sweeps:3,newton",
                                    "homotopy",
                                    "scatter",
                                    "lemke,splitting",
                                    "momentum:5",
                                    "augmented-lagrangian:2",
                                    "sweeps:2,scatter",
                                    "cold-splitting",
                                    "near-splitting",
                                    "convex",
                                    "anderson:2,scatter",
                                    "splitting:1,lemke",
                                    "sweeps:9999999999",
                                    "none,such"};

/* Returns a plan, or NULL. */
static const char *take_words(fuzz_bytes *b) {
  const int k = take_byte(b);
  return k < 64 ? words[k % (int)(sizeof words / sizeof *words)] : NULL;
}

/* Cancels at the byte'th call. */
static int cancel(void *data, const dls_progress *progress) {
  int *left = data;
  return !progress->last && --*left <= 0;
}

/* The answer is checked as fuzz_solve does. */
static void check_solved(const dls_contact *problem, const double *r, dls_status status,
                         double tol) {
  dls_certificate seen;
  dls_error error;
  FUZZ_CHECK(dls_contact_certify(problem, r, NULL, &seen, &error) == DLS_OK);
  if (status == DLS_OK) FUZZ_CHECK(dls_certificate_holds(&seen, tol));
}

/* Solves up to four times in one workspace, between which contacts come, go and change numbers,
 * loads and limits change. */
static void call_solver(fuzz_bytes *b, const dls_contact *first) {
  dls_contact problem = *first;
  const int d = problem.d, top = problem.nc + take_int(b, 0, 2);
  int left = take_byte(b);
  dls_solver_settings s;
  dls_solver *solver;
  dls_info info;
  dls_error error;
  dls_solver_settings_init(&s);
  take_limits(b, &s.limits);
  s.limits.cpu_seconds = 0.1; /* all steps of auto take seconds on some */
  s.limits.threads = take_int(b, 0, 2);
  s.limits.blocks = problem.Wb.x ? problem.Wb.p[problem.nc] : 0;
  if (problem.bodies.H) (void)!dls_bodies_count(&problem, &s.limits.blocks, &error);
  if (left < 128) {
    s.limits.progress = cancel;
    s.limits.progress_data = &left;
  }
  s.method = (dls_method)(take_byte(b) < 160 ? DLS_AUTO : take_int(b, 0, 8));
  s.forces = (dls_forces)take_int(b, 0, 1);
  s.positive_definite = take_byte(b) < 20;
  s.plan = take_words(b);
  s.without = take_words(b);
  if (dls_solver_create(&solver, d, top, &s, &error)) {
    FUZZ_CHECK(solver == NULL);
    return;
  }
  double *r = fuzz_doubles(NULL, d * problem.nc);
  take_vector(b, d * problem.nc, r);
  for (int turn = 0; turn < 4; turn++) {
    const int what = take_byte(b);
    double *u = what & 1 ? fuzz_doubles(NULL, d * problem.nc) : NULL;
    const dls_status status =
        dls_solver_solve(solver, &problem, r, u, what & 2 ? &info : NULL, &error);
    if (status < 0) break;
    check_solved(&problem, r, status, s.limits.tol);
    char text[64];
    if (what & 2) (void)dls_explain(&info, text, sizeof text);
    if (what & 4) {
      take_limits(b, &s.limits);
      if (dls_solver_set_limits(solver, &s.limits, &error)) break;
    }
    if (!(what & 8)) continue;
    const int nc = take_int(b, 0, top);
    int *from = fuzz_ints(NULL, nc);
    for (int c = 0; c < nc; c++)
      from[c] = take_byte(b) % (problem.nc + 2) - 1;
    double *mapped = fuzz_doubles(NULL, d * nc);
    if (dls_solver_map(solver, nc, from, mapped, &error)) continue;
    dls_contact next;
    take_contact(b, &next);
    if (next.d != d || next.nc != nc) continue;
    problem = next;
    r = mapped;
  }
  dls_solver_destroy(solver);
}

/* Asks for all that is known of an answer. */
static void call_facts(fuzz_bytes *b, const dls_contact *problem) {
  const int d = problem->d, nc = problem->nc, m = d * nc;
  double *r = fuzz_doubles(NULL, m), *u = fuzz_doubles(NULL, m);
  dls_solver_settings s;
  dls_error error;
  dls_solver_settings_init(&s);
  take_limits(b, &s.limits);
  s.limits.cpu_seconds = 0.1;
  if (dls_solve(problem, &s, r, u, NULL, &error) < 0) return;
  dls_proof proof;
  dls_sensitivity sensitivity;
  dls_contact_state *state = fuzz_exact(NULL, (size_t)nc * sizeof *state);
  int freedom;
  (void)!dls_contact_states(problem, r, u, state, &error);
  (void)!dls_contact_misfits(problem, r, u, fuzz_doubles(NULL, nc), &error);
  (void)!dls_contact_sensitivity(problem, r, &sensitivity, &error);
  (void)!dls_contact_freedom(problem, r, &freedom, &error);
  if (take_byte(b) < 128 && d == 2 && nc <= 3) {
    const int capacity = take_int(b, 1, 6), what = take_byte(b);
    double *low = what & 1 ? fuzz_doubles(NULL, capacity * m) : NULL;
    dls_solution_set set;
    dls_fold fold;
    (void)!dls_contact_enumerate(problem, 1e-8, capacity, fuzz_doubles(NULL, capacity * m), low,
                                 low ? fuzz_doubles(NULL, capacity * m) : NULL, &set, &error);
    (void)!dls_contact_fold(
        problem, &fold, what & 2 ? state : NULL, what & 4 ? fuzz_doubles(NULL, m) : NULL,
        what & 8 ? fuzz_doubles(NULL, m) : NULL, what & 16 ? fuzz_doubles(NULL, m) : NULL, &error);
  }
  (void)!dls_contact_prove(problem, r, &proof, take_byte(b) & 1 ? r : fuzz_doubles(NULL, m),
                           &error);
  dls_derive *derive;
  if (dls_derive_create(&derive, problem, r, take_byte(b) % 3 - 1, &error)) return;
  const int values = problem->W.a    ? problem->W.ld * m
                     : problem->Wb.x ? d * d * problem->Wb.p[nc]
                                     : 2 * problem->bodies.n * m;
  take_vector(b, m, u);
  const int what = take_byte(b);
  const dls_derive_data data = {what & 1 ? fuzz_doubles(NULL, nc) : NULL,
                                what & 2 ? fuzz_doubles(NULL, m) : NULL,
                                what & 4 ? fuzz_doubles(NULL, values) : NULL,
                                NULL,
                                NULL,
                                NULL};
  const dls_derive_answer loss = {what & 8 ? u : NULL, what & 16 ? u : NULL, NULL};
  const dls_derive_answer moved = {fuzz_doubles(NULL, m), what & 32 ? fuzz_doubles(NULL, m) : NULL,
                                   NULL};
  if (dls_derive_vjp(derive, &loss, &data, &error) == DLS_OK)
    (void)!dls_derive_jvp(derive, &data, &moved, &error);
  dls_derive_destroy(derive);
}

void fuzz_calls(const unsigned char *data, size_t size) {
  fuzz_bytes b = {data, size};
  dls_contact problem;
  take_contact(&b, &problem);
  if (take_byte(&b) < 64) {
    double *weights = fuzz_doubles(NULL, 2 * problem.nc);
    take_vector(&b, 2 * problem.nc, weights);
    for (int k = 0; k < 2 * problem.nc; k++)
      weights[k] = fabs(weights[k]);
    problem.weights = weights;
  }
  (take_byte(&b) < 160 ? call_solver : call_facts)(&b, &problem);
}

/* The words of a plan, and after the first line those that are left out; a good one solves. */
void fuzz_plans(const unsigned char *data, size_t size) {
  const char *line = memchr(data, '\n', size);
  const size_t length = line ? (size_t)(line - (const char *)data) : size, rest = size - length;
  char *plan = fuzz_exact(NULL, length + 1), *without = fuzz_exact(NULL, rest + 1);
  memcpy(plan, data, length);
  plan[length] = '\0';
  memcpy(without, rest ? line + 1 : "", rest ? rest - 1 : 0);
  without[rest ? rest - 1 : 0] = '\0';
  dls_solver_settings s;
  dls_error error;
  dls_solver_settings_init(&s);
  s.limits.max_iterations = 200;
  s.plan = plan;
  s.without = rest ? without : NULL;
  const double W[16] = {2, 1, 0, 1, 1, 2, 1, 0, 0, 1, 2, 1, 1, 0, 1, 2}, q[4] = {-1, .3, -1, -.8};
  const double mu[2] = {.5, .3};
  const dls_contact problem = {.d = 2,
                               .nc = 2,
                               .W = {4, 4, 4, fuzz_doubles(W, 16)},
                               .q = fuzz_doubles(q, 4),
                               .mu = fuzz_doubles(mu, 2)};
  double *r = fuzz_doubles(NULL, 4);
  const dls_status status = dls_solve(&problem, &s, r, NULL, NULL, &error);
  if (status >= 0)
    check_solved(&problem, r, status, s.limits.tol);
  else
    FUZZ_CHECK(status == DLS_E_ARGUMENT &&
               (!strcmp(error.argument, "plan") || !strcmp(error.argument, "without")));
}

/* A file of numbers by each reader of the program. */
void fuzz_tables(const unsigned char *data, size_t size) {
  const char *path = fuzz_file(data, size);
  table t = {0};
  if (table_read(path, &t)) {
    FUZZ_CHECK(t.rows > 0 && t.cols > 0);
    volatile double sum = 0; /* each entry is read */
    for (size_t k = 0; k < (size_t)t.rows * (size_t)t.cols; k++)
      sum += t.a[k];
    free(table_by_columns(path, &t));
  }
  free(t.a);
  sparse A = {0};
  if (sparse_read(path, &A)) {
    FUZZ_CHECK(A.view.rows > 0 && A.view.cols > 0 && A.view.p[0] == 0);
    for (int j = 0; j < A.view.cols; j++)
      for (int k = A.view.p[j]; k < A.view.p[j + 1]; k++)
        FUZZ_CHECK(A.view.i[k] >= 0 && A.view.i[k] < A.view.rows);
  }
  sparse_free(&A);
}

/* The same of a file that begins as .npy does. */
void fuzz_numpy(const unsigned char *data, size_t size) {
  static const char magic[] = "\x93NUMPY";
  unsigned char *file = fuzz_exact(data, size);
  memcpy(file, magic, size < sizeof magic - 1 ? size : sizeof magic - 1);
  fuzz_tables(file, size);
}
