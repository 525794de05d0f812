"""What limits the digits of a trajectory: rounding, inputs, conditioning, method or reference.

And where a part leaves the motion: right until one time, and wrong from the next one on.  A motion
that multiplies errors takes digits too, and takes them from any part: what is expected of rounding
explains such a fall, and then none is told.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate, pairwise, repeat
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np

from polhode.common.errors import BadInput, few
from polhode.equations.form import field
from polhode.judging.auxiliary_runs import by_sign
from polhode.judging.conditioning import Band, Conditioning, conditioning
from polhode.judging.correct_digits import log10_rate, plain_rows
from polhode.judging.score import SHOWN, STATE_PART, RowDigits, Score
from polhode.numbers.conversion import doubles, exactly, to_double
from polhode.numbers.decimals import brief
from polhode.numbers.double_double import Pairs
from polhode.numbers.number_types import Doubles, Given, Scalar
from polhode.scenes.vocabulary import ATTITUDE, STATE
from polhode.taylor import heyoka

FOLLOWED = 400  # times at which what rounding does to the motion is followed
LAST = 1.0  # digits: the type's own last ones
MOTION_TAKES = 2.0  # digits: what the motion takes before it is named
#: Smallest moment over largest below which a step loses more than one rounding, up to so many
#: digits: 12 of 24 runs of bodies like the case euler/needle (1e-6), 2 of 16 at 1e-4.
THIN, THIN_TAKES = 5e-5, 2.0
ALONE = 0.03  # digits: what steps add to an error three times theirs
_MORE = 1.1  # times what rounded times explain: of rates that are not the same between two times
_MOST = 2.0  # times what the worst row's time explains: most of its error
FALL = 3.0  # digits between the fewest before and the most after
_BEFORE = 2  # times before, beside t = 0, where every program is right


class Limit(str):
    """What limits digits: a name, and in brackets what is known beside it; empty of nothing.

    >>> from polhode.judging.limits import Limit
    >>> Limit("rounding", "of the printed digits").name
    'rounding'
    """

    __slots__ = ("detail", "name")
    name: str
    detail: str

    def __new__(cls, name: str, detail: str = "") -> Limit:
        """A name and what is known beside it."""
        limit = super().__new__(cls, f"{name} ({detail})" if detail else name)
        limit.name, limit.detail = name, detail
        return limit

    def __reduce__(self) -> tuple[type, tuple[str, str]]:
        return type(self), (self.name, self.detail)


NO_LIMIT = Limit("")
PRINTED = Limit("rounding", "of the printed digits")
WHITE, BIASED = Limit("noise", "white"), Limit("bias", "constant")
NOISES = (WHITE, BIASED)
UNKNOWN = Limit("unknown", "the digits to expect were not computed")
OF_THIN = Limit("unknown", "steps of so thin a body lose more than the expected digits allow for")


def limit(
    digits: float,
    most: float,
    expected: Band | None,
    inputs: float | None,
    steps: str,
    times: int = 1,
    thin: bool = False,
    reference: float = math.inf,
) -> Limit:
    """What limits so many correct digits.

    ``most``: the most that a table may have.  ``expected``: those of a run that rounds once a step.
    ``inputs``: those that rounding the scene's numbers leaves.  ``times``: of so many these digits
    are the fewest.  ``reference``: those that the reference is good for, inf for a closed form.

    *reference*: it is not good for more.  *rounding*: these are the type's own last digits, or the
    motion takes few.  *inputs*: no fewer than expected, and it is rounding the scene's numbers that
    costs them: the steps add next to nothing.  *conditioning*: no fewer than expected; any method
    that rounds its state at each step in this type loses as much.  *method*: fewer than nineteen in
    twenty such runs have at their worst time; ``steps`` says what the method does.  *unknown*: what
    to expect was not computed; or the body is ``thin``, of which steps lose more.
    """
    if reference < digits + LAST:
        return Limit("reference")
    if digits >= most - LAST:
        return Limit("rounding")
    if expected is None:
        return UNKNOWN
    least = expected.least - selected(times)
    if digits < least:
        return OF_THIN if thin and digits >= least - THIN_TAKES else Limit("method", steps)
    if expected.middle >= most - MOTION_TAKES:
        return Limit("rounding")
    lost = expected.most == 0
    alone = inputs is not None and inputs < expected.middle + ALONE and not lost
    return Limit("inputs" if alone else "conditioning")


def selected(times: int) -> float:
    """How many digits below the band of its time the worst one of several may lie.

    At one time a run in twenty has fewer digits than the band's least.  A run whose worst time is
    looked for has many chances; with n times it is no more likely than that to fall short anywhere
    if each is allowed what happens once in 20 n (Bonferroni; however the times depend on each
    other).  For a normal deviate that is an error z(20 n)/z(20) times as large.
    """
    once, each = (NormalDist().inv_cdf(1 - 1 / (40 * n)) for n in (1, max(1, times)))
    return math.log10(each / once)


def chance(digits: float, expected: Band, times: int) -> float:
    """The share of runs that have so few digits at their worst time by rounding alone, or fewer.

    Of a normal deviate, as in :func:`selected`; at most 1.  Who looks at hundreds of runs finds
    some of a share of one in a hundred.
    """
    ratio = 10.0 ** min(expected.least - digits, 3.0)
    deviate = NormalDist().inv_cdf(1 - 1 / 40) * ratio
    return min(1.0, times * math.erfc(deviate / math.sqrt(2)))


def is_lost(digits: float | None, expected: Band | None) -> bool:
    """Whether no digit is expected there, and none was found either."""
    return expected is not None and expected.middle == 0 and digits is not None and digits < LAST


def shown_digits(digits: float | None, expected: Band | None) -> str:
    """Correct digits for people; never a number where none is left, or none was judged."""
    if digits is None:
        return "-"
    return "none left" if is_lost(digits, expected) else f"{digits:.2f}"


def between(by_row: Mapping[int, Any], times: Sequence[Fraction]) -> tuple[Any, ...]:
    """Digits (numbers or bands) at times, linear between the rows where they are known.

    None where they are not known at a neighbour.
    """
    kind = next((x for x in by_row.values() if x is not None), None)
    if kind is None:
        return (None,) * len(times)
    nodes, unknown = sorted(by_row, key=times.__getitem__), np.full(np.size(kind), math.nan)
    rows = np.array([unknown if by_row[k] is None else np.ravel(by_row[k]) for k in nodes])
    at = np.array([to_double(t) for t in times])
    columns = [np.interp(at, at[nodes], column) for column in rows.T]
    rows_between = np.stack(columns, axis=1).tolist()
    make = type(kind) if np.size(kind) > 1 else float
    return tuple(
        by_row[k] if k in by_row else None if math.isnan(row[0]) else make(*row)
        for k, row in enumerate(rows_between)
    )


class Departure(NamedTuple):
    """``least`` digits or more until a time, ``most`` or fewer from the next one on."""

    until: Fraction
    least: float
    since: Fraction
    most: float

    def __str__(self) -> str:
        return (
            f"right until t = {brief(self.until)} ({self.least:.2f} digits or more), "
            f"then from t = {brief(self.since)} on {self.most:.2f} or fewer"
        )

    def is_unexpected(
        self, times: Sequence[Fraction], digits: RowDigits, bands: Sequence[Band | None]
    ) -> bool:
        """Whether far more digits are expected, wherever there are any, from the fall on."""
        first = times.index(self.since)
        pairs = zip(digits[first:], bands[first:], strict=True)
        expected = [band for d, band in pairs if d is not None]
        return all(band is not None and band.least >= self.most + FALL for band in expected)


def departure(times: Sequence[Fraction], digits: Sequence[float | None]) -> Departure | None:
    """Where digits fall for good; None where they do not."""
    there = [k for k, d in enumerate(digits) if d is not None]
    numbers = [d for d in digits if d is not None]
    least = list(accumulate(numbers, min))
    most = list(accumulate(reversed(numbers), max))[::-1]
    first = _BEFORE + (times[0] == 0 and there[:1] == [0])
    falls = [(least[n - 1] - most[n], n) for n in range(first, len(numbers))]
    fall, n = max(falls, default=(0.0, 0))
    if fall < FALL or least[n - 1] < FALL:
        return None
    if not all(abs(s) < abs(t) and s * t >= 0 for s, t in pairwise(times)):
        return None  # not in order
    return Departure(times[there[n - 1]], least[n - 1], times[there[n]], most[n])


# --- expectation ----------------------------------------------------------------------------------
#
# The digits to expect of a table: followed at ``FOLLOWED`` times or so, linear between those.


@dataclass(frozen=True)
class Expectation:
    """The digits to expect of a table at its times.

    ``bands``: those of runs that round once a step of the table's type; ``inputs``: those that
    rounding the scene's numbers to it leaves; None where they are not known.  ``lost_after``: the
    time after which kappa leaves no digits, None where it leaves some throughout; ``lost``: the
    same in words, or empty.
    """

    bands: tuple[Band | None, ...]
    inputs: tuple[float | None, ...]
    lost_after: float | None
    lost: str


def expectation(score: Score, conditions: Conditioning | None = None) -> Expectation:
    """The digits to expect of what was judged.

    ``conditions``: the conditioning at the scene's times, of which these are the first ones, to
    spare its computation.
    """
    table, times, scene = score.subject, score.times, score.reference.scene
    lowest = {score.lowest_row} if score.digits else set()
    rows = sorted({*few(len(times), FOLLOWED), *few(len(times), SHOWN)} | lowest)
    parts: list[tuple[Sequence[Fraction], Conditioning]] = []
    if conditions is not None:  # at the same times, though the table's are rounded
        parts, rows = [(times, conditions)], [*range(len(times))]
    elif heyoka.installed:
        instants = by_sign([times[k] for k in rows])
        with suppress(BadInput):  # a motion that cannot be followed in doubles
            parts = [(part, conditioning(scene, part, table.number)) for part in instants]
    every = 0 if table.run is None or table.run.projection is None else table.run.projection.every

    def at_all_times(question: Callable[[Conditioning], Sequence[Any]]) -> tuple[Any, ...]:
        pairs = (zip(part, question(growth), strict=False) for part, growth in parts)
        answers = {t: x for pair in pairs for t, x in pair}
        return between({k: answers[times[k]] for k in rows if answers}, times)

    after = [x.lost_after for _, x in parts if x.lost_after is not None]
    return Expectation(
        at_all_times(lambda part: part.expected(table.number, every)),
        at_all_times(lambda part: part.inputs(table.number, every)),
        min(after, key=abs, default=None),
        next((x.lost for _, x in parts if x.lost), ""),
    )


def lost_digits(digits: RowDigits, expected: Expectation) -> str:
    """That no digits are left, and after which time; empty where some are left throughout."""
    if not any(d is not None and d < LAST for d in digits):
        return ""
    return expected.lost if any(map(is_lost, digits, expected.bands)) else ""


# --- limits of a score ----------------------------------------------------------------------------


def limit_of(score: Score, part: str, expected: Expectation | None = None) -> Limit:
    """What limits the digits of the state, or of the attitude; none of what was not judged.

    Without ``expected`` UNKNOWN where the motion has to be known.  The rate at which an attitude
    goes wrong is the error of omega, and that of the state is what it was expected to be: so it is
    expected to lose the digits of the state, and those of the angle that was turned until then.
    """
    table, scene = score.subject, score.reference.scene
    digits = score.digits if part == STATE_PART else score.other_parts.get(part, ())
    there = [d for d in digits if d is not None]
    if not there:
        return NO_LIMIT
    worst, most = min(there), min(table.held, table.number.most_digits)
    if table.run is None and worst >= table.printed - 1:
        return PRINTED
    moments = [to_double(x) for x in scene.body.moments]
    at, thin = digits.index(worst), min(moments) < THIN * max(moments)
    band, inputs = (expected.bands[at], expected.inputs[at]) if expected else (None, None)
    times = score.rows_judged
    if part != STATE_PART:
        inputs, times = None, len(there)
        if band is not None:
            angle = 10.0**scene.log10_rate * abs(to_double(score.times[at]))
            band = band._replace(least=max(0.0, band.least - math.log10(1 + angle)))
    of_rounding = limit(worst, most, band, inputs, table.steps, times, thin, score.agreement)
    if part != STATE_PART or of_rounding.name != "method" or expected is None:
        return of_rounding
    off = time_rounding(score, expected)
    return of_rounding if off is None else Limit("rounding", f"of the times, by up to {off:.1g}")


def time_rounding(score: Score, expected: Expectation) -> float | None:
    """By how much rounded times are off at most, if that explains the digits; None if not.

    A row holds at a time that the table has rounded, such as a clock's late ones:
    :mod:`polhode.judging.tables.csv_file`.
    """
    table, scene, comparison = score.subject, score.reference.scene, score.comparison
    if not table.time_errors or comparison is None:
        return None
    judged = range(len(score.times)) if score.selected is None else score.selected.rows
    places = sorted({*few(len(judged), FOLLOWED), judged.index(score.lowest_row)})
    true = comparison.first_answer("at")  # for by a wrong number the motion could be of any speed
    rows = true.hi[places] if isinstance(true, Pairs) else [true[k] for k in places]
    numbers, chosen = doubles(rows), [judged[k] for k in places]
    with np.errstate(over="ignore", invalid="ignore"):  # of units in which doubles end
        speed = float(np.max(np.linalg.norm(numbers[:, :3], axis=1))) or 1.0
        rates = np.abs(field(scene)(0.0, numbers.T))
        omega, gamma = np.max(rates[:3], axis=0), np.max(rates[3:], axis=0, initial=0.0)
        off = np.array([table.time_errors[k] for k in chosen])
        moved = off * np.maximum(omega / speed, gamma)
    fewer = selected(len(score.times))
    least = [table.held if (e := expected.bands[k]) is None else e.least - fewer for k in chosen]
    digits = [table.held if (d := score.digits[k]) is None else d for k in chosen]
    errors, allowance = 10.0 ** -np.array([digits, least])
    right = bool(np.all(errors <= _MORE * (moved + allowance)))
    worst = int(np.argmax(errors))
    return float(np.max(off)) if right and errors[worst] <= _MOST * moved[worst] else None


# --- residuals ------------------------------------------------------------------------------------
#
# What is left of a table beside the reference: its size, its bias, and whether it is white noise.
#
# An attitude's residual is the rotation from the true attitude to the table's, as a vector along
# body axes.  Residuals are called white if three tests do not reject that at a significance of one
# in a hundred over all tests and columns: Ljung's and Box's of their autocorrelations, the runs of
# their signs about the median (Wald, Wolfowitz), and the ratio of the variances of their halves.


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
        rounded: Doubles = (Pairs(own.hi * signs[:, None], own.lo * signs[:, None]) - true).hi
        return rounded
    rows = zip(signs.tolist(), plain_rows(own), plain_rows(true), strict=True)
    gaps = [[*map(_difference, repeat(sign), mine, right)] for sign, mine, right in rows]
    return np.array(gaps, dtype=float)


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
