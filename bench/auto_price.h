/* auto_price.h: the cost of a step, measured and assumed; the total cost of auto. */
#ifndef AUTO_PRICE_H
#define AUTO_PRICE_H

#include <stdint.h>
#include <stdio.h>

/* Prints a table of the steps on generated problems of 30 to 1000 contacts, and one of the methods.
 * Returns how many methods have wrong prices. */
int price_report(FILE *page, uint64_t seed);

/* Prints a line: what auto solves of generated problems, and its cost. */
void total_report(uint64_t seed);

#endif
