/* vtu.c: mesh and results as an unstructured grid of VTK XML, ascii. */
#include "fe_internal.h"
#include "files/file.h"

enum { vtk_triangle = 5, vtk_quad = 9 };

void dlsi_vtu_begin(FILE *file, int nodes, int cells) {
  (void)fprintf(file,
                "<?xml version=\"1.0\"?>\n"
                "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
                "<UnstructuredGrid>\n"
                "<Piece NumberOfPoints=\"%d\" NumberOfCells=\"%d\">\n"
                "<PointData>\n",
                nodes, cells);
}

void dlsi_vtu_plane(FILE *file, const char *name, const double *x, int nodes, int digits) {
  (void)fprintf(file,
                "<DataArray type=\"Float64\" Name=\"%s\" NumberOfComponents=\"3\" "
                "format=\"ascii\">\n",
                name);
  for (int i = 0; i < nodes; i++, x += 2)
    (void)fprintf(file, "%.*g %.*g 0\n", digits, x[0], digits, x[1]);
  (void)fprintf(file, "</DataArray>\n");
}

void dlsi_vtu_end(FILE *file, const double *xy, int nodes, const int *node, int corners, int cells,
                  int digits) {
  (void)fprintf(file, "</CellData>\n<Points>\n");
  dlsi_vtu_plane(file, "points", xy, nodes, digits);
  (void)fprintf(file, "</Points>\n<Cells>\n"
                      "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">\n");
  for (int k = 0; k < corners * cells; k++)
    (void)fprintf(file, "%d%c", node[k], (k + 1) % corners ? ' ' : '\n');
  (void)fprintf(file, "</DataArray>\n"
                      "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">\n");
  for (int e = 1; e <= cells; e++)
    (void)fprintf(file, "%d\n", corners * e);
  (void)fprintf(file, "</DataArray>\n"
                      "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n");
  for (int e = 0; e < cells; e++)
    (void)fprintf(file, "%d\n", corners == 3 ? vtk_triangle : vtk_quad);
  (void)fprintf(file, "</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
}

static void write_grid(FILE *file, const dls_fe_mesh *mesh, const double *displacement,
                       const double *reaction, const double *stress) {
  enum { digits = 17 };
  dlsi_vtu_begin(file, mesh->nodes, mesh->triangles);
  if (displacement) dlsi_vtu_plane(file, "displacement", displacement, mesh->nodes, digits);
  if (reaction) dlsi_vtu_plane(file, "reaction", reaction, mesh->nodes, digits);
  (void)fprintf(file, "</PointData>\n<CellData>\n");
  if (stress) {
    (void)fprintf(file, "<DataArray type=\"Float64\" Name=\"stress\" NumberOfComponents=\"3\" "
                        "ComponentName0=\"xx\" ComponentName1=\"yy\" ComponentName2=\"xy\" "
                        "format=\"ascii\">\n");
    for (int e = 0; e < mesh->triangles; e++, stress += 3)
      (void)fprintf(file, "%.17g %.17g %.17g\n", stress[0], stress[1], stress[2]);
    (void)fprintf(file, "</DataArray>\n");
  }
  dlsi_vtu_end(file, mesh->xy, mesh->nodes, mesh->node, 3, mesh->triangles, digits);
}

dls_status dls_fe_write_vtu(const char *path, const dls_fe_mesh *mesh, const double *displacement,
                            const double *reaction, const double *stress, dls_error *error) {
  if (!path) return dlsi_at(__func__, dlsi_is_null(error, "path"), error);
  dls_status status = dlsi_fe_check_mesh(mesh, error);
  if (status) return dlsi_at(__func__, status, error);
  const size_t n = 2 * (size_t)mesh->nodes, cells = 3 * (size_t)mesh->triangles;
  if (displacement) status = dlsi_fe_check_vector("displacement", displacement, n, error);
  if (!status && reaction) status = dlsi_fe_check_vector("reaction", reaction, n, error);
  if (!status && stress) status = dlsi_fe_check_vector("stress", stress, cells, error);
  if (status) return dlsi_at(__func__, status, error);

  FILE *file = fopen(path, "w");
  if (!file)
    return dlsi_at(__func__,
                   dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "%.60s: cannot be opened", path),
                   error);
  write_grid(file, mesh, displacement, reaction, stress);
  return dlsi_at(__func__, dlsi_file_finish(path, file, error), error);
}
