#include "stiffness.h"

#include <string.h>

void stiffness_fill(stiffness *S, int n, const double *rows, dls_factorization factorization,
                    int is_sparse) {
  int e = 0;
  memset(S, 0, sizeof *S);
  S->n = n;
  for (int k = 0; k < n * (n + 1); k++)
    S->a[k] = 64;
  for (int j = 0; j < n; j++) {
    S->p[j] = e;
    for (int turn = 0; turn < 2; turn++)
      for (int i = n - 1; i >= 0; i--) {
        const double entry = rows[j + n * i];
        S->a[i + j * (n + 1)] = entry;
        if (entry == 0) continue;
        S->i[e] = i;
        S->x[e++] = (turn ? 0.75 : 0.25) * entry;
      }
  }
  S->p[n] = e;
  S->model = (dls_model){.d = 2,
                         .n = n,
                         .operator_kind = is_sparse ? DLS_STIFFNESS_SPARSE : DLS_STIFFNESS_DENSE,
                         .factorization = factorization,
                         .K = {n, n, n + 1, S->a},
                         .Ks = {n, n, S->p, S->i, S->x}};
}
