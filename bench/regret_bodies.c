/* regret_bodies.c: machines and stacks of rigid bodies, from gears to dominoes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "regret_kinds.h"

static const double pi = 3.14159265358979;

int yard_open(yard *y, regret_problem *a, int d, int bodies, int contacts) {
  const size_t b = (size_t)bodies, c = (size_t)contacts, n = (size_t)(3 * (d - 1));
  y->a = a;
  y->d = d;
  y->n = (int)n;
  y->most_bodies = bodies;
  y->most_contacts = contacts;
  y->root = calloc(b * n, sizeof *y->root);
  y->middle = calloc(3 * b, sizeof *y->middle);
  a->own.body = calloc(2 * c, sizeof *a->own.body);
  a->own.H = calloc(2 * c * n * (size_t)d, sizeof *a->own.H);
  a->own.v = calloc(b * n, sizeof *a->own.v);
  a->own.q = calloc(c * (size_t)d, sizeof *a->own.q);
  a->own.mu = calloc(c, sizeof *a->own.mu);
  return y->root && y->middle && a->own.body && a->own.H && a->own.v && a->own.q && a->own.mu ? 0
                                                                                              : -1;
}

int yard_body(yard *y, const double *middle, double mass, const double *inertia, const double *v) {
  if (y->bodies == y->most_bodies) return -1;
  const int b = y->bodies++;
  for (int l = 0; l < y->n; l++) {
    const double m = l < y->d ? mass : inertia[l - y->d];
    y->root[b * y->n + l] = 1 / sqrt(m);
    y->a->own.v[b * y->n + l] = sqrt(m) * v[l];
  }
  memcpy(y->middle + 3 * b, middle, 3 * sizeof *middle);
  return b;
}

/* F := n, t, s, orthonormal; d = 2: t is n turned by a quarter. */
static void frame_of(int d, const double *normal, double F[3][3]) {
  memcpy(F[0], normal, sizeof F[0]);
  if (d == 2) {
    F[1][0] = -normal[1];
    F[1][1] = normal[0];
    F[1][2] = 0;
    return;
  }
  const double axis[3] = {fabs(normal[0]) < 0.6, fabs(normal[0]) >= 0.6, 0};
  regret_cross(normal, axis, F[1]);
  const double length = sqrt(F[1][0] * F[1][0] + F[1][1] * F[1][1] + F[1][2] * F[1][2]);
  for (int i = 0; i < 3; i++)
    F[1][i] /= length;
  regret_cross(F[0], F[1], F[2]);
}

void yard_touch(yard *y, int a, int b, const double *x, const double *normal) {
  const int d = y->d, n = y->n, c = y->contacts;
  double F[3][3];
  if (c == y->most_contacts) return;
  y->contacts++;
  y->a->own.mu[c] = y->mu;
  frame_of(d, normal, F);
  for (int side = 0; side < 2; side++) {
    const int of = y->a->own.body[2 * c + side] = side ? b : a;
    double *H = y->a->own.H + (size_t)(2 * c + side) * (size_t)(n * d);
    for (int j = 0; j < d && of >= 0; j++) {
      double arm[3], turn[3];
      for (int i = 0; i < 3; i++)
        arm[i] = x[i] - y->middle[3 * of + i];
      regret_cross(arm, F[j], turn);
      for (int l = 0; l < n; l++)
        H[l + n * j] = (side ? -1 : 1) * y->root[of * n + l] *
                       (l < d    ? F[j][l]
                        : d == 2 ? turn[2]
                                 : turn[l - 3]);
    }
  }
}

int yard_close(yard *y) {
  free(y->root);
  free(y->middle);
  return y->a && y->bodies ? regret_assemble(y->a, y->d, y->contacts, y->bodies) : -1;
}

