/*
 * global.c: the public functions of the contact problem on K: a copy of the model in round
 * variables, new values, a solve, the motion of a proof.
 *
 * The copy of K has its repeated entries added up and no zeros; of a symmetric K only the lower
 * triangle. The solvers work on K without redundant joints (linear/redundant.c), the certificate on
 * all of K. Memory: this copy, H twice, the system (system.c), 20 vectors. Fails: no memory.
 */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "global_internal.h"
#include "linear/blas.h"

enum { most_iterations = 5000, window = 10, most_landings = 3 };

static const double tidy = 1e-8; /* of the largest reaction: a distance from the cones */

/* ---- the model ------------------------------------------------------------------------------- */

/* The matrices made from a model. */
typedef struct matrices {
  dlsi_columns K, H;
  dlsi_operator operator;
  dlsi_apart apart;
  double *w, *root, *scratch;
  int *part; /* 3 n: parts, joints, pieces */
  int parts, pieces, joints;
} matrices;

static void matrices_free(matrices *of) {
  dlsi_columns_free(&of->K);
  dlsi_columns_free(&of->H);
  dlsi_operator_free(&of->operator);
  dlsi_apart_free(&of->apart);
  free(of->w);
  free(of->root);
  free(of->scratch);
  free(of->part);
}

static dls_model matrices_view(const matrices *of, dls_factorization factorization) {
  return (dls_model){.n = of->K.cols,
                     .operator_kind = DLS_STIFFNESS_SPARSE,
                     .factorization = factorization,
                     .Ks = dlsi_columns_view(&of->K)};
}

/* Scales H to round variables by the weights. */
static void matrices_make_round(matrices *to, int d) {
  for (int k = 0; k < to->H.cols; k++) {
    to->root[k] = sqrt(to->w[2 * (k / d) + (k % d > 0)]);
    for (int e = to->H.p[k]; e < to->H.p[k + 1]; e++)
      to->H.x[e] /= to->root[k];
  }
}

/* Returns the body without its model, which is a view of K. */
static dlsi_body matrices_body(const matrices *of, int d) {
  const int n = of->K.cols;
  return (dlsi_body){.n = n,
                     .Ht = dlsi_columns_view(&of->operator.Ht),
                     .d = d,
                     .nc = of->operator.candidates,
                     .w = of->w,
                     .share = of->w + 2 * (size_t)of->operator.candidates,
                     .part = of->part,
                     .joint = of->joints ? of->part + n : NULL,
                     .piece = of->joints ? of->part + 2 * (size_t)n : NULL,
                     .parts = of->parts,
                     .pieces = of->pieces};
}

/* Finds connected bodies and joints, and separates the redundant joints. */
static dls_status matrices_find_joints(matrices *to, const dls_model *K, dls_error *error) {
  int *joint = to->part + K->n, *piece = joint + K->n;
  const dls_sparse Ht = dlsi_columns_view(&to->operator.Ht);
  to->parts = dlsi_body_parts(K, to->part);
  to->joints = dlsi_body_joints(K, &Ht, joint);
  if (to->joints) to->pieces = dlsi_body_pieces(K, joint, piece);
  return dlsi_apart_create(&to->apart, K, &Ht, error);
}

/* Makes H by columns, the weights, and then H round. */
static dls_status matrices_make_H(matrices *to, const dls_model *model, dls_error *error) {
  const int d = model->d;
  const size_t nc = (size_t)to->operator.candidates, m = (size_t)d * nc;
  dls_status status = dlsi_operator_columns(&to->operator, d, DLSI_ALL, &to->H, error);
  to->w = dlsi_alloc(2 * nc + (size_t)model->n, sizeof *to->w);
  to->root = dlsi_alloc(m, sizeof *to->root);
  to->part = dlsi_alloc(3 * (size_t)model->n, sizeof *to->part);
  if (!status && (!to->w || !to->root || !to->part)) status = dlsi_no_memory(error);
  if (status) return status;
  const dls_model K = matrices_view(to, model->factorization);
  const dls_sparse H = dlsi_columns_view(&to->H);
  status = matrices_find_joints(to, &K, error);
  if (!status) {
    const dlsi_body body = matrices_body(to, d);
    to->scratch = dlsi_alloc(dlsi_body_scratch(&body), sizeof *to->scratch);
    status = to->scratch ? dlsi_body_weights(&K, &H, d, to->w, error) : dlsi_no_memory(error);
    if (!status) dlsi_body_shares(&K, to->w + 2 * nc);
  }
  if (!status) matrices_make_round(to, d);
  return status;
}

