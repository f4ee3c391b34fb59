/*
 * motion.c: proves that nothing can hold a body.
 *
 * A motion b of the body with
 *
 *   (GM1)  K b = 0,  b^T f > 0,  (H^T b)_n >= mu |(H^T b)_t| at every contact
 *
 * has b^T (f + H r) > 0 for all r of the friction cones, but b^T K x = 0: no equilibrium. By
 * Farkas's lemma there is one wherever no r of the cones balances f, up to closure. For K not
 * symmetric it is b^T K = 0 that counts.
 *
 *   (GM2)  The splitting with the projection on the cone, q - r, in the place of the law, and g =
 *          0: a convex problem with the same cones. Where it has no solution, x - x_old converges to
 *          such a b.
 *   (GM3)  b := b - (K + 1e-8 e)^-1 K b, three times: without what is no null vector; in bodies that
 *          hardly move b := 0
 *   (GM4)  (GM1) by the user's numbers: |K b|_i <= 100 eps (|K||b|)_i; b^T f above its rounding;
 *          the cones within 100 eps (|H|^T |b|), which the rounding of b accounts for
 *
 * Source of (GM2): Banjac, Goulart, Stellato and Boyd, J. Optim. Theory Appl. 183, 2019, 490-519.
 * Cost: up to `most` solves with the factor of A, one factorisation. What can fail: forces that
 * balance on the boundary of the cones alone; a drift that converges slowly. Nothing is proved then.
 */
#include <stdlib.h>
#include <string.h>

#include "global_internal.h"

enum { most = 1000, try_every = 20, times = 3 };

static const double soft = 1e-8;
static const double still = 1e-7; /* of the largest motion: no motion */
static const double slack = 100 * DBL_EPSILON;

typedef struct drift {
  dls_global *global;
  dlsi_system *null; /* K + 1e-8 e */
  double *q, *x;     /* of the splitting: kept here */
  double *b, *y, *a; /* n */
} drift;

/* (GM3) */
static dls_status drift_clean(drift *D, dls_error *error) {
  const dls_global *work = D->global;
  double *b = D->b;
  dls_status status = DLS_OK;
  for (int turn = 0; !status && turn < times; turn++) {
    dlsi_body_multiply(&work->model, b, D->y, NULL);
    status = dlsi_system_solve(D->null, D->y, error);
    for (int j = 0; j < work->n; j++)
      b[j] -= D->y[j];
  }
  return status;
}

/* Scales b to 1 at its largest entry and stops the bodies that hardly move. Returns 0 for b = 0. */
static int drift_scale(drift *D, int *mover) {
  const dls_global *work = D->global;
  double most_b = 0, *size = D->y;
  for (int j = 0; j < work->n; j++)
    size[j] = 0;
  for (int j = 0; j < work->n; j++) {
    if (fabs(D->b[j]) > size[work->part[j]]) size[work->part[j]] = fabs(D->b[j]);
    if (!(fabs(D->b[j]) <= most_b)) {
      most_b = fabs(D->b[j]);
      *mover = work->part[j];
    }
  }
  if (!(most_b > 0 && most_b <= DBL_MAX)) return 0;
  for (int j = 0; j < work->n; j++)
    D->b[j] = size[work->part[j]] > still * most_b ? D->b[j] / most_b : 0;
  for (int j = work->n; j-- > 0;) /* the first unknown of the body */
    if (work->part[j] == *mover) D->a[0] = j;
  *mover = (int)D->a[0];
  return 1;
}

