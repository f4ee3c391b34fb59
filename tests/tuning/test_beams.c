/*
 * test_beams.c: accelerated sweeps on 640 cantilevers of 40 contacts, against recorded counts.
 *
 *   build/tests/tuning/test_beams print
 *
 * writes a table: for each height of the beam and each acceleration how many are solved to 1e-8 in
 * 10000 sweeps, and the geometric mean of the sweeps; in the last column those of auto.
 *
 * A beam: nx x ny squares, clamped at its left end, above the ground; each node of the lower side
 * except the clamped one is a contact.
 */
#include "delassus.h"
#include "made.h"
#include "reduced.h"
#include "run.h"
#include "solids.h"

enum { nx = 40, heights = 5, kinds = 8, pushes = 4, frictions = 4, ways = 4 };

static const int height[heights] = {1, 2, 4, 8, 20};
static const double push[pushes] = {-.5, .1, .5, 1}, friction[frictions] = {.1, .3, .6, 1};

/* Loads on the upper nodes; a push acts on all of them, or at the free end. */
typedef struct beam_kind {
  int first;       /* upper node from which on each is pressed by 1e-3; nx + 1: none */
  double point[3]; /* downwards at the upper nodes 13, 20, 40 */
  double gap;      /* times ny */
  int at_end;      /* 1: the push acts at the free end */
} beam_kind;

static const beam_kind kind[kinds] = {
    {0, {0, 0, 0}, 0, 0},          {nx / 2, {0, 0, 0}, 0, 0},
    {3 * nx / 4, {0, 0, 0}, 0, 0}, {0, {0, 0, 0}, 0, 1},
    {nx + 1, {0, 0, 4e-2}, 0, 1},  {nx + 1, {0, 0, 4e-2}, .05, 1},
    {nx + 1, {0, 4e-2, 0}, 0, 1},  {nx + 1, {2e-2, -1e-2, 2e-2}, 0, 0}};

static dls_reduction *beam_create(const beam_kind *k, int ny, double pushed) {
  static const int at[] = {13, 20, 40};
  const int up = (nx + 1) * ny;
  solids S;
  dls_reduction *R;
  solids_new(&S, 2, (nx + 1) * (ny + 1), nx);
  solids_block(&S, (int[]){nx, ny, 1}, 1);
  for (int i = 0; i < 2 * (ny + 1); i++)
    solids_spring(&S, (nx + 1) * (i / 2), i % 2, 1e3);
  for (int i = 0; i <= nx; i++) {
    S.f[2 * (i + up)] = k->at_end ? 0 : 1e-3 * pushed;
    S.f[2 * (i + up) + 1] = i >= k->first ? -1e-3 : 0;
  }
  for (int i = 0; i < 3; i++)
    S.f[2 * (at[i] + up) + 1] -= k->point[i];
  for (int j = 0; j <= ny; j++)
    S.f[2 * (nx + (nx + 1) * j)] += k->at_end ? 4e-2 * pushed / (ny + 1) : 0;
  for (int i = 1; i <= nx; i++)
    solids_contact(&S, i, -1, (double[]){0, 1}, k->gap * ny);
  ck_assert_int_eq(reduce_on_W(&R, solids_model(&S), NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(R, S.f, S.g, NULL), DLS_OK);
  solids_free(&S);
  return R;
}

/* Solves all beams of a height. way: an acceleration of nlgs, or ways - 1 for auto. Returns how
 * many are solved; *mean: of the iterations. */
static int beams_solve(int ny, int way, double *mean) {
  int solved = 0;
  double sum = 0, r[2 * nx], mu[nx];
  dls_solver_settings s = settings_with(DLS_AUTO, default_tol);
  if (way < ways - 1) {
    s.method = DLS_NLGS;
    s.acceleration = (dls_acceleration)way;
  }
  for (int k = 0; k < kinds * pushes; k++) {
    dls_reduction *R = beam_create(&kind[k / pushes], ny, push[k % pushes]);
    for (int f = 0; f < frictions; f++) {
      dls_contact p;
      dls_info info;
      for (int c = 0; c < nx; c++)
        mu[c] = friction[f];
      ck_assert_int_eq(dls_reduction_contact(R, mu, &p, NULL), DLS_OK);
      const dls_status status = dls_solve(&p, &s, r, NULL, &info, NULL);
      ck_assert_int_ge(status, 0);
      solved += status == DLS_OK;
      sum += log(info.iterations + 1);
    }
    dls_reduction_destroy(R);
  }
  *mean = exp(sum / (kinds * pushes * frictions)) - 1;
  return solved;
}

static int printing;

/* Anderson's acceleration solves more beams than Aitken's, and takes fewer sweeps. */
TEST_EACH(anderson_is_ahead, 0, heights) {
  double aitken, anderson;
  if (!WITH_MUMPS) return;
  const int fewer = beams_solve(height[_i], DLS_ACCELERATION_AITKEN, &aitken);
  ck_assert_int_ge(beams_solve(height[_i], DLS_ACCELERATION_ANDERSON, &anderson), fewer);
  ck_assert_double_lt(anderson, aitken);
}

TEST(print_table) {
  if (!printing) return;
  printf("height, none, aitken, anderson, auto: solved of %d, mean\n", kinds * pushes * frictions);
  for (int h = 0; h < heights; h++) {
    printf("%2d", height[h]);
    for (int way = 0; way < ways; way++) {
      double mean;
      const int solved = beams_solve(height[h], way, &mean);
      printf("  %3d %4.0f", solved, mean);
    }
    printf("\n");
  }
}

int main(int argc, char **argv) {
  printing = argc > 1 && strcmp(argv[1], "print") == 0;
  return run_tests("beams", NULL, NULL);
}
