"""Ticks of logarithmic axes: two labels at least, each a number that is read at once."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axis import Axis

RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PLAIN = (1e-4, 1e4)  # numbers between these are written out
_NEAR = 1e-9  # of a limit: it is a tick, too
_MOST = 7  # labels of an axis
_EVERY = (1, 2, 3, 5, 10, 20, 50, 100, 200, 500)  # decades from a label to the next
_OF_DECADE: tuple[tuple[int, ...], ...] = ((1,), (1, 3), (1, 2, 5))  # or labels of each


def set_ticks(axis: Axis, scale: str) -> None:
    """Label an axis of matplotlib of scale log or symlog, which has its final limits."""
    from matplotlib.ticker import NullFormatter

    low, high = sorted(axis.get_view_interval())
    values = ticks(low, high) if scale == "log" else ticks_about_0(low, high)
    axis.set_ticks(values, names(values))
    axis.set_minor_formatter(NullFormatter())


def ticks_about_0(low: float, high: float) -> list[float]:
    """0, 1, 10, ... and their negatives.

    >>> ticks_about_0(-2.5, 30)
    [-1.0, 0.0, 1.0, 10.0]
    """
    powers = [10.0**k for k in range(9)]
    return [x for x in (*(-p for p in powers[::-1]), 0.0, *powers) if low <= x <= high]


def ticks(low: float, high: float) -> list[float]:
    """Powers of ten, evenly spaced; of fewer decades their parts, of a narrow range round numbers.

    >>> ticks(0.5, 2e4)
    [1.0, 10.0, 100.0, 1000.0, 10000.0]
    >>> ticks(1e-40, 1)
    [1e-40, 1e-30, 1e-20, 1e-10, 1.0]
    >>> ticks(0.9, 25)
    [1.0, 2.0, 5.0, 10.0, 20.0]
    """
    first, last = math.ceil(math.log10(low) - _NEAR), math.floor(math.log10(high) + _NEAR)
    if last - first >= 2:
        step = next(x for x in _EVERY if last - first < x * _MOST)
        return [10.0**k for k in range(-(-first // step) * step, last + 1, step)]
    found: list[float] = []
    for of_decade in _OF_DECADE:
        parts = [float(f"{m}e{k}") for k in range(first - 1, last + 1) for m in of_decade]
        found = [x for x in parts if low * (1 - _NEAR) <= x <= high * (1 + _NEAR)] or found
        if len(found) > _MOST / 2:
            break
    if len(found) > 1:
        return found
    from matplotlib.ticker import MaxNLocator

    unit = 10.0 ** math.floor(math.log10(low))
    even = MaxNLocator(4).tick_values(low / unit, high / unit)
    return [float(x) * unit for x in even if low <= x * unit <= high]


def names(values: list[float]) -> list[str]:
    """The labels of ticks, all written in one way.

    >>> names([0.01, 1.0, 100.0]), names([1e-12, 3e-11])
    (['0.01', '1', '100'], ['10⁻¹²', '3·10⁻¹¹'])
    """
    if all(x == 0 or _PLAIN[0] <= abs(x) <= _PLAIN[1] for x in values):
        return [f"{x:g}".replace("-", "−") for x in values]
    return [_power(x) for x in values]


def _power(x: float) -> str:
    exponent = math.floor(math.log10(x) + _NEAR)
    factor = f"{x / 10.0**exponent:.6g}"
    power = "10" + str(exponent).translate(RAISED)
    return power if factor == "1" else f"{factor}·{power}"
