/*
 * papers_flow.c: what does the radial return (12) of [Chabrand 1998] cost beside the flow rule (6),
 * from which the paper derives it? (12) replaces be in the plastic term by its mean, an error of
 * the size of the elastic strain; papers_material.c returns (6) as it stands.
 *
 *   points   simple shear to 2 of both materials of the paper, in 4 to 4096 steps: the stress and
 *            the plastic strain at the end beside those of (6) in 16384 steps; CPU of a point
 *   scenes   indentation and extrusion: force at the end, largest plastic strain, energy balance
 */
#include <math.h>
#include <stdlib.h>

#include "common.h"
#include "delassus/forming.h"
#include "fe/solid.h"
#include "papers.h"

enum { materials = 2, paths = 2, levels = 6, scenes = 2, ways = 3, runs = 3 };

static const char *const material_name[materials] = {"indentation", "extrusion"};

static dlsi_solid material(int k) {
  return k == 0 ? dlsi_solid_make(2e5, 0.3, (dlsi_hardening){593, 0.00384, 0.202, 0, 0, 0})
                : dlsi_solid_make(6.8955e4, 0.32, (dlsi_hardening){261.2, 0.11868, 1, 0, 0, 0});
}

typedef struct flow_end {
  double s[4], ep, cpu; /* CPU seconds of a point */
} flow_end;

/* Shears a point to gamma = 2 (path 0), or shears it to 1, stretches it to 1.5 in the plane (path
 * 1: the axes of stress turn, and proportional loading ends). */
static void flow_gradient(int path, double t, double F[5]) {
  const double shear = path == 0 ? 2 * t : fmin(2 * t, 1);
  const double stretch = path == 0 ? 1 : 1 + 0.5 * fmax(0, 2 * t - 1);
  F[0] = stretch;
  F[1] = stretch * shear;
  F[2] = 0;
  F[3] = 1 / stretch;
  F[4] = 1;
}

static flow_end flow_path(int of_material, int path, int exponential, int steps) {
  const dlsi_solid solid = material(of_material);
  dlsi_point point = dlsi_point_virgin(), next;
  flow_end end = {{0}, NAN, 0};
  papers_exponential = exponential;
  const double start = bench_seconds();
  for (int k = 1; k <= steps; k++) {
    double F[5];
    flow_gradient(path, (double)k / steps, F);
    if (!dlsi_solid_update(&solid, F, 1, &point, &next, end.s, NULL)) return end;
    point = next;
  }
  end.cpu = (bench_seconds() - start) / steps;
  end.ep = point.ep;
  papers_exponential = 0;
  return end;
}

typedef struct flow_scene {
  double force, strain, balance, cpu;
  int newton, failed;
} flow_scene;

static flow_scene flow_forming(const char *name, int steps, int exponential, int keep_trace) {
  dls_forming_settings settings;
  dls_forming_settings_init(&settings);
  settings.method = DLS_AUTO;
  settings.steps = steps;
  settings.keep_trace = keep_trace;
  dls_forming *forming = NULL;
  dls_forming_data d = {0};
  papers_exponential = exponential;
  const double start = bench_seconds();
  dls_status status = dls_forming_create(&forming, name, &settings, NULL);
  dls_forming_get(forming, &d);
  for (int k = d.steps; k > 0 && !status; k--)
    status = dls_forming_step(forming, NULL);
  dls_forming_get(forming, &d);
  flow_scene end = {.force = d.force,
                    .cpu = bench_seconds() - start,
                    .newton = d.count.newton,
                    .failed = status != DLS_OK};
  const dls_forming_energy *e = &d.energy;
  end.balance = (e->external - e->elastic - e->plastic - e->friction) / e->external;
  for (int k = 0; k < 4 * (d.mesh ? d.mesh->quads : 0); k++)
    end.strain = fmax(end.strain, d.plastic_strain[k]);
  dls_forming_destroy(forming);
  papers_exponential = 0;
  return end;
}

