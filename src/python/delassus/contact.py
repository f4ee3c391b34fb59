"""The contact problem u = W r + q and its solution by any method of the library."""

import collections
import ctypes
from ctypes import byref, c_int

import numpy as np

from ._library import (PROGRESS_FN, address, call, constants, dense, entries, lib, structs, vector)

_STATES = np.array(["free", "slip", "stick"])

Progress = collections.namedtuple(
    "Progress", "method stage iteration max_iterations residual cpu_seconds last")
Stage = collections.namedtuple("Stage", "method iterations factorisations residual")
Certificate = collections.namedtuple("Certificate",
                                     [name for name, _ in structs["dls_certificate"]._fields_])


class Solution:
    """The outcome of a solve.

    r, u         reactions and local positions, nc x d, each row (n, t) or (n, t, s)
    x            unknowns of the host, where a reduction or a motion solved; else None
    states       "free", "slip" or "stick" of each candidate
    solved       True: certified to tol
    status, words   number (DLS_...) and words of the outcome; above 0, r is the best answer found
    residual, certificate   of r
    iterations, method, stages, unique, ambiguous   as in delassus/info.h
    history      rows (stage, iteration, residual, cpu_seconds), with history=True
    """

    def __init__(self, problem, info, status, r, u, history):
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
        self.iterations = info.iterations
        self.method = _method_name(info.method)
        self.stages = [Stage(_method_name(s.method), s.iterations, s.factorisations, s.residual)
                       for s in info.stage[:info.stages]]
        self.unique = {constants["DLS_UNIQUE_YES"]: True,
                       constants["DLS_UNIQUE_NO"]: False}.get(info.unique)
        self.ambiguous = info.ambiguous
        self.history = history
        state = (c_int * max(nc, 1))()
        if nc:
            call("dls_contact_states", byref(problem), address(r), address(u), state)
        self.states = _STATES[np.frombuffer(state, dtype=np.intc)[:nc]]

    def __repr__(self):
        return (f"<{self.words}: {len(self.r)} candidates, {self.method}, "
                f"{self.iterations} iterations, residual {self.residual:.1e}>")


def _method_name(method):
    return (lib.dls_method_name(method) or b"").decode()


class _Watch:
    """The callback of a solve: keeps the history, calls the user's function, holds exceptions."""

    def __init__(self, history, progress):
        self.rows = [] if history else None
        self.progress = progress
        self.exception = None
        self.function = PROGRESS_FN(self._look)

    def _look(self, _, pointer):
        try:
            p = structs["dls_progress"].from_address(pointer)
            row = Progress(ctypes.string_at(p.method).decode(), ctypes.string_at(p.stage).decode(),
                           p.iteration, p.max_iterations, p.residual, p.cpu_seconds, bool(p.last))
            if self.rows is not None:
                self.rows.append((row.stage, row.iteration, row.residual, row.cpu_seconds))
            return int(bool(self.progress and self.progress(row)))
        except BaseException as exception:  # Ctrl-C, too, must not run through C
            self.exception = exception
            return 1

    def history(self):
        if self.rows is None:
            return None
        return np.array(self.rows, dtype=[("stage", "U24"), ("iteration", "i4"), ("residual", "f8"),
                                          ("cpu_seconds", "f8")])


def set_limits(limits, tol, max_iterations, cpu_seconds, warm_start, watch, threads=None):
    """Fills a dls_limits; None leaves the default."""
    if tol is not None:
        limits.tol = tol
    if max_iterations is not None:
        limits.max_iterations = max_iterations
    if cpu_seconds is not None:
        limits.cpu_seconds = cpu_seconds
    if threads is not None:
        limits.threads = threads
    if warm_start is not None:
        limits.warm_start = warm_start
    if watch:
        limits.progress = ctypes.cast(watch.function, ctypes.c_void_p).value


def find_method(name):
    number = c_int()
    if not lib.dls_method_find(name.encode(), byref(number)):
        raise ValueError(f"no method {name!r}")
    return number.value


