/*
 * solvers_scenes.c: the contact problems of bench/solvers.
 *
 * fclib, global: every file of a directory; at most 20 contacts: set "tiny". A global problem
 * (K, H) comes twice: unchanged, where the reduction by delassus counts, and reduced.
 *
 * block, cube: an elastic block, E = 1, nu = 0.3, of equal slabs piled upwards, b unknowns on the
 * plane between two slabs. One slab has the stiffness (ll lu; ul uu), 2 b x 2 b. From the top
 * down, the stiffness Z and load h of all that stands on a plane are condensed to the plane below:
 *
 *   E = Z + uu,   Z := ll - lu E^-1 ul,   h := f_below - lu E^-1 h                           (SS1)
 *
 * starting with Z = ll where the top is glued to a rigid back, Z = 0 where it is free. On the
 * bottom plane W = Z^-1 and x = Z^-1 h of the contact unknowns (SS2). K of the whole block is
 * never formed: 7/3 b^3 flops for each slab. The back, of a block [0,1] x [0,1/2] or [0,1]^3, is
 * moved as a rigid body, so that without reactions the block goes with it and q is
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
 * velocity (push, -1): W = H^T M^-1 H (SS3) is rank deficient and sparse, u a velocity.
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

void dpotrf_(const char *uplo, const int *n, double *a, const int *lda, int *info, size_t);
void dpotri_(const char *uplo, const int *n, double *a, const int *lda, int *info, size_t);
void dtrsm_(const char *side, const char *uplo, const char *transa, const char *diag, const int *m,
            const int *n, const double *alpha, const double *a, const int *lda, double *b,
            const int *ldb, size_t, size_t, size_t, size_t);
void dsyrk_(const char *uplo, const char *trans, const int *n, const int *k, const double *alpha,
            const double *a, const int *lda, const double *beta, double *c, const int *ldc, size_t,
            size_t);
void dgemv_(const char *trans, const int *m, const int *n, const double *alpha, const double *a,
            const int *lda, const double *x, const int *incx, const double *beta, double *y,
            const int *incy, size_t);

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

/* Condenses all slabs to the bottom plane, (SS1).
 *
 *   S: a slab, the lower plane first, 2b x 2b
 *   f: loads, b a plane from the bottom; NULL for none
 *   Z: stiffness, b x b, lower triangle
 *   h: load, b */
static int block_condense(int b, int slabs, const double *S, const double *f, int glued, double *Z,
                          double *h) {
  const size_t B = (size_t)b, ld = 2 * B;
  const double one = 1, minus = -1;
  const int unit = 1;
  double *A = zeros(B * B), *Y = zeros(B * B), *y = zeros(B);
  int info = !A || !Y || !y, plane = glued ? slabs - 1 : slabs;
  memset(h, 0, B * sizeof *h);
  for (size_t k = 0; k < B * B; k++)
    Z[k] = glued ? S[k % B + k / B * ld] : 0;
  if (f) memcpy(h, f + (size_t)plane * B, B * sizeof *h);
  for (; plane > 0 && !info; plane--) {
    for (size_t k = 0; k < B * B; k++) {
      const size_t i = k % B, j = k / B;
      A[k] = Z[k] + S[B + i + (B + j) * ld];
      Y[k] = S[B + i + j * ld];
      Z[k] = S[i + j * ld];
    }
    memcpy(y, h, B * sizeof *h);
    memset(h, 0, B * sizeof *h);
    if (f) memcpy(h, f + (size_t)(plane - 1) * B, B * sizeof *h);
    dpotrf_("L", &b, A, &b, &info, 1);
    dtrsm_("L", "L", "N", "N", &b, &b, &one, A, &b, Y, &b, 1, 1, 1, 1);
    dtrsm_("L", "L", "N", "N", &b, &unit, &one, A, &b, y, &b, 1, 1, 1, 1);
    dsyrk_("L", "T", &b, &b, &minus, Y, &b, &one, Z, &b, 1, 1);
    dgemv_("T", &b, &b, &minus, Y, &b, y, &unit, &one, h, &unit, 1);
  }
  free(A);
  free(Y);
  free(y);
  return info;
}

/* The contact problem on the bottom of a block; owns its arrays. */
typedef struct elastic {
  int d, nc;
  double *W;     /* m x m */
  double *x;     /* m: without reactions, but for the motion of the back */
  double *place; /* 2 nc: horizontal coordinates from the middle */
  double *q, *mu;
} elastic;

static void block_free(elastic *k) {
  free(k->W);
  free(k->x);
  free(k->place);
  free(k->q);
  free(k->mu);
}

