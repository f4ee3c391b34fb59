/* utf8.h: reads UTF-8 that may be invalid, and shows it on a terminal. */
#ifndef DLSI_UTF8_H
#define DLSI_UTF8_H

#include <stddef.h>

/* Returns the character at text and its length in bytes, 1 to 4. Returns 0 and the length 0 at the
 * end. Returns -1 and the length 1 at a byte that starts no character: an overlong form, half of a
 * pair (U+D800 to U+DFFF) or a number beyond U+10FFFF. */
long dlsi_utf8_next(const char *text, int *length);

/* Returns 1 for characters that our files cannot hold: controls (C0, DEL, C1), and characters
 * excluded from XML, to which gnuplot copies labels. */
int dlsi_utf8_is_control(long code);

/* Returns 1 for a mark that changes the direction of a line: it can make a name look like another
 * one. */
int dlsi_utf8_turns_line(long code);

/* Room for the longest form of a character, 4 bytes as \xNN, and its end. */
enum { dlsi_shown_room = 17 };

/* Writes the character of `length` bytes at text in a form safe for a terminal: a line feed as \n,
 * a tab as \t; other controls, marks that change the direction of a line, and invalid UTF-8 byte by
 * byte as \xNN. */
void dlsi_utf8_show(char form[dlsi_shown_room], const char *text, long code, int length);

/* Writes as many characters of text as fit, in this form. A text shown twice stays the same. */
void dlsi_utf8_show_all(char *to, size_t room, const char *text);

#endif
