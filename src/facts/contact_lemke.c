/*
 * contact_lemke.c: Lemke's method on a contact problem.
 *
 *   (CL1)  d = 2: the 3-row form of the LCP (lcp/friction.c); after a ray the 4-row form
 *          (lcp/facets.c) d = 3: the cone with facets
 *   (CL2)  from the LCP's reactions to the round cone by Newton's method; if the states of the
 *          contacts cycle, sweeps of Gauss-Seidel sort them, then Newton again
 *
 *   (CL3)  d = 2: v_c = s_c times the entry of row u_n in the LCP's Farkas vector is a Farkas
 *          vector of the contact problem, (EX2), up to rounding. It is a proof if v, or a vector
 *          near v, holds exactly for W, q and mu: the LCP has only rounded numbers
 *
 *   (CL4)  r_c = s_c r'_c with s_c = sqrt(w / w_c), w the largest w_c. Dividing W and q by a power
 *          of two near w removes the rest of the unit of W and changes no r. A W in a unit that
 *          differs by a power of two thus leads to the LCP with the same bits.
 *
 *   (CL5)  if (CL2) finds no answer: the linear problem of farkas.c. Its ray is a Farkas vector,
 *          proof or not by the rule of (CL3), in 3D too; its solution may show that no r can be
 *          certified
 *
 * The certificate decides. In 3D the LCP of (CL1) proves nothing about the problem: the round cone
 * is larger than the cone with facets.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "contact/exact.h"
#include "delassus/facets.h"
#include "delassus/lcp.h"
#include "facts/facts.h"
#include "lcp/lcp_internal.h"
#include "vi/vi_internal.h"

enum {
  linear_form = -1, /* of an LCP: (CL5) */
  default_facets = 8,
  most_fallback_rows = 4000, /* d = 2: largest 4-row form for which create has memory */
  polish_sweeps = 30,
  polish_rounds = 3
};

typedef struct contact_lemke {
  dls_limits limits;
  int d, nc;
  int facets; /* of the cone; d = 2: 2 */
  int n;      /* rows that have memory */
  dls_lemke *lemke;
  dls_nlgs *nlgs;     /* (CL2) */
  dls_newton *newton; /* (CL2) */
  double *M;          /* n x n: matrix of the LCP */
  double *q, *z;      /* n: its right-hand side and unknowns */
  double *s;          /* nc: scales, r_c = s_c r'_c */
  double unit;        /* (CL4) */
  double *r;          /* m: the iterate */
  double *v;          /* nc: (CL3) */
  double *dr;         /* m: reactions of the last ray */
  dlsi_iterate it;

  /* of the current or last solve */
  const dls_contact *problem;
  int form;     /* facets of the LCP that Lemke's method solves; 0: the 3-row form; linear_form */
  int has_v;    /* 1: v is a Farkas vector, at least up to rounding */
  int has_ray;  /* 1: the solve ended in DLS_RAY, along dr */
  int excludes; /* 1: (CL5) shows that no r can be certified */
  int pivots;   /* of earlier LCPs */
} contact_lemke;

static void contact_lemke_carve(void *lemke, dlsi_arena *arena) {
  contact_lemke *work = lemke;
  const size_t D = sizeof(double), n = (size_t)work->n, nc = (size_t)work->nc;
  work->M = dlsi_take(arena, n, n * D);
  work->q = dlsi_take(arena, n, D);
  work->z = dlsi_take(arena, n, D);
  work->s = dlsi_take(arena, nc, D);
  work->r = dlsi_take(arena, (size_t)work->d * nc, D);
  work->dr = dlsi_take(arena, (size_t)work->d * nc, D);
  work->v = dlsi_take(arena, nc, D);
  dlsi_iterate_carve(&work->it, arena, work->d, work->nc, &work->limits);
}

static void contact_lemke_destroy(void *lemke) {
  contact_lemke *work = lemke;
  if (!work) return;
  dls_lemke_destroy(work->lemke);
  dls_nlgs_destroy(work->nlgs);
  dls_newton_destroy(work->newton);
  free(work);
}

