/* test_mpi.c: the reduction and the solve on several ranks against the serial ones. Run by
 * tests/mpi/run.sh under mpirun. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "delassus.h"
#include "malloc_fails.h"
#include "shares.h"

static int rank, ranks;

/* A box, its loads, and the serial answer. */
typedef struct scene {
  box b;
  int n, m, d;
  double *f, *g, *mu, *W, *q, *r, *u, *x;
  dls_certificate off; /* of the pair (off_by r, x) */
} scene;

static const double off_by = 1.01;

/* Makes loads that press some nodes, lift others, and shear. */
static void scene_load(scene *s) {
  for (int i = 0; i < s->n; i++)
    s->f[i] = 1e-3 * sin(1 + i);
  for (int c = 0; c < s->b.model.nodes; c++) {
    s->mu[c] = c % 5 == 0 ? 0 : 0.2 + 0.1 * (c % 3);
    s->g[s->d * c] = -1e-2 * (1 + cos(c)) + 4e-3;
    s->g[s->d * c + 1] = 4e-3;
  }
}

/* Solves the scene in this process alone. */
static void scene_solve(scene *s) {
  dls_reduction *reduction = NULL;
  dls_contact problem;
  dls_solver_settings settings;
  dls_error error = {0};
  dls_info info;
  dls_solver_settings_init(&settings);
  settings.method = DLS_ADMM;
  settings.limits.tol = 1e-13;
  dls_reduction_settings to_W;
  dls_reduction_settings_init(&to_W);
  to_W.on = DLS_ON_W;
  dls_status status = dls_reduction_create(&reduction, &s->b.model, &to_W, &error);
  if (!status) status = dls_reduction_load(reduction, s->f, s->g, &error);
  if (!status) status = dls_reduction_contact(reduction, s->mu, &problem, &error);
  if (!status) status = dls_solve(&problem, &settings, s->r, s->u, &info, &error);
  if (status >= 0) status = dls_reduction_recover(reduction, s->r, s->x, &error);
  EXPECT(status == DLS_OK, "serial: %d %s", status, error.message);
  if (!status) {
    for (int j = 0; j < s->m; j++)
      memcpy(s->W + (size_t)j * (size_t)s->m, problem.W.a + (size_t)j * (size_t)problem.W.ld,
             (size_t)s->m * sizeof *s->W);
    memcpy(s->q, problem.q, (size_t)s->m * sizeof *s->q);
    double *r = malloc((size_t)s->m * sizeof *r);
    for (int k = 0; r && k < s->m; k++)
      r[k] = off_by * s->r[k];
    status = dls_reduction_certify(reduction, s->mu, r, s->x, NULL, &s->off, &error);
    EXPECT(r && status == DLS_OK, "serial certificate: %s", error.message);
    free(r);
  }
  dls_reduction_destroy(reduction);
}

static scene scene_create(int d, int cells, double skew) {
  scene s = {.d = d};
  if (box_create(&s.b, d, cells, skew)) MPI_Abort(MPI_COMM_WORLD, 1);
  s.n = s.b.model.n;
  s.m = d * s.b.model.nodes;
  const size_t n = (size_t)s.n, m = (size_t)s.m;
  s.f = calloc(2 * n + 6 * m + m * m, sizeof *s.f);
  if (!s.f) MPI_Abort(MPI_COMM_WORLD, 1);
  s.x = s.f + n;
  s.g = s.x + n;
  s.mu = s.g + m;
  s.q = s.mu + m;
  s.r = s.q + m;
  s.u = s.r + m;
  s.W = s.u + m;
  scene_load(&s);
  scene_solve(&s);
  return s;
}

static void scene_free(scene *s) {
  box_free(&s->b);
  free(s->f);
}

/* ---- answers --------------------------------------------------------------------------------- */

