/*
 * nlgs_sweep.c: one sweep of Gauss-Seidel (nlgs.c), over all contacts or some.
 *
 * u = W r + q is kept up to date by columns. For each contact c in turn:
 *
 *   (NL1)  p  = u_c - W_cc r_c                what the others leave to contact c
 *   (NL2)  s  = the solution of contact c alone, u_c = W_cc s + p            (local.c)
 *   (NL3)  s := P_Cmu( r_c + omega (s - r_c) )           only if omega is not 1
 *   (NL4)  u += W(:,c) (s - r_c),   r_c := s             only if s is not r_c
 *
 * (NL0) A contact with r_c = 0 and u_n >= 0 stays free: (NL1)-(NL4) would change nothing. (NL3)
 * projects orthogonally on the cone; for omega <= 1 this changes nothing, because the cone is
 * convex. If omega < 1, the r_c of a contact that has opened becomes exactly 0 once it is too small
 * to move u.
 *
 * W dense: one pass over the columns of four contacts adds their changes to u (products.c). A
 * contact that is visited before that pass adds the outstanding changes to its own rows. Every u_i
 * receives the changes in the order of the contacts: the bits are those of one by one.
 *
 * Of rigid bodies, W = H^T H, a sweep updates v = H r in place of u:
 *
 *   (NL11) u_c = q_c + H_c^T v in (NL1);  v += H_c (s - r_c) in (NL4); u of all contacts is
 *          computed for the estimate only
 *
 * From 500 contacts on, W by blocks and bodies are swept in groups of eight (groups.c), on one
 * thread or more. On several threads a dense W is applied by rows, to the bits of one thread.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "nlgs_work.h"

enum { batch_size = 4 };

/* W dense: changes of r that are not yet in u; one pass adds them to all rows. */
typedef struct nlgs_batch {
  int count, c[batch_size];
  int normal; /* 1: normals alone change, so that W's columns of tangents are not read */
  double dr[3 * batch_size];
} nlgs_batch;

/* v := u_c with the changes of the batch. b is NULL for W by blocks. */
static inline void nlgs_look(int d, const dls_contact *problem, const nlgs_batch *b, int c,
                             const double *u, double *v) {
  const size_t D = (size_t)d, ld = (size_t)problem->W.ld, row = D * (size_t)c;
  for (size_t i = 0; i < D; i++)
    v[i] = u[row + i];
  for (int k = 0; b && k < b->count; k++) {
    const double *w = problem->W.a + row + D * (size_t)b->c[k] * ld, *dr = b->dr + d * k;
    for (size_t i = 0; i < D; i++) {
      double sum = w[i] * dr[0];
      for (size_t j = 1; j < D; j++)
        sum += w[i + j * ld] * dr[j];
      v[i] += sum;
    }
  }
}

/* Adds E_c dr to u_c. */
static inline void nlgs_add_springs(const dls_nlgs *work, int d, int c, const double *dr) {
  double *uc = work->it.u + (size_t)d * (size_t)c;
  for (int i = 0; work->it.E && i < d; i++)
    uc[i] += work->it.E[c] * dr[i];
}

/* A batch and the rows of u that one thread adds it to. */
typedef struct nlgs_panel {
  const dls_nlgs *work;
  const dls_contact *problem;
  const nlgs_batch *b;
  int pieces;
} nlgs_panel;

static void nlgs_add_rows(void *data, int piece) {
  const nlgs_panel *s = data;
  const int first = dlsi_piece(s->problem->nc, s->pieces, piece);
  const size_t row = (size_t)s->problem->d * (size_t)first;
  dls_contact part = *s->problem;
  part.nc = dlsi_piece(s->problem->nc, s->pieces, piece + 1) - first;
  part.W.a += row;
  dlsi_contact_add_panel(&part, s->b->count, s->b->c, s->b->dr, s->work->it.u + row);
}

static void nlgs_flush(const dls_nlgs *work, const dls_contact *problem, nlgs_batch *b) {
  if (work->team && b->count) {
    nlgs_panel s = {work, problem, b, work->settings.limits.threads};
    dlsi_parallel(work->team, s.pieces, nlgs_add_rows, &s);
  } else
    dlsi_contact_add_panel(problem, b->count, b->c, b->dr, work->it.u);
  for (int k = 0; k < b->count; k++)
    nlgs_add_springs(work, problem->d, b->c[k], b->dr + problem->d * k);
  b->count = 0;
}

/* (NL4) for one contact: into the batch, or at once (b NULL, W by blocks). With springs the batch
 * is flushed at once, since E_c comes after W_cc. */
static inline void nlgs_change(const dls_nlgs *work, const dls_contact *problem, int c,
                               const double *dr, nlgs_batch *b) {
  const size_t d = (size_t)problem->d;
  if (b) {
    const int normal = d < 2 || (dr[1] == 0 && (d < 3 || dr[2] == 0));
    if (b->count && normal != b->normal) nlgs_flush(work, problem, b); /* half of the columns */
    b->normal = normal;
    memcpy(b->dr + d * (size_t)b->count, dr, d * sizeof *dr);
    b->c[b->count++] = c;
    if (b->count == batch_size || work->it.E) nlgs_flush(work, problem, b);
    return;
  }
  dlsi_contact_add_columns(problem, c, dr, work->it.u);
  nlgs_add_springs(work, problem->d, c, dr);
}

/* (NL0)-(NL4) for the contacts of a set, inlined for constants d and n, motions of a body or 0.
 * Returns how many changed. */
