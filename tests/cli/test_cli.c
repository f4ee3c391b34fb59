/* test_cli.c: the program `delassus` as a user meets it: exit statuses, JSON, files. */
#define _GNU_SOURCE
#include <sys/wait.h>
#include <unistd.h>

#include "delassus.h"
#include "failures.h"
#include "fclib_file.h"
#include "program.h"
#include "run.h"

static int prints(const char *text) {
  return strstr(output, text) != NULL;
}

static char *read_text(const char *name, char *text, size_t room) {
  (void)snprintf(text, room, "%s", contents(name));
  return text;
}

/* The program ends well and prints the text. */
static void says(const char *arguments, const char *text) {
  ck_assert_int_eq(run(arguments), 0);
  ck_assert_msg(prints(text), "%s: no \"%s\" in %s", arguments, text, output);
}

TEST(help_and_version) {
  says("--help", "Usage: delassus");
  ck_assert_int_eq(run("--version"), 0);
  ck_assert_str_eq(output, "delassus " DLS_VERSION "\n");
  ck_assert_int_eq(run("-V"), 0);
  says("scene --help", "--weighted");
  says("solve -h", "--max-iter");
  says("solve -h", "--threads");
  ck_assert_int_eq(run("scene --list"), 0);
  ck_assert(prints("jean-fig3") && prints("jean-fig4"));
}

/* The problems of the catalogue, contact and LCP, in text. */
/* A large sparse M: active sets with sparse factors. An obstacle of 1 below a string of 2500 nodes
 * that is pulled down, y = M z + q; then M = -I, q = -1, which has no solution. */
TEST(large_sparse_lcp) {
  enum { n = 2500, room = 200000 };
  char *M = malloc(room), *q = malloc(room), path[128];
  size_t m = (size_t)snprintf(
      M, room, "%%%%MatrixMarket matrix coordinate real symmetric\n%d %d %d\n", n, n, 2 * n - 1);
  size_t k = (size_t)snprintf(q, room, "%%%%MatrixMarket matrix array real general\n%d 1\n", n);
  for (int i = 1; i <= n; i++) {
    m += (size_t)snprintf(M + m, room - m, "%d %d 2\n", i, i);
    if (i < n) m += (size_t)snprintf(M + m, room - m, "%d %d -1\n", i + 1, i);
    k += (size_t)snprintf(q + k, room - k, "%.17g\n", i == 1 || i == n ? 1e-5 - 1 : 1e-5);
  }
  write_file("M.mtx", M);
  write_file("q.mtx", q);
  ck_assert_int_eq(run("solve --lcp @/M.mtx @/q.mtx --json --output=@/z.mtx"), 0);
  ck_assert(prints("\"principal\"") && prints("\"solved\"") && number_of("residual") <= 1e-12);
  int rows, cols, touches = 0;
  double *z;
  (void)snprintf(path, sizeof path, "%s/z.mtx", directory);
  ck_assert_int_eq(dls_mtx_read(path, &rows, &cols, &z, NULL), DLS_OK);
  ck_assert(rows == n && cols == 1);
  for (int i = 0; i < n; i++) { /* ends at height 1 */
    const double y = 2 * z[i] - (i > 0 ? z[i - 1] : 1) - (i < n - 1 ? z[i + 1] : 1) + 1e-5;
    ck_assert(z[i] >= 0 && y >= -1e-14 && (z[i] == 0 || fabs(y) < 1e-14));
    touches += z[i] == 0;
  }
  ck_assert(touches > n / 2 && touches < n);
  dls_mtx_free(z);
  ck_assert_int_eq(run("solve --lcp @/M.mtx @/q.mtx"), 0);
  ck_assert(prints("LCP of 2500 unknowns") && prints("principal: solved") &&
            prints("factorisation"));
  /* an entry that is no number, a size that does not fit, limits */
  ck_assert_int_eq(run("solve --lcp @/M.mtx @/q.mtx --method nlgs"), 2);
  ck_assert_int_eq(run("solve --lcp @/M.mtx @/M.mtx"), 2);
  ck_assert_int_eq(run("solve --lcp @/M.mtx @/q.mtx --max-iter 1 --tol 1e-14"), 1);
  m = (size_t)snprintf(M, room, "%%%%MatrixMarket matrix coordinate real general\n%d %d %d\n", n, n,
                       n);
  for (int i = 1; i <= n; i++)
    m += (size_t)snprintf(M + m, room - m, "%d %d -1\n", i, i);
  write_file("M.mtx", M);
  ck_assert_int_eq(run("solve --lcp @/M.mtx @/q.mtx"), 1);
  ck_assert(prints("active sets stopped without an answer") && prints("--method lemke"));
  free(M);
  free(q);
}

TEST(text_problems) {
  says("solve " TEST_DATA "/failures/c24-runaway.txt", "3 contacts, text");
  ck_assert_int_eq(run("solve --json " TEST_DATA "/failures/c20-scales.txt"), 0);
  ck_assert(number_of("residual") <= 1e-8 && number_of("contacts") == 2);
  ck_assert_int_eq(run("solve " TEST_DATA "/failures/c03-jam-above.txt"), 1);
  says("info " TEST_DATA "/failures/c20-scales.txt", "positive definite");
  says("solve " TEST_DATA "/failures/l01-cycling.txt", "LCP of");
  ck_assert_int_eq(run("solve " TEST_DATA "/failures/l01-cycling.txt -m newton"), 2);
  ck_assert_int_eq(run("solve " TEST_DATA "/failures/l05-no-solution.txt"), 1);
  ck_assert_int_eq(run("info " TEST_DATA "/failures/l01-cycling.txt"), 2);
  ck_assert_int_eq(run("solve Makefile"), 2);
}

/* Plans, steps left out, and what auto did in words. */
TEST(plans_and_explanations) {
  static const char file[] = "solve " TEST_DATA "/failures/c25-unsymmetric.txt";
  char text[300];
  const char *const with[] = {"--plan anderson:9,newton:3", "--explain",
                              "--without homotopy --json", "--explain --without homotopy,scatter"};
  static const int ends[] = {1, 0, 0, 0};
  for (int k = 0; k < 4; k++) {
    (void)snprintf(text, sizeof text, "%s %s", file, with[k]);
    ck_assert_msg(run(text) == ends[k] || k == 3, "%s: %s", text, output);
    if (k == 0)
      ck_assert(prints("    newton: 3 steps, ") && prints(": its iterations are spent\n"));
    if (k == 1) ck_assert(prints("    regime elastic (W is dense, 2 candidates): "));
    if (k == 1) ck_assert(prints(" s of CPU, ") && prints(", on a copy: the reactions run away\n"));
    if (k == 2) ck_assert(prints("\"step\": \"scatter\", \"reason\": \"solved\", \"cpu_sec"));
    if (k == 2) ck_assert(prints("\"regime\": \"elastic\"") && !prints("homotopy"));
    if (k == 3) ck_assert(!prints("homotopy") && !prints("scatter"));
  }
  static const char *const wrong[] = {
      "--plan newtn",        "--plan newton:0",  "--without newton:3", "--plan newton -m nlgs",
      "--explain -m newton", "--explain --json", "--explain --quiet",  "--plan ''"};
  for (int k = 0; k < 8; k++) {
    (void)snprintf(text, sizeof text, "%s %s", file, wrong[k]);
    ck_assert_msg(run(text) == 2, "%s: %s", text, output);
  }
  ck_assert_int_eq(run("solve " TEST_DATA "/failures/l01-cycling.txt --explain"), 2);
}

