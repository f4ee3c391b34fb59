/*
 * sensitivity.c: the map of delassus info --sensitivity: which gaps and loads each reaction of an
 * answer depends on, and what friction does to it.
 *
 * q is the position that gaps and loads would give without reactions; a gap of contact k is a part
 * of q_k, a load moves q of all contacts. The map holds w_c |d r_c / d q_k|, w_c = trace(W_cc) / d:
 * normal and tangential part of r_c by normal and tangential part of q_k, norms in 3D. A contact
 * alone has 1 on the diagonal, or less.
 */
#include <math.h>
#include <stdlib.h>

#include "cli.h"
#include "delassus/derive.h"

enum { parts = 4, listed = 12, named = 3 };

/* All of an answer; one piece of memory. */
typedef struct influence {
  const dls_contact *contact;
  const double *r;
  double *u, *dq, *dmu, *map; /* m; m x m; m; parts x nc x nc */
  dls_contact_state *state;   /* nc */
} influence;

static const char *const part_name[parts] = {"rn_qn", "rn_qt", "rt_qn", "rt_qt"};

static double *map_at(const influence *of, int part, int c, int k) {
  const size_t nc = (size_t)of->contact->nc;
  return &of->map[((size_t)part * nc + (size_t)c) * nc + (size_t)k];
}

/* Returns trace(W_cc) / d. */
static double mean_compliance(const dls_contact *p, int c) {
  const int d = p->d, n = p->bodies.n;
  double sum = 0;
  for (int i = 0; p->W.a && i < d; i++)
    sum += p->W.a[(size_t)(d * c + i) * (size_t)(p->W.ld + 1)];
  for (int k = 0; p->Wb.x && k < p->Wb.p[c + 1] - p->Wb.p[c]; k++)
    for (int i = 0; p->Wb.i[p->Wb.p[c] + k] == c && i < d; i++)
      sum += p->Wb.x[(size_t)(p->Wb.p[c] + k) * (size_t)(d * d) + (size_t)(i * (d + 1))];
  for (int side = 0; p->bodies.H && side < 2; side++)
    for (int i = 0; p->bodies.body[2 * c + side] >= 0 && i < n * d; i++) {
      const double h = p->bodies.H[(size_t)(2 * c + side) * (size_t)(n * d) + (size_t)i];
      sum += h * h;
    }
  return sum / d;
}

/* dq, column j := d r / d q_j; dmu := d r / d mu, all mu > 0 raised together. change: m,
 * scratch. */
static dls_status find_influence(const influence *of, double *change, dls_error *error) {
  const dls_contact *p = of->contact;
  const size_t m = (size_t)p->d * (size_t)p->nc;
  dls_derive *derive = NULL;
  dls_status status = dls_derive_create(&derive, p, of->r, -1, error);
  for (size_t k = 0; k < m; k++)
    change[k] = 0;
  for (size_t j = 0; !status && j < m; j++) {
    change[j] = 1;
    const dls_derive_data by_q = {.q = change};
    const dls_derive_answer moved = {.r = of->dq + j * m};
    status = dls_derive_jvp(derive, &by_q, &moved, error);
    change[j] = 0;
  }
  for (int c = 0; c < p->nc; c++)
    change[c] = p->mu[c] > 0;
  const dls_derive_data by_mu = {.mu = change};
  const dls_derive_answer moved = {.r = of->dmu};
  if (!status) status = dls_derive_jvp(derive, &by_mu, &moved, error);
  dls_derive_destroy(derive);
  return status;
}

static void fill_map(const influence *of) {
  const int d = of->contact->d, nc = of->contact->nc, m = d * nc;
  for (int c = 0; c < nc; c++) {
    const double w = mean_compliance(of->contact, c);
    for (int k = 0; k < nc; k++)
      for (int i = 0; i < d; i++)
        for (int j = 0; j < d; j++) {
          double *entry = map_at(of, 2 * (i > 0) + (j > 0), c, k);
          const double x = of->dq[(size_t)(d * c + i) + (size_t)(d * k + j) * (size_t)m];
          *entry = hypot(*entry, w * x);
        }
  }
}

/* Returns the norm of all parts of r_c by q_k. */
static double effect_of(const influence *of, int c, int k) {
  double sum = 0;
  for (int part = 0; part < parts; part++)
    sum = hypot(sum, *map_at(of, part, c, k));
  return sum;
}

/* ---- files ----------------------------------------------------------------------------------- */

