"""Sections of a level: where many orbits of one body cross it, and in which coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from polhode.common.arguments import each, whole
from polhode.common.errors import BadInput
from polhode.common.provenance import provenance
from polhode.dynamics import permanent
from polhode.dynamics.jobs import Progress, carried_out
from polhode.dynamics.kept import Kept
from polhode.dynamics.levels import least_energy
from polhode.dynamics.permanent import RationalBody
from polhode.equations.integrals import first_integrals
from polhode.equations.section_zero import HEIGHT, MOMENTUM
from polhode.numbers import expression
from polhode.numbers.convert import exact_number, to_double, to_extended
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact
from polhode.numbers.expression import ExpressionError
from polhode.numbers.polynomials import fraction_near
from polhode.scenes import library
from polhode.scenes.columns import check
from polhode.scenes.scene import Scene
from polhode.scenes.words import STATE

MAXIMA, MINIMA = "max", "min"
OWN = "scene"  # in place of starts
GRID, CROSSINGS = (9, 8), 500
MOST_CROSSINGS, MOST_STARTS = 1_000_000, 1_000_000
LANES = 64  # orbits of a job: where one is over the next takes its lane
CHUNK = 160.0  # radians of the fastest rate between two projections
WORTH_A_PROCESS = 200_000  # crossings, of two seconds
PATIENCE = 1000.0  # units of time without a crossing until an orbit is given up


@dataclass(frozen=True, repr=False)
class Section:
    """Crossings of a section by orbits on one level, an orbit a row; nan past an orbit's last one.

    ``by``: momentum, height, or an expression.  ``starts`` (n, 2): coordinates of the starts.
    ``states`` (n, m, 6): p q r gamma1 gamma2 gamma3 in the scene's axes and units.  ``times``,
    ``rests`` (n, m): a time is their sum.  ``l``, ``ratio`` (n, m): Andoyer's angle l and L/G about
    r0.  ``counts`` (n,); ``outcomes``: how each orbit ended.  ``drift``: the largest residual of h,
    f and |gamma|^2 before a projection, relative.

    >>> import polhode
    >>> found = polhode.section("lagrange/nutation", starts=[[1, 0.2]], crossings=20)
    >>> found
    <Section of lagrange/nutation by momentum: 1 orbit, 20 crossings>
    >>> float(found.ratio[0].max() - found.ratio[0].min()) < 1e-14  # L is an integral, and so is G
    True
    """

    scene: Scene
    h: Exact
    f: Exact
    by: str
    extremum: str
    starts: Any
    states: Any
    times: Any
    rests: Any
    l: Any
    ratio: Any
    counts: Any
    outcomes: tuple[str, ...]
    drift: float
    interrupted: bool = False
    kept: Kept | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        n = len(self.counts)
        orbits = f"{n} orbit" + ("s" if n != 1 else "")
        made = int(self.counts.sum())
        return f"<Section of {self.scene.name} by {self.by}: {orbits}, {made} crossings>"

    @property
    def complete(self) -> bool:
        """Whether every orbit made all its crossings."""
        return not self.interrupted and bool((self.counts == self.times.shape[1]).all())


class Asked(NamedTuple):
    """A scene's body, a level and a section of it, checked."""

    scene: Scene
    h: Exact
    f: Exact
    by: str
    extremum: str


