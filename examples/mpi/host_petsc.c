/* host_petsc.c: PETSc as the host on several ranks, with its algebraic multigrid in the place of a
 * factor, for models that are too large for one. The library takes Newton steps: one cycle of
 * multigrid (-pc_type gamg, ml, hypre) for each vector of its FGMRES. Where these fail, conjugate
 * gradients solve with K + H R H^T. A block of cubic elements is glued to a plate above and pressed
 * on a rough, curved floor that moves sideways. Each rank gives the library the rows of the
 * distributed Mat that it owns.
 *
 * mpirun -np 4 build/examples/mpi/host_petsc [CELLS [HEIGHT]]    counts and memory are printed, too
 * Output:
 *   1944 unknowns, 81 contact nodes: solved
 *   force of the floor: normal 0.01588, along its motion 0.003602
 *   agrees with the distributed factor to 1e-6: yes
 */
#include <math.h>
#include <petscksp.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>

#include "delassus/mpi.h"

/* ---- elements -------------------------------------------------------------------------------- */

/* A block of cells x cells x height elements of size 1; the nodes above are held, the others are
 * numbered along x, then y, then up. */
typedef struct block {
  int cells, height, side, n;
} block;

/* Integrates the stiffness of one element, E = 1, nu = .3, by Gauss's 8 points. */
static void element_stiffness(double Ke[24][24]) {
  const double nu = 0.3, lambda = nu / ((1 + nu) * (1 - 2 * nu)), shear = 1 / (2 * (1 + nu));
  for (int i = 0; i < 24; i++)
    for (int j = 0; j < 24; j++)
      Ke[i][j] = 0;
  for (int g = 0; g < 8; g++) {
    double slope[8][3];
    for (int a = 0; a < 8; a++)
      for (int k = 0; k < 3; k++) {
        slope[a][k] = a >> k & 1 ? 1 : -1;
        for (int j = 0; j < 3; j++)
          if (j != k)
            slope[a][k] *= (1 + (a >> j & 1 ? 1 : -1) * (g >> j & 1 ? 1 : -1) / sqrt(3)) / 2;
      }
    for (int a = 0; a < 8; a++)
      for (int b = 0; b < 8; b++) {
        const double *s = slope[a], *t = slope[b];
        const double both = shear * (s[0] * t[0] + s[1] * t[1] + s[2] * t[2]);
        for (int i = 0; i < 3; i++)
          for (int j = 0; j < 3; j++)
            Ke[3 * a + i][3 * b + j] +=
                (lambda * s[i] * t[j] + shear * s[j] * t[i] + (i == j ? both : 0)) / 8;
      }
  }
}

