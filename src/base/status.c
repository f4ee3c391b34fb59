/* status.c: gives names and words for statuses, fills errors, returns the version. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/base.h"
#include "base/utf8.h"

typedef struct status_words {
  dls_status status;
  const char *name, *text;
} status_words;

static const status_words words[] = {
    {DLS_OK, "DLS_OK", "solved"},
    {DLS_MAX_ITERATIONS, "DLS_MAX_ITERATIONS", "iteration limit reached"},
    {DLS_CANCELLED, "DLS_CANCELLED", "cancelled"},
    {DLS_STALLED, "DLS_STALLED", "no further progress"},
    {DLS_RAY, "DLS_RAY", "secondary ray"},
    {DLS_NO_SOLUTION, "DLS_NO_SOLUTION", "no solution exists"},
    {DLS_NO_SOLUTION_LIKELY, "DLS_NO_SOLUTION_LIKELY", "no solution likely"},
    {DLS_TIME_LIMIT, "DLS_TIME_LIMIT", "time limit reached"},
    {DLS_FOLDED, "DLS_FOLDED", "mesh folded"},
    {DLS_TO_ROUNDING, "DLS_TO_ROUNDING", "solved to rounding"},
    {DLS_NOT_IN_EQUILIBRIUM, "DLS_NOT_IN_EQUILIBRIUM", "not in equilibrium"},
    {DLS_E_ARGUMENT, "DLS_E_ARGUMENT", "invalid argument"},
    {DLS_E_SIZE, "DLS_E_SIZE", "sizes do not fit"},
    {DLS_E_NOT_FINITE, "DLS_E_NOT_FINITE", "NaN or Inf in the input"},
    {DLS_E_SETTINGS, "DLS_E_SETTINGS", "settings not initialised"},
    {DLS_E_MEMORY, "DLS_E_MEMORY", "out of memory"},
    {DLS_E_NOT_POSITIVE_DEFINITE, "DLS_E_NOT_POSITIVE_DEFINITE", "matrix not positive definite"},
    {DLS_E_SINGULAR, "DLS_E_SINGULAR", "matrix singular"},
    {DLS_E_UNSUPPORTED, "DLS_E_UNSUPPORTED", "not supported"},
    {DLS_E_FILE, "DLS_E_FILE", "file cannot be opened, read or written"},
    {DLS_E_FORMAT, "DLS_E_FORMAT", "file format"},
    {DLS_E_CALLBACK, "DLS_E_CALLBACK", "host callback failed"},
    {DLS_E_BUSY, "DLS_E_BUSY", "object in use by another call"},
    {DLS_E_NO_DERIVATIVE, "DLS_E_NO_DERIVATIVE", "no derivative"},
};

static const status_words *find_words(dls_status status) {
  for (size_t k = 0; k < sizeof words / sizeof words[0]; k++)
    if (words[k].status == status) return &words[k];
  return NULL;
}

const char *dls_status_name(dls_status status) {
  const status_words *w = find_words(status);
  return w ? w->name : "unknown status";
}

const char *dls_status_text(dls_status status) {
  const status_words *w = find_words(status);
  return w ? w->text : "unknown status";
}

int dls_solved(dls_status status) {
  return status == DLS_OK || status == DLS_TO_ROUNDING;
}

const char *dls_version(void) {
  return DLS_VERSION;
}

dls_status dlsi_fail(dls_error *error, dls_status status, const char *argument, long long index,
                     double value, const char *format, ...) {
  if (!error) return status;
  char text[170], place[32] = "", whole[sizeof error->message];
  va_list args;
  va_start(args, format);
  if (vsnprintf(text, sizeof text, format, args) < 0) text[0] = '\0';
  va_end(args);
  if (index >= 0) (void)snprintf(place, sizeof place, "[%lld]", index);
  *error = (dls_error){status, "", argument, index, value, ""};
  (void)snprintf(whole, sizeof whole, "%s%s%s%s", argument, place, argument[0] ? ": " : "", text);
  /* text may quote a file's bytes */
  dlsi_utf8_show_all(error->message, sizeof error->message, whole);
  return status;
}

dls_status dlsi_at(const char *function, dls_status status, dls_error *error) {
  if (status >= 0 || !error) return status;
  char text[sizeof error->message + 64];
  const char *old = error->message; /* past the name that an inner public function has put there */
  if (error->function[0]) old += strlen(error->function) + 2;
  (void)snprintf(text, sizeof text, "%s: %s", function, old);
  error->function = function;
  dlsi_utf8_show_all(error->message, sizeof error->message, text);
  return status;
}
