/* test_blas_of_host.c: a BLAS that the library cannot call is refused, and does no harm. */
#include "delassus.h"
#include "linear/blas.h"
#include "run.h"

/* 1: the first half of 64 bits is the low one, which 32 bits would be. */
#if !defined(__BYTE_ORDER__) || __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define LOW_HALF_FIRST 1
#else
#define LOW_HALF_FIRST 0
#endif

#if LOW_HALF_FIRST
static int64_t seen; /* n as a BLAS with integers of 64 bits reads it */

/* dscal_ with such integers. */
static void scale_64(const int *n, const double *alpha, double *x, const int *incx) {
  int64_t step;
  memcpy(&seen, n, sizeof seen);
  memcpy(&step, incx, sizeof step);
  for (int64_t k = 0; k < seen; k++)
    x[k * step] *= *alpha;
}
#endif

static void scale_32(const int *n, const double *alpha, double *x, const int *incx) {
  for (int k = 0; k < *n; k++)
    x[k * *incx] *= *alpha;
}

static int is_64; /* 1: the BLAS of this program has integers of 64 bits */

/* The library calls this one. */
void dscal_(const int *n, const double *alpha, double *x, const int *incx) {
#if LOW_HALF_FIRST
  if (is_64)
    scale_64(n, alpha, x, incx);
  else
#endif
    scale_32(n, alpha, x, incx);
}

TEST(integers_of_64_bits) {
#if LOW_HALF_FIRST
  dls_error error = {0};
  expect_error(dlsi_check_scale(scale_64, &error), &error, DLS_E_UNSUPPORTED, "", "BLAS", -1);
  ck_assert(strstr(error.message, "ILP64") != NULL);
  ck_assert(seen < 0); /* so that it has touched nothing */
#endif
}

TEST(integers_of_32_bits) {
  ck_assert_int_eq(dlsi_check_scale(scale_32, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_check_blas(NULL), DLS_OK);
  ck_assert_int_eq(dlsi_check_product(NULL), DLS_OK);
}

/* Every function that would call such a BLAS returns the error. */
TEST(every_door_refuses_it) {
  static const double W[16] = {3, 1, 0, 1, 1, 3, 1, 0, 0, 1, 3, 1, 1, 0, 1, 3};
  static const double q[4] = {-1, 0, -1, 0}, mu[2] = {.5, .5}, K[4] = {3, 1, 1, 3}, one[1] = {1};
  static const int p[2] = {0, 1}, first[1] = {0}, second[1] = {1};
  const dls_contact contact = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu};
  const dls_model model = {.d = 2,
                           .n = 2,
                           .nodes = 1,
                           .operator_kind = DLS_STIFFNESS_DENSE,
                           .factorization = DLS_CHOLESKY,
                           .K = {2, 2, 2, K},
                           .HN = {2, 1, p, first, one},
                           .HT = {2, 1, p, second, one}};
  double r[4] = {0}, basis[4];
  int count;
  dls_proof proof;
  dls_sensitivity sensitivity;
  dls_diagnosis diagnosis;
  dls_fold fold;
  dls_solver *solver;
  dls_derive *derive;
  dls_lemke *lemke;
  dls_principal *principal;
  dls_reduction *reduction;
  dls_global *global;
  dls_primal *primal;
  dls_reduction_settings on_K;
  dls_error e = {0};
  dls_reduction_settings_init(&on_K);
  on_K.on = DLS_ON_K;
  is_64 = LOW_HALF_FIRST;
  if (!is_64) return;
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_solve, &contact, NULL, r, NULL, NULL);
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_solver_create, &solver, 2, 2, NULL);
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_contact_prove, &contact, r, &proof, NULL);
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_contact_sensitivity, &contact, r, &sensitivity);
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_contact_freedom, &contact, r, &count);
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_contact_diagnose, &contact, 9, &diagnosis);
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_contact_fold, &contact, &fold, NULL, NULL, NULL, NULL);
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_derive_create, &derive, &contact, r, 0);
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_lemke_create, &lemke, 4, NULL);
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_principal_create, &principal, 4, NULL);
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_reduction_create, &reduction, &model, NULL);
  ck_assert_int_eq(dls_reduction_create(&reduction, &model, &on_K, &e), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(reduction, q, NULL, &e), DLS_OK);
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_reduction_solve, reduction, mu, NULL, r, NULL, basis, NULL);
  dls_reduction_destroy(reduction);
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_global_create, &global, &model);
  REFUSES(UNSUPPORTED, "BLAS", -1, dls_primal_create, &primal, &model, NULL);
}
