/*
 * reduction.c: W = H^T K^-1 H and q = H^T K^-1 f + P^T g, and back: x = K^-1 (f + H r).
 *
 * Source: [Jean 1988] (3.3)1-6, with the weighting of 4.4. His W_nn, W_nt, W_tn, W_tt come out
 * interleaved, in local order per candidate. The unknowns are M r, so that H = L P without his M.
 *
 *   (RE1)  build H = L P by rows, without what the scene does not need         (operator.c)
 *   (RE2)  put springs at the rigid-body modes of K, if there are any          (modes.c)
 *   (RE3)  factor K                                                            (factor.c)
 *   (RE4)  form W                                                              (influence.c)
 *
 * An indefinite K whose Schur complement cannot be had is factored as a whole. A singular K is searched
 * for rigid-body modes, and goes back to (RE2) or is reported with them. A K that is not positive
 * definite goes back to (RE3) as DLS_LDLT or is reported.
 *
 * Memory: m^2 + O(n + nnz H) doubles beside the factor. Load, recover, balance: one solve each.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reduction_internal.h"

struct dls_reduction {
  dls_reduction_settings settings;
  int d, nodes;
  size_t n, m;
  dls_operator kind;
  dls_factorization factorization; /* as tagged */
  dlsi_factor *factor;
  dlsi_modes modes;
  double spring[dlsi_most_modes], foot[dlsi_most_modes]; /* s_j, c_j of each mode */
  dls_reduction_info info;
  int ready; /* 0 after an update that failed */
  int whole; /* 1: K is factored without a Schur complement */
  dlsi_operator H;
  double *mu;   /* candidates: a copy of H.mu that stays in its place; NULL if the model has none */
  double *W;    /* m x m, or NULL */
  double *q;    /* m */
  double *f;    /* n, by position: the last load */
  double *x;    /* n, by position: scratch */
  double *y;    /* n: scratch of a solve with a flexibility */
  double *z;    /* n: scratch of a solve with a sparse K */
  double *v;    /* m: scratch, the next q */
  void *memory; /* of all of these but H, the factor, the modes and W */
};

void dls_reduction_settings_init(dls_reduction_settings *settings) {
  if (!settings) return;
  *settings = (dls_reduction_settings){.size = sizeof *settings, .form_W = 1};
}

static dls_status reduction_settings(const dls_reduction_settings *s, dls_error *error) {
  const dlsi_setting own[] = {{"memory_limit", s->memory_limit, 0, INFINITY, 0},
                              {"allow_indefinite", s->allow_indefinite, 0, 1, 0},
                              {"stabilize", s->stabilize, 0, 1, 0},
                              {"form_W", s->form_W, 0, 1, 0}};
  if (s->size == sizeof *s) return dlsi_check_each(sizeof own / sizeof own[0], own, error);
  return dlsi_fail(error, DLS_E_SETTINGS, "settings", -1, (double)s->size,
                   "are not filled by their init function");
}

/* ---- memory ---------------------------------------------------------------------------------- */

static void reduction_carve(dls_reduction *R, dlsi_arena *arena) {
  R->mu = R->H.mu ? dlsi_take(arena, (size_t)R->H.candidates, sizeof *R->mu) : NULL;
  R->q = dlsi_take(arena, R->m, sizeof *R->q);
  R->v = dlsi_take(arena, R->m, sizeof *R->v);
  R->f = dlsi_take(arena, R->n, sizeof *R->f);
  R->x = dlsi_take(arena, R->n, sizeof *R->x);
  R->z = dlsi_take(arena, R->kind == DLS_STIFFNESS_SPARSE ? R->n : 0, sizeof *R->z);
  R->y = dlsi_take(arena, R->kind == DLS_FLEXIBILITY ? R->n : 0, sizeof *R->y);
}

