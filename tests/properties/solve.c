/*
 * solve.c: one run: the problem in another order, unit or storage, a method, and its answer in the
 * original ones.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "delassus/facets.h"
#include "delassus/lcp.h"
#include "delassus/trust.h"

/* The problem as the library gets it. */
typedef struct room {
  int d, nc, m, from[NC_MAX]; /* candidate c is from[c] of the problem */
  double *W, q[M_MAX], mu[NC_MAX], r[M_MAX];
  int p[NC_MAX + 1], *i;
  double *x;
  dls_contact contact;
} room;

static room *room_create(const problem *p) {
  room *at = problem_alloc(sizeof *at);
  const size_t m = (size_t)p->m, nc = (size_t)p->nc;
  at->W = problem_alloc(m * m * sizeof *at->W);
  at->x = problem_alloc(m * m * sizeof *at->x);
  at->i = problem_alloc(nc * nc * sizeof *at->i);
  return at;
}

static void room_destroy(room *at) {
  free(at->W);
  free(at->x);
  free(at->i);
  free(at);
}

static void room_fill(room *at, const problem *p, const run *how) {
  dice g = {how->seed};
  at->d = p->d, at->nc = p->nc, at->m = p->m;
  for (int c = 0; c < p->nc; c++)
    at->from[c] = c;
  for (int c = p->nc - 1; how->shuffle && c > 0; c--) {
    const int k = dice_below(&g, c + 1), swap = at->from[c];
    at->from[c] = at->from[k];
    at->from[k] = swap;
  }
  for (int j = 0; j < p->m; j++) {
    const size_t m = (size_t)p->m;
    const int from_j = p->d * at->from[j / p->d] + j % p->d;
    at->q[j] = ldexp(p->q[from_j], how->power_q);
    at->mu[j / p->d] = p->mu[from_j / p->d];
    for (int i = 0; i < p->m; i++) {
      const int from_i = p->d * at->from[i / p->d] + i % p->d;
      at->W[(size_t)i + (size_t)j * m] =
          ldexp(p->W[(size_t)from_i + (size_t)from_j * m], how->power_W);
    }
  }
  at->contact = (dls_contact){
      .d = p->d, .nc = p->nc, .W = {p->m, p->m, p->m, at->W}, .q = at->q, .mu = at->mu};
  if (!how->blocks) return;
  dls_blocks blocks;
  if (dls_blocks_from_dense(&at->contact.W, p->d, at->p, at->i, at->x, &blocks, NULL)) abort();
  at->contact.W = (dls_dense){0};
  at->contact.Wb = blocks;
}

/* Starts: 1, pushes of the size of |q| over the candidate's weight; 2, the answer before. */
static void room_start(room *at, const problem *p, const run *how, const outcome *before) {
  dice g = {how->seed ^ 0x5bd1e995u};
  for (int i = 0; i < p->m; i++) {
    const int c = i / p->d, own = p->d * c;
    double weight = 0;
    for (int k = 0; k < p->d; k++)
      weight += p->W[(size_t)(own + k) * (size_t)(p->m + 1)] / p->d;
    const double push = dice_between(&g, 0, 1);
    double start = how->warm == 1 && weight > 0 ? fabs(p->q[own]) / weight * push : 0;
    if (how->warm == 1 && i != own) start *= (push - 0.5) * fmin(p->mu[c], 10);
    if (how->warm == 2 && before) start = before->r[i];
    at->r[i] = ldexp(start, how->power_q - how->power_W);
  }
}

static void room_answer(const room *at, const problem *p, const run *how, double *r) {
  for (int i = 0; i < p->m; i++)
    r[p->d * at->from[i / p->d] + i % p->d] = ldexp(at->r[i], how->power_W - how->power_q);
}

/* ---- the LCP --------------------------------------------------------------------------------- */

typedef struct lcp_room {
  double *M, q[4 * NC_MAX], z[4 * NC_MAX], v[4 * NC_MAX], s[NC_MAX];
} lcp_room;

