/*
 * weighting.c: the weighting P of a contact line, [J] 4.4 example 2, for any spacing, and of a line
 * of quadratic edges. A rectangular grid of faces has the Kronecker product of two lines.
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
 *
 * Quadratic edges, corners at 0 and 1 and a middle node at 1/2 of the edge's length a:
 *
 *   N_0 = (1 - t)(1 - 2t),  N_m = 4 t (1 - t),  N_1 = t (2t - 1)
 *
 * The dual cell of a corner reaches a quarter into its edges, that of a middle node from 1/4 to
 * 3/4. Integrals over [0, 1/4]: a/6, 5a/48, -a/48; over [1/4, 3/4]: a/48, 11a/24, a/48. With M =
 * (a + b)/4 and a/2 the columns are, from corner to corner,
 *
 *   corner  -(1/12) a/(a+b), (5/12) a/(a+b), 2/3, (5/12) b/(a+b), -(1/12) b/(a+b)
 *   middle  1/24, 11/12, 1/24
 *
 * Each corner has an entry < 0: N_1 < 0 on [0, 1/2], whatever cell of a corner ends there. chi_j
 * >= 0 is all that [J] 4.3 needs of the laws; what is lost is proposition 2, P r >= 0.
 */
#include <limits.h>
#include <math.h>

#include "contact/contact.h"
#include "delassus/reduction.h"

/* Distance of a middle node from the middle of its edge, over the edge: more than rounding. */
static const double most_off = 1e-6;

/* A line and the names of its arguments. */
typedef struct line {
  int order, nodes;
  const double *s;
  const int *candidate;
  const char *name[3]; /* of nodes, s, candidate */
} line;

/* Checks the line; the number of its candidates must be > 0. Of order 2 it has whole edges, and
 * each middle node is the middle of its edge. */
static dls_status weighting_check(const line *of, int least, dls_error *error) {
  const int nodes = of->nodes;
  const double *s = of->s;
  if (nodes < least || nodes > INT_MAX / 4)
    return dlsi_fail(error, DLS_E_SIZE, of->name[0], -1, nodes, "is %d", nodes);
  const dls_status status = dlsi_check_vector(of->name[1], s, (size_t)nodes, error);
  if (status) return status;
  int count = 0;
  for (int k = 0; k < nodes; k++) {
    if (k > 0 && !(s[k] > s[k - 1] && isfinite(s[k] - s[k - 1])))
      return dlsi_fail(error, DLS_E_ARGUMENT, of->name[1], k, s[k],
                       "does not follow %g in strictly increasing order", s[k - 1]);
    count += !of->candidate || of->candidate[k];
  }
  if (count == 0) return dlsi_fail(error, DLS_E_ARGUMENT, of->name[2], -1, 0, "names no candidate");
  if (of->order == 1) return DLS_OK;
  if (nodes % 2 == 0)
    return dlsi_fail(error, DLS_E_SIZE, of->name[0], -1, nodes, "is %d, not odd", nodes);
  for (int k = 1; k < nodes; k += 2) {
    const double a = s[k + 1] - s[k - 1];
    if (!(fabs(s[k] - s[k - 1] - a / 2) <= most_off * a))
      return dlsi_fail(error, DLS_E_ARGUMENT, of->name[1], k, s[k],
                       "is not the middle between %g and %g", s[k - 1], s[k + 1]);
  }
  return DLS_OK;
}

/* A column of P: its entries at the nodes -reach .. reach from its own, of five, and its M. */
typedef struct column {
  int reach;
  double M, weight[5];
} column;

static column column_of_line(int nodes, const double *s, int k) {
  const double a = k > 0 ? s[k] - s[k - 1] : 0, b = k < nodes - 1 ? s[k + 1] - s[k] : 0;
  const double M = a / 2 + b / 2;
  return (column){1, M, {0, (a / 2 / M) / 4, 0.75, (b / 2 / M) / 4}};
}