def section(
    scene: Scene | str | Path,
    by: str | None = None,
    extremum: str | None = None,
    starts: Any = None,
    grid: tuple[int, int] | None = None,
    crossings: int | None = None,
    h: Any = None,
    f: Any = None,
    workers: int | None = None,
    executor: Executor | None = None,
    parts: Path | None = None,
    progress: Progress | None = None,
) -> Section:
    """Follow orbits of a scene's body on a level to their crossings of a section.

    ``by``: "momentum" (extrema of |G|, the default) or "height" (extrema of r0.gamma), both of
    which every orbit crosses; or an expression in p q r gamma1 gamma2 gamma3, whose zeros in either
    direction are taken.  ``extremum``: "max" (default) or "min".  ``starts``: [l, L/G] or
    [l, L/G, k], the k-th of several by rising y, for momentum and expressions;
    [gamma1, gamma2, gamma3, ±1] in the scene's axes for height; or "scene", its own start.
    ``grid``: as many cells of both coordinates instead, starts in their centres (9 x 8).  ``h``,
    ``f``: the level, the scene's own unless given.  What the scene's [section] says stands where
    nothing is given.  ``workers``: processes.  ``executor``: of concurrent.futures.  ``parts``: a
    folder for finished jobs.

    Raises BadInput for a level that does not exist, a start outside the section, an expression that
    does not change or is never zero.

    >>> import polhode
    >>> scene = polhode.load("general/asymmetric-chaotic")
    >>> found = polhode.section(scene, grid=(2, 2), crossings=5, h=3, f="1/2")
    >>> found.states.shape
    (4, 5, 6)
    """
    import numpy as np

    from polhode.dynamics import section_states as geometry
    from polhode.taylor import crossings as taylor

    scene = library.load(scene)
    plan = scene.section
    asked = asked_of(scene, by or plan.by, extremum or plan.extremum, h, f)
    count = whole(scene.name, "crossings", crossings or plan.crossings, 1, MOST_CROSSINGS)
    if starts is None and grid is None and plan.starts:
        starts = plan.starts
    on = geometry.ground(scene, asked.h, asked.f)
    found = starts_of(asked, on, starts, grid)
    zero = zero_of(asked.scene, on, asked.by)
    direction = 0
    if asked.by in (MOMENTUM, HEIGHT):
        direction = -1 if asked.extremum == MAXIMA else 1
    _refuse_constant(asked, zero, found.states)
    jobs = _jobs(asked, on, zero, direction, count, found.states)
    key = repr((scene.text, str(asked[1:]), count, direction, found.states.tobytes()))
    kept = None if parts is None else Kept(parts, "section", key)
    results, interrupted = carried_out(
        taylor.solve,
        jobs,
        [len(job.starts) for job in jobs],
        workers or _workers(len(jobs), count),
        executor,
        kept,
        _packed,
        _unpacked,
        progress,
        processes=True,
    )
    rows = np.concatenate(
        [np.full(len(job.starts), r is not None) for job, r in zip(jobs, results, strict=True)]
    )
    if not rows.any():
        raise KeyboardInterrupt
    crossed = taylor.joined([result for result in results if result is not None])
    if asked.by not in (MOMENTUM, HEIGHT) and not crossed.found.any():
        _refuse_never_zero(asked, on, zero)
    return _result(asked, on, found.states[rows], crossed, interrupted, kept)


def asked_of(scene: Scene, by: str, extremum: str, h: Any, f: Any) -> Asked:
    """What is asked, checked; ``h`` and ``f`` None for the scene's own.  Raises BadInput."""
    if scene.gamma is None:
        raise BadInput(scene.name, "start.gamma", None, "given: a level is one of h and f")
    if extremum not in (MAXIMA, MINIMA):
        raise BadInput(scene.name, "extremum", extremum, "max or min")
    if by not in (MOMENTUM, HEIGHT):
        try:
            check(by, STATE)
        except ExpressionError as fault:
            expected = f"momentum, height, or an expression in {' '.join(STATE)} ({fault})"
            raise BadInput(scene.name, "by", by, expected) from None
    own = scene.integrals
    assert own.area is not None
    level = [
        default if given is None else each(scene.name, key, (given,), exact_number, "a number")[0]
        for key, given, default in (("h", h, own.energy), ("f", f, own.area))
    ]
    found = Asked(scene, level[0], level[1], by, extremum)
    body = RationalBody.of(scene.body)
    near = fraction_near(found.f, permanent.BODY_BITS)[0]
    least = least_energy(body, permanent.arcs(body), near)
    if to_double(found.h) <= least:
        expected = f"above {least:.12g}, the least energy at f = {shown(found.f)}"
        raise BadInput(scene.name, "h", shown(found.h), expected)
    return found