static dls_status reduction_allocate(dls_reduction *R, dls_error *error) {
  dlsi_arena arena = {0};
  reduction_carve(R, &arena);
  R->memory = arena.failed ? NULL : dlsi_alloc(arena.used, 1);
  if (!R->memory) return dlsi_no_memory(error);
  arena = (dlsi_arena){.base = R->memory, .size = arena.used};
  reduction_carve(R, &arena);
  return DLS_OK;
}

/* Foresees what the factor and W take. */
static void reduction_foresee(dls_reduction *R) {
  dls_reduction_info *info = &R->info;
  const double m = (double)R->m, n = (double)R->n, b = R->factor->kept;
  dlsi_factor_estimate(R->factor, info);
  info->condensed = R->factor->kept;
  info->W_bytes = R->settings.form_W ? sizeof(double) * m * m : 0;
  const double batch = m < dlsi_batch ? m : dlsi_batch;
  const double extra = b > 0 ? b * b : (double)R->factor->largest * batch;
  info->bytes += info->W_bytes + sizeof(double) * (6 * n + (R->settings.form_W ? extra : 0));
}

static dls_status reduction_limit(const dls_reduction *R, dls_error *error) {
  const dls_reduction_info *info = &R->info;
  if (R->settings.memory_limit == 0 || info->bytes <= R->settings.memory_limit) return DLS_OK;
  return dlsi_fail(error, DLS_E_MEMORY, "memory_limit", -1, info->bytes,
                   "%.3g GB needed (W %.3g, factor %.3g), limit %.3g; dls_primal needs no W",
                   1e-9 * info->bytes, 1e-9 * info->W_bytes, 1e-9 * info->factor_bytes,
                   1e-9 * R->settings.memory_limit);
}

/* ---- factor (RE2), (RE3) --------------------------------------------------------------------- */

/* Lays K out, if that has not been done. A Schur complement on far more unknowns than H has columns
 * would be dearer than solving for these. */
static dls_status reduction_analyse(dls_reduction *R, const dls_model *model, dls_error *error) {
  if (R->factor) return DLS_OK;
  const dlsi_operator *H = &R->H;
  const int kept = R->settings.form_W && !R->whole && H->kept / 4 <= H->columns ? H->kept : 0;
  const dls_status status = dlsi_factor_create(&R->factor, model, kept, H->keep, error);
  if (!status) reduction_foresee(R);
  return status;
}

static void reduction_forget_factor(dls_reduction *R) {
  dlsi_factor_destroy(R->factor);
  R->factor = NULL;
}

static dls_status reduction_factor_once(dls_reduction *R, const dls_model *model,
                                        dls_error *error) {
  dls_status status = reduction_analyse(R, model, error);
  if (!status) status = reduction_limit(R, error);
  return status ? status : dlsi_factor_numeric(R->factor, model, error);
}

/* Returns 1 if the Schur complement is not to be had, or spoilt, because K without the unknowns that H
 * touches is (nearly) singular: multipliers that tie such unknowns. A definite K has it always. */
static int reduction_schur_fails(const dls_reduction *R, dls_factorization factorization,
                                 dls_status status) {
  if (!R->factor || R->factor->kept == 0 || factorization == DLS_CHOLESKY) return 0;
  return status == DLS_E_SINGULAR ||
         (!status && !(dlsi_schur_measured(R->factor->schur)->error <= 1000 * DBL_EPSILON));
}

/* Factors K with the springs of R->modes, as a whole where the Schur complement fails. */
static dls_status reduction_attempt(dls_reduction *R, const dls_model *model, dls_error *error) {
  dlsi_stable stable;
  dls_status status = dlsi_stable_create(&stable, model, &R->modes, R->spring, error);
  stable.model.factorization = R->info.indefinite ? DLS_LDLT : model->factorization;
  if (!status) {
    status = reduction_factor_once(R, &stable.model, error);
    if (reduction_schur_fails(R, stable.model.factorization, status)) {
      reduction_forget_factor(R);
      R->whole = 1;
      status = reduction_factor_once(R, &stable.model, error);
      if (status) reduction_forget_factor(R);
      R->whole = !status;
    }
  }
  dlsi_stable_free(&stable);
  return status;
}

