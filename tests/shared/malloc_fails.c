/* malloc_fails.c: wrappers of malloc, calloc and realloc that fail on demand. */
#include "malloc_fails.h"

#include <malloc.h>
#include <stdatomic.h>
#include <stdlib.h>

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void __real_free(void *p);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);
void __wrap_free(void *p);

long mallocs_failed;
static atomic_long calls, fail_at; /* threads allocate at the same time */
static atomic_size_t bytes;
static atomic_long held, most; /* bytes since the last malloc_fails_at */

void malloc_fails_at(long k) {
  calls = 0;
  bytes = 0;
  held = most = 0;
  fail_at = k;
}

long malloc_calls(void) {
  return calls;
}

size_t malloc_bytes(void) {
  return bytes;
}

long malloc_most(void) {
  return most;
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

static void *hold(void *p) {
  held += (long)malloc_usable_size(p);
  if (held > most) most = held;
  return p;
}

void *__wrap_malloc(size_t size) {
  return fails(size) ? NULL : hold(__real_malloc(size));
}

void *__wrap_calloc(size_t count, size_t size) {
  return fails(count * size) ? NULL : hold(__real_calloc(count, size));
}

void *__wrap_realloc(void *old, size_t size) {
  if (fails(size)) return NULL;
  held -= (long)malloc_usable_size(old);
  return hold(__real_realloc(old, size));
}

void __wrap_free(void *p) {
  held -= (long)malloc_usable_size(p);
  __real_free(p);
}
