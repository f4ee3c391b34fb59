/* fuzz_doors.c: functions that dls_solver_solve does not reach: conversions of W, subsets, LCPs of
 * contact problems, the methods' own functions, batches, files written and read back, tools. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "delassus.h"
#include "files/file.h"
#include "fuzz.h"
#include "vi/vi_internal.h"

enum { most_m = fuzz_rows, most_rows = 120, most_count = 9 };

/* Takes what a conversion has made: it may not be worse than what it was made of. */
static void expect_valid(const dls_contact *from, const dls_contact *made) {
  dls_error error;
  if (from->nc > 0 && made->nc > 0 && dls_contact_check(from, &error) == DLS_OK)
    FUZZ_CHECK(dls_contact_check(made, &error) == DLS_OK);
}

/* ---- storages -------------------------------------------------------------------------------- */

/* W dense -> blocks -> dense: the same numbers. */
static void convert_dense(const dls_contact *problem) {
  static double x[9 * 25 + 1], back[most_m * most_m + 1];
  static int p[most_m + 1], i[most_m * most_m];
  dls_blocks B;
  dls_contact blocks = *problem;
  dls_error error;
  int count;
  const int m = problem->W.rows;
  if (!problem->W.a || problem->nc == 0) return;
  if (dls_blocks_count(&problem->W, problem->d, &count, &error)) return;
  FUZZ_CHECK(dls_blocks_from_dense(&problem->W, problem->d, p, i, x, &B, &error) == DLS_OK);
  FUZZ_CHECK(p[problem->nc] == count);
  FUZZ_CHECK(dls_blocks_to_dense(&B, back, m, &error) == DLS_OK);
  for (int k = 0; k < m * m; k++)
    FUZZ_CHECK(back[k] == problem->W.a[k]);
  blocks.W = (dls_dense){0};
  blocks.Wb = B;
  expect_valid(problem, &blocks);
}

/* W of bodies -> blocks. */
static void convert_bodies(const dls_contact *problem) {
  static double x[9 * 25];
  static int p[6], i[25];
  dls_blocks B;
  dls_contact blocks = *problem;
  dls_error error;
  int count;
  if (dls_bodies_count(problem, &count, &error)) return;
  FUZZ_CHECK(count <= problem->nc * problem->nc);
  if (dls_blocks_from_bodies(problem, p, i, x, &B, &error)) return;
  blocks.bodies = (dls_bodies){0};
  blocks.Wb = B;
  double r[most_m] = {0};
  dls_certificate seen;
  (void)!dls_contact_certify(&blocks, r, NULL, &seen, &error);
}

static void take_subset(const dls_contact *problem, fuzz_bytes *b) {
  static double values[most_m * most_m + 4 * most_m + 60 * most_m];
  int index[3 * most_m + 10], candidate[most_m], count = 0;
  dls_contact subset;
  dls_error error;
  const int odd = take_byte(b) < 16;
  for (int c = 0; c < problem->nc; c++)
    if (take_byte(b) < 128) candidate[count++] = odd ? take_int(b, -1, 6) : c;
  if (dls_contact_subset(problem, count, candidate, values, index, &subset, &error)) return;
  FUZZ_CHECK(subset.nc == count);
  expect_valid(problem, &subset);
  if (count > 0 && take_byte(b) < 40) fuzz_solve(&subset, b);
}

/* ---- LCPs of contact problems ---------------------------------------------------------------- */

static void state_as_lcp(const dls_contact *problem, fuzz_bytes *b) {
  static double M[most_rows * most_rows], q[most_rows], z[most_rows];
  double s[most_m], r[most_m];
  const int facets = take_byte(b) < 128 ? 0 : take_int(b, -1, 22), scaled = take_byte(b) & 1;
  const int n = facets ? dls_contact_facets_size(problem, facets) : dls_contact_lcp_size(problem);
  dls_error error;
  if (n <= 0 || n > most_rows) return;
  for (int c = 0; c < problem->nc; c++)
    s[c] = take_byte(b) < 250 ? 1 + take_byte(b) / 64.0 : take_value(b);
  const double *scale = scaled ? s : NULL;
  const dls_status status = facets
                                ? dls_contact_to_facets_lcp(problem, facets, scale, M, n, q, &error)
                                : dls_contact_to_lcp(problem, scale, M, n, q, &error);
  if (status) return;
  const dls_lcp lcp = {.n = n, .M = {n, n, n, M}, .q = q};
  dls_lemke *lemke;
  dls_lcp_certificate seen;
  dls_certificate laws;
  FUZZ_CHECK(dls_lemke_create(&lemke, n, NULL, &error) == DLS_OK);
  const dls_status solved = dls_lemke_solve(lemke, &lcp, z, NULL, NULL, &error);
  dls_lemke_destroy(lemke);
  if (solved < 0) return;
  FUZZ_CHECK(dls_lcp_certify(&lcp, z, NULL, &seen, &error) == DLS_OK);
  if (facets)
    (void)!dls_contact_from_facets_lcp(problem, facets, scale, z, r, &error);
  else if (dls_contact_from_lcp(problem, scale, z, r, &error) == DLS_OK)
    (void)!dls_contact_certify(problem, r, NULL, &laws, &error);
}

