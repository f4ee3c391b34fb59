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

/* ---- rigid bodies (bodies.c) ----------------------------------------------------------------- */

/* A copy of a problem of bodies with scratch, and perhaps also with W by blocks: products and the
 * certificate use the factors, methods that need entries of W the blocks. Zero at first; the memory
 * stays from one problem to the next. */
typedef struct dlsi_formed {
  dls_contact problem;
  double *work, *x;  /* bodies.work; Wb.x */
  int *p, *i, *list; /* Wb.p; Wb.i; the contacts of each body: starts, then contacts */
  size_t work_room, x_room, p_room, i_room, list_room;
} dlsi_formed;

/* Turn *problem, a problem of bodies, into a copy with scratch (lend), and with W by blocks (form).
 * Its memory is in *formed. Other storage stays unchanged. dlsi_form_blocks checks a problem of
 * bodies first. DLS_E_MEMORY; DLS_E_SIZE for too many blocks. */
dls_status dlsi_lend(dlsi_formed *formed, const dls_contact **problem, dls_error *error);
dls_status dlsi_form_blocks(dlsi_formed *formed, const dls_contact **problem, dls_error *error);
void dlsi_formed_free(dlsi_formed *formed);

/* Returns 1 if W is only there as H^T H. */
static inline int dlsi_is_factored(const dls_contact *problem) {
  return problem->bodies.H && !problem->Wb.x;
}

/* Returns `held` if it has room for `count` entries. Else returns a new array of them and frees
 * held; NULL without memory, and held stays. room: of held. */
void *dlsi_make_room(void *held, size_t *room, size_t count, size_t size);

/* Computes u := W r + q (q NULL for 0) and, if a is not NULL, a := |H|^T |H| |r|; bodies.work := H
 * r. */
void dlsi_bodies_multiply(const dls_contact *problem, const int *order, const double *q,
                          const double *r, double *u, double *a);

/* Copies the d x d diagonal block of contact c. */
void dlsi_bodies_diagonal(const dls_contact *problem, int c, double *block);

/* The two bodies of contact c: their numbers, H and motions v; NULL for a fixed body. */
typedef struct dlsi_pair_of_bodies {
  const double *H[2];
  double *v[2];
} dlsi_pair_of_bodies;

static inline dlsi_pair_of_bodies dlsi_bodies_of(const dls_bodies *B, size_t size, size_t c,
                                                 double *v) {
  dlsi_pair_of_bodies of = {{NULL, NULL}, {NULL, NULL}};
  for (size_t side = 0; side < 2; side++) {
    const int b = B->body[2 * c + side];
    if (b < 0) continue;
    of.H[side] = B->H + (2 * c + side) * size;
    of.v[side] = v + (size_t)B->n * (size_t)b;
  }
  return of;
}

/* Two motions of a body. */
typedef double dlsi_two __attribute__((vector_size(16), aligned(8), may_alias));

/* Returns h . v; n = 3 or 6, a constant when inlined. */
static DLSI_INLINE double dlsi_motion_dot(const int n, const double *h, const double *v) {
  const dlsi_two *a = (const dlsi_two *)h, *b = (const dlsi_two *)v;
  dlsi_two s = a[0] * b[0];
  if (n == 6) {
    s += a[1] * b[1];
    s += a[2] * b[2];
    return s[0] + s[1];
  }
  return (s[0] + s[1]) + h[2] * v[2];
}

/* u (d) := q + H^T v over both bodies. */
static DLSI_INLINE void dlsi_bodies_look(const int d, const int n, const dlsi_pair_of_bodies *of,
                                         const double *q, double *u) {
  for (int i = 0; i < d; i++)
    u[i] = q[i];
  for (int side = 0; side < 2; side++)
    for (int i = 0; of->H[side] && i < d; i++)
      u[i] += dlsi_motion_dot(n, of->H[side] + n * i, of->v[side]);
}

/* v += H r of both bodies. */
static DLSI_INLINE void dlsi_bodies_push(const int d, const int n, const dlsi_pair_of_bodies *of,
                                         const double *r) {
  for (int side = 0; side < 2; side++) {
    const double *h = of->H[side];
    double *v = of->v[side];
    if (!h) continue;
    for (int k = 0; k < n; k++) {
      double sum = h[k] * r[0];
      for (int i = 1; i < d; i++)
        sum += h[k + n * i] * r[i];
      v[k] += sum;
    }
  }
}

