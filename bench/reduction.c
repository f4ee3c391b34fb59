/*
 * reduction.c: K, H -> W by delassus beside the ways a user has without it, on elastic boxes.
 *
 * Each way runs in a child process of its own, which builds the box, so that its peak memory is its own;
 * W comes back through shared memory. delassus and MUMPS alone run three times in turn, the least CPU
 * time counts; the peers once. Writes bench/results/reduction.csv and prints the same.
 *
 *   reduction            the smaller cases
 *   reduction --full     the 3D box of 30^3 elements and others, too (7 GB)
 *   reduction --large    the 2D box of 850 x 850 elements alone, without peers (6 GB)
 *   reduction D CELLS SKEW    one case, on the screen only
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "clock.h"
#include "direct.h"
#include "elastic.h"

void dgemm_(const char *, const char *, const int *, const int *, const int *, const double *,
            const double *, const int *, const double *, const int *, const double *, double *,
            const int *, size_t, size_t);

enum { turns = 3 };

typedef enum way { DELASSUS, COLUMNS, COLUMNS_64, MUMPS_ALONE } way;
static const char *const names[] = {"delassus", "columns", "columns by 64", "MUMPS alone"};

typedef struct result {
  int failed, n, m;
  double cpu, peak; /* s, bytes */
  double foreseen, flops, condition;
  double load, update;    /* s: a new load; new values */
  double residual;        /* |K X - H| / (|K||X|) of sampled columns */
  double recovered;       /* |W(:,j) - H^T X| / |W(:,j)| of these */
  double before, inverse; /* s: MUMPS alone; cpu is its factorisation */
} result;

/* |K x - e| / (|K||x|), maximum norms, and |K| by rows */
static double residual_of(const dls_model *model, const double *x, int e, double *y, double *a) {
  const dls_sparse *K = &model->Ks;
  const int n = model->n, lower = model->factorization == DLS_CHOLESKY;
  memset(y, 0, (size_t)n * sizeof *y);
  memset(a, 0, (size_t)n * sizeof *a);
  for (int j = 0; j < n; j++)
    for (int k = K->p[j]; k < K->p[j + 1]; k++) {
      const int i = K->i[k];
      y[i] += K->x[k] * x[j];
      a[i] += fabs(K->x[k]);
      if (!lower || i == j) continue;
      y[j] += K->x[k] * x[i];
      a[j] += fabs(K->x[k]);
    }
  y[e] -= 1;
  double left = 0, norm = 0, size = 0;
  for (int i = 0; i < n; i++) {
    if (!(fabs(y[i]) <= left)) left = fabs(y[i]);
    if (!(a[i] <= norm)) norm = a[i];
    if (!(fabs(x[i]) <= size)) size = fabs(x[i]);
  }
  return left / (norm * size);
}

static int sample(dls_reduction *R, const dls_model *model, const double *W, result *out) {
  const int n = model->n, m = model->d * model->nodes;
  double *x = malloc(3 * (size_t)n * sizeof *x), *r = calloc((size_t)m, sizeof *r);
  int bad = !x || !r;
  for (int k = 0; !bad && k < 5; k++) {
    const int j = (int)((long)k * (m - 1) / 4);
    r[j] = 1;
    bad = dls_reduction_recover(R, r, x, NULL) != DLS_OK;
    r[j] = 0;
    const double left = residual_of(model, x, picked(model, j), x + n, x + 2 * n);
    if (!(left <= out->residual)) out->residual = left;
    double far = 0, size = 0;
    for (int i = 0; i < m; i++) {
      const double w = W[(size_t)i + (size_t)j * (size_t)m];
      if (!(fabs(w - x[picked(model, i)]) <= far)) far = fabs(w - x[picked(model, i)]);
      if (!(fabs(w) <= size)) size = fabs(w);
    }
    if (!(far / size <= out->recovered)) out->recovered = far / size;
  }
  free(r);
  free(x);
  return bad;
}

