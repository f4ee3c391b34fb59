/*
 * solvers_peer.c: the friction contact solvers of Siconos Numerics.
 *
 * Each runs with its default options and with one or more of the settings that its headers offer;
 * besides, only the tolerance is changed, and the iteration limit to one that never comes first. W
 * is stored in the best form for the solver: dense if W is dense, else blocks for sweeps, sparse
 * for Newton and ADMM; small ones dense, too. Matrix and options are made again for each call, as
 * some solvers write into them. Short calls are also tried in a row on one matrix, which is then in
 * the cache.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <FrictionContactProblem.h>
#include <Friction_cst.h>
#include <GlobalFrictionContactProblem.h>
#include <NonSmoothDrivers.h>
#include <NumericsMatrix.h>
#include <NumericsSparseMatrix.h>
#include <NumericsVerbose.h>
#include <SolverOptions.h>
#include <SparseBlockMatrix.h>

#include "common.h"
#include "solvers.h"

enum {
  most_iterations = 100000000,
  least_iterations = 1000,
  pivoting_rows = 3000,   /* most for the lexicographic Lemke, which takes seconds there */
  dense_copy_rows = 1500, /* most for trying W by blocks as a dense matrix, too */
  dense_only_rows = 6000  /* most for solvers that take nothing but a dense matrix */
};

typedef enum storage { DENSE, BLOCKS, SPARSE } storage;

/* What a setting changes: one integer parameter, or the solver of one contact. */
typedef struct tuning {
  int local; /* the solver; 0: as it is */
  int parameter, value;
} tuning;

struct peer_method {
  const char *name, *setting;
  int id;             /* of the solver */
  int d;              /* it is for */
  int global;         /* K, H as they are */
  int quick;          /* part of an impatient run */
  storage of;         /* W, where W is given by blocks; a dense W stays dense */
  const tuning *tune; /* NULL for the defaults */
};

/* ---- settings -------------------------------------------------------------------------------- */

static const tuning local_projection[] = {
    {.local = SICONOS_FRICTION_3D_ONECONTACT_ProjectionOnConeWithLocalIteration}};
static const tuning local_quartic[] = {{.local = SICONOS_FRICTION_3D_ONECONTACT_QUARTIC}};
static const tuning local_newton[] = {{.local = SICONOS_FRICTION_3D_ONECONTACT_NSN}};
static const tuning freezing[] = {{0, SICONOS_FRICTION_3D_NSGS_FREEZING_CONTACT, 20}};
static const tuning full_error[] = {{0, SICONOS_FRICTION_3D_IPARAM_ERROR_EVALUATION,
                                     SICONOS_FRICTION_3D_NSGS_ERROR_EVALUATION_FULL}};
static const tuning jean_moreau[] = {
    {0, SICONOS_FRICTION_3D_NSN_FORMULATION, SICONOS_FRICTION_3D_NSN_FORMULATION_JEANMOREAU_STD}};
static const tuning mumps[] = {
    {0, SICONOS_FRICTION_3D_NSN_LINEAR_SOLVER, SICONOS_FRICTION_3D_NSN_USE_MUMPS}};
static const tuning hybrid[] = {{0, SICONOS_FRICTION_3D_NSN_HYBRID_STRATEGY,
                                 SICONOS_FRICTION_3D_NSN_HYBRID_STRATEGY_VI_EG_NSN}};
static const tuning balancing[] = {{0, SICONOS_FRICTION_3D_ADMM_IPARAM_RHO_STRATEGY,
                                    SICONOS_FRICTION_3D_ADMM_RHO_STRATEGY_RESIDUAL_BALANCING}};
static const tuning scaled_balancing[] = {
    {0, SICONOS_FRICTION_3D_ADMM_IPARAM_RHO_STRATEGY,
     SICONOS_FRICTION_3D_ADMM_RHO_STRATEGY_SCALED_RESIDUAL_BALANCING}};