static dls_status reduction_report_modes(const dls_model *model, const dlsi_modes *modes,
                                         dls_error *error) {
  char list[64] = "";
  size_t end = 0;
  for (int k = 0; k < modes->count && k < 6; k++) {
    const int wrote =
        snprintf(list + end, sizeof list - end, "%s%d", k > 0 ? ", " : "", modes->unknown[k]);
    if (wrote < 0 || (size_t)wrote >= sizeof list - end) break;
    end += (size_t)wrote;
  }
  return dlsi_fail(error, DLS_E_SINGULAR, model->operator_kind == DLS_STIFFNESS_DENSE ? "K" : "Ks",
                   modes->unknown[0], modes->count,
                   "singular: %d%s rigid-body mode%s, of unknowns %s%s", modes->count,
                   modes->count == dlsi_most_modes ? " or more" : "", modes->count > 1 ? "s" : "",
                   list, modes->count > 6 ? ", .." : "");
}

/* Attempts, and where K asks for it looks for modes and for another factorisation. */
static dls_status reduction_factor(dls_reduction *R, const dls_model *model, dls_error *error) {
  dls_error first = {0};
  dls_status status = reduction_attempt(R, model, &first);
  const int stuck = status == DLS_E_SINGULAR || status == DLS_E_NOT_POSITIVE_DEFINITE;
  if (stuck && R->modes.count == 0) {
    reduction_forget_factor(R);
    const int found = !dlsi_modes_create(&R->modes, model, (dls_dense){0}, NULL) && R->modes.count;
    if (found && R->settings.stabilize)
      status = reduction_attempt(R, model, &first);
    else {
      if (found) status = reduction_report_modes(model, &R->modes, &first);
      dlsi_modes_free(&R->modes);
    }
  }
  if (status == DLS_E_NOT_POSITIVE_DEFINITE && R->settings.allow_indefinite &&
      !R->info.indefinite) {
    reduction_forget_factor(R);
    R->info.indefinite = 1;
    status = reduction_attempt(R, model, &first);
  }
  if (status && error) *error = first;
  if (status) return status;
  R->info.modes = R->modes.count;
  R->info.condition = R->factor->rcond > 0 ? 1 / R->factor->rcond : 0;
  return DLS_OK;
}

/* ---- create, update, destroy ----------------------------------------------------------------- */

/* Computes all that depends on values, but H. */
static dls_status reduction_fill(dls_reduction *R, const dls_model *model, dls_error *error) {
  R->ready = 0;
  dls_status status = reduction_factor(R, model, error);
  if (status) return status;
  memset(R->q, 0, R->m * sizeof *R->q);
  memset(R->f, 0, R->n * sizeof *R->f);
  memset(R->foot, 0, sizeof R->foot);
  if (R->mu) memcpy(R->mu, R->H.mu, (size_t)R->H.candidates * sizeof *R->mu);
  if (R->settings.form_W) {
    if (!R->W) R->W = dlsi_alloc(R->m, R->m * sizeof *R->W);
    status = R->W ? dlsi_influence(R->factor, &R->H, R->W, error)
                  : dlsi_fail(error, DLS_E_MEMORY, "", -1, 0,
                              "out of memory; W alone takes %.3g GB; dls_primal needs no W",
                              1e-9 * R->info.W_bytes);
  }
  R->ready = !status;
  return status;
}

/* Does everything before the factorisation: checks, H, sizes, the modes that are given. *out = NULL after
 * an error. */
