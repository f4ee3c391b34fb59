/*
 * forming_contact.c: solves the linearised contact problem of an equilibrium step, [Chabrand 1998]
 * (24)-(25).
 *
 *   K dx = f + H r,  f = -F,   u' = u + H^T dx,   0 <= u'_n _|_ r_n >= 0,  |r_t| <= mu r_n, ..
 *
 * with (FO8) of forming.c in K and f, and with supports as decoupled rows: K stays banded, with one
 * pattern. Methods:
 *
 *   condensed      LU of K, W and q by the reduction, a method of the solver; auto: only if
 *                  Newton's method on K fails
 *   Gauss-Seidel   (37)-(38) on the symmetric part of K, which the method needs: Newton's method
 *                  then converges linearly, by the weight of the skew part (material.c)
 *   springs        (28)-(36): K + H D H^T, one LU for each change of branch
 *
 * The first two methods solve for the contacts that carry a reaction or have no gap. If the
 * solution opens all other contacts, it solves the whole problem. If not, the contacts that it
 * closes are added:
 *
 *   (FC1)  A := { r_n > 0 or u_n <= 0 }
 *   (FC2)  solve on A;  A := A + { u'_n < 0 };  again if A has grown
 *
 * Springs, in the paper's words: eps_N = eps_T = eps_c, a multiple of the stiffness of the node at
 * the start of the step; multipliers start from the reactions of the last step; penalty: lambda_n =
 * 0, and lambda_t the friction at the end of the last step, to which (33) adds. The branches of
 * springs (free, stick, slip forward or back) are found with K frozen:
 *
 *   (FC3)  the branches at u; solve; the branches at u'; again until they stay, 30 times at most
 *
 * A slip that turns round goes through stick first: otherwise + and - may alternate without end.
 *
 * Newton's method on K, an active set: r' = H^T (K dx - f) is eliminated. The two rows of a free
 * candidate's node are r' = 0, that is K dx = f; the two rows of a node in contact become
 *
 *   (FC4)  u'_n = 0,  and  stick: u'_t = 0;  slip: r'_t = s r'_n, s = +-mu
 *   (FC5)  the branches of r - stiff u; solve; the branches of r' - stiff u'; again until they
 *          stay, 10 times at most
 *
 * Branches that stay are the laws between u' and r', whatever stiff > 0: (24)-(25) is solved.
 * What can fail: a singular K, DLS_STALLED: the caller halves the step.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "forming_internal.h"

enum { most_branches = 30, most_on_K = 10 };

static const double augmented_factor = 30, penalty_factor = 1e3; /* eps_c over the stiffness */

int dlsi_forming_springs(const dls_forming *f) {
  return f->settings.contact == DLS_FORMING_AUGMENTED_LAGRANGIAN ||
         f->settings.contact == DLS_FORMING_PENALTY;
}

/* ---- condensed, Gauss-Seidel ----------------------------------------------------------------- */

/* Returns a model with H of the chosen candidates and no operator. */
static dls_model chosen_model(const dls_forming *f) {
  const dlsi_chosen *s = &f->chosen;
  return (dls_model){.d = 2,
                     .n = f->n,
                     .nodes = s->count,
                     .HN = {f->n, s->count, s->p, s->i, s->normal},
                     .HT = {f->n, s->count, s->p, s->i, s->tangent}};
}

/* lu := the factors of K. */
static dls_status factor_K(dls_forming *f) {
  const double start = dlsi_forming_seconds();
  dlsi_band_load(&f->band);
  const int good = dlsi_band_factor(&f->band);
  f->data.cpu.reduction += dlsi_forming_seconds() - start;
  return good ? DLS_OK : DLS_STALLED;
}

/* dx := K^-1 rhs by the factors: no contact. */
static dls_status solve_free(dls_forming *f) {
  memcpy(f->dx, f->rhs, (size_t)f->n * sizeof *f->dx);
  return dlsi_band_solve(&f->band, f->dx, f->n, 1) ? DLS_STALLED : DLS_OK;
}

