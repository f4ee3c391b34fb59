/* fuzz_problems.c: LCPs, contact problems by every method, reductions and motions made of any
 * bytes, their settings, too. Answers reported as solved are certified again. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "delassus.h"
#include "delassus/moving.h"
#include "fuzz.h"

enum { most_m = fuzz_rows, most_n = 14 }; /* rows of W or of an LCP, unknowns of a model */

static const double tols[] = {1e-8, 1e-8, 1e-10, 1e-12, 0, 1e-3, 1, 1e300};

/* Fills a (m x m, ld m): values, or F F^T + s with positive definite or singular outcome. */
static void take_matrix(fuzz_bytes *b, int m, double *a) {
  const int kind = take_byte(b) % 5;
  const double scale = take_scale(b);
  double F[most_m * most_m];
  for (int k = 0; k < m * m; k++)
    F[k] = kind < 4 ? take_plain(b) : take_value(b);
  const double shift = kind == 0 ? 1 : kind == 1 ? 1e-7 : 0;
  for (int i = 0; i < m; i++)
    for (int j = 0; j < m; j++) {
      double sum = i == j ? shift : 0;
      for (int k = 0; k < m; k += kind == 2 ? 2 : 1)
        sum += F[i + m * k] * F[j + m * k];
      a[i + m * j] = scale * (kind < 3 ? sum : F[i + m * j]);
    }
  for (int k = take_byte(b) % 8; k > 6; k--) /* now and then, one odd entry */
    if (m) {
      const int i = take_byte(b) % m, j = take_byte(b) % m; /* in turn, by any compiler */
      a[i + m * j] = take_value(b);
    }
}

void take_vector(fuzz_bytes *b, int n, double *x) {
  const double scale = take_scale(b);
  const int odd = take_byte(b) < 32;
  for (int k = 0; k < n; k++)
    x[k] = scale * (odd ? take_value(b) : take_plain(b));
}

void take_limits(fuzz_bytes *b, struct dls_limits *limits) {
  limits->tol = tols[take_byte(b) % 8];
  limits->max_iterations = take_byte(b) < 200 ? take_int(b, 1, 300) : 0;
  limits->warm_start = take_byte(b) & 1;
}

/* ---- LCPs ------------------------------------------------------------------------------------ */

void fuzz_lcp(const unsigned char *data, size_t size) {
  fuzz_bytes b = {data, size};
  const int n = take_int(&b, 1, 10), capacity = take_int(&b, 1, 4);
  double *M = fuzz_doubles(NULL, n * n), *q = fuzz_doubles(NULL, n), *z = fuzz_doubles(NULL, n);
  double *y = fuzz_doubles(NULL, n), *list = fuzz_doubles(NULL, capacity * n);
  take_matrix(&b, n, M);
  take_vector(&b, n, q);
  take_vector(&b, n, z);
  const dls_lcp lcp = {.n = n, .M = {n, n, n, M}, .q = q};
  dls_lcp_certificate seen;
  dls_lemke_settings settings;
  dls_principal_settings principal;
  dls_lemke_info info;
  dls_lemke *lemke;
  dls_principal *pivoting;
  dls_enumeration found;
  dls_error error;
  dls_lemke_settings_init(&settings);
  take_limits(&b, &settings.limits);
  settings.crash = take_byte(&b) & 1;
  FUZZ_CHECK(dls_lemke_create(&lemke, n, &settings, &error) == DLS_OK);
  for (int pass = 0; pass < 2; pass++) { /* twice in one workspace */
    const dls_status status = dls_lemke_solve(lemke, &lcp, z, y, &info, &error);
    if (status < 0) break;
    FUZZ_CHECK(dls_lcp_certify(&lcp, z, NULL, &seen, &error) == DLS_OK);
    if (status == DLS_OK) FUZZ_CHECK(dls_lcp_certificate_holds(&seen, settings.limits.tol));
    double *dz = fuzz_doubles(NULL, n), *cover = fuzz_doubles(NULL, n), z0, dz0, violation;
    if (dls_lemke_ray(lemke, z, &z0, dz, &dz0, cover, &error) == DLS_OK) {
      FUZZ_CHECK(status == DLS_RAY || status == DLS_NO_SOLUTION);
      (void)!dls_lcp_check_ray(&lcp, cover, z, z0, dz, dz0, &violation, &error);
    }
    if (status == DLS_NO_SOLUTION) {
      FUZZ_CHECK(dls_lemke_farkas(lemke, y, &error) == DLS_OK);
      FUZZ_CHECK(dls_lcp_check_farkas(&lcp, y, &violation, &error) == DLS_OK);
    }
  }
  dls_lemke_destroy(lemke);
  dls_principal_settings_init(&principal);
  take_limits(&b, &principal.limits);
  FUZZ_CHECK(dls_principal_create(&pivoting, n, &principal, &error) == DLS_OK);
  if (dls_principal_solve(pivoting, &lcp, z, y, NULL, &error) == DLS_OK) {
    FUZZ_CHECK(dls_lcp_certify(&lcp, z, NULL, &seen, &error) == DLS_OK);
    FUZZ_CHECK(dls_lcp_certificate_holds(&seen, principal.limits.tol));
  }
  dls_principal_destroy(pivoting);
  if (n <= 8 && dls_lcp_enumerate(&lcp, 1e-8, capacity, list, &found, &error) == DLS_OK)
    for (int k = 0; k < found.solutions; k++)
      FUZZ_CHECK(dls_lcp_certify(&lcp, list + k * n, NULL, &seen, &error) == DLS_OK &&
                 dls_lcp_certificate_holds(&seen, 1e-8));
}