/* What W does not determine is said beside the reactions, in words, in r.csv and as JSON; --forces
 * chooses the least: of two contacts that share everything a half each. */
TEST(forces_that_are_not_determined) {
  static const char all[] = "2 self-stresses: positions determine the sum on each body, not single "
                            "reactions; ";
  char text[200];
  (void)snprintf(text, sizeof text, "\n  %s--forces=least gives the least\n", all);
  ck_assert_int_eq(run("solve " TEST_DATA "/failures/c05-hyperstatic.txt"), 0);
  ck_assert(strstr(output, text) != NULL);
  (void)snprintf(text, sizeof text, "  %sthese are the least\n", all);
  ck_assert_int_eq(
      run("solve " TEST_DATA "/failures/c05-hyperstatic.txt --forces least -q --print"), 0);
  ck_assert(strstr(output, text) != NULL);
  ck_assert(strstr(output, "0 stick              0            0.5         -0.125 ") != NULL);
  ck_assert(strstr(output, "1 stick              0            0.5         -0.125 ") != NULL);
  ck_assert_int_eq(run("solve " TEST_DATA "/failures/c05-hyperstatic.txt --forces=least --json"),
                   0);
  ck_assert(strstr(output, "\"forces\": \"least\",\n  \"freedom\": 2,") != NULL);
  ck_assert_int_eq(run("solve " TEST_DATA "/failures/c04-squeezed.txt --json"), 1);
  ck_assert(strstr(output, "\"forces\": \"any\",\n  \"freedom\": null,") != NULL);
  ck_assert_int_eq(run("solve " TEST_DATA "/failures/c20-scales.txt"), 0);
  ck_assert(strstr(output, "self-stress") == NULL);
  ck_assert_int_eq(run("solve " TEST_DATA "/failures/c20-scales.txt --forces=most"), 2);
  ck_assert(strstr(output, "--forces: 'most' is none of any, least") != NULL);
}

/* A block between two walls jams, sum r_t = 10, or falls, r = 0: positions determine the sum. */
TEST(sums_of_a_jammed_block) {
  write_file("jam.txt", "title jam\ncontact 2 4\nW\n"
                        "2.5 1.5 -0.5 1.5 -2.5 -1.5 0.5 -1.5\n1.5 2.5 -1.5 2.5 -1.5 -0.5 1.5 -0.5\n"
                        "-0.5 -1.5 2.5 -1.5 0.5 1.5 -2.5 1.5\n1.5 2.5 -1.5 2.5 -1.5 -0.5 1.5 -0.5\n"
                        "-2.5 -1.5 0.5 -1.5 2.5 1.5 -0.5 1.5\n-1.5 -0.5 1.5 -0.5 1.5 2.5 -1.5 2.5\n"
                        "0.5 1.5 -2.5 1.5 -0.5 -1.5 2.5 -1.5\n-1.5 -0.5 1.5 -0.5 1.5 2.5 -1.5 2.5\n"
                        "q 0 -10 0 -10 0 -10 0 -10\nmu 0.5 0.5 0.5 0.5\n");
  ck_assert_int_eq(run("solve @/jam.txt"), 0);
  ck_assert(!prints("the sum on each body is determined"));
  ck_assert(!prints("self-stress") || prints("positions determine the sum on each body"));
}

/* The last line names the part of the certificate that rounding limits. */
TEST(to_rounding_names_its_part) {
  write_file("soft.txt", "title soft\ncontact 1 2\nW\n1e9 -1e9\n-1e9 1000000001\n"
                         "q -1.1 -1.3\nmu 0 0\n");
  ck_assert_int_eq(run("solve @/soft.txt"), 0);
  ck_assert(prints("solved to rounding: positions to ") && !prints("forces to"));
}

/* --prove: the last line says what is proved of the answer, or which contact is on a border. */
TEST(proofs) {
  static const char *const last[][2] = {
      {"c28-nearly-singular", "\nsolved (proved: reactions within "},
      {"c17-four-solutions", "\nsolved (proved: reactions exact)\n"},
      {"c02-critical", "\nsolved (not proved: contact 0 is at the border between "}};
  for (int k = 0; k < 3; k++) {
    char text[200];
    (void)snprintf(text, sizeof text, "solve --prove " TEST_DATA "/failures/%s.txt", last[k][0]);
    says(text, last[k][1]);
  }
  says("solve --json --prove " TEST_DATA "/failures/c28-nearly-singular.txt",
       "\"proof\": \"proved: reactions within ");
  ck_assert_double_le(number_of("radius"), 1e-10);
  ck_assert_double_gt(number_of("radius"), 0);
  says("info " TEST_DATA "/failures/c28-nearly-singular.txt", "  answer of auto: proved: ");
  says("info --json " TEST_DATA "/failures/c28-nearly-singular.txt", "\"proved_radius\": ");
  ck_assert_double_le(number_of("proved_radius"), 1e-10);
  ck_assert_int_eq(run("solve --prove " TEST_DATA "/failures/l01-cycling.txt"), 2);
  ck_assert_int_eq(run("solve --prove " TEST_DATA "/failures/c04-squeezed.txt"), 1);
  ck_assert(prints("not solved: ") && !prints("proved: reactions"));
}

/* The rows of --history: iterations and time go on, the last row is what --json says. */
TEST(history_of_a_solve) {
  static const char *const methods[] = {"auto", "nlgs", "lemke", "newton"};
  for (int k = 0; k < 4; k++) {
    static char text[200000];
    char arguments[300];
    (void)snprintf(arguments, sizeof arguments,
                   "solve --json -m %s " TEST_DATA "/failures/c15-slow-splitting.txt --history %s",
                   methods[k], path_of("h.csv"));
    ck_assert_int_eq(run(arguments), 0);
    char *row = strchr(read_text("h.csv", text, sizeof text), '\n');
    ck_assert_int_eq(strncmp(text, "iteration,cpu_seconds,residual,stage\n", 37), 0);
    double before = 0, cpu = 0, iteration = 0, seconds = 0, residual = -1;
    int rows = 0;
    for (; row && row[1]; row = strchr(row + 1, '\n'), rows++) {
      char stage[40];
      ck_assert_int_eq(sscanf(row + 1, "%lf,%lf,%lf,%39s", &iteration, &seconds, &residual, stage),
                       4);
      ck_assert(iteration >= before && seconds >= cpu);
      before = iteration;
      cpu = seconds;
    }
    ck_assert_int_ge(rows, 2);
    ck_assert(residual == number_of("residual") &&
              (k == 3 || iteration == number_of("iterations")));
  }
  ck_assert_int_eq(run("solve Makefile --history no/such/h.csv"), 2);
}

