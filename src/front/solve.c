/*
 * solve.c: the front door. Chooses the method, and has the last word: whatever a method says of
 * itself, "solved" is what the certificate of the returned r says.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "auto/auto.h"
#include "delassus/facets.h"
#include "facts/facts.h"
#include "facts/least.h"
#include "front/front.h"

struct dls_solver {
  dls_solver_settings settings;
  int d, nc;
  atomic_int busy;   /* 1: a call is at work */
  dls_status status; /* of the last solve */
  const dlsi_method *method;
  void *work;         /* of the method */
  dlsi_formed formed; /* W of bodies by blocks, for methods that want them */
  dlsi_units units;   /* a copy of the problem, if it needs one */
  double *room;       /* of the prediction of the error; NULL: none is made, or auto makes it */
  double *last;       /* m: r of the last solve, of last_nc contacts; NULL: no next one is mapped */
  int last_nc, mapped;
  const int *map;    /* of mapped contacts, from; NULL: there is none */
  int *from, *mark;  /* nc; scratch, all 0 */
  dlsi_least *least; /* NULL: not asked for */
};

int dls_acceleration_find(const char *name, dls_acceleration *acceleration) {
  static const char *const names[] = {[DLS_ACCELERATION_NONE] = "none",
                                      [DLS_ACCELERATION_AITKEN] = "aitken",
                                      [DLS_ACCELERATION_ANDERSON] = "anderson",
                                      [DLS_ACCELERATION_MOMENTUM] = "momentum"};
  for (int k = 0; name && acceleration && k < (int)(sizeof names / sizeof names[0]); k++)
    if (strcmp(names[k], name) == 0) {
      *acceleration = (dls_acceleration)k;
      return 1;
    }
  return 0;
}

void dls_solver_settings_init(dls_solver_settings *settings) {
  if (!settings) return;
  *settings = (dls_solver_settings){.size = sizeof *settings};
  dlsi_limits_init(&settings->limits);
}

dls_status dlsi_solver_check(const dls_solver_settings *s, dls_error *error) {
  const dlsi_setting own[] = {{"positive_definite", s->positive_definite, 0, 1, 0},
                              {"acceleration", s->acceleration, 0, DLS_ACCELERATION_MOMENTUM, 0},
                              {"forces", s->forces, 0, DLS_FORCES_LEAST, 0}};
  const dls_status status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 3, own, error);
  if (status) return status;
  if (!dlsi_method_of(s->method))
    return dlsi_fail(error, DLS_E_ARGUMENT, "method", -1, s->method, "%d is no method",
                     (int)s->method);
  if (s->facets && (s->facets < 4 || s->facets > DLS_FACETS_MAX || s->facets % 2))
    return dlsi_fail(error, DLS_E_ARGUMENT, "facets", -1, s->facets,
                     "is %d, must be even, 4 to %d, or 0", s->facets, DLS_FACETS_MAX);
  if (s->acceleration && s->method != DLS_NLGS)
    return dlsi_fail(error, DLS_E_ARGUMENT, "acceleration", -1, s->acceleration, "is for nlgs");
  if ((s->plan || s->without) && s->method != DLS_AUTO)
    return dlsi_fail(error, DLS_E_ARGUMENT, s->plan ? "plan" : "without", -1, s->method,
                     "is for auto");
  dlsi_auto_given given;
  return dlsi_auto_read_words(s->plan, s->without, &given, error);
}

/* Creates the workspace of solver->method, for one candidate at least: without any none is needed.
 * lazy: see dlsi_options. */
static dls_status solver_create_work(dls_solver *solver, int lazy, dls_error *error) {
  const dls_solver_settings *s = &solver->settings;
  const dlsi_options options = {.limits = s->limits,
                                .acceleration = (int)s->acceleration,
                                .facets = s->facets,
                                .positive_definite = s->positive_definite,
                                .plan = s->plan,
                                .without = s->without,
                                .lazy = lazy};
  solver->method = dlsi_method_of(s->method);
  const int nc = solver->nc > 0 ? solver->nc : 1;
  return solver->method->create(&solver->work, solver->d, nc, &options, error);
}

