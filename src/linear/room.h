/* room.h: keeps memory for a matrix and its factors, dense or sparse. */
#ifndef DLSI_ROOM_H
#define DLSI_ROOM_H

#include "contact/contact.h"

/* Room for a matrix and its factors. Methods that run one after the other may share it: only the
 * owner still has its factors. */
typedef struct dlsi_room {
  double *J; /* side^2 */
  size_t side;
  int *i;    /* entries: rows of a sparse matrix */
  double *v; /* entries: values */
  size_t entries;
  struct dlsi_sparse_lu *lu; /* NULL if never needed, or without MUMPS */
  const void *owner;         /* the workspace that wrote to J last; NULL: none */
} dlsi_room;

/* Make room for a side x side matrix, or for W of `blocks` d x d blocks and a diagonal. The
 * contents are lost. DLS_E_MEMORY, DLS_E_SIZE; without MUMPS dlsi_room_sparse returns
 * DLS_E_UNSUPPORTED. */
dls_status dlsi_room_dense(dlsi_room *room, size_t side, dls_error *error);
dls_status dlsi_room_sparse(dlsi_room *room, int d, int nc, int blocks, dls_error *error);

/* Frees the memory, not *room itself. */
void dlsi_room_free(dlsi_room *room);

#endif
