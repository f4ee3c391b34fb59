/*
 * reduction.c: W = H^T K^-1 H and q = H^T K^-1 f + P^T g, and back: x = K^-1 (f + H r).
 *
 * Source: [Jean 1988] (3.3)1-6, with the weighting of 4.4. His W_nn, W_nt, W_tn, W_tt come out
 * interleaved, in local order per candidate. The unknowns are M r, so that H = L P without his M.
 *
 *   (R1)  H = L P by rows, without what the scene does not need
 *   (R2)  K with springs at its rigid-body modes, if there are any                  (modes.c)
 *   (R3)  factor                                                                    (factor.c)
 *   (R4)  W                                                                         (influence.c)
 *
 * An indefinite K whose Schur complement cannot be had is factored as a whole. A K that turns out
 * singular is searched for rigid-body modes, and goes back to (R2) or is reported
 * with them; one that is not positive definite goes back to (R3) as DLS_LDLT or is reported.
 *
 * Memory: m^2 + O(n + nnz H) doubles beside the factor. load, recover, balance: one solve each.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reduction_internal.h"

struct dls_reduction {
  dls_reduction_settings settings;
  int d, nodes, candidates; /* candidates: active ones */
  dls_operator kind;
  dls_factorization factorization; /* as tagged */
  dlsi_factor *factor;
  dlsi_modes modes;
  double spring[dlsi_most_modes], at[dlsi_most_modes]; /* s_j, c_j of each mode */
  dls_reduction_info info;
  int ready; /* 0 after an update that failed */
  dlsi_rows H;
  int *keep, kept; /* unknowns that H touches, ascending */
  int whole;       /* 1: no Schur complement */
  int columns;     /* of H that are not empty */
  size_t entries;  /* of H, those of one place counted one by one */
  int weights;     /* entries of P */
  int *Pp, *Pi;    /* P by columns, of the active candidates; the nodes themselves without P */
  double *Px;
  int *tangents; /* candidates: 0 where they are left out */
  double *mu;    /* candidates; NULL if the model has none */
  double *W;     /* m x m, or NULL */
  double *q;     /* m */
  double *f;     /* n, by position: the last load */
  double *x, *y; /* n, by position: room for solves; y as scratch of the solve */
  double *v, *z; /* m, n: room for load */
  void *memory;  /* of all of these but the factor and the modes */
};

void dls_reduction_settings_init(dls_reduction_settings *settings) {
  if (!settings) return;
  *settings = (dls_reduction_settings){.size = sizeof *settings, .form_W = 1};
}

static dls_status check_settings(const dls_reduction_settings *s, dls_error *error) {
  if (s->size != sizeof *s)
    return dlsi_fail(error, DLS_E_SETTINGS, "settings", -1, (double)s->size,
                     "not filled by dls_reduction_settings_init");
  if (!(s->memory_limit >= 0))
    return dlsi_fail(error, DLS_E_ARGUMENT, "memory_limit", -1, s->memory_limit, "must be >= 0");
  const struct {
    const char *name;
    int value;
  } switches[] = {{"allow_indefinite", s->allow_indefinite},
                  {"stabilize", s->stabilize},
                  {"form_W", s->form_W}};
  for (size_t k = 0; k < sizeof switches / sizeof switches[0]; k++)
    if (switches[k].value != 0 && switches[k].value != 1)
      return dlsi_fail(error, DLS_E_ARGUMENT, switches[k].name, -1, switches[k].value,
                       "must be 0 or 1");
  return DLS_OK;
}

/* ---- H and P (R1) ---------------------------------------------------------------------------- */

static int is_active(const dls_model *model, int c) {
  return !model->active || model->active[c];
}

static int count_active(const dls_model *model) {
  int count = 0;
  for (int c = 0; c < dlsi_model_candidates(model); c++)
    count += is_active(model, c);
  return count;
}

static int has_tangents(const dls_model *model, int c) {
  return !model->mu || model->mu[c] > 0;
}

