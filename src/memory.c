/* memory.c: checked allocation and size-then-carve. */
#include <stdint.h>
#include <stdlib.h>

#include "dlsi.h"

enum { alignment = 64 };

void *dlsi_take(dlsi_arena *arena, size_t count, size_t size) {
  if (arena->failed || (size && count > (SIZE_MAX - alignment) / size)) {
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
