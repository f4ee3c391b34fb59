/*
 * cholesky_analyse.c: the supernodes of a sparse Cholesky factor and their rows.
 *
 *   (CH1)  neighbours of each position that come before it
 *   (CH2)  elimination tree of the positions before c (Liu, ACM Trans. Math. Software 12, 1986,
 *          127-148), and its postorder, which becomes the order
 *   (CH3)  entries of each column of L: row k holds the columns on the paths from its neighbours
 *          up to k
 *   (CH4)  supernodes: chains of the tree in which a column has all rows of the last one but one
 *   (CH5)  merge a supernode into the next one, its parent, if that adds at most `spare` zeros and
 *          fills at most a third of the panel with them: else a long chain could be mostly zeros
 *   (CH6)  rows of the supernodes, by the paths of (CH3) on their tree; they come out ascending
 *   (CH7)  the place of each entry of A in L
 *
 * A position whose parent would be in c is a root. c, at the end, is one supernode and dense.
 * Cost: O(entries of L) for (CH3), less for the others. Fails: no memory.
 */
#include <stdlib.h>
#include <string.h>

#include "linear/cholesky.h"

/* Zeros that a merge of supernodes may add. Half the number or twice as many give the same time per
 * solve: then fewer supernodes are better. */
enum { spare = 100 };
static const double share = 1. / 3; /* (CH5) */

typedef struct analysis {
  int n, inner;  /* positions; those before c */
  size_t *start; /* n + 1 */
  int *before;   /* neighbours of position k that come before it, start[k] .. start[k+1]-1 */
  int *parent;   /* n: of the tree; of supernodes from (CH5) on; -1 for a root */
  int *mark;     /* n */
  int *a, *b;    /* n: scratch */
} analysis;

/* (CH1) */
static void analyse_neighbours(analysis *g, const dlsi_cholesky *to, const int *row,
                               const int *col) {
  memset(g->start, 0, ((size_t)g->n + 1) * sizeof *g->start);
  for (int fill = 0; fill < 2; fill++) {
    for (size_t k = 0; k < to->entries; k++) {
      const int i = to->place[row[k] - 1], j = to->place[col[k] - 1];
      if (i == j) continue;
      const int low = i < j ? i : j, high = i < j ? j : i;
      if (fill)
        g->before[--g->start[high]] = low;
      else
        g->start[high]++;
    }
    for (int k = 0; !fill && k < g->n; k++) /* ends, which the second turn makes starts */
      g->start[k + 1] += g->start[k];
  }
}

/* (CH2) */
static void analyse_tree(analysis *g) {
  int *ancestor = g->a;
  for (int k = 0; k < g->inner; k++) {
    g->parent[k] = ancestor[k] = -1;
    for (size_t e = g->start[k]; e < g->start[k + 1]; e++)
      for (int i = g->before[e], next; i >= 0 && i < k; i = next) {
        next = ancestor[i];
        ancestor[i] = k;
        if (next < 0) g->parent[i] = k;
      }
  }
}

/* (CH2) Renumbers the positions of `to` and the tree. The children of a node are consecutive, the
 * one with the highest number right before the node. */
static void analyse_postorder(analysis *g, dlsi_cholesky *to) {
  int *child = g->a, *sibling = g->b, *stack = g->mark, *turn = to->unknown;
  int next = 0, top = 0, root = -1;
  for (int k = 0; k < g->inner; k++)
    child[k] = -1;
  for (int k = g->inner - 1; k >= 0; k--) {
    int *const list = g->parent[k] < 0 ? &root : &child[g->parent[k]];
    sibling[k] = *list;
    *list = k;
  }
  for (; root >= 0; root = sibling[root])
    for (stack[top++] = root; top > 0;) {
      const int k = stack[top - 1], below = child[k];
      if (below >= 0) {
        child[k] = sibling[below];
        stack[top++] = below;
      } else {
        top--;
        turn[k] = next++;
      }
    }
  for (int k = 0; k < g->inner; k++)
    g->a[turn[k]] = g->parent[k] < 0 ? -1 : turn[g->parent[k]];
  memcpy(g->parent, g->a, (size_t)g->inner * sizeof *g->parent);
  for (int i = 0; i < g->n; i++)
    if (to->place[i] < g->inner) to->place[i] = turn[to->place[i]];
  for (int i = 0; i < g->n; i++)
    to->unknown[to->place[i]] = i;
}

