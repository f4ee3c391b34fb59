"""From K, H_N, H_T to the contact problem and back: K x = f + H r, u = H^T x + g."""

from ctypes import byref, c_double, c_void_p, cast

import numpy as np
import scipy.sparse as sp

from ._library import (SOLVE_FN, address, call, columns, constants, dense, entries, lib, read,
                       sparse, structs, vector)
from .contact import solve_problem

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
    HN = columns(HN)
    HT = columns(HT if HT is not None else np.zeros((HN.shape[0], ((d or 2) - 1) * HN.shape[1])))
    found = HT.shape[1] // HN.shape[1] + 1 if HN.shape[1] else d or 2
    if found not in (2, 3) or HT.shape != (HN.shape[0], (found - 1) * HN.shape[1]):
        raise ValueError(f"HT is {HT.shape}, HN {HN.shape}: HT has d - 1 columns for one of HN")
    return found, HN, HT


class Reduction:
    """K factored and W formed; made by reduce().

    d, n, m, candidates   sizes: m = d candidates rows of W
    W, q                  of the contact problem, read-only views of the library's arrays
    info                  memory, condition, rigid-body modes
    """

    def __init__(self, K, HN, HT, P, mu, active, modes, factorization, flexibility, d, settings):
        self._held = c_void_p()
        self._exception = None
        model = self._model(K, HN, HT, P, mu, active, modes, factorization, flexibility, d)
        create = structs["dls_reduction_settings"]()
        lib.dls_reduction_settings_init(byref(create))
        create.allow_indefinite = factorization is None
        for name, value in settings.items():
            setattr(create, name, value)
        self._call("dls_reduction_create_with", byref(self._held), byref(model), byref(create))
        self._options = (P, mu, active, modes, factorization, flexibility, d)

    def _model(self, K, HN, HT, P, mu, active, modes, factorization, flexibility, d):
        """Returns a dls_model; self._kept holds what it views."""
        self.d, HN, HT = operators(HN, HT, d)
        self.n = HN.shape[0]
        nodes = HN.shape[1]
        P = None if P is None else columns(P)
        candidates = nodes if P is None else P.shape[1]
        mu = None if mu is None else vector("mu", mu, candidates)
        active = None if active is None else np.ascontiguousarray(active, dtype=np.intc).reshape(-1)
        if active is not None and active.size != candidates:
            raise ValueError(f"active has {entries(active)}, needs {candidates}")
        modes = None if modes is None else np.asfortranarray(modes, dtype=np.float64)
        if modes is not None and (modes.ndim != 2 or modes.shape[0] != self.n):
            raise ValueError(f"modes is {modes.shape}, needs {self.n} rows")
        model = structs["dls_model"](d=self.d, n=self.n, nodes=nodes, HN=sparse(HN), HT=sparse(HT),
                                     P=sparse(P), mu=address(mu), active=address(active))
        if modes is not None:
            model.modes = dense(modes)
        if callable(K):
            kind = "DLS_HOST_SOLVER"
            K = SOLVE_FN(self._host_solve(K))
            model.solve = cast(K, c_void_p).value
        else:
            if K.shape != (self.n, self.n):
                raise ValueError(f"K is {K.shape}, HN has {self.n} rows")
            model.factorization = find_factorization("lu" if flexibility else factorization, K)
            if hasattr(K, "tocsc") and not flexibility:
                kind, K = "DLS_STIFFNESS_SPARSE", columns(K)
                model.Ks = sparse(K)
            else:
                kind = "DLS_FLEXIBILITY" if flexibility else "DLS_STIFFNESS_DENSE"
                K = np.asfortranarray(K.toarray() if hasattr(K, "tocsc") else K, dtype=np.float64)
                model.K = dense(K)
        model.operator_kind = constants[kind]
        self._kept = (K, HN, HT, P, mu, active, modes)
        return model

    def _host_solve(self, solve):
        def callback(_, X, n, nrhs):
            try:
                B = np.ctypeslib.as_array(X, shape=(nrhs, n)).T
                B[:] = np.reshape(solve(B.copy(order="F")), (n, nrhs))
                return 0
            except BaseException as exception:  # must not run through C
                self._exception = exception
                return 1
        return callback

    def _call(self, name, *arguments):
        """Calls the library; an exception of the host's solver comes out as it is."""
        self._exception = None
        try:
            return call(name, *arguments)
        finally:
            if self._exception:
                raise self._exception

    def __del__(self):
        if getattr(self, "_held", None):
            lib.dls_reduction_destroy(self._held)

    def update(self, K, HN, HT=None):
        """Takes new values of K, HN, HT on the old pattern; loads become 0."""
        model = self._model(K, HN, HT, *self._options)
        self._call("dls_reduction_update", self._held, byref(model))

    def load(self, f=None, g=None):
        """Takes loads f (n) and gaps g (nodes x d): q := H^T K^-1 f + g."""
        f, g = self._loads(f, g)
        self._call("dls_reduction_load", self._held, address(f), address(g))

    def load_free(self, x_free, g=None):
        """Takes K^-1 f instead of f, from a host that has it."""
        x_free, g = self._loads(x_free, g)
        self._call("dls_reduction_load_free", self._held, address(x_free), address(g))

    def _loads(self, f, g):
        nodes = self._kept[1].shape[1]
        return (None if f is None else vector("f", f, self.n),
                None if g is None else vector("g", g, self.d * nodes))

    def solve(self, mu=None, f=None, g=None, **options):
        """Loads f and g if one is given, solves for r, recovers x; options as in solve()."""
        if f is not None or g is not None:
            self.load(f, g)
        problem, mu = self._contact(mu)
        solution = solve_problem(problem, **options)
        solution.x = self.recover(solution.r)
        del mu
        return solution

    def _contact(self, mu):
        """Returns the dls_contact of the active candidates, and the friction that it views."""
        problem = structs["dls_contact"]()
        if mu is None and self._kept[4] is not None:
            call("dls_reduction_contact", self._held, None, byref(problem))
            return problem, None
        mu = vector("mu", 0.0 if mu is None else mu, self.candidates)
        call("dls_reduction_contact", self._held, address(mu), byref(problem))
        return problem, mu

    @property
    def candidates(self):
        _, HN, _, P, _, active, _ = self._kept
        if active is not None:
            return int(np.count_nonzero(active))
        return HN.shape[1] if P is None else P.shape[1]

    @property
    def m(self):
        return self.d * self.candidates

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
        r, x = vector("r", r, self.m), np.zeros(self.n)
        self._call("dls_reduction_recover", self._held, address(r), address(x))
        return x

    def nodal(self, r):
        """Returns P r, nodes x d: the nodal reactions that weighted r stand for."""
        r, R = vector("r", r, self.m), np.zeros((self._kept[1].shape[1], self.d))
        self._call("dls_reduction_nodal", self._held, address(r), address(R))
        return R

    def balance(self, r):
        """Takes what the springs of held rigid-body modes carry out of q; returns the imbalance."""
        r, imbalance = vector("r", r, self.m), c_double()
        self._call("dls_reduction_balance", self._held, address(r), byref(imbalance))
        return imbalance.value

    @property
    def info(self):
        info = structs["dls_reduction_info"]()
        call("dls_reduction_get_info", self._held, byref(info))
        return {name: getattr(info, name) for name, _ in info._fields_}


def reduce(K, HN, HT=None, *, P=None, mu=None, active=None, modes=None, factorization=None,
           flexibility=False, d=None, stabilize=False, memory_limit=0):
    """Factors K and forms W = H^T K^-1 H; returns a Reduction.

    K       n x n, numpy or scipy.sparse; or a function that returns K^-1 B for B (n x k), such as
            scipy.sparse.linalg.splu(K).solve; with flexibility=True K^-1, dense
    HN, HT  n x nodes and n x (d-1) nodes: normal and tangents of each contact node; HT None: d = 2
            without friction
    P       weighting, nodes x candidates
    mu      friction of each candidate; where it is 0 the tangents are left out
    active  candidates: 0 leaves one out
    factorization   "cholesky", "ldlt", "lu"; None: lu if K is not symmetric to the last bit, else
            cholesky, or ldlt where that meets a negative pivot
    modes, stabilize   rigid-body motions, given or looked for
    """
    return Reduction(K, HN, HT, P, mu, active, modes, factorization, flexibility, d,
                     {"stabilize": bool(stabilize), "memory_limit": float(memory_limit)})
