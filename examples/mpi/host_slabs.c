/* host_slabs.c: each rank assembles its slab of a block of springs that is pressed on a floor.
 *
 * mpirun -np 4 build/examples/mpi/host_slabs [CELLS]
 * Output:
 *   540 unknowns, 36 contact nodes: solved
 *   force of the floor: normal 4.0374e-02, shear -3.4420e-03
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "delassus/mpi.h"

int main(int argc, char **argv) {
  int rank, ranks, at = 0;
  (void)MPI_Init(&argc, &argv);
  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  (void)MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const int c = argc > 1 ? atoi(argv[1]) : 5, side = c + 1, n = 3 * side * c * side;
  /* layers of cells lo .. hi-1; of nodes lo .. hi-1, and of the last rank the one behind */
  const int lo = c * rank / ranks, hi = c * (rank + 1) / ranks, cells = c * c * (hi - lo);
  const int layers = hi - lo + (rank == ranks - 1), nodes = side * layers, room = 1008 * cells;
  int *row = malloc((size_t)(2 * room + 1) * sizeof *row), *col = row + room;
  int *p = malloc((size_t)(5 * nodes + 1) * sizeof *p), *normal = p + 2 * nodes + 1;
  double *x = malloc((size_t)(room + 12 * nodes + 1) * sizeof *x), *one = x + room;
  if (!row || !p || !x) MPI_Abort(MPI_COMM_WORLD, 1);
  int *tangent = normal + nodes;
  double *g = one + 2 * nodes, *mu = g + 3 * nodes, *r = mu + nodes, *u = r + 3 * nodes;
  /* Springs of stiffness 1 between the corners of each cell. Node (i, j, k) has the unknowns from 3
   * (i + side (j + c k)) on; the face j = c is held. A spring of an interface is there twice. */
  for (int e = 0; e < cells; e++)
    for (int s = 0; s < 64; s++) {
      const int a = s / 8, b = s % 8;
      if (a >= b) continue;
      const int corner[2] = {a, b}, cell[3] = {e % c, e / c % c, lo + e / (c * c)};
      int first[2];
      double t[3], length = 0;
      for (int k = 0; k < 3; k++) {
        t[k] = (b >> k & 1) - (a >> k & 1);
        length += t[k] * t[k];
      }
      for (int k = 0; k < 2; k++) {
        const int i = cell[0] + (corner[k] & 1), j = cell[1] + (corner[k] >> 1 & 1);
        first[k] = j == c ? -1 : 3 * (i + side * (j + c * (cell[2] + (corner[k] >> 2))));
      }
      for (int k = 0; k < 36; k++) {
        const int from = k / 18, to = k / 9 % 2, i = k / 3 % 3, j = k % 3;
        if (first[from] < 0 || first[to] < 0) continue;
        row[at] = first[from] + i;
        col[at] = first[to] + j;
        x[at++] = (from == to ? 1 : -1) * t[i] * t[j] / length;
      }
    }
  for (int k = 0; k < nodes; k++) { /* the floor below j = 0 has risen by 1e-3 and moved by 3e-4 */
    normal[k] = 3 * (k % side + side * c * (lo + k / side)) + 1;
    tangent[2 * k] = normal[k] + 1;
    tangent[2 * k + 1] = normal[k] - 1;
    g[3 * k] = -1e-3, g[3 * k + 1] = 0, g[3 * k + 2] = 3e-4, mu[k] = 0.4;
  }
  for (int k = 0; k <= 2 * nodes; k++)
    p[k] = k, one[k < 2 * nodes ? k : 0] = 1;
  const dls_sparse HN = {n, nodes, p, normal, one}, HT = {n, 2 * nodes, p, tangent, one};
  const dls_mpi_model model = {
      3, DLS_CHOLESKY, 3 * side * c * layers, (size_t)at, row, col, x, nodes, HN, HT};
  dls_mpi_reduction *reduction = NULL;
  dls_error error = {0};
  dls_status status = dls_mpi_reduction_create(&reduction, MPI_COMM_WORLD, &model, NULL, &error);
  if (!status) status = dls_mpi_reduction_load(reduction, NULL, g, &error);
  if (!status) status = dls_mpi_solve(reduction, mu, NULL, r, u, NULL, &error);
  double mine[2] = {0, 0}, sum[2];
  for (int k = 0; k < 3 * nodes && !status; k++)
    mine[k % 3 == 0 ? 0 : 1] += k % 3 == 1 ? 0 : r[k];
  (void)MPI_Reduce(mine, sum, 2, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
  if (rank == 0)
    printf("%d unknowns, %d contact nodes: %s\nforce of the floor: normal %.4e, shear %.4e\n", n,
           side * side, status < 0 ? error.message : dls_status_text(status), sum[0], sum[1]);
  dls_mpi_reduction_destroy(reduction);
  free(row), free(p), free(x);
  return MPI_Finalize() || status;
}
