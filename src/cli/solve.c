/* solve.c: delassus solve FILE, delassus solve --lcp M.mtx q.mtx: solves problems from files. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "problem/hints.h"
#include "solve.h"

enum { KEY_FORCES = 256 };

static void solve_usage(FILE *out) {
  fputs("Usage: delassus solve [OPTION]... FILE|SCENE\n"
        "  or:  delassus solve --stiffness=K --HN=N --HT=T --f=F --mu=MU [OPTION]...\n"
        "  or:  delassus solve --W=W --q=Q --mu=MU [OPTION]...\n"
        "  or:  delassus solve --lcp [OPTION]... M.mtx q.mtx | FILE.txt\n"
        "Solves a contact problem from a file (FCLIB, local or global; or text), of a scene,\n"
        "or from the matrices of a host code, or an LCP (Matrix Market, or text) by Lemke's\n"
        "method. The last line on stdout is 'solved' or 'not solved: WHY'. Each file may be a\n"
        "pipe, or - for standard input.\n"
        "delassus-solve(1) has the layout of FCLIB files.\n"
        "\n",
        out);
  source_usage(out);
  fputs("\nThe solver:\n", out);
  solver_usage(out, "", 1e-8);
  fputs(
      "  -f, --facets=M        lemke in 3D: facets of the friction cone, even, 4 to 64 (8)\n"
      "      --plan=STEPS      steps for auto, for example sweeps:30,newton,homotopy (30: limit "
      "of\n"
      "                        iterations); a wrong word prints the right ones\n"
      "      --without=STEPS   steps that auto leaves out, for example homotopy,scatter\n"
      "      --explain         print what auto did: the regime, each step, its cost, why it ended\n"
      "      --forces=WHICH    if W does not determine the reactions: any (default), or least,\n"
      "                        those with the least sum of w |r|^2, on W\n"
      "\nThe answer:\n"
      "      --print           print state, gap, r and u of each contact, and x\n"
      "      --csv=DIR         write the same to DIR/r.csv and DIR/x.csv, with all digits\n"
      "  -o, --out=OUT         write the problem with its solution (FCLIB); OUT.mtx: r, or z of "
      "an\n"
      "                        LCP (Matrix Market)\n"
      "  -H, --history=CSV     write iteration (of all stages), CPU seconds, residual and stage\n"
      "                        during the solve; the last row is the answer\n"
      "  -P, --plot=DIR        write DIR/history.csv, and a picture of it\n"
      "  -p, --proof           if there is no answer, print the vectors behind the verdict: the\n"
      "                        proof that there is no solution, or the ray\n"
      "      --prove           prove the answer: improve r and bound its error, on W\n"
      "      --limit=F1        in place of an answer: the largest lambda with an answer for the\n"
      "                        loads f + lambda f1, and the least with a proof that there is none\n"
      "      --lcp             the files hold an LCP\n" LAST_USAGE,
      out);
}

/* ---- the history of a solve ------------------------------------------------------------------ */

typedef struct history {
  FILE *file;
  const char *stage;     /* "": none yet */
  int before, iteration; /* of the stages that are over, of this one */
} history;

/* Writes a row: the progress callback of --history. The last row never counts fewer iterations than
 * the row before it: rows also count the sweeps that Newton's method takes before its first step,
 * which info.iterations leaves out. */
static int write_row(void *data, const dls_progress *p) {
  history *h = data;
  if (!p->last && (p->iteration < h->iteration || strcmp(p->stage, h->stage) != 0)) {
    h->before += h->iteration;
    h->stage = p->stage;
  }
  if (!p->last) h->iteration = p->iteration;
  const int shown = h->before + h->iteration;
  (void)fprintf(h->file, "%d,%.9f,", p->last && p->iteration > shown ? p->iteration : shown,
                p->cpu_seconds);
  if (p->residual >= 0) (void)fprintf(h->file, "%.17g", p->residual);
  (void)fprintf(h->file, ",%s\n", p->stage);
  return show_progress(NULL, p);
}

/* ---- contact problems ------------------------------------------------------------------------ */

/* Writes the problem's title into text (size), followed by `unsolved` instead of what an earlier
 * solve has put there. */
