/*
 * mpi_global.c: the contact problem on K of elastic boxes on the ranks that mpirun has started, by
 * the distributed factor of K + H R H^T: wall seconds, CPU seconds outside of MPI (mpi_waits.c),
 * memory, iterations, as one row of numbers for bench/mpi_global.sh.
 *
 *   mpirun -np RANKS mpi_global CELLS HEIGHT [rows]    rows: prints the names of the columns first
 *
 * The box has CELLS x CELLS x HEIGHT cubic elements and is glued to a rigid body above. A curved
 * floor touches its middle and not its corners, and moves sideways: friction .3. The whole box
 * is made on every rank and given back before the measured part; the memory is the most that is
 * resident from there on.
 */
#include <malloc.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus.h"
#include "tests/mpi/shares.h"

static const double friction = 0.3, tol = 1e-8, megabyte = 1024 * 1024;

/* Gap of node c of the face: half of the nodes begin below the floor. */
static void curve_floor(int side, int nodes, double *g, double *mu) {
  for (int c = 0; c < nodes; c++) {
    const double x = 2.0 * (c % side) / (side - 1) - 1,
                 y = 2.0 * (c / side % side) / (side - 1) - 1;
    g[3 * c] = 1e-3 * (x * x + y * y - 0.6);
    g[3 * c + 1] = 4e-4;
    g[3 * c + 2] = 1e-4;
    mu[c] = friction;
  }
}

static double most_of(double mine) {
  double most = 0;
  (void)MPI_Reduce(&mine, &most, 1, MPI_DOUBLE, MPI_MAX, 0, MPI_COMM_WORLD);
  return most;
}

int main(int argc, char **argv) {
  box b;
  int rank;
  if (!bench_options(argc, argv, "[CELLS [HEIGHT [rows]]...]")) return 2;
  (void)MPI_Init(&argc, &argv);
  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const int cells = argc > 1 ? atoi(argv[1]) : 20, height = argc > 2 ? atoi(argv[2]) : 3;
  if (box_create_glued(&b, 3, cells, height)) MPI_Abort(MPI_COMM_WORLD, 1);
  const int nodes = b.model.nodes;
  double *g = calloc((size_t)(4 * nodes), sizeof *g), *mu = g + 3 * nodes;
  if (!g) MPI_Abort(MPI_COMM_WORLD, 1);
  curve_floor(cells + 1, nodes, g, mu);
  share part = share_take(&b.model, CUT_EVEN, NULL, g, mu);
  double *values = malloc((part.model.entries + 1) * sizeof *values);
  double *r = calloc((size_t)(3 * part.model.nodes) + 1, sizeof *r);
  double *x = calloc((size_t)part.model.rows + 1, sizeof *x);
  if (!values || !r || !x) MPI_Abort(MPI_COMM_WORLD, 1);
  memcpy(values, part.model.x, part.model.entries * sizeof *values);
  part.model.x = values;
  free(b.x); /* the arrays of H are small, and borrowed */
  free(b.i);
  b.x = NULL;
  b.i = NULL;
  (void)malloc_trim(0);
  const double before = bench_watch_memory() / megabyte;
  (void)MPI_Barrier(MPI_COMM_WORLD);
  dls_mpi_global *global = NULL;
  dls_mpi_info cost = {0};
  dls_info info = {0};
  dls_error error = {0};
  const dls_limits limits = {.tol = tol};
  const double wall = MPI_Wtime(), cpu = bench_seconds();
  dls_status status = dls_mpi_global_create(&global, MPI_COMM_WORLD, &part.model, NULL, &error);
  const double created = MPI_Wtime(), made = bench_seconds() - cpu;
  if (!status)
    status = dls_mpi_global_solve(global, NULL, part.g, part.mu, &limits, r, x, &info, &error);
  const double solved = MPI_Wtime(), spent = bench_seconds() - cpu;
  if (!status) status = dls_mpi_global_get_info(global, &cost, &error);
  double square = 0, size = 0;
  for (int k = 0; k < 3 * part.model.nodes; k++)
    square += r[k] * r[k];
  (void)MPI_Reduce(&square, &size, 1, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
  if (status) (void)fprintf(stderr, "%d %s\n", status, error.message);
  const double factor = cost.wall[DLS_MPI_FACTOR];
  const double factor_cpu = cost.cpu[DLS_MPI_FACTOR];
  const double row[] = {most_of(created - wall),
                        most_of(factor),
                        most_of(solved - created - factor),
                        most_of(solved - wall),
                        most_of(made),
                        most_of(factor_cpu),
                        most_of(spent - made - factor_cpu),
                        most_of(spent),
                        most_of(1e-6 * cost.factor_bytes),
                        most_of(bench_memory("VmHWM") / megabyte),
                        most_of(before)};
  if (rank == 0) {
    if (argc > 3)
      printf("cells,height,ranks,n,m,create,factor,iterate,all,create cpu,factor cpu,iterate "
             "cpu,all cpu,mumps MB,rss MB,rss before MB,iterations,factors,residual,size of r\n");
    printf("%d,%d,%d,%d,%d", cells, height, cost.ranks, cost.n, cost.m);
    for (int k = 0; k < 11; k++)
      printf(",%.4g", row[k]);
    printf(",%d,%d,%.3g,%.12g\n", info.iterations, info.factorisations, info.certificate.residual,
           sqrt(size));
  }
  dls_mpi_global_destroy(global);
  share_free(&part);
  box_free(&b);
  free(values);
  free(g);
  free(r);
  free(x);
  (void)MPI_Finalize();
  return status ? EXIT_FAILURE : EXIT_SUCCESS;
}
