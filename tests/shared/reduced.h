/* reduced.h: what a reduction returns, and its memory. */
#ifndef REDUCED_H
#define REDUCED_H

#include "delassus/reduction.h"

/* The contact problem without friction, which dls_contact_check takes; up to 1000 candidates. */
dls_contact contact_of(const dls_reduction *R);

/* Creates while each malloc fails in turn, until none does; *count: the k of the call that went
 * well. singular: a search for rigid-body modes without memory reports K as it was found. */
dls_reduction *create_by_failures(const dls_model *model, const dls_reduction_settings *settings,
                                  int singular, long *count);

#endif
