/* reduced.h: what a reduction returns, and its memory. */
#ifndef REDUCED_H
#define REDUCED_H

#include "delassus/reduction.h"

/* Works as dls_reduction_create, on W if settings (or NULL) leave the choice. */
dls_status reduce_on_W(dls_reduction **out, const dls_model *model,
                       const dls_reduction_settings *settings, dls_error *error);

/* The contact problem without friction, which dls_contact_check takes; up to 1000 candidates. */
dls_contact contact_of(const dls_reduction *R);

/* Creates on W while each malloc fails in turn, until none does; *count: the k of the call that
 * goes well. */
dls_reduction *create_by_failures(const dls_model *model, const dls_reduction_settings *settings,
                                  long *count);

#endif
