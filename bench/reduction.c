/*
 * reduction.c: K, H -> W of elastic boxes by delassus and by what a careful user does without it.
 *
 *   reduction [--full] [--out DIR]   the smaller cases; --full: 30^3 elements and others (2 GB)
 *   reduction --large [--out DIR]    2D, 850 x 850 elements, without peers (6 GB)
 *
 * The peers factor K and solve for the columns of H: CHOLMOD for 64 columns at a time, adding H^T
 * X to W as it goes; UMFPACK for one. MUMPS alone is its factorisation with the Schur complement
 * in the order of delassus, without ordering, analysis and W: a bound for all methods by MUMPS.
 *
 * Each method runs in a child process that builds the box itself, so that its peak memory is its
 * own; W comes back in shared memory. delassus and MUMPS alone run three times in turn; the least
 * CPU time counts. A peer runs once. Writes DIR/reduction.csv and DIR/reduction.md.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include "common.h"
#include "reduction_boxes.h"
#include "reduction_peer.h"

void dgemm_(const char *, const char *, const int *, const int *, const int *, const double *,
            const double *, const int *, const double *, const int *, const double *, double *,
            const int *, size_t, size_t);

enum { turns = 3 };

typedef enum way { DELASSUS, COLUMNS, MUMPS_ALONE, WAYS } way;
static const char *const way_name[] = {"delassus", "columns", "MUMPS alone"};

typedef struct result {
  int failed, n, m;
  double cpu, peak;                  /* s, bytes */
  double foreseen, flops, condition; /* of dls_reduction_info */
  double load, update;               /* s: a new load; new values */
  double residual;                   /* |K X - H| / (|K||X|) of sampled columns */
  double recovered;                  /* |W(:,j) - H^T X| / |W(:,j)| of these */
  double before, inverse;            /* s: MUMPS alone; cpu is its factorisation */
} result;

/* One way on one box, in a child process. */
typedef struct trial {
  way w;
  int d, cells;
  double skew;
  double *W;   /* m x m, shared */
  result *out; /* shared */
} trial;

static double peak_bytes(void) {
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * (double)usage.ru_maxrss;
}

/* Raises *most to |x|; a NaN stays. */
static void raise_to(double *most, double x) {
  if (!(fabs(x) <= *most)) *most = fabs(x);
}

/* Measures residual and recovery on five columns of W. */
static int sample_columns(dls_reduction *R, const dls_model *model, const double *W, result *out) {
  const int n = model->n, m = model->d * model->nodes;
  double *x = calloc(2 * (size_t)n, sizeof *x), *r = calloc((size_t)m, sizeof *r);
  int bad = !x || !r;
  for (int k = 0; !bad && k < 5; k++) {
    const int j = (int)((long)k * (m - 1) / 4);
    const double *column = W + (size_t)j * (size_t)m;
    r[j] = 1;
    bad = dls_reduction_recover(R, r, x, NULL) != DLS_OK;
    r[j] = 0;
    x[n + picked(model, j)] = 1;
    raise_to(&out->residual, box_residual(model, x, x + n));
    x[n + picked(model, j)] = 0;
    double far = 0, size = 0;
    for (int i = 0; i < m; i++) {
      raise_to(&far, column[i] - x[picked(model, i)]);
      raise_to(&size, column[i]);
    }
    raise_to(&out->recovered, far / size);
  }
  free(r);
  free(x);
  return bad;
}

static int take_delassus(const dls_model *model, double *W, result *out) {
  dls_reduction_info info;
  dls_contact contact;
  dls_reduction *R;
  dls_error error = {.message = "out of memory"};
  double *mu = calloc((size_t)model->nodes, sizeof *mu);
  double *f = calloc((size_t)model->n, sizeof *f);
  double start = bench_seconds();
  if (!mu || !f || bench_reduce(&R, model, &error)) return fprintf(stderr, "%s\n", error.message);
  out->cpu = bench_seconds() - start;
  out->peak = peak_bytes();
  int bad = dls_reduction_get_info(R, &info, NULL) || dls_reduction_contact(R, mu, &contact, NULL);
  out->foreseen = info.bytes;
  out->flops = info.flops;
  out->condition = info.condition;
  const size_t m = (size_t)contact.W.rows;
  if (!bad) memcpy(W, contact.W.a, m * m * sizeof *W);
  f[model->n / 2] = 1;
  start = bench_seconds();
  bad = bad || dls_reduction_load(R, f, NULL, NULL);
  out->load = bench_seconds() - start;
  bad = bad || dls_reduction_load(R, NULL, NULL, NULL) || sample_columns(R, model, W, out);
  start = bench_seconds();
  bad = bad || dls_reduction_update(R, model, NULL);
  out->update = bench_seconds() - start;
  dls_reduction_destroy(R);
  free(f);
  free(mu);
  return bad;
}

