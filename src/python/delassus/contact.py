"""The contact problem u = W r + q and its solution by any method of the library."""

from __future__ import annotations

import ctypes
import html
import itertools
import os
import threading
from ctypes import byref, c_int, c_size_t
from typing import Any, Callable, Dict, List, NamedTuple, Tuple, Union

import numpy as np
import numpy.typing as npt

from .derivative import Change, Derivative, Gradient, Moved
from .surface import Sum, Surface
from ._library import (Array, Callback, Matrix, Vector, address, call, columns, constants, dense,
                       entries, integers, lib, number, one_of, reals, structs, vector, whole)

STATES: npt.NDArray[np.str_] = np.array(["free", "slip", "stick"])


def name_states(numbers: npt.NDArray[Any], tangents: bool) -> npt.NDArray[np.str_]:
    """Returns the names of states; without tangents a contact is free or touches."""
    named: npt.NDArray[np.str_] = STATES[numbers]
    return named if tangents else np.where(named == "free", "free", "touch")


FORCES = ("any", "least")

# W: a matrix, or (body, H) of rigid bodies
Operator = Union[Matrix, Tuple[Array, Array]]


class Progress(NamedTuple):
    """The argument of a progress function."""

    method: str
    stage: str
    iteration: int
    max_iterations: int
    residual: float
    cpu_seconds: float
    last: bool


class Stage(NamedTuple):
    """A stage of auto."""

    method: str
    iterations: int
    factorisations: int
    residual: float
    step: str
    reason: str
    on_copy: bool
    ahead: float
    next: float
    cpu_seconds: float


class Certificate(NamedTuple):
    """dls_certificate of delassus/contact.h."""

    residual: float
    residual_u: float
    residual_r: float
    floor_u: float
    floor_r: float
    penetration: float
    adhesion: float
    cone_violation: float
    slip_direction: float
    complementarity: float
    worst: int
    equilibrium: float
    floor_e: float
    unbalanced: float
    body: int


def _certificate(c: Any) -> Certificate:
    return Certificate(*(getattr(c, name) for name in Certificate._fields))



class Proof(NamedTuple):
    """A proof of an answer by dls_contact_prove (delassus/trust.h).

    proved            "reactions": one solution within radius |improved|; "positions": u is proved
                      and `freedom` reactions are free; None: not proved
    radius, radius_u  bounds on the errors of `improved`, relative to it, and of its positions u,
                      relative to the largest |u| or |q|
    error             of r itself
    border            (contact, its state, the other state) if one is on the border of two, or None
    improved          r after Newton steps to rounding, nc x d
    """

    proved: str | None
    radius: float
    radius_u: float
    error: float
    freedom: int
    border: Tuple[int, str, str] | None
    improved: Array


class Fold(NamedTuple):
    """The least friction at which some loads have several answers, by dls_contact_fold
    (delassus/trust.h); all mu are scaled together, the largest one counts.

    unique       one answer for each load below (proved)
    friction     here the load q has the answers r and other (nc x d each); inf: none was found
    exact        True: unique == friction (2D, up to 8 contacts)
    """

    unique: float
    friction: float
    exact: bool
    q: Array
    r: Array
    other: Array


_PROVED = {constants["DLS_PROVED"]: "reactions", constants["DLS_PROVED_POSITIONS"]: "positions"}


