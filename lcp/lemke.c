/*
 * lemke.c: solves LCP(M, q) by Lemke's method, [Chabrand 1998] 4.3 (40)-(49).
 *
 *   y = M z + d z0 + q,   y, z >= 0,  z0 >= 0,  y_i z_i = 0       [C] (42) with d = 1
 *
 * as a table x_B = b + A x_N (table.c). z0 starts large enough for y >= 0 and ends at 0:
 *
 *   (LE0) warm start only: begin at the basis of z, see below
 *   (LE1) z0 enters, y_r leaves, r = argmin q_i / d_i                               [C] (43)-(45)
 *   (LE2) the complement of the variable that left enters: column c of A
 *   (LE3) x_r leaves, r = argmin { b_i / -c_i : c_i < 0 }; no such i: a ray, stop       (46), (49)
 *   (LE4) pivot; if z0 left, b is a solution, else go to (LE2)                      (47)-(48)
 *
 * Ties. Replace q by q(e) = q + e g + (e^2, .., e^(n+1)), g > 0, e -> 0+. The basic variables
 * become b + e g' + .., where pivots transform g' like b. A change of q_j acts as the opposite
 * change of y_j, so the coefficient of e^(j+2) in row i is
 *
 *   (LE5) l_ij = -a_is if y_j stands in column s;  if y_j is basic, 1 in its row, else 0.
 *
 * (LE3) compares (LE6) b_i / -c_i, among ties (LE7) g'_i / -c_i, among ties (LE8) l_ij / -c_i for
 * j = 0, 1, .. A column for (LE8) costs as much as one for (LE2), but with this g (LE8) hardly ever
 * starts.
 *
 * Why it ends. (l_ij) is the inverse of the basis, so the rows (b_i, g'_i, l_i) are linearly
 * independent, no two are proportional, and (LE6)-(LE8) always leave one r. (LE1) makes all rows
 * lexicographically positive, and the same choice keeps them so. So for small e > 0 the path is
 * that of the problem q(e), which is not degenerate. An almost complementary basis has at most two
 * neighbours, one for each variable of the nonbasic pair. The first basis has only one: on its
 * other side is the primary ray. Hence no basis occurs twice, and there are finitely many (Lemke,
 * Management Science 11, 1965, 681-689; Cottle, Pang, Stone, The Linear Complementarity Problem,
 * 1992, 4.4, 4.9).
 *
 * Warm start. At the basis of a complementary z, x_B = b + A x_N is an LCP in x_N, as (40) is in z.
 * (LE1) can begin there with a cover d' > 0 and a perturbation g' > 0, e^2, e^3, .. of that LCP;
 * the proof holds for it. In terms of y these are d = B d' and g = B g', where B has the columns of
 * x_B in (I, -M); so the table can be computed again at any time. If b >= 0, the basis is a
 * solution. d need not be positive: a ray is then no ray of the user's cover, and a cold start
 * follows.
 *
 * Crash start. Before the path crash.c guesses a complementary basis with LU factors, unless
 * `crash` is 0 or a cover is given. If its z has the certificate, z is the answer. Else the guess
 * is dropped, and the path is the same as without it.
 *
 * Rounding. All tests use R M C with powers of two R and C (scale.c), so that the same relative
 * tolerances serve all units. Deviations from (LE1)-(LE8):
 *
 *   (LE9)  c_i < -1e-11 max|c| replaces c_i < 0; b_i / -c_i ties with the least if it is at most
 *          min_k (b_k + 1e-13 max|b|) / -c_k
 *   (LE10) z0 leaves if it ties with 1e-10 for 1e-13: at the end z0 often ties with many others
 *   (LE11) every max(n, 256) pivots, and after a small pivot, b is tested with the user's M. If the
 *          misfit is above 1e-9, and before a ray is accepted, the table is refreshed: computed
 *          again from M by pivoting in the basic variables, each at the row with the largest
 *          coefficient
 *   (LE12) b, and c for a ray, are refined with the user's M, so that answers do not carry the
 *          table's rounding; the table is the approximate inverse
 *   (LE13) an answer must have its certificate, a ray must pass dls_lcp_check_ray. If not, a fresh
 *          table is tried; then the path restarts without (LE10), with 1e-14 for 1e-11 in (LE9),
 *          and with (LE11) every 32 pivots
 *
 * A ray (z, z0) + t (dz, dz0) proves that there is no solution if dz, or a vector near it, is a
 * Farkas vector in exact arithmetic; if M is copositive-plus, dz is one up to rounding. Any other
 * ray proves nothing: other vectors d are tried, unless the user chose d.
 *
 * Cost: 2 n^2 flops per pivot at the rate of dgemm, and O(96 n); memory n (n + 1) + 330 n. The
 * number of pivots can be 2^n (Murty) and usually is n/2 to 3 n.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lcp_internal.h"
#include "linear/blas.h"

static const double pivot_tolerance = 1e-11; /* (LE9), to max|c| */
static const double strict_pivot = 1e-14;    /* (LE9) at the second try */
static const double tie_tolerance = 1e-13;   /* (LE9), to max|b| */
static const double z0_tolerance = 1e-10;    /* (LE10), to max|b| */
static const double lex_tolerance = 1e-9;    /* (LE7), (LE8): relative */
static const double small_pivot = 1e-8;      /* (LE11), to max|c| */
static const double misfit_tolerance = 1e-9; /* (LE11), to 1 + max|b|; max|q| is about 1 */
static const double proof_tolerance = 1e-14; /* of a ray or a Farkas vector, times n + 10 */
static const double golden = 0.6180339887498949;
enum { most_covers = 10 };         /* the first one, and others */
static const double sharp = 1e-12; /* accept a residual below it at once */

