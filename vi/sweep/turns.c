/*
 * turns.c: variants of an iteration take turns: the one with the lowest cost continues.
 *
 *   (TU1) price of a variant: the cost of its last halving, at least first_price; if its last turn
 *         ended without one, the cost of that turn over the part of a halving that it has brought,
 *         log2 of the residuals, at least least_part; 0 if the variant has not been tried
 *   (TU2) a variant continues until it has spent 3/2 of the lowest price of the others, and of
 *         first_price, without halving the least residual so far
 *   (TU3) then the other one of the lowest price follows, of equals the first
 *
 * If no variant halves the residual, prices grow from turn to turn. Each then gets longer and
 * longer turns, the one that gets farthest the longest. No clock is read.
 *
 * Cost: none. What can fail: the best variant is found late if it begins slowly, or if variants
 * need each other.
 */
#include <math.h>

#include "vi/vi_internal.h"

static const double first_price = 100; /* sweeps */
static const double patience = 1.5;
static const double least_part = 0.25;

void dlsi_turns_start(dlsi_turns *turns, int ways) {
  *turns = (dlsi_turns){.ways = ways, .least = INFINITY, .halved = INFINITY, .begun = INFINITY};
}

int dlsi_turns_advance(dlsi_turns *turns, double residual, double cost) {
  turns->spent += cost;
  turns->least = fmin(turns->least, residual);
  if (turns->least <= turns->halved / 2) {
    turns->price[turns->now] = fmax(turns->spent, first_price);
    turns->halved = turns->begun = turns->least;
    turns->spent = 0;
    return 0;
  }
  int next = turns->now;
  double least = INFINITY;
  for (int k = 0; k < turns->ways; k++)
    if (k != turns->now && turns->price[k] < least) least = turns->price[next = k];
  if (turns->spent < patience * fmax(least, first_price)) return 0;
  const double part = log2(turns->begun / turns->least);
  turns->price[turns->now] = turns->spent / fmin(fmax(part, least_part), 1);
  turns->now = next;
  turns->begun = turns->least;
  turns->spent = 0;
  return 1;
}
