/* forming_vtu.c: writes a forming scene and its tools as unstructured grids of VTK XML, ascii. */
#include <math.h>
#include <stdlib.h>

#include "fe_internal.h"
#include "forming_internal.h"

static dls_status forming_write_grid(const dls_forming_data *d, const dls_fe_fields *fields,
                                     const dlsi_cells *cells, const char *path, dls_error *error) {
  const dls_forming_mesh *mesh = d->mesh;
  dlsi_output out;
  const dls_status status = dlsi_vtu_begin(&out, path, mesh->nodes, cells->cells, error);
  if (status) return status;
  FILE *file = out.file;
  dlsi_vtu_plane(file, "displacement", d->displacement, mesh->nodes);
  dlsi_vtu_plane(file, "reaction", d->reaction, mesh->nodes);
  dlsi_vtu_contact(file, fields, mesh->nodes);
  dlsi_vtu_cells(file);
  dlsi_vtu_tensor(file, d->stress, 4, 0, 4, cells);
  dlsi_vtu_means(file, "Name=\"plastic_strain\" NumberOfComponents=\"1\"", d->plastic_strain, 1, 4,
                 cells);
  return dlsi_vtu_end(&out, mesh->xy, mesh->nodes, cells, error);
}

/* Lists the quads; a quad with a flat corner becomes the two triangles that meet there.
 *   node: out, 6 * quads; end, from: out, 2 * quads; returns the number of cells */
static int forming_list_cells(const dls_forming *f, int *node, int *end, int *from) {
  int cells = 0, corners = 0;
  for (int e = 0; e < f->mesh.quads; e++) {
    const int *quad = f->mesh.node + 4 * e, flat = dlsi_forming_flat_corner(f, e);
    for (int part = 0; part < (flat < 0 ? 1 : 2); part++) {
      for (int k = 0; k < (flat < 0 ? 4 : 3); k++)
        node[corners++] = flat < 0 ? quad[k] : quad[(flat + (k > 0 ? k + part : 0)) % 4];
      from[cells] = e;
      end[cells++] = corners;
    }
  }
  return cells;
}

/* Fills the fields of the candidates; state, gap, slip: nc each. A reaction on its cone slips. */
static dls_fe_fields forming_contact(const dls_forming *f, dls_contact_state *state, double *gap,
                                     double *slip) {
  static const double border = 1e-6; /* of the cone: above the tolerance of a step */
  const dls_forming_data *d = &f->data;
  for (int c = 0; c < d->candidates; c++) {
    const double *r = d->r + 2 * c;
    state[c] = r[0] <= 0                                      ? DLS_FREE
               : fabs(r[1]) >= (1 - border) * f->mu[c] * r[0] ? DLS_SLIP
                                                              : DLS_STICK;
    gap[c] = d->u[2 * c];
    slip[c] = d->u[2 * c + 1];
  }
  return (dls_fe_fields){.candidates = d->candidates,
                         .node = d->candidate_node,
                         .state = state,
                         .gap = gap,
                         .slip = slip};
}

static dls_status forming_write_body(const dls_forming *f, const char *path, dls_error *error) {
  const size_t quads = (size_t)f->mesh.quads, nc = (size_t)f->nc;
  int *room = dlsi_alloc(10 * quads, sizeof *room);
  double *gap = dlsi_alloc(2 * nc, sizeof *gap);
  dls_contact_state *state = dlsi_alloc(nc, sizeof *state);
  dls_status status = room && gap && state ? DLS_OK : dlsi_no_memory(error);
  if (!status) {
    int *node = room, *end = room + 6 * quads, *from = room + 8 * quads;
    const dlsi_cells cells = {
        .cells = forming_list_cells(f, node, end, from), .node = node, .end = end, .from = from};
    const dls_fe_fields fields = forming_contact(f, state, gap, gap + nc);
    status = forming_write_grid(&f->data, &fields, &cells, path, error);
  }
  free(room);
  free(gap);
  free(state);
  return status;
}

static dls_status forming_write_outlines(const dls_forming_data *d, const char *path,
                                         dls_error *error) {
  enum { most = dlsi_most_tools * dlsi_most_outline };
  double xy[2 * most], number[dlsi_most_tools], force[2 * dlsi_most_tools];
  int node[most], end[dlsi_most_tools], cells = 0, nodes = 0;
  for (int k = 0; k < d->tools; k++) {
    const dls_forming_tool *tool = &d->tool[k];
    if (!tool->points) continue;
    for (int i = 0; i < tool->points; i++, nodes++)
      for (int j = 0; j < 2; j++) {
        xy[2 * nodes + j] = tool->outline[2 * i + j];
        node[nodes] = nodes;
      }
    number[cells] = k;
    for (int j = 0; j < 2; j++)
      force[2 * cells + j] = tool->force[j];
    end[cells++] = nodes;
  }
  const dlsi_cells outlines = {.cells = cells, .node = node, .end = end};
  dlsi_output out;
  const dls_status status = dlsi_vtu_begin(&out, path, nodes, cells, error);
  if (status) return status;
  FILE *file = out.file;
  dlsi_vtu_cells(file);
  dlsi_vtu_means(file, "Name=\"tool\" NumberOfComponents=\"1\"", number, 1, 1, &outlines);
  dlsi_vtu_means(file,
                 "Name=\"force\" NumberOfComponents=\"2\" ComponentName0=\"x\" "
                 "ComponentName1=\"y\"",
                 force, 2, 1, &outlines);
  return dlsi_vtu_end(&out, xy, nodes, &outlines, error);
}

dls_status dls_forming_write_vtu(const dls_forming *forming, const char *path, dls_error *error) {
  DLSI_DOOR;
  const dls_status status = !forming ? dlsi_is_null(error, "forming")
                            : !path  ? dlsi_is_null(error, "path")
                                     : forming_write_body(forming, path, error);
  return dlsi_at(__func__, status, error);
}

dls_status dls_forming_write_tools(const dls_forming *forming, const char *path, dls_error *error) {
  DLSI_DOOR;
  const dls_status status = !forming ? dlsi_is_null(error, "forming")
                            : !path  ? dlsi_is_null(error, "path")
                                     : forming_write_outlines(&forming->data, path, error);
  return dlsi_at(__func__, status, error);
}
