/*
 * words.c: the names of steps and reasons, and the plan and the steps left out that a caller names.
 *
 *   plan     word[:iterations] {, word[:iterations]}
 *   without  word {, word}
 */
#include <string.h>

#include "auto/auto.h"

enum { word_list_room = 200, longest_word = 16, most_iterations = 1000000000 };

static const char *const step_names[] = {
    [DLS_STEP_SWEEPS] = "sweeps",
    [DLS_STEP_ANDERSON] = "anderson",
    [DLS_STEP_MOMENTUM] = "momentum",
    [DLS_STEP_CONVEX] = "convex",
    [DLS_STEP_INTERIOR] = "interior-point",
    [DLS_STEP_NEWTON] = "newton",
    [DLS_STEP_SPLITTING] = "splitting",
    [DLS_STEP_COLD_SPLITTING] = "cold-splitting",
    [DLS_STEP_NEAR_SPLITTING] = "near-splitting",
    [DLS_STEP_AUGMENTED] = "augmented-lagrangian",
    [DLS_STEP_LEMKE] = "lemke",
    [DLS_STEP_HOMOTOPY] = "homotopy",
    [DLS_STEP_SCATTER] = "scatter",
    [DLS_STEP_ON_K] = "on-K",
};

static const char *const reason_texts[] = {
    [DLS_REASON_SOLVED] = "solved",
    [DLS_REASON_COSTLIER] = "costlier than the next step",
    [DLS_REASON_NO_PROGRESS] = "no progress",
    [DLS_REASON_SPENT] = "its iterations are spent",
    [DLS_REASON_TIME] = "time limit",
    [DLS_REASON_ITERATIONS] = "limit of iterations",
    [DLS_REASON_CANCELLED] = "cancelled",
    [DLS_REASON_NOT_APPLICABLE] = "not applicable",
    [DLS_REASON_NO_SOLUTION] = "proved that there is no solution",
    [DLS_REASON_EXCLUDED] = "no solution could be certified",
    [DLS_REASON_RUNS_AWAY] = "the reactions run away",
};

enum {
  step_count = sizeof step_names / sizeof step_names[0],
  reason_count = sizeof reason_texts / sizeof reason_texts[0]
};

const char *dls_step_name(dls_step which) {
  return (int)which >= 0 && (int)which < step_count ? step_names[which] : NULL;
}

const char *dls_regime_name(dls_regime regime) {
  static const char *const names[] = {
      [DLS_REGIME_NONE] = "none",   [DLS_REGIME_ELASTIC] = "elastic",
      [DLS_REGIME_FEW] = "few",     [DLS_REGIME_PACKING] = "packing",
      [DLS_REGIME_TIGHT] = "tight", [DLS_REGIME_GIVEN] = "given"};
  const int count = sizeof names / sizeof names[0];
  return (int)regime >= 0 && (int)regime < count ? names[regime] : NULL;
}

const char *dls_reason_text(dls_reason reason) {
  return (int)reason >= 0 && (int)reason < reason_count ? reason_texts[reason] : NULL;
}

/* ---- the caller's words ---------------------------------------------------------------------- */

/* Returns the part that a step of a plan runs; of "sweeps" SWEEPS; END if it is no word of one. */
static part part_of_step(dls_step which) {
  if (which == DLS_STEP_SWEEPS) return SWEEPS;
  for (part k = 0; k < parts; k++)
    if (dlsi_auto_kind[k].step == which) return k;
  return END;
}

/* Says which words are right. */
static dls_status refuse_word(const char *argument, const char *word, int length,
                              dls_error *error) {
  char list[word_list_room] = "";
  for (int k = 0; k < step_count; k++) {
    if (part_of_step((dls_step)k) == END) continue;
    if (k) strcat(list, " ");
    strcat(list, step_names[k]);
  }
  return dlsi_fail(error, DLS_E_ARGUMENT, argument, -1, 0, "'%.*s' is no step: %s",
                   length < longest_word ? length : longest_word, word, list);
}

/* *which := the step of the name text[0 .. length-1]. Returns 0 if it is no word of a plan. */
static int find_step(const char *text, size_t length, dls_step *which) {
  for (int k = 0; k < step_count; k++) {
    *which = (dls_step)k;
    if (strlen(step_names[k]) == length && memcmp(step_names[k], text, length) == 0)
      return part_of_step(*which) != END;
  }
  return 0;
}

/* Reads a word, and iterations behind a ':' (*most, 0: none); most = NULL: the list has none. *at:
 * in, where it begins; out, where the next one does, NULL after the last. */
static dls_status read_word(const char **at, const char *argument, dls_step *which, int *most,
                            dls_error *error) {
  const char *word = *at + strspn(*at, " ");
  const size_t length = strcspn(word, ":, ");
  const char *end = word + length;
  if (!find_step(word, length, which)) return refuse_word(argument, word, (int)length, error);
  if (most) *most = 0;
  if (*end == ':') {
    end++;
    if (!most || !dlsi_read_whole(&end, 1, most_iterations, most))
      return dlsi_fail(error, DLS_E_ARGUMENT, argument, -1, 0, "'%.40s': %s", word,
                       most ? "iterations are a whole number >= 1" : "takes no iterations");
  }
  end += strspn(end, " ");
  if (*end && *end != ',')
    return dlsi_fail(error, DLS_E_ARGUMENT, argument, -1, 0, "'%.40s': a comma ends a step", word);
  *at = *end ? end + 1 : NULL;
  return DLS_OK;
}

/* A step from r = 0, as on auto's copy. */
static unsigned flags_of(dls_step which) {
  if (which == DLS_STEP_SWEEPS) return ANY_SWEEPS;
  return which == DLS_STEP_COLD_SPLITTING || which == DLS_STEP_HOMOTOPY ? COLD : 0;
}

static dls_status read_plan(const char *plan, dlsi_auto_given *given, dls_error *error) {
  dls_step found;
  for (const char *at = plan; at; given->steps++) {
    const int k = given->steps;
    if (k == DLS_STAGES_MAX)
      return dlsi_fail(error, DLS_E_ARGUMENT, "plan", -1, k + 1, "has more than %d steps", k);
    const dls_status status = read_word(&at, "plan", &found, &given->step[k].most, error);
    if (status) return status;
    given->step[k].part = part_of_step(found);
    given->step[k].flags = flags_of(found);
  }
  given->step[given->steps] = (step){END, 0, 0};
  return DLS_OK;
}

dls_status dlsi_auto_read_words(const char *plan, const char *without, dlsi_auto_given *given,
                                dls_error *error) {
  dls_step found;
  *given = (dlsi_auto_given){.steps = 0};
  const dls_status status = plan ? read_plan(plan, given, error) : DLS_OK;
  if (status) return status;
  for (const char *at = without; at;) {
    const dls_status read = read_word(&at, "without", &found, NULL, error);
    if (read) return read;
    given->without |= 1U << part_of_step(found);
    if (found == DLS_STEP_SWEEPS) given->without |= 1U << PUSH;
  }
  return DLS_OK;
}
