/*
 * verdict.c: says what a solve without an answer means, what to do next, and shows the vectors that
 * stand behind it.
 */
#include "console.h"

void verdict_fill(verdict *v, dls_status status, int lcp) {
  v->says = v->next = NULL;
  v->exact = status == DLS_NO_SOLUTION;
  if (v->motion) {
    v->says = "no equilibrium (proved)";
    v->next =
        v->mover < 0
            ? "Joints contradict each other. --proof prints a number for each joint that takes "
              "part; these ask for different lengths of the same motion."
            : "Nothing holds a body: it moves rigidly with the loads, and no contact stops "
              "it. --proof prints the motion. Is a support or a load missing?";
  } else if (status == DLS_NO_SOLUTION) {
    v->says = "no solution (proved)";
    v->next =
        lcp ? "No z >= 0 has M z + q >= 0. Look for the mistake in the rows with v > 0, which "
              "--proof prints."
            : "No reactions keep all contacts apart. Change gaps, loads, supports or friction of "
              "the contacts with v > 0, which --proof prints.";
  } else if (status == DLS_NO_SOLUTION_LIKELY) {
    v->says = "no solution likely";
    v->next =
        v->ray ? "The reactions grow without bound in the direction that --proof prints. Look for "
                 "contacts that jam or are squeezed there. Lower their friction, or make the "
                 "bodies softer."
        : v->farkas ? "Up to rounding no reactions keep all contacts apart. Look at the contacts "
                      "with v > 0, which --proof prints."
                    : "No states of the contacts have a solution, or it is too large to be "
                      "certified. Look for contacts that jam or are squeezed. Lower their "
                      "friction, or make the bodies softer.";
  } else if (status == DLS_RAY && v->farkas) {
    v->says = "ray (to rounding)";
    v->next = lcp ? "Up to rounding there is no solution, which proves nothing. Give exact numbers "
                    "(fractions), or look at the rows with v > 0, which --proof prints."
                  : "Up to rounding there is no solution, which proves nothing. Look at the "
                    "contacts with v > 0, which --proof prints, or try --method auto.";
  } else if (status == DLS_RAY) {
    v->says = "ray: Lemke's method stopped without an answer";
    v->next =
        lcp ? "A solution may or may not exist (none if M is positive semidefinite). Try another "
              "form of the problem, or other units of rows and columns."
            : "A solution may or may not exist. Try --method auto, which uses other methods.";
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
    print_rows(v->exact ? "proof v:" : "v, a proof up to rounding:", v->rows, 1, v->farkas);
  if (v->motion)
    print_rows(v->mover < 0 ? "multipliers:" : "rigid motion:", v->unknowns, 1, v->motion);
  if (v->ray) print_rows("ray:", v->rows, v->stride, v->ray);
}
