"""What may be wrong with a table's motion: another start, another number, other equations."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import combinations_with_replacement
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.common.errors import few
from polhode.judging.tables.double_motion import integrated, matrices
from polhode.judging.tables.table import GAIN, WRONG, Table, TimeChange
from polhode.motion.frame import Frame
from polhode.numbers.conversion import doubles, exactly, to_double
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import Doubles
from polhode.numbers.vectors import Vector
from polhode.scenes import library
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE, STATE

# --- other start ----------------------------------------------------------------------------------
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


# --- causes ---------------------------------------------------------------------------------------
#
# Why a table leaves the motion: another constant of the body, another start, another clock.
#
# One number at a time (of a symmetric body its equal moments, too, as one) is fitted to the
# table, by Gauss's and Newton's method on the motion integrated in double, over rows from the
# first ones on, so that a motion that turns many times is not lost. Where one number makes the
# table right to three digits more, it is told, with the digits that it is fitted to. Nothing is
# changed: it may be the program's mistake, or the scene's.
#
# A rough method is late or early as a slow clock is, or as a body of other moments: so what
# differs by less than ``LEAST`` is not told; of a clock's pace, which a crystal holds to some
# 1e-5, less if the table is then right to more digits than such a method's is.


LEAST = 1e-5  # of a number: below it a method's error may look like it
_CLOCK, _CLOCK_IF_SURE, _SURE = 1e-4, 1e-7, 9.0  # of a clock's pace, and digits of a sure one
_SLOWEST = 0.1  # pace of a clock
_ROWS = 40
_FIRST = 6  # rows that are fitted first; then twice as many, and so on
_STEPS, _HALVINGS = 8, 5  # of Gauss and Newton; of a step that leads nowhere
_SMALL = 1e-6  # a change that a derivative is taken by
_LEADS = 0.5  # of the square of what is left of the first rows, at least, is along the change
_FARTHEST = 3e3  # radians or so
_ALIKE = 1.0  # digits: causes that explain as much
_TOLD = 3  # causes at most

CONSTANT = "omega that stays as it is at t = 0, without the terms omega x I omega and of the torque"

#: The scene where the number is so much larger, and its times; raises ValueError for no body.
Change: TypeAlias = Callable[[Fraction], tuple[Scene, TimeChange]]


class Cause(NamedTuple):
    """A number that makes a table right, in words, and the fewest digits of the table then."""

    words: str
    digits: float

    def __str__(self) -> str:
        return f"explained by {self.words}, which gives {self.digits:.1f} digits"


class _Candidate(NamedTuple):
    """A number that may be another, ``origin`` and ``unit`` times a change.

    ``least``: the least change that is told; ``least_if_sure``: of a table that it makes right.
    ``smallest``: the smallest number that is told.
    """

    words: str
    change: Change
    origin: float
    unit: float
    least: float = LEAST
    least_if_sure: float = LEAST
    smallest: float = -math.inf


def causes(subject: Table, scene: Scene) -> tuple[Cause, ...]:
    """What explains a table of states that is wrong, the best first; empty where nothing does."""
    whole = subject.some(subject.whole_rows(subject.state))
    chosen = few(len(whole.times), _ROWS)
    some = whole.some(sorted(chosen, key=lambda k: abs(whole.times[k])))
    times, cells = [*some.times], some.rows(some.state)
    columns = [k for k, name in enumerate(scene.columns) if name in some.state]
    speed = max([1e-300, *(abs(to_double(x)) for x in scene.start[:3])])
    if not cells or abs(to_double(times[-1])) * speed > _FARTHEST:
        return ()
    fit = Fit(doubles(cells), times, columns, scene)
    if (still := fit.constant()) is not None:
        return (still,)
    explanations = [
        cause for number in _candidates(scene) if (cause := fit.cause(number)) is not None
    ]
    explanations.sort(key=lambda cause: -cause.digits)
    least = explanations[0].digits - _ALIKE if explanations else 0.0
    return tuple(cause for cause in explanations if cause.digits >= least)[:_TOLD]


class Fit:
    """A table that numbers are fitted to."""

    def __init__(
        self, table: Doubles, times: list[Fraction], columns: list[int], scene: Scene
    ) -> None:
        self.table, self.times, self.columns, self.scene = table, times, columns, scene
        plain = integrated(scene, times, attitude=False)
        self.plain = None if plain is None else plain.states
        self.scale = np.ones(len(columns))
        self.before = math.inf
        if self.plain is not None:
            rates = float(np.max(np.linalg.norm(self.plain[:, :3], axis=1))) or 1.0
            self.scale = np.array([rates if c < 3 else 1.0 for c in columns])
            self.before = self._digits((self.plain[:, columns] - table) / self.scale)

    @staticmethod
    def _digits(error: Doubles) -> float:
        worst = float(np.max(np.abs(error)))
        return -math.log10(worst) if worst > 0 else 16.0

    def _error(self, candidate: _Candidate, x: float, count: int) -> Doubles | None:
        """The scaled difference from the first rows, in one column; None if too large."""
        try:
            scene, moved = candidate.change(Fraction(x))
        except ValueError:  # moments of no body
            return None
        motion = integrated(scene, [moved.of(t) for t in self.times[:count]], attitude=False)
        if motion is None:
            return None
        with np.errstate(over="ignore", invalid="ignore"):
            off = motion.states[:, self.columns] - self.table[:count]
            error: Doubles = (off / self.scale).ravel()
            return error if math.isfinite(error @ error) else None

    def constant(self) -> Cause | None:
        """That omega stays as it is at t = 0, where that makes the table right.

        It does so of a body of equal moments without weight.
        """
        if self.plain is None or not {*self.columns} & {0, 1, 2}:
            return None
        unit, none = Fraction(1), Fraction(0)
        sphere = Body(
            ((unit, none, none), (none, unit, none), (none, none, unit)), (none,) * 3, none
        )
        free = integrated(replace(self.scene, body=sphere), self.times, attitude=False)
        if free is None:
            return None
        digits = self._digits((free.states[:, self.columns] - self.table) / self.scale)
        if digits < max(WRONG, self.before + GAIN):
            return None
        return Cause(CONSTANT, min(digits, 15.0))

    def cause(self, candidate: _Candidate) -> Cause | None:
        """The number, fitted, where it explains the table."""
        x, slope, count = 0.0, 0.0, min(_FIRST, len(self.times))
        while True:
            fit = self.fitted(candidate, x, count)
            if fit is None:
                return None
            x, slope, error = fit
            if self._digits(error) < WRONG:  # of the first rows, which any cause makes right
                return None
            if count == len(self.times):
                break
            count = min(2 * count, len(self.times))
        digits = self._digits(error)
        least = candidate.least_if_sure if digits >= _SURE else candidate.least
        value = candidate.origin + candidate.unit * x
        if digits < max(WRONG, self.before + GAIN) or abs(x) < least or not slope:
            return None
        if value < candidate.smallest:
            return None
        sure = 10.0**-digits / slope * abs(candidate.unit) / max(abs(value), 1e-300)
        places = max(1, min(15, math.floor(-math.log10(sure)) if sure > 0 else 15))
        words = candidate.words.format(f"{value:.{places}g}").replace("+ -", "- ")
        return Cause(words, min(digits, 15.0))

    def fitted(
        self, candidate: _Candidate, x: float, count: int
    ) -> tuple[float, float, Doubles] | None:
        """The number for the first rows, the largest change by it, and what is left.

        The change by the number is that over the last step, as long as that is no small one.
        """
        error, moved = self._error(candidate, x, count), self._error(candidate, x + _SMALL, count)
        if error is None or moved is None:
            return None
        slope, leads = (moved - error) / _SMALL, _LEADS if count < len(self.times) else 0.0
        for _ in range(_STEPS):
            along, square = float(slope @ error), float(slope @ slope)
            if not square > 0:
                return None
            if along * along < leads * square * float(error @ error):
                break
            step = -along / square
            for _ in range(_HALVINGS):
                nearer = self._error(candidate, x + step, count)
                if nearer is not None and nearer @ nearer < error @ error:
                    break
                step /= 2
            else:
                break
            if abs(step) > _SMALL:
                slope = (nearer - error) / step
            x, error = x + step, nearer
        return x, float(np.max(np.abs(slope))), error


def _candidates(scene: Scene) -> Iterator[_Candidate]:
    """Numbers that may be others, the plainer first."""
    yield from _of_clock(scene)
    yield from _of_body(scene)
    rate = max([to_double(abs(w)) for w in scene.omega]) or 1.0
    for i, name in enumerate(STATE[:3]):
        own = to_double(scene.omega[i])
        words = f"{name} = {{}} at t = 0 (the scene's is {own:.6g})"
        yield _Candidate(words, partial(_other_start, scene, i, rate), own, rate)


def _of_clock(scene: Scene) -> Iterator[_Candidate]:
    """Times that begin elsewhere; a clock of another pace."""
    unit = float(Frame.of(scene).unit)

    def later(x: Fraction) -> tuple[Scene, TimeChange]:
        return scene, TimeChange(shift=-Fraction(float(x) * unit))

    yield _Candidate("rows that belong to t + {}", later, 0.0, unit)
    words = "a clock of {} times the pace"
    yield _Candidate(
        words, lambda x: (scene, TimeChange(unit=1 + x)), 1.0, 1.0, _CLOCK, _CLOCK_IF_SURE, _SLOWEST
    )


def _of_body(scene: Scene) -> Iterator[_Candidate]:
    """Moments, or the elements of a full tensor; the weight; components of the centre."""
    body = scene.body
    moments = [body.inertia[i][i] for i in range(3)]
    if all(body.inertia[i][j] == 0 for i in range(3) for j in range(i)):
        equal = [i for i in range(3) if moments.count(moments[i]) > 1]
        for axes in [[0], [1], [2], *([equal] if equal else [])]:
            own = to_double(moments[axes[0]])
            letters = " = ".join("ABC"[i] for i in axes)
            noun, verb = ("moment", "is") if len(axes) == 1 else ("moments", "are")
            words = f"the {noun} {letters} = {{}} (the scene's {verb} {own:.6g})"
            elements = [(i, i) for i in axes]
            yield _Candidate(words, partial(_other_inertia, scene, elements), own, own)
    else:
        for i, j in combinations_with_replacement(range(3), 2):
            own, unit = to_double(body.inertia[i][j]), to_double(_unit(body, i, j))
            words = f"the element {'xyz'[i]}{'xyz'[j]} of inertia = {{}} (the scene's is {own:.6g})"
            yield _Candidate(words, partial(_other_inertia, scene, [(i, j)]), own, unit)
    if scene.columns[3:] and body.weight:
        own = to_double(body.weight)
        words = f"a weight, or a distance of the centre, of {{}} times the scene's {own:.6g}"
        yield _Candidate(words, partial(_other_weight, scene), 1.0, 1.0)
        for i, axis in enumerate("xyz"):
            own, size = to_double(body.centre[i]), to_double(max(map(abs, body.centre)))
            words = f"the centre's {axis} = {{}} (the scene's is {own:.6g})"
            yield _Candidate(words, partial(_other_centre, scene, i), own, size)


def _unit(body: Body, i: int, j: int) -> Exact:
    """What an element of inertia is changed in: itself, or the largest moment beside others."""
    return body.inertia[i][i] if i == j else max(body.inertia[k][k] for k in range(3))


def _other_inertia(
    scene: Scene, elements: Sequence[tuple[int, int]], x: Fraction
) -> tuple[Scene, TimeChange]:
    body = scene.body
    inertia = [*body.inertia]
    for i, j in elements:
        for row, column in {(i, j), (j, i)}:
            inertia[row] = _moved(inertia[row], column, x * _unit(body, i, j))
    a, b, c = inertia
    return replace(scene, body=body.replaced(inertia=(a, b, c))), TimeChange()


def _other_weight(scene: Scene, x: Fraction) -> tuple[Scene, TimeChange]:
    scene_of_weight = scene.body.replaced(weight=scene.body.weight * (1 + x))
    return replace(scene, body=scene_of_weight), TimeChange()


def _other_centre(scene: Scene, place: int, x: Fraction) -> tuple[Scene, TimeChange]:
    body = scene.body
    centre = _moved(body.centre, place, x * max(map(abs, body.centre)))
    return replace(scene, body=body.replaced(centre=centre)), TimeChange()


def _other_start(scene: Scene, place: int, rate: float, x: Fraction) -> tuple[Scene, TimeChange]:
    omega = _moved(scene.omega, place, Fraction(rate * float(x)))
    return replace(scene, omega=omega), TimeChange()


def _moved(vector: Vector, place: int, by: Exact) -> Vector:
    """A vector with one component so much larger."""
    a, b, c = (x + by if k == place else x for k, x in enumerate(vector))
    return a, b, c
