"""What the golden comparison writes down, exactly, and how two of its files differ.

A record is plain JSON.  Every real number is text: ``0x3p-1`` is 3/2, ``1/3`` a third, and so the
record of a double, of a long double or of an mpf holds all of its bits and nothing of its type.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence, Set
from enum import Enum
from fractions import Fraction
from typing import Any, NamedTuple

_BINARY = re.compile(r"(-?)0x([0-9a-f]+)p([+-]\d+)")
_QUOTIENT = re.compile(r"-?\d+/\d+")
DOUBLE_BITS = 53


def told(value: Any) -> Any:
    """A value as JSON: containers of any kind, words, and numbers as exact text."""
    if value is None or isinstance(value, str):
        return value
    if type(value).__name__ in ("bool", "bool_"):  # Python's and numpy's
        return bool(value)
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, Mapping):
        return {str(key): told(one) for key, one in value.items()}
    if hasattr(value, "_asdict"):
        return told(value._asdict())
    if isinstance(value, complex):
        return [told(value.real), told(value.imag)]
    if hasattr(value, "tolist") and getattr(value, "shape", ()):
        return [told(one) for one in value]  # by element: ``tolist`` would round long doubles
    if isinstance(value, Sequence):
        return [told(one) for one in value]
    if isinstance(value, Set):
        return sorted(told(one) for one in value)
    return number(value)


def number(value: Any) -> str:
    """A real number as exact text; what has no digits to its end is asked for 200 bits."""
    if hasattr(value, "_mpf_"):
        return str(value).lstrip("+") if value - value != 0 else _of_raw(value._mpf_)
    if isinstance(value, int) or hasattr(value, "__index__"):
        return str(int(value))
    if not isinstance(value, Fraction) and hasattr(value, "as_integer_ratio"):
        if value - value != 0:  # inf, nan
            return str(float(value))
        if value == 0:
            return ("-" if math.copysign(1, value) < 0 else "") + "0x0p+0"
        value = Fraction(*map(int, value.as_integer_ratio()))
    if isinstance(value, Fraction):
        top, bottom = value.numerator, value.denominator
        if bottom & (bottom - 1):
            return f"{top}/{bottom}"
        return _binary(top < 0, abs(top), 1 - bottom.bit_length())
    if hasattr(value, "enclosure"):
        return _near(value.enclosure(200))
    raise TypeError(f"no exact text of a {type(value).__name__}")


def _of_raw(number: tuple[int, Any, Any, int]) -> str:
    """Of a finite number as mpmath keeps it."""
    sign, mantissa, exponent, _ = number
    return _binary(bool(sign), int(mantissa), int(exponent))


def _near(enclosure: Any) -> str:
    """What a ball, or an interval of mpmath's, is around, to 150 bits."""
    if isinstance(enclosure, tuple):
        sign, mantissa, exponent, _ = enclosure[0]
        mantissa = -mantissa if sign else mantissa
    else:
        mantissa, exponent = enclosure.mid().man_exp()
    mantissa, exponent = int(mantissa), int(exponent)
    spare = mantissa.bit_length() - 150
    if spare > 0:
        mantissa, exponent = (mantissa + (1 << (spare - 1))) >> spare, exponent + spare
    return "~" + _binary(mantissa < 0, abs(mantissa), exponent)


def _binary(negative: bool, mantissa: int, exponent: int) -> str:
    """The mantissa odd, so that equal numbers have one text."""
    if mantissa:
        even = (mantissa & -mantissa).bit_length() - 1
        mantissa, exponent = mantissa >> even, exponent + even
    else:
        exponent = 0
    return f"{'-' if negative else ''}{mantissa:#x}p{exponent:+d}"


def read(text: object) -> Fraction | None:
    """The number of a text of :func:`number`; None for any other."""
    if not isinstance(text, str):
        return None
    if found := _BINARY.fullmatch(text):
        sign, mantissa, exponent = found.groups()
        value = int(mantissa, 16) * Fraction(2) ** int(exponent)
        return -value if sign else value
    return Fraction(text) if _QUOTIENT.fullmatch(text) else None


def ulps(one: Fraction, two: Fraction, bits: int) -> float:
    """How far apart, in units of the last of so many bits of the larger one."""
    size = max(abs(one), abs(two))
    if size == 0:
        return 0.0  # 0 and -0
    exponent = size.numerator.bit_length() - size.denominator.bit_length()
    if size < Fraction(2) ** exponent:
        exponent -= 1
    return float(min(abs(one - two) / Fraction(2) ** (exponent + 1 - bits), Fraction(10) ** 300))


class Difference(NamedTuple):
    """One entry that is not the same: how many leaves differ, and the worst or first of them.

    ``ulps``: of the numbers among them, the largest; None where none can be measured so.
    """

    part: str
    entry: str
    what: str
    count: int
    ulps: float | None

    def __str__(self) -> str:
        far = "" if self.ulps is None else f", up to {self.ulps:.3g} ulp"
        many = "1 difference" if self.count == 1 else f"{self.count} differences"
        return f"{self.part}: {self.entry}: {many}{far}: {self.what}"


def differences(one: Mapping[str, Any], two: Mapping[str, Any]) -> Iterator[Difference]:
    """Every entry of either record that is not the same in the other."""
    for part in sorted({*one, *two}):
        if part not in one or part not in two:
            which = "first" if part not in one else "second"
            yield Difference(part, "all", f"missing in the {which}", 1, None)
            continue
        for entry in sorted({*one[part], *two[part]}):
            if entry not in one[part] or entry not in two[part]:
                which = "first" if entry not in one[part] else "second"
                yield Difference(part, entry, f"missing in the {which}", 1, None)
            elif one[part][entry] != two[part][entry]:
                yield _of_entry(part, entry, one[part][entry], two[part][entry])


def _of_entry(part: str, entry: str, one: Any, two: Any) -> Difference:
    bits = one.get("bits", DOUBLE_BITS) if isinstance(one, Mapping) else DOUBLE_BITS
    found = [(path, a, b, _apart(a, b, int(bits))) for path, a, b in _leaves(one, two)]
    measured = [far for *_, far in found if far is not None]
    unlike = [leaf for leaf in found if leaf[3] is None]
    path, a, b, _ = unlike[0] if unlike else max(found, key=lambda leaf: leaf[3])
    what = f"{path or 'value'}: {_short(a)} and {_short(b)}"
    return Difference(part, entry, what, len(found), max(measured, default=None))


def _apart(one: Any, two: Any, bits: int) -> float | None:
    first, second = read(one), read(two)
    return None if first is None or second is None else ulps(first, second, bits)


_MISSING = "nothing"


def _leaves(one: Any, two: Any, path: str = "") -> Iterator[tuple[str, Any, Any]]:
    """The leaves in which two values differ; what one of them has more is a leaf."""
    if isinstance(one, Mapping) and isinstance(two, Mapping):
        for key in sorted({*one, *two}):
            below = f"{path}.{key}" if path else key
            yield from _leaves(one.get(key, _MISSING), two.get(key, _MISSING), below)
    elif isinstance(one, list) and isinstance(two, list):
        for k in range(max(len(one), len(two))):
            pair = (x[k] if k < len(x) else _MISSING for x in (one, two))
            yield from _leaves(*pair, f"{path}[{k}]")
    elif one != two or type(one) is not type(two):
        yield path, one, two


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 100 else text[:97] + "..."
