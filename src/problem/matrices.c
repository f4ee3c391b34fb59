/*
 * matrices.c: makes a contact problem of the matrices that a host code has written into files:
 *
 *   --stiffness or --flexibility, --HN and --HT (or --H, or --nodes), --f, --g   to be condensed
 *   --W, --q                                                                     condensed already
 *
 * docs/files.md says what each file holds.
 */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "contact/contact.h"
#include "hints.h"
#include "matrices.h"

/* The arrays that the model and the problem borrow, and CalculiX's numbering. */
struct matrices {
  sparse Ks, HN, HT, P;
  double *K, *f, *g, *q, *mu;
  int *node, *direction;             /* of each unknown, from 1; or NULL */
  int *place;                        /* node of each contact, from 1; or NULL */
  double *X;                         /* coordinates, 3 a row, or NULL */
  int rows, *row_node, *row_contact; /* of X: rows, their nodes, their contacts or -1 */
  int most_node, *row_of;            /* the row of each node up to most_node, or -1 */
};

/* ---- options --------------------------------------------------------------------------------- */

const char *matrices_name(const matrix_options *o) {
  return o->stiffness ? o->stiffness : o->flexibility ? o->flexibility : o->W;
}

int matrices_given(const matrix_options *o) {
  return matrices_name(o) || o->H || o->HN || o->HT || o->nodes || o->f || o->q || o->g || o->mu ||
         o->weights || o->dim;
}

void source_usage(FILE *out) {
  fputs(
      "      --step=N          of a scene in steps, the contact problem of step N (the last step\n"
      "                        where as many contacts touch as in any)\n\n"
      "Matrices of a host code, K x = f + H r, u = H^T x + g (the guide, 'Files', lists the\n"
      "formats: Matrix Market, .npy, .npz, text, Abaqus, CalculiX, Harwell-Boeing, PETSc, ...).\n"
      "Units are yours: r has that of f, gaps, u and x that of K^-1 f.\n"
      "      --stiffness=K     n x n, sparse or dense; CalculiX's job.sti, with job.dof beside it\n"
      "      --flexibility=F   K^-1, n x n, instead of K\n"
      "      --HN=N --HT=T     n x nodes and n x (d-1) nodes, the normals and the tangents; "
      "normals\n"
      "                        point from the obstacle into the body\n"
      "      --H=H             both: columns (n, t) or (n, t, s) of each contact node\n"
      "      --nodes=LIST      both, from rows 'node n_x n_y [n_z]', 'x y [z]' may stand behind;\n"
      "                        nodes are numbered from 1, as in job.dof; otherwise unknown\n"
      "                        d (node - 1) + k is direction k. Beside --HN or --H: coordinates,\n"
      "                        rows 'x y [z]' of all nodes, or 'node x y [z]'\n"
      "      --f=F             n loads; with --nodes also rows 'node direction value'\n"
      "      --g=G             gaps: a number, one or d for each contact node; 0 without it\n"
      "      --mu=MU           friction: a number (inf: no slip) or one for each candidate\n"
      "      --weights=P       nodes x candidates, the weighting of the reactions\n"
      "      --W=W --q=Q       the condensed problem u = W r + q itself, instead of K, H, f, g\n"
      "      --triplets        a text of K, H or P holds lines 'row column value' (MATLAB's [i j "
      "x],\n"
      "                        Abaqus COORDINATE), from 0 if an index is 0, else from 1\n"
      "      --dim=D           2 or 3, if the sizes do not determine it; 1: normals alone\n"
      "      --on=W|K          solve on the Delassus matrix W, or on K itself (also for bodies "
      "that\n"
      "                        contact alone holds); default: the lower estimated cost\n",
      out);
}

