/*
 * motion.c: compares the cost of the reduction in each step of a moving body with one solve.
 *
 *   motion [--out DIR]
 *
 * A step is dls_reduction_load, the contact problem (not timed here), dls_reduction_recover. The
 * peer is one solve by CHOLMOD with the same K: supernodal and simplicial, each with its own order;
 * the faster one counts. All three take turns in one process, each for as many steps as take 20 ms;
 * the least CPU time of the turns counts. x is compared with the peer's solve for the same f + H r,
 * and shown with the residual |K x - f - H r| / (|K||x|).
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cholmod_view.h"
#include "common.h"
#include "reduction_boxes.h"

/* ---- a solve by CHOLMOD --------------------------------------------------------------------- */

typedef struct peer {
  cholmod_common c;
  cholmod_factor *L;
  cholmod_dense *X, *Y, *E;
} peer;

static void peer_destroy(peer *p) {
  if (!p) return;
  cholmod_free_dense(&p->X, &p->c);
  cholmod_free_dense(&p->Y, &p->c);
  cholmod_free_dense(&p->E, &p->c);
  cholmod_free_factor(&p->L, &p->c);
  cholmod_finish(&p->c);
  free(p);
}

/* Factorises K; seconds: of the factorisation. NULL after a failure. */
static peer *peer_create(const dls_sparse *K, int supernodal, double *seconds) {
  peer *p = calloc(1, sizeof *p);
  if (!p) return NULL;
  cholmod_sparse A = cholmod_view(K);
  cholmod_start(&p->c);
  p->c.supernodal = supernodal ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
  const double start = bench_seconds();
  p->L = cholmod_analyze(&A, &p->c);
  const int ok = p->L && cholmod_factorize(&A, p->L, &p->c) && p->c.status == CHOLMOD_OK;
  *seconds = bench_seconds() - start;
  if (ok) return p;
  peer_destroy(p);
  return NULL;
}

/* Returns x of K x = b, valid until the next call; NULL after a failure. */
static const double *peer_solve(peer *p, const double *b) {
  cholmod_dense B = {.nrow = p->L->n,
                     .ncol = 1,
                     .nzmax = p->L->n,
                     .d = p->L->n,
                     .x = (void *)(size_t)b,
                     .xtype = CHOLMOD_REAL,
                     .dtype = CHOLMOD_DOUBLE};
  if (!cholmod_solve2(CHOLMOD_A, p->L, &B, NULL, &p->X, NULL, &p->Y, &p->E, &p->c)) return NULL;
  return p->X->x;
}

/* ---- the comparison -------------------------------------------------------------------------- */

enum { turns = 9 };

typedef struct measured {
  int failed, n, m;
  double create, factor; /* s: the reduction with W; the peer's factorisation, the faster one */
  double load, recover, solve[2];
  double apart, residual;
} measured;

typedef struct steps {
  dls_reduction *R;
  peer *of[2]; /* simplicial, supernodal */
  int n, m;
  double *f, *r, *b, *x; /* loads; reactions; f + H r; the answer */
} steps;

enum { LOAD, RECOVER, SIMPLICIAL, SUPERNODAL, CALLS };

static int one_call(const steps *s, int call) {
  if (call == LOAD) return dls_reduction_load(s->R, s->f, NULL, NULL) != DLS_OK;
  if (call == RECOVER) return dls_reduction_recover(s->R, s->r, s->x, NULL) != DLS_OK;
  return !peer_solve(s->of[call - SIMPLICIAL], s->b);
}

/* Adds to least[] the CPU seconds of one call of each kind, load and recover in turn. */
static int one_turn(const steps *s, double *least) {
  static const int kinds[3][2] = {
      {LOAD, RECOVER}, {SIMPLICIAL, SIMPLICIAL}, {SUPERNODAL, SUPERNODAL}};
  for (int k = 0; k < 3; k++) {
    double start = bench_seconds(), taken = 0, spent[2] = {0};
    int count = 0;
    while (taken < 0.02) {
      const int batch = count ? count : 1;
      for (int i = 0; i < batch; i++)
        for (int half = 0; half < 2; half++)
          if (one_call(s, kinds[k][half])) return 1;
      count += batch;
      taken = bench_seconds() - start;
    }
    if (k > 0) {
      spent[0] = taken / (2 * count);
    } else { /* the first half alone; the second one is the rest */
      start = bench_seconds();
      for (int i = 0; i < count; i++)
        if (one_call(s, LOAD)) return 1;
      spent[0] = (bench_seconds() - start) / count;
      spent[1] = taken / count - spent[0];
    }
    for (int half = 0; half < 2; half++)
      if (half == 0 || k == 0)
        if (!(spent[half] >= least[kinds[k][half]])) least[kinds[k][half]] = spent[half];
  }
  return 0;
}

