/* quote.c: writes names and titles, which are anybody's bytes, as text of a file or of a terminal.
 * Names reach scripts, tables and JSON through these functions alone. */
#include <string.h>

#include "base/utf8.h"
#include "console.h"

/* Room for the longest form of a character, such as 4 bytes as \xNN. */
enum { longest_form = 24 };

/* Characters that gnuplot may interpret: in blocks of braces even within single quotes. As \0ooo in
 * double quotes they are text everywhere. */
static const char live_in_gnuplot[] = "\"'\\`$@#{}";

/* Writes the first character of the text, one of ASCII, as gnuplot has to read it. gnuplot copies
 * "]]>" into SVG as it is, which XML forbids: a space of no width stands within. */
static void write_gnuplot(char form[longest_form], const char *text) {
  if (strchr(live_in_gnuplot, text[0]))
    (void)snprintf(form, longest_form, "\\0%03o", (unsigned)text[0]);
  else if (strncmp(text, "]]>", 3) == 0)
    (void)snprintf(form, longest_form, "]\xe2\x80\x8b");
}

/* Writes the character of `length` bytes at text into form. */
static void write_form(char form[longest_form], text_kind kind, const char *text, long code,
                       int length) {
  if (kind == AS_SHOWN) {
    dlsi_utf8_show(form, text, code, length);
    return;
  }
  (void)snprintf(form, longest_form, "%.*s", length, text);
  const int turns = dlsi_utf8_turns_line(code);
  if (code < 0 || code == 0xfffe || code == 0xffff || (turns && kind != AS_JSON)) {
    (void)snprintf(form, longest_form, "\xef\xbf\xbd"); /* U+FFFD */
  } else if (kind == AS_JSON) {
    if (code == '"' || code == '\\')
      (void)snprintf(form, longest_form, "\\%c", (char)code);
    else if (turns || dlsi_utf8_is_control(code))
      (void)snprintf(form, longest_form, "\\u%04lx", (unsigned long)code);
  } else if (dlsi_utf8_is_control(code)) {
    (void)snprintf(form, longest_form, " ");
  } else if (kind == AS_CSV) {
    if (code == '"') (void)snprintf(form, longest_form, "\"\"");
  } else if (kind == AS_HTML) {
    const char *name = code == '&' ? "amp" : code == '<' ? "lt" : code == '>' ? "gt" : "quot";
    if (code < 0x80 && strchr("&<>\"", (char)code))
      (void)snprintf(form, longest_form, "&%s;", name);
  } else if (code < 0x80) {
    write_gnuplot(form, text);
  }
}

/* Returns the mark on both sides of the text. */
static const char *side_mark(text_kind kind, const char *text) {
  if (kind == AS_SHOWN || kind == AS_HTML) return "";
  if (kind != AS_CSV) return "\"";
  return text[0] == '#' || text[0] == ' ' || text[strcspn(text, ",\"")] ? "\"" : "";
}

/* Returns 1 for a text that a spreadsheet would compute. */
static int is_formula(const char *text) {
  return text[0] && strchr("=+-@", text[0]);
}

quoted quote(text_kind kind, const char *text) {
  quoted q;
  const char *mark = side_mark(kind, text);
  int length;
  size_t used = (size_t)snprintf(q.text, sizeof q.text, "%s%s", mark,
                                 kind == AS_CSV && is_formula(text) ? "'" : "");
  for (long code; (code = dlsi_utf8_next(text, &length)) != 0; text += length) {
    char form[longest_form];
    write_form(form, kind, text, code, length);
    if (used + strlen(form) + 2 > sizeof q.text) break;
    memcpy(q.text + used, form, strlen(form) + 1);
    used += strlen(form);
  }
  memcpy(q.text + used, mark, strlen(mark) + 1);
  return q;
}