/* u := q + H^T v for the contacts first .. end-1, v = bodies.work. */
void dlsi_bodies_unfold(const dls_contact *problem, int first, int end, double *u);

/* ---- units (units.c) ------------------------------------------------------------------------- */

/* A copy of a problem in units of its own. Zero at first; its powers and its memory stay from one
 * problem to the next. */
typedef struct dlsi_units {
  int W, q;            /* W and q of the caller are 2 to these powers times those of the copy */
  dls_contact problem; /* the copy; not in use while both are 0 */
  double *values;      /* its arrays, and: */
  double *r, *u;       /* m: of the copy */
  double *shown;       /* m: r of a progress in the units of the caller */
  size_t room;
} dlsi_units;

/* Returns 1 if squares stay in the range of numbers, so that no copy is needed. */
int dlsi_has_plain_units(const dls_contact *problem);

/* Turns *problem, which has been checked, into a copy in units of its own, if squares could leave
 * the range of numbers in those of the caller. DLS_E_MEMORY. */
dls_status dlsi_take_units(dlsi_units *units, const dls_contact **problem, dls_error *error);
void dlsi_units_free(dlsi_units *units);

/* The same of a problem and a vector r of reactions; neither is replaced if r would lose bits. */
dls_status dlsi_take_answer(dlsi_units *units, const dls_contact **problem, const double **r,
                            dls_error *error);

/* y := 2^power x, n entries, y may be x. The second one returns 1 if that has rounded none. */
void dlsi_shift(size_t n, int power, const double *x, double *y);
int dlsi_shift_exactly(size_t n, int power, const double *x, double *y);

/* Sets the fields of a certificate of the copy to the units of the caller. */
void dlsi_certificate_from_units(const dlsi_units *units, dls_certificate *certificate);

/* ---- the contact problem --------------------------------------------------------------------- */

/* One block column of W, dense or by blocks, for a loop over its blocks: for k = begin .. end-1 the
 * block in block row dlsi_row(&column, k) has entry (i, j) at block[i + ld j], block = x + k
 * step. */
typedef struct dlsi_block_column {
  size_t begin, end;
  const int *row; /* NULL: k */
  const double *x;
  size_t step, ld;
} dlsi_block_column;

static inline dlsi_block_column dlsi_contact_column(const dls_contact *problem, size_t c) {
  const size_t d = (size_t)problem->d, ld = (size_t)problem->W.ld;
  const dls_blocks *B = &problem->Wb;
  if (B->x) return (dlsi_block_column){(size_t)B->p[c], (size_t)B->p[c + 1], B->i, B->x, d * d, d};
  return (dlsi_block_column){0, (size_t)problem->nc, NULL, problem->W.a + d * c * ld, d, ld};
}

static inline size_t dlsi_row(const dlsi_block_column *column, size_t k) {
  return column->row ? (size_t)column->row[k] : k;
}

/* Copies the d x d diagonal block of contact c, column-major; zeros if a block-sparse W has
 * none. */
void dlsi_contact_diagonal(const dls_contact *problem, int c, double *block);

/* Adds W(:,c) dr to u for the d columns of contact c. */
void dlsi_contact_add_columns(const dls_contact *problem, int c, const double *dr, double *u);

/* Adds W(:,c) dr to u for the d columns of contact c, W by blocks. */
void dlsi_contact_add_blocks(const dls_contact *problem, int c, const double *dr, double *u);

/* Adds W(:,c[k]) dr[d k..] to u for k = 0 .. count-1, one after the other, W dense. */
void dlsi_contact_add_panel(const dls_contact *problem, int count, const int *c, const double *dr,
                            double *u);

/* As dlsi_contact_add_panel; also adds |W(:,c[k])| |dr[d k..]| to a. */
void dlsi_contact_add_both(const dls_contact *problem, int count, const int *c, const double *dr,
                           double *u, double *a);

/* y := W x, without q. */
void dlsi_contact_apply(const dls_contact *problem, const double *x, double *y);

