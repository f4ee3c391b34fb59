/* reduced.h: makes a reduction for the front, and gives it what it needs of one to solve on K. */
#ifndef DLSI_REDUCED_H
#define DLSI_REDUCED_H

#include "delassus/reduction.h"
#include "linear/operator.h"

typedef struct dlsi_reduced {
  int has_K;
  dls_model K; /* a view: n, operator_kind, factorization, K or Ks */
  const dlsi_operator *H;
  const double *f, *gap; /* the last load: n, m */
  const double *mu;      /* of the model, or NULL */
  const double *w;       /* weights of the contacts, 2 nc */
  int nodes, space;      /* contact nodes; entries of g for each */
  void *companion;       /* NULL: none is kept */
  int is_stale;          /* 1: the companion has the values before the last update, on K alone */
  int on_K;              /* 1: there is no W */
} dlsi_reduced;

/* Does the work of dls_reduction_create on K if settings->on is DLS_ON_K, else on W. *out = NULL
 * after an error. settings: NULL for the defaults. */
dls_status dlsi_reduction_create(dls_reduction **out, const dls_model *model,
                                 const dls_reduction_settings *settings, dls_error *error);

dlsi_reduced dlsi_reduction_body(dls_reduction *reduction);

/* Works as dls_reduction_certify, and looks closer if the pair does not hold at `tol`. */
dls_status dlsi_reduction_certify(dls_reduction *reduction, const double *mu, const double *r,
                                  const double *x, double tol, double *u,
                                  dls_certificate *certificate, dls_error *error);

/* Keeps an object that belongs to these values of K and H: until the next update, or without W
 * until destroy. */
void dlsi_reduction_keep(dls_reduction *reduction, void *companion, void (*destroy)(void *));

#endif
