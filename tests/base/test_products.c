/* test_products.c: products with W in whole numbers, exact in any order, of lists of any length. */
#include "contact/contact.h"
#include "run.h"

enum { most_nc = 35, most_m = 3 * most_nc, most_ld = most_m + 2 };

/* W unsymmetric, dense with room between its columns and by blocks, each block in two parts. */
typedef struct whole {
  int d, nc, m, p[most_nc + 1], i[2 * most_nc * most_nc];
  double W[most_m * most_ld], x[2 * 9 * most_nc * most_nc], q[most_m], mu[most_nc];
  dls_contact dense, blocks;
} whole;

static whole w;

/* Returns the whole number from -7 to 7 that k draws. */
static double small(int k) {
  return floor(15 * dlsi_draw((uint64_t)k * DLSI_GOLDEN_BITS)) - 7;
}

static void set_whole(int d, int nc) {
  const int m = d * nc, ld = m + 2;
  int k = 0;
  w.d = d, w.nc = nc, w.m = m;
  for (int e = 0; e < ld * m; e++)
    w.W[e] = e % ld < m ? small(e + 1) : NAN;
  for (int e = 0; e < m; e++)
    w.q[e] = small(-e - 1);
  w.p[0] = 0;
  for (int c = 0; c < nc; c++) {
    for (int a = nc - 1; a >= 0; a--)
      for (int part = 0; part < 2; part++, k++) {
        w.i[k] = a;
        for (int e = 0; e < d * d; e++) {
          const double x = w.W[d * a + e % d + ld * (d * c + e / d)];
          w.x[d * d * k + e] = part ? (x < 0 ? -1 : 1) : x - (x < 0 ? -1 : 1); /* |x| adds up */
          if (x == 0) w.x[d * d * k + e] = 0;
        }
      }
    w.p[c + 1] = k;
  }
  w.dense = (dls_contact){.d = d, .nc = nc, .W = {m, m, ld, w.W}, .q = w.q, .mu = w.mu};
  w.blocks = (dls_contact){.d = d, .nc = nc, .Wb = {d, nc, w.p, w.i, w.x}, .q = w.q, .mu = w.mu};
}

/* u := u + W(:,c) x and a := a + |W(:,c)| |x|, entry by entry. */
static void add_column(int c, const double *x, double *u, double *a) {
  for (int j = 0; j < w.d; j++)
    for (int i = 0; i < w.m; i++) {
      const double y = w.W[i + (w.m + 2) * (w.d * c + j)] * x[j];
      u[i] += y;
      a[i] += fabs(y);
    }
}

/* Lists of up to ten candidates: whole fours, and the rest. */
TEST_EACH(lists_of_any_length, 1, 4) {
  const int c[10] = {9, 0, 4, 10, 1, 7, 3, 8, 2, 5};
  double dr[30], u[5][36], a[2][36];
  set_whole(_i, 11);
  const size_t size = sizeof u[0];
  for (int e = 0; e < 30; e++)
    dr[e] = small(1000 + e);
  for (int count = 0; count <= 10; count++)
    for (int tangent = -1; tangent < w.d; tangent++) { /* -1: all; else r has this entry alone */
      double r[30];
      for (int e = 0; e < 30; e++)
        r[e] = tangent < 0 || e % w.d == tangent ? dr[e] : 0;
      for (int e = 0; e < 36; e++) {
        u[0][e] = e;
        a[0][e] = 2 * e;
      }
      for (int k = 1; k < 5; k++)
        memcpy(u[k], u[0], size);
      memcpy(a[1], a[0], size);
      for (int k = 0; k < count; k++) {
        add_column(c[k], r + w.d * k, u[0], a[0]);
        dlsi_contact_add_columns(&w.dense, c[k], r + w.d * k, u[1]);
        dlsi_contact_add_columns(&w.blocks, c[k], r + w.d * k, u[2]);
      }
      dlsi_contact_add_panel(&w.dense, count, c, r, u[3]);
      dlsi_contact_add_both(&w.dense, count, c, r, u[4], a[1]);
      for (int k = 1; k < 5; k++)
        ck_assert_mem_eq(u[k], u[0], size);
      ck_assert_mem_eq(a[1], a[0], size);
    }
}

