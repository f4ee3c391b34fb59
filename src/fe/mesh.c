/* mesh.c: makes the block of three-node triangles, and checks a mesh. */
#include <float.h>
#include <limits.h>
#include <stdlib.h>

#include "fe_internal.h"

void dlsi_fe_grid(double lx, double ly, int nx, int ny, double *xy) {
  for (int j = 0; j <= ny; j++)
    for (int i = 0; i <= nx; i++) {
      *xy++ = lx * ((double)i / nx); /* the last one is lx exactly */
      *xy++ = ly * ((double)j / ny);
    }
}

/* Checks the arguments of dls_fe_mesh_block. 6 nx ny node numbers and 2 (nx+1)(ny+1) <= 8 nx ny
 * unknowns are counted in int. */
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

dls_status dls_fe_mesh_block(dls_fe_mesh *mesh, double lx, double ly, int nx, int ny,
                             dls_error *error) {
  const dls_status status = block_check(mesh, lx, ly, nx, ny, error);
  if (status) return dlsi_at(__func__, status, error);
  const int nodes = (nx + 1) * (ny + 1), triangles = 2 * nx * ny;
  double *xy = dlsi_alloc(2 * (size_t)nodes, sizeof *xy);
  int *node = dlsi_alloc(3 * (size_t)triangles, sizeof *node);
  if (!xy || !node) {
    free(xy);
    free(node);
    return dlsi_at(__func__, dlsi_no_memory(error), error);
  }
  dlsi_fe_grid(lx, ly, nx, ny, xy);
  int *corner = node;
  for (int j = 0; j < ny; j++)
    for (int i = 0; i < nx; i++) {
      const int a = i + j * (nx + 1), b = a + 1, d = a + nx + 1, c = d + 1;
      const int two[6] = {a, b, d, b, c, d}; /* d - c */
      for (int k = 0; k < 6; k++)            /* | \ | */
        *corner++ = two[k];                  /* a - b */
    }
  *mesh = (dls_fe_mesh){nodes, xy, triangles, node};
  return DLS_OK;
}

void dls_fe_mesh_free(dls_fe_mesh *mesh) {
  if (!mesh) return;
  free(mesh->xy);
  free(mesh->node);
  *mesh = (dls_fe_mesh){0};
}

dls_status dlsi_fe_check_mesh(const dls_fe_mesh *mesh, dls_error *error) {
  if (!mesh) return dlsi_is_null(error, "mesh");
  if (mesh->nodes < 1 || mesh->nodes > INT_MAX / 2)
    return dlsi_fail(error, DLS_E_SIZE, "nodes", -1, mesh->nodes, "is %d", mesh->nodes);
  if (mesh->triangles < 1 || mesh->triangles > INT_MAX / 3)
    return dlsi_fail(error, DLS_E_SIZE, "triangles", -1, mesh->triangles, "is %d", mesh->triangles);
  const dls_status status = dlsi_check_vector("xy", mesh->xy, 2 * (size_t)mesh->nodes, error);
  if (status) return status;
  if (!mesh->node) return dlsi_is_null(error, "node");
  for (int k = 0; k < 3 * mesh->triangles; k++)
    if (mesh->node[k] < 0 || mesh->node[k] >= mesh->nodes)
      return dlsi_fail(error, DLS_E_ARGUMENT, "node", k, mesh->node[k], "is %d, outside of 0 .. %d",
                       mesh->node[k], mesh->nodes - 1);
  return DLS_OK;
}
