/*
 * problem.h: the problem that a command is asked for, and the scenes.
 */
#ifndef PROBLEM_H
#define PROBLEM_H

#include "console/console.h"
#include "delassus/forming.h"
#include "delassus/moving.h"

int command_scene(int argc, char **argv);
int command_forming(int argc, char **argv);
int command_moving(int argc, char **argv);

/* ---- input.c --------------------------------------------------------------------------------- */

/* Returns a name under which `path` can be opened any number of times: its own, or that of a copy
 * of a pipe or of standard input ("-"), which this reads to the end. */
const char *input_path(const char *path);

/* Removes the copies. */
void drop_inputs(void);

/* ---- problem.c ------------------------------------------------------------------------------- */

/* A problem in memory, and the owners of its parts. Start from {0}; free it after a failed load,
 * too. */
struct matrices;
struct source;
struct engine;
typedef struct problem {
  dls_fclib *file;           /* NULL for text */
  dls_text *text;            /* NULL for FCLIB */
  struct matrices *matrices; /* those of a host code (matrices.c), or NULL */
  dls_fe_scene *scene;       /* NULL: none */
  dls_moving *moving;
  double *own;              /* of a scene in steps */
  double *friction;         /* in place of that of a file or a scene, or NULL */
  dls_reduction *reduction; /* NULL for a local problem */
  dls_model model;          /* of a global one; n = 0: none */
  const double *f, *g, *mu;
  int of_bodies;               /* 1: a global one whose contact is one of bodies, not reduced */
  int on_K;                    /* contact has d, nc and mu, and no W; 2: an engine has it */
  int smooth;                  /* 1: H_T was not given: the tangents of contact are empty */
  const struct engine *engine; /* solves it; NULL: this process */
  dls_contact contact;
  double reduction_cpu_seconds;
  char name[96];  /* without directories and ending; with the step */
  char note[200]; /* what was chosen or changed to get it; "" */
} problem;

/* Loads the problem that a command is asked for: the matrices of `wanted`, or `name`, a file or a
 * scene. Prints the note. Returns 1; 0 after a complaint, or silently after Ctrl-C. */
int problem_open(const char *name, const struct source *wanted, problem *p);

/* Reads mu of `wanted` for the problem at hand and, with loads = 1, f and g (or q) for its
 * matrices. K stays factorised. 0 after a complaint. */
int problem_reload(const char *name, const struct source *wanted, int loads, problem *p);

/* Copies a name without directories and ending (named.c). */
void shorten(const char *name, char *text, size_t size);

/* named.c: the problem of a scene, of one step where it goes in steps. */
dls_status problem_of_scene(const char *name, const struct source *from, problem *p,
                            dls_error *error);

/* Other processes that solve a problem of a sparse K (src/mpi/main.c). */
typedef struct engine {
  /* Takes p->model and the loads; sets p->contact, p->on_K. p->reduction is on K. */
  dls_status (*take)(problem *p, dls_on on, dls_error *error);
  /* Solves as dls_reduction_solve. */
  dls_status (*solve)(problem *p, const dls_solver_settings *settings, double *r, double *u,
                      double *x, dls_info *info, dls_error *error);
  /* x := K^-1 (f + H r) */
  dls_status (*recover)(problem *p, const double *r, double *x, dls_error *error);
  const double *(*motion)(int *body); /* as dls_reduction_motion */
} engine;

/* place.c: reduces p->model to W with the loads f, g, or takes it on K if `from` is for `solve` and
 * allows it. */
dls_status problem_condense(problem *p, const struct source *from, dls_error *error);

/* Loads f and g into the reduction; sets p->contact and p->on_K. */
dls_status problem_take_load(problem *p, dls_error *error);

/* Works as dls_reduction_create, on W. */
dls_status reduce_to_W(dls_reduction **out, const dls_model *model, dls_error *error);

/* Keeps the BLAS of this process to one thread for a small problem: threads that wait for work of
 * some microseconds take more CPU than the work (docs/threads.md). The library leaves the BLAS of
 * its host alone and wakes no thread but through MUMPS and LAPACK's eigenvalues. */
void problem_fit_threads(const problem *p);
void problem_free(problem *p);

const char *problem_title(const problem *p);

/* matrices.c: tells the host's name of unknown k; returns 0 if it has none. NULL is fine. */
int problem_unknown(const problem *p, int k, int *node, int *direction);
/* Returns the host's number of the node of a contact; 0 if it has none. */
int problem_node(const problem *p, int c);

