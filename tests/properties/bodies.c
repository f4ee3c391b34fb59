/*
 * bodies.c: stacks of blocks on K itself, their statics, and the judge: bodies.h.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bodies.h"

const char *const stack_text[STACK_VERDICTS] = {"good",
                                                "solved, and no equilibrium exists",
                                                "not solved, and it stands",
                                                "a block is not in balance",
                                                "a plane carries another force",
                                                "a reaction is not in its cone",
                                                "K x = f + H r does not hold",
                                                "positions do not meet the laws"};

/* ---- lattices -------------------------------------------------------------------------------- */

typedef struct lattice {
  int w, h, left, base, first; /* squares; x and y of the lowest node on the left; its number */
  double k;                    /* stiffness of a bar */
} lattice;

typedef struct entry {
  int i, j;
  double x;
} entry;

typedef struct entries {
  entry *at;
  int count;
} entries;

static int node_of(const lattice *b, int x, int y) {
  return b->first + (x - b->left) + (b->w + 1) * (y - b->base);
}

/* A bar between two nodes, one unit away in x, y or both. */
static void add_bar(entries *K, double k, int one, int two, int dx, int dy) {
  const int node[2] = {one, two}, e[2] = {dx, dy};
  const double share = k / (dx * dx + dy * dy);
  for (int a = 0; a < 4; a++)
    for (int b = 0; b < 4; b++) {
      const double x = share * e[a & 1] * e[b & 1] * ((a >> 1) == (b >> 1) ? 1 : -1);
      if (x != 0)
        K->at[K->count++] = (entry){2 * node[a >> 1] + (a & 1), 2 * node[b >> 1] + (b & 1), x};
    }
}

static void add_lattice(entries *K, const lattice *b) {
  for (int y = b->base; y < b->base + b->h; y++)
    for (int x = b->left; x < b->left + b->w; x++) {
      const int at[4] = {node_of(b, x, y), node_of(b, x + 1, y), node_of(b, x, y + 1),
                         node_of(b, x + 1, y + 1)};
      add_bar(K, b->k, at[0], at[1], 1, 0);
      add_bar(K, b->k, at[2], at[3], 1, 0);
      add_bar(K, b->k, at[0], at[2], 0, 1);
      add_bar(K, b->k, at[1], at[3], 0, 1);
      add_bar(K, b->k, at[0], at[3], 1, 1);
      add_bar(K, b->k, at[1], at[2], -1, 1);
    }
}

/* Compressed columns of some entries, whose places may repeat; p (cols + 1), i and x: count. */
static dls_sparse compress(const entries *of, int rows, int cols, int *p, int *i, double *x) {
  memset(p, 0, ((size_t)cols + 1) * sizeof *p);
  for (int k = 0; k < of->count; k++)
    p[of->at[k].j + 1]++;
  for (int j = 0; j < cols; j++)
    p[j + 1] += p[j];
  for (int k = 0; k < of->count; k++) {
    const int to = p[of->at[k].j]++;
    i[to] = of->at[k].i;
    x[to] = of->at[k].x;
  }
  memmove(p + 1, p, (size_t)cols * sizeof *p);
  p[0] = 0;
  return (dls_sparse){rows, cols, p, i, x};
}

/* ---- a stack --------------------------------------------------------------------------------- */

void stack_free(stack *s) {
  free(s->f);
  free(s->mu);
  free(s->block);
  free(s->place);
  free(s->index);
  free(s->numbers);
  memset(s, 0, sizeof *s);
}

/* Each block overlaps the one below by a square or more. */
static void draw_lattices(dice *g, stack *s, lattice *b) {
  const int luck = dice_below(g, 20), most = luck < 14 ? 4 : luck < 19 ? 12 : BLOCKS_MAX;
  s->blocks = 1 + dice_below(g, most);
  for (int k = 0; k < s->blocks; k++) {
    b[k] = (lattice){.w = 1 + dice_below(g, 4), .h = 1 + dice_below(g, 2)};
    b[k].k = exp2(10 + dice_below(g, 12));
    const int room = k ? b[k - 1].w + b[k].w - 1 : 1;
    b[k].left = k ? b[k - 1].left - b[k].w + 1 + dice_below(g, room) : 0;
    if (k && dice_below(g, 4)) { /* at rest in the middle, as well as whole numbers allow */
      b[k].w = b[k - 1].w;
      b[k].left = b[k - 1].left;
    }
    b[k].base = k ? b[k - 1].base + b[k - 1].h : 0;
    b[k].first = k ? b[k - 1].first + (b[k - 1].w + 1) * (b[k - 1].h + 1) : 0;
    s->nodes = b[k].first + (b[k].w + 1) * (b[k].h + 1);
  }
  s->n = 2 * s->nodes;
}

