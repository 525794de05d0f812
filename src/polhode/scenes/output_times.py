"""Output times, exact: evenly spaced, or listed."""

from __future__ import annotations

import sys
from collections.abc import Iterable

from polhode.common.arguments import each
from polhode.numbers.exact import ZERO, Exact
from polhode.numbers.exact_sequences import ExactNumbers, spaced
from polhode.numbers.scalars import AnyNumber
from polhode.scenes.given_numbers import TIME, reader


def even_times(end: Exact, samples: int) -> ExactNumbers[Exact]:
    """The times end·k/(samples - 1), 0 and end included."""
    return spaced(ZERO, end, samples)


def listed_times(
    source: str, key: str, values: Iterable[AnyNumber], units: str = ""
) -> ExactNumbers[Exact]:
    """Times of any kind taken exactly; those of an array of doubles stay one.  Raises BadInput.

    ``units``: the scene's.
    """
    numpy = sys.modules.get("numpy")
    if numpy is not None and isinstance(values, numpy.ndarray):
        bare = type(values) is numpy.ndarray  # no masked one
        flat = bare and values.ndim == 1 and values.dtype == numpy.float64
        if flat and len(values) and bool(numpy.isfinite(values).all()):
            return ExactNumbers(floats=values.copy())
    return ExactNumbers(each(source, key, values, reader(units, TIME), "a list of times"))
