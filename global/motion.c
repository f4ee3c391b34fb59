/*
 * motion.c: proves that nothing can hold a body.
 *
 * A motion b of the body with
 *
 *   (GM1)  K b = 0,  b^T f > 0,  (H^T b)_n >= mu |(H^T b)_t| at every contact
 *
 * has b^T (f + H r) > 0 for all r of the friction cones, but b^T K x = 0: there is no equilibrium.
 * By Farkas's lemma there is such a b if no r of the cones balances f, up to closure. The proof
 * needs b^T K = 0: if K is not symmetric, nothing is tried.
 *
 *   (GM2)  b := the solution x of the convex problem without gaps, with springs of 1e-10 of K
 *          (interior.c). If the bodies are held, it is elastic. Else it is 1e10 times as large: of
 *          all rigid motions in the cones the nearest to E^-1 f. Goes on if the springs of some
 *          body hold more than a hundredth of its energy. The interior point starts at the size of
 *          f; if that does not end, at 1e10 times that: contacts that leave many motions free, in
 *          3D above all, move by so much.
 *   (GM3)  Bodies that hardly move stand still, b := 0. Then three times
 *            | K + 1e-10 E  -G    | |db|     | K b   |        b := b + db
 *            | G^T          delta | |y | = - | G^T b |
 *          G: the rows that hold with equality: (H^T b)_c = 0 where it is small, (H^T b)_n = mu
 *          |(H^T b)_t| where the difference is. Each turn removes the elastic part, and has less
 *          rounding than the turn before. The rows of K are scaled by body: K b = 0 stays the same,
 *          and the rounding of a stiff body that moves much disturbs no soft one that moves little.
 *          "Hardly" and "small" are 1e-7, 1e-6, .. 1e-2 of the largest b, until a b proves; after
 *          the first turn "hardly" is 1e-10.
 *   (GM4)  Check (GM1) by the numbers of the user, with b of largest entry 1:
 *            energy   |b^T K b| <= eps |b|^T |K| |b| in each connected body, in long double
 *            forces   |K b|_i <= 1e-12 (|K| |b|)_i
 *            b^T f    more than |b|^T (1e-10 |f'| + 64 eps (|f| + |K||x_own|)), |b| the largest of
 *                     each body; f' = f, x_own = 0 where nothing is split off (loads.c)
 *            cones    within 100 eps of |H|^T |b| of the contact, |b| the largest of each body
 *
 * Why eps: storing an entry of K rounds it by eps / 2 of it, assembling it by as much again. Then
 * b^T K b changes by up to eps |b|^T |K| |b|. Below this limit, some K within the user's rounding
 * has no energy in b; above it, none. The softest bending of a strip of L x 1 squares clamped at
 * one end has 1491 eps for L = 1000, 93 for 2000, 2.3 for 5000. The forces are a second check: by
 * the forces alone the strip of 1000 would pass.
 *
 * Cost: an interior point, 3 to 18 LUs. b depends only on f, K, H, mu: one try per solve.
 * What can fail: forces that balance only on the boundary of the cones, or a structure so slender
 * that its bending is as soft as the springs of (GM2). Then nothing is proved.
 */
#include <stdlib.h>
#include <string.h>

#include "global_internal.h"

enum { turns = 3 };

static const double soft = 1e-10, delta = 1e-9;
static const double share = 1e-2;                          /* (GM2) */
static const double least_small = 1e-7, most_small = 1e-2; /* (GM3) */
static const double least = 1e-10;                         /* (GM3): of b, after a turn */
static const double even = 1e-3; /* (GM3): bodies that move less are scaled as if they moved so */
static const double slack = 100 * DBL_EPSILON, balance = 1e-12; /* (GM4) */
static const double certain = 1e-10; /* of |b|^T |f|: more than what the rounding of b leaves */

typedef struct drift {
  dls_global *global;
  double small;        /* fraction of the largest motion that counts as 0 */
  double *sums;        /* 2 n */
  double scale;        /* the largest size of drift_misses */
  long double *energy; /* 2 parts */
  double *x;           /* of (GM2): n */
  double *b, *y, *a;   /* b; scratch: n, n + m, n */
  double *size;        /* n: the largest |b| of each connected body, 0 where it stands still */
  dlsi_triplets t;     /* of (GM3) */
  dlsi_general general;
} drift;

/* Returns 1 if unknown j is a multiplier: a force, 0 in a motion. */
static int drift_is_force(const drift *D, int j) {
  return D->global->body.joint && D->global->body.joint[j];
}

/* h := (H^T b)_c; a: what it rounds relative to, |H|^T times the largest motion of the body. */
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

/* Returns by how much contact c misses its cone: mu |h_t| - h_n, or the larger of -h_n and |h_t| if
 * bonded; *size: the size of the numbers that give it. */
