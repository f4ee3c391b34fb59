"""From K, H_N, H_T to the contact problem and back: K x = f + H r, u = H^T x + g."""

import weakref
from ctypes import byref, c_double, c_int, c_size_t, c_void_p

import numpy as np
import scipy.sparse as sp

from ._library import (Callback, Error, Owner, address, call, columns, constants, dense, entries,
                       integers, lib, read, reals, set_fields, sparse, structs, vector)
from .contact import Watch, solve_problem

_FACTORIZATIONS = {"cholesky": "DLS_CHOLESKY", "ldlt": "DLS_LDLT", "lu": "DLS_LU"}


def is_symmetric(K):
    """Tells whether K equals its transpose but for the rounding of an assembly, as the program
    does (src/cli/arrays.c)."""
    K = sp.coo_matrix(K)
    size = np.sqrt(np.abs(K.diagonal()))
    apart = (K - K.T).tocoo()
    return bool(np.all(np.abs(apart.data) <= 1e-12 * size[apart.row] * size[apart.col]))


def find_factorization(name, K):
    if name is None:
        name = "cholesky" if is_symmetric(K) else "lu"
        if name == "lu" and sp.tril(K, -1).nnz == 0:
            raise ValueError("K is an upper triangle; a symmetric K is wanted whole, or "
                             "factorization='lu' takes it as it stands")
    if name not in _FACTORIZATIONS:
        raise ValueError(f"no factorization {name!r}: cholesky, ldlt or lu")
    return constants[_FACTORIZATIONS[name]]


def operators(HN, HT, d=None):
    """Returns d, HN and HT as compressed columns; without HT there is no tangent: d = 2, zeros."""
    if d not in (None, 2, 3):
        raise ValueError(f"d is {d!r}, must be 2 or 3")
    HN = columns("HN", HN)
    if HT is None:
        HT = np.zeros((HN.shape[0], ((d or 2) - 1) * HN.shape[1]))
    HT = columns("HT", HT)
    found = HT.shape[1] // HN.shape[1] + 1 if HN.shape[1] else d or 2
    if found not in (2, 3) or HT.shape != (HN.shape[0], (found - 1) * HN.shape[1]):
        raise ValueError(f"HT is {HT.shape}, HN {HN.shape}: HT has d - 1 columns for one of HN")
    return found, HN, HT


class _Host:
    """The function that solves with K where the host has one: one callback of C for the life of a
    reduction, whichever function is at hand."""

    def __init__(self):
        self.solve = None
        this = weakref.ref(self)

        def run(_, X, n, nrhs):
            B = np.frombuffer((c_double * (n * nrhs)).from_address(X)).reshape(nrhs, n).T
            answer = reals("K^-1 B", this().solve(B.copy(order="F")))
            if answer.shape != B.shape and not (nrhs == 1 and answer.shape == (n,)):
                raise ValueError(f"K^-1 B is {answer.shape}, must be {B.shape}")
            B[:] = answer.reshape(B.shape)

        self.callback = Callback(run, c_size_t, c_size_t, c_int, c_int)


