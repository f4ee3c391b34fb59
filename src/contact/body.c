/*
 * body.c: the certificate of a pair (x, r) on the body itself, in three parts.
 *
 *   (BO1)  residual_u = |D^1/2 F'| / s_u,  s_u^2 = sum |(H^T x)_c|^2 + |g_c|^2 + |D_c r_c|^2
 *   (BO2)  residual_r = |D^-1/2 F'| / |r|, as contact.h
 *   (BO3)  equilibrium: the forces that do not balance, and joints     equilibrium.c
 *
 * The sums are over the contacts that touch (contact.c). (BO1) is relative to the actual
 * displacements: |H^T K^-1 f|, the scale of the problem on W, is larger than the body if soft
 * springs hold it. D r, the local indentation, keeps the scale above rounding if everything sticks;
 * r enters it up to (EB2)'s bound.
 *
 *   (BO4)  floor_u, floor_r as of contact.h, with |H|^T |x| + |g| in place of |W||r| + |q|
 *   (BO5)  floor_e                                                     equilibrium.c
 *
 *   (BO6)  an F_c of no more than 4 eps D |H_c|^T a is 0, a = |K||x| + |f| + |H||r|, the last up to
 *          (EB2)'s bound, but at least the largest share of a in the body: if loads balance without
 *          the contacts, reactions are rounding, and so is their error. The rounding of one unknown
 *          affects the whole body as far as its row passes it on (dlsi_body_shares). So is an F_c
 *          of no more than 4 eps times the positions split off (body->blur). Where D r_c is no
 *          more, either, c is left out of (BO4); with joints, whose loads are not split off, an r_c
 *          that is not 0 has this bound as its rounding. Where D r_n is more, and r_c outside its
 *          cone by 1e-4, F_c stays
 *
 * The weights are local: the compliance of the whole body on soft supports would contain the motion
 * of the body. Cost: a product with K, O(nnz H). Fails: the weights, without memory.
 */
#include "body.h"

#include <stdlib.h>
#include <string.h>

enum { largest_block = 24 };

/* ---- weights --------------------------------------------------------------------------------- */

/* The unknowns J of a contact, K[J,J] and H_c. */
typedef struct contact_block {
  int size;
  int J[largest_block];
  double A[largest_block * largest_block];
  double H[3 * largest_block];
} contact_block;

/* Fills the block of contact c; returns 0 if it is empty or too large. place: n, -1 throughout, as
 * it is afterwards. */
static int block_fill(contact_block *b, const dls_model *model, const dls_sparse *H, int d, int c,
                      int *place) {
  int fits = 1;
  b->size = 0;
  for (int k = H->p[d * c]; fits && k < H->p[d * c + d]; k++) {
    if (place[H->i[k]] >= 0) continue;
    fits = b->size < largest_block;
    if (!fits) break;
    place[H->i[k]] = b->size;
    b->J[b->size++] = H->i[k];
  }
  const int s = b->size;
  memset(b->A, 0, (size_t)(s * s) * sizeof *b->A);
  memset(b->H, 0, (size_t)(d * s) * sizeof *b->H);
  for (int l = 0; fits && l < s; l++) {
    double v;
    for (int at = 0, i; dlsi_body_entry(model, b->J[l], &at, &i, &v);) {
      const int k = place[i];
      if (k < 0) continue;
      b->A[k + s * l] += v;
      if (model->factorization != DLS_LU && k != l) b->A[l + s * k] += v;
    }
  }
  for (int i = 0; fits && i < d; i++)
    for (int k = H->p[d * c + i]; k < H->p[d * c + i + 1]; k++)
      b->H[place[H->i[k]] + s * i] += H->x[k];
  for (int k = 0; k < s; k++)
    place[b->J[k]] = -1;
  return fits && s > 0;
}

/* Solves X := A^-1 X (s x count) by elimination with pivots by rows; returns 0 if A is singular. */
static int block_solve(double *A, int s, double *X, int count) {
  double most = 0;
  for (int k = 0; k < s * s; k++)
    if (fabs(A[k]) > most) most = fabs(A[k]);
  for (int k = 0; k < s; k++) {
    int p = k;
    for (int i = k + 1; i < s; i++)
      if (fabs(A[i + s * k]) > fabs(A[p + s * k])) p = i;
    if (!(fabs(A[p + s * k]) > 1e-12 * most)) return 0;
    for (int j = k; p != k && j < s; j++) {
      const double t = A[k + s * j];
      A[k + s * j] = A[p + s * j];
      A[p + s * j] = t;
    }
    for (int j = 0; p != k && j < count; j++) {
      const double t = X[k + s * j];
      X[k + s * j] = X[p + s * j];
      X[p + s * j] = t;
    }
    for (int i = k + 1; i < s; i++) {
      const double l = A[i + s * k] / A[k + s * k];
      for (int j = k + 1; j < s; j++)
        A[i + s * j] -= l * A[k + s * j];
      for (int j = 0; j < count; j++)
        X[i + s * j] -= l * X[k + s * j];
    }
  }
  for (int j = 0; j < count; j++)
    for (int k = s - 1; k >= 0; k--) {
      for (int i = k + 1; i < s; i++)
        X[k + s * j] -= A[k + s * i] * X[i + s * j];
      X[k + s * j] /= A[k + s * k];
    }
  return 1;
}

