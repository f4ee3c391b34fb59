/* problem.c: loads the problem that a command is asked for: a file, a scene or matrices. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "matrices.h"

/* Returns 1 if the file begins as those of HDF5 do, or cannot be read. */
static int is_hdf5(const char *path) {
  static const char signature[8] = {'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
  char first[8] = {0};
  FILE *file = fopen(input_path(path), "rb");
  if (!file) return 1;
  const size_t got = fread(first, 1, sizeof first, file);
  const int failed = ferror(file);
  (void)fclose(file);
  return failed || (got == sizeof first && memcmp(first, signature, sizeof first) == 0);
}

const char *other_kind(const char *path) {
  char first = 0;
  dlsi_format format;
  FILE *file = fopen(input_path(path), "rb");
  const size_t got = file ? fread(&first, 1, 1, file) : 0;
  if (file) (void)fclose(file);
  if (!got || dlsi_format_find(array_is_calculix(path) ? path : input_path(path), &format, NULL) ||
      (format == DLSI_TEXT && !strchr("+-.0123456789", first)))
    return NULL;
  return dlsi_format_name(format);
}

int is_no_problem(const char *path) {
  const char *kind = other_kind(path);
  if (!kind) return 0;
  return complain("%s is %s: use --stiffness: delassus solve --stiffness=%s --HN=N --HT=T "
                  "--f=F --mu=MU; or --W with --q and --mu; an LCP: --lcp M.mtx q.mtx",
                  path, kind, path),
         1;
}

int read_lcp_text(const char *path, dls_text **text) {
  *text = NULL;
  if (is_hdf5(path) || dls_text_read(text, input_path(path), NULL)) return 0;
  if (dls_text_is_lcp(*text)) return 1;
  dls_text_destroy(*text);
  *text = NULL;
  return 0;
}

const char *problem_title(const problem *p) {
  return p->text ? dls_text_title(p->text) : p->file ? dls_fclib_title(p->file) : "";
}

/* Returns 1 after a complaint of a format that belongs to another program. */
static int is_foreign(const char *path) {
  dlsi_format format;
  dls_error error = {0};
  if (is_hdf5(path) || dlsi_format_find(input_path(path), &format, &error) != DLS_E_UNSUPPORTED)
    return 0;
  return complain_of(path, &error), 1;
}

/* Refuses --on=K for a file that holds W. */
static dls_status check_place(dls_on on, dls_error *error) {
  if (on != DLS_ON_K) return DLS_OK;
  *error = (dls_error){.status = DLS_E_UNSUPPORTED, .message = "--on=K: this file holds W alone"};
  return DLS_E_UNSUPPORTED;
}

static dls_status problem_of_file(const char *path, const source *from, problem *p,
                                  dls_error *error) {
  const dls_on on = from->matrices.on;
  dls_status status;
  if (!is_hdf5(path)) {
    status = dls_text_read(&p->text, input_path(path), error);
    if (!status) status = check_place(on, error);
    return status ? status : dls_text_contact(p->text, &p->contact, error);
  }
  status = dls_fclib_read(&p->file, input_path(path), error);
  if (status) return status;
  if (!dls_fclib_is_global(p->file)) {
    status = check_place(on, error);
    return status ? status : dls_fclib_contact(p->file, &p->contact, error);
  }
  status = dls_fclib_model(p->file, &p->model, &p->f, &p->g, &p->mu, error);
  if (status) return status;
  p->of_bodies =
      from->solves && on != DLS_ON_K && dls_fclib_bodies(p->file, &p->contact, NULL) == DLS_OK;
  return p->of_bodies ? DLS_OK : problem_condense(p, from, error);
}

/* Complains of a name that is neither a scene nor a file; 0 if it is a file. */
static int is_nothing(const char *name) {
  nearest near = {.word = name};
  for (int k = 0; scene_name(k); k++)
    nearest_try(&near, scene_name(k));
  if (!near.count || access(input_path(name), F_OK) == 0) return 0;
  return complain("%s: no file and no scene%s", name, nearest_words(&near)), 1;
}

int problem_open(const char *name, const source *wanted, problem *p) {
  source own = *wanted;
  const source *from = &own;
  const char *where = own.matrices.where;
  if (where && !own.matrices.on)
    own.matrices.on = !strcmp(where, "K")   ? DLS_ON_K
                      : !strcmp(where, "W") ? DLS_ON_W
                                            : own.matrices.on;
  if (where && !own.matrices.on) return refuse("--on: '%s' is not W or K", where);
  const char *given = matrices_name(&from->matrices);
  const scene_kind kind = given ? NO_SCENE : kind_of_scene(name);
  dls_error error = {0};
  dls_status status;
  if (!from->solves && from->matrices.on == DLS_ON_K)
    return refuse("--on=K: is for delassus solve");
  if (from->step && kind != SCENE_FORMING && kind != SCENE_MOVING)
    return refuse("--step: is for scenes in steps");
  if (!given && matrices_given(&from->matrices))
    return refuse("give one of --stiffness, --flexibility and --W");
  shorten(given ? given : name, p->name, sizeof p->name);
  if (given) {
    name = given;
    if (!matrices_load(&from->matrices, p)) return 0;
    status = p->model.n ? problem_condense(p, from, &error) : DLS_OK;
  } else if (kind) {
    status = problem_of_scene(name, from, p, &error);
  } else {
    if (is_nothing(name) || is_no_problem(name) || is_foreign(name)) return 0;
    status = problem_of_file(name, from, p, &error);
  }
  if (status < 0) (void)complain_of(name, &error);
  if (status == DLS_E_SINGULAR && p->model.operator_kind != DLS_FLEXIBILITY)
    (void)complain(from->solves ? "without --on=W and with --method=auto, it is solved on K"
                                : "needs W; delassus solve takes free bodies, on K");
  if (!status && *p->note) tell("%s: %s\n", quote(AS_SHOWN, p->name).text, p->note);
  return !status;
}

int problem_reload(const char *name, const source *wanted, int loads, problem *p) {
  dls_error error = {0};
  if (!p->matrices) return friction_load(&wanted->matrices, p);
  if (!matrices_load_data(&wanted->matrices, loads, p)) return 0;
  if (loads && p->reduction && problem_take_load(p, &error)) return complain_of(name, &error), 0;
  return 1;
}

/* Takes text files of LCPs, on which methods for contact cannot race, out of the names: a line on
 * stderr for each. Returns how many names are left, in front. */
static int leave_lcps(int count, char **names) {
  int kept = 0;
  for (int i = 0; i < count; i++) {
    dls_text *text;
    if (read_lcp_text(names[i], &text))
      (void)complain("%s: skipped: an LCP, no contact problem; delassus solve solves it", names[i]);
    else
      names[kept++] = names[i];
    dls_text_destroy(text);
  }
  return kept;
}

char **source_names(int *count, char **argv, const source *from) {
  static char *alone[1];
  const char *given = matrices_name(&from->matrices);
  const int names = *count;
  if (given ? names > 0 : names < 1) return wrong_names(argv[0]), NULL;
  alone[0] = (char *)given;
  *count = given ? 1 : leave_lcps(names, argv + optind);
  return given ? alone : argv + optind;
}

/* Is in OpenBLAS alone; NULL with another BLAS. */
extern void openblas_set_num_threads(int count) __attribute__((weak));

enum { one_thread_rows = 1000 };

void problem_fit_threads(const problem *p) {
  const long long rows = (long long)p->contact.d * p->contact.nc;
  if (rows <= one_thread_rows && openblas_set_num_threads) openblas_set_num_threads(1);
}

void problem_free(problem *p) {
  dls_reduction_destroy(p->reduction);
  dls_fclib_destroy(p->file);
  dls_text_destroy(p->text);
  dls_fe_scene_destroy(p->scene);
  dls_moving_destroy(p->moving);
  free(p->own);
  free(p->friction);
  matrices_free(p->matrices);
}

int problem_parts(const problem *p) {
  return p->smooth ? 1 : p->contact.d;
}

void problem_print(const char *path, const problem *p) {
  printf("%s: %dD, %d contact%s, %s\n", quote(AS_SHOWN, path).text, p->contact.d, p->contact.nc,
         plural(p->contact.nc),
         p->scene || p->own             ? "of a scene"
         : p->reduction || p->of_bodies ? "global"
         : p->text                      ? "text"
                                        : "local");
  if (p->of_bodies)
    printf("  of %d rigid bod%s\n", p->contact.bodies.count,
           p->contact.bodies.count == 1 ? "y" : "ies");
  if (p->reduction && !p->of_bodies)
    printf("  %s %d unknown%s in %s of CPU\n", p->on_K == 1 ? "on K, of" : "reduced from",
           p->model.n, plural(p->model.n), in_words(p->reduction_cpu_seconds).text);
}

void print_reduction(FILE *out, const problem *p) {
  dls_reduction_info info;
  if (!p->reduction || dls_reduction_get_info(p->reduction, &info, NULL)) return;
  if (p->on_K) {
    fprintf(out, "on K: %d unknown%s, %d contact%s, W is not formed\n", p->model.n,
            plural(p->model.n), info.contacts, plural(info.contacts));
    return;
  }
  fprintf(out, "reduction: %d unknown%s, %d condensed, %.3g flops, at most %.3g MB, %s of CPU",
          p->model.n, plural(p->model.n), info.condensed, info.flops, info.bytes * 1e-6,
          in_words(p->reduction_cpu_seconds).text);
  if (info.condition > 0) fprintf(out, ", condition of K about %.1e", info.condition);
  if (info.indefinite) fputs(", K is indefinite", out);
  fputc('\n', out);
}
