/*
 * papers_weighting.c: may P have negative entries? [Jean 1988] ends with "this is a particular
 * situation due to the fact the matrix P is positive. For other kinds of finite elements further
 * investigation is needed." Quadratic edges have a P with entries < 0, four-node faces in 3D have
 * none, nine-node faces have.
 *
 *   definite    least over largest eigenvalue of the scaled W = P^T L^T K^-1 L P
 *   answers     of random q at frictions 0.3, 1 and 3: how many have a certified answer by auto
 *   pull        most that P r pulls at a node, over the largest reaction; all densities press
 *   error       density of the normal reactions beside that of a fine mesh, at nodes 2 <= x <= 3
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus/diagnose.h"
#include "papers.h"
#include "papers_grid.h"

enum { loads = 20, frictions = 3, meshes = 3, kinds = 4 };

static const double friction[frictions] = {0.3, 1, 3};
static const double scene_mu = 0.2;

/* Elements: d, order, cells of the coarsest mesh and of the reference. */
static const struct {
  const char *name;
  int d, order, coarsest, finest, draws;
} kind[kinds] = {{"linear edges", 2, 1, 16, 256, loads},
                 {"quadratic edges", 2, 2, 8, 128, loads},
                 {"four-node faces", 3, 1, 6, 24, loads / 4},
                 {"nine-node faces", 3, 2, 3, 12, loads / 4}};

typedef struct weighting_row {
  double least, definite, unique, pull, error;
  int answers, asked, nc;
} weighting_row;

/* Counts certified answers of random q. */
static void weighting_answers(const grid *g, int draws, weighting_row *row) {
  const int m = g->d * g->contact.nc;
  double *q = calloc(3 * (size_t)m, sizeof *q), *r = q + m, *mu = r + m;
  uint64_t state = 2026;
  for (int k = 0; k < frictions * draws && q; k++) {
    dls_contact p = g->contact;
    p.q = q;
    p.mu = mu;
    for (int i = 0; i < m; i++)
      q[i] = bench_draw(&state);
    for (int c = 0; c < p.nc; c++)
      mu[c] = friction[k % frictions];
    dls_certificate certificate = {0};
    row->asked++;
    if (dls_solve(&p, NULL, r, NULL, NULL, NULL) < 0) continue;
    row->answers += dls_contact_certify(&p, r, NULL, &certificate, NULL) == DLS_OK &&
                    dls_certificate_holds(&certificate, 1e-8);
  }
  free(q);
}

/* Solves the scene: density (candidates) for the caller to free. */
static double *weighting_density(grid *g, weighting_row *row) {
  double *r = jean_solve(&g->contact), *R = calloc((size_t)(g->d * g->line), sizeof *R);
  if (!r || !R || dls_reduction_nodal(g->reduction, r, R, NULL) < 0) {
    free(r);
    free(R);
    return NULL;
  }
  double most = 0;
  for (int k = 0; k < g->line; k++)
    most = fmax(most, R[g->d * k]);
  for (int k = 0; k < g->line; k++)
    row->pull = fmin(row->pull, R[g->d * k] / most);
  for (int c = 0; c < g->candidates; c++)
    r[c] = r[g->d * c] / g->area[c];
  free(R);
  return r;
}

/* Returns the error of a density beside the mean of both of a fine grid. */
static double weighting_error(const grid *g, const double *density, const grid *fine,
                              const double *a, const double *b) {
  double difference = 0, size = 0;
  const int step = (fine->nodes[0] - 1) / (g->nodes[0] - 1), columns = g->nodes[0] - 1;
  for (int c = 0; c < g->candidates; c++) {
    const double x = grid_coordinate(g, g->node[c], 0);
    if (x < 2 - 1e-9 || x > 3 + 1e-9) continue;
    const int f = (c % columns) * step + (c / columns) * step * (fine->nodes[0] - 1);
    const double exact = (a[f] + b[f]) / 2, d = density[c] - exact;
    difference += g->area[c] * d * d;
    size += g->area[c] * exact * exact;
  }
  return sqrt(difference / size);
}

/* Writes the densities along a contact line. */
static void weighting_line(const grid *g, const double *density, const char *name, int weighted,
                           FILE *line) {
  for (int c = 0; c < g->candidates; c++)
    fprintf(line, "%s,%s,%g,%g\n", name, weighted ? "weighted" : "concentrated",
            grid_coordinate(g, g->node[c], 0), density[c]);
}