/* Checks which matrices go together. */
static int check_matrices(const matrix_options *o) {
  const int operators = (o->stiffness != NULL) + (o->flexibility != NULL) + (o->W != NULL);
  const int traces = (o->H != NULL) + (o->HN != NULL) + (o->nodes && !o->H && !o->HN);
  if (o->dim > 3)
    complain("--dim: %d is not 1, 2 or 3", o->dim);
  else if (operators != 1)
    complain("give one of --stiffness, --flexibility and --W");
  else if (o->W && (traces || o->HT || o->f || o->g || o->weights || o->on == DLS_ON_K))
    complain("--W: goes with --q, --mu and --dim");
  else if (o->W && !o->q)
    complain("--W: needs --q");
  else if (!o->W && o->q)
    complain("--q: goes with --W");
  else if (!o->W && o->dim == 1)
    complain("--dim: 1 goes with --W; beside K, --HN without --HT is without friction");
  else if (!o->W && traces != 1)
    complain("give one of --HN, --H and --nodes with normals");
  else if (o->HT && !o->HN)
    complain("--HT: goes with --HN");
  else if (!o->mu && o->dim != 1 && (!o->HN || o->HT))
    complain("give --mu, 0 for no friction");
  else if (o->flexibility && o->on == DLS_ON_K)
    complain("--on=K: is for --stiffness");
  else
    return 1;
  return 0;
}

/* ---- vectors --------------------------------------------------------------------------------- */

/* Returns 1 if the text is a number, which is then no file's name. */
static int is_number(const char *text, double *value) {
  char *end;
  *value = strtod(text, &end);
  return end > text && !*end;
}

static size_t table_count(const table *t) {
  return (size_t)t->rows * (size_t)t->cols;
}

static double *new_vector(size_t count) {
  double *x = calloc(count ? count : 1, sizeof *x);
  if (!x) (void)complain("out of memory");
  return x;
}

/* Returns 1 if the table has one or the other number of entries; 0 after a complaint. */
static int holds(const char *option, const char *path, const table *t, int one, int other) {
  const size_t count = table_count(t);
  if (count == (size_t)one || count == (size_t)other) return 1;
  char or_other[24] = "";
  if (other != one) (void)snprintf(or_other, sizeof or_other, " or %d", other);
  return refuse("--%s: %s holds %zu number%s, must hold %d%s", option, path, count,
                plural((long long)count), one, or_other);
}

/* Reads the `count` numbers of q. */
static int read_q(const char *path, int count, double **q) {
  table t;
  const int good = table_read(path, &t) && holds("q", path, &t, count, count);
  *q = t.a; /* freed with the others */
  return good;
}

/* Returns 1 if the text names a file; 0 after a complaint that it is none and no number. */
static int is_file(const char *option, const char *text) {
  return access(input_path(text), F_OK) == 0 ||
         refuse_number(option, text, "neither a number nor a file");
}

/* Returns 1 for a friction that can be: >= 0, inf too; 0 after a complaint. c: candidate, or -1. */
static int check_friction(double mu, const char *text, int c) {
  if (mu >= 0) return 1;
  if (c < 0) return refuse("--mu: friction is %s, must be a number >= 0", text);
  return refuse("--mu: %s: the friction of contact %d is %g, must be a number >= 0", text, c, mu);
}

/* Reads the friction: one number for all candidates, or one each. */
static int read_friction(const char *text, int nc, double **mu) {
  double each = 0;
  table t = {0};
  *mu = new_vector((size_t)nc);
  int good = *mu != NULL;
  const int number = text && is_number(text, &each);
  if (good && number) good = check_friction(each, text, -1);
  if (good && text && !number)
    good = is_file("mu", text) && table_read(text, &t) && holds("mu", text, &t, 1, nc);
  for (int c = 0; good && c < nc; c++) {
    (*mu)[c] = !t.a ? each : table_count(&t) == 1 ? t.a[0] : t.a[c];
    if (t.a) good = check_friction((*mu)[c], text, c);
  }
  free(t.a);
  return good;
}

/* Reads the gaps of `nodes` contact nodes in local order; those of the normals alone may be given.
 */
