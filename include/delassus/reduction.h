/*
 * delassus/reduction.h: from the host's model to the contact problem, and back.
 *
 *   K x = f + H r,   u = H^T x + g
 *   W = H^T K^-1 H,  q = H^T K^-1 f + g,   u = W r + q        [Jean 1988] (3.3)1-6
 *
 *   x  unknowns of the host (displacements or velocities), n    length (velocity)
 *   f  loads on them, n                                         force (impulse)
 *   K  stiffness (mass, or tangent), n x n, regular             force / length
 *   H  = (H_N, H_T): column c of H_N, and columns (d-1) c .. of H_T, give the normal and the
 *      tangents of contact node c
 *      settings.frictionless: H = H_N, and m, r, u, q are those of d = 1; g and R keep d per node
 *      nodes = 0 (HN, HT are not read then), or none active: W and q are empty, x = K^-1 f
 *   g  initial gap, or the motion of the obstacle with the sign of a gap, d per contact node in
 *      local order ([J] Y_0; gap / h + velocity in dynamics)    length (velocity)
 *
 * Weighted reactions, [J] 4.4: H = L P with L the nodal operator (L_N, L_T) that the host gives and
 * P (contact nodes x candidates) the weighting; without P, candidates are the contact nodes.
 * Unknowns are then the weighted reactions of dimension force (the paper's M r); P r are the
 * equivalent nodal reactions, and u = P^T (L^T x + g).
 */
#ifndef DELASSUS_REDUCTION_H
#define DELASSUS_REDUCTION_H

#include "delassus/contact.h"
#include "delassus/limits.h"
#include "delassus/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The matrix on which the contact problem is solved. */
typedef enum dls_on {
  DLS_ON_EITHER, /* dls_reduction_create chooses; dls_reduction_estimate: W */
  DLS_ON_W,      /* the Delassus matrix, m x m and dense: few contacts, many loads, any method */
  DLS_ON_K       /* the stiffness (global.h): contact over whole surfaces, bodies that contact alone
                    holds; by dls_reduction_solve with method auto */
} dls_on;

typedef struct dls_reduction_settings {
  size_t size;          /* set by init; settings without it are refused */
  dls_on on;            /* DLS_ON_EITHER */
  int loads;            /* expected number of solves with one K, for the choice of W or K; 1 */
  double memory_limit;  /* bytes; a larger estimate is DLS_E_MEMORY; 0: no limit; 0 */
  int allow_indefinite; /* 1: factorises an indefinite K tagged DLS_CHOLESKY as DLS_LDLT; 0: that is
                           an error; 0 */
  int form_W;        /* 0: q and x only, for methods that work on K: DLS_ON_EITHER is W then; 1 */
  int frictionless;  /* 1: condenses H_N alone. The contact problem has d = 1: one entry of r, u and
                       q per contact, 1/4 (2D) or 1/9 (3D) of W's memory. HT is checked, not used;
                       model.mu must be 0 or NULL (DLS_E_ARGUMENT); 0 */
  int surface_count; /* unknowns in surface; 0 */
  const int *surface; /* unknowns that H of dls_reduction_move may touch, besides those that H of
                         create touches; read by create only; NULL */
  dls_progress_fn progress; /* called in create and update, about every millisecond. dls_progress
                               has method "reduction"; stage "analysis", "factor" or "W";
                               iteration of max_iterations pieces (0: unknown); residual -1, r NULL.
                               A value other than 0 cancels: DLS_CANCELLED, after the running call
                               of METIS, MUMPS or LAPACK's LU. NULL for none; NULL */
  void *progress_data;      /* must live while create or update runs */
} dls_reduction_settings;

/* Sets each field to its default. */
DLS_API void dls_reduction_settings_init(dls_reduction_settings *settings);

/* Cost of a reduction, estimated or measured. */
typedef struct dls_reduction_info {
  dls_on on;           /* DLS_ON_W; DLS_ON_K: the fields from condensed on are 0, because the
                          reduction does not factorise K */
  int contacts;        /* contacts of the contact problem */
  int condensed;       /* unknowns of the dense Schur complement; 0: there is none */
  double W_bytes;      /* m^2 doubles */
  double factor_bytes; /* of K's factor and the Schur complement */
  double bytes;        /* largest memory in use during create */
  double flops;        /* of the factorisation and of S^-1, from the analysis */
  double condition;    /* estimate for K scaled; 0 before the work, or if K is not factorised */
  int indefinite;      /* K was tagged DLS_CHOLESKY and is not positive definite */
  int joints;          /* multipliers among the unknowns (model.h) */
  int redundant;       /* joints that follow from others; their multipliers are 0 */
} dls_reduction_info;

