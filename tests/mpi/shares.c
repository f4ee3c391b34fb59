/* shares.c: implements shares.h. */
#include "shares.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static int failures;

void expect_at(int holds, const char *file, int line, const char *format, ...) {
  if (holds) return;
  int rank;
  va_list args;
  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  (void)fprintf(stderr, "%s:%d: rank %d: ", file, line, rank);
  va_start(args, format);
  (void)vfprintf(stderr, format, args);
  va_end(args);
  (void)fputc('\n', stderr);
  failures++;
}

int expect_end(const char *name) {
  int rank, ranks, sum;
  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  (void)MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  (void)MPI_Allreduce(&failures, &sum, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
  if (rank == 0) printf("%s on %d ranks: %d failures\n", name, ranks, sum);
  return sum;
}

/* Returns where the part of `rank` begins among n. */
static int cut_at(cut how, int n, int rank, int ranks) {
  if (rank >= ranks) return n;
  if (rank == 0 || how == CUT_LAST) return 0;
  if (how == CUT_EVEN) return (int)((long)n * rank / ranks);
  return 4 * n / 5 + (int)((long)(n - 4 * n / 5) * (rank - 1) / (ranks - 1));
}

share share_take(const dls_model *model, cut how, const double *f, const double *g,
                 const double *mu) {
  int rank, ranks;
  (void)MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  (void)MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  return share_of(model, how, rank, ranks, f, g, mu);
}

share share_of(const dls_model *model, cut how, int rank, int ranks, const double *f,
               const double *g, const double *mu) {
  const dls_sparse *K = &model->Ks;
  const int d = model->d, lo = cut_at(how, model->n, rank, ranks),
            hi = cut_at(how, model->n, rank + 1, ranks);
  const int a = cut_at(how, model->nodes, rank, ranks),
            b = cut_at(how, model->nodes, rank + 1, ranks);
  const int begin = K->p[lo], count = K->p[hi] - begin;
  share s = {.first_row = lo, .first_node = a, .f = f + lo, .g = g + d * a, .mu = mu + a};
  s.row = malloc((size_t)(count + 1) * sizeof *s.row);
  s.col = malloc((size_t)(count + 1) * sizeof *s.col);
  s.pn = malloc((size_t)(b - a + 1) * sizeof *s.pn);
  s.pt = malloc((size_t)((d - 1) * (b - a) + 1) * sizeof *s.pt);
  if (!s.row || !s.col || !s.pn || !s.pt) MPI_Abort(MPI_COMM_WORLD, 1);
  for (int j = lo; j < hi; j++)
    for (int k = K->p[j]; k < K->p[j + 1]; k++) {
      s.row[k - begin] = K->i[k];
      s.col[k - begin] = j;
    }
  const dls_sparse *N = &model->HN, *T = &model->HT;
  for (int k = 0; k <= b - a; k++)
    s.pn[k] = N->p[a + k] - N->p[a];
  for (int k = 0; k <= (d - 1) * (b - a); k++)
    s.pt[k] = T->p[(d - 1) * a + k] - T->p[(d - 1) * a];
  s.model = (dls_mpi_model){.d = d,
                            .factorization = model->factorization,
                            .rows = hi - lo,
                            .entries = (size_t)count,
                            .row = s.row,
                            .col = s.col,
                            .x = K->x + begin,
                            .nodes = b - a,
                            .HN = {model->n, b - a, s.pn, N->i + N->p[a], N->x + N->p[a]},
                            .HT = {model->n, (d - 1) * (b - a), s.pt, T->i + T->p[(d - 1) * a],
                                   T->x + T->p[(d - 1) * a]}};
  return s;
}

void share_free(share *s) {
  free(s->row);
  free(s->col);
  free(s->pn);
  free(s->pt);
}

double apart(const double *x, const double *y, int n, const double *all, int count) {
  double most = 0, scale = 0;
  for (int i = 0; i < n; i++)
    if (!(fabs(x[i] - y[i]) <= most)) most = fabs(x[i] - y[i]);
  for (int i = 0; i < count; i++)
    if (fabs(all[i]) > scale) scale = fabs(all[i]);
  return most == 0 ? 0 : most <= 1e300 ? most / scale : INFINITY;
}