static int read_gaps(const char *text, int d, int nodes, double **g) {
  double each = 0;
  table t = {0};
  *g = new_vector((size_t)d * (size_t)nodes);
  int good = *g != NULL, whole = 0;
  if (good && text && !is_number(text, &each)) {
    good = is_file("g", text) && table_read(text, &t) && holds("g", text, &t, nodes, d * nodes);
    whole = good && table_count(&t) == (size_t)d * (size_t)nodes;
  }
  for (int c = 0; good && c < nodes; c++)
    for (int i = 0; i < (whole ? d : 1); i++)
      (*g)[d * c + i] = !t.a ? each : whole ? t.a[d * c + i] : t.a[c];
  free(t.a);
  return good;
}

/* ---- the numbering --------------------------------------------------------------------------- */

/* Reads job.dof beside job.sti: lines node.direction, one for each of the n unknowns. */
static int read_numbering(const char *sti, int n, struct matrices *own) {
  char path[PATH_ROOM], line[64];
  if (strlen(sti) >= sizeof path) return refuse("%s: the name is too long", sti);
  strcpy(path, sti);
  strcpy(path + strlen(path) - 4, ".dof");
  FILE *file = fopen(path, "r");
  if (!file) return refuse("%s: cannot be opened, CalculiX writes it beside %s", path, sti);
  own->node = malloc((size_t)n * sizeof *own->node);
  own->direction = malloc((size_t)n * sizeof *own->direction);
  int good = own->node && own->direction ? 1 : refuse("out of memory"), k = 0;
  while (good && fgets(line, sizeof line, file)) {
    const char *at = line + strspn(line, " ");
    if (k >= n || !dlsi_read_whole(&at, 1, INT_MAX, &own->node[k]) || *at++ != '.' ||
        !dlsi_read_whole(&at, 0, 9, &own->direction[k]) || at[strspn(at, " \r\n")])
      good = refuse("%s: line %d is no node.direction of %d unknown%s", path, k + 1, n, plural(n));
    k++;
  }
  (void)fclose(file);
  if (good && k != n)
    good = refuse("%s: holds %d unknown%s, %s has %d", path, k, plural(k), sti, n);
  return good;
}

/* Takes the labels that Abaqus gives the n unknowns of K. */
static int take_labels(struct matrices *own, int n) {
  own->node = malloc((size_t)n * sizeof *own->node);
  own->direction = malloc((size_t)n * sizeof *own->direction);
  for (int k = 0; own->node && own->direction && k < n; k++) {
    own->node[k] = own->Ks.labels[2 * k];
    own->direction[k] = own->Ks.labels[2 * k + 1];
  }
  return (own->node && own->direction) || refuse("out of memory");
}

/* Returns the unknown of a node's direction k = 0, 1, ..: -1 if the node is held there, -2 if there
 * is no such node. */
static int find_unknown(const struct matrices *own, int d, int n, int node, int k) {
  if (!own->node) return node < 1 || node > n / d || k >= d ? -2 : d * (node - 1) + k;
  int known = -2;
  for (int e = 0; e < n; e++) {
    if (own->node[e] != node) continue;
    if (own->direction[e] == k + 1) return e;
    known = -1;
  }
  return known;
}

/* Reads the loads: n numbers, or, where nodes have numbers, rows (node, direction, value). */
static int read_loads(const char *path, int d, int n, int numbered, struct matrices *own) {
  table t;
  own->f = new_vector((size_t)n);
  if (!own->f) return 0;
  if (!path) return 1;
  int good = table_read(path, &t);
  const int whole = good && table_count(&t) == (size_t)n;
  if (good && !whole && !(numbered && t.cols == 3))
    good = refuse("--f: %s holds %zu number%s, must hold %d%s", path, table_count(&t),
                  plural((long long)table_count(&t)), n,
                  numbered ? ", or rows of node, direction and value" : "");
  for (int e = 0; whole && e < n; e++)
    own->f[e] = t.a[e];
  for (int i = 0; good && !whole && i < t.rows; i++) {
    const double *row = t.a + 3 * (size_t)i;
    const int is_place = row[0] >= 1 && row[0] < INT_MAX && row[1] >= 1 && row[1] <= d;
    const int e = is_place ? find_unknown(own, d, n, (int)row[0], (int)row[1] - 1) : -2;
    if (e == -2)
      good = refuse("--f: %s, row %d: there is no node %g with direction %g", path, i + 1, row[0],
                    row[1]);
    else if (e >= 0)
      own->f[e] += row[2]; /* a load where a node is held moves nothing */
  }
  free(t.a);
  return good;
}

