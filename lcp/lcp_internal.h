/*
 * lcp_internal.h: shared by the files of lcp/: the certificate and the scaling of an LCP, the parts
 * of Lemke's method, and the contact problem as an LCP.
 */
#ifndef LCP_INTERNAL_H
#define LCP_INTERNAL_H

#include "contact/contact.h"
#include "delassus/facets.h"
#include "delassus/lcp.h"
#include "delassus/pivoting.h"
#include "linear/dense.h"

/* ---- lcp.c ----------------------------------------------------------------------------------- */

dls_status dlsi_check_lcp(const dls_lcp *lcp, dls_error *error);

/* As dlsi_check_lcp, for a function that needs a dense M: DLS_E_UNSUPPORTED for Ms. */
dls_status dlsi_check_dense_lcp(const dls_lcp *lcp, dls_error *error);

/* Checks the arguments of a solver with room for `most` unknowns: its size, and z, which must be
 * finite with a warm start. The LCP has been checked. */
dls_status dlsi_check_lcp_solve(int most, const dls_lcp *lcp, const double *z, int warm_start,
                                dls_error *error);

/* Checks that x (n) is finite and each x_i > 0. */
dls_status dlsi_check_positive(const char *argument, const double *x, int n, dls_error *error);

static inline const double *dlsi_lcp_column(const dls_lcp *lcp, int j) {
  return lcp->M.a + (size_t)j * (size_t)lcp->M.ld;
}

/* y := M z + q, a := |M||z|; q = NULL for none. */
void dlsi_lcp_multiply(const dls_lcp *lcp, const double *q, const double *z, double *y, double *a);

/* Returns M_jj. */
double dlsi_lcp_diagonal(const dls_lcp *lcp, size_t j);

/* s_i := |M_ii|, or max_j |M_ij| where M_ii = 0, or 1 for a zero row. */
void dlsi_lcp_weights(const dls_lcp *lcp, double *s);

/* Computes the certificate of z from given y = M z + q, a = |M||z| and weights s. */
void dlsi_lcp_measure(const dls_lcp *lcp, const double *z, const double *y, const double *a,
                      const double *s, dls_lcp_certificate *certificate);

/* Return the violations of dls_lcp_check_ray (work: scratch, 6 n) and dls_lcp_check_farkas. */
double dlsi_lcp_ray_violation(const dls_lcp *lcp, const double *cover, const double *z, double z0,
                              const double *dz, double dz0, double *work);
double dlsi_lcp_farkas_violation(const dls_lcp *lcp, const double *v);

/* Returns 1 if v (n), or a vector near v, is a Farkas vector in exact arithmetic, and stores that
 * vector in v. work: n. */
int dlsi_lcp_find_proof(const dls_lcp *lcp, double *v, double *work);

/* ---- active.c -------------------------------------------------------------------------------- */

/* The workspace of block pivots with a sparse M. */
typedef struct dlsi_active dlsi_active;

/* Makes room for n unknowns and so many entries. *out = NULL on error: DLS_E_SIZE, DLS_E_MEMORY. */
dls_status dlsi_active_create(dlsi_active **out, int n, int entries, dls_error *error);

/* Solves a checked problem with Ms of that room. z (n): in, the start of a warm start; out, z >= 0
 * of the least residual, untouched after an error. Counts in *info, and sets its status. Errors of
 * dlsi_general_factor but DLS_E_SINGULAR. */
dls_status dlsi_active_run(dlsi_active *work, const dls_lcp *lcp,
                           const dls_principal_settings *settings, double begun, double *z,
                           dls_principal_info *info, dls_error *error);

/* Frees the workspace; NULL is fine. */
void dlsi_active_destroy(dlsi_active *work);

/* ---- scale.c --------------------------------------------------------------------------------- */

/* Finds exponents rho (rows) and gamma (columns) so that the entries != 0 of 2^(rho_i + gamma_j)
 * |M_ij| have a geometric mean of about 1 in every row and column. Negligible entries are raised
 * (SC4). work: scratch, 9 n. */
void dlsi_lcp_equilibrate(const dls_lcp *lcp, double *rho, double *gamma, double *work);

/* Returns 2^round(e), with e limited to -500 .. 500 so that two such factors cannot overflow. */
double dlsi_power_of_two(double e);

/* ---- crash.c --------------------------------------------------------------------------------- */

/* The state of (CR1)-(CR5). The caller sets s and factors.A; dlsi_crash_carve takes the rest. */
typedef struct dlsi_crash {
  const double *s;     /* weights of the certificate, n */
  dlsi_dense factors;  /* M_00, k x k. A has n x n doubles: Y, G, change.A, a product behind M_00 */
  dlsi_dense change;   /* the matrix of (CR5), h x h; in factors.A */
  double *G;           /* M_E0, e x k; in factors.A */
  double *z, *y, *a;   /* z and y of (CR1), |M||z|, n */
  double *b, *x, *v;   /* right-hand sides, n */
  int *in, *wrong;     /* 1 for i in A; 1 for a negative z_i or y_i, n */
  int *base;           /* A_0, ascending, k */
  int *place, *slot;   /* position of i in A_0, column of i in Y; -1 for none, n */
  int *differ;         /* E, then D, h */
  int columns, e;      /* columns of Y; |E| */
  int rounds;          /* so far */
  int fewest, chances; /* of (CR3): least |out| + |in|; rounds left */
} dlsi_crash;