/* The place of an unknown: the host's node, its direction 0, 1, 2, its row of the coordinates (-1
 * without). */
typedef struct spot {
  int node, direction, row;
} spot;

/* Finds the place of unknown k; 0 if it has none. */
int unknown_place(const problem *p, int k, spot *at);

/* Returns 1 if unknowns are the directions of nodes, as far as can be told. */
int places_known(const problem *p);

/* Returns the coordinates, 3 a row, or NULL; *rows: how many; *contact: the contact of each row, -1
 * for none. */
const double *problem_coordinates(const problem *p, int *rows, const int **contact);
void matrices_free(struct matrices *matrices);

/* Returns what a file is that holds no problem but a matrix ("matrix", "table of numbers"); else
 * NULL. */
const char *other_kind(const char *path);

/* Returns 1 after a complaint if `path` is a file of another kind than a problem (a matrix). */
int is_no_problem(const char *path);

/* Returns 1 if the file is text with an LCP, read into *text; 0 for any other. */
int read_lcp_text(const char *path, dls_text **text);

/* Returns the parts of a reaction that a problem has: d, or 1 without tangents. */
int problem_parts(const problem *p);

/* Prints the name, the size and the kind of the problem. */
void problem_print(const char *path, const problem *p);

/* Prints what the reduction took, if there was one. */
void print_reduction(FILE *out, const problem *p);

/* ---- surface.c ------------------------------------------------------------------------------- */

/* Prints the sums of the reactions of the answer r, by body; 0 after a complaint. */
int put_reactions(FILE *file, const problem *p, const double *r);

/* Draws surface.* into a directory; returns 1 if there are coordinates and gnuplot. */
int picture_surface(const char *directory, const problem *p, const dls_contact_state *state,
                    const double *r);

/* Writes sums.csv and, with coordinates and x, answer.vtu and surface.*; 0 after a complaint. */
int write_surface(const char *directory, const problem *p, const dls_contact_state *state,
                  const double *r, const double *u, const double *x);

/* ---- scene.c --------------------------------------------------------------------------------- */

/* The tolerance of the scenes of one equilibrium, unless --tol says. */
extern const double scene_tol;

/* ---- jean.c ---------------------------------------------------------------------------------- */

/* The iteration that printed the tables of [Jean 1988], with its stopping rule, from r = 0. r: out,
 * 2 nc. Returns the sweeps done; -1 - sweeps where the rule does not hold after `most` of them or
 * Ctrl-C. */
int jean_sweeps(const dls_contact *problem, int weighted, int most, double *r);

/* w := P^-1 r, the weighted reactions equivalent to concentrated ones: of r the entries 2 c + i, of
 * P (tridiagonal but for a last row) the rows of the candidates. work: nc. */
void jean_unweight(const dls_sparse *P, const double *r, int i, double *work, double *w);

/* ---- moving.c -------------------------------------------------------------------------------- */

/* Shows the progress of a step on the terminal; returns non-zero after Ctrl-C. */
int show_moving_step(const dls_moving_data *data);

/* Draws energy.* and bar.*, map.*, loop.* in a directory that holds energy.csv and their data
 * (moving_picture.c); EXIT_SOLVED, or EXIT_BAD_INPUT after a complaint. */
int draw_moving(const char *directory, const dls_moving_data *data);

/* ---- forming.c ------------------------------------------------------------------------------- */

/* Sets the method of a forming scene by its name: one of the library on W, or "gauss-seidel",
 * "augmented-lagrangian", "penalty" in the equilibrium loop. Returns 0 for no method. */
int forming_method(const char *name, dls_forming_settings *settings);

/* Shows the progress of a step on the terminal; returns non-zero after Ctrl-C. */
int show_step(const dls_forming_data *data, int step);

/* The callback of dls_forming_settings: ends a step after Ctrl-C, and shows nothing. */
int stop_step(void *unused, const dls_progress *progress);

/* Writes travel, position, pressure and shear of a step, a row for each node, and a blank row. */
void write_pressures(FILE *data, const dls_forming_data *d);

/* Draws mesh.*, plastic.*, pressure.*, force.* in a directory that holds force.csv and pressure.dat
 * (forming_picture.c); EXIT_SOLVED, or EXIT_BAD_INPUT after a complaint. as_is: 1 for a scene with
 * all of its own settings, whose force other codes have computed. */
int draw_forming(const char *directory, const char *title, const dls_forming_data *data, int as_is);

#endif
