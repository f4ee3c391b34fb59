/*
 * assemble.c: assembles stiffness and mass of a mesh, dense and sparse; edge loads; stress.
 *
 * Sparse: the entries of all elements go to columns in the order of the elements. A transposition
 * sorts the rows (the matrix is its own transpose, entry by entry). Then entries of the same place
 * stand side by side and are summed. O(entries) time, three times their memory.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fe_internal.h"

enum { most_unknowns = 8 }; /* of an element */

/* The matrix that is assembled: stiffness with D, or mass with rho. */
typedef struct assembly {
  const dls_fe_mesh *mesh;
  const int *unknown; /* NULL: all, in order */
  int n;              /* of the matrix */
  int mass, lumped;
  dlsi_lame D;
  double rho;
} assembly;

static dlsi_lame assemble_moduli(double E, double nu) { /* (TR2) of t3.c */
  return (dlsi_lame){.l = E * nu / ((1 + nu) * (1 - 2 * nu)), .G = E / (2 * (1 + nu))};
}

/* Checks the mesh, and that the area of every element is above the rounding of its coordinates. */
static dls_status assemble_check_mesh(const dls_fe_mesh *mesh, dls_error *error) {
  const dls_status status = dlsi_fe_check_mesh(mesh, error);
  if (status) return status;
  const int corners = dlsi_fe_corners(mesh);
  for (int e = 0; e < dlsi_fe_elements(mesh); e++)
    if (corners == 3 ? dlsi_t3_is_flat(mesh, e) : dlsi_quad_is_flat(mesh, e))
      return dlsi_fail(error, DLS_E_ARGUMENT, corners == 3 ? "node" : "quad",
                       (long long)corners * e, 0,
                       corners == 3 ? "triangle %d is flat or clockwise"
                                    : "element %d is flat, clockwise or not convex",
                       e);
  return DLS_OK;
}

static dls_status assemble_check(const dls_fe_mesh *mesh, double E, double nu, dls_error *error) {
  const dls_status status = assemble_check_mesh(mesh, error);
  if (status) return status;
  const dlsi_setting material[] = {{"E", E, 0, DBL_MAX, 1}, {"nu", nu, -1, 0.5, 1}};
  return dlsi_check_each(2, material, error);
}

/* Computes the matrix of element e, 2c x 2c column-major. Of a mass all entries that couple x and y
 * are 0. */
static void assemble_element(const assembly *a, int e, double *k) {
  const int c = dlsi_fe_corners(a->mesh), ld = 2 * c;
  if (!a->mass) {
    (c == 3 ? dlsi_t3_stiffness : dlsi_quad_stiffness)(a->mesh, e, &a->D, k);
    return;
  }
  double m[16];
  if (c == 3)
    dlsi_t3_mass(a->mesh, e, a->rho, m);
  else
    dlsi_quad_mass(a->mesh, e, a->rho, m);
  memset(k, 0, (size_t)(ld * ld) * sizeof *k);
  for (int j = 0; j < c; j++)
    for (int i = 0; i < c; i++) {
      double *block = a->lumped ? k + 2 * i + 2 * i * ld : k + 2 * i + 2 * j * ld;
      block[0] += m[i + c * j];
      block[ld + 1] += m[i + c * j];
    }
}

/* ---- dense ----------------------------------------------------------------------------------- */

/* Checks the arguments of dls_fe_stiffness. */
static dls_status stiffness_check(const dls_fe_mesh *mesh, double E, double nu, const double *K,
                                  int ldk, dls_error *error) {
  const dls_status status = assemble_check(mesh, E, nu, error);
  if (status) return status;
  if (!K) return dlsi_is_null(error, "K");
  const int n = 2 * mesh->nodes;
  return ldk >= n
             ? DLS_OK
             : dlsi_fail(error, DLS_E_SIZE, "ldk", -1, ldk, "is %d, must be at least %d", ldk, n);
}

dls_status dls_fe_stiffness(const dls_fe_mesh *mesh, double E, double nu, double *K, int ldk,
                            dls_error *error) {
  DLSI_DOOR;
  const dls_status status = stiffness_check(mesh, E, nu, K, ldk, error);
  if (status) return dlsi_at(__func__, status, error);
  const int n = 2 * mesh->nodes, corners = dlsi_fe_corners(mesh);
  const size_t ld = (size_t)ldk;
  const assembly a = {.mesh = mesh, .D = assemble_moduli(E, nu)};
  for (int j = 0; j < n; j++)
    memset(K + (size_t)j * ld, 0, (size_t)n * sizeof *K);
  for (int e = 0; e < dlsi_fe_elements(mesh); e++) {
    const int *node = dlsi_fe_corner(mesh, e);
    double k[most_unknowns * most_unknowns];
    assemble_element(&a, e, k);
    for (int j = 0; j < 2 * corners; j++)
      for (int i = 0; i < 2 * corners; i++)
        K[2 * (size_t)node[i / 2] + (size_t)(i % 2) +
          (2 * (size_t)node[j / 2] + (size_t)(j % 2)) * ld] += k[i + 2 * corners * j];
  }
  return DLS_OK;
}