enum { progress_interval = 50, check_interval = 256, strict_check_interval = 32 }; /* pivots */
/* Stop after so many rays that are Farkas vectors up to rounding: any solution left is too large
 * for a certificate, but a second ray may prove that there is none. */
enum { most_vectors = 2 };

struct dls_lemke {
  int n; /* of create */
  atomic_int busy;
  dls_lemke_settings settings;
  double *given; /* the user's covering vector, or NULL, n */

  /* The scaled problem: M' = R M C, q' = R q / kappa, d' = sigma R d; z = kappa C z',
   * y = kappa y' / R, z0 = kappa sigma z0'. */
  double *R, *C, *q, *d; /* n */
  double *cover;         /* d without the factors of lemke_choose_cover, n */
  double kappa, sigma;

  /* the path */
  dlsi_table table;
  double *c;      /* the entering column, n */
  double *x, *dx; /* values by variable, and along the entering column, 2n+1 */
  double *g;      /* the perturbation in terms of y, n */
  int *start;     /* basic variables of the start, one of each pair, n */
  int *rows;      /* rows of the ratio test; 1 for a row still without its z, n */
  int *reenter;   /* the basic z, as variables, n+1 */
  int entering;   /* the variable of the ray, if the path ended in one */
  int strict;     /* 1: second try of (LE13) */
  int max_pivots;
  int pivots, refreshes, starts; /* of this solve */

  /* Before the path: its factors share the memory of table.T. */
  dlsi_crash crash;

  double *residual;                       /* n */
  double *work;                           /* scratch, 9 n */
  double *y, *magnitude, *weight, *trial; /* certificate of a trial z, n */
  double *z, *best_y;                     /* the best so far, n */
  dls_lcp_certificate best;

  int solved_n; /* n of the last solve if it ended in a ray, else 0 */
  int proved;   /* 1: farkas is a proof */
  int vectors;  /* rays of this solve that are Farkas vectors up to rounding */
  double *ray_z, *ray_dz, *ray_cover, *farkas; /* n */
  dlsi_judge *judge;                           /* of farkas; NULL: this LCP */
  void *judged;
  double begun;       /* CPU seconds when the solve began; -1: not needed */
  dls_status stopped; /* why: the progress function or the time limit */
  double ray_z0, ray_dz0;
};

/* ---- workspace ------------------------------------------------------------------------------- */

void dls_lemke_settings_init(dls_lemke_settings *settings) {
  if (!settings) return;
  *settings = (dls_lemke_settings){.size = sizeof *settings, .crash = 1};
  dlsi_limits_init(&settings->limits);
}

/* Returns a column length >= n that is no multiple of 512 doubles, so that a row of the table falls
 * on all cache sets. */
static size_t lemke_leading_dimension(size_t n) {
  const size_t ld = (n + 7) / 8 * 8;
  return ld % 512 ? ld : ld + 8;
}

static void lemke_carve(void *workspace, dlsi_arena *arena) {
  dls_lemke *work = workspace;
  const size_t n = (size_t)work->n, ld = lemke_leading_dimension(n), D = sizeof(double);
  dlsi_table_carve(&work->table, arena, n, ld);
  dlsi_crash_carve(&work->crash, arena, n, ld);
  double **vectors[] = {&work->R,      &work->C,      &work->q,         &work->d,
                        &work->c,      &work->y,      &work->trial,     &work->magnitude,
                        &work->weight, &work->z,      &work->ray_z,     &work->ray_dz,
                        &work->cover,  &work->best_y, &work->ray_cover, &work->residual,
                        &work->g,      &work->farkas};
  for (size_t k = 0; k < sizeof vectors / sizeof vectors[0]; k++)
    *vectors[k] = dlsi_take(arena, ld, D);
  work->work = dlsi_take(arena, 9 * n, D);
  work->x = dlsi_take(arena, 2 * n + 1, D);
  work->dx = dlsi_take(arena, 2 * n + 1, D);
  work->rows = dlsi_take(arena, n, sizeof(int));
  work->reenter = dlsi_take(arena, n + 1, sizeof(int));
  work->start = dlsi_take(arena, n, sizeof(int));
  work->crash.factors.A = work->table.T;
  work->crash.s = work->weight;
  if (work->settings.cover) work->given = dlsi_take(arena, n, D);
}