/* Wheels of radius 1 in a square grid. The axle lends each wheel 50 times its mass. */
static void put_gears(yard *y, int side) {
  const double pressure = 0.349;
  for (int b = 0; b < side * side; b++) {
    const double m = 1.5 + 0.5 * bench_draw(&y->state), I = 0.5 * m;
    const double turn =
        ((b % side + b / side) % 2 ? -1 : 1) * (0.75 + 0.25 * bench_draw(&y->state));
    const double x[3] = {2. * (b % side), 2. * (b / side), 0};
    const double v[3] = {0.03 * bench_draw(&y->state), 0, turn};
    (void)yard_body(y, x, 50 * m, &I, v);
  }
  for (int a = 0; a < side * side; a++)
    for (int up = 0; up < 2; up++) {
      if ((up ? a / side : a % side) == side - 1) continue;
      const int b = up ? a + side : a + 1;
      const double e[2] = {!up, up}, *x = y->middle + 3 * a;
      for (int flank = 0; flank < 3; flank++) {
        const double s = flank < 2 ? 1 : -1, off = flank == 0 ? -0.05 : flank == 1 ? 0.05 : 0.02;
        const double n[3] = {-s * cos(pressure) * e[1] - sin(pressure) * e[0],
                             s * cos(pressure) * e[0] - sin(pressure) * e[1], 0};
        const double at[3] = {x[0] + (1 + off) * e[0] - off * s * e[1],
                              x[1] + (1 + off) * e[1] + off * s * e[0], 0};
        yard_touch(y, a, b, at, n);
      }
    }
}

/* Writes the point of elevation e and azimuth z on the sphere of radius R. */
static void on_sphere(double R, double e, double z, double *x) {
  x[0] = R * cos(e) * cos(z);
  x[1] = R * cos(e) * sin(z);
  x[2] = R * sin(e);
}

/* Rings of voussoirs in half bond up to an opening, from elevation 0 to 1.25. */
static void put_dome(yard *y, int rings, int stones) {
  const double inner = 1, outer = 1.12, middle = 1.06, wide = 2 * pi / stones, high = 1.25 / rings;
  for (int b = 0; b < rings * stones; b++) {
    const int ring = b / stones;
    const double e = high * (ring + 0.5), z = wide * (b % stones + 0.5 * (ring % 2));
    const double h = middle * high, w = middle * wide * cos(e), t = outer - inner, m = h * w * t;
    const double I = m * (h * h + w * w + t * t) / 18, inertia[3] = {I, I, I};
    double x[3], v[6] = {0.05, 0, -1};
    on_sphere(middle, e, z, x);
    for (int l = 0; l < 6; l++)
      v[l] += 0.003 * bench_draw(&y->state);
    (void)yard_body(y, x, m, inertia, v);
  }
  for (int b = 0; b < rings * stones; b++) {
    const int ring = b / stones, stone = b % stones, beside = ring * stones + (stone + 1) % stones;
    const double z = wide * (stone + 0.5 * (ring % 2)), low = high * ring;
    double x[3];
    for (int k = 0; k < 4; k++) {
      const double across[3] = {sin(z + wide / 2), -cos(z + wide / 2), 0};
      on_sphere(k & 2 ? outer : inner, k & 1 ? low + high : low, z + wide / 2, x);
      yard_touch(y, b, beside, x, across);
    }
    for (int k = 0; k < 4; k++) {
      const double to = z + (k & 1 ? 0.45 : -0.45) * wide;
      const double up[3] = {-sin(low) * cos(to), -sin(low) * sin(to), cos(low)};
      /* The one below on this half: half bond moves even rings by one. */
      const int left = stone - (ring % 2 == 0), half = left + (k & 1);
      on_sphere(k & 2 ? outer : inner, low, to, x);
      yard_touch(y, b, ring ? (ring - 1) * stones + (half + stones) % stones : -1, x, up);
    }
  }
}