/* ---- sparse ---------------------------------------------------------------------------------- */

/* Checks the numbers of the unknowns; *n := the size of the matrix. */
static dls_status assemble_number(const dls_fe_mesh *mesh, const int *unknown, int unknowns, int *n,
                                  dls_error *error) {
  *n = unknown ? unknowns : 2 * mesh->nodes;
  if (!unknown) return DLS_OK;
  if (unknowns < 1 || unknowns > 2 * mesh->nodes)
    return dlsi_fail(error, DLS_E_SIZE, "unknowns", -1, unknowns, "is %d, outside of 1 .. %d",
                     unknowns, 2 * mesh->nodes);
  for (int k = 0; k < 2 * mesh->nodes; k++)
    if (unknown[k] < -1 || unknown[k] >= unknowns)
      return dlsi_fail(error, DLS_E_ARGUMENT, "unknown", k, unknown[k],
                       "is %d, outside of -1 .. %d", unknown[k], unknowns - 1);
  return DLS_OK;
}

/* Fills row[] with the matrix's numbers of the unknowns of element e; returns their count. */
static int assemble_rows(const assembly *a, int e, int row[most_unknowns]) {
  const int count = 2 * dlsi_fe_corners(a->mesh), *node = dlsi_fe_corner(a->mesh, e);
  for (int k = 0; k < count; k++) {
    const int at = 2 * node[k / 2] + k % 2;
    row[k] = a->unknown ? a->unknown[at] : at;
  }
  return count;
}

/* Returns 1 if entry (i, j) of an element's matrix belongs to the pattern. */
static int assemble_has(const assembly *a, int i, int j) {
  if (!a->mass) return 1;
  return a->lumped ? i == j : i % 2 == j % 2;
}

/* Counts the entries of each column of all elements' matrices into p (n + 1); returns their sum. */
static size_t assemble_count(const assembly *a, size_t *p) {
  for (int k = 0; k <= a->n; k++)
    p[k] = 0;
  for (int e = 0; e < dlsi_fe_elements(a->mesh); e++) {
    int row[most_unknowns];
    const int count = assemble_rows(a, e, row);
    for (int j = 0; j < count; j++)
      for (int i = 0; i < count; i++)
        if (row[i] >= 0 && row[j] >= 0 && assemble_has(a, i, j)) p[row[j] + 1]++;
  }
  for (int k = 0; k < a->n; k++)
    p[k + 1] += p[k];
  return p[a->n];
}

/* Fills the columns that p delimits, entries in the order of the elements; moves p[j] to the end of
 * column j. */
static void assemble_fill(const assembly *a, size_t *p, int *index, double *x) {
  for (int e = 0; e < dlsi_fe_elements(a->mesh); e++) {
    int row[most_unknowns];
    double k[most_unknowns * most_unknowns];
    const int count = assemble_rows(a, e, row);
    assemble_element(a, e, k);
    for (int j = 0; j < count; j++)
      for (int i = 0; i < count; i++) {
        if (row[i] < 0 || row[j] < 0 || !assemble_has(a, i, j)) continue;
        index[p[row[j]]] = row[i];
        x[p[row[j]]++] = k[i + count * j];
      }
  }
}

/* Restores the beginnings of the columns from their ends. */
static void assemble_rewind(int n, size_t *p) {
  for (int j = n; j > 0; j--)
    p[j] = p[j - 1];
  p[0] = 0;
}

/* Transposes the columns (p, i, x) into (ti, tx), which the same p delimits: rows come out
 * sorted. */
static void assemble_sort(int n, size_t *p, const int *i, const double *x, size_t *at, int *ti,
                          double *tx) {
  memcpy(at, p, (size_t)n * sizeof *at);
  for (int j = 0; j < n; j++)
    for (size_t k = p[j]; k < p[j + 1]; k++) {
      const size_t to = at[i[k]]++;
      ti[to] = j;
      tx[to] = x[k];
    }
}

/* Sums neighbours of the same place. P: out, n + 1; i, x: in and out. */
static void assemble_sum(int n, const size_t *p, int *i, double *x, int *P) {
  int used = 0;
  for (int j = 0; j < n; j++) {
    P[j] = used;
    for (size_t k = p[j]; k < p[j + 1]; k++)
      if (used > P[j] && i[used - 1] == i[k])
        x[used - 1] += x[k];
      else {
        i[used] = i[k];
        x[used++] = x[k];
      }
  }
  P[n] = used;
}

