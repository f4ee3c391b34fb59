/*
 * papers_refinement.c: which reactions converge faster to the pressure under the block, weighted or
 * concentrated? Proposition 1 of [Jean 1988] covers the weighted ones alone.
 *
 *   weighted       density r / M, constant on the dual cell
 *   nodal          density of the equivalent nodal forces P r of the weighted reactions, over M
 *   concentrated   density r / M of the nodal forces
 *
 * Compared at the nodes of each mesh, which are nodes of the reference, too, with the mean of the
 * concentrated and the weighted densities of the finest mesh. Error: the L2 norm of the difference
 * over that of the reference, each node with its cell, over a part of the line:
 *
 *   whole     0 to 3 mm: all but two cells of the coarsest mesh, beside the fixed corner
 *   smooth    2 to 3 mm: away from where contact begins
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "papers.h"

enum { coarsest = 8, finest = 512, meshes = 5, kinds = 3, parts = 2 };

static const char *const kind_name[kinds] = {"weighted", "weighted, P r", "concentrated"};
static const double from[parts] = {0, 2e-3}, to[parts] = {3e-3, 3e-3}; /* m */

/* Normal density (kind x nc) at the nodes of a mesh of nx = nc; NULL after a message. */
typedef struct density {
  int nc;
  double *x, *cell, *of[kinds];
} density;

static void density_free(density *p) {
  free(p->x);
  *p = (density){0};
}

/* Fills the densities of one kind of block. */
static int density_fill(density *p, int weighted, double mu) {
  jean_block b;
  if (jean_create(&b, "jean-fig3", weighted, p->nc, mu)) return -1;
  double *r = jean_solve(&b.contact);
  double *nodal = calloc(2 * (size_t)b.data.model.nodes, sizeof *nodal);
  int bad = !r || !nodal;
  if (!bad) bad = dls_reduction_nodal(b.reduction, r, nodal, NULL) < 0;
  for (int c = 0; c < p->nc && !bad; c++) {
    const int node = b.data.candidate_node[c];
    p->x[c] = b.data.mesh->xy[2 * b.data.contact_node[node]];
    p->cell[c] = b.data.cell[c];
    p->of[weighted ? 0 : 2][c] = r[2 * c] / p->cell[c];
    if (weighted) p->of[1][c] = nodal[2 * node] / p->cell[c];
  }
  free(nodal);
  free(r);
  jean_free(&b);
  return bad ? -1 : 0;
}

static int density_create(density *p, int nc, double mu) {
  *p = (density){.nc = nc};
  p->x = calloc((size_t)nc * (2 + kinds), sizeof *p->x);
  if (!p->x) return -1;
  p->cell = p->x + nc;
  for (int k = 0; k < kinds; k++)
    p->of[k] = p->cell + (size_t)nc * (size_t)(1 + k);
  if (!density_fill(p, 0, mu) && !density_fill(p, 1, mu)) return 0;
  density_free(p);
  return -1;
}

/* Returns the distance of both kinds of the reference over a part of the line. */
static double density_apart(const density *fine, int part) {
  double difference = 0, size = 0;
  for (int c = 0; c < fine->nc; c++) {
    if (fine->x[c] < from[part] - 1e-9 || fine->x[c] > to[part] + 1e-9) continue;
    const double a = fine->of[0][c], b = fine->of[2][c];
    difference += fine->cell[c] * (a - b) * (a - b);
    size += fine->cell[c] * (a + b) * (a + b) / 4;
  }
  return sqrt(difference / size);
}

/* Returns the error of a kind over a part of the line. */
static double density_error(const density *p, int kind, int part, const density *fine) {
  double difference = 0, size = 0;
  for (int c = 0; c < p->nc; c++) {
    if (p->x[c] < from[part] - 1e-9 || p->x[c] > to[part] + 1e-9) continue;
    const int f = c * (fine->nc / p->nc);
    const double exact = (fine->of[0][f] + fine->of[2][f]) / 2, d = p->of[kind][c] - exact;
    difference += p->cell[c] * d * d;
    size += p->cell[c] * exact * exact;
  }
  return sqrt(difference / size);
}

static int refinement_write(FILE *csv, const density *p, const char *name) {
  for (int c = 0; c < p->nc; c++)
    fprintf(csv, "%s,%d,%.9g,%.9g,%.9g,%.9g\n", name, p->nc, p->x[c], p->of[0][c], p->of[1][c],
            p->of[2][c]);
  return 0;
}