/* The caller calls matrices_free, also after an error. */
static dls_status matrices_create(matrices *to, const dls_model *model, dls_error *error) {
  *to = (matrices){.parts = 0};
  dls_status status = dlsi_check_model(model, error);
  if (status) return status;
  if (model->operator_kind != DLS_STIFFNESS_DENSE && model->operator_kind != DLS_STIFFNESS_SPARSE)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "operator_kind", -1, model->operator_kind,
                     "is not a stiffness, dense or sparse");
  status = dlsi_stiffness_columns(model, &to->K, error);
  if (!status) status = dlsi_operator_create(&to->operator, model, 0, error);
  return status ? status : matrices_make_H(to, model, error);
}

/* Returns K without redundant joints. */
static dls_sparse matrices_reduced(const matrices *of) {
  return of->apart.K.p ? dlsi_columns_view(&of->apart.K) : dlsi_columns_view(&of->K);
}

/* Takes over the matrices; *from receives the old ones. */
static void global_take(dls_global *work, matrices *from) {
  const matrices old = {.K = work->K,
                        .H = work->H,
                        .operator= work->operator,
                        .apart = work->apart,
                        .w = work->w,
                        .root = work->root,
                        .scratch = work->scratch,
                        .part = work->part};
  work->K = from->K;
  work->H = from->H;
  work->operator= from->operator;
  work->apart = from->apart;
  work->w = from->w;
  work->root = from->root;
  work->scratch = from->scratch;
  work->part = from->part;
  const dlsi_body before = work->body;
  work->whole = matrices_view(from, work->whole.factorization);
  work->model = work->whole;
  work->model.Ks = matrices_reduced(from);
  work->body = matrices_body(from, work->d);
  work->body.model = before.multiply ? NULL : &work->whole;
  work->body.multiply = before.multiply;
  work->body.data = before.data;
  if (before.multiply) work->body.share = NULL;
  work->body.ranks = work->history.ranks = before.ranks;
  work->body.nc = work->nc;
  *from = old;
}

/* ---- create, update, destroy ----------------------------------------------------------------- */

static void global_carve(dls_global *work, dlsi_arena *arena) {
  const size_t n = (size_t)work->n, m = (size_t)work->m, nc = (size_t)work->nc;
  double **const of_m[] = {&work->gap,  &work->g, &work->q,      &work->r,      &work->z,
                           &work->p,    &work->u, &work->before, &work->best_r, &work->trial,
                           &work->look, &work->R, &work->blur};
  double **const of_n[] = {&work->motion, &work->x,      &work->y,     &work->f,
                           &work->own,    &work->flight, &work->best_x};
  for (size_t k = 0; k < sizeof of_m / sizeof of_m[0]; k++)
    *of_m[k] = dlsi_take(arena, m, sizeof(double));
  for (size_t k = 0; k < sizeof of_n / sizeof of_n[0]; k++)
    *of_n[k] = dlsi_take(arena, n, sizeof(double));
  work->balanced = dlsi_take(arena, 2 * n, sizeof *work->balanced);
  dlsi_anderson_carve(&work->history, arena, m, window, 0);
  work->mu = dlsi_take(arena, nc, sizeof *work->mu);
  work->bend = dlsi_take(arena, nc, sizeof *work->bend);
  work->state = dlsi_take(arena, nc, sizeof *work->state);
}

/* Makes H, and copies weights and connected bodies; K is elsewhere. */
static dls_status matrices_create_on(matrices *to, const dls_model *model, const dlsi_body *body,
                                     dls_error *error) {
  const size_t n = (size_t)model->n;
  *to = (matrices){.parts = body->parts};
  dls_status status = dlsi_columns_alloc(model->n, model->n, 0, &to->K, error);
  if (!status) status = dlsi_operator_create(&to->operator, model, 0, error);
  if (!status) status = dlsi_operator_columns(&to->operator, model->d, DLSI_ALL, &to->H, error);
  const size_t nc = (size_t)to->operator.candidates;
  to->w = dlsi_alloc(2 * nc, sizeof *to->w);
  to->root = dlsi_alloc((size_t)model->d * nc, sizeof *to->root);
  to->part = dlsi_alloc(n, sizeof *to->part);
  if (!status && (!to->w || !to->root || !to->part)) status = dlsi_no_memory(error);
  if (status) return status;
  memset(to->K.p, 0, (n + 1) * sizeof *to->K.p);
  memcpy(to->w, body->w, 2 * nc * sizeof *to->w);
  memcpy(to->part, body->part, n * sizeof *to->part);
  dlsi_body of = matrices_body(to, model->d);
  of.ranks = body->ranks;
  to->scratch = dlsi_alloc(dlsi_body_scratch(&of), sizeof *to->scratch);
  if (!to->scratch) return dlsi_no_memory(error);
  matrices_make_round(to, model->d);
  return DLS_OK;
}

