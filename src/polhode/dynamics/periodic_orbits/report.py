"""A periodic orbit for people: of each number the digits that are known."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from polhode.common.text_tables import counted
from polhode.dynamics.periodic_orbits import high_precision
from polhode.numbers import exact
from polhode.numbers.conversion import exactly
from polhode.numbers.decimals import decimal_string, in_full, shown
from polhode.numbers.exact import Exact

#: An orbit, whose class imports this.
Orbit = Any


def report(found: Orbit) -> str:
    """Start, period and stability, a line each."""
    more = found.digits + 2
    gamma = found.scene.gamma or ()
    residue = _known(exactly(found.residue), found.residue_error, found.digits)
    lines = [
        f"period      {_decimal(found.period, more)}",
        f"omega       {', '.join(_decimal(x, more) for x in found.scene.omega)}",
        f"gamma       {', '.join(_placed(x, more) for x in gamma)}",
        f"level       h = {shown(found.h)}, f = {shown(found.f)}",
        f"residue     {residue}, {found.kind}",
    ]
    for real, imaginary in _multipliers(found):
        sign = "-" if imaginary.startswith("-") else "+"
        side = f" {sign} {imaginary.lstrip('-')} i" if imaginary != "0" else ""
        lines.append(f"multiplier  {real}{side}")
    return "\n".join([*lines, f"psi         {_advance(found)}"])


def _advance(found: Orbit) -> str:
    error = found.psi_error  # 0 beyond the range of doubles
    known = math.floor(-math.log10(error)) if error else found.digits - 2
    places = min(found.digits, known)
    if found.psi is None or places < 1:
        return "not known"
    closes = "the motion in space does not close in few periods"
    if found.digits < high_precision.DIGITS_OF_TURNS:
        closes = "too few digits to tell whether the motion in space closes"
    if found.turns is not None:
        count = counted(found.turns.denominator, "period")
        closes = f"the motion in space closes after {count}"
    return f"{_placed(exactly(found.psi), places)} per period; {closes}"


def _multipliers(found: Orbit) -> list[tuple[str, str]]:
    """Real and imaginary part of both, with the digits that are known."""
    pairs, most = [], found.digits
    for parts in found.multipliers:
        real, imaginary = map(exactly, parts)
        one, size = complex(*map(float, parts)), max(1.0, abs(float(real)))
        # mu - 1/mu divides the error of mu + 1/mu = 2 - 4R; near +-1 its root is taken
        apart = abs(one - 1 / one)
        error = 4 * found.residue_error * size / max(apart, math.sqrt(found.residue_error))
        pairs.append((_known(real, error, most), _known(imaginary, error, most)))
    return pairs


def _decimal(x: Exact, digits: int) -> str:
    """x to so many digits: its own where it has no more."""
    if isinstance(x, Fraction):
        text = in_full(x)
        if "/" not in text and len(text.strip("-0.")) <= digits:
            return text
    return decimal_string(exact.binary(*exact.rounded(x, 4 * digits + 8)), digits)


def _placed(x: Exact, digits: int) -> str:
    """A component of a unit vector to so many places."""
    near = exact.binary(*exact.rounded(x, 4 * digits + 8)) if x else Fraction(0)
    return high_precision.decimal(near, Fraction(1), digits)


def _known(x: Fraction, error: float, most: int) -> str:
    """x as far as an error leaves digits, and no more than so many; 0 where it leaves none."""
    if not x:
        return "0"
    left = math.floor(exact.log10(abs(x)) - math.log10(error))
    return decimal_string(x, min(left, most)) if left >= 1 else "0"
