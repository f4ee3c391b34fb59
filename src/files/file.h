/* file.h: what the readers and writers of files share. */
#ifndef DLSI_FILE_H
#define DLSI_FILE_H

#include <stdio.h>

#include "base/base.h"

/* Opens `path` for reading; NULL and DLS_E_FILE in *error if it is missing or a directory. */
FILE *dlsi_file_open(const char *path, dls_error *error);

/* Closes a file that was written; if any write failed, removes it and returns DLS_E_FILE. */
dls_status dlsi_file_finish(const char *path, FILE *file, dls_error *error);

#endif
