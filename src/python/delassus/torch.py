"""Contact as a layer of torch: solve(W, q, mu) and solve_body(reduction, f, g, mu) or
solve_body(K, f, g, mu, HN=.., HT=..), differentiable in every tensor among these arguments.

Tensors are used in double precision on the CPU; so are results. backward() solves with the factors
of one matrix (Solution.vjp). At a kink of the solution it raises NoDerivativeError, or with side=0
or side=1 takes the derivative of one side. If the problem is not solved, NotSolvedError is raised,
because there is no solution to differentiate. The import fails without torch.
"""

from __future__ import annotations

import importlib
from typing import Any, Callable, List, Tuple

from . import contact, reduction
from ._library import NoDerivativeError

torch: Any = importlib.import_module("torch")


class NotSolvedError(ArithmeticError):
    """The solve stopped early; solution has its best answer."""

    def __init__(self, solution: contact.Solution) -> None:
        super().__init__(solution.words)
        self.solution = solution


def _array(a: Any) -> Any:
    """Returns a tensor as an array of doubles, anything else as it is."""
    if not torch.is_tensor(a):
        return a
    return a.detach().to(device="cpu", dtype=torch.float64).numpy()


def _backward(context: Any, *loss: Any) -> Any:
    if context.failure is not None:
        raise context.failure
    gradient = context.solution.vjp(*map(_array, loss), side=context.side)
    out: List[Any] = [None, None, None]
    for name, kind, needed in zip(context.names, context.kinds, context.needs_input_grad[3:]):
        if not needed:
            out.append(None)
            continue
        g = torch.as_tensor(getattr(gradient, name))
        shape, dtype, device = kind
        g = g.sum() if not shape and g.numel() > 1 else g  # one number for all contacts
        out.append(g.reshape(shape).to(dtype=dtype, device=device))
    return tuple(out)


class _Layer(torch.autograd.Function):  # type: ignore[misc]
    """answer (r, u[, x]) := run(data), with backward by the solution's vjp. names: of the data in
    the Gradient."""

    @staticmethod
    def forward(context: Any, run: Callable[..., contact.Solution], names: Tuple[str, ...],
                side: int | None, *data: Any) -> Any:
        solution = run(*map(_array, data))
        if not solution.solved:
            raise NotSolvedError(solution)
        context.solution, context.names, context.side = solution, names, side
        context.failure = None
        if any(context.needs_input_grad):
            try:
                solution._derivative(side)  # now: a reduction may take another load later
            except NoDerivativeError as failure:
                context.failure = failure
        context.kinds = [(a.shape, a.dtype, a.device) if torch.is_tensor(a) else None for a in data]
        parts = [solution.r, solution.u] + ([] if solution.x is None else [solution.x])
        return tuple(torch.from_numpy(part.copy()) for part in parts)

    backward = staticmethod(torch.autograd.function.once_differentiable(_backward))


def solve(W: Any, q: Any, mu: Any, *, side: int | None = None, **options: Any) -> Tuple[Any, Any]:
    """Returns r and u, nc x d, of delassus.solve(W, q, mu, **options). W: a dense tensor, or as
    there and then without a gradient."""
    def run(W: Any, q: Any, mu: Any) -> contact.Solution:
        return contact.solve(W, q, mu, **options)

    r, u = _Layer.apply(run, ("W", "q", "mu"), side, W, q, mu)
    return r, u


def solve_body(K: Any, f: Any, g: Any, mu: Any, *, HN: Any = None, HT: Any = None,
               side: int | None = None, **options: Any) -> Tuple[Any, Any, Any]:
    """Returns r, u (nc x d) and x (n) of a Reduction, or of reduce(K, HN, HT) for a dense tensor
    K, symmetric or not; then each call factorises K. options: of Reduction.solve. No update of the
    Reduction between this call and backward()."""
    def run(K: Any, f: Any, g: Any, mu: Any) -> contact.Solution:
        body = K if isinstance(K, reduction.Reduction) else reduction.reduce(K, HN, HT)
        return body.solve(mu, f, g, **options)

    r, u, x = _Layer.apply(run, ("K", "f", "g", "mu"), side, K, f, g, mu)
    return r, u, x