/* ---- contact problems ------------------------------------------------------------------------ */

void fuzz_solve(const dls_contact *problem, fuzz_bytes *b) {
  const int m = problem->d * problem->nc;
  const size_t bytes = (size_t)m * sizeof(double);
  double *r = fuzz_doubles(NULL, m), *u = fuzz_doubles(NULL, m), before[most_m];
  dls_solver_settings settings;
  dls_certificate seen;
  dls_solver *solver;
  dls_info info;
  dls_error error;
  int methods = 0;
  while (dls_method_name((dls_method)methods))
    methods++;
  dls_solver_settings_init(&settings);
  take_limits(b, &settings.limits);
  settings.method = (dls_method)take_int(b, 0, methods);
  settings.acceleration = (dls_acceleration)take_int(b, 0, 4);
  settings.facets = take_byte(b) < 200 ? 0 : take_int(b, -2, 70);
  settings.limits.blocks = problem->Wb.x ? problem->Wb.p[problem->nc] : 0;
  if (problem->bodies.H && take_byte(b) < 128)
    (void)!dls_bodies_count(problem, &settings.limits.blocks, &error);
  take_vector(b, m, r);
  if (dls_solver_create(&solver, problem->d, problem->nc, &settings, &error)) {
    FUZZ_CHECK(solver == NULL);
    return;
  }
  for (int pass = 0; pass < 2; pass++) {
    memcpy(before, r, bytes);
    const dls_status status = dls_solver_solve(solver, problem, r, u, &info, &error);
    if (status < 0) {
      FUZZ_CHECK(memcmp(before, r, bytes) == 0 && error.status == status);
      break;
    }
    FUZZ_CHECK(info.status == status);
    FUZZ_CHECK(dls_contact_certify(problem, r, NULL, &seen, &error) == DLS_OK);
    if (status == DLS_OK) FUZZ_CHECK(dls_certificate_holds(&seen, settings.limits.tol));
    const double *direction = dls_solver_direction(solver), *proof = dls_solver_farkas(solver);
    FUZZ_CHECK(status != DLS_OK || (!direction && !proof));
    for (int k = 0; direction && k < m; k++)
      FUZZ_CHECK(isfinite(direction[k]));
    for (int k = 0; proof && k < problem->nc; k++)
      FUZZ_CHECK(proof[k] >= 0);
    take_limits(b, &settings.limits);
    if (dls_solver_set_limits(solver, &settings.limits, &error)) break;
  }
  dls_solver_destroy(solver);
}

/* Asks for what is known of a problem. */
static void look_at(const dls_contact *problem, fuzz_bytes *b) {
  double r[4 * most_m] = {0}, low[4 * most_m], high[4 * most_m];
  dls_diagnosis facts;
  dls_solution_set found;
  dls_sensitivity sensitivity;
  dls_fold fold;
  dls_contact_state state[most_m];
  dls_error error;
  const int what = take_byte(b);
  if (what < 64)
    (void)!dls_contact_diagnose(problem, 20, &facts, &error);
  else if (what < 80 && problem->nc <= 3)
    (void)!dls_contact_enumerate(problem, 1e-8, 4, r, low, high, &found, &error);
  else if (what < 96)
    (void)!dls_contact_sensitivity(problem, r, &sensitivity, &error);
  else if (what < 104 && problem->nc <= 3)
    (void)!dls_contact_fold(problem, &fold, state, r, low, high, &error);
}

