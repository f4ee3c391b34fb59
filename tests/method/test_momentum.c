/* test_momentum.c: momentum on sweeps, one step after the other by hand. */
#include "cases.h"
#include "run.h"
#include "vi/vi_internal.h"

static const dlsi_set one = {.count = 1};

/* A momentum of one candidate, d = e. */
typedef struct small {
  dlsi_momentum mo;
  double of[4][3];
} small;

static void small_start(small *s, int d, const double *r, const double *u) {
  *s = (small){.of = {{0}}};
  s->mo.r = s->of[0];
  s->mo.u = s->of[1];
  s->mo.p = s->of[2];
  s->mo.pu = s->of[3];
  for (int i = 0; i < d; i++)
    s->mo.p[i] = s->mo.pu[i] = NAN; /* start sets them */
  dlsi_momentum_start(&s->mo, d, d, one, one, r, u);
}

/* (MO1), (MO4): no step before, then b = 1 / 12, then the largest that is allowed, then 0; G = w
 * |e|^2 with w = 2. */
TEST(steps_by_hand) {
  const double w = 2;
  double r = 3, u = 5;
  small s;
  small_start(&s, 1, &r, &u);
  r = 15, u = 29; /* p = 12, p_u = 24 */
  ck_assert(dlsi_momentum_step(&s.mo, 1, 1, &w, 1, one, one, &r, &u) == 2 * 144);
  ck_assert(r == 15 && u == 29 && s.mo.k == 1 && s.mo.reference == 288);
  r = 21, u = 41; /* 6 and 12 from the sweep, 1 and 2 more */
  ck_assert(dlsi_momentum_step(&s.mo, 1, 1, &w, 1, one, one, &r, &u) == 2 * 36);
  ck_assert(r == 22 && u == 43 && s.mo.k == 2 && s.mo.reference == 72);
  r = 24, u = 47; /* p = 7, p_u = 14 */
  ck_assert(dlsi_momentum_step(&s.mo, 1, 1, &w, .125, one, one, &r, &u) == 2 * 4);
  ck_assert(r == 24.875 && u == 48.75 && s.mo.k == 3 && s.mo.reference == 8);
  r = 24.375, u = 47; /* e = .5 along p = 2.875: uphill */
  ck_assert(dlsi_momentum_step(&s.mo, 1, 1, &w, .125, one, one, &r, &u) == .5);
  ck_assert(r == 24.375 && u == 47 && s.mo.k == 0 && s.mo.reference == .5);
  ck_assert(s.mo.p[0] == -.5 && s.mo.pu[0] == -1.75 && s.mo.r[0] == 24.375 && s.mo.u[0] == 47);
  r = 23.75; /* k = 1: b = 0, and G* becomes a larger G */
  ck_assert(dlsi_momentum_step(&s.mo, 1, 1, &w, .125, one, one, &r, &u) == .78125);
  ck_assert(r == 23.75 && s.mo.k == 1 && s.mo.reference == .78125);
}

/* (MO2), (MO3): e across p is not uphill; G = 2 G* does not begin anew and leaves G*, more does. */
TEST(growth_begins_anew) {
  const double w = 1, start[2] = {0, 0};
  for (int more = 0; more < 2; more++) {
    double r[2] = {8, 0}, u[2] = {0, 0};
    small s;
    small_start(&s, 2, start, start);
    ck_assert(dlsi_momentum_step(&s.mo, 2, 2, &w, .0625, one, one, r, u) == 64);
    r[1] = 8;
    ck_assert(dlsi_momentum_step(&s.mo, 2, 2, &w, .0625, one, one, r, u) == 64);
    ck_assert(r[0] == 8.5 && r[1] == 8 && s.mo.k == 2 && s.mo.reference == 64);
    r[0] = 16.5; /* e = (-8, -8), or (-8, -10); p = (.5, 8) */
    r[1] = more ? 18 : 16;
    const double G = dlsi_momentum_step(&s.mo, 2, 2, &w, .0625, one, one, r, u);
    ck_assert(G == (more ? 164 : 128) && s.mo.k == (more ? 0 : 3));
    ck_assert(r[0] == (more ? 16.5 : 16.53125) && r[1] == (more ? 18 : 16.5));
    ck_assert(s.mo.reference == (more ? 164 : 64));
  }
}