/* Computes C_ii of the d directions of a contact. */
static int block_compliance(contact_block *b, int d, double *C) {
  double X[3 * largest_block], A[largest_block * largest_block];
  memcpy(X, b->H, (size_t)(d * b->size) * sizeof *X);
  memcpy(A, b->A, (size_t)(b->size * b->size) * sizeof *A);
  if (!block_solve(A, b->size, X, d)) return 0;
  for (int i = 0; i < d; i++) {
    C[i] = 0;
    for (int k = 0; k < b->size; k++)
      C[i] += b->H[k + b->size * i] * X[k + b->size * i];
  }
  return 1;
}

/* Sets w_n and w_t of a contact from C; returns 1 if both are positive numbers. tangents: 0 if the
 * contact has none. */
static int weights_from(const double *C, int d, int tangents, double *w) {
  double sum = 0;
  for (int i = 1; i < d; i++)
    sum += C[i];
  w[0] = C[0];
  w[1] = tangents ? sum / (d - 1) : w[0];
  return w[0] > 0 && w[1] > 0 && w[0] <= DBL_MAX && w[1] <= DBL_MAX;
}

/* Replaces weights that are not positive by the mean of the positive ones of their kind, or 1. */
static void weights_complete(double *w, size_t nc) {
  for (size_t kind = 0; kind < 2; kind++) {
    double sum = 0, count = 0;
    for (size_t c = 0; c < nc; c++)
      if (w[2 * c + kind] > 0 && w[2 * c + kind] <= DBL_MAX) {
        sum += w[2 * c + kind];
        count++;
      }
    for (size_t c = 0; c < nc; c++)
      if (!(w[2 * c + kind] > 0 && w[2 * c + kind] <= DBL_MAX))
        w[2 * c + kind] = count > 0 ? sum / count : 1;
  }
}

dls_status dlsi_body_weights(const dls_model *model, const dls_sparse *H, int d, double *w,
                             dls_error *error) {
  const size_t n = (size_t)model->n, nc = (size_t)(H->cols / d);
  int *place = dlsi_alloc(n, sizeof *place);
  double *diagonal = dlsi_alloc(n, sizeof *diagonal);
  contact_block *block = dlsi_alloc(1, sizeof *block);
  const dls_status status = place && diagonal && block ? DLS_OK : dlsi_no_memory(error);
  for (size_t k = 0; !status && k < n; k++) {
    place[k] = -1;
    diagonal[k] = dlsi_body_diagonal(model, (int)k);
  }
  for (int c = 0; !status && c < (int)nc; c++) {
    const int tangents = H->p[d * c + 1] < H->p[d * c + d];
    double C[3];
    if (block_fill(block, model, H, d, c, place) && block_compliance(block, d, C) &&
        weights_from(C, d, tangents, w + 2 * c))
      continue;
    for (int i = 0; i < d; i++) {
      C[i] = 0;
      for (int k = H->p[d * c + i]; k < H->p[d * c + i + 1]; k++)
        if (diagonal[H->i[k]] > 0) C[i] += H->x[k] * H->x[k] / diagonal[H->i[k]];
    }
    (void)weights_from(C, d, tangents, w + 2 * c);
  }
  if (!status) weights_complete(w, nc);
  free(block);
  free(diagonal);
  free(place);
  return status;
}

void dlsi_body_shares(const dls_model *model, double *share) {
  const int symmetric = model->factorization != DLS_LU;
  memset(share, 0, (size_t)model->n * sizeof *share);
  for (int j = 0; j < model->n; j++) {
    double v;
    for (int at = 0, i; dlsi_body_entry(model, j, &at, &i, &v);) {
      if (i == j) continue;
      share[i] += fabs(v);
      if (symmetric) share[j] += fabs(v);
    }
  }
  for (int j = 0; j < model->n; j++) {
    const double stiffness = dlsi_body_diagonal(model, j);
    share[j] = share[j] < stiffness ? share[j] / stiffness : 1;
  }
}

/* ---- the measure ----------------------------------------------------------------------------- */

/* Arrays of a measure, in `work`: m unless said otherwise. */
typedef struct body_arrays {
  double *F;      /* D^1/2 F' */
  double *scale;  /* (BO1) */
  double *ut;     /* |H|^T |x| + |g| */
  double *hidden; /* (BO6) */
  dlsi_forces forces;
} body_arrays;

static size_t body_rows(const dlsi_body *body) {
  return body->ranks ? body->ranks->reach : (size_t)body->d * (size_t)body->nc;
}

size_t dlsi_body_scratch(const dlsi_body *body) {
  return 4 * body_rows(body) + dlsi_forces_scratch(body);
}

/* Sets *m to max(*m, x), keeping NaN. */
static void body_raise(double *m, double x) {
  if (x > *m || x != x) *m = x;
}

