/*
 * common.h: shared by the benchmark programs: clocks, random numbers, medians, child processes,
 * options, pages of results.
 */
#ifndef BENCH_COMMON_H
#define BENCH_COMMON_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "delassus/reduction.h"

/* Returns the CPU seconds of this process, all threads: a BLAS with threads does not go unseen. */
double bench_seconds(void);

/* CPU seconds of runs of one kind: their number, the least, the last and all of them; {0} at first.
 */
typedef struct bench_clock {
  int count;
  double least, last, all, since;
} bench_clock;

/* Counts the run before and returns 1 if there is another one: `while (bench_runs(&c, 3, 40, .1))
 * solve();` solves 3 times or more, until all took .1 s, at most 40 times. */
int bench_runs(bench_clock *c, int least, int most, double seconds);

/* Begin and end a run, where several take turns or a run has parts; bench_stop returns its seconds.
 */
void bench_start(bench_clock *c);
double bench_stop(bench_clock *c);

/* Draws from [-1, 1): the top 53 bits of Knuth's MMIX generator. */
double bench_draw(uint64_t *state);

/* Works as dls_reduction_create, on W. */
dls_status bench_reduce(dls_reduction **out, const dls_model *model, dls_error *error);

/* Sorts x (n) and returns its median, the mean of the two in the middle for an even n; NAN for 0.
 */
double bench_median(size_t n, double *x);

/* Returns |a - b| / |b|, Euclidean norms over n entries. */
double bench_distance(size_t n, const double *a, const double *b);

/* Returns the exponent p of y ~ x^p by least squares over the last `last` of n points, those with
 * y <= 0, infinite or NaN left out. */
double bench_exponent(size_t n, const double *x, const double *y, size_t last);

/* Returns zeroed memory that child processes share, or NULL; released by munmap or at exit. */
void *bench_shared(size_t bytes);

/* Returns a number of /proc/self/status in bytes, "VmRSS" say; NAN if it is not there. */
double bench_memory(const char *name);

/* Begins to watch for the peak, "VmHWM", from here on; returns what is in use. */
double bench_watch_memory(void);

/* Runs work(data) in a child process. Returns 0 if it came to its end, the number of the signal
 * that ended it, or -1 if it left by exit() or could not be started. */
int bench_child(void (*work)(void *data), void *data);

/* Checks all arguments before a page is opened. usage: the options, "--out DIR [--large]", a word
 * in capitals for a value. An option that begins the usage must be given; "..." allows other words.
 * Returns 1; or 0 after the usage on stderr, and main returns 2. */
int bench_options(int argc, char *const *argv, const char *usage);

/* Return what follows an option, `otherwise` where it is not given: a word, a number, or a list of
 * at most `most` numbers in x, which holds `count` at first. has: 1 if the option is there. */
const char *bench_word(int argc, char *const *argv, const char *option, const char *otherwise);
double bench_number(int argc, char *const *argv, const char *option, double otherwise);
int bench_list(int argc, char *const *argv, const char *option, int *x, int count, int most);
int bench_has(int argc, char *const *argv, const char *option);

/* Returns word k, from 0, of those that are neither options of the usage nor their values. */
const char *bench_other(int argc, char *const *argv, const char *usage, int k);

/* Opens DIRECTORY/NAME.md and writes its head: the title, the command (make bench-<program> with
 * the options in argv, --out apart, as BENCH) and the kind of machine. NULL after a message. */
FILE *bench_page(const char *directory, const char *name, const char *title, int argc,
                 char *const *argv);

/* Checks the options of a program that writes one page, and opens it in the folder that follows
 * --out, else build. Exits with 2 or 1 after a message. */
FILE *bench_program(int argc, char *const *argv, const char *usage, const char *name,
                    const char *title);

/* Opens DIRECTORY/NAME for writing; NULL after a message. */
FILE *bench_open(const char *directory, const char *name);

/* Prints to the page and to stdout. */
void bench_print(FILE *page, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
