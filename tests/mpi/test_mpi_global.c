/* test_mpi_global.c: the contact problem on K itself on several ranks against the serial one; a
 * host's solver; errors, limits, memory. Run by tests/mpi/run.sh under mpirun. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "delassus.h"
#include "malloc_fails.h"
#include "shares.h"
#include "solids.h"

static int rank, ranks;
static const double tol = 1e-9, close_by = 1e-6;

/* A model, its loads, and the answer of dls_global_solve. */
typedef struct scene {
  dls_model model;
  int n, m, d;
  double *f, *g, *mu, *r, *x;
  dls_info info;
} scene;

static void *zero_array(size_t count, size_t size) {
  void *p = calloc(count + 1, size);
  if (!p) MPI_Abort(MPI_COMM_WORLD, 1);
  return p;
}

/* Solves in this process alone. */
static void scene_solve(scene *s) {
  dls_global *global = NULL;
  dls_error error = {0};
  const dls_limits limits = {.tol = tol};
  dls_status status = dls_global_create(&global, &s->model, &error);
  if (!status)
    status = dls_global_solve(global, s->f, s->g, s->mu, &limits, s->r, s->x, &s->info, &error);
  EXPECT(status == DLS_OK, "serial: %d, residual %g, %s", status, s->info.certificate.residual,
         error.message);
  dls_global_destroy(global);
}

static scene scene_of(const dls_model *model) {
  scene s = {.model = *model, .n = model->n, .d = model->d, .m = model->d * model->nodes};
  s.f = zero_array((size_t)s.n, sizeof *s.f);
  s.x = zero_array((size_t)s.n, sizeof *s.x);
  s.g = zero_array((size_t)s.m, sizeof *s.g);
  s.mu = zero_array((size_t)s.m, sizeof *s.mu);
  s.r = zero_array((size_t)s.m, sizeof *s.r);
  return s;
}

/* Loads a box that is held: presses some nodes, lifts others, shears. */
static scene scene_of_box(const box *b, double mu) {
  scene s = scene_of(&b->model);
  for (int i = 0; i < s.n; i++)
    s.f[i] = 1e-4 * sin(1 + i);
  for (int c = 0; c < b->model.nodes; c++) {
    s.mu[c] = mu;
    s.g[s.d * c] = -1e-2 * (1 + 0.5 * cos(c));
    s.g[s.d * c + 1] = 4e-3;
  }
  scene_solve(&s);
  return s;
}

static void scene_free(scene *s) {
  double *const owned[] = {s->f, s->x, s->g, s->mu, s->r};
  for (int k = 0; k < 5; k++)
    free(owned[k]);
}

/* ---- a host's solver: conjugate gradients on all of A ---------------------------------------- */

typedef struct host {
  const dls_model *model;
  const share *part;
  double *R, *b, *p, *v, *w; /* m, n each */
  int *rows, *starts;
  int prepared, solved, steps;
  dls_status fails;
} host;

static host host_of(const dls_model *model, const share *part) {
  host h = {.model = model, .part = part};
  const size_t n = (size_t)model->n;
  h.R = zero_array((size_t)(model->d * model->nodes), sizeof *h.R);
  h.b = zero_array(4 * n, sizeof *h.b);
  h.p = h.b + n;
  h.v = h.p + n;
  h.w = h.v + n;
  h.rows = zero_array(4 * (size_t)ranks, sizeof *h.rows);
  h.starts = h.rows + ranks;
  (void)MPI_Allgather(&part->model.rows, 1, MPI_INT, h.rows, 1, MPI_INT, MPI_COMM_WORLD);
  (void)MPI_Allgather(&part->first_row, 1, MPI_INT, h.starts, 1, MPI_INT, MPI_COMM_WORLD);
  const int own = model->d * part->model.nodes, first = model->d * part->first_node;
  (void)MPI_Allgather(&own, 1, MPI_INT, h.rows + 2 * ranks, 1, MPI_INT, MPI_COMM_WORLD);
  (void)MPI_Allgather(&first, 1, MPI_INT, h.rows + 3 * ranks, 1, MPI_INT, MPI_COMM_WORLD);
  return h;
}