/* Makes room for the least reactions, and for the prediction of the error of small problems: m^2 +
 * m + 2 nc doubles. */
static dls_status solver_make_room(dls_solver *solver, dls_error *error) {
  const dls_solver_settings *s = &solver->settings;
  const size_t nc = (size_t)solver->nc, m = (size_t)solver->d * nc;
  if (s->forces == DLS_FORCES_LEAST && m > 0) {
    const dls_status status =
        dlsi_least_create(&solver->least, solver->d, solver->nc, s->limits.blocks, error);
    if (status) return status;
  }
  const size_t most = s->limits.blocks ? dlsi_predicted_of_blocks : dlsi_predicted_rows;
  if (s->method == DLS_AUTO || m == 0 || m > most) return DLS_OK;
  solver->room = dlsi_alloc(m * m + m + 2 * nc, sizeof *solver->room);
  return solver->room ? DLS_OK : dlsi_no_memory(error);
}

/* Makes room for what the next solve takes from the last one. */
static dls_status solver_make_memory(dls_solver *solver, dls_error *error) {
  const size_t nc = (size_t)solver->nc;
  solver->last = dlsi_alloc((size_t)solver->d * nc, sizeof *solver->last);
  solver->from = dlsi_alloc(2 * nc, sizeof *solver->from);
  if (!solver->last || !solver->from) return dlsi_no_memory(error);
  solver->mark = solver->from + nc;
  memset(solver->mark, 0, nc * sizeof *solver->mark);
  return DLS_OK;
}

/* Sets info->error of a solved problem whose W may hide an error. */
static void solver_predict(const dls_solver *solver, const dls_contact *problem, const double *r,
                           dls_info *info) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  if (!solver->room || dlsi_is_factored(problem)) return;
  if (!problem->W.a && m > dlsi_predicted_of_blocks) return;
  double *J = solver->room, *x = J + m * m, *w = x + m;
  dlsi_certificate_weights(problem, w);
  if (!dlsi_may_hide_error(problem, w, info)) return;
  const double predicted = dlsi_predict_error(problem, r, w, J, x);
  info->error = predicted < 0 ? INFINITY : predicted; /* W does not determine r */
}

dls_status dlsi_solver_create(dls_solver **out, int d, int nc, int lazy,
                              const dls_solver_settings *settings, dls_error *error) {
  dls_solver_settings defaults;
  dls_solver_settings_init(&defaults);
  if (!settings) settings = &defaults;
  dls_status status = dlsi_solver_check(settings, error);
  if (!status) status = dlsi_check_sizes(d, nc, error);
  if (status) return status;
  dls_solver *solver = dlsi_alloc(1, sizeof *solver);
  if (!solver) return dlsi_no_memory(error);
  *solver = (dls_solver){.settings = *settings, .d = d, .nc = nc};
  status = solver_create_work(solver, lazy, error);
  solver->settings.plan = settings->plan ? "" : NULL; /* the words are the workspace's now */
  solver->settings.without = NULL;
  if (status) {
    free(solver);
    return status;
  }
  status = solver_make_room(solver, error);
  if (!status) status = solver_make_memory(solver, error);
  if (status)
    dls_solver_destroy(solver);
  else
    *out = solver;
  return status;
}

dls_status dls_solver_create(dls_solver **out, int d, int nc, const dls_solver_settings *settings,
                             dls_error *error) {
  DLSI_DOOR;
  if (!out) return dlsi_at(__func__, dlsi_is_null(error, "out"), error);
  *out = NULL;
  return dlsi_at(__func__, dlsi_solver_create(out, d, nc, 0, settings, error), error);
}

