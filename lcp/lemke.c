/*
 * lemke.c: Lemke's method for LCP(M, q), [Chabrand 1998] 4.3 (40)-(49).
 *
 *   y = M z + d z0 + q,   y, z >= 0,  z0 >= 0,  y_i z_i = 0       [C] (42) with d = 1
 *
 * kept as a table x_B = b + A x_N (table.c), from z0 large enough for y >= 0 down to z0 = 0:
 *
 *   (L0) warm start only: see below
 *   (L1) z0 enters, y_r leaves, r = argmin q_i / d_i                                [C] (43)-(45)
 *   (L2) the complement of the variable that left enters: column c of A
 *   (L3) x_r leaves, r = argmin { b_i / -c_i : c_i < 0 }; no such i: a ray, stop        (46), (49)
 *   (L4) exchange; if z0 left, b is a solution, else (L2)                            (47)-(48)
 *
 * Ties. Replace q by q(e) = q + e g + (e^2, .., e^(n+1)), g > 0, e -> 0+. The basic variables
 * become b + e g' + .., g' being g carried through the exchanges as b is; and because to move q_j
 * is to move y_j the other way, the coefficient of e^(j+2) in row i is
 *
 *   (L5) l_ij = -a_is if y_j stands in column s;  if y_j is basic, 1 in its row, else 0.
 *
 * (L3) compares (R1) b_i / -c_i, among ties (R2) g'_i / -c_i, among ties (R3) l_ij / -c_i for
 * j = 0, 1, .. One column for (R3) costs what one for (L2) does, and with the g taken (R3) hardly
 * ever starts.
 *
 * It ends. (l_ij) is the inverse of the basis, so the rows (b_i, g'_i, l_i) are linearly
 * independent, no two are proportional, and (R1)-(R3) always leave one r. All rows stay
 * lexicographically positive, as they are after (L1) by the same choice. So for small e > 0 the
 * path is that of the problem q(e), which is not degenerate: an almost complementary basis has at
 * most two neighbours (one for each of the pair that is not basic), the first basis has only one
 * (on the other side lies the primary ray), hence no basis comes twice, and there are finitely
 * many (Lemke, Management Science 11, 1965, 681-689; Cottle, Pang, Stone, The Linear
 * Complementarity Problem, 1992, 4.4, 4.9).
 *
 * Warm start. (L0) At the basis of a complementary z, x_B = b + A x_N is an LCP in x_N as (40) is in z:
 * (L1) can begin there with a cover d' > 0 and a perturbation g' > 0, e^2, e^3, .. of its own, and all
 * that was said holds for it. In y these are d = B d' and g = B g', B being the columns of x_B in
 * (I, -M), so that the table can be computed anew at any time. If b >= 0 there is nothing to do. d need
 * not be positive: a ray is no ray of the user's cover then, and the cold start is tried instead.
 *
 * Crash start. Before all this, unless it is switched off or a cover is given, crash.c guesses a
 * complementary basis with LU factors; up to ten unknowns and without a warm start, tiny.c follows a path
 * of its own instead. If the z has the certificate, that is the answer; else nothing of it is kept
 * and the path is what it would have been. (After tiny.c, crash.c has its turn.)
 *
 * Rounding. Decisions are taken on R M C with powers of two R and C (scale.c), so that the same
 * relative tolerances serve all units. Deviations from the above:
 *
 *   (T1) c_i < -1e-11 max|c| for c_i < 0; b_i / -c_i is a tie with the least if it is at most the
 *        least (b_i + 1e-13 max|b|) / -c_i
 *   (T2) z0 leaves where this holds with 1e-10: at the end it is commonly tied with many others
 *   (T3) now and then, and after an exchange on a small pivot, b is put into the user's M; if it
 *        does not fit to 1e-9, and before a ray is believed, the table is computed anew
 *        ("refreshed"): from M, the basic variables are exchanged in, each at the row with the
 *        largest coefficient
 *   (T4) answers do not carry the table's rounding: b, and c for a ray, are refined with the user's
 *        M, the table serving as approximate inverse
 *   (T5) an answer must have its certificate, a ray must pass dls_lcp_check_ray; if not, once
 *        more on a fresh table, then from the start without (T2), with 1e-14 in (T1) and (T3)
 *        more often
 *
 * A ray (z, z0) + t (dz, dz0) with v = dz a Farkas proof (so if M is copositive-plus) means that
 * there is no solution. Another ray means nothing: unless the user chose d, other vectors d are
 * tried.
 *
 * Cost: 2 n^2 flops per exchange at the rate of dgemm, and O(96 n); memory n (n + 1) + 320 n. The
 * number of exchanges can be 2^n (Murty) and usually is n/2 to 3 n.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/base.h"
#include "lcp_internal.h"

static const double pivot_tolerance = 1e-11; /* (T1), to max|c| */
static const double strict_pivot = 1e-14;    /* the same at the second try */
static const double tie_tolerance = 1e-13;   /* (T1), to max|b| */
static const double z0_tolerance = 1e-10;    /* (T2), to max|b| */
static const double lex_tolerance = 1e-9;    /* (R2), (R3): relative */
static const double small_pivot = 1e-8;      /* (T3), to max|c| */
static const double misfit_tolerance = 1e-9; /* (T3), to 1 + max|b|; max|q| is about 1 */
static const double proof_tolerance = 1e-14; /* of a ray or a Farkas vector, times n + 10 */
static const double sharp = 1e-12;           /* a residual that calls for no second look */

