/*
 * splitting.c: Douglas and Rachford's splitting on K, d = 2 and 3.
 *
 * In round variables (global_internal.h):
 *
 *   (GL1)  r := the law's reactions for q = r - rho u:  r_n = max(q_n, 0), r_t = q_t put on the
 *          disc |.| <= mu r_n. Then rho z = r - q are the law's positions.
 *   (GL2)  (K + rho H H^T + E) x := f + H (r + rho (z - g)) + E x
 *   (GL3)  u := H^T x + g
 *   (GL4)  q := q + a (p - q),  p = r - rho u;  a = 1.6 with (GL5), 1 without
 *
 * A fixed point has u = z, hence K x = f + H r. The pair (x, r(p)) is measured. K alone is never
 * inverted: a body that only contact holds is no special case. E is 0 unless nothing holds a
 * motion (system.c).
 *
 *   (GL5)  The next q by Anderson's acceleration of (GL4), 10 steps, unless the smallest residual
 *          has not halved between the last two looks at rho.
 *   (GL6)  If an accelerated q has more than twice the |p - q| of the previous q, the step is
 *          taken back: q := (GL4) of the previous q, and the history is forgotten.
 *   (GL7)  Every 20 iterations, later after k/2 more, look at rho, with turn = sqrt(|p - q|
 *          / |rho (z - z')|), z' the previous z, between .1 and 10:
 *            the residual is a hundredth              rho stays: a factor costs 5 to 15 iterations
 *            turn outside of 1/sqrt(5) .. sqrt(5)     rho := rho turn
 *            else, and the residual has halved        rho stays
 *            else, two times of three                 rho stays
 *            else                                     rho / 10, 10 rho, rho / 100, .. in turn
 *          A change keeps r and z, and costs a factorisation. rho starts at .35 of the local
 *          stiffness: 1/4 suits contacts that open, 1 contacts that stay.
 *   (GL8)  A host with a preconditioner begins with Newton steps, and tries them again after 20
 *          iterations. Otherwise Newton steps (newton.c) end the iteration if no state has changed
 *          between two measures and the splitting would need more than 200 further iterations.
 *          That is the cost of an LU: 100 to 330 iterations for strips and plates of 2,000 to
 *          40,000 unknowns.
 *   (GL9)  If equilibrium is the worst part and stands still, look once for a motion that nothing
 *          can hold (motion.c).
 *   (GL10) If nothing has halved for 500 iterations, try once the fixed point of s = mu |u_t| by
 *          convex problems (fixed.c), and go on from there if that is much better.
 *   (GL11) The first step shows joints that contradict each other (contradiction.c).
 *   (GL12) If the residual of a look is more than a tenth of that of the previous look, the
 *          augmented Lagrangian (lagrangian.c) goes on. If it does not end the solve, the splitting
 *          goes on from the best pair; if it has halved the residual, (GL12) may be tried again
 *          after twice as many iterations.
 *   (GL15) Before the first (GL12), where K = 0: the convex problem with s = 0 (fixed.c), then
 *          (GL9). Of 1,000 voussoirs that takes 20 to 60 factors, (GL12) 260.
 *   (GL14) On the split problem (loads.c) g contains slips of the size of the body's own
 *          deformation, far larger than what reactions do: rho starts at w^1/2 |f'| / |g'|, at
 *          most .35, and becomes rho |r| / |rho z| if the residual has not halved and
 *          |rho z| > 30 |r|.
 *   (GL13) Ends when nothing has halved for 2000 iterations, or with the first NaN.
 *
 * Source: Lions and Mercier, SIAM J. Numer. Anal. 16, 1979, 964-979; admm.c is the same on W.
 * Cost: a solve with the factor of A per iteration, a product with K every 10 iterations.
 * What can fail: Coulomb's law is not monotone, and nothing proves convergence with friction.
 */
#include <limits.h>
#include <string.h>

#include "global_internal.h"

