/*
 * primal.c: projected Gauss-Seidel on the displacements, [Chabrand 1998] 4.2, (37)-(38).
 *
 *   K x = f + r,   0 <= u_n _|_ r_n >= 0,   |r_t| <= b,   u_t opposed to r_t where it slips,
 *   b = mu r_n
 *
 * in the local frames of frames.c: x_c = u_c - g_c, and r stands at the unknowns of the contact
 * nodes. For given thresholds b this is Tresca's problem, the minimum under u_n >= 0 of the
 * strictly convex Q(x) = x^T K x / 2 - f^T x + sum_c b_c |u_tc|, (38). R = f - K x is kept up to
 * date by columns, which are the rows of K. One sweep visits the unknowns in their order:
 *
 *   (PR1)  x_i += omega R_i / K_ii                    an unknown without contact
 *   (PR2)  u_c := the solution of Tresca's problem of node c alone, the others frozen
 *   (PR3)  Aitken: x := s - gamma (s - s_before), s the end of a sweep, if that does not raise Q
 *   (PR4)  b_c := mu_c max(0, r_nc), r = -R at the contact nodes: a step of the fixed point, taken
 *          instead of (PR3) when Tresca's problem is solved to half of the residual of
 *          Coulomb's
 *   (PR5)  the certificate (primal.h) from a fresh R, when its estimate from the current R meets
 *          the target, when a sweep changes nothing, and every 50 sweeps
 *
 * (PR3) With x_k the start of sweep k, s_k its end and f_k = s_k - x_k,
 *
 *   gamma = <f_k - f_k-1, f_k> / |f_k - f_k-1|^2,   x_k+1 = s_k - gamma (s_k - s_k-1)
 *
 * in the scalar product of diag(K): Aitken's Delta^2 for vectors, by Irons and Tuck (Anderson's
 * with a memory of one). It accelerates the sweeps, not the fixed point. It replaces
 * over-relaxation, whose parameter [C] wants to avoid, and most time goes into sweeps: [J] Fig. 3
 * to 1e-12 takes 495 sweeps and 19 steps of the fixed point. R is affine in x, so (PR3) takes no
 * product with K, and neither does Q(x) - Q(s) = -(x - s)^T (R_x + R_s) / 2 + sum_c b_c (|u_tc
 * of x| - |u_tc of s|).
 *
 * Convergence: each (PR1) with 0 < omega < 2, (PR2) and (PR3) never raises Q, so the sweeps
 * solve Tresca's problem from any start. The fixed point is a contraction for small mu only.
 *
 * Source: [C] 4.2, which gives no formula for its Aitken procedure. Deviations: a contact node
 * takes the exact solution of its 2 x 2 problem, n and t together, without over-relaxation (no gain
 * on [J] Figs. 3 and 4, and against the argument above); the inner problems are not solved to the
 * end (PR4), which the paper leaves open; R is updated by columns, not (K x)_i by rows: the same
 * products, but an unknown that stays costs nothing, and residual, Q and d^T K d are free.
 *
 * Cost of a sweep: one pass over the columns of K, and O(n).
 * What can fail: the fixed point diverges or cycles for large mu (DLS_MAX_ITERATIONS); the number
 * of sweeps grows with the mesh.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/primal.h"
#include "vi/vi_internal.h"

enum { most_sweeps = 100000, refresh_every = 50 };

struct dls_primal {
  dls_primal_settings settings;
  atomic_int busy;
  dlsi_frames K;
  /* of unknowns, n each */
  double *inverse; /* 1 / K_ii */
  double *f, *g;   /* loads; gaps, 0 off the contact nodes */
  double *x, *R;   /* x + g (so that it is u at the contact nodes), f - K x */
  double *x0, *R0; /* at the start of the sweep, then the proposal of (PR3) */
  double *s, *Rs;  /* at the end of the sweep before */
  double *step;    /* of the sweep before */
  double *a;       /* |f| + |K| (|x| + |g|) */
  double *best;    /* x with the smallest residual */
  /* of contact nodes, one each */
  double *mu, *b, *w;       /* friction, thresholds, weights of the certificate */
  double *coupling, *schur; /* K_nt; K_tt - K_tn K_nn^-1 K_nt */
  /* of contact nodes, two each: for the certificate */
  double *r, *u, *q, *A, *F;
  double begun; /* CPU seconds when the solve began; -1: not needed */
};

