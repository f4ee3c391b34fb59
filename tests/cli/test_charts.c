/* test_charts.c: chart, map, profile and solve --plot: figures, verdicts, files, exit statuses. */
#define _GNU_SOURCE
#include <sys/wait.h>

#include "program.h"
#include "run.h"

static int shows(const char *text) {
  return strstr(output, text) != NULL;
}

static int count_of(const char *text, const char *part) {
  int count = 0;
  for (const char *at = text; (at = strstr(at, part)); at += strlen(part))
    count++;
  return count;
}

/* ---- chart ----------------------------------------------------------------------------------- */

static const char *const charted[] = {"data/failures/c15-slow-splitting.txt",
                                      "data/failures/c16-three-solutions-3d.txt",
                                      "data/fclib/FC2D_SliderCrankLagrangian00000.hdf5"};
static const char *const by_hand[] = {
    "auto",  "nlgs", "nlgs -a aitken", "nlgs -a momentum", "nlgs -a anderson",    "newton",
    "lemke", "admm", "homotopy",       "penalty",          "augmented-lagrangian"};
static const char *const in_table[] = {
    "auto",  "nlgs", "nlgs+aitken", "nlgs+momentum", "nlgs+anderson",        "newton",
    "lemke", "admm", "homotopy",    "penalty",       "augmented-lagrangian", "gauss-seidel"};
enum {
  without_model = sizeof by_hand / sizeof by_hand[0],
  with_model = sizeof in_table / sizeof in_table[0]
};
static const char *const tolerances[] = {"1e-02", "1e-04", "1e-08", "1e-12"};

/* Each row that was asked tells iterations, verdict and residual of `solve --json` at the same
 * tolerance, to the last bit. */
TEST_EACH(chart_tells_what_solve_tells, 0, 3) {
  NEEDS_HDF5;
  char arguments[300], key[80], verdict[40];
  (void)snprintf(arguments, sizeof arguments, "chart -r 1 %s -o @", charted[_i]);
  ck_assert_int_eq(run(arguments), 0);
  const char *csv = contents("chart.csv");
  int compared = 0;
  for (size_t k = 0; k < sizeof by_hand / sizeof by_hand[0]; k++)
    for (size_t t = 0; t < sizeof tolerances / sizeof tolerances[0]; t++) {
      int asked, iterations, longer;
      double cpu, residual;
      char times[20];
      (void)snprintf(key, sizeof key, "\n%s,%s,", in_table[k], tolerances[t]);
      const char *row = strstr(csv, key);
      ck_assert_msg(row != NULL, "no row %s", key);
      ck_assert_int_eq(sscanf(row + strlen(key), "%39[^,],%d,%lf,%19[^,],%d,%lf,%*[^,],%*c,%d",
                              verdict, &asked, &cpu, times, &iterations, &residual, &longer),
                       7);
      if (!asked || longer) continue; /* solve stops at the method's own limit */
      (void)snprintf(arguments, sizeof arguments, "solve --json -t %s -m %s %s", tolerances[t],
                     by_hand[k], charted[_i]);
      const int exit_status = run(arguments);
      ck_assert_msg(exit_status == (strcmp(verdict, "solved") ? 1 : 0), "%s: %s", arguments,
                    verdict);
      ck_assert_msg(number_of("iterations") == iterations, "%s: %d", arguments, iterations);
      ck_assert_msg(number_of("residual") == residual, "%s: %g", arguments, residual);
      compared++;
    }
  ck_assert_int_ge(compared, 30);
}