def starts_of(asked: Asked, on: Any, starts: Any, grid: tuple[int, int] | None) -> Any:
    """States of the starts; raises BadInput for one that is not on the section."""
    import numpy as np

    from polhode.dynamics import section_states as geometry

    name, maxima = asked.scene.name, asked.extremum == MAXIMA
    if starts is None:
        first, second = (whole(name, "grid", n, 1, MOST_STARTS) for n in grid or GRID)
        angle, cosine = geometry.cells(first, second)
        if asked.by == HEIGHT:
            gamma = np.repeat(geometry.gamma_at(on, angle, cosine), 2, axis=0)
            found = geometry.height_states(on, gamma, np.tile([1.0, -1.0], len(angle)), maxima)
        else:
            found = geometry.momentum_states(on, angle, cosine, maxima)
        if len(found.states) == 0:
            expected = "a finer grid: no cell's centre is on the level"
            raise BadInput(name, "grid", f"{first}x{second}", expected)
        return found
    if isinstance(starts, str) and starts == OWN:
        return geometry.Found(_own(asked, on)[None, :], np.zeros(1, dtype=int))
    rows = [
        [to_double(x) for x in each(name, f"starts[{k + 1}]", row, exact_number, "numbers")]
        for k, row in enumerate(each(name, "starts", starts, lambda row: row, "a list of starts"))
    ]
    if not rows:
        raise BadInput(name, "starts", "nothing", "at least one start")
    one = _height_start if asked.by == HEIGHT else _momentum_start
    states = [one(asked, on, f"starts[{k + 1}]", row) for k, row in enumerate(rows)]
    return geometry.Found(np.array(states), np.arange(len(states)))


def _own(asked: Asked, on: Any) -> Any:
    """The scene's own start, on the section or not."""
    import numpy as np

    scene = asked.scene
    assert scene.gamma is not None
    if asked.h != scene.integrals.energy or asked.f != scene.integrals.area:
        raise BadInput(scene.name, "starts", OWN, "the scene's own h and f")
    axes, unit = scene.body.axes, Fraction(2) ** scene.time_unit
    parts = [*(unit * w for w in axes.components(scene.omega)), *axes.components(scene.gamma)]
    return _moving(asked, on, "starts", OWN, np.array([to_double(x) for x in parts]))


def _momentum_start(asked: Asked, on: Any, key: str, row: Sequence[float]) -> Any:
    import numpy as np

    from polhode.dynamics import section_states as geometry

    name, shown_row = asked.scene.name, f"[{', '.join(f'{x:g}' for x in row)}]"
    if len(row) not in (2, 3) or (len(row) == 3 and row[2] != int(row[2])):
        raise BadInput(name, key, shown_row, "[l, L/G] or [l, L/G, k] with k = 0, 1, ...")
    if not -1 < row[1] < 1:
        raise BadInput(name, key, shown_row, "L/G between -1 and 1")
    maxima = asked.extremum == MAXIMA
    found = geometry.momentum_states(on, np.array([row[0]]), np.array([row[1]]), maxima)
    k = int(row[2]) if len(row) == 3 else 0
    if not 0 <= k < len(found.states):
        kind = f"{'maxima' if maxima else 'minima'} of |G|"
        expected = f"k below {len(found.states)}"
        if not len(found.states):
            expected = _where(on, row[0], maxima)
        raise BadInput(name, key, shown_row, f"a point with {kind}: {expected}")
    return _moving(asked, on, key, shown_row, found.states[k])


def _where(on: Any, l: float, maxima: bool) -> str:
    """The range of L/G that has states at this l."""
    import numpy as np

    from polhode.dynamics import section_states as geometry

    sig = -1 + (np.arange(1000) + 0.5) / 500
    found = geometry.momentum_states(on, np.full(1000, l), sig, maxima)
    if len(found.of) == 0:
        return "there is none at this l"
    inside = sig[found.of]
    return f"at this l they lie from L/G = {inside.min():.4g} to {inside.max():.4g}"