static dls_status contact_lemke_create(void **out, int d, int nc, const dlsi_options *options,
                                       dls_error *error) {
  const int facets = d <= 2 ? 2 : options->facets ? options->facets : default_facets;
  /* d = 1: nc for the LCP, as many again for that of (CL5) */
  long long n = (d == 1 ? 2 : facets + 2) * (long long)nc;
  if (d == 2 && n > most_fallback_rows) n = 3LL * nc; /* no memory for the 4-row form */
  if (n > INT32_MAX / 4) return dlsi_fail(error, DLS_E_SIZE, "nc", -1, nc, "is too large");
  contact_lemke filled = {.d = d, .nc = nc, .facets = facets, .n = (int)n};
  void *memory;
  dls_status status =
      dlsi_workspace(&memory, &filled, sizeof filled, contact_lemke_carve, nc, error);
  if (status) return status;
  contact_lemke *work = memory;
  dls_newton_settings steps;
  dls_newton_settings_init(&steps);
  steps.sweeps = 0;
  steps.limits.blocks = options->limits.blocks;
  status = dls_lemke_create(&work->lemke, work->n, NULL, error);
  if (!status) status = dls_nlgs_create(&work->nlgs, d, nc, NULL, error);
  if (!status) status = dls_newton_create(&work->newton, d, nc, &steps, error);
  if (status) {
    contact_lemke_destroy(work);
    return status;
  }
  dlsi_set_limits(&dlsi_lemke_method, work, &options->limits);
  *out = work;
  return DLS_OK;
}

/* (CL3) Decides whether the Farkas vector of the LCP is a proof; work->v := that of the contact
 * problem. d = 3: establishes that the cone with facets has no solution. scratch: nc. */
static int contact_lemke_judge(void *lemke, double *farkas, double *scratch) {
  contact_lemke *work = lemke;
  const dls_contact *problem = work->problem;
  const int rows = work->form == linear_form ? 1 : work->form ? work->form + 2 : 3;
  if (problem->d == 3 && work->form != linear_form) return 1;
  for (int c = 0, i = 0; c < problem->nc; c++) {
    work->v[c] = work->s[c] * farkas[i];
    i += problem->mu[c] > 0 ? rows : 1;
  }
  work->has_v = 1;
  return dlsi_contact_find_proof(problem, work->v, scratch);
}

/* r := the reactions of z, in the current form of the LCP. Errors of the forms. */
static dls_status take_reactions(const contact_lemke *work, const double *z, double *r,
                                 dls_error *error) {
  const dls_contact *problem = work->problem;
  if (!work->form) return dls_contact_from_lcp(problem, work->s, z, r, error);
  return dls_contact_from_facets_lcp(problem, work->form, work->s, z, r, error);
}

/* work->dr := the reactions of the ray that the LCP ended in. Returns `status`, or an error. */
static dls_status read_ray(contact_lemke *work, dls_status status, dls_error *error) {
  const dls_status ray = dls_lemke_ray(work->lemke, NULL, NULL, work->z, NULL, NULL, error);
  if (ray) return ray;
  const dls_status mapped = take_reactions(work, work->z, work->dr, error);
  return mapped ? mapped : status;
}

/* (CL4) Divides W and q in the LCP of work->form, n rows, by a power of two. Rows and columns of a
 * multiplier, the last of a contact with friction, contain nothing of W. */
static void divide_by_unit(contact_lemke *work, const dls_contact *problem, int n) {
  const double unit = work->unit;
  const int rows = work->form ? work->form + 2 : 3;
  double *column = work->M;
  for (int b = 0; b < problem->nc; b++)
    for (int k = 0, columns = problem->mu[b] > 0 ? rows - 1 : 0; k <= columns; k++, column += n)
      for (int c = 0, i = 0; (!k || k < columns) && c < problem->nc; c++) {
        const int end = i + (problem->mu[c] > 0 ? rows - 1 : 1);
        for (; i < end; i++)
          column[i] /= unit;
        i += problem->mu[c] > 0;
      }
  for (int i = 0; i < n; i++)
    work->q[i] /= unit;
}

/* Reports a point z of the LCP's path to the caller: its reactions and their certificate. */
static int tell_of_path(void *lemke, const dls_progress *of_path) {
  DLSI_DOOR;
  contact_lemke *work = lemke;
  const dls_contact *problem = work->problem;
  const dls_limits *limits = &work->limits;
  dls_progress progress = *of_path;
  const dls_status mapped = take_reactions(work, of_path->r, work->r, NULL);
  progress.iteration += work->pivots;
  progress.residual = mapped ? -1 : dlsi_iterate_measure(&work->it, problem, work->r).residual;
  progress.r = mapped ? NULL : work->r;
  return dlsi_tell(limits, work->it.begun, &progress) == DLS_CANCELLED;
}

/* Returns DLS_STALLED for an LCP whose scales or unknowns overflow: the numbers of the problem do
 * not, and the best r so far stays. */
static dls_status stall_beyond_range(dls_status status) {
  return status == DLS_E_NOT_FINITE ? DLS_STALLED : status;
}