/* Condenses K to W of the chosen candidates and solves by the front door. */
static dls_status solve_condensed(dls_forming *f, dls_error *error) {
  const double start = dlsi_forming_seconds();
  dls_model model = chosen_model(f);
  model.operator_kind = DLS_HOST_SOLVER;
  model.solve = dlsi_band_solve;
  model.user = &f->band;
  dls_solver *solver = f->way == DLS_FORMING_BY_LEMKE ? f->last_resort : f->solver;
  dls_reduction *reduction;
  dls_contact problem = {0};
  dls_info info = {0};
  dls_status status = dls_reduction_create(&reduction, &model, NULL, error);
  if (!status) status = dls_reduction_load(reduction, f->rhs, f->chosen.u, error);
  if (!status) status = dls_reduction_contact(reduction, f->chosen.mu, &problem, error);
  const double reduced = dlsi_forming_seconds();
  if (!status) status = dls_solver_solve(solver, &problem, f->chosen.r, NULL, &info, error);
  const double solved = dlsi_forming_seconds();
  if (status >= 0) status = dls_reduction_recover(reduction, f->chosen.r, f->dx, error);
  dls_reduction_destroy(f->reduction);
  f->reduction = reduction;
  f->problem = problem;
  f->data.count.reductions++;
  f->data.count.iterations += info.iterations;
  f->data.cpu.contact += solved - reduced;
  f->data.cpu.reduction += reduced - start + (dlsi_forming_seconds() - solved);
  return status;
}

/* Returns (K + K^T) / 2 by columns. */
static dls_sparse K_symmetric_part(dls_forming *f) {
  const int n = f->n, k = f->band.k;
  int entries = 0;
  for (int j = 0; j < n; j++) {
    f->Kp[j] = entries;
    for (int i = j > k ? j - k : 0; i < n && i <= j + k; i++) {
      const double a = f->band.a[dlsi_band_at(&f->band, i, j)];
      const double b = f->band.a[dlsi_band_at(&f->band, j, i)];
      if (a == 0 && b == 0) continue;
      f->Ki[entries] = i;
      f->Kx[entries++] = (a + b) / 2;
    }
  }
  f->Kp[n] = entries;
  return (dls_sparse){n, n, f->Kp, f->Ki, f->Kx};
}

/* Solves on the chosen candidates by sweeps on the symmetric part of K. */
static dls_status solve_gauss_seidel(dls_forming *f, dls_error *error) {
  const double start = dlsi_forming_seconds();
  dls_model model = chosen_model(f);
  model.operator_kind = DLS_STIFFNESS_SPARSE;
  model.factorization = DLS_CHOLESKY;
  model.Ks = K_symmetric_part(f);
  dls_primal_settings settings;
  dls_primal_settings_init(&settings);
  settings.limits.tol = f->settings.tol / 100; /* the sum of all forces has to hold, too */
  settings.relaxation = f->settings.relaxation;
  settings.aitken = f->settings.aitken;
  if (f->settings.cpu_seconds > 0) settings.limits.cpu_seconds = fmax(dlsi_forming_left(f), 1e-9);
  dls_primal *primal;
  dls_primal_info info = {0};
  dls_status status = dls_primal_create(&primal, &model, &settings, error);
  if (!status)
    status = dls_primal_solve(primal, f->rhs, f->chosen.u, f->chosen.mu, f->dx, f->chosen.r, NULL,
                              &info, error);
  dls_primal_destroy(primal);
  f->data.count.iterations += info.iterations;
  f->data.cpu.contact += dlsi_forming_seconds() - start;
  return status > 0 ? DLS_OK : status;
}

/* Gathers the marked candidates. */
static void chosen_gather(dls_forming *f) {
  dlsi_chosen *s = &f->chosen;
  s->count = 0;
  for (int c = 0; c < f->nc; c++) {
    if (!s->mark[c]) continue;
    const int k = s->count++;
    for (int i = 0; i < 2; i++) {
      s->i[2 * k + i] = 2 * f->candidate[c] + i;
      s->normal[2 * k + i] = f->normal[2 * c + i];
      s->tangent[2 * k + i] = f->tangent[2 * c + i];
      s->u[2 * k + i] = f->u[2 * c + i];
      s->r[2 * k + i] = f->r[2 * c + i];
    }
    s->mu[k] = f->mu[c];
  }
}

/* Fills next_r from the chosen candidates; marks the others that dx closes and returns 1 if there
 * is one. */
static int chosen_spread(dls_forming *f) {
  int more = 0;
  for (int c = 0, k = 0; c < f->nc; c++) {
    const double *dx = f->dx + 2 * f->candidate[c], *n = f->normal + 2 * c;
    double *r = f->next_r + 2 * c;
    r[0] = r[1] = 0;
    if (f->chosen.mark[c])
      memcpy(r, f->chosen.r + 2 * k++, 2 * sizeof *r);
    else if (f->u[2 * c] + n[0] * dx[0] + n[1] * dx[1] < 0)
      f->chosen.mark[c] = more = 1;
  }
  return more;
}

