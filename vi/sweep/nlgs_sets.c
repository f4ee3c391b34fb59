/*
 * nlgs_sets.c: extra sweeps where the residual is large, with momentum (nlgs_ways.c).
 *
 *   (NL9)  every 10 sweeps, from sweep 50 on: take the fewest contacts that hold 90 % of |F|^2, and
 *          three layers of contacts that W couples with them. If that is at most 1/3 of all, it
 *          gets up to 300 sweeps of its own, until |F| on it is 0.3 of what it was; then (NL8)
 *          restarts. Otherwise the next 1, 2, 4 .. 16 looks are skipped
 *
 * F is the misfit of the contact law, as in the certificate. The fewest contacts are found up to a
 * factor of two: they have an |F_c|^2 above a bound that is halved until they hold enough. A local
 * sweep changes r in the set and u in the set and one more layer.
 *
 * Cost: a look walks over all contacts and over the graph, like some sweeps. A local sweep costs
 * its fraction of a sweep, and counts as that.
 */
#include <float.h>
#include <math.h>

#include "nlgs_work.h"

enum { local_sweeps = 300, local_looks = 5, local_layers = 3 };
enum { longest_pause = 16 };
static const double local_share = 0.9;   /* of |F|^2 that the worst contacts hold */
static const double local_size = 1. / 3; /* of the contacts: a larger set is no gain */
static const double local_end = 0.3;     /* of |F| on the set */

/* A sum of |F_c|^2 by pieces. */
typedef struct nlgs_measures {
  const dls_nlgs *work;
  const dls_contact *problem;
  dlsi_set set;
  const double *r;
  double *F2; /* nc, NULL for none */
  int pieces;
  double sum[dlsi_most_pieces];
} nlgs_measures;

static void nlgs_measure_piece(void *data, int piece) {
  nlgs_measures *s = data;
  const dls_nlgs *work = s->work;
  const int d = s->problem->d, n = work->motions;
  const int end = dlsi_piece(s->set.count, s->pieces, piece + 1);
  double sum = 0;
  for (int k = dlsi_piece(s->set.count, s->pieces, piece); k < end; k++) {
    const int c = s->set.list ? s->set.list[k] : k;
    double F[3] = {0}, u[3] = {0};
    if (n && !s->set.groups) {
      const dlsi_pair_of_bodies of =
          dlsi_bodies_of(&s->problem->bodies, (size_t)n * (size_t)d, (size_t)c, work->v);
      dlsi_bodies_look(d, n, &of, s->problem->q + d * c, u);
    }
    (void)dlsi_contact_misfit(d, s->problem->mu[c], work->it.weights + 2 * (size_t)c, s->r + d * c,
                              n && !s->set.groups ? u : work->it.u + d * c, F);
    const double square = F[0] * F[0] + F[1] * F[1] + F[2] * F[2];
    if (s->F2) s->F2[c] = square;
    sum += square;
  }
  s->sum[piece] = sum;
}

/* Returns the sum of |F_c|^2 over a set; F2 (nc, NULL for none): each of them. */
static double nlgs_measure(const dls_nlgs *work, const dls_contact *problem, dlsi_set set,
                           const double *r, double *F2) {
  nlgs_measures s = {work, problem, set, r, F2, dlsi_pieces(set.count), {0}};
  double sum = 0;
  if (set.groups) dlsi_groups_look(set.groups, work->team, r, work->v, work->it.u);
  dlsi_parallel(work->team, s.pieces, nlgs_measure_piece, &s);
  for (int k = 0; k < s.pieces; k++)
    sum += s.sum[k];
  return sum;
}

/* Returns the largest 2^-k max F2 for which the contacts above it hold their share. */
static double nlgs_threshold(const dls_contact *problem, const double *F2, double sum) {
  double bound = 0, held = 0;
  for (int c = 0; c < problem->nc; c++)
    bound = fmax(bound, F2[c]);
  while (bound > 0 && bound <= DBL_MAX && held < local_share * sum) {
    bound /= 2;
    held = 0;
    for (int c = 0; c < problem->nc; c++)
      if (F2[c] > bound) held += F2[c];
  }
  return bound;
}

/* Marks the bodies of the contacts with near = `layer`. Contacts in no layer that share such a body
 * get near = `layer` + 1. */
static void nlgs_add_layer_of_bodies(const dls_nlgs *work, const dls_contact *problem, int layer) {
  const int *body = problem->bodies.body;
  int *mark = work->bodies.some + problem->bodies.count;
  for (int k = 0; k < 2 * problem->nc; k++)
    if (work->near[k / 2] == layer && body[k] >= 0) mark[body[k]] = 1;
  for (int k = 0; k < 2 * problem->nc; k++)
    if (!work->near[k / 2] && body[k] >= 0 && mark[body[k]]) work->near[k / 2] = layer + 1;
}

