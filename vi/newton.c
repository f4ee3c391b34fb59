/*
 * newton.c: nonsmooth Newton on the friction law, d = 2 and 3.
 *
 * With w_c of the certificate, x = w r_n - u_n and tau = w r_t - u_t per candidate, u = W r + q, the
 * law is AC(r, u) = 0,
 *
 *   AC_c = w r_c - ( max(0, x),  tau put on the disc of radius R ),   R = mu max(0, x)
 *
 * (Alart and Curnier, Comp. Meth. Appl. Mech. Eng. 92, 1991, 353-375). Its generalised derivative is
 * reduced by hand: the branch of a candidate says which part of its new r is known, and only the
 * rest stays unknown. With r0 = r + known part, u0 = W r0 + q, t = tau / |tau| and, in 3D, p = t turned
 * by 90 degrees, one step is
 *
 *   (N1)  free   x <= 0        r0_c = 0                               nothing unknown
 *         stick  |tau| <= R    r0_c = r_c                             dr_c:  u0_c + W_c dr = 0
 *         slip   otherwise     r0_c = r_c + (0, k t), k = (mu u_n + R) / w - t.r_t
 *                              dr_c = (a, mu a t + b p), unknown a:   u0_n + W_n dr = 0
 *                              and, 3D, b:  p.(u0_t + W_t dr) + l (p.r_t + b) = 0
 *                              l = w (|tau| - R) / R
 *         slip, mu = 0         r0_c = (r_n, 0), unknown a:            u0_n + W_n dr = 0
 *   (N2)  these rows and columns of W + eps diag(w), and l on the rows of b: one LU, one solve
 *         While the states stay, and in 3D nobody slides, the matrix does, and its factors are kept.
 *         In a dense matrix the head, A, comes first: the unknowns of candidates that stick or have
 *         mu = 0. If W is symmetric and three quarters of all unknowns are in it,
 *           ( A  B )      A = L L^T,  X = L^-1 B,  Y = L^-1 C^T,  and LU of S = D - Y^T X.
 *           ( C  D )
 *         L is kept while the candidates of the head stick; new ones that stick join D, up to a quarter
 *         of the head. No pivots are needed between the two: Y^T Y is less than the diagonal blocks of
 *         W, and X is no larger than (1 + mu) Y.
 *   (N3)  r := r0 + dr
 *
 * k and mu a are the row of AC along t, linearised; the row of b is the one along p divided by
 * R / |tau|, with p.tau = 0. eps = 1e-6 keeps the matrix regular where W is not, and leaves AC alone:
 * steps then shrink the error by eps cond(W) or so instead of squaring it. If the matrix is singular
 * all the same, eps grows a hundredfold for good, from 1e-8 on. And tenfold, up to 1e-2, after each 4
 * steps in a row that did not halve the residual: on a W of low rank the rounding of W r + q comes
 * back divided by eps, and shorter steps go round among states less often.
 *
 * With springs, u = (W + diag(E)) r + q (augmented.c), E stands beside eps diag(w) in (N2).
 *
 *   (N0)  First, sweeps of Gauss-Seidel (nlgs.c) sort the states: from r = 0 the full step alone goes
 *         round among states too often.
 *   (N4)  Line search, for starts without sweeps: r + s (r' - r), s = 1, 1/2, .. 1/64, until |AC| is
 *         below the largest of its last five values (Grippo, Lampariello and Lucidi, SIAM J. Numer.
 *         Anal. 23, 1986, 707-716). u is affine in r, so that a trial costs O(m).
 *
 * Stop: the certificate holds (its F is de Saxce's; both vanish together), the limit of steps, or 12
 * steps that did not halve the residual. Uphill steps are taken, too; the best r met is kept.
 *
 * Deviation from the full method, which has m unknowns whatever the states: only that arithmetic is
 * saved, the iterates are the same but for eps.
 * Cost of a step: two products with W, and an LU of the unknowns: 2/3 k^3 dense, half of that by
 * Cholesky, much less sparse.
 * What can fail: nothing makes it converge from afar, and states may go round for ever (cycle in
 * tests/test_newton.c): DLS_STALLED.
 */
#include "delassus/newton.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/base.h"
#include "linear/blas.h"
#include "linear/dense.h"
#include "linear/sparse_lu.h"
#include "vi_internal.h"

