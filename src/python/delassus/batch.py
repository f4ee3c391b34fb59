"""Many small contact problems in one call."""

from __future__ import annotations

from ctypes import byref, sizeof
from typing import Any, Iterator, Sequence

import numpy as np
import numpy.typing as npt

from ._library import Vector, address, call, constants, number, reals, structs, whole
from .contact import Solution, _dimension, _problem, solver_settings


class Batch(Sequence[Solution]):
    """The outcome of solve_many: batch[k] is the Solution of problem k.

    r, u        reactions and local positions: count x nc x d, or a list where sizes differ
    solved      True for each problem that is certified to tol
    status, residual, iterations   one for each problem, as of a Solution
    """

    def __init__(self, problems: Any, info: Any, r: Any, u: Any, sources: Any, kept: Any) -> None:
        self.r, self.u = r, u
        self._problems, self._info, self._sources, self._kept = problems, info, sources, kept
        kind, inner = structs["dls_info"], structs["dls_certificate"]

        def column(offset: int, dtype: Any) -> npt.NDArray[Any]:
            if not len(info):
                return np.zeros(0, dtype)
            view: npt.NDArray[Any] = np.ndarray((len(info),), dtype, info, offset, (sizeof(kind),))
            return view.copy()

        self.status = column(kind.status.offset, np.intc)
        self.iterations = column(kind.iterations.offset, np.intc)
        self.residual = column(kind.certificate.offset + inner.residual.offset, np.float64)
        self.solved = np.isin(self.status, [constants["DLS_OK"], constants["DLS_TO_ROUNDING"]])

    def __len__(self) -> int:
        return len(self._problems)

    def __getitem__(self, k: Any) -> Any:
        if isinstance(k, slice):
            return [self[i] for i in range(*k.indices(len(self)))]
        k = range(len(self))[k]
        solution = Solution(self._problems[k], self._info[k], int(self.status[k]),
                            self.r[k].reshape(-1).copy(), self.u[k].reshape(-1).copy(), None)
        solution._source = self._sources(k)
        return solution

    def __iter__(self) -> Iterator[Solution]:
        return (self[k] for k in range(len(self)))

    def __repr__(self) -> str:
        return f"<{int(self.solved.sum())} of {len(self)} problems solved>"


def _run(problems: Any, r: Any, u: Any, settings: Any) -> Any:
    """Solves; r, u: addresses for each problem."""
    info = (structs["dls_info"] * len(problems))()
    call("dls_solve_batch", len(problems), problems, byref(settings), address(r), address(u), info)
    return info


def _stack(W: Vector, q: Any, mu: Any, d: Any, settings: Any) -> Batch:
    """Solves problems of equal sizes: one array for each of W, q, mu."""
    q, mu = reals("q", q), reals("mu", mu)
    count = W.shape[0]
    if W.ndim != 3 or W.shape[1] != W.shape[2] or q.ndim not in (2, 3) or len(q) != count:
        raise ValueError(f"W is {W.shape}, q {q.shape}: wanted are count x m x m and count x m (or "
                         "count x nc x d)")
    m = W.shape[1]
    each = q.reshape(count, m) if q.size == count * m else q
    if each.shape != (count, m):
        raise ValueError(f"q is {q.shape}, W {W.shape}")
    d = _dimension(W, q[0] if count else np.zeros(q.shape[1:]), mu[0] if mu.ndim == 2 else mu, d)
    if m % d:
        raise ValueError(f"W has {m} rows, which d = {d} does not divide")
    nc = m // d
    if mu.shape not in ((), (nc,), (count, nc)):
        raise ValueError(f"mu is {mu.shape}, needs {(count, nc)}, {(nc,)} or one number")
    W = np.ascontiguousarray(W.transpose(0, 2, 1))  # columns
    each = np.ascontiguousarray(each)
    frictions = np.ascontiguousarray(np.broadcast_to(mu, (count, nc)))
    if d == 1 and frictions.any():
        raise ValueError("mu must be 0 where d = 1")
    kind, view = structs["dls_contact"], structs["dls_dense"]
    problems = (kind * count)()
    one = kind(d=d, nc=nc, W=view(m, m, max(1, m), None))
    rows = np.ndarray((count, sizeof(kind)), np.uint8, problems) if count else np.zeros((0, 1))
    rows[:] = np.frombuffer(one, np.uint8) if count else 0

    def places(a: Any, size: int) -> npt.NDArray[Any]:
        return np.asarray(a.ctypes.data + 8 * size * np.arange(count), np.uintp)

    for offset, a, size in ((kind.W.offset + view.a.offset, W, m * m), (kind.q.offset, each, m),
                            (kind.mu.offset, frictions, nc)):
        if count:
            np.ndarray((count,), np.uintp, problems, offset, (sizeof(kind),))[:] = places(a, size)
    r, u = np.zeros((count, nc, d)), np.zeros((count, nc, d))
    info = _run(problems, places(r, m), places(u, m), settings)
    return Batch(problems, info, r, u, lambda k: (W[k].T, each[k], frictions[k], d),
                 (W, each, frictions))


def _list(W: Sequence[Any], q: Sequence[Any], mu: Any, d: Any, settings: Any) -> Batch:
    """Solves problems of any sizes and kinds of W."""
    count = len(W)
    frictions = list(mu) if np.iterable(mu) else [mu] * count
    if len(q) != count or len(frictions) != count:
        raise ValueError(f"{count} of W, {len(q)} of q, {len(frictions)} of mu")
    made = []
    for k in range(count):
        try:
            made.append(_problem(W[k], q[k], frictions[k], d))
        except ValueError as wrong:
            raise ValueError(f"problem {k}: {wrong}") from None
    problems = (structs["dls_contact"] * count)(*(p for p, _ in made))
    shapes = [(p.nc, p.d) for p, _ in made]
    r, u = [np.zeros(shape) for shape in shapes], [np.zeros(shape) for shape in shapes]
    at = [np.array([a.ctypes.data for a in arrays], np.uintp) for arrays in (r, u)]
    info = _run(problems, at[0], at[1], settings)
    return Batch(problems, info, r, u, lambda k: (W[k], q[k], frictions[k], d), made)


def solve_many(W: Any, q: Any, mu: Any, d: int | None = None, *, method: str = "auto",
               tol: float | None = None, max_iterations: int | None = None,
               acceleration: str | None = None, facets: int | None = None,
               positive_definite: int | None = None, plan: str | None = None,
               without: str | None = None, forces: str = "any") -> Batch:
    """Solves many problems u = W r + q in one call (dls_solve_batch); returns a Batch.

    W    count x m x m, and q count x m or count x nc x d, mu count x nc, nc or one number: problems
         of equal sizes, without a loop of Python. Or lists of W, q and mu (or one mu), each as in
         solve(): sizes may differ, W may be sparse or of rigid bodies

    Small problems of equal sizes that follow each other are solved eight at a time, by method auto
    without max_iterations, plan and forces. Answers do not depend on the other problems. Options as
    in solve(). Ctrl-C waits for the end of the call. Threads may run solve_many at once.
    """
    settings, words = solver_settings(method, acceleration, facets, positive_definite, plan,
                                      without, forces)
    if tol is not None:
        settings.limits.tol = number("tol", tol)
    if max_iterations is not None:
        settings.limits.max_iterations = whole("max_iterations", max_iterations)
    if isinstance(W, (list, tuple)):
        batch = _list(W, q, mu, d, settings)
    else:
        batch = _stack(reals("W", W), q, mu, d, settings)
    del words
    return batch