static dls_status reduction_begin(dls_reduction **out, const dls_model *model,
                                  const dls_reduction_settings *settings, dls_error *error) {
  dls_reduction_settings defaults;
  dls_reduction_settings_init(&defaults);
  if (!settings) settings = &defaults;
  *out = NULL;
  dls_status status = reduction_settings(settings, error);
  if (!status) status = dlsi_check_model(model, error);
  if (status) return status;
  dls_reduction *R = calloc(1, sizeof *R);
  if (!R) return dlsi_no_memory(error);
  R->settings = *settings;
  R->d = model->d;
  R->nodes = model->nodes;
  R->kind = model->operator_kind;
  R->factorization = model->factorization;
  R->n = (size_t)model->n;
  status = dlsi_operator_create(&R->H, model, error);
  R->m = (size_t)R->d * (size_t)R->H.candidates;
  if (!status) status = reduction_allocate(R, error);
  if (!status && model->modes.a) status = dlsi_modes_create(&R->modes, model, model->modes, error);
  if (status)
    dls_reduction_destroy(R);
  else
    *out = R;
  return status;
}

static dls_status reduction_create(dls_reduction **out, const dls_model *model,
                                   const dls_reduction_settings *settings, dls_error *error) {
  if (!out) return dlsi_is_null(error, "out");
  dls_status status = reduction_begin(out, model, settings, error);
  if (status) return status;
  status = reduction_fill(*out, model, error);
  if (!status) return DLS_OK;
  dls_reduction_destroy(*out);
  *out = NULL;
  return status;
}

dls_status dls_reduction_create_with(dls_reduction **out, const dls_model *model,
                                     const dls_reduction_settings *settings, dls_error *error) {
  return dlsi_at(__func__, reduction_create(out, model, settings, error), error);
}

dls_status dls_reduction_create(dls_reduction **out, const dls_model *model, dls_error *error) {
  return dlsi_at(__func__, reduction_create(out, model, NULL, error), error);
}

static dls_status reduction_estimate(const dls_model *model, const dls_reduction_settings *settings,
                                     dls_reduction_info *info, dls_error *error) {
  dls_reduction *R;
  if (!info) return dlsi_is_null(error, "info");
  dls_status status = reduction_begin(&R, model, settings, error);
  if (status) return status;
  dlsi_stable stable;
  status = dlsi_stable_create(&stable, model, &R->modes, R->spring, error);
  if (!status) status = reduction_analyse(R, &stable.model, error);
  dlsi_stable_free(&stable);
  R->info.modes = R->modes.count;
  if (!status) *info = R->info;
  dls_reduction_destroy(R);
  return status;
}

dls_status dls_reduction_estimate(const dls_model *model, const dls_reduction_settings *settings,
                                  dls_reduction_info *info, dls_error *error) {
  return dlsi_at(__func__, reduction_estimate(model, settings, info, error), error);
}

/* Compares sizes and pattern of a new model and its H with those of create. */
static dls_status reduction_same(const dls_reduction *R, const dls_model *model,
                                 const dlsi_operator *H, dls_error *error) {
  const struct {
    const char *name;
    int now, then;
  } sizes[] = {{"d", model->d, R->d},
               {"n", model->n, (int)R->n},
               {"nodes", model->nodes, R->nodes},
               {"active", H->candidates, R->H.candidates},
               {"P", H->P.p[H->candidates], R->H.P.p[R->H.candidates]},
               {"mu", H->mu != NULL, R->mu != NULL},
               {"operator_kind", (int)model->operator_kind, (int)R->kind},
               {"factorization", (int)model->factorization, (int)R->factorization}};
  for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++)
    if (sizes[k].now != sizes[k].then)
      return dlsi_fail(error, DLS_E_SIZE, sizes[k].name, -1, sizes[k].now,
                       "is not what it was in create");
  const int entries = H->Ht.p[R->n];
  if (entries != R->H.Ht.p[R->n] || H->columns != R->H.columns || H->kept != R->H.kept ||
      memcmp(H->keep, R->H.keep, (size_t)H->kept * sizeof *H->keep))
    return dlsi_fail(error, DLS_E_ARGUMENT, "HN", -1, entries,
                     "HN, HT, P touch other unknowns than those of create");
  if (!R->factor) return DLS_OK;
  dlsi_stable stable;
  double spring[dlsi_most_modes];
  dls_status status = dlsi_stable_create(&stable, model, &R->modes, spring, error);
  if (!status) status = dlsi_factor_same(R->factor, &stable.model, error);
  dlsi_stable_free(&stable);
  return status;
}

