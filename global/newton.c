/*
 * newton.c: Newton steps on K itself, d = 2 and 3.
 *
 * In round variables, with v = r_n - s u_n, tau = r_t - s u_t, s = 1 or, on the split problem, the
 * splitting's rho if that is less (slips are 1e4 times reactions there), R = mu max(0, v), the law
 * is Alart and Curnier's equation of newton.c. Its branches decide which part of a new r is
 * known (t = tau / |tau|, in 3D p = t turned by 90 degrees):
 *
 *   (GN1)  free    v <= 0        r0 = 0                              nothing unknown
 *          stick   |tau| <= R    r0 = r                              dr:           u = 0
 *          slip    otherwise     r0 = r_n (n + mu t) + (p.r_t) p     dr = a (n + mu t) + b p:
 *                                  u_n = 0  and, 3D,  p.u_t + l (p.r_t + b) = 0,
 *                                  l = (|tau| - R) / (s R)
 *          slip, mu = 0          r0 = (r_n, 0)                       dr = a n:     u_n = 0
 *   (GN2)  | K + E   -H F      | |dx|   | f + H r0 - K x             |
 *          | G^T H^T  L + delta| |dy| = | -G^T u - (0 or l p.r_t)    |
 *          F the directions dr, G the tests, L = l on the rows of b. LU.
 *   (GN3)  x := x + dx, r := r0 + F dy
 *
 * delta = 1e-9 of the local compliance, which is 1 in round variables, keeps the matrix regular if
 * contacts are redundant. E is that of the splitting. Both are proximal terms: the right sides are
 * residuals, so that a fixed point depends on neither. For the same reason the factors of the
 * previous step serve again while no state has changed and a step gains a digit: a chord method.
 *
 * Every step is measured; the caller keeps the best pair. Ends after `most_steps`, if three steps
 * have not halved the measure, or if the matrix is singular.
 *
 *   (GN4)  Scattered steps (scatter.c): a contact whose state is to change keeps it with
 *          probability 1/2. E starts large and is halved by each step; s is drawn, too: with a
 *          small one a contact that slips the wrong way sticks first. 30 steps.
 *
 *   (GN5)  The error of an answer is the length of the next step. The step is taken if the
 *          certificate gets no worse; its own error is that of one more. Where W of the contacts
 *          that carry is singular, delta alone holds their reactions: they are not determined.
 *   (GN6)  A host with a preconditioner M of P = K + H B H^T has no LU: FGMRES (krylov.c) on (GN2),
 *          its second row in the unit of forces, with
 *            B = sum b_j G_j G_j^T,  b_j = min(1 / L_j, 20): rows that a contact holds are stiff
 *            dx := M (v_x + H F b v_y),  dy := b (v_y - G^T H^T dx)
 *          P is symmetric; the mu t of F is left to FGMRES. s = 1/10: the compliance of a surface,
 *          against that of a node with its neighbours held. 30 steps, of which six have to halve
 *          the measure. P is made anew if a state changes. No E: if the states leave a motion
 *          free, M may fail, and the splitting goes on.
 *
 * Cost of a step: LU of n + the unknowns of contact, which is several times a factor of A.
 */
#include <stdlib.h>
#include <string.h>

#include "global_internal.h"
#include "solved.h"

enum {
  most_steps = 12,
  patience = 3,
  most_scattered = 30,
  host_patience = 6,
  most_predicted = 1000
};

static const double delta = 1e-9;
static const double least_beta = 1e-10;  /* R / |tau|: keeps l finite if R vanishes */
static const double fade = 0.5;          /* (GN4) */
static const double least_hold = 1e-10;  /* (GN5) where the states leave a motion free */
static const double at_bound = 1e-6;     /* of R: a reaction on its cone */
static const double undetermined = 1e-3; /* of 1 / delta (GN5) */
static const double stale = 0.1;         /* ratio of residuals above which factors are renewed */
/* (GN6): s; stiffness of P over the local one where a contact holds; accuracy asked of M, and of a
 * step at most; of the last step over what tol asks */
static const double host_s = 0.1, held = 20, rough = 0.1, loose = 0.05, close_by = 0.3;

/* A contact under (GN1). */
typedef struct branch {
  dls_contact_state state;
  int first, count; /* its unknowns */
  double t[3], p[3];
  double l;
} branch;