dls_status dls_solver_set_limits(dls_solver *solver, const dls_limits *limits, dls_error *error) {
  DLSI_DOOR;
  dls_status status = !solver   ? dlsi_is_null(error, "solver")
                      : !limits ? dlsi_is_null(error, "limits")
                                : dlsi_check_limits(limits, error);
  if (!status) status = dlsi_enter(&solver->busy, "solver", error);
  if (status) return dlsi_at(__func__, status, error);
  const int blocks = solver->settings.limits.blocks;
  solver->settings.limits = *limits;
  solver->settings.limits.blocks = blocks;
  dlsi_set_limits(solver->method, solver->work, &solver->settings.limits);
  return dlsi_leave(&solver->busy, DLS_OK);
}

/* Makes the last call of the progress callback. The stage is the last one of auto. */
static void solver_tell_last(const dls_limits *limits, double begun, const dls_info *info,
                             const double *r) {
  const dls_method stage = info->stages ? info->stage[info->stages - 1].method : info->method;
  dlsi_tell_last(limits, begun, dls_method_name(info->method), dls_method_name(stage),
                 info->sweeps + info->iterations, info->certificate.residual, r);
}

/* Takes a solved r to the least one where that is asked for; info (or NULL) is told. Returns
 * `solved`, or an error. */
static dls_status solver_take_least(dls_solver *solver, const dls_contact *problem, double begun,
                                    dls_status solved, double *r, double *u, dls_info *info,
                                    dls_error *error) {
  dls_certificate certificate;
  int done = 0;
  if (info) info->forces = DLS_FORCES_ANY;
  if (!solver->least || !dls_solved(solved)) return solved;
  dls_status status = dlsi_form_blocks(&solver->formed, &problem, error);
  if (!status)
    status = dlsi_least_take(solver->least, problem, &solver->settings.limits, begun, solved, r, u,
                             &certificate, &done, error);
  if (status) return status;
  if (info && done) {
    info->certificate = certificate;
    info->forces = DLS_FORCES_LEAST;
  }
  return solved;
}

/* Hands the map over to the method, if there is one of this problem. */
static void solver_take_map(dls_solver *solver, const dls_contact *problem) {
  const int *from = solver->mapped == problem->nc ? solver->map : NULL;
  solver->map = NULL;
  if (solver->method->map) solver->method->map(solver->work, problem->nc, from);
}

/* Keeps the answer for dls_solver_map. */
static void solver_remember(dls_solver *solver, const dls_contact *problem, const double *r) {
  solver->last_nc = problem->nc;
  if (problem->nc > 0)
    memcpy(solver->last, r, (size_t)problem->d * (size_t)problem->nc * sizeof *r);
}

/* Solves a problem that has been checked. */
static dls_status solver_solve(dls_solver *solver, const dls_contact *problem, double *r, double *u,
                               dls_info *info, dls_error *error) {
  const dls_limits *limits = &solver->settings.limits;
  const double begun = dlsi_clock_start(limits);
  dls_info own;
  if (!info && limits->progress) info = &own;
  dls_status status = DLS_OK;
  if (solver->last) solver_take_map(solver, problem);
  if (!solver->method->takes_bodies) status = dlsi_form_blocks(&solver->formed, &problem, error);
  if (!status) status = solver->method->solve(solver->work, problem, r, u, info, error);
  status = solver_take_least(solver, problem, begun, status, r, u, info, error);
  solver->status = status;
  if (info && dls_solved(status)) solver_predict(solver, problem, r, info);
  if (status >= 0 && info && limits->progress) solver_tell_last(limits, begun, info, r);
  return status;
}

/* Returns 1 if the answer needs no workspace, and gives it: no candidate, or auto's cheapest ones.
 * The progress callback, which no iteration calls then, is called once: nothing is left to
 * cancel. */