/* body: NULL, or K is elsewhere; solver: NULL, or replaces the factor. */
static dls_status global_create(dls_global **out, const dls_model *model, const dlsi_body *body,
                                const dls_global_solver *solver, dls_error *error) {
  matrices of;
  if (!out) return dlsi_is_null(error, "out");
  *out = NULL;
  dls_status status = dlsi_check_blas(error);
  if (status) return status;
  status = body ? matrices_create_on(&of, model, body, error) : matrices_create(&of, model, error);
  dls_global *work = status ? NULL : calloc(1, sizeof *work);
  if (!status && !work) status = dlsi_no_memory(error);
  if (status) {
    matrices_free(&of);
    return status;
  }
  work->d = model->d;
  work->n = model->n;
  work->nodes = body ? body->nc : model->nodes;
  work->nc = body ? body->nc : of.operator.candidates;
  work->m = work->d * work->nc;
  work->whole.factorization = model->factorization;
  if (solver) work->solver = *solver;
  if (body) work->body = *body;
  global_take(work, &of);
  dlsi_arena arena = {0};
  global_carve(work, &arena);
  status = dlsi_arena_allocate(&arena, "model", model->n, error);
  if (!status) {
    work->memory = arena.base;
    work->bytes = arena.size;
    global_carve(work, &arena);
  }
  if (!status && !solver) {
    const dls_sparse H = dlsi_columns_view(&work->H);
    status = dlsi_system_create(&work->system, &work->model, &H, work->d, work->body.joint, error);
  }
  if (status)
    dls_global_destroy(work);
  else
    *out = work;
  return status;
}

dls_status dls_global_create(dls_global **out, const dls_model *model, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, global_create(out, model, NULL, NULL, error), error);
}

dls_status dls_global_create_with(dls_global **out, const dls_model *model,
                                  const dls_global_solver *solver, dls_error *error) {
  DLSI_DOOR;
  if (out) *out = NULL;
  dls_status status = solver ? DLS_OK : dlsi_is_null(error, "solver");
  if (!status && !solver->prepare) status = dlsi_is_null(error, "solver.prepare");
  if (!status && !solver->solve) status = dlsi_is_null(error, "solver.solve");
  if (!status && !solver->block && solver->apply) status = dlsi_is_null(error, "solver.block");
  if (!status && solver->block && !solver->apply) status = dlsi_is_null(error, "solver.apply");
  if (!status) status = global_create(out, model, NULL, solver, error);
  return dlsi_at(__func__, status, error);
}

dls_status dlsi_global_create_on(dls_global **out, const dls_model *model, const dlsi_body *body,
                                 const dls_global_solver *solver, dls_error *error) {
  return global_create(out, model, body, solver, error);
}

/* Returns 1 if both have the same pattern. */
static int same_pattern(dls_sparse A, dls_sparse B) {
  if (A.rows != B.rows || A.cols != B.cols) return 0;
  return memcmp(A.p, B.p, ((size_t)A.cols + 1) * sizeof *A.p) == 0 &&
         memcmp(A.i, B.i, (size_t)A.p[A.cols] * sizeof *A.i) == 0;
}

