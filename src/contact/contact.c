/*
 * contact.c: the contact problem u = W r + q and its certificate, the same for every method.
 *
 *   D_c = diag(w_n, w_t, ..),  v = D r - u,  R = mu (w_t / w_n) max(0, v_n)
 *   F_n = w_n r_n - max(0, v_n),  F_t = D r_t - P(v_t), P on the disc of radius R
 *   F = D r where v_n < 0
 *
 * F = 0 if and only if every contact meets the contact and friction laws (Alart and Curnier,
 * Comput. Methods Appl. Mech. Eng. 92, 1991, 353-375, (19)). The weights measure normals and
 * tangents by separate compliances. In r' = D^1/2 r, u' = D^-1/2 u the friction is
 * mu (w_t / w_n)^1/2 and the disc stays round.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "contact.h"

/* ---- W, dense or by blocks ------------------------------------------------------------------- */

/* Sums the blocks of column c in row c, W by blocks. n = d d is a parameter, so that the compiler
 * knows it when it inlines. block: the sum, n. */
static inline void sum_diagonal(size_t n, const dls_blocks *B, int c, double *block) {
  for (size_t e = 0; e < n; e++)
    block[e] = 0;
  for (int k = B->p[c]; k < B->p[c + 1]; k++)
    if (B->i[k] == c)
      for (size_t e = 0; e < n; e++)
        block[e] += B->x[n * (size_t)k + e];
}

void dlsi_contact_diagonal(const dls_contact *problem, int c, double *block) {
  const int d = problem->d;
  if (problem->bodies.H)
    dlsi_bodies_diagonal(problem, c, block);
  else if (!problem->Wb.x) {
    const size_t ld = (size_t)problem->W.ld, k = (size_t)d * (size_t)c;
    for (int j = 0; j < d; j++)
      for (int i = 0; i < d; i++)
        block[i + d * j] = problem->W.a[k + (size_t)i + (k + (size_t)j) * ld];
  } else if (d == 1)
    sum_diagonal(1, &problem->Wb, c, block);
  else if (d == 2)
    sum_diagonal(4, &problem->Wb, c, block);
  else
    sum_diagonal(9, &problem->Wb, c, block);
}

static int reaction_is_zero(size_t d, const double *r) {
  return r[0] == 0 && (d == 1 || r[1] == 0) && (d <= 2 || r[2] == 0);
}

static void multiply_panel(const dls_contact *problem, int count, const int *c, const double *dr,
                           double *u, double *a) {
  if (a)
    dlsi_contact_add_both(problem, count, c, dr, u, a);
  else
    dlsi_contact_add_panel(problem, count, c, dr, u);
}

/* Adds W r to u and, if a is not NULL, |W| |r| to a, W dense: gathers up to at_once contacts that
 * carry a reaction, so that dlsi_contact_add_panel reads W at the speed of the memory. Skips
 * reactions of 0, which add nothing as W is finite. */
static void multiply_dense(const dls_contact *problem, const int *order, const double *r, double *u,
                           double *a) {
  enum { at_once = 16 };
  const size_t d = (size_t)problem->d;
  int count = 0, c[at_once];
  double dr[3 * at_once];
  for (int i = 0; i < problem->nc; i++) {
    const int k = order ? order[i] : i;
    const double *rk = r + d * (size_t)k;
    if (reaction_is_zero(d, rk)) continue;
    memcpy(dr + d * (size_t)count, rk, d * sizeof *dr);
    c[count++] = k;
    if (count < at_once) continue;
    multiply_panel(problem, count, c, dr, u, a);
    count = 0;
  }
  multiply_panel(problem, count, c, dr, u, a);
}

/* Adds |W(:,c)| |rc| to a, W by blocks. */
static inline void add_magnitudes(size_t d, const dls_blocks *B, size_t c, const double *rc,
                                  double *a) {
  for (int k = B->p[c]; k < B->p[c + 1]; k++) {
    const double *x = B->x + d * d * (size_t)k;
    double *b = a + d * (size_t)B->i[k];
    for (size_t i = 0; i < d; i++) {
      double sum = 0;
      for (size_t j = 0; j < d; j++)
        sum += fabs(x[i + d * j]) * fabs(rc[j]);
      b[i] += sum;
    }
  }
}