typedef struct newton {
  dls_global *global;
  branch *of;
  dlsi_general general;
  dlsi_triplets t;
  double *v, *r, *x; /* right side and solution, n + m; r, m; x at the start, n */
  int unknowns;      /* of contact */
  int spatial;       /* 1: some contact slips in 3D */
  double hold;       /* E of (GN2) is hold E */
  double s;          /* of (GN1) */
  double *w, unit;   /* (GN6): max(n + m, d m); of the rows of contact, force / work^1/2 */
  uint64_t draw;     /* (GN4): where the draws are; 0: none */
} newton;

/* Returns 1 if both are the same linear equations. */
static int same_branch(int d, const branch *a, const branch *b) {
  return a->state == b->state && (d == 3 || a->t[1] == b->t[1]);
}

/* (GN1), (GN4) Sets the branches; returns 1 if the unknowns have changed. */
static int newton_sort(newton *N, const double *r, int first_step) {
  const dls_global *work = N->global;
  const int d = work->d;
  int changed = 0, first = 0;
  N->spatial = 0;
  for (int c = 0; c < work->nc; c++) {
    branch *b = &N->of[c], now = {.state = DLS_FREE, .first = first};
    const double *rc = r + d * c, *uc = work->u + d * c, v = rc[0] - N->s * uc[0];
    const double R = dlsi_friction_bound(work->bend[c], v);
    double tau[3] = {0};
    for (int i = 1; i < d; i++)
      tau[i] = rc[i] - N->s * uc[i];
    const double size = dlsi_tangent_norm(d, tau);
    if (v > 0 && work->bend[c] == 0) {
      now.state = DLS_SLIP;
      now.count = 1;
    } else if (v > 0 && size <= R) {
      now.state = DLS_STICK;
      now.count = d;
    } else if (v > 0) {
      now.state = DLS_SLIP;
      now.count = d - 1;
      for (int i = 1; i < d; i++)
        now.t[i] = tau[i] / size;
      now.p[1] = -now.t[2];
      now.p[2] = now.t[1];
      now.l = (R > least_beta * size ? (size - R) / R : 1 / least_beta) / N->s;
      N->spatial |= d == 3;
    }
    if (N->draw && !first_step && !same_branch(d, &now, b) &&
        dlsi_draw(N->draw += DLSI_GOLDEN_BITS) < 0.5) {
      now = *b;
      now.first = first;
    }
    first += now.count;
    changed |= !same_branch(d, &now, b);
    *b = now;
  }
  N->unknowns = first;
  double any = changed;
  dlsi_join(work->body.ranks, DLSI_MOST, &any, 1);
  return any > 0;
}

/* e := direction j of (GN1): of the reactions (test = 0), or of the test of positions. */
static void branch_vector(int d, double mu, const branch *b, int j, int test, double *e) {
  e[0] = e[1] = e[2] = 0;
  if (b->state == DLS_STICK || j == 0) e[j] = 1;
  if (b->state != DLS_SLIP || mu == 0) return;
  for (int i = 1; i < d; i++) {
    if (j == 1) e[i] = b->p[i];
    if (j == 0 && !test) e[i] = mu * b->t[i];
  }
  if (j == 1) e[0] = 0;
}

/* r0 of (GN1), in place. */
static void newton_base(const newton *N, double *r) {
  const int d = N->global->d;
  for (int c = 0; c < N->global->nc; c++) {
    const branch *b = &N->of[c];
    double *rc = r + d * c, pr = 0;
    const double mu = N->global->bend[c];
    if (b->state == DLS_STICK) continue;
    for (int i = 1; i < d; i++)
      pr += b->p[i] * rc[i];
    if (b->state == DLS_FREE) rc[0] = 0;
    for (int i = 1; i < d; i++)
      rc[i] = b->state == DLS_FREE || mu == 0 ? 0 : mu * rc[0] * b->t[i] + pr * b->p[i];
  }
}

/* Returns L of unknown j of a contact. */
static double branch_law(const branch *b, int j) {
  return delta + (j == 1 && b->state == DLS_SLIP ? b->l : 0);
}

/* ---- (GN6) ----------------------------------------------------------------------------------- */

static void newton_multiply(const dls_global *work, const double *x, double *y) {
  if (work->body.multiply)
    work->body.multiply(work->body.data, x, y, NULL);
  else
    dlsi_body_multiply(&work->model, x, y, NULL);
}

