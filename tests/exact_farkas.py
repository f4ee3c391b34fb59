#!/usr/bin/env python3
"""Checks proofs that a problem has no solution, in rational arithmetic.

    OPENBLAS_NUM_THREADS=1 build/tests/front/test_proof print 10000 | tests/exact_farkas.py

Reads a verdict a line: "lcp n", M by columns, q, v, or "contact nc", W by columns, q, mu, v (d = 2,
local order n, t), numbers as the C format %a. A proof is

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


def proves_contact(nc, x):
    m = 2 * nc
    w, q, mu, v = x[: m * m], x[m * m : m * m + m], x[m * m + m : m * m + m + nc], x[m * m + m + nc :]
    g = [dot(w[j * m : j * m + m : 2], v) for j in range(m)]
    return (
        len(v) == nc
        and min(v) >= 0
        and dot(q[::2], v) < 0
        and all(g[2 * c] + mu[c] * abs(g[2 * c + 1]) <= 0 for c in range(nc))
    )


def main():
    count = {"lcp": 0, "contact": 0}
    wrong = 0
    for line in sys.stdin:
        kind, n, *numbers = line.split()
        if kind not in count:  # what the test program says of itself
            continue
        x = [Fraction(float.fromhex(word)) for word in numbers]
        count[kind] += 1
        if not (proves_lcp if kind == "lcp" else proves_contact)(int(n), x):
            wrong += 1
            print("no proof:", line, end="")
    print(f"{count['lcp']} LCPs, {count['contact']} contact problems, {wrong} without an exact proof")
    return wrong > 0 or sum(count.values()) == 0


sys.exit(main())
