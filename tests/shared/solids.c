/* solids.c: elastic solids and their contacts. */
#include "solids.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* Ends the program without memory, or room. */
static void need(int good) {
  if (!good) abort();
}

void solids_new(solids *S, int d, int nodes, int contacts) {
  *S = (solids){.d = d};
  const size_t each = d == 2 ? 36 : 300; /* entries of an element; there are fewer than nodes */
  const int n = d * nodes;
  need(!dlsi_triplets_alloc(n, n, each * (size_t)nodes + 2 * (size_t)n, &S->K, NULL));
  const size_t most = 18 * (size_t)contacts + 1;
  need(!dlsi_triplets_alloc(n, contacts, most, &S->N, NULL));
  need(!dlsi_triplets_alloc(n, (d - 1) * contacts, most, &S->T, NULL));
  S->f = calloc((size_t)n, sizeof *S->f);
  S->g = calloc((size_t)(d * contacts) + 1, sizeof *S->g);
  need(S->f && S->g);
}

void solids_free(solids *S) {
  dlsi_triplets_free(&S->K);
  dlsi_triplets_free(&S->N);
  dlsi_triplets_free(&S->T);
  dlsi_columns_free(&S->Kc);
  dlsi_columns_free(&S->Nc);
  dlsi_columns_free(&S->Tc);
  free(S->f);
  free(S->g);
}

/* Gives dN/dx (corners x d) at point p of the element with corners x, and returns the volume that
 * belongs to it. Bit l of a corner's or point's number is its side in direction l. */
static double element_gradients(int d, const double *x, int p, double (*dN)[3]) {
  const int corners = 1 << d;
  const double at = 1 / sqrt(3);
  double local[8][3], J[3][3] = {{0}}, I[3][3] = {{0}};
  for (int c = 0; c < corners; c++)
    for (int k = 0; k < d; k++) {
      local[c][k] = 1;
      for (int l = 0; l < d; l++) {
        const double side = c >> l & 1 ? 1 : -1, xi = p >> l & 1 ? at : -at;
        local[c][k] *= l == k ? side / 2 : (1 + side * xi) / 2;
      }
      for (int l = 0; l < d; l++)
        J[k][l] += local[c][k] * x[d * c + l];
    }
  if (d == 2) J[2][2] = 1;
  double det = 0;
  for (int k = 0; k < 3; k++)
    for (int l = 0; l < 3; l++) {
      const int k1 = (k + 1) % 3, k2 = (k + 2) % 3, l1 = (l + 1) % 3, l2 = (l + 2) % 3;
      I[l][k] = J[k1][l1] * J[k2][l2] - J[k1][l2] * J[k2][l1]; /* cofactors */
      if (k == 0) det += J[0][l] * I[l][0];
    }
  for (int c = 0; c < corners; c++)
    for (int k = 0; k < d; k++) {
      dN[c][k] = 0;
      for (int l = 0; l < d; l++)
        dN[c][k] += I[k][l] / det * local[c][l];
    }
  return fabs(det);
}

void solids_stiffness(int d, const double *x, double E, double nu, double *A) {
  const int corners = 1 << d, size = d * corners;
  const double lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), G = E / (2 * (1 + nu));
  double dN[8][3];
  memset(A, 0, (size_t)(size * size) * sizeof *A);
  for (int p = 0; p < corners; p++) {
    const double volume = element_gradients(d, x, p, dN);
    for (int a = 0; a < corners; a++)
      for (int b = 0; b < corners; b++) {
        double dot = 0;
        for (int k = 0; k < d; k++)
          dot += dN[a][k] * dN[b][k];
        for (int k = 0; k < d; k++)
          for (int l = 0; l < d; l++)
            A[d * a + k + size * (d * b + l)] +=
                volume *
                (lambda * dN[a][k] * dN[b][l] + G * dN[a][l] * dN[b][k] + (k == l ? G * dot : 0));
      }
  }
}