class Solution:
    """The outcome of a solve.

    r, u         reactions and local positions, nc x d, each row (n, t) or (n, t, s)
    x            unknowns of the host, if a reduction or a motion solved; else None
    states       "free", "slip" or "stick" of each candidate; "free" or "touch" without tangents
    notes        what was not given, and what that means
    solved       True: certified to tol
    status, words   number (DLS_...) and words of the outcome; above 0, r is the best answer found
    residual, certificate   of r; if a reduction solved, of the body, with its equilibrium
    error        predicted relative error of r, or None
    iterations, method, stages, unique, ambiguous   as in delassus/info.h
    regime       of auto, the kind of the problem: "elastic", "packing", ...
    explain()    what auto did and why, in words
    forces       "least" where r is the least of the reactions of its positions, else "any"
    freedom      self-stresses, counted when it is first asked for: above 0, r is one of many:
                 the positions u determine the sum on each body, not single reactions; None where a
                 reduction or a motion solved
    history      rows (stage, iteration, residual, cpu_seconds), with history=True
    proof        a Proof of r, computed at its first use from the arrays as they are then; None
                 if a reduction or a motion solved
    fold         a Fold of W, likewise; UnsupportedError: d = 1 or an infinite mu
    sums(), write_vtu(path)   where a reduction solved: reactions by body, a file for ParaView
    vjp(), jvp() derivatives, of the arrays as they are at the first call
    """

    def __init__(self, problem: Any, info: Any, status: int, r: Vector, u: Vector,
                 history: npt.NDArray[Any] | None, body: Any = None,
                 states: npt.NDArray[np.str_] | None = None) -> None:
        d, nc = problem.d, problem.nc
        self.status = status
        self.words: str = lib.dls_status_text(status).decode()
        self.solved = bool(lib.dls_solved(status))
        self.r = r.reshape(nc, d)
        self.u = u.reshape(nc, d)
        self.x: Vector | None = None
        self.notes: List[str] = []
        self._surface: Surface | None = None
        self._nodal: Any = None
        self.certificate = _certificate(info.certificate)
        self.residual = self.certificate.residual
        self.error: float | None = info.error or None
        self.iterations: int = info.iterations
        self.method = _method_name(info.method)
        self.stages = [_stage(s) for s in info.stage[:info.stages]]
        self.regime: str = lib.dls_regime_name(info.regime).decode()
        self._info = bytes(info)  # a copy of the struct would not pickle
        self.unique: bool | None = {constants["DLS_UNIQUE_YES"]: True,
                                    constants["DLS_UNIQUE_NO"]: False}.get(info.unique)
        self.ambiguous: int = info.ambiguous
        self.forces = FORCES[info.forces]
        self.history = history
        self._source: Tuple[Any, ...] | None = None
        self._proof: Proof | None = None
        self._fold: Fold | None = None
        self._freedom: int | None = None
        # side -> Derivative; of a reduction: makes one, or says that the reduction has moved on
        self._derivatives: Dict[int, Derivative] = {}
        self._of_body: Callable[[Solution, int, Derivative | None], Derivative] | None = None
        state = (c_int * max(nc, 1))()
        if states is not None:
            self.states = states
            return
        if nc and body is not None:
            call("dls_reduction_states", *body[:2], address(r), address(u), state)
        elif nc:
            call("dls_contact_states", byref(problem), address(r), address(u), state)
        self.states = name_states(np.frombuffer(state, dtype=np.intc)[:nc], d > 1)

    @property
    def proof(self) -> Proof | None:
        if self._proof is None and self._source is not None:
            problem, kept = _problem(*self._source)
            proof, improved = structs["dls_proof"](), np.empty_like(self.r)
            call("dls_contact_prove", byref(problem), address(self.r), byref(proof),
                 address(improved))
            del kept
            self._proof = Proof(
                _PROVED.get(proof.kind), proof.radius, proof.radius_u, proof.error, proof.freedom,
                proof.border and (proof.contact, str(STATES[proof.state]),
                                  str(STATES[proof.other])) or None, improved)
        return self._proof

    @property
    def fold(self) -> Fold | None:
        if self._fold is None and self._source is not None:
            problem, kept = _problem(*self._source)
            fold, (q, r, other) = structs["dls_fold"](), np.zeros((3, *self.r.shape))
            call("dls_contact_fold", byref(problem), byref(fold), None, address(q), address(r),
                 address(other))
            del kept
            self._fold = Fold(fold.unique, fold.friction, bool(fold.exact), q, r, other)
        return self._fold

    @property
    def freedom(self) -> int | None:
        if self._freedom is None and self._source is not None:
            problem, kept = _problem(*self._source)
            count = c_int()
            call("dls_contact_freedom", byref(problem), address(self.r), byref(count))
            del kept
            self._freedom = count.value
        return self._freedom

    def __getstate__(self) -> Dict[str, Any]:  # derivatives own memory of the library
        return {**self.__dict__, "_derivatives": {}, "_of_body": None, "_surface": None}

    def _derivative(self, side: int | None) -> Derivative:
        side = -1 if side is None else whole("side", side)
        made = self._derivatives.get(side)
        if self._of_body is not None:
            made = self._of_body(self, side, made)
        elif made is None:
            if self._source is None:
                raise ValueError("no derivatives of a motion, nor of a pickled body")
            problem, kept = _problem(*self._source)
            W = self._source[0]
            made = Derivative("dls_derive_create", byref(problem), address(self.r), side,
                              d=problem.d, nc=problem.nc, r=self.r, kept=(problem, kept),
                              matrix=kept[2:] if problem.bodies.H else W)
        self._derivatives[side] = made
        return made

    def vjp(self, r: Array | None = None, u: Array | None = None, x: Array | None = None, *,
            side: int | None = None) -> Gradient:
        """Returns the Gradient, dL/d(data), of a loss L with dL/dr = r, dL/du = u and, if a
        reduction solved, dL/dx = x. The first call factorises a matrix, later ones solve with it.

        NoDerivativeError: a contact is on the border of two states, where the solution has a kink,
        or r is not determined. On a border side=0 takes the derivative of the higher state (stick
        rather than slip, closed rather than free), side=1 that of the lower one."""
        return self._derivative(side).vjp(r, u, x)

    def jvp(self, q: Array | None = None, mu: Array | None = None, W: Change | None = None,
            f: Array | None = None, g: Array | None = None, K: Matrix | None = None, *,
            side: int | None = None) -> Moved:
        """Returns the change of r, u (and x) for a change of the data: q, mu and W, or f, g, mu and
        K if a reduction solved; None: no change. side and errors as in vjp."""
        return self._derivative(side).jvp(q, mu, W, f, g, K)

    def sums(self) -> List[Sum]:
        """Returns the sum of the reactions on each body, a part of K's unknowns that K connects;
        with moments where the reduction has coordinates."""
        return self._on_body().sums(self._nodal)

    def write_vtu(self, path: str | os.PathLike[str]) -> None:
        """Writes the nodes with displacement, reaction, state (-1: no contact, 0 free, 1 slip, 2
        stick or touch) and gap for ParaView. Needs coordinates."""
        assert self.x is not None
        self._on_body().write(path, self.x, self._nodal, self.states,
                              np.where(self.states == "free", self.u[:, 0], 0))

    def _on_body(self) -> Surface:
        if self._surface is None:
            raise ValueError("no sums of a solution without a reduction, nor of a pickled one")
        return self._surface

    def __repr__(self) -> str:
        return (f"<{self.words}: {len(self.r)} candidates, {self.method}, "
                f"{self.iterations} iterations, residual {self.residual:.1e}"
                + "".join(f"; {note}" for note in self.notes) + ">")

    def _repr_html_(self) -> str:
        """Returns a table of the first contacts, for notebooks."""
        d, shown = self.r.shape[1], min(len(self.r), 20)
        head = ["contact", "state", *(f"{a}_{i}" for a in "ru" for i in "nts"[:d])]
        cells = [[str(c), str(self.states[c]), *(f"{x:.5g}" for x in (*self.r[c], *self.u[c]))]
                 for c in range(shown)]
        rows = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>"
                       for row in cells)
        rest = f"<p>{len(self.r) - shown} more contacts</p>" if shown < len(self.r) else ""
        names = "".join(f"<th>{name}</th>" for name in head)
        return (f"<p>{html.escape(repr(self)[1:-1])}</p><table><tr>{names}</tr>{rows}</table>{rest}")

    def explain(self) -> str:
        """Returns a description of what auto did: the regime, and a line for each step with its
        iterations, why it ended and, with timed=True, a history or a callback, its CPU time."""
        info = structs["dls_info"].from_buffer_copy(self._info)
        text = ctypes.create_string_buffer(lib.dls_explain(byref(info), None, 0) + 1)
        lib.dls_explain(byref(info), text, len(text))
        return str(text.value.decode())