static int lcp_rows(const dls_contact *problem, int facets) {
  return facets ? dls_contact_facets_size(problem, facets) : dls_contact_lcp_size(problem);
}

/* (CL1) Solves the LCP of `facets` (0: the 3-row form) in scaled unknowns, warm from the states
 * of work->z, and offers its reactions. Returns the status of the LCP, or an error. */
static dls_status pivot(contact_lemke *work, const dls_contact *problem, int facets, int *pivots,
                        dls_error *error) {
  const double *s = work->s;
  const int n = lcp_rows(problem, facets);
  dls_status status =
      facets ? dls_contact_to_facets_lcp(problem, facets, s, work->M, n, work->q, error)
             : dls_contact_to_lcp(problem, s, work->M, n, work->q, error);
  if (status) return stall_beyond_range(status);
  if (facets) memset(work->z, 0, (size_t)n * sizeof *work->z);
  const dls_lcp lcp = {.n = n, .M = {n, n, n, work->M}, .q = work->q};
  dls_lemke_info info;
  dls_limits limits = work->limits;
  work->form = facets;
  limits.cpu_seconds = dlsi_clock_left(&work->limits, work->it.begun);
  limits.progress = work->limits.progress ? tell_of_path : NULL;
  limits.progress_data = work;
  dlsi_lemke_set_limits(work->lemke, &limits);
  divide_by_unit(work, problem, n);
  work->pivots = *pivots;
  status = dlsi_lemke_run(work->lemke, &lcp, work->z, NULL, &info);
  *pivots += info.pivots + info.crash_rounds;
  const dls_status mapped = take_reactions(work, work->z, work->r, error);
  if (mapped) return stall_beyond_range(mapped);
  (void)dlsi_iterate_offer(&work->it, problem, work->r);
  return status == DLS_RAY || status == DLS_NO_SOLUTION ? read_ray(work, status, error) : status;
}

static int is_stopped(dls_status status) {
  return status == DLS_CANCELLED || status == DLS_TIME_LIMIT;
}

/* Reports a step to the round cone to the caller. */
static int tell_of_polish(void *lemke, const dls_progress *of_step) {
  DLSI_DOOR;
  const contact_lemke *work = lemke;
  dls_progress progress = *of_step;
  if (of_step->last) return 0;
  progress.method = "lemke";
  return dlsi_tell(&work->limits, work->it.begun, &progress) == DLS_CANCELLED;
}

/* (CL2) from work->r, not from the best r so far: r = 0 may have the smaller residual, but not the
 * right states. */
static dls_status polish(contact_lemke *work, const dls_contact *problem, dls_error *error) {
  dls_status status = DLS_OK;
  dls_limits steps = {.tol = work->limits.tol, .warm_start = 1, .progress_data = work};
  if (work->limits.progress) steps.progress = tell_of_polish;
  for (int round = 1; round <= polish_rounds; round++) {
    if (dls_certificate_holds(&work->it.certificate, work->limits.tol)) return DLS_OK;
    steps.cpu_seconds = dlsi_clock_left(&work->limits, work->it.begun);
    steps.max_iterations = polish_sweeps;
    dlsi_set_limits(&dlsi_nlgs_method, work->nlgs, &steps);
    steps.max_iterations = 0;
    dlsi_set_limits(&dlsi_newton_method, work->newton, &steps);
    if (round > 1) {
      status = dls_nlgs_solve(work->nlgs, problem, work->r, NULL, NULL, error);
      if (status < 0) return status;
      (void)dlsi_iterate_offer(&work->it, problem, work->r);
      if (is_stopped(status)) return status;
    }
    status = dls_newton_solve(work->newton, problem, work->r, NULL, NULL, error);
    if (status < 0) return status;
    (void)dlsi_iterate_offer(&work->it, problem, work->r);
    if (is_stopped(status)) return status;
  }
  return DLS_OK;
}

/* (CL5) Returns DLS_NO_SOLUTION with a proof, DLS_RAY with a proof up to rounding, DLS_TIME_LIMIT,
 * an error, else `status`. */