/* Expects the certificate of (off_by r, x) of the serial answer, as the serial reduction has it. */
static void compare_certificates(const scene *s, const share *part, dls_mpi_reduction *reduction) {
  dls_certificate seen;
  dls_error error = {0};
  const int own = s->d * part->model.nodes, first = s->d * part->first_node;
  double *r = malloc((size_t)(own + 1) * sizeof *r);
  for (int k = 0; r && k < own; k++)
    r[k] = off_by * s->r[first + k];
  const dls_status status =
      dls_mpi_certify(reduction, part->mu, r, s->x + part->first_row, NULL, &seen, &error);
  EXPECT(!status, "certify: %s", error.message);
  const double parts[][2] = {
      {seen.residual_u, s->off.residual_u},   {seen.residual_r, s->off.residual_r},
      {seen.equilibrium, s->off.equilibrium}, {seen.unbalanced, s->off.unbalanced},
      {seen.floor_u, s->off.floor_u},         {seen.floor_r, s->off.floor_r},
      {seen.floor_e, s->off.floor_e}};
  for (int k = 0; k < 7; k++) { /* the first two are positions near 0: rounding, in another order */
    const double rounding = k < 2 ? DBL_EPSILON : 0;
    EXPECT(fabs(parts[k][0] - parts[k][1]) <= 1e-9 * parts[k][1] + rounding,
           "part %d: %g, serial %g", k, parts[k][0], parts[k][1]);
  }
  EXPECT(seen.equilibrium > 1e-5 && seen.body == s->off.body && seen.worst == s->off.worst,
         "equilibrium %g, body %d, worst %d", seen.equilibrium, seen.body, seen.worst);
  free(r);
}

/* Compares W, q, r, u, x of this rank with the serial ones. */
static void compare(const scene *s, cut how, int gather, double tol) {
  share part = share_take(&s->b.model, how, s->f, s->g, s->mu);
  dls_mpi_reduction *reduction = NULL;
  dls_mpi_contact problem;
  dls_error error = {0};
  dls_info info = {0};
  dls_certificate seen = {0};
  const int own = s->d * part.model.nodes, first = s->d * part.first_node;
  double *r = calloc((size_t)(2 * s->m + s->n + 1), sizeof *r), *u = r + s->m, *x = u + s->m;
  double *W = calloc((size_t)s->m * (size_t)s->m + 1, sizeof *W);
  dls_mpi_settings settings;
  dls_mpi_settings_init(&settings);
  settings.limits.tol = 1e-13;
  settings.gather = gather;
  dls_status status =
      dls_mpi_reduction_create(&reduction, MPI_COMM_WORLD, &part.model, NULL, &error);
  EXPECT(!status, "create: %s", error.message);
  if (status || !reduction) return;
  status = dls_mpi_reduction_load(reduction, part.f, part.g, &error);
  EXPECT(!status, "load: %s", error.message);
  status = dls_mpi_reduction_contact(reduction, &problem, &error);
  EXPECT(!status && problem.m == s->m, "contact: %s", error.message);
  EXPECT(apart(problem.q, s->q, s->m, s->q, s->m) <= 1e-11, "q: %g",
         apart(problem.q, s->q, s->m, s->q, s->m));
  double most = 0, scale = 0;
  for (int j = 0; j < s->m; j++)
    scale = fmax(scale, s->W[(size_t)j * (size_t)(s->m + 1)]);
  for (int j = 0; j < problem.cols; j++)
    for (int i = 0; i < problem.rows; i++)
      most = fmax(most, fabs(problem.W[(size_t)i + (size_t)j * (size_t)problem.rows] -
                             s->W[(size_t)problem.row[i] + (size_t)problem.col[j] * (size_t)s->m]));
  EXPECT(most <= 1e-11 * scale, "W: %g of %g", most, scale);
  status = dls_mpi_reduction_gather(reduction, W, &error);
  EXPECT(!status, "gather: %s", error.message);
  if (rank == 0)
    EXPECT(apart(W, s->W, s->m * s->m, s->W, s->m * s->m) <= 1e-11, "gathered W: %g",
           apart(W, s->W, s->m * s->m, s->W, s->m * s->m));
  status = dls_mpi_solve(reduction, part.mu, &settings, r, u, &info, &error);
  EXPECT(status == DLS_OK && info.status == DLS_OK, "solve: %d, residual %g, %s", status,
         info.certificate.residual, error.message);
  EXPECT(apart(r, s->r + first, own, s->r, s->m) <= tol, "r: %g",
         apart(r, s->r + first, own, s->r, s->m));
  EXPECT(apart(u, s->u + first, own, s->u, s->m) <= tol, "u: %g",
         apart(u, s->u + first, own, s->u, s->m));
  status = dls_mpi_reduction_recover(reduction, r, x, &error);
  EXPECT(!status, "recover: %s", error.message);
  EXPECT(apart(x, s->x + part.first_row, part.model.rows, s->x, s->n) <= tol, "x: %g",
         apart(x, s->x + part.first_row, part.model.rows, s->x, s->n));
  EXPECT(info.certificate.equilibrium > 0 && info.certificate.equilibrium <= 1e-11,
         "equilibrium %g", info.certificate.equilibrium);
  compare_certificates(s, &part, reduction);
  if (rank == 0 && ranks == 1) { /* the certificate by the one that all methods share */
    const dls_contact whole = {
        .d = s->d, .nc = s->m / s->d, .W = {s->m, s->m, s->m, W}, .q = problem.q, .mu = s->mu};
    status = dls_contact_certify(&whole, r, NULL, &seen, &error);
    EXPECT(!status && dls_certificate_holds(&seen, 1e-13), "certificate %g", seen.residual);
  }
  dls_mpi_reduction_destroy(reduction);
  share_free(&part);
  free(W);
  free(r);
}

