/* problem.c: loads problems, FCLIB or text, and condenses them if they are global. */
#define _GNU_SOURCE
#include <string.h>
#include <unistd.h>

#include "cli.h"

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
  char first[16] = {0};
  FILE *file = fopen(input_path(path), "rb");
  const size_t got = file ? fread(first, 1, sizeof first, file) : 0;
  if (file) (void)fclose(file);
  const char *dot = strrchr(path, '.');
  if (dot && got && (!strcmp(dot, ".sti") || !strcmp(dot, ".mas"))) return "matrix of CalculiX";
  if (got >= 14 && strncasecmp(first, "%%MatrixMarket", 14) == 0) return "matrix";
  if (got >= 6 && memcmp(first, "\x93NUMPY", 6) == 0) return "matrix of NumPy";
  return first[0] && strchr("+-.0123456789", first[0]) ? "table of numbers" : NULL;
}

int is_no_problem(const char *path) {
  const char *kind = other_kind(path);
  if (kind)
    return complain("%s is a %s: use --stiffness: delassus solve --stiffness=%s --HN=N --HT=T "
                    "--f=F --mu=MU; or --W with --q and --mu; an LCP: --lcp M.mtx q.mtx",
                    path, kind, path),
           1;
  if (access(input_path(path), F_OK) == 0 || !names_a_scene(path)) return 0;
  return complain("%s: is a scene: delassus scene %s", path, path), 1;
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

/* Refuses --on=K for a file that holds W. */
static dls_status check_place(dls_on on, dls_error *error) {
  if (on != DLS_ON_K) return DLS_OK;
  *error = (dls_error){.status = DLS_E_UNSUPPORTED, .message = "--on=K: this file holds W alone"};
  return DLS_E_UNSUPPORTED;
}

dls_status problem_load(const char *path, int bodies, dls_on on, problem *p, dls_error *error) {
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
  p->of_bodies = bodies && on != DLS_ON_K && dls_fclib_bodies(p->file, &p->contact, NULL) == DLS_OK;
  if (p->of_bodies) return DLS_OK;
  dls_reduction_settings settings;
  dls_reduction_settings_init(&settings);
  settings.on = on;
  settings.progress = show_reduction;
  const double start = cpu_seconds();
  status = dls_reduction_create_either(&p->reduction, &p->model, &settings, error);
  if (!status) status = dls_reduction_load(p->reduction, p->f, p->g, error);
  if (!status) status = problem_take_contact(p, error);
  p->reduction_cpu_seconds = cpu_seconds() - start;
  return status;
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
  matrices_free(p->matrices);
}

void problem_print(const char *path, const problem *p) {
  printf("%s: %dD, %d contact%s, %s\n", quote(AS_SHOWN, path).text, p->contact.d, p->contact.nc,
         plural(p->contact.nc),
         p->reduction   ? "global"
         : p->of_bodies ? "global"
         : p->text      ? "text"
                        : "local");
  if (p->of_bodies)
    printf("  of %d rigid bod%s\n", p->contact.bodies.count,
           p->contact.bodies.count == 1 ? "y" : "ies");
  if (p->reduction && !p->of_bodies)
    printf("  %s %d unknown%s in %.3g s of CPU\n", p->on_K ? "on K, of" : "reduced from",
           p->model.n, plural(p->model.n), p->reduction_cpu_seconds);
}

void print_reduction(FILE *out, const problem *p) {
  dls_reduction_info info;
  if (!p->reduction || dls_reduction_get_info(p->reduction, &info, NULL)) return;
  if (p->on_K) {
    fprintf(out, "on K: %d unknown%s, %d contact%s, W is not formed\n", p->model.n,
            plural(p->model.n), info.contacts, plural(info.contacts));
    return;
  }
  fprintf(out, "reduction: %d unknown%s, %d condensed, %.3g flops, at most %.3g MB, %.3g s of CPU",
          p->model.n, plural(p->model.n), info.condensed, info.flops, info.bytes * 1e-6,
          p->reduction_cpu_seconds);
  if (info.condition > 0) fprintf(out, ", condition of K about %.1e", info.condition);
  if (info.indefinite) fputs(", K is indefinite", out);
  if (info.modes) fprintf(out, ", %d rigid-body mode%s held", info.modes, plural(info.modes));
  fputc('\n', out);
}