/* Walks over H = L P: what it does with an entry. */
typedef struct visit {
  int *touched;  /* n: marks unknowns, or NULL */
  size_t *count; /* by position: counts, or NULL */
  size_t *at;    /* by position: the next free entry of H, or NULL */
  const int *place;
  dlsi_rows *H;
  size_t entries;
  int columns;
} visit;

/* Column `column` of L, times weight, as column j of H. */
static void visit_column(visit *v, const dls_sparse *L, int column, double weight, int j) {
  for (int e = L->p[column]; e < L->p[column + 1]; e++) {
    const int i = L->i[e];
    v->entries++;
    if (v->touched) v->touched[i] = 1;
    if (v->count) v->count[v->place[i]]++;
    if (!v->at) continue;
    const size_t to = v->at[v->place[i]]++;
    v->H->j[to] = j;
    v->H->h[to] = weight * L->x[e];
  }
}

static void visit_all(visit *v, const dls_model *model) {
  const int d = model->d, all = dlsi_model_candidates(model);
  for (int a = 0, c = 0; a < all; a++) { /* c: number among the active ones */
    if (!is_active(model, a)) continue;
    const int begin = model->P.p ? model->P.p[a] : a, end = model->P.p ? model->P.p[a + 1] : a + 1;
    for (int i = 0; i < (has_tangents(model, a) ? d : 1); i++) { /* n, then the tangents */
      const size_t before = v->entries;
      for (int k = begin; k < end; k++) {
        const int node = model->P.p ? model->P.i[k] : k;
        visit_column(v, i == 0 ? &model->HN : &model->HT, i == 0 ? node : (d - 1) * node + i - 1,
                     model->P.p ? model->P.x[k] : 1, d * c + i);
      }
      v->columns += v->entries > before;
    }
    c++;
  }
}

/* room (n) */
static void list_touched(dls_reduction *R, const dls_model *model, int *room) {
  memset(room, 0, R->H.n * sizeof *room);
  visit v = {.touched = room};
  visit_all(&v, model);
  R->columns = v.columns;
  R->kept = 0;
  for (int i = 0; i < model->n; i++)
    if (room[i]) R->keep[R->kept++] = i;
}

static void store_rows(dls_reduction *R, const dls_model *model) {
  size_t *p = R->H.p; /* counts stand two places on, then starts one place on, which end as p */
  memset(p, 0, (R->H.n + 2) * sizeof *p);
  visit count = {.count = p + 2, .place = R->factor->place};
  visit_all(&count, model);
  for (size_t k = 1; k <= R->H.n; k++)
    p[k + 1] += p[k];
  visit fill = {.at = p + 1, .place = R->factor->place, .H = &R->H};
  visit_all(&fill, model);
}

/* Pp, Pi, Px, tangents, mu of the active candidates */
static void store_candidates(dls_reduction *R, const dls_model *model) {
  const int all = dlsi_model_candidates(model);
  int c = 0, to = 0;
  R->Pp[0] = 0;
  for (int a = 0; a < all; a++) {
    if (!is_active(model, a)) continue;
    if (!model->P.p) {
      R->Pi[to] = a;
      R->Px[to++] = 1;
    }
    for (int k = model->P.p ? model->P.p[a] : 0; model->P.p && k < model->P.p[a + 1]; k++) {
      R->Pi[to] = model->P.i[k];
      R->Px[to++] = model->P.x[k];
    }
    R->tangents[c] = has_tangents(model, a);
    if (model->mu) R->mu[c] = model->mu[a];
    R->Pp[++c] = to;
  }
}

/* ---- memory ---------------------------------------------------------------------------------- */

