/*
 * interior.c: the convex problem on K by an interior point, d = 2 and 3.
 *
 *   (GI1)  min x^T K x / 2 + hold x^T E x / 2 - f^T x,  H^T x + g in the dual cones:
 *          (K + hold E) x = f + H r,  z = H^T x + g,  r in the friction cones, r.z = 0
 *
 *   or x - old in place of the second x. That is the law if g holds s = mu |u_t|. Without g the
 *   loads of joints are 0, too. E is that of system.c, 0 at multipliers. Scales S make the cones
 *   Lorentz cones: r = S p,  S z:  S_n = 1 / sqrt(1 + mu^2), S_t = mu S_n, mu at most 1e4. Below,
 *   z, g and H^T contain S.
 *
 *   (GI2)  P with l = P p = P^-1 z (contact/cone.h). A direction for a right-hand side rc, with
 *          v = l \ rc and e = z - H^T x - g:
 *          (K + hold E + H P^-2 H^T) dx = f + H p - (K + hold E) x + H (P^-1 v + P^-2 e)
 *          dz = H^T dx - e,  dp = P^-1 v - P^-2 dz
 *   (GI3)  affine:   rc = - l o l, largest step a; sigma = max((1 - a)^3, 1e-3)
 *          combined: rc = sigma tau e - l o l - (P dp) o (P^-1 dz), dp and dz the affine ones,
 *          tau = p.z / nc. If its step is below .1: without the last term, sigma >= .5
 *   (GI4)  x, p, z += .99 times the largest step, at most 1
 *   (GI5)  ends when p.z is 1e-14 of f^T x or of the first p.z, or after 60 iterations
 *   (GI6)  K = 0, r wanted: ends, too, if 10 iterations have not taken a tenth off p.z. P^-2 has
 *          entries of 1e-7 to 1e7 at the end, and its rounding leaves f + H r at 1e-8 of f. So
 *          twice, D = r_n over the largest r_n at each contact:
 *          (hold E + H D H^T) y = f + H r,  r -= D H^T y
 *
 * Source: as vi/split/rest.c (AR7)-(AR9), the same method on W.
 * Cost: an analysis, 10 to 40 factorisations of a matrix with the entries of K + H R H^T, three
 * solves each. Fails: a matrix that is singular to rounding, or steps that become short. Then it
 * returns DLS_STALLED and keeps the last x.
 */
#include <stdlib.h>
#include <string.h>

#include "contact/cone.h"
#include "global_internal.h"
#include "linear/dissection.h"

enum { most_points = 60, stuck_every = 10, balances = 2 };

static const double to_boundary = 0.99, short_step = 0.1, least_step = 1e-8;
static const double largest_mu = 1e4, done = 1e-14, stuck = 0.9;

typedef struct interior {
  dls_global *global;
  double hold;
  int rests;             /* 1: (GI6) */
  const double *old, *g; /* n, m; NULL: 0 */
  double *x, *dx, *rest; /* n; rest: f + H p - (K + hold E) x */
  double *e;             /* n: hold E with its sign */
  double *S;             /* 2 nc */
  double *p, *z;         /* m, as all below */
  double *dp, *dz, *ap, *az, *w, *lambda, *rc, *miss, *h;
  double *B;      /* d m: S P^-2 S by blocks */
  double *eta;    /* nc */
  int *row, *col; /* entries, counted from 1: of K, of the contacts, of E */
  double *value;
  size_t entries;
  dlsi_cholesky *cholesky; /* NULL where A is not definite */
  dlsi_general general;
} interior;

/* ---- the matrix ------------------------------------------------------------------------------ */

/* Lists the entries of H B H^T, B: d x d blocks (NULL: 0), lower triangle. row NULL: counts. */
static size_t interior_list(const dls_global *work, const double *B, int *row, int *col,
                            double *value) {
  const dlsi_columns *H = &work->H;
  const int d = work->d;
  size_t count = 0;
  for (int c = 0; c < work->nc; c++)
    for (int i = d * c; i < d * c + d; i++)
      for (int j = d * c; j < d * c + d; j++)
        for (int a = H->p[i]; a < H->p[i + 1]; a++)
          for (int b = H->p[j]; b < H->p[j + 1]; b++) {
            if (H->i[a] < H->i[b]) continue;
            if (row) {
              row[count] = H->i[a] + 1;
              col[count] = H->i[b] + 1;
            }
            if (B) value[count] = H->x[a] * B[d * i + j - d * c] * H->x[b];
            count++;
          }
  return count;
}

