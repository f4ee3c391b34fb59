/* test_room.c: room for a matrix grows, never shrinks, and ends at what an int counts. */
#include "linear/room.h"
#include "run.h"

/* The owner of J loses it where J moves alone. */
TEST(dense) {
  dlsi_room room = {0};
  dls_error error;
  ck_assert_int_eq(dlsi_room_dense(&room, 0, NULL), DLS_OK);
  ck_assert(!room.J && room.side == 0);
  malloc_fails_at(0);
  dls_status status = dlsi_room_dense(&room, 3, NULL);
  const size_t bytes = malloc_bytes();
  ck_assert(!status && room.J && room.side == 3 && bytes == 9 * sizeof(double));
  const double *const J = room.J;
  room.owner = &room;
  status = dlsi_room_dense(&room, 3, NULL);
  if (!status) status = dlsi_room_dense(&room, 2, NULL);
  ck_assert(!status && room.J == J && room.side == 3 && room.owner == &room);
  ck_assert_int_eq(dlsi_room_dense(&room, 4, NULL), DLS_OK);
  ck_assert(room.J && room.side == 4 && !room.owner);
  room.owner = &room;
  malloc_fails_at(1);
  status = dlsi_room_dense(&room, 5, NULL);
  malloc_fails_at(0);
  ck_assert_int_eq(status, DLS_E_MEMORY);
  ck_assert(!room.J && room.side == 0 && !room.owner);
  const size_t much = (size_t)1 << (4 * sizeof much); /* its square is 0 in a size_t */
  status = dlsi_room_dense(&room, much, &error);
  ck_assert(status == DLS_E_MEMORY && !room.J && room.side == 0);
  ck_assert_int_eq(dlsi_room_dense(&room, 1, NULL), DLS_OK);
  ck_assert(room.J && room.side == 1);
  dlsi_room_free(&room);
}

#if WITH_MUMPS

/* d^2 blocks + d nc entries: 4 * 3 + 2 * 5; fewer of them take what is there. */
TEST(sparse) {
  dlsi_room room = {0};
  ck_assert_int_eq(dlsi_room_sparse(&room, 2, 5, 3, NULL), DLS_OK);
  ck_assert(room.lu && room.i && room.v && room.entries == 22);
  const int *const i = room.i;
  malloc_fails_at(0);
  const dls_status status = dlsi_room_sparse(&room, 1, 19, 3, NULL);
  const long calls = malloc_calls();
  ck_assert(!status && room.i == i && room.entries == 22 && calls == 0);
  ck_assert_int_eq(dlsi_room_sparse(&room, 3, 1, 3, NULL), DLS_OK);
  ck_assert(room.entries == 30);
  dlsi_room_free(&room);
}

/* 2^31 - 1 entries are a lack of memory, one more is a size: 1 * 7 + 1 nc and 9 * 238609294 + 3. */
TEST(too_large) {
  dlsi_room room = {0};
  dls_error error;
  ck_assert_int_eq(dlsi_room_sparse(&room, 1, 1, 1, NULL), DLS_OK);
  malloc_fails_at(1);
  const dls_status most = dlsi_room_sparse(&room, 1, INT_MAX - 7, 7, NULL);
  malloc_fails_at(0);
  ck_assert_int_eq(most, DLS_E_MEMORY);
  ck_assert(room.entries == 0);
  const int nc[] = {INT_MAX - 6, 1}, blocks[] = {7, 238609294};
  for (int k = 0; k < 2; k++) {
    ck_assert_int_eq(dlsi_room_sparse(&room, k ? 3 : 1, nc[k], blocks[k], &error), DLS_E_SIZE);
    ck_assert_str_eq(error.argument, "blocks");
    ck_assert(error.index == -1 && error.value == blocks[k]);
  }
  dlsi_room_free(&room);
}

/* Each allocation fails in turn; the room serves afterwards. */
TEST(failing_mallocs) {
  long k = 0;
  for (dls_status status = DLS_E_MEMORY; status;) {
    dlsi_room room = {0};
    malloc_fails_at(++k);
    status = dlsi_room_sparse(&room, 3, 2, 1, NULL);
    malloc_fails_at(0);
    if (status) ck_assert_int_eq(status, DLS_E_MEMORY);
    ck_assert_int_eq(dlsi_room_sparse(&room, 3, 2, 1, NULL), DLS_OK);
    ck_assert(room.i && room.v && room.entries == 15);
    dlsi_room_free(&room);
  }
  ck_assert_int_eq(k, 7); /* the work, i, v, row, col, x, and none */
}

#else

TEST(sparse_needs_mumps) {
  dlsi_room room = {0};
  ck_assert_int_eq(dlsi_room_sparse(&room, 2, 5, 3, NULL), DLS_E_UNSUPPORTED);
  dlsi_room_free(&room);
}

#endif
