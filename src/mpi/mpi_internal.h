/* mpi_internal.h: declares what the files of src/mpi share. */
#ifndef MPI_INTERNAL_H
#define MPI_INTERNAL_H

#include <mpi.h>

#include "contact/body.h"
#include "contact/columns.h"
#include "contact/contact.h"
#include "delassus/mpi.h"

/* ---- agree.c: one status for all ranks ------------------------------------------------------- */

/* Returns a status that is equal on all ranks: DLS_OK, or the error of the first rank that has one;
 * *error then describes it on every rank. error: not NULL; filled on a rank with an error.
 * Collective. */
dls_status dlsi_agree(MPI_Comm comm, dls_status status, dls_error *error);

/* ---- grid.c: the ranks as a grid, and block-cyclic matrices on it ---------------------------- */

enum { dlsi_cyclic_block = 64 };

typedef struct dlsi_grid {
  MPI_Comm all, row, column; /* all ranks in their order; those of this process row, column */
  int rank, ranks;
  int rows, cols, my_row, my_col;
  int handle, context; /* of BLACS */
  int open;            /* 1: BLACS has the grid */
  MPI_Op most, norm;   /* DLSI_MOST, DLSI_NORM */
} dlsi_grid;

/* *grid (to be closed also after an error) := the ranks of comm, row by row. Collective. */
dls_status dlsi_grid_open(dlsi_grid *grid, MPI_Comm comm, dls_error *error);
void dlsi_grid_close(dlsi_grid *grid);

/* x := the sums, maxima or norms of the x of all ranks, with the same bits on each. Collective. */
void dlsi_grid_join(const dlsi_grid *grid, dlsi_how how, double *x, size_t count);

/* The distribution of square matrices of n rows: entry (i, j) of the share, i + rows j, is entry
 * (row[i], col[j]), both ascending. */
typedef struct dlsi_spread {
  const dlsi_grid *grid;
  int n, rows, cols;
  int *row, *col;
  double *x, *y, *all; /* scratch: rows + cols, rows + cols, n */
  int desc[9];
} dlsi_spread;

/* Local. */
dls_status dlsi_spread_create(dlsi_spread *s, const dlsi_grid *grid, int n, dls_error *error);
void dlsi_spread_free(dlsi_spread *s);

/* Returns the number of entries of a share. */
static inline size_t dlsi_spread_size(const dlsi_spread *s) {
  return (size_t)s->rows * (size_t)s->cols;
}

/* y := A x or, magnitudes = 1, |A| |x|, equal on all ranks to the last bit. symmetric: 1 if only
 * the lower triangle of A is read. x, y: n, may be the same. Collective. */
void dlsi_spread_multiply(const dlsi_spread *s, const double *A, int symmetric, int magnitudes,
                          const double *x, double *y);

/* A := A^-1, symmetric: 1 if A is positive definite; then only its lower triangle is read and
 * written. Returns 0, or k > 0 if pivot k, counted from 1, is not positive or is 0; -1 without
 * memory. Equal on all ranks. Collective. */
int dlsi_spread_invert(const dlsi_spread *s, double *A, int symmetric);

/* C := C + A^T. Collective. */
void dlsi_spread_add_transpose(const dlsi_spread *s, const double *A, double *C);

/* ---- halo.c: rows of other ranks ------------------------------------------------------------- */

/* A vector of a rank has its own rows, then ghosts. */
typedef struct dlsi_halo {
  const dlsi_grid *grid;
  int rows, first;    /* own rows */
  int ghosts, *ghost; /* rows of others, ascending, numbered through the ranks */
  int open, near;     /* 1: graph is there; ranks in it */
  MPI_Comm graph;
  int *out, *out_start, *in, *in_start; /* near each: rows that are ghosts there; ghosts here */
  int sent, *row;                       /* the former, own numbers */
  double *x;                            /* sent: scratch */
} dlsi_halo;

/* Numbers of rows, and of columns that are the same unknowns; lower: 1: only row >= col counts. */
typedef struct dlsi_entries {
  const int *row, *col; /* col: or NULL */
  size_t count;
  int lower;
} dlsi_entries;

/* Makes ghosts of those numbers that this rank does not own. counts, starts: rows of all ranks;
 * grid: borrowed. The caller calls dlsi_halo_free, also after an error. Collective. */
dls_status dlsi_halo_create(dlsi_halo *h, const dlsi_grid *grid, const int *counts,
                            const int *starts, const dlsi_entries *of, dls_error *error);
void dlsi_halo_free(dlsi_halo *h);

/* Returns where a row or ghost stands; the number of a row or ghost. */
int dlsi_halo_place(const dlsi_halo *h, int number);
static inline int dlsi_halo_number(const dlsi_halo *h, int place) {
  return place < h->rows ? h->first + place : h->ghost[place - h->rows];
}

/* Ghosts of x from their owners; owners' rows joined with the ghosts. Collective. */
void dlsi_halo_fetch(const dlsi_halo *h, double *x);
void dlsi_halo_give(const dlsi_halo *h, dlsi_how how, double *x);