TEST(chart_names_the_method_and_writes_its_files) {
  ck_assert_int_eq(run("chart -r 1 jean-fig3 -o @/a/b"), 0);
  ck_assert((shows("\nthe fastest on the whole, ") || shows("\nauto: ")) &&
            shows("times the fastest") && shows("\nauto  "));
  ck_assert(shows("errors in r; answer A of "));
  ck_assert_int_eq(count_of(contents("a/b/chart.csv"), "\n"), 1 + with_model * 13);
  ck_assert_int_ge(count_of(contents("a/b/history.csv"), "\nnlgs,"), 50);
  ck_assert_int_ge(count_of(contents("a/b/chart.gp"), "times the fastest"), 1);
  /* every method has a colour of its own in the key */
  const char *gp = contents("a/b/chart.gp");
  char colours[16][8];
  int found = 0;
  for (size_t k = 0; k < sizeof in_table / sizeof in_table[0]; k++) {
    char key[64];
    (void)snprintf(key, sizeof key, "set label '%s' at screen", in_table[k]);
    const char *at = strstr(gp, key), *colour = at ? strstr(at, "tc rgb '#") : NULL;
    ck_assert_msg(colour != NULL, "no %s", key);
    (void)snprintf(colours[found], 8, "%.7s", colour + 8);
    for (int j = 0; j < found; j++)
      ck_assert_str_ne(colours[j], colours[found]);
    found++;
  }
}

/* Errors are measured from a proved answer: each is at least its radius. */
TEST(chart_proves_its_reference) {
  ck_assert_int_eq(run("chart -r 1 data/failures/c28-nearly-singular.txt -o @"), 0);
  const char *proved = strstr(output, ", proved within ");
  ck_assert_msg(proved != NULL, "%s", output);
  const double radius = strtod(proved + strlen(", proved within "), NULL);
  ck_assert(radius > 0 && radius < 1e-10);
  int rows = 0;
  for (const char *row = strchr(contents("chart.csv"), '\n'); row; row = strchr(row + 1, '\n')) {
    double tol, cpu, times, residual, error;
    int asked, iterations;
    if (sscanf(row, "\n%*[^,],%lf,solved,%d,%lf,%lf,%d,%lf,%lf", &tol, &asked, &cpu, &times,
               &iterations, &residual, &error) != 7)
      continue;
    rows++;
    ck_assert_double_ge(error, 0.8 * radius);
  }
  ck_assert_int_gt(rows, 20);
  ck_assert(strstr(contents("chart.gp"), "proved error in r") != NULL);
  /* the first stage of auto begins at iteration 0, which a logarithm moves to 1 */
  ck_assert_ptr_nonnull(strstr(contents("chart.gp"), "set arrow from first 1,graph 0"));
  /* the band ends where it begins: at the first tolerance, by twice the time */
  double corner[2][2];
  const char *band = strstr(contents("chart.gp"), "$band << END\n"), *end = strstr(band, "\nEND");
  while (end[-1] != '\n')
    end--;
  ck_assert_int_eq(sscanf(band, "$band << END %lf,%lf", &corner[0][0], &corner[0][1]), 2);
  ck_assert_int_eq(sscanf(end, "%lf,%lf", &corner[1][0], &corner[1][1]), 2);
  ck_assert_double_eq(corner[1][1], corner[0][1]);
  ck_assert_double_eq_tol(corner[1][0], 2 * corner[0][0], 1e-4 * corner[1][0]);
}

/* One contact that slips, W = 2, mu = 1/2 and r = (1, 1/2): w d r / d q_n = (1, 1/2), d r / d mu =
 * (0, 1). */
TEST(info_maps_what_reactions_depend_on) {
  write_file("slip.txt", "contact 2 1\nW\n2 0\n0 2\nq -2 -3\nmu 1/2\n");
  ck_assert_msg(run("info @/slip.txt --sensitivity -o @") == 0, "%s", output);
  ck_assert(shows("\n          0 slip ") && shows(" 0 (1.1)\n"));
  ck_assert_str_eq(contents("sensitivity.csv"),
                   "candidate_from_0,by,rn_qn,rn_qt,rt_qn,rt_qt\n0,0,1,0,0.5,0\n");
  ck_assert_str_eq(contents("friction.csv"),
                   "candidate_from_0,state,r_n,r_t,dr_n_dmu,dr_t_dmu\n0,1,1,0.5,0,1\n");
  ck_assert_int_eq(run("info data/failures/c05-hyperstatic.txt --sensitivity -o @/b"), 2);
  ck_assert(shows("no derivative"));
}

TEST(rank_deficient_is_measured_in_u) {
  NEEDS_HDF5;
  ck_assert_int_eq(run("chart -r 1 data/fclib/gfc2d_granularflowonwall_00069_00350.hdf5 -o @"), 0);
  ck_assert(shows("errors in u, W being rank deficient; answer A of "));
}

