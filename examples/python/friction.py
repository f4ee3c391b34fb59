# friction.py: one load under growing friction, each solve from the answer before: how many contacts slip
# and how far.  python3 friction.py [PICTURE.png]
#
# Output:
#   mu 0.0: 30 slip, 0 stick
#   mu 0.6: 25 slip, 5 stick
#   mu 1.2: 9 slip, 21 stick
import sys

import numpy as np
import scipy.sparse as sp

import delassus

n = 30
line = sp.diags([2.02, -1.0, -1.0], [0, 1, -1], (n, n))
K = sp.kron(line, sp.eye(2), format="csc")
nodes = np.arange(n)
HN = sp.csc_matrix((np.ones(n), (2 * nodes + 1, nodes)), (2 * n, n))
HT = sp.csc_matrix((np.ones(n), (2 * nodes, nodes)), (2 * n, n))
f = np.zeros(2 * n)
f[1::2] = -1.0  # pressed
f[::2] = np.linspace(0.1, 1.5, n)  # and pulled
R = delassus.reduce(K, HN, HT)
R.load(f)
friction, slips, r = np.linspace(0, 1.2, 25), [], None
largest = []
for mu in friction:
    s = R.solve(mu, r0=r)
    r = s.r
    slips.append(int((s.states == "slip").sum() + (mu == 0) * (s.states == "stick").sum()))
    largest.append(np.abs(s.u[:, 1]).max())
for k in (0, 12, 24):
    print(f"mu {friction[k]:.1f}: {slips[k]} slip, {n - slips[k]} stick")

if len(sys.argv) > 1:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    plt.plot(friction, np.array(slips) / n, label="share of contacts that slip")
    plt.plot(friction, np.array(largest) / largest[0], label="largest slip, relative")
    plt.xlabel("friction")
    plt.legend()
    plt.savefig(sys.argv[1], dpi=80)
