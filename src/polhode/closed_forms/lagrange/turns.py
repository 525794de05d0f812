"""Turns of psi and phi of a Lagrange top about any axis of the scene, at any time.

In the scene's axes al and bt are sums x al_top + y bt_top (:mod:`.attitude`) of two terms of known
arguments.  They are equally large where |x|^2 (1 + u) = |y|^2 (1 - u), u = u1 + (u2 - u1) sn^2 v,
which is at most twice in half a period of dn.
"""

from __future__ import annotations

from typing import Any

from polhode.closed_forms._winding.argument_of_sum import Crossing, Polar, Sum, Terms, Turning
from polhode.closed_forms.functions.jacobi import MP
from polhode.closed_forms.lagrange.motion import Nutating, Parameter, Parts
from polhode.numbers.mpmath_context import mpc, mpmath


def turning(motion: Nutating, row: tuple[Parts, Parts]) -> Turning | None:
    """The argument of the row's sum; None where neither term ever takes the lead from the other."""
    factors = mpc(*row[0]), mpc(*row[1])
    places = _places(motion, abs(factors[0]), abs(factors[1]))
    if not places:
        return None

    def terms(v: Any) -> Terms:
        one, two = (_polar(motion, z, v) for z in (motion.al, motion.bt))
        return one.times(factors[0]), two.times(factors[1])

    advances = 2 * motion.al.jump, 2 * motion.bt.jump
    whole = Sum(terms, advances, 1 if places[0].rises else 0, places)
    return Turning(whole, motion, (motion.al.rate, motion.bt.rate))


def _polar(motion: Nutating, z: Parameter, v: Any) -> Polar:
    """al or bt at a phase, without what turns evenly in time."""
    waves = motion.elliptic.waves(v, MP)
    x, y = z.shift.at(waves)
    modulus = mpmath.hypot(x, y) / motion.elliptic.denominator(waves)
    argument = z.jump * waves.turns + z.sense * mpmath.atan2(y, x)
    return Polar(modulus, argument).times(mpc(*z.factor))


def _places(motion: Nutating, one: Any, other: Any) -> tuple[Crossing, ...]:
    """Where the first term takes or loses the lead: |al|^2 rises with sn^2."""
    elliptic = motion.elliptic
    # |al|^2 at v = 0, and at v = K or in the limit of a separatrix, where bt is 0.
    low = _polar(motion, motion.al, mpmath.zero).modulus ** 2
    finite = mpmath.isfinite(elliptic.K)
    high = _polar(motion, motion.al, elliptic.K).modulus ** 2 if finite else mpmath.one
    equal = other**2 / (one**2 + other**2)
    part = (equal - low) / (high - low)  # sn^2
    if not 0 < part < 1:
        return ()
    k2 = 1 - elliptic.functions(elliptic.waves(elliptic.K, MP))[2] ** 2 if finite else mpmath.one
    sn, cn, dn = mpmath.sqrt(part), mpmath.sqrt(1 - part), mpmath.sqrt(1 - k2 * part)
    v, slope = sn * mpmath.elliprf(1 - part, 1 - k2 * part, 1), 2 * sn * cn * dn * (high - low)
    if not finite:
        return Crossing(-v, -slope), Crossing(v, slope)
    K = elliptic.K
    phases = (v, slope), (2 * K - v, -slope), (2 * K + v, slope), (4 * K - v, -slope)
    return tuple(Crossing(*phase) for phase in phases)
