/*
 * products.c: adds columns of W to u: u += W(:,c) dr_c, for one contact or for a list of
 * contacts.
 *
 * Dense W: one pass over u takes the columns of four contacts, to read W at the speed of the
 * memory. Each u_i receives the terms of the contacts in the order of the list, to the same bits as
 * successive calls of dlsi_contact_add_columns.
 *
 * The Makefile compiles this file with -O3, which vectorises the loops over i. Each loop is written
 * once per dimension: the compiler has to know how many columns run side by side.
 */
#include <math.h>

#include "contact.h"

/* Two doubles in a register, for loops in which the compiler finds no pairs. */
typedef double dlsi_pair __attribute__((vector_size(16), aligned(8), may_alias));

static inline dlsi_pair dlsi_load(const double *x) {
  return *(const dlsi_pair *)x;
}

/* ---- W dense --------------------------------------------------------------------------------- */

typedef const double *restrict column;

DLSI_CLONES static void add_one_1d(size_t rows, column a, size_t ld, const double *x,
                                   double *restrict u) {
  const double x0 = x[0];
  (void)ld;
  for (size_t i = 0; i < rows; i++)
    u[i] += a[i] * x0;
}

DLSI_CLONES static void add_one_2d(size_t rows, column a, size_t ld, const double *x,
                                   double *restrict u) {
  column b = a + ld;
  const double x0 = x[0], x1 = x[1];
  for (size_t i = 0; i < rows; i++)
    u[i] += a[i] * x0 + b[i] * x1;
}

DLSI_CLONES static void add_one_3d(size_t rows, column a, size_t ld, const double *x,
                                   double *restrict u) {
  column b = a + ld, c = b + ld;
  const double x0 = x[0], x1 = x[1], x2 = x[2];
  for (size_t i = 0; i < rows; i++)
    u[i] += a[i] * x0 + b[i] * x1 + c[i] * x2;
}

DLSI_CLONES static void add_four_1d(size_t rows, const double *const w[4], size_t ld,
                                    const double *x, double *restrict u) {
  column a = w[0], b = w[1], c = w[2], d = w[3];
  const double x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3];
  (void)ld;
  for (size_t i = 0; i < rows; i++) {
    double v = u[i] + a[i] * x0;
    v += b[i] * x1;
    v += c[i] * x2;
    u[i] = v + d[i] * x3;
  }
}

DLSI_CLONES static void add_four_2d(size_t rows, const double *const w[4], size_t ld,
                                    const double *x, double *restrict u) {
  column a0 = w[0], a1 = a0 + ld, b0 = w[1], b1 = b0 + ld;
  column c0 = w[2], c1 = c0 + ld, d0 = w[3], d1 = d0 + ld;
  const double x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3];
  const double x4 = x[4], x5 = x[5], x6 = x[6], x7 = x[7];
  for (size_t i = 0; i < rows; i++) {
    double v = u[i] + (a0[i] * x0 + a1[i] * x1);
    v += b0[i] * x2 + b1[i] * x3;
    v += c0[i] * x4 + c1[i] * x5;
    u[i] = v + (d0[i] * x6 + d1[i] * x7);
  }
}

DLSI_CLONES static void add_four_3d(size_t rows, const double *const w[4], size_t ld,
                                    const double *x, double *restrict u) {
  column a0 = w[0], a1 = a0 + ld, a2 = a1 + ld, b0 = w[1], b1 = b0 + ld, b2 = b1 + ld;
  column c0 = w[2], c1 = c0 + ld, c2 = c1 + ld, d0 = w[3], d1 = d0 + ld, d2 = d1 + ld;
  const double x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3], x4 = x[4], x5 = x[5];
  const double x6 = x[6], x7 = x[7], x8 = x[8], x9 = x[9], x10 = x[10], x11 = x[11];
  for (size_t i = 0; i < rows; i++) {
    double v = u[i] + (a0[i] * x0 + a1[i] * x1 + a2[i] * x2);
    v += b0[i] * x3 + b1[i] * x4 + b2[i] * x5;
    v += c0[i] * x6 + c1[i] * x7 + c2[i] * x8;
    u[i] = v + (d0[i] * x9 + d1[i] * x10 + d2[i] * x11);
  }
}

/* Add W(:,c) dr_c to u and |W(:,c)| |dr_c| to a; |w| |x| is |w x| to the last bit. */
DLSI_CLONES static void both_one_1d(size_t rows, column w, size_t ld, const double *x,
                                    double *restrict u, double *restrict a) {
  const double x0 = x[0];
  (void)ld;
  for (size_t i = 0; i < rows; i++) {
    const double p = w[i] * x0;
    u[i] += p;
    a[i] += fabs(p);
  }
}

DLSI_CLONES static void both_one_2d(size_t rows, column w, size_t ld, const double *x,
                                    double *restrict u, double *restrict a) {
  column v = w + ld;
  const double x0 = x[0], x1 = x[1];
  for (size_t i = 0; i < rows; i++) {
    const double p = w[i] * x0, q = v[i] * x1;
    u[i] += p + q;
    a[i] += fabs(p) + fabs(q);
  }
}

