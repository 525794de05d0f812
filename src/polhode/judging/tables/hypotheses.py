"""What may be wrong with a table, and the one rule by which it is accepted.

And the motions that a table may be of, all in doubles: dearer digits are not needed to tell.  The
scene's own; the same at other times; those of other scenes, with a sign or an order of numbers that
is often another; those of another clock, body or start, by a number that is fitted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import combinations_with_replacement
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from polhode.common.errors import BadInput
from polhode.judging.auxiliary_runs import in_double
from polhode.judging.tables.table import WRONG, Change, TimeChange, TrajectoryTable
from polhode.motion.frame import Frame
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.decimals import brief
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, Doubles, NumberType
from polhode.numbers.vectors import Matrix, Vector, rotation
from polhode.scenes import library
from polhode.scenes.body import IDENTITY, Body, exact_vector
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE, STATE

# --- the rule -------------------------------------------------------------------------------------
#
# A *hypothesis* says how a part of a table is to be read, at which times its rows hold, or of which
# other scene it is the motion.  Its *evidence* is the digits that the rows have then.  The rule is
# the same for all of them.
#
# **The first rows tell.**  A program that drifts is right at the start, where the scene is exact,
# and wrong at the end.  So digits are counted from the first row on and never rise again: what is
# wrong in the first rows is wrong, and what is right there may drift as it likes.  Rows to which a
# number of the hypothesis was fitted say nothing one by one: what counts for them are the rows
# after them, and where there are none, their own fewest digits.
#
# **Chance.**  A hypothesis of which ``tries`` were tried has to have so many digits more than the
# table as it stands that one in some thousand tables of random numbers has one.  A number that was
# fitted to all rows costs as much again; one that was fitted to the first costs those rows.
#
# **Motion.**  It has to follow the motion: where the motion has left its first row, the table is
# nearer to it than one that stays there, or goes elsewhere, would be.


MOST = 12.0  # digits that count: more are no more certain
LEAST_GAIN = 1.5  # digits that a hypothesis gives at least, at some row
_RARE = 3.5  # log10 of so many tables of which one is right by chance
_ALIKE, _ALIKE_IF_EXACT, EXACT = 0.3, 1.0, 9.0  # digits by which hypotheses do not differ
SURE = 6.0  # digits of a first row that is the start
_STAYS = 0.5  # digits that are left where the motion has left it
_LEFT = 0.1  # of its size: by so much the motion has left its first row
_FAR_LEFT = 0.5  # likewise, so that what goes elsewhere is plainly not there
_STILL = 0.01  # and by less it stands still
_FOLLOWS = 0.7  # digits of the way that the motion has come

AS_THEY_STAND = TimeChange()
#: The scene whose number is so much larger, and its times; raises ValueError for no body.
Motion: TypeAlias = Callable[[Fraction], tuple[Scene, TimeChange]]


class Hypothesis(NamedTuple):
    """What may be wrong with a part of a table, or with all of it.

    ``words``: how it is told, with {} for the number that is fitted; empty for the table as it
    stands.  ``change``: how a part is read; None where that is told and not applied.  ``motion``:
    of which the whole table may be, and at which times.  ``tries``: how many are as plain, of which
    one may be right by chance.  ``fitted``: how many numbers are fitted to the table, for the x of
    ``motion`` ``origin + unit * x``, ``smallest`` or more.
    """

    words: str = ""
    change: Change | None = None
    motion: Motion | None = None
    tries: int = 1
    fitted: int = 0
    origin: float = 0.0
    unit: float = 1.0
    smallest: float = -math.inf

    def of(self, x: Fraction) -> tuple[Scene, TimeChange]:
        """The motion of which it says that the table is; 0 before a number is fitted."""
        assert self.motion is not None
        return self.motion(x)


class Evidence(NamedTuple):
    """The digits that rows of a table have under a hypothesis, those of the earliest row first.

    ``rows_fitted``: how many of them its numbers were fitted to.  ``freedom``: the numbers of a row
    that are free of each other.
    """

    hypothesis: Hypothesis
    rows: Doubles
    rows_fitted: int = 0
    freedom: int = 1

    @property
    def digits(self) -> float:
        """The fewest digits of a row."""
        return float(np.min(self.rows))

    @property
    def course(self) -> Doubles:
        """The digits that count at each row: the fewest up to there."""
        digits = np.clip(self.rows, 0.0, MOST)
        if self.rows_fitted >= len(digits):
            return np.full(len(digits), np.min(digits))
        digits[: self.rows_fitted] = digits[self.rows_fitted]
        course: Doubles = np.minimum.accumulate(digits)
        return course

    @property
    def gain(self) -> float:
        """The digits more than as it stands that random numbers hardly have in any of the tries."""
        chance = (math.log10(self.hypothesis.tries) + _RARE) / self.freedom
        is_all_fitted = self.hypothesis.fitted and self.rows_fitted >= len(self.rows)
        return max(LEAST_GAIN, chance) * (2 if is_all_fitted else 1)

    def follows(self, moved: Doubles, must_move: bool = False, is_named: bool = False) -> bool:
        """Whether it goes with the motion; ``moved``: how far that is from its first row.

        ``must_move``: whether a motion that stands still tells nothing.  ``is_named``: whether the
        first row alone tells, being the start to many digits in one convention.
        """
        course, fitted = self.course, bool(self.hypothesis.fitted)
        is_named = is_named and float(course[0]) >= SURE and not must_move
        left = np.flatnonzero(moved >= (_FAR_LEFT if is_named or fitted else _LEFT))
        row = int(left[0]) if len(left) else int(np.argmax(moved))
        if is_named:
            return float(course[row]) >= _STAYS
        if moved[row] < _STILL and not (fitted or must_move):
            return True
        if moved[row] == 0:
            return False
        digits = float(course[row]) + math.log10(float(moved[row]))
        return digits >= _FOLLOWS * (2 if fitted else 1)


class Trial(NamedTuple):
    """Evidence of a part beside that of a rival, the part as it stands unless another is better.

    ``goes``: whether the evidence goes with the motion.
    """

    evidence: Evidence
    rival: Evidence
    goes: bool

    @property
    def is_told(self) -> bool:
        """Whether it explains the part."""
        return explains([self])

    @property
    def convention(self) -> Evidence:
        """In which the part is read."""
        return self.evidence if self.is_told else self.rival

    def of_tries(self, tries: int) -> Trial:
        """The same of a hypothesis of the whole table, of which so many are as plain."""
        hypothesis = self.evidence.hypothesis._replace(tries=tries)
        return self._replace(evidence=self.evidence._replace(hypothesis=hypothesis))


def explains(trials: Sequence[Trial]) -> bool:
    """The rule: whether evidence of all parts of a table explains it.

    All of them begin right and have more digits together; one or more have far more at some row,
    and no fewer before it, and go with the motion.
    """
    better, more = [], 0.0
    for trial in trials:
        mine, rival = trial.evidence.course, trial.rival.course
        count = min(len(mine), len(rival))  # as far as both go
        gains = mine[:count] - rival[:count]
        more += float(np.sum(gains))
        first = np.flatnonzero(gains >= trial.evidence.gain)[:1]
        if len(first) and np.all(gains[: first[0]] >= -_slack(rival[: first[0]])):
            better.append(trial)
    begin = all(float(trial.evidence.course[0]) >= LEAST_GAIN for trial in trials)
    return bool(better) and all(trial.goes for trial in better) and more > 0 and begin


def is_alike(mine: Doubles, best: Doubles) -> bool:
    """Whether a course is as good as the best one, where that has any digits."""
    return bool(np.all((mine >= best - _slack(best)) | (best < 1.0)))


def _slack(digits: Doubles) -> Doubles:
    return np.where(digits >= EXACT, _ALIKE_IF_EXACT, _ALIKE)


# --- a motion in doubles --------------------------------------------------------------------------


_POLE = 1e-9  # the sine of theta where psi and phi are one angle


def matrices(quaternions: Any) -> Doubles:
    """R (body -> space) of quaternions, scalar first, of any length but 0; shape (n, 3, 3)."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        return np.array(rotation([*np.transpose(quaternions)])).T.reshape(-1, 3, 3)


