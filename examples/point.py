# point.py: the program of README.md in Python: a point on springs is pushed onto the floor y = 0 and
# slides to the right.
#
# Output:
#   solved: r_n = 10.9375, r_t = -2.1875, x = 0.9375
#   ['slip']
import numpy as np
import scipy.sparse as sp

import delassus

K = sp.csc_matrix([[3.0, 1.0], [1.0, 2.0]])
HN = np.array([[0.0], [1.0]])  # picks y
HT = np.array([[1.0], [0.0]])  # picks x
s = delassus.reduce(K, HN, HT).solve(mu=0.2, f=[5.0, -10.0])
print(f"{s.words}: r_n = {s.r[0, 0]:g}, r_t = {s.r[0, 1]:g}, x = {s.x[0]:g}")
print(s.states)
