/*
 * hard_problems.c: hard contact problems in 3D, each with a known answer.
 *
 *   W = Q diag(eigenvalues) Q^T, Q from 30 reflections, eigenvalues from 1 to 1 / condition, spaced
 *   evenly in their logarithm; r and u that obey the laws are drawn first, and q = u - W r: a
 *   solution exists, to rounding. Contacts are free, stick or slip, one in three each.
 *
 *   none     as above
 *   rank     half of the eigenvalues are 0: r is not determined, u is
 *   border   contacts in thirds: r = 0 and u = 0; |r_t| = mu r_n and u = 0; stick
 *   bonded   mu = INFINITY for every second contact
 */
#include <math.h>
#include <stdlib.h>

#include "hard.h"
#include "regret_kinds.h"

const char *hard_flaw_name(hard_flaw flaw) {
  static const char *const name[HARD_FLAWS] = {"none", "rank", "border", "bonded"};
  return name[flaw];
}

/* Moves the drawn answer of contact c to the border of two states. */
static void put_on_border(int c, double mu, double *r, double *u) {
  const double size = hypot(r[1], r[2]);
  for (int i = 0; i < 3; i++)
    u[i] = 0;
  if (c % 3 == 0) r[0] = r[1] = r[2] = 0;
  if (c % 3 == 1 && size > 0) {
    r[1] *= mu * r[0] / size;
    r[2] *= mu * r[0] / size;
  }
}

int hard_create(hard_problem *p, int nc, double condition, double mu, hard_flaw flaw,
                uint64_t seed) {
  const size_t m = 3 * (size_t)nc;
  uint64_t state = regret_state(seed, 77 + (uint64_t)flaw);
  *p = (hard_problem){.W = calloc(m * m, sizeof *p->W),
                      .q = calloc(m, sizeof *p->q),
                      .mu = calloc((size_t)nc, sizeof *p->mu),
                      .r = calloc(2 * m, sizeof *p->r)};
  double *u = p->r ? p->r + m : NULL;
  if (!p->W || !p->q || !p->mu || !p->r ||
      regret_spectrum(p->W, (int)m, (int)(flaw == HARD_RANK ? m / 2 : m), condition, &state)) {
    hard_free(p);
    return -1;
  }
  for (int c = 0; c < nc; c++) {
    p->mu[c] = flaw == HARD_BONDED && c % 2 ? INFINITY : mu;
    regret_plant(3, p->mu[c], &state, p->r + 3 * c, u + 3 * c);
    if (flaw == HARD_BORDER) put_on_border(c, mu, p->r + 3 * c, u + 3 * c);
  }
  for (size_t i = 0; i < m; i++)
    p->q[i] = u[i];
  for (size_t j = 0; j < m; j++)
    for (size_t i = 0; i < m; i++)
      p->q[i] -= p->W[i + j * m] * p->r[j];
  p->contact =
      (dls_contact){.d = 3, .nc = nc, .W = {(int)m, (int)m, (int)m, p->W}, .q = p->q, .mu = p->mu};
  return 0;
}

void hard_free(hard_problem *p) {
  free(p->W);
  free(p->q);
  free(p->mu);
  free(p->r);
  *p = (hard_problem){0};
}