/* Computes u := W r + q and, if a is not NULL, a := |W| |r|, column after column of the contacts in
 * `order`, which determines the rounding. order: contacts, nc; NULL for 0, 1, .. For bodies a is
 * |H|^T |H| |r|, the scale of the rounding of H^T (H r), and bodies.work := H r. */
void dlsi_contact_multiply(const dls_contact *problem, const int *order, const double *r, double *u,
                           double *a);

/* Compute y := A^T x and y -= A x for A (m x n, column-major, leading dimension m). */
void dlsi_panel_dot(size_t m, int n, const double *A, const double *x, double *y);
void dlsi_panel_subtract(size_t m, int n, const double *A, const double *x, double *y);

/* Computes one compliance per contact, the unit of the steps of methods: trace(W_cc) / d. If that
 * is not positive: the mean of the positive ones; if none is positive, the largest |entry| of the
 * diagonal blocks; 1 if all of them are 0. w: nc. */
void dlsi_contact_weights(const dls_contact *problem, double *w);

/* Computes the weights of the certificate: problem->weights, or W_nn and trace(W_tt) / (d-1) of the
 * diagonal block. A weight that is not positive is completed as above from those of its kind
 * (normal or tangential), and a kind without any from the other kind. w: 2 nc. */
void dlsi_certificate_weights(const dls_contact *problem, double *w);

/* Computes both in one pass. w: nc, weights: 2 nc. */
void dlsi_both_weights(const dls_contact *problem, double *w, double *weights);

/* Fills *subset as dls_contact_subset does, from arguments that have been checked; count > 0. */
void dlsi_subset(const dls_contact *problem, int count, const int *candidate, double *values,
                 int *index, dls_contact *subset);

/* Returns trace(W_cc) / d of one block. */
static inline double dlsi_block_weight(int d, const double *block) {
  if (d == 1) return block[0];
  return d == 2 ? (block[0] + block[3]) / 2 : (block[0] + block[4] + block[8]) / 3;
}

/* Returns 1 for a zero d-vector of a contact. */
static inline int dlsi_is_zero(int d, const double *v) {
  return v[0] == 0 && (d < 2 || v[1] == 0) && (d < 3 || v[2] == 0);
}

/* Returns |v_t|. */
static inline double dlsi_tangent_norm(int d, const double *v) {
  if (d == 1) return 0;
  if (d == 2) return fabs(v[1]);
  const double s = v[1] * v[1] + v[2] * v[2];
  return dlsi_is_plain(s) ? sqrt(s) : dlsi_norm2(v + 1, 2); /* to the same bits */
}

/* Projects v (d) on C_mu = { |r_t| <= mu r_n }: p := P(v); returns the branch taken. */
static inline dls_contact_state dlsi_project_cone(int d, double mu, const double *v, double *p) {
  if (dlsi_is_bonded(mu)) { /* C_mu = { r_n > 0 or r = 0 } */
    for (int i = 0; i < d; i++)
      p[i] = v[0] > 0 ? v[i] : 0;
    return v[0] > 0 ? DLS_STICK : DLS_FREE;
  }
  const double t = dlsi_tangent_norm(d, v);
  if (t <= mu * v[0] && v[0] >= 0) { /* inside; mu = 0 has t = mu v_n for any sign of v_n */
    for (int i = 0; i < d; i++)
      p[i] = v[i];
    return DLS_STICK;
  }
  if (mu * t <= -v[0]) { /* in the polar cone */
    for (int i = 0; i < d; i++)
      p[i] = 0;
    return DLS_FREE;
  }
  p[0] = (v[0] + mu * t) / (1 + mu * mu);
  if (d == 2)
    p[1] = copysign(mu * p[0], v[1]);
  else if (d == 3) {
    const double k = mu * p[0] / t;
    p[1] = k * v[1];
    p[2] = k * v[2];
  }
  return DLS_SLIP;
}

/* Computes the reactions r (d nc) that the law gives for v (d nc): r_n = max(v_n, 0), r_t = v_t put
 * on the disc |.| <= mu r_n. Unlike this, the projection on C_mu also changes r_n. */
void dlsi_put_on_discs(int d, int nc, const double *mu, const double *v, double *r);

