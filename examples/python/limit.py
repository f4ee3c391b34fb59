# limit.py: how much a wall carries. A wall of blocks in running bond stands on a floor that is tilted
# until it fails: loads f0 + lambda f1, weight and its share sideways. One answer is certified, one
# motion proves that there is none beyond; a linear programme (the associated law) lies between.
# python3 limit.py [PICTURE.png]
#
# Output:
#   27 blocks, 130 contacts, friction 0.65
#   carried 0.59758, refused 0.59758, a linear programme 0.59758; both within 1e-6: True
import sys

import numpy as np
import scipy.sparse as sp
from scipy.optimize import linprog

import delassus

rows, columns, width, height, mu = 6, 4, 1.0, 0.5, 0.65
blocks = []  # left, right, row
for row in range(rows):
    cuts = np.arange(columns + 1) * width if row % 2 == 0 else np.r_[
        0, (np.arange(columns) + 0.5) * width, columns * width]
    blocks += [(a, b, row) for a, b in zip(cuts, cuts[1:])]
centre = np.array([((a + b) / 2, (row + 0.5) * height) for a, b, row in blocks])
n = 3 * len(blocks)  # two displacements and a turn each
HN, HT = [], []


def motion(k, point, e):
    """How the unknowns of block k move a point of it along e; k < 0: the floor."""
    column = np.zeros(n)
    if k >= 0:
        x, y = point - centre[k]
        column[3 * k:3 * k + 3] = e[0], e[1], x * e[1] - y * e[0]
    return column


def touch(upper, lower, point, normal):
    """A contact at a point; the normal looks from `lower` into `upper`."""
    for operator, e in ((HN, normal), (HT, (normal[1], -normal[0]))):
        operator.append(motion(upper, np.array(point), e) - motion(lower, np.array(point), e))


for k, (a, b, row) in enumerate(blocks):
    for x in (a, b) if row == 0 else ():
        touch(k, -1, (x, 0.0), (0.0, 1.0))
    for j, (c, d, other) in enumerate(blocks):
        left, right = max(a, c), min(b, d)
        if other == row - 1 and right > left + 1e-9:
            for x in (left, right):
                touch(k, j, (x, row * height), (0.0, 1.0))
        if other == row and abs(d - a) < 1e-9:
            for y in (row * height, (row + 1) * height):
                touch(k, j, (a, y), (1.0, 0.0))
HN, HT = np.array(HN).T, np.array(HT).T
f0, f1 = np.zeros(n), np.zeros(n)
f1[::3] = [(b - a) * height for a, b, row in blocks]
f0[1::3] = -f1[::3]

limit = delassus.reduce(sp.csc_matrix((n, n)), HN, HT).limit(f1, mu, f0)

# max lambda: f0 + lambda f1 + H_N r_n + H_T r_t = 0, |r_t| <= mu r_n
count = HN.shape[1]
cone = np.vstack([np.hstack([-mu * np.eye(count), sign * np.eye(count), np.zeros((count, 1))])
                  for sign in (1, -1)])
programme = linprog(np.r_[np.zeros(2 * count), -1], A_ub=cone, b_ub=np.zeros(2 * count),
                    A_eq=np.hstack([HN, HT, f1[:, None]]), b_eq=-f0,
                    bounds=[(0, None)] * count + [(None, None)] * count + [(0, None)]).x[-1]
print(f"{len(blocks)} blocks, {count} contacts, friction {mu}")
print(f"carried {limit.carried:.5f}, refused {limit.refused:.5f}, a linear programme "
      f"{programme:.5f}; both within 1e-6:",
      limit.carried - 1e-6 < programme < limit.refused + 1e-6 < limit.carried + 2e-6)

if len(sys.argv) > 1:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    axes = plt.figure(figsize=(6, 4)).gca()
    for k, (a, b, row) in enumerate(blocks):
        corners = np.array([(a, 0), (b, 0), (b, height), (a, height), (a, 0)]) + (0, row * height)
        x, y, turn = 0.25 * limit.motion[3 * k:3 * k + 3]
        arm = corners - centre[k]
        moved = corners + (x, y) + turn * np.c_[-arm[:, 1], arm[:, 0]]
        axes.plot(*corners.T, color="0.8", linewidth=0.8)
        axes.fill(*moved.T, facecolor="#cfe3f2", edgecolor="#0072b2", linewidth=1)
    axes.set_title(f"a wall tilted by {limit.refused:.4f}: the motion that proves that it fails", fontsize=10)
    axes.set_aspect("equal")
    axes.axis("off")
    plt.savefig(sys.argv[1], dpi=90, bbox_inches="tight")