TEST(several_answers_are_told) {
  ck_assert_int_eq(run("chart -r 1 data/failures/c16-three-solutions-3d.txt -o @"), 0);
  ck_assert(shows("SEVERAL ANSWERS: answer A of ") && shows("; answer B of "));
}

/* No solution: auto fails, and the files are there all the same. */
TEST(chart_is_1_where_auto_fails) {
  ck_assert_int_eq(run("chart -r 1 data/failures/c04-squeezed.txt -o @"), 1);
  ck_assert(shows("auto: proved none") && shows("true errors are unknown"));
  ck_assert_int_ge(count_of(contents("chart.csv"), "proved none"), 13);
}

/* Without gnuplot: tables are written, one line says what to install, and the exit is as if
 * drawn. */
TEST(without_gnuplot) {
  static const char *const calls[] = {
      "chart -r 1 jean-fig4 -o @/c", "map --rows 3 --limit 0.05 jean-fig4 -o @/m",
      "profile -r 1 jean-fig4 -o @/p", "solve data/failures/c20-scales.txt --plot @/s"};
  static const char *const files[] = {"c/chart.csv", "m/map.csv", "p/profile.csv", "s/history.csv"};
  char path[4000];
  (void)snprintf(path, sizeof path, "%s", getenv("PATH"));
  for (int k = 0; k < 4; k++) {
    ck_assert_int_eq(setenv("PATH", "/no/such/place", 1), 0);
    const int status = run(calls[k]);
    ck_assert_int_eq(setenv("PATH", path, 1), 0);
    ck_assert_msg(status == 0, "%s: %d: %s", calls[k], status, output);
    ck_assert_int_eq(count_of(output, "install gnuplot"), 1);
    ck_assert(!shows("drawn: "));
    ck_assert_int_ge(count_of(contents(files[k]), "\n"), 3);
  }
}

/* --no-pictures: the same tables and scripts, and gnuplot is not looked for. */
TEST_EACH(no_pictures_are_asked_for, 0, 3) {
  static const char *const scenes[] = {"jean-fig3 --mesh 4x4", "bar-impact --mesh 6 --steps 6",
                                       "indentation --mesh 6x4 --steps 2"};
  static const char *const tables[] = {"contact.csv", "energy.csv", "contact.csv"};
  static const char *const scripts[] = {"deformed.gp", "energy.gp", "force.gp"};
  NEEDS_MUMPS;
  char arguments[200], name[80], path[4000];
  static char drawn[100000], script[100000];
  (void)snprintf(path, sizeof path, "%s", getenv("PATH"));
  for (int without = 0; without < 2; without++) {
    (void)snprintf(arguments, sizeof arguments, "scene %s --out @/%d%s", scenes[_i], without,
                   without ? " --no-pictures" : "");
    ck_assert_int_eq(setenv("PATH", "/no/such/place", 1), 0);
    const int status = run(arguments);
    ck_assert_int_eq(setenv("PATH", path, 1), 0);
    ck_assert_msg(status == 0, "%s: %d: %s", arguments, status, output);
    ck_assert_int_eq(count_of(output, "install gnuplot"), !without);
  }
  (void)snprintf(name, sizeof name, "0/%s", tables[_i]);
  (void)snprintf(drawn, sizeof drawn, "%s", contents(name));
  (void)snprintf(name, sizeof name, "0/%s", scripts[_i]);
  (void)snprintf(script, sizeof script, "%s", contents(name));
  ck_assert(count_of(drawn, "\n") > 3 && count_of(script, "plot") > 0);
  (void)snprintf(name, sizeof name, "1/%s", tables[_i]);
  ck_assert_str_eq(contents(name), drawn);
  (void)snprintf(name, sizeof name, "1/%s", scripts[_i]);
  ck_assert_str_eq(contents(name), script);
  /* where there is gnuplot, too */
  ck_assert_int_eq(run(arguments), 0);
  (void)snprintf(arguments, sizeof arguments, "ls %s/1 | grep -q -e png -e svg", directory);
  ck_assert_int_ne(system(arguments), 0);
}

