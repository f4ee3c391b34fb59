/* test_report.c: delassus report: the page, its advice, its text, and mistakes. */
#define _GNU_SOURCE
#include "program.h"
#include "run.h"

/* The letters of each picture are 10 pixels high at least where the page is narrow. */
static void expect_letters(const char *page) {
  double wide = 0, least = 0, size;
  for (const char *at = page; (at = strpbrk(at + 1, "<vmf")) != NULL;) {
    (void)sscanf(at, "viewBox=\"0 0 %lf", &wide);
    (void)sscanf(at, "min-width:%lfpx;", &least);
    (void)sscanf(at, "min-width:%lfpx\"", &least);
    if (sscanf(at, "font-size=\"%lf\"", &size) == 1 && size > 0)
      ck_assert_msg(size * least / wide > 9.99, "%g of %g px in %g px", size, wide, least);
  }
}

/* Every tag is closed in its order; nothing is loaded; no id stands twice. */
static void expect_page(const char *name) {
  const char *page = contents(name);
  static const char *const loads[] = {"<script", "<link",    "<img",        "<iframe",   "src=",
                                      "@import", "url(http", "href=\"http", "href='http"};
  char open[64][16];
  int depth = 0, ids = 0;
  ck_assert_int_lt((int)strlen(page), 1000000);
  ck_assert_msg(!strstr(page, ">nan<") && !strstr(page, "times_fastest"), "%s", name);
  for (size_t k = 0; k < sizeof loads / sizeof loads[0]; k++)
    ck_assert_msg(strstr(page, loads[k]) == NULL, "%s: %s", name, loads[k]);
  for (const char *at = page; (at = strchr(at, '<')) != NULL; at++) {
    char tag[16] = "";
    const char *end = strchr(at, '>');
    ck_assert_msg(end != NULL, "%s: %.40s", name, at);
    (void)sscanf(at + 1, "%15[/a-zA-Z0-9]", tag);
    if (at[1] == '!' || end[-1] == '/') continue;
    if (tag[0] == '/') {
      ck_assert_msg(depth > 0 && strcmp(open[--depth], tag + 1) == 0, "%s: %.60s", name, at);
    } else {
      ck_assert_int_lt(depth, 64);
      (void)snprintf(open[depth++], 16, "%s", tag);
    }
  }
  ck_assert_int_eq(depth, 0);
  for (const char *at = page; (at = strstr(at, " id='")) != NULL; at++) {
    char id[40], key[60];
    ck_assert_int_eq(sscanf(at, " id='%39[^']", id), 1);
    (void)snprintf(key, sizeof key, " id='%s'", id);
    ck_assert_msg(strstr(at + 1, key) == NULL, "%s: %s stands twice", name, id);
    ids++;
  }
  expect_letters(page);
  ck_assert_msg((ids > 0) == (strstr(page, "<svg") != NULL), "%s: %d ids", name, ids);
}

/* The resultant of jean-fig3 on a mesh; the weights of the last run are in output. */
static double force_at(int nx, int ny, const char *tol) {
  char arguments[200];
  (void)snprintf(arguments, sizeof arguments, "scene jean-fig3 --mesh=%dx%d --tol=%s --json", nx,
                 ny, tol);
  ck_assert_int_eq(run(arguments), 0);
  return number_of("resultant_t");
}

/* The advised setting is within the accuracy of one four times finer, and one that is half as fine
 * is not. */
TEST(advice_holds) {
  NEEDS_MUMPS;
  int nx, ny;
  char tol[16];
  ck_assert_int_eq(run("report jean-fig3 --quick --cpu 8 --text -o @/r"), 0);
  const char *take = strstr(output, "Take ");
  ck_assert(take && sscanf(take, "Take %d x %d, tol %15[^:]", &nx, &ny, tol) == 3);
  ck_assert_ptr_nonnull(strstr(take, "friction force within 1 %"));
  const double fine = force_at(4 * nx, 4 * ny, "1e-12");
  ck_assert_double_le(fabs(force_at(nx, ny, tol) / fine - 1), 0.01);
  ck_assert_double_gt(fabs(force_at(nx / 2, ny / 2, tol) / fine - 1), 0.01);
}