/* Sorts x and removes what stands there twice; returns how many are left. */
size_t dlsi_unique(int *x, size_t count);

/* ---- shares.c: the model as the ranks have it ------------------------------------------------ */

typedef struct dlsi_shares {
  dlsi_grid grid;
  int d, n, nodes, m;             /* of all ranks; m = d nodes */
  int rows, first_row;            /* of this rank */
  int own, first;                 /* contact nodes of this rank */
  int *row_counts, *row_starts;   /* ranks each: rows */
  int *node_counts, *node_starts; /* ranks each: d nodes */
  int symmetric;
  dlsi_triplets mine; /* columns of H of this rank's nodes, by columns */
  dlsi_columns here;  /* rows of H of this rank, as H^T: contact rows of `touched` x rows */
  dlsi_halo touched;  /* contact rows: of this rank's nodes, of others that `here` touches */
  dlsi_ranks ranks;   /* what the certificate needs of them */
  dlsi_columns H, Ht; /* count x m: all of H on the unknowns that it touches; its transpose .. */
  int count, *keep;   /* .. those unknowns, ascending; dlsi_shares_shrink frees all this */
} dlsi_shares;

/* Checks what each rank can check alone: NULL, sizes, d, factorization. Local. */
dls_status dlsi_shares_check(const dls_mpi_model *model, dls_error *error);

/* Duplicates comm, checks the entries of the model, numbers, copies H. *work is zero before, and
 * stays in place; the caller calls dlsi_shares_free, also after an error. All of these are
 * collective except check_vector and shrink. */
dls_status dlsi_shares_create(dlsi_shares *work, MPI_Comm comm, const dls_mpi_model *model,
                              dls_error *error);
void dlsi_shares_free(dlsi_shares *work);
void dlsi_shares_shrink(dlsi_shares *work);

/* Joins the triplets of all ranks, of equal sizes, in `whole`. The caller frees it. */
dls_status dlsi_shares_join(const dlsi_shares *work, const dlsi_triplets *mine,
                            dlsi_triplets *whole, dls_error *error);

/* Checks a vector of this rank; NULL means zeros if `optional`. */
dls_status dlsi_shares_check_vector(const char *argument, const double *x, int count, int optional,
                                    dls_error *error);

/* Gathers the d values of each node of this rank, own, to all (m). */
void dlsi_shares_gather_nodes(const dlsi_shares *work, const double *own, double *all);

/* Gathers the rows of this rank on rank 0 (all: n there), or hands them out from there. */
void dlsi_shares_collect(const dlsi_shares *work, const double *own, double *all);
void dlsi_shares_hand_out(const dlsi_shares *work, const double *all, double *own);

/* Sets b (rows) to sign_i / scale_i, signs at random, the same on any number of ranks. */
void dlsi_shares_signs(const dlsi_shares *work, const double *scale, double *b);

/* ---- body.c: the certificate of the body on a K that is spread ------------------------------- */

typedef struct dlsi_mpi_body {
  const dlsi_shares *of;
  dlsi_halo halo;     /* unknowns: rows of this rank, others that its entries of K touch */
  size_t entries, *p; /* of a symmetric K those on and below the diagonal; rows + ghosts + 1 .. */
  int *col;           /* .. where the entries of each row begin; places */
  double *x;
  dlsi_body body; /* of the rows and nodes of this rank; its functions are collective */
  int *part;      /* rows */
  double *w;      /* 2 for each node of of->touched */
  double *near;   /* 3 vectors of the halo: scratch */
  double *scratch;
} dlsi_mpi_body;

/* Copies K, finds connected bodies and weights. *work is zero before; the caller calls
 * dlsi_mpi_body_free, also after an error. `of` and *work must stay in place. Collective. */
dls_status dlsi_mpi_body_create(dlsi_mpi_body *work, const dlsi_shares *of,
                                const dls_mpi_model *model, dls_error *error);
void dlsi_mpi_body_free(dlsi_mpi_body *work);

/* Copies the places of entries as numbers through the ranks: row, col: entries each. */
void dlsi_mpi_body_entries(const dlsi_mpi_body *work, int *row, int *col);

/* ---- condense.c: K without the unknowns that are kept ---------------------------------------- */

typedef struct dlsi_condenser dlsi_condenser;

/* Orders, analyses, factors K, spread as entries of a checked model, `of` its shares with keep. *S:
 * receives the share of the Schur complement of the scaled A = R K C, distributed by `spread`, to
 * be freed; its lower triangle if K is symmetric. info: receives the phases and the memory of
 * MUMPS. Collective, status equal on all ranks; *out and *S are NULL on error. of: borrowed. */
dls_status dlsi_condenser_create(dlsi_condenser **out, const dlsi_shares *of,
                                 const dls_mpi_model *model, double memory_limit,
                                 const dlsi_spread *spread, double **S, dls_mpi_info *info,
                                 dls_error *error);

/* R and C on the kept unknowns, count each, on every rank: (K^-1)_cc = C_c S^-1 R_c. For the rows
 * of this rank. */
