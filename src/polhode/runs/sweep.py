"""Many tops at once: initial conditions or body parameters of one scene varied."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common import upstairs
from polhode.common.arguments import steps, whole
from polhode.common.progress import bar
from polhode.common.provenance import provenance
from polhode.common.values import ByValue
from polhode.numbers.decimals import shown
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Rows
from polhode.runs import refined_sweep
from polhode.runs import workers as crew
from polhode.runs.parts import Parts
from polhode.runs.refinement import check_method
from polhode.runs.sweep_plan import Plan, planned
from polhode.runs.sweep_results import Results
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library, vary
from polhode.scenes.scene import Scene
from polhode.taylor.outcomes import Outcome

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from polhode.taylor.batches import Solved

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
    ``ensemble[k]`` is member k as a Trajectory.  ``projected``: False, steps are bare
    Taylor steps, not put back onto the first integrals.  ``parts``: the folder that finished
    members were kept in.  ``errors``: one entry a member, of a refined one what a refined
    trajectory's are, else None.
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
    errors: tuple[tuple[float | None, ...] | None, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict, compare=False)
    parts: Parts | None = field(default=None, compare=False)

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
            method="taylor" if self._errors(index) is None else "refined",
            errors=self._errors(index),
        )

    def _repr_html_(self) -> str:
        return str(upstairs.call("output.notebook:of_ensemble", self))

    def to_xarray(self) -> Any:
        """An xarray Dataset along member and t (extra ``polhode[frames]``)."""
        return upstairs.call("output.frames:of_ensemble_xarray", self)

    def to_pandas(self) -> Any:
        """A pandas DataFrame: a row a member and time (extra ``polhode[frames]``)."""
        return upstairs.call("output.frames:of_ensemble_pandas", self)

    def _errors(self, index: int) -> tuple[float | None, ...] | None:
        return self.errors[index] if self.errors else None

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
    parts: Path | None = None,
    method: str = "auto",
    progress: Progress | bool | None = None,
) -> Ensemble:
    """Integrate many variants of a scene (3.29), by one compiled code for all.

    ``vary``: numbers of the scene file by key, such as ``{"start.omega[1]": ["0.1", 0.2],
    "body.weight": "0:1:11"}``: exact values, or FROM:TO:N, every combination being a member; or a
    list of such mappings with one value for each key, the members one by one.  Doubles go through
    the machine's SIMD lanes, sorted by cost, in as many threads as there are cores (``workers``).
    ``executor``: any executor of concurrent.futures instead (a process pool, dask's
    ``Client.get_executor()``, mpi4py's): jobs are plain data both ways, and jobs lost with a worker
    are run again here.  ``number``, ``digits``, ``at``, ``tol``, ``max_steps`` as in
    :func:`polhode.integrate`, and ``method``: "auto" refines, in quad and above, each member that
    can be and is long enough; ``progress``: called with the fraction of members
    done and how many, or True for a bar.

    Steps are bare: the states are not projected onto the first integrals, as single runs can be.
    ``parts``: a folder that finished members are written to about once a second, so that the same
    call after a kill goes on from there, with the same results to the bit; it is made where it
    takes longer, and stays until ``ensemble.parts.remove()``.  Raises BadInput where it holds
    anything but parts of this very sweep.

    ``digits`` chooses the number type by how far the fastest member turns, and promises no more:
    unlike a single run, a sweep is not checked, and members whose motion multiplies errors may
    have fewer digits right.  States alone are kept: outputs that the scene asks for are left out.
    Ctrl-C keeps the members that are finished; the others have the outcome NOT_RUN.  Raises
    BadInput, before anything is integrated, for a member that cannot be, a scene with events, or
    too much of it all.

    >>> import polhode
    >>> many = polhode.integrate_many(
    ...     "lagrange/nutation", {"start.omega[3]": [2, 3], "body.weight": "1:2:3"}, at=[0, 1]
    ... )
    >>> len(many), many.varied.keys, many.done
    (6, ('start.omega[3]', 'body.weight'), True)
    """
    if isinstance(progress, bool):
        asked = {key: value for key, value in locals().items() if key != "progress"}
        if not progress:
            return integrate_many(**asked)
        with bar(library.load(scene).name) as tell:
            return integrate_many(**asked, progress=tell)
    began = time.perf_counter()
    scene = library.load(scene)
    if at is not None:
        scene = scene.at(at)
    if max_steps is not None:
        max_steps = steps(scene.name, max_steps)
    if workers is not None:
        workers = whole(scene.name, "workers", workers, 1)
    check_method(scene, method)
    plan = planned(scene, vary, number, digits, tol, max_steps)
    prepared = time.perf_counter()
    kept = _opened(plan, scene, parts, method)
    results = Results(plan, kept)
    build = _solve(plan, results, executor, workers, progress, method)
    results.end()
    seconds = {
        "scenes": prepared - began,
        "build": build,
        "run": time.perf_counter() - prepared - build,
    }
    tolerance = plan.tolerance or plan.number.eps
    return Ensemble(
        scene=scene,
        varied=plan.varied,
        members=plan.members,
        number=plan.number,
        times=plan.times,
        states=results.states,
        outcomes=tuple(results.outcomes),
        steps=tuple(results.steps),
        reached=tuple(results.reached),
        tolerance=float(tolerance),
        digits=digits,
        errors=tuple(results.errors),
        provenance={**provenance(scene.text), "seconds": seconds},
        parts=kept,
    )


def _opened(plan: Plan, scene: Scene, folder: Path | None, method: str) -> Parts | None:
    """The folder of a sweep's parts, if there is to be one."""
    if folder is None:
        return None
    asked = (plan.varied, plan.number, plan.tolerance, plan.max_steps, plan.times, plan.names)
    axes = {id(m.body): repr(m.body.axes) for m in plan.members}
    what = "\n".join([scene.name, method, repr(asked), *axes.values(), *map(repr, plan.lanes)])
    return Parts(folder, what, plan.number)


def _solve(
    plan: Plan,
    results: Results,
    executor: Executor | None,
    workers: int | None,
    progress: Progress | None,
    method: str,
) -> float:
    """Integrate the members that are not done; the seconds of compiling."""
    from polhode.taylor import batches

    order = sorted(range(len(plan.lanes)), key=lambda k: -plan.lanes[k].rate)
    size = batches.width(plan.number)
    size *= -(-len(order) // (size * _JOBS))
    wanted = results.left  # whole batches of lanes: the others' results do not depend on them
    groups = [[k for k in order[i : i + size] if k in wanted] for i in range(0, len(order), size)]
    groups = [group for group in groups if group]
    columns = len(plan.lanes[0].start)
    steps = [
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
    jobs: Sequence[Any] = steps
    solve: Any = batches.solve
    prepare: Any = batches.compiled
    members = tuple(
        replace(m, times=plan.asked, outputs=(), form="principal") for m in plan.members
    )
    if plan.tolerance is None and refined_sweep.wanted(plan.number, method, members):
        solve, prepare = refined_sweep.solve, refined_sweep.prepare
        jobs = [
            refined_sweep.Job(tuple(members[k] for k in group), job, method)
            for group, job in zip(groups, steps, strict=True)
        ]
    count = len(order) - len(wanted)

    def ready(k: int, solved: Sequence[Solved | None]) -> None:
        nonlocal count
        results.take(groups[k], solved)
        count += len(solved)
        if progress is not None:
            progress(count / len(order), count)

    left = list(range(len(jobs)))
    if executor is not None:
        undisturbed, left = crew.elsewhere(solve, jobs, ready, executor)
        if not undisturbed:
            return 0.0
    if not left:
        return 0.0
    began = time.perf_counter()
    prepare(jobs[0])
    build = time.perf_counter() - began
    crew.here(solve, [jobs[k] for k in left], lambda i, solved: ready(left[i], solved), workers)
    return build
