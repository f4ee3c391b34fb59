/*
 * report_page.c: the page of delassus report: one HTML file, well-formed XML besides, that loads
 * nothing; and the same as text on stdout. Names and words, which are anybody's bytes, go through
 * quote(); the pictures are gnuplot's, within the page.
 */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "report.h"

static const double readable = 10; /* pixels of the page that the smallest letters have at least */
enum { MOST_PICTURE = 280000 };    /* bytes: four pictures and the tables stay below 1 MB */

/* Colours follow the reader's; pictures are drawn on white and turned in the dark. */
static const char head[] =
    "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\" />\n"
    "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\" />\n"
    "<meta name=\"color-scheme\" content=\"light dark\" />\n";
static const char style[] =
    "<style>\n"
    ":root { --ink: #1a1a1a; --paper: #fff; --line: #d0d0d0; --soft: #f3f5f8; --mark: #0050a0 }\n"
    "@media (prefers-color-scheme: dark) {\n"
    "  :root { --ink: #e6e6e6; --paper: #191919; --line: #444; --soft: #242629; --mark: #8ab8f0 }\n"
    "  svg { filter: invert(.9) hue-rotate(180deg) }\n}\n"
    "body { margin: 0 auto; padding: 1rem; max-width: 72rem; color: var(--ink);\n"
    "  background: var(--paper); font: 16px/1.5 system-ui, sans-serif }\n"
    "h1 { font-size: 1.4rem; margin: 0 0 .5rem; overflow-wrap: anywhere }\n"
    "h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; padding-top: .5rem;\n"
    "  border-top: 1px solid var(--line) }\n"
    ".lead { font-size: 1.15rem; padding: .7rem 1rem; background: var(--soft);\n"
    "  border-left: 4px solid var(--mark); overflow-wrap: anywhere }\n"
    ".note { font-size: .9rem; opacity: .85 }\n"
    "span { white-space: nowrap }\n"
    "p { margin: .5rem 0 } p, li { overflow-wrap: anywhere }\n"
    ".wide { overflow-x: auto; margin: .7rem 0 }\n"
    "table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums }\n"
    "th, td { padding: .2rem .7rem .2rem 0; text-align: right; white-space: nowrap;\n"
    "  border-bottom: 1px solid var(--line) }\n"
    "th { font-weight: 600 } th:first-child, td:first-child, .word { text-align: left }\n"
    ".word { padding-left: .7rem }\n"
    "pre { background: var(--soft); padding: .4rem .7rem; margin: .3rem 0; font-size: .85rem;\n"
    "  white-space: pre-wrap; overflow-wrap: anywhere }\n"
    "figure { margin: .8rem 0 } figcaption { font-size: .9rem; opacity: .85 }\n"
    "svg { display: block; width: 100%; height: auto } image { image-rendering: pixelated }\n"
    "@media (max-width: 600px) { table { font-size: .78rem }\n"
    "  th, td { white-space: normal; padding-right: .4rem } }\n"
    "@media print {\n"
    "  :root { --ink: #000; --paper: #fff; --line: #bbb; --soft: #f3f3f3; --mark: #000 }\n"
    "  svg { filter: none; min-width: 0 !important } html { font-size: 11px }\n"
    "  body { font-size: 1rem; max-width: none }\n"
    "  figure, table, pre { break-inside: avoid } h2 { break-after: avoid }\n"
    "  .wide { overflow: visible }\n}\n"
    "</style>\n</head>\n<body>\n";

int page_open(page *p, const char *directory, const char *name, const char *title, int text) {
  p->html = open_in(directory, name);
  p->text = text;
  p->pictures = 0;
  if (!p->html) return 0;
  fprintf(p->html, "%s<title>%s</title>\n%s", head, quote(AS_HTML, title).text, style);
  page_say(p, PAGE_TITLE, "%s", title);
  return 1;
}

int page_close(page *p, const char *name) {
  fputs("</body>\n</html>\n", p->html);
  return close_file(p->html, name);
}

/* Writes text between tags; numbers such as 1e-03, with their units, and options stay in one line.
 * copied = 1: blanks stay what they are. */
static void write_words(const page *p, const char *text, int copied) {
  const quoted q = quote(AS_HTML, text);
  for (const char *at = q.text; *at;) {
    const int length = (int)strcspn(at, " ");
    const int digits = (int)strspn(at, "+-.0123456789"); /* of 1e-03, not of three-solutions */
    const int power = digits > 0 && digits < length && !strncmp(at + digits, "e-", 2);
    const int whole = power || (!strncmp(at, "--", 2) && length < 40);
    fprintf(p->html, whole ? "<span>%.*s</span>" : "%.*s", length, at);
    at += length;
    const int unit = *at && digits == length && digits && strcspn(at + 1, " .,:;)") <= 3;
    fputs(unit && !copied ? "\xc2\xa0" : *at ? " " : "", p->html);
    at += *at == ' ';
  }
}

