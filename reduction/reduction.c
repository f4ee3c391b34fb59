/*
 * reduction.c: W = H^T K^-1 H and q = H^T K^-1 f + P^T g, and back: x = K^-1 (f + H r).
 *
 * Source: [Jean 1988] (3.3)1-6, with the weighting of 4.4. Here his W_nn, W_nt, W_tn, W_tt are
 * interleaved, in local order per contact. The unknowns are M r, so that H = L P without his M.
 *
 *   (RE1)  build H = L P by rows, without what the scene does not need         (operator.c)
 *   (RE2)  take redundant joints out of K             (src/linear/redundant.c)
 *   (RE3)  factor K                                                            (factor.c)
 *   (RE4)  form W                                                              (influence.c)
 *
 *   K indefinite, its Schur complement fails    factor K as a whole
 *   K not positive definite                     (RE3) as DLS_LDLT, or report it
 *   K singular                                  report it; the problem on K takes it (src/front)
 *
 * Memory: m^2 + O(n + nnz H) doubles beside the factor. Load, recover: one solve each.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "linear/redundant.h"
#include "reduced.h"
#include "reduction_internal.h"

struct dls_reduction {
  dls_reduction_settings settings;
  atomic_int busy;  /* a call is at work, in the host's solver perhaps */
  dlsi_watch watch; /* the host's, of create and update */
  int d, nodes;     /* d: of the model; H.d of the contact problem */
  size_t n, m;
  dls_operator kind;
  dls_factorization factorization; /* as tagged */
  dlsi_factor *factor;
  dls_reduction_info info;
  int ready;   /* 0 after an update that failed */
  int whole;   /* 1: K is factored without a Schur complement */
  int is_free; /* 1: the host gave K^-1 f instead of f */
  int moves;   /* 1: H may touch all of H.keep, the surface */
  int half;    /* 1: the factor holds the forward pass of f, or of 0 where is_free */
  dlsi_operator H;
  dlsi_kept kept; /* for the certificate of the body */
  int *
      redundant; /* info.redundant: the multipliers of redundant joints, whose loads are left out */
  void *companion; /* of src/front/body.c, or NULL, and how to end it */
  int is_stale;    /* 1: the companion has the values before the last update */
  void (*companion_destroy)(void *);
  double *mu; /* candidates: a copy of H.mu that stays in its place; NULL if the model has none */
  double *W;  /* m x m, or NULL */
  double *q;  /* m */
  double *f;  /* n, by position: the last load; or x_free, where is_free */
  double *x;  /* n, by position: scratch */
  double *y;  /* n: scratch of a solve with a flexibility */
  double *z;  /* n: scratch of the halves of a solve with a sparse K */
  double *on_surface; /* n: K^-1 f on the kept unknowns, of the last load; a sparse K */
  double *v;          /* m: scratch, the next q */
  double *next_gap;   /* m: the next P^T g */
  void *memory;       /* of all of these but H, the factor, the modes and W */
};

void dls_reduction_settings_init(dls_reduction_settings *settings) {
  if (!settings) return;
  *settings = (dls_reduction_settings){.size = sizeof *settings, .loads = 1, .form_W = 1};
}

static int is_on_K(const dls_reduction *work) {
  return work->settings.on == DLS_ON_K;
}

static dls_status reduction_settings(const dls_reduction_settings *s, dls_error *error) {
  const dlsi_setting own[] = {{"on", (double)s->on, DLS_ON_EITHER, DLS_ON_K, 0},
                              {"loads", s->loads, 1, INT_MAX, 0},
                              {"memory_limit", s->memory_limit, 0, INFINITY, 0},
                              {"allow_indefinite", s->allow_indefinite, 0, 1, 0},
                              {"form_W", s->form_W, 0, 1, 0},
                              {"surface_count", s->surface_count, 0, INT_MAX, 0},
                              {"frictionless", s->frictionless, 0, 1, 0}};
  if (s->size == sizeof *s) return dlsi_check_each(sizeof own / sizeof own[0], own, error);
  return dlsi_fail(error, DLS_E_SETTINGS, "settings", -1, (double)s->size,
                   "are not filled by their init function");
}

/* ---- memory ---------------------------------------------------------------------------------- */

static void reduction_carve(dls_reduction *work, dlsi_arena *arena) {
  work->mu = work->H.mu ? dlsi_take(arena, (size_t)work->H.candidates, sizeof *work->mu) : NULL;
  work->q = dlsi_take(arena, work->m, sizeof *work->q);
  work->v = dlsi_take(arena, work->m, sizeof *work->v);
  work->next_gap = dlsi_take(arena, work->m, sizeof *work->next_gap);
  work->f = dlsi_take(arena, work->n, sizeof *work->f);
  work->x = dlsi_take(arena, work->n, sizeof *work->x);
  const size_t sparse = work->kind == DLS_STIFFNESS_SPARSE ? work->n : 0;
  work->z = dlsi_take(arena, sparse, sizeof *work->z);
  work->on_surface = dlsi_take(arena, sparse, sizeof *work->on_surface);
  work->y = dlsi_take(arena, work->kind == DLS_FLEXIBILITY ? work->n : 0, sizeof *work->y);
}

static dls_status reduction_allocate(dls_reduction *work, dls_error *error) {
  dlsi_arena arena = {0};
  reduction_carve(work, &arena);
  work->memory = arena.failed ? NULL : dlsi_alloc(arena.used, 1);
  if (!work->memory) return dlsi_no_memory(error);
  arena = (dlsi_arena){.base = work->memory, .size = arena.used};
  reduction_carve(work, &arena);
  return DLS_OK;
}