static void host_free(host *h) {
  free(h->R);
  free(h->b);
  free(h->rows);
}

static dls_status cg_prepare(void *data, const double *R, dls_error *error) {
  host *h = data;
  (void)error;
  (void)MPI_Allgatherv(R, h->model->d * h->part->model.nodes, MPI_DOUBLE, h->R, h->rows + 2 * ranks,
                       h->rows + 3 * ranks, MPI_DOUBLE, MPI_COMM_WORLD);
  h->prepared++;
  return DLS_OK;
}

static double inner(const double *a, const double *b, int n) {
  double sum = 0;
  for (int k = 0; k < n; k++)
    sum += a[k] * b[k];
  return sum;
}

static dls_status cg_solve(void *data, const double *b, double *x, double accuracy,
                           dls_error *error) {
  host *h = data;
  const int n = h->model->n, rows = h->part->model.rows, first = h->part->first_row;
  (void)error;
  h->solved++;
  (void)MPI_Allgatherv(b, rows, MPI_DOUBLE, h->b, h->rows, h->starts, MPI_DOUBLE, MPI_COMM_WORLD);
  (void)MPI_Allgatherv(x, rows, MPI_DOUBLE, h->w, h->rows, h->starts, MPI_DOUBLE, MPI_COMM_WORLD);
  if (h->fails && rank == ranks - 1) return h->fails;
  double *left = h->b, *all = h->w;
  const double goal = accuracy * sqrt(inner(h->b, h->b, n));
  solids_apply(h->model, h->R, all, h->v);
  for (int k = 0; k < n; k++)
    h->p[k] = left[k] -= h->v[k];
  double size = inner(left, left, n);
  for (int step = 0; step < 20 * n && sqrt(size) > goal; step++) {
    solids_apply(h->model, h->R, h->p, h->v);
    const double a = size / inner(h->p, h->v, n), before = size;
    for (int k = 0; k < n; k++) {
      all[k] += a * h->p[k];
      left[k] -= a * h->v[k];
    }
    size = inner(left, left, n);
    for (int k = 0; k < n; k++)
      h->p[k] = left[k] + size / before * h->p[k];
    h->steps++;
  }
  memcpy(x, all + first, (size_t)rows * sizeof *x);
  return DLS_OK;
}

/* ---- answers --------------------------------------------------------------------------------- */

/* Compares r, x and the certificate of this rank with the serial ones. by_host: 1: conjugate
 * gradients in the place of the factor. A warm start of the answer ends at once. */
static void compare_pairs(const scene *s, cut how, int by_host) {
  share part = share_take(&s->model, how, s->f, s->g, s->mu);
  dls_mpi_global *global = NULL;
  dls_error error = {0};
  dls_info info = {0};
  dls_mpi_info cost = {0};
  host h = host_of(&s->model, &part);
  const dls_global_solver solver = {.data = &h, .prepare = cg_prepare, .solve = cg_solve};
  dls_limits limits = {.tol = tol};
  const int own = s->d * part.model.nodes, first = s->d * part.first_node;
  double *r = zero_array((size_t)own, sizeof *r),
         *x = zero_array((size_t)part.model.rows, sizeof *x);
  dls_status status =
      dls_mpi_global_create(&global, MPI_COMM_WORLD, &part.model, by_host ? &solver : NULL, &error);
  EXPECT(!status && global, "create: %s", error.message);
  status = dls_mpi_global_solve(global, part.f, part.g, part.mu, &limits, r, x, &info, &error);
  EXPECT(status == DLS_OK && info.status == DLS_OK, "solve: %d, residual %g, %d iterations, %s",
         status, info.certificate.residual, info.iterations, error.message);
  EXPECT(apart(r, s->r + first, own, s->r, s->m) <= close_by, "r: %g",
         apart(r, s->r + first, own, s->r, s->m));
  EXPECT(apart(x, s->x + part.first_row, part.model.rows, s->x, s->n) <= close_by, "x: %g",
         apart(x, s->x + part.first_row, part.model.rows, s->x, s->n));
  EXPECT(dls_certificate_holds(&info.certificate, limits.tol), "residual %g",
         info.certificate.residual);
  EXPECT(!by_host || (h.prepared == info.factorisations && h.solved == info.iterations),
         "%d prepared, %d solved", h.prepared, h.solved);
  status = dls_mpi_global_get_info(global, &cost, &error);
  EXPECT(!status && cost.n == s->n && cost.m == s->m && cost.condensed == 0 &&
             (cost.wall[DLS_MPI_FACTOR] > 0) == (!by_host && ranks > 1),
         "info: n %d, m %d", cost.n, cost.m);
  limits.warm_start = 1;
  status = dls_mpi_global_solve(global, part.f, part.g, part.mu, &limits, r, x, &info, &error);
  EXPECT(status == DLS_OK && info.iterations == 0, "warm: %d, %d iterations", status,
         info.iterations);
  dls_mpi_global_destroy(global);
  host_free(&h);
  share_free(&part);
  free(r);
  free(x);
}

