/* program.h: running the program `delassus` from a test, with a fresh directory. */
#ifndef PROGRAM_H
#define PROGRAM_H

#include <stdio.h>

extern char directory[64];
extern char output[200000]; /* standard output and error of the last run */

/* of a checked fixture */
void make_directory(void);
void remove_directory(void);

/* Runs `delassus ARGUMENTS`, "@" standing for the test's directory; returns its exit status. */
int run(const char *arguments);

/* Returns 1 if there is gnuplot. Without it the test fails if NO_SKIP is set, as in .ci/run. */
int has_gnuplot(void);

/* Returns the path of a file of the test's directory, until the next call. */
const char *path_of(const char *name);

/* Opens a file of the test's directory, which has to succeed. */
FILE *open_file(const char *name, const char *mode);
void write_file(const char *name, const char *text);

/* Counts the lines of a file of the test's directory; last (size) := the last one. */
int lines_of(const char *name, char *last, int size);

/* Returns the contents of a file of the test's directory, until the next call. */
const char *contents(const char *name);

/* Returns the number that follows `before` in what the last run printed. */
double number_after(const char *before);

/* Returns the number behind "name": in the JSON that the last run printed. */
double number_of(const char *name);

/* Ends a test that needs FCLIB files in a build without HDF5. */
#define NEEDS_HDF5                                                                                 \
  if (!WITH_HDF5) return

/* Ends a test of meshes that MUMPS factorises in a build without it. */
#define NEEDS_MUMPS                                                                                \
  if (!WITH_MUMPS) return

#endif
