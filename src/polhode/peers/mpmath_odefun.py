"""mpmath.odefun: a Taylor method in Python, here at the 53 bits of a double."""

from __future__ import annotations

from polhode.peers.field import returning
from polhode.peers.protocol import Problem, Solution, Solve, serve


def load() -> str:
    """Import mpmath."""
    import mpmath

    return f"mpmath {mpmath.__version__}"


def build(problem: Problem) -> Solve:
    """Nothing to compile."""
    import mpmath

    rates = returning(problem.coefficients)

    def solve(tol: float) -> Solution:
        with mpmath.workprec(53):
            at = mpmath.odefun(lambda t, y: list(rates(*y)), 0, list(problem.start), tol=tol)
            return Solution([at(t) for t in problem.times])

    return solve


if __name__ == "__main__":
    serve(load, build)
