/*
 * problems.c: writes scenes of the benchmarks as FCLIB files, for the program's chart, map and
 * profile.
 *
 *   problems DIR NAME...    those whose names begin with a NAME, "wall-6x5" say, into DIR/NAME.hdf5
 *   problems --list
 */
#include <stdio.h>
#include <string.h>

#include "solvers.h"

typedef struct wanted {
  const char *directory; /* NULL: list them */
  int count, failed;
  char **names;
} wanted;

static void write_wanted(void *data, const scene *s) {
  wanted *w = data;
  char path[1024];
  dls_error error;
  if (!w->directory) printf("%s: %dD, %d candidates\n", s->name, s->contact.d, s->contact.nc);
  for (int k = 0; k < w->count; k++) {
    if (strncmp(s->name, w->names[k], strlen(w->names[k])) != 0) continue;
    (void)snprintf(path, sizeof path, "%s/%s.hdf5", w->directory, s->name);
    if (!dls_fclib_write_local(path, &s->contact, s->name, NULL, NULL, &error)) continue;
    fprintf(stderr, "%s: %s\n", path, error.message);
    w->failed = 1;
  }
}

int main(int argc, char **argv) {
  wanted w = {.directory = argv[1]};
  if (argc == 2 && strcmp(argv[1], "--list") == 0)
    w.directory = NULL;
  else if (argc < 3) {
    fputs("usage: problems DIR NAME... | problems --list\n", stderr);
    return 2;
  } else {
    for (int k = 1; k < argc; k++)
      if (argv[k][0] == '-') return fprintf(stderr, "problems: %s: is no name\n", argv[k]), 2;
    w.names = argv + 2;
    w.count = argc - 2;
  }
  if (scenes_blocks(0, write_wanted, &w) || scenes_cubes(0, write_wanted, &w) ||
      scenes_walls(0, write_wanted, &w))
    return 2;
  return w.failed ? 2 : 0;
}
