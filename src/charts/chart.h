/* chart.h: what delassus chart measured, for its table and its picture. */
#ifndef CHART_H
#define CHART_H

#include "race.h"

int command_chart(int argc, char **argv);

enum { CHART_RUNGS = 13, CHART_TARGETS = 3 };

/* Answers of the methods that agree. */
typedef struct chart_answer {
  int of;           /* contender with the least residual: the reference */
  int found_by;     /* how many found it */
  double agreement; /* distance of the next best member; NaN: nobody else found it; of a proved one
                       the radius of its proof */
  double *proved;   /* m: the answer improved and proved (dls_contact_prove), which errors are
                       measured from; NULL: not proved */
} chart_answer;

typedef struct chart {
  problem subject;
  race race;
  double tol[CHART_RUNGS], limit; /* limit: CPU seconds */
  int in_u;      /* 1: errors are measured in u, for W is rank deficient; 0: in r */
  double *error; /* contenders x rungs: from the answer that the method went to; NaN: unknown */
  int answers;
  chart_answer answer[MOST_CONTENDERS];
  int went_to[MOST_CONTENDERS];          /* the contender's answer; -1: none to 1e-8 */
  double amplification[MOST_CONTENDERS]; /* largest error / residual above the noise, or NaN */
  double predicted; /* the same as dls_contact_sensitivity expects it, of r; NaN: not known */
  int take;         /* the contender to take; -1: nobody solved it */
  double worst[MOST_CONTENDERS]; /* CPU over the fastest, the most of all rungs; INFINITY: a rung
                                    is missing that another solved */
  history *history;              /* of each contender */
} chart;

/* ---- chart_words.c --------------------------------------------------------------------------- */

/* The rungs 1e-4, 1e-8, 1e-12. */
extern const int chart_target[CHART_TARGETS];

/* Writes the words of the advice, "take newton: ...". */
void chart_advice(const chart *c, char *text, size_t size);
/* Writes where the errors are measured from. */
void chart_reference(const chart *c, char *text, size_t size);
/* Writes the last cells of the table: CPU in ms and over the fastest, or the verdict; error over
 * residual. */
void chart_cell(const chart *c, int k, int rung, char *text, size_t size);
void chart_amplification(const chart *c, int k, char *text, size_t size);

/* ---- chart_picture.c ------------------------------------------------------------------------- */

/* Writes chart.csv, history.csv, chart.gp and draws chart.png, chart.svg;
 * returns EXIT_SOLVED, or EXIT_BAD_INPUT after a complaint. */
int draw_chart(const chart *c, const char *directory);

#endif
