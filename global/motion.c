/*
 * motion.c: proves that nothing can hold a body.
 *
 * A motion b of the body with
 *
 *   (GM1)  K b = 0,  b^T f > 0,  (H^T b)_n >= mu |(H^T b)_t| at every contact
 *
 * has b^T (f + H r) > 0 for all r of the friction cones, but b^T K x = 0: there is no equilibrium.
 * By Farkas's lemma there is such a b wherever no r of the cones balances f, up to closure. Where K
 * is not symmetric nothing is tried: b^T K = 0 is what would count.
 *
 *   (GM2)  Iterate the splitting with rho = 1, the projection on the cone in the place of the law,
 *          and g = 0. This is a convex problem with the same cones. Where it has no solution, the
 *          drift x - x_old converges to such a b.
 *   (GM3)  Bodies that hardly move stand still, b := 0. Then three times
 *            | K + 1e-8 e   -G    | |db|     | K b   |        b := b + db
 *            | G^T          delta | |y | = - | G^T b |
 *          G: the rows that hold with equality: (H^T b)_c = 0 where it is small, (H^T b)_n = mu
 *          |(H^T b)_t| where the difference is. The rounding of a turn, divided by 1e-8, is small
 *          beside db only: each turn has a smaller one.
 *   (GM4)  Check (GM1) by the user's numbers, with b of largest entry 1:
 *            K b      |K b|_i <= 100 eps sum_j |K_ij|: the rounding of K itself, whose net force a
 *                     stack hands down to bodies that move less; and |b^T K b| <= 50 eps sum_i
 *                     |K_ii| b_i^2 in each connected body: the bending of a slender body that is
 *                     held passes the first test, not this one
 *            b^T f    more than 1e-10 |b|^T |f|
 *            cones    within 100 eps of the largest |H|^T |b|
 *
 * "Hardly" and "small" are 10 times the change of b between two looks: the steadier the drift, the
 * more is told apart. A try needs half of that of the try before.
 *
 * Source of (GM2): Banjac, Goulart, Stellato and Boyd, J. Optim. Theory Appl. 183, 2019, 490-519.
 * Cost: a solve with the factor of A an iteration, an LU for each turn of (GM3).
 * What can fail: forces that balance on the boundary of the cones alone, or a drift that converges
 * slowly. Nothing is proved then.
 */
#include <stdlib.h>
#include <string.h>

#include "global_internal.h"

enum { try_every = 20, turns = 3, most_tries = 12 };

static const double soft = 1e-8, delta = 1e-9;
static const double slack = 100 * DBL_EPSILON, soft_mode = 50 * DBL_EPSILON;
static const double certain = 1e-10; /* of |b|^T |f|: more than what the rounding of b leaves */
static const double steady = 1e-2;   /* most change of b / |b| between two looks for a try */
static const double least = 1e-9;    /* of b, taken for its rounding */

typedef struct drift {
  dls_global *global;
  double small; /* what counts as 0 over the largest motion: 10 times the change of b */
  double tried; /* small of the last try */
  int tries;
  double *drift, *before; /* the drift; b of the look before: n */
  double *sums;           /* 2 n */
  double scale;           /* the largest size of drift_misses */
  double *q, *x;          /* of the splitting, kept here: m, n */
  double *b, *y, *a;      /* b; scratch: n, n + m, n */
  double *size;           /* n: the largest |b| of each connected body, 0 where it stands still */
  dlsi_triplets t;        /* of (GM3) */
  dlsi_general general;
} drift;

/* h := (H^T b)_c; a: relative to what it rounds: |H|^T times the largest motion of the body. */
static void drift_at(const drift *D, int c, double *h, double *a) {
  const dlsi_columns *H = &D->global->H;
  const int d = D->global->d;
  for (int i = 0; i < 3; i++)
    h[i] = a[i] = 0;
  for (int i = 0; i < d; i++)
    for (int k = H->p[d * c + i]; k < H->p[d * c + i + 1]; k++) {
      h[i] += H->x[k] * D->b[H->i[k]];
      a[i] += fabs(H->x[k]) * D->size[D->global->part[H->i[k]]];
    }
}

/* Returns by how much the cone of contact c is missed: mu |h_t| - h_n, or the larger of -h_n and
 * |h_t| of a bonded one; *size: the numbers that it is computed from. */