static dls_status lemke_create(dls_lemke **out, int n, const dls_lemke_settings *settings,
                               dls_error *error) {
  if (!out) return dlsi_is_null(error, "out");
  *out = NULL;
  if (n < 1 || n > INT_MAX / 4) return dlsi_fail(error, DLS_E_SIZE, "n", -1, n, "is %d", n);
  dls_lemke work = {.n = n};
  dls_lemke_settings_init(&work.settings);
  if (settings) work.settings = *settings;
  const dls_lemke_settings *s = &work.settings;
  const dlsi_setting own[] = {{"crash", s->crash, 0, 1, 0}};
  dls_status status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 1, own, error);
  if (!status && s->cover) status = dlsi_check_positive("cover", s->cover, n, error);
  void *made = NULL;
  if (!status) status = dlsi_check_blas(error);
  if (!status) status = dlsi_carve_workspace(&made, &work, sizeof work, lemke_carve, "n", n, error);
  if (status) return status;
  dls_lemke *w = *out = made;
  if (s->cover) w->settings.cover = memcpy(w->given, s->cover, (size_t)n * sizeof *w->given);
  return DLS_OK;
}

dls_status dls_lemke_create(dls_lemke **out, int n, const dls_lemke_settings *settings,
                            dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, lemke_create(out, n, settings, error), error);
}

void dls_lemke_destroy(dls_lemke *workspace) {
  free(workspace);
}

void dlsi_lemke_set_limits(dls_lemke *work, const dls_limits *limits) {
  work->settings.limits = *limits;
}

void dlsi_lemke_set_judge(dls_lemke *work, dlsi_judge *judge, void *problem) {
  work->judge = judge;
  work->judged = problem;
}

/* ---- the scaled problem ---------------------------------------------------------------------- */

/* Returns the other variable of the pair of v. */
static int lemke_complement(int n, int v) {
  return v < n ? v + n : v - n;
}

/* cover := R d; without a given d, the row norms of R M C with C = 2^gamma not rounded, so that
 * units do not change d. */
static void lemke_scale_cover(dls_lemke *work, const dls_lcp *lcp, const double *gamma) {
  const int n = lcp->n;
  double *d = work->cover;
  for (int i = 0; i < n; i++)
    d[i] = work->given ? work->R[i] * work->given[i] : 0;
  for (int j = 0; !work->given && j < n; j++) {
    const double *m = dlsi_lcp_column(lcp, j), c = exp2(gamma[j]);
    for (int i = 0; i < n; i++)
      d[i] += (work->R[i] * m[i] * c) * (work->R[i] * m[i] * c);
  }
  for (int i = 0; !work->given && i < n; i++)
    d[i] = d[i] > 0 ? sqrt(d[i]) : 1;
}

static void lemke_scale(dls_lemke *work, const dls_lcp *lcp) {
  const int n = lcp->n;
  double *rho = work->R, *gamma = work->C;
  dlsi_lcp_equilibrate(lcp, rho, gamma, work->work);
  for (int i = 0; i < n; i++) {
    work->R[i] = dlsi_power_of_two(rho[i]);
    work->q[i] = work->R[i] * lcp->q[i];
  }
  lemke_scale_cover(work, lcp, gamma);
  work->sigma = dlsi_power_of_two(-log2(dlsi_max_abs(work->cover, (size_t)n)));
  const double largest = dlsi_max_abs(work->q, (size_t)n);
  work->kappa = largest > 0 ? ldexp(1, ilogb(largest)) : 1; /* exact; log2 rounds by its size */
  for (int i = 0; i < n; i++) {
    work->C[i] = dlsi_power_of_two(gamma[i]);
    work->cover[i] *= work->sigma;
    work->q[i] /= work->kappa;
  }
}

/* Returns a number in [0, 1) for row i of covering vector k > 0. */
static double lemke_spread(int i, int k) {
  const double x = golden * (i + 1) + 0.7548776662466927 * k;
  return x - floor(x);
}

/* d := covering vector k: vector 0 times factors between 1/32 and 32, no two alike, if k > 0. */
static void lemke_choose_cover(dls_lemke *work, int n, int k) {
  double fraction = 0;
  for (int i = 0; i < n; i++) {
    work->d[i] = k ? work->cover[i] * exp2(10 * lemke_spread(i, k) - 5) : work->cover[i];
    fraction += golden; /* no two alike */
    fraction -= fraction >= 1;
    work->g[i] = 1 + fraction;
    work->start[i] = i;
  }
}

/* ---- the table of a basis -------------------------------------------------------------------- */

/* Loads the table of the basis y: y = q' + M' z' + d' z0. */
static void lemke_load_table(dls_lemke *work, const dls_lcp *lcp) {
  const int n = lcp->n;
  dlsi_table *table = &work->table;
  table->n = n;
  table->pending = 0;
  for (int j = 0; j < n; j++) {
    const double *m = dlsi_lcp_column(lcp, j);
    double *a = table->T + (size_t)j * (size_t)table->ld;
    for (int i = 0; i < n; i++)
      a[i] = work->R[i] * m[i] * work->C[j];
  }
  for (int j = 0; j <= n; j++) {
    table->column[j] = n + j;
    table->where[n + j] = -1 - j;
    table->born[j] = -1;
  }
  double *last = table->T + (size_t)n * (size_t)table->ld; /* z0's column */
  for (int i = 0; i < n; i++) {
    last[i] = work->d[i];
    table->b[i] = work->q[i];
    table->g[i] = work->g[i];
    table->basic[i] = table->where[i] = i;
  }
}

/* Loads the table of the basis in which the `count` variables of work->reenter replace the y_j with
 * work->rows[j] = 1. Returns 0 if that basis is singular. */
