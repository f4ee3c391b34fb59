/* json.c: the object that --json prints of a command whose result is a table (chart, map, profile)
 * or a run in time. */
#include <stdlib.h>
#include <string.h>

#include "console.h"

/* Cuts a line into fields in place; returns their number. */
static int cut_fields(char *line, char **field) {
  int count = 0;
  char *at = line;
  while (count < MOST_FIELDS) {
    char *to = at;
    const int in_quotes = *at == '"';
    field[count++] = at;
    at += in_quotes;
    while (*at && *at != '\n' && (in_quotes || *at != ',')) {
      if (in_quotes && *at == '"' && *++at != '"') break;
      *to++ = *at++;
    }
    const int more = *at == ',';
    *to = '\0';
    if (!more) return count;
    at++;
  }
  return count;
}

int csv_open(csv_table *t, const char *directory, const char *name) {
  char path[PATH_ROOM];
  t->columns = 0;
  t->file = !directory                         ? fopen(name, "r")
            : join_path(path, directory, name) ? fopen(path, "r")
                                               : NULL;
  while (t->file && !t->columns && fgets(t->head, sizeof t->head, t->file))
    if (t->head[0] != '#') t->columns = cut_fields(t->head, t->column);
  if (t->columns) return 1;
  if (t->file) (void)fclose(t->file);
  return 0;
}

int csv_next(csv_table *t) {
  do {
    if (!fgets(t->line, sizeof t->line, t->file)) return (void)fclose(t->file), 0;
  } while (t->line[0] == '#');
  t->fields = cut_fields(t->line, t->field);
  return 1;
}

int csv_column(const csv_table *t, const char *name, size_t length) {
  for (int k = 0; k < t->columns; k++)
    if (strlen(t->column[k]) == length && !strncmp(t->column[k], name, length)) return k;
  return -1;
}

/* Prints a field: as a number if it is one, null for an empty one or what is not finite. */
static void print_field(const char *text) {
  char *end;
  const double x = strtod(text, &end);
  if (!*text)
    fputs("null", stdout);
  else if (!*end)
    print_json_number(stdout, x);
  else
    print_json_string(stdout, text);
}

/* Prints the rows of a table of DIRECTORY as an array of objects. */
static int print_rows(const char *directory, const char *name) {
  csv_table t;
  if (!csv_open(&t, directory, name)) return refuse("%s/%s: cannot be read", directory, name);
  fputs(",\n  \"rows\": [", stdout);
  for (int row = 0; csv_next(&t); row++) {
    fputs(row ? ",\n    {" : "\n    {", stdout);
    for (int k = 0; k < t.fields && k < t.columns; k++) {
      if (k) fputs(", ", stdout);
      print_json_string(stdout, t.column[k]);
      fputs(": ", stdout);
      print_field(t.field[k]);
    }
    fputc('}', stdout);
  }
  fputs("\n  ]", stdout);
  return 1;
}

void print_json_head(const char *title, const char *status, const char *why) {
  fputs("{\n  \"command\": ", stdout);
  print_json_string(stdout, title);
  fputs(",\n  \"status\": ", stdout);
  print_json_string(stdout, status);
  if (!why) return;
  fputs(",\n  \"why\": ", stdout);
  print_json_string(stdout, why);
}

int end_table(int result, const char *why, const char *title, const char *directory,
              const char *name) {
  if (result != EXIT_BAD_INPUT) tell("files: %s\n", quote(AS_SHOWN, directory).text);
  if (!is_json() || result == EXIT_BAD_INPUT) return end_command(result, why);
  if (was_interrupted()) {
    result = EXIT_NOT_SOLVED;
    why = dls_status_text(DLS_CANCELLED);
  }
  print_json_head(title, result == EXIT_SOLVED ? "solved" : "not_solved",
                  result == EXIT_SOLVED ? NULL : why);
  fputs(",\n  \"directory\": ", stdout);
  print_json_string(stdout, directory);
  const int good = print_rows(directory, name);
  puts("\n}");
  return good ? result : EXIT_BAD_INPUT;
}
