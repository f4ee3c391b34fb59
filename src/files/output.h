/* output.h: writes files so that either the whole new file exists or the old one stays. */
#ifndef DLSI_OUTPUT_H
#define DLSI_OUTPUT_H

#include <stdio.h>

#include "delassus/status.h"

/* A file that is being written: the library and the program write every file by it. */
enum { dlsi_longest_path = 4096 };
typedef struct dlsi_output {
  FILE *file;                        /* to print into; NULL: none is open */
  char path[dlsi_longest_path];      /* the end of the links */
  char temporary[dlsi_longest_path]; /* name until the file is whole; "": path is written itself */
  int is_table;                      /* 1: a head and rows, of use without those that follow */
} dlsi_output;

/* Opens a file that will replace `path` when it is finished. DLS_E_FILE: cannot be written there;
 * nothing happened. */
dls_status dlsi_output_open(dlsi_output *out, const char *path, dls_error *error);

/* Closes the file, brings it to the disk and puts it in its place. DLS_E_FILE: an earlier write or
 * one of these steps failed; the old file is still there, or of a table the rows that were written
 * (dlsi_output_keep_rows). */
dls_status dlsi_output_finish(dlsi_output *out, dls_error *error);

/* Ends a table where writing it further makes no sense, as on a full disk: the whole rows that were
 * written become the file. Without a row after the head the old file stays. */
void dlsi_output_keep_rows(dlsi_output *out);

/* Gives the file up: the old file is still there. Does nothing if none is open. */
void dlsi_output_drop(dlsi_output *out);

#endif
