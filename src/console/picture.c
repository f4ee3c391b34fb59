/* picture.c: draws pictures through gnuplot; data and scripts stay beside them. */
#define _GNU_SOURCE
#include <errno.h>
#include <math.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "console.h"
#include "files/output.h"

extern char **environ;

int join_path(char path[PATH_ROOM], const char *directory, const char *name) {
  const int length = snprintf(path, PATH_ROOM, "%s/%s", directory, name);
  if (length >= 0 && length < PATH_ROOM) return 1;
  return refuse("%s: the name is too long", directory);
}

/* The files that are open, the latest first. */
typedef struct open_file {
  dlsi_output out;
  struct open_file *next;
} open_file;
static open_file *open_files;

FILE *open_path(const char *path) {
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  open_file *entry = malloc(sizeof *entry);
  if (!entry || dlsi_output_open(&entry->out, path, &error)) {
    (void)complain_of(path, &error);
    free(entry);
    return NULL;
  }
  entry->next = open_files;
  open_files = entry;
  return entry->out.file;
}

FILE *open_in(const char *directory, const char *name) {
  char path[PATH_ROOM];
  return join_path(path, directory, name) ? open_path(path) : NULL;
}

FILE *open_table(const char *directory, const char *name, const char *head) {
  FILE *file = open_in(directory, name);
  if (file) fputs(head, file);
  return file;
}

FILE *open_growing(const char *directory, const char *name, const char *head) {
  FILE *file = open_table(directory, name, head);
  if (file) open_files->out.is_table = 1;
  return file;
}

int close_file(FILE *file, const char *name) {
  open_file **at = &open_files;
  while ((*at)->out.file != file)
    at = &(*at)->next;
  open_file *entry = *at;
  dls_error error = {0};
  *at = entry->next;
  const int good = dlsi_output_finish(&entry->out, &error) == DLS_OK;
  if (!good) (void)complain_of(name, &error);
  free(entry);
  return good;
}

int close_files(void) {
  int good = 1;
  while (open_files && good) {
    open_file *first = open_files;
    while (first->next)
      first = first->next;
    good = close_file(first->out.file, first->out.path);
  }
  keep_tables();
  return good;
}

open_file *set_files_aside(void) {
  open_file *files = open_files;
  open_files = NULL;
  return files;
}

void put_files_back(open_file *files) {
  drop_files();
  open_files = files;
}

/* Gives all open files up; keep: but the rows of growing tables. */
static void end_files(int keep) {
  while (open_files) {
    open_file *entry = open_files;
    open_files = entry->next;
    if (keep && entry->out.is_table)
      dlsi_output_keep_rows(&entry->out);
    else
      dlsi_output_drop(&entry->out);
    free(entry);
  }
}

void drop_files(void) {
  end_files(0);
}

void keep_tables(void) {
  end_files(1);
}

dls_fe_series *open_series(const char *directory) {
  char path[PATH_ROOM];
  dls_fe_series *series;
  dls_error error = {0};
  if (!join_path(path, directory, "series.pvd")) return NULL;
  if (dls_fe_series_create(&series, path, &error)) complain_of(path, &error);
  return series;
}

int close_series(dls_fe_series *series) {
  dls_error error = {0};
  if (!dls_fe_series_finish(series, &error)) return 1;
  complain_of("series.pvd", &error);
  return 0;
}

int make_directory(const char *path) {
  char part[PATH_ROOM];
  if (!join_path(part, path, "")) return 0;
  for (char *slash = part + 1; (slash = strchr(slash, '/')); slash++) {
    *slash = '\0';
    if (mkdir(part, 0777) && errno != EEXIST) return refuse("%s: %s", part, strerror(errno));
    *slash = '/';
  }
  return 1;
}

/* Runs gnuplot on NAME.gp in the directory. The first complaint is enough. */
static int run_gnuplot(const char *directory, const char *name) {
  static int told;
  char program[] = "gnuplot", script[80];
  (void)snprintf(script, sizeof script, "%s.gp", name);
  char *argv[] = {program, script, NULL};
  posix_spawn_file_actions_t actions;
  if (posix_spawn_file_actions_init(&actions)) return 0;
  pid_t child;
  int status = -1;
  if (posix_spawn_file_actions_addchdir_np(&actions, directory) == 0 &&
      posix_spawnp(&child, program, &actions, NULL, argv, environ) == 0)
    while (waitpid(child, &status, 0) < 0 && errno == EINTR)
      ;
  (void)posix_spawn_file_actions_destroy(&actions);
  if (status == 0) return 1;
  if (!told++)
    complain("%s/%s: gnuplot did not draw it; install gnuplot (Debian: gnuplot-nox)", directory,
             script);
  return 0;
}