/* near := `layer` + 1 for the contacts in no layer that W couples with that layer. */
static void nlgs_add_layer(const dls_nlgs *work, const dls_contact *problem, int layer) {
  const dls_blocks *W = &problem->Wb;
  if (work->motions) nlgs_add_layer_of_bodies(work, problem, layer);
  for (int c = 0; !work->motions && c < problem->nc; c++)
    for (int k = W->p[c]; work->near[c] == layer && k < W->p[c + 1]; k++)
      if (!work->near[W->i[k]]) work->near[W->i[k]] = layer + 1;
}

dlsi_set dlsi_nlgs_list(const dls_nlgs *work, const dls_contact *problem, int layer, int *list,
                        int *start) {
  const dlsi_set all = work->grouped ? work->slabs.set : dlsi_nlgs_all(work, problem);
  int count = 0, slab = 0;
  for (int k = 0; k < problem->nc; k++) {
    const int c = all.list ? all.list[k] : k;
    while (slab < all.slabs && all.start[slab] <= k)
      start[slab++] = count;
    if (work->near[c] && work->near[c] <= layer) list[count++] = c;
  }
  if (all.slabs) start[all.slabs] = count;
  return (dlsi_set){.list = list, .count = count, .slabs = all.slabs, .start = start};
}

/* Lists the bodies that have a mark. */
static dlsi_set nlgs_list_bodies(const dls_nlgs *work, const dls_contact *problem) {
  int *list = work->bodies.some, count = 0;
  for (int b = 0; b < problem->bodies.count; b++)
    if (list[problem->bodies.count + b]) list[count++] = b;
  return (dlsi_set){.list = list, .count = count};
}

/* (NL9) Sweeps where the residual is large. u belongs to r. Returns 0 if the set is too large. */
static int nlgs_sweep_locally(dls_nlgs *work, const dls_contact *problem, double *r) {
  const int d = problem->d, n = work->motions;
  double *F2 = work->it.F, *const u = dlsi_nlgs_kept(work);
  const int narrow = work->narrow;
  work->narrow = 0; /* a look over all of them */
  const double sum = nlgs_measure(work, problem, dlsi_nlgs_all(work, problem), r, F2);
  work->narrow = narrow;
  const double bound = nlgs_threshold(problem, F2, sum);
  for (int c = 0; c < problem->nc; c++)
    work->near[c] = F2[c] > bound;
  for (int b = 0; n && b < problem->bodies.count; b++)
    work->bodies.some[problem->bodies.count + b] = 0;
  for (int layer = 1; layer <= local_layers + 1; layer++)
    nlgs_add_layer(work, problem, layer);
  dlsi_set set = dlsi_nlgs_list(work, problem, local_layers + 1, work->some, work->slabs.some);
  if (set.count == 0 || set.count > local_size * problem->nc) return 0;
  if (work->grouped) {
    if (dlsi_groups_set(&work->part, problem, set, &work->groups, NULL) || !work->part.count)
      return 0;
    set.groups = &work->part;
  }
  dlsi_set rows = {.count = 0};
  if (n)
    rows = nlgs_list_bodies(work, problem);
  else if (!work->grouped)
    rows = dlsi_nlgs_list(work, problem, local_layers + 2, work->rows, work->slabs.rows);
  const double end = local_end * local_end * nlgs_measure(work, problem, set, r, NULL);
  dlsi_momentum *mo = &work->momentum;
  dlsi_momentum_start(mo, d, n ? n : d, set, rows, r, u);
  for (int k = 1; k <= local_sweeps; k++) {
    work->sweeps += (double)set.count / problem->nc;
    if (!dlsi_nlgs_sweep(work, problem, set, r)) break;
    if (k % local_looks == 0 && nlgs_measure(work, problem, set, r, NULL) <= end) break;
    if (k < local_sweeps)
      (void)dlsi_momentum_step(mo, d, n ? n : d, work->it.w, work->largest, set, rows, r, u);
  }
  return 1;
}

/* (NL9), less and less often while the sets are too large. Returns 1 if r has changed. */
int dlsi_nlgs_look_locally(dls_nlgs *work, const dls_contact *problem, double *r) {
  if (work->wait > 0) {
    work->wait--;
    return 0;
  }
  const int swept = nlgs_sweep_locally(work, problem, r);
  const int longer = work->pause ? 2 * work->pause : 1;
  work->pause = swept ? 0 : longer < longest_pause ? longer : longest_pause;
  work->wait = work->pause;
  return swept;
}
