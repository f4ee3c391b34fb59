/*
 * surface.c: what an answer to matrices means on the body: the sums of the reactions on each body
 * and, with coordinates, their moments, the fields for ParaView and a picture of the surface.
 *
 *   bodies   parts of K's unknowns that K connects
 *   F = sum of R e_k over the unknowns of a body in direction k,   R = H_N r_n + H_T r_t
 *   M = sum of X x R about the origin
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "contact/body.h"
#include "hints.h"
#include "matrices.h"

/* Forces on unknowns, and the bodies that these belong to. */
typedef struct surface {
  const problem *p;
  int n, d, count;  /* count: of bodies */
  double *force;    /* n */
  int *body;        /* n */
  double (*sum)[6]; /* count: F, M */
} surface;

/* ---- bodies ---------------------------------------------------------------------------------- */

/* Numbers the bodies by their first unknown. */
static void find_bodies(surface *s) {
  const dls_model *m = &s->p->model;
  for (int k = 0; k < s->n; k++)
    s->body[k] = k;
  for (int j = 0; j < s->n; j++) {
    if (m->Ks.p)
      for (int e = m->Ks.p[j]; e < m->Ks.p[j + 1]; e++)
        if (m->Ks.x[e] != 0) dlsi_body_join(s->body, j, m->Ks.i[e]);
    if (m->K.a)
      for (int i = 0; i < j; i++)
        if (m->K.a[(size_t)i + (size_t)j * (size_t)m->K.ld] != 0) dlsi_body_join(s->body, j, i);
  }
  /* the directions of a node belong together */
  for (int k = 1; k < s->n; k++) {
    spot here, before;
    if (unknown_place(s->p, k, &here) && unknown_place(s->p, k - 1, &before) &&
        here.node == before.node)
      dlsi_body_join(s->body, k, k - 1);
  }
  s->count = dlsi_body_number(s->n, s->body);
}

/* ---- forces ---------------------------------------------------------------------------------- */

static void surface_push(const dls_sparse *H, int per, const double *r, int d, int first,
                         double *f) {
  for (int j = 0; j < H->cols; j++) {
    const double x = r[(size_t)d * (size_t)(j / per) + (size_t)(first + j % per)];
    for (int e = H->p[j]; e < H->p[j + 1]; e++)
      f[H->i[e]] += H->x[e] * x;
  }
}

static void surface_free(surface *s) {
  free(s->force);
  free(s->body);
  free(s->sum);
}

/* Sums F and M of each body, three parts each; returns 0 without memory. */
static int sum_bodies(surface *s) {
  const double *X = problem_coordinates(s->p, NULL, NULL);
  s->sum = calloc((size_t)s->count + 1, sizeof *s->sum);
  for (int k = 0; s->sum && k < s->n; k++) {
    spot at;
    if (s->force[k] == 0 || !unknown_place(s->p, k, &at)) continue;
    double *F = s->sum[s->body[k]], *M = F + 3;
    const int i = at.direction, j = (i + 1) % 3, l = (i + 2) % 3;
    F[i] += s->force[k];
    if (!X || at.row < 0) continue;
    M[j] += X[3 * at.row + l] * s->force[k];
    M[l] -= X[3 * at.row + j] * s->force[k];
  }
  return s->sum != NULL;
}

/* Returns 0 after a complaint. r: of the contact problem. */
static int surface_make(surface *s, const problem *p, const double *r) {
  const dls_model *m = &p->model;
  dls_error error = {0};
  *s = (surface){.p = p, .n = m->n, .d = m->d};
  s->force = calloc((size_t)s->n + (size_t)m->d * (size_t)m->nodes + 1, sizeof *s->force);
  s->body = malloc(((size_t)s->n + 1) * sizeof *s->body);
  if (!s->force || !s->body) return refuse("out of memory");
  double *nodal = s->force + s->n;
  if (dls_reduction_nodal(p->reduction, r, nodal, &error))
    return complain_of("reactions", &error), 0;
  surface_push(&m->HN, 1, nodal, m->d, 0, s->force);
  surface_push(&m->HT, m->d - 1, nodal, m->d, 1, s->force);
  find_bodies(s);
  return sum_bodies(s) || refuse("out of memory");
}

/* ---- sums ------------------------------------------------------------------------------------ */