static dls_status interior_analyse(interior *I, dls_error *error) {
  const size_t n = (size_t)I->global->n;
  dls_error why = {0};
  int *order = dlsi_alloc(2 * n, sizeof *order), *turn = order + n;
  if (!order) return dlsi_no_memory(error);
  dls_status status = dlsi_dissection((int)n, I->entries, I->row, I->col, order, &why);
  for (size_t k = 0; k < n; k++)
    turn[status ? k : (size_t)order[k]] = (int)k + 1;
  if (status == DLS_E_UNSUPPORTED)
    status = DLS_OK;
  else if (status && error)
    *error = why;
  if (!status)
    status = dlsi_cholesky_create(&I->cholesky, (int)n, I->entries, I->row, I->col, turn, 0, error);
  free(order);
  return status;
}

static dls_status interior_matrix(interior *I, dls_error *error) {
  const dls_global *work = I->global;
  const dls_sparse *K = &work->model.Ks;
  const size_t n = (size_t)work->n, of_K = (size_t)K->p[n];
  const size_t of_H = interior_list(work, NULL, NULL, NULL, NULL);
  I->entries = of_K + of_H + n;
  I->row = dlsi_alloc(2 * I->entries, sizeof *I->row);
  I->value = dlsi_alloc(I->entries, sizeof *I->value);
  if (!I->row || !I->value) return dlsi_no_memory(error);
  I->col = I->row + I->entries;
  for (int j = 0; j < work->n; j++) {
    for (int k = K->p[j]; k < K->p[j + 1]; k++) {
      I->row[k] = K->i[k] + 1;
      I->col[k] = j + 1;
      I->value[k] = K->x[k];
    }
    const size_t at = of_K + of_H + (size_t)j;
    I->row[at] = I->col[at] = j + 1;
    I->value[at] = I->e[j] = I->hold * work->system->e[j];
  }
  (void)interior_list(work, NULL, I->row + of_K, I->col + of_K, NULL);
  return work->system->definite ? interior_analyse(I, error) : DLS_OK;
}

static dls_status interior_lu(interior *I, dls_error *error) {
  const int n = I->global->n;
  dlsi_triplets t;
  dls_status status = dlsi_triplets_alloc(n, n, 2 * I->entries, &t, error);
  for (size_t k = 0; !status && k < I->entries; k++) {
    const int i = I->row[k] - 1, j = I->col[k] - 1;
    dlsi_triplets_add(&t, i, j, I->value[k]);
    if (i != j) dlsi_triplets_add(&t, j, i, I->value[k]);
  }
  if (!status) status = dlsi_general_factor(&I->general, &t, error);
  dlsi_triplets_free(&t);
  return status;
}

/* ---- a point --------------------------------------------------------------------------------- */

/* y := S H^T x */
static void interior_look(const interior *I, const double *x, double *y) {
  const dlsi_columns *H = &I->global->H;
  const int d = I->global->d;
  for (int k = 0; k < I->global->m; k++) {
    y[k] = 0;
    for (int e = H->p[k]; e < H->p[k + 1]; e++)
      y[k] += H->x[e] * x[H->i[e]];
    y[k] *= I->S[2 * (k / d) + (k % d > 0)];
  }
}

/* v += H S p; scratch: h */
static void interior_push(interior *I, const double *p, double *v) {
  const int d = I->global->d;
  for (int k = 0; k < I->global->m; k++)
    I->h[k] = I->S[2 * (k / d) + (k % d > 0)] * p[k];
  dlsi_global_push(I->global, I->h, v);
}

/* y := P^-2 x for contact c; y is not x. */
static void interior_square(const interior *I, int c, const double *x, double *y) {
  const int d = I->global->d;
  double v[3];
  dlsi_cone_scale(d, I->eta[c], I->w + d * c, 1, x, v);
  dlsi_cone_scale(d, I->eta[c], I->w + d * c, 1, v, y);
}

/* Factors K + hold E + H B H^T. DLS_E_SINGULAR if a pivot is not positive. */
static dls_status interior_factor(interior *I, dls_error *error) {
  dls_global *work = I->global;
  work->factorisations++;
  (void)interior_list(work, I->B, NULL, NULL, I->value + work->model.Ks.p[work->n]);
  if (!I->cholesky) return interior_lu(I, error);
  double pivot;
  const int failed = dlsi_cholesky_factor(I->cholesky, I->value, &pivot);
  return failed < 0 ? dlsi_no_memory(error) : failed ? DLS_E_SINGULAR : DLS_OK;
}

/* dx := A^-1 dx */
static dls_status interior_solve(interior *I, dls_error *error) {
  return I->cholesky ? dlsi_cholesky_solve(I->cholesky, I->dx, 1, error)
                     : dlsi_general_solve(&I->general, 0, I->dx, error);
}