/* The iterations of --history never run back, from the first row to the last. */
static void expect_rising(const char *file) {
  static char text[2000000];
  char arguments[300];
  (void)snprintf(arguments, sizeof arguments, "solve " TEST_DATA "/%s --history %s", file,
                 path_of("h.csv"));
  ck_assert_int_le(run(arguments), 1);
  int before = 0;
  for (char *row = strchr(read_text("h.csv", text, sizeof text), '\n'); row && row[1];
       row = strchr(row + 1, '\n')) {
    const int iteration = (int)strtol(row + 1, NULL, 10);
    ck_assert_msg(iteration >= before, "%s: %d, then %d", file, before, iteration);
    before = iteration;
  }
}

TEST(histories_never_run_back) {
  static char names[200][64];
  const int count = failures_list(TEST_DATA "/failures", names, 200);
  char file[100];
  ck_assert_int_gt(count, 0);
  for (int k = 0; k < count; k++) {
    if (names[k][0] != 'c') continue; /* the others are LCPs */
    (void)snprintf(file, sizeof file, "failures/%.63s.txt", names[k]);
    expect_rising(file);
  }
  for (int k = 0; k < fclib_count; k++) {
    (void)snprintf(file, sizeof file, "fclib/%s.hdf5", fclib_files[k]);
    if (WITH_HDF5) expect_rising(file);
  }
}

TEST(info_lists_all_solutions) {
  says("info " TEST_DATA "/failures/c01-three-solutions.txt",
       "3 isolated, 0 continua\n    r = 0 0");
  ck_assert(prints("below friction 1 each load has one solution"));
  says("info " TEST_DATA "/failures/c05-hyperstatic.txt",
       "0 isolated, 1 continuum\n    r = [0,1] ");
  says("info " TEST_DATA "/failures/c03-jam-above.txt", "no solution (proved");
  says("info --json " TEST_DATA "/failures/c01-three-solutions.txt", "{\"r\": [0, 0], \"low\":");
  ck_assert(number_of("fold") == 1 && number_of("isolated") == 3);
  ck_assert(number_of("continua") == 0 && prints("\"no_solution_proved\": false"));
  says("info --json " TEST_DATA "/failures/c03-jam-above.txt", "\"no_solution_proved\": true");
  says("info --json " TEST_DATA "/failures/c16-three-solutions-3d.txt", "\"solutions\": null");
}

TEST(bad_usage_is_2) {
  static const char *const wrong[] = {"",
                                      "frobnicate",
                                      "scene",
                                      "scene no-such-scene",
                                      "scene jean-fig3 --method simplex",
                                      "scene jean-fig3 --accel fast",
                                      "scene jean-fig3 --accel aitken --method lemke",
                                      "solve Makefile -a fast",
                                      "solve --lcp Makefile Makefile --accel anderson",
                                      "scene jean-fig3 --tol -1",
                                      "scene jean-fig3 --mesh 16",
                                      "scene jean-fig3 --mesh 0x8",
                                      "scene jean-fig3 --mesh 99999x99999",
                                      "scene jean-fig3 --mu -1",
                                      "scene jean-fig3 --young 0",
                                      "scene jean-fig3 --poisson 0.5",
                                      "scene jean-fig3 --load 5e8",
                                      "scene jean-fig3 --load 5e8:5e8",
                                      "scene jean-fig3 --load 5e8,5e8:5e8",
                                      "scene jean-fig3 --load 5e8,5e8,5e8,5e8",
                                      "scene jean-fig3 --load 5e8,nan",
                                      "scene jean-fig3 --order sideways",
                                      "scene jean-fig3 --tol nan",
                                      "scene jean-fig3 --max-iter 0",
                                      "scene jean-fig3 --frobnicate",
                                      "scene jean-fig3 jean-fig4",
                                      "scene jean-fig3 --reference /no/such.csv",
                                      "scene jean-fig3 --out /dev/null/x",
                                      "scene jean-fig3 --save /no/such/place.hdf5",
                                      "solve",
                                      "solve /no/such/file.hdf5",
                                      "solve Makefile",
                                      "solve tests",
                                      "solve --lcp Makefile",
                                      "solve --method gauss-seidel Makefile",
                                      "solve --lcp Makefile Makefile",
                                      "solve --tol x Makefile",
                                      "solve --facets 8 data/fclib/FC3D_Example1.hdf5",
                                      "solve --lcp -f 8 Makefile Makefile",
                                      "solve -m lemke -f 7 data/fclib/FC3D_Example1.hdf5",
                                      "info",
                                      "info --frobnicate x",
                                      "info --limit 0 data/fclib/FC3D_Example1.hdf5",
                                      "info data/fclib/FC3D_Example1.hdf5 Makefile",
                                      "info /no/such/file.hdf5",
                                      "info Makefile"};
  for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
    ck_assert_msg(run(wrong[k]) == 2, "delassus %s", wrong[k]);
    ck_assert_msg(prints("delassus"), "delassus %s says: %s", wrong[k], output);
  }
}

TEST(accelerated_scene) {
  ck_assert_int_eq(run("scene jean-fig3 --json --method nlgs"), 0);
  const double sweeps = number_of("iterations");
  ck_assert_int_eq(run("scene jean-fig3 --json --accel aitken"), 0);
  ck_assert(prints("\"method\": \"nlgs\"")); /* which --accel is for */
  ck_assert_int_eq(run("scene jean-fig3 --json -a anderson"), 0);
  ck_assert(number_of("iterations") < sweeps);
}

TEST(auto_says_what_it_did) {
  NEEDS_HDF5;
  ck_assert_int_eq(run("scene jean-fig3 --tol 1e-14"), 0);
  ck_assert(prints("reactions, auto: solved") && prints("    anderson: 15 sweeps, resi"));
  ck_assert(prints("    newton: ") && prints(" step") && prints(" factorisation"));
  ck_assert_int_eq(run("scene jean-fig3 --json"), 0);
  ck_assert(prints("\"stages\": [\n    {\"method\": \"nlgs\", \"iterations\": 15,"));
  ck_assert_int_eq(run("solve data/fclib/FC3D_Example1.hdf5"), 0);
  ck_assert(prints("auto: solved") && prints("    sweeps: 1 sweep,"));
  ck_assert_int_eq(run("solve -j -m newton data/fclib/FC3D_Example1.hdf5"), 0);
  ck_assert(!prints("stages"));
}