enum { most_steps = 30, patience = 12, impatience = 4, memory = 5, halvings = 6 };
enum { head_over_rest = 3, head_over_new = 4 };
enum { dense_limit = 250 }; /* of 50, 150, 250, 400 the fastest on FCLIB files by blocks */

static const double least_eps = 1e-8; /* that cures a singular matrix */
static const double most_eps = 1e-2;  /* that a lack of progress leads to */
static const double most_floor = 1e-6;
static const double least_beta = 1e-10; /* R / |tau|: l stays finite where R vanishes */

/* (N1) of a candidate */
typedef struct branch {
  dls_contact_state state;
  int first, count; /* its unknowns, */
  int in_head;      /* among those of A */
  double t[2], p[2];
  double l;
} branch;

typedef enum factors { NONE, DENSE, SPARSE } factors;

struct dls_newton {
  dls_newton_settings settings;
  int d, nc;
  dls_nlgs *nlgs;       /* NULL without sweeps */
  double *w;            /* nc      weights of the certificate */
  branch *branch;       /* nc      */
  double *r, *u, *best; /* m       the iterate, W r + q, the best one */
  double *next, *unext; /* m       r0, then r0 + dr; u of it */
  double *a, *F;        /* m       */
  double *x;            /* m       right side and solution of (N2) */
  int *pivot;           /* m       */
  int *p;          /* m + 1   sparse: columns of the matrix; W dense: the rows of W for its rows */
  double tol;      /* of this run, and */
  const double *E; /* nc: it solves u = (W + diag(E)) r + q; NULL: 0 */
  int sparse;      /* this run factorises sparse beyond dense_limit */
  factors factors; /* of (N2) as it stands */
  int head;        /* unknowns in A */
  int has_head;    /* L is there */
  int symmetric;   /* no A has shown yet that W is not */
  dlsi_room *room; /* of (N2): the one given, or */
  dlsi_room own;
};

void dls_newton_settings_init(dls_newton_settings *settings) {
  if (!settings) return;
  *settings = (dls_newton_settings){.size = sizeof *settings, .sweeps = 20, .regularization = 1e-6};
  dlsi_limits_init(&settings->limits);
}

static dls_status check_settings(const dls_newton_settings *s, dls_error *error) {
  const dlsi_setting own[] = {{"sweeps", s->sweeps, 0, INT_MAX, 0},
                              {"line_search", s->line_search, 0, 1, 0},
                              {"regularization", s->regularization, 0, 1 - DBL_EPSILON, 0}};
  return dlsi_check_settings(&s->limits, s->size, sizeof *s, 3, own, error);
}

/* the workspace and its arrays, in one piece */
static dls_newton *carve(dlsi_arena *arena, int d, int nc) {
  const size_t n = (size_t)nc, m = (size_t)d * n;
  const size_t D = sizeof(double);
  dls_newton *s = dlsi_take(arena, 1, sizeof *s);
  dls_newton filled = {.d = d, .nc = nc};
  filled.w = dlsi_take(arena, n, D);
  filled.branch = dlsi_take(arena, n, sizeof *filled.branch);
  double **const vectors[] = {&filled.r,     &filled.u, &filled.best, &filled.next,
                              &filled.unext, &filled.a, &filled.F,    &filled.x};
  for (size_t e = 0; e < sizeof vectors / sizeof vectors[0]; e++)
    *vectors[e] = dlsi_take(arena, m, D);
  filled.pivot = dlsi_take(arena, m, sizeof *filled.pivot);
  filled.p = dlsi_take(arena, m + 1, sizeof *filled.p);
  if (arena->failed || !arena->base) return NULL;
  *s = filled;
  return s;
}

/* From a quarter of all blocks on, the sparse matrix takes the room of the dense one, and MUMPS more time
 * than LAPACK: 1 to 2.5 times (d = 3, 200 and 500 candidates, band or scattered; at an eighth 0.4 to
 * 1.1 times). */
static int is_sparse(int nc, int blocks) {
  return blocks < 0.25 * nc * nc;
}

/* Room for the matrix of nc candidates, W dense (blocks = 0) or with so many blocks; what was announced
 * to create decides how they are factorised. */