/* Prints the sums of the bodies that contact presses: in words or as rows of CSV. */
static void put_sums(const surface *s, FILE *file, int csv) {
  const int moments = problem_coordinates(s->p, NULL, NULL) != NULL, d = s->d;
  if (csv) {
    fputs("body_from_0", file);
    for (int i = 0; i < d; i++)
      fprintf(file, ",F_%c", "xyz"[i]);
    for (int i = d == 2 ? 2 : 0; moments && i < 3; i++)
      fprintf(file, ",M_%c", "xyz"[i]);
    fputc('\n', file);
  }
  for (int b = 0, shown = 0; b < s->count; b++) {
    const double *F = s->sum[b], *M = F + 3;
    if (F[0] == 0 && F[1] == 0 && F[2] == 0 && !csv) continue;
    if (!csv && shown++ == 6) {
      fputs("  more bodies: sums.csv of --csv\n", file);
      return;
    }
    if (csv)
      fprintf(file, "%d", b);
    else if (s->count > 1)
      fprintf(file, "  sum of the reactions on body %d:", b);
    else
      fputs("  sum of the reactions:", file);
    for (int i = 0; i < d; i++)
      csv ? fprintf(file, ",%.17g", F[i]) : fprintf(file, " %c %.6g", "xyz"[i], F[i]);
    if (moments && !csv) fputs("; moment about the origin:", file);
    for (int i = d == 2 ? 2 : 0; moments && i < 3; i++)
      csv ? fprintf(file, ",%.17g", M[i]) : fprintf(file, " %c %.6g", "xyz"[i], M[i]);
    fputc('\n', file);
  }
}

int put_reactions(FILE *file, const problem *p, const double *r) {
  if (p->reduction && p->matrices && !p->of_bodies && places_known(p)) {
    surface s;
    const int good = surface_make(&s, p, r);
    if (good) put_sums(&s, file, 0);
    surface_free(&s);
    return good;
  }
  double sum = 0;
  for (int c = 0; c < p->contact.nc; c++)
    sum += r[p->contact.d * c];
  if (p->contact.nc > 0) fprintf(file, "  sum of the r_n: %.6g\n", sum);
  return 1;
}

/* ---- fields ---------------------------------------------------------------------------------- */

static void begin_array(FILE *file, const char *name, const char *type, int parts) {
  fprintf(file, "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"ascii\">\n",
          type, name, parts);
}

/* Writes a vector field of unknowns over the nodes. */
static void put_vectors(const surface *s, FILE *file, const char *name, const double *x, int rows,
                        double *scratch) {
  memset(scratch, 0, 3 * (size_t)rows * sizeof *scratch);
  for (int k = 0; k < s->n; k++) {
    spot at;
    if (unknown_place(s->p, k, &at) && at.row >= 0) scratch[3 * at.row + at.direction] = x[k];
  }
  begin_array(file, name, "Float64", 3);
  for (int i = 0; i < rows; i++)
    fprintf(file, "%.9g %.9g %.9g\n", scratch[3 * i], scratch[3 * i + 1], scratch[3 * i + 2]);
  fputs("</DataArray>\n", file);
}

/* Writes answer.vtu: the nodes as points. state: of each contact; -1 at other nodes. */
static int write_points(const surface *s, const char *directory, const dls_contact_state *state,
                        const double *u, const double *x) {
  int rows;
  const int *contact;
  const double *X = problem_coordinates(s->p, &rows, &contact);
  double *scratch = malloc(3 * (size_t)rows * sizeof *scratch);
  FILE *file = scratch ? open_in(directory, "answer.vtu") : NULL;
  if (!scratch) (void)complain("out of memory");
  if (file) {
    fprintf(file,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
            "byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"%d\" "
            "NumberOfCells=\"%d\">\n<PointData>\n",
            rows, rows);
    put_vectors(s, file, "displacement", x, rows, scratch);
    put_vectors(s, file, "reaction", s->force, rows, scratch);
    begin_array(file, "state", "Int32", 1);
    for (int i = 0; i < rows; i++)
      fprintf(file, "%d\n", contact[i] < 0 ? -1 : (int)state[contact[i]]);
    fputs("</DataArray>\n", file);
    begin_array(file, "gap", "Float64", 1);
    for (int i = 0; i < rows; i++) {
      const int c = contact[i];
      fprintf(file, "%.9g\n", c < 0 || state[c] != DLS_FREE ? 0 : u[s->p->contact.d * c]);
    }
    fputs("</DataArray>\n</PointData>\n<Points>\n", file);
    begin_array(file, "Points", "Float64", 3);
    for (int i = 0; i < rows; i++)
      fprintf(file, "%.9g %.9g %.9g\n", X[3 * i], X[3 * i + 1], X[3 * i + 2]);
    fputs("</DataArray>\n</Points>\n<Cells>\n", file);
    static const char *const names[] = {"connectivity", "offsets", "types"};
    for (int k = 0; k < 3; k++) {
      begin_array(file, names[k], k < 2 ? "Int64" : "UInt8", 1);
      for (int i = 0; i < rows; i++)
        fprintf(file, "%d\n", k == 2 ? 1 : i + k); /* 1: a vertex */
      fputs("</DataArray>\n", file);
    }
    fputs("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n", file);
  }
  free(scratch);
  return file && close_file(file, "answer.vtu");
}