def _stage(s: Any) -> Stage:
    return Stage(_method_name(s.method), s.iterations, s.factorisations, s.residual,
                 lib.dls_step_name(s.step).decode(), lib.dls_reason_text(s.reason).decode(),
                 bool(s.on_copy), s.ahead, s.next, s.cpu_seconds)


def _method_name(method: int) -> str:
    return str((lib.dls_method_name(method) or b"").decode())


_NO_LIMIT = 1e9  # seconds
_PACED = ctypes.cast(lib.dls_progress_paced, ctypes.c_void_p).value


class _Signals:
    """A callback that does nothing but let the handlers of signals run, some 50 times a second."""

    idle: list[_Signals] = []  # some made before: one takes 10 us to make

    def __init__(self) -> None:
        self.callback = Callback(lambda _, __: False, c_size_t, c_size_t)
        self.paced = structs["dls_paced"](progress=self.callback.address, seconds=0.02)


class Watch:
    """The callback of a solve: keeps the history, calls the user's function and lets the handlers
    of signals run. Those run in the main thread alone; elsewhere a solve that is not watched by the
    user has no callback."""

    def __init__(self, history: bool = False,
                 progress: Callable[[Progress], object] | None = None) -> None:
        rows: list[tuple[Any, ...]] | None = [] if history else None
        self._rows = rows
        asked = history or progress is not None

        def look(_: Any, pointer: int) -> bool:
            p = structs["dls_progress"].from_address(pointer)
            row = Progress(ctypes.string_at(p.method).decode(), ctypes.string_at(p.stage).decode(),
                           p.iteration, p.max_iterations, p.residual, p.cpu_seconds, bool(p.last))
            if rows is not None:
                rows.append((row.stage, row.iteration, row.residual, row.cpu_seconds))
            return progress is not None and bool(progress(row))

        self._callback: Callback | None = None
        self._signals: _Signals | None = None
        if asked:
            self._callback = Callback(look, c_size_t, c_size_t)
        elif threading.current_thread() is threading.main_thread():
            self._signals = _Signals.idle.pop() if _Signals.idle else _Signals()
            self._callback = self._signals.callback

    def release(self) -> None:
        """Hands the callback on to the next watch; this one has seen its last call. (A __del__
        would revive a generator that the collector of garbage has ended.)"""
        if self._signals:
            _Signals.idle.append(self._signals)
            self._callback = self._signals = None

    def set(self, limits: Any) -> None:
        """Enters the callback in a dls_limits."""
        if self._signals:
            limits.progress = _PACED
            limits.progress_data = ctypes.addressof(self._signals.paced)
        elif self._callback:
            limits.progress = self._callback.address

    def call(self, name: str, *arguments: Any, by: Callable[..., int] = call) -> int:
        """Calls the library; raises what the callback caught."""
        if not self._callback:
            return by(name, *arguments)
        self._callback.begin()
        try:
            return by(name, *arguments)
        finally:
            self._callback.end()

    def history(self) -> npt.NDArray[Any] | None:
        if self._rows is None:
            return None
        return np.array(self._rows, dtype=[("stage", "U24"), ("iteration", "i4"),
                                           ("residual", "f8"), ("cpu_seconds", "f8")])


