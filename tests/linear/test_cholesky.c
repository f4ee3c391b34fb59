/* test_cholesky.c: the sparse Cholesky factor by supernodes, and the two halves of a solve. */
#include "cases.h"
#include "contact/contact.h"
#include "linear/cholesky.h"
#include "run.h"

#if WITH_MUMPS

enum { most_n = 90, most_entries = most_n * most_n };

/* A: dense and its lower triangle as entries, in any order and some in halves. */
typedef struct matrix {
  int n, kept, row[most_entries], col[most_entries], order[most_n];
  size_t entries;
  double x[most_entries], A[most_n * most_n], b[most_n];
} matrix;

static matrix M;
static void add_entry(int i, int j, double a) {
  const int turned = uniform() < 0; /* of which triangle an entry is does not matter */
  M.row[M.entries] = 1 + (turned ? j : i);
  M.col[M.entries] = 1 + (turned ? i : j);
  M.x[M.entries++] = a;
  M.A[i + j * M.n] += a;
  if (i != j) M.A[j + i * M.n] += a;
}

/* The number-th matrix: of 1 to 89 unknowns, of every density, with nothing, some or all of it
 * kept, in a random order. */
static void make_matrix(int number) {
  memset(&M, 0, sizeof M);
  set_seed(77 + (uint64_t)number);
  M.n = 1 + (number * 37) % 89;
  M.kept = number % 4 == 0 ? 0 : number % 4 == 1 ? M.n / 3 : number % 4 == 2 ? M.n / 9 : M.n;
  const double density = number % 5 == 4 ? 0.6 : 0.02 * (number % 5);
  for (int j = 0; j < M.n; j++)
    for (int i = j + 1; i < M.n; i++)
      if (fabs(uniform()) < density || (number % 3 == 0 && i == j + 1))
        for (int half = 0; half < 1 + (i % 7 == 0); half++)
          add_entry(i, j, uniform());
  for (int j = 0; j < M.n; j++) { /* diagonally dominant */
    double sum = 1;
    for (int i = 0; i < M.n; i++)
      sum += fabs(M.A[i + j * M.n]);
    add_entry(j, j, sum);
    M.b[j] = uniform();
    M.order[j] = j + 1;
  }
  for (int j = M.n - 1; j > 0; j--) {
    const int i = (int)(fabs(uniform()) * (j + 1)) % (j + 1), at = M.order[i];
    M.order[i] = M.order[j];
    M.order[j] = at;
  }
}

static dlsi_cholesky *analysed(void) {
  dlsi_cholesky *L = NULL;
  ck_assert_int_eq(dlsi_cholesky_create(&L, M.n, M.entries, M.row, M.col, M.order, M.kept, NULL),
                   DLS_OK);
  return L;
}

/* |A x - b| <= rounding |A||x| */
static void assert_solves(const double *x, const double *b) {
  double Ax[most_n] = {0}, size = 0;
  for (int j = 0; j < M.n; j++)
    for (int i = 0; i < M.n; i++) {
      Ax[i] += M.A[i + j * M.n] * x[j];
      size = fmax(size, fabs(M.A[i + j * M.n] * x[j]));
    }
  for (int i = 0; i < M.n; i++)
    ck_assert_double_le(fabs(Ax[i] - b[i]), 4 * M.n * DBL_EPSILON * size);
}