static dls_status reserve(dls_newton *work, int nc, int blocks, dls_error *error) {
  const size_t m = (size_t)work->d * (size_t)nc;
  work->sparse = 0;
  const int told = work->settings.limits.blocks;
  if (blocks && m > dense_limit && (told ? is_sparse(work->nc, told) : is_sparse(nc, blocks))) {
    dls_error why;
    const dls_status status = dlsi_room_sparse(work->room, work->d, nc, blocks, &why);
    if (status && status != DLS_E_UNSUPPORTED) {
      if (error) *error = why;
      return status;
    }
    work->sparse = !status;
  }
  return dlsi_room_dense(work->room, work->sparse ? dense_limit : m, error);
}

/* the Gauss-Seidel part, and the matrices of the storage that is announced */
static dls_status create_parts(dls_newton *work, dls_error *error) {
  const dls_newton_settings *settings = &work->settings;
  if (settings->sweeps) {
    dls_nlgs_settings s;
    dls_nlgs_settings_init(&s);
    s.limits.max_iterations = settings->sweeps;
    s.limits.warm_start = 1;
    s.limits.progress = settings->limits.progress;
    s.limits.progress_data = settings->limits.progress_data;
    if (dls_nlgs_create(&work->nlgs, work->d, work->nc, &s, NULL)) return dlsi_no_memory(error);
  }
  return reserve(work, work->nc, settings->limits.blocks, error);
}

dls_status dlsi_newton_create(dls_newton **out, int d, int nc, const dls_newton_settings *settings,
                              dlsi_room *room, dls_error *error) {
  if (!out) return dlsi_is_null(error, "out");
  *out = NULL;
  dls_status status = dlsi_check_sizes(d, nc, error);
  dls_newton_settings defaults;
  dls_newton_settings_init(&defaults);
  if (!settings) settings = &defaults;
  if (!status) status = check_settings(settings, error);
  if (status) return status;

  dlsi_arena arena = {0};
  (void)carve(&arena, d, nc);
  const size_t m = (size_t)d * (size_t)nc;
  if (arena.failed || (!settings->limits.blocks && m > SIZE_MAX / sizeof(double) / m))
    return dlsi_fail(error, DLS_E_SIZE, "nc", -1, nc, "is too large");
  arena.size = arena.used;
  arena.used = 0;
  arena.base = dlsi_alloc(1, arena.size);
  if (!arena.base) return dlsi_no_memory(error);
  dls_newton *work = carve(&arena, d, nc);
  work->settings = *settings;
  work->room = room ? room : &work->own;
  status = create_parts(work, error);
  if (status) {
    dls_newton_destroy(work);
    return status;
  }
  *out = work;
  return DLS_OK;
}

dls_status dls_newton_create(dls_newton **out, int d, int nc, const dls_newton_settings *settings,
                             dls_error *error) {
  return dlsi_at(__func__, dlsi_newton_create(out, d, nc, settings, NULL, error), error);
}

void dls_newton_destroy(dls_newton *workspace) {
  if (!workspace) return;
  dls_nlgs_destroy(workspace->nlgs);
  dlsi_room_free(&workspace->own);
  free(workspace); /* first in its one piece */
}

/* ---- the matrix of a step -------------------------------------------------------------------- */

/* direction of unknown j of a candidate */
static void direction(const branch *b, double mu, int j, double *e) {
  e[0] = e[1] = e[2] = 0;
  if (b->state == DLS_STICK)
    e[j] = 1;
  else if (j == 0) {
    e[0] = 1;
    e[1] = mu * b->t[0];
    e[2] = mu * b->t[1];
  } else {
    e[1] = b->p[0];
    e[2] = b->p[1];
  }
}

/* row i of a candidate times v (3) */
static double row(const branch *b, int i, const double *v) {
  if (b->state == DLS_STICK) return i == 0 ? v[0] : i == 1 ? v[1] : v[2];
  return i == 0 ? v[0] : b->p[0] * v[1] + b->p[1] * v[2];
}

/* what (N2) adds to the diagonal for unknown j of candidate c: the rows of a candidate are
 * orthonormal to its columns, but for the tangential part of a, which no row sees along p */
static double extra_diagonal(const dls_newton *work, int c, int j, double eps) {
  const branch *b = &work->branch[c];
  return eps * work->w[c] + (work->E ? work->E[c] : 0) +
         (b->state == DLS_SLIP && j == 1 ? b->l : 0);
}

/* v (3) := a block of W times e */
static void multiply_block(int d, const double *x, size_t ld, const double *e, double *v) {
  v[0] = v[1] = v[2] = 0;
  for (int i = 0; i < d; i++)
    v[i] = x[i] * e[0] + x[(size_t)i + ld] * e[1] + (d == 3 ? x[(size_t)i + 2 * ld] * e[2] : 0);
}

