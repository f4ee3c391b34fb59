/* nlgs_work.h: the workspace of Gauss-Seidel, and what its files (nlgs.c lists them) share. */
#ifndef DLSI_NLGS_WORK_H
#define DLSI_NLGS_WORK_H

#include <string.h>

#include "groups.h"

enum { dlsi_few_candidates = 1000 }; /* beyond: several variants, threads, few estimates */

/* Arrays of momentum for a problem of bodies; memory is kept for the next problem. */
typedef struct dlsi_nlgs_bodies {
  double *moved; /* u and pu of momentum, then u and DU of the history: n count each column */
  int *some;     /* bodies of (NL9), then a mark for each: 2 count */
  size_t moved_room, some_room;
} dlsi_nlgs_bodies;

/* (NL14): momentum as it was when a stage of auto ended, or when another variant began */
typedef struct dlsi_nlgs_left {
  double *r;       /* m: that sweep's own r, not the best one */
  double residual; /* the best one until then; 0: nothing is left */
  double accepted; /* of (NL7) */
  int sweeps, changed;
} dlsi_nlgs_left;

/* (NL12) */
typedef enum dlsi_nlgs_way { DLSI_WAY_FREE, DLSI_WAY_HELD, DLSI_WAY_ANDERSON } dlsi_nlgs_way;

struct dls_nlgs {
  dls_nlgs_settings settings;
  int d, nc;
  int stage;               /* of auto: from the given r, in an order of its own, no ambiguous */
  int *own_order;          /* of a stage: nc; else NULL */
  int *scratch;            /* of a stage: nc; else NULL */
  const int *order;        /* of the visits in this run: nc; NULL: 0, 1, .. */
  double *carved[4];       /* u, pu of momentum; u, DU of the history: if not of bodies */
  double *block_1d;        /* W_cc (+ E_c): nc; for d = 1, else NULL */
  dlsi_block_2d *block_2d; /* the same for d = 2 */
  dlsi_block_3d *block_3d; /* the same for d = 3 */
  dlsi_iterate it;         /* its u is kept up to date by the sweeps */
  dlsi_formed formed;      /* of a problem of bodies: scratch, W by blocks */
  int motions;             /* of a body; 0 if u is kept up to date */
  double *v;               /* H r of bodies, kept up to date by the sweeps in place of u */
  dlsi_nlgs_bodies bodies;
  int *visits, *earlier; /* nc: the order of the visits that dls_solver_map keeps; scratch */
  int knows, narrow, acting_count; /* (NL13): may be used; is used; contacts in acting */
  int *acts, *acting;              /* nc: 1: it acts; those that do, in the order of the visits */
  dlsi_groups active;              /* of them */
  int visited;                     /* contacts of that order; 0: as they are numbered */
  int whole;                /* groups has all of this problem; (NL13) goes without at first */
  int grouped;              /* 1: sweeps go over groups; u is not kept up to date then */
  dlsi_groups groups, part; /* all contacts; a set of (NL9) */
  dlsi_slabs slabs;         /* the order of the groups */
  dlsi_team *team;          /* of this run; NULL: one thread */
  double *x;                /* r that the sweep started from, if accelerated: m */
  dlsi_anderson history;
  double residual_then; /* (NL7): residual when the returns were last 0 ... */
  int returns, plain;   /* ... returns since; plain sweeps to come */
  dlsi_momentum momentum;
  int *near; /* of momentum: nc, layer of (NL9) of each contact, from 1 on; 0: not in a set */
  int *some, *rows; /* of momentum: nc, the sets of (NL9) */
  double largest;   /* largest b (NL10) */
  double halved;    /* (NL10): the residual at the last halving ... */
  double since;     /* ... and the sweeps until then, those on a set count by its share */
  double looked;    /* the residual when (NL9) was due last */
  int pause, wait;  /* (NL9): looks skipped after a set that was too large; those to come */
  double sweeps;
  dlsi_turns turns; /* (NL12) */
  dlsi_nlgs_left left;
  dlsi_nlgs_way way[dlsi_most_ways], now;
};

/* Returns 1 for (NL6). */
static inline int dlsi_nlgs_has_history(const dls_nlgs_settings *s) {
  return s->acceleration == DLS_ACCELERATION_AITKEN || s->acceleration == DLS_ACCELERATION_ANDERSON;
}

/* Returns 1 if (NL6) is one of the variants of (NL12). */
static inline int dlsi_nlgs_may_turn(const dls_nlgs *work) {
  const int pushed = work->settings.acceleration == DLS_ACCELERATION_MOMENTUM;
  return work->stage && pushed && (work->d == 2 || work->nc > dlsi_few_candidates);
}

