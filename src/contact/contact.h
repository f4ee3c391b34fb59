/* contact.h: the contact problem: its products, its certificate, what every method does with it. */
#ifndef DLSI_CONTACT_H
#define DLSI_CONTACT_H

#include "base/base.h"

/* ---- rigid bodies (bodies.c) ----------------------------------------------------------------- */

/* A copy of a problem of bodies with scratch, and perhaps also with W by blocks: products and the
 * certificate use the factors, methods that need entries of W the blocks. Zero at first; the memory
 * stays from one problem to the next. */
typedef struct dlsi_formed {
  dls_contact problem;
  double *work, *x;  /* bodies.work; Wb.x */
  int *p, *i, *list; /* Wb.p; Wb.i; the contacts of each body: starts, then contacts */
  size_t work_room, x_room, p_room, i_room, list_room;
} dlsi_formed;

/* Turn *problem, a problem of bodies, into a copy with scratch (lend), and with W by blocks (form).
 * Its memory is in *formed. Other storage stays unchanged. dlsi_form_blocks checks a problem of
 * bodies first. DLS_E_MEMORY; DLS_E_SIZE for too many blocks. */
dls_status dlsi_lend(dlsi_formed *formed, const dls_contact **problem, dls_error *error);
dls_status dlsi_form_blocks(dlsi_formed *formed, const dls_contact **problem, dls_error *error);
void dlsi_formed_free(dlsi_formed *formed);

/* Returns 1 if W is only there as H^T H. */
static inline int dlsi_is_factored(const dls_contact *problem) {
  return problem->bodies.H && !problem->Wb.x;
}

/* Returns `held` if it has room for `count` entries. Else returns a new array of them and frees
 * held; NULL without memory, and held stays. room: of held. */
void *dlsi_make_room(void *held, size_t *room, size_t count, size_t size);

/* Computes u := W r + q (q NULL for 0) and, if a is not NULL, a := |H|^T |H| |r|; bodies.work := H
 * r. */
void dlsi_bodies_multiply(const dls_contact *problem, const int *order, const double *q,
                          const double *r, double *u, double *a);

/* Copies the d x d diagonal block of contact c. */
void dlsi_bodies_diagonal(const dls_contact *problem, int c, double *block);

/* The two bodies of contact c: their numbers, H and motions v; NULL for a fixed body. */
typedef struct dlsi_pair_of_bodies {
  const double *H[2];
  double *v[2];
} dlsi_pair_of_bodies;

static inline dlsi_pair_of_bodies dlsi_bodies_of(const dls_bodies *B, size_t size, size_t c,
                                                 double *v) {
  dlsi_pair_of_bodies of = {{NULL, NULL}, {NULL, NULL}};
  for (size_t side = 0; side < 2; side++) {
    const int b = B->body[2 * c + side];
    if (b < 0) continue;
    of.H[side] = B->H + (2 * c + side) * size;
    of.v[side] = v + (size_t)B->n * (size_t)b;
  }
  return of;
}

/* Two motions of a body. */
typedef double dlsi_two __attribute__((vector_size(16), aligned(8), may_alias));

/* Returns h . v; n = 3 or 6, a constant when inlined. */
static DLSI_INLINE double dlsi_motion_dot(const int n, const double *h, const double *v) {
  const dlsi_two *a = (const dlsi_two *)h, *b = (const dlsi_two *)v;
  dlsi_two s = a[0] * b[0];
  if (n == 6) {
    s += a[1] * b[1];
    s += a[2] * b[2];
    return s[0] + s[1];
  }
  return (s[0] + s[1]) + h[2] * v[2];
}

/* u (d) := q + H^T v over both bodies. */
static DLSI_INLINE void dlsi_bodies_look(const int d, const int n, const dlsi_pair_of_bodies *of,
                                         const double *q, double *u) {
  for (int i = 0; i < d; i++)
    u[i] = q[i];
  for (int side = 0; side < 2; side++)
    for (int i = 0; of->H[side] && i < d; i++)
      u[i] += dlsi_motion_dot(n, of->H[side] + n * i, of->v[side]);
}

/* v += H r of both bodies. */
static DLSI_INLINE void dlsi_bodies_push(const int d, const int n, const dlsi_pair_of_bodies *of,
                                         const double *r) {
  for (int side = 0; side < 2; side++) {
    const double *h = of->H[side];
    double *v = of->v[side];
    if (!h) continue;
    for (int k = 0; k < n; k++) {
      double sum = h[k] * r[0];
      for (int i = 1; i < d; i++)
        sum += h[k + n * i] * r[i];
      v[k] += sum;
    }
  }
}

/* u := q + H^T v for the contacts first .. end-1, v = bodies.work. */
void dlsi_bodies_unfold(const dls_contact *problem, int first, int end, double *u);

