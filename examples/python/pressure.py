# pressure.py: an elastic sheet on a rough floor, pulled to one side. Reactions along the floor, inside the
# friction cone where they stick.  python3 pressure.py [PICTURE.png]
#
# Output:
#   solved: 10 slip, 10 stick, 0 free
#   sum of r_n 11.85, of r_t -1.38
import sys

import numpy as np
import scipy.sparse as sp

import delassus

side, mu = 20, 0.15
line = sp.diags([2.0, -1.0, -1.0], [0, 1, -1], (side, side))
sheet = sp.kron(line, sp.eye(side)) + sp.kron(sp.eye(side), line)
K = sp.kron(sheet, sp.eye(2), format="csc")  # unknowns x, y of each node
low = np.arange(side)  # the lowest row may touch the floor
HN = sp.csc_matrix((np.ones(side), (2 * low + 1, low)), (K.shape[0], side))
HT = sp.csc_matrix((np.ones(side), (2 * low, low)), (K.shape[0], side))
f = np.tile([0.0, -0.1], side * side)
f[:2 * side:2] = 0.2 * np.linspace(0, 1, side)  # the pull grows to the right
s = delassus.reduce(K, HN, HT).solve(mu, f=f)
count = {state: int((s.states == state).sum()) for state in ("slip", "stick", "free")}
print(f"{s.words}: " + ", ".join(f"{n} {state}" for state, n in count.items()))
print(f"sum of r_n {s.r[:, 0].sum():.2f}, of r_t {s.r[:, 1].sum():.2f}")

if len(sys.argv) > 1:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    plt.fill_between(low, -mu * s.r[:, 0], mu * s.r[:, 0], alpha=0.2, label=r"$|r_t| \leq \mu r_n$")
    plt.plot(low, s.r[:, 0], "k-", label="$r_n$")
    for state, mark in (("stick", "go"), ("slip", "rs")):
        at = s.states == state
        plt.plot(low[at], s.r[at, 1], mark, label=f"$r_t$, {state}")
    plt.xlabel("contact")
    plt.legend()
    plt.savefig(sys.argv[1], dpi=80)
