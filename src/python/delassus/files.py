"""Reads the matrices that other codes have written, by libdelassus-files."""

from __future__ import annotations

import ctypes
import os
from ctypes import POINTER, byref, c_char_p, c_int, c_void_p
from typing import Any

import numpy as np

from ._library import error_of, find_library, read, structs

_NAME = "libdelassus-files.so.0"
_library: Any = None


def _files() -> Any:
    global _library
    if _library is None:
        library = find_library(_NAME, "DELASSUS_FILES_LIBRARY")
        library.dls_matrix_read.argtypes = [c_char_p, c_int, c_void_p, c_void_p,
                                            POINTER(POINTER(c_int)), c_void_p]
        library.dls_matrix_free_labels.argtypes = [POINTER(c_int)]
        library.dls_mtx_free_sparse.argtypes = [c_void_p]
        library.dls_matrix_free_labels.restype = library.dls_mtx_free_sparse.restype = None
        _library = library
    return _library


def read_matrix(path: str | os.PathLike[str], triplets: bool = False, labels: bool = False) -> Any:
    """Returns the matrix in a file as scipy.sparse.csc_matrix: Matrix Market, .npy, .npz of SciPy,
    Abaqus, CalculiX, Harwell-Boeing, PETSc, FreeFEM, Octave, text; the program reads the same.

    triplets: lines of a text are row, column, value, from 0 if an index is 0, else from 1.
    labels: return (matrix, rows), rows[i] = (node, direction) of unknown i, or None."""
    import scipy.sparse

    library, A, symmetric = _files(), structs["dls_sparse"](), c_int()
    given, error = POINTER(c_int)(), structs["dls_error"]()
    if library.dls_matrix_read(os.fsencode(path), int(triplets), byref(A), byref(symmetric),
                               byref(given), byref(error)) < 0:
        raise error_of(error, file=os.fspath(path))
    try:
        p = read(c_int, A.p, A.cols + 1, None).copy()
        i = read(c_int, A.i, int(p[-1]), None).copy()
        x = read(ctypes.c_double, A.x, int(p[-1]), None).copy()
        matrix = scipy.sparse.csc_matrix((x, i, p), shape=(A.rows, A.cols))
        rows = np.ctypeslib.as_array(given, (A.rows, 2)).copy() if given else None
    finally:
        library.dls_mtx_free_sparse(byref(A))
        library.dls_matrix_free_labels(given)
    matrix.sum_duplicates()
    return (matrix, rows) if labels else matrix
