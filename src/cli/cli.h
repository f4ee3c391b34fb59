/*
 * cli.h: the parts of the program `delassus`.
 *
 *   main.c      commands, help, version
 *   scene.c     delassus scene NAME: model -> reduction -> solver -> tables, files, pictures
 *   forming.c   delassus scene indentation, extrusion: load steps, files
 *   forming_picture.c   their pictures
 *   tables.c    delassus tables: both of them by every method
 *   solve.c     delassus solve FILE: FCLIB problems and LCPs
 *   info.c      delassus info FILE: facts about an FCLIB problem
 *   problem.c   FCLIB problems in memory, condensed if they are global
 *   options.c   the options that scene and solve share
 *   report.c    messages, JSON, progress on a terminal, Ctrl-C
 *   picture.c   data files and gnuplot scripts, and running gnuplot on them
 */
#ifndef CLI_H
#define CLI_H

#include <stdio.h>

#include "delassus.h"
#include "delassus/fe.h"
#include "delassus/forming.h"

/* Exit statuses. */
enum { EXIT_SOLVED = 0, EXIT_NOT_SOLVED = 1, EXIT_BAD_INPUT = 2 };

int command_scene(int argc, char **argv);
int command_solve(int argc, char **argv);
int command_info(int argc, char **argv);
int command_forming(int argc, char **argv);
int command_tables(int argc, char **argv);

/* Creates the directory and its parents; 1 if it is there. */
int make_directory(const char *path);

/* ---- problem.c ------------------------------------------------------------------------------- */

/* A problem in memory: read from the file, condensed if it was global. Start from {0}; free it
 * whether loading succeeded or not. */
typedef struct problem {
  dls_fclib *file;
  dls_reduction *reduction; /* NULL for a local problem */
  dls_model model;          /* of a global one */
  const double *f, *g, *mu;
  dls_contact contact;
  double reduction_cpu_seconds;
} problem;

dls_status problem_load(const char *path, problem *p, dls_error *error);
void problem_free(problem *p);

/* ---- options.c ------------------------------------------------------------------------------- */

/* Method and settings, of -m, -a, -t, -i. */
typedef struct solver_options {
  dls_solver_settings settings;
  int primal; /* gauss-seidel, in the place of settings.method */
  int method_given, accel_given;
} solver_options;

#define SOLVER_KEYS "m:a:t:i:"
/* clang-format off */
#define SOLVER_OPTIONS                           \
  {"method", required_argument, NULL, 'm'},      \
  {"accel", required_argument, NULL, 'a'},       \
  {"tol", required_argument, NULL, 't'},         \
  {"max-iter", required_argument, NULL, 'i'}
/* clang-format on */

void solver_options_init(solver_options *options, double tol);

/* Their lines of --help; more: methods that the library does not name. */
void solver_usage(FILE *out, const char *more, double tol);

/* 1: taken; 0: wrong, after a complaint; -1: another key. */
int take_solver_option(int key, const char *text, solver_options *options);

/* When all are taken: 0 after a complaint. */
int settle_solver_options(solver_options *options);

/* "auto, nlgs, ...": the names of all methods, in text (size), which is returned. */
enum { METHOD_LIST_ROOM = 200 };
const char *method_list(char *text, size_t size);

/* ---- report.c -------------------------------------------------------------------------------- */

/* "delassus: " and the message on stderr; returns EXIT_BAD_INPUT. */
int complain(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* The same for an error of the library, about `what` (a file name, say). */
int complain_of(const char *what, const dls_error *error);

/* The value of an option, finite and >= 0 (number) or an integer >= 1; 0 after a complaint. */
int parse_number(const char *option, const char *text, double *value);
int parse_count(const char *option, const char *text, int *value);

/* "solved", "max_iterations", "stalled", ...: the word of a solver's status in JSON. */
const char *status_word(dls_status status);
const char *state_word(dls_contact_state state);
const char *iteration_word(dls_method method);

/* What a run is summed up by, in text and in JSON. */
typedef struct outcome {
  dls_info info;
  int d, nc;
  double solve_cpu_seconds;
  const char *scene; /* NULL for a file */
  int weighted;
  double Rt, Rn;                 /* scenes: resultants of the candidates' reactions */
  const dls_primal_info *primal; /* gauss-seidel, its own certificate; NULL: another method */
} outcome;

const char *method_word(const outcome *outcome);

/* What auto did, a line for each stage; nothing for the other methods. */
void print_stages(const dls_info *info);

/* One object with the fields of the outcome. */
void print_json(FILE *out, const outcome *outcome);

/* A JSON string or number (null if not finite). */
void print_json_string(FILE *out, const char *text);
void print_json_number(FILE *out, double value);

/* CPU seconds of this process. */
double cpu_seconds(void);

/* A progress callback: a line on stderr if that is a terminal and the work is long; cancels on
 * Ctrl-C, which watch_interrupt has to catch first. progress_end clears the line. */
int show_progress(void *data, const dls_progress *progress);
void watch_interrupt(void);
void progress_end(void);

/* ---- picture.c ------------------------------------------------------------------------------- */

/* What a scene's pictures show; arrays belong to the caller, NaN where the paper has no value. */
typedef struct scene_picture {
  const char *directory;
  const char *title;
  const dls_fe_mesh *mesh;
  const double *displacement; /* 2 * nodes */
  const double *reaction;     /* 2 * nodes, (x, y) */
  int candidates;
  const double *x, *rt, *rn;         /* candidates */
  const double *paper_rt, *paper_rn; /* candidates, or NULL */
} scene_picture;

/* Writes deformed.{dat,gp,png,svg} and reactions.{dat,gp,png,svg}; EXIT_SOLVED, or EXIT_BAD_INPUT
 * after a complaint. Without gnuplot, data and scripts are kept and a line on stderr says so. */
int draw_scene(const scene_picture *picture);

/* A file to write in a directory: NULL after a complaint; 1 if all was written; gnuplot SCRIPT
 * there: 1 if the pictures are there, 0 after a word on stderr. */
FILE *open_in(const char *directory, const char *name);
int close_file(FILE *file, const char *name);
int run_gnuplot(const char *directory, const char *script);

/* "DIRECTORY/NAME" into path; 0 if that is too long. */
enum { PATH_ROOM = 4096 };
int join_path(char path[PATH_ROOM], const char *directory, const char *name);

/* ---- forming.c ------------------------------------------------------------------------------- */

/* Names of the methods for the forming scenes: those of the front door on W, and "gauss-seidel",
 * "augmented-lagrangian", "penalty" in the equilibrium loop. 0 for no method. */
int forming_method(const char *name, dls_forming_settings *settings);

/* Whether one of the arguments is the name of a forming scene. */
int names_forming(int argc, char **argv);

/* Candidates that carry a reaction. */
int count_contacts(const dls_forming_data *data);

/* Progress of a step on the terminal; not 0 after Ctrl-C. */
int show_step(const dls_forming_data *data, int step);

/* forming_picture.c: mesh.*, plastic.*, force.* in a directory that holds force.csv; EXIT_SOLVED,
 * or EXIT_BAD_INPUT after a complaint. */
int draw_forming(const char *directory, const char *title, const dls_forming_data *data);

#endif
