/*
 * console.h: what every command of the program uses: options, messages, names, files, pictures.
 */
#ifndef CONSOLE_H
#define CONSOLE_H

#include <getopt.h>
#include <stddef.h>
#include <stdio.h>

#include "contact/contact.h"
#include "delassus.h"
#include "delassus/fe.h"

/* Exit statuses. */
enum { EXIT_SOLVED = 0, EXIT_NOT_SOLVED = 1, EXIT_BAD_INPUT = 2 };

enum { PATH_ROOM = 4096 }; /* of a path */

/* ---- nearest.c ------------------------------------------------------------------------------- */

/* The names nearest to a mistyped word: those that it begins, else those with the fewest mistakes.
 * Start from {.word = word}. */
enum { NEAREST_MOST = 6 };
typedef struct nearest {
  const char *word;
  int mistakes, count; /* of each name; of names */
  const char *name[NEAREST_MOST];
  char words[300];
} nearest;
void nearest_try(nearest *n, const char *name);

/* Returns "; did you mean A, B or C?", or "" if no name is near. */
const char *nearest_words(nearest *n);

/* Returns the name of scene k of any kind; NULL beyond the last. */
const char *scene_name(int k);
const char *scene_description(int k);
typedef enum scene_kind { NO_SCENE, SCENE_AT_ONCE, SCENE_FORMING, SCENE_MOVING } scene_kind;
scene_kind kind_of_scene(const char *name);
scene_kind kind_among(int argc, char **argv); /* of the first argument that is a scene */

/* ---- json.c ---------------------------------------------------------------------------------- */

/* A table in a CSV file, row by row: the names of its columns, and the fields of the row at hand. A
 * field in quotes may hold commas, and "" for a quote. */
enum { MOST_FIELDS = 24, LONGEST_LINE = 8192 };
typedef struct csv_table {
  FILE *file;
  int columns, fields;
  char *column[MOST_FIELDS], *field[MOST_FIELDS];
  char head[LONGEST_LINE], line[LONGEST_LINE];
} csv_table;

/* Opens DIRECTORY/NAME, or NAME where directory is NULL, and reads its columns; returns 0 if it
 * cannot be read. */
int csv_open(csv_table *t, const char *directory, const char *name);

/* Reads the next row, past comments; returns 0, and closes the file, after the last. */
int csv_next(csv_table *t);

/* Returns the place of a column, whose name has `length` letters; -1 for none. */
int csv_column(const csv_table *t, const char *name, size_t length);

/* Begins the object that --json prints: its title, status and, where it is not NULL, why. */
void print_json_head(const char *title, const char *status, const char *why);

/* Does the same as end_command; with --json prints one object with the rows of the table NAME that
 * the command has written into the directory. */
int end_table(int result, const char *why, const char *title, const char *directory,
              const char *name);

/* ---- options.c ------------------------------------------------------------------------------- */

/* The outcome of taking one option. */
typedef enum taken {
  OPTION_WRONG = 0, /* after a complaint */
  OPTION_TAKEN = 1,
  OPTION_UNKNOWN,
  OPTION_HELP,
  OPTION_DONE /* there is nothing left to do */
} taken;

/* What is done with the value of an option. */
typedef enum option_kind {
  BY_FUNCTION, /* command.take takes it, by its key */
  A_FLAG,      /* int := 1 */
  A_TEXT,      /* const char * */
  A_NUMBER,    /* double, finite and >= 0 */
  A_COUNT,     /* int >= 1 */
  A_MESH       /* two ints, NXxNY */
} option_kind;

/* An option. key: its letter; else, for command.take alone, a number from 256 on; else 0. at: place
 * of the value in the data of the command. */
typedef struct option_row {
  const char *name;
  int key;
  option_kind kind;
  int has_value;
  size_t at;
} option_row;

/* A command: its options, the last one without a name, the text of --help, and a function that
 * takes those BY_FUNCTION into the command's data, or NULL. */
typedef struct command {
  const option_row *options;
  void (*usage)(FILE *out);
  taken (*take)(int key, const char *text, void *data);
  int operands; /* names after the options; 0: the command counts them itself */
} command;

/* Takes all options of a command and counts its operands. Returns GO_ON, or the exit status to end
 * with. */
enum { GO_ON = -1 };
int take_options(int argc, char **argv, const command *command, void *data);