class Right(NamedTuple):
    """What the reference has at the rows' times."""

    states: Doubles
    attitude: Doubles | None = None  # None where not known

    @property
    def matrices(self) -> Doubles | None:
        """The attitude's matrices, body -> space."""
        return None if self.attitude is None else matrices(self.attitude)

    def part(self, name: str) -> Doubles:
        """A part's numbers; of attitudes and angles the elements of the matrices."""
        if name in ("omega", "gamma"):
            return self.states[:, :3] if name == "omega" else self.states[:, 3:]
        assert self.attitude is not None
        return matrices(self.attitude).reshape(len(self.attitude), -1)

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
    outputs = ("attitude",) if attitude and scene.columns[3:] else ()
    try:
        rows = in_double(scene, times, outputs, number)
    except ImportError:  # without heyoka
        return None
    if not rows:
        return None
    return Right(*(np.asarray(rows[name], dtype=float) for name in ("states", *outputs)))


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


def clock_remark(subject: TrajectoryTable, scene: Scene) -> tuple[str, ...]:
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
    changes, ends = other_times(times), (min(times), max(times))
    near_first = sorted(changes, key=lambda words: max(abs(changes[words].of(t)) for t in ends))
    return [_plainly(words, scene, changes[words], len(changes)) for words in near_first]


def _plainly(
    words: str, scene: Scene, change: TimeChange = AS_THEY_STAND, tries: int = 1
) -> Hypothesis:
    """That a table is of a scene, without a number to be fitted."""
    return Hypothesis(words, motion=lambda _: (scene, change), tries=tries)


# --- other scenes ---------------------------------------------------------------------------------