/* Adds up the rows of K that this rank owns, with the elements around its nodes. */
static PetscErrorCode block_assemble(const block *b, Mat K, int first, int end) {
  double Ke[24][24];
  element_stiffness(Ke);
  for (int node = first / 3; node < end / 3; node++) {
    const int at[] = {node % b->side, node / b->side % b->side, node / (b->side * b->side)};
    for (int a = 0; a < 8; a++) { /* node is corner a of the element from `from` on */
      const int from[] = {at[0] - (a & 1), at[1] - (a >> 1 & 1), at[2] - (a >> 2)};
      if (from[0] < 0 || from[1] < 0 || from[2] < 0 || from[0] == b->cells || from[1] == b->cells ||
          from[2] == b->height)
        continue;
      for (int c = 0; c < 8; c++) {
        const int to[] = {from[0] + (c & 1), from[1] + (c >> 1 & 1), from[2] + (c >> 2)};
        if (to[2] == b->height) continue;
        const int other = to[0] + b->side * (to[1] + b->side * to[2]);
        double part[9];
        for (int k = 0; k < 9; k++)
          part[k] = Ke[3 * a + k / 3][3 * c + k % 3];
        PetscCall(MatSetValuesBlocked(K, 1, &node, 1, &other, part, ADD_VALUES));
      }
    }
  }
  PetscCall(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
  return 0;
}

/* Tells K the motions of a rigid body, which multigrid keeps on coarse levels. */
static PetscErrorCode block_motions(const block *b, Mat K, int first, int end) {
  Vec where;
  MatNullSpace motions;
  PetscCall(MatCreateVecs(K, &where, NULL));
  PetscCall(VecSetBlockSize(where, 3));
  for (int node = first / 3; node < end / 3; node++) {
    const double x[] = {node % b->side, node / b->side % b->side, node / (b->side * b->side)};
    PetscCall(VecSetValuesBlocked(where, 1, &node, x, INSERT_VALUES));
  }
  PetscCall(VecAssemblyBegin(where));
  PetscCall(VecAssemblyEnd(where));
  PetscCall(MatNullSpaceCreateRigidBody(where, &motions));
  PetscCall(MatSetNearNullSpace(K, motions));
  PetscCall(MatNullSpaceDestroy(&motions));
  PetscCall(VecDestroy(&where));
  return 0;
}

/* Copies the rows first .. end-1 of K, on and below the diagonal, as entries; only counts them for
 * row NULL. Returns how many. */
static size_t take_rows(Mat K, int first, int end, int *row, int *col, double *x) {
  size_t count = 0;
  for (int i = first; i < end; i++) {
    int entries;
    const int *at;
    const double *value;
    if (MatGetRow(K, i, &entries, &at, &value)) PETSCABORT(PETSC_COMM_SELF, PETSC_ERR_PLIB);
    for (int k = 0; k < entries; k++) {
      if (at[k] > i) continue;
      if (row) row[count] = i, col[count] = at[k], x[count] = value[k];
      count++;
    }
    if (MatRestoreRow(K, i, &entries, &at, &value)) PETSCABORT(PETSC_COMM_SELF, PETSC_ERR_PLIB);
  }
  return count;
}

/* ---- the solver for K + H R H^T -------------------------------------------------------------- */

typedef struct solver {
  Mat A; /* K + H R H^T */
  KSP krylov;
  Vec added; /* the diagonal of H R H^T so far */
  Vec b, x;
  int nodes;
  const int *normal, *tangent; /* rows of H of this rank's contact nodes, one entry each */
  int solves, iterations;
  Mat K, P; /* P = K + H R H^T of blocks, the matrix of `cycle` */
  PC cycle;
  int cycles;
} solver;

/* Adds the change of H R H^T, which is diagonal here, to A. */
static PetscErrorCode solver_add(solver *s, const double *R) {
  Vec change;
  PetscCall(VecDuplicate(s->added, &change));
  for (int c = 0; c < s->nodes; c++) {
    const int at[] = {s->normal[c], s->tangent[2 * c], s->tangent[2 * c + 1]};
    PetscCall(VecSetValues(change, 3, at, R + 3 * c, INSERT_VALUES));
  }
  PetscCall(VecAssemblyBegin(change));
  PetscCall(VecAssemblyEnd(change));
  PetscCall(VecAYPX(s->added, -1, change)); /* new - old */
  PetscCall(MatDiagonalSet(s->A, s->added, ADD_VALUES));
  PetscCall(VecCopy(change, s->added));
  PetscCall(VecDestroy(&change));
  PetscCall(KSPSetOperators(s->krylov, s->A, s->A));
  return 0;
}

static dls_status solver_prepare(void *data, const double *R, dls_error *error) {
  (void)error; /* the library says that the host's solver failed */
  return solver_add(data, R) ? DLS_E_MEMORY : DLS_OK;
}

static PetscErrorCode solver_run(solver *s, const double *b, double *x, double accuracy) {
  int steps;
  KSPConvergedReason reason;
  PetscCall(VecPlaceArray(s->b, b));
  PetscCall(VecPlaceArray(s->x, x));
  PetscCall(KSPSetTolerances(s->krylov, accuracy, 0, PETSC_DEFAULT, 1000));
  PetscCall(KSPSolve(s->krylov, s->b, s->x));
  PetscCall(KSPGetIterationNumber(s->krylov, &steps));
  PetscCall(KSPGetConvergedReason(s->krylov, &reason));
  PetscCall(VecResetArray(s->b));
  PetscCall(VecResetArray(s->x));
  s->solves++;
  s->iterations += steps;
  return reason < 0;
}

static dls_status solver_solve(void *data, const double *b, double *x, double accuracy,
                               dls_error *error) {
  (void)error;
  return solver_run(data, b, x, accuracy) ? DLS_E_SINGULAR : DLS_OK;
}

/* Makes P, with blocks on the unknowns of each contact node, and multigrid for it. */
static PetscErrorCode solver_join(solver *s, const double *R) {
  PetscCall(PCDestroy(&s->cycle));
  PetscCall(MatDestroy(&s->P));
  PetscCall(MatDuplicate(s->K, MAT_COPY_VALUES, &s->P));
  for (int c = 0; c < s->nodes; c++) {
    const int at[] = {s->normal[c], s->tangent[2 * c], s->tangent[2 * c + 1]};
    PetscCall(MatSetValues(s->P, 3, at, 3, at, R + 9 * c, ADD_VALUES));
  }
  PetscCall(MatAssemblyBegin(s->P, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(s->P, MAT_FINAL_ASSEMBLY));
  PetscCall(MatSetOption(s->P, MAT_SPD, PETSC_TRUE));
  PetscCall(PCCreate(PETSC_COMM_WORLD, &s->cycle));
  PetscCall(PCSetType(s->cycle, PCGAMG));
  PetscCall(PCSetFromOptions(s->cycle));
  PetscCall(PCSetOperators(s->cycle, s->P, s->P));
  PetscCall(PCSetUp(s->cycle));
  return 0;
}

static dls_status solver_block(void *data, const double *R, dls_error *error) {
  (void)error;
  return solver_join(data, R) ? DLS_E_MEMORY : DLS_OK;
}

static PetscErrorCode solver_cycle(solver *s, const double *b, double *x) {
  PetscCall(VecPlaceArray(s->b, b));
  PetscCall(VecPlaceArray(s->x, x));
  PetscCall(PCApply(s->cycle, s->b, s->x));
  PetscCall(VecResetArray(s->b));
  PetscCall(VecResetArray(s->x));
  s->cycles++;
  return 0;
}

static dls_status solver_apply(void *data, const double *b, double *x, double accuracy,
                               dls_error *error) {
  (void)accuracy;
  (void)error;
  return solver_cycle(data, b, x) ? DLS_E_SINGULAR : DLS_OK;
}

static PetscErrorCode solver_create(solver *s, Mat K) {
  PC multigrid;
  s->K = K;
  PetscCall(MatDuplicate(K, MAT_COPY_VALUES, &s->A));
  PetscCall(MatSetOption(s->A, MAT_SPD, PETSC_TRUE));
  PetscCall(MatCreateVecs(K, &s->added, NULL));
  PetscCall(VecDuplicate(s->added, &s->b));
  PetscCall(VecDuplicate(s->added, &s->x));
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &s->krylov));
  PetscCall(KSPSetType(s->krylov, KSPCG));
  PetscCall(KSPSetNormType(s->krylov, KSP_NORM_UNPRECONDITIONED)); /* |b - A x| */
  PetscCall(KSPSetInitialGuessNonzero(s->krylov, PETSC_TRUE));
  PetscCall(KSPGetPC(s->krylov, &multigrid));
  PetscCall(PCSetType(multigrid, PCGAMG));
  PetscCall(KSPSetFromOptions(s->krylov));
  return 0;
}

