/*
 * groups.c: puts contacts into groups of eight that share nothing, for sweeps in lanes.
 *
 *   (GR1)  slab by slab (slabs.c), in the order of the visits, each contact joins the oldest open
 *          group without a neighbour: a contact on one of its bodies, or coupled by a block of W.
 *          By blocks also of its kind: the number of blocks in its row, halved and rounded down
 *   (GR2)  a group is closed when it has eight, or when 64 younger ones have been opened
 *
 * Thus nearly all groups are full, and contacts stay within 64 groups of their place in the order.
 * The data of a sweep are stored by groups: H of bodies, or the rows of W by blocks, padded with
 * zeros to the longest of the group. All follows from the problem alone, and so do the bits.
 *
 * Cost: a few sweeps, half of them if W has the structure of the last solve. What can fail: memory.
 * If most contacts touch one body, groups would hold one contact each: then none are made.
 */
#include "groups.h"

#include <float.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

enum { size = dlsi_group_size, most_open = 64, most_kinds = 16, line = 64 };
enum { least_filled = 2 }; /* lanes of a group, on average: below, one by one is as fast */

/* ---- who joins which group ------------------------------------------------------------------- */

typedef struct groups_fit {
  const dls_contact *problem;
  const dlsi_rows *rows; /* NULL: of bodies */
  uint64_t *held;        /* of bodies: the open groups with each body */
  int *group;            /* by blocks: group of each contact, -1: none */
  int *member;           /* of all groups */
  int oldest, end;       /* groups that may be open */
  uint64_t open;         /* bit g % most_open */
  uint64_t like[most_kinds];
  int filled[most_open];
} groups_fit;

static uint64_t fit_bit(int g) {
  return (uint64_t)1 << g % most_open;
}

/* Returns the open groups with a neighbour of c. */
static uint64_t fit_busy(const groups_fit *f, int c) {
  const dls_blocks *B = &f->problem->Wb;
  uint64_t busy = 0;
  if (!f->rows) {
    const int *body = f->problem->bodies.body + 2 * (size_t)c;
    return (body[0] >= 0 ? f->held[body[0]] : 0) | (body[1] >= 0 ? f->held[body[1]] : 0);
  }
  for (int k = B->p[c]; k < B->p[c + 1]; k++)
    if (f->group[B->i[k]] >= f->oldest) busy |= fit_bit(f->group[B->i[k]]);
  for (int k = f->rows->row[c]; k < f->rows->row[c + 1]; k++)
    if (f->group[f->rows->column[k]] >= f->oldest) busy |= fit_bit(f->group[f->rows->column[k]]);
  return busy;
}

/* Enters contact c in group g, or removes it. */
static void fit_mark(const groups_fit *f, int c, int g, int in) {
  if (f->rows) {
    f->group[c] = in ? g : -1;
    return;
  }
  for (int side = 0; side < 2; side++) {
    const int b = f->problem->bodies.body[2 * (size_t)c + (size_t)side];
    if (b >= 0) f->held[b] = in ? f->held[b] | fit_bit(g) : f->held[b] & ~fit_bit(g);
  }
}

static void fit_close(groups_fit *f, int g) {
  if (!(f->open & fit_bit(g))) return;
  f->open &= ~fit_bit(g);
  for (int l = 0; l < f->filled[g % most_open]; l++)
    fit_mark(f, f->member[size * (size_t)g + (size_t)l], g, 0);
}

/* Opens a group of this kind. */
static int fit_open(groups_fit *f, int kind) {
  const int g = f->end++;
  if (g - f->oldest == most_open) fit_close(f, f->oldest++); /* (GR2) */
  for (int l = 0; l < size; l++)
    f->member[size * (size_t)g + (size_t)l] = -1;
  for (int k = 0; k < most_kinds; k++)
    f->like[k] &= ~fit_bit(g);
  f->like[kind] |= fit_bit(g);
  f->filled[g % most_open] = 0;
  f->open |= fit_bit(g);
  return g;
}

/* Returns the oldest group of a set that is not empty. */
static int fit_oldest(const groups_fit *f, uint64_t set) {
  int g = f->oldest;
  while (!(set & fit_bit(g)))
    g++;
  return g;
}

/* (GR1) for one contact. */
static void fit_add(groups_fit *f, int c) {
  const int length = f->rows ? (f->rows->row[c + 1] - f->rows->row[c]) / 2 : 0;
  const int kind = length < most_kinds ? length : most_kinds - 1;
  const uint64_t may = f->open & f->like[kind] & ~fit_busy(f, c);
  const int g = may ? fit_oldest(f, may) : fit_open(f, kind);
  f->member[size * (size_t)g + (size_t)f->filled[g % most_open]++] = c;
  fit_mark(f, c, g, 1);
  if (f->filled[g % most_open] == size) fit_close(f, g);
}