static const char *make_title(const problem *p, const char *unsolved, char *text, size_t size) {
  const char *title = problem_title(p), *before = strstr(title, "[not solved: ");
  int length = before ? (int)(before - title) : (int)strlen(title);
  while (length > 0 && title[length - 1] == ' ')
    length--;
  if (*unsolved)
    (void)snprintf(text, size, "%.*s%s[%s]", length, title, length ? " " : "", unsolved);
  else
    (void)snprintf(text, size, "%.*s", length, title);
  return text;
}

/* Writes r as a Matrix Market file, or the problem with its solution as FCLIB: as it was condensed
 * where the format does not hold the model (a flexibility, a weighting). x: n, or NULL. unsolved:
 * in a comment, or in the title. */
static dls_status write_solution(const char *out, const problem *p, const double *r,
                                 const double *u, const double *x, const char *unsolved,
                                 dls_error *error) {
  char room[1000];
  const char *title = make_title(p, unsolved, room, sizeof room);
  const size_t length = strlen(out);
  const int m = p->contact.d * p->contact.nc;
  if (length > 4 && strcmp(out + length - 4, ".mtx") == 0)
    return dls_mtx_write_commented(out, &(dls_dense){m, 1, m, r}, unsolved, error);
  const int is_local =
      !(p->reduction || p->of_bodies) || p->model.P.p || p->model.operator_kind == DLS_FLEXIBILITY;
  if (is_local && p->on_K)
    return *error = (dls_error){.status = DLS_E_UNSUPPORTED,
                                .message = "a weighting needs W in this format: --on=W"},
           DLS_E_UNSUPPORTED;
  if (is_local) return dls_fclib_write_local(out, &p->contact, title, r, u, error);
  return dls_fclib_write_global(out, &p->model, p->f, p->g, p->mu, title, x, r, u, error);
}

/* Recovers the unknowns of a problem of bodies: *x := new array of n. */
static dls_status recover(problem *p, const double *r, double **x, dls_error *error) {
  dls_reduction_settings settings;
  dls_reduction_settings_init(&settings);
  settings.form_W = 0;
  dls_status status = dls_reduction_create(&p->reduction, &p->model, &settings, error);
  if (!status) status = dls_reduction_load(p->reduction, p->f, p->g, error);
  if (status) return status;
  *x = malloc((size_t)p->model.n * sizeof **x);
  return *x ? dls_reduction_recover(p->reduction, r, *x, error) : no_memory(error);
}

/* Returns 1 for a status that a vector of the solver stands behind. */
static int has_vectors(dls_status status) {
  return status == DLS_NO_SOLUTION || status == DLS_NO_SOLUTION_LIKELY || status == DLS_RAY;
}

/* Prints how many candidates are in each state; returns 0 after a complaint. */
static int print_states(const problem *p, const double *r, const double *u) {
  dls_contact_state *state = find_states(p, r, u);
  int count[3] = {0};
  if (!state) return 0;
  for (int c = 0; c < p->contact.nc; c++)
    count[state[c]]++;
  if (problem_parts(p) == 1)
    printf("  free %d, touching %d\n", count[DLS_FREE], count[DLS_SLIP] + count[DLS_STICK]);
  else
    printf("  free %d, slip %d, stick %d\n", count[DLS_FREE], count[DLS_SLIP], count[DLS_STICK]);
  free(state);
  return 1;
}

/* Prints what dls_explain says, a line each. */
static void print_explanation(const dls_info *info) {
  char text[200 * (DLS_STAGES_MAX + 4)];
  (void)dls_explain(info, text, sizeof text);
  for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n"))
    printf("    %s\n", line);
}

/* Prints what is known of other answers, a line for each fact. */
static void print_others(const dls_info *info) {
  if (info->unique == DLS_UNIQUE_NO) puts("  another certified answer was found");
  if (info->unique == DLS_UNIQUE_YES) puts("  no other answer: proved");
  if (info->ambiguous)
    printf("  %d contact%s with several answers if all others are held\n", info->ambiguous,
           plural(info->ambiguous));
}

enum { hint_rows = 300 }; /* of a problem that is looked at in full for a hint */