static void carve(dls_reduction *R, const dls_model *model, dlsi_arena *arena) {
  const size_t n = R->H.n, m = R->H.m, c = (size_t)R->candidates, entries = R->entries;
  const size_t weights = (size_t)R->weights;
  R->H.p = dlsi_take(arena, n + 2, sizeof *R->H.p);
  R->H.j = dlsi_take(arena, entries, sizeof *R->H.j);
  R->H.h = dlsi_take(arena, entries, sizeof *R->H.h);
  R->keep = dlsi_take(arena, n, sizeof *R->keep);
  R->Pp = dlsi_take(arena, c + 1, sizeof *R->Pp);
  R->Pi = dlsi_take(arena, weights, sizeof *R->Pi);
  R->Px = dlsi_take(arena, weights, sizeof *R->Px);
  R->tangents = dlsi_take(arena, c, sizeof *R->tangents);
  R->mu = model->mu ? dlsi_take(arena, c, sizeof *R->mu) : NULL;
  R->q = dlsi_take(arena, m, sizeof *R->q);
  R->v = dlsi_take(arena, m, sizeof *R->v);
  R->f = dlsi_take(arena, n, sizeof *R->f);
  R->x = dlsi_take(arena, n, sizeof *R->x);
  R->z = dlsi_take(arena, R->kind == DLS_STIFFNESS_SPARSE ? n : 0, sizeof *R->z);
  R->y = dlsi_take(arena, R->kind == DLS_FLEXIBILITY ? n : 0, sizeof *R->y);
}

/* Everything that does not depend on values, but W and the factor. */
static dls_status lay_out(dls_reduction *R, const dls_model *model, dls_error *error) {
  visit v = {0};
  visit_all(&v, model);
  R->entries = v.entries;
  R->weights = model->P.p ? model->P.p[model->P.cols] : R->candidates;
  dlsi_arena arena = {0};
  carve(R, model, &arena);
  arena.size = arena.used;
  arena.used = 0;
  arena.base = R->memory = arena.failed ? NULL : dlsi_alloc(arena.size, 1);
  int *room = dlsi_alloc(R->H.n, sizeof *room);
  if (R->memory && room) {
    carve(R, model, &arena);
    list_touched(R, model, room);
  }
  free(room);
  return R->memory && room ? DLS_OK : dlsi_no_memory(error);
}

/* What the factor and W take. */
static void foresee(dls_reduction *R) {
  dls_reduction_info *info = &R->info;
  const double m = (double)R->H.m, n = (double)R->H.n, b = R->factor->kept;
  info->condensed = R->factor->kept;
  dlsi_factor_estimate(R->factor, &info->factor_bytes, &info->bytes, &info->flops);
  info->W_bytes = R->settings.form_W ? sizeof(double) * m * m : 0;
  const double batch = m < dlsi_batch ? m : dlsi_batch;
  const double room = b > 0 ? b * b : (double)R->factor->largest * batch;
  info->bytes += info->W_bytes + sizeof(double) * (6 * n + (R->settings.form_W ? room : 0));
}

static dls_status check_limit(const dls_reduction *R, dls_error *error) {
  const dls_reduction_info *info = &R->info;
  if (R->settings.memory_limit == 0 || info->bytes <= R->settings.memory_limit) return DLS_OK;
  return dlsi_fail(error, DLS_E_MEMORY, "memory_limit", -1, info->bytes,
                   "%.3g GB needed (W %.3g, factor %.3g), limit %.3g; dls_primal needs no W",
                   1e-9 * info->bytes, 1e-9 * info->W_bytes, 1e-9 * info->factor_bytes,
                   1e-9 * R->settings.memory_limit);
}

/* ---- factor (R2), (R3) ----------------------------------------------------------------------- */

/* Lays K out, if that has not been done. A Schur complement on far more unknowns than H has columns
 * would be dearer than solving for these. */
static dls_status analyse(dls_reduction *R, const dls_model *model, dls_error *error) {
  if (R->factor) return DLS_OK;
  const int kept = R->settings.form_W && !R->whole && R->kept / 4 <= R->columns ? R->kept : 0;
  const dls_status status = dlsi_factor_create(&R->factor, model, kept, R->keep, error);
  if (status) return status;
  foresee(R);
  return DLS_OK;
}

