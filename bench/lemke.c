/*
 * lemke.c: compares Lemke's method of delassus, the path alone and with its crash start, with the
 * lexicographic Lemke of Siconos Numerics, on the same LCPs, in one run, in turn.
 *
 *   lemke [--max N] [--full] [--lcp DIR] [--out DIR]   the comparison: lemke.csv, lemke.md
 *   lemke --large [--out DIR]                          n = 9999, delassus alone: lemke_large.*
 *
 * --full: the peer runs beyond n = 2100, too. --lcp: the pairs DIR/NAME_M.mtx, NAME_q.mtx
 * in place of those of data/lcp.
 *
 * Every measurement runs in a child process: a crash or a run without end costs only that
 * measurement. The first call is not counted, unless it takes more than a second. Then calls are
 * repeated for at least 20 ms between two readings of the CPU clock, and averaged. Calls of
 * delassus include create and destroy, as the peer allocates inside; "reused" is the solve alone,
 * with the crash start, on an existing workspace, as over time steps. The peer's options are made
 * once, outside. All answers are certified here by dls_lcp_certify. The median over the repetitions
 * counts.
 *
 * The time per pivot is shown with one dger (the update of a Lemke on the full condensed table at
 * each pivot) and one dgemv, both on n x (n+1).
 */
#include <dirent.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include "common.h"
#include "lemke.h"

void dger_(const int *m, const int *n, const double *alpha, const double *x, const int *incx,
           const double *y, const int *incy, double *a, const int *lda);
void dgemv_(const char *trans, const int *m, const int *n, const double *alpha, const double *a,
            const int *lda, const double *x, const int *incx, const double *beta, double *y,
            const int *incy, size_t);

enum { peer_size = 2100, cpu_limit = 1200, max_repetitions = 9 };
static const double shortest = 2e-2; /* s: of repeated calls */
static const double long_call = 1;   /* s: no second call */
static const double tol = 1e-8;      /* the default of dls_lemke */

/* ---- one call in a process of its own -------------------------------------------------------- */

typedef enum solver { path, crash, reused, peer, solvers } solver;

typedef struct outcome {
  double cpu; /* s, negative if the call did not return */
  int pivots; /* crash: rounds, or -1 if a path was needed after them */
  int status; /* what the call returned; or the signal that ended it */
  double residual;
  int solved;
} outcome;

static void call_ours(solver which, const problem *p, int calls, outcome *o, double *z) {
  const dls_lcp lcp = problem_view(p);
  dls_lemke_settings settings;
  dls_lemke_settings_init(&settings);
  settings.crash = which != path;
  dls_lemke_info info = {0};
  dls_lemke *lemke = NULL;
  if (which == reused && dls_lemke_create(&lemke, p->n, &settings, NULL) != DLS_OK) return;
  const double start = bench_seconds();
  for (int k = 0; k < calls; k++) {
    o->status = DLS_OK;
    if (which != reused) o->status = dls_lemke_create(&lemke, p->n, &settings, NULL);
    if (o->status == DLS_OK) o->status = dls_lemke_solve(lemke, &lcp, z, NULL, &info, NULL);
    if (which != reused) dls_lemke_destroy(lemke);
  }
  o->cpu = (bench_seconds() - start) / calls;
  if (which == reused) dls_lemke_destroy(lemke);
  o->pivots = which == path ? info.pivots : info.starts ? -1 : info.crash_rounds;
}

static void call_peer(const problem *p, int calls, outcome *o, double *z) {
  double *w = calloc((size_t)p->n, sizeof *w);
  o->status = w ? peer_lemke(p->n, p->M, p->q, calls, z, w, &o->cpu, &o->pivots) : -1;
  free(w);
}

static void call(solver which, const problem *p, int calls, outcome *o, double *z) {
  if (which == peer)
    call_peer(p, calls, o, z);
  else
    call_ours(which, p, calls, o, z);
}

/* A call in a child process; o and z are shared. */
typedef struct job {
  solver which;
  const problem *p;
  outcome *o;
  double *z; /* n */
} job;

static void run_job(void *data) {
  const job *j = data;
  const struct rlimit limit = {cpu_limit, cpu_limit};
  setrlimit(RLIMIT_CPU, &limit);
  call(j->which, j->p, 1, j->o, j->z);
  if (j->o->cpu >= long_call || j->o->cpu < 0) return;
  for (int calls = 1;; calls *= 2) {
    call(j->which, j->p, calls, j->o, j->z);
    if (j->o->cpu < 0 || calls * j->o->cpu >= shortest) return;
  }
}

