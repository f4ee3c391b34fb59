/*
 * solvers_scenes.c: the contact problems of bench/solvers.
 *
 * fclib, global: every file of a directory; at most 20 contacts: set "tiny". A global problem
 * (K, H) comes twice: unchanged, where the reduction by delassus counts, and reduced.
 *
 * block, cube: an elastic block, E = 1, nu = 0.3, whose top is glued to a rigid back or free,
 * condensed to its bottom by the library. The back, of a block [0,1] x [0,1/2] or [0,1]^3, is moved
 * as a rigid body, so that without reactions the block goes with it and q is
 *
 *   press  down, and along by as much     hertz  down on a paraboloid obstacle, and along
 *   shear  down, and along by 5 times it  tilt   down, turned so that a part opens, and along
 *
 * and in cubes a twist about the vertical as well. raous (2D): a free top under pressure, pushed
 * from the left, u_x = 0 on the right edge and both unknowns of its lowest node, as in [Jean 1988]
 * 4.5: W is ill-conditioned, as the block rests on that node and on the contacts. Triangles
 * (src/fe) in 2D, 16 to 128 candidates; hexahedra with eight nodes in 3D, 6, 12 and 18 elements a
 * side (49 to 361 contacts), with --full also 24 (625). mu = 0.3 and 1 (18 a side: 0.3), with
 * --full 0.1 to 2. bench/regret has cubes of other ratios of Poisson, frictions drawn.
 *
 * wall: rigid bricks 2 x 1 x 1 of unit density in running bond on a floor, half bricks at the ends
 * of every other row; two contacts for each pair of faces that touch, 20 to 336 of them; mu is
 * 0.3, 1, 8, with --full also 0.6 and 3. In one time step, from rest, gravity gives each brick the
 * velocity (push, -1): W = H^T M^-1 H is rank deficient and sparse, u a velocity.
 */
#include <dirent.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus/fe.h"
#include "reduction_boxes.h"
#include "regret_kinds.h"
#include "solvers_scenes.h"

void dsyrk_(const char *uplo, const char *trans, const int *n, const int *k, const double *alpha,
            const double *a, const int *lda, const double *beta, double *c, const int *ldc, size_t,
            size_t);
static const double E = 1, usual_nu = 0.3;

static double *zeros(size_t count) {
  return calloc(count, sizeof(double));
}

static int out_of_memory(void) {
  fputs("solvers: out of memory\n", stderr);
  return -1;
}

/* ---- files ----------------------------------------------------------------------------------- */

static void visit_file(const dls_fclib *file, const char *name, scene_fn visit, void *data,
                       dls_error *error) {
  scene s = {.set = "fclib"};
  snprintf(s.name, sizeof s.name, "%s", name);
  dls_reduction *reduction = NULL;
  dls_model model;
  const double *mu = NULL;
  dls_status status;
  if (!dls_fclib_is_global(file))
    status = dls_fclib_contact(file, &s.contact, error);
  else {
    status = dls_fclib_model(file, &model, &s.f, &s.g, &mu, error);
    if (!status) status = bench_reduce(&reduction, &model, error);
    if (!status) status = dls_reduction_load(reduction, s.f, s.g, error);
    if (!status) status = dls_reduction_contact(reduction, mu, &s.contact, error);
  }
  if (status)
    fprintf(stderr, "%s: %s\n", name, error->message);
  else
    visit(data, &s);
  if (!status && reduction) {
    s.set = "global";
    s.model = &model;
    visit(data, &s);
  }
  dls_reduction_destroy(reduction);
}

static int is_hdf5(const struct dirent *e) {
  const size_t length = strlen(e->d_name);
  return length > 5 && strcmp(e->d_name + length - 5, ".hdf5") == 0;
}

int scenes_files(const char *directory, scene_fn visit, void *data) {
  struct dirent **entries;
  const int count = scandir(directory, &entries, is_hdf5, alphasort);
  if (count < 0) {
    perror(directory);
    return -1;
  }
  int result = 0;
  for (int k = 0; k < count; k++) {
    char path[1024];
    dls_error error = {.message = ""};
    dls_fclib *file;
    snprintf(path, sizeof path, "%s/%s", directory, entries[k]->d_name);
    if (dls_fclib_read(&file, path, &error)) {
      fprintf(stderr, "%s: %s\n", path, error.message);
      result = -1;
    } else {
      entries[k]->d_name[strlen(entries[k]->d_name) - 5] = '\0';
      visit_file(file, entries[k]->d_name, visit, data, &error);
      dls_fclib_destroy(file);
    }
    free(entries[k]);
  }
  free(entries);
  return result;
}