static PetscErrorCode solver_destroy(solver *s) {
  PetscCall(KSPDestroy(&s->krylov));
  PetscCall(PCDestroy(&s->cycle));
  PetscCall(MatDestroy(&s->P));
  PetscCall(MatDestroy(&s->K));
  PetscCall(MatDestroy(&s->A));
  PetscCall(VecDestroy(&s->added));
  PetscCall(VecDestroy(&s->b));
  PetscCall(VecDestroy(&s->x));
  return 0;
}

/* ---- the contact problem --------------------------------------------------------------------- */

/* The floor under a node: half of the nodes begin below it; it moves along x. */
static void floor_gap(const block *b, int node, double *g) {
  const double x = 2.0 * (node % b->side) / b->cells - 1, y = 2.0 * (node / b->side) / b->cells - 1;
  g[0] = 1e-3 * b->cells * (x * x + y * y - 0.6);
  g[1] = -4e-4 * b->cells;
  g[2] = 0;
}

/* Solves by a solver, or by the distributed factor for NULL. */
static dls_status contact_solve(const dls_mpi_model *model, const dls_global_solver *how,
                                const double *g, const double *mu, double *r, double *x,
                                dls_info *info, dls_error *error) {
  dls_mpi_global *global = NULL;
  dls_status status = dls_mpi_global_create(&global, PETSC_COMM_WORLD, model, how, error);
  if (!status) status = dls_mpi_global_solve(global, NULL, g, mu, NULL, r, x, info, error);
  dls_mpi_global_destroy(global);
  return status;
}

