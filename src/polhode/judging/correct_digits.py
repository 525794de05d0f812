"""Correct digits of rows of states against reference rows: the definition, and nothing else.

Correct digits = -log10 of the larger of (max-norm error of w over the largest |w| that the
reference reaches at the output times; if that is 0, over sqrt(Mg|r0|/largest moment), else over 1)
and (max-norm error of gamma).

Differences of numbers, of whatever types, are exact; their logarithms are doubles, in which an
error of 1e-1000 is a number like any other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from itertools import repeat
from pathlib import Path
from typing import TypeAlias

import numpy as np

from polhode.common.errors import BadInput, plain
from polhode.numbers import exact
from polhode.numbers.conversion import exactly
from polhode.numbers.double_double import Pairs, binary_numbers
from polhode.numbers.exact import sign
from polhode.numbers.number_types import Doubles, Given, Real, Scalar, States
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import REQUESTS

#: States of any number type, as a user has them.
AnyStates: TypeAlias = "States | Sequence[Sequence[Real]]"

_TINIEST = -(1 << 17)  # the binary exponent below which a number is 0: no digit asked for shows it

#: What a difference is taken from: both numbers as quotients of integers.
_Quotient = tuple[int, int]


def log10_differences(
    own: Given | Pairs,
    true: Given | Pairs,
    side: int = 1,
    turning: Sequence[int] = (),
    bits: int = 0,
) -> Doubles:
    """log10 of the difference of each number from the true one, shape (rows, columns).

    -inf where they are equal, inf where the own one is infinite, not a number where either is not
    there.  ``side``: a sign of the own numbers.  ``turning``: columns of angles whose whole turns
    mean nothing; 2 pi is taken to so many ``bits``.  Pairs are subtracted as they are.
    """
    if isinstance(own, Pairs) and isinstance(true, Pairs):
        return log10_sizes((own if side > 0 else -own) - true)  # a product may be out of range
    own, true = plain_rows(own), plain_rows(true)
    turns = [_turn(bits) if k in turning else None for k in range(len(own[0]) if len(own) else 0)]
    rows = own.tolist() if isinstance(own, np.ndarray) else own  # quicker to take apart
    pairs = zip(rows, true, strict=True)
    logs = [[*map(_log10_gap, row, right, turns, repeat(side))] for row, right in pairs]
    return np.array(logs).reshape(len(logs), len(turns))


def log10_sizes(rows: Given | Pairs) -> Doubles:
    """log10 of the size of each number, shape (rows, columns); not a number where there is none."""
    if isinstance(rows, Pairs):
        with np.errstate(divide="ignore"):
            logs: Doubles = np.log10(np.abs(rows.hi))
        return logs
    return np.array(
        [[math.nan if x is None else _log10(_quotient(x)) for x in row] for row in rows]
    )


def log10_rate(rows: Given | Pairs, scene: Scene) -> float:
    """log10 of what errors of w are relative to: the largest |w| of the reference's rows."""
    omega = rows[:, :3] if isinstance(rows, Pairs) else [row[:3] for row in rows]
    sizes = log10_sizes(omega)
    if len(sizes):
        most = float(np.max(sizes))
        if most > -math.inf:
            squares = np.sum(100.0 ** (sizes - most), axis=1)
            return most + math.log10(float(np.max(squares))) / 2
    fallback = scene.pendulum_rate_squared
    return exact.log10(fallback) / 2 if sign(fallback) else 0.0


def log10_errors(states: Given, reference: Given, scene: Scene) -> Doubles:
    """For each time log10 of the larger of the scaled errors of w and of gamma.

    ``states``: rows as long as those of ``reference``; an entry None is not judged.
    """
    return largest(scaled(log10_differences(states, reference), log10_rate(reference, scene)))


def scaled(differences: Doubles, rate: float) -> Doubles:
    """Those of w relative to a rate, those of gamma as they are."""
    logs = differences.copy()
    logs[:, :3] -= rate
    return logs


def largest(differences: Doubles) -> Doubles:
    """That of each row; not a number where none is there."""
    most: Doubles = np.fmax.reduce(differences, axis=1, initial=math.nan)
    return most


def digits_of(log10_error: Scalar, cap: float) -> Scalar:
    """The digits that an error leaves, or each of many, at most ``cap`` and at least 0."""
    return np.clip(-log10_error, 0.0, cap)