/* The candidates of plane k: nodes of both sides at the same place. */
static void add_plane(stack *s, const lattice *b, int k, entries *N, entries *T) {
  const lattice *up = &b[k], *down = k ? &b[k - 1] : NULL;
  int from = up->left, to = up->left + up->w;
  if (down && down->left > from) from = down->left;
  if (down && down->left + down->w < to) to = down->left + down->w;
  s->planes[k] = (plane){.height = up->base, .first = s->nc, .contacts = to - from + 1};
  for (int x = from; x <= to; x++, s->nc++) {
    const int one = node_of(up, x, up->base);
    N->at[N->count++] = (entry){2 * one + 1, s->nc, 1};
    T->at[T->count++] = (entry){2 * one, s->nc, 1};
    if (!down) continue;
    const int two = node_of(down, x, up->base);
    N->at[N->count++] = (entry){2 * two + 1, s->nc, -1};
    T->at[T->count++] = (entry){2 * two, s->nc, -1};
  }
}

/* Weights of all nodes, a push to the side and a pull upwards, in sixteenths. */
static void draw_loads(dice *g, stack *s, const lattice *b, double mu) {
  static const double part[5] = {0, 0.125, 0.5, 0.875, 1.5};
  const int heavy = dice_below(g, 3) ? 0 : dice_below(g, 20);
  double weight = 0;
  const int pushed = dice_below(g, s->blocks);
  for (int k = s->blocks - 1; k >= 0; k--) {
    const double own = exp2(dice_below(g, heavy + 1)) * (1 + dice_below(g, 8)) / 16;
    for (int i = b[k].first; i < (k + 1 < s->blocks ? b[k + 1].first : s->nodes); i++) {
      s->f[2 * i + 1] = -own;
      if (k >= pushed) weight += own;
    }
  }
  const int at =
      node_of(&b[pushed], b[pushed].left, b[pushed].base + dice_below(g, b[pushed].h + 1));
  s->f[2 * at] = floor(16 * part[dice_below(g, 5)] * mu * weight) / 16;
  if (dice_below(g, 6)) return;
  const int top = dice_below(g, s->blocks);
  const int up =
      node_of(&b[top], b[top].left + dice_below(g, b[top].w + 1), b[top].base + b[top].h);
  s->f[2 * up + 1] += floor(16 * (dice_below(g, 2) ? 0.25 : 2) * weight) / 16;
}

/* x of candidate c; the first entry of its column is the node above. */
static double place_of(const stack *s, int c) {
  return s->place[2 * (s->HN.i[s->HN.p[c]] / 2)];
}

/* Returns how far plane p is from its limits, over them: > 0 inside. */
static double margin_of(const stack *s, const plane *p, stack_kind *how) {
  const double mu = s->mu[p->first];
  *how = LIFTED;
  if (p->N <= 0) return p->N < 0 ? -1 : 0;
  const double slide = 1 - fabs(p->T) / (mu * p->N);
  const double a = place_of(s, p->first), b = place_of(s, p->first + p->contacts - 1);
  const double at = p->M / p->N;
  const double tip = fmin(at - a, b - at) / (b - a);
  *how = slide < tip ? SLIDES : TIPS;
  return fmin(slide, tip);
}

/* Statics: resultants of the planes, and whether they can carry them. */
static void find_resultants(stack *s) {
  double least = 1;
  stack_kind worst = STANDS;
  for (int k = 0; k < s->blocks; k++) {
    plane *p = &s->planes[k];
    double moment = 0;
    for (int i = 0; i < s->nodes; i++) {
      if (s->block[i] < k) continue;
      p->N -= s->f[2 * i + 1];
      p->T -= s->f[2 * i];
      moment += s->place[2 * i] * s->f[2 * i + 1] - s->place[2 * i + 1] * s->f[2 * i];
    }
    p->M = -moment + p->height * p->T;
    stack_kind how;
    const double margin = margin_of(s, p, &how);
    if (margin >= least) continue;
    least = margin;
    worst = how;
  }
  s->kind = least >= 0.0625 ? STANDS : least > -0.0625 ? ON_EDGE : worst;
}

