"""Limit loads of rigid blocks beside a linear programme (HiGHS of SciPy): 40 walls in running bond, pushed sideways,
and the least thickness of semicircular arches. Writes a page to $RESULTS/limit.md.

The blocks touch at the two ends of each joint. The programme is that of the associated law:
max lambda, H r + f0 + lambda f1 = 0, |r_t| <= mu r_n. From the top of the tree: /usr/bin/python3 bench/limit.py
"""
import os
import statistics
import subprocess
import sys
import time

import numpy as np
import scipy
import scipy.sparse as sp
from scipy.optimize import linprog

sys.path.insert(0, "src/python")
os.environ.setdefault("DELASSUS_LIBRARY", os.path.abspath("build/libdelassus.so.0"))
import delassus  # noqa: E402


def assemble(centres, joints):
    """H_N and H_T of joints (body, other or -1, point, normal): r_n along the normal on body."""
    H = np.zeros((2, 3 * len(centres), len(joints)))
    for j, (body, other, point, normal) in enumerate(joints):
        for b, sign in ((body, 1), (other, -1)):
            if b < 0:
                continue
            x, y = point - centres[b]
            for k, e in enumerate((normal, (-normal[1], normal[0]))):
                H[k, 3 * b:3 * b + 3, j] += sign * np.array([e[0], e[1], x * e[1] - y * e[0]])
    return H


def wall(rows, cols, height):
    """Blocks of length 1, half blocks at the ends of every second row; weight = area."""
    blocks = []
    for r in range(rows):
        cuts = list(range(cols + 1)) if r % 2 == 0 else [0, *np.arange(0.5, cols), cols]
        blocks += [(a, b, r) for a, b in zip(cuts[:-1], cuts[1:])]
    centres = [np.array([(a + b) / 2, (r + 0.5) * height]) for a, b, r in blocks]
    joints, up, right = [], (0.0, 1.0), (1.0, 0.0)
    for i, (a, b, r) in enumerate(blocks):
        if r == 0:
            joints += [(i, -1, np.array([x, 0.0]), up) for x in (a, b)]
        for k, (c, e, s) in enumerate(blocks):
            left, end = max(a, c), min(b, e)
            if s == r - 1 and end > left:
                joints += [(i, k, np.array([x, r * height]), up) for x in (left, end)]
            if s == r and e == a:
                joints += [(i, k, np.array([a, y * height]), right) for y in (r, r + 1)]
    weight = np.array([(b - a) * height for a, b, _ in blocks])
    f0, f1 = np.zeros(3 * len(blocks)), np.zeros(3 * len(blocks))
    f0[1::3], f1[0::3] = -weight, weight
    return assemble(centres, joints), f0, f1


def programme(H, f0, f1, mu):
    """The largest lambda of the associated law."""
    k, one = H.shape[2], sp.eye(H.shape[2])
    A = sp.csc_matrix(np.hstack([H[0], H[1], f1[:, None]]))
    G = sp.vstack([sp.hstack([-mu * one, s * one, sp.csc_matrix((k, 1))]) for s in (1, -1)])
    tight = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    end = linprog(np.r_[np.zeros(2 * k), -1], A_ub=G, b_ub=np.zeros(2 * k), A_eq=A, b_eq=-f0,
                  bounds=[(0, None)] * k + [(None, None)] * k + [(0, None)], method="highs", options=tight)
    assert end.status == 0, end.message
    return -end.fun


def reduction(H):
    n = H.shape[1]
    return delassus.reduce(sp.csc_matrix((n, n)), sp.csc_matrix(H[0]), sp.csc_matrix(H[1]))


def walls(out):
    sizes = [(2, 5), (3, 4), (4, 4), (5, 4), (5, 6), (7, 5), (8, 6), (8, 9), (10, 11), (10, 19)]
    widest, solves, unproved, outside, ours, theirs = 0.0, [], 0, 0, 0.0, 0.0
    out += ["Friction .3, .45, .6 and .75; the table has .75, the screen all.", "",
            "| rows x columns | blocks | contacts | carried | refused | programme | solves |",
            "|---|---|---|---|---|---|---|"]
    for rows, cols in sizes:
        for mu in (0.3, 0.45, 0.6, 0.75):
            H, f0, f1 = wall(rows, cols, 0.5)
            begun = time.process_time()
            found = reduction(H).limit(f1, mu=np.full(H.shape[2], mu), f=f0)
            middle = time.process_time()
            best = programme(H, f0, f1, mu)
            ours, theirs = ours + middle - begun, theirs + time.process_time() - middle
            width = found.refused / found.carried - 1
            widest, unproved = max(widest, width), unproved + (not found.proved)
            outside += not found.carried * (1 - 1e-9) <= best <= found.refused * (1 + 1e-9)
            solves.append(found.solves)
            line = (f"| {rows} x {cols} | {len(f0) // 3} | {H.shape[2]} | {found.carried:.8f} | "
                    f"{found.refused:.8f} | {best:.8f} | {found.solves} |")
            print(mu, line, flush=True)
            out += [line] if mu == .75 else []
    out += ["", f"Limits without a proof: {unproved} of {len(solves)}. Programme outside carried .. refused: "
            f"{outside}. Widest bracket {widest:.1e} of the limit.",
            f"Solves: median {statistics.median(solves):g}, most {max(solves)}. "
            f"CPU time: {ours / theirs:.1f} times that of the programme.", ""]


