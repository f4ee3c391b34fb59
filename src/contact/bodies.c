/*
 * bodies.c: W = H^T H of rigid bodies, kept factored: products, W by blocks on demand.
 *
 *   v_b = sum over the contacts c of body b of  H_cb r_c        motions, n per body
 *   u_c = q_c + sum over the bodies b of contact c of  H_cb^T v_b
 *   W_ck = sum over the bodies b that c and k share of  H_cb^T H_kb
 *
 * A product costs 4 n d operations per contact, however many neighbours it has. Fails: no memory; W
 * with too many blocks, as for a body that all others touch.
 */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "contact.h"

/* ---- products -------------------------------------------------------------------------------- */

static size_t bodies_size(const dls_contact *problem) {
  return (size_t)problem->bodies.n * (size_t)problem->d;
}

/* Calls CALL(d, n) with constants, which the compiler knows when it inlines. */
#define BY_SIZE(CALL)                                                                              \
  if (problem->d == 1 && problem->bodies.n == 3)                                                   \
    CALL(1, 3);                                                                                    \
  else if (problem->d == 1)                                                                        \
    CALL(1, 6);                                                                                    \
  else if (problem->d == 2)                                                                        \
    CALL(2, 3);                                                                                    \
  else                                                                                             \
    CALL(3, 6)

static DLSI_INLINE void bodies_gather(const int d, const int n, const dls_contact *problem,
                                      const int *order, const double *r) {
  const dls_bodies *B = &problem->bodies;
  for (int k = 0; k < problem->nc; k++) {
    const size_t c = order ? (size_t)order[k] : (size_t)k;
    if (dlsi_is_zero(d, r + (size_t)d * c)) continue;
    const dlsi_pair_of_bodies of = dlsi_bodies_of(B, (size_t)n * (size_t)d, c, B->work);
    dlsi_bodies_push(d, n, &of, r + (size_t)d * c);
  }
}

static DLSI_INLINE void bodies_spread(const int d, const int n, const dls_contact *problem,
                                      int first, int end, const double *q, double *u) {
  static const double zero[3] = {0};
  const dls_bodies *B = &problem->bodies;
  for (size_t c = (size_t)first; c < (size_t)end; c++) {
    const dlsi_pair_of_bodies of = dlsi_bodies_of(B, (size_t)n * (size_t)d, c, B->work);
    dlsi_bodies_look(d, n, &of, q ? q + (size_t)d * c : zero, u + (size_t)d * c);
  }
}

/* Adds |H| |r| to v and |H|^T v to a: a product without W rounds in both H and H^T. */
static DLSI_INLINE void bodies_magnitudes(const size_t d, const size_t n,
                                          const dls_contact *problem, const double *r, double *v,
                                          double *a) {
  const dls_bodies *B = &problem->bodies;
  const size_t places = 2 * (size_t)problem->nc;
  for (size_t k = 0; k < places; k++) {
    if (B->body[k] < 0 || dlsi_is_zero((int)d, r + k / 2 * d)) continue;
    const double *H = B->H + n * d * k;
    double *of = v + n * (size_t)B->body[k];
    for (size_t i = 0; i < d; i++)
      for (size_t l = 0; l < n; l++)
        of[l] += fabs(H[l + n * i]) * fabs(r[k / 2 * d + i]);
  }
  for (size_t k = 0; k < places; k++) {
    if (B->body[k] < 0) continue;
    const double *H = B->H + n * d * k, *of = v + n * (size_t)B->body[k];
    for (size_t i = 0; i < d; i++)
      for (size_t l = 0; l < n; l++)
        a[k / 2 * d + i] += fabs(H[l + n * i]) * of[l];
  }
}

void dlsi_bodies_unfold(const dls_contact *problem, int first, int end, double *u) {
#define SPREAD(d, n) bodies_spread(d, n, problem, first, end, problem->q, u)
  BY_SIZE(SPREAD);
}