/* Sweeps that circle: the candidate at fault is named. */
TEST(names_the_unsettled) {
  ck_assert_int_eq(run("solve -m nlgs data/failures/c11-gauss-seidel-cycle.txt"), 1);
  ck_assert(prints("  the error is at candidate 0 (100 % of its square); sweeps circle here\n"));
  ck_assert_int_eq(run("solve --json -m nlgs data/failures/c11-gauss-seidel-cycle.txt"), 1);
  ck_assert(prints("\"unsettled\": [0],\n  \"unsettled_share\": 1,\n  \"sweep_growth\": 1"));
  ck_assert_int_eq(run("solve --json data/failures/c11-gauss-seidel-cycle.txt"), 0);
  ck_assert(!prints("unsettled"));
}

/* The wedge that jams. */
TEST(no_solution_likely_is_1) {
  NEEDS_HDF5;
  const double W[4] = {1, 1, 1, 1}, q[2] = {-2, 0}, mu[1] = {2};
  const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  ck_assert_int_eq(dls_fclib_write_local(path_of("jam.hdf5"), &p, "", NULL, NULL, NULL), DLS_OK);
  ck_assert_int_eq(run("solve @/jam.hdf5"), 1);
  ck_assert(prints("auto: no solution likely") && prints("augmented-lagrangian: "));
  ck_assert(prints(" augmentations, residual "));
  ck_assert_int_eq(run("solve --json @/jam.hdf5"), 1);
  ck_assert(prints("\"no_solution_likely\""));
  ck_assert(prints(
      "\"verdict\": \"no solution likely\",\n  \"next\": \"The reactions grow without bound "));
  ck_assert(!prints("\"ray\""));
  ck_assert_int_eq(run("solve --json @/jam.hdf5 -m augmented-lagrangian"), 1);
  ck_assert(prints("\"stalled\""));
  ck_assert_int_eq(run("solve --proof @/jam.hdf5"), 1);
  ck_assert(prints("  no solution likely. The reactions grow without bound ") &&
            prints("  ray:\n    0: "));
  ck_assert_int_eq(run("solve -p -m lemke @/jam.hdf5"), 1);
  ck_assert(prints("lemke: secondary ray") && prints("  ray:\n    0: "));
  ck_assert(prints("  ray: Lemke's method stopped without an answer. A solution may or "));
  ck_assert_int_eq(run("solve -pj -m lemke @/jam.hdf5"), 1);
  ck_assert(prints("\"verdict\": \"ray: Lemke's method stopped without an answer\""));
  ck_assert(prints("\"ray\": [") && !prints("\"farkas"));
}

/* Two walls closer than what is between them, and the same with rows that add up to e instead of
 * 0. */
TEST(proofs_are_printed) {
  NEEDS_HDF5;
  double W[16] = {1, 0, -1, 0, 0, 1, 0, 0, -1, 0, 1, 0, 0, 0, 0, 1}, q[4] = {-1, 0, -1, 0};
  const double mu[2] = {0, 0};
  const dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu};
  char path[128];
  (void)snprintf(path, sizeof path, "%s/walls.hdf5", directory);
  ck_assert_int_eq(dls_fclib_write_local(path, &p, "", NULL, NULL, NULL), DLS_OK);
  ck_assert_int_eq(run("solve -m lemke @/walls.hdf5"), 1);
  ck_assert(prints("  no solution (proved). No reactions keep all contacts apart. "));
  ck_assert(!prints("proof v:"));
  ck_assert_int_eq(run("solve -m lemke --proof @/walls.hdf5"), 1);
  ck_assert(prints("  proof v:\n    0: 1\n    1: 1\n"));
  ck_assert_int_eq(run("solve -m lemke --proof --json @/walls.hdf5"), 1);
  ck_assert(prints("\"verdict\": \"no solution (proved)\"") && prints("\"farkas\": [1, 1]"));
  W[10] = 1 + 0x1p-48;
  ck_assert_int_eq(dls_fclib_write_local(path, &p, "", NULL, NULL, NULL), DLS_OK);
  ck_assert_int_eq(run("solve -m lemke --proof @/walls.hdf5"), 1);
  ck_assert(prints("  ray (to rounding). Up to rounding there is no solution, "));
  ck_assert(prints("  v, a proof up to rounding:\n    0: ") && !prints("proved"));
  ck_assert_int_eq(run("solve -m lemke --proof --json @/walls.hdf5"), 1);
  ck_assert(prints("\"ray (to rounding)\"") && prints("\"farkas_to_rounding\": ["));
  /* LCPs: no solution; a true ray, l12 of data/failures; rows that add up to e */
  write_file("q.mtx", "%%MatrixMarket matrix array real general\n2 1\n-1\n-1\n");
  write_file("M.mtx", "%%MatrixMarket matrix array real general\n2 2\n1\n-1\n-1\n1\n");
  ck_assert_int_eq(run("solve --lcp -p @/M.mtx @/q.mtx"), 1);
  ck_assert(prints("  no solution (proved). No z >= 0 has M z + q >= 0. "));
  ck_assert(prints("  proof v:\n    0: 1\n    1: 1\n"));
  ck_assert_int_eq(run("solve --lcp -j -p @/M.mtx @/q.mtx"), 1);
  ck_assert(prints("\"no_solution\"") && prints("\"farkas\": [1, 1]"));
  write_file("M.mtx",
             "%%MatrixMarket matrix array real general\n2 2\n1\n-1\n-1\n1.00000000000001\n");
  ck_assert_int_eq(run("solve --lcp -p @/M.mtx @/q.mtx"), 1);
  ck_assert(prints("  ray (to rounding). ") && prints("  v, a proof up to rounding:\n    0: "));
  write_file("M.mtx", "%%MatrixMarket matrix array real general\n2 2\n-1\n1\n0\n-1\n");
  write_file("q.mtx", "%%MatrixMarket matrix array real general\n2 1\n1\n-1\n");
  ck_assert_int_eq(run("solve --lcp -p @/M.mtx @/q.mtx"), 1);
  ck_assert(prints("  ray: Lemke's method stopped without an answer. ") && prints("  ray:\n    "));
}

/* A rigid body, M = diag(4, 4, 1), on the ground: v = (3, -2, 0) becomes (3, 0, 0), r = 8, without
 * friction. The file is solved as bodies; x comes from M, the file written holds r and u. */
TEST(a_file_of_bodies) {
  NEEDS_HDF5;
  static const int diagonal[] = {0, 1, 2, 3}, p[] = {0, 1};
  static const double M[] = {4, 4, 1}, one[] = {1}, f[] = {12, -8, 0}, g[2] = {0}, mu[] = {0};
  const dls_model body = {.d = 2,
                          .n = 3,
                          .nodes = 1,
                          .operator_kind = DLS_STIFFNESS_SPARSE,
                          .factorization = DLS_LU,
                          .Ks = {3, 3, diagonal, diagonal, M},
                          .HN = {3, 1, p, diagonal + 1, one},
                          .HT = {3, 1, p, diagonal, one}};
  ck_assert_int_eq(dls_fclib_write_global(path_of("body.hdf5"), &body, f, g, mu, "a body", NULL,
                                          NULL, NULL, NULL),
                   DLS_OK);
  ck_assert_int_eq(run("solve @/body.hdf5 --print --csv @/csv --out @/solved.hdf5"), 0);
  ck_assert(prints("1 rigid body") && !prints("reduced from"));
  ck_assert_str_eq(contents("csv/x.csv"), "unknown_from_0,x\n0,3\n1,0\n2,0\n");
  dls_fclib *file;
  const double *r, *u;
  ck_assert_int_eq(dls_fclib_read(&file, path_of("solved.hdf5"), NULL), DLS_OK);
  ck_assert_int_eq(dls_fclib_solution(file, &r, &u, NULL), DLS_OK);
  ck_assert(r[0] == 8 && r[1] == 0 && u[0] == 0 && u[1] == 3);
  dls_fclib_destroy(file);
}

