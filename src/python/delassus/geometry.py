"""H and gaps from two meshes (delassus/pairs.h), and from rigid bodies (delassus/rigid.h)."""

from __future__ import annotations

from ctypes import byref, c_double, c_int
from typing import Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from ._library import (Array, Vector, address, call, integers, lib, number, read, reals, structs,
                       vector, whole)

PAIR_STATES = np.array(["found", "far", "beside", "shared", "held"])


class Pairs(NamedTuple):
    """Operators from two meshes: reduce(K, HN, HT, P=P).solve(mu, f, g)."""

    HN: Any                       # n x nodes, scipy's compressed columns
    HT: Any                       # n x (d-1) nodes
    P: Any                        # nodes x candidates with own, else None
    g: Vector                     # nodes x d: gap, 0[, 0]
    frame: Vector                 # nodes x d x d: rows n, t[, s]
    node: npt.NDArray[np.intc]    # candidates: their nodes
    face: npt.NDArray[np.intc]    # nodes: row of `face`, -1 for the wall
    measure: Optional[Vector]     # candidates, with own: r / measure is the pressure
    state: Optional[npt.NDArray[np.str_]]  # of each of `node`: found, far, beside, shared, held


def pairs(X: Array, node: Any = None, face: Any = None, *, own: Any = None,
          wall: Array | None = None, dof: Any = None, n: int | None = None, base: int = 0,
          reach: float = 0.0) -> Pairs:
    """Returns the Pairs of the nodes of one body with the faces of another one.

    X      nodes x d: where the nodes of both bodies are
    node   numbers of the nodes that may touch
    face   faces x corners: edges (a, b) with their body to the left; T3 or Q4, counterclockwise
           as seen from outside
    own    faces of your body in place of node: mortar, with P
    wall   (point, normal) of a fixed plane in place of face
    dof    nodes x d: the unknown of each direction, -1: held; None: d node + k
    n      number of unknowns; None: those of dof, or of X
    base   number of the first node, 0 or 1
    reach  largest |gap|; 0: the largest extent of a face
    """
    place = np.ascontiguousarray(reals("X", X))
    if place.ndim != 2 or place.shape[1] not in (2, 3):
        raise ValueError(f"X is {place.shape}, needs a row of 2 or 3 for each node")
    d = place.shape[1]
    s = structs["dls_surfaces"](d=d, points=len(place), base=whole("base", base),
                                X=address(place), reach=number("reach", reach))
    kept: list[Any] = [place]
    if dof is not None:
        kept.append(integers("dof", dof))
        if kept[-1].shape != place.shape:
            raise ValueError(f"dof is {kept[-1].shape}, needs {place.shape}")
        s.dof = address(kept[-1])
    if n is None:
        n = place.size if dof is None else int(kept[-1].max(initial=-1)) + 1
    s.n = whole("n", n)
    for name, count, corners, given in (("face", "faces", "corners", face),
                                        ("own", "own_faces", "own_corners", own)):
        if given is None:
            continue
        a = integers(name, given)
        if a.ndim != 2:
            raise ValueError(f"{name} is {a.shape}, needs a row for each face")
        kept.append(a if a.size else np.zeros((1, a.shape[1]), np.intc))
        setattr(s, name, address(kept[-1]))
        setattr(s, count, len(a))
        setattr(s, corners, a.shape[1])
    if node is not None:
        kept.append(integers("node", node).reshape(-1))
        s.node, s.nodes = address(kept[-1]), kept[-1].size
    if wall is not None:
        kept.append(vector("wall", wall, 2 * d, d))
        s.wall = address(kept[-1])
    found = structs["dls_pairs"]()
    call("dls_pairs_find", byref(s), byref(found))
    try:
        def take(kind: Any, pointer: Any, *shape: int) -> Any:
            return read(kind, pointer, int(np.prod(shape)), None).copy().reshape(shape)

        def matrix(a: Any) -> Any:
            p = take(c_int, a.p, a.cols + 1)
            values, rows = take(c_double, a.x, p[-1]), take(c_int, a.i, p[-1])
            return sp.csc_matrix((values, rows, p), (a.rows, a.cols))

        nodes = found.nodes
        return Pairs(matrix(found.HN), matrix(found.HT), matrix(found.P) if found.P.p else None,
                     take(c_double, found.g, nodes, d), take(c_double, found.frame, nodes, d, d),
                     take(c_int, found.node, found.candidates), take(c_int, found.face, nodes),
                     take(c_double, found.measure, found.candidates) if found.measure else None,
                     PAIR_STATES[take(c_int, found.state, s.nodes)] if found.state else None)
    finally:
        lib.dls_pairs_free(byref(found))


class RigidBodies:
    """Rigid bodies in space: mass (n), inertia about the centre in the body's frame and rotation R
    (n x 3 x 3), centre x, velocity v, spin w in the world (n x 3). solve(*bodies.contacts(...), mu),
    then apply(r)."""

    def __init__(self, mass: Array, inertia: Array, R: Array, x: Array, v: Array, w: Array) -> None:
        masses = reals("mass", mass).reshape(-1)
        self.n = masses.size
        self._bodies = (structs["dls_rigid"] * self.n)()
        # one row of doubles for each body, over the structs
        table = np.frombuffer(self._bodies, dtype=np.float64).reshape(self.n, 28)
        table[:, 0] = masses
        at = 1
        parts: tuple[tuple[str, Any, int], ...] = (
            ("inertia", inertia, 9), ("R", R, 9), ("x", x, 3), ("v", v, 3), ("w", w, 3))
        for name, a, width in parts:
            table[:, at:at + width] = vector(name, a, width * self.n, 3).reshape(self.n, width)
            at += width
        self.v, self.w = table[:, 22:25], table[:, 25:28]  # these views change with apply()
        self._contacts: Any = None

    def contacts(self, body: Any, point: Array, normal: Array, gap: Array = 0.0) -> Any:
        """Returns (W, q) for solve(): body (nc x 2) a, b, -1 fixed; point, normal from b into a
        (nc x 3); gap (nc): distance / h."""
        pair = integers("body", body).reshape(-1, 2)
        nc = len(pair)
        place, along = vector("point", point, 3 * nc, 3), vector("normal", normal, 3 * nc, 3)
        opening = vector("gap", gap, nc)
        moved, H, q = np.zeros((nc, 2), np.intc), np.zeros((nc, 2, 3, 6)), np.zeros((nc, 3))
        for k in range(nc):
            call("dls_rigid_contact", self.n, byref(self._bodies), *map(int, pair[k]),
                 address(place[3 * k:]), address(along[3 * k:]), opening[k], k, address(moved),
                 address(H), address(q), None)
        self._contacts = moved, H
        return self._contacts, q

    def apply(self, r: Array) -> None:
        """Adds the impulses r of the last contacts() to v and w."""
        if self._contacts is None:
            raise ValueError("there are no contacts yet")
        body, H = self._contacts
        impulses = vector("r", r, 3 * len(body), 3)
        call("dls_rigid_apply", self.n, byref(self._bodies), len(body), address(body), address(H),
             address(impulses))