/* Returns 1 if l->v proves without rounding that this LCP has no solution. */
static int lcp_proof_holds(const lcp_room *l, int n) {
  exact sum;
  exact_clear(&sum);
  for (int i = 0; i < n; i++) {
    if (!(l->v[i] >= 0 && l->v[i] <= 1e300)) return 0;
    exact_add(&sum, l->q[i], l->v[i], 1);
  }
  if (exact_sign(&sum) >= 0) return 0;
  for (int j = 0; j < n; j++) {
    exact_clear(&sum);
    for (int i = 0; i < n; i++)
      exact_add(&sum, l->M[i + j * n], l->v[i], 1);
    if (exact_sign(&sum) > 0) return 0;
  }
  return 1;
}

/* Divides W and q by the power of two below `most`, so that the LCP has the same bits in every unit
 * that is a power of two; r stays. */
static void divide_by_unit(room *at, double most) {
  const int e = most > 0 ? -ilogb(most) : 0;
  for (int i = 0; i < at->m * at->m; i++)
    at->W[i] = ldexp(at->W[i], e);
  for (int i = 0; i < at->m; i++)
    at->q[i] = ldexp(at->q[i], e);
}

/* at->r := the reactions of Lemke's answer; *proof: 1 if its proof holds exactly for the LCP; y
 * (nc): the normal part of its proof after DLS_NO_SOLUTION. */
static dls_status solve_lcp(room *at, const run *how, int scaled, double *y, int *holds,
                            int *proof) {
  lcp_room *l = problem_alloc(sizeof *l);
  l->M = problem_alloc(16 * (size_t)at->nc * (size_t)at->nc * sizeof *l->M);
  const dls_contact *contact = &at->contact;
  double most = 0;
  for (int c = 0; c < at->nc; c++) {
    const double *W = at->W + at->d * c * (at->m + 1);
    l->s[c] = scaled ? W[0] + W[at->m + 1] : 0;
    most = fmax(most, l->s[c]);
  }
  for (int c = 0; c < at->nc; c++)
    l->s[c] = most > 0 && l->s[c] > 0 ? sqrt(most / l->s[c]) : 1;
  divide_by_unit(at, most);
  const int n =
      how->rows == 3 ? dls_contact_lcp_size(contact) : dls_contact_facets_size(contact, 2);
  dls_status status = how->rows == 3
                          ? dls_contact_to_lcp(contact, l->s, l->M, n, l->q, NULL)
                          : dls_contact_to_facets_lcp(contact, 2, l->s, l->M, n, l->q, NULL);
  dls_lemke_settings settings;
  dls_lemke_settings_init(&settings);
  settings.limits.tol = how->tol;
  settings.crash = how->crash;
  dls_lemke *lemke = NULL;
  const dls_lcp lcp = {.n = n, .M = {n, n, n, l->M}, .q = l->q};
  dls_lemke_info info;
  if (!status) status = dls_lemke_create(&lemke, n, &settings, NULL);
  if (!status) status = dls_lemke_solve(lemke, &lcp, l->z, NULL, &info, NULL);
  if (status >= 0) {
    dls_lcp_certificate own;
    if (dls_lcp_certify(&lcp, l->z, NULL, &own, NULL)) abort();
    *holds = dls_lcp_certificate_holds(&own, how->tol);
    if (how->rows == 3 ? dls_contact_from_lcp(contact, l->s, l->z, at->r, NULL)
                       : dls_contact_from_facets_lcp(contact, 2, l->s, l->z, at->r, NULL))
      abort();
  }
  const int proved = status == DLS_NO_SOLUTION && dls_lemke_farkas(lemke, l->v, NULL) == DLS_OK;
  *proof = proved && lcp_proof_holds(l, n);
  if (proved)
    for (int c = 0, row = 0; c < at->nc; c++) {
      y[at->from[c]] = l->v[row] * l->s[c];
      row += at->mu[c] > 0 ? how->rows : 1;
    }
  dls_lemke_destroy(lemke);
  free(l->M);
  free(l);
  return status;
}

/* Returns 1 if one of the forms of the LCP gives a proof that is exact for the problem's numbers.
 * */
