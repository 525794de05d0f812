"""A closed form asked at many times, by several processes where that pays.

Each answers for a stretch of the times.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from typing import NamedTuple, TypeAlias

from polhode.common.executors import in_order
from polhode.common.progress import Progress
from polhode.common.text_tables import few
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import Reference, reference
from polhode.numbers.scalars import Scalar
from polhode.scenes import added_families
from polhode.scenes.scene import Scene

PAYS = 4.0  # seconds of work from which on processes, which cost about one to start, are used
_TRIED = 8  # rows that tell what one costs
_PIECE, _LEAST = 1.0, 100  # seconds of work of a job, and rows that it has at least

#: Rows of mpf at times, to so many digits.
Ask: TypeAlias = Callable[[Sequence[Fraction], int], list[list[Scalar]]]

AnyReference: TypeAlias = Reference | Certified


class Job(NamedTuple):
    """A stretch of the times: ``question`` is a method of a reference."""

    scene: Scene
    question: str
    times: tuple[Fraction, ...]
    digits: int


def asked_by(known: Reference, question: str, workers: int, tell: Progress | None = None) -> Ask:
    """A reference's ``at``, ``attitude`` or ``angles``, by up to so many processes.

    ``tell``: called with the part of the rows that are there, and how many, where that takes long.
    """
    alone: Ask = getattr(known, question)

    def ask(times: Sequence[Fraction], digits: int) -> list[list[Scalar]]:
        if len(times) <= _TRIED:
            return alone(times, digits)
        some = [times[k] for k in few(len(times), _TRIED)]
        alone(some[-1:], digits)  # what is made once
        began = time.perf_counter()
        alone(some, digits)
        cost = (time.perf_counter() - began) / len(some)
        if cost * len(times) < PAYS:
            return alone(times, digits)
        size = min(-(-len(times) // workers), max(_LEAST, int(_PIECE / cost)))
        parts = [times[k : k + size] for k in range(0, len(times), size)]
        answers: Iterable[list[list[Scalar]]] = (alone(part, digits) for part in parts)
        elsewhere = not added_families.is_of_process(known.kind)
        if workers > 1 and elsewhere and reference(known.scene) == known:
            jobs = [Job(known.scene, question, tuple(part), digits) for part in parts]
            answers = in_order(answer, jobs, workers)
        found: list[list[Scalar]] = []
        for part in answers:
            found += part
            if tell is not None:
                tell(len(found) / len(times), len(found))
        return found

    return ask


def answer(job: Job) -> list[list[Scalar]]:
    """A job's rows."""
    rows: list[list[Scalar]] = getattr(_known(job.scene), job.question)(job.times, job.digits)
    return rows


_LAST: list[
    AnyReference
] = []  # the reference of a process's last job, with all that it has computed


def _known(scene: Scene) -> AnyReference:
    if not _LAST or _LAST[0].scene != scene:
        _LAST[:] = [reference(scene)]
    return _LAST[0]
