#!/usr/bin/env python3
"""Checks proofs that a problem has no solution, in rational arithmetic.

    OPENBLAS_NUM_THREADS=1 build/tests/facts/test_proof print 10000 | tests/exact_farkas.py

Reads a verdict a line: "lcp n", M by columns, q, v, or "contact2 nc", "contact3 nc", W by columns, q,
mu, v (local order n, t, s), numbers as the C format %a. A proof is

    lcp:      v >= 0,  M' v <= 0,  q.v < 0
    contact:  v >= 0,  q_n.v < 0,  g_n + mu |g_t| <= 0 for each candidate, g = the normal rows' v' W
"""
import sys
from fractions import Fraction


def dot(a, b):
    return sum((x * y for x, y in zip(a, b) if x and y), Fraction(0))


def proves_lcp(n, x):
    m, q, v = x[: n * n], x[n * n : n * n + n], x[n * n + n :]
    return (
        len(v) == n
        and min(v) >= 0
        and dot(q, v) < 0
        and all(dot(m[j * n : j * n + n], v) <= 0 for j in range(n))
    )


def proves_contact(d, nc, x):
    m = d * nc
    w, q, mu, v = x[: m * m], x[m * m : m * m + m], x[m * m + m : m * m + m + nc], x[m * m + m + nc :]
    g = [dot(w[j * m : j * m + m : d], v) for j in range(m)]
    return (
        len(v) == nc
        and min(v) >= 0
        and dot(q[::d], v) < 0
        and all(
            g[i] <= 0 and mu[i // d] ** 2 * sum(y * y for y in g[i + 1 : i + d]) <= g[i] ** 2
            for i in range(0, m, d)
        )
    )


def main():
    count = {"lcp": 0, "contact2": 0, "contact3": 0}
    wrong = 0
    for line in sys.stdin:
        kind, n, *numbers = line.split()
        if kind not in count:  # what the test program says of itself
            continue
        x = [Fraction(float.fromhex(word)) for word in numbers]
        count[kind] += 1
        good = proves_lcp(int(n), x) if kind == "lcp" else proves_contact(int(kind[-1]), int(n), x)
        if not good:
            wrong += 1
            print("no proof:", line, end="")
    print(f"{count['lcp']} LCPs, {count['contact2']} contact problems in 2D, {count['contact3']} in 3D, {wrong} without an exact proof")
    return wrong > 0 or sum(count.values()) == 0


sys.exit(main())
