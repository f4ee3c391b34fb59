/*
 * scene.c: delassus scene NAME: takes a scene from its model through the reduction and a solver
 * to tables, files and pictures.
 *
 * The tables show for every candidate: (u_t, u_n), the relative position of its node (with weighted
 * reactions, too: the paper prints displacements of nodes); its reactions (r_t, r_n); the
 * equivalent ones of the other kind: of weighted reactions P r at its node, of concentrated ones
 * P^-1 r.
 */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hints.h"
#include "problem.h"

typedef struct scene_options {
  const char *name;
  int weighted;
  int as_printed; /* 1: by jean_sweeps instead of a method */
  dls_fe_scene_settings block;
  solver_options solver;
  const char *out, *save, *reference; /* NULL: none */
} scene_options;

/* A thousandth of what halving the mesh changes (docs/decisions.md, "The tolerance of a scene"). */
const double scene_tol = 1e-6;

static void scene_usage(FILE *out) {
  fputs("Usage: delassus scene [OPTION]... NAME\n"
        "  or:  delassus scene --list\n"
        "Runs a built-in scene and prints displacements and reactions of its contacts. Scenes in\n"
        "load steps or in time have options of their own: delassus scene NAME --help.\n"
        "\n",
        out);
  solver_usage(
      out,
      ",\n                        or gauss-seidel, on the displacements; or jean, the paper's"
      "\n                        sweeps, which stop at a relative change of 1e-4",
      scene_tol);
  fputs(
      "      --mesh=NXxNY      rectangles along x and y (16x8)\n"
      "      --mu=MU           friction (1; 0.1)\n"
      "      --grade=G         elements smaller towards the fixed node: node k of n along a side "
      "at\n"
      "                        (k/n)^G of it (1)\n"
      "      --young=E         Young's modulus (0.13e12)\n"
      "      --poisson=NU      Poisson's ratio, plane strain (0.2)\n"
      "      --load=TOP,SIDE[,SIDE_TOP]\n"
      "                        pressure on top, traction on the side, at its bottom and its top\n"
      "                        (5e8,9e8,25e8; 5e8,5e8)\n"
      "      --order=HOW       order of the loads: together (default), top-first or side-first\n"
      "  -w, --weighted        weighted instead of concentrated reactions\n"
      "  -o, --out=DIR         write contact.csv, result.json, the deformed mesh (.vtu), "
      "pictures\n" PICTURE_USAGE
      "  -s, --save=FILE       write the contact problem as an FCLIB file (HDF5)\n"
      "      --reference=CSV   print and draw beside these values (columns node, Q1, Q2, RT, RN,\n"
      "                        equivalent RT, RN)\n"
      "      --list            the names of the scenes\n" LAST_USAGE,
      out);
}

/* ---- what a run holds ------------------------------------------------------------------------ */

enum { REFERENCE_COLUMNS = 6 }; /* Q1, Q2, RT, RN, equivalent RT, RN */

typedef struct run {
  dls_fe_scene *scene;
  dls_fe_scene_data data;
  dls_reduction *reduction;
  dls_contact contact;
  dls_solver *solver;
  dls_primal *primal;
  dls_primal_info primal_info;
  outcome outcome;
  dls_contact_state *state;         /* nc */
  int *vertex;                      /* nc: node of the mesh */
  double *memory;                   /* of the arrays below */
  double *r, *u;                    /* 2 nc */
  double *R, *moved;                /* 2 * contact nodes: P r; g of the second of two steps */
  dls_info first;                   /* of the first of two steps */
  double *x, *force;                /* model unknowns: displacements, H r */
  double *displacement, *reaction;  /* 2 * mesh nodes */
  double *stress;                   /* 3 * triangles */
  double *column[8];                /* nc each: x, y, ut, un, rt, rn, rt_eq, rn_eq */
  double *paper[REFERENCE_COLUMNS]; /* nc each, NaN where there is no value */
} run;

enum { X, Y, UT, UN, RT, RN, RT_EQ, RN_EQ };

