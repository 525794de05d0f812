"""Conventions of one part of a table, each with the digits that the part has in it.

Doubles are enough: a convention is right or it is wrong in the first digit.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Any, TypeAlias

import numpy as np

from polhode.judging.tables.hypotheses import (
    Evidence,
    Hypothesis,
    Right,
    errors_of_rows,
    matrices,
    size_of_motion,
)
from polhode.judging.tables.table import TURN, Change
from polhode.numbers.number_types import Doubles
from polhode.numbers.vectors import quaternion_products
from polhode.scenes.vocabulary import STATE

SAME = (0, 1, 2)
#: Orders and signs of three axes: all 48, the axes as they are first, few changes before many.
AXES = sorted(
    itertools.product(itertools.permutations(range(3)), itertools.product((1, -1), repeat=3)),
    key=lambda axes: (sum(a != b for a, b in zip(axes[0], SAME, strict=True)), axes[1].count(-1)),
)
NEAR = 0.1  # how near to 0 or ±1 the entries of a matrix that renames axes are at once


def turns(sequence: str, angles: Any) -> Doubles:
    """The product of turns about body axes, one after the other: R = R1(a1) R2(a2) R3(a3)."""
    product = np.broadcast_to(np.eye(3), (len(angles), 3, 3))
    for axis, angle in zip(sequence, angles.T, strict=True):
        i = "xyz".index(axis)
        j, k = (i + 1) % 3, (i + 2) % 3
        turn = np.zeros((len(angle), 3, 3))
        turn[:, i, i] = 1
        turn[:, j, j] = turn[:, k, k] = np.cos(angle)
        turn[:, k, j], turn[:, j, k] = np.sin(angle), -np.sin(angle)
        product = product @ turn
    return product


def renaming(order: Sequence[int], signs: Sequence[int]) -> Doubles:
    """The matrix that takes a vector v to the one with ``signs[k] v[order[k]]``."""
    matrix = np.zeros((3, 3))
    for k, (source, sign) in enumerate(zip(order, signs, strict=True)):
        matrix[k, source] = sign
    return matrix


def in_words(matrix: Doubles) -> str:
    """A renaming as ``x y z = x -z y``; empty where the axes stay."""
    order, signs = np.argmax(np.abs(matrix), axis=1), matrix.sum(axis=1)
    signed_axes = ["-" * bool(s < 0) + "xyz"[k] for s, k in zip(signs, order, strict=True)]
    return "" if signed_axes == ["x", "y", "z"] else f"x y z = {' '.join(signed_axes)}"


def _largest_product(matrix: Doubles) -> Doubles:
    """The quaternion of a rotation, of some length."""
    products = quaternion_products(matrix.ravel().tolist())
    k = max(range(4), key=lambda k: products[k][k])
    return np.array(products[k])


def rotation_in_words(matrix: Doubles) -> str:
    """A rotation as ``78.46° about (0.267, 0.535, 0.802)``, by 0 to 180 degrees."""
    q = _largest_product(matrix)
    scalar, axis = abs(float(q[0])), q[1:] * (-1 if q[0] < 0 else 1)
    sine = float(np.linalg.norm(axis))
    axis = (axis / (sine or 1.0)).round(3) + 0.0
    angle = math.degrees(2 * math.atan2(sine, scalar))
    return f"{angle:.4g}° about ({', '.join(f'{x:.3g}' for x in axis)})"


#: The 24 renamings that are turns, the axes as they are first.
TURNED = [m for m in (renaming(*axes) for axes in AXES) if np.linalg.det(m) > 0]


def quaternion(matrix: Doubles) -> tuple[int, ...]:
    """The quaternion of a renaming that is a turn, of some length, in small whole numbers."""
    q = _largest_product(matrix)
    return tuple(round(x) for x in q / np.min(np.abs(q[q != 0])))


# --- conventions ----------------------------------------------------------------------------------


LEAST_ROWS = 3  # fewer do not tell other axes from a wrong number
_TELLABLE = 15.0  # digits
_HUGE = 1e300  # a size that no motion's number has, and that stays a double in any unit
_DEGREE = math.pi / 180
#: Units of angles by the degrees in them; 0 for radians.
_UNITS = ((0, ""), (1, "degrees"), (6, "rpm"), (360, "revolutions"))
#: The scene's own first: of a motion in a plane others say the same in stranger words.
_SEQUENCES = sorted(
    ("".join(s) for s in itertools.product("xyz", repeat=3) if s[0] != s[1] != s[2]),
    key="zxz".__ne__,
)
SCALAR_FIRST = "q1 the scalar"  # which a scene's start that was typed scalar-last looks like, too
_ORDERS = (((0, 1, 2, 3), ""), ((3, 0, 1, 2), "scalar-last"), ((1, 2, 3, 0), SCALAR_FIRST))


_ORDERS_OF_AXES = np.array([order for order, _ in AXES])
_SIGNS_OF_AXES = np.array([signs for _, signs in AXES])
#: Numbers of a part that are free of each other.
FREEDOM = {"omega": 3, "gamma": 2, "attitude": 3, "angles": 3}
#: Conventions in which a start of numbers that are not round is one: the same one in other words.
ALIKE_AT_START = {"omega": 3, "gamma": 3, "attitude": 6, "angles": 12}
#: A convention, and the digits that it gives at each row.
_Way: TypeAlias = tuple[Hypothesis, Doubles]


def is_unit_alone(hypothesis: Hypothesis) -> bool:
    """Whether it changes the unit and no axes: a factor that no start has by chance."""
    change = hypothesis.change
    return change is not None and change == Change(SAME, (1, 1, 1), change.degrees)


def conventions(part: str, values: Doubles, right: Right) -> Iterator[Evidence]:
    """Conventions of a part and the digits that each gives; as it stands first."""
    values = np.clip(values, -_HUGE, _HUGE)
    if part == "omega":
        ways = _of_omega(values, right)
    elif part == "gamma":
        ways = _of_vector(STATE[3:], values, right.states[:, 3:], False)
    elif right.matrices is None:
        return
    else:
        ways = (_of_attitude if part == "attitude" else _of_angles)(values, right)
    for hypothesis, rows in ways:
        rows_fitted = 1 if hypothesis.fitted else 0
        yield Evidence(hypothesis, rows, rows_fitted, FREEDOM[part])


def _of_omega(values: Doubles, right: Right) -> Iterator[_Way]:
    true, attitude = right.states[:, :3], right.matrices
    for degrees, unit in _UNITS:
        yield from _of_vector(STATE[:3], values, true, True, degrees, unit)
        if attitude is not None:
            along = np.einsum("nij,nj->ni", attitude, true)
            for convention, digits in _of_vector("xyz", values, along, True, degrees):
                words = filter(None, ("along the axes of space", convention.words, unit))
                yield Hypothesis(" ".join(words), tries=convention.tries), digits


def _of_vector(
    names: Sequence[str],
    values: Doubles,
    true: Doubles,
    relative: bool,
    degrees: int = 0,
    unit: str = "",
) -> Iterator[_Way]:
    """Axes in another order or of another sense, left-handed frames among them."""
    scaled = values * (degrees * _DEGREE or 1.0)
    renamed = scaled[:, _ORDERS_OF_AXES] * _SIGNS_OF_AXES
    off = np.abs(renamed - true[:, None, :]).max(axis=2) / size_of_motion(true, relative)
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
        name = " ".join(filter(None, (words, unit)))
        yield Hypothesis(name, change, tries=tries), digits[:, k]


def _of_attitude(values: Doubles, right: Right) -> Iterator[_Way]:
    true = right.matrices
    yield Hypothesis(change=Change()), _against(matrices(values), true)
    forms: list[_Form] = []
    for order, place in _ORDERS:
        rotations = matrices(values[:, order])
        back = ", ".join(filter(None, (place, "body from space")))
        forms.append((place, rotations, Change(order, (1, 1, 1, 1))))
        forms.append((back, rotations.transpose(0, 2, 1), Change(order, (1, -1, -1, -1))))
    yield from _in_frames(forms, true)


#: A way to read a part as rotations: in words, the matrices, and the change that it is; None of one
#: that is told and not applied.
_Form: TypeAlias = tuple[str, Doubles, Change | None]


def _in_frames(forms: Sequence[_Form], true: Any) -> list[_Way]:
    """Rotations in all frames, by those that they rename: a change of scalar or sense may be one of
    frames."""
    ways: list[tuple[int, _Way]] = []
    for form, rotations, change in forms:
        for frames, rows in _frames(rotations, true, change):
            if words := ", ".join(filter(None, (form, frames.words))):
                renamed = frames.fitted or frames.words.count("=")
                hypothesis = frames._replace(words=words, tries=len(forms) * frames.tries)
                ways.append((renamed, (hypothesis, rows)))
    return [way for _, way in sorted(ways, key=lambda way: way[0])]


def _frames(rotations: Doubles, true: Any, change: Change | None) -> Iterator[_Way]:
    """Frames of space U and of the body B in which matrices R are the true ones as U R Bᵀ, nearly
    in the first row.

    Axes may have other names, or the first row tells by which rotation all differ.  Two left-handed
    frames turn a matrix as two right-handed ones do, their opposites.  ``change``: to R.
    """
    few, same = len(rotations) < LEAST_ROWS, np.eye(3)
    for body in TURNED[:1] if few else TURNED:
        matrix = rotations[0] @ body @ true[0].T
        space = np.round(matrix)
        is_near = np.max(np.abs(matrix - space)) < NEAR  # not so where one is not a number
        if not is_near or (few and not np.array_equal(space, same)):
            continue
        words, whole = _words_of(space, body), change
        if change is not None:
            whole = change._replace(space=quaternion(space.T), body=quaternion(body))
        tries = len(TURNED) ** 2 if words else 1
        yield Hypothesis(words, whole, tries=tries), _against(space.T @ rotations @ body, true)
    if few or not np.all(np.isfinite(rotations[0])):
        return
    space, body = rotations[0] @ true[0].T, rotations[0].T @ true[0]
    pairs = (("space", space.T, space.T @ rotations), ("body", body, rotations @ body))
    for axes, turn, turned_back in pairs:
        words = f"{TURN}{rotation_in_words(turn)} in {axes} axes"
        yield Hypothesis(words, tries=2, fitted=3), _against(turned_back, true)


def _words_of(space: Doubles, body: Doubles) -> str:
    """What frames are called; a world by its vertical where the body's axes are the scene's."""
    words = []
    if in_words(space):
        up = int(np.argmax(np.abs(space[:, 2])))
        vertical = f"{'xyz'[up]} {'up' if space[up, 2] > 0 else 'down'}, "
        words.append(f"{vertical}space {in_words(space)}")
    if in_words(body):
        words.append(f"body {in_words(body)}")
    return ", ".join(words)


def _of_angles(values: Doubles, right: Right) -> Iterator[_Way]:
    true = right.matrices
    yield Hypothesis(change=Change()), _against(turns("zxz", values), true)
    in_degrees = Hypothesis("in degrees", Change(SAME, (1, 1, 1), 1))
    yield in_degrees, _against(turns("zxz", _DEGREE * values), true)
    forms: list[_Form] = []
    for sequence in _SEQUENCES:
        for factor, unit in ((1.0, ""), (_DEGREE, " in degrees")):
            rotations = turns(sequence, factor * values)
            name = f"turns about {'-'.join(sequence)}{unit}"
            forms.append((name, rotations, None))
            forms.append((f"{name} body from space", rotations.transpose(0, 2, 1), None))
    yield from _in_frames(forms, true)


def _against(values: Any, true: Any) -> Doubles:
    """Digits to which matrices agree at each row."""
    return _digits(errors_of_rows(values, true))


def _digits(error: Doubles) -> Doubles:
    with np.errstate(divide="ignore", invalid="ignore"):
        digits = np.nan_to_num(-np.log10(error), nan=0.0, posinf=_TELLABLE)
    clipped: Doubles = np.clip(digits, 0.0, _TELLABLE)
    return clipped