enum { progress_interval = 50, check_interval = 256, strict_check_interval = 32 }; /* pivots */
enum { covers = 10 };

struct dls_lemke {
  int n; /* of create */
  dls_lemke_settings settings;
  double *given; /* n of create: the user's covering vector, or NULL */
  dlsi_table table;

  /* The scaled problem: M' = R M C, q' = R q / kappa, d' = sigma R d; z = kappa C z',
   * y = kappa y' / R, z0 = kappa sigma z0'. */
  double *R, *C, *q, *d, *cover; /* d: factors times cover, the given or default one */
  double kappa, sigma;

  double *c;             /* n: the entering column */
  double *x, *dx;        /* 2n+1: values by variable, and along the entering column */
  double *residual;      /* n */
  double *work;          /* 6 n */
  int *rows;             /* 2 n */
  int *reenter;          /* n+1 */
  double *g;             /* n: the perturbation, as y would feel it */
  int *start;            /* n: basic variables of the start, one of each pair */
  int pivots, refreshes; /* of this solve */
  dlsi_crash crash;      /* in the memory of the table */

  double *y, *magnitude, *weight, *trial; /* n: certificate of a trial z */
  double *z, *best_y;                     /* n: the best so far */
  dls_lcp_certificate best;

  int solved_n; /* n of the last solve if it ended in a ray, else 0 */
  int proved;   /* ray_dz is a Farkas proof */
  double *ray_z, *ray_dz, *ray_cover;
  double ray_z0, ray_dz0;
};

/* ---- workspace ------------------------------------------------------------------------------- */

void dls_lemke_settings_init(dls_lemke_settings *settings) {
  if (!settings) return;
  *settings = (dls_lemke_settings){.size = sizeof *settings, .crash = 1};
  dlsi_limits_init(&settings->limits);
}

/* A column length that is no multiple of 512 doubles: a row of T then falls on all cache sets. */
static size_t leading_dimension(size_t n) {
  const size_t ld = (n + 7) / 8 * 8;
  return ld % 512 ? ld : ld + 8;
}

static void carve(dls_lemke *w, dlsi_arena *arena) {
  const size_t n = (size_t)w->n, block = dlsi_table_block;
  const size_t ld = leading_dimension(n);
  dlsi_table *t = &w->table;
  if (n + 1 > (size_t)-1 / sizeof(double) / ld) {
    arena->failed = 1;
    return;
  }
  t->ld = (int)ld;
  t->T = dlsi_take(arena, ld * (n + 1), sizeof(double));
  double **vectors[] = {&t->b,        &t->g,      &w->R,     &w->C,      &w->q,
                        &w->d,        &w->c,      &w->y,     &w->trial,  &w->magnitude,
                        &w->weight,   &w->z,      &w->ray_z, &w->ray_dz, &w->ray_cover,
                        &w->residual, &w->best_y, &w->cover, &w->g};
  const size_t count = sizeof vectors / sizeof vectors[0];
  double *all =
      dlsi_take(arena, (3 * n + 2 + block) * block + ld * (count + 10) + 2, sizeof(double));
  int *ints = dlsi_take(arena, 9 * n + 4 + block, sizeof(int));
  if (w->settings.cover) w->given = dlsi_take(arena, n, sizeof(double));
  if (!all || !ints) return; /* only the sizes are asked for, or there is an overflow */
  t->U = all;
  t->V = t->U + n * block;
  t->W = t->V + (n + 1) * block;
  t->L = t->W + (n + 1) * block;
  all = t->L + block * block;
  for (size_t k = 0; k < count; k++)
    *vectors[k] = all + k * ld;
  w->work = all + count * ld;
  w->x = w->work + 6 * ld;
  w->dx = w->x + 2 * n + 1;
  t->row = ints;
  t->basic = t->row + block;
  t->column = t->basic + n;
  t->where = t->column + n + 1;
  t->born = t->where + 2 * n + 1;
  w->rows = t->born + n + 1;
  w->reenter = w->rows + 2 * n;
  w->start = w->reenter + n + 1;

  dlsi_crash *k = &w->crash;
  int **indices[] = {&k->in,    &k->wrong, &k->base,   &k->pivots,
                     &k->place, &k->slot,  &k->differ, &k->differ_pivots};
  k->S = t->T;
  k->s = w->weight;
  k->z = w->trial;
  k->y = w->y;
  k->a = w->magnitude;
  k->b = w->x;
  k->x = w->dx;
  k->v = w->work;
  for (size_t l = 0; l < sizeof indices / sizeof indices[0]; l++)
    *indices[l] = ints + l * n;
}

