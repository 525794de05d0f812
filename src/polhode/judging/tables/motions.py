"""The motions that a table may be of, all in doubles: dearer digits are not needed to tell.

The scene's own; the same at other times; those of other scenes, with a sign or an order of numbers
that is often another; those of another clock, body or start, by a number that is fitted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

import numpy as np

from polhode.common.errors import BadInput
from polhode.judging.sources import in_double
from polhode.judging.tables.hypotheses import Hypothesis
from polhode.judging.tables.table import WRONG, Table, TimeChange
from polhode.motion.frame import Frame
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.decimals import brief
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, Doubles, NumberType
from polhode.numbers.vectors import Vector
from polhode.scenes import library
from polhode.scenes.body import Body, exact_vector
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE, STATE

_POLE = 1e-9  # the sine of theta where psi and phi are one angle


def matrices(quaternions: Any) -> Doubles:
    """R (body -> space) of quaternions, scalar first, of any length but 0; shape (n, 3, 3)."""
    with np.errstate(invalid="ignore", divide="ignore"):
        length = np.linalg.norm(quaternions, axis=1, keepdims=True)
        a, b, c, d = (quaternions / np.where(length == 0, 1, length)).T
    rows = [
        [1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)],
    ]
    return np.array(rows).transpose(2, 0, 1)


class Right(NamedTuple):
    """What the reference has at the rows' times."""

    states: Doubles
    attitude: Doubles | None = None  # None where not known
    matrices: Doubles | None = None  # body -> space, likewise

    def part(self, name: str) -> Doubles:
        """A part's numbers; of attitudes and angles the elements of the matrices."""
        if name in ("omega", "gamma"):
            return self.states[:, :3] if name == "omega" else self.states[:, 3:]
        assert self.matrices is not None
        return self.matrices.reshape(len(self.matrices), -1)

    def moved(self, part: str) -> Doubles:
        """How far a part is from its first row, in the measure that its errors are told in."""
        values = self.part(part)
        return errors_of_rows(values, values[0]) / size_of_motion(values, part == "omega")


def errors_of_rows(values: Any, true: Any) -> Doubles:
    """The largest difference in each row."""
    largest: Doubles = np.abs(values - true).reshape(len(values), -1).max(axis=1)
    return largest


def size_of_motion(true: Any, relative: bool) -> float:
    """What errors are told in."""
    return (float(np.max(np.linalg.norm(true, axis=1))) if relative else 1.0) or 1.0


def integrated(
    scene: Scene, times: Sequence[Fraction], attitude: bool = True, number: NumberType = DOUBLE
) -> Right | None:
    """The motion, its attitude too where it has one; None where it cannot be integrated so far.

    ``number``: the type in which it is integrated.
    """
    turning = attitude and bool(scene.columns[3:])
    try:
        rows = in_double(scene, times, ("attitude",) if turning else (), number)
    except ImportError:  # without heyoka
        return None
    if not rows:
        return None
    states = np.asarray(rows["states"], dtype=float)
    if not turning:
        return Right(states)
    quaternions = np.asarray(rows["attitude"], dtype=float)
    return Right(states, quaternions, matrices(quaternions))


# --- other times ----------------------------------------------------------------------------------
#
# A program's t may be a row late, run backward, begin at its first row, or have another unit.


#: Units of time by name, in the scene's.
UNITS: Mapping[str, Fraction] = {
    "milliseconds": Fraction(1, 1000),
    "microseconds": Fraction(1, 1_000_000),
    "nanoseconds": Fraction(1, 1_000_000_000),
    "minutes": Fraction(60),
    "hours": Fraction(3600),
    "days": Fraction(86400),
}
_FAR = 1e5  # radians: few programs go so far, and none begins there