/* Estimates the memory of the factor and W. */
static void reduction_foresee(dls_reduction *work) {
  dls_reduction_info *info = &work->info;
  const double m = (double)work->m, n = (double)work->n, b = work->factor->kept;
  dlsi_factor_estimate(work->factor, info);
  info->condensed = work->factor->kept;
  info->W_bytes = work->settings.form_W ? sizeof(double) * m * m : 0;
  const double batch = m < dlsi_batch ? m : dlsi_batch;
  const double extra = b > 0 ? b * b : (double)work->factor->largest * batch;
  info->bytes += info->W_bytes + sizeof(double) * (6 * n + (work->settings.form_W ? extra : 0));
}

static dls_status reduction_limit(const dls_reduction *work, dls_error *error) {
  const dls_reduction_info *info = &work->info;
  if (work->settings.memory_limit == 0 || info->bytes <= work->settings.memory_limit) return DLS_OK;
  return dlsi_fail(error, DLS_E_MEMORY, "memory_limit", -1, info->bytes,
                   "%.3g GB needed (W %.3g, factor %.3g), limit %.3g; dls_primal needs no W",
                   1e-9 * info->bytes, 1e-9 * info->W_bytes, 1e-9 * info->factor_bytes,
                   1e-9 * work->settings.memory_limit);
}

/* ---- factor (RE2), (RE3) --------------------------------------------------------------------- */

/* Lays K out, if that has not been done. If H touches far more unknowns than it has columns, to
 * solve for the columns costs less than a Schur complement. */
static dls_status reduction_analyse(dls_reduction *work, const dls_model *model, dls_error *error) {
  if (work->factor) return DLS_OK;
  const dlsi_operator *H = &work->H;
  const int pays = work->moves || (work->settings.form_W && H->kept / 4 <= H->columns);
  const int kept = pays && !work->whole ? H->kept : 0;
  dls_status status = dlsi_watch_stage(&work->watch, "analysis", 0);
  if (!status) status = dlsi_factor_create(&work->factor, model, kept, H->keep, error);
  if (status) return status;
  work->factor->watch = &work->watch;
  work->factor->keeps_Z = work->moves;
  reduction_foresee(work);
  return DLS_OK;
}

static void reduction_forget_factor(dls_reduction *work) {
  dlsi_factor_destroy(work->factor);
  work->factor = NULL;
}

/* Return how many pieces the stages "factor" and "W" have for the host; 0: not known. */
static int reduction_fronts(const dls_reduction *work) {
  const dlsi_factor *factor = work->factor;
  return factor->schur ? dlsi_schur_measured(factor->schur)->fronts : factor->parts;
}

static int reduction_batches(const dls_reduction *work) {
  const dlsi_factor *factor = work->factor;
  return factor->kept > 0 ? factor->kept : factor->parts > 1 ? factor->parts : (int)work->m;
}

static dls_status reduction_factor_once(dls_reduction *work, const dls_model *model,
                                        dls_error *error) {
  dls_status status = reduction_analyse(work, model, error);
  if (!status) status = reduction_limit(work, error);
  if (!status) status = dlsi_watch_stage(&work->watch, "factor", reduction_fronts(work));
  return status ? status : dlsi_factor_numeric(work->factor, model, error);
}

/* Returns 1 if the Schur complement does not exist or is inaccurate: K without the unknowns that H
 * touches is (nearly) singular, as multipliers tie such unknowns. A definite K always has it. */
static int reduction_schur_fails(const dls_reduction *work, dls_factorization factorization,
                                 dls_status status) {
  if (!work->factor || work->factor->kept == 0 || factorization == DLS_CHOLESKY) return 0;
  return status == DLS_E_SINGULAR ||
         (!status && !(dlsi_schur_measured(work->factor->schur)->error <= 1000 * DBL_EPSILON));
}

/* Factors K, as a whole where the Schur complement fails. */
static dls_status reduction_attempt(dls_reduction *work, const dls_model *model, dls_error *error) {
  dls_model K = *model;
  if (work->info.indefinite) K.factorization = DLS_LDLT;
  dls_status status = reduction_factor_once(work, &K, error);
  if (!reduction_schur_fails(work, K.factorization, status)) return status;
  reduction_forget_factor(work);
  work->whole = 1;
  status = reduction_factor_once(work, &K, error);
  if (status) reduction_forget_factor(work);
  work->whole = !status;
  return status;
}

/* A pivot of the scaled K that is <= 0, but not by more, is the rounding of a free body's 0: of n
 * eps times the squares of a rigid motion over its value at the last unknown. Above that condition
 * an indefinite factor of such a K holds nothing but rounding. */
static const double pivot_of_free = -1.5e-8, condition_of_free = 1e12;

/* Attempts, as DLS_LDLT too where that is allowed. */
static dls_status reduction_search(dls_reduction *work, const dls_model *model, dls_error *error) {
  dls_error why = {0};
  dls_status status = reduction_attempt(work, model, &why);
  const int not_definite = status == DLS_E_NOT_POSITIVE_DEFINITE;
  int is_free = not_definite && why.value > pivot_of_free;
  if (not_definite && work->settings.allow_indefinite && !work->info.indefinite) {
    dls_error second = {0};
    reduction_forget_factor(work);
    work->info.indefinite = 1;
    status = reduction_attempt(work, model, &second);
    if (!status)
      is_free &= work->factor->rcond * condition_of_free < 1;
    else if (status != DLS_E_SINGULAR && status != DLS_E_UNSUPPORTED)
      is_free = 0;
    if (!is_free) why = second;
  }
  if (is_free)
    status = dlsi_fail(&why, DLS_E_SINGULAR, why.argument, why.index, why.value,
                       "singular: pivot %.3g (scaled)", why.value);
  if (status == DLS_E_SINGULAR) {
    const size_t end = strlen(why.message);
    (void)snprintf(why.message + end, sizeof why.message - end,
                   "; W needs bodies that are held, K does not");
  }
  if (status < 0 && error) *error = why;
  if (status) return status;
  work->info.condition = work->factor->rcond > 0 ? 1 / work->factor->rcond : 0;
  return DLS_OK;
}

