/*
 * test_jean.c: computes the four tables of [Jean 1988] Figs. 3 and 4 from end to end: scene,
 * reduction, Gauss-Seidel and Lemke, recovery.
 *
 * The tolerances, relative to a column's largest value, are those of data/jean-1988/README.md: the
 * paper stopped at a relative change of 1e-4. All that does not depend on the print is tested to
 * the solvers' tolerance.
 */
#include "delassus.h"
#include "delassus/fe.h"
#include "made.h"
#include "reduced.h"
#include "run.h"

enum { nc = 16, m = 2 * nc, line = 17, n = 296, mesh_n = 306 };
enum { Q1, Q2, RT, RN, RT_EQUIVALENT, RN_EQUIVALENT, columns };

static const double tol = 1e-12;

/* agreement: relative difference of two methods' answers; tight: tolerance of the iterative one.
 * The conditioning of the problem stands between residual and error of the reactions: a factor of
 * 18 and 110 (concentrated, Figs. 3 and 4), 470 and 840 (weighted), measured by stopping
 * Gauss-Seidel at 1e-12. tight is above 4 floor_u = 2e-15. */
static const double agreement = 1e-10, tight = 1e-14;

typedef struct table {
  const char *scene;
  int weighted;
  const char *file;
  double Rx, Ry;                 /* printed resultants of the listed reactions */
  const char *states;            /* f free, s slip, k stick; NULL where the paper names none */
  double displacement, reaction; /* tolerances */
} table;

static const table tables[] = {
    {"jean-fig3", 0, TEST_DATA "/jean-1988/fig3_concentrated.csv", -0.11691e7, 0.18583e7,
     "fffffssssssskkkk", 3e-4, 5e-4},
    {"jean-fig3", 1, TEST_DATA "/jean-1988/fig3_weighted.csv", -0.11729e7, 0.18946e7, NULL, 3e-4,
     4e-3},
    {"jean-fig4", 0, TEST_DATA "/jean-1988/fig4_concentrated.csv", -0.19286e6, 0.19286e7,
     "ssssssssssssssss", 3e-4, 5e-4},
    {"jean-fig4", 1, TEST_DATA "/jean-1988/fig4_weighted.csv", -0.19483e6, 0.19483e7,
     "ssssssssssssssss", 3e-4, 4e-3},
};
enum { table_count = sizeof tables / sizeof tables[0] };
static const dls_method methods[] = {DLS_NLGS, DLS_LEMKE};

typedef struct answer {
  double r[m], u[m];  /* local */
  double x[n];        /* of the model */
  double d[mesh_n];   /* displacement of the mesh */
  double R[2 * line]; /* nodal reactions, (n, t) per contact node */
  double mu;
  char states[nc + 1];
  dls_info info;
} answer;

/* Asserts DLS_OK; prints the message of a failed call. */
static dls_error error;
static void ok(dls_status status) {
  ck_assert_msg(status == DLS_OK, "%s: %s", dls_status_name(status), error.message);
}

/* The scene from end to end by one method; the answer is the caller's to free. */
static answer *solve_case(const dls_fe_scene *scene, dls_method method, double tolerance) {
  answer *a = calloc(1, sizeof *a);
  ck_assert_ptr_nonnull(a);
  dls_fe_scene_data data;
  dls_fe_scene_get(scene, &data);
  dls_reduction *reduction;
  dls_contact problem;
  ck_assert(data.model.n == n && data.candidates == nc);
  ok(reduce_on_W(&reduction, &data.model, NULL, &error));
  ok(dls_reduction_load(reduction, data.f, data.g, &error));
  ok(dls_reduction_contact(reduction, data.mu, &problem, &error));
  ck_assert(problem.nc == nc && problem.d == 2);

  dls_solver_settings settings = settings_with(method, tolerance);
  dls_solver *solver;
  ok(dls_solver_create(&solver, 2, nc, &settings, &error));
  ok(dls_solver_solve(solver, &problem, a->r, a->u, &a->info, &error));
  dls_solver_destroy(solver);

  dls_certificate certificate;
  dls_contact_state state[nc];
  ok(dls_contact_certify(&problem, a->r, NULL, &certificate, &error));
  ck_assert_double_le(certificate.residual_u, tolerance);
  ck_assert(dls_certificate_holds(&certificate, tolerance));
  ok(dls_contact_states(&problem, a->r, a->u, state, &error));
  for (int c = 0; c < nc; c++)
    a->states[c] = "fsk"[state[c]];

  ok(dls_reduction_recover(reduction, a->r, a->x, &error));
  ok(dls_reduction_nodal(reduction, a->r, a->R, &error));
  ok(dls_fe_scene_displacement(scene, a->x, a->d, &error));
  a->mu = data.mu[0];
  dls_reduction_destroy(reduction);
  return a;
}

