/* failures.c: the reader of data/failures, line by line. */
#define _POSIX_C_SOURCE 200809L
#include "failures.h"

#include <check.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

/* x[0], x[stride], ... := count numbers, each "1.5e-3" or "p/q"; 1 if there are exactly as many */
static int numbers(const char *text, int count, int stride, double *x) {
  for (int i = 0; i < count; i++) {
    char *end;
    double v = strtod(text, &end);
    if (end == text) return 0;
    text = end;
    if (*text == '/') {
      const double below = strtod(text + 1, &end);
      if (end == text + 1 || below == 0) return 0;
      v /= below;
      text = end;
    }
    x[i * stride] = v;
  }
  return text[strspn(text, " \t\r\n")] == 0;
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
  return numbers(text, n, 1, list[(*count)++].x);
}

static int sizes(failure *f, int contact, const char *text) {
  double v[2] = {0};
  if (!numbers(text, contact ? 2 : 1, 1, v)) return 0;
  for (int i = 0; i < 2; i++)
    if (!(v[i] >= 0 && v[i] <= FAILURE_N)) return 0;
  f->d = contact ? (int)v[0] : 0;
  f->nc = contact ? (int)v[1] : 0;
  f->n = contact ? f->d * f->nc : (int)v[0];
  return f->n >= 1 && f->n <= FAILURE_N;
}

/* The matrix is the n lines after its key. */
static int matrix(FILE *in, failure *f, int *at) {
  char line[1000];
  for (int i = 0; i < f->n; i++, ++*at)
    if (!fgets(line, sizeof line, in) || !numbers(line, f->n, f->n, f->M + i)) return 0;
  return f->n > 0;
}

/* One line: key and text; 1 if it is understood. */
static int take(FILE *in, failure *f, const char *key, const char *text, int *at) {
  if (!strcmp(key, "title") || !strcmp(key, "shows") || !strcmp(key, "source")) return *text != 0;
  if (!strcmp(key, "contact") || !strcmp(key, "lcp")) return sizes(f, *key == 'c', text);
  if (!strcmp(key, "W") || !strcmp(key, "M")) return matrix(in, f, at);
  if (!strcmp(key, "q")) return numbers(text, f->n, 1, f->q);
  if (!strcmp(key, "mu")) return f->nc > 0 && numbers(text, f->nc, 1, f->mu);
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

int failure_read(const char *directory, const char *name, failure *f, char *why) {
  char path[300], line[1000], key[16];
  memset(f, 0, sizeof *f);
  snprintf(f->name, sizeof f->name, "%s", name);
  snprintf(path, sizeof path, "%s/%s.txt", directory, name);
  FILE *in = fopen(path, "r");
  if (!in) {
    snprintf(why, 200, "%.150s cannot be opened", path);
    return 0;
  }
  int good = 1, at = 0;
  while (good && fgets(line, sizeof line, in)) {
    at++;
    int end = 0;
    if (sscanf(line, "%15s%n", key, &end) != 1 || key[0] == '#') continue;
    good = take(in, f, key, line + end, &at);
  }
  if (!good)
    snprintf(why, 200, "%.150s, line %d is not understood", path, at);
  else if (f->none ? f->points > 0 : f->points == 0) {
    snprintf(why, 200, "%.150s: solutions or the word none, one of the two", path);
    good = 0;
  }
  fclose(in);
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
