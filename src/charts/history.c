/* history.c: records the residual of a solve as it goes on (race.h). */
#include <string.h>

#include "race.h"

/* Halves the number of points that are kept. */
static void history_thin(history *h) {
  for (int k = 0; 2 * k < h->points; k++) {
    h->iteration[k] = h->iteration[2 * k];
    h->residual[k] = h->residual[2 * k];
    h->seconds[k] = h->seconds[2 * k];
  }
  h->points = (h->points + 1) / 2;
  h->every *= 2;
}

static void history_add(history *h, const dls_progress *p) {
  if (h->points == HISTORY_POINTS) history_thin(h);
  h->iteration[h->points] = h->before + h->last;
  h->residual[h->points] = p->residual;
  h->seconds[h->points++] = p->cpu_seconds;
}

static int history_note(void *data, const dls_progress *p) {
  history *h = data;
  const int fresh = !h->stages || strcmp(h->stage[h->stages - 1], p->stage) != 0;
  if (p->last) { /* of all stages; fewer than the rows, which count sweeps inside of stages, too */
    if (p->iteration > h->before + h->last) h->last = p->iteration - h->before;
    history_add(h, p);
    return 0;
  }
  if (fresh || p->iteration < h->last) { /* another stage counts from 0 */
    h->before += h->last;
    if (h->stages < HISTORY_STAGES && fresh) {
      h->begin[h->stages] = h->before;
      h->stage[h->stages++] = p->stage;
    }
  }
  h->last = p->iteration;
  if (p->residual >= 0 && (fresh || h->calls++ % h->every == 0)) history_add(h, p);
  return show_progress(NULL, p);
}

dls_status record_history(history *h, race *a, int k, double tol, double limit, double *r,
                          dls_error *error) {
  dls_info info;
  *h = (history){.every = 1};
  const dls_limits limits = {
      .tol = tol, .progress = history_note, .progress_data = h, .cpu_seconds = limit};
  return race_call(a, k, &limits, r, &info, error);
}
