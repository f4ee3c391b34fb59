/* main.c: the program `delassus-mpi`: reads a problem on rank 0, shares it out, solves on all. */
#define _GNU_SOURCE
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "delassus/files.h"
#include "delassus/mpi.h"
#include "delassus/solve.h"
#include "files/file.h"
#include "mpi_internal.h"

enum { SOLVED = 0, NOT_SOLVED = 1, BAD_INPUT = 2 };

static int rank, ranks;

static void usage(FILE *out) {
  (void)fputs(
      "Usage: mpirun -np N delassus-mpi solve [OPTION]... FILE\n"
      "  or:  mpirun -np N delassus-mpi solve [OPTION]... K.mtx H.mtx f.mtx w.mtx mu.mtx\n"
      "Solves a global contact problem K x = f + H r, u = H^T x + w on N processes: an FCLIB file\n"
      "(HDF5), or Matrix Market files, K and H (n x d nc, local order) in coordinate form.\n"
      "\n"
      "  -k, --kind=KIND   of K: cholesky (symmetric positive definite), ldlt, lu (lu)\n"
      "  -t, --tol=TOL     on the certificate (1e-8)\n"
      "  -g, --gather=M    W of up to M rows goes to one process (1000)\n"
      "  -o, --on=W|K      the problem on W alone, or on K itself without W (W, and K from its\n"
      "                    answer where that is not the body's)\n"
      "  -r, --ranks       time and memory of each phase on each process\n"
      "  -h, --help        this text\n"
      "\n"
      "\"Solved\" is said by the certificate of the body: positions, forces, equilibrium.\n"
      "Exit status: 0 solved, 1 not solved, 2 bad input.\n",
      out);
}

/* ---- read ------------------------------------------------------------------------------------ */

/* The whole problem, on rank 0. */
typedef struct whole {
  int d, n, nodes;
  dls_fclib *file;
  dlsi_triplets K, H; /* of Matrix Market files */
  dlsi_columns N, T;  /* ... H by parts */
  double *read[3];    /* ... f, w, mu */
  dls_sparse HN, HT;
  const double *f, *g, *mu;
} whole;

static void whole_free(whole *w) {
  dls_fclib_destroy(w->file);
  dlsi_triplets_free(&w->K);
  dlsi_triplets_free(&w->H);
  dlsi_columns_free(&w->N);
  dlsi_columns_free(&w->T);
  for (int k = 0; k < 3; k++)
    dls_mtx_free(w->read[k]);
}

static dls_status read_fclib(whole *w, const char *path, dls_error *error) {
  dls_model model;
  dls_status status = dls_fclib_read(&w->file, path, error);
  if (!status) status = dls_fclib_model(w->file, &model, &w->f, &w->g, &w->mu, error);
  if (status) return status;
  w->d = model.d;
  w->n = model.n;
  w->nodes = model.nodes;
  w->HN = model.HN;
  w->HT = model.HT;
  status = dlsi_triplets_alloc(w->n, w->n, (size_t)model.Ks.p[w->n], &w->K, error);
  for (int j = 0; !status && j < w->n; j++)
    for (int e = model.Ks.p[j]; e < model.Ks.p[j + 1]; e++)
      dlsi_triplets_add(&w->K, model.Ks.i[e], j, model.Ks.x[e]);
  return status;
}

static dls_status read_vector(const char *path, int wanted, double **x, dls_error *error) {
  int rows, cols;
  const dls_status status = dls_mtx_read(path, &rows, &cols, x, error);
  if (status || (rows == wanted && cols == 1)) return status;
  return dlsi_fail(error, DLS_E_SIZE, "path", -1, rows, "%.60s is %d x %d, not %d x 1", path, rows,
                   cols, wanted);
}

