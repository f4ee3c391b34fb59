/* regret_kinds.c: the kinds of problems of bench/regret, as regret_kinds.h describes them. */
#include "regret_kinds.h"

#include <stdlib.h>
#include <string.h>

typedef int (*generator)(regret_problem *a, const char *kind, int size, double mu, uint64_t seed);

static int of_rigid(regret_problem *a, const char *kind, int size, double mu, uint64_t seed) {
  if (rigid_create(&a->bodies, kind, size, mu, seed)) return -1;
  a->contact = a->bodies.contact;
  return 0;
}

/* most: contacts; dense problems are limited by the time that making and solving them takes. */
static const struct row {
  const char *kind;
  generator make;
  int most;
} rows[] = {
    {"packing-rest", of_rigid, 3000},
    {"packing-flow", of_rigid, 3000},
    {"wall-rest", of_rigid, 3000},
    {"wall-pushed", of_rigid, 3000},
    {"rubble-rest", of_rigid, 3000},
    {"rubble-pushed", of_rigid, 3000},
    {"wall3-rest", of_rigid, 3000},
    {"wall3-pushed", of_rigid, 3000},
    {"chain", of_rigid, 3000},
    {"chain3", of_rigid, 3000},
    {"arch", of_rigid, 3000},
    {"arch3", of_rigid, 3000},
    {"tower2", of_rigid, 3000},
    {"tower", of_rigid, 3000},
    {"discs-rest", of_rigid, 3000},
    {"discs-flow", of_rigid, 3000},
    {"balls-rest", of_rigid, 3000},
    {"balls-flow", of_rigid, 3000},
    {"mixed2-rest", of_rigid, 3000},
    {"mixed3-rest", of_rigid, 3000},
    {"elastic2", regret_elastic, 600},
    {"elastic3", regret_elastic, 400},
    {"elastic2-blocks", regret_elastic, 300},
    {"elastic3-blocks", regret_elastic, 300},
    {"ell3-rest", regret_grains, 3000},
    {"ell3-flow", regret_grains, 3000},
    {"poly2-rest", regret_grains, 3000},
    {"poly2-flow", regret_grains, 3000},
    {"poly3-flow", regret_grains, 3000},
    {"drum2", regret_grains, 3000},
    {"drum3", regret_grains, 3000},
    {"impact2", regret_grains, 3000},
    {"impact3", regret_grains, 3000},
    {"gears", regret_bodies, 3000},
    {"dome", regret_bodies, 3000},
    {"pyramid", regret_bodies, 3000},
    {"wedges", regret_bodies, 3000},
    {"ill2", regret_elastic, 400},
    {"ill3", regret_elastic, 300},
    {"bonded2", regret_elastic, 400},
    {"bonded3", regret_elastic, 300},
    {"rough3", regret_elastic, 400},
    {"cube.49", regret_elastic, 169},
    {"cube.4999", regret_elastic, 169},
    {"block2", regret_elastic, 400},
    {"train", regret_bodies, 3000},
    {"books", regret_bodies, 3000},
    {"logs", regret_bodies, 3000},
    {"box", regret_elastic, 40},
    {"feet", regret_elastic, 40},
    {"hand", regret_elastic, 60},
    {"beams", regret_bodies, 3000},
    {"beams-pushed", regret_bodies, 3000},
    {"pyramid-pushed", regret_bodies, 3000},
    {"dominoes", regret_bodies, 3000},
    {"sizes2-flow", of_rigid, 3000},
    {"sizes3-flow", of_rigid, 3000},
    {"worn3-rest", regret_grains, 3000},
    {"drum3-sizes", regret_grains, 3000},
    {"asperities", regret_elastic, 300},
    {"cloth", regret_nets, 200},
    {"cloth-stiff", regret_nets, 200},
    {"rope", regret_nets, 200},
    {"plates", regret_nets, 150},
};
enum { row_count = sizeof rows / sizeof rows[0] };

static const struct row *row_of(const char *kind) {
  for (int k = 0; k < row_count; k++)
    if (strcmp(kind, rows[k].kind) == 0) return &rows[k];
  return NULL;
}

int regret_is_pair(const char *kind) {
  return strncmp(kind, "elastic", 7) == 0;
}

const char *regret_kind(int index) {
  return index >= 0 && index < row_count ? rows[index].kind : NULL;
}

int regret_most(const char *kind) {
  const struct row *row = row_of(kind);
  return row ? row->most : 0;
}

int regret_create(regret_problem *a, const char *kind, int size, double mu, uint64_t seed) {
  const struct row *row = row_of(kind);
  *a = (regret_problem){0};
  if (!row) return -1;
  const int bad = row->make(a, kind, size, mu, seed);
  if (bad) regret_free(a);
  return bad;
}

void regret_free(regret_problem *a) {
  rigid_free(&a->bodies);
  rigid_free(&a->own);
  free(a->W);
  *a = (regret_problem){0};
}

/* Mixes by splitmix64 (Steele, Lea, Flood 2014). */
uint64_t regret_state(uint64_t seed, uint64_t salt) {
  uint64_t z = seed * 0x9E3779B97F4A7C15u + salt;
  z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
  z = (z ^ z >> 27) * 0x94D049BB133111EBu;
  return z ^ z >> 31;
}
