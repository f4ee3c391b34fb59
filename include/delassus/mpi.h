/*
 * delassus/mpi.h: a model that does not fit one machine: reduction and solve on several processes.
 *
 *   K x = f + H r,   u = H^T x + g,   W = H^T K^-1 H,   q = H^T K^-1 f + g,   u = W r + q
 *
 * as in reduction.h. Every process (rank) of a communicator has a share of the rows and of the
 * contact nodes; K is factorised by the distributed MUMPS, the Schur complement and W are
 * block-cyclic matrices of ScaLAPACK. The functions belong to libdelassus-mpi (make MPI=1), which
 * holds all of libdelassus, too, and is linked in its place.
 *
 * All functions but those said to be local are collective: every rank of the communicator calls
 * them, in the same order. Status, error and info are then equal on all ranks: an error of one rank
 * is an error of all, its message begins with the rank's number, and index counts in the arguments
 * of that rank. If a rank dies, mpirun ends the others.
 *
 * Rows and contact nodes are numbered through the ranks: those of rank 0 first, then those of rank
 * 1, and so on; a rank may have none. Indices are 0-based. Neither MUMPS nor METIS is re-entrant:
 * one thread of a process at a time.
 */
#ifndef DELASSUS_MPI_H
#define DELASSUS_MPI_H

#include <mpi.h>

#include "delassus/contact.h"
#include "delassus/global.h"
#include "delassus/info.h"
#include "delassus/model.h"
#include "delassus/reduction.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The share of one rank: a view, read by dls_mpi_reduction_create only. n: the rows of all ranks
 * together. */
typedef struct dls_mpi_model {
  int d;                           /* 2 or 3, equal on all ranks */
  dls_factorization factorization; /* of K, equal on all ranks; of a symmetric K only entries on and
                                      below the diagonal are read */
  int rows;                        /* of this rank, >= 0 */
  size_t entries;                  /* of K that this rank has, in any rows; entries of the same
                                      place add up, on one rank or on several */
  const int *row, *col;            /* entries, 0 .. n-1 */
  const double *x;                 /* entries; force / length */
  int nodes;                       /* contact nodes of this rank, >= 0 */
  dls_sparse HN;                   /* n x nodes; not read where nodes = 0 */
  dls_sparse HT;                   /* n x (d-1) nodes */
} dls_mpi_model;

typedef enum dls_mpi_phase {
  DLS_MPI_ORDER = 0,   /* gather the pattern, nested dissection on rank 0 */
  DLS_MPI_ANALYSE = 1, /* MUMPS */
  DLS_MPI_FACTOR = 2,  /* MUMPS: factor and Schur complement S */
  DLS_MPI_INVERT = 3,  /* S^-1 */
  DLS_MPI_FORM = 4,    /* W */
  DLS_MPI_PHASES = 5
} dls_mpi_phase;

/* Sizes, and the cost on this rank. */
typedef struct dls_mpi_info {
  int ranks, rank;
  int grid[2];                 /* process rows and columns of the block-cyclic matrices */
  int n, condensed, m;         /* unknowns; rows of S; rows of W, of all ranks together */
  double wall[DLS_MPI_PHASES]; /* seconds */
  double cpu[DLS_MPI_PHASES];
  double factor_bytes; /* largest memory of MUMPS on this rank */
  double dense_bytes;  /* of the block-cyclic matrices on this rank, W included */
  double flops;        /* of the elimination on this rank */
} dls_mpi_info;

typedef struct dls_mpi_reduction dls_mpi_reduction;

/* Creates a reduction: orders and factorises K, forms W; *out = NULL on error. settings: those of
 * the serial reduction, from rank 0; NULL for the defaults. memory_limit is in bytes on a rank,
 * compared with MUMPS's estimate. form_W = 0: DLS_E_UNSUPPORTED.
 *
 * Memory of a rank: its share of the factor, three times its share of b^2 doubles (b unknowns that
 * H touches), its entries of K, all of H, 12 vectors of its rows; on rank 0 two vectors of n, and
 * the pattern of K while it is ordered.
 * Errors as dls_reduction_create, and DLS_E_MEMORY if one rank has none. No reference to the model
 * is kept; comm is duplicated. */
