/*
 * forming.c: runs the loops of a step of [Chabrand 1998] Table 1.
 *
 *   loading loop: forming_step.c                                                           (FO1)
 *     x := x0 plus the displacement of the last step, r := r0                                (FO2)
 *     contact loop: frames n, t and gaps at x; augmented Lagrangian: multipliers := r        (FO3)
 *       equilibrium loop, frames frozen:
 *         dx, r' of the linearised contact problem (forming_contact.c)                       (FO4)
 *         (x, r) += s (dx, r' - r), s = 1, 1/2, ..                                           (FO5)
 *       until equilibrium, |F(x) - H r| <= tol |F|, also summed up, and laws hold
 *     until equilibrium and laws hold in the frames at x
 *     states, x0, r0 := those at x                                                           (FO6)
 *
 *   u_n = gap + n.(x - anchor),   u_t = t.(x - x0 - motion of the obstacle since load0)      (FO7)
 *
 * If the last obstacle is a moving plane, the ram, the loop ends with a check of the nodes of the
 * boundary. Nodes beyond the plane are held by it from now on, a support of y; nodes that the plane
 * would pull are released. After a change the loop goes on                                 (FO9)
 *
 * Laws hold if the certificate of contact.h holds for each contact with the others frozen,
 * W_cc = 2 / trace(K_cc), as in primal.h. (FO5) halves s while an element is inside out, or, at
 * most three times, while the forces out of balance grow. The second method of auto halves up to
 * seven times: if guesses of stick, slip and yield alternate, other cuts may end the cycle. While
 * supports still move the forces may grow: the path starts out of contact.
 *
 * Deviation. The paper neglects the variation of the frames, the second part of (26). The contact
 * loop then oscillates without end when a heavily loaded node passes the rounded corner of the die:
 * each rotation of the frame moves the node by r_n curvature / stiffness times the last motion, and
 * a plastic body is soft along the surface. Here the equilibrium loop rotates the reactions with
 * the node, to first order,
 *
 *   H r + b t t.(x - anchor),   b = curvature r_n of the previous pass                       (FO8)
 *
 * The rotation vanishes at the end of the contact loop, where anchor = x. The term of r_t is left
 * out. What can fail: a step that is too large for the loops, DLS_STALLED. Half steps are another
 * load path, and plastic answers depend on the path. If Newton's method does not contract, rounding
 * decides which steps are halved, and answers of two machines may differ by percents.
 */
#include <math.h>
#include <string.h>

#include "forming_internal.h"

enum { most_frames = 40, most_cuts = 8, cuts_for_balance = 3, most_turns = 2 };

/* ---- forces ---------------------------------------------------------------------------------- */

/* Assembles F, K, new states and energy at x; returns 0 if an element fails. */
static int forming_assemble(dls_forming *f) {
  const double start = dlsi_forming_seconds();
  double *K = f->band.a;
  int good = 1;
  dlsi_band_clear(&f->band);
  memset(f->F, 0, (size_t)f->n * sizeof *f->F);
  f->elastic = f->plastic = 0;
  for (int e = 0; good && e < f->mesh.quads; e++) {
    const int *node = f->mesh.node + 4 * e;
    double X[8], x[8], Fe[8], Ke[64], energy[2];
    for (int k = 0; k < 8; k++) {
      X[k] = f->mesh.xy[2 * node[k / 2] + k % 2];
      x[k] = f->x[2 * node[k / 2] + k % 2];
    }
    const dlsi_q4 element = {f->axisymmetric, f->settings.standard, X, x};
    good = dlsi_q4_forces(&element, &f->solid, f->old + 4 * e, f->now + 4 * e, Fe, Ke, energy,
                          f->stress + 16 * e);
    if (!good) {
      f->inside_out = e;
      break;
    }
    f->elastic += energy[0];
    f->plastic += energy[1];
    for (int l = 0; l < 8; l++) {
      const int column = 2 * node[l / 2] + l % 2;
      f->F[column] += Fe[l];
      for (int k = 0; k < 8; k++)
        K[dlsi_band_at(&f->band, 2 * node[k / 2] + k % 2, column)] += Ke[k + 8 * l];
    }
  }
  for (int c = 0; c < f->nc; c++) {
    const int i = 2 * f->candidate[c], j = i + 1;
    f->stiff[c] =
        (fabs(K[dlsi_band_at(&f->band, i, i)]) + fabs(K[dlsi_band_at(&f->band, j, j)])) / 2;
  }
  f->data.cpu.assembly += dlsi_forming_seconds() - start;
  return good;
}