DLSI_CLONES static void both_one_3d(size_t rows, column w, size_t ld, const double *x,
                                    double *restrict u, double *restrict a) {
  column v = w + ld, t = v + ld;
  const double x0 = x[0], x1 = x[1], x2 = x[2];
  for (size_t i = 0; i < rows; i++) {
    const double p = w[i] * x0, q = v[i] * x1, s = t[i] * x2;
    u[i] += p + q + s;
    a[i] += fabs(p) + fabs(q) + fabs(s);
  }
}

DLSI_CLONES static void both_four_2d(size_t rows, const double *const w[4], size_t ld,
                                     const double *x, double *restrict u, double *restrict a) {
  column a0 = w[0], a1 = a0 + ld, b0 = w[1], b1 = b0 + ld;
  column c0 = w[2], c1 = c0 + ld, d0 = w[3], d1 = d0 + ld;
  const double x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3];
  const double x4 = x[4], x5 = x[5], x6 = x[6], x7 = x[7];
  for (size_t i = 0; i < rows; i++) {
    double p = a0[i] * x0, q = a1[i] * x1, v = u[i] + (p + q), s = a[i] + (fabs(p) + fabs(q));
    p = b0[i] * x2, q = b1[i] * x3, v += p + q, s += fabs(p) + fabs(q);
    p = c0[i] * x4, q = c1[i] * x5, v += p + q, s += fabs(p) + fabs(q);
    p = d0[i] * x6, q = d1[i] * x7, u[i] = v + (p + q), a[i] = s + (fabs(p) + fabs(q));
  }
}

DLSI_CLONES static void both_four_3d(size_t rows, const double *const w[4], size_t ld,
                                     const double *x, double *restrict u, double *restrict a) {
  column a0 = w[0], a1 = a0 + ld, a2 = a1 + ld, b0 = w[1], b1 = b0 + ld, b2 = b1 + ld;
  column c0 = w[2], c1 = c0 + ld, c2 = c1 + ld, d0 = w[3], d1 = d0 + ld, d2 = d1 + ld;
  const double x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3], x4 = x[4], x5 = x[5];
  const double x6 = x[6], x7 = x[7], x8 = x[8], x9 = x[9], x10 = x[10], x11 = x[11];
  for (size_t i = 0; i < rows; i++) {
    double p = a0[i] * x0, q = a1[i] * x1, t = a2[i] * x2;
    double v = u[i] + (p + q + t), s = a[i] + (fabs(p) + fabs(q) + fabs(t));
    p = b0[i] * x3, q = b1[i] * x4, t = b2[i] * x5;
    v += p + q + t, s += fabs(p) + fabs(q) + fabs(t);
    p = c0[i] * x6, q = c1[i] * x7, t = c2[i] * x8;
    v += p + q + t, s += fabs(p) + fabs(q) + fabs(t);
    p = d0[i] * x9, q = d1[i] * x10, t = d2[i] * x11;
    u[i] = v + (p + q + t), a[i] = s + (fabs(p) + fabs(q) + fabs(t));
  }
}

void dlsi_contact_add_columns(const dls_contact *problem, int c, const double *dr, double *u) {
  if (problem->Wb.x)
    dlsi_contact_add_blocks(problem, c, dr, u);
  else
    dlsi_contact_add_panel(problem, 1, &c, dr, u);
}

void dlsi_contact_add_both(const dls_contact *problem, int count, const int *c, const double *dr,
                           double *u, double *a) {
  const size_t d = (size_t)problem->d, ld = (size_t)problem->W.ld, m = d * (size_t)problem->nc;
  int k = 0;
  for (; d > 1 && k + 4 <= count; k += 4) {
    const double *w[4];
    for (int j = 0; j < 4; j++)
      w[j] = problem->W.a + d * (size_t)c[k + j] * ld;
    (d == 2 ? both_four_2d : both_four_3d)(m, w, ld, dr + d * (size_t)k, u, a);
  }
  for (; k < count; k++) {
    const double *w = problem->W.a + d * (size_t)c[k] * ld;
    (d == 1 ? both_one_1d : d == 2 ? both_one_2d : both_one_3d)(m, w, ld, dr + d * (size_t)k, u, a);
  }
}