static void test_answers(void) {
  scene cube = scene_create(3, 6, 0), plate = scene_create(2, 40, 0),
        skew = scene_create(3, 4, 0.1);
  for (cut how = 0; how < CUTS; how++) {
    compare(&cube, how, 0, 1e-10);
    compare(&plate, how, 0, 1e-10);
    compare(&skew, how, 0, 1e-10);
  }
  compare(&cube, CUT_UNEVEN, 1000, 1e-10);
  scene_free(&cube);
  scene_free(&plate);
  scene_free(&skew);
}

/* A square of four nodes on springs of 1e-8, pressed to a floor by 10. Its W is 1e8 times as large
 * as its local compliance: an r that solves the problem on W may be wrong in all digits, as the one
 * where ADMM ends. "Solved" must not be said of it; r = 5, 5 is right. */
static void test_soft(void) {
  static const int row[] = {0, 1, 2, 3, 4, 5, 6, 7, 2, 4, 6, 6, 3, 5, 7, 7};
  static const int col[] = {0, 1, 2, 3, 4, 5, 6, 7, 0, 0, 2, 4, 1, 1, 3, 5};
  double x[16];
  const int all = rank == ranks - 1; /* which has the whole model */
  static const int p[] = {0, 1, 2}, none[] = {0, 0, 0}, normal[] = {1, 3}, tangent[] = {0, 2};
  static const double one[] = {1, 1}, mu[] = {0.3, 0.3}, f[] = {0, 0, 0, 0, 0, -5, 0, -5};
  for (int k = 0; k < 16; k++)
    x[k] = k < 8 ? 2 + 1e-8 : -1;
  const dls_mpi_model model = {2,
                               DLS_CHOLESKY,
                               all ? 8 : 0,
                               all ? 16 : 0,
                               row,
                               col,
                               x,
                               all ? 2 : 0,
                               {8, all ? 2 : 0, all ? p : none, normal, one},
                               {8, all ? 2 : 0, all ? p : none, tangent, one}};
  for (int gather = 0; gather <= 1000; gather += 1000) {
    dls_mpi_reduction *reduction = NULL;
    dls_mpi_contact problem;
    dls_error error = {0};
    dls_info info = {0};
    dls_certificate of_W = {0}, again;
    double r[4] = {0}, u[4], W[16], whole[4];
    double unknowns[8];
    dls_mpi_settings settings;
    dls_mpi_settings_init(&settings);
    settings.gather = gather;
    dls_status status = dls_mpi_reduction_create(&reduction, MPI_COMM_WORLD, &model, NULL, &error);
    if (!status) status = dls_mpi_reduction_load(reduction, f, NULL, &error);
    if (!status) status = dls_mpi_reduction_contact(reduction, &problem, &error);
    if (!status) status = dls_mpi_reduction_gather(reduction, W, &error);
    EXPECT(!status, "%s", error.message);
    if (!status) status = dls_mpi_solve(reduction, mu, &settings, r, u, &info, &error);
    const int solved = status == DLS_OK || status == DLS_TO_ROUNDING;
    memcpy(whole, r, sizeof r);
    (void)MPI_Bcast(whole, 4, MPI_DOUBLE, ranks - 1, MPI_COMM_WORLD);
    EXPECT(status >= 0 && info.status == status, "status %d, info %d: %s", status, info.status,
           error.message);
    EXPECT(!solved || (fabs(whole[0] - 5) < 1e-6 && fabs(whole[2] - 5) < 1e-6),
           "solved with r = %g, %g", whole[0], whole[2]);
    EXPECT(info.certificate.equilibrium > 0, "not the certificate of the body");
    if (rank == 0) {
      const dls_contact problem_on_W = {
          .d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = problem.q, .mu = mu};
      status = dls_contact_certify(&problem_on_W, whole, NULL, &of_W, &error);
      const int holds = !status && dls_certificate_verdict(&of_W, 1e-8) != DLS_STALLED;
      EXPECT(holds && (gather || !solved), "gather %d: W %g, body %g: no example of both", gather,
             of_W.residual, info.certificate.residual);
    }
    status = dls_mpi_reduction_recover(reduction, r, unknowns, &error);
    if (!status) status = dls_mpi_certify(reduction, mu, r, unknowns, u, &again, &error);
    EXPECT(!status && again.residual == info.certificate.residual, "certify: %g, solve said %g",
           again.residual, info.certificate.residual);
    dls_mpi_reduction_destroy(reduction);
  }
}