/* ---- map ------------------------------------------------------------------------------------- */

TEST(map_of_friction) {
  ck_assert_int_eq(run("map jean-fig3 --rows 5 --mu 0:4 -o @"), 0);
  const char *csv = contents("map.csv");
  ck_assert_int_eq(count_of(csv, "\n"), 1 + 6 * with_model); /* 1 is the scene's own */
  ck_assert_int_eq(count_of(csv, ",auto,solved,"), 6);
  ck_assert_int_eq(count_of(csv, "1 (own),1,"), with_model);
  ck_assert_int_eq(count_of(csv, ",penalty,no progress,"), 6);
  ck_assert_int_ge(count_of(contents("map.gp"), "one answer for all loads below 0.22"), 1);
  ck_assert_int_ge(count_of(contents("map.gp"), "some candidate jams above 2.8"), 1);
}

/* A wedge jams from a friction on: auto says so, and no other method is better. */
TEST(map_of_a_wedge_that_jams) {
  ck_assert_int_eq(run("map data/failures/c03-jam-below.txt --rows 9 --mu 0:3 -o @"), 0);
  const char *csv = contents("map.csv");
  ck_assert_int_ge(count_of(csv, ",auto,solved,"), 2);
  ck_assert_int_ge(count_of(csv, ",auto,likely none,"), 1);
  ck_assert_int_ge(count_of(contents("map.gp"), "last reached by continuation"), 1);
}

TEST(map_of_problems) {
  ck_assert_int_eq(run("map data/failures/c04-squeezed.txt data/failures/c20-scales.txt -o @"), 0);
  const char *csv = contents("map.csv");
  ck_assert_int_eq(count_of(csv, ",auto,proved none,"), 1);
  ck_assert_int_eq(count_of(csv, "c20-scales,"), without_model);
}

TEST_EACH(map_against_damage, 0, 2) {
  char line[100];
  (void)snprintf(line, sizeof line, "map data/failures/c20-scales.txt --against %s -o @ %s",
                 _i ? "skew" : "rank", "--samples 2 --rows 2");
  ck_assert_int_eq(run(line), 0);
  const char *csv = contents("map.csv");
  ck_assert_int_eq(count_of(csv, "\n"), 1 + 2 * 7 * without_model);
  /* full rank, symmetric: all solved */
  ck_assert_int_eq(count_of(csv, _i ? ",0,auto,1,0\n" : ",1,auto,1,0\n"), 2);
}

TEST(map_of_a_scene_in_steps) {
  ck_assert_int_eq(run("map extrusion --rows 2 --mu 0.05:0.1 --limit 0.1 -o @") & ~1, 0);
  ck_assert_int_eq(count_of(contents("map.csv"), "\n"), 1 + 2 * 6);
}

/* A coarse mesh folds under much friction: a verdict of its own, in a colour of its own. Fine ones
 * end at the limit, within a step that would take seconds. */
TEST(map_of_meshes_that_fold) {
  ck_assert_int_eq(run("map extrusion --against mesh --rows 1 --mu 0.3:0.5 --limit 0.05 -o @"), 1);
  const char *csv = contents("map.csv");
  ck_assert_int_ge(count_of(csv, "0.5,2x3,mesh folded,0.3"), 1);
  ck_assert_int_ge(count_of(csv, ",not decided,"), 2);
  for (const char *at = csv; (at = strstr(at, ",not decided,")); at++) {
    double part, seconds;
    ck_assert_int_eq(sscanf(at, ",not decided,%lf,%lf", &part, &seconds), 2);
    ck_assert(seconds >= 0.5 && seconds < 1);
  }
  ck_assert_int_ge(count_of(contents("map.dat"), "0 0 0x303030 0xffffff \"mesh folded 3"), 1);
  ck_assert_int_ge(count_of(contents("map.dat"), "%\" 1\n"), 2); /* hatched */
}