/* Reads a table. printed: out, nc x columns, NaN for empty fields. */
static void read_table(const char *path, double printed[nc][columns]) {
  FILE *file = fopen(path, "r");
  ck_assert_msg(file != NULL, "%s", path);
  char text[200];
  int count = 0;
  ck_assert_ptr_nonnull(fgets(text, sizeof text, file));
  for (const char *p = text; *p; p++)
    count += *p == ',';
  ck_assert_int_eq(count, columns);
  for (int c = 0; c < nc; c++) {
    ck_assert_ptr_nonnull(fgets(text, sizeof text, file));
    char *p;
    ck_assert_int_eq(strtol(text, &p, 10), c + 1);
    for (int k = 0; k < count; k++) {
      ck_assert_int_eq(*p++, ',');
      const char *start = p;
      printed[c][k] = strtod(start, &p);
      if (p == start) printed[c][k] = NAN;
    }
    ck_assert_int_eq(*p, '\n');
  }
  ck_assert_ptr_null(fgets(text, sizeof text, file));
  ck_assert_int_eq(fclose(file), 0);
}

static dls_fe_scene *scene_of(const table *t) {
  dls_fe_scene *scene;
  ok(dls_fe_scene_create(&scene, t->scene, t->weighted, &error));
  return scene;
}

/* _i: 2 * table + method */
TEST_EACH(printed_table, 0, 2 * table_count) {
  const table *t = &tables[_i / 2];
  dls_fe_scene *scene = scene_of(t);
  dls_fe_scene_data data;
  dls_fe_scene_get(scene, &data);
  answer *a = solve_case(scene, methods[_i % 2], tol);

  double printed[nc][columns];
  read_table(t->file, printed);
  /* equivalents of concentrated reactions are the program's */
  for (int k = 0; k < (t->weighted ? columns : RT_EQUIVALENT); k++) {
    double largest = 0, deviation = 0;
    int values = 0;
    for (int c = 0; c < nc; c++) {
      const int contact = data.candidate_node[c], node = data.contact_node[contact];
      const double value[columns] = {a->d[2 * node], a->d[2 * node + 1],    a->r[2 * c + 1],
                                     a->r[2 * c],    a->R[2 * contact + 1], a->R[2 * contact]};
      if (printed[c][k] != printed[c][k]) continue;
      values++;
      largest = fmax(largest, fabs(printed[c][k]));
      const double off = fabs(value[k] - printed[c][k]);
      if (!(off <= deviation)) deviation = off;
    }
    ck_assert_int_ge(values, 6);
    /* Fig. 4's Q2: no node leaves the plane, the exact value is 0 */
    const double allowed = largest > 0 ? (k <= Q2 ? t->displacement : t->reaction) * largest
                                       : agreement * fabs(a->d[0]);
    ck_assert_msg(deviation <= allowed, "%s column %d: off by %g, allowed %g", t->file, k,
                  deviation, allowed);
  }

  double Rx = 0, Ry = 0;
  for (int c = 0; c < nc; c++) {
    Ry += a->r[2 * c];
    Rx += a->r[2 * c + 1];
  }
  /* five digits, from reactions of relative accuracy 1e-4 */
  ck_assert_double_le(fabs(Rx - t->Rx), 1e-4 * fabs(t->Rx));
  ck_assert_double_le(fabs(Ry - t->Ry), 1e-4 * t->Ry);
  if (t->states) ck_assert_str_eq(a->states, t->states);

  free(a);
  dls_fe_scene_destroy(scene);
}

