/* lcp_of.h: an LCP over a matrix and a vector of the test. */
#ifndef LCP_OF_H
#define LCP_OF_H

#include "delassus/lcp.h"

/* M: n x n, column-major; q: n */
static inline dls_lcp lcp_of(int n, const double *M, const double *q) {
  return (dls_lcp){.n = n, .M = {n, n, n, M}, .q = q};
}

#endif