/* One right-hand side, several at once to rounding the same, and again after a new factor. */
TEST_EACH(solves, 0, 120) {
  make_matrix(_i);
  dlsi_cholesky *L = analysed();
  double pivot = 0, X[3 * most_n], x[most_n], again[most_n];
  ck_assert_int_eq(dlsi_cholesky_factor(L, M.x, &pivot), 0);
  memcpy(x, M.b, sizeof x);
  ck_assert_int_eq(dlsi_cholesky_solve(L, x, 1, NULL), DLS_OK);
  assert_solves(x, M.b);
  for (int k = 0; k < 3 * M.n; k++)
    X[k] = (1 + k / M.n) * M.b[k % M.n];
  ck_assert_int_eq(dlsi_cholesky_solve(L, X, 3, NULL), DLS_OK);
  for (int k = 0; k < 3; k++) {
    double b[most_n];
    scale_vector(b, M.b, 1 + k, M.n);
    assert_solves(X + k * M.n, b);
  }
  ck_assert_int_eq(dlsi_cholesky_factor(L, M.x, &pivot), 0);
  memcpy(again, M.b, sizeof again);
  ck_assert_int_eq(dlsi_cholesky_solve(L, again, 1, NULL), DLS_OK);
  ck_assert_mem_eq(again, x, (size_t)M.n * sizeof *x);
  dlsi_cholesky_destroy(L);
}

/* condense, then expand for one h on c after the other: A x = b + (0, h). b may be 0. */
TEST_EACH(halves_make_a_solve, 0, 120) {
  make_matrix(_i);
  dlsi_cholesky *L = analysed();
  double pivot = 0, z[most_n], x[most_n], load[most_n];
  ck_assert_int_eq(dlsi_cholesky_factor(L, M.x, &pivot), 0);
  const double *S = dlsi_cholesky_of_kept(L);
  ck_assert_int_eq(S == NULL, M.kept == 0);
  const int b = M.kept;
  for (int turn = 0; turn < 4; turn++) {
    const int loaded = turn < 2;
    if (turn % 2 == 0) dlsi_cholesky_condense(L, loaded ? M.b : NULL, z);
    double xc[most_n];
    for (int i = 0; i < M.n; i++)
      load[i] = loaded ? M.b[i] : 0;
    for (int k = 0; k < b; k++) {
      const double h = uniform();
      xc[k] = z[k] + h;
      load[L->unknown[M.n - b + k]] += h;
    }
    for (int k = 0; k < b; k++) { /* x_c = S^-1 (z + h), by the factor L of S */
      for (int j = 0; j < k; j++)
        xc[k] -= S[k + j * b] * xc[j];
      xc[k] /= S[k + k * b];
    }
    for (int k = b - 1; k >= 0; k--) {
      for (int j = k + 1; j < b; j++)
        xc[k] -= S[j + k * b] * xc[j];
      xc[k] /= S[k + k * b];
    }
    dlsi_cholesky_expand(L, xc, x);
    assert_solves(x, load);
    for (int k = 0; k < b; k++)
      ck_assert(x[L->unknown[M.n - b + k]] == xc[k]);
  }
  dlsi_cholesky_destroy(L);
}

/* The order: c stands last as it was given, and every unknown stands once. */
TEST_EACH(kept_stand_last, 0, 40) {
  make_matrix(_i);
  dlsi_cholesky *L = analysed();
  int seen[most_n] = {0};
  for (int k = 0; k < M.n; k++) {
    seen[L->unknown[k]]++;
    ck_assert_int_eq(L->place[L->unknown[k]], k);
    if (k >= M.n - M.kept) ck_assert_int_eq(M.order[L->unknown[k]], k + 1);
  }
  for (int k = 0; k < M.n; k++)
    ck_assert_int_eq(seen[k], 1);
  dlsi_cholesky_destroy(L);
}

/* A negative pivot is told with its position, and a good matrix is factored all the same next. */
TEST_EACH(indefinite_is_told, 0, 40) {
  make_matrix(_i);
  dlsi_cholesky *L = analysed();
  double pivot = 7;
  const int bad = M.n / 2;
  const size_t at = M.entries - (size_t)M.n + (size_t)bad;
  const double good = M.x[at];
  M.x[at] = -good;
  const int failed = dlsi_cholesky_factor(L, M.x, &pivot);
  ck_assert_int_eq(L->unknown[failed - 1], bad);
  ck_assert(pivot <= 0);
  M.x[at] = good;
  ck_assert_int_eq(dlsi_cholesky_factor(L, M.x, &pivot), 0);
  double x[most_n];
  memcpy(x, M.b, sizeof x);
  ck_assert_int_eq(dlsi_cholesky_solve(L, x, 1, NULL), DLS_OK);
  assert_solves(x, M.b);
  dlsi_cholesky_destroy(L);
}