/* Estimates the cost of dls_reduction_create on W. For a sparse K it orders and analyses the
 * matrix, which is a few per cent of the work in 3D, and up to half of it in 2D. settings NULL for
 * the defaults; memory_limit is not applied. Errors of dls_reduction_create. */
DLS_API DLS_MUST_USE dls_status dls_reduction_estimate(const dls_model *model,
                                                       const dls_reduction_settings *settings,
                                                       dls_reduction_info *info, dls_error *error);

typedef struct dls_reduction dls_reduction;

/* Creates a reduction: on W it factorises K and forms W, on K it copies K and H. settings NULL for
 * the defaults. settings.on DLS_ON_EITHER chooses:
 *
 *   W   K is not known (flexibility, host's solver), or form_W is 0
 *   K   K is singular, or W would exceed settings.memory_limit
 *   W   d * (contacts) <= 100, or settings.surface is given
 *   otherwise the one with the lower estimated cost of settings.loads solves
 *
 * dls_reduction_get_info returns the choice. dls_reduction_solve works on both; so do load,
 * load_free, certify, judge, states, nodal, update. dls_reduction_contact and dls_reduction_recover
 * need W, and return DLS_E_UNSUPPORTED on K: set settings.on to DLS_ON_W for them.
 *
 * W is exactly symmetric with DLS_CHOLESKY and DLS_LDLT. Threads wait for one another in METIS and
 * MUMPS. Memory on W in doubles, with m = d * (active contacts), or the active contacts if
 * frictionless:
 *
 *   W                                   m^2
 *   K^-1, dense K                       n^2
 *   K^-1, sparse K of small parts       sum of the squares of their sizes
 *   factor, other sparse K              the sparse factor, and b^2 for the Schur complement on the
 *                                       b unknowns that H touches; without b^2 if b is more than
 *                                       four times the columns of H
 *   while forming W                     128 n or b^2 more at most
 *
 * Errors, with *out = NULL; the first only with DLS_ON_W:
 *
 *   DLS_E_SINGULAR               condition above 4e14 after scaling rows and columns, independent
 *                                of units: a body is free to move. Names K or Ks; index is an
 *                                unknown where it shows, or -1
 *   DLS_E_NOT_POSITIVE_DEFINITE  index: unknown of a pivot <= 0, value: that pivot of the scaled
 *                                matrix; or index -1 and value the number of negative pivots
 *   DLS_E_NOT_FINITE             overflow in "W", or entries of Ks that add up to Inf
 *   DLS_E_MEMORY                 with the figures
 *
 * DLS_E_UNSUPPORTED, DLS_E_CALLBACK, DLS_E_SIZE, DLS_E_SETTINGS, and those of dls_model_check.
 * DLS_CANCELLED, which is not negative, if settings.progress cancels: *out = NULL then, too. */
DLS_API DLS_MUST_USE dls_status dls_reduction_create(dls_reduction **out, const dls_model *model,
                                                     const dls_reduction_settings *settings,
                                                     dls_error *error);

/* Takes new values of K, H, P on the pattern of create and forms W again. The analysis and the
 * memory are reused, views (dls_reduction_contact) stay valid, f and q become 0. The choice of W or
 * K stays that of create.
 *
 *   DLS_E_SIZE, DLS_E_ARGUMENT   another size or pattern; the reduction is unchanged
 *   errors of dls_model_check    the reduction is unchanged
 *   other errors, DLS_CANCELLED  the reduction is empty: all functions but update and destroy
 *                                return DLS_E_ARGUMENT */
DLS_API DLS_MUST_USE dls_status dls_reduction_update(dls_reduction *reduction,
                                                     const dls_model *model, dls_error *error);

/* Takes new contacts on the K of create: contact that moves over the surface of a body. Reads d, n,
 * nodes, HN, HT, P, active and mu of the model, any number of contacts; f stays, g (d nodes, or
 * NULL for 0) is new. K is neither read nor factorised again:
 *
 *   sparse K   H may touch settings.surface and what H of create touches: b unknowns. Without
 *              settings.surface the first call takes 2 b^3 operations; others b for each entry of H
 *   other K    any H; a solve for each of its columns, and one for f. So do a sparse K of small
 *              parts, and one without a Schur complement (info.condensed = 0)
 *   on K       any H; the next solve analyses K + H R H^T anew
 *
 * Views of dls_reduction_contact end. create with nodes = 0 and settings.surface condenses a body
 * before it has any contact. After an error, or DLS_CANCELLED, the reduction is unchanged.
 *
 *   DLS_E_ARGUMENT   "HN": an unknown that is not on the surface, or is the multiplier of a joint
 *   DLS_E_SIZE       another d or n
 *   and those of dls_reduction_create for H, P, mu, g, W */
