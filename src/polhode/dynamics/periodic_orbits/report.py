"""A periodic orbit for people: of each number the digits that are known."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from polhode.common.errors import counted
from polhode.dynamics.periodic_orbits import high_precision
from polhode.numbers import exact
from polhode.numbers.conversion import exactly
from polhode.numbers.decimals import decimal_string, in_full, shown
from polhode.numbers.exact import Exact

#: An orbit, whose class imports this.
Orbit = Any


def report(orbit: Orbit) -> str:
    """Start, period and stability, a line each."""
    more = orbit.digits + 2
    gamma = orbit.scene.gamma or ()
    residue = _known(exactly(orbit.residue), orbit.residue_error, orbit.digits)
    lines = [
        f"period      {_decimal(orbit.period, more)}",
        f"omega       {', '.join(_decimal(x, more) for x in orbit.scene.omega)}",
        f"gamma       {', '.join(_placed(x, more) for x in gamma)}",
        f"level       h = {shown(orbit.h)}, f = {shown(orbit.f)}",
        f"residue     {residue}, {orbit.kind}",
    ]
    for real, imaginary in _multipliers(orbit):
        sign = "-" if imaginary.startswith("-") else "+"
        side = f" {sign} {imaginary.lstrip('-')} i" if imaginary != "0" else ""
        lines.append(f"multiplier  {real}{side}")
    return "\n".join([*lines, f"psi         {_advance(orbit)}"])


def _advance(orbit: Orbit) -> str:
    error = orbit.psi_error  # 0 beyond the range of doubles
    digits = math.floor(-math.log10(error)) if error else orbit.digits - 2
    places = min(orbit.digits, digits)
    if orbit.psi is None or places < 1:
        return "not known"
    closes = "the motion in space does not close in few periods"
    if orbit.digits < high_precision.DIGITS_OF_TURNS:
        closes = "too few digits to tell whether the motion in space closes"
    if orbit.turns is not None:
        count = counted(orbit.turns.denominator, "period")
        closes = f"the motion in space closes after {count}"
    return f"{_placed(exactly(orbit.psi), places)} per period; {closes}"


def _multipliers(orbit: Orbit) -> list[tuple[str, str]]:
    """Real and imaginary part of both, with the digits that are known."""
    pairs, most = [], orbit.digits
    for parts in orbit.multipliers:
        real, imaginary = map(exactly, parts)
        one, size = complex(*map(float, parts)), max(1.0, abs(float(real)))
        # mu - 1/mu divides the error of mu + 1/mu = 2 - 4R; near +-1 its root is taken
        apart = abs(one - 1 / one)
        error = 4 * orbit.residue_error * size / max(apart, math.sqrt(orbit.residue_error))
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