/* Writes the table of the points and their file. */
static int flow_points(const char *out, double *stress, double *strain, double ratio[2]) {
  FILE *csv = bench_open(out, "papers_flow.csv");
  if (!csv) return 1;
  fprintf(csv, "material,path,steps,radial,exponential,ep_radial,ep_exponential\n");
  for (int m = 0; m < materials; m++)
    for (int path = 0; path < paths; path++) {
      const flow_end exact = flow_path(m, path, 1, 65536);
      for (int k = 0; k < levels; k++) {
        const int steps = 4 << 2 * k;
        const flow_end a = flow_path(m, path, 0, steps), b = flow_path(m, path, 1, steps);
        const double sa = bench_distance(4, a.s, exact.s), sb = bench_distance(4, b.s, exact.s);
        const double ea = fabs(a.ep / exact.ep - 1), eb = fabs(b.ep / exact.ep - 1);
        ratio[0] = fmin(ratio[0], b.cpu / a.cpu);
        ratio[1] = fmax(ratio[1], b.cpu / a.cpu);
        if (k == levels - 1) {
          *stress = fmax(*stress, sa);
          *strain = fmax(*strain, ea);
        }
        fprintf(csv, "%s,%d,%d,%g,%g,%g,%g\n", material_name[m], path, steps, sa, sb, ea, eb);
        bench_print(NULL, "| %s | %s | %d | %.1e | %.1e | %.2f | %.1e | %.1e | %.2f |\n",
                    material_name[m], path ? "shear, then stretch" : "shear", steps, sa, ea,
                    1e6 * a.cpu, sb, eb, 1e6 * b.cpu);
      }
    }
  return fclose(csv) != 0;
}

/* Writes the table of the scenes and their file. */
static int flow_scenes(FILE *page, const char *out, flow_scene end[scenes][runs][ways]) {
  static const int steps[scenes][runs] = {{25, 50, 100}, {100, 400, 1600}};
  static const char *const way_name[ways] = {"(12), det be = 1", "(12), (13) as printed", "(6)"};
  FILE *csv = bench_open(out, "papers_return.csv");
  if (!csv) return 1;
  fprintf(csv, "scene,steps,radial,printed,exponential\n");
  for (int k = 0; k < scenes; k++)
    for (int n = 0; n < runs; n++) {
      for (int way = 0; way < ways; way++) {
        const flow_scene e = flow_forming(dls_forming_name(k), steps[k][n], way == 2, way == 1);
        end[k][n][way] = e;
        bench_print(n == 1 ? NULL : page, "| %s | %d | %s | %.6g | %.4g | %.1e | %d | %.2g%s |\n",
                    dls_forming_name(k), steps[k][n], way_name[way], e.force, e.strain, e.balance,
                    e.newton, e.cpu, e.failed ? ", stopped" : "");
      }
      fprintf(csv, "%s,%d,%g,%g,%g\n", dls_forming_name(k), steps[k][n], end[k][n][0].force,
              end[k][n][1].force, end[k][n][2].force);
    }
  return fclose(csv) != 0;
}

int papers_flow(FILE *page, const char *out) {
  double stress = 0, strain = 0, ratio[2] = {INFINITY, 0};
  flow_scene end[scenes][runs][ways];
  FILE *table = tmpfile();
  if (!table || flow_points(out, &stress, &strain, ratio) || flow_scenes(table, out, end)) return 1;
  const flow_scene *dent = end[0][runs - 1], *first = end[1][0], *last = end[1][runs - 1];
  bench_print(page,
              "## What does the return (12) cost beside the flow rule (6)?\n\n%.1f %% of the "
              "stress at a point, %.0e of the force of the indentation, and %.2f %% of the force "
              "of the extrusion with\n100 steps, %.2f %% with 1600. A return of (6) takes %.0f to "
              "%.0f times the CPU of (12), a fraction of a microsecond\nmore.\n\n(12) replaces be "
              "by its mean in the plastic term of (6). This error has the size of the elastic "
              "strain, and more steps\ndo not remove it. It turns the stress, whose size the yield "
              "stress holds. The plastic strain hardly changes (%.0e).\nWith 100 steps of the "
              "extrusion (6) is within %.2f %% of its own force with 1600, (12) within %.2f %%. "
              "Keeping the\ntrace as in (13) costs no force, but the whole energy balance. "
              "`bench/papers_material.c` integrates (6) by an\nexponential.\n\n",
              100 * stress, fabs(dent[0].force / dent[2].force - 1),
              100 * (first[0].force / first[2].force - 1),
              100 * (last[0].force / last[2].force - 1), ratio[0], ratio[1], strain,
              100 * fabs(first[2].force / last[2].force - 1),
              100 * fabs(first[0].force / last[0].force - 1));
  bench_print(
      page,
      "\nForce of the indentation in N per mm of thickness, of the extrusion in N per radian. "
      "Energy balance: work that is missing,\nover that of the tool. The tangent of (6) is a "
      "difference of eight returns, which takes most of its seconds.\n\n"
      "| scene | steps | return | force | largest plastic strain | energy balance | "
      "Newton steps | s |\n|---|---|---|---|---|---|---|---|\n");
  table_copy(table, page);
  bench_print(page, "\n![Error of the stress, and forces of the extrusion](papers_flow.png)\n\n");
  return 0;
}
