/* json.c: the object that --json prints of a command whose result is a table (chart, map, profile)
 * or a run in time. */
#define _GNU_SOURCE
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

int cut_fields(char *line, char **field) {
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
  char path[PATH_ROOM], line[LONGEST_LINE], head[LONGEST_LINE], *column[MOST_FIELDS];
  if (!join_path(path, directory, name)) return 0;
  FILE *file = fopen(path, "r");
  if (!file || !fgets(head, sizeof head, file)) {
    if (file) (void)fclose(file);
    return complain("%s: cannot be read", path), 0;
  }
  const int columns = cut_fields(head, column);
  fputs(",\n  \"rows\": [", stdout);
  for (int row = 0; fgets(line, sizeof line, file);) {
    char *field[MOST_FIELDS];
    if (line[0] == '#') continue;
    const int count = cut_fields(line, field);
    fputs(row++ ? ",\n    {" : "\n    {", stdout);
    for (int k = 0; k < count && k < columns; k++) {
      if (k) fputs(", ", stdout);
      print_json_string(stdout, column[k]);
      fputs(": ", stdout);
      print_field(field[k]);
    }
    fputc('}', stdout);
  }
  fputs("\n  ]", stdout);
  (void)fclose(file);
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
