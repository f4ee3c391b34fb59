/*
 * main.c: the program `delassus-mpi`: `delassus solve` on rank 0 (src/cli), with all ranks in the
 * place of its reduction and of its solve.
 *
 * Rank 0 reads, checks, prints and writes. The others wait for orders: each is a broadcast, then
 * the same collective calls on all ranks.
 */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "cli/cli.h"
#include "front/front.h"
#include "mpi_internal.h"

static int rank, ranks;
static int most_gathered = 1000; /* --gather */
static int tells_ranks;          /* --ranks */

static void usage(FILE *out) {
  (void)fputs(
      "Usage: mpirun -n N delassus-mpi solve [OPTION]... FILE|SCENE\n"
      "  or:  mpirun -n N delassus-mpi solve --stiffness=K --HN=N --HT=T ... [OPTION]...\n"
      "Solves as 'delassus solve' does, with its options and its output, on N processes. A "
      "problem\n"
      "with a sparse K is shared out; any other, and --limit, is solved by the first process.\n"
      "\n"
      "      --gather=M   W of up to M rows goes to one process, where all methods, --prove\n"
      "                   and --forces work (1000)\n"
      "      --ranks      print time and memory of each process\n"
      "  -h, --help       this text; 'delassus-mpi solve --help': the options of the solve\n"
      "\n"
      "Exit status: 0 solved, 1 not solved, 2 bad input.\n",
      out);
}

/* ---- hand out -------------------------------------------------------------------------------- */

/* The share of one rank, which owns its arrays. */
typedef struct part {
  dls_mpi_model model;
  int *ints;
  double *doubles;
  double *f, *g, *mu, *r, *u, *x; /* r, u, x: for the answer */
} part;

static int part_begin(int count, int k) {
  return (int)((long long)count * k / ranks);
}

/* Copies columns a .. b-1 of L; p starts at 0. */
static void part_columns(const dls_sparse *L, int a, int b, int *p, int *i, double *x) {
  const size_t begin = (size_t)L->p[a], size = (size_t)L->p[b] - begin;
  for (int k = a; k <= b; k++)
    p[k - a] = L->p[k] - L->p[a];
  memcpy(i, L->i + begin, size * sizeof *i);
  memcpy(x, L->x + begin, size * sizeof *x);
}

/* Lays out the pieces of a share whose sizes are known. size: rows, nodes, entries of K, of HN, of
 * HT. Returns 0 without memory. */
static int part_carve(part *s, int d, int n, dls_factorization kind, const int size[5]) {
  const size_t rows = (size_t)size[0], nodes = (size_t)size[1], K = (size_t)size[2],
               N = (size_t)size[3], T = (size_t)size[4], m = (size_t)d * nodes;
  s->ints = malloc((2 * K + N + T + m + 2) * sizeof *s->ints);
  s->doubles = calloc(K + N + T + 2 * rows + 3 * m + nodes + 1, sizeof *s->doubles);
  if (!s->ints || !s->doubles) return 0;
  int *pn = s->ints + 2 * K, *in = pn + nodes + 1, *pt = in + N, *it = pt + m - nodes + 1;
  double *xn = s->doubles + K, *xt = xn + N;
  s->model = (dls_mpi_model){d,
                             kind,
                             size[0],
                             K,
                             s->ints,
                             s->ints + K,
                             s->doubles,
                             size[1],
                             {n, size[1], pn, in, xn},
                             {n, (d - 1) * size[1], pt, it, xt}};
  s->f = xt + T;
  s->x = s->f + rows;
  s->g = s->x + rows;
  s->r = s->g + m;
  s->u = s->r + m;
  s->mu = s->u + m;
  return 1;
}

/* Fills the share of rank k. */
static void part_fill(const problem *w, int k, part *s) {
  const int lo = part_begin(w->model.n, k), hi = part_begin(w->model.n, k + 1);
  const int a = part_begin(w->model.nodes, k), b = part_begin(w->model.nodes, k + 1),
            d = w->model.d;
  const size_t K = s->model.entries;
  size_t at = 0;
  for (int j = lo; j < hi; j++)
    for (int e = w->model.Ks.p[j]; e < w->model.Ks.p[j + 1]; e++) {
      s->ints[at] = w->model.Ks.i[e];
      s->ints[K + at] = j;
      s->doubles[at++] = w->model.Ks.x[e];
    }
  int *pn = s->ints + 2 * K, *in = pn + (b - a) + 1;
  const int N = w->model.HN.p[b] - w->model.HN.p[a];
  int *pt = in + N, *it = pt + (d - 1) * (b - a) + 1;
  double *xn = s->doubles + K;
  part_columns(&w->model.HN, a, b, pn, in, xn);
  part_columns(&w->model.HT, (d - 1) * a, (d - 1) * b, pt, it, xn + N);
  if (w->f) memcpy(s->f, w->f + lo, (size_t)(hi - lo) * sizeof *s->f);
  if (w->g) memcpy(s->g, w->g + d * a, (size_t)(d * (b - a)) * sizeof *s->g);
  if (w->mu) memcpy(s->mu, w->mu + a, (size_t)(b - a) * sizeof *s->mu);
}