static int write_map_csv(const influence *of, const char *directory) {
  FILE *file = open_in(directory, "sensitivity.csv");
  const int nc = of->contact->nc;
  if (!file) return 0;
  fputs("candidate_from_0,by", file);
  for (int part = 0; part < parts; part++)
    fprintf(file, ",%s", part_name[part]);
  fputc('\n', file);
  for (int c = 0; c < nc; c++)
    for (int k = 0; k < nc; k++) {
      fprintf(file, "%d,%d", c, k);
      for (int part = 0; part < parts; part++)
        fprintf(file, ",%.9g", *map_at(of, part, c, k));
      fputc('\n', file);
    }
  return close_file(file, "sensitivity.csv");
}

static int write_friction_csv(const influence *of, const char *directory) {
  static const char letter[] = "nts";
  const int d = of->contact->d, nc = of->contact->nc;
  FILE *file = open_table(directory, "friction.csv", "candidate_from_0,state");
  if (!file) return 0;
  for (int i = 0; i < 2 * d; i++)
    fprintf(file, i < d ? ",r_%c" : ",dr_%c_dmu", letter[i % d]);
  fputc('\n', file);
  for (int c = 0; c < nc; c++) {
    fprintf(file, "%d,%d", c, (int)of->state[c]);
    for (int i = 0; i < 2 * d; i++)
      fprintf(file, ",%.17g", (i < d ? of->r : of->dmu)[d * c + i % d]);
    fputc('\n', file);
  }
  return close_file(file, "friction.csv");
}

/* ---- picture --------------------------------------------------------------------------------- */

/* Writes the maps, one above the other two by two. */
static void draw_maps(FILE *s, const influence *of, double least, double most) {
  static const char *const title[parts] = {"r_n by q_n", "r_n by q_t", "r_t by q_n", "r_t by q_t"};
  const int nc = of->contact->nc, count = of->contact->d == 1 ? 1 : parts;
  fprintf(s,
          "  set palette defined (0 '#fff4d8', 0.35 '#f0b060', 0.7 '#c03020', 1 '#300018')\n"
          "  set logscale cb\n  set cbrange [%g:%g]\n  set format cb '10^{%%T}'\n"
          "  set xrange [-0.5:%g]\n  set yrange [%g:-0.5]\n  set size ratio 1\n",
          least, most, nc - 0.5, nc - 0.5);
  for (int part = 0; part < count; part++) {
    const int column = part % 2, row = part / 2;
    place_panel(s, column ? 0.54 : 0.08, column ? 0.90 : 0.44, row ? 0.405 : 0.69,
                row ? 0.635 : 0.92);
    fprintf(s,
            "  set title '{/:Bold %s}' offset 0,-0.6\n  set xlabel 'q of contact' offset 0,0.5\n"
            "  set ylabel 'r of contact' offset 0.8,0\n  %sset colorbox\n",
            title[part], column ? "" : "un");
    fprintf(
        s,
        "  plot 'sensitivity.csv' every ::1 using 2:1:($%d > %g ? $%d : %g) with image notitle\n",
        3 + part, least, 3 + part, least);
  }
}

/* Writes r, or d r / d mu, along the contacts, the states as points. */
static void draw_curves(FILE *s, const influence *of, int by_friction) {
  static const char *const colour[] = {"#3060a0", "#c03020", "#1b7837"};
  static const char letter[] = "nts";
  const int d = of->contact->d;
  place_panel(s, by_friction ? 0.59 : 0.10, by_friction ? 0.97 : 0.48, 0.06, 0.31);
  fprintf(s,
          "  unset logscale\n  set size noratio\n  set xrange [-0.5:%g]\n  set yrange [*:*]\n  set "
          "title '{/:Bold %s}' offset 0,-0.6\n"
          "  set xlabel 'contact' offset 0,0.5\n  set ylabel '%s' offset 0.5,0\n"
          "  set key top left samplen 2\n  plot 0 with lines lc rgb '#c0c0c0' notitle",
          of->contact->nc - 0.5,
          by_friction ? "d r / d mu, all mu together" : "reactions; points: states",
          by_friction ? "d r / d mu [force]" : "r [force]");
  for (int i = 0; i < d && i < 3; i++)
    fprintf(s,
            ", \\\n       'friction.csv' every ::1 using 1:%d with lines lw 2 lc rgb '%s' title "
            "'%sr_%c%s'",
            3 + i + d * by_friction, colour[i], by_friction ? "d " : "", letter[i],
            by_friction ? " / d mu" : "");
  for (int k = DLS_FREE; k <= DLS_STICK; k++)
    fprintf(s,
            ", \\\n       '' every ::1 using 1:($2==%d?$%d:NaN) with points pt 7 ps 0.8 lc rgb "
            "'%s' title '%s'",
            k, 3 + d * by_friction, state_colour((dls_contact_state)k),
            by_friction ? "" : state_word((dls_contact_state)k));
  fputc('\n', s);
}

