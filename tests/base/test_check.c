/* test_check.c: the results of checks for input at their limits: values, indices, words. */
#include "base/utf8.h"
#include "contact/contact.h"
#include "run.h"

/* An answer and the error beside it. */
static void check_says(dls_status answer, const dls_error *e, dls_status status,
                       const char *argument, long long index, double value, const char *words) {
  ck_assert_int_eq(answer, status);
  ck_assert_str_eq(e->argument, argument);
  ck_assert_int_eq(e->index, index);
  ck_assert(e->value == value || (e->value != e->value && value != value));
  ck_assert_msg(strstr(e->message, words) != NULL, "%s", e->message);
}

TEST(sizes) {
  dls_error e;
  for (int d = 1; d <= 3; d++) {
    ck_assert_int_eq(dlsi_check_sizes(d, INT_MAX / d, NULL), DLS_OK);
    ck_assert_int_eq(dlsi_check_sizes(d, 0, NULL), DLS_OK);
  }
  check_says(dlsi_check_sizes(2, INT_MAX / 2 + 1, &e), &e, DLS_E_SIZE, "nc", -1, INT_MAX / 2 + 1,
             "too large");
  check_says(dlsi_check_sizes(2, -1, &e), &e, DLS_E_SIZE, "nc", -1, -1,
             "is -1, must not be negative");
  check_says(dlsi_check_sizes(0, 1, &e), &e, DLS_E_ARGUMENT, "d", -1, 0, "is 0, must be 1, 2 or 3");
  check_says(dlsi_check_sizes(4, 1, &e), &e, DLS_E_ARGUMENT, "d", -1, 4, "is 4, must be 1, 2 or 3");
}

/* Room between the columns of a dense matrix is not read; without columns nothing is. */
TEST(dense_matrices) {
  double a[10] = {1, 2, 3, NAN, NAN, 6, 7, 8, NAN, NAN};
  dls_dense A = {3, 2, 5, a};
  dls_error e;
  ck_assert_int_eq(dlsi_check_dense("A", &A, 3, 2, NULL), DLS_OK);
  a[7] = -INFINITY;
  check_says(dlsi_check_dense("A", &A, 3, 2, &e), &e, DLS_E_NOT_FINITE, "A", 7, -INFINITY,
             "(row 2, column 1)");
  check_says(dlsi_check_dense("A", &A, 3, 3, &e), &e, DLS_E_SIZE, "A", -1, 3,
             "is 3 x 2, must be 3 x 3");
  check_says(dlsi_check_dense("A", &A, 2, 2, &e), &e, DLS_E_SIZE, "A", -1, 3,
             "is 3 x 2, must be 2 x 2");
  A.ld = 3;
  a[3] = a[4] = 0;
  ck_assert_int_eq(dlsi_check_dense("A", &A, 3, 2, NULL), DLS_OK);
  A.ld = 2;
  check_says(dlsi_check_dense("A", &A, 3, 2, &e), &e, DLS_E_SIZE, "A", -1, 2,
             "leading dimension 2 is less than 3");
  A = (dls_dense){0, 0, 0, a};
  check_says(dlsi_check_dense("A", &A, 0, 0, &e), &e, DLS_E_SIZE, "A", -1, 0,
             "leading dimension 0 is less than 1");
  A = (dls_dense){1, 1, 0, a};
  check_says(dlsi_check_dense("A", &A, 1, 1, &e), &e, DLS_E_SIZE, "A", -1, 0,
             "leading dimension 0 is less than 1");
  A = (dls_dense){0, 0, 1, a};
  ck_assert_int_eq(dlsi_check_dense("A", &A, 0, 0, NULL), DLS_OK);
}