/* ---- an elastic block ------------------------------------------------------------------------ */

/* The contact problem on the bottom of a block; owns its arrays. */
typedef struct elastic {
  int d, nc;
  dls_reduction *reduction;
  dls_contact condensed; /* q: without reactions, but for the motion of the back */
  double *place;         /* 2 nc: horizontal coordinates from the middle */
  double *q, *mu;
} elastic;

static void block_free(elastic *k) {
  dls_reduction_destroy(k->reduction);
  free(k->place);
  free(k->q);
  free(k->mu);
}

/* Condenses a block to its contact nodes. f: loads, or NULL. */
static int block_condense(elastic *k, const dls_model *model, const double *f) {
  const size_t d = (size_t)model->d, nc = (size_t)model->nodes;
  *k = (elastic){.d = model->d, .nc = model->nodes};
  k->place = zeros(2 * nc);
  k->q = zeros(d * nc);
  k->mu = zeros(nc);
  if (!k->place || !k->q || !k->mu) return out_of_memory();
  return bench_reduce(&k->reduction, model, NULL) ||
                 dls_reduction_load(k->reduction, f, NULL, NULL) ||
                 dls_reduction_contact(k->reduction, k->mu, &k->condensed, NULL)
             ? -1
             : 0;
}

/* Moves the back of a block; p is the depth by which it is pressed down. */
typedef void (*move_fn)(double X, double Y, double p, double *q);

static void move_press(double X, double Y, double p, double *q) {
  (void)X, (void)Y;
  q[0] = -p;
  q[1] = p;
}
static void move_shear(double X, double Y, double p, double *q) {
  (void)X, (void)Y;
  q[0] = -p;
  q[1] = 5 * p;
}
static void move_tilt(double X, double Y, double p, double *q) {
  q[0] = -p + 4 * p * X + 1.5 * p * Y;
  q[1] = 0.5 * p;
}
static void move_hertz(double X, double Y, double p, double *q) {
  q[0] = -p + 8 * p * (X * X + Y * Y);
  q[1] = 0.5 * p;
}

typedef struct load {
  const char *name;
  move_fn move; /* NULL: raous */
} load;

static void visit_block(elastic *k, const char *set, const char *name, move_fn move, double mu,
                        scene_fn visit, void *data) {
  const double press = 1e-3;
  for (int c = 0; c < k->nc; c++) {
    const double X = k->place[2 * c], Y = k->place[2 * c + 1];
    double q[3] = {0};
    if (move) move(X, Y, press, q);
    if (k->d == 3) { /* the twist, and another direction along */
      q[2] = 0.3 * q[1] + press * X;
      q[1] -= press * Y;
    }
    for (int i = 0; i < k->d; i++)
      k->q[k->d * c + i] = k->condensed.q[k->d * c + i] + q[i];
    k->mu[c] = mu;
  }
  scene s = {.set = set, .contact = k->condensed};
  s.contact.q = k->q;
  s.contact.mu = k->mu;
  snprintf(s.name, sizeof s.name, "%s-mu%g", name, mu);
  visit(data, &s);
}

/* Friction coefficients: a full run takes all, a quick one the first two. */
static const double frictions[] = {0.3, 1, 0.1, 0.6, 2};
enum { quick_frictions = 2, all_frictions = 5 };

/* Makes a 2D block of n candidates: n - 1 squares of two triangles wide, half as many high. raous:
 * u_x = 0 on the right, u_y = 0 at its lowest node. */
