# getfem_block.py: GetFEM as the host. A block of trilinear elements, held at its top and sheared,
# stands on a rough floor. The stiffness and the load of the model go to delassus, beside it to
# GetFEM's own contact brick (augmented Lagrangian, its parameter r tuned by hand).
#
# GetFEM writes B_N U <= gap and multipliers <= 0: H_N = -B_N^T, r_n = -lambda_N, H_T = B_T^T.
#
# Output:
#   2187 unknowns, 81 contact nodes: free 26, slip 31, stick 24
#   x and r_n agree with GetFEM's brick to 1e-8: yes
import sys
import time

import getfem as gf
import numpy as np
import scipy.sparse as sp

import delassus

TOP, FRICTION = 1, 0.3
gf.util_trace_level(0)
side = np.linspace(0, 1, 9)
mesh = gf.Mesh("cartesian", side, side, side)
mesh.set_region(TOP, mesh.outer_faces_with_direction([0, 0, 1], 0.1))
mf = gf.MeshFem(mesh, 3)
mf.set_fem(gf.Fem("FEM_QK(3,1)"))
mim = gf.MeshIm(mesh, gf.Integ("IM_GAUSS_PARALLELEPIPED(3,4)"))
n, X = mf.nbdof(), mf.basic_dof_nodes()[:, ::3]      # unknowns 3 k, 3 k + 1, 3 k + 2 of node k
half, low = abs(X[2] - 0.5) < 1e-9, np.flatnonzero(X[2] < 1e-9)
load = np.zeros((n // 3, 3))
load[half] = np.c_[np.full((half.sum(), 2), [4e-4, 1e-4]), 1e-3 - 5e-3 * X[0, half]]


def block():
    """The model without contact."""
    md = gf.Model("real")
    md.add_fem_variable("u", mf)
    for name in ("lambda", "mu"):
        md.add_initialized_data(name, [1.0])
    md.add_isotropic_linearized_elasticity_brick(mim, "u", "lambda", "mu")
    md.add_explicit_rhs("u", load.ravel())
    md.add_Dirichlet_condition_with_simplification("u", TOP)
    return md


def pick(direction):
    """Column c is 1 at that unknown of the c-th node on the floor."""
    columns = np.arange(low.size)
    return sp.csc_matrix((np.ones(low.size), (3 * low + direction, columns)), (n, low.size))


HN, nc = pick(2), low.size
HT = sp.hstack([pick(0), pick(1)]).tocsc()[:, np.arange(2 * nc).reshape(2, nc).T.ravel()]
md = block()
md.assembly()
start = time.process_time()
# -> delassus
A, f = md.tangent_matrix(), md.rhs()
s = delassus.reduce(sp.csc_matrix((A.csc_val(), *A.csc_ind()[::-1])), HN, HT).solve(FRICTION, f)
# <- delassus
ours = time.process_time() - start

md = block()
BN, BT = gf.Spmat("empty", nc, n), gf.Spmat("empty", 2 * nc, n)
for c, k in enumerate(3 * low):
    BN.add(c, int(k) + 2, -1.0)
    BT.add(2 * c, int(k), 1.0)
    BT.add(2 * c + 1, int(k) + 1, 1.0)
md.add_variable("normal", nc)
md.add_variable("tangent", 2 * nc)
md.add_initialized_data("r", [0.1])
md.add_initialized_data("gap", np.zeros(nc))
md.add_initialized_data("friction", [FRICTION])
md.add_basic_contact_brick("u", "normal", "tangent", "r", BN, BT, "friction", "gap")
start = time.process_time()
md.solve("max_res", 1e-13, "max_iter", 200)
theirs = time.process_time() - start

count = {state: int((s.states == state).sum()) for state in ("free", "slip", "stick")}
print(f"{n} unknowns, {nc} contact nodes:", ", ".join(f"{state} {k}" for state, k in count.items()))
apart = max(abs(a - b).max() / abs(a).max() for a, b in
            ((md.variable("u"), s.x), (md.variable("normal"), -s.r[:, 0])))
print("x and r_n agree with GetFEM's brick to 1e-8:", "yes" if apart <= 1e-8 else "no")
print(f"apart {apart:.0e}; CPU: brick {theirs:.2f} s, delassus {ours:.2f} s", file=sys.stderr)
