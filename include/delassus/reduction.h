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

/* Finds the rigid-body modes of K, dense or sparse, without redundant joints: its null space to
 * working precision, |K x| <= 50 eps |K||x| with rows and columns scaled. *count := how many; up to
 * `most` of them go to basis (n x most; or NULL), each with a 1 in its unknown[k] (most; or NULL)
 * where all others are 0, so that a body's modes live on that body and fixing unknown[0 ..
 * *count-1] fixes all. At most 24 are found. Factors a shifted K. DLS_E_UNSUPPORTED for a
 * flexibility or a host's solver. */
DLS_API DLS_MUST_USE dls_status dls_model_modes(const dls_model *model, int most, double *basis,
                                                int *unknown, int *count, dls_error *error);

/* Where the contact problem is solved. */
typedef enum dls_on {
  DLS_ON_EITHER, /* dls_reduction_create_either chooses; the others take W */
  DLS_ON_W,      /* the Delassus matrix, m x m and dense: few contacts, many loads, any method */
  DLS_ON_K       /* the stiffness (global.h): contact over whole surfaces, bodies that only contact
                    holds; by dls_reduction_solve with method auto */
} dls_on;

typedef struct dls_reduction_settings {
  size_t size;         /* set by init; settings without it are refused */
  dls_on on;           /* DLS_ON_EITHER */
  int loads;           /* how many solves to expect for one K, for the choice; 1 */
  double memory_limit; /* bytes; more than that foreseen is DLS_E_MEMORY before the work; 0: none */
  int allow_indefinite; /* 1: a K tagged DLS_CHOLESKY that is indefinite is factored as DLS_LDLT
                           instead of being an error; 0 */
  int stabilize;    /* 1: rigid-body modes are looked for in a singular K and held as if they had
                          been given as model.modes, instead of being an error; 0 */
  int form_W;       /* 0: q and x only, for methods that work on K; 1 */
  int frictionless; /* 1: H_N alone is condensed, and the contact problem has d = 1: one entry of r,
                       u and q per candidate, a quarter (2D) or a ninth (3D) of W's memory. HT is
                       checked but not used; model.mu must be 0 or NULL (DLS_E_ARGUMENT); 0 */
  dls_progress_fn progress; /* called in create and update, about every millisecond between pieces
                               of the work: method "reduction"; stage "analysis", "factor", "modes"
                               (the search for them) or "W"; iteration of max_iterations pieces (0:
                               unknown); residual -1, r NULL. Not 0 cancels: DLS_CANCELLED. One call
                               of METIS, of MUMPS, or of LAPACK's LU cannot be cancelled: the next
                               call comes after it. NULL for none; NULL */
  void *progress_data;      /* lives as long as the reduction is created or updated */
} dls_reduction_settings;

/* Sets each field to its default. */
DLS_API void dls_reduction_settings_init(dls_reduction_settings *settings);

/* Cost of a reduction: foreseen, or as it was. */
typedef struct dls_reduction_info {
  dls_on on;           /* DLS_ON_W; DLS_ON_K: K is not factored here, the fields from condensed on
                          are 0 */
  int contacts;        /* candidates of the contact problem */
  int condensed;       /* unknowns of the dense Schur complement; 0 where there is none */
  double W_bytes;      /* m^2 doubles */
  double factor_bytes; /* of K's factor and the Schur complement */
  double bytes;        /* most in use at the same time in create */
  double flops;        /* of the factorisation and of S^-1, from the analysis */
  double condition;    /* of K scaled, by estimate; 0 before the work or where K is not factored */
  int indefinite;      /* K was tagged DLS_CHOLESKY and is not positive definite */
  int modes;     /* rigid-body modes held by springs; 25: more than 24, springs at all unknowns */
  int joints;    /* multipliers among the unknowns (model.h) */
  int redundant; /* joints that follow from others: their multipliers are 0, any would do */
} dls_reduction_info;

/* Foresees what dls_reduction_create_with would take; for a sparse K from ordering and analysis (a
 * few per cent of the work in 3D, up to half of it in 2D). settings NULL for the defaults; the
 * limit is not applied. */
DLS_API DLS_MUST_USE dls_status dls_reduction_estimate(const dls_model *model,
                                                       const dls_reduction_settings *settings,
                                                       dls_reduction_info *info, dls_error *error);

typedef struct dls_reduction dls_reduction;

