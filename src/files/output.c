/*
 * output.c: writes files so that either the whole new file exists or the old one stays. A file
 * grows under a temporary name in its own directory. Only when all of it is on the disk, one rename
 * replaces the old file. A failure or a kill before that leaves the old file unchanged.
 *
 * If the name is a link, the file at its end is replaced, and the link stays. A device or a pipe
 * cannot be replaced and is written directly; so is a file that any process holds open
 * (/dev/stdout leads to /proc/self/fd/1, which may be a file).
 */
#define _XOPEN_SOURCE 700
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "contact/contact.h"
#include "files/output.h"

enum { most_links = 40, most_names = 1000 };

/* Reports `text` with the reason from errno; 0: none is known. */
static dls_status output_fail(int reason, const char *text, dls_error *error) {
  char words[80];
  if (!reason || strerror_r(reason, words, sizeof words))
    return dlsi_fail(error, DLS_E_FILE, "path", -1, 0, "%s", text);
  return dlsi_fail(error, DLS_E_FILE, "path", -1, reason, "%s: %s", text, words);
}

static int is_held_open(const char *path) {
  return strncmp(path, "/proc/", 6) == 0 || strncmp(path, "/dev/fd/", 8) == 0;
}

/* Replaces `path` by the file at the end of its links, which need not exist. Returns 0 and sets
 * errno if the links have no end. */
static int output_follow(char path[dlsi_longest_path]) {
  char link[dlsi_longest_path];
  for (int k = 0; k < most_links && !is_held_open(path); k++) {
    const ssize_t length = readlink(path, link, sizeof link);
    if (length < 0) return 1; /* no link: opening reports other errors */
    const char *slash = strrchr(path, '/');
    const size_t head = link[0] == '/' || !slash ? 0 : (size_t)(slash + 1 - path);
    if (head + (size_t)length >= dlsi_longest_path) return errno = ENAMETOOLONG, 0;
    memcpy(path + head, link, (size_t)length);
    path[head + (size_t)length] = '\0';
  }
  return is_held_open(path) || (errno = ELOOP, 0);
}

/* Opens a new file next to out->path; returns its descriptor, -1 with errno on failure. */
static int output_open_beside(dlsi_output *out, mode_t mode) {
  const char *slash = strrchr(out->path, '/');
  const int head = slash ? (int)(slash + 1 - out->path) : 0;
  for (int k = 0; k < most_names; k++) {
    const int length = snprintf(out->temporary, sizeof out->temporary, "%.*s.delassus-%ld-%d", head,
                                out->path, (long)getpid(), k);
    if (length < 0 || (size_t)length >= sizeof out->temporary) return errno = ENAMETOOLONG, -1;
    const int fd = open(out->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (fd >= 0 || errno != EEXIST) return fd;
  }
  return -1;
}

dls_status dlsi_output_open(dlsi_output *out, const char *path, dls_error *error) {
  static const char *const text = "cannot be opened for writing";
  *out = (dlsi_output){.file = NULL};
  if (strlen(path) >= sizeof out->path) return output_fail(ENAMETOOLONG, text, error);
  strcpy(out->path, path);
  struct stat old;
  const int there = stat(path, &old) == 0;
  if (there && S_ISREG(old.st_mode) && access(path, W_OK)) return output_fail(errno, text, error);
  if (!(there && !S_ISREG(old.st_mode)) && !output_follow(out->path))
    return output_fail(errno, text, error);
  if ((there && !S_ISREG(old.st_mode)) || is_held_open(out->path)) {
    out->file = fopen(path, "w");
    return out->file ? DLS_OK : output_fail(errno, text, error);
  }
  const mode_t mode = there ? old.st_mode & 0777 : 0666;
  const int fd = output_open_beside(out, mode);
  if (fd < 0) return output_fail(errno, text, error);
  /* the umask has removed bits that the old file had; a file system without modes does no harm */
  if (there && fchmod(fd, mode)) errno = 0;
  out->file = fdopen(fd, "w");
  if (out->file) return DLS_OK;
  const int reason = errno;
  (void)close(fd);
  (void)unlink(out->temporary);
  return output_fail(reason, text, error);
}

void dlsi_output_drop(dlsi_output *out) {
  if (!out->file) return;
  (void)fclose(out->file);
  if (out->temporary[0]) (void)unlink(out->temporary);
  out->file = NULL;
}

void dlsi_output_keep_rows(dlsi_output *out) {
  off_t at = 0, end = 0;
  int lines = 0;
  if (!out->file) return;
  (void)fclose(out->file);
  out->file = NULL;
  FILE *written = out->temporary[0] ? fopen(out->temporary, "r") : NULL;
  for (int c; written && (c = getc(written)) != EOF;) {
    at++;
    if (c != '\n') continue;
    end = at;
    lines += lines < 2;
  }
  if (written) (void)fclose(written);
  if (!out->temporary[0]) return;
  const int good = lines > 1 && truncate(out->temporary, end) == 0;
  if (!good || rename(out->temporary, out->path)) (void)unlink(out->temporary);
}

dls_status dlsi_output_finish(dlsi_output *out, dls_error *error) {
  static const char *const text = "cannot be written to the end";
  const int whole = out->temporary[0] != '\0'; /* a file of its own */
  const int lost = ferror(out->file); /* writing again tells why, unless the reason has gone */
  int failed = fflush(out->file) != 0 || (whole && !lost && fsync(fileno(out->file)) != 0);
  if (lost && !failed) failed = write(fileno(out->file), " ", 1) < 0; /* nothing is left to flush */
  int reason = failed ? errno : 0;
  if (failed || lost) {
    if (out->is_table)
      dlsi_output_keep_rows(out);
    else
      dlsi_output_drop(out);
    return output_fail(reason, text, error);
  }
  failed = fclose(out->file) != 0 || (whole && rename(out->temporary, out->path) != 0);
  reason = errno;
  out->file = NULL;
  if (!failed) return DLS_OK;
  if (whole) (void)unlink(out->temporary);
  return output_fail(reason, text, error);
}