/* ---- the operators H ------------------------------------------------------------------------- */

/* Copies the columns of H, (n, t[, s]) of each node, into H_N and H_T. */
static int split_columns(const dls_sparse *H, int d, sparse *HN, sparse *HT) {
  const int nodes = H->cols / d;
  const size_t count = (size_t)H->p[H->cols];
  if (!sparse_alloc(H->rows, nodes, count, HN) ||
      !sparse_alloc(H->rows, (d - 1) * nodes, count, HT))
    return 0;
  int at[2] = {0, 0}, col[2] = {0, 0};
  HN->p[0] = HT->p[0] = 0;
  for (int j = 0; j < H->cols; j++) {
    const int tangent = j % d > 0;
    sparse *to = tangent ? HT : HN;
    for (int k = H->p[j]; k < H->p[j + 1]; k++) {
      to->i[at[tangent]] = H->i[k];
      to->x[at[tangent]++] = H->x[k];
    }
    to->p[++col[tangent]] = at[tangent];
  }
  return 1;
}

/* Takes coordinates from columns `from`, .. of the table, nodes from column `label` (-1: 1, 2, ..).
 */
static int take_coordinates(const table *t, int label, int from, int d, struct matrices *own) {
  const size_t rows = (size_t)t->rows, cols = (size_t)t->cols;
  own->rows = t->rows;
  own->X = calloc(3 * rows, sizeof *own->X);
  own->row_node = malloc(2 * rows * sizeof *own->row_node);
  if (!own->X || !own->row_node) return refuse("out of memory");
  own->row_contact = own->row_node + rows;
  for (size_t i = 0; i < rows; i++) {
    const double node = label < 0 ? (double)i + 1 : t->a[i * cols + (size_t)label];
    if (!(node >= 1 && node < INT_MAX && node == (int)node))
      return refuse("--nodes: row %zu: %g is no number of a node", i + 1, node);
    own->row_node[i] = (int)node;
    own->row_contact[i] = -1;
    for (int k = 0; k < d; k++)
      own->X[3 * i + (size_t)k] = t->a[i * cols + (size_t)(from + k)];
  }
  return 1;
}

/* Reads the coordinates of --nodes beside --HN or --H: rows 'x y [z]' or 'node x y [z]'. *d: 2 or
 * 3, or 0 if H does not tell. */
static int read_coordinates(const char *path, int *d, int n, struct matrices *own) {
  table t;
  int good = table_read(path, &t);
  if (good && !*d && t.cols != 3) *d = t.cols == 2 ? 2 : 3;
  if (good && !*d) *d = n == 2 * t.rows ? 2 : 3; /* 3 columns: x y z, or node x y */
  if (good && t.cols != *d && t.cols != *d + 1)
    good = refuse("--nodes: %s has %d column%s, must have %s or 'node' before them", path, t.cols,
                  plural(t.cols), *d == 2 ? "'x y'" : "'x y z'");
  if (good && !own->node && t.cols == *d && t.rows * *d != n)
    good = refuse("--nodes: %s has %d row%s, K has %d unknowns: %d for each node are wanted", path,
                  t.rows, plural(t.rows), n, *d);
  if (good) good = take_coordinates(&t, t.cols == *d ? -1 : 0, t.cols - *d, *d, own);
  free(t.a);
  return good;
}

