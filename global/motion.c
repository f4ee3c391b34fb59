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
 *   (GM3)  Bodies that hardly move stand still, b := 0. Then three times
 *            | K + 1e-8 e   -G    | |db|     | K b   |        b := b + db
 *            | G^T          delta | |y | = - | G^T b |
 *          G: the rows that hold with equality: (H^T b)_c = 0 where it is small, (H^T b)_n = mu
 *          |(H^T b)_t| where the difference is. Rounding divided by 1e-8 is small beside db only:
 *          each turn has a smaller one.
 *   (GM4)  (GM1) by the user's numbers: |K b|_i <= 100 eps (|K||b|)_i; b^T f above its rounding;
 *          the cones within 100 eps |H|^T times the largest motion of each body, to which b
 *          is rounded
 *
 * Source of (GM2): Banjac, Goulart, Stellato and Boyd, J. Optim. Theory Appl. 183, 2019, 490-519.
 * Cost: up to `most` solves with the factor of A, an LU for each turn of (GM3). What can fail: forces that
 * balance on the boundary of the cones alone; a drift that converges slowly. Nothing is proved then.
 */
#include <stdlib.h>
#include <string.h>

#include "global_internal.h"

enum { most = 1000, try_every = 20, turns = 3, most_tries = 5 };

static const double soft = 1e-8, delta = 1e-9;
static const double still = 1e-2; /* of the largest motion: no motion */
static const double small = 1e-3; /* of |H|^T |b|, |K||b|: to be made 0 */
static const double slack = 100 * DBL_EPSILON;

typedef struct drift {
  dls_global *global;
  double scale;      /* the largest size of drift_misses */
  double *q, *x;     /* of the splitting, kept here: m, n */
  double *b, *y, *a; /* b; scratch: n, n + m, n */
  double *size;      /* n: the largest |b| of each connected body, 0 where it stands still */
  dlsi_triplets t;   /* of (GM3) */
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
    D->size[p] = D->size[p] > still * largest ? D->size[p] / largest : 0;
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
  const double scale = small * dlsi_max_abs(D->a, (size_t)work->n);
  for (int j = 0; j < work->n; j++) {
    if (!(fabs(D->y[j]) <= scale)) return 0;
    load += D->b[j] * (work->f ? work->f[j] : 0);
  }
  for (int c = 0; c < work->nc; c++) {
    double h[3], size;
    if (!(drift_misses(D, c, h, &size) <= small * D->scale)) return 0;
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
    if (fabs(h[0]) + t <= small * D->scale || dlsi_is_bonded(mu)) {
      for (int i = h[0] > small * D->scale; i < d; i++, rows++) {
        const double unit[3] = {i == 0, i == 1, i == 2};
        D->y[rows] = -drift_row(D, c, unit, h, rows);
      }
    } else if (fabs(miss) <= small * D->scale) {
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

/* (GM4) */
static int drift_proves(drift *D) {
  const dls_global *work = D->global;
  const size_t n = (size_t)work->n;
  double load = 0, turmoil = 0;
  dlsi_body_multiply(&work->model, D->b, D->y, D->a);
  for (size_t j = 0; j < n; j++) {
    if (!(fabs(D->y[j]) <= slack * D->a[j])) return 0;
    load += D->b[j] * (work->f ? work->f[j] : 0);
    turmoil += fabs(D->b[j] * (work->f ? work->f[j] : 0));
  }
  if (!(load > 1e-10 * turmoil)) return 0;
  for (int c = 0; c < work->nc; c++) {
    double h[3], size;
    if (!(drift_misses(D, c, h, &size) <= slack * size)) return 0;
  }
  return 1;
}

/* Takes the drift for b and tries to prove by it. */
static dls_status drift_try(drift *D, int *tries, int *proved, dls_error *error) {
  dls_global *work = D->global;
  dls_error why = {0};
  const int mover = drift_scale(D);
  {
    extern int printf(const char *, ...);
    double v = 0, kb = 0, load = 0;
    dlsi_body_multiply(&work->model, D->b, D->y, D->a);
    double sc = dlsi_max_abs(D->a, (size_t)work->n);
    for (size_t j = 0; j < (size_t)work->n; j++) {
      load += D->b[j] * work->f[j];
      if (fabs(D->y[j]) > kb * sc) kb = fabs(D->y[j]) / sc;
    }
    for (int c = 0; c < work->nc; c++) {
      double h[3], z;
      double t = drift_misses(D, c, h, &z);
      if (t > v * z) v = t / z;
    }
    printf("mover %d load %.3e Kb %.1e viol %.3e\n", mover, load, kb, v);
  }
  if (mover < 0 || *tries == most_tries || !drift_is_near(D)) return DLS_OK;
  ++*tries;
  const dls_status status = drift_clean(D, &why);
  if (status == DLS_E_SINGULAR || status == DLS_E_UNSUPPORTED) return DLS_OK;
  if (status) {
    if (error) *error = why;
    return status;
  }
  {
    extern int printf(const char *, ...);
    double v = 0, kb = 0, load = 0;
    dlsi_body_multiply(&work->model, D->b, D->y, D->a);
    for (size_t j = 0; j < (size_t)work->n; j++) {
      load += D->b[j] * work->f[j];
      if (fabs(D->y[j]) > kb * D->a[j]) kb = fabs(D->y[j]) / D->a[j];
    }
    for (int c = 0; c < work->nc; c++) {
      double h[3], z;
      double t = drift_misses(D, c, h, &z);
      if (t > v * z) {
        v = t / z;
      }
      if (t > 1e-13 * z)
        printf("c %d miss %.2e size %.1e h %.3e %.3e %.3e\n", c, t, z, h[0], h[1], h[2]);
    }
    printf("AFTER load %.3e Kb %.1e viol %.3e\n", load, kb, v);
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

static dls_status drift_run(drift *D, int *proved, dls_error *error) {
  dls_global *work = D->global;
  const size_t n = (size_t)work->n;
  int tries = 0;
  dls_status status = DLS_OK;
  for (int k = 1; !status && k <= most && !*proved; k++) {
    const int look = k % try_every == 0;
    drift_project(work, D->q, work->r);
    if (look) memcpy(D->b, work->x, n * sizeof *D->b);
    status = dlsi_global_step(work, work->r, D->q, NULL, error);
    if (status) break;
    for (int i = 0; i < work->m; i++)
      D->q[i] = work->r[i] - work->rho * (work->u[i] - work->g[i]);
    if (!look) continue;
    for (size_t j = 0; j < n; j++)
      D->b[j] = work->x[j] - D->b[j];
    status = drift_try(D, &tries, proved, error);
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

dls_status dlsi_global_prove(dls_global *work, int *proved, dls_error *error) {
  const size_t n = (size_t)work->n, m = (size_t)work->m;
  const size_t entries = 2 * (size_t)work->K.p[n] + n + m + 4 * (size_t)work->H.p[m];
  drift D = {.global = work};
  *proved = 0;
  if (work->model.factorization == DLS_LU) return DLS_OK;
  double *memory = dlsi_alloc(5 * n + 2 * m, sizeof *memory);
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
    memcpy(D.x, work->x, n * sizeof *D.x);
    memcpy(D.q, work->q, m * sizeof *D.q);
    status = drift_run(&D, proved, error);
    memcpy(work->x, D.x, n * sizeof *D.x);
  }
  dlsi_general_free(&D.general);
  dlsi_triplets_free(&D.t);
  free(memory);
  return status;
}
