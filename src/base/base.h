/*
 * base.h: the hidden base of the library, used by every other folder. Names start with dlsi_.
 */
#ifndef DLSI_BASE_H
#define DLSI_BASE_H

#include <fenv.h>
#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

#include "delassus/info.h"
#include "delassus/model.h"

/* ---- what the compiler has to keep ----------------------------------------------------------- */

/* NaN and Inf have to be seen, and sums to be rounded as they are written. */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) ||                                     \
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "delassus: without -Ofast, -ffast-math, -ffinite-math-only, -fassociative-math, please"
#endif
/* A double has to be rounded to a double: on i386 -msse2 -mfpmath=sse does that. */
#if FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 1
#error "delassus: needs arithmetic in double; on i386 add -msse2 -mfpmath=sse"
#endif

/* ---- loops that vectorise -------------------------------------------------------------------- */

/* Compiles a function twice, plain and with AVX2, if the linker can choose at load time. Both round
 * products and sums one by one, to the same bits. Functions that it calls must be inlined. Not
 * under the thread sanitizer, whose code would run before it is set up, when the linker chooses;
 * not without optimisation, so that make coverage sees each line once. */
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define __SANITIZE_THREAD__
#endif
#endif
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__OPTIMIZE__) &&                          \
    !defined(__SANITIZE_THREAD__)
#define DLSI_CLONES __attribute__((target_clones("avx2", "default")))
#define DLSI_INLINE inline __attribute__((always_inline))
#else
#define DLSI_CLONES
#define DLSI_INLINE inline
#endif

/* ---- the host's floating point environment (environment.c) ----------------------------------- */

/* An environment; known: 1 if there is one. */
typedef struct dlsi_host {
  int known;
  fenv_t environment;
} dlsi_host;

/* Holds what a public function restores. */
typedef struct dlsi_door {
  unsigned control;     /* x86-64: control and flags of SSE, ... */
  unsigned short flags; /* ... flags of the x87, which BLAS and LAPACK may use */
  int held;             /* 1: the host traps or rounds otherwise; found and before are set */
  fenv_t found;
  dlsi_host before;
} dlsi_door;

/* The slow halves of the next two. */
void dlsi_hold_host(dlsi_door *door);
void dlsi_free_host(const dlsi_door *door);

#if defined(__x86_64__) && defined(__GNUC__)
static inline unsigned short dlsi_x87_flags(void) {
  unsigned short word;
  __asm__ volatile("fnstsw %0" : "=a"(word));
  return word & 0x3f;
}

static inline void dlsi_door_open(dlsi_door *door) {
  const unsigned masks = 0x1f80, rounding = 0x6000; /* all masked, to nearest: the default */
  door->control = __builtin_ia32_stmxcsr();
  door->flags = dlsi_x87_flags();
  door->held = (door->control & (masks | rounding)) != masks;
  if (door->held) dlsi_hold_host(door);
}

static inline void dlsi_door_close(dlsi_door *door) {
  if (door->held) {
    dlsi_free_host(door);
    return;
  }
  const int raised = dlsi_x87_flags() & ~door->flags;
  if (raised) (void)feclearexcept(raised);
  if (__builtin_ia32_stmxcsr() != door->control) __builtin_ia32_ldmxcsr(door->control);
}
#else
static inline void dlsi_door_open(dlsi_door *door) {
  dlsi_hold_host(door);
}

static inline void dlsi_door_close(dlsi_door *door) {
  dlsi_free_host(door);
}
#endif

/* Comes first in every public function that may compute, in functions of the library that are
 * called back as a host's are, and in entry functions of threads: no trap, round to nearest. When
 * the function returns, it restores traps, flags and rounding. */
#define DLSI_DOOR                                                                                  \
  dlsi_door door __attribute__((cleanup(dlsi_door_close)));                                        \
  dlsi_door_open(&door)

/* Enclose a call of the host's code, which runs in the environment that the host left. */
void dlsi_go_out(dlsi_host *own);
void dlsi_come_in(const dlsi_host *own);

/* ---- errors ---------------------------------------------------------------------------------- */

#if defined(__GNUC__)
#define DLSI_PRINTF(f, a) __attribute__((cold, format(printf, f, a)))
#else
#define DLSI_PRINTF(f, a)
#endif

