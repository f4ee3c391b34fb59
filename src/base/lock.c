/*
 * lock.c: lets one thread at a time into libraries with state of their own: MUMPS, METIS, HDF5;
 * lets one call at a time into an object.
 *
 * The lock is the one writable global of the library (tests/check_symbols.sh names it);
 * libdelassus-files.so has its own. A thread holds it for one call of such a library and calls
 * nothing of the host meanwhile: no two locks are ever held, and a callback may use the library
 * freely. Locking a mutex of the default kind that this thread does not hold cannot fail.
 */
#include <pthread.h>

#include "base/base.h"

static pthread_mutex_t lock_of_others = PTHREAD_MUTEX_INITIALIZER;

void dlsi_lock(void) {
  (void)pthread_mutex_lock(&lock_of_others);
}

void dlsi_unlock(void) {
  (void)pthread_mutex_unlock(&lock_of_others);
}

dls_status dlsi_enter(atomic_int *busy, const char *argument, dls_error *error) {
  if (!atomic_exchange(busy, 1)) return DLS_OK;
  return dlsi_fail(error, DLS_E_BUSY, argument, -1, 0, "another call is at work on it");
}

dls_status dlsi_leave(atomic_int *busy, dls_status status) {
  atomic_store(busy, 0);
  return status;
}
