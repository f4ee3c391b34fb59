/*
 * fuzz.c: runs the targets. With libFuzzer (FUZZ_ENGINE defined) the part after the last '-' of the
 * program's name is the target. Without it, this file is the engine: it changes seeds at random,
 * from a given seed, in a separate process for each target, and reports why a process died.
 *
 *   fuzz [--seconds=S] [--seed=N] [--out=DIR] [--sanitized] [TARGET]...   S s of CPU a target
 *   fuzz TARGET FILE...                                         runs these inputs once
 */
#define _GNU_SOURCE
#include "fuzz.h"

#include <fcntl.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

const fuzz_target fuzz_targets[] = {
    {"fclib",
     fuzz_fclib,
     {"fclib/FC3D_Example1.hdf5", "fclib/FC2D_SliderCrankLagrangian00000.hdf5",
      "fclib/GFC3D_Example0.hdf5"},
     0,
     0},
    {"sets", fuzz_fclib_sets, {NULL}, 0, 0},
    {"mtx",
     fuzz_mtx,
     {"torment/array.mtx", "torment/symmetric.mtx", "torment/coordinate.mtx", "torment/skew.mtx"},
     1,
     0},
    {"text",
     fuzz_text,
     {"failures/c01-three-solutions.txt", "failures/l01-cycling.txt",
      "failures/c26-rank-two-3d.txt", "torment/fractions.txt"},
     1,
     0},
    {"calculix", fuzz_calculix, {"torment/job.sti"}, 1, 0},
    {"program",
     fuzz_program,
     {"torment/program-text", "torment/program-npy", "torment/program-matrices",
      "torment/program-options", "torment/program-lcp"},
     1,
     1},
    {"lcp", fuzz_lcp, {NULL}, 0, 0},
    {"contact", fuzz_contact, {NULL}, 0, 0},
    {"reduction", fuzz_reduction, {NULL}, 0, 0},
    {"motion", fuzz_motion, {NULL}, 0, 0},
    {"doors", fuzz_doors, {NULL}, 0, 0},
    {"calls", fuzz_calls, {NULL}, 0, 0},
    {"plans", fuzz_plans, {"torment/plan"}, 1, 0},
    {"tables",
     fuzz_tables,
     {"torment/numbers.npy", "torment/numbers.txt", "torment/array.mtx", "torment/coordinate.mtx"},
     1,
     1},
    {"numpy", fuzz_numpy, {"torment/numbers.npy"}, 0, 1},
    {NULL, NULL, {NULL}, 0, 0}};

/* ---- what targets share ---------------------------------------------------------------------- */

static int error_file = 2; /* of the messages, where the target's own go to /dev/null */

void fuzz_check(int holds, const char *text, const char *file, int line) {
  if (holds) return;
  (void)dprintf(error_file, "%s:%d: does not hold: %s\n", file, line, text);
  abort();
}

int take_byte(fuzz_bytes *b) {
  if (!b->left) return 0;
  b->left--;
  return *b->at++;
}

int take_int(fuzz_bytes *b, int low, int high) {
  int number = take_byte(b);
  if (high - low > 255) number += 256 * take_byte(b);
  return low + number % (high - low + 1);
}

double take_plain(fuzz_bytes *b) {
  return (take_byte(b) - 128) / 32.0;
}

double take_value(fuzz_bytes *b) {
  static const double odd[] = {0,      -0.0,  1e308,       -1.7e308,  5e-324, 2.3e-308,
                               1e-160, 1e160, 1.0 / 0.0,   0.0 / 0.0, 1e-8,   1e9,
                               1e-9,   0.3,   0.999999999, 1e12};
  const int kind = take_byte(b);
  if (kind < 224) return take_plain(b);
  if (kind < 252) return odd[take_byte(b) % (int)(sizeof odd / sizeof odd[0])];
  unsigned char bits[sizeof(double)];
  double x;
  for (size_t k = 0; k < sizeof bits; k++)
    bits[k] = (unsigned char)take_byte(b);
  memcpy(&x, bits, sizeof x);
  return x;
}

double take_scale(fuzz_bytes *b) {
  static const double scale[] = {1e-300, 1e-160, 1e-30, 1e-9, 1e-3, 1e3, 1e9, 1e30, 1e160, 1e300};
  const int kind = take_byte(b);
  return kind < 200 ? 1 : scale[kind % 10];
}

enum { most_arrays = 4096 };
static void *exact[most_arrays];
static int exact_count;

void *fuzz_exact(const void *from, size_t bytes) {
  void *p = malloc(bytes ? bytes : 1);
  if (!p || exact_count == most_arrays) abort();
  if (bytes) (void)(from ? memcpy(p, from, bytes) : memset(p, 0x5a, bytes));
  return exact[exact_count++] = p;
}

