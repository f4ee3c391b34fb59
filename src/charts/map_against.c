/*
 * map_against.c: how each method bears W as it worsens. The W of a problem is made worse in one
 * way, friction is the other axis, and a cell tells the share of random loads that a method solves.
 *
 *   condition   the eigenvectors of the scaled W; eigenvalues in equal ratios, 1 to 1 / condition
 *   rank        the smallest eigenvalues are set to 0
 *   skew        a random skew-symmetric matrix is added, its size over that of the mean diagonal
 *
 * A load is planted: every candidate is free, sticks or slips by chance, r and u follow from that
 * at random, and q = u - W r, so that each problem has a solution. W need not be one that a body
 * has: the map is about methods.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "linear/blas.h"
#include "map.h"

enum { AGAINST_ROWS = 7, AGAINST_COLUMNS = 7, against_rows_most = 150 };

static const double against_limit = 0.05; /* CPU seconds of a solve, unless --limit says */

typedef enum damage { DAMAGE_CONDITION, DAMAGE_RANK, DAMAGE_SKEW, DAMAGES } damage;

static const struct {
  const char *name, *label, *format;
  double value[AGAINST_COLUMNS];
} damages[DAMAGES] = {
    {"condition", "condition of W", "1e%g", {1e1, 1e2, 1e4, 1e6, 1e8, 1e10, 1e12}},
    {"rank", "rank of W, part of full", "%g", {1, 0.9, 0.8, 0.65, 0.5, 0.35, 0.2}},
    {"skew", "skew part of W over its diagonal", "%g", {0, 0.1, 0.3, 1, 3, 10, 30}}};

/* A generator of numbers of its own, so that a map is the same everywhere. */
static double uniform(unsigned long long *state) {
  *state = *state * 6364136223846793005ull + 1442695040888963407ull;
  return (double)(*state >> 11) / 9007199254740992.0;
}

static double normal(unsigned long long *state) {
  const double radius = sqrt(-2 * log(1 - uniform(state)));
  return radius * cos(6.283185307179586 * uniform(state));
}

/* ---- W --------------------------------------------------------------------------------------- */

/* What the damage starts from. */
typedef struct base {
  int m;
  double *W;          /* m x m, scaled to unit diagonal blocks */
  double *V, *values; /* its symmetric part's eigenvectors and values, falling */
  double *damaged;    /* m x m */
  double *work;       /* 3 m */
} base;

/* Finds eigenvectors V and eigenvalues of the symmetric A, the largest first. work: 3 m. */
static void find_spectrum(int m, const double *A, double *V, double *values, double *work) {
  const int room = 3 * m;
  int info = 0;
  memcpy(V, A, (size_t)m * (size_t)m * sizeof *V);
  dsyev_("V", "L", &m, V, &m, values, work, &room, &info, 1, 1);
  for (int i = 0; i < m / 2; i++) {
    const int at = m - 1 - i;
    const double value = values[i];
    values[i] = values[at];
    values[at] = value;
    for (int k = 0; k < m; k++) {
      const double v = V[k + i * m];
      V[k + i * m] = V[k + at * m];
      V[k + at * m] = v;
    }
  }
}

/* Copies the scaled W of the problem: D^-1/2 W D^-1/2 with the mean diagonal of each candidate. */
static dls_status base_fill(base *b, const dls_contact *c, dls_error *error) {
  const int m = b->m, d = c->d;
  dls_status status = DLS_OK;
  if (c->Wb.x)
    status = dls_blocks_to_dense(&c->Wb, b->W, m, error);
  else
    for (int j = 0; j < m; j++)
      memcpy(b->W + (size_t)j * (size_t)m, c->W.a + (size_t)j * (size_t)c->W.ld,
             (size_t)m * sizeof *b->W);
  if (status) return status;
  for (int i = 0; i < c->nc; i++) {
    double w = 0;
    for (int k = 0; k < d; k++)
      w += b->W[(d * i + k) * (m + 1)] / d;
    b->values[i] = w > 0 ? 1 / sqrt(w) : 1;
  }
  for (int k = 0; k < m * m; k++)
    b->W[k] *= b->values[k % m / d] * b->values[k / m / d];
  for (int k = 0; k < m * m; k++)
    b->damaged[k] = (b->W[k] + b->W[k / m + k % m * m]) / 2;
  find_spectrum(m, b->damaged, b->V, b->values, b->work);
  return DLS_OK;
}

