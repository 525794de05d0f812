"""Numbers of mpmath as FLINT's exact balls, and the middles of balls as numbers.

Long sums run in balls of some bits more than the precision in force: one operation costs a tenth
of mpmath's.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import flint
from mpmath import libmp

from polhode.common.locks import Held
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

#: An arb or an acb.
Ball: TypeAlias = Any

SPARE = 24  # bits of sums in balls beyond the precision in force


def more_bits() -> Held:
    """``with more_bits()``: balls of the precision in force and some bits more."""
    return ctx.workprec(mpmath.prec + SPARE)


def ball(x: Scalar) -> Ball:
    """An mpf as an exact arb, an mpc as an exact acb."""
    if isinstance(x, mpc):
        return flint.acb(_real_ball(x.real), _real_ball(x.imag))
    return _real_ball(mpf(x))


def middle(x: Ball) -> Scalar:
    """The midpoint of an arb as mpf, of an acb as mpc."""
    if isinstance(x, flint.acb):
        return mpc(_real_middle(x.real), _real_middle(x.imag))
    return _real_middle(x)


def _real_ball(x: Scalar) -> Ball:
    sign, mantissa, exponent, _ = x._mpf_
    return flint.arb((-int(mantissa) if sign else int(mantissa), int(exponent)))


def _real_middle(x: Ball) -> Scalar:
    mantissa, exponent = x.mid().man_exp()
    return mpmath.make_mpf(libmp.from_man_exp(int(mantissa), int(exponent)))
