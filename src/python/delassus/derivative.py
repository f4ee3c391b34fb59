"""Derivatives of a solution: of any loss (vjp), in any direction (jvp)."""

from __future__ import annotations

from ctypes import byref, c_void_p
from typing import Any, NamedTuple, Tuple, Union

import numpy as np
import scipy.sparse as sp

from ._library import (Array, Matrix, Owner, Vector, address, call, columns, gaps, lib, reals,
                       structs, vector)

# a change of W: a matrix, or of H of rigid bodies
Change = Union[Matrix, Array]


class Gradient:
    """dL/d(data) of a loss L; what does not belong to the problem is None.

    mu   one for each contact
    q    nc x d, and
    W    m x m, q r^T: of a sparse W at its entries; of rigid bodies dL/dH, as H
    f    n, g nodes x d, and
    K    n x n, -f x^T: of a sparse K at its entries. Entries count one by one: of a symmetric K
         the gradient is right for symmetric changes
    """

    def __init__(self, mu: Vector, q: Vector | None, f: Vector | None, g: Vector | None,
                 left: Vector, right: Vector, pattern: Any) -> None:
        self.mu, self.q, self.f, self.g = mu, q, f, g
        self._outer = left, right, pattern

    def _matrix(self) -> Any:
        left, right, pattern = self._outer
        if isinstance(pattern, np.ndarray):  # dL/dH
            return pattern
        if pattern is None:
            return np.outer(left, right)
        G = sp.csc_matrix(pattern, copy=True)
        G.data = left[G.indices] * np.repeat(right, np.diff(G.indptr))
        return G

    @property
    def W(self) -> Any:
        return None if self.q is None else self._matrix()

    @property
    def K(self) -> Any:
        return None if self.f is None else self._matrix()


class Moved(NamedTuple):
    """The change of a solution: r and u, nc x d, and x, n, of a body."""

    r: Vector
    u: Vector
    x: Vector | None


class Derivative(Owner):
    """A dls_derive and the arrays that it views."""

    def __init__(self, name: str, *arguments: Any, d: int, nc: int, r: Vector, matrix: Any,
                 kept: Any, x: Vector | None = None, nodes: Tuple[int, ...] = ()) -> None:
        self._held = c_void_p()
        self._kept = kept
        self._d, self._nc, self._r, self._x, self._nodes = d, nc, r.copy(), x, nodes
        self._matrix = matrix  # W or K as given; (body, H)
        call(name, byref(self._held), *arguments)

    def __del__(self) -> None:
        if getattr(self, "_held", None):
            lib.dls_derive_destroy(self._held)

    def _given(self, name: str, a: Any, size: int, width: int = 1) -> Any:
        return None if a is None else vector(name, a, size, width)

    def vjp(self, r: Any, u: Any, x: Any) -> Gradient:
        d, nc, m = self._d, self._nc, self._d * self._nc
        if x is not None and self._x is None:
            raise ValueError("x is of a body: this solution has none")
        gr, gu = self._given("r", r, m, d), self._given("u", u, m, d)
        gx = None if self._x is None else self._given("x", x, self._x.size)
        loss = structs["dls_derive_answer"](*map(address, (gr, gu, gx)))
        mu, q, H, f, g = np.zeros(nc), None, None, None, None
        if self._x is None:
            q = np.zeros((nc, d))
            H = np.zeros_like(self._matrix[1]) if isinstance(self._matrix, tuple) else None
        else:
            f, g = np.zeros(self._x.size), np.zeros(self._nodes)
        data = structs["dls_derive_data"](mu=address(mu), q=address(q), W=address(H),
                                          f=address(f), g=address(g))
        call("dls_derive_vjp", self._held, byref(loss), byref(data))
        sparse = self._matrix if hasattr(self._matrix, "tocsc") else None
        if q is not None:
            return Gradient(mu, q, None, None, q.reshape(-1), self._r.reshape(-1),
                            sparse if H is None else H)
        assert f is not None and g is not None and self._x is not None
        return Gradient(mu, None, f, g[:, :d], -f, self._x, sparse)

    def jvp(self, q: Any, mu: Any, W: Any, f: Any, g: Any, K: Any) -> Moved:
        d, nc, m, x = self._d, self._nc, self._d * self._nc, self._x
        for name, a in (("q", q), ("W", W)) if x is not None else (("f", f), ("g", g), ("K", K)):
            if a is not None:
                raise ValueError(f"{name} is no part of the data of this problem")
        n = 0 if x is None else x.size
        dq, df = self._given("q", q, m, d), self._given("f", f, n)
        H: Any = None
        if W is not None and isinstance(self._matrix, tuple):
            H = self._given("W", W, self._matrix[1].size, self._matrix[1].shape[-1])
        elif W is not None:  # a change of W moves as q = dW r does, one of K as f = -dK x
            dq = (0 if dq is None else dq) + _times("W", W, self._r.reshape(-1))
        if K is not None:
            assert x is not None
            df = (0 if df is None else df) - _times("K", K, x)
        dmu = self._given("mu", mu, nc)
        dg = None if g is None else gaps("g", g, self._nodes[0], d, self._nodes[1])
        data = structs["dls_derive_data"](mu=address(dmu), q=address(dq), W=address(H),
                                          f=address(df), g=address(dg))
        moved = Moved(np.zeros((nc, d)), np.zeros((nc, d)), None if x is None else np.zeros(n))
        answer = structs["dls_derive_answer"](*map(address, moved))
        call("dls_derive_jvp", self._held, byref(data), byref(answer))
        return moved


def _times(name: str, A: Any, x: Vector) -> Vector:
    A = columns(name, A) if hasattr(A, "tocsc") else reals(name, A)
    if A.shape != (x.size, x.size):
        raise ValueError(f"{name} is {A.shape}, needs {(x.size, x.size)}")
    return np.asarray(A @ x, dtype=np.float64)
