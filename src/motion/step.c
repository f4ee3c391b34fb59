/*
 * step.c: one step of a motion.
 *
 * Velocity form and gap form, A = M + h theta C + h^2 theta^2 K:
 *
 *   (MT1)  b = h (f - C v - K (x + h theta v)),   g = L^T v - y'
 *   (MT2)  g_n += e g_n in the velocity form;  g_n += gap / h in the gap form
 *   (MT3)  q = P^T g + H^T A^-1 b                                          (dls_reduction_load)
 *   (MT4)  closed contacts: velocity form: gap + forecast h u_n <= activation, or <= 1e-6 h max |q|
 *          if closed in the last step; else all
 *   (MT5)  p from u = W p + q and the laws of contact, for closed contacts; 0 for others
 *   (MT6)  A dv = b + H p                                               (dls_reduction_recover)
 *   (MT7)  v+ = v + dv,   x+ = x + h (v + theta dv)
 *
 * Solving for dv instead of v+ keeps the digits of the change in one step. Path, with z = x:
 *
 *   (MT8)  b = f - K z;  g_n = gap(z) at the obstacle's new place,  g_t = L_t^T (z - x) - h y'_t
 *   (MT9)  (MT3) to (MT5) with A = K, then K dz = b + H r,  z += dz;  x+ = z
 *
 * That is exact up to rounding, which the next step sees in b and corrects. If only contact holds a
 * body, K is singular; contact over whole surfaces makes W large. Then the reduction is on K, and
 * dls_reduction_solve does (MT3) to (MT5) and dz.
 *
 * Sources: [Jean 1988] (3.2)1, (3.3)1-6; J. J. Moreau, Unilateral contact and dry friction in
 * finite freedom dynamics, 1988, for the velocity form with Newton's restitution. A step that is
 * not certified leaves nothing behind. Cost: a solve and a half with A, some products, and the
 * contact problem.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "motion/motion_internal.h"

/* ---- the contact problem of a step ----------------------------------------------------------- */

/* Part of the motion without contact in a step, h max |q|, up to which the foreseen gap of a
 * contact that was closed leaves it so. Rounding and the tolerance, 1e-12, open it by some 1e-12 of
 * that in a step at rest. */
static const double still_closed = 1e-6;

/* (MT4) q: m, of the step; NULL where all are closed. */
static void step_activate(dls_motion *motion, const double *q) {
  const dls_motion_settings *s = &motion->settings;
  const motion_point *now = &motion->now;
  const int d = motion->model.d, all = s->law != DLS_MOTION_VELOCITY;
  motion_point *next = &motion->next;
  double most = 0;
  for (size_t k = 0; !all && k < motion->m; k++)
    most = fmax(most, fabs(q[k]));
  next->active = 0;
  for (int c = 0, a = 0; c < (int)motion->candidates; c++) {
    const int was = a < now->active && now->list[a] == c;
    a += was;
    const double foreseen = now->gap[c] + s->forecast * s->h * motion->uc[d * c];
    if (all || foreseen <= s->activation || (was && foreseen <= still_closed * s->h * most))
      next->list[next->active++] = c;
  }
}

/* Finds the states of the active contacts from motion->r and motion->w. */
static void step_find_states(dls_motion *motion, dls_contact_state *state) {
  const dls_contact *problem = &motion->problem;
  const int d = problem->d;
  double F[3];
  if (problem->nc > 0) dlsi_certificate_weights(problem, motion->weight);
  for (int a = 0; a < problem->nc; a++)
    state[a] = dlsi_contact_misfit(d, problem->mu[a], motion->weight + 2 * a, motion->r + d * a,
                                   motion->w + d * a, F);
}

/* Solves the problem of the active contacts from the impulses `start` (m) times factor; sets
 * next->p and the states. */