/* W r + q and |W| |r| where `loaded` candidates carry a reaction, in one entry each or in all; 16
 * of them are read at once. */
TEST_EACH(any_number_of_reactions, 1, 4) {
  static double r[most_m], u[2][most_m], a[2][most_m];
  int order[most_nc];
  set_whole(_i, most_nc);
  const size_t size = (size_t)w.m * sizeof(double);
  for (int c = 0; c < most_nc; c++)
    order[c] = 12 * c % most_nc;
  for (int loaded = 0; loaded <= most_nc; loaded += loaded % 16 < 14 ? 7 : 1) {
    memcpy(u[0], w.q, size);
    memset(a[0], 0, size);
    for (int e = 0; e < w.m; e++) {
      const int c = e / w.d, entry = c % 4; /* 3: all entries */
      r[e] = c < loaded && (entry == 3 || entry % w.d == e % w.d) ? e % 5 + 1 : 0;
    }
    for (int c = 0; c < most_nc; c++)
      add_column(c, r + w.d * c, u[0], a[0]);
    const dls_contact *const storage[2] = {&w.dense, &w.blocks};
    for (int k = 0; k < 4; k++) {
      memset(a[1], 0x55, size);
      dlsi_contact_multiply(storage[k / 2], k % 2 ? order : NULL, r, u[1], a[1]);
      ck_assert_mem_eq(u[1], u[0], size);
      ck_assert_mem_eq(a[1], a[0], size);
      memset(u[1], 0x55, size);
      dlsi_contact_multiply(storage[k / 2], k % 2 ? order : NULL, r, u[1], NULL);
      ck_assert_mem_eq(u[1], u[0], size);
    }
    for (int k = 0; k < 2; k++) {
      memset(u[1], 0x55, size);
      dlsi_contact_apply(storage[k], r, u[1]);
      for (int e = 0; e < w.m; e++)
        ck_assert(u[1][e] == u[0][e] - w.q[e]);
    }
  }
}

/* Reactions are added in the order that is asked for: 2^53 + 1 - 2^53 is 0 or, in another order, 1
 * in numbers of 53 bits; dense, by blocks, of bodies. */
TEST(order_of_sums) {
  const double ones[9] = {1, 1, 1, 1, 1, 1, 1, 1, 1}, q[3] = {0}, mu[3] = {0};
  const double H[18] = {1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1};
  const int p[4] = {0, 3, 6, 9}, i[9] = {0, 1, 2, 0, 1, 2, 0, 1, 2};
  const int body[6] = {0, -1, 0, -1, 0, -1}, order[3] = {0, 2, 1};
  const double r[3] = {0x1p53, 1, -0x1p53};
  double work[6], u[3];
  dls_contact problem[3] = {
      {.W = {3, 3, 3, ones}}, {.Wb = {1, 3, p, i, ones}}, {.bodies = {3, 1, body, H, work}}};
  for (int k = 0; k < 3; k++) {
    problem[k].d = 1, problem[k].nc = 3, problem[k].q = q, problem[k].mu = mu;
    dlsi_contact_multiply(&problem[k], NULL, r, u, NULL);
    ck_assert(u[0] == 0 && u[2] == 0);
    dlsi_contact_multiply(&problem[k], order, r, u, NULL);
    ck_assert(u[0] == 1 && u[2] == 1);
  }
}

/* y = A^T x and y - A x of a few columns. */
TEST(panels_of_any_width) {
  double A[9 * 9], x[9], y[10], z[10];
  for (int e = 0; e < 81; e++)
    A[e] = small(e + 1);
  for (int e = 0; e < 9; e++)
    x[e] = small(100 + e);
  for (int m = 1; m <= 9; m++)
    for (int n = 0; n <= 9; n++) {
      y[n] = z[m] = 77; /* not touched */
      dlsi_panel_dot((size_t)m, n, A, x, y);
      for (int i = 0; i < m; i++)
        z[i] = i;
      dlsi_panel_subtract((size_t)m, n, A, x, z);
      for (int j = 0; j < n; j++) {
        double sum = 0;
        for (int i = 0; i < m; i++)
          sum += A[i + m * j] * x[i];
        ck_assert(y[j] == sum);
      }
      for (int i = 0; i < m; i++) {
        double sum = i;
        for (int j = 0; j < n; j++)
          sum -= A[i + m * j] * x[j];
        ck_assert(z[i] == sum);
      }
      ck_assert(y[n] == 77 && z[m] == 77);
    }
}