TEST_EACH(methods_agree, 0, table_count) {
  dls_fe_scene *scene = scene_of(&tables[_i]);
  answer *a = solve_case(scene, DLS_NLGS, tight), *b = solve_case(scene, DLS_LEMKE, tol);
  double r = 0, u = 0, dr = 0, du = 0, dx = 0, x = 0;
  for (int i = 0; i < m; i++) {
    r = fmax(r, fabs(b->r[i]));
    u = fmax(u, fabs(b->u[i]));
    dr = fmax(dr, fabs(a->r[i] - b->r[i]));
    du = fmax(du, fabs(a->u[i] - b->u[i]));
  }
  for (int i = 0; i < n; i++) {
    x = fmax(x, fabs(b->x[i]));
    dx = fmax(dx, fabs(a->x[i] - b->x[i]));
  }
  ck_assert_str_eq(a->states, b->states);
  ck_assert_double_le(dr, agreement * r);
  ck_assert_double_le(du, agreement * u);
  ck_assert_double_le(dx, agreement * x);
  free(a);
  free(b);
  dls_fe_scene_destroy(scene);
}

/* Checks the balance without the reduction: the full stiffness times the displacement, less the
 * loads, equals the forces of obstacle and supports. */
TEST_EACH(equilibrium, 0, table_count) {
  const table *t = &tables[_i];
  dls_fe_scene *scene = scene_of(t);
  dls_fe_scene_data data;
  dls_fe_scene_get(scene, &data);
  answer *a = solve_case(scene, DLS_LEMKE, tol);

  double *K = malloc((size_t)mesh_n * mesh_n * sizeof *K);
  ck_assert_ptr_nonnull(K);
  double R[mesh_n], size[mesh_n], one[n], is_free[mesh_n];
  ok(dls_fe_stiffness(data.mesh, data.E, data.nu, K, mesh_n, &error));
  ok(dls_fe_scene_displacement(scene, data.f, R, &error));
  for (int i = 0; i < n; i++)
    one[i] = 1;
  ok(dls_fe_scene_displacement(scene, one, is_free, &error));
  double load = 0; /* vertical */
  for (int i = 0; i < mesh_n; i++) {
    load += i % 2 ? R[i] : 0;
    R[i] = -R[i];
    size[i] = 0;
  }
  for (int j = 0; j < mesh_n; j++)
    for (int i = 0; i < mesh_n; i++) {
      R[i] += K[i + j * mesh_n] * a->d[j];
      size[i] += fabs(K[i + j * mesh_n] * a->d[j]);
    }
  free(K);

  /* R = K d - f here; without the contact nodes' share the free unknowns are in balance */
  double vertical = 0, rounding = 0, largest = 0;
  for (int i = 0; i < mesh_n; i++) {
    rounding = fmax(rounding, size[i]);
    vertical += i % 2 ? R[i] : 0;
  }
  rounding *= mesh_n * DBL_EPSILON;
  for (int c = 0; c < data.model.nodes; c++) {
    const int node = data.contact_node[c];
    if (is_free[2 * node] > 0) R[2 * node] -= a->R[2 * c + 1];
    if (is_free[2 * node + 1] > 0) R[2 * node + 1] -= a->R[2 * c];
  }
  for (int i = 0; i < mesh_n; i++)
    if (is_free[i] > 0) largest = fmax(largest, fabs(R[i]));
  ck_assert_double_le(largest, rounding);
  ck_assert_double_le(fabs(vertical + load), rounding); /* obstacle and node 17 carry the load */

  /* weighted: u is the mean of the nodes' displacements over the dual cells, u = P^T (x_n, x_t) */
  for (int c = 0; c < nc; c++) {
    double un = 0, ut = 0;
    const dls_sparse *P = &data.model.P;
    if (!t->weighted) {
      const int node = data.contact_node[data.candidate_node[c]];
      un = a->d[2 * node + 1];
      ut = a->d[2 * node];
    } else
      for (int k = P->p[c]; k < P->p[c + 1]; k++) {
        const int node = data.contact_node[P->i[k]];
        un += P->x[k] * a->d[2 * node + 1];
        ut += P->x[k] * a->d[2 * node];
      }
    ck_assert_double_le(fabs(a->u[2 * c] - un), agreement * fabs(a->d[0]));
    ck_assert_double_le(fabs(a->u[2 * c + 1] - ut), agreement * fabs(a->d[0]));
  }
  free(a);
  dls_fe_scene_destroy(scene);
}

/* Fig. 4: all candidates slide, so both ways of computation give the same displacements and
 * nodal reactions (the paper's remark): r_t = -mu r_n at every candidate gives R_t = -mu R_n at
 * every node, and u_n = 0 at every candidate gives u_n = 0 at every node, P being regular without
 * row 17. */