/* (RE2), (RE3) */
static dls_status reduction_factor(dls_reduction *work, const dls_model *model, dls_error *error) {
  dlsi_apart apart;
  const dls_sparse Ht = dlsi_columns_view(&work->H.Ht);
  dls_status status = dlsi_apart_create(&apart, model, &Ht, error);
  if (!status) {
    int *const old = work->redundant;
    work->redundant = apart.redundant;
    apart.redundant = old;
    work->info.joints = apart.joints;
    work->info.redundant = apart.count;
    if (apart.joints && model->factorization == DLS_CHOLESKY && work->settings.allow_indefinite)
      work->info.indefinite = 1; /* Cholesky would fail */
    status = reduction_search(work, &apart.model, error);
  }
  dlsi_apart_free(&apart);
  return status;
}

/* Sets v, by position, to 0 at the multipliers of redundant joints. */
static void reduction_silence(const dls_reduction *work, double *v) {
  for (int k = 0; work->factor && k < work->info.redundant; k++)
    v[work->factor->place[work->redundant[k]]] = 0;
}

/* ---- create, update, destroy ----------------------------------------------------------------- */

static void reduction_drop_companion(dls_reduction *work) {
  if (work->companion) work->companion_destroy(work->companion);
  work->companion = NULL;
  work->is_stale = 0;
}

/* Copies what the problem on K needs. */
static dls_status reduction_keep_K(dls_reduction *work, const dls_model *model, dls_error *error) {
  dlsi_apart apart;
  const dls_sparse Ht = dlsi_columns_view(&work->H.Ht);
  dls_status status = dlsi_apart_create(&apart, model, &Ht, error); /* only counts here */
  work->info.joints = apart.joints;
  work->info.redundant = apart.count;
  dlsi_apart_free(&apart);
  if (!status) status = dlsi_kept_create(&work->kept, model, &work->H, error);
  work->is_stale = 1;
  if (status || work->kept.has_K) return status;
  return dlsi_fail(error, DLS_E_UNSUPPORTED, "on", -1, DLS_ON_K,
                   "is K, which a flexibility or a host's solver does not have");
}

/* Computes all that depends on values, except H. */
static dls_status reduction_fill(dls_reduction *work, const dls_model *model, dls_error *error) {
  work->ready = 0;
  dlsi_kept_free(&work->kept);
  if (work->mu) memcpy(work->mu, work->H.mu, (size_t)work->H.candidates * sizeof *work->mu);
  if (is_on_K(work)) {
    const dls_status kept = reduction_keep_K(work, model, error);
    work->ready = !kept;
    return kept;
  }
  reduction_drop_companion(work);
  dls_status status = reduction_factor(work, model, error);
  if (!status) status = dlsi_kept_create(&work->kept, model, &work->H, error);
  if (status) return status;
  memset(work->q, 0, work->m * sizeof *work->q);
  memset(work->f, 0, work->n * sizeof *work->f);
  memset(work->on_surface, 0, (size_t)work->factor->kept * sizeof *work->on_surface);
  work->is_free = work->half = 0;
  if (work->settings.form_W) {
    status = dlsi_watch_stage(&work->watch, "W", reduction_batches(work));
    if (status) return status;
    if (!work->W) work->W = dlsi_alloc(work->m, work->m * sizeof *work->W);
    status = work->W ? dlsi_influence(work->factor, &work->H, work->W, error)
                     : dlsi_fail(error, DLS_E_MEMORY, "", -1, 0,
                                 "out of memory; W alone takes %.3g GB; dls_primal needs no W",
                                 1e-9 * work->info.W_bytes);
  }
  work->ready = !status;
  return status;
}

/* Adds the surface of the settings to the unknowns that H touches. */
static dls_status reduction_surface(dls_reduction *work, dls_error *error) {
  const int count = work->settings.surface_count, *surface = work->settings.surface;
  dlsi_operator *H = &work->H;
  work->moves = count > 0;
  if (count > 0 && !surface) return dlsi_is_null(error, "surface");
  char *on = calloc(work->n, 1);
  if (!on) return dlsi_no_memory(error);
  dls_status status = DLS_OK;
  for (int k = 0; k < H->kept; k++)
    on[H->keep[k]] = 1;
  for (int k = 0; !status && k < count; k++)
    if (surface[k] < 0 || (size_t)surface[k] >= work->n)
      status = dlsi_fail(error, DLS_E_ARGUMENT, "surface", k, surface[k],
                         "is %d, outside of 0 .. n-1", surface[k]);
    else
      on[surface[k]] = 1;
  H->kept = 0;
  for (int i = 0; (size_t)i < work->n; i++)
    if (on[i]) H->keep[H->kept++] = i;
  free(on);
  work->settings.surface = NULL; /* the host's */
  return status;
}