static void forget_factor(dls_reduction *R) {
  dlsi_factor_destroy(R->factor);
  R->factor = NULL;
}

static dls_status analyse_and_factor(dls_reduction *R, const dls_model *model, dls_error *error) {
  dls_status status = analyse(R, model, error);
  if (!status) status = check_limit(R, error);
  return status ? status : dlsi_factor_numeric(R->factor, model, error);
}

/* The Schur complement is not to be had, or spoilt, because K without the unknowns that H touches is
 * (nearly) singular: multipliers that tie such unknowns. Not so for a definite K. */
static int schur_fails(const dls_reduction *R, dls_factorization factorization, dls_status status) {
  if (!R->factor || R->factor->kept == 0 || factorization == DLS_CHOLESKY) return 0;
  return status == DLS_E_SINGULAR ||
         (!status && !(dlsi_schur_error(R->factor->schur) <= 1000 * DBL_EPSILON));
}

static dls_status attempt(dls_reduction *R, const dls_model *model, dls_error *error) {
  dlsi_stable stable;
  dls_status status = dlsi_stable_create(&stable, model, &R->modes, R->spring, error);
  stable.model.factorization = R->info.indefinite ? DLS_LDLT : model->factorization;
  if (!status) {
    status = analyse_and_factor(R, &stable.model, error);
    if (schur_fails(R, stable.model.factorization, status)) {
      forget_factor(R);
      R->whole = 1;
      status = analyse_and_factor(R, &stable.model, error);
      if (status) forget_factor(R);
      R->whole = !status;
    }
  }
  dlsi_stable_free(&stable);
  return status;
}