static dls_status step_solve(dls_motion *motion, const double *start, double factor, dls_info *info,
                             dls_error *error) {
  motion_point *next = &motion->next;
  const dls_contact *problem = &motion->problem;
  const size_t d = (size_t)motion->model.d;
  dls_contact_state *state = next->state; /* of the active ones first, then spread */
  for (size_t k = 0; k < d * (size_t)next->active; k++)
    motion->r[k] = factor * start[d * (size_t)next->list[k / d] + k % d];
  dls_status status = dls_solver_solve(motion->solver, problem, motion->r, motion->w, info, error);
  if (status > 0) /* the solver was asked for more: motion_solver_limits */
    status = info->status = dlsi_settled(&info->certificate, motion->settings.limits.tol, status);
  if (status == DLS_TO_ROUNDING) status = DLS_OK;
  if (status) return status;
  step_find_states(motion, state);
  memset(next->p, 0, motion->m * sizeof *next->p);
  int a = next->active;
  for (int c = (int)motion->candidates - 1; c >= 0; c--) { /* from the end: list[a] >= a */
    const int closed = a > 0 && next->list[a - 1] == c;
    if (closed) memcpy(next->p + d * (size_t)c, motion->r + d * (size_t)--a, d * sizeof *next->p);
    state[c] = closed ? state[a] : DLS_FREE;
  }
  return DLS_OK;
}

/* Puts the equilibrium of A dx = b + H p into the certificate, which has the laws of the active
 * contacts. */
static dls_status step_equilibrium(dls_motion *motion, const double *mu, dls_info *info,
                                   dls_error *error) {
  dls_certificate body, *c = &info->certificate;
  const dls_status status = dls_reduction_certify(motion->reduction, mu ? mu : motion->zero,
                                                  motion->next.p, motion->dx, NULL, &body, error);
  if (status) return status;
  c->equilibrium = body.equilibrium;
  c->floor_e = body.floor_e;
  c->unbalanced = body.unbalanced;
  c->body = body.body;
  if (!(c->equilibrium <= c->residual)) c->residual = c->equilibrium;
  const double tol = motion->settings.limits.tol;
  if (c->equilibrium <= dlsi_target(tol, c->floor_e)) return DLS_OK;
  return info->status = DLS_NOT_IN_EQUILIBRIUM;
}

/* (MT3) to (MT6), for b and g = motion->local; sets motion->dx to the solution. */
static dls_status step_contact(dls_motion *motion, const double *mu, const double *start,
                               double factor, dls_info *info, dls_error *error) {
  dls_contact whole;
  dls_status status = dls_reduction_load(motion->reduction, motion->b, motion->local, error);
  if (!status)
    status = dls_reduction_contact(motion->reduction, mu ? mu : motion->zero, &whole, error);
  if (status) return status;
  step_activate(motion, whole.q);
  status = dls_contact_subset(&whole, motion->next.active, motion->next.list, motion->values, NULL,
                              &motion->problem, error);
  if (!status) status = step_solve(motion, start, factor, info, error);
  if (!status) status = dls_reduction_recover(motion->reduction, motion->next.p, motion->dx, error);
  return status ? status : step_equilibrium(motion, mu, info, error);
}

static const double more_digits = 1e-3;

/* As step_contact, but on K, from the reactions of the last step; on a path all contacts are
 * active. Asks the solver for more digits than the step: single reactions have fewer than the
 * residual. */
static dls_status step_on_K(dls_motion *motion, const double *mu, dls_info *info,
                            dls_error *error) {
  motion_point *next = &motion->next;
  if (!mu) mu = motion->zero;
  dls_solver_settings settings;
  dls_solver_settings_init(&settings);
  settings.limits = motion->settings.limits;
  settings.limits.tol *= more_digits;
  step_activate(motion, NULL);
  memcpy(next->p, motion->now.p, motion->m * sizeof *next->p);
  dls_status status = dls_reduction_load(motion->reduction, motion->b, motion->local, error);
  if (!status)
    status = dls_reduction_solve(motion->reduction, mu, &settings, next->p, motion->w, motion->dx,
                                 info, error);
  if (status == DLS_TO_ROUNDING) status = DLS_OK;
  return status
             ? status
             : dls_reduction_states(motion->reduction, mu, next->p, motion->w, next->state, error);
}