static int block_create(elastic *k, int d, int nc) {
  const size_t m = (size_t)d * (size_t)nc;
  *k = (elastic){d, nc, zeros(m * m), zeros(m), zeros(2 * (size_t)nc), zeros(m), zeros(m)};
  return k->W && k->x && k->place && k->q && k->mu ? 0 : out_of_memory();
}

/* Computes W and x from Z and h, (SS2). Unknowns of Z and h: d for each node, the vertical last. */
static int block_invert(elastic *k, int b, double *Z, double *h) {
  const size_t B = (size_t)b, d = (size_t)k->d, m = d * (size_t)k->nc;
  const double one = 1;
  const int unit = 1;
  int info;
  dpotrf_("L", &b, Z, &b, &info, 1);
  if (info) return info;
  dtrsm_("L", "L", "N", "N", &b, &unit, &one, Z, &b, h, &b, 1, 1, 1, 1);
  dtrsm_("L", "L", "T", "N", &b, &unit, &one, Z, &b, h, &b, 1, 1, 1, 1);
  dpotri_("L", &b, Z, &b, &info, 1);
  for (size_t j = 0; j < m; j++) {
    const size_t column = j - j % d + (j % d + d - 1) % d; /* (n, t, s) is (z, x, y) */
    k->x[j] = h[column];
    for (size_t i = 0; i < m; i++) {
      const size_t row = i - i % d + (i % d + d - 1) % d;
      k->W[i + j * m] = row >= column ? Z[row + column * B] : Z[column + row * B];
    }
  }
  return info;
}

/* Holds unknown i of every slab. */
static void block_fix(int b, double *S, int i) {
  for (int k = 0; k < 2 * b; k++)
    for (int half = 0; half < 2; half++) {
      const size_t B = (size_t)b, j = (half ? B : 0) + (size_t)i, K = (size_t)k, ld = 2 * B;
      S[K + j * ld] = S[j + K * ld] = K == j;
    }
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
  const int m = k->d * k->nc;
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
      k->q[k->d * c + i] = k->x[k->d * c + i] + q[i];
    k->mu[c] = mu;
  }
  scene s = {.set = set,
             .contact = {.d = k->d, .nc = k->nc, .W = {m, m, m, k->W}, .q = k->q, .mu = k->mu}};
  snprintf(s.name, sizeof s.name, "%s-mu%g", name, mu);
  visit(data, &s);
}

/* Friction coefficients: a full run takes all, a quick one the first two. */
static const double frictions[] = {0.3, 1, 0.1, 0.6, 2};
enum { quick_frictions = 2, all_frictions = 5 };