/* ---- units (units.c) ------------------------------------------------------------------------- */

/* A copy of a problem in units of its own. Zero at first; its powers and its memory stay from one
 * problem to the next. */
typedef struct dlsi_units {
  int W, q;            /* W and q of the caller are 2 to these powers times those of the copy */
  dls_contact problem; /* the copy; not in use while both are 0 */
  double *values;      /* its arrays, and: */
  double *r, *u;       /* m: of the copy */
  double *shown;       /* m: r of a progress in the units of the caller */
  size_t room;
} dlsi_units;

/* Returns the largest |entry| of W; 1 if squares stay in the range of numbers, without a copy. */
double dlsi_largest_value(const dls_contact *problem);
int dlsi_has_plain_units(const dls_contact *problem);

/* Turns *problem, which has been checked, into a copy in units of its own, if squares could leave
 * the range of numbers in those of the caller. DLS_E_MEMORY. */
dls_status dlsi_take_units(dlsi_units *units, const dls_contact **problem, dls_error *error);
void dlsi_units_free(dlsi_units *units);

/* The same of a problem and a vector r of reactions; neither is replaced if r would lose bits. */
dls_status dlsi_take_answer(dlsi_units *units, const dls_contact **problem, const double **r,
                            dls_error *error);

/* y := 2^power x, n entries, y may be x. The second one returns 1 if that has rounded none. */
void dlsi_shift(size_t n, int power, const double *x, double *y);
int dlsi_shift_exactly(size_t n, int power, const double *x, double *y);

/* Sets the fields of a certificate of the copy to the units of the caller. */
void dlsi_certificate_from_units(const dlsi_units *units, dls_certificate *certificate);

/* ---- the contact problem --------------------------------------------------------------------- */

/* One block column of W, dense or by blocks, for a loop over its blocks: for k = begin .. end-1 the
 * block in block row dlsi_row(&column, k) has entry (i, j) at block[i + ld j], block = x + k
 * step. */
typedef struct dlsi_block_column {
  size_t begin, end;
  const int *row; /* NULL: k */
  const double *x;
  size_t step, ld;
} dlsi_block_column;

static inline dlsi_block_column dlsi_contact_column(const dls_contact *problem, size_t c) {
  const size_t d = (size_t)problem->d, ld = (size_t)problem->W.ld;
  const dls_blocks *B = &problem->Wb;
  if (B->x) return (dlsi_block_column){(size_t)B->p[c], (size_t)B->p[c + 1], B->i, B->x, d * d, d};
  return (dlsi_block_column){0, (size_t)problem->nc, NULL, problem->W.a + d * c * ld, d, ld};
}

static inline size_t dlsi_row(const dlsi_block_column *column, size_t k) {
  return column->row ? (size_t)column->row[k] : k;
}

/* Copies the d x d diagonal block of contact c, column-major; zeros if a block-sparse W has
 * none. */
void dlsi_contact_diagonal(const dls_contact *problem, int c, double *block);

/* Adds W(:,c) dr to u for the d columns of contact c. */
void dlsi_contact_add_columns(const dls_contact *problem, int c, const double *dr, double *u);

/* Adds W(:,c) dr to u for the d columns of contact c, W by blocks. */
void dlsi_contact_add_blocks(const dls_contact *problem, int c, const double *dr, double *u);

/* Adds W(:,c[k]) dr[d k..] to u for k = 0 .. count-1, one after the other, W dense. */
void dlsi_contact_add_panel(const dls_contact *problem, int count, const int *c, const double *dr,
                            double *u);

/* As dlsi_contact_add_panel; also adds |W(:,c[k])| |dr[d k..]| to a. */
void dlsi_contact_add_both(const dls_contact *problem, int count, const int *c, const double *dr,
                           double *u, double *a);

/* y := W x, without q. */
void dlsi_contact_apply(const dls_contact *problem, const double *x, double *y);

/* Computes u := W r + q and, if a is not NULL, a := |W| |r|, column after column of the contacts in
 * `order`, which determines the rounding. order: contacts, nc; NULL for 0, 1, .. For bodies a is
 * |H|^T |H| |r|, the scale of the rounding of H^T (H r), and bodies.work := H r. */
void dlsi_contact_multiply(const dls_contact *problem, const int *order, const double *r, double *u,
                           double *a);

/* Compute y := A^T x and y -= A x for A (m x n, column-major, leading dimension m). */
void dlsi_panel_dot(size_t m, int n, const double *A, const double *x, double *y);
void dlsi_panel_subtract(size_t m, int n, const double *A, const double *x, double *y);

/* Computes one compliance per contact, the unit of the steps of methods: trace(W_cc) / d. If that
 * is not positive: the mean of the positive ones; if none is positive, the largest |entry| of the
 * diagonal blocks; 1 if all of them are 0. w: nc. */
