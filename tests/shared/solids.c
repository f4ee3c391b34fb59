/* solids.c: elastic solids and their contacts. */
#include "solids.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

void solids_new(solids *S, int d, int nodes, int contacts) {
  *S = (solids){.d = d};
  const size_t near = d == 2 ? 4 * 36 : 8 * 300; /* entries of the elements around a node */
  const int n = d * nodes;
  ck_assert(!dlsi_triplets_alloc(n, n, near * (size_t)nodes + (size_t)n, &S->K, NULL));
  const size_t most = 18 * (size_t)contacts + 1;
  ck_assert(!dlsi_triplets_alloc(n, contacts, most, &S->N, NULL));
  ck_assert(!dlsi_triplets_alloc(n, (d - 1) * contacts, most, &S->T, NULL));
  S->f = calloc((size_t)n, sizeof *S->f);
  S->g = calloc((size_t)(d * contacts) + 1, sizeof *S->g);
  ck_assert(S->f && S->g);
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

/* Adds the stiffness of one element. node: 2^d; x: its coordinates, d each; corner k has the bits
 * of k as its place. */
static void add_element(solids *S, const int *node, const double *x, double stiff) {
  const int d = S->d, corners = 1 << d, size = d * corners;
  const double nu = .3, lambda = stiff * nu / ((1 + nu) * (1 - 2 * nu)), G = stiff / (2 * (1 + nu)),
               at = 1 / sqrt(3);
  double A[24][24] = {{0}};
  for (int point = 0; point < corners; point++) {
    double dN[8][3] = {{0}}, J[3][3] = {{0}}, I[3][3] = {{0}}, D[8][3] = {{0}};
    for (int c = 0; c < corners; c++)
      for (int k = 0; k < d; k++) {
        double v = 1;
        for (int l = 0; l < d; l++) {
          const double s = c >> l & 1 ? 1 : -1, xi = point >> l & 1 ? at : -at;
          v *= l == k ? s / 2 : (1 + s * xi) / 2;
        }
        dN[c][k] = v;
        for (int l = 0; l < d; l++)
          J[k][l] += v * x[d * c + l];
      }
    double det;
    if (d == 2) {
      det = J[0][0] * J[1][1] - J[0][1] * J[1][0];
      I[0][0] = J[1][1] / det;
      I[1][1] = J[0][0] / det;
      I[0][1] = -J[0][1] / det;
      I[1][0] = -J[1][0] / det;
    } else {
      det = J[0][0] * J[1][1] * J[2][2]; /* boxes along the axes */
      for (int k = 0; k < 3; k++)
        I[k][k] = 1 / J[k][k];
    }
    ck_assert(det > 0);
    for (int c = 0; c < corners; c++)
      for (int k = 0; k < d; k++)
        for (int l = 0; l < d; l++)
          D[c][k] += I[k][l] * dN[c][l];
    for (int a = 0; a < corners; a++)
      for (int b = 0; b < corners; b++) {
        double dot = 0;
        for (int k = 0; k < d; k++)
          dot += D[a][k] * D[b][k];
        for (int k = 0; k < d; k++)
          for (int l = 0; l < d; l++)
            A[d * a + k][d * b + l] +=
                det * (lambda * D[a][k] * D[b][l] + G * D[a][l] * D[b][k] + (k == l ? G * dot : 0));
      }
  }
  for (int i = 0; i < size; i++)
    for (int j = 0; j < size; j++) {
      const int p = d * node[i / d] + i % d, q = d * node[j / d] + j % d;
      if (p >= q) dlsi_triplets_add(&S->K, p, q, A[i][j]);
    }
}

static int add_block(solids *S, const int count[3], const double *x, double stiff) {
  const int d = S->d, corners = 1 << d, first = S->nodes;
  const int nx = count[0], ny = count[1], nz = d == 3 ? count[2] : 1;
  S->nodes += (nx + 1) * (ny + 1) * (d == 3 ? nz + 1 : 1);
  ck_assert_int_le(d * S->nodes, S->K.rows);
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
        add_element(S, node, at, stiff);
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
  const int d = S->d, c = S->contacts++;
  double e[3][3] = {{0}};
  memcpy(e[0], normal, (size_t)d * sizeof *normal);
  if (d == 2) {
    e[1][0] = normal[1];
    e[1][1] = -normal[0];
  } else {
    const int k = fabs(normal[0]) < .8 ? 0 : 1; /* the axis to make the first tangent of */
    double length = 0;
    for (int i = 0; i < 3; i++) {
      e[1][i] = (i == k) - normal[k] * normal[i];
      length += e[1][i] * e[1][i];
    }
    for (int i = 0; i < 3; i++)
      e[1][i] /= sqrt(length);
    for (int i = 0; i < 3; i++)
      e[2][i] = normal[(i + 1) % 3] * e[1][(i + 2) % 3] - normal[(i + 2) % 3] * e[1][(i + 1) % 3];
  }
  for (int i = 0; i < d; i++)
    for (int k = 0; k < d; k++) {
      dlsi_triplets *t = i ? &S->T : &S->N;
      const int column = i ? (d - 1) * c + i - 1 : c;
      if (e[i][k] == 0) continue;
      dlsi_triplets_add(t, d * node + k, column, e[i][k]);
      if (other >= 0) dlsi_triplets_add(t, d * other + k, column, -e[i][k]);
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
  ck_assert(!dlsi_columns_compress(&S->K, 1, DLSI_ALL, &S->Kc, NULL));
  ck_assert(!dlsi_columns_compress(&S->N, 1, DLSI_ALL, &S->Nc, NULL));
  ck_assert(!dlsi_columns_compress(&S->T, 1, DLSI_ALL, &S->Tc, NULL));
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

void solids_pad(solids *S, int nx, int ny) {
  solids_new(S, 2, (nx + 1) * (ny + 1), nx);
  solids_block(S, (int[]){nx, ny, 1}, 1);
  for (int j = 0; j <= ny; j++)
    for (int k = 0; k < 2; k++)
      solids_spring(S, nx + (nx + 1) * j, k, 1e3);
  for (int i = 0; i <= nx; i++) {
    const int top = i + (nx + 1) * ny;
    const double s = (double)i / nx, wave = sin(11 * pi * s);
    solids_spring(S, top, 0, .05);
    solids_spring(S, top, 1, .05);
    S->f[2 * top] = 2.5e-3 * sin(9 * pi * s);
    S->f[2 * top + 1] =
        wave > -.6 ? -1e-2 * (1 + .5 * cos(40 * s) * (sin(7 * s) > 0 ? 1 : -1)) : 8e-3;
    if (i < nx) solids_contact(S, i, -1, (double[]){0, 1}, 0);
  }
  (void)solids_model(S);
}

void solids_plate(solids *S, int nx, int nz) {
  const int layer = (nx + 1) * (nx + 1);
  solids_new(S, 3, layer * (nz + 1), layer);
  solids_block(S, (int[]){nx, nx, nz}, 1);
  for (int i = 0; i <= nx; i++)
    for (int j = 0; j <= nx; j++) {
      const int bottom = i + (nx + 1) * j, top = bottom + layer * nz;
      const double x = (double)i / nx, y = (double)j / nx;
      for (int k = 0; k < 3; k++)
        solids_spring(S, top, k, .05);
      S->f[3 * top] = 2.5e-3 * sin(8 * x + 3 * y);
      S->f[3 * top + 1] = 2e-3 * cos(6 * x - 7 * y);
      S->f[3 * top + 2] =
          -1e-2 * (1 + .5 * cos(13 * x + 7 * y)) + (sin(9 * x - 5 * y) < -.55 ? 1.8e-2 : 0);
      solids_contact(S, bottom, -1, (double[]){0, 0, 1}, 0);
    }
  (void)solids_model(S);
}

void solids_strip(solids *S, int nx, int ny) {
  solids_new(S, 2, (nx + 1) * (ny + 1), nx);
  solids_block(S, (int[]){nx, ny, 1}, 1);
  for (int j = 0; j <= ny; j++)
    for (int k = 0; k < 2; k++)
      solids_spring(S, (nx + 1) * j, k, 1e3);
  for (int i = 0; i <= nx; i++) {
    const int top = i + (nx + 1) * ny;
    const double s = (double)i / nx;
    S->f[2 * top] = 2.5e-3 * sin(28 * s);
    S->f[2 * top + 1] = -1e-2 * (1 + .5 * cos(40 * s)) + (sin(34 * s) < -.6 ? 1.8e-2 : 0);
    if (i > 0) solids_contact(S, i, -1, (double[]){0, 1}, 0);
  }
  (void)solids_model(S);
}

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
