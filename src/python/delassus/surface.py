"""What an answer means on the body: sums of reactions by body, and files for ParaView."""

from __future__ import annotations

import os
from typing import Any, Dict, List, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ._library import Vector, reals

_STATES: Dict[str, int] = {"free": 0, "slip": 1, "stick": 2, "touch": 2}


class Sum(NamedTuple):
    """The sum of the reactions on a body: force (d), moment about the origin (1 in 2D, 3 in 3D;
    None without coordinates), and the body's unknowns."""

    force: Vector
    moment: Vector | None
    unknowns: Any


class Surface:
    """The nodes of a body: unknown d k + i is direction i of node k. force: H r, nodes x d."""

    def __init__(self, K: Any, HN: Any, HT: Any, d: int, coordinates: Any) -> None:
        self._K, self._HN, self._HT, self.d = K, HN, HT, d
        self.X: Vector | None = None
        if coordinates is not None:
            X = reals("coordinates", coordinates)
            if X.ndim != 2 or X.shape[1] not in (2, 3) or X.size != HN.shape[0]:
                raise ValueError(f"coordinates is {X.shape}, needs 2 or 3 columns and "
                                 f"{HN.shape[0]} numbers, one for each unknown")
            self.X, self.d = X.copy(), X.shape[1]

    def force(self, nodal: Vector) -> Vector:
        if not self.d:
            raise ValueError("HT is not given: reduce(K, HN, d=3) or coordinates tell d")
        R = self._HN @ nodal[:, 0]
        if nodal.shape[1] > 1:
            R = R + self._HT @ nodal[:, 1:].reshape(-1)
        if R.size % self.d:
            raise ValueError(f"the unknowns, {R.size}, are not the {self.d} directions of nodes")
        return np.asarray(R).reshape(-1, self.d)

    def sums(self, nodal: Vector) -> List[Sum]:
        R = self.force(nodal)
        nodes = len(R)
        which = np.zeros(nodes, dtype=int)
        if not callable(self._K):
            C = sp.coo_matrix(self._K)
            keep = C.data != 0
            links = sp.coo_matrix((np.ones(keep.sum()), (C.row[keep] // self.d,
                                                         C.col[keep] // self.d)), (nodes, nodes))
            which = connected_components(links, directed=False)[1]
        found = []
        for body in range(which.max() + 1):
            own = np.flatnonzero(which == body)
            moment = None
            if self.X is not None:
                moment = np.atleast_1d(np.cross(self.X[own], R[own]).sum(axis=0))
            unknowns = (self.d * own[:, None] + np.arange(self.d)).reshape(-1)
            found.append(Sum(R[own].sum(axis=0), moment, unknowns))
        return found

    def place(self) -> Any:
        """Returns the node of each contact: that of its largest entry in HN."""
        N = sp.csc_matrix(self._HN)
        return np.array([N.indices[a:b][np.argmax(np.abs(N.data[a:b]))] // self.d if b > a else -1
                         for a, b in zip(N.indptr, N.indptr[1:])], dtype=int)

    def write(self, path: str | os.PathLike[str], x: Vector, nodal: Vector, states: Any,
              gap: Vector) -> None:
        if self.X is None:
            raise ValueError("coordinates are missing: reduce(K, HN, HT, coordinates=X)")
        nodes = len(self.X)
        state, gaps = np.full(nodes, -1), np.zeros(nodes)
        if len(states) == self._HN.shape[1]:  # not with weights, or where contacts are left out
            place = self.place()
            on = place >= 0
            state[place[on]] = [_STATES[s] for s in states[on]]
            gaps[place[on]] = gap[on]

        def wide(a: Vector) -> Vector:
            return np.hstack([a, np.zeros((nodes, 3 - a.shape[1]))])

        def array(name: str, kind: str, a: Any) -> str:
            rows = np.asarray(a).reshape(nodes, -1)
            text = "\n".join(" ".join(f"{v:.17g}" for v in row) for row in rows)
            return (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{rows.shape[1]}" '
                    f'format="ascii">\n{text}\n</DataArray>\n')

        one = np.arange(nodes)
        text = ('<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="0.1" '
                'byte_order="LittleEndian">\n<UnstructuredGrid>\n'
                f'<Piece NumberOfPoints="{nodes}" NumberOfCells="{nodes}">\n<PointData>\n'
                + array("displacement", "Float64", wide(x.reshape(nodes, self.d)))
                + array("reaction", "Float64", wide(self.force(nodal)))
                + array("state", "Int32", state) + array("gap", "Float64", gaps)
                + "</PointData>\n<Points>\n" + array("Points", "Float64", wide(self.X))
                + "</Points>\n<Cells>\n" + array("connectivity", "Int64", one)
                + array("offsets", "Int64", one + 1) + array("types", "UInt8", np.ones(nodes))
                + "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