static dls_status pivot_linear(contact_lemke *work, const dls_contact *problem, dls_status status,
                               int *pivots, dls_error *error) {
  const int n = dlsi_farkas_size(problem);
  const dls_lcp lcp = {.n = n, .M = {n, n, n, work->M}, .q = work->q};
  dls_lemke_info info;
  if (n > work->n) return status;
  work->form = linear_form;
  dlsi_farkas_lcp(problem, work->s, work->unit, work->M, work->q, work->z);
  memset(work->z, 0, (size_t)n * sizeof *work->z);
  dls_limits limits = work->limits;
  limits.progress = NULL; /* the unknowns of this LCP are not reactions */
  limits.cpu_seconds = dlsi_clock_left(&work->limits, work->it.begun);
  dlsi_lemke_set_limits(work->lemke, &limits);
  const dls_status ended = dlsi_lemke_run(work->lemke, &lcp, work->z, NULL, &info);
  if (ended < 0) return ended;
  *pivots += info.pivots + info.crash_rounds;
  if (ended == DLS_NO_SOLUTION || is_stopped(ended)) return ended;
  if (ended == DLS_RAY) { /* may not pass for Farkas' */
    const dls_status ray = dls_lemke_ray(work->lemke, NULL, NULL, work->z, NULL, NULL, error);
    if (ray) return ray;
  }
  for (int c = 0; c < problem->nc; c++)
    work->z[c] *= work->s[c]; /* v of (FA1) */
  const double *v = work->has_v ? work->v : work->z;
  work->excludes = dlsi_farkas_excludes(problem, work->it.w, v, work->limits.tol);
  return work->has_v ? DLS_RAY : status;
}

static dls_status contact_lemke_solve(void *lemke, const dls_contact *problem, double *r, double *u,
                                      dls_info *info, dls_error *error) {
  contact_lemke *work = lemke;
  dlsi_iterate *it = &work->it;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const int flat = problem->d <= 2, warm = work->limits.warm_start;
  dls_info outcome = {.method = DLS_LEMKE};
  work->problem = problem;
  work->has_v = work->has_ray = work->excludes = 0;
  dlsi_lemke_set_judge(work->lemke, contact_lemke_judge, work);
  dlsi_iterate_begin(it, problem, NULL, work->limits.tol, warm, r, work->r);
  (void)dlsi_iterate_offer(it, problem, work->r);
  if (warm && flat) dlsi_friction_start(problem, it->w, work->r, it->u, work->z);
  memset(work->r, 0, m * sizeof *r);
  if (warm) (void)dlsi_iterate_offer(it, problem, work->r);
  const double most = dlsi_max_abs(it->w, (size_t)problem->nc);
  for (int c = 0; c < problem->nc; c++) /* (CL4) */
    work->s[c] = sqrt(most / it->w[c]);
  work->unit = ldexp(1, ilogb(most));
  int *pivots = &outcome.iterations;
  const int other = problem->d == 2 && dls_contact_facets_size(problem, 2) <= work->n;
  dls_status status = pivot(work, problem, flat ? 0 : work->facets, pivots, error);
  if (other && status == DLS_RAY) status = pivot(work, problem, 2, pivots, error);
  if (status < 0) return status;
  if (!flat && status == DLS_NO_SOLUTION) status = DLS_RAY;
  if (status == DLS_OK || status == DLS_RAY || status == DLS_STALLED) {
    const dls_status polished = polish(work, problem, error);
    if (polished < 0) return polished;
    if (polished) status = polished;
  }
  work->has_ray = status == DLS_RAY;
  if (status == DLS_OK) status = DLS_STALLED;
  if (dls_certificate_holds(&it->certificate, work->limits.tol))
    status = DLS_OK;
  else if (status == DLS_RAY || status == DLS_STALLED)
    status = pivot_linear(work, problem, status, pivots, error);
  if (status < 0) return status;
  work->has_ray &= status == DLS_RAY;
  work->has_v &= status == DLS_RAY || status == DLS_NO_SOLUTION;
  return dlsi_iterate_end(it, problem, status, &outcome, r, u, info);
}

static const double *contact_lemke_direction(const void *lemke) {
  const contact_lemke *work = lemke;
  return work->has_ray ? work->dr : NULL;
}

static const double *contact_lemke_farkas(const void *lemke) {
  const contact_lemke *work = lemke;
  return work->has_v ? work->v : NULL;
}

int dlsi_contact_lemke_excludes(const void *lemke) {
  return ((const contact_lemke *)lemke)->excludes;
}

const dlsi_method dlsi_lemke_method = {
    .method = DLS_LEMKE,
    .name = "lemke",
    .summary = "2D; 3D on facets, then polished: up to some thousand unknowns, exact to rounding",
    .create = contact_lemke_create,
    .solve = contact_lemke_solve,
    .destroy = contact_lemke_destroy,
    .limits = offsetof(contact_lemke, limits),
    .direction = contact_lemke_direction,
    .farkas = contact_lemke_farkas,
};
