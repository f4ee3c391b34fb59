/* shares.h: a box of bench/reduction_boxes.c cut in shares for the ranks; checks without forks. */
#ifndef SHARES_H
#define SHARES_H

#include "bench/reduction_boxes.h"
#include "delassus/mpi.h"

/* How rows and nodes are cut: in even parts; four fifths to rank 0; all to the last rank, so that
 * others have nothing, not even an entry. */
typedef enum cut { CUT_EVEN, CUT_UNEVEN, CUT_LAST, CUTS } cut;

/* The share of this rank of the box; borrows the box's arrays but for row, col and HT. */
typedef struct share {
  dls_mpi_model model;
  int first_row, first_node;
  int *row, *col, *pn, *pt;
  const double *f, *g, *mu; /* of this rank */
} share;

/* Takes the share of this rank; f: n, g: d nodes, mu: nodes of all. The entries are those of the
 * columns of K that the rank has as rows. */
share share_take(const dls_model *model, cut how, const double *f, const double *g,
                 const double *mu);

/* That of one of so many ranks. */
share share_of(const dls_model *model, cut how, int rank, int ranks, const double *f,
               const double *g, const double *mu);
void share_free(share *s);

/* Counts a failure, with its place, if `holds` is 0. */
#define EXPECT(holds, ...) expect_at(holds, __FILE__, __LINE__, __VA_ARGS__)
void expect_at(int holds, const char *file, int line, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* Returns the number of failures on all ranks; prints a line on rank 0. Collective. */
int expect_end(const char *name);

/* Returns max |x_i - y_i| / max |all|, infinite for NaN. x, y: n; all: count. */
double apart(const double *x, const double *y, int n, const double *all, int count);

#endif