static int is_answered(const dls_solver_settings *s, const dls_contact *problem, double *r,
                       double *u, dls_info *info) {
  const dls_limits *limits = &s->limits;
  const double begun = dlsi_clock_start(limits);
  dls_info own;
  if (!info && limits->progress) info = &own;
  if (dlsi_is_empty(problem, limits, s->method, dls_method_name(s->method), info)) return 1;
  if (s->method != DLS_AUTO || limits->warm_start || s->plan || s->forces) return 0;
  if (!dlsi_alone_solve(problem, limits->tol, r, u, info)) return 0;
  if (limits->progress) solver_tell_last(limits, begun, info, r);
  return 1;
}

/* Refuses an infinite friction to the methods that divide by mu or put it into a matrix. */
static dls_status solver_check_friction(const dls_solver_settings *s, const dls_contact *problem,
                                        dls_error *error) {
  if (s->method != DLS_LEMKE && s->method != DLS_HOMOTOPY) return DLS_OK;
  return dlsi_refuse_bonded(problem, error);
}

/* Solves a problem that has been checked, in units of its own if it needs them. */
static dls_status solver_run(dls_solver *solver, const dls_contact *problem, double *r, double *u,
                             dls_info *info, dls_error *error) {
  dlsi_scaled scaled;
  dls_limits *limits = &solver->settings.limits;
  const dls_limits given = *limits;
  dls_status status =
      dlsi_scaled_begin(&scaled, &solver->units, &problem, &r, &u, &info, limits, error);
  if (limits->progress != given.progress) dlsi_set_limits(solver->method, solver->work, limits);
  if (!status && !is_answered(&solver->settings, problem, r, u, info))
    status = solver_solve(solver, problem, r, u, info, error);
  if (limits->progress != given.progress) dlsi_set_limits(solver->method, solver->work, &given);
  *limits = given;
  return solver->status = dlsi_scaled_end(&scaled, status, error);
}

dls_status dls_solver_solve(dls_solver *solver, const dls_contact *problem, double *r, double *u,
                            dls_info *info, dls_error *error) {
  DLSI_DOOR;
  if (!solver) return dlsi_at(__func__, dlsi_is_null(error, "solver"), error);
  dls_status status = dlsi_check_solve(solver->d, solver->nc, problem, r, u,
                                       solver->settings.limits.warm_start, error);
  if (!status) status = solver_check_friction(&solver->settings, problem, error);
  if (!status) status = dlsi_enter(&solver->busy, "solver", error);
  if (status) return dlsi_at(__func__, status, error);
  solver->status = DLS_OK;
  status = solver_run(solver, problem, r, u, info, error);
  if (status >= 0) solver_remember(solver, problem, r);
  return dlsi_at(__func__, dlsi_leave(&solver->busy, status), error);
}

/* Checks the map of nc contacts. mark: all 0, before and after. */
static dls_status check_map(const dls_solver *solver, int nc, const int *from, dls_error *error) {
  const int had = solver->last_nc;
  int *mark = solver->mark;
  dls_status status = DLS_OK;
  if (nc < 0 || nc > solver->nc)
    return dlsi_fail(error, DLS_E_SIZE, "nc", -1, nc, "is %d, the solver has room for 0 to %d", nc,
                     solver->nc);
  for (int c = 0; c < nc && !status; c++) {
    if (from[c] < -1 || from[c] >= had)
      status = dlsi_fail(error, DLS_E_ARGUMENT, "from", c, from[c],
                         "is %d, outside of -1 to %d, the last solve had %d contacts", from[c],
                         had - 1, had);
    else if (from[c] >= 0 && mark[from[c]])
      status = dlsi_fail(error, DLS_E_ARGUMENT, "from", c, from[c], "is %d, as the other entry %d",
                         from[c], mark[from[c]] - 1);
    else if (from[c] >= 0)
      mark[from[c]] = c + 1;
  }
  memset(mark, 0, (size_t)had * sizeof *mark);
  return status;
}

