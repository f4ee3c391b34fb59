/* test_sweeps.c: every iterate of Gauss-Seidel against (NL1)-(NL8) done one by one, with a product
 * by W for each contact. */
#include "cases.h"
#include "delassus/nlgs.h"
#include "made.h"
#include "run.h"
#include "vi/vi_internal.h"

enum { most_sweeps = 40, window = 3 };

/* The same iteration, done directly. */
typedef struct direct {
  const dls_contact *p;
  double omega, w[most], r[most], x[most], u[most], accepted;
  dls_acceleration acceleration;
  dlsi_momentum momentum;
  double moves[4][most];
  dlsi_anderson history;
  dlsi_arena arena;
  int sweeps;
} direct;

static void direct_multiply(direct *t) {
  dlsi_contact_multiply(t->p, NULL, t->r, t->u, NULL);
}

static void direct_begin(direct *t) {
  const int d = t->p->d, m = d * t->p->nc;
  const dlsi_set all = {.count = t->p->nc};
  for (int c = 0; c < t->p->nc; c++) {
    double v[3], W[9];
    dlsi_contact_diagonal(t->p, c, W);
    t->w[c] = 0;
    for (int i = 0; i < d; i++)
      t->w[c] += W[i + d * i] / d;
    memcpy(v, t->r + d * c, (size_t)d * sizeof *v);
    (void)dlsi_project_cone(d, t->p->mu[c], v, t->r + d * c);
  }
  direct_multiply(t);
  t->momentum =
      (dlsi_momentum){.r = t->moves[0], .u = t->moves[1], .p = t->moves[2], .pu = t->moves[3]};
  dlsi_momentum_start(&t->momentum, d, d, all, all, t->r, t->u);
  for (int twice = 0; twice < 2; twice++) {
    dlsi_anderson_carve(&t->history, &t->arena, (size_t)m, window, (size_t)m);
    if (!twice) ck_assert_int_eq(dlsi_arena_allocate(&t->arena, "m", m, NULL), DLS_OK);
  }
  dlsi_anderson_clear(&t->history);
  memcpy(t->x, t->r, sizeof t->x);
  const dls_certificate c = certificate_of(t->p, t->r);
  t->accepted = c.residual;
}

/* (NL6)-(NL8) r := the start of the next sweep. */
static void direct_accelerate(direct *t) {
  const int d = t->p->d, nc = t->p->nc, m = d * nc;
  const dlsi_set all = {.count = nc};
  direct_multiply(t);
  if (t->acceleration == DLS_ACCELERATION_MOMENTUM)
    (void)dlsi_momentum_step(&t->momentum, d, d, t->w, 1, all, all, t->r, t->u);
  if (t->acceleration != DLS_ACCELERATION_ANDERSON) return;
  const dls_certificate now = certificate_of(t->p, t->r);
  if (t->history.columns && now.residual > 1.1 * t->accepted) { /* (NL7) */
    memcpy(t->r, t->history.g, (size_t)m * sizeof *t->r);
    dlsi_anderson_clear(&t->history);
  } else {
    double f[most];
    t->accepted = now.residual;
    for (int i = 0; i < m; i++)
      f[i] = t->w[i / d] * (t->r[i] - t->x[i]);
    (void)dlsi_anderson_step(&t->history, m, f, t->r, t->u);
    for (int c = 0; c < nc && t->history.columns; c++) {
      double v[3];
      memcpy(v, t->r + d * c, (size_t)d * sizeof *v);
      (void)dlsi_project_cone(d, t->p->mu[c], v, t->r + d * c);
    }
  }
  memcpy(t->x, t->r, sizeof t->x);
}

/* (NL0)-(NL4) */
static void direct_sweep(direct *t) {
  const int d = t->p->d;
  for (int c = 0; c < t->p->nc; c++) {
    double *rc = t->r + d * c, W[9], p[3], s[3] = {0}, v[3];
    direct_multiply(t);
    dlsi_contact_diagonal(t->p, c, W);
    for (int i = 0; i < d; i++) {
      p[i] = t->u[d * c + i];
      for (int j = 0; j < d; j++)
        p[i] -= W[i + d * j] * rc[j];
    }
    if (d == 1)
      s[0] = p[0] < 0 ? -p[0] / W[0] : 0;
    else
      (void)dlsi_nlgs_local(d, W, p, t->p->mu[c], s, NULL);
    for (int i = 0; i < d; i++)
      v[i] = t->omega == 1 ? s[i] : rc[i] + t->omega * (s[i] - rc[i]);
    if (t->omega == 1)
      memcpy(rc, s, (size_t)d * sizeof *s);
    else
      (void)dlsi_project_cone(d, t->p->mu[c], v, rc);
  }
}

static int watch_sweeps(void *data, const dls_progress *progress) {
  direct *t = data;
  if (progress->last) return 0;
  ck_assert_int_eq(progress->iteration, ++t->sweeps);
  if (t->sweeps > 1) direct_accelerate(t);
  direct_sweep(t);
  const int m = t->p->d * t->p->nc;
  const double size = norm_of(t->r, m);
  for (int i = 0; i < m; i++)
    ck_assert_msg(fabs(progress->r[i] - t->r[i]) <= 1e-9 * size, "sweep %d, r[%d]: %g, %g",
                  t->sweeps, i, progress->r[i], t->r[i]);
  return 0;
}

/* d = 1, 2, 3; W dense, whose columns go in fours, and by blocks; plain, with two relaxations, with
 * Anderson and momentum; from 0 and from an r outside of its cones. Two candidates have no friction
 * and two are pressed by nobody but their neighbours. */
TEST_EACH(iterates_one_by_one, 0, 60) {
  static model a;
  static block_storage B;
  static const double omegas[3] = {1, .75, 1.25};
  const int d = 1 + _i % 3, blocks = _i / 3 % 2, kind = _i / 6 % 5, warm = _i / 30;
  const int nc = 6 + _i % 4, m = d * nc;
  static direct t;
  set_seed(90 + (uint64_t)_i);
  random_model(&a, d, nc, d == 1 ? 0 : .6);
  for (int c = 0; c < nc; c++) {
    if (c % 4 == 3) a.mu[c] = 0;
    if (c % 5 == 1) a.q[d * c] = .01;
  }
  t = (direct){.omega = kind < 3 ? omegas[kind] : 1,
               .acceleration = kind == 3   ? DLS_ACCELERATION_ANDERSON
                               : kind == 4 ? DLS_ACCELERATION_MOMENTUM
                                           : DLS_ACCELERATION_NONE};
  const dls_contact problem = blocks ? by_blocks(&a, &B) : a.p;
  t.p = &problem;
  double r[most];
  for (int i = 0; i < m; i++)
    t.r[i] = r[i] = warm ? uniform() : 0;
  direct_begin(&t);
  dls_nlgs_settings s;
  dls_nlgs_settings_init(&s);
  s.limits.tol = 1e-7;
  s.limits.max_iterations = most_sweeps;
  s.limits.warm_start = warm;
  s.limits.progress = watch_sweeps;
  s.limits.progress_data = &t;
  s.relaxation = t.omega;
  s.acceleration = t.acceleration;
  s.window = window;
  dls_nlgs *work;
  dls_info info;
  ck_assert_int_eq(dls_nlgs_create(&work, d, nc, &s, NULL), DLS_OK);
  ck_assert_int_ge(dls_nlgs_solve(work, &problem, r, NULL, &info, NULL), 0);
  ck_assert_int_ge(t.sweeps, 2);
  dls_nlgs_destroy(work);
  free(t.arena.base);
}