/* W(:,b) times the direction of unknown j of candidate b, m; W dense */
static const double *column_of(dls_newton *work, const dls_contact *problem, int b, int j) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  const branch *at = &work->branch[b];
  double e[3];
  if (at->state == DLS_STICK)
    return problem->W.a + (d * (size_t)b + (size_t)j) * (size_t)problem->W.ld;
  direction(at, problem->mu[b], j, e);
  memset(work->a, 0, m * sizeof *work->a);
  dlsi_contact_add_panel(problem, 1, &b, e, work->a);
  return work->a;
}

/* (N2) in J, part by part, each by columns. A turns into L, the others into X, Y^T and S. */
typedef struct parts {
  int h, t;           /* unknowns in A, and the others */
  double *A, *B, *CT; /* h x h, h x t, h x t */
  double *D;          /* t x t */
} parts;

static parts parts_of(const dls_newton *work, int k) {
  const size_t h = (size_t)work->head, t = (size_t)k - h;
  double *J = work->room->J;
  return (parts){(int)h, (int)t, J, J + h * h, J + h * h + h * t, J + h * h + 2 * h * t};
}

static double *entry(const parts *in, int row, int col) {
  const size_t h = (size_t)in->h, t = (size_t)in->t, i = (size_t)row, j = (size_t)col;
  if (row < in->h) return col < in->h ? in->A + i + j * h : in->B + i + (j - h) * h;
  return col < in->h ? in->CT + j + (i - h) * h : in->D + (i - h) + (j - h) * t;
}

/* (N2) but for an A that is known; W dense */
static void build_from_dense(dls_newton *work, const dls_contact *problem, double eps, int k) {
  const int d = problem->d;
  const parts in = parts_of(work, k);
  const int h = in.h;
  for (int c = 0; c < problem->nc; c++)
    for (int i = 0; i < work->branch[c].count; i++)
      work->p[work->branch[c].first + i] = d * c + i;
  for (int b = 0; b < problem->nc; b++)
    for (int j = 0; j < work->branch[b].count; j++) {
      const int col = work->branch[b].first + j, known = work->has_head && col < h;
      const double *v = column_of(work, problem, b, j);
      for (int i = known ? h : 0; i < k; i++)
        *entry(&in, i, col) = v[work->p[i]];
      for (int c = 0; d == 3 && c < problem->nc; c++) {
        const branch *at = &work->branch[c];
        if (at->state == DLS_SLIP && at->count == 2)
          *entry(&in, at->first + 1, col) = row(at, 1, v + 3 * c);
      }
      if (!known) *entry(&in, col, col) += extra_diagonal(work, b, j, eps);
    }
}

/* the same; W by blocks */
static void build_from_blocks(dls_newton *work, const dls_contact *problem, double eps, int k) {
  const parts in = parts_of(work, k);
  const size_t known = work->has_head ? (size_t)in.h : 0;
  memset(in.A + known * known, 0, ((size_t)k * (size_t)k - known * known) * sizeof *in.A);
  for (int b = 0; b < problem->nc; b++) {
    const dlsi_block_column W = dlsi_contact_column(problem, (size_t)b);
    for (int j = 0; j < work->branch[b].count; j++) {
      const int col = work->branch[b].first + j, from = (size_t)col < known ? in.h : 0;
      double e[3], v[3];
      direction(&work->branch[b], problem->mu[b], j, e);
      for (size_t s = W.begin; s < W.end; s++) {
        const branch *row_of = &work->branch[dlsi_row(&W, s)];
        if (!row_of->count || row_of->first < from) continue;
        multiply_block(problem->d, W.x + s * W.step, W.ld, e, v);
        for (int i = 0; i < row_of->count; i++)
          *entry(&in, row_of->first + i, col) += row(row_of, i, v);
      }
      if (!from) *entry(&in, col, col) += extra_diagonal(work, b, j, eps);
    }
  }
}

static void build_dense(dls_newton *work, const dls_contact *problem, double eps, int k) {
  (problem->Wb.x ? build_from_blocks : build_from_dense)(work, problem, eps, k);
}