static void test_answers(void) {
  box cube, plate, strip, skew;
  if (box_create(&cube, 3, 4, 0) || box_create_glued(&plate, 3, 6, 2) ||
      box_create_glued(&strip, 2, 24, 3) || box_create(&skew, 3, 3, 0.1))
    MPI_Abort(MPI_COMM_WORLD, 1);
  scene scenes[] = {scene_of_box(&cube, 0.3), scene_of_box(&plate, 0.3), scene_of_box(&strip, 0.6),
                    scene_of_box(&skew, 0.2)};
  for (int k = 0; k < 4; k++) /* each message costs a turn of the scheduler on a busy machine */
    compare_pairs(&scenes[k], (cut)(k % CUTS), 0);
  compare_pairs(&scenes[1], CUT_EVEN, 1);
  compare_pairs(&scenes[2], CUT_UNEVEN, 1);
  for (int k = 0; k < 4; k++)
    scene_free(&scenes[k]);
  box_free(&cube);
  box_free(&plate);
  box_free(&strip);
  box_free(&skew);
}

/* A square of four nodes joined by springs: nodes 0, 1 touch the floor, springs of `ground` hold
 * every unknown. Ten blows of the load of 10. */
typedef struct square {
  dls_model model;
  double x[16];
} square;

static square square_of(double ground) {
  static const int p[] = {0, 3, 6, 8, 10, 12, 14, 15, 16};
  static const int i[] = {0, 2, 4, 1, 3, 5, 2, 6, 3, 7, 4, 6, 5, 7, 6, 7};
  static const int each[] = {0, 1, 2}, normal[] = {1, 3}, tangent[] = {0, 2};
  static const double one[] = {1, 1};
  square s = {.model = {.d = 2,
                        .n = 8,
                        .nodes = 2,
                        .operator_kind = DLS_STIFFNESS_SPARSE,
                        .factorization = DLS_CHOLESKY,
                        .HN = {8, 2, each, normal, one},
                        .HT = {8, 2, each, tangent, one}}};
  for (int j = 0; j < 8; j++)
    for (int k = p[j]; k < p[j + 1]; k++)
      s.x[k] = i[k] == j ? 2 + ground : -1;
  s.model.Ks = (dls_sparse){8, 8, p, i, NULL};
  return s;
}

/* Bodies that nothing, or next to nothing, but contact holds; without friction their motion
 * sideways is held by nothing (E of system.c). */
