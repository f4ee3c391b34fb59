/* map.h: maps of verdicts: cells in rows and columns, of delassus map. */
#ifndef MAP_H
#define MAP_H

#include "race.h"

int command_map(int argc, char **argv);

enum { MAP_ROWS = 80, MAP_COLUMNS = 16, MAP_LINES = 8, MAP_NAME = 96 };

/* A cell; an empty colour leaves it out. */
typedef struct map_cell {
  char colour[8];
  int hatched; /* 1: not decided */
  char text[40];
} map_cell;

/* A line across the rows, between two of them: at row 2.5, say. */
typedef struct map_line {
  double row;
  const char *colour;
  char text[80];
} map_line;

/* Panels of rows x columns cells. Row 0 is the lowest. */
typedef struct map_picture {
  const char *directory, *title, *subtitle;
  const char *x, *y; /* labels of the axes */
  int panels, rows, columns;
  const char *panel[MOST_CONTENDERS]; /* titles; NULL for one without */
  char row[MAP_ROWS][MAP_NAME], column[MAP_COLUMNS][MAP_NAME];
  map_cell *cells;    /* panels x rows x columns: map_at */
  const double *side; /* rows: values of a panel beside, NaN for none; NULL for no such panel */
  const char *side_title;
  int lines;
  map_line line[MAP_LINES];
  const char *notes; /* what the colours mean, where the cells do not say; NULL */
} map_picture;

map_cell *map_at(const map_picture *p, int panel, int row, int column);

/* Sets the cell of a verdict: its colour and word; of a solve, the shade and the number tell how
 * many times the fastest of the row it took. */
void map_verdict(map_cell *cell, ending e, double times_fastest);

/* Sets the cell of a share, 0 to 1; hatched = 1: not all of it is decided. */
void map_share(map_cell *cell, double share, int hatched);

/* Fills mu with rows values from `from` to `to`: 0 if from is 0, then in equal ratios. */
void spread_friction(double from, double to, int rows, double *mu);

/* Writes map.dat, map.gp, draws map.png, map.svg; returns EXIT_SOLVED, or EXIT_BAD_INPUT after a
 * complaint (map_picture.c). */
int draw_map(const map_picture *p);

/* ---- the maps -------------------------------------------------------------------------------- */

typedef struct map_options {
  source of;
  double from, to; /* friction; to < 0: the map's own */
  int rows;        /* of friction; 0: the map's own */
  double tol, limit;
  int samples;
  const char *against; /* NULL: methods */
  const char *method;  /* of scenes that go in steps */
  const char *out;     /* NULL: a new folder */
} map_options;

enum { map_longer = 10 }; /* times its limit that a cell may take before it is not decided */

int map_against(const char *name, map_options *o); /* map_against.c */
/* moves = 1: a scene of bodies that move, 0: forming (map_steps.c) */
int map_steps(const char *name, map_options *o, int moves);

#endif
