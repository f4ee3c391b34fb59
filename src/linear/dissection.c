/*
 * dissection.c: nested dissection of the graph of a sparse matrix by METIS (Karypis and Kumar, SIAM
 * J. Sci. Comput. 20, 1998, 359-392).
 *
 *   (DS1)  list the neighbours of each unknown, each of them once
 *   (DS2)  merge unknowns with equal neighbourhoods, themselves included, into one vertex: such
 *          unknowns are neighbours. They are the d unknowns of a node, which divides vertices by d
 *          and edges by d^2
 *   (DS3)  call METIS on the vertices, weighted by the number of their unknowns
 *   (DS4)  go back from vertices to unknowns
 *
 * METIS merges vertices, too, but then draws two separators where one is enough: 0.5 s more of 3.4
 * s in 2D (320,800 unknowns).
 *
 * METIS draws from rand(), whose state belongs to the host: (DS3) restores the state. METIS also
 * catches SIGABRT and SIGTERM while it runs, in case it lacks memory, and afterwards restores them
 * as handlers of one signal: (DS3) restores the host's handlers. METIS's handler of SIGTERM jumps
 * out of whatever runs, malloc included, which spoils the heap: a thread of (DS3) puts the host's
 * handler back as soon as METIS has set its own, unless the graph is small, and the caller's thread
 * holds SIGTERM back until METIS has ended.
 * Cost: O(entries), and METIS. Fails: no memory.
 */
#define _XOPEN_SOURCE 600 /* initstate, setstate, sigaction, nanosleep */

#include "linear/dissection.h"

#include <metis.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "contact/contact.h"

typedef struct graph {
  idx_t n;
  size_t *start;  /* n + 1 */
  idx_t *other;   /* the neighbours of i from start[i] to start[i + 1] - 1 */
  uint64_t *hash; /* n: of a neighbourhood */
  idx_t *mark;    /* n: scratch; values are unknowns */
  idx_t *vertex;  /* n: the vertex that an unknown belongs to */
  idx_t *first;   /* n: the first unknown of each vertex */
  idx_t *x;       /* n + 1: like start, for vertices */
  idx_t *weight;  /* n: unknowns of each vertex */
  idx_t *turn;    /* n: place of each vertex in the elimination */
} graph;

/* (DS1) */
static void graph_neighbours(graph *g, size_t entries, const int *row, const int *col) {
  size_t *start = g->start;
  memset(start, 0, ((size_t)g->n + 1) * sizeof *start);
  for (size_t k = 0; k < entries; k++)
    if (row[k] != col[k]) {
      start[row[k] - 1]++;
      start[col[k] - 1]++;
    }
  for (idx_t i = 0; i < g->n; i++) /* ends, ... */
    start[i + 1] += start[i];
  for (size_t k = 0; k < entries; k++) /* ... which become starts */
    if (row[k] != col[k]) {
      g->other[--start[row[k] - 1]] = col[k] - 1;
      g->other[--start[col[k] - 1]] = row[k] - 1;
    }
  for (idx_t i = 0; i < g->n; i++)
    g->mark[i] = -1;
  size_t end = 0;
  for (idx_t i = 0; i < g->n; i++) {
    size_t k = start[i];
    start[i] = end;
    for (; k < start[i + 1]; k++) {
      const idx_t j = g->other[k];
      if (g->mark[j] == i) continue;
      g->mark[j] = i;
      g->other[end++] = j;
    }
  }
  start[g->n] = end;
}

static uint64_t graph_mix(idx_t i) {
  return dlsi_mix((uint64_t)i + 1);
}

/* Returns 1 if i and j have equal neighbourhoods. mark: i at the neighbours of i and at i, n. */
static int graph_alike(const graph *g, idx_t i, idx_t j) {
  if (g->hash[i] != g->hash[j] || g->start[i + 1] - g->start[i] != g->start[j + 1] - g->start[j])
    return 0;
  for (size_t k = g->start[j]; k < g->start[j + 1]; k++)
    if (g->mark[g->other[k]] != i) return 0;
  return 1;
}

/* (DS2): fills vertex, first and weight; returns the number of vertices. */
static idx_t graph_merge(graph *g) {
  for (idx_t i = 0; i < g->n; i++) {
    g->hash[i] = graph_mix(i);
    for (size_t k = g->start[i]; k < g->start[i + 1]; k++)
      g->hash[i] += graph_mix(g->other[k]);
    g->weight[i] = 0;
  }
  idx_t count = 0;
  for (idx_t i = 0; i < g->n; i++) {
    g->mark[i] = i;
    for (size_t k = g->start[i]; k < g->start[i + 1]; k++)
      g->mark[g->other[k]] = i;
    idx_t v = -1;
    for (size_t k = g->start[i]; v < 0 && k < g->start[i + 1]; k++)
      if (g->other[k] < i && graph_alike(g, i, g->other[k])) v = g->vertex[g->other[k]];
    if (v < 0) g->first[v = count++] = i;
    g->vertex[i] = v;
    g->weight[v]++;
  }
  return count;
}