/* ---- after the step -------------------------------------------------------------------------- */

/* Sets local := gap0 + L^T x - way, the place of the contact nodes relative to the obstacle. */
static void step_place(dls_motion *motion, const double *x, const double *way) {
  const size_t d = (size_t)motion->model.d;
  dlsi_motion_local(motion, x, motion->local);
  for (size_t k = 0; k < d * motion->nodes; k++)
    motion->local[k] += (k % d == 0 ? motion->gap0[k / d] : 0) - way[k];
}

void dlsi_motion_measure_gap(dls_motion *motion, motion_point *point) {
  step_place(motion, point->x, point->way);
  dlsi_motion_gather(motion, motion->local, motion->mc);
  for (size_t c = 0; c < motion->candidates; c++)
    point->gap[c] = motion->mc[(size_t)motion->model.d * c];
}

/* Sets u+, the slip and the gaps of next. dx: x+ - x on a path. y: d nodes. */
static void step_measure(dls_motion *motion, const double *y, const double *dx) {
  const dls_motion_settings *s = &motion->settings;
  const int path = s->law == DLS_MOTION_PATH;
  const size_t d = (size_t)motion->model.d;
  const motion_point *now = &motion->now;
  motion_point *next = &motion->next;
  dlsi_motion_local(motion, path ? dx : next->v, motion->local);
  for (size_t k = 0; k < d * motion->nodes; k++) {
    motion->local[k] -= (path ? s->h : 1) * y[k];
    next->way[k] = now->way[k] + s->h * y[k];
  }
  dlsi_motion_gather(motion, motion->local, next->u);
  for (size_t c = 0; c < motion->candidates; c++)
    for (size_t i = 1; i < d; i++) {
      const size_t k = d * c + i, j = (d - 1) * c + i - 1;
      next->slip[j] =
          now->slip[j] +
          (path ? next->u[k] : s->h * (s->theta * next->u[k] + (1 - s->theta) * motion->uc[k]));
    }
  dlsi_motion_measure_gap(motion, next);
}

static dls_status step_finite(const dls_motion *motion, dls_error *error) {
  const motion_point *next = &motion->next;
  long long bad = dlsi_first_not_finite(next->x, motion->n);
  if (bad >= 0) return dlsi_fail(error, DLS_E_NOT_FINITE, "x", bad, next->x[bad], "overflow");
  bad = dlsi_first_not_finite(next->v, motion->n);
  if (bad >= 0) return dlsi_fail(error, DLS_E_NOT_FINITE, "v", bad, next->v[bad], "overflow");
  return DLS_OK;
}

void dlsi_motion_keep(const dls_motion *motion, const motion_point *from, motion_point *to) {
  const size_t d = (size_t)motion->model.d, nc = motion->candidates;
  memcpy(to->x, from->x, motion->n * sizeof *to->x);
  memcpy(to->v, from->v, motion->n * sizeof *to->v);
  memcpy(to->kx, from->kx, motion->n * sizeof *to->kx);
  memcpy(to->p, from->p, motion->m * sizeof *to->p);
  memcpy(to->u, from->u, motion->m * sizeof *to->u);
  memcpy(to->gap, from->gap, nc * sizeof *to->gap);
  memcpy(to->slip, from->slip, (d - 1) * nc * sizeof *to->slip);
  memcpy(to->way, from->way, d * motion->nodes * sizeof *to->way);
  memcpy(to->state, from->state, nc * sizeof *to->state);
  memcpy(to->list, from->list, nc * sizeof *to->list);
  to->active = from->active;
  to->energies = from->energies;
  to->restitution = from->restitution;
}

/* ---- dynamics -------------------------------------------------------------------------------- */