/* Solves by the condensed problem or by Gauss-Seidel. */
static dls_status solve_chosen(dls_forming *f, dls_error *error) {
  const int primal = f->settings.contact == DLS_FORMING_GAUSS_SEIDEL;
  int any = 0;
  for (int c = 0; c < f->nc; c++) /* (FC1) */
    any |= f->chosen.mark[c] = f->r[2 * c] > 0 || f->u[2 * c] <= 0;
  dls_status status = primal && any ? DLS_OK : factor_K(f);
  if (status) return status;
  dls_error why = {0};
  do { /* (FC2) */
    chosen_gather(f);
    status = !f->chosen.count ? solve_free(f)
             : primal         ? solve_gauss_seidel(f, &why)
                              : solve_condensed(f, &why);
  } while (status == DLS_OK && chosen_spread(f));
  if (status == DLS_E_NOT_FINITE || status == DLS_E_CALLBACK ||
      status == DLS_E_NOT_POSITIVE_DEFINITE)
    return DLS_STALLED; /* K is to blame; a smaller step may succeed */
  if (status < 0 && error) *error = why;
  return status;
}

/* ---- branches: springs, Newton on K ---------------------------------------------------------- */

typedef enum branch { FREE, STICK, SLIP_FORWARD, SLIP_BACK } branch; /* SLIP_FORWARD: r_t > 0 */

void dlsi_forming_set_springs(dls_forming *f) {
  const int soft = f->settings.contact == DLS_FORMING_AUGMENTED_LAGRANGIAN;
  const double own = soft ? augmented_factor : penalty_factor;
  const double factor = f->settings.penalty > 0 ? f->settings.penalty : own;
  f->augmentations = 0;
  for (int c = 0; c < f->nc; c++) {
    f->eps[c] = factor * f->stiff[c];
    f->lambda[2 * c] = soft ? f->r[2 * c] : 0;
    f->lambda[2 * c + 1] = f->r[2 * c + 1];
  }
}

void dlsi_forming_augment(dls_forming *f) { /* (35), (36) */
  if (f->settings.contact != DLS_FORMING_AUGMENTED_LAGRANGIAN || dlsi_forming_stays(f)) return;
  memcpy(f->lambda, f->r, 2 * (size_t)f->nc * sizeof *f->r);
  f->augmentations++;
}

int dlsi_forming_stays(const dls_forming *f) {
  const int most = f->settings.augmentations;
  return f->settings.contact == DLS_FORMING_PENALTY || (most > 0 && f->augmentations >= most);
}

/* Returns the branch of (32)-(34) at u; without friction there is only one slip. */
static branch branch_at(const dls_forming *f, int c, const double u[2]) {
  const double eps = f->eps[c], mu = f->mu[c], *lambda = f->lambda + 2 * c;
  const double rn = lambda[0] - eps * u[0], rt = lambda[1] - eps * u[1];
  if (!(rn > 0)) return FREE;
  if (mu > 0 && fabs(rt) <= mu * rn) return STICK;
  return rt > 0 || mu == 0 ? SLIP_FORWARD : SLIP_BACK;
}

/* Returns r_t / r_n of a slip. */
static double slip_slope(const dls_forming *f, int c, branch on) {
  return on == SLIP_FORWARD ? f->mu[c] : -f->mu[c];
}

/* Evaluates (32)-(34) of candidate c at u on the branch `on`.
 *   r: out, reaction, 2; D: out, -dr/du, 2 x 2 column-major */
static void spring_law(const dls_forming *f, int c, branch on, const double u[2], double r[2],
                       double D[4]) {
  const double eps = f->eps[c], *lambda = f->lambda + 2 * c;
  const double slope = on == STICK ? 0 : slip_slope(f, c, on);
  r[0] = on == FREE ? 0 : lambda[0] - eps * u[0];
  r[1] = on == STICK ? lambda[1] - eps * u[1] : slope * r[0];
  D[0] = on == FREE ? 0 : eps;
  D[1] = slope * D[0];
  D[2] = 0;
  D[3] = on == STICK ? eps : 0;
}