/* Factors the matrix of (GI2). DLS_E_SINGULAR also if the point has left the cones. */
static dls_status interior_matrix_at(interior *I, dls_error *error) {
  dls_global *work = I->global;
  const int d = work->d;
  for (int c = 0; c < work->nc; c++) {
    const int o = d * c;
    if (!dlsi_cone_between(d, I->p + o, I->z + o, &I->eta[c], I->w + o)) return DLS_E_SINGULAR;
    dlsi_cone_scale(d, I->eta[c], I->w + o, 0, I->p + o, I->lambda + o);
    for (int j = 0; j < d; j++) {
      double unit[3] = {j == 0, j == 1, j == 2}, column[3];
      interior_square(I, c, unit, column);
      for (int i = 0; i < d; i++)
        I->B[d * (o + i) + j] = I->S[2 * c + (i > 0)] * column[i] * I->S[2 * c + (j > 0)];
    }
  }
  return interior_factor(I, error);
}

/* (GI2) *step: the largest step. */
static dls_status interior_direction(interior *I, double *dp, double *dz, double *step,
                                     dls_error *error) {
  dls_global *work = I->global;
  const int d = work->d;
  for (int c = 0; c < work->nc; c++) {
    const int o = d * c;
    double v[3], Pv[3], Pm[3];
    dlsi_cone_divide(d, I->lambda + o, I->rc + o, v);
    dlsi_cone_scale(d, I->eta[c], I->w + o, 1, v, Pv);
    interior_square(I, c, I->miss + o, Pm);
    for (int i = 0; i < d; i++) {
      dp[o + i] = Pv[i];
      dz[o + i] = Pv[i] + Pm[i];
    }
  }
  memcpy(I->dx, I->rest, (size_t)work->n * sizeof *I->dx);
  interior_push(I, dz, I->dx);
  const dls_status status = interior_solve(I, error);
  if (status) return status;
  interior_look(I, I->dx, dz);
  *step = INFINITY;
  for (int c = 0; c < work->nc; c++) {
    const int o = d * c;
    double Pz[3];
    for (int i = 0; i < d; i++)
      dz[o + i] -= I->miss[o + i];
    interior_square(I, c, dz + o, Pz);
    for (int i = 0; i < d; i++)
      dp[o + i] -= Pz[i];
    *step =
        fmin(*step, fmin(dlsi_cone_step(d, I->p + o, dp + o), dlsi_cone_step(d, I->z + o, dz + o)));
  }
  return DLS_OK;
}

/* Sets rc of (GI3); second: 1 with the product of the affine direction. */
static void interior_target(interior *I, double target, int second) {
  dlsi_cone_target(I->global->d, I->global->nc, I->eta, I->w, I->lambda, target,
                   second ? I->ap : NULL, I->az, I->rc);
}

/* (GI3) */
static dls_status interior_step(interior *I, double tau, double *step, dls_error *error) {
  interior_target(I, 0, 0);
  dls_status status = interior_direction(I, I->ap, I->az, step, error);
  double sigma = fmax(pow(1 - fmin(*step, 1), 3), 1e-3);
  *step = 0;
  for (int second = 1; !status && second >= 0 && *step < short_step; second--) {
    if (!second) sigma = fmax(sigma, 0.5);
    interior_target(I, sigma * tau, second);
    status = interior_direction(I, I->dp, I->dz, step, error);
  }
  return status;
}

/* Returns the load of unknown j. */
static double interior_load(const interior *I, int j) {
  const dls_global *work = I->global;
  return !I->g && work->body.joint && work->body.joint[j] ? 0 : work->f[j];
}

/* Starts on the axes of the cones, at `start` times the size of f and g in round variables. */
static void interior_begin(interior *I, double start) {
  const dls_global *work = I->global;
  double size = 0;
  for (int j = 0; j < work->n; j++)
    if (work->system->e[j] > 0) size = hypot(size, interior_load(I, j) / sqrt(work->system->e[j]));
  for (int k = 0; I->g && k < work->m; k++)
    size = hypot(size, I->g[k]);
  if (size == 0) size = 1;
  for (int k = 0; k < work->m; k++)
    I->p[k] = I->z[k] = k % work->d ? 0 : start * size;
  for (int c = 0; c < work->nc; c++) {
    const double mu = fmin(work->bend[c], largest_mu);
    I->S[2 * c] = 1 / sqrt(1 + mu * mu);
    I->S[2 * c + 1] = mu * I->S[2 * c];
  }
}