void mesh_box(int nodes, const double *xy, const double *displacement, double lo[2], double hi[2]) {
  lo[0] = hi[0] = xy[0];
  lo[1] = hi[1] = xy[1];
  for (int k = 0; k < 2 * nodes; k++) {
    const double rest = xy[k], moved = rest + (displacement ? displacement[k] : 0);
    lo[k % 2] = fmin(lo[k % 2], fmin(rest, moved));
    hi[k % 2] = fmax(hi[k % 2], fmax(rest, moved));
  }
}

void place_panel(FILE *script, double left, double right, double bottom, double top) {
  fprintf(script,
          "  set lmargin at screen %.5g\n  set rmargin at screen %.5g\n"
          "  set bmargin at screen %.5g\n  set tmargin at screen %.5g\n",
          left, right, bottom, top);
}

const char *state_colour(dls_contact_state state) {
  return state == DLS_FREE ? "#909090" : state == DLS_SLIP ? "#d95f02" : "#1b7837";
}

FILE *open_script(const char *directory, const char *name) {
  char script[80];
  (void)snprintf(script, sizeof script, "%s.gp", name);
  return open_in(directory, script);
}

void begin_pictures(FILE *script, const char *name, double width, double height) {
  fprintf(script,
          "set encoding utf8\ndo for [type in 'png svg'] {\n"
          "  if (type eq 'png') { set terminal pngcairo size %g,%g font ',13' }\n"
          "  if (type eq 'svg') { set terminal svg size %g,%g font ',13' background 'white' }\n"
          "  set output '%s.'.type\n",
          width, height, width, height, name);
}

static int no_pictures;

void draw_pictures(int on) {
  no_pictures = !on;
}

int draw_script(FILE *script, const char *directory, const char *name) {
  fputs("\n  unset multiplot\n  unset output\n}\n", script);
  if (!close_file(script, name)) return 0;
  return no_pictures ? 1 : 1 + run_gnuplot(directory, name);
}

static double largest_pair(const double *v, int n) {
  double m = 0;
  for (int i = 0; i < n; i++)
    m = fmax(m, hypot(v[2 * i], v[2 * i + 1]));
  return m;
}

/* Returns the largest number <= x that is 1, 2 or 5 times a power of ten. */
static double round_down(double x) {
  const double power = pow(10, floor(log10(x)));
  return x >= 5 * power ? 5 * power : x >= 2 * power ? 2 * power : power;
}

/* Colours of the two components of a reaction. */
static const char blue[] = "#3060a0", red[] = "#c03020";

/* Draws the sides of the triangles, displaced `amplify` times. */
static void write_triangles(FILE *data, const scene_picture *p, double amplify) {
  const dls_fe_mesh *mesh = p->scene->mesh;
  for (int t = 0; t < mesh->triangles; t++) {
    for (int k = 0; k < 4; k++) {
      const int i = mesh->node[3 * t + k % 3];
      fprintf(data, "%.9g %.9g\n", mesh->xy[2 * i] + amplify * p->displacement[2 * i],
              mesh->xy[2 * i + 1] + amplify * p->displacement[2 * i + 1]);
    }
    fputc('\n', data);
  }
  fputs("\n", data);
}

/* Draws the nodal reactions of the candidates in one state, each with its head at the node: rows x,
 * y, components of the arrow. */
static void write_arrows(FILE *data, const scene_picture *p, dls_contact_state state,
                         double amplify, double arrow) {
  const dls_fe_scene_data *s = p->scene;
  for (int c = 0; c < s->candidates; c++) {
    const int i = s->contact_node[s->candidate_node[c]];
    const double rx = arrow * p->reaction[2 * i], ry = arrow * p->reaction[2 * i + 1];
    if (p->state[c] != state || (rx == 0 && ry == 0)) continue;
    fprintf(data, "%.9g %.9g %.9g %.9g\n",
            s->mesh->xy[2 * i] + amplify * p->displacement[2 * i] - rx,
            s->mesh->xy[2 * i + 1] + amplify * p->displacement[2 * i + 1] - ry, rx, ry);
  }
  fputs("NaN NaN NaN NaN\n\n\n", data); /* a block of data, of no candidate, too */
}

/* Draws the deformed block with an arrow for each nodal reaction, as in [Jean 1988] Fig. 3a. Lines
 * and heads of the arrows are as thin as the distance of the candidates asks. */