static dls_status reduction_update(dls_reduction *R, const dls_model *model, dls_error *error) {
  if (!R) return dlsi_is_null(error, "reduction");
  dls_status status = dlsi_check_model(model, error);
  if (status) return status;
  dlsi_operator H;
  status = dlsi_operator_create(&H, model, error);
  if (!status) status = reduction_same(R, model, &H, error);
  if (!status) {
    const dlsi_operator old = R->H;
    R->H = H;
    H = old;
  }
  dlsi_operator_free(&H);
  return status ? status : reduction_fill(R, model, error);
}

dls_status dls_reduction_update(dls_reduction *reduction, const dls_model *model,
                                dls_error *error) {
  return dlsi_at(__func__, reduction_update(reduction, model, error), error);
}

void dls_reduction_destroy(dls_reduction *reduction) {
  if (!reduction) return;
  reduction_forget_factor(reduction);
  dlsi_modes_free(&reduction->modes);
  dlsi_operator_free(&reduction->H);
  free(reduction->W);
  free(reduction->memory);
  free(reduction);
}

/* ---- info, load, contact, recover, balance, nodal -------------------------------------------- */

static dls_status reduction_ready(const dls_reduction *R, dls_error *error) {
  if (!R) return dlsi_is_null(error, "reduction");
  if (R->ready) return DLS_OK;
  return dlsi_fail(error, DLS_E_ARGUMENT, "reduction", -1, 0,
                   "holds nothing after an update that failed");
}

/* Checks a reduction, the reactions r and the place of the result. */
static dls_status reduction_given(const dls_reduction *R, const double *r, const char *argument,
                                  const void *result, dls_error *error) {
  dls_status status = reduction_ready(R, error);
  if (!status) status = dlsi_check_vector("r", r, R->m, error);
  return status || result ? status : dlsi_is_null(error, argument);
}

dls_status dls_reduction_get_info(const dls_reduction *reduction, dls_reduction_info *info,
                                  dls_error *error) {
  dls_status status = reduction_ready(reduction, error);
  if (!status && !info) status = dlsi_is_null(error, "info");
  if (!status) *info = reduction->info;
  return dlsi_at(__func__, status, error);
}

/* Solves R->x := K^-1 R->x, part by part. */
static dls_status reduction_solve_x(dls_reduction *R, dls_error *error) {
  dls_status status = DLS_OK;
  for (int k = 0; !status && k < R->factor->parts; k++)
    status = dlsi_factor_solve(R->factor, k, R->x + R->factor->first[k], 1, R->y, error);
  return status;
}

/* Adds H^T K^-1 R->x to R->v; spoils R->x. */
static dls_status reduction_respond(dls_reduction *R, dls_error *error) {
  const int kept = R->factor->kept;
  const dls_status status =
      kept ? dlsi_schur_kept(R->factor->schur, R->x, R->z, error) : reduction_solve_x(R, error);
  if (status) return status;
  if (kept)
    dlsi_operator_add(&R->H, R->H.keep, (size_t)kept, R->z, R->v);
  else
    dlsi_operator_add(&R->H, R->factor->unknown, R->n, R->x, R->v);
  return DLS_OK;
}

/* Sets R->v := P^T g, without the tangents that are left out. */
static void reduction_gaps(const dls_reduction *R, const double *g) {
  const size_t d = (size_t)R->d;
  const dlsi_columns *P = &R->H.P;
  memset(R->v, 0, R->m * sizeof *R->v);
  for (int c = 0; g && c < R->H.candidates; c++)
    for (int k = P->p[c]; k < P->p[c + 1]; k++)
      for (size_t i = 0; i < (dlsi_has_tangents(&R->H, c) ? d : 1); i++)
        R->v[d * (size_t)c + i] += P->x[k] * g[d * (size_t)P->i[k] + i];
}