static int scene_allocate(run *a) {
  const size_t nc = (size_t)a->data.candidates, nodes = (size_t)a->data.model.nodes;
  const size_t n = (size_t)a->data.model.n, mesh = (size_t)a->data.mesh->nodes;
  const size_t triangles = (size_t)a->data.mesh->triangles;
  double *next = malloc(
      (4 * nc + 4 * nodes + 2 * n + 4 * mesh + 3 * triangles + 8 * nc + REFERENCE_COLUMNS * nc) *
      sizeof *next);
  a->memory = next;
  a->state = malloc(nc * sizeof *a->state);
  a->vertex = malloc(nc * sizeof *a->vertex);
  if (!next || !a->state || !a->vertex) return 0;
  a->r = next, next += 2 * nc;
  a->u = next, next += 2 * nc;
  a->R = next, next += 2 * nodes;
  a->moved = next, next += 2 * nodes;
  a->x = next, next += n;
  a->force = next, next += n;
  a->displacement = next, next += 2 * mesh;
  a->reaction = next, next += 2 * mesh;
  a->stress = next, next += 3 * triangles;
  for (int k = 0; k < 8; k++, next += nc)
    a->column[k] = next;
  for (int k = 0; k < REFERENCE_COLUMNS; k++, next += nc)
    a->paper[k] = next;
  return 1;
}

static void scene_release(run *a) {
  dls_solver_destroy(a->solver);
  dls_primal_destroy(a->primal);
  dls_reduction_destroy(a->reduction);
  dls_fe_scene_destroy(a->scene);
  free(a->memory);
  free(a->state);
  free(a->vertex);
}

/* ---- the computation ------------------------------------------------------------------------- */

/* Returns the product of column j of A with x. */
static double column_dot(const dls_sparse *A, int j, const double *x) {
  double sum = 0;
  for (int k = A->p[j]; k < A->p[j + 1]; k++)
    sum += A->x[k] * x[A->i[k]];
  return sum;
}

/* Adds A(:,j) s to y. */
static void column_add(const dls_sparse *A, int j, double s, double *y) {
  for (int k = A->p[j]; k < A->p[j + 1]; k++)
    y[A->i[k]] += A->x[k] * s;
}

/* Fills the columns of the tables from r, R = P r and x. */
static void tabulate(run *a) {
  const dls_fe_scene_data *s = &a->data;
  for (int c = 0; c < s->candidates; c++) {
    const int node = s->candidate_node[c], vertex = s->contact_node[node];
    a->column[X][c] = s->mesh->xy[2 * vertex];
    a->column[Y][c] = s->mesh->xy[2 * vertex + 1];
    a->column[UN][c] = column_dot(&s->model.HN, node, a->x) + s->g[2 * node];
    a->column[UT][c] = column_dot(&s->model.HT, node, a->x) + s->g[2 * node + 1];
    a->column[RN][c] = a->r[2 * c];
    a->column[RT][c] = a->r[2 * c + 1];
    if (a->outcome.weighted) {
      a->column[RN_EQ][c] = a->R[2 * node];
      a->column[RT_EQ][c] = a->R[2 * node + 1];
    }
    a->outcome.Rn += a->r[2 * c];
    a->outcome.Rt += a->r[2 * c + 1];
  }
  if (a->outcome.weighted) return;
  jean_unweight(&s->weighting, a->r, 0, a->moved, a->column[RN_EQ]);
  jean_unweight(&s->weighting, a->r, 1, a->moved, a->column[RT_EQ]);
}

/* Computes r and u by a method on the condensed problem, and x from r. */
static dls_status solve_condensed(run *a, const scene_options *o, dls_error *error) {
  dls_status status = DLS_OK;
  if (!a->solver)
    status = dls_solver_create(&a->solver, 2, a->contact.nc, &o->solver.settings, error);
  if (!status)
    status = dls_solver_solve(a->solver, &a->contact, a->r, a->u, &a->outcome.info, error);
  if (status >= 0) status = dls_reduction_recover(a->reduction, a->r, a->x, error);
  if (status < 0) return status;
  status = dls_reduction_judge(a->reduction, a->data.mu, a->r, a->x, o->solver.settings.limits.tol,
                               &a->outcome.info, error);
  return status < 0 ? status : DLS_OK;
}