/* Solves p in a child process and certifies the answer. */
static outcome solve_apart(solver which, const problem *p) {
  const size_t bytes = sizeof(outcome) + (size_t)p->n * sizeof(double);
  const outcome failed = {.cpu = -1, .status = -1, .residual = INFINITY};
  outcome *o = bench_shared(bytes);
  if (!o) return failed;
  *o = failed;
  job j = {which, p, o, (double *)(o + 1)};
  const int ended = bench_child(run_job, &j);
  if (ended) {
    o->cpu = -1;
    o->status = ended;
  } else if (o->cpu >= 0) {
    const dls_lcp lcp = problem_view(p);
    dls_lcp_certificate certificate;
    if (dls_lcp_certify(&lcp, j.z, NULL, &certificate, NULL) == DLS_OK) {
      o->residual = certificate.residual;
      o->solved = dls_lcp_certificate_holds(&certificate, tol);
    }
  }
  const outcome result = *o;
  munmap(o, bytes);
  return result;
}

/* ---- yardsticks ------------------------------------------------------------------------------ */

typedef struct yardsticks {
  double dger, dgemv; /* s */
} yardsticks;

static yardsticks time_blas(int n) {
  const int m = n + 1, unit = 1;
  const size_t N = (size_t)n;
  double *A = malloc(N * (N + 1) * sizeof *A), *x = malloc((N + 1) * sizeof *x),
         *y = malloc((N + 1) * sizeof *y);
  yardsticks t = {-1, -1};
  if (A && x && y) {
    const double one = 1, zero = 0, alpha = 1e-3;
    for (size_t k = 0; k < N * (N + 1); k++)
      A[k] = 1;
    for (size_t k = 0; k <= N; k++)
      x[k] = y[k] = 1;
    for (int kind = 0; kind < 2; kind++) {
      bench_clock c = {0};
      while (bench_runs(&c, 4, INT_MAX, 0.05)) {
        if (kind == 0) dger_(&n, &m, &alpha, x, &unit, x, &unit, A, &n);
        if (kind == 1) dgemv_("N", &n, &m, &one, A, &n, x, &unit, &zero, y, &unit, 1);
      }
      *(kind == 0 ? &t.dger : &t.dgemv) = c.least;
    }
  }
  free(A);
  free(x);
  free(y);
  return t;
}

/* ---- the comparison -------------------------------------------------------------------------- */

/* Returns the outcome of all repetitions: the median of the times, the worst of the rest. */
static outcome lemke_summary(const outcome *o, int count) {
  double cpu[max_repetitions] = {0};
  outcome s = o[0];
  for (int k = 0; k < count; k++) {
    cpu[k] = o[k].cpu;
    if (!(o[k].residual <= s.residual)) s.residual = o[k].residual;
    if (o[k].cpu < 0 || !o[k].solved) {
      s.solved = 0;
      s.status = o[k].status;
    }
  }
  s.cpu = bench_median((size_t)count, cpu);
  if (cpu[0] < 0) s.cpu = -1;
  return s;
}

/* Prints a field of the CSV file; "nan" where there is none, which gnuplot takes for a gap. */
static void csv_field(FILE *csv, double x) {
  if (x >= 0 && isfinite(x))
    fprintf(csv, ",%.4g", x);
  else
    fputs(",nan", csv);
}

/* Prints a cell of the page, empty where there is no figure. */
static void page_cell(FILE *page, const char *format, double x) {
  if (x >= 0 && isfinite(x)) {
    bench_print(page, " ");
    bench_print(page, format, x); // NOLINT(clang-diagnostic-format-nonliteral)
  }
  bench_print(page, " |");
}

/* Prints time, exchanges and residual, or why there is no answer. */
static void page_outcome(FILE *page, const outcome *o) {
  page_cell(page, "%.2g", o->cpu);
  page_cell(page, "%.0f", o->pivots);
  if (o->cpu >= 0 && !o->solved)
    bench_print(page, " not solved, %.0e |", o->residual);
  else
    page_cell(page, "%.0e", o->residual);
}

typedef struct output {
  FILE *csv, *page;
} output;