static int by_delassus(const dls_model *model, double *W, result *out) {
  dls_reduction_info info;
  dls_contact contact;
  dls_reduction *R;
  dls_error error;
  double *mu = calloc((size_t)model->nodes, sizeof *mu);
  double *f = calloc((size_t)model->n, sizeof *f);
  double start = cpu_seconds();
  if (!mu || !f || dls_reduction_create(&R, model, &error))
    return fprintf(stderr, "%s\n", error.message);
  out->cpu = cpu_seconds() - start;
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  out->peak = 1024.0 * (double)usage.ru_maxrss;
  int bad = dls_reduction_get_info(R, &info, NULL) || dls_reduction_contact(R, mu, &contact, NULL);
  out->foreseen = info.bytes;
  out->flops = info.flops;
  out->condition = info.condition;
  const size_t m = (size_t)contact.W.rows;
  if (!bad) memcpy(W, contact.W.a, m * m * sizeof *W);
  f[model->n / 2] = 1;
  start = cpu_seconds();
  bad = bad || dls_reduction_load(R, f, NULL, NULL);
  out->load = cpu_seconds() - start;
  bad = bad || dls_reduction_load(R, NULL, NULL, NULL) || sample(R, model, W, out);
  start = cpu_seconds();
  bad = bad || dls_reduction_update(R, model, NULL);
  out->update = cpu_seconds() - start;
  dls_reduction_destroy(R);
  free(f);
  free(mu);
  return bad;
}

static int take(way w, const dls_model *model, double *W, result *out) {
  const double start = cpu_seconds();
  const int batch = w == COLUMNS_64 ? 64 : 0;
  if (w == DELASSUS) return by_delassus(model, W, out);
  if (w == MUMPS_ALONE) return mumps_schur(model, &out->before, &out->cpu, &out->inverse);
  const int bad = model->factorization == DLS_CHOLESKY ? cholmod_columns(model, batch, W)
                                                       : umfpack_columns(model, batch, W);
  out->cpu = cpu_seconds() - start;
  return bad;
}

/* In a child process; W (m x m) is shared. */
static result run(way w, int d, int cells, double skew, double *W, result *shared) {
  memset(shared, 0, sizeof *shared);
  shared->failed = 1;
  const pid_t child = fork();
  if (child == 0) {
    box b;
    if (box_create(&b, d, cells, skew) == 0) {
      shared->n = b.model.n;
      shared->m = b.model.d * b.model.nodes;
      shared->failed = take(w, &b.model, W, shared);
      struct rusage usage;
      getrusage(RUSAGE_SELF, &usage);
      if (shared->peak == 0) shared->peak = 1024.0 * (double)usage.ru_maxrss;
    }
    _exit(0);
  }
  if (child > 0) waitpid(child, NULL, 0);
  return *shared;
}

static double dgemm_rate(void) {
  const int n = 2000;
  const size_t N = (size_t)n * (size_t)n;
  double *A = calloc(3 * N, sizeof *A), best = 0;
  if (!A) return NAN;
  const double one = 1, zero = 0;
  for (int turn = 0; turn < 3; turn++) {
    const double start = cpu_seconds();
    dgemm_("N", "N", &n, &n, &n, &one, A, &n, A + N, &n, &zero, A + 2 * N, &n, 1, 1);
    const double rate = 2.0 * n * n * n / (cpu_seconds() - start);
    if (rate > best) best = rate;
  }
  free(A);
  return best;
}

static double difference(const double *V, const double *W, size_t entries) {
  double far = 0, size = 0;
  for (size_t k = 0; k < entries; k++) {
    if (!(fabs(V[k] - W[k]) <= far)) far = fabs(V[k] - W[k]);
    if (!(fabs(W[k]) <= size)) size = fabs(W[k]);
  }
  return far / size;
}