static int lemke_enter_basis(dls_lemke *work, const dls_lcp *lcp, int count) {
  const int n = lcp->n;
  dlsi_table *table = &work->table;
  lemke_load_table(work, lcp);
  for (int k = 0; k < count; k++) {
    const int s = -1 - table->where[work->reenter[k]];
    int r = -1;
    dlsi_table_column(table, s, work->c);
    for (int i = 0; i < n; i++)
      if (work->rows[i] && (r < 0 || fabs(work->c[i]) > fabs(work->c[r]))) r = i;
    if (r < 0 || !(fabs(work->c[r]) > 0)) return 0;
    work->rows[r] = 0;
    dlsi_table_exchange(table, r, s, work->c);
  }
  return 1;
}

/* (LE11) Computes the table of the present basis from the user's M; returns 0 if it is singular. */
static int lemke_refresh(dls_lemke *work, const dls_lcp *lcp) {
  const dlsi_table *table = &work->table;
  int count = 0;
  for (int i = 0; i < lcp->n; i++) {
    work->rows[i] = table->where[i] < 0;
    if (table->basic[i] >= lcp->n) work->reenter[count++] = table->basic[i];
  }
  work->refreshes++;
  return lemke_enter_basis(work, lcp, count);
}

/* (LE0) Makes z_i basic if z_i > 0, else y_i. Forms d = B d', g = B g' by the columns e_i or -M'_i
 * of B. Returns 0 if that basis is singular. */
static int lemke_enter_warm_basis(dls_lemke *work, const dls_lcp *lcp, const double *z) {
  const int n = lcp->n;
  double *d = work->work, *g = work->work + n;
  int count = 0;
  memset(d, 0, 2 * (size_t)n * sizeof *d);
  for (int i = 0; i < n; i++) {
    const int in = z[i] > 0;
    work->rows[i] = in;
    work->start[i] = in ? n + i : i;
    if (!in) {
      d[i] += work->d[i];
      g[i] += work->g[i];
      continue;
    }
    work->reenter[count++] = n + i;
    const double *m = dlsi_lcp_column(lcp, i);
    for (int k = 0; k < n; k++) {
      const double a = work->R[k] * m[k] * work->C[i];
      d[k] -= a * work->d[i];
      g[k] -= a * work->g[i];
    }
  }
  memcpy(work->d, d, (size_t)n * sizeof *d);
  memcpy(work->g, g, (size_t)n * sizeof *g);
  return lemke_enter_basis(work, lcp, count);
}

/* ---- values by variable ---------------------------------------------------------------------- */

/* x := values by variable: b for the basic ones, 0 for others. For dx pass c as b, and `entering`,
 * whose value is 1. */
static void lemke_read_values(const dlsi_table *table, const double *b, int entering, double *x) {
  memset(x, 0, (2 * (size_t)table->n + 1) * sizeof *x);
  for (int i = 0; i < table->n; i++)
    x[table->basic[i]] = b[i];
  if (entering >= 0) x[entering] = 1;
}

/* residual := M' z' + d' z0 + h q' - y' of values x by variable; returns its max norm. */
static double lemke_misfit(dls_lemke *work, const dls_lcp *lcp, const double *x, double h) {
  const size_t n = (size_t)lcp->n;
  double *f = work->residual;
  memset(f, 0, n * sizeof *f);
  for (size_t j = 0; j < n; j++) {
    const double *m = dlsi_lcp_column(lcp, (int)j), z = work->C[j] * x[n + j];
    if (z == 0) continue;
    for (size_t i = 0; i < n; i++)
      f[i] += m[i] * z;
  }
  for (size_t i = 0; i < n; i++)
    f[i] = work->R[i] * f[i] + (work->d[i] * x[2 * n] + h * work->q[i] - x[i]);
  return dlsi_max_abs(f, n);
}

/* (LE12) Refines x until the residual f is rounding or does not halve. A nonbasic y_i is f_i
 * instead of 0: it moves by -f_i, and the basic variables follow. A basic y_i takes up f_i. */
static void lemke_refine(dls_lemke *work, const dls_lcp *lcp, double *x, double h) {
  const dlsi_table *table = &work->table;
  const int n = lcp->n;
  double before = INFINITY, *dx = work->work;
  for (int sweep = 0; sweep < 4; sweep++) {
    const double f = lemke_misfit(work, lcp, x, h);
    if (!(f > DBL_EPSILON * (h + dlsi_max_abs(x, 2 * (size_t)n + 1))) || !(f < 0.5 * before))
      return;
    before = f;
    for (int i = 0; i < n; i++)
      if (table->where[i] >= 0)
        x[i] += work->residual[i];
      else
        work->residual[i] = -work->residual[i];
    dlsi_table_move_y(table, work->residual, dx);
    for (int k = 0; k < n; k++)
      x[table->basic[k]] += dx[k];
  }
}

/* ---- the ratio test -------------------------------------------------------------------------- */

enum { no_row = -1, not_finite = -2 };

/* Keeps those of rows[0..count) whose value[k] is smallest up to rounding; returns their
 * number. */
