# pile.py: a triangle of rigid discs between two leaning walls: contacts between bodies, and W is never
# formed.
# python3 pile.py [PICTURE.png]
#
# Output:
#   36 discs, 108 contacts: solved
#   floor and walls carry 36.00 of the weight 36.00
import sys

import numpy as np

import delassus

rows, mu, dt = 8, 0.3, 1e-2
centre = np.array([[2 * i + k, 1 + np.sqrt(3) * k] for k in range(rows) for i in range(rows - k)],
                  dtype=float)
n = len(centre)
pairs = [(a, b) for a in range(n) for b in range(a) if np.linalg.norm(centre[a] - centre[b]) < 2.01]
body, H = [], []


def add(a, b, normal):
    """Adds the contact of disc a with disc b, -1 for what is fixed; normal: from b into a."""
    t = np.array([-normal[1], normal[0]])
    rows_of = [np.array([[normal[0], normal[1], 0.0], [t[0], t[1], -1.0]]),
               np.array([[-normal[0], -normal[1], 0.0], [-t[0], -t[1], -1.0]])]
    scale = np.array([1, 1, np.sqrt(2)])  # M^-1/2: mass 1, inertia 1/2
    body.append([a, b])
    H.append([rows_of[0] * scale, rows_of[1] * scale])


for a, b in pairs:
    add(a, b, (centre[a] - centre[b]) / 2)
for a in range(n):
    if centre[a, 1] < 1.01:
        add(a, -1, np.array([0.0, 1.0]))
for a in range(n):  # walls along both slopes
    k = int(round((centre[a, 1] - 1) / np.sqrt(3)))
    if abs(centre[a, 0] - k) < 0.01:
        add(a, -1, np.array([np.sqrt(3) / 2, -0.5]))
    if abs(centre[a, 0] - (2 * (rows - 1) - k)) < 0.01:
        add(a, -1, np.array([-np.sqrt(3) / 2, -0.5]))
body, H = np.array(body), np.array(H)
free = np.tile([0.0, -dt, 0.0], (n, 1))  # velocities after a step without contact, weight 1
q = np.zeros((len(body), 2))
for c, (a, b) in enumerate(body):
    q[c] = (H[c, 0] / [1, 1, np.sqrt(2)]) @ free[a]
    if b >= 0:
        q[c] += (H[c, 1] / [1, 1, np.sqrt(2)]) @ free[b]
s = delassus.solve((body, H), q, mu)
fixed = body[:, 1] < 0
# the force on a disc, upwards: r_n times the normal and r_t times the tangent
up = (s.r * H[:, 0, :, 1]).sum(axis=1) / dt
print(f"{n} discs, {len(body)} contacts: {s.words}")
print(f"floor and walls carry {up[fixed].sum():.2f} of the weight {n:.2f}")

if len(sys.argv) > 1:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    axes = plt.gca()
    for x in centre:
        axes.add_patch(plt.Circle(x, 1, fill=False, color="0.7"))
    for c, (a, b) in enumerate(body):
        normal = H[c, 0, 0, :2]
        ends = np.array([centre[a], centre[b] if b >= 0 else centre[a] - normal])
        plt.plot(*ends.T, "r-", linewidth=0.5 * s.r[c, 0] / dt)
    axes.set_aspect("equal")
    plt.savefig(sys.argv[1], dpi=80)
