/*
 * delassus/status.h: the status that every call returns, the details of an error, and the version.
 *
 *   < 0  error: nothing was computed, all outputs are unchanged
 *   = 0  done; for a solver: solved, certified
 *   > 0  stopped early: the outputs hold the best answer found, the info has its certificate
 *
 * Layouts of structs and values of enums are fixed for a SONAME (libdelassus.so.0): a library that
 * changes one of them carries another SONAME. Symbols of libdelassus.so have the version
 * DELASSUS_0.
 */
#ifndef DELASSUS_STATUS_H
#define DELASSUS_STATUS_H

#include <stddef.h>

/* The version of these headers, as text and, for #if, as major * 10000 + minor * 100 + patch. */
#define DLS_VERSION        "0.1.0"
#define DLS_VERSION_NUMBER 100

#if defined(DLS_BUILD_SHARED) && defined(__GNUC__)
#define DLS_API __attribute__((visibility("default")))
#else
#define DLS_API
#endif

#if defined(__GNUC__)
#define DLS_MUST_USE __attribute__((warn_unused_result))
#else
#define DLS_MUST_USE
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef enum dls_status {
  DLS_OK = 0, /* done; solvers: dls_certificate_holds */

  DLS_MAX_ITERATIONS = 1,      /* the iteration limit came first */
  DLS_CANCELLED = 2,           /* the progress callback returned non-zero */
  DLS_STALLED = 3,             /* no further progress in this arithmetic */
  DLS_RAY = 4,                 /* Lemke's method ended in a ray (dls_lemke_ray) without an answer;
                                 a solution may or may not exist */
  DLS_NO_SOLUTION = 5,         /* proved: no solution exists */
  DLS_NO_SOLUTION_LIKELY = 6,  /* not proved; dls_solver_direction() shows why */
  DLS_TIME_LIMIT = 7,          /* limits.cpu_seconds came first */
  DLS_FOLDED = 8,              /* forming.h: the next step would leave no body */
  DLS_TO_ROUNDING = 9,         /* solved to rounding, which is above the tolerance; see the floors
                                 of the certificate. auto: up to 1e-4, or r is proved */
  DLS_NOT_IN_EQUILIBRIUM = 10, /* the forces of a body do not balance, by certificate.unbalanced */

  DLS_E_ARGUMENT = -1,              /* NULL, or a value outside its range */
  DLS_E_SIZE = -2,                  /* dimensions that do not fit, or too large to address */
  DLS_E_NOT_FINITE = -3,            /* NaN or Inf in an input array */
  DLS_E_SETTINGS = -4,              /* settings not filled by their init function */
  DLS_E_MEMORY = -5,                /* malloc failed */
  DLS_E_NOT_POSITIVE_DEFINITE = -6, /* Cholesky met a pivot <= 0 */
  DLS_E_SINGULAR = -7,              /* the matrix is singular to working precision */
  DLS_E_UNSUPPORTED = -8,           /* not in this build, or not for this kind of problem */
  DLS_E_FILE = -9,                  /* the file cannot be opened, read or written */
  DLS_E_FORMAT = -10,               /* the file is not what it should be */
  DLS_E_CALLBACK = -11,             /* a callback of the host reported failure */
  DLS_E_BUSY = -12,                 /* another call is using the object (the guide, "Threads") */
  DLS_E_NO_DERIVATIVE = -13         /* the answer has none: derive.h */
} dls_status;

/* Details of an error. The caller owns the struct; every call takes NULL instead. A call fills it
 * when it returns a status < 0, and leaves it alone otherwise. */
typedef struct dls_error {
  dls_status status;
  const char *function; /* name of the function that was called; static storage */
  const char *argument; /* the argument at fault as the header spells it, "" if none; static */
  long long index;      /* 0-based index into that argument, -1 if it has none */
  double value;         /* the offending value, 0 if there is none */
  char message[200];    /* one sentence for a log, always terminated */
} dls_error;

/* Returns the name of a status, "DLS_E_SIZE" say; "unknown status" for any other number. Static
 * storage. */
DLS_API const char *dls_status_name(dls_status status);

/* Returns a status in words for people, "iteration limit reached" say. Static storage. */
DLS_API const char *dls_status_text(dls_status status);

/* Returns 1 if an answer is certified: DLS_OK (solved) or DLS_TO_ROUNDING (solved to rounding).
 * Returns 0 for any other status. With each status >= 0 of a solver r, u and x hold its best
 * answer. */
DLS_API int dls_solved(dls_status status);

/* Returns the version of the library that runs, written as DLS_VERSION. Static storage. */
DLS_API const char *dls_version(void);

#ifdef __cplusplus
}
#endif

#endif