def set_limits(limits: Any, watch: Watch, tol: float | None = None,
               max_iterations: int | None = None, cpu_seconds: float | None = None,
               threads: int | None = None) -> None:
    """Fills a dls_limits; None leaves the default."""
    if tol is not None:
        limits.tol = number("tol", tol)
    if max_iterations is not None:
        limits.max_iterations = whole("max_iterations", max_iterations)
    if cpu_seconds is not None:
        limits.cpu_seconds = number("cpu_seconds", cpu_seconds)
    if threads is not None:
        limits.threads = whole("threads", threads)
    watch.set(limits)


_METHODS = list(iter(map(_method_name, itertools.count()).__next__, ""))
_ACCELERATIONS = ("none", "aitken", "anderson", "momentum")


def _find(function: Any, what: str, name: Any) -> int:
    """Returns the number of a method or an acceleration."""
    found = c_int()
    if not isinstance(name, str) or "\0" in name or not function(name.encode(), byref(found)):
        raise one_of(what, name, _METHODS if what == "method" else _ACCELERATIONS)
    return found.value


def find_method(name: str) -> int:
    return _find(lib.dls_method_find, "method", name)


def _text(name: str, value: Any) -> Any:
    """Returns a C string."""
    if not isinstance(value, str) or "\0" in value:
        raise ValueError(f"{name} is no text: {value!r}")
    return ctypes.create_string_buffer(value.encode())


def solver_settings(method: str = "auto", acceleration: str | None = None,
                    facets: int | None = None, positive_definite: int | None = None,
                    plan: str | None = None, without: str | None = None,
                    forces: str = "any") -> tuple[Any, list[Any]]:
    """Returns a dls_solver_settings with default limits, and the strings that it views."""
    settings = structs["dls_solver_settings"]()
    lib.dls_solver_settings_init(byref(settings))
    settings.method = find_method(method)
    if acceleration is not None:
        settings.acceleration = _find(lib.dls_acceleration_find, "acceleration", acceleration)
    if facets is not None:
        settings.facets = whole("facets", facets)
    if positive_definite is not None:
        settings.positive_definite = whole("positive_definite", positive_definite)
    if forces not in FORCES:
        raise one_of("forces", forces, FORCES)
    settings.forces = FORCES.index(forces)
    words = [_text(*one) if one[1] is not None else None
             for one in (("plan", plan), ("without", without))]
    settings.plan, settings.without = [word and ctypes.addressof(word) for word in words]
    return settings, words