/* Returns the stiffness of unknown j in the preconditioner. */
static double newton_stiffness(const branch *b, int j) {
  return fmin(1 / branch_law(b, j), held);
}

/* e := G^T H^T x for the unknowns of contact. */
static void newton_tests(const newton *N, const double *x, double *e) {
  const dls_global *work = N->global;
  const int d = work->d;
  dlsi_global_look_from(work, NULL, x, work->look);
  for (int c = 0; c < work->nc; c++)
    for (int j = 0; j < N->of[c].count; j++) {
      double G[3], sum = 0;
      branch_vector(d, work->bend[c], &N->of[c], j, 1, G);
      for (int i = 0; i < d; i++)
        sum += G[i] * work->look[d * c + i];
      e[N->of[c].first + j] = sum;
    }
}

/* Gives the host P. */
static dls_status newton_block(newton *N, dls_error *error) {
  const dls_global *work = N->global;
  const int d = work->d;
  double *B = N->w;
  memset(B, 0, (size_t)(d * work->m) * sizeof *B);
  for (int c = 0; c < work->nc; c++)
    for (int j = 0; j < N->of[c].count; j++) {
      const double stiffness = newton_stiffness(&N->of[c], j), *root = work->root + d * c;
      double G[3];
      branch_vector(d, work->bend[c], &N->of[c], j, 1, G);
      for (int k = 0; k < d * d; k++)
        B[d * d * c + k] += stiffness * G[k % d] * G[k / d] / (root[k % d] * root[k / d]);
    }
  return dlsi_host_prepare(work->solver.block, work->solver.data, B, error);
}

/* w := A z */
static void newton_apply(void *data, const double *z, double *w) {
  newton *N = data;
  dls_global *work = N->global;
  const int d = work->d, n = work->n;
  double *s = work->look;
  newton_multiply(work, z, w);
  memset(s, 0, (size_t)work->m * sizeof *s);
  for (int c = 0; c < work->nc; c++)
    for (int j = 0; j < N->of[c].count; j++) {
      const branch *b = &N->of[c];
      double F[3];
      branch_vector(d, work->bend[c], b, j, 0, F);
      for (int i = 0; i < d; i++)
        s[d * c + i] -= F[i] * z[n + b->first + j];
    }
  dlsi_global_push(work, s, w);
  newton_tests(N, z, w + n);
  for (int c = 0; c < work->nc; c++)
    for (int j = 0; j < N->of[c].count; j++) {
      const int at = n + N->of[c].first + j;
      w[at] = N->unit * (w[at] + branch_law(&N->of[c], j) * z[at]);
    }
}

static dls_status newton_precondition(void *data, double *b, double *z, dls_error *error) {
  newton *N = data;
  dls_global *work = N->global;
  const int d = work->d, n = work->n;
  double *s = work->look;
  memset(s, 0, (size_t)work->m * sizeof *s);
  for (int c = 0; c < work->nc; c++)
    for (int j = 0; j < N->of[c].count; j++) {
      const branch *at = &N->of[c];
      double F[3];
      branch_vector(d, work->bend[c], at, j, 0, F);
      for (int i = 0; i < d; i++)
        s[d * c + i] += F[i] * newton_stiffness(at, j) * b[n + at->first + j] / N->unit;
    }
  dlsi_global_push(work, s, b);
  memset(z, 0, (size_t)n * sizeof *z);
  const dls_status status =
      dlsi_host_solve(work->solver.apply, work->solver.data, b, z, rough, error);
  if (status) return status;
  newton_tests(N, z, z + n);
  for (int c = 0; c < work->nc; c++)
    for (int j = 0; j < N->of[c].count; j++) {
      const int at = n + N->of[c].first + j;
      z[at] = newton_stiffness(&N->of[c], j) * (b[at] / N->unit - z[at]);
    }
  return DLS_OK;
}

/* v := about A^-1 v */
static dls_status newton_krylov(newton *N, double eta, dls_error *error) {
  const dls_global *work = N->global;
  const size_t size = (size_t)(work->n + N->unknowns);
  const dlsi_krylov of = {size, work->body.ranks, N, newton_apply, newton_precondition};
  for (int k = 0; k < N->unknowns; k++)
    N->v[work->n + k] *= N->unit;
  const dls_status status = dlsi_krylov_solve(&of, eta, N->v, N->w, error);
  memcpy(N->v, N->w, size * sizeof *N->v);
  return status;
}