void dlsi_forming_push(const dls_forming *f, const double *r, double *y) {
  for (int c = 0; c < f->nc; c++)
    for (int i = 0; i < 2; i++)
      y[2 * f->candidate[c] + i] +=
          f->normal[2 * c + i] * r[2 * c] + f->tangent[2 * c + i] * r[2 * c + 1];
}

/* Returns |F - H r|, (FO8) included, over the free unknowns. */
static double forming_imbalance(const dls_forming *f) {
  double sum = 0;
  memset(f->rhs, 0, (size_t)f->n * sizeof *f->rhs);
  dlsi_forming_push(f, f->r, f->rhs);
  dlsi_forming_turn(f, f->rhs);
  for (int i = 0; i < f->n; i++) {
    const double d = f->F[i] - f->rhs[i];
    if (!f->fixed[i]) sum += d * d;
  }
  return sqrt(sum);
}

/* Returns |F - H r| / |F|. */
static double forming_equilibrium(const dls_forming *f) {
  const double out = forming_imbalance(f);
  return out == 0 ? 0 : out / dlsi_norm2(f->F, (size_t)f->n);
}

/* ---- frames and laws ------------------------------------------------------------------------- */

/* Sets frames, gaps and bends at x. */
static void forming_set_frames(dls_forming *f) { /* (FO3) */
  for (int c = 0; c < f->nc; c++) {
    const double *x = f->x + 2 * f->candidate[c];
    const dlsi_rigid *rigid = &f->rigid[f->meets[c]];
    const double seen[2] = {x[0] - f->load * rigid->way[0], x[1] - f->load * rigid->way[1]};
    double *n = f->normal + 2 * c, curvature;
    f->gap[c] = dlsi_obstacle_gap(&rigid->profile, seen, n, &curvature);
    f->bend[c] = curvature * f->r[2 * c];
    f->tangent[2 * c] = n[1];
    f->tangent[2 * c + 1] = -n[0];
    memcpy(f->anchor + 2 * c, x, 2 * sizeof *x);
  }
}

/* Sets u at x. */
static void forming_set_positions(dls_forming *f) { /* (FO7) */
  const double since = f->load - f->load0;
  for (int c = 0; c < f->nc; c++) {
    const int i = 2 * f->candidate[c];
    const double *n = f->normal + 2 * c, *t = f->tangent + 2 * c, *a = f->anchor + 2 * c;
    const double *way = f->rigid[f->meets[c]].way;
    f->u[2 * c] = f->gap[c] + n[0] * (f->x[i] - a[0]) + n[1] * (f->x[i + 1] - a[1]);
    f->u[2 * c + 1] = t[0] * (f->x[i] - f->x0[i] - since * way[0]) +
                      t[1] * (f->x[i + 1] - f->x0[i + 1] - since * way[1]);
  }
}

/* Certifies r. Open contacts without reaction obey the laws to the last bit. Their gaps, which may
 * be large, do not count in |q|. */
static dls_status forming_certify(dls_forming *f, dls_error *error) {
  int count = 0;
  for (int c = 0; c < f->nc; c++) {
    const double *r = f->r + 2 * c, *u = f->u + 2 * c;
    if (r[0] == 0 && r[1] == 0 && u[0] >= 0) continue;
    for (int i = 0; i < 2; i++) {
      f->node_r[2 * count + i] = r[i];
      f->node_q[2 * count + i] = u[i] - r[i] / f->stiff[c];
    }
    f->node_W[4 * count] = f->node_W[4 * count + 3] = 1 / f->stiff[c];
    f->node_mu[count++] = f->mu[c];
  }
  f->data.certificate = (dls_certificate){0};
  if (!count) return DLS_OK;
  const dls_contact nodes = {.d = 2,
                             .nc = count,
                             .Wb = {2, count, f->node_p, f->node_i, f->node_W},
                             .q = f->node_q,
                             .mu = f->node_mu};
  return dls_contact_certify(&nodes, f->node_r, NULL, &f->data.certificate, error);
}

/* Returns |sum of F - H r over the free unknowns| over the sum of |H r|, by components that have to
 * balance. Internal forces add up to zero: this is the error of tools and supports. The norm of F -
 * H r does not bound it. Reads rhs of forming_imbalance. */