static int block_of_triangles(elastic *k, int n, int raous) {
  const int nx = n - 1, slabs = nx / 2, all = 2 * n * (slabs + 1), nc = raous ? nx : n;
  const double pressure = 1e-3, side = 2e-3;
  dls_fe_mesh mesh = {0};
  dls_fe_matrix K = {0};
  double *f = zeros(2 * (size_t)all + (size_t)nc), *loads = f + all, *one = loads + all;
  int *unknown = calloc((size_t)(all + 3 * nc + 1), sizeof *unknown), unknowns = 0;
  int *normal = unknown + all, *tangent = normal + nc, *p = tangent + nc;
  dls_status bad = !f || !unknown ? DLS_E_MEMORY : DLS_OK;
  if (!bad) bad = dls_fe_mesh_block(&mesh, 1, (double)slabs / nx, nx, slabs, NULL);
  for (int i = 0; raous && !bad && i < nx; i++)
    bad = dls_fe_edge_load(&mesh, slabs * n + i, slabs * n + i + 1, 0, -pressure, f, NULL);
  for (int j = 0; raous && !bad && j < slabs; j++)
    bad = dls_fe_edge_load(&mesh, j * n, (j + 1) * n, side, 0, f, NULL);
  for (int i = 0; !bad && i < all; i++) {
    const int node = i / 2, right = node % n == nx && (i % 2 == 0 || node == nx);
    unknown[i] = (raous ? right : node / n == slabs) ? -1 : unknowns;
    if (unknown[i] >= 0) loads[unknowns++] = f[i];
  }
  for (int c = 0; !bad && c < nc; c++) {
    tangent[c] = unknown[2 * c];
    normal[c] = unknown[2 * c + 1];
    one[c] = 1;
    p[c + 1] = c + 1;
  }
  if (!bad) bad = dls_fe_sparse_stiffness(&mesh, E, usual_nu, unknown, unknowns, &K, NULL);
  const dls_model model = {.d = 2,
                           .n = unknowns,
                           .nodes = nc,
                           .operator_kind = DLS_STIFFNESS_SPARSE,
                           .factorization = DLS_CHOLESKY,
                           .Ks = K.A,
                           .HN = {unknowns, nc, p, normal, one},
                           .HT = {unknowns, nc, p, tangent, one}};
  const int result = bad || block_condense(k, &model, loads) ? -1 : 0;
  for (int c = 0; !result && c < nc; c++)
    k->place[2 * c] = (double)c / nx - 0.5;
  dls_fe_mesh_free(&mesh);
  dls_fe_matrix_free(&K);
  free(f);
  free(unknown);
  return result;
}

/* Visits the block under each load with each of the first `count` frictions. */
static void visit_loads(elastic *k, int size, const load *loads, int load_count, int count,
                        scene_fn visit, void *data) {
  for (int l = 0; l < load_count; l++) {
    char name[32];
    snprintf(name, sizeof name, "%s-%d-%s", k->d == 2 ? "t3" : "h8", size, loads[l].name);
    for (int f = 0; f < count; f++)
      visit_block(k, k->d == 2 ? "block" : "cube", name, loads[l].move, frictions[f], visit, data);
  }
}

int scenes_blocks(int full, scene_fn visit, void *data) {
  static const int sizes[] = {16, 32, 64, 128};
  static const load loads[] = {
      {"press", move_press}, {"tilt", move_tilt}, {"hertz", move_hertz}, {"raous", NULL}};
  int result = 0;
  for (int i = 0; i < 4 && !result; i++)
    for (int raous = 0; raous < 2 && !result; raous++) {
      elastic k = {0};
      result = block_of_triangles(&k, sizes[i], raous);
      const int count = full ? all_frictions : quick_frictions;
      if (!result)
        visit_loads(&k, sizes[i], loads + (raous ? 3 : 0), raous ? 1 : 3, count, visit, data);
      block_free(&k);
    }
  return result;
}

/* ---- hexahedra ------------------------------------------------------------------------------- */

/* Makes a cube of n x n x n hexahedra, glued at the top, a candidate at each node of the bottom. */
static int block_of_hexahedra(elastic *k, int n, double nu) {
  box b;
  if (box_create_cube(&b, n, nu)) return out_of_memory();
  const int result = block_condense(k, &b.model, NULL);
  for (int c = 0; !result && c < k->nc; c++) {
    k->place[2 * c] = (double)(c % (n + 1)) / n - 0.5;
    k->place[2 * c + 1] = (double)(c / (n + 1)) / n - 0.5; // NOLINT(bugprone-integer-division)
  }
  box_free(&b);
  return result;
}

static const load cube_loads[] = {
    {"press", move_press}, {"shear", move_shear}, {"tilt", move_tilt}, {"hertz", move_hertz}};