/* Checks that another H stays on the surface, and gives it the list of that. */
static dls_status reduction_stay(const dls_reduction *work, dlsi_operator *H, dls_error *error) {
  const dlsi_operator *old = &work->H;
  const int *joint = work->kept.body.joint;
  int at = 0;
  for (int k = 0; k < H->kept; k++) {
    const int i = H->keep[k];
    while (at < old->kept && old->keep[at] < i)
      at++;
    const int off =
        work->factor && work->factor->kept > 0 && (at == old->kept || old->keep[at] != i);
    if (off || (joint && joint[i]))
      return dlsi_fail(error, DLS_E_ARGUMENT, "HN", -1, i, "HN, HT, P touch unknown %d, %s", i,
                       off ? "which is not on the surface" : "a multiplier");
  }
  if (!work->factor || work->factor->kept == 0) return DLS_OK;
  memcpy(H->keep, old->keep, (size_t)old->kept * sizeof *H->keep);
  H->kept = old->kept;
  return DLS_OK;
}

/* Does everything before the factorisation: checks, H, sizes. *out = NULL after an error. */
static dls_status reduction_begin(dls_reduction **out, const dls_model *model,
                                  const dls_reduction_settings *settings, dls_error *error) {
  dls_reduction_settings defaults;
  dls_reduction_settings_init(&defaults);
  if (!settings) settings = &defaults;
  *out = NULL;
  dls_status status = reduction_settings(settings, error);
  if (!status) status = dlsi_check_model(model, error);
  if (status) return status;
  dls_reduction *work = calloc(1, sizeof *work);
  if (!work) return dlsi_no_memory(error);
  work->settings = *settings;
  work->info.on = is_on_K(work) ? DLS_ON_K : DLS_ON_W;
  work->watch = (dlsi_watch){
      .limits = {.progress = settings->progress, .progress_data = settings->progress_data},
      .method = "reduction",
      .stage = "analysis"};
  work->watch.begun = dlsi_clock_start(&work->watch.limits);
  work->d = model->d;
  work->nodes = model->nodes;
  work->kind = model->operator_kind;
  work->factorization = model->factorization;
  work->n = (size_t)model->n;
  status = dlsi_operator_create(&work->H, model, settings->frictionless, error);
  work->m = (size_t)work->H.d * (size_t)work->H.candidates;
  work->info.contacts = work->H.candidates;
  if (!status) status = reduction_surface(work, error);
  if (!status) status = reduction_allocate(work, error);
  if (status)
    dls_reduction_destroy(work);
  else
    *out = work;
  return status;
}

dls_status dlsi_reduction_create(dls_reduction **out, const dls_model *model,
                                 const dls_reduction_settings *settings, dls_error *error) {
  if (!out) return dlsi_is_null(error, "out");
  dls_status status = reduction_begin(out, model, settings, error);
  if (status) return status;
  status = reduction_fill(*out, model, error);
  if (status >= 0) dlsi_watch_end(&(*out)->watch);
  if (!status) return DLS_OK;
  dls_reduction_destroy(*out);
  *out = NULL;
  return status;
}

static dls_status reduction_estimate(const dls_model *model, const dls_reduction_settings *settings,
                                     dls_reduction_info *info, dls_error *error) {
  dls_reduction *work;
  if (!info) return dlsi_is_null(error, "info");
  dls_status status = reduction_begin(&work, model, settings, error);
  if (status) return status;
  dlsi_apart apart;
  const dls_sparse Ht = dlsi_columns_view(&work->H.Ht);
  status = dlsi_apart_create(&apart, model, &Ht, error);
  if (!status) status = reduction_analyse(work, &apart.model, error);
  work->info.joints = apart.joints;
  work->info.redundant = apart.count;
  dlsi_apart_free(&apart);
  if (!status) *info = work->info;
  dls_reduction_destroy(work);
  return status;
}

dls_status dls_reduction_estimate(const dls_model *model, const dls_reduction_settings *settings,
                                  dls_reduction_info *info, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, reduction_estimate(model, settings, info, error), error);
}

static dls_status reduction_enter(dls_reduction *work, dls_error *error) {
  if (!work) return dlsi_is_null(error, "reduction");
  return dlsi_enter(&work->busy, "reduction", error);
}

/* Compares sizes and pattern of a new model and its H with those of create. */
static dls_status reduction_same(const dls_reduction *work, const dls_model *model,
                                 const dlsi_operator *H, dls_error *error) {
  const struct {
    const char *name;
    int now, then;
  } sizes[] = {{"d", model->d, work->d},
               {"n", model->n, (int)work->n},
               {"nodes", model->nodes, work->nodes},
               {"active", H->candidates, work->H.candidates},
               {"P", H->P.p[H->candidates], work->H.P.p[work->H.candidates]},
               {"mu", H->mu != NULL, work->mu != NULL},
               {"operator_kind", (int)model->operator_kind, (int)work->kind},
               {"factorization", (int)model->factorization, (int)work->factorization}};
  for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++)
    if (sizes[k].now != sizes[k].then)
      return dlsi_fail(error, DLS_E_SIZE, sizes[k].name, -1, sizes[k].now,
                       "is not what it was in create");
  const int entries = H->Ht.p[work->n];
  if (entries != work->H.Ht.p[work->n] || H->columns != work->H.columns ||
      H->kept != work->H.kept || memcmp(H->keep, work->H.keep, (size_t)H->kept * sizeof *H->keep))
    return dlsi_fail(error, DLS_E_ARGUMENT, "HN", -1, entries,
                     "HN, HT, P touch other unknowns than those of create");
  if (!work->factor) return DLS_OK;
  dlsi_apart apart;
  const dls_sparse Ht = dlsi_columns_view(&H->Ht);
  dls_status status = dlsi_apart_create(&apart, model, &Ht, error);
  if (!status) status = dlsi_factor_same(work->factor, &apart.model, error);
  dlsi_apart_free(&apart);
  return status;
}