/* Without friction the upper of two blocks slides off; friction 1 keeps it at its place. */
TEST(map_of_bodies_that_move) {
  ck_assert_int_eq(run("map two-blocks --rows 2 --mu 0:1 -o @"), 1);
  const char *csv = contents("map.csv");
  ck_assert_int_eq(count_of(csv, "\n"), 1 + 2 * 6);
  ck_assert_int_eq(count_of(csv, "\n0,"), 6);
  ck_assert_int_eq(count_of(csv, ",proved none,0."), 6);
  ck_assert_int_eq(count_of(csv, "\n1,"), 6);
  ck_assert_int_eq(count_of(csv, ",solved,1.0000,"), 6);
  ck_assert_int_eq(count_of(csv, ",40,"), 2);           /* the scene's own steps */
  ck_assert_int_ge(count_of(csv, ",0,0.000e+00\n"), 4); /* stuck: no work of friction */
  ck_assert_int_eq(count_of(contents("map.dat"), "proved none"), 6);
  ck_assert_int_eq(count_of(contents("map.gp"), "set xlabel 'steps of the whole time, 2'"), 1);
  ck_assert_int_eq(run("map bar-impact --against mesh --rows 1 --mu 0:1 -m nlgs -o @/m"), 0);
  ck_assert_int_eq(count_of(contents("m/map.csv"), ",100,solved,"), 1);
  ck_assert_int_eq(run("map block-drop --rows 1 --mu 0.1:1 --limit 10 -o @/b"), 0);
}

/* A run that finishes with few steps is no right answer: each cell says how far its force is from
 * that of the most steps. */
TEST(map_tells_how_far_a_run_is_off) {
  ck_assert_int_eq(run("map indentation --rows 1 --mu 0.1:1 --limit 10 -o @"), 0);
  const char *at = contents("map.csv");
  double off[6];
  double force[6];
  ck_assert_int_eq(count_of(at, ",solved,1.0000,"), 6);
  for (int k = 0; k < 6; k++) {
    at = strstr(at + 1, ",solved,1.0000,");
    ck_assert_int_eq(sscanf(at, ",solved,1.0000,%*f,%lf,%lf", &force[k], &off[k]), 2);
  }
  for (int k = 0; k < 6; k++)
    ck_assert_double_eq_tol(off[k], fabs(force[k] / force[5] - 1), 1e-3 * off[k] + 1e-8);
  ck_assert_double_eq(off[5], 0);
  ck_assert(off[0] > 5e-3 && off[4] < 2e-3 && off[0] > off[3] && off[3] > off[4]);
  ck_assert_int_eq(count_of(contents("map.dat"), "s, finest\""), 1);
  ck_assert_int_ge(count_of(contents("map.dat"), " %\""), 5);
}

/* A solve that ends at its own limit of iterations goes on; if it still has no verdict when its
 * time is over, it has none. */
TEST(limits_are_no_verdicts) {
  ck_assert_int_eq(run("map jean-fig3 --rows 2 --mu 0.05:10 --limit 0.001 -o @"), 0);
  ck_assert_int_eq(count_of(contents("map.csv"), "10,10,gauss-seidel,not decided,"), 1);
  ck_assert_int_eq(count_of(contents("map.gp"), "no verdict in 0.01 s of CPU"), 1);
}

/* The steps of scenes, and matrices, in every command; the answer of a step is the scene's. */
TEST(steps_and_matrices_are_problems) {
  static const char *const names[] = {"indentation --step 10", "two-blocks", "block-drop",
                                      "jean-moving4 --step 10", "bar-impact"};
  static const char *const notes[] = {"step 10 of 100, 4 contacts touch", "step 40 of 40",
                                      "the last step with so many; --step=N takes another one",
                                      "step 10 of 800", "1 contact touches"};
  static const char *const calls[] = {"solve %s", "info %s", "chart -r 1 %s -o @/c%d",
                                      "profile -r 1 %s -o @/p%d"};
  char arguments[300];
  for (int k = 0; k < 5; k++)
    for (int i = 0; i < 4; i++) {
      (void)snprintf(arguments, sizeof arguments, calls[i], names[k], k);
      if (i > 0 && k == 1) { /* the upper block has no support */
        ck_assert_msg(run(arguments) == 2, "%s: %s", arguments, output);
        ck_assert_msg(shows("delassus solve takes free bodies, on K"), "%s", output);
        continue;
      }
      ck_assert_msg(run(arguments) == 0, "%s: %s", arguments, output);
      ck_assert_msg(shows(notes[k]), "%s: %s", arguments, output);
    }
  ck_assert_int_eq(run("map indentation --step 10 --rows 2 --mu 0.1:0.2 -o @/m"), 0);
  ck_assert_int_ge(count_of(contents("m/map.csv"), ",auto,solved,"), 2);
}