int scenes_cubes(int full, scene_fn visit, void *data) {
  static const int sizes[] = {6, 12, 18, 24};
  int result = 0;
  for (int i = 0; i < (full ? 4 : 3) && !result; i++) {
    elastic k = {0};
    result = block_of_hexahedra(&k, sizes[i], usual_nu);
    const int count = full ? all_frictions : sizes[i] < 18 ? quick_frictions : 1;
    if (!result) visit_loads(&k, sizes[i], cube_loads, 4, count, visit, data);
    block_free(&k);
  }
  return result;
}

int scenes_cubes_of(double nu, unsigned seed, scene_fn visit, void *data) {
  static const int sizes[] = {6, 8, 10, 12};
  uint64_t state = seed;
  int result = 0;
  for (int i = 0; i < 4 && !result; i++) {
    elastic k = {0};
    result = block_of_hexahedra(&k, sizes[i], nu);
    for (int j = 0; j < 12 && !result; j++) {
      char name[32];
      const double mu = 0.3 * pow(40. / 3, (1 + bench_draw(&state)) / 2);
      snprintf(name, sizeof name, "h8-%d-%s", sizes[i], cube_loads[j % 4].name);
      visit_block(&k, "cube", name, cube_loads[j % 4].move, mu, visit, data);
    }
    block_free(&k);
  }
  return result;
}

/* ---- walls ----------------------------------------------------------------------------------- */

static int visit_wall(int full, int rows, int width, scene_fn visit, void *data) {
  static const double mus[] = {0.3, 1, 8, 0.6, 3}, pushes[] = {0, 0.3};
  const int count = full ? all_frictions : 3;
  for (int k = 0; k < 2 * count; k++) {
    const double push = pushes[k / count], mu = mus[k % count];
    rigid a;
    if (rigid_wall(&a, rows, width, push, mu)) return out_of_memory();
    scene s = {.set = "wall", .contact = a.contact};
    snprintf(s.name, sizeof s.name, "wall-%dx%d-push%g-mu%g", rows, width, push, mu);
    visit(data, &s);
    rigid_free(&a);
  }
  return 0;
}

int scenes_walls(int full, scene_fn visit, void *data) {
  static const int sizes[][2] = {{3, 2}, {6, 5}, {11, 8}};
  int result = 0;
  for (int k = 0; k < 3 && !result; k++)
    result = visit_wall(full, sizes[k][0], sizes[k][1], visit, data);
  return result;
}

/* ---- random ---------------------------------------------------------------------------------- */

int scenes_random(int k, int nc, int rows, scene_fn visit, void *data) {
  uint64_t seed = 2 * (uint64_t)k + 2;
  scene s = {.set = "random"};
  const int d = 1 + k % 3;
  if (!nc) nc = 1 + (int)((bench_draw(&seed) + 1) / 2 * (rows / d));
  const int n = d * nc;
  const size_t m = (size_t)n;
  const double over = 1 / (double)m, zero = 0;
  double *A = malloc(m * m * sizeof *A), *W = calloc(m * m, sizeof *W);
  double *q = malloc(m * sizeof *q), *mu = malloc((size_t)nc * sizeof *mu);
  const int made = A && W && q && mu;
  (void)snprintf(s.name, sizeof s.name, "%d", k);
  for (size_t i = 0; made && i < m * m; i++)
    A[i] = bench_draw(&seed);
  if (made) dsyrk_("L", "N", &n, &n, &over, A, &n, &zero, W, &n, 1, 1);
  for (size_t j = 0; made && j < m; j++) {
    W[j * (m + 1)] += k / 3 % 2 ? 1e-3 : 0.1;
    for (size_t i = j + 1; i < m; i++)
      W[j + i * m] = W[i + j * m];
  }
  for (size_t i = 0; made && i < m; i++)
    q[i] = bench_draw(&seed) - (i % (size_t)d == 0 ? 0.3 : 0);
  for (int c = 0; made && c < nc; c++)
    mu[c] = d == 1 ? 0 : 0.45 + 0.35 * bench_draw(&seed);
  s.contact = (dls_contact){.d = d, .nc = nc, .W = {n, n, n, W}, .q = q, .mu = mu};
  if (made)
    visit(data, &s);
  else
    fputs("scenes_random: out of memory\n", stderr);
  free(A);
  free(W);
  free(q);
  free(mu);
  return made ? 0 : -1;
}