/* Fills the rows of a kind: mesh, then concentrated and weighted. */
static int weighting_kind(int k, weighting_row row[meshes][2], FILE *csv, FILE *line) {
  grid fine[2], g;
  double *exact[2] = {0};
  int bad = 0;
  for (int w = 0; w < 2 && !bad; w++) {
    weighting_row ignored = {0};
    bad = grid_create(&fine[w], kind[k].d, kind[k].order, kind[k].finest, w, scene_mu);
    if (!bad) bad = !(exact[w] = weighting_density(&fine[w], &ignored));
  }
  for (int n = 0; n < meshes && !bad; n++)
    for (int w = 0; w < 2 && !bad; w++) {
      const int cells = kind[k].d == 2 ? kind[k].coarsest << n : kind[k].coarsest * (n + 1);
      if (kind[k].finest % cells) continue;
      weighting_row *r = &row[n][w];
      *r = (weighting_row){0};
      bad = grid_create(&g, kind[k].d, kind[k].order, cells, w, scene_mu);
      if (bad) break;
      dls_diagnosis d = {0};
      bad = dls_contact_diagnose(&g.contact, 600, &d, NULL) < 0;
      r->least = g.least;
      r->definite = d.smallest / d.largest;
      r->unique = d.friction_unique;
      r->nc = g.candidates;
      if (n < 2) weighting_answers(&g, kind[k].draws, r);
      double *density = weighting_density(&g, r);
      bad |= !density;
      if (!bad) r->error = weighting_error(&g, density, &fine[0], exact[0], exact[1]);
      const double h = 4. / (g.nodes[0] - 1);
      if (!bad && kind[k].d == 2 && n == 0) weighting_line(&g, density, kind[k].name, w, line);
      if (!bad)
        fprintf(csv, "%s,%s,%g,%g\n", kind[k].name, w ? "weighted" : "concentrated", h, r->error);
      free(density);
      grid_free(&g);
    }
  for (int w = 0; w < 2; w++) {
    grid_free(&fine[w]);
    free(exact[w]);
  }
  return bad;
}

int papers_weighting(FILE *page, const char *out) {
  FILE *csv = bench_open(out, "papers_weighting.csv"), *line = bench_open(out, "papers_line.csv");
  if (!csv || !line) return 1;
  fprintf(csv, "edges,reactions,h,error\n");
  fprintf(line, "edges,reactions,x,density\n");
  weighting_row row[kinds][meshes][2] = {0};
  int bad = 0, asked = 0, answers = 0;
  for (int k = 0; k < kinds && !bad; k++)
    bad = weighting_kind(k, row[k], csv, line);
  if (fclose(csv) || fclose(line) || bad) return 1;
  double pull = 0, ratio = INFINITY, most = 0;
  for (int k = 0; k < kinds; k++)
    for (int n = 0; n < meshes && row[k][n][1].nc; n++) {
      const weighting_row *r = row[k][n];
      asked += k % 2 ? r[1].asked : 0;
      answers += k % 2 ? r[1].answers : 0;
      pull = fmax(pull, -r[1].pull);
      ratio = fmin(ratio, r[1].definite / r[0].definite);
      most = fmax(most, r[1].definite / r[0].definite);
    }
  bench_print(page,
              "## May P have negative entries?\n\nYes. Quadratic edges give entries down to %.3f, "
              "nine-node faces down to %.4f. The method loses Propositions 2 and 3\nand nothing "
              "else. W = P^T (L^T K^-1 L) P stays positive definite, so that every load has an "
              "answer: of %d random loads\nat frictions 0.3, 1 and 3, auto answered %d.\n\nP costs "
              "conditioning, with and without negative entries: the least eigenvalue over the "
              "largest is %.2f to %.2f times\nthat of concentrated reactions. Densities obey the "
              "laws. Their equivalents P r pull at some corners beside the border\nof contact, by "
              "up to %.0f %% of the largest reaction. Four-node faces have no negative entry.\n\n"
              "The table has boxes of linear and quadratic elements with loads like those of "
              "jean-fig3, in 2D and 3D, friction %g.\nError: of the normal density at 2 <= x <= 3. "
              "Its reference is the mean of both kinds on %d linear and %d quadratic\nedges, %d x "
              "%d four-node and %d x %d nine-node faces.\n\n| contact line or face | contacts | "
              "reactions | least entry of P | eigenvalues of W, least / largest | one answer below "
              "friction | error |\n|---|---|---|---|---|---|---|\n",
              row[1][0][1].least, row[3][0][1].least, asked, answers, ratio, most, 100 * pull,
              scene_mu, kind[0].finest, kind[1].finest, kind[2].finest, kind[2].finest,
              kind[3].finest, kind[3].finest);
  for (int k = 0; k < kinds; k++)
    for (int n = 0; n < meshes; n++)
      for (int w = 0; w < 2; w++) {
        const weighting_row *r = &row[k][n][w];
        if (!r->nc) continue;
        FILE *const kept = n > (k < 2) ? NULL : page; /* the screen shows all */
        bench_print(kept, "| %s | %d | %s | %.3g | %.1e | %.2g | %.1e |\n", kind[k].name, r->nc,
                    w ? "weighted" : "concentrated", r->least, r->definite, r->unique, r->error);
      }
  bench_print(page, "\n![Densities along the line, and their error](papers_weighting.png)\n");
  return 0;
}