TEST(matrices_are_problems) {
  static const char *const calls[] = {"solve", "info", "chart -r 1 -o @/c", "profile -r 1 -o @/p",
                                      "map --mu 0:2 --rows 3 -o @/m"};
  char arguments[400];
  write_file("W.txt", "2 0.5\n0.5 2\n");
  write_file("q.txt", "-2\n-3\n");
  for (int k = 0; k < 5; k++) {
    (void)snprintf(arguments, sizeof arguments, "%s --W %s/W.txt --q %s/q.txt --mu 0.5 --dim 2",
                   calls[k], directory, directory);
    ck_assert_msg(run(arguments) == 0, "%s: %s", arguments, output);
  }
  ck_assert_int_eq(count_of(contents("m/map.csv"), "0.5 (own),0.5,"), without_model);
}

/* An LCP is no contact problem: a line, and the rest goes on. */
TEST(lcps_are_skipped) {
  static const char *const calls[] = {"chart -r 1 %s -o @", "map %s -o @", "profile -r 1 %s -o @",
                                      "map --rows 2 --limit 0.05 %s jean-fig4 -o @",
                                      "profile -r 1 %s jean-fig4 -o @/p"};
  char arguments[200];
  for (int k = 0; k < 5; k++) {
    (void)snprintf(arguments, sizeof arguments, calls[k], "data/failures/l01-cycling.txt");
    ck_assert_msg(run(arguments) == 0, "%s: %s", arguments, output);
    ck_assert_int_eq(count_of(output, "l01-cycling.txt: skipped: an LCP"), 1);
    ck_assert_int_eq(count_of(output, "\n") > 1, k > 2);
  }
  ck_assert_int_eq(run("solve data/failures/l01-cycling.txt"), 0);
}

/* Ctrl-C in a long map: what is done is drawn. */
TEST(interrupted_map_is_drawn) {
  const char *program = getenv("DELASSUS_PROGRAM");
  char command[600];
  (void)snprintf(command, sizeof command,
                 "timeout -s INT 2 %s map jean-fig3 --against condition --samples 100000 -o %s "
                 ">%s/log 2>&1",
                 program ? program : "build/delassus", directory, directory);
  const int status = system(command);
  ck_assert(WIFEXITED(status) && WEXITSTATUS(status) == 124); /* ended by timeout */
  ck_assert_int_ge(count_of(contents("log"), has_gnuplot() ? "drawn: " : "gnuplot"), 1);
  ck_assert_int_lt(count_of(contents("map.csv"), "\n"), 1 + 7 * 7 * without_model);
  (void)contents("map.gp");
}

/* ---- profile, plot --------------------------------------------------------------------------- */

TEST(profile_counts) {
  ck_assert_int_eq(
      run("profile -r 1 jean-fig3 jean-fig4 data/failures/c11-gauss-seidel-cycle.txt -o @"), 0);
  ck_assert(shows("auto over the fastest single method, 3 problems"));
  ck_assert(shows("solved by auto alone 0, by others only 0 of 21"));
  const char *gp = contents("profile.gp");
  ck_assert_int_eq(count_of(gp, "\"auto\".' 3/3'"), 1);
  ck_assert_int_eq(count_of(gp, "\"nlgs\".' 2/3'"), 1); /* it cycles on one */
  ck_assert_int_eq(count_of(gp, "\"gauss-seidel\".' 2/2'"), 1);
  ck_assert_int_eq(count_of(contents("profile.csv"), "\n"),
                   1 + 7 * (2 * with_model + without_model));
  /* a proof that there is no solution is an answer */
  ck_assert_int_eq(run("profile -r 1 jean-fig3 data/failures/c04-squeezed.txt -o @"), 0);
  ck_assert_int_eq(count_of(contents("profile.gp"), "\"auto\".' 2/2'"), 1);
  ck_assert_int_eq(count_of(contents("profile.gp"), "\"newton\".' 1/2'"), 1);
}