DLS_API DLS_MUST_USE dls_status dls_reduction_move(dls_reduction *reduction, const dls_model *model,
                                                   const double *g, dls_error *error);

/* Returns the cost of the reduction and where it solves. DLS_E_ARGUMENT. */
DLS_API DLS_MUST_USE dls_status dls_reduction_get_info(const dls_reduction *reduction,
                                                       dls_reduction_info *info, dls_error *error);

/* Sets the loads and gaps: q := H^T K^-1 f + P^T g. f (n) or NULL for 0; g (d * nodes) or NULL for
 * 0. Before the first call f and q are 0; an error leaves both unchanged. Takes one solve, or half
 * of one with a Schur complement. Allocates nothing (MUMPS does). */
DLS_API DLS_MUST_USE dls_status dls_reduction_load(dls_reduction *reduction, const double *f,
                                                   const double *g, dls_error *error);

/* Sets the free displacement or velocity x_free (n) = K^-1 f, which you have computed, in place of
 * f: q := H^T x_free + P^T g. dls_reduction_recover then returns x_free + K^-1 H r. g as in
 * dls_reduction_load. No solve, no allocation. */
DLS_API DLS_MUST_USE dls_status dls_reduction_load_free(dls_reduction *reduction,
                                                        const double *x_free, const double *g,
                                                        dls_error *error);

/* Returns the contact problem of the active contacts with the friction mu (one for each of them;
 * borrowed; NULL for those of the model). W and q belong to the reduction and live as long as it
 * does; q changes with dls_reduction_load. For a contact without tangents their rows and columns of
 * W and q are 0, and mu must be 0 (DLS_E_ARGUMENT). DLS_E_UNSUPPORTED without W. */
DLS_API DLS_MUST_USE dls_status dls_reduction_contact(const dls_reduction *reduction,
                                                      const double *mu, dls_contact *problem,
                                                      dls_error *error);

/* Recovers x := K^-1 (f + H r), n, with f as last given to dls_reduction_load (copied there), or
 * x_free + K^-1 H r. r (m). Takes one solve. With a Schur complement, load and recover together
 * take one solve; with MUMPS that holds for the first recover after a load. Allocates nothing
 * (MUMPS does). */
DLS_API DLS_MUST_USE dls_status dls_reduction_recover(dls_reduction *reduction, const double *r,
                                                      double *x, dls_error *error);

/* Certifies the pair (x, r) for the body, with f and g as last loaded. Positions and forces as in
 * contact.h, but
 *
 *   u = H^T x + g            from x, not W r + q; or NULL, else m: receives it
 *   weights                  the compliance of the contact node with its neighbours held, from K
 *   |q|                      sqrt( |H^T x|^2 + |g|^2 + |D r|^2 ) of the contacts that touch
 *   equilibrium              max over connected bodies of |K x - f - H r| over
 *                            |H||r| + min(|f|, 100 |H||r|); with joints, for each body separately
 *                            over |f| + |H||r| + |G l|, and for the joints |G^T x - b| over lengths
 *
 * If that is above 1e-8 only because loads balance in themselves (heat, pressure, bolts,
 * penalties), or if the rounding level is, x and f are taken without the body's own deformation
 * x_own (docs/certificate.md): K y = f' + H r, y = x - x_own, u = H^T y + g'. This needs a factor
 * of K with weak contacts, which is kept.
 *
 * mu as in dls_reduction_contact. If K is a flexibility or a host's solver, equilibrium is 0 and
 * the weights are those of W. dls_certificate_verdict judges all three parts. O(entries of K and
 * H), or a factor. Errors of dls_reduction_recover, and DLS_E_MEMORY, DLS_E_SINGULAR. */
DLS_API DLS_MUST_USE dls_status dls_reduction_certify(dls_reduction *reduction, const double *mu,
                                                      const double *r, const double *x, double *u,
                                                      dls_certificate *certificate,
                                                      dls_error *error);

/* Returns the state of each contact, as dls_contact_states, from r and u = H^T x + g with the
 * weights of K. mu as in dls_reduction_contact; r, u (m); state (candidates). Errors of
 * dls_reduction_certify. */
