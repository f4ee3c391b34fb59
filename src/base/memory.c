/* memory.c: checked allocation, and workspaces in one piece: count first, then carve. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/base.h"

#if defined(__SANITIZE_ADDRESS__)
#define WITH_ADDRESS_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define WITH_ADDRESS_SANITIZER
#endif
#endif
#ifdef WITH_ADDRESS_SANITIZER
#include <sanitizer/asan_interface.h>
#endif

enum { alignment = 64 };

/* Returns 1 if count * size + alignment > SIZE_MAX. Divides only if a factor is large: the product
 * of two factors below 2^(half of the bits) cannot overflow, and a division takes longer than the
 * rest. */
static int overflows(size_t count, size_t size) {
  const size_t half = SIZE_MAX >> (4 * sizeof(size_t));
  return (count > half || size > half) && size && count > (SIZE_MAX - alignment) / size;
}

/* Makes the address sanitizer report accesses between a piece and the next one. */
static void forbid_rest(char *piece, size_t used, size_t bytes) {
#ifdef WITH_ADDRESS_SANITIZER
  __asan_unpoison_memory_region(piece, used);
  __asan_poison_memory_region(piece + used, bytes - used);
#else
  (void)piece, (void)used, (void)bytes;
#endif
}

void *dlsi_take(dlsi_arena *arena, size_t count, size_t size) {
  arena->failed |= overflows(count, size);
  if (arena->failed) return NULL;
  const size_t bytes = (count * size + alignment - 1) / alignment * alignment;
  const size_t left = (arena->base ? arena->size : SIZE_MAX) - arena->used;
  arena->failed = bytes > left;
  if (arena->failed) return NULL;
  char *piece = arena->base ? arena->base + arena->used : NULL;
  if (piece) forbid_rest(piece, count * size, bytes);
  arena->used += bytes;
  return piece;
}

dls_status dlsi_arena_allocate(dlsi_arena *arena, const char *argument, long long value,
                               dls_error *error) {
  if (arena->failed)
    return dlsi_fail(error, DLS_E_SIZE, argument, -1, (double)value, "is too large");
  arena->base = dlsi_alloc(arena->used, 1);
  if (!arena->base) return dlsi_no_memory(error);
  arena->size = arena->used;
  arena->used = 0;
  return DLS_OK;
}

dls_status dlsi_carve_workspace(void **out, void *filled, size_t size, dlsi_carve *carve,
                                const char *argument, long long value, dls_error *error) {
  dlsi_arena arena = {0};
  *out = NULL;
  (void)dlsi_take(&arena, 1, size);
  carve(filled, &arena);
  const dls_status status = dlsi_arena_allocate(&arena, argument, value, error);
  if (status) return status;
  *out = memcpy(dlsi_take(&arena, 1, size), filled, size);
  carve(*out, &arena);
  return DLS_OK;
}

void *dlsi_alloc(size_t count, size_t size) {
  if (size && count > SIZE_MAX / size) return NULL;
  const size_t bytes = count * size;
  return malloc(bytes ? bytes : 1);
}