void dlsi_bodies_multiply(const dls_contact *problem, const int *order, const double *q,
                          const double *r, double *u, double *a) {
  const size_t room = (size_t)problem->bodies.n * (size_t)problem->bodies.count;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  double *work = problem->bodies.work;
  if (m == 0) return; /* nothing was lent */
  memset(work, 0, room * sizeof *work);
#define GATHER(d, n) bodies_gather(d, n, problem, order, r)
  BY_SIZE(GATHER);
#define SPREAD_ALL(d, n) bodies_spread(d, n, problem, 0, problem->nc, q, u)
  BY_SIZE(SPREAD_ALL);
  if (!a) return;
  memset(work + room, 0, room * sizeof *work);
  memset(a, 0, m * sizeof *a);
#define MAGNITUDES(d, n) bodies_magnitudes(d, n, problem, r, work + room, a)
  BY_SIZE(MAGNITUDES);
}

/* Adds A^T B to the block, A and B n x d. */
static DLSI_INLINE void bodies_add_product(const size_t d, const size_t n, const double *A,
                                           const double *B, double *block) {
  for (size_t j = 0; j < d; j++)
    for (size_t i = 0; i < d; i++) {
      double sum = A[n * i] * B[n * j];
      for (size_t k = 1; k < n; k++)
        sum += A[k + n * i] * B[k + n * j];
      block[i + d * j] += sum;
    }
}

/* block := W_cc, inlined for constants d and n. */
static DLSI_INLINE void bodies_square(const size_t d, const size_t n, const dls_contact *problem,
                                      int c, double *block) {
  const size_t size = n * d;
  for (size_t e = 0; e < d * d; e++)
    block[e] = 0;
  for (size_t k = 2 * (size_t)c; k < 2 * (size_t)c + 2; k++) {
    const double *H = problem->bodies.H + k * size;
    if (problem->bodies.body[k] >= 0) bodies_add_product(d, n, H, H, block);
  }
}

void dlsi_bodies_diagonal(const dls_contact *problem, int c, double *block) {
#define SQUARE(d, n) bodies_square(d, n, problem, c, block)
  BY_SIZE(SQUARE);
}

/* ---- W by blocks ----------------------------------------------------------------------------- */

void *dlsi_make_room(void *held, size_t *room, size_t count, size_t size) {
  if (held && *room >= count) return held;
  void *larger = dlsi_alloc(count, size);
  if (!larger) return NULL;
  free(held);
  *room = count;
  return larger;
}

/* Lists the places of each body among body[], ascending: those of body b are list[first[b]] ..
 * list[first[b+1]-1]. */
static dls_status bodies_list(dlsi_formed *formed, const dls_contact *problem, dls_error *error) {
  const dls_bodies *B = &problem->bodies;
  const size_t places = 2 * (size_t)problem->nc, bodies = (size_t)B->count;
  int *first = dlsi_make_room(formed->list, &formed->list_room, bodies + 1 + places, sizeof *first);
  if (!first) return dlsi_no_memory(error);
  int *list = first + bodies + 1;
  formed->list = first;
  memset(first, 0, (bodies + 1) * sizeof *first);
  for (size_t k = 0; k < places; k++)
    if (B->body[k] >= 0) first[B->body[k] + 1]++;
  for (size_t b = 0; b < bodies; b++)
    first[b + 1] += first[b];
  for (size_t k = 0; k < places; k++)
    if (B->body[k] >= 0) list[first[B->body[k]]++] = (int)k;
  for (size_t b = bodies; b > 0; b--)
    first[b] = first[b - 1];
  first[0] = 0;
  return DLS_OK;
}

/* The blocks of one column in the order of their rows: the contacts of both bodies merged. */
typedef struct bodies_column {
  const int *next[2], *end[2]; /* among body[], of each body */
  size_t own[2];               /* the places of the contact itself */
} bodies_column;

