"""Many rows judged at once, in pairs of doubles.

What is judged has 53 or 64 bits, or some 17 printed digits, and is off by a unit of its last one or
more: a reference that is right to three digits beyond that tells the correct digits to a hundredth.
Pairs hold about 30 digits, of which the phases take log10 of the largest; at some rows they are
held against the closed form itself, and where they do not have the digits, nothing is judged by
them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

import numpy as np

from polhode.common.errors import BadInput
from polhode.common.progress import Progress
from polhode.common.text_tables import few
from polhode.equations.column import column
from polhode.judging._dense_reference.columns import Columns, in_panels
from polhode.judging._dense_reference.parallel_evaluation import Ask
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import Reference, rows
from polhode.judging.score.part_digits import TURNING
from polhode.judging.tables.candidate import Subject, columns_in_pairs
from polhode.numbers import exact
from polhode.numbers.conversion import to_double
from polhode.numbers.double_double import Pairs, of_exact, of_fractions, of_pairs, pairs
from polhode.numbers.exact import sign
from polhode.numbers.rows import Doubles
from polhode.numbers.scalars import Scalar
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import COLUMNS

FEWEST = 100  # rows: fewer are judged one by one in no time
MOST_DIGITS = 20.0  # that can be told in pairs
_SPARE = 3  # digits of the reference beyond those that can be told
SPARE_DIGITS = 6  # and where it is asked row by row, or proves them
_CHECKED = 7  # rows at which the pairs are held against the closed form


@dataclass(frozen=True)
class ManyRows:
    """Errors of a subject's rows: of the state (0 without one), scaled as digits are, of the
    attitude, of the angles and of derived columns; None where these are to be judged one by one.

    A quaternion may have either sign: that which makes more of its rows right, or in each row the
    better one where its signs mean nothing.  ``halves``: the
    errors of omega and of gamma.  ``turned``: of angles, psi and phi up to whole turns.
    ``untold``: rows of which theta is judged and psi and phi, which the subject has, are not yet.
    """

    errors: Doubles
    halves: Mapping[str, Doubles]
    attitude: Doubles | None
    angles: Doubles | None
    turned: Doubles | None
    derived: Mapping[str, Doubles]
    untold: tuple[int, ...] = ()

    def part(self, word: str) -> Doubles | None:
        """The errors of an output by its word."""
        return {"attitude": self.attitude, "angles": self.angles, **self.derived}.get(word)


def many_rows(
    subject: Subject, reference: object, workers: int = 1, tell: Progress | None = None
) -> ManyRows | None:
    """A subject held against a reference; None where pairs cannot judge it."""
    count = len(subject.times)
    if count < FEWEST or subject.held > MOST_DIGITS:
        return None
    if isinstance(reference, Certified):
        return _against_balls(subject, reference)
    if not isinstance(reference, Reference):
        return None
    try:
        found = _columns(subject, reference, workers, tell)
        if found is None:
            return None
        own = [] if subject.states is None else subject.pairs
        rotated = [] if subject.attitude is None else columns_in_pairs(subject.attitude)
        told_angles = None if found.angles is None else subject.angles
        angular = [] if told_angles is None else columns_in_pairs(told_angles)
        made = {word: columns_in_pairs(rows) for word, rows in subject.derived.items()}
    except OverflowError:  # numbers beyond doubles
        return None
    states, quaternion, told = ([_spread(x, count) for x in part or ()] for part in found[:3])
    with np.errstate(all="ignore"):
        scale = _scale(states, reference.scene)
        scales = [scale if i < 3 else 1.0 for i in range(len(states))]
        halves = _halves(own, states, scale)
        errors = np.maximum.reduce([*halves.values()]) if own else np.zeros(count)
        sides = [
            _errors(rotated, [y * side for y in quaternion], [1.0] * 4)
            for side in (1.0, -1.0)
            if rotated and quaternion
        ]
        # psi and phi are not judged where the closed form has none, or does not tell them here
        known = [
            x if k == 1 else Pairs(np.where(np.isnan(told[k].hi), np.nan, x.hi), x.lo)
            for k, x in enumerate(angular)
        ]
        angle_errors = _errors(known, told, [1.0] * 3) if angular else None
        turned = _errors(_near(known, told), told, [1.0] * 3) if angular else None
        right = {w: _derived(w, reference.scene, states, quaternion, count) for w in made}
        by = {w: [_largest(columns)] * len(columns) for w, columns in right.items() if columns}
        derived = {w: _errors(made[w], right[w], scale) for w, scale in by.items()}
    if subject.signless and sides:
        sides = [np.minimum(*sides)]
    attitude = max(sides, key=lambda side: sum(digits(side, subject.held)), default=None)
    judged: list[tuple[Ask, Sequence[Pairs], Sequence[float], Doubles | None]] = [
        (reference.at, own and states, scales, errors),
        (reference.attitude, quaternion, [1.0] * 4, attitude),
        (reference.angles, told, [1.0] * 3, angle_errors),
    ]
    judged += [(partial(reference.column, w), right[w], by[w], derived[w]) for w in by]
    for ask, true, scale_of, found_errors in judged:
        if true and found_errors is not None:
            # the largest error, or what is no number: that is what argmax finds first
            checked = {*few(count, _CHECKED), int(found_errors.argmax())}
            if true is told:
                checked -= {*found.untold}
            if not _right(subject, ask, true, scale_of, sorted(checked)):
                return None
    untold = [k for k in found.untold if not all(np.isnan(angular[i].hi[k]) for i in (0, 2))]
    return ManyRows(errors, halves, attitude, angle_errors, turned, derived, tuple(untold))


def _against_balls(subject: Subject, reference: Certified) -> ManyRows | None:
    """A subject of states alone, held against the midpoints of proven balls."""
    if not subject.columns or any(subject.part(word) is not None for word in COLUMNS):
        return None
    proven = reference.enclosure(subject.times, math.ceil(subject.held) + SPARE_DIGITS)
    try:
        own, true = subject.pairs, [of_fractions(x) for x in zip(*proven.centres, strict=True)]
    except OverflowError:  # numbers beyond doubles
        return None
    with np.errstate(all="ignore"):
        halves = _halves(own, true, _scale(true, reference.scene))
    errors = np.maximum.reduce([*halves.values()])
    return ManyRows(errors, halves, None, None, None, {})


def _halves(own: Sequence[Pairs], true: Sequence[Pairs], scale: float) -> dict[str, Doubles]:
    """The errors of omega, scaled, and of gamma."""
    return {
        name: _errors(own[half], true[half], [by] * len(own[half]))
        for name, half, by in (("omega", slice(0, 3), scale), ("gamma", slice(3, 6), 1.0))
        if own[half]
    }


def _near(angles: Sequence[Pairs], true: Sequence[Pairs]) -> list[Pairs]:
    """Angles moved by the whole turns of psi and phi that bring them nearest to the true ones."""
    turn = of_exact(2 * exact.pi())
    counts = {k: np.rint((angles[k].hi - true[k].hi) / (2 * math.pi)) for k in TURNING}
    return [
        x - Pairs(np.where(np.isnan(counts[k]), 0.0, counts[k])) * turn if k in counts else x
        for k, x in enumerate(angles)
    ]


def _largest(columns: Sequence[Pairs]) -> float:
    """The largest size of a derived column's numbers, 1 where they are 0."""
    return max(float(np.max(np.abs(x.hi))) for x in columns) or 1.0