/* What the analysis says of panels follows from supernodes and rows: places, sizes, operations. The
 * rows of a supernode ascend, come after it and hold those of each column of A. */
TEST_EACH(panels_by_definition, 0, 120) {
  make_matrix(_i);
  dlsi_cholesky *L = analysed();
  double flops = 0;
  size_t panel = 0, update = 0;
  int longest = 0;
  ck_assert(L->first[0] == 0 && L->first[L->count] == M.n && L->start[0] == 0);
  if (M.kept > 0) ck_assert_int_eq(L->first[L->count - 1], M.n - M.kept);
  for (int s = 0; s < L->count; s++) {
    const int first = L->first[s], end = L->first[s + 1], columns = end - first;
    const int rows = (int)(L->start[s + 1] - L->start[s]), *row = L->row + L->start[s];
    const double c = columns, r = rows;
    ck_assert(columns > 0 && L->panel[s] == panel);
    panel += (size_t)((columns + rows) * columns);
    flops += c * c * c / 3 + r * c * c + r * r * c;
    longest = columns + rows > longest ? columns + rows : longest;
    for (int k = first; k < end; k++)
      ck_assert_int_eq(L->owner[k], s);
    for (int k = 0; k < rows; k++) {
      ck_assert(row[k] >= end && row[k] < M.n && (k == 0 || row[k] > row[k - 1]));
      int width = 0; /* of the rows from k on, those in the supernode of row k */
      while (k + width < rows && L->owner[row[k + width]] == L->owner[row[k]])
        width++;
      const size_t size = (size_t)((rows - k) * width);
      if ((k == 0 || L->owner[row[k - 1]] != L->owner[row[k]]) && size > update) update = size;
    }
    for (int k = first; k < end; k++)
      for (int i = end; i < M.n; i++) {
        int found = M.A[L->unknown[i] + M.n * L->unknown[k]] == 0;
        for (int e = 0; !found && e < rows; e++)
          found = row[e] == i;
        ck_assert(found);
      }
  }
  ck_assert(L->panel[L->count] == panel && L->update == update && L->longest == longest);
  ck_assert_double_eq_tol(L->flops, flops, 1e-12 * flops);
  dlsi_cholesky_destroy(L);
}

/* An entry (i, j) counted from 0, for an order that is that of the unknowns. */
static void add_place(int i, int j) {
  M.row[M.entries] = 1 + i;
  M.col[M.entries++] = 1 + j;
}

/* Supernodes of a path in its order. The last two unknowns are one from the start; a panel of width
 * w takes the column before it while its zeros, 1 + 2 + .. + (w - 1), are at most (w + 1)^2 / 3: up
 * to w = 7, which makes 8. The one before begins with a column of two rows, and w zeros come in, of
 * 1 + .. + w <= (w + 2) (w + 1) / 3: up to w = 4, which makes 5. */
TEST_EACH(supernodes_of_a_path, 1, 17) {
  memset(&M, 0, sizeof M);
  M.n = _i;
  for (int k = 0; k < M.n; k++) {
    M.order[k] = k + 1;
    add_place(k, k);
    if (k > 0) add_place(k, k - 1);
  }
  dlsi_cholesky *L = analysed();
  ck_assert_int_eq(L->count, _i <= 8 ? 1 : _i <= 13 ? 2 : 3);
  if (_i > 8) ck_assert_int_eq(L->first[L->count - 1], _i - 8);
  if (_i > 13) ck_assert_int_eq(L->first[1], _i - 13);
  dlsi_cholesky_destroy(L);
}

/* Cliques of a and b unknowns, one of the second tied to all of the first: merged, the first has a
 * columns with b - 1 zeros each, which may be a hundred, and no more than a third of the panel. */