static bodies_column bodies_begin(const dlsi_formed *formed, const dls_contact *problem, int c) {
  const int *first = formed->list, *list = first + problem->bodies.count + 1;
  bodies_column column = {.next = {NULL, NULL}};
  for (size_t side = 0; side < 2; side++) {
    const int b = problem->bodies.body[2 * (size_t)c + side];
    column.own[side] = 2 * (size_t)c + side;
    if (b < 0) continue;
    column.next[side] = list + first[b];
    column.end[side] = list + first[b + 1];
  }
  return column;
}

/* Returns the row of the next block, -1 after the last one; block: receives it, NULL for none. */
static int bodies_next(const dls_contact *problem, bodies_column *column, double *block) {
  const size_t d = (size_t)problem->d, size = bodies_size(problem);
  int row = INT_MAX;
  for (int side = 0; side < 2; side++)
    if (column->next[side] < column->end[side] && *column->next[side] / 2 < row)
      row = *column->next[side] / 2;
  if (row == INT_MAX) return -1;
  for (size_t e = 0; block && e < d * d; e++)
    block[e] = 0;
  for (int side = 0; side < 2; side++)
    if (column->next[side] < column->end[side] && *column->next[side] / 2 == row) {
      const size_t other = (size_t)*column->next[side]++;
      if (block)
        bodies_add_product(d, (size_t)problem->bodies.n, problem->bodies.H + other * size,
                           problem->bodies.H + column->own[side] * size, block);
    }
  return row;
}

static dls_status bodies_count(const dlsi_formed *formed, const dls_contact *problem, int *count,
                               dls_error *error) {
  size_t found = 0, least = 0; /* blocks: a body couples all of its contacts */
  for (int b = 0; b < problem->bodies.count; b++) {
    const size_t of = (size_t)(formed->list[b + 1] - formed->list[b]);
    if (of * of > least) least = of * of;
  }
  for (int c = 0; least <= INT_MAX && found <= INT_MAX && c < problem->nc; c++) {
    bodies_column column = bodies_begin(formed, problem, c);
    while (bodies_next(problem, &column, NULL) >= 0)
      found++;
  }
  if (least > found) found = least;
  if (found > INT_MAX)
    return dlsi_fail(error, DLS_E_SIZE, "bodies", -1, (double)found, "leave W too many blocks");
  *count = (int)found;
  return DLS_OK;
}

static void bodies_fill(const dlsi_formed *formed, const dls_contact *problem, int *p, int *i,
                        double *x) {
  const size_t entries = (size_t)problem->d * (size_t)problem->d;
  int k = 0;
  for (int c = 0; c < problem->nc; c++) {
    bodies_column column = bodies_begin(formed, problem, c);
    p[c] = k;
    for (int row; (row = bodies_next(problem, &column, x + entries * (size_t)k)) >= 0; k++)
      i[k] = row;
  }
  p[problem->nc] = k;
}

dls_status dlsi_lend(dlsi_formed *formed, const dls_contact **problem, dls_error *error) {
  const dls_bodies *B = &(*problem)->bodies;
  if (!B->H || B->work) return DLS_OK;
  double *work = dlsi_make_room(formed->work, &formed->work_room,
                                2 * (size_t)B->n * (size_t)B->count, sizeof *work);
  if (!work) return dlsi_no_memory(error);
  formed->work = work;
  formed->problem = **problem;
  formed->problem.bodies.work = work;
  *problem = &formed->problem;
  return DLS_OK;
}

/* Makes room for W by so many blocks. */
static dls_status bodies_reserve(dlsi_formed *formed, size_t entries, size_t nc, size_t blocks,
                                 dls_error *error) {
  int *p = dlsi_make_room(formed->p, &formed->p_room, nc + 1, sizeof *p);
  if (!p) return dlsi_no_memory(error);
  formed->p = p;
  int *i = dlsi_make_room(formed->i, &formed->i_room, blocks, sizeof *i);
  if (!i) return dlsi_no_memory(error);
  formed->i = i;
  double *x = dlsi_make_room(formed->x, &formed->x_room, blocks, entries * sizeof *x);
  if (!x) return dlsi_no_memory(error);
  formed->x = x;
  return DLS_OK;
}