static const char primal_name[] = "gauss-seidel"; /* in calls of progress */

void dls_primal_settings_init(dls_primal_settings *settings) {
  if (!settings) return;
  *settings = (dls_primal_settings){.size = sizeof *settings, .relaxation = 1, .aitken = 1};
  dlsi_limits_init(&settings->limits);
}

static dls_status primal_check(const dls_primal_settings *s, const dls_model *model,
                               dls_error *error) {
  const dlsi_setting own[] = {{"relaxation", s->relaxation, 0, 2, 1},
                              {"aitken", s->aitken, 0, 1, 0}};
  dls_status status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 2, own, error);
  if (!status) status = dlsi_check_model(model, error);
  if (status) return status;
  if (model->d != 2)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "d", -1, model->d, "is %d; this method is for d = 2",
                     model->d);
  if (model->operator_kind != DLS_STIFFNESS_DENSE && model->operator_kind != DLS_STIFFNESS_SPARSE)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "operator_kind", -1, model->operator_kind,
                     "this method works on the entries of a stiffness matrix");
  if (model->factorization != DLS_CHOLESKY)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "factorization", -1, model->factorization,
                     "this method is for K symmetric positive definite: DLS_CHOLESKY");
  if (model->P.p)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "P", -1, model->P.cols,
                     "weighted reactions couple the contact nodes; condense this model");
  if (model->active)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "active", -1, 0,
                     "this method takes every contact node; give HN and HT of the active ones");
  return DLS_OK;
}

static void primal_carve(void *workspace, dlsi_arena *arena) {
  dls_primal *p = workspace;
  const size_t nodes = (size_t)p->K.nodes;
  double **const of_unknowns[] = {&p->inverse, &p->f, &p->g,  &p->x,    &p->R, &p->x0,
                                  &p->R0,      &p->s, &p->Rs, &p->step, &p->a, &p->best};
  double **const of_nodes[] = {&p->mu, &p->b, &p->coupling, &p->schur};
  double **const of_pairs[] = {&p->r, &p->u, &p->q, &p->A, &p->F, &p->w};
  dlsi_take_vectors(arena, (size_t)p->K.n, 12, of_unknowns);
  dlsi_take_vectors(arena, nodes, 4, of_nodes);
  dlsi_take_vectors(arena, 2 * nodes, 6, of_pairs);
}

/* Computes the arrays that depend on K alone. */
static void primal_prepare(dls_primal *p) {
  const dlsi_frames *K = &p->K;
  for (int i = 0; i < K->n; i++)
    p->inverse[i] = 1 / K->diagonal[i];
  for (int c = 0; c < K->nodes; c++) {
    const int i = K->normal[c], j = K->tangent[c];
    p->coupling[c] = dlsi_frames_coupling(K, c);
    const double ratio = p->coupling[c] / K->diagonal[i];
    p->schur[c] = K->diagonal[j] - p->coupling[c] * ratio;
    /* the diagonal of K_cc^-1 */
    p->w[2 * c] = 1 / K->diagonal[i] + ratio * ratio / p->schur[c];
    p->w[2 * c + 1] = 1 / p->schur[c];
  }
}

static dls_status primal_create(void **out, const dls_model *model,
                                const dls_primal_settings *settings, dls_error *error) {
  dls_primal filled = {0};
  dls_primal_settings_init(&filled.settings);
  if (settings) filled.settings = *settings;
  dls_status status = primal_check(&filled.settings, model, error);
  if (!status) status = dlsi_frames_create(&filled.K, model, error);
  if (!status)
    status = dlsi_workspace(out, &filled, sizeof filled, primal_carve, model->nodes, error);
  if (status)
    dlsi_frames_free(&filled.K);
  else
    primal_prepare(*out);
  return status;
}

