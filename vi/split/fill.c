/*
 * fill.c: foresees what a factorisation on the motions of joints (joints.c) takes, from the graph
 * of the bodies alone: before W is formed, and before anything is ordered.
 *
 *   (FI1)  levels of bodies by their distance from one that is far from others, breadth first
 *   (FI2)  s = motions of the joints from one level to the next, the least that cuts at least a
 *          quarter of the contacts off. Such joints are a separator, and nested dissection finds a
 *          top separator of about that size
 *   (FI3)  operations: 4 s^3. Spheres and ellipsoids in 3D (3,600 contacts) take half of that,
 *          pyramids of crates (19,000) 1.2 times as many; domes 2.5, walls 15 times as many, since
 *          their other separators are as large
 *
 * Cost: O(contacts), less than a sweep. What can fail: memory, which counts as no fill.
 */
#include <stdlib.h>
#include <string.h>

#include "vi/vi_internal.h"

static const double least_part = 0.25; /* (FI2) */
static const double share_of_top = 4;  /* (FI3) */

/* Contacts by body, and levels of bodies. */
typedef struct fill_graph {
  const dls_bodies *of;
  int nc, count;
  int *first, *contact; /* count + 1; 2 nc */
  int *level, *queue;   /* count */
} fill_graph;

static void fill_list(fill_graph *g) {
  const int *body = g->of->body;
  for (int k = 0; k < 2 * g->nc; k++)
    if (body[k] >= 0) g->first[body[k] + 1]++;
  for (int b = 0; b < g->count; b++)
    g->first[b + 1] += g->first[b];
  memcpy(g->queue, g->first, (size_t)g->count * sizeof *g->queue);
  for (int k = 0; k < 2 * g->nc; k++)
    if (body[k] >= 0) g->contact[g->queue[body[k]]++] = k / 2;
}

/* (FI1) from a body; those that it does not reach have level -1. Returns the last body reached. */
static int fill_spread(fill_graph *g, int from) {
  int count = 1;
  memset(g->level, -1, (size_t)g->count * sizeof *g->level);
  g->level[g->queue[0] = from] = 0;
  for (int k = 0; k < count; k++) {
    const int b = g->queue[k];
    for (int l = g->first[b]; l < g->first[b + 1]; l++) {
      const int *pair = g->of->body + 2 * (size_t)g->contact[l];
      const int other = pair[0] == b ? pair[1] : pair[0];
      if (other < 0 || g->level[other] >= 0) continue;
      g->level[other] = g->level[b] + 1;
      g->queue[count++] = other;
    }
  }
  return g->queue[count - 1];
}

/* (FI2) of the bodies that are reached. cut, within: count, zeros: receive the contacts from level
 * l to l + 1, and within level l. */
static double fill_cut(const fill_graph *g, int *cut, int *within) {
  double all = 0, done = 0;
  for (int c = 0; c < g->nc; c++) {
    const int *pair = g->of->body + 2 * (size_t)c;
    const int a = pair[0] < 0 ? -1 : g->level[pair[0]], b = pair[1] < 0 ? -1 : g->level[pair[1]];
    if (a >= 0 && b >= 0 && a != b)
      cut[a < b ? a : b]++;
    else if (a >= 0 || b >= 0)
      within[a > b ? a : b]++;
  }
  for (int l = 0; l < g->count; l++)
    all += within[l] + cut[l];
  double least = all;
  for (int l = 0; l < g->count; l++) {
    done += within[l];
    if (done >= least_part * all && done + cut[l] <= (1 - least_part) * all && cut[l] < least)
      least = cut[l];
    done += cut[l];
  }
  return least;
}

double dlsi_foresee_fill(const dls_contact *problem) {
  const dls_bodies *of = &problem->bodies;
  fill_graph g = {.of = of, .nc = problem->nc, .count = of->count};
  const size_t nc = (size_t)g.nc, nb = (size_t)g.count;
  if (!of->body || g.count < 2) return 0;
  int *memory = calloc(5 * nb + 2 * nc + 1, sizeof *memory), joints = 0;
  if (!memory) return 0;
  g.first = memory;
  g.contact = memory + nb + 1;
  g.level = g.contact + 2 * nc;
  g.queue = g.level + nb;
  fill_list(&g);
  (void)fill_spread(&g, fill_spread(&g, 0));
  memset(g.first, 0, nb * sizeof *g.first);
  memset(g.queue, 0, nb * sizeof *g.queue);
  const double cut = fill_cut(&g, g.first, g.queue);
  for (int c = 0; c < g.nc; c++)
    joints += c == 0 || memcmp(of->body + 2 * c, of->body + 2 * c - 2, 2 * sizeof *of->body) != 0;
  const double d = problem->d, motions = of->n * (double)joints / g.nc;
  const double s = cut * (motions < d ? motions : d);
  free(memory);
  return share_of_top * s * s * s;
}