/* The settings tried; solvers that get everywhere come first, which shortens an impatient run. */
static const peer_method methods[] = {
    {"siconos-nsgs", "default", SICONOS_FRICTION_2D_NSGS, 2, 0, 1, BLOCKS, NULL},
    {"siconos-nsgs", "default", SICONOS_FRICTION_2D_NSGS, 2, 0, 1, DENSE, NULL},
    {"siconos-cpg", "default", SICONOS_FRICTION_2D_CPG, 2, 0, 1, DENSE, NULL},
    {"siconos-lemke", "default", SICONOS_FRICTION_2D_LEMKE, 2, 0, 1, DENSE, NULL},
    {"siconos-prox", "default", SICONOS_FRICTION_3D_PROX, 3, 0, 1, BLOCKS, NULL},
    {"siconos-nsgs", "default", SICONOS_FRICTION_3D_NSGS, 3, 0, 1, BLOCKS, NULL},
    {"siconos-nsgs", "freezing", SICONOS_FRICTION_3D_NSGS, 3, 0, 1, BLOCKS, freezing},
    {"siconos-nsgs", "full-error", SICONOS_FRICTION_3D_NSGS, 3, 0, 0, BLOCKS, full_error},
    {"siconos-nsgs", "local-newton", SICONOS_FRICTION_3D_NSGS, 3, 0, 0, BLOCKS, local_newton},
    {"siconos-nsgs", "local-quartic", SICONOS_FRICTION_3D_NSGS, 3, 0, 0, BLOCKS, local_quartic},
    {"siconos-nsgs-p", "default", SICONOS_FRICTION_3D_NSGS, 3, 0, 1, BLOCKS, local_projection},
    {"siconos-nsn-ac", "default", SICONOS_FRICTION_3D_NSN_AC, 3, 0, 1, SPARSE, NULL},
    {"siconos-nsn-ac", "default", SICONOS_FRICTION_3D_NSN_AC, 3, 0, 0, DENSE, NULL},
    {"siconos-nsn-ac", "mumps", SICONOS_FRICTION_3D_NSN_AC, 3, 0, 0, SPARSE, mumps},
    {"siconos-nsn-ac", "jean-moreau", SICONOS_FRICTION_3D_NSN_AC, 3, 0, 0, SPARSE, jean_moreau},
    {"siconos-nsn-ac", "hybrid", SICONOS_FRICTION_3D_NSN_AC, 3, 0, 0, SPARSE, hybrid},
    {"siconos-nsn-fb", "default", SICONOS_FRICTION_3D_NSN_FB, 3, 0, 1, SPARSE, NULL},
    {"siconos-nsn-fb", "default", SICONOS_FRICTION_3D_NSN_FB, 3, 0, 0, DENSE, NULL},
    {"siconos-nsn-nm", "default", SICONOS_FRICTION_3D_NSN_NM, 3, 0, 0, SPARSE, NULL},
    {"siconos-nsn-nm", "default", SICONOS_FRICTION_3D_NSN_NM, 3, 0, 0, DENSE, NULL},
    {"siconos-admm", "default", SICONOS_FRICTION_3D_ADMM, 3, 0, 1, SPARSE, NULL},
    {"siconos-admm", "balancing", SICONOS_FRICTION_3D_ADMM, 3, 0, 1, SPARSE, balancing},
    {"siconos-admm", "scaled-balancing", SICONOS_FRICTION_3D_ADMM, 3, 0, 0, SPARSE,
     scaled_balancing},
    {"siconos-tfp", "default", SICONOS_FRICTION_3D_TFP, 3, 0, 0, BLOCKS, NULL},
    {"siconos-aclmfp", "default", SICONOS_FRICTION_3D_ACLMFP, 3, 0, 0, BLOCKS, NULL},
    {"siconos-vi-eg", "default", SICONOS_FRICTION_3D_VI_EG, 3, 0, 0, BLOCKS, NULL},
    {"siconos-vi-fpp", "default", SICONOS_FRICTION_3D_VI_FPP, 3, 0, 0, BLOCKS, NULL},
    {"siconos-nsgs-wr", "default", SICONOS_GLOBAL_FRICTION_3D_NSGS_WR, 3, 1, 1, SPARSE, NULL},
    {"siconos-nsn-ac-wr", "default", SICONOS_GLOBAL_FRICTION_3D_NSN_AC_WR, 3, 1, 1, SPARSE, NULL},
    {"siconos-admm-wr", "default", SICONOS_GLOBAL_FRICTION_3D_ADMM_WR, 3, 1, 0, SPARSE, NULL},
    {"siconos-nsn-ac", "default", SICONOS_GLOBAL_FRICTION_3D_NSN_AC, 3, 1, 1, SPARSE, NULL},
    {"siconos-admm", "default", SICONOS_GLOBAL_FRICTION_3D_ADMM, 3, 1, 1, SPARSE, NULL},
    {"siconos-admm", "balancing", SICONOS_GLOBAL_FRICTION_3D_ADMM, 3, 1, 1, SPARSE, balancing},
};
enum { method_count = sizeof methods / sizeof methods[0] };