/* (N2) in compressed columns */
static dls_sparse build_sparse(dls_newton *work, const dls_contact *problem, double eps, int k) {
  int entries = 0, *rows = work->room->i;
  double *value = work->room->v;
  for (int b = 0; b < problem->nc; b++) {
    const dlsi_block_column W = dlsi_contact_column(problem, (size_t)b);
    for (int j = 0; j < work->branch[b].count; j++) {
      const int col = work->branch[b].first + j;
      double e[3], v[3];
      direction(&work->branch[b], problem->mu[b], j, e);
      work->p[col] = entries;
      rows[entries] = col;
      value[entries++] = extra_diagonal(work, b, j, eps);
      for (size_t s = W.begin; s < W.end; s++) {
        const branch *row_of = &work->branch[dlsi_row(&W, s)];
        if (!row_of->count) continue;
        multiply_block(problem->d, W.x + s * W.step, W.ld, e, v);
        for (int i = 0; i < row_of->count; i++) {
          rows[entries] = row_of->first + i;
          value[entries++] = row(row_of, i, v);
        }
      }
    }
  }
  work->p[k] = entries;
  const dls_sparse A = {k, k, work->p, rows, value};
  return A;
}

/* of another matrix */
static void forget_factors(dls_newton *work) {
  work->factors = NONE;
  work->has_head = 0;
}

/* L; 0 if there is none */
static int factor_head(dls_newton *work, const parts *in) {
  int info;
  if (!in->h || work->has_head) return 1;
  if (!dlsi_is_symmetric(in->A, (size_t)in->h)) return work->symmetric = 0;
  dpotrf_("L", &in->h, in->A, &in->h, &info, 1);
  return work->has_head = !info;
}

/* X, Y, S and its factors; DLS_E_SINGULAR */
static dls_status factor_rest(dls_newton *work, const parts *in) {
  const double one = 1, minus = -1;
  const int h = in->h, t = in->t;
  int info;
  if (!t) return DLS_OK;
  if (h) {
    dtrsm_("L", "L", "N", "N", &h, &t, &one, in->A, &h, in->B, &h, 1, 1, 1, 1);
    dtrsm_("L", "L", "N", "N", &h, &t, &one, in->A, &h, in->CT, &h, 1, 1, 1, 1);
    dgemm_("T", "N", &t, &t, &h, &minus, in->CT, &h, in->B, &h, &one, in->D, &t, 1, 1);
  }
  dgetrf_(&t, &t, in->D, &t, work->pivot, &info);
  return info ? DLS_E_SINGULAR : DLS_OK;
}

/* factors of (N2); DLS_E_SINGULAR, DLS_E_MEMORY */
static dls_status factor(dls_newton *work, const dls_contact *problem, double eps, int k,
                         dls_error *error) {
  if (work->sparse && k > dense_limit) {
    const dls_sparse A = build_sparse(work, problem, eps, k);
    work->factors = SPARSE;
    return dlsi_sparse_lu_factor(work->room->lu, &A, error);
  }
  parts in = parts_of(work, k);
  build_dense(work, problem, eps, k);
  if (!factor_head(work, &in)) {
    work->head = 0;
    in = parts_of(work, k);
    build_dense(work, problem, eps, k);
  }
  work->factors = DENSE;
  return factor_rest(work, &in);
}

/* x := the solution of (N2) with right side x, by its parts */
static void solve_parts(const dls_newton *work, int k, double *x) {
  const parts in = parts_of(work, k);
  const double one = 1, minus = -1;
  const int h = in.h, t = in.t, step = 1;
  int info;
  dlsi_solve_lower(h, in.A, x);
  if (t) {
    if (h) dgemv_("T", &h, &t, &minus, in.CT, &h, x, &step, &one, x + h, &step, 1);
    dgetrs_("N", &t, &step, in.D, &t, work->pivot, x + h, &t, &info, 1);
    if (h) dgemv_("N", &h, &t, &minus, in.B, &h, x + h, &step, &one, x, &step, 1);
  }
  dlsi_solve_upper(h, in.A, x);
}

/* x := the solution of (N2) with right side x; *done counts the factorisations. DLS_E_SINGULAR,
 * DLS_E_MEMORY */
static dls_status solve_step(dls_newton *work, const dls_contact *problem, double eps, int k,
                             int *done, dls_error *error) {
  if (k == 0) return DLS_OK;
  if (!work->factors) {
    const dls_status status = factor(work, problem, eps, k, error);
    ++*done;
    if (status) {
      work->factors = NONE;
      return status;
    }
  }
  if (work->factors == SPARSE) return dlsi_sparse_lu_solve(work->room->lu, work->x, error);
  solve_parts(work, k, work->x);
  return DLS_OK;
}