static int ratio_keep_smallest(int count, int *rows, const double *value) {
  const double largest = dlsi_max_abs(value, (size_t)count);
  double smallest = INFINITY;
  int kept = 0;
  for (int k = 0; k < count; k++)
    if (value[k] < smallest) smallest = value[k];
  for (int k = 0; k < count; k++)
    if (value[k] <= smallest + lex_tolerance * largest) rows[kept++] = rows[k];
  return kept;
}

/* value_k := (LE5) / -c_i for the rows i = rows[k]. v: basic variable j of the start (y_j if cold).
 * The coefficient of e^(j+2) is -a_is if v stands in column s, 1 if v is basic in row i, else 0.
 * a: scratch, n. */
static void ratio_perturbation(const dlsi_table *table, int v, int count, const int *rows,
                               const double *c, double *a, double *value) {
  const int where = table->where[v];
  if (where < 0) dlsi_table_column(table, -1 - where, a);
  for (int k = 0; k < count; k++) {
    const int i = rows[k];
    value[k] = where < 0 ? a[i] / c[i] : where == i ? -1 / c[i] : 0;
  }
}

/* (LE6) Keeps those of rows[0..count), all with c < 0, that tie by (LE9), and returns their number;
 * -1 if z0 may leave by (LE10). */
static int ratio_keep_ties(const dls_lemke *work, int count, int *rows, double bmax) {
  const dlsi_table *table = &work->table;
  const double *b = table->b, *c = work->c;
  const double tie = tie_tolerance * bmax, tie0 = (work->strict ? tie : z0_tolerance * bmax);
  const int z0 = table->where[2 * table->n];
  double bound = INFINITY, bound0 = INFINITY;
  int tied = 0, waits = 0;
  for (int k = 0; k < count; k++) {
    const double bk = b[rows[k]] > 0 ? b[rows[k]] : 0, a = -c[rows[k]];
    if (bk + tie < bound * a) bound = (bk + tie) / a;
    if (bk + tie0 < bound0 * a) bound0 = (bk + tie0) / a;
    waits |= rows[k] == z0;
  }
  if (waits && b[z0] <= -bound0 * c[z0]) return -1;
  for (int k = 0; k < count; k++)
    if (b[rows[k]] <= -bound * c[rows[k]]) rows[tied++] = rows[k];
  return tied;
}

/* (LE3) Returns the row that leaves when column c enters, by (LE6)-(LE10); cmax = max|c|. */
static int ratio_leaving_row(dls_lemke *work, double cmax) {
  const dlsi_table *table = &work->table;
  const int n = table->n;
  const double *c = work->c, bmax = dlsi_max_abs(table->b, (size_t)n);
  if (!isfinite(cmax) || !isfinite(bmax)) return not_finite;
  const double least = -(work->strict ? strict_pivot : pivot_tolerance) * cmax;
  int *rows = work->rows, count = 0;
  for (int i = 0; i < n; i++) {
    rows[count] = i;
    count += c[i] < least;
  }
  if (count == 0) return no_row;
  double *value = work->work;
  int tied = ratio_keep_ties(work, count, rows, bmax);
  if (tied < 0) return table->where[2 * n];
  for (int k = 0; tied > 1 && k < tied; k++) /* (LE7) */
    value[k] = table->g[rows[k]] / -c[rows[k]];
  if (tied > 1) tied = ratio_keep_smallest(tied, rows, value);
  for (int j = 0; tied > 1 && j < n; j++) { /* (LE8) */
    ratio_perturbation(table, work->start[j], tied, rows, c, work->work + n, value);
    tied = ratio_keep_smallest(tied, rows, value);
  }
  int r = rows[0];
  for (int k = 1; k < tied; k++) /* several are left only if rounding hides the difference */
    if (c[rows[k]] < c[r]) r = rows[k];
  return r;
}

/* (LE1) Returns the row that leaves when z0 enters. c: column of z0. Ties as in (LE7), (LE8), where
 * the last of the rows (e_i / c_i) is lexicographically smallest. Returns no_row if b >= 0
 * (solved), not_finite if rounding has lost c > 0. */
static int ratio_first_row(const dlsi_table *table, const double *c) {
  const int n = table->n;
  double least = INFINITY, size = 0, smallest = INFINITY;
  int r = no_row;
  for (int i = 0; i < n; i++) {
    if (!(c[i] > 0)) return not_finite;
    if (table->b[i] < least * c[i]) least = table->b[i] / c[i];
    if (fabs(table->b[i]) > size * c[i]) size = fabs(table->b[i]) / c[i];
  }
  if (least >= -tie_tolerance * size) return no_row;
  for (int i = 0; i < n; i++)
    if (table->b[i] / c[i] <= least + tie_tolerance * size && table->g[i] / c[i] <= smallest) {
      smallest = table->g[i] / c[i];
      r = i;
    }
  return r;
}

/* ---- the path -------------------------------------------------------------------------------- */

typedef enum path_end { path_solved, path_ray, path_limit, path_cancelled, path_lost } path_end;

/* Reports z (n) to the user's progress function; scaled: z is of the scaled problem. Returns 1 to
 * stop, for the reason work->stopped. */