/* H with several entries a column, frames that are turned, an unknown in two columns. */
static void test_operator(void) {
  scene s = scene_create(3, 5, 0);
  const int nodes = s.b.model.nodes;
  int *p = malloc((size_t)(3 * nodes + 1) * sizeof *p), *i = malloc((size_t)nodes * 9 * sizeof *i);
  double *x = malloc((size_t)nodes * 9 * sizeof *x);
  if (!p || !i || !x) MPI_Abort(MPI_COMM_WORLD, 1);
  int *pt = p + nodes, at = 0;
  for (int c = 0; c < nodes; c++) { /* normals: mixed with the tangents of the next node */
    p[c] = at;
    const int next = (c + 1) % nodes;
    i[at] = s.b.hn[c], x[at++] = 0.8;
    i[at] = s.b.ht[2 * c], x[at++] = 0.6;
    i[at] = s.b.ht[2 * next], x[at++] = 0.1;
  }
  p[nodes] = at;
  const int normals = at;
  int *qt = malloc((size_t)(2 * nodes + 1) * sizeof *qt);
  if (!qt) MPI_Abort(MPI_COMM_WORLD, 1);
  for (int c = 0; c < 2 * nodes; c++) {
    qt[c] = at - normals;
    i[at] = c % 2 ? s.b.ht[c] : s.b.hn[c / 2], x[at++] = c % 2 ? 1 : -0.6;
    if (c % 2 == 0) i[at] = s.b.ht[c], x[at++] = 0.8;
  }
  qt[2 * nodes] = at - normals;
  (void)pt;
  s.b.model.HN = (dls_sparse){s.n, nodes, p, i, x};
  s.b.model.HT = (dls_sparse){s.n, 2 * nodes, qt, i + normals, x + normals};
  scene_solve(&s);
  compare(&s, CUT_EVEN, 0, 1e-10);
  s.b.model.factorization = DLS_LDLT;
  compare(&s, CUT_UNEVEN, 0, 1e-10);
  free(p);
  free(qt);
  free(i);
  free(x);
  scene_free(&s);
}

/* Equal bits of a second solve, the same answer after a second reduction, warm as cold, no
 * candidate at all. (The order in which MUMPS adds up follows the messages: W has other last bits
 * each time where there are more than two ranks.) */