TEST(scene_writes_its_files) {
  ck_assert_int_eq(run("scene jean-fig3 --method lemke --weighted --json --out @/a/b"), 0);
  ck_assert(prints("\"status\": \"solved\"") && prints("\"method\": \"lemke\""));
  ck_assert(number_of("residual") <= 1e-12);
  ck_assert_int_eq((int)number_of("contacts"), 16);
  ck_assert_int_eq((int)number_of("dimension"), 2);
  static char text[100000];
  (void)read_text("a/b/contact.csv", text, sizeof text);
  ck_assert(!strncmp(text, "candidate_from_0,x,y,ut,un,rt,rn,status,rt_eq,rn_eq,cell\n", 57));
  int lines = 0;
  for (const char *c = text; *c; c++)
    lines += *c == '\n';
  ck_assert_int_eq(lines, 17);
  ck_assert_str_eq(read_text("a/b/result.json", text, sizeof text), output);
  ck_assert_ptr_nonnull(
      strstr(read_text("a/b/jean-fig3.vtu", text, sizeof text), "UnstructuredGrid"));
  static const char *const pictures[] = {"deformed.dat", "deformed.gp", "reactions.dat",
                                         "reactions.gp"};
  for (int k = 0; k < 4; k++) {
    char path[128];
    (void)snprintf(path, sizeof path, "%s/a/b/%s", directory, pictures[k]);
    ck_assert_msg(access(path, R_OK) == 0, "%s", path);
  }
  /* the pictures' states and arrows are those of contact.csv */
  static char rows[100000];
  const char *state = strchr(read_text("a/b/contact.csv", text, sizeof text), '\n') + 1;
  const char *row = strchr(read_text("a/b/reactions.dat", rows, sizeof rows), '\n') + 1;
  int count[3] = {0};
  for (int c = 0; c < 16; c++, state = strchr(state, '\n') + 1, row = strchr(row, '\n') + 1) {
    const int drawn = *(strchr(row, '\n') - 1) - '0';
    static const char *const words[] = {"free,", "slip,", "stick,"};
    ck_assert(drawn >= 0 && drawn < 3);
    for (int k = 0; k < 7; k++)
      state = strchr(state, ',') + 1;
    ck_assert(!strncmp(state, words[drawn], strlen(words[drawn])));
    count[drawn]++;
  }
  ck_assert(count[0] == 5 && count[1] + count[2] == 11 && count[2] > 0);
  (void)read_text("a/b/deformed.dat", rows, sizeof rows);
  for (char *block = strstr(rows, "\n\n\n"), *k = NULL; block; block = k) {
    k = strstr(block += 3, "NaN NaN"); /* ends a block of arrows */
    if (!k) break;
    int arrows = 0;
    for (const char *at = block; at < k; at++)
      arrows += *at == '\n';
    count[arrows == count[1] ? 1 : arrows == count[2] ? 2 : 0] -= arrows;
    k = strstr(k, "\n\n\n");
  }
  ck_assert(count[1] == 0 && count[2] == 0 && count[0] == 5 - 1); /* P r of node 5: an arrow */
}

TEST(scene_on_the_displacements) {
  ck_assert_int_eq(run("scene jean-fig3 --method gauss-seidel --tol 1e-10 --json"), 0);
  ck_assert(prints("\"status\": \"solved\"") && prints("\"method\": \"gauss-seidel\""));
  ck_assert(number_of("equilibrium") <= 1e-10 && number_of("laws") <= 1e-10);
  /* of the condensed problem; 7.2e-10 and 4.0e-8 measured */
  ck_assert(number_of("residual_u") <= 1e-9 && number_of("residual_r") <= 1e-7);
  const double Rn = number_of("resultant_n");
  ck_assert_int_eq(run("scene jean-fig3 --json"), 0);
  ck_assert(fabs(number_of("resultant_n") - Rn) <= 1e-8 * Rn);
  ck_assert_int_eq(run("scene jean-fig4 --method gauss-seidel --max-iter 5"), 1);
  ck_assert(prints("gauss-seidel: iteration limit") && prints("equilibrium"));
  ck_assert_int_eq(run("scene jean-fig3 --method gauss-seidel --weighted"), 2);
  ck_assert(prints("weighted reactions couple the contact nodes"));
}

/* Reads numbers between commas; NaN where a field is empty or a word. */
static void read_row(const char *line, int count, double *value) {
  for (int k = 0; k < count; k++) {
    char *end;
    value[k] = strtod(line, &end);
    if (end == line) value[k] = NAN;
    line += strcspn(line, ",\n") + 1;
  }
}

/* The sweeps of [Jean 1988], their counts, and the digits that data/jean-1988/README.md names. */
TEST(the_sweeps_as_printed) {
  static const int IS[] = {62, 85, 42, 146}, column[] = {0, 3, 4, 5, 6, 8, 9};
  int numbers = 0, rounded = 0;
  for (int t = 0; t < 4; t++) {
    char command[128], path[128], name[32];
    (void)snprintf(command, sizeof command, "scene jean-fig%d --method jean%s --json -o @/%d",
                   3 + t / 2, t % 2 ? " -w" : "", t);
    ck_assert_int_eq(run(command), 1); /* 1e-4 is not what the certificate asks */
    ck_assert(prints("\"method\": \"jean\""));
    ck_assert_int_eq((int)number_of("iterations"), IS[t]);
    static char ours[100000];
    (void)snprintf(name, sizeof name, "%d/contact.csv", t);
    const char *at = strchr(read_text(name, ours, sizeof ours), '\n') + 1;
    (void)snprintf(path, sizeof path, "data/jean-1988/fig%d_%s.csv", 3 + t / 2,
                   t % 2 ? "weighted" : "concentrated");
    FILE *file = fopen(path, "r");
    ck_assert_ptr_nonnull(file);
    char line[512];
    ck_assert_ptr_nonnull(fgets(line, sizeof line, file));
    while (fgets(line, sizeof line, file)) {
      double printed[7], value[10];
      read_row(line, 7, printed);
      read_row(at, 10, value);
      at = strchr(at, '\n') + 1;
      for (int k = 1; k < 7; k++) {
        if (isnan(printed[k]) || printed[k] == 0) continue;
        const double unit = 1e-4 * pow(10, floor(log10(fabs(printed[k]))));
        const double off = fabs(value[column[k]] - printed[k]) / unit;
        ck_assert(off < 5.3);
        numbers++;
        rounded += off <= 0.55; /* half a unit, but for ties */
      }
    }
    (void)fclose(file);
  }
  ck_assert(numbers == 269 && rounded == 266);
  ck_assert_int_eq(run("scene jean-fig3 --method jean --max-iter 61"), 1);
  ck_assert(prints("jean: iteration limit reached, 61 sweeps"));
  says("scene jean-fig3 --method jean --tol 1e-3", "jean: solved, 62 sweeps");
}