/* CPU for little more than one run of the scene says nothing of its error, and so does the page. */
TEST(cpu_for_one_run) {
  ck_assert_int_eq(run("scene indentation --quiet --json"), 0);
  const double cpu = number_of("cpu_seconds");
  for (int k = 1; k <= 3; k += 2) { /* half a run, one and a half */
    char arguments[100];
    (void)snprintf(arguments, sizeof arguments,
                   "report indentation --quick --cpu %.3f --text -o @/r", k * cpu / 2);
    const int status = run(arguments), finishes = strstr(output, "it finishes") != NULL;
    ck_assert_msg(status == !finishes && (k > 1 || !finishes), "%s", output);
    ck_assert_int_eq(strstr(output, "its error is unknown") != NULL, finishes);
    ck_assert_int_eq(strstr(output, "CPU are too few (--cpu=S).") != NULL, finishes);
    ck_assert_ptr_nonnull(strstr(output, finishes ? "CPU, all steps" : "CPU, up to there"));
    ck_assert_ptr_null(strstr(output, "By order"));
    ck_assert_msg(!strstr(output, " 0 %") && !strstr(output, "nan") && !strstr(output, "Warning"),
                  "%s", output);
  }
}

enum { PIECES = 50 };

/* Fills the mean pressure of 50 equal parts of the contact line of jean-fig3, whose nodes stand for
 * it half way to their neighbours. */
static void pressures(const char *setting, double p[PIECES]) {
  static const double length = 4e-3;
  char arguments[300];
  double low = 0;
  (void)snprintf(arguments, sizeof arguments, "scene jean-fig3 %s --out=@/p", setting);
  ck_assert_int_eq(run(arguments), 0);
  const char *row = strchr(contents("p/contact.csv"), '\n') + 1;
  for (int k = 0; k < PIECES; k++)
    p[k] = 0;
  while (*row) {
    double x, rn, next = length;
    ck_assert_int_eq(sscanf(row, "%*d,%lf,%*f,%*f,%*f,%*f,%lf", &x, &rn), 2);
    row = strchr(row, '\n') + 1;
    if (*row) ck_assert_int_eq(sscanf(row, "%*d,%lf", &next), 1);
    const double high = *row ? (x + next) / 2 : length;
    for (int k = 0; k < PIECES; k++) {
      const double left = fmax(low, length * k / PIECES), right = length * (k + 1) / PIECES;
      if (fmin(high, right) > left) p[k] += rn / (high - low) * (fmin(high, right) - left);
    }
    low = high;
  }
}

/* The pressure of the advised mesh is within what the report says of one twice finer; that of
 * 45 x 23, which the force asks for, is 12 % off. */
TEST(pressure_holds) {
  NEEDS_MUMPS;
  static double taken[PIECES], fine[PIECES];
  char setting[100];
  int nx, ny;
  double grade = 1, sum = 0, norm = 0;
  ck_assert_int_eq(run("report jean-fig3 --quick --accuracy .05 --of=pressure --text -o @/r"), 0);
  const char *take = strstr(output, "Take ");
  ck_assert(take && sscanf(take, "Take %d x %d, grade %lf", &nx, &ny, &grade) >= 2);
  ck_assert_ptr_nonnull(strstr(take, "pressure within 5 %"));
  (void)snprintf(setting, sizeof setting, "--mesh=%dx%d --grade=%g", nx, ny, grade);
  pressures(setting, taken);
  (void)snprintf(setting, sizeof setting, "--mesh=%dx%d --grade=%g", 2 * nx, 2 * ny, grade);
  pressures(setting, fine);
  for (int k = 0; k < PIECES; k++) {
    sum += (taken[k] - fine[k]) * (taken[k] - fine[k]);
    norm += fine[k] * fine[k];
  }
  ck_assert_double_le(sqrt(sum / norm), 0.05);
}

