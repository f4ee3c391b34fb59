/*
 * test_moving_cli.c: runs the scenes of bodies that move in the program: exit statuses, summaries,
 * files, Ctrl-C, convergence.
 */
#define _XOPEN_SOURCE 700

#include "delassus/moving.h"
#include "program.h"
#include "run.h"

TEST(summary) { /* the numbers are those of the library */
  ck_assert_int_eq(run("scene block-drop -o @"), 0);
  ck_assert_ptr_nonnull(strstr(output, "block-drop: velocity form, theta 0.5, consistent mass"));
  ck_assert_ptr_nonnull(strstr(output, "finished after 300 of 300 steps, t = 0.03"));
  ck_assert_ptr_nonnull(strstr(output, "% of the "));
  dls_moving *moving;
  dls_moving_data d = {0};
  ck_assert_int_eq(dls_moving_create(&moving, "block-drop", NULL, NULL), DLS_OK);
  for (int k = 0; k < 300; k++)
    ck_assert_int_eq(dls_moving_step(moving, NULL), DLS_OK);
  dls_moving_get(moving, &d);
  ck_assert_double_eq_tol(number_after("impulse: normal "), d.impulse[0], 1e-7);
  ck_assert_double_eq_tol(number_after(", friction "), d.energy.friction, 1e-6);
  dls_moving_destroy(moving);
  ck_assert_double_le(number_after("worst step: energy "), 1e-13);
  if (!has_gnuplot()) return;
  double left = 0, width = 0; /* of the map of pressures, which hides no label beside it */
  const char *image = strstr(contents("map.svg"), "<image ");
  ck_assert(image && sscanf(image, "<image x='%lf' y='%*f' width='%lf'", &left, &width) == 2);
  ck_assert_msg(left > 109 && left + width < 851, "%g %g", left, width);
}

TEST(options) {
  ck_assert_int_eq(run("scene bar-impact --mesh 20 --mass lumped --courant 0.5 --theta 1"), 0);
  ck_assert_ptr_nonnull(strstr(output, "theta 1, lumped mass, e 0, mu 0, 20 elements, 1 cand"));
  ck_assert_ptr_nonnull(strstr(output, "180 steps")); /* 1.5 / (0.5 * 10 / 20 / 30) */
  ck_assert_int_eq(run("scene bar-impact --mesh 20 --law gap --steps 90 --method nlgs"), 0);
  ck_assert_ptr_nonnull(strstr(output, "gap form, theta 1, consistent mass"));
  ck_assert_int_eq(run("scene bar-impact --mesh 20 --e 0.5"), 0);
  ck_assert_ptr_nonnull(strstr(output, "e 0.5"));
  ck_assert_int_eq(run("scene --steps 20 two-blocks --mesh 8x4 --upper 5 --mu 0.5"), 0);
  ck_assert_ptr_nonnull(strstr(output, "mu 0.5, 52 elements, 6 candidates, 20 steps"));
  ck_assert_int_eq(
      run("scene jean-moving --law gap --amplitude 2e-6 --frequency 500 --steps 100 --tol 1e-10"),
      0);
  ck_assert_ptr_nonnull(strstr(output, "t = 0.004"));
  ck_assert_double_lt(number_after("friction "), 0);
}

TEST(files) {
  char line[400];
  ck_assert_int_eq(run("scene jean-moving --steps 40 --out @/a"), 0);
  ck_assert_int_eq(lines_of("a/energy.csv", line, sizeof line), 1 + 41);
  double t, x[9];
  ck_assert_int_eq(sscanf(line, "%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &t, x, x + 1, x + 2,
                          x + 3, x + 4, x + 5, x + 6, x + 7, x + 8),
                   10);
  ck_assert(t == 2 && x[0] == 0 && x[1] > 100);
  ck_assert_double_le(fabs(x[8]), 1e-12 * x[1]); /* the balance of the energies: 0 at the start */
  ck_assert_int_eq(lines_of("a/contact.csv", line, sizeof line), 1 + 40 * 16);
  int candidate;
  char state[10];
  ck_assert_int_eq(
      sscanf(line, "%lf,%d,%lf,%lf,%lf,%lf,%9s", &t, &candidate, x, x + 1, x + 2, x + 3, state), 7);
  ck_assert(t == 2 && candidate == 16 && x[0] > 0);
  ck_assert(strcmp(state, "slip") == 0 || strcmp(state, "stick") == 0);
  ck_assert_int_eq(lines_of("a/series.pvd", line, sizeof line), 3 + 41 + 2);
  ck_assert_int_gt(lines_of("a/step_0040.vtu", line, sizeof line), 40);
  ck_assert_int_eq(lines_of("a/map.dat", line, sizeof line), 1 + 40 * 16);
  ck_assert_int_gt(lines_of("a/loop.dat", line, sizeof line), 40);
  const char *scripts[] = {"a/energy.gp", "a/map.gp", "a/loop.gp"};
  for (int k = 0; k < 3; k++)
    ck_assert_int_gt(lines_of(scripts[k], line, sizeof line), 8);
  ck_assert_int_eq(run("scene bar-impact --mesh 10 -o @/b"), 0);
  ck_assert_int_gt(lines_of("b/bar.dat", line, sizeof line), 40);
  ck_assert_int_gt(lines_of("b/bar.gp", line, sizeof line), 8);
}

