/* fclib_file.h: the problems of data/fclib. */
#ifndef FCLIB_FILE_H
#define FCLIB_FILE_H

#include "delassus/files.h"

/* Their names, without folder and ending. */
enum { fclib_count = 7 };
extern const char *const fclib_files[fclib_count];

/* Reads data/fclib/NAME.hdf5, which the caller destroys. NULL in a build without HDF5. */
dls_fclib *read_fclib_file(const char *name);

#endif