void dlsi_contact_multiply(const dls_contact *problem, const int *order, const double *r, double *u,
                           double *a) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  if (m == 0) return; /* q may be NULL */
  if (problem->bodies.H) {
    dlsi_bodies_multiply(problem, order, problem->q, r, u, a);
    return;
  }
  memcpy(u, problem->q, m * sizeof *u);
  if (a) memset(a, 0, m * sizeof *a);
  if (!problem->Wb.x) {
    multiply_dense(problem, order, r, u, a);
    return;
  }
  for (int i = 0; i < problem->nc; i++) {
    const int c = order ? order[i] : i;
    const double *rc = r + d * (size_t)c;
    if (reaction_is_zero(d, rc)) continue;
    dlsi_contact_add_blocks(problem, c, rc, u);
    if (!a) continue;
    if (d == 1)
      add_magnitudes(1, &problem->Wb, (size_t)c, rc, a);
    else if (d == 2)
      add_magnitudes(2, &problem->Wb, (size_t)c, rc, a);
    else
      add_magnitudes(3, &problem->Wb, (size_t)c, rc, a);
  }
}

void dlsi_contact_apply(const dls_contact *problem, const double *x, double *y) {
  const size_t d = (size_t)problem->d;
  if (problem->bodies.H) {
    dlsi_bodies_multiply(problem, NULL, NULL, x, y, NULL);
    return;
  }
  memset(y, 0, d * (size_t)problem->nc * sizeof *y);
  for (int c = 0; c < problem->nc; c++)
    dlsi_contact_add_columns(problem, c, x + d * (size_t)c, y);
}

int dlsi_is_empty(const dls_contact *problem, const dls_limits *limits, dls_method method,
                  const char *name, dls_info *info) {
  if (problem->nc > 0) return 0;
  dlsi_tell_last(limits, dlsi_clock_start(limits), name, name, 0, 0, NULL);
  if (info) *info = (dls_info){.status = DLS_OK, .method = method};
  return 1;
}

void dlsi_put_on_discs(int d, int nc, const double *mu, const double *v, double *r) {
  for (int c = 0; c < nc; c++) {
    const double *vc = v + d * c;
    double *rc = r + d * c;
    rc[0] = vc[0] > 0 ? vc[0] : 0;
    const double R = dlsi_friction_bound(mu[c], rc[0]), size = dlsi_tangent_norm(d, vc);
    for (int i = 1; i < d; i++)
      rc[i] = size > R ? R * (vc[i] / size) : vc[i];
  }
}

/* ---- the certificate ------------------------------------------------------------------------- */

/* Returns the compliance for contacts whose own is not positive: the mean of the positive ones,
 * else the largest entry of the diagonal blocks, else 1. w: so far, every step-th entry. */
static double common_weight(const dls_contact *problem, const double *w, int step) {
  const int entries = problem->d * problem->d;
  double block[9] = {0}, sum = 0, largest = 0;
  int positive = 0;
  for (int c = 0; c < problem->nc; c++) {
    dlsi_contact_diagonal(problem, c, block);
    for (int e = 0; e < entries; e++)
      if (fabs(block[e]) > largest) largest = fabs(block[e]);
    if (w[step * c] > 0) {
      sum += w[step * c];
      positive++;
    }
  }
  return positive ? sum / positive : largest > 0 ? largest : 1;
}

/* Completes every step-th entry of w that is not positive. Returns how many are positive. */
static int complete_weights(const dls_contact *problem, double *w, int step) {
  int positive = 0;
  for (int c = 0; c < problem->nc; c++)
    positive += w[step * c] > 0;
  if (positive == problem->nc) return positive;
  const double common = common_weight(problem, w, step);
  for (int c = 0; c < problem->nc; c++)
    if (!(w[step * c] > 0)) w[step * c] = common;
  return positive;
}

/* Fills w and weights; one of them may be NULL. */
static void weights_of(const dls_contact *problem, double *w, double *weights) {
  const int d = problem->d, nc = problem->nc;
  const int given = problem->weights && weights;
  if (given) memcpy(weights, problem->weights, 2 * (size_t)nc * sizeof *weights);
  for (int c = 0; c < nc && (w || !given); c++) {
    double block[9] = {0};
    dlsi_contact_diagonal(problem, c, block);
    if (w) w[c] = dlsi_block_weight(d, block);
    if (!weights || given) continue;
    weights[2 * c] = block[0];
    weights[2 * c + 1] = d == 1 ? block[0] : d == 2 ? block[3] : (block[4] + block[8]) / 2;
  }
  if (w) (void)complete_weights(problem, w, 1);
  if (!weights || given) return;
  const int normals = complete_weights(problem, weights, 2);
  const int tangents = complete_weights(problem, weights + 1, 2);
  for (int c = 0; c < nc && !normals != !tangents; c++) /* a kind without any takes the other's */
    weights[2 * c + !tangents] = weights[2 * c + !normals];
}