/* Layers of crates of side 1: `side`^2, (side-1)^2, .., each on four, moved along at the top. */
static void put_pyramid(yard *y, int side, double along) {
  static const double up[3] = {0, 0, 1};
  int first = 0, below = 0;
  for (int layer = 0; layer < side; layer++) {
    const int wide = side - layer;
    for (int k = 0; k < wide * wide; k++) {
      const double m = 1 + 0.5 * bench_draw(&y->state), inertia[3] = {m / 6, m / 6, m / 6};
      const double x[3] = {k % wide + 0.5 * layer, k / wide + 0.5 * layer, layer + 0.5};
      const double v[6] = {along * (layer + 1.) / side, 0, -1};
      const int b = yard_body(y, x, m, inertia, v);
      for (int at = 0; at < (layer ? 12 : 4); at++) {
        const int right = at & 1, back = at >> 1 & 1;
        const double ax = layer ? 0.27 + 0.22 * bench_draw(&y->state) : 0.49;
        const double ay = layer ? 0.27 + 0.22 * bench_draw(&y->state) : 0.49;
        const double p[3] = {x[0] + (right ? ax : -ax), x[1] + (back ? ay : -ay), layer};
        const int lower = below + k % wide + right + (wide + 1) * (k / wide + back);
        yard_touch(y, b, layer ? lower : -1, p, up);
      }
    }
    below = first;
    first = y->bodies;
  }
}

/* A row of blocks between two walls. Every second is a keystone that is driven in from above; the
 * others stand on the floor. Each face has two contacts. */
static void put_wedges(yard *y, int count) {
  const double slope = 0.15;
  for (int b = 0; b < count; b++) {
    const double m = 1 + 0.3 * bench_draw(&y->state), I = m / 6, x[3] = {b, 0, 0};
    const double v[3] = {0.1 * bench_draw(&y->state), b % 2 ? -1 : -0.1, 0};
    (void)yard_body(y, x, m, &I, v);
  }
  for (int face = 0; face <= count; face++)
    for (int end = -1; end <= 1; end += 2) {
      const int left = face - 1, right = face < count ? face : -1;
      /* Faces of a keystone open upwards; the normal points to the body that is named first. */
      const double lean = (left < 0 || right < 0) ? 0 : (right % 2 ? 1 : -1) * slope;
      const double x[3] = {face - 0.5 - lean * 0.4 * end, 0.4 * end, 0};
      const double to_right[3] = {cos(lean), sin(lean), 0}, to_left[3] = {-1, 0, 0};
      if (right < 0)
        yard_touch(y, left, -1, x, to_left);
      else
        yard_touch(y, right, left, x, to_right);
    }
  for (int b = 0; b < count; b += 2)
    for (int end = -1; end <= 1; end += 2) {
      const double x[3] = {b + 0.4 * end, -0.5, 0}, up[3] = {0, 1, 0};
      yard_touch(y, b, -1, x, up);
    }
}

/* A row of gears on heavy axles, driven at both ends. Four flanks touch where two gears meet. */
static void put_train(yard *y, int count) {
  const double pressure = 0.349;
  for (int b = 0; b < count; b++) {
    const double m = 1.5 + 0.5 * bench_draw(&y->state), I = 0.5 * m, x[3] = {2. * b, 0, 0};
    const double driven = b == 0 ? 1 : b == count - 1 ? 0.6 : 0.15 * bench_draw(&y->state);
    const double v[3] = {0, 0, b % 2 ? -driven : driven};
    (void)yard_body(y, x, 80 * m, &I, v);
  }
  for (int b = 0; b + 1 < count; b++)
    for (int flank = 0; flank < 4; flank++) {
      const double side = flank < 2 ? 1 : -1, off = flank % 2 ? 0.04 : -0.05;
      const double n[3] = {-sin(pressure), side * cos(pressure), 0};
      const double at[3] = {2. * b + 1 + off, off * side, 0};
      yard_touch(y, b, b + 1, at, n);
    }
}