/* Sets q := R->v, unless something overflowed. */
static dls_status reduction_take_q(dls_reduction *R, dls_error *error) {
  const long long bad = dlsi_first_not_finite(R->v, R->m);
  if (bad >= 0) return dlsi_fail(error, DLS_E_NOT_FINITE, "q", bad, R->v[bad], "overflow");
  memcpy(R->q, R->v, R->m * sizeof *R->q);
  return DLS_OK;
}

static dls_status reduction_load(dls_reduction *R, const double *f, const double *g,
                                 dls_error *error) {
  dls_status status = reduction_ready(R, error);
  if (!status && f) status = dlsi_check_vector("f", f, R->n, error);
  if (!status && g) status = dlsi_check_vector("g", g, (size_t)R->d * (size_t)R->nodes, error);
  if (status) return status;
  reduction_gaps(R, g);
  for (size_t k = 0; f && k < R->n; k++)
    R->x[k] = f[R->factor->unknown[k]];
  if (f) status = reduction_respond(R, error);
  if (!status) status = reduction_take_q(R, error);
  if (status) return status;
  for (size_t k = 0; k < R->n; k++)
    R->f[k] = f ? f[R->factor->unknown[k]] : 0;
  memset(R->foot, 0, sizeof R->foot);
  return DLS_OK;
}

dls_status dls_reduction_load(dls_reduction *reduction, const double *f, const double *g,
                              dls_error *error) {
  return dlsi_at(__func__, reduction_load(reduction, f, g, error), error);
}

static dls_status reduction_contact(const dls_reduction *R, const double *mu, dls_contact *problem,
                                    dls_error *error) {
  dls_status status = reduction_ready(R, error);
  if (status) return status;
  if (!R->W)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "reduction", -1, 0,
                     "was made without W (settings.form_W)");
  if (!mu) mu = R->mu;
  status = dlsi_check_vector("mu", mu, (size_t)R->H.candidates, error);
  if (status) return status;
  for (int c = 0; c < R->H.candidates; c++) {
    if (mu[c] < 0) return dlsi_fail(error, DLS_E_ARGUMENT, "mu", c, mu[c], "is negative");
    if (mu[c] > 0 && !dlsi_has_tangents(&R->H, c))
      return dlsi_fail(error, DLS_E_ARGUMENT, "mu", c, mu[c],
                       "is %g, but model.mu was 0 there: the tangents were left out", mu[c]);
  }
  if (!problem) return dlsi_is_null(error, "problem");
  const int m = (int)R->m;
  *problem =
      (dls_contact){.d = R->d, .nc = R->H.candidates, .W = {m, m, m, R->W}, .q = R->q, .mu = mu};
  return DLS_OK;
}

dls_status dls_reduction_contact(const dls_reduction *reduction, const double *mu,
                                 dls_contact *problem, dls_error *error) {
  return dlsi_at(__func__, reduction_contact(reduction, mu, problem, error), error);
}

/* Solves R->x := K^-1 (f + H r), with the springs' feet at c. */
static dls_status reduction_solve_for(dls_reduction *R, const double *r, dls_error *error) {
  const dlsi_columns *Ht = &R->H.Ht;
  for (size_t k = 0; k < R->n; k++) {
    const int i = R->factor->unknown[k];
    double sum = R->f[k];
    for (int e = Ht->p[i]; e < Ht->p[i + 1]; e++)
      sum += Ht->x[e] * r[Ht->i[e]];
    R->x[k] = sum;
  }
  for (int k = 0; k < R->modes.count; k++)
    R->x[R->factor->place[R->modes.unknown[k]]] += R->spring[k] * R->foot[k];
  const dls_status status = reduction_solve_x(R, error);
  if (status) return status;
  const long long bad = dlsi_first_not_finite(R->x, R->n);
  if (bad < 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_NOT_FINITE, "x", R->factor->unknown[bad], R->x[bad], "overflow");
}