void dlsi_contact_weights(const dls_contact *problem, double *w) {
  weights_of(problem, w, NULL);
}

void dlsi_certificate_weights(const dls_contact *problem, double *w) {
  weights_of(problem, NULL, w);
}

void dlsi_both_weights(const dls_contact *problem, double *w, double *weights) {
  weights_of(problem, w, weights);
}

/* Sets *m to max(*m, x), keeping NaN. */
static void raise_to(double *m, double x) {
  if (x > *m || x != x) *m = x;
}

/* Returns the size of the terms in the sum u_e. */
static inline double size_of_u(const dlsi_laws *of, size_t e) {
  return of->b ? of->a[e] + fabs(of->b[e]) : of->a[e];
}

static const double outside = 1e-4; /* of r_n: what no answer "to rounding" has */

/* Squares of the norms whose ratios are the certificate's first fields. The last five are sums over
 * the contacts that are not free. */
typedef struct measured_sums {
  double F, force;               /* D^1/2 F', D^-1/2 F' */
  double rounded, rounded_force; /* their sizes, for the rounding */
  double r, q, a;
  double any;     /* the sum of |F|: 0 where F is */
  double touches; /* contacts that are not free */
} measured_sums;

enum { of_F, of_force, of_rounded, of_rounded_force, of_r, of_q, of_a };

/* Returns 1 if F_c is no more than `hidden`. */
static inline int is_hidden(int d, const dlsi_laws *of, size_t o) {
  for (int i = 0; i < d; i++)
    if (!(fabs(of->F[o + (size_t)i]) <= of->hidden[o + (size_t)i])) return 0;
  return 1;
}

/* Fills size (d) with the scale of the rounding of F_c in this state; a: size of the terms in the
 * sum u.
 *
 *   stick  F = u                                      a
 *   slip   F_n = u_n                                  a_n
 *          F_t = D r_t - mu k v_n v_t / |v_t|         w_t |r_t| + mu k (a_n + w_n r_n), and in 3D
 *                                                     w_t |r_t| |a_t| / |v_t| for the direction
 *   free   F = D r is as good as exact                0
 *
 * A contact that sticks, but would slip with another rounding of v_n, adds mu k (a_n + w_n r_n).
 * Where F_c and D r_c are hidden, r_c is 0, and the rounding of its position presses nothing; if
 * `shows`, an r_c that is not 0 is as uncertain as what hides it. */
static inline void magnitudes(int d, const dlsi_laws *of, int k, dls_contact_state state,
                              double *size) {
  const size_t o = (size_t)d * (size_t)k;
  const double *w = of->w + 2 * (size_t)k, mu = of->mu[k], *r = of->r + o, *u = of->u + o;
  double v[3] = {0}, Dr[3] = {0};
  int zero = of->hidden && is_hidden(d, of, o);
  for (int i = 0; i < d; i++)
    zero &= zero && w[i > 0] * fabs(r[i]) <= of->hidden[o + (size_t)i];
  for (int i = 0; i < d; i++) {
    size[i] = zero || state == DLS_FREE ? 0 : size_of_u(of, o + (size_t)i);
    if (zero && of->shows && r[i] != 0) size[i] = of->hidden[o + (size_t)i] / (4 * DBL_EPSILON);
    Dr[i] = w[i > 0] * fabs(r[i]);
    v[i] = w[i > 0] * r[i] - u[i];
  }
  if (zero || d == 1 || state == DLS_FREE || dlsi_is_bonded(mu)) return;
  const double per_n = mu * (w[1] / w[0]), radius = per_n * (size[0] + Dr[0]);
  const double t = dlsi_tangent_norm(d, v);
  if (state == DLS_STICK) {
    for (int i = 1; t > per_n * v[0] - 4 * DBL_EPSILON * radius && i < d; i++)
      size[i] += radius;
    return;
  }
  const double at = dlsi_tangent_norm(d, size), push = dlsi_tangent_norm(d, Dr);
  const double turn = d == 3 && at > 0 ? push * (at / t) : 0;
  for (int i = 1; i < d; i++)
    size[i] = Dr[i] + radius + turn;
}