static int lemke_report(dls_lemke *work, double residual, const double *z, int scaled) {
  const dls_limits *limits = &work->settings.limits;
  if (!limits->progress && !(limits->cpu_seconds > 0)) return 0;
  for (int j = 0; j < work->table.n; j++) {
    const double zj = scaled ? work->kappa * work->C[j] * z[j] : z[j];
    work->trial[j] = zj > 0 ? zj : 0;
  }
  dls_progress progress = {
      "lemke", "lemke", work->pivots + work->crash.rounds, work->max_pivots, residual, work->trial,
      0,       0};
  work->stopped = dlsi_tell(limits, work->begun, &progress);
  return work->stopped != DLS_OK;
}

/* Estimates the residual while z0 > 0: z0 |d| / |q|, since y - d z0 >= -d z0. */
static double lemke_residual_estimate(const dls_lemke *work) {
  const dlsi_table *table = &work->table;
  const size_t n = (size_t)table->n;
  const double z0 = table->where[2 * n] < 0 ? 0 : table->b[table->where[2 * n]];
  return z0 * dlsi_norm2(work->d, n) / dlsi_norm2(work->q, n);
}

/* Reports the point of the path, with an estimate of its residual. */
static int path_report(dls_lemke *work) {
  if (!work->settings.limits.progress && !(work->settings.limits.cpu_seconds > 0)) return 0;
  lemke_read_values(&work->table, work->table.b, -1, work->x);
  return lemke_report(work, lemke_residual_estimate(work), work->x + work->table.n, 1);
}

/* (LE4) Pivots at row r, column s. Returns the variable that left; its complement enters next. */
static int path_exchange(dls_lemke *work, int r, int s) {
  dlsi_table *table = &work->table;
  const int out = table->basic[r];
  dlsi_table_exchange(table, r, s, work->c);
  work->pivots++;
  if (out != 2 * table->n) work->entering = lemke_complement(table->n, out);
  return out;
}

/* (LE11) Returns 1 if b fits the user's M. */
static int path_fits(dls_lemke *work, const dls_lcp *lcp) {
  const dlsi_table *table = &work->table;
  lemke_read_values(table, table->b, -1, work->x);
  return lemke_misfit(work, lcp, work->x, 1) <=
         misfit_tolerance * (1 + dlsi_max_abs(table->b, (size_t)table->n));
}

/* Follows the path to its end, from the basis of z, or of y if z is NULL. */
static path_end path_follow(dls_lemke *work, const dls_lcp *lcp, const double *z) {
  dlsi_table *table = &work->table;
  const int n = lcp->n, longest = n > check_interval ? n : check_interval;
  const int interval = work->strict ? strict_check_interval : longest;
  int fresh = 0, unchecked = 0;
  if (!z)
    lemke_load_table(work, lcp);
  else if (!lemke_enter_warm_basis(work, lcp, z)) /* (LE0) */
    return path_lost;
  int s = -1 - table->where[2 * n];
  dlsi_table_column(table, s, work->c);
  int r = ratio_first_row(table, work->c); /* (LE1) */
  if (r < 0) return r == no_row ? path_solved : path_lost;
  path_exchange(work, r, s);
  for (;;) {
    if (work->pivots >= work->max_pivots) return path_limit;
    if (work->pivots % progress_interval == 0 && path_report(work)) return path_cancelled;
    s = -1 - table->where[work->entering];
    dlsi_table_column(table, s, work->c); /* (LE2) */
    const double cmax = dlsi_max_abs(work->c, (size_t)n);
    r = ratio_leaving_row(work, cmax); /* (LE3) */
    if (r < 0) {
      if (fresh) return r == no_row ? path_ray : path_lost;
      if (!lemke_refresh(work, lcp)) return path_lost;
      fresh = 1;
      continue;
    }
    const double pivot = fabs(work->c[r]);
    if (path_exchange(work, r, s) == 2 * n) return path_solved; /* (LE4) */
    fresh = 0;
    if (++unchecked < interval && pivot >= small_pivot * cmax) continue;
    unchecked = 0;
    fresh = !path_fits(work, lcp); /* (LE11) */
    if (fresh && !lemke_refresh(work, lcp)) return path_lost;
  }
}

/* ---- answers --------------------------------------------------------------------------------- */

/* Returns the residual, or 4 times the rounding level if that is larger: a z that has run away may
 * have residual 0. */
static double lemke_error(const dls_lcp_certificate *certificate) {
  const double hidden = 4 * certificate->floor;
  return hidden > certificate->residual ? hidden : certificate->residual;
}

/* Certifies max(0, z), or max(0, kappa C z) of a scaled z; keeps it if it is the best so far. */
static void lemke_offer(dls_lemke *work, const dls_lcp *lcp, const double *z, int scaled) {
  const size_t n = (size_t)lcp->n;
  dls_lcp_certificate certificate;
  for (size_t j = 0; j < n; j++) {
    const double zj = scaled ? work->kappa * work->C[j] * z[j] : z[j];
    work->trial[j] = zj > 0 ? zj : 0;
  }
  dlsi_lcp_multiply(lcp, lcp->q, work->trial, work->y, work->magnitude);
  dlsi_lcp_measure(lcp, work->trial, work->y, work->magnitude, work->weight, &certificate);
  if (!(lemke_error(&certificate) < lemke_error(&work->best))) return;
  work->best = certificate;
  memcpy(work->z, work->trial, n * sizeof *work->z);
  memcpy(work->best_y, work->y, n * sizeof *work->best_y);
}

