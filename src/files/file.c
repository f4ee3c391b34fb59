/* file.c: opens files for reading, distinguishes what goes wrong; reads numbers. */
#define _XOPEN_SOURCE 700
#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "files/file.h"

FILE *dlsi_file_open(const char *path, dls_error *error) {
  FILE *file = fopen(path, "rb");
  if (!file) {
    (void)dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "%s",
                    errno == ENOENT   ? "does not exist"
                    : errno == EACCES ? "cannot be opened: permission denied"
                                      : "cannot be opened");
    return NULL;
  }
  const int first = getc(file); /* a directory can be opened, but not read */
  if (ferror(file)) {
    (void)dlsi_fail(error, DLS_E_FILE, "path", -1, 0,
                    errno == EISDIR ? "is a directory" : "cannot be read");
    (void)fclose(file);
    return NULL;
  }
  /* a byte order mark: editors on Windows put it before UTF-8 */
  if (first == 0xef && getc(file) == 0xbb && getc(file) == 0xbf) return file;
  if (first == 0xef) rewind(file);
  if (first != EOF && first != 0xef) (void)ungetc(first, file);
  return file;
}

long long dlsi_file_size(FILE *file) {
  struct stat entry;
  if (fstat(fileno(file), &entry) || !S_ISREG(entry.st_mode)) return -1;
  return (long long)entry.st_size;
}

dls_status dlsi_file_content(FILE *file, char **content, size_t *size, dls_error *error) {
  *content = NULL;
  *size = 0;
  for (size_t room = 0;;) {
    if (*size + 1 >= room) {
      char *more = room > SIZE_MAX / 4 ? NULL : dlsi_alloc(2 * room + 4096, 1);
      if (!more) return dlsi_no_memory(error);
      if (*size) memcpy(more, *content, *size);
      free(*content);
      *content = more;
      room = 2 * room + 4096;
    }
    const size_t got = fread(*content + *size, 1, room - *size - 1, file);
    *size += got;
    if (!got) break;
  }
  (*content)[*size] = '\0';
  return ferror(file) ? dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "cannot be read") : DLS_OK;
}

/* Accepts word = [+-] digits [. digits] [e [+-] digits], finite; returns 0 for any other word. The
 * e may be E, or d or D as in Fortran's double precision. strtod reads the decimal point of the
 * locale, which printf shows between the digits of 0.5. */
int dlsi_read_number(const char *word, size_t length, double *value) {
  char w[dlsi_longest_number + 1];
  if (length > dlsi_longest_number) return 0;
  memcpy(w, word, length);
  w[length] = '\0';
  size_t digits = 0, point = SIZE_MAX, k = w[0] == '+' || w[0] == '-';
  for (; dlsi_is_digit(w[k]) || (w[k] == '.' && point == SIZE_MAX); k++) {
    if (w[k] == '.')
      point = k;
    else
      digits++;
  }
  if (!digits) return 0;
  if (w[k] == 'd' || w[k] == 'D') w[k] = 'e';
  if (w[k] == 'e' || w[k] == 'E') {
    k += w[k + 1] == '+' || w[k + 1] == '-' ? 2 : 1;
    if (!dlsi_is_digit(w[k])) return 0;
    while (dlsi_is_digit(w[k]))
      k++;
  }
  if (w[k] != '\0' || k != length) return 0;
  char half[16], text[dlsi_longest_number + sizeof half];
  if (snprintf(half, sizeof half, "%.1f", 0.5) < 3) return 0;
  const int point_length = (int)strlen(half) - 2;
  if (point == SIZE_MAX)
    (void)snprintf(text, sizeof text, "%s", w);
  else
    (void)snprintf(text, sizeof text, "%.*s%.*s%s", (int)point, w, point_length, half + 1,
                   w + point + 1);
  char *end;
  *value = strtod(text, &end);
  return *end == '\0' && isfinite(*value);
}
