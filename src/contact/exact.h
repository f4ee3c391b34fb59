/* exact.h: sums of products without any rounding, and proofs that need them. */
#ifndef DLSI_EXACT_H
#define DLSI_EXACT_H

#include <stdint.h>

#include "contact.h"

/* A fixed-point number wide enough for every product of three doubles: digits of 32 bits, lowest
 * first, with postponed carries. */
enum { dlsi_exact_digits = 210 };
typedef struct dlsi_exact {
  int64_t digit[dlsi_exact_digits];
  int pending; /* products added since the carries were done */
} dlsi_exact;

void dlsi_exact_clear(dlsi_exact *sum);

/* sum := sum + a b c for finite a, b, c. */
void dlsi_exact_add(dlsi_exact *sum, double a, double b, double c);

/* Returns -1, 0 or 1, the sign of the sum. */
int dlsi_exact_sign(dlsi_exact *sum);

/* Returns 1 if v (nc) proves that no r in the friction cones has (W r + q)_n >= 0: v >= 0,
 * v.q_n < 0 and, for every contact c, g_n + mu |g_t| <= 0 of g = sum of v_i times row n_i of
 * W_ic. Exact for the numbers of the problem. */
int dlsi_contact_is_infeasible(const dls_contact *problem, const double *v);

/* Returns 1 if v (nc), or a vector near it (EX3), is such a proof, and puts it into v. work: nc. */
int dlsi_contact_find_proof(const dls_contact *problem, double *v, double *work);

/* Returns 1 if `holds` is true of v (n), or of a vector near it (EX3), put into v. work: n. */
int dlsi_find_exact(size_t n, double *v, double *work,
                    int (*holds)(const void *problem, const double *v), const void *problem);

#endif