/* (GM4) */
static int drift_proves(drift *D) {
  const dls_global *work = D->global;
  const dlsi_columns *H = &work->H;
  const size_t n = (size_t)work->n;
  const int d = work->d;
  double load = 0, turmoil = 0;
  dlsi_body_multiply(&work->model, D->b, D->y, D->a);
  for (size_t j = 0; j < n; j++) {
    if (!(fabs(D->y[j]) <= slack * D->a[j])) return 0;
    load += D->b[j] * (work->f ? work->f[j] : 0);
    turmoil += fabs(D->b[j] * (work->f ? work->f[j] : 0));
  }
  if (!(load > slack * (double)n * turmoil)) return 0;
  for (int c = 0; c < work->nc; c++) {
    double h[3] = {0}, a[3] = {0};
    for (int i = 0; i < d; i++)
      for (int k = H->p[d * c + i]; k < H->p[d * c + i + 1]; k++) {
        h[i] += H->x[k] * D->b[H->i[k]];
        a[i] += fabs(H->x[k] * D->b[H->i[k]]);
      }
    const double t = dlsi_tangent_norm(d, h), at = dlsi_tangent_norm(d, a);
    if (dlsi_is_bonded(work->bend[c])) {
      if (!(h[0] >= -slack * a[0] && t <= slack * at)) return 0;
    } else if (!(h[0] - work->bend[c] * t >= -slack * (a[0] + work->bend[c] * at)))
      return 0;
  }
  return 1;
}

/* (GM2) r := the projection of q on the cones. */
static void drift_project(const dls_global *work, const double *q, double *r) {
  for (int c = 0; c < work->nc; c++)
    (void)dlsi_project_cone(work->d, work->bend[c], q + work->d * c, r + work->d * c);
}

static dls_status drift_run(drift *D, int *proved, dls_error *error) {
  dls_global *work = D->global;
  const size_t n = (size_t)work->n;
  for (int k = 1; k <= most && !*proved; k++) {
    const int look = k % try_every == 0;
    drift_project(work, D->q, work->r);
    if (look) memcpy(D->b, work->x, n * sizeof *D->b);
    const dls_status status = dlsi_global_step(work, work->r, D->q, NULL, error);
    if (status) return status;
    for (int i = 0; i < work->m; i++)
      D->q[i] = work->r[i] - work->rho * (work->u[i] - work->g[i]);
    if (!look) continue;
    const dls_status told = dlsi_tell(work->limits, work->begun,
                                      &(dls_progress){.method = "global",
                                                      .stage = "motion",
                                                      .iteration = k,
                                                      .max_iterations = most,
                                                      .residual = work->best.residual,
                                                      .r = work->best_r});
    if (told) return told;
    int mover = 0;
    for (size_t j = 0; j < n; j++)
      D->b[j] = work->x[j] - D->b[j];
    dls_status cleaned = drift_clean(D, error);
    if (cleaned) return cleaned;
    if (!drift_scale(D, &mover) || !drift_proves(D)) continue;
    *proved = 1;
    work->moves = 1;
    work->mover = mover;
    memcpy(work->motion, D->b, n * sizeof *D->b);
  }
  return DLS_OK;
}

dls_status dlsi_global_prove(dls_global *work, int *proved, dls_error *error) {
  const size_t n = (size_t)work->n, m = (size_t)work->m;
  const dls_sparse none = {.rows = work->n, .p = (const int[]){0}};
  drift D = {.global = work};
  *proved = 0;
  if (work->model.factorization == DLS_LU) return DLS_OK;
  double *memory = dlsi_alloc(4 * n + m, sizeof *memory);
  dls_status status = memory ? DLS_OK : dlsi_no_memory(error);
  if (!status) status = dlsi_system_create(&D.null, &work->model, &none, error);
  if (!status) {
    D.x = memory;
    D.b = memory + n;
    D.y = memory + 2 * n;
    D.a = memory + 3 * n;
    D.q = memory + 4 * n;
    memcpy(D.x, work->x, n * sizeof *D.x);
    memcpy(D.q, work->q, m * sizeof *D.q);
    D.null->hold = soft;
    status = dlsi_system_factor(D.null, 0, error);
    work->factorisations++;
    if (!status) status = drift_run(&D, proved, error);
    memcpy(work->x, D.x, n * sizeof *D.x);
  }
  dlsi_system_destroy(D.null);
  free(memory);
  return status;
}