TEST(sparse_matrices) {
  int p[3] = {0, 1, 2}, i[2] = {1, 2};
  double x[2] = {1, 2};
  const dls_sparse A = {3, 2, p, i, x}, none = {3, 2, (const int[3]){0, 0, 0}, NULL, NULL};
  dls_error e;
  ck_assert_int_eq(dlsi_check_sparse("A", &A, 3, 2, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_check_sparse("A", &none, 3, 2, NULL), DLS_OK);
  i[1] = 3;
  check_says(dlsi_check_sparse("A", &A, 3, 2, &e), &e, DLS_E_ARGUMENT, "A", 1, 3,
             "is outside of 0 .. 2");
  i[1] = -1;
  check_says(dlsi_check_sparse("A", &A, 3, 2, &e), &e, DLS_E_ARGUMENT, "A", 1, -1, "is outside");
  i[1] = 0;
  x[1] = NAN;
  check_says(dlsi_check_sparse("A", &A, 3, 2, &e), &e, DLS_E_NOT_FINITE, "A", 1, NAN, "not finite");
  p[1] = 3;
  check_says(dlsi_check_sparse("A", &A, 3, 2, &e), &e, DLS_E_ARGUMENT, "A", 2, 2,
             "is less than the one before it");
  p[0] = 1;
  check_says(dlsi_check_sparse("A", &A, 3, 2, &e), &e, DLS_E_ARGUMENT, "A", 0, 1, "must be 0");
  const dls_blocks large = {.d = 3, .n = INT_MAX / 3 + 1};
  check_says(dlsi_check_blocks(&large, &e), &e, DLS_E_SIZE, "B.n", -1, INT_MAX / 3 + 1,
             "is 715827883");
  const dls_blocks empty = {3, 0, (const int[1]){0}, NULL, NULL};
  ck_assert_int_eq(dlsi_check_blocks(&empty, NULL), DLS_OK);
  const dls_blocks most = {.d = 3, .n = INT_MAX / 3};
  check_says(dlsi_check_blocks(&most, &e), &e, DLS_E_ARGUMENT, "B.p", -1, 0, "NULL");
}

/* Friction of any size, infinite too; in one dimension none. */
TEST(friction) {
  const double W[4] = {1, 0, 0, 1}, q[2] = {0};
  double mu[2] = {0, INFINITY};
  dls_error e;
  ck_assert_int_eq(dlsi_check_friction(mu, 2, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_check_friction(NULL, 0, NULL), DLS_OK);
  mu[1] = -DBL_MAX;
  check_says(dlsi_check_friction(mu, 2, &e), &e, DLS_E_ARGUMENT, "mu", 1, -DBL_MAX, "is negative");
  mu[1] = -INFINITY;
  check_says(dlsi_check_friction(mu, 2, &e), &e, DLS_E_NOT_FINITE, "mu", 1, -INFINITY,
             "not finite");
  dls_contact p = {.d = 1, .nc = 2, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  mu[1] = 0;
  ck_assert_int_eq(dls_contact_check(&p, NULL), DLS_OK);
  mu[1] = 0.25;
  check_says(dls_contact_check(&p, &e), &e, DLS_E_ARGUMENT, "mu", 1, 0.25, "is 0.25, must be 0");
  p = (dls_contact){.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  ck_assert_int_eq(dlsi_first_bonded(&p), -1);
  ck_assert_int_eq(dlsi_refuse_bonded(&p, NULL), DLS_OK);
  mu[0] = INFINITY;
  ck_assert_int_eq(dlsi_first_bonded(&p), 0);
  check_says(dlsi_refuse_bonded(&p, &e), &e, DLS_E_UNSUPPORTED, "mu", 0, INFINITY, "is infinite");
}

/* A vector that is not needed may be anything. */
TEST(workspaces_and_starts) {
  const double W[16] = {1}, q[4] = {0}, mu[4] = {0}, r[4] = {0, 0, 0, NAN};
  dls_error e;
  const dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu}, none = {.d = 2};
  ck_assert_int_eq(dlsi_check_solve(2, 2, &p, r, NULL, 0, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_check_solve(2, 9, &none, NULL, NULL, 1, NULL), DLS_OK);
  check_says(dlsi_check_solve(2, 2, &p, r, NULL, 1, &e), &e, DLS_E_NOT_FINITE, "r", 3, NAN,
             "finite");
  check_says(dlsi_check_solve(2, 2, &p, NULL, NULL, 0, &e), &e, DLS_E_ARGUMENT, "r", -1, 0, "NULL");
  check_says(dlsi_check_solve(3, 2, &p, r, NULL, 0, &e), &e, DLS_E_SIZE, "problem", -1, 2,
             "has d = 2, the workspace is for 3");
  check_says(dlsi_check_solve(2, 1, &p, r, NULL, 0, &e), &e, DLS_E_SIZE, "problem", -1, 2,
             "has 2 candidates, the workspace is for 1");
}

/* Two storages at once; bodies of each shape. */
TEST(bodies) {
  const int p[2] = {0, 0};
  int body[4] = {-1, 1, 1, 0};
  double H[72] = {0}, q[6] = {0}, mu[2] = {0}, W[4] = {1, 0, 0, 1}, work[12];
  dls_error e;
  dls_contact problem = {.d = 2, .nc = 2, .q = q, .mu = mu, .bodies = {3, 2, body, H, NULL}};
  const dls_contact good = problem;
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  problem.d = 3;
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_SIZE, "bodies.n", -1, 3, "is 3, must be 6");
  problem.bodies.n = 6;
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  problem.d = 2;
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_SIZE, "bodies.n", -1, 6, "is 6, must be 3");
  problem.d = 1;
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  problem.bodies.n = 3;
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  problem.bodies.n = 4;
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_SIZE, "bodies.n", -1, 4, "must be 3 or 6");
  problem = good;
  problem.bodies.count = INT_MAX / 12;
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  problem.bodies.count++;
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_SIZE, "bodies.count", -1, INT_MAX / 12 + 1,
             "is 178956971");
  problem.bodies.count = -1;
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_SIZE, "bodies.count", -1, -1, "is -1");
  problem = good;
  problem.bodies.body = NULL;
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_ARGUMENT, "bodies.body", -1, 0, "NULL");
  problem = good;
  problem.bodies.work = work;
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_ARGUMENT, "bodies.work", -1, 0,
             "must be NULL");
  problem = good;
  problem.W = (dls_dense){4, 4, 4, W};
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_ARGUMENT, "bodies", -1, 0,
             "W and bodies are both given");
  problem = good;
  problem.Wb = (dls_blocks){2, 2, p, p, W};
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_ARGUMENT, "bodies", -1, 0,
             "Wb and bodies are both given");
  problem = good;
  const int wrong[4] = {-2, 2, INT_MIN, INT_MAX};
  for (int k = 0; k < 4; k++) {
    const int kept = body[k];
    body[k] = wrong[k];
    check_says(dls_contact_check(&problem, &e), &e, DLS_E_ARGUMENT, "bodies.body", k, wrong[k],
               "must be from -1 to 1");
    body[k] = kept;
  }
  body[3] = 1;
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_ARGUMENT, "bodies.body", 3, 1,
             "is 1, as the other body of candidate 1");
  body[3] = body[2] = 0;
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_ARGUMENT, "bodies.body", 3, 0,
             "is 0, as the other body of candidate 1");
  body[3] = -1, body[2] = -1; /* fixed on both sides */
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  body[3] = 0;
  H[0] = H[5] = H[12] = H[17] = NAN; /* of sides that are fixed */
  H[11] = 1e160;
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_NOT_FINITE, "bodies.H", 0, INFINITY,
             "gives a W that is not finite");
  H[11] = NAN;
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_NOT_FINITE, "bodies.H", 11, NAN,
             "not finite");
  H[11] = 0, H[23] = -INFINITY;
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_NOT_FINITE, "bodies.H", 23, -INFINITY,
             "not finite");
  H[23] = 0, H[18] = H[19] = 1e154; /* 2e308 */
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_NOT_FINITE, "bodies.H", 12, INFINITY,
             "gives a W that is not finite");
  H[19] = 0;
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  body[0] = body[1] = body[2] = body[3] = -1; /* no bodies but the fixed one */
  problem.bodies.count = 0;
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  problem =
      (dls_contact){.d = 2, .nc = 1, .W = {2, 2, 2, W}, .Wb = {2, 1, p, p, W}, .q = q, .mu = mu};
  check_says(dls_contact_check(&problem, &e), &e, DLS_E_ARGUMENT, "Wb", -1, 0,
             "W and Wb are both given");
}

