"""What a table that is wrong everywhere may mean: the usual other conventions, tried one by one.

Doubles are enough: a convention is right or it is wrong in the first digit.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, Iterator, Sequence
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from polhode.common.text_tables import few
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import Reference, Remembered, rows
from polhode.judging.references.two_precisions import TwoPrecisions
from polhode.judging.tables.candidate import Subject
from polhode.judging.tables.reading import GAIN, WRONG, Change, Reading
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.rows import Doubles
from polhode.scenes.vocabulary import STATE

AnyReference: TypeAlias = Reference | Certified | TwoPrecisions | Remembered

_LEAST_ROWS = 3
MOST_ROWS = 40  # looked at
_TELLABLE = 15.0  # digits
_DEGREE = math.pi / 180
_SEQUENCES = [s for s in itertools.product("xyz", repeat=3) if s[0] != s[1] != s[2]]


def readings(
    subject: Subject,
    reference: AnyReference,
    wrong: Collection[str],
) -> list[Reading]:
    """For each part that is wrong, the convention that makes most of it right, if one does.

    ``wrong``: which of omega, gamma, attitude and angles are, or may be.
    """
    kept = few(len(subject.times), MOST_ROWS)
    times = [subject.times[k] for k in kept]

    def doubles(part: Any) -> Any:
        if part is None:
            return None
        values = [[math.nan if x is None else to_double(exactly(x)) for x in part[k]] for k in kept]
        found = np.array(values, dtype=float)
        return None if np.isnan(found).any() else found

    def asked(question: Callable[..., Any], times: Any = times) -> Any:
        try:
            return np.array([[float(x) for x in row] for row in rows(question, times, 18)])
        except (TypeError, ValueError):  # no closed form for it, a pole
            return None

    whole = {k: part for k, part in _whole(subject, doubles).items() if k in wrong}
    if not whole:
        return []
    right = _right(asked, reference, times)
    if right is None:
        return []
    found = [_best(part, _ways(part, values, right)) for part, values in whole.items()]
    good = [reading for reading in found if reading is not None]
    if not good and len(times) > 2:
        step = subject.times[1] - subject.times[0]
        for sign, word in ((1, "late"), (-1, "early")):
            moved = _right(asked, reference, [t - sign * step for t in times])
            if moved is not None:
                good += _moved(whole, right, moved, f"one step of t {word}", sign)
    return good


def _right(
    asked: Callable[..., Any], reference: AnyReference, times: Sequence[Fraction]
) -> _Right | None:
    """The reference's states and attitudes at these times; None where it gives no states."""
    states, turns = (asked(question, times) for question in (reference.at, reference.attitude))
    if states is None:  # a proof that had no more time
        return None
    return _Right(states, None if turns is None else _matrices(turns))


def _moved(
    whole: dict[str, Doubles], right: _Right, moved: _Right, words: str, late: int
) -> list[Reading]:
    """Readings of all parts at other times, where none of them contradicts."""
    found = []
    for part, values in whole.items():
        plain, there = (next(_ways(part, values, held), None) for held in (right, moved))
        if plain is None or there is None:
            continue
        if plain.digits >= WRONG:
            continue
        best = _best(part, iter((plain, _Way(words, there.digits, Change(late=late)))))
        if best is None:
            return []
        found.append(best)
    return found


class _Right(NamedTuple):
    states: Any
    matrices: Any  # body -> space, None where not known


def _whole(subject: Subject, doubles: Callable[[Any], Any]) -> dict[str, Any]:
    """The parts of which every number is there."""
    found: dict[str, Any] = {}
    if subject.columns:
        for name, columns in (("omega", slice(0, 3)), ("gamma", slice(3, 6))):
            values = doubles([row[columns] for row in subject.states])
            if values is not None and values.shape[1] == 3:
                found[name] = values
    for name in ("attitude", "angles"):
        values = doubles(getattr(subject, name))
        if values is not None:
            found[name] = values
    return found


class _Way(NamedTuple):
    """A convention, the digits that it gives, and the change that applies it, if one does."""

    words: str
    digits: float
    change: Change | None = None


_SAME = (0, 1, 2)


def _ways(part: str, values: Any, right: _Right) -> Iterator[_Way]:
    """Conventions of a part and the digits that each gives; as it stands first."""
    if part == "omega":
        yield from _of_omega(values, right)
        yield from _of_axes(STATE[:3], values, right.states[:, :3], True)
    elif part == "gamma":
        true = right.states[:, 3:]
        yield _Way("", _against(values, true))
        down = Change(_SAME, (-1, -1, -1))
        yield _Way("the downward vertical", _against(-values, true), down)
        yield from _of_axes(STATE[3:], values, true, False)
    elif right.matrices is not None:
        yield from (_of_attitude if part == "attitude" else _of_angles)(values, right)