static dls_status reduction_update(dls_reduction *work, const dls_model *model, dls_error *error) {
  dls_status status = dlsi_check_model(model, error);
  if (status) return status;
  dlsi_operator H;
  status = dlsi_operator_create(&H, model, work->settings.frictionless, error);
  if (!status && work->moves) status = reduction_stay(work, &H, error);
  if (!status) status = reduction_same(work, model, &H, error);
  if (!status) {
    const dlsi_operator old = work->H;
    work->H = H;
    H = old;
  }
  dlsi_operator_free(&H);
  if (status) return status;
  work->watch.is_cancelled = 0;
  work->watch.begun = dlsi_clock_start(&work->watch.limits);
  status = reduction_fill(work, model, error);
  if (status >= 0) dlsi_watch_end(&work->watch);
  return status;
}

dls_status dls_reduction_update(dls_reduction *reduction, const dls_model *model,
                                dls_error *error) {
  DLSI_DOOR;
  dls_status status = reduction_enter(reduction, error);
  if (!status) status = dlsi_leave(&reduction->busy, reduction_update(reduction, model, error));
  return dlsi_at(__func__, status, error);
}

void dls_reduction_destroy(dls_reduction *reduction) {
  if (!reduction) return;
  reduction_forget_factor(reduction);
  reduction_drop_companion(reduction);
  dlsi_kept_free(&reduction->kept);
  free(reduction->redundant);
  dlsi_operator_free(&reduction->H);
  free(reduction->W);
  free(reduction->memory);
  free(reduction);
}

/* ---- info, load, contact, recover, nodal ----------------------------------------------------- */

static dls_status reduction_ready(const dls_reduction *work, dls_error *error) {
  if (!work) return dlsi_is_null(error, "reduction");
  if (work->ready) return DLS_OK;
  return dlsi_fail(error, DLS_E_ARGUMENT, "reduction", -1, 0,
                   "holds nothing after an update that failed");
}

/* Refuses what only a reduction to W can do. */
static dls_status reduction_on_W(const dls_reduction *work, dls_error *error) {
  const dls_status status = reduction_ready(work, error);
  if (status || !is_on_K(work)) return status;
  return dlsi_fail(error, DLS_E_UNSUPPORTED, "reduction", -1, 0,
                   "solves on K (settings.on): W is not formed");
}

/* Checks a reduction, the reactions r and the place of the result. */
static dls_status reduction_given(const dls_reduction *work, const double *r, const char *argument,
                                  const void *result, dls_error *error) {
  dls_status status = reduction_ready(work, error);
  if (!status) status = dlsi_check_vector("r", r, work->m, error);
  return status || result ? status : dlsi_is_null(error, argument);
}

dls_status dls_reduction_get_info(const dls_reduction *reduction, dls_reduction_info *info,
                                  dls_error *error) {
  DLSI_DOOR;
  dls_status status = reduction_ready(reduction, error);
  if (!status && !info) status = dlsi_is_null(error, "info");
  if (!status) *info = reduction->info;
  return dlsi_at(__func__, status, error);
}

/* Solves work->x := K^-1 work->x, part by part. */
static dls_status reduction_solve_x(dls_reduction *work, dls_error *error) {
  dls_status status = DLS_OK;
  for (int k = 0; !status && k < work->factor->parts; k++)
    status =
        dlsi_factor_solve(work->factor, k, work->x + work->factor->first[k], 1, work->y, error);
  return status;
}

/* Adds H^T K^-1 work->x to work->v; spoils work->x. */
static dls_status reduction_respond(dls_reduction *work, dls_error *error) {
  const int kept = work->factor->kept;
  const dls_status status = kept ? dlsi_schur_condense(work->factor->schur, work->x, work->z, error)
                                 : reduction_solve_x(work, error);
  if (status) return status;
  if (kept)
    dlsi_operator_add(&work->H, work->H.keep, (size_t)kept, work->z, work->v);
  else
    dlsi_operator_add(&work->H, work->factor->unknown, work->n, work->x, work->v);
  return DLS_OK;
}

/* Sets work->v := P^T g, without the tangents that are left out. */
static void reduction_gaps(const dls_reduction *work, const double *g) {
  const size_t d = (size_t)work->H.d, space = (size_t)work->d;
  const dlsi_columns *P = &work->H.P;
  memset(work->v, 0, work->m * sizeof *work->v);
  for (int c = 0; g && c < work->H.candidates; c++)
    for (int k = P->p[c]; k < P->p[c + 1]; k++)
      for (size_t i = 0; i < (dlsi_has_tangents(&work->H, c) ? d : 1); i++)
        work->v[d * (size_t)c + i] += P->x[k] * g[space * (size_t)P->i[k] + i];
}

/* Sets q := work->v, unless something overflowed. */
static dls_status reduction_take_q(dls_reduction *work, dls_error *error) {
  const long long bad = dlsi_first_not_finite(work->v, work->m);
  if (bad >= 0) return dlsi_fail(error, DLS_E_NOT_FINITE, "q", bad, work->v[bad], "overflow");
  memcpy(work->q, work->v, work->m * sizeof *work->q);
  return DLS_OK;
}