/* ---- the methods' own functions -------------------------------------------------------------- */

static void check_answer(const dls_contact *problem, const double *r, dls_status status, double tol,
                         const dls_info *info) {
  dls_certificate seen;
  dls_error error;
  if (status < 0) return;
  FUZZ_CHECK(info->status == status);
  FUZZ_CHECK(dls_contact_certify(problem, r, NULL, &seen, &error) == DLS_OK);
  if (status == DLS_OK) FUZZ_CHECK(dls_certificate_holds(&seen, tol));
}

/* Solves by one method twice, from r and with the limits of the bytes; SET changes its settings. */
#define SOLVE_BY(NAME, SET)                                                                        \
  do {                                                                                             \
    dls_##NAME##_settings s;                                                                       \
    dls_##NAME *work;                                                                              \
    dls_##NAME##_settings_init(&s);                                                                \
    take_limits(b, &s.limits);                                                                     \
    SET;                                                                                           \
    const dls_status made = dls_##NAME##_create(&work, problem->d, problem->nc, &s, &error);       \
    FUZZ_CHECK((made == DLS_OK) == (work != NULL));                                                \
    for (int pass = 0; pass < 2 && work; pass++)                                                   \
      check_answer(problem, r, dls_##NAME##_solve(work, problem, r, u, &info, &error),             \
                   s.limits.tol, &info);                                                           \
    dls_##NAME##_destroy(work);                                                                    \
  } while (0)

static void solve_by_methods(const dls_contact *problem, fuzz_bytes *b) {
  double r[most_m] = {0}, u[most_m], penalty[most_m];
  dls_info info;
  dls_error error;
  take_vector(b, problem->d * problem->nc, r);
  take_vector(b, problem->nc, penalty);
  switch (take_byte(b) % 4) {
  case 0:
    SOLVE_BY(nlgs, (s.acceleration = (dls_acceleration)take_int(b, 0, 4),
                    s.relaxation = take_byte(b) < 200 ? 1 : take_plain(b),
                    s.window = take_byte(b) < 200 ? 5 : take_int(b, -1, 101)));
    break;
  case 1:
    SOLVE_BY(newton, (s.sweeps = take_int(b, -1, 20), s.line_search = take_int(b, -1, 2),
                      s.regularization = take_byte(b) < 200 ? 1e-6 : take_value(b)));
    break;
  case 2:
    SOLVE_BY(admm, s.rho = take_byte(b) < 200 ? 1 : take_value(b));
    break;
  default:
    SOLVE_BY(augmented,
             (s.factor = take_byte(b) < 200 ? 100 : take_value(b), s.adaptive = take_byte(b) & 1,
              s.penalty = take_byte(b) < 60 ? penalty : NULL));
  }
}

/* The problem with loads of its own, `count` times. */
static void solve_batch(const dls_contact *problem, fuzz_bytes *b) {
  static double q[most_count][most_m], r[most_count][most_m], u[most_count][most_m];
  double *at_r[most_count], *at_u[most_count];
  dls_contact problems[most_count];
  dls_info info[most_count];
  dls_solver_settings settings;
  dls_error error;
  /* all stages of auto on many hard problems would take seconds */
  const int defaults = problem->nc < 3 && take_byte(b) < 128;
  const int count = take_int(b, 0, defaults ? 2 : most_count);
  memset(r, 0, sizeof r);
  for (int k = 0; k < count; k++) {
    problems[k] = *problem;
    problems[k].q = q[k];
    take_vector(b, problem->d * problem->nc, q[k]);
    at_r[k] = r[k];
    at_u[k] = take_byte(b) < 20 ? NULL : u[k];
  }
  dls_solver_settings_init(&settings);
  if (!defaults) take_limits(b, &settings.limits);
  if (!defaults && !settings.limits.max_iterations) settings.limits.max_iterations = 100;
  if (!defaults) settings.method = (dls_method)take_int(b, 0, 8);
  const dls_status status =
      dls_solve_batch(count, problems, defaults ? NULL : &settings, at_r, at_u, info, &error);
  if (status < 0) return;
  for (int k = 0; k < count; k++)
    check_answer(&problems[k], r[k], info[k].status, settings.limits.tol, &info[k]);
}

/* ---- files ----------------------------------------------------------------------------------- */

static char doors_directory[] = "/dev/shm/delassus-doors-XXXXXX", doors_path[64];

static void remove_doors_directory(void) {
  (void)unlink(doors_path);
  (void)rmdir(doors_directory);
}