static DLSI_INLINE int nlgs_visit(const int d, const int n, const dls_nlgs *work,
                                  const dls_contact *problem, dlsi_set set, nlgs_batch *b,
                                  double *r) {
  const double omega = work->settings.relaxation;
  int changed = 0;
  for (int k = 0; k < set.count; k++) {
    const int c = set.list ? set.list[k] : k;
    double *rc = r + (size_t)d * (size_t)c, uc[3] = {0}, p[3] = {0}, s[3] = {0}, v[3], dr[3];
    const double *W = d == 1   ? work->block_1d + c
                      : d == 2 ? work->block_2d[c].W
                               : work->block_3d[c].W;
    dlsi_pair_of_bodies of;
    if (n) {
      of = dlsi_bodies_of(&problem->bodies, (size_t)d * (size_t)n, (size_t)c, work->v);
      dlsi_bodies_look(d, n, &of, problem->q + (size_t)d * (size_t)c, uc);
    } else
      nlgs_look(d, problem, b, c, work->it.u, uc);
    if (uc[0] >= 0 && dlsi_is_zero(d, rc)) continue; /* (NL0) */
    for (int i = 0; i < d; i++) {                    /* (NL1) */
      double sum = W[i] * rc[0];
      for (int j = 1; j < d; j++)
        sum += W[i + d * j] * rc[j];
      p[i] = uc[i] - sum;
    }
    dlsi_local_state state; /* (NL2) */
    if (d == 1)
      state = dlsi_local_1d(*W, p, s);
    else if (d == 2)
      state = dlsi_local_2d(work->block_2d + c, p, s);
    else { /* u_t = -guess r_t; NaN for none */
      const double guess = -(uc[1] * rc[1] + uc[2] * rc[2]) / (rc[1] * rc[1] + rc[2] * rc[2]);
      state = dlsi_local_3d(work->block_3d + c, p, guess, s);
    }
    if (omega != 1) { /* (NL3) */
      for (int i = 0; i < d; i++)
        v[i] = rc[i] + omega * (s[i] - rc[i]);
      if (state != DLS_LOCAL_FREE || work->it.w[c] * v[0] > DBL_EPSILON * p[0])
        dlsi_project_cone(d, problem->mu[c], v, s);
    }
    int moves = 0;
    for (int i = 0; i < d; i++) {
      dr[i] = s[i] - rc[i];
      moves |= dr[i] != 0;
    }
    if (!moves) continue;
    if (n) /* (NL4) */
      dlsi_bodies_push(d, n, &of, dr);
    else
      nlgs_change(work, problem, c, dr, b);
    for (int i = 0; i < d; i++)
      rc[i] = s[i];
    changed++;
  }
  return changed;
}

/* One sweep over a list; returns how many contacts changed. */
static int nlgs_sweep_list(const dls_nlgs *work, const dls_contact *problem, dlsi_set set,
                           double *r) {
  if (work->motions)
    return problem->d == 3      ? nlgs_visit(3, 6, work, problem, set, NULL, r)
           : problem->d == 2    ? nlgs_visit(2, 3, work, problem, set, NULL, r)
           : work->motions == 3 ? nlgs_visit(1, 3, work, problem, set, NULL, r)
                                : nlgs_visit(1, 6, work, problem, set, NULL, r);
  nlgs_batch dense = {0}, *b = problem->Wb.x ? NULL : &dense;
  const int changed = problem->d == 1   ? nlgs_visit(1, 0, work, problem, set, b, r)
                      : problem->d == 2 ? nlgs_visit(2, 0, work, problem, set, b, r)
                                        : nlgs_visit(3, 0, work, problem, set, b, r);
  if (b) nlgs_flush(work, problem, b);
  return changed;
}

/* One sweep over a set; returns 0 if no contact changed. */
int dlsi_nlgs_sweep(const dls_nlgs *work, const dls_contact *problem, dlsi_set set, double *r) {
  if (set.groups) return dlsi_groups_sweep(set.groups, work->team, r, work->v);
  return nlgs_sweep_list(work, problem, set, r);
}

/* ---- back on the cones ----------------------------------------------------------------------- */

/* dr := P_Cmu(rc) - rc. Returns 0 if that is only rounding, as for most r_c that slip. */
static inline int nlgs_lack(int d, double mu, const double *rc, double *dr) {
  double p[3] = {0}, size = 0, moved = 0;
  if (dlsi_project_cone(d, mu, rc, p) == DLS_STICK) return 0;
  for (int i = 0; i < d; i++) {
    dr[i] = p[i] - rc[i];
    size += fabs(rc[i]);
    moved += fabs(dr[i]);
  }
  return !(moved <= 8 * DBL_EPSILON * size);
}

/* Projects every r_c on its cone, u by columns, v of bodies. */
void dlsi_nlgs_repair(const dls_nlgs *work, const dls_contact *problem, double *r) {
  const int d = problem->d, n = work->motions;
  nlgs_batch dense = {0}, *b = problem->W.a ? &dense : NULL;
  for (int k = 0; k < problem->nc; k++) {
    const int c = work->order ? work->order[k] : k;
    double *rc = r + (size_t)d * (size_t)c, dr[3] = {0};
    if (!nlgs_lack(d, problem->mu[c], rc, dr)) continue;
    if (n) {
      const dlsi_pair_of_bodies of =
          dlsi_bodies_of(&problem->bodies, (size_t)d * (size_t)n, (size_t)c, work->v);
      dlsi_bodies_push(d, n, &of, dr);
    } else if (!work->grouped)
      nlgs_change(work, problem, c, dr, b);
    for (int i = 0; i < d; i++)
      rc[i] += dr[i];
  }
  if (b) nlgs_flush(work, problem, b);
}