/* (CH3) Fills count, n. */
static void analyse_counts(analysis *g, int *count) {
  for (int k = 0; k < g->n; k++)
    g->mark[k] = -1;
  for (int k = 0; k < g->n; k++) {
    g->mark[k] = k;
    count[k] = 1;
    for (size_t e = g->start[k]; e < g->start[k + 1]; e++)
      for (int j = g->before[e]; j >= 0 && j < g->inner && g->mark[j] != k; j = g->parent[j]) {
        g->mark[j] = k;
        count[j]++;
      }
  }
}

/* (CH4) Fills first and owner; returns the number of supernodes. count: entries of the columns. */
static int analyse_chains(const analysis *g, dlsi_cholesky *to, const int *count) {
  int s = 0;
  for (int k = 0; k < g->inner; k++) {
    const int joins = k > 0 && g->parent[k - 1] == k && count[k - 1] == count[k] + 1;
    if (!joins) to->first[s++] = k;
    to->owner[k] = s - 1;
  }
  to->first[s] = g->inner;
  return s;
}

/* (CH5) Merges, appends c, and makes parent the tree of the supernodes. size: rows of the panels,
 * which start with the entries of their first columns; scratch, n. */
static void analyse_merge(analysis *g, dlsi_cholesky *to, const int *count, int chains) {
  int *first = to->first, *size = g->a, *joins = g->b;
  double padded = 0, width = 0; /* zeros and columns of the panel that grows */
  for (int s = chains - 1; s >= 0; s--) {
    const int columns = first[s + 1] - first[s], above = g->parent[first[s + 1] - 1];
    size[s] = count[first[s]];
    const int next = above >= 0 && to->owner[above] == s + 1;
    const double rows = next ? columns + size[s + 1] : 0, zeros = columns * (rows - size[s]);
    joins[s] = next && zeros <= spare && padded + zeros <= share * rows * (width + columns);
    if (joins[s]) size[s] = columns + size[s + 1];
    padded = joins[s] ? padded + zeros : 0;
    width = joins[s] ? width + columns : columns;
  }
  to->count = 0;
  for (int s = 0; s < chains; s++)
    if (s == 0 || !joins[s - 1]) first[to->count++] = first[s];
  if (to->kept > 0) first[to->count++] = g->inner;
  first[to->count] = g->n;
  for (int s = 0; s < to->count; s++)
    for (int k = first[s]; k < first[s + 1]; k++)
      to->owner[k] = s;
  for (int s = 0; s < to->count; s++) { /* s comes at or before its last column */
    const int last = first[s + 1] - 1, above = last < g->inner ? g->parent[last] : -1;
    g->parent[s] = above < 0 ? -1 : to->owner[above];
  }
}

/* (CH6) Counts the rows of each supernode into start (fill = 0), or fills row. */
static void analyse_rows(analysis *g, dlsi_cholesky *to, int fill) {
  for (int s = 0; s < to->count; s++)
    g->mark[s] = -1;
  for (int k = 0; k < g->n; k++)
    for (size_t e = g->start[k]; e < g->start[k + 1]; e++)
      for (int s = to->owner[g->before[e]]; s >= 0 && s != to->owner[k] && g->mark[s] != k;
           s = g->parent[s]) {
        g->mark[s] = k;
        if (fill)
          to->row[to->todo[s]++] = k;
        else
          to->start[s + 1]++;
      }
}

/* (CH6) Lays the panels out and measures them. */
static void analyse_panels(dlsi_cholesky *to) {
  to->panel[0] = 0;
  for (int s = 0; s < to->count; s++) {
    const size_t end = to->start[s + 1], columns = (size_t)(to->first[s + 1] - to->first[s]);
    const size_t rows = end - to->start[s];
    const double c = (double)columns, r = (double)rows;
    to->panel[s + 1] = to->panel[s] + (columns + rows) * columns;
    to->flops += c * c * c / 3 + r * c * c + r * r * c;
    if ((int)(columns + rows) > to->longest) to->longest = (int)(columns + rows);
    for (size_t k = to->start[s], next; k < end; k = next) {
      for (next = k; next < end && to->owner[to->row[next]] == to->owner[to->row[k]];)
        next++;
      if ((end - k) * (next - k) > to->update) to->update = (end - k) * (next - k);
    }
  }
}

