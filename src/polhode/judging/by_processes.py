"""A closed form asked at many times, by several processes where that pays.

Each answers for a stretch of the times; numbers travel as mantissas and exponents, so that none is
rounded on the way.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from polhode.common.text import few
from polhode.judging.reference import Reference, reference
from polhode.numbers.private import mpmath, ordinary
from polhode.runs.workers import in_order
from polhode.scenes.scene import Scene

PAYS = 4.0  # seconds of work from which on processes, which cost about one to start, are used
_TRIED = 8  # rows that tell what one costs

#: Rows of mpf at times, to so many digits.
Ask = Callable[[Sequence[Fraction], int], list[Any]]


class Job(NamedTuple):
    """A stretch of the times: ``question`` is a method of a reference."""

    scene: Scene
    question: str
    times: tuple[Fraction, ...]
    digits: int


def asked_by(known: Reference, question: str, workers: int) -> Ask:
    """A reference's ``at``, ``attitude`` or ``angles``, by up to so many processes."""
    alone: Ask = getattr(known, question)

    def ask(times: Sequence[Fraction], digits: int) -> list[Any]:
        if workers == 1 or len(times) <= _TRIED or reference(known.scene) != known:
            return alone(times, digits)
        some = [times[k] for k in few(len(times), _TRIED)]
        began = time.perf_counter()
        alone(some, digits)
        if (time.perf_counter() - began) / len(some) * len(times) < PAYS:
            return alone(times, digits)
        size = -(-len(times) // workers)
        jobs = [
            Job(known.scene, question, tuple(times[k : k + size]), digits)
            for k in range(0, len(times), size)
        ]
        return [
            [_number(x) for x in row] for part in in_order(answer, jobs, workers) for row in part
        ]

    return ask


def answer(job: Job) -> list[list[tuple[int, int] | None]]:
    """A job's rows: mantissas and exponents of two, None where there is no number."""
    rows = getattr(reference(job.scene), job.question)(job.times, job.digits)
    return [[None if x is None else _parts(x) for x in row] for row in rows]


def _parts(x: Any) -> tuple[int, int]:
    negative, mantissa, exponent, _ = x._mpf_
    return int(-mantissa if negative else mantissa), int(exponent)


def _number(parts: tuple[int, int] | None) -> Any:
    """An mpf of as many bits as it needs."""
    if parts is None:
        return None
    mantissa, exponent = parts
    with mpmath.workprec(max(mantissa.bit_length(), 1)):
        return ordinary(mpmath.ldexp(mantissa, exponent))
