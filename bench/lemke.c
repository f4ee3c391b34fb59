/*
 * lemke.c: Lemke's method of delassus, the path alone and with its crash start, beside the lexicographic
 * Lemke of Siconos Numerics, on the same LCPs, in the same run, in turn.
 *
 *   lemke [--max N] [--full] [--lcp DIR] [--out DIR]     the comparison: lemke.csv
 *   lemke --large [--out DIR]                            one friction LCP of n = 9999: lemke_large.csv
 *
 * Every measurement runs in a child process of its own, so that a crash or a run without end costs that
 * one only. It begins with a call that is not counted, unless that takes more than a second; then calls
 * are repeated for 20 ms at least between two readings of the CPU clock, and averaged. Ours are with
 * create and destroy, since the peer allocates inside; "reused" is the solve alone, with the crash start, on
 * a workspace that is there already, as over time steps. The peer's options are made once. The answers
 * come back in shared memory and are certified here, all by dls_lcp_certify. The median over the
 * repetitions counts; the peer stops after n = 2100 unless --full.
 *
 * Beside the time per exchange stand one dger (the update that a Lemke on the full condensed table
 * makes at each exchange) and one dgemv, both on n x (n+1).
 */
#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bench.h"
#include "clock.h"

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
  const double start = cpu_seconds();
  for (int k = 0; k < calls; k++) {
    o->status = DLS_OK;
    if (which != reused) o->status = dls_lemke_create(&lemke, p->n, &settings, NULL);
    if (o->status == DLS_OK) o->status = dls_lemke_solve(lemke, &lcp, z, NULL, &info, NULL);
    if (which != reused) dls_lemke_destroy(lemke);
  }
  o->cpu = (cpu_seconds() - start) / calls;
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

static void run_child(solver which, const problem *p, outcome *o, double *z) {
  const struct rlimit limit = {cpu_limit, cpu_limit};
  setrlimit(RLIMIT_CPU, &limit);
  call(which, p, 1, o, z);
  if (o->cpu >= long_call || o->cpu < 0) return;
  for (int calls = 1;; calls *= 2) {
    call(which, p, calls, o, z);
    if (o->cpu < 0 || calls * o->cpu >= shortest) return;
  }
}

/* Solves p in a child process and certifies its answer. */
static outcome measure(solver which, const problem *p) {
  const size_t n = (size_t)p->n, bytes = sizeof(outcome) + n * sizeof(double);
  outcome failed = {.cpu = -1, .status = -1, .residual = INFINITY};
  outcome *o = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (o == MAP_FAILED) return failed;
  double *z = (double *)(o + 1);
  *o = failed;
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    run_child(which, p, o, z);
    _exit(0);
  }
  int wait_status = 0;
  pid_t ended;
  do
    ended = waitpid(child, &wait_status, 0);
  while (ended < 0 && errno == EINTR);
  if (child < 0 || ended != child || !WIFEXITED(wait_status)) {
    o->cpu = -1;
    if (ended == child && WIFSIGNALED(wait_status)) o->status = WTERMSIG(wait_status);
  }
  if (o->cpu >= 0) {
    const dls_lcp lcp = problem_view(p);
    dls_lcp_certificate certificate;
    if (dls_lcp_certify(&lcp, z, NULL, &certificate, NULL) == DLS_OK) {
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
      double spent = 0, start = 0;
      int calls = -1; /* the first call is not timed */
      do {
        if (calls == 0) start = cpu_seconds();
        if (kind == 0) dger_(&n, &m, &alpha, x, &unit, x, &unit, A, &n);
        if (kind == 1) dgemv_("N", &n, &m, &one, A, &n, x, &unit, &zero, y, &unit, 1);
        if (calls >= 0) spent = cpu_seconds() - start;
        calls++;
      } while (spent < 0.05 || calls < 3);
      *(kind == 0 ? &t.dger : &t.dgemv) = spent / calls;
    }
  }
  free(A);
  free(x);
  free(y);
  return t;
}

/* ---- the comparison -------------------------------------------------------------------------- */

