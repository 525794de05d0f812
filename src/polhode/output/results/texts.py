"""A column of a table as texts that give back the same numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from polhode.numbers.conversion import exactly
from polhode.numbers.decimals import decimal_string, in_full
from polhode.numbers.exact import Exact


def text_of(column: Sequence[Any]) -> list[str]:
    """The texts; an mpf has the digits of the column's widest one, no number is empty."""
    digits = 0
    for x in column:
        if hasattr(x, "_mpf_"):
            digits = max(digits, 1 + math.ceil(max(x._mpf_[3], 53) * math.log10(2)))
    return [_text(x, digits) for x in column]


def _text(x: Any, digits: int) -> str:
    if x is None or (isinstance(x, (float, np.floating)) and x != x):
        return ""
    if isinstance(x, (bool, np.bool_)):
        return str(bool(x)).lower()
    if hasattr(x, "_mpf_"):
        return decimal_string(exactly(x), digits)
    if isinstance(x, (Fraction, Exact)):
        return in_full(exactly(x))
    if isinstance(x, float):  # numpy's doubles, too
        return repr(float(x))
    if isinstance(x, np.floating):
        return str(np.format_float_scientific(x, unique=True))
    text = str(x)
    return '"' + text.replace('"', '""') + '"' if "," in text or '"' in text else text