/* Returns 0 after a complaint. */
static int print_outcome(const char *path, const problem *p, const outcome *o, int explain,
                         const double *r, const double *u) {
  const dls_certificate *c = &o->info.certificate;
  problem_print(path, p);
  printf("  %s: %s, %d %s, residual %.2e, %s of CPU\n", dls_method_name(o->info.method),
         dls_status_text(o->info.status), o->info.iterations,
         iteration_word(o->info.method, o->info.iterations), c->residual,
         in_words(o->solve_cpu_seconds).text);
  print_residuals("  ", c);
  print_others(&o->info);
  if (explain)
    print_explanation(&o->info);
  else
    print_stages(&o->info);
  printf("  penetration %.2e, adhesion %.2e, cone violation %.2e, slip direction %.2e, "
         "complementarity %.2e\n",
         c->penetration, c->adhesion, c->cone_violation, c->slip_direction, c->complementarity);
  if (!print_states(p, r, u) || !put_reactions(stdout, p, r)) return 0;
  char text[FREEDOM_ROOM];
  if (*freedom_words(o->freedom, o->info.forces, text)) printf("  %s\n", text);
  verdict_print(&o->verdict, o->proof);
  unsettled_print(&o->unsettled);
  dls_diagnosis facts;
  dls_error error = {0};
  const int m = p->contact.d * p->contact.nc, limit = dls_solved(o->info.status) ? 0 : hint_rows;
  if (m == 0 || p->on_K || (dls_solved(o->info.status) && r[0] != 0)) return 1;
  if (dls_contact_diagnose(&p->contact, m <= limit ? limit : 0, &facts, &error))
    return complain_of(path, &error), 0;
  print_hints(facts.hints);
  return 1;
}

/* Proves an answer on W: r, u, x (or NULL) := the improved ones. */
static dls_status prove(problem *p, outcome *o, double *r, double *u, double *x, dls_error *error) {
  dls_status status = dls_contact_prove(&p->contact, r, &o->proved, r, error);
  if (!status && o->proved.kind)
    status = dls_contact_certify(&p->contact, r, u, &o->info.certificate, error);
  if (status || !x || !o->proved.kind) return status;
  return p->engine ? p->engine->recover(p, r, x, error)
                   : dls_reduction_recover(p->reduction, r, x, error);
}

source solve_source(const solve_options *options) {
  source from = options->from;
  if (options->limit) from.engine = NULL;
  const dls_solver_settings *asked = &options->solver.settings;
  if ((options->prove || asked->method != DLS_AUTO || asked->plan || asked->without ||
       asked->forces) &&
      !(from.matrices.where && !strcmp(from.matrices.where, "K")))
    from.matrices.on = DLS_ON_W;
  return from;
}

void solution_free(solution *a) {
  dls_solver_destroy(a->solver);
  free(a->r);
  free(a->u);
  free(a->x);
}

dls_status problem_solve(problem *p, const solve_options *options, solution *a, outcome *o,
                         dls_error *error) {
  const size_t m = (size_t)p->contact.d * (size_t)p->contact.nc;
  *o = (outcome){.d = p->contact.d, .nc = p->contact.nc};
  a->r = malloc(m * sizeof *a->r);
  a->u = malloc(m * sizeof *a->u);
  if (p->reduction) a->x = malloc((size_t)p->model.n * sizeof *a->x);
  if (!a->r || !a->u || (p->reduction && !a->x)) return no_memory(error);
  dls_solver_settings settings = options->solver.settings;
  settings.limits.blocks = p->contact.Wb.x ? p->contact.Wb.p[o->nc] : 0;
  if (p->of_bodies) {
    const dls_status counted = dls_bodies_count(&p->contact, &settings.limits.blocks, error);
    if (counted) return counted;
  }
  const double start = cpu_seconds();
  dls_status status = DLS_STALLED;
  int mover = 0;
  if (p->engine)
    status = p->engine->solve(p, &settings, a->r, a->u, a->x, &o->info, error);
  else if (p->reduction)
    status = dls_reduction_solve(p->reduction, p->mu, &settings, a->r, a->u, a->x, &o->info, error);
  const double *motion = status != DLS_NO_SOLUTION ? NULL
                         : p->engine               ? p->engine->motion(&mover)
                                                   : dls_reduction_motion(p->reduction, &mover);
  if (!p->reduction ||
      (!p->on_K && !motion && has_vectors(status))) { /* which the solver on W has */
    status = dls_solver_create(&a->solver, o->d, o->nc, &settings, error);
    if (!status) status = dls_solver_solve(a->solver, &p->contact, a->r, a->u, &o->info, error);
  }
  o->solve_cpu_seconds = cpu_seconds() - start;
  progress_end();
  if (status < 0) return status;
  o->freedom = !dls_solved(status) || o->info.error > 0 ? NO_FREEDOM
               : p->on_K == 2                           ? FREEDOM_TOO_LARGE
                                                        : FREEDOM_ON_K;
  o->proof = options->proof;
  o->verdict = (verdict){.rows = o->nc,
                         .stride = o->d,
                         .farkas = a->solver ? dls_solver_farkas(a->solver) : NULL,
                         .ray = a->solver ? dls_solver_direction(a->solver) : NULL,
                         .motion = motion,
                         .unknowns = p->model.n,
                         .mover = mover};
  verdict_fill(&o->verdict, status, 0);
  return status;
}