def _height_start(asked: Asked, on: Any, key: str, row: Sequence[float]) -> Any:
    import numpy as np

    from polhode.dynamics import section_states as geometry

    name, shown_row = asked.scene.name, f"[{', '.join(f'{x:g}' for x in row)}]"
    length = sum(x * x for x in row[:3]) ** 0.5
    if len(row) != 4 or row[3] not in (1, -1) or abs(length - 1) > 1e-6:
        raise BadInput(name, key, shown_row, "[gamma1, gamma2, gamma3, 1 or -1], gamma of length 1")
    axes = asked.scene.body.axes
    turned = np.array([[to_double(x) for x in line] for line in axes.rows])
    gamma = (turned @ np.array(row[:3]) / length)[None, :]
    maxima = asked.extremum == MAXIMA
    for kind in (maxima, not maxima):
        found = geometry.height_states(on, gamma, np.array([row[3]]), kind)
        if len(found.states):
            break
    if not len(found.states):
        inertia = float((gamma[0] ** 2 * on.moments).sum())
        least = on.f**2 / (2 * inertia) + float(gamma[0] @ on.torque)
        unit = 2.0 ** (2 * asked.scene.time_unit)
        if least > on.h:
            expected = f"a gamma that the level allows: h is at least {least / unit:.12g} there"
        else:
            expected = "a gamma that is not along the centre of mass"
        raise BadInput(name, key, shown_row, expected)
    if kind is not maxima:
        expected = f"a {'maximum' if maxima else 'minimum'} of the height; this is the other kind"
        raise BadInput(name, key, shown_row, expected)
    return _moving(asked, on, key, shown_row, found.states[0])


def _moving(asked: Asked, on: Any, key: str, shown_row: str, state: Any) -> Any:
    """A start that is no permanent rotation."""
    import numpy as np

    w, g = state[:3], state[3:]
    moment = np.cross(g, on.torque) - np.cross(w, w * on.moments)
    speed = float(np.linalg.norm(np.cross(g, w)))
    if speed < 1e-9 * on.fastest and float(np.linalg.norm(moment)) < 1e-9 * on.fastest**2:
        expected = "a motion: this is a permanent rotation, which crosses no section"
        raise BadInput(asked.scene.name, key, shown_row, expected)
    return state


def zero_of(scene: Scene, on: Any, by: str) -> Any:
    """A section's function, scaled to order one."""
    from polhode.equations.section_zero import SectionZero

    moments = tuple(float(a) for a in on.moments)
    side = -1.0 if on.weight < 0 else 1.0
    size = on.largest_momentum if by == MOMENTUM else on.fastest
    arm = tuple(float(side * x / (size or 1.0)) for x in on.frame[2])
    if by == HEIGHT:
        arm = tuple(float(x / (size or 1.0)) for x in on.frame[2])
    rows = tuple(tuple(to_double(x) for x in row) for row in scene.body.axes.rows)
    return SectionZero(by, moments, arm, rows, 2.0**scene.time_unit)  # type: ignore[arg-type]


def _refuse_constant(asked: Asked, zero: Any, states: Any) -> None:
    """Raise BadInput for an expression whose rate vanishes at every start."""
    import numpy as np

    from polhode.equations.forms import principal
    from polhode.taylor import crossings as taylor

    if asked.by in (MOMENTUM, HEIGHT):
        return
    k = {
        name: to_double(x)
        for name, x in principal.coefficients(asked.scene.body, asked.scene.time_unit).items()
    }
    moved = states.T + 1e-3 * np.random.default_rng(0).normal(size=states.T.shape)
    try:
        with np.errstate(all="ignore"):
            speed = taylor.slope(zero, moved, taylor.rates(k, moved))
            value = np.real(zero.value(list(moved), taylor.ARRAYS))
    except (ArithmeticError, AttributeError, TypeError):  # no name in it
        speed = value = np.zeros(1)
    if not np.any(np.abs(speed) > 1e-12 * np.maximum(1e-300, np.abs(value))):
        expected = "an expression that changes along the motion; this one is constant"
        raise BadInput(asked.scene.name, "by", asked.by, expected)


def _refuse_never_zero(asked: Asked, on: Any, zero: Any) -> None:
    import numpy as np

    from polhode.dynamics import section_states as geometry
    from polhode.taylor import crossings as taylor

    grid = geometry.cells(60, 60)
    states = [geometry.momentum_states(on, *grid, kind).states for kind in (True, False)]
    values = np.real(zero.value(list(np.concatenate(states).T), taylor.ARRAYS))
    expected = (
        "an expression that becomes zero; at the extrema of |G| on this level it is from "
        f"{np.nanmin(values):.4g} to {np.nanmax(values):.4g}, and no orbit crosses 0"
    )
    raise BadInput(asked.scene.name, "by", asked.by, expected)