void stack_generate(uint64_t seed, stack *s) {
  lattice b[BLOCKS_MAX];
  dice g = {seed ^ 0x6a09e667f3bcc909u};
  stack_free(s);
  draw_lattices(&g, s, b);
  int squares = 0, most = 0;
  for (int k = 0; k < s->blocks; k++) {
    squares += b[k].w * b[k].h;
    most += b[k].w + 1;
  }
  const size_t n = (size_t)s->n, bars = (size_t)(96 * squares), nc = (size_t)most;
  entries K = {problem_alloc(bars * sizeof(entry)), 0};
  entries N = {problem_alloc(2 * nc * sizeof(entry)), 0};
  entries T = {problem_alloc(2 * nc * sizeof(entry)), 0};
  s->f = problem_alloc(n * sizeof(double));
  s->mu = problem_alloc(nc * sizeof(double));
  s->block = problem_alloc((size_t)s->nodes * sizeof(int));
  s->place = problem_alloc(n * sizeof(double));
  s->index = problem_alloc((n + 1 + bars + 2 * (nc + 1) + 4 * nc) * sizeof(int));
  s->numbers = problem_alloc((bars + 4 * nc) * sizeof(double));
  for (int k = 0; k < s->blocks; k++) {
    add_lattice(&K, &b[k]);
    add_plane(s, b, k, &N, &T);
    for (int y = b[k].base; y <= b[k].base + b[k].h; y++)
      for (int x = b[k].left; x <= b[k].left + b[k].w; x++) {
        const int i = node_of(&b[k], x, y);
        s->block[i] = k;
        s->place[2 * i] = x;
        s->place[2 * i + 1] = y;
      }
  }
  int *i = s->index + n + 1;
  s->K = compress(&K, s->n, s->n, s->index, i, s->numbers);
  i += bars;
  s->HN = compress(&N, s->n, s->nc, i, i + nc + 1, s->numbers + bars);
  i += nc + 1 + 2 * nc;
  s->HT = compress(&T, s->n, s->nc, i, i + nc + 1, s->numbers + bars + 2 * nc);
  free(K.at);
  free(N.at);
  free(T.at);
  const double mu = (1 + dice_below(&g, 8)) / 8.0;
  for (int c = 0; c < s->nc; c++)
    s->mu[c] = mu;
  draw_loads(&g, s, b, mu);
  find_resultants(s);
}

/* ---- the judge ------------------------------------------------------------------------------- */

typedef long double real;

/* y += A x, rows of size |A||x| in a if not NULL; x: every step-th entry from `first` on */
static void add_columns(const dls_sparse *A, const double *x, int first, int step, real *y,
                        real *a) {
  for (int j = 0; j < A->cols; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++) {
      const real t = (real)A->x[k] * x[first + step * j];
      y[A->i[k]] += t;
      if (a) a[A->i[k]] += fabsl(t);
    }
}

/* Returns column c of A times x. */
static real dot_column(const dls_sparse *A, int c, const double *x) {
  real sum = 0;
  for (int k = A->p[c]; k < A->p[c + 1]; k++)
    sum += (real)A->x[k] * x[A->i[k]];
  return sum;
}

/* Sums over block k: rest (n) = f + H r - K x or f + H r; size (n): of |f| and |H r|. */
typedef struct balance {
  real x, y, moment, norm, size, lever;
  int n;
} balance;

static balance balance_of(const stack *s, int k, const real *rest, const real *loads) {
  balance b = {0};
  real cx = 0, cy = 0;
  for (int i = 0; i < s->nodes; i++)
    if (s->block[i] == k) cx = s->place[2 * i], cy = s->place[2 * i + 1];
  for (int i = 0; i < s->nodes; i++) {
    if (s->block[i] != k) continue;
    const real lx = s->place[2 * i] - cx, ly = s->place[2 * i + 1] - cy;
    b.x += rest[2 * i];
    b.y += rest[2 * i + 1];
    b.moment += lx * rest[2 * i + 1] - ly * rest[2 * i];
    b.norm = hypotl(b.norm, hypotl(rest[2 * i], rest[2 * i + 1]));
    b.size += loads[2 * i] + loads[2 * i + 1];
    b.lever = fmaxl(b.lever, hypotl(lx, ly));
    b.n += 2;
  }
  return b;
}

/* f + H r by blocks: forces and moments, the sums of n entries each of which may be tol wrong. */
static stack_verdict judge_blocks(const stack *s, const real *rest, const real *loads, double tol) {
  for (int k = 0; k < s->blocks; k++) {
    const balance b = balance_of(s, k, rest, loads);
    const real limit = sqrtl(b.n) * tol * b.size;
    if (!(hypotl(b.x, b.y) <= limit && fabsl(b.moment) <= limit * b.lever)) return STACK_BLOCK;
  }
  return STACK_GOOD;
}