/* All contacts; one by one, in the order of the visits. */
static inline dlsi_set dlsi_nlgs_all(const dls_nlgs *work, const dls_contact *problem) {
  if (work->narrow)
    return (dlsi_set){.list = work->acting, .count = work->acting_count, .groups = &work->active};
  return (dlsi_set){
      .list = work->order, .count = problem->nc, .groups = work->whole ? &work->groups : NULL};
}

/* The rows that sweeps over all contacts keep up to date: of u, of v, or, in groups by blocks,
 * none. */
static inline dlsi_set dlsi_nlgs_rows(const dls_nlgs *work, const dls_contact *problem) {
  if (work->motions) return (dlsi_set){.count = problem->bodies.count};
  return (dlsi_set){.count = work->grouped ? 0 : problem->nc};
}

/* Returns what the sweeps keep up to date: u, or v of bodies. */
static inline double *dlsi_nlgs_kept(const dls_nlgs *work) {
  return work->motions ? work->v : work->it.u;
}

/* Goes back to an earlier r and recomputes u. */
static inline void dlsi_nlgs_return(const dls_nlgs *work, const dls_contact *problem,
                                    const double *from, double *r) {
  memcpy(r, from, (size_t)problem->d * (size_t)problem->nc * sizeof *r);
  dlsi_multiply(problem, work->order, work->it.E, r, work->it.u, NULL);
}

/* ---- nlgs_sweep.c ---------------------------------------------------------------------------- */

/* Sweeps once over a set: updates r and what is kept with it. Returns 0 if no contact changed. */
int dlsi_nlgs_sweep(const dls_nlgs *work, const dls_contact *problem, dlsi_set set, double *r);

/* Projects every r_c on its cone, and updates u by columns or v of bodies. */
void dlsi_nlgs_repair(const dls_nlgs *work, const dls_contact *problem, double *r);

/* ---- nlgs_estimate.c ------------------------------------------------------------------------- */

/* Estimates the residuals of the certificate of r from the current u, of bodies from their motions:
 * it.u is computed from them. scale = 1 / |q|. everywhere: 0 to look at those that act alone
 * (NL13). */
void dlsi_nlgs_estimate(const dls_nlgs *work, const dls_contact *problem, const double *r,
                        double scale, int everywhere, dls_certificate *now);

/* ---- nlgs_sets.c ----------------------------------------------------------------------------- */

/* Sweeps where the residual is large, (NL9), unless it waits. u belongs to r. Returns 1 if r has
 * changed. */
int dlsi_nlgs_look_locally(dls_nlgs *work, const dls_contact *problem, double *r);

/* Lists the contacts with near up to `layer`, in the order of the visits; start: of the slabs, if
 * there are any, in the list. */
dlsi_set dlsi_nlgs_list(const dls_nlgs *work, const dls_contact *problem, int layer, int *list,
                        int *start);

/* ---- nlgs_active.c --------------------------------------------------------------------------- */

/* (NL13) at the start and after a look at all contacts: u of r is in it.u. */
void dlsi_nlgs_narrow(dls_nlgs *work, const dls_contact *problem, const double *r);

/* ---- nlgs_ways.c ----------------------------------------------------------------------------- */

/* Chooses the first variant and begins it at r, to which u (or v) belongs. */
void dlsi_nlgs_begin_ways(dls_nlgs *work, const dls_contact *problem, const double *r);

/* (NL14) Keeps the state after k sweeps, r that of the last one. Nothing without momentum. */
void dlsi_nlgs_leave(dls_nlgs *work, const dls_contact *problem, int k, int changed,
                     double accepted, const double *r);

/* (NL14) Goes back to that state, if the start is not far better than it: r, u (or v) are its own.
 * Returns the sweeps that it has taken; 0 to begin at the start. */
int dlsi_nlgs_resume(dls_nlgs *work, const dls_contact *problem, double *r);

/* r := the start of the next sweep by (NL6) or (NL7). r = g(x) has the estimated residual
 * `residual`, the g of the sweep before had *accepted; scale = 1 / |q|. */
void dlsi_nlgs_accelerate(dls_nlgs *work, const dls_contact *problem, double residual, double scale,
                          double *accepted, double *r);

/* r := the start of the next sweep k by (NL8), every 10 sweeps after local sweeps. Returns 0 if a
 * stage of auto has no smaller momentum left. */
int dlsi_nlgs_push(dls_nlgs *work, const dls_contact *problem, int k, double residual, double *r);

/* Changes the variant by (NL12), after `sweeps` sweeps, which gave r with this residual. Returns 1
 * if another one begins, from the best r if r is 10 % worse; 2 if one goes on (NL14). */
int dlsi_nlgs_change_way(dls_nlgs *work, const dls_contact *problem, double residual, int sweeps,
                         double *r);

#endif