/* W = H^T H: each candidate presses on two of up to four bodies, or on fixed ones. */
static void take_bodies(fuzz_bytes *b, int d, int nc, dls_bodies *bodies) {
  static double H[2 * 6 * 3 * 5];
  static int body[2 * 5];
  const int n = d == 3 || take_byte(b) < 16 ? 6 : 3, count = take_int(b, 0, 4);
  for (int k = 0; k < 2 * nc; k++)
    body[k] = take_byte(b) < 4 ? take_int(b, -3, 5) : count ? take_byte(b) % (count + 1) - 1 : -1;
  take_vector(b, 2 * n * d * nc, H);
  *bodies = (dls_bodies){.n = n,
                         .count = count,
                         .body = fuzz_ints(body, 2 * nc),
                         .H = fuzz_doubles(H, 2 * n * d * nc)};
}

void take_contact(fuzz_bytes *b, struct dls_contact *problem) {
  static double W[most_m * most_m], q[most_m], mu[most_m], x[9 * most_m];
  static int p[most_m + 1], i[most_m];
  const int d = take_int(b, 1, 3), nc = take_int(b, 0, most_m / d < 5 ? most_m / d : 5);
  const int m = d * nc, storage = take_byte(b);
  *problem = (dls_contact){.d = d, .nc = nc};
  if (storage < 150) {
    take_matrix(b, m, W);
    problem->W = (dls_dense){m, m, m, fuzz_doubles(W, m * m)};
  } else if (storage < 200)
    take_bodies(b, d, nc, &problem->bodies);
  else {
    const int entries = take_int(b, 0, most_m);
    for (int k = 0; k < entries; k++) {
      const int byte = take_byte(b), odd = take_byte(b) < 4;
      i[k] = nc ? byte % (nc + odd) : 0;
    }
    for (int c = 0; c <= nc; c++)
      p[c] = c * entries / (nc ? nc : 1);
    if (!nc) p[0] = 0;
    take_vector(b, d * d * entries, x);
    problem->Wb = (dls_blocks){d, nc, fuzz_ints(p, nc + 1), fuzz_ints(i, entries),
                               fuzz_doubles(x, d * d * entries)};
  }
  take_vector(b, m, q);
  for (int c = 0; c < nc; c++) {
    const int kind = take_byte(b);
    mu[c] = kind < 200 ? kind / 100.0 : kind < 220 ? 0 : kind < 240 ? INFINITY : take_value(b);
    if (d == 1 && kind < 250) mu[c] = 0;
  }
  problem->q = fuzz_doubles(q, m);
  problem->mu = fuzz_doubles(mu, nc);
}

void fuzz_contact(const unsigned char *data, size_t size) {
  fuzz_bytes b = {data, size};
  dls_contact problem;
  take_contact(&b, &problem);
  look_at(&problem, &b);
  fuzz_solve(&problem, &b);
}

/* ---- reductions ------------------------------------------------------------------------------ */

typedef struct columns {
  int *p, *i;
  double *x;
} columns;

/* Fills a sparse matrix with entries all over, or with diagonal ones, too. */
static dls_sparse take_columns(fuzz_bytes *b, int rows, int cols, int diagonal, columns *own) {
  enum { most = 6 * most_n };
  const int odd = take_byte(b) < 8;
  int p[3 * most_n + 1], i[most], count = 0;
  double x[most];
  for (int j = 0; j < cols; j++) {
    p[j] = count;
    for (int k = take_byte(b) % 3; k >= 0 && count < most; k--, count++) {
      i[count] = diagonal && k == 0 ? j : take_byte(b) % rows;
      x[count] = diagonal && k == 0 ? 4 + take_plain(b) : take_plain(b);
    }
  }
  p[cols] = count;
  *own = (columns){fuzz_ints(p, cols + 1), fuzz_ints(i, count), fuzz_doubles(x, count)};
  if (odd && count) own->i[take_byte(b) % count] = take_int(b, -1, rows);
  if (odd && count) own->x[take_byte(b) % count] = take_value(b);
  if (odd && take_byte(b) < 64) own->p[take_byte(b) % (cols + 1)] = take_int(b, -1, count);
  return (dls_sparse){rows, cols, own->p, own->i, own->x};
}

