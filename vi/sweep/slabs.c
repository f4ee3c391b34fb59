/*
 * slabs.c: sorts contacts into slabs that may be swept at the same time.
 *
 * Two contacts are neighbours if they change the same row of u; of bodies, if they share a body.
 * The level of a contact is its distance from a far contact, so neighbours are at most one level
 * apart. A slab has at least one level, 64 contacts and 1/4 of all. So slabs of the same parity,
 * with a level between them, have no neighbours:
 *
 *   levels   0 1 2 | 3 | 4 | 5 | 6 7 | ..       all even slabs at the same time,
 *   slab       0   | 1 | 2 | 3 |  4  | ..       then all odd ones
 *
 * Four slabs keep two threads at work, and take as many sweeps as the order of the numbers. Their
 * groups are less full, so slabs begin at 4,000 contacts (docs/decisions.md). They follow from the
 * problem alone, and so do the bits of a sweep. Within a slab contacts ascend, as in memory. Parts
 * that are not coupled follow each other in one row of levels.
 *
 * Cost: two walks over the graph, a few sweeps. What can fail: memory. If most contacts touch one
 * body, there are few levels, and little to do at the same time.
 */
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "vi/vi_internal.h"

enum { least_candidates = 64, most_slabs = 4, piece_size = 512 };

int dlsi_pieces(int count) {
  if (count < 2 * piece_size) return 1;
  return count / piece_size < dlsi_most_pieces ? count / piece_size : dlsi_most_pieces;
}

/* The graph: contacts and their joints, bodies or, W by blocks, the contacts themselves. */
typedef struct slabs_graph {
  int nc, joints;
  int *joint; /* nc + 1 starts, then the joints of each contact */
  int *of;    /* joints + 1 starts, then the contacts of each joint */
  int *done;  /* joints: 1: all contacts of this joint have been reached */
} slabs_graph;

/* Returns the number of joints of contact c. */
static int slabs_degree(const dls_contact *problem, int c) {
  const int *body = problem->bodies.body + 2 * c;
  if (problem->Wb.x) return problem->Wb.p[c + 1] - problem->Wb.p[c] + 1;
  return (body[0] >= 0) + (body[1] >= 0);
}

/* Writes the joints of contact c: W by blocks, itself and each row of its column. */
static void slabs_write(const dls_contact *problem, int c, int *joint) {
  if (problem->Wb.x) {
    *joint++ = c;
    for (int k = problem->Wb.p[c]; k < problem->Wb.p[c + 1]; k++)
      *joint++ = problem->Wb.i[k];
    return;
  }
  for (int k = 2 * c; k < 2 * c + 2; k++)
    if (problem->bodies.body[k] >= 0) *joint++ = problem->bodies.body[k];
}

static void slabs_fill(const slabs_graph *g, const dls_contact *problem) {
  int *joint = g->joint + g->nc + 1, *of = g->of + g->joints + 1;
  g->joint[0] = 0;
  memset(g->of, 0, ((size_t)g->joints + 1) * sizeof *g->of);
  for (int c = 0; c < g->nc; c++) {
    g->joint[c + 1] = g->joint[c] + slabs_degree(problem, c);
    slabs_write(problem, c, joint + g->joint[c]);
    for (int k = g->joint[c]; k < g->joint[c + 1]; k++)
      g->of[joint[k] + 1]++;
  }
  for (int b = 0; b < g->joints; b++)
    g->of[b + 1] += g->of[b];
  for (int c = 0; c < g->nc; c++)
    for (int k = g->joint[c]; k < g->joint[c + 1]; k++)
      of[g->of[joint[k]]++] = c;
  for (int b = g->joints; b > 0; b--)
    g->of[b] = g->of[b - 1];
  g->of[0] = 0;
}

/* Walks from contact `from` over all that can be reached: queue[first ..] in the order of the walk,
 * level of each, from `base` on. Returns the end of the queue. */