/* ---- how much is carried --------------------------------------------------------------------- */

static void print_limit(const char *path, dls_status status, const dls_limit *l) {
  if (is_json()) {
    print_json_head("limit", status_word(status), NULL);
    print_json_field(stdout, "carried", l->carried);
    print_json_field(stdout, "refused", l->refused);
    print_json_field(stdout, "open", l->open);
    printf(",\n  \"proved\": %s,\n  \"solves\": %d\n}\n", l->proved ? "true" : "false", l->solves);
    return;
  }
  if (!is_quiet()) {
    printf("%s: loads f + lambda f1, %d solves\n", path, l->solves);
    printf("  carried at %.9g: an answer is certified%s\n", l->carried,
           l->unique == DLS_UNIQUE_YES ? ", the only one" : "");
    if (l->proved)
      printf("  refused at %.9g: a motion proves that there is no answer\n", l->refused);
    else
      printf("  nothing is refused up to %g\n", l->refused);
    if (!isnan(l->open)) printf("  without a verdict at %.9g\n", l->open);
  }
  print_ending(status, NULL);
}

/* Finds the limit of loads beside those of the problem. */
static int solve_limit(const char *path, problem *p, const solve_options *options) {
  dls_limit limit;
  dls_error error;
  dls_limit_settings settings;
  if (!p->matrices || !p->reduction)
    return complain("--limit: is for --stiffness or --flexibility, with --HN or --H");
  double *f1 = matrices_read_loads(options->limit, &options->from.matrices, p);
  double *r = malloc((size_t)p->contact.d * (size_t)p->contact.nc * sizeof *r);
  int result = EXIT_BAD_INPUT;
  dls_limit_settings_init(&settings);
  settings.limits = options->solver.settings.limits;
  if (f1 && !r)
    (void)complain("out of memory");
  else if (f1) {
    const dls_status status = dls_limit_load(p->reduction, p->f, f1, p->g, p->mu, NULL, &settings,
                                             r, NULL, NULL, &limit, &error);
    progress_end();
    if (status < 0)
      (void)complain_of(path, &error);
    else {
      print_limit(path, status, &limit);
      result = status == DLS_OK ? EXIT_SOLVED : EXIT_NOT_SOLVED;
    }
  }
  free(f1);
  free(r);
  return result;
}

/* Solves the problem in a file or, where options name matrices, of these. */
static int solve_contact(const char *path, const solve_options *options) {
  problem p = {0};
  solution a = {0};
  outcome o;
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  int result = EXIT_BAD_INPUT;
  const source from = solve_source(options);
  if (!problem_open(path, &from, &p)) { /* a reduction may have been cancelled */
    if (was_interrupted()) result = end_command(EXIT_NOT_SOLVED, NULL);
    goto end;
  }
  problem_fit_threads(&p);
  if (is_verbose()) print_reduction(stderr, &p);
  if (options->limit) {
    result = solve_limit(path, &p, options);
    goto end;
  }
  const dls_status status = problem_solve(&p, options, &a, &o, &error);
  if (status < 0) goto failed;
  double *const r = a.r, *const u = a.u;
  o.prove = options->prove && dls_solved(status) && !p.on_K;
  if (o.prove && prove(&p, &o, r, u, a.x, &error)) goto failed;
  if (dls_solved(status) && !p.on_K && count_freedom(&p.contact, r, &o.freedom, &error))
    goto failed;
  const int wrong = !p.on_K && !dls_solved(status) &&
                    o.info.certificate.residual > options->solver.settings.limits.tol &&
                    !o.verdict.says;
  if (wrong && !unsettled_find(&o.unsettled, &p.contact, r, u)) goto end;
  if (p.of_bodies && (options->out || options->print || options->csv) &&
      recover(&p, r, &a.x, &error))
    goto failed;
  if (is_json())
    print_json(stdout, &o);
  else if (!is_quiet() && !print_outcome(path, &p, &o, options->explain, r, u))
    goto end;
  if (dls_solved(status) && p.matrices) hint_answer(&p, r);
  char room[UNSOLVED_ROOM];
  const char *unsolved = unsolved_words(status, o.info.certificate.residual, room, sizeof room);
  if (options->out && write_solution(options->out, &p, r, u, a.x, unsolved, &error)) {
    (void)complain_of(options->out, &error);
    goto end;
  }
  if (options->csv && !write_results(options->csv, &p, &o, r, u, a.x, unsolved)) goto end;
  if (options->print && !print_results(&p, &o, r, u, a.x)) goto end;
  if (!is_json() && o.prove)
    print_proved(&o.proved);
  else if (!is_json())
    print_ending(status, &o.info);
  result = dls_solved(status) ? EXIT_SOLVED : EXIT_NOT_SOLVED;
  goto end;
failed:
  (void)complain_of(path, &error);
end:
  solution_free(&a);
  problem_free(&p);
  return result;
}