static dls_status check_settings(const dls_lemke_settings *s, int n, dls_error *error) {
  const dlsi_setting own[] = {{"crash", s->crash, 0, 1, 0}};
  const dls_status status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 1, own, error);
  if (status || !s->cover) return status;
  const dls_status finite = dlsi_check_vector("cover", s->cover, (size_t)n, error);
  if (finite) return finite;
  for (int i = 0; i < n; i++)
    if (!(s->cover[i] > 0))
      return dlsi_fail(error, DLS_E_ARGUMENT, "cover", i, s->cover[i], "must be positive");
  return DLS_OK;
}

dls_status dls_lemke_create(dls_lemke **out, int n, const dls_lemke_settings *settings,
                            dls_error *error) {
  if (!out) return dlsi_at(__func__, dlsi_is_null(error, "out"), error);
  *out = NULL;
  if (n < 1 || n > INT_MAX / 4)
    return dlsi_at(__func__, dlsi_fail(error, DLS_E_SIZE, "n", -1, n, "is %d", n), error);
  dls_lemke_settings defaults;
  dls_lemke_settings_init(&defaults);
  if (!settings) settings = &defaults;
  const dls_status status = check_settings(settings, n, error);
  if (status) return dlsi_at(__func__, status, error);

  dls_lemke sizes = {.n = n, .settings = *settings};
  dlsi_arena arena = {0};
  carve(&sizes, &arena);
  if (arena.failed)
    return dlsi_at(__func__, dlsi_fail(error, DLS_E_SIZE, "n", -1, n, "is too large"), error);
  const size_t head = (sizeof sizes + 63) / 64 * 64; /* the arena starts after the struct */
  char *memory = arena.used > (size_t)-1 - head - 63 ? NULL : dlsi_alloc(head + arena.used + 63, 1);
  if (!memory) return dlsi_at(__func__, dlsi_no_memory(error), error);
  dls_lemke *w = (dls_lemke *)(void *)memory;
  *w = sizes;
  arena = (dlsi_arena){.base = memory + head, .size = arena.used};
  carve(w, &arena);
  if (settings->cover) memcpy(w->given, settings->cover, (size_t)n * sizeof *w->given);
  w->settings.cover = w->given;
  *out = w;
  return DLS_OK;
}

void dls_lemke_destroy(dls_lemke *workspace) {
  free(workspace);
}

void dlsi_lemke_set_limits(dls_lemke *work, const dls_limits *limits) {
  work->settings.limits = *limits;
}

/* ---- the scaled problem ---------------------------------------------------------------------- */

/* max |x_i|, not finite if there is a NaN: as dlsi_max_abs, for a hot loop, four at a time */
static double largest(int n, const double *x) {
  double m[4] = {0}, s[4] = {0};
  int i = 0;
  for (; i + 4 <= n; i += 4)
    for (int k = 0; k < 4; k++) {
      const double a = fabs(x[i + k]);
      m[k] = a > m[k] ? a : m[k];
      s[k] += a;
    }
  for (; i < n; i++) {
    const double a = fabs(x[i]);
    m[0] = a > m[0] ? a : m[0];
    s[0] += a;
  }
  const double sum = (s[0] + s[1]) + (s[2] + s[3]);
  for (int k = 1; k < 4; k++)
    m[0] = m[k] > m[0] ? m[k] : m[0];
  return sum == sum ? m[0] : sum;
}

static int complement(int n, int v) {
  return v < n ? v + n : v - n;
}

/* 2^round(e), held back to where it can be multiplied with anything of size 1 twice */
static double power_of_two(double e) {
  return ldexp(1, (int)lrint(e < -500 ? -500 : e > 500 ? 500 : e));
}

/* cover := R d; without a given d, that is the norms of the rows of R M C, C = 2^gamma not rounded,
 * so that units do not change it */
static void scale_cover(dls_lemke *w, const dls_lcp *lcp, const double *gamma) {
  const int n = lcp->n;
  double *d = w->cover;
  for (int i = 0; i < n; i++)
    d[i] = w->given ? w->R[i] * w->given[i] : 0;
  for (int j = 0; !w->given && j < n; j++) {
    const double *m = lcp->M.a + (size_t)j * (size_t)lcp->M.ld, c = exp2(gamma[j]);
    for (int i = 0; i < n; i++)
      d[i] += (w->R[i] * m[i] * c) * (w->R[i] * m[i] * c);
  }
  for (int i = 0; !w->given && i < n; i++)
    d[i] = d[i] > 0 ? sqrt(d[i]) : 1;
}

static void scale_problem(dls_lemke *w, const dls_lcp *lcp) {
  const int n = lcp->n;
  double *rho = w->R, *gamma = w->C;
  dlsi_lcp_equilibrate(lcp, rho, gamma, w->table.U);
  for (int i = 0; i < n; i++) {
    w->R[i] = power_of_two(rho[i]);
    w->q[i] = w->R[i] * lcp->q[i];
  }
  scale_cover(w, lcp, gamma);
  w->sigma = power_of_two(-log2(largest(n, w->cover)));
  w->kappa = power_of_two(log2(largest(n, w->q)));
  for (int i = 0; i < n; i++) {
    w->C[i] = power_of_two(gamma[i]);
    w->cover[i] *= w->sigma;
    w->q[i] /= w->kappa;
  }
}