/* Writes a local problem and reads the same one back. */
static void write_and_read(const dls_contact *problem, fuzz_bytes *b) {
  static int made;
  double r[most_m], u[most_m];
  dls_fclib *file;
  dls_contact back;
  dls_error error;
  const double *read_r, *read_u;
  const int m = problem->d * problem->nc, solution = take_byte(b) & 1;
  if (!made++) {
    if (!mkdtemp(doors_directory)) abort();
    (void)snprintf(doors_path, sizeof doors_path, "%s/f", doors_directory);
    (void)atexit(remove_doors_directory);
  }
  char title[40];
  for (int k = 0; k < 39; k++)
    title[k] = (char)take_byte(b);
  title[39] = '\0';
  take_vector(b, m, r);
  take_vector(b, m, u);
  if (problem->W.a && take_byte(b) < 60) {
    double *a;
    int rows, cols;
    if (dls_mtx_write(doors_path, &problem->W, &error)) return;
    FUZZ_CHECK(dls_mtx_read(doors_path, &rows, &cols, &a, &error) == DLS_OK);
    FUZZ_CHECK(rows == m && cols == m);
    for (int k = 0; k < m * m; k++)
      FUZZ_CHECK(a[k] == problem->W.a[k]);
    dls_mtx_free(a);
    return;
  }
  if (dls_fclib_write_local(doors_path, problem, title, solution ? r : NULL, solution ? u : NULL,
                            &error))
    return;
  const dls_status read = dls_fclib_read(&file, doors_path, &error);
  if (read) (void)fprintf(stderr, "%s\n", error.message);
  FUZZ_CHECK(read == DLS_OK);
  FUZZ_CHECK(dls_fclib_contact(file, &back, &error) == DLS_OK);
  FUZZ_CHECK(back.d == problem->d && back.nc == problem->nc);
  FUZZ_CHECK(memcmp(back.q, problem->q, (size_t)m * sizeof *back.q) == 0);
  FUZZ_CHECK(memcmp(back.mu, problem->mu, (size_t)back.nc * sizeof *back.mu) == 0);
  FUZZ_CHECK(dls_fclib_solution(file, &read_r, &read_u, &error) == DLS_OK);
  FUZZ_CHECK(!solution == !read_r);
  if (read_r) FUZZ_CHECK(memcmp(read_r, r, (size_t)m * sizeof *r) == 0);
  dls_fclib_destroy(file);
}

/* ---- small tools ----------------------------------------------------------------------------- */

static void use_tools(fuzz_bytes *b) {
  double W[9], q[3], r[3], s[8], x[32], length[8];
  int candidate[8], p[9], i[32], columns, count;
  char text[64];
  dls_error error;
  const int d = take_int(b, 1, 3);
  take_vector(b, d * d, W);
  take_vector(b, d, q);
  (void)dlsi_nlgs_local(d, W, q, take_byte(b) < 200 ? take_byte(b) / 100.0 : take_value(b), r,
                        &count);
  for (int k = 0; k < d; k++)
    FUZZ_CHECK(isfinite(r[k]));
  const int nodes = take_int(b, -1, 8);
  double at = 0;
  for (int k = 0; k < 8; k++) {
    s[k] = take_byte(b) < 250 ? (at += take_byte(b) / 16.0 + 0.01) : take_value(b);
    candidate[k] = take_byte(b) < 160;
  }
  const int quadratic = take_byte(b) < 128;
  for (int k = 1; quadratic && k < 7; k += 2)
    s[k] = s[k - 1] / 2 + s[k + 1] / 2;
  const int *chosen = take_byte(b) < 128 ? candidate : NULL;
  if ((quadratic
           ? dls_weighting_quadratic(nodes, s, chosen, p, i, x, length, &columns, &error)
           : dls_weighting_line(nodes, s, chosen, p, i, x, length, &columns, &error)) == DLS_OK)
    for (int j = 0; j < columns; j++) {
      double sum = 0;
      for (int k = p[j]; k < p[j + 1]; k++)
        sum += x[k];
      FUZZ_CHECK(fabs(sum - 1) < 1e-12);
    }
  for (int k = 0; k < 63; k++)
    text[k] = (char)take_byte(b);
  text[63] = '\0';
  dls_method method;
  dls_acceleration acceleration;
  (void)dlsi_text_numbers(text, take_int(b, 0, 8), s);
  (void)!dls_method_find(text, &method);
  (void)!dls_acceleration_find(text, &acceleration);
}

void fuzz_doors(const unsigned char *data, size_t size) {
  fuzz_bytes b = {data, size};
  dls_contact problem;
  const int what = take_byte(&b) % 8;
  if (what == 7) {
    use_tools(&b);
    return;
  }
  take_contact(&b, &problem);
  switch (what) {
  case 0:
    convert_dense(&problem);
    convert_bodies(&problem);
    break;
  case 1:
    break;
  case 2:
    take_subset(&problem, &b);
    break;
  case 3:
    state_as_lcp(&problem, &b);
    break;
  case 4:
    solve_batch(&problem, &b);
    break;
  case 5:
    write_and_read(&problem, &b);
    break;
  default:
    solve_by_methods(&problem, &b);
  }
}