/* (MT1), (MT2) with restitution e; sets uc to u before the step. y: d nodes. */
static void step_predict(dls_motion *motion, double e, const double *f, const double *y) {
  const dls_motion_settings *s = &motion->settings;
  const motion_point *now = &motion->now;
  const size_t d = (size_t)motion->model.d;
  double *g = motion->local;
  if (s->law == DLS_MOTION_GAP) step_place(motion, now->x, now->way);
  for (size_t k = 0; k < d * motion->nodes; k++)
    motion->place[k] = s->law == DLS_MOTION_GAP ? g[k] / s->h : 0;
  dlsi_motion_local(motion, now->v, g);
  for (size_t k = 0; k < d * motion->nodes; k++)
    g[k] -= y[k];
  dlsi_motion_gather(motion, g, motion->uc);
  for (size_t k = 0; k < d * motion->nodes; k += d)
    g[k] += e * g[k] + motion->place[k];
  for (size_t i = 0; i < motion->n; i++)
    motion->z[i] = now->x[i] + s->h * s->theta * now->v[i];
  dlsi_motion_multiply(motion, &motion->model.K, motion->z, motion->yn, NULL);
  dlsi_motion_multiply(motion, &motion->model.C, now->v, motion->z, NULL);
  for (size_t i = 0; i < motion->n; i++)
    motion->b[i] = s->h * ((f ? f[i] : 0) - motion->z[i] - motion->yn[i]);
}

/* Returns the work of contact on the bodies, p.(u + theta H^T dv); *size: the sum of |terms|. */
static double step_work(dls_motion *motion, double *size) {
  dlsi_motion_local(motion, motion->dx, motion->local);
  dlsi_motion_gather(motion, motion->local, motion->mc);
  double work = *size = 0;
  for (size_t k = 0; k < motion->m; k++) {
    const double p = motion->next.p[k], du = motion->settings.theta * motion->mc[k];
    work += p * (motion->uc[k] + du);
    *size += fabs(p) * (fabs(motion->uc[k]) + fabs(du));
  }
  return work;
}

static const double work_rounds = 1e-12, work_meets = 1e-9; /* parts of its size */
enum { impact_tries = 40, impact_close = 20 };

/* (MT1) to (MT6). With energy_consistent and where contact would do work on the bodies, again with
 * smaller e: e = 0 does none (but where slip reverses within the step), and between both the
 * Illinois method finds the e that does none: with the same states the work is a parabola in e.
 * Where it jumps, the first e below the jump is taken. */
static dls_status step_impact(dls_motion *motion, const double *f, const double *y,
                              const double *mu, dls_info *info, dls_error *error) {
  const dls_motion_settings *s = &motion->settings;
  double *e = &motion->next.restitution, size;
  double high = s->restitution, low = 0, above = 0, below = 0;
  const double factor = motion->h_last > 0 ? s->h / motion->h_last : 1;
  *e = high;
  for (int k = 0, side = 0; k < impact_tries; k++) {
    step_predict(motion, *e, f, y);
    const dls_status status = step_contact(motion, mu, motion->now.p, factor, info, error);
    if (status || !s->energy_consistent || (*e == 0 && k != 1)) return status;
    double work = step_work(motion, &size);
    if (k == 0 && work <= work_rounds * size) return DLS_OK;
    work += work_meets * size / 2; /* its zero is on the side that loses energy */
    if (fabs(work) <= work_meets * size / 2 || (work <= 0 && k >= impact_close)) return DLS_OK;
    if (work > 0) {
      if (k == 1) return DLS_OK; /* with e = 0 */
      high = *e, above = work;
      if (side > 0) below /= 2;
      side = 1;
    } else {
      low = *e, below = work;
      if (side < 0) above /= 2;
      side = -1;
    }
    const int last = k == 0 || k == impact_tries - 2;
    *e = last               ? 0
         : k < impact_close ? (low * above - high * below) / (above - below)
                            : (low + high) / 2;
  }
  return DLS_OK;
}