def _jobs(asked: Asked, on: Any, zero: Any, direction: int, count: int, states: Any) -> list[Any]:
    import numpy as np

    from polhode.equations.forms import principal
    from polhode.taylor.crossings import CrossingJob, Level

    scene = asked.scene
    known = level_of(scene, asked.h, asked.f)
    k = tuple(
        (name, to_double(x))
        for name, x in principal.coefficients(scene.body, scene.time_unit).items()
    )
    chunk = 2.0 ** round(np.log2(CHUNK / (on.fastest or 1.0)))
    patience = int(-(-PATIENCE // chunk))
    assert isinstance(known, Level)
    return [
        CrossingJob(
            k, zero, direction, count, np.inf, chunk, patience, known, states[first : first + LANES]
        )
        for first in range(0, len(states), LANES)
    ]


def level_of(scene: Scene, h: Exact, f: Exact) -> Any:
    """The integrals of a level, as those of a scene on it."""
    from polhode.equations import integrals
    from polhode.taylor.crossings import Level

    known = first_integrals(scene)
    if integrals.CHAPLYGIN in known.onto and f != 0:
        known = integrals.FirstIntegrals(known.onto[:-1], known.order, known.coefficients)
    unit, largest = Fraction(2) ** scene.time_unit, max(scene.body.moments)
    targets = (2 * h * unit * unit / largest, f * unit / largest, Fraction(1))
    coefficients = {name: to_extended(x) for name, x in known.coefficients.items()}
    return Level(known, coefficients, tuple(to_extended(x) for x in targets))


def _workers(jobs: int, crossings: int) -> int:
    """Processes: as many as pay, for each costs half a second to begin.

    Threads would not do: at every crossing they wait for each other.
    """
    from polhode.runs.workers import cores

    return max(1, min(cores(), jobs, jobs * LANES * crossings // WORTH_A_PROCESS))


def _packed(result: Any) -> dict[str, Any]:
    import numpy as np

    return {**result._asdict(), "outcomes": np.array(result.outcomes)}


def _unpacked(held: dict[str, Any]) -> Any:
    from polhode.taylor.crossings import Crossed

    held["outcomes"] = tuple(held["outcomes"].tolist())
    held["drift"] = float(held["drift"])
    return Crossed(**held)


def _result(
    asked: Asked, on: Any, states: Any, crossed: Any, interrupted: bool, kept: Kept | None
) -> Section:
    import numpy as np

    from polhode.dynamics import section_states as geometry

    scene = asked.scene
    angles = geometry.height_coordinates if asked.by == HEIGHT else geometry.coordinates
    l, ratio = geometry.coordinates(on, crossed.states)
    unit = 2.0**scene.time_unit
    rows = np.array([[to_double(x) for x in row] for row in scene.body.axes.rows])
    turned = np.concatenate(
        [crossed.states[..., :3] @ rows / unit, crossed.states[..., 3:] @ rows], axis=-1
    )
    return Section(
        scene,
        asked.h,
        asked.f,
        asked.by,
        asked.extremum,
        np.stack(angles(on, states), axis=-1),
        turned,
        crossed.times * unit,
        crossed.rests * unit,
        l,
        ratio,
        crossed.found,
        crossed.outcomes,
        crossed.drift,
        interrupted,
        kept,
        provenance(scene.text),
    )


def read_starts(path: Path) -> list[list[Exact]]:
    """Starts of a text file: a line each, numbers apart by commas or blanks, # begins a comment."""
    from polhode.common.files import read_whole

    text = read_whole(path, 50_000_000, "a list of starts", str(path)).decode("utf-8", "replace")
    rows = []
    for number, line in enumerate(text.splitlines(), 1):
        parts = line.partition("#")[0].replace(",", " ").split()
        if not parts:
            continue
        try:
            rows.append([expression.number(part) for part in parts])
        except ExpressionError as fault:
            raise BadInput(str(path), f"line {number}", line, f"numbers ({fault})") from None
    if not rows:
        raise BadInput(str(path), "file", None, "at least one start, a line each")
    return rows
