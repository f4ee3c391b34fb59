/* motion_internal.h: declares what the files of src/motion share. */
#ifndef DLSI_MOTION_H
#define DLSI_MOTION_H

#include "contact/columns.h"
#include "contact/contact.h"
#include "delassus/motion.h"
#include "delassus/reduction.h"

/* The state at the end of a step. */
typedef struct motion_point {
  double *x, *v, *kx;       /* n; kx = K x */
  double *p, *u;            /* m */
  double *gap;              /* candidates */
  double *slip;             /* (d-1) candidates */
  double *way;              /* d nodes: y, displacement of the obstacle since the start */
  dls_contact_state *state; /* candidates */
  int active, *list;        /* candidates; ascending, `active` of them */
  dls_motion_energies energies;
  double restitution; /* of the step */
} motion_point;

struct dls_motion {
  dls_motion_model model;
  dls_motion_settings settings;
  atomic_int busy;
  size_t n, nodes, candidates, m; /* m = d candidates */
  int on_K;                       /* 1: a path whose contact problem is solved on K, without W */
  dlsi_columns A;
  dls_reduction *reduction;
  dls_solver *solver;  /* NULL on K */
  dls_contact problem; /* of the last step */

  long long steps;
  double t, h_last; /* h_last: of the step that computed now.p */
  motion_point now, next;

  double *gap0;                         /* nodes */
  double *b, *z, *dx, *sum, *yn, *yabs; /* n: scratch; dx: solution of (MT6), (MT9) */
  double *ways;                         /* n: x+ - x on a path */
  double *local, *place;                /* d nodes: scratch */
  double *zero;                         /* max(d nodes, candidates): zeros for y and mu */
  double *uc, *mc;                      /* m: scratch, by contact */
  double *r, *w;                        /* m: of the active contacts, reactions and W r + q */
  double *weight;                       /* 2 candidates: weights of the active contacts */
  double *values;                       /* memory of W, q, mu of the active contacts; none on K */
  void *memory;                         /* of all arrays but A */
};

static inline dls_status dlsi_motion_enter(dls_motion *motion, dls_error *error) {
  return motion ? dlsi_enter(&motion->busy, "motion", error) : dlsi_is_null(error, "motion");
}

/* Returns 0 if the model has no such matrix. */
static inline int dlsi_motion_has(const dls_sparse *A) {
  return A->p != NULL;
}

/* y := A x and, if a is not NULL, a := |A||x|, n each; 0 for a model without A. Reads the lower
 * triangle of a symmetric A. */
void dlsi_motion_multiply(const dls_motion *motion, const dls_sparse *A, const double *x, double *y,
                          double *a);

/* local := L^T x, d nodes. */
void dlsi_motion_local(const dls_motion *motion, const double *x, double *local);

/* c := P^T local, m; without P a copy. */
void dlsi_motion_gather(const dls_motion *motion, const double *local, double *c);

/* y += H p and, if a is not NULL, a += |H||p|, n each. p: m. */
void dlsi_motion_push(const dls_motion *motion, const double *p, double *y, double *a);

/* Lays A = M + h theta C + h^2 theta^2 K out; entries of the same place are adjacent. On a path A =
 * K. The caller frees motion->A, also after an error. DLS_E_SIZE, DLS_E_MEMORY. */
dls_status dlsi_motion_lay(dls_motion *motion, dls_error *error);

/* Sets the values of A for the step h. */
void dlsi_motion_form(dls_motion *motion, double h);

/* Sets the gaps of the state x, way. Spoils local and mc. */
void dlsi_motion_measure_gap(dls_motion *motion, motion_point *point);

/* Copies a state. */
void dlsi_motion_keep(const dls_motion *motion, const motion_point *from, motion_point *to);

/* Sets point->kx and the energies of the state x, v; raises the scale. */
void dlsi_motion_weigh(dls_motion *motion, motion_point *point);

/* Adds the works of the step from now to next, and checks it: residual, momentum. f: n or NULL; y:
 * d nodes; dv: n, the change of v, or of x on a path. */
void dlsi_motion_account(dls_motion *motion, const double *f, const double *y, const double *dv);

/* Returns max_i |res_i| / max_i (sum of the absolute values of its terms)_i, res = M dv - h (f - C
 * v_th - K x_th) - H p, or K x+ - f - H r. Spoils b, z, sum, yn, yabs. */
double dlsi_motion_momentum(dls_motion *motion, const double *f, const double *dv);

#endif
