/* file.c: opens and closes files, telling apart what goes wrong. */
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

FILE *dlsi_file_create(const char *path, const char *mode, dls_error *error) {
  FILE *file = fopen(path, mode);
  if (!file) (void)dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "cannot be opened for writing");
  return file;
}

dls_status dlsi_file_finish(const char *path, FILE *file, dls_error *error) {
  const int failed = ferror(file);
  if (fclose(file) == 0 && !failed) return DLS_OK;
  struct stat entry; /* a device that was written to must stay */
  if (stat(path, &entry) == 0 && S_ISREG(entry.st_mode)) (void)remove(path);
  return dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "cannot be written to the end");
}
