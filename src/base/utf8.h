/* utf8.h: reads UTF-8 that may be invalid, and shows it on a terminal. */
#ifndef DLSI_UTF8_H
#define DLSI_UTF8_H

#include <stddef.h>

/* Returns the character at text and its length in bytes, 1 to 4. Returns 0 and the length 0 at the
 * end; returns -1 and the length 1 at a byte that begins no character: an overlong form, half of a
 * pair (U+D800 to U+DFFF) and numbers beyond U+10FFFF are none. */
long dlsi_utf8_next(const char *text, int *length);

/* Returns 1 for characters that no file of ours can hold: controls (C0, DEL, C1), and what XML, to
 * which gnuplot copies labels, leaves out. */
int dlsi_utf8_is_control(long code);

/* Room for the longest form of a character, 4 bytes as \xNN, and its end. */
enum { dlsi_shown_room = 17 };

/* Writes the character of `length` bytes at text as a terminal may get it: a line feed as \n, a tab
 * as \t; each byte of other controls, of marks that turn the direction of a line, and of what is no
 * UTF-8 as \xNN. */
void dlsi_utf8_show(char form[dlsi_shown_room], const char *text, long code, int length);

/* Writes as many characters of text as have room, each so. A text shown twice stays as it is. */
void dlsi_utf8_show_all(char *to, size_t room, const char *text);

#endif
