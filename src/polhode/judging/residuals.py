"""What is left of a table beside the reference: its size, its bias, and whether it is white noise.

An attitude's residual is the rotation from the true attitude to the table's, as a vector along body
axes.  Residuals are called white if three tests do not reject that at a significance of one in a
hundred over all tests and columns: Ljung's and Box's of their autocorrelations, the runs of their
signs about the median (Wald, Wolfowitz), and the ratio of the variances of their halves.
"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from polhode.judging.correct_digits import log10_rate, plain_rows
from polhode.judging.limits import BIASED, WHITE, Limit
from polhode.judging.score import Score
from polhode.numbers.conversion import doubles, exactly, to_double
from polhode.numbers.double_double import Pairs
from polhode.numbers.number_types import Doubles, Given, Scalar
from polhode.scenes.vocabulary import ATTITUDE, STATE

FEWEST = 30  # rows of which it can be told
SIGNIFICANCE = 0.01
_LAGS = 10
_TESTS = 3
_NOISY, _RADIAN = 0.1, 57.3  # of a column's size: noise that leaves digits; degrees
_BIASED = 5.0  # a bias, times the noise about it, that limits
ROTATION = ("rotation_x", "rotation_y", "rotation_z")


class Residual(NamedTuple):
    """Of a column: the root mean square about the bias, the bias, and its standard error."""

    column: str
    rms: float
    bias: float
    bias_error: float


def differences(own: Given | Pairs, true: Given | Pairs, signs: Doubles | None = None) -> Doubles:
    """Own numbers, each row times its sign, less the true ones, rounded once; not a number where
    either is not there."""
    if signs is None:
        signs = np.ones(len(own.hi) if isinstance(own, Pairs) else len(list(own)))
    if isinstance(own, Pairs) and isinstance(true, Pairs):
        signed = Pairs(own.hi * signs[:, None], own.lo * signs[:, None])
        rounded: Doubles = (signed - true).hi
        return rounded
    rows = zip(signs.tolist(), plain_rows(own), plain_rows(true), strict=True)
    return np.array(
        [
            [_difference(sign, x, y) for x, y in zip(mine, right, strict=True)]
            for sign, mine, right in rows
        ],
        dtype=float,
    )


def rotations(own: Given | Pairs, true: Given | Pairs) -> Doubles:
    """Rotations from true attitudes to own ones, vectors along body axes in degrees.

    By the quaternions' difference d: the vector part of true* own is that of true* d.  They are of
    any length and sign.
    """
    theirs, right = (x.hi if isinstance(x, Pairs) else doubles(x) for x in (own, true))
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # of any numbers
        product = np.sum(theirs * right, axis=1)
        d = differences(own, true, np.where(product < 0, -1.0, 1.0))
        a, b = right[:, :1], right[:, 1:]
        vector = a * d[:, 1:] - b * d[:, :1] - np.cross(b, d[:, 1:])
        sine = np.linalg.norm(vector, axis=1)
        angle = 2 * np.arctan2(sine, np.abs(product))
        factor = np.where(sine > 0, np.degrees(angle) / sine, 0.0)
        rotation: Doubles = vector * factor[:, None]
    return rotation


def are_white(rows: Doubles) -> bool:
    """Whether columns may be white noise, each about its bias."""
    count, columns = rows.shape
    if count < FEWEST or not np.all(np.ptp(rows, axis=0) > 0):
        return False
    share = SIGNIFICANCE / (_TESTS * columns)
    limit, one_sided = (NormalDist().inv_cdf(1 - x) for x in (share / 2, share))
    return all(
        _correlation(x) < one_sided and abs(_runs(x)) < limit and abs(_halves(x)) < limit
        for x in rows.T
    )


def _correlation(values: Doubles) -> float:
    """Ljung's and Box's statistic as a normal deviate, by Wilson's and Hilferty's cube root."""
    x, count = values - np.mean(values), len(values)
    square = float(x @ x)
    ratios = [float(x[k:] @ x[:-k]) / square for k in range(1, _LAGS + 1)]
    q = count * (count + 2) * sum(r * r / (count - k) for k, r in enumerate(ratios, 1))
    spread = 2 / (9 * _LAGS)
    return (math.cbrt(q / _LAGS) - (1 - spread)) / math.sqrt(spread)


def _runs(values: Doubles) -> float:
    """The number of runs of signs about the median, as a normal deviate."""
    signs = values > np.median(values)
    above, count = int(np.sum(signs)), len(signs)
    mean = 2 * above * (count - above) / count + 1
    variance = (mean - 1) * (mean - 2) / (count - 1)
    runs = 1 + int(np.sum(signs[1:] != signs[:-1]))
    return (runs - mean) / math.sqrt(variance) if variance > 0 else math.inf


def _halves(values: Doubles) -> float:
    """The logarithm of the ratio of the variances of both halves, as a normal deviate."""
    first, second = np.array_split(values, 2)
    variances = [float(np.var(half, ddof=1)) for half in (first, second)]
    if not min(variances) > 0:
        return math.inf
    spread = 2 / (len(first) - 1) + 2 / (len(second) - 1)
    return math.log(variances[1] / variances[0]) / math.sqrt(spread)


def _difference(sign: float, x: Scalar | None, y: Scalar | None) -> float:
    if x is None or y is None:
        return math.nan
    return to_double(int(sign) * exactly(x) - exactly(y))


# --- residuals of a score -------------------------------------------------------------------------


def rotation_errors(score: Score) -> Doubles:
    """Rotations from the true attitudes to a table's, vectors along body axes in degrees, shape
    (rows, 3); not a number where the attitude was not judged, no rows where nowhere."""
    digits, comparison = score.other_parts.get("attitude"), score.comparison
    if digits is None or comparison is None:
        return np.zeros((0, 3))
    try:
        errors = comparison.residuals("attitude", ATTITUDE, rotations)
    except ValueError:  # a proof judged it, and its digits alone are known
        return np.zeros((0, 3))
    errors[[k for k, d in enumerate(digits) if d is None]] = math.nan
    return errors


class ResidualRows(NamedTuple):
    """What is left of a table's state and attitude: names, and its whole rows in time."""

    names: tuple[str, ...]
    rows: Doubles

    @classmethod
    def of(cls, score: Score, rotation: Doubles) -> ResidualRows:
        """Those of what was judged; ``rotation``: as of :func:`rotation_errors`."""
        names: list[str] = []
        parts = []
        if score.digits and score.comparison is not None:
            columns = score.reference.scene.columns
            there = [k for k, name in enumerate(columns) if name in score.subject.state]
            names += [columns[k] for k in there]
            parts.append(score.comparison.residuals("at", columns, differences)[:, there])
        if len(rotation):
            names += ROTATION
            parts.append(rotation)
        if not parts:
            return cls((), np.zeros((0, 0)))
        order = sorted(range(len(score.times)), key=lambda k: score.times[k])
        rows = np.hstack(parts)[order]
        return cls(tuple(names), rows[np.all(np.isfinite(rows), axis=1)])

    @property
    def residuals(self) -> tuple[Residual, ...]:
        """Of each column root mean square, bias, and the bias's standard error."""
        count = len(self.rows)
        if not count:
            return tuple(Residual(name, 0.0, 0.0, 0.0) for name in self.names)
        # powers of two, so that no square is beyond doubles: of numbers that are no motion's
        sizes = np.ldexp(1.0, np.frexp(np.max(np.abs(self.rows), axis=0))[1] - 1)
        spread, means = (sizes * f(self.rows / sizes, axis=0) for f in (np.std, np.mean))
        pairs = zip(self.names, spread.tolist(), means.tolist(), strict=True)
        return tuple(Residual(name, rms, bias, rms / math.sqrt(count)) for name, rms, bias in pairs)

    def noise(self, score: Score) -> Limit | None:
        """What white noise of a tenth of its size or less is called: by its bias, where that is
        more than the noise; None where it is no such noise."""
        if len(self.rows) < FEWEST:
            return None
        rate = 1.0
        if score.digits and score.comparison is not None:
            true = score.comparison.first_answer("at")
            rate = 10.0 ** log10_rate(true, score.reference.scene)
        sizes = [rate if n in STATE[:3] else _RADIAN if n in ROTATION else 1.0 for n in self.names]
        with np.errstate(over="ignore"):  # of numbers that are no motion's
            level = np.sqrt(np.mean(self.rows**2, axis=0)) / sizes
        if not (np.all(level < _NOISY) and are_white(self.rows)):
            return None
        return BIASED if any(abs(x.bias) > _BIASED * x.rms for x in self.residuals) else WHITE
