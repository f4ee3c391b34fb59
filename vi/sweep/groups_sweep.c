/*
 * groups_sweep.c: a sweep of Gauss-Seidel over contacts in groups of eight, one in each lane.
 *
 * The rules are those of nlgs_sweep.c, (NL0)-(NL2) and (NL4) for omega = 1, for eight contacts
 * that share nothing:
 *
 *   bodies     u_c = q_c + H_c^T v,  p = u_c - W_cc r_c,  v += H_c (s - r_c)
 *   by blocks  p = q_c + sum of W_ck r_k over k != c, by rows: no u is kept
 *
 * A register holds 2, 4 or 8 lanes, depending on the processor. All widths give the same bits: sums
 * have a fixed order and each lane is rounded by itself. So do all numbers of threads: the tasks of
 * a stage share nothing. Contacts that the kernels do not serve (groups.c), or whose slip they do
 * not find, are solved by local.c, one by one.
 */
#include "groups.h"

#include <float.h>
#include <math.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

enum { newton_steps = 1 }; /* 2 give the same residual after 300 sweeps of packings */

void dlsi_groups_solve_one(int d, const double *own, double *p) {
  const double mu = own[8 * (d * d + d)];
  double W[9], r[3] = {0};
  for (int e = 0; e < d * d; e++)
    W[e] = own[8 * e];
  if (d == 1)
    (void)dlsi_local_1d(W[0], p, r);
  else if (d == 2) {
    dlsi_block_2d b;
    dlsi_block_2d_set(&b, W, mu);
    (void)dlsi_local_2d(&b, p, r);
  } else {
    dlsi_block_3d b;
    dlsi_block_3d_set(&b, W, mu);
    (void)dlsi_local_3d(&b, p, 0, r);
  }
  for (int i = 0; i < d; i++)
    p[i] = r[i];
}

/* Entries of a place are moved two at a time where the compiler has shuffles of two registers. */
#ifdef __has_builtin
#define SHUFFLES __has_builtin(__builtin_shufflevector)
#else
#define SHUFFLES 0
#endif
typedef double groups_pair __attribute__((vector_size(16), aligned(8), may_alias));
#if defined(__x86_64__)
typedef double groups_quad __attribute__((vector_size(32), aligned(8), may_alias));
#define WIDTH   8
#define TARGET  __attribute__((target("avx512f")))
#define NAME(x) x##_8
#define ROOT(x) (V) _mm512_sqrt_pd((__m512d)(x))
#define ANY(m)  (_mm512_test_epi64_mask((__m512i)(m), (__m512i)(m)) != 0)
#include "groups_kernel.h"
#define WIDTH   4
#define TARGET  __attribute__((target("avx2")))
#define NAME(x) x##_4
#define ROOT(x) (V) _mm256_sqrt_pd((__m256d)(x))
#define ANY(m)  (_mm256_movemask_pd((__m256d)(m)) != 0)
#include "groups_kernel.h"
#define WIDTH 2
#define TARGET
#define NAME(x) x##_2
#define ROOT(x) (V) _mm_sqrt_pd((__m128d)(x))
#define ANY(m)  (_mm_movemask_pd((__m128d)(m)) != 0)
#include "groups_kernel.h"
#else
#define WIDTH 2
#define TARGET
#define NAME(x) x##_2
#define ROOT(x) ((V){sqrt((x)[0]), sqrt((x)[1])})
#define ANY(m)  (((m)[0] | (m)[1]) != 0)
#include "groups_kernel.h"
#endif

typedef int groups_kernel(const dlsi_groups *, int, int, double *, double *, double *);

/* Returns the kernel for this width; for 0 the widest of the processor. */
static groups_kernel *groups_choose(int width) {
#if defined(__x86_64__)
  const int most = __builtin_cpu_supports("avx512f") ? 8 : __builtin_cpu_supports("avx2") ? 4 : 2;
  const int now = width && width < most ? width : most;
  return now == 8 ? run_8 : now == 4 ? run_4 : run_2;
#else
  (void)width;
  return run_2;
#endif
}

/* The tasks of one stage. */
typedef struct groups_tasks {
  const dlsi_groups *groups;
  groups_kernel *kernel;
  double *r, *v, *u;
  int first;
} groups_tasks;

static void groups_do(void *data, int k) {
  const groups_tasks *s = data;
  const int task = s->first + k, *start = s->groups->task + task;
  s->groups->changed[task] = s->kernel(s->groups, start[0], start[1], s->r, s->v, s->u);
}

static int groups_run(const dlsi_groups *groups, dlsi_team *team, double *r, double *v, double *u) {
  groups_tasks s = {groups, groups_choose(groups->width), r, v, u, 0};
  int changed = 0;
  for (int k = 0; k < groups->stages; k++) {
    s.first = groups->stage[k];
    dlsi_parallel(team, groups->stage[k + 1] - s.first, groups_do, &s);
  }
  for (int k = 0; k < groups->tasks; k++)
    changed |= groups->changed[k];
  return changed;
}

int dlsi_groups_sweep(const dlsi_groups *groups, dlsi_team *team, double *r, double *v) {
  return groups_run(groups, team, r, v, NULL);
}

void dlsi_groups_look(const dlsi_groups *groups, dlsi_team *team, const double *r, double *v,
                      double *u) {
  (void)groups_run(groups, team, (double *)r, v, u);
}
