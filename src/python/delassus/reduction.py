"""From K, H_N, H_T to the contact problem and back: K x = f + H r, u = H^T x + g."""

from __future__ import annotations

import dataclasses
import weakref
from ctypes import byref, c_double, c_int, c_size_t, c_void_p
from typing import Any, Callable, Union

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from ._library import (Array, Callback, Error, Matrix, Owner, Vector, address, call, columns, constants, dense, entries,
                       gaps, integers, lib, one_of, read, reals, set_fields, sparse, structs, vector)
from .contact import Certificate, Progress, Solution, Watch, _certificate, solve_problem
from .derivative import Derivative
from .surface import Surface

_FACTORIZATIONS = {"cholesky": "DLS_CHOLESKY", "ldlt": "DLS_LDLT", "lu": "DLS_LU"}

# K, or the function of a host that solves with it
Stiffness = Union[Matrix, Callable[[Vector], Any]]


def is_symmetric(K: Any) -> bool:
    """Returns True if K equals its transpose up to the rounding of an assembly, as the program
    does (src/problem/arrays.c)."""
    K = sp.coo_matrix(K)
    size = np.sqrt(np.abs(K.diagonal()))
    apart = (K - K.T).tocoo()
    return bool(np.all(np.abs(apart.data) <= 1e-12 * size[apart.row] * size[apart.col]))


def find_factorization(name: str | None, K: Any) -> int:
    if name is None:
        name = "cholesky" if is_symmetric(K) else "lu"
        if name == "lu" and sp.tril(K, -1).nnz == 0 and sp.triu(K, 1).nnz > 0:
            raise ValueError("K is an upper triangle; a symmetric K is wanted whole, or "
                             "factorization='lu' takes it as it stands")
    if name not in _FACTORIZATIONS:
        raise one_of("factorization", name, _FACTORIZATIONS)
    return constants[_FACTORIZATIONS[name]]


def operators(HN: Any, HT: Any, d: int | None = None) -> tuple[int, Any, Any]:
    """Returns d, HN and HT as compressed columns; without HT there is no tangent: d = 2, no entry."""
    if d not in (None, 2, 3):
        raise ValueError(f"d is {d!r}, must be 2 or 3")
    HN = columns("HN", HN)
    if HT is None:
        HT = sp.csc_matrix((HN.shape[0], ((d or 2) - 1) * HN.shape[1]))
    HT = columns("HT", HT)
    found = HT.shape[1] // HN.shape[1] + 1 if HN.shape[1] else d or 2
    if found not in (2, 3) or HT.shape != (HN.shape[0], (found - 1) * HN.shape[1]):
        raise ValueError(f"HT is {HT.shape}, HN {HN.shape}: HT has d - 1 columns for one of HN")
    return found, HN, HT


def check_tangents(HT: Any, mu: Any) -> None:
    """Refuses friction without tangents."""
    if HT is None and mu is not None and np.any(reals("mu", mu) != 0):
        raise ValueError("HT is missing: friction mu needs the tangents")


class _Host:
    """The function that solves with K where the host has one: one callback of C for the life of a
    reduction, whichever function is at hand."""

    def __init__(self) -> None:
        self.solve: Any = None
        this = weakref.ref(self)

        def run(_: Any, X: int, n: int, nrhs: int) -> None:
            memory: Any = (c_double * (n * nrhs)).from_address(X)
            B = np.frombuffer(memory).reshape(nrhs, n).T
            host: Any = this()
            answer = reals("K^-1 B", host.solve(B.copy(order="F")))
            if answer.shape != B.shape and not (nrhs == 1 and answer.shape == (n,)):
                raise ValueError(f"K^-1 B is {answer.shape}, must be {B.shape}")
            B[:] = answer.reshape(B.shape)

        self.callback = Callback(run, c_size_t, c_size_t, c_int, c_int)


@dataclasses.dataclass
class Limit:
    """What a structure carries: an answer is certified at `carried` (r, x), and a motion proves that
    there is none at `refused`. open: a trial in between without a verdict, or NaN."""

    carried: float
    refused: float
    proved: bool
    open: float
    solves: int
    words: str
    r: Vector
    x: Vector
    motion: Vector | None


