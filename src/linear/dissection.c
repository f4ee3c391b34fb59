/*
 * dissection.c: nested dissection of the graph of a sparse matrix by METIS (Karypis and Kumar, SIAM J.
 * Sci. Comput. 20, 1998, 359-392).
 *
 *   (D1)  adjacency of each unknown, without doubles
 *   (D2)  unknowns with the same neighbours, themselves included, become one vertex: the d unknowns of
 *         a node, which divides vertices by d and edges by d^2
 *   (D3)  METIS on the vertices, weighted by what they stand for
 *   (D4)  vertices back to unknowns
 *
 * METIS draws from rand(), whose state belongs to the host: it is put back afterwards. It also holds
 * SIGABRT and SIGTERM while it runs, for its own lack of memory, and puts them back.
 * Cost: O(entries), and METIS. Fails: no memory.
 */
#define _XOPEN_SOURCE 600 /* initstate, setstate */

#include "linear/dissection.h"

#include <metis.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/base.h"

typedef struct graph {
  idx_t n;
  size_t *start;  /* n + 1 */
  idx_t *other;   /* neighbours, without doubles and the vertex itself */
  idx_t *mark;    /* n: room; values are vertices */
  idx_t *vertex;  /* n: what an unknown is merged into */
  idx_t *first;   /* n: an unknown of each vertex */
  uint64_t *hash; /* n: of the neighbours and itself */
  idx_t *chain;   /* n: list of vertices of the same hash bucket */
  idx_t *bucket;  /* n */
} graph;

/* (D1) */
static void gather(graph *g, size_t entries, const int *row, const int *col) {
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
    const size_t begin = start[i];
    start[i] = end;
    g->mark[i] = i;
    for (size_t k = begin; k < start[i + 1]; k++) {
      const idx_t j = g->other[k];
      if (g->mark[j] == i) continue;
      g->mark[j] = i;
      g->other[end++] = j;
    }
  }
  start[g->n] = end;
}

static uint64_t mix(idx_t i) {
  uint64_t h = ((uint64_t)i + 1) * 0x9e3779b97f4a7c15u;
  h ^= h >> 32;
  return h * 0xd6e8feb86659fd93u;
}

/* i and j have the same neighbours, themselves included. mark holds the neighbours of i. */
static int same(const graph *g, idx_t i, idx_t j) {
  if (g->start[i + 1] - g->start[i] != g->start[j + 1] - g->start[j] || g->mark[j] != i) return 0;
  for (size_t k = g->start[j]; k < g->start[j + 1]; k++)
    if (g->mark[g->other[k]] != i) return 0;
  return 1;
}

/* (D2): vertex and first; returns the number of vertices. Candidates have the same hash. */
static idx_t merge(graph *g) {
  for (idx_t i = 0; i < g->n; i++) {
    g->hash[i] = mix(i);
    for (size_t k = g->start[i]; k < g->start[i + 1]; k++)
      g->hash[i] += mix(g->other[k]);
    g->bucket[i] = g->mark[i] = -1;
  }
  idx_t count = 0;
  for (idx_t i = 0; i < g->n; i++) {
    idx_t *head = g->bucket + g->hash[i] % (uint64_t)g->n;
    g->mark[i] = i;
    for (size_t k = g->start[i]; k < g->start[i + 1]; k++)
      g->mark[g->other[k]] = i;
    idx_t v = *head;
    while (v >= 0 && !(g->hash[g->first[v]] == g->hash[i] && same(g, i, g->first[v])))
      v = g->chain[v];
    if (v < 0) {
      v = count++;
      g->first[v] = i;
      g->chain[v] = *head;
      *head = v;
    }
    g->vertex[i] = v;
  }
  return count;
}

/* The graph of the vertices: x (count + 1), adjacent (at most as many as `other`), weight (count).
 * Returns 0 if its edges are too many for METIS to count. */