def other_times(times: Sequence[Fraction]) -> dict[str, TimeChange]:
    """Times at which rows may hold instead, by what they are called, the plainest first.

    >>> [*other_times([Fraction(0), Fraction(1, 4)])]
    ['one step late', 'one step early', 'of the other sense', \
'of the other sense, from its last row on (0.25)', 'milliseconds', 'microseconds', 'nanoseconds', \
'minutes', 'hours', 'days']
    """
    first, *later = sorted({*times})
    last = max(times)
    shifts, back = {}, {"of the other sense": TimeChange(sign=-1)}
    units = {name: TimeChange(unit=length) for name, length in UNITS.items()}
    if first:
        words = f"from its first row on ({brief(first)})"
        shifts[words] = TimeChange(shift=first)
        back[f"of the other sense, {words}"] = TimeChange(-1, shift=-first)
        for name, length in UNITS.items():
            units[f"{name}, {words}"] = TimeChange(unit=length, shift=length * first)
    if last not in (first, 0):  # a program that counts down
        words = f"of the other sense, from its last row on ({brief(last)})"
        back[words] = TimeChange(-1, shift=-last)
    steps = {
        f"one step {word}": TimeChange(shift=sign * (second - first))
        for second in later[:1]
        for sign, word in ((1, "late"), (-1, "early"))
    }
    return shifts | steps | back | units


def clock_remark(subject: Table, scene: Scene) -> tuple[str, ...]:
    """That times that are far and close together look like a clock's, in words."""
    first, last = (to_double(end(subject.times)) for end in (min, max))
    nearest = min(abs(first), abs(last))
    if nearest * 10.0**scene.log10_rate < _FAR or last - first > nearest / 10:
        return ()
    began = brief(min(subject.times), 12)
    return (
        f"t looks like a clock's ({began} to {last - first:.3g} later): the first row is not the "
        "scene's start",
    )


def at_other_times(times: Sequence[Fraction], scene: Scene) -> list[Hypothesis]:
    """That the rows of a table hold at other times, those near before those far."""
    changes = other_times(times)

    def farthest(change: TimeChange) -> Fraction:
        return max(abs(change.of(t)) for t in (min(times), max(times)))

    order = sorted(changes.items(), key=lambda item: farthest(item[1]))
    return [
        Hypothesis(words, change, partial(_at_times, scene, change), len(changes))
        for words, change in order
    ]


def _at_times(scene: Scene, change: TimeChange, _: Fraction) -> tuple[Scene, TimeChange]:
    return scene, change


# --- other scenes ---------------------------------------------------------------------------------


def other_scenes(scene: Scene) -> Iterator[Hypothesis]:
    """That a table is of a scene with a sign or an order of numbers that is often another."""
    body, plain = scene.body, TimeChange()
    scenes: dict[str, Scene] = {}
    if body.weight:
        scenes["a weight of the other sign"] = _with_weight(scene, Fraction(-2))
    products = [(i, j) for i in range(3) for j in range(i) if body.inertia[i][j] != 0]
    some = [products, *([product] for product in products)] if len(products) > 1 else [products]
    for signs in filter(None, some):
        names = ", ".join("I" + "xyz"[j] + "xyz"[i] for i, j in signs)
        changes = [(i, j, -2 * body.inertia[i][j]) for i, j in signs]
        with suppress(BadInput, ValueError):  # moments of no body
            words = f"products of inertia of the other sign ({names})"
            scenes[words] = _with_inertia(scene, changes)
    for words, changed in scenes.items():
        yield Hypothesis(words, motion=partial(_at_times, changed, plain), tries=len(scenes))
    if scene.columns[3:] and "quaternion" in scene.source:
        start = integrated(scene, [Fraction(0)])
        if start is not None and start.attitude is not None:
            a, b, c, d = start.attitude[0]
            motion = partial(_at_times, _with_attitude(scene, (d, a, b, c)), plain)
            yield Hypothesis("the scene's quaternion taken as scalar-last", motion=motion)


def _with_attitude(scene: Scene, quaternion: Sequence[float]) -> Scene:
    """The scene from another attitude, a quaternion, scalar first."""
    (matrix,) = matrices(np.array([quaternion]))
    x, y = matrix[0, 2], -matrix[1, 2]  # the sine of theta times those of psi
    if math.hypot(x, y) < _POLE:
        x, y = matrix[1, 0], matrix[0, 0]
    gamma = exact_vector([float(z) for z in matrix[2]])
    return replace(scene, gamma=gamma, psi=Fraction(math.atan2(x, y)), normalise=True)


