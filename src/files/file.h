/* file.h: opens files for all readers and writers; reports what goes wrong. */
#ifndef DLSI_FILE_H
#define DLSI_FILE_H

#include <stdio.h>

#include "contact/columns.h"
#include "contact/contact.h"
#include "delassus/files.h"

/* Opens `path` for reading, past a byte order mark; NULL and DLS_E_FILE in *error if it is missing
 * or a directory. */
FILE *dlsi_file_open(const char *path, dls_error *error);

/* Returns the bytes of an open file, -1 for a pipe. Compare with them what a file claims to hold
 * before you allocate memory. */
long long dlsi_file_size(FILE *file);

/* *content := all of the file behind its place, *size bytes and a 0; free it after an error. */
dls_status dlsi_file_content(FILE *file, char **content, size_t *size, dls_error *error);

/* Reads a real Matrix Market file, or, where `calculix`, that format; lists both halves of a
 * symmetric one. *symmetric (or NULL): of the whole. Free t also after an error. Errors of
 * dls_mtx_read. */
dls_status dlsi_mtx_read_file(const char *path, int calculix, dlsi_triplets *t, int *symmetric,
                              dls_error *error);

/* Returns the triplets as new compressed columns, whose arrays dls_mtx_free_sparse frees. */
dls_status dlsi_mtx_columns(const dlsi_triplets *t, dls_sparse *A, dls_error *error);

/* Reads a finite decimal number, a word of `length` characters, with a decimal point in every
 * locale of the host, also with exponents of Fortran (1D0). Returns 0 for any other word. */
enum { dlsi_longest_number = 64 }; /* a double needs 24 characters */
int dlsi_read_number(const char *word, size_t length, double *value);

/* Returns the text of line k = 0, 1, .. of those that are no part of the problem, and its *key (or
 * NULL); NULL after the last one. */
const char *dlsi_text_line(const dls_text *text, int k, const char **key);

/* Reads exactly `count` numbers from a text; returns 0 if there are more or less. */
int dlsi_text_numbers(const char *text, int count, double *x);

#endif
