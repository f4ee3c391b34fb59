# bounce.py: a ball that falls on a rough floor with restitution e = 0.8, and rolls nowhere: it slides
# until friction stops it. Height, energies.  python3 bounce.py [PICTURE.png]
#
# Output:
#   first impact at t = 0.45, heights of the bounces 0.64 0.41 0.26
#   the energy balances in every step
import sys

import numpy as np

import delassus

h = 1e-3
ball = delassus.Motion(None, [[0], [1]], [[1], [0]], M=np.eye(2), gap=[0.0], h=h, restitution=0.8)
ball.start(x=[0, 1], v=[1, 0])
t, height, energy, balanced = [], [], [], True
for _ in range(3000):
    ball.step([0, -9.81], mu=0.1)
    e = ball.energies
    t.append(ball.t)
    height.append(ball.x[1])
    energy.append(e["kinetic"] + 9.81 * ball.x[1])
    balanced &= e["residual"] <= 1e-10 * e["scale"]
height = np.array(height)
tops = [k for k in range(1, len(height) - 1) if height[k - 1] < height[k] >= height[k + 1]][:3]
down = int(np.argmax(np.diff(height) > 0))
print(f"first impact at t = {t[down]:.2f}, heights of the bounces",
      " ".join(f"{height[k]:.2f}" for k in tops))
print("the energy balances in every step" if balanced else "the energy does not balance")

if len(sys.argv) > 1:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    plt.plot(t, height, label="height")
    plt.plot(t, np.array(energy) / energy[0], label="energy, relative")
    plt.xlabel("t")
    plt.legend()
    plt.savefig(sys.argv[1], dpi=80)