static column column_of_quadratic(int nodes, const double *s, int k) {
  const int middle = k % 2, reach = middle ? 1 : 2;
  const double a = k > 0 ? s[k] - s[k - reach] : 0, b = k < nodes - 1 ? s[k + reach] - s[k] : 0;
  const double M = middle ? a / 2 + b / 2 : a / 4 + b / 4, left = a / 4 / M, right = b / 4 / M;
  if (middle) return (column){1, M, {0, 1. / 24, 11. / 12, 1. / 24}};
  return (column){2, M, {-left / 12, 5 * left / 12, 2. / 3, 5 * right / 12, -right / 12}};
}

static column column_of(const line *of, int k) {
  if (of->nodes == 1) return (column){0, 1, {0, 0, 1}};
  return of->order == 1 ? column_of_line(of->nodes, of->s, k)
                        : column_of_quadratic(of->nodes, of->s, k);
}

/* Checks the outputs and fills the product of two lines that have been checked. */
static dls_status weighting_fill(const line *first, const line *second, int *p, int *i, double *x,
                                 double *measure, int *columns, dls_error *error) {
  if (!p || !i || !x || !columns)
    return dlsi_is_null(error, !p ? "p" : !i ? "i" : !x ? "x" : "columns");
  int j = 0, e = 0;
  p[0] = 0;
  for (int b = 0; b < second->nodes; b++) {
    if (second->candidate && !second->candidate[b]) continue;
    const column B = column_of(second, b);
    for (int a = 0; a < first->nodes; a++) {
      if (first->candidate && !first->candidate[a]) continue;
      const column A = column_of(first, a);
      for (int l = -B.reach; l <= B.reach; l++)
        for (int k = -A.reach; k <= A.reach; k++) {
          if (a + k < 0 || a + k >= first->nodes || b + l < 0 || b + l >= second->nodes) continue;
          i[e] = a + k + first->nodes * (b + l);
          x[e++] = A.weight[k + 2] * B.weight[l + 2];
        }
      if (measure) measure[j] = A.M * B.M;
      p[++j] = e;
    }
  }
  *columns = j;
  return DLS_OK;
}

static dls_status weighting_line(const line *of, int *p, int *i, double *x, double *length,
                                 int *columns, dls_error *error) {
  const line one = {.order = 1, .nodes = 1};
  const dls_status status = weighting_check(of, 2, error);
  return status ? status : weighting_fill(of, &one, p, i, x, length, columns, error);
}

dls_status dls_weighting_line(int nodes, const double *s, const int *candidate, int *p, int *i,
                              double *x, double *length, int *columns, dls_error *error) {
  DLSI_DOOR;
  const line of = {1, nodes, s, candidate, {"nodes", "s", "candidate"}};
  return dlsi_at(__func__, weighting_line(&of, p, i, x, length, columns, error), error);
}

dls_status dls_weighting_quadratic(int nodes, const double *s, const int *candidate, int *p, int *i,
                                   double *x, double *length, int *columns, dls_error *error) {
  DLSI_DOOR;
  const line of = {2, nodes, s, candidate, {"nodes", "s", "candidate"}};
  return dlsi_at(__func__, weighting_line(&of, p, i, x, length, columns, error), error);
}

dls_status dls_weighting_face(int order, int nodes_s, const double *s, const int *candidate_s,
                              int nodes_t, const double *t, const int *candidate_t, int *p, int *i,
                              double *x, double *area, int *columns, dls_error *error) {
  DLSI_DOOR;
  const line first = {order, nodes_s, s, candidate_s, {"nodes_s", "s", "candidate_s"}};
  const line second = {order, nodes_t, t, candidate_t, {"nodes_t", "t", "candidate_t"}};
  dls_status status = DLS_OK;
  if (order != 1 && order != 2)
    status = dlsi_fail(error, DLS_E_ARGUMENT, "order", -1, order, "is %d, not 1 or 2", order);
  if (!status) status = weighting_check(&first, 1, error);
  if (!status) status = weighting_check(&second, 1, error);
  if (!status && nodes_t > INT_MAX / 16 / nodes_s)
    status = dlsi_fail(error, DLS_E_SIZE, "nodes_t", -1, nodes_t, "is %d: too many nodes", nodes_t);
  if (!status) status = weighting_fill(&first, &second, p, i, x, area, columns, error);
  return dlsi_at(__func__, status, error);
}
