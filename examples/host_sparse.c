/*
 * host_sparse.c: a host with a sparse stiffness matrix and contact in 3D. A cube of 12^3 nodes
 * joined to their neighbours by springs stands on a rough floor, its top held by soft springs; its
 * weight presses, a push along one edge of the top shears it. One reduction serves both loads.
 *
 * Output:
 *   push 15: the floor carries 1421.4, holds back 348.3; the top moves by 53.2
 *   push 25: the floor carries 1421.4, holds back 426.4; the top moves by 110.3
 */
#include <stdio.h>

#include "delassus/solve.h"

enum { side = 12, nc = side * side, n = 3 * nc * side, m = 3 * nc };

static int p[n + 1], i[4 * n], each[2 * nc + 1], normal[nc], tangent[2 * nc];
static double v[4 * n], f[n], x[n], r[m], mu[nc], ones[2 * nc + 1];

/* Lower triangle of K by columns: the node itself, then its neighbours at +x, +y, +z. */
static void assemble(void) {
  const int step[] = {1, side, side * side};
  for (int j = 0, e = 0; j < n; j++) {
    const int node = j / 3, at[] = {node % side, node / side % side, node / side / side};
    const int diagonal = e++;
    i[diagonal] = j;
    v[diagonal] = at[2] == side - 1 ? 0.05 : 0; /* the springs at the top */
    for (int k = 0; k < 3; k++) {
      v[diagonal] += (at[k] > 0) + (at[k] < side - 1);
      if (at[k] == side - 1) continue;
      i[e] = j + 3 * step[k];
      v[e++] = -1;
    }
    p[j + 1] = e;
    f[j] = j % 3 == 2 ? -1 : 0; /* weight */
  }
  for (int c = 0; c < nc; c++) { /* the floor's nodes come first: normal +z, tangents +x, +y */
    normal[c] = 3 * c + 2;
    tangent[2 * c] = 3 * c;
    tangent[2 * c + 1] = 3 * c + 1;
    mu[c] = 0.3;
  }
  for (int k = 0; k <= 2 * nc; k++) {
    each[k] = k;
    ones[k] = 1;
  }
}

int main(void) {
  assemble();
  dls_model model = {.d = 3, .n = n, .nodes = nc, .factorization = DLS_CHOLESKY};
  model.operator_kind = DLS_STIFFNESS_SPARSE;
  model.Ks = (dls_sparse){n, n, p, i, v};
  model.HN = (dls_sparse){n, nc, each, normal, ones};
  model.HT = (dls_sparse){n, 2 * nc, each, tangent, ones};
  dls_error error;
  dls_reduction *reduction;
  dls_status status = dls_reduction_create(&reduction, &model, NULL, &error);
  for (double push = 15; dls_solved(status) && push < 30; push += 10) {
    for (int c = 0; c < nc / 4; c++)
      f[n - m + 3 * c] = push;
    status = dls_reduction_load(reduction, f, NULL, &error);
    if (!status) status = dls_reduction_solve(reduction, mu, NULL, r, NULL, x, NULL, &error);
    if (!dls_solved(status)) break;
    double up = 0, back = 0;
    for (int c = 0; c < nc; c++) {
      up += r[3 * c];
      back -= r[3 * c + 1];
    }
    printf("push %.0f: the floor carries %.1f, holds back %.1f; the top moves by %.1f\n", push, up,
           back, x[n - m]);
  }
  dls_reduction_destroy(reduction);
  if (dls_solved(status)) return 0;
  fprintf(stderr, "%s\n", status < 0 ? error.message : dls_status_text(status));
  return 1;
}