/* Covering vector k: the given one, or it times factors between 1/32 and 32, no two alike */
static void choose_cover(dls_lemke *w, int n, int k) {
  for (int i = 0; i < n; i++) {
    const double x = 0.6180339887498949 * (i + 1) + 0.7548776662466927 * k;
    w->d[i] = k ? w->cover[i] * exp2(10 * (x - floor(x)) - 5) : w->cover[i];
  }
  double x = 0;
  for (int i = 0; i < n; i++) {
    x += 0.6180339887498949; /* golden ratio: no two alike */
    x -= x >= 1;
    w->g[i] = 1 + x;
    w->start[i] = i;
  }
}

/* The table of the basis y: y = q' + M' z' + d' z0. */
static void load_table(dls_lemke *w, const dls_lcp *lcp) {
  const int n = lcp->n;
  dlsi_table *t = &w->table;
  t->n = n;
  t->pending = 0;
  for (int j = 0; j < n; j++) {
    const double *m = lcp->M.a + (size_t)j * (size_t)lcp->M.ld;
    double *a = t->T + (size_t)j * (size_t)t->ld;
    for (int i = 0; i < n; i++)
      a[i] = w->R[i] * m[i] * w->C[j];
    t->column[j] = n + j;
    t->where[n + j] = -1 - j;
    t->born[j] = -1;
  }
  memcpy(t->T + (size_t)n * (size_t)t->ld, w->d, (size_t)n * sizeof *t->T);
  t->column[n] = 2 * n;
  t->born[n] = -1;
  t->where[2 * n] = -1 - n;
  for (int i = 0; i < n; i++) {
    t->basic[i] = i;
    t->where[i] = i;
    t->b[i] = w->q[i];
    t->g[i] = w->g[i];
  }
}

/* The table of the basis that has z_j instead of y_j for `count` pairs, listed in w->reenter as
 * variables; free_row[j] (w->rows) marks them. 0 if the basis is singular. */
static int enter_basis(dls_lemke *w, const dls_lcp *lcp, int count) {
  const int n = lcp->n;
  dlsi_table *t = &w->table;
  int *free_row = w->rows; /* y_j is out: row j waits for a z */
  load_table(w, lcp);
  for (int k = 0; k < count; k++) {
    const int s = -1 - t->where[w->reenter[k]];
    int r = -1;
    dlsi_table_column(t, s, w->c);
    for (int i = 0; i < n; i++)
      if (free_row[i] && (r < 0 || fabs(w->c[i]) > fabs(w->c[r]))) r = i;
    if (r < 0 || !(fabs(w->c[r]) > 0)) return 0;
    free_row[r] = 0;
    dlsi_table_exchange(t, r, s, w->c);
  }
  return 1;
}

/* (T3) the table of the present basis from the user's M; 0 if the basis is singular */
static int refresh(dls_lemke *w, const dls_lcp *lcp) {
  const int n = lcp->n;
  const dlsi_table *t = &w->table;
  int count = 0;
  for (int i = 0; i < n; i++) {
    w->rows[i] = t->where[i] < 0;
    if (t->basic[i] >= n) w->reenter[count++] = t->basic[i];
  }
  w->refreshes++;
  return enter_basis(w, lcp, count);
}

/* (L0): z_i basic where z_i > 0, y_i elsewhere; 0 if that basis is singular. B d', B g' by columns,
 * B's being e_i and -M'_i. */
static int enter_warm_basis(dls_lemke *w, const dls_lcp *lcp, const double *z) {
  const int n = lcp->n;
  double *d = w->work, *g = w->work + n;
  int count = 0;
  memset(d, 0, 2 * (size_t)n * sizeof *d);
  for (int i = 0; i < n; i++) {
    const int in = z[i] > 0;
    w->rows[i] = in;
    w->start[i] = in ? n + i : i;
    if (!in) {
      d[i] += w->d[i];
      g[i] += w->g[i];
      continue;
    }
    w->reenter[count++] = n + i;
    const double *m = lcp->M.a + (size_t)i * (size_t)lcp->M.ld;
    for (int k = 0; k < n; k++) {
      const double a = w->R[k] * m[k] * w->C[i];
      d[k] -= a * w->d[i];
      g[k] -= a * w->g[i];
    }
  }
  memcpy(w->d, d, (size_t)n * sizeof *d);
  memcpy(w->g, g, (size_t)n * sizeof *g);
  return enter_basis(w, lcp, count);
}

/* residual := M' z' + d' z0 + h q' - y' of values x by variable; returns its max norm */
static double misfit(dls_lemke *w, const dls_lcp *lcp, const double *x, double h) {
  const size_t n = (size_t)lcp->n;
  double *f = w->residual, largest = 0;
  memset(f, 0, n * sizeof *f);
  for (size_t j = 0; j < n; j++) {
    const double *m = lcp->M.a + j * (size_t)lcp->M.ld, z = w->C[j] * x[n + j];
    if (z == 0) continue;
    for (size_t i = 0; i < n; i++)
      f[i] += m[i] * z;
  }
  for (size_t i = 0; i < n; i++) {
    f[i] = w->R[i] * f[i] + (w->d[i] * x[2 * n] + h * w->q[i] - x[i]);
    if (fabs(f[i]) > largest || f[i] != f[i]) largest = fabs(f[i]);
  }
  return largest;
}