/* Factors K, forms W; *out = NULL on error. With m = d * (active candidates), or these alone where
 * settings.frictionless, it holds m^2 doubles
 * for W, H, a few vectors, and the factor or K^-1: n^2 for a dense one, the sum of the squares of
 * small parts of a sparse one, else the sparse factor and the b^2 of the Schur complement on the b
 * unknowns that H touches (or, where these are more than four times the columns of H, the
 * sparse factor alone). Forming W takes at most 128 n, or b^2, doubles more. W is exactly
 * symmetric with DLS_CHOLESKY and DLS_LDLT. Threads with a sparse K each wait for one another in
 * METIS and MUMPS.
 *
 * DLS_E_SINGULAR (condition above 4e14 after scaling rows and columns, so whatever the units of
 * forces, moments, displacements and rotations) names K or Ks. Where the null space is that of
 * rigid-body modes, the message says how many and of which unknowns, value is their number, index
 * the first of these unknowns, and model.modes or settings.stabilize are the way on. Otherwise
 * index is an unknown where it shows. DLS_E_NOT_POSITIVE_DEFINITE: index the unknown of a pivot <=
 * 0 and value the pivot of the scaled matrix; or index -1 and value the number of negative pivots.
 * DLS_E_NOT_FINITE naming "W", or entries of Ks that add up to Inf: an overflow. DLS_E_MEMORY
 * with the figures. DLS_E_UNSUPPORTED, DLS_E_CALLBACK, DLS_E_SIZE, DLS_E_SETTINGS, and the errors
 * of dls_model_check. */
DLS_API DLS_MUST_USE dls_status dls_reduction_create(dls_reduction **out, const dls_model *model,
                                                     dls_error *error);

/* Works as dls_reduction_create, with settings; NULL for the defaults. DLS_CANCELLED, which is not
 * negative, if settings.progress cancels: *out = NULL then, too. */
DLS_API DLS_MUST_USE dls_status dls_reduction_create_with(dls_reduction **out,
                                                          const dls_model *model,
                                                          const dls_reduction_settings *settings,
                                                          dls_error *error);

/* Works as dls_reduction_create_with and chooses, unless settings.on says it, where the problem is
 * solved: on W, or on K, by the flops and bytes foreseen for settings.loads solves. W that does not
 * fit settings.memory_limit, a singular K, and given or wanted rigid-body modes go to K; a K that
 * is not at hand (flexibility, a host's solver) to W. dls_reduction_get_info tells.
 *
 * On K a reduction serves load, load_free, certify, nodal, update and dls_reduction_solve;
 * dls_reduction_contact, recover and balance need W and answer DLS_E_UNSUPPORTED. */
DLS_API DLS_MUST_USE dls_status dls_reduction_create_either(dls_reduction **out,
                                                            const dls_model *model,
                                                            const dls_reduction_settings *settings,
                                                            dls_error *error);

/* Takes new values of K, H, P on the pattern of create, whose analysis and memory are reused: W is
 * formed anew, f and q are 0 again, views of them (dls_reduction_contact) stay valid; modes stay
 * those of create. DLS_E_SIZE or
 * DLS_E_ARGUMENT for another size or pattern, and then the reduction is as it was. After any other
 * error than those of dls_model_check it holds nothing: all but update and destroy answer
 * DLS_E_ARGUMENT; nor does it after DLS_CANCELLED. */
DLS_API DLS_MUST_USE dls_status dls_reduction_update(dls_reduction *reduction,
                                                     const dls_model *model, dls_error *error);

/* Tells what the reduction took. */
DLS_API DLS_MUST_USE dls_status dls_reduction_get_info(const dls_reduction *reduction,
                                                       dls_reduction_info *info, dls_error *error);

/* Takes new loads and gaps on the same factor: q := H^T K^-1 f + P^T g. f (n) or NULL for 0; g (d *
 * nodes) or NULL for 0. Before the first call f and q are 0; an error leaves both as they were.
 * One solve, or half of one where there is a Schur complement. Allocates nothing (MUMPS does). */
DLS_API DLS_MUST_USE dls_status dls_reduction_load(dls_reduction *reduction, const double *f,
                                                   const double *g, dls_error *error);

/* Takes K^-1 f instead of f, from a host that has it: its free displacement or velocity, by a
 * scheme or a solver of its own. q := H^T x_free + P^T g, and dls_reduction_recover gives
 * x_free + K^-1 H r. x_free (n); g as in dls_reduction_load. No solve, no allocation.
 * DLS_E_UNSUPPORTED where rigid-body modes are held: K^-1 does not exist. */