static double drift_misses(const drift *D, int c, double *h, double *size) {
  const double mu = D->global->bend[c];
  double a[3];
  drift_at(D, c, h, a);
  const double t = dlsi_tangent_norm(D->global->d, h), at = dlsi_tangent_norm(D->global->d, a);
  *size = a[0] + (dlsi_is_bonded(mu) ? at : mu * at);
  return dlsi_is_bonded(mu) ? fmax(-h[0], t) : mu * t - h[0];
}

/* Scales b to 1 at its largest entry and stops the bodies that hardly move. Returns the body that
 * moves most, -1 for b = 0. */
static int drift_scale(drift *D) {
  const dls_global *work = D->global;
  double largest = 0;
  int mover = -1;
  memset(D->size, 0, (size_t)work->n * sizeof *D->size);
  for (int j = 0; j < work->n; j++) {
    const int p = work->part[j];
    if (fabs(D->b[j]) > D->size[p]) D->size[p] = fabs(D->b[j]);
    if (!(fabs(D->b[j]) <= largest)) {
      largest = fabs(D->b[j]);
      mover = p;
    }
  }
  if (!(largest > 0 && largest <= DBL_MAX)) return -1;
  for (int p = 0; p < work->body.parts; p++)
    D->size[p] = D->size[p] > D->small * largest ? D->size[p] / largest : 0;
  for (int j = 0; j < work->n; j++)
    D->b[j] = D->size[work->part[j]] > 0 ? D->b[j] / largest : 0;
  D->scale = 0;
  for (int c = 0; c < work->nc; c++) {
    double h[3], size;
    (void)drift_misses(D, c, h, &size);
    if (size > D->scale) D->scale = size;
  }
  return mover;
}

/* Returns 1 if b is near a proof. */
static int drift_is_near(drift *D) {
  const dls_global *work = D->global;
  double load = 0;
  dlsi_body_multiply(&work->model, D->b, D->y, D->a);
  const double scale = D->small * dlsi_max_abs(D->a, (size_t)work->n);
  for (int j = 0; j < work->n; j++) {
    if (!(fabs(D->y[j]) <= scale)) return 0;
    load += D->b[j] * (work->f ? work->f[j] : 0);
  }
  for (int c = 0; c < work->nc; c++) {
    double h[3], size;
    if (!(drift_misses(D, c, h, &size) <= D->small * D->scale)) return 0;
  }
  return load > 0;
}

/* Adds row e^T H_c^T of G to the matrix, as its unknown `at`; returns e^T (H^T b)_c. */
static double drift_row(drift *D, int c, const double *e, const double *h, int at) {
  const dls_global *work = D->global;
  const dlsi_columns *H = &work->H;
  double sum = 0;
  for (int i = 0; i < work->d; i++) {
    sum += e[i] * h[i];
    for (int k = H->p[work->d * c + i]; e[i] != 0 && k < H->p[work->d * c + i + 1]; k++) {
      if (D->size[work->part[H->i[k]]] == 0) continue;
      dlsi_triplets_add(&D->t, H->i[k], at, -e[i] * H->x[k]);
      dlsi_triplets_add(&D->t, at, H->i[k], e[i] * H->x[k]);
    }
  }
  dlsi_triplets_add(&D->t, at, at, delta);
  return sum;
}

