/*
 * unsettled.c: names the contacts whose error keeps an answer from being solved, and tests
 * if sweeps diverge from it.
 *
 * On some packings at rest the solution is a fixed point that sweeps leave: the error grows at few
 * candidates until they change states, falls again, and so on without end. The user learns which.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "console.h"

enum { watched_sweeps = 40 }; /* the first half of them forgets where other methods ended */
static const double named_share = 0.5; /* of the sum of |F_c|^2: few candidates hold it */
static const double diverges =
    1.001; /* residual of a sweep over that of the one before; its inverse: they circle */

static int note_residual(void *data, const dls_progress *p) {
  double *residual = data;
  if (p->iteration > 0 && p->iteration <= watched_sweeps) residual[p->iteration - 1] = p->residual;
  return 0;
}

/* Returns by how much the residual grows in a sweep from r, 0 if nobody knows. */
static double sweep_growth(const dls_contact *contact, const double *r) {
  const size_t m = (size_t)contact->d * (size_t)contact->nc;
  double residual[watched_sweeps] = {0}, *copy = malloc(m * sizeof *copy);
  dls_solver_settings settings;
  dls_solver_settings_init(&settings);
  settings.method = DLS_NLGS;
  settings.limits.tol = 0;
  settings.limits.max_iterations = watched_sweeps;
  settings.limits.warm_start = 1;
  settings.limits.progress = note_residual;
  settings.limits.progress_data = residual;
  if (!copy) return 0;
  memcpy(copy, r, m * sizeof *copy);
  const dls_status status = dls_solve(contact, &settings, copy, NULL, NULL, NULL);
  free(copy);
  enum { quarter = watched_sweeps / 4 };
  double first = 0, last = 0; /* the largest of two quarters: what circles is not monotone */
  for (int k = 0; k < quarter; k++) {
    first = fmax(first, residual[quarter + k]);
    last = fmax(last, residual[3 * quarter + k]);
  }
  if (status < 0 || !(first > 0 && last > 0)) return 0;
  return pow(last / first, 2. / watched_sweeps);
}

/* Puts candidate c, whose |F_c|^2 is `square`, among the worst. */
static void unsettled_insert(unsettled *to, double *squares, int c, double square) {
  int k = to->count < most_unsettled ? to->count++ : most_unsettled;
  for (; k > 0 && square > squares[k - 1]; k--)
    if (k < most_unsettled) {
      squares[k] = squares[k - 1];
      to->candidate[k] = to->candidate[k - 1];
    }
  if (k == most_unsettled) return;
  squares[k] = square;
  to->candidate[k] = c;
}

int unsettled_find(unsettled *to, const dls_contact *contact, const double *r, const double *u) {
  const size_t nc = (size_t)contact->nc;
  double *misfit = malloc((nc ? nc : 1) * sizeof *misfit), squares[most_unsettled] = {0}, all = 0;
  dls_error error = {0};
  *to = (unsettled){0};
  if (!misfit) return complain("out of memory");
  if (dls_contact_misfits(contact, r, u, misfit, &error)) {
    free(misfit);
    return complain_of("misfits", &error);
  }
  for (int c = 0; c < contact->nc; c++) {
    all += misfit[c] * misfit[c];
    if (misfit[c] > 0) unsettled_insert(to, squares, c, misfit[c] * misfit[c]);
  }
  free(misfit);
  double held = 0;
  int count = 0;
  while (count < to->count && held < named_share * all)
    held += squares[count++];
  to->count = count;
  to->share = all > 0 ? held / all : 0;
  to->growth = sweep_growth(contact, r);
  return 1;
}

void unsettled_print(const unsettled *from) {
  if (from->count == 0) return;
  printf("  the error is at candidate%s", plural(from->count));
  for (int k = 0; k < from->count; k++)
    printf("%s %d", k ? "," : "", from->candidate[k]);
  printf(" (%.0f %% of its square)", 100 * from->share);
  if (from->growth > diverges)
    printf("; sweeps diverge from here, by %.4g each", from->growth);
  else if (from->growth * diverges > 1)
    printf("; sweeps circle here");
  putchar('\n');
}
