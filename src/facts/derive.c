/*
 * derive.c: derivatives of an answer, by one linear system of its states.
 *
 * In the states of the answer the laws are equations, and E, R, L, A = R W E + L are their
 * derivatives (vi/states_matrix.c). With t the direction of a slip, data and answer change by
 *
 *   (DR1)  dr = E y + s,   s_c = r_n dmu_c (0, t) where contact c slips, else 0
 *   (DR2)  A y = -R (dq + dW r + W s),   du = dq + dW r + W dr
 *
 * In 3D L holds that t turns: |r_t| p.du + |u_t| p.dr = 0. The transposed system gives the gradient
 * of a loss with g_r = dL/dr and g_u = dL/du:
 *
 *   (DR3)  A^T l = E^T (g_r + W^T g_u),   a = g_u - R^T l
 *   (DR4)  dL/dq = a,   dL/dW = a r^T,   dL/dmu_c = r_n t.(g_r + W^T a)_c
 *   (DR5)  W = H^T H of rigid bodies: dL/dH_c = (H r) a_c^T + (H a) r_c^T for each body of c;
 *          dW r = H^T (dH r) + dH^T (H r)
 *
 *   (DR6)  On the border of two states, dlsi_border_state, the equations hold on one side: those of
 *          the higher or of the lower state are taken on request.
 *   (DR7)  A is singular where |(R A C)^-1| >= 1 / (64 sqrt(n) eps), R and C such that units do not
 *          matter: by one step of inverse iteration from numbers drawn.
 *
 * Cost: 2/3 rows^3 once, then 2 rows^2 and two products with W for each gradient or direction. What
 * can fail: borders, reactions that are not determined.
 */
#include "facts/derive.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "facts/facts.h"
#include "linear/blas.h"

static const double most_residual = 1e-4; /* of an answer */

/* ---- the object ------------------------------------------------------------------------------ */

dls_status dlsi_derive_new(dls_derive **out, const dls_contact *problem, int n, dls_error *error) {
  const size_t nc = (size_t)problem->nc, m = (size_t)problem->d * nc, all = (size_t)n + m;
  const size_t motions =
      problem->bodies.H ? (size_t)problem->bodies.n * (size_t)problem->bodies.count : 0;
  dls_derive *work = *out = calloc(1, sizeof *work);
  if (!work) return dlsi_no_memory(error);
  work->n = n;
  work->problem = *problem;
  work->state = dlsi_alloc(nc, sizeof *work->state);
  work->memory = dlsi_alloc(4 * nc + 5 * m + (size_t)n + 3 * all + 2 * motions, sizeof(double));
  if (!work->state || !work->memory) {
    dls_derive_destroy(work);
    *out = NULL;
    return dlsi_no_memory(error);
  }
  double *at = work->memory;
  const struct {
    double **array;
    size_t size;
  } arrays[] = {{&work->w, 2 * nc}, {&work->t, 2 * nc}, {&work->r, m},     {&work->u, m},
                {&work->a, m},      {&work->b, m},      {&work->c, m},     {&work->x, (size_t)n},
                {&work->z, all},    {&work->row, all},  {&work->col, all}, {&work->motion, 0}};
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
    *arrays[k].array = at;
    at += arrays[k].size;
  }
  return DLS_OK;
}

void dls_derive_destroy(dls_derive *derive) {
  if (!derive) return;
  if (derive->A)
    dlsi_states_destroy(derive->A);
  else
    free(derive->branch);
  dlsi_general_free(&derive->M);
  dlsi_formed_free(&derive->formed);
  free(derive->state);
  free(derive->memory);
  free(derive);
}

/* ---- states ---------------------------------------------------------------------------------- */

static const char *const state_names[] = {"free", "slip", "stick"};

/* t (2) := the direction of the friction that mu would have, or has, at a contact that touches. */
static void derive_direction(const dls_derive *work, int c, double close, double *t) {
  const int d = work->problem.d;
  const dlsi_branch *at = &work->branch[c];
  const double *u = work->u + d * c, slip = dlsi_tangent_norm(d, u);
  const int from_rest = at->count == 1 && at->mu == 0 && slip > close;
  t[0] = t[1] = 0;
  if (at->state != DLS_SLIP) return;
  for (int i = 1; i < d; i++)
    t[i - 1] = from_rest ? -u[i] / slip : at->t[i - 1];
}