int papers_refinement(FILE *page, const char *out) {
  FILE *csv = bench_open(out, "papers_pressure.csv"),
       *errors = bench_open(out, "papers_errors.csv");
  if (!csv || !errors) return 1;
  fprintf(csv, "kind,mesh,x,weighted,nodal,concentrated\n");
  fprintf(errors, "mu,part,h,weighted,nodal,concentrated\n");
  static const double friction[] = {1, 0.2};
  double h[meshes], error[2][parts][kinds][meshes], order[2][parts][kinds], apart[2][parts];
  int bad = 0;
  for (int m = 0; m < 2 && !bad; m++) {
    density fine, p;
    bad = density_create(&fine, finest, friction[m]);
    if (bad) break;
    for (int a = 0; a < parts; a++)
      apart[m][a] = density_apart(&fine, a);
    if (m == 0) refinement_write(csv, &fine, "reference");
    for (int k = 0; k < meshes && !bad; k++) {
      bad = density_create(&p, coarsest << k, friction[m]);
      if (bad) break;
      h[k] = 4e-3 / p.nc;
      if (m == 0) refinement_write(csv, &p, "mesh");
      for (int a = 0; a < parts; a++) {
        for (int t = 0; t < kinds; t++)
          error[m][a][t][k] = density_error(&p, t, a, &fine);
        fprintf(errors, "%g,%s,%g,%g,%g,%g\n", friction[m], a ? "smooth" : "whole", h[k],
                error[m][a][0][k], error[m][a][1][k], error[m][a][2][k]);
      }
      density_free(&p);
    }
    for (int a = 0; a < parts; a++)
      for (int t = 0; t < kinds; t++)
        order[m][a][t] = bench_exponent(meshes, h, error[m][a][t], 4);
    density_free(&fine);
  }
  if (fclose(csv) || fclose(errors) || bad) return 1;
  double least = INFINITY, most = 0;
  for (int m = 0; m < 2; m++)
    for (int a = 0; a < parts; a++)
      for (int k = 1; k < meshes; k++) {
        least = fmin(least, error[m][a][0][k] / error[m][a][2][k]);
        most = fmax(most, error[m][a][0][k] / error[m][a][2][k]);
      }
  bench_print(page,
              "## Weighted or concentrated reactions?\n\nBoth converge with the same order. Take "
              "the concentrated ones, which need fewer sweeps. From 16x8 on the error of the\n"
              "weighted densities is %.2f to %.2f times that of the concentrated forces, divided "
              "by their cells. The order is %.1f\nand %.1f if a part of the line slips from end to "
              "end (friction 0.2, smooth), and %.1f to %.1f if a zone ends between\ntwo nodes. "
              "Nodal forces P r of the weighted reactions are as good as concentrated ones.\n\nThe "
              "table has the error of the normal density of jean-fig3 at the nodes (L2 norm, "
              "relative). The reference is the mean\nof both kinds on %dx%d, which differ there by "
              "%.0e and %.0e (friction 1), %.0e and %.0e (0.2). Whole: the line from 0\nto 3 mm; "
              "smooth: from 2 to 3 mm, away from where contact begins and from the fixed corner. "
              "Order: of the last four\nmeshes.\n\n| friction | part of the line | reactions |",
              least, most, order[1][1][0], order[1][1][2], order[1][0][2], order[0][0][0], finest,
              finest / 2, apart[0][0], apart[0][1], apart[1][0], apart[1][1]);
  for (int k = 0; k < meshes; k++)
    bench_print(page, " %dx%d |", coarsest << k, coarsest << k >> 1);
  bench_print(page, " order |\n|---|---|---|---|---|---|---|---|---|\n");
  for (int m = 0; m < 2; m++)
    for (int a = 0; a < parts; a++)
      for (int t = 0; t < kinds; t++) {
        FILE *const kept = t == 1 ? NULL : page; /* P r: the screen */
        bench_print(kept, "| %g | %s | %s |", friction[m], a ? "smooth" : "whole", kind_name[t]);
        for (int k = 0; k < meshes; k++)
          bench_print(kept, " %.2g |", error[m][a][t][k]);
        bench_print(kept, " %.2f |\n", order[m][a][t]);
      }
  bench_print(page,
              "\n![Density at the nodes, and its error against h](papers_refinement.png)\n\n");
  return 0;
}