/* Fills *error (NULL: nothing) and returns status, so that a check reads
 *   if (n < 1) return dlsi_fail(error, DLS_E_SIZE, "n", -1, n, "is %d, must be at least 1", n);
 * argument must be a static string; index -1 for none. The message is "argument[index]: text"
 * until the public function puts its name before it by dlsi_at. */
dls_status dlsi_fail(dls_error *error, dls_status status, const char *argument, long long index,
                     double value, const char *format, ...) DLSI_PRINTF(6, 7);

/* Returns status; puts the name of the public function into *error (NULL: nothing) if status is an
 * error. Every public function ends in it: return dlsi_at(__func__, status, error). If one public
 * function has called another, the outer name stays. */
dls_status dlsi_at(const char *function, dls_status status, dls_error *error);

/* Report the two commonest failures. They are inline, so that every reader (and analyser) sees that
 * the status is never DLS_OK. */
static inline dls_status dlsi_no_memory(dls_error *error) {
  (void)dlsi_fail(error, DLS_E_MEMORY, "", -1, 0, "out of memory");
  return DLS_E_MEMORY;
}
static inline dls_status dlsi_is_null(dls_error *error, const char *argument) {
  (void)dlsi_fail(error, DLS_E_ARGUMENT, argument, -1, 0, "is NULL");
  return DLS_E_ARGUMENT;
}

/* Returns the index of the first NaN or Inf among x[0..n), -1 if there is none. */
long long dlsi_first_not_finite(const double *x, size_t n);

/* Check a view, which errors call `argument`: pointers, sizes, indices, finite values. */
dls_status dlsi_check_vector(const char *argument, const double *x, size_t n, dls_error *error);
dls_status dlsi_check_dense(const char *argument, const dls_dense *A, int rows, int cols,
                            dls_error *error);
dls_status dlsi_check_sparse(const char *argument, const dls_sparse *A, int rows, int cols,
                             dls_error *error);
dls_status dlsi_check_blocks(const dls_blocks *B, dls_error *error);
dls_status dlsi_check_contact(const dls_contact *problem, dls_error *error);
dls_status dlsi_check_model(const dls_model *model, dls_error *error);
dls_status dlsi_check_model_contacts(const dls_model *model, dls_error *error); /* all but K */

/* Checks that the n friction coefficients "mu" are >= 0; INFINITY is one. */
dls_status dlsi_check_friction(const double *mu, size_t n, dls_error *error);

/* Returns 1 for an infinite friction: it bonds the tangents of a contact that is pressed. */
static inline int dlsi_is_bonded(double mu) {
  return mu > DBL_MAX;
}

/* Returns the first contact with infinite friction, -1 if there is none. */
int dlsi_first_bonded(const dls_contact *problem);

/* Returns DLS_E_UNSUPPORTED if there is one, for methods whose form of the law needs mu itself. */
dls_status dlsi_refuse_bonded(const dls_contact *problem, dls_error *error);

/* Returns the bound mu r_n of |r_t| for r_n >= 0: 0 for r_n = 0, whatever the friction. */
static inline double dlsi_friction_bound(double mu, double rn) {
  return rn > 0 ? mu * rn : 0;
}

/* Checks that d is 1, 2 or 3. */
dls_status dlsi_check_dimension(const char *argument, int d, dls_error *error);

/* Checks that d is 1, 2 or 3, nc at least 0, and d nc an int. */
dls_status dlsi_check_sizes(int d, int nc, dls_error *error);

/* Sets the limits to their defaults. */
void dlsi_limits_init(dls_limits *limits);

/* Returns the limit of iterations of a method whose own limit is `own`. */
static inline int dlsi_most_iterations(const dls_limits *limits, int own) {
  return limits->max_iterations ? limits->max_iterations : own;
}

dls_status dlsi_check_limits(const dls_limits *limits, dls_error *error);

/* Returns the CPU seconds of this thread at the start of a solve. Reads no clock and returns -1 if
 * limits have neither a time limit nor a callback, or cpu_seconds = dlsi_no_clock. */
double dlsi_clock_start(const dls_limits *limits);

/* The cpu_seconds of an inner solve: the outer solve keeps the time. */
static const double dlsi_no_clock = -1;