/* x := the basic variables at b (dx: at c, with the entering variable at 1), the others 0 */
static void read_values(const dlsi_table *t, const double *b, int entering, double *x) {
  memset(x, 0, (2 * (size_t)t->n + 1) * sizeof *x);
  for (int i = 0; i < t->n; i++)
    x[t->basic[i]] = b[i];
  if (entering >= 0) x[entering] = 1;
}

/* (T4) With residual f, y_i out of the basis is f_i instead of 0: it has to move by -f_i, which
 * moves the basic variables along; y_i in the basis takes up its f_i by itself. Until f is
 * rounding, or does not halve. */
static void refine(dls_lemke *w, const dls_lcp *lcp, double *x, double h) {
  const dlsi_table *t = &w->table;
  const int n = lcp->n;
  double before = INFINITY, *dx = w->work;
  for (int sweep = 0; sweep < 4; sweep++) {
    const double f = misfit(w, lcp, x, h);
    if (!(f > DBL_EPSILON * (h + dlsi_max_abs(x, 2 * (size_t)n + 1))) || !(f < 0.5 * before))
      return;
    before = f;
    for (int i = 0; i < n; i++)
      if (t->where[i] >= 0)
        x[i] += w->residual[i];
      else
        w->residual[i] = -w->residual[i];
    dlsi_table_move_y(t, w->residual, dx);
    for (int k = 0; k < n; k++)
      x[t->basic[k]] += dx[k];
  }
}

/* ---- the ratio test -------------------------------------------------------------------------- */

enum { no_row = -1, not_finite = -2 };

/* Keeps those of rows[0..count) whose value[k] is smallest but for rounding; returns how many. */
static int keep_smallest(int count, int *rows, const double *value) {
  double smallest = INFINITY, largest = 0;
  int kept = 0;
  for (int k = 0; k < count; k++) {
    if (value[k] < smallest) smallest = value[k];
    if (fabs(value[k]) > largest) largest = fabs(value[k]);
  }
  for (int k = 0; k < count; k++)
    if (value[k] <= smallest + lex_tolerance * largest) rows[kept++] = rows[k];
  return kept;
}

/* value_k := (L5) / -c_i for the rows i = rows[k]: the coefficient of e^(j+2) is -a_is if v,
 * the basic variable number j of the start (y_j if cold), stands in column s, 1 if it is basic in
 * row i; a: n doubles */
static void perturbation(const dlsi_table *t, int v, int count, const int *rows, const double *c,
                         double *a, double *value) {
  if (t->where[v] < 0) dlsi_table_column(t, -1 - t->where[v], a);
  for (int k = 0; k < count; k++) {
    const int i = rows[k];
    value[k] = t->where[v] < 0 ? a[i] / c[i] : t->where[v] == i ? -1 / c[i] : 0;
  }
}

/* (L3) with (R1)-(R3), (T1), (T2): the row that leaves when column c enters */
static int leaving_row(dls_lemke *w, const double *c, double cmax, int strict) {
  dlsi_table *t = &w->table;
  const int n = t->n, z0 = t->where[2 * n];
  const double bmax = largest(n, t->b);
  if (!isfinite(cmax) || !isfinite(bmax)) return not_finite;
  const double least = -(strict ? strict_pivot : pivot_tolerance) * cmax;
  const double tie = tie_tolerance * bmax;
  const double tie0 = (strict ? tie_tolerance : z0_tolerance) * bmax;
  int *rows = w->rows, count = 0, tied = 0;
  for (int i = 0; i < n; i++) {
    rows[count] = i;
    count += c[i] < least;
  }
  if (count == 0) return no_row;
  double bound = INFINITY, bound0 = INFINITY;
  for (int k = 0; k < count; k++) { /* (R1) */
    const double b = t->b[rows[k]] > 0 ? t->b[rows[k]] : 0, a = -c[rows[k]];
    if (b + tie < bound * a) bound = (b + tie) / a;
    if (b + tie0 < bound0 * a) bound0 = (b + tie0) / a;
  }
  if (c[z0] < least && t->b[z0] <= -bound0 * c[z0]) return z0; /* (T2) */
  for (int k = 0; k < count; k++) {
    rows[tied] = rows[k];
    tied += t->b[rows[k]] <= -bound * c[rows[k]];
  }
  double *value = w->work;
  if (tied > 1) { /* (R2) */
    for (int k = 0; k < tied; k++)
      value[k] = t->g[rows[k]] / -c[rows[k]];
    tied = keep_smallest(tied, rows, value);
  }
  for (int j = 0; tied > 1 && j < n; j++) { /* (R3) */
    perturbation(t, w->start[j], tied, rows, c, w->work + n, value);
    tied = keep_smallest(tied, rows, value);
  }
  int r = rows[0];
  for (int k = 1; k < tied; k++) /* only where rounding hides the difference */
    if (c[rows[k]] < c[r]) r = rows[k];
  return r;
}