dls_status dlsi_derive_choose(dls_derive *work, int side, double residual, dls_error *error) {
  const dls_contact *problem = &work->problem;
  const int d = problem->d;
  double F[3];
  if (side < -1 || side > 1)
    return dlsi_fail(error, DLS_E_ARGUMENT, "side", -1, side, "must be -1, 0 or 1");
  if (!(residual <= most_residual))
    return dlsi_fail(error, DLS_E_ARGUMENT, "r", -1, residual, "no answer: its residual is %.3g",
                     residual);
  const double close = dlsi_border_width(problem, work->w, work->r, work->u, residual);
  for (int c = 0; c < problem->nc; c++) {
    const double mu = problem->mu[c], *w = work->w + 2 * c, *r = work->r + d * c,
                 *u = work->u + d * c;
    const dls_contact_state own = dlsi_contact_misfit(d, mu, w, r, u, F);
    const dls_contact_state other = dlsi_border_state(d, mu, own, w, r, u, close);
    if (other != own && side < 0)
      return dlsi_fail(error, DLS_E_NO_DERIVATIVE, "contact", c, other,
                       "at the border of %s and %s: no derivative", state_names[own],
                       state_names[other]);
    work->state[c] = (own < other) == (side == 0) ? other : own; /* (DR6) */
  }
  work->rows = dlsi_branches_set(problem, work->state, work->r, work->u, work->branch);
  for (int c = 0; c < problem->nc; c++)
    derive_direction(work, c, close, work->t + 2 * c);
  return DLS_OK;
}

void dlsi_derive_slip(const dls_derive *work, const double *dmu, double *s) {
  const int d = work->problem.d;
  for (int c = 0; c < work->problem.nc; c++)
    for (int i = 0; i < d; i++)
      s[d * c + i] = dmu && i > 0 ? work->r[d * c] * work->t[2 * c + i - 1] * dmu[c] : 0;
}

void dlsi_derive_friction(const dls_derive *work, const double *v, double *mu) {
  const int d = work->problem.d;
  for (int c = 0; c < work->problem.nc; c++) {
    mu[c] = 0;
    for (int i = 1; i < d; i++)
      mu[c] += work->r[d * c] * work->t[2 * c + i - 1] * v[d * c + i];
  }
}

/* ---- the system ------------------------------------------------------------------------------ */

dls_status dlsi_derive_solve(dls_derive *work, int transposed, dls_error *error) {
  if (!work->A) return dlsi_general_solve(&work->M, transposed, work->z, error);
  return work->rows ? dlsi_states_solve(work->A, transposed, work->z, error) : DLS_OK;
}

dls_status dlsi_derive_judge(dls_derive *work, dls_status status, dls_error *error) {
  const size_t all = (size_t)work->n + (size_t)work->rows;
  double size = 0, *z = work->z;
  if (status && status != DLS_E_SINGULAR) return status;
  for (size_t i = 0; i < all; i++)
    z[i] = 2 * dlsi_draw_entry(0, (int)i) - 1;
  for (int turn = 0; !status && turn < 2; turn++) {
    const double *before = turn ? work->col : work->row, *after = turn ? work->row : work->col;
    for (size_t i = 0; i < all; i++)
      z[i] /= before[i];
    status = dlsi_derive_solve(work, turn, error);
    for (size_t i = 0; i < all; i++)
      z[i] /= after[i];
    size = dlsi_norm2(z, all);
    for (size_t i = 0; !turn && i < all; i++)
      z[i] /= size;
  }
  const int singular =
      status == DLS_E_SINGULAR || !(size * 64 * sqrt((double)all) * DBL_EPSILON < 1);
  if (!all || (!singular && status <= 0)) return status;
  return dlsi_fail(error, DLS_E_NO_DERIVATIVE, "r", -1, size, "not determined: no derivative");
}

dls_status dlsi_derive_enter(dls_derive *work, int of_body, int count, const dlsi_given *given,
                             dls_error *error) {
  if (!work) return dlsi_is_null(error, "derive");
  if (of_body != (work->body.H != NULL))
    return dlsi_fail(error, DLS_E_ARGUMENT, "derive", -1, of_body, "made %s a body",
                     of_body ? "without" : "of");
  for (int k = 0; k < count; k++) {
    const dls_status status =
        given[k].x ? dlsi_check_vector(given[k].name, given[k].x, given[k].size, error) : DLS_OK;
    if (status) return status;
  }
  return dlsi_enter(&work->busy, "derive", error);
}

