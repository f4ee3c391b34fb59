/* malloc_fails.c: wrappers of malloc, calloc and realloc that fail on demand. */
#include "malloc_fails.h"

#include <stdatomic.h>
#include <stdlib.h>

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);

long mallocs_failed;
static atomic_long calls, fail_at; /* threads allocate at the same time */
static atomic_size_t bytes;

void malloc_fails_at(long k) {
  calls = 0;
  bytes = 0;
  fail_at = k;
}

long malloc_calls(void) {
  return calls;
}

size_t malloc_bytes(void) {
  return bytes;
}

#if WITH_MUMPS
void __real_dlsi_dmumps(void *mumps);
void __wrap_dlsi_dmumps(void *mumps);

static _Thread_local int inside_mumps;

void __wrap_dlsi_dmumps(void *mumps) {
  inside_mumps = 1;
  __real_dlsi_dmumps(mumps);
  inside_mumps = 0;
}
#else
enum { inside_mumps = 0 };
#endif

static int fails(size_t size) {
  if (inside_mumps) return 0;
  bytes += size;
  return ++calls == fail_at;
}

void *__wrap_malloc(size_t size) {
  return fails(size) ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size) {
  return fails(count * size) ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *old, size_t size) {
  return fails(size) ? NULL : __real_realloc(old, size);
}