static void test_free(void) {
  const double grounds[] = {1e-8, 0, 0}, mus[] = {0.3, 0.3, 0};
  for (int k = 0; k < 3; k++) {
    square s = square_of(grounds[k]);
    s.model.Ks.x = s.x;
    scene of = scene_of(&s.model);
    of.f[5] = of.f[7] = -5;
    of.mu[0] = of.mu[1] = mus[k];
    scene_solve(&of);
    compare_pairs(&of, (cut)(k % CUTS), 0);
    EXPECT(fabs(of.r[0] - 5) <= close_by && fabs(of.r[2] - 5) <= close_by, "r = %g, %g", of.r[0],
           of.r[2]);
    scene_free(&of);
  }
  square s = square_of(0); /* lifted: a motion proves that there is no answer */
  s.model.Ks.x = s.x;
  scene of = scene_of(&s.model);
  of.f[5] = of.f[7] = 5;
  share part = share_take(&s.model, CUT_EVEN, of.f, of.g, of.mu);
  dls_mpi_global *global = NULL;
  dls_error error = {0};
  dls_info info = {0};
  dls_status status = dls_mpi_global_create(&global, MPI_COMM_WORLD, &part.model, NULL, &error);
  EXPECT(!status, "create: %s", error.message);
  const dls_limits limits = {.tol = 1e-8, .max_iterations = ranks > 1 ? 40 : 0};
  status =
      dls_mpi_global_solve(global, part.f, part.g, part.mu, &limits, of.r, of.x, &info, &error);
  EXPECT(status == DLS_NO_SOLUTION && info.status == status, "lifted: %d", status);
  int mover = -1;
  const double *b = dls_mpi_global_motion(global, &mover);
  for (int k = 0; rank == 0 && k < 8; k++)
    EXPECT(b && mover >= 0 && fabs(b[k] - k % 2) <= 1e-12, "motion of %d: %g", k, b ? b[k] : 0);
  of.f[5] = of.f[7] = -5; /* pressed: solved, and nothing is left of the proof */
  share_free(&part);
  part = share_take(&s.model, CUT_EVEN, of.f, of.g, of.mu);
  status = dls_mpi_global_solve(global, part.f, part.g, part.mu, NULL, of.r, of.x, &info, &error);
  EXPECT(status == DLS_OK && !dls_mpi_global_motion(global, NULL), "pressed: %d", status);
  dls_mpi_global_destroy(global);
  share_free(&part);
  scene_free(&of);
}

/* ---- errors ---------------------------------------------------------------------------------- */

static void expect_all(dls_status status, const dls_error *error, dls_status wanted,
                       const char *argument) {
  EXPECT(status == wanted && error->status == wanted && !strcmp(error->argument, argument),
         "%s: %d, '%s', %s", argument, status, error->argument, error->message);
}

static int stop_at_once(void *data, const dls_progress *progress) {
  ++*(int *)data;
  return progress->iteration >= 10;
}