# --- other numbers --------------------------------------------------------------------------------
#
# One number at a time (of a symmetric body its equal moments, too, as one) that may be another.


_SLOWEST = 0.1  # pace of a clock
CONSTANT = "omega that stays as it is at t = 0, without the terms omega x I omega and of the torque"


def constant_omega(scene: Scene) -> Hypothesis:
    """That omega stays as it is at t = 0: it does so of a body of equal moments without weight."""
    unit, none = Fraction(1), Fraction(0)
    rows = (unit, none, none), (none, unit, none), (none, none, unit)
    sphere = replace(scene, body=Body(rows, (none,) * 3, none))
    return Hypothesis(CONSTANT, motion=partial(_at_times, sphere, TimeChange()))


def other_numbers(scene: Scene) -> Iterator[Hypothesis]:
    """That one number is another, the plainer first: of the clock, of the body, of the start."""
    unit = float(Frame.of(scene).unit)

    def later(x: Fraction) -> tuple[Scene, TimeChange]:
        return scene, TimeChange(shift=-Fraction(float(x) * unit))

    yield Hypothesis("rows that belong to t + {}", motion=later, fitted=1, unit=unit)
    yield Hypothesis(
        "a clock of {} times the pace",
        motion=lambda x: (scene, TimeChange(unit=1 + x)),
        fitted=1,
        origin=1.0,
        smallest=_SLOWEST,
    )
    yield from _other_moments(scene)
    if scene.columns[3:] and scene.body.weight:
        own = to_double(scene.body.weight)
        words = f"a weight, or a distance of the centre, of {{}} times the scene's {own:.6g}"
        yield _number(words, partial(_with_weight, scene), 1.0, 1.0)
        centre = scene.body.centre
        size = max(map(abs, centre))
        for i, axis in enumerate("xyz"):
            own = to_double(centre[i])
            words = f"the centre's {axis} = {{}} (the scene's is {own:.6g})"
            yield _number(words, partial(_with_centre, scene, i, size), own, to_double(size))
    rate = max([to_double(abs(w)) for w in scene.omega]) or 1.0
    for i, name in enumerate(STATE[:3]):
        own = to_double(scene.omega[i])
        words = f"{name} = {{}} at t = 0 (the scene's is {own:.6g})"
        yield _number(words, partial(_with_omega, scene, i, rate), own, rate)


def _other_moments(scene: Scene) -> Iterator[Hypothesis]:
    """That a moment, or an element of a full tensor, is another."""
    inertia = scene.body.inertia
    moments = [inertia[i][i] for i in range(3)]
    if any(inertia[i][j] != 0 for i in range(3) for j in range(i)):
        for i, j in combinations_with_replacement(range(3), 2):
            own, unit = to_double(inertia[i][j]), moments[i] if i == j else max(moments)
            words = f"the element {'xyz'[i]}{'xyz'[j]} of inertia = {{}} (the scene's is {own:.6g})"
            change = partial(_with_elements, scene, [(i, j, unit)])
            yield _number(words, change, own, to_double(unit))
        return
    equal = [i for i in range(3) if moments.count(moments[i]) > 1]
    for axes in [[0], [1], [2], *([equal] if equal else [])]:
        own = to_double(moments[axes[0]])
        letters = " = ".join("ABC"[i] for i in axes)
        noun, verb = ("moment", "is") if len(axes) == 1 else ("moments", "are")
        words = f"the {noun} {letters} = {{}} (the scene's {verb} {own:.6g})"
        change = partial(_with_elements, scene, [(i, i, moments[i]) for i in axes])
        yield _number(words, change, own, own)


def _number(
    words: str, scene_of: Callable[[Fraction], Scene], origin: float, unit: float
) -> Hypothesis:
    """That a number of the scene is ``origin + unit * x``."""

    def motion(x: Fraction) -> tuple[Scene, TimeChange]:
        return scene_of(x), TimeChange()

    return Hypothesis(words, motion=motion, fitted=1, origin=origin, unit=unit)