dls_status dls_primal_create(dls_primal **out, const dls_model *model,
                             const dls_primal_settings *settings, dls_error *error) {
  DLSI_DOOR;
  void *work = NULL;
  const dls_status status =
      out ? primal_create(&work, model, settings, error) : dlsi_is_null(error, "out");
  if (out) *out = work;
  return dlsi_at(__func__, status, error);
}

void dls_primal_destroy(dls_primal *workspace) {
  if (!workspace) return;
  dlsi_frames_free(&workspace->K);
  free(workspace);
}

/* ---- the sweep ------------------------------------------------------------------------------- */

/* x_i := value, and updates R. Returns 1 if x_i changes. */
static int primal_move(const dlsi_frames *K, int i, double value, double *x, double *R) {
  const double step = value - x[i];
  if (step == 0) return 0;
  x[i] = value;
  for (size_t k = K->start[i]; k < K->start[i + 1]; k++)
    R[K->row[k]] -= K->value[k] * step;
  return 1;
}

/* Returns the u_t that minimises k u_t^2 / 2 + p u_t + b |u_t|. */
static double primal_slip(double k, double p, double b) {
  return p > b ? -(p - b) / k : p < -b ? -(p + b) / k : 0;
}

/* (PR2) r = p + K_cc u: contact if that leaves r_n >= 0, else free. Returns 1 if u has changed. */
static int primal_visit_node(const dls_primal *work, int c, double *x, double *R) {
  const dlsi_frames *K = &work->K;
  const int i = K->normal[c], j = K->tangent[c];
  const double k_nn = K->diagonal[i], k_nt = work->coupling[c], k_tt = K->diagonal[j];
  const double pn = -R[i] - (k_nn * x[i] + k_nt * x[j]);
  const double pt = -R[j] - (k_nt * x[i] + k_tt * x[j]);
  double un = 0, ut = primal_slip(k_tt, pt, work->b[c]);
  if (!(pn + k_nt * ut >= 0)) {
    ut = primal_slip(work->schur[c], pt - k_nt * (pn / k_nn), work->b[c]);
    un = -(pn + k_nt * ut) / k_nn;
  }
  const int changed = primal_move(K, i, un, x, R);
  return primal_move(K, j, ut, x, R) || changed;
}

/* One sweep; returns 1 if anything changed. */
static int primal_sweep(const dls_primal *work) {
  const dlsi_frames *K = &work->K;
  const double omega = work->settings.relaxation;
  double *x = work->x, *R = work->R;
  int changed = 0;
  for (int i = 0; i < K->n; i++) {
    const int c = K->node[i];
    if (c < 0)
      changed |= primal_move(K, i, x[i] + omega * (R[i] * work->inverse[i]), x, R); /* (PR1) */
    else if (K->normal[c] == i)
      changed |= primal_visit_node(work, c, x, R); /* (PR2) */
  }
  return changed;
}

/* ---- the certificate ------------------------------------------------------------------------- */

/* R := f - K x afresh, and a := |f| + |K| (|x| + |g|), the size of the terms that round in R. */
static void primal_refresh(const dls_primal *work) {
  const dlsi_frames *K = &work->K;
  memcpy(work->R, work->f, (size_t)K->n * sizeof *work->R);
  for (int i = 0; i < K->n; i++)
    work->a[i] = fabs(work->f[i]);
  for (int j = 0; j < K->n; j++) {
    const double x = work->x[j] - work->g[j], size = fabs(work->x[j]) + fabs(work->g[j]);
    for (size_t k = K->start[j]; k < K->start[j + 1]; k++) {
      work->R[K->row[k]] -= K->value[k] * x;
      work->a[K->row[k]] += fabs(K->value[k]) * size;
    }
  }
}

/* u := K_cc^-1 r, by the pivots k_nn and schur. */
static void primal_flexibility(const dls_primal *work, int c, double rn, double rt, double u[2]) {
  const double k_nn = work->K.diagonal[work->K.normal[c]], k_nt = work->coupling[c];
  u[1] = (rt - k_nt * (rn / k_nn)) / work->schur[c];
  u[0] = (rn - k_nt * u[1]) / k_nn;
}