/* Fits slab s and closes its groups. */
static void fit_slab(groups_fit *f, const dlsi_set *set, int s) {
  const int first = set->slabs ? set->start[s] : 0;
  const int end = set->slabs ? set->start[s + 1] : set->count;
  for (int k = first; k < end; k++)
    fit_add(f, set->list ? set->list[k] : k);
  for (; f->oldest < f->end; f->oldest++)
    fit_close(f, f->oldest);
}

/* ---- what follows from the structure of W ---------------------------------------------------- */

/* Lists the off-diagonal blocks of each row of W. */
static void groups_transpose(const dls_blocks *B, int *row, int *column, int *place) {
  memset(row, 0, ((size_t)B->n + 1) * sizeof *row);
  for (int c = 0; c < B->n; c++)
    for (int k = B->p[c]; k < B->p[c + 1]; k++)
      if (B->i[k] != c) row[B->i[k] + 1]++;
  for (int c = 0; c < B->n; c++)
    row[c + 1] += row[c];
  for (int c = 0; c < B->n; c++)
    for (int k = B->p[c]; k < B->p[c + 1]; k++) {
      if (B->i[k] == c) continue;
      const int at = row[B->i[k]]++;
      column[at] = c;
      place[at] = k;
    }
  for (int c = B->n; c > 0; c--)
    row[c] = row[c - 1];
  row[0] = 0;
}

/* The structure of W: the bodies, or the starts of the columns and the rows of their blocks. */
typedef struct groups_structure {
  const int *of[2];
  size_t length[2];
  int n; /* motions; 0: by blocks */
} groups_structure;

static groups_structure groups_structure_of(const dls_contact *problem) {
  const size_t nc = (size_t)problem->nc;
  const dls_blocks *B = &problem->Wb;
  if (dlsi_is_factored(problem))
    return (groups_structure){{problem->bodies.body, NULL}, {2 * nc, 0}, problem->bodies.n};
  return (groups_structure){{B->p, B->i}, {nc + 1, (size_t)B->p[nc]}, 0};
}

int dlsi_groups_are_of(const dlsi_groups *groups, const dls_contact *problem) {
  const groups_structure s = groups_structure_of(problem);
  const int *kept = groups->kept;
  if (groups->kept_size != s.length[0] + s.length[1] || groups->d != problem->d || groups->n != s.n)
    return 0;
  return memcmp(kept, s.of[0], s.length[0] * sizeof *kept) == 0 &&
         (s.n || memcmp(kept + s.length[0], s.of[1], s.length[1] * sizeof *kept) == 0);
}

/* Stores the structure and its rows. DLS_E_MEMORY. */
static dls_status groups_keep(dlsi_groups *groups, const dls_contact *problem, dls_error *error) {
  const groups_structure s = groups_structure_of(problem);
  const size_t all = s.length[0] + s.length[1];
  const size_t rows = s.n ? 0 : s.length[0] + 2 * s.length[1];
  groups->kept_size = 0;
  int *kept = dlsi_make_room(groups->kept, &groups->kept_room, all + rows, sizeof *kept);
  if (!kept) return dlsi_no_memory(error);
  groups->kept = kept;
  groups->kept_size = all;
  memcpy(kept, s.of[0], s.length[0] * sizeof *kept);
  if (s.n) return DLS_OK;
  memcpy(kept + s.length[0], s.of[1], s.length[1] * sizeof *kept);
  int *row = kept + all, *column = row + s.length[0], *place = column + s.length[1];
  groups_transpose(&problem->Wb, row, column, place);
  groups->rows = (dlsi_rows){row, column, place};
  return DLS_OK;
}

/* Returns the length of the longest row of a group. */
static int groups_longest(const dlsi_rows *rows, const int *member) {
  int longest = 0;
  for (int l = 0; l < size; l++) {
    const int c = member[l], length = c < 0 ? 0 : rows->row[c + 1] - rows->row[c];
    if (length > longest) longest = length;
  }
  return longest;
}

