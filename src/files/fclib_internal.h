/* fclib_internal.h: names of the data sets of the matrices in an FCLIB file, within their group. */
#ifndef DLSI_FCLIB_H
#define DLSI_FCLIB_H

typedef struct matrix_names {
  const char *m, *n, *nz, *nzmax, *p, *i, *x;
} matrix_names;

#define MATRIX(a)                                                                                  \
  { a "/m", a "/n", a "/nz", a "/nzmax", a "/p", a "/i", a "/x" }

static const matrix_names names_W = MATRIX("W"), names_M = MATRIX("M"), names_H = MATRIX("H"),
                          names_G = MATRIX("G");

#endif