double dlsi_forming_stretch(const dls_forming *f) {
  double change = 0, size = 0;
  for (int c = 0; c < f->nc; c++) {
    const double *u = f->u + 2 * c, *x = f->anchor + 2 * c;
    const double blur = 4 * DBL_EPSILON * f->eps[c] * (fabs(x[0]) + fabs(x[1]));
    double r[2], D[4];
    spring_law(f, c, branch_at(f, c, u), u, r, D);
    for (int i = 0; i < 2; i++) {
      change = fmax(change, fabs(r[i] - f->r[2 * c + i]) - blur);
      size = fmax(size, fabs(r[i]));
    }
  }
  return change > 0 ? change / size : 0;
}

/* Sets up a solve with springs on the branches at u' = trial_u: lu := K + H D H^T,
 * dx := rhs + H (r + D (u' - u)). */
static void attach_springs(dls_forming *f) {
  dlsi_band_load(&f->band);
  memcpy(f->dx, f->rhs, (size_t)f->n * sizeof *f->dx);
  for (int c = 0; c < f->nc; c++) {
    const double *axis[2] = {f->normal + 2 * c, f->tangent + 2 * c};
    const double *trial = f->trial_u + 2 * c, *u = f->u + 2 * c;
    const int row = 2 * f->candidate[c];
    double r[2], D[4];
    spring_law(f, c, (branch)f->branch[c], trial, r, D);
    for (int a = 0; a < 4; a++) {
      r[a % 2] += D[a] * (trial[a / 2] - u[a / 2]);
      for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++)
          f->band.lu[dlsi_band_at(&f->band, row + i, row + j)] +=
              axis[a % 2][i] * D[a] * axis[a / 2][j];
    }
    for (int i = 0; i < 2; i++)
      if (!f->fixed[row + i]) f->dx[row + i] += axis[0][i] * r[0] + axis[1][i] * r[1];
  }
}

/* Finds the columns first .. last in which a node's rows, i and i + 1, may have entries. */
static void node_columns(const dls_forming *f, int i, int *first, int *last) {
  const int k = f->band.k, n = f->band.n;
  *first = i + 1 > k ? i + 1 - k : 0;
  *last = i + k < n ? i + k : n - 1;
}

/* Sets up the system lu dx = rhs of (FC4). The row of u'_n is the node's row of the larger
 * component of n. */
static void impose_laws(dls_forming *f) {
  dlsi_band_load(&f->band);
  memcpy(f->dx, f->rhs, (size_t)f->n * sizeof *f->dx);
  for (int c = 0; c < f->nc; c++) {
    const branch on = (branch)f->branch[c];
    if (on == FREE) continue;
    const double *n = f->normal + 2 * c, *t = f->tangent + 2 * c, *u = f->u + 2 * c;
    const double size = f->stiff[c], slope = slip_slope(f, c, on);
    const double v[2] = {t[0] - slope * n[0], t[1] - slope * n[1]};
    const int i = 2 * f->candidate[c], across = fabs(n[1]) > fabs(n[0]);
    int first, last;
    node_columns(f, i, &first, &last);
    for (int j = first; j <= last; j++) {
      double *a = f->band.lu + dlsi_band_at(&f->band, i, j);
      const double along = on == STICK ? 0 : v[0] * a[0] + v[1] * a[1];
      a[across] = 0;
      a[1 - across] = along;
    }
    double *b = f->dx + i;
    b[1 - across] = on == STICK ? -size * u[1] : v[0] * b[0] + v[1] * b[1];
    b[across] = -size * u[0];
    for (int j = 0; j < 2; j++) {
      double *a = f->band.lu + dlsi_band_at(&f->band, i, i + j);
      a[across] = size * n[j];
      if (on == STICK) a[1 - across] = size * t[j];
    }
  }
}

/* next_r and lambda := r' of contact c. u: in and out, u'; sets components that the branch makes
 * zero to exactly 0. */
static void recover_reaction(dls_forming *f, int c, branch on, double u[2]) {
  const int i = 2 * f->candidate[c];
  const double *n = f->normal + 2 * c, *t = f->tangent + 2 * c;
  double *r = f->next_r + 2 * c, force[2] = {-f->rhs[i], -f->rhs[i + 1]};
  r[0] = r[1] = 0;
  if (on != FREE) {
    int first, last;
    node_columns(f, i, &first, &last);
    for (int j = first; j <= last; j++) {
      const double *a = f->band.a + dlsi_band_at(&f->band, i, j);
      force[0] += a[0] * f->dx[j];
      force[1] += a[1] * f->dx[j];
    }
    r[0] = n[0] * force[0] + n[1] * force[1];
    r[1] = on == STICK ? t[0] * force[0] + t[1] * force[1] : slip_slope(f, c, on) * r[0];
    u[0] = 0;
    if (on == STICK) u[1] = 0;
  }
  memcpy(f->lambda + 2 * c, r, 2 * sizeof *r);
}

