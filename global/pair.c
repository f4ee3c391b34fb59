/*
 * pair.c: what the splitting, Newton's steps and proofs share: products with H, one step, and the
 * measure of a pair (x, r), which keeps the best pair.
 *
 * The better of two pairs has the smaller dlsi_body_badness. It includes the rounding levels:
 * otherwise a pair that has run away could win, as rounding hides its residual. A pair that is
 * solved ends the solve, and is the best pair whatever its rounding levels.
 */
#include <string.h>

#include "global_internal.h"

/* accuracy of a host's solve over the change of q, at the end over tol: the residual of a solve is
 * the equilibrium of the pair */
static const double share = 0.01;

void dlsi_global_ask(dls_global *work, double change) {
  const double most = change > 1 ? 1 : change, tol = work->limits->tol;
  work->accuracy = share * (most > tol ? most : tol); /* tol if nothing changes */
}

/* Makes the answer of a host's function a status; error: what it was given. */
static dls_status host_answer(dls_status answer, dls_error *error) {
  if (answer > 0) return DLS_CANCELLED;
  if (answer < 0 && error->status != answer)
    return dlsi_fail(error, answer, "solver", -1, answer, "the host's solver failed");
  return answer;
}

dls_status dlsi_host_prepare(dls_global_prepare_fn prepare, void *data, const double *R,
                             dls_error *error) {
  dls_error none = {0}, *why = error ? error : &none;
  dlsi_host own;
  why->status = DLS_OK;
  dlsi_go_out(&own);
  const dls_status answer = prepare(data, R, why);
  dlsi_come_in(&own);
  return host_answer(answer, why);
}

dls_status dlsi_host_solve(dls_global_solve_fn solve, void *data, const double *b, double *x,
                           double accuracy, dls_error *error) {
  dls_error none = {0}, *why = error ? error : &none;
  dlsi_host own;
  why->status = DLS_OK;
  dlsi_go_out(&own);
  const dls_status answer = solve(data, b, x, accuracy, why);
  dlsi_come_in(&own);
  return host_answer(answer, why);
}

dls_status dlsi_global_factor(dls_global *work, dls_error *error) {
  work->factorisations++;
  if (!work->solver.prepare) return dlsi_system_factor(work->system, work->rho, error);
  for (int k = 0; k < work->m; k++)
    work->R[k] = work->rho / (work->root[k] * work->root[k]);
  return dlsi_host_prepare(work->solver.prepare, work->solver.data, work->R, error);
}

void dlsi_global_look_from(const dls_global *work, const double *g, const double *x, double *u) {
  const dlsi_columns *H = &work->H;
  double *all = work->body.ranks ? work->body.ranks->scratch : u;
  for (int k = 0; k < H->cols; k++) {
    double sum = g && k < work->m ? g[k] : 0;
    for (int e = H->p[k]; e < H->p[k + 1]; e++)
      sum += H->x[e] * x[H->i[e]];
    all[k] = sum;
  }
  dlsi_body_give(&work->body, DLSI_SUM, all, u);
}

void dlsi_global_look(const dls_global *work, const double *x, double *u) {
  dlsi_global_look_from(work, work->g, x, u);
}

void dlsi_global_push(const dls_global *work, const double *r, double *v) {
  const dlsi_columns *H = &work->H;
  r = dlsi_body_fetch(&work->body, r);
  for (int k = 0; k < H->cols; k++)
    for (int e = H->p[k]; r[k] != 0 && e < H->p[k + 1]; e++)
      v[H->i[e]] += H->x[e] * r[k];
}

dls_status dlsi_global_step(dls_global *work, const double *r, const double *q, const double *g,
                            dls_error *error) {
  const dlsi_system *A = work->system;
  double *y = work->y;
  for (int j = 0; j < work->n; j++)
    y[j] = work->f[j] + (A ? A->hold * A->e[j] * work->x[j] : 0);
  for (int k = 0; k < work->m; k++)
    work->look[k] = 2 * r[k] - q[k] - (g ? work->rho * g[k] : 0);
  dlsi_global_push(work, work->look, y);
  const dls_status status =
      A ? dlsi_system_solve(work->system, y, error)
        : dlsi_host_solve(work->solver.solve, work->solver.data, y, work->x, work->accuracy, error);
  if (status) return status;
  if (A) memcpy(work->x, y, (size_t)work->n * sizeof *y);
  dlsi_global_look(work, work->x, work->u);
  return DLS_OK;
}

int dlsi_global_touches(const dls_global *work) {
  return work->body.ranks ? work->body.ranks->all > 0 : work->m > 0;
}

double dlsi_global_compliance(const dls_global *work) {
  double sum[2] = {0, work->nc};
  for (int c = 0; c < work->nc; c++)
    sum[0] += work->w[2 * c];
  dlsi_join(work->body.ranks, DLSI_SUM, sum, 2);
  return sum[0] / sum[1];
}

int dlsi_global_is_rigid(const dls_global *work) {
  const dls_sparse *K = &work->model.Ks;
  return dlsi_max_abs(K->x, (size_t)K->p[work->n]) == 0;
}

int dlsi_global_can_split(const dls_global *work) {
  return !work->is_split && !work->body.joint && dlsi_global_touches(work) &&
         (work->body.model || work->body.multiply);
}

dls_status dlsi_global_measure(dls_global *work, const double *r, dls_certificate *found) {
  for (int k = 0; k < work->m; k++)
    work->trial[k] = r[k] / work->root[k];
  dlsi_body_measure(&work->body, work->load, work->gap, work->mu, work->trial, work->x, work->look,
                    work->scratch, found);
  const double tol = work->limits->tol;
  dls_status verdict = dlsi_certificate_verdict(found, tol);
  if (verdict == DLS_STALLED && dlsi_global_can_split(work)) { /* (LO1) */
    dls_certificate loose = *found;
    dlsi_forces_loose(&work->body, work->scratch, &loose);
    const dls_status then = dlsi_certificate_verdict(&loose, tol);
    if (then != DLS_STALLED &&
        (work->system || dlsi_joined_norm(work->body.ranks, r, (size_t)work->m) > 0))
      return dlsi_split_first;
    if (then != DLS_STALLED) { /* a host's solver holds the bodies: all contacts are open */
      *found = loose;
      verdict = then;
    }
  }
  if (verdict != DLS_STALLED || dlsi_body_badness(found) < dlsi_body_badness(&work->best)) {
    work->best = *found;
    memcpy(work->best_r, work->trial, (size_t)work->m * sizeof *work->trial);
    memcpy(work->best_x, work->x, (size_t)work->n * sizeof *work->x);
  }
  if (verdict == DLS_TO_ROUNDING && dlsi_global_can_split(work) && work->system &&
      4 * found->floor_e > fmax(tol, 1e-8) && dlsi_forces_dwarf(&work->body, work->scratch))
    return dlsi_split_first; /* (LO1) */
  return verdict;
}