static double drift_misses(const drift *D, int c, double *h, double *size) {
  const double mu = D->global->bend[c];
  double a[3];
  drift_at(D, c, h, a);
  const double t = dlsi_tangent_norm(D->global->d, h), at = dlsi_tangent_norm(D->global->d, a);
  *size = a[0] + (dlsi_is_bonded(mu) ? at : mu * at);
  return dlsi_is_bonded(mu) ? fmax(-h[0], t) : mu * t - h[0];
}

/* Scales b to 1 at its largest entry and stops the bodies that move by less than `small` of it.
 * Returns the body that moves most, -1 for b = 0. */
static int drift_scale(drift *D, double small) {
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
    D->size[p] = D->size[p] > small * largest ? D->size[p] / largest : 0;
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

/* Adds row e^T H_c^T of G to the matrix, as its unknown `at`; returns e^T (H^T b)_c. */
static double drift_row(drift *D, int c, const double *e, const double *h, int at) {
  const dls_global *work = D->global;
  const dlsi_columns *H = &work->H;
  const int from = H->p[work->d * c], end = H->p[work->d * c + work->d];
  const double unit = dlsi_max_abs(H->x + from, (size_t)(end - from));
  double sum = 0;
  for (int i = 0; i < work->d; i++) {
    sum += e[i] / unit * h[i];
    for (int k = H->p[work->d * c + i]; e[i] != 0 && k < H->p[work->d * c + i + 1]; k++) {
      if (D->size[work->part[H->i[k]]] == 0) continue;
      dlsi_triplets_add(&D->t, H->i[k], at, -e[i] / unit * H->x[k]);
      dlsi_triplets_add(&D->t, at, H->i[k], e[i] / unit * H->x[k]);
    }
  }
  dlsi_triplets_add(&D->t, at, at, delta);
  return sum;
}

/* Fills the matrix of (GM3), and y with its right side. */
static void drift_assemble(drift *D) {
  const dls_global *work = D->global;
  const dls_sparse *K = &work->model.Ks;
  const int n = work->n, d = work->d;
  int rows = n;
  D->t.count = 0;
  dlsi_body_multiply(&work->model, D->b, D->y, NULL);
  memset(D->sums, 0, (size_t)n * sizeof *D->sums);
  for (int j = 0; j < n; j++)
    D->sums[work->part[j]] = fmax(D->sums[work->part[j]], work->system->e[j]);
  for (int j = 0; j < n; j++) {
    const double size = D->size[work->part[j]], unit = fmax(size, even) * D->sums[work->part[j]];
    D->y[j] = size > 0 ? -D->y[j] / unit : 0;
    dlsi_triplets_add(&D->t, j, j,
                      size > 0 ? soft * (work->system->e[j] / D->sums[work->part[j]]) : 1);
    for (int k = K->p[j]; size > 0 && k < K->p[j + 1]; k++) {
      dlsi_triplets_add(&D->t, K->i[k], j, K->x[k] / unit);
      if (K->i[k] != j) dlsi_triplets_add(&D->t, j, K->i[k], K->x[k] / unit);
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
    if (drift_scale(D, turn ? least : D->small) < 0) return DLS_OK;
    drift_assemble(D);
    status = dlsi_general_factor(&D->general, &D->t, error);
    D->global->factorisations++;
    if (!status) status = dlsi_general_solve(&D->general, 0, D->y, error);
    for (int j = 0; !status && j < D->global->n; j++)
      if (D->size[D->global->part[j]] > 0 && !drift_is_force(D, j)) D->b[j] += D->y[j];
  }
  return status;
}

/* (GM4) Returns 1 if |b^T K b| <= eps |b|^T |K| |b| in each connected body. */
static int drift_is_soft(const drift *D) {
  const dls_global *work = D->global;
  const dls_sparse *K = &work->model.Ks;
  long double *sums = D->energy;
  memset(sums, 0, 2 * (size_t)work->body.parts * sizeof *sums);
  for (int j = 0; j < work->n; j++)
    for (int k = K->p[j]; k < K->p[j + 1]; k++) {
      const long double e = (K->i[k] == j ? 1 : 2) * (long double)D->b[j] * K->x[k] * D->b[K->i[k]];
      sums[2 * work->part[j]] += e;
      sums[2 * work->part[j] + 1] += fabsl(e);
    }
  for (int p = 0; p < work->body.parts; p++)
    if (!(fabsl(sums[2 * p]) <= DBL_EPSILON * sums[2 * p + 1])) return 0;
  return 1;
}

/* (GM4) */
static int drift_proves(drift *D) {
  const dls_global *work = D->global;
  const size_t n = (size_t)work->n;
  long double load = 0;
  double turmoil = 0;
  dlsi_body_multiply(&work->model, D->b, D->y, D->a);
  for (size_t j = 0; j < n; j++)
    if (!(fabs(D->y[j]) <= balance * D->a[j])) return 0;
  dlsi_body_multiply(&work->model, work->own, D->y, D->a);
  for (size_t j = 0; j < n; j++) {
    const double f = work->given ? work->given[j] : 0;
    if (drift_is_force(D, (int)j)) continue;
    load += (long double)D->b[j] * f;
    turmoil += D->size[work->part[j]] *
               (certain * fabs(work->f[j]) + 64 * DBL_EPSILON * (fabs(f) + D->a[j]));
  }
  if (!(load > turmoil) || !drift_is_soft(D)) return 0;
  for (int c = 0; c < work->nc; c++) {
    double h[3], size;
    if (!(drift_misses(D, c, h, &size) <= slack * size)) return 0;
  }
  return 1;
}

/* Returns 1 if x of (GM2) has more energy in the springs of some body than in itself. */
static int drift_is_rigid(const drift *D) {
  const dls_global *work = D->global;
  memset(D->sums, 0, 2 * (size_t)work->n * sizeof *D->sums);
  dlsi_body_multiply(&work->model, D->x, D->y, NULL);
  for (int j = 0; j < work->n; j++) {
    const double e = soft * work->system->e[j];
    D->sums[2 * work->part[j]] += D->x[j] * D->y[j];
    D->sums[2 * work->part[j] + 1] += D->x[j] * e * D->x[j];
  }
  for (int p = 0; p < work->body.parts; p++)
    if (D->sums[2 * p + 1] > share * fabs(D->sums[2 * p])) return 1;
  return 0;
}

/* (GM3), (GM4) Takes x of (GM2) for b and tries to prove by it, with D->small. */
static dls_status drift_try(drift *D, int *proved, dls_error *error) {
  dls_global *work = D->global;
  dls_error why = {0};
  for (int j = 0; j < work->n; j++)
    D->b[j] = drift_is_force(D, j) ? 0 : D->x[j];
  const dls_status status = drift_clean(D, &why);
  if (status == DLS_E_SINGULAR || status == DLS_E_UNSUPPORTED) return DLS_OK;
  if (status) {
    if (error) *error = why;
    return status;
  }
  const int mover = drift_scale(D, least);
  if (mover < 0 || !drift_proves(D)) return DLS_OK;
  *proved = work->moves = 1;
  for (int j = work->n; j-- > 0;)
    if (work->part[j] == mover) work->mover = j;
  memcpy(work->motion, D->b, (size_t)work->n * sizeof *D->b);
  return DLS_OK;
}

/* (GM2)-(GM4) from points of this size. DLS_STALLED if that has not ended and proves nothing. */
static dls_status drift_from(drift *D, double start, int *proved, dls_error *error) {
  const dls_status ended =
      dlsi_global_interior(D->global, soft, start, NULL, NULL, D->x, NULL, error);
  if (ended && ended != DLS_STALLED) return ended;
  dls_status status = DLS_OK;
  D->small = least_small;
  for (int rigid = drift_is_rigid(D); rigid && !status && !*proved && D->small < 2 * most_small;
       D->small *= 10)
    status = drift_try(D, proved, error);
  return status || *proved ? status : ended;
}

dls_status dlsi_global_prove(dls_global *work, int *proved, dls_error *error) {
  const size_t n = (size_t)work->n, m = (size_t)work->m;
  const size_t entries = 2 * (size_t)work->model.Ks.p[n] + n + m + 4 * (size_t)work->H.p[m];
  drift D = {.global = work};
  *proved = 0;
  if (work->prove) return work->prove(work->prover, proved, error);
  if (work->model.factorization == DLS_LU || !work->system) return DLS_OK;
  double *memory = calloc(7 * n + m + 1, sizeof *memory);
  dls_status status =
      dlsi_triplets_alloc(work->n + work->m, work->n + work->m, entries, &D.t, error);
  D.energy = dlsi_alloc(2 * (size_t)work->body.parts, sizeof *D.energy);
  if (!status && (!memory || !D.energy)) status = dlsi_no_memory(error);
  if (!status) {
    D.x = memory;
    D.b = memory + n;
    D.a = memory + 2 * n;
    D.size = memory + 3 * n;
    D.sums = memory + 4 * n;
    D.y = memory + 6 * n;
    status = drift_from(&D, 1, proved, error);
    if (status == DLS_STALLED) status = drift_from(&D, 1 / soft, proved, error);
    if (status == DLS_STALLED) status = DLS_OK;
  }
  dlsi_general_free(&D.general);
  dlsi_triplets_free(&D.t);
  free(memory);
  free(D.energy);
  return status;
}