class Reduction(Owner):
    """K factored and W formed, or the problem on K itself; made by reduce().

    d, n, m, candidates   sizes: m = d candidates rows of W
    W, q                  of the contact problem, read-only views of the library's arrays; not on K
    on                    "W" or "K": where solve() works
    info                  memory, condition, rigid-body modes
    """

    def __init__(self, K, HN, HT, P, mu, active, modes, factorization, flexibility, d, settings):
        self._held = c_void_p()
        self._host = _Host()
        self._watch = Watch()
        HN = columns("HN", HN)
        nodes = HN.shape[1]
        P = None if P is None else columns("P", P).copy()
        candidates = nodes if P is None else P.shape[1]
        # copies: update() takes them once more
        mu = None if mu is None else vector("mu", mu, candidates).copy()
        if active is not None:
            active = (integers("active", active) != 0).astype(np.intc).reshape(-1)
            if active.size != candidates:
                raise ValueError(f"active has {entries(active)}, needs {candidates}")
        modes = None if modes is None else np.array(reals("modes", modes), order="F")
        if modes is not None and (modes.ndim != 2 or modes.shape[0] != HN.shape[0]):
            raise ValueError(f"modes is {modes.shape}, needs {HN.shape[0]} rows")
        self._options = (P, mu, active, modes, factorization, flexibility, d)
        model, kept, solve = self._model(K, HN, HT)
        create = structs["dls_reduction_settings"]()
        lib.dls_reduction_settings_init(byref(create))
        create.allow_indefinite = factorization is None
        set_fields(create, settings)
        self._watch.set(create)
        self._host.solve = solve
        self._call("dls_reduction_create_either", byref(self._held), byref(model), byref(create))
        del kept  # the library has copied it
        # the sizes that the library holds: no update changes them
        self.d, self.n, self._nodes = model.d, model.n, nodes
        self.candidates = candidates if active is None else int(np.count_nonzero(active))
        self.m = self.d * self.candidates

    def _model(self, K, HN, HT):
        """Returns a dls_model, what it views, and K where that is a function; changes nothing."""
        P, mu, active, modes, factorization, flexibility, d = self._options
        d, HN, HT = operators(HN, HT, d)
        n, nodes = HN.shape
        model = structs["dls_model"](d=d, n=n, nodes=nodes, HN=sparse(HN), HT=sparse(HT),
                                     P=sparse(P), mu=address(mu), active=address(active))
        if modes is not None:
            model.modes = dense(modes)
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

    def _call(self, name, *arguments, solve=None):
        """Calls the library; raises what the host's solver or the handler of a signal has raised.
        After an Error the host's solver is `solve` again."""
        def attempt(*given):
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

    def __del__(self):
        if getattr(self, "_held", None):
            lib.dls_reduction_destroy(self._held)

    def update(self, K, HN, HT=None):
        """Takes new values of K, HN, HT on the old pattern; loads become 0. After an Error for
        other sizes or another pattern the reduction is as it was."""
        model, kept, solve = self._model(K, HN, HT)
        before, self._host.solve = self._host.solve, solve
        self._call("dls_reduction_update", self._held, byref(model), solve=before)
        del kept

    def load(self, f=None, g=None):
        """Takes loads f (n) and gaps g (nodes x d): q := H^T K^-1 f + g."""
        f, g = self._loads(f, g)
        self._call("dls_reduction_load", self._held, address(f), address(g))

    def load_free(self, x_free, g=None):
        """Takes K^-1 f instead of f, from a host that has it."""
        x_free, g = self._loads(x_free, g)
        self._call("dls_reduction_load_free", self._held, address(x_free), address(g))

    def _loads(self, f, g):
        return (None if f is None else vector("f", f, self.n),
                None if g is None else vector("g", g, self.d * self._nodes, self.d))

    def solve(self, mu=None, f=None, g=None, **options):
        """Loads f and g if one is given, solves for r and x; options as in solve(). Solved is said
        of the body (dls_reduction_solve): what springs of held modes carry is missing."""
        if f is not None or g is not None:
            self.load(f, g)
        problem, mu = self._contact(mu) if self.on == "W" else self._sizes(mu)
        x = np.zeros(self.n)
        self._host.callback.begin()
        try:
            solution = solve_problem(problem, body=(self._held, address(mu), x), **options)
        finally:
            self._host.callback.end()
        solution.x = x
        return solution

    def _contact(self, mu):
        """Returns the dls_contact of the active candidates, and the friction that it views."""
        problem = structs["dls_contact"]()
        if mu is None and self._options[1] is not None:
            call("dls_reduction_contact", self._held, None, byref(problem))
            return problem, None
        mu = vector("mu", 0.0 if mu is None else mu, self.candidates)
        call("dls_reduction_contact", self._held, address(mu), byref(problem))
        return problem, mu

    def _sizes(self, mu):
        """Returns a dls_contact that has sizes alone, and the friction, for the problem on K."""
        problem = structs["dls_contact"](d=self.d, nc=self.candidates)
        if mu is None and self._options[1] is not None:
            return problem, None
        return problem, vector("mu", 0.0 if mu is None else mu, self.candidates)

    @property
    def on(self):
        return "K" if self.info["on"] == constants["DLS_ON_K"] else "W"

    @property
    def W(self):
        p, _ = self._contact(None)
        return read(c_double, p.W.a, p.W.ld * self.m, self).reshape(self.m, p.W.ld).T[:self.m]

    @property
    def q(self):
        p, _ = self._contact(None)
        return read(c_double, p.q, self.m, self).reshape(-1, self.d)

    def recover(self, r):
        """Returns x = K^-1 (f + H r)."""
        r, x = vector("r", r, self.m, self.d), np.zeros(self.n)
        self._call("dls_reduction_recover", self._held, address(r), address(x))
        return x

    def nodal(self, r):
        """Returns P r, nodes x d: the nodal reactions that weighted r stand for."""
        r, R = vector("r", r, self.m, self.d), np.zeros((self._nodes, self.d))
        self._call("dls_reduction_nodal", self._held, address(r), address(R))
        return R

    def balance(self, r):
        """Takes what the springs of held rigid-body modes carry out of q; returns the imbalance."""
        r, imbalance = vector("r", r, self.m, self.d), c_double()
        self._call("dls_reduction_balance", self._held, address(r), byref(imbalance))
        return imbalance.value

    @property
    def info(self):
        info = structs["dls_reduction_info"]()
        call("dls_reduction_get_info", self._held, byref(info))
        return {name: getattr(info, name) for name, _ in info._fields_}


def reduce(K, HN, HT=None, *, P=None, mu=None, active=None, modes=None, factorization=None,
           flexibility=False, d=None, stabilize=False, memory_limit=0, on=None, loads=1):
    """Factors K and forms W = H^T K^-1 H, or takes the problem on K; returns a Reduction.

    K       n x n, numpy or scipy.sparse; or a function that returns K^-1 B for B (n x k), such as
            scipy.sparse.linalg.splu(K).solve; with flexibility=True K^-1, dense
    HN, HT  n x nodes and n x (d-1) nodes: normal and tangents of each contact node; HT None: d = 2
            without friction
    P       weighting, nodes x candidates
    mu      friction of each candidate; where it is 0 the tangents are left out
    active  candidates: 0 leaves one out
    factorization   "cholesky", "ldlt", "lu"; None: lu if K is not symmetric to the last bit, else
            cholesky, or ldlt where that meets a negative pivot
    modes, stabilize   rigid-body motions, given or looked for: solved on K
    on      "W": few contacts, any method, W and recover(); "K": contact over whole surfaces, bodies
            that contact alone holds, solve() by method auto; None: the cheaper one for so many
            loads, K where it is singular or W exceeds memory_limit (bytes)
    """
    if on not in (None, "W", "K"):
        raise ValueError(f"on is {on!r}, must be 'W', 'K' or None")
    place = constants["DLS_ON_EITHER" if on is None else "DLS_ON_" + on]
    return Reduction(K, HN, HT, P, mu, active, modes, factorization, flexibility, d,
                     {"stabilize": bool(stabilize), "memory_limit": memory_limit, "on": place,
                      "loads": loads})
