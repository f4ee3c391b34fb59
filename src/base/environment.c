/*
 * environment.c: sets the host's floating point environment aside while the library computes.
 *
 * A host may trap invalid operations (gfortran -ffpe-trap), round upwards, or read later which
 * flags it has raised. The library divides 0 by 0 and checks the result, and promises the same bits
 * to everybody. So each public function starts with DLSI_DOOR (base.h): it sets the default
 * environment and restores the host's when the function returns.
 *
 *   x86-64     all of it in the control word of SSE: one read at the start, one at the return; only
 *              a host that traps or rounds otherwise pays for <fenv.h>
 *   elsewhere  <fenv.h> in every call
 *
 * The host's callbacks run in the environment that the host left: dlsi_go_out reads it from a
 * variable of the thread, set while a public function holds it. A callback may leave traps on, or
 * another rounding: dlsi_come_in sets the library's own again, whatever the callback did.
 */

#include "base/base.h"

/* The environment of the host in this thread; known: 0 if it is the default one. */
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
  *own = (dlsi_host){.known = 1};
  (void)fegetenv(&own->environment);
  if (host_of_thread.known) (void)fesetenv(&host_of_thread.environment);
}

void dlsi_come_in(const dlsi_host *own) {
  (void)fesetenv(&own->environment);
}
