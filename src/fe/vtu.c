/* vtu.c: mesh and results as an unstructured grid of VTK XML, ascii. */
#include "fe_internal.h"
#include "file.h"

enum { vtk_triangle = 5 };

/* one <DataArray> of points in the plane, or vectors there, as VTK wants them: in space */
static void write_plane(FILE *file, const char *name, const double *x, int nodes) {
  (void)fprintf(file,
                "<DataArray type=\"Float64\" Name=\"%s\" NumberOfComponents=\"3\" "
                "format=\"ascii\">\n",
                name);
  for (int i = 0; i < nodes; i++, x += 2)
    (void)fprintf(file, "%.17g %.17g 0\n", x[0], x[1]);
  (void)fprintf(file, "</DataArray>\n");
}

static void write_grid(FILE *file, const dls_fe_mesh *mesh, const double *displacement,
                       const double *reaction, const double *stress) {
  (void)fprintf(file,
                "<?xml version=\"1.0\"?>\n"
                "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
                "<UnstructuredGrid>\n"
                "<Piece NumberOfPoints=\"%d\" NumberOfCells=\"%d\">\n"
                "<PointData>\n",
                mesh->nodes, mesh->triangles);
  if (displacement) write_plane(file, "displacement", displacement, mesh->nodes);
  if (reaction) write_plane(file, "reaction", reaction, mesh->nodes);
  (void)fprintf(file, "</PointData>\n<CellData>\n");
  if (stress) {
    (void)fprintf(file, "<DataArray type=\"Float64\" Name=\"stress\" NumberOfComponents=\"3\" "
                        "ComponentName0=\"xx\" ComponentName1=\"yy\" ComponentName2=\"xy\" "
                        "format=\"ascii\">\n");
    for (int e = 0; e < mesh->triangles; e++, stress += 3)
      (void)fprintf(file, "%.17g %.17g %.17g\n", stress[0], stress[1], stress[2]);
    (void)fprintf(file, "</DataArray>\n");
  }
  (void)fprintf(file, "</CellData>\n<Points>\n");
  write_plane(file, "points", mesh->xy, mesh->nodes);
  (void)fprintf(file, "</Points>\n<Cells>\n"
                      "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">\n");
  const int *node = mesh->node;
  for (int e = 0; e < mesh->triangles; e++, node += 3)
    (void)fprintf(file, "%d %d %d\n", node[0], node[1], node[2]);
  (void)fprintf(file, "</DataArray>\n"
                      "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">\n");
  for (int e = 0; e < mesh->triangles; e++)
    (void)fprintf(file, "%d\n", 3 * (e + 1));
  (void)fprintf(file, "</DataArray>\n"
                      "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n");
  for (int e = 0; e < mesh->triangles; e++)
    (void)fprintf(file, "%d\n", vtk_triangle);
  (void)fprintf(file, "</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
}

dls_status dls_fe_write_vtu(const char *path, const dls_fe_mesh *mesh, const double *displacement,
                            const double *reaction, const double *stress, dls_error *error) {
  if (!path) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "path", -1, 0, "is NULL");
  dls_status status = dlsi_fe_check_mesh(__func__, mesh, error);
  if (status) return status;
  const size_t n = 2 * (size_t)mesh->nodes, cells = 3 * (size_t)mesh->triangles;
  if (displacement) status = dlsi_fe_check_vector(__func__, "displacement", displacement, n, error);
  if (!status && reaction) status = dlsi_fe_check_vector(__func__, "reaction", reaction, n, error);
  if (!status && stress) status = dlsi_fe_check_vector(__func__, "stress", stress, cells, error);
  if (status) return status;

  FILE *file = fopen(path, "w");
  if (!file)
    return dlsi_fail(error, DLS_E_FILE, __func__, "path", -1, 0, "%.60s: cannot be opened", path);
  write_grid(file, mesh, displacement, reaction, stress);
  return dlsi_file_finish(__func__, path, file, error);
}