static void test_repeat(void) {
  scene s = scene_create(3, 4, 0);
  share part = share_take(&s.b.model, CUT_EVEN, s.f, s.g, s.mu);
  const int own = 3 * part.model.nodes;
  double *r[3];
  dls_error error = {0};
  dls_mpi_settings settings;
  dls_mpi_settings_init(&settings);
  settings.gather = 0;
  settings.limits.tol = 1e-13;
  for (int k = 0; k < 3; k++) {
    r[k] = calloc((size_t)s.m + 1, sizeof *r[k]);
    if (!r[k]) MPI_Abort(MPI_COMM_WORLD, 1);
  }
  for (int k = 0; k < 2; k++) {
    dls_mpi_reduction *reduction = NULL;
    dls_info info = {0};
    dls_status status =
        dls_mpi_reduction_create(&reduction, MPI_COMM_WORLD, &part.model, NULL, &error);
    if (!status) status = dls_mpi_reduction_load(reduction, part.f, part.g, &error);
    settings.limits.warm_start = 0;
    if (!status) status = dls_mpi_solve(reduction, part.mu, &settings, r[k], NULL, NULL, &error);
    if (!status) status = dls_mpi_solve(reduction, part.mu, &settings, r[2], NULL, NULL, &error);
    EXPECT(status == DLS_OK, "%s", error.message);
    EXPECT(!memcmp(r[k], r[2], (size_t)own * sizeof **r), "other bits");
    settings.limits.warm_start = 1;
    status = dls_mpi_solve(reduction, part.mu, &settings, r[2], NULL, &info, &error);
    EXPECT(!status && info.iterations == 0, "warm: %d iterations", info.iterations);
    dls_mpi_reduction_destroy(reduction);
  }
  EXPECT(apart(r[0], r[1], own, s.r, s.m) <= 1e-10, "another answer");
  free(r[2]);
  part.model.nodes = 0;
  dls_mpi_reduction *reduction = NULL;
  dls_info info = {0};
  double *x = calloc((size_t)s.n + 1, sizeof *x);
  dls_status status =
      dls_mpi_reduction_create(&reduction, MPI_COMM_WORLD, &part.model, NULL, &error);
  if (!status) status = dls_mpi_reduction_load(reduction, part.f, NULL, &error);
  if (!status) status = dls_mpi_solve(reduction, NULL, NULL, NULL, NULL, &info, &error);
  if (!status) status = dls_mpi_reduction_recover(reduction, NULL, x, &error);
  EXPECT(status == DLS_OK && info.status == DLS_OK, "no candidate: %d %s", status, error.message);
  dls_mpi_reduction_destroy(reduction);
  share_free(&part);
  free(r[0]);
  free(r[1]);
  free(x);
  scene_free(&s);
}

/* ---- errors ---------------------------------------------------------------------------------- */

/* Expects the same error on every rank, from the one that made it. */
static void expect_same(dls_status status, const dls_error *error, dls_status wanted,
                        const char *argument, const char *name) {
  char start[32];
  (void)snprintf(start, sizeof start, "rank %d: ", ranks - 1);
  EXPECT(status == wanted && error->status == wanted, "%s: status %d, %s", name, status,
         error->message);
  EXPECT(!strcmp(error->argument, argument), "%s: argument '%s'", name, error->argument);
  EXPECT(ranks == 1 || strstr(error->message, start) || wanted == DLS_E_SINGULAR ||
             wanted == DLS_E_NOT_POSITIVE_DEFINITE,
         "%s: message '%s'", name, error->message);
}

/* Spoils the share of the last rank in one slot after the other. */
static void test_bad_input(void) {
  scene s = scene_create(3, 3, 0);
  const int bad = rank == ranks - 1;
  static const char *const slots[] = {
      "d", "factorization", "rows", "row", "col", "x", "nodes", "HN", "HT", "row", "col", "x"};
  for (int k = 0; k < (int)(sizeof slots / sizeof slots[0]); k++) {
    share part = share_take(&s.b.model, CUT_EVEN, s.f, s.g, s.mu);
    dls_mpi_model *model = &part.model;
    dls_mpi_reduction *out = NULL;
    dls_error error = {0};
    double nan_x = NAN;
    dls_status wanted = DLS_E_ARGUMENT;
    if (k == 0 && bad) model->d = 4;
    if (k == 1 && bad) model->factorization = 9;
    if (k == 2) wanted = DLS_E_SIZE;
    if (k == 2 && bad) model->rows = -1;
    if (k == 3 && bad) model->row = NULL;
    if (k == 4 && bad) model->col = NULL;
    if (k == 5 && bad) model->x = NULL;
    if (k == 6) wanted = DLS_E_SIZE;
    if (k == 6 && bad) model->nodes = -1;
    if (k == 7 && bad) model->HN.x = NULL;
    if (k == 8 && bad) model->HT.p = NULL;
    if (k == 9 && bad) part.row[1] = s.n;
    if (k == 10 && bad) part.col[0] = -1;
    if (k == 11) wanted = DLS_E_NOT_FINITE;
    if (k == 11 && bad) {
      model->x = &nan_x;
      model->entries = 1;
    }
    const dls_status status = dls_mpi_reduction_create(&out, MPI_COMM_WORLD, model, NULL, &error);
    EXPECT(status == wanted, "slot %d: %d %s", k, status, error.message);
    expect_same(status, &error, wanted, error.argument, slots[k]);
    EXPECT(!strncmp(error.argument, slots[k], strlen(slots[k])), "slot %d: argument '%s'", k,
           error.argument);
    EXPECT(!out, "slot %d: out", k);
    share_free(&part);
  }
  scene_free(&s);
}