const peer_method *peer_at(int index) {
  return index >= 0 && index < method_count ? &methods[index] : NULL;
}
const char *peer_name(const peer_method *p) {
  return p->name;
}
const char *peer_setting(const peer_method *p) {
  return p->setting;
}
/* Returns 1 for sweeps and the like, which the CPU limit ends; others keep their own limit. */
static int iterates_cheaply(int id) {
  return id == SICONOS_FRICTION_2D_NSGS || id == SICONOS_FRICTION_2D_CPG ||
         id == SICONOS_FRICTION_2D_LEMKE || id == SICONOS_FRICTION_3D_NSGS ||
         id == SICONOS_FRICTION_3D_ADMM || id == SICONOS_FRICTION_3D_VI_EG ||
         id == SICONOS_FRICTION_3D_VI_FPP || id == SICONOS_GLOBAL_FRICTION_3D_NSGS_WR ||
         id == SICONOS_GLOBAL_FRICTION_3D_ADMM || id == SICONOS_GLOBAL_FRICTION_3D_ADMM_WR;
}

int peer_pivots(const peer_method *p) {
  return p->id == SICONOS_FRICTION_2D_LEMKE;
}

/* Returns the storage of W that p gets. */
static storage storage_of(const peer_method *p, const scene *s) {
  return s->contact.W.a && !p->global ? DENSE : p->of;
}

const char *peer_storage(const peer_method *p, const scene *s) {
  static const char *const names[] = {"dense", "blocks", "sparse"};
  return names[storage_of(p, s)];
}

/* Returns 1 if the line before has this solver and setting with another storage. */
static int is_double(const peer_method *p) {
  return p > methods && p[-1].id == p->id && p[-1].tune == p->tune;
}

int peer_takes(const peer_method *p, const scene *s, int patient) {
  const int m = s->contact.d * s->contact.nc, dense = s->contact.W.a != NULL;
  if (p->d != s->contact.d || p->global != (s->model != NULL) || (!patient && !p->quick)) return 0;
  if (peer_pivots(p) && m > pivoting_rows) return 0;
  if (dense && !p->global) return !is_double(p) && p->tune != mumps;
  return p->of != DENSE || m <= (is_double(p) ? dense_copy_rows : dense_only_rows);
}

/* ---- matrices -------------------------------------------------------------------------------- */

static NumericsMatrix *triplets(int rows, int cols, int count) {
  NumericsMatrix *A = NM_create(NM_SPARSE, rows, cols);
  NM_triplet_alloc(A, count);
  numericsSparseMatrix(A)->origin = NSM_TRIPLET;
  return A;
}

static NumericsMatrix *sparse_of_blocks(const dls_blocks *W) {
  const int d = W->d, m = d * W->n;
  NumericsMatrix *A = triplets(m, m, d * d * W->p[W->n]);
  for (int c = 0; c < W->n; c++)
    for (int k = W->p[c]; k < W->p[c + 1]; k++)
      for (int j = 0; j < d; j++)
        for (int i = 0; i < d; i++)
          NM_entry(A, d * W->i[k] + i, d * c + j,
                   W->x[(size_t)d * (size_t)(d * k + j) + (size_t)i]);
  NM_csc(A);
  return A;
}

