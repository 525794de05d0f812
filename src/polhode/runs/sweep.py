"""Many tops at once: initial conditions or body parameters of one scene varied."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
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
from polhode.numbers.scalars import AnyNumber, Rows
from polhode.runs import refined_sweep
from polhode.runs import workers as crew
from polhode.runs.parts import Parts
from polhode.runs.refinement import check_method
from polhode.runs.sweep_plan import Plan, planned
from polhode.runs.sweep_results import Results
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library, vary
from polhode.scenes.scene import Scene
from polhode.taylor import policy
from polhode.taylor.outcomes import OUTCOMES, Outcome

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import pandas as pd
    import xarray as xr

    from polhode.taylor.batch_jobs import Solved

#: Called with the fraction of the members that are done, and how many.
Progress = Callable[[float, int], None]

_JOBS = 16, 256  # so many at least and at most: each costs a fraction of a millisecond
_JOB = 0.05  # seconds that one should take
_STEPS_PER_RADIAN = 2.0  # about, at the fastest rate, in double
_SHARE = 0.25  # of a scalar step that a lane's costs


@dataclass(frozen=True, eq=False, repr=False)
class Ensemble(ByValue):
    """Members of a sweep at the same output times, states in the scene's body axes.

    >>> import polhode
    >>> many = polhode.integrate_many("lagrange/nutation", {"start.omega[3]": "2:4:3"}, at=[0, 1])
    >>> many
    <Ensemble of lagrange/nutation: 3 members in double, 2 times to t = 1, all reached the end>
    >>> many.states.shape, many.t.tolist(), many[2].outcome.value
    ((3, 2, 6), [0.0, 1.0], 'reached end')

    ``varied``: keys and exact values, a row a member.  ``states``: shape (members, times, columns),
    columns p q r [gamma1 gamma2 gamma3]; float64, longdouble, or objects (mpf) above extended; not
    a number where a member did not come.  ``outcomes``, ``steps``, ``reached``, ``errors``: one a
    member, made of the arrays ``endings``, ``counts``, ``arrived`` and of ``told`` when asked for.
    ``ensemble[k]`` is member k as a Trajectory.  ``projected``: False, steps are bare
    Taylor steps, not put back onto the first integrals.  ``parts``: the folder that finished
    members were kept in.
    """

    scene: Scene
    varied: vary.Grid
    members: vary.Members
    number: NumberType
    times: tuple[Fraction, ...]
    states: Rows
    endings: npt.NDArray[np.uint8]  # indices into polhode.taylor.outcomes.OUTCOMES
    counts: npt.NDArray[np.int64]  # of steps
    arrived: Rows  # times reached, Fractions
    tolerance: float
    digits: int | None = None
    projected: bool = False
    told: Mapping[int, tuple[float | None, ...]] = field(default_factory=dict)
    provenance: Mapping[str, object] = field(default_factory=dict, compare=False)
    parts: Parts | None = field(default=None, compare=False)

    def __len__(self) -> int:
        return len(self.members)

    def __repr__(self) -> str:
        count = sum(n for outcome, n in self.tally().items() if outcome.done)
        how = "all reached the end" if self.done else f"{count} of them reached the end"
        return (
            f"<Ensemble of {self.scene.name}: {len(self)} members in {self.number.name}, "
            f"{len(self.times)} times to t = {shown(self.times[-1])}, {how}>"
        )

    def __getitem__(self, index: int) -> Trajectory:
        """One member by itself, as far as it came."""
        member = self.members[index]
        states = self.rows(index)
        count = len(states)
        return Trajectory(
            scene=member.at(self.scene.times),
            number=self.number,
            times=self.times[:count],
            states=states if self.number.flat else [list(row) for row in states],
            outcome=self.outcome(index),
            steps=int(self.counts[index]),
            reached=self.arrived[index],
            tolerance=self.tolerance,
            digits=self.digits,
            provenance=self.provenance,
            method="taylor" if self._errors(index) is None else "refined",
            errors=self._errors(index),
        )

    def _repr_html_(self) -> str:
        return str(upstairs.call("output.notebook:of_ensemble", self))

    @property
    def t(self) -> npt.NDArray[np.float64]:
        """The times as doubles, the nearest ones."""
        import numpy as np

        return np.array([float(t) for t in self.times])

    def to_xarray(self) -> xr.Dataset:
        """An xarray Dataset along member and t (extra ``polhode[frames]``)."""
        dataset: xr.Dataset = upstairs.call("output.frames:of_ensemble_xarray", self)
        return dataset

    def to_pandas(self) -> pd.DataFrame:
        """A pandas DataFrame: a row a member and time (extra ``polhode[frames]``)."""
        frame: pd.DataFrame = upstairs.call("output.frames:of_ensemble_pandas", self)
        return frame

    def _errors(self, index: int) -> tuple[float | None, ...] | None:
        return self.told.get(index % len(self))

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the states' columns."""
        return self.scene.columns

    @cached_property
    def outcomes(self) -> tuple[Outcome, ...]:
        """How each member ended."""
        return tuple(OUTCOMES[code] for code in self.endings.tolist())

    def outcome(self, index: int) -> Outcome:
        """How one member ended."""
        return OUTCOMES[int(self.endings[index])]

    def tally(self) -> dict[Outcome, int]:
        """How many members ended how, in the order in which the first of each comes."""
        import numpy as np

        codes, first, counts = np.unique(self.endings, return_index=True, return_counts=True)
        return {OUTCOMES[codes[k]]: int(counts[k]) for k in np.argsort(first)}

    @cached_property
    def steps(self) -> tuple[int, ...]:
        """How many steps each member took."""
        return tuple(self.counts.tolist())

    @cached_property
    def reached(self) -> tuple[Fraction, ...]:
        """The time that each member reached."""
        return tuple(self.arrived.tolist())

    @cached_property
    def errors(self) -> tuple[tuple[float | None, ...] | None, ...]:
        """One entry a member: of a refined one what a refined trajectory's are, else None."""
        return tuple(self.told.get(k) for k in range(len(self)))

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C left members undone."""
        return Outcome.NOT_RUN in self.tally()

    @property
    def done(self) -> bool:
        """Whether every member reached the end."""
        return all(outcome.done for outcome in self.tally())

    @cached_property
    def drift(self) -> npt.NDArray[np.float64]:
        """Largest drift of h, f, |gamma|² and the fourth integral of each, shape (members, 4).

        From the member's exact scene, see :class:`polhode.equations.integrals.Drift`; nan where
        unknown.
        """
        from polhode.runs.sweep_drift import drifts

        return drifts(self.members, self.states, lambda k: self[k].drift)

    def rows(self, index: int) -> Rows:
        """The states of one member as far as it came."""
        states = self.states[index]
        return states[: int((states[:, 0] == states[:, 0]).sum())]


def integrate_many(
    scene: Scene | str | Path,
    vary: vary.Vary,
    *,
    number: str | NumberType | None = None,
    digits: int | None = None,
    at: Iterable[AnyNumber] | None = None,
    tol: AnyNumber | None = None,
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
        endings=results.outcomes,
        counts=results.steps,
        arrived=results.reached,
        tolerance=float(tolerance),
        digits=digits,
        told=results.errors,
        provenance={**provenance(scene.text), "seconds": seconds},
        parts=kept,
    )


def _jobs(plan: Plan) -> int:
    """In about how many jobs a sweep is cut."""
    least, most = _JOBS
    if plan.number.name != "double":
        return most
    radians = float(plan.rates.sum()) * abs(float(plan.times[-1]))
    seconds = _SHARE * policy.seconds(plan.number, _STEPS_PER_RADIAN * radians)
    return int(min(most, max(least, seconds / _JOB)))


def _opened(plan: Plan, scene: Scene, folder: Path | None, method: str) -> Parts | None:
    """The folder of a sweep's parts, if there is to be one."""
    if folder is None:
        return None
    asked = (plan.varied, plan.number, plan.tolerance, plan.max_steps, plan.times, plan.names)
    body = repr((scene.body.inertia, scene.body.centre, scene.body.weight))
    what = "\n".join([scene.name, method, repr(asked), body])
    return Parts(folder, what.encode() + plan.lanes.bytes(), plan.number)


