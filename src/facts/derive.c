/*
 * derive.c: derivatives of an answer, by one linear system of its states.
 *
 * In the states of the answer the laws are equations, and E, R, L, A = R W E + L are their
 * derivatives (states_matrix.c). With t the direction of a slip, data and answer change by
 *
 *   (DR1)  dr = E y + s,   s_c = r_n dmu_c (0, t) where contact c slips, else 0
 *   (DR2)  A y = -R (dq + dW r + W s),   du = dq + dW r + W dr
 *
 * In 3D L contains the turning of t: |r_t| p.du + |u_t| p.dr = 0. The transposed system gives the
 * gradient of a loss with g_r = dL/dr and g_u = dL/du:
 *
 *   (DR3)  A^T l = E^T (g_r + W^T g_u),   a = g_u - R^T l
 *   (DR4)  dL/dq = a,   dL/dW = a r^T,   dL/dmu_c = r_n t.(g_r + W^T a)_c
 *   (DR5)  W = H^T H of rigid bodies: dL/dH_c = (H r) a_c^T + (H a) r_c^T for each body of c;
 *          dW r = H^T (dH r) + dH^T (H r)
 *
 *   (DR6)  On the border of two states, dlsi_border_state, the equations hold on one side. `side`
 *          chooses the higher or the lower state.
 *   (DR7)  A is singular if |(R A C)^-1| >= 1 / (64 sqrt(n) eps), with R and C such that units do
 *          not matter: by one step of inverse iteration from drawn numbers.
 *
 * Cost: 2/3 rows^3 once, then 2 rows^2 and two products with W for each gradient or direction. What
 * can fail: borders, reactions that are not determined.
 */
#include "facts/derive.h"

#include <string.h>

#include "linear/blas.h"

/* ---- create ---------------------------------------------------------------------------------- */

static dls_status derive_create(dls_derive *work, const double *r, int side, dls_error *error) {
  const dls_contact *problem = &work->problem;
  dls_certificate found;
  dls_status status = dlsi_form_blocks(&work->formed, &problem, error);
  if (status) return status;
  work->problem = *problem;
  problem = &work->problem;
  if (r) memcpy(work->r, r, (size_t)problem->d * (size_t)problem->nc * sizeof *r);
  dlsi_certificate_weights(problem, work->w);
  dlsi_contact_multiply(problem, NULL, r, work->u, work->a);
  dlsi_contact_measure(problem, r, work->u, work->a, work->w, work->b, &found);
  status = dlsi_states_create(&work->A, problem, error);
  if (status) return status;
  status = dlsi_derive_choose(work, side, found.residual, error);
  if (status) return status;
  work->A->n = work->rows;
  memcpy(work->A->branch, work->branch, (size_t)problem->nc * sizeof *work->branch);
  for (int c = 0; c < problem->nc; c++)
    for (int j = 0; j < work->branch[c].count; j++) {
      const int k = work->branch[c].first + j;
      work->row[k] = work->col[k] = 1 / sqrt(work->w[2 * c + (j > 0)]);
    }
  if (work->rows) status = dlsi_states_factor(work->A, problem, NULL, work->a, error);
  return dlsi_derive_judge(work, status, error);
}

dls_status dls_derive_create(dls_derive **out, const dls_contact *problem, const double *r,
                             int side, dls_error *error) {
  DLSI_DOOR;
  if (out) *out = NULL;
  dls_status status = out ? dlsi_check_blas(error) : dlsi_is_null(error, "out");
  if (!status) status = dlsi_check_contact(problem, error);
  if (!status) status = dlsi_check_vector("r", r, (size_t)problem->d * (size_t)problem->nc, error);
  if (!status) status = dlsi_derive_new(out, problem, 0, error);
  if (!status) {
    status = derive_create(*out, r, side, error);
    if (status) {
      dls_derive_destroy(*out);
      *out = NULL;
    }
  }
  return dlsi_at(__func__, status, error);
}

/* ---- products with W ------------------------------------------------------------------------- */

/* y += W^T v; t: only of the contacts that slip; NULL: of all. */
static void derive_transposed(const dls_contact *p, const double *t, const double *v, double *y) {
  const size_t d = (size_t)p->d, m = d * (size_t)p->nc;
  for (size_t c = 0; c < (size_t)p->nc; c++) {
    const dlsi_block_column W = dlsi_contact_column(p, c);
    for (size_t j = 0; j < d && !(t && t[2 * c] == 0 && t[2 * c + 1] == 0); j++) {
      double sum = 0;
      if (!W.row) dlsi_panel_dot(m, 1, W.x + j * W.ld, v, &sum);
      for (size_t k = W.begin; W.row && k < W.end; k++)
        for (size_t i = 0; i < d; i++)
          sum += W.x[k * W.step + i + j * d] * v[d * (size_t)W.row[k] + i];
      y[d * c + j] += sum;
    }
  }
}

