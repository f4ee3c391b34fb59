"""The contact problem u = W r + q and its solution by any method of the library."""

import collections
import ctypes
import threading
from ctypes import byref, c_int, c_size_t

import numpy as np

from ._library import (Callback, address, call, columns, constants, dense, entries, integers, lib,
                       number, reals, structs, vector, whole)

_STATES = np.array(["free", "slip", "stick"])

Progress = collections.namedtuple(
    "Progress", "method stage iteration max_iterations residual cpu_seconds last")
Stage = collections.namedtuple(
    "Stage", "method iterations factorisations residual step reason on_copy ahead next cpu_seconds")
Certificate = collections.namedtuple("Certificate",
                                     [name for name, _ in structs["dls_certificate"]._fields_])


Proof = collections.namedtuple(
    "Proof", "proved radius radius_u error freedom border improved")
Proof.__doc__ = """What dls_contact_prove shows of an answer (delassus/trust.h).

proved            "reactions": one solution within radius |improved|; "positions": u is proved and
                  `freedom` reactions are free; None: not proved
radius, radius_u  relative bounds on the errors of `improved` and of its positions
error             of r itself
border            (contact, its state, the other one) on the border of two states, or None
improved          r after Newton steps to rounding, nc x d
"""
_PROVED = {constants["DLS_PROVED"]: "reactions", constants["DLS_PROVED_POSITIONS"]: "positions"}


class Solution:
    """The outcome of a solve.

    r, u         reactions and local positions, nc x d, each row (n, t) or (n, t, s)
    x            unknowns of the host, where a reduction or a motion solved; else None
    states       "free", "slip" or "stick" of each candidate
    solved       True: certified to tol
    status, words   number (DLS_...) and words of the outcome; above 0, r is the best answer found
    residual, certificate   of r; where a reduction solved, of the body: equilibrium is a part
    error        predicted relative error of r where that was looked at, else None
    iterations, method, stages, unique, ambiguous   as in delassus/info.h
    regime       of auto, the kind of the problem: "elastic", "packing", ...
    explain()    what auto did and why, in words
    history      rows (stage, iteration, residual, cpu_seconds), with history=True
    proof        a Proof of r, made when it is first asked for, of the arrays as they are then; None
                 where a reduction or a motion solved
    """

    def __init__(self, problem, info, status, r, u, history, body=None):
        d, nc = problem.d, problem.nc
        self.status = status
        self.words = lib.dls_status_text(status).decode()
        self.solved = lib.dls_status_name(status).decode() in ("DLS_OK", "DLS_TO_ROUNDING")
        self.r = r.reshape(nc, d)
        self.u = u.reshape(nc, d)
        self.x = None
        c = info.certificate
        self.certificate = Certificate(*(getattr(c, name) for name in Certificate._fields))
        self.residual = c.residual
        self.error = info.error or None
        self.iterations = info.iterations
        self.method = _method_name(info.method)
        self.stages = [_stage(s) for s in info.stage[:info.stages]]
        self.regime = lib.dls_regime_name(info.regime).decode()
        self._info = bytes(info)  # a copy of the struct would not pickle
        self.unique = {constants["DLS_UNIQUE_YES"]: True,
                       constants["DLS_UNIQUE_NO"]: False}.get(info.unique)
        self.ambiguous = info.ambiguous
        self.history = history
        self._source = self._proof = None
        state = (c_int * max(nc, 1))()
        if nc and body is not None:
            call("dls_reduction_states", *body[:2], address(r), address(u), state)
        elif nc:
            call("dls_contact_states", byref(problem), address(r), address(u), state)
        self.states = _STATES[np.frombuffer(state, dtype=np.intc)[:nc]]

    @property
    def proof(self):
        if self._proof is None and self._source is not None:
            problem, kept = _problem(*self._source)
            proof, improved = structs["dls_proof"](), np.empty_like(self.r)
            call("dls_contact_prove", byref(problem), address(self.r), byref(proof),
                 address(improved))
            del kept
            self._proof = Proof(
                _PROVED.get(proof.kind), proof.radius, proof.radius_u, proof.error, proof.freedom,
                proof.border and (proof.contact, str(_STATES[proof.state]),
                                  str(_STATES[proof.other])) or None, improved)
        return self._proof

    def __repr__(self):
        return (f"<{self.words}: {len(self.r)} candidates, {self.method}, "
                f"{self.iterations} iterations, residual {self.residual:.1e}>")


    def explain(self):
        """Returns what auto did, by lines: the regime, and each step with its iterations, why it
        ended, and, with timed=True, a history or a callback, its CPU."""
        info = structs["dls_info"].from_buffer_copy(self._info)
        text = ctypes.create_string_buffer(lib.dls_explain(byref(info), None, 0) + 1)
        lib.dls_explain(byref(info), text, len(text))
        return text.value.decode()