/* Computes r and u by the paper's sweeps, and x from r. The certificate judges the answer by the
 * tolerance of the other methods. */
static dls_status solve_as_printed(run *a, const scene_options *o, dls_error *error) {
  const dls_limits *limits = &o->solver.settings.limits;
  dls_info *info = &a->outcome.info;
  const int most = limits->max_iterations ? limits->max_iterations : 10000;
  const int sweeps = jean_sweeps(&a->contact, o->weighted, most, a->r);
  *info = (dls_info){.method = DLS_NLGS, .iterations = sweeps < 0 ? -1 - sweeps : sweeps};
  const dls_status status = dls_contact_certify(&a->contact, a->r, a->u, &info->certificate, error);
  if (status) return status;
  if (!dls_certificate_holds(&info->certificate, limits->tol))
    info->status = sweeps >= 0                ? DLS_STALLED
                   : info->iterations == most ? DLS_MAX_ITERATIONS
                                              : DLS_CANCELLED;
  return dls_reduction_recover(a->reduction, a->r, a->x, error);
}

/* Computes r, u and x on K itself from loads f and gaps g. The method ends by its own certificate;
 * the outcome holds that of the condensed problem, too. */
static dls_status solve_primal(run *a, const scene_options *o, const double *f, const double *g,
                               dls_error *error) {
  dls_primal_settings settings;
  dls_primal_settings_init(&settings);
  settings.limits = o->solver.settings.limits;
  dls_status status = DLS_OK;
  if (!a->primal) status = dls_primal_create(&a->primal, &a->data.model, &settings, error);
  if (!status)
    status =
        dls_primal_solve(a->primal, f, g, a->data.mu, a->x, a->r, a->u, &a->primal_info, error);
  if (status < 0) return status;
  a->outcome.primal = &a->primal_info;
  a->outcome.info.status = a->primal_info.status;
  a->outcome.info.iterations = a->primal_info.iterations;
  return dls_contact_certify(&a->contact, a->r, NULL, &a->outcome.info.certificate, error);
}

/* Computes a step from loads f and gaps g; < 0 or DLS_OK. The outcome says if the solver arrived.
 */
static dls_status scene_step(run *a, const scene_options *o, const double *f, const double *g,
                             dls_error *error) {
  dls_status status = dls_reduction_load(a->reduction, f, g, error);
  if (!status) status = dls_reduction_contact(a->reduction, a->data.mu, &a->contact, error);
  if (status) return status;
  const double start = cpu_seconds();
  status = o->solver.primal ? solve_primal(a, o, f, g, error)
           : o->as_printed  ? solve_as_printed(a, o, error)
                            : solve_condensed(a, o, error);
  a->outcome.solve_cpu_seconds += cpu_seconds() - start;
  progress_end();
  return status;
}

/* Computes the steps of the scene. Friction works on what the second step adds, so that its g takes
 * off the tangential positions of the first one. */
static dls_status scene_steps(run *a, const scene_options *o, dls_error *error) {
  const dls_fe_scene_data *s = &a->data;
  if (!s->f_first) return scene_step(a, o, s->f, s->g, error);
  dls_status status = scene_step(a, o, s->f_first, s->g, error);
  if (status) return status;
  a->first = a->outcome.info;
  for (int k = 0; k < s->model.nodes; k++) {
    a->moved[2 * k] = s->g[2 * k];
    a->moved[2 * k + 1] = -column_dot(&s->model.HT, k, a->x);
  }
  status = scene_step(a, o, s->f, a->moved, error);
  if (!status && a->first.status) a->outcome.info.status = a->first.status;
  return status;
}

