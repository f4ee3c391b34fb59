/*
 * dice.c: random numbers by splitmix64: the same bits on every machine.
 */
#include <math.h>

#include "problem.h"

uint64_t dice_bits(dice *g) {
  uint64_t z = g->state += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

int dice_below(dice *g, int n) {
  return (int)(dice_bits(g) % (uint64_t)n);
}

double dice_between(dice *g, double a, double b) {
  return a + (b - a) * ldexp((double)(dice_bits(g) >> 11), -53);
}

double dice_normal(dice *g) {
  double sum = 0;
  for (int k = 0; k < 6; k++)
    sum += dice_between(g, -1, 1);
  return sum / sqrt(2);
}

double dice_power(dice *g, double a, double b) {
  return pow(10, dice_between(g, a, b));
}

int dice_sign(dice *g) {
  return dice_below(g, 2) ? 1 : -1;
}
