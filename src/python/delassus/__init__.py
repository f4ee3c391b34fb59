"""Discrete contact with dry friction: solve(W, q, mu), reduce(K, HN, HT), Motion(K, HN, HT, ...).

    u = W r + q,   0 <= u_n _|_ r_n >= 0,   |r_t| <= mu r_n,   slip opposes friction
"""

from ._library import VERSION as __version__
from ._library import Error, constants
from .contact import Progress, Solution, certify, solve
from .motion import Motion, NotCertified
from .reduction import Reduction, reduce

globals().update(constants)  # DLS_OK, DLS_NO_SOLUTION, ...

__all__ = ["Error", "Motion", "NotCertified", "Progress", "Proof", "Reduction", "Solution", "certify",
           "reduce", "solve", *constants]