/* (GI2)-(GI5) DLS_STALLED if p.z has not become that small. */
static dls_status interior_run(interior *I, dls_error *error) {
  dls_global *work = I->global;
  const int n = work->n, m = work->m;
  dls_status status = DLS_OK;
  double first = 0, before = INFINITY;
  for (int k = 0; !status && k < most_points; k++) {
    double tau = 0, load = 0, step;
    dlsi_body_multiply(&work->model, I->x, I->rest, NULL);
    for (int j = 0; j < n; j++) {
      const double f = interior_load(I, j);
      I->rest[j] = f - I->rest[j] - I->e[j] * (I->x[j] - (I->old ? I->old[j] : 0));
      load += f * I->x[j];
    }
    interior_push(I, I->p, I->rest);
    interior_look(I, I->x, I->miss);
    for (int i = 0; i < m; i++) {
      I->miss[i] = I->z[i] - I->miss[i];
      if (I->g) I->miss[i] -= I->S[2 * (i / work->d) + (i % work->d > 0)] * I->g[i];
      tau += I->p[i] * I->z[i];
    }
    if (k == 0) first = tau;
    if (k > 0 && !(tau > done * fmax(fabs(load), first))) return DLS_OK;
    if (I->rests && k % stuck_every == 0) {
      if (tau > stuck * before) break;
      before = tau;
    }
    status = interior_matrix_at(I, error);
    if (!status) status = interior_step(I, tau / work->nc, &step, error);
    if (status) break;
    if (!(step > least_step)) break;
    step = fmin(1, to_boundary * step);
    for (int j = 0; j < n; j++)
      I->x[j] += step * I->dx[j];
    for (int i = 0; i < m; i++) {
      I->p[i] += step * I->dp[i];
      I->z[i] += step * I->dz[i];
    }
    status = dlsi_tell(work->limits, work->begun,
                       &(dls_progress){.method = "global",
                                       .stage = "motion",
                                       .iteration = k + 1,
                                       .max_iterations = most_points,
                                       .residual = work->best.residual,
                                       .r = work->best_r});
  }
  return !status || status == DLS_E_SINGULAR || status == DLS_E_UNSUPPORTED ? DLS_STALLED : status;
}

/* (GI6) */
static dls_status interior_balance(interior *I, double *r, dls_error *error) {
  dls_global *work = I->global;
  const int d = work->d;
  const size_t n = (size_t)work->n;
  double most = 0;
  dls_status status = DLS_OK;
  for (int c = 0; c < work->nc; c++)
    most = fmax(most, r[d * c]);
  if (!(most > 0)) return DLS_OK;
  memset(I->B, 0, (size_t)(d * work->m) * sizeof *I->B);
  for (int k = 0; k < work->m; k++) {
    I->B[d * k + k % d] = fmax(r[k - k % d], 0) / most;
    I->S[2 * (k / d)] = I->S[2 * (k / d) + 1] = 1;
  }
  for (int k = 0; !status && k < balances; k++) {
    memcpy(I->dx, work->f, n * sizeof *I->dx);
    dlsi_global_push(work, r, I->dx);
    if (k == 0) status = interior_factor(I, error);
    if (!status) status = interior_solve(I, error);
    if (status) break;
    interior_look(I, I->dx, I->h);
    for (int i = 0; i < work->m; i++)
      r[i] -= I->B[d * i + i % d] * I->h[i];
  }
  return status == DLS_E_SINGULAR || status == DLS_E_UNSUPPORTED ? DLS_OK : status;
}

dls_status dlsi_global_interior(dls_global *work, double hold, double start, const double *old,
                                const double *g, double *x, double *r, dls_error *error) {
  const size_t n = (size_t)work->n, m = (size_t)work->m, nc = (size_t)work->nc;
  interior I = {.global = work, .hold = hold, .old = old, .g = g, .x = x};
  I.rests = r && dlsi_global_is_rigid(work);
  double *memory = dlsi_alloc(3 * n + (11 + (size_t)work->d) * m + 3 * nc, sizeof *memory);
  if (!memory) return dlsi_no_memory(error);
  double **const of_m[] = {&I.p, &I.z,      &I.dp, &I.dz,   &I.ap, &I.az,
                           &I.w, &I.lambda, &I.rc, &I.miss, &I.h};
  I.dx = memory;
  I.rest = memory + n;
  I.e = memory + 2 * n;
  for (size_t k = 0; k < 11; k++)
    *of_m[k] = memory + 3 * n + k * m;
  I.B = memory + 3 * n + 11 * m;
  I.S = I.B + (size_t)work->d * m;
  I.eta = I.S + 2 * nc;
  memset(x, 0, n * sizeof *x);
  dls_error why = {0};
  interior_begin(&I, start);
  dls_status status = interior_matrix(&I, &why);
  if (!status) status = interior_run(&I, &why);
  for (size_t k = 0; r && k < m; k++)
    r[k] = I.S[2 * (k / (size_t)work->d) + (k % (size_t)work->d > 0)] * I.p[k];
  if (I.rests && (!status || status == DLS_STALLED)) {
    const dls_status balanced = interior_balance(&I, r, &why);
    if (balanced) status = balanced;
  }
  if (status < 0 && error) *error = why;
  dlsi_cholesky_destroy(I.cholesky);
  dlsi_general_free(&I.general);
  free(I.row);
  free(I.value);
  free(memory);
  return status;
}