/* ---- the iteration --------------------------------------------------------------------------- */

/* (N1) for one candidate; r := r0 */
static branch branch_of(int d, double mu, double w, const double *u, double *r) {
  branch b = {.state = DLS_FREE};
  const double x = w * r[0] - u[0];
  if (!(x > 0)) {
    memset(r, 0, (size_t)d * sizeof *r);
    return b;
  }
  const double R = mu * x, tau[2] = {w * r[1] - u[1], d == 3 ? w * r[2] - u[2] : 0};
  const double size = hypot(tau[0], tau[1]);
  if (mu > 0 && size <= R) {
    b.state = DLS_STICK;
    b.count = d;
    return b;
  }
  b.state = DLS_SLIP;
  b.count = 1;
  if (!(mu > 0)) {
    memset(r + 1, 0, (size_t)(d - 1) * sizeof *r);
    return b;
  }
  const double beta = R > least_beta * size ? R / size : least_beta;
  b.count = d - 1;
  b.t[0] = tau[0] / size;
  b.t[1] = tau[1] / size;
  b.p[0] = -b.t[1];
  b.p[1] = b.t[0];
  b.l = w * ((1 - beta) / beta);
  const double along = b.t[0] * r[1] + (d == 3 ? b.t[1] * r[2] : 0);
  const double k = (mu * u[0] + R) / w - along;
  for (int i = 1; i < d; i++)
    r[i] += k * b.t[i - 1];
  return b;
}

/* a and b of one candidate lead to the same rows and columns of (N2) */
static int same_matrix(int d, const branch *a, const branch *b) {
  return a->state == b->state && a->t[0] == b->t[0] && a->t[1] == b->t[1] &&
         (d == 2 || a->l == b->l);
}

/* may stand in A */
static int is_symmetric(const branch *b, double mu) {
  return b->state == DLS_STICK || (b->state == DLS_SLIP && !(mu > 0));
}

/* Whether L remains good for a matrix with k unknowns; else what is to stand in A, if anything. */
static void choose_head(dls_newton *work, const dls_contact *problem, int k) {
  int lead = 0, new = 0, left = 0;
  for (int c = 0; c < problem->nc; c++) {
    const branch *b = &work->branch[c];
    const int symmetric = is_symmetric(b, problem->mu[c]);
    if (symmetric) lead += b->count;
    if (symmetric && !b->in_head) new += b->count;
    if (!symmetric && b->in_head) left = 1;
  }
  const int dense = !(work->sparse && k > dense_limit);
  if (work->has_head && dense && !left && head_over_new * new <= work->head) return;
  const int worth = dense && work->symmetric && lead >= head_over_rest * (k - lead);
  work->has_head = 0;
  for (int c = 0; c < problem->nc; c++)
    work->branch[c].in_head = worth && is_symmetric(&work->branch[c], problem->mu[c]);
}

/* Numbers the k unknowns of a matrix to be factorised, those in A first. */
static void number(dls_newton *work, const dls_contact *problem, int k) {
  int next = 0;
  choose_head(work, problem, k);
  for (int rest = 0; rest < 2; rest++) {
    for (int c = 0; c < problem->nc; c++) {
      branch *b = &work->branch[c];
      if (b->in_head == rest) continue;
      b->first = next;
      next += b->count;
    }
    if (!rest) work->head = next;
  }
}

/* (N1) for all: next := r0, x := right side; returns how many unknowns there are */
static int linearise(dls_newton *work, const dls_contact *problem) {
  const int d = problem->d;
  const size_t m = (size_t)d * (size_t)problem->nc;
  int k = 0;
  memcpy(work->next, work->r, m * sizeof *work->r);
  for (int c = 0; c < problem->nc; c++) {
    const size_t o = (size_t)d * (size_t)c;
    branch *b = &work->branch[c];
    const branch before = *b;
    *b = branch_of(d, problem->mu[c], work->w[c], work->u + o, work->next + o);
    if (work->factors && !same_matrix(d, b, &before)) work->factors = NONE;
    b->first = before.first;
    b->in_head = before.in_head;
    k += b->count;
  }
  if (!work->factors) number(work, problem, k);
  dlsi_multiply(problem, NULL, work->E, work->next, work->unext, NULL);
  for (int c = 0; c < problem->nc; c++) {
    const size_t o = (size_t)d * (size_t)c;
    const branch *b = &work->branch[c];
    double v[3] = {0}, s[3] = {0};
    memcpy(v, work->unext + o, (size_t)d * sizeof *v);
    memcpy(s, work->next + o, (size_t)d * sizeof *s);
    for (int i = 0; i < b->count; i++)
      work->x[b->first + i] =
          -row(b, i, v) - (b->state == DLS_SLIP && i == 1 ? b->l * row(b, i, s) : 0);
  }
  return k;
}