/* ---- on W ------------------------------------------------------------------------------------ */

static dls_status derive_create(dls_derive *work, const double *r, int side, dls_error *error) {
  const dls_contact *problem = &work->problem;
  dls_certificate found;
  dls_status status = dls_contact_certify(problem, r, work->u, &found, error);
  if (!status) status = dlsi_form_blocks(&work->formed, &problem, error);
  if (status) return status;
  work->problem = *problem;
  problem = &work->problem;
  memcpy(work->r, r, (size_t)problem->d * (size_t)problem->nc * sizeof *r);
  dlsi_certificate_weights(problem, work->w);
  status = dlsi_states_create(&work->A, problem, error);
  if (status) return status;
  work->branch = work->A->branch;
  status = dlsi_derive_choose(work, side, found.residual, error);
  if (status) return status;
  work->A->n = work->rows;
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

/* y := W^T v. */
static void derive_transposed(const dls_contact *p, const double *v, double *y) {
  const size_t d = (size_t)p->d, m = d * (size_t)p->nc;
  for (size_t c = 0; c < (size_t)p->nc; c++) {
    const dlsi_block_column W = dlsi_contact_column(p, c);
    for (size_t j = 0; j < d; j++) {
      double *sum = y + d * c + j;
      *sum = 0;
      if (!W.row) dlsi_panel_dot(m, 1, W.x + j * W.ld, v, sum);
      for (size_t k = W.begin; W.row && k < W.end; k++)
        for (size_t i = 0; i < d; i++)
          *sum += W.x[k * W.step + i + j * d] * v[d * (size_t)W.row[k] + i];
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

/* (DR4), (DR5) W := the gradient of what is stored. */
static void derive_stored(const dls_derive *work, const double *a, double *W) {
  const dls_contact *p = &work->problem;
  const size_t d = (size_t)p->d;
  const double *r = work->r;
  const dls_bodies *B = &p->bodies;
  if (B->H) {
    const size_t n = (size_t)B->n, all = n * (size_t)B->count;
    double *of_r = work->motion, *of_a = of_r + all;
    derive_move(p, B->H, r, of_r);
    derive_move(p, B->H, a, of_a);
    for (size_t k = 0; k < 2 * (size_t)p->nc; k++)
      for (size_t j = 0; j < d * n; j++) {
        const size_t o = d * (k / 2) + j / n,
                     v = n * (size_t)(B->body[k] < 0 ? 0 : B->body[k]) + j % n;
        W[k * d * n + j] = B->body[k] < 0 ? 0 : of_r[v] * a[o] + of_a[v] * r[o];
      }
    return;
  }
  for (size_t c = 0; c < (size_t)p->nc; c++) {
    const dlsi_block_column of = dlsi_contact_column(p, c);
    double *x = W + (p->Wb.x ? 0 : d * c * of.ld);
    for (size_t j = 0; j < d; j++)
      for (size_t k = of.begin; k < of.end; k++)
        for (size_t i = 0; i < d; i++)
          x[k * of.step + i + j * of.ld] = a[d * dlsi_row(&of, k) + i] * r[d * c + j];
  }
}

static dls_status derive_vjp(dls_derive *work, const double *gr, const double *gu, double *q,
                             double *mu, double *W, dls_error *error) {
  const dls_contact *p = &work->problem;
  const int d = p->d, nc = p->nc;
  const size_t m = (size_t)d * (size_t)nc;
  double *g = work->b, *a = work->a;
  for (size_t k = 0; k < m; k++)
    a[k] = gu ? gu[k] : 0;
  derive_transposed(p, a, g);
  for (size_t k = 0; gr && k < m; k++)
    g[k] += gr[k];
  dlsi_branches_directions(d, nc, work->branch, g, work->z); /* (DR3) */
  const dls_status status = dlsi_derive_solve(work, 1, error);
  if (status) return status;
  for (int k = 0; k < work->rows; k++)
    work->z[k] = -work->z[k];
  dlsi_branches_add_rows(d, nc, work->branch, work->z, a);
  if (q) memcpy(q, a, m * sizeof *q);
  if (W) derive_stored(work, a, W);
  if (!mu) return DLS_OK;
  derive_transposed(p, a, g); /* (DR4) */
  for (size_t k = 0; gr && k < m; k++)
    g[k] += gr[k];
  dlsi_derive_friction(work, g, mu);
  return DLS_OK;
}

dls_status dls_derive_vjp(dls_derive *derive, const double *gr, const double *gu, double *q,
                          double *mu, double *W, dls_error *error) {
  DLSI_DOOR;
  const size_t m = derive ? (size_t)derive->problem.d * (size_t)derive->problem.nc : 0;
  const dlsi_given given[] = {{"gr", gr, m}, {"gu", gu, m}};
  dls_status status = dlsi_derive_enter(derive, 0, 2, given, error);
  if (!status) status = dlsi_leave(&derive->busy, derive_vjp(derive, gr, gu, q, mu, W, error));
  return dlsi_at(__func__, status, error);
}

/* y := dW r. */
static dls_status derive_data(dls_derive *work, const double *dW, double *y, dls_error *error) {
  const dls_contact *p = &work->problem;
  dls_contact other = *p;
  memset(y, 0, (size_t)p->d * (size_t)p->nc * sizeof *y);
  if (!dW) return DLS_OK;
  if (!p->bodies.H) {
    *(p->Wb.x ? &other.Wb.x : &other.W.a) = dW;
    const dls_status status = dlsi_check_contact(&other, error);
    if (!status) dlsi_contact_apply(&other, work->r, y);
    return status;
  }
  other.Wb = (dls_blocks){0};
  other.bodies.H = dW;
  other.bodies.work = NULL;
  const dls_status status = dlsi_check_contact(&other, error);
  if (status) return status;
  const dls_bodies B = p->bodies;
  const size_t size = (size_t)(B.n * p->d);
  double *moved = work->motion, *motion = moved + (size_t)B.n * (size_t)B.count;
  derive_move(p, dW, work->r, moved);
  derive_move(p, B.H, work->r, motion);
  for (int c = 0; c < p->nc; c++) { /* (DR5) */
    const dlsi_pair_of_bodies one = dlsi_bodies_of(&B, size, (size_t)c, moved);
    const dlsi_pair_of_bodies two = dlsi_bodies_of(&other.bodies, size, (size_t)c, motion);
    dlsi_bodies_look(p->d, B.n, &one, y + p->d * c, y + p->d * c);
    dlsi_bodies_look(p->d, B.n, &two, y + p->d * c, y + p->d * c);
  }
  return DLS_OK;
}

static dls_status derive_jvp(dls_derive *work, const double *dq, const double *dmu,
                             const double *dW, double *dr, double *du, dls_error *error) {
  const dls_contact *p = &work->problem;
  const size_t m = (size_t)p->d * (size_t)p->nc;
  double *s = work->a, *fixed = work->b, *Ws = work->c;
  dls_status status = derive_data(work, dW, fixed, error);
  if (status) return status;
  for (size_t k = 0; dq && k < m; k++)
    fixed[k] += dq[k];
  dlsi_derive_slip(work, dmu, s);
  dlsi_contact_apply(p, s, Ws);
  for (size_t k = 0; k < m; k++)
    Ws[k] = -Ws[k] - fixed[k];
  dlsi_branches_rows(p->d, p->nc, work->branch, Ws, work->z); /* (DR2) */
  status = dlsi_derive_solve(work, 0, error);
  if (status) return status;
  dlsi_branches_add_directions(p->d, p->nc, work->branch, work->z, s); /* (DR1) */
  if (dr) memcpy(dr, s, m * sizeof *dr);
  if (!du) return DLS_OK;
  dlsi_contact_apply(p, s, Ws);
  for (size_t k = 0; k < m; k++)
    du[k] = Ws[k] + fixed[k];
  return DLS_OK;
}

dls_status dls_derive_jvp(dls_derive *derive, const double *dq, const double *dmu, const double *dW,
                          double *dr, double *du, dls_error *error) {
  DLSI_DOOR;
  const size_t nc = derive ? (size_t)derive->problem.nc : 0;
  const dlsi_given given[] = {{"dq", dq, derive ? (size_t)derive->problem.d * nc : 0},
                              {"dmu", dmu, nc}};
  dls_status status = dlsi_derive_enter(derive, 0, 2, given, error);
  if (!status) status = dlsi_leave(&derive->busy, derive_jvp(derive, dq, dmu, dW, dr, du, error));
  return dlsi_at(__func__, status, error);
}