/* (L1) with z0's column c, ties as in (R2), (R3): of rows (e_i / c_i) the last one is
 * lexicographically smallest. no_row: b >= 0, solved; not_finite: c > 0 was lost to rounding. */
static int first_row(const dlsi_table *t, const double *c) {
  const int n = t->n;
  double least = INFINITY, size = 0, smallest = INFINITY;
  int r = no_row;
  for (int i = 0; i < n; i++) {
    if (!(c[i] > 0)) return not_finite;
    if (t->b[i] < least * c[i]) least = t->b[i] / c[i];
    if (fabs(t->b[i]) > size * c[i]) size = fabs(t->b[i]) / c[i];
  }
  if (least >= -tie_tolerance * size) return no_row;
  for (int i = 0; i < n; i++)
    if (t->b[i] / c[i] <= least + tie_tolerance * size && t->g[i] / c[i] <= smallest) {
      smallest = t->g[i] / c[i];
      r = i;
    }
  return r;
}

/* ---- the path -------------------------------------------------------------------------------- */

typedef enum path_end { path_solved, path_ray, path_limit, path_cancelled, path_lost } path_end;

static int report(const dls_lemke *w, int max_pivots, double residual) {
  const dls_progress progress = {"lemke", w->pivots, max_pivots, residual};
  return w->settings.limits.progress &&
         w->settings.limits.progress(w->settings.limits.progress_data, &progress);
}

/* The residual with z0 > 0 is about that of y - d z0 where y - d z0 < 0. */
static double residual_estimate(const dls_lemke *w, size_t n) {
  const double z0 = w->table.where[2 * n] < 0 ? 0 : w->table.b[w->table.where[2 * n]];
  return z0 * dlsi_norm2(w->d, n) / dlsi_norm2(w->q, n);
}

/* Follows the path to its end, from the basis of z if that is not NULL; *entering is the variable of
 * the ray. */
static path_end follow(dls_lemke *w, const dls_lcp *lcp, const double *z, int max_pivots,
                       int strict, int *entering) {
  dlsi_table *t = &w->table;
  const int n = lcp->n, z0 = 2 * n;
  if (!z)
    load_table(w, lcp);
  else if (!enter_warm_basis(w, lcp, z)) /* (L0) */
    return path_lost;
  const int first = -1 - t->where[z0];
  dlsi_table_column(t, first, w->c);
  int r = first_row(t, w->c), fresh = 0, unchecked = 0; /* (L1) */
  if (r < 0) return r == no_row ? path_solved : path_lost;
  *entering = complement(n, t->basic[r]);
  dlsi_table_exchange(t, r, first, w->c);
  w->pivots++;
  for (;;) {
    if (w->pivots >= max_pivots) return path_limit;
    if (w->pivots % progress_interval == 0 &&
        report(w, max_pivots, residual_estimate(w, (size_t)n)))
      return path_cancelled;
    const int s = -1 - t->where[*entering];
    dlsi_table_column(t, s, w->c); /* (L2) */
    const double cmax = largest(n, w->c);
    r = leaving_row(w, w->c, cmax, strict); /* (L3) */
    if (r < 0) {
      if (fresh) return r == no_row ? path_ray : path_lost;
      if (!refresh(w, lcp)) return path_lost;
      fresh = 1;
      continue;
    }
    const int out = t->basic[r];
    const double pivot = fabs(w->c[r]);
    dlsi_table_exchange(t, r, s, w->c); /* (L4) */
    w->pivots++;
    fresh = 0;
    if (out == z0) return path_solved;
    *entering = complement(n, out);
    if (++unchecked >= (strict               ? strict_check_interval
                        : n > check_interval ? n
                                             : check_interval) ||
        pivot < small_pivot * cmax) { /* (T3) */
      unchecked = 0;
      read_values(t, t->b, -1, w->x);
      if (!(misfit(w, lcp, w->x, 1) <= misfit_tolerance * (1 + dlsi_max_abs(t->b, (size_t)n)))) {
        if (!refresh(w, lcp)) return path_lost;
        fresh = 1;
      }
    }
  }
}

/* ---- answers --------------------------------------------------------------------------------- */

/* Certifies z = max(0, trial); keeps it if it is the best so far. */
static void offer_trial(dls_lemke *w, const dls_lcp *lcp) {
  const size_t n = (size_t)lcp->n;
  dls_lcp_certificate certificate;
  for (size_t j = 0; j < n; j++)
    w->trial[j] = w->trial[j] > 0 ? w->trial[j] : 0;
  dlsi_lcp_multiply(lcp, lcp->q, w->trial, w->y, w->magnitude);
  dlsi_lcp_measure(lcp, w->trial, w->y, w->magnitude, w->weight, &certificate);
  if (!(certificate.residual < w->best.residual)) return;
  w->best = certificate;
  memcpy(w->z, w->trial, n * sizeof *w->z);
  memcpy(w->best_y, w->y, n * sizeof *w->best_y);
}