/* ---- LCPs ------------------------------------------------------------------------------------ */

/* The solver of an LCP, one of the two, and its answer. */
typedef struct lcp_run {
  dls_lemke *lemke;
  dls_principal *principal; /* for a sparse M */
  dls_status status;
  dls_lcp_certificate certificate;
  int iterations;
  char words[96]; /* the steps that it took */
  double cpu_seconds;
} lcp_run;

static const char *lcp_method(const lcp_run *run) {
  return run->lemke ? "lemke" : "principal";
}

/* Solves by Lemke's method. z: n. Returns DLS_OK or an error. */
static dls_status run_lemke(lcp_run *run, const dls_lcp *lcp, const dls_limits *limits, double *z,
                            dls_error *error) {
  dls_lemke_settings settings;
  dls_lemke_info info;
  dls_lemke_settings_init(&settings);
  settings.limits = *limits;
  dls_status status = dls_lemke_create(&run->lemke, lcp->n, &settings, error);
  if (!status) status = dls_lemke_solve(run->lemke, lcp, z, NULL, &info, error);
  if (status < 0) return status;
  run->status = status;
  run->certificate = info.certificate;
  run->iterations = info.pivots + info.crash_rounds;
  (void)snprintf(run->words, sizeof run->words, "%d round%s of the crash start, %d pivot%s",
                 info.crash_rounds, plural(info.crash_rounds), info.pivots, plural(info.pivots));
  return DLS_OK;
}

/* As run_lemke, by active sets with sparse factors. */
static dls_status run_principal(lcp_run *run, const dls_lcp *lcp, const dls_limits *limits,
                                double *z, dls_error *error) {
  dls_principal_settings settings;
  dls_principal_info info;
  dls_principal_settings_init(&settings);
  settings.limits = *limits;
  settings.limits.blocks = lcp->Ms.p[lcp->n] + 1;
  dls_status status = dls_principal_create(&run->principal, lcp->n, &settings, error);
  if (!status) status = dls_principal_solve(run->principal, lcp, z, NULL, &info, error);
  if (status < 0) return status;
  run->status = status;
  run->certificate = info.certificate;
  run->iterations = info.iterations;
  (void)snprintf(run->words, sizeof run->words, "%d factorisation%s, %d of the path",
                 info.factorizations, plural(info.factorizations), info.path_steps);
  return DLS_OK;
}

/* Fills v of an LCP after a solve; x: n, room for its vector. Returns DLS_OK, or an error. */
static dls_status fill_lcp_verdict(verdict *v, const lcp_run *run, const dls_lcp *lcp, double *x,
                                   dls_error *error) {
  const dls_status status = run->status;
  double violation = INFINITY;
  dls_status done = DLS_OK;
  *v = (verdict){.rows = lcp->n, .stride = 1};
  if (status == DLS_NO_SOLUTION) done = dls_lemke_farkas(run->lemke, x, error);
  if (status == DLS_RAY) {
    done = dls_lemke_ray(run->lemke, NULL, NULL, x, NULL, NULL, error);
    if (!done) done = dls_lcp_check_farkas(lcp, x, &violation, error);
  }
  if (status == DLS_NO_SOLUTION || violation <= 1e-14 * (lcp->n + 10)) /* as dls_lemke_solve asks */
    v->farkas = x;
  else if (status == DLS_RAY)
    v->ray = x;
  verdict_fill(v, status, 1);
  if (status == DLS_STALLED && run->principal) {
    v->says = "active sets stopped without an answer";
    v->next = "M is no P-matrix, or there is no solution. --method lemke stores M densely, solves "
              "more kinds of M, and may prove that there is no solution.";
  }
  return done;
}