/* Returns entry i of contact k in the sum `what`. */
static double entry_of(const dlsi_laws *of, int what, int k, int i) {
  const int d = of->d;
  const size_t o = (size_t)d * (size_t)k, e = o + (size_t)i;
  const double *w = of->w + 2 * (size_t)k;
  double F[3] = {0}, size[3] = {0};
  if (what == of_F) return fabs(of->F[e]);
  if (what == of_force) return fabs(of->F[e]) / w[i > 0];
  const dls_contact_state state = dlsi_contact_misfit(d, of->mu[k], w, of->r + o, of->u + o, F);
  if (state == DLS_FREE) return 0;
  if (what == of_r) return fabs(of->r[e]);
  if (what == of_q) return fabs(of->scale[e]);
  if (what == of_a) return of->a[e];
  magnitudes(d, of, k, state, size);
  return what == of_rounded ? size[i] : size[i] / w[i > 0];
}

/* Returns the root of `plain`, or the norm itself if the plain sum of squares over- or
 * underflows. */
static double norm_of(const dlsi_laws *of, const measured_sums *s, int what, double plain) {
  if (dlsi_is_plain(plain)) return sqrt(plain);
  if (what <= of_force ? s->any == 0 : s->touches == 0) return 0;
  double largest = 0, sum = 0;
  for (int pass = 0; pass < 2; pass++) {
    const double scale = largest;
    for (int k = 0; k < of->nc; k++)
      for (int i = 0; i < of->d; i++) {
        const double x = entry_of(of, what, k, i);
        raise_to(&largest, x);
        if (pass) sum += (x / scale) * (x / scale);
      }
    dlsi_join(of->ranks, DLSI_MOST, &largest, 1);
    if (!(largest > 0 && largest <= DBL_MAX)) return largest;
  }
  dlsi_join(of->ranks, DLSI_SUM, &sum, 1);
  return largest * sqrt(sum);
}

/* Returns the contact with the largest |F_c| if plain sums of squares over- or underflow. */
static int find_worst(const dlsi_laws *of) {
  const size_t d = (size_t)of->d;
  double worst = -1;
  int at = 0;
  for (int k = 0; k < of->nc; k++) {
    const double size = dlsi_norm2(of->F + d * (size_t)k, d);
    if (!(size > worst) && size == size) continue;
    worst = size != size ? INFINITY : size;
    at = k;
  }
  return at;
}

/* Raises the fields for the reader by contact k, whose magnitudes are at most `largest`. */
static inline void measure_laws(int d, const dlsi_laws *of, int k, double largest,
                                dls_certificate *c) {
  const size_t o = (size_t)d * (size_t)k;
  const double mu = of->mu[k], *w = of->w + 2 * (size_t)k, *r = of->r + o, *u = of->u + o;
  const double ut = dlsi_tangent_norm(d, u), rt = dlsi_tangent_norm(d, r);
  raise_to(&c->penetration, -u[0]);
  raise_to(&c->adhesion, -r[0]);
  if (w[0] * fabs(r[0]) + w[1] * rt <= 4 * DBL_EPSILON * largest) return;
  raise_to(&c->cone_violation, rt - dlsi_friction_bound(mu, r[0]));
  raise_to(&c->complementarity, fabs(u[0] * r[0]));
  if (w[0] * r[0] <= u[0]) return;
  if (rt > 0) {
    double e[3] = {0};
    for (int i = 1; i < d; i++)
      e[i] = u[i] + ut * (r[i] / rt);
    raise_to(&c->slip_direction, dlsi_tangent_norm(d, e));
  } else if (mu * r[0] > 0)
    raise_to(&c->slip_direction, ut);
}

/* Sets the F of a contact to 0 if it is no more than `hidden`; but a contact that presses by more
 * shows a reaction that is far outside its cone. */
static inline void hide_rounding(int d, const dlsi_laws *of, double mu, const double *w, size_t o) {
  const double *r = of->r + o, bound = dlsi_friction_bound(mu, r[0]);
  if (!is_hidden(d, of, o)) return;
  if (w[0] * r[0] > of->hidden[o] && dlsi_tangent_norm(d, r) - bound > outside * r[0]) return;
  for (int i = 0; i < d; i++)
    of->F[o + (size_t)i] = 0;
}

/* Computes F and the fields of c from penetration on. d is a parameter, so that the compiler knows
 * it when it inlines. */