static void test_bad_calls(void) {
  box b;
  if (box_create(&b, 3, 3, 0)) MPI_Abort(MPI_COMM_WORLD, 1);
  scene s = scene_of_box(&b, 0.3);
  const int bad = rank == ranks - 1;
  share part = share_take(&s.model, CUT_EVEN, s.f, s.g, s.mu);
  host h = host_of(&s.model, &part);
  dls_global_solver solver = {.data = &h, .prepare = cg_prepare};
  dls_mpi_global *global = NULL;
  dls_error error = {0};
  dls_info info = {0};
  double *r = zero_array((size_t)s.m, sizeof *r), *x = zero_array((size_t)s.n, sizeof *x);
  double *spoilt = zero_array((size_t)s.n, sizeof *spoilt);
  spoilt[0] = NAN;
  dls_status status =
      dls_mpi_global_create(&global, MPI_COMM_WORLD, bad ? NULL : &part.model, NULL, &error);
  expect_all(status, &error, DLS_E_ARGUMENT, "model");
  solver.solve = bad ? NULL : cg_solve;
  status = dls_mpi_global_create(&global, MPI_COMM_WORLD, &part.model, &solver, &error);
  expect_all(status, &error, DLS_E_ARGUMENT, "solver");
  solver.solve = cg_solve;
  if (ranks > 1) {
    status =
        dls_mpi_global_create(&global, MPI_COMM_WORLD, &part.model, bad ? &solver : NULL, &error);
    expect_all(status, &error, DLS_E_ARGUMENT, "solver");
  }
  EXPECT(!global, "out after an error");
  status = dls_mpi_global_create(&global, MPI_COMM_WORLD, &part.model, &solver, &error);
  EXPECT(!status, "%s", error.message);
  status =
      dls_mpi_global_solve(global, bad ? spoilt : part.f, NULL, NULL, NULL, r, x, NULL, &error);
  expect_all(status, &error, DLS_E_NOT_FINITE, "f");
  status =
      dls_mpi_global_solve(global, NULL, bad ? spoilt : part.g, NULL, NULL, r, x, NULL, &error);
  expect_all(status, &error, DLS_E_NOT_FINITE, "g");
  status =
      dls_mpi_global_solve(global, NULL, NULL, bad ? spoilt : part.mu, NULL, r, x, NULL, &error);
  expect_all(status, &error, DLS_E_NOT_FINITE, "mu");
  status = dls_mpi_global_solve(global, NULL, NULL, NULL, NULL, bad ? NULL : r, x, NULL, &error);
  expect_all(status, &error, DLS_E_ARGUMENT, "r");
  status = dls_mpi_global_solve(global, NULL, NULL, NULL, NULL, r, bad ? NULL : x, NULL, &error);
  expect_all(status, &error, DLS_E_ARGUMENT, "x");
  h.fails = DLS_E_SINGULAR; /* on the last rank alone; the error is one of all */
  status = dls_mpi_global_solve(global, part.f, part.g, part.mu, NULL, r, x, &info, &error);
  expect_all(status, &error, DLS_E_SINGULAR, "solver");
  h.fails = DLS_OK;
  int calls = 0;
  dls_limits limits = {.tol = 1e-12};
  limits.progress = rank == 0 ? stop_at_once : NULL;
  limits.progress_data = &calls;
  status = dls_mpi_global_solve(global, part.f, part.g, part.mu, &limits, r, x, &info, &error);
  EXPECT(status == DLS_CANCELLED && info.iterations == 10, "cancel: %d, %d", status,
         info.iterations);
  EXPECT(calls == (rank == 0 ? 2 : 0), "%d calls", calls);
  limits.progress = NULL;
  limits.cpu_seconds = rank == 0 ? 1e-9 : 0;
  status = dls_mpi_global_solve(global, part.f, part.g, part.mu, &limits, r, x, &info, &error);
  EXPECT(status == DLS_TIME_LIMIT && info.status == status, "time: %d", status);
  limits.cpu_seconds = 0;
  limits.max_iterations = 3;
  status = dls_mpi_global_solve(global, part.f, part.g, part.mu, &limits, r, x, &info, &error);
  EXPECT(status == DLS_MAX_ITERATIONS && info.iterations == 3, "iterations: %d", status);
  dls_mpi_global_destroy(global);
  dls_mpi_global_destroy(NULL);
  host_free(&h);
  share_free(&part);
  free(spoilt);
  free(r);
  free(x);
  scene_free(&s);
  box_free(&b);
}

/* ---- memory ---------------------------------------------------------------------------------- */

static dls_status idle_prepare(void *data, const double *R, dls_error *error) {
  (void)data;
  (void)R;
  (void)error;
  return DLS_OK;
}

static dls_status idle_solve(void *data, const double *b, double *x, double accuracy,
                             dls_error *error) {
  (void)accuracy;
  (void)error;
  memcpy(x, b, (size_t) * (const int *)data * sizeof *x);
  return DLS_OK;
}

/* Every malloc of our own on the last rank fails in turn; nobody waits. newton: with a host's
 * solver, which solves nothing. */
