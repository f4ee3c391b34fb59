/*
 * report.h: the parts of delassus report: the page that it writes, and the error budget.
 */
#ifndef REPORT_H
#define REPORT_H

#include "charts/race.h"
#include "problem/setting.h"

int command_report(int argc, char **argv);

/* ---- report_page.c --------------------------------------------------------------------------- */

enum { PAGE_CELLS = 1200, PAGE_COLUMNS = 12, PAGE_CELL = 72, PAGE_SENTENCE = 1000 };

/* A page in HTML and, with text = 1, the same on stdout. All words go through quote(). */
typedef struct page {
  FILE *html;
  int text;
  int pictures; /* so far: the ids of each have a number of their own */
  int columns, cells;
  char cell[PAGE_CELLS][PAGE_CELL]; /* of the table at hand, the heads first */
} page;

/* Begins and ends DIRECTORY/NAME; 0 after a complaint. */
int page_open(page *p, const char *directory, const char *name, const char *title, int text);
int page_close(page *p, const char *name);

typedef enum page_words {
  PAGE_TITLE,
  PAGE_SECTION,
  PAGE_LEAD,
  PAGE_PLAIN,
  PAGE_NOTE,
  PAGE_COMMAND
} page_words;
void page_say(page *p, page_words kind, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Begins a table with its heads, a comma between them; adds a cell, row by row; ends it. */
void page_table(page *p, const char *heads);
void page_cell(page *p, const char *format, ...) __attribute__((format(printf, 2, 3)));
void page_table_end(page *p);

/* Adds columns of DIRECTORY/NAME, a CSV file, as a table: those named in `columns`, a comma
 * between them, "" for all; the last `rows` of the rows that have a field `only` (NULL: all).
 * Returns 0 if it cannot be read. */
int page_csv(page *p, const char *directory, const char *name, const char *columns,
             const char *only, int rows);

/* Adds the picture DIRECTORY/NAME, an SVG of gnuplot. Returns 0 if it is not there, or too large
 * for a page. */
int page_picture(page *p, const char *directory, const char *name, const char *words);

/* ---- report_budget.c ------------------------------------------------------------------------- */

enum { MOST_PROBES = 250, LOWEST = -14, HIGHEST = 8, LEVELS = HIGHEST - LOWEST + 1 };

/* A run of the scene at a setting. */
typedef struct probe {
  setting at;
  scene_answer got;
  const char *part; /* why it was run: "own", "mesh", .. */
} probe;

/* Runs along one part of the setting: level 0 is the scene's own, and each level above it finer.
 * The other parts stay at levels of theirs. */
typedef struct ladder {
  const char *part;
  int mesh, steps, tol; /* levels of the other parts */
  int low, high;        /* levels that were run; low > high: none */
  int run[LEVELS];      /* the probe of a level: run[level - LOWEST] */
  double limit;         /* of the values; the finest value if they have no order */
  double truth;         /* limit, or a better one: a closed form, the other mesh */
  double doubt;         /* estimated error of the limit, relative */
  double order;         /* measured; NaN: none that three limits agree on */
  int monotone;         /* 1: the last values move in one direction */
} ladder;

typedef struct budget {
  const scene *scene;
  double accuracy, limit; /* wanted, relative; CPU seconds for all runs */
  int of; /* what is to be accurate: bits 1 << OF_.., 0: force and curve; in: those that it has */
  double start;
  int probes;
  probe probe[MOST_PROBES];
  ladder mesh, second, steps, tol; /* second: the other kind of mesh, if the scene has one */
  double reference;                /* the closed form or the limit of the ladders */
  int finest[OF_COUNT];            /* the probe whose field is the reference, -1: none */
  double doubt[OF_COUNT];          /* estimated error of each reference */
  int disagree;         /* 1: the limits of both meshes differ by more than their doubts */
  int own, take, check; /* probes; -1: none */
  double error;         /* of the setting to take: the worst of what is asked, with its doubt */
  int met;              /* 1: take is within the accuracy, and the check run agrees */
  setting enough;       /* met = 0: what would be enough by an order, ... */
  double enough_order, enough_seconds; /* ... its CPU; NaN: 64 times as fine is not enough */
  dls_status status;                   /* of the first error of the library */
} budget;

/* The words of --of. */
extern const char *const quantity_names[OF_COUNT];

/* Measures and searches. Returns a status < 0 with *error, or DLS_OK. */
dls_status budget_run(budget *b, dls_error *error);

/* Returns the probe of a level, -1 if that was not run or did not finish. */
int ladder_probe(const budget *b, const ladder *l, int level);

/* ---- report_words.c -------------------------------------------------------------------------- */

/* Writes a fraction as "0.65 %", "12 %" or "unknown" and returns text. */
const char *percent(double part, char text[24]);

/* Writes the verdict, and the tables of the budget. */
void budget_verdict(const budget *b, char *text, size_t size);
void budget_accuracy(const budget *b, page *p);
void budget_tables(const budget *b, page *p);

/* Returns the distance of a probe from the reference, without the doubt; INFINITY without one. */
double budget_error(const budget *b, int probe, quantity_of of);

/* Returns that with the doubt; of the setting to take at least the distance from its check run. */
double budget_within(const budget *b, int probe, quantity_of of);

/* Returns which of what is asked has the largest error. */
quantity_of budget_worst(const budget *b, int probe);

/* Writes budget.csv, budget.gp and draws budget.svg in the directory; 0 after a complaint. */
int budget_picture(const budget *b, const char *directory);

/* ---- report_file.c --------------------------------------------------------------------------- */

enum { FILE_RUNGS = 12 };

/* The budget of a contact problem of a file, or of matrices: no mesh, no steps. */
typedef struct file_budget {
  const dls_contact *contact; /* borrowed */
  double accuracy, limit;
  double tol[FILE_RUNGS];
  dls_info info[FILE_RUNGS];
  double seconds[FILE_RUNGS];
  double error[FILE_RUNGS]; /* of r or u from the reference; NaN: not solved */
  double *answer;           /* FILE_RUNGS * m: r, or u where in_u */
  int best;                 /* the tightest rung that is solved, -1: none */
  int take;                 /* the rung to take, -1: none */
  int in_u;                 /* 1: W does not determine r, errors are of u */
  dls_proof proof;          /* of the reference */
  double no_friction;       /* by how much mu = 0 moves the answer; NaN: not solved, no friction */
  dls_contact_state *state; /* nc: of the best answer */
  double *r, *u, *other;    /* m: of the best answer; room */
} file_budget;

/* Solves down the tolerances, proves, compares. Start from {contact, accuracy, limit}; free it
 * after a failed run, too. */
dls_status file_budget_run(file_budget *b, dls_error *error);
void file_budget_free(file_budget *b);

void file_verdict(const file_budget *b, char *text, size_t size);
void file_tables(const file_budget *b, page *p);
void file_contacts(const file_budget *b, page *p);

/* ---- report_parts.c -------------------------------------------------------------------------- */

enum { MOST_COMMANDS = 8, COMMAND_ROOM = 900, MOST_WORDS = 16 };

typedef struct command_line {
  int count;
  char word[MOST_WORDS][PATH_ROOM];
} command_line;

/* What the parts of a page share. */
typedef struct parts {
  page *page;
  const char *name;    /* as commands take it */
  const char *folder;  /* of the files: FOLDER/chart, .. */
  const scene *scene;  /* NULL: a file */
  const setting *take; /* of a scene */
  double cpu;          /* seconds of a part, about */
  int commands;
  char command[MOST_COMMANDS][COMMAND_ROOM]; /* as a shell reads them */
  command_line line;                         /* at work; not on the stack, which may be small */
} parts;

/* Notes a command line; shows the last one. */
void part_note(parts *a, const char *what, const char *options);
void part_command(const parts *a);

/* Says how many answers the problem has at its own friction. */
void part_uniqueness(const parts *a, const dls_contact *contact);

/* Add the section of a part. of: the problem that all methods solve. */
void part_speed(parts *a, int step, const char *of);
void part_stability(parts *a);
void part_run(parts *a, const scene_answer *got);
void part_commands(const parts *a);

/* Removes the largest files of the scene until 20 MB are left, and says so. */
void part_trim(const parts *a);

#endif