/* Makes `other` the neighbours of the vertices, in place. Vertices are neighbours if and only if
 * their first unknowns are. Returns 0 if there are more than METIS can count. */
static int graph_contract(graph *g, idx_t count) {
  size_t end = 0;
  for (idx_t v = 0; v < count; v++) {
    g->x[v] = (idx_t)end;
    for (size_t k = g->start[g->first[v]]; k < g->start[g->first[v] + 1]; k++) {
      const idx_t j = g->other[k];
      if (g->first[g->vertex[j]] == j) g->other[end++] = g->vertex[j];
    }
    if (end > IDX_MAX) return 0;
  }
  g->x[count] = (idx_t)end;
  return 1;
}

/* Asks for more memory than METIS will: METIS prints if it gets none. Returns 1 if there is
 * enough. */
static int metis_has_memory(idx_t count, idx_t edges) {
  void *trial = dlsi_alloc(64 * (size_t)count + 24 * (size_t)edges, 1);
  free(trial);
  return trial != NULL;
}

enum { small = 1000 }; /* vertices: ordered in 3 ms, and the thread takes .1 ms */

typedef struct host {
  struct sigaction abort, term;
  atomic_int metis_ended;
} host;

/* Puts the host's handler of SIGTERM back once METIS has replaced it. */
static void *host_watch(void *data) {
  host *const h = data;
  struct sigaction now = h->term;
  while (now.sa_handler == h->term.sa_handler && !atomic_load(&h->metis_ended)) {
    (void)nanosleep(&(struct timespec){.tv_nsec = 20000}, NULL);
    (void)sigaction(SIGTERM, NULL, &now);
  }
  (void)sigaction(SIGTERM, &h->term, NULL);
  return NULL;
}

/* (DS3) Fills turn; returns METIS's code. */
static int metis_run(graph *g, idx_t count) {
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_COMPRESS] = 0;
  char state[64];
  host h = {.metis_ended = 0};
  sigset_t all, mask;
  pthread_t watch;
  dlsi_lock();
  (void)sigaction(SIGABRT, NULL, &h.abort);
  (void)sigaction(SIGTERM, NULL, &h.term);
  (void)sigfillset(&all);
  (void)pthread_sigmask(SIG_SETMASK, &all, &mask); /* the watch inherits it */
  const int watched = count > small && !pthread_create(&watch, NULL, host_watch, &h);
  sigset_t without_term = mask;
  (void)sigaddset(&without_term, SIGTERM);
  (void)pthread_sigmask(SIG_SETMASK, &without_term, NULL);
  char *const draws = initstate(1, state, sizeof state);
  const int answer = METIS_NodeND(&count, g->x, g->other, g->weight, options, g->mark, g->turn);
  if (draws) setstate(draws);
  atomic_store(&h.metis_ended, 1);
  if (watched) (void)pthread_join(watch, NULL);
  (void)sigaction(SIGABRT, &h.abort, NULL);
  (void)sigaction(SIGTERM, &h.term, NULL);
  (void)pthread_sigmask(SIG_SETMASK, &mask, NULL);
  dlsi_unlock();
  return answer;
}

/* (DS4) order: unknowns in the order of elimination, n. x becomes the next place of each vertex. */
static void graph_spread(graph *g, idx_t count, int *order) {
  memset(g->x, 0, ((size_t)count + 1) * sizeof *g->x);
  for (idx_t v = 0; v < count; v++)
    g->x[g->turn[v] + 1] = g->weight[v];
  for (idx_t v = 0; v < count; v++)
    g->x[v + 1] += g->x[v];
  for (idx_t i = 0; i < g->n; i++)
    order[g->x[g->turn[g->vertex[i]]]++] = i;
}

dls_status dlsi_dissection(int n, size_t entries, const int *row, const int *col, int *order,
                           dls_error *error) {
  const size_t N = (size_t)n;
  graph g = {.n = n};
  g.start = dlsi_alloc(N + 1, sizeof *g.start);
  g.hash = dlsi_alloc(N, sizeof *g.hash);
  g.other = dlsi_alloc(2 * entries, sizeof *g.other);
  g.x = dlsi_alloc(6 * N + 1, sizeof *g.x);
  int answer = METIS_ERROR_MEMORY;
  if (g.start && g.hash && g.other && g.x) {
    idx_t **const pieces[] = {&g.mark, &g.vertex, &g.first, &g.weight, &g.turn};
    for (size_t k = 0; k < 5; k++)
      *pieces[k] = g.x + 1 + (k + 1) * N;
    graph_neighbours(&g, entries, row, col);
    const idx_t count = graph_merge(&g);
    if (graph_contract(&g, count) && metis_has_memory(count, g.x[count]))
      answer = metis_run(&g, count);
    if (answer == METIS_OK) graph_spread(&g, count, order);
  }
  free(g.x);
  free(g.other);
  free(g.hash);
  free(g.start);
  if (answer == METIS_OK) return DLS_OK;
  return dlsi_fail(error, DLS_E_MEMORY, "", -1, answer,
                   "out of memory in the ordering, METIS's code %d", answer);
}