dls_status dls_solver_map(dls_solver *solver, int nc, const int *from, double *r,
                          dls_error *error) {
  DLSI_DOOR;
  dls_status status =
      !solver ? dlsi_is_null(error, "solver") : dlsi_enter(&solver->busy, "solver", error);
  if (status) return dlsi_at(__func__, status, error);
  if (nc > 0 && !from) status = dlsi_is_null(error, "from");
  if (nc > 0 && from && !r) status = dlsi_is_null(error, "r");
  if (!status) status = check_map(solver, nc, from, error);
  if (status) return dlsi_at(__func__, dlsi_leave(&solver->busy, status), error);
  const size_t d = (size_t)solver->d;
  for (int c = 0; c < nc; c++) {
    double *rc = r + d * (size_t)c;
    solver->from[c] = from[c];
    if (from[c] < 0)
      memset(rc, 0, d * sizeof *rc);
    else
      memcpy(rc, solver->last + d * (size_t)from[c], d * sizeof *rc);
  }
  solver->map = solver->from;
  solver->mapped = nc;
  return dlsi_leave(&solver->busy, DLS_OK);
}

const double *dls_solver_direction(const dls_solver *solver) {
  if (!solver || !solver->method->direction) return NULL;
  const dls_status status = solver->status;
  if (status != DLS_NO_SOLUTION_LIKELY && status != DLS_RAY && status != DLS_STALLED) return NULL;
  return solver->method->direction(solver->work);
}

const double *dls_solver_farkas(const dls_solver *solver) {
  if (!solver || !solver->method->farkas) return NULL;
  if (solver->status <= 0) return NULL;
  return solver->method->farkas(solver->work);
}

void dls_solver_destroy(dls_solver *solver) {
  if (!solver) return;
  solver->method->destroy(solver->work);
  dlsi_formed_free(&solver->formed);
  dlsi_units_free(&solver->units);
  dlsi_least_destroy(solver->least);
  free(solver->room);
  free(solver->last);
  free(solver->from);
  free(solver);
}

/* Solves a problem that has been checked, in a workspace of its own. */
static dls_status solve_in_passing(const dls_contact *problem, const dls_solver_settings *settings,
                                   double *r, double *u, dls_info *info, dls_error *error) {
  dls_solver solver = {.settings = *settings};
  dls_solver_settings *s = &solver.settings;
  dls_status status = DLS_OK;
  if (is_answered(s, problem, r, u, info)) return status;
  solver.d = problem->d;
  solver.nc = problem->nc;
  if (!dlsi_method_of(s->method)->takes_bodies)
    status = dlsi_form_blocks(&solver.formed, &problem, error);
  s->limits.blocks = problem->Wb.x ? problem->Wb.p[problem->nc] : dlsi_is_factored(problem);
  if (!status) status = solver_create_work(&solver, 1, error);
  if (!status) status = solver_make_room(&solver, error);
  if (!status) status = solver_solve(&solver, problem, r, u, info, error);
  if (solver.method) solver.method->destroy(solver.work);
  dlsi_formed_free(&solver.formed);
  dlsi_least_destroy(solver.least);
  free(solver.room);
  return status;
}

static dls_status solve_once(const dls_contact *problem, const dls_solver_settings *settings,
                             double *r, double *u, dls_info *info, dls_error *error) {
  dls_solver_settings s;
  dlsi_scaled scaled;
  dlsi_units units = {.W = 0};
  dls_solver_settings_init(&s);
  if (settings) s = *settings;
  dls_status status = dlsi_check_contact(problem, error);
  if (!status) status = dlsi_solver_check(&s, error);
  if (!status) status = dlsi_check_start(problem, r, u, s.limits.warm_start, error);
  if (!status) status = solver_check_friction(&s, problem, error);
  if (status) return status;
  status = dlsi_scaled_begin(&scaled, &units, &problem, &r, &u, &info, &s.limits, error);
  if (!status) status = solve_in_passing(problem, &s, r, u, info, error);
  status = dlsi_scaled_end(&scaled, status, error);
  dlsi_units_free(&units);
  return status;
}

dls_status dls_solve(const dls_contact *problem, const dls_solver_settings *settings, double *r,
                     double *u, dls_info *info, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, solve_once(problem, settings, r, u, info, error), error);
}
