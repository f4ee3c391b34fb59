/*
 * delassus/files.h: contact problems as FCLIB files (HDF5; Acary et al., INRIA RT-0444), LCPs as
 * Matrix Market files. A library built without HDF5 answers DLS_E_UNSUPPORTED to the dls_fclib_
 * functions.
 *
 *   fclib_local   W, vectors/q, vectors/mu, spacedim            u = W r + q
 *   fclib_global  M, H, vectors/f, vectors/w, vectors/mu        M v = H r + f,  u = H^T v + w
 *   solution      v, r, u                                       (optional in both)
 *
 * HDF5 is as a rule built without locks: no two threads may be in the dls_fclib_ functions that read
 * or write a file, or elsewhere in HDF5, at once.
 */
#ifndef DELASSUS_FILES_H
#define DELASSUS_FILES_H

#include "delassus/contact.h"
#include "delassus/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A file's contents in memory; owns every array that the functions below hand out. */
typedef struct dls_fclib dls_fclib;

/* *out = the problem in file `path`, NULL on error. DLS_E_FILE: cannot be opened. DLS_E_FORMAT: not
 * HDF5, a group or data set is missing or of the wrong size, indices out of range, a value is not
 * finite; the message names the data set. DLS_E_UNSUPPORTED: bilateral constraints (V, R, G). Of a
 * file that holds both problems the local one is read. HDF5's error handler is left as it was. */
DLS_API DLS_MUST_USE dls_status dls_fclib_read(dls_fclib **out, const char *path, dls_error *error);

/* 1 if the file holds a global problem, 0 if a local one. */
DLS_API int dls_fclib_is_global(const dls_fclib *file);

/* "title" of the info group, "" if there is none. Lives as long as file. */
DLS_API const char *dls_fclib_title(const dls_fclib *file);

/* Local: *problem := W (by blocks), q, mu. DLS_E_ARGUMENT if the file is global. */
DLS_API DLS_MUST_USE dls_status dls_fclib_contact(const dls_fclib *file, dls_contact *problem,
                                                  dls_error *error);

/* Global: *model := M as a sparse stiffness (DLS_LU), H split into H_N, H_T; *f (n), *g (d nc, the
 * file's w), *mu (nc). DLS_E_ARGUMENT if the file is local. */
DLS_API DLS_MUST_USE dls_status dls_fclib_model(const dls_fclib *file, dls_model *model,
                                                const double **f, const double **g,
                                                const double **mu, dls_error *error);

/* *r, *u (m each) := the solution stored in the file, NULL if there is none. */
DLS_API DLS_MUST_USE dls_status dls_fclib_solution(const dls_fclib *file, const double **r,
                                                   const double **u, dls_error *error);

/* NULL is fine. */
DLS_API void dls_fclib_destroy(dls_fclib *file);

/* Write `path` anew. title "" or NULL for none; r and u (m) both NULL for no solution group. A
 * failed write leaves no file behind; bad input leaves an old one alone. The file is built in memory
 * first (once its size). The same problem gives the same bytes; read back, it has the same numbers,
 * but entries equal to 0 of a dense W or K are left out (so -0.0 is 0 there) and blocks of the
 * same place are one block. */
DLS_API DLS_MUST_USE dls_status dls_fclib_write_local(const char *path, const dls_contact *problem,
                                                      const char *title, const double *r,
                                                      const double *u, dls_error *error);

/* The same for a global problem: dense or sparse K of the model (DLS_CHOLESKY, DLS_LDLT: its
 * lower triangle, mirrored), no weighting P, no candidate left out, else DLS_E_UNSUPPORTED; f (n),
 * g (d nc), mu (nc); x (n, or NULL) as v. */
DLS_API DLS_MUST_USE dls_status dls_fclib_write_global(const char *path, const dls_model *model,
                                                       const double *f, const double *g,
                                                       const double *mu, const char *title,
                                                       const double *x, const double *r,
                                                       const double *u, dls_error *error);

/* A real Matrix Market file, array or coordinate, general, symmetric or skew-symmetric, as a dense
 * matrix: *a is a new array of *rows * *cols doubles, column-major, to be given to dls_mtx_free; NULL
 * on error. Entries of the same place add up. The host's locale does not matter. DLS_E_FILE,
 * DLS_E_FORMAT (index = line, from 1; NaN and Inf too), DLS_E_UNSUPPORTED (complex, pattern),
 * DLS_E_SIZE, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_mtx_read(const char *path, int *rows, int *cols, double **a,
                                             dls_error *error);
DLS_API void dls_mtx_free(double *a);

/* Writes a dense matrix (array, general, 17 digits: the same bits when read back). A failed write
 * leaves no file behind. */
DLS_API DLS_MUST_USE dls_status dls_mtx_write(const char *path, const dls_dense *A,
                                              dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
