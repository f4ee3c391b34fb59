# methods.py: how five methods converge on one problem of 200 contacts in 3D.
# python3 methods.py [PICTURE.png]
#
# Output:
#   nlgs solved
#   nlgs with anderson solved
#   newton solved
#   admm solved
#   auto solved
import sys

import numpy as np

import delassus

random = np.random.default_rng(1)
nc = 200
A = random.standard_normal((3 * nc, 3 * nc))
W = A @ A.T / nc + 0.05 * np.eye(3 * nc)
q = random.standard_normal((nc, 3)) - [1, 0, 0]
runs = {"nlgs": {"method": "nlgs"}, "nlgs with anderson": {"method": "nlgs", "acceleration": "anderson"},
        "newton": {"method": "newton"}, "admm": {"method": "admm"}, "auto": {}}
histories = {}
for name, options in runs.items():
    s = delassus.solve(W, q, 0.5, history=True, max_iterations=20000, **options)
    histories[name] = s.history
    print(name, s.words)

if len(sys.argv) > 1:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    for name, rows in histories.items():
        plt.loglog(np.maximum(rows["cpu_seconds"], 1e-5), rows["residual"], ".-", label=name)
    plt.xlabel("CPU seconds")
    plt.ylabel("residual of the certificate")
    plt.legend()
    plt.savefig(sys.argv[1], dpi=80)