/* (GN2) */
static dls_status newton_factor(newton *N, dls_error *error) {
  const dls_global *work = N->global;
  if (!work->system) return newton_block(N, error);
  const dls_sparse *K = &work->model.Ks;
  const dlsi_columns *H = &work->H;
  const int d = work->d, n = work->n, symmetric = work->model.factorization != DLS_LU;
  dlsi_triplets *t = &N->t;
  t->rows = t->cols = n + N->unknowns;
  t->count = 0;
  for (int j = 0; j < n; j++) {
    for (int k = K->p[j]; k < K->p[j + 1]; k++) {
      dlsi_triplets_add(t, K->i[k], j, K->x[k]);
      if (symmetric && K->i[k] != j) dlsi_triplets_add(t, j, K->i[k], K->x[k]);
    }
    if (N->hold > 0) dlsi_triplets_add(t, j, j, N->hold * work->system->e[j]);
  }
  for (int c = 0; c < work->nc; c++)
    for (int j = 0; j < N->of[c].count; j++) {
      const int at = n + N->of[c].first + j;
      double F[3], G[3];
      branch_vector(d, work->bend[c], &N->of[c], j, 0, F);
      branch_vector(d, work->bend[c], &N->of[c], j, 1, G);
      for (int i = 0; i < d; i++)
        for (int k = H->p[d * c + i]; k < H->p[d * c + i + 1]; k++) {
          if (F[i] != 0) dlsi_triplets_add(t, H->i[k], at, -F[i] * H->x[k]);
          if (G[i] != 0) dlsi_triplets_add(t, at, H->i[k], G[i] * H->x[k]);
        }
      dlsi_triplets_add(t, at, at, branch_law(&N->of[c], j));
    }
  return dlsi_general_factor(&N->general, t, error);
}

/* ---- the steps ------------------------------------------------------------------------------- */

/* (GN2), (GN3) */
static dls_status newton_step(newton *N, double *r, double eta, dls_error *error) {
  dls_global *work = N->global;
  const int d = work->d, n = work->n;
  double *v = N->v;
  newton_multiply(work, work->x, v);
  for (int j = 0; j < n; j++)
    v[j] = work->f[j] - v[j];
  dlsi_global_push(work, r, v);
  for (int c = 0; c < work->nc; c++)
    for (int j = 0; j < N->of[c].count; j++) {
      const branch *b = &N->of[c];
      double G[3], sum = 0;
      branch_vector(d, work->bend[c], b, j, 1, G);
      for (int i = 0; i < d; i++)
        sum += G[i] * work->u[d * c + i] +
               (b->state == DLS_SLIP && j == 1 && i > 0 ? b->l * b->p[i] * r[d * c + i] : 0);
      v[n + b->first + j] = -sum;
    }
  const dls_status status =
      work->system ? dlsi_general_solve(&N->general, 0, v, error) : newton_krylov(N, eta, error);
  if (status) return status;
  for (int j = 0; j < n; j++)
    work->x[j] += v[j];
  for (int c = 0; c < work->nc; c++)
    for (int j = 0; j < N->of[c].count; j++) {
      double F[3];
      branch_vector(d, work->bend[c], &N->of[c], j, 0, F);
      for (int i = 0; i < d; i++)
        r[d * c + i] += F[i] * v[n + N->of[c].first + j];
    }
  dlsi_global_look(work, work->x, work->u);
  return DLS_OK;
}

/* Sets u so that (GN1) takes the states of r. */
static void states_of_r(dls_global *work, const double *r) {
  const int d = work->d;
  for (int c = 0; c < work->nc; c++) {
    const double *rc = r + d * c, R = dlsi_friction_bound(work->bend[c], rc[0]);
    const int slips = dlsi_tangent_norm(d, rc) >= R * (1 - at_bound);
    work->u[d * c] = rc[0] > 0 ? 0 : 1;
    for (int i = 1; i < d; i++)
      work->u[d * c + i] = slips ? -rc[i] : 0;
  }
}

