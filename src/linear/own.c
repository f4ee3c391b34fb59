/*
 * own.c: the body's own deformation under its loads.
 *
 *   (OW1)  x := x + B (f - K x), four times
 *   (OW2)  once more from x = 0 with f - e in place of f, e the f - K x of (OW1)
 *   (OW3)  rest := f - K x, 0 where it is rounding
 *
 * B = (K + eps H H^T)^-1 leaves a fraction eps / (eps + k) of what K resists with stiffness k, and
 * all of what it does not resist. (OW1) therefore ends with the resultants; (OW2) repeats it
 * without them, so that x contains no rigid motion. x and f - K x are kept in long double: loads
 * are up to 1e30 times f', and a body that K gives by a function is as exact as that.
 *
 *   (OW4)  The rounding of f and K: the rest of eps (|f| + |K||x|)_i with signs at random. A body's
 *          rest below 512 times that is 0: its loads balance.
 *
 * What K resists by its rounding alone is no support: x may contain a flight of any size.
 *
 *   (OW5)  Split the load K x: K x_e + rest. A body whose |rest| is at most 4 eps ||K||x|| has
 *          x := x_e, g := g + H^T (x - x_e).
 *   (OW6)  The rounding of x: e = K x - f - H r, no entry more than 4 eps |K||x|, as a load is
 *          K d + rest. x := x - d: then e has only the rest, and u the displacement.
 *   (OW7)  The positions that the rounding of f and K moves: the x_own of (OW4)'s load
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "linear/own.h"

enum { most_steps = 4 };

static const double suspicious = 1e-10; /* of |f|: (OW4) is worth its solves */
static const double noise = 512;        /* (OW4) */
static const double laws_hold = 1e-8;   /* residuals that need no (OW7) */
static const double cancels = 1e4;      /* times y: a y - d that has lost digits (OW6) */

typedef struct own_arrays {
  const dlsi_own *of;
  long double *rest, *size, *net; /* f - K x, |f| + |K||x|, e of (OW2) */
  double *y, *a, *load, *f;       /* scratch; loads */
  double *sums;                   /* 2 parts */
} own_arrays;

/* y := K x, size := |K||x|. */
static void own_product(const own_arrays *w, const long double *x, long double *y,
                        long double *size) {
  const dlsi_body *body = w->of->body;
  const int symmetric = !body->model || body->model->factorization != DLS_LU;
  for (int j = 0; j < body->n; j++) {
    y[j] = size[j] = 0;
    if (body->multiply) w->load[j] = (double)x[j];
  }
  if (body->multiply) body->multiply(body->data, w->load, w->y, w->a);
  for (int j = 0; j < body->n && body->multiply; j++) {
    y[j] = w->y[j];
    size[j] = w->a[j];
  }
  for (int j = 0; j < body->n && !body->multiply; j++) {
    double v;
    for (int at = 0, i; dlsi_body_entry(body->model, j, &at, &i, &v);) {
      y[i] += v * x[j];
      size[i] += fabsl(v * x[j]);
      if (!symmetric || i == j) continue;
      y[j] += v * x[i];
      size[j] += fabsl(v * x[i]);
    }
  }
}

/* rest := f - K x, size := |f| + |K||x|. */
static void own_rest(const own_arrays *w, const double *f, const long double *x) {
  own_product(w, x, w->rest, w->size);
  for (int j = 0; j < w->of->body->n; j++) {
    w->rest[j] = f[j] - w->rest[j];
    w->size[j] += fabs(f[j]);
  }
}

/* y := f - K x - net */
static void own_goal(const own_arrays *w) {
  for (int j = 0; j < w->of->body->n; j++)
    w->y[j] = (double)(w->rest[j] - w->net[j]);
}

/* (OW1), (OW2) */
static dls_status own_iterate(const own_arrays *w, const double *f, long double *x,
                              dls_error *error) {
  const int n = w->of->body->n;
  memset(w->net, 0, (size_t)n * sizeof *w->net);
  for (int turn = 0; turn < 2; turn++) {
    for (int j = 0; j < n; j++)
      x[j] = 0;
    own_rest(w, f, x);
    for (int step = 0; step < most_steps; step++) {
      own_goal(w);
      const dls_status status = w->of->solve(w->of->data, w->y, error);
      if (status) return status;
      for (int j = 0; j < n; j++)
        x[j] += w->y[j];
      own_rest(w, f, x);
    }
    for (int j = 0; j < n; j++)
      w->net[j] = w->rest[j];
  }
  return DLS_OK;
}

