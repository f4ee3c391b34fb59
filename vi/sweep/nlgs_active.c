/*
 * nlgs_active.c: sweeps over the contacts that act, with momentum (nlgs_ways.c).
 *
 *   (NL13) A solve that knows its contacts again (dls_solver_map) sweeps only those that act: at
 *          the start those with r_c not 0 or u_n < 0. A look at all contacts, after sweeps 5, 10,
 *          15, 20, 40, 60 .. and before the certificate, adds others by the same rule; none is
 *          taken out. All are swept if more than half of them act, with (NL6), and by a stage that
 *          goes on (NL14), whose p has other contacts
 *
 * A contact that is left out has r_c = 0. In flowing packings a sixth to a third of the contacts
 * act. A cold solve would gain as well, but has to find them first: it sweeps all.
 *
 * Cost: of a look, half a sweep over all; if contacts are added, groups of those that act.
 */
#include "nlgs_work.h"

static const double most_acting = 0.5; /* of the contacts: with more, groups cost what they save */

/* Returns 1 if the contact carries a reaction or closes. */
static int active_acts(const dls_nlgs *work, size_t d, int c, const double *r) {
  const size_t at = d * (size_t)c;
  return !dlsi_is_zero((int)d, r + at) || work->it.u[at] < 0;
}

void dlsi_nlgs_narrow(dls_nlgs *work, const dls_contact *problem, const double *r) {
  work->narrow = 0;
  if (!work->knows || !work->grouped || work->now == DLSI_WAY_ANDERSON) return;
  int count = 0, fresh = work->acting_count == 0;
  for (int c = 0; c < problem->nc; c++) {
    const int acts = active_acts(work, (size_t)problem->d, c, r);
    fresh |= acts && !work->acts[c];
    work->acts[c] |= acts;
    count += work->acts[c];
  }
  work->knows = count > 0 && count <= most_acting * problem->nc;
  if (!work->knows) return;
  if (fresh) {
    for (int c = 0; c < problem->nc; c++)
      work->near[c] = work->acts[c];
    const dlsi_set set = dlsi_nlgs_list(work, problem, 1, work->acting, work->slabs.rows);
    if (dlsi_groups_set(&work->active, problem, set, &work->groups, NULL) || !work->active.count)
      work->knows = 0;
    if (!work->knows) return;
  }
  work->acting_count = count;
  work->narrow = 1;
}
