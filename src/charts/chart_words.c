/* chart_words.c: the words and figures that the table and the picture of delassus chart share. */
#include <math.h>

#include "chart.h"

const int chart_target[CHART_TARGETS] = {2, 6, 10};

void chart_advice(const chart *c, char *text, size_t size) {
  const race *a = &c->race;
  if (c->take < 0) {
    (void)snprintf(text, size, "%s; auto: %s",
                   isfinite(race_fastest(a, 0))
                       ? "no method solves it at all tolerances that another solves"
                       : "no method solves it",
                   ending_word(race_trial(a, 0, a->rungs - 1)->end));
    return;
  }
  char how[60] = "the fastest at every tolerance";
  if (c->worst[c->take] >= 1.05)
    (void)snprintf(how, sizeof how, "at most %.2g times the fastest", c->worst[c->take]);
  int used = snprintf(text, size, "%s%s: %s", c->take ? "the fastest on the whole, " : "",
                      a->who[c->take].name, how);
  if (used < 0 || (size_t)used >= size || c->take == 0) return;
  if (isfinite(c->worst[0]))
    (void)snprintf(text + used, size - (size_t)used, "; auto: at most %.2g times", c->worst[0]);
  else
    (void)snprintf(text + used, size - (size_t)used, "; auto does not reach every tolerance");
}

void chart_reference(const chart *c, char *text, size_t size) {
  int used = 0;
  text[0] = '\0';
  if (!c->answers) (void)snprintf(text, size, "no answer to 1e-8: true errors are unknown");
  for (int at = 0; at < c->answers && used >= 0 && (size_t)used < size; at++) {
    const chart_answer *answer = &c->answer[at];
    used += snprintf(text + used, size - (size_t)used, "%sanswer %c of %s, found by %d",
                     at               ? "; "
                     : c->answers > 1 ? "SEVERAL ANSWERS: "
                                      : "",
                     'A' + at, c->race.who[answer->of].name, answer->found_by);
    if (isfinite(answer->agreement) && used >= 0 && (size_t)used < size)
      used += snprintf(text + used, size - (size_t)used,
                       answer->proved ? ", proved within %.0e" : ", next best agrees to %.0e",
                       answer->agreement);
  }
}

void chart_cell(const chart *c, int k, int rung, char *text, size_t size) {
  const trial *t = race_trial(&c->race, k, rung);
  if (t->end == ENDED_SOLVED)
    (void)snprintf(text, size, "%s (%.2g)", in_words(t->seconds).text,
                   t->seconds / race_fastest(&c->race, rung));
  else
    (void)snprintf(text, size, "%s", ending_word(t->end));
}

void chart_amplification(const chart *c, int k, char *text, size_t size) {
  if (isfinite(c->amplification[k]))
    (void)snprintf(text, size, "%.2g", c->amplification[k]);
  else
    (void)snprintf(text, size, "-");
}