static int draw_sensitivity(const influence *of, const char *name, const char *directory) {
  static const double decades = 1e-4;
  const size_t nc = (size_t)of->contact->nc;
  double most = 0;
  for (size_t k = 0; k < parts * nc * nc; k++)
    most = fmax(most, of->map[k]);
  if (!(most > 0)) most = 1;
  const double least = decades * most;
  if (!write_map_csv(of, directory) || !write_friction_csv(of, directory)) return EXIT_BAD_INPUT;
  FILE *s = open_script(directory, "sensitivity");
  if (!s) return EXIT_BAD_INPUT;
  begin_pictures(s, "sensitivity", 1150, 1600);
  fputs("  set datafile separator ','\n  set datafile missing 'nan'\n", s);
  char title[200], file[100];
  shorten(name, file, sizeof file);
  (void)snprintf(title, sizeof title, "%s: w_c |d r_c / d q_k|, and what friction does", file);
  fprintf(s, "  set multiplot title %s noenhanced\n", quote(AS_GNUPLOT, title).text);
  draw_maps(s, of, least, most);
  draw_curves(s, of, 0);
  draw_curves(s, of, 1);
  return draw_script(s, directory, "sensitivity") ? EXIT_SOLVED : EXIT_BAD_INPUT;
}

/* ---- text ------------------------------------------------------------------------------------ */

/* Prints the contacts with the largest reactions, and whose q moves them most. */
static void print_sensitivity(const influence *of, const char *directory) {
  const int d = of->contact->d, nc = of->contact->nc;
  unsigned char *told = calloc((size_t)nc, 1);
  if (!told) return;
  puts("  reactions and what moves them, w |d r_c / d q_k|, the largest reactions first:");
  puts("    contact state          |r|      d|r|/dmu  by q of contacts");
  for (int line = 0; line < listed && line < nc; line++) {
    int best = -1;
    double most = 0, along = 0;
    for (int c = 0; c < nc; c++) {
      double size = 0;
      for (int i = 0; i < d; i++)
        size = hypot(size, of->r[d * c + i]);
      if (told[c] || !(size > most)) continue;
      best = c;
      most = size;
    }
    if (best < 0) break;
    told[best] = 1;
    for (int i = 0; i < d; i++)
      along += of->r[d * best + i] / most * of->dmu[d * best + i];
    printf("    %7d %-5s %12.5g  %12.5g ", best, state_word(of->state[best]), most, along);
    double above = INFINITY;
    for (int n = 0; n < named; n++) { /* the next largest */
      int by = -1;
      for (int k = 0; k < nc; k++)
        if (effect_of(of, best, k) < above &&
            (by < 0 || effect_of(of, best, k) > effect_of(of, best, by)))
          by = k;
      if (by < 0) break;
      above = effect_of(of, best, by);
      if (above > 0) printf(" %d (%.2g)", by, above);
    }
    putchar('\n');
  }
  printf("  the map of all: %s/sensitivity.png, .csv, friction.csv\n",
         quote(AS_SHOWN, directory).text);
  free(told);
}

/* ---- the call -------------------------------------------------------------------------------- */

int show_sensitivity(const char *name, const dls_contact *contact, const double *r,
                     const char *directory, int text) {
  const size_t nc = (size_t)contact->nc, m = (size_t)contact->d * nc;
  influence of = {.contact = contact, .r = r};
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  dls_certificate certificate;
  int result = EXIT_BAD_INPUT;
  of.u = calloc(3 * m + m * m + parts * nc * nc, sizeof *of.u);
  of.state = malloc(nc * sizeof *of.state);
  dls_status status = of.u && of.state ? DLS_OK : DLS_E_MEMORY;
  if (!status) {
    of.dq = of.u + m;
    of.dmu = of.dq + m * m;
    of.map = of.dmu + m;
    status = dls_contact_certify(contact, r, of.u, &certificate, &error);
  }
  if (!status) status = dls_contact_states(contact, r, of.u, of.state, &error);
  if (!status) status = find_influence(&of, of.map + parts * nc * nc, &error);
  if (status)
    (void)complain_of(name, &error);
  else {
    fill_map(&of);
    result = draw_sensitivity(&of, name, directory);
    if (result == EXIT_SOLVED && text) print_sensitivity(&of, directory);
  }
  free(of.u);
  free(of.state);
  return result;
}