static dls_status reduction_recover(dls_reduction *R, const double *r, double *x,
                                    dls_error *error) {
  dls_status status = reduction_given(R, r, "x", x, error);
  if (!status) status = reduction_solve_for(R, r, error);
  for (size_t k = 0; !status && k < R->n; k++)
    x[R->factor->unknown[k]] = R->x[k];
  return status;
}

dls_status dls_reduction_recover(dls_reduction *reduction, const double *r, double *x,
                                 dls_error *error) {
  return dlsi_at(__func__, reduction_recover(reduction, r, x, error), error);
}

/* Returns |b|^T (|f| + |H||r|) of mode k. */
static double reduction_turmoil(const dls_reduction *R, int k, const double *r) {
  const dlsi_columns *Ht = &R->H.Ht;
  double sum = 0;
  for (size_t at = 0; at < R->n; at++) {
    const size_t i = (size_t)R->factor->unknown[at];
    double load = fabs(R->f[at]);
    for (int e = Ht->p[i]; e < Ht->p[i + 1]; e++)
      load += fabs(Ht->x[e] * r[Ht->i[e]]);
    sum += fabs(R->modes.basis[i + (size_t)k * R->n]) * load;
  }
  return sum;
}

static dls_status reduction_balance(dls_reduction *R, const double *r, double *imbalance,
                                    dls_error *error) {
  dls_status status = reduction_given(R, r, "r", r, error);
  if (!status) status = reduction_solve_for(R, r, error);
  if (status) return status;
  double worst = 0, move[dlsi_most_modes] = {0};
  for (int k = 0; k < R->modes.count; k++) {
    move[k] = R->x[R->factor->place[R->modes.unknown[k]]] - R->foot[k];
    const double load = reduction_turmoil(R, k, r);
    const double part = load > 0 ? fabs(R->spring[k] * move[k]) / load : 0;
    if (!(part <= worst)) worst = part;
  }
  /* The springs alone give K^-1 s_k e_k = b_k: q += H^T sum_k b_k (x_k - c_k). */
  for (size_t i = 0; i < R->n; i++) {
    R->x[i] = 0;
    for (int k = 0; k < R->modes.count; k++)
      R->x[i] += move[k] * R->modes.basis[(size_t)R->factor->unknown[i] + (size_t)k * R->n];
  }
  memcpy(R->v, R->q, R->m * sizeof *R->v);
  dlsi_operator_add(&R->H, R->factor->unknown, R->n, R->x, R->v);
  status = reduction_take_q(R, error);
  if (status) return status;
  for (int k = 0; k < R->modes.count; k++)
    R->foot[k] += move[k];
  if (imbalance) *imbalance = worst;
  return DLS_OK;
}

dls_status dls_reduction_balance(dls_reduction *reduction, const double *r, double *imbalance,
                                 dls_error *error) {
  return dlsi_at(__func__, reduction_balance(reduction, r, imbalance, error), error);
}

/* Sets nodal := P r. */
static dls_status reduction_nodal(const dls_reduction *R, const double *r, double *nodal,
                                  dls_error *error) {
  const dls_status status = reduction_given(R, r, "R", nodal, error);
  if (status) return status;
  const size_t d = (size_t)R->d;
  const dlsi_columns *P = &R->H.P;
  memset(nodal, 0, d * (size_t)R->nodes * sizeof *nodal);
  for (int c = 0; c < R->H.candidates; c++)
    for (int k = P->p[c]; k < P->p[c + 1]; k++)
      for (size_t i = 0; i < d; i++)
        nodal[d * (size_t)P->i[k] + i] += P->x[k] * r[d * (size_t)c + i];
  return DLS_OK;
}

dls_status dls_reduction_nodal(const dls_reduction *reduction, const double *r, double *R,
                               dls_error *error) {
  return dlsi_at(__func__, reduction_nodal(reduction, r, R, error), error);
}