/* (BO1) */
static void measure_scale(const dlsi_body *body, const double *g, const double *r, const double *u,
                          int has_K, const body_arrays *of) {
  const size_t d = (size_t)body->d, m = d * (size_t)body->nc;
  const dls_sparse *Ht = &body->Ht;
  double *arm = of->hidden; /* largest entries of the columns of H */
  memset(arm, 0, body_rows(body) * sizeof *arm);
  for (int k = 0; has_K && k < Ht->p[body->n]; k++)
    arm[Ht->i[k]] = fmax(arm[Ht->i[k]], fabs(Ht->x[k]));
  dlsi_body_give(body, DLSI_MOST, arm, arm);
  for (size_t k = 0; k < m; k++) {
    const double gk = g ? g[k] : 0;
    double force = fabs(r[k]);
    if (has_K && arm[k] * force > *of->forces.most) force = *of->forces.most / arm[k];
    of->scale[k] = hypot(hypot(u[k] - gk, gk), body->w[2 * (k / d) + (k % d > 0)] * force);
  }
}

/* (BO6) */
static void measure_hidden(const dlsi_body *body, const body_arrays *of) {
  const size_t d = (size_t)body->d, m = d * (size_t)body->nc;
  const dls_sparse *Ht = &body->Ht;
  double *most = of->forces.sums;
  memset(most, 0, (size_t)body->parts * sizeof *most);
  memset(of->hidden, 0, body_rows(body) * sizeof *of->hidden);
  for (int turn = 0; turn < 2; turn++) {
    for (int j = 0; j < body->n; j++) {
      const double a = of->forces.ae[j] - fmax(0, of->forces.Hr[j] - *of->forces.most);
      const double share = body->share ? body->share[j] : 1;
      if (!turn && !(body->joint && body->joint[j])) body_raise(&most[body->part[j]], share * a);
      for (int k = Ht->p[j]; turn && k < Ht->p[j + 1]; k++)
        of->hidden[Ht->i[k]] += fabs(Ht->x[k]) * fmax(a, most[body->part[j]]);
    }
    if (!turn) dlsi_join(body->ranks, DLSI_MOST, most, (size_t)body->parts);
  }
  dlsi_body_give(body, DLSI_SUM, of->hidden, of->hidden);
  for (size_t k = 0; k < m; k++) {
    of->hidden[k] *= 4 * DBL_EPSILON * body->w[2 * (k / d) + (k % d > 0)];
    if (body->blur) of->hidden[k] += 4 * DBL_EPSILON * body->blur[k];
  }
}

void dlsi_body_measure(const dlsi_body *body, const double *f, const double *g, const double *mu,
                       const double *r, const double *x, double *u, double *work,
                       dls_certificate *certificate) {
  const size_t m = (size_t)body->d * (size_t)body->nc, rows = body_rows(body);
  const dls_sparse *Ht = &body->Ht;
  double *own = work + dlsi_forces_scratch(body);
  const body_arrays of = {.F = own,
                          .scale = own + rows,
                          .ut = own + 2 * rows,
                          .hidden = own + 3 * rows,
                          .forces = dlsi_forces_in(body, work)};
  dls_certificate found;
  memset(of.ut, 0, rows * sizeof *of.ut);
  for (size_t k = 0; k < m; k++) {
    u[k] = g ? g[k] : 0;
    of.ut[k] = fabs(u[k]) + (body->blur ? body->blur[k] : 0);
  }
  double *all = dlsi_body_reach(body, u);
  for (int j = 0; j < body->n; j++)
    for (int k = Ht->p[j]; k < Ht->p[j + 1]; k++) {
      all[Ht->i[k]] += Ht->x[k] * x[j];
      of.ut[Ht->i[k]] += fabs(Ht->x[k] * x[j]);
    }
  dlsi_body_give(body, DLSI_SUM, all, u);
  dlsi_body_give(body, DLSI_SUM, of.ut, of.ut);
  const int has_K = body->model || body->multiply;
  if (has_K) dlsi_forces_sum(body, f, r, x, &of.forces);
  measure_scale(body, g, r, u, has_K, &of);
  dlsi_laws laws = {.d = body->d,
                    .nc = body->nc,
                    .mu = mu,
                    .r = r,
                    .u = u,
                    .w = body->w,
                    .a = of.ut,
                    .scale = of.scale,
                    .F = of.F,
                    .ranks = body->ranks};
  if (has_K) {
    measure_hidden(body, &of);
    laws.hidden = of.hidden;
    laws.shows = body->joint != NULL;
  }
  dlsi_laws_measure(&laws, &found);
  if (has_K) dlsi_forces_measure(body, f, x, &of.forces, &found);
  body_raise(&found.residual, found.equilibrium);
  *certificate = found;
}

double dlsi_body_badness(const dls_certificate *c) {
  double most = c->residual;
  body_raise(&most, 4 * c->floor_u);
  body_raise(&most, 4 * c->floor_r);
  body_raise(&most, 4 * c->floor_e);
  return most;
}