/* Returns sqrt( sum v_i^2 / K_ii ), over the unknowns without contact or, all = 1, over all. */
static double primal_force_norm(const dls_primal *work, const double *v, int all) {
  double sum = 0;
  for (int i = 0; i < work->K.n; i++)
    if (all || work->K.node[i] < 0) sum += v[i] * (v[i] * work->inverse[i]);
  return sqrt(sum);
}

typedef struct primal_measure {
  double equilibrium;
  dls_certificate laws; /* its residuals */
  double tresca;        /* residual_u with |r_t| <= b for |r_t| <= mu r_n */
} primal_measure;

static double primal_ratio(double part, double whole) {
  return part == 0 ? 0 : part / whole;
}

/* r (2) := the reaction -R of contact c: 0 if that is only the rounding of R. */
static void primal_reaction(const dls_primal *work, int c, double *r) {
  const int of[2] = {work->K.normal[c], work->K.tangent[c]};
  const double rounding = 4 * DBL_EPSILON * (work->a[of[0]] + work->a[of[1]]);
  const int is_rounding = fabs(work->R[of[0]]) + fabs(work->R[of[1]]) <= rounding;
  for (int i = 0; i < 2; i++)
    r[i] = is_rounding ? 0 : -work->R[of[i]];
}

/* Estimates the certificate from the current R; load = |f|. */
static primal_measure primal_estimate(const dls_primal *work, double load) {
  const dlsi_frames *K = &work->K;
  double laws = 0, tresca = 0, size = 0; /* squares, in displacements */
  double force = 0, r2 = 0, reactions = 0;
  for (int c = 0; c < K->nodes; c++) {
    const int i = K->normal[c], j = K->tangent[c];
    const double u[2] = {work->x[i], work->x[j]};
    const double *w = work->w + 2 * (size_t)c, limit = w[1] * work->b[c];
    double r[2], F[3], q[2];
    primal_reaction(work, c, r);
    const int touches = dlsi_contact_misfit(2, work->mu[c], w, r, u, F) != DLS_FREE;
    laws += F[0] * F[0] + F[1] * F[1];
    force += F[0] / w[0] * (F[0] / w[0]) + F[1] / w[1] * (F[1] / w[1]);
    const double vn = w[0] * r[0] - u[0], vt = w[1] * r[1] - u[1];
    F[0] = w[0] * r[0] - (vn > 0 ? vn : 0);
    F[1] = w[1] * r[1] - (vt > limit ? limit : vt < -limit ? -limit : vt);
    tresca += F[0] * F[0] + F[1] * F[1];
    primal_flexibility(work, c, r[0], r[1], q);
    if (touches) {
      r2 += r[0] * r[0] + r[1] * r[1];
      size += (u[0] - q[0]) * (u[0] - q[0]) + (u[1] - q[1]) * (u[1] - q[1]);
    }
    reactions += r[0] * (r[0] * work->inverse[i]) + r[1] * (r[1] * work->inverse[j]);
  }
  const double out_of_balance = primal_force_norm(work, work->R, 0);
  primal_measure now = {.equilibrium = primal_ratio(out_of_balance, load + sqrt(reactions)),
                        .tresca = size > 0 ? sqrt(tresca / size) : tresca > 0};
  const double residual_u = size > 0 ? sqrt(laws / size) : laws > 0; /* 0: nothing touches */
  dlsi_set_residuals(&now.laws, residual_u, sqrt(force), sqrt(r2));
  return now;
}