/* Returns the accuracy of a step's equations: its error is quadratic if no state has changed. */
static double newton_accuracy(const dls_global *work, double residual, int changed) {
  const double last = close_by * work->limits->tol / residual;
  return changed ? loose : fmin(loose, fmax(last, residual));
}

static dls_status newton_iterate(newton *N, double *r, double hold, dls_error *error) {
  dls_global *work = N->global;
  double before = INFINITY, halved = INFINITY;
  int slow = 0, fresh = 0;
  const int most = N->draw || !work->system ? most_scattered : most_steps;
  for (int step = 0; step < most && (slow < (work->system ? patience : host_patience) || N->draw);
       step++) {
    if (step == 0 && work->from_r) states_of_r(work, r);
    const int changed = newton_sort(N, r, step == 0), fades = N->draw && N->hold > 0;
    if (step == 0 && work->from_r) dlsi_global_look(work, work->x, work->u);
    newton_base(N, r);
    if (fades) N->hold = N->hold > hold ? N->hold * fade : 0;
    if (step == 0 || changed || fades || (N->spatial && !fresh && work->system)) {
      dls_status status = newton_factor(N, error);
      work->factorisations++;
      if (status == DLS_E_SINGULAR && N->hold < hold) {
        N->hold = hold;
        status = newton_factor(N, error);
        work->factorisations++;
      }
      if (status) return status;
    }
    dls_status status = newton_step(N, r, newton_accuracy(work, before, changed), error);
    if (status) return status;
    dls_certificate now;
    status = dlsi_global_measure(work, r, &now);
    const int splits = status == dlsi_split_first && !work->system; /* left to the splitting */
    if (status != DLS_STALLED && !splits) return status;
    status = dlsi_tell(work->limits, work->begun,
                       &(dls_progress){.method = "global",
                                       .stage = N->draw ? "scatter" : "newton",
                                       .iteration = step + 1,
                                       .max_iterations = most,
                                       .residual = now.residual,
                                       .r = work->trial});
    if (status) return status;
    if (!work->system && ++work->iterations == work->limits->max_iterations) break;
    const double badness = dlsi_body_badness(&now);
    if (!(badness <= DBL_MAX)) break;
    slow = badness < halved / 2 ? 0 : slow + 1;
    if (slow == 0) halved = badness;
    fresh = badness < stale * before;
    before = badness;
  }
  return DLS_STALLED;
}

static dls_status newton_create(newton *N, dls_global *work, dls_error *error) {
  const size_t n = (size_t)work->n, m = (size_t)work->m;
  const size_t of_host = work->system ? 0 : n + (size_t)work->d * m;
  dls_status status = DLS_OK;
  *N = (newton){.global = work,
                .hold = work->system ? work->system->hold : 0,
                .s = work->is_split ? fmin(1, work->rho)
                     : work->system ? 1
                                    : host_s,
                .unit = work->system ? 0 : 1 / sqrt(dlsi_global_compliance(work))};
  if (work->system) /* slip: H_n alone, H_n and H_t p, twice */
    status = dlsi_triplets_alloc(work->n + work->m, work->n + work->m,
                                 2 * (size_t)work->model.Ks.p[n] + n + m + 6 * (size_t)work->H.p[m],
                                 &N->t, error);
  N->of = calloc((size_t)work->nc + 1, sizeof *N->of);
  N->v = dlsi_alloc(2 * n + m + of_host, sizeof *N->v);
  if (status) return status;
  if (!N->of || !N->v) return dlsi_no_memory(error);
  N->x = N->v + n + m;
  N->w = N->x + n;
  return DLS_OK;
}

static void newton_free(newton *N) {
  dlsi_general_free(&N->general);
  dlsi_triplets_free(&N->t);
  free(N->of);
  free(N->v);
}

dls_status dlsi_global_newton(dls_global *work, double *r, double hold, uint64_t draw,
                              dls_error *error) {
  newton N;
  dls_error why = {0};
  const size_t n = (size_t)work->n;
  dls_status status = newton_create(&N, work, error);
  status = dlsi_joined_status(work->body.ranks, status, error);
  if (draw) {
    N.hold = pow(10, -8 * dlsi_draw(draw));
    N.s = pow(10, -8 * dlsi_draw(draw + 1));
    N.draw = dlsi_mix(draw) | 1;
  }
  if (!status) {
    memcpy(N.x, work->x, n * sizeof *N.x);
    status = newton_iterate(&N, r, hold, &why);
    memcpy(work->x, N.x, n * sizeof *N.x);
    if (status == DLS_E_SINGULAR || status == DLS_E_UNSUPPORTED)
      status = DLS_STALLED; /* the splitting goes on alone */
    else if (status < 0 && error)
      *error = why;
  }
  newton_free(&N);
  return status;
}

