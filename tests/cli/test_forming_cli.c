/* test_forming_cli.c: the forming scenes in the program: exit statuses, tables, files. */
#include "program.h"
#include "run.h"

TEST(files) {
  char line[400];
  ck_assert_int_eq(
      run("scene indentation --mesh 6x5 --steps 20 --at 2,4.1 --method newton --out @/a/b"), 0);
  ck_assert_ptr_nonnull(strstr(output, "\n    2.0000"));
  ck_assert_ptr_nonnull(strstr(output, "\n    4.5000")); /* the step that reaches 4.1 */
  ck_assert_ptr_nonnull(strstr(output, "indentation by newton: solved at 10 of 10 mm"));
  ck_assert_int_eq(lines_of("a/b/force.csv", line, sizeof line), 22); /* rest, too */
  double travel, force;
  ck_assert_int_eq(sscanf(line, "%lf,%lf,", &travel, &force), 2);
  ck_assert(travel == 10 && force > 9000 && force < 16000);
  ck_assert_int_eq(lines_of("a/b/contact.csv", line, sizeof line), 1 + 3 * 7);
  ck_assert_int_eq(lines_of("a/b/series.pvd", line, sizeof line), 3 + 2 * 20 + 2);
  ck_assert_int_gt(lines_of("a/b/step_0020.vtu", line, sizeof line), 40);
  ck_assert_int_gt(lines_of("a/b/tools_0020.vtu", line, sizeof line), 40);
  ck_assert_int_gt(lines_of("a/b/mesh.gp", line, sizeof line), 10);
  ck_assert_int_gt(lines_of("a/b/plastic.dat", line, sizeof line), 30 * 6);
  ck_assert_int_gt(lines_of("a/b/force.gp", line, sizeof line), 5);
  ck_assert_int_eq(lines_of("a/b/pressure.dat", line, sizeof line), 20 * 8);
}

TEST(every_method) {
  static const char *const methods[] = {
      "lemke", "nlgs", "newton", "penalty", "gauss-seidel", "augmented-lagrangian", "auto"};
  double forces[7];
  for (int k = 0; k < 7; k++) {
    char arguments[200];
    (void)snprintf(arguments, sizeof arguments,
                   "scene --mesh 2x8 extrusion --steps 100 --mu 0.05 --method %s", methods[k]);
    ck_assert_int_eq(run(arguments), 0);
    const char *at = strstr(output, "  177.8000");
    ck_assert_ptr_nonnull(at);
    forces[k] = strtod(at + 10, NULL);
    ck_assert_double_eq_tol(forces[k], forces[0], (k == 3 ? 1e-2 : 1e-5) * forces[0]);
  }
}

/* a tolerance below rounding: not solved, 1, and the state reached is printed */
TEST(not_solved) {
  ck_assert_int_eq(run("scene indentation --mesh 4x4 --tol 1e-16"), 1);
  ck_assert_ptr_nonnull(strstr(output, "of 10 mm"));
  ck_assert_ptr_nonnull(strstr(output, "\nnot solved: "));
  ck_assert_int_eq(run("scene extrusion --limit 0.05 --out @/limited"), 1);
  ck_assert_ptr_nonnull(strstr(output, "extrusion by auto: time limit reached at "));
  char line[400];
  ck_assert_int_gt(lines_of("limited/force.csv", line, sizeof line), 2);
}

TEST(bad_options) {
  static const char *const bad[] = {
      "scene indentation --mesh 4",        "scene indentation --mesh 4x0",
      "scene indentation --mesh 4x4x4",    "scene indentation --steps 0",
      "scene indentation --mu x",          "scene indentation --method magic",
      "scene indentation --tol 0",         "scene indentation extrusion",
      "scene indentation --at -1",         "scene indentation --at 1,,2",
      "scene indentation --out /dev/null", "scene extrusion --nonsense",
      "scene extrusion --limit x"};
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++)
    ck_assert_msg(run(bad[k]) == 2, "%s: not 2", bad[k]);
  ck_assert_int_eq(run("scene indentation --help"), 0);
  ck_assert_int_eq(run("scene --list"), 0);
  ck_assert(strstr(output, "indentation") && strstr(output, "extrusion"));
}

int main(void) {
  return run_tests("forming_cli", make_directory, remove_directory);
}
