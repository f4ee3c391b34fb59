/* utf8.c: utf8.h, after Table 3-7 of the Unicode standard. */
#include "base/utf8.h"

#include <stdio.h>
#include <string.h>

long dlsi_utf8_next(const char *text, int *length) {
  static const long least[] = {0, 0, 0x80, 0x800, 0x10000}; /* of so many bytes */
  const unsigned char *byte = (const unsigned char *)text;
  *length = byte[0] ? 1 : 0;
  if (byte[0] < 0x80) return byte[0];
  const int bytes = byte[0] >= 0xf0 ? 4 : byte[0] >= 0xe0 ? 3 : 2;
  if (byte[0] < 0xc0 || byte[0] >= 0xf8) return -1;
  long code = byte[0] & (0x7f >> bytes);
  for (int k = 1; k < bytes; k++) {
    if ((byte[k] & 0xc0) != 0x80) return -1; /* the final 0 is such a byte */
    code = code << 6 | (byte[k] & 0x3f);
  }
  if (code < least[bytes] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return -1;
  *length = bytes;
  return code;
}

int dlsi_utf8_is_control(long code) {
  return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0xfffe || code == 0xffff;
}

int dlsi_utf8_turns_line(long code) {
  return code == 0x200e || code == 0x200f || (code >= 0x202a && code <= 0x202e) ||
         (code >= 0x2066 && code <= 0x2069);
}

void dlsi_utf8_show(char form[dlsi_shown_room], const char *text, long code, int length) {
  if (code == '\n' || code == '\t')
    (void)snprintf(form, dlsi_shown_room, code == '\n' ? "\\n" : "\\t");
  else if (dlsi_utf8_is_control(code) || dlsi_utf8_turns_line(code)) /* no character is -1 */
    for (int k = 0; k < length; k++)
      (void)snprintf(form + 4 * k, 5, "\\x%02x", (unsigned char)text[k]);
  else
    (void)snprintf(form, dlsi_shown_room, "%.*s", length, text);
}

void dlsi_utf8_show_all(char *to, size_t room, const char *text) {
  size_t used = 0;
  int length;
  to[0] = '\0';
  for (long code; (code = dlsi_utf8_next(text, &length)) != 0; text += length) {
    char form[dlsi_shown_room];
    dlsi_utf8_show(form, text, code, length);
    const size_t size = strlen(form);
    if (used + size >= room) break;
    memcpy(to + used, form, size + 1);
    used += size;
  }
}