enum {
  measure_every = 10,
  first_look = 20,
  most_unsplit = 40,
  worth = 200,
  patience = 500,
  no_progress = 2000
};

static const double relaxation = 1.6;
static const double most_growth = 2;          /* (GL6) */
static const double off = 2.2360679774997896; /* (GL7): sqrt(5) */
static const double most_change = 10;         /* (GL7) */
static const double first_rho = 0.35;         /* of the local stiffness */
static const double fast = 0.01;              /* (GL7): gain between looks at which rho stays */
static const double slow = 0.1;               /* (GL12): gain that is too small for the splitting */
static const double least_rho = 1e-8, most_rho = 100;
static const double least_rho_split = 1e-11; /* (GL14) */
static const double flight = 30;             /* (GL14): |rho z| over |r| */

/* ---- the iteration --------------------------------------------------------------------------- */

/* Returns |a - b| on this rank. Spoils look. */
static double distance(const dls_global *work, const double *a, const double *b) {
  for (int k = 0; k < work->m; k++)
    work->look[k] = a[k] - b[k];
  return dlsi_norm2(work->look, (size_t)work->m);
}

/* Returns |a| of all ranks, a of m. */
static double norm_of_all(const dls_global *work, const double *a) {
  return dlsi_joined_norm(work->body.ranks, a, (size_t)work->m);
}

/* Sets the states by q = r - rho u; returns 1 if one has changed. */
static int split_sort(dls_global *work, const double *q) {
  double changed = 0;
  for (int c = 0; c < work->nc; c++) {
    const double *qc = q + work->d * c;
    const double R = dlsi_friction_bound(work->bend[c], qc[0]);
    const dls_contact_state now = !(qc[0] > 0)                         ? DLS_FREE
                                  : dlsi_tangent_norm(work->d, qc) > R ? DLS_SLIP
                                                                       : DLS_STICK;
    changed += work->state[c] != (int)now;
    work->state[c] = (int)now;
  }
  dlsi_join(work->body.ranks, DLSI_MOST, &changed, 1);
  return changed > 0;
}

/* What one look keeps for the next. */
typedef struct schedule {
  int look;                /* iteration of the next (GL7) */
  int newton, lagrangian;  /* iteration from which on (GL8), (GL12) may be tried */
  int tried, fixed;        /* 1 after (GL9), (GL10) */
  double jump;             /* (GL7): next factor if the residual stands still */
  int moves;               /* 1: the smallest residual has halved between the two looks before */
  int still;               /* looks at which it had not, with rho balanced */
  double residual_at_look; /* the smallest one at the look before */
  double residual;         /* of the measure before */
  double equilibrium;      /* at the look before */
  double best;             /* badness of the best pair at its last halving, .. */
  int since;               /* .. and the iteration of that */
} schedule;

/* (GL7) Returns the next rho at iteration k. gap: |p - q|; change: |rho (z - z')|. */
static double split_next_rho(const dls_global *work, int k, double gap, double change,
                             schedule *s) {
  const double residual = dlsi_body_badness(&work->best);
  const int more = k / (2 * measure_every) * measure_every;
  double turn = fmin(fmax(sqrt(gap / change), 1 / most_change), most_change);
  const double gain = residual / s->residual_at_look;
  s->moves = gain <= 0.5;
  s->residual_at_look = residual;
  s->look = k + (more > first_look ? more : first_look);
  if (gain <= fast)
    turn = 1;
  else if (turn <= off && turn >= 1 / off) {
    turn = s->moves || s->still++ % 3 < 2 ? 1 : s->jump;
    if (turn != 1) s->jump = s->jump < 1 ? 10 / s->jump : 0.1 / s->jump;
  }
  if (work->is_split && gain > 0.5) { /* a body that flies */
    const double force = norm_of_all(work, work->r), slip = norm_of_all(work, work->z);
    if (force > 0 && slip > flight * force) turn = force / slip;
  }
  return fmin(fmax(work->rho * turn, work->is_split ? least_rho_split : least_rho), most_rho);
}