/* Computes everything from the model to the tables; < 0 or DLS_OK. */
static dls_status scene_compute(run *a, const scene_options *o, dls_error *error) {
  a->outcome.d = 2;
  a->outcome.nc = a->data.candidates;
  a->outcome.scene = o->name;
  a->outcome.weighted = o->weighted;
  a->outcome.as_printed = o->as_printed;
  dls_status status = reduce_to_W(&a->reduction, &a->data.model, error);
  if (!status) status = scene_steps(a, o, error);
  if (status) return status;

  const dls_model *model = &a->data.model;
  status = dls_reduction_nodal(a->reduction, a->r, a->R, error);
  if (!status) status = dls_contact_states(&a->contact, a->r, a->u, a->state, error);
  a->outcome.freedom = NO_FREEDOM;
  if (!status && dls_solved(a->outcome.info.status))
    status = count_freedom(&a->contact, a->r, &a->outcome.freedom, error);
  if (!status) status = dls_fe_scene_displacement(a->scene, a->x, a->displacement, error);
  if (status) return status;
  for (int i = 0; i < model->n; i++)
    a->force[i] = 0;
  for (int k = 0; k < model->nodes; k++) {
    column_add(&model->HN, k, a->R[2 * k], a->force);
    column_add(&model->HT, k, a->R[2 * k + 1], a->force);
  }
  status = dls_fe_scene_displacement(a->scene, a->force, a->reaction, error);
  if (!status)
    status = dls_fe_stress(a->data.mesh, a->data.E, a->data.nu, a->displacement, a->stress, error);
  if (!status) tabulate(a);
  return status;
}

/* ---- the paper's values ---------------------------------------------------------------------- */

/* Reads rows "node,Q1,Q2,RT,RN,RT_eq,RN_eq" after a header, an empty field where there is no value.
 * Returns 1 if all were read. */
static int read_reference(const char *path, run *a) {
  for (int k = 0; k < REFERENCE_COLUMNS; k++)
    for (int c = 0; c < a->data.candidates; c++)
      a->paper[k][c] = NAN;
  FILE *file = fopen(path, "r");
  if (!file) return refuse("%s: %s", path, strerror(errno));
  char line[512];
  int number = 0, good = fgets(line, sizeof line, file) != NULL;
  while (good && fgets(line, sizeof line, file)) {
    number++;
    const char *field = line;
    int node;
    good = dlsi_read_whole(&field, 1, a->data.candidates, &node);
    for (int k = 0; good && k < REFERENCE_COLUMNS && *field == ','; k++) {
      field++;
      (void)read_real(&field, &a->paper[k][node - 1]);
    }
    good = good && (*field == '\n' || *field == '\r' || *field == '\0');
  }
  fclose(file);
  if (!good) complain("%s: row %d is not 'node,Q1,Q2,RT,RN,RT_eq,RN_eq'", path, number);
  return good;
}

/* ---- tables ---------------------------------------------------------------------------------- */

/* A column of a table: its name, the computed values, the paper's or NULL. */
typedef struct quantity {
  const char *name;
  const double *ours, *paper;
} quantity;

static void print_cell(const quantity *q, int c, double scale, double *worst) {
  printf("  %12.5e", q->ours[c]);
  if (!q->paper) return;
  if (isnan(q->paper[c])) {
    printf("  %12s  %8s", "-", "-");
    return;
  }
  const double difference = (q->ours[c] - q->paper[c]) / scale;
  printf("  %12.5e  %8.1e", q->paper[c], difference);
  if (fabs(difference) > *worst) *worst = fabs(difference);
}

static void print_quantities(const run *a, const quantity *q) {
  const int nc = a->data.candidates;
  double worst[2] = {0}, scale[2] = {0};
  for (int k = 0; k < 2 && q[k].paper; k++)
    scale[k] = largest_entry(q[k].paper, nc);
  if (scale[1] == 0) scale[1] = scale[0]; /* Fig. 4: all Q2 are 0 */
  printf("from 0  status");
  for (int k = 0; k < 2; k++) {
    printf("  %12s", q[k].name);
    if (q[k].paper) printf("  %12s  %8s", "paper", "diff/max");
  }
  putchar('\n');
  for (int c = 0; c < nc; c++) {
    printf("%6d  %-6s", c, state_word(a->state[c]));
    for (int k = 0; k < 2; k++)
      print_cell(&q[k], c, scale[k], &worst[k]);
    putchar('\n');
  }
  if (!q[0].paper) return;
  printf("largest diff/max:");
  for (int k = 0; k < 2; k++)
    printf(" %s %.1e%s", q[k].name, worst[k], k ? "\n" : ",");
}

