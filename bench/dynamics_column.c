/* dynamics_column.c: spheres in steps of time, as dynamics_column.h describes them. */
#include "dynamics_column.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

static const double gravity = 9.81, mean_radius = 0.01, density = 2500; /* m/s2, m, kg/m3 */
static const double margin = 0.1;                                       /* of the mean radius */

enum { d = 3, n = 6, contacts_of_one = 8 };

/* Places sphere k on layers of side x side, each in the hollows of the one below. */
static void column_place(column *a, const column_kind *kind, int k, int side, uint64_t *state) {
  const double cell = kind->cell * mean_radius, reach = 2 * mean_radius * (1 + kind->spread);
  const double rise = sqrt(reach * reach - cell * cell / 2) + kind->shake * mean_radius;
  const int layer = k / (side * side), row = k / side % side, spot = k % side;
  const double radius = a->radius[k] = mean_radius * (1 + kind->spread * bench_draw(state));
  dls_rigid *s = &a->sphere[k];
  s->mass = density * 4 / 3 * acos(-1) * pow(radius, 3);
  for (int i = 0; i < d; i++) {
    s->inertia[4 * i] = 0.4 * s->mass * radius * radius;
    s->R[4 * i] = 1;
  }
  s->x[0] = cell * (spot + layer % 2 * 0.5) + kind->shake * mean_radius * bench_draw(state);
  s->x[1] = cell * (row + layer % 2 * 0.5) + kind->shake * mean_radius * bench_draw(state);
  s->x[2] = mean_radius * (1 + kind->spread) + rise * layer;
}

static int column_room(column *a, size_t count, size_t most) {
  a->sphere = calloc(count, sizeof *a->sphere);
  a->radius = calloc(count + (2 * d * n + d + 1) * most, sizeof *a->radius);
  int *numbers = calloc(6 * count + 2 + 5 * most + (size_t)a->buckets, sizeof *numbers);
  if (!a->sphere || !a->radius || !numbers) return free(numbers), -1;
  a->H = a->radius + count;
  a->q = a->H + (size_t)(2 * d * n) * most;
  a->mu = a->q + d * most;
  a->now.first = numbers;
  a->last.first = a->now.first + count + 1;
  a->now.body = a->last.first + count + 1;
  a->last.body = a->now.body + 2 * most;
  a->from = a->last.body + 2 * most;
  a->next = a->from + most;
  a->cell = a->next + count;
  a->head = a->cell + d * count;
  return 0;
}

int column_create(column *a, const column_kind *kind, int count, uint64_t seed) {
  *a = (column){.count = count, .most = contacts_of_one * count, .buckets = 1};
  a->h = kind->h;
  a->friction = 0.4;
  while (a->buckets < 2 * count)
    a->buckets *= 2;
  if (column_room(a, (size_t)count, (size_t)a->most)) {
    column_free(a);
    return -1;
  }
  const int side = (int)fmax(2, round(cbrt(count / 4.)));
  for (int k = 0; k < count; k++)
    column_place(a, kind, k, side, &seed);
  return 0;
}

void column_free(column *a) {
  free(a->sphere);
  free(a->radius);
  /* the arrays of two steps change places */
  free(a->now.first < a->last.first ? a->now.first : a->last.first);
  *a = (column){0};
}

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

/* Adds the contact of sphere `one` with another one, -1: the floor. */
static int column_touch(column *a, int one, int other, const double *normal, double gap) {
  if (a->now.count == a->most) return -1;
  const int c = a->now.count++;
  const double *x = a->sphere[one].x, arm = a->radius[one];
  const double point[3] = {x[0] - arm * normal[0], x[1] - arm * normal[1], x[2] - arm * normal[2]};
  a->from[c] = column_find(&a->last, one, other);
  a->mu[c] = a->friction;
  return dls_rigid_contact(a->count, a->sphere, one, other, point, normal, gap / a->h, c,
                           a->now.body, a->H, a->q, NULL, NULL);
}

/* Adds the contact of two spheres if they are near. */
static int column_try(column *a, int one, int other) {
  const double *x = a->sphere[one].x, *y = a->sphere[other].x;
  const double across[3] = {x[0] - y[0], x[1] - y[1], x[2] - y[2]};
  const double length = hypot(hypot(across[0], across[1]), across[2]);
  const double gap = length - a->radius[one] - a->radius[other];
  const double normal[3] = {across[0] / length, across[1] / length, across[2] / length};
  return gap < margin * mean_radius ? column_touch(a, one, other, normal, gap) : 0;
}

/* Adds the contacts of a sphere with the floor and with the spheres before it. */
static int column_look_around(column *a, int k) {
  static const double up[3] = {0, 0, 1};
  const double height = a->sphere[k].x[2] - a->radius[k];
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
  for (int k = 0; k < a->count; k++)
    a->sphere[k].v[2] -= gravity * a->h;
  for (int k = 0; k < a->count; k++) {
    int *cell = a->cell + (size_t)d * (size_t)k;
    for (int i = 0; i < d; i++)
      cell[i] = (int)floor(a->sphere[k].x[i] / (2.3 * mean_radius));
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

void column_move(column *a, const double *r) {
  if (dls_rigid_apply(a->count, a->sphere, a->now.count, a->now.body, a->H, r, NULL)) exit(1);
  for (int k = 0; k < a->count; k++)
    for (int i = 0; i < d; i++)
      a->sphere[k].x[i] += a->h * a->sphere[k].v[i];
}
