/*
 * cli.h: the commands solve, info and study.
 */
#ifndef CLI_H
#define CLI_H

#include "problem/problem.h"

int command_solve(int argc, char **argv);
int command_info(int argc, char **argv);
int command_study(int argc, char **argv);

/* Runs `delassus solve`; from: NULL, or what solves. */
int solve_with(int argc, char **argv, const engine *from);

/* Drops what a command has left open, flushes stdout; returns the exit status of the program. */
int end_program(int result);

/* info.c: prints a line for each of dls_diagnosis.hints. */
void print_hints(int hints);

/* ---- results.c ------------------------------------------------------------------------------- */

/* Finds the state of each candidate; a new array, or NULL after a complaint. */
dls_contact_state *find_states(const problem *p, const double *r, const double *u);

/* Prints the answer as a table: each candidate's state, reaction and position; with x (n), each
 * unknown's. */
int print_results(const problem *p, const outcome *o, const double *r, const double *u,
                  const double *x);

/* Writes the answer into DIRECTORY/r.csv and, with x, x.csv, `unsolved` in a line before it; 0
 * after a complaint. The directory is there: make_directory. */
int write_results(const char *directory, const problem *p, const outcome *o, const double *r,
                  const double *u, const double *x, const char *unsolved);

/* ---- sensitivity.c --------------------------------------------------------------------------- */

/* Rows of the largest problem for the map of info --sensitivity. */
enum { most_rows_of_map = 600 };

/* Writes which gaps and loads, and how much friction, each reaction of the answer r depends on:
 * sensitivity.csv, friction.csv and the picture sensitivity.png, .svg in the directory, and, text =
 * 1, a table on stdout. EXIT_SOLVED, or EXIT_BAD_INPUT after a complaint. */
int show_sensitivity(const char *name, const dls_contact *contact, const double *r,
                     const char *directory, int text);

/* ---- history_picture.c ----------------------------------------------------------------------- */

/* Draws history.csv of the directory (solve --plot); returns 1, or 0 after a complaint. */
int draw_history(const char *directory, const char *title);

#endif
