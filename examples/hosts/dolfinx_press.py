"""dolfinx_press.py: a press fit by dolfinx. A ring .5 .. 1 sits in a ring 1 .. 2 that is too
narrow by 1e-3, plane stress; their meshes do not match at the common circle. delassus.pairs makes
H_N and H_T, nodes against edges and by mortar. The mean pressure is Lame's up to the error of the
meshes.

Output:
  nodes against edges: 126 contacts, solved, pressure within 1 % of Lame's: yes, varies by 2e-02
  mortar: 126 contacts, solved, pressure within 1 % of Lame's: yes, varies by 2e-02
"""

import sys

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import delassus

a, b, c, tight, E, nu = .5, 1.0, 2.0, 1e-3, 1000.0, .3


def ring(inner, outer, around, across, first):
    """Triangles of a ring: nodes layer by layer from the inner circle, and cells."""
    r, t = np.linspace(inner, outer, across + 1), 2 * np.pi * np.arange(around) / around
    x = np.array([[s * np.cos(u), s * np.sin(u)] for s in r for u in t])
    i, k = np.meshgrid(np.arange(around), np.arange(across))
    p, q = (k * around + i).ravel(), (k * around + (i + 1) % around).ravel()
    cells = np.r_[np.c_[p, p + around, q], np.c_[q, p + around, q + around]]
    return x, cells + first


x1, cells1 = ring(a, b, 126, 10, 0)
x2, cells2 = ring(b, c, 76, 12, len(x1))
domain = ufl.Mesh(ufl.VectorElement("Lagrange", "triangle", 1))
M = mesh.create_mesh(MPI.COMM_SELF, np.r_[cells1, cells2].astype(np.int64), np.r_[x1, x2], domain)
V = fem.VectorFunctionSpace(M, ("CG", 1))
u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
lam, G = E * nu / (1 - nu * nu), E / (2 * (1 + nu))


def eps(w):
    return ufl.sym(ufl.grad(w))


A = fem.petsc.assemble_matrix(fem.form(
    ufl.inner(lam * ufl.tr(eps(u)) * ufl.Identity(2) + 2 * G * eps(u), eps(v)) * ufl.dx))
A.assemble()
p, i, x = A.getValuesCSR()
K = sp.csc_matrix((x, i, p), A.size)  # symmetric
X = V.tabulate_dof_coordinates()[:, :2]
body = np.zeros(len(X), int)  # dolfinx numbers nodes and cells anew: which ring holds each node
for cell in range(M.topology.index_map(2).size_local):
    place = V.dofmap.cell_dofs(cell)
    body[place] = 1 if np.linalg.norm(X[place].mean(axis=0)) < b else 2
circle = [np.flatnonzero((abs(np.linalg.norm(X, axis=1) - b) < 1e-9) & (body == k)) for k in (1, 2)]
inner, outer = (k[np.argsort(np.arctan2(X[k, 1], X[k, 0]))] for k in circle)

# -> delassus: the outer ring looks inwards, its edges run clockwise
face = np.c_[np.roll(outer, -1), outer]
nodes = delassus.pairs(X, inner, face)
mortar = delassus.pairs(X, face=face, own=np.c_[inner, np.roll(inner, -1)])
# <- delassus

lame = tight * E / b * (b * b - a * a) * (c * c - b * b) / (2 * b * b * (c * c - a * a))
good = True
for name, pair in (("nodes against edges", nodes), ("mortar", mortar)):
    g = np.tile([-tight, 0], (len(pair.g), 1))  # in place of pair.g, the sag of the edges
    s = delassus.reduce(K, pair.HN, pair.HT, P=pair.P).solve(0, g=g)
    area = 2 * np.pi * b / len(inner) if pair.measure is None else pair.measure
    pressure = s.r[:, 0] / area
    near = abs(pressure.mean() / lame - 1) < .01
    print(f"{name}: {len(s.r)} contacts, {s.words}, pressure within 1 % of Lame's: "
          f"{'yes' if near else 'no'}, varies by {pressure.std() / pressure.mean():.0e}")
    good &= near and s.solved
sys.exit(not good)