static void print(FILE *csv, const char *kind, int d, int cells, const char *name, const result *r,
                  double apart, double rate) {
  FILE *const to[] = {csv, stdout};
  for (int k = 0; k < 2; k++)
    if (to[k])
      fprintf(to[k],
              "%s,%d,%d,%d,%d,%s,%.3f,%.4f,%.4f,%.2e,%.2e,%.2e,%.3f,%.3f,%.3f,%.3f,%.2f,%.2f\n",
              kind, d, cells, r->n, r->m, name, r->cpu, 1e-9 * r->peak, 1e-9 * r->foreseen, apart,
              r->residual, r->recovered, r->load, r->update, r->before, r->inverse,
              1e-9 * r->flops / r->cpu, 1e-9 * rate);
  fflush(stdout);
}

static int compare(FILE *csv, int d, int cells, double skew, int peers) {
  const size_t m = (size_t)d * (size_t)cells * (size_t)(d == 3 ? cells + 1 : 1);
  const size_t bytes = m * m * sizeof(double);
  double *V = mmap(NULL, 2 * bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  result *shared =
      mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (V == MAP_FAILED || shared == MAP_FAILED) return 1;
  double *W = V + m * m;
  result best[MUMPS_ALONE + 1];
  const char *kind = skew == 0 ? "definite" : "unsymmetric";
  int failed = 0;
  for (int turn = 0; turn < (peers ? turns : 1); turn++) /* the two that are close, in turn */
    for (int w = MUMPS_ALONE; w >= DELASSUS; w -= MUMPS_ALONE) {
      if (w == MUMPS_ALONE && (!peers || skew != 0)) continue;
      const result r = run((way)w, d, cells, skew, w == DELASSUS ? V : W, shared);
      if (turn == 0 || r.cpu < best[w].cpu) best[w] = r;
      failed |= r.failed;
    }
  for (int w = DELASSUS; w <= MUMPS_ALONE; w++) {
    const int columns = w == COLUMNS || w == COLUMNS_64;
    if ((w != DELASSUS && !peers) || (skew != 0 && w > COLUMNS)) continue;
    if (columns) best[w] = run((way)w, d, cells, skew, W, shared);
    failed |= best[w].failed;
    const double apart = columns && !best[w].failed ? difference(W, V, m * m) : NAN;
    print(csv, kind, d, cells, names[w], &best[w], apart, dgemm_rate());
  }
  munmap(shared, sizeof *shared);
  munmap(V, 2 * bytes);
  return failed;
}

int main(int argc, char **argv) {
  const int full = argc > 1 && strcmp(argv[1], "--full") == 0;
  const int large = argc > 1 && strcmp(argv[1], "--large") == 0;
  if (argc == 4) return compare(NULL, atoi(argv[1]), atoi(argv[2]), atof(argv[3]), 1);
  FILE *csv =
      fopen(large ? "bench/results/reduction_large.csv" : "bench/results/reduction.csv", "w");
  if (!csv) return perror("bench/results"), EXIT_FAILURE;
  static const char head[] =
      "K,d,cells,n,m,way,cpu_s,peak_GB,foreseen_GB,W_difference,residual,recovered,load_s,update_s,"
      "ordering_analysis_s,inverse_s,Gflops,dgemm_Gflops\n";
  fputs(head, csv);
  fputs(head, stdout);
  int failed = 0;
  if (large) failed = compare(csv, 2, 850, 0, 0);
  const struct {
    int d, cells, full;
    double skew;
  } cases[] = {{2, 50, 0, 0},   {2, 100, 0, 0},   {2, 200, 0, 0},    {2, 300, 1, 0},
               {3, 6, 0, 0},    {3, 10, 0, 0},    {3, 16, 0, 0},     {3, 22, 0, 0},
               {3, 30, 1, 0},   {2, 50, 0, 0.05}, {2, 100, 0, 0.05}, {2, 200, 1, 0.05},
               {3, 6, 0, 0.05}, {3, 10, 0, 0.05}, {3, 16, 1, 0.05}};
  for (size_t k = 0; !large && k < sizeof cases / sizeof cases[0]; k++)
    if (full || !cases[k].full)
      failed |= compare(csv, cases[k].d, cases[k].cells, cases[k].skew, 1);
  fclose(csv);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
