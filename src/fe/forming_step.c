/*
 * forming_step.c: takes the steps of a forming scene: one controller for every method.
 *
 *   (FS1)  try the part of the step from load0 to load: the loops of forming.c, by each variant of
 *          the method in turn (auto: on K, on W, by Lemke's method) until one succeeds
 *   (FS2)  certify the end: a body (forming_body.c), forces that balance, energy
 *   (FS3)  with step_tol, or if the force jumps: repeat the part in two halves; if both forces
 *          agree, with step_tol the halves stay, as the better answer
 *   (FS4)  on any failure: take both halves of it instead, six times at most; after a half that has
 *          succeeded the rest is one piece, so that parts grow again
 *   (FS5)  states, x0, r0 := those at the end, once it is certified
 *
 * (FS2) The energy lost in a part, by the trapezoids of force and friction, is at most a quarter of
 * the largest of work, stored and spent. The first part is exempt: the billet starts 0.011 mm
 * inside the rounded corner of the die, and is pressed out of it first.
 *
 * (FS3) estimates the error of a step of first order. The halves have about half of its error, so
 * that |F - F_halves| is about the error of the halves. It must be at most step_tol times the
 * largest force so far. data.step_error is the sum over the steps, which bounds the error of the
 * curve, because errors of early steps decay.
 *
 * A jump is a force that differs from the line through its last two values by more than 25 % of the
 * largest force so far. At the friction of the paper 1 step of 100 and 3 of 300 jump; all are
 * confirmed.
 *
 * What can fail: the smallest part. The state shown is then the last good one.
 */
#include <math.h>
#include <string.h>

#include "forming_internal.h"

enum { most_halvings = 6 };

static const double jump_bound = 0.25;    /* of the force, over the largest so far */
static const double jump_agreement = 0.1; /* of the step and its halves, over the jump */
static const double balance_bound = 1e-9; /* of the sum of all forces */
static const double energy_bound = 0.25;  /* of the step, over its largest part */

/* ---- the end of a step ----------------------------------------------------------------------- */

/* Fills reaction with the forces on the nodes, friction on held nodes included, and returns the
 * force against the motion: power at unit rate of load over the length of the path. */
static double step_resistance(dls_forming *f) {
  double power = 0;
  for (int c = 0; c < f->nc; c++)
    if (f->held[f->candidate[c]]) f->r[2 * c + 1] = dlsi_forming_held_friction(f, c);
  memset(f->reaction, 0, (size_t)f->n * sizeof *f->reaction);
  dlsi_forming_push(f, f->r, f->reaction);
  for (int c = 0; c < f->nc; c++) {
    const double *way = f->rigid[f->meets[c]].way, *r = f->reaction + 2 * f->candidate[c];
    power += r[0] * way[0] + r[1] * way[1];
  }
  for (int i = 0; i < f->n; i++)
    if (f->fixed[i]) power += (f->F[i] - f->reaction[i]) * f->drive[i];
  return power / f->whole;
}

/* Sums up force and work of the step at its end. */
static void step_book(dls_forming *f) {
  const double load = f->load - f->load0;
  dlsi_book *b = &f->book;
  b->force = step_resistance(f);
  b->external = (f->data.force + b->force) / 2 * f->whole * load;
  b->friction = 0;
  for (int c = 0; c < f->nc; c++)
    b->friction -= (f->r0[2 * c + 1] + f->r[2 * c + 1]) / 2 * f->u[2 * c + 1];
}

/* Certifies the end of a step, (FS2); returns 0 and fills the fault on failure. */
static int step_is_good(dls_forming *f) {
  const dls_forming_energy *e = &f->data.energy;
  const dlsi_book *b = &f->book;
  dls_forming_fault *fault = &f->data.fault;
  if (!dlsi_forming_is_body(f, fault)) return 0;
  if (!(f->data.balance <= fmax(balance_bound, f->settings.tol))) {
    dlsi_forming_blame(fault, DLS_FORMING_BALANCE, -1, -1, -1, f->data.balance);
    return 0;
  }
  const double stored = f->elastic - e->elastic, spent = f->plastic - e->plastic;
  const double size = fmax(fabs(b->external), fmax(fabs(stored), fabs(spent)));
  const double off = fabs(b->external - stored - spent - b->friction);
  const int exempt = f->load0 == 0 || f->settings.keep_trace; /* of whose energy see material.c */
  if (!exempt && !(off <= energy_bound * size)) {
    dlsi_forming_blame(fault, DLS_FORMING_ENERGY, -1, -1, -1, off / size);
    return 0;
  }
  return 1;
}