typedef struct host {
  int fails, odd;
} host;

/* Divides by 2: the host's own factorisation; now and then it fails. */
static int host_solve(void *user, double *X, int n, int nrhs) {
  host *h = user;
  for (int k = 0; k < n * nrhs; k++)
    X[k] /= 2;
  if (h->odd && n) X[0] = NAN;
  return h->fails-- == 1;
}

/* Solves a model by the method on displacements. */
static void solve_primal(fuzz_bytes *b, const dls_model *model, const double *f, const double *g,
                         const double *mu) {
  const int candidates = model->P.p ? model->P.cols : model->nodes, m = model->d * candidates;
  double *x = fuzz_doubles(NULL, model->n), *r = fuzz_doubles(NULL, m), *u = fuzz_doubles(NULL, m);
  dls_primal_settings settings;
  dls_primal_info info;
  dls_primal *work;
  dls_error error;
  dls_primal_settings_init(&settings);
  take_limits(b, &settings.limits);
  settings.aitken = take_byte(b) & 1;
  if (take_byte(b) < 30) settings.relaxation = take_plain(b);
  const dls_status status = dls_primal_create(&work, model, &settings, &error);
  FUZZ_CHECK((status == DLS_OK) == (work != NULL));
  take_vector(b, model->n, x);
  for (int pass = 0; pass < 2 && work; pass++) {
    const dls_status end = dls_primal_solve(work, f, g, mu, x, r, u, &info, &error);
    if (end < 0) break;
    FUZZ_CHECK(info.status == end);
    if (end == DLS_OK)
      FUZZ_CHECK(info.equilibrium <= fmax(settings.limits.tol, 4 * info.equilibrium_floor));
  }
  dls_primal_destroy(work);
}

/* Solves a model on K, and once more after an update. */
static void solve_global(fuzz_bytes *b, const dls_model *model, const double *f, const double *g) {
  dls_global *global;
  dls_global_info cost;
  dls_solver_settings settings; /* for its limits */
  dls_info info;
  dls_error error;
  int body;
  (void)!dls_global_estimate(model, &cost, &error);
  const dls_status status = dls_global_create(&global, model, &error);
  FUZZ_CHECK((status == DLS_OK) == (global != NULL));
  if (status) return;
  const int contacts = dls_global_contacts(global), m = model->d * contacts;
  double *r = fuzz_doubles(NULL, m), *x = fuzz_doubles(NULL, model->n);
  double *mu = fuzz_doubles(NULL, contacts);
  take_vector(b, m, r);
  take_vector(b, model->n, x);
  for (int c = 0; c < contacts; c++)
    mu[c] = take_byte(b) / 100.0;
  dls_solver_settings_init(&settings);
  for (int pass = 0; pass < 2; pass++) {
    take_limits(b, &settings.limits);
    const int left_out = take_byte(b);
    const dls_status end = dls_global_solve(
        global, left_out & 1 ? f : NULL, left_out & 2 ? g : NULL, left_out & 4 ? mu : NULL,
        &settings.limits, r, x, left_out & 8 ? &info : NULL, &error);
    if (end < 0) break;
    const double *motion = dls_global_motion(global, &body);
    FUZZ_CHECK((motion != NULL) == (end == DLS_NO_SOLUTION));
    for (int i = 0; motion && i < model->n; i++)
      FUZZ_CHECK(isfinite(motion[i]));
    if (dls_global_update(global, model, &error)) break;
  }
  (void)!dls_global_get_info(global, &cost, &error);
  dls_global_destroy(global);
}