/* Makes the damaged W of a sample. */
static void damage_matrix(base *b, damage kind, double value, unsigned long long *state) {
  const int m = b->m;
  if (kind == DAMAGE_SKEW) {
    memcpy(b->damaged, b->W, (size_t)m * (size_t)m * sizeof *b->W);
    for (int i = 0; i < m; i++)
      for (int j = 0; j < i; j++) {
        const double s = value * normal(state) / sqrt(m);
        b->damaged[i + j * m] += s;
        b->damaged[j + i * m] -= s;
      }
    return;
  }
  memset(b->damaged, 0, (size_t)m * (size_t)m * sizeof *b->W);
  const int rank = kind == DAMAGE_RANK ? (int)fmax(1, ceil(value * m)) : m;
  for (int k = 0; k < rank; k++) {
    const double own = fmax(b->values[k], 1e-3 * b->values[0]);
    const double lambda = kind == DAMAGE_RANK ? own : pow(value, -(double)k / (m > 1 ? m - 1 : 1));
    for (int j = 0; j < m; j++) {
      const double v = lambda * b->V[j + k * m];
      for (int i = 0; i < m; i++)
        b->damaged[i + j * m] += v * b->V[i + k * m];
    }
  }
}

/* ---- loads ----------------------------------------------------------------------------------- */

/* Plants a solution: q = u - W r. r: m, room. */
static void plant(const base *b, int d, int nc, double mu, double *r, double *q,
                  unsigned long long *state) {
  const int m = b->m;
  for (int c = 0; c < nc; c++) {
    const double chance = uniform(state), force = 0.2 + uniform(state), side = normal(state);
    double t[2] = {side < 0 ? -1 : 1, 0};
    if (d == 3) {
      const double angle = 6.283185307179586 * uniform(state);
      t[0] = cos(angle);
      t[1] = sin(angle);
    }
    const int is_free = chance<0.25, slips = chance> 0.6;
    const double slide = uniform(state), grip = slips ? 1 : uniform(state);
    for (int k = 0; k < d; k++) {
      r[d * c + k] = is_free ? 0 : k ? mu * force * grip * t[k - 1] : force;
      q[d * c + k] = k ? (is_free ? slide * t[k - 1]
                          : slips ? -slide * t[k - 1]
                                  : 0)
                       : (is_free ? 0.1 + slide : 0);
    }
  }
  for (int j = 0; j < m; j++)
    for (int i = 0; i < m; i++)
      q[i] -= b->damaged[i + j * m] * r[j];
}

/* ---- the map --------------------------------------------------------------------------------- */

typedef struct against {
  map_picture picture;
  contender who[MOST_CONTENDERS];
  base base;
  double *mu, *r, *q; /* nc, m, m */
  damage kind;
} against;

/* Fills the cells of one friction and one damage. */
static dls_status against_cell(against *a, const dls_contact *given, int row, int column, double mu,
                               const map_options *o, FILE *csv, dls_error *error) {
  const int m = a->base.m;
  int solved[MOST_CONTENDERS] = {0}, open[MOST_CONTENDERS] = {0};
  const race_plan plan = {.rungs = 1,
                          .tol = &o->tol,
                          .repeat = 1,
                          .limit = o->limit < 0 ? against_limit : o->limit,
                          .budget = 10};
  for (int c = 0; c < given->nc; c++)
    a->mu[c] = mu;
  for (int sample = 0; sample < o->samples; sample++) {
    unsigned long long state = 2 + 2 * (unsigned)sample + 1000003ull * (unsigned)(8 * column + row);
    damage_matrix(&a->base, a->kind, damages[a->kind].value[column], &state);
    plant(&a->base, given->d, given->nc, mu, a->r, a->q, &state);
    const dls_contact p = {
        .d = given->d, .nc = given->nc, .W = {m, m, m, a->base.damaged}, .q = a->q, .mu = a->mu};
    race it = {0};
    const dls_status status = race_run(&it, &p, NULL, &plan, error);
    for (int k = 0; k < it.count && !status; k++)
      for (int j = 0; j < a->picture.panels; j++) {
        if (strcmp(a->who[j].name, it.who[k].name) != 0) continue;
        solved[j] += race_trial(&it, k, 0)->end == ENDED_SOLVED;
        open[j] += race_trial(&it, k, 0)->end == ENDED_UNDECIDED;
      }
    race_free(&it);
    if (status || was_interrupted()) return status;
  }
  for (int j = 0; j < a->picture.panels; j++) {
    const double share = (double)solved[j] / o->samples;
    map_share(map_at(&a->picture, j, row, column), share, open[j] > 0);
    fprintf(csv, "%.9g,%g,%s,%g,%g\n", mu, damages[a->kind].value[column], a->who[j].name, share,
            (double)open[j] / o->samples);
  }
  return DLS_OK;
}

