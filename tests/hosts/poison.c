/*
 * poison.c: a host whose global symbols have the names of MUMPS and of what MUMPS calls, of another
 * make: MPI, BLACS, SCOTCH. The library may reach none of them. tests/install.sh links the program
 * with the shared and with the static library.
 */
#include <stdio.h>

#include "unsymmetric.h"

static int touched;

#define OTHER(name)                                                                                \
  int name(void);                                                                                  \
  int name(void) {                                                                                 \
    touched++;                                                                                     \
    return 0;                                                                                      \
  }
OTHER(dmumps_c)
OTHER(dmumps_)
OTHER(dmumps_f77_)
OTHER(mumps_abort_)
OTHER(mpi_init_)
OTHER(mpi_initialized_)
OTHER(mpi_comm_dup_)
OTHER(mpi_comm_free_)
OTHER(mpi_comm_rank_)
OTHER(mpi_comm_size_)
OTHER(mpi_comm_split_)
OTHER(mpi_bcast_)
OTHER(mpi_reduce_)
OTHER(mpi_allreduce_)
OTHER(mpi_barrier_)
OTHER(mpi_gather_)
OTHER(mpi_iprobe_)
OTHER(mpi_probe_)
OTHER(mpi_isend_)
OTHER(mpi_send_)
OTHER(mpi_irecv_)
OTHER(mpi_recv_)
OTHER(mpi_wait_)
OTHER(mpi_wtime_)
OTHER(mpi_pack_size_)
OTHER(mpi_attr_get_)
OTHER(MPI_Init)
OTHER(MPI_Comm_rank)
OTHER(MPI_Comm_size)
OTHER(blacs_gridinit_)
OTHER(numroc_)
OTHER(mumps_io_init_)
OTHER(SPACE_ordering)
OTHER(esmumps)
OTHER(SCOTCH_graphOrder)

int main(void) {
  const int wrong = unsymmetric_wrong();
  if (touched) printf("%d calls of the host's MUMPS, MPI or SCOTCH\n", touched);
  return wrong || touched;
}
