/*
 * methods.c: the table of methods. A method is one row, at the end of the file that implements
 * it, and one line here; dls_solver, auto, the program's help and the tests read the table.
 */
#include <string.h>

#include "front/front.h"

#define METHODS(X)                                                                                 \
  X(auto)                                                                                          \
  X(nlgs)                                                                                          \
  X(lemke)                                                                                         \
  X(newton)                                                                                        \
  X(admm)                                                                                          \
  X(augmented)                                                                                     \
  X(penalty)

#define DECLARE(name) extern const dlsi_method dlsi_##name##_method;
METHODS(DECLARE)

#define ROW(name) &dlsi_##name##_method,
static const dlsi_method *const methods[] = {METHODS(ROW)};

enum { count = sizeof methods / sizeof methods[0] };

const dlsi_method *dlsi_method_of(dls_method method) {
  for (int k = 0; k < count; k++)
    if (methods[k]->method == method) return methods[k];
  return NULL;
}

const char *dls_method_name(dls_method method) {
  const dlsi_method *row = dlsi_method_of(method);
  return row ? row->name : NULL;
}

const char *dls_method_summary(dls_method method) {
  const dlsi_method *row = dlsi_method_of(method);
  return row ? row->summary : NULL;
}

int dls_method_find(const char *name, dls_method *method) {
  for (int k = 0; name && method && k < count; k++)
    if (strcmp(methods[k]->name, name) == 0) {
      *method = methods[k]->method;
      return 1;
    }
  return 0;
}