TEST(solve_plots_its_history) {
  NEEDS_HDF5;
  ck_assert_int_eq(run("solve data/fclib/FC2D_SliderCrankLagrangian00000.hdf5 --plot @/h"), 0);
  ck_assert_int_ge(count_of(contents("h/history.csv"), "\n"), 2);
  ck_assert_int_ge(count_of(contents("h/history.gp"), "title \"nlgs\""), 1);
}

/* Without --out the files go into a new folder under TMPDIR, which is printed. */
TEST(a_new_folder_each_time) {
  static const char *const calls[] = {"chart jean-fig4 -r 1 -b 0.1", "map jean-fig4 --rows 1",
                                      "profile jean-fig4 -r 1 -b 0.1",
                                      "profile jean-fig4 -r 1 -b 0.1"};
  static const char *const files[] = {"chart.csv", "map.csv", "profile.csv", "profile.csv"};
  char folder[4][100], path[150];
  ck_assert_int_eq(setenv("TMPDIR", directory, 1), 0);
  for (int k = 0; k < 4; k++) {
    ck_assert_int_eq(run(calls[k]), 0);
    const char *at = strstr(output, "\nfiles: ");
    ck_assert_msg(at != NULL, "%s: %s", calls[k], output);
    ck_assert_int_eq(sscanf(at, "\nfiles: %99s", folder[k]), 1);
    ck_assert_int_eq(strncmp(folder[k], directory, strlen(directory)), 0);
    (void)snprintf(path, sizeof path, "%s/%s", folder[k] + strlen(directory) + 1, files[k]);
    ck_assert_int_ge(count_of(contents(path), "\n"), 2);
    for (int j = 0; j < k; j++)
      ck_assert_str_ne(folder[j], folder[k]);
  }
  ck_assert_int_eq(run("profile /no/such.hdf5"), 2); /* and leaves no empty one */
  (void)snprintf(path, sizeof path, "test $(ls %s | wc -l) = 4", directory);
  ck_assert_int_eq(system(path), 0);
}

TEST(wrong_use_is_2) {
  static const char *const wrong[] = {"chart",
                                      "chart a b",
                                      "chart /no/such.hdf5",
                                      "chart jean-fig3 --repeat 0",
                                      "chart jean-fig3 --limit x",
                                      "chart jean-fig3 -r 1 -o /dev/null/x",
                                      "map",
                                      "map /no/such.hdf5",
                                      "map jean-fig3 --mu 3:1",
                                      "map jean-fig3 --mu 3",
                                      "map jean-fig3 --rows 0",
                                      "map jean-fig3 --against time",
                                      "map jean-fig3 jean-fig4 --against rank",
                                      "chart jean-fig3 --step 3",
                                      "chart indentation --steps 3",
                                      "chart indentation --step 101",
                                      "chart jean-fig3 --HN x",
                                      "chart --W /no/such.npy --q /no/such.npy --mu 0",
                                      "info jean-fig3 --on K",
                                      "profile jean-fig3 --W x --q x",
                                      "map jean-fig3 --against mesh",
                                      "map indentation --method simplex -o /tmp",
                                      "map block-drop --method gauss-seidel -o /tmp",
                                      "map jean-moving --against mesh -o @",
                                      "map jean-fig3 --rows 2 -o /dev/null/x",
                                      "profile",
                                      "profile /no/such.hdf5 -o @",
                                      "profile jean-fig3 -o /dev/null/x",
                                      "solve Makefile --plot /dev/null/x",
                                      "solve data/failures/c20-scales.txt --plot @ --history @/h"};
  for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
    ck_assert_msg(run(wrong[k]) == 2, "delassus %s: %s", wrong[k], output);
    ck_assert_msg(shows("delassus"), "delassus %s says: %s", wrong[k], output);
  }
}

int main(void) {
  return run_tests("charts", make_directory, remove_directory);
}