void solids_element(solids *S, const int *node, const double *x, double stiff) {
  const int d = S->d, size = d << d;
  double A[24 * 24];
  solids_stiffness(d, x, stiff, .3, A);
  for (int a = 0; a < size; a++)
    for (int b = 0; b < size; b++) {
      const int i = d * node[a / d] + a % d, j = d * node[b / d] + b % d;
      if (i >= j) dlsi_triplets_add(&S->K, i, j, A[a + size * b]);
    }
}

static int add_block(solids *S, const int count[3], const double *x, double stiff) {
  const int d = S->d, corners = 1 << d, first = S->nodes;
  const int nx = count[0], ny = count[1], nz = d == 3 ? count[2] : 1;
  S->nodes += (nx + 1) * (ny + 1) * (d == 3 ? nz + 1 : 1);
  need(d * S->nodes <= S->K.rows);
  for (int k = 0; k < nz; k++)
    for (int j = 0; j < ny; j++)
      for (int i = 0; i < nx; i++) {
        int node[8];
        double at[24];
        for (int c = 0; c < corners; c++) {
          const int p[3] = {i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1)};
          const int local = p[0] + (nx + 1) * (p[1] + (ny + 1) * p[2]);
          node[c] = first + local;
          for (int l = 0; l < d; l++)
            at[d * c + l] = x ? x[d * local + l] : p[l];
        }
        solids_element(S, node, at, stiff);
      }
  return first;
}

int solids_block(solids *S, const int count[3], double stiff) {
  return add_block(S, count, NULL, stiff);
}

int solids_mapped(solids *S, const int count[3], const double *x, double stiff) {
  return add_block(S, count, x, stiff);
}

void solids_spring(solids *S, int node, int k, double stiffness) {
  dlsi_triplets_add(&S->K, S->d * node + k, S->d * node + k, stiffness);
}

void solids_contact(solids *S, int node, int other, const double *normal, double gap) {
  solids_contact_on(S, node, other >= 0, &other, (double[]){1}, normal, gap);
}

void solids_contact_on(solids *S, int node, int count, const int *other, const double *part,
                       const double *normal, double gap) {
  const int d = S->d, c = S->contacts++;
  double e[3][3] = {{0}};
  memcpy(e[0], normal, (size_t)d * sizeof *normal);
  if (d == 2) {
    e[1][0] = normal[1];
    e[1][1] = -normal[0];
  } else {
    const int k = fabs(e[0][0]) < .8 ? 0 : 1; /* the axis to make the first tangent of */
    double length = 0;
    for (int i = 0; i < 3; i++) {
      e[1][i] = (i == k) - e[0][k] * e[0][i];
      length += e[1][i] * e[1][i];
    }
    for (int i = 0; i < 3; i++)
      e[1][i] /= sqrt(length);
    for (int i = 0; i < 3; i++)
      e[2][i] = e[0][(i + 1) % 3] * e[1][(i + 2) % 3] - e[0][(i + 2) % 3] * e[1][(i + 1) % 3];
  }
  for (int i = 0; i < d; i++)
    for (int k = 0; k < d; k++) {
      dlsi_triplets *t = i ? &S->T : &S->N;
      const int column = i ? (d - 1) * c + i - 1 : c;
      if (e[i][k] == 0) continue;
      dlsi_triplets_add(t, d * node + k, column, e[i][k]);
      for (int o = 0; o < count; o++)
        if (part[o] != 0) dlsi_triplets_add(t, d * other[o] + k, column, -part[o] * e[i][k]);
    }
  S->g[d * c] = gap;
}

const dls_model *solids_model(solids *S) {
  const int n = S->d * S->nodes;
  S->K.rows = S->K.cols = S->N.rows = S->T.rows = n;
  S->N.cols = S->contacts;
  S->T.cols = (S->d - 1) * S->contacts;
  dlsi_columns_free(&S->Kc); /* of an earlier call */
  dlsi_columns_free(&S->Nc);
  dlsi_columns_free(&S->Tc);
  need(!dlsi_columns_compress(&S->K, 1, DLSI_ALL, &S->Kc, NULL));
  need(!dlsi_columns_compress(&S->N, 1, DLSI_ALL, &S->Nc, NULL));
  need(!dlsi_columns_compress(&S->T, 1, DLSI_ALL, &S->Tc, NULL));
  S->model = (dls_model){.d = S->d,
                         .n = n,
                         .nodes = S->contacts,
                         .operator_kind = DLS_STIFFNESS_SPARSE,
                         .factorization = DLS_CHOLESKY,
                         .Ks = dlsi_columns_view(&S->Kc),
                         .HN = dlsi_columns_view(&S->Nc),
                         .HT = dlsi_columns_view(&S->Tc)};
  return &S->model;
}