/* (GN5) Takes a step from `from` to r, x, the factors in N; returns the largest move over the
 * largest reaction, both in the caller's unit. */
static dls_status accuracy_step(newton *N, const double *from, double *r, double *moved,
                                dls_error *error) {
  const dls_global *work = N->global;
  double most = 0, move = 0;
  memcpy(r, from, (size_t)work->m * sizeof *r);
  newton_base(N, r);
  const dls_status status = newton_step(N, r, 0, error);
  for (int k = 0; k < work->m; k++) {
    most = fmax(most, fabs(r[k] / work->root[k]));
    move = fmax(move, fabs((r[k] - from[k]) / work->root[k]));
  }
  *moved = move == 0 ? 0 : move / most;
  return status;
}

/* (GN5) Returns 1 if the reactions are not determined: unit positions, with signs at random, make
 * them as large as delta does. */
static int accuracy_is_free(newton *N, dls_error *error) {
  const dls_global *work = N->global;
  const size_t n = (size_t)work->n;
  double most = 0;
  memset(N->v, 0, n * sizeof *N->v);
  for (int k = 0; k < N->unknowns; k++)
    N->v[n + (size_t)k] = dlsi_draw((uint64_t)(k + 1) * DLSI_GOLDEN_BITS) < 0.5 ? -1 : 1;
  if (dlsi_general_solve(&N->general, 0, N->v, error)) return 0;
  for (int k = 0; k < N->unknowns; k++)
    most = fmax(most, fabs(N->v[n + (size_t)k]));
  return most > undetermined / delta;
}

dls_status dlsi_global_accuracy(dls_global *work, double *predicted, dls_error *error) {
  newton N;
  dls_error why = {0};
  dls_certificate now;
  const size_t n = (size_t)work->n, m = (size_t)work->m;
  const dls_certificate best = work->best;
  *predicted = 0;
  if (!work->system || m == 0 || n + m > most_predicted) return DLS_OK;
  double *kept = dlsi_alloc(n + 2 * m, sizeof *kept), moved = 0;
  dls_status status = kept ? newton_create(&N, work, &why) : dlsi_no_memory(error);
  if (!kept) return status;
  double *r = kept + n, *next = work->before;
  if (!status) {
    memcpy(kept, work->best_x, n * sizeof *kept);
    memcpy(r + m, work->best_r, m * sizeof *r);
    memcpy(work->x, kept, n * sizeof *kept);
    for (size_t k = 0; k < m; k++)
      r[k] = work->best_r[k] * work->root[k];
    dlsi_global_look(work, work->x, work->u);
    (void)newton_sort(&N, r, 1);
    status = newton_factor(&N, &why);
    work->factorisations++;
    if (status == DLS_E_SINGULAR && N.hold < least_hold) {
      N.hold = least_hold;
      status = newton_factor(&N, &why);
      work->factorisations++;
    }
    if (!status) status = accuracy_step(&N, r, next, &moved, &why);
  }
  if (!status) {
    const dls_status verdict = dlsi_global_measure(work, next, &now);
    if (verdict == DLS_STALLED || verdict == dlsi_split_first ||
        !(dlsi_body_badness(&now) <= dlsi_body_badness(&best))) {
      work->best = best;
      memcpy(work->best_x, kept, n * sizeof *kept);
      memcpy(work->best_r, r + m, m * sizeof *r);
    } else {
      memcpy(r, next, m * sizeof *r);
      status = accuracy_step(&N, r, next, &moved, &why);
    }
    *predicted = accuracy_is_free(&N, &why) ? INFINITY : fmax(moved, work->best.floor_r);
  }
  newton_free(&N);
  free(kept);
  if (status == DLS_E_SINGULAR || status == DLS_E_UNSUPPORTED) return DLS_OK;
  if (status < 0 && error) *error = why;
  return status;
}

void dlsi_global_leave_error(dls_global *global, int unread) {
  global->unread = unread;
}