static dls_status reduction_load(dls_reduction *work, const double *f, const double *g,
                                 dls_error *error) {
  dls_status status = reduction_ready(work, error);
  if (!status && f) status = dlsi_check_vector("f", f, work->n, error);
  if (!status && g)
    status = dlsi_check_vector("g", g, (size_t)work->d * (size_t)work->nodes, error);
  if (status) return status;
  const int solves = f && !is_on_K(work) && (work->m > 0 || work->factor->kept > 0);
  reduction_gaps(work, g);
  memcpy(work->next_gap, work->v, work->m * sizeof *work->v);
  for (size_t k = 0; solves && k < work->n; k++)
    work->x[k] = f[work->factor->unknown[k]];
  work->half = 0;
  if (solves) reduction_silence(work, work->x);
  if (solves) status = reduction_respond(work, error);
  if (!status) status = reduction_take_q(work, error);
  if (status) return status;
  work->half = solves && work->factor->kept > 0;
  for (size_t k = 0; k < work->n && !is_on_K(work); k++)
    work->f[k] = f ? f[work->factor->unknown[k]] : 0;
  reduction_silence(work, work->f);
  for (int k = 0; !is_on_K(work) && k < work->factor->kept; k++)
    work->on_surface[k] = solves ? work->z[k] : 0;
  for (size_t k = 0; k < work->n; k++)
    work->kept.f[k] = f ? f[k] : 0;
  memcpy(work->kept.gap, work->next_gap, work->m * sizeof *work->v);
  work->is_free = 0;
  return DLS_OK;
}

dls_status dls_reduction_load(dls_reduction *reduction, const double *f, const double *g,
                              dls_error *error) {
  DLSI_DOOR;
  dls_status status = reduction_enter(reduction, error);
  if (!status) status = dlsi_leave(&reduction->busy, reduction_load(reduction, f, g, error));
  return dlsi_at(__func__, status, error);
}

static dls_status reduction_load_free(dls_reduction *work, const double *x_free, const double *g,
                                      dls_error *error) {
  dls_status status = reduction_ready(work, error);
  if (!status) status = dlsi_check_vector("x_free", x_free, work->n, error);
  if (!status && g)
    status = dlsi_check_vector("g", g, (size_t)work->d * (size_t)work->nodes, error);
  if (status) return status;
  reduction_gaps(work, g);
  memcpy(work->next_gap, work->v, work->m * sizeof *work->v);
  if (!is_on_K(work)) {
    const int *unknown = work->factor->unknown;
    for (size_t k = 0; k < work->n; k++)
      work->x[k] = x_free[unknown[k]];
    dlsi_operator_add(&work->H, unknown, work->n, work->x, work->v);
    status = reduction_take_q(work, error);
    if (status) return status;
    memcpy(work->f, work->x, work->n * sizeof *work->f);
  }
  memcpy(work->kept.gap, work->next_gap, work->m * sizeof *work->v);
  if (work->kept.has_K) dlsi_body_multiply(&work->kept.model, x_free, work->kept.f, NULL);
  work->is_free = 1;
  work->half = 0;
  return DLS_OK;
}

dls_status dls_reduction_load_free(dls_reduction *reduction, const double *x_free, const double *g,
                                   dls_error *error) {
  DLSI_DOOR;
  dls_status status = reduction_enter(reduction, error);
  if (!status)
    status = dlsi_leave(&reduction->busy, reduction_load_free(reduction, x_free, g, error));
  return dlsi_at(__func__, status, error);
}

/* Computes q of `next`, whose H is new, from the f of work; next.v := q, next.next_gap := P^T g. */
static dls_status reduction_reload(const dls_reduction *work, dls_reduction *next, const double *g,
                                   dls_error *error) {
  reduction_gaps(next, g);
  memcpy(next->next_gap, next->v, next->m * sizeof *next->v);
  if (is_on_K(next)) return reduction_take_q(next, error);
  const dlsi_factor *factor = next->factor;
  dls_status status = DLS_OK;
  memcpy(next->f, work->f, next->n * sizeof *next->f);
  memcpy(next->on_surface, work->on_surface, (size_t)factor->kept * sizeof *next->on_surface);
  if (factor->kept > 0 && !work->is_free)
    dlsi_operator_add(&next->H, next->H.keep, (size_t)factor->kept, work->on_surface, next->v);
  else {
    memcpy(next->x, work->f, next->n * sizeof *next->x);
    if (!work->is_free) status = reduction_solve_x(next, error);
    if (!status) dlsi_operator_add(&next->H, factor->unknown, next->n, next->x, next->v);
  }
  return status ? status : reduction_take_q(next, error);
}

/* Fills `next`, a copy of work that shares all but what depends on H. */
static dls_status reduction_again(const dls_reduction *work, dls_reduction *next, const double *g,
                                  dls_error *error) {
  dls_status status = reduction_allocate(next, error);
  if (!status) status = dlsi_kept_again(&work->kept, &next->H, &next->kept, error);
  if (status) return status;
  if (next->mu) memcpy(next->mu, next->H.mu, (size_t)next->H.candidates * sizeof *next->mu);
  if (!is_on_K(work) && work->settings.form_W) {
    next->info.W_bytes = sizeof(double) * (double)next->m * (double)next->m;
    next->info.bytes += next->info.W_bytes - work->info.W_bytes;
    status = reduction_limit(next, error);
    if (!status) status = dlsi_watch_stage(next->factor->watch, "W", reduction_batches(next));
    if (!status) next->W = dlsi_alloc(next->m, next->m * sizeof *next->W);
    if (!status && !next->W) status = dlsi_no_memory(error);
    if (!status) status = dlsi_influence(next->factor, &next->H, next->W, error);
  }
  if (!status) status = reduction_reload(work, next, g, error);
  if (!status) memcpy(next->kept.gap, next->next_gap, next->m * sizeof *next->v);
  return status;
}

