/*
 * verdict.c: says what a solve without an answer means, what to do next, and shows the vectors that
 * stand behind it.
 */
#include "cli.h"

void verdict_fill(verdict *v, dls_status status, int lcp) {
  v->says = v->next = NULL;
  v->exact = status == DLS_NO_SOLUTION;
  if (v->motion) {
    v->says = "no equilibrium (proved)";
    v->next =
        v->mover < 0
            ? "Joints contradict each other: those with an entry in what --proof shows ask "
              "for different lengths of the same motion."
            : "Nothing can hold a body: it moves rigidly with the loads, and no contact stops "
              "it. --proof shows the motion; look for a support or a load that is missing.";
  } else if (status == DLS_NO_SOLUTION) {
    v->says = "no solution (proved)";
    v->next =
        lcp ? "No z >= 0 has M z + q >= 0: look for the mistake in the rows with v > 0, which "
              "--proof shows."
            : "No reactions keep all candidates apart: change the gaps, the loads or the "
              "supports of the candidates with v > 0, which --proof shows, or their friction.";
  } else if (status == DLS_NO_SOLUTION_LIKELY) {
    v->says = "no solution likely";
    v->next = v->ray ? "The reactions run away in the direction that --proof shows: look for "
                       "candidates that jam or are squeezed there, and lower their friction or let "
                       "the bodies give way."
              : v->farkas
                  ? "But for rounding no reactions keep all candidates apart: look at the "
                    "candidates with v > 0, which --proof shows."
                  : "No states of the candidates have a solution, or it is too far away to be "
                    "certified: look for candidates that jam or are squeezed, and lower their "
                    "friction or let the bodies give way.";
  } else if (status == DLS_RAY && v->farkas) {
    v->says = "ray (to rounding)";
    v->next = lcp ? "But for rounding there is no solution, which proves nothing: give the numbers "
                    "as they were meant, whole if they are, or look at the rows with v > 0, which "
                    "--proof shows."
                  : "But for rounding there is no solution, which proves nothing: look at the "
                    "candidates with v > 0, which --proof shows, or ask auto (-m auto).";
  } else if (status == DLS_RAY) {
    v->says = "ray: this form of the problem says nothing";
    v->next =
        lcp ? "There may be a solution, unless M is positive semidefinite: another form of the "
              "problem, or other units of rows and columns, may show it."
            : "There may be a solution: let auto try the other methods (-m auto).";
  }
}

/* Prints the rows of `stride` numbers that are not all 0, each after its index. */
static void print_rows(const char *title, int rows, int stride, const double *x) {
  printf("  %s\n", title);
  for (int i = 0; i < rows; i++, x += stride) {
    int zeros = 0;
    for (int k = 0; k < stride; k++)
      zeros += x[k] == 0;
    if (zeros == stride) continue;
    printf("    %d:", i);
    for (int k = 0; k < stride; k++)
      printf(" %.17g", x[k]);
    putchar('\n');
  }
}

void verdict_print(const verdict *v, int proof) {
  if (!v->says) return;
  printf("  %s. %s\n", v->says, v->next);
  if (v->motion && v->mover >= 0) printf("  the body of unknown %d moves\n", v->mover);
  if (!proof) return;
  if (v->farkas)
    print_rows(v->exact ? "proof v:" : "v, a proof but for rounding:", v->rows, 1, v->farkas);
  if (v->motion)
    print_rows(v->mover < 0 ? "multipliers:" : "rigid motion:", v->unknowns, 1, v->motion);
  if (v->ray) print_rows("ray:", v->rows, v->stride, v->ray);
}
