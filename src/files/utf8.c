/* utf8.c: utf8.h, after Table 3-7 of the Unicode standard. */
#include "files/utf8.h"

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