static const struct {
  const char *arguments, *page;
  const char *says[8];
} reports[] = {
    {"report jean-fig3 --cpu 2 --text -o @",
     "jean-fig3.html",
     {"Take ", "== Error budget ==", "mesh * 2", "weighted reactions", "no friction",
      "Uniqueness: unknown at friction 1", "== Stability ==", "== Contacts =="}},
    {"report bar-impact --quick --cpu 4 --text -o @",
     "bar-impact.html",
     {"impulse of the wall and its curve within 1 %", "mesh * 2", "lumped mass", "== Motion",
      "of the closed form", "delassus scene --mesh=", "Uniqueness: unknown"}},
    {"report two-blocks --cpu 4 --text -o @",
     "two-blocks.html",
     {"work of friction", "Uniqueness: unknown; a free body has no W.", "== Stability =="}},
#ifdef __SANITIZE_ADDRESS__ /* takes three times as long */
    {"report extrusion --quick --cpu 24 --accuracy 0.1 --text -o @",
#else
    {"report extrusion --quick --cpu 16 --accuracy 0.1 --text -o @",
#endif
     "extrusion.html",
     {"force on the ram", "estimated to", "penalty, factor 1000", "penalty, factor 2000"}},
    {"report data/failures/c28-nearly-singular.txt --cpu 1 --text -o @",
     "c28-nearly-singular.html",
     {"Take auto, tol 1e-02: reactions within 1 %", "(proved: ",
      "Stability: auto solves it to 1e-12", "tolerance 1e-12", "== Stability ==", "2 contacts: "}},
    {"report data/failures/c01-three-solutions.txt --quick --text -o @",
     "c01-three-solutions.html",
     {"Uniqueness: three answers, proved: r = 0 0; r = 2 -3; r = 1 -2.",
      "delassus solve --tol=1e-01 data/failures/c01-three-solutions.txt"}},
    {"report bar-bounce --quick --accuracy .1 --of force --text -o @",
     "bar-bounce.html",
     {"impulse of the wall and its curve within 10 %", "the closed form, 533.333 N s",
      "the curve the worst", "curve over the steps (L2)", "energy drift"}},
    {"report jean-moving4 --quick --accuracy .001 --of force --cpu 20 --text -o @",
     "jean-moving4.html",
     {"work of friction within 0.1 % (estimated to: ", "the limit of the steps, 13.22"}},
    {"report data/failures/c05-hyperstatic.txt --quick --text -o @",
     "c05-hyperstatic.html",
     {"positions within 1 %", "W does not determine the reactions"}},
    {"report data/failures/c04-squeezed.txt --quick --text -o @",
     "c04-squeezed.html",
     {"Not solved by auto: no solution exists", "There is no answer."}}};

/* The text on stdout has each part, and the page all of its words. */
TEST_EACH(page_and_text, 0, sizeof reports / sizeof reports[0]) {
  if (!WITH_MUMPS && strstr(reports[_i].arguments, "jean")) return; /* its finer meshes */
  ck_assert_int_eq(run(reports[_i].arguments), strstr(reports[_i].page, "squeezed") != NULL);
  for (int k = 0; k < 8 && reports[_i].says[k]; k++)
    ck_assert_msg(strstr(output, reports[_i].says[k]) != NULL, "no '%s' in %s", reports[_i].says[k],
                  output);
  expect_page(reports[_i].page);
  ck_assert(!strstr(output, "No chart: ") || !strstr(output, "$ delassus chart"));
}

/* Sentence and table give one error, also where an edge lowers the order of even meshes. */
TEST(sentence_and_table_agree) {
  NEEDS_MUMPS;
  double sentence, row;
  ck_assert_int_eq(run("report jean-fig4 --quick --accuracy .001 --cpu 12 --text -o @/r"), 0);
  ck_assert_ptr_nonnull(strstr(output, "grade 3, tol 1e-05: friction force within 0.1 %"));
  const char *lead = strstr(output, "estimated to: "), *table = strstr(output, "\nfriction force ");
  ck_assert(lead && sscanf(lead, "estimated to: %lf", &sentence) == 1);
  ck_assert(table && sscanf(table, "\nfriction force %lf", &row) == 1);
  ck_assert_double_eq(sentence, row);
}

/* Pressure, energies and gap over many steps are small enough for a page. */
TEST(pressure_fits_a_page) {
  ck_assert_int_eq(run("scene indentation --mesh=10x10 --steps=400 --tol=1e-4 --out=@/i"), 0);
  ck_assert_uint_le(strlen(contents("i/pressure.svg")), 280000);
  ck_assert_int_eq(run("scene bar-fixed --mesh=100 --steps=20000 --tol=1e-4 --out=@/b"), 0);
  ck_assert(strlen(contents("b/energy.svg")) < 280000 && strlen(contents("b/bar.svg")) < 280000);
}

/* The matrices of a host code; two names that make one file name. */
TEST(matrices_and_many_names) {
  FILE *W = open_file("W.txt", "w"), *q = open_file("q.txt", "w");
  for (int k = 0; k < 144; k++) {
    fprintf(W, "%.17g%c", 4. * (k % 13 == 0) + cos(k / 12 * (k % 12)), k % 12 < 11 ? ' ' : '\n');
    if (k < 12) fprintf(q, "%.17g\n", cos(k) - (k % 3 == 0));
  }
  ck_assert(fclose(W) == 0 && fclose(q) == 0);
  if (WITH_HDF5) {
    ck_assert_int_eq(run("report --W=@/W.txt --q=@/q.txt --mu=.4 --dim=3 --quick --text -o @/m"),
                     0);
    expect_page("m/W.html");
    const int iterations = (int)number_after("tolerance 1e-02          solved ");
    ck_assert_int_eq(run("solve --tol=1e-02 @/m/W/problem.hdf5"), 0); /* as the page prints */
    ck_assert_int_eq((int)number_after("auto: solved, "), iterations);
  }
  ck_assert_int_eq(run("report data/failures/c01-three-solutions.txt --quick -o @/n "
                       "./data/failures/c01-three-solutions.txt"),
                   0);
  expect_page("n/c01-three-solutions.html"); /* its name may be broken in two */
  ck_assert_ptr_nonnull(strstr(contents("n/c01-three-solutions.html"),
                               "<h1>data/failures/c01-three-solutions.txt</h1>"));
  expect_page("n/c01-three-solutions-2.html");
}

/* Without gnuplot the page has tables only, and a line says what to install. */
TEST(without_gnuplot) {
  NEEDS_MUMPS;
  char path[4096];
  (void)snprintf(path, sizeof path, "%s", getenv("PATH"));
  ck_assert_int_eq(setenv("PATH", "/nowhere", 1), 0);
  const int status = run("report jean-fig3 --cpu 1 -o @");
  ck_assert_int_eq(setenv("PATH", path, 1), 0);
  ck_assert_int_eq(status, 0);
  ck_assert_ptr_nonnull(strstr(output, "install gnuplot"));
  const char *page = contents("jean-fig3.html");
  ck_assert_ptr_null(strstr(page, "<svg"));
  ck_assert_ptr_nonnull(strstr(page, "install gnuplot"));
  ck_assert_ptr_nonnull(strstr(page, "mu</th><th class=\"word\">method</th>"));
}

/* A part that cannot write its files is left out, with the reason; the page is whole. */
TEST(a_part_that_fails_leaves_the_page) {
  ck_assert_int_eq(run("scene bar-impact --mesh 9 -o @/bar-fixed/scene"), 0);
  ck_assert_int_le(run("report bar-fixed --quick --cpu=2 -o @"), 1);
  expect_page("bar-fixed.html");
  ck_assert_ptr_nonnull(strstr(contents("bar-fixed.html"), "holds the files of"));
}

/* Of the files of steps 20 MB stay, and all with --data; nothing else is removed. */
TEST(data_of_twenty_megabytes) {
  static const char *const options[] = {"", "--data"};
  for (int k = 0; k < 2; k++) {
    char command[600];
    (void)snprintf(command, sizeof command,
                   "cd %s && rm -rf bar-fixed && mkdir -p bar-fixed/scene && cd bar-fixed/scene && "
                   "truncate -s 21000000 step_9999.vtu && truncate -s 12000000 own.vtu",
                   directory);
    ck_assert_int_eq(system(command), 0);
    (void)snprintf(command, sizeof command, "report bar-fixed --quick --cpu=1 --json -o @ %s",
                   options[k]);
    ck_assert_int_eq(run(command), 0);
    ck_assert_double_eq(number_of("reference"), 2);
    ck_assert_double_gt(number_of("cpu_seconds"), 0);
    (void)snprintf(command, sizeof command,
                   "cd %s/bar-fixed/scene && test %s -e step_9999.vtu && test -e own.vtu",
                   directory, k ? "" : "!");
    ck_assert_int_eq(system(command), 0);
    ck_assert_int_eq(strstr(contents("bar-fixed.html"), "Left out: 21\xc2\xa0MB") != NULL, !k);
  }
}

/* After five seconds stderr has a line with part, share and time. */
TEST(progress_is_shown) {
  ck_assert_int_eq(run("report bar-bounce --quick --accuracy=1e-5 --cpu=8 -o @/s"), 0);
  const char *line = strstr(output, "bar-bounce: ");
  int share, left;
  char part[40];
  ck_assert_msg(line && sscanf(line, "bar-bounce: %39[^,], %d %% done, at most %d s of CPU left",
                               part, &share, &left) == 3,
                "%s", output);
  ck_assert_int_le(share, 100);
  ck_assert_int_le(left, 8);
}

/* The options in each row of budget.csv give its answer: friction and weights, too. */
TEST_EACH(rows_are_commands, 0, 2) {
  static const char *const names[] = {"jean-fig3", "bar-impact"};
  NEEDS_MUMPS;
  int rows = 0;
  double answer;
  char setting[120], arguments[200];
  (void)snprintf(arguments, sizeof arguments, "report %s --quick --cpu 1 -o @/%d", names[_i], _i);
  ck_assert_int_eq(run(arguments), 0);
  (void)snprintf(arguments, sizeof arguments, "%d/%s/budget.csv", _i, names[_i]);
  for (const char *row = contents(arguments); (row = strchr(row, '\n')) && *++row;) {
    if (sscanf(row, "%*[^,],%119[^,],solved,%lf", setting, &answer) != 2 || rows++ > 12) continue;
    (void)snprintf(arguments, sizeof arguments, "scene %s %s --json", names[_i], setting);
    ck_assert_int_eq(run(arguments), 0);
    const double value = number_of(_i ? "impulse_normal" : "resultant_t");
    ck_assert_double_eq_tol(fabs(value), answer, 1e-8 * answer);
  }
  ck_assert_int_gt(rows, 12);
}

static const struct {
  const char *typed, *answer;
} mistakes[] = {{"report", "too few or too many names"},
                {"report jean-fig -o @/r", "did you mean jean-fig3 or jean-fig4?"},
                {"report nowhere.hdf5 -o @/r", "nowhere.hdf5"},
                {"report jean-fig3 --accuracy 2", "--accuracy: '2' is not between 0 and 1"},
                {"report jean-fig3 --of speed", "--of: 'speed' is not a list of force, curve"},
                {"report jean-fig3 --of force,", "--of: 'force,' is not a list"},
                {"report jean-fig3 --of curve,drift", "it has none of 'curve,drift'"},
                {"report jean-fig3 --cpu much", "--cpu: 'much' is not a number >= 0"},
                {"report --W=@/no.txt --q=@/no.txt --mu=1 -o @/r", "no.txt"}};

TEST_EACH(mistakes_are_named, 0, sizeof mistakes / sizeof mistakes[0]) {
  ck_assert_int_eq(run(mistakes[_i].typed), 2);
  ck_assert_msg(strstr(output, mistakes[_i].answer) != NULL, "%s", output);
}

int main(void) {
  return run_tests("report", make_directory, remove_directory);
}