TEST(all_slide) {
  dls_fe_scene *scene[2];
  answer *a[2];
  for (int w = 0; w < 2; w++) {
    ok(dls_fe_scene_create(&scene[w], "jean-fig4", w, &error));
    a[w] = solve_case(scene[w], DLS_LEMKE, tol);
    for (int c = 0; c < nc; c++)
      ck_assert_double_le(fabs(a[w]->r[2 * c + 1] + a[w]->mu * a[w]->r[2 * c]),
                          agreement * a[w]->r[2 * c]);
  }
  for (int i = 0; i < mesh_n; i++)
    ck_assert_double_le(fabs(a[0]->d[i] - a[1]->d[i]), agreement * fabs(a[0]->d[0]));
  for (int i = 0; i < 2 * nc; i++) /* nodal reactions agree, too */
    ck_assert_double_le(fabs(a[0]->R[i] - a[1]->R[i]), agreement * a[0]->R[2 * nc - 2]);
  for (int w = 0; w < 2; w++) {
    free(a[w]);
    dls_fe_scene_destroy(scene[w]);
  }
}

/* Solves a scene on a mesh; *R: resultant of the tangential reactions, *stick: contacts that stick,
 * x (n of the model), which the caller frees. */
static double *solve_mesh(const char *name, const dls_fe_scene_settings *settings,
                          dls_fe_scene **scene, double *R, int *stick) {
  dls_fe_scene_data d;
  ok(dls_fe_scene_create_with(scene, name, 0, settings, &error));
  dls_fe_scene_get(*scene, &d);
  double *r = calloc(4 * (size_t)d.candidates + (size_t)d.model.n, sizeof *r);
  ck_assert_ptr_nonnull(r);
  double *u = r + 2 * d.candidates, *x = calloc((size_t)d.model.n, sizeof *x);
  ck_assert_ptr_nonnull(x);
  ok(dls_solve_model(&d.model, d.f, d.g, d.mu, r, u, x, NULL, &error));
  *R = 0;
  *stick = 0;
  for (int c = 0; c < d.candidates; c++) {
    *R -= r[2 * c + 1];
    *stick += fabs(r[2 * c + 1]) < (1 - 1e-6) * settings->mu * r[2 * c];
  }
  free(r);
  return x;
}

/* Fig. 4 does not slide everywhere: graded meshes show the zone beside the fixed face that sticks,
 * even ones up to 256 x 128 do not. R_t tends to 199,165, not to mu R_n = 200,000. */
TEST(fixed_face_sticks) {
  dls_fe_scene_settings settings;
  dls_fe_scene *scene;
  double R;
  int stick;
  dls_fe_scene_settings_init(&settings);
  settings.mu = 0.1;
  settings.nx = 64;
  settings.ny = 32;
  for (int graded = 0; graded < 2; graded++) {
    settings.grade = graded ? 3 : 0;
    free(solve_mesh("jean-fig4", &settings, &scene, &R, &stick));
    dls_fe_scene_destroy(scene);
    ck_assert_int_eq(stick, graded ? 11 : 0);
    ck_assert_double_eq_tol(R, graded ? 199165 : 198155, graded ? 40 : 5);
  }
}

/* The block of the group GRECO, Code_Aster's test SSNV128: slip at five points in um, on a block
 * ten times as large. The last point lies where the slip ends. */
TEST(greco) {
  static const struct {
    int node; /* of 128 along 40 mm */
    double slip, tolerance;
  } points[] = {
      {0, 28.6, 0.003}, {4, 27.2, 0.003}, {16, 22.8, 0.004}, {24, 19.8, 0.004}, {36, 15.0, 0.03}};
  dls_fe_scene_settings settings;
  dls_fe_scene *scene;
  double R, displacement[2 * 129 * 129];
  int stick;
  dls_fe_scene_settings_init(&settings);
  settings.nx = settings.ny = 128;
  settings.mu = 1;
  settings.has_load = 1;
  settings.top = 5e7;
  settings.side = settings.side_top = 15e7;
  double *x = solve_mesh("jean-fig3", &settings, &scene, &R, &stick);
  ok(dls_fe_scene_displacement(scene, x, displacement, &error));
  for (size_t k = 0; k < sizeof points / sizeof points[0]; k++) {
    const double slip = 1e6 * 10 * displacement[2 * points[k].node];
    ck_assert_double_eq_tol(slip / points[k].slip, 1, points[k].tolerance);
  }
  free(x);
  dls_fe_scene_destroy(scene);
}