/* Makes H of a list of nodes and normals; directions in which a node is held have no entry. */
static int operators_of_nodes(const char *path, int n, struct matrices *own, int *d, sparse *H) {
  table t;
  int good = table_read(path, &t);
  if (good && t.cols != 3 && t.cols != 4 && t.cols != 5 && t.cols != 7)
    good = refuse("--nodes: %s has %d column%s, must have 'node n_x n_y [n_z]', and may have 'x y "
                  "[z]' behind",
                  path, t.cols, plural(t.cols));
  if (good) {
    *d = t.cols == 3 || t.cols == 5 ? 2 : 3;
    const size_t cols = (size_t)*d * (size_t)t.rows;
    good =
        cols <= INT_MAX / 3 ? sparse_alloc(n, (int)cols, 3 * cols, H) : refuse("--nodes: too many");
  }
  if (good)
    good = (own->place = calloc((size_t)t.rows, sizeof *own->place)) || refuse("out of memory");
  int entries = 0;
  for (int c = 0; good && c < t.rows; c++) {
    const double *row = t.a + (size_t)c * (size_t)t.cols;
    double frame[3][3] = {{row[1], row[2], *d == 3 ? row[3] : 0}};
    const int node = row[0] >= 1 && row[0] < INT_MAX ? (int)row[0] : 0;
    if (find_unknown(own, *d, n, node, 0) == -2)
      good = refuse("--nodes: %s, row %d: there is no node %g", path, c + 1, row[0]);
    else if (!dlsi_frame(*d, frame))
      good = refuse("--nodes: %s, row %d: has no normal", path, c + 1);
    own->place[c] = node;
    for (int i = 0; good && i < *d; i++) {
      H->p[*d * c + i] = entries;
      for (int k = 0; k < *d; k++) {
        const int e = find_unknown(own, *d, n, node, k);
        if (e < 0 || frame[i][k] == 0) continue;
        H->i[entries] = e;
        H->x[entries++] = frame[i][k];
      }
    }
  }
  if (good) H->p[H->view.cols] = entries;
  if (good && t.cols > 4) good = take_coordinates(&t, 0, *d + 1, *d, own);
  free(t.a);
  return good;
}

/* Tells the dimension from --dim, else from the numbers of friction or gaps beside the m columns
 * of H or rows of W; 0 after a complaint. */
static int find_dimension(const matrix_options *o, int m) {
  const char *const paths[] = {o->mu, o->g};
  double number;
  int d = o->dim;
  for (int k = 0; k < 2 && !d; k++) {
    table t = {0};
    if (!paths[k] || is_number(paths[k], &number) || !table_read(paths[k], &t)) continue;
    const size_t count = table_count(&t);
    if (count == (size_t)m && o->W) d = 1;
    if (2 * count == (size_t)m) d = 2;
    if (3 * count == (size_t)m) d = 3;
    free(t.a);
  }
  if (!d && (m % 2 == 0) != (m % 3 == 0)) d = m % 2 ? 3 : 2; /* the other one does not divide m */
  if (!d)
    complain("--dim: 2 or 3 is wanted: %d columns of H or rows of W fit %s", m,
             m % 6 ? "neither" : "both");
  else if (m % d)
    d = refuse("--dim: %d does not divide %d, the columns of H or rows of W", d, m);
  return d;
}

/* Checks the rows of an operator against the n unknowns of K. */
static int has_rows(const char *option, const char *path, dls_sparse *A, int n, int triplets) {
  if (triplets && A->rows < n) A->rows = n; /* the last unknowns have no entry */
  if (A->rows == n) return 1;
  return refuse("--%s: %s has %d row%s, must have %d", option, path, A->rows, plural(A->rows), n);
}

/* Makes an H_T without entries. */
static int empty_tangents(int n, struct matrices *own, dls_model *model) {
  const int cols = (model->d - 1) * model->nodes;
  sparse_free(&own->HT);
  if (!sparse_alloc(n, cols, 0, &own->HT)) return 0;
  memset(own->HT.p, 0, ((size_t)cols + 1) * sizeof *own->HT.p);
  model->HT = own->HT.view;
  return 1;
}