static int take_columns(const dls_model *model, double *W, result *out) {
  const double start = bench_seconds();
  const int bad =
      model->factorization == DLS_CHOLESKY ? cholmod_columns(model, W) : umfpack_columns(model, W);
  out->cpu = bench_seconds() - start;
  return bad;
}

static void run_trial(void *data) {
  const trial *t = data;
  result *out = t->out;
  box b;
  if (box_create(&b, t->d, t->cells, t->skew)) return;
  out->n = b.model.n;
  out->m = b.model.d * b.model.nodes;
  out->failed = t->w == DELASSUS  ? take_delassus(&b.model, t->W, out)
                : t->w == COLUMNS ? take_columns(&b.model, t->W, out)
                                  : mumps_schur(&b.model, &out->before, &out->cpu, &out->inverse);
  if (out->peak == 0) out->peak = peak_bytes();
}

static result one_result(trial t, way w) {
  t.w = w;
  *t.out = (result){.failed = 1};
  if (bench_child(run_trial, &t)) t.out->failed = 1;
  return *t.out;
}

static double dgemm_rate(void) {
  const int n = 2000;
  const size_t N = (size_t)n * (size_t)n;
  double *A = calloc(3 * N, sizeof *A);
  if (!A) return NAN;
  const double one = 1, zero = 0;
  bench_clock c = {0};
  while (bench_runs(&c, 3, 0, 0))
    dgemm_("N", "N", &n, &n, &n, &one, A, &n, A + N, &n, &zero, A + 2 * N, &n, 1, 1);
  free(A);
  return 2.0 * n * n * n / c.least;
}

/* Returns the largest entry of V - W over that of W. */
static double difference(const double *V, const double *W, size_t entries) {
  double far = 0, size = 0;
  for (size_t k = 0; k < entries; k++) {
    raise_to(&far, V[k] - W[k]);
    raise_to(&size, W[k]);
  }
  return far / size;
}

/* ---- output ---------------------------------------------------------------------------------- */

typedef struct output {
  FILE *csv, *page;
} output;

static void write_csv(FILE *csv, const trial *t, way w, const result *r, double apart,
                      double rate) {
  if (!csv) return;
  fprintf(csv, "%s,%d,%d,%d,%d,%s,%.3f,%.4f,%.4f,%.2e,%.2e,%.2e,%.3f,%.3f,%.3f,%.3f,%.2f,%.2f\n",
          t->skew == 0 ? "definite" : "unsymmetric", t->d, t->cells, r->n, r->m, way_name[w],
          r->cpu, 1e-9 * r->peak, 1e-9 * r->foreseen, apart, r->residual, r->recovered, r->load,
          r->update, r->before, r->inverse, 1e-9 * r->flops / r->cpu, 1e-9 * rate);
  fflush(csv);
}