/* Puts the contacts into groups. tasks: the slabs, even ones first. DLS_E_MEMORY. */
static dls_status groups_fit_set(dlsi_groups *groups, groups_fit *f, const dlsi_set *set,
                                 dls_error *error) {
  const size_t nc = (size_t)f->problem->nc, bodies = (size_t)f->problem->bodies.count;
  const int slabs = set->slabs ? set->slabs : 1;
  const size_t lanes = size * (size_t)set->count, more = f->rows ? nc : 0;
  int *scratch = dlsi_make_room(groups->scratch, &groups->scratch_room,
                                (size_t)slabs + 1 + lanes + more, sizeof *scratch);
  if (!scratch) return dlsi_no_memory(error);
  groups->scratch = scratch;
  if (!f->rows) {
    uint64_t *held = dlsi_make_room(groups->held, &groups->held_room, bodies + 1, sizeof *held);
    if (!held) return dlsi_no_memory(error);
    groups->held = f->held = held;
    memset(held, 0, (bodies + 1) * sizeof *held);
  }
  f->member = scratch + slabs + 1;
  f->group = f->member + lanes;
  for (size_t c = 0; c < more; c++)
    f->group[c] = -1;
  groups->tasks = 0;
  for (int parity = 0; parity < 2; parity++)
    for (int s = parity; s < slabs; s += 2) {
      scratch[groups->tasks++] = f->end;
      fit_slab(f, set, s);
    }
  scratch[groups->tasks] = f->end;
  groups->stages = slabs > 1 ? 2 : 1;
  groups->count = set->count < least_filled * f->end && f->end > 1 ? 0 : f->end;
  return DLS_OK;
}

/* Returns x rounded up to a cache line. */
static double *groups_align(double *x) {
  const uintptr_t past = (uintptr_t)(void *)x % line;
  return past ? x + (line - past) / sizeof *x : x;
}

/* Makes room for `count` groups and copies the result of the fit to it. DLS_E_MEMORY. */
static dls_status groups_take(dlsi_groups *groups, const groups_fit *f, dls_error *error) {
  const size_t count = (size_t)groups->count, tasks = (size_t)groups->tasks;
  const size_t d = (size_t)groups->d, own = d * d + d + 2;
  size_t blocks = 0;
  for (size_t g = 0; f->rows && g < count; g++)
    blocks += (size_t)groups_longest(f->rows, f->member + size * g);
  if (blocks > INT_MAX / size) groups->count = 0; /* int would overflow */
  if (!groups->count) return DLS_OK;
  const size_t x = f->rows ? d * d * blocks : 2 * d * (size_t)groups->n * count;
  const size_t bodies = f->rows ? 0 : 2 * size * count, of_rows = f->rows ? count + 1 : 0;
  groups->count = 0;
  int *ints = dlsi_make_room(groups->ints, &groups->ints_room,
                             2 * tasks + 4 + size * count + bodies + of_rows + size * blocks +
                                 count / sizeof(int) + 1,
                             sizeof *ints);
  if (!ints) return dlsi_no_memory(error);
  groups->ints = ints;
  double *doubles =
      dlsi_make_room(groups->doubles, &groups->doubles_room,
                     size * (x + own * count) + line / sizeof(double), sizeof *doubles);
  if (!doubles) return dlsi_no_memory(error);
  groups->doubles = doubles;
  groups->count = (int)count;
  groups->x = groups_align(doubles);
  groups->own = groups->x + size * x;
  groups->task = ints;
  groups->stage = groups->task + tasks + 1;
  groups->changed = groups->stage + 3;
  groups->member = groups->changed + tasks;
  groups->at = groups->member + size * count;
  groups->row = groups->at + bodies;
  groups->column = groups->row + of_rows;
  groups->odd = (unsigned char *)(groups->column + size * blocks);
  memcpy(groups->task, groups->scratch, (tasks + 1) * sizeof *ints);
  memcpy(groups->member, f->member, size * count * sizeof *ints);
  groups->stage[0] = 0;
  groups->stage[1] = (groups->tasks + 1) / 2;
  groups->stage[groups->stages] = groups->tasks;
  if (f->rows) groups->row[0] = 0;
  for (size_t g = 0; f->rows && g < count; g++)
    groups->row[g + 1] = groups->row[g] + groups_longest(f->rows, f->member + size * g);
  return DLS_OK;
}

/* ---- numbers --------------------------------------------------------------------------------- */

/* Returns 1 if the kernels serve a block: W_nn > 0, S positive definite, finite friction. */
static int groups_is_plain(int d, const double *W, double mu) {
  if (!(W[0] > 0 && W[0] <= DBL_MAX && mu <= DBL_MAX)) return 0;
  if (d == 1) return 1;
  const double c = W[1] / W[0];
  if (d == 2) return W[3] - c * W[2] > DBL_EPSILON * W[3];
  const double e = W[2] / W[0];
  const double S[4] = {W[4] - c * W[3], W[5] - e * W[3], W[7] - c * W[6], W[8] - e * W[6]};
  const double trace = S[0] + S[3], det = S[0] * S[3] - S[1] * S[2];
  return S[0] > 0 && trace <= DBL_MAX && det > 1e-10 * trace * trace;
}