/* Makes x and r the end of a step: fills the views. */
static void step_commit(dls_forming *f) { /* (FS5) */
  dls_forming_data *d = &f->data;
  const size_t n = (size_t)f->n, m = 2 * (size_t)f->nc, points = 4 * (size_t)f->mesh.quads;
  const dlsi_book *b = &f->book;
  f->slope = (b->force - d->force) / (f->load - f->load0);
  f->largest = fmax(f->largest, fabs(b->force));
  d->force = b->force;
  d->travel = f->load * f->whole;
  d->energy.external += b->external;
  d->energy.elastic = f->elastic;
  d->energy.plastic = f->plastic;
  d->energy.friction += b->friction;
  for (size_t k = 0; k < points; k++)
    f->plastic_strain[k] = f->now[k].ep;
  for (size_t i = 0; i < n; i++)
    f->displacement[i] = f->x[i] - f->mesh.xy[i];
  d->worst_equilibrium = fmax(d->worst_equilibrium, d->equilibrium);
  d->worst_residual = fmax(d->worst_residual, d->certificate.residual);
  d->worst_balance = fmax(d->worst_balance, d->balance);
  d->way = f->way;
  d->count.parts++;
  d->count.handed += f->way == DLS_FORMING_ON_W || f->way == DLS_FORMING_BY_LEMKE;
  d->count.held = 0;
  for (int i = 0; i < f->mesh.nodes; i++)
    d->count.held += f->held[i];
  f->part = f->load - f->load0;
  f->load0 = f->load;
  memcpy(f->before, f->x0, n * sizeof *f->x);
  memcpy(f->x0, f->x, n * sizeof *f->x);
  memcpy(f->r0, f->r, m * sizeof *f->r);
  memcpy(f->held0, f->held, (size_t)f->mesh.nodes * sizeof *f->held);
  memcpy(f->old, f->now, points * sizeof *f->old);
  f->good = *d;
}

/* Resets the nodes that are held to the end of the last step. */
static void step_hold(dls_forming *f) {
  for (int i = 0; i < f->mesh.nodes; i++)
    if (f->held[i] != f->held0[i]) dlsi_forming_hold(f, i, f->held0[i]);
}

/* Restores the last good state, with its views, and slips of no step. */
static void step_restore(dls_forming *f) {
  const dls_forming_data *good = &f->good;
  f->load = f->load0;
  step_hold(f);
  memcpy(f->x, f->x0, (size_t)f->n * sizeof *f->x);
  memcpy(f->r, f->r0, 2 * (size_t)f->nc * sizeof *f->r);
  dlsi_forming_show(f);
  memset(f->reaction, 0, (size_t)f->n * sizeof *f->reaction);
  dlsi_forming_push(f, f->r, f->reaction);
  dlsi_forming_press(f);
  f->data.equilibrium = good->equilibrium;
  f->data.certificate = good->certificate;
  f->data.balance = good->balance;
}

/* ---- the copy -------------------------------------------------------------------------------- */

static void step_keep(dls_forming *f) {
  const size_t n = (size_t)f->n;
  f->kept_data = f->data;
  f->kept_load = f->load0;
  f->kept_part = f->part;
  f->kept_largest = f->largest;
  f->kept_slope = f->slope;
  memcpy(f->kept_before, f->before, n * sizeof *f->x);
  memcpy(f->kept_x, f->x0, n * sizeof *f->x);
  memcpy(f->kept_r, f->r0, 2 * (size_t)f->nc * sizeof *f->r);
  memcpy(f->kept_held, f->held0, (size_t)f->mesh.nodes * sizeof *f->held);
  memcpy(f->kept_points, f->old, 4 * (size_t)f->mesh.quads * sizeof *f->old);
}

/* Restores the copy; the counts keep the cost of the steps since then. */
static void step_undo(dls_forming *f) {
  const size_t n = (size_t)f->n;
  const dls_forming_data *kept = &f->kept_data;
  dls_forming_data *d = &f->data;
  d->travel = kept->travel;
  d->force = kept->force;
  d->energy = kept->energy;
  d->count.parts = kept->count.parts;
  d->count.handed = kept->count.handed;
  f->load0 = f->kept_load;
  f->part = f->kept_part;
  f->largest = f->kept_largest;
  f->slope = f->kept_slope;
  memcpy(f->before, f->kept_before, n * sizeof *f->x);
  memcpy(f->x0, f->kept_x, n * sizeof *f->x);
  memcpy(f->r0, f->kept_r, 2 * (size_t)f->nc * sizeof *f->r);
  memcpy(f->held0, f->kept_held, (size_t)f->mesh.nodes * sizeof *f->held);
  memcpy(f->old, f->kept_points, 4 * (size_t)f->mesh.quads * sizeof *f->old);
}

/* ---- the controller -------------------------------------------------------------------------- */

/* Runs the loops up to `load` and certifies the end. Returns DLS_OK, an error < 0, or DLS_STALLED
 * or DLS_FOLDED with the fault filled. */