static void test_no_memory(int newton) {
  box b;
  if (box_create(&b, 3, 2, 0)) MPI_Abort(MPI_COMM_WORLD, 1);
  scene s = scene_of_box(&b, 0.3);
  share part = share_take(&s.model, CUT_EVEN, s.f, s.g, s.mu);
  const dls_global_solver idle = {&part.model.rows, idle_prepare, idle_solve, idle_prepare,
                                  idle_solve};
  double *r = zero_array((size_t)s.m, sizeof *r), *x = zero_array((size_t)s.n, sizeof *x);
  const dls_limits limits = {.tol = 1e-2, .max_iterations = newton ? 2 : 0};
  int done = 0, k = 0;
  while (!done && k++ < 200) {
    dls_mpi_global *global = NULL;
    dls_error error = {0};
    malloc_fails_at(rank == ranks - 1 ? k : 0);
    dls_status status =
        dls_mpi_global_create(&global, MPI_COMM_WORLD, &part.model, newton ? &idle : NULL, &error);
    if (!status)
      status = dls_mpi_global_solve(global, part.f, part.g, part.mu, &limits, r, x, NULL, &error);
    const int mine = rank != ranks - 1 || malloc_calls() < k;
    malloc_fails_at(0);
    dls_mpi_global_destroy(global);
    (void)MPI_Allreduce(&mine, &done, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    EXPECT(done ? status >= 0 : status == DLS_E_MEMORY, "malloc %d: %d %s", k, status,
           error.message);
    EXPECT(newton || !done || status == DLS_OK, "%d", status);
  }
  EXPECT(done && k > 20, "%d mallocs", k);
  share_free(&part);
  free(r);
  free(x);
  scene_free(&s);
  box_free(&b);
}

/* Returns the most bytes that the library holds for a share in create and two iterations. */
static double memory_of(MPI_Comm comm, share part, int newton) {
  dls_mpi_global *global = NULL;
  dls_error error = {0};
  dls_global_solver solver = {.data = &part.model.rows, idle_prepare, idle_solve};
  if (newton) {
    solver.block = idle_prepare;
    solver.apply = idle_solve;
  }
  const dls_limits limits = {.tol = tol, .max_iterations = 2};
  double *r = zero_array((size_t)(3 * part.model.nodes), sizeof *r);
  double *x = zero_array((size_t)part.model.rows, sizeof *x);
  malloc_fails_at(0);
  dls_status status = dls_mpi_global_create(&global, comm, &part.model, &solver, &error);
  if (!status)
    status = dls_mpi_global_solve(global, part.f, part.g, part.mu, &limits, r, x, NULL, &error);
  const double most = (double)malloc_most();
  EXPECT(status > 0, "memory: %d %s", status, error.message);
  dls_mpi_global_destroy(global);
  free(r);
  free(x);
  return most;
}

/* The memory of all ranks together is less than 1.2 times that of one process: every vector and H
 * are shared out. A plate, of MEMORY elements along its sides if that is set. */
static void test_memory(void) {
  const char *asked = getenv("MEMORY");
  box plate;
  if (box_create_glued(&plate, 3, asked ? atoi(asked) : 30, 3)) MPI_Abort(MPI_COMM_WORLD, 1);
  scene s = scene_of(&plate.model);
  share whole = share_of(&s.model, CUT_EVEN, 0, 1, s.f, s.g, s.mu),
        part = share_take(&s.model, CUT_EVEN, s.f, s.g, s.mu);
  for (int k = 0; k < s.m; k += 3)
    s.g[k] = -1e-2;
  for (int newton = 0; newton < 2; newton++) {
    double alone = rank == 0 ? memory_of(MPI_COMM_SELF, whole, newton) : 0, most, sum;
    const double mine = memory_of(MPI_COMM_WORLD, part, newton);
    (void)MPI_Allreduce(&mine, &sum, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    (void)MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    (void)MPI_Bcast(&alone, 1, MPI_DOUBLE, 0, MPI_COMM_WORLD);
    EXPECT(sum <= 1.2 * alone, "%g MB on all ranks, alone %g", 1e-6 * sum, 1e-6 * alone);
    if (rank == 0 && asked)
      printf("%d ranks, %s: %.1f MB in one process, %.1f MB on all ranks, %.2f; largest %.1f MB\n",
             ranks, newton ? "Newton" : "splitting", 1e-6 * alone, 1e-6 * sum, sum / alone,
             1e-6 * most);
  }
  share_free(&whole);
  share_free(&part);
  scene_free(&s);
  box_free(&plate);
}

int main(int argc, char **argv) {
  (void)MPI_Init(&argc, &argv);
  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  (void)MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  test_answers();
  test_free();
  test_bad_calls();
  test_no_memory(0);
  test_no_memory(1);
  test_memory();
  const int failures = expect_end("test_mpi_global");
  (void)MPI_Finalize();
  return failures ? EXIT_FAILURE : EXIT_SUCCESS;
}