DLS_API DLS_MUST_USE dls_status dls_mpi_reduction_create(dls_mpi_reduction **out, MPI_Comm comm,
                                                         const dls_mpi_model *model,
                                                         const dls_reduction_settings *settings,
                                                         dls_error *error);

/* Copies the sizes and the cost of the reduction into *info. Local. */
DLS_API DLS_MUST_USE dls_status dls_mpi_reduction_get_info(const dls_mpi_reduction *reduction,
                                                           dls_mpi_info *info, dls_error *error);

/* Sets q := H^T K^-1 f + g. f (rows of this rank) or NULL for 0; g (d nodes of this rank) or NULL
 * for 0. Half a solve. An error leaves f and q unchanged. */
DLS_API DLS_MUST_USE dls_status dls_mpi_reduction_load(dls_mpi_reduction *reduction,
                                                       const double *f, const double *g,
                                                       dls_error *error);

/* The distributed contact problem: views into the reduction, valid as long as it is. */
typedef struct dls_mpi_contact {
  int d, nc;       /* of all ranks */
  int m, block;    /* rows of W; of its square blocks */
  int rows, cols;  /* of this rank's share of W */
  const int *row;  /* rows: the row of W that stands in each row of the share */
  const int *col;  /* cols */
  const double *W; /* rows x cols, column-major without gaps */
  const double *q; /* m: all of it, on every rank */
} dls_mpi_contact;

/* Sets *problem to views of the part of W, and of q, that this rank holds. Local. */
DLS_API DLS_MUST_USE dls_status dls_mpi_reduction_contact(const dls_mpi_reduction *reduction,
                                                          dls_mpi_contact *problem,
                                                          dls_error *error);

/* Copies all of W to rank 0. W: m x m, column-major without gaps, on rank 0; not read on others. */
DLS_API DLS_MUST_USE dls_status dls_mpi_reduction_gather(const dls_mpi_reduction *reduction,
                                                         double *W, dls_error *error);

/* Recovers x := K^-1 (f + H r). r: d nodes of this rank; x: rows of this rank. One solve. */
DLS_API DLS_MUST_USE dls_status dls_mpi_reduction_recover(dls_mpi_reduction *reduction,
                                                          const double *r, double *x,
                                                          dls_error *error);

/* Frees the reduction; NULL is fine. Collective, because it frees the communicator. */
DLS_API void dls_mpi_reduction_destroy(dls_mpi_reduction *reduction);

/* Settings, of which those of rank 0 are used. */
typedef struct dls_mpi_settings {
  dls_limits limits; /* blocks is not read; progress is called on rank 0, cpu_seconds are those of
                        rank 0 */
  size_t size;       /* set by init; settings without it are refused */
  int gather;        /* rows of W up to which W goes to rank 0 and is solved there by dls_solve
                        (auto), while the others wait; 1000 */
} dls_mpi_settings;

/* Sets each field to its default. */
DLS_API void dls_mpi_settings_init(dls_mpi_settings *settings);

/* Solves u = W r + q with the law of contact.h: on rank 0 by dls_solve, or by ADMM (admm.h) on the
 * shared W. Then takes x = K^-1 (f + H r) of the last load and certifies the pair (x, r) on the
 * body as dls_mpi_certify does: info->certificate is that of the body, and it alone decides the
 * status, as in dls_reduction_judge. If it does not hold, the problem is solved again from r with a
 * smaller tolerance on W, up to 4 times, as long as the body's residual halves; iterations, limits
 * and progress count all of these solves. mu: nodes of this rank. r (d nodes of this rank): in, the
 * start if warm_start; out, the reactions. u (d nodes) or NULL: H^T x + g. info or NULL. settings
 * NULL for the defaults.
 *
 * Takes one more share of m^2 doubles, on every rank, or m^2 doubles on rank 0; one solve with K
 * and one product with it besides. Statuses of dls_solver_solve and of dls_admm_solve;
 * DLS_NOT_IN_EQUILIBRIUM or DLS_STALLED if r solves the problem on W and the body's certificate
 * does not hold: continue with dls_mpi_global_solve from r and x. */