TEST_EACH(supernodes_of_cliques, 0, 7) {
  static const struct {
    int a, b, count;
  } at[] = {{10, 11, 1}, {10, 12, 2}, {1, 80, 1}, {4, 26, 1}, {4, 27, 2}, {20, 6, 1}, {20, 7, 2}};
  const int a = at[_i].a, b = at[_i].b;
  memset(&M, 0, sizeof M);
  M.n = a + b;
  for (int j = 0; j < M.n; j++) {
    M.order[j] = j + 1;
    for (int i = j; i < M.n; i++)
      if (j >= a || i <= a) add_place(i, j);
  }
  dlsi_cholesky *L = analysed();
  ck_assert_int_eq(L->count, at[_i].count);
  if (at[_i].count == 2) ck_assert(L->first[1] == a && L->start[1] == 1 && L->row[0] == a);
  dlsi_cholesky_destroy(L);
}

/* The pivot that fails is told: of (1 2; 2 1) the second one, -3, in one panel or where 0 is a
 * panel of its own, before c; of diag(1, -5, 1) -5. */
TEST_EACH(pivots_by_hand, 0, 2) {
  memset(&M, 0, sizeof M);
  M.n = 3;
  M.kept = _i % 2;
  const int places[5][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 0}, {2, 1}};
  for (int k = 0; k < 5; k++)
    add_place(places[k][0], places[k][1]);
  for (int k = 0; k < 3; k++)
    M.order[k] = k + 1;
  dlsi_cholesky *L = analysed();
  double pivot = 7, x[3] = {4, 2, 6};
  ck_assert_int_eq(dlsi_cholesky_factor(L, (double[]){1, 1, 1, 2, 0}, &pivot), 2);
  ck_assert(pivot == -3);
  ck_assert_int_eq(dlsi_cholesky_factor(L, (double[]){1, -5, 1, 0, 0}, &pivot), 2);
  ck_assert(pivot == -5);
  ck_assert_int_eq(dlsi_cholesky_factor(L, (double[]){4, 1, 3, 0, 2}, &pivot), 3);
  ck_assert(pivot == -1);
  ck_assert_int_eq(dlsi_cholesky_factor(L, (double[]){-1, 1, 1, 0, 0}, &pivot), 1);
  ck_assert(pivot == -1);
  ck_assert_int_eq(dlsi_cholesky_factor(L, (double[]){4, 1, 4, 2, 0}, &pivot), 2);
  ck_assert(pivot == 0);
  ck_assert_int_eq(dlsi_cholesky_factor(L, (double[]){4, 1, 5, 0, 2}, &pivot), 0);
  ck_assert(pivot == 0);
  ck_assert_int_eq(dlsi_cholesky_solve(L, x, 1, NULL), DLS_OK);
  ck_assert(x[0] == 1 && x[1] == -2 && x[2] == 2);
  dlsi_cholesky_destroy(L);
}

TEST_EACH(every_malloc_fails, 0, 4) {
  make_matrix(_i);
  dlsi_cholesky *L = NULL;
  long k;
  MALLOCS_FAIL(dlsi_cholesky_create(&L, M.n, M.entries, M.row, M.col, M.order, M.kept, NULL), !L,
               DLS_OK, 8);
  double pivot = 0, X[2 * most_n] = {0};
  int failed = -1;
  for (k = 0; failed;) {
    malloc_fails_at(++k);
    failed = dlsi_cholesky_factor(L, M.x, &pivot);
    malloc_fails_at(0);
    ck_assert(failed == 0 || failed == -1);
  }
  ck_assert_int_eq(k, 3);
  malloc_fails_at(1);
  const dls_status one = dlsi_cholesky_solve(L, X, 1, NULL);
  const dls_status two = dlsi_cholesky_solve(L, X, 2, NULL);
  malloc_fails_at(0);
  ck_assert_int_eq(one, DLS_OK);
  ck_assert_int_eq(two, DLS_E_MEMORY);
  dlsi_cholesky_destroy(L);
  dlsi_cholesky_destroy(NULL);
}

#endif
