/*
 * renumber.c: solves a copy of a small contact problem, in an order and in units that follow from
 * its data, from r = 0, after the first plan has failed.
 *
 * Stages that succeed by luck depend on the order of the candidates through rounding and ties, and
 * on the unit of W through square roots. On this copy they do the same, to the bit, however the
 * candidates are numbered and whatever powers of two W and q are multiplied by.
 *
 *   (RN1)  W and q over the powers of two below their largest entries; W dense
 *   (RN2)  a code of 64 bits per candidate: of the bits of q_c, mu_c, W_cc; then, as often as the
 *          number of different codes grows, of the code before and the sum over the others of codes
 *          of (code of a, W_ca, W_ac), which does not depend on their order
 *   (RN3)  while some codes are equal, the first of the smallest such code gets one of its own, and
 *          (RN2) goes on. What is left to the given order so is which of the candidates comes first
 *          that the whole problem does not tell apart
 *   (RN4)  by code, then by the order of vi/sweep/order.c, which follows the mechanics
 *
 * Frictions above 1e4, also infinite ones, are first 1e4 there, which pivots and paths can handle.
 * An answer in which these contacts do not slip is an answer of the problem.
 *
 * Source: colour refinement, Weisfeiler and Leman, Nauchno-Technicheskaya Informatsiya 2 (9), 1968,
 * 12-16. Cost: nc^2 d^2 per round; usually two rounds.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "auto/auto.h"

void dlsi_renumber_carve(dlsi_renumber *copy, dlsi_arena *arena, int d, int nc) {
  const size_t n = (size_t)nc, m = (size_t)d * n, D = sizeof(double);
  copy->W = dlsi_take(arena, m, m * D);
  copy->q = dlsi_take(arena, m, D);
  copy->mu = dlsi_take(arena, n, D);
  copy->weights = dlsi_take(arena, 2 * n, D);
  for (int k = 0; k < 3; k++)
    copy->key[k] = dlsi_take(arena, n, D);
  copy->code = dlsi_take(arena, 2 * n, sizeof *copy->code);
  copy->from = dlsi_take(arena, 3 * n, sizeof *copy->from);
}

/* Mixes the bits of x into the code h. */
static uint64_t code_mix(uint64_t h, uint64_t x) {
  return dlsi_mix((h ^ x) + DLSI_GOLDEN_BITS);
}

/* Mixes a number into h, 0 and -0 alike. */
static uint64_t code_add(uint64_t h, double x) {
  uint64_t bits;
  x += 0;
  memcpy(&bits, &x, sizeof bits);
  return code_mix(h, bits);
}

/* Mixes block W_ca of the dense W. */
static uint64_t code_block(uint64_t h, const dls_contact *p, int c, int a) {
  for (int j = 0; j < p->d; j++)
    for (int i = 0; i < p->d; i++)
      h = code_add(h, p->W.a[(size_t)(p->d * c + i) + (size_t)(p->d * a + j) * (size_t)p->W.ld]);
  return h;
}

static void code_begin(const dls_contact *p, uint64_t *code) {
  for (int c = 0; c < p->nc; c++) {
    code[c] = code_add(0, p->mu[c]);
    for (int i = 0; i < p->d; i++)
      code[c] = code_add(code[c], p->q[p->d * c + i]);
    code[c] = code_block(code[c], p, c, c);
  }
}

/* Takes one round of (RN2). next: scratch, nc. */
static void code_refine(const dls_contact *p, uint64_t *code, uint64_t *next) {
  for (int c = 0; c < p->nc; c++) {
    uint64_t sum = 0;
    for (int a = 0; a < p->nc; a++)
      if (a != c) sum += code_block(code_block(code_mix(0, code[a]), p, c, a), p, a, c);
    next[c] = code_mix(code[c], sum);
  }
  memcpy(code, next, (size_t)p->nc * sizeof *code);
}

/* Sorts order (nc) by code, and returns the number of different codes. */
static int code_sort(int nc, const uint64_t *code, int *order) {
  int different = nc > 0;
  for (int k = 1; k < nc; k++) { /* nc is at most some hundred, and mostly sorted already */
    const int c = order[k];
    int j = k;
    for (; j > 0 && code[order[j - 1]] > code[c]; j--)
      order[j] = order[j - 1];
    order[j] = c;
  }
  for (int k = 1; k < nc; k++)
    different += code[order[k]] != code[order[k - 1]];
  return different;
}

/* (RN2), (RN3); order (nc): in the order of the problem at first. */
static void code_order(const dls_contact *p, uint64_t *code, int *order) {
  code_begin(p, code);
  for (int different = code_sort(p->nc, code, order); different < p->nc;) {
    code_refine(p, code, code + p->nc);
    const int now = code_sort(p->nc, code, order);
    for (int k = 1; now == different && k < p->nc; k++) {
      if (code[order[k]] != code[order[k - 1]]) continue;
      code[order[k - 1]] = code_mix(code[order[k]], 1);
      break;
    }
    different = now == different ? code_sort(p->nc, code, order) : now;
  }
}

/* Returns the power of two that the largest of n numbers is over one by. */
static int unit_of(double largest) {
  return largest > 0 && isfinite(largest) ? ilogb(largest) : 0;
}