void page_say(page *p, page_words kind, const char *format, ...) {
  static const char *const begin[] = {[PAGE_TITLE] = "<h1>",
                                      [PAGE_SECTION] = "<h2>",
                                      [PAGE_LEAD] = "<p class=\"lead\">",
                                      [PAGE_PLAIN] = "<p>",
                                      [PAGE_NOTE] = "<p class=\"note\">",
                                      [PAGE_COMMAND] = "<pre>"};
  static const char *const end[] = {"</h1>", "</h2>", "</p>", "</p>", "</p>", "</pre>"};
  char text[PAGE_SENTENCE];
  va_list args;
  va_start(args, format);
  if (vsnprintf(text, sizeof text, format, args) < 0) text[0] = '\0';
  va_end(args);
  fputs(begin[kind], p->html);
  write_words(p, text, kind == PAGE_COMMAND);
  fprintf(p->html, "%s\n", end[kind]);
  if (!p->text) return;
  const char *shown = kind == PAGE_SECTION ? "\n== " : kind == PAGE_COMMAND ? "  $ " : "";
  printf("%s%s%s\n", shown, quote(AS_SHOWN, text).text, kind == PAGE_SECTION ? " ==" : "");
}

/* ---- tables ---------------------------------------------------------------------------------- */

void page_table(page *p, const char *heads) {
  p->columns = p->cells = 0;
  while (*heads) {
    const int length = (int)strcspn(heads, ",");
    page_cell(p, "%.*s", length, heads);
    p->columns++;
    heads += length + (heads[length] == ',');
  }
}

void page_cell(page *p, const char *format, ...) {
  va_list args;
  if (p->cells == PAGE_CELLS) return;
  va_start(args, format);
  if (vsnprintf(p->cell[p->cells], PAGE_CELL, format, args) < 0) p->cell[p->cells][0] = '\0';
  va_end(args);
  p->cells++;
}

/* Prints a row of the table in text, each column as wide as its widest cell. */
static void page_row(const page *p, int row, const int *width) {
  for (int j = 0; j < p->columns; j++) {
    const quoted q = quote(AS_SHOWN, p->cell[row * p->columns + j]);
    printf(j ? "  %*s" : "%-*s", width[j], q.text);
  }
  putchar('\n');
}

void page_table_end(page *p) {
  int width[PAGE_COLUMNS] = {0};
  const int rows = p->columns ? p->cells / p->columns : 0;
  fputs("<div class=\"wide\"><table>\n", p->html);
  for (int i = 0; i < rows; i++) {
    const char *mark = i ? "td" : "th";
    fputs("<tr>", p->html);
    for (int j = 0; j < p->columns; j++) {
      const char *cell = p->cell[i * p->columns + j];
      const int length = (int)strlen(quote(AS_SHOWN, cell).text);
      const int below = p->cell[(rows > 1) * p->columns + j][0] | 32;
      if (length > width[j]) width[j] = length;
      fprintf(p->html, j && below >= 'a' && below <= 'z' ? "<%s class=\"word\">" : "<%s>", mark);
      write_words(p, cell, 0);
      fprintf(p->html, "</%s>", mark);
    }
    fputs("</tr>\n", p->html);
  }
  fputs("</table></div>\n", p->html);
  for (int i = 0; p->text && i < rows; i++)
    page_row(p, i, width);
}

/* Finds the numbers of the wanted columns; returns how many. */
static int find_columns(const csv_table *t, const char *columns, int *which) {
  int found = 0;
  for (int k = 0; k < t->columns && !*columns && found < PAGE_COLUMNS; k++)
    which[found++] = k;
  while (*columns && found < PAGE_COLUMNS) {
    const size_t length = strcspn(columns, ",");
    const int k = csv_column(t, columns, length);
    if (k >= 0) which[found++] = k;
    columns += length + (columns[length] == ',');
  }
  return found;
}

/* Adds a field, a number to four digits. */
static void add_field(page *p, const char *text) {
  char *end;
  const double x = strtod(text, &end);
  if (x != x)
    page_cell(p, "-");
  else if (*text && !*end && strlen(text) > 6)
    page_cell(p, "%.4g", x);
  else
    page_cell(p, "%s", text);
}