/* Two of three candidates, and one of two bodies: the others stay, NaN as they are. */
TEST(only_the_set_moves) {
  static const int some[2] = {2, 0}, row[1] = {1};
  const dlsi_set changes = {.list = some, .count = 2}, rows = {.list = row, .count = 1};
  const double w[3] = {1, NAN, 4};
  double r[6] = {1, 2, NAN, NAN, 3, 4}, u[6] = {NAN, NAN, NAN, 5, 6, 7};
  double of[4][6];
  for (int k = 0; k < 4; k++)
    for (int i = 0; i < 6; i++)
      of[k][i] = 99;
  dlsi_momentum mo = {.r = of[0], .u = of[1], .p = of[2], .pu = of[3]};
  dlsi_momentum_start(&mo, 2, 3, changes, rows, r, u);
  for (int step = 1; step <= 2; step++) {
    const double b = step == 1 ? 0 : .0625;
    for (int k = 0; k < 2; k++)
      for (int i = 0; i < 2; i++)
        r[2 * some[k] + i] += 16 * (2 * k + i + 1);
    for (int i = 3; i < 6; i++)
      u[i] += 16 * i;
    /* candidate 2: 16, 32; candidate 0: 48, 64 */
    ck_assert(dlsi_momentum_step(&mo, 2, 3, w, b, changes, rows, r, u) ==
              4 * (256 + 1024) + 2304 + 4096);
    ck_assert(mo.k == step);
  }
  static const double expected[6] = {1 + 99, 2 + 132, 0, 0, 3 + 33, 4 + 66};
  for (int i = 0; i < 6; i++)
    if (i == 2 || i == 3)
      ck_assert(isnan(r[i]) && of[0][i] == 99 && of[2][i] == 99);
    else
      ck_assert(r[i] == expected[i] && of[0][i] == r[i]);
  for (int i = 0; i < 6; i++)
    if (i < 3)
      ck_assert(isnan(u[i]) && of[1][i] == 99 && of[3][i] == 99);
    else
      ck_assert(u[i] == i + 2 + 33 * i && of[1][i] == u[i] && of[3][i] == 17 * i);
}

/* Work on pieces: the same r and u to the bit each time, and as a list of all, last first, the same
 * G but for rounding. */
TEST(pieces_are_the_whole) {
  enum { count = 5000, d = 3, e = 2 };
  static double v[3][2][d * count], of[3][4][d * count], w[count], start[d * count];
  static int list[count];
  set_seed(5);
  for (int c = 0; c < count; c++) {
    list[c] = count - 1 - c;
    w[c] = 2 + uniform();
  }
  dlsi_momentum mo[3];
  double G[3];
  const dlsi_set all = {.count = count}, backwards = {.list = list, .count = count};
  ck_assert_int_gt(dlsi_pieces(count), 1);
  for (int k = 0; k < 3; k++) {
    mo[k] = (dlsi_momentum){.r = of[k][0], .u = of[k][1], .p = of[k][2], .pu = of[k][3]};
    const dlsi_set set = k == 2 ? backwards : all;
    dlsi_momentum_start(&mo[k], d, e, set, set, start, start);
    set_seed(6);
    for (int step = 0; step < 3; step++) {
      for (int i = 0; i < d * count; i++)
        v[k][0][i] += 2 + uniform(); /* downhill */
      for (int i = 0; i < e * count; i++)
        v[k][1][i] += uniform();
      G[k] = dlsi_momentum_step(&mo[k], d, e, w, 1, set, set, v[k][0], v[k][1]);
    }
    ck_assert_int_eq(mo[k].k, 3);
    ck_assert_mem_eq(v[k], v[0], sizeof v[0]);
    ck_assert_double_eq_tol(G[k], G[0], 1e-14 * count * G[0]);
  }
}
