"""Conventions of one part of a table, each with the digits that the part has in it.

Doubles are enough: a convention is right or it is wrong in the first digit.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from polhode.judging.diagnosis.rotation_matrices import (
    AXES,
    SAME,
    TURNED,
    in_words,
    matrices,
    nearest_renaming,
    quaternion,
    turns,
)
from polhode.judging.tables.reading import Change
from polhode.numbers.rows import Doubles
from polhode.scenes.vocabulary import STATE

LEAST_ROWS = 3  # fewer do not tell other axes from a wrong number
_TELLABLE = 15.0  # digits
_DEGREE = math.pi / 180
#: Units of angles by the degrees in them; 0 for radians.
_UNITS = ((0, ""), (1, "degrees"), (6, "rpm"), (360, "revolutions"))
_SEQUENCES = [s for s in itertools.product("xyz", repeat=3) if s[0] != s[1] != s[2]]
_ORDERS = (((0, 1, 2, 3), ""), ((3, 0, 1, 2), "scalar-last"), ((1, 2, 3, 0), "q1 the scalar"))


class Right(NamedTuple):
    """What the reference has at the rows' times."""

    states: Doubles
    attitude: Doubles | None = None  # None where not known
    matrices: Doubles | None = None  # body -> space, likewise


class Way(NamedTuple):
    """A convention, the digits that it gives, and the change that applies it, if one does."""

    words: str
    digits: float
    change: Change | None = None


def ways(part: str, values: Doubles, right: Right) -> Iterator[Way]:
    """Conventions of a part and the digits that each gives; as it stands first."""
    if part == "omega":
        yield from _of_omega(values, right)
    elif part == "gamma":
        yield from _of_vector(STATE[3:], values, right.states[:, 3:], False)
    elif right.matrices is not None:
        yield from (_of_attitude if part == "attitude" else _of_angles)(values, right)


def as_it_stands(part: str, values: Doubles, right: Right) -> float | None:
    """Digits of a part in the scene's conventions; None where the reference has no such part."""
    first = next(ways(part, values, right), None)
    return None if first is None else first.digits


def _of_omega(values: Doubles, right: Right) -> Iterator[Way]:
    true = right.states[:, :3]
    yield from _of_vector(STATE[:3], values, true, True)
    for degrees, unit in _UNITS:
        factor = degrees * _DEGREE or 1.0
        if unit:
            yield from _of_vector(STATE[:3], values, true, True, degrees, unit)
        if right.matrices is not None:
            along = np.einsum("nij,nj->ni", right.matrices, true)
            for words, digits, _ in _of_vector(("x", "y", "z"), factor * values, along, True):
                yield Way(" ".join(filter(None, ("along the axes of space", words, unit))), digits)


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
    for order, signs in AXES:
        if order == SAME and len({*signs}) == 1:
            opposite = "of the other sense" if relative else "the downward vertical"
            words = "" if signs[0] > 0 else opposite
        elif len(values) < LEAST_ROWS:
            continue
        else:
            axes = [f"{'-' if s < 0 else ''}{names[k]}" for s, k in zip(signs, order, strict=True)]
            words = f"{' '.join(names)} = {' '.join(axes)}"
        change = Change(order, signs, degrees)
        digits = _against(held[:, order] * signs, true, relative)
        yield Way(" ".join(filter(None, (words, unit))), digits, change)


def _of_attitude(values: Doubles, right: Right) -> Iterator[Way]:
    steady = _is_steady(values)
    true = right.matrices
    yield Way("", _against(matrices(values), true) if steady else 0.0, Change())
    found: list[tuple[int, Way]] = []
    for order, place in _ORDERS:
        turned = matrices(values[:, order])
        for signs, sense in (((1, 1, 1, 1), ""), ((1, -1, -1, -1), "body from space")):
            held = turned if signs[1] > 0 else turned.transpose(0, 2, 1)
            for space, body, digits in _frames(held, true):
                frames = _told(space, body)
                words = ", ".join(filter(None, (place, sense, frames)))
                change = None
                if words and steady:
                    change = Change(order, signs, space=quaternion(space.T), body=quaternion(body))
                    change = _of_same_sign(change, values[0], right)
                way = Way(words or "of either sign at each time", digits, change)
                found.append((frames.count("="), way))
    yield from _plain_first(found)


def _plain_first(found: list[tuple[int, Way]]) -> Iterator[Way]:
    """Ways by the frames that they rename: a change of scalar or sense may be one of frames."""
    return (way for _, way in sorted(found, key=lambda one: one[0]))


def _of_same_sign(change: Change, first: Doubles, right: Right) -> Change:
    """A change after which the first row's quaternion has the reference's sign."""
    if change.space == change.body == (1, 0, 0, 0) or right.attitude is None:
        return change
    row = [float(x) for x in change.row([float(x) for x in first]) if x is not None]
    if float(np.dot(row, right.attitude[0])) >= 0:
        return change
    return change._replace(signs=tuple(-s for s in change.signs))


def _frames(held: Doubles, true: Any) -> Iterator[tuple[Doubles, Doubles, float]]:
    """Frames of space U and of the body B in which held = U R Bᵀ, nearly in the first row.

    Two left-handed frames turn a matrix as two right-handed ones do, their opposites.
    """
    for body in TURNED if len(held) >= LEAST_ROWS else TURNED[:1]:
        space = nearest_renaming(held[0] @ body @ true[0].T)
        same = space is not None and np.array_equal(space, np.eye(3))
        if space is not None and (same or len(held) >= LEAST_ROWS):
            yield space, body, _against(space.T @ held @ body, true)


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


def _is_steady(values: Doubles) -> bool:
    """Whether a quaternion's sign does not change between samples."""
    return bool(np.all(np.einsum("ni,ni->n", values[1:], values[:-1]) >= 0))


def _of_angles(values: Doubles, right: Right) -> Iterator[Way]:
    true = right.matrices
    yield Way("", _against(turns("zxz", values), true), Change())
    held = turns("zxz", _DEGREE * values)
    yield Way("in degrees", _against(held, true), Change(SAME, (1, 1, 1), 1))
    found: list[tuple[int, Way]] = []
    for sequence in _SEQUENCES:
        for factor, unit in ((1.0, ""), (_DEGREE, "in degrees")):
            turned = turns("".join(sequence), factor * values)
            name = f"turns about {'-'.join(sequence)}"
            for held, sense in ((turned, ""), (turned.transpose(0, 2, 1), "body from space")):
                words = " ".join(filter(None, (name, unit, sense)))
                for space, body, digits in _frames(held, true):
                    frames = _told(space, body)
                    way = Way(", ".join(filter(None, (words, frames))), digits)
                    found.append((frames.count("="), way))
    yield from _plain_first(found)


def _against(values: Any, true: Any, relative: bool = False) -> float:
    """Digits to which arrays agree, the fewest; ``relative``: to the largest vector."""
    scale = float(np.max(np.linalg.norm(true, axis=1))) if relative else 1.0
    error = float(np.max(np.abs(values - true))) / (scale or 1.0)
    return _TELLABLE if error == 0 else min(_TELLABLE, max(0.0, -math.log10(error)))
