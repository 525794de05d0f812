"""Chaos maps: which motions of a level, of a family of scenes, or of own starts, are chaotic.

One tangent u a motion, followed to the time T:

    growth = ln|u(T)| - ln|u(T/2)|,      FLI = max ln|u|,
    MEGNO = (1/T) int Y dt,              Y(t) = 2 ln|u(t)| - (2/t) int_0^t ln|u|

(Y being (2/t) int_0^t s d ln|u(s)| by parts: the mean exponential growth of nearby orbits of
P. Cincotta and C. Simo, A&AS 147 (2000) 205).
A motion is *chaotic* where growth > 6, or *unstable* where it is known: all motions of its body
are, or it is a fixed point or has a closed form (the definition and the bound are those of
:mod:`polhode.dynamics.lyapunov`); *regular* (up to T) where growth < 2.5 and
MEGNO < 2.2 and T is 1000 units or more; else *undecided*. Orbits that stick to islands for
longer than T are called regular.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.arguments import cells, each, whole, with_progress
from polhode.common.checkpoint import JobCheckpoint
from polhode.common.errors import BadInput, counted
from polhode.common.interrupts import Progress
from polhode.common.processes import run_jobs
from polhode.common.values import ByValue, refuse_too_much
from polhode.dynamics.level_body import LevelBody, tangents_of
from polhode.dynamics.lyapunov import SHORTEST, UNSTABLE, UNSTABLE_GROWTH, is_integrable, is_known
from polhode.dynamics.starts import cell_centres, cut_of, starts_of
from polhode.equations.section_functions import HEIGHT, MOMENTUM
from polhode.equations.terms import NAMES
from polhode.judging.tables.table_file import read_starts
from polhode.motion.frame import Frame
from polhode.numbers.conversion import TIME, exact_number, reader, to_double
from polhode.numbers.exact import ZERO, Exact
from polhode.numbers.number_types import AnyNumber, Doubles, Integers
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.runs.integrate_many import varied_of
from polhode.runs.members import Members
from polhode.scenes import library, vary
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts, text_column, unit_of
from polhode.scenes.vocabulary import REQUESTS
from polhode.taylor import variations

# --- map motions ----------------------------------------------------------------------------------
#
# The motions of a chaos map: of a section's grid, or of scenes in which numbers vary.


GRID = 50, 50  # cells
MOST_MOTIONS = 1_000_000


class Motions(NamedTuple):
    """Motions, a row each, and where on a map they are.

    ``keys``, ``shape``, ``at``, ``cell``, ``h``, ``f``: as a ChaosMap has them.  ``starts``,
    ``tangents`` (n, 6): in principal axes and the run's unit of time.  ``coefficients``: of the
    equations in their principal form, a column for each of ``names``.  ``is_known``: whether the
    k-th is a motion that is not called chaotic, however nearby ones separate.
    """

    keys: tuple[str, ...]
    shape: tuple[int, ...]
    at: Doubles
    cell: Integers
    starts: Doubles
    tangents: Doubles
    names: tuple[str, ...]
    coefficients: Doubles
    is_known: Callable[[int], bool]
    h: Exact | None = None
    f: Exact | None = None


def on_section(
    scene: Scene,
    grid: Any,
    by: str | None,
    extremum: str | None,
    h: AnyNumber | None,
    f: AnyNumber | None,
    foretold: Callable[[int], object],
) -> Motions:
    """The motions that start in the cells of a section's grid; raises BadInput.

    ``foretold``: see :func:`starts_of`.
    """
    cut = cut_of(scene, by, extremum, h, f)
    if cut.by not in (MOMENTUM, HEIGHT):
        raise BadInput(scene.name, "by", cut.by, "momentum or height, for a map")
    first, second = cells(scene.name, GRID if grid is None else grid, MOST_MOTIONS)
    points, on = starts_of(cut, None, (first, second), foretold), cut.on
    of = points.of // 2 if cut.by == HEIGHT else points.of
    integrable = is_integrable(scene.body)
    return Motions(
        keys=("azimuth", "u") if cut.by == HEIGHT else ("l", "L_over_G"),
        shape=(first, second),
        at=np.stack(cell_centres(first, second), axis=1)[of],
        cell=of,
        starts=points.states,
        tangents=tangents_of(points.states, on.moments, on.torque),
        names=tuple(on.numbers),
        coefficients=np.tile([*on.numbers.values()], (len(of), 1)),
        is_known=lambda _: integrable,
        h=on.h,
        f=on.f,
    )


def of_varied(scene: Scene, grid: vary.Variation, foretold: Callable[[int], object]) -> Motions:
    """The motions of a scene in which numbers vary; raises BadInput.

    All combinations of two numbers make a grid.  ``foretold``: told how many they are before they
    are made, to refuse them.
    """
    if len(grid.rows) > MOST_MOTIONS:
        expected = f"at most {MOST_MOTIONS}; a coarser grid"
        raise BadInput(scene.name, "vary", f"{len(grid.rows)} motions", expected)
    if not len(grid.rows):
        raise BadInput(scene.name, "starts", "nothing", "at least one start")
    if scene.gamma is None:
        raise BadInput(scene.name, "start.gamma", None, "a unit vector, for a map")
    foretold(len(grid.rows))
    members = Members(scene, grid)
    unit = Frame.of(scene).exponent  # of all members
    rows = np.array([[to_double(x) for x in row] for row in grid.rows])
    shape: tuple[int, ...] = (len(rows),)
    cell = np.arange(len(rows))
    if len(grid.keys) == 2 and grid.rows.product:
        axes = [np.unique(column) for column in rows.T]
        first, second = (np.searchsorted(*pair) for pair in zip(axes, rows.T, strict=True))
        shape = (len(axes[0]), len(axes[1]))
        cell = first * len(axes[1]) + second
    numbers, rows_of = [], []
    for member in members:
        on = LevelBody(member, ZERO, ZERO, unit - Frame.of(member).exponent)
        numbers.append(on.numbers)
        rows_of.append((on.start, on.moments, on.torque))
    starts, moments, torques = (np.array(column) for column in zip(*rows_of, strict=True))
    names = tuple(name for name in NAMES if any(name in k for k in numbers))

    def is_member_known(k: int) -> bool:
        member = members[k]
        return is_integrable(member.body) or is_known(member)

    return Motions(
        keys=tuple(grid.keys),
        shape=shape,
        at=rows,
        cell=cell,
        starts=starts,
        tangents=tangents_of(starts, moments, torques),
        names=names,
        coefficients=np.array([[k.get(name, 0.0) for name in names] for k in numbers]),
        is_known=is_member_known,
    )


# --- chaos map ------------------------------------------------------------------------------------


END = 1000  # units of the inner time
TOLERANCE = 1e-8  # no verdict of 2000 was another at eps
REGULAR_GROWTH, REGULAR_MEGNO = 2.5, 2.2
_BYTES = 24  # of a look: ln|u|, and what it is judged by
LOOK, LEAST_LOOKS = 8.0, 16  # units of time between two looks, at most; looks, a multiple of this
LANES = 256
VERDICTS = ("regular", "undecided", "chaotic", UNSTABLE)
_CHAOTIC, _UNSTABLE = 2, 3
MOST = 10_000_000  # units of time
_ROUNDING = 1e-9  # of an end


@dataclass(frozen=True, repr=False, eq=False)
class ChaosMap(Result, ByValue):
    """Verdicts of many motions: arrays with one row per motion.

    ``keys``: the names of the coordinates, two of a grid; ``at`` (n, keys): their values.
    ``shape``: cells of the grid, ``cell`` (n,) the cell of each motion, in C order; without a grid
    a cell is a motion.  ``verdict`` (n,): indices into VERDICTS.  ``fli`` (max ln|u|), ``megno``,
    ``growth`` (of ln|u| over the second half of the time), ``exponent`` (per unit of the scene's
    time), each (n,), up to the time ``until``, which is less than ``end`` for a motion that was
    found chaotic earlier.

    >>> import polhode
    >>> found = polhode.chaos_map("lagrange/nutation", grid=(3, 3), end=1000)
    >>> int((found.verdict == 2).sum())  # no motion of a Lagrange top is chaotic
    0
    """

    scene: Scene
    keys: tuple[str, ...]
    shape: tuple[int, ...]
    at: Doubles
    cell: Integers
    verdict: Integers
    fli: Doubles
    megno: Doubles
    growth: Doubles
    exponent: Doubles
    until: Doubles
    end: float
    h: Exact | None = None
    f: Exact | None = None
    interrupted: bool = False
    kept: JobCheckpoint | None = None
    provenance: Mapping[str, object] = field(default_factory=dict)

    def __repr__(self) -> str:
        counts = ", ".join(f"{n} {name}" for name, n in self.counts.items())
        return f"<ChaosMap of {self.scene.name}: {counted(len(self.verdict), 'motion')}, {counts}>"

    @property
    def enough(self) -> float:
        """The least end at which a motion can be called regular; before, it stays undecided."""
        return SHORTEST * float(Frame.of(self.scene).unit)

    @property
    def too_short(self) -> bool:
        """Whether the end alone leaves what is not chaotic undecided."""
        return self.end < self.enough * (1 - _ROUNDING)

    @property
    def counts(self) -> dict[str, int]:
        """How many motions have each verdict."""
        return {name: int((self.verdict == k).sum()) for k, name in enumerate(VERDICTS)}

    def table(self) -> Table:
        """One row per motion: where it starts, its verdict, and what that rests on."""
        time = unit_of(self.scene, "t")
        return Table(
            [
                Column("motion", np.arange(1, len(self.verdict) + 1)),
                *(Column(key, self.at[:, k]) for k, key in enumerate(self.keys)),
                Column("cell", self.cell, "its cell of the grid, row by row from 0"),
                text_column("verdict", [VERDICTS[k] for k in self.verdict.tolist()]),
                Column("fli", self.fli, "largest logarithm of the tangent", digits=4),
                Column("megno", self.megno, "mean exponential growth of nearby orbits", digits=4),
                Column("growth", self.growth, "of the logarithm, in the second half", digits=4),
                Column("exponent", self.exponent, "of Lyapunov", f"1/{time}", digits=4),
                Column("until", self.until, "how far it was followed", time),
            ]
        )

    def __str__(self) -> str:
        """How many motions have each verdict."""
        each = self.counts.items()
        share = 100 / max(1, len(self.verdict))
        return "\n".join(f"{name:<10}{n:>8}  {share * n:.1f} %" for name, n in each)

    @property
    def meaning(self) -> str:
        """What the verdicts rest on: how far motions were followed, and whether that is enough."""
        if not self.too_short:
            return f"regular means up to t = {self.end:g}"
        least = f"{self.enough:g}"
        return (
            f"{self.counts['undecided']} undecided: t = {self.end:g} is too short, none is called "
            f"regular before t = {least}; an end of {least} or more can decide"
        )

    def facts(self) -> list[Fact]:
        """The level or the family, the grid, and how many motions have each verdict."""
        return [
            *scene_facts(self.scene),
            Fact("h", self.h, "energy"),
            Fact("f", self.f, "vertical momentum"),
            Fact("keys", list(self.keys), "the coordinates of a motion"),
            Fact("grid", list(self.shape), "rows and columns of cells; or motions without a grid"),
            Fact("end", self.end, "how far motions are followed", unit_of(self.scene, "t")),
            Fact("least_end", self.enough, "the least end at which one is called regular"),
            Fact("counts", self.counts, "motions of each verdict"),
            Fact("meaning", self.meaning, "what the verdicts rest on"),
            Fact("complete", not self.interrupted, "whether all motions were followed"),
            provenance_fact(self.provenance),
        ]


@with_progress
def chaos_map(
    scene: Scene | str | Path,
    grid: tuple[int, int] | None = None,
    vary: vary.Vary | None = None,
    end: AnyNumber | None = None,
    by: str | None = None,
    extremum: str | None = None,
    h: AnyNumber | None = None,
    f: AnyNumber | None = None,
    tol: float | None = TOLERANCE,
    workers: int | None = None,
    executor: Executor | None = None,
    parts: str | Path | None = None,
    progress: Progress | None = None,
    starts: npt.ArrayLike | str | Path | None = None,
) -> ChaosMap:
    """Classify the motions of a section's grid, of scenes in which numbers vary, or of own starts.

    Each is regular, unstable, chaotic or undecided by the growth of a tangent vector, see
    :func:`polhode.lyapunov`; regular means up to ``end``.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    grid : tuple of int, optional
        The cells of the section's two coordinates (50x50 unless given).
    vary : mapping, optional
        Numbers of the scene file and values of each instead of the section's grid, as in
        :func:`polhode.integrate_many`; all combinations of two of them make a grid.
    end : number, optional
        The last time of each motion, in the scene's unit (about 1000 radians by default).  The
        default is 1000 units of the inner time, a power of two of the scene's unit, about a radian
        of the start's fastest rate.
    by, extremum : str, optional
        The section and which of its extrema, as in :func:`polhode.section`.
    h, f : number, optional
        The level's energy h or vertical momentum f, if not the scene's.
    tol : float or None
        The tolerance of a step (1e-8); in Python None for the eps of double.
    workers : int, optional
        Threads, as many as there are cores unless given.
    executor : Executor, optional
        An executor of ``concurrent.futures`` instead of threads.
    parts : str or Path, optional
        A folder for finished jobs, from which the same call continues after a kill.
    progress : callable, optional
        Called with the fraction done and the motions done.
    starts : array_like, shape (N, 6), or path, optional
        A start for each motion instead of the grid, p q r gamma1 gamma2 gamma3 in the scene's axes
        and units, or a file of such rows, as for ``polhode sweep``; in Python ``vary`` may have
        arrays of the body's numbers beside them.

    Returns
    -------
    ChaosMap
        A verdict and an exponent for each motion.

    Raises
    ------
    BadInput
        A level that does not exist, an end of 0, a number that cannot vary, a gamma that is not of
        length 1.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.chaos_map("general/asymmetric-chaotic", (4, 4), end=1000, h=3, f="1/2")
    >>> found.counts["chaotic"] > 6
    True
    >>> own = [[1.0, 0.5, 2.0, 0.6, 0.0, 0.8], [0.1, 0.0, 3.0, 0.0, 0.6, 0.8]]
    >>> found = polhode.chaos_map("general/asymmetric-chaotic", starts=own, end=2000)
    >>> found.exponent.shape
    (2,)
    """
    scene = library.load(scene, takes=REQUESTS)
    if workers is not None:
        workers = whole(scene.name, "workers", workers, 1)
    frame = Frame.of(scene)
    unit, default = float(frame.unit), frame.time_outside(Fraction(END))
    last_time = default if end is None else end
    (last,) = each(scene.name, "end", (last_time,), reader(scene.units, TIME), "a time")
    length = to_double(last) / unit
    if not 0 < length < MOST:
        raise BadInput(scene.name, "end", to_double(last), f"a time above 0, below {MOST * unit:g}")
    if tol is not None:
        (tolerance,) = each(scene.name, "tol", (tol,), exact_number, "a number")
        tol = to_double(tolerance)
        if not 2.0**-52 <= tol <= 1e-3:
            raise BadInput(scene.name, "tol", tol, "a tolerance from 2.2e-16 to 1e-3")
    looks = LEAST_LOOKS * max(1, int(np.ceil(length / LOOK / LEAST_LOOKS)))

    def forecast(many: int, more_than: str = "") -> None:
        work = f"{more_than}{many} motions with {looks} samples each"
        words = "samples in all; a coarser grid, or an earlier end"
        refuse_too_much(scene.name, "map", work, many * looks, _BYTES, words)

    if vary is None and starts is None:
        foretold = partial(forecast, more_than="more than ")
        motions = on_section(scene, grid, by, extremum, h, f, foretold)
    else:
        if any(x is not None for x in (grid, by, extremum, h, f)):
            key = "vary" if starts is None else "starts"
            raise BadInput(scene.name, key, None, "no grid, section or level together with it")
        if isinstance(starts, (str, Path)):
            starts = read_starts(Path(starts), scene)
        motions = of_varied(*varied_of(scene, starts, vary), forecast)
    initial, coefficients = motions.starts, motions.coefficients
    forecast(len(initial))
    early = (looks // 8, looks // 4, looks // 2)
    jobs = [
        variations.TangentJob(
            motions.names,
            coefficients[k : k + LANES],
            initial[k : k + LANES],
            motions.tangents[k : k + LANES],
            length,
            looks,
            tol,
            early,
            UNSTABLE_GROWTH,
        )
        for k in range(0, len(initial), LANES)
    ]
    checkpoint = JobCheckpoint.at(
        parts, "map", scene.text, length, looks, tol, initial, coefficients
    )
    finished = run_jobs(
        variations.solve,
        jobs,
        [len(job.starts) for job in jobs],
        workers,
        executor,
        checkpoint,
        variations.TangentSizes._asdict,
        variations.TangentSizes.of,
        progress,
    )
    sizes, left = (np.concatenate(arrays) for arrays in zip(*finished.done, strict=True))
    judged = _judged(sizes, left, length)
    verdict, rows = judged["verdict"], np.flatnonzero(finished.rows)
    integrable = [
        k for k in np.flatnonzero(verdict == _CHAOTIC).tolist() if motions.is_known(rows[k])
    ]
    verdict[integrable] = _UNSTABLE
    judged["exponent"] = judged["exponent"] / unit
    judged["until"] = judged["until"] * unit
    return ChaosMap(
        scene,
        motions.keys,
        motions.shape,
        motions.at[finished.rows],
        motions.cell[finished.rows],
        **judged,
        end=to_double(last),
        h=motions.h,
        f=motions.f,
        interrupted=finished.interrupted,
        kept=checkpoint,
        provenance=scene.provenance(),
    )


def _judged(sizes: Any, last: Any, length: float) -> dict[str, Any]:
    """Growth, FLI, MEGNO, exponent and verdict of ln|u| at evenly spaced looks."""
    n, looks = sizes.shape[0], sizes.shape[1] - 1
    step = length / looks
    rows = np.arange(n)
    growth = sizes[rows, last] - sizes[rows, last // 2]
    until = last * step
    time = step * np.arange(looks + 1)
    area = np.zeros_like(sizes)
    area[:, 1:] = np.cumsum((sizes[:, 1:] + sizes[:, :-1]) / 2, axis=1) * step
    y = 2 * sizes
    y[:, 1:] -= 2 * area[:, 1:] / time[1:]
    mean = np.zeros_like(sizes)
    mean[:, 1:] = np.cumsum((y[:, 1:] + y[:, :-1]) / 2, axis=1) * step / time[1:]
    megno = mean[rows, last]
    calm = (
        (growth < REGULAR_GROWTH) & (megno < REGULAR_MEGNO) & (until >= SHORTEST * (1 - _ROUNDING))
    )
    verdict = np.where(growth > UNSTABLE_GROWTH, _CHAOTIC, np.where(calm, 0, 1))
    half = np.maximum(last - last // 2, 1) * step
    return {
        "verdict": verdict,
        "fli": np.nanmax(sizes, axis=1),
        "megno": megno,
        "growth": growth,
        "exponent": growth / half,
        "until": until,
    }