def solve_problem(problem, method="auto", tol=None, max_iterations=None, cpu_seconds=None, r0=None,
                  acceleration=None, facets=None, positive_definite=None, history=False,
                  progress=None, threads=None):
    """Solves a dls_contact; the arguments are those of solve()."""
    settings = structs["dls_solver_settings"]()
    lib.dls_solver_settings_init(byref(settings))
    settings.method = find_method(method)
    if acceleration is not None:
        number = c_int()
        if not lib.dls_acceleration_find(acceleration.encode(), byref(number)):
            raise ValueError(f"no acceleration {acceleration!r}")
        settings.acceleration = number.value
    if facets is not None:
        settings.facets = facets
    if positive_definite is not None:
        settings.positive_definite = positive_definite
    watch = _Watch(history, progress) if history or progress else None
    m = problem.d * problem.nc
    r = np.zeros(m) if r0 is None else vector("r0", r0, m).copy()
    u = np.zeros(m)
    set_limits(settings.limits, tol, max_iterations, cpu_seconds, r0 is not None, watch, threads)
    info = structs["dls_info"]()
    status = call("dls_solve", byref(problem), byref(settings), address(r), address(u), byref(info))
    if watch and watch.exception:
        raise watch.exception
    return Solution(problem, info, status, r, u, watch.history() if watch else None)


def _problem(W, q, mu, d):
    """Returns a dls_contact and the arrays that it views."""
    q = np.asarray(q, dtype=np.float64)
    if d is None:
        known = np.ndim(mu) and np.size(mu)
        d = q.shape[1] if q.ndim == 2 else q.size // np.size(mu) if known else None
    if d not in (2, 3):
        raise ValueError("d is neither 2 nor 3: give d, or q as nc x d, or mu for each candidate")
    q = np.ascontiguousarray(q).reshape(-1)
    nc = q.size // d
    q = vector("q", q, d * nc)
    mu = vector("mu", mu, nc)
    problem = structs["dls_contact"](d=d, nc=nc, q=address(q), mu=address(mu))
    if isinstance(W, tuple):
        body, H = np.array(W[0], dtype=np.int32, order="C"), np.array(W[1], np.float64, order="C")
        if body.shape != (nc, 2) or H.shape[:3] != (nc, 2, d) or H.ndim != 4:
            raise ValueError(f"body is {body.shape}, H is {H.shape}; nc = {nc}, d = {d}")
        count = int(body.max(initial=-1)) + 1
        problem.bodies = structs["dls_bodies"](H.shape[3], count, address(body), address(H), None)
        return problem, (q, mu, body, H)
    if W.shape != (q.size, q.size):
        raise ValueError(f"W is {W.shape[0]} x {W.shape[1]}, q has {entries(q)}")
    if hasattr(W, "tocsc"):
        # rows of blocks of the transpose, each stored by rows: the columns of W, stored by columns
        B = W.T.tobsr(blocksize=(d, d))
        kept = [np.ascontiguousarray(B.indptr, dtype=np.int32),
                np.ascontiguousarray(B.indices, dtype=np.int32),
                np.ascontiguousarray(B.data, dtype=np.float64)]
        if kept[2].size == 0:
            kept[1:] = [np.zeros(1, np.int32), np.zeros(d * d)]
        problem.Wb = structs["dls_blocks"](d, nc, *map(address, kept))
    else:
        kept = [np.asfortranarray(W, dtype=np.float64)]
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

    Raises Error for wrong data; a solve that stops early has solution.solved == False.
    """
    if not hasattr(W, "tocsc") and not isinstance(W, tuple):
        W = np.atleast_2d(np.asarray(W, dtype=np.float64))
    problem, kept = _problem(W, q, mu, d)
    solution = solve_problem(problem, **options)
    del kept
    return solution


def certify(W, q, mu, r, d=None):
    """Measures r: returns its Certificate, with u = W r + q recomputed from W and q."""
    if not hasattr(W, "tocsc") and not isinstance(W, tuple):
        W = np.atleast_2d(np.asarray(W, dtype=np.float64))
    problem, kept = _problem(W, q, mu, d)
    r = vector("r", r, problem.d * problem.nc)
    certificate = structs["dls_certificate"]()
    call("dls_contact_certify", byref(problem), address(r), None, byref(certificate))
    del kept
    return Certificate(*(getattr(certificate, name) for name in Certificate._fields))