void dlsi_contact_add_panel(const dls_contact *problem, int count, const int *c, const double *dr,
                            double *u) {
  const size_t d = (size_t)problem->d, ld = (size_t)problem->W.ld, m = d * (size_t)problem->nc;
  int k = 0, normal = 1; /* contacts without friction skip the columns of tangents */
  for (size_t i = 0; i < d * (size_t)count; i++)
    normal &= i % d == 0 || dr[i] == 0;
  const size_t columns = normal ? 1 : d;
  for (; k + 4 <= count; k += 4) {
    const double *w[4];
    double x[12];
    for (size_t j = 0; j < 4; j++) {
      w[j] = problem->W.a + d * (size_t)c[k + (int)j] * ld;
      for (size_t i = 0; i < columns; i++)
        x[columns * j + i] = dr[d * ((size_t)k + j) + i];
    }
    (columns == 1 ? add_four_1d : d == 2 ? add_four_2d : add_four_3d)(m, w, ld, x, u);
  }
  for (; k < count; k++) {
    const double *w = problem->W.a + d * (size_t)c[k] * ld;
    (columns == 1 ? add_one_1d : d == 2 ? add_one_2d : add_one_3d)(m, w, ld, dr + d * (size_t)k, u);
  }
}

/* ---- W by blocks ----------------------------------------------------------------------------- */

static void add_blocks_1d(const dls_blocks *B, int c, const double *dr, double *u) {
  const double r0 = dr[0];
  for (int k = B->p[c]; k < B->p[c + 1]; k++)
    u[B->i[k]] += B->x[k] * r0;
}

DLSI_CLONES static void add_blocks_2d(const dls_blocks *B, int c, const double *dr, double *u) {
  const double r0 = dr[0], r1 = dr[1];
  const int end = B->p[c + 1];
  for (int k = B->p[c]; k < end; k++) {
    double *v = u + 2 * (size_t)B->i[k];
    const double *x = B->x + 4 * (size_t)k;
    *(dlsi_pair *)v = dlsi_load(v) + (dlsi_load(x) * r0 + dlsi_load(x + 2) * r1);
  }
}

DLSI_CLONES static void add_blocks_3d(const dls_blocks *B, int c, const double *dr, double *u) {
  const double r0 = dr[0], r1 = dr[1], r2 = dr[2];
  const int end = B->p[c + 1];
  for (int k = B->p[c]; k < end; k++) {
    double *v = u + 3 * (size_t)B->i[k];
    const double *x = B->x + 9 * (size_t)k;
    const dlsi_pair nt =
        dlsi_load(v) + (dlsi_load(x) * r0 + dlsi_load(x + 3) * r1 + dlsi_load(x + 6) * r2);
    const double s = v[2] + (x[2] * r0 + x[5] * r1 + x[8] * r2);
    *(dlsi_pair *)v = nt;
    v[2] = s;
  }
}

void dlsi_contact_add_blocks(const dls_contact *problem, int c, const double *dr, double *u) {
  const int d = problem->d;
  (d == 1 ? add_blocks_1d : d == 2 ? add_blocks_2d : add_blocks_3d)(&problem->Wb, c, dr, u);
}

/* ---- a few columns --------------------------------------------------------------------------- */

typedef double four __attribute__((vector_size(32), aligned(8), may_alias));

/* Sets y[0] to a.x and y[1] to b.x. */
DLSI_CLONES static void dot_two(size_t m, const double *a, const double *b, const double *x,
                                double *y) {
  four s = {0}, t = {0};
  size_t i = 0;
  for (; i + 4 <= m; i += 4) {
    const four v = *(const four *)(x + i);
    s += *(const four *)(a + i) * v;
    t += *(const four *)(b + i) * v;
  }
  y[0] = (s[0] + s[1]) + (s[2] + s[3]);
  y[1] = (t[0] + t[1]) + (t[2] + t[3]);
  for (; i < m; i++) {
    y[0] += a[i] * x[i];
    y[1] += b[i] * x[i];
  }
}

void dlsi_panel_dot(size_t m, int n, const double *A, const double *x, double *y) {
  for (int j = 0; j < n; j += 2) {
    const double *a = A + (size_t)j * m, *b = j + 1 < n ? a + m : a;
    double two[2];
    dot_two(m, a, b, x, two);
    y[j] = two[0];
    if (j + 1 < n) y[j + 1] = two[1];
  }
}

/* Subtract A x from y, A of two columns a and b, or of four columns from a on. */
DLSI_CLONES static void subtract_two(size_t m, column a, column b, const double *x,
                                     double *restrict y) {
  const double x0 = x[0], x1 = x[1];
  for (size_t i = 0; i < m; i++)
    y[i] -= a[i] * x0 + b[i] * x1;
}

DLSI_CLONES static void subtract_four(size_t m, column a, const double *x, double *restrict y) {
  column b = a + m, c = b + m, d = c + m;
  const double x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3];
  for (size_t i = 0; i < m; i++)
    y[i] -= (a[i] * x0 + b[i] * x1) + (c[i] * x2 + d[i] * x3);
}

void dlsi_panel_subtract(size_t m, int n, const double *A, const double *x, double *y) {
  int j = 0;
  for (; j + 4 <= n; j += 4)
    subtract_four(m, A + (size_t)j * m, x + j, y);
  for (; j < n; j += 2) {
    const double last[2] = {x[j], j + 1 < n ? x[j + 1] : 0};
    const double *a = A + (size_t)j * m;
    subtract_two(m, a, j + 1 < n ? a + m : a, last, y);
  }
}
