/*
 * lemke_peer.c: Lemke's method of Siconos Numerics, which only this file of bench/lemke uses.
 */
#include <stdlib.h>
#include <string.h>

#include <LCP_Solvers.h>
#include <LinearComplementarityProblem.h>
#include <NonSmoothDrivers.h>
#include <NumericsMatrix.h>
#include <NumericsVerbose.h>
#include <SolverOptions.h>
#include <lcp_cst.h>

#include "common.h"
#include "lemke.h"

int peer_lemke(int n, double *M, double *q, int calls, double *z, double *w, double *cpu,
               int *pivots) {
  NumericsMatrix *A = NM_create_from_data(NM_DENSE, n, n, M);
  SolverOptions *options = solver_options_create(SICONOS_LCP_LEMKE);
  int status = -1;
  if (A && options) {
    LinearComplementarityProblem lcp = {.size = n, .M = A, .q = q};
    numerics_set_verbose(0);
    options->iparam[SICONOS_IPARAM_MAX_ITER] = 50 * n + 1000; /* the default of dls_lemke */
    options->filterOn = false; /* its own check of the answer is not timed */
    const double start = bench_seconds();
    for (int k = 0; k < calls; k++) {
      memset(z, 0, (size_t)n * sizeof *z);
      memset(w, 0, (size_t)n * sizeof *w);
      status = linearComplementarity_driver(&lcp, z, w, options);
    }
    *cpu = (bench_seconds() - start) / calls;
    *pivots = options->iparam[SICONOS_IPARAM_ITER_DONE];
  }
  if (options) solver_options_delete(options); /* what it points to */
  free(options);
  if (A) free(NM_free_not_dense(A)); /* M is the caller's */
  return status;
}