static int contract(graph *g, idx_t count, idx_t *x, idx_t *adjacent, idx_t *weight) {
  memset(weight, 0, (size_t)count * sizeof *weight);
  for (idx_t i = 0; i < g->n; i++) {
    weight[g->vertex[i]]++;
    g->mark[i] = -1;
  }
  size_t end = 0;
  for (idx_t v = 0; v < count; v++) {
    x[v] = (idx_t)end;
    g->mark[v] = v;
    for (size_t k = g->start[g->first[v]]; k < g->start[g->first[v] + 1]; k++) {
      const idx_t w = g->vertex[g->other[k]];
      if (g->mark[w] == v) continue;
      g->mark[w] = v;
      adjacent[end++] = w;
    }
    if (end > IDX_MAX) return 0;
  }
  x[count] = (idx_t)end;
  return 1;
}

/* (D4) from turn[v], the place of vertex v; x (count + 1) is free by now */
static void spread(const graph *g, idx_t count, const idx_t *turn, const idx_t *weight, idx_t *x,
                   int *order) {
  memset(x, 0, ((size_t)count + 1) * sizeof *x);
  for (idx_t v = 0; v < count; v++)
    x[turn[v] + 1] = weight[v];
  for (idx_t v = 0; v < count; v++)
    x[v + 1] += x[v];
  for (idx_t i = 0; i < g->n; i++)
    order[x[turn[g->vertex[i]]]++] = i;
}

/* METIS prints when it has no memory: ask first for more than it will. 0 if that is not there. */
static int room_for_metis(idx_t count, idx_t entries) {
  void *room = dlsi_alloc(64 * (size_t)count + 24 * (size_t)entries, 1);
  free(room);
  return room != NULL;
}

/* (D3) */
static int dissect(idx_t count, idx_t *x, idx_t *adjacent, idx_t *weight, idx_t *inverse,
                   idx_t *turn) {
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_COMPRESS] = 0;
  char room[64];
  char *const host = initstate(1, room, sizeof room);
  const int answer = METIS_NodeND(&count, x, adjacent, weight, options, inverse, turn);
  if (host) setstate(host);
  return answer;
}

dls_status dlsi_dissection(int n, size_t entries, const int *row, const int *col, int *order,
                           dls_error *error) {
  const size_t N = (size_t)n, I = sizeof(idx_t);
  graph g = {.n = n};
  idx_t *const room = dlsi_alloc(5 * N, I);
  g.start = dlsi_alloc(N + 1, sizeof *g.start);
  g.hash = dlsi_alloc(N, sizeof *g.hash);
  g.other = dlsi_alloc(2 * entries, I);
  idx_t *const vertices = dlsi_alloc(4 * N + 1, I);
  idx_t *adjacent = NULL;
  int answer = METIS_ERROR_MEMORY;
  if (room && g.start && g.hash && g.other && vertices) {
    idx_t **const pieces[] = {&g.mark, &g.vertex, &g.first, &g.chain, &g.bucket};
    for (size_t k = 0; k < 5; k++)
      *pieces[k] = room + k * N;
    gather(&g, entries, row, col);
    const idx_t count = merge(&g);
    adjacent = dlsi_alloc(g.start[n], I);
    if (adjacent) {
      idx_t *const x = vertices, *const weight = x + N + 1, *const turn = weight + N;
      if (contract(&g, count, x, adjacent, weight) && room_for_metis(count, x[count]))
        answer = dissect(count, x, adjacent, weight, turn + N, turn);
      if (answer == METIS_OK) spread(&g, count, turn, weight, x, order);
    }
  }
  free(adjacent);
  free(vertices);
  free(g.other);
  free(g.hash);
  free(g.start);
  free(room);
  if (answer == METIS_OK) return DLS_OK;
  return dlsi_fail(error, DLS_E_MEMORY, "", -1, answer,
                   "out of memory in the ordering, METIS's code %d", answer);
}