void dlsi_contact_weights(const dls_contact *problem, double *w);

/* Computes the weights of the certificate: problem->weights, or W_nn and trace(W_tt) / (d-1) of the
 * diagonal block. A weight that is not positive is completed as above from those of its kind
 * (normal or tangential), and a kind without any from the other kind. w: 2 nc. */
void dlsi_certificate_weights(const dls_contact *problem, double *w);

/* Computes both in one pass. w: nc, weights: 2 nc. */
void dlsi_both_weights(const dls_contact *problem, double *w, double *weights);

/* Fills *subset as dls_contact_subset does, from arguments that have been checked; count > 0. */
void dlsi_subset(const dls_contact *problem, int count, const int *candidate, double *values,
                 int *index, dls_contact *subset);

/* Returns trace(W_cc) / d of one block. */
static inline double dlsi_block_weight(int d, const double *block) {
  if (d == 1) return block[0];
  return d == 2 ? (block[0] + block[3]) / 2 : (block[0] + block[4] + block[8]) / 3;
}

/* Returns 1 for a zero d-vector of a contact. */
static inline int dlsi_is_zero(int d, const double *v) {
  return v[0] == 0 && (d < 2 || v[1] == 0) && (d < 3 || v[2] == 0);
}

/* Returns |v_t|. */
static inline double dlsi_tangent_norm(int d, const double *v) {
  if (d == 1) return 0;
  if (d == 2) return fabs(v[1]);
  const double s = v[1] * v[1] + v[2] * v[2];
  return dlsi_is_plain(s) ? sqrt(s) : dlsi_norm2(v + 1, 2); /* to the same bits */
}

/* Projects v (d) on C_mu = { |r_t| <= mu r_n }: p := P(v); returns the branch taken. */
static inline dls_contact_state dlsi_project_cone(int d, double mu, const double *v, double *p) {
  if (dlsi_is_bonded(mu)) { /* C_mu = { r_n > 0 or r = 0 } */
    for (int i = 0; i < d; i++)
      p[i] = v[0] > 0 ? v[i] : 0;
    return v[0] > 0 ? DLS_STICK : DLS_FREE;
  }
  const double t = dlsi_tangent_norm(d, v);
  if (t <= mu * v[0] && v[0] >= 0) { /* inside; mu = 0 has t = mu v_n for any sign of v_n */
    for (int i = 0; i < d; i++)
      p[i] = v[i];
    return DLS_STICK;
  }
  if (mu * t <= -v[0]) { /* in the polar cone */
    for (int i = 0; i < d; i++)
      p[i] = 0;
    return DLS_FREE;
  }
  p[0] = (v[0] + mu * t) / (1 + mu * mu);
  if (d == 2)
    p[1] = copysign(mu * p[0], v[1]);
  else if (d == 3) {
    const double k = mu * p[0] / t;
    p[1] = k * v[1];
    p[2] = k * v[2];
  }
  return DLS_SLIP;
}

/* Computes the reactions r (d nc) that the law gives for v (d nc): r_n = max(v_n, 0), r_t = v_t put
 * on the disc |.| <= mu r_n. Unlike this, the projection on C_mu also changes r_n. */
void dlsi_put_on_discs(int d, int nc, const double *mu, const double *v, double *r);

/* Computes F_c of the certificate, a position, for one contact of the weights w_n = w[0] and w_t =
 * w[1]; returns the branch. With v = D r - u and the radius R = mu (w_t / w_n) v_n
 *
 *   free   F = D r                                    where v_n < 0
 *   stick  F = u                                      where |v_t| <= R
 *   slip   F_n = u_n, F_t = D r_t - R v_t / |v_t|     else
 *
 * An infinite friction sticks where v_n > 0, else it is free. */
static inline dls_contact_state dlsi_contact_misfit(int d, double mu, const double *w,
                                                    const double *r, const double *u, double *F) {
  double v[3] = {0}, Dr[3] = {0};
  for (int i = 0; i < d; i++) {
    Dr[i] = w[i > 0] * r[i];
    v[i] = Dr[i] - u[i];
    F[i] = u[i];
  }
  const int bonded = dlsi_is_bonded(mu);
  if (v[0] < 0 || (bonded && v[0] == 0)) {
    for (int i = 0; i < d; i++)
      F[i] = Dr[i];
    return DLS_FREE;
  }
  if (bonded) return DLS_STICK;
  const double t = dlsi_tangent_norm(d, v), R = d > 1 ? mu * (w[1] / w[0]) * v[0] : 0;
  if (t <= R) return DLS_STICK;
  if (d == 1) return t == 0 ? DLS_STICK : DLS_SLIP; /* slip: NaN */
  for (int i = 1; i < d; i++)
    F[i] = Dr[i] - R * (v[i] / t);
  return DLS_SLIP;
}