/* Fills the matrix of (GM3), and y with its right side. */
static void drift_assemble(drift *D) {
  const dls_global *work = D->global;
  const dlsi_columns *K = &work->K;
  const int n = work->n, d = work->d;
  int rows = n;
  D->t.count = 0;
  dlsi_body_multiply(&work->model, D->b, D->y, NULL);
  for (int j = 0; j < n; j++) {
    const int moves = D->size[work->part[j]] > 0;
    D->y[j] = moves ? -D->y[j] : 0;
    dlsi_triplets_add(&D->t, j, j, (moves ? soft : 1) * work->system->e[j]);
    for (int k = K->p[j]; moves && k < K->p[j + 1]; k++) {
      dlsi_triplets_add(&D->t, K->i[k], j, K->x[k]);
      if (K->i[k] != j) dlsi_triplets_add(&D->t, j, K->i[k], K->x[k]);
    }
  }
  for (int c = 0; c < work->nc; c++) {
    const double mu = work->bend[c];
    double h[3], size, e[3] = {1, 0, 0};
    const double miss = drift_misses(D, c, h, &size);
    const double t = dlsi_tangent_norm(d, h);
    if (size == 0) continue;
    if (fabs(h[0]) + t <= D->small * D->scale || dlsi_is_bonded(mu)) {
      for (int i = h[0] > D->small * D->scale; i < d; i++, rows++) {
        const double unit[3] = {i == 0, i == 1, i == 2};
        D->y[rows] = -drift_row(D, c, unit, h, rows);
      }
    } else if (fabs(miss) <= D->small * D->scale) {
      for (int i = 1; i < d; i++)
        e[i] = t > 0 ? -mu * h[i] / t : 0;
      D->y[rows] = -drift_row(D, c, e, h, rows);
      rows++;
    }
  }
  D->t.rows = D->t.cols = rows;
}

/* (GM3) DLS_E_SINGULAR, DLS_E_UNSUPPORTED, DLS_E_MEMORY. */
static dls_status drift_clean(drift *D, dls_error *error) {
  dls_status status = DLS_OK;
  for (int turn = 0; !status && turn < turns; turn++) {
    drift_assemble(D);
    status = dlsi_general_factor(&D->general, &D->t, error);
    D->global->factorisations++;
    if (!status) status = dlsi_general_solve(&D->general, D->y, error);
    for (int j = 0; !status && j < D->global->n; j++)
      if (D->size[D->global->part[j]] > 0) D->b[j] += D->y[j];
  }
  return status;
}

/* (GM4) Returns 1 if b^T K b is rounding in each connected body. Kb: K b, n. sums: scratch, 2 n. */
static int drift_is_soft(const drift *D, const double *Kb, double *sums) {
  const dls_global *work = D->global;
  const size_t n = (size_t)work->n;
  memset(sums, 0, 2 * n * sizeof *sums);
  for (size_t j = 0; j < n; j++) {
    sums[2 * work->part[j]] += D->b[j] * Kb[j];
    sums[2 * work->part[j] + 1] += work->system->e[j] * D->b[j] * D->b[j];
  }
  for (int p = 0; p < work->body.parts; p++)
    if (!(fabs(sums[2 * p]) <= soft_mode * sums[2 * p + 1])) return 0;
  return 1;
}

/* (GM4) */
static int drift_proves(drift *D) {
  const dls_global *work = D->global;
  const size_t n = (size_t)work->n;
  double load = 0, turmoil = 0;
  for (size_t j = 0; j < n; j++) /* D->y := |K| e */
    D->a[j] = 1;
  dlsi_body_multiply(&work->model, D->a, work->y, D->y);
  dlsi_body_multiply(&work->model, D->b, D->a, NULL);
  for (size_t j = 0; j < n; j++) {
    if (!(fabs(D->a[j]) <= slack * D->y[j])) return 0;
    load += D->b[j] * (work->f ? work->f[j] : 0);
    turmoil += fabs(D->b[j] * (work->f ? work->f[j] : 0));
  }
  if (!(load > certain * turmoil) || !drift_is_soft(D, D->a, D->sums)) return 0;
  for (int c = 0; c < work->nc; c++) {
    double h[3], size;
    if (!(drift_misses(D, c, h, &size) <= slack * D->scale)) return 0;
  }
  return 1;
}

/* b := drift over its largest entry. Returns the largest change of b since the look before. */
static double drift_update(drift *D) {
  const int n = D->global->n;
  const double largest = dlsi_max_abs(D->drift, (size_t)n);
  double change = 0;
  for (int j = 0; j < n; j++) {
    const double b = D->drift[j] / largest;
    if (!(fabs(b - D->before[j]) <= change)) change = fabs(b - D->before[j]);
    D->b[j] = D->before[j] = b;
  }
  return change;
}

