/*
 * malloc_fails.h: make the k-th allocation of our own code fail. The test programs are linked with
 * --wrap=malloc, so that every malloc, calloc and realloc of libdelassus (not of MUMPS, BLAS,
 * HDF5 or Check) passes through here.
 */
#ifndef MALLOC_FAILS_H
#define MALLOC_FAILS_H

#include <stddef.h>

/* The k-th allocation from now on (k = 1, 2, ...) and no other fails; k = 0: none. */
void malloc_fails_at(long k);

/* Allocations since the last malloc_fails_at, and the bytes they asked for. */
long malloc_calls(void);
size_t malloc_bytes(void);

#endif
