/* vtu.c: writes mesh and results as an unstructured grid of VTK XML, ascii; collections of such
 * files in time. */
#include <stdlib.h>
#include <string.h>

#include "base/utf8.h"
#include "fe_internal.h"

enum { vtk_triangle = 5, vtk_polygon = 7, vtk_quad = 9, digits = 17 };

dls_status dlsi_vtu_begin(dlsi_output *out, const char *path, int nodes, int cells,
                          dls_error *error) {
  const dls_status status = dlsi_output_open(out, path, error);
  if (status) return status;
  (void)fprintf(out->file,
                "<?xml version=\"1.0\"?>\n"
                "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
                "<UnstructuredGrid>\n"
                "<Piece NumberOfPoints=\"%d\" NumberOfCells=\"%d\">\n"
                "<PointData>\n",
                nodes, cells);
  return DLS_OK;
}

void dlsi_vtu_plane(FILE *file, const char *name, const double *x, int nodes) {
  (void)fprintf(file,
                "<DataArray type=\"Float64\" Name=\"%s\" NumberOfComponents=\"3\" "
                "format=\"ascii\">\n",
                name);
  for (int i = 0; i < nodes; i++, x += 2)
    (void)fprintf(file, "%.*g %.*g 0\n", digits, x[0], digits, x[1]);
  (void)fprintf(file, "</DataArray>\n");
}

void dlsi_vtu_cells(FILE *file) {
  (void)fprintf(file, "</PointData>\n<CellData>\n");
}

/* Returns where the corners of cell e end. */
static int vtu_end(const dlsi_cells *c, int e) {
  return c->end ? c->end[e] : c->corners * (e + 1);
}

void dlsi_vtu_means(FILE *file, const char *head, const double *x, int components, int points,
                    const dlsi_cells *cells) {
  (void)fprintf(file, "<DataArray type=\"Float64\" %s format=\"ascii\">\n", head);
  for (int e = 0; e < cells->cells; e++) {
    const double *own = x + points * components * (cells->from ? cells->from[e] : e);
    for (int i = 0; i < components; i++) {
      double sum = own[i];
      for (int k = 1; k < points; k++)
        sum += own[i + k * components];
      (void)fprintf(file, "%.*g%c", digits, sum / points, i + 1 < components ? ' ' : '\n');
    }
  }
  (void)fprintf(file, "</DataArray>\n");
}

void dlsi_vtu_contact(FILE *file, const dls_fe_fields *f, int nodes) {
  static const char *const names[] = {"contact", "gap", "slip"};
  for (int k = 0; k < 3; k++) {
    if (!(k == 0 ? (const void *)f->state : k == 1 ? f->gap : f->slip)) continue;
    (void)fprintf(file, "<DataArray type=\"%s\" Name=\"%s\" format=\"ascii\">\n",
                  k ? "Float64" : "Int32", names[k]);
    for (int i = 0; i < nodes; i++) {
      int c = 0;
      while (c < f->candidates && f->node[c] != i)
        c++;
      const int none = c == f->candidates;
      if (k == 0)
        (void)fprintf(file, "%d\n", none ? -1 : (int)f->state[c]);
      else
        (void)fprintf(file, "%.*g\n", digits, none ? 0 : k == 1 ? f->gap[c] : f->slip[c]);
    }
    (void)fprintf(file, "</DataArray>\n");
  }
}

void dlsi_vtu_tensor(FILE *file, const double *x, int components, double nu, int points,
                     const dlsi_cells *cells) {
  (void)fprintf(file, "<DataArray type=\"Float64\" Name=\"stress\" NumberOfComponents=\"9\" "
                      "format=\"ascii\">\n");
  for (int e = 0; e < cells->cells; e++) {
    const double *own = x + points * components * (cells->from ? cells->from[e] : e);
    double mean[4] = {0};
    for (int k = 0; k < points; k++)
      for (int i = 0; i < components; i++)
        mean[i] += own[i + k * components] / points;
    const double xy = mean[components - 1];
    const double zz = components == 4 ? mean[2] : nu * (mean[0] + mean[1]);
    (void)fprintf(file, "%.*g %.*g 0 %.*g %.*g 0 0 0 %.*g\n", digits, mean[0], digits, xy, digits,
                  xy, digits, mean[1], digits, zz);
  }
  (void)fprintf(file, "</DataArray>\n");
}