/* Takes the drift for b and tries to prove by it, if it has become steadier since the last try. */
static dls_status drift_try(drift *D, int *proved, dls_error *error) {
  dls_global *work = D->global;
  dls_error why = {0};
  const double change = drift_update(D);
  D->small = fmax(10 * change, least);
  if (!(change <= steady && D->small < D->tried / 2) || D->tries == most_tries) return DLS_OK;
  const int mover = drift_scale(D);
  if (mover < 0 || !drift_is_near(D)) return DLS_OK;
  D->tried = D->small;
  D->tries++;
  const dls_status status = drift_clean(D, &why);
  if (status == DLS_E_SINGULAR || status == DLS_E_UNSUPPORTED) return DLS_OK;
  if (status) {
    if (error) *error = why;
    return status;
  }
  if (!drift_proves(D)) return DLS_OK;
  *proved = work->moves = 1;
  for (int j = work->n; j-- > 0;)
    if (work->part[j] == mover) work->mover = j;
  memcpy(work->motion, D->b, (size_t)work->n * sizeof *D->b);
  return DLS_OK;
}

/* (GM2) r := the projection of q on the cones. */
static void drift_project(const dls_global *work, const double *q, double *r) {
  for (int c = 0; c < work->nc; c++)
    (void)dlsi_project_cone(work->d, work->bend[c], q + work->d * c, r + work->d * c);
}

static dls_status drift_run(drift *D, int most, int *proved, dls_error *error) {
  dls_global *work = D->global;
  const size_t n = (size_t)work->n;
  dls_status status = DLS_OK;
  for (int k = 1; !status && k <= most && !*proved; k++) {
    const int look = k % try_every == 0;
    drift_project(work, D->q, work->r);
    if (look) memcpy(D->drift, work->x, n * sizeof *D->drift);
    status = dlsi_global_step(work, work->r, D->q, NULL, error);
    if (status) break;
    for (int i = 0; i < work->m; i++)
      D->q[i] = work->r[i] - work->rho * (work->u[i] - work->g[i]);
    if (!look) continue;
    for (size_t j = 0; j < n; j++)
      D->drift[j] = work->x[j] - D->drift[j];
    status = drift_try(D, proved, error);
    if (status) break;
    dls_progress progress = {.method = "global",
                             .stage = "motion",
                             .iteration = k,
                             .max_iterations = most,
                             .residual = work->best.residual,
                             .r = work->best_r};
    status = dlsi_tell(work->limits, work->begun, &progress);
  }
  return status;
}

/* Runs with rho = 1: the drift is slow with larger ones. */
static dls_status drift_with(drift *D, int most, int *proved, dls_error *error) {
  dls_global *work = D->global;
  const double rho = work->rho;
  dls_status status = DLS_OK;
  work->rho = 1;
  if (rho != 1) status = dlsi_global_factor(work, error);
  if (!status) status = drift_run(D, most, proved, error);
  work->rho = rho;
  if (rho != 1 && status >= 0 && !*proved) {
    const dls_status again = dlsi_global_factor(work, error);
    if (again) status = again;
  }
  return status;
}

dls_status dlsi_global_prove(dls_global *work, int most, int *proved, dls_error *error) {
  const size_t n = (size_t)work->n, m = (size_t)work->m;
  const size_t entries = 2 * (size_t)work->K.p[n] + n + m + 4 * (size_t)work->H.p[m];
  drift D = {.global = work};
  *proved = 0;
  if (work->model.factorization == DLS_LU) return DLS_OK;
  double *memory = calloc(9 * n + 2 * m, sizeof *memory);
  dls_status status =
      dlsi_triplets_alloc(work->n + work->m, work->n + work->m, entries, &D.t, error);
  if (!status && !memory) status = dlsi_no_memory(error);
  if (!status) {
    D.x = memory;
    D.b = memory + n;
    D.a = memory + 2 * n;
    D.size = memory + 3 * n;
    D.y = memory + 4 * n;
    D.q = memory + 5 * n + m;
    D.drift = D.q + m;
    D.before = D.drift + n;
    D.sums = D.before + n;
    D.tried = 1;
    memcpy(D.x, work->x, n * sizeof *D.x);
    for (size_t k = 0; k < m; k++)
      D.q[k] = work->p[k] + (work->rho - 1) * work->u[k];
    status = drift_with(&D, most, proved, error);
    memcpy(work->x, D.x, n * sizeof *D.x);
  }
  dlsi_general_free(&D.general);
  dlsi_triplets_free(&D.t);
  free(memory);
  return status;
}
