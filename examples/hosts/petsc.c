/*
 * petsc.c: PETSc as the host, twice: its Mat is passed as a sparse K, and its KSP stays the
 * host's own factorisation, which answers the callback. A cube of 12^3 nodes joined by springs
 * stands on a rough floor, its top held by soft springs, and is pushed near one edge of the floor.
 *
 * Output:
 *   Mat: solved, free 0, slip 48, stick 96
 *   KSP: solved, free 0, slip 48, stick 96
 *   x of both agree to 1e-8: yes
 */
#include <delassus.h>
#include <math.h>
#include <petscksp.h>
#include <stdio.h>

enum { side = 12, nc = side * side, n = 3 * nc * side, m = 3 * nc };

static int each[2 * nc + 1], normal[nc], tangent[2 * nc];
static double f[n], mu[nc], ones[2 * nc + 1], r[m], u[m], x[2][n];

/* Assembles K, all entries, and fills H_N, H_T, f, mu. */
static PetscErrorCode assemble(Mat *K) {
  const int step[] = {1, side, side * side};
  PetscCall(MatCreateSeqAIJ(PETSC_COMM_SELF, n, n, 7, NULL, K));
  for (int j = 0; j < n; j++) {
    const int node = j / 3, at[] = {node % side, node / side % side, node / side / side};
    double diagonal = at[2] == side - 1 ? 0.05 : 0;
    for (int k = 0; k < 3; k++)
      for (int way = -1; way <= 1; way += 2) {
        if (at[k] + way < 0 || at[k] + way >= side) continue;
        diagonal += 1;
        PetscCall(MatSetValue(*K, j, j + 3 * way * step[k], -1, INSERT_VALUES));
      }
    PetscCall(MatSetValue(*K, j, j, diagonal, INSERT_VALUES));
    f[j] = j % 3 == 2 ? -1 : j % 3 == 0 && at[2] == 1 && at[1] == 0 ? 20 : 0;
  }
  PetscCall(MatAssemblyBegin(*K, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*K, MAT_FINAL_ASSEMBLY));
  for (int c = 0; c < nc; c++) {
    normal[c] = 3 * c + 2;
    tangent[2 * c] = 3 * c;
    tangent[2 * c + 1] = 3 * c + 1;
    mu[c] = 0.3;
  }
  for (int k = 0; k <= 2 * nc; k++)
    each[k] = k, ones[k] = 1;
  return 0;
}

/* Is the host's solver: X := K^-1 X, column by column, by the KSP. */
static int solve_by_ksp(void *user, double *X, int rows, int count) {
  for (int k = 0; k < count; k++) {
    Vec column;
    if (VecCreateSeqWithArray(PETSC_COMM_SELF, 1, rows, X + (size_t)k * (size_t)rows, &column) ||
        KSPSolve((KSP)user, column, column) || VecDestroy(&column))
      return 1;
  }
  return 0;
}

/* Solves; prints what came of it. */
static int run(const char *name, const dls_model *model, double *unknowns) {
  dls_reduction *reduction;
  dls_error error;
  dls_contact_state state[nc];
  int count[3] = {0};
  /* -> delassus */
  dls_status status = dls_reduction_create(&reduction, model, NULL, &error);
  if (!status) status = dls_reduction_load(reduction, f, NULL, &error);
  if (!status) status = dls_reduction_solve(reduction, mu, NULL, r, u, unknowns, NULL, &error);
  /* <- delassus */
  if (dls_solved(status) && !dls_reduction_states(reduction, mu, r, u, state, NULL))
    for (int c = 0; c < nc; c++)
      count[state[c]]++;
  printf("%s: %s, free %d, slip %d, stick %d\n", name,
         status < 0 ? error.message : dls_status_text(status), count[0], count[1], count[2]);
  dls_reduction_destroy(reduction);
  return dls_solved(status);
}

int main(int argc, char **argv) {
  Mat K;
  KSP ksp;
  PC pc;
  const PetscInt *p, *i;
  PetscInt rows;
  PetscBool done;
  PetscScalar *values;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(assemble(&K));
  /* -> delassus */
  dls_model model = {.d = 3, .n = n, .nodes = nc, .factorization = DLS_CHOLESKY};
  model.HN = (dls_sparse){n, nc, each, normal, ones};
  model.HT = (dls_sparse){n, 2 * nc, each, tangent, ones};
  /* the rows of a symmetric Mat are its columns */
  PetscCall(MatGetRowIJ(K, 0, PETSC_FALSE, PETSC_FALSE, &rows, &p, &i, &done));
  PetscCall(MatSeqAIJGetArray(K, &values));
  model.operator_kind = DLS_STIFFNESS_SPARSE;
  model.Ks = (dls_sparse){n, n, p, i, values};
  /* <- delassus */
  int good = run("Mat", &model, x[0]);
  PetscCall(MatSeqAIJRestoreArray(K, &values));
  PetscCall(KSPCreate(PETSC_COMM_SELF, &ksp));
  PetscCall(KSPSetOperators(ksp, K, K));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCCHOLESKY));
  model.operator_kind = DLS_HOST_SOLVER;
  model.solve = solve_by_ksp;
  model.user = ksp;
  good &= run("KSP", &model, x[1]);
  double apart = 0, size = 0;
  for (int k = 0; k < n; k++)
    apart = fmax(apart, fabs(x[0][k] - x[1][k])), size = fmax(size, fabs(x[0][k]));
  printf("x of both agree to 1e-8: %s\n", apart <= 1e-8 * size ? "yes" : "no");
  PetscCall(KSPDestroy(&ksp));
  PetscCall(MatDestroy(&K));
  PetscCall(PetscFinalize());
  return !(good && apart <= 1e-8 * size);
}