/* Tells if P^-1 of concentrated reactions obeys the laws, too ([Jean 1988] Propositions 2 and 3),
 * to 1e-3 of the largest: ten times what the paper's own reactions are exact to. */
static void print_admissible(const run *a) {
  const double *rn = a->column[RN_EQ], *rt = a->column[RT_EQ];
  const double small = 1e-3 * largest_entry(rn, a->data.candidates);
  int pulls = 0, outside = 0;
  for (int c = 0; c < a->data.candidates; c++) {
    pulls += rn[c] < -small;
    outside += rn[c] >= -small && fabs(rt[c]) > a->data.mu[c] * rn[c] + small;
  }
  if (pulls + outside == 0)
    puts("admissible: they solve the problem with weighted reactions");
  else
    printf("not admissible: %d pull, %d more lie outside of the cone\n", pulls, outside);
}

static void print_run(const run *a, const scene_options *o) {
  const outcome *out = &a->outcome;
  const dls_certificate *c = &out->info.certificate;
  printf("%s, %s reactions, %s: %s, %d %s, residual %.1e, %s of CPU\n", o->name,
         o->weighted ? "weighted" : "concentrated", method_word(out),
         o->as_printed && out->info.status == DLS_STALLED ? "stopped by the paper's rule"
                                                          : dls_status_text(out->info.status),
         out->info.iterations, iteration_word(out->info.method, out->info.iterations), c->residual,
         in_words(out->solve_cpu_seconds).text);
  if (a->data.f_first)
    printf("first step, %s alone: %s, %d %s, residual %.1e\n",
           o->block.order == DLS_FE_TOP_FIRST ? "top" : "side", dls_status_text(a->first.status),
           a->first.iterations, iteration_word(a->first.method, a->first.iterations),
           a->first.certificate.residual);
  print_residuals("", c);
  print_stages(&out->info);
  if (out->primal)
    printf("equilibrium %.1e (floor %.1e), laws %.1e, %d threshold%s\n", out->primal->equilibrium,
           out->primal->equilibrium_floor, out->primal->laws.residual, out->primal->thresholds,
           plural(out->primal->thresholds));
  const int with = o->reference != NULL;
  const quantity positions[] = {{"Q1 [m]", a->column[UT], with ? a->paper[0] : NULL},
                                {"Q2 [m]", a->column[UN], with ? a->paper[1] : NULL}};
  const quantity reactions[] = {{"RT [N/m]", a->column[RT], with ? a->paper[2] : NULL},
                                {"RN [N/m]", a->column[RN], with ? a->paper[3] : NULL}};
  const quantity equivalent[] = {{"RT eq [N/m]", a->column[RT_EQ], with ? a->paper[4] : NULL},
                                 {"RN eq [N/m]", a->column[RN_EQ], with ? a->paper[5] : NULL}};
  putchar('\n');
  print_quantities(a, positions);
  putchar('\n');
  print_quantities(a, reactions);
  puts(o->weighted ? "\nequivalent concentrated reactions, P r"
                   : "\nequivalent weighted reactions, P^-1 r");
  print_quantities(a, equivalent);
  if (!o->weighted) print_admissible(a);
  char text[FREEDOM_ROOM];
  if (*freedom_words(out->freedom, out->info.forces, text)) printf("%s\n", text);
  printf("\nresultants of the reactions: Rx = %.5e, Ry = %.5e N/m\n", out->Rt, out->Rn);
}

/* ---- files ----------------------------------------------------------------------------------- */

static int write_csv(const run *a, const scene_options *o) {
  FILE *file = open_table(o->out, "contact.csv",
                          "candidate_from_0,x,y,ut,un,rt,rn,status,rt_eq,rn_eq,cell\n");
  if (!file) return 0;
  for (int c = 0; c < a->data.candidates; c++) {
    fprintf(file, "%d", c);
    for (int k = X; k <= RN; k++)
      fprintf(file, ",%.17g", a->column[k][c]);
    fprintf(file, ",%s", state_word(a->state[c]));
    fprintf(file, ",%.17g,%.17g,%.17g\n", a->column[RT_EQ][c], a->column[RN_EQ][c],
            a->data.cell[c]);
  }
  return close_file(file, "contact.csv");
}