static dls_status report_modes(const dls_model *model, const dlsi_modes *modes, dls_error *error) {
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

/* Attempts, looking for modes and another factorisation where K asks for them. */
static dls_status factor_model(dls_reduction *R, const dls_model *model, dls_error *error) {
  dls_error first = {0};
  dls_status status = attempt(R, model, &first);
  const int stuck = status == DLS_E_SINGULAR || status == DLS_E_NOT_POSITIVE_DEFINITE;
  if (stuck && R->modes.count == 0) {
    forget_factor(R);
    if (dlsi_modes_find(model, &R->modes, NULL) || R->modes.count == 0) {
      dlsi_modes_free(&R->modes);
    } else if (!R->settings.stabilize) {
      status = report_modes(model, &R->modes, error);
      dlsi_modes_free(&R->modes);
      return status;
    } else
      status = attempt(R, model, &first);
  }
  if (status == DLS_E_NOT_POSITIVE_DEFINITE && R->settings.allow_indefinite &&
      !R->info.indefinite) {
    forget_factor(R);
    R->info.indefinite = 1;
    status = attempt(R, model, &first);
  }
  if (status && error) *error = first;
  if (status) return status;
  R->info.modes = R->modes.count;
  R->info.condition = R->factor->rcond > 0 ? 1 / R->factor->rcond : 0;
  return DLS_OK;
}

/* ---- create, update, destroy ----------------------------------------------------------------- */

/* All that depends on values. */
static dls_status fill(dls_reduction *R, const dls_model *model, dls_error *error) {
  R->ready = 0;
  dls_status status = factor_model(R, model, error);
  if (status) return status;
  store_candidates(R, model);
  store_rows(R, model);
  memset(R->q, 0, R->H.m * sizeof *R->q);
  memset(R->f, 0, R->H.n * sizeof *R->f);
  memset(R->at, 0, sizeof R->at);
  if (R->settings.form_W) {
    if (!R->W) R->W = dlsi_alloc(R->H.m, R->H.m * sizeof *R->W);
    status = R->W ? dlsi_influence(R->factor, &R->H, R->keep, R->W, error)
                  : dlsi_fail(error, DLS_E_MEMORY, "", -1, 0,
                              "out of memory; W alone takes %.3g GB; dls_primal needs no W",
                              1e-9 * R->info.W_bytes);
  }
  R->ready = !status;
  return status;
}

/* Checks, sizes, modes that are given, H's pattern: everything before the factorisation. NULL after
 * an error, which is in *status. */
static dls_reduction *begin(const dls_model *model, const dls_reduction_settings *settings,
                            dls_status *status, dls_error *error) {
  dls_reduction_settings defaults;
  dls_reduction_settings_init(&defaults);
  *status = check_settings(settings ? settings : &defaults, error);
  if (!*status) *status = dlsi_check_model(model, error);
  if (*status) return NULL;
  dls_reduction *R = calloc(1, sizeof *R);
  if (!R) {
    *status = dlsi_no_memory(error);
    return NULL;
  }
  R->settings = settings ? *settings : defaults;
  R->d = model->d;
  R->nodes = model->nodes;
  R->candidates = count_active(model);
  R->kind = model->operator_kind;
  R->factorization = model->factorization;
  R->H.n = (size_t)model->n;
  R->H.m = (size_t)R->d * (size_t)R->candidates;
  *status = lay_out(R, model, error);
  if (!*status && model->modes.a) *status = dlsi_modes_given(model, &R->modes, error);
  if (!*status) return R;
  dls_reduction_destroy(R);
  return NULL;
}

static dls_status create(dls_reduction **out, const dls_model *model,
                         const dls_reduction_settings *settings, dls_error *error) {
  if (!out) return dlsi_is_null(error, "out");
  *out = NULL;
  dls_status status;
  dls_reduction *R = begin(model, settings, &status, error);
  if (!R) return status;
  status = fill(R, model, error);
  if (status)
    dls_reduction_destroy(R);
  else
    *out = R;
  return status;
}

dls_status dls_reduction_create_with(dls_reduction **out, const dls_model *model,
                                     const dls_reduction_settings *settings, dls_error *error) {
  return dlsi_at(__func__, create(out, model, settings, error), error);
}

dls_status dls_reduction_create(dls_reduction **out, const dls_model *model, dls_error *error) {
  return dlsi_at(__func__, create(out, model, NULL, error), error);
}

dls_status dls_reduction_estimate(const dls_model *model, const dls_reduction_settings *settings,
                                  dls_reduction_info *info, dls_error *error) {
  if (!info) return dlsi_at(__func__, dlsi_is_null(error, "info"), error);
  dls_status status;
  dls_reduction *R = begin(model, settings, &status, error);
  if (!R) return dlsi_at(__func__, status, error);
  dlsi_stable stable;
  status = dlsi_stable_create(&stable, model, &R->modes, R->spring, error);
  if (!status) status = analyse(R, &stable.model, error);
  dlsi_stable_free(&stable);
  R->info.modes = R->modes.count;
  if (!status) *info = R->info;
  dls_reduction_destroy(R);
  return dlsi_at(__func__, status, error);
}

/* A model for update: as large as the one of create, and H on the same unknowns. room (n) */
static dls_status check_same(dls_reduction *R, const dls_model *model, int *room,
                             dls_error *error) {
  memset(room, 0, R->H.n * sizeof *room);
  visit v = {.touched = room};
  visit_all(&v, model);
  int touched = 0;
  for (int i = 0; i < model->n; i++)
    touched += room[i];
  for (int k = 0; touched == R->kept && k < R->kept; k++)
    if (!room[R->keep[k]]) touched = -1;
  if (v.entries != R->entries || v.columns != R->columns || touched != R->kept)
    return dlsi_fail(error, DLS_E_ARGUMENT, "HN", -1, (double)v.entries,
                     "HN, HT, P touch other unknowns than those of create");
  return DLS_OK;
}

static dls_status check_sizes(const dls_reduction *R, const dls_model *model, dls_error *error) {
  const int active = count_active(model);
  const int weights = model->P.p ? model->P.p[model->P.cols] : active;
  const struct {
    const char *name;
    int now, then;
  } sizes[] = {{"d", model->d, R->d},
               {"n", model->n, (int)R->H.n},
               {"nodes", model->nodes, R->nodes},
               {"P", weights, R->weights},
               {"active", active, R->candidates},
               {"mu", model->mu != NULL, R->mu != NULL},
               {"operator_kind", (int)model->operator_kind, (int)R->kind},
               {"factorization", (int)model->factorization, (int)R->factorization}};
  for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++)
    if (sizes[k].now != sizes[k].then)
      return dlsi_fail(error, DLS_E_SIZE, sizes[k].name, -1, sizes[k].now,
                       "is not what it was in create");
  return DLS_OK;
}