static void part_sizes(const problem *w, int k, int size[5]) {
  const int lo = part_begin(w->model.n, k), hi = part_begin(w->model.n, k + 1), d = w->model.d;
  const int a = part_begin(w->model.nodes, k), b = part_begin(w->model.nodes, k + 1);
  size[0] = hi - lo;
  size[1] = b - a;
  size[2] = w->model.Ks.p[hi] - w->model.Ks.p[lo];
  size[3] = w->model.HN.p[b] - w->model.HN.p[a];
  size[4] = w->model.HT.p[(d - 1) * b] - w->model.HT.p[(d - 1) * a];
}

/* Gives every rank its share. Returns 0 without memory on this rank. */
static int hand_out(const problem *w, part *mine) {
  int whole_size[3], size[5], fine = 1;
  if (rank == 0) {
    whole_size[0] = w->model.d;
    whole_size[1] = w->model.n;
    whole_size[2] = (int)w->model.factorization;
  }
  (void)MPI_Bcast(whole_size, 3, MPI_INT, 0, MPI_COMM_WORLD);
  for (int k = ranks - 1; rank == 0 && k >= 0; k--) {
    part other = {0}, *s = k ? &other : mine;
    part_sizes(w, k, size);
    const int have = part_carve(s, w->model.d, w->model.n, w->model.factorization, size);
    if (have) part_fill(w, k, s);
    fine = fine && have;
    if (k == 0) break;
    if (!have) size[0] = -1;
    (void)MPI_Send(size, 5, MPI_INT, k, 0, MPI_COMM_WORLD);
    const size_t m = (size_t)(w->model.d * (have ? size[1] : 0));
    if (have) {
      (void)MPI_Send(s->ints,
                     (int)(2 * (size_t)size[2] + (size_t)size[3] + (size_t)size[4] + m + 2),
                     MPI_INT, k, 0, MPI_COMM_WORLD);
      (void)MPI_Send(s->doubles, (int)(s->mu + size[1] - s->doubles), MPI_DOUBLE, k, 0,
                     MPI_COMM_WORLD);
    }
    free(other.ints);
    free(other.doubles);
  }
  if (rank == 0) return fine;
  (void)MPI_Recv(size, 5, MPI_INT, 0, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  if (size[0] < 0) return 0;
  if (!part_carve(mine, whole_size[0], whole_size[1], (dls_factorization)whole_size[2], size)) {
    (void)fprintf(stderr, "delassus-mpi: rank %d: out of memory\n", rank);
    (void)MPI_Abort(MPI_COMM_WORLD, EXIT_BAD_INPUT); /* rank 0 is about to send */
  }
  const size_t m = (size_t)(whole_size[0] * size[1]);
  (void)MPI_Recv(mine->ints, (int)(2 * (size_t)size[2] + (size_t)size[3] + (size_t)size[4] + m + 2),
                 MPI_INT, 0, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  (void)MPI_Recv(mine->doubles, (int)(mine->mu + size[1] - mine->doubles), MPI_DOUBLE, 0, 0,
                 MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return 1;
}

/* ---- orders ---------------------------------------------------------------------------------- */

typedef enum order { END, TAKE, FORM_W, FORM_K, GATHER, SOLVE_W, SOLVE_K, JUDGE, TELL } order;

/* What a rank holds; on rank 0 also what the orders are given and return. */
typedef struct shared {
  part mine;
  dls_mpi_reduction *W;
  dls_mpi_global *K;
  dlsi_mpi_clock solve; /* of the last */
  problem *whole;
  double *gathered, *r, *u, *x;
  dls_mpi_settings settings;
  dls_info info;
} shared;

static shared all;

static void shared_drop(void) {
  dls_mpi_reduction_destroy(all.W);
  dls_mpi_global_destroy(all.K);
  free(all.mine.ints);
  free(all.mine.doubles);
  free(all.gathered);
  all = (shared){.W = NULL};
}

/* Copies `unit` numbers for each of `count` things from rank 0 to the ranks that have them, or
 * back. */
static void pass(int count, int unit, double *whole, double *mine, int back) {
  int *sizes = malloc(2 * (size_t)ranks * sizeof *sizes), *starts = sizes + ranks;
  if (!sizes) (void)MPI_Abort(MPI_COMM_WORLD, EXIT_BAD_INPUT);
  for (int k = 0; k < ranks; k++) {
    starts[k] = unit * part_begin(count, k);
    sizes[k] = unit * part_begin(count, k + 1) - starts[k];
  }
  if (back)
    (void)MPI_Gatherv(mine, sizes[rank], MPI_DOUBLE, whole, sizes, starts, MPI_DOUBLE, 0,
                      MPI_COMM_WORLD);
  else
    (void)MPI_Scatterv(whole, sizes, starts, MPI_DOUBLE, mine, sizes[rank], MPI_DOUBLE, 0,
                       MPI_COMM_WORLD);
  free(sizes);
}

/* Passes r and x to the ranks, or r, u and x back. */
static void pass_answer(int back) {
  const part *s = &all.mine;
  int size[3] = {s->model.d, s->model.HN.rows};
  size[2] = rank == 0 ? all.whole->model.nodes : 0;
  (void)MPI_Bcast(size, 3, MPI_INT, 0, MPI_COMM_WORLD);
  pass(size[2], size[0], all.r, s->r, back);
  if (back) pass(size[2], size[0], all.u, s->u, back);
  pass(size[1], 1, all.x, s->x, back);
}

static void tell_ranks(void) {
  static const char *const names[] = {"order", "analyse", "factor", "invert", "form"};
  dls_mpi_info cost = {0};
  struct rusage used;
  dls_error error;
  if (all.K ? dls_mpi_global_get_info(all.K, &cost, &error)
            : dls_mpi_reduction_get_info(all.W, &cost, &error))
    return;
  (void)getrusage(RUSAGE_SELF, &used);
  double mine[2 * DLS_MPI_PHASES + 5] = {all.solve.wall, all.solve.cpu, 1e-6 * cost.factor_bytes,
                                         1e-6 * cost.dense_bytes, 1e-3 * (double)used.ru_maxrss};
  const int count = sizeof mine / sizeof *mine;
  for (int p = 0; p < DLS_MPI_PHASES; p++) {
    mine[5 + 2 * p] = cost.wall[p];
    mine[6 + 2 * p] = cost.cpu[p];
  }
  for (int k = 0; k < ranks; k++) {
    if (k && rank == k) (void)MPI_Send(mine, count, MPI_DOUBLE, 0, 0, MPI_COMM_WORLD);
    if (rank) continue;
    if (k) (void)MPI_Recv(mine, count, MPI_DOUBLE, k, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    tell("  rank %d: wall (CPU) s:", k);
    for (int p = 0; p < DLS_MPI_PHASES; p++)
      tell(" %s %.3g (%.3g),", names[p], mine[5 + 2 * p], mine[6 + 2 * p]);
    tell(" solve %.3g (%.3g); MB: MUMPS %.0f, dense %.1f, all %.0f\n", mine[0], mine[1], mine[2],
         mine[3], mine[4]);
  }
}

/* Carries out an order on this rank. Collective. */
static dls_status carry_out(order what, int warm, dls_error *error) {
  part *s = &all.mine;
  dls_certificate found;
  dls_status status = DLS_OK;
  const int solves = what == SOLVE_W || what == SOLVE_K || what == JUDGE;
  const dlsi_mpi_clock from = dlsi_mpi_now();
  if (solves) pass_answer(0);
  if (rank) dls_mpi_settings_init(&all.settings);
  all.settings.limits.warm_start = warm;
  switch (what) {
  case TAKE:
    status =
        dlsi_agree(MPI_COMM_WORLD, hand_out(all.whole, s) ? DLS_OK : dlsi_no_memory(error), error);
    break;
  case FORM_W:
    if (warm) s->model.factorization = DLS_LDLT;
    status = dls_mpi_reduction_create(&all.W, MPI_COMM_WORLD, &s->model, NULL, error);
    if (!status) status = dls_mpi_reduction_load(all.W, s->f, s->g, error);
    break;
  case FORM_K:
    status = dls_mpi_global_create(&all.K, MPI_COMM_WORLD, &s->model, NULL, error);
    break;
  case GATHER:
    status = dls_mpi_reduction_gather(all.W, all.gathered, error);
    break;
  case SOLVE_W:
    status = dls_mpi_solve(all.W, s->mu, &all.settings, s->r, s->u, &all.info, error);
    if (status >= 0) {
      const dls_status then = dls_mpi_reduction_recover(all.W, s->r, s->x, error);
      if (then) status = then;
    }
    break;
  case SOLVE_K:
    status = dls_mpi_global_solve(all.K, s->f, s->g, s->mu, &all.settings.limits, s->r, s->x,
                                  &all.info, error);
    break;
  case JUDGE:
    status = dls_mpi_reduction_recover(all.W, s->r, s->x, error);
    if (!status) status = dls_mpi_certify(all.W, s->mu, s->r, s->x, s->u, &found, error);
    if (!status) dlsi_body_judge(&all.info, &found, all.settings.limits.tol, all.W->condition);
    break;
  default:
    tell_ranks();
  }
  if (!solves || status < 0) return status;
  const dlsi_mpi_clock now = dlsi_mpi_now();
  all.solve = (dlsi_mpi_clock){now.wall - from.wall, now.cpu - from.cpu};
  pass_answer(1);
  return status;
}

/* Gives an order to all ranks. warm: of a solve; of FORM_W, 1: K is indefinite. */
static dls_status command_all(order what, int warm, dls_error *error) {
  int words[2] = {what, warm};
  dls_error why = {0};
  (void)MPI_Bcast(words, 2, MPI_INT, 0, MPI_COMM_WORLD);
  const dls_status status = carry_out(what, warm, &why);
  if (status < 0) *error = why;
  return status;
}

/* Takes orders until the end; returns the exit status of rank 0. */
static int obey(void) {
  for (;;) {
    int words[2];
    dls_error error = {0};
    (void)MPI_Bcast(words, 2, MPI_INT, 0, MPI_COMM_WORLD);
    if (words[0] == END) return words[1];
    (void)carry_out((order)words[0], words[1], &error);
  }
}

/* ---- what src/cli asks, on rank 0 ------------------------------------------------------------ */

/* Forms W; *on_K := 1 if K is singular. */
static dls_status ranks_form_W(int *on_K, dls_error *error) {
  dls_status status = command_all(FORM_W, 0, error);
  if (status == DLS_E_NOT_POSITIVE_DEFINITE) status = command_all(FORM_W, 1, error);
  *on_K = status == DLS_E_SINGULAR;
  return status;
}

static dls_status ranks_take(problem *p, dls_on on, dls_error *error) {
  const size_t m = (size_t)p->model.d * (size_t)p->model.nodes;
  int on_K = on == DLS_ON_K;
  dls_mpi_contact view;
  dls_status status = on == DLS_ON_EITHER ? dlsi_body_foresee(p->reduction, &on_K, error) : DLS_OK;
  all.whole = p;
  if (!status) status = command_all(TAKE, 0, error);
  if (!status && !on_K) {
    status = ranks_form_W(&on_K, error);
    if (on != DLS_ON_EITHER) on_K = 0;
  }
  if (on_K) status = command_all(FORM_K, 0, error);
  p->on_K = on_K ? 1 : m > (size_t)most_gathered ? 2 : 0;
  if (status || p->on_K) return status;
  all.gathered = malloc(m * m * sizeof *all.gathered);
  if (!all.gathered) return no_memory(error);
  status = command_all(GATHER, 0, error);
  if (!status) status = dls_mpi_reduction_contact(all.W, &view, error);
  if (status) return status;
  p->contact.W = (dls_dense){(int)m, (int)m, (int)m, all.gathered};
  p->contact.q = view.q;
  return DLS_OK;
}

/* By W. A method of the user's choice works where W is gathered. */
static dls_status ranks_on_W(problem *p, const dls_solver_settings *settings, dls_error *error) {
  const char *own = settings->method != DLS_AUTO ? "method"
                    : settings->plan             ? "plan"
                    : settings->without          ? "without"
                    : settings->forces           ? "forces"
                                                 : NULL;
  if (!own) return command_all(SOLVE_W, 0, error);
  if (p->on_K)
    return *error = (dls_error){.status = DLS_E_UNSUPPORTED},
           (void)snprintf(error->message, sizeof error->message,
                          "--%s: W is spread over the ranks; --gather=%d brings it to one", own,
                          p->contact.d * p->contact.nc),
           DLS_E_UNSUPPORTED;
  dls_status status = dls_solve(&p->contact, settings, all.r, all.u, &all.info, error);
  if (status < 0) return status;
  status = command_all(JUDGE, 0, error);
  return status ? status : all.info.status;
}

/* By K, warm or not; u := H^T x + g. */
static dls_status ranks_on_K(problem *p, int warm, dls_error *error) {
  const int before = all.info.iterations;
  dls_certificate found;
  dls_status status = all.K ? DLS_OK : command_all(FORM_K, 0, error);
  if (!status) status = command_all(SOLVE_K, warm, error);
  if (status < 0) return status;
  const dls_status done = status;
  status = dls_reduction_certify(p->reduction, p->mu, all.r, all.x, all.u, &found, error);
  all.info.method = DLS_AUTO;
  all.info.stages = 1;
  all.info.stage[0] = (dls_stage){.method = DLS_ADMM,
                                  .step = DLS_STEP_ON_K,
                                  .iterations = all.info.iterations,
                                  .factorisations = all.info.factorisations,
                                  .residual = all.info.certificate.residual,
                                  .reason = dlsi_body_reason(done)};
  all.info.iterations += before;
  return status ? status : done;
}

static dls_status ranks_solve(problem *p, const dls_solver_settings *settings, double *r, double *u,
                              double *x, dls_info *info, dls_error *error) {
  dls_status status = DLS_STALLED;
  all.r = r;
  all.u = u;
  all.x = x;
  dls_mpi_settings_init(&all.settings);
  all.settings.limits = settings->limits;
  all.settings.gather = most_gathered;
  all.info = (dls_info){.status = DLS_STALLED};
  memset(r, 0, (size_t)p->model.d * (size_t)p->model.nodes * sizeof *r);
  memset(x, 0, (size_t)p->model.n * sizeof *x);
  if (all.W) status = ranks_on_W(p, settings, error);
  const int goes_on = (status == DLS_STALLED || status == DLS_NOT_IN_EQUILIBRIUM ||
                       status == DLS_MAX_ITERATIONS || status == DLS_NO_SOLUTION_LIKELY) &&
                      settings->method == DLS_AUTO && !settings->plan &&
                      !settings->limits.max_iterations;
  if (!all.W || goes_on) status = ranks_on_K(p, all.W != NULL, error);
  all.info.status = status;
  *info = all.info;
  if (status >= 0 && tells_ranks) (void)command_all(TELL, 0, error);
  return status;
}

static dls_status ranks_recover(problem *p, const double *r, double *x, dls_error *error) {
  double *const given = malloc((size_t)p->contact.d * (size_t)p->contact.nc * 2 * sizeof *given);
  if (!given) return no_memory(error);
  const size_t m = (size_t)p->contact.d * (size_t)p->contact.nc;
  memcpy(given, r, m * sizeof *r);
  all.r = given;
  all.u = given + m;
  all.x = x;
  const dls_status status = command_all(JUDGE, 0, error);
  free(given);
  return status;
}

static const double *ranks_motion(int *body) {
  return dls_mpi_global_motion(all.K, body);
}

/* ---- the program ----------------------------------------------------------------------------- */

/* Takes --gather and --ranks out of the arguments, and runs the rest. */
static int run(int argc, char **argv) {
  static const engine by_ranks = {ranks_take, ranks_solve, ranks_recover, ranks_motion};
  int kept = 1;
  for (int k = 1; k < argc; k++) {
    const char *value = strncmp(argv[k], "--gather", 8) ? NULL : argv[k] + 8;
    if (value && !*value && k + 1 < argc)
      value = argv[++k];
    else if (value && *value == '=')
      value++;
    if (value && !dlsi_read_whole(&value, 0, 1000000, &most_gathered))
      return complain("--gather: '%s' is not a whole number up to 1000000", value);
    if (!value && !strcmp(argv[k], "--ranks"))
      tells_ranks = 1;
    else if (!value)
      argv[kept++] = argv[k];
  }
  argv[kept] = NULL;
  const char *name = kept > 1 ? argv[1] : "";
  if (!strcmp(name, "solve")) return solve_with(kept - 1, argv + 1, &by_ranks);
  if (!strcmp(name, "--help") || !strcmp(name, "-h")) return usage(stdout), EXIT_SOLVED;
  return *name ? complain("'%s': delassus-mpi has one command, solve", name)
               : (usage(stderr), EXIT_BAD_INPUT);
}

int main(int argc, char **argv) {
  int words[2] = {END, 0};
  (void)MPI_Init(&argc, &argv);
  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  (void)MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  if (rank == 0) {
    words[1] = end_program(run(argc, argv));
    (void)MPI_Bcast(words, 2, MPI_INT, 0, MPI_COMM_WORLD);
  } else
    words[1] = obey();
  shared_drop();
  (void)MPI_Finalize();
  return words[1];
}