static void write_heads(const output *to) {
  fputs("problem,n,repetitions,path_cpu_s,path_pivots,path_residual,path_solved,crash_cpu_s,"
        "crash_rounds,crash_residual,crash_solved,peer_cpu_s,peer_pivots,peer_residual,"
        "peer_solved,path_ratio,crash_ratio,path_per_pivot_s,dger_s,dgemv_s,"
        "reused_cpu_s,reused_ratio\n",
        to->csv);
  bench_print(to->page, "%s",
              "CPU of a call. Path: without the crash start. Crash: by default; no rounds where "
              "the path had to follow. The screen\nshows problems with fewer than 100 rows, too."
              "\n\n| problem | n | path s | pivots | residual | crash s | rounds | residual | "
              "Siconos s | pivots | residual | Siconos / path | Siconos / crash |\n"
              "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
}

static void write_row(const output *to, const problem *p, int count, const outcome sum[solvers],
                      const yardsticks *t) {
  double ratio[peer];
  for (solver which = path; which < peer; which++)
    ratio[which] = sum[which].solved && sum[peer].solved ? sum[peer].cpu / sum[which].cpu : -1;
  const double per_pivot = sum[path].cpu / sum[path].pivots;

  FILE *const page = p->n < 99 ? NULL : to->page;
  bench_print(page, "| %s | %d |", p->name, p->n);
  page_outcome(page, &sum[path]);
  page_outcome(page, &sum[crash]);
  page_outcome(page, &sum[peer]);
  page_cell(page, "%.1f", ratio[path]);
  page_cell(page, "%.1f", ratio[crash]);
  bench_print(page, "\n");

  FILE *csv = to->csv;
  fprintf(csv, "%s,%d,%d", p->name, p->n, count);
  for (solver which = path; which < solvers; which++) {
    if (which == reused) continue; /* last */
    csv_field(csv, sum[which].cpu);
    csv_field(csv, sum[which].pivots);
    csv_field(csv, sum[which].residual);
    fprintf(csv, ",%d", sum[which].solved);
  }
  csv_field(csv, ratio[path]);
  csv_field(csv, ratio[crash]);
  csv_field(csv, per_pivot);
  csv_field(csv, t->dger);
  csv_field(csv, t->dgemv);
  csv_field(csv, sum[reused].cpu);
  csv_field(csv, ratio[reused]);
  fputc('\n', csv);
  fflush(csv);
}

static void compare_lemke(const problem *p, int with_peer, const output *to) {
  const int count = p->n <= 400 ? max_repetitions : p->n <= 1200 ? 5 : p->n <= 2400 ? 3 : 1;
  outcome runs[solvers][max_repetitions], sum[solvers];
  for (int k = 0; k < count; k++)
    for (solver which = path; which < solvers; which++)
      runs[which][k] = which == peer && !with_peer
                           ? (outcome){.cpu = -1, .status = -1, .residual = INFINITY, .pivots = -1}
                           : solve_apart(which, p);
  for (solver which = path; which < solvers; which++)
    sum[which] = lemke_summary(runs[which], count);
  const yardsticks t = time_blas(p->n);
  write_row(to, p, count, sum, &t);
}

static int compare_names(const void *a, const void *b) {
  return strcmp(*(char *const *)a, *(char *const *)b);
}

/* Compares on every pair NAME_M.mtx, NAME_q.mtx of a directory, in alphabetical order. */
static int compare_directory(const char *directory, int max, const output *to) {
  DIR *d = opendir(directory);
  if (!d) {
    perror(directory);
    return -1;
  }
  char *names[1000] = {0};
  int count = 0, status = 0;
  for (struct dirent *e = readdir(d); e && count < 1000; e = readdir(d)) {
    const size_t length = strlen(e->d_name);
    if (length <= 6 || strcmp(e->d_name + length - 6, "_M.mtx") != 0) continue;
    names[count] = strndup(e->d_name, length - 6);
    if (names[count]) count++;
  }
  closedir(d);
  qsort(names, (size_t)count, sizeof *names, compare_names);
  for (int k = 0; k < count; k++) {
    problem p;
    if (problem_read(&p, directory, names[k]) == 0) {
      if (p.n <= max) compare_lemke(&p, 1, to);
      problem_free(&p);
    } else
      status = -1;
    free(names[k]);
  }
  return status;
}

static int compare_generated(int max, int full, const output *to) {
  static const int sizes[] = {100, 300, 1000, 2000, 4000};
  for (size_t k = 0; k < sizeof sizes / sizeof sizes[0] && sizes[k] <= max; k++)
    for (int friction = 0; friction < 2; friction++) {
      const int n = sizes[k];
      problem p;
      lining l = {0};
      const int status = !friction                        ? problem_random(&p, n)
                         : lining_create(&l, (n + 1) / 3) ? -1
                                                          : problem_from_lining(&p, &l);
      lining_free(&l);
      if (status) {
        fprintf(stderr, "n = %d: out of memory\n", n);
        return -1;
      }
      compare_lemke(&p, full || n <= peer_size, to);
      problem_free(&p);
    }
  return 0;
}

/* ---- one large problem ----------------------------------------------------------------------- */

/* Outcome of the large problem. */
typedef struct large {
  outcome o;
  dls_certificate contact;
  dls_lcp_certificate lcp;
  int count[3]; /* of candidates, by dls_contact_state */
} large;

static int solve_large(const lining *l, const problem *p, large *out) {
  const size_t nc = (size_t)l->contact.nc;
  double *z = calloc((size_t)p->n, sizeof *z), *r = calloc(2 * nc, sizeof *r),
         *u = calloc(2 * nc, sizeof *u);
  dls_contact_state *state = calloc(nc, sizeof *state);
  const dls_lcp lcp = problem_view(p);
  int failed = !z || !r || !u || !state;
  if (!failed) {
    call_ours(crash, p, 1, &out->o, z);
    failed = dls_lcp_certify(&lcp, z, NULL, &out->lcp, NULL) ||
             dls_contact_from_lcp(&l->contact, NULL, z, r, NULL) ||
             dls_contact_certify(&l->contact, r, u, &out->contact, NULL) ||
             dls_contact_states(&l->contact, r, u, state, NULL);
  }
  for (size_t c = 0; c < nc && !failed; c++)
    out->count[state[c]]++;
  free(z);
  free(r);
  free(u);
  free(state);
  return failed;
}

/* Solves one problem of nc candidates. Memory: W (2 nc)^2 and M (3 nc)^2 doubles, and the
 * workspace of Lemke, about as much as M. */
static int run_large(int nc, const output *to) {
  lining l;
  problem p = {.n = 0};
  large a = {.o = {.cpu = -1}};
  double start = bench_seconds();
  if (lining_create(&l, nc)) return -1;
  const double make = bench_seconds() - start;
  const int failed = problem_from_lining(&p, &l) || solve_large(&l, &p, &a);
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  const double gigabytes = (double)usage.ru_maxrss * 1024e-9;
  const char *const states[] = {"free", "slip", "stick"};
  if (!failed) {
    fprintf(to->csv,
            "n,candidates,free,slip,stick,make_W_s,cpu_s,crash_rounds,lcp_residual,"
            "contact_residual,solved,max_rss_GB\n%d,%d,%d,%d,%d,%.4g,%.4g,%d,%.2e,%.2e,%d,%.3g\n",
            p.n, nc, a.count[DLS_FREE], a.count[DLS_SLIP], a.count[DLS_STICK], make, a.o.cpu,
            a.o.pivots, a.lcp.residual, a.contact.residual, dls_lcp_certificate_holds(&a.lcp, tol),
            gigabytes);
    bench_print(to->page, "| n | %d |\n|---|---|\n| contacts | %d |\n", p.n, nc);
    for (int k = DLS_FREE; k <= DLS_STICK; k++)
      bench_print(to->page, "| %s | %d |\n", states[k], a.count[k]);
    bench_print(to->page,
                "| CPU of W, s | %.3g |\n| CPU of Lemke, s | %.3g |\n| rounds of the crash start | "
                "%d |\n| residual of the LCP | %.1e |\n| residual of the contact problem | %.1e |\n"
                "| largest resident set, GB | %.2f |\n",
                make, a.o.cpu, a.o.pivots, a.lcp.residual, a.contact.residual, gigabytes);
  }
  problem_free(&p);
  lining_free(&l);
  return failed ? -1 : 0;
}

/* ---- program --------------------------------------------------------------------------------- */

int main(int argc, char **argv) {
  const int one = bench_has(argc, argv, "--large");
  const int max = (int)bench_number(argc, argv, "--max", 4000);
  output to = {.page =
                   bench_program(argc, argv, "[--max N] [--full] [--large] [--lcp DIR] [--out DIR]",
                                 one ? "lemke_large" : "lemke", "Lemke's method against Siconos'")};
  to.csv =
      bench_open(bench_word(argc, argv, "--out", "build"), one ? "lemke_large.csv" : "lemke.csv");
  if (!to.csv) return 1;
  int status = 0;
  if (one)
    status = run_large(3333, &to);
  else {
    write_heads(&to);
    status |= compare_directory(bench_word(argc, argv, "--lcp", "data/lcp"), max, &to);
    status |= compare_generated(max, bench_has(argc, argv, "--full"), &to);
    bench_print(to.page, "\n![CPU time against n](lemke.png)\n");
  }
  if (fclose(to.csv) != 0) status = -1;
  if (fclose(to.page) != 0) status = -1;
  if (status) fprintf(stderr, "lemke: not everything could be run\n");
  return status ? 1 : 0;
}