static dls_status global_update(dls_global *work, const dls_model *model, dls_error *error) {
  matrices of;
  dls_status status = matrices_create(&of, model, error);
  const struct {
    const char *name;
    int then, now;
  } sizes[] = {{"d", work->d, status ? 0 : model->d},
               {"n", work->n, status ? 0 : model->n},
               {"nodes", work->nodes, status ? 0 : model->nodes}};
  for (int k = 0; !status && k < 3; k++)
    if (sizes[k].then != sizes[k].now)
      status = dlsi_fail(error, DLS_E_SIZE, sizes[k].name, -1, sizes[k].now,
                         "is %d, was %d in create", sizes[k].now, sizes[k].then);
  if (!status && model->factorization != work->whole.factorization)
    status = dlsi_fail(error, DLS_E_ARGUMENT, "factorization", -1, model->factorization,
                       "is not what it was in create");
  if (!status && of.operator.candidates != work->nc)
    status = dlsi_fail(error, DLS_E_SIZE, "active", -1, of.operator.candidates,
                       "other contacts than those of create");
  if (!status && !(same_pattern(dlsi_columns_view(&of.K), work->whole.Ks) &&
                   same_pattern(matrices_reduced(&of), work->model.Ks)))
    status = dlsi_fail(error, DLS_E_ARGUMENT, "Ks", -1, 0, "has entries at other places");
  if (!status && !same_pattern(dlsi_columns_view(&of.H), dlsi_columns_view(&work->H)))
    status = dlsi_fail(error, DLS_E_ARGUMENT, "HN", -1, 0,
                       "HN, HT, P touch other unknowns than those of create");
  if (!status) {
    global_take(work, &of);
    const dls_sparse H = dlsi_columns_view(&work->H);
    if (work->system) dlsi_system_update(work->system, &work->model, &H, work->body.joint);
    work->moves = 0;
  }
  matrices_free(&of);
  return status;
}

dls_status dls_global_update(dls_global *global, const dls_model *model, dls_error *error) {
  DLSI_DOOR;
  dls_status status =
      global ? dlsi_enter(&global->busy, "global", error) : dlsi_is_null(error, "global");
  if (!status) status = dlsi_leave(&global->busy, global_update(global, model, error));
  return dlsi_at(__func__, status, error);
}

void dls_global_destroy(dls_global *global) {
  if (!global) return;
  matrices none = {.parts = 0};
  global_take(global, &none);
  matrices_free(&none);
  dlsi_system_destroy(global->system);
  free(global->memory);
  free(global);
}

int dls_global_contacts(const dls_global *global) {
  return global ? global->nc : 0;
}

const double *dls_global_motion(const dls_global *global, int *body) {
  if (!global || !global->moves) return NULL;
  if (body) *body = global->mover;
  return global->motion;
}

/* ---- solve ----------------------------------------------------------------------------------- */

static dls_status solve_check(const dls_global *work, const double *f, const double *g,
                              const double *mu, const double *r, const double *x,
                              dls_error *error) {
  const size_t n = (size_t)work->n, m = (size_t)work->m;
  dls_status status = dlsi_check_limits(work->limits, error);
  if (!status && f) status = dlsi_check_vector("f", f, n, error);
  if (!status && g)
    status = dlsi_check_vector("g", g, (size_t)work->d * (size_t)work->nodes, error);
  if (!status && mu) status = dlsi_check_friction(mu, (size_t)work->nc, error);
  for (int c = 0; !status && mu && c < work->nc; c++)
    if (mu[c] > 0 && !dlsi_has_tangents(&work->operator, c))
      status = dlsi_fail(error, DLS_E_ARGUMENT, "mu", c, mu[c],
                         "is %g, but model.mu was 0 there: the tangents were left out", mu[c]);
  if (!status && !r && m > 0) status = dlsi_is_null(error, "r");
  if (!status && !x) status = dlsi_is_null(error, "x");
  if (status) return status;
  const uintptr_t a = (uintptr_t)r, b = (uintptr_t)x;
  if (m > 0 && a < b + n * sizeof *x && b < a + m * sizeof *r)
    return dlsi_fail(error, DLS_E_ARGUMENT, "x", -1, 0, "overlaps r");
  if (!work->limits->warm_start) return DLS_OK;
  status = dlsi_check_vector("r", r, m, error);
  return status ? status : dlsi_check_vector("x", x, n, error);
}

