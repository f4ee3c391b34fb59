/* fclib_internal.h: the names of a matrix's data sets, for reading and writing. */
#ifndef DLSI_FCLIB_H
#define DLSI_FCLIB_H

typedef struct matrix_names {
  const char *m, *n, *nz, *nzmax, *p, *i, *x;
} matrix_names;

#define MATRIX(a)                                                                                  \
  { a "/m", a "/n", a "/nz", a "/nzmax", a "/p", a "/i", a "/x" }

#endif