/* Returns the CPU seconds since a solve began. Reads no clock and returns 0 for begun = -1. */
double dlsi_clock_since(double begun);

/* Returns 1 if the time of a solve that began at `begun` is over. */
int dlsi_clock_is_over(const dls_limits *limits, double begun);

/* Returns the cpu_seconds for an inner solve of one that began at `begun`. */
double dlsi_clock_left(const dls_limits *limits, double begun);

/* Calls the caller's callback with progress, after setting cpu_seconds, and checks the time limit.
 * Returns DLS_OK to go on, DLS_CANCELLED, or DLS_TIME_LIMIT. */
dls_status dlsi_tell(const dls_limits *limits, double begun, dls_progress *progress);

/* Lets the host watch and cancel a long piece of work other than a solve. */
typedef struct dlsi_watch {
  dls_limits limits; /* only the callback */
  double begun;
  const char *method, *stage;
  int done, all; /* pieces of the stage; all = 0: not known */
  double flops;  /* since the host was called last */
  int is_cancelled;
} dlsi_watch;

/* Starts a stage of `all` pieces and calls the host. Returns DLS_OK, or DLS_CANCELLED from then on.
 * watch = NULL or without a callback: nothing happens. */
dls_status dlsi_watch_stage(dlsi_watch *watch, const char *stage, int all);

/* Reports, between two pieces, that `done` pieces of the stage are done, after `flops` more
 * operations. Calls the host about every millisecond. Returns 1 if the work is cancelled. */
int dlsi_watch_stops(dlsi_watch *watch, int done, double flops);

/* Makes the last call. */
void dlsi_watch_end(dlsi_watch *watch);

/* Makes the last call of a solve. */
void dlsi_tell_last(const dls_limits *limits, double begun, const char *method, const char *stage,
                    int iterations, double residual, const double *r);

/* A number among the settings of a method and its range: lowest <= value <= highest, or, with
 * `open`, lowest < value < highest. */
typedef struct dlsi_setting {
  const char *name;
  double value, lowest, highest;
  int open;
} dlsi_setting;

dls_status dlsi_check_each(int count, const dlsi_setting *setting, dls_error *error);

/* Checks the settings of a method: size, set by their init function, is the wanted size of the
 * struct; the limits; `count` numbers of the method's own. */
dls_status dlsi_check_settings(const dls_limits *limits, size_t size, size_t wanted, int count,
                               const dlsi_setting *own, dls_error *error);

/* Checks that r is not NULL and, for a warm start, finite. */
dls_status dlsi_check_start(const dls_contact *problem, const double *r, const double *u,
                            int warm_start, dls_error *error);

/* Checks that r and u (or NULL), which a solve writes, overlap neither each other nor W, q, mu. */
dls_status dlsi_check_apart(const dls_contact *problem, const double *r, const double *u,
                            dls_error *error);

/* Checks the arguments of a solve: a sound problem of the workspace's dimension d with at most its
 * nc contacts, and the start r. */
dls_status dlsi_check_solve(int d, int nc, const dls_contact *problem, const double *r,
                            const double *u, int warm_start, dls_error *error);

/* Returns the number of contacts of a model, active or not. */
int dlsi_model_candidates(const dls_model *model);

/* Returns 1 if the problem has no contact. It is then solved: fills *info (or NULL), and calls the
 * progress callback once, under `name`. */
int dlsi_is_empty(const dls_contact *problem, const dls_limits *limits, dls_method method,
                  const char *name, dls_info *info);

/* ---- threads --------------------------------------------------------------------------------- */

/* Lock and unlock the parts of MUMPS, METIS and HDF5 that are not re-entrant. Put one call of such
 * a library between both, never a callback of the host. */
void dlsi_lock(void);
void dlsi_unlock(void);

/* Begin and end a call that changes the object with this flag. A call on it from inside its own
 * callback, or from another thread, is refused: DLS_E_BUSY, naming `argument`. dlsi_leave returns
 * status; call it only after DLS_OK of dlsi_enter. */
dls_status dlsi_enter(atomic_int *busy, const char *argument, dls_error *error);
dls_status dlsi_leave(atomic_int *busy, dls_status status);

/* Threads that help the caller with tasks; NULL: none. */
typedef struct dlsi_team dlsi_team;