dls_status dls_reduction_update(dls_reduction *reduction, const dls_model *model,
                                dls_error *error) {
  dls_reduction *R = reduction;
  if (!R) return dlsi_at(__func__, dlsi_is_null(error, "reduction"), error);
  dls_status status = dlsi_check_model(model, error);
  if (!status) status = check_sizes(R, model, error);
  if (status) return dlsi_at(__func__, status, error);
  int *room = dlsi_alloc(R->H.n, sizeof *room);
  if (!room) return dlsi_at(__func__, dlsi_no_memory(error), error);
  status = check_same(R, model, room, error);
  free(room);
  if (!status && R->factor) {
    dlsi_stable stable;
    status = dlsi_stable_create(&stable, model, &R->modes, R->spring, error);
    if (!status) status = dlsi_factor_same(R->factor, &stable.model, error);
    dlsi_stable_free(&stable);
  }
  return dlsi_at(__func__, status ? status : fill(R, model, error), error);
}

void dls_reduction_destroy(dls_reduction *reduction) {
  if (!reduction) return;
  forget_factor(reduction);
  dlsi_modes_free(&reduction->modes);
  free(reduction->W);
  free(reduction->memory);
  free(reduction);
}

/* ---- load, contact, recover, balance, nodal -------------------------------------------------- */

static dls_status check_ready(const dls_reduction *R, dls_error *error) {
  if (!R) return dlsi_is_null(error, "reduction");
  if (R->ready) return DLS_OK;
  return dlsi_fail(error, DLS_E_ARGUMENT, "reduction", -1, 0,
                   "holds nothing after an update that failed");
}

dls_status dls_reduction_get_info(const dls_reduction *reduction, dls_reduction_info *info,
                                  dls_error *error) {
  const dls_status status = check_ready(reduction, error);
  if (status) return dlsi_at(__func__, status, error);
  if (!info) return dlsi_at(__func__, dlsi_is_null(error, "info"), error);
  *info = reduction->info;
  return DLS_OK;
}

/* R->x := K^-1 R->x, part by part */
static dls_status solve_x(dls_reduction *R, dls_error *error) {
  dls_status status = DLS_OK;
  for (int k = 0; !status && k < R->factor->parts; k++)
    status = dlsi_factor_solve(R->factor, k, R->x + R->factor->first[k], 1, R->y, error);
  return status;
}

/* R->v += H^T K^-1 R->x; R->x is spoilt */
static dls_status respond(dls_reduction *R, dls_error *error) {
  if (R->factor->kept == 0) {
    const dls_status status = solve_x(R, error);
    if (!status) dlsi_rows_add(&R->H, 0, R->H.n, R->x, R->v);
    return status;
  }
  const dls_status status = dlsi_schur_kept(R->factor->schur, R->x, R->z, error);
  for (int k = 0; !status && k < R->kept; k++)
    dlsi_rows_add(&R->H, (size_t)R->keep[k], 1, R->z + k, R->v);
  return status;
}

/* v := P^T g, without the tangents that are left out */
static void gather_gaps(const dls_reduction *R, const double *g, double *v) {
  const size_t d = (size_t)R->d;
  memset(v, 0, R->H.m * sizeof *v);
  for (size_t c = 0; g && c < (size_t)R->candidates; c++)
    for (int k = R->Pp[c]; k < R->Pp[c + 1]; k++)
      for (size_t i = 0; i < (R->tangents[c] ? d : 1); i++)
        v[d * c + i] += R->Px[k] * g[d * (size_t)R->Pi[k] + i];
}

