/*
 * petsc.c: matrices and vectors that PETSc has written (PetscViewerBinaryOpen, MatView, VecView):
 * big-endian whole numbers of 4 bytes (8 with --with-64-bit-indices) and doubles.
 *
 *   matrix: 1211216, rows, columns, entries; entries of each row; their columns, from 0; values
 *   dense:  1211216, rows, columns, -1; values, row by row
 *   vector: 1211214, size; values
 */
#include <limits.h>
#include <string.h>

#include "files/formats.h"

enum { petsc_matrix = 1211216, petsc_vector = 1211214 };

typedef struct petsc_reader {
  const dlsi_bytes *file;
  size_t at, width; /* width: bytes of a whole number */
} petsc_reader;

static uint64_t big_endian(const unsigned char *at, size_t width) {
  uint64_t bits = 0;
  for (size_t b = 0; b < width; b++)
    bits = bits << 8 | at[b];
  return bits;
}

/* Returns the next whole number; -1 past the end, for -1 and for a larger one than INT_MAX. */
static int take_whole(petsc_reader *p) {
  if (p->file->size - p->at < p->width) return -1;
  const uint64_t value = big_endian(p->file->at + p->at, p->width);
  p->at += p->width;
  return value <= INT_MAX ? (int)value : -1;
}

static double take_double(petsc_reader *p) {
  const uint64_t bits = big_endian(p->file->at + p->at, 8);
  double value;
  p->at += 8;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static petsc_reader petsc_begin(const dlsi_bytes *file) {
  return (petsc_reader){.file = file, .width = file->size && file->at[1] ? 4 : 8};
}

static dls_status petsc_wrong(const char *what, dls_error *error) {
  return dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0, "is a file of PETSc: %s", what);
}

static const char wrong_size[] = "its size is not what its first numbers say (complex numbers and "
                                 "single precision are not read)";

/* Reads the values row by row, behind the numbers of entries and columns. */
static dls_status petsc_entries(petsc_reader *p, int entries, dlsi_triplets *t, dls_error *error) {
  petsc_reader column = {p->file, p->at + (size_t)t->rows * p->width, p->width};
  petsc_reader value = {p->file, column.at + (size_t)entries * p->width, p->width};
  int left = entries;
  for (int i = 0; i < t->rows; i++) {
    const int count = take_whole(p);
    if (count < 0 || count > left)
      return petsc_wrong("a row has more entries than there are", error);
    left -= count;
    for (int k = 0; k < count; k++) {
      const int j = take_whole(&column);
      if (j < 0 || j >= t->cols) return petsc_wrong("a column is out of range", error);
      dlsi_triplets_add(t, i, j, take_double(&value));
    }
  }
  return left ? petsc_wrong("its rows have fewer entries than there are", error) : DLS_OK;
}

dls_status dlsi_petsc_read(const dlsi_bytes *file, dlsi_triplets *t, dls_error *error) {
  petsc_reader p = petsc_begin(file);
  if (take_whole(&p) != petsc_matrix) return petsc_wrong("is a vector, no matrix", error);
  const int rows = take_whole(&p), cols = take_whole(&p);
  const size_t at = p.at;
  const int entries = take_whole(&p), dense = entries < 0;
  if (rows < 1 || cols < 1) return petsc_wrong("it has no size", error);
  const size_t count = dense ? (size_t)rows * (size_t)cols : (size_t)entries;
  const size_t heads = dense ? 0 : (size_t)rows + count, rest = file->size - p.at;
  if (at == p.at || count > rest / 8 || heads > rest / p.width ||
      rest != heads * p.width + 8 * count)
    return petsc_wrong(wrong_size, error);
  const dls_status status = dlsi_triplets_alloc(rows, cols, count, t, error);
  if (status || !dense) return status ? status : petsc_entries(&p, entries, t, error);
  for (int i = 0; i < rows; i++)
    for (int j = 0; j < cols; j++)
      dlsi_triplets_add(t, i, j, take_double(&p));
  return DLS_OK;
}

dls_status dlsi_petsc_vector(const dlsi_bytes *file, dlsi_table *t, dls_error *error) {
  petsc_reader p = petsc_begin(file);
  if (take_whole(&p) != petsc_vector) return petsc_wrong("is a sparse matrix", error);
  t->rows = take_whole(&p);
  t->cols = 1;
  if (t->rows < 1 || (file->size - p.at) / 8 != (size_t)t->rows || (file->size - p.at) % 8)
    return petsc_wrong(wrong_size, error);
  t->a = dlsi_alloc((size_t)t->rows, sizeof *t->a);
  if (!t->a) return dlsi_no_memory(error);
  for (int i = 0; i < t->rows; i++)
    t->a[i] = take_double(&p);
  return DLS_OK;
}