class Reduction(Owner):
    """A factorised K with W, or the problem on K itself; made by reduce().

    d, n, m, candidates   sizes: m = d candidates rows of W; d = 1 without HT: normals alone
    W, q                  of the contact problem, read-only views of the library's arrays; copies
                          with surface; not on K
    on                    "W" or "K": where solve() works
    info                  memory, condition
    """

    def __init__(self, K: Any, HN: Any, HT: Any, P: Any, mu: Any, active: Any,
                 factorization: str | None, flexibility: bool, d: int | None,
                 settings: dict[str, Any], surface: Any = None, coordinates: Any = None) -> None:
        self._held = c_void_p()
        self._host = _Host()
        self._watch = Watch()
        P, mu, active = self._sides(HN, P, mu, active)
        HN = columns("HN", HN)
        self._has_tangents = HT is not None
        self._options = (P, mu, active, factorization, flexibility, d)
        model, kept, solve = self._model(K, HN, HT)
        create = structs["dls_reduction_settings"]()
        lib.dls_reduction_settings_init(byref(create))
        create.allow_indefinite = factorization is None
        set_fields(create, settings)
        create.frictionless = not self._has_tangents
        self._surface = surface is not None
        if surface is not None:
            surface = integers("surface", surface).reshape(-1)
            create.surface, create.surface_count = address(surface), surface.size
        self._watch.set(create)
        self._host.solve = solve
        self._call("dls_reduction_create", byref(self._held), byref(model), byref(create))
        self._matrix = kept[0]  # for the pattern of dL/dK; the library has copied it
        directions = model.d if self._has_tangents or d else 0
        self._on_body = Surface(kept[0], kept[1], kept[2], directions, coordinates)
        self._loaded = self._updated = 0  # counts loads and updates
        self._given = [False, False]  # f, g
        self._fresh = False  # no solve since the load
        # the sizes that the library holds: no update changes them
        self._d: int = model.d  # of g
        self.d: int = model.d if self._has_tangents else 1
        self.n: int = model.n
        self._count(model, P, active)

    def __repr__(self) -> str:
        return (f"<Reduction: {f'{self.d}D' if self._has_tangents else 'normals alone'}, "
                f"{self.candidates} candidates, {self.n} unknowns, on {self.on}>")

    def _count(self, model: Any, P: Any, active: Any) -> None:
        self._nodes: int = model.nodes
        candidates = model.nodes if P is None else P.shape[1]
        self.candidates: int = candidates if active is None else int(np.count_nonzero(active))
        self.m: int = self.d * self.candidates

    @staticmethod
    def _sides(HN: Any, P: Any, mu: Any, active: Any) -> tuple[Any, Any, Any]:
        """Returns copies, which update() takes once more."""
        P = None if P is None else columns("P", P).copy()
        candidates = columns("HN", HN).shape[1] if P is None else P.shape[1]
        mu = None if mu is None else vector("mu", mu, candidates).copy()
        if active is not None:
            active = (integers("active", active) != 0).astype(np.intc).reshape(-1)
            if active.size != candidates:
                raise ValueError(f"active has {entries(active)}, needs {candidates}")
        return P, mu, active

    def _model(self, K: Any, HN: Any, HT: Any) -> tuple[Any, Any, Any]:
        """Returns a dls_model, what it views, and K where that is a function; changes nothing."""
        P, mu, active, factorization, flexibility, d = self._options
        if (HT is not None) != self._has_tangents:
            raise ValueError("HT is missing" if HT is None else
                             "HT is given, but the reduction was made without it")
        check_tangents(HT, mu)
        d, HN, HT = operators(HN, HT, d)
        n, nodes = HN.shape
        model = structs["dls_model"](d=d, n=n, nodes=nodes, HN=sparse(HN), HT=sparse(HT),
                                     P=sparse(P), mu=address(mu), active=address(active))
        solve = None
        if callable(K):
            kind, solve = "DLS_HOST_SOLVER", K
            model.solve = self._host.callback.address
        else:
            K = K if hasattr(K, "tocsc") else reals("K", K)
            if K.shape != (n, n):
                raise ValueError(f"K is {K.shape}, HN has {n} rows")
            if hasattr(K, "tocsc"):
                K = columns("K", K)
            model.factorization = find_factorization("lu" if flexibility else factorization, K)
            if hasattr(K, "tocsc") and not flexibility:
                kind = "DLS_STIFFNESS_SPARSE"
                model.Ks = sparse(K)
            else:
                kind = "DLS_FLEXIBILITY" if flexibility else "DLS_STIFFNESS_DENSE"
                K = np.asfortranarray(K.toarray() if hasattr(K, "tocsc") else K)
                model.K = dense(K)
        model.operator_kind = constants[kind]
        return model, (K, HN, HT), solve

    def _call(self, name: str, *arguments: Any, solve: Any = None) -> int:
        """Calls the library; raises what the host's solver or the handler of a signal has raised.
        After an Error the host's solver is `solve` again."""
        def attempt(*given: Any) -> int:
            try:
                return call(*given)
            except Error:
                self._host.solve = solve or self._host.solve
                raise

        self._host.callback.begin()
        try:
            return self._watch.call(name, *arguments, by=attempt)
        finally:
            self._host.callback.end()

    def __del__(self) -> None:
        if getattr(self, "_held", None):
            lib.dls_reduction_destroy(self._held)

    def update(self, K: Stiffness, HN: Matrix, HT: Matrix | None = None) -> None:
        """Takes new values of K, HN, HT on the old pattern; loads become 0. After an Error for
        other sizes or another pattern the reduction is unchanged."""
        model, kept, solve = self._model(K, HN, HT)
        before, self._host.solve = self._host.solve, solve
        self._loaded += 1
        self._given = [False, False]
        self._updated += 1
        self._call("dls_reduction_update", self._held, byref(model), solve=before)
        self._matrix = kept[0]
        self._on_body = Surface(kept[0], kept[1], kept[2], self._on_body.d, self._on_body.X)

    def move(self, HN: Matrix, HT: Matrix | None = None, *, P: Matrix | None = None,
             mu: Array | None = None, active: Array | None = None,
             g: Array | None = None) -> None:
        """Takes new contacts, any number, on the K that is factorised: HN and HT touch unknowns of
        `surface`. The load stays, g is new. After an Error the reduction is unchanged."""
        if not self._surface:
            raise ValueError("the reduction was made without surface")
        if (HT is not None) != self._has_tangents:
            raise ValueError("HT is missing" if HT is None else
                             "HT is given, but the reduction was made without it")
        check_tangents(HT, mu)
        d, N, T = operators(HN, HT, self._d)
        weights, friction, on = self._sides(N, P, mu, active)
        model = structs["dls_model"](d=d, n=N.shape[0], nodes=N.shape[1], HN=sparse(N), HT=sparse(T),
                                     P=sparse(weights), mu=address(friction), active=address(on))
        gaps = None if g is None else vector("g", g, d * N.shape[1], d)
        self._loaded += 1
        self._updated += 1
        self._call("dls_reduction_move", self._held, byref(model), address(gaps))
        self._options = (weights, friction, on, *self._options[3:])
        self._on_body = Surface(self._matrix, N, T, self._on_body.d, self._on_body.X)
        self._count(model, weights, on)

    def load(self, f: Array | None = None, g: Array | None = None) -> None:
        """Sets loads f (n) and gaps g (nodes x d; without HT one for each node): q := H^T K^-1 f +
        g."""
        f, g = self._loads(f, g)
        self._loaded += 1
        self._given, self._fresh = [f is not None, g is not None], True
        self._call("dls_reduction_load", self._held, address(f), address(g))

    def load_free(self, x_free: Array | None, g: Array | None = None) -> None:
        """Sets x_free = K^-1 f, which you have computed, in place of f."""
        x_free, g = self._loads(x_free, g)
        self._loaded += 1
        self._given, self._fresh = [x_free is not None, g is not None], True
        self._call("dls_reduction_load_free", self._held, address(x_free), address(g))

    def _loads(self, f: Any, g: Any) -> tuple[Vector | None, Vector | None]:
        return (None if f is None else vector("f", f, self.n),
                None if g is None else gaps("g", g, self._nodes, self.d, self._d))

    def solve(self, mu: Array | None = None, f: Array | None = None, g: Array | None = None, *,
              method: str = "auto", tol: float | None = None, max_iterations: int | None = None,
              cpu_seconds: float | None = None, r0: Array | None = None,
              acceleration: str | None = None, facets: int | None = None,
              positive_definite: int | None = None, history: bool = False,
              progress: Callable[[Progress], object] | None = None,
              threads: int | None = None, plan: str | None = None, without: str | None = None,
              timed: bool = False, forces: str = "any") -> Solution:
        """Loads f and g if one is given, and solves for r and x; options as in solve(). The
        certificate is that of the body (dls_reduction_solve)."""
        check_tangents(self._has_tangents or None, mu)
        before = self._given
        if f is not None or g is not None:
            self.load(f, g)
        notes = self._missing(f, g, mu, before)
        problem, mu = self._contact(mu) if self.on == "W" else self._sizes(mu)
        x = np.zeros(self.n)
        self._host.callback.begin()
        try:
            solution = solve_problem(
                problem, method=method, tol=tol, max_iterations=max_iterations,
                cpu_seconds=cpu_seconds, r0=r0, acceleration=acceleration, facets=facets,
                positive_definite=positive_definite, history=history, progress=progress,
                threads=threads, plan=plan, without=without, timed=timed, forces=forces,
                body=(self._held, address(mu), x))
        finally:
            self._host.callback.end()
        solution.x = x
        solution.notes = notes
        plain = self._options[0] is None and self._options[2] is None
        solution._surface = self._on_body
        solution._nodal = solution.r if plain else self.nodal(solution.r)
        loaded, updated = self._loaded, self._updated

        def derivative(of: Solution, side: int, made: Derivative | None) -> Derivative:
            if made is not None and self._updated == updated:
                return made
            if self._loaded != loaded:
                raise ValueError("the reduction has taken another load or K since this solution")
            assert of.x is not None
            return Derivative(
                "dls_derive_create_body", self._held, address(mu), address(of.r), address(of.x),
                side, d=self.d, nc=self.candidates, r=of.r, x=of.x.copy(), matrix=self._matrix,
                nodes=(self._nodes, self._d), kept=(self, mu))

        solution._of_body = derivative
        return solution

    def limit(self, f1: Array | None, mu: Array | None = None, f: Array | None = None,
              g: Array | None = None, *, mu1: Array | None = None, start: float = 0.0,
              to: float = np.inf, tol: float | None = None, most: int | None = None) -> "Limit":
        """Finds how much is carried: loads f + lambda f1 (n), friction mu + lambda mu1, gaps g, from
        lambda = start, which has an answer, towards `to` (dls_limit_load)."""
        check_tangents(self._has_tangents or None, mu)
        f, g = self._loads(f, g)
        f1 = None if f1 is None else vector("f1", f1, self.n)
        mu = vector("mu", 0.0 if mu is None else mu, self.candidates)
        mu1 = None if mu1 is None else vector("mu1", mu1, self.candidates)
        settings, found = structs["dls_limit_settings"](), structs["dls_limit"]()
        lib.dls_limit_settings_init(byref(settings))
        set_fields(settings, {"from": start, "tol": tol, "most": most})
        settings.to = float(to)
        self._watch.set(settings.limits)
        r, x, motion = np.zeros((self.candidates, self.d)), np.zeros(self.n), np.zeros(self.n)
        self._loaded += 1
        self._given, self._fresh = [True, g is not None], False  # the load of some trial
        status = self._call("dls_limit_load", self._held, address(f), address(f1), address(g),
                            address(mu), address(mu1), byref(settings), address(r), address(x),
                            address(motion), byref(found))
        return Limit(found.carried, found.refused, bool(found.proved), found.open, found.solves,
                     lib.dls_status_text(status).decode(), r, x, motion if found.proved else None)

    def _missing(self, f: Any, g: Any, mu: Any, before: list[bool]) -> list[str]:
        """Returns what a solve was not given, and what it takes instead."""
        notes = []
        if not self._given[0]:
            notes.append("no loads: f is not given")
        elif not self._fresh:
            notes.append("f and g are those of the load before")
        if f is not None and g is None and before[1]:
            notes.append("gaps are 0: g is not given, and those of the load before are gone")
        if not self._has_tangents:
            notes.append("no friction: HT is not given")
        elif mu is None and self._options[1] is None:
            notes.append("no friction: mu is not given")
        self._fresh = False
        return notes

    def _contact(self, mu: Any) -> tuple[Any, Vector | None]:
        """Returns the dls_contact of the active candidates, and the friction that it views."""
        problem = structs["dls_contact"]()
        if mu is None and self._options[1] is not None:
            call("dls_reduction_contact", self._held, None, byref(problem))
            return problem, None
        mu = vector("mu", 0.0 if mu is None else mu, self.candidates)
        call("dls_reduction_contact", self._held, address(mu), byref(problem))
        return problem, mu

    def _sizes(self, mu: Any) -> tuple[Any, Vector | None]:
        """Returns a dls_contact that has sizes alone, and the friction, for the problem on K."""
        problem = structs["dls_contact"](d=self.d, nc=self.candidates)
        if mu is None and self._options[1] is not None:
            return problem, None
        return problem, vector("mu", 0.0 if mu is None else mu, self.candidates)

    @property
    def on(self) -> str:
        return "K" if self.info["on"] == constants["DLS_ON_K"] else "W"

    @property
    def W(self) -> Vector:
        p, _ = self._contact(None)
        W = read(c_double, p.W.a, p.W.ld * self.m, self).reshape(self.m, p.W.ld).T[:self.m]
        return W.copy() if self._surface else W

    @property
    def q(self) -> Vector:
        p, _ = self._contact(None)
        q = read(c_double, p.q, self.m, self).reshape(-1, self.d)
        return q.copy() if self._surface else q

    def recover(self, r: Array) -> Vector:
        """Returns x = K^-1 (f + H r)."""
        r, x = vector("r", r, self.m, self.d), np.zeros(self.n)
        self._call("dls_reduction_recover", self._held, address(r), address(x))
        return x

    def nodal(self, r: Array) -> Vector:
        """Returns P r, nodes x d: the nodal reactions of weighted r."""
        r, R = vector("r", r, self.m, self.d), np.zeros((self._nodes, self._d))
        self._call("dls_reduction_nodal", self._held, address(r), address(R))
        return R[:, :self.d]

    def certify(self, r: Array, x: Array, mu: Array | None = None) -> Certificate:
        """Measures the pair (x, r) on the body: returns its Certificate."""
        r, x = vector("r", r, self.m, self.d), vector("x", x, self.n)
        _, mu = self._sizes(mu)
        certificate = structs["dls_certificate"]()
        self._call("dls_reduction_certify", self._held, address(mu), address(r), address(x), None,
                   byref(certificate))
        return _certificate(certificate)

    @property
    def info(self) -> dict[str, Any]:
        info = structs["dls_reduction_info"]()
        call("dls_reduction_get_info", self._held, byref(info))
        return {name: getattr(info, name) for name, _ in info._fields_}