DLS_API DLS_MUST_USE dls_status dls_mpi_solve(dls_mpi_reduction *reduction, const double *mu,
                                              const dls_mpi_settings *settings, double *r,
                                              double *u, dls_info *info, dls_error *error);

/* Certifies the pair (x, r) for the body and the last load, as dls_reduction_certify: positions,
 * forces, and |K x - f - H r| over |H||r| + min(|f|, 100 |H||r|) of each connected body, without
 * what f alone does to the body where that is needed (docs/certificate.md); dls_certificate_holds
 * and dls_certificate_verdict read it. mu: nodes of this rank; r: d nodes; x: rows; u: receives
 * H^T x + g, d nodes, or NULL. *certificate is equal on all ranks; its `worst` and `body` count
 * through the ranks. One product with K. */
DLS_API DLS_MUST_USE dls_status dls_mpi_certify(dls_mpi_reduction *reduction, const double *mu,
                                                const double *r, const double *x, double *u,
                                                dls_certificate *certificate, dls_error *error);

/* The contact problem on K itself, as global.h: W is never formed, and no rank holds a matrix of m
 * rows. Each iteration of the splitting is one solve with a distributed factor of K + H R H^T. */
typedef struct dls_mpi_global dls_mpi_global;

/* Copies the model. solver NULL: orders and analyses K + H R H^T, which MUMPS factorises on all
 * ranks; K may be singular, and with DLS_CHOLESKY need not be definite. Otherwise all ranks give a
 * solver, as dls_global_create_with, whose functions are collective: R is that of the nodes of this
 * rank, b and x are the rows of this rank; an error on one rank is an error on all. No reference to
 * the model is kept; comm is duplicated. *out = NULL on error. Errors as dls_mpi_reduction_create.
 *
 * Memory of a rank: its entries of K, about 18 vectors of its rows and, with H, 60 of the contact
 * rows that these touch. Nothing of n or m is on every rank, except while H is numbered. With a
 * factor also its share of that, its entries once more, and on rank 0 a vector of n, and the
 * pattern of K while it is ordered. */
DLS_API DLS_MUST_USE dls_status dls_mpi_global_create(dls_mpi_global **out, MPI_Comm comm,
                                                      const dls_mpi_model *model,
                                                      const dls_global_solver *solver,
                                                      dls_error *error);

/* Returns sizes and cost. Only the phases order, analyse and factor are set, summed over all
 * factorisations, and none on one rank, which solves as global.h does; condensed is 0. Local. */
DLS_API DLS_MUST_USE dls_status dls_mpi_global_get_info(const dls_mpi_global *global,
                                                        dls_mpi_info *info, dls_error *error);

/* Solves as dls_global_solve: same statuses, same certificate of (x, r) in *info; max_iterations,
 * warm_start, tol, cpu_seconds and progress (its r: of the nodes of rank 0) are those of rank 0.
 * f, x: rows of this rank; g, r: d nodes; mu: nodes, NULL for 0; r and x must not overlap. Newton
 * steps need a host's block and apply; a rank then keeps its rows of up to 61 vectors. With a
 * host's solver there are no proofs. For the proof that nothing can hold a body rank 0 takes and
 * factorises all of K; without the memory for that nothing is proved. */
DLS_API DLS_MUST_USE dls_status dls_mpi_global_solve(dls_mpi_global *global, const double *f,
                                                     const double *g, const double *mu,
                                                     const dls_limits *limits, double *r, double *x,
                                                     dls_info *info, dls_error *error);

/* Returns on rank 0 the motion (n, of all ranks) that proves DLS_NO_SOLUTION after the last solve,
 * as dls_global_motion; NULL after any other status. Not set on other ranks. Local. */
DLS_API const double *dls_mpi_global_motion(const dls_mpi_global *global, int *body);

/* Frees the object; NULL is fine. Collective. */
DLS_API void dls_mpi_global_destroy(dls_mpi_global *global);

#ifdef __cplusplus
}
#endif

#endif
