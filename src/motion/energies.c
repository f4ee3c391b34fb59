/*
 * energies.c: energies, works, and the two identities that a step meets to rounding.
 *
 *   E = (v.M v + x.K x) / 2
 *   E+ - E = (1/2 - theta)(|dv|_M^2 + |dx|_K^2) - h v_th.C v_th + h f.v_th + p.(H^T v_th)
 *   M dv = h (f - C v_th - K x_th) + H p          v_th = theta v+ + (1 - theta) v, x_th alike
 * H^T v_th = u_th + y' splits the work of the reactions: normal (impact), tangential (friction) and
 * that of the obstacle. On a path, where dx replaces dv and there is no M:
 *
 *   E+ - E = f.dx + r.(H^T dx) - |dx|_K^2 / 2,    K x+ = f + H r,   H^T dx = u + h y'
 *
 * Each is recomputed from M, C, K, H, so that an error of the solve shows. Cost: four products.
 */
#include <math.h>
#include <string.h>

#include "motion/motion_internal.h"

static double energies_dot(const double *x, const double *y, size_t n) {
  double sum = 0;
  for (size_t i = 0; i < n; i++)
    sum += x[i] * y[i];
  return sum;
}

/* Returns |x|.a. */
static double energies_size(const double *x, const double *a, size_t n) {
  double sum = 0;
  for (size_t i = 0; i < n; i++)
    sum += fabs(x[i]) * a[i];
  return sum;
}

static void energies_enlarge(double *scale, double size) {
  if (!(size <= *scale)) *scale = size;
}

void dlsi_motion_weigh(dls_motion *motion, motion_point *point) {
  dls_motion_energies *e = &point->energies;
  const size_t n = motion->n;
  dlsi_motion_multiply(motion, &motion->model.K, point->x, point->kx, motion->yabs);
  e->elastic = energies_dot(point->x, point->kx, n) / 2;
  double size = energies_size(point->x, motion->yabs, n) / 2;
  if (motion->settings.law == DLS_MOTION_PATH)
    e->kinetic = 0;
  else {
    dlsi_motion_multiply(motion, &motion->model.M, point->v, motion->yn, motion->yabs);
    e->kinetic = energies_dot(point->v, motion->yn, n) / 2;
    size += energies_size(point->v, motion->yabs, n) / 2;
  }
  energies_enlarge(&e->scale, size);
}

/* Adds factor A x to motion->b and its absolute terms to motion->sum. */
static void momentum_add(dls_motion *motion, const dls_sparse *A, double factor, const double *x) {
  if (!dlsi_motion_has(A)) return;
  dlsi_motion_multiply(motion, A, x, motion->yn, motion->yabs);
  for (size_t i = 0; i < motion->n; i++) {
    motion->b[i] += factor * motion->yn[i];
    motion->sum[i] += fabs(factor) * motion->yabs[i];
  }
}

/* Overwrites b, sum, yn, yabs, z. */
double dlsi_motion_momentum(dls_motion *motion, const double *f, const double *dv) {
  const dls_motion_model *model = &motion->model;
  const motion_point *now = &motion->now, *next = &motion->next;
  const int path = motion->settings.law == DLS_MOTION_PATH;
  const double h = path ? 1 : motion->settings.h, theta = path ? 1 : motion->settings.theta;
  const size_t n = motion->n;
  for (size_t i = 0; i < n; i++) {
    motion->b[i] = f ? h * f[i] : 0;
    motion->sum[i] = fabs(motion->b[i]);
  }
  dlsi_motion_push(motion, next->p, motion->b, motion->sum);
  momentum_add(motion, &model->M, -1, dv);
  for (size_t i = 0; i < n; i++)
    motion->z[i] = now->v[i] + theta * dv[i];
  momentum_add(motion, &model->C, -h, motion->z);
  for (size_t i = 0; i < n; i++)
    motion->z[i] = theta * next->x[i] + (1 - theta) * now->x[i];
  momentum_add(motion, &model->K, -h, motion->z);
  const double scale = dlsi_max_abs(motion->sum, n);
  return scale > 0 ? dlsi_max_abs(motion->b, n) / scale : 0;
}

