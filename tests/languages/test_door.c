/*
 * test_door.c: C, C++, Fortran and Python have the same answers, to the last bit: of a held body in
 * one call and on K, a free one pressed down, the same on W (refused), one that flies away.
 * door.cpp, door.f90 and door.py print what this program does: a line a problem, its name, the
 * status, the bits of r, u, x, residual, equilibrium.
 */
#include <inttypes.h>
#include <unistd.h>

#include "delassus.h"
#include "run.h"

static char expected[2000], printed[2000];

static void door_line(const char *name, dls_status status, const double *r, const double *u,
                      const double *x, const dls_certificate *c) {
  const double all[] = {r[0], r[1], u[0], u[1], x[0], x[1], c->residual, c->equilibrium};
  size_t end = strlen(expected);
  end += (size_t)snprintf(expected + end, sizeof expected - end, "%s %d", name, (int)status);
  for (int k = 0; k < 8 && status >= 0; k++) {
    uint64_t bits;
    memcpy(&bits, &all[k], sizeof bits);
    end += (size_t)snprintf(expected + end, sizeof expected - end, " %016" PRIX64, bits);
  }
  (void)snprintf(expected + end, sizeof expected - end, "\n");
}

static dls_model body(const double *K, int normal, int tangents) {
  static const int p[] = {0, 1}, none[] = {0, 0}, i[] = {0, 1};
  static const double one[] = {1};
  dls_model model = {.d = 2, .n = 2, .nodes = 1, .K = {2, 2, 2, K}};
  model.operator_kind = DLS_STIFFNESS_DENSE;
  model.factorization = DLS_CHOLESKY;
  model.HN = (dls_sparse){2, 1, p, i + normal, one};
  model.HT = (dls_sparse){2, 1, tangents ? p : none, i, one};
  return model;
}

static void solve_in_C(void) {
  const double K[] = {3, 1, 1, 2}, f[] = {5, -10}, mu[] = {0.2};
  const double spring[] = {5, -5, -5, 5}, down[] = {0, -10}, up[] = {0, 10}, g[] = {1, 0};
  const double zero[] = {0};
  const dls_model held = body(K, 1, 1), loose = body(spring, 0, 0);
  double r[2], u[2], x[2];
  dls_info info;
  dls_status status = dls_solve_model(&held, f, NULL, mu, r, u, x, &info, NULL);
  ck_assert(status == DLS_OK && fabs(r[0] - 10.9375) <= 1e-9 && fabs(x[0] - 0.9375) <= 1e-9);
  door_line("held", status, r, u, x, &info.certificate);
  dls_reduction_settings settings;
  dls_reduction *reduction;
  dls_reduction_settings_init(&settings);
  settings.on = DLS_ON_K;
  ck_assert_int_eq(dls_reduction_create(&reduction, &held, &settings, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(reduction, f, NULL, NULL), DLS_OK);
  status = dls_reduction_solve(reduction, mu, NULL, r, u, x, &info, NULL);
  ck_assert(status == DLS_OK && fabs(r[0] - 10.9375) <= 1e-6 && fabs(x[0] - 0.9375) <= 1e-6);
  ck_assert_int_eq(dls_reduction_certify(reduction, mu, r, x, u, &info.certificate, NULL), DLS_OK);
  door_line("on-K", status, r, u, x, &info.certificate);
  dls_reduction_destroy(reduction);
  status = dls_solve_model(&loose, down, g, zero, r, u, x, &info, NULL);
  ck_assert(status == DLS_OK && fabs(r[0] - 10) <= 1e-7 && fabs(x[1] + 3) <= 1e-7);
  door_line("pressed", status, r, u, x, &info.certificate);
  settings.on = DLS_ON_W;
  status = dls_reduction_create(&reduction, &loose, &settings, NULL);
  ck_assert_int_eq(status, DLS_E_SINGULAR);
  door_line("on-W", status, r, u, x, &info.certificate);
  status = dls_solve_model(&loose, up, g, zero, r, u, x, &info, NULL);
  ck_assert_int_eq(status, DLS_NO_SOLUTION);
  door_line("flies", status, r, u, x, &info.certificate);
}

/* Asserts that a command prints the same; says so if it is not there. */
static void door_compare(const char *program, const char *command) {
  if (access(program, F_OK)) {
    (void)printf("skipped: %s\n", program);
    return;
  }
  FILE *output = popen(command, "r"); /* NOLINT(cert-env33-c) */
  ck_assert_ptr_nonnull(output);
  printed[fread(printed, 1, sizeof printed - 1, output)] = '\0';
  ck_assert_msg(pclose(output) == 0, "%s", command);
  ck_assert_msg(strcmp(printed, expected) == 0, "%s\n%snot\n%s", command, printed, expected);
}

TEST(languages_agree) {
  const char *build = getenv("DELASSUS_BUILD"), *python = getenv("PYTHON");
  char command[500];
  if (!build) build = "build";
  solve_in_C();
  (void)snprintf(command, sizeof command, "%s/tests/languages/door-cpp", build);
  door_compare(command, command);
  (void)snprintf(command, sizeof command, "%s/tests/languages/door-f90", build);
  door_compare(command, command);
  (void)snprintf(command, sizeof command, "%s tests/languages/door.py", python ? python : "");
  if (python && *python)
    door_compare("tests/languages/door.py", command);
  else
    (void)printf("skipped: door.py, no PYTHON\n");
}
