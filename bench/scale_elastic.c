/*
 * scale_elastic.c: two elastic bodies, the upper one pressed down on the lower one and along.
 *
 * Both are boxes of the same grid, glued to rigid bodies on their outer faces; their nodes meet.
 * With F the flexibility of the upper box on its lower face, the lower box, its mirror image
 * and E2 times as stiff, has D F D / E2, D = -1 for normals and 1 for tangents, so that
 *
 *   W = F + D F D / E2
 *
 * Without reactions the upper body moves as its rigid part does: q_n is the gap of two crowned and
 * slightly rough faces less the motion down, q_t the motion along. About half the contacts touch.
 */
#include "scale_elastic.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "reduction_boxes.h"

static const double stiffer = 2;           /* E2 */
static const double crown = 1.2;           /* at the edges, over the way down */
static const double rough = 0.02;          /* over the way down */
static const double along[2] = {0.4, 0.2}; /* over the way down */

/* Copies W of the pair; F: of the upper box. */
static void elastic_pair(elastic *a, const dls_contact *F) {
  const int d = F->d, m = d * F->nc;
  for (int j = 0; j < m; j++)
    for (int i = 0; i < m; i++) {
      const double sign = (i % d == 0) == (j % d == 0) ? 1 : -1;
      a->W[(size_t)i + (size_t)j * (size_t)m] =
          (1 + sign / stiffer) * F->W.a[(size_t)i + (size_t)j * (size_t)F->W.ld];
    }
}

/* Fills q of cells + 1 nodes a side. */
static void elastic_gaps(elastic *a, int cells, double down, uint64_t state) {
  const int d = a->contact.d;
  for (int k = 0; k < a->contact.nc; k++) {
    const double x = 2. * (k % (cells + 1)) / cells - 1, y = 2. * (k / (cells + 1)) / cells - 1;
    const double far = d == 3 ? (x * x + y * y) / 2 : x * x;
    a->q[d * k] = down * (crown * far + rough * bench_draw(&state) - 1);
    for (int t = 1; t < d; t++)
      a->q[d * k + t] = down * along[t - 1];
  }
}

/* Puts W by blocks in place of W dense. */
static int elastic_by_blocks(elastic *a) {
  const size_t d = (size_t)a->contact.d, nc = (size_t)a->contact.nc;
  a->p = calloc(nc + 1, sizeof *a->p);
  a->i = calloc(nc * nc, sizeof *a->i);
  a->x = calloc(d * d * nc * nc, sizeof *a->x);
  if (!a->p || !a->i || !a->x) return -1;
  const dls_dense W = a->contact.W;
  a->contact.W = (dls_dense){0};
  return dls_blocks_from_dense(&W, a->contact.d, a->p, a->i, a->x, &a->contact.Wb, NULL) ? -1 : 0;
}

/* Fills all but W by blocks from the grid of the upper box. */
static int elastic_fill(elastic *a, int d, int cells, double mu, uint64_t seed) {
  const int height = cells / 4 > 4 ? cells / 4 : 4, flat = d == 2 && height > 40 ? 40 : height;
  box b;
  dls_reduction *R = NULL;
  dls_contact F;
  if (box_create_glued(&b, d, cells, flat)) return -1;
  const int nc = b.model.nodes, m = d * nc;
  a->W = calloc((size_t)m * (size_t)m, sizeof *a->W);
  a->q = calloc((size_t)m, sizeof *a->q);
  a->mu = calloc((size_t)nc, sizeof *a->mu);
  int bad = !a->W || !a->q || !a->mu;
  for (int k = 0; !bad && k < nc; k++)
    a->mu[k] = mu;
  bad = bad || bench_reduce(&R, &b.model, NULL) || dls_reduction_contact(R, a->mu, &F, NULL);
  if (!bad) {
    a->contact = (dls_contact){.d = d, .nc = nc, .W = {m, m, m, a->W}, .q = a->q, .mu = a->mu};
    elastic_pair(a, &F);
    elastic_gaps(a, cells, 0.01 * flat, seed * 0x9E3779B97F4A7C15u + 1);
  }
  dls_reduction_destroy(R);
  box_free(&b);
  return bad ? -1 : 0;
}

void elastic_free(elastic *a) {
  free(a->W);
  free(a->q);
  free(a->mu);
  free(a->p);
  free(a->i);
  free(a->x);
  memset(a, 0, sizeof *a);
}

static const char *const elastic_kinds[] = {"elastic2", "elastic3", "elastic2-blocks",
                                            "elastic3-blocks"};
enum { elastic_count = sizeof elastic_kinds / sizeof elastic_kinds[0] };

const char *elastic_kind(int index) {
  return index >= 0 && index < elastic_count ? elastic_kinds[index] : NULL;
}

int elastic_create(elastic *a, const char *kind, int candidates, double mu, uint64_t seed) {
  int k = 0;
  memset(a, 0, sizeof *a);
  while (k < elastic_count && strcmp(kind, elastic_kinds[k]) != 0)
    k++;
  if (k == elastic_count || candidates > elastic_most) return -1;
  const int d = 2 + k % 2, side = d == 2 ? candidates : (int)round(sqrt(candidates));
  int bad = elastic_fill(a, d, side > 2 ? side - 1 : 1, mu, seed);
  if (!bad && k >= 2) bad = elastic_by_blocks(a);
  if (bad) elastic_free(a);
  return bad;
}
