/*
 * delassus/layout.h: the layouts of the public structs and the values of the public constants as
 * the library was compiled with, for other languages: src/python builds its structs from them,
 * src/fortran its types. The headers of delassus.h are covered, without delassus/fe.h.
 */
#ifndef DELASSUS_LAYOUT_H
#define DELASSUS_LAYOUT_H

#include "delassus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A field of a public struct; all strings are static. */
typedef struct dls_field {
  const char *record; /* name of the struct, "dls_limits" */
  const char *name;   /* "tol"; "" for the whole struct, which comes before its fields */
  const char *type;   /* of one element: "int" (enums, too), "long long", "size_t", "double",
                         "char", "pointer", "function", or the name of a struct */
  size_t offset;      /* bytes */
  size_t size;        /* bytes, of all elements */
  size_t count;       /* elements: 1, or those of an array */
} dls_field;

/* Returns field k = 0, 1, .. of all structs, each in the order of its declaration; NULL after the
 * last, and for k < 0. A struct comes after those that it contains by value. */
DLS_API const dls_field *dls_layout_field(int k);

/* A constant of an enum. */
typedef struct dls_constant {
  const char *name; /* "DLS_OK" */
  int value;
} dls_constant;

/* Returns constant k = 0, 1, ..; NULL after the last, and for k < 0. */
DLS_API const dls_constant *dls_layout_constant(int k);

#ifdef __cplusplus
}
#endif

#endif