/* ---- rigid bodies ---------------------------------------------------------------------------- */

enum { bodies = 4, touching = 7 };

/* H r, H^T H r + q, |H|^T |H| |r| and the diagonal blocks for each shape that there is; body -1 is
 * fixed, and its H is not read. */
TEST_EACH(bodies_of_each_shape, 0, 4) {
  static const int shape[4][2] = {{1, 3}, {1, 6}, {2, 3}, {3, 6}};
  static const int body[2 * touching] = {0, 1, 3, -1, 2, 0, -1, 1, 3, 2, 1, 3, -1, -1};
  const int d = shape[_i][0], n = shape[_i][1], m = d * touching;
  double H[2 * touching * 18], q[3 * touching], r[3 * touching], mu[touching] = {0};
  double v[6 * bodies] = {0}, s[6 * bodies] = {0}, work[2 * 6 * bodies + 1];
  double u[3 * touching + 1], a[3 * touching + 1];
  for (int e = 0; e < 2 * touching * n * d; e++)
    H[e] = body[e / (n * d)] < 0 ? NAN : small(e + 1);
  for (int e = 0; e < m; e++) {
    q[e] = small(500 + e);
    r[e] = small(600 + e);
  }
  for (int k = 0; k < 2 * touching; k++)
    for (int e = 0; body[k] >= 0 && e < n * d; e++) {
      v[n * body[k] + e % n] += H[n * d * k + e] * r[d * (k / 2) + e / n];
      s[n * body[k] + e % n] += fabs(H[n * d * k + e] * r[d * (k / 2) + e / n]);
    }
  const dls_contact p = {
      .d = d, .nc = touching, .q = q, .mu = mu, .bodies = {n, bodies, body, H, work}};
  work[2 * n * bodies] = u[m] = a[m] = 77;
  memset(work, 0x55, sizeof(double) * (size_t)(2 * n * bodies));
  dlsi_contact_multiply(&p, NULL, r, u, a);
  ck_assert(work[2 * n * bodies] == 77 && u[m] == 77 && a[m] == 77);
  ck_assert_mem_eq(work, v, sizeof(double) * (size_t)(n * bodies));
  for (int i = 0; i < m; i++) {
    const int c = i / d;
    double sum = q[i], size = 0;
    for (int k = 2 * c; k < 2 * c + 2; k++)
      for (int l = 0; body[k] >= 0 && l < n; l++) {
        const double h = H[n * d * k + n * (i % d) + l];
        sum += h * v[n * body[k] + l];
        size += fabs(h) * s[n * body[k] + l];
      }
    ck_assert(u[i] == sum && a[i] == size);
  }
  for (int i = 0; i < m; i++)
    u[i] = 99;
  dlsi_contact_apply(&p, r, u); /* without q */
  double again[3 * touching];
  for (int i = 0; i < m; i++)
    again[i] = u[i] + q[i];
  for (int i = 0; i < m; i++)
    u[i] = 99;
  dlsi_bodies_unfold(&p, 2, 5, u); /* candidates 2, 3, 4 from work = H r */
  for (int i = 0; i < m; i++)
    ck_assert(u[i] == (i / d >= 2 && i / d < 5 ? again[i] : 99));
  for (int c = 0; c < touching; c++) {
    double block[10];
    block[d * d] = 77;
    dlsi_contact_diagonal(&p, c, block);
    for (int e = 0; e < d * d; e++) {
      double sum = 0;
      for (int k = 2 * c; k < 2 * c + 2; k++)
        for (int l = 0; body[k] >= 0 && l < n; l++)
          sum += H[n * d * k + n * (e % d) + l] * H[n * d * k + n * (e / d) + l];
      ck_assert(block[e] == sum);
    }
    ck_assert(block[d * d] == 77);
  }
}

