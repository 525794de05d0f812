"""The Euler angles psi, theta, phi of a closed form's attitude, psi and phi continuous in time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, direction
from polhode.numbers.exact import EQUAL_BITS
from polhode.numbers.mpmath_context import mpf, mpmath
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

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """Growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0; None of one always 0."""
        ...

    @property
    def speed(self) -> Scalar:
        """An upper bound of |w|."""
        ...


#: Attitude at a number of bits.
Source = Callable[[int], Attitude]

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
    rows: list[list[mpf | None]] = []
    for (al, bt, used), time in zip(moved, times, strict=True):
        with mpmath.workprec(used):
            growths = source(used).arguments(time(used))
            theta = 2 * mpmath.atan2(abs(bt), abs(al))
            if not al or not bt or None in growths:
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
