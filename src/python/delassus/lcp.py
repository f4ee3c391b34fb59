"""The linear complementarity problem y = M z + q, y >= 0, z >= 0, y.z = 0."""

from __future__ import annotations

from ctypes import byref, c_void_p
from typing import Any, Callable

import numpy as np

from ._library import (Array, Matrix, Vector, address, call, columns, dense, lib, one_of, reals,
                       sparse, structs, vector)
from .contact import Progress, Watch, set_limits

_METHODS = {"lemke": "dls_lemke", "principal": "dls_principal"}


class LcpSolution:
    """The outcome of solve_lcp.

    z, y         the answer, and M z + q
    solved       True: certified to tol
    status, words   number (DLS_...) and words of the outcome; above 0, z is the best point found
    residual     |min(s z, y)| / |q|, s the diagonal of M (dls_lcp_certificate)
    certificate  the residual's parts by name
    iterations   pivots, or bases and steps of the path
    method       "lemke" or "principal"
    proof        v >= 0 with M^T v <= 0 and q.v < 0, exactly, where there is no solution; else None
    """

    def __init__(self, method: str, status: int, info: Any, z: Vector, y: Vector,
                 proof: Vector | None) -> None:
        self.method, self.status, self.z, self.y, self.proof = method, status, z, y, proof
        self.words: str = lib.dls_status_text(status).decode()
        self.solved = lib.dls_status_name(status).decode() == "DLS_OK"
        c = info.certificate
        self.certificate: dict[str, Any] = {name: getattr(c, name) for name, _ in c._fields_}
        self.residual: float = c.residual
        self.iterations: int = (info.pivots + info.crash_rounds if method == "lemke"
                                else info.iterations)

    def __repr__(self) -> str:
        return (f"<{self.words}: {self.z.size} unknowns, {self.method}, {self.iterations} "
                f"iterations, residual {self.residual:.1e}>")


def solve_lcp(M: Matrix, q: Array, *, method: str | None = None, z0: Array | None = None,
              tol: float | None = None, max_iterations: int | None = None,
              cpu_seconds: float | None = None,
              progress: Callable[[Progress], object] | None = None) -> LcpSolution:
    """Solves y = M z + q, y >= 0, z >= 0, y.z = 0; returns an LcpSolution.

    M        n x n: numpy or lists (dense), or scipy.sparse, of any size
    method   "lemke": any M, stored densely, finds proofs that there is no solution; "principal":
             P-matrices (symmetric positive definite, M-matrices, ..), a sparse M by sparse factors
             (delassus/pivoting.h says for which M it ends). None: principal for a sparse M, else
             lemke
    z0       a start
    tol, max_iterations, cpu_seconds, progress   as in solve()
    """
    is_sparse = hasattr(M, "tocsc")
    if method is None:
        method = "principal" if is_sparse else "lemke"
    if method not in _METHODS:
        raise one_of("method", method, _METHODS)
    given: Any = columns("M", M) if is_sparse else np.atleast_2d(reals("M", M))
    q = np.atleast_1d(reals("q", q))
    n = q.size
    if given.shape != (n, n):
        raise ValueError(f"M is {given.shape}, q has {n} entries")
    b = vector("q", q, n)
    lcp = structs["dls_lcp"](n=n, q=address(b))
    if is_sparse and method == "principal":
        lcp.Ms = sparse(given)
    else:
        given = np.asfortranarray(given.toarray() if is_sparse else given)
        lcp.M = dense(given)
    prefix = _METHODS[method]
    settings, info = structs[prefix + "_settings"](), structs[prefix + "_info"]()
    getattr(lib, prefix + "_settings_init")(byref(settings))
    watch = Watch(False, progress)
    set_limits(settings.limits, watch, tol, max_iterations, cpu_seconds)
    settings.limits.warm_start = z0 is not None
    settings.limits.blocks = max(given.nnz, 1) if lcp.Ms.p else 0
    z = np.zeros(n) if z0 is None else vector("z0", z0, n).copy()
    y, work, proof = np.zeros(n), c_void_p(), None
    try:
        call(prefix + "_create", byref(work), n, byref(settings))
        status = watch.call(prefix + "_solve", work, byref(lcp), address(z), address(y),
                            byref(info))
        if lib.dls_status_name(status).decode() == "DLS_NO_SOLUTION":
            proof = np.zeros(n)
            call("dls_lemke_farkas", work, address(proof))
    finally:
        getattr(lib, prefix + "_destroy")(work)
        watch.release()
    return LcpSolution(method, status, info, z, y, proof)