/* Solves the problem of a loaded reduction on W or on K, and differentiates the answer. */
static void solve_reduced(fuzz_bytes *b, dls_reduction *reduction, const dls_model *model,
                          const double *mu, int m, int contacts) {
  const int n = model->n, nodal = model->d * model->nodes, what = take_byte(b);
  const int values = model->operator_kind == DLS_STIFFNESS_SPARSE ? model->Ks.p[n] : n * n;
  double *r = fuzz_doubles(NULL, m), *u = fuzz_doubles(NULL, m), *x = fuzz_doubles(NULL, n);
  dls_solver_settings settings;
  dls_info info;
  dls_error error;
  dls_derive *derive;
  dls_solver_settings_init(&settings);
  take_limits(b, &settings.limits);
  settings.method = (dls_method)take_int(b, 0, 8);
  if (dls_reduction_solve(reduction, mu, what & 1 ? &settings : NULL, r, what & 2 ? u : NULL, x,
                          what & 4 ? &info : NULL, &error))
    return;
  if (dls_derive_create_body(&derive, reduction, mu, r, x, what % 3 - 1, &error)) return;
  take_vector(b, m, u);
  const dls_derive_data data = {
      fuzz_doubles(NULL, contacts), NULL, NULL, fuzz_doubles(NULL, n), fuzz_doubles(NULL, nodal),
      fuzz_doubles(NULL, values)};
  const dls_derive_answer loss = {u, NULL, NULL}, moved = {fuzz_doubles(NULL, m), NULL, x};
  if (dls_derive_vjp(derive, &loss, &data, &error) == DLS_OK)
    (void)!dls_derive_jvp(derive, &data, &moved, &error);
  dls_derive_destroy(derive);
}

/* Loads a reduction and asks for all that it returns. */
static void look_at_reduction(fuzz_bytes *b, dls_reduction *reduction, const dls_model *model) {
  const int candidates = model->P.p ? model->P.cols : model->nodes;
  int contacts = 0;
  for (int c = 0; c < candidates; c++)
    contacts += !model->active || model->active[c];
  double *f = fuzz_doubles(NULL, model->n), *g = fuzz_doubles(NULL, model->d * model->nodes);
  double *mu = fuzz_doubles(NULL, contacts), *x = fuzz_doubles(NULL, model->n);
  double *nodal = fuzz_doubles(NULL, model->d * model->nodes);
  dls_contact problem;
  dls_error error;
  take_vector(b, model->n, f);
  take_vector(b, model->d * model->nodes, g);
  for (int c = 0; c < contacts; c++)
    mu[c] = take_byte(b) / 100.0;
  const int loaded_free = take_byte(b) < 30;
  const dls_status loaded = loaded_free ? dls_reduction_load_free(reduction, f, g, &error)
                                        : dls_reduction_load(reduction, f, g, &error);
  if (loaded || dls_reduction_contact(reduction, mu, &problem, &error)) return;
  const int m = problem.d * problem.nc;
  FUZZ_CHECK(problem.nc == contacts);
  if (m <= most_m) fuzz_solve(&problem, b);
  if (take_byte(b) < 60) solve_reduced(b, reduction, model, mu, m, contacts);
  double *r = fuzz_doubles(NULL, m);
  take_vector(b, m, r);
  (void)!dls_reduction_recover(reduction, r, x, &error);
  (void)!dls_reduction_nodal(reduction, r, nodal, &error);
}

/* Updates a reduction, to good models and bad ones, and looks at it, in turns. What it was made of
 * stays in use: the models differ in the arrays that they point to. */
static void use_reduction(fuzz_bytes *b, dls_reduction *reduction, dls_model *model, columns *K) {
  static columns other, HN, HT;
  double a[most_m * most_m];
  dls_error error;
  look_at_reduction(b, reduction, model);
  for (int turn = take_int(b, 0, 4); turn > 0; turn--) {
    dls_model next = *model;
    switch (take_byte(b) % 8) {
    case 0: /* another pattern */
      next.Ks = take_columns(b, model->n, model->n, 1, &other);
      break;
    case 1: /* other operators */
      next.HN = take_columns(b, model->n, model->nodes, 0, &HN);
      next.HT = take_columns(b, model->n, (model->d - 1) * model->nodes, 0, &HT);
      break;
    case 2: /* another dense K */
      take_matrix(b, model->n, a);
      next.K.a = fuzz_doubles(a, model->n * model->n);
      break;
    case 3: /* other sizes and kinds */
      next.n = take_int(b, 0, model->n);
      next.nodes = take_int(b, 0, model->nodes);
      next.operator_kind = (dls_operator)take_int(b, 0, 5);
      break;
    case 4: /* a value that may be none */
      if (K->p[model->n] > 0) K->x[take_int(b, 0, K->p[model->n] - 1)] = take_value(b);
      break;
    default: /* other values */
      for (int k = 0; k < K->p[model->n]; k++)
        K->x[k] *= 1.5;
    }
    const dls_status status = dls_reduction_update(reduction, &next, &error);
    FUZZ_CHECK(status <= 0);
    if (status == DLS_OK && next.n != model->n) FUZZ_CHECK(0);
    if (status == DLS_OK) *model = next; /* on K another pattern is taken */
    look_at_reduction(b, reduction, model);
  }
}