/* Fills W, q, mu from the problem, candidate c := from[c], over powers of two. */
static void renumber_fill(dlsi_renumber *copy, const dls_contact *problem, double most_mu) {
  const int d = problem->d, nc = problem->nc, m = d * nc;
  int *place = copy->from + 2 * nc;
  for (int c = 0; c < nc; c++)
    place[copy->from[c]] = c;
  memset(copy->W, 0, (size_t)m * (size_t)m * sizeof *copy->W);
  for (int c = 0; c < nc; c++) {
    const dlsi_block_column W = dlsi_contact_column(problem, (size_t)copy->from[c]);
    for (size_t k = W.begin; k < W.end; k++) {
      const double *block = W.x + k * W.step;
      double *to = copy->W + d * place[dlsi_row(&W, k)] + (size_t)(d * c) * (size_t)m;
      for (int j = 0; j < d; j++)
        for (int i = 0; i < d; i++)
          to[i + j * m] += ldexp(block[(size_t)i + (size_t)j * W.ld], -copy->power_W);
    }
    copy->mu[c] = fmin(problem->mu[copy->from[c]], most_mu);
    for (int i = 0; problem->weights && i < 2; i++)
      copy->weights[2 * c + i] = ldexp(problem->weights[2 * copy->from[c] + i], -copy->power_W);
    for (int i = 0; i < d; i++)
      copy->q[d * c + i] = ldexp(problem->q[d * copy->from[c] + i], -copy->power_q);
  }
}

void dlsi_renumber_set(dlsi_renumber *copy, const dls_contact *problem, double most_mu) {
  const int nc = problem->nc, m = problem->d * nc;
  int *given = copy->from, *order = copy->from + nc, *scratch = copy->from + 2 * nc;
  copy->power_W = unit_of(dlsi_largest_value(problem));
  copy->power_q = unit_of(dlsi_max_abs(problem->q, (size_t)m));
  copy->problem = (dls_contact){.d = problem->d,
                                .nc = nc,
                                .W = {m, m, m, copy->W},
                                .q = copy->q,
                                .mu = copy->mu,
                                .weights = problem->weights ? copy->weights : NULL};
  for (int c = 0; c < nc; c++)
    given[c] = order[c] = c;
  renumber_fill(copy, problem, most_mu);
  code_order(&copy->problem, copy->code, order);
  memcpy(given, order, (size_t)nc * sizeof *given);
  renumber_fill(copy, problem, most_mu);
  dlsi_order_candidates(&copy->problem, copy->key, scratch, order);
  for (int c = 0; c < nc; c++)
    scratch[c] = given[order[c]];
  memcpy(given, scratch, (size_t)nc * sizeof *given);
  renumber_fill(copy, problem, most_mu);
}

void dlsi_renumber_back(const dlsi_renumber *copy, int entries, int power, const double *x,
                        double *back) {
  for (int c = 0; c < copy->problem.nc; c++)
    for (int i = 0; i < entries; i++)
      back[entries * copy->from[c] + i] = ldexp(x[entries * c + i], power);
}

/* Turns to a copy of the problem, with r = 0 as the best. Returns the certificate of the best r of
 * the problem, which is work->kept then. */
static dls_certificate enter_copy(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const dls_certificate kept = work->info.certificate;
  memcpy(work->kept, work->best, m * sizeof *work->kept);
  memset(work->best, 0, m * sizeof *work->best);
  dlsi_renumber_set(&work->copy, problem, work->firm ? dlsi_auto_firm : INFINITY);
  work->problem = &work->copy.problem;
  work->info.certificate = dlsi_no_certificate;
  return kept;
}

/* Takes the vectors of the verdict back from the copy. */
static void take_back_vectors(dlsi_auto *work, dls_status status) {
  const dlsi_renumber *copy = &work->copy;
  const int excluded = work->excluded, proved = status == DLS_NO_SOLUTION;
  const double *delta = work->part[AUGMENTED] && !excluded && !proved
                            ? dlsi_augmented_method.direction(work->part[AUGMENTED])
                            : NULL;
  const double *v = proved || excluded ? dlsi_lemke_method.farkas(work->part[PIVOTING]) : NULL;
  work->has_direction = delta != NULL;
  work->has_farkas = v != NULL;
  if (delta) dlsi_renumber_back(copy, copy->problem.d, 0, delta, work->direction);
  if (v) dlsi_renumber_back(copy, 1, 0, v, work->farkas);
}

/* Takes the best r back from the copy if it is better than the one kept. Returns the status for the
 * problem. */
static dls_status leave_copy(dlsi_auto *work, const dls_contact *problem,
                             const dls_certificate *kept, dls_status status) {
  const dlsi_renumber *copy = &work->copy;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  dls_certificate *best = &work->info.certificate;
  work->problem = problem;
  dlsi_renumber_back(copy, problem->d, copy->power_q - copy->power_W, work->best, work->r);
  dlsi_contact_multiply(problem, NULL, work->r, work->v[0], work->v[1]);
  dlsi_auto_set_weights(work);
  dlsi_contact_measure(problem, work->r, work->v[0], work->v[1], work->weights, work->v[2], best);
  /* forces beyond the range of numbers: an answer to the copy is none to the problem */
  const int in_range = best->residual <= DBL_MAX && dlsi_first_not_finite(work->r, m) < 0;
  if (in_range && (status == DLS_OK || dlsi_is_better(best, kept))) {
    memcpy(work->best, work->r, m * sizeof *work->best);
  } else {
    memcpy(work->best, work->kept, m * sizeof *work->best);
    *best = *kept;
  }
  if (status == DLS_NO_SOLUTION_LIKELY && best->residual <= work->options.limits.tol)
    return DLS_STALLED; /* only rounding speaks against this answer */
  return status;
}

dls_status dlsi_auto_on_copy(dlsi_auto *work, dlsi_auto_run_fn run, const step *plan,
                             dls_error *error) {
  const dls_contact *problem = work->problem;
  const dls_certificate kept = enter_copy(work);
  const dls_status status = run(work, plan, error);
  if (status < 0) return status;
  if (work->has_copy) take_back_vectors(work, status);
  return leave_copy(work, problem, &kept, status);
}
