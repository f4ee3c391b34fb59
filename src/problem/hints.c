/* hints.c: says on stderr what is plausible and wrong in the matrices of a host code. A hint
 * refuses nothing. */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>

#include "hints.h"

static void hint(const char *format, ...) __attribute__((format(printf, 1, 2)));
static void hint(const char *format, ...) {
  char text[300];
  va_list args;
  if (is_quiet()) return;
  va_start(args, format);
  (void)vsnprintf(text, sizeof text, format, args);
  va_end(args);
  (void)complain("hint: %s", text);
}

/* Returns the product of column a of A and column b of B. dense: scratch of A->rows zeros, left so.
 */
static double column_product(const dls_sparse *A, int a, const dls_sparse *B, int b,
                             double *dense) {
  double sum = 0;
  for (int k = A->p[a]; k < A->p[a + 1]; k++)
    dense[A->i[k]] += A->x[k];
  for (int k = B->p[b]; k < B->p[b + 1]; k++)
    sum += B->x[k] * dense[B->i[k]];
  for (int k = A->p[a]; k < A->p[a + 1]; k++)
    dense[A->i[k]] = 0;
  return sum;
}

/* A node on a surface of the other body has 1 + sum N_i^2 <= 2 for the square of the length. */
static const double shortest = 0.999, longest = 1.415, least_angle = 1e-6;

int model_is_nodal(const dls_model *model) {
  const int rigid = 3 * (model->d - 1), dense = model->K.a != NULL;
  int most = 0;
  if (!dense && !model->Ks.p) return 1;
  for (int j = 0; j < model->n; j++) {
    const int from = dense ? 0 : model->Ks.p[j], to = dense ? model->n : model->Ks.p[j + 1];
    double diagonal = 0;
    int count = 0;
    for (int k = from; k < to; k++) {
      const double x =
          dense ? model->K.a[(size_t)k + (size_t)j * (size_t)model->K.ld] : model->Ks.x[k];
      count += x != 0;
      if ((dense ? k : model->Ks.i[k]) == j) diagonal += x;
    }
    if (diagonal == 0) return 0;
    most = count > most ? count : most;
  }
  return most > rigid || model->n % rigid;
}

void hint_operators(const dls_model *model) {
  if (!model_is_nodal(model)) return;
  const dls_sparse *N = &model->HN, *T = &model->HT;
  double *dense = calloc((size_t)model->n + 1, sizeof *dense);
  int stretched = -1, leaning = -1, count = 0, leans = 0;
  double length = 0, cosine = 0;
  for (int c = 0; dense && c < model->nodes; c++) {
    const double n = sqrt(column_product(N, c, N, c, dense));
    if (n > 0 && !(n >= shortest && n <= longest)) {
      if (count++ == 0) stretched = c, length = n;
    }
    for (int i = 0; i < model->d - 1; i++) {
      const int j = (model->d - 1) * c + i;
      const double t = sqrt(column_product(T, j, T, j, dense));
      const double along = column_product(N, c, T, j, dense);
      if (fabs(along) > least_angle * n * t && leans++ == 0) leaning = c, cosine = along / (n * t);
    }
  }
  free(dense);
  if (count)
    hint("H_N: the normal of contact %d has length %.3g, as have %d of %d; a normal has length 1, "
         "apart from rotations",
         stretched, length, count, model->nodes);
  if (leans)
    hint("H_T: the tangent of contact %d is not perpendicular to its normal (cosine %.2g)", leaning,
         cosine);
}

void hint_gaps(const double *g, int d, int nodes) {
  double least = 0;
  for (int c = 0; c < nodes; c++) {
    if (!(g[d * c] < 0)) return;
    least = fmin(least, g[d * c]);
  }
  if (nodes)
    hint(
        "--g: all gaps are negative (the least %.3g): the bodies overlap everywhere at rest; a gap "
        "is positive where they are apart",
        least);
}

void hint_answer(const problem *p, const double *r) {
  const int d = p->contact.d, nc = p->contact.nc;
  const double *q = p->contact.q;
  double normal = 0, tangent = 0, sum = 0;
  int loaded = 0;
  for (int k = 0; k < p->model.n && p->f; k++)
    loaded |= p->f[k] != 0;
  for (int c = 0; c < nc; c++)
    if (r[d * c] != 0) return;
  if (!loaded || nc == 0) return;
  for (int c = 0; !p->on_K && d == 2 && c < nc; c++) {
    normal = fmax(normal, fabs(q[2 * c]));
    tangent += fabs(q[2 * c + 1]);
    sum += q[2 * c + 1];
  }
  /* along the tangents all contacts go one way, and farther than along the normals */
  if (tangent > 0 && fabs(sum) == tangent && tangent > 2 * nc * normal)
    hint("nothing presses, and the loads move the contacts along H_T: are H_N and H_T "
         "exchanged?");
  else
    hint("nothing presses although unknowns are loaded: check the signs of the loads and of the "
         "normals, which point from the obstacle into the body");
}

void hint_size(const dls_fe_mesh *mesh, const double *displacement) {
  double lo[2], hi[2];
  mesh_box(mesh->nodes, mesh->xy, NULL, lo, hi);
  const double size = fmax(hi[0] - lo[0], hi[1] - lo[1]);
  const double most = largest_entry(displacement, 2 * mesh->nodes);
  if (most > size)
    hint("the largest displacement, %.3g, exceeds the size of the body, %.3g: check the units of "
         "Young's modulus and of the loads",
         most, size);
}