static int search_proof(const problem *p, const run *how, room *at) {
  double y[NC_MAX];
  int holds, proof;
  if (p->d != 2 || problem_is_bonded(p)) return 0;
  for (int way = 0; way < 8; way++) {
    run lcp = *how;
    lcp.rows = way & 1 ? 4 : 3;
    lcp.crash = !(way & 4);
    lcp.blocks = 0;
    memset(y, 0, sizeof y);
    room_fill(at, p, &lcp);
    if (solve_lcp(at, &lcp, !(way & 2), y, &holds, &proof) != DLS_NO_SOLUTION) continue;
    if (farkas_rounded(p, y)) return 1;
  }
  return 0;
}

/* ---- the contact problem --------------------------------------------------------------------- */

/* y (nc) := the solver's own proof after DLS_NO_SOLUTION, in the problem's order. */
static void keep_proof(const room *at, const dls_solver *solver, dls_status status, double *y) {
  const double *v = status == DLS_NO_SOLUTION ? dls_solver_farkas(solver) : NULL;
  for (int c = 0; v && c < at->nc; c++)
    y[at->from[c]] = v[c];
}

static dls_status solve_contact(room *at, const run *how, outcome *out, double *y) {
  dls_solver_settings settings;
  dls_solver_settings_init(&settings);
  settings.limits.tol = how->tol;
  settings.limits.warm_start = how->warm > 0;
  settings.limits.blocks = how->blocks ? at->contact.Wb.p[at->nc] : 0;
  settings.method = how->method;
  dls_info info = {0};
  dls_status status;
  if (how->front) {
    dls_solver *solver = NULL;
    status = dls_solve(&at->contact, &settings, at->r, NULL, &info, NULL);
    if (status == DLS_NO_SOLUTION && !dls_solver_create(&solver, at->d, at->nc, &settings, NULL)) {
      double *r = calloc((size_t)at->m, sizeof *r);
      memcpy(r, at->r, (size_t)at->m * sizeof *r);
      keep_proof(at, solver, dls_solver_solve(solver, &at->contact, r, NULL, NULL, NULL), y);
      free(r);
    }
    dls_solver_destroy(solver);
  } else {
    dls_solver *solver = NULL;
    status = dls_solver_create(&solver, at->d, at->nc, &settings, NULL);
    if (!status) status = dls_solver_solve(solver, &at->contact, at->r, NULL, &info, NULL);
    keep_proof(at, solver, status, y);
    dls_solver_destroy(solver);
  }
  out->residual = info.certificate.residual;
  out->error = info.error;
  out->factorisations = info.factorisations;
  return status;
}

/* Returns 1 if one solution is proved to lie within 1e-8 of r. */
static int is_proved(const room *at) {
  dls_proof proof;
  if (dls_contact_prove(&at->contact, at->r, &proof, NULL, NULL)) return 0;
  return proof.kind == DLS_PROVED && proof.error <= 1e-8;
}

void solve_run(const problem *p, const run *how, const outcome *before, outcome *out) {
  room *at = room_create(p);
  double y[NC_MAX] = {0};
  memset(out, 0, sizeof *out);
  room_fill(at, p, how);
  room_start(at, p, how, before);
  if (how->rows) {
    out->status = solve_lcp(at, how, 1, y, &out->lcp_holds, &out->lcp_proof);
    out->residual = 1;
  } else {
    out->status = solve_contact(at, how, out, y);
  }
  if (out->status >= 0) {
    room_answer(at, p, how, out->r);
    measure_answer(p, out->r, &out->is);
    out->holds = measure_holds(&out->is, how->tol, 0.5, 1e-8, 1);
    out->holds_to_rounding = measure_holds(&out->is, how->tol, 0.5, 1e-4, 1);
  }
  if (out->status == DLS_TO_ROUNDING && !how->rows) out->is_proved = is_proved(at);
  if (out->status == DLS_OK && !how->rows && p->kind == SOLVABLE)
    judge_truth(p, out->r, fmax(how->tol, 4 * fmax(out->is.floor_u, out->is.floor_r)),
                how->method == DLS_AUTO, &out->is_true);
  if (out->status == DLS_NO_SOLUTION)
    out->proof = how->rows ? farkas_rounded(p, y) || search_proof(p, how, at) : farkas_holds(p, y);
  room_destroy(at);
}