def _with_elements(scene: Scene, elements: Sequence[tuple[int, int, Exact]], x: Fraction) -> Scene:
    """The scene with elements of inertia that are x units larger."""
    return _with_inertia(scene, [(i, j, x * unit) for i, j, unit in elements])


def _with_inertia(scene: Scene, changes: Sequence[tuple[int, int, Exact]]) -> Scene:
    """The scene with elements of inertia that are so much larger."""
    inertia = [*scene.body.inertia]
    for i, j, change in changes:
        for row, column in {(i, j), (j, i)}:
            inertia[row] = _moved(inertia[row], column, change)
    a, b, c = inertia
    return replace(scene, body=scene.body.replaced(inertia=(a, b, c)))


def _with_weight(scene: Scene, x: Fraction) -> Scene:
    return replace(scene, body=scene.body.replaced(weight=scene.body.weight * (1 + x)))


def _with_centre(scene: Scene, place: int, size: Exact, x: Fraction) -> Scene:
    centre = _moved(scene.body.centre, place, x * size)
    return replace(scene, body=scene.body.replaced(centre=centre))


def _with_omega(scene: Scene, place: int, rate: float, x: Fraction) -> Scene:
    return replace(scene, omega=_moved(scene.omega, place, Fraction(rate * float(x))))


def _moved(vector: Vector, place: int, by: Exact) -> Vector:
    """A vector with one component so much larger."""
    a, b, c = (x + by if k == place else x for k, x in enumerate(vector))
    return a, b, c


# --- another start --------------------------------------------------------------------------------
#
# That a table begins with another state than the scene, and with which case's, in words.


_SAME_START = 6.0  # digits of a start that is a case's
_SHOWN = 2  # cases


def other_start(subject: Table, scene: Scene) -> str:
    """That a table's row at t = 0 is not the scene's start; empty where it is, or there is none."""
    row = _start_of(subject)
    off = {name: digits for name, digits in _digits(row, scene).items() if digits < WRONG}
    if not off:
        return ""
    own = dict(zip(scene.columns, map(to_double, scene.start), strict=True))
    theirs = ", ".join(f"{name} = {row[name]:.6g}" for name in off)
    right = ", ".join(f"{name} = {own[name]:.6g}" for name in off)
    cases = (library.load(name) for name in library.names())
    alike = [case.name for case in cases if min(_digits(row, case).values()) >= _SAME_START]
    return f"at t = 0 it has {theirs}, where {scene.name} has {right}{_begin_so(alike)}"


def _begin_so(cases: list[str]) -> str:
    """Which cases begin as the table does, the hard ones last; nothing where none does."""
    if not cases:
        return ""
    shown = sorted(cases, key=lambda name: name.startswith("hard/"))[:_SHOWN]
    more = f" (and {len(cases) - _SHOWN} more)" * (len(cases) > _SHOWN)
    return f"; {' and '.join(shown)}{more} begin{'s' * (len(cases) == 1)} so"


def _start_of(subject: Table) -> Mapping[str, float]:
    """The numbers of the state at t = 0, as far as they are there; gamma also of a quaternion."""
    if 0 not in subject.times:
        return {}
    place = subject.times.index(0)
    cells = {
        name: subject.columns[name][place]
        for name in (*subject.state, *ATTITUDE)
        if name in subject.columns
    }
    row = {name: to_double(exactly(x)) for name, x in cells.items() if x is not None}
    if {*ATTITUDE} <= row.keys():
        (matrix,) = matrices(np.array([[row[name] for name in ATTITUDE]]))
        row = dict(zip(STATE[3:], matrix[2].tolist(), strict=True)) | row
    return {name: x for name, x in row.items() if name in STATE}


def _digits(row: Mapping[str, float], scene: Scene) -> Mapping[str, float]:
    """To how many digits each number is that of a scene's start; 0 where the scene has none."""
    start = dict(zip(scene.columns, map(to_double, scene.start), strict=True))
    size = math.hypot(*(start[name] for name in STATE[:3])) or 1.0
    off = {name: abs(x - start.get(name, math.inf)) for name, x in row.items()}
    for name in {*STATE[:3]} & off.keys():
        off[name] /= size
    return {name: -math.log10(x) if x else math.inf for name, x in off.items()}