static double forming_net_force(const dls_forming *f) {
  double net[2] = {0}, size = 0;
  for (int i = f->axisymmetric; i < f->n; i += 1 + f->axisymmetric) {
    if (f->fixed[i]) continue;
    net[i % 2] += f->F[i] - f->rhs[i];
    size += fabs(f->rhs[i]);
  }
  return size > 0 ? dlsi_norm2(net, 2) / size : 0;
}

/* Measures the equilibrium; returns 1 if it holds to the tolerance. */
static int forming_balanced(dls_forming *f) {
  f->data.equilibrium = forming_equilibrium(f);
  const double tol = f->settings.tol;
  /* sweeps leave long waves: their sum is checked only at the end of the step */
  const int sweeps = f->settings.contact == DLS_FORMING_GAUSS_SEIDEL;
  return f->data.equilibrium <= tol && (sweeps || forming_net_force(f) <= tol);
}

/* Returns 1 if equilibrium and laws hold in the frozen frames (penalty: the laws of its springs), 0
 * if one of them does not, an error < 0. */
static int forming_holds(dls_forming *f, dls_error *error) {
  const double tol = f->settings.tol;
  if (!forming_balanced(f)) return 0;
  const dls_status status = forming_certify(f, error);
  if (status) return status;
  return dlsi_forming_springs(f) && dlsi_forming_stays(f)
             ? dlsi_forming_stretch(f) <= tol
             : dls_certificate_holds(&f->data.certificate, tol);
}

/* ---- loops ----------------------------------------------------------------------------------- */

/* (x, r) := the start of the Newton step plus s times the step. */
static void forming_move(dls_forming *f, double s) {
  for (int i = 0; i < f->n; i++)
    f->x[i] = f->start_x[i] + s * f->dx[i];
  for (int i = 0; i < 2 * f->nc; i++)
    f->r[i] = f->start_r[i] + s * (f->next_r[i] - f->start_r[i]);
  forming_set_positions(f);
}

/* Assembles at x and returns 1 if (FO5) takes the step.
 *   before: in, the imbalance before the step; grow: in, 1 if it may grow */
static int forming_acceptable(dls_forming *f, double before, int grow) {
  if (!forming_assemble(f)) return 0;
  return grow || forming_imbalance(f) <= before || forming_equilibrium(f) <= f->settings.tol;
}

/* Returns 1 if the caller's progress callback ends the step. */
static int forming_is_cancelled(const dls_forming *f) {
  if (!f->settings.progress) return 0;
  const dls_progress now = {.method = "forming",
                            .stage = "",
                            .iteration = f->step + 1,
                            .max_iterations = f->settings.steps,
                            .residual = f->data.equilibrium,
                            .cpu_seconds = f->seconds + dlsi_forming_seconds() - f->begun};
  return f->settings.progress(f->settings.progress_data, &now);
}

/* Runs the equilibrium loop.
 *   away: in and out, fraction of the travel of supports and reactions of springs still to go */
static dls_status forming_equilibrate(dls_forming *f, double *away, dls_error *error) {
  const int springs = dlsi_forming_springs(f);
  const int patient = f->way == DLS_FORMING_ON_W;
  const int cuts = patient ? most_cuts - 1 : cuts_for_balance;
  if (springs) *away = 1; /* frames and multipliers are new */
  f->data.residuals = 0;
  for (int k = 0;; k++) {
    const int done = springs ? forming_balanced(f) : forming_holds(f, error);
    if (done < 0) return (dls_status)done;
    f->data.residual[f->data.residuals++] = f->data.equilibrium;
    if (done && *away == 0) return DLS_OK;
    if (k == DLS_FORMING_MOST_STEPS) return DLS_STALLED;
    if (f->settings.cpu_seconds > 0 && dlsi_forming_left(f) <= 0) return DLS_TIME_LIMIT;
    if (forming_is_cancelled(f)) return DLS_CANCELLED;
    const double before = forming_imbalance(f);
    const dls_status status = dlsi_forming_direction(f, error); /* (FO4) */
    if (status < 0) return status;
    f->data.count.newton++;
    memcpy(f->start_x, f->x, (size_t)f->n * sizeof *f->x);
    memcpy(f->start_r, f->r, 2 * (size_t)f->nc * sizeof *f->r);
    double s = 1;
    forming_move(f, s);
    for (int cut = 0; !forming_acceptable(f, before, *away > 0 || cut >= cuts); cut++) {
      if (cut == most_cuts) return DLS_STALLED; /* (FO5) */
      s /= 2;
      forming_move(f, s);
    }
    *away *= 1 - s;
  }
}

