/* room.c: keeps memory for a matrix and its factors, dense or sparse. It grows and never
 * shrinks. */
#include <limits.h>
#include <stdint.h>
#include <stdlib.h>

#include "linear/room.h"
#include "linear/sparse_lu.h"

dls_status dlsi_room_dense(dlsi_room *room, size_t side, dls_error *error) {
  if (side <= room->side) return DLS_OK;
  free(room->J);
  room->owner = NULL;
  room->J = side > SIZE_MAX / side ? NULL : dlsi_alloc(side * side, sizeof *room->J);
  room->side = room->J ? side : 0;
  return room->J ? DLS_OK : dlsi_no_memory(error);
}

dls_status dlsi_room_sparse(dlsi_room *room, int d, int nc, int blocks, dls_error *error) {
  const size_t D = (size_t)d, entries = D * D * (size_t)blocks + D * (size_t)nc;
  if (entries > INT_MAX) return dlsi_fail(error, DLS_E_SIZE, "blocks", -1, blocks, "are too many");
  if (!room->lu) {
    const dls_status status = dlsi_sparse_lu_create(&room->lu, error);
    if (status) return status;
  }
  if (entries > room->entries) {
    free(room->i);
    free(room->v);
    room->i = dlsi_alloc(entries, sizeof *room->i);
    room->v = dlsi_alloc(entries, sizeof *room->v);
    room->entries = room->i && room->v ? entries : 0;
    if (!room->entries) return dlsi_no_memory(error);
  }
  return dlsi_sparse_lu_reserve(room->lu, entries, error);
}

void dlsi_room_free(dlsi_room *room) {
  dlsi_sparse_lu_destroy(room->lu);
  free(room->J);
  free(room->i);
  free(room->v);
}