static NumericsMatrix *dense_of(const scene *s) {
  const size_t m = (size_t)s->contact.d * (size_t)s->contact.nc;
  NumericsMatrix *A = NM_create(NM_DENSE, (int)m, (int)m);
  const dls_dense *W = &s->contact.W;
  const dls_blocks *B = &s->contact.Wb;
  if (W->a) {
    for (size_t j = 0; j < m; j++)
      memcpy(A->matrix0 + j * m, W->a + j * (size_t)W->ld, m * sizeof(double));
    return A;
  }
  const size_t d = (size_t)B->d;
  memset(A->matrix0, 0, m * m * sizeof(double));
  for (int c = 0; c < B->n; c++)
    for (int k = B->p[c]; k < B->p[c + 1]; k++)
      for (size_t j = 0; j < d; j++)
        for (size_t i = 0; i < d; i++)
          A->matrix0[d * (size_t)B->i[k] + i + (d * (size_t)c + j) * m] +=
              B->x[d * (d * (size_t)k + j) + i];
  return A;
}

static NumericsMatrix *matrix_of(const scene *s, storage kind) {
  if (kind == DENSE) return dense_of(s);
  NumericsMatrix *A = sparse_of_blocks(&s->contact.Wb);
  if (kind == SPARSE) return A;
  SparseBlockStructuredMatrix *blocks = SBM_new();
  SBM_from_csparse(s->contact.d, NM_csc(A), blocks);
  NumericsMatrix *B = NM_new_SBM(A->size0, A->size1, blocks);
  NM_free(A);
  return B;
}

static NumericsMatrix *sparse_of(const dls_sparse *K) {
  NumericsMatrix *A = triplets(K->rows, K->cols, K->p[K->cols]);
  for (int j = 0; j < K->cols; j++)
    for (int k = K->p[j]; k < K->p[j + 1]; k++)
      NM_entry(A, K->i[k], j, K->x[k]);
  NM_csc(A);
  return A;
}

/* Orders the columns of H_N and H_T candidate by candidate. */
static NumericsMatrix *sparse_of_H(const dls_model *model) {
  const int d = model->d, nc = model->nodes;
  const dls_sparse *HN = &model->HN, *HT = &model->HT;
  NumericsMatrix *A = triplets(model->n, d * nc, HN->p[nc] + HT->p[(d - 1) * nc]);
  for (int j = 0; j < d * nc; j++) {
    const dls_sparse *H = j % d ? HT : HN;
    const int column = j % d ? (d - 1) * (j / d) + j % d - 1 : j / d;
    for (int k = H->p[column]; k < H->p[column + 1]; k++)
      NM_entry(A, H->i[k], j, H->x[k]);
  }
  NM_csc(A);
  return A;
}

static double *copy_of(const double *x, int n) {
  double *y = malloc((size_t)n * sizeof *y);
  if (y) memcpy(y, x, (size_t)n * sizeof *y);
  return y;
}

/* ---- solving --------------------------------------------------------------------------------- */

/* Arguments of a call. Solvers write into the matrix, and keep things in it and in the options. */
typedef struct job {
  SolverOptions *options;
  FrictionContactProblem local;
  GlobalFrictionContactProblem *global; /* NULL: local */
  double *v;                            /* n of the global one */
} job;

static void tune(SolverOptions *options, const tuning *t) {
  if (t->local)
    solver_options_update_internal(options, 0, t->local);
  else
    options->iparam[t->parameter] = t->value;
}

static SolverOptions *options_of(const peer_method *p, double tol) {
  SolverOptions *options = solver_options_create(p->id);
  if (p->tune) tune(options, p->tune);
  options->dparam[SICONOS_DPARAM_TOL] = tol;
  if (options->iparam[SICONOS_IPARAM_MAX_ITER] < least_iterations)
    options->iparam[SICONOS_IPARAM_MAX_ITER] = least_iterations;
  if (iterates_cheaply(p->id)) options->iparam[SICONOS_IPARAM_MAX_ITER] = most_iterations;
  return options;
}