/* Halving the elements changes the resultant a thousand times as much as the default tolerance, or
 * more; and no digit is bought that the mesh does not have. */
TEST(the_tolerance_follows_from_the_mesh) {
  double normal[3], sweeps[3];
  static const char *const calls[] = {"scene jean-fig3 -m nlgs --json",
                                      "scene jean-fig3 -m nlgs --json --tol 1e-14",
                                      "scene jean-fig3 --mesh 32x16 --json"};
  for (int k = 0; k < 3; k++) {
    ck_assert_int_eq(run(calls[k]), 0);
    normal[k] = number_of("resultant_n");
    sweeps[k] = number_of("iterations");
  }
  ck_assert_double_ge(fabs(normal[2] - normal[1]), 1e3 * fabs(normal[0] - normal[1]));
  ck_assert_double_le(sweeps[0], 0.6 * sweeps[1]);
}

TEST(equivalents_of_concentrated_reactions) {
  says("scene jean-fig3", "not admissible: 1 pull, 2 more lie outside of the cone");
  says("scene jean-fig4", "admissible: they solve the problem with weighted reactions");
  /* and do: P^-1 r of the one is the r of the other */
  static char text[2][100000];
  for (int w = 0; w < 2; w++) {
    ck_assert_int_eq(
        run(w ? "scene jean-fig4 -w --tol 1e-14 --out @" : "scene jean-fig4 --tol 1e-14 --out @"),
        0);
    (void)read_text("contact.csv", text[w], sizeof text[w]);
  }
  const char *at[2] = {text[0], text[1]};
  double cells = 0;
  for (int c = 0; c < 16; c++) {
    double v[2][11];
    for (int w = 0; w < 2; w++)
      read_row(at[w] = strchr(at[w], '\n') + 1, 11, v[w]);
    for (int k = 0; k < 2; k++) {
      ck_assert_double_eq_tol(v[0][8 + k], v[1][5 + k], 1e-9 * 2e5);
      ck_assert_double_eq_tol(v[1][8 + k], v[0][5 + k], 1e-9 * 2e5);
    }
    cells += v[0][10];
  }
  ck_assert_double_eq_tol(cells, 4e-3 * (1 - 0.5 / 16), 1e-15); /* but for node 17's */
}

/* One block twice, in other units of force: reactions are as many times larger. */
TEST(a_block_of_its_own) {
  double Rn[2];
  for (int k = 0; k < 2; k++) {
    ck_assert_int_eq(run(k ? "scene jean-fig3 --mesh=12x6 --mu .3 --young=7e4 --poisson=.3 "
                             "--load=50,20,80 --json"
                           : "scene jean-fig4 --mesh 12x6 --mu=.3 --young 7e10 --poisson .3 "
                             "--load 50e6,20e6,80e6 --json"),
                     0);
    ck_assert_int_eq((int)number_of("contacts"), 12);
    Rn[k] = number_of("resultant_n");
  }
  ck_assert_double_eq_tol(Rn[0], 1e6 * Rn[1], 1e-9 * Rn[0]);
  /* side and side_top are one number, and the scene's own values can be given */
  for (int k = 0; k < 2; k++) {
    ck_assert_int_eq(run(k ? "scene jean-fig4 --json"
                           : "scene jean-fig3 --mesh 16x8 --mu .1 --young 0.13e12 --poisson .2 "
                             "--load 5e8,5e8 --json"),
                     0);
    Rn[k] = number_of("resultant_n");
  }
  ck_assert(Rn[0] == Rn[1]);
}

/* Friction remembers the way, where some candidates end by sliding back or by sticking. */
TEST(loads_one_after_the_other) {
  static const char *const order[] = {"", "together", "top-first", "side-first"};
  static const char block[] = "--mu .1 --load 5e8,1e8";
  double Rt[4];
  for (int k = 0; k < 4; k++) {
    char command[128];
    (void)snprintf(command, sizeof command, "scene jean-fig3 %s --json %s%s", block,
                   k ? "--order=" : "", order[k]);
    ck_assert_int_eq(run(command), 0);
    Rt[k] = number_of("resultant_t");
  }
  ck_assert(Rt[0] == Rt[1]);
  ck_assert(fabs(Rt[2] - Rt[0]) > 0.1 * fabs(Rt[0]));
  ck_assert(fabs(Rt[3] - Rt[0]) > 0.1 * fabs(Rt[0]));
  says("scene jean-fig3 --order top-first", "first step, top alone: solved");
  /* on the displacements, too */
  ck_assert_int_eq(run("scene jean-fig3 --mu .1 --load 5e8,1e8 --order=top-first "
                       "--method gauss-seidel -t 1e-12 --json"),
                   0);
  ck_assert_double_eq_tol(number_of("resultant_t"), Rt[2], 1e-8 * number_of("resultant_n"));
  /* with no friction the way is forgotten */
  for (int k = 0; k < 2; k++) {
    ck_assert_int_eq(run(k ? "scene jean-fig3 --mu 0 --json"
                           : "scene jean-fig3 --mu 0 --order side-first --json"),
                     0);
    Rt[k] = number_of("resultant_n");
  }
  ck_assert_double_eq_tol(Rt[0], Rt[1], 1e-10 * Rt[1]);
}

TEST(newton_and_the_list_of_methods) {
  NEEDS_HDF5;
  ck_assert_int_eq(run("solve -m newton -t 1e-12 data/fclib/FC3D_Example1.hdf5"), 0);
  ck_assert(prints("newton: ") && prints(" steps"));
  ck_assert_int_eq(run("scene jean-fig3 --method newton --json"), 0);
  ck_assert(prints("\"status\": \"solved\"") && prints("\"method\": \"newton\""));
  ck_assert_int_eq(run("solve --help"), 0);
  ck_assert(prints("auto, nlgs, lemke, newton"));
  ck_assert_int_eq(run("scene --help"), 0);
  ck_assert(prints("auto, nlgs, lemke, newton"));
}

TEST(lemke_in_3d_takes_facets) {
  NEEDS_HDF5;
  static const char *const options[] = {"", "--facets=4 ", "-f 16 "};
  for (int k = 0; k < 3; k++) {
    char command[128] = "solve -m lemke -t 1e-12 --json ";
    strcat(strcat(command, options[k]), "data/fclib/FC3D_Example1.hdf5");
    ck_assert_int_eq(run(command), 0);
    ck_assert(number_of("residual") <= 1e-12 && number_of("iterations") > 0);
    ck_assert_int_eq((int)number_of("dimension"), 3);
  }
  ck_assert_int_eq(run("solve -m lemke -f 2 data/fclib/FC3D_Example1.hdf5"), 2);
  ck_assert_int_eq(run("solve -m lemke -f 5 data/fclib/FC3D_Example1.hdf5"), 2);
  ck_assert(prints("facets"));
}

