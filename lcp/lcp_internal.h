/*
 * lcp_internal.h: what the files of lcp/ share: the measure of an LCP's answer, the scaling of an
 * LCP, and the table of Lemke's method.
 */
#ifndef LCP_INTERNAL_H
#define LCP_INTERNAL_H

#include "delassus/lcp.h"

/* ---- lcp.c ----------------------------------------------------------------------------------- */

dls_status dlsi_check_lcp(const char *function, const dls_lcp *lcp, dls_error *error);

/* y := M z + q, a := |M||z|; q = NULL for none. */
void dlsi_lcp_multiply(const dls_lcp *lcp, const double *q, const double *z, double *y, double *a);

/* s_i = |M_ii|, or max_j |M_ij| where M_ii = 0, or 1 for a zero row. */
void dlsi_lcp_weights(const dls_lcp *lcp, double *s);

/* The certificate of z from given y = M z + q, a = |M||z| and weights s. */
void dlsi_lcp_measure(const dls_lcp *lcp, const double *z, const double *y, const double *a,
                      const double *s, dls_lcp_certificate *certificate);

/* The violations of dls_lcp_check_ray and dls_lcp_check_farkas; work: 6 n and 0 doubles. */
double dlsi_lcp_ray_violation(const dls_lcp *lcp, const double *cover, const double *z, double z0,
                              const double *dz, double dz0, double *work);
double dlsi_lcp_farkas_violation(const dls_lcp *lcp, const double *v);

/* ---- scale.c --------------------------------------------------------------------------------- */

/* Exponents rho (rows), gamma (columns) such that the entries 2^(rho_i + gamma_j) |M_ij| that are
 * not 0 have geometric mean 1 in every row and column, nearly, negligible ones being raised
 * (scale.c, S4). work: 9 n doubles. */
void dlsi_lcp_equilibrate(const dls_lcp *lcp, double *rho, double *gamma, double *work);

/* ---- table.c --------------------------------------------------------------------------------- */

enum { dlsi_table_block = 96 }; /* exchanges put off */

/* Variables are numbered: y_i is i, z_i is n + i, z0 is 2 n. See table.c for (E3), (E4). */
typedef struct dlsi_table {
  int n, ld;
  double *T;   /* ld x (n+1): coefficients, but for the pending exchanges */
  double *U;   /* n x block */
  double *L;   /* block x block, lower triangle */
  double *V;   /* block x (n+1), while flushing */
  double *W;   /* block x (n+1), the right-hand side of (E4) */
  int pending; /* exchanges put off */
  int *row;    /* block: their rows */
  int *born;   /* n+1: the last one of them in this column, -1 if none */
  double *b;   /* n: values of the basic variables */
  double *g;   /* n: their derivative by the perturbation */
  int *basic;  /* n: variable of each row */
  int *column; /* n+1: variable of each column */
  int *where;  /* 2n+1: row of a basic variable, -1 - column of another */
} dlsi_table;

/* c (n) := column s of A */
void dlsi_table_column(const dlsi_table *t, int s, double *c);

/* Exchanges the variables of row r and column s; c: column s as above, c[r] != 0. */
void dlsi_table_exchange(dlsi_table *t, int r, int s, const double *c);

/* dx (n) := how the basic variables move when each y_i that is not basic moves by dy_i (n) */
void dlsi_table_move_y(const dlsi_table *t, const double *dy, double *dx);

#endif