static int stop_at_once(void *data, const dls_progress *progress) {
  ++*(int *)data;
  return progress->iteration >= 2;
}

/* Counts the last calls; the residual of each is that of the body. */
static int count_last(void *data, const dls_progress *progress) {
  double *seen = data;
  if (!progress->last) return 0;
  seen[0]++;
  seen[1] = progress->residual;
  return 0;
}

/* A tolerance that the certificate of the body meets only after a second turn on W: one solve for
 * the callback, whose limits hold for all turns. */
static void test_turns(void) {
  scene s = scene_create(3, 3, 0);
  share part = share_take(&s.b.model, CUT_EVEN, s.f, s.g, s.mu);
  double seen[2] = {0}, *r = calloc((size_t)s.m + 1, sizeof *r);
  for (int gather = 0; gather <= 1000; gather += 1000) {
    dls_mpi_reduction *reduction = NULL;
    dls_error error = {0};
    dls_info info = {0};
    dls_mpi_settings settings;
    dls_mpi_settings_init(&settings);
    settings.gather = gather;
    settings.limits.progress = rank == 0 ? count_last : NULL;
    settings.limits.progress_data = seen;
    seen[0] = 0;
    dls_status status =
        dls_mpi_reduction_create(&reduction, MPI_COMM_WORLD, &part.model, NULL, &error);
    if (!status) status = dls_mpi_reduction_load(reduction, part.f, part.g, &error);
    for (double tol = 1e-2; !status && tol > 1e-9; tol /= 10) {
      settings.limits.tol = tol;
      seen[0] = 0;
      status = dls_mpi_solve(reduction, part.mu, &settings, r, NULL, &info, &error);
      EXPECT(!status && dls_certificate_holds(&info.certificate, tol), "tol %g: %d, %g", tol,
             status, info.certificate.residual);
      EXPECT(seen[0] == (rank == 0) && (rank || seen[1] == info.certificate.residual),
             "%g last calls, residual %g of %g", seen[0], seen[1], info.certificate.residual);
    }
    const int most = info.iterations;
    settings.limits.max_iterations = 1;
    status = dls_mpi_solve(reduction, part.mu, &settings, r, NULL, &info, &error);
    EXPECT(status >= 0 && info.iterations <= (gather ? most : 1), "%d iterations", info.iterations);
    dls_mpi_reduction_destroy(reduction);
  }
  free(r);
  share_free(&part);
  scene_free(&s);
}

