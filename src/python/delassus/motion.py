"""Bodies that move: the theta scheme with contact and friction, and paths of equilibria."""

from ctypes import byref, c_double, c_int, c_void_p

import numpy as np

from ._library import (Owner, address, call, columns, constants, lib, number, read, set_fields,
                       sparse, structs, vector)
from .contact import Solution, Watch, find_method, set_limits
from .reduction import find_factorization, operators

_LAWS = {"velocity": "DLS_MOTION_VELOCITY", "gap": "DLS_MOTION_GAP", "path": "DLS_MOTION_PATH"}


class Motion(Owner):
    """Bodies M v' + C v + K x = f + H p/h with contact, as delassus/motion.h has them.

    Motion(K, HN, HT, M=M, h=1e-3)           impacts; restitution, activation, theta: see motion.h
    Motion(K, HN, HT, M=M, h=h, law="gap", theta=1)
    Motion(K, HN, HT, law="path")            equilibria, one after the other

    step(f, y, mu) takes a step and returns the Solution of its contact problem, or None where no
    candidate was closed. The state after the last certified step: t, steps, x, v (n), p, u
    (candidates x d), gap, slip, states.
    """

    def __init__(self, K, HN, HT=None, *, M=None, C=None, P=None, gap=None, h=1.0, law="velocity",
                 method="auto", factorization=None, tol=None, max_iterations=None, d=None,
                 **settings):
        self._held = c_void_p()
        # copies: the library goes on reading them
        M, C, K, P, HN, HT = (
            None if A is None else columns(name, A).copy()
            for name, A in (("M", M), ("C", C), ("K", K), ("P", P), ("HN", HN), ("HT", HT)))
        self.d, HN, HT = operators(HN, HT, d)
        self.n = HN.shape[0]
        if factorization is None:
            given = [A for A in (M, C, K) if A is not None]
            kinds = {find_factorization(None, A) for A in given}
            kind = constants["DLS_LU" if constants["DLS_LU"] in kinds else "DLS_CHOLESKY"]
        else:
            kind = find_factorization(factorization, K)
        if law not in _LAWS:
            raise ValueError(f"no law {law!r}: velocity, gap or path")
        self._nodes = HN.shape[1]
        self._candidates = self._nodes if P is None else P.shape[1]
        gap = None if gap is None else vector("gap", gap, self._nodes).copy()
        model = structs["dls_motion_model"](
            d=self.d, n=self.n, nodes=self._nodes, factorization=kind, M=sparse(M), C=sparse(C),
            K=sparse(K), HN=sparse(HN), HT=sparse(HT), P=sparse(P), gap=address(gap))
        self._kept = (M, C, K, HN, HT, P, gap)
        create = structs["dls_motion_settings"]()
        lib.dls_motion_settings_init(byref(create))
        create.law, create.method = constants[_LAWS[law]], find_method(method)
        create.h = number("h", h)
        self._watch = Watch()
        set_limits(create.limits, self._watch, tol, max_iterations)
        set_fields(create, settings)
        call("dls_motion_create", byref(self._held), byref(model), byref(create))

    def __del__(self):
        if getattr(self, "_held", None):
            lib.dls_motion_destroy(self._held)

    def start(self, x=None, v=None, t=0.0):
        """Starts anew from x and v at time t."""
        x = None if x is None else vector("x", x, self.n)
        v = None if v is None else vector("v", v, self.n)
        call("dls_motion_start", self._held, address(x), address(v), number("t", t))

    def step(self, f=None, y=None, mu=None):
        """Takes a step under loads f (n), velocities y of the obstacle (nodes x d), friction mu."""
        f = None if f is None else vector("f", f, self.n)
        y = None if y is None else vector("y", y, self.d * self._nodes, self.d)
        mu = None if mu is None else vector("mu", mu, self._candidates)
        info, problem = structs["dls_info"](), structs["dls_contact"]()
        status = self._watch.call("dls_motion_step", self._held, address(f), address(y),
                                  address(mu), byref(info))
        call("dls_motion_get_problem", self._held, byref(problem))
        if status:
            raise NotCertified(status)
        if not problem.nc:
            return None
        active = read(c_int, self._state().active_list, problem.nc, self)
        r, u = self.p[active].reshape(-1), np.zeros(self.d * problem.nc)
        call("dls_contact_certify", byref(problem), address(r), address(u),
             byref(structs["dls_certificate"]()))
        solution = Solution(problem, info, status, r, u, None)
        solution.x = self.x
        return solution

    def set_h(self, h):
        """Changes the step from the next one on."""
        call("dls_motion_set_h", self._held, number("h", h))

    def _state(self):
        state = structs["dls_motion_state"]()
        call("dls_motion_get_state", self._held, byref(state))
        return state

    def _array(self, name, kind, size):
        return read(kind, getattr(self._state(), name), size, self).copy()

    t = property(lambda self: self._state().t)
    steps = property(lambda self: self._state().steps)
    x = property(lambda self: self._array("x", c_double, self.n))
    v = property(lambda self: self._array("v", c_double, self.n))
    p = property(lambda self: self._local("p"))
    u = property(lambda self: self._local("u"))
    gap = property(lambda self: self._array("gap", c_double, self._candidates))

    def _local(self, name):
        return self._array(name, c_double, self.d * self._candidates).reshape(-1, self.d)

    @property
    def slip(self):
        tangents = self.d - 1
        return self._array("slip", c_double, tangents * self._candidates).reshape(-1, tangents)

    @property
    def states(self):
        return np.array(["free", "slip", "stick"])[self._array("state", c_int, self._candidates)]

    @property
    def energies(self):
        """Energies and works since the start, by the names of dls_motion_energies."""
        energies = structs["dls_motion_energies"]()
        call("dls_motion_get_energies", self._held, byref(energies))
        return {name: getattr(energies, name) for name, _ in energies._fields_}


class NotCertified(RuntimeError):
    """A step whose contact problem was not solved: the state is that of the step before."""

    def __init__(self, status):
        super().__init__(status)
        self.status = status

    def __str__(self):
        return "the contact problem of the step: " + lib.dls_status_text(self.status).decode()