/* (OW3) rest := the rest, 0 where it is the rounding of a long double. */
static void own_take(const own_arrays *w, double *rest) {
  const double rounding = w->of->body->multiply ? 4 * DBL_EPSILON : 64 * LDBL_EPSILON;
  for (int j = 0; j < w->of->body->n; j++)
    rest[j] = fabsl(w->rest[j]) <= rounding * w->size[j] ? 0 : (double)w->rest[j];
}

/* sums := the largest |v| of each body. */
static void own_largest(const dlsi_body *body, const double *v, double *sums) {
  memset(sums, 0, (size_t)body->parts * sizeof *sums);
  for (int j = 0; j < body->n; j++)
    if (fabs(v[j]) > sums[body->part[j]]) sums[body->part[j]] = fabs(v[j]);
  dlsi_join(body->ranks, DLSI_MOST, sums, (size_t)body->parts);
}

/* (OW4) load := the rounding of f and K. */
static void own_signs(const own_arrays *w, double *load) {
  unsigned state = 1;
  for (int j = 0; j < w->of->body->n; j++) {
    state = state * 1664525u + 1013904223u;
    load[j] = (state >> 31 ? DBL_EPSILON : -DBL_EPSILON) * (double)w->size[j];
  }
}

/* (OW4) */
static dls_status own_round(const own_arrays *w, const double *f, double *rest, dls_error *error) {
  const dlsi_body *body = w->of->body;
  double *most = w->sums, *least = w->sums + body->parts;
  int any = 0;
  own_largest(body, f, most);
  own_largest(body, rest, least);
  for (int p = 0; p < body->parts; p++)
    any |= least[p] > 0 && least[p] <= suspicious * most[p];
  if (!any) return DLS_OK;
  long double *x = malloc((size_t)body->n * sizeof *x);
  double *load = dlsi_alloc((size_t)body->n, sizeof *load);
  dls_status status = x && load ? DLS_OK : dlsi_no_memory(error);
  status = dlsi_joined_status(body->ranks, status, error);
  if (!status) own_signs(w, load);
  if (!status) status = own_iterate(w, load, x, error);
  if (!status) {
    own_take(w, load);
    own_largest(body, load, most);
    for (int j = 0; j < body->n; j++)
      if (least[body->part[j]] <= noise * most[body->part[j]]) rest[j] = 0;
  }
  free(load);
  free(x);
  return status;
}

/* there: 1 if the caller has its own arrays. The caller calls own_free, also after an error. */
static dls_status own_arrays_create(own_arrays *w, const dlsi_own *of, int there,
                                    dls_error *error) {
  const size_t n = (size_t)of->body->n;
  *w = (own_arrays){.of = of};
  w->rest = calloc(3 * n + 1, sizeof *w->rest);
  w->y = dlsi_alloc(4 * n + 2 * (size_t)of->body->parts, sizeof *w->y);
  dls_status status = there && w->rest && w->y ? DLS_OK : dlsi_no_memory(error);
  status = dlsi_joined_status(of->body->ranks, status, error);
  if (status) return status;
  w->size = w->rest + n;
  w->net = w->size + n;
  w->a = w->y + n;
  w->load = w->a + n;
  w->f = w->load + n;
  w->sums = w->f + n;
  return DLS_OK;
}

static void own_free(own_arrays *w) {
  free(w->rest);
  free(w->y);
}

dls_status dlsi_own_split(const dlsi_own *of, const double *load, long double *x, double *rest,
                          dls_error *error) {
  own_arrays w;
  dls_status status = own_arrays_create(&w, of, 1, error);
  if (!status) {
    memcpy(w.f, load, (size_t)of->body->n * sizeof *load);
    status = own_iterate(&w, w.f, x, error);
    if (!status) {
      own_take(&w, rest);
      status = own_round(&w, w.f, rest, error);
    }
  }
  own_free(&w);
  return status;
}

void dlsi_own_look(const dlsi_body *body, const long double *x, double *g) {
  const dls_sparse *Ht = &body->Ht;
  double *all = dlsi_body_reach(body, g);
  for (int j = 0; j < body->n; j++)
    for (int k = Ht->p[j]; k < Ht->p[j + 1]; k++)
      all[Ht->i[k]] = (double)(all[Ht->i[k]] + Ht->x[k] * x[j]);
  dlsi_body_give(body, DLSI_SUM, all, g);
}