/* (GL14) */
static double split_first_rho(const dls_global *work) {
  const double force = sqrt(dlsi_global_compliance(work)) *
                       dlsi_joined_norm(work->body.ranks, work->f, (size_t)work->n);
  const double gap = norm_of_all(work, work->g);
  if (!work->is_split || !(gap > 0 && force > 0)) return first_rho;
  return fmin(first_rho, fmax(least_rho_split, force / gap));
}

/* (GL7) Goes on with another rho from the same r and z. */
static dls_status split_adapt(dls_global *work, int k, double gap, double change, schedule *s,
                              dls_error *error) {
  const double rho = split_next_rho(work, k, gap, change, s), f = rho / work->rho;
  if (rho != work->rho || !s->moves) dlsi_anderson_clear(&work->history);
  if (rho == work->rho) return DLS_OK;
  dlsi_put_on_discs(work->d, work->nc, work->bend, work->q, work->r);
  for (int i = 0; i < work->m; i++) {
    work->q[i] = work->r[i] + f * (work->q[i] - work->r[i]);
    work->z[i] *= f;
  }
  work->rho = rho;
  return dlsi_global_factor(work, error);
}

/* (GL4), (GL5), (GL6) gap: |p - q|; *accepted: that of the previous q. */
static void split_advance(dls_global *work, int accelerate, double gap, double *accepted) {
  dlsi_anderson *history = &work->history;
  if (history->columns && !(gap <= most_growth * *accepted)) {
    memcpy(work->q, history->g, (size_t)work->m * sizeof *work->q);
    dlsi_anderson_clear(history);
    return;
  }
  *accepted = gap;
  for (int i = 0; i < work->m; i++) {
    work->look[i] = (accelerate ? relaxation : 1) * (work->p[i] - work->q[i]);
    work->q[i] += work->look[i];
  }
  if (accelerate) (void)dlsi_anderson_step(history, work->m, work->look, work->q, NULL);
}

/* (GL8) Returns 1 if enough iterations are left to pay for the factors of Newton steps. */
static int newton_is_due(const dls_global *work, int k, int changed, const dls_certificate *now,
                         const schedule *s) {
  if (k < s->newton || !dlsi_global_touches(work)) return 0;
  if (!work->system) return work->solver.apply != NULL;
  if (changed) return 0;
  const double gain = s->residual / now->residual, left = now->residual / work->limits->tol;
  return !(gain > 1) || log(left) / log(gain) * measure_every > worth;
}

/* Goes on from the best pair if it is much better than `before`. */
static void split_resume(dls_global *work, double before) {
  if (!(dlsi_body_badness(&work->best) < before / 2)) return;
  memcpy(work->x, work->best_x, (size_t)work->n * sizeof *work->x);
  dlsi_global_look(work, work->x, work->u);
  for (int i = 0; i < work->m; i++)
    work->p[i] = work->best_r[i] * work->root[i] - work->rho * work->u[i];
  memcpy(work->q, work->p, (size_t)work->m * sizeof *work->q);
  dlsi_anderson_clear(&work->history);
}

/* (GL8) */
static dls_status split_newton(dls_global *work, int k, schedule *s, dls_error *error) {
  const double before = dlsi_body_badness(&work->best);
  const dls_status status = dlsi_global_newton(work, work->before, 0, 0, error);
  s->newton = 2 * k;
  if (status == DLS_STALLED) split_resume(work, before);
  return status;
}

/* (GL10) */
static dls_status split_fixed(dls_global *work, schedule *s, dls_error *error) {
  const double before = dlsi_body_badness(&work->best);
  const dls_status status = dlsi_global_fixed(work, 0, error);
  s->fixed = 1;
  if (status == DLS_STALLED) split_resume(work, before);
  return status;
}

/* (GM1), once a solve. DLS_NO_SOLUTION if proved, DLS_STALLED to go on, or an error. */
static dls_status split_prove(dls_global *work, schedule *s, dls_error *error) {
  int proved = 0;
  s->tried = 1;
  const dls_status status = dlsi_global_prove(work, &proved, error);
  return status ? status : proved ? DLS_NO_SOLUTION : DLS_STALLED;
}