TEST(saved_problem_solves_to_the_same_answer) {
  NEEDS_HDF5;
  ck_assert_int_eq(run("scene jean-fig3 --tol 1e-14 --save @/p.hdf5"), 0);
  ck_assert_int_eq(run("solve @/p.hdf5 --tol 1e-14 --json -o @/s.hdf5"), 0);
  ck_assert(number_of("residual_u") <= 1e-14);
  ck_assert(number_of("residual_r") <= fmax(1e-14, 4 * number_of("floor_r")));
  char path[128];
  double r[2][32], largest = 0;
  for (int k = 0; k < 2; k++) {
    dls_fclib *file;
    const double *stored, *u;
    (void)snprintf(path, sizeof path, "%s/%s.hdf5", directory, k ? "s" : "p");
    ck_assert_int_eq(dls_fclib_read(&file, path, NULL), DLS_OK);
    ck_assert_int_eq(dls_fclib_solution(file, &stored, &u, NULL), DLS_OK);
    ck_assert_ptr_nonnull(stored);
    memcpy(r[k], stored, sizeof r[k]);
    dls_fclib_destroy(file);
  }
  for (int i = 0; i < 32; i++)
    largest = fmax(largest, fabs(r[0][i]));
  for (int i = 0; i < 32; i++) /* the error in r is below 1e3 residuals */
    ck_assert_double_eq_tol(r[0][i], r[1][i], 2e-11 * largest);
}

TEST(not_solved_is_1) {
  ck_assert_int_eq(run("scene jean-fig3 --max-iter 3 --json"), 1);
  ck_assert(prints("\"max_iterations\"") && number_of("residual") > 1e-12);
}

/* What a solve without an answer writes says so, once, however often it is written; a solve with
 * one takes it back. */
TEST(files_carry_their_status) {
  char text[4000];
  if (run("solve data/failures/c13-newton-cycle.txt -m newton -i 1 -q -o @/a.hdf5 --csv @/csv") ==
      2)
    return; /* a build without HDF5 */
  ck_assert_int_eq(run("solve @/a.hdf5 -m newton -i 2 -q -o @/a.hdf5"), 1);
  ck_assert_int_eq(run("solve data/failures/c13-newton-cycle.txt -m newton -i 1 -o @/a.mtx"), 1);
  read_text("csv/r.csv", text, sizeof text);
  ck_assert_msg(strncmp(text, "# not solved: iteration limit reached, residual ", 48) == 0, "%s",
                text);
  read_text("a.mtx", text, sizeof text);
  ck_assert_ptr_nonnull(strstr(text, "general\n% not solved: iteration limit reached"));
  dls_fclib *file;
  for (int solved = 0; solved < 2; solved++) {
    ck_assert_int_eq(dls_fclib_read(&file, path_of("a.hdf5"), NULL), DLS_OK);
    const char *title = dls_fclib_title(file), *found = strstr(title, "[not solved: ");
    ck_assert(strncmp(title, "Newton cycles", 13) == 0);
    ck_assert_msg((found != NULL) == !solved, "%s", title);
    if (found) ck_assert_ptr_null(strstr(found + 1, "[not solved: "));
    dls_fclib_destroy(file);
    ck_assert_int_eq(run("solve @/a.hdf5 -q -o @/a.hdf5"), 0);
  }
}

/* An empty name is an error, not the root folder, for each option that names a file. */
TEST(empty_names_are_2) {
  static const char *const lines[] = {
      "scene jean-fig3 --out ''",
      "scene jean-fig3 --save ''",
      "scene bar-impact --out ''",
      "scene indentation -o ''",
      "map x --out=",
      "solve data/failures/c01-three-solutions.txt --csv ''",
      "solve data/failures/c01-three-solutions.txt --plot ''",
  };
  for (size_t k = 0; k < sizeof lines / sizeof *lines; k++) {
    ck_assert_msg(run(lines[k]) == 2, "%s: %s", lines[k], output);
    ck_assert_msg(prints(": is empty"), "%s: %s", lines[k], output);
  }
}

/* A scene that a full disk stops leaves the files of before. */
TEST(a_full_disk_keeps_old_files) {
  static const char *const lines[] = {"scene jean-fig3 --mesh 4x4 --out ",
                                      "scene bar-impact --mesh 6x1 --steps 6 --out "};
  static const char *const folders[] = {"a", "b"};
  char text[100], command[400], name[40];
  for (int k = 0; k < 2; k++) {
    (void)snprintf(command, sizeof command, "mkdir %s/%s", directory, folders[k]);
    ck_assert_int_eq(system(command), 0);
    (void)snprintf(name, sizeof name, "%s/contact.csv", folders[k]);
    write_file(name, "old\n");
    const char *program = getenv("DELASSUS_PROGRAM");
    /* counters of a build for coverage, which the limit cuts off, go into the test's directory */
    (void)snprintf(command, sizeof command,
                   "trap '' XFSZ; ulimit -f 1; GCOV_PREFIX=%s %s %s%s/%s >/dev/null 2>&1",
                   directory, program ? program : "build/delassus", lines[k], directory,
                   folders[k]);
    const int status = system(command);
    ck_assert_msg(WIFEXITED(status) && WEXITSTATUS(status) == 2, "%s: %d", command, status);
    ck_assert_str_eq(read_text(name, text, sizeof text), "old\n");
  }
}

/* A folder belongs to the command, and to the scene, that wrote into it first. */
TEST(a_folder_has_one_owner) {
  char text[100];
  ck_assert_int_eq(run("scene jean-fig3 --mesh 4x4 --out @/o"), 0);
  ck_assert_int_eq(run("scene jean-fig3 --mesh 4x4 --weighted --out @/o"), 0);
  static const char *const refused[] = {"scene jean-fig4 --mesh 4x4 --out @/o",
                                        "scene bar-impact --mesh 6x1 --steps 6 --out @/o",
                                        "scene indentation --mesh 6x4 --steps 2 --out @/o",
                                        "chart jean-fig3 -r 1 -b 0.1 --out @/o",
                                        "map jean-fig3 --rows 1 --out @/o",
                                        "map jean-fig3 --against rank --rows 1 --out @/o",
                                        "profile jean-fig3 -r 1 -b 0.1 --out @/o",
                                        "solve data/failures/c20-scales.txt --csv @/o",
                                        "solve data/failures/c20-scales.txt --plot @/o"};
  for (size_t k = 0; k < sizeof refused / sizeof *refused; k++) {
    ck_assert_msg(run(refused[k]) == 2, "%s: %s", refused[k], output);
    ck_assert_msg(prints("holds the files of 'delassus scene jean-fig3'"), "%s", output);
  }
  ck_assert_str_eq(read_text("o/made-by.txt", text, sizeof text), "delassus scene jean-fig3\n");
}