dls_status dlsi_vtu_end(dlsi_output *out, const double *xy, int nodes, const dlsi_cells *cells,
                        dls_error *error) {
  FILE *file = out->file;
  (void)fprintf(file, "</CellData>\n<Points>\n");
  dlsi_vtu_plane(file, "points", xy, nodes);
  (void)fprintf(file, "</Points>\n<Cells>\n"
                      "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">\n");
  for (int e = 0, k = 0; e < cells->cells; e++)
    for (const int end = vtu_end(cells, e); k < end; k++)
      (void)fprintf(file, "%d%c", cells->node[k], k + 1 < end ? ' ' : '\n');
  (void)fprintf(file, "</DataArray>\n"
                      "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">\n");
  for (int e = 0; e < cells->cells; e++)
    (void)fprintf(file, "%d\n", vtu_end(cells, e));
  (void)fprintf(file, "</DataArray>\n"
                      "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n");
  for (int e = 0; e < cells->cells; e++) {
    const int corners = vtu_end(cells, e) - (e > 0 ? vtu_end(cells, e - 1) : 0);
    (void)fprintf(file, "%d\n",
                  corners == 3   ? vtk_triangle
                  : corners == 4 ? vtk_quad
                                 : vtk_polygon);
  }
  (void)fprintf(file, "</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
  return dlsi_output_finish(out, error);
}

static dls_status fe_write_grid(const char *path, const dls_fe_mesh *mesh, const dls_fe_fields *f,
                                dls_error *error) {
  const double *displacement = f->displacement, *reaction = f->reaction, *stress = f->stress;
  const size_t nc = f->candidates > 0 ? (size_t)f->candidates : 0;
  if (!path) return dlsi_is_null(error, "path");
  dls_status status = dlsi_fe_check_mesh(mesh, error);
  if (status) return status;
  const size_t n = 2 * (size_t)mesh->nodes, cells = 3 * (size_t)dlsi_fe_elements(mesh);
  if (displacement) status = dlsi_check_vector("displacement", displacement, n, error);
  if (!status && reaction) status = dlsi_check_vector("reaction", reaction, n, error);
  if (!status && stress) status = dlsi_check_vector("stress", stress, cells, error);
  if (!status && f->gap) status = dlsi_check_vector("gap", f->gap, nc, error);
  if (!status && f->slip) status = dlsi_check_vector("slip", f->slip, nc, error);
  for (int c = 0; c < (int)nc && !status; c++)
    if (!f->node || f->node[c] < 0 || f->node[c] >= mesh->nodes)
      status = f->node ? dlsi_fail(error, DLS_E_ARGUMENT, "node", c, f->node[c],
                                   "is %d, outside of 0 to %d", f->node[c], mesh->nodes - 1)
                       : dlsi_is_null(error, "node");
  if (status) return status;

  const int elements = dlsi_fe_elements(mesh);
  const dlsi_cells all = {
      .cells = elements, .corners = dlsi_fe_corners(mesh), .node = dlsi_fe_corner(mesh, 0)};
  dlsi_output out;
  status = dlsi_vtu_begin(&out, path, mesh->nodes, elements, error);
  if (status) return status;
  FILE *file = out.file;
  if (displacement) dlsi_vtu_plane(file, "displacement", displacement, mesh->nodes);
  if (reaction) dlsi_vtu_plane(file, "reaction", reaction, mesh->nodes);
  dlsi_vtu_contact(file, f, mesh->nodes);
  dlsi_vtu_cells(file);
  if (stress) dlsi_vtu_tensor(file, stress, 3, f->nu, 1, &all);
  return dlsi_vtu_end(&out, mesh->xy, mesh->nodes, &all, error);
}

dls_status dls_fe_write_fields(const char *path, const dls_fe_mesh *mesh,
                               const dls_fe_fields *fields, dls_error *error) {
  DLSI_DOOR;
  const dls_status status =
      fields ? fe_write_grid(path, mesh, fields, error) : dlsi_is_null(error, "fields");
  return dlsi_at(__func__, status, error);
}

/* ---- collections ----------------------------------------------------------------------------- */

struct dls_fe_series {
  char *path, *rows;   /* rows: the text between head and end of the file */
  size_t length, room; /* of rows */
};

/* Writes the collection again, so that the file is whole after every row. */
static dls_status series_write(const dls_fe_series *s, dls_error *error) {
  dlsi_output out;
  const dls_status status = dlsi_output_open(&out, s->path, error);
  if (status) return status;
  (void)fprintf(out.file,
                "<?xml version=\"1.0\"?>\n"
                "<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n%s"
                "</Collection>\n</VTKFile>\n",
                s->length ? s->rows : "");
  return dlsi_output_finish(&out, error);
}

static dls_status series_open(dls_fe_series **out, const char *path, dls_error *error) {
  dls_fe_series *s = dlsi_alloc(1, sizeof *s);
  const size_t length = strlen(path) + 1;
  char *copy = dlsi_alloc(length, 1);
  dls_status status = s && copy ? DLS_OK : dlsi_no_memory(error);
  if (!status) {
    *s = (dls_fe_series){.path = copy};
    memcpy(copy, path, length);
    status = series_write(s, error);
  }
  if (status) {
    free(s);
    free(copy);
    return status;
  }
  *out = s;
  return DLS_OK;
}

dls_status dls_fe_series_create(dls_fe_series **out, const char *path, dls_error *error) {
  DLSI_DOOR;
  if (out) *out = NULL;
  const dls_status status = !out    ? dlsi_is_null(error, "out")
                            : !path ? dlsi_is_null(error, "path")
                                    : series_open(out, path, error);
  return dlsi_at(__func__, status, error);
}

/* Makes room for `more` characters and a final 0. */
static dls_status series_reserve(dls_fe_series *s, size_t more, dls_error *error) {
  if (more < s->room - s->length) return DLS_OK;
  const size_t room = 2 * s->room + more + 1;
  char *rows = dlsi_alloc(room, 1);
  if (!rows) return dlsi_no_memory(error);
  if (s->length) memcpy(rows, s->rows, s->length);
  free(s->rows);
  s->rows = rows;
  s->room = room;
  return DLS_OK;
}

static dls_status series_add(dls_fe_series *s, double time, int part, const char *file,
                             dls_error *error) {
  enum { numbers = 100 }; /* room for the words of a row, its time and its part */
  dls_status status = series_reserve(s, strlen(file) + numbers, error);
  if (status) return status;
  const int length =
      snprintf(s->rows + s->length, s->room - s->length,
               "<DataSet timestep=\"%.17g\" part=\"%d\" file=\"%s\"/>\n", time, part, file);
  s->length += (size_t)length;
  status = series_write(s, error);
  if (status) s->length -= (size_t)length; /* a later call writes the rows that are on the disk */
  return status;
}

/* Returns the length of the beginning of `file` that can go into XML unchanged. */
static size_t series_prefix(const char *file) {
  size_t at = 0;
  int length;
  for (long code; (code = dlsi_utf8_next(file + at, &length)) >= 0x20; at += (size_t)length)
    if (code == 0x7f || code == 0xfffe || code == 0xffff ||
        (code < 0x7f && strchr("<>&\"", (int)code)))
      break;
  return at;
}

dls_status dls_fe_series_add(dls_fe_series *series, double time, int part, const char *file,
                             dls_error *error) {
  DLSI_DOOR;
  dls_status status = DLS_OK;
  if (!series) status = dlsi_is_null(error, "series");
  if (!status && !isfinite(time))
    status = dlsi_fail(error, DLS_E_NOT_FINITE, "time", -1, time, "is %g", time);
  if (!status && part < 0)
    status =
        dlsi_fail(error, DLS_E_ARGUMENT, "part", -1, part, "is %d, must not be negative", part);
  if (!status && !file) status = dlsi_is_null(error, "file");
  if (!status && file[series_prefix(file)])
    status = dlsi_fail(error, DLS_E_ARGUMENT, "file", (long long)series_prefix(file), 0,
                       "is a character that XML keeps for itself, a control or no UTF-8");
  if (!status) status = series_add(series, time, part, file, error);
  return dlsi_at(__func__, status, error);
}

dls_status dls_fe_series_finish(dls_fe_series *series, dls_error *error) {
  DLSI_DOOR;
  (void)error;
  if (!series) return DLS_OK;
  free(series->path);
  free(series->rows);
  free(series);
  return DLS_OK;
}
