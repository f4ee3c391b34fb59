"""Prints the lines that test_door.c compares, by the package delassus."""

import struct

import numpy as np

import delassus

K, HN, HT = np.array([[3.0, 1.0], [1.0, 2.0]]), [[0.0], [1.0]], [[1.0], [0.0]]
SPRING, FIRST = np.array([[5.0, -5.0], [-5.0, 5.0]]), [[1.0], [0.0]]
NONE = [[0.0], [0.0]]  # without it the reduction would have d = 1


def put(name, s, c):
    values = [*s.r[0], *s.u[0], *s.x, c.residual, c.equilibrium]
    print(name, s.status, *(struct.pack(">d", v).hex().upper() for v in values))


s = delassus.reduce(K, HN, HT).solve(mu=0.2, f=[5, -10])
put("held", s, s.certificate)
R = delassus.reduce(K, HN, HT, on="K")
s = R.solve(mu=0.2, f=[5, -10])
put("on-K", s, R.certify(s.r, s.x, mu=0.2))
s = delassus.reduce(SPRING, FIRST, NONE).solve(f=[0, -10], g=[[1, 0]])
put("pressed", s, s.certificate)
try:
    delassus.reduce(SPRING, FIRST, NONE, on="W")
except delassus.Error as e:
    print("on-W", e.status)
s = delassus.reduce(SPRING, FIRST, NONE).solve(f=[0, 10], g=[[1, 0]])
put("flies", s, s.certificate)