/* Returns the residual that a certificate with this rounding level has to meet: max(tol, 4 floor),
 * NaN for a floor of NaN, which no residual meets. */
static inline double dlsi_target(double tol, double floor) {
  return 4 * floor <= tol ? tol : 4 * floor;
}

/* Returns 1 if every part of the residual meets its target. */
static inline int dlsi_certificate_meets(const dls_certificate *c, double tol) {
  return c->residual_u <= dlsi_target(tol, c->floor_u) &&
         c->residual_r <= dlsi_target(tol, c->floor_r) &&
         c->equilibrium <= dlsi_target(tol, c->floor_e);
}

/* dls_certificate_holds and dls_certificate_verdict, inside of the library. */
int dlsi_certificate_holds(const dls_certificate *certificate, double tol);
dls_status dlsi_certificate_verdict(const dls_certificate *certificate, double tol);

/* Returns the target of the part of the certificate that `residual` is. */
static inline double dlsi_certificate_target(const dls_certificate *c, double tol) {
  return dlsi_target(tol, c->residual_r > c->residual_u ? c->floor_r : c->floor_u);
}

/* Returns the status of a solve that has ended with `reason` and the answer of this certificate.
 * That is the verdict of the certificate, if it has one and the method ended by itself; else the
 * reason, but DLS_STALLED for a DLS_OK or DLS_TO_ROUNDING that does not hold. */
dls_status dlsi_settled(const dls_certificate *c, double tol, dls_status reason);

/* Sets the three residuals. force: |D^-1/2 F'|; r: |r|. */
void dlsi_set_residuals(dls_certificate *c, double residual_u, double force, double r);

/* The ranks that share a problem (src/mpi): each has contacts and unknowns of its own. Its rows of
 * H touch contacts of its own and of others, `reach` contact rows together. What a join makes is
 * equal on all ranks to the last bit. NULL in place of it: one process. */
typedef enum dlsi_how { DLSI_SUM, DLSI_MOST, DLSI_NORM } dlsi_how; /* MOST keeps NaN */

typedef struct dlsi_ranks {
  void *data;
  void (*join)(void *data, dlsi_how how, double *x, size_t count); /* x := that of all ranks */
  void (*fetch)(void *data, double *r); /* r: reach; takes the rows of others */
  void (*give)(void *data, dlsi_how how,
               double *u); /* u: reach; joins the rows of others to them */
  int first;               /* contact of this rank, among all */
  size_t all, reach;       /* contact rows: of all ranks; as above */
  double *scratch;         /* reach */
} dlsi_ranks;

static inline void dlsi_join(const dlsi_ranks *ranks, dlsi_how how, double *x, size_t count) {
  if (ranks) ranks->join(ranks->data, how, x, count);
}

/* Returns status, or DLS_E_MEMORY if that is fine and another rank has no memory. */
static inline dls_status dlsi_joined_status(const dlsi_ranks *ranks, dls_status status,
                                            dls_error *error) {
  double fails = status < 0;
  dlsi_join(ranks, DLSI_MOST, &fails, 1);
  return fails > 0 && !status ? dlsi_no_memory(error) : status;
}

/* Returns |x| of a vector of which a rank has m entries. */
static inline double dlsi_joined_norm(const dlsi_ranks *ranks, const double *x, size_t m) {
  double norm = dlsi_norm2(x, m);
  dlsi_join(ranks, DLSI_NORM, &norm, 1);
  return norm;
}

/* Data for measuring the laws of contact and friction, m entries unless said otherwise. */
typedef struct dlsi_laws {
  int d, nc;
  const double *mu;     /* nc */
  const double *r, *u;  /* reactions; positions */
  const double *w;      /* weights: 2 nc */
  const double *a, *b;  /* a + |b| is the size of the terms in the sum u; b: NULL for 0 */
  const double *scale;  /* residual_u is relative to its norm over the contacts that touch */
  double *F;            /* receives F */
  const double *hidden; /* an F_c with entries up to these is rounding, taken as 0; or NULL */
  int shows;            /* 1: where reactions are hidden, too, floor_r has `hidden` */
  const dlsi_ranks *ranks;
} dlsi_laws;

/* Fills the residuals, floors and laws of the certificate; equilibrium 0, body -1. */
void dlsi_laws_measure(const dlsi_laws *of, dls_certificate *certificate);

/* Measures r: its certificate from u = W r + q, a = |W| |r| and the weights w (2 nc), those of
 * dlsi_certificate_weights. F: receives D^1/2 F', m. */
void dlsi_contact_measure(const dls_contact *problem, const double *r, const double *u,
                          const double *a, const double *w, double *F,
                          dls_certificate *certificate);

#endif
