/* forming_vtu.c: a forming scene as an unstructured grid of VTK XML, ascii. */
#include "file.h"
#include "forming_internal.h"

enum { vtk_quad = 9 };

/* one <DataArray> of vectors in the plane, or points, as VTK wants them: in space */
static void write_plane(FILE *file, const char *name, const double *x, int nodes) {
  (void)fprintf(file,
                "<DataArray type=\"Float64\" Name=\"%s\" NumberOfComponents=\"3\" "
                "format=\"ascii\">\n",
                name);
  for (int i = 0; i < nodes; i++, x += 2)
    (void)fprintf(file, "%.9g %.9g 0\n", x[0], x[1]);
  (void)fprintf(file, "</DataArray>\n");
}

/* means over the four points of each element */
static void write_means(FILE *file, const char *head, const double *x, int components, int quads) {
  (void)fprintf(file, "<DataArray type=\"Float64\" %s format=\"ascii\">\n", head);
  for (int e = 0; e < quads; e++, x += 4 * components)
    for (int i = 0; i < components; i++)
      (void)fprintf(file, "%.9g%c",
                    (x[i] + x[i + components] + x[i + 2 * components] + x[i + 3 * components]) / 4,
                    i + 1 < components ? ' ' : '\n');
  (void)fprintf(file, "</DataArray>\n");
}

static void write_grid(FILE *file, const dls_forming_data *d) {
  const dls_forming_mesh *mesh = d->mesh;
  (void)fprintf(file,
                "<?xml version=\"1.0\"?>\n"
                "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
                "<UnstructuredGrid>\n"
                "<Piece NumberOfPoints=\"%d\" NumberOfCells=\"%d\">\n"
                "<PointData>\n",
                mesh->nodes, mesh->quads);
  write_plane(file, "displacement", d->displacement, mesh->nodes);
  write_plane(file, "reaction", d->reaction, mesh->nodes);
  (void)fprintf(file, "</PointData>\n<CellData>\n");
  write_means(file,
              "Name=\"stress\" NumberOfComponents=\"4\" ComponentName0=\"11\" "
              "ComponentName1=\"22\" ComponentName2=\"33\" ComponentName3=\"12\"",
              d->stress, 4, mesh->quads);
  write_means(file, "Name=\"plastic_strain\" NumberOfComponents=\"1\"", d->plastic_strain, 1,
              mesh->quads);
  (void)fprintf(file, "</CellData>\n<Points>\n");
  write_plane(file, "points", mesh->xy, mesh->nodes);
  (void)fprintf(file, "</Points>\n<Cells>\n"
                      "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">\n");
  for (const int *node = mesh->node; node < mesh->node + 4 * mesh->quads; node += 4)
    (void)fprintf(file, "%d %d %d %d\n", node[0], node[1], node[2], node[3]);
  (void)fprintf(file, "</DataArray>\n"
                      "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">\n");
  for (int e = 1; e <= mesh->quads; e++)
    (void)fprintf(file, "%d\n", 4 * e);
  (void)fprintf(file, "</DataArray>\n"
                      "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n");
  for (int e = 0; e < mesh->quads; e++)
    (void)fprintf(file, "%d\n", vtk_quad);
  (void)fprintf(file, "</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
}

dls_status dls_forming_write_vtu(const dls_forming *forming, const char *path, dls_error *error) {
  if (!forming) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "forming", -1, 0, "is NULL");
  if (!path) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "path", -1, 0, "is NULL");
  FILE *file = fopen(path, "w");
  if (!file)
    return dlsi_fail(error, DLS_E_FILE, __func__, "path", -1, 0, "%.60s: cannot be opened", path);
  write_grid(file, &forming->data);
  return dlsi_file_finish(__func__, path, file, error);
}