/* (PR5) *info := the certificate of x from a fresh R; r, u := those of x. */
static void primal_certify(const dls_primal *work, double load, dls_primal_info *info) {
  const dlsi_frames *K = &work->K;
  primal_refresh(work);
  for (int c = 0; c < K->nodes; c++) {
    const size_t n = 2 * (size_t)c, t = n + 1;
    const int i = K->normal[c], j = K->tangent[c];
    const double coupling = fabs(work->coupling[c]) / K->diagonal[i];
    double q[2];
    primal_reaction(work, c, work->r + n);
    work->u[n] = work->x[i];
    work->u[t] = work->x[j];
    primal_flexibility(work, c, work->r[n], work->r[t], q);
    work->q[n] = work->u[n] - q[0];
    work->q[t] = work->u[t] - q[1];
    /* |u| + |K_cc^-1| a */
    work->A[t] = (work->a[j] + coupling * work->a[i]) / work->schur[c];
    work->A[n] = work->a[i] / K->diagonal[i] + coupling * work->A[t] + fabs(work->u[n]);
    work->A[t] += fabs(work->u[t]);
  }
  const dls_contact nodes = {.d = 2, .nc = K->nodes, .q = work->q, .mu = work->mu};
  dlsi_contact_measure(&nodes, work->r, work->u, work->A, work->w, work->F, &info->laws);
  double reactions = 0;
  for (int c = 0; c < K->nodes; c++) {
    const int i = K->normal[c], j = K->tangent[c];
    reactions += work->R[i] * (work->R[i] * work->inverse[i]);
    reactions += work->R[j] * (work->R[j] * work->inverse[j]);
  }
  const double scale = load + sqrt(reactions);
  info->equilibrium = primal_ratio(primal_force_norm(work, work->R, 0), scale);
  info->equilibrium_floor = DBL_EPSILON * primal_ratio(primal_force_norm(work, work->a, 1), scale);
}

static double primal_larger(double a, double b) {
  return a > b || a != a ? a : b;
}

static int primal_holds(const dls_primal_info *info, double tol) {
  return info->equilibrium <= dlsi_target(tol, info->equilibrium_floor) &&
         dls_certificate_holds(&info->laws, tol);
}

/* ---- acceleration, thresholds ---------------------------------------------------------------- */

/* (PR4); returns 1 if any b_c changed. */
static int primal_set_thresholds(const dls_primal *work) {
  int changed = 0;
  for (int c = 0; c < work->K.nodes; c++) {
    const double rn = -work->R[work->K.normal[c]], b = rn > 0 ? work->mu[c] * rn : 0;
    changed |= work->b[c] != b;
    work->b[c] = b;
  }
  return changed;
}

typedef struct primal_comparison {
  double gamma;     /* of (PR3) */
  double curvature; /* d^T K d / d^T diag(K) d of the sweep's step d */
  double length;    /* |d| / |x| in the norm of diag(K) */
} primal_comparison;

/* Compares the sweep's step with the one before, which it replaces. */
static primal_comparison primal_compare_steps(const dls_primal *work) {
  const double *D = work->K.diagonal;
  double ff = 0, fd = 0, dd = 0, fKf = 0, xx = 0;
  for (int i = 0; i < work->K.n; i++) {
    const double f = work->x[i] - work->x0[i], d = f - work->step[i];
    ff += D[i] * f * f;
    fd += D[i] * f * d;
    dd += D[i] * d * d;
    fKf -= f * (work->R[i] - work->R0[i]);
    xx += D[i] * work->x[i] * work->x[i];
    work->step[i] = f;
  }
  return (primal_comparison){primal_ratio(fd, dd), primal_ratio(fKf, ff),
                             sqrt(primal_ratio(ff, xx))};
}

static void primal_rotate(double **x, double **s, double **x0) {
  double *free_one = *s;
  *s = *x;
  *x = *x0;
  *x0 = free_one;
}

/* (PR3) x := s_k - gamma (s_k - s_k-1) with u_n >= 0 if that does not raise Q; s := s_k. */
static void primal_extrapolate(dls_primal *work, double gamma) {
  const dlsi_frames *K = &work->K;
  const double *x = work->x, *R = work->R;
  double *y = work->x0, *Ry = work->R0; /* free by now */
  for (int i = 0; i < K->n; i++) {
    y[i] = x[i] - gamma * (x[i] - work->s[i]);
    Ry[i] = R[i] - gamma * (R[i] - work->Rs[i]);
  }
  for (int c = 0; c < K->nodes; c++)
    if (y[K->normal[c]] < 0) (void)primal_move(K, K->normal[c], 0, y, Ry);
  double rise = 0; /* of Q */
  for (int i = 0; i < K->n; i++)
    rise -= 0.5 * ((y[i] - x[i]) * (Ry[i] + R[i]));
  for (int c = 0; c < K->nodes; c++)
    rise += work->b[c] * (fabs(y[K->tangent[c]]) - fabs(x[K->tangent[c]]));
  if (rise <= 0) {
    primal_rotate(&work->x, &work->s, &work->x0);
    primal_rotate(&work->R, &work->Rs, &work->R0);
  } else {
    memcpy(work->s, x, (size_t)K->n * sizeof *x);
    memcpy(work->Rs, R, (size_t)K->n * sizeof *R);
  }
}