/* Reads H_N and H_T in one of the three ways; sets model->d and nodes. */
static int load_operators(const matrix_options *o, struct matrices *own, dls_model *model) {
  sparse H = {0};
  const int n = model->n;
  int good = 1, d = o->dim;
  if (o->HN) {
    good = sparse_read(o->HN, &own->HN) && has_rows("HN", o->HN, &own->HN.view, n, o->triplets);
    const int nodes = own->HN.view.cols;
    if (good && o->HT) {
      good = sparse_read(o->HT, &own->HT) && has_rows("HT", o->HT, &own->HT.view, n, o->triplets);
      const int cols = own->HT.view.cols;
      d = cols == 2 * nodes ? 3 : 2;
      if (good && nodes == 2 * cols)
        return refuse("--HT: %s has %d column%s, --HN %d: are --HN and --HT exchanged?", o->HT,
                      cols, plural(cols), nodes);
      if (good && (cols != (d - 1) * nodes || (o->dim && d != o->dim)))
        good = refuse("--HT: %s has %d column%s; --HN has %d, so %d or %d are wanted", o->HT, cols,
                      plural(cols), nodes, nodes, 2 * nodes);
    } else if (good) { /* no tangents */
      model->d = d = o->dim ? o->dim : 2;
      model->nodes = nodes;
      good = empty_tangents(n, own, model);
    }
  } else {
    if (!o->H)
      good = operators_of_nodes(o->nodes, n, own, &d, &H);
    else
      good = sparse_read(o->H, &H) && has_rows("H", o->H, &H.view, n, o->triplets) &&
             (d = find_dimension(o, H.view.cols)) > 0;
    if (good) good = split_columns(&H.view, d, &own->HN, &own->HT);
    if (good && o->dim && o->dim != d) good = refuse("--dim: the normals have %d parts", d);
    sparse_free(&H);
  }
  model->d = d;
  model->nodes = own->HN.view.cols;
  model->HN = own->HN.view;
  model->HT = own->HT.view;
  return good;
}

/* ---- K, W ------------------------------------------------------------------------------------ */

/* Reads a dense square matrix by columns. */
static int read_square(const char *option, const char *path, int *n, double **a) {
  table t;
  int good = table_read(path, &t);
  if (good && t.rows != t.cols)
    good = table_is_triplets(&t)
               ? refuse_triplets(path)
               : refuse("--%s: %s is %d x %d, must be square", option, path, t.rows, t.cols);
  if (good) good = (*a = table_by_columns(path, &t)) != NULL;
  *n = t.rows;
  free(t.a);
  return good;
}

/* Chooses the factorisation: Cholesky, or LDL^T where that fails, for a symmetric K (1; -1: after a
 * complaint). Refuses a triangle: half of a symmetric matrix, as many codes write it. */
static int choose_factorization(const char *path, int symmetric, const char *triangle,
                                dls_model *model) {
  if (!symmetric && triangle)
    return refuse("--stiffness: %s is %s triangle; half of a symmetric matrix goes as the lower "
                  "triangle of a Matrix Market file that says 'symmetric'",
                  path, triangle);
  model->factorization = symmetric ? DLS_CHOLESKY : DLS_LU;
  return symmetric >= 0;
}

static int load_stiffness(const char *path, struct matrices *own, dls_model *model) {
  const int is_sparse = array_is_sparse(path);
  if (is_sparse < 0) return 0;
  if (!is_sparse) {
    model->operator_kind = DLS_STIFFNESS_DENSE;
    if (!read_square("stiffness", path, &model->n, &own->K)) return 0;
    model->K = (dls_dense){model->n, model->n, model->n, own->K};
    return choose_factorization(path, dense_is_symmetric(model->n, own->K),
                                dense_triangle(model->n, own->K), model);
  }
  model->operator_kind = DLS_STIFFNESS_SPARSE;
  if (!sparse_read(path, &own->Ks)) return 0;
  model->Ks = own->Ks.view;
  model->n = model->Ks.rows;
  if (model->Ks.rows != model->Ks.cols)
    return refuse("--stiffness: %s is %d x %d, must be square", path, model->Ks.rows,
                  model->Ks.cols);
  if (!choose_factorization(path, sparse_is_symmetric(&model->Ks), sparse_triangle(&model->Ks),
                            model))
    return 0;
  if (own->Ks.labels) return take_labels(own, model->n);
  return !array_is_calculix(path) || read_numbering(path, model->n, own);
}