/* Bad vectors and settings; limits. */
static void test_bad_calls(void) {
  scene s = scene_create(3, 3, 0);
  const int bad = rank == ranks - 1;
  share part = share_take(&s.b.model, CUT_EVEN, s.f, s.g, s.mu);
  dls_mpi_reduction *reduction = NULL;
  dls_error error = {0};
  dls_info info = {0};
  double *r = calloc((size_t)s.m + 1, sizeof *r), *spoilt = calloc((size_t)s.n, sizeof *spoilt);
  dls_mpi_contact problem;
  dls_status status =
      dls_mpi_reduction_create(&reduction, MPI_COMM_WORLD, &part.model, NULL, &error);
  if (!status) status = dls_mpi_reduction_load(reduction, part.f, part.g, &error);
  EXPECT(!status, "%s", error.message);
  if (!status) status = dls_mpi_reduction_contact(reduction, &problem, &error);
  const double q0 = problem.q[0];
  spoilt[0] = NAN;
  status = dls_mpi_reduction_load(reduction, bad ? spoilt : part.f, NULL, &error);
  expect_same(status, &error, DLS_E_NOT_FINITE, "f", "load f");
  status = dls_mpi_reduction_load(reduction, NULL, bad ? spoilt : part.g, &error);
  expect_same(status, &error, DLS_E_NOT_FINITE, "g", "load g");
  EXPECT(problem.q[0] == q0, "an error changed q");
  status = dls_mpi_reduction_recover(reduction, bad ? spoilt : r, spoilt + 1, &error);
  expect_same(status, &error, DLS_E_NOT_FINITE, "r", "recover r");
  status = dls_mpi_solve(reduction, bad ? NULL : part.mu, NULL, r, NULL, &info, &error);
  expect_same(status, &error, DLS_E_ARGUMENT, "mu", "solve mu");
  status = dls_mpi_solve(reduction, part.mu, NULL, bad ? NULL : r, NULL, &info, &error);
  expect_same(status, &error, DLS_E_ARGUMENT, "r", "solve r");
  dls_certificate seen = {.residual = 7};
  status = dls_mpi_certify(reduction, part.mu, r, bad ? spoilt : part.f, NULL, &seen, &error);
  expect_same(status, &error, DLS_E_NOT_FINITE, "x", "certify x");
  status = dls_mpi_certify(reduction, part.mu, bad ? spoilt : r, part.f, NULL, &seen, &error);
  expect_same(status, &error, DLS_E_NOT_FINITE, "r", "certify r");
  status = dls_mpi_certify(reduction, bad ? NULL : part.mu, r, part.f, NULL, &seen, &error);
  expect_same(status, &error, DLS_E_ARGUMENT, "mu", "certify mu");
  status = dls_mpi_certify(reduction, part.mu, r, part.f, NULL, bad ? NULL : &seen, &error);
  expect_same(status, &error, DLS_E_ARGUMENT, "certificate", "certify certificate");
  EXPECT(seen.residual == 7, "an error changed the certificate");
  dls_mpi_settings settings;
  dls_mpi_settings_init(&settings);
  settings.gather = bad ? -1 : 0;
  status = dls_mpi_solve(reduction, part.mu, &settings, r, NULL, &info, &error);
  EXPECT(status < 0, "gather -1: %d", status);
  dls_mpi_settings_init(&settings);
  if (bad) settings.size = 0;
  status = dls_mpi_solve(reduction, part.mu, &settings, r, NULL, &info, &error);
  expect_same(status, &error, DLS_E_SETTINGS, "settings", "settings");
  int calls = 0;
  dls_mpi_settings_init(&settings);
  settings.gather = 0;
  settings.limits.tol = 1e-14;
  settings.limits.progress = rank == 0 ? stop_at_once : NULL;
  settings.limits.progress_data = &calls;
  status = dls_mpi_solve(reduction, part.mu, &settings, r, NULL, &info, &error);
  EXPECT(status == DLS_CANCELLED && info.iterations == 2, "cancel: %d, %d", status,
         info.iterations);
  EXPECT(calls == (rank == 0 ? 3 : 0), "%d calls", calls);
  settings.limits.progress = NULL;
  settings.limits.cpu_seconds = rank == 0 ? 1e-9 : 0;
  status = dls_mpi_solve(reduction, part.mu, &settings, r, NULL, &info, &error);
  EXPECT(status == DLS_TIME_LIMIT && info.status == status, "time: %d", status);
  settings.limits.cpu_seconds = 0;
  settings.limits.max_iterations = 3;
  status = dls_mpi_solve(reduction, part.mu, &settings, r, NULL, &info, &error);
  EXPECT(status == DLS_MAX_ITERATIONS && info.iterations == 3, "iterations: %d", status);
  dls_mpi_reduction_destroy(reduction);
  share_free(&part);
  free(spoilt);
  free(r);
  scene_free(&s);
}