static int write_deformed(const scene_picture *p) {
  const dls_fe_mesh *mesh = p->scene->mesh;
  double lo[2], hi[2];
  mesh_box(mesh->nodes, mesh->xy, NULL, lo, hi);
  const double size = fmax(hi[0] - lo[0], hi[1] - lo[1]);
  const double dmax = largest_pair(p->displacement, mesh->nodes);
  const double rmax = largest_pair(p->reaction, mesh->nodes);
  const double amplify = dmax > 0 ? round_down(0.2 * size / dmax) : 1;
  const double arrow = rmax > 0 ? 0.25 * size / rmax : 0;
  const double distance = size / p->scene->candidates, head = fmin(size / 40, 0.5 * distance);
  const double thin = fmin(1, 16.0 / p->scene->candidates);

  FILE *data = open_in(p->directory, "deformed.dat");
  if (!data) return 0;
  fprintf(data,
          "# block 0: triangles, displacements x %g; reactions where 1: free, 2: slip, "
          "3: stick\n",
          amplify);
  write_triangles(data, p, amplify);
  for (int k = DLS_FREE; k <= DLS_STICK; k++)
    write_arrows(data, p, (dls_contact_state)k, amplify, arrow);
  if (!close_file(data, "deformed.dat")) return 0;

  FILE *script = open_script(p->directory, "deformed");
  if (!script) return 0;
  fprintf(script,
          "set title %s.\"\\ndisplacements x %g, longest arrow %.3g N/m\"\n"
          "set size ratio -1\nset key outside top center horizontal\n"
          "set xlabel 'x [m]'\nset ylabel 'y [m]'\nset xtics %g\nset ytics %g\n"
          "set xrange [%g:%g]\nset yrange [%g:%g]\n"
          "set object 1 rectangle from %g,%g to %g,%g fs empty border lc rgb '#a0a0a0'\n"
          "set arrow 1 from %g,%g to %g,%g nohead lw 2 lc rgb 'black'\n",
          quote(AS_GNUPLOT, p->title).text, amplify, rmax, size / 4, size / 4, lo[0] - 0.1 * size,
          hi[0] + 0.3 * size, lo[1] - 0.35 * size, hi[1] + 0.15 * size, lo[0], lo[1], hi[0], hi[1],
          lo[0] - 0.1 * size, lo[1], hi[0] + 0.3 * size, lo[1]);
  begin_pictures(script, "deformed", 900, 940);
  fprintf(script, "  plot 'deformed.dat' index 0 with lines lw %.2g lc rgb '%s' notitle", thin,
          blue);
  for (int k = DLS_FREE; k <= DLS_STICK; k++)
    fprintf(script,
            ", \\\n       '' index %d using 1:2:3:4 with vectors head size %.3g,20,60 filled lw "
            "%.2g lc rgb '%s' title '%s'",
            k + 1, head, fmax(0.5, 2 * thin), state_colour((dls_contact_state)k),
            state_word((dls_contact_state)k));
  return draw_script(script, p->directory, "deformed");
}

/* Draws the reactions along the contact line: R_N as a broad line, so that -R_T over it hides
 * nothing where both are one; the states as points on R_N; the paper's as open points. */
static int write_reactions(const scene_picture *p) {
  FILE *data = open_table(p->directory, "reactions.dat",
                          "# x rt rn paper_rt paper_rn state (0 free, 1 slip, 2 stick)\n");
  if (!data) return 0;
  for (int c = 0; c < p->scene->candidates; c++)
    fprintf(data, "%.9g %.9g %.9g %.9g %.9g %d\n", p->x[c], p->rt[c], p->rn[c],
            p->paper_rt ? p->paper_rt[c] : NAN, p->paper_rn ? p->paper_rn[c] : NAN,
            (int)p->state[c]);
  if (!close_file(data, "reactions.dat")) return 0;
  FILE *script = open_script(p->directory, "reactions");
  if (!script) return 0;
  const double point = fmin(1.3, fmax(0.6, 40.0 / p->scene->candidates));
  fprintf(script,
          "set title %s\nset key outside top center horizontal\nset grid\n"
          "set datafile missing 'nan'\nset xlabel 'x [m]'\nset ylabel 'reaction [N/m]'\n"
          "set autoscale noextend\nset offsets graph 0.02, graph 0.02, graph 0.04, graph 0.03\n",
          quote(AS_GNUPLOT, p->title).text);
  begin_pictures(script, "reactions", 1000, 680);
  fputs("  plot 'reactions.dat' using 1:3 with lines lw 7 lc rgb '#a8c4e8' title 'R_N', \\\n",
        script);
  fprintf(script, "       '' using 1:(-$2) with lines lw 2 lc rgb '%s' title '-R_T'", red);
  for (int k = DLS_FREE; k <= DLS_STICK; k++)
    fprintf(script,
            ", \\\n       '' using 1:($6==%d?$3:NaN) with points pt 7 ps %.2g lc rgb '%s' "
            "title '%s'",
            k, point, state_colour((dls_contact_state)k), state_word((dls_contact_state)k));
  const double *const paper[] = {p->paper_rn, p->paper_rt};
  static const char *const points[] = {"1:5 with points pt 6 ps 2.2 lw 1.5 lc rgb '#3060a0' "
                                       "title 'R_N paper'",
                                       "1:(-$4) with points pt 4 ps 2 lc rgb '#c03020' "
                                       "title '-R_T paper'"};
  for (int k = 0; k < 2; k++)
    if (paper[k]) fprintf(script, ", \\\n       '' using %s", points[k]);
  return draw_script(script, p->directory, "reactions");
}

int draw_scene(const scene_picture *picture) {
  return write_deformed(picture) && write_reactions(picture) ? EXIT_SOLVED : EXIT_BAD_INPUT;
}