/* The bounds of a setting belong to it, unless it is open; NaN is never within. */
TEST(settings_at_their_ends) {
  const struct {
    dlsi_setting set;
    const char *words; /* NULL: fine */
  } is[] = {{{"a", 0, 0, 1, 0}, NULL},
            {{"a", 1, 0, 1, 0}, NULL},
            {{"a", 0.5, 0, 1, 1}, NULL},
            {{"a", 0, 0, 1, 1}, "is 0, must be between 0 and 1"},
            {{"a", 1, 0, 1, 1}, "is 1, must be between 0 and 1"},
            {{"a", -0.5, 0, 1, 0}, "is -0.5, must be from 0 to 1"},
            {{"a", 2, 0, 1, 0}, "is 2, must be from 0 to 1"},
            {{"a", NAN, 0, 1, 0}, "must be from 0 to 1"},
            {{"a", -1, 0, INT_MAX, 0}, "is -1, must be >= 0, finite"},
            {{"a", 0, 0, DBL_MAX, 1}, "is 0, must be > 0, finite"},
            {{"a", INFINITY, 0, DBL_MAX, 1}, "must be > 0, finite"},
            {{"a", 5, 6, INT_MAX - 1., 0}, "is 5, must be from 6 to 2.14748e+09"}};
  for (size_t k = 0; k < sizeof is / sizeof is[0]; k++) {
    const dlsi_setting both[2] = {{"b", 1, 1, 1, 0}, is[k].set};
    dls_error e;
    const dls_status status = dlsi_check_each(2, both, &e);
    if (is[k].words)
      check_says(status, &e, DLS_E_ARGUMENT, "a", -1, is[k].set.value, is[k].words);
    else
      ck_assert_int_eq(status, DLS_OK);
    ck_assert_int_eq(dlsi_check_each(1, both, &e), DLS_OK);
  }
}