/* Makes z = 0 the best so far, [C] (41). */
static void lemke_offer_zero(dls_lemke *work, const dls_lcp *lcp) {
  const size_t n = (size_t)lcp->n;
  memset(work->work, 0, n * sizeof *work->work);
  memset(work->z, 0, n * sizeof *work->z);
  memcpy(work->best_y, lcp->q, n * sizeof *work->best_y);
  work->best = (dls_lcp_certificate){.residual = INFINITY, .negative_y = INFINITY};
  lemke_offer(work, lcp, work->work, 0);
}

static int lemke_holds(const dls_lemke *work, double tol) {
  return dls_lcp_certificate_holds(&work->best, tol);
}

/* Returns 1 if the best so far holds to min(tol, 1e-12). */
static int lemke_is_sharp(const dls_lemke *work) {
  const double tol = work->settings.limits.tol;
  return lemke_holds(work, tol < sharp ? tol : sharp);
}

/* (LE13) for a solution: returns 1 if the table, or a fresh one, gives a sharp one. */
static int lemke_accept_solution(dls_lemke *work, const dls_lcp *lcp) {
  for (int anew = 0; anew < 2; anew++) {
    if (anew && !lemke_refresh(work, lcp)) return 0;
    lemke_read_values(&work->table, work->table.b, -1, work->x);
    lemke_refine(work, lcp, work->x, 1);
    lemke_offer(work, lcp, work->x + lcp->n, 1);
    if (lemke_is_sharp(work)) return 1;
  }
  return 0;
}

/* (LE13) for a ray on a fresh table: returns 1 if it is one. */
static int lemke_accept_ray(dls_lemke *work, const dls_lcp *lcp) {
  const size_t n = (size_t)lcp->n;
  double *x = work->x, *dx = work->dx;
  lemke_read_values(&work->table, work->table.b, -1, x);
  lemke_read_values(&work->table, work->c, work->entering, dx);
  lemke_refine(work, lcp, x, 1);
  lemke_refine(work, lcp, dx, 0);
  lemke_offer(work, lcp, x + n, 1);
  const double least = strict_pivot * dlsi_max_abs(dx, 2 * n + 1);
  const double tolerance = proof_tolerance * (double)(n + 10);
  for (size_t j = 0; j < n; j++) {
    work->ray_z[j] = x[n + j] > 0 ? work->kappa * work->C[j] * x[n + j] : 0;
    work->ray_dz[j] = dx[n + j] > least ? work->C[j] * dx[n + j] : 0;
    work->ray_cover[j] = work->d[j] / work->R[j] / work->sigma;
  }
  const double size = dlsi_max_abs(work->ray_dz, n);
  for (size_t j = 0; j < n; j++)
    work->ray_dz[j] /= size; /* dz = 0 gives NaN, which is no ray */
  work->ray_z0 = work->kappa * work->sigma * x[2 * n];
  work->ray_dz0 = dx[2 * n] > least ? work->sigma * dx[2 * n] / size : 0;
  if (!(dlsi_lcp_ray_violation(lcp, work->ray_cover, work->ray_z, work->ray_z0, work->ray_dz,
                               work->ray_dz0, work->work) <= tolerance))
    return 0;
  work->solved_n = lcp->n;
  if (!(dlsi_lcp_farkas_violation(lcp, work->ray_dz) <= tolerance)) return 1;
  work->vectors++;
  memcpy(work->farkas, work->ray_dz, n * sizeof *work->farkas);
  work->proved = work->judge ? work->judge(work->judged, work->farkas, work->work)
                             : dlsi_lcp_find_proof(lcp, work->farkas, work->work);
  return 1;
}

/* ---- starts ---------------------------------------------------------------------------------- */

/* Runs up to max_pivots rounds of crash.c from the basis of z, or of y if z is NULL; returns
 * path_lost if they find no solution. */
static path_end lemke_crash(dls_lemke *work, const dls_lcp *lcp, const double *z) {
  dlsi_crash *crash = &work->crash;
  int outcome = 0;
  dlsi_crash_begin(lcp, z, crash);
  while (outcome == 0 && crash->rounds < work->max_pivots) {
    outcome = dlsi_crash_round(lcp, crash);
    if (lemke_report(work, -1, crash->z, 0)) return path_cancelled;
  }
  if (outcome <= 0) return path_lost;
  lemke_offer(work, lcp, crash->z, 0);
  if (lemke_is_sharp(work)) return path_solved;
  lemke_offer_zero(work, lcp);
  return path_lost;
}

/* Follows paths until one decides the problem. After an end that is not confirmed the path is
 * strict (LE13). After a ray that proves nothing it has another covering vector. */