def _stage(s):
    return Stage(_method_name(s.method), s.iterations, s.factorisations, s.residual,
                 lib.dls_step_name(s.step).decode(), lib.dls_reason_text(s.reason).decode(),
                 bool(s.on_copy), s.ahead, s.next, s.cpu_seconds)


def _method_name(method):
    return (lib.dls_method_name(method) or b"").decode()


_NO_LIMIT = 1e9  # seconds
_PACED = ctypes.cast(lib.dls_progress_paced, ctypes.c_void_p).value


class _Signals:
    """A callback that does nothing but let the handlers of signals run, some 50 times a second."""

    idle = []  # some made before: one takes 10 us to make

    def __init__(self):
        self.callback = Callback(lambda _, __: False, c_size_t, c_size_t)
        self.paced = structs["dls_paced"](progress=self.callback.address, seconds=0.02)


class Watch:
    """The callback of a solve: keeps the history, calls the user's function and lets the handlers
    of signals run. Those run in the main thread alone; elsewhere a solve that is not watched by the
    user has no callback."""

    def __init__(self, history=False, progress=None):
        self._rows = rows = [] if history else None
        asked = history or progress is not None

        def look(_, pointer):
            p = structs["dls_progress"].from_address(pointer)
            row = Progress(ctypes.string_at(p.method).decode(), ctypes.string_at(p.stage).decode(),
                           p.iteration, p.max_iterations, p.residual, p.cpu_seconds, bool(p.last))
            if rows is not None:
                rows.append((row.stage, row.iteration, row.residual, row.cpu_seconds))
            return progress is not None and progress(row)

        self._callback = self._signals = None
        if asked:
            self._callback = Callback(look, c_size_t, c_size_t)
        elif threading.current_thread() is threading.main_thread():
            self._signals = _Signals.idle.pop() if _Signals.idle else _Signals()
            self._callback = self._signals.callback

    def release(self):
        """Hands the callback on to the next watch; this one has seen its last call. (A __del__
        would revive a generator that the collector of garbage has ended.)"""
        if self._signals:
            _Signals.idle.append(self._signals)
            self._callback = self._signals = None

    def set(self, limits):
        """Enters the callback in a dls_limits."""
        if self._signals:
            limits.progress = _PACED
            limits.progress_data = ctypes.addressof(self._signals.paced)
        elif self._callback:
            limits.progress = self._callback.address

    def call(self, name, *arguments, by=call):
        """Calls the library; raises what the callback caught."""
        if not self._callback:
            return by(name, *arguments)
        self._callback.begin()
        try:
            return by(name, *arguments)
        finally:
            self._callback.end()

    def history(self):
        if self._rows is None:
            return None
        return np.array(self._rows, dtype=[("stage", "U24"), ("iteration", "i4"),
                                           ("residual", "f8"), ("cpu_seconds", "f8")])


def set_limits(limits, watch, tol=None, max_iterations=None, cpu_seconds=None, threads=None):
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


def _find(function, what, name):
    """Returns the number of a method or an acceleration."""
    found = c_int()
    if not isinstance(name, str) or "\0" in name or not function(name.encode(), byref(found)):
        raise ValueError(f"no {what} {name!r}")
    return found.value


def find_method(name):
    return _find(lib.dls_method_find, "method", name)


def _text(name, value):
    """Returns a C string."""
    if not isinstance(value, str) or "\0" in value:
        raise ValueError(f"{name} is no text: {value!r}")
    return ctypes.create_string_buffer(value.encode())


def solve_problem(problem, method="auto", tol=None, max_iterations=None, cpu_seconds=None, r0=None,
                  acceleration=None, facets=None, positive_definite=None, history=False,
                  progress=None, threads=None, plan=None, without=None, timed=False, body=None):
    """Solves a dls_contact; the arguments are those of solve(). body: (reduction, mu, x), whose
    dls_reduction_solve is called instead and fills x."""
    settings = structs["dls_solver_settings"]()
    lib.dls_solver_settings_init(byref(settings))
    settings.method = find_method(method)
    if acceleration is not None:
        settings.acceleration = _find(lib.dls_acceleration_find, "acceleration", acceleration)
    if facets is not None:
        settings.facets = whole("facets", facets)
    if positive_definite is not None:
        settings.positive_definite = whole("positive_definite", positive_definite)
    words = [_text(*one) if one[1] is not None else None
             for one in (("plan", plan), ("without", without))]
    settings.plan, settings.without = [word and ctypes.addressof(word) for word in words]
    if timed and cpu_seconds is None:
        cpu_seconds = _NO_LIMIT  # a limit asks for the clock
    watch = Watch(history, progress)
    m = problem.d * problem.nc
    r = np.zeros(m) if r0 is None else vector("r0", r0, m, problem.d).copy()
    u = np.zeros(m)
    set_limits(settings.limits, watch, tol, max_iterations, cpu_seconds, threads)
    settings.limits.warm_start = r0 is not None
    info = structs["dls_info"]()
    name, first, last = "dls_solve", (byref(problem),), ()
    if body is not None:
        reduction, mu, x = body
        name, first, last = "dls_reduction_solve", (reduction, mu), (address(x),)
    try:
        status = watch.call(name, *first, byref(settings), address(r), address(u), *last,
                            byref(info))
    finally:
        watch.release()
    return Solution(problem, info, status, r, u, watch.history(), body)


