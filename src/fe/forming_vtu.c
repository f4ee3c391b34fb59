/* forming_vtu.c: writes a forming scene as an unstructured grid of VTK XML, ascii. */
#include "fe_internal.h"
#include "forming_internal.h"

enum { digits = 9 };

static dls_status forming_write_grid(const dls_forming_data *d, const char *path,
                                     dls_error *error) {
  const dls_forming_mesh *mesh = d->mesh;
  FILE *file = dlsi_vtu_begin(path, mesh->nodes, mesh->quads, error);
  if (!file) return DLS_E_FILE;
  dlsi_vtu_plane(file, "displacement", d->displacement, mesh->nodes, digits);
  dlsi_vtu_plane(file, "reaction", d->reaction, mesh->nodes, digits);
  dlsi_vtu_cells(file);
  dlsi_vtu_means(file,
                 "Name=\"stress\" NumberOfComponents=\"4\" ComponentName0=\"11\" "
                 "ComponentName1=\"22\" ComponentName2=\"33\" ComponentName3=\"12\"",
                 d->stress, 4, 4, mesh->quads, digits);
  dlsi_vtu_means(file, "Name=\"plastic_strain\" NumberOfComponents=\"1\"", d->plastic_strain, 1, 4,
                 mesh->quads, digits);
  return dlsi_vtu_end(path, file, mesh->xy, mesh->nodes, mesh->node, 4, mesh->quads, digits, error);
}

dls_status dls_forming_write_vtu(const dls_forming *forming, const char *path, dls_error *error) {
  const dls_status status = !forming ? dlsi_is_null(error, "forming")
                            : !path  ? dlsi_is_null(error, "path")
                                     : forming_write_grid(&forming->data, path, error);
  return dlsi_at(__func__, status, error);
}
