"""Bodies that move: the theta scheme with contact and friction, and paths of equilibria."""

from __future__ import annotations

from ctypes import byref, c_double, c_int, c_void_p
from typing import Any

import numpy as np
import numpy.typing as npt

from ._library import (Array, Matrix, Owner, Vector, address, call, columns, constants, lib, number, one_of, read, set_fields,
                       sparse, structs, vector)
from .contact import Solution, Watch, name_states, find_method, set_limits
from .reduction import check_tangents, find_factorization, operators

_LAWS = {"velocity": "DLS_MOTION_VELOCITY", "gap": "DLS_MOTION_GAP", "path": "DLS_MOTION_PATH"}


class Motion(Owner):
    """Bodies M v' + C v + K x = f + H p/h with contact (delassus/motion.h).

    Motion(K, HN, HT, M=M, h=1e-3)           impacts; restitution, activation, theta,
                                             energy_consistent: see motion.h
    Motion(K, HN, HT, M=M, h=h, law="gap", theta=1)
    Motion(K, HN, HT, law="path")            equilibria, one after the other

    step(f, y, mu) takes a step and returns the Solution of its contact problem, or None if no
    contact took part. On a path that is solved on K its u is (gap, slip of the step). The state after the last certified step: t, steps, x, v (n), p, u
    (candidates x d), gap, slip, states.
    """

    def __init__(self, K: Matrix | None, HN: Matrix, HT: Matrix | None = None, *,
                 M: Matrix | None = None, C: Matrix | None = None, P: Matrix | None = None,
                 gap: Array | None = None, h: float = 1.0, law: str = "velocity",
                 method: str = "auto", factorization: str | None = None, tol: float | None = None,
                 max_iterations: int | None = None, d: int | None = None,
                 theta: float | None = None, restitution: float | None = None,
                 activation: float | None = None, forecast: float | None = None,
                 energy_consistent: bool = False) -> None:
        self._held = c_void_p()
        # copies: the library goes on reading them
        copies: list[Any] = [
            None if A is None else columns(name, A).copy()
            for name, A in (("M", M), ("C", C), ("K", K), ("P", P), ("HN", HN), ("HT", HT))]
        self.d, N, T = operators(copies[4], copies[5], d)
        self._has_tangents = HT is not None
        self.n: int = N.shape[0]
        if factorization is None:
            given = [A for A in copies[:3] if A is not None]
            kinds = {find_factorization(None, A) for A in given}
            kind = constants["DLS_LU" if constants["DLS_LU"] in kinds else "DLS_CHOLESKY"]
        else:
            kind = find_factorization(factorization, copies[2])
        if law not in _LAWS:
            raise one_of("law", law, _LAWS)
        self._law = law
        self._nodes: int = N.shape[1]
        self._candidates: int = self._nodes if P is None else copies[3].shape[1]
        gap = None if gap is None else vector("gap", gap, self._nodes).copy()
        model = structs["dls_motion_model"](
            d=self.d, n=self.n, nodes=self._nodes, factorization=kind, HN=sparse(N), HT=sparse(T),
            gap=address(gap), **{name: sparse(A) for name, A in zip("MCKP", copies)})
        self._kept = (*copies[:4], N, T, gap)
        create = structs["dls_motion_settings"]()
        lib.dls_motion_settings_init(byref(create))
        create.law, create.method = constants[_LAWS[law]], find_method(method)
        create.h = number("h", h)
        self._watch = Watch()
        set_limits(create.limits, self._watch, tol, max_iterations)
        set_fields(create, {"theta": theta, "restitution": restitution, "activation": activation,
                            "forecast": forecast, "energy_consistent": int(energy_consistent)})
        call("dls_motion_create", byref(self._held), byref(model), byref(create))

    def __del__(self) -> None:
        if getattr(self, "_held", None):
            lib.dls_motion_destroy(self._held)

    def __repr__(self) -> str:
        return (f"<Motion: law {self._law}, {self.d}D, {self._candidates} candidates, {self.n} unknowns, "
                f"{self.steps} steps, t = {self.t:g}>")

    def start(self, x: Array | None = None, v: Array | None = None, t: float = 0.0) -> None:
        """Restarts from x and v at time t."""
        x = None if x is None else vector("x", x, self.n)
        v = None if v is None else vector("v", v, self.n)
        call("dls_motion_start", self._held, address(x), address(v), number("t", t))

    def step(self, f: Array | None = None, y: Array | None = None,
             mu: Array | None = None) -> Solution | None:
        """Takes a step under loads f (n), velocities y of the obstacle (nodes x d), friction mu."""
        f = None if f is None else vector("f", f, self.n)
        y = None if y is None else vector("y", y, self.d * self._nodes, self.d)
        check_tangents(self._has_tangents or None, mu)
        mu = None if mu is None else vector("mu", mu, self._candidates)
        info, problem = structs["dls_info"](), structs["dls_contact"]()
        status = self._watch.call("dls_motion_step", self._held, address(f), address(y),
                                  address(mu), byref(info))
        call("dls_motion_get_problem", self._held, byref(problem))
        if status:
            raise NotCertified(status)
        state = self._state()
        if not state.active:
            return None
        active = read(c_int, state.active_list, state.active, self)
        if not problem.nc:  # solved on K
            u = self.u[active]
            u[:, 0] = self.gap[active]
            solution = Solution(problem, info, status, np.empty(0), np.empty(0), None)
            solution.r, solution.u, solution.states = self.p[active], u, self.states[active]
            solution.x = self.x
            return solution
        r, u = self.p[active].reshape(-1), np.zeros(self.d * problem.nc)
        call("dls_contact_certify", byref(problem), address(r), address(u),
             byref(structs["dls_certificate"]()))
        solution = Solution(problem, info, status, r, u, None)
        solution.x = self.x
        return solution

    def set_h(self, h: float) -> None:
        """Changes the step size from the next step on."""
        call("dls_motion_set_h", self._held, number("h", h))

    def _state(self) -> Any:
        state = structs["dls_motion_state"]()
        call("dls_motion_get_state", self._held, byref(state))
        return state

    def _array(self, name: str, kind: Any, size: int) -> npt.NDArray[Any]:
        return read(kind, getattr(self._state(), name), size, self).copy()

    @property
    def t(self) -> float:
        return float(self._state().t)

    @property
    def steps(self) -> int:
        return int(self._state().steps)

    @property
    def x(self) -> Vector:
        return self._array("x", c_double, self.n)

    @property
    def v(self) -> Vector:
        return self._array("v", c_double, self.n)

    @property
    def p(self) -> Vector:
        return self._local("p")

    @property
    def u(self) -> Vector:
        return self._local("u")

    @property
    def gap(self) -> Vector:
        return self._array("gap", c_double, self._candidates)

    def _local(self, name: str) -> Vector:
        return self._array(name, c_double, self.d * self._candidates).reshape(-1, self.d)

    @property
    def slip(self) -> Vector:
        tangents = self.d - 1
        return self._array("slip", c_double, tangents * self._candidates).reshape(-1, tangents)

    @property
    def states(self) -> npt.NDArray[np.str_]:
        return name_states(self._array("state", c_int, self._candidates), self._has_tangents)

    @property
    def energies(self) -> dict[str, float]:
        """Energies and works since the start, by the names of dls_motion_energies."""
        energies = structs["dls_motion_energies"]()
        call("dls_motion_get_energies", self._held, byref(energies))
        return {name: getattr(energies, name) for name, _ in energies._fields_}


class NotCertified(RuntimeError):
    """A step whose contact problem was not solved: the state is that of the last step."""

    status: int

    def __init__(self, status: int) -> None:
        super().__init__(status)
        self.status = status

    def __str__(self) -> str:
        words: str = lib.dls_status_text(self.status).decode()
        return f"the contact problem of the step: {words}"
