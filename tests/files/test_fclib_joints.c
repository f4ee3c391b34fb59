/* test_fclib_joints.c: joints in FCLIB files: G, b and l of a global problem. */
#include <unistd.h>

#include "delassus.h"
#include "files/fclib_joints.h"
#include "linkage.h"
#include "reduced.h"
#include "run.h"

#if WITH_HDF5

static char path[100];
static linkage L;

static void named(void) {
  (void)snprintf(path, sizeof path, "/tmp/delassus_joints_%ld.hdf5", (long)getpid());
}

static void remove_file(void) {
  (void)remove(path);
  linkage_free(&L);
}

/* A bar that hangs by a pin, given twice, and lies with its end on the ground. */
static const dls_model *hanging(dls_factorization factorization, int is_sparse) {
  const double end[2] = {.5, 0}, pin[2] = {-.5, 0};
  linkage_new(&L, 2);
  (void)linkage_body(&L, 1, 1. / 12, 4);
  linkage_pin(&L, 0, pin, -1, pin);
  linkage_pin(&L, 0, pin, -1, pin);
  linkage_contact(&L, 0, end);
  return linkage_model(&L, factorization, is_sparse);
}

static const double w[2] = {0, 0}, mu[1] = {.5};

static dls_status write_hanging(const dls_model *model, const double *x, const double *r) {
  return dls_fclib_write_global(path, model, L.f, w, mu, "hanging", x, r, r, NULL);
}

static void hang(const dls_model *model, const double *f, double *r, double *x) {
  dls_reduction *reduction;
  dls_info info;
  ck_assert(!reduce_on_W(&reduction, model, NULL, NULL));
  ck_assert(!dls_reduction_load(reduction, f, w, NULL));
  ck_assert(!dls_reduction_solve(reduction, mu, NULL, r, NULL, x, &info, NULL));
  dls_reduction_destroy(reduction);
}

/* Half the weight stands on the ground, half hangs on the pins, whichever of them carries it. */
TEST_EACH(round_trip, 0, 4) {
  const dls_model *model = hanging(_i & 1 ? DLS_LU : DLS_LDLT, _i & 2);
  double r[2], x[7], again[2], y[7];
  hang(model, L.f, r, x);
  ck_assert_double_eq_tol(r[0], 2, 1e-12);
  ck_assert_double_eq_tol(x[4] + x[6], -2, 1e-12);
  ck_assert_int_eq(write_hanging(model, x, r), DLS_OK);
  dls_fclib *file;
  dls_model back;
  dls_contact bodies;
  const double *f, *g, *friction;
  ck_assert(!dls_fclib_read(&file, path, NULL));
  ck_assert(!dls_fclib_model(file, &back, &f, &g, &friction, NULL));
  ck_assert_int_eq(dls_fclib_bodies(file, &bodies, NULL), DLS_E_UNSUPPORTED);
  ck_assert(back.n == 7 && back.nodes == 1 && back.factorization == DLS_LU);
  for (int k = 0; k < 7; k++)
    ck_assert(f[k] == L.f[k]);
  for (int j = 0; j < 7; j++) {
    double column[7] = {0};
    for (int k = back.Ks.p[j]; k < back.Ks.p[j + 1]; k++)
      column[back.Ks.i[k]] += back.Ks.x[k];
    for (int i = 0; i < 7; i++) {
      const double here = L.dense[i + 7 * j] != 0 ? L.dense[i + 7 * j] : L.dense[j + 7 * i];
      ck_assert(column[i] == here);
    }
  }
  hang(&back, f, again, y);
  ck_assert_double_eq_tol(again[0], 2, 1e-12);
  ck_assert_double_eq_tol(y[4] + y[6], -2, 1e-12);
  dls_fclib_destroy(file);
}

/* A K with a diagonal among the multipliers is no M and G, nor is one that is unsymmetric there. */
TEST_EACH(written_whole, 0, 2) {
  (void)hanging(DLS_LU, 1);
  if (_i)
    dlsi_triplets_add(&L.K, 3, 3, -1e-3);
  else
    dlsi_triplets_add(&L.K, 3, 1, .25);
  dlsi_columns K, H = {7, 1, (int[]){0, 0}, NULL, NULL};
  dlsi_fclib_split split;
  const dls_sparse of_H = dlsi_columns_view(&H);
  ck_assert(!dlsi_columns_compress(&L.K, 1, DLSI_ALL, &K, NULL));
  const dls_sparse of_K = dlsi_columns_view(&K);
  ck_assert(!dlsi_fclib_split_create(&split, &of_K, &of_H, NULL));
  ck_assert_int_eq(split.joints, 0);
  dlsi_fclib_split_free(&split);
  dlsi_columns_free(&K);
}

TEST(failing_mallocs) {
  const dls_model *model = hanging(DLS_LDLT, 1);
  double r[2], x[7];
  hang(model, L.f, r, x);
  dls_fclib *file;
  MALLOCS_FAIL(write_hanging(model, x, r), 1, DLS_OK, 1);
  MALLOCS_FAIL(dls_fclib_read(&file, path, NULL), !file, DLS_OK, 1);
  dls_fclib_destroy(file);
}

int main(void) {
  return run_tests("joints in files", named, remove_file);
}

#endif
