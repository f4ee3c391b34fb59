/* file.c: opening and closing files, with what goes wrong told apart. */
#include <stdio.h>
#include <sys/stat.h>

#include "files/file.h"

FILE *dlsi_file_open(const char *path, dls_error *error) {
  FILE *file = fopen(path, "rb");
  if (!file) {
    (void)dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "cannot be opened");
    return NULL;
  }
  const int first = getc(file); /* a directory can be opened, but not read */
  if (ferror(file)) {
    (void)dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "cannot be read");
    (void)fclose(file);
    return NULL;
  }
  if (first != EOF) (void)ungetc(first, file);
  return file;
}

dls_status dlsi_file_finish(const char *path, FILE *file, dls_error *error) {
  const int failed = ferror(file);
  if (fclose(file) == 0 && !failed) return DLS_OK;
  struct stat what; /* a device that was written to must stay */
  if (stat(path, &what) == 0 && S_ISREG(what.st_mode)) (void)remove(path);
  return dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "cannot be written to the end");
}
