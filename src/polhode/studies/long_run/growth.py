"""Growth of an ensemble's errors with time: medians, mean and spread, the exponent of a power law.

The exponent is the slope of log10 of the ensemble's median (or standard deviation) over log10 t, by
least squares, every time weighted by the inverse variance of its median; variances and the
exponent's uncertainty come from the same bootstrap over whole members, since the times of one
member are not independent.  Efron & Tibshirani, An Introduction to the Bootstrap, 1993.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

RESAMPLES = 400


class Exponent(NamedTuple):
    """A fitted exponent and that of the last decade alone, each with its standard error."""

    exponent: float
    uncertainty: float
    last_decade: float
    last_uncertainty: float


def exponent(
    times: Sequence[float],
    members: Sequence[Sequence[float]],
    since: float,
    middle_of: Callable[..., Any] = np.median,
) -> Exponent | None:
    """The exponent of the median's growth from ``since`` on; None where it is zero somewhere.

    ``members``: one row of errors a member.  ``middle_of``: numpy's function that grows.
    """
    kept = np.array(times) >= since
    x, y = np.log10(np.array(times))[kept], np.array(members)[:, kept]
    if kept.sum() < 3 or (middle_of(y, axis=0) <= 0).any():
        return None
    drawn = np.random.default_rng(1).integers(0, len(y), (RESAMPLES, len(y)))
    samples = np.log10(np.maximum(middle_of(y[drawn], axis=1), np.finfo(float).tiny))
    weights = 1 / np.maximum(samples.var(axis=0), 1e-6)
    middle = np.log10(middle_of(y, axis=0))
    last = x >= x[-1] - 1 - 1e-9
    found = []
    for part in (slice(None), last):
        slopes = [_slope(x[part], sample[part], weights[part]) for sample in samples]
        found += [_slope(x[part], middle[part], weights[part]), float(np.std(slopes, ddof=1))]
    return Exponent(*found)


def _slope(x: Any, y: Any, weights: Any) -> float:
    """The slope of a weighted line through the points."""
    centre = (weights * x).sum() / weights.sum()
    return float((weights * (x - centre) * y).sum() / (weights * (x - centre) ** 2).sum())