/* Takes loads, gaps, friction and the start; converts them to round variables. */
static void solve_begin(dls_global *work, const double *f, const double *g, const double *mu,
                        const double *r, const double *x) {
  const size_t d = (size_t)work->d, m = (size_t)work->m;
  const dlsi_columns *P = &work->operator.P;
  work->given = work->load = f;
  for (int k = 0; k < work->n; k++)
    work->f[k] = f ? f[k] : 0;
  for (int k = 0; k < work->apart.count; k++)
    work->f[work->apart.redundant[k]] = 0;
  memset(work->gap, 0, m * sizeof *work->gap);
  for (int c = 0; c < work->nc; c++) {
    for (int k = P->p[c]; g && k < P->p[c + 1]; k++)
      for (size_t i = 0; i < (dlsi_has_tangents(&work->operator, c) ? d : 1); i++)
        work->gap[d * (size_t)c + i] += P->x[k] * g[d * (size_t)P->i[k] + i];
    work->mu[c] = mu ? mu[c] : work->operator.mu ? work->operator.mu[c] : 0;
    work->bend[c] = work->mu[c] * sqrt(work->w[2 * c + 1] / work->w[2 * c]);
  }
  const int warm = work->limits->warm_start;
  for (size_t k = 0; k < m; k++) {
    work->g[k] = work->gap[k] / work->root[k];
    work->r[k] = warm ? r[k] * work->root[k] : 0;
  }
  for (int k = 0; k < work->n; k++)
    work->x[k] = warm ? x[k] : 0;
  work->from_r = warm && work->system && dlsi_max_abs(work->r, m) > 0 &&
                 dlsi_max_abs(work->x, (size_t)work->n) == 0;
  memset(work->own, 0, (size_t)work->n * sizeof *work->own);
  memset(work->flight, 0, (size_t)work->n * sizeof *work->flight);
  work->is_split = 0;
  work->body.balanced = work->body.blur = NULL;
  work->iterations = work->factorisations = work->scattered = work->moves = 0;
  work->best = (dls_certificate){.residual = INFINITY, .body = -1};
}

/* Returns 1 if a solve ended without an answer, a proof or a limit of the caller. */
static int solve_failed(dls_status status) {
  return status == DLS_STALLED || status == DLS_NOT_IN_EQUILIBRIUM || status == DLS_MAX_ITERATIONS;
}

/* Solves, and goes on where an answer holds only by a flight (LO3), unless a motion proves that
 * there is none. */
static dls_status solve_and_land(dls_global *work, int most, dls_error *error) {
  dls_status status = DLS_OK;
  for (int turn = 0; turn < most_landings; turn++) {
    int proved = 0;
    dls_status found = DLS_STALLED;
    if (work->from_r) {
      memcpy(work->before, work->r, (size_t)work->m * sizeof *work->r);
      found = dlsi_global_newton(work, work->before, 0, 0, error);
      work->from_r = 0;
    }
    if (found == DLS_STALLED) found = dlsi_global_split(work, most, error);
    status = dlsi_global_land(work, found, error);
    if (status != DLS_NOT_IN_EQUILIBRIUM || !work->is_split) break;
    const dls_status tried = turn == 0 ? dlsi_global_prove(work, &proved, error) : DLS_OK;
    if (tried || proved) return tried ? tried : DLS_NO_SOLUTION;
  }
  return status;
}

/* Solves, and solves again without the loads that bodies balance in themselves if these are in the
 * way (loads.c). */
static dls_status solve_split(dls_global *work, dls_error *error) {
  const size_t n = (size_t)work->n, m = (size_t)work->m;
  const int most = dlsi_most_iterations(work->limits, most_iterations);
  dls_status status = solve_and_land(work, most, error);
  const dls_certificate first = work->best;
  const int spent = work->limits->max_iterations && work->iterations >= most;
  if (status != dlsi_split_first &&
      !(solve_failed(status) && dlsi_global_can_split(work) && !spent))
    return solve_failed(status) && !spent ? dlsi_global_scatter(work, status, error) : status;
  double *kept = dlsi_alloc(n + m, sizeof *kept);
  dls_status then = kept ? DLS_OK : dlsi_no_memory(error);
  if (!then) {
    memcpy(kept, work->best_x, n * sizeof *kept);
    memcpy(kept + n, work->best_r, m * sizeof *kept);
    then = dlsi_global_split_off(work, error);
  }
  if (!then) {
    memset(work->x, 0, n * sizeof *work->x);
    memset(work->r, 0, m * sizeof *work->r);
    work->best = (dls_certificate){.residual = INFINITY, .body = -1};
    then =
        solve_and_land(work, work->limits->max_iterations ? most : work->iterations + most, error);
  }
  if (solve_failed(then) && !(work->limits->max_iterations && work->iterations >= most))
    then = dlsi_global_scatter(work, then, error);
  if (solve_failed(then)) { /* the first try has the better report */
    work->best = first;
    memcpy(work->best_x, kept, n * sizeof *kept);
    memcpy(work->best_r, kept + n, m * sizeof *kept);
    memset(work->own, 0, n * sizeof *work->own);
    memset(work->flight, 0, n * sizeof *work->flight);
    work->is_split = 0;
    then = dlsi_global_verdict(work, solve_failed(status) ? status : then);
  }
  free(kept);
  return then;
}