dls_status dlsi_own_land(const dlsi_own *of, double *x, double *g, dls_error *error) {
  const dlsi_body *body = of->body;
  const size_t n = (size_t)body->n;
  own_arrays w;
  long double *xe = malloc((2 * n + 1) * sizeof *xe), *away = xe ? xe + n : NULL;
  double *rest = dlsi_alloc(n, sizeof *rest);
  dls_status status = own_arrays_create(&w, of, xe && rest, error);
  if (!status) {
    for (size_t j = 0; j < n; j++)
      away[j] = x[j];
    own_product(&w, away, w.rest, w.size);
    memset(w.sums, 0, 2 * (size_t)body->parts * sizeof *w.sums);
    for (size_t j = 0; j < n; j++) {
      rest[j] = (double)w.rest[j];
      w.sums[body->part[j]] = hypot(w.sums[body->part[j]], (double)w.size[j]);
    }
    dlsi_join(body->ranks, DLSI_NORM, w.sums, (size_t)body->parts);
    status = dlsi_own_split(of, rest, xe, rest, error);
  }
  if (!status) {
    double *held = w.sums + body->parts;
    for (size_t j = 0; j < n; j++)
      held[body->part[j]] = hypot(held[body->part[j]], rest[j]);
    dlsi_join(body->ranks, DLSI_NORM, held, (size_t)body->parts);
    for (size_t j = 0; j < n; j++) {
      const int p = body->part[j];
      if (!(held[p] <= 4 * DBL_EPSILON * w.sums[p])) xe[j] = x[j];
      away[j] -= xe[j];
      x[j] = (double)xe[j];
    }
    dlsi_own_look(body, away, g);
  }
  own_free(&w);
  free(rest);
  free(xe);
  return status;
}

/* (OW6) y := y - d; *again: raised to 1 where y is the rounding of d. x: as it was given, whose
 * rounding it is; e: scratch, n. */
static dls_status own_mend(const own_arrays *w, const double *f, const double *r, const double *x,
                           double *y, double *e, long double *d, int *again, dls_error *error) {
  const dlsi_body *body = w->of->body;
  const dls_sparse *Ht = &body->Ht;
  for (int j = 0; j < body->n; j++)
    d[j] = x[j];
  own_product(w, d, w->rest, w->net);
  for (int j = 0; j < body->n; j++)
    d[j] = y[j];
  own_product(w, d, w->rest, w->size);
  for (int j = 0; j < body->n; j++) {
    long double sum = w->rest[j] - f[j];
    for (int k = Ht->p[j]; k < Ht->p[j + 1]; k++)
      sum -= (long double)Ht->x[k] * r[Ht->i[k]];
    const double most = 4 * DBL_EPSILON * (double)w->net[j];
    e[j] = fmin(fmax((double)sum, -most), most);
  }
  const dls_status status = dlsi_own_split(w->of, e, d, e, error);
  for (int j = 0; !status && j < body->n; j++) {
    y[j] = (double)(y[j] - d[j]);
    *again |= fabsl(d[j]) > cancels * fabs(y[j]);
  }
  return status;
}

/* Returns K_jj, 1 if K is given by a function. */
static double own_diagonal(const dlsi_body *body, int j) {
  return body->multiply ? 1 : dlsi_body_diagonal(body->model, j);
}

void dlsi_own_balanced(const dlsi_body *body, const double *f, const double *rest,
                       double *balanced) {
  for (int p = 0; p < body->parts; p++)
    balanced[p] = INFINITY;
  for (int j = 0; j < body->n; j++) {
    const double k = own_diagonal(body, j);
    if (k > 0 && k < balanced[body->part[j]]) balanced[body->part[j]] = k;
  }
  double *size = balanced + body->parts;
  memset(size, 0, (size_t)body->parts * sizeof *size);
  for (int j = 0; j < body->n; j++) {
    const double k = own_diagonal(body, j), least = balanced[body->part[j]];
    if (k > 0) size[body->part[j]] = hypot(size[body->part[j]], f[j] * (least / k));
  }
  dlsi_join(body->ranks, DLSI_NORM, size, (size_t)body->parts);
  for (int p = 0; p < body->parts; p++)
    balanced[p] = 0; /* 1: a rest */
  for (int j = 0; j < body->n; j++)
    if (rest[j] != 0) balanced[body->part[j]] = 1;
  dlsi_join(body->ranks, DLSI_MOST, balanced, (size_t)body->parts);
  for (int p = 0; p < body->parts; p++)
    balanced[p] = balanced[p] > 0 ? 0 : size[p];
}

