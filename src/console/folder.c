/* folder.c: the folder that a command writes into, and which command it belongs to. */
#define _GNU_SOURCE
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "console.h"

static const char owner_file[] = "made-by.txt";

/* The folder that take_folder made by itself; "" if there is none. */
static char own_folder[PATH_ROOM];

/* Reads the first line of DIRECTORY/made-by.txt into line; "" if there is no such file. */
static int read_owner(const char *directory, char line[PATH_ROOM]) {
  char path[PATH_ROOM];
  line[0] = '\0';
  if (!join_path(path, directory, owner_file)) return 0;
  FILE *file = fopen(path, "r");
  if (!file && errno == ENOENT) return 1;
  if (!file) return refuse("%s: %s", path, strerror(errno));
  if (!fgets(line, PATH_ROOM, file)) line[0] = '\0';
  line[strcspn(line, "\n")] = '\0';
  return fclose(file) == 0;
}

static int write_owner(const char *directory, const char *owner) {
  FILE *file = open_in(directory, owner_file);
  if (!file) return 0;
  fprintf(file, "%s\n", owner);
  return close_file(file, owner_file);
}

static const char *make_own_folder(const char *of) {
  const char *place = temporary_place();
  if (snprintf(own_folder, PATH_ROOM, "%s/delassus-%s-XXXXXX", place, of) < PATH_ROOM &&
      mkdtemp(own_folder))
    return own_folder;
  own_folder[0] = '\0';
  (void)complain("%s: no folder can be made here; name one with --out", place);
  return NULL;
}

const char *temporary_place(void) {
  const char *place = getenv("TMPDIR");
  return place && *place ? place : "/tmp";
}

const char *take_folder(const char *directory, const char *of, const char *name) {
  char owner[PATH_ROOM], before[PATH_ROOM];
  if (!directory) return make_own_folder(of);
  (void)snprintf(owner, sizeof owner, "delassus %s%s%.4000s", of, name ? " " : "",
                 name ? quote(AS_SHOWN, name).text : "");
  if (!make_directory(directory) || !read_owner(directory, before)) return NULL;
  if (!strcmp(owner, before)) return directory;
  if (before[0]) {
    (void)complain("%s: holds the files of '%s'; name another folder",
                   quote(AS_SHOWN, directory).text, quote(AS_SHOWN, before).text);
    return NULL;
  }
  return write_owner(directory, owner) ? directory : NULL;
}

void drop_folder(void) {
  if (own_folder[0]) (void)rmdir(own_folder);
}
