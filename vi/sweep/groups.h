/* groups.h: contacts in groups of eight that share nothing, one in each lane (groups.c). */
#ifndef DLSI_GROUPS_H
#define DLSI_GROUPS_H

#include <stdint.h>

#include "vi/vi_internal.h"

enum { dlsi_group_size = 8 };

/* Off-diagonal blocks of W, by rows. */
typedef struct dlsi_rows {
  const int *row, *column, *place; /* nc + 1 starts; of each block its column, its place in Wb.x */
} dlsi_rows;

/* Groups in the order of their visits. Group g has the lanes 8 g .. 8 g + 7. An empty lane has a
 * dummy problem with the answer 0. The eight numbers of a kind are adjacent. */
typedef struct dlsi_groups {
  int d, n;           /* n: motions of a body; 0: W by blocks */
  int width;          /* lanes in a register; 0: as many as the processor has */
  int count;          /* groups; 0: none, sweeps go one by one */
  int tasks, stages;  /* tasks of one stage share nothing: they may be done at the same time */
  int *task, *stage;  /* tasks + 1 first groups; stages + 1 first tasks */
  int *changed;       /* tasks: 1: the last sweep has changed some r */
  int *member;        /* 8 count: contacts; -1: an empty lane */
  int *at;            /* bodies: 16 count: where their motions begin in v; -1: fixed */
  int *row, *column;  /* blocks: count + 1 first blocks of the groups; 8 contacts of each */
  unsigned char *odd; /* count: bit l: local.c solves lane l */
  double *x;          /* bodies: H, 2 n d times 8 a group; blocks: d d times 8 each, without W_cc */
  double *own;        /* d d + d + 2 times 8 a group: W_cc, q, mu, l of the last slip */
  dlsi_rows rows;     /* of all of W */
  int *ints, *kept, *scratch; /* memory: of the arrays, of the structure and the rows, of the fit */
  double *doubles;
  uint64_t *held;
  size_t ints_room, kept_room, scratch_room, doubles_room, held_room, kept_size;
} dlsi_groups;

/* Groups the contacts of a set, slab by slab, for a problem by blocks or of bodies; count := 0 if
 * groups do not pay. whole: groups of all contacts of this problem, whose rows are used. NULL: this
 * set has all, and if W has the structure of the last call, what follows from that alone is kept.
 * DLS_E_MEMORY. */
dls_status dlsi_groups_set(dlsi_groups *groups, const dls_contact *problem, dlsi_set set,
                           const dlsi_groups *whole, dls_error *error);

/* Returns 1 if the last call of dlsi_groups_set was for this structure of W. */
int dlsi_groups_are_of(const dlsi_groups *groups, const dls_contact *problem);
void dlsi_groups_free(dlsi_groups *groups);

/* Sweeps once over all groups: updates r and, of bodies, v = H r. Returns 0 if nothing changed. */
int dlsi_groups_sweep(const dlsi_groups *groups, dlsi_team *team, double *r, double *v);

/* u_c := W r + q for the contacts c of all groups, of bodies from v. */
void dlsi_groups_look(const dlsi_groups *groups, dlsi_team *team, const double *r, double *v,
                      double *u);

/* (NL2) Solves one lane by local.c. p: p, then the solution. own: its group's, from the lane on. */
void dlsi_groups_solve_one(int d, const double *own, double *p);

#endif
