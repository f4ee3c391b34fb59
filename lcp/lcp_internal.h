/*
 * lcp_internal.h: what the files of lcp/ share: the measure of an LCP's answer, the scaling of an
 * LCP, and the table of Lemke's method.
 */
#ifndef LCP_INTERNAL_H
#define LCP_INTERNAL_H

#include "base/base.h"
#include "delassus/lcp.h"

/* ---- lcp.c ----------------------------------------------------------------------------------- */

dls_status dlsi_check_lcp(const dls_lcp *lcp, dls_error *error);

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

/* ---- crash.c --------------------------------------------------------------------------------- */

/* See crash.c for (K1)-(K5). */
typedef struct dlsi_crash {
  const double *s;      /* n: weights of the certificate */
  double *S;            /* n x n: the factors of M_00, k x k; then Y, G, T and a product */
  double *G, *T;        /* in S: M_E0, e x k; the matrix of (K5), h x h, factorised */
  double *z, *y, *a;    /* n: (K1), |M||z| */
  double *b, *x, *v;    /* n */
  int *in, *wrong;      /* n: 1 in A; 1 for a negative z_i or y_i */
  int *base, *pivots;   /* k: A_0, ascending */
  int *place;           /* n: of an index in A_0, -1 outside */
  int *slot;            /* n: its column of Y, -1 if it has none */
  int *differ;          /* h: E, then D */
  int *differ_pivots;   /* h */
  int k, columns, h, e; /* |A_0|; of Y; |D| + |E|; |E| */
  int rounds, fewest, chances;
} dlsi_crash;

/* The caller has set s, `in` and the memory, of which S, z, y, a, b, x, v and eight arrays of n int are
 * to be n long at least. */
void dlsi_crash_begin(const dls_lcp *lcp, dlsi_crash *w);

/* One round: 0 to go on, 1 if z solves the LCP but for rounding, -1 if this leads nowhere. */
int dlsi_crash_round(const dls_lcp *lcp, dlsi_crash *w);

/* ---- tiny.c ---------------------------------------------------------------------------------- */

enum { dlsi_tiny_size = 10 };

/* n <= dlsi_tiny_size. 1 with z >= 0, in all likelihood a solution but for rounding; 0 if it gave up, after
 * `limit` exchanges at the latest. */
int dlsi_lcp_tiny(const dls_lcp *lcp, int limit, double *z, int *exchanges);

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

/* ---- lcp/friction.c ---------------------------------------------------------------------------- */

/* z (dls_contact_lcp_size) := 1 where the 3-row form's unknown is positive by the states of (u, r), 0
 * elsewhere: a start for Lemke. d = 2; w: weights of the certificate. */
void dlsi_friction_start(const dls_contact *problem, const double *w, const double *r,
                         const double *u, double *z);

/* Changes the limits of an existing workspace, from the next solve on. */
void dlsi_lemke_set_limits(dls_lemke *work, const dls_limits *limits);

#endif