DLS_API DLS_MUST_USE dls_status dls_reduction_states(dls_reduction *reduction, const double *mu,
                                                     const double *r, const double *u,
                                                     dls_contact_state *state, dls_error *error);

/* Computes the nodal reactions R := P r (d * nodes, local order) of r (m); R = r without P. R and r
 * must not overlap. */
DLS_API DLS_MUST_USE dls_status dls_reduction_nodal(const dls_reduction *reduction, const double *r,
                                                    double *R, dls_error *error);

/* Frees the reduction; NULL is fine. */
DLS_API void dls_reduction_destroy(dls_reduction *reduction);

/* Computes the weighting P of a contact line, [J] 4.4 example 2. Column j distributes the reaction
 * of contact j, constant on its dual cell (half way to its neighbours), by the integrals of the
 * nodes' hat functions over that cell divided by its length.
 *
 *   nodes      number of nodes of the line, in order, >= 2
 *   s          their abscissae along the line, strictly increasing, nodes      length
 *   candidate  candidate[i] != 0: node i is a candidate; 0: it is not (fixed, say), nodes. NULL:
 *              all. A surface ends at the first and last node, candidates or not.
 *   p, i, x    the columns of P (nodes x candidates), compressed; room for
 *              nodes + 1, 3 nodes, 3 nodes
 *   length     measure of each dual cell (the paper's M), candidates; or NULL   length
 *   columns    receives the number of candidates
 *
 * Columns add up to 1: the resultant is kept. Inside, (1/4) a/(a+b), 3/4, (1/4) b/(a+b) for the
 * segments a, b beside the node ((1/8, 3/4, 1/8) if equal); at an end (3/4, 1/4). Rows ascend in
 * each column. A neighbour that is no candidate keeps its row of P: its node takes part in the
 * reduction. DLS_E_ARGUMENT (no candidate at all, s not increasing: index), DLS_E_SIZE,
 * DLS_E_NOT_FINITE. */
DLS_API DLS_MUST_USE dls_status dls_weighting_line(int nodes, const double *s, const int *candidate,
                                                   int *p, int *i, double *x, double *length,
                                                   int *columns, dls_error *error);

/* Computes P of a line of quadratic edges: nodes 0, 2, .. are corners, nodes 1, 3, .. lie in the
 * middle of their edges. As dls_weighting_line, with an odd number of nodes and room for nodes + 1,
 * 4 nodes, 4 nodes in p, i, x. The cell of a corner reaches a quarter into its edges, that of a
 * middle node covers half of its edge.
 *
 * Columns of equal edges: corner (-1/24, 5/24, 2/3, 5/24, -1/24), middle (1/24, 11/12, 1/24); they
 * add up to 1. Nodal reactions P r of densities r >= 0 may pull at corners; the laws hold in the
 * mean over the cells all the same, and P^T W P is definite where W is. DLS_E_ARGUMENT, also for a
 * middle node off the middle by more than 1e-6 of its edge (index). */
DLS_API DLS_MUST_USE dls_status dls_weighting_quadratic(int nodes, const double *s,
                                                        const int *candidate, int *p, int *i,
                                                        double *x, double *length, int *columns,
                                                        dls_error *error);

/* Computes P of a rectangular grid of faces in 3D: the Kronecker product of the P of two lines, and
 * a cell the product of two cells.
 *
 *   order        1: four-node faces, dls_weighting_line; 2: nine-node ones, dls_weighting_quadratic
 *   nodes_s, nodes_t   nodes of the lines; 1 for a strip of width 1: its P is 1
 *   s, t         abscissae of the lines, nodes_s, nodes_t          length
 *   candidate_s, candidate_t   as for a line: candidates are the products of candidates. NULL: all
 *   p, i, x      the columns of P, compressed; node (a, b) is a + b nodes_s, and candidates go
 *                in the same way. Room for N + 1, 16 N, 16 N; of order 1 for N + 1, 9 N, 9 N, N =
 *                nodes_s nodes_t
 *   area         measure of each cell, candidates; or NULL         length^2
 *   columns      receives the number of candidates
 *
 * The errors of the lines; candidate_s is named before candidate_t. */
DLS_API DLS_MUST_USE dls_status dls_weighting_face(int order, int nodes_s, const double *s,
                                                   const int *candidate_s, int nodes_t,
                                                   const double *t, const int *candidate_t, int *p,
                                                   int *i, double *x, double *area, int *columns,
                                                   dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
