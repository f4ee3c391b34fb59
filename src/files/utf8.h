/* utf8.h: reads UTF-8 that may be invalid. */
#ifndef DLSI_UTF8_H
#define DLSI_UTF8_H

/* Returns the character at text and its length in bytes, 1 to 4. Returns 0 and the length 0 at the
 * end; returns -1 and the length 1 at a byte that begins no character: an overlong form, half of a
 * pair (U+D800 to U+DFFF) and numbers beyond U+10FFFF are none. */
long dlsi_utf8_next(const char *text, int *length);

#endif
