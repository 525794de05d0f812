"""The Euler angles psi, theta, phi of a closed form's attitude, psi and phi continuous in time."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from typing import Protocol, runtime_checkable

from polhode.closed_forms._winding.winding_number import (
    coarse_parameters,
    fine_parameters,
    growth,
    longest,
    too_far,
)
from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions, numpy_functions
from polhode.closed_forms.functions.quaternion import Quaternion, direction
from polhode.numbers.exact import EQUAL_BITS
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.rows import Complexes, Doubles
from polhode.numbers.scalars import Scalar


class Attitude(Protocol):
    """What the angles need of a closed form: its attitude at one precision."""

    @property
    def start(self) -> Quaternion:
        """The attitude at t = 0."""
        ...

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        ...

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar] | None:
        """Growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0; None: it is to be counted."""
        ...

    @property
    def speed(self) -> Scalar:
        """An upper bound of |w|."""
        ...


class TooFewBits(ArithmeticError):
    """Turns are known at any time, but not at so few bits."""


@runtime_checkable
class Countable(Attitude, Protocol):
    """An attitude whose turns can be counted in doubles, where they are not closed."""

    @property
    def fastest(self) -> Scalar:
        """An upper bound of the rates that the motion is made of."""
        ...

    @property
    def bend(self) -> Scalar | None:
        """A bound of the quaternion's second derivative over speed^2, where there is one."""
        ...

    def floats(self, speed: Scalar) -> Countable:
        """The same in doubles, time in units of 1/speed."""
        ...


#: Attitude at a number of bits.
Source = Callable[[int], Attitude]

_COUNTING_BITS = 384  # where the march passes near 0
_COARSE_BITS = 64
#: For the direction in which a pole is left: an error of 2^-64 is none to :func:`direction`, so
#: that the branch of psi and phi depends neither on the digits asked for nor on the time.
_POLE_BITS = 256


def angles(
    source: Source,
    times: Sequence[Callable[[int], mpf]],
    start: tuple[Scalar, Scalar],
    sign: int,
    bits: int,
) -> list[list[mpf | None]]:
    """Rows psi, theta, phi; psi and phi are None at a pole.

    ``times`` are numbers as functions of the precision; ``start`` holds psi and phi at t = 0, and
    ``sign`` says by which sign the attitude differs from the one that has those angles.
    """
    moved = [_parameters(source, time, bits) for time in times]
    grown = _growths(source, times, [used for *_, used in moved])
    rows: list[list[mpf | None]] = []
    for (al, bt, used), time, growths in zip(moved, times, grown, strict=True):
        with mpmath.workprec(used):
            theta = 2 * mpmath.atan2(abs(bt), abs(al))
            if not al or not bt or growths is None:
                rows.append([None, theta, None])
                continue
            begin = _start(source, time(used), start)
            args = []
            for z, first, more in zip((al, bt), begin, growths, strict=True):
                arg = mpmath.arg(sign * z)
                args.append(arg + 2 * mpmath.pi * mpmath.nint((first + more - arg) / 2 / mpmath.pi))
            rows.append([args[0] + args[1], theta, args[0] - args[1]])
    return rows


def _parameters(
    source: Source, time: Callable[[int], mpf], bits: int
) -> tuple[Scalar, Scalar, int]:
    """al, bt, and the precision that keeps the digits of the smaller one; 0 for an exact 0."""
    while True:
        with mpmath.workprec(bits):
            attitude, t = source(bits), time(bits)
            q0, q1, q2, q3 = attitude.at(t, MP) if t else attitude.start
            al, bt = mpmath.mpc(q0, q3), mpmath.mpc(q1, q2)
            lost = -int(mpmath.mag(min(abs(al), abs(bt)) or mpmath.eps))
        if lost < 32 or not t:
            return al, bt, bits
        if lost > bits // 2:
            if bits >= EQUAL_BITS:
                al, bt = (z if abs(z) > mpmath.ldexp(1, -bits // 2) else mpf(0) for z in (al, bt))
                return al, bt, bits
            bits *= 2
            continue
        needed = 64 * (lost // 64 + 1)
        with mpmath.workprec(bits + needed):
            q0, q1, q2, q3 = source(bits + needed).at(time(bits + needed), MP)
            return mpmath.mpc(q0, q3), mpmath.mpc(q1, q2), bits + needed


def _start(source: Source, t: mpf, start: tuple[Scalar, Scalar]) -> tuple[Scalar, Scalar]:
    """arg al and arg bt at t = 0; from a pole, their limit on the side of t."""
    psi, phi = start
    q0, q1, q2, q3 = source(mpmath.prec).start
    al, bt = mpmath.mpc(q0, q3), mpmath.mpc(q1, q2)
    one, other = (psi + phi) / 2, (psi - phi) / 2
    if al and bt:
        return one, other
    bits = max(mpmath.prec, _POLE_BITS)
    with mpmath.workprec(bits):
        attitude = source(bits)
        speed = attitude.speed
        soon = mpmath.sign(t) * mpmath.ldexp(1, -bits // 4) / speed if speed else mpf(0)
        q0, q1, q2, q3 = attitude.at(soon, MP)
        if not bt:
            return one, one + direction(mpmath.mpc(q1, q2) * al.conjugate())
        return other + direction(mpmath.mpc(q0, q3) * bt.conjugate()), other


def _closed(source: Source, time: Callable[[int], mpf], bits: int) -> tuple[Scalar, Scalar] | None:
    """The growth of both arguments where it is closed, with as many bits as it asks for."""
    while True:
        with mpmath.workprec(bits), contextlib.suppress(TooFewBits):
            return source(bits).arguments(time(bits))
        bits *= 2


def _growths(
    source: Source, times: Sequence[Callable[[int], mpf]], bits: Sequence[int]
) -> list[tuple[Scalar, Scalar] | None]:
    """Growth of arg al and arg bt from t = 0: closed where it can be, else counted."""
    found: list[tuple[Scalar, Scalar] | None] = []
    open_ = []
    for i, (time, used) in enumerate(zip(times, bits, strict=True)):
        found.append(_closed(source, time, used))
        if found[-1] is None:
            open_.append(i)
        elif None in found[-1]:
            found[-1] = None
    if not open_:
        return found
    used = max(_COUNTING_BITS, *(bits[i] for i in open_))
    with mpmath.workprec(used):
        attitude, rough, fn = source(used), source(_COARSE_BITS), numpy_functions()
        assert isinstance(attitude, Countable)
        assert isinstance(rough, Countable)
        speed = attitude.speed
        coarse = rough.floats(speed)

        def fine(t: mpf) -> tuple[Scalar, Scalar]:
            return fine_parameters(attitude.at(t / speed, MP))

        def many(t: Doubles) -> tuple[Complexes, Complexes]:
            return coarse_parameters(coarse.at(t, fn))

        scaled = {i: times[i](used) * speed for i in open_}
        # No phase may outgrow the digits of a double; of a physical body none outruns |w|.
        limit = longest() * speed / attitude.fastest
        if max(abs(t) for t in scaled.values()) > limit:
            raise too_far(limit / speed)
        for side in (1, -1):
            chosen = sorted(
                (i for i in open_ if side * scaled[i] >= 0), key=lambda i: side * scaled[i]
            )
            counts = growth(fine, many, [scaled[i] for i in chosen], attitude.bend)
            for i, count in zip(chosen, counts, strict=True):
                found[i] = count
    return found
