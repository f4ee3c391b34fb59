"""moving.py: contact that moves over a body that is factorised once, beside a new reduction for each place.

An elastic cube of 24^3 nodes, n = 41,472 unknowns; 60 contacts between nodes of a strip of 302 nodes. Prints
CPU ratios of one run: a new reduction over dls_reduction_move and the solve on W; and how far r is apart.
"""
import sys
import time

import numpy as np
import scipy.sparse as sp

import delassus

side, contacts = 24, 60
line = sp.diags([2.0, -1.0, -1.0], [0, 1, -1], (side, side))
I = sp.eye(side)
lattice = sp.kron(sp.kron(line, I), I) + sp.kron(sp.kron(I, line), I) + sp.kron(sp.kron(I, I), line)
K = sp.kron(lattice, np.array([[2, .3, .1], [.3, 2, .2], [.1, .2, 2.]]), format="csc")
n = K.shape[0]
f = np.zeros(n)
f[2::3] = -.01
surface = np.arange(3 * (5 * contacts + 2))


def sides(shift):
    node, c = 5 * np.arange(contacts) + shift, np.arange(contacts)
    N = (np.tile([.6, .4], contacts), (np.c_[3 * node + 2, 3 * node + 5].ravel(), np.repeat(c, 2)))
    T = (np.ones(2 * contacts), (np.c_[3 * node, 3 * node + 1].ravel(), np.arange(2 * contacts)))
    return sp.csc_matrix(N, (n, contacts)), sp.csc_matrix(T, (n, 2 * contacts))


def timed(call, *arguments, **options):
    begun = time.process_time()
    return call(*arguments, **options), time.process_time() - begun


R, once = timed(delassus.reduce, K, *sides(0), surface=surface)
R.load(f)
good, rows = True, []
for shift in range(4):
    other, create = timed(delassus.reduce, K, *sides(shift), on="W")
    _, move = timed(R.move, *sides(shift))
    s, on_W = timed(delassus.solve, R.W, R.q, .3)
    whole, body = timed(R.solve, .3)
    r = other.solve(.3, f).r
    apart = abs(whole.r - r).max() / abs(r).max()
    good &= s.solved and whole.solved and apart < 2e-8
    rows.append((create / (move + on_W), create / (move + body), once / create, apart))
a = np.median(rows, axis=0)
print(f"n = {n}, {surface.size} unknowns on the surface, {contacts} contacts: a new reduction costs {a[0]:.0f} times as "
      f"much as a move and the solve on W, {a[1]:.0f} times as a move and x; condensed once: {a[2]:.1f} reductions; "
      f"r apart by {a[3]:.0e}")
sys.exit(not good)
