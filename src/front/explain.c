/* explain.c: explains in words what auto did with a problem and why. */
#include <float.h>
#include <stdarg.h>
#include <stdio.h>

#include "contact/contact.h"
#include "delassus/solve.h"

/* A text that grows; text that does not fit is only counted. */
typedef struct words {
  char *text;
  size_t room, length;
} words;

static void say(words *to, const char *format, ...) DLSI_PRINTF(2, 3);

static void say(words *to, const char *format, ...) {
  const size_t left = to->length < to->room ? to->room - to->length : 0;
  va_list args;
  va_start(args, format);
  const int count = vsnprintf(left ? to->text + to->length : NULL, left, format, args);
  va_end(args);
  if (count > 0) to->length += (size_t)count;
}

static void say_storage(words *to, const dls_info *info) {
  if (info->blocks > 0)
    say(to, "W by blocks, %.1f for each candidate",
        (double)info->blocks / (info->candidates - info->left_out));
  else
    say(to, info->blocks ? "W of bodies" : "W is dense");
  say(to, ", %d candidate%s", info->candidates, info->candidates == 1 ? "" : "s");
}

static void say_regime(words *to, const dls_info *info) {
  static const char *const why[] = {
      [DLS_REGIME_ELASTIC] = "an elastic body, W regular: sweeps, then Newton's method",
      [DLS_REGIME_FEW] = "few contacts, W by blocks: sweeps, Newton's method, momentum, pivots",
      [DLS_REGIME_PACKING] = "many bodies, W by blocks and singular: sweeps, then momentum in turn "
                             "with Newton's method",
      [DLS_REGIME_TIGHT] =
          "a large or dense packing: momentum from the first sweep on, in turn with "
          "Newton's method",
      [DLS_REGIME_GIVEN] = "the plan is the caller's"};
  say(to, "regime %s (", dls_regime_name(info->regime));
  say_storage(to, info);
  say(to, "): %s\n", why[info->regime]);
  if (info->at_rest)
    say(to, "at rest (-q nearly in the friction cones, or few neighbours): the convex problem "
            "without mu |u_t| is tried\n");
  if (info->left_out)
    say(to, "%d of %d candidates provably cannot touch: the steps are without them\n",
        info->left_out, info->candidates);
}

static void say_forecast(words *to, const dls_stage *s) {
  if (s->reason != DLS_REASON_COSTLIER) return;
  if (s->ahead <= DBL_MAX)
    say(to, " (%.0f more sweeps expected, the next step costs %.0f)", s->ahead, s->next);
  else
    say(to, " (no end expected, the next step costs %.0f sweeps)", s->next);
}

/* all: CPU seconds of all stages, 0: not measured. */
static void say_stage(words *to, int number, const dls_stage *s, double all) {
  say(to, "%3d %-20s %6d iterations", number, dls_step_name(s->step), s->iterations);
  if (all > 0)
    say(to, s->cpu_seconds < 999.5 ? ", %9.3g s of CPU, %3.0f %%" : ", %9.0f s of CPU, %3.0f %%",
        s->cpu_seconds, 100 * s->cpu_seconds / all);
  say(to, ", residual %.1e%s: %s", s->residual, s->on_copy ? ", on a copy" : "",
      dls_reason_text(s->reason));
  say_forecast(to, s);
  say(to, "\n");
}

size_t dls_explain(const dls_info *info, char *text, size_t room) {
  words to = {text, text ? room : 0, 0};
  double all = 0;
  if (text && room) *text = '\0';
  if (!info) return 0;
  for (int k = 0; k < info->stages; k++)
    all += info->stage[k].cpu_seconds;
  if (info->method != DLS_AUTO)
    say(&to, "%s alone: auto has no part in it\n", dls_method_name(info->method));
  else if (info->regime != DLS_REGIME_NONE)
    say_regime(&to, info);
  else if (info->stages && info->stage[0].step == DLS_STEP_ON_K)
    say(&to, "the problem on K itself, without W: auto's plans are for W\n");
  else
    say(&to, "no plan was needed: what presses stands alone\n");
  for (int k = 0; k < info->stages; k++)
    say_stage(&to, k + 1, &info->stage[k], all);
  if (info->method == DLS_AUTO)
    say(&to, "%s: %d step%s, %d iterations, residual %.1e\n", dls_status_text(info->status),
        info->stages, info->stages == 1 ? "" : "s", info->iterations, info->certificate.residual);
  return to.length;
}
