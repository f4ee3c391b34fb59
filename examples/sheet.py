# sheet.py: a first answer from scipy, the script of docs/python.md: a sheet of nodes on springs,
# whose lowest row may touch the floor, from its stiffness matrix to reactions and displacements.
#
# Output:
#   solved sum of (r_n, r_t): [11.8546 -0.8258] largest x: 0.4501
#   2 slip, 18 stick
import numpy as np
import scipy.sparse as sp
import delassus

side = 20                                            # a sheet of side^2 nodes on springs
line = sp.diags([2.0, -1.0, -1.0], [0, 1, -1], (side, side))
sheet = sp.kron(line, sp.eye(side)) + sp.kron(sp.eye(side), line)
K = sp.kron(sheet, sp.eye(2), format="csc")          # stiffness; unknowns x, y of each node
low = np.arange(side)                                # the lowest row of nodes may touch the floor
HN = sp.csc_matrix((np.ones(side), (2 * low + 1, low)), (K.shape[0], side))  # picks their y
HT = sp.csc_matrix((np.ones(side), (2 * low, low)), (K.shape[0], side))      # picks their x
f = np.tile([0.0, -0.1], side * side)                # weight
f[::2 * side] = 0.5                                  # its left side is pushed to the right
s = delassus.reduce(K, HN, HT).solve(mu=0.4, f=f)    # r, u, x
print(s.words, "sum of (r_n, r_t):", s.r.sum(axis=0).round(4), "largest x:", s.x.max().round(4))
print((s.states == "slip").sum(), "slip,", (s.states == "stick").sum(), "stick")
