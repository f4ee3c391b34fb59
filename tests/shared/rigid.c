/* rigid.c: contact problems of rigid bodies, as rigid.h describes them. */
#include "rigid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double heap_random(heap *h) {
  h->state = h->state * 6364136223846793005u + 1442695040888963407u;
  return (double)(h->state >> 11) * 0x1p-52 - 1;
}

void rigid_cross(const double *a, const double *b, double *c) {
  for (int i = 0; i < 3; i++)
    c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Returns memory for one more entry of an array, twice as large where it is full. */
static void *heap_room(heap *h, void *array, int count, int *most, size_t size) {
  if (count < *most) return array;
  const int more = *most ? 2 * *most : 64;
  void *larger = realloc(array, (size_t)more * size);
  if (!larger) {
    h->bad = 1;
    return array;
  }
  *most = more;
  return larger;
}

int heap_add_body(heap *h, solid body) {
  h->body = heap_room(h, h->body, h->bodies, &h->most_bodies, sizeof body);
  if (h->bad) return -1;
  h->body[h->bodies] = body;
  return h->bodies++;
}

void heap_touch(heap *h, place at) {
  h->at = heap_room(h, h->at, h->places, &h->most_places, sizeof at);
  if (!h->bad) h->at[h->places++] = at;
}

int heap_body(heap *h, const double *middle, double mass, const double *inertia, const double *v) {
  solid s = {.mass = mass};
  memcpy(s.x, middle, sizeof s.x);
  memcpy(s.v, v, (size_t)h->d * sizeof *v);
  for (int i = h->d == 2 ? 2 : 0, l = 0; i < 3; i++, l++) {
    s.inertia[i] = inertia[l];
    s.spin[i] = v[h->d + l];
  }
  return heap_add_body(h, s);
}

void heap_contact(heap *h, int a, int b, const double *x, const double *normal) {
  place at = {.a = a, .b = b};
  memcpy(at.x, x, sizeof at.x);
  memcpy(at.normal, normal, sizeof at.normal);
  heap_touch(h, at);
}

/* ---- kinds ----------------------------------------------------------------------------------- */

static const double step_of_gravity = 0.098;

/* Touches spheres a and b where they are less than a gap apart. radius: of all. */
static void touch_spheres(heap *h, int a, int b, const double *radius, double gap) {
  const double *x = h->body[a].x, *y = h->body[b].x;
  double n[3], length = 0;
  for (int i = 0; i < 3; i++) {
    n[i] = x[i] - y[i];
    length += n[i] * n[i];
  }
  length = sqrt(length);
  if (length >= radius[a] + radius[b] + gap) return;
  place at = {.a = a, .b = b};
  for (int i = 0; i < 3; i++) {
    at.normal[i] = n[i] / length;
    at.x[i] = y[i] + at.normal[i] * radius[b];
  }
  heap_touch(h, at);
}

/* Touches sphere a and the sides of the box that are less than a gap away, but for its top. */
static void touch_box(heap *h, int a, double radius, double low, double high, double gap) {
  for (int i = 0; i < h->d; i++)
    for (int end = 0; end < (i == h->d - 1 ? 1 : 2); end++) {
      const double *x = h->body[a].x;
      if (fabs(x[i] - (end ? high : low)) >= radius + gap) continue;
      place at = {.a = a, .b = -1};
      memcpy(at.x, x, sizeof at.x);
      at.x[i] += end ? radius : -radius;
      at.normal[i] = end ? -1 : 1;
      heap_touch(h, at);
    }
}

/* About 12 n^3 candidates for n^3 cells. */
static void make_packing(heap *h, int candidates, int flow) {
  static const double corner[4][3] = {{0, 0, 0}, {0.5, 0.5, 0}, {0.5, 0, 0.5}, {0, 0.5, 0.5}};
  const int n = (int)fmax(1, round(cbrt(candidates / 12.))), count = 4 * n * n * n;
  double *radius = calloc((size_t)count, sizeof *radius);
  h->bad |= !radius;
  h->d = 3;
  for (int k = 0; k < count && !h->bad; k++) {
    const int cell[3] = {k / 4 % n, k / 4 / n % n, k / 4 / n / n};
    const double R = 0.3535 * (1 + 0.03 * heap_random(h)), I = 0.4 * R * R * R * R * R;
    solid s = {.mass = R * R * R, .inertia = {I, I, I}, .v = {0, 0, -step_of_gravity}};
    for (int i = 0; i < 3; i++) {
      s.x[i] = cell[i] + corner[k % 4][i] + 0.05 * heap_random(h);
      if (flow) s.v[i] += 0.15 * heap_random(h);
      if (flow) s.spin[i] = 0.15 * heap_random(h);
    }
    radius[k] = R;
    (void)heap_add_body(h, s);
  }
  for (int a = 0; a < count && !h->bad; a++) {
    const int cell[3] = {a / 4 % n, a / 4 / n % n, a / 4 / n / n};
    touch_box(h, a, radius[a], -0.25, n - 0.25, 0.1);
    for (int near = 0; near < 27; near++) {
      const int x = cell[0] + near % 3 - 1, y = cell[1] + near / 3 % 3 - 1;
      const int z = cell[2] + near / 9 - 1;
      if (x < 0 || y < 0 || z < 0 || x >= n || y >= n || z >= n) continue;
      const int first = 4 * (x + n * (y + n * z));
      for (int b = first; b < first + 4; b++)
        if (b < a) touch_spheres(h, a, b, radius, 0);
    }
  }
  free(radius);
}

/* ---- settled packings ------------------------------------------------------------------------ */

enum { most_settling = 6000, most_near = 27 };

/* Soft spheres, or discs, in a box without a top, on their way to rest under gravity; d numbers are
 * used of each 3. */
typedef struct settling {
  int d, count, cells[3]; /* cells: of a grid, one largest diameter wide */
  double side, cell, gravity;
  double *x, *v, *f, *radius; /* f: forces, overlap times 1 */
  int *first, *next;          /* of each cell a list; -1: end */
} settling;

static int settling_cell(const settling *s, const double *x, int *of) {
  for (int i = 0; i < 3; i++) {
    const double at = i < s->d ? floor(x[i] / s->cell) : 0;
    of[i] = at <= 0 ? 0 : at >= s->cells[i] ? s->cells[i] - 1 : (int)at;
  }
  return of[0] + s->cells[0] * (of[1] + s->cells[1] * of[2]);
}

static void settling_sort(settling *s) {
  int of[3];
  for (int k = 0; k < s->cells[0] * s->cells[1] * s->cells[2]; k++)
    s->first[k] = -1;
  for (int a = 0; a < s->count; a++) {
    const int k = settling_cell(s, s->x + 3 * a, of);
    s->next[a] = s->first[k];
    s->first[k] = a;
  }
}

/* Calls each(data, a, b, n, overlap) for b < a that overlap by more than -gap; n from b to a. */
static void settling_pairs(const settling *s, double gap,
                           void (*each)(void *, int, int, const double *, double), void *data) {
  for (int a = 0; a < s->count; a++) {
    int of[3];
    (void)settling_cell(s, s->x + 3 * a, of);
    for (int near = 0; near < most_near; near++) {
      const int at[3] = {of[0] + near % 3 - 1, of[1] + near / 3 % 3 - 1, of[2] + near / 9 - 1};
      int inside = 1;
      for (int i = 0; i < 3; i++)
        inside &= at[i] >= 0 && at[i] < s->cells[i];
      if (!inside) continue;
      for (int b = s->first[at[0] + s->cells[0] * (at[1] + s->cells[1] * at[2])]; b >= 0;
           b = s->next[b]) {
        double n[3] = {0}, length = 0;
        for (int i = 0; i < s->d; i++) {
          n[i] = s->x[3 * a + i] - s->x[3 * b + i];
          length += n[i] * n[i];
        }
        length = sqrt(length);
        const double overlap = s->radius[a] + s->radius[b] - length;
        if (b >= a || overlap <= -gap || length == 0) continue;
        for (int i = 0; i < s->d; i++)
          n[i] /= length;
        each(data, a, b, n, overlap);
      }
    }
  }
}

static void settling_press(void *data, int a, int b, const double *n, double overlap) {
  settling *s = data;
  for (int i = 0; i < s->d; i++) {
    s->f[3 * a + i] += overlap * n[i];
    s->f[3 * b + i] -= overlap * n[i];
  }
}

/* Fast inertial relaxation (Bitzek et al. 2006) until forces are 1e-9 of a unit overlap's. */
static void settling_run(settling *s) {
  const int n = 3 * s->count;
  double step = 0.3, mix = 0.1;
  for (int k = 0, downhill = 0; k < most_settling; k++) {
    settling_sort(s);
    memset(s->f, 0, (size_t)n * sizeof *s->f);
    for (int a = 0; a < s->count; a++) {
      const double R = s->radius[a], *x = s->x + 3 * a;
      s->f[3 * a + s->d - 1] -= s->gravity * pow(R, s->d);
      for (int i = 0; i < s->d; i++) {
        s->f[3 * a + i] += fmax(0, R - x[i]);
        if (i < s->d - 1) s->f[3 * a + i] -= fmax(0, x[i] + R - s->side);
      }
    }
    settling_pairs(s, 0, settling_press, s);
    double power = 0, vv = 0, ff = 0;
    for (int i = 0; i < n; i++) {
      power += s->f[i] * s->v[i];
      vv += s->v[i] * s->v[i];
      ff += s->f[i] * s->f[i];
    }
    if (sqrt(ff / s->count) < 1e-9) break;
    if (power > 0 && ++downhill > 5) {
      step = fmin(1.1 * step, 0.6);
      mix *= 0.99;
    } else if (power <= 0) {
      memset(s->v, 0, (size_t)n * sizeof *s->v);
      vv = downhill = 0;
      step = fmax(step / 2, 0.02);
      mix = 0.1;
    }
    for (int i = 0; i < n; i++) {
      s->v[i] = (1 - mix) * s->v[i] + (mix * sqrt(vv / ff) + step) * s->f[i];
      s->x[i] += step * s->v[i];
    }
  }
  settling_sort(s);
}

typedef struct settled {
  heap *h;
  const double *radius;
  double gap;
} settled;

static void settled_touch(void *data, int a, int b, const double *n, double overlap) {
  const settled *of = data;
  (void)n;
  (void)overlap;
  touch_spheres(of->h, a, b, of->radius, of->gap);
}

/* mixed: densities from 1/32 to 32 in place of 1. sizes: radii from 1 to 10 in place of .7 to 1.3,
 * uniform in their logarithm. */
static void make_settled(heap *h, int d, int candidates, int flow, int mixed, int sizes) {
  static const double spread = 0.3, near = 0.01;
  settling s = {.d = d, .count = (int)fmax(4, candidates / (d == 2 ? 2.05 : 2.9))};
  const size_t n = (size_t)s.count;
  h->d = d;
  s.x = calloc(3 * n, sizeof *s.x);
  s.v = calloc(3 * n, sizeof *s.v);
  s.f = calloc(3 * n, sizeof *s.f);
  s.radius = calloc(n, sizeof *s.radius);
  s.next = calloc(n, sizeof *s.next);
  h->bad |= !s.x || !s.v || !s.f || !s.radius || !s.next;
  double volume = 0;
  for (int a = 0; a < s.count && !h->bad; a++) {
    s.radius[a] = sizes ? pow(10, (1 + heap_random(h)) / 2) : 1 + spread * heap_random(h);
    volume += d == 2 ? 3.1416 * s.radius[a] * s.radius[a] : 4.1888 * pow(s.radius[a], 3);
  }
  s.side = d == 2 ? sqrt(volume / 0.83) : cbrt(volume / 0.63);
  s.cell = 2 * (sizes ? 10 : 1 + spread);
  s.gravity = sizes ? 2e-4 / (volume / s.count) : 2e-4;
  for (int i = 0; i < 3; i++)
    s.cells[i] = i < d ? (int)fmax(1, 1.5 * s.side / s.cell) : 1;
  s.first = calloc((size_t)s.cells[0] * (size_t)s.cells[1] * (size_t)s.cells[2], sizeof *s.first);
  h->bad |= !s.first;
  for (int a = 0; a < s.count && !h->bad; a++)
    for (int i = 0; i < d; i++)
      s.x[3 * a + i] = s.radius[a] + (s.side / 2 - s.radius[a]) * (1 + heap_random(h));
  if (!h->bad) settling_run(&s);
  for (int a = 0; a < s.count && !h->bad; a++) {
    const double R = s.radius[a], density = mixed ? exp2(5 * heap_random(h)) : 1;
    const double m = density * pow(R, d), I = (d == 2 ? 0.5 : 0.4) * m * R * R;
    solid body = {.mass = m, .inertia = {I, I, I}};
    for (int i = 0; i < d; i++) {
      body.x[i] = s.x[3 * a + i];
      if (flow) body.v[i] = 0.15 * heap_random(h);
    }
    for (int i = d == 2 ? 2 : 0; i < 3 && flow; i++)
      body.spin[i] = 0.15 * heap_random(h);
    body.v[d - 1] -= step_of_gravity;
    (void)heap_add_body(h, body);
    if (!h->bad) touch_box(h, a, R, 0, s.side, near);
  }
  settled of = {h, s.radius, near};
  if (!h->bad) settling_pairs(&s, near, settled_touch, &of);
  free(s.x);
  free(s.v);
  free(s.f);
  free(s.radius);
  free(s.next);
  free(s.first);
}

/* ---- walls, chains, arches, towers ----------------------------------------------------------- */

/* Returns a box with this middle and these sides, of unit density; d = 2: lz = 1. */
static solid box(double x, double y, double z, double lx, double ly, double lz) {
  const double m = lx * ly * lz;
  return (solid){.x = {x, y, z},
                 .mass = m,
                 .inertia = {m * (ly * ly + lz * lz) / 12, m * (lx * lx + lz * lz) / 12,
                             m * (lx * lx + ly * ly) / 12}};
}

/* Lays a row of bricks from 0 to `width`; edge (2 width + 2): where they begin and end. Returns how
 * many. */
static int lay_row(heap *h, int row, int width, int random, double *edge) {
  int count = 0;
  edge[0] = 0;
  while (edge[count] < width) {
    double length = random ? 2 + heap_random(h) : row % 2 && count == 0 ? 1 : 2;
    if (width - edge[count] - length < (random ? 1 : 0.5)) length = width - edge[count];
    edge[count + 1] = edge[count] + length;
    count++;
  }
  for (int i = 0; i < count; i++) {
    const double length = edge[i + 1] - edge[i];
    (void)heap_add_body(h, box(edge[i] + length / 2, row + 0.5, 0, length, 1, 1));
  }
  return count;
}

/* Touches a and b along the bottom of a between two x; d = 3: at four corners. */
static void touch_along(heap *h, int a, int b, double from, double to, double y) {
  for (int k = 0; k < (h->d == 2 ? 2 : 4); k++)
    heap_touch(h, (place){.a = a,
                          .b = b,
                          .x = {k % 2 ? to : from, y, h->d == 2 ? 0 : k / 2 - 0.5},
                          .normal = {0, 1, 0}});
}

/* Rows of bricks from 0 to `width`; 2 (d - 1) candidates an overlap. */
static void make_wall(heap *h, int d, int rows, int width, int random, double push) {
  h->d = d;
  double *edge = calloc(2 * (2 * (size_t)width + 2), sizeof *edge);
  double *lower = edge, *upper = edge ? edge + 2 * width + 2 : NULL;
  h->bad |= !edge;
  for (int row = 0, first = 0, below = 0, under = 0; row < rows && !h->bad; row++) {
    const int count = lay_row(h, row, width, random, upper);
    for (int i = 0; i < count; i++) {
      if (row == 0) touch_along(h, first + i, -1, upper[i], upper[i + 1], 0);
      for (int k = 0; row > 0 && k < under; k++) {
        const double from = fmax(lower[k], upper[i]), to = fmin(lower[k + 1], upper[i + 1]);
        if (to > from) touch_along(h, first + i, below + k, from, to, row);
      }
    }
    below = first;
    first += count;
    under = count;
    double *other = lower;
    lower = upper;
    upper = other;
  }
  for (int b = 0; b < h->bodies; b++) {
    h->body[b].v[0] = push;
    h->body[b].v[1] = -1;
    if (d == 3) h->body[b].v[2] = push / 3;
  }
  free(edge);
}

static void make_chain(heap *h, int d, int candidates) {
  h->d = d;
  for (int k = 0; k < candidates; k++) {
    solid disc = {
        .x = {0, k + 0.5}, .v = {0.01 * heap_random(h), -1}, .mass = 1, .inertia = {0, 0, 0.125}};
    if (d == 3) {
      disc.v[2] = 0.01 * heap_random(h);
      for (int i = 0; i < 3; i++)
        disc.inertia[i] = 0.1; /* of a ball */
    }
    (void)heap_add_body(h, disc);
    heap_touch(h, (place){.a = k, .b = k - 1, .x = {0, k}, .normal = {0, 1}});
  }
}

/* d = 3: voussoirs as deep as they are thick. */
static void make_arch(heap *h, int d, int candidates) {
  const int joint = 2 * (d - 1), n = candidates / joint > 2 ? candidates / joint - 1 : 1;
  const double thick = 0.3, angle = acos(-1.) / n, depth = d == 3 ? thick : 1;
  h->d = d;
  for (int k = 0; k <= n; k++) { /* joint k stands before voussoir k */
    const double at = angle * k, middle = angle * (k + 0.5), m = thick * angle * depth;
    const double along = k < n ? 1 : -1; /* the last joint: voussoir n - 1 upon the ground */
    solid s = {.x = {-cos(middle), sin(middle)},
               .v = {0, -step_of_gravity},
               .mass = m,
               .inertia = {0, 0, m * (thick * thick + angle * angle) / 12}};
    for (int i = 0; i < 2; i++) /* the same about all axes in the plane */
      s.inertia[i] = d == 3 ? m * (depth * depth + thick * thick) / 12 : 0;
    if (k < n) (void)heap_add_body(h, s);
    for (int end = 0; end < joint; end++) {
      const double R = 1 + (end % 2 ? thick : -thick) / 2;
      heap_touch(h, (place){.a = k < n ? k : n - 1,
                            .b = k < n ? k - 1 : -1,
                            .x = {-R * cos(at), R * sin(at), d == 3 ? (end / 2 - 0.5) * depth : 0},
                            .normal = {along * sin(at), along * cos(at)}});
    }
  }
}

/* Square blocks upon each other, d = 2. */
static void make_pile(heap *h, int candidates) {
  h->d = 2;
  for (int k = 0; 2 * k < candidates; k++) {
    solid b = box(0, k + 0.5, 0, 1, 1, 1);
    b.v[0] = 0.4 / candidates; /* a fifth of what would tip it over */
    b.v[1] = -1;
    touch_along(h, heap_add_body(h, b), k - 1, -0.5, 0.5, k);
  }
}

static void make_tower(heap *h, int candidates) {
  const double thick = 0.4;
  h->d = 3; /* y upwards, as in walls */
  for (int layer = 0; 36 * layer < candidates; layer++)
    for (int k = 0; k < 3; k++) {
      const int crosswise = layer % 2;
      const double side = k - 1., y = thick * (layer + 0.5);
      solid plank = crosswise ? box(side, y, 0, 1, thick, 3) : box(0, y, side, 3, thick, 1);
      plank.v[1] = -1;
      const int a = heap_add_body(h, plank);
      for (int under = 0; under < 3; under++)
        for (int corner = 0; corner < 4 && !h->bad; corner++) {
          const double along = under - 1 + (corner % 2 ? 0.45 : -0.45);
          const double across = side + (corner / 2 ? 0.45 : -0.45);
          heap_touch(h, (place){.a = a,
                                .b = layer ? 3 * (layer - 1) + under : -1,
                                .x = {crosswise ? across : along, thick * layer,
                                      crosswise ? along : across},
                                .normal = {0, 1, 0}});
        }
    }
}

/* ---- W and q --------------------------------------------------------------------------------- */

/* Computes the rows n, t (, s) of the velocity of body b at a place, for its motions times
 * M^1/2. H: n x d, their transpose, column-major. */
static void rigid_rows(int d, const place *at, const solid *b, double sign, double *H) {
  double frame[3][3] = {{0}}, arm[3], turn[3];
  memcpy(frame[0], at->normal, sizeof frame[0]);
  const double *n = frame[0];
  if (d == 2) {
    frame[1][0] = n[1];
    frame[1][1] = -n[0];
  } else {
    const int axis = fabs(n[0]) < 0.6 ? 0 : 1;
    double length = 0;
    for (int i = 0; i < 3; i++) {
      frame[1][i] = (i == axis) - n[axis] * n[i];
      length += frame[1][i] * frame[1][i];
    }
    for (int i = 0; i < 3; i++)
      frame[1][i] /= sqrt(length);
    rigid_cross(n, frame[1], frame[2]);
  }
  for (int i = 0; i < 3; i++)
    arm[i] = at->x[i] - b->x[i];
  for (int r = 0; r < d; r++, H += 3 * (d - 1)) {
    rigid_cross(arm, frame[r], turn);
    for (int i = 0; i < d; i++)
      H[i] = sign * frame[r][i] / sqrt(b->mass);
    for (int i = d == 2 ? 2 : 0; i < 3; i++)
      H[d == 2 ? 2 : 3 + i] = sign * turn[i] / sqrt(b->inertia[i]);
  }
}

/* Lists the candidates of each body: of body b list[first[b]] .. list[first[b + 1] - 1]. */
static void rigid_list(const rigid *a, int *first, int *list) {
  const int nc = a->contact.nc;
  for (int k = 0; k < 2 * nc; k++)
    if (a->body[k] >= 0) first[a->body[k] + 1]++;
  for (int b = 0; b < a->bodies; b++)
    first[b + 1] += first[b];
  for (int k = 0; k < 2 * nc; k++)
    if (a->body[k] >= 0) list[first[a->body[k]]++] = k / 2;
  for (int b = a->bodies; b > 0; b--)
    first[b] = first[b - 1];
  first[0] = 0;
}

/* Adds block (e, c) of W, H_e^T H_c of the bodies that both have. */
static void rigid_couple(const rigid *a, int e, int c, double *block) {
  const int d = a->d, n = 3 * (d - 1);
  for (int k = 0; k < 4; k++) {
    const double *E = a->H + (size_t)(2 * e + k / 2) * (size_t)(d * n);
    const double *C = a->H + (size_t)(2 * c + k % 2) * (size_t)(d * n);
    if (a->body[2 * e + k / 2] < 0 || a->body[2 * e + k / 2] != a->body[2 * c + k % 2]) continue;
    for (int l = 0; l < n; l++)
      for (int j = 0; j < d; j++)
        for (int i = 0; i < d; i++)
          block[i + d * j] += E[l + n * i] * C[l + n * j];
  }
}

/* Fills p, i and, if there is room, x. seen: nc, scratch. Returns the number of blocks. */
static int rigid_blocks(rigid *a, const int *first, const int *list, int *seen) {
  const int d = a->d, nc = a->contact.nc;
  int count = 0;
  memset(seen, -1, (size_t)nc * sizeof *seen);
  for (int c = 0; c < nc; c++) {
    a->p[c] = count;
    for (int side = 0; side < 2; side++) {
      const int b = a->body[2 * c + side];
      for (int k = b < 0 ? 0 : first[b]; b >= 0 && k < first[b + 1]; k++) {
        if (seen[list[k]] == c) continue;
        seen[list[k]] = c;
        if (a->x) {
          a->i[count] = list[k];
          rigid_couple(a, list[k], c, a->x + (size_t)count * (size_t)(d * d));
        }
        count++;
      }
    }
  }
  a->p[nc] = count;
  return count;
}

int rigid_room(rigid *a, int d, int bodies, int nc) {
  const size_t n = (size_t)(3 * (d - 1)), b = (size_t)bodies, candidates = (size_t)nc;
  *a = (rigid){.d = d, .bodies = bodies, .contact = {.d = d, .nc = nc}};
  a->body = calloc(2 * candidates, sizeof *a->body);
  a->H = calloc(2 * candidates * n * (size_t)d, sizeof *a->H);
  a->v = calloc(b * n, sizeof *a->v);
  a->q = calloc((size_t)d * candidates, sizeof *a->q);
  a->mu = calloc(candidates, sizeof *a->mu);
  return a->body && a->H && a->v && a->q && a->mu ? 0 : -1;
}

int rigid_assemble(rigid *a) {
  const int d = a->d, n = 3 * (d - 1), nc = a->contact.nc;
  for (int k = 0; k < 2 * nc; k++)
    for (int l = 0; l < n && a->body[k] >= 0; l++)
      for (int i = 0; i < d; i++)
        a->q[d * (k / 2) + i] += a->H[(size_t)(k * d + i) * (size_t)n + (size_t)l] *
                                 a->v[(size_t)a->body[k] * (size_t)n + (size_t)l];
  const size_t candidates = (size_t)nc, bodies = (size_t)a->bodies;
  a->p = calloc(candidates + 1, sizeof *a->p);
  int *first = calloc(bodies + 1 + 3 * candidates, sizeof *first);
  if (a->p && first) {
    int *list = first + bodies + 1, *seen = list + 2 * candidates;
    rigid_list(a, first, list);
    const size_t count = (size_t)rigid_blocks(a, first, list, seen);
    a->i = calloc(count, sizeof *a->i);
    a->x = calloc(count * (size_t)(d * d), sizeof *a->x);
    if (a->i && a->x) (void)rigid_blocks(a, first, list, seen);
  }
  free(first);
  a->contact = (dls_contact){.d = d, .nc = nc, .q = a->q, .mu = a->mu};
  a->factored = a->contact;
  a->contact.Wb = (dls_blocks){d, nc, a->p, a->i, a->x};
  a->factored.bodies = (dls_bodies){n, a->bodies, a->body, a->H, NULL};
  return a->i && a->x ? 0 : -1;
}

/* Fills the arrays of a from the heap. Returns 0, or -1 without memory. */
static int rigid_fill(rigid *a, const heap *h, double mu) {
  const int d = h->d, n = 3 * (d - 1);
  if (rigid_room(a, d, h->bodies, h->places)) return -1;
  for (int b = 0; b < h->bodies; b++) {
    const solid *s = &h->body[b];
    double *v = a->v + b * n;
    for (int i = 0; i < d; i++)
      v[i] = sqrt(s->mass) * s->v[i];
    for (int i = d == 2 ? 2 : 0; i < 3; i++)
      v[d == 2 ? 2 : 3 + i] = sqrt(s->inertia[i]) * s->spin[i];
  }
  for (int k = 0; k < 2 * h->places; k++) {
    const place *at = &h->at[k / 2];
    const int b = a->body[k] = k % 2 ? at->b : at->a;
    a->mu[k / 2] = mu;
    if (b >= 0) rigid_rows(d, at, &h->body[b], k % 2 ? -1 : 1, a->H + (size_t)k * (size_t)(d * n));
  }
  return rigid_assemble(a);
}

int rigid_close(rigid *a, heap *h, double mu) {
  const int bad = h->bad || h->places == 0 || rigid_fill(a, h, mu) ? -1 : 0;
  if (bad) rigid_free(a);
  free(h->body);
  free(h->at);
  return bad;
}

void rigid_free(rigid *a) {
  free(a->body);
  free(a->H);
  free(a->v);
  free(a->p);
  free(a->i);
  free(a->x);
  free(a->q);
  free(a->mu);
  *a = (rigid){0};
}

static const char *const kinds[] = {
    "packing-rest", "packing-flow", "wall-rest",   "wall-pushed", "rubble-rest", "rubble-pushed",
    "wall3-rest",   "wall3-pushed", "chain",       "chain3",      "arch",        "arch3",
    "tower2",       "tower",        "discs-rest",  "discs-flow",  "balls-rest",  "balls-flow",
    "mixed2-rest",  "mixed3-rest",  "sizes2-flow", "sizes3-flow"};
enum { kind_count = sizeof kinds / sizeof kinds[0], listed_count = kind_count - 2 };

const char *rigid_kind(int index) {
  return index >= 0 && index < listed_count ? kinds[index] : NULL;
}

int rigid_create(rigid *a, const char *kind, int candidates, double mu, uint64_t seed) {
  heap h = {.state = seed * 0x9E3779B97F4A7C15u + 1};
  int k = 0;
  *a = (rigid){0};
  while (k < kind_count && strcmp(kind, kinds[k]) != 0)
    k++;
  for (int warm = 0; warm < 8; warm++)
    (void)heap_random(&h);
  if (k < 2) make_packing(&h, candidates, k == 1);
  if (k >= 2 && k < 8) { /* half as high in bricks as it is wide */
    const int d = k < 6 ? 2 : 3, rows = (int)fmax(2, round(sqrt(candidates / (4. * (d - 1)))));
    make_wall(&h, d, rows, 2 * rows, k / 2 == 2, k % 2 ? 0.3 : 0);
  }
  if (k == 8 || k == 9) make_chain(&h, k - 6, candidates);
  if (k == 10 || k == 11) make_arch(&h, k - 8, candidates);
  if (k == 12) make_pile(&h, candidates);
  if (k == 13) make_tower(&h, candidates);
  if (k >= 14 && k < 18) make_settled(&h, k < 16 ? 2 : 3, candidates, k % 2, 0, 0);
  if (k >= 18 && k < listed_count) make_settled(&h, k - 16, candidates, 0, 1, 0);
  if (k >= listed_count && k < kind_count)
    make_settled(&h, k - listed_count + 2, candidates, 1, 0, 1);
  return rigid_close(a, &h, mu);
}

int rigid_wall(rigid *a, int rows, int width, double push, double mu) {
  heap h = {0};
  make_wall(&h, 2, rows, 2 * width, 0, push);
  return rigid_close(a, &h, mu);
}