/* v := H x, of all bodies. */
static void derive_move(const dls_contact *p, const double *H, const double *x, double *v) {
  dls_bodies B = p->bodies;
  B.H = H;
  memset(v, 0, (size_t)B.n * (size_t)B.count * sizeof *v);
  for (int c = 0; c < p->nc; c++) {
    const dlsi_pair_of_bodies of = dlsi_bodies_of(&B, (size_t)(B.n * p->d), (size_t)c, v);
    dlsi_bodies_push(p->d, B.n, &of, x + p->d * c);
  }
}

/* (DR4), (DR5) W := the gradient of the stored values. */
static void derive_stored(const dls_derive *work, const double *a, double *W) {
  const dls_contact *p = &work->problem;
  const size_t d = (size_t)p->d, n = (size_t)p->bodies.n, all = n * (size_t)p->bodies.count;
  const double *r = work->r;
  const int *body = p->bodies.body;
  if (p->bodies.H) {
    derive_move(p, p->bodies.H, r, work->motion);
    derive_move(p, p->bodies.H, a, work->motion + all);
  }
  for (size_t k = 0; p->bodies.H && k < 2 * (size_t)p->nc; k++)
    for (size_t j = 0; j < d * n; j++) {
      const double *of_r = work->motion + (body[k] < 0 ? 0 : n * (size_t)body[k]) + j % n;
      const size_t o = d * (k / 2) + j / n;
      W[k * d * n + j] = body[k] < 0 ? 0 : of_r[0] * a[o] + of_r[all] * r[o];
    }
  for (size_t c = 0; !p->bodies.H && c < (size_t)p->nc; c++) {
    const dlsi_block_column of = dlsi_contact_column(p, c);
    double *x = W + (of.row ? 0 : d * c * of.ld);
    for (size_t j = 0; j < d; j++)
      for (size_t k = of.begin; k < of.end; k++)
        for (size_t i = 0; i < d; i++)
          x[k * of.step + i + j * of.ld] = a[d * dlsi_row(&of, k) + i] * r[d * c + j];
  }
}

/* y += dW r. DLS_E_NOT_FINITE. */
static dls_status derive_change(dls_derive *work, const double *dW, double *y, dls_error *error) {
  const dls_contact *p = &work->problem;
  const size_t size = (size_t)p->bodies.n * (size_t)p->d;
  dls_contact other = *p;
  if (p->bodies.H) {
    other.Wb = (dls_blocks){0};
    other.bodies.H = dW;
    other.bodies.work = NULL;
  } else
    *(p->Wb.x ? &other.Wb.x : &other.W.a) = dW;
  const dls_status status = dlsi_check_contact(&other, error);
  double *moved = work->motion, *motion = moved + (size_t)p->bodies.n * (size_t)p->bodies.count;
  if (!status && p->bodies.H) {
    derive_move(p, dW, work->r, moved);
    derive_move(p, p->bodies.H, work->r, motion);
  }
  for (int c = 0; !status && c < p->nc; c++, y += p->d)
    if (p->bodies.H) { /* (DR5) */
      const dlsi_pair_of_bodies one = dlsi_bodies_of(&p->bodies, size, (size_t)c, moved);
      const dlsi_pair_of_bodies two = dlsi_bodies_of(&other.bodies, size, (size_t)c, motion);
      dlsi_bodies_look(p->d, p->bodies.n, &one, y, y);
      dlsi_bodies_look(p->d, p->bodies.n, &two, y, y);
    } else
      dlsi_contact_add_columns(&other, c, work->r + p->d * c, y - p->d * c);
  return status;
}

/* ---- derivatives ----------------------------------------------------------------------------- */

/* s (m) := s of (DR1); dmu NULL: 0. */
static void derive_slip(const dls_derive *work, const double *dmu, double *s) {
  const int d = work->problem.d;
  for (int c = 0; c < work->problem.nc; c++)
    for (int i = 0; i < d; i++)
      s[d * c + i] = dmu && i > 0 ? work->r[d * c] * work->t[2 * c + i - 1] * dmu[c] : 0;
}

/* mu (nc) := r_n t . v. */
static void derive_friction(const dls_derive *work, const double *v, double *mu) {
  const int d = work->problem.d;
  for (int c = 0; c < work->problem.nc; c++) {
    mu[c] = 0;
    for (int i = 1; i < d; i++)
      mu[c] += work->r[d * c] * work->t[2 * c + i - 1] * v[d * c + i];
  }
}

/* to := from, NULL: 0. */
static void derive_copy(double *to, const double *from, size_t n) {
  for (size_t k = 0; k < n; k++)
    to[k] = from ? from[k] : 0;
}