/* Reads the friction, of the same number of candidates each time. */
static int load_friction(const matrix_options *o, problem *p) {
  struct matrices *own = p->matrices;
  const int candidates = o->W ? p->contact.nc : o->weights ? p->model.P.cols : p->model.nodes;
  free(own->mu);
  if (!read_friction(o->mu, candidates, &own->mu)) return 0;
  for (int c = 0; o->HN && !o->HT && c < candidates; c++) /* without tangents there is none */
    if (own->mu[c] != 0) return refuse("--mu: friction needs the tangents, --HT");
  if (o->HN && !o->HT) p->model.mu = own->mu;
  p->mu = p->contact.mu = own->mu;
  return 1;
}

/* Reads f and g, or q. */
static int load_loads(const matrix_options *o, problem *p) {
  struct matrices *own = p->matrices;
  dls_model *model = &p->model;
  double **const old[] = {&own->f, &own->g, &own->q};
  for (int k = 0; k < 3; k++) {
    free(*old[k]);
    *old[k] = NULL;
  }
  if (o->W ? !read_q(o->q, p->contact.W.rows, &own->q)
           : !read_gaps(o->g, model->d, model->nodes, &own->g) ||
                 !read_loads(o->f, model->d, model->n, own->node || o->nodes, own))
    return 0;
  p->f = own->f;
  p->g = own->g;
  p->contact.q = own->q;
  return 1;
}

double *matrices_read_loads(const char *path, const matrix_options *o, const problem *p) {
  struct matrices *own = p->matrices;
  double *const kept = own->f;
  const int good = read_loads(path, p->model.d, p->model.n, own->node || o->nodes, own);
  double *f = own->f;
  own->f = kept;
  if (!good) free(f);
  return good ? f : NULL;
}

int matrices_load_data(const matrix_options *o, int loads, problem *p) {
  return load_friction(o, p) && (!loads || load_loads(o, p));
}

int friction_load(const matrix_options *o, problem *p) {
  if (!o->mu) return 1;
  free(p->friction);
  p->friction = NULL;
  if (!read_friction(o->mu, p->contact.nc, &p->friction)) return 0;
  p->mu = p->contact.mu = p->friction;
  return 1;
}

static int load_condensed(const matrix_options *o, problem *p) {
  struct matrices *own = p->matrices;
  int m = 0;
  if (!read_square("W", o->W, &m, &own->K)) return 0;
  const int d = find_dimension(o, m);
  if (!d) return 0;
  p->contact = (dls_contact){.d = d, .nc = m / d, .W = {m, m, m, own->K}};
  if (!o->dim)
    (void)snprintf(p->note, sizeof p->note,
                   "%dD: %d rows of --W for %d contacts; --dim says it otherwise", d, m, m / d);
  return matrices_load_data(o, 1, p);
}

/* ---- the problem ----------------------------------------------------------------------------- */

int unknown_place(const problem *p, int k, spot *at) {
  const struct matrices *own = p->matrices;
  const int d = p->model.d;
  *at = own->node ? (spot){own->node[k], own->direction[k] - 1, -1} : (spot){k / d + 1, k % d, -1};
  if (at->direction < 0 || at->direction > 2) return 0;
  if (own->X && at->node <= own->most_node && own->row_of[at->node] >= 0)
    at->row = own->row_of[at->node];
  return 1;
}

int places_known(const problem *p) {
  const struct matrices *own = p->matrices;
  return own->node || own->X ||
         (p->model.n % p->model.d == 0 && !p->smooth && model_is_nodal(&p->model));
}

const double *problem_coordinates(const problem *p, int *rows, const int **contact) {
  const struct matrices *own = p->matrices;
  if (rows) *rows = own->rows;
  if (contact) *contact = own->row_contact;
  return own->X;
}

/* Finds the row of each node, and where each contact is: at the node with its largest entry in H_N.
 * Returns 0 after a complaint. */
