/*
 * delassus/contact.h: the discrete contact problem with dry friction, and its certificate.
 *
 *   nc candidates to contact in dimension d = 2 or 3; candidate c owns entries d c .. d c + d-1 of
 *   every local vector, in the order (n, t) or (n, t, s). m = d nc. d = 1: normals alone, without
 *   friction, in a space of any dimension; W = W_nn and the problem is LCP(W_nn, q_n).
 *
 *     u = W r + q                                              [Jean 1988] (3.3)5-6
 *     0 <= u_n  _|_  r_n >= 0                                                (2.1)1
 *     |r_t| <= mu r_n,  u_t = -alpha r_t with alpha >= 0,
 *                       u_t = 0 where |r_t| < mu r_n           [Chabrand 1998] (21)
 *
 *   r  reactions of the obstacle on the body   force (impulse in dynamics)
 *   u  local relative positions                length (velocity)
 *   W  Delassus (influence) matrix, m x m      length / force; need not be symmetric
 *   q  local positions at r = 0                length (velocity)
 *   mu friction coefficients >= 0, nc          none
 *      INFINITY: bonded in the tangents, u_t = 0 while r_n > 0, and r = 0 else. nlgs, newton, admm,
 *      augmented-lagrangian, penalty and auto take it; an LCP, the homotopy and FCLIB files do not,
 *      nor what lists all solutions or looks for the fold
 *      (DLS_E_UNSUPPORTED, in files DLS_E_NOT_FINITE). There may be no solution where a bonded
 *      candidate would have to pull.
 */
#ifndef DELASSUS_CONTACT_H
#define DELASSUS_CONTACT_H

#include "delassus/matrix.h"