static int slabs_walk(const slabs_graph *g, int from, int first, int base, int *queue, int *level) {
  const int *joint = g->joint + g->nc + 1, *of = g->of + g->joints + 1;
  int end = first;
  queue[end++] = from;
  level[from] = base;
  for (int at = first; at < end; at++) {
    const int c = queue[at];
    for (int k = g->joint[c]; k < g->joint[c + 1]; k++) {
      const int b = joint[k];
      if (g->done[b]) continue;
      g->done[b] = 1;
      for (int e = g->of[b]; e < g->of[b + 1]; e++) {
        if (level[of[e]] >= 0) continue;
        level[of[e]] = level[c] + 1;
        queue[end++] = of[e];
      }
    }
  }
  return end;
}

/* Undoes the walk that filled queue[first .. end-1]. */
static void slabs_forget(const slabs_graph *g, const int *queue, int first, int end, int *level) {
  const int *joint = g->joint + g->nc + 1;
  for (int at = first; at < end; at++) {
    const int c = queue[at];
    level[c] = -1;
    for (int k = g->joint[c]; k < g->joint[c + 1]; k++)
      g->done[joint[k]] = 0;
  }
}

/* queue := the contacts by levels; each part begins at the contact that a first walk reached
 * last. */
static void slabs_order(const slabs_graph *g, int *queue, int *level) {
  int first = 0, base = 0;
  memset(g->done, 0, (size_t)g->joints * sizeof *g->done);
  for (int c = 0; c < g->nc; c++)
    level[c] = -1;
  for (int c = 0; c < g->nc; c++) {
    if (level[c] >= 0) continue;
    const int end = slabs_walk(g, c, first, base, queue, level), far = queue[end - 1];
    slabs_forget(g, queue, first, end, level);
    first = slabs_walk(g, far, first, base, queue, level);
    base = level[queue[first - 1]] + 1;
  }
}

static int slabs_compare(const void *a, const void *b) {
  const int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

/* Cuts the queue into slabs. Returns their number. */
static int slabs_cut(int nc, int *queue, const int *level, int *start) {
  const int least = nc / most_slabs > least_candidates ? nc / most_slabs : least_candidates;
  int slabs = 0, first = 0;
  while (first < nc) {
    int end = first;
    while (end < nc && end - first < least)
      for (const int now = level[queue[end]]; end < nc && level[queue[end]] == now;)
        end++;
    start[slabs++] = first;
    qsort(queue + first, (size_t)(end - first), sizeof *queue, slabs_compare);
    first = end;
  }
  start[slabs] = nc;
  return slabs;
}

dls_status dlsi_slabs_set(dlsi_slabs *slabs, const dls_contact *problem, dls_error *error) {
  const int nc = problem->nc;
  slabs_graph g = {.nc = nc, .joints = problem->Wb.x ? nc : problem->bodies.count};
  size_t edges = 0;
  for (int c = 0; c < nc; c++)
    edges += (size_t)slabs_degree(problem, c);
  slabs->set = (dlsi_set){.count = nc};
  if (edges > INT_MAX) return DLS_OK;
  const size_t n = (size_t)nc, joints = (size_t)g.joints;
  int *memory = dlsi_make_room(slabs->memory, &slabs->room, 4 * n + 3, sizeof *memory);
  if (memory) slabs->memory = memory;
  int *scratch = dlsi_alloc(2 * n + 1 + 2 * joints + 1 + 2 * edges, sizeof *scratch);
  if (!memory || !scratch) {
    free(scratch);
    return dlsi_no_memory(error);
  }
  int *queue = memory, *start = queue + n, *level = scratch;
  slabs->some = start + n + 1;
  slabs->rows = slabs->some + n + 1;
  g.done = level + n;
  g.joint = g.done + joints;
  g.of = g.joint + n + 1 + edges;
  slabs_fill(&g, problem);
  slabs_order(&g, queue, level);
  slabs->set = (dlsi_set){
      .list = queue, .count = nc, .slabs = slabs_cut(nc, queue, level, start), .start = start};
  free(scratch);
  return DLS_OK;
}

void dlsi_slabs_free(dlsi_slabs *slabs) {
  free(slabs->memory);
  *slabs = (dlsi_slabs){.memory = NULL};
}