/* A row of books that two hands press together and lift: four corners touch between neighbours. */
static void put_books(yard *y, int count) {
  const double thick = 0.03, deep = 0.18, high = 0.25;
  for (int b = 0; b < count; b++) {
    const double m = 1 + 0.5 * bench_draw(&y->state), x[3] = {thick * b, 0, 0};
    const double inertia[3] = {m * (high * high + deep * deep) / 12,
                               m * (high * high + thick * thick) / 12,
                               m * (deep * deep + thick * thick) / 12};
    const double v[6] = {b == 0 ? 1 : b == count - 1 ? -1 : 0, 0, -0.1};
    (void)yard_body(y, x, m, inertia, v);
  }
  for (int face = 0; face <= count; face++)
    for (int corner = 0; corner < 4; corner++) {
      const double n[3] = {face < count ? 1 : -1, 0, 0};
      const double at[3] = {thick * (face - 0.5), corner & 1 ? deep / 2 : -deep / 2,
                            corner & 2 ? high / 2 : -high / 2};
      yard_touch(y, face < count ? face : count - 1, face < count ? face - 1 : -1, at, n);
    }
}

/* Logs across, stacked in rows of `wide` and wide - 1 between two posts. */
static void put_logs(yard *y, int wide) {
  int below = -1, first = 0;
  for (int row = 0; row < wide; row++, below = first, first = y->bodies) {
    const int odd = row % 2, logs = wide - odd;
    for (int k = 0; k < logs; k++) {
      const double m = 1.15 + 0.15 * bench_draw(&y->state), I = m / 8;
      const double x[3] = {k + 0.5 * odd, 0.866 * row, 0};
      const double v[3] = {0.003 * bench_draw(&y->state), -0.1 + 0.003 * bench_draw(&y->state),
                           0.003 * bench_draw(&y->state)};
      const int b = yard_body(y, x, m, &I, v);
      for (int side = 0; side < 2; side++) {
        const int lower = k + side - !odd, end = side ? logs - 1 : 0;
        const double lean = row ? 1.047 + 0.01 * bench_draw(&y->state) : pi / 2;
        const double n[3] = {(side ? -1 : 1) * cos(lean), sin(lean), 0};
        const double at[3] = {x[0] - 0.5 * n[0], x[1] - 0.5 * n[1], 0};
        const double post[3] = {side ? -1 : 1, 0, 0};
        const double wall[3] = {x[0] + (side ? 0.5 : -0.5), x[1], 0};
        if (row ? lower >= 0 && lower < wide - !odd : !side)
          yard_touch(y, b, row ? below + lower : -1, at, n);
        if (!odd && k == end) yard_touch(y, b, -1, wall, post);
      }
    }
  }
}

/* Layers of three beams 3 x 1 x .6, each across those below, some of them missing. Two beams touch
 * in four points. */
static void put_beams(yard *y, int layers, double along) {
  static const double up[3] = {0, 0, 1};
  int below[3] = {-1, -1, -1}, now[3];
  for (int layer = 0; layer < layers; layer++, memcpy(below, now, sizeof below)) {
    const int turned = layer % 2;
    for (int k = 0; k < 3; k++) {
      const double m = 1 + 0.02 * bench_draw(&y->state),
                   x[3] = {turned ? k - 1. : 0, turned ? 0 : k - 1., 0.6 * layer + 0.3};
      const double inertia[3] = {m * (turned ? 9.36 : 1.36) / 12, m * (turned ? 1.36 : 9.36) / 12,
                                 m * 10 / 12};
      const double v[6] = {along + 3e-4 * bench_draw(&y->state), 0, -0.1};
      const int inside = layer && layer < layers - 1;
      now[k] = inside && bench_draw(&y->state) < -0.8 ? -1 : yard_body(y, x, m, inertia, v);
      for (int at = 0; now[k] >= 0 && at < (layer ? 12 : 4); at++) {
        const int lower = layer ? below[at / 4] : -1;
        const double beside = layer ? at / 4 - 1. : 0, side = (at & 1 ? 0.45 : -0.45),
                     end = beside + (at & 2 ? 0.45 : -0.45) * (layer ? 1 : 3);
        const double p[3] = {turned ? x[0] + side : end, turned ? end : x[1] + side, 0.6 * layer};
        if (!layer || lower >= 0) yard_touch(y, now[k], lower, p, up);
      }
    }
  }
}