DLS_API DLS_MUST_USE dls_status dls_reduction_load_free(dls_reduction *reduction,
                                                        const double *x_free, const double *g,
                                                        dls_error *error);

/* Gives the contact problem of the active candidates with the friction coefficients mu (one
 * for each of these; borrowed; NULL for those of the model). W and q belong to the reduction and
 * live as long as it does; q changes with dls_reduction_load. Where tangents were left out, their
 * rows and columns of W and q are 0, and mu must be 0 (DLS_E_ARGUMENT). DLS_E_UNSUPPORTED without
 * W. */
DLS_API DLS_MUST_USE dls_status dls_reduction_contact(const dls_reduction *reduction,
                                                      const double *mu, dls_contact *problem,
                                                      dls_error *error);

/* Recovers x := K^-1 (f + H r), n, with f as last given to dls_reduction_load (copied there), or
 * x_free + K^-1 H r. r (m). One solve; where there is a Schur complement, the half that load has
 * left: load and recover are then one solve. With MUMPS that holds for the first recover, and the
 * next ones of the same load take one solve. Allocates nothing (MUMPS does). */
DLS_API DLS_MUST_USE dls_status dls_reduction_recover(dls_reduction *reduction, const double *r,
                                                      double *x, dls_error *error);

/* Measures the pair (x, r) on the body, with f and g as last loaded, without any spring that holds
 * a mode. Positions and forces as in contact.h, but
 *
 *   u = H^T x + g            from x, not W r + q; or NULL, else m: receives it
 *   weights                  the compliance of the contact node with its neighbours held, from K
 *   |q|                      the root of |H^T x|^2 + |g|^2 + |D r|^2 of the contacts that touch
 *   equilibrium              max over connected bodies of |K x - f - H r| / (|f| + |H r|); with
 *                            joints, of each body by itself with |G l| beside |H r|, and of the
 *                            joints |G^T x - b| over lengths (src/base/equilibrium.c)
 *
 * mu as in dls_reduction_contact. Where K is a flexibility or a host's solver, equilibrium is 0 and
 * the weights are those of W. dls_certificate_verdict judges all three parts. O(entries of K and
 * H). Errors of dls_reduction_recover. */
DLS_API DLS_MUST_USE dls_status dls_reduction_certify(dls_reduction *reduction, const double *mu,
                                                      const double *r, const double *x, double *u,
                                                      dls_certificate *certificate,
                                                      dls_error *error);

/* Tells the state of each candidate, as dls_contact_states, from r and u = H^T x + g with the
 * weights of K. mu as in dls_reduction_contact; r, u (m); state (candidates). Errors of
 * dls_reduction_certify. */
DLS_API DLS_MUST_USE dls_status dls_reduction_states(dls_reduction *reduction, const double *mu,
                                                     const double *r, const double *u,
                                                     dls_contact_state *state, dls_error *error);

/* Balances a K whose k rigid-body modes are held: the springs s_j = 0.1 K_jj at k unknowns j of
 * the modes make K regular, and take the part of the loads that r does not balance,
 *
 *   K x = f + H r - s (x_j - c_j) e_j for each of them,   c = 0 after dls_reduction_load.
 *
 * *imbalance (or NULL) := max over the modes b of |b^T (f + H r)| / |b|^T (|f| + |H||r|): 0 in
 * equilibrium, 1 where nothing holds the body. Then c moves, and q follows: solving, balancing and
 * solving again until *imbalance is small gives the equilibrium of the free body without any
 * spring. c_j := x_j first (proximal point method on the resultants); from the second turn on by
 * what the turns before, of this load and of earlier ones, have taught about x_j and c_j (Broyden's
 * method), which needs about as many turns as modes while the contacts keep their states. Takes
 * what dls_reduction_recover takes. *imbalance := 0 if there are no modes. */
DLS_API DLS_MUST_USE dls_status dls_reduction_balance(dls_reduction *reduction, const double *r,
                                                      double *imbalance, dls_error *error);

/* Gives R := P r in local order, d * nodes, the nodal reactions that r (m) stands for; R = r
 * without P. R and r must not overlap. */
DLS_API DLS_MUST_USE dls_status dls_reduction_nodal(const dls_reduction *reduction, const double *r,
                                                    double *R, dls_error *error);

/* NULL is fine. */
DLS_API void dls_reduction_destroy(dls_reduction *reduction);

/* Computes the weighting of a contact line, [J] 4.4 example 2: column j spreads the reaction of
 * candidate j, constant on its dual cell (half way to its neighbours), by the integrals of the
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

#ifdef __cplusplus
}
#endif

#endif
