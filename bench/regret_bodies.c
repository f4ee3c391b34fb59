/* regret_bodies.c: machines and stacks of rigid bodies, from gears to dominoes. */
#include <math.h>
#include <string.h>

#include "regret_kinds.h"

static const double pi = 3.14159265358979;

/* Wheels of radius 1 in a square grid. The axle lends each wheel 50 times its mass. */
static void put_gears(heap *h, int size) {
  const int side = (int)fmax(2, round(sqrt(size / 6.) + 0.5));
  const double pressure = 0.349;
  for (int b = 0; b < side * side; b++) {
    const double m = 1.5 + 0.5 * heap_random(h), I = 0.5 * m;
    const double turn = ((b % side + b / side) % 2 ? -1 : 1) * (0.75 + 0.25 * heap_random(h));
    const double x[3] = {2. * (b % side), 2. * (b / side), 0};
    const double v[3] = {0.03 * heap_random(h), 0, turn};
    (void)heap_body(h, x, 50 * m, &I, v);
  }
  for (int a = 0; a < side * side; a++)
    for (int up = 0; up < 2; up++) {
      if ((up ? a / side : a % side) == side - 1) continue;
      const int b = up ? a + side : a + 1;
      const double e[2] = {!up, up}, *x = h->body[a].x;
      for (int flank = 0; flank < 3; flank++) {
        const double s = flank < 2 ? 1 : -1, off = flank == 0 ? -0.05 : flank == 1 ? 0.05 : 0.02;
        const double n[3] = {-s * cos(pressure) * e[1] - sin(pressure) * e[0],
                             s * cos(pressure) * e[0] - sin(pressure) * e[1], 0};
        const double at[3] = {x[0] + (1 + off) * e[0] - off * s * e[1],
                              x[1] + (1 + off) * e[1] + off * s * e[0], 0};
        heap_contact(h, a, b, at, n);
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
static void put_dome(heap *h, int size) {
  const int rings = (int)fmax(2, sqrt(size / 32.)), stones = (int)fmax(3, size / (8. * rings));
  const double inner = 1, outer = 1.12, middle = 1.06, wide = 2 * pi / stones, high = 1.25 / rings;
  for (int b = 0; b < rings * stones; b++) {
    const int ring = b / stones;
    const double e = high * (ring + 0.5), z = wide * (b % stones + 0.5 * (ring % 2));
    const double tall = middle * high, w = middle * wide * cos(e), t = outer - inner,
                 m = tall * w * t;
    const double I = m * (tall * tall + w * w + t * t) / 18, inertia[3] = {I, I, I};
    double x[3], v[6] = {0.05, 0, -1};
    on_sphere(middle, e, z, x);
    for (int l = 0; l < 6; l++)
      v[l] += 0.003 * heap_random(h);
    (void)heap_body(h, x, m, inertia, v);
  }
  for (int b = 0; b < rings * stones; b++) {
    const int ring = b / stones, stone = b % stones, beside = ring * stones + (stone + 1) % stones;
    const double z = wide * (stone + 0.5 * (ring % 2)), low = high * ring;
    double x[3];
    for (int k = 0; k < 4; k++) {
      const double across[3] = {sin(z + wide / 2), -cos(z + wide / 2), 0};
      on_sphere(k & 2 ? outer : inner, k & 1 ? low + high : low, z + wide / 2, x);
      heap_contact(h, b, beside, x, across);
    }
    for (int k = 0; k < 4; k++) {
      const double to = z + (k & 1 ? 0.45 : -0.45) * wide;
      const double up[3] = {-sin(low) * cos(to), -sin(low) * sin(to), cos(low)};
      /* The one below on this half: half bond moves even rings by one. */
      const int left = stone - (ring % 2 == 0), half = left + (k & 1);
      on_sphere(k & 2 ? outer : inner, low, to, x);
      heap_contact(h, b, ring ? (ring - 1) * stones + (half + stones) % stones : -1, x, up);
    }
  }
}

/* Layers of crates of side 1: `side`^2, (side-1)^2, .., each on four, moved along at the top. */
static void put_pyramid(heap *h, int size) {
  const int side = (int)fmax(1, round(cbrt(size / 4.) + 0.2));
  static const double up[3] = {0, 0, 1};
  int first = 0, below = 0;
  for (int layer = 0; layer < side; layer++) {
    const int wide = side - layer;
    for (int k = 0; k < wide * wide; k++) {
      const double m = 1 + 0.5 * heap_random(h), inertia[3] = {m / 6, m / 6, m / 6};
      const double x[3] = {k % wide + 0.5 * layer, k / wide + 0.5 * layer, layer + 0.5};
      const double v[6] = {h->push * (layer + 1.) / side, 0, -1};
      const int b = heap_body(h, x, m, inertia, v);
      for (int at = 0; at < (layer ? 12 : 4); at++) {
        const int right = at & 1, back = at >> 1 & 1;
        const double ax = layer ? 0.27 + 0.22 * heap_random(h) : 0.49;
        const double ay = layer ? 0.27 + 0.22 * heap_random(h) : 0.49;
        const double p[3] = {x[0] + (right ? ax : -ax), x[1] + (back ? ay : -ay), layer};
        const int lower = below + k % wide + right + (wide + 1) * (k / wide + back);
        heap_contact(h, b, layer ? lower : -1, p, up);
      }
    }
    below = first;
    first = h->bodies;
  }
}

/* A row of blocks between two walls. Every second is a keystone that is driven in from above; the
 * others stand on the floor. Each face has two contacts. */
static void put_wedges(heap *h, int size) {
  const int count = size / 3 > 2 ? size / 3 : 2;
  const double slope = 0.15;
  for (int b = 0; b < count; b++) {
    const double m = 1 + 0.3 * heap_random(h), I = m / 6, x[3] = {b, 0, 0};
    const double v[3] = {0.1 * heap_random(h), b % 2 ? -1 : -0.1, 0};
    (void)heap_body(h, x, m, &I, v);
  }
  for (int face = 0; face <= count; face++)
    for (int end = -1; end <= 1; end += 2) {
      const int left = face - 1, right = face < count ? face : -1;
      /* Faces of a keystone open upwards; the normal points to the body that is named first. */
      const double lean = (left < 0 || right < 0) ? 0 : (right % 2 ? 1 : -1) * slope;
      const double x[3] = {face - 0.5 - lean * 0.4 * end, 0.4 * end, 0};
      const double to_right[3] = {cos(lean), sin(lean), 0}, to_left[3] = {-1, 0, 0};
      if (right < 0)
        heap_contact(h, left, -1, x, to_left);
      else
        heap_contact(h, right, left, x, to_right);
    }
  for (int b = 0; b < count; b += 2)
    for (int end = -1; end <= 1; end += 2) {
      const double x[3] = {b + 0.4 * end, -0.5, 0}, up[3] = {0, 1, 0};
      heap_contact(h, b, -1, x, up);
    }
}

/* A row of gears on heavy axles, driven at both ends. Four flanks touch where two gears meet. */
static void put_train(heap *h, int size) {
  const int count = size / 4 + 2;
  const double pressure = 0.349;
  for (int b = 0; b < count; b++) {
    const double m = 1.5 + 0.5 * heap_random(h), I = 0.5 * m, x[3] = {2. * b, 0, 0};
    const double driven = b == 0 ? 1 : b == count - 1 ? 0.6 : 0.15 * heap_random(h);
    const double v[3] = {0, 0, b % 2 ? -driven : driven};
    (void)heap_body(h, x, 80 * m, &I, v);
  }
  for (int b = 0; b + 1 < count; b++)
    for (int flank = 0; flank < 4; flank++) {
      const double side = flank < 2 ? 1 : -1, off = flank % 2 ? 0.04 : -0.05;
      const double n[3] = {-sin(pressure), side * cos(pressure), 0};
      const double at[3] = {2. * b + 1 + off, off * side, 0};
      heap_contact(h, b, b + 1, at, n);
    }
}

/* A row of books that two hands press together and lift: four corners touch between neighbours. */
static void put_books(heap *h, int size) {
  const int count = size / 4 + 1;
  const double thick = 0.03, deep = 0.18, high = 0.25;
  for (int b = 0; b < count; b++) {
    const double m = 1 + 0.5 * heap_random(h), x[3] = {thick * b, 0, 0};
    const double inertia[3] = {m * (high * high + deep * deep) / 12,
                               m * (high * high + thick * thick) / 12,
                               m * (deep * deep + thick * thick) / 12};
    const double v[6] = {b == 0 ? 1 : b == count - 1 ? -1 : 0, 0, -0.1};
    (void)heap_body(h, x, m, inertia, v);
  }
  for (int face = 0; face <= count; face++)
    for (int corner = 0; corner < 4; corner++) {
      const double n[3] = {face < count ? 1 : -1, 0, 0};
      const double at[3] = {thick * (face - 0.5), corner & 1 ? deep / 2 : -deep / 2,
                            corner & 2 ? high / 2 : -high / 2};
      heap_contact(h, face < count ? face : count - 1, face < count ? face - 1 : -1, at, n);
    }
}

/* Logs across, stacked in rows of `wide` and wide - 1 between two posts. */
static void put_logs(heap *h, int size) {
  const int wide = (int)sqrt(size / 2.) + 2;
  int below = -1, first = 0;
  for (int row = 0; row < wide; row++, below = first, first = h->bodies) {
    const int odd = row % 2, logs = wide - odd;
    for (int k = 0; k < logs; k++) {
      const double m = 1.15 + 0.15 * heap_random(h), I = m / 8;
      const double x[3] = {k + 0.5 * odd, 0.866 * row, 0};
      const double v[3] = {0.003 * heap_random(h), -0.1 + 0.003 * heap_random(h),
                           0.003 * heap_random(h)};
      const int b = heap_body(h, x, m, &I, v);
      for (int side = 0; side < 2; side++) {
        const int lower = k + side - !odd, end = side ? logs - 1 : 0;
        const double lean = row ? 1.047 + 0.01 * heap_random(h) : pi / 2;
        const double n[3] = {(side ? -1 : 1) * cos(lean), sin(lean), 0};
        const double at[3] = {x[0] - 0.5 * n[0], x[1] - 0.5 * n[1], 0};
        const double post[3] = {side ? -1 : 1, 0, 0};
        const double wall[3] = {x[0] + (side ? 0.5 : -0.5), x[1], 0};
        if (row ? lower >= 0 && lower < wide - !odd : !side)
          heap_contact(h, b, row ? below + lower : -1, at, n);
        if (!odd && k == end) heap_contact(h, b, -1, wall, post);
      }
    }
  }
}

/* Layers of three beams 3 x 1 x .6, each across those below, some of them missing. Two beams touch
 * in four points. */
static void put_beams(heap *h, int size) {
  const int layers = size / 33 + 2;
  static const double up[3] = {0, 0, 1};
  int below[3] = {-1, -1, -1}, now[3];
  for (int layer = 0; layer < layers; layer++, memcpy(below, now, sizeof below)) {
    const int turned = layer % 2;
    for (int k = 0; k < 3; k++) {
      const double m = 1 + 0.02 * heap_random(h),
                   x[3] = {turned ? k - 1. : 0, turned ? 0 : k - 1., 0.6 * layer + 0.3};
      const double inertia[3] = {m * (turned ? 9.36 : 1.36) / 12, m * (turned ? 1.36 : 9.36) / 12,
                                 m * 10 / 12};
      const double v[6] = {h->push + 3e-4 * heap_random(h), 0, -0.1};
      const int inside = layer && layer < layers - 1;
      now[k] = inside && heap_random(h) < -0.8 ? -1 : heap_body(h, x, m, inertia, v);
      for (int at = 0; now[k] >= 0 && at < (layer ? 12 : 4); at++) {
        const int lower = layer ? below[at / 4] : -1;
        const double beside = layer ? at / 4 - 1. : 0, side = (at & 1 ? 0.45 : -0.45),
                     end = beside + (at & 2 ? 0.45 : -0.45) * (layer ? 1 : 3);
        const double p[3] = {turned ? x[0] + side : end, turned ? end : x[1] + side, 0.6 * layer};
        if (!layer || lower >= 0) heap_contact(h, now[k], lower, p, up);
      }
    }
  }
}

/* Slabs that lean on each other in a row, each on one edge; the last one on both. */
static void put_dominoes(heap *h, int size) {
  const int count = size / 2 + 1;
  const double high = 1, thick = 0.15;
  for (int b = 0; b < count; b++) {
    const double lean = 0.25 + 0.3 * b / count, m = 1 + 0.05 * heap_random(h);
    const double I = m * (high * high + thick * thick) / 12, x[3] = {0.5 * b, 0.5, 0};
    const double v[3] = {0, -0.1, -0.025 * (1 + heap_random(h))}, up[3] = {0, 1, 0};
    const int now = heap_body(h, x, m, &I, v);
    const double e[2] = {sin(lean), cos(lean)}; /* along the slab, upwards */
    for (int edge = 0; edge < (b == count - 1 ? 2 : 1); edge++) {
      const double across = edge ? -thick / 2 : thick / 2;
      const double foot[3] = {x[0] + across * e[1] - e[0] / 2, x[1] - across * e[0] - e[1] / 2, 0};
      heap_contact(h, now, -1, foot, up);
    }
    if (b == 0) continue;
    const double to_last[3] = {-cos(lean + 0.02), sin(lean + 0.02), 0};
    const double top[3] = {x[0] - thick / 2 * e[1] + 0.3 * e[0], x[1] + 0.3 * e[1], 0};
    heap_contact(h, now - 1, now, top, to_last);
  }
}

static const struct {
  const char *kind;
  int d;
  void (*put)(heap *h, int size);
  double push;
} kinds[] = {{"gears", 2, put_gears, 0},        {"dome", 3, put_dome, 0},
             {"pyramid", 3, put_pyramid, 0.05}, {"pyramid-pushed", 3, put_pyramid, 0.5},
             {"wedges", 2, put_wedges, 0},      {"train", 2, put_train, 0},
             {"books", 3, put_books, 0},        {"logs", 2, put_logs, 0},
             {"beams", 3, put_beams, 0},        {"beams-pushed", 3, put_beams, 0.02},
             {"dominoes", 2, put_dominoes, 0}};

int regret_bodies(regret_problem *a, const char *kind, int size, double mu, uint64_t seed) {
  size_t k = 0;
  while (k < sizeof kinds / sizeof kinds[0] && strcmp(kind, kinds[k].kind) != 0)
    k++;
  if (k == sizeof kinds / sizeof kinds[0]) return -1;
  heap h = {.d = kinds[k].d, .push = kinds[k].push, .state = regret_state(seed, 3)};
  kinds[k].put(&h, size);
  if (rigid_close(&a->bodies, &h, mu)) return -1;
  a->contact = a->bodies.contact;
  return 0;
}