void dlsi_own_blur(const dlsi_body *body, const long double *x, double *parts, double *blur) {
  const dls_sparse *Ht = &body->Ht;
  memset(parts, 0, (size_t)body->parts * sizeof *parts);
  memset(blur, 0, (size_t)body->d * (size_t)body->nc * sizeof *blur);
  double *all = dlsi_body_reach(body, blur);
  for (int turn = 0; turn < 2; turn++) {
    for (int j = 0; j < body->n; j++) {
      double *most = &parts[body->part[j]];
      for (int k = Ht->p[j]; k < Ht->p[j + 1]; k++) {
        const double u = fabs(Ht->x[k]) * (double)fabsl(x[j]);
        if (turn)
          all[Ht->i[k]] = fmax(all[Ht->i[k]], *most);
        else
          *most = fmax(*most, u);
      }
    }
    if (!turn) dlsi_join(body->ranks, DLSI_MOST, parts, (size_t)body->parts);
  }
  dlsi_body_give(body, DLSI_MOST, all, blur);
}

/* (OW7) Raises blur. x: x_own; e: n, shaken: n, blurred: m, scratch. Costs a split. */
static dls_status own_shake(const own_arrays *w, const long double *x, double *e,
                            long double *shaken, double *blurred, double *blur, dls_error *error) {
  const dlsi_body *body = w->of->body;
  own_rest(w, w->f, x);
  own_signs(w, e);
  const dls_status status = dlsi_own_split(w->of, e, shaken, e, error);
  if (status) return status;
  dlsi_own_blur(body, shaken, w->sums, blurred);
  for (int k = 0; k < body->d * body->nc; k++)
    blur[k] = fmax(blur[k], blurred[k] / DBL_EPSILON);
  return DLS_OK;
}

dls_status dlsi_own_measure(const dlsi_own *of, const double *f, const double *g, const double *mu,
                            const double *r, const double *x, double *u, double *work,
                            dls_certificate *certificate, dls_error *error) {
  const dlsi_body *body = of->body;
  const size_t n = (size_t)body->n, m = (size_t)body->d * (size_t)body->nc;
  own_arrays w;
  long double *own = malloc((2 * n + 1) * sizeof *own), *shaken = own ? own + n : NULL;
  double *rest = dlsi_alloc(3 * n + 3 * m + 2 * (size_t)body->parts, sizeof *rest);
  dls_status status = own_arrays_create(&w, of, own && rest, error);
  if (!status) {
    double *y = rest + n, *e = y + n, *gap = e + n, *blur = gap + m, *blurred = blur + m,
           *balanced = blurred + m;
    dlsi_body split = *body;
    if (f)
      memcpy(w.f, f, n * sizeof *f);
    else
      memset(w.f, 0, n * sizeof *w.f);
    for (size_t k = 0; k < m; k++)
      gap[k] = g ? g[k] : 0;
    status = dlsi_own_split(of, w.f, own, rest, error);
    if (!status) {
      dlsi_own_blur(body, own, w.sums, blur);
      dlsi_own_balanced(body, w.f, rest, balanced);
      dlsi_own_look(body, own, gap);
      for (size_t j = 0; j < n; j++)
        y[j] = (double)(x[j] - own[j]);
      status = dlsi_own_land(of, y, gap, error);
    }
    for (int turn = 0, again = 1; !status && again && turn < 2; turn++) {
      again = 0;
      status = own_mend(&w, rest, r, x, y, e, shaken, &again, error);
    }
    if (!status) {
      split.balanced = balanced;
      split.blur = blur;
      dlsi_body_measure(&split, rest, gap, mu, r, y, u, work, certificate);
      if (!(fmax(certificate->residual_u, certificate->residual_r) <= laws_hold)) {
        status = own_shake(&w, own, e, shaken, blurred, blur, error);
        if (!status) dlsi_body_measure(&split, rest, gap, mu, r, y, u, work, certificate);
      }
    }
    if (!status) {
      for (size_t k = 0; k < m; k++)
        u[k] = g ? g[k] : 0;
      for (size_t j = 0; j < n; j++)
        own[j] = x[j];
      dlsi_own_look(body, own, u);
    }
  }
  own_free(&w);
  free(rest);
  free(own);
  return status;
}