/* Takes the arrays; ld >= n: length of a vector of doubles. */
void dlsi_crash_carve(dlsi_crash *work, dlsi_arena *arena, size_t n, size_t ld);

/* Starts at the basis { i : z_i > 0 }; NULL: at the empty one. */
void dlsi_crash_begin(const dls_lcp *lcp, const double *z, dlsi_crash *work);

/* Runs one round. Returns 0 to go on, 1 if z solves the LCP up to rounding, -1 to give up. */
int dlsi_crash_round(const dls_lcp *lcp, dlsi_crash *work);

/* ---- table.c --------------------------------------------------------------------------------- */

enum { dlsi_table_block = 96 }; /* postponed pivots */

/* Lemke's table, with (TA3) and (TA4) of table.c. Variables are numbered: y_i is i, z_i is n + i,
 * z0 is 2 n. */
typedef struct dlsi_table {
  int n, ld;
  double *T;   /* coefficients without the pending pivots, ld x (n+1) */
  double *U;   /* n x block */
  double *L;   /* block x block, lower triangle */
  double *V;   /* block x (n+1), used while flushing */
  double *W;   /* right-hand side of (TA4), block x (n+1) */
  int pending; /* postponed pivots */
  int *row;    /* their rows, block */
  int *born;   /* the last pending pivot of each column, -1 if none, n+1 */
  double *b;   /* values of the basic variables, n */
  double *g;   /* their derivatives by the perturbation, n */
  int *basic;  /* variable of each row, n */
  int *column; /* variable of each column, n+1 */
  int *where;  /* of each variable: its row, or -1 - its column, 2n+1 */
} dlsi_table;

/* Takes the arrays for n unknowns; ld >= n: length of a column of T. */
void dlsi_table_carve(dlsi_table *table, dlsi_arena *arena, size_t n, size_t ld);

/* c (n) := column s of A. */
void dlsi_table_column(const dlsi_table *table, int s, double *c);

/* Exchanges the variables of row r and column s; c: column s as above, c[r] != 0. */
void dlsi_table_exchange(dlsi_table *table, int r, int s, const double *c);

/* dx (n) := the move of the basic variables if each nonbasic y_i moves by dy_i (n). */
void dlsi_table_move_y(const dlsi_table *table, const double *dy, double *dx);

/* ---- friction.c ------------------------------------------------------------------------------ */

/* A contact problem as an LCP, (FI1)-(FI3) of friction.c. */
typedef struct dlsi_form {
  int directions;                  /* tangential unknowns of a contact with mu > 0 */
  double shift;                    /* 0 or 1 */
  double c[DLS_FACETS_MAX + 1][3]; /* n, then e_k, k = 0 .. directions-1 */
} dlsi_form;

/* Counts the rows of the LCP, `directions` + 2 for a contact with mu > 0; 0 if they overflow an
 * int. */
int dlsi_form_size(const dls_contact *problem, int directions);

/* Do the work of dls_contact_to_lcp and dls_contact_from_lcp on a checked problem, and check the
 * other arguments. */
dls_status dlsi_form_matrix(const dls_contact *problem, const dlsi_form *form, const double *s,
                            double *M, int ldm, double *q, dls_error *error);
dls_status dlsi_form_reactions(const dls_contact *problem, const dlsi_form *form, const double *s,
                               const double *z, double *r, dls_error *error);

/* z (dls_contact_lcp_size) := 1 where the states of (u, r) make the unknown of the 3-row form
 * positive, else 0: a start for Lemke's method. d = 2; w: weights of the certificate. */
void dlsi_friction_start(const dls_contact *problem, const double *w, const double *r,
                         const double *u, double *z);

/* Does the work of dls_lemke_solve on an LCP that has been checked, without the last call of
 * progress. */
dls_status dlsi_lemke_run(dls_lemke *work, const dls_lcp *lcp, double *z, double *y,
                          dls_lemke_info *info);

/* Changes the limits of an existing workspace, from the next solve on. */
void dlsi_lemke_set_limits(dls_lemke *work, const dls_limits *limits);

/* Finds a vertex x (n) of { x >= 0 : C x = q }. Returns 1, 0 if that set is empty to 1e-10, -1 if
 * rounding keeps the simplex method from ending. C: (C | q) by rows, n x (n + 1), n <=
 * DLS_ENUMERATE_MAX. */
int dlsi_find_vertex(int n, const double *C, double *x);

/* Call it after dlsi_find_vertex returned 0. y (n) := a vector with y.C <= 0 and y.q > 0 up to
 * rounding: it proves that the polyhedron is empty. slack: y.C = 0 becomes y.C = -slack, where
 * entries of y are about 1. Returns 0 if rounding hides y. */
int dlsi_refute_vertex(int n, const double *C, double slack, double *y);

/* Call it after dlsi_find_vertex returned 1. Returns the dimension of the polyhedron, -1 if
 * rounding hides it. If it is > 0, low and high (count) := the least and largest a_i.x on the
 * polyhedron, -INFINITY or INFINITY if unbounded. a: count rows of n. */
int dlsi_spread(int n, const double *C, int count, const double *a, double *low, double *high);

/* From the next solve on, `judge` decides whether v (n), a Farkas vector up to rounding, proves
 * that there is no solution. NULL: dlsi_lcp_find_proof. For an LCP computed from another problem,
 * for whose numbers the proof has to hold. judge may overwrite v; work: n. */
typedef int dlsi_judge(void *problem, double *v, double *work);
void dlsi_lemke_set_judge(dls_lemke *work, dlsi_judge *judge, void *problem);

#endif