/* Takes the option --NAME=TEXT of a command. */
taken take_named(const command *command, const char *name, const char *text, void *data);

/* Complains of the number of names after the options of command `name`; returns EXIT_BAD_INPUT. */
int wrong_names(const char *name);

/* Rows of a table of options: BY_FUNCTION with a value and without; the other kinds; and the last
 * rows of every command. */
#define VALUE(name, key)                                                                           \
  { name, key, BY_FUNCTION, 1, 0 }
#define FLAG(name, key)                                                                            \
  { name, key, BY_FUNCTION, 0, 0 }
#define ROW(kind, name, key, type, member)                                                         \
  { name, key, kind, (kind) != A_FLAG, offsetof(type, member) }
#define LAST_OPTIONS                                                                               \
  FLAG("json", 'j'), FLAG("verbose", 'v'), FLAG("quiet", 'q'), FLAG("help", 'h'), FLAG(NULL, 0)
#define LAST_USAGE                                                                                 \
  "  -j, --json            print one JSON object instead of text\n"                                \
  "  -v, --verbose         print progress on stderr\n"                                             \
  "  -q, --quiet           print the last line only, and what another option asks for\n"           \
  "  -h, --help            this text\n"

/* Of the commands whose --out writes pictures that may be left out. */
enum { KEY_NO_PICTURES = 901 }; /* no letter */
#define PICTURE_OPTION FLAG("no-pictures", KEY_NO_PICTURES)
#define PICTURE_USAGE                                                                              \
  "      --no-pictures     --out: write data and scripts of the pictures, do not run gnuplot\n"

/* Take --quiet, --verbose and --json; return 0 for another key. Key 0 forgets all three. */
int take_loudness(int key);
int is_quiet(void);
int is_verbose(void);
int is_json(void);
int prints_text(void); /* neither --quiet nor --json */