/* Returns 1 if the row at hand has the field `only`, or that is NULL. */
static int row_counts(const csv_table *t, const char *only) {
  for (int k = 0; only && k < t->fields; k++)
    if (!strcmp(t->field[k], only)) return 1;
  return !only;
}

int page_csv(page *p, const char *directory, const char *name, const char *columns,
             const char *only, int rows) {
  csv_table t;
  int which[PAGE_COLUMNS], count = 0, row = 0;
  if (!csv_open(&t, directory, name)) return 0;
  while (csv_next(&t))
    count += row_counts(&t, only);
  if (!csv_open(&t, directory, name)) return 0;
  p->columns = find_columns(&t, columns, which);
  p->cells = 0;
  for (int j = 0; j < p->columns; j++) {
    const char *column = t.column[which[j]];
    page_cell(p, "%s", strcmp(column, "times_fastest") ? column : "over the fastest");
  }
  while (csv_next(&t)) {
    if (!row_counts(&t, only) || row++ < count - rows) continue;
    for (int j = 0; j < p->columns; j++)
      add_field(p, which[j] < t.fields ? t.field[which[j]] : "");
  }
  if (p->columns) page_table_end(p);
  return p->columns > 0;
}

/* ---- pictures -------------------------------------------------------------------------------- */

/* Reads a file whole, up to MOST_PICTURE bytes; the caller frees it. NULL: not there, too large. */
static char *read_picture(const char *directory, const char *name) {
  char path[PATH_ROOM];
  if (!join_path(path, directory, name)) return NULL;
  FILE *file = fopen(path, "rb");
  if (!file) return NULL;
  char *text = malloc(MOST_PICTURE + 1);
  const size_t got = text ? fread(text, 1, MOST_PICTURE + 1, file) : 0;
  (void)fclose(file);
  if (got == 0 || got > MOST_PICTURE) {
    free(text);
    return NULL;
  }
  text[got] = '\0';
  return text;
}

/* Returns 1 if an id of the picture, or a reference to one, follows the character. */
static int before_id(const char *at) {
  static const char *const before[] = {" id='", " id=\"", "href='#", "href=\"#", "url(#"};
  for (int k = 0; k < 5; k++) {
    const size_t length = strlen(before[k]);
    if (!strncmp(at + 1 - length, before[k], length)) return 1;
  }
  return 0;
}

/* Writes what follows the first tag of the picture: the ids of gnuplot, which all pictures share,
 * get the number of this one; its title, the same for all, is left out. */
static void write_picture(const page *p, const char *text) {
  const char *title = strstr(text, "<title>Gnuplot</title>");
  if (title) text = title + strlen("<title>Gnuplot</title>");
  for (int in_tag = 0; *text; text++) {
    fputc(*text, p->html);
    in_tag = *text == '<' || (in_tag && *text != '>');
    if (in_tag && before_id(text)) fprintf(p->html, "p%d", p->pictures);
  }
}

/* Returns the size of the smallest letters, in pixels of the picture. */
static double smallest_letters(const char *text) {
  double least = 16;
  for (const char *at = text; (at = strstr(at, "font-size=\"")) != NULL;) {
    double size;
    at += strlen("font-size=\"");
    if (read_real(&at, &size) && size > 0 && size < least) least = size;
  }
  return least;
}

int page_picture(page *p, const char *directory, const char *name, const char *words) {
  double width, height;
  char *text = read_picture(directory, name);
  const char *box = text ? strstr(text, "viewBox=\"") : NULL;
  const char *after = box ? strchr(box, '>') : NULL, *at = box ? strstr(box, "0 0 ") : NULL;
  if (at) at += strlen("0 0 ");
  const int good = after && at && read_real(&at, &width) && read_real(&at, &height);
  if (good) {
    const double least = width * readable / smallest_letters(text);
    p->pictures++;
    /* a wide picture scrolls on a small screen, where its words would be too small */
    fprintf(p->html,
            "<figure><div class=\"wide\"><svg role=\"img\" aria-label=\"%s\" viewBox=\"0 0 %g %g\" "
            "style=\"max-width:%gpx;min-width:%gpx\" xmlns=\"http://www.w3.org/2000/svg\" "
            "xmlns:xlink=\"http://www.w3.org/1999/xlink\">",
            quote(AS_HTML, words).text, width, height, fmax(width, least), least);
    write_picture(p, after + 1);
    fprintf(p->html, "</div><figcaption>%s</figcaption></figure>\n", quote(AS_HTML, words).text);
    if (p->text)
      printf("[picture: %s/%s: %s]\n", quote(AS_SHOWN, directory).text, name,
             quote(AS_SHOWN, words).text);
  }
  free(text);
  return good;
}
