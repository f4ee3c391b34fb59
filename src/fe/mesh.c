/* mesh.c: makes blocks of triangles and of four-node elements, and checks a mesh. */
#include <float.h>
#include <limits.h>
#include <stdlib.h>

#include "fe_internal.h"

/* Places node i + j (nx + 1) at (i lx / nx, j ly / ny). xy: out, 2 (nx + 1) (ny + 1). */
static void block_grid(double lx, double ly, int nx, int ny, double *xy) {
  for (int j = 0; j <= ny; j++)
    for (int i = 0; i <= nx; i++) {
      *xy++ = lx * ((double)i / nx); /* the last one is lx exactly */
      *xy++ = ly * ((double)j / ny);
    }
}

/* Checks the arguments of dls_fe_mesh_block and dls_fe_mesh_quads. 6 nx ny node numbers
 * and 2 (nx+1)(ny+1) <= 8 nx ny unknowns are counted in int. */
static dls_status block_check(const dls_fe_mesh *mesh, double lx, double ly, int nx, int ny,
                              dls_error *error) {
  if (!mesh) return dlsi_is_null(error, "mesh");
  const dlsi_setting lengths[] = {{"lx", lx, 0, DBL_MAX, 1}, {"ly", ly, 0, DBL_MAX, 1}};
  const dls_status status = dlsi_check_each(2, lengths, error);
  if (status) return status;
  if (nx < 1) return dlsi_fail(error, DLS_E_SIZE, "nx", -1, nx, "is %d, must be at least 1", nx);
  if (ny < 1) return dlsi_fail(error, DLS_E_SIZE, "ny", -1, ny, "is %d, must be at least 1", ny);
  if (ny <= INT_MAX / 8 / nx) return DLS_OK;
  return dlsi_fail(error, DLS_E_SIZE, "ny", -1, ny, "%d x %d is too large", nx, ny);
}

/* Makes the block of elements of `corners` (3 or 4) nodes. */
static dls_status block_make(dls_fe_mesh *mesh, double lx, double ly, int nx, int ny, int corners,
                             dls_error *error) {
  const dls_status status = block_check(mesh, lx, ly, nx, ny, error);
  if (status) return status;
  const int nodes = (nx + 1) * (ny + 1), most = corners == 3 ? 6 : 4; /* numbers per rectangle */
  double *xy = dlsi_alloc(2 * (size_t)nodes, sizeof *xy);
  int *node = dlsi_alloc((size_t)most * (size_t)nx * (size_t)ny, sizeof *node);
  if (!xy || !node) {
    free(xy);
    free(node);
    return dlsi_no_memory(error);
  }
  block_grid(lx, ly, nx, ny, xy);
  int *corner = node;
  for (int j = 0; j < ny; j++)
    for (int i = 0; i < nx; i++) {
      const int a = i + j * (nx + 1), b = a + 1, d = a + nx + 1, c = d + 1;
      const int two[6] = {a, b, d, b, c, d}, one[4] = {a, b, c, d}; /* d - c */
      for (int k = 0; k < most; k++)                                /* | \ | */
        *corner++ = corners == 3 ? two[k] : one[k];                 /* a - b */
    }
  *mesh = corners == 3 ? (dls_fe_mesh){nodes, xy, 2 * nx * ny, node, 0, NULL}
                       : (dls_fe_mesh){nodes, xy, 0, NULL, nx * ny, node};
  return DLS_OK;
}

dls_status dls_fe_mesh_block(dls_fe_mesh *mesh, double lx, double ly, int nx, int ny,
                             dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, block_make(mesh, lx, ly, nx, ny, 3, error), error);
}

dls_status dls_fe_mesh_quads(dls_fe_mesh *mesh, double lx, double ly, int nx, int ny,
                             dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, block_make(mesh, lx, ly, nx, ny, 4, error), error);
}

void dls_fe_mesh_free(dls_fe_mesh *mesh) {
  if (!mesh) return;
  free(mesh->xy);
  free(mesh->node);
  free(mesh->quad);
  *mesh = (dls_fe_mesh){0};
}

dls_status dlsi_fe_check_mesh(const dls_fe_mesh *mesh, dls_error *error) {
  if (!mesh) return dlsi_is_null(error, "mesh");
  if (mesh->nodes < 1 || mesh->nodes > INT_MAX / 2)
    return dlsi_fail(error, DLS_E_SIZE, "nodes", -1, mesh->nodes, "is %d", mesh->nodes);
  const int quads = mesh->quads != 0 && mesh->triangles == 0;
  const char *count_name = quads ? "quads" : "triangles", *list_name = quads ? "quad" : "node";
  const int count = dlsi_fe_elements(mesh), corners = dlsi_fe_corners(mesh);
  if (count < 1 || count > INT_MAX / corners)
    return dlsi_fail(error, DLS_E_SIZE, count_name, -1, count, "is %d", count);
  if (!quads && mesh->quads != 0)
    return dlsi_fail(error, DLS_E_SIZE, "quads", -1, mesh->quads,
                     "is %d in a mesh of triangles, must be 0", mesh->quads);
  const dls_status status = dlsi_check_vector("xy", mesh->xy, 2 * (size_t)mesh->nodes, error);
  if (status) return status;
  const int *node = quads ? mesh->quad : mesh->node;
  if (!node) return dlsi_is_null(error, list_name);
  for (int k = 0; k < corners * count; k++)
    if (node[k] < 0 || node[k] >= mesh->nodes)
      return dlsi_fail(error, DLS_E_ARGUMENT, list_name, k, node[k], "is %d, outside of 0 .. %d",
                       node[k], mesh->nodes - 1);
  return DLS_OK;
}