static dls_status assemble_sparse(const assembly *a, dls_fe_matrix *out, dls_error *error) {
  const size_t n = (size_t)a->n;
  size_t *p = dlsi_alloc(2 * n + 1, sizeof *p);
  if (!p) return dlsi_no_memory(error);
  const size_t entries = assemble_count(a, p);
  dls_status status = DLS_OK;
  for (size_t j = 0; !status && j < n; j++)
    if (p[j + 1] == p[j])
      status = dlsi_fail(error, DLS_E_ARGUMENT, "unknown", (long long)j, (double)j,
                         "no unknown of an element has the number %zu", j);
  if (!status && entries > INT_MAX)
    status = dlsi_fail(error, DLS_E_SIZE, "mesh", -1, (double)entries, "%zu entries are too many",
                       entries);
  /* x, i and P of the result in one piece, the values first */
  char *memory =
      status ? NULL
             : dlsi_alloc(entries * (sizeof(double) + sizeof(int)) + (n + 1) * sizeof(int), 1);
  double *x = status ? NULL : dlsi_alloc(entries, sizeof *x);
  int *i = status ? NULL : dlsi_alloc(entries, sizeof *i);
  if (!status && (!memory || !x || !i)) status = dlsi_no_memory(error);
  if (!status) {
    double *tx = (double *)(void *)memory;
    int *ti = (int *)(void *)(tx + entries), *P = ti + entries;
    assemble_fill(a, p, i, x);
    assemble_rewind(a->n, p);
    assemble_sort(a->n, p, i, x, p + n + 1, ti, tx);
    assemble_sum(a->n, p, ti, tx, P);
    *out = (dls_fe_matrix){{a->n, a->n, P, ti, tx}, memory};
  } else
    free(memory);
  free(x);
  free(i);
  free(p);
  return status;
}

void dls_fe_matrix_free(dls_fe_matrix *matrix) {
  if (!matrix) return;
  free(matrix->memory);
  *matrix = (dls_fe_matrix){0};
}

dls_status dls_fe_sparse_stiffness(const dls_fe_mesh *mesh, double E, double nu, const int *unknown,
                                   int unknowns, dls_fe_matrix *K, dls_error *error) {
  DLSI_DOOR;
  assembly a = {.mesh = mesh, .unknown = unknown, .D = assemble_moduli(E, nu)};
  dls_status status = assemble_check(mesh, E, nu, error);
  if (!status) status = assemble_number(mesh, unknown, unknowns, &a.n, error);
  if (!status && !K) status = dlsi_is_null(error, "K");
  if (!status) status = assemble_sparse(&a, K, error);
  return dlsi_at(__func__, status, error);
}

static dls_status mass_check(const dls_fe_mesh *mesh, double rho, dls_fe_mass_kind kind,
                             const dls_fe_matrix *M, dls_error *error) {
  dls_status status = assemble_check_mesh(mesh, error);
  const dlsi_setting density[] = {{"rho", rho, 0, DBL_MAX, 1}};
  if (!status) status = dlsi_check_each(1, density, error);
  if (status) return status;
  if (kind != DLS_FE_CONSISTENT && kind != DLS_FE_LUMPED)
    return dlsi_fail(error, DLS_E_ARGUMENT, "kind", -1, kind, "is %d, no kind of mass", (int)kind);
  return M ? DLS_OK : dlsi_is_null(error, "M");
}

dls_status dls_fe_mass(const dls_fe_mesh *mesh, double rho, dls_fe_mass_kind kind,
                       const int *unknown, int unknowns, dls_fe_matrix *M, dls_error *error) {
  DLSI_DOOR;
  assembly a = {
      .mesh = mesh, .unknown = unknown, .mass = 1, .lumped = kind == DLS_FE_LUMPED, .rho = rho};
  dls_status status = mass_check(mesh, rho, kind, M, error);
  if (!status) status = assemble_number(mesh, unknown, unknowns, &a.n, error);
  if (!status) status = assemble_sparse(&a, M, error);
  return dlsi_at(__func__, status, error);
}

/* ---- derivatives ----------------------------------------------------------------------------- */

/* Returns f^T k displacement of all elements, with moduli D. */
static double assemble_form(const dls_fe_mesh *mesh, dlsi_lame D, const double *f,
                            const double *displacement) {
  const assembly a = {.mesh = mesh, .D = D};
  double sum = 0;
  for (int e = 0; e < dlsi_fe_elements(mesh); e++) {
    int at[most_unknowns];
    double k[most_unknowns * most_unknowns];
    const int count = assemble_rows(&a, e, at);
    assemble_element(&a, e, k);
    for (int j = 0; j < count; j++)
      for (int i = 0; i < count; i++)
        sum += f[at[i]] * k[i + count * j] * displacement[at[j]];
  }
  return sum;
}