void fuzz_reduction(const unsigned char *data, size_t size) {
  fuzz_bytes b = {data, size};
  static columns K, HN, HT, P;
  double a[most_m * most_m];
  const int n = take_int(&b, 1, most_n), d = take_int(&b, 2, 3), nodes = take_int(&b, 0, 4);
  host own = {take_byte(&b) % 16, take_byte(&b) < 8};
  dls_model model = {.d = d, .n = n, .nodes = nodes, .solve = host_solve, .user = &own};
  model.operator_kind = (dls_operator)(take_byte(&b) < 250 ? take_int(&b, 1, 4) : 5);
  model.factorization = (dls_factorization)(take_byte(&b) < 250 ? take_int(&b, 1, 3) : 4);
  take_matrix(&b, n, a);
  model.K = (dls_dense){n, n, n, fuzz_doubles(a, n * n)};
  model.Ks = take_columns(&b, n, n, 1, &K);
  model.HN = take_columns(&b, n, nodes, 0, &HN);
  model.HT = take_columns(&b, n, (d - 1) * nodes, 0, &HT);
  int candidates = nodes;
  if (take_byte(&b) < 40) {
    candidates = take_int(&b, 0, nodes);
    model.P = take_columns(&b, nodes ? nodes : 1, candidates, 0, &P);
  }
  double *f = fuzz_doubles(NULL, n), *g = fuzz_doubles(NULL, d * nodes);
  double *mu = fuzz_doubles(NULL, candidates);
  int *active = fuzz_ints(NULL, candidates);
  take_vector(&b, n, f);
  take_vector(&b, d * nodes, g);
  for (int c = 0; c < candidates; c++) {
    mu[c] = take_byte(&b) / 100.0;
    active[c] = take_byte(&b) < 200;
  }
  if (take_byte(&b) < 40) model.active = active;
  if (take_byte(&b) < 40) model.mu = mu;
  dls_reduction_settings settings;
  dls_reduction_settings_init(&settings);
  const int how = take_byte(&b);
  settings.allow_indefinite = how & 1;
  settings.on = how >> 1 & 1 ? DLS_ON_EITHER : DLS_ON_W;
  settings.form_W = how % 16 != 4;
  settings.frictionless = how % 16 == 8;
  dls_reduction *reduction;
  dls_reduction_info info;
  dls_error error;
  (void)!dls_reduction_estimate(&model, &settings, &info, &error);
  if (take_byte(&b) < 30) solve_primal(&b, &model, f, g, mu);
  if (take_byte(&b) < 60) solve_global(&b, &model, f, g);
  const dls_status status = dls_reduction_create(&reduction, &model, &settings, &error);
  FUZZ_CHECK((status == DLS_OK) == (reduction != NULL));
  if (status) return;
  use_reduction(&b, reduction, &model, &K);
  (void)!dls_reduction_get_info(reduction, &info, &error);
  dls_reduction_destroy(reduction);
}

/* ---- motions --------------------------------------------------------------------------------- */

/* Runs a few steps of a scene with any settings. */
static void move_scene(fuzz_bytes *b) {
  int scenes = 0;
  while (dls_moving_name(scenes))
    scenes++;
  dls_moving_settings s;
  dls_moving_data seen;
  dls_moving *moving;
  dls_error error;
  dls_moving_settings_init(&s);
  s.limits.tol = tols[take_byte(b) % 8];
  s.limits.max_iterations = take_int(b, -1, 200);
  s.law = (dls_motion_law)take_int(b, 0, 4);
  s.method = (dls_method)take_int(b, 0, 12);
  s.mass = (dls_fe_mass_kind)take_int(b, 0, 3);
  double *const values[] = {&s.theta,   &s.restitution, &s.mu,
                            &s.courant, &s.amplitude,   &s.frequency};
  for (size_t k = 0; k < sizeof values / sizeof *values; k++)
    if (take_byte(b) < 60) *values[k] = take_byte(b) < 128 ? take_plain(b) : take_value(b);
  s.steps = take_int(b, -1, 60);
  s.nx = take_int(b, -1, 5);
  s.ny = take_int(b, -1, 5);
  if (s.nx == 0) s.nx = 1; /* 0 is the scene's own mesh, which is larger than an input should be */
  if (s.ny == 0) s.ny = 1;
  s.upper = take_int(b, -1, 5);
  s.measure = take_byte(b) & 1;
  const char *name = dls_moving_name(take_byte(b) % scenes);
  const dls_status status = dls_moving_create(&moving, name, &s, &error);
  FUZZ_CHECK((status == DLS_OK) == (moving != NULL));
  for (int k = 0; k < 2 && !status; k++) {
    if (dls_moving_step(moving, &error)) break;
    dls_moving_get(moving, &seen);
    FUZZ_CHECK(seen.step == k + 1);
  }
  dls_moving_destroy(moving);
}