/* u' := u + H^T dx; fills next_r at u' on the branches of the solve, then finds the branches at u'.
 * Returns 1 if a branch has changed. */
static int renew_branches(dls_forming *f) {
  const int springs = dlsi_forming_springs(f);
  int changed = 0;
  for (int c = 0; c < f->nc; c++) {
    const double *dx = f->dx + 2 * f->candidate[c];
    const double *n = f->normal + 2 * c, *t = f->tangent + 2 * c;
    double *u = f->trial_u + 2 * c, D[4];
    u[0] = f->u[2 * c] + n[0] * dx[0] + n[1] * dx[1];
    u[1] = f->u[2 * c + 1] + t[0] * dx[0] + t[1] * dx[1];
    const branch was = (branch)f->branch[c];
    if (springs)
      spring_law(f, c, was, u, f->next_r + 2 * c, D);
    else
      recover_reaction(f, c, was, u);
    branch now = branch_at(f, c, u);
    if (now != was && now >= SLIP_FORWARD && was >= SLIP_FORWARD) now = STICK;
    changed |= now != was;
    f->branch[c] = (int)now;
  }
  return changed;
}

/* Runs (FC3) or (FC5) with at most `most` factorisations. Returns 1 if the branches stay, 0 if they
 * do not, -1 if a matrix is singular. */
static int settle_branches(dls_forming *f, int most) {
  const double start = dlsi_forming_seconds();
  const int springs = dlsi_forming_springs(f);
  int changed = 1;
  memcpy(f->trial_u, f->u, 2 * (size_t)f->nc * sizeof *f->u);
  for (int c = 0; c < f->nc; c++)
    f->branch[c] = (int)branch_at(f, c, f->u + 2 * c);
  for (int k = 0; changed > 0 && k < most; k++) {
    if (springs)
      attach_springs(f);
    else
      impose_laws(f);
    if (!dlsi_band_factor(&f->band) || dlsi_band_solve(&f->band, f->dx, f->n, 1))
      changed = -1;
    else
      changed = renew_branches(f);
    f->data.count.iterations++;
  }
  f->data.cpu.reduction += dlsi_forming_seconds() - start;
  return changed < 0 ? -1 : !changed;
}

/* Solves by Newton's method on K; returns 0 if that fails. */
static int solve_on_K(dls_forming *f) {
  memcpy(f->eps, f->stiff, (size_t)f->nc * sizeof *f->eps);
  memcpy(f->lambda, f->r, 2 * (size_t)f->nc * sizeof *f->r);
  return settle_branches(f, most_on_K) > 0;
}

/* ---- the step -------------------------------------------------------------------------------- */

void dlsi_forming_turn(const dls_forming *f, double *y) {
  for (int c = 0; c < f->nc; c++) {
    const int i = 2 * f->candidate[c];
    const double *t = f->tangent + 2 * c, *a = f->anchor + 2 * c;
    const double s = f->bend[c] * (t[0] * (f->x[i] - a[0]) + t[1] * (f->x[i + 1] - a[1]));
    y[i] += s * t[0];
    y[i + 1] += s * t[1];
  }
}

/* K -= the derivative of (FO8). */
static void subtract_turn(dls_forming *f) {
  for (int c = 0; c < f->nc; c++) {
    const int i = 2 * f->candidate[c];
    const double *t = f->tangent + 2 * c;
    for (int k = 0; k < 4; k++)
      f->band.a[dlsi_band_at(&f->band, i + k % 2, i + k / 2)] -= f->bend[c] * t[k % 2] * t[k / 2];
  }
}

dls_status dlsi_forming_direction(dls_forming *f, dls_error *error) {
  for (int i = 0; i < f->n; i++)
    f->rhs[i] = -f->F[i];
  dlsi_forming_turn(f, f->rhs);
  subtract_turn(f);
  for (int i = 0; i < f->n; i++)
    if (f->fixed[i])
      dlsi_band_support(&f->band, i, f->rest[i] + f->load * f->drive[i] - f->x[i], f->rhs);
  if (dlsi_forming_springs(f)) return settle_branches(f, most_branches) < 0 ? DLS_STALLED : DLS_OK;
  return f->way == DLS_FORMING_ON_K && solve_on_K(f) ? DLS_OK : solve_chosen(f, error);
}
