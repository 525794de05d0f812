"""Sweeps of which some numbers a member are kept, and no state of all members at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from polhode.common.arguments import steps, whole, with_progress
from polhode.common.checkpoint import JobCheckpoint
from polhode.common.errors import counted
from polhode.common.interrupts import Progress
from polhode.common.processes import run_jobs
from polhode.dynamics.observables import Reduced, check, job_of, reductions_of, solve
from polhode.motion.outcomes import OUTCOMES, Outcome, code
from polhode.numbers.number_types import AnyNumber, NumberType, Stack, kind_of
from polhode.results.table import Column, Fact, Table
from polhode.runs.ensemble import SweepResult
from polhode.runs.integrate_many import planned, varied_of
from polhode.runs.members import Members
from polhode.scenes import library, vary
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import (
    provenance_fact,
    scene_facts,
    text_column,
    unit_of,
    varied_columns,
)
from polhode.scenes.vocabulary import REQUESTS

MOST_AT_ONCE = 1 << 22  # numbers of states that one job may hold: 32 MB of doubles
_JOBS = 256  # at most, but for that
LANES = 8  # a job has a multiple of so many members


@dataclass(frozen=True, eq=False, repr=False)
class Reductions(SweepResult):
    """Some numbers of each member of a sweep, without its states.

    >>> import polhode
    >>> found = polhode.reduce_many(
    ...     "lagrange/nutation", {"start.omega[3]": "2:4:3"}, keep=["largest theta", "final"]
    ... )
    >>> found
    <Reductions of lagrange/nutation: 3 members in double, 8 numbers each, all reached the end>
    >>> found["largest theta"].shape, found.names[:3]
    ((3,), ('largest theta', 't of largest theta', 'final p'))

    ``numbers``: arrays (members,) by name, float64 or longdouble, in the scene's body axes and
    units; nan for members that did not reach the end, and for a first event that does not happen.
    ``kept``: the folder of finished jobs, to be removed.  ``endings``: indices into
    ``polhode.motion.outcomes.OUTCOMES``; ``counts``: steps.
    """

    scene: Scene
    varied: vary.Variation
    members: Members
    number: NumberType
    keep: tuple[str, ...]
    numbers: Mapping[str, Stack]
    endings: npt.NDArray[np.uint8]
    counts: npt.NDArray[np.int64]
    provenance: Mapping[str, object] = field(default_factory=dict, compare=False)
    kept: JobCheckpoint | None = field(default=None, compare=False)

    def __len__(self) -> int:
        return len(self.members)

    def __getitem__(self, name: str) -> Stack:
        return self.numbers[name]

    def __repr__(self) -> str:
        members = counted(len(self), "member")
        return (
            f"<Reductions of {self.scene.name}: {members} in {self.number.name}, "
            f"{counted(len(self.numbers), 'number')} each, {self._reached()}>"
        )

    @property
    def names(self) -> tuple[str, ...]:
        """What the numbers are called."""
        return tuple(self.numbers)

    def table(self) -> Table:
        """One row per member: what is varied, how it ended, and its numbers."""
        member, digits = np.arange(len(self)), self.number.printed_digits
        return Table(
            [
                Column("member", member + 1),
                *varied_columns(self.varied, member),
                text_column("outcome", [OUTCOMES[k].value for k in self.endings.tolist()]),
                Column("steps", self.counts),
                *(Column(name, x, digits=digits) for name, x in self.numbers.items()),
            ]
        )

    def facts(self) -> list[Fact]:
        """What was varied and kept, and how the members were integrated."""
        return [
            *scene_facts(self.scene),
            Fact("vary", list(self.varied.keys), "what is varied"),
            Fact("keep", list(self.keep), "what was kept of each member"),
            Fact("number", self.number.name, "the type of the numbers"),
            Fact("bits", self.number.bits, "of its significand"),
            Fact("end", self.scene.end, "the last time", unit_of(self.scene, "t")),
            Fact("projected", False, "whether put back on the first integrals"),
            Fact("complete", self.complete, "whether every member reached the end"),
            provenance_fact(self.provenance),
        ]


@with_progress
def reduce_many(
    scene: Scene | str | Path,
    vary: vary.Vary | None = None,
    keep: Sequence[str] | str = (),
    *,
    starts: npt.ArrayLike | None = None,
    number: str | NumberType | None = None,
    at: Iterable[AnyNumber] | None = None,
    tol: AnyNumber | None = None,
    max_steps: int | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    parts: str | Path | None = None,
    progress: Progress | bool | None = None,
) -> Reductions:
    """Integrate many variants of a scene and keep some numbers of each.

    States are not projected onto the first integrals.  Memory does not grow with the number of
    output times.  Ctrl-C keeps the finished members.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    vary : mapping or list of mappings
        Numbers of the scene file by key, as in :func:`polhode.integrate_many`; beside ``starts``
        arrays of the body's numbers alone.
    keep : str or sequence of str
        "final" (the last state); "largest X" and "smallest X", X an expression in p q r gamma1
        gamma2 gamma3 t theta: its extreme over the output times, and the first of them at which it
        is reached; "first NAME": time and state of the first zero after 0 of an event of the scene,
        or of nutation or equator, also between output times; "lyapunov": the largest exponent to
        the last time, its uncertainty and growth, as in :func:`polhode.lyapunov`.
    starts : array_like, shape (N, 6) or (N, 3), optional
        A start in each row, as in :func:`polhode.integrate_many`.
    number : str or NumberType, optional
        double or extended; events and exponents in double only.
    at : iterable of numbers, optional
        Output times in the scene's unit; the scene's own unless given.
    tol : number, optional
        The tolerance of a step; the type's eps by default.
    max_steps : int, optional
        A limit on the steps of each member.
    executor : Executor, optional
        An executor of ``concurrent.futures`` instead of threads.
    workers : int, optional
        Threads; as many as there are cores unless given.
    parts : str or Path, optional
        A folder for finished jobs, from which the same call continues after a kill.
    progress : callable or bool, optional
        Called with the fraction of members done and how many; True for a bar.

    Returns
    -------
    Reductions
        A table: one row per member, columns by ``keep``.  Numbers that are made of the states at
        output times are the same to the bit as from :func:`polhode.integrate_many`.

    Raises
    ------
    BadInput
        A member that cannot be integrated, an unknown name in ``keep``.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.reduce_many("lagrange/nutation", {"body.weight": [1, 2]}, "smallest gamma3")
    >>> found["smallest gamma3"].round(3).tolist()
    [0.213, -0.212]
    >>> starts = [[0, 0, k, 0.6, 0, 0.8] for k in (2.0, 3.0, 4.0)]  # any array (N, 6)
    >>> polhode.reduce_many("lagrange/nutation", starts=starts, keep="final")["final r"]
    array([2., 3., 4.])
    """
    assert not isinstance(progress, bool)  # it is a bar's
    scene = library.load(scene, takes=REQUESTS)
    if at is not None:
        scene = scene.at(at)
    which = reductions_of(scene, keep)
    scene, varied = varied_of(scene, starts, vary)
    plan = planned(
        replace(scene, events=()),
        varied,
        number,
        None,
        tol,
        None if max_steps is None else steps(scene.name, max_steps),
        kept=False,
    )
    if workers is not None:
        workers = whole(scene.name, "workers", workers, 1)
    check(scene, plan, which)
    size = len(plan.members) * len(plan.times) * len(scene.columns)
    groups = list(plan.groups(LANES, max(_JOBS, -(-size // MOST_AT_ONCE))))
    jobs = [job_of(scene, plan, which, group) for group in groups]
    key = scene.text, scene.times, which, varied, plan.number, tol, plan.max_steps
    checkpoint = JobCheckpoint.at(parts, "sweep", *key)
    finished = run_jobs(
        solve,
        jobs,
        [len(group) for group in groups],
        workers,
        executor,
        checkpoint,
        lambda reduced: {"endings": reduced.endings, "counts": reduced.counts, **reduced.numbers},
        Reduced.of,
        progress,
    )
    endings = np.full(len(plan.members), code(Outcome.NOT_RUN), dtype=np.uint8)
    counts = np.zeros(len(plan.members), dtype=np.int64)
    names = [name for reduction in which for name in reduction.names(scene.columns)]
    kind = np.dtype(kind_of(plan.number))
    numbers = {name: np.full(len(plan.members), np.nan, kind) for name in names}
    for group, reduced in zip(groups, finished.results, strict=True):
        if reduced is None:
            continue
        endings[group], counts[group] = reduced.endings, reduced.counts
        for name in names:
            numbers[name][group] = reduced.numbers[name]
    plan.members.speak()
    return Reductions(
        scene,
        varied,
        plan.members,
        plan.number,
        tuple(reduction.text for reduction in which),
        numbers,
        endings,
        counts,
        plan.members.provenance(),
        checkpoint,
    )