def solve_problem(problem: Any, *, method: str = "auto", tol: float | None = None,
                  max_iterations: int | None = None, cpu_seconds: float | None = None,
                  r0: Array | None = None, acceleration: str | None = None,
                  facets: int | None = None, positive_definite: int | None = None,
                  history: bool = False, progress: Callable[[Progress], object] | None = None,
                  threads: int | None = None, plan: str | None = None,
                  without: str | None = None, timed: bool = False, forces: str = "any",
                  body: Any = None) -> Solution:
    """Solves a dls_contact; the arguments are those of solve(). body: (reduction, mu, x), whose
    dls_reduction_solve is called instead and fills x."""
    settings, words = solver_settings(method, acceleration, facets, positive_definite, plan,
                                      without, forces)
    if timed and cpu_seconds is None:
        cpu_seconds = _NO_LIMIT  # a limit asks for the clock
    watch = Watch(history, progress)
    m = problem.d * problem.nc
    r = np.zeros(m) if r0 is None else vector("r0", r0, m, problem.d).copy()
    u = np.zeros(m)
    set_limits(settings.limits, watch, tol, max_iterations, cpu_seconds, threads)
    settings.limits.warm_start = r0 is not None
    info = structs["dls_info"]()
    name = "dls_solve"
    first: tuple[Any, ...] = (byref(problem),)
    last: tuple[Any, ...] = ()
    if body is not None:
        reduction, mu, x = body
        name, first, last = "dls_reduction_solve", (reduction, mu), (address(x),)
    try:
        status = watch.call(name, *first, byref(settings), address(r), address(u), *last,
                            byref(info))
    finally:
        watch.release()
    return Solution(problem, info, status, r, u, watch.history(), body)


def _dimension(W: Any, q: Vector, mu: Any, d: Any) -> int:
    """Returns d: given, else what the sizes of q, H or mu leave, else 2 or 3, whichever alone
    divides the rows; 1 where q is flat and mu is 0."""
    if d is not None:
        if whole("d", d) not in (1, 2, 3):
            raise ValueError(f"d is {d!r}, must be 1, 2 or 3")
        return int(d)
    if q.ndim == 2:
        found = q.shape[1]
    elif isinstance(W, tuple):
        found = np.shape(W[1])[2]
    elif mu.ndim and mu.size:
        found = q.size // mu.size
    elif not mu.any():
        return 1
    else:
        fits = [k for k in (2, 3) if q.size % k == 0]
        if len(fits) == 2:
            raise ValueError(f"q has {entries(q)}, which fits d = 2 and d = 3: give d, or q as "
                             "nc x d, or mu for each contact")
        found = fits[0] if fits else 0
    if found not in (1, 2, 3):
        raise ValueError(f"q has {entries(q)}, mu {entries(mu)}, which fits neither d = 2 nor "
                         "d = 3")
    return found


