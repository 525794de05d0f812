"""Many tops at once: initial conditions or body parameters of one scene varied."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.arguments import whole
from polhode.common.errors import BadInput
from polhode.common.interrupts import delayed
from polhode.common.provenance import provenance
from polhode.common.values import ByValue
from polhode.equations.forms import principal
from polhode.equations.readout import Readout
from polhode.numbers.convert import number_value
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Rows
from polhode.runs import workers as crew
from polhode.runs.request import choose_number, rounded_times, rounded_tolerance
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library, vary
from polhode.scenes.scene import Scene
from polhode.taylor import policy
from polhode.taylor.outcomes import Outcome

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from polhode.taylor.batches import Lane, Solved

MAX_NUMBERS = 10**8  # in all states together: 0.8 GB of doubles

#: Called with the fraction of the members that are done, and how many.
Progress = Callable[[float, int], None]

_JOBS = 256  # so many at most: each costs a fraction of a millisecond


@dataclass(frozen=True, eq=False, repr=False)
class Ensemble(ByValue):
    """Members of a sweep at the same output times, states in the scene's body axes.

    >>> import polhode
    >>> many = polhode.integrate_many("lagrange/nutation", {"start.omega[3]": "2:4:3"}, at=[0, 1])
    >>> many
    <Ensemble of lagrange/nutation: 3 members in double, 2 times to t = 1, all reached the end>
    >>> many.states.shape, len(many), many[2].outcome.value
    ((3, 2, 6), 3, 'reached end')

    ``varied``: keys and exact values, a row a member.  ``states``: shape (members, times, columns),
    columns p q r [gamma1 gamma2 gamma3]; float64, longdouble, or objects (mpf) above extended; not
    a number where a member did not come.  ``outcomes``, ``steps``, ``reached``: one a member.
    ``ensemble[k]`` is member k as a Trajectory.  ``projected``: False, steps are bare Taylor steps,
    not put back onto the first integrals.
    """

    scene: Scene
    varied: vary.Grid
    members: tuple[Scene, ...]
    number: NumberType
    times: tuple[Fraction, ...]
    states: Rows
    outcomes: tuple[Outcome, ...]
    steps: tuple[int, ...]
    reached: tuple[Fraction, ...]
    tolerance: float
    digits: int | None = None
    projected: bool = False
    provenance: Mapping[str, Any] = field(default_factory=dict, compare=False)

    def __len__(self) -> int:
        return len(self.members)

    def __repr__(self) -> str:
        count = sum(outcome.done for outcome in self.outcomes)
        how = "all reached the end" if self.done else f"{count} of them reached the end"
        return (
            f"<Ensemble of {self.scene.name}: {len(self)} members in {self.number.name}, "
            f"{len(self.times)} times to t = {shown(self.times[-1])}, {how}>"
        )

    def __getitem__(self, index: int) -> Trajectory:
        """One member by itself, as far as it came."""
        member = self.members[index]
        count = self._rows(index)
        states = self.states[index][:count]
        return Trajectory(
            scene=member.at(self.scene.times),
            number=self.number,
            times=self.times[:count],
            states=states if self.number.flat else [list(row) for row in states],
            outcome=self.outcomes[index],
            steps=self.steps[index],
            reached=self.reached[index],
            tolerance=self.tolerance,
            digits=self.digits,
            provenance=self.provenance,
        )

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the states' columns."""
        return self.scene.columns

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C left members undone."""
        return Outcome.NOT_RUN in self.outcomes

    @property
    def done(self) -> bool:
        """Whether every member reached the end."""
        return all(outcome.done for outcome in self.outcomes)

    @cached_property
    def drift(self) -> npt.NDArray[np.float64]:
        """Largest drift of h, f, |gamma|² of each member, shape (members, 3); nan where unknown.

        From the member's exact scene, see :class:`polhode.equations.integrals.Drift`.
        """
        import numpy as np

        found = [self[k].drift for k in range(len(self))]
        return np.array([[np.nan if x is None else x for x in row] for row in found], dtype=float)

    def _rows(self, index: int) -> int:
        """How many output times a member has states at."""
        first = [row[0] for row in self.states[index]]
        return sum(1 for x in first if x == x)


def integrate_many(
    scene: Scene | str | Path,
    vary: vary.Vary,
    *,
    number: str | NumberType | None = None,
    digits: int | None = None,
    at: Sequence[Any] | None = None,
    tol: Any = None,
    max_steps: int | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Ensemble:
    """Integrate many variants of a scene (3.29), by one compiled code for all.

    ``vary``: numbers of the scene file by key, such as ``{"start.omega[1]": ["0.1", 0.2],
    "body.weight": "0:1:11"}``: exact values, or FROM:TO:N, every combination being a member; or a
    list of such mappings with one value for each key, the members one by one.  Doubles go through
    the machine's SIMD lanes, sorted by cost, in as many threads as there are cores (``workers``).
    ``executor``: any executor of concurrent.futures instead (a process pool, dask's
    ``Client.get_executor()``, mpi4py's): jobs are plain data both ways, and jobs lost with a worker
    are run again here.  ``number``, ``digits``, ``at``, ``tol``, ``max_steps`` as in
    :func:`polhode.integrate`; ``progress``: called with the fraction of members done and how many.

    Steps are bare: the states are not projected onto the first integrals, as single runs can be.
    States alone are kept: outputs that the scene asks for are left out.  Ctrl-C keeps the members
    that are finished; the others have the outcome NOT_RUN.  Raises BadInput, before anything is
    integrated, for a member that cannot be, a scene with events, or too much of it all.

    >>> import polhode
    >>> many = polhode.integrate_many(
    ...     "lagrange/nutation", {"start.omega[3]": [2, 3], "body.weight": "1:2:3"}, at=[0, 1]
    ... )
    >>> len(many), many.varied.keys, many.done
    (6, ('start.omega[3]', 'body.weight'), True)
    """
    began = time.perf_counter()
    scene = library.load(scene)
    if at is not None:
        scene = scene.at(at)
    if max_steps is not None:
        max_steps = whole(scene.name, "max_steps", max_steps, 1)
    if workers is not None:
        workers = whole(scene.name, "workers", workers, 1)
    plan = _plan(scene, vary, number, digits, tol, max_steps)
    prepared = time.perf_counter()
    found, build = _solved(plan, executor, workers, progress)
    solved = time.perf_counter()
    with delayed() as waiting:  # a moment: no finished member is lost over it
        states = _states(plan, found)
        waiting.forget()
    seconds = {
        "scenes": prepared - began,
        "build": build,
        "run": solved - prepared - build,
        "readout": time.perf_counter() - solved,
    }
    tolerance = plan.tolerance or plan.number.eps
    return Ensemble(
        scene=scene,
        varied=plan.varied,
        members=plan.members,
        number=plan.number,
        times=plan.times,
        states=states,
        outcomes=tuple(r.outcome if r else Outcome.NOT_RUN for r in found),
        steps=tuple(r.steps if r else 0 for r in found),
        reached=tuple(r.reached if r else Fraction(0) for r in found),
        tolerance=float(tolerance),
        digits=digits,
        provenance={**provenance(scene.text), "seconds": seconds},
    )


@dataclass(frozen=True)
class _Plan:
    """A sweep, checked: what there is to integrate."""

    varied: vary.Grid
    members: tuple[Scene, ...]
    number: NumberType
    tolerance: Fraction | None
    max_steps: int
    times: tuple[Fraction, ...]
    names: tuple[str, ...]
    lanes: tuple[Lane, ...]


def _plan(
    scene: Scene,
    given: vary.Vary,
    number: str | NumberType | None,
    digits: int | None,
    tol: Any,
    max_steps: int | None,
) -> _Plan:
    if scene.events:
        expected = "none in a sweep: a step size of its own for each event; run members singly"
        raise BadInput(scene.name, "events", scene.events[0].name, expected)
    varied = vary.grid(given, scene.name)
    numbers = len(varied.rows) * len(scene.times) * len(scene.columns)
    if numbers > MAX_NUMBERS:
        what = f"{len(varied.rows)} members at {len(scene.times)} times"
        expected = f"at most {MAX_NUMBERS} numbers of states; fewer samples, or split the sweep"
        raise BadInput(scene.name, "vary", what, expected)
    members = vary.members(scene, varied)
    chosen = choose_number(scene, number, None)
    if digits is not None:
        fastest = max(members, key=lambda member: member.log10_rate)
        chosen = choose_number(fastest.at(scene.times), number, digits)
    times = tuple(rounded_times(scene, chosen))
    tolerance = rounded_tolerance(scene, chosen, tol)

    names, lanes = _lanes(members, times[-1], chosen)
    limit = max_steps if max_steps is not None else policy.of(chosen).max_steps
    return _Plan(varied, members, chosen, tolerance, limit, times, names, lanes)


def _lanes(
    members: Sequence[Scene], end: Fraction, number: NumberType
) -> tuple[tuple[str, ...], tuple[Lane, ...]]:
    """The names of all coefficients that any member has, and each member in numbers of a type."""
    from polhode.taylor import batches, heyoka_numbers

    bodies: dict[tuple[int, int], dict[str, Exact]] = {}
    for member in members:
        key = id(member.body), member.time_unit  # members share their bodies
        if key not in bodies:
            bodies[key] = principal.coefficients(member.body, member.time_unit)
    names = tuple(sorted(set().union(*bodies.values())))
    known: dict[int, tuple[Exact, Fraction]] = {}  # they share most of their numbers, too

    def typed(x: Exact) -> Fraction:
        if id(x) not in known:
            heyoka_numbers.scalar(x, number)
            known[id(x)] = x, number.rounded(x)
        return known[id(x)][1]

    lanes = []
    for member in members:
        unit, axes = Fraction(2) ** member.time_unit, member.body.axes
        k = bodies[id(member.body), member.time_unit]
        try:
            heyoka_numbers.scalar(end / unit, number)
            start = [typed(unit * w) for w in axes.components(member.omega)]
            if member.gamma is not None:
                start += [typed(g) for g in axes.components(member.gamma)]
            coefficients = [typed(k[name]) if name in k else Fraction(0) for name in names]
        except heyoka_numbers.OutOfRange as fault:
            expected = f"a type of wider range ({fault})"
            raise BadInput(member.name, "number", number.name, expected) from None
        lanes.append(batches.Lane(tuple(coefficients), tuple(start), member.time_unit))
    return names, tuple(lanes)


def _solved(
    plan: _Plan,
    executor: Executor | None,
    workers: int | None,
    progress: Progress | None,
) -> tuple[list[Solved | None], float]:
    """What became of each member, None where it was not run; and the seconds of compiling."""
    from polhode.taylor import batches

    order = sorted(range(len(plan.lanes)), key=lambda k: -plan.lanes[k].rate)
    size = batches.width(plan.number)
    size *= -(-len(order) // (size * _JOBS))
    groups = [order[k : k + size] for k in range(0, len(order), size)]
    columns = len(plan.lanes[0].start)
    jobs = [
        batches.BatchJob(
            plan.names,
            columns,
            plan.number,
            plan.tolerance,
            plan.max_steps,
            plan.times,
            tuple(plan.lanes[k] for k in group),
        )
        for group in groups
    ]
    found: list[Solved | None] = [None] * len(order)
    count = 0

    def ready(k: int, solved: Sequence[Solved | None]) -> None:
        nonlocal count
        for member, result in zip(groups[k], solved, strict=True):
            found[member] = result
        count += len(solved)
        if progress is not None:
            progress(count / len(order), count)

    left = list(range(len(jobs)))
    if executor is not None:
        undisturbed, left = crew.elsewhere(batches.solve, jobs, ready, executor)
        if not undisturbed:
            return found, 0.0
    if not left:
        return found, 0.0
    began = time.perf_counter()
    batches.compiled(jobs[0])
    build = time.perf_counter() - began
    crew.here(
        batches.solve, [jobs[k] for k in left], lambda i, solved: ready(left[i], solved), workers
    )
    return found, build


def _states(plan: _Plan, found: Sequence[Solved | None]) -> Rows:
    """States in scene axes and units, not a number where a member did not come."""
    import numpy as np

    shape = (len(found), len(plan.times), len(plan.members[0].columns))
    if plan.number.name == "double":
        states = np.full(shape, np.nan)
    elif plan.number.name == "extended":
        states = np.full(shape, np.nan, dtype=np.longdouble)
    else:
        from polhode.numbers.private import mpmath, ordinary

        states = np.full(shape, ordinary(mpmath.nan), dtype=object)
    alike: dict[tuple[int, int], list[int]] = {}  # members that one readout reads
    reached = {k: r.rows for k, r in enumerate(found) if r is not None and len(r.rows)}
    for k in reached:
        member = plan.members[k]
        alike.setdefault((id(member.body), member.time_unit), []).append(k)
    for those in alike.values():
        rows = [row for k in those for row in reached[k]]
        if states.dtype == object:
            rows = [[number_value(x, plan.number) for x in row] for row in rows]
        read = iter(Readout(plan.members[those[0]], plan.number).states(rows))
        for k in those:
            for i in range(len(reached[k])):
                states[k, i] = next(read)
    return states