def other_scenes(scene: Scene) -> Iterator[Hypothesis]:
    """That a table is of a scene with a sign or an order of numbers that is often another."""
    inertia, opposite = scene.body.inertia, Fraction(-2)
    scenes: dict[str, Scene] = {}
    if scene.body.weight:
        scenes["a weight of the other sign"] = _with_weight(scene, opposite)
    products = [(i, j, inertia[i][j]) for i in range(3) for j in range(i) if inertia[i][j] != 0]
    some = [products, *([product] for product in products)] if len(products) > 1 else [products]
    for elements in filter(None, some):
        names = ", ".join("I" + "xyz"[j] + "xyz"[i] for i, j, _ in elements)
        with suppress(BadInput, ValueError):  # moments of no body
            words = f"products of inertia of the other sign ({names})"
            scenes[words] = _with_elements(scene, elements, opposite)
    for words, changed in scenes.items():
        yield _plainly(words, changed, tries=len(scenes))
    if scene.columns[3:] and "quaternion" in scene.source:
        start = integrated(scene, [Fraction(0)])
        if start is not None and start.attitude is not None:
            a, b, c, d = start.attitude[0]
            words = "the scene's quaternion taken as scalar-last"
            yield _plainly(words, _with_attitude(scene, (d, a, b, c)))


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
    return _plainly(CONSTANT, replace(scene, body=Body(IDENTITY)))


def other_numbers(scene: Scene) -> Iterator[Hypothesis]:
    """That one number is another, the plainer first: of the clock, of the body, of the start."""
    unit = float(Frame.of(scene).unit)
    yield Hypothesis(
        "rows that belong to t + {}",
        motion=lambda x: (scene, TimeChange(shift=-Fraction(float(x) * unit))),
        fitted=1,
        unit=unit,
    )
    yield Hypothesis(
        "a clock of {} times the pace",
        motion=lambda x: (scene, TimeChange(unit=1 + x)),
        fitted=1,
        origin=1.0,
        smallest=_SLOWEST,
    )
    for words, places, own, size in _elements(scene.body.inertia):
        elements = [(i, j, size) for i, j in places]
        yield _number(words, partial(_with_elements, scene, elements), own, to_double(size))
    if scene.columns[3:] and scene.body.weight:
        weight = f"{to_double(scene.body.weight):.6g}"
        words = f"a weight, or a distance of the centre, of {{}} times the scene's {weight}"
        yield _number(words, partial(_with_weight, scene), Fraction(1), 1.0)
        centre = scene.body.centre
        size = max(map(abs, centre))
        for i, axis in enumerate("xyz"):
            words = f"the centre's {axis} = {{}} (the scene's is {{own}})"
            yield _number(words, partial(_with_centre, scene, i, size), centre[i], to_double(size))
    rate = max([to_double(abs(w)) for w in scene.omega]) or 1.0
    for i, name in enumerate(STATE[:3]):
        words = f"{name} = {{}} at t = 0 (the scene's is {{own}})"
        yield _number(words, partial(_with_omega, scene, i, rate), scene.omega[i], rate)


def _elements(inertia: Matrix) -> Iterator[tuple[str, list[tuple[int, int]], Exact, Exact]]:
    """The moments, or the elements of a full tensor, that may be another: in words, their places,
    the scene's, and the size of a change."""
    moments = [inertia[i][i] for i in range(3)]
    if any(inertia[i][j] != 0 for i in range(3) for j in range(i)):
        for i, j in combinations_with_replacement(range(3), 2):
            words = f"the element {'xyz'[i]}{'xyz'[j]} of inertia = {{}} (the scene's is {{own}})"
            yield words, [(i, j)], inertia[i][j], moments[i] if i == j else max(moments)
        return
    equal = [i for i in range(3) if moments.count(moments[i]) > 1]
    for axes in [[0], [1], [2], *([equal] if equal else [])]:
        letters = " = ".join("ABC"[i] for i in axes)
        noun, verb = ("moment", "is") if len(axes) == 1 else ("moments", "are")
        words = f"the {noun} {letters} = {{}} (the scene's {verb} {{own}})"
        yield words, [(i, i) for i in axes], moments[axes[0]], moments[axes[0]]


def _number(
    words: str, scene_of: Callable[[Fraction], Scene], own: Exact, unit: float
) -> Hypothesis:
    """That a number of the scene is ``own + unit * x``."""
    origin = to_double(own)
    words = words.replace("{own}", f"{origin:.6g}")
    return Hypothesis(
        words, motion=lambda x: (scene_of(x), AS_THEY_STAND), fitted=1, origin=origin, unit=unit
    )


def _with_elements(scene: Scene, elements: Sequence[tuple[int, int, Exact]], x: Fraction) -> Scene:
    """The scene with elements of inertia, on both sides of the diagonal, that are x units larger;
    raises UnphysicalBody."""
    inertia = [*scene.body.inertia]
    for i, j, unit in elements:
        for row, column in {(i, j), (j, i)}:
            inertia[row] = _moved(inertia[row], column, x * unit)
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


def other_start(subject: TrajectoryTable, scene: Scene) -> str:
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


def _start_of(subject: TrajectoryTable) -> Mapping[str, float]:
    """The numbers of the state at t = 0, as far as they are there; gamma also of a quaternion."""
    if 0 not in subject.times:
        return {}
    row = {
        name: to_double(exactly(x))
        for name in (*subject.state, *ATTITUDE)
        if name in subject.columns
        and (x := subject.columns[name][subject.times.index(0)]) is not None
    }
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