static inline measured_sums measure_each(int d, const dlsi_laws *of, dls_certificate *c) {
  measured_sums sums = {0};
  double worst = 0;
  for (int k = 0; k < of->nc; k++) {
    const size_t o = (size_t)d * (size_t)k;
    const double *w = of->w + 2 * (size_t)k, inverse[2] = {1 / w[0], 1 / w[d > 1]};
    const double *rc = of->r + o, *uc = of->u + o, *scale = of->scale + o;
    double *Fc = of->F + o, size = 0, x[3], largest = 0;
    if (reaction_is_zero((size_t)d, rc) && uc[0] >= 0 &&
        uc[0] + dlsi_tangent_norm(d, uc) <= DBL_MAX) { /* open: F_c = 0 */
      for (int i = 0; i < d; i++)
        Fc[i] = 0;
      continue;
    }
    const dls_contact_state state = dlsi_contact_misfit(d, of->mu[k], w, rc, uc, Fc);
    if (of->hidden) hide_rounding(d, of, of->mu[k], w, o);
    magnitudes(d, of, k, state, x);
    sums.touches += state != DLS_FREE;
    for (int i = 0; i < d; i++) {
      const double F = Fc[i] * inverse[i > 0], e = x[i] * inverse[i > 0];
      const double all = size_of_u(of, o + (size_t)i) + w[i > 0] * fabs(rc[i]);
      size += Fc[i] * Fc[i];
      sums.force += F * F;
      sums.any += fabs(Fc[i]);
      largest = all > largest ? all : largest;
      if (state == DLS_FREE) continue;
      sums.rounded += x[i] * x[i];
      sums.rounded_force += e * e;
      sums.r += rc[i] * rc[i];
      sums.q += scale[i] * scale[i];
      sums.a += of->a[o + (size_t)i] * of->a[o + (size_t)i];
    }
    sums.F += size;
    if (size > worst) {
      worst = size;
      c->worst = k;
    }
    measure_laws(d, of, k, largest, c);
  }
  return sums;
}

void dlsi_set_residuals(dls_certificate *c, double residual_u, double force, double r) {
  c->residual_u = residual_u;
  c->residual_r = force == 0 ? 0 : force > r ? 1 : force / r;
  c->residual =
      c->residual_r > residual_u || c->residual_r != c->residual_r ? c->residual_r : residual_u;
}

/* Joins what the ranks have measured. */
static void laws_join(const dlsi_laws *of, measured_sums *s, dls_certificate *c) {
  double most[] = {c->penetration, c->adhesion, c->cone_violation, c->slip_direction,
                   c->complementarity};
  const size_t d = (size_t)of->d;
  dlsi_join(of->ranks, DLSI_SUM, &s->F, sizeof *s / sizeof s->F);
  dlsi_join(of->ranks, DLSI_MOST, most, sizeof most / sizeof most[0]);
  c->penetration = most[0];
  c->adhesion = most[1];
  c->cone_violation = most[2];
  c->slip_direction = most[3];
  c->complementarity = most[4];
  if (!dlsi_is_plain(s->F)) c->worst = find_worst(of);
  double mine = of->nc ? dlsi_norm2(of->F + d * (size_t)c->worst, d) : -1, worst = mine;
  dlsi_join(of->ranks, DLSI_MOST, &worst, 1);
  double at = mine == worst || mine != mine ? -of->ranks->first - c->worst : -INT_MAX;
  dlsi_join(of->ranks, DLSI_MOST, &at, 1); /* the first of equals */
  c->worst = (int)-at;
}

void dlsi_laws_measure(const dlsi_laws *of, dls_certificate *certificate) {
  dls_certificate c = {.body = -1};
  measured_sums s = of->d == 1   ? measure_each(1, of, &c)
                    : of->d == 2 ? measure_each(2, of, &c)
                                 : measure_each(3, of, &c);
  if (of->ranks)
    laws_join(of, &s, &c);
  else if (!dlsi_is_plain(s.F))
    c.worst = find_worst(of);
  const double f = norm_of(of, &s, of_F, s.F), force = norm_of(of, &s, of_force, s.force);
  const double size = norm_of(of, &s, of_r, s.r), q = norm_of(of, &s, of_q, s.q);
  const double rounded = norm_of(of, &s, of_rounded, s.rounded);
  const double rounded_force = norm_of(of, &s, of_rounded_force, s.rounded_force);
  const double scale_u = q > 0 ? q : norm_of(of, &s, of_a, s.a),
               scale_r = force > size ? force : size;
  /* nothing presses, though r is not 0: 1. Relative to a norm beyond the range of numbers
   * everything is small: nothing is certified */
  const double residual_u = f == 0               ? 0
                            : scale_u == 0       ? 1
                            : scale_u <= DBL_MAX ? f / scale_u
                                                 : INFINITY;
  dlsi_set_residuals(&c, residual_u, force, size);
  c.floor_u = rounded == 0 ? 0 : DBL_EPSILON * (rounded / scale_u);
  c.floor_r = rounded_force == 0 ? 0 : DBL_EPSILON * (rounded_force / scale_r);
  *certificate = c;
}

