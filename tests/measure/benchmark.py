"""What scenes, bodies, closed forms, commands and pages cost; runs and sweeps: the study speed.

    python tests/measure/benchmark.py                     every group
    python tests/measure/benchmark.py scenes bodies       some of them
    python tests/measure/benchmark.py scenes --seconds 5  longer: narrower intervals

Jobs that are compared run side by side in one process, in turn, for about so many seconds each:
:func:`side_by_side`.  What counts is processor time, so that other work on the machine disturbs
little; a run of a millisecond still shares the caches with it.  A ratio is the median of those of
all rounds, with the interval that holds the true median in 95 of 100 cases.  Nothing here passes or
fails: "wanted" is what a change should keep to.
"""

from __future__ import annotations

import argparse
import math
import resource
import statistics
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

Job = Callable[[], Any]
Clock = Callable[[], float]

_ROUNDS = 5  # at least, whatever a job takes
_LOOK = 0.002  # seconds between two looks at the clock


class Timing(NamedTuple):
    """Of a job: its least seconds, and its ratio to the first job's, with an interval."""

    seconds: float
    ratio: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.ratio:.3f} [{self.low:.3f}, {self.high:.3f}]"


class Line(NamedTuple):
    """A row of the table: what was measured, what came out, and what is wanted, if anything."""

    measure: str
    value: object
    wanted: str = ""


def of_children() -> float:
    """Processor seconds of this process's children that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def side_by_side(
    jobs: Sequence[Job],
    seconds: float,
    calls: int | None = None,
    clock: Clock = time.process_time,
) -> list[Timing]:
    """Times of jobs in turn, for about ``seconds`` a job; one round before does not count.

    ``calls``: of each job in a row between two looks at the clock, as many as take 2 ms unless
    given; seconds are those of one call.
    """
    many = [calls or 1 for _ in jobs]
    rounds = [_round(jobs, many, clock)]
    if calls is None:
        many = [math.ceil(_LOOK / max(spent, _LOOK / 10_000)) for spent in rounds[0]]
    end = clock() + seconds * len(jobs)
    while len(rounds) <= _ROUNDS or clock() < end:
        rounds.append(_round(jobs, many, clock))
    columns = [*zip(*rounds[1:], strict=True)]
    return [Timing(min(one), *_median(one, columns[0])) for one in columns]


def _round(jobs: Sequence[Job], many: Sequence[int], clock: Clock) -> list[float]:
    """The seconds of a call of each job, called so many times."""
    taken = []
    for job, calls in zip(jobs, many, strict=True):
        began = clock()
        for _ in range(calls):
            job()
        taken.append((clock() - began) / calls)
    return taken


def _median(times: Sequence[float], others: Sequence[float]) -> tuple[float, float, float]:
    """The median ratio, and the order statistics that enclose it with a chance of 95 %."""
    ratios = sorted(one / other for one, other in zip(times, others, strict=True))
    reach = 0.98 * math.sqrt(len(ratios))
    low, high = math.floor(len(ratios) / 2 - reach), math.ceil(len(ratios) / 2 + reach)
    return statistics.median(ratios), ratios[max(low, 0)], ratios[min(high, len(ratios) - 1)]


class Group(NamedTuple):
    """``module``: of measure.timings, which has the function."""

    module: str
    about: str


GROUPS = {
    "scenes": Group("bodies", "scenes made and run again, bodies of a known pattern"),
    "bodies": Group("bodies", "the first body of a process, the disk cache"),
    "closed_forms": Group("references", "set-up and states of closed forms; over runs"),
    "commands": Group("references", "whole commands over the bare imports"),
    "frames": Group("frames", "a frame of an animated page, in a browser"),
}


def lines(name: str, seconds: float) -> Iterator[Line]:
    """What a group measures, as it comes."""
    found: Iterator[Line] = getattr(import_module(f"measure.timings.{GROUPS[name].module}"), name)(
        seconds
    )
    return found


def main(arguments: Sequence[str]) -> int:
    """Print the groups asked for; 2 where one is asked for that there is not."""
    told = "\n".join(f"  {name:14s}{group.about}" for name, group in GROUPS.items())
    parser = argparse.ArgumentParser(
        description=f"Timings.  Groups:\n{told}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("groups", nargs="*", metavar="GROUP")
    parser.add_argument("--seconds", type=float, default=1.0, help="of each job (1)")
    given = parser.parse_args(arguments)
    for name in given.groups:
        if name not in GROUPS:
            print(f"benchmark: {name}: expected one of {', '.join(GROUPS)}", file=sys.stderr)
            return 2
    print(f"{'measure':58s} {'found':32s} wanted")
    for name in given.groups or GROUPS:
        print(f"\n{name}: {GROUPS[name].about}")
        for line in lines(name, given.seconds):
            print(f"{line.measure:58s} {line.value!s:32s} {line.wanted}".rstrip(), flush=True)
    return 0


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))
    from measure import benchmark  # by the name that the groups import it by

    raise SystemExit(benchmark.main(sys.argv[1:]))