/* Each limit at its ends, and beyond. */
TEST(limits_at_their_ends) {
  dls_limits limits;
  dls_error e;
  dlsi_limits_init(&limits);
  ck_assert(limits.tol == 1e-8 && limits.threads == 1 && limits.max_iterations == 0);
  limits.tol = DBL_MAX, limits.cpu_seconds = DBL_MAX;
  limits.max_iterations = limits.blocks = INT_MAX;
  limits.warm_start = 1, limits.threads = 1024;
  ck_assert_int_eq(dlsi_check_limits(&limits, NULL), DLS_OK);
  limits.tol = limits.cpu_seconds = 0, limits.warm_start = limits.threads = 0;
  limits.max_iterations = limits.blocks = 0;
  ck_assert_int_eq(dlsi_check_limits(&limits, NULL), DLS_OK);
  const dls_limits good = limits;
  limits.tol = INFINITY;
  check_says(dlsi_check_limits(&limits, &e), &e, DLS_E_ARGUMENT, "tol", -1, INFINITY,
             "must be >= 0");
  limits = good, limits.max_iterations = -1;
  check_says(dlsi_check_limits(&limits, &e), &e, DLS_E_ARGUMENT, "max_iterations", -1, -1, "is -1");
  limits = good, limits.warm_start = 2;
  check_says(dlsi_check_limits(&limits, &e), &e, DLS_E_ARGUMENT, "warm_start", -1, 2,
             "from 0 to 1");
  limits = good, limits.blocks = -1;
  check_says(dlsi_check_limits(&limits, &e), &e, DLS_E_ARGUMENT, "blocks", -1, -1, "is -1");
  limits = good, limits.threads = 1025;
  check_says(dlsi_check_limits(&limits, &e), &e, DLS_E_ARGUMENT, "threads", -1, 1025, "0 to 1024");
  limits = good, limits.cpu_seconds = -1;
  check_says(dlsi_check_limits(&limits, &e), &e, DLS_E_ARGUMENT, "cpu_seconds", -1, -1, "is -1");
  const dlsi_setting own = {"own", 2, 0, 1, 0};
  ck_assert_int_eq(dlsi_check_settings(&good, 8, 8, 0, &own, NULL), DLS_OK);
  check_says(dlsi_check_settings(&good, 8, 8, 1, &own, &e), &e, DLS_E_ARGUMENT, "own", -1, 2,
             "is 2");
  check_says(dlsi_check_settings(&good, 7, 8, 0, &own, &e), &e, DLS_E_SETTINGS, "settings", -1, 7,
             "init function");
}

/* Returns 1 if the text is UTF-8 that a terminal may get. */
static int is_shown(const char *text) {
  int length;
  for (long code; (code = dlsi_utf8_next(text, &length)) != 0; text += length)
    if (dlsi_utf8_is_control(code)) return 0;
  return 1;
}

/* A message holds no control, whatever it quotes and wherever it is cut, and a public name before
 * it leaves it so. */
TEST(messages_without_controls) {
  static const char hidden[] = "\001\n\t\033[2J\x7f\xc2\x9b\xe2\x80\xae\xff\xed\xa0\x80";
  dls_error e;
  ck_assert_int_eq(dlsi_fail(&e, DLS_E_FORMAT, "path", 3, 0, "line %lld, '%s'", 3LL, hidden),
                   DLS_E_FORMAT);
  ck_assert_str_eq(e.message, "path[3]: line 3, '\\x01\\n\\t\\x1b[2J\\x7f\\xc2\\x9b\\xe2\\x80\\xae"
                              "\\xff\\xed\\xa0\\x80'");
  (void)dlsi_at("dls_text_read", e.status, &e);
  ck_assert(strstr(e.message, "dls_text_read: path[3]: line 3, '\\x01\\n") == e.message);
  (void)dlsi_at("dls_read", e.status, &e); /* takes the place of the first */
  ck_assert(strstr(e.message, "dls_read: path[3]: line 3, '\\x01\\n") == e.message);
  /* a character of 4 bytes after any number of letters */
  char text[200];
  for (size_t letters = 0; letters < 180; letters++) {
    memset(text, 'a', letters);
    memcpy(text + letters, "\xf0\x9f\x98\x80\xf0\x9f\x98\x80", 9);
    (void)dlsi_fail(&e, DLS_E_FORMAT, "path", 3, 0, "line %lld, '%s'", 3LL, text);
    ck_assert_msg(is_shown(e.message), "%zu: %s", letters, e.message);
    (void)dlsi_at("dls_a_function_with_a_name_of_some_50_characters_", e.status, &e);
    ck_assert_msg(is_shown(e.message), "%zu: %s", letters, e.message);
  }
}
