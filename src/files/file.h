/* file.h: opens and closes files for all readers and writers, with one report of what goes
 * wrong. */
#ifndef DLSI_FILE_H
#define DLSI_FILE_H

#include <stdio.h>

#include "base/base.h"

/* Opens `path` for reading; NULL and DLS_E_FILE in *error if it is missing or a directory. */
FILE *dlsi_file_open(const char *path, dls_error *error);

/* Opens `path` for writing anew, mode "w" or "wb"; NULL and DLS_E_FILE in *error on failure. */
FILE *dlsi_file_create(const char *path, const char *mode, dls_error *error);

/* Closes a file that was written; if any write failed, removes it and returns DLS_E_FILE. */
dls_status dlsi_file_finish(const char *path, FILE *file, dls_error *error);

#endif
