"""polhode as a process like those of the peers: ``python -m polhode.studies.isolated_process <
job``.

It takes the exact scene by the name of its case instead of rounded numbers, and rounds it itself;
see polhode.peers.protocol.  What a run spends on making its integrator belongs to the compile
column, as the peers' does.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from polhode.peers.protocol import Solution, Solve, serve


@dataclass(frozen=True)
class Job:
    """A scene at its times, a number type, and whether to project."""

    scene: Any
    number: str
    project: bool

    @classmethod
    def read(cls, job: dict[str, Any]) -> Job:
        """From the job's JSON."""
        from polhode.studies.peer_processes import plain_scene

        times = tuple(Fraction(float.fromhex(t)) for t in job["times"])
        number, _, projected = job["method"].partition(" ")
        return cls(plain_scene(job["case"], times), number, bool(projected))


def load() -> str:
    """Import what a run needs."""
    from polhode.common.provenance import versions
    from polhode.taylor.integrator import stepping  # noqa: F401

    found = versions()
    return f"polhode {found['polhode']}, heyoka {found['heyoka']}"


def build(job: Job) -> Solve:
    """Compile the integrator at the type's own tolerance, and the projection."""
    from polhode.judging.adaptive_precision import integrate
    from polhode.numbers.number_types import named

    eps = float(named(job.number).eps)

    def solve(tol: float) -> Solution:
        tolerance = None if tol <= eps else tol
        run = integrate(job.scene, job.number, tol=tolerance, project=job.project)
        if not run.outcome.done:
            raise ArithmeticError(run.outcome.cause)
        return Solution(run.states, run.steps, run.seconds["build"])

    few = 200 if job.number in ("double", "extended") else 2  # past the first projection
    integrate(job.scene, job.number, max_steps=few, project=job.project)
    return solve


def written(x: Any) -> str:
    """A number as text that is exactly it."""
    from polhode.numbers.conversion import exactly

    return float(x).hex() if isinstance(x, float) else str(exactly(x))


if __name__ == "__main__":
    serve(load, build, read=Job.read, written=written)
