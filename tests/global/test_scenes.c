/* test_scenes.c: free bodies with random contacts in 2D and 3D, with known statics. A scene that
 * stands is solved; one that falls is never "solved", and is proved to fall; no other proofs.
 * build/tests/global/test_scenes runs a fixed number of seeds. */
#include "delassus/global.h"
#include "run.h"
#include "scenes.h"

enum { scenes = 100 };

/* Returns the largest |K x - f - H r|_j over the largest |f|. */
static double imbalance(const solids *S, const double *x, const double *r) {
  const int n = S->model.n, d = S->d;
  double *e = calloc((size_t)n, sizeof *e), most = 0, size = 0;
  for (int j = 0; j < n; j++) {
    e[j] -= S->f[j];
    size = fmax(size, fabs(S->f[j]));
    for (int k = S->Kc.p[j]; k < S->Kc.p[j + 1]; k++) {
      e[S->Kc.i[k]] += S->Kc.x[k] * x[j];
      if (S->Kc.i[k] != j) e[j] += S->Kc.x[k] * x[S->Kc.i[k]];
    }
  }
  for (int c = 0; c < S->contacts; c++)
    for (int i = 0; i < d; i++) {
      const dlsi_columns *L = i ? &S->Tc : &S->Nc;
      const int column = i ? (d - 1) * c + i - 1 : c;
      for (int k = L->p[column]; k < L->p[column + 1]; k++)
        e[L->i[k]] -= L->x[k] * r[d * c + i];
    }
  for (int j = 0; j < n; j++)
    most = fmax(most, fabs(e[j]));
  free(e);
  return most / size;
}

/* Solves a scene and checks the answer; returns the status. */
static dls_status solve_scene(uint64_t seed, int d, scene_kind kind) {
  solids S;
  dls_global *G;
  dls_info info;
  double same;
  const dls_limits limits = {.tol = 1e-10};
  scene_generate(seed, d, kind, &S, &same);
  const size_t nc = (size_t)S.contacts;
  double *r = calloc((size_t)d * nc, sizeof *r), *x = calloc((size_t)S.model.n, sizeof *x);
  double *mu = calloc(nc, sizeof *mu);
  for (size_t c = 0; c < nc; c++)
    mu[c] = same;
  ck_assert(!dls_global_create(&G, &S.model, NULL));
  const dls_status status = dls_global_solve(G, S.f, S.g, mu, &limits, r, x, &info, NULL);
  if (kind == SCENE_STANDS)
    ck_assert_msg(status == DLS_OK || status == DLS_TO_ROUNDING, "seed %d: %s", (int)seed,
                  dls_status_name(status));
  else
    ck_assert_msg(status > DLS_OK && status != DLS_TO_ROUNDING, "seed %d: %s", (int)seed,
                  dls_status_name(status));
  if (status == DLS_OK) ck_assert_double_lt(imbalance(&S, x, r), 1e-8);
  double force = 0;
  for (size_t k = 0; k < (size_t)d * nc; k++)
    force = fmax(force, fabs(r[k]));
  for (size_t c = 0; status == DLS_OK && c < nc; c++) {
    const double *t = r + (size_t)d * c, size = d == 3 ? hypot(t[1], t[2]) : fabs(t[1]);
    ck_assert_msg(t[0] >= -1e-9 * force && size <= same * t[0] + 1e-9 * force, "%g %g", t[0], size);
  }
  dls_global_destroy(G);
  free(r);
  free(x);
  free(mu);
  solids_free(&S);
  return status;
}

TEST_EACH(stand, 0, 2) {
  for (uint64_t seed = 0; seed < scenes; seed++)
    (void)solve_scene(seed, 2 + _i, SCENE_STANDS);
}

/* In 3D 6 in 400 are not proved (seeds 1, 3, .. 799). */
TEST_EACH(fall, 0, 2) {
  int proved = 0;
  for (uint64_t seed = 0; seed < scenes; seed++)
    proved += solve_scene(seed, 2 + _i, SCENE_FALLS) == DLS_NO_SOLUTION;
  ck_assert_int_ge(proved, _i ? scenes - 5 : scenes);
}