static dls_status read_mtx(whole *w, char *const *path, dls_error *error) {
  int cols = 0;
  dls_status status = dlsi_mtx_read_triplets(path[0], &w->K, error);
  if (!status) status = dlsi_mtx_read_triplets(path[1], &w->H, error);
  if (!status) status = dls_mtx_read(path[4], &w->nodes, &cols, &w->read[2], error);
  if (status) return status;
  w->n = w->K.rows;
  w->d = w->H.cols / w->nodes;
  if (w->K.cols != w->n || w->H.rows != w->n || cols != 1 || w->H.cols != w->d * w->nodes ||
      (w->d != 2 && w->d != 3))
    return dlsi_fail(error, DLS_E_SIZE, "path", -1, 0, "K, H and mu do not fit");
  status = read_vector(path[2], w->n, &w->read[0], error);
  if (!status) status = read_vector(path[3], w->H.cols, &w->read[1], error);
  if (!status) status = dlsi_columns_compress(&w->H, w->d, DLSI_NORMALS, &w->N, error);
  if (!status) status = dlsi_columns_compress(&w->H, w->d, DLSI_TANGENTS, &w->T, error);
  if (status) return status;
  w->HN = dlsi_columns_view(&w->N);
  w->HT = dlsi_columns_view(&w->T);
  w->f = w->read[0];
  w->g = w->read[1];
  w->mu = w->read[2];
  return DLS_OK;
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
static void part_fill(const whole *w, int k, part *s) {
  const int lo = part_begin(w->n, k), hi = part_begin(w->n, k + 1);
  const int a = part_begin(w->nodes, k), b = part_begin(w->nodes, k + 1), d = w->d;
  const size_t K = s->model.entries;
  size_t at = 0;
  for (int e = 0; e < w->K.count; e++) {
    if (w->K.row[e] < lo || w->K.row[e] >= hi) continue;
    s->ints[at] = w->K.row[e];
    s->ints[K + at] = w->K.col[e];
    s->doubles[at++] = w->K.x[e];
  }
  int *pn = s->ints + 2 * K, *in = pn + (b - a) + 1;
  const int N = w->HN.p[b] - w->HN.p[a];
  int *pt = in + N, *it = pt + (d - 1) * (b - a) + 1;
  double *xn = s->doubles + K;
  part_columns(&w->HN, a, b, pn, in, xn);
  part_columns(&w->HT, (d - 1) * a, (d - 1) * b, pt, it, xn + N);
  memcpy(s->f, w->f + lo, (size_t)(hi - lo) * sizeof *s->f);
  memcpy(s->g, w->g + d * a, (size_t)(d * (b - a)) * sizeof *s->g);
  memcpy(s->mu, w->mu + a, (size_t)(b - a) * sizeof *s->mu);
}

static void part_sizes(const whole *w, int k, int size[5]) {
  const int lo = part_begin(w->n, k), hi = part_begin(w->n, k + 1), d = w->d;
  const int a = part_begin(w->nodes, k), b = part_begin(w->nodes, k + 1);
  size[0] = hi - lo;
  size[1] = b - a;
  size[2] = 0;
  for (int e = 0; e < w->K.count; e++)
    size[2] += w->K.row[e] >= lo && w->K.row[e] < hi;
  size[3] = w->HN.p[b] - w->HN.p[a];
  size[4] = w->HT.p[(d - 1) * b] - w->HT.p[(d - 1) * a];
}

/* Gives every rank its share. Returns 0 without memory on this rank. */
static int hand_out(const whole *w, dls_factorization kind, part *mine) {
  int whole_size[2] = {w->d, w->n}, size[5], fine = 1;
  (void)MPI_Bcast(whole_size, 2, MPI_INT, 0, MPI_COMM_WORLD);
  for (int k = ranks - 1; rank == 0 && k >= 0; k--) {
    part other = {0}, *s = k ? &other : mine;
    part_sizes(w, k, size);
    const int have = part_carve(s, w->d, w->n, kind, size);
    if (have) part_fill(w, k, s);
    fine = fine && have;
    if (k == 0) break;
    if (!have) size[0] = -1;
    (void)MPI_Send(size, 5, MPI_INT, k, 0, MPI_COMM_WORLD);
    const size_t m = (size_t)(w->d * (have ? size[1] : 0));
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
  if (!part_carve(mine, whole_size[0], whole_size[1], kind, size)) {
    (void)fprintf(stderr, "delassus-mpi: rank %d: out of memory\n", rank);
    (void)MPI_Abort(MPI_COMM_WORLD, BAD_INPUT); /* rank 0 is about to send */
  }
  const size_t m = (size_t)(whole_size[0] * size[1]);
  (void)MPI_Recv(mine->ints, (int)(2 * (size_t)size[2] + (size_t)size[3] + (size_t)size[4] + m + 2),
                 MPI_INT, 0, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  (void)MPI_Recv(mine->doubles, (int)(mine->mu + size[1] - mine->doubles), MPI_DOUBLE, 0, 0,
                 MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return 1;
}

/* ---- solve ----------------------------------------------------------------------------------- */

static void print_ranks(const dls_mpi_info *mine, dlsi_mpi_clock solve) {
  static const char *const names[] = {"order", "analyse", "factor", "invert", "form"};
  dls_mpi_info *all = malloc((size_t)ranks * sizeof *all);
  struct rusage used;
  (void)getrusage(RUSAGE_SELF, &used);
  double last[3] = {solve.wall, solve.cpu, 1e-3 * (double)used.ru_maxrss};
  double *other = malloc((size_t)ranks * sizeof last);
  if (!all || !other) (void)MPI_Abort(MPI_COMM_WORLD, BAD_INPUT);
  (void)MPI_Gather(mine, (int)sizeof *mine, MPI_BYTE, all, (int)sizeof *mine, MPI_BYTE, 0,
                   MPI_COMM_WORLD);
  (void)MPI_Gather(last, 3, MPI_DOUBLE, other, 3, MPI_DOUBLE, 0, MPI_COMM_WORLD);
  for (int k = 0; rank == 0 && k < ranks; k++) {
    printf("  rank %d: wall (CPU) s:", k);
    for (int p = 0; p < DLS_MPI_PHASES; p++)
      printf(" %s %.3g (%.3g),", names[p], all[k].wall[p], all[k].cpu[p]);
    printf(" solve %.3g (%.3g); MB: MUMPS %.0f, dense %.1f, all %.0f\n", other[3 * k],
           other[3 * k + 1], 1e-6 * all[k].factor_bytes, 1e-6 * all[k].dense_bytes,
           other[3 * k + 2]);
  }
  free(all);
  free(other);
}

/* Names the part with the largest rounding, as `delassus solve` does. */
static void rounding_words(const dls_certificate *c, char *text, size_t size) {
  const char *limited = "positions";
  double held = fmax(4 * c->floor_u, c->residual_u);
  const double forces = fmax(4 * c->floor_r, c->residual_r);
  const double balance = fmax(4 * c->floor_e, c->equilibrium);
  if (forces > held) limited = "forces", held = forces;
  if (balance > held) limited = "equilibrium", held = balance;
  (void)snprintf(text, size, " to rounding: %s to %.0e", limited, held);
}

/* Prints the last line, in the words of `delassus solve`. */
static void print_ending(dls_status status, const dls_certificate *c) {
  char how_well[80];
  if (status == DLS_TO_ROUNDING) {
    rounding_words(c, how_well, sizeof how_well);
    printf("solved%s\n", how_well);
  } else if (status == DLS_NOT_IN_EQUILIBRIUM)
    printf("not solved: %s: a force of %.3g on body %d is not balanced\n", dls_status_text(status),
           c->unbalanced, c->body);
  else if (dls_solved(status))
    printf("solved\n");
  else
    printf("not solved: %s\n", dls_status_text(status));
}

/* The values of the options. */
typedef struct choice {
  dls_factorization kind;
  dls_mpi_settings settings;
  char on; /* W or K; 0: W, then K if the answer is not that of the body */
  int print;
} choice;

static void print_outcome(const dls_info *info) {
  const dls_certificate *c = &info->certificate;
  printf("  %s: %d iterations, residual %.2e (positions %.2e, forces %.2e, equilibrium %.2e)\n",
         dls_method_name(info->method), info->iterations, c->residual, c->residual_u, c->residual_r,
         c->equilibrium);
}

/* By W. s->x receives the unknowns. */
static dls_status solve_by_W(part *s, const choice *o, dls_info *info, dls_error *error) {
  dls_mpi_reduction *reduction = NULL;
  dls_mpi_info cost = {0};
  dls_status status = dls_mpi_reduction_create(&reduction, MPI_COMM_WORLD, &s->model, NULL, error);
  if (!status) status = dls_mpi_reduction_get_info(reduction, &cost, error);
  dlsi_mpi_clock from = dlsi_mpi_now();
  if (!status) status = dls_mpi_reduction_load(reduction, s->f, s->g, error);
  if (!status) status = dls_mpi_solve(reduction, s->mu, &o->settings, s->r, s->u, info, error);
  if (status >= 0) {
    const dls_status outcome = status;
    status = dls_mpi_reduction_recover(reduction, s->r, s->x, error);
    if (!status) status = outcome;
  }
  const dlsi_mpi_clock now = dlsi_mpi_now();
  if (status >= 0 && rank == 0) {
    printf("  %d unknowns, %d condensed, %d rows of W, %d ranks (grid %d x %d)\n", cost.n,
           cost.condensed, cost.m, cost.ranks, cost.grid[0], cost.grid[1]);
    print_outcome(info);
  }
  if (status >= 0 && o->print)
    print_ranks(&cost, (dlsi_mpi_clock){now.wall - from.wall, now.cpu - from.cpu});
  dls_mpi_reduction_destroy(reduction);
  return status;
}

/* By K; warm: from s->r and s->x. */
static dls_status solve_by_K(part *s, const choice *o, int warm, dls_info *info, dls_error *error) {
  dls_mpi_global *global = NULL;
  dls_mpi_info cost = {0};
  dls_limits limits = o->settings.limits;
  limits.warm_start = warm;
  dls_status status = dls_mpi_global_create(&global, MPI_COMM_WORLD, &s->model, NULL, error);
  dlsi_mpi_clock from = dlsi_mpi_now();
  if (!status)
    status = dls_mpi_global_solve(global, s->f, s->g, s->mu, &limits, s->r, s->x, info, error);
  const dlsi_mpi_clock now = dlsi_mpi_now();
  if (status >= 0) {
    const dls_status outcome = status;
    status = dls_mpi_global_get_info(global, &cost, error);
    if (!status) status = outcome;
  }
  if (status >= 0 && rank == 0) {
    printf("  %d unknowns, %d rows of contact, on K, %d ranks, %d factorisations\n", cost.n, cost.m,
           cost.ranks, info->factorisations);
    print_outcome(info);
  }
  if (status >= 0 && o->print)
    print_ranks(&cost, (dlsi_mpi_clock){now.wall - from.wall, now.cpu - from.cpu});
  dls_mpi_global_destroy(global);
  return status;
}

/* As dls_reduction_solve: by W, then on K if the certificate of the body does not hold. */
static dls_status solve_part(part *s, const choice *o, dls_info *info, dls_error *error) {
  dls_status status =
      o->on == 'K' ? solve_by_K(s, o, 0, info, error) : solve_by_W(s, o, info, error);
  if (!o->on && status > 0 && !dls_solved(status)) status = solve_by_K(s, o, 1, info, error);
  if (status >= 0 && rank == 0) print_ending(status, &info->certificate);
  return status;
}

static int command_solve(char *const *path, int files, const choice *o) {
  whole w = {0};
  part mine = {0};
  dls_error error = {0};
  dls_info info = {0};
  dls_status status = DLS_OK;
  if (rank == 0) status = files == 1 ? read_fclib(&w, path[0], &error) : read_mtx(&w, path, &error);
  status = dlsi_agree(MPI_COMM_WORLD, status, &error);
  if (!status) {
    if (!hand_out(&w, o->kind, &mine)) status = dlsi_no_memory(&error);
    status = dlsi_agree(MPI_COMM_WORLD, status, &error);
  }
  whole_free(&w);
  if (!status) {
    if (rank == 0) printf("%s\n", path[0]);
    status = solve_part(&mine, o, &info, &error);
  }
  if (status < 0 && rank == 0)
    (void)fprintf(stderr, "delassus-mpi: %s: %s\n", path[0], error.message);
  free(mine.ints);
  free(mine.doubles);
  return status < 0 ? BAD_INPUT : dls_solved(status) ? SOLVED : NOT_SOLVED;
}

static int complain(const char *text) {
  if (rank == 0) (void)fprintf(stderr, "delassus-mpi: %s; see 'delassus-mpi --help'\n", text);
  return BAD_INPUT;
}

static int run(int argc, char **argv) {
  static const struct option options[] = {{"kind", required_argument, NULL, 'k'},
                                          {"tol", required_argument, NULL, 't'},
                                          {"gather", required_argument, NULL, 'g'},
                                          {"on", required_argument, NULL, 'o'},
                                          {"ranks", no_argument, NULL, 'r'},
                                          {"help", no_argument, NULL, 'h'},
                                          {NULL, 0, NULL, 0}};
  choice o = {.kind = DLS_LU};
  double number = 0;
  int key;
  dls_mpi_settings_init(&o.settings);
  opterr = rank == 0;
  while ((key = getopt_long(argc, argv, "k:t:g:o:rh", options, NULL)) != -1) {
    if (key == 'h') {
      if (rank == 0) usage(stdout);
      return SOLVED;
    }
    if (key == 'r') o.print = 1;
    if (key == 'o') {
      if (strcmp(optarg, "W") != 0 && strcmp(optarg, "K") != 0) return complain("on is W or K");
      o.on = optarg[0];
    }
    if (key == 'k') {
      if (!strcmp(optarg, "cholesky"))
        o.kind = DLS_CHOLESKY;
      else if (!strcmp(optarg, "ldlt"))
        o.kind = DLS_LDLT;
      else if (strcmp(optarg, "lu") != 0)
        return complain("no such kind of K");
    }
    if (key == 't' || key == 'g') {
      if (!dlsi_read_number(optarg, strlen(optarg), &number) || number < 0 || number > 1e9)
        return complain("no such number");
      if (key == 't')
        o.settings.limits.tol = number;
      else
        o.settings.gather = (int)number;
    }
    if (key == '?') return BAD_INPUT;
  }
  const int files = argc - optind - 1;
  if (files < 0 || strcmp(argv[optind], "solve") != 0) return complain("no command");
  if (files != 1 && files != 5) return complain("one file, or five");
  return command_solve(argv + optind + 1, files, &o);
}

int main(int argc, char **argv) {
  (void)MPI_Init(&argc, &argv);
  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  (void)MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const int result = run(argc, argv);
  (void)MPI_Finalize();
  return result;
}