/* Ctrl-C, or the signal of a batch system, after a while: exit status 1, whole files of the steps
 * that were done, and no temporary ones. */
TEST_EACH(interrupted, 0, 4) {
  static const char *const signals[] = {"INT", "TERM", "HUP", "XCPU"};
  const char *program = getenv("DELASSUS_PROGRAM");
  char command[400], line[400];
  (void)snprintf(command, sizeof command,
                 "timeout -s %s 1 %s scene bar-fixed --mesh 2000 -o %s/c "
                 ">%s/text 2>&1; test $? -eq 124 -a -z \"$(find %s -name '.delassus*')\"",
                 signals[_i], program ? program : "build/delassus", directory, directory,
                 directory);
  ck_assert_int_eq(system(command), 0);
  const int steps = lines_of("c/energy.csv", line, sizeof line) - 3;
  ck_assert_msg(strncmp(line, "# cancelled after ", 18) == 0, "%s", line);
  ck_assert(steps > 0 && steps < 26666);
  ck_assert_int_eq(lines_of("c/contact.csv", line, sizeof line), 1 + steps);
  (void)lines_of("c/series.pvd", line, sizeof line);
  ck_assert_str_eq(line, "</VTKFile>\n");
  ck_assert_int_gt(lines_of("c/energy.gp", line, sizeof line), 8);
  char wanted[80];
  (void)snprintf(wanted, sizeof wanted, "cancelled after %d of ", steps);
  FILE *text = open_file("text", "r");
  output[fread(output, 1, sizeof output - 1, text)] = '\0';
  (void)fclose(text);
  ck_assert_msg(strstr(output, wanted) != NULL, "%s: %s", wanted, output);
}

TEST(bad_options) {
  static const char *const bad[] = {
      "scene bar-impact --law gaps",   "scene bar-impact --mass heavy",
      "scene bar-impact --theta 0.4",  "scene bar-impact --theta 1.1",
      "scene bar-impact --theta x",    "scene bar-impact --e 1.5",
      "scene bar-impact --courant -1", "scene bar-impact --steps 0",
      "scene bar-impact --mesh 0",     "scene bar-impact --mesh 4x",
      "scene bar-impact --mesh 4x4x4", "scene bar-impact --law path",
      "scene bar-impact --mu -1",      "scene bar-impact --method magic",
      "scene bar-impact --tol x",      "scene two-blocks --upper 0",
      "scene jean-moving --law x",     "scene jean-moving --amplitude x",
      "scene bar-impact bar-fixed",    "scene bar-impact --out /dev/null",
      "scene bar-impact --nonsense",   "scene bar-impact --law gap --theta 0.5"};
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++)
    ck_assert_msg(run(bad[k]) == 2, "%s: not 2: %s", bad[k], output);
  ck_assert_int_eq(run("scene two-blocks --help"), 0);
  for (int k = 0; dls_moving_name(k); k++)
    ck_assert_ptr_nonnull(strstr(output, dls_moving_name(k)));
  ck_assert_int_eq(run("scene --list"), 0);
  for (int k = 0; dls_moving_name(k); k++)
    ck_assert_ptr_nonnull(strstr(output, dls_moving_description(k)));
}

/* Too little friction for the shear: the upper block has no equilibrium, and the run says so. */
TEST(slides_away) {
  ck_assert_int_eq(run("scene two-blocks --mu 0.1"), 1);
  const double steps = number_after("after ");
  ck_assert(steps >= 20 && steps < 40);
}

int main(void) {
  return run_tests("moving_cli", make_directory, remove_directory);
}