/* A body that 46,341 candidates touch alone couples 46341^2 > 2^31 - 1 pairs, which is said at
 * once; the last one of three. */
TEST(too_many_blocks) {
  enum { nc = 46341 };
  int *body = malloc(2 * nc * sizeof *body), count = 7;
  double *H = calloc(6 * (size_t)nc, sizeof *H), *q = calloc(2 * (size_t)nc, sizeof *q);
  ck_assert(body && H && q);
  for (int k = 0; k < 2 * nc; k++)
    body[k] = k % 2 ? (k == 1 ? 0 : -1) : 2;
  const dls_contact p = {.d = 1, .nc = nc, .q = q, .mu = q + nc, .bodies = {3, 3, body, H, NULL}};
  REFUSES(SIZE, "bodies", -1, dls_bodies_count, &p, &count);
  ck_assert(last_refusal.value == (double)nc * nc && count == 7);
  free(body);
  free(H);
  free(q);
}

/* Scratch is lent to bodies without, and W by blocks formed with both: 2 = |(1, 1)|^2. Of other
 * storages nothing is done, and who comes with scratch has been checked. */
TEST(lent_scratch) {
  const int body[2] = {0, 1};
  const double H[6] = {1, 0, 0, 1, 0, 0}, bad[6] = {NAN}, q = 1, mu = 0, one = 1;
  double work[12];
  dlsi_formed formed = {.work = NULL};
  dls_contact given = {.d = 1, .nc = 1, .q = &q, .mu = &mu, .bodies = {3, 2, body, H, NULL}};
  const dls_contact dense = {.d = 1, .nc = 1, .q = &q, .mu = &mu, .W = {1, 1, 1, &one}};
  const dls_contact *p = &dense;
  ck_assert(!dlsi_lend(&formed, &p, NULL) && p == &dense);
  ck_assert(!dlsi_form_blocks(&formed, &p, NULL) && p == &dense && !formed.work);
  p = &given;
  ck_assert(!dlsi_lend(&formed, &p, NULL) && p == &formed.problem);
  ck_assert(p->bodies.work == formed.work && formed.work && formed.work_room == 12);
  ck_assert(p->bodies.H == H && p->q == &q && !p->Wb.x);
  for (int lent = 0; lent < 2; lent++) {
    given.bodies.work = lent ? work : NULL;
    p = &given;
    ck_assert_int_eq(dlsi_form_blocks(&formed, &p, NULL), DLS_OK);
    ck_assert(p == &formed.problem && p->bodies.work == (lent ? work : formed.work));
    ck_assert(p->Wb.n == 1 && p->Wb.p[1] == 1 && p->Wb.i[0] == 0 && p->Wb.x[0] == 2);
  }
  given.bodies.work = work;
  p = &given;
  ck_assert(!dlsi_lend(&formed, &p, NULL) && p == &given);
  given.bodies.work = NULL;
  given.bodies.H = bad;
  ck_assert(dlsi_form_blocks(&formed, &p, NULL) == DLS_E_NOT_FINITE && p == &given);
  dlsi_formed_free(&formed);
  ck_assert(!formed.work && !formed.x);
}

/* Memory that is held serves again if it is large enough. */
TEST(room_grows) {
  size_t room = 0;
  double *held = dlsi_make_room(NULL, &room, 4, sizeof *held);
  ck_assert(held && room == 4);
  ck_assert_ptr_eq(dlsi_make_room(held, &room, 4, sizeof *held), held);
  ck_assert_ptr_eq(dlsi_make_room(held, &room, 1, sizeof *held), held);
  ck_assert_uint_eq(room, 4);
  held = dlsi_make_room(held, &room, 5, sizeof *held);
  ck_assert(held && room == 5);
  held[4] = 1;
  ck_assert_ptr_null(dlsi_make_room(held, &room, SIZE_MAX / 4, sizeof *held)); /* held stays */
  ck_assert(room == 5 && held[4] == 1);
  free(held);
}