static dls_status lemke_paths(dls_lemke *work, const dls_lcp *lcp, const double *warm) {
  const double tol = work->settings.limits.tol;
  int cover = 0;
  work->strict = 0;
  lemke_scale(work, lcp);
  for (;; warm = NULL) {
    lemke_choose_cover(work, lcp->n, cover);
    const path_end end = path_follow(work, lcp, warm);
    work->starts++;
    if (end == path_ray && warm) continue; /* not a ray of the user's cover */
    if (end == path_ray && lemke_accept_ray(work, lcp)) {
      if (lemke_holds(work, tol)) break; /* z0 was as good as 0 */
      if (work->proved) return DLS_NO_SOLUTION;
      if (work->given || work->vectors == most_vectors || ++cover == most_covers) return DLS_RAY;
      continue;
    }
    work->solved_n = 0;
    if (end == path_solved && lemke_accept_solution(work, lcp)) return DLS_OK;
    if (end == path_limit || end == path_cancelled) {
      lemke_read_values(&work->table, work->table.b, -1, work->x);
      lemke_offer(work, lcp, work->x + lcp->n, 1);
      if (lemke_holds(work, tol)) return DLS_OK;
      return end == path_limit ? DLS_MAX_ITERATIONS : work->stopped;
    }
    if (warm) continue;
    if (work->strict) return lemke_holds(work, tol) ? DLS_OK : DLS_STALLED;
    work->strict = 1;
  }
  work->solved_n = work->proved = 0;
  return DLS_OK;
}

/* Checks the arguments of a solve and enters the workspace. */
static dls_status lemke_enter(dls_lemke *work, const dls_lcp *lcp, const double *z,
                              dls_error *error) {
  if (!work) return dlsi_is_null(error, "workspace");
  dls_status status = dlsi_check_dense_lcp(lcp, error);
  if (!status)
    status = dlsi_check_lcp_solve(work->n, lcp, z, work->settings.limits.warm_start, error);
  return status ? status : dlsi_enter(&work->busy, "workspace", error);
}

dls_status dlsi_lemke_run(dls_lemke *work, const dls_lcp *lcp, double *z, double *y,
                          dls_lemke_info *info) {
  dls_status status = DLS_OK;
  const size_t n = (size_t)lcp->n;
  const dls_limits *limits = &work->settings.limits;
  const double *warm = limits->warm_start ? z : NULL;
  const int most = lcp->n < (INT_MAX - 1000) / 500 ? 50 * lcp->n + 1000 : INT_MAX / 10;
  work->max_pivots = dlsi_most_iterations(limits, most);
  work->begun = dlsi_clock_start(limits);
  work->table.n = lcp->n;
  work->pivots = work->refreshes = work->starts = work->crash.rounds = 0;
  work->solved_n = work->proved = work->vectors = 0;
  dlsi_lcp_weights(lcp, work->weight);
  lemke_offer_zero(work, lcp);
  if (work->best.negative_y > 0) {
    path_end end = path_lost;
    if (work->settings.crash && !work->given) end = lemke_crash(work, lcp, warm);
    if (end == path_lost)
      status = lemke_paths(work, lcp, warm);
    else if (end == path_cancelled)
      status = work->stopped;
  }
  memcpy(z, work->z, n * sizeof *z);
  if (y) memcpy(y, work->best_y, n * sizeof *y);
  if (info)
    *info = (dls_lemke_info){status,       work->pivots,    work->best,
                             work->starts, work->refreshes, work->crash.rounds};
  return status;
}

dls_status dls_lemke_solve(dls_lemke *workspace, const dls_lcp *lcp, double *z, double *y,
                           dls_lemke_info *info, dls_error *error) {
  DLSI_DOOR;
  dls_lemke *work = workspace;
  dls_status status = lemke_enter(work, lcp, z, error);
  if (status) return dlsi_at(__func__, status, error);
  status = dlsi_lemke_run(work, lcp, z, y, info);
  dlsi_tell_last(&work->settings.limits, work->begun, "lemke", "lemke",
                 work->pivots + work->crash.rounds, work->best.residual, z);
  return dlsi_leave(&work->busy, status);
}

/* ---- the proof of a ray ---------------------------------------------------------------------- */

static dls_status lemke_check_end(const dls_lemke *work, int ended, const char *other,
                                  dls_error *error) {
  if (!work) return dlsi_is_null(error, "workspace");
  return ended ? DLS_OK : dlsi_fail(error, DLS_E_ARGUMENT, "workspace", -1, 0, "%s", other);
}

dls_status dls_lemke_ray(const dls_lemke *workspace, double *z, double *z0, double *dz, double *dz0,
                         double *cover, dls_error *error) {
  DLSI_DOOR;
  const dls_lemke *work = workspace;
  const dls_status status =
      lemke_check_end(work, work && work->solved_n, "the last solve did not end in a ray", error);
  if (status) return dlsi_at(__func__, status, error);
  const size_t n = (size_t)work->solved_n;
  if (z) memcpy(z, work->ray_z, n * sizeof *z);
  if (z0) *z0 = work->ray_z0;
  if (dz) memcpy(dz, work->ray_dz, n * sizeof *dz);
  if (dz0) *dz0 = work->ray_dz0;
  if (cover) memcpy(cover, work->ray_cover, n * sizeof *cover);
  return DLS_OK;
}

dls_status dls_lemke_farkas(const dls_lemke *workspace, double *v, dls_error *error) {
  DLSI_DOOR;
  const dls_lemke *work = workspace;
  dls_status status =
      lemke_check_end(work, work && work->proved, "the last solve proved nothing", error);
  if (!status && !v) status = dlsi_is_null(error, "v");
  if (!status) memcpy(v, work->farkas, (size_t)work->solved_n * sizeof *v);
  return dlsi_at(__func__, status, error);
}