static dls_status reduction_move(dls_reduction *work, const dls_model *model, const double *g,
                                 dls_error *error) {
  dls_status status = reduction_ready(work, error);
  if (!status) status = dlsi_check_model_contacts(model, error);
  if (status) return status;
  if (model->d != work->d || (size_t)model->n != work->n)
    return dlsi_fail(error, DLS_E_SIZE, model->d != work->d ? "d" : "n", -1,
                     model->d != work->d ? model->d : model->n, "is not what it was in create");
  if (g) status = dlsi_check_vector("g", g, (size_t)work->d * (size_t)model->nodes, error);
  if (status) return status;
  dls_reduction next = *work;
  next.memory = NULL;
  next.W = NULL;
  next.kept = (dlsi_kept){.x = NULL};
  next.nodes = model->nodes;
  status = dlsi_operator_create(&next.H, model, work->settings.frictionless, error);
  if (!status) status = reduction_stay(work, &next.H, error);
  next.m = (size_t)next.H.d * (size_t)next.H.candidates;
  next.info.contacts = next.H.candidates;
  work->watch.is_cancelled = 0;
  work->watch.begun = dlsi_clock_start(&work->watch.limits);
  if (work->factor) work->factor->keeps_Z = 1;
  if (!status) status = reduction_again(work, &next, g, error);
  if (status >= 0) dlsi_watch_end(&work->watch);
  if (status) {
    dlsi_kept_free(&next.kept);
    dlsi_operator_free(&next.H);
    free(next.W);
    free(next.memory);
    return status;
  }
  reduction_drop_companion(work);
  dlsi_operator_free(&work->H);
  free(work->W);
  free(work->memory);
  dlsi_kept_take(&work->kept, &next.kept);
  next.kept = work->kept;
  next.companion = NULL;
  next.is_stale = 0;
  next.moves = 1;
  next.watch = work->watch;
  *work = next;
  return DLS_OK;
}

dls_status dls_reduction_move(dls_reduction *reduction, const dls_model *model, const double *g,
                              dls_error *error) {
  DLSI_DOOR;
  dls_status status = reduction_enter(reduction, error);
  if (!status) status = dlsi_leave(&reduction->busy, reduction_move(reduction, model, g, error));
  return dlsi_at(__func__, status, error);
}

static dls_status reduction_contact(const dls_reduction *work, const double *mu,
                                    dls_contact *problem, dls_error *error) {
  dls_status status = reduction_on_W(work, error);
  if (status) return status;
  if (!work->W)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "reduction", -1, 0,
                     "was made without W (settings.form_W)");
  if (!mu) mu = work->mu;
  status = dlsi_check_friction(mu, (size_t)work->H.candidates, error);
  if (status) return status;
  for (int c = 0; c < work->H.candidates; c++) {
    if (mu[c] > 0 && !dlsi_has_tangents(&work->H, c))
      return dlsi_fail(error, DLS_E_ARGUMENT, "mu", c, mu[c],
                       "is %g, but model.mu was 0 there: the tangents were left out", mu[c]);
  }
  if (!problem) return dlsi_is_null(error, "problem");
  const int m = (int)work->m;
  *problem = (dls_contact){
      .d = work->H.d, .nc = work->H.candidates, .W = {m, m, m, work->W}, .q = work->q, .mu = mu};
  if (work->kept.has_K) problem->weights = work->kept.w;
  return DLS_OK;
}

dls_status dls_reduction_contact(const dls_reduction *reduction, const double *mu,
                                 dls_contact *problem, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, reduction_contact(reduction, mu, problem, error), error);
}

/* Solves work->x := K^-1 (f + H r), with f = 0 if the host gave K^-1 f: the backward half of a
 * solve. The forward half runs first if the factor does not hold it. */
static dls_status reduction_expand(dls_reduction *work, const double *r, dls_error *error) {
  const dlsi_columns *Ht = &work->H.Ht;
  const dlsi_factor *factor = work->factor;
  dls_status status = DLS_OK;
  if (!work->half) {
    for (size_t k = 0; k < work->n; k++)
      work->x[k] = work->is_free ? 0 : work->f[k];
    status = dlsi_schur_condense(factor->schur, work->x, work->z, error);
  }
  for (int k = 0; k < factor->kept; k++) {
    const int i = work->H.keep[k];
    work->z[k] = 0;
    for (int e = Ht->p[i]; e < Ht->p[i + 1]; e++)
      work->z[k] += Ht->x[e] * r[Ht->i[e]];
  }
  if (!status) status = dlsi_schur_expand(factor->schur, work->z, work->x, error);
  work->half = dlsi_schur_holds(factor->schur);
  return status;
}

/* Solves work->x := K^-1 (f + H r). */
static dls_status reduction_solve_for(dls_reduction *work, const double *r, dls_error *error) {
  const dlsi_columns *Ht = &work->H.Ht;
  const int *unknown = work->factor->unknown;
  dls_status status;
  if (work->factor->kept > 0)
    status = reduction_expand(work, r, error);
  else {
    for (size_t k = 0; k < work->n; k++) {
      double sum = work->is_free ? 0 : work->f[k];
      for (int e = Ht->p[unknown[k]]; e < Ht->p[unknown[k] + 1]; e++)
        sum += Ht->x[e] * r[Ht->i[e]];
      work->x[k] = sum;
    }
    status = reduction_solve_x(work, error);
  }
  if (status) return status;
  for (size_t k = 0; work->is_free && k < work->n; k++)
    work->x[k] += work->f[k];
  const long long bad = dlsi_first_not_finite(work->x, work->n);
  if (bad < 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_NOT_FINITE, "x", unknown[bad], work->x[bad], "overflow");
}

static dls_status reduction_recover(dls_reduction *work, const double *r, double *x,
                                    dls_error *error) {
  dls_status status = reduction_on_W(work, error);
  if (!status) status = reduction_given(work, r, "x", x, error);
  if (!status) status = reduction_solve_for(work, r, error);
  for (size_t k = 0; !status && k < work->n; k++)
    x[work->factor->unknown[k]] = work->x[k];
  return status;
}

