/* faces.c: the weighting P of a rectangular grid of faces, as faces.h describes it. */
#include "faces.h"

#include <stdlib.h>

#include "delassus/reduction.h"

/* The P of a line. */
typedef struct line_columns {
  int count, *p, *i;
  double *x, *length;
} line_columns;

static int line_create(line_columns *P, const face_line *line) {
  const int n = line->nodes;
  *P = (line_columns){.p = calloc(5 * (size_t)n + 1, sizeof *P->p),
                      .x = calloc(5 * (size_t)n, sizeof *P->x)};
  if (!P->p || !P->x) return -1;
  P->i = P->p + n + 1;
  P->length = P->x + 4 * n;
  if (n == 1) {
    P->count = P->p[1] = 1;
    P->x[0] = P->length[0] = 1;
    return 0;
  }
  return (line->order == 1 ? dls_weighting_line(n, line->s, line->candidate, P->p, P->i, P->x,
                                                P->length, &P->count, NULL)
                           : dls_weighting_quadratic(n, line->s, line->candidate, P->p, P->i, P->x,
                                                     P->length, &P->count, NULL));
}

int faces_weighting(const face_line *first, const face_line *second, int *p, int *i, double *x,
                    double *area) {
  line_columns A, B = {0};
  int e = 0, count = -1;
  if (line_create(&A, first) || line_create(&B, second)) goto end;
  count = p[0] = 0;
  for (int b = 0; b < B.count; b++)
    for (int a = 0; a < A.count; a++) {
      for (int l = B.p[b]; l < B.p[b + 1]; l++)
        for (int k = A.p[a]; k < A.p[a + 1]; k++) {
          i[e] = A.i[k] + first->nodes * B.i[l];
          x[e++] = A.x[k] * B.x[l];
        }
      area[count++] = A.length[a] * B.length[b];
      p[count] = e;
    }
end:
  free(A.p);
  free(A.x);
  free(B.p);
  free(B.x);
  return count;
}