static void print_counts(const solver *s, const dls_info *info, double seconds) {
  struct rusage used;
  (void)getrusage(RUSAGE_SELF, &used);
  double mine = 1e-3 * (double)used.ru_maxrss, sum;
  (void)MPI_Allreduce(&mine, &sum, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  (void)PetscPrintf(PETSC_COMM_WORLD,
                    "%d outer iterations, %d matrices, %d cycles of Newton steps, %.1f Krylov "
                    "iterations a solve, residual "
                    "%.2e, %.0f s, %.0f MB on all ranks\n",
                    info->iterations, info->factorisations, s->cycles,
                    (double)s->iterations / (s->solves ? s->solves : 1), info->certificate.residual,
                    seconds, sum);
}

static void *room(size_t count, size_t size) {
  void *p = calloc(count + 1, size);
  if (!p) (void)MPI_Abort(PETSC_COMM_WORLD, 1);
  return p;
}

int main(int argc, char **argv) {
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  const int told = argc > 1 && argv[1][0] != '-', cells = told ? atoi(argv[1]) : 8;
  const int height = told && argc > 2 && argv[2][0] != '-' ? atoi(argv[2]) : cells;
  const block b = {cells, height, cells + 1, 3 * (cells + 1) * (cells + 1) * height};
  Mat K;
  int first, end, nodes = 0, local = PETSC_DECIDE, all = b.n / 3;
  PetscCall(PetscSplitOwnership(PETSC_COMM_WORLD, &local, &all));
  PetscCall(
      MatCreateBAIJ(PETSC_COMM_WORLD, 3, 3 * local, 3 * local, b.n, b.n, 27, NULL, 26, NULL, &K));
  PetscCall(MatGetOwnershipRange(K, &first, &end));
  PetscCall(block_assemble(&b, K, first, end));
  PetscCall(MatConvert(K, MATAIJ, MAT_INPLACE_MATRIX, &K));
  PetscCall(block_motions(&b, K, first, end));

  /* a contact node belongs to the rank of its rows: normal up, tangents x and y */
  const size_t most = (size_t)(b.side * b.side), rows = (size_t)(end - first);
  int *normal = room(5 * most + 1, sizeof *normal), *tangent = normal + most;
  int *each = tangent + 2 * most;
  double *one = room(9 * most, sizeof *one), *g = one + 2 * most, *mu = g + 3 * most;
  double *r = mu + most, *x = room(rows, sizeof *x);
  for (int node = first / 3; node < end / 3 && node < (int)most; node++) {
    normal[nodes] = 3 * node + 2;
    tangent[2 * nodes] = 3 * node;
    tangent[2 * nodes + 1] = 3 * node + 1;
    floor_gap(&b, node, g + 3 * nodes);
    mu[nodes++] = 0.3;
  }
  for (int k = 0; k <= 2 * nodes; k++)
    each[k] = k, one[k < 2 * nodes ? k : 0] = 1;
  const size_t entries = take_rows(K, first, end, NULL, NULL, NULL);
  int *row = room(2 * entries, sizeof *row), *col = row + entries;
  double *value = room(entries, sizeof *value);
  (void)take_rows(K, first, end, row, col, value);
  const dls_sparse HN = {b.n, nodes, each, normal, one}, HT = {b.n, 2 * nodes, each, tangent, one};
  const dls_mpi_model model = {3,   DLS_CHOLESKY, end - first, entries, row,
                               col, value,        nodes,       HN,      HT};

  solver s = {.nodes = nodes, .normal = normal, .tangent = tangent};
  const dls_global_solver how = {&s, solver_prepare, solver_solve, solver_block, solver_apply};
  dls_info info = {0};
  dls_error error = {0};
  const double begun = MPI_Wtime();
  PetscCall(solver_create(&s, K));
  dls_status status = contact_solve(&model, &how, g, mu, r, x, &info, &error);
  int touching, here = nodes;
  double mine[2] = {0, 0}, sum[2];
  for (int c = 0; c < nodes; c++)
    mine[0] += r[3 * c], mine[1] += r[3 * c + 1];
  (void)MPI_Allreduce(mine, sum, 2, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  (void)MPI_Allreduce(&here, &touching, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
  PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                        "%d unknowns, %d contact nodes: %s\n"
                        "force of the floor: normal %.4g, along its motion %.4g\n",
                        b.n, touching, status < 0 ? error.message : dls_status_text(status), sum[0],
                        sum[1]));
  if (told)
    print_counts(&s, &info, MPI_Wtime() - begun);
  else if (!status) {
    double *theirs = room(3 * most, sizeof *theirs), size[2] = {0, 0}, largest[2];
    status = contact_solve(&model, NULL, g, mu, theirs, x, &info, &error);
    for (int k = 0; k < 3 * nodes; k++) {
      size[0] = fmax(size[0], fabs(r[k] - theirs[k]));
      size[1] = fmax(size[1], fabs(theirs[k]));
    }
    (void)MPI_Allreduce(size, largest, 2, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "agrees with the distributed factor to 1e-6: %s\n",
                          !status && largest[0] <= 1e-6 * largest[1] ? "yes" : "no"));
    free(theirs);
  }
  PetscCall(solver_destroy(&s));
  free(normal);
  free(one);
  free(x);
  free(row);
  free(value);
  PetscCall(PetscFinalize());
  return status != DLS_OK;
}
