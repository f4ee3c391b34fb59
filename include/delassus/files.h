/*
 * delassus/files.h: reads and writes contact problems as FCLIB files (HDF5; Acary et al., INRIA
 * RT-0444) and dense matrices as Matrix Market files; reads matrices in the formats of
 * other codes and small problems from text. The guide, "Files", describes them.
 *
 * These functions are in a library of their own, libdelassus-files: link -ldelassus-files
 * -ldelassus (pkg-config delassus-files). Without HDF5 the dls_fclib_ functions return
 * DLS_E_UNSUPPORTED.
 *
 *   fclib_local   W, vectors/q, vectors/mu, spacedim            u = W r + q
 *   fclib_global  M, H, vectors/f, vectors/w, vectors/mu        M v = H r + f,  u = H^T v + w
 *                 G, vectors/b (optional: joints)               + G l,  G^T v + b = 0
 *   solution      v, r, u                                       (optional in both)
 *
 * HDF5 usually has no locks. The dls_fclib_ functions let one thread at a time in; a host that
 * calls HDF5 itself must not do so at the same time.
 */
#ifndef DELASSUS_FILES_H
#define DELASSUS_FILES_H

#include "delassus/contact.h"
#include "delassus/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The contents of a file in memory; owns the arrays that the functions below return. */
typedef struct dls_fclib dls_fclib;

/* Reads the problem in file `path` into a new *out, NULL on error. DLS_E_FILE: cannot be opened.
 * DLS_E_FORMAT: not HDF5, a group or data set is missing or of the wrong size, indices out of
 * range, a value is not finite; the message names the data set. DLS_E_UNSUPPORTED: bilateral
 * constraints of a local problem (V, R). Of a file that holds both problems the local one is read.
 * HDF5's error handler is left as it was. */
DLS_API DLS_MUST_USE dls_status dls_fclib_read(dls_fclib **out, const char *path, dls_error *error);

/* Returns 1 if the file holds a global problem, 0 if a local one. */
DLS_API int dls_fclib_is_global(const dls_fclib *file);

/* Returns "title" of the info group, "" if there is none. Lives as long as file. */
DLS_API const char *dls_fclib_title(const dls_fclib *file);

/* Returns a local problem: W (by blocks), q, mu. DLS_E_ARGUMENT if the problem is global. */
DLS_API DLS_MUST_USE dls_status dls_fclib_contact(const dls_fclib *file, dls_contact *problem,
                                                  dls_error *error);

/* Returns a global problem: M as a sparse stiffness (DLS_LU) and H, split into H_N and H_T, in
 * *model; *f: n, *g: the w of the file, d nc, *mu: nc. With joints the unknowns are v, then the
 * multipliers l; K = (M -G; -G^T 0), and *f is f, then b.
 * DLS_E_ARGUMENT if the problem is local. */
DLS_API DLS_MUST_USE dls_status dls_fclib_model(const dls_fclib *file, dls_model *model,
                                                const double **f, const double **g,
                                                const double **mu, dls_error *error);

/* Returns a global problem of rigid bodies as one of bodies: M has blocks of 3 (d - 1) rows, each
 * symmetric and positive definite, no joint, and no candidate moves more than two of them; q is w +
 * H^T M^-1 f. The v of the file is M^-1 (H r + f). DLS_E_UNSUPPORTED for another problem: use
 * dls_fclib_model. DLS_E_ARGUMENT if the problem is local. */
DLS_API DLS_MUST_USE dls_status dls_fclib_bodies(const dls_fclib *file, dls_contact *problem,
                                                 dls_error *error);

/* Returns the solution that the file holds. *r, *u: m each, NULL if there is none. */
DLS_API DLS_MUST_USE dls_status dls_fclib_solution(const dls_fclib *file, const double **r,
                                                   const double **u, dls_error *error);

/* Frees the contents and all their arrays; NULL is fine. */
DLS_API void dls_fclib_destroy(dls_fclib *file);

/* Writes a local problem to `path` and replaces an old file. title: "" or NULL for none. r, u: m
 * each, both NULL for no solution group. After an error the old file is unchanged: the new one is
 * written beside it, brought to the disk and renamed; a link stays a link. The file is built in
 * memory first (once its size). Equal problems give equal bytes, and numbers read back are those
 * that were written. Zeros of a dense W or K are left out (-0.0 becomes 0), and blocks of the same
 * place become one. */
DLS_API DLS_MUST_USE dls_status dls_fclib_write_local(const char *path, const dls_contact *problem,
                                                      const char *title, const double *r,
                                                      const double *u, dls_error *error);