def _solve(
    plan: Plan,
    results: Results,
    executor: Executor | None,
    workers: int | None,
    progress: Progress | None,
    method: str,
) -> float:
    """Integrate the members that are not done; the seconds of compiling."""
    from polhode.taylor import batch_jobs, batches

    size = batches.width(plan.number)
    wanted = results.left  # whole batches of lanes: the others' results do not depend on them
    groups = [group[wanted[group]] for group in plan.groups(size, _jobs(plan))]
    groups = [group for group in groups if len(group)]
    steps = [
        batch_jobs.BatchJob(
            plan.names,
            plan.number,
            plan.tolerance,
            plan.max_steps,
            plan.times,
            int(plan.time_units[group[0]]),
            plan.lanes.some(group),
        )
        for group in groups
    ]
    jobs: Sequence[Any] = steps
    solve: Any = batches.solve
    prepare: Any = batches.compiled
    if plan.tolerance is None and not plan.number.flat:
        members = tuple(
            replace(m, times=plan.asked, outputs=(), form="principal") for m in plan.members
        )
        if refined_sweep.wanted(plan.number, method, members):
            solve, prepare = refined_sweep.solve, refined_sweep.prepare
            jobs = [
                refined_sweep.Job(tuple(members[k] for k in group), job, method)
                for group, job in zip(groups, steps, strict=True)
            ]
    total = len(plan.members)
    count = total - int(wanted.sum())

    def ready(k: int, solved: Solved) -> None:
        nonlocal count
        results.take(groups[k], solved)
        count += len(groups[k])
        if progress is not None:
            progress(count / total, count)

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