def reduce(K: Stiffness, HN: Matrix, HT: Matrix | None = None, *, P: Matrix | None = None,
           mu: Array | None = None, active: Array | None = None,
           factorization: str | None = None, flexibility: bool = False, d: int | None = None,
           memory_limit: float = 0, on: str | None = None, loads: int = 1,
           surface: Array | None = None, coordinates: Array | None = None) -> Reduction:
    """Returns a Reduction: factorises K and forms W = H^T K^-1 H, or keeps the problem on K.

    K       n x n, numpy or scipy.sparse; or a function that returns K^-1 B for B (n x k), such as
            scipy.sparse.linalg.splu(K).solve; with flexibility=True K^-1, dense
    HN, HT  n x nodes and n x (d-1) nodes: normal and tangents of each contact node; HT None: no
            friction, d = 1, r and g have one entry for each contact
    P       weighting, nodes x candidates
    mu      friction of each contact; the tangents of contacts with 0 are left out
    active  one for each contact: 0 leaves it out
    factorization   "cholesky", "ldlt", "lu"; None: lu if K is not symmetric to the last bit, else
            cholesky, or ldlt if that finds a negative pivot
    on      "W": few contacts, any method, W and recover(); "K": contact over whole surfaces, bodies
            that contact alone holds, solve() by method auto; None: the lower estimated cost for
            `loads` solves, K if it is singular or W exceeds memory_limit (bytes)
    coordinates   nodes x d: unknown d k + i is direction i of node k; for the moments of
            Solution.sums() and for Solution.write_vtu()
    surface unknowns that HN and HT of move() may touch, besides those of this HN and HT
    """
    if on not in (None, "W", "K"):
        raise ValueError(f"on is {on!r}, must be 'W', 'K' or None")
    place = constants["DLS_ON_EITHER" if on is None else "DLS_ON_" + on]
    return Reduction(K, HN, HT, P, mu, active, factorization, flexibility, d,
                     {"memory_limit": memory_limit, "on": place,
                      "loads": loads}, surface, coordinates)