/* Returns the place in L of the entry in row `high` and column `low`, positions. */
static size_t analyse_place(const dlsi_cholesky *to, int high, int low) {
  const int s = to->owner[low];
  const size_t columns = (size_t)(to->first[s + 1] - to->first[s]);
  const size_t rows = columns + to->start[s + 1] - to->start[s];
  size_t i = (size_t)(high - to->first[s]);
  if (i >= columns) {
    size_t from = to->start[s], end = to->start[s + 1];
    while (end - from > 1) { /* the row is there: row[from] <= high < row[end] */
      const size_t middle = from + (end - from) / 2;
      if (to->row[middle] <= high)
        from = middle;
      else
        end = middle;
    }
    i = columns + from - to->start[s];
  }
  return to->panel[s] + i + (size_t)(low - to->first[s]) * rows;
}

/* (CH7) */
static void analyse_places(dlsi_cholesky *to, const int *row, const int *col) {
  for (size_t k = 0; k < to->entries; k++) {
    const int i = to->place[row[k] - 1], j = to->place[col[k] - 1];
    to->where[k] = analyse_place(to, i > j ? i : j, i > j ? j : i);
  }
}

static dls_status analyse(analysis *g, dlsi_cholesky *to, const int *row, const int *col,
                          dls_error *error) {
  analyse_neighbours(g, to, row, col);
  analyse_tree(g);
  analyse_postorder(g, to);
  analyse_neighbours(g, to, row, col);
  int *count = to->local;
  analyse_counts(g, count);
  analyse_merge(g, to, count, analyse_chains(g, to, count));
  const size_t supernodes = (size_t)to->count;
  to->start = calloc(supernodes + 1, sizeof *to->start);
  to->panel = dlsi_alloc(2 * supernodes + 1, sizeof *to->panel);
  if (!to->start || !to->panel) return dlsi_no_memory(error);
  to->todo = to->panel + supernodes + 1;
  analyse_rows(g, to, 0);
  for (size_t s = 0; s < supernodes; s++) {
    to->todo[s] = to->start[s];
    to->start[s + 1] += to->start[s];
  }
  to->row = dlsi_alloc(to->start[supernodes], sizeof *to->row);
  if (!to->row) return dlsi_no_memory(error);
  analyse_rows(g, to, 1);
  analyse_panels(to);
  analyse_places(to, row, col);
  to->x = dlsi_alloc((size_t)to->longest, sizeof *to->x);
  return to->x ? DLS_OK : dlsi_no_memory(error);
}

dls_status dlsi_cholesky_create(dlsi_cholesky **out, int n, size_t entries, const int *row,
                                const int *col, const int *order, int kept, dls_error *error) {
  *out = NULL;
  dlsi_cholesky *to = calloc(1, sizeof *to);
  if (!to) return dlsi_no_memory(error);
  const size_t N = (size_t)n;
  analysis g = {.n = n, .inner = n - kept};
  to->n = n;
  to->kept = kept;
  to->entries = entries;
  to->unknown = dlsi_alloc(7 * N + 1, sizeof *to->unknown);
  to->where = dlsi_alloc(entries, sizeof *to->where);
  to->y = dlsi_alloc(3 * N, sizeof *to->y);
  g.start = dlsi_alloc(N + 1, sizeof *g.start);
  g.before = dlsi_alloc(entries, sizeof *g.before);
  g.parent = dlsi_alloc(4 * N, sizeof *g.parent);
  dls_status status = DLS_OK;
  if (!to->unknown || !to->where || !to->y || !g.start || !g.before || !g.parent)
    status = dlsi_no_memory(error);
  if (!status) {
    int **const pieces[] = {&to->place, &to->owner, &to->head, &to->next, &to->local, &to->first};
    for (size_t k = 0; k < sizeof pieces / sizeof pieces[0]; k++)
      *pieces[k] = to->unknown + (k + 1) * N;
    to->held = to->y + N;
    to->pivot = to->held + N;
    g.mark = g.parent + N;
    g.a = g.mark + N;
    g.b = g.a + N;
    for (size_t i = 0; i < N; i++)
      to->place[i] = order[i] - 1;
    status = analyse(&g, to, row, col, error);
  }
  free(g.parent);
  free(g.before);
  free(g.start);
  if (status)
    dlsi_cholesky_destroy(to);
  else
    *out = to;
  return status;
}