static void print_head(FILE *page) {
  bench_print(page, "%s",
              "CPU seconds and peak memory of a process. Columns: CHOLMOD, 64 columns of H at a "
              "time; UMFPACK, one at\na time, where K is not symmetric. Difference of W over its "
              "largest entry; residual |K X - H| / (|K||X|).\n\n"
              "| K | elements | unknowns | of contact | delassus s | GB | columns s | GB | columns "
              "/ delassus: time | memory | MUMPS alone s | W differs by | residual | new load s | "
              "new values s |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
}

/* Prints one row; ways that did not run leave their fields empty. */
static void print_row(FILE *page, const trial *t, const result *all, double apart) {
  const result *own = &all[DELASSUS], *peer = &all[COLUMNS];
  if (own->n < 6000) page = NULL; /* the screen shows all */
  bench_print(page, "| %s %dD | %d^%d | %d | %d | %.3g | %.3g |",
              t->skew == 0 ? "definite" : "unsymmetric", t->d, t->cells, t->d, own->n, own->m,
              own->cpu, 1e-9 * own->peak);
  if (peer->failed)
    bench_print(page, " | | | |");
  else
    bench_print(page, " %.3g | %.3g | %.2g | %.2g |", peer->cpu, 1e-9 * peer->peak,
                peer->cpu / own->cpu, peer->peak / own->peak);
  if (all[MUMPS_ALONE].failed)
    bench_print(page, " |");
  else
    bench_print(page, " %.3g |", all[MUMPS_ALONE].cpu);
  if (peer->failed)
    bench_print(page, " |");
  else
    bench_print(page, " %.0e |", apart);
  bench_print(page, " %.0e | %.2g | %.2g |\n", own->residual, own->load, own->update);
}

/* ---- one case -------------------------------------------------------------------------------- */

static int compare_ways(const output *to, int d, int cells, double skew, int peers) {
  const size_t m = (size_t)d * (size_t)cells * (size_t)(d == 3 ? cells + 1 : 1);
  const size_t bytes = m * m * sizeof(double);
  double *V = bench_shared(2 * bytes), *W = V ? V + m * m : NULL;
  trial t = {.d = d, .cells = cells, .skew = skew, .out = bench_shared(sizeof(result))};
  if (!V || !t.out) return 1;
  result best[WAYS] = {{0}, {.failed = 1}, {.failed = 1}};
  int failed = 0;
  for (int turn = 0; turn < (peers ? turns : 1); turn++) /* the two that are close, in turn */
    for (int w = MUMPS_ALONE; w >= DELASSUS; w -= MUMPS_ALONE) {
      if (w == MUMPS_ALONE && (!peers || skew != 0)) continue;
      t.W = w == DELASSUS ? V : W;
      const result r = one_result(t, (way)w);
      if (turn == 0 || r.cpu < best[w].cpu) best[w] = r;
      failed |= r.failed;
    }
  t.W = W;
  if (peers) best[COLUMNS] = one_result(t, COLUMNS);
  failed |= peers && best[COLUMNS].failed;
  const double apart = peers && !failed ? difference(W, V, m * m) : NAN, rate = dgemm_rate();
  for (way w = DELASSUS; w < WAYS; w++)
    if (best[w].n) write_csv(to->csv, &t, w, &best[w], w == COLUMNS ? apart : NAN, rate);
  print_row(to->page, &t, best, apart);
  munmap(t.out, sizeof(result));
  munmap(V, 2 * bytes);
  return failed;
}

static int run_cases(const output *to, int full) {
  static const struct {
    int d, cells, full;
    double skew;
  } cases[] = {{2, 50, 0, 0},   {2, 100, 0, 0},   {2, 200, 0, 0},    {2, 300, 1, 0},
               {3, 6, 0, 0},    {3, 10, 0, 0},    {3, 16, 0, 0},     {3, 22, 0, 0},
               {3, 30, 1, 0},   {2, 50, 0, 0.05}, {2, 100, 0, 0.05}, {2, 200, 1, 0.05},
               {3, 6, 0, 0.05}, {3, 10, 0, 0.05}, {3, 16, 1, 0.05}};
  int failed = 0;
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++)
    if (full || !cases[k].full)
      failed |= compare_ways(to, cases[k].d, cases[k].cells, cases[k].skew, 1);
  return failed;
}

int main(int argc, char **argv) {
  const int large = bench_has(argc, argv, "--large");
  output to = {.page = bench_program(argc, argv, "[--full] [--large] [--out DIR]",
                                     large ? "reduction_large" : "reduction",
                                     "K, H -> W by its Schur complement and column by column")};
  to.csv = bench_open(bench_word(argc, argv, "--out", "build"),
                      large ? "reduction_large.csv" : "reduction.csv");
  if (!to.csv) return EXIT_FAILURE;
  fputs(
      "K,d,cells,n,m,way,cpu_s,peak_GB,foreseen_GB,W_difference,residual,recovered,load_s,update_s,"
      "ordering_analysis_s,inverse_s,Gflops,dgemm_Gflops\n",
      to.csv);
  print_head(to.page);
  const int failed =
      large ? compare_ways(&to, 2, 850, 0, 0) : run_cases(&to, bench_has(argc, argv, "--full"));
  if (!large)
    bench_print(to.page, "\n![CPU time, memory and speed against unknowns](reduction.png)\n");
  fclose(to.page);
  fclose(to.csv);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