dls_status dls_reduction_recover(dls_reduction *reduction, const double *r, double *x,
                                 dls_error *error) {
  DLSI_DOOR;
  dls_status status = reduction_enter(reduction, error);
  if (!status) status = dlsi_leave(&reduction->busy, reduction_recover(reduction, r, x, error));
  return dlsi_at(__func__, status, error);
}

/* Sets nodal := P r. */
static dls_status reduction_nodal(const dls_reduction *work, const double *r, double *nodal,
                                  dls_error *error) {
  const dls_status status = reduction_given(work, r, "R", nodal, error);
  if (status) return status;
  const size_t d = (size_t)work->H.d, space = (size_t)work->d;
  const dlsi_columns *P = &work->H.P;
  memset(nodal, 0, space * (size_t)work->nodes * sizeof *nodal);
  for (int c = 0; c < work->H.candidates; c++)
    for (int k = P->p[c]; k < P->p[c + 1]; k++)
      for (size_t i = 0; i < d; i++)
        nodal[space * (size_t)P->i[k] + i] += P->x[k] * r[d * (size_t)c + i];
  return DLS_OK;
}

dls_status dls_reduction_nodal(const dls_reduction *reduction, const double *r, double *R,
                               dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, reduction_nodal(reduction, r, R, error), error);
}

/* ---- the certificate of the body ------------------------------------------------------------- */

static const double usual_tol = 1e-8;      /* of dls_reduction_certify, which has none of its own */
static const double most_condition = 1e10; /* of a K that holds its bodies for certain */

/* Sets the weights of a reduction without K to those of W. */
static void reduction_weigh(dls_reduction *work) {
  const int m = (int)work->m;
  const dls_contact of_W = {.d = work->H.d, .nc = work->H.candidates, .W = {m, m, m, work->W}};
  if (!work->kept.has_K && work->W) dlsi_certificate_weights(&of_W, work->kept.w);
}

static dls_status reduction_certify(dls_reduction *work, const double *mu, const double *r,
                                    const double *x, double tol, double *u,
                                    dls_certificate *certificate, dls_error *error) {
  dls_status status = reduction_given(work, r, "certificate", certificate, error);
  if (!status) status = dlsi_check_vector("x", x, work->n, error);
  if (!mu) mu = work->mu;
  if (!status) status = dlsi_check_friction(mu, (size_t)work->H.candidates, error);
  if (status) return status;
  reduction_weigh(work);
  const int regular = !is_on_K(work) && work->info.condition <= most_condition;
  status = dlsi_kept_certify(&work->kept, &work->H, mu, r, x, tol, regular, certificate, error);
  if (status) return status;
  if (u) memcpy(u, work->kept.u, work->m * sizeof *u);
  return DLS_OK;
}

dls_status dlsi_reduction_certify(dls_reduction *reduction, const double *mu, const double *r,
                                  const double *x, double tol, double *u,
                                  dls_certificate *certificate, dls_error *error) {
  const dls_status status = reduction_enter(reduction, error);
  if (status) return status;
  return dlsi_leave(&reduction->busy,
                    reduction_certify(reduction, mu, r, x, tol, u, certificate, error));
}

dls_status dls_reduction_certify(dls_reduction *reduction, const double *mu, const double *r,
                                 const double *x, double *u, dls_certificate *certificate,
                                 dls_error *error) {
  DLSI_DOOR;
  const dls_status status =
      dlsi_reduction_certify(reduction, mu, r, x, usual_tol, u, certificate, error);
  return dlsi_at(__func__, status, error);
}

static dls_status reduction_states(dls_reduction *work, const double *mu, const double *r,
                                   const double *u, dls_contact_state *state, dls_error *error) {
  dls_status status = reduction_given(work, r, "state", state, error);
  if (!status) status = dlsi_check_vector("u", u, work->m, error);
  if (!mu) mu = work->mu;
  if (!status) status = dlsi_check_friction(mu, (size_t)work->H.candidates, error);
  if (status) return status;
  reduction_weigh(work);
  for (int c = 0; c < work->H.candidates; c++) {
    const size_t o = (size_t)work->H.d * (size_t)c;
    double F[3];
    state[c] = dlsi_contact_misfit(work->H.d, mu[c], work->kept.w + 2 * (size_t)c, r + o, u + o, F);
  }
  return DLS_OK;
}

dls_status dls_reduction_states(dls_reduction *reduction, const double *mu, const double *r,
                                const double *u, dls_contact_state *state, dls_error *error) {
  DLSI_DOOR;
  dls_status status = reduction_enter(reduction, error);
  if (!status)
    status = dlsi_leave(&reduction->busy, reduction_states(reduction, mu, r, u, state, error));
  return dlsi_at(__func__, status, error);
}

/* ---- for src/front/body.c -------------------------------------------------------------------- */

dlsi_reduced dlsi_reduction_body(dls_reduction *reduction) {
  return (dlsi_reduced){.has_K = reduction->kept.has_K,
                        .K = reduction->kept.model,
                        .H = &reduction->H,
                        .f = reduction->kept.f,
                        .gap = reduction->kept.gap,
                        .mu = reduction->mu,
                        .w = reduction->kept.w,
                        .nodes = reduction->nodes,
                        .space = reduction->d,
                        .companion = reduction->companion,
                        .is_stale = reduction->is_stale,
                        .on_K = is_on_K(reduction)};
}

void dlsi_reduction_keep(dls_reduction *reduction, void *companion, void (*destroy)(void *)) {
  if (companion != reduction->companion) reduction_drop_companion(reduction);
  reduction->is_stale = 0;
  reduction->companion = companion;
  reduction->companion_destroy = destroy;
}