static dls_status step_dynamics(dls_motion *motion, const double *f, const double *y,
                                const double *mu, dls_info *info, dls_error *error) {
  const dls_motion_settings *s = &motion->settings;
  const motion_point *now = &motion->now;
  motion_point *next = &motion->next;
  dls_status status = step_impact(motion, f, y, mu, info, error);
  if (status) return status;
  for (size_t i = 0; i < motion->n; i++) { /* (MT7) */
    next->v[i] = now->v[i] + motion->dx[i];
    next->x[i] = now->x[i] + s->h * (now->v[i] + s->theta * motion->dx[i]);
  }
  status = step_finite(motion, error);
  if (status) return status;
  step_measure(motion, y, NULL);
  dlsi_motion_account(motion, f, y, motion->dx);
  return DLS_OK;
}

/* ---- path ------------------------------------------------------------------------------------ */

/* (MT8) at next->x = now->x + ways. y: d nodes. */
static void step_predict_path(dls_motion *motion, const double *f, const double *y) {
  const double h = motion->settings.h;
  const size_t d = (size_t)motion->model.d;
  const motion_point *next = &motion->next;
  dlsi_motion_local(motion, motion->ways, motion->place);
  step_place(motion, next->x, motion->now.way);
  for (size_t k = 0; k < d * motion->nodes; k++)
    motion->local[k] = (k % d == 0 ? motion->local[k] : motion->place[k]) - h * y[k];
  dlsi_motion_multiply(motion, &motion->model.K, next->x, motion->b, NULL);
  for (size_t i = 0; i < motion->n; i++)
    motion->b[i] = (f ? f[i] : 0) - motion->b[i];
}

static dls_status step_path(dls_motion *motion, const double *f, const double *y, const double *mu,
                            dls_info *info, dls_error *error) {
  motion_point *next = &motion->next;
  const size_t n = motion->n;
  memcpy(next->x, motion->now.x, n * sizeof *next->x);
  memset(motion->ways, 0, n * sizeof *motion->ways);
  step_predict_path(motion, f, y);
  dls_status status = motion->on_K ? step_on_K(motion, mu, info, error)
                                   : step_contact(motion, mu, motion->now.p, 1, info, error);
  if (status) return status;
  for (size_t i = 0; i < n; i++) { /* (MT9) */
    motion->ways[i] = motion->dx[i];
    next->x[i] = motion->now.x[i] + motion->ways[i];
    next->v[i] = motion->ways[i] / motion->settings.h;
  }
  status = step_finite(motion, error);
  if (status) return status;
  step_measure(motion, y, motion->ways);
  dlsi_motion_account(motion, f, y, motion->ways);
  return DLS_OK;
}

/* ---- the door -------------------------------------------------------------------------------- */

static dls_status step_check(const dls_motion *motion, const double *f, const double *y,
                             const double *mu, dls_error *error) {
  dls_status status = f ? dlsi_check_vector("f", f, motion->n, error) : DLS_OK;
  if (!status && y)
    status = dlsi_check_vector("y", y, (size_t)motion->model.d * motion->nodes, error);
  if (!status && mu) status = dlsi_check_friction(mu, motion->candidates, error);
  return status;
}

static dls_status step_take(dls_motion *motion, const double *f, const double *y, const double *mu,
                            dls_info *info, dls_error *error) {
  dls_status status = step_check(motion, f, y, mu, error);
  if (status) return status;
  dls_info own;
  if (!info) info = &own;
  if (!y) y = motion->zero;
  status = motion->settings.law == DLS_MOTION_PATH ? step_path(motion, f, y, mu, info, error)
                                                   : step_dynamics(motion, f, y, mu, info, error);
  if (status) return status;
  dlsi_motion_keep(motion, &motion->next, &motion->now);
  motion->steps++;
  motion->t += motion->settings.h;
  motion->h_last = motion->settings.h;
  return DLS_OK;
}

dls_status dls_motion_step(dls_motion *motion, const double *f, const double *y, const double *mu,
                           dls_info *info, dls_error *error) {
  DLSI_DOOR;
  dls_status status = dlsi_motion_enter(motion, error);
  if (!status) status = dlsi_leave(&motion->busy, step_take(motion, f, y, mu, info, error));
  return dlsi_at(__func__, status, error);
}