/* (GL15) Looks for reactions of rigid bodies at rest, then for a proof that there are none. */
static dls_status split_rigid(dls_global *work, schedule *s, dls_error *error) {
  const double before = dlsi_body_badness(&work->best);
  dls_status status = dlsi_global_fixed(work, 1, error);
  if (status == DLS_STALLED) status = split_prove(work, s, error);
  if (status == DLS_STALLED) split_resume(work, before);
  return status;
}

/* (GL12) Returns 1 if the residual has hardly moved since the last look. */
static int lagrangian_is_due(const dls_global *work, int k, const schedule *s) {
  return k >= s->look && k >= s->lagrangian && work->m > 0 && work->system &&
         work->system->definite && dlsi_body_badness(&work->best) > slow * s->residual_at_look;
}

/* (GL12) */
static dls_status split_lagrangian(dls_global *work, int k, int most, schedule *s,
                                   dls_error *error) {
  const double before = dlsi_body_badness(&work->best);
  dls_status status = dlsi_global_lagrangian(work, work->before, most, error);
  s->lagrangian = dlsi_body_badness(&work->best) < before / 2 ? 2 * k : INT_MAX;
  if (status != DLS_STALLED) return status;
  status = dlsi_global_factor(work, error);
  if (status) return status;
  split_resume(work, INFINITY);
  return DLS_STALLED;
}

/* Returns 1 if equilibrium is the worst part and stands still. */
static int stands_still(const dls_certificate *now, schedule *s) {
  const int still = now->equilibrium > 0.5 * s->equilibrium && now->equilibrium == now->residual;
  s->equilibrium = now->equilibrium;
  return still;
}

dls_status dlsi_global_verdict(const dls_global *work, dls_status status) {
  const dls_certificate *c = &work->best;
  const double contact = c->residual_u > c->residual_r ? c->residual_u : c->residual_r;
  return c->equilibrium > dlsi_target(work->limits->tol, c->floor_e) &&
                 contact < 0.1 * c->equilibrium
             ? DLS_NOT_IN_EQUILIBRIUM
             : status;
}

/* Measures and decides at iteration k. p: r - rho u. Returns DLS_STALLED to go on, with *end = 0.
 * */
static dls_status split_look(dls_global *work, int k, int most, const double *p, schedule *s,
                             int *end, dls_error *error) {
  dls_certificate now;
  dlsi_put_on_discs(work->d, work->nc, work->bend, p, work->before);
  dls_status status = dlsi_global_measure(work, work->before, &now);
  *end = 1;
  if (status != DLS_STALLED) return status;
  dls_progress progress = {.method = "global",
                           .stage = "global",
                           .iteration = work->iterations,
                           .max_iterations = most,
                           .residual = now.residual,
                           .r = work->trial};
  status = dlsi_tell(work->limits, work->begun, &progress);
  if (status) return status;
  if (k % measure_every) { /* between two looks */
    *end = 0;
    return DLS_STALLED;
  }
  if (k >= most_unsplit && dlsi_global_can_split(work) &&
      dlsi_forces_dwarf(&work->body, work->scratch))
    return dlsi_split_first; /* (LO1) */
  if (newton_is_due(work, k, split_sort(work, p), &now, s)) {
    status = split_newton(work, k, s, error);
    if (status != DLS_STALLED) return status;
  }
  if (lagrangian_is_due(work, k, s)) {
    if (!s->tried && dlsi_global_is_rigid(work)) {
      status = split_rigid(work, s, error);
      if (status != DLS_STALLED) return status;
    }
    status = split_lagrangian(work, k, most - work->iterations, s, error);
    if (status != DLS_STALLED) return status;
  }
  s->residual = now.residual;
  const double badness = dlsi_body_badness(&work->best);
  if (badness < s->best / 2) {
    s->best = badness;
    s->since = k;
  }
  *end = k - s->since > no_progress || now.residual != now.residual;
  const int still = k >= s->look && stands_still(&now, s);
  if (!s->tried && (still || *end)) {
    status = split_prove(work, s, error);
    if (status != DLS_STALLED) {
      *end = 1;
      return status;
    }
  }
  if (!s->fixed && work->system && (k - s->since > patience || *end)) {
    *end = 1;
    status = split_fixed(work, s, error);
    if (status != DLS_STALLED) return status;
    *end = 0;
    s->since = k;
  }
  return *end ? dlsi_global_verdict(work, DLS_STALLED) : DLS_STALLED;
}