static void print_lcp_json(int n, const lcp_run *run, const verdict *v, int proof) {
  const dls_lcp_certificate *c = &run->certificate;
  printf("{\n  \"status\": \"%s\",\n  \"method\": \"%s\",\n  \"dimension\": %d,\n"
         "  \"contacts\": 0,\n  \"iterations\": %d",
         status_word(run->status), lcp_method(run), n, run->iterations);
  print_json_field(stdout, "residual", c->residual);
  print_json_field(stdout, "floor", c->floor);
  print_json_field(stdout, "penetration", c->negative_y); /* y stands for u_n */
  print_json_field(stdout, "cone_violation", c->negative_z);
  print_json_field(stdout, "complementarity", c->complementarity);
  print_json_field(stdout, "solve_cpu_seconds", run->cpu_seconds);
  print_json_verdict(stdout, v, proof);
  puts("\n}");
}

static void print_lcp(const char *path, int n, const lcp_run *run) {
  const dls_lcp_certificate *c = &run->certificate;
  printf("%s: LCP of %d unknown%s\n", quote(AS_SHOWN, path).text, n, plural(n));
  printf("  %s: %s, %s, residual %.2e (floor %.1e), %s of CPU\n", lcp_method(run),
         dls_status_text(run->status), run->words, c->residual, c->floor,
         in_words(run->cpu_seconds).text);
  printf("  negative z %.2e, negative y %.2e, complementarity %.2e\n", c->negative_z, c->negative_y,
         c->complementarity);
}

/* Solves an LCP and tells of it; `path` names it. */
static int solve_one_lcp(const char *path, const dls_lcp *lcp, const solve_options *options) {
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  lcp_run run = {0};
  const int n = lcp->n;
  int result = EXIT_BAD_INPUT;
  double *z = calloc(2 * (size_t)n, sizeof *z);
  const double start = cpu_seconds();
  const dls_limits *limits = &options->solver.settings.limits;
  const int ends = z && !(lcp->Ms.p ? run_principal : run_lemke)(&run, lcp, limits, z, &error);
  run.cpu_seconds = cpu_seconds() - start;
  progress_end();
  if (!ends) goto failed;
  verdict v;
  if (fill_lcp_verdict(&v, &run, lcp, z + n, &error)) goto failed;
  if (is_json())
    print_lcp_json(n, &run, &v, options->proof);
  else if (!is_quiet()) {
    print_lcp(path, n, &run);
    verdict_print(&v, options->proof);
  }
  const dls_dense answer = {n, 1, n, z};
  char room[UNSOLVED_ROOM];
  const char *unsolved = unsolved_words(run.status, run.certificate.residual, room, sizeof room);
  if (options->out && dls_mtx_write_commented(options->out, &answer, unsolved, &error)) {
    (void)complain_of(options->out, &error);
    goto end;
  }
  if (!is_json()) print_ending(run.status, NULL);
  result = run.status == DLS_OK ? EXIT_SOLVED : EXIT_NOT_SOLVED;
  goto end;
failed:
  (void)complain_of(path, &error);
end:
  dls_lemke_destroy(run.lemke);
  dls_principal_destroy(run.principal);
  free(z);
  return result;
}

/* Returns 1 if the options suit an LCP, 0 after a complaint. */
static int suits_lcp(const solve_options *o) {
  const dls_solver_settings *s = &o->solver.settings;
  if ((o->solver.method_given || o->solver.accel_given) && s->method != DLS_LEMKE)
    return refuse("--%s: an LCP is solved by lemke", o->solver.method_given ? "method" : "accel");
  if (o->explain || s->plan || s->without)
    return refuse("--plan, --without, --explain: are for contact problems");
  if (!s->facets && !o->print && !o->csv && !o->prove && !s->forces) return 1;
  return refuse("--%s: is for contact problems", s->facets  ? "facets"
                                                 : o->print ? "print"
                                                 : o->csv   ? "csv"
                                                 : o->prove ? "prove"
                                                            : "forces");
}