def _problem(W: Any, q: Any, mu: Any, d: Any) -> tuple[Any, tuple[Any, ...]]:
    """Returns a dls_contact and the arrays that it views."""
    if isinstance(W, tuple) and not (len(W) == 2 and np.ndim(W[1]) == 4):
        W = list(W)
    if not hasattr(W, "tocsc") and not isinstance(W, tuple):
        W = np.atleast_2d(reals("W", W))
    q = reals("q", q)
    if mu is None and d != 1:
        raise ValueError("mu is missing: give the friction, 0 for none")
    mu = reals("mu", 0.0 if mu is None else mu)
    d = _dimension(W, q, mu, d)
    nc = q.size // d
    q = vector("q", np.atleast_1d(q), d * nc, d)
    mu = vector("mu", mu, nc)
    if d == 1 and mu.any():
        raise ValueError(f"mu[{np.flatnonzero(mu)[0]}] is {mu[mu != 0][0]:g}, must be 0 where d = 1")
    problem = structs["dls_contact"](d=d, nc=nc, q=address(q), mu=address(mu))
    if isinstance(W, tuple):
        body, H = integers("body", W[0]), np.ascontiguousarray(reals("H", W[1]))
        if body.shape != (nc, 2) or H.shape[:3] != (nc, 2, d) or H.ndim != 4:
            raise ValueError(f"body is {body.shape}, H is {H.shape}; nc = {nc}, d = {d}")
        count = int(body.max(initial=-1)) + 1
        problem.bodies = structs["dls_bodies"](H.shape[3], count, address(body), address(H), None)
        return problem, (q, mu, body, H)
    if W.shape != (q.size, q.size):
        raise ValueError(f"W is {' x '.join(map(str, W.shape))}, q has {entries(q)}")
    if hasattr(W, "tocsc"):
        # rows of blocks of the transpose, each stored by rows: the columns of W, stored by columns
        B = columns("W", W).T.tobsr(blocksize=(d, d))
        kept: list[npt.NDArray[Any]] = [
            np.ascontiguousarray(B.indptr, dtype=np.int32),
            np.ascontiguousarray(B.indices, dtype=np.int32),
            np.ascontiguousarray(B.data, dtype=np.float64)]
        if kept[2].size == 0:
            kept[1:] = [np.zeros(1, np.int32), np.zeros(d * d)]
        problem.Wb = structs["dls_blocks"](d, nc, *map(address, kept))
    else:
        kept = [np.asfortranarray(W)]
        problem.W = dense(kept[0])
    return problem, (q, mu, *kept)


def solve(W: Operator, q: Array, mu: Array | None = None, d: int | None = None, *,
          method: str = "auto", tol: float | None = None, max_iterations: int | None = None,
          cpu_seconds: float | None = None, r0: Array | None = None,
          acceleration: str | None = None, facets: int | None = None,
          positive_definite: int | None = None, history: bool = False,
          progress: Callable[[Progress], object] | None = None,
          threads: int | None = None, plan: str | None = None, without: str | None = None,
          timed: bool = False, forces: str = "any") -> Solution:
    """Solves u = W r + q with Coulomb friction; returns a Solution.

    W    m x m, lists or numpy (dense) or scipy.sparse (by d x d blocks); (n, t) or (n, t, s) of
         one contact after the other. Or (body, H) of rigid bodies: body is nc x 2, -1 for a fixed
         one; H is nc x 2 x d x 3 (d - 1): how the reaction's component moves the body, with
         M^-1/2 in it (dls_bodies)
    q    m, or nc x d
    mu   nc, or one number; 0 for no friction
    d    1 (normals alone, mu = 0), 2 or 3; None: what the sizes of q and mu say. A flat q with
         mu = 0 has normals alone

    method          "auto" (or "nlgs", "lemke", "newton", "admm", ...)
    tol             on the residual of the certificate (1e-8)
    max_iterations, cpu_seconds   limits
    r0              a start
    acceleration    of nlgs: "none", "aitken", "anderson", "momentum"
    facets          of lemke in 3D: facets of the friction cone
    positive_definite   1 if W is known to be, 0 if not
    history         True: Solution.history
    progress        function of a Progress; returns True to cancel
    threads         for sweeps over a large W
    forces          "least": of the reactions of the same positions those with the least sum of
                    w |r|^2, as symmetric as the problem; "any": those that the method finds

    Of auto:
    plan            steps in place of its own, "sweeps:30,newton,homotopy" (delassus/solve.h)
    without         steps left out, "homotopy,scatter"
    timed           True: the CPU of each stage

    Raises an Error for wrong data; a solve that stops early has solution.solved == False.
    """
    problem, kept = _problem(W, q, mu, d)
    solution = solve_problem(
        problem, method=method, tol=tol, max_iterations=max_iterations, cpu_seconds=cpu_seconds,
        r0=r0, acceleration=acceleration, facets=facets, positive_definite=positive_definite,
        history=history, progress=progress, threads=threads,
        plan=plan, without=without, timed=timed, forces=forces)
    solution._source = W, q, mu, d
    del kept
    return solution


def certify(W: Operator, q: Array, mu: Array | None, r: Array,
            d: int | None = None) -> Certificate:
    """Measures r: returns its Certificate, with u = W r + q recomputed from W and q."""
    problem, kept = _problem(W, q, mu, d)
    r = vector("r", r, problem.d * problem.nc, problem.d)
    certificate = structs["dls_certificate"]()
    call("dls_contact_certify", byref(problem), address(r), None, byref(certificate))
    del kept
    return _certificate(certificate)