static dls_status derive_vjp(dls_derive *work, const dls_derive_answer *loss,
                             const dls_derive_data *gradient, dls_error *error) {
  const dls_contact *p = &work->problem;
  const size_t n = (size_t)work->n, m = (size_t)p->d * (size_t)p->nc;
  double *a = work->a, *g = work->b, *z = work->z, *l = z + n;
  derive_copy(a, loss->u, m);
  derive_copy(g, loss->r, m);
  derive_copy(z, loss->x, n);
  if (!work->A)
    dlsi_derive_push(work, a, z);
  else if (loss->u)
    derive_transposed(p, NULL, a, g);
  dlsi_branches_directions(p->d, p->nc, work->branch, g, l);
  const dls_status status = dlsi_derive_solve(work, 1, error); /* (DR3), (DB3) */
  if (status) return status;
  for (int k = 0; k < work->rows; k++)
    l[k] = -l[k];
  dlsi_branches_add_rows(p->d, p->nc, work->branch, l, a);
  if (gradient->mu) { /* (DR4), (DB4) */
    derive_copy(g, loss->r, m);
    if (work->A)
      derive_transposed(p, work->t, a, g);
    else
      dlsi_derive_look(work, z, g);
    derive_friction(work, g, gradient->mu);
  }
  if (gradient->q) derive_copy(gradient->q, a, m);
  if (gradient->W) derive_stored(work, a, gradient->W);
  if (gradient->f) derive_copy(gradient->f, z, n);
  if (gradient->g) dlsi_derive_gaps(work, 1, gradient->g, a);
  if (gradient->K) dlsi_derive_stored(work, z, gradient->K);
  return DLS_OK;
}

static dls_status derive_jvp(dls_derive *work, const dls_derive_data *change,
                             const dls_derive_answer *moved, dls_error *error) {
  const dls_contact *p = &work->problem;
  const size_t n = (size_t)work->n, m = (size_t)p->d * (size_t)p->nc;
  double *dr = work->a, *u = work->b, *v = work->c, *z = work->z, *y = z + n;
  dls_status status = DLS_OK;
  derive_slip(work, change->mu, dr);
  derive_copy(u, change->q, m); /* u: the given part of du */
  derive_copy(z, NULL, n);
  if (change->W) status = derive_change(work, change->W, u, error);
  if (change->K) dlsi_derive_apply(work, change->K, z);
  if (change->g) dlsi_derive_gaps(work, 0, change->g, u);
  for (size_t i = 0; i < n; i++)
    z[i] = (change->f ? change->f[i] : 0) - z[i];
  if (work->A)
    dlsi_contact_apply(p, dr, v);
  else {
    dlsi_derive_push(work, dr, z);
    derive_copy(v, NULL, m);
  }
  for (size_t k = 0; k < m; k++)
    v[k] = -v[k] - u[k];
  dlsi_branches_rows(p->d, p->nc, work->branch, v, y);
  if (!status) status = dlsi_derive_solve(work, 0, error); /* (DR2), (DB1) */
  if (status) return status;
  dlsi_branches_add_directions(p->d, p->nc, work->branch, y, dr); /* (DR1) */
  if (work->A)
    dlsi_contact_apply(p, dr, v);
  else {
    derive_copy(v, NULL, m);
    dlsi_derive_look(work, z, v);
  }
  for (size_t k = 0; moved->u && k < m; k++)
    moved->u[k] = u[k] + v[k];
  if (moved->r) derive_copy(moved->r, dr, m);
  if (moved->x) derive_copy(moved->x, z, n);
  return DLS_OK;
}

/* Checks the input arrays, and computes one of the two products. */
static dls_status derive_call(dls_derive *work, int forward, const dls_derive_data *data,
                              const dls_derive_answer *answer, dls_error *error) {
  if (!work) return dlsi_is_null(error, "derive");
  if (!data) return dlsi_is_null(error, forward ? "change" : "gradient");
  if (!answer) return dlsi_is_null(error, forward ? "moved" : "loss");
  if (work->A ? data->f || data->g || data->K || answer->x : data->q || data->W)
    return dlsi_fail(error, DLS_E_ARGUMENT, "derive", -1, 0, "made on %s of these arrays",
                     work->A ? "W, without f, g, K, x" : "K, without q, W");
  const dlsi_reduced *body = &work->body;
  const size_t nc = (size_t)work->problem.nc, m = (size_t)work->problem.d * nc, n = (size_t)work->n;
  const struct {
    const char *name;
    const double *x;
    size_t size;
    int of_data;
  } given[] = {{"mu", data->mu, nc, 1},
               {"q", data->q, m, 1},
               {"f", data->f, n, 1},
               {"g", data->g, (size_t)body->space * (size_t)body->nodes, 1},
               {"K", data->K, work->A ? 0 : dlsi_derive_values(&body->K), 1},
               {"r", answer->r, m, 0},
               {"u", answer->u, m, 0},
               {"x", answer->x, n, 0}};
  dls_status status = DLS_OK;
  for (size_t k = 0; !status && k < sizeof given / sizeof *given; k++)
    if (given[k].x && given[k].of_data == forward)
      status = dlsi_check_vector(given[k].name, given[k].x, given[k].size, error);
  if (!status) status = dlsi_enter(&work->busy, "derive", error);
  if (status) return status;
  return dlsi_leave(&work->busy, forward ? derive_jvp(work, data, answer, error)
                                         : derive_vjp(work, answer, data, error));
}

dls_status dls_derive_vjp(dls_derive *derive, const dls_derive_answer *loss,
                          const dls_derive_data *gradient, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, derive_call(derive, 0, gradient, loss, error), error);
}

dls_status dls_derive_jvp(dls_derive *derive, const dls_derive_data *change,
                          const dls_derive_answer *moved, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, derive_call(derive, 1, change, moved, error), error);
}