/* Computes F_c of the certificate, a position, for one contact of the weights w_n = w[0] and w_t =
 * w[1]; returns the branch. With v = D r - u and the radius R = mu (w_t / w_n) v_n
 *
 *   free   F = D r                                    where v_n < 0
 *   stick  F = u                                      where |v_t| <= R
 *   slip   F_n = u_n, F_t = D r_t - R v_t / |v_t|     else
 *
 * An infinite friction sticks where v_n > 0, else it is free. */
static inline dls_contact_state dlsi_contact_misfit(int d, double mu, const double *w,
                                                    const double *r, const double *u, double *F) {
  double v[3] = {0}, Dr[3] = {0};
  for (int i = 0; i < d; i++) {
    Dr[i] = w[i > 0] * r[i];
    v[i] = Dr[i] - u[i];
    F[i] = u[i];
  }
  const int bonded = dlsi_is_bonded(mu);
  if (v[0] < 0 || (bonded && v[0] == 0)) {
    for (int i = 0; i < d; i++)
      F[i] = Dr[i];
    return DLS_FREE;
  }
  if (bonded) return DLS_STICK;
  const double t = dlsi_tangent_norm(d, v), R = d > 1 ? mu * (w[1] / w[0]) * v[0] : 0;
  if (t <= R) return DLS_STICK;
  if (d == 1) return t == 0 ? DLS_STICK : DLS_SLIP; /* slip: NaN */
  for (int i = 1; i < d; i++)
    F[i] = Dr[i] - R * (v[i] / t);
  return DLS_SLIP;
}

/* Returns the residual that a certificate with this rounding level has to meet: max(tol, 4 floor),
 * NaN for a floor of NaN, which no residual meets. */
static inline double dlsi_target(double tol, double floor) {
  return 4 * floor <= tol ? tol : 4 * floor;
}

/* Returns 1 if every part of the residual meets its target. */
static inline int dlsi_certificate_meets(const dls_certificate *c, double tol) {
  return c->residual_u <= dlsi_target(tol, c->floor_u) &&
         c->residual_r <= dlsi_target(tol, c->floor_r) &&
         c->equilibrium <= dlsi_target(tol, c->floor_e);
}

/* dls_certificate_holds and dls_certificate_verdict, inside of the library. */
int dlsi_certificate_holds(const dls_certificate *certificate, double tol);
dls_status dlsi_certificate_verdict(const dls_certificate *certificate, double tol);

/* Returns the target of the part of the certificate that `residual` is. */
static inline double dlsi_certificate_target(const dls_certificate *c, double tol) {
  return dlsi_target(tol, c->residual_r > c->residual_u ? c->floor_r : c->floor_u);
}

/* Returns the status of a solve that has ended with `reason` and the answer of this certificate.
 * That is the verdict of the certificate, if it has one and the method ended by itself; else the
 * reason, but DLS_STALLED for a DLS_OK or DLS_TO_ROUNDING that does not hold. */
dls_status dlsi_settled(const dls_certificate *c, double tol, dls_status reason);

/* Sets the three residuals. force: |D^-1/2 F'|; r: |r|. */
void dlsi_set_residuals(dls_certificate *c, double residual_u, double force, double r);

/* Data for measuring the laws of contact and friction, m entries unless said otherwise. */
typedef struct dlsi_laws {
  int d, nc;
  const double *mu;     /* nc */
  const double *r, *u;  /* reactions; positions */
  const double *w;      /* weights: 2 nc */
  const double *a, *b;  /* a + |b| is the size of the terms in the sum u; b: NULL for 0 */
  const double *scale;  /* residual_u is relative to its norm over the contacts that touch */
  double *F;            /* receives F */
  const double *hidden; /* an F_c with entries up to these is rounding, taken as 0; or NULL */
} dlsi_laws;

/* Fills the residuals, floors and laws of the certificate; equilibrium 0, body -1. */
void dlsi_laws_measure(const dlsi_laws *of, dls_certificate *certificate);

/* Measures r: its certificate from u = W r + q, a = |W| |r| and the weights w (2 nc), those of
 * dlsi_certificate_weights. F: receives D^1/2 F', m. */
void dlsi_contact_measure(const dls_contact *problem, const double *r, const double *u,
                          const double *a, const double *w, double *F,
                          dls_certificate *certificate);

#endif
