/*
 * units.c: takes the units out of a contact problem whose squares would leave the range of numbers.
 *
 *   W' = 2^-W W,  q' = 2^-q q;  then u' = 2^-q u and r' = 2^(W - q) r
 *
 * Powers of two keep every bit: a solve, a proof or a norm on the copy is the same in any unit.
 * Problems whose largest diagonal entry of W and largest q lie within 2^-64 .. 2^64 are not copied:
 * fourth powers are in range there.
 *
 * What can fail: a copy needs memory; entries 2^1000 apart are not all in range in any unit, and
 * the problem is not copied then.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "contact.h"

enum { plain_power = 64 };

void dlsi_shift(size_t n, int power, const double *x, double *y) {
  for (size_t i = 0; i < n; i++)
    y[i] = ldexp(x[i], power);
}

int dlsi_shift_exactly(size_t n, int power, const double *x, double *y) {
  int exact = 1;
  for (size_t i = 0; i < n; i++) {
    const double given = x[i];
    y[i] = ldexp(given, power);
    exact &= ldexp(y[i], -power) == given;
  }
  return exact;
}

/* Returns the power of two of x, `known` for 0. */
static int power_of(double x, int known) {
  return x > 0 ? ilogb(x) : known;
}

double dlsi_largest_value(const dls_contact *problem) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  double largest = 0;
  if (problem->Wb.x) return dlsi_max_abs(problem->Wb.x, d * d * (size_t)problem->Wb.p[problem->nc]);
  for (size_t j = 0; j < m; j++)
    largest = fmax(largest, dlsi_max_abs(problem->W.a + j * (size_t)problem->W.ld, m));
  return largest;
}

/* Returns the power of two, an even one, of the largest diagonal entry of W. */
static int power_of_W(const dls_contact *problem, int known) {
  const int d = problem->d;
  if (problem->bodies.H) {
    const size_t size = (size_t)problem->bodies.n * (size_t)d;
    double H = 0;
    for (size_t k = 0; k < 2 * (size_t)problem->nc; k++)
      if (problem->bodies.body[k] >= 0)
        H = fmax(H, dlsi_max_abs(problem->bodies.H + k * size, size));
    return H > 0 ? 2 * ilogb(H) : known;
  }
  double largest = 0, block[9] = {0};
  for (int c = 0; c < problem->nc; c++) {
    dlsi_contact_diagonal(problem, c, block);
    for (int i = 0; i < d; i++)
      largest = fmax(largest, fabs(block[i * (d + 1)]));
  }
  if (!(largest > 0)) largest = dlsi_largest_value(problem);
  return power_of(largest, known) / 2 * 2;
}

static int is_within(int power, int of) {
  return abs(power - of) <= plain_power;
}

int dlsi_has_plain_units(const dls_contact *problem) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  return is_within(power_of_W(problem, 0), 0) &&
         is_within(power_of(dlsi_max_abs(problem->q, m), 0), 0);
}

/* Chooses the powers: those of the last problem, if they do; 0, if they do; those of the data. */
static void choose_powers(dlsi_units *units, const dls_contact *problem) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const int W = power_of_W(problem, units->W);
  const int q = power_of(dlsi_max_abs(problem->q, m), units->q);
  if (is_within(W, units->W) && is_within(q, units->q)) return;
  const int plain = is_within(W, 0) && is_within(q, 0);
  units->W = plain ? 0 : W;
  units->q = plain ? 0 : q;
}

/* Copies the values of W, weights and q. Returns 0 if one of them leaves the range of
 * numbers, or loses bits at its lower end. */
static int copy_values(dlsi_units *units, const dls_contact *given, size_t values) {
  const size_t d = (size_t)given->d, nc = (size_t)given->nc, m = d * nc;
  double *W = units->values, *q = W + values, *weights = q + m;
  dls_contact *copy = &units->problem;
  int exact = 1;
  *copy = *given;
  if (given->bodies.H) {
    const size_t size = (size_t)given->bodies.n * d;
    memset(W, 0, values * sizeof *W); /* H of a fixed body is not read */
    for (size_t k = 0; k < 2 * nc; k++)
      if (given->bodies.body[k] >= 0)
        exact &= dlsi_shift_exactly(size, -units->W / 2, given->bodies.H + k * size, W + k * size);
    copy->bodies.H = W;
  } else if (given->Wb.x) {
    exact &= dlsi_shift_exactly(values, -units->W, given->Wb.x, W);
    copy->Wb.x = W;
  } else {
    for (size_t j = 0; j < m; j++)
      exact &= dlsi_shift_exactly(m, -units->W, given->W.a + j * (size_t)given->W.ld, W + j * m);
    copy->W = (dls_dense){(int)m, (int)m, (int)m, W};
  }
  exact &= dlsi_shift_exactly(m, -units->q, given->q, q);
  copy->q = q;
  if (given->weights) exact &= dlsi_shift_exactly(2 * nc, -units->W, given->weights, weights);
  if (given->weights) copy->weights = weights;
  const size_t count = values + m + (given->weights ? 2 * nc : 0);
  return exact && dlsi_first_not_finite(units->values, count) < 0;
}

dls_status dlsi_take_units(dlsi_units *units, const dls_contact **problem, dls_error *error) {
  const dls_contact *given = *problem;
  const size_t d = (size_t)given->d, nc = (size_t)given->nc, m = d * nc;
  if (nc == 0) return DLS_OK;
  choose_powers(units, given);
  if (!units->W && !units->q) return DLS_OK;
  const size_t values = given->bodies.H ? 2 * (size_t)given->bodies.n * m
                        : given->Wb.x   ? d * d * (size_t)given->Wb.p[nc]
                                        : m * m;
  double *room = dlsi_make_room(units->values, &units->room, values + 4 * m + 2 * nc, sizeof *room);
  if (!room) return dlsi_no_memory(error);
  units->values = room;
  units->r = room + values + m + 2 * nc;
  units->u = units->r + m;
  units->shown = units->u + m;
  if (copy_values(units, given, values))
    *problem = &units->problem;
  else
    units->W = units->q = 0;
  return DLS_OK;
}

dls_status dlsi_take_answer(dlsi_units *units, const dls_contact **problem, const double **r,
                            dls_error *error) {
  const dls_contact *given = *problem;
  const dls_status status = dlsi_take_units(units, problem, error);
  if (status || *problem == given) return status;
  const size_t m = (size_t)given->d * (size_t)given->nc;
  if (dlsi_shift_exactly(m, units->W - units->q, *r, units->r)) {
    *r = units->r;
    return DLS_OK;
  }
  units->W = units->q = 0; /* an r far from any answer */
  *problem = given;
  return DLS_OK;
}

void dlsi_certificate_from_units(const dlsi_units *units, dls_certificate *c) {
  const int W = units->W, q = units->q;
  c->penetration = ldexp(c->penetration, q);
  c->slip_direction = ldexp(c->slip_direction, q);
  c->adhesion = ldexp(c->adhesion, q - W);
  c->cone_violation = ldexp(c->cone_violation, q - W);
  c->complementarity = ldexp(c->complementarity, 2 * q - W);
}

void dlsi_units_free(dlsi_units *units) {
  free(units->values);
  *units = (dlsi_units){.W = 0};
}