dls_status dlsi_global_split(dls_global *work, int most, dls_error *error) {
  const int m = work->m;
  schedule s = {.look = first_look,
                .newton = first_look,
                .jump = 0.1,
                .moves = 1,
                .residual_at_look = 1,
                .residual = INFINITY,
                .equilibrium = INFINITY,
                .best = INFINITY};
  dls_certificate now;
  double accepted = 0;
  dlsi_anderson_clear(&work->history);
  for (int c = 0; c < work->nc; c++)
    work->state[c] = -1;
  work->rho = split_first_rho(work);
  dlsi_global_ask(work, 1);
  dlsi_global_look(work, work->x, work->u);
  dls_status status = dlsi_global_measure(work, work->r, &now);
  if (status != DLS_STALLED) return status;
  const double begun = dlsi_body_badness(&work->best);
  if (work->solver.apply && dlsi_global_touches(work)) { /* (GL8) */
    memcpy(work->before, work->r, (size_t)m * sizeof *work->r);
    status = dlsi_global_newton(work, work->before, 0, 0, error);
    if (status != DLS_STALLED) return status;
    dlsi_global_look(work, work->x, work->u);
  }
  status = dlsi_global_factor(work, error);
  for (int k = 0; k < m; k++)
    work->q[k] = work->r[k] - work->rho * work->u[k];
  memset(work->z, 0, (size_t)m * sizeof *work->z);
  split_resume(work, begun);
  for (int k = 1; !status && work->iterations < most; k++) {
    work->iterations++;
    dlsi_put_on_discs(work->d, work->nc, work->bend, work->q, work->r); /* (GL1) */
    for (int i = 0; i < m; i++)
      work->before[i] = work->r[i] - work->q[i];
    double change = distance(work, work->before, work->z);
    dlsi_join(work->body.ranks, DLSI_NORM, &change, 1);
    memcpy(work->z, work->before, (size_t)m * sizeof *work->z);
    status = dlsi_global_step(work, work->r, work->q, work->g, error); /* (GL2), (GL3) */
    if (status) break;
    int proved = 0;
    if (k == 1) status = dlsi_global_contradict(work, &proved, error); /* (GL11) */
    if (status || proved) return proved ? DLS_NO_SOLUTION : status;
    for (int i = 0; i < m; i++)
      work->p[i] = work->r[i] - work->rho * work->u[i];
    double norms[] = {distance(work, work->p, work->q), dlsi_norm2(work->r, (size_t)m),
                      dlsi_norm2(work->p, (size_t)m)};
    dlsi_join(work->body.ranks, DLSI_NORM, norms, 3);
    const double gap = norms[0], size = norms[1];
    dlsi_global_ask(work, gap / norms[2]);
    const int adapt = k >= s.look && k % measure_every == 0;
    if (k % measure_every == 0 || work->iterations == most || gap <= work->limits->tol * size) {
      int end;
      status = split_look(work, k, most, work->p, &s, &end, error);
      if (end) return status;
      status = DLS_OK;
    }
    split_advance(work, dlsi_global_touches(work) && s.moves, gap, &accepted);
    if (adapt) status = split_adapt(work, k, gap, change, &s, error); /* (GL7) */
  }
  return status ? status : dlsi_global_verdict(work, DLS_MAX_ITERATIONS);
}
