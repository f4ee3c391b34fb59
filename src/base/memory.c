/* memory.c: checked allocation and size-then-carve. */
#include <stdint.h>
#include <stdlib.h>

#include "base/base.h"

enum { alignment = 64 };

/* count * size + alignment > SIZE_MAX; a division only where both are large: it takes longer than the rest */
static int overflows(size_t count, size_t size) {
  const size_t half =
      SIZE_MAX >> (4 * sizeof(size_t)); /* half squared is less than SIZE_MAX - alignment */
  return (count > half || size > half) && size && count > (SIZE_MAX - alignment) / size;
}

void *dlsi_take(dlsi_arena *arena, size_t count, size_t size) {
  if (arena->failed || overflows(count, size)) {
    arena->failed = 1;
    return NULL;
  }
  const size_t bytes = (count * size + alignment - 1) / alignment * alignment;
  if (bytes > SIZE_MAX - arena->used || (arena->base && bytes > arena->size - arena->used)) {
    arena->failed = 1;
    return NULL;
  }
  void *piece = arena->base ? arena->base + arena->used : NULL;
  arena->used += bytes;
  return piece;
}

void *dlsi_alloc(size_t count, size_t size) {
  if (size && count > SIZE_MAX / size) return NULL;
  const size_t bytes = count * size;
  return malloc(bytes ? bytes : 1);
}