/* (N3) next := r0 + dr */
static void add_step(dls_newton *work, const dls_contact *problem) {
  const int d = problem->d;
  for (int c = 0; c < problem->nc; c++) {
    const branch *b = &work->branch[c];
    double *r = work->next + (size_t)d * (size_t)c, e[3];
    for (int j = 0; j < b->count; j++) {
      const double x = work->x[b->first + j];
      direction(b, problem->mu[c], j, e);
      r[0] += x * e[0];
      r[1] += x * e[1];
      if (d == 3) r[2] += x * e[2];
    }
  }
}

/* |AC| of r and u = W r + q */
static double merit(dls_newton *work, const dls_contact *problem, const double *r,
                    const double *u) {
  const int d = problem->d;
  for (int c = 0; c < problem->nc; c++) {
    const size_t o = (size_t)d * (size_t)c;
    const double w = work->w[c], x = w * r[o] - u[o], R = x > 0 ? problem->mu[c] * x : 0;
    double tau[2] = {0};
    for (int i = 1; i < d; i++)
      tau[i - 1] = w * r[o + (size_t)i] - u[o + (size_t)i];
    const double size = hypot(tau[0], tau[1]), beta = size > R ? R / size : 1;
    work->F[o] = x > 0 ? u[o] : w * r[o];
    for (int i = 1; i < d; i++)
      work->F[o + (size_t)i] = w * r[o + (size_t)i] - beta * tau[i - 1];
  }
  return dlsi_norm2(work->F, (size_t)d * (size_t)problem->nc);
}

/* (N4) next := r + s (next - r); last: the |AC| of the last iterates, this one's being added */
static void search(dls_newton *work, const dls_contact *problem, int step, double *last) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  double bound = last[0];
  for (int k = 1; k < memory; k++)
    if (last[k] > bound) bound = last[k];
  dlsi_multiply(problem, NULL, work->E, work->next, work->unext, NULL);
  double now = merit(work, problem, work->next, work->unext);
  for (int k = 0; k < halvings && !(now < bound); k++) {
    for (size_t i = 0; i < m; i++) {
      work->next[i] = 0.5 * (work->r[i] + work->next[i]);
      work->unext[i] = 0.5 * (work->u[i] + work->unext[i]);
    }
    now = merit(work, problem, work->next, work->unext);
  }
  last[step % memory] = now;
}

static dls_certificate measure(const dls_newton *work, const dls_contact *problem) {
  dls_certificate certificate;
  dlsi_multiply(problem, NULL, work->E, work->r, work->u, work->a);
  dlsi_contact_measure(problem, work->r, work->u, work->a, work->w, work->F, &certificate);
  return certificate;
}

/* Keeps work->r with its certificate if it is better than the best so far. Where there is no solution
 * and W is singular, r can run away until W r + q is all rounding: such an r is no answer. */
static void keep_best(const dls_newton *work, size_t m, const dls_certificate *now,
                      dls_certificate *best) {
  if (!(now->residual < best->residual) && best->residual <= DBL_MAX) return;
  if (!(now->floor <= most_floor)) return;
  *best = *now;
  memcpy(work->best, work->r, m * sizeof *work->r);
}

/* Steps from work->r, to which work->u and `now` belong, until the certificate holds or there is a
 * reason to stop, which is returned. *steps: done. */