typedef struct dlsi_scales {
  const double *row, *col, *own_rows, *own_cols;
  double norm; /* |A|_1 */
} dlsi_scales;
dlsi_scales dlsi_condenser_scales(const dlsi_condenser *work);

/* The two halves of a solve. condense: z (count, on every rank) from b (rows of this rank, spoilt),
 * so that (K^-1 b)_c = (K^-1)_cc z. expand, after it: x (rows) with the values y (count) on c.
 * Collective. */
dls_status dlsi_condenser_condense(dlsi_condenser *work, double *b, double *z, dls_error *error);
dls_status dlsi_condenser_expand(dlsi_condenser *work, const double *y, double *x,
                                 dls_error *error);

/* Orders and analyses the pattern of a matrix without kept unknowns; info receives the phases.
 * Again: for another kind. Then values (in the order of the model's entries, to be written anew
 * each time) and refactor, whenever they change; condense with z NULL and expand with y NULL solve.
 * DLS_E_SINGULAR, DLS_E_NOT_POSITIVE_DEFINITE and DLS_E_NOT_FINITE leave the pattern ready for
 * other values. Collective. */
dls_status dlsi_condenser_begin(dlsi_condenser **out, const dlsi_shares *of,
                                const dls_mpi_model *model, dls_mpi_info *info, dls_error *error);
dls_status dlsi_condenser_again(dlsi_condenser *work, dls_factorization kind, dls_mpi_info *info,
                                dls_error *error);
double *dlsi_condenser_values(dlsi_condenser *work);
dls_status dlsi_condenser_refactor(dlsi_condenser *work, dls_mpi_info *info, dls_error *error);

/* NULL is fine. Collective. */
void dlsi_condenser_destroy(dlsi_condenser *work);

/* ---- system.c: A = K + H R H^T + E on the ranks ---------------------------------------------- */

typedef struct dlsi_mpi_system {
  const dlsi_mpi_body *K;
  dls_mpi_info *info; /* adds up the phases */
  dlsi_condenser *condenser;
  size_t of_H; /* entries of A on this rank, in this order: K, so many of H R H^T, E of its rows */
  double *e;   /* rows: E is hold * e, e = |K_jj| */
  double hold; /* 0 if nothing is singular */
  double *b;   /* rows: scratch */
} dlsi_mpi_system;

/* Lists A and analyses it. *work is zero before; the caller calls dlsi_mpi_system_free, also after
 * an error. K, info: borrowed. All of these are collective. */
dls_status dlsi_mpi_system_create(dlsi_mpi_system *work, const dlsi_mpi_body *K,
                                  dls_factorization kind, dls_mpi_info *info, dls_error *error);
void dlsi_mpi_system_free(dlsi_mpi_system *work);

/* The functions of a dls_global_solver, data: a dlsi_mpi_system: R: of this rank's nodes; b, x:
 * rows. */
dls_status dlsi_mpi_system_prepare(void *data, const double *R, dls_error *error);
dls_status dlsi_mpi_system_solve(void *data, const double *b, double *x, double accuracy,
                                 dls_error *error);

/* ---- solve.c --------------------------------------------------------------------------------- */

/* Rank 0's callback and clock, which hold for all ranks. */
typedef struct dlsi_mpi_watch {
  MPI_Comm all;
  int root;
  dls_limits told; /* rank 0's own */
  double begun;
  int late; /* 1: stopped by the clock */
} dlsi_mpi_watch;

/* Starts to watch a solve with *limits, and replaces callback and clock in *limits, which differ by
 * rank. Collective. *watch lives as long as *limits is used. */
void dlsi_mpi_watch_begin(dlsi_mpi_watch *watch, const dlsi_grid *grid, dls_limits *limits);

/* Sets tol, max_iterations and warm_start to those of rank 0. Collective. */
void dlsi_mpi_take_limits(const dlsi_grid *grid, dls_limits *limits);

/* ---- reduction.c ----------------------------------------------------------------------------- */

struct dls_mpi_reduction {
  dlsi_shares of;
  dlsi_mpi_body body;
  dlsi_condenser *condenser;
  double condition; /* of K, scaled */
  dlsi_spread on_kept, on_W;
  double *Z, *W; /* shares of (A^-1)_cc (lower triangle if symmetric) and of W */
  double *A;     /* share of (W + rho D)^-1, NULL before the first solve; as Z */
  int A_symmetric;
  double *q, *gap;   /* m each: of the last load, as f */
  double *f, *b;     /* rows each; b: scratch */
  double *z, *local; /* scratch: count; m */
  dls_mpi_info info;
};

/* work->b := K^-1 f. Errors of dlsi_mpi_recover. */
dls_status dlsi_mpi_own(dls_mpi_reduction *work, dls_error *error);

/* Computes x := K^-1 (f + H r). r: m, of all ranks; x: rows. Collective. */
dls_status dlsi_mpi_recover(dls_mpi_reduction *work, const double *r, double *x, dls_error *error);

/* The wall clock and the CPU seconds of this thread, to take differences of. */
typedef struct dlsi_mpi_clock {
  double wall, cpu;
} dlsi_mpi_clock;
dlsi_mpi_clock dlsi_mpi_now(void);

#endif
