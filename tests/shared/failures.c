/* failures.c: reads data/failures: the problem, and the statements about it. */
#define _POSIX_C_SOURCE 200809L
#include "failures.h"

#include <check.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/files.h"
#include "files/file.h"

static int by_name(const void *a, const void *b) {
  return strcmp(a, b);
}

int failures_list(const char *directory, char names[][64], int capacity) {
  DIR *d = opendir(directory);
  if (!d) return -1;
  int count = 0;
  for (struct dirent *e = readdir(d); e; e = readdir(d)) {
    const size_t length = strlen(e->d_name);
    if (length < 5 || length > 67 || strcmp(e->d_name + length - 4, ".txt") != 0) continue;
    if (count == capacity) break;
    memcpy(names[count], e->d_name, length - 4);
    names[count++][length - 4] = 0;
  }
  closedir(d);
  qsort(names, (size_t)count, sizeof names[0], by_name);
  return count;
}

const char *const failure_methods[FAILURE_METHODS] = {"auto",    "nlgs",  "nlgs+anderson",
                                                      "newton",  "admm",  "augmented-lagrangian",
                                                      "penalty", "lemke", "homotopy"};

enum { statuses_known = 7 };

const char *failure_word(int status) {
  static const char *const word[statuses_known] = {
      "ok", "max-iterations", "cancelled", "stalled", "ray", "no-solution", "no-solution-likely"};
  return status < 0 || status >= statuses_known ? "error" : word[status];
}

/* bits of the statuses that are named; 0 if one is unknown */
static unsigned statuses(const char *text) {
  unsigned bits = 0;
  while (*(text += strspn(text, " \t\r\n"))) {
    const size_t length = strcspn(text, " \t\r\n");
    unsigned bit = 0;
    for (int s = 0; s < statuses_known; s++)
      if (strlen(failure_word(s)) == length && memcmp(text, failure_word(s), length) == 0)
        bit = 1u << s;
    if (!bit) return 0;
    bits |= bit;
    text += length;
  }
  return bits;
}

/* METHOD statuses */
static int take_solve(failure *f, const char *text) {
  text += strspn(text, " \t");
  const size_t length = strcspn(text, " \t\r\n");
  for (int k = 0; k < FAILURE_METHODS; k++)
    if (strlen(failure_methods[k]) == length && memcmp(text, failure_methods[k], length) == 0)
      return (f->solve[k] = statuses(text + length)) != 0;
  return 0;
}

static int add_point(failure_point *list, int *count, int continuum, int n, const char *text) {
  if (*count == FAILURE_POINTS) return 0;
  list[*count].continuum = continuum;
  return dlsi_text_numbers(text, n, list[(*count)++].x);
}

/* One line that is no part of the problem; 1 if it is understood. */
static int take(failure *f, const char *key, const char *text) {
  if (!strcmp(key, "title") || !strcmp(key, "shows") || !strcmp(key, "source")) return *text != 0;
  if (!strcmp(key, "none")) return f->none = 1;
  if (!strcmp(key, "continuum")) return ++f->continua;
  if (!strcmp(key, "solution")) return add_point(f->point, &f->points, -1, f->n, text);
  if (!strcmp(key, "point")) return add_point(f->point, &f->points, f->continua - 1, f->n, text);
  if (!strcmp(key, "ray")) return add_point(f->ray, &f->rays, f->continua - 1, f->n, text);
  if (!strcmp(key, "lemke")) return (f->lemke = statuses(text)) != 0;
  if (!strcmp(key, "nlgs")) return (f->nlgs = statuses(text)) != 0;
  if (!strcmp(key, "solve")) return take_solve(f, text);
  if (!strcmp(key, "principal")) return (f->principal = statuses(text)) != 0;
  return 0;
}

/* The problem itself; 1 if it fits. */
static int take_problem(failure *f, const dls_text *text) {
  dls_contact p;
  const double *M, *q;
  const int contact = !dls_text_is_lcp(text);
  if (contact ? dls_text_contact(text, &p, NULL) : dls_text_lcp(text, &f->n, &M, &q, NULL))
    return 0;
  if (contact) f->n = p.d * p.nc;
  if (f->n > FAILURE_N) return 0;
  const size_t n = (size_t)f->n;
  memcpy(f->M, contact ? p.W.a : M, n * n * sizeof *f->M);
  memcpy(f->q, contact ? p.q : q, n * sizeof *f->q);
  if (!contact) return 1;
  f->d = p.d;
  f->nc = p.nc;
  memcpy(f->mu, p.mu, (size_t)p.nc * sizeof *f->mu);
  return 1;
}

int failure_read(const char *directory, const char *name, failure *f, char *why) {
  char path[300];
  const char *key, *line;
  dls_text *text;
  dls_error error;
  memset(f, 0, sizeof *f);
  snprintf(f->name, sizeof f->name, "%s", name);
  snprintf(path, sizeof path, "%s/%s.txt", directory, name);
  if (dls_text_read(&text, path, &error)) {
    snprintf(why, 200, "%.80s: %.110s", path, error.message);
    return 0;
  }
  int good = take_problem(f, text);
  if (!good) snprintf(why, 200, "%.150s is too large", path);
  for (int k = 0; good && (line = dlsi_text_line(text, k, &key)); k++) {
    good = take(f, key, line);
    if (!good) snprintf(why, 200, "%.100s: '%.15s %.50s' is not understood", path, key, line);
  }
  if (good && (f->none ? f->points > 0 : f->points == 0)) {
    snprintf(why, 200, "%.150s: solutions or the word none, one of the two", path);
    good = 0;
  }
  dls_text_destroy(text);
  return good;
}

int failure_says(const failure *f, const char *method, int status) {
  for (int k = 0; k < FAILURE_METHODS; k++)
    if (!strcmp(failure_methods[k], method)) return f->solve[k] == 1u << status;
  return 0;
}

dls_contact failure_contact(const failure *f) {
  return (dls_contact){
      .d = f->d, .nc = f->nc, .W = {f->n, f->n, f->n, f->M}, .q = f->q, .mu = f->mu};
}

const failure *contact_failures(int *count) {
  enum { capacity = 128 };
  static char names[capacity][64];
  static failure list[capacity];
  char why[200];
  const int n = failures_list(TEST_DATA "/failures", names, capacity);
  *count = 0;
  for (int k = 0; k < n; k++) {
    failure *f = &list[*count];
    if (!failure_read(TEST_DATA "/failures", names[k], f, why)) ck_abort_msg("%s", why);
    *count += f->d > 0;
  }
  return list;
}