/* q := v, unless something overflowed */
static dls_status take_q(dls_reduction *R, dls_error *error) {
  const long long bad = dlsi_first_not_finite(R->v, R->H.m);
  if (bad >= 0) return dlsi_fail(error, DLS_E_NOT_FINITE, "q", bad, R->v[bad], "overflow");
  memcpy(R->q, R->v, R->H.m * sizeof *R->q);
  return DLS_OK;
}

dls_status dls_reduction_load(dls_reduction *reduction, const double *f, const double *g,
                              dls_error *error) {
  dls_reduction *R = reduction;
  dls_status status = check_ready(R, error);
  if (status) return dlsi_at(__func__, status, error);
  const size_t n = R->H.n, d = (size_t)R->d;
  if (f) status = dlsi_check_vector("f", f, n, error);
  if (!status && g) status = dlsi_check_vector("g", g, d * (size_t)R->nodes, error);
  if (status) return dlsi_at(__func__, status, error);

  gather_gaps(R, g, R->v);
  if (f) { /* v += H^T K^-1 f */
    for (size_t k = 0; k < n; k++)
      R->x[k] = f[R->factor->unknown[k]];
    status = respond(R, error);
    if (status) return dlsi_at(__func__, status, error);
  }
  status = take_q(R, error);
  if (status) return dlsi_at(__func__, status, error);
  for (size_t k = 0; k < n; k++)
    R->f[k] = f ? f[R->factor->unknown[k]] : 0;
  memset(R->at, 0, sizeof R->at);
  return DLS_OK;
}

dls_status dls_reduction_contact(const dls_reduction *reduction, const double *mu,
                                 dls_contact *problem, dls_error *error) {
  const dls_reduction *R = reduction;
  dls_status status = check_ready(R, error);
  if (status) return dlsi_at(__func__, status, error);
  if (!R->W)
    return dlsi_at(__func__,
                   dlsi_fail(error, DLS_E_UNSUPPORTED, "reduction", -1, 0,
                             "was made without W (settings.form_W)"),
                   error);
  if (!mu) mu = R->mu;
  status = dlsi_check_vector("mu", mu, (size_t)R->candidates, error);
  if (status) return dlsi_at(__func__, status, error);
  for (int c = 0; c < R->candidates; c++) {
    if (mu[c] < 0)
      return dlsi_at(__func__, dlsi_fail(error, DLS_E_ARGUMENT, "mu", c, mu[c], "is negative"),
                     error);
    if (mu[c] > 0 && !R->tangents[c])
      return dlsi_at(__func__,
                     dlsi_fail(error, DLS_E_ARGUMENT, "mu", c, mu[c],
                               "is %g, but model.mu was 0 there: the tangents were left out",
                               mu[c]),
                     error);
  }
  if (!problem) return dlsi_at(__func__, dlsi_is_null(error, "problem"), error);
  const int m = (int)R->H.m;
  *problem =
      (dls_contact){.d = R->d, .nc = R->candidates, .W = {m, m, m, R->W}, .q = R->q, .mu = mu};
  return DLS_OK;
}

/* R->x := K^-1 (f + H r), with the springs at c */
static dls_status solve_for(dls_reduction *R, const double *r, dls_error *error) {
  for (size_t k = 0; k < R->H.n; k++) {
    double sum = R->f[k];
    for (size_t e = R->H.p[k]; e < R->H.p[k + 1]; e++)
      sum += R->H.h[e] * r[R->H.j[e]];
    R->x[k] = sum;
  }
  for (int k = 0; k < R->modes.count; k++)
    R->x[R->factor->place[R->modes.unknown[k]]] += R->spring[k] * R->at[k];
  const dls_status status = solve_x(R, error);
  if (status) return status;
  const long long bad = dlsi_first_not_finite(R->x, R->H.n);
  if (bad < 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_NOT_FINITE, "x", R->factor->unknown[bad], R->x[bad], "overflow");
}