def arch(n, thick):
    """A semicircle of mean radius 1, n blocks between radial joints; weight = area."""
    cuts, inner, outer = np.linspace(0, np.pi, n + 1), 1 - thick / 2, 1 + thick / 2
    a, b = cuts[:-1], cuts[1:]
    area, moment = (outer**2 - inner**2) * (b - a) / 2, (outer**3 - inner**3) / 3
    centres = np.c_[moment * (np.sin(b) - np.sin(a)), moment * (np.cos(a) - np.cos(b))] / area[:, None]
    joints = [(j if j < n else -1, j - 1, r * np.array([np.cos(t), np.sin(t)]), (-np.sin(t), np.cos(t)))
              for j, t in enumerate(cuts) for r in (inner, outer)]
    f0 = np.zeros(3 * n)
    f0[1::3] = -area
    return assemble(centres, joints), f0


def arches(out):
    def least(stands):
        low, high = 0.05, 0.3
        while high - low > 2e-7:
            low, high = (low, (low + high) / 2) if stands((low + high) / 2) else ((low + high) / 2, high)
        return high

    unproved = []

    def ours(thick, n, mu):
        H, f0 = arch(n, thick)
        end = reduction(H).solve(np.full(H.shape[2], mu), f0)
        if not end.solved and end.status != delassus.DLS_NO_SOLUTION:
            unproved.append((n, mu, thick))
        return end.solved

    def theirs(thick, n, mu):
        H, f0 = arch(n, thick)
        k = H.shape[2]
        G = np.vstack([np.hstack([-mu * np.eye(k), s * np.eye(k)]) for s in (1, -1)])
        return linprog(np.zeros(2 * k), A_ub=G, b_ub=np.zeros(2 * k), A_eq=np.hstack([H[0], H[1]]), b_eq=-f0,
                       bounds=[(0, None)] * k + [(None, None)] * k, method="highs").status == 0

    out += ["The least thickness over the mean radius of a semicircular arch under its weight, by halving:", "",
            "| blocks | friction | least thickness | programme |", "|---|---|---|---|"]
    for n in (13, 27, 54, 120):
        for mu in (0.7, 0.35, 0.32, 0.309):
            both = least(lambda t: ours(t, n, mu)), least(lambda t: theirs(t, n, mu))
            out.append(f"| {n} | {mu} | {both[0]:.7f} | {both[1]:.7f} |")
            print(out[-1], flush=True)
    out += ["", f"0.3 is the end of the search. Trials with neither an answer nor a proof: {len(unproved)}."]


def long_arch(out):
    """1,000 voussoirs pushed sideways with lambda times their weight."""
    H, f0 = arch(1000, 0.15)
    f1, mu = np.zeros_like(f0), 0.7
    f1[0::3] = -f0[1::3]
    begun = time.process_time()
    found = reduction(H).limit(f1, mu=np.full(H.shape[2], mu), f=f0)
    middle = time.process_time()
    best = programme(H, f0, f1, mu)
    end = time.process_time()
    out += ["", f"A semicircle of 1,000 blocks, thickness 0.15, friction {mu}, pushed sideways: carried "
            f"{found.carried:.8f}, refused {found.refused:.8f}, programme {best:.8f}, {found.solves} solves, "
            f"{middle - begun:.2f} s of CPU, {(middle - begun) / (end - middle):.2f} times that of the programme.", ""]
    print(out[-2], flush=True)


if __name__ == "__main__":
    page = ["# Limit loads beside a linear programme", "",
            f"`/usr/bin/python3 bench/limit.py`: {subprocess.check_output('bench/where.sh', text=True).strip()}, HiGHS of SciPy "
            f"{scipy.__version__}. Walls in running bond under their "
            "weight, lambda times the weight sideways; blocks 1 x 0.5.", ""]
    walls(page)
    arches(page)
    long_arch(page)
    with open(os.path.join(os.environ.get("RESULTS", "bench/results"), "limit.md"), "w") as file:
        file.write("\n".join(page).rstrip() + "\n")