#ifdef __cplusplus
extern "C" {
#endif

/* W of rigid bodies, kept factorised. Candidate c presses with r_c on two bodies, and moves each by
 * M^-1/2 H_c r_c, M its mass matrix (any factor of M^-1 does in place of M^-1/2):
 *
 *   W_ck = sum over the bodies that c and k share of  H_c^T H_k,   H here with M^-1/2 in it
 *
 * symmetric and positive semidefinite. The cost of a sweep then grows with the motions of a body,
 * not with the neighbours of a contact, and the memory is a third. */
typedef struct dls_bodies {
  int n;           /* motions of a body: 3 (d - 1); d = 1: 3 or 6 */
  int count;       /* bodies, >= 0 */
  const int *body; /* 2 nc: body[2 c] and body[2 c + 1] of candidate c, 0 .. count-1, not the same;
                      -1: fixed */
  const double *H; /* 2 n d nc: block k of n x d, column-major at H + n d k, belongs to body[k]; of
                      a fixed body it is not read; its squares do not overflow. 1 / sqrt(mass) */
  double *work;    /* NULL; in copies of the view that the library makes, its own scratch */
} dls_bodies;

/* The problem: a view; all arrays are borrowed. W is dense, by blocks, or of rigid bodies: leave
 * the other two zero. */
typedef struct dls_contact {
  int d;                 /* 1, 2 or 3 */
  int nc;                /* number of candidates, >= 0; W, q, mu are not read where it is 0 */
  dls_dense W;           /* m x m; W.a = NULL where it is not used */
  dls_blocks Wb;         /* nc x nc blocks of d x d; Wb.x = NULL where it is not used */
  const double *q;       /* m */
  const double *mu;      /* nc; all 0 where d = 1 */
  dls_bodies bodies;     /* bodies.H = NULL where it is not used */
  const double *weights; /* 2 nc: w_n and w_t of each contact for the certificate, > 0, length /
                            force; NULL: from the diagonal blocks of W */
} dls_contact;

/* Checks sizes, pointers, finite values, mu >= 0, block structure; O(size of W). Every function
 * that takes a dls_contact runs this check first. DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_NOT_FINITE,
 * each naming the field ("W", "Wb.i", "q", "mu", ...) and the index: position i + j*ld in W, plain
 * position elsewhere. */
DLS_API DLS_MUST_USE dls_status dls_contact_check(const dls_contact *problem, dls_error *error);

/* Counts the blocks of W of a problem of bodies: the value of limits.blocks for the methods that
 * form W by blocks, and the size of the arrays below. Errors of dls_contact_check; DLS_E_ARGUMENT
 * for another storage, DLS_E_SIZE for more than INT_MAX blocks, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_bodies_count(const dls_contact *problem, int *count,
                                                 dls_error *error);

/* Forms W of a problem of bodies by blocks in p (nc + 1), i (count) and x (d d count), block rows
 * increasing, which the caller owns, and sets *B to a view of them. Errors of dls_bodies_count. */
DLS_API DLS_MUST_USE dls_status dls_blocks_from_bodies(const dls_contact *problem, int *p, int *i,
                                                       double *x, dls_blocks *B, dls_error *error);

/* Makes a problem of some candidates of another one: reduce all candidates once, then solve in each
 * step for those that may touch. r and u of candidate k of the subset belong to candidate[k]; r of
 * the others is 0.
 *
 *   candidate  count of them, ascending, each from 0 to nc - 1; NULL for count = 0
 *   values     memory of W, q, mu of the subset: for a dense W (d count)^2 + (d + 1) count doubles,
 *              by blocks d d Wb.p[nc] + (d + 1) count (fewer are used where blocks drop out), of
 *              bodies (2 n d + d + 1) count; 2 count more where there are weights
 *   index      memory of Wb.p, Wb.i of the subset: count + 1 + Wb.p[nc]; of bodies.body: 2 count;
 *              dense: not used, NULL
 *   subset     view of values and index, of the storage that the problem has
 *
 * The arrays are the caller's, must not overlap the problem, and live as long as the subset is
 * used; arrays for all candidates serve every subset. DLS_E_SIZE (count), DLS_E_ARGUMENT
 * (candidate, with its index). */
DLS_API DLS_MUST_USE dls_status dls_contact_subset(const dls_contact *problem, int count,
                                                   const int *candidate, double *values, int *index,
                                                   dls_contact *subset, dls_error *error);

/* The state of a candidate; d = 1: free or, where it carries a reaction, stick. */
typedef enum dls_contact_state { DLS_FREE = 0, DLS_SLIP = 1, DLS_STICK = 2 } dls_contact_state;

/* The certificate of r, one measure for every method. Each contact has two weights w_n, w_t > 0,
 * length / force: those of `weights`, else W_nn and trace(W_tt) / (d-1) of its diagonal block
 * (where one is not positive, the mean of the positive ones of its kind). D_c = diag(w_n, w_t, ..),
 * u = W r + q recomputed, v = D r - u, and the radius R = mu (w_t / w_n) max(0, v_n):
 *
 *   F_n = w_n r_n - max(0, v_n),  F_t = D r_t - (v_t, at most R long); F = D r where v_n < 0
 *   residual_u = sqrt( sum_c |F_c|^2 ) / |q|             of positions
 *   residual_r = sqrt( sum_c |D^-1 F_c|^2 ) / |r|        of forces
 *
 * F = 0 where the laws hold (Alart and Curnier 1991). |q| and |r| are taken over the contacts that
 * touch, v_n >= 0. Open contacts, at any distance, affect no scale and no rounding level. Both
 * residuals are needed: with |q| alone the reactions of a stiff support beside a soft one can be
 * wrong by percents at 1e-8; |r| alone would accept wrong positions under large forces. Both are
 * without unit, and do not change under r -> b r, (u,q) -> a u, W -> a/b W, another order of the
 * contacts, or (d = 3) another tangent frame.
 *
 * The rounding level is the residual that double precision leaves: floor_u = eps |e| / |q|,
 * floor_r = eps |D^-1 e| / |r|. With a = |W||r| + |q| by entries, e is
 *
 *   free   0
 *   stick  a
 *   slip   e_n = a_n,  e_t = w_t |r_t| + mu (w_t / w_n) (a_n + w_n r_n)
 *          and, d = 3, w_t |r_t| |a_t| / |v_t| more in e_t
 *   stick that 4 eps (a_n + w_n r_n) in u_n would turn into slip: a, and in e_t
 *          mu (w_t / w_n) (a_n + w_n r_n) more
 *
 * Where |q| = 0, | |W||r| | takes its place. Where |D^-1 F| is above |r|, as it is for r = 0 and F
 * not 0, it takes the place of |r|: residual_r is at most 1. All are 0 for r = 0 if F = 0.
 *
 * The other fields are in your units; each is >= 0 and the largest value over the contacts.
 * cone_violation to complementarity leave out a contact whose D r is at most 4 eps of the largest
 * entry of a_c, that is, rounding. */
typedef struct dls_certificate {
  double residual;        /* max(residual_u, residual_r, equilibrium)  1 */
  double residual_u;      /* of positions                              1 */
  double residual_r;      /* of forces                                 1 */
  double floor_u;         /* of positions                              1 */
  double floor_r;         /* of forces                                 1 */
  double penetration;     /* max(0, -u_n)                              length (velocity) */
  double adhesion;        /* max(0, -r_n)                              force */
  double cone_violation;  /* max(0, |r_t| - mu r_n)                    force */
  double slip_direction;  /* |u_t + |u_t| r_t/|r_t||, or |u_t| where r_t = 0 and mu r_n > 0, of
                             candidates with w r_n > u_n, the closed ones: slip that friction does
                             not oppose                                length (velocity) */
  double complementarity; /* |u_n r_n|                                 work */
  int worst;              /* candidate with the largest |F_c| */
  double equilibrium;     /* of the body and its joints, dls_reduction_certify; 0 where K is not
                             known                                     1 */
  double floor_e;         /* of equilibrium                            1 */
  double unbalanced;      /* |K x - f - H r| of that connected body; 0 where its joints have the
                             largest equilibrium part                  force */
  int body;               /* connected body with the largest equilibrium part; joints connect; -1:
                             none */
} dls_certificate;

/* Measures r for this problem, from the user's W, q, mu alone. Allocates 4 m doubles, for bodies
 * 2 n count besides. r: m, finite.
 * u: receives W r + q, m; or NULL. Returns DLS_OK also for a bad r, or an error. */
DLS_API DLS_MUST_USE dls_status dls_contact_certify(const dls_contact *problem, const double *r,
                                                    double *u, dls_certificate *certificate,
                                                    dls_error *error);

/* Returns 1 if each part of the residual is at most max(tol, 4 floor) with its own floor, and
 * 4 floor <= max(tol, 1e-8) for all of them; NaN gives 0. A larger floor means that r is so large
 * (for example in the null space of W) that rounding hides u and q in the residual. */
DLS_API int dls_certificate_holds(const dls_certificate *certificate, double tol);

/* Returns DLS_OK if the certificate holds; DLS_TO_ROUNDING if it fails only because a floor lies
 * between max(tol, 1e-8) and 1e-4: double precision cannot improve such an answer, whose positions
 * are right to about 4 floor_u and forces to 4 floor_r; else DLS_STALLED. */
DLS_API dls_status dls_certificate_verdict(const dls_certificate *certificate, double tol);

/* Returns the state of every contact, by the branch of F_c: free if v_n < 0, stick if |v_t| <= R,
 * slip otherwise.
 * u: W r + q as dls_contact_certify gives it, m. state: nc. */
DLS_API DLS_MUST_USE dls_status dls_contact_states(const dls_contact *problem, const double *r,
                                                   const double *u, dls_contact_state *state,
                                                   dls_error *error);

/* Computes |F_c| of each contact, which shows where an answer is wrong: residual_u is the root of
 * the sum of their squares, over |q| of the contacts that touch. u: as above. misfit: nc; length
 * (velocity) */
DLS_API DLS_MUST_USE dls_status dls_contact_misfits(const dls_contact *problem, const double *r,
                                                    const double *u, double *misfit,
                                                    dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