def _derived(
    word: str, scene: Scene, states: list[Pairs], quaternion: list[Pairs], count: int
) -> list[Pairs]:
    """A derived column of the reference's columns; none where it needs others."""
    given = {"state": states, "attitude": quaternion}
    parts = [given.get(need, []) for need in COLUMNS[word].needs]
    if not all(parts):
        return []
    found = column(word)
    k = {name: of_exact(x) for name, x in found.of(scene).items()}
    made = found.values([x for part in parts for x in part], k, of_pairs())
    return [_spread(x, count) for x in made]


def _columns(
    subject: Subject, reference: Reference, workers: int, tell: Progress | None
) -> Columns | None:
    """The reference at a subject's times, for all its columns; None where it does not pay."""
    given = (("at", subject.states), ("attitude", subject.attitude), ("angles", subject.angles))
    needed = {need for word in subject.derived for need in COLUMNS[word].needs}
    needed |= {"at"} if "state" in needed else set()
    asked = [name for name, own in given if own is not None or name in needed]
    with suppress(BadInput):  # an answer that this closed form does not have
        return in_panels(reference, subject.times, _needed(subject), asked, workers, tell)
    return None


def _needed(subject: Subject) -> int:
    """The digits of a reference that tells those of a subject."""
    return math.ceil(subject.held) + _SPARE


def _errors(own: Sequence[Pairs], true: Sequence[Pairs], scales: Sequence[float]) -> Doubles:
    """The largest error of each row; a cell that is not there is not judged."""
    columns = [
        np.where(np.isnan(x.hi), 0.0, np.abs((x - y).hi) / scale)
        for x, y, scale in zip(own, true, scales, strict=True)
    ]
    found: Doubles = np.maximum.reduce(columns)  # not a number where one is none
    return found


def digits(errors: Doubles, cap: float) -> list[float]:
    """-log10 of errors, between 0 and ``cap``."""
    with np.errstate(divide="ignore"):
        found: list[float] = np.clip(-np.log10(errors), 0.0, cap).tolist()
    return found


def _spread(x: Scalar, count: int) -> Pairs:
    one = pairs(x)
    return Pairs(*(np.broadcast_to(part, count) for part in (one.hi, one.lo)))


def _scale(states: Sequence[Pairs], scene: Scene) -> float:
    """What errors of w are relative to, see :func:`polhode.judging.correct_digits.rate_scale`."""
    largest = float(np.sqrt(sum(x.hi**2 for x in states[:3])).max())
    if largest > 0:
        return largest
    fallback = scene.pendulum_rate_squared
    return to_double(exact.sqrt(fallback)) if sign(fallback) else 1.0


def _right(
    subject: Subject,
    ask: Ask,
    found: Sequence[Pairs],
    scales: Sequence[float],
    at: Sequence[int],
) -> bool:
    """Whether the pairs are right, at some rows, to the digits needed."""
    needed = _needed(subject)
    for k, true in zip(at, rows(ask, [subject.times[k] for k in at], needed + 3), strict=True):
        for x, y, scale in zip(found, true, scales, strict=True):
            if y is None and np.isnan(x.hi[k]):
                continue
            if y is None or not abs((x[k] - y).hi) / scale < 10.0**-needed:
                return False
    return True
