"""calculix_pairs.py DIR: two blocks whose meshes do not match, by CalculiX. ccx writes K of both
(job.sti, job.dof); delassus.pairs makes H_N, H_T and the gaps of the upper block's bottom nodes on
the faces of the lower one. Beside it ccx presses and shears the blocks with its own contact, node
to surface, as the stiffness of the contact grows: the distance of all displacements falls.

Output:
  36 pairs: solved, they carry the load to 1e-8: yes
  contact stiffness 1e4: ccx differs by 6e-02 of the largest displacement
  contact stiffness 1e5: ccx differs by 6e-03 of the largest displacement
  contact stiffness 1e6: ccx differs by 6e-04 of the largest displacement
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import scipy.sparse as sp

import delassus

where = Path(sys.argv[1])
where.mkdir(parents=True, exist_ok=True)
nodes, elements, bottom, top, faces = [], [], [], [], []


def block(count, low, high):
    """Adds a block of count elements; lists its nodes at the bottom and top, its faces at the top."""
    a, b, c = (np.linspace(low[k], high[k], count[k] + 1) for k in range(3))
    index = np.arange(len(a) * len(b) * len(c)).reshape(len(c), len(b), len(a)) + len(nodes) + 1
    nodes.extend([x, y, z] for z in c for y in b for x in a)
    for k, j, i in np.ndindex(count[2], count[1], count[0]):
        q = [index[k + l, j:j + 2, i:i + 2].ravel()[[0, 1, 3, 2]] for l in (0, 1)]
        elements.append(np.concatenate(q))
        if k == count[2] - 1:
            faces.append(q[1])
    bottom.append(index[0].ravel())
    top.append(index[-1].ravel())


def rows(a):
    return "\n".join(", ".join(map(str, row)) for row in a)


def ccx(name, *deck):
    (where / f"{name}.inp").write_text("\n".join(deck) + "\n")
    subprocess.run(["ccx", name], cwd=where, stdout=subprocess.DEVNULL, check=False)


block((7, 7, 4), (0, 0, 0), (1, 1, .6))
below = len(faces)
block((5, 5, 4), (.1, .1, .6), (.9, .9, 1.2))
loads = [(k, 1, .05 / len(top[1])) for k in top[1]] + [(k, 3, -.4 / len(top[1])) for k in top[1]]
mesh = ["*NODE, NSET=NALL", rows([k + 1, *x] for k, x in enumerate(nodes)),
        "*ELEMENT, TYPE=C3D8, ELSET=EALL", rows([k + 1, *e] for k, e in enumerate(elements)),
        "*NSET, NSET=FIX", rows(bottom[0][:, None]), "*NSET, NSET=SLAVE", rows(bottom[1][:, None]),
        "*MATERIAL, NAME=M", "*ELASTIC", "1000, .3", "*DENSITY", "1",
        "*SOLID SECTION, ELSET=EALL, MATERIAL=M", "*BOUNDARY", "FIX, 1, 3"]
ccx("job", *mesh, "*STEP", "*FREQUENCY, SOLVER=MATRIXSTORAGE", "1", "*END STEP")
i, j, x = np.loadtxt(where / "job.sti", unpack=True)
half = sp.csc_matrix((x, (j.astype(int) - 1, i.astype(int) - 1)))
K = half + sp.tril(half, -1).T

# -> delassus
X, dof = np.array(nodes), -np.ones((len(nodes), 3), int)
for k, line in enumerate(open(where / "job.dof")):
    dof[tuple(int(a) - 1 for a in line.split("."))] = k
c = delassus.pairs(X, bottom[1], faces[:below], dof=dof, base=1)
# <- delassus

f = np.zeros(K.shape[0])
for node, direction, load in loads:
    f[dof[node - 1, direction - 1]] += load
s = delassus.reduce(K, c.HN, c.HT).solve(0.3, f, c.g)
total = np.einsum("cj,cjk->k", s.r, c.frame)
carry = np.allclose(total, [-.05, 0, .4], atol=4e-9)
print(f"{len(c.g)} pairs: {s.words}, they carry the load to 1e-8: {'yes' if carry else 'no'}")
apart = []
for stiffness in ("1e4", "1e5", "1e6"):
    ccx("pen", *mesh, "*SURFACE, NAME=UP, TYPE=NODE", "SLAVE", "*SURFACE, NAME=LOW",
        rows([k + 1, "S2"] for k in range(7 * 7 * 3, 7 * 7 * 4)),
        "*SURFACE INTERACTION, NAME=I", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
        f"{stiffness}, 1e-9", "*FRICTION", f"0.3, {stiffness}",
        "*CONTACT PAIR, INTERACTION=I, TYPE=NODE TO SURFACE", "UP, LOW", "*STEP, INC=1000",
        "*STATIC", "1, 1", "*CLOAD", rows(loads), "*NODE PRINT, NSET=NALL, GLOBAL=YES", "U",
        "*END STEP")
    found = [line.split() for line in (where / "pen.dat").read_text().splitlines()]
    u = {int(v[0]): np.array(v[1:], float) for v in found if len(v) == 4 and v[0].isdigit()}
    mine = np.where(dof < 0, 0, s.x[dof])
    apart.append(max(np.abs(u[k + 1] - mine[k]).max() for k in range(len(X))) / np.abs(mine).max())
    print(f"contact stiffness {stiffness}: ccx differs by {apart[-1]:.0e} of the largest "
          "displacement")
sys.exit(not (s.solved and carry and apart[-1] < 0.02 and apart == sorted(apart)[::-1]))