/* Asks for all that a motion returns, and changes its step and limits. */
static void look_at_motion(dls_motion *motion, fuzz_bytes *b) {
  dls_motion_state state;
  dls_motion_energies energies;
  dls_contact problem;
  dls_limits limits = {0};
  dls_error error;
  FUZZ_CHECK(dls_motion_get_state(motion, &state, &error) == DLS_OK);
  for (int i = 0; i < state.n; i++)
    FUZZ_CHECK(isfinite(state.x[i]) && isfinite(state.v[i]));
  for (int k = 0; k < state.active; k++)
    FUZZ_CHECK(state.active_list[k] >= 0 && state.active_list[k] < state.candidates);
  (void)!dls_motion_get_energies(motion, &energies, &error);
  if (dls_motion_get_problem(motion, &problem, &error) == DLS_OK && problem.nc > 0)
    FUZZ_CHECK(dls_contact_check(&problem, &error) == DLS_OK);
  if (take_byte(b) < 30) {
    take_limits(b, &limits);
    (void)!dls_motion_set_limits(motion, &limits, &error);
  }
  if (take_byte(b) < 30)
    (void)!dls_motion_set_h(motion, take_byte(b) < 128 ? 0.02 : take_value(b), &error);
}

/* Moves bodies of any matrices. */
static void move_model(fuzz_bytes *b) {
  static columns M, C, K, HN, HT;
  double gap[most_n], x[most_n], v[most_n], f[most_n];
  const int n = take_int(b, 1, most_n), d = take_int(b, 2, 3), nodes = take_int(b, 0, 4);
  dls_motion_model model = {.d = d, .n = n, .nodes = nodes, .gap = gap};
  model.factorization = (dls_factorization)take_int(b, 1, 3);
  if (take_byte(b) < 220) model.M = take_columns(b, n, n, 1, &M);
  if (take_byte(b) < 60) model.C = take_columns(b, n, n, 1, &C);
  if (take_byte(b) < 180) model.K = take_columns(b, n, n, 1, &K);
  model.HN = take_columns(b, n, nodes, 0, &HN);
  model.HT = take_columns(b, n, (d - 1) * nodes, 0, &HT);
  take_vector(b, nodes, gap);
  take_vector(b, n, x);
  take_vector(b, n, v);
  take_vector(b, n, f);
  dls_motion_settings s;
  dls_motion_settings_init(&s);
  s.h = take_byte(b) < 230 ? 0.01 : take_value(b);
  s.law = (dls_motion_law)take_int(b, 1, 3);
  s.theta = s.law == DLS_MOTION_GAP ? 1 : 0.5 + take_byte(b) / 500.0;
  s.restitution = take_byte(b) < 128 ? 0 : take_byte(b) / 250.0;
  s.activation = take_byte(b) < 200 ? 0 : take_value(b);
  s.forecast = take_byte(b) / 250.0;
  s.limits.max_iterations = take_int(b, 0, 200);
  double mu[most_n];
  for (int c = 0; c < most_n; c++)
    mu[c] = take_byte(b) / 100.0;
  dls_motion *motion;
  dls_error error;
  if (dls_motion_create(&motion, &model, &s, &error)) {
    FUZZ_CHECK(motion == NULL);
    return;
  }
  if (dls_motion_start(motion, x, v, 0, &error) == DLS_OK)
    for (int k = 0; k < 3; k++) {
      if (dls_motion_step(motion, f, NULL, mu, NULL, &error)) break;
      look_at_motion(motion, b);
    }
  dls_motion_destroy(motion);
}

void fuzz_motion(const unsigned char *data, size_t size) {
  fuzz_bytes b = {data, size};
  (take_byte(&b) < 80 ? move_scene : move_model)(&b);
}