/* ---- the iteration --------------------------------------------------------------------------- */

static void primal_copy(const dls_primal *work, double *to, const double *from) {
  memcpy(to, from, (size_t)work->K.n * sizeof *to);
}

/* Returns 1 if Tresca's problem is solved to half of the residual of Coulomb's. */
static int time_for_thresholds(const primal_measure *now, double balance) {
  const double half = 0.5 * now->laws.residual_u;
  return now->tresca <= half && now->equilibrium <= primal_larger(half, balance);
}

/* Sweeps until the certificate holds. Returns DLS_OK, or the reason to stop before. work->x is then
 * the best iterate, and work->r, work->u and *info belong to it. < 0: K is not positive definite,
 * as *curvature shows. */
static dls_status primal_iterate(dls_primal *work, dls_primal_info *info, double *curvature) {
  const dls_primal_settings *settings = &work->settings;
  const int most = dlsi_most_iterations(&settings->limits, most_sweeps);
  const double load = primal_force_norm(work, work->f, 1);

  primal_certify(work, load, info);
  if (primal_holds(info, settings->limits.tol)) return DLS_OK;
  (void)primal_set_thresholds(work);
  double best = primal_larger(info->equilibrium, info->laws.residual);
  primal_copy(work, work->best, work->x);
  dls_status reason = DLS_MAX_ITERATIONS;
  int fresh = 1;   /* R carries no rounding of earlier sweeps */
  int history = 0; /* s and step are of the sweep before, with the same b */
  for (int k = 1; k <= most; k++) {
    primal_copy(work, work->x0, work->x);
    primal_copy(work, work->R0, work->R);
    const int changed = primal_sweep(work); /* (PR1), (PR2) */
    info->iterations = k;
    const primal_comparison steps = primal_compare_steps(work);
    if (steps.curvature < -1e-8 && steps.length > 1e-6) { /* more than rounding can do */
      *curvature = steps.curvature;
      return DLS_E_NOT_POSITIVE_DEFINITE;
    }
    primal_measure now = primal_estimate(work, load);
    const double balance = dlsi_target(settings->limits.tol, info->equilibrium_floor);
    now.laws.floor_u = info->laws.floor_u;
    now.laws.floor_r = info->laws.floor_r;
    const int lawful = dlsi_certificate_meets(&now.laws, settings->limits.tol);
    const int was_fresh = fresh;
    fresh = !changed || (now.equilibrium <= balance && lawful) || k % refresh_every == 0;
    if (fresh) { /* (PR5) */
      primal_certify(work, load, info);
      if (primal_holds(info, settings->limits.tol)) return DLS_OK;
      now = primal_estimate(work, load);
    }
    const double residual = primal_larger(now.equilibrium, now.laws.residual);
    if (residual < best) {
      best = residual;
      primal_copy(work, work->best, work->x);
    }
    dls_progress progress = {primal_name, primal_name, k, most, residual, NULL, 0, 0};
    const dls_status stop = dlsi_tell(&settings->limits, work->begun, &progress);
    if (stop) {
      reason = stop;
      break;
    }
    if (!(residual <= DBL_MAX)) {
      reason = DLS_STALLED;
      break;
    }
    if (!changed || time_for_thresholds(&now, balance)) { /* (PR4) */
      if (!primal_set_thresholds(work) && !changed && was_fresh) {
        reason = DLS_STALLED;
        break;
      }
      info->thresholds++;
      history = 0;
    } else if (settings->aitken && history)
      primal_extrapolate(work, steps.gamma); /* (PR3) */
    else if (settings->aitken) {
      primal_copy(work, work->s, work->x);
      primal_copy(work, work->Rs, work->R);
      history = 1;
    }
  }
  primal_copy(work, work->x, work->best);
  primal_certify(work, load, info);
  return primal_holds(info, settings->limits.tol) ? DLS_OK : reason;
}

