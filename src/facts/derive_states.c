/*
 * derive_states.c: the object of derivatives, the states of its answer, its linear system. Notation
 * of derive.c.
 */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "facts/derive.h"
#include "facts/facts.h"

static const double most_residual = 1e-4; /* of an answer */

/* ---- the object ------------------------------------------------------------------------------ */

static void derive_carve(void *workspace, dlsi_arena *arena) {
  dls_derive *work = workspace;
  const dls_bodies *B = &work->problem.bodies;
  const size_t nc = (size_t)work->problem.nc, m = (size_t)work->problem.d * nc;
  const size_t n = (size_t)work->n, motions = B->H ? (size_t)B->n * (size_t)B->count : 0;
  double **const of_m[] = {&work->r, &work->u, &work->a, &work->b, &work->c};
  double **const of_all[] = {&work->z, &work->row, &work->col};
  for (int k = 0; k < 5; k++)
    *of_m[k] = dlsi_take(arena, m, sizeof(double));
  for (int k = 0; k < 3; k++)
    *of_all[k] = dlsi_take(arena, n + m, sizeof(double));
  work->x = dlsi_take(arena, n, sizeof(double));
  work->w = dlsi_take(arena, 2 * nc, sizeof(double));
  work->t = dlsi_take(arena, 2 * nc, sizeof(double));
  work->motion = dlsi_take(arena, 2 * motions, sizeof(double));
  work->state = dlsi_take(arena, nc, sizeof *work->state);
  work->branch = dlsi_take(arena, nc, sizeof *work->branch);
}

dls_status dlsi_derive_new(dls_derive **out, const dls_contact *problem, int n, dls_error *error) {
  dls_derive filled = {.n = n, .problem = *problem};
  void *made;
  *out = NULL;
  const dls_status status =
      dlsi_carve_workspace(&made, &filled, sizeof filled, derive_carve, "nc", problem->nc, error);
  if (!status) *out = made;
  return status;
}

void dls_derive_destroy(dls_derive *derive) {
  if (!derive) return;
  dlsi_states_destroy(derive->A);
  dlsi_general_free(&derive->M);
  dlsi_formed_free(&derive->formed);
  free(derive->redundant);
  free(derive);
}

/* ---- states ---------------------------------------------------------------------------------- */

static const char *const state_names[] = {"free", "slip", "stick"};

/* t (2) := the direction of friction at a contact that touches; for mu = 0, if it had friction. */
static void derive_direction(const dls_derive *work, int c, double close, double *t) {
  const int d = work->problem.d;
  const dlsi_branch *at = &work->branch[c];
  const double *u = work->u + d * c, slip = dlsi_tangent_norm(d, u);
  const int from_rest = at->count == 1 && at->mu == 0 && slip > close;
  t[0] = t[1] = 0;
  if (at->state != DLS_SLIP) return;
  for (int i = 1; i < d; i++)
    t[i - 1] = from_rest ? -u[i] / slip : at->t[i - 1];
}

dls_status dlsi_derive_choose(dls_derive *work, int side, double residual, dls_error *error) {
  const dls_contact *problem = &work->problem;
  const int d = problem->d;
  double F[3];
  if (side < -1 || side > 1)
    return dlsi_fail(error, DLS_E_ARGUMENT, "side", -1, side, "must be -1, 0 or 1");
  if (!(residual <= most_residual))
    return dlsi_fail(error, DLS_E_ARGUMENT, "r", -1, residual, "no answer: its residual is %.3g",
                     residual);
  const double close = dlsi_border_width(problem, work->w, work->r, work->u, residual);
  for (int c = 0; c < problem->nc; c++) {
    const double mu = problem->mu[c], *w = work->w + 2 * c, *r = work->r + d * c,
                 *u = work->u + d * c;
    const dls_contact_state own = dlsi_contact_misfit(d, mu, w, r, u, F);
    const dls_contact_state other = dlsi_border_state(d, mu, own, w, r, u, close);
    if (other != own && side < 0)
      return dlsi_fail(error, DLS_E_NO_DERIVATIVE, "contact", c, other,
                       "at the border of %s and %s: no derivative", state_names[own],
                       state_names[other]);
    work->state[c] = (own < other) == (side == 0) ? other : own; /* (DR6) */
  }
  work->rows = dlsi_branches_set(problem, work->state, work->r, work->u, work->branch);
  for (int c = 0; c < problem->nc; c++)
    derive_direction(work, c, close, work->t + 2 * c);
  return DLS_OK;
}

/* ---- the system ------------------------------------------------------------------------------ */

dls_status dlsi_derive_solve(dls_derive *work, int transposed, dls_error *error) {
  for (int k = 0; k < work->fixed; k++)
    work->z[work->redundant[k]] = 0;
  if (!work->A) return dlsi_general_solve(&work->M, transposed, work->z, error);
  return work->rows ? dlsi_states_solve(work->A, transposed, work->z, error) : DLS_OK;
}

dls_status dlsi_derive_judge(dls_derive *work, dls_status status, dls_error *error) {
  const size_t all = (size_t)work->n + (size_t)work->rows;
  double size = 0, *z = work->z;
  if (status && status != DLS_E_SINGULAR) return status;
  for (size_t i = 0; i < all; i++)
    z[i] = 2 * dlsi_draw_entry(0, (int)i) - 1;
  for (int turn = 0; !status && turn < 2; turn++) {
    const double *before = turn ? work->col : work->row, *after = turn ? work->row : work->col;
    for (size_t i = 0; i < all; i++)
      z[i] /= before[i];
    status = dlsi_derive_solve(work, turn, error);
    for (size_t i = 0; i < all; i++)
      z[i] /= after[i];
    size = dlsi_norm2(z, all);
    for (size_t i = 0; !turn && i < all; i++)
      z[i] /= size;
  }
  if (status && status != DLS_E_SINGULAR) return status;
  if (!status && (!all || size * 64 * sqrt((double)all) * DBL_EPSILON < 1)) return DLS_OK;
  return dlsi_fail(error, DLS_E_NO_DERIVATIVE, "r", -1, size, "not determined: no derivative");
}