static stack_verdict judge_planes(const stack *s, const double *r, double tol) {
  for (int k = 0; k < s->blocks; k++) {
    const plane *p = &s->planes[k];
    real N = 0, T = 0, M = 0, size = 0, far = 1;
    for (int c = p->first; c < p->first + p->contacts; c++) {
      const real x = place_of(s, c);
      N += r[2 * c];
      T += r[2 * c + 1];
      M += x * r[2 * c];
      far = fmaxl(far, fabsl(x));
    }
    for (int i = 0; i < s->n; i++)
      if (s->block[i / 2] >= k) size += fabs(s->f[i]);
    const real limit = sqrtl(s->n) * tol * 2 * (s->blocks - k) * size;
    far += s->planes[s->blocks - 1].height + 4;
    if (!(fabsl(N - p->N) <= limit && fabsl(T - p->T) <= limit && fabsl(M - p->M) <= far * limit))
      return STACK_PLANE;
  }
  return STACK_GOOD;
}

static stack_verdict judge_laws(const stack *s, const double *x, const double *r, double tol) {
  real most = 0, size = 0;
  for (int c = 0; c < s->nc; c++)
    most = fmaxl(most, hypotl(r[2 * c], r[2 * c + 1]));
  for (int i = 0; i < s->n; i++)
    size = fmaxl(size, fabsl((real)x[i]));
  const real small_u = 10 * tol * size, small_r = 10 * tol * most;
  for (int c = 0; c < s->nc; c++) {
    const real un = dot_column(&s->HN, c, x), ut = dot_column(&s->HT, c, x);
    const real rn = r[2 * c], rt = r[2 * c + 1], bound = s->mu[c] * rn;
    if (!(rn >= -small_r && fabsl(rt) <= bound + small_r)) return STACK_CONE;
    if (!(un >= -small_u && (un <= small_u || rn <= small_r))) return STACK_LAW;
    const int slips = fabsl(ut) > small_u && rn > small_r;
    if (slips && !(fabsl(rt) >= bound - small_r && rt * ut <= small_r * fabsl(ut)))
      return STACK_LAW;
  }
  return STACK_GOOD;
}

static stack_verdict judge_answer(const stack *s, const double *x, const double *r, double tol,
                                  real *rest, real *loads) {
  for (int i = 0; i < s->n; i++) {
    rest[i] = s->f[i];
    loads[i] = fabs(s->f[i]);
  }
  add_columns(&s->HN, r, 0, 2, rest, loads);
  add_columns(&s->HT, r, 1, 2, rest, loads);
  stack_verdict verdict = judge_blocks(s, rest, loads, tol);
  if (!verdict) verdict = judge_planes(s, r, tol);
  if (verdict) return verdict;
  for (int i = 0; i < s->n; i++)
    rest[i] = -rest[i];
  add_columns(&s->K, x, 0, 1, rest, NULL);
  for (int k = 0; k < s->blocks; k++) {
    const balance b = balance_of(s, k, rest, loads);
    if (!(b.norm <= 1.001L * tol * b.size)) return STACK_NODES;
  }
  return judge_laws(s, x, r, tol);
}

stack_verdict stack_judge(const stack *s, dls_status status, const double *x, const double *r,
                          double tol) {
  const int found = status == DLS_OK || status == DLS_TO_ROUNDING;
  if (!found) return s->kind == STANDS ? STACK_DENIED : STACK_GOOD;
  if (s->kind != STANDS && s->kind != ON_EDGE) return STACK_CLAIMED;
  real *rest = problem_alloc(2 * (size_t)s->n * sizeof *rest);
  const stack_verdict verdict =
      judge_answer(s, x, r, status == DLS_OK ? tol : fmax(tol, 1e-4), rest, rest + s->n);
  free(rest);
  return verdict;
}

int stack_run(uint64_t seed, uint64_t step, long count, double tol, stack_solver solve,
              void *user) {
  static const char *const word[] = {"stands", "slides", "tips", "lifted", "on edge"};
  long tally[5][STACK_VERDICTS] = {{0}};
  int good = 1;
  stack s = {0};
  for (long i = 0; i < count; i++) {
    const uint64_t own = seed + step * (uint64_t)i;
    stack_generate(own, &s);
    double *x = problem_alloc((size_t)s.n * sizeof *x);
    double *r = problem_alloc(2 * (size_t)s.nc * sizeof *r);
    const dls_status status = solve(user, &s, tol, x, r);
    const stack_verdict verdict = stack_judge(&s, status, x, r, tol);
    tally[s.kind][verdict]++;
    if (verdict)
      printf("stack %llu, %s, %d blocks: %s (%s)\n", (unsigned long long)own, word[s.kind],
             s.blocks, stack_text[verdict], dls_status_text(status));
    good &= verdict == STACK_GOOD;
    free(x);
    free(r);
  }
  for (int k = 0; k < 5; k++)
    for (int v = 0; v < STACK_VERDICTS; v++)
      if (tally[k][v]) printf("%-8s %6ld %s\n", word[k], tally[k][v], stack_text[v]);
  stack_free(&s);
  return good;
}