/* A singular K, one that is indefinite, a limit of memory. */
static void test_bad_matrices(void) {
  scene s = scene_create(3, 3, 0);
  share part = share_take(&s.b.model, CUT_EVEN, s.f, s.g, s.mu);
  dls_mpi_reduction *out = NULL;
  dls_error error = {0};
  double *x = malloc((part.model.entries + 1) * sizeof *x);
  if (!x) MPI_Abort(MPI_COMM_WORLD, 1);
  for (int k = 0; k < 3; k++) {
    /* an unknown without stiffness; one of negative stiffness inside, or among those that touch */
    const int at = k == 2 ? s.b.hn[0] : s.n - 1;
    for (size_t e = 0; e < part.model.entries; e++) {
      x[e] = s.b.x[s.b.p[part.first_row] + (int)e];
      if (part.row[e] == at && part.col[e] == at) x[e] = k == 0 ? 0 : -x[e];
      if (k == 0 && (part.row[e] == at || part.col[e] == at)) x[e] = 0;
    }
    part.model.x = x;
    const dls_status status =
        dls_mpi_reduction_create(&out, MPI_COMM_WORLD, &part.model, NULL, &error);
    EXPECT(k == 0 ? status == DLS_E_SINGULAR || status == DLS_E_NOT_POSITIVE_DEFINITE
                  : status == DLS_E_NOT_POSITIVE_DEFINITE,
           "matrix %d: %d %s", k, status, error.message);
    EXPECT(!strcmp(error.argument, "Ks"), "matrix %d: argument '%s'", k, error.argument);
    EXPECT(!out, "matrix %d: out", k);
    if (out) dls_mpi_reduction_destroy(out);
  }
  dls_reduction_settings settings;
  dls_reduction_settings_init(&settings);
  settings.memory_limit = 10;
  part.model.x = s.b.x + s.b.p[part.first_row];
  dls_status status =
      dls_mpi_reduction_create(&out, MPI_COMM_WORLD, &part.model, &settings, &error);
  EXPECT(status == DLS_E_MEMORY, "limit: %d", status);
  dls_reduction_settings_init(&settings);
  settings.form_W = rank != ranks - 1;
  status = dls_mpi_reduction_create(&out, MPI_COMM_WORLD, &part.model, &settings, &error);
  expect_same(status, &error, DLS_E_UNSUPPORTED, "form_W", "form_W");
  free(x);
  share_free(&part);
  scene_free(&s);
}

/* Every malloc of our own on the last rank fails in turn; nobody waits. */
static void test_no_memory(void) {
  scene s = scene_create(3, 3, 0);
  share part = share_take(&s.b.model, CUT_EVEN, s.f, s.g, s.mu);
  double *r = calloc((size_t)s.m + (size_t)s.n + 1, sizeof *r);
  dls_mpi_settings settings;
  dls_mpi_settings_init(&settings);
  int done = 0, k = 0;
  while (!done && k++ < 200) {
    dls_mpi_reduction *reduction = NULL;
    dls_error error = {0};
    settings.gather = k % 2 ? 0 : 1000;
    malloc_fails_at(rank == ranks - 1 ? k : 0);
    dls_status status =
        dls_mpi_reduction_create(&reduction, MPI_COMM_WORLD, &part.model, NULL, &error);
    if (!status) status = dls_mpi_reduction_load(reduction, part.f, part.g, &error);
    if (!status) status = dls_mpi_solve(reduction, part.mu, &settings, r, NULL, NULL, &error);
    if (!status) status = dls_mpi_reduction_recover(reduction, r, r + s.m, &error);
    const int mine = rank != ranks - 1 || malloc_calls() < k;
    malloc_fails_at(0);
    dls_mpi_reduction_destroy(reduction);
    (void)MPI_Allreduce(&mine, &done, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    EXPECT(status == (done ? DLS_OK : DLS_E_MEMORY), "malloc %d: %d %s", k, status, error.message);
  }
  EXPECT(done && k > 20, "%d mallocs", k);
  share_free(&part);
  free(r);
  scene_free(&s);
}

int main(int argc, char **argv) {
  (void)MPI_Init(&argc, &argv);
  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  (void)MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  test_answers();
  test_soft();
  test_operator();
  test_repeat();
  test_turns();
  test_bad_input();
  test_bad_calls();
  test_bad_matrices();
  test_no_memory();
  const int failures = expect_end("test_mpi");
  (void)MPI_Finalize();
  return failures ? EXIT_FAILURE : EXIT_SUCCESS;
}