static int write_files(const run *a, const scene_options *o) {
  char path[PATH_ROOM], name[256], title[256];
  dls_error error = {0};
  FILE *json = write_csv(a, o) ? open_in(o->out, "result.json") : NULL;
  if (json) print_json(json, &a->outcome);
  if (!json || !close_file(json, "result.json")) return EXIT_BAD_INPUT;
  (void)snprintf(name, sizeof name, "%s.vtu", o->name);
  if (!join_path(path, o->out, name)) return EXIT_BAD_INPUT;
  for (int c = 0; c < a->data.candidates; c++)
    a->vertex[c] = a->data.contact_node[a->data.candidate_node[c]];
  const dls_fe_fields fields = {.displacement = a->displacement,
                                .reaction = a->reaction,
                                .stress = a->stress,
                                .nu = a->data.nu,
                                .candidates = a->data.candidates,
                                .node = a->vertex,
                                .state = a->state,
                                .gap = a->column[UN],
                                .slip = a->column[UT]};
  if (dls_fe_write_fields(path, a->data.mesh, &fields, &error)) return complain_of(path, &error);
  (void)snprintf(title, sizeof title, "%s, %s reactions, %s", o->name,
                 o->weighted ? "weighted" : "concentrated", method_word(&a->outcome));
  const scene_picture picture = {.directory = o->out,
                                 .title = title,
                                 .scene = &a->data,
                                 .displacement = a->displacement,
                                 .reaction = a->reaction,
                                 .state = a->state,
                                 .x = a->column[X],
                                 .rt = a->column[RT],
                                 .rn = a->column[RN],
                                 .paper_rt = o->reference ? a->paper[2] : NULL,
                                 .paper_rn = o->reference ? a->paper[3] : NULL};
  return draw_scene(&picture);
}

/* ---- the command ----------------------------------------------------------------------------- */

static int run_scene(const scene_options *o) {
  run a = {0};
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  int result = EXIT_BAD_INPUT;
  if (dls_fe_scene_create_with(&a.scene, o->name, o->weighted, &o->block, &error)) goto failed;
  dls_fe_scene_get(a.scene, &a.data);
  if (!scene_allocate(&a)) goto failed;
  if (o->reference && !read_reference(o->reference, &a)) goto end;
  if (o->out && !take_folder(o->out, "scene", o->name)) goto end;
  if (scene_compute(&a, o, &error)) goto failed;
  if (is_json())
    print_json(stdout, &a.outcome);
  else if (!is_quiet())
    print_run(&a, o);
  hint_size(a.data.mesh, a.displacement);
  char unsolved[UNSOLVED_ROOM], title[UNSOLVED_ROOM + 100];
  const dls_info *info = &a.outcome.info;
  (void)snprintf(
      title, sizeof title, dls_solved(info->status) ? "%.80s" : "%.80s [%s]", o->name,
      unsolved_words(info->status, info->certificate.residual, unsolved, sizeof unsolved));
  if (o->save && dls_fclib_write_local(o->save, &a.contact, title, a.r, a.u, &error)) {
    (void)complain_of(o->save, &error);
    goto end;
  }
  if (o->out && write_files(&a, o) != EXIT_SOLVED) goto end;
  if (!is_json()) print_ending(a.outcome.info.status, &a.outcome.info);
  result = dls_solved(a.outcome.info.status) ? EXIT_SOLVED : EXIT_NOT_SOLVED;
  goto end;
failed:
  (void)complain_of(o->name, &error);
end:
  scene_release(&a);
  return result;
}