static const double made_rounds = 1e-12; /* part of its terms */

/* The works of a step. */
typedef struct step_work {
  double load, damping, obstacle, friction, impact, numerical;
  double contact; /* the sum of |terms| of friction and impact */
} step_work;

/* Sets the works of the reactions. y: d nodes. */
static void work_of_reactions(dls_motion *motion, const double *y, step_work *work) {
  const motion_point *next = &motion->next;
  const int path = motion->settings.law == DLS_MOTION_PATH;
  const double theta = path ? 1 : motion->settings.theta, h = path ? motion->settings.h : 1;
  const size_t d = (size_t)motion->model.d;
  dlsi_motion_gather(motion, y, motion->mc);
  for (size_t k = 0; k < motion->m; k++) {
    const double p = next->p[k], before = path ? 0 : (1 - theta) * motion->uc[k];
    work->obstacle += p * h * motion->mc[k];
    *(k % d == 0 ? &work->impact : &work->friction) += p * (theta * next->u[k] + before);
    work->contact += fabs(p) * (theta * fabs(next->u[k]) + fabs(before));
  }
}

/* Sets the other works. dv: n. */
static void work_inside(dls_motion *motion, const double *f, const double *dv, step_work *work) {
  const motion_point *now = &motion->now, *next = &motion->next;
  const int path = motion->settings.law == DLS_MOTION_PATH;
  const double h = motion->settings.h, theta = motion->settings.theta;
  const size_t n = motion->n;
  double bend = 0;
  for (size_t i = 0; i < n; i++) {
    motion->z[i] = path ? dv[i] : h * (now->v[i] + theta * dv[i]); /* the path that loads work on */
    bend += (next->x[i] - now->x[i]) * (next->kx[i] - now->kx[i]);
  }
  work->load = f ? energies_dot(f, motion->z, n) : 0;
  if (path) {
    work->numerical = -bend / 2;
    return;
  }
  dlsi_motion_multiply(motion, &motion->model.C, motion->z, motion->yn, NULL);
  work->damping = -energies_dot(motion->z, motion->yn, n) / h;
  dlsi_motion_multiply(motion, &motion->model.M, dv, motion->yn, NULL);
  work->numerical = (0.5 - theta) * (energies_dot(dv, motion->yn, n) + bend);
}

void dlsi_motion_account(dls_motion *motion, const double *f, const double *y, const double *dv) {
  const dls_motion_energies *before = &motion->now.energies;
  motion_point *next = &motion->next;
  dls_motion_energies *e = &next->energies;
  *e = *before;
  dlsi_motion_weigh(motion, next);
  e->momentum = dlsi_motion_momentum(motion, f, dv);
  const double way = motion->settings.law == DLS_MOTION_PATH ? 1 : motion->settings.h;
  step_work work = {0};
  work_of_reactions(motion, y, &work);
  work_inside(motion, f, dv, &work);
  e->load += work.load;
  e->damping += work.damping;
  e->obstacle += work.obstacle;
  e->friction += work.friction;
  e->impact += work.impact;
  const double made = work.friction + work.impact;
  if (motion->settings.law != DLS_MOTION_PATH && made > made_rounds * work.contact)
    e->created += made;
  e->numerical += work.numerical;
  const double sum =
      work.load + work.damping + work.obstacle + work.friction + work.impact + work.numerical;
  e->residual = fabs((e->kinetic - before->kinetic) + (e->elastic - before->elastic) - sum);
  /* z, sum: the path and the terms of the momentum; work of the obstacle that goes into friction */
  const double size = energies_size(motion->z, motion->sum, motion->n) / way;
  energies_enlarge(&e->scale, size + fabs(work.obstacle) + fabs(work.friction));
}