/* ---- the picture ----------------------------------------------------------------------------- */

/* Writes surface.dat: place along the two longest axes, r_n, |r_t|, state; draws surface.*. */
static int draw_surface(const surface *s, const char *directory, const dls_contact_state *state,
                        const double *r) {
  int rows, axis[3] = {0, 1, 2};
  const int *contact;
  const double *X = problem_coordinates(s->p, &rows, &contact);
  double lo[3], hi[3], most = 0;
  const int d = s->p->contact.d;
  FILE *data = open_table(directory, "surface.dat", "# place1 place2 r_n |r_t| state\n");
  if (!data) return 0;
  for (int k = 0; k < 3; k++) {
    lo[k] = INFINITY, hi[k] = -INFINITY;
    for (int i = 0; i < rows; i++)
      if (contact[i] >= 0) lo[k] = fmin(lo[k], X[3 * i + k]), hi[k] = fmax(hi[k], X[3 * i + k]);
  }
  for (int a = 0; a < 2; a++) /* the longest first */
    for (int k = 2; k > a; k--)
      if (hi[axis[k]] - lo[axis[k]] > hi[axis[k - 1]] - lo[axis[k - 1]]) {
        const int swap = axis[k];
        axis[k] = axis[k - 1], axis[k - 1] = swap;
      }
  for (int i = 0; i < rows; i++) {
    const int c = contact[i];
    if (c < 0) continue;
    double slip = 0;
    for (int k = 1; k < d; k++)
      slip = hypot(slip, r[d * c + k]);
    most = fmax(most, r[d * c]);
    fprintf(data, "%.9g %.9g %.9g %.9g %d\n", X[3 * i + axis[0]], X[3 * i + axis[1]], r[d * c],
            slip, (int)state[c]);
  }
  if (!close_file(data, "surface.dat")) return 0;
  FILE *script = open_script(directory, "surface");
  if (!script) return 0;
  fprintf(script,
          "set title %s noenhanced\nset key outside top center horizontal\nset grid\n"
          "set offsets graph 0.04, graph 0.04, graph 0.04, graph 0.04\nset xlabel '%c'\n",
          quote(AS_GNUPLOT, s->p->name).text, "xyz"[axis[0]]);
  if (s->d == 3) fprintf(script, "set ylabel '%c'\nset size ratio -1\n", "xyz"[axis[1]]);
  if (s->d == 2) fputs("set ylabel 'reaction'\n", script);
  begin_pictures(script, "surface", 1000, 680);
  fputs(s->d == 2
            ? "  plot 'surface.dat' using 1:3 with impulses lw 3 lc rgb '#a8c4e8' title 'r_n', "
              "'' using 1:4 with points pt 4 lc rgb '#c03020' title '|r_t|'"
            : "  plot 'surface.dat' using 1:2 with dots lc rgb '#808080' notitle",
        script);
  for (int k = DLS_FREE; k <= DLS_STICK; k++) {
    const char *word =
        problem_parts(s->p) > 1 || k == DLS_FREE ? state_word((dls_contact_state)k) : "touch";
    if (problem_parts(s->p) == 1 && k == DLS_SLIP) continue;
    fprintf(script, ", \\\n       '' using 1:($5==%d?$%d:NaN)", k, s->d == 2 ? 3 : 2);
    if (s->d == 3) /* the area of a point is its pressure */
      fprintf(script, ":(.5+3*sqrt($3>0?$3/%.9g:0)) with points pt 7 ps variable",
              most > 0 ? most : 1);
    else
      fputs(" with points pt 7 ps 1.2", script);
    fprintf(script, " lc rgb '%s' title '%s'", state_colour((dls_contact_state)k), word);
  }
  return draw_script(script, directory, "surface");
}

int picture_surface(const char *directory, const problem *p, const dls_contact_state *state,
                    const double *r) {
  if (!p->reduction || !p->matrices || p->model.P.p || !problem_coordinates(p, NULL, NULL))
    return 0;
  const surface s = {.p = p, .n = p->model.n, .d = p->model.d};
  return draw_surface(&s, directory, state, r) == 2;
}

int write_surface(const char *directory, const problem *p, const dls_contact_state *state,
                  const double *r, const double *u, const double *x) {
  if (!p->reduction || !p->matrices || p->of_bodies || !places_known(p)) return 1;
  surface s;
  int good = surface_make(&s, p, r);
  FILE *sums = good ? open_in(directory, "sums.csv") : NULL;
  if (sums) put_sums(&s, sums, 1);
  good = sums && close_file(sums, "sums.csv");
  if (good && x && !p->model.P.p && problem_coordinates(p, NULL, NULL))
    good = write_points(&s, directory, state, u, x) && draw_surface(&s, directory, state, r);
  surface_free(&s);
  return good;
}
