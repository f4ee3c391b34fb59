"""Discrete contact with dry friction: solve(W, q, mu), reduce(K, HN, HT), Motion(K, HN, HT, ...).

    u = W r + q,   0 <= u_n _|_ r_n >= 0,   |r_t| <= mu r_n,   slip opposes friction
"""

from typing import List

from ._library import VERSION as __version__
from ._library import (Error, InputError, NoDerivativeError, OutOfMemoryError, SingularError,
                       StateError, UnsupportedError, constants)
from .batch import Batch, solve_many
from .contact import Certificate, Fold, Progress, Proof, Solution, Stage, certify, solve
from .derivative import Gradient, Moved
from .files import read_matrix
from .geometry import Pairs, RigidBodies, pairs
from .lcp import LcpSolution, solve_lcp
from .motion import Motion, NotCertified
from .reduction import Limit, Reduction, reduce
from .solver import Solver
from .surface import Sum

__all__ = ["Batch", "Certificate", "Error", "Fold", "Gradient", "InputError", "LcpSolution", "Limit",
           "Motion",           "Moved", "NoDerivativeError", "NotCertified", "OutOfMemoryError", "Pairs", "Progress",
           "Proof", "Reduction", "RigidBodies", "SingularError", "Solution", "Solver", "Stage",
           "StateError", "Sum", "UnsupportedError", "__version__", "certify", "constants", "pairs",
           "read_matrix", "reduce", "solve", "solve_lcp", "solve_many"]


def __getattr__(name: str) -> int:
    """DLS_OK, DLS_NO_SOLUTION, ...: the constants of C."""
    if name not in constants:
        raise AttributeError(f"module 'delassus' has no attribute {name!r}")
    return constants[name]


def __dir__() -> List[str]:
    return sorted([*globals(), *constants])
