/* dynamics_column.c: spheres in steps of time, as dynamics_column.h describes them. */
#include "dynamics_column.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "rigid.h"

static const double gravity = 9.81, mean_radius = 0.01, density = 2500; /* m/s2, m, kg/m3 */
static const double margin = 0.1;                                       /* of the mean radius */

enum { d = 3, n = 6, contacts_of_one = 8 };

static double column_dot(const double *x, const double *y) {
  return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

/* Places sphere k on layers of side x side, each in the hollows of the one below. */
static void column_place(column *a, const column_kind *kind, int k, int side, uint64_t *state) {
  const double cell = kind->cell * mean_radius, reach = 2 * mean_radius * (1 + kind->spread);
  const double rise = sqrt(reach * reach - cell * cell / 2) + kind->shake * mean_radius;
  const int layer = k / (side * side), row = k / side % side, spot = k % side;
  double *x = a->x + (size_t)d * (size_t)k;
  a->radius[k] = mean_radius * (1 + kind->spread * bench_draw(state));
  a->mass[k] = density * 4 / 3 * acos(-1) * pow(a->radius[k], 3);
  x[0] = cell * (spot + layer % 2 * 0.5) + kind->shake * mean_radius * bench_draw(state);
  x[1] = cell * (row + layer % 2 * 0.5) + kind->shake * mean_radius * bench_draw(state);
  x[2] = mean_radius * (1 + kind->spread) + rise * layer;
}

static double *column_values(column *a, size_t count, size_t most) {
  double *values = calloc(11 * count + (2 * d + 2 * n * d + d + 1) * most, sizeof *values);
  if (!values) return NULL;
  a->x = values;
  a->v = a->x + d * count;
  a->radius = a->v + n * count;
  a->mass = a->radius + count;
  a->now.tangent = a->mass + count;
  a->last.tangent = a->now.tangent + d * most;
  a->H = a->last.tangent + d * most;
  a->q = a->H + (size_t)(2 * n * d) * most;
  a->mu = a->q + d * most;
  return values;
}

static int *column_numbers(column *a, size_t count, size_t most) {
  int *numbers = calloc(6 * count + 2 + 5 * most + (size_t)a->buckets, sizeof *numbers);
  if (!numbers) return NULL;
  a->now.first = numbers;
  a->last.first = a->now.first + count + 1;
  a->now.body = a->last.first + count + 1;
  a->last.body = a->now.body + 2 * most;
  a->from = a->last.body + 2 * most;
  a->next = a->from + most;
  a->cell = a->next + count;
  a->head = a->cell + d * count;
  return numbers;
}

int column_create(column *a, const column_kind *kind, int count, uint64_t seed) {
  *a = (column){.count = count, .most = contacts_of_one * count, .buckets = 1};
  a->h = kind->h;
  a->friction = 0.4;
  while (a->buckets < 2 * count)
    a->buckets *= 2;
  if (!column_values(a, (size_t)count, (size_t)a->most) ||
      !column_numbers(a, (size_t)count, (size_t)a->most)) {
    column_free(a);
    return -1;
  }
  const int side = (int)fmax(2, round(cbrt(count / 4.)));
  for (int k = 0; k < count; k++)
    column_place(a, kind, k, side, &seed);
  return 0;
}

void column_free(column *a) {
  free(a->x);
  /* the arrays of two steps change places */
  free(a->now.first < a->last.first ? a->now.first : a->last.first);
  *a = (column){0};
}

/* ---- contacts -------------------------------------------------------------------------------- */

static int column_bucket(const column *a, const int *cell) {
  const uint32_t x = (uint32_t)cell[0], y = (uint32_t)cell[1], z = (uint32_t)cell[2];
  return (int)((x * 73856093u ^ y * 19349663u ^ z * 83492791u) & (uint32_t)(a->buckets - 1));
}

/* Returns the contact of the pair in the step before; -1: there was none. */
static int column_find(const column_contacts *last, int one, int other) {
  for (int c = last->first[one]; c < last->first[one + 1]; c++)
    if (last->body[2 * c + 1] == other) return c;
  return -1;
}

/* t := the unit vector across the normal that is nearest to the old t. */
static void column_turn(const double *normal, const double *old, double *t) {
  const double along = column_dot(normal, old);
  for (int i = 0; i < d; i++)
    t[i] = old[i] - along * normal[i];
  const double length = sqrt(column_dot(t, t));
  for (int i = 0; i < d; i++)
    t[i] /= length;
}

/* Writes the blocks of H for sphere k, its middle `arm` away from the contact along the normal, and
 * adds its velocity to u. */
static void column_write(const column *a, int k, double arm, double sign, double frame[3][3],
                         double *H, double *u) {
  const double by_mass = sign / sqrt(a->mass[k]);
  const double by_inertia = sign / (sqrt(0.4 * a->mass[k]) * a->radius[k]);
  const double lever[3] = {-arm * frame[0][0], -arm * frame[0][1], -arm * frame[0][2]};
  const double *v = a->v + (size_t)n * (size_t)k;
  for (int j = 0; j < d; j++) {
    double turn[3];
    rigid_cross(lever, frame[j], turn);
    for (int i = 0; i < d; i++) {
      H[n * j + i] = by_mass * frame[j][i];
      H[n * j + d + i] = by_inertia * turn[i];
    }
    u[j] += sign * (column_dot(v, frame[j]) + column_dot(v + d, turn));
    u[j] += sign * -gravity * a->h * frame[j][2];
  }
}

/* Adds the contact of sphere `one` with another one, -1: the floor. */
static int column_touch(column *a, int one, int other, const double *normal, double gap) {
  static const double axes[2][3] = {{1, 0, 0}, {0, 1, 0}};
  if (a->now.count == a->most) return -1;
  const size_t c = (size_t)a->now.count++;
  double frame[3][3], *H = a->H + 2 * n * d * c, *q = a->q + d * c;
  a->now.body[2 * c] = one;
  a->now.body[2 * c + 1] = other;
  a->from[c] = column_find(&a->last, one, other);
  memcpy(frame[0], normal, sizeof frame[0]);
  column_turn(normal,
              a->from[c] >= 0 ? a->last.tangent + d * (size_t)a->from[c]
                              : axes[fabs(normal[0]) > 0.7],
              frame[1]);
  memcpy(a->now.tangent + d * c, frame[1], sizeof frame[1]);
  rigid_cross(frame[0], frame[1], frame[2]);
  memset(q, 0, d * sizeof *q);
  column_write(a, one, a->radius[one], 1, frame, H, q);
  if (other >= 0) column_write(a, other, -a->radius[other], -1, frame, H + n * d, q);
  q[0] += gap / a->h;
  a->mu[c] = a->friction;
  return 0;
}

/* Adds the contact of two spheres if they are near. */
static int column_try(column *a, int one, int other) {
  const double *x = a->x + (size_t)d * (size_t)one, *y = a->x + (size_t)d * (size_t)other;
  double normal[3] = {x[0] - y[0], x[1] - y[1], x[2] - y[2]};
  const double length = sqrt(column_dot(normal, normal));
  const double gap = length - a->radius[one] - a->radius[other];
  if (gap >= margin * mean_radius) return 0;
  for (int i = 0; i < d; i++)
    normal[i] /= length;
  return column_touch(a, one, other, normal, gap);
}

/* Adds the contacts of a sphere with the floor and with the spheres before it. */
static int column_look_around(column *a, int k) {
  static const double up[3] = {0, 0, 1};
  const double height = a->x[(size_t)d * (size_t)k + 2] - a->radius[k];
  const int *of = a->cell + (size_t)d * (size_t)k;
  if (height < margin * mean_radius && column_touch(a, k, -1, up, height)) return -1;
  for (int near = 0; near < 27; near++) {
    const int cell[3] = {of[0] + near % 3 - 1, of[1] + near / 3 % 3 - 1, of[2] + near / 9 - 1};
    for (int j = a->head[column_bucket(a, cell)]; j >= 0; j = a->next[j])
      if (memcmp(a->cell + (size_t)d * (size_t)j, cell, sizeof cell) == 0 && column_try(a, k, j))
        return -1;
  }
  return 0;
}

int column_look(column *a) {
  const column_contacts last = a->now;
  a->now = a->last;
  a->last = last;
  a->now.count = 0;
  for (int b = 0; b < a->buckets; b++)
    a->head[b] = -1;
  for (int k = 0; k < a->count; k++) {
    int *cell = a->cell + (size_t)d * (size_t)k;
    for (int i = 0; i < d; i++)
      cell[i] = (int)floor(a->x[(size_t)d * (size_t)k + (size_t)i] / (2.3 * mean_radius));
    a->now.first[k] = a->now.count;
    if (column_look_around(a, k)) return -1;
    const int bucket = column_bucket(a, cell);
    a->next[k] = a->head[bucket];
    a->head[bucket] = k;
  }
  a->now.first[a->count] = a->now.count;
  a->contact = (dls_contact){.d = d, .nc = a->now.count, .q = a->q, .mu = a->mu};
  a->contact.bodies = (dls_bodies){n, a->count, a->now.body, a->H, NULL};
  return 0;
}

/* ---- the step -------------------------------------------------------------------------------- */

void column_move(column *a, const double *r) {
  for (int k = 0; k < a->count; k++)
    a->v[(size_t)n * (size_t)k + 2] -= gravity * a->h;
  for (size_t e = 0; e < 2 * (size_t)a->now.count; e++) {
    const int k = a->now.body[e];
    if (k < 0) continue;
    const double *H = a->H + n * d * e, *rc = r + d * (e / 2);
    const double by[2] = {1 / sqrt(a->mass[k]), 1 / (sqrt(0.4 * a->mass[k]) * a->radius[k])};
    double *v = a->v + (size_t)n * (size_t)k;
    for (int i = 0; i < n; i++)
      v[i] += by[i / d] * (H[i] * rc[0] + H[n + i] * rc[1] + H[2 * n + i] * rc[2]);
  }
  for (int k = 0; k < a->count; k++)
    for (int i = 0; i < d; i++)
      a->x[(size_t)d * (size_t)k + (size_t)i] += a->h * a->v[(size_t)n * (size_t)k + (size_t)i];
}
