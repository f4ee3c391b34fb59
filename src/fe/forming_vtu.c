/* forming_vtu.c: a forming scene as an unstructured grid of VTK XML, ascii. */
#include "fe_internal.h"
#include "files/file.h"
#include "forming_internal.h"

enum { digits = 9 };

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
  dlsi_vtu_begin(file, mesh->nodes, mesh->quads);
  dlsi_vtu_plane(file, "displacement", d->displacement, mesh->nodes, digits);
  dlsi_vtu_plane(file, "reaction", d->reaction, mesh->nodes, digits);
  (void)fprintf(file, "</PointData>\n<CellData>\n");
  write_means(file,
              "Name=\"stress\" NumberOfComponents=\"4\" ComponentName0=\"11\" "
              "ComponentName1=\"22\" ComponentName2=\"33\" ComponentName3=\"12\"",
              d->stress, 4, mesh->quads);
  write_means(file, "Name=\"plastic_strain\" NumberOfComponents=\"1\"", d->plastic_strain, 1,
              mesh->quads);
  dlsi_vtu_end(file, mesh->xy, mesh->nodes, mesh->node, 4, mesh->quads, digits);
}

dls_status dls_forming_write_vtu(const dls_forming *forming, const char *path, dls_error *error) {
  if (!forming) return dlsi_at(__func__, dlsi_is_null(error, "forming"), error);
  if (!path) return dlsi_at(__func__, dlsi_is_null(error, "path"), error);
  FILE *file = fopen(path, "w");
  if (!file)
    return dlsi_at(__func__,
                   dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "%.60s: cannot be opened", path),
                   error);
  write_grid(file, &forming->data);
  return dlsi_at(__func__, dlsi_file_finish(path, file, error), error);
}