/* Solves for every cell. DLS_E_FILE: after a complaint. */
static dls_status against_fill(against *a, const dls_contact *given, const map_options *o,
                               dls_error *error) {
  const size_t m = (size_t)a->base.m;
  double mu[MAP_ROWS];
  double *room = malloc((3 * m * m + 7 * m) * sizeof *room);
  FILE *csv = room ? open_growing(o->out, "map.csv", "") : NULL;
  dls_status status = csv ? DLS_OK : room ? DLS_E_FILE : DLS_E_MEMORY;
  a->base.W = room;
  if (csv) {
    a->base.V = room + m * m;
    a->base.damaged = room + 2 * m * m;
    a->base.values = room + 3 * m * m;
    a->mu = a->base.values + m;
    a->r = a->mu + m;
    a->q = a->r + m;
    a->base.work = a->q + m;
    fprintf(csv, "mu,%s,method,share,not_decided\n", damages[a->kind].name);
    status = base_fill(&a->base, given, error);
    spread_friction(o->from > 0 ? o->from : 0.1, o->to < 0 ? 10 : o->to, a->picture.rows, mu);
    for (int i = 0; i < a->picture.rows; i++)
      (void)snprintf(a->picture.row[i], MAP_NAME, "%.2g", mu[i]);
  }
  for (int j = 0; j < a->picture.columns && !status; j++)
    for (int i = 0; i < a->picture.rows && !status && !was_interrupted(); i++)
      status = against_cell(a, given, i, j, mu[i], o, csv, error);
  if (!status && !close_file(csv, "map.csv")) status = DLS_E_FILE;
  free(room);
  a->base = (base){0};
  return status;
}

int map_against(const char *name, map_options *o) {
  against a = {0};
  char title[200], subtitle[200], notes[200];
  problem subject = {0};
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  int result = EXIT_BAD_INPUT;
  while (a.kind < DAMAGES && strcmp(damages[a.kind].name, o->against))
    a.kind++;
  if (a.kind == DAMAGES)
    return complain(
        "--against: '%s' is none of condition, rank, skew (and mesh, of scenes in steps)",
        o->against);
  dls_status status = DLS_OK;
  if (!problem_open(name, &o->of, &subject)) {
    problem_free(&subject);
    return end_command(was_interrupted() ? EXIT_NOT_SOLVED : EXIT_BAD_INPUT, NULL);
  }
  a.base.m = subject.contact.d * subject.contact.nc;
  if (a.base.m > against_rows_most) {
    problem_free(&subject);
    return complain("--against: %s has %d rows, more than %d", name, a.base.m, against_rows_most);
  }
  map_picture *p = &a.picture;
  *p = (map_picture){.title = title, .subtitle = subtitle, .y = "friction", .notes = notes};
  p->x = damages[a.kind].label;
  contender all[MOST_CONTENDERS];
  for (int k = 0, count = list_contenders(all); k < count; k++)
    if (race_takes(&all[k], &subject.contact, NULL)) a.who[p->panels++] = all[k];
  p->rows = o->rows && o->rows <= MAP_ROWS ? o->rows : AGAINST_ROWS;
  p->columns = AGAINST_COLUMNS;
  for (int k = 0; k < p->panels; k++)
    p->panel[k] = a.who[k].name;
  for (int j = 0; j < p->columns; j++)
    (void)snprintf(p->column[j], MAP_NAME, damages[a.kind].format,
                   a.kind == DAMAGE_CONDITION ? log10(damages[a.kind].value[j])
                                              : damages[a.kind].value[j]);
  p->cells = calloc((size_t)(p->panels * p->rows * p->columns), sizeof *p->cells);
  (void)snprintf(title, sizeof title, "%s with another %s: who still solves it", subject.name,
                 damages[a.kind].label);
  (void)snprintf(subtitle, sizeof subtitle,
                 "numbers: per cent of %d random loads that have a solution, solved to %.0e",
                 o->samples, o->tol);
  (void)snprintf(
      notes, sizeof notes,
      "measured. Hatched: some of the loads are not decided in %g s of CPU, or in ten times the "
      "method's iterations",
      map_longer * (o->limit < 0 ? against_limit : o->limit));
  if (!p->cells)
    (void)complain_of(name, &error);
  else if ((o->out = take_folder(o->out, "map", name))) {
    p->directory = o->out;
    status = against_fill(&a, &subject.contact, o, &error);
    if (!status)
      result = draw_map(p);
    else if (status != DLS_E_FILE)
      (void)complain_of(name, &error);
  }
  free(p->cells);
  problem_free(&subject);
  return end_table(result, NULL, "map", o->out, "map.csv");
}