dls_status dls_reduction_recover(dls_reduction *reduction, const double *r, double *x,
                                 dls_error *error) {
  dls_reduction *R = reduction;
  dls_status status = check_ready(R, error);
  if (!status) status = dlsi_check_vector("r", r, R->H.m, error);
  if (status) return dlsi_at(__func__, status, error);
  if (!x) return dlsi_at(__func__, dlsi_is_null(error, "x"), error);
  status = solve_for(R, r, error);
  if (status) return dlsi_at(__func__, status, error);
  for (size_t k = 0; k < R->H.n; k++)
    x[R->factor->unknown[k]] = R->x[k];
  return DLS_OK;
}

/* |b|^T (|f| + |H||r|) of mode k */
static double turmoil(const dls_reduction *R, int k, const double *r) {
  double sum = 0;
  for (size_t i = 0; i < R->H.n; i++) {
    double load = fabs(R->f[i]);
    for (size_t e = R->H.p[i]; e < R->H.p[i + 1]; e++)
      load += fabs(R->H.h[e] * r[R->H.j[e]]);
    sum += fabs(R->modes.basis[(size_t)R->factor->unknown[i] + (size_t)k * R->H.n]) * load;
  }
  return sum;
}

dls_status dls_reduction_balance(dls_reduction *reduction, const double *r, double *imbalance,
                                 dls_error *error) {
  dls_reduction *R = reduction;
  dls_status status = check_ready(R, error);
  if (!status) status = dlsi_check_vector("r", r, R->H.m, error);
  if (!status) status = solve_for(R, r, error);
  if (status) return dlsi_at(__func__, status, error);
  double worst = 0, move[dlsi_most_modes] = {0};
  for (int k = 0; k < R->modes.count; k++) {
    move[k] = R->x[R->factor->place[R->modes.unknown[k]]] - R->at[k];
    const double load = turmoil(R, k, r), part = load > 0 ? fabs(R->spring[k] * move[k]) / load : 0;
    if (!(part <= worst)) worst = part;
  }
  /* the springs alone give K^-1 s_k e_k = b_k: q += H^T sum_k b_k (x_k - c_k) */
  for (size_t i = 0; i < R->H.n; i++) {
    R->x[i] = 0;
    for (int k = 0; k < R->modes.count; k++)
      R->x[i] += move[k] * R->modes.basis[(size_t)R->factor->unknown[i] + (size_t)k * R->H.n];
  }
  memcpy(R->v, R->q, R->H.m * sizeof *R->v);
  dlsi_rows_add(&R->H, 0, R->H.n, R->x, R->v);
  status = take_q(R, error);
  if (status) return dlsi_at(__func__, status, error);
  for (int k = 0; k < R->modes.count; k++)
    R->at[k] += move[k];
  if (imbalance) *imbalance = worst;
  return DLS_OK;
}

dls_status dls_reduction_nodal(const dls_reduction *reduction, const double *r, double *R,
                               dls_error *error) {
  const dls_reduction *A = reduction;
  dls_status status = check_ready(A, error);
  if (!status) status = dlsi_check_vector("r", r, A->H.m, error);
  if (status) return dlsi_at(__func__, status, error);
  if (!R) return dlsi_at(__func__, dlsi_is_null(error, "R"), error);
  const size_t d = (size_t)A->d;
  memset(R, 0, d * (size_t)A->nodes * sizeof *R);
  for (size_t c = 0; c < (size_t)A->candidates; c++)
    for (int k = A->Pp[c]; k < A->Pp[c + 1]; k++)
      for (size_t i = 0; i < d; i++)
        R[d * (size_t)A->Pi[k] + i] += A->Px[k] * r[d * c + i];
  return DLS_OK;
}
