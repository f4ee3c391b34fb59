/*
 * weighting.c: the weighting P of a contact line, [J] 4.4 example 2, for any spacing.
 *
 *   chi_j  = 1 on the dual cell of contact j: half of the segment a before its node, half of
 *            b after it
 *   M_j    = integral of chi_j = (a + b) / 2
 *   P_ij   = (1 / M_j) integral of hat_i chi_j
 *
 * On the half segment next to node j, hat_j runs from 1 to 1/2 and the neighbour's from 0 to 1/2:
 * their integrals are 3 a/8 and a/8. Hence (1/4) a/(a+b), 3/4, (1/4) b/(a+b); a = 0 at the first
 * node of the surface, b = 0 at the last. A neighbour that is no candidate takes its share, too.
 * The paper does not show this case: both ends of its print are candidates.
 */
#include <limits.h>
#include <math.h>

#include "base/base.h"
#include "delassus/reduction.h"

/* Checks the line; the number of its candidates must be > 0. */
static dls_status weighting_check(int nodes, const double *s, const int *candidate,
                                  dls_error *error) {
  if (nodes < 2 || nodes > INT_MAX / 3)
    return dlsi_fail(error, DLS_E_SIZE, "nodes", -1, nodes, "is %d", nodes);
  const dls_status status = dlsi_check_vector("s", s, (size_t)nodes, error);
  if (status) return status;
  int count = 0;
  for (int k = 0; k < nodes; k++) {
    if (k > 0 && !(s[k] > s[k - 1] && isfinite(s[k] - s[k - 1])))
      return dlsi_fail(error, DLS_E_ARGUMENT, "s", k, s[k],
                       "does not follow %g in strictly increasing order", s[k - 1]);
    count += !candidate || candidate[k];
  }
  if (count > 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_ARGUMENT, "candidate", -1, 0, "names no candidate");
}

dls_status dls_weighting_line(int nodes, const double *s, const int *candidate, int *p, int *i,
                              double *x, double *length, int *columns, dls_error *error) {
  DLSI_DOOR;
  dls_status status = weighting_check(nodes, s, candidate, error);
  if (!status && (!p || !i || !x || !columns))
    status = dlsi_is_null(error, !p ? "p" : !i ? "i" : !x ? "x" : "columns");
  if (status) return dlsi_at(__func__, status, error);

  int j = 0, e = 0;
  p[0] = 0;
  for (int k = 0; k < nodes; k++) {
    if (candidate && !candidate[k]) continue;
    const double a = k > 0 ? s[k] - s[k - 1] : 0, b = k < nodes - 1 ? s[k + 1] - s[k] : 0;
    const double M = a / 2 + b / 2;
    if (k > 0) {
      i[e] = k - 1;
      x[e++] = (a / 2 / M) / 4;
    }
    i[e] = k;
    x[e++] = 0.75;
    if (k < nodes - 1) {
      i[e] = k + 1;
      x[e++] = (b / 2 / M) / 4;
    }
    if (length) length[j] = M;
    p[++j] = e;
  }
  *columns = j;
  return DLS_OK;
}
