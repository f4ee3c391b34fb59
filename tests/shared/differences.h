/* differences.h: derivatives of answers by differences. */
#ifndef DIFFERENCES_H
#define DIFFERENCES_H

#include "delassus/contact.h"

/* Returns zeros; the caller frees them. */
double *numbers(size_t n);

/* Returns an array of numbers that an output has to replace. */
double *garbage(size_t n);

double scalar(const double *x, const double *y, size_t n);

/* Returns |x - y| / |y|, or over `size` where that is larger: of positions that contacts hold. */
double apart(const double *x, const double *y, size_t n, double size);

/* Fills out (size) and state (nc) with the answer for the data + h direction; 0: not solved. */
typedef int answer_at(void *data, double h, double *out, dls_contact_state *state);

/* D (size) := d answer / d h at 0, extrapolated from four differences that halve their steps:
 * central ones (sign 0), or to the right or the left (1, -1), of steps that keep the states of 0 or
 * of a tiny step to that side. Returns 0 if there are no such steps. */
int differentiate(answer_at *answer, void *data, int sign, int size, int nc, double *D);

#endif