/* Slabs that lean on each other in a row, each on one edge; the last one on both. */
static void put_dominoes(yard *y, int count) {
  const double high = 1, thick = 0.15;
  for (int b = 0; b < count; b++) {
    const double lean = 0.25 + 0.3 * b / count, m = 1 + 0.05 * bench_draw(&y->state);
    const double I = m * (high * high + thick * thick) / 12, x[3] = {0.5 * b, 0.5, 0};
    const double v[3] = {0, -0.1, -0.025 * (1 + bench_draw(&y->state))}, up[3] = {0, 1, 0};
    const int now = yard_body(y, x, m, &I, v);
    const double e[2] = {sin(lean), cos(lean)}; /* along the slab, upwards */
    for (int edge = 0; edge < (b == count - 1 ? 2 : 1); edge++) {
      const double across = edge ? -thick / 2 : thick / 2;
      const double foot[3] = {x[0] + across * e[1] - e[0] / 2, x[1] - across * e[0] - e[1] / 2, 0};
      yard_touch(y, now, -1, foot, up);
    }
    if (b == 0) continue;
    const double to_last[3] = {-cos(lean + 0.02), sin(lean + 0.02), 0};
    const double top[3] = {x[0] - thick / 2 * e[1] + 0.3 * e[0], x[1] + 0.3 * e[1], 0};
    yard_touch(y, now - 1, now, top, to_last);
  }
}

int regret_bodies(regret_problem *a, const char *kind, int size, double mu, uint64_t seed) {
  yard y = {.mu = mu, .state = regret_state(seed, 3)};
  int bad = -1;
  if (strcmp(kind, "gears") == 0) {
    const int side = (int)fmax(2, round(sqrt(size / 6.) + 0.5));
    bad = yard_open(&y, a, 2, side * side, 6 * side * side);
    if (!bad) put_gears(&y, side);
  } else if (strcmp(kind, "dome") == 0) {
    const int rings = (int)fmax(2, sqrt(size / 32.)), stones = (int)fmax(3, size / (8. * rings));
    bad = yard_open(&y, a, 3, rings * stones, 8 * rings * stones);
    if (!bad) put_dome(&y, rings, stones);
  } else if (strncmp(kind, "pyramid", 7) == 0) {
    const int side = (int)fmax(1, round(cbrt(size / 4.) + 0.2));
    bad = yard_open(&y, a, 3, side * side * side, 12 * side * side * side);
    if (!bad) put_pyramid(&y, side, kind[7] ? 0.5 : 0.05);
  } else if (strcmp(kind, "wedges") == 0) {
    const int count = size / 3 > 2 ? size / 3 : 2;
    bad = yard_open(&y, a, 2, count, 4 * count + 4);
    if (!bad) put_wedges(&y, count);
  } else if (strcmp(kind, "train") == 0) {
    const int count = size / 4 + 2;
    bad = yard_open(&y, a, 2, count, 4 * count);
    if (!bad) put_train(&y, count);
  } else if (strcmp(kind, "books") == 0) {
    const int count = size / 4 + 1;
    bad = yard_open(&y, a, 3, count, 4 * count + 4);
    if (!bad) put_books(&y, count);
  } else if (strcmp(kind, "logs") == 0) {
    const int wide = (int)sqrt(size / 2.) + 2;
    bad = yard_open(&y, a, 2, wide * wide, 2 * wide * wide + 2 * wide);
    if (!bad) put_logs(&y, wide);
  } else if (strncmp(kind, "beams", 5) == 0) {
    const int layers = size / 33 + 2;
    bad = yard_open(&y, a, 3, 3 * layers, 36 * layers);
    if (!bad) put_beams(&y, layers, kind[5] ? 0.02 : 0);
  } else if (strcmp(kind, "dominoes") == 0) {
    const int count = size / 2 + 1;
    bad = yard_open(&y, a, 2, count, 2 * count + 1);
    if (!bad) put_dominoes(&y, count);
  }
  return yard_close(&y) || bad ? -1 : 0;
}