static int place_contacts(problem *p) {
  struct matrices *own = p->matrices;
  for (int i = 0; i < own->rows; i++)
    if (own->row_node[i] > own->most_node) own->most_node = own->row_node[i];
  own->row_of = malloc(((size_t)own->most_node + 1) * sizeof *own->row_of);
  if (!own->row_of) return refuse("out of memory");
  for (int i = 0; i <= own->most_node; i++)
    own->row_of[i] = -1;
  for (int i = 0; i < own->rows; i++)
    own->row_of[own->row_node[i]] = i;
  const dls_sparse *N = &p->model.HN;
  if (!own->place) own->place = calloc((size_t)N->cols + 1, sizeof *own->place);
  if (!own->place) return refuse("out of memory");
  for (int c = 0; c < N->cols; c++) {
    double most = 0;
    spot at = {0}, best = {own->place[c], 0, -1};
    for (int e = N->p[c]; e < N->p[c + 1]; e++)
      if (fabs(N->x[e]) > most && unknown_place(p, N->i[e], &at)) most = fabs(N->x[e]), best = at;
    own->place[c] = best.node;
    if (best.row >= 0 && own->row_contact[best.row] < 0) own->row_contact[best.row] = c;
  }
  return 1;
}

/* Says what was not given, and what that means. */
static void say_missing(const matrix_options *o, problem *p) {
  (void)snprintf(p->note, sizeof p->note, "%s%s%s", o->f ? "" : "no loads: --f is not given",
                 !o->f && p->smooth ? "; " : "", p->smooth ? "no friction: --HT is not given" : "");
  if (o->H && !o->dim)
    (void)snprintf(p->note + strlen(p->note), sizeof p->note - strlen(p->note),
                   "%s%dD: %d columns of --H for %d contacts", *p->note ? "; " : "", p->model.d,
                   p->model.d * p->model.nodes, p->model.nodes);
}

int matrices_load(const matrix_options *o, problem *p) {
  if (!check_matrices(o)) return 0;
  arrays_of_triplets(o->triplets);
  struct matrices *own = p->matrices = calloc(1, sizeof *own);
  if (!own) return refuse("out of memory");
  if (o->W) return load_condensed(o, p);
  dls_model *model = &p->model;
  if (o->stiffness) {
    if (!load_stiffness(o->stiffness, own, model)) return 0;
  } else {
    model->operator_kind = DLS_FLEXIBILITY;
    if (!read_square("flexibility", o->flexibility, &model->n, &own->K)) return 0;
    model->K = (dls_dense){model->n, model->n, model->n, own->K};
  }
  if (!load_operators(o, own, model)) return 0;
  if (o->nodes && (o->HN || o->H)) {
    int d = o->HN && !o->HT ? o->dim : model->d;
    if (!read_coordinates(o->nodes, &d, model->n, own)) return 0;
    if (o->HN && !o->HT && d != model->d && !(model->d = d, empty_tangents(model->n, own, model)))
      return 0;
  }
  if (o->weights) {
    if (!sparse_read(o->weights, &own->P)) return 0;
    model->P = own->P.view;
  }
  if (!matrices_load_data(o, 1, p)) return 0;
  if (own->X && !place_contacts(p)) return 0;
  p->smooth = o->HN && !o->HT;
  say_missing(o, p);
  hint_operators(model);
  hint_gaps(own->g, model->d, model->nodes);
  return 1;
}

void matrices_free(struct matrices *own) {
  if (!own) return;
  sparse_free(&own->Ks);
  sparse_free(&own->HN);
  sparse_free(&own->HT);
  sparse_free(&own->P);
  free(own->K);
  free(own->f);
  free(own->g);
  free(own->q);
  free(own->mu);
  free(own->node);
  free(own->direction);
  free(own->place);
  free(own->X);
  free(own->row_of);
  free(own->row_node);
  free(own);
}

int problem_node(const problem *p, int c) {
  return p->matrices && p->matrices->place && !p->model.P.p ? p->matrices->place[c] : 0;
}

int problem_unknown(const problem *p, int k, int *node, int *direction) {
  if (!p->matrices || !p->matrices->node) return 0;
  *node = p->matrices->node[k];
  *direction = p->matrices->direction[k];
  return 1;
}