static dls_status iterate(dls_newton *work, const dls_contact *problem, dls_certificate now,
                          dls_certificate *best, dlsi_newton_count *count, dls_error *error) {
  const dls_newton_settings *settings = &work->settings;
  const int most = dlsi_most_iterations(&settings->limits, most_steps);
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  double eps = settings->regularization, halved = now.residual, last[memory] = {0};
  if (settings->line_search) last[0] = merit(work, problem, work->r, work->u);
  for (int k = 1, since = 0; k <= most; k++) {
    const int unknowns = linearise(work, problem); /* (N1) */
    dls_error why = {0};
    dls_status status;
    while ((status = solve_step(work, problem, eps, unknowns, &count->factorisations, &why)) ==
           DLS_E_SINGULAR) {
      eps = eps > least_eps ? 100 * eps : least_eps;
      forget_factors(work);
      if (!(eps < 1)) return DLS_STALLED;
      linearise(work, problem); /* x is spent */
    }
    if (status) {
      if (error) *error = why;
      return status;
    }
    add_step(work, problem); /* (N3) */
    if (settings->line_search) search(work, problem, k, last);
    memcpy(work->r, work->next, m * sizeof *work->r);
    now = measure(work, problem);
    count->steps = k;
    keep_best(work, m, &now, best);
    if (dls_certificate_holds(best, work->tol)) return DLS_OK;
    const dls_progress progress = {"newton", k, most, now.residual};
    if (settings->limits.progress &&
        settings->limits.progress(settings->limits.progress_data, &progress))
      return DLS_CANCELLED;
    if (now.residual <= halved / 2) {
      halved = now.residual;
      since = k;
    }
    if (k > since && (k - since) % impatience == 0 && eps < most_eps) {
      eps *= 10;
      forget_factors(work);
    }
    if (k - since >= patience || !(now.residual <= DBL_MAX)) return DLS_STALLED;
  }
  return DLS_MAX_ITERATIONS;
}

/* (N0), then steps, from work->r; the best r is work->best, to which *best belongs. */
static dls_status run(dls_newton *work, const dls_contact *problem, dls_certificate *best,
                      dlsi_newton_count *count, dls_error *error) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  dls_status status = DLS_STALLED;
  if (work->nlgs)
    status = dlsi_nlgs_run(work->nlgs, problem, (dlsi_sweeps){.E = work->E}, work->tol, work->r,
                           work->u, best, &count->sweeps);
  else
    *best = measure(work, problem);
  memcpy(work->best, work->r, m * sizeof *work->r);
  if (dls_certificate_holds(best, work->tol)) return DLS_OK;
  return status == DLS_CANCELLED ? status : iterate(work, problem, *best, best, count, error);
}

dls_status dlsi_newton_run(dls_newton *work, const dls_contact *problem, const double *E,
                           double tol, double *r, double *u, dls_certificate *certificate,
                           dlsi_newton_count *count, dls_error *error) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  dls_status status =
      reserve(work, problem->nc, problem->Wb.x ? problem->Wb.p[problem->nc] : 0, error);
  if (status) return status;
  work->E = E;
  work->tol = tol;
  work->symmetric = 1;
  forget_factors(work);
  *count = (dlsi_newton_count){0};
  dlsi_contact_weights(problem, work->w);
  if (!work->settings.limits.warm_start || dlsi_max_abs(problem->q, m) == 0) /* q = 0: r = 0 */
    memset(work->r, 0, m * sizeof *r);
  else
    memcpy(work->r, r, m * sizeof *r);
  status = run(work, problem, certificate, count, error);
  if (status < 0) return status;
  memcpy(r, work->best, m * sizeof *r);
  if (u) dlsi_multiply(problem, NULL, E, r, u, NULL);
  return status;
}

dls_status dlsi_newton_solve(dls_newton *work, const dls_contact *problem, double *r, double *u,
                             dls_info *info, dls_error *error) {
  dlsi_newton_count count;
  dls_certificate certificate;
  const dls_status status = dlsi_newton_run(work, problem, NULL, work->settings.limits.tol, r, u,
                                            &certificate, &count, error);
  if (status >= 0 && info)
    *info = (dls_info){.status = status,
                       .method = DLS_NEWTON,
                       .iterations = count.steps,
                       .certificate = certificate,
                       .factorisations = count.factorisations,
                       .sweeps = count.sweeps};
  return status;
}

dls_status dls_newton_solve(dls_newton *workspace, const dls_contact *problem, double *r, double *u,
                            dls_info *info, dls_error *error) {
  if (!workspace) return dlsi_at(__func__, dlsi_is_null(error, "workspace"), error);
  const dls_status status = dlsi_check_solve(workspace->d, workspace->nc, problem, r,
                                             workspace->settings.limits.warm_start, error);
  return dlsi_at(__func__,
                 status ? status : dlsi_newton_solve(workspace, problem, r, u, info, error), error);
}