/* Makes a 2D block of n candidates: n - 1 squares of two triangles wide, half as many high. */
static int block_of_triangles(elastic *k, int n, int raous) {
  const int nx = n - 1, slabs = nx / 2, b = 2 * n;
  const size_t B = (size_t)b;
  dls_fe_mesh slab = {0}, whole = {0};
  double *S = zeros(4 * B * B), *Z = zeros(B * B), *h = zeros(B),
         *f = zeros((size_t)(slabs + 1) * B);
  dls_status bad = !S || !Z || !h || !f ? DLS_E_MEMORY : DLS_OK;
  if (!bad) bad = dls_fe_mesh_block(&slab, 1, 1.0 / nx, nx, 1, NULL);
  if (!bad) bad = dls_fe_mesh_block(&whole, 1, (double)slabs / nx, nx, slabs, NULL);
  if (!bad) bad = dls_fe_stiffness(&slab, E, usual_nu, S, 2 * b, NULL);
  const double pressure = 1e-3, side = 2e-3;
  for (int i = 0; raous && !bad && i < nx; i++)
    bad = dls_fe_edge_load(&whole, slabs * n + i, slabs * n + i + 1, 0, -pressure, f, NULL);
  for (int j = 0; raous && !bad && j < slabs; j++)
    bad = dls_fe_edge_load(&whole, j * n, (j + 1) * n, side, 0, f, NULL);
  dls_fe_mesh_free(&slab);
  dls_fe_mesh_free(&whole);
  int info = bad || block_create(k, 2, raous ? nx : n);
  if (!info && raous) {
    block_fix(b, S, b - 2); /* u_x on the right; the loads have nothing there */
    for (int j = 0; j <= slabs; j++)
      f[(size_t)(j + 1) * B - 2] = 0;
  }
  if (!info) info = block_condense(b, slabs, S, raous ? f : NULL, !raous, Z, h);
  if (!info && raous) { /* u_y of its lowest node: the last unknown */
    for (size_t j = 0; j < B; j++)
      Z[B - 1 + j * B] = 0;
    Z[B * B - 1] = 1;
    h[B - 1] = 0;
  }
  if (!info) info = block_invert(k, b, Z, h);
  for (int c = 0; !info && c < k->nc; c++)
    k->place[2 * c] = (double)c / nx - 0.5;
  free(S);
  free(Z);
  free(h);
  free(f);
  return info ? -1 : 0;
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
  const int nodes = (n + 1) * (n + 1), b = 3 * nodes;
  const size_t B = (size_t)b;
  double corner[24], K[24 * 24], *S = zeros(4 * B * B), *Z = zeros(B * B), *h = zeros(B);
  int info = !S || !Z || !h || block_create(k, 3, nodes);
  for (int i = 0; i < 24; i++)
    corner[i] = (i / 3 >> i % 3 & 1) / (double)n;
  box_element(3, corner, nu, K);
  for (int e = 0; !info && e < n * n; e++) {
    size_t unknown[24];
    for (int i = 0; i < 24; i++) {
      const int v = i / 3, x = e % n + (v & 1), y = e / n + (v >> 1 & 1), upper = v >> 2;
      const int node = x + y * (n + 1) + upper * nodes;
      unknown[i] = 3 * (size_t)node + (size_t)(i % 3);
    }
    for (int i = 0; i < 24; i++)
      for (int j = 0; j < 24; j++)
        S[unknown[i] + unknown[j] * 2 * B] += K[i + 24 * j];
  }
  if (!info) info = block_condense(b, n, S, NULL, 1, Z, h);
  if (!info) info = block_invert(k, b, Z, h);
  for (int c = 0; !info && c < nodes; c++) {
    k->place[2 * c] = (double)(c % (n + 1)) / n - 0.5;
    k->place[2 * c + 1] = (double)(c / (n + 1)) / n - 0.5; // NOLINT(bugprone-integer-division)
  }
  free(S);
  free(Z);
  free(h);
  return info ? -1 : 0;
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

static const double length = 2, height = 1;

/* Lays the bricks of a row from left to right. */
static void lay_row(yard *y, int row, int width) {
  const int half = row % 2, count = width + half;
  for (int i = 0; i < count; i++) {
    const int cut = half && (i == 0 || i == count - 1);
    const double w = cut ? length / 2 : length, mass = w * height;
    const double left = i == 0 ? 0 : length * i - (half ? length / 2 : 0);
    const double inertia = mass * (w * w + height * height) / 12, still[3] = {0};
    const double middle[3] = {left + w / 2, height * (row + 0.5), 0};
    (void)yard_body(y, middle, mass, &inertia, still);
  }
}

/* Lays two candidates on every stretch, half a brick long, where a brick of this row stands on one
 * below or on the floor. */
static void touch_row(yard *y, int row, int width, int first, int below) {
  const int stretches = row ? 2 * width : width;
  const double w = row ? length / 2 : length, up[3] = {0, 1, 0};
  for (int i = 0; i < stretches; i++) {
    const int even = i / 2, odd = (i + 1) / 2; /* the brick over stretch i of an even, an odd row */
    const int upper = first + (!row ? i : row % 2 ? odd : even);
    const int lower = !row ? -1 : below + (row % 2 ? even : odd);
    for (int end = 0; end < 2; end++) {
      const double x[3] = {w * (i + end), height * row, 0};
      yard_touch(y, upper, lower, x, up);
    }
  }
}

static int visit_wall(int full, int rows, int width, scene_fn visit, void *data) {
  static const double mus[] = {0.3, 1, 8, 0.6, 3}, pushes[] = {0, 0.3};
  regret_problem a = {0};
  yard y = {0};
  int bad = yard_open(&y, &a, 2, rows * (width + 1), 2 * rows * 2 * width), below = 0;
  for (int row = 0; row < rows && !bad; row++) {
    const int first = y.bodies;
    lay_row(&y, row, width);
    touch_row(&y, row, width, first, below);
    below = first;
  }
  bad = bad || yard_close(&y);
  for (int k = 0; k < (full ? 10 : 6) && !bad; k++) {
    const double push = pushes[k / (full ? 5 : 3)], mu = mus[k % (full ? 5 : 3)];
    for (int c = 0; c < a.contact.nc; c++) { /* only the floor does not fall */
      a.own.q[2 * c] = a.own.body[2 * c + 1] < 0 ? -1 : 0;
      a.own.q[2 * c + 1] = a.own.body[2 * c + 1] < 0 ? push : 0;
      a.own.mu[c] = mu;
    }
    scene s = {.set = "wall", .contact = a.contact};
    snprintf(s.name, sizeof s.name, "wall-%dx%d-push%g-mu%g", rows, width, push, mu);
    visit(data, &s);
  }
  regret_free(&a);
  return bad ? out_of_memory() : 0;
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