def _of_axes(
    names: Sequence[str], values: Doubles, true: Doubles, relative: bool
) -> Iterator[_Way]:
    """Axes in another order or of another sense, left-handed frames among them.

    None of fewer rows than tell that from a wrong number.
    """
    if len(values) < _LEAST_ROWS:
        return
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1, -1), repeat=3):
            if order == _SAME and len({*signs}) == 1:
                continue
            held = [f"{'-' if s < 0 else ''}{names[k]}" for s, k in zip(signs, order, strict=True)]
            words = f"{' '.join(names)} = {' '.join(held)}"
            digits = _against(values[:, order] * signs, true, relative)
            yield _Way(words, digits, Change(order, signs))


def _of_omega(values: Any, right: _Right) -> Iterator[_Way]:
    true = right.states[:, :3]
    yield _Way("", _against(values, true, True))
    for factor, unit in ((1.0, ""), (_DEGREE, "degrees")):
        for sign, sense in ((1, ""), (-1, "of the other sense")):
            words = " ".join(filter(None, (unit, sense)))
            change = Change(_SAME, (sign,) * 3, bool(unit))
            if words:
                yield _Way(words, _against(sign * factor * values, true, True), change)
            if right.matrices is not None:
                inside = np.einsum("nij,ni->nj", right.matrices, sign * factor * values)
                in_space = f"along the axes of space {words}".strip()
                yield _Way(in_space, _against(inside, true, True))


def _of_attitude(values: Any, right: _Right) -> Iterator[_Way]:
    yield _Way("", _as_it_stands(values, right))
    orders = (
        ((0, 1, 2, 3), ""),
        ((3, 0, 1, 2), "scalar-last"),
        ((1, 2, 3, 0), "q1 the scalar"),
    )
    steady = _is_steady(values)
    for order, place in orders:
        matrices = _matrices(values[:, order])
        senses = (
            (matrices, "", (1, 1, 1, 1)),
            (matrices.transpose(0, 2, 1), "body from space", (1, -1, -1, -1)),
        )
        for turned, sense, signs in senses:
            words = ", ".join(filter(None, (place, sense)))
            change = Change(order, signs) if words and steady else None
            words = words or "of either sign at each time"
            yield _Way(words, _against(turned, right.matrices), change)


def _is_steady(values: Doubles) -> bool:
    """Whether a quaternion's sign does not change between samples."""
    return bool(np.all(np.einsum("ni,ni->n", values[1:], values[:-1]) >= 0))


def _as_it_stands(values: Any, right: _Right) -> float:
    """Digits of a quaternion whose sign does not change between samples."""
    return _against(_matrices(values), right.matrices) if _is_steady(values) else 0.0


def _of_angles(values: Any, right: _Right) -> Iterator[_Way]:
    own = _turns("zxz", values)
    yield _Way("", _against(own, right.matrices))
    for sequence in _SEQUENCES:
        for factor, unit in ((1.0, ""), (_DEGREE, "in degrees")):
            matrices = _turns("".join(sequence), factor * values)
            name = f"turns about {'-'.join(sequence)}"
            for turned, sense in ((matrices, ""), (matrices.transpose(0, 2, 1), "body from space")):
                words = " ".join(filter(None, (name, unit, sense)))
                yield _Way(words, _against(turned, right.matrices))


def _best(part: str, ways: Iterator[_Way]) -> Reading | None:
    found = list(ways)
    if not found:
        return None
    plain, others = found[0].digits, found[1:]
    words, digits, change = max(others, key=lambda way: way.digits, default=_Way("", plain))
    if plain >= WRONG or digits < plain + GAIN:
        return None
    return Reading(part, plain, words, digits, change)


def _against(values: Any, true: Any, relative: bool = False) -> float:
    """Digits to which arrays agree, the fewest; ``relative``: to the largest vector."""
    scale = float(np.max(np.linalg.norm(true, axis=1))) if relative else 1.0
    error = float(np.max(np.abs(values - true))) / (scale or 1.0)
    return _TELLABLE if error == 0 else min(_TELLABLE, max(0.0, -math.log10(error)))


def _matrices(quaternions: Any) -> Any:
    """R (body -> space) of quaternions, scalar first, of any length but 0; shape (n, 3, 3)."""
    with np.errstate(invalid="ignore", divide="ignore"):
        length = np.linalg.norm(quaternions, axis=1, keepdims=True)
        a, b, c, d = (quaternions / np.where(length == 0, 1, length)).T
    found = [
        [1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)],
    ]
    return np.array(found).transpose(2, 0, 1)


def _turns(sequence: str, angles: Any) -> Any:
    """The product of turns about body axes, one after the other: R = R1(a1) R2(a2) R3(a3)."""
    found = np.broadcast_to(np.eye(3), (len(angles), 3, 3))
    for axis, angle in zip(sequence, angles.T, strict=True):
        i = "xyz".index(axis)
        j, k = (i + 1) % 3, (i + 2) % 3
        one = np.zeros((len(angle), 3, 3))
        one[:, i, i] = 1
        one[:, j, j] = one[:, k, k] = np.cos(angle)
        one[:, k, j], one[:, j, k] = np.sin(angle), -np.sin(angle)
        found = found @ one
    return found
