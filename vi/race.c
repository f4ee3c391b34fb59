/*
 * race.c: which of a few ways to iterate halves a residual at the least price.
 *
 *   (RA1) price of a way: what its last halving has cost, at least first_price; where its last turn
 *         ended without one, what that turn has cost over the part of a halving that it has
 *         brought, log2 of the residuals, at least least_part; 0 where it has not been tried
 *   (RA2) a way goes on until it has spent 3/2 of the least price of the others, and of
 *         first_price, without halving the least residual so far
 *   (RA3) then the other one of the least price follows, the first of them where two have it
 *
 * Where no way halves the residual, prices grow from turn to turn, so that each gets longer and
 * longer turns, the one that gets farthest the longest. No clock is read.
 *
 * Cost: nothing. What can fail: the best way is found late where it begins slowly, and where ways
 * need each other.
 */
#include <math.h>

#include "vi_internal.h"

static const double first_price = 100; /* sweeps */
static const double patience = 1.5;
static const double least_part = 0.25;

void dlsi_race_start(dlsi_race *race, int ways) {
  *race = (dlsi_race){.ways = ways, .least = INFINITY, .halved = INFINITY, .begun = INFINITY};
}

int dlsi_race_advance(dlsi_race *race, double residual, double cost) {
  race->spent += cost;
  race->least = fmin(race->least, residual);
  if (race->least <= race->halved / 2) {
    race->price[race->now] = fmax(race->spent, first_price);
    race->halved = race->begun = race->least;
    race->spent = 0;
    return 0;
  }
  int next = race->now;
  double least = INFINITY;
  for (int k = 0; k < race->ways; k++)
    if (k != race->now && race->price[k] < least) least = race->price[next = k];
  if (race->spent < patience * fmax(least, first_price)) return 0;
  const double part = log2(race->begun / race->least);
  race->price[race->now] = race->spent / fmin(fmax(part, least_part), 1);
  race->now = next;
  race->begun = race->least;
  race->spent = 0;
  return 1;
}
