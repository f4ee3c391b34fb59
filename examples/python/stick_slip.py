# stick_slip.py: a chain of springs dragged to and fro over a floor: a path of equilibria, and the loop of
# force over displacement that friction leaves.  python3 stick_slip.py [PICTURE.png]
#
# Output:
#   80 steps, all solved
#   work of friction of the last cycle -1.77
import sys

import numpy as np
import scipy.sparse as sp

import delassus

n, mu, weight = 10, 0.3, 1.0
# unknowns: x of n masses in a row, then y; springs between neighbours, soft ones to the ground
chain = sp.diags([2.0, -1.0, -1.0], [0, 1, -1], (n, n)) + 0.01 * sp.eye(n)
K = sp.block_diag([chain, sp.eye(n)], format="csc")
I, O = sp.eye(n), sp.csc_matrix((n, n))
path = delassus.Motion(K, sp.vstack([O, I]), sp.vstack([I, O]), law="path", tol=1e-10)
load = np.concatenate([np.zeros(n), -weight * np.ones(n)])
pulls, ends, solved, work = [], [], 0, []
for phase in np.linspace(0, 4 * np.pi, 81)[1:]:  # two cycles
    load[n - 1] = 2.0 * np.sin(phase)
    s = path.step(load, mu=np.full(n, mu))
    solved += s.solved
    pulls.append(load[n - 1])
    ends.append(path.x[n - 1])
    work.append(path.energies["friction"])
print(f"{len(pulls)} steps, " + ("all solved" if solved == len(pulls) else f"{solved} solved"))
print(f"work of friction of the last cycle {work[-1] - work[39]:.2f}")

if len(sys.argv) > 1:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    plt.plot(ends, pulls, ".-")
    plt.xlabel("displacement of the last mass")
    plt.ylabel("pull")
    plt.savefig(sys.argv[1], dpi=80)