/* Puts the r of an answer into its cones, and x after it, each unknown by itself. A reaction on an
 * unknown that a penalty holds is rounding beside it: Newton leaves it there with either sign. */
static void solve_tidy(dls_global *work) {
  const size_t m = (size_t)work->m;
  double most = 0, moved = 0;
  if (!work->system) return;
  for (size_t k = 0; k < m; k++) {
    work->r[k] = work->best_r[k] * work->root[k];
    most = fmax(most, fabs(work->best_r[k]));
  }
  dlsi_put_on_discs(work->d, work->nc, work->bend, work->r, work->before);
  for (size_t k = 0; k < m; k++) {
    work->look[k] = work->before[k] - work->r[k];
    moved = fmax(moved, fabs(work->look[k] / work->root[k]));
  }
  if (!(moved > tidy * most)) return;
  dls_certificate now;
  memcpy(work->x, work->best_x, (size_t)work->n * sizeof *work->x);
  memset(work->y, 0, (size_t)work->n * sizeof *work->y);
  dlsi_global_push(work, work->look, work->y);
  for (int j = 0; j < work->n; j++) {
    const double stiffness = dlsi_body_diagonal(&work->model, j);
    work->x[j] += stiffness > 0 ? work->y[j] / stiffness : 0;
  }
  (void)dlsi_global_measure(work, work->before, &now);
}

static dls_status global_solve(dls_global *work, const double *f, const double *g, const double *mu,
                               const dls_limits *limits, double *r, double *x, dls_info *info,
                               dls_error *error) {
  dls_limits usual;
  dlsi_limits_init(&usual);
  work->limits = limits ? limits : &usual;
  dls_status status = solve_check(work, f, g, mu, r, x, error);
  if (status) return status;
  work->begun = dlsi_clock_start(work->limits);
  solve_begin(work, f, g, mu, r, x);
  status = solve_split(work, error);
  if (status < 0) return status;
  double predicted = 0;
  if (dls_solved(status) && info && !work->unread) {
    const dls_status failed = dlsi_global_accuracy(work, &predicted, error);
    if (failed) return failed;
    status = dlsi_certificate_verdict(&work->best, work->limits->tol);
  }
  if (dls_solved(status)) solve_tidy(work);
  if (work->m > 0) memcpy(r, work->best_r, (size_t)work->m * sizeof *r);
  for (int j = 0; j < work->n; j++)
    x[j] = work->best_x[j] + work->own[j] + work->flight[j];
  if (info)
    *info = (dls_info){.status = status,
                       .method = DLS_ADMM,
                       .iterations = work->iterations,
                       .factorisations = work->factorisations,
                       .certificate = work->best,
                       .error = predicted};
  dlsi_tell_last(work->limits, work->begun, "global", "global", work->iterations,
                 work->best.residual, r);
  return status;
}

dls_status dlsi_global_prove_for(dls_global *work, const double *f, const double *mu, int *proved,
                                 dls_error *error) {
  dls_limits usual;
  dlsi_limits_init(&usual);
  work->limits = &usual;
  work->begun = dlsi_clock_start(&usual);
  solve_begin(work, f, NULL, mu, NULL, NULL);
  return dlsi_global_prove(work, proved, error);
}

dls_status dls_global_solve(dls_global *global, const double *f, const double *g, const double *mu,
                            const dls_limits *limits, double *r, double *x, dls_info *info,
                            dls_error *error) {
  DLSI_DOOR;
  dls_status status =
      global ? dlsi_enter(&global->busy, "global", error) : dlsi_is_null(error, "global");
  if (!status)
    status = dlsi_leave(&global->busy, global_solve(global, f, g, mu, limits, r, x, info, error));
  return dlsi_at(__func__, status, error);
}