/* A solve that cycles without end ends on each signal with its history so far. */
TEST_EACH(signals_end_a_solve, 0, 4) {
  static const char *const signals[] = {"INT", "TERM", "HUP", "XCPU"};
  char text[2000], command[600];
  const char *program = getenv("DELASSUS_PROGRAM");
  write_file("cycle.txt",
             "contact 2 2\nW\n1 0 -1 0\n0 1 0 1\n-1 0 1 0\n0 1 0 1\nq -1 0 -1 0\nmu .5 .5\n");
  (void)snprintf(command, sizeof command,
                 "timeout -s %s 0.5 %s solve %s/cycle.txt -m nlgs -i 1000000000 -o %s/r.mtx "
                 "> %s/said 2>&1; test $? -eq 124 -a -z \"$(find %s -name '.delassus*')\"",
                 signals[_i], program ? program : "build/delassus", directory, directory, directory,
                 directory);
  ck_assert_int_eq(system(command), 0);
  ck_assert_ptr_nonnull(strstr(read_text("said", text, sizeof text), "not solved: cancelled"));
  ck_assert_ptr_nonnull(strstr(read_text("r.mtx", text, sizeof text), "not solved: cancelled"));
}

TEST(threads_have_limits) {
  static const char *const wrong[] = {"0", "1025", "-1", "1000000000000", "two", "1.5"};
  char line[200];
  for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
    (void)snprintf(line, sizeof line, "solve data/failures/c20-scales.txt --threads=%s", wrong[k]);
    ck_assert_int_eq(run(line), 2);
    ck_assert_msg(prints("is not a whole number from 1 to 1024"), "%s", output);
  }
  ck_assert_int_eq(run("solve data/failures/c20-scales.txt --threads=1024"), 0);
}

TEST(lcp_files) {
  /* y = M z + q with M = (2 1; 1 2), q = (-5, -6): z = (4/3, 7/3) */
  write_file("M.mtx", "%%MatrixMarket matrix array real general\n2 2\n2\n1\n1\n2\n");
  write_file("q.mtx", "%%MatrixMarket matrix array real general\n2 1\n-5\n-6\n");
  ck_assert_int_eq(run("solve --lcp @/M.mtx @/q.mtx --json --output=@/z.mtx"), 0);
  ck_assert(prints("\"solved\"") && number_of("residual") <= 1e-12);
  char path[128];
  int rows, cols;
  double *z;
  (void)snprintf(path, sizeof path, "%s/z.mtx", directory);
  ck_assert_int_eq(dls_mtx_read(path, &rows, &cols, &z, NULL), DLS_OK);
  ck_assert(rows == 2 && cols == 1);
  assert_near(z, (double[]){4. / 3, 7. / 3}, 2, 1e-15);
  dls_mtx_free(z);
  /* no solution: M = -1, q = -1 */
  write_file("M.mtx", "%%MatrixMarket matrix array real general\n1 1\n-1\n");
  write_file("q.mtx", "%%MatrixMarket matrix array real general\n1 1\n-1\n");
  ck_assert_int_eq(run("solve --lcp @/M.mtx @/q.mtx"), 1);
  /* sizes that do not fit; a method that is not for LCPs */
  write_file("q.mtx", "%%MatrixMarket matrix array real general\n2 1\n-1\n1\n");
  ck_assert_int_eq(run("solve --lcp @/M.mtx @/q.mtx"), 2);
  ck_assert_int_eq(run("solve --lcp @/M.mtx @/q.mtx --method nlgs"), 2);
}

TEST(info_says_what_it_found) {
  NEEDS_HDF5;
  says("info -h", "--limit");
  /* W = I */
  ck_assert_int_eq(run("info data/fclib/FC3D_Example1.hdf5"), 0);
  ck_assert(prints("3D, 3 contacts, local") && prints("W: 9 x 9, 3 blocks; symmetric\n"));
  ck_assert(prints("rank 9 of 9: positive definite"));
  ck_assert(prints("friction 0.1: one solution, whatever the friction and the loads"));
  ck_assert_int_eq(run("info --json data/fclib/FC3D_Example1.hdf5"), 0);
  ck_assert(prints("\"friction_unique\": null") && prints("\"critical\": null"));
  ck_assert_double_eq_tol(number_of("smallest"), 1, 1e-15);
  /* global; singular */
  ck_assert_int_eq(run("info data/fclib/gfc2d_granularflowonwall_00069_00350.hdf5"), 0);
  ck_assert(prints("2D, 69 contacts, global") && prints("reduced from 900 unknowns"));
  ck_assert(prints("rank 136 of 138: positive semidefinite, statically indeterminate (2 self-"));
  ck_assert(prints("the reactions need not be unique"));
  /* rounding of the file */
  says("info data/fclib/Confeti-ex13-4contact-Fc3D-SBM.hdf5", "look like rounding of the file");
  ck_assert(prints("above 2.89 (contact 3) there are loads with several solutions"));
  /* too large for eigenvalues */
  says("info --limit=8 data/fclib/FC3D_Example1.hdf5", "not computed for more than 8 rows");
  ck_assert_int_eq(run("info --limit=8 --json data/fclib/FC3D_Example1.hdf5"), 0);
  ck_assert(prints("\"spectrum\": false") && prints("\"rank\": null"));
}

/* Degenerate contacts, friction above the critical one, no interpenetration. */
TEST(info_names_degenerate_contacts) {
  NEEDS_HDF5;
  double W[16] = {2, 1, 0, 0, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, q[4] = {1, 0, 0, 0};
  double mu[2] = {3, 0};
  const dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu};
  ck_assert_int_eq(dls_fclib_write_local(path_of("w.hdf5"), &p, "", NULL, NULL, NULL), DLS_OK);
  ck_assert_int_eq(run("info @/w.hdf5"), 0);
  ck_assert(prints("degenerate: 1 contact (first: 1): W_cc = 0"));
  ck_assert(prints("degenerate: 2 components of r (first: 2): without effect on u"));
  ck_assert(prints("r = 0 is a solution"));
  ck_assert(prints("friction 0 to 3;") && prints("1 contact (first: 0) is above W_nn/|W_nt|"));
  /* alone, the first contact has W_nn W_tt >= 2 W_nt^2: the bound is W_nn/|W_nt| */
  const dls_contact one = {.d = 2, .nc = 1, .W = {2, 2, 4, W}, .q = q, .mu = mu + 1};
  ck_assert_int_eq(dls_fclib_write_local(path_of("w.hdf5"), &one, "", NULL, NULL, NULL), DLS_OK);
  ck_assert_int_eq(run("info @/w.hdf5"), 0);
  ck_assert(
      prints("below 2 there is one solution, whatever the loads, and Lemke's method finds it: "
             "this is so here"));
}

int main(void) {
  return run_tests("cli", make_directory, remove_directory);
}