/* Fills loads and reactions from equal random numbers each time, and b := f + H r. */
static void fill(const dls_model *model, steps *s) {
  uint64_t seed = 1;
  for (int k = 0; k < s->n + s->m; k++)
    *(k < s->n ? &s->f[k] : &s->r[k - s->n]) = bench_draw(&seed);
  memcpy(s->b, s->f, (size_t)s->n * sizeof *s->b);
  for (int c = 0; c < model->nodes; c++)
    for (int i = 0; i < model->d; i++) {
      const dls_sparse *H = i ? &model->HT : &model->HN;
      const int j = i ? (model->d - 1) * c + i - 1 : c;
      for (int k = H->p[j]; k < H->p[j + 1]; k++)
        s->b[H->i[k]] += H->x[k] * s->r[model->d * c + i];
    }
}

static int measure_steps(const dls_model *model, steps *s, measured *out) {
  double least[CALLS] = {INFINITY, INFINITY, INFINITY, INFINITY}, factor[2];
  const double start = bench_seconds();
  if (bench_reduce(&s->R, model, NULL)) return 1;
  out->create = bench_seconds() - start;
  for (int k = 0; k < 2; k++)
    if (!(s->of[k] = peer_create(&model->Ks, k, &factor[k]))) return 1;
  out->factor = fmin(factor[0], factor[1]);
  for (int k = 0; k < turns; k++)
    if (one_turn(s, least)) return 1;
  out->load = least[LOAD];
  out->recover = least[RECOVER];
  out->solve[0] = least[SIMPLICIAL];
  out->solve[1] = least[SUPERNODAL];
  const double *x = peer_solve(s->of[1], s->b);
  double size = 0;
  if (!x || one_call(s, RECOVER)) return 1;
  for (int i = 0; i < s->n; i++) {
    out->apart = fmax(out->apart, fabs(x[i] - s->x[i]));
    size = fmax(size, fabs(x[i]));
  }
  out->apart /= size;
  out->residual = box_residual(model, s->x, s->b);
  return 0;
}

static measured measure_box(int d, int cells) {
  measured out = {.failed = 1};
  box b;
  if (box_create(&b, d, cells, 0)) return out;
  const dls_model *model = &b.model;
  steps s = {.n = model->n, .m = model->d * model->nodes};
  const size_t n = (size_t)s.n;
  out.n = s.n;
  out.m = s.m;
  s.f = calloc(3 * n + (size_t)s.m, sizeof *s.f);
  if (s.f) {
    s.b = s.f + n;
    s.x = s.b + n;
    s.r = s.x + n;
    fill(model, &s);
    out.failed = measure_steps(model, &s, &out);
  }
  peer_destroy(s.of[0]);
  peer_destroy(s.of[1]);
  dls_reduction_destroy(s.R);
  free(s.f);
  box_free(&b);
  return out;
}

static int print_box(FILE *page, int d, int cells) {
  const measured r = measure_box(d, cells);
  if (r.failed) {
    fprintf(stderr, "%dD, %d cells: failed\n", d, cells);
    return 1;
  }
  const double best = fmin(r.solve[0], r.solve[1]);
  bench_print(r.n < 300 ? NULL : page,
              "| %dD %d^%d | %d | %d | %.3g | %.3g | %.3g | %.2f | %.0e | %.3g | %.3g |\n", d,
              cells, d, r.n, r.m, 1e6 * r.load, 1e6 * r.recover, 1e6 * best,
              (r.load + r.recover) / best, r.apart, r.create, r.factor);
  return 0;
}

int main(int argc, char **argv) {
  static const int boxes[][2] = {{2, 4},   {2, 8},   {2, 10}, {2, 12}, {2, 22}, {2, 45}, {2, 90},
                                 {2, 181}, {2, 256}, {3, 4},  {3, 8},  {3, 12}, {3, 18}, {3, 24}};
  FILE *page = bench_program(argc, argv, "[--out DIR]", "motion", "A step of a body that moves");
  bench_print(
      page, "%s",
      "Elastic boxes, one face held, all nodes of another one contacts. Microseconds of CPU: "
      "dls_reduction_load, dls_reduction_recover,\none solve by CHOLMOD with its simplicial or "
      "supernodal factor, the faster one. Ratio: load + recover over that. x\ndiffers by: distance "
      "from the peer's x over its largest entry. Seconds: dls_reduction_create with W, and the "
      "peer's factorisation.\n\n| elements | unknowns | of contact | load | recover | CHOLMOD | "
      "ratio | x differs by | create s | peer's factor s |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n");
  int failed = 0;
  for (size_t k = 0; k < sizeof boxes / sizeof boxes[0]; k++)
    failed |= print_box(page, boxes[k][0], boxes[k][1]);
  return fclose(page) != 0 || failed;
}
