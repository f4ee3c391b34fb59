#!/usr/bin/env python3
"""states.py SEED COUNT: judges auto by all states of small problems in 2D, W of any rank and sign, in exact fractions.

For each choice of free, stick and both slips the equations of u and r are solved without rounding; what meets the laws is
an answer. A verdict that none of them bears out is on a border if the answers come, go or jump when q moves by 1e-8 |q|,
or if each is so large that rounding of W alone is as large as q. What is left is printed with its seed; exit status 1.
"""
import itertools
import sys
from fractions import Fraction

import numpy as np

import delassus

TOL = 1e-8


def solve_exactly(A, b):
    """Returns x with A x = b, None if A is singular."""
    n = len(b)
    T = [row[:] + [b[i]] for i, row in enumerate(A)]
    for p in range(n):
        r = next((r for r in range(p, n) if T[r][p]), None)
        if r is None:
            return None
        T[p], T[r] = T[r], T[p]
        for i in range(n):
            if i != p and T[i][p]:
                f = T[i][p] / T[p][p]
                T[i] = [a - f * c for a, c in zip(T[i], T[p])]
    return [T[p][n] / T[p][p] for p in range(n)]


def answers(W, q, mu):
    """Returns the answers, and 1 if some states have a singular matrix."""
    m, found, singular = len(q), [], 0
    W = [[Fraction(x) for x in row] for row in W]
    q, mu = [Fraction(x) for x in q], [Fraction(x) for x in mu]
    for states in itertools.product("osrl", repeat=len(mu)):  # open, stick, slip to the right and the left
        columns, rows = [], []
        for c, s in enumerate(states):
            n, t = 2 * c, 2 * c + 1
            if s == "s":
                columns += [{n: Fraction(1)}, {t: Fraction(1)}]
                rows += [n, t]
            elif s != "o":
                columns.append({n: Fraction(1), t: mu[c] if s == "r" else -mu[c]})
                rows.append(n)
        x = solve_exactly([[sum(W[i][k] * v for k, v in col.items()) for col in columns] for i in rows], [-q[i] for i in rows])
        if x is None:
            singular = 1
            continue
        r = [sum(v * col.get(k, 0) for v, col in zip(x, columns)) for k in range(m)]
        u = [q[i] + sum(W[i][j] * r[j] for j in range(m)) for i in range(m)]
        good = all(u[2 * c] >= 0 if s == "o" else r[2 * c] >= 0 and
                   (abs(r[2 * c + 1]) <= mu[c] * r[2 * c] if s == "s" else (u[2 * c + 1] <= 0) == (s == "r") or not u[2 * c + 1])
                   for c, s in enumerate(states))
        if good and r not in found:
            found.append(r)
    return [np.array([float(x) for x in r]) for r in found], singular


def draw(rng):
    nc = int(rng.integers(1, 4))
    m, kind = 2 * nc, int(rng.integers(5))
    H = rng.integers(-2, 3, (m, m)).astype(float) if rng.random() < .5 else rng.normal(size=(m, m))
    H = H[:int(rng.integers(1, m + 1))]
    W = H.T @ H
    if kind == 1:
        W += np.eye(m)
    elif kind == 2:
        W += np.diag(2.0 ** -rng.integers(0, 40, m))
    elif kind == 3:
        W += np.where(rng.random((m, m)) < .25, rng.integers(-1, 2, (m, m)), 0)
    elif kind == 4:
        W = rng.integers(-3, 4, (m, m)).astype(float)
    q = rng.integers(-4, 4, m).astype(float) if rng.random() < .5 else rng.normal(size=m) - .5
    return W, q, rng.choice([0, .25, .5, 1, 2, 8, .3, .7, 100, 1e-3], nc)


def is_near(r, found):
    return any(np.linalg.norm(r - x) <= 1e-3 * max(np.linalg.norm(x), np.linalg.norm(r)) for x in found)


def fair(W, q, found):
    return [x for x in found if np.abs(W).max() * np.linalg.norm(x) < 1e6 * np.linalg.norm(q)]


def wrong(s, W, q, found):
    """Returns what is wrong with a verdict, "" for nothing."""
    if s.solved and not is_near(s.r.ravel(), found):
        return "solved, none near"
    if not s.solved and found and (s.status == delassus.DLS_NO_SOLUTION or fair(W, q, found)):
        return f"status {s.status}, but there is one"
    return ""


def is_border(W, q, mu, r, found, singular, rng):
    usual = len(fair(W, q, found))
    if singular or not usual and found:
        return True
    for _ in range(40):
        moved, singular = answers(W, q + TOL * np.linalg.norm(q) * rng.normal(size=len(q)), mu)
        if singular or len(fair(W, q, moved)) != usual or is_near(r, moved):
            return True
    return False


def main():
    seed, count = int(sys.argv[1]), int(sys.argv[2])
    tally = {"solved": 0, "no answer": 0, "border": 0, "left": 0}
    for k in range(seed, seed + count):
        rng = np.random.default_rng(k)
        W, q, mu = draw(rng)
        s = delassus.solve(W, q, mu, d=2)
        found, singular = answers(W, q, mu)
        what = wrong(s, W, q, found) if found or not singular else ""
        if what and s.status != delassus.DLS_NO_SOLUTION and is_border(W, q, mu, s.r.ravel(), found, singular, rng):
            tally["border"] += 1
        elif what:
            tally["left"] += 1
            print(f"seed {k}: {what}\n{W.tolist()} {q.tolist()} {mu.tolist()} {s.r.tolist()}")
        else:
            tally["solved" if s.solved else "no answer"] += 1
    print(", ".join(f"{n} {name}" for name, n in tally.items()))
    return tally["left"] > 0


if __name__ == "__main__":
    sys.exit(main())
