/*
 * agree.c: makes the error of one rank an error of all.
 *
 * Every public function checks its arguments and allocates on each rank, then calls this before the
 * next collective call: a rank that has failed calls it, too, so that no other rank waits for it in
 * vain.
 */
#define _POSIX_C_SOURCE 200809L /* clock_gettime */

#include <stdio.h>
#include <string.h>
#include <time.h>

#include "mpi_internal.h"

/* The fields of an error that can be sent: text in place of pointers. */
typedef struct travelling {
  long long index;
  double value;
  char argument[32], message[200];
} travelling;

/* arguments that errors name: a string of static storage on every rank */
static const char *const arguments[] = {"out",
                                        "comm",
                                        "model",
                                        "d",
                                        "factorization",
                                        "rows",
                                        "entries",
                                        "row",
                                        "col",
                                        "x",
                                        "nodes",
                                        "HN",
                                        "HT",
                                        "HN.p",
                                        "HN.i",
                                        "HN.x",
                                        "HT.p",
                                        "HT.i",
                                        "HT.x",
                                        "settings",
                                        "memory_limit",
                                        "reduction",
                                        "certificate",
                                        "global",
                                        "solver",
                                        "f",
                                        "g",
                                        "r",
                                        "mu",
                                        "W",
                                        "Ks",
                                        "q",
                                        "gather",
                                        "tol",
                                        "max_iterations",
                                        "cpu_seconds",
                                        "warm_start",
                                        "blocks",
                                        "threads",
                                        "limits",
                                        "limits.tol",
                                        "limits.max_iterations",
                                        "limits.cpu_seconds",
                                        "limits.blocks",
                                        "limits.warm_start",
                                        "form_W"};

static const char *agree_argument(const char *name) {
  for (size_t k = 0; k < sizeof arguments / sizeof arguments[0]; k++)
    if (!strcmp(arguments[k], name)) return arguments[k];
  return "";
}

dls_status dlsi_agree(MPI_Comm comm, dls_status status, dls_error *error) {
  int rank, ranks;
  (void)MPI_Comm_rank(comm, &rank);
  (void)MPI_Comm_size(comm, &ranks);
  int first = status < 0 ? rank : ranks, failed;
  (void)MPI_Allreduce(&first, &failed, 1, MPI_INT, MPI_MIN, comm);
  if (failed == ranks) return DLS_OK;
  int answer = (int)status;
  travelling told = {0};
  if (rank == failed) {
    const int alone = ranks == 1;
    told.index = error->index;
    told.value = error->value;
    (void)snprintf(told.argument, sizeof told.argument, "%s", error->argument);
    if (alone)
      (void)snprintf(told.message, sizeof told.message, "%s", error->message);
    else
      (void)snprintf(told.message, sizeof told.message, "rank %d: %.180s", rank, error->message);
  }
  (void)MPI_Bcast(&answer, 1, MPI_INT, failed, comm);
  (void)MPI_Bcast(&told, (int)sizeof told, MPI_BYTE, failed, comm);
  *error = (dls_error){(dls_status)answer, "",         agree_argument(told.argument),
                       told.index,         told.value, ""};
  memcpy(error->message, told.message, sizeof error->message);
  return (dls_status)answer;
}

dlsi_mpi_clock dlsi_mpi_now(void) {
  struct timespec t = {0};
  (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (dlsi_mpi_clock){MPI_Wtime(), (double)t.tv_sec + 1e-9 * (double)t.tv_nsec};
}