/* The best so far := z = 0, [C] (41) */
static void offer_zero(dls_lemke *w, const dls_lcp *lcp) {
  const size_t n = (size_t)lcp->n;
  memset(w->z, 0, n * sizeof *w->z);
  memcpy(w->best_y, lcp->q, n * sizeof *w->best_y);
  memset(w->magnitude, 0, n * sizeof *w->magnitude);
  dlsi_lcp_measure(lcp, w->z, lcp->q, w->magnitude, w->weight, &w->best);
}

/* The same for the z of scaled values x */
static void offer(dls_lemke *w, const dls_lcp *lcp, const double *x) {
  const size_t n = (size_t)lcp->n;
  for (size_t j = 0; j < n; j++)
    w->trial[j] = w->kappa * w->C[j] * x[n + j];
  offer_trial(w, lcp);
}

/* (T5) for a solution: 1 if nothing better is to be expected */
static int accept_solution(dls_lemke *w, const dls_lcp *lcp) {
  for (int anew = 0; anew < 2; anew++) {
    if (anew && !refresh(w, lcp)) return 0;
    read_values(&w->table, w->table.b, -1, w->x);
    refine(w, lcp, w->x, 1);
    offer(w, lcp, w->x);
    if (dls_lcp_certificate_holds(&w->best, sharp)) return 1;
  }
  return 0;
}

/* (T5) for a ray on a fresh table: 1 if it is one */
static int accept_ray(dls_lemke *w, const dls_lcp *lcp, int entering) {
  const size_t n = (size_t)lcp->n;
  read_values(&w->table, w->table.b, -1, w->x);
  read_values(&w->table, w->c, entering, w->dx);
  refine(w, lcp, w->x, 1);
  refine(w, lcp, w->dx, 0);
  offer(w, lcp, w->x);
  const double least = strict_pivot * dlsi_max_abs(w->dx, 2 * n + 1);
  const double tolerance = proof_tolerance * (double)(n + 10);
  for (size_t j = 0; j < n; j++) {
    const double z = w->x[n + j], dz = w->dx[n + j];
    w->ray_z[j] = z > 0 ? w->kappa * w->C[j] * z : 0;
    w->ray_dz[j] = dz > least ? w->C[j] * dz : 0;
    w->ray_cover[j] = w->d[j] / w->R[j] / w->sigma;
  }
  w->ray_z0 = w->kappa * w->sigma * w->x[2 * n];
  w->ray_dz0 = w->dx[2 * n] > least ? w->sigma * w->dx[2 * n] : 0;
  const double size = dlsi_max_abs(w->ray_dz, n);
  for (size_t j = 0; j < n; j++)
    w->ray_dz[j] /= size; /* dz = 0 gives NaN, which is no ray */
  w->ray_dz0 /= size;
  if (!(dlsi_lcp_ray_violation(lcp, w->ray_cover, w->ray_z, w->ray_z0, w->ray_dz, w->ray_dz0,
                               w->work) <= tolerance))
    return 0;
  w->proved = dlsi_lcp_farkas_violation(lcp, w->ray_dz) <= tolerance;
  w->solved_n = lcp->n;
  return 1;
}

/* What tiny.c finds, z >= 0, if it has a certificate that leaves nothing to refine. */
static int solve_tiny(dls_lemke *w, const dls_lcp *lcp, int limit) {
  if (lcp->n > dlsi_tiny_size || !w->settings.crash || w->settings.limits.warm_start || w->given)
    return 0;
  if (!dlsi_lcp_tiny(lcp, limit, w->z, &w->crash.rounds)) return 0;
  dlsi_lcp_multiply(lcp, lcp->q, w->z, w->best_y, w->magnitude);
  dlsi_lcp_measure(lcp, w->z, w->best_y, w->magnitude, w->weight, &w->best);
  return dls_lcp_certificate_holds(&w->best, DBL_EPSILON);
}

/* Up to max_pivots rounds of crash.c from the basis of z, or of y if z is NULL; path_lost if they lead
 * nowhere. */
static path_end crash(dls_lemke *w, const dls_lcp *lcp, const double *z, int max_pivots) {
  int outcome = 0;
  for (int i = 0; i < lcp->n; i++)
    w->crash.in[i] = z && z[i] > 0;
  dlsi_crash_begin(lcp, &w->crash);
  while (outcome == 0 && w->crash.rounds < max_pivots) {
    outcome = dlsi_crash_round(lcp, &w->crash);
    if (report(w, max_pivots, -1)) return path_cancelled;
  }
  if (outcome <= 0) return path_lost;
  offer_trial(w, lcp);
  if (dls_lcp_certificate_holds(&w->best, sharp)) return path_solved;
  offer_zero(w, lcp);
  return path_lost;
}

/* Starts until something is settled: again with care (T5) after what could not be confirmed, with
 * another covering vector after a ray that proves nothing. */