static taken list_scenes(void) {
  for (int k = 0; dls_fe_scene_name(k); k++)
    printf("%-12s %s\n", dls_fe_scene_name(k), dls_fe_scene_description(k));
  for (int k = 0; dls_forming_name(k); k++)
    printf("%-12s %s\n", dls_forming_name(k), dls_forming_description(k));
  for (int k = 0; dls_moving_name(k); k++)
    printf("%-12s %s\n", dls_moving_name(k), dls_moving_description(k));
  return OPTION_DONE;
}

/* Reads TOP,SIDE[,SIDE_TOP]. */
static taken parse_load(const char *text, dls_fe_scene_settings *block) {
  const char *at = text;
  block->has_load = 1;
  if (read_real(&at, &block->top) && *at++ == ',' && read_real(&at, &block->side)) {
    block->side_top = block->side;
    if (!*at || (*at++ == ',' && read_real(&at, &block->side_top) && !*at)) return OPTION_TAKEN;
  }
  return (taken)refuse("--load: '%s' is not TOP,SIDE or TOP,SIDE,SIDE_TOP", text);
}

static taken parse_order(const char *text, dls_fe_order *order) {
  static const char *const words[] = {"together", "top-first", "side-first"};
  const int k = parse_word("order", text, words, 3);
  *order = (dls_fe_order)k;
  return k >= 0 ? OPTION_TAKEN : OPTION_WRONG;
}

static taken parse_young(const char *text, double *E) {
  const taken result = parse_number("young", text, E);
  if (result != OPTION_TAKEN || *E > 0) return result;
  return (taken)refuse("--young: '%s' is not a number > 0", text);
}

enum { KEY_YOUNG = 256, KEY_LOAD, KEY_ORDER, KEY_LIST };

static taken take_scene_option(int key, const char *text, void *data) {
  scene_options *o = data;
  switch (key) {
  case KEY_YOUNG:
    return parse_young(text, &o->block.E);
  case KEY_LOAD:
    return parse_load(text, &o->block);
  case KEY_ORDER:
    return parse_order(text, &o->block.order);
  case KEY_LIST:
    return list_scenes();
  default:
    o->as_printed = key == 'm' && !strcmp(text, "jean");
    return o->as_printed ? OPTION_TAKEN : take_solver_option(key, text, &o->solver);
  }
}

/* Complains of a name that is no scene; returns EXIT_BAD_INPUT. */
static int no_scene(const char *name) {
  nearest near = {.word = name};
  for (int k = 0; scene_name(k); k++)
    nearest_try(&near, scene_name(k));
  return complain("'%s' is no scene%s", name,
                  near.count ? nearest_words(&near) : "; 'delassus scene --list' names them");
}
int command_scene(int argc, char **argv) {
  static const option_row options[] = {SOLVER_OPTIONS(scene_options, solver),
                                       ROW(A_MESH, "mesh", 0, scene_options, block.nx),
                                       ROW(A_NUMBER, "mu", 0, scene_options, block.mu),
                                       VALUE("young", KEY_YOUNG),
                                       ROW(A_NUMBER, "grade", 0, scene_options, block.grade),
                                       ROW(A_NUMBER, "poisson", 0, scene_options, block.nu),
                                       VALUE("load", KEY_LOAD),
                                       VALUE("order", KEY_ORDER),
                                       ROW(A_FLAG, "weighted", 'w', scene_options, weighted),
                                       ROW(A_TEXT, "out", 'o', scene_options, out),
                                       PICTURE_OPTION,
                                       ROW(A_TEXT, "save", 's', scene_options, save),
                                       ROW(A_TEXT, "reference", 0, scene_options, reference),
                                       FLAG("list", KEY_LIST),
                                       LAST_OPTIONS};
  static const command scene = {options, scene_usage, take_scene_option, 1};
  scene_options o = {0};
  solver_options_init(&o.solver, scene_tol);
  dls_fe_scene_settings_init(&o.block);
  const int stop = take_options(argc, argv, &scene, &o);
  if (stop != GO_ON) return stop;
  if (!settle_solver_options(&o.solver)) return EXIT_BAD_INPUT;
  o.name = argv[optind];
  if (!kind_of_scene(o.name)) return no_scene(o.name);
  watch_interrupt();
  return run_scene(&o);
}
