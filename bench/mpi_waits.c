/*
 * mpi_waits.c: takes the CPU time within MPI out of the clock of bench/mpi.c.
 *
 * A rank that waits spins: its CPU seconds do not show its work, nor do its wall seconds on a
 * machine that others use, too. These functions replace MPI's own (its profiling interface, PMPI)
 * and time them. The clock that the program reads (linked with --wrap=clock_gettime) subtracts that
 * time: computation alone, without messages and waiting. Functions that MUMPS, BLACS and
 * libdelassus-mpi call; Fortran's by reference.
 */
#include <mpi.h>
#include <time.h>

static double within;
static int depth;

int __real_clock_gettime(clockid_t id, struct timespec *t);
int __wrap_clock_gettime(clockid_t id, struct timespec *t);

static double waits_clock(void) {
  struct timespec t = {0};
  (void)__real_clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int __wrap_clock_gettime(clockid_t id, struct timespec *t) {
  const int failed = __real_clock_gettime(id, t);
  if (failed || id != CLOCK_PROCESS_CPUTIME_ID) return failed;
  const double seconds = (double)t->tv_sec + 1e-9 * (double)t->tv_nsec - within;
  t->tv_sec = (time_t)seconds;
  t->tv_nsec = (long)(1e9 * (seconds - (double)t->tv_sec));
  return 0;
}

/* Runs `call` and counts its time, once where calls are nested. */
#define COUNTED(call)                                                                              \
  const double since = depth++ ? 0 : waits_clock();                                                \
  call;                                                                                            \
  if (!--depth) within += waits_clock() - since

#define FORTRAN(name, parameters, arguments)                                                       \
  void name##_ parameters;                                                                         \
  void p##name##_ parameters;                                                                      \
  void name##_ parameters {                                                                        \
    COUNTED(p##name##_ arguments);                                                                 \
  }
#define C(name, parameters, arguments)                                                             \
  int MPI_##name parameters {                                                                      \
    int answer;                                                                                    \
    COUNTED(answer = PMPI_##name arguments);                                                       \
    return answer;                                                                                 \
  }

FORTRAN(mpi_iprobe, (void *a, void *b, void *c, void *d, void *e, void *f), (a, b, c, d, e, f))
FORTRAN(mpi_probe, (void *a, void *b, void *c, void *d, void *e), (a, b, c, d, e))
FORTRAN(mpi_recv, (void *a, void *b, void *c, void *d, void *e, void *f, void *g, void *h),
        (a, b, c, d, e, f, g, h))
FORTRAN(mpi_send, (void *a, void *b, void *c, void *d, void *e, void *f, void *g),
        (a, b, c, d, e, f, g))
FORTRAN(mpi_isend, (void *a, void *b, void *c, void *d, void *e, void *f, void *g, void *h),
        (a, b, c, d, e, f, g, h))
FORTRAN(mpi_irecv, (void *a, void *b, void *c, void *d, void *e, void *f, void *g, void *h),
        (a, b, c, d, e, f, g, h))
FORTRAN(mpi_test, (void *a, void *b, void *c, void *d), (a, b, c, d))
FORTRAN(mpi_wait, (void *a, void *b, void *c), (a, b, c))
FORTRAN(mpi_waitall, (void *a, void *b, void *c, void *d), (a, b, c, d))
FORTRAN(mpi_barrier, (void *a, void *b), (a, b))
FORTRAN(mpi_bcast, (void *a, void *b, void *c, void *d, void *e, void *f), (a, b, c, d, e, f))
FORTRAN(mpi_reduce, (void *a, void *b, void *c, void *d, void *e, void *f, void *g, void *h),
        (a, b, c, d, e, f, g, h))
FORTRAN(mpi_allreduce, (void *a, void *b, void *c, void *d, void *e, void *f, void *g),
        (a, b, c, d, e, f, g))

C(Send, (const void *x, int n, MPI_Datatype t, int to, int tag, MPI_Comm c), (x, n, t, to, tag, c))
C(Rsend, (const void *x, int n, MPI_Datatype t, int to, int tag, MPI_Comm c), (x, n, t, to, tag, c))
C(Recv, (void *x, int n, MPI_Datatype t, int from, int tag, MPI_Comm c, MPI_Status *s),
  (x, n, t, from, tag, c, s))
C(Isend, (const void *x, int n, MPI_Datatype t, int to, int tag, MPI_Comm c, MPI_Request *r),
  (x, n, t, to, tag, c, r))
C(Irecv, (void *x, int n, MPI_Datatype t, int from, int tag, MPI_Comm c, MPI_Request *r),
  (x, n, t, from, tag, c, r))
C(Waitall, (int n, MPI_Request r[], MPI_Status s[]), (n, r, s))
C(Testall, (int n, MPI_Request r[], int *flag, MPI_Status s[]), (n, r, flag, s))
C(Bcast, (void *x, int n, MPI_Datatype t, int root, MPI_Comm c), (x, n, t, root, c))
C(Reduce, (const void *x, void *y, int n, MPI_Datatype t, MPI_Op op, int root, MPI_Comm c),
  (x, y, n, t, op, root, c))
C(Allreduce, (const void *x, void *y, int n, MPI_Datatype t, MPI_Op op, MPI_Comm c),
  (x, y, n, t, op, c))