static dls_status step_try(dls_forming *f, double load, dls_error *error) { /* (FS1) */
  const int any = f->settings.contact == DLS_FORMING_CONDENSED && f->settings.method == DLS_AUTO;
  const dls_forming_way first = any ? DLS_FORMING_ON_K : DLS_FORMING_BY_METHOD;
  const dls_forming_way last = any ? DLS_FORMING_BY_LEMKE : DLS_FORMING_BY_METHOD;
  dls_status status = DLS_STALLED;
  for (f->way = first; status > 0; f->way++) {
    step_hold(f);
    f->load = load;
    status = dlsi_forming_contact_loop(f, error);
    if (f->way == last || status <= 0 || dlsi_forming_is_over(status)) break;
  }
  if (status < 0 || dlsi_forming_is_over(status)) return status;
  if (status > 0) {
    dls_forming_fault *fault = &f->data.fault;
    if (f->inside_out >= 0)
      dlsi_forming_blame(fault, DLS_FORMING_ELEMENT, f->inside_out, -1, -1, 0);
    else
      dlsi_forming_blame(fault, DLS_FORMING_NEWTON, -1, -1, dlsi_forming_worst_node(f),
                         f->data.equilibrium);
  } else {
    step_book(f);
    dlsi_forming_press(f);
    if (!step_is_good(f)) status = DLS_FOLDED;
  }
  if (status > 0) f->data.fault.travel = load * f->whole;
  return status;
}

/* Returns how far the force at the end deviates from its trend. */
static double step_jump(const dls_forming *f) {
  return fabs(f->book.force - f->data.force - f->slope * (f->load - f->load0));
}

/* Repeats the part up to `load`, which has just succeeded, in two halves, (FS3). Returns DLS_OK if
 * they agree; with step_tol they then are the end of the step. A jump that they confirm leaves the
 * step unchanged: the path is the one that was asked for. */
static dls_status step_compare(dls_forming *f, double load, double jump, dls_error *error) {
  const double force = f->book.force, share = load - f->load0, middle = f->load0 + share / 2;
  const double largest = fmax(f->largest, fabs(force));
  const double allowed =
      f->settings.step_tol > 0 ? f->settings.step_tol * largest : jump_agreement * jump;
  step_keep(f);
  f->data.count.compared++;
  dls_status status = step_try(f, middle, error);
  if (status == DLS_OK) {
    step_commit(f);
    status = step_try(f, load, error);
  }
  const double off = fabs(f->book.force - force);
  if (status == DLS_OK && !(off <= allowed)) {
    dlsi_forming_blame(&f->data.fault, DLS_FORMING_JUMP, -1, -1, -1, jump);
    f->data.fault.travel = load * f->whole;
    status = DLS_FOLDED;
  }
  if (status == DLS_OK && f->settings.step_tol > 0) {
    step_commit(f);
    f->data.step_error += off;
    return DLS_OK;
  }
  step_undo(f);
  if (status == DLS_OK) status = step_try(f, load, error);
  if (status == DLS_OK) step_commit(f);
  return status;
}

/* Advances from load0 to `load`. halvings: in, how often the step has been halved so far. */
static dls_status step_advance(dls_forming *f, double load, int halvings, dls_error *error) {
  dls_status status = step_try(f, load, error);
  if (status == DLS_OK) {
    const double jump = step_jump(f);
    const int jumps = f->data.travel > 0 && jump > jump_bound * fmax(f->largest, f->book.force);
    if (halvings < most_halvings && (jumps || f->settings.step_tol > 0))
      status = step_compare(f, load, jump, error);
    else
      step_commit(f);
  }
  if (status <= DLS_OK || dlsi_forming_is_over(status) || halvings == most_halvings)
    return status; /* (FS4) */
  f->data.count.halvings++;
  f->part = 0;
  const double middle = f->load0 + (load - f->load0) / 2;
  status = step_advance(f, middle, halvings + 1, error);
  return status ? status : step_advance(f, load, halvings + 1, error);
}

static dls_status step_take(dls_forming *f, dls_error *error) {
  const int step = f->step + 1, steps = f->settings.steps;
  if (step > steps)
    return dlsi_fail(error, DLS_E_ARGUMENT, "forming", -1, steps, "has done all of its %d steps",
                     steps);
  f->data.fault = (dls_forming_fault){0};
  f->begun = dlsi_forming_seconds();
  const dls_status status = step_advance(f, (double)step / steps, 0, error);
  if (status == DLS_OK)
    f->step = step;
  else
    step_restore(f);
  if (dlsi_forming_is_over(status)) f->data.fault = (dls_forming_fault){0};
  dlsi_forming_move_tools(f);
  f->seconds += dlsi_forming_seconds() - f->begun;
  return status;
}

dls_status dls_forming_step(dls_forming *forming, dls_error *error) {
  DLSI_DOOR;
  if (!forming) return dlsi_at(__func__, dlsi_is_null(error, "forming"), error);
  return dlsi_at(__func__, step_take(forming, error), error);
}

void dls_forming_get(const dls_forming *forming, dls_forming_data *data) {
  if (data) *data = forming ? forming->data : (dls_forming_data){0};
}
