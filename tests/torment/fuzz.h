/*
 * fuzz.h: inputs made of any bytes, for every interface of the library and the program. A target
 * takes the bytes, calls what it is named after, and ends the process (FUZZ_CHECK, a signal, a
 * sanitizer) if the library breaks a promise. An error status is no failure.
 */
#ifndef FUZZ_H
#define FUZZ_H

#include <stddef.h>

typedef struct fuzz_target {
  const char *name;
  void (*run)(const unsigned char *data, size_t size);
  const char *seeds[8]; /* files under data/ to start from; NULL ends them, none: random bytes */
  int is_text;          /* 1: mutate numbers and lines, too */
  int is_loud;          /* 1: writes to stdout and stderr, which go to /dev/null */
} fuzz_target;

/* All targets; the name of the last one is NULL. */
extern const fuzz_target fuzz_targets[];

enum { fuzz_most = 16384 }; /* bytes of an input */

/* Ends the process with a message unless `holds`. */
#define FUZZ_CHECK(holds) fuzz_check((holds), #holds, __FILE__, __LINE__)
void fuzz_check(int holds, const char *text, const char *file, int line);

/* The bytes that are left; 0 comes after the last. */
typedef struct fuzz_bytes {
  const unsigned char *at;
  size_t left;
} fuzz_bytes;

int take_byte(fuzz_bytes *b);
int take_int(fuzz_bytes *b, int low, int high); /* low <= . <= high */
double take_value(fuzz_bytes *b);               /* small numbers, extreme ones, any bits */
double take_plain(fuzz_bytes *b);               /* -4 .. 4 by sixteenths */
double take_scale(fuzz_bytes *b);               /* mostly 1, else a power of ten, up to 1e300 */

/* Returns an array of exactly so many bytes, a copy of `from` or, with NULL, of bytes 0x5a: the
 * sanitizers see a read or a write beyond it. It lives until the input ends. */
void *fuzz_exact(const void *from, size_t bytes);
double *fuzz_doubles(const double *from, int count);
int *fuzz_ints(const int *from, int count);

/* Runs a target and frees the arrays of fuzz_exact. */
void fuzz_run(const fuzz_target *target, const unsigned char *data, size_t size);

/* Puts the bytes into a file of this process and returns its name. */
const char *fuzz_file(const unsigned char *data, size_t size);

enum { fuzz_rows = 18 }; /* of W, at most */

/* Makes a contact problem of up to 5 candidates in any storage, valid or not, in exact arrays. */
struct dls_contact;
void take_contact(fuzz_bytes *b, struct dls_contact *problem);
void take_vector(fuzz_bytes *b, int n, double *x);
struct dls_limits;
void take_limits(fuzz_bytes *b, struct dls_limits *limits);

/* Solves the problem by a method, with settings, both from the bytes, and checks the answer. */
void fuzz_solve(const struct dls_contact *problem, fuzz_bytes *b);

void fuzz_fclib(const unsigned char *data, size_t size);
void fuzz_fclib_sets(const unsigned char *data, size_t size);
void fuzz_mtx(const unsigned char *data, size_t size);
void fuzz_text(const unsigned char *data, size_t size);
void fuzz_calculix(const unsigned char *data, size_t size);
void fuzz_lcp(const unsigned char *data, size_t size);
void fuzz_contact(const unsigned char *data, size_t size);
void fuzz_reduction(const unsigned char *data, size_t size);
void fuzz_motion(const unsigned char *data, size_t size);
void fuzz_doors(const unsigned char *data, size_t size);
void fuzz_calls(const unsigned char *data, size_t size);
void fuzz_plans(const unsigned char *data, size_t size);
void fuzz_tables(const unsigned char *data, size_t size);
void fuzz_numpy(const unsigned char *data, size_t size);
void fuzz_program(const unsigned char *data, size_t size);

#endif