def worst_digits(states: Given, reference: Given, scene: Scene, cap: float) -> float:
    """The fewest correct digits over all rows."""
    digits = digits_of(log10_errors(states, reference, scene), cap)
    return float(np.fmin.reduce(digits, initial=cap))


def state_errors(states: AnyStates, true: AnyStates, scene: Scene | str | Path) -> Doubles:
    """Measure the error of each state: 10 to the power of minus its correct digits.

    Parameters
    ----------
    states : array_like, shape (N, 6) or (N, 3)
        p q r gamma1 gamma2 gamma3 at some times, omega alone of a scene without gamma; numbers of
        any type, whose differences are exact.
    true : array_like
        The true states at these times, of another type if you like, such as those of
        :func:`polhode.reference`.
    scene : Scene, str or Path
        Whose motion it is: where omega vanishes, its error is relative to the rate of the pendulum.

    Returns
    -------
    ndarray of double, shape (N,)
        The larger of the error of omega over the largest size of omega of the true states, and that
        of gamma; nan of a state with a nan.  What is None is not judged.

    Raises
    ------
    BadInput
        A scene that there is not, states of another shape than the true ones, or a true one that is
        not finite.

    Examples
    --------
    >>> import polhode
    >>> run = polhode.integrate("lagrange/nutation", at=[1, 2])
    >>> true = polhode.reference("lagrange/nutation").at([1, 2], digits=20)
    >>> float(polhode.state_errors(run.states, true, "lagrange/nutation").max()) < 1e-14
    True
    """
    scene = library.load(scene, takes=REQUESTS)
    if len(states) != len(true):
        expected = f"{len(true)}, as the true ones"
        raise BadInput(scene.name, "states", f"{len(states)} rows", expected)
    for k, (row, right) in enumerate(zip(states, true, strict=True), 1):
        if len(row) != len(right):
            expected = f"{len(right)}, as the true one"
            raise BadInput(scene.name, f"states, row {k}", f"{len(row)} numbers", expected)
        if not all(x is not None and x - x == 0 for x in right):
            raise BadInput(scene.name, f"true, row {k}", plain([*right]), "finite numbers")
    errors: Doubles = 10.0 ** log10_errors(states, true, scene)
    errors[[any(x is not None and x != x for x in row) for row in states]] = math.nan
    return errors


def plain_rows(rows: Given | Pairs) -> Given:
    """Rows of single numbers, exact; of pairs polhode's own mpf."""
    return binary_numbers(rows) if isinstance(rows, Pairs) else rows


def _quotient(x: Scalar) -> _Quotient:
    """A number as a quotient of integers; raises OverflowError or ValueError if not finite."""
    if isinstance(x, (float, int, Decimal, Fraction)):
        return x.as_integer_ratio()
    raw = getattr(x, "_mpf_", None)
    if raw is None or (not raw[1] and raw[2]):
        return exactly(x).as_integer_ratio()
    negative, mantissa, exponent, size = raw
    if exponent + size < _TINIEST:
        return 0, 1
    top = -int(mantissa) if negative else int(mantissa)
    return (top << exponent, 1) if exponent >= 0 else (top, 1 << -exponent)


def _log10_gap(x: Scalar | None, y: Scalar | None, turn: _Quotient | None, side: int) -> float:
    """log10 of the difference of ``side`` x from y, up to whole turns where one is given."""
    if x is None or y is None:
        return math.nan
    try:
        top, bottom = _quotient(x)
    except (OverflowError, ValueError):
        return math.inf if x == x else math.nan
    gap = _difference((side * top, bottom), _quotient(y))
    if turn is not None:
        gap = _difference(gap, (turn[0] * _whole(gap, turn), turn[1]))
    return _log10(gap)


def _difference(x: _Quotient, y: _Quotient) -> _Quotient:
    return x[0] * y[1] - y[0] * x[1], x[1] * y[1]


def _log10(x: _Quotient) -> float:
    return math.log10(abs(x[0])) - math.log10(x[1]) if x[0] else -math.inf


def _turn(bits: int) -> _Quotient:
    mantissa, exponent = exact.rounded(2 * exact.pi(), bits)
    return mantissa, 1 << -exponent


def _whole(x: _Quotient, unit: _Quotient) -> int:
    """The whole number nearest to a quotient of two."""
    top, bottom = x[0] * unit[1], x[1] * unit[0]
    return (2 * top + bottom) // (2 * bottom)
