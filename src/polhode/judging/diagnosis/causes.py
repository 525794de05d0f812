"""Why a table leaves the motion: another constant of the body, another start, another clock.

One number at a time (of a symmetric body its equal moments, too, as one) is fitted to the table, by
Gauss's and Newton's method on the motion integrated in double, over rows from the first ones on, so
that a motion that turns many times is not lost.
Where one number makes the table right to three digits more, it is told, with the digits that it is
fitted to.  Nothing is changed: it may be the program's mistake, or the scene's.

A rough method is late or early as a slow clock is, or as a body of other moments: so what differs
by less than ``LEAST`` is not told.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import combinations_with_replacement
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.common.errors import BadInput
from polhode.common.text_tables import few
from polhode.judging.diagnosis.motion_in_double import integrated
from polhode.judging.tables.reading import GAIN, WRONG
from polhode.judging.tables.table import Table
from polhode.numbers.conversion import doubles, to_double
from polhode.numbers.exact import Exact
from polhode.numbers.rows import Doubles
from polhode.numbers.vectors import Vector
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import STATE

LEAST = 1e-5  # of a number: below it a method's error may look like it
_CLOCK = 1e-4  # likewise of a clock's pace
_ROWS = 40
_FIRST = 6  # rows that are fitted first; then twice as many, and so on
_STEPS, _HALVINGS = 8, 5  # of Gauss and Newton; of a step that leads nowhere
_SMALL = 1e-6  # a change that a derivative is taken by
_ENOUGH = 1e-13
_FARTHEST = 3e3  # radians or so
_ALIKE = 1.0  # digits: causes that explain as much
_TOLD = 3  # causes at most

#: States at the rows' times where the number is so much larger; None where there are none.
Model: TypeAlias = "Callable[[float, Sequence[Fraction]], Doubles | None]"


class Cause(NamedTuple):
    """A number that makes a table right, in words, and the fewest digits of the table then."""

    words: str
    digits: float

    def __str__(self) -> str:
        return f"explained by {self.words}, which gives {self.digits:.1f} digits"


class _Candidate(NamedTuple):
    """A number that may be another, ``origin`` and ``unit`` times a change; its ``least`` one."""

    words: str
    model: Model
    origin: float
    unit: float
    least: float = 0.0


def causes(subject: Table, scene: Scene) -> tuple[Cause, ...]:
    """What explains a table of states that is wrong, the best first; empty where nothing does."""
    some = subject.some(sorted(few(len(subject.times), _ROWS), key=lambda k: abs(subject.times[k])))
    times, cells = [*some.times], some.rows(some.state)
    columns = [k for k, name in enumerate(scene.columns) if name in some.state]
    speed = max([1e-300, *(abs(to_double(x)) for x in scene.start[:3])])
    if cells is None or abs(to_double(times[-1])) * speed > _FARTHEST:
        return ()
    if any(x is None for row in cells for x in row):
        return ()
    fit = Fit(doubles(cells), times, columns, scene)
    found = [cause for one in _candidates(scene, columns) if (cause := fit.cause(one)) is not None]
    found.sort(key=lambda one: -one.digits)
    return tuple(one for one in found if one.digits >= found[0].digits - _ALIKE)[:_TOLD]


class Fit:
    """A table that numbers are fitted to."""

    def __init__(
        self, table: Doubles, times: list[Fraction], columns: list[int], scene: Scene
    ) -> None:
        self.table, self.times, self.columns = table, times, columns
        plain = integrated(scene, times, attitude=False)
        self.scale = np.ones(len(columns))
        self.before = math.inf
        if plain is not None:
            rates = float(np.max(np.linalg.norm(plain.states[:, :3], axis=1))) or 1.0
            self.scale = np.array([rates if c < 3 else 1.0 for c in columns])
            self.before = self._digits((plain.states[:, columns] - table) / self.scale)

    @staticmethod
    def _digits(error: Doubles) -> float:
        worst = float(np.max(np.abs(error)))
        return -math.log10(worst) if worst > 0 else 16.0

    def _error(self, model: Model, x: float, count: int) -> Doubles | None:
        """The scaled difference from the first rows, in one column; None if too large."""
        states = model(x, self.times[:count])
        if states is None:
            return None
        with np.errstate(over="ignore", invalid="ignore"):
            found: Doubles = ((states[:, self.columns] - self.table[:count]) / self.scale).ravel()
        return found if np.all(np.isfinite(found)) else None

    def cause(self, one: _Candidate) -> Cause | None:
        """The number, fitted, where it explains the table."""
        x, slope, count = 0.0, 0.0, min(_FIRST, len(self.times))
        while True:
            found = self.fitted(one.model, x, count)
            if found is None:
                return None
            x, slope, error = found
            if self._digits(error) < WRONG:  # of the first rows, which any cause makes right
                return None
            if count == len(self.times):
                break
            count = min(2 * count, len(self.times))
        digits, least = self._digits(error), max(LEAST, one.least)
        if digits < max(WRONG, self.before + GAIN) or abs(x) < least or not slope:
            return None
        value = one.origin + one.unit * x
        sure = 10.0**-digits / slope * abs(one.unit) / max(abs(value), 1e-300)
        places = max(1, min(15, math.floor(-math.log10(sure)) if sure > 0 else 15))
        words = one.words.format(f"{value:.{places}g}").replace("+ -", "- ")
        return Cause(words, min(digits, 15.0))

    def fitted(self, model: Model, x: float, count: int) -> tuple[float, float, Doubles] | None:
        """The number for the first rows, the largest change by it, and what is left."""
        error = self._error(model, x, count)
        if error is None:
            return None
        largest = 0.0
        for _ in range(_STEPS):
            moved = self._error(model, x + _SMALL, count)
            if moved is None:
                return None
            slope = (moved - error) / _SMALL
            largest = float(np.max(np.abs(slope)))
            square = float(slope @ slope)
            if not square > 0:
                return None
            step = -float(slope @ error) / square
            for _ in range(_HALVINGS):
                nearer = self._error(model, x + step, count)
                if nearer is not None and nearer @ nearer < error @ error:
                    break
                step /= 2
            else:
                break
            x, error = x + step, nearer
            if abs(step) < _ENOUGH:
                break
        return x, largest, error


def _candidates(scene: Scene, columns: Sequence[int]) -> Iterator[_Candidate]:
    """Numbers that may be others, the plainer first."""
    yield from _of_clock(scene, columns)
    body = scene.body
    if all(body.inertia[i][j] == 0 for i in range(3) for j in range(i)):
        for i, letter in enumerate("ABC"):
            own = to_double(body.inertia[i][i])
            words = f"the moment {letter} = {{}} (the scene's is {own:.6g})"
            yield _Candidate(words, partial(_of_body, scene, [(i, i)], None), own, own)
        if equal := _equal_moments(body):
            own = to_double(body.inertia[equal[0]][equal[0]])
            letters = " = ".join("ABC"[i] for i in equal)
            words = f"the moments {letters} = {{}} (the scene's are {own:.6g})"
            yield _Candidate(
                words, partial(_of_body, scene, [(i, i) for i in equal], None), own, own
            )
    else:
        for i, j in combinations_with_replacement(range(3), 2):
            own, unit = to_double(body.inertia[i][j]), to_double(_unit(body, i, j))
            words = f"the element {'xyz'[i]}{'xyz'[j]} of inertia = {{}} (the scene's is {own:.6g})"
            yield _Candidate(words, partial(_of_body, scene, [(i, j)], None), own, unit)
    if scene.columns[3:] and body.weight:
        own = to_double(body.weight)
        words = f"a weight, or a distance of the centre, of {{}} times the scene's {own:.6g}"
        yield _Candidate(words, partial(_of_body, scene, [], None), 1.0, 1.0)
        size = to_double(max(map(abs, body.centre)))
        for i, axis in enumerate("xyz"):
            own = to_double(body.centre[i])
            words = f"the centre's {axis} = {{}} (the scene's is {own:.6g})"
            yield _Candidate(words, partial(_of_body, scene, [], i), own, size)
    rate = max([to_double(abs(w)) for w in scene.omega]) or 1.0
    for i, name in enumerate(STATE[:3]):
        own = to_double(scene.omega[i])
        words = f"{name} = {{}} at t = 0 (the scene's is {own:.6g})"
        yield _Candidate(words, partial(_of_start, scene, i, rate), own, rate)


def _equal_moments(body: Body) -> tuple[int, ...]:
    """The axes of moments that are equal, empty where all differ."""
    own = [body.inertia[i][i] for i in range(3)]
    return tuple(i for i in range(3) if own.count(own[i]) > 1)


def _unit(body: Body, i: int, j: int) -> Exact:
    """What an element of inertia is changed in: itself, or the largest moment beside others."""
    return body.inertia[i][i] if i == j else max(body.inertia[k][k] for k in range(3))


def _of_clock(scene: Scene, columns: Sequence[int]) -> Iterator[_Candidate]:
    """Times that begin elsewhere, for all columns or for omega alone; a clock of another pace."""
    unit = 2.0**scene.time_unit
    parts = {"omega": slice(0, 3), "gamma": slice(3, 6)}
    words = "rows that belong to t + {}"
    yield _Candidate(words, partial(_later, scene, unit, slice(0, 6)), 0.0, unit)
    if any(c < 3 for c in columns) and any(c >= 3 for c in columns):
        for name, part in parts.items():
            words = f"{name} that belongs to t + {{}}, and all else to t"
            yield _Candidate(words, partial(_later, scene, unit, part), 0.0, unit)
    yield _Candidate("a clock of {} times the pace", partial(_faster, scene), 1.0, 1.0, _CLOCK)


def _later(
    scene: Scene, unit: float, part: slice, x: float, times: Sequence[Fraction]
) -> Doubles | None:
    """The motion, a part of its columns at times that are later by a change."""
    later = integrated(scene, [t + Fraction(x * unit) for t in times], attitude=False)
    plain = integrated(scene, times, attitude=False)
    if later is None or plain is None:
        return None
    found: Doubles = plain.states.copy()
    found[:, part] = later.states[:, part]
    return found


def _faster(scene: Scene, x: float, times: Sequence[Fraction]) -> Doubles | None:
    found = integrated(scene, [t * (1 + Fraction(x)) for t in times], attitude=False)
    return None if found is None else found.states


def _of_body(
    scene: Scene,
    elements: Sequence[tuple[int, int]],
    centre: int | None,
    x: float,
    times: Sequence[Fraction],
) -> Doubles | None:
    """The motion of a body with other inertia, or component of the centre; neither: weight."""
    body, by = scene.body, Fraction(x)
    weight = body.weight if centre is not None or elements else body.weight * (1 + by)
    inertia = [*body.inertia]
    for i, j in elements:
        for row, column in {(i, j), (j, i)}:
            inertia[row] = _moved(inertia[row], column, by * _unit(body, i, j))
    a, b, c = inertia
    middle = _moved(body.centre, centre, by * max(map(abs, body.centre)))
    try:
        other = Body((a, b, c), middle, weight)
    except (BadInput, ValueError):  # moments of no body
        return None
    found = integrated(replace(scene, body=other), times, attitude=False)
    return None if found is None else found.states


def _of_start(
    scene: Scene, place: int, rate: float, x: float, times: Sequence[Fraction]
) -> Doubles | None:
    other = replace(scene, omega=_moved(scene.omega, place, Fraction(rate * x)))
    found = integrated(other, times, attitude=False)
    return None if found is None else found.states


def _moved(vector: Vector, place: int | None, by: Exact) -> Vector:
    """A vector with one component, if any, so much larger."""
    a, b, c = (x + by if k == place else x for k, x in enumerate(vector))
    return a, b, c