/* Fills W_cc, q, mu of all lanes; no lane has slipped yet. */
static void groups_fill_own(const dlsi_groups *groups, const dls_contact *problem) {
  const int d = groups->d;
  for (int g = 0; g < groups->count; g++) {
    double *own = groups->own + size * (size_t)(d * d + d + 2) * (size_t)g;
    groups->odd[g] = 0;
    for (int l = 0; l < size; l++) {
      const int c = groups->member[size * g + l];
      double W[9] = {0}, *to = own + l;
      for (int i = 0; i < d; i++)
        W[i + d * i] = 1;
      if (c >= 0) dlsi_contact_diagonal(problem, c, W);
      const double mu = c < 0 ? 0 : problem->mu[c];
      if (c >= 0 && !groups_is_plain(d, W, mu)) groups->odd[g] |= (unsigned char)(1 << l);
      for (int e = 0; e < d * d; e++, to += size)
        *to = W[e];
      for (int i = 0; i < d; i++, to += size)
        *to = c < 0 ? 1 : problem->q[(size_t)d * (size_t)c + (size_t)i];
      to[0] = mu;
      to[size] = 0;
    }
  }
}

/* x (entries times 8) := the entries of eight arrays; zeros for NULL. */
static void groups_weave(size_t entries, const double *const from[size], double *x) {
  static const double none[18] = {0};
  const double *p[size];
  for (int l = 0; l < size; l++)
    p[l] = from[l] ? from[l] : none;
  for (size_t e = 0; e < entries; e++)
    for (int l = 0; l < size; l++)
      *x++ = p[l][e];
}

static void groups_fill_bodies(const dlsi_groups *groups, const dls_contact *problem) {
  const size_t entries = (size_t)groups->d * (size_t)groups->n;
  for (size_t g = 0; g < (size_t)groups->count; g++)
    for (size_t side = 0; side < 2; side++) {
      const double *H[size] = {NULL};
      for (size_t l = 0; l < size; l++) {
        const int c = groups->member[size * g + l];
        const size_t at = 2 * (size_t)c + side;
        const int b = c < 0 ? -1 : problem->bodies.body[at];
        if (b >= 0) H[l] = problem->bodies.H + at * entries;
        groups->at[2 * size * g + size * side + l] = b < 0 ? -1 : groups->n * b;
      }
      groups_weave(entries, H, groups->x + size * entries * (2 * g + side));
    }
}

/* Pads a short row with zero blocks times r of the contact itself. */
static void groups_fill_blocks(const dlsi_groups *groups, const dls_contact *problem,
                               const dlsi_rows *rows) {
  const size_t entries = (size_t)groups->d * (size_t)groups->d;
  for (size_t g = 0; g < (size_t)groups->count; g++)
    for (int k = groups->row[g]; k < groups->row[g + 1]; k++) {
      const double *W[size] = {NULL};
      const int j = k - groups->row[g], *member = groups->member + size * g;
      for (size_t l = 0; l < size; l++) {
        const int c = member[l] < 0 ? member[0] : member[l];
        const int has = member[l] >= 0 && j < rows->row[c + 1] - rows->row[c];
        if (has) W[l] = problem->Wb.x + entries * (size_t)rows->place[rows->row[c] + j];
        groups->column[size * (size_t)k + l] = has ? rows->column[rows->row[c] + j] : c;
      }
      groups_weave(entries, W, groups->x + size * entries * (size_t)k);
    }
}

/* ---- groups ---------------------------------------------------------------------------------- */

void dlsi_groups_free(dlsi_groups *groups) {
  free(groups->ints);
  free(groups->kept);
  free(groups->scratch);
  free(groups->doubles);
  free(groups->held);
  *groups = (dlsi_groups){.count = 0};
}

dls_status dlsi_groups_set(dlsi_groups *groups, const dls_contact *problem, dlsi_set set,
                           const dlsi_groups *whole, dls_error *error) {
  const int blocks = !dlsi_is_factored(problem),
            same = !whole && dlsi_groups_are_of(groups, problem);
  const dlsi_rows *rows = !blocks ? NULL : whole ? &whole->rows : &groups->rows;
  dls_status status = whole || same ? DLS_OK : groups_keep(groups, problem, error);
  if (!status && !same) {
    groups_fit f = {.problem = problem, .rows = rows};
    groups->d = problem->d;
    groups->n = blocks ? 0 : problem->bodies.n;
    groups->count = 0;
    status = groups_fit_set(groups, &f, &set, error);
    if (!status) status = groups_take(groups, &f, error);
    if (status) groups->kept_size = 0;
  }
  if (status || !groups->count) return status;
  groups_fill_own(groups, problem);
  if (blocks)
    groups_fill_blocks(groups, problem, rows);
  else
    groups_fill_bodies(groups, problem);
  return DLS_OK;
}
