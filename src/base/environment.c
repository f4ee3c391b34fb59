/*
 * environment.c: the floating point environment of the host, out of the way while the library
 * computes.
 *
 * A host may trap invalid operations (gfortran -ffpe-trap), round upwards, or ask later which flags
 * it has raised. The library divides 0 by 0 and looks at the outcome, and promises the same bits to
 * everybody. So each public function begins with DLSI_DOOR (base.h), which puts the default
 * environment in place and, as the function returns, the one that it found.
 *
 *   x86-64     all of it in the control word of SSE: one look as the function begins, one as it
 *              returns; only a host that traps or rounds otherwise pays for <fenv.h>
 *   elsewhere  <fenv.h> in every call
 *
 * The host's callbacks run in the environment that the host left: dlsi_go_out, dlsi_come_in. They
 * find it in a variable of the thread, which is set while a public function holds it.
 */

#include "base/base.h"

/* Is the environment of the host in this thread; known: 0 where it is the default one. */
static _Thread_local dlsi_host host_of_thread;

void dlsi_hold_host(dlsi_door *door) {
  door->before = host_of_thread;
  (void)feholdexcept(&door->found);
  (void)fesetround(FE_TONEAREST);
  host_of_thread = (dlsi_host){1, door->found};
}

void dlsi_free_host(const dlsi_door *door) {
  (void)fesetenv(&door->found);
  host_of_thread = door->before;
}

void dlsi_go_out(dlsi_host *own) {
  own->known = host_of_thread.known;
  if (!own->known) return;
  (void)fegetenv(&own->environment);
  (void)fesetenv(&host_of_thread.environment);
}

void dlsi_come_in(const dlsi_host *own) {
  if (own->known) (void)fesetenv(&own->environment);
}