static int compare_doubles(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* The outcome of all repetitions: the median of the times, else the worst of them. */
static outcome summarise(const outcome *o, int count) {
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
  qsort(cpu, (size_t)count, sizeof *cpu, compare_doubles);
  s.cpu = cpu[0] < 0 ? -1 : count % 2 ? cpu[count / 2] : (cpu[count / 2 - 1] + cpu[count / 2]) / 2;
  return s;
}

/* A field of the table; "nan" where there is none, which gnuplot takes for a gap. */
static void print_field(FILE *csv, double x) {
  if (x >= 0 && isfinite(x))
    fprintf(csv, ",%.4g", x);
  else
    fputs(",nan", csv);
}

static void print_line(const problem *p, int count, const outcome sum[solvers], const double *ratio,
                       const yardsticks *t) {
  const outcome *o = &sum[path], *c = &sum[crash], *r = &sum[peer];
  printf("%-12.12s %5d  %2d  %9.3g %6d %8.1e  %9.3g %6d %8.1e  %9.3g", p->name, p->n, count, o->cpu,
         o->pivots, o->residual, c->cpu, c->pivots, c->residual, sum[reused].cpu);
  if (r->cpu >= 0)
    printf("  %9.3g %6d %8.1e  %6.1f %6.1f %6.1f", r->cpu, r->pivots, r->residual, ratio[path],
           ratio[crash], ratio[reused]);
  else
    printf(" %48s", "");
  printf("  %9.3g %9.3g %9.3g", 1e6 * o->cpu / o->pivots, 1e6 * t->dger, 1e6 * t->dgemv);
  for (solver which = path; which <= crash; which++)
    if (!sum[which].solved) printf("  %s", dls_status_name((dls_status)sum[which].status));
  if (r->cpu >= 0 && !r->solved) printf("  peer: %d", r->status);
  putchar('\n');
}

static void compare(const problem *p, int with_peer, FILE *csv) {
  const int count = p->n <= 400 ? max_repetitions : p->n <= 1200 ? 5 : p->n <= 2400 ? 3 : 1;
  outcome runs[solvers][max_repetitions], sum[solvers];
  double ratio[peer];
  for (int k = 0; k < count; k++)
    for (solver which = path; which < solvers; which++)
      runs[which][k] = which == peer && !with_peer
                           ? (outcome){.cpu = -1, .status = -1, .residual = INFINITY, .pivots = -1}
                           : measure(which, p);
  for (solver which = path; which < solvers; which++)
    sum[which] = summarise(runs[which], count);
  for (solver which = path; which < peer; which++)
    ratio[which] = sum[which].solved && sum[peer].solved ? sum[peer].cpu / sum[which].cpu : -1;
  const yardsticks t = time_blas(p->n);
  print_line(p, count, sum, ratio, &t);

  fprintf(csv, "%s,%d,%d", p->name, p->n, count);
  for (solver which = path; which < solvers; which++) {
    if (which == reused) continue; /* last */
    print_field(csv, sum[which].cpu);
    print_field(csv, sum[which].pivots);
    print_field(csv, sum[which].residual);
    fprintf(csv, ",%d", sum[which].solved);
  }
  print_field(csv, ratio[path]);
  print_field(csv, ratio[crash]);
  print_field(csv, sum[path].cpu / sum[path].pivots);
  print_field(csv, t.dger);
  print_field(csv, t.dgemv);
  print_field(csv, sum[reused].cpu);
  print_field(csv, ratio[reused]);
  fputc('\n', csv);
  fflush(csv);
}

static int compare_names(const void *a, const void *b) {
  return strcmp(*(char *const *)a, *(char *const *)b);
}

/* Every pair NAME_M.mtx, NAME_q.mtx of a directory, in alphabetical order. */
static int compare_directory(const char *directory, int max, FILE *csv) {
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
      if (p.n <= max) compare(&p, 1, csv);
      problem_free(&p);
    } else
      status = -1;
    free(names[k]);
  }
  return status;
}

static int compare_generated(int max, int full, FILE *csv) {
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
      compare(&p, full || n <= peer_size, csv);
      problem_free(&p);
    }
  return 0;
}

/* ---- one large problem ----------------------------------------------------------------------- */