/* The moduli are linear in E, and d l / d nu = E (1 + 2 nu^2) / ((1 + nu) (1 - 2 nu))^2,
 * d G / d nu = -E / (2 (1 + nu)^2). */
dls_status dls_fe_material_gradient(const dls_fe_mesh *mesh, double E, double nu, const double *f,
                                    const double *displacement, double *of_E, double *of_nu,
                                    dls_error *error) {
  DLSI_DOOR;
  dls_status status = assemble_check(mesh, E, nu, error);
  const size_t all = status ? 0 : 2 * (size_t)mesh->nodes;
  if (!status) status = dlsi_check_vector("f", f, all, error);
  if (!status) status = dlsi_check_vector("displacement", displacement, all, error);
  if (!status && !of_E) status = dlsi_is_null(error, "of_E");
  if (!status && !of_nu) status = dlsi_is_null(error, "of_nu");
  if (status) return dlsi_at(__func__, status, error);
  const double a = 1 + nu, b = 1 - 2 * nu;
  const dlsi_lame of = {.l = E * (1 + 2 * nu * nu) / (a * a * b * b), .G = -E / (2 * a * a)};
  *of_E = -assemble_form(mesh, assemble_moduli(1, nu), f, displacement);
  *of_nu = -assemble_form(mesh, of, f, displacement);
  return DLS_OK;
}

/* ---- edge loads, stress ---------------------------------------------------------------------- */

/* Checks the arguments of dls_fe_edge_load, which is called edge by edge: checks only the two
 * nodes, not the whole mesh. *half := half of the edge's length. */
static dls_status edge_check(const dls_fe_mesh *mesh, int a, int b, double tx, double ty,
                             const double *f, double *half, dls_error *error) {
  if (!mesh) return dlsi_is_null(error, "mesh");
  if (!mesh->xy) return dlsi_is_null(error, "xy");
  if (a < 0 || a >= mesh->nodes)
    return dlsi_fail(error, DLS_E_ARGUMENT, "a", -1, a, "is %d, no node of the mesh", a);
  if (b < 0 || b >= mesh->nodes || b == a)
    return dlsi_fail(error, DLS_E_ARGUMENT, "b", -1, b, "is %d, no other node", b);
  if (!isfinite(tx)) return dlsi_fail(error, DLS_E_NOT_FINITE, "tx", -1, tx, "is %g", tx);
  if (!isfinite(ty)) return dlsi_fail(error, DLS_E_NOT_FINITE, "ty", -1, ty, "is %g", ty);
  if (!f) return dlsi_is_null(error, "f");
  const double *A = mesh->xy + 2 * (size_t)a, *B = mesh->xy + 2 * (size_t)b;
  *half = hypot(B[0] - A[0], B[1] - A[1]) / 2;
  if (isfinite(*half)) return DLS_OK;
  return dlsi_fail(error, DLS_E_NOT_FINITE, "xy", 2LL * (isfinite(A[0] + A[1]) ? b : a), *half,
                   "edge of no finite length");
}

dls_status dls_fe_edge_load(const dls_fe_mesh *mesh, int a, int b, double tx, double ty, double *f,
                            dls_error *error) {
  DLSI_DOOR;
  double half = 0;
  const dls_status status = edge_check(mesh, a, b, tx, ty, f, &half, error);
  if (status) return dlsi_at(__func__, status, error);
  f[2 * (size_t)a] += half * tx;
  f[2 * (size_t)a + 1] += half * ty;
  f[2 * (size_t)b] += half * tx;
  f[2 * (size_t)b + 1] += half * ty;
  return DLS_OK;
}

dls_status dls_fe_stress(const dls_fe_mesh *mesh, double E, double nu, const double *displacement,
                         double *stress, dls_error *error) {
  DLSI_DOOR;
  dls_status status = assemble_check(mesh, E, nu, error);
  if (!status)
    status = dlsi_check_vector("displacement", displacement, 2 * (size_t)mesh->nodes, error);
  if (!status && !stress) status = dlsi_is_null(error, "stress");
  if (status) return dlsi_at(__func__, status, error);
  const dlsi_lame D = assemble_moduli(E, nu);
  for (int e = 0; e < dlsi_fe_elements(mesh); e++)
    (dlsi_fe_corners(mesh) == 3 ? dlsi_t3_stress : dlsi_quad_stress)(mesh, e, &D, displacement,
                                                                     stress + 3 * (size_t)e);
  return DLS_OK;
}
