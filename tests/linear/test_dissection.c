/* test_dissection.c: orders by METIS: each unknown once, those of a node in a row, whatever else is
 * listed; little fill; signals of the host. */
#define _XOPEN_SOURCE 600 /* sigaction, setitimer */

#include <signal.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "contact/contact.h"
#include "linear/cholesky.h"
#include "linear/dissection.h"
#include "run.h"

#if WITH_MUMPS

enum { side = 12, nodes = side * side, most_unknowns = 3 * nodes, most_listed = 200 * nodes };

static struct {
  int n;
  size_t entries;
  int row[most_listed], col[most_listed], order[most_unknowns];
} G;

static void list(int i, int j) {
  G.row[G.entries] = 1 + i;
  G.col[G.entries++] = 1 + j;
}

/* A grid of side x side nodes with d unknowns each, coupled along edges and diagonals: the lower
 * triangle; `turn` 1: with each entry twice and the diagonal. */
static void list_grid(int d, int turn) {
  G.n = d * nodes;
  G.entries = 0;
  for (int node = 0; node < nodes; node++)
    for (int k = 0; k < 5; k++) {
      const int column = node % side + (int[]){0, -1, 0, 1, -1}[k];
      const int row = node / side - (k > 1 ? 1 : 0);
      if (column < 0 || column >= side || row < 0) continue;
      const int other = column + side * row;
      for (int i = 0; i < d; i++)
        for (int j = 0; j < d; j++) {
          if (k == 0 && i <= j) {
            if (turn && i == j) list(d * node + i, d * node + i);
            continue;
          }
          for (int again = 0; again <= turn; again++)
            list(d * node + i, d * other + j);
        }
    }
}

static void dissect(void) {
  memset(G.order, -1, sizeof G.order);
  ck_assert_int_eq(dlsi_dissection(G.n, G.entries, G.row, G.col, G.order, NULL), DLS_OK);
  int seen[most_unknowns] = {0};
  for (int k = 0; k < G.n; k++) {
    ck_assert(G.order[k] >= 0 && G.order[k] < G.n);
    seen[G.order[k]]++;
  }
  for (int k = 0; k < G.n; k++)
    ck_assert_int_eq(seen[k], 1);
  for (int k = G.n; k < most_unknowns; k++)
    ck_assert_int_eq(G.order[k], -1);
}

/* The unknowns of a node stand in a row, ascending, in the order of the nodes alone; entries listed
 * twice and those of the diagonal change nothing. */
TEST_EACH(unknowns_of_a_node, 0, 3) {
  const int d = 1 + _i;
  int alone[nodes], first[most_unknowns];
  list_grid(1, 0);
  dissect();
  memcpy(alone, G.order, sizeof alone);
  list_grid(d, 0);
  dissect();
  memcpy(first, G.order, sizeof first);
  for (int k = 0; k < G.n; k++)
    ck_assert(first[k] % d == k % d && first[k] / d == first[k - k % d] / d);
  if (d == 1) ck_assert_mem_eq(alone, first, sizeof alone);
  list_grid(d, 1);
  dissect();
  ck_assert_mem_eq(G.order, first, (size_t)G.n * sizeof first[0]);
}

/* Operations of a Cholesky factor in this order. */
static double operations(const int *order) {
  int turn[most_unknowns];
  for (int k = 0; k < G.n; k++)
    turn[order[k]] = k + 1;
  dlsi_cholesky *L;
  ck_assert_int_eq(dlsi_cholesky_create(&L, G.n, G.entries, G.row, G.col, turn, 0, NULL), DLS_OK);
  const double flops = L->flops;
  dlsi_cholesky_destroy(L);
  return flops;
}

/* On a grid the factor takes much less work than in the order of rows, of which the band is full:
 * less than two thirds on 12 x 12 nodes. */
TEST_EACH(little_fill, 0, 3) {
  int rows[most_unknowns];
  list_grid(1 + _i, 0);
  dissect();
  for (int k = 0; k < G.n; k++)
    rows[k] = k;
  ck_assert_double_lt(operations(G.order), 0.67 * operations(rows));
}

/* A star with as many leaves, a pair of whose unknowns is alike but for each other; a pair with
 * equal neighbourhoods that are not neighbours is no node; unknowns alone. */
TEST(odd_graphs) {
  G.n = 5;
  G.entries = 0;
  dissect(); /* no entry at all */
  for (int i = 1; i < 5; i++)
    list(i, 0);
  dissect();
  list(2, 1);
  dissect();
  int at[5];
  for (int k = 0; k < 5; k++)
    at[G.order[k]] = k;
  ck_assert_int_eq(at[2], at[1] + 1);
  G.n = 1;
  G.entries = 0;
  list(0, 0);
  dissect();
}

static volatile sig_atomic_t terms;

static void on_term(int number) {
  (void)number;
  terms++;
}

static void on_alarm(int number) {
  (void)number;
  (void)kill(getpid(), SIGTERM);
}

static void handle(int number, void (*handler)(int)) {
  struct sigaction action;
  memset(&action, 0, sizeof action);
  action.sa_handler = handler;
  ck_assert_int_eq(sigaction(number, &action, NULL), 0);
}

/* METIS would put a handler back for one signal only. */
TEST(handlers_stay) {
  handle(SIGTERM, on_term);
  handle(SIGABRT, on_term);
  list_grid(2, 0);
  dissect();
  for (int k = 0; k < 4; k++)
    ck_assert_int_eq(raise(k % 2 ? SIGABRT : SIGTERM), 0);
  ck_assert_int_eq(terms, 4);
}

/* Twelve SIGTERMs, each at another moment of the 20 ms that METIS takes for this tree: a handler
 * that leaves malloc by a jump spoils the heap or never ends. */
TEST(term_while_ordering) {
  enum { n = 20000 };
  int *const row = malloc(3 * n * sizeof *row), *const col = row + n, *const order = col + n;
  ck_assert_ptr_nonnull(row);
  for (int k = 0; k < n - 1; k++) {
    row[k] = k + 2;
    col[k] = 1 + (int)((unsigned)k * 7919u % (unsigned)(k + 1));
  }
  handle(SIGTERM, on_term);
  handle(SIGALRM, on_alarm);
  for (int t = 1; t <= 12; t++) {
    terms = 0;
    const struct itimerval after = {.it_value = {.tv_usec = 1500 * t}};
    ck_assert_int_eq(setitimer(ITIMER_REAL, &after, NULL), 0);
    dls_error e = {0};
    ck_assert_msg(dlsi_dissection(n, n - 1, row, col, order, &e) == DLS_OK, "%s", e.message);
    while (!terms) /* a machine on which all is done sooner */
      (void)nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    ck_assert_int_eq(terms, 1);
  }
  free(row);
}

TEST(every_malloc_fails) {
  list_grid(2, 0);
  dls_error e = {0};
  MALLOCS_FAIL(dlsi_dissection(G.n, G.entries, G.row, G.col, G.order, &e), e.index == -1, DLS_OK,
               5);
  ck_assert_int_eq(mallocs_failed, 5);
}

#endif