/* RSS: W (2 nc)^2 and M (3 nc)^2 doubles, and the workspace of Lemke, about the same as M. */
static int run_large(int nc, FILE *csv) {
  lining l;
  problem p;
  double start = cpu_seconds();
  if (lining_create(&l, nc)) return -1;
  const double make = cpu_seconds() - start;
  if (problem_from_lining(&p, &l)) {
    lining_free(&l);
    return -1;
  }
  outcome o = {0};
  double *z = calloc((size_t)p.n, sizeof *z), *r = calloc(2 * (size_t)nc, sizeof *r),
         *u = calloc(2 * (size_t)nc, sizeof *u);
  dls_contact_state *state = calloc((size_t)nc, sizeof *state);
  dls_certificate contact = {0};
  dls_lcp_certificate certificate = {0};
  const dls_lcp lcp = problem_view(&p);
  int count[3] = {0}, failed = !z || !r || !u || !state;
  if (!failed) {
    call_ours(crash, &p, 1, &o, z);
    failed = dls_lcp_certify(&lcp, z, NULL, &certificate, NULL) ||
             dls_contact_from_lcp(&l.contact, NULL, z, r, NULL) ||
             dls_contact_certify(&l.contact, r, u, &contact, NULL) ||
             dls_contact_states(&l.contact, r, u, state, NULL);
  }
  for (int c = 0; c < nc && !failed; c++)
    count[state[c]]++;
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  const double gigabytes = (double)usage.ru_maxrss * 1024e-9;
  if (!failed) {
    printf("n = %d, %d candidates: %d free, %d slip, %d stick\n", p.n, nc, count[DLS_FREE],
           count[DLS_SLIP], count[DLS_STICK]);
    printf("W %.3g s, Lemke %.4g s CPU, %d rounds of the crash start, %s\n", make, o.cpu, o.pivots,
           dls_status_name((dls_status)o.status));
    printf("residual: LCP %.1e, contact %.1e; largest RSS %.2f GB\n", certificate.residual,
           contact.residual, gigabytes);
    fprintf(
        csv,
        "n,candidates,free,slip,stick,make_W_s,cpu_s,crash_rounds,lcp_residual,contact_residual,"
        "solved,max_rss_GB\n");
    fprintf(csv, "%d,%d,%d,%d,%d,%.4g,%.4g,%d,%.2e,%.2e,%d,%.3g\n", p.n, nc, count[DLS_FREE],
            count[DLS_SLIP], count[DLS_STICK], make, o.cpu, o.pivots, certificate.residual,
            contact.residual, dls_lcp_certificate_holds(&certificate, tol), gigabytes);
  }
  free(z);
  free(r);
  free(u);
  free(state);
  problem_free(&p);
  lining_free(&l);
  return failed ? -1 : 0;
}

/* ---- program --------------------------------------------------------------------------------- */

int main(int argc, char **argv) {
  const char *out = "bench/results", *directory = NULL;
  int max = 4000, full = 0, large = 0;
  for (int k = 1; k < argc; k++) {
    const int more = k + 1 < argc;
    if (!strcmp(argv[k], "--full"))
      full = 1;
    else if (!strcmp(argv[k], "--large"))
      large = 1;
    else if (!strcmp(argv[k], "--max") && more)
      max = atoi(argv[++k]);
    else if (!strcmp(argv[k], "--lcp") && more)
      directory = argv[++k];
    else if (!strcmp(argv[k], "--out") && more)
      out = argv[++k];
    else {
      fprintf(stderr,
              "usage: lemke [--max N] [--full] [--lcp DIR] [--out DIR] | --large [--out DIR]\n");
      return 2;
    }
  }
  char file[1024];
  snprintf(file, sizeof file, "%s/%s", out, large ? "lemke_large.csv" : "lemke.csv");
  FILE *csv = fopen(file, "w");
  if (!csv) {
    perror(file);
    return 1;
  }
  int status = 0;
  if (large)
    status = run_large(3333, csv);
  else {
    fputs("problem,n,repetitions,path_cpu_s,path_pivots,path_residual,path_solved,crash_cpu_s,"
          "crash_rounds,crash_residual,crash_solved,peer_cpu_s,peer_pivots,peer_residual,"
          "peer_solved,path_ratio,crash_ratio,path_per_pivot_s,dger_s,dgemv_s,"
          "reused_cpu_s,reused_ratio\n",
          csv);
    printf("%-12s %5s %3s  %9s %6s %8s  %9s %6s %8s  %9s  %9s %6s %8s  %6s %6s %6s  %9s %9s "
           "%9s\n",
           "problem", "n", "rep", "path s", "pivots", "residual", "crash s", "rounds", "residual",
           "reused s", "peer s", "pivots", "residual", "path", "crash", "reused", "us/pivot",
           "dger us", "dgemv us");
    status |= compare_directory("data/lcp", max, csv);
    if (directory) status |= compare_directory(directory, max, csv);
    status |= compare_generated(max, full, csv);
  }
  if (fclose(csv) != 0) status = -1;
  if (status) fprintf(stderr, "lemke: not everything could be run\n");
  return status ? 1 : 0;
}