static dls_status solve(dls_lemke *w, const dls_lcp *lcp, const double *warm, int max_pivots,
                        int *starts) {
  int strict = 0, cover = 0, entering = 0;
  if (w->settings.crash && !w->given) {
    const path_end end = crash(w, lcp, warm, max_pivots);
    if (end != path_lost) return end == path_solved ? DLS_OK : DLS_CANCELLED;
  }
  scale_problem(w, lcp);
  for (;; warm = NULL) {
    choose_cover(w, lcp->n, cover);
    const path_end end = follow(w, lcp, warm, max_pivots, strict, &entering);
    ++*starts;
    if (end == path_ray && warm) continue; /* a ray of another cover than the user's */
    if (end == path_ray && accept_ray(w, lcp, entering)) {
      if (dls_lcp_certificate_holds(&w->best, w->settings.limits.tol))
        break; /* z0 was as good as 0 */
      if (w->proved) return DLS_NO_SOLUTION;
      if (w->given || ++cover == covers) return DLS_RAY;
      continue;
    }
    w->solved_n = 0;
    if (end == path_solved && accept_solution(w, lcp)) return DLS_OK;
    if (end == path_limit || end == path_cancelled) {
      read_values(&w->table, w->table.b, -1, w->x);
      offer(w, lcp, w->x);
      if (dls_lcp_certificate_holds(&w->best, w->settings.limits.tol)) return DLS_OK;
      return end == path_limit ? DLS_MAX_ITERATIONS : DLS_CANCELLED;
    }
    if (warm) continue;
    if (strict)
      return dls_lcp_certificate_holds(&w->best, w->settings.limits.tol) ? DLS_OK : DLS_STALLED;
    strict = 1;
  }
  w->solved_n = w->proved = 0;
  return DLS_OK;
}

dls_status dls_lemke_solve(dls_lemke *workspace, const dls_lcp *lcp, double *z, double *y,
                           dls_lemke_info *info, dls_error *error) {
  if (!workspace) return dlsi_at(__func__, dlsi_is_null(error, "workspace"), error);
  dls_status status = dlsi_check_lcp(lcp, error);
  if (status) return dlsi_at(__func__, status, error);
  if (lcp->n > workspace->n)
    return dlsi_at(
        __func__,
        dlsi_fail(error, DLS_E_SIZE, "n", -1, lcp->n, "is more than %d of create", workspace->n),
        error);
  if (!z) return dlsi_at(__func__, dlsi_is_null(error, "z"), error);
  if (workspace->settings.limits.warm_start) {
    status = dlsi_check_vector("z", z, (size_t)lcp->n, error);
    if (status) return dlsi_at(__func__, status, error);
  }

  dls_lemke *w = workspace;
  const size_t n = (size_t)lcp->n;
  const int limit = w->settings.limits.max_iterations ? w->settings.limits.max_iterations
                    : lcp->n < (INT_MAX - 1000) / 50  ? 50 * lcp->n + 1000
                                                      : INT_MAX;
  w->pivots = w->refreshes = w->crash.rounds = w->solved_n = w->proved = 0;
  int starts = 0;
  dlsi_lcp_weights(lcp, w->weight);
  if (!solve_tiny(w, lcp, limit)) {
    offer_zero(w, lcp);
    if (w->best.negative_y > 0)
      status = solve(w, lcp, w->settings.limits.warm_start ? z : NULL, limit, &starts);
  }
  memcpy(z, w->z, n * sizeof *z);
  if (y) memcpy(y, w->best_y, n * sizeof *y);
  if (info)
    *info = (dls_lemke_info){status, w->pivots, w->best, starts, w->refreshes, w->crash.rounds};
  return dlsi_at(__func__, status, error);
}

/* ---- what a ray proves ----------------------------------------------------------------------- */

dls_status dls_lemke_ray(const dls_lemke *workspace, double *z, double *z0, double *dz, double *dz0,
                         double *cover, dls_error *error) {
  if (!workspace || !workspace->solved_n)
    return dlsi_at(__func__,
                   dlsi_fail(error, DLS_E_ARGUMENT, "workspace", -1, 0,
                             workspace ? "the last solve did not end in a ray" : "is NULL"),
                   error);
  const size_t n = (size_t)workspace->solved_n;
  if (z) memcpy(z, workspace->ray_z, n * sizeof *z);
  if (z0) *z0 = workspace->ray_z0;
  if (dz) memcpy(dz, workspace->ray_dz, n * sizeof *dz);
  if (dz0) *dz0 = workspace->ray_dz0;
  if (cover) memcpy(cover, workspace->ray_cover, n * sizeof *cover);
  return DLS_OK;
}

dls_status dls_lemke_farkas(const dls_lemke *workspace, double *v, dls_error *error) {
  if (!workspace || !workspace->proved)
    return dlsi_at(__func__,
                   dlsi_fail(error, DLS_E_ARGUMENT, "workspace", -1, 0,
                             workspace ? "the last solve proved nothing" : "is NULL"),
                   error);
  if (!v) return dlsi_at(__func__, dlsi_is_null(error, "v"), error);
  memcpy(v, workspace->ray_dz, (size_t)workspace->solved_n * sizeof *v);
  return DLS_OK;
}