void dlsi_contact_measure(const dls_contact *problem, const double *r, const double *u,
                          const double *a, const double *w, double *F,
                          dls_certificate *certificate) {
  const dlsi_laws of = {.d = problem->d,
                        .nc = problem->nc,
                        .mu = problem->mu,
                        .r = r,
                        .u = u,
                        .w = w,
                        .a = a,
                        .b = problem->q,
                        .scale = problem->q,
                        .F = F};
  dlsi_laws_measure(&of, certificate);
}

/* Returns 1 if the certificate meets tol and rounding hides no more than max(tol, most). */
static int meets_within(const dls_certificate *c, double tol, double most) {
  const double largest = tol > most ? tol : most;
  return c && dlsi_certificate_meets(c, tol) && 4 * c->floor_u <= largest &&
         4 * c->floor_r <= largest && 4 * c->floor_e <= largest;
}

int dlsi_certificate_holds(const dls_certificate *certificate, double tol) {
  return meets_within(certificate, tol, 1e-8);
}

dls_status dlsi_certificate_verdict(const dls_certificate *certificate, double tol) {
  if (meets_within(certificate, tol, 1e-8)) return DLS_OK;
  return meets_within(certificate, tol, 1e-4) ? DLS_TO_ROUNDING : DLS_STALLED;
}

int dls_certificate_holds(const dls_certificate *certificate, double tol) {
  DLSI_DOOR;
  return dlsi_certificate_holds(certificate, tol);
}

dls_status dls_certificate_verdict(const dls_certificate *certificate, double tol) {
  DLSI_DOOR;
  return dlsi_certificate_verdict(certificate, tol);
}

dls_status dlsi_settled(const dls_certificate *c, double tol, dls_status reason) {
  const dls_status verdict = dlsi_certificate_verdict(c, tol);
  const int by_itself = reason == DLS_OK || reason == DLS_STALLED || reason == DLS_TO_ROUNDING ||
                        reason == DLS_MAX_ITERATIONS || reason == DLS_RAY;
  if (verdict == DLS_OK || (verdict == DLS_TO_ROUNDING && by_itself)) return verdict;
  return reason == DLS_OK || reason == DLS_TO_ROUNDING ? DLS_STALLED : reason;
}

/* Fills state or misfit (`name`: which); the other is NULL. Returns a public function's status. */
static dls_status contact_tell(const dls_contact *problem, const double *r, const double *u,
                               const char *name, dls_contact_state *state, double *misfit,
                               dls_error *error) {
  dls_status status = dlsi_check_contact(problem, error);
  const size_t d = status ? 0 : (size_t)problem->d, nc = status ? 0 : (size_t)problem->nc;
  if (!status) status = dlsi_check_vector("r", r, d * nc, error);
  if (!status) status = dlsi_check_vector("u", u, d * nc, error);
  if (!status && !state && !misfit) status = dlsi_is_null(error, name);
  double *w = status ? NULL : dlsi_alloc(2 * nc, sizeof *w);
  if (!status && !w) status = dlsi_no_memory(error);
  if (status) return status;
  dlsi_certificate_weights(problem, w);
  for (size_t c = 0; c < nc; c++) {
    double F[3] = {0};
    const dls_contact_state now =
        dlsi_contact_misfit(problem->d, problem->mu[c], w + 2 * c, r + d * c, u + d * c, F);
    if (state) state[c] = now;
    if (misfit) misfit[c] = dlsi_norm2(F, d);
  }
  free(w);
  return DLS_OK;
}

dls_status dls_contact_states(const dls_contact *problem, const double *r, const double *u,
                              dls_contact_state *state, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, contact_tell(problem, r, u, "state", state, NULL, error), error);
}

dls_status dls_contact_misfits(const dls_contact *problem, const double *r, const double *u,
                               double *misfit, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, contact_tell(problem, r, u, "misfit", NULL, misfit, error), error);
}