/* Starts a step, (FO2); returns 0 if an element fails even at x0. */
static int forming_start(dls_forming *f) {
  const double ahead = f->part > 0 ? (f->load - f->load0) / f->part : 0;
  memcpy(f->r, f->r0, 2 * (size_t)f->nc * sizeof *f->r);
  for (int i = 0; i < f->n; i++)
    f->x[i] = f->x0[i] + ahead * (f->x0[i] - f->before[i]);
  if (ahead > 0 && forming_assemble(f)) return 1;
  memcpy(f->x, f->x0, (size_t)f->n * sizeof *f->x);
  return forming_assemble(f);
}

double dlsi_forming_held_friction(const dls_forming *f, int c) {
  const double slip = f->u[2 * c + 1];
  return !f->held[f->candidate[c]] || slip == 0
             ? 0
             : (slip > 0 ? -1 : 1) * f->settings.mu * f->r[2 * c];
}

int dlsi_forming_worst_node(const dls_forming *f) {
  int worst = 0;
  double largest = 0;
  for (int i = 0; i < f->n; i++) {
    const double d = fabs(f->F[i] - f->rhs[i]);
    if (f->fixed[i] || !(d > largest)) continue;
    largest = d;
    worst = i / 2;
  }
  return worst;
}

/* Holds the nodes that have met the moving plane and releases those that the plane would pull;
 * returns 1 if a node has changed. */
static int forming_renew_holds(dls_forming *f) { /* (FO9) */
  int changed = 0;
  if (!f->holds) return 0;
  const dlsi_rigid *plane = &f->rigid[f->rigids - 1];
  const double y = plane->piece[0].a[1] + f->load * plane->way[1];
  for (int k = 0; k < f->edges; k++) {
    const int node = f->edge[k], i = 2 * node + 1, c = f->candidate_of[node];
    if ((c >= 0 && f->meets[c] == f->rigids - 1) || f->turns[node] == most_turns) continue;
    double pull = f->F[i];
    if (c >= 0)
      pull -= f->normal[2 * c + 1] * f->r[2 * c] +
              f->tangent[2 * c + 1] * dlsi_forming_held_friction(f, c);
    const int on = f->held[node] ? !(pull > 0) : f->x[i] > y;
    if (on == f->held[node]) continue;
    dlsi_forming_hold(f, node, on);
    f->turns[node]++;
    changed = 1;
  }
  return changed;
}

dls_status dlsi_forming_contact_loop(dls_forming *f, dls_error *error) {
  memset(f->turns, 0, (size_t)f->mesh.nodes * sizeof *f->turns);
  f->inside_out = -1;
  if (!forming_start(f)) return DLS_STALLED;
  dlsi_forming_set_springs(f);
  double away = 1;
  for (int pass = 0; pass < most_frames; pass++) {
    if (pass > 0) dlsi_forming_augment(f);
    forming_set_frames(f);
    forming_set_positions(f);
    if (pass > 0) {
      const int done = forming_holds(f, error);
      if (done < 0) return (dls_status)done;
      if (done && !forming_renew_holds(f)) return DLS_OK;
      if (done) away = 1;
    }
    f->data.count.frames++;
    const dls_status status = forming_equilibrate(f, &away, error);
    if (status) return status;
  }
  return DLS_STALLED;
}

void dlsi_forming_show(dls_forming *f) {
  (void)forming_assemble(f);
  forming_set_frames(f);
  forming_set_positions(f);
}

dls_status dls_forming_problem(const dls_forming *forming, dls_contact *problem, dls_error *error) {
  DLSI_DOOR;
  dls_status status = DLS_OK;
  if (!forming || !problem)
    status = dlsi_is_null(error, forming ? "problem" : "forming");
  else if (!forming->problem.nc)
    status = dlsi_fail(error, DLS_E_ARGUMENT, "forming", -1, 0, "has condensed no problem yet");
  else
    *problem = forming->problem;
  return dlsi_at(__func__, status, error);
}
