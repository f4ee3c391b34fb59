/* output.h: writes files that are either the old ones or whole new ones. */
#ifndef DLSI_OUTPUT_H
#define DLSI_OUTPUT_H

#include <stdio.h>

#include "delassus/status.h"

/* A file that is being written: the library and the program write every file this way. */
enum { dlsi_longest_path = 4096 };
typedef struct dlsi_output {
  FILE *file;                        /* to print into; NULL: none is open */
  char path[dlsi_longest_path];      /* what links lead to */
  char temporary[dlsi_longest_path]; /* name until the file is whole; "": path is written itself */
} dlsi_output;

/* Opens a file that will take the place of `path` when it is finished. DLS_E_FILE: cannot be
 * written there; nothing happened. */
dls_status dlsi_output_open(dlsi_output *out, const char *path, dls_error *error);

/* Closes the file, brings it to the disk and puts it in its place. DLS_E_FILE: any write before or
 * one of these steps failed; what was there before is still there. */
dls_status dlsi_output_finish(dlsi_output *out, dls_error *error);

/* Gives the file up: what was there before is still there. Nothing happens where none is open. */
void dlsi_output_drop(dlsi_output *out);

#endif