static FrictionContactProblem local_of(const peer_method *p, const scene *s) {
  const dls_contact *c = &s->contact;
  return (FrictionContactProblem){.dimension = c->d,
                                  .numberOfContacts = c->nc,
                                  .M = matrix_of(s, storage_of(p, s)),
                                  .q = copy_of(c->q, c->d * c->nc),
                                  .mu = copy_of(c->mu, c->nc)};
}

static GlobalFrictionContactProblem *global_of(const scene *s) {
  GlobalFrictionContactProblem *problem = globalFrictionContactProblem_new();
  problem->dimension = s->contact.d;
  problem->numberOfContacts = s->contact.nc;
  problem->M = sparse_of(&s->model->Ks);
  problem->H = sparse_of_H(s->model);
  problem->q = copy_of(s->f, s->model->n);
  problem->b = copy_of(s->g, s->contact.d * s->contact.nc);
  problem->mu = copy_of(s->contact.mu, s->contact.nc);
  return problem;
}

static void job_fill(job *j, const peer_method *p, const scene *s) {
  if (!p->global)
    j->local = local_of(p, s);
  else {
    j->global = global_of(s);
    j->v = calloc((size_t)s->model->n, sizeof *j->v);
  }
}

static int run_job(job *j, double *r, double *u) {
  if (j->global) return gfc3d_driver(j->global, r, u, j->v, j->options);
  return (j->local.dimension == 2 ? fc2d_driver : fc3d_driver)(&j->local, r, u, j->options);
}

static void job_free(job *j) {
  if (!j->global)
    NM_free(j->local.M); /* a global one goes with the process: some solvers free parts */
  free(j->local.q);
  free(j->local.mu);
  free(j->v);
  solver_options_delete(j->options);
  free(j->options);
}

/* Solves `calls` times on as many jobs as `different` says, 1 or calls. */
static void solve_jobs(const peer_method *p, const scene *s, double tol, int calls, int different,
                       double *r, outcome *o) {
  const size_t bytes = (size_t)s->contact.d * (size_t)s->contact.nc * sizeof *r;
  double *u = malloc(bytes);
  job *jobs = calloc((size_t)different, sizeof *jobs);
  if (!u || !jobs) abort(); /* a row */
  numerics_set_verbose(0);
  const double before = bench_seconds();
  for (int k = 0; k < different; k++)
    jobs[k].options = options_of(p, tol);
  o->setup = (bench_seconds() - before) / different;
  for (int k = 0; k < different; k++)
    job_fill(&jobs[k], p, s);
  int status = 0;
  job *last = jobs;
  const double start = bench_seconds();
  for (int k = 0; k < calls; k++) {
    last = jobs + (k < different ? k : 0);
    memset(r, 0, bytes);
    memset(u, 0, bytes);
    status = run_job(last, r, u);
  }
  o->cpu = (bench_seconds() - start) / calls;
  o->claim = status == 0;
  o->iterations = last->options->iparam[SICONOS_IPARAM_ITER_DONE];
  for (int k = 0; k < different; k++)
    job_free(&jobs[k]);
  free(jobs);
  free(u);
}

void peer_solve(const void *how, const scene *s, double tol, int calls, double *r, outcome *o) {
  solve_jobs(how, s, tol, calls, calls, r, o);
}

void peer_solve_again(const void *how, const scene *s, double tol, int calls, double *r,
                      outcome *o) {
  solve_jobs(how, s, tol, calls, 1, r, o);
}

outcome peer_reach(const peer_method *p, const scene *s, double tol, double limit) {
  outcome o = {.ended = REFUSED, .certificate = {.residual = INFINITY}};
  for (double own_tol = 10 * tol; own_tol > 1e-16; own_tol /= 10) {
    o = measure(s, peer_solve, p, own_tol, limit + 0.1);
    if (isfinite(outcome_seconds(&o, tol)) || o.ended != ENDED || o.cpu > limit || peer_pivots(p))
      break;
  }
  return o;
}