dls_status dlsi_form_blocks(dlsi_formed *formed, const dls_contact **problem, dls_error *error) {
  if (!*problem || !dlsi_is_factored(*problem)) return DLS_OK;
  const int lent = (*problem)->bodies.work != NULL; /* a copy of the library's own */
  dls_status status = lent ? DLS_OK : dlsi_check_contact(*problem, error);
  if (status || (*problem)->nc == 0) return status;
  const dls_contact *given = *problem;
  int count = 0;
  status = bodies_list(formed, given, error);
  if (!status) status = bodies_count(formed, given, &count, error);
  if (!status)
    status = bodies_reserve(formed, (size_t)given->d * (size_t)given->d, (size_t)given->nc,
                            (size_t)count, error);
  if (!status) status = dlsi_lend(formed, problem, error);
  if (status) return status;
  if (*problem == given) formed->problem = *given; /* its scratch was lent before */
  bodies_fill(formed, given, formed->p, formed->i, formed->x);
  formed->problem.Wb = (dls_blocks){given->d, given->nc, formed->p, formed->i, formed->x};
  *problem = &formed->problem;
  return DLS_OK;
}

void dlsi_formed_free(dlsi_formed *formed) {
  free(formed->work);
  free(formed->x);
  free(formed->p);
  free(formed->i);
  free(formed->list);
  *formed = (dlsi_formed){.work = NULL};
}

/* Checks that the problem is one of bodies. */
static dls_status bodies_check(const dls_contact *problem, dls_error *error) {
  const dls_status status = dlsi_check_contact(problem, error);
  if (status || problem->nc == 0 || problem->bodies.H) return status;
  return dlsi_fail(error, DLS_E_ARGUMENT, "bodies.H", -1, 0, "is NULL");
}

dls_status dls_bodies_count(const dls_contact *problem, int *count, dls_error *error) {
  DLSI_DOOR;
  dlsi_formed lists = {.work = NULL};
  dls_status status = bodies_check(problem, error);
  if (!status && !count) status = dlsi_is_null(error, "count");
  if (!status && problem->nc == 0)
    *count = 0;
  else if (!status) {
    status = bodies_list(&lists, problem, error);
    if (!status) status = bodies_count(&lists, problem, count, error);
  }
  dlsi_formed_free(&lists);
  return dlsi_at(__func__, status, error);
}

static dls_status blocks_from_bodies(dlsi_formed *formed, const dls_contact *problem, int *p,
                                     int *i, double *x, dls_blocks *B, dls_error *error) {
  dls_status status = bodies_check(problem, error);
  if (!status && !p) status = dlsi_is_null(error, "p");
  if (!status && !i) status = dlsi_is_null(error, "i");
  if (!status && !x) status = dlsi_is_null(error, "x");
  if (!status && !B) status = dlsi_is_null(error, "B");
  if (!status) status = dlsi_form_blocks(formed, &problem, error);
  if (status) return status;
  const size_t entries = (size_t)problem->d * (size_t)problem->d;
  const size_t blocks = problem->nc ? (size_t)problem->Wb.p[problem->nc] : 0;
  p[0] = 0;
  if (problem->nc) {
    memcpy(p, problem->Wb.p, ((size_t)problem->nc + 1) * sizeof *p);
    memcpy(i, problem->Wb.i, blocks * sizeof *i);
    memcpy(x, problem->Wb.x, entries * blocks * sizeof *x);
  }
  *B = (dls_blocks){problem->d, problem->nc, p, i, x};
  return DLS_OK;
}

dls_status dls_blocks_from_bodies(const dls_contact *problem, int *p, int *i, double *x,
                                  dls_blocks *B, dls_error *error) {
  DLSI_DOOR;
  dlsi_formed formed = {.work = NULL};
  const dls_status status = blocks_from_bodies(&formed, problem, p, i, x, B, error);
  dlsi_formed_free(&formed);
  return dlsi_at(__func__, status, error);
}
