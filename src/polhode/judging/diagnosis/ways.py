"""Conventions of one part of a table, each with the digits that the part has in it.

Doubles are enough: a convention is right or it is wrong in the first digit.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from polhode.judging.diagnosis.rotation_matrices import (
    AXES,
    SAME,
    TURNED,
    in_words,
    matrices,
    nearest_renaming,
    quaternion,
    rotation_in_words,
    turns,
)
from polhode.judging.tables.reading import TURN, Change
from polhode.numbers.rows import Doubles
from polhode.scenes.vocabulary import STATE

LEAST_ROWS = 3  # fewer do not tell other axes from a wrong number
_TELLABLE = 15.0  # digits
_DEGREE = math.pi / 180
#: Units of angles by the degrees in them; 0 for radians.
_UNITS = ((0, ""), (1, "degrees"), (6, "rpm"), (360, "revolutions"))
_SEQUENCES = [s for s in itertools.product("xyz", repeat=3) if s[0] != s[1] != s[2]]
SCALAR_FIRST = "q1 the scalar"  # which a scene's start that was typed scalar-last looks like, too
_ORDERS = (((0, 1, 2, 3), ""), ((3, 0, 1, 2), "scalar-last"), ((1, 2, 3, 0), SCALAR_FIRST))


_ORDERS_OF_AXES = np.array([order for order, _ in AXES])
_SIGNS_OF_AXES = np.array([signs for _, signs in AXES])
#: Numbers of a part that are free of each other.
FREEDOM = {"omega": 3, "gamma": 2, "attitude": 3, "angles": 3}
#: Conventions in which a start of numbers that are not round is one: the same one in other words.
ALIKE_AT_START = {"omega": 3, "gamma": 3, "attitude": 6, "angles": 12}


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
        return _errors(values, values[0]) / _size(values, part == "omega")


class Way(NamedTuple):
    """A convention, the digits that it gives at each row, and the change that applies it, if any.

    ``tries``: how many conventions are as plain, of which one may be right by chance.
    ``fitted``: whether the first row decides what is changed, so that it is right there.
    ``renamed``: how many frames it renames; the plainer ones come first.
    """

    words: str
    rows: Doubles  # the earliest first
    change: Change | None = None
    tries: int = 1
    fitted: bool = False
    renamed: int = 0

    @property
    def digits(self) -> float:
        """The fewest digits of a row."""
        return float(np.min(self.rows))

    @property
    def is_unit_alone(self) -> bool:
        """Whether it changes the unit and no axes: a factor that no start has by chance."""
        change = self.change
        return change is not None and change == Change(SAME, (1, 1, 1), change.degrees)


def ways(part: str, values: Doubles, right: Right) -> Iterator[Way]:
    """Conventions of a part and the digits that each gives; as it stands first."""
    if part == "omega":
        yield from _of_omega(values, right)
    elif part == "gamma":
        yield from _of_vector(STATE[3:], values, right.states[:, 3:], False)
    elif right.matrices is not None:
        yield from (_of_attitude if part == "attitude" else _of_angles)(values, right)


def _of_omega(values: Doubles, right: Right) -> Iterator[Way]:
    true = right.states[:, :3]
    yield from _of_vector(STATE[:3], values, true, True)
    for degrees, unit in _UNITS:
        factor = degrees * _DEGREE or 1.0
        if unit:
            yield from _of_vector(STATE[:3], values, true, True, degrees, unit)
        if right.matrices is not None:
            along = np.einsum("nij,nj->ni", right.matrices, true)
            for way in _of_vector(("x", "y", "z"), factor * values, along, True):
                words = filter(None, ("along the axes of space", way.words, unit))
                yield Way(" ".join(words), way.rows, tries=way.tries)


def _of_vector(
    names: tuple[str, ...],
    values: Doubles,
    true: Doubles,
    relative: bool,
    degrees: int = 0,
    unit: str = "",
) -> Iterator[Way]:
    """Axes in another order or of another sense, left-handed frames among them."""
    held = values * (degrees * _DEGREE or 1.0)
    renamed = held[:, _ORDERS_OF_AXES] * _SIGNS_OF_AXES
    off = np.abs(renamed - true[:, None, :]).max(axis=2) / _size(true, relative)
    digits = _digits(off)
    for k, (order, signs) in enumerate(AXES):
        plain = order == SAME and len({*signs}) == 1
        if plain:
            opposite = "of the other sense" if relative else "the downward vertical"
            words = "" if signs[0] > 0 else opposite
        elif len(values) < LEAST_ROWS:
            continue
        else:
            axes = [f"{'-' if s < 0 else ''}{names[i]}" for s, i in zip(signs, order, strict=True)]
            words = f"{' '.join(names)} = {' '.join(axes)}"
        change = Change(order, signs, degrees)
        tries = (2 if plain else len(AXES)) * (len(_UNITS) if relative else 1)
        yield Way(" ".join(filter(None, (words, unit))), digits[:, k], change, tries)


def _of_attitude(values: Doubles, right: Right) -> Iterator[Way]:
    true = right.matrices
    yield Way("", _against(matrices(values), true), Change())
    forms: list[_Form] = []
    for order, place in _ORDERS:
        turned = matrices(values[:, order])
        back = ", ".join(filter(None, (place, "body from space")))
        forms.append((place, turned, Change(order, (1, 1, 1, 1))))
        forms.append((back, turned.transpose(0, 2, 1), Change(order, (1, -1, -1, -1))))
    yield from _in_frames(forms, true)


#: A way to read a part as rotations: in words, the matrices, and the change that it is; None of one
#: that is told and not applied.
_Form: TypeAlias = tuple[str, Doubles, Change | None]


def _in_frames(forms: Sequence[_Form], true: Any) -> list[Way]:
    """Rotations in all frames, by those that they rename: a change of scalar or sense may be one of
    frames."""
    found = []
    for form, held, change in forms:
        for frames in _frames(held, true):
            words = ", ".join(filter(None, (form, frames.words)))
            tries = len(forms) * frames.tries
            whole = None
            if change is not None and not frames.is_fitted:
                space, body = quaternion(frames.space.T), quaternion(frames.body)
                whole = change._replace(space=space, body=body)
            way = Way(words, frames.rows, whole, tries, frames.is_fitted, frames.renamed)
            found += [way] if words else []
    return sorted(found, key=lambda way: way.renamed)


class _Frames(NamedTuple):
    """Frames of space U and of the body B in which a matrix is U R Bᵀ, and its digits then."""

    space: Doubles
    body: Doubles
    rows: Doubles
    is_fitted: bool = False

    @property
    def words(self) -> str:
        """What the frames are called."""
        if not self.is_fitted:
            return _told(self.space, self.body)
        if np.array_equal(self.body, np.eye(3)):
            return f"{TURN}{rotation_in_words(self.space.T)} in space axes"
        return f"{TURN}{rotation_in_words(self.body)} in body axes"

    @property
    def tries(self) -> int:
        """How many frames are as plain."""
        if self.is_fitted:
            return 2
        return len(TURNED) ** 2 if self.words else 1

    @property
    def renamed(self) -> int:
        """How many frames are renamed; a turned one is less plain."""
        return 3 if self.is_fitted else self.words.count("=")


def _frames(held: Doubles, true: Any) -> Iterator[_Frames]:
    """Frames in which matrices are the true ones, nearly in the first row.

    Axes may have other names, or the first row tells by which rotation all differ.  Two left-handed
    frames turn a matrix as two right-handed ones do, their opposites.
    """
    few, same = len(held) < LEAST_ROWS, np.eye(3)
    for body in TURNED[:1] if few else TURNED:
        space = nearest_renaming(held[0] @ body @ true[0].T)
        if space is not None and (np.array_equal(space, same) or not few):
            yield _Frames(space, body, _against(space.T @ held @ body, true))
    if few or not np.all(np.isfinite(held[0])):
        return
    space, body = held[0] @ true[0].T, held[0].T @ true[0]
    yield _Frames(space, same, _against(space.T @ held, true), True)
    yield _Frames(same, body, _against(held @ body, true), True)


def _told(space: Doubles, body: Doubles) -> str:
    """What frames are called; a world by its vertical where the body's axes are the scene's."""
    words = []
    if in_words(space):
        up = int(np.argmax(np.abs(space[:, 2])))
        vertical = f"{'xyz'[up]} {'up' if space[up, 2] > 0 else 'down'}, "
        words.append(f"{vertical}space {in_words(space)}")
    if in_words(body):
        words.append(f"body {in_words(body)}")
    return ", ".join(words)


def _of_angles(values: Doubles, right: Right) -> Iterator[Way]:
    true = right.matrices
    yield Way("", _against(turns("zxz", values), true), Change())
    held = turns("zxz", _DEGREE * values)
    yield Way("in degrees", _against(held, true), Change(SAME, (1, 1, 1), 1))
    forms: list[_Form] = []
    for sequence in _SEQUENCES:
        for factor, unit in ((1.0, ""), (_DEGREE, " in degrees")):
            turned = turns("".join(sequence), factor * values)
            name = f"turns about {'-'.join(sequence)}{unit}"
            forms.append((name, turned, None))
            forms.append((f"{name} body from space", turned.transpose(0, 2, 1), None))
    yield from _in_frames(forms, true)


def _against(values: Any, true: Any) -> Doubles:
    """Digits to which matrices agree at each row."""
    return _digits(_errors(values, true))


def _digits(error: Doubles) -> Doubles:
    with np.errstate(divide="ignore", invalid="ignore"):
        digits = np.nan_to_num(-np.log10(error), nan=0.0, posinf=_TELLABLE)
    found: Doubles = np.clip(digits, 0.0, _TELLABLE)
    return found


def _errors(values: Any, true: Any) -> Doubles:
    """The largest difference in each row."""
    found: Doubles = np.abs(values - true).reshape(len(values), -1).max(axis=1)
    return found


def _size(true: Any, relative: bool) -> float:
    """What errors are told in."""
    return (float(np.max(np.linalg.norm(true, axis=1))) if relative else 1.0) or 1.0
