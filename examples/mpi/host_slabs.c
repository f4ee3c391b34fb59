/* A host on several ranks: each assembles its slab of an elastic block, pressed on a floor and sheared, friction 0.4.
 *
 * mpirun -np 4 build/examples/mpi/host_slabs [CELLS]
 * Output:
 *   648 unknowns, 36 contact nodes
 *   solved, residual below 1e-8: yes
 *   resultant of the floor: normal 7.2345e-03, shear -1.0927e-03
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/mpi.h"

/* Cubes of side 1, E = 1, nu = 0.3; node (i, j, k) has the unknowns 3 (i + (c+1) (j + c k)) ..; j = c is held. */
static double element(int a, int b, int i, int j) { /* K of the corners a, b in directions i, j */
  double sum = 0, s[2][3];
  for (int g = 0; g < 8; g++) { /* Gauss's points */
    for (int n = 0; n < 2; n++)
      for (int k = 0; k < 3; k++) {
        const int corner = n ? b : a;
        s[n][k] = corner >> k & 1 ? 1 : -1;
        for (int l = 0; l < 3; l++)
          if (l != k)
            s[n][k] *= (1 + (corner >> l & 1 ? 1 : -1) * (g >> l & 1 ? 1 : -1) / sqrt(3)) / 2;
      }
    const double dot = s[0][0] * s[1][0] + s[0][1] * s[1][1] + s[0][2] * s[1][2];
    sum += (0.577 * s[0][i] * s[1][j] + 0.385 * (s[0][j] * s[1][i] + (i == j) * dot)) / 8;
  }
  return sum;
}

int main(int argc, char **argv) {
  int rank, ranks, at = 0;
  (void)MPI_Init(&argc, &argv);
  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  (void)MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const int c = argc > 1 ? atoi(argv[1]) : 5, lo = c * rank / ranks, hi = c * (rank + 1) / ranks;
  /* element layers lo .. hi-1; node layers from lo on, the last rank's with the one behind */
  const int layers = hi - lo + (rank == ranks - 1), side = c + 1, nodes = side * layers;
  const int room = 576 * c * c * (hi - lo), n = 3 * side * c * side;
  int *row = malloc((size_t)(2 * room + 1) * sizeof *row), *col = row + room;
  int *p = malloc((size_t)(5 * nodes + 1) * sizeof *p), *normal = p + 2 * nodes + 1,
      *tangent = normal + nodes;
  double *x = malloc((size_t)(room + 13 * nodes + 1) * sizeof *x), *one = x + room,
         *g = one + 2 * nodes, *mu = g + 3 * nodes, *r = mu + nodes, *u = r + 3 * nodes;
  if (!row || !p || !x) MPI_Abort(MPI_COMM_WORLD, 1);
  for (int e = 0; e < c * c * (hi - lo); e++)
    for (int k = 0; k < 576; k++) {
      const int a = k / 72, b = k / 9 % 8, i = k / 3 % 3, j = k % 3, y = e / c % c,
                z = lo + e / (c * c);
      if (y + (a >> 1 & 1) == c || y + (b >> 1 & 1) == c) continue;
      row[at] = 3 * (e % c + (a & 1) + side * (y + (a >> 1 & 1) + c * (z + (a >> 2)))) + i;
      col[at] = 3 * (e % c + (b & 1) + side * (y + (b >> 1 & 1) + c * (z + (b >> 2)))) + j;
      x[at++] = element(a, b, i, j);
    }
  for (int k = 0; k < nodes; k++) { /* the floor below j = 0 rises by 1e-3 and moves by 3e-4 */
    const int first = 3 * (k % side + side * c * (lo + k / side));
    normal[k] = first + 1, tangent[2 * k] = first + 2, tangent[2 * k + 1] = first;
    g[3 * k] = -1e-3, g[3 * k + 1] = 0, g[3 * k + 2] = 3e-4, mu[k] = 0.4;
  }
  for (int k = 0; k <= 2 * nodes; k++)
    p[k] = k;
  for (int k = 0; k < 2 * nodes; k++)
    one[k] = 1;
  const dls_mpi_model model = {3,
                               DLS_CHOLESKY,
                               3 * side * c * layers,
                               (size_t)at,
                               row,
                               col,
                               x,
                               nodes,
                               {n, nodes, p, normal, one},
                               {n, 2 * nodes, p, tangent, one}};
  dls_mpi_reduction *reduction = NULL;
  dls_error error = {0};
  dls_info info = {0};
  dls_status status = dls_mpi_reduction_create(&reduction, MPI_COMM_WORLD, &model, NULL, &error);
  if (!status) status = dls_mpi_reduction_load(reduction, NULL, g, &error);
  if (!status) status = dls_mpi_solve(reduction, mu, NULL, r, u, &info, &error);
  double mine[2] = {0, 0}, sum[2];
  for (int k = 0; k < nodes && !status; k++)
    mine[0] += r[3 * k], mine[1] += r[3 * k + 2];
  (void)MPI_Reduce(mine, sum, 2, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
  if (rank == 0 && status) printf("%s\n", status < 0 ? error.message : dls_status_text(status));
  if (rank == 0 && !status)
    printf("%d unknowns, %d contact nodes\n%s, residual below 1e-8: %s\nresultant of the floor: "
           "normal %.4e, shear %.4e\n",
           n, side * side, dls_status_text(status),
           info.certificate.residual <= 1e-8 ? "yes" : "no", sum[0], sum[1]);
  dls_mpi_reduction_destroy(reduction);
  free(row), free(p), free(x);
  (void)MPI_Finalize();
  return status != DLS_OK;
}