/* Runs body(team, data) in this thread, with up to threads - 1 helpers if the compiler has OpenMP;
 * team is NULL for threads < 2 or without OpenMP. */
void dlsi_team_run(int threads, void (*body)(dlsi_team *team, void *data), void *data);

/* Runs task(data, k) for k = 0 .. tasks-1, in any order and at the same time. Tasks write to
 * separate memory, so that their bits do not depend on the threads. */
typedef void dlsi_task(void *data, int k);
void dlsi_parallel(dlsi_team *team, int tasks, dlsi_task *task, void *data);

enum { dlsi_most_threads = 1024 };

/* ---- memory ---------------------------------------------------------------------------------- */

/* A workspace in one piece of memory. A carve function is a sequence of takes. Run it twice: on {0}
 * to count bytes, then, after dlsi_arena_allocate, on memory. Every piece starts a multiple of 64
 * bytes after base. An overflow of size_t, or a take past the end, makes this take and all later
 * ones fail. */
typedef struct dlsi_arena {
  char *base;  /* NULL while counting */
  size_t size; /* of base */
  size_t used;
  int failed;
} dlsi_arena;

/* Returns the next piece, for count elements of size bytes; NULL while counting and after a
 * failure. */
void *dlsi_take(dlsi_arena *arena, size_t count, size_t size);

/* Ends the counting run: allocates arena->base, which the caller frees, and rewinds, so that the
 * takes run again. If the sizes overflowed, DLS_E_SIZE names `argument` with its value;
 * DLS_E_MEMORY. */
dls_status dlsi_arena_allocate(dlsi_arena *arena, const char *argument, long long value,
                               dls_error *error);

/* Both runs: allocates a workspace in one piece of memory, which free() releases: *out := a copy of
 * `filled` (size bytes), with arrays that carve has taken from the arena. carve is called twice,
 * first on `filled`, to count. Errors as above. */
typedef void dlsi_carve(void *work, dlsi_arena *arena);
dls_status dlsi_carve_workspace(void **out, void *filled, size_t size, dlsi_carve *carve,
                                const char *argument, long long value, dls_error *error);

/* Returns malloc(count * size), of 1 byte for 0 bytes; NULL on overflow or when there is no memory.
 * */
void *dlsi_alloc(size_t count, size_t size);

/* ---- numbers --------------------------------------------------------------------------------- */

/* Returns |x|_2 without overflow or underflow in between; NaN stays NaN. */
double dlsi_norm2(const double *x, size_t n);

/* Returns the place of `value` in the ascending x; -1: not there. */
int dlsi_find(const int *x, int count, int value);

/* Mixes the bits of x (the finalizer of splitmix64: Steele, Lea and Flood, OOPSLA 2014). Steps of
 * DLSI_GOLDEN_BITS, the golden ratio times 2^64, make a sequence of unlike x. */
#define DLSI_GOLDEN_BITS 0x9e3779b97f4a7c15u
uint64_t dlsi_mix(uint64_t x);

/* Completes a frame whose row 0 has a normal n of d entries, of any length > 0: n becomes a unit
 * vector; in 2D t is n turned by -90 degrees; in 3D t is the axis that n leans to least, without
 * its part along n, and s = n x t. Returns 0 if n is zero or not finite. */
int dlsi_frame(int d, double frame[3][3]);

/* Returns the number in [0, 1) drawn by x, by dlsi_mix. */
double dlsi_draw(uint64_t x);

/* Returns the number in [0, 1) drawn by entry i >= 0 of sequence k >= 0. */
double dlsi_draw_entry(int k, int i);

static inline int dlsi_is_digit(int c) {
  return c >= '0' && c <= '9';
}

/* Reads the decimal digits at *text, a whole number from `least` >= 0 to `most`, and moves *text
 * past them. Returns 0 if no such number stands there; takes no sign and no blank. */
int dlsi_read_whole(const char **text, int least, int most, int *value);

/* Returns 1 if the plain sum of squares `sum` has neither over- nor underflown, so that sqrt(sum)
 * is the norm. */
static inline int dlsi_is_plain(double sum) {
  return sum > 0x1p-900 && sum < 0x1p900;
}

/* Returns max |x_i|, 0 for n = 0; NaN stays NaN (fmax and idamax lose it). */
double dlsi_max_abs(const double *x, size_t n);

#endif
