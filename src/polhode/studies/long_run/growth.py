"""Growth of an ensemble's errors with time: medians, mean and spread, the exponent of a power law.

The exponent is the slope of log10 of the ensemble's median (or standard deviation) over log10 t, by
least squares, every time weighted by the inverse variance of its median; variances and the
exponent's uncertainty come from the same bootstrap over whole members, since the times of one
member are not independent.  Efron & Tibshirani, An Introduction to the Bootstrap, 1993.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

RESAMPLES = 400


class Exponent(NamedTuple):
    """A fitted exponent and that of the last decade alone, each with its standard error."""

    value: float
    uncertainty: float
    last_decade: float
    last_uncertainty: float


def medians(members: Sequence[Sequence[float]]) -> list[float]:
    """The median over the members at each time; ``members``: one row of errors a member."""
    import numpy as np

    return [float(x) for x in np.median(np.array(members), axis=0)]


def means(members: Sequence[Sequence[float]]) -> list[float]:
    """The mean over the members at each time."""
    import numpy as np

    return [float(x) for x in np.mean(np.array(members), axis=0)]


def deviations(members: Sequence[Sequence[float]]) -> list[float]:
    """The standard deviation about the mean at each time, of a sample: n - 1."""
    import numpy as np

    return [float(x) for x in np.std(np.array(members), axis=0, ddof=1)]


def exponent(
    times: Sequence[float], members: Sequence[Sequence[float]], since: float
) -> Exponent | None:
    """The exponent of the median's growth from ``since`` on; None where it is zero somewhere."""
    import numpy as np

    return _fitted(times, members, since, np.median)


def exponent_of_deviation(
    times: Sequence[float], members: Sequence[Sequence[float]], since: float
) -> Exponent | None:
    """The same of the standard deviation's growth."""
    import numpy as np

    return _fitted(times, members, since, np.std)


def _fitted(
    times: Sequence[float],
    members: Sequence[Sequence[float]],
    since: float,
    middle_of: Callable[..., Any],
) -> Exponent | None:
    import numpy as np

    kept = np.array(times) >= since
    x, y = np.log10(np.array(times))[kept], np.array(members)[:, kept]
    if kept.sum() < 3 or (middle_of(y, axis=0) <= 0).any():
        return None
    drawn = np.random.default_rng(1).integers(0, len(y), (RESAMPLES, len(y)))
    samples = np.log10(np.maximum(middle_of(y[drawn], axis=1), np.finfo(float).tiny))
    weights = 1 / np.maximum(samples.var(axis=0), 1e-6)
    middle = np.log10(middle_of(y, axis=0))
    slopes = [_slope(x, sample, weights) for sample in samples]
    last = x >= x[-1] - 1 - 1e-9
    late = [_slope(x[last], sample[last], weights[last]) for sample in samples]
    return Exponent(
        _slope(x, middle, weights),
        float(np.std(slopes, ddof=1)),
        _slope(x[last], middle[last], weights[last]),
        float(np.std(late, ddof=1)),
    )


def _slope(x: Any, y: Any, weights: Any) -> float:
    """The slope of a weighted line through the points."""
    centre = (weights * x).sum() / weights.sum()
    return float((weights * (x - centre) * y).sum() / (weights * (x - centre) ** 2).sum())
