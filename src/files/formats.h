/* formats.h: matrices and tables in the formats of other codes. */
#ifndef DLSI_FORMATS_H
#define DLSI_FORMATS_H

#include "contact/columns.h"
#include "files/file.h"

/* The formats that are read. DLSI_TEXT: rows of numbers, if nothing else fits. */
typedef enum dlsi_format {
  DLSI_UNKNOWN, /* cannot be read, or belongs to another program */
  DLSI_MTX,
  DLSI_NPY,
  DLSI_NPZ,
  DLSI_PETSC,
  DLSI_BOEING,
  DLSI_FREEFEM,
  DLSI_OCTAVE,
  DLSI_ABAQUS,
  DLSI_CALCULIX,
  DLSI_TEXT
} dlsi_format;

/* Finds the format of a file: CalculiX's by the name, the others by the first bytes. DLS_E_FILE;
 * DLS_E_UNSUPPORTED for a format that is known and not read: the message says what to do. */
dls_status dlsi_format_find(const char *path, dlsi_format *format, dls_error *error);

/* Returns what a format is called ("an array of NumPy"). */
const char *dlsi_format_name(dlsi_format format);

/* Rows of numbers: a[i * cols + j]. commas: 1 if all commas may be decimal ones. Free a. */
typedef struct dlsi_table {
  int rows, cols, commas;
  double *a;
} dlsi_table;

/* Reads Matrix Market, .npy, PETSc's vectors or text as a table. Infinite numbers only in text. On
 * error, too, the caller frees t->a. */
dls_status dlsi_table_read(const char *path, dlsi_table *t, dls_error *error);

/* The bytes of a file and a place in them. */
typedef struct dlsi_bytes {
  const unsigned char *at;
  size_t size;
} dlsi_bytes;

/* Readers of one format each, from the bytes of a file. On error, too, the caller frees t or
 * table->a. */
dls_status dlsi_boeing_read(const dlsi_bytes *file, dlsi_triplets *t, int *symmetric,
                            dls_error *error);
dls_status dlsi_petsc_read(const dlsi_bytes *file, dlsi_triplets *t, dls_error *error);
dls_status dlsi_petsc_vector(const dlsi_bytes *file, dlsi_table *t, dls_error *error);
dls_status dlsi_npy_read(const dlsi_bytes *file, dlsi_table *t, dls_error *error);
dls_status dlsi_npz_read(const dlsi_bytes *file, dlsi_triplets *t, dls_error *error);

#endif