/* Writes a global problem as dls_fclib_write_local writes a local one: dense or sparse K of the
 * model (DLS_CHOLESKY, DLS_LDLT: its lower triangle, mirrored) and H; DLS_E_UNSUPPORTED for a
 * weighting P, an array `active`, or another operator. f: n, g: d nc, mu: nc, x: n or NULL, goes
 * to the file's v. Multipliers among the unknowns (model.h), where they have no diagonal block and
 * K is symmetric there, become the file's G, b and l: read back, they come after the positions. */
DLS_API DLS_MUST_USE dls_status dls_fclib_write_global(const char *path, const dls_model *model,
                                                       const double *f, const double *g,
                                                       const double *mu, const char *title,
                                                       const double *x, const double *r,
                                                       const double *u, dls_error *error);

/* Reads a real Matrix Market file, array or coordinate, general, symmetric or skew-symmetric, as a
 * dense matrix. *a: new array of *rows * *cols doubles, column-major, which dls_mtx_free frees;
 * NULL on error. Entries of the same place add up. The host's locale does not matter. DLS_E_FILE,
 * DLS_E_FORMAT (index = line, from 1; NaN and Inf too), DLS_E_UNSUPPORTED (complex, pattern),
 * DLS_E_SIZE, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_mtx_read(const char *path, int *rows, int *cols, double **a,
                                             dls_error *error);
DLS_API void dls_mtx_free(double *a);

/* Reads a matrix in any format that the guide ("Files") lists, as compressed columns: a
 * symmetric one with both triangles, a dense one without its zeros. The three arrays of *A are new;
 * dls_mtx_free_sparse frees them. The name counts for CalculiX alone (.sti, .mas: the upper
 * triangle), the first bytes for the others.
 * triplets: 1 if a text holds lines "row column value", counted from 0 if an index is 0, else from
 * 1; 0 if it is a dense table. *symmetric (or NULL) := 1 if the file says that it is, or holds one
 * triangle of labels. *labels (or NULL) := new array of (node, direction) for each row where the
 * file has them (Abaqus), else NULL; dls_matrix_free_labels frees it. Outputs are untouched on
 * error. Errors of dls_mtx_read; DLS_E_UNSUPPORTED for a format that is recognised and not
 * read: the message says what to do. */
DLS_API DLS_MUST_USE dls_status dls_matrix_read(const char *path, int triplets, dls_sparse *A,
                                                int *symmetric, int **labels, dls_error *error);

/* Frees labels that dls_matrix_read has returned; NULL is fine. */
DLS_API void dls_matrix_free_labels(int *labels);

/* Frees the arrays of a matrix that was read and sets it to zero; NULL is fine. */
DLS_API void dls_mtx_free_sparse(dls_sparse *A);

/* Writes a dense matrix (array, general, 17 digits, which read back to the same bits). After any
 * error an old file is as it was. */
DLS_API DLS_MUST_USE dls_status dls_mtx_write(const char *path, const dls_dense *A,
                                              dls_error *error);

/* Writes as dls_mtx_write does, with `comment`, a line, below the banner; NULL or "": none.
 * DLS_E_ARGUMENT for a comment of several lines. */
DLS_API DLS_MUST_USE dls_status dls_mtx_write_commented(const char *path, const dls_dense *A,
                                                        const char *comment, dls_error *error);

/* A small problem in text, in memory; owns all that the functions below return. A line is a key
 * and its text; # begins a comment line. The lines of a contact problem and of an LCP:
 *
 *   contact d nc      lcp n
 *   W                 M       the m (n) lines that follow are its rows
 *   q    m numbers    q       n numbers, decimals or fractions p/q
 *   mu   nc numbers
 *
 * in any order after the first. Lines with other keys, such as `solution`, are kept as they
 * are. */
typedef struct dls_text dls_text;

/* Reads the problem in file `path` into a new *out, NULL on error. DLS_E_FILE, DLS_E_FORMAT (index
 * = line, from 1; -1: something is missing), DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_text_read(dls_text **out, const char *path, dls_error *error);

/* Returns 1 if the file holds an LCP, 0 if a contact problem. */
DLS_API int dls_text_is_lcp(const dls_text *text);

/* Returns the text of the first line `title`, "" if there is none. */
DLS_API const char *dls_text_title(const dls_text *text);

/* Return the problem; of an LCP n, M (n x n, column-major) and q (n). DLS_E_ARGUMENT if it is of
 * the other kind. */
DLS_API DLS_MUST_USE dls_status dls_text_contact(const dls_text *text, dls_contact *problem,
                                                 dls_error *error);
DLS_API DLS_MUST_USE dls_status dls_text_lcp(const dls_text *text, int *n, const double **M,
                                             const double **q, dls_error *error);

/* Frees the problem; NULL is fine. */
DLS_API void dls_text_destroy(dls_text *text);

#ifdef __cplusplus
}
#endif

#endif