static dls_status primal_check_input(const dls_primal *work, const double *f, const double *g,
                                     const double *mu, const double *x, const double *r,
                                     dls_error *error) {
  const size_t n = (size_t)work->K.n, nodes = (size_t)work->K.nodes;
  dls_status status = f ? dlsi_check_vector("f", f, n, error) : DLS_OK;
  if (!status && g) status = dlsi_check_vector("g", g, 2 * nodes, error);
  if (!status) status = dlsi_check_vector("mu", mu, nodes, error);
  if (status) return status;
  for (size_t c = 0; c < nodes; c++)
    if (mu[c] < 0)
      return dlsi_fail(error, DLS_E_ARGUMENT, "mu", (long long)c, mu[c], "is negative");
  if (!x) return dlsi_is_null(error, "x");
  if (!r) return dlsi_is_null(error, "r");
  return work->settings.limits.warm_start ? dlsi_check_vector("x", x, n, error) : DLS_OK;
}

/* Sets loads, gaps and the start in local frames. */
static void primal_load(dls_primal *work, const double *f, const double *g, const double *mu,
                        const double *x) {
  const dlsi_frames *K = &work->K;
  const size_t n = (size_t)K->n, nodes = (size_t)K->nodes;
  int at_rest = 1; /* no load, no penetration: x = 0, r = 0 is the answer */
  memset(work->f, 0, n * sizeof *work->f);
  memset(work->g, 0, n * sizeof *work->g);
  memset(work->x, 0, n * sizeof *work->x);
  if (f) dlsi_frames_forces(K, f, work->f);
  for (size_t c = 0; g && c < nodes; c++) {
    work->g[K->normal[c]] = g[2 * c];
    work->g[K->tangent[c]] = g[2 * c + 1];
    at_rest &= g[2 * c] >= 0;
  }
  at_rest &= dlsi_max_abs(work->f, n) == 0;
  if (work->settings.limits.warm_start && !at_rest) dlsi_frames_positions(K, x, work->x);
  for (size_t i = 0; i < n; i++)
    work->x[i] += work->g[i];
  memcpy(work->mu, mu, nodes * sizeof *mu);
  memset(work->b, 0, nodes * sizeof *work->b);
  memset(work->step, 0, n * sizeof *work->step);
}

static dls_status primal_solve(dls_primal *work, const double *f, const double *g, const double *mu,
                               double *x, double *r, double *u, dls_primal_info *info,
                               dls_error *error) {
  const size_t m = 2 * (size_t)work->K.nodes;
  dls_primal_info outcome = {0};
  double curvature = 0;
  work->begun = dlsi_clock_start(&work->settings.limits);
  primal_load(work, f, g, mu, x);
  outcome.status = primal_iterate(work, &outcome, &curvature);
  if (outcome.status < 0)
    return dlsi_fail(error, outcome.status, "K", -1, curvature, "has a negative curvature, %g",
                     curvature);
  for (int i = 0; i < work->K.n; i++)
    work->x[i] -= work->g[i];
  dlsi_frames_unknowns(&work->K, work->x, x);
  memcpy(r, work->r, m * sizeof *r);
  if (u) memcpy(u, work->u, m * sizeof *u);
  if (info) *info = outcome;
  dlsi_tell_last(&work->settings.limits, work->begun, primal_name, primal_name, outcome.iterations,
                 primal_larger(outcome.equilibrium, outcome.laws.residual), r);
  return outcome.status;
}

dls_status dls_primal_solve(dls_primal *workspace, const double *f, const double *g,
                            const double *mu, double *x, double *r, double *u,
                            dls_primal_info *info, dls_error *error) {
  DLSI_DOOR;
  dls_status status = workspace ? primal_check_input(workspace, f, g, mu, x, r, error)
                                : dlsi_is_null(error, "workspace");
  if (!status) status = dlsi_enter(&workspace->busy, "workspace", error);
  if (status) return dlsi_at(__func__, status, error);
  status = primal_solve(workspace, f, g, mu, x, r, u, info, error);
  return dlsi_at(__func__, dlsi_leave(&workspace->busy, status), error);
}
