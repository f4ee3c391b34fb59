/* stiffness.h: small stiffness matrices by hand, for models in either storage. */
#ifndef STIFFNESS_H
#define STIFFNESS_H

#include "delassus/model.h"

enum { stiffness_most = 300, stiffness_dense_most = 40 };

/* K dense with a leading dimension of n + 1, with 64 where nothing is to be read; or sparse, each
 * entry in a quarter and three quarters, rows backwards. */
typedef struct stiffness {
  int n, p[stiffness_most + 1], i[2 * stiffness_dense_most * stiffness_dense_most];
  double a[stiffness_dense_most * (stiffness_dense_most + 1)];
  double x[2 * stiffness_dense_most * stiffness_dense_most];
  dls_model model; /* d = 2, without contact nodes */
} stiffness;

/* Fills S with K (n x n, by rows), n <= stiffness_dense_most. */
void stiffness_fill(stiffness *S, int n, const double *rows, dls_factorization factorization,
                    int is_sparse);

#endif