def _problem(W, q, mu, d):
    """Returns a dls_contact and the arrays that it views."""
    q = reals("q", q)
    if d is None:
        known = np.ndim(mu) and np.size(mu)
        d = q.shape[1] if q.ndim == 2 else q.size // np.size(mu) if known else None
    if d not in (2, 3):
        raise ValueError("d is neither 2 nor 3: give d, or q as nc x d, or mu for each candidate")
    d = whole("d", d)
    nc = q.size // d
    q = vector("q", np.atleast_1d(q), d * nc, d)
    mu = vector("mu", mu, nc)
    problem = structs["dls_contact"](d=d, nc=nc, q=address(q), mu=address(mu))
    if isinstance(W, tuple):
        body, H = integers("body", W[0]), np.ascontiguousarray(reals("H", W[1]))
        if body.shape != (nc, 2) or H.shape[:3] != (nc, 2, d) or H.ndim != 4:
            raise ValueError(f"body is {body.shape}, H is {H.shape}; nc = {nc}, d = {d}")
        count = int(body.max(initial=-1)) + 1
        problem.bodies = structs["dls_bodies"](H.shape[3], count, address(body), address(H), None)
        return problem, (q, mu, body, H)
    if W.shape != (q.size, q.size):
        raise ValueError(f"W is {W.shape[0]} x {W.shape[1]}, q has {entries(q)}")
    if hasattr(W, "tocsc"):
        # rows of blocks of the transpose, each stored by rows: the columns of W, stored by columns
        B = columns("W", W).T.tobsr(blocksize=(d, d))
        kept = [np.ascontiguousarray(B.indptr, dtype=np.int32),
                np.ascontiguousarray(B.indices, dtype=np.int32),
                np.ascontiguousarray(B.data, dtype=np.float64)]
        if kept[2].size == 0:
            kept[1:] = [np.zeros(1, np.int32), np.zeros(d * d)]
        problem.Wb = structs["dls_blocks"](d, nc, *map(address, kept))
    else:
        kept = [np.asfortranarray(W)]
        problem.W = dense(kept[0])
    return problem, (q, mu, *kept)


def solve(W, q, mu, d=None, **options):
    """Solves u = W r + q with Coulomb friction; returns a Solution.

    W    m x m, numpy (dense) or scipy.sparse (by d x d blocks); (n, t) or (n, t, s) of one
         candidate after the other. Or (body, H) of rigid bodies: body is nc x 2, -1 for a fixed
         one; H is nc x 2 x d x 3 (d - 1): how the reaction's component moves the body, with
         M^-1/2 in it (dls_bodies)
    q    m, or nc x d
    mu   nc, or one number
    d    2 or 3, if it does not follow from q or mu

    method="auto" (or "nlgs", "lemke", "newton", "admm", ...), tol=1e-8, max_iterations,
    cpu_seconds, r0 (a start), acceleration="anderson" (nlgs), facets, positive_definite,
    history=True, progress=function of a Progress, which cancels by returning True, threads.

    Of auto: plan="sweeps:30,newton,homotopy", steps in place of its own (delassus/solve.h);
    without="homotopy,scatter", steps left out; timed=True, the CPU of each stage.

    Raises Error for wrong data; a solve that stops early has solution.solved == False.
    """
    if not hasattr(W, "tocsc") and not isinstance(W, tuple):
        W = np.atleast_2d(reals("W", W))
    problem, kept = _problem(W, q, mu, d)
    solution = solve_problem(problem, **options)
    solution._source = W, q, mu, d
    del kept
    return solution


def certify(W, q, mu, r, d=None):
    """Measures r: returns its Certificate, with u = W r + q recomputed from W and q."""
    if not hasattr(W, "tocsc") and not isinstance(W, tuple):
        W = np.atleast_2d(reals("W", W))
    problem, kept = _problem(W, q, mu, d)
    r = vector("r", r, problem.d * problem.nc, problem.d)
    certificate = structs["dls_certificate"]()
    call("dls_contact_certify", byref(problem), address(r), None, byref(certificate))
    del kept
    return Certificate(*(getattr(certificate, name) for name in Certificate._fields))