/* Beyond, Lemke's method would take seconds and n^2 doubles. */
enum { rows_of_lemke = 2000 };

/* Solves LCP(A, q): by Lemke's method, or by active sets a large A with zeros in most places. */
static int solve_lcp_columns(const char *path, const dls_sparse *A, const double *q,
                             const solve_options *options) {
  const int n = A->cols;
  const size_t size = (size_t)n;
  if (n > rows_of_lemke && (size_t)A->p[n] < size * size / 4 && !options->solver.method_given)
    return solve_one_lcp(path, &(dls_lcp){.n = n, .q = q, .Ms = *A}, options);
  double *M = size <= SIZE_MAX / size / sizeof *M ? calloc(size * size, sizeof *M) : NULL;
  if (!M) return complain("%s: no memory for a dense M of %d rows", path, n);
  for (int j = 0; j < n; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      M[(size_t)A->i[k] + size * (size_t)j] += A->x[k];
  const int result = solve_one_lcp(path, &(dls_lcp){.n = n, .M = {n, n, n, M}, .q = q}, options);
  free(M);
  return result;
}

static int solve_lcp_files(const char *path_M, const char *path_q, const solve_options *options) {
  sparse A = {0};
  table q = {0};
  int result = EXIT_BAD_INPUT;
  arrays_of_triplets(options->from.matrices.triplets);
  if (sparse_read(path_M, &A) && table_read(path_q, &q)) {
    const dls_sparse *M = &A.view;
    if (M->rows != M->cols || M->rows < 1)
      (void)complain("%s: M is %d x %d, must be square", path_M, M->rows, M->cols);
    else if ((q.rows != M->rows || q.cols != 1) && (q.rows != 1 || q.cols != M->rows))
      (void)complain("%s: q is %d x %d, must be %d x 1", path_q, q.rows, q.cols, M->rows);
    else
      result = solve_lcp_columns(path_M, M, q.a, options);
  }
  sparse_free(&A);
  free(q.a);
  return result;
}

/* Solves the problem in a file, of whatever kind. */
static int solve_file(const char *path, const solve_options *options) {
  dls_text *text;
  int n;
  const double *M, *q;
  if (matrices_name(&options->from.matrices)) return solve_contact(path, options);
  if (!read_lcp_text(path, &text))
    return options->lcp
               ? complain("--lcp: %s holds no LCP; a contact problem goes without --lcp", path)
               : solve_contact(path, options);
  int result = EXIT_BAD_INPUT;
  if (suits_lcp(options) && dls_text_lcp(text, &n, &M, &q, NULL) == DLS_OK)
    result = solve_one_lcp(path, &(dls_lcp){.n = n, .M = {n, n, n, M}, .q = q}, options);
  dls_text_destroy(text);
  return result;
}

/* ---- options --------------------------------------------------------------------------------- */

static taken take_solve_option(int key, const char *text, void *data) {
  static const char *const words[] = {[DLS_FORCES_ANY] = "any", [DLS_FORCES_LEAST] = "least"};
  solve_options *o = data;
  if (key != KEY_FORCES) return take_solver_option(key, text, &o->solver);
  const int k = parse_word("forces", text, words, 2);
  o->solver.settings.forces = (dls_forces)k;
  return k >= 0 ? OPTION_TAKEN : OPTION_WRONG;
}

static const option_row solve_rows[] = {
    SOLVER_OPTIONS(solve_options, solver),
    ROW(A_COUNT, "facets", 'f', solve_options, solver.settings.facets),
    ROW(A_TEXT, "out", 'o', solve_options, out),
    ROW(A_TEXT, "output", 0, solve_options, out),
    ROW(A_TEXT, "history", 'H', solve_options, history),
    ROW(A_TEXT, "plot", 'P', solve_options, plot),
    ROW(A_FLAG, "lcp", 0, solve_options, lcp),
    ROW(A_FLAG, "proof", 'p', solve_options, proof),
    ROW(A_FLAG, "prove", 0, solve_options, prove),
    ROW(A_TEXT, "limit", 0, solve_options, limit),
    ROW(A_FLAG, "print", 0, solve_options, print),
    ROW(A_TEXT, "csv", 0, solve_options, csv),
    ROW(A_TEXT, "plan", 0, solve_options, solver.settings.plan),
    ROW(A_TEXT, "without", 0, solve_options, solver.settings.without),
    ROW(A_FLAG, "explain", 0, solve_options, explain),
    VALUE("forces", KEY_FORCES),
    SOURCE_OPTIONS(solve_options, from),
    LAST_OPTIONS};
const command solve_command = {solve_rows, solve_usage, take_solve_option, 0};

void solve_options_init(solve_options *o) {
  *o = (solve_options){.from = {.solves = 1}};
  solver_options_init(&o->solver, 1e-8);
}

int settle_solve_options(solve_options *o) {
  const dls_solver_settings *s = &o->solver.settings;
  if ((o->explain || s->plan || s->without) && (s->method != DLS_AUTO || o->solver.accel_given))
    return refuse("--plan, --without, --explain: are for auto");
  if (o->solver.primal) return refuse("--method: gauss-seidel is for scenes");
  if (!settle_solver_options(&o->solver)) return 0;
  if (s->facets && s->method != DLS_LEMKE)
    return refuse("--facets: is for contact problems and lemke");
  return 1;
}

int solve_with(int argc, char **argv, const engine *from) {
  solve_options o;
  solve_options_init(&o);
  o.from.engine = from;
  const int stop = take_options(argc, argv, &solve_command, &o);
  if (stop != GO_ON) return stop;
  const char *named = matrices_name(&o.from.matrices);
  if (!named && matrices_given(&o.from.matrices))
    return complain("give one of --stiffness, --flexibility and --W");
  const int files = argc - optind;
  if (o.lcp && files == 1 && other_kind(argv[optind]))
    return complain("--lcp: q is missing: delassus solve --lcp %s q.mtx", argv[optind]);
  if (files != (named ? 0 : o.lcp && files == 2 ? 2 : 1)) return wrong_names(argv[0]);
  if (o.explain && is_json()) return complain("--explain, --json: one of the two");
  if (o.explain && is_quiet()) return complain("--explain, --quiet: one of the two");
  if (o.print && is_json()) return complain("--print, --json: one of the two");
  if (o.limit && (o.lcp || o.print || o.csv || o.out || o.history || o.plot || o.prove || o.proof ||
                  o.explain))
    return complain(
        "--limit: prints two loads, no answer: without --print, --csv, --out, --history, "
        "--plot, --prove, --proof, --explain, --lcp");
  if (o.lcp && named) return complain("--lcp: goes without --W, --stiffness and --flexibility");
  const char *path = named ? named : argv[optind];
  if (!settle_solve_options(&o)) return EXIT_BAD_INPUT;
  if (o.lcp && !suits_lcp(&o)) return EXIT_BAD_INPUT;
  if (o.history && o.plot) return complain("--plot: writes the history, too; one of the two");
  history rows = {.stage = ""};
  /* before the work: an answer that cannot be written is lost */
  if ((o.plot && !take_folder(o.plot, "solve", NULL)) ||
      (o.csv && !take_folder(o.csv, "solve", NULL)))
    return EXIT_BAD_INPUT;
  if (o.plot && !(rows.file = open_in(o.plot, "history.csv"))) return EXIT_BAD_INPUT;
  if (o.history && !(rows.file = open_path(o.history))) return EXIT_BAD_INPUT;
  if (rows.file) {
    fputs("iteration,cpu_seconds,residual,stage\n", rows.file);
    o.solver.settings.limits.progress = write_row;
    o.solver.settings.limits.progress_data = &rows;
  }
  end_at_once(!rows.file);
  watch_interrupt();
  const int result =
      files == 2 ? solve_lcp_files(path, argv[optind + 1], &o) : solve_file(path, &o);
  if (result == EXIT_BAD_INPUT) drop_files(); /* no history of what was not solved */
  if (result != EXIT_BAD_INPUT && rows.file && !close_file(rows.file, o.plot ? o.plot : o.history))
    return EXIT_BAD_INPUT;
  if (o.plot && result != EXIT_BAD_INPUT && !draw_history(o.plot, path)) return EXIT_BAD_INPUT;
  return result;
}

int command_solve(int argc, char **argv) {
  return solve_with(argc, argv, NULL);
}

int end_program(int result) {
  drop_files();
  drop_folder();
  drop_inputs();
  if (fflush(stdout) || ferror(stdout)) return complain("cannot write to standard output");
  return result;
}
