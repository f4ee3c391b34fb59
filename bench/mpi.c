/*
 * mpi.c: the reduction and the solve of an elastic cube on the ranks that mpirun has started: wall
 * seconds, CPU seconds outside of MPI (mpi_waits.c), memory and operations of each phase, as one
 * row of numbers for bench/mpi.sh.
 *
 *   mpirun -np RANKS mpi CELLS [rows]    rows: prints the names of the columns first
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "common.h"
#include "delassus.h"
#include "tests/mpi/shares.h"

enum { LOAD = DLS_MPI_PHASES, SOLVE, RECOVER, PHASES };

static const char *const phases[] = {"order", "analyse", "factor", "invert",
                                     "form",  "load",    "solve",  "recover"};

typedef struct spent {
  double wall[PHASES], cpu[PHASES];
} spent;

static void stop_clock(spent *s, int phase, double wall, double cpu) {
  s->wall[phase] = MPI_Wtime() - wall;
  s->cpu[phase] = bench_seconds() - cpu;
}

static void collect(double mine, double *most, double *sum) {
  (void)MPI_Reduce(&mine, most, 1, MPI_DOUBLE, MPI_MAX, 0, MPI_COMM_WORLD);
  (void)MPI_Reduce(&mine, sum, 1, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
}

/* Prints the row on rank 0. */
static void report(int cells, const dls_mpi_info *cost, const spent *s, const dls_info *info,
                   double size) {
  struct rusage used;
  double most, sum;
  (void)getrusage(RUSAGE_SELF, &used);
  const int root = cost->rank == 0;
  if (root) printf("%d,%d,%d,%d", cells, cost->ranks, cost->n, cost->m);
  for (int k = 0; k < PHASES; k++) {
    collect(s->wall[k], &most, &sum);
    if (root) printf(",%.3f", most);
    collect(s->cpu[k], &most, &sum);
    if (root) printf(",%.3f,%.3f", most, sum);
  }
  collect(1e-6 * cost->factor_bytes, &most, &sum);
  if (root) printf(",%.0f,%.0f", most, sum);
  collect(1e-6 * cost->dense_bytes, &most, &sum);
  if (root) printf(",%.0f", most);
  collect(1e-3 * (double)used.ru_maxrss, &most, &sum);
  if (root) printf(",%.0f", most);
  collect(cost->flops, &most, &sum);
  if (root)
    printf(",%.4g,%.4g,%d,%.3g,%.15g\n", most, sum, info->iterations, info->certificate.residual,
           size);
}

static void print_names(void) {
  printf("cells,ranks,n,m");
  for (int k = 0; k < PHASES; k++)
    printf(",%s wall,%s cpu max,%s cpu sum", phases[k], phases[k], phases[k]);
  printf(",mumps MB max,mumps MB sum,dense MB max,rss MB max,flops max,flops "
         "sum,iterations,residual,size of r\n");
}

/* Loads: pushed down by an amount that grows along the face, and sheared. */
static void load(int nodes, double *g, double *mu) {
  for (int c = 0; c < nodes; c++) {
    g[3 * c] = -1e-3;
    g[3 * c + 1] = 4e-4;
    g[3 * c + 2] = 1e-4;
    mu[c] = 0.3;
  }
}

int main(int argc, char **argv) {
  box b;
  if (!bench_options(argc, argv, "[CELLS [rows]...]")) return 2;
  (void)MPI_Init(&argc, &argv);
  const int cells = argc > 1 ? atoi(argv[1]) : 10;
  if (box_create(&b, 3, cells, 0)) MPI_Abort(MPI_COMM_WORLD, 1);
  const int n = b.model.n, nodes = b.model.nodes;
  double *f = calloc((size_t)(2 * n + 10 * nodes), sizeof *f);
  if (!f) MPI_Abort(MPI_COMM_WORLD, 1);
  double *x = f + n, *g = x + n, *mu = g + 3 * nodes, *r = mu + nodes, *u = r + 3 * nodes;
  load(nodes, g, mu);
  share part = share_take(&b.model, CUT_EVEN, f, g, mu);
  dls_mpi_reduction *reduction = NULL;
  dls_mpi_info cost = {0};
  dls_mpi_settings settings;
  dls_info info = {0};
  dls_error error = {0};
  spent s = {0};
  dls_mpi_settings_init(&settings);
  settings.gather = 0;
  dls_status status =
      dls_mpi_reduction_create(&reduction, MPI_COMM_WORLD, &part.model, NULL, &error);
  if (!status) status = dls_mpi_reduction_get_info(reduction, &cost, &error);
  memcpy(s.wall, cost.wall, sizeof cost.wall);
  memcpy(s.cpu, cost.cpu, sizeof cost.cpu);
  double wall = MPI_Wtime(), cpu = bench_seconds();
  if (!status) status = dls_mpi_reduction_load(reduction, part.f, part.g, &error);
  stop_clock(&s, LOAD, wall, cpu);
  wall = MPI_Wtime(), cpu = bench_seconds();
  if (!status) status = dls_mpi_solve(reduction, part.mu, &settings, r, u, &info, &error);
  stop_clock(&s, SOLVE, wall, cpu);
  wall = MPI_Wtime(), cpu = bench_seconds();
  if (status >= 0) status = dls_mpi_reduction_recover(reduction, r, x, &error);
  stop_clock(&s, RECOVER, wall, cpu);
  double square = 0, sum = 0;
  for (int k = 0; k < 3 * part.model.nodes; k++)
    square += r[k] * r[k];
  (void)MPI_Allreduce(&square, &sum, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  if (status) (void)fprintf(stderr, "%s\n", error.message);
  if (argc > 2 && cost.rank == 0) print_names();
  if (!status) report(cells, &cost, &s, &info, sqrt(sum));
  dls_mpi_reduction_destroy(reduction);
  share_free(&part);
  box_free(&b);
  free(f);
  (void)MPI_Finalize();
  return status ? EXIT_FAILURE : EXIT_SUCCESS;
}