double *fuzz_doubles(const double *from, int count) {
  return fuzz_exact(from, (size_t)count * sizeof *from);
}

int *fuzz_ints(const int *from, int count) {
  return fuzz_exact(from, (size_t)count * sizeof *from);
}

void fuzz_run(const fuzz_target *target, const unsigned char *data, size_t size) {
  target->run(data, size);
  while (exact_count)
    free(exact[--exact_count]);
}

const char *fuzz_file(const unsigned char *data, size_t size) {
  static char name[64];
  static int fd = -1;
  if (fd < 0) {
    fd = memfd_create("fuzz", 0);
    (void)snprintf(name, sizeof name, "/proc/self/fd/%d", fd);
  }
  if (ftruncate(fd, 0) || pwrite(fd, data, size, 0) != (ssize_t)size) abort();
  return name;
}

static const fuzz_target *find_target(const char *name) {
  for (const fuzz_target *t = fuzz_targets; t->name; t++)
    if (!strcmp(t->name, name)) return t;
  (void)fprintf(stderr, "fuzz: no target '%s'\n", name);
  exit(2);
}

static double cpu_now(void) {
  struct timespec t;
  (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#ifdef FUZZ_ENGINE

/* ---- libFuzzer ------------------------------------------------------------------------------- */

/* of CPU for one input, which the sanitizers make 11 to 20 times as long */
static const double most_seconds = 10;
static const fuzz_target *target;
int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerInitialize(int *argc, char ***argv) {
  const char *name = strrchr((*argv)[0], '-');
  target = find_target(name ? name + 1 : "");
  if (*argc > 1 && !strcmp((*argv)[1], "--seeds")) {
    for (int k = 0; target->seeds[k]; k++)
      puts(target->seeds[k]);
    exit(0);
  }
  return 0;
}

/* Ends the process by a signal: libFuzzer keeps the input. A clock on the wall would count the
 * work of others. */
static void too_slow(void) {
  abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const double start = cpu_now();
  if (size <= fuzz_most) fuzz_run(target, data, size);
  if (cpu_now() - start > most_seconds) too_slow();
  return 0;
}

#else

/* ---- seeds and changes ----------------------------------------------------------------------- */

typedef struct input {
  size_t size;
  unsigned char data[fuzz_most];
} input;

/* What the process of a target leaves when it dies. */
typedef struct outcome {
  long executions;
  double slowest;     /* CPU seconds */
  long memory;        /* kB by which the process grew beyond its seeds, less the input's size */
  input now;          /* that runs */
  input slow, greedy; /* those of `slowest` and `memory` */
} outcome;

static double slow_seconds = 1; /* more under sanitizers, whose time and memory say nothing */
static long greedy_kilobytes = 64 * 1024;
static const long kill_seconds = 20;

static uint64_t state;

static unsigned draw(unsigned bound) { /* xorshift64* */
  state ^= state >> 12;
  state ^= state << 25;
  state ^= state >> 27;
  return (unsigned)((state * 2685821657736338717u) >> 33) % bound;
}

static int read_input(const char *path, input *in) {
  FILE *file = fopen(path, "rb");
  if (!file) return 0;
  in->size = fread(in->data, 1, sizeof in->data, file);
  const int whole = getc(file) == EOF;
  (void)fclose(file);
  return whole;
}

static void write_input(const char *path, const input *in) {
  FILE *file = fopen(path, "wb");
  if (!file || fwrite(in->data, 1, in->size, file) != in->size || fclose(file))
    (void)fprintf(stderr, "fuzz: %s: cannot be written\n", path);
}

/* Replaces `cut` bytes at `at` by `count` others, as far as there is room. */
static void replace_bytes(input *in, size_t at, size_t cut, const unsigned char *by, size_t count) {
  unsigned char copy[fuzz_most];
  if (in->size - cut + count > fuzz_most) return;
  memcpy(copy, by, count);
  memmove(in->data + at + count, in->data + at + cut, in->size - at - cut);
  memcpy(in->data + at, copy, count);
  in->size = in->size - cut + count;
}

/* Puts an odd number in the place of the digits around a place, or nothing. */
static void change_number(input *in) {
  static const char *const odd[] = {
      "0",     "-1",  "1e999", "2147483647", "2147483648", "nan", "1e308", "4294967297",
      "46000", "1/0", "-0",    "1e-320",     "3",          "0.5", "-2",    "99999999999999999999"};
  size_t from = draw((unsigned)in->size), to;
  while (from < in->size && (in->data[from] < '0' || in->data[from] > '9'))
    from++;
  for (to = from; to < in->size && in->data[to] >= '0' && in->data[to] <= '9';)
    to++;
  const char *by = odd[draw(sizeof odd / sizeof odd[0])];
  replace_bytes(in, from, to - from, (const unsigned char *)by, strlen(by));
}

static void change_line(input *in) {
  size_t from = draw((unsigned)in->size), to = from;
  while (from > 0 && in->data[from - 1] != '\n')
    from--;
  while (to < in->size && in->data[to] != '\n')
    to++;
  if (to < in->size) to++;
  if (draw(2))
    replace_bytes(in, from, to - from, in->data, 0);
  else
    replace_bytes(in, from, 0, in->data + from, to - from);
}

/* Writes an odd integer of 1, 2, 4 or 8 bytes, low byte first. */
static void change_integer(input *in) {
  static const uint64_t odd[] = {0,          1,          2,          16,         0x7f,
                                 0x80,       0xff,       0x7fff,     0x8000,     0xffff,
                                 0x7fffffff, 0x80000000, 0xffffffff, 0x10000000, UINT64_MAX,
                                 1ull << 40, 1ull << 62, 4096};
  const size_t width = (size_t)1 << draw(4), at = draw((unsigned)in->size);
  uint64_t value = odd[draw(sizeof odd / sizeof odd[0])];
  if (!draw(4)) value = in->size + draw(16);
  for (size_t k = 0; k < width && at + k < in->size; k++, value >>= 8)
    in->data[at + k] = (unsigned char)value;
}

static void change(input *in, const input *other, int is_text) {
  if (!in->size) {
    in->data[0] = (unsigned char)draw(256);
    in->size = 1;
  }
  const size_t at = draw((unsigned)in->size), rest = in->size - at;
  const size_t count = 1 + draw((unsigned)(rest < 64 ? rest : 64));
  switch (draw(is_text ? 10 : 7)) {
  case 0:
    in->data[at] ^= (unsigned char)(1u << draw(8));
    break;
  case 1:
    in->data[at] = (unsigned char)draw(256);
    break;
  case 2:
    change_integer(in);
    break;
  case 3:
    replace_bytes(in, at, count, in->data, 0);
    break;
  case 4:
    replace_bytes(in, at, 0, in->data + at, count);
    break;
  case 5:
    if (other->size) {
      const size_t from = draw((unsigned)other->size), most = other->size - from;
      const size_t length = 1 + draw((unsigned)(most < 256 ? most : 256));
      replace_bytes(in, at, length < rest ? length : rest, other->data + from, length);
    }
    break;
  case 6:
    if (draw(16) == 0) in->size = at;
    break;
  case 7:
    change_line(in);
    break;
  default:
    change_number(in);
  }
}

static void randomize(input *in) {
  in->size = 16 + draw(700);
  for (size_t k = 0; k < in->size; k++)
    in->data[k] = (unsigned char)draw(256);
}

/* ---- the process of a target ----------------------------------------------------------------- */

static int prints = -1; /* where the target's prints go */

/* Sends what a target prints to a file: the library (and LAPACK called by it) prints nothing. */
static void catch_prints(const fuzz_target *t) {
  error_file = dup(2);
  prints = t->is_loud ? open("/dev/null", O_WRONLY) : memfd_create("prints", 0);
  if (prints < 0 || dup2(prints, 1) < 0 || dup2(prints, 2) < 0) abort();
}

static void check_prints(void) {
  char text[200];
  const ssize_t length = prints < 0 ? 0 : pread(prints, text, sizeof text - 1, 0);
  if (length <= 0) return;
  text[length] = '\0';
  text[strcspn(text, "\n")] = '\0';
  fuzz_check(0, text, "printed", 0);
}

static long memory_now(void) {
  struct rusage usage;
  (void)getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

/* Runs the input that stands in out->now; base: kB before, 0: do not look. */
static void run_input(const fuzz_target *t, outcome *out, long base) {
  const struct itimerval limit = {.it_value = {kill_seconds, 0}};
  (void)setitimer(ITIMER_PROF, &limit, NULL);
  const double start = cpu_now();
  fuzz_run(t, out->now.data, out->now.size);
  check_prints();
  const double seconds = cpu_now() - start;
  out->executions++;
  if (seconds > out->slowest) {
    out->slowest = seconds;
    out->slow = out->now;
  }
  const long more = base ? memory_now() - base - (long)(out->now.size / 1024) : 0;
  if (more > out->memory) {
    out->memory = more;
    out->greedy = out->now;
  }
}

static void run_target(const fuzz_target *t, double seconds, uint64_t seed, outcome *out) {
  enum { most_seeds = 8 };
  static input seeds[most_seeds], none;
  int count = 0;
  catch_prints(t);
  for (; count < most_seeds && t->seeds[count]; count++) {
    char path[256];
    (void)snprintf(path, sizeof path, "data/%s", t->seeds[count]);
    if (!read_input(path, &seeds[count])) {
      (void)dprintf(error_file, "fuzz: %s: cannot be read\n", path);
      exit(2);
    }
  }
  state = 0x9e3779b97f4a7c15u * (seed + 1);
  for (int k = 0; k < (count ? count : 50); k++) {
    if (count)
      out->now = seeds[k];
    else
      randomize(&out->now);
    run_input(t, out, 0);
  }
  const double start = cpu_now();
  const long base = memory_now();
  while (cpu_now() - start < seconds) {
    if (count)
      out->now = seeds[draw((unsigned)count)];
    else
      randomize(&out->now);
    for (unsigned k = count ? 1 + draw(1u << draw(5)) : draw(8); k > 0; k--)
      change(&out->now, count ? &seeds[draw((unsigned)count)] : &none, t->is_text);
    run_input(t, out, base);
  }
}

/* Runs a target in a process of its own. Returns 1 if it kept its promises. */
static int attack(const fuzz_target *t, double seconds, uint64_t seed, const char *folder) {
  outcome *out = mmap(NULL, sizeof *out, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (out == MAP_FAILED) return 0;
  *out = (outcome){0};
  (void)fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    run_target(t, seconds, seed, out);
    _exit(0);
  }
  int status = -1;
  if (child < 0 || waitpid(child, &status, 0) != child) return 0;
  const int died = status != 0, slow = out->slowest > slow_seconds;
  const int greedy = out->memory > greedy_kilobytes;
  printf("%-10s %8ld inputs, slowest %.3f s of CPU, at most %ld kB beyond its seeds: %s\n", t->name,
         out->executions, out->slowest, out->memory,
         died     ? "DIED"
         : slow   ? "TOO SLOW"
         : greedy ? "TOO MUCH MEMORY"
                  : "good");
  if (died || slow || greedy) {
    char path[256];
    (void)snprintf(path, sizeof path, "%s/%s-%s-%lu", folder, t->name,
                   died   ? "died"
                   : slow ? "slow"
                          : "greedy",
                   (unsigned long)seed);
    write_input(path, died ? &out->now : slow ? &out->slow : &out->greedy);
    if (died && WIFSIGNALED(status)) printf("  signal %d\n", WTERMSIG(status));
    printf("  again: build/tests/torment/fuzz %s %s\n", t->name, path);
  }
  (void)munmap(out, sizeof *out);
  return !died && !slow && !greedy;
}

int main(int argc, char **argv) {
  double seconds = 60;
  unsigned long seed = 1;
  const char *folder = ".";
  int k = 1, good = 1;
  for (; k < argc && argv[k][0] == '-'; k++) {
    if (!strncmp(argv[k], "--seconds=", 10))
      seconds = atof(argv[k] + 10);
    else if (!strncmp(argv[k], "--seed=", 7))
      seed = strtoul(argv[k] + 7, NULL, 10);
    else if (!strcmp(argv[k], "--sanitized"))
      slow_seconds = 10, greedy_kilobytes = 1024 * 1024;
    else if (!strncmp(argv[k], "--out=", 6))
      folder = argv[k] + 6;
    else
      return (void)fprintf(stderr, "fuzz: '%s' is no option\n", argv[k]), 2;
  }
  struct stat entry; /* the folders lcp and reduction are targets */
  if (k + 1 < argc && stat(argv[k + 1], &entry) == 0 && S_ISREG(entry.st_mode)) {
    static outcome out;
    const fuzz_target *t = find_target(argv[k]);
    for (k++; k < argc; k++) {
      if (!read_input(argv[k], &out.now)) return (void)fprintf(stderr, "fuzz: %s\n", argv[k]), 2;
      out.slowest = 0;
      run_input(t, &out, 0);
      (void)fprintf(stderr, "%s: %.3f s of CPU, %ld kB in all\n", argv[k], out.slowest,
                    memory_now());
    }
    return 0;
  }
  setvbuf(stdout, NULL, _IOLBF, 0);
  if (k == argc)
    for (const fuzz_target *t = fuzz_targets; t->name; t++)
      good &= attack(t, seconds, seed, folder);
  for (; k < argc; k++)
    good &= attack(find_target(argv[k]), seconds, seed, folder);
  return !good;
}

#endif
