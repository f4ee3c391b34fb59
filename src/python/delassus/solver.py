"""Contact problems of one step after the other, whose contacts appear and vanish."""

from __future__ import annotations

from ctypes import byref, c_void_p
from typing import Any

import numpy as np
import numpy.typing as npt

from ._library import Array, Owner, address, call, integers, lib, structs, whole
from .contact import Operator, Solution, Watch, _problem, set_limits, solver_settings


class Solver(Owner):
    """Solves a problem in each step and starts from the step before (dls_solver, dls_solver_map).

    nc      the most contacts of a step
    d       1, 2 or 3
    blocks  the most d x d blocks of a sparse W; 0: W is dense. Of rigid bodies also the blocks that
            they would make
    Options as in solve().

    solve(W, q, mu, contacts) starts from the reactions, the order of sweeps and, where they still
    fit, the factors of the last step. contacts names the contacts by integers of yours: those of
    the last step are found again under their new places, others are new. None: contact k is contact
    k of the last step.
    """

    def __init__(self, nc: int, d: int, *, blocks: int = 0, method: str = "auto",
                 tol: float | None = None, max_iterations: int | None = None,
                 cpu_seconds: float | None = None, acceleration: str | None = None,
                 facets: int | None = None, positive_definite: int | None = None,
                 threads: int | None = None, plan: str | None = None, without: str | None = None,
                 forces: str = "any") -> None:
        self._held = c_void_p()
        self._names: npt.NDArray[Any] = np.zeros(0, np.int64)
        self._limits = (tol, max_iterations, cpu_seconds, threads)
        settings, words = solver_settings(method, acceleration, facets, positive_definite, plan,
                                          without, forces)
        settings.limits.blocks = whole("blocks", blocks)
        settings.limits.warm_start = 1
        watch = Watch()
        set_limits(settings.limits, watch, *self._limits)
        call("dls_solver_create", byref(self._held), whole("d", d), whole("nc", nc),
             byref(settings))
        watch.release()
        self._settings = settings
        del words

    def __del__(self) -> None:
        if getattr(self, "_held", None):
            lib.dls_solver_destroy(self._held)

    def solve(self, W: Operator, q: Array, mu: Array | None = None, contacts: Array | None = None,
              d: int | None = None) -> Solution:
        """Solves the problem of a step; arguments as in solve()."""
        problem, kept = _problem(W, q, mu, d)
        if contacts is None:
            names = np.arange(problem.nc)
        else:
            names = np.asarray(contacts)
            if names.shape != (problem.nc,) or (names.size and names.dtype.kind not in "iu"):
                raise ValueError(f"contacts is {names.shape} of {names.dtype}, needs "
                                 f"{problem.nc} integers")
        if np.unique(names).size != names.size:
            raise ValueError("contacts names a contact twice")
        before = {name: k for k, name in enumerate(self._names.tolist())}
        origin = integers("contacts", [before.get(name, -1) for name in names.tolist()])
        m = problem.d * problem.nc
        r, u = np.zeros(m), np.zeros(m)
        call("dls_solver_map", self._held, problem.nc, address(origin), address(r))
        watch = Watch()
        limits = self._settings.limits
        limits.progress = limits.progress_data = None
        set_limits(limits, watch, *self._limits)
        info = structs["dls_info"]()
        try:
            call("dls_solver_set_limits", self._held, byref(limits))
            status = watch.call("dls_solver_solve", self._held, byref(problem), address(r),
                                address(u), byref(info))
        finally:
            watch.release()
        self._names = names.copy()
        solution = Solution(problem, info, status, r, u, None)
        solution._source = W, q, mu, d
        del kept
        return solution