/* Prints on stdout, if the command prints text. */
void tell(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* The method and its settings, from -m, -a, -t, -i, --threads. */
typedef struct solver_options {
  dls_solver_settings settings;
  int primal; /* 1: gauss-seidel on the displacements instead of settings.method */
  int method_given, accel_given;
} solver_options;

enum { KEY_THREADS = 900 };   /* no letter */
enum { most_threads = 1024 }; /* of the library */
/* member: of the solver_options in the data of a command */
#define SOLVER_OPTIONS(type, member)                                                               \
  VALUE("method", 'm'), VALUE("accel", 'a'),                                                       \
      ROW(A_NUMBER, "tol", 't', type, member.settings.limits.tol),                                 \
      ROW(A_COUNT, "max-iter", 'i', type, member.settings.limits.max_iterations),                  \
      VALUE("threads", KEY_THREADS)

void solver_options_init(solver_options *options, double tol);

/* Prints the lines of --help for these options. more: methods that the library does not name. */
void solver_usage(FILE *out, const char *more, double tol);

/* Takes an option of SOLVER_OPTIONS; OPTION_UNKNOWN for another key. */
taken take_solver_option(int key, const char *text, solver_options *options);

/* Checks the options against each other when all are taken; returns 0 after a complaint. */
int settle_solver_options(solver_options *options);

/* Complains of a name that is no method: the nearest one, or all. more: methods that the library
 * does not name, the last one NULL; or NULL. Returns OPTION_WRONG. */
taken no_method(const char *name, const char *const *more);

/* Writes the names of all methods, "auto, nlgs, ...", into text (size) and returns it. */
enum { METHOD_LIST_ROOM = 200 };
const char *method_list(char *text, size_t size);

/* ---- quote.c --------------------------------------------------------------------------------- */

/* The places that a name or a title is written to. */
typedef enum text_kind {
  AS_SHOWN,   /* a terminal: controls and bytes that are no UTF-8 as \n, \t, \xNN */
  AS_GNUPLOT, /* a string of gnuplot's, with its quotes, where no format is read (as in tics);
                 controls as blanks */
  AS_CSV,     /* a field; quotes around it where it needs them; controls as blanks; a text that a
                 spreadsheet would compute begins with ' */
  AS_JSON,    /* a string, with its quotes */
  AS_HTML     /* text between tags, or in quotes within one; controls as blanks */
} text_kind;

/* Returns the text as it has to stand there, for use within one expression:
 * fprintf(script, "set title %s\n", quote(AS_GNUPLOT, title).text). In files U+FFFD stands for each
 * byte that is no UTF-8 and, but in JSON, for each mark that changes the direction of a line. A
 * text that is too long ends early, its quotes closed. */
enum { QUOTED_ROOM = 4096 };
typedef struct quoted {
  char text[QUOTED_ROOM];
} quoted;
quoted quote(text_kind kind, const char *text);

/* ---- messages.c ------------------------------------------------------------------------------ */

/* Prints "delassus: " and the message on stderr; returns EXIT_BAD_INPUT. */
int complain(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Does the same; is 0, which as (taken) is OPTION_WRONG. */
#define refuse(...) (complain(__VA_ARGS__) != EXIT_BAD_INPUT)

/* Runs a command within another one: argv ends with NULL and has --quiet. It prints nothing.
 * Returns its exit status; `why` (PATH_ROOM): what it complained of, "" for nothing. */
int run_command(int (*run)(int argc, char **argv), char **argv, char *why);

/* Prints the last line of a command on stdout, in colour on a terminal unless the environment has
 * NO_COLOR: "solved", "solved to rounding: ..", "solved: reactions to about E" where the predicted
 * error is above 1e-4, or "not solved: WHY". info: of a contact problem; or NULL. */
void print_ending(dls_status status, const dls_info *info);

/* Writes what a proof shows of an answer into text (size); returns text. */
const char *proof_words(const dls_proof *proof, char *text, size_t size);

/* Counts the self-stresses of an answer r on W, up to most_rows_of_freedom rows. DLS_E_MEMORY and
 * the like. */
enum { most_rows_of_freedom = 1000, FREEDOM_TOO_LARGE = -1, FREEDOM_ON_K = -2, NO_FREEDOM = -3 };
dls_status count_freedom(const dls_contact *contact, const double *r, int *freedom,
                         dls_error *error);
/* Writes what a table of reactions has to say of them, "" where they are determined. */
enum { FREEDOM_ROOM = 160 };
const char *freedom_words(int freedom, dls_forces forces, char *text);

/* Prints the last line of a solve whose answer a proof has looked at. */
void print_proved(const dls_proof *proof);

/* Does the same for a command of many solves, by its exit status; why: of EXIT_NOT_SOLVED. Returns
 * the exit status: after Ctrl-C, EXIT_NOT_SOLVED. */
int end_command(int result, const char *why);

/* Complains of an error of the library about `what` (a file name, say). */
int complain_of(const char *what, const dls_error *error);

/* Fills in *error and returns DLS_E_MEMORY. */
dls_status no_memory(dls_error *error);

/* Returns "" for 1, else "s". */
const char *plural(long long count);

/* Refuses a value that is `what`; of a number with a decimal comma, says how to write it. */
int refuse_number(const char *option, const char *text, const char *what);

/* Reads the finite number at *text and moves *text past it; returns 0 if none stands there. */
int read_real(const char **text, double *value);

/* Reads N, with *ny = 0, or NXxNY, whole numbers >= 1; returns 0 for any other text. */
int read_mesh(const char *text, int *nx, int *ny);

/* Reads the value of an option, finite and >= 0. */
taken parse_number(const char *option, const char *text, double *value);

/* Finds a word among count; returns its place, or -1 after a complaint that lists them. */
int parse_word(const char *option, const char *text, const char *const *words, int count);

/* Returns the largest |v_i|; entries that are not a number do not count. */
double largest_entry(const double *v, int n);

/* Returns |x - y|_2, or |x|_2 where y is NULL. */
double distance(size_t n, const double *x, const double *y);

/* Compares two doubles, for qsort: the smallest first. */
int ascending(const void *a, const void *b);

/* Return the words of JSON for a status ("solved", "max_iterations", ...), for a state and for an
 * iteration of a method. */
const char *status_word(dls_status status);
const char *state_word(dls_contact_state state);

/* Writes "not solved: WHY, residual R" into text (size), nothing for solved, and returns it: what
 * every file with an answer carries. */
enum { UNSOLVED_ROOM = 120 };
const char *unsolved_words(dls_status status, double residual, char *text, size_t size);
const char *iteration_word(dls_method method, int count);

/* ---- verdict.c ------------------------------------------------------------------------------- */

/* The meaning of a solve that ended without an answer. */
typedef struct verdict {
  const char *says, *next; /* NULL: there is nothing to say */
  int exact;               /* 1: farkas is a proof, 0: up to rounding */
  int rows, stride;        /* of farkas, and numbers in a row of ray */
  const double *farkas;    /* rows, or NULL */
  const double *ray;       /* rows x stride, along which the unknowns run away, or NULL */
  const double *motion;    /* of a body that nothing can hold: unknowns, or NULL */
  int unknowns, mover;     /* mover: an unknown of that body */
} verdict;

/* Fills says, next and exact; farkas tells a ray that has a solution excluded up to rounding. */
void verdict_fill(verdict *v, dls_status status, int lcp);

/* Prints the verdict; with proof = 1 the vectors, too. */
void verdict_print(const verdict *v, int proof);

/* ---- unsettled.c ----------------------------------------------------------------------------- */

enum { most_unsettled = 8 };

/* The candidates at which an answer that is none is wrong. */
typedef struct unsettled {
  int count, candidate[most_unsettled]; /* the worst first: half of the error, or the first few */
  double share;                         /* of the sum of |F_c|^2 that these hold */
  double
      growth; /* of the residual in a sweep from there; more than 1: sweeps diverge; 0: unknown */
} unsettled;

/* Returns 0 after a complaint. */
int unsettled_find(unsettled *to, const dls_contact *contact, const double *r, const double *u);

/* Prints nothing if count is 0. */
void unsettled_print(const unsettled *from);

/* ---- messages.c, outcomes -------------------------------------------------------------------- */

/* The summary of a run, in text and in JSON. */
typedef struct outcome {
  dls_info info;
  int d, nc;
  double solve_cpu_seconds;
  const char *scene; /* NULL for a file */
  int weighted;
  double Rt, Rn;                 /* scenes: resultants of the candidates' reactions */
  const dls_primal_info *primal; /* gauss-seidel, its own certificate; NULL: another method */
  int as_printed;                /* 1: by jean_sweeps */
  verdict verdict;               /* of solve */
  int proof;                     /* 1: with its vectors */
  int prove;                     /* of solve, 1: `proved` is known */
  dls_proof proved;
  unsettled unsettled; /* of solve, where nothing else is said */
  int freedom;         /* of the answer (count_freedom), FREEDOM_ON_K; NO_FREEDOM: no answer */
} outcome;

const char *method_word(const outcome *outcome);

/* Prints the stages of auto, one a line; nothing for the other methods. */
void print_stages(const dls_info *info);

/* Prints both parts of the residual, a line. */
void print_residuals(const char *indent, const dls_certificate *c);

/* Prints one object with the fields of the outcome. */
void print_json(FILE *out, const outcome *outcome);

/* Print a string, a number (null if not finite), and a number as the next field of an object. */
void print_json_string(FILE *out, const char *text);
void print_json_number(FILE *out, double value);
void print_json_field(FILE *out, const char *name, double value);

/* Prints a field of an object whose value is an array of numbers; name: in its quotes, and what
 * stands before it. */
void print_json_numbers(FILE *out, const char *name, int n, const double *x);

/* Prints a verdict as the next fields of an object; with proof = 1 the vectors, too. */
void print_json_verdict(FILE *out, const verdict *v, int proof);

/* Returns the CPU seconds of this process. */
double cpu_seconds(void);

/* Returns seconds to two digits, without powers of ten: "0.13 ms", "4.1 s", "350 s", "23 min",
 * "4 h", for use within one expression. */
typedef struct duration {
  char text[24];
} duration;
duration in_words(double seconds);

/* Shows progress: a callback that prints a line on stderr if that is a terminal and the work is
 * long, or with --verbose each call as a line, and cancels on Ctrl-C, SIGTERM, SIGHUP and SIGXCPU,
 * which watch_interrupt has to catch first. progress_end clears the line. */
int show_progress(void *data, const dls_progress *progress);
void watch_interrupt(void);
int was_interrupted(void); /* 1 after one of these signals */
/* 1: one of these signals ends the program at once, until progress is shown for the first time or
 * end_at_once(0). For a command that reads, which takes no callback, and has begun no file. */
void end_at_once(int on);
void progress_end(void);
/* Shows a task of many runs instead: its name (borrowed), its part, the share done of `whole` CPU
 * seconds and what is left; without a terminal as lines, each 5 seconds. name = NULL: no more. */
void progress_task(const char *name, double whole, double reached);
void progress_part(const char *part);
/* The same of a reduction, which calls every millisecond: silent with --verbose. */
int show_reduction(void *data, const dls_progress *progress);

/* ---- picture.c ------------------------------------------------------------------------------- */

/* The contents of a scene's pictures; the caller owns the arrays; NaN where the paper has no
 * value. */
typedef struct scene_picture {
  const char *directory;
  const char *title;
  const dls_fe_scene_data *scene;
  const double *displacement;        /* 2 * nodes */
  const double *reaction;            /* 2 * nodes, (x, y) */
  const dls_contact_state *state;    /* candidates */
  const double *x, *rt, *rn;         /* candidates */
  const double *paper_rt, *paper_rn; /* candidates, or NULL */
} scene_picture;

/* Writes deformed.{dat,gp,png,svg} and reactions.{dat,gp,png,svg}; EXIT_SOLVED, or EXIT_BAD_INPUT
 * after a complaint. Without gnuplot, data and scripts are kept and a line on stderr says so. */
int draw_scene(const scene_picture *picture);

/* Joins "DIRECTORY/NAME" into path; returns 0 after a complaint if that is too long. */
int join_path(char path[PATH_ROOM], const char *directory, const char *name);

/* Creates the directory and its parents; returns 1 if it is there. */
int make_directory(const char *path);

/* Open a file for writing, by its path or in a directory; NULL after a complaint. It takes the
 * place of an old one when close_file has brought it to the disk. */
FILE *open_path(const char *path);
FILE *open_in(const char *directory, const char *name);

/* Opens a file in a directory, and writes its first line. */
FILE *open_table(const char *directory, const char *name, const char *head);

/* Opens a table that grows with the run: whatever ends that, the table keeps its rows. */
FILE *open_growing(const char *directory, const char *name, const char *head);

/* Closes a file that was opened so, by its name in a complaint; returns 1 if all of it was
 * written. Otherwise the old one stays. */
int close_file(FILE *file, const char *name);

/* Closes all files that are open, in the order they were opened. Returns 0 after a complaint about
 * one that was not written; it and those after it keep the rows of growing tables alone. */
int close_files(void);

/* Gives up the files that are still open, but the rows of growing tables, which become files. */
void keep_tables(void);

/* Gives up the files that are still open; old ones stay. */
void drop_files(void);

/* Set the open files aside, so that a command within another one does not drop them; put them back,
 * and drop what that command left open. */
struct open_file *set_files_aside(void);
void put_files_back(struct open_file *files);

/* Open and close DIRECTORY/series.pvd; NULL, or 0, after a complaint. */
dls_fe_series *open_series(const char *directory);
int close_series(dls_fe_series *series);

/* Opens DIRECTORY/NAME.gp, a script for gnuplot, for what stands before begin_pictures; NULL after
 * a complaint. */
FILE *open_script(const char *directory, const char *name);

/* Sets if draw_script runs gnuplot, as it does at first. */
void draw_pictures(int on);

/* Ends the script that begin_pictures has begun, and draws NAME.png and NAME.svg. Returns 2 if they
 * are there, 1 if gnuplot has not drawn them (it complains of the first) or was not asked to, 0 if
 * the script could not be written. Data and script are kept. */
int draw_script(FILE *script, const char *directory, const char *name);

/* Begins the loop of a script that draws NAME.png and NAME.svg; the caller writes the plot and
 * closes the brace. */
void begin_pictures(FILE *script, const char *name, double width, double height);

/* Returns the colour of a state of contact in all pictures. */
const char *state_colour(dls_contact_state state);

/* Places the next plot of a script: its edges in parts of the picture, from the lower left. */
void place_panel(FILE *script, double left, double right, double bottom, double top);

/* Computes the bounding box of the mesh at rest and, if displacement is not NULL, displaced. */
void mesh_box(int nodes, const double *xy, const double *displacement, double lo[2], double hi[2]);

/* ---- folder.c -------------------------------------------------------------------------------- */

/* Returns the system's folder for temporary files: $TMPDIR, else /tmp. */
const char *temporary_place(void);

/* Takes a folder for the files of `delassus OF NAME` and returns its name. directory: given by
 * the user; it and its parents are created where they are missing, and made-by.txt in it names the
 * command. NULL: a new folder in temporary_place. name: NULL for a command of many names. Returns
 * NULL after a complaint: the files there belong to another command, or it cannot be written. */
const char *take_folder(const char *directory, const char *of, const char *name);

/* Removes the new folder if nothing was written into it. */
void drop_folder(void);

#endif
