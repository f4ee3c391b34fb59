/*
 * palette.c: the colours of methods and verdicts in all pictures: Okabe and Ito's eight, which
 * colour-blind readers tell apart, wine and grey; each with a point of its own besides.
 */
#include <string.h>

#include "palette.h"

static const struct {
  const char *name, *colour;
  int point;
} palette[] = {
    {"auto", "#000000", 13},         {"nlgs", "#e69f00", 6},
    {"nlgs+anderson", "#56b4e9", 7}, {"newton", "#0072b2", 5},
    {"admm", "#009e73", 9},          {"augmented-lagrangian", "#d55e00", 11},
    {"lemke", "#cc79a7", 15},        {"penalty", "#999999", 4},
    {"homotopy", "#882255", 8},      {"gauss-seidel", "#8b6914", 10},
    {"nlgs+aitken", "#f0c040", 1},   {"nlgs+momentum", "#6a51a3", 3},
};
enum { colours = sizeof palette / sizeof palette[0] };

/* Returns the row of a method; -1 if it has none. */
static int palette_row(const char *name) {
  for (int k = 0; k < colours; k++)
    if (strcmp(palette[k].name, name) == 0) return k;
  return -1;
}

const char *method_colour(const char *name) {
  const int row = palette_row(name);
  return row < 0 ? "#6b6b00" : palette[row].colour;
}

int method_point(const char *name) {
  const int row = palette_row(name);
  return row < 0 ? 12 : palette[row].point;
}

int list_contenders(contender list[MOST_CONTENDERS]) {
  static const contender of_nlgs[] = {
      {.name = "nlgs+aitken", .acceleration = DLS_ACCELERATION_AITKEN},
      {.name = "nlgs+momentum", .acceleration = DLS_ACCELERATION_MOMENTUM},
      {.name = "nlgs+anderson", .acceleration = DLS_ACCELERATION_ANDERSON},
      {.name = "gauss-seidel", .on_body = 1}};
  enum { ways = sizeof of_nlgs / sizeof of_nlgs[0] };
  int count = 0;
  for (int k = 0; dls_method_name((dls_method)k) && count < MOST_CONTENDERS - ways; k++) {
    contender *c = &list[count++];
    *c = (contender){.method = (dls_method)k};
    (void)snprintf(c->name, sizeof c->name, "%s", dls_method_name((dls_method)k));
    for (int way = 0; k == DLS_NLGS && way < ways; way++) {
      list[count] = of_nlgs[way];
      list[count++].method = DLS_NLGS;
    }
  }
  for (int k = 0; k < count; k++) {
    list[k].colour = method_colour(list[k].name);
    list[k].point = method_point(list[k].name);
  }
  return count;
}

static const struct {
  const char *word, *colour;
} endings[ENDINGS] = {
    [ENDED_SOLVED] = {"solved", "#0072b2"},
    [ENDED_STALLED] = {"no progress", "#e69f00"},
    [ENDED_RAY] = {"ray", "#cc79a7"},
    [ENDED_LIKELY_NONE] = {"likely none", "#d55e00"},
    [ENDED_NONE] = {"proved none", "#882255"},
    [ENDED_REFUSED] = {"refused", "#ffffff"},
    [ENDED_UNDECIDED] = {"not decided", "#e4e4e4"},
    [ENDED_FOLDED] = {"mesh folded", "#303030"},
};

ending ending_of(dls_status status) {
  switch (status) {
  case DLS_OK:
  case DLS_TO_ROUNDING:
    return ENDED_SOLVED;
  case DLS_STALLED:
    return ENDED_STALLED;
  case DLS_RAY:
    return ENDED_RAY;
  case DLS_NO_SOLUTION:
    return ENDED_NONE;
  case DLS_NO_SOLUTION_LIKELY:
    return ENDED_LIKELY_NONE;
  case DLS_FOLDED:
    return ENDED_FOLDED;
  default:
    return status < 0 ? ENDED_REFUSED : ENDED_UNDECIDED;
  }
}

const char *ending_word(ending e) {
  return endings[e].word;
}

const char *ending_colour(ending e) {
  return endings[e].colour;
}