/* ---- scenes ---------------------------------------------------------------------------------- */

void solids_stack(solids *S, int d, int count, int side, double push) {
  const int sides[3] = {side, side, side}, across = d == 2 ? side + 1 : (side + 1) * (side + 1);
  const int each = across * (side + 1);
  const double up[3] = {0, d == 2, d == 3};
  solids_new(S, d, each * count, across * count);
  for (int b = 0; b < count; b++) {
    const int first = solids_block(S, sides, 1 + b % 3);
    for (int k = 0; k < each; k++)
      S->f[d * (first + k) + d - 1] = -1e-3 / each;
    for (int k = 0; k < across; k++)
      solids_contact(S, first + k, b ? first - across + k : -1, up, 0);
  }
  const int top = each * (count - 1); /* its block alone is pushed, at its foot */
  for (int k = 0; k < across; k++)
    S->f[d * (top + k)] = push * .3 * 1e-3 / across;
  (void)solids_model(S);
}

void solids_arch(solids *S, int stones, double thick) {
  enum { nx = 2, ny = 3, each = (nx + 1) * (ny + 1) };
  solids_new(S, 2, each * stones, (ny + 1) * (stones + 1));
  for (int b = 0; b < stones; b++) {
    double x[2 * each];
    for (int j = 0; j <= ny; j++)
      for (int i = 0; i <= nx; i++) {
        const double angle = pi - pi * (b + (double)i / nx) / stones;
        const double radius = 1 + thick * ((double)j / ny - .5);
        x[2 * (i + (nx + 1) * j)] = radius * cos(angle);
        x[2 * (i + (nx + 1) * j) + 1] = radius * sin(angle);
      }
    const int first = solids_mapped(S, (int[]){nx, ny, 1}, x, 1e4);
    for (int k = 0; k < each; k++)
      S->f[2 * (first + k) + 1] = -1. / (stones * each);
    /* column 0 is the side of the stone before, column nx that of the next one */
    const double angle = pi - pi * b / stones;
    const double normal[2] = {sin(angle), -cos(angle)};
    for (int j = 0; j <= ny; j++)
      solids_contact(S, first + (nx + 1) * j, b ? first - each + nx + (nx + 1) * j : -1, normal, 0);
  }
  for (int j = 0; j <= ny; j++)
    solids_contact(S, each * (stones - 1) + nx + (nx + 1) * j, -1, (double[]){0, 1}, 0);
  (void)solids_model(S);
}

void solids_apply(const dls_model *model, const double *R, const double *x, double *y) {
  const dls_sparse *K = &model->Ks;
  const int d = model->d;
  memset(y, 0, (size_t)model->n * sizeof *y);
  for (int j = 0; j < K->cols; j++)
    for (int e = K->p[j]; e < K->p[j + 1]; e++) {
      y[K->i[e]] += K->x[e] * x[j];
      if (K->i[e] != j) y[j] += K->x[e] * x[K->i[e]];
    }
  for (int k = 0; k < d * model->nodes; k++) {
    const dls_sparse *L = k % d ? &model->HT : &model->HN;
    const int column = k % d ? (d - 1) * (k / d) + k % d - 1 : k / d;
    double sum = 0;
    for (int e = L->p[column]; e < L->p[column + 1]; e++)
      sum += L->x[e] * x[L->i[e]];
    for (int e = L->p[column]; e < L->p[column + 1]; e++)
      y[L->i[e]] += R[k] * L->x[e] * sum;
  }
}
