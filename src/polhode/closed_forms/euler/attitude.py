"""The attitude of the torque-free body at one precision, and where its two arguments are closed.

R (body -> space, z up) = Rz(psi) Rx(theta) Rz(phi) is the quaternion of the Cayley-Klein parameters

    al = q0 + i q3 = cos(theta/2) exp i(psi + phi)/2,
    bt = q1 + i q2 = sin(theta/2) exp i(psi - phi)/2,

so the continuous psi and phi are the sum and difference of the continuous arg al and arg bt.
Seen from G, the numbered axes have Cayley-Klein parameters whose arguments are known for all time;
al and bt are real-linear in those two.  While one of the four terms outweighs the others, its
argument counts the turns.  That covers every motion with gamma along G in principal axes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from polhode.closed_forms.attitude.axes import MotionAxes
from polhode.closed_forms.attitude.quaternion import Quaternion, conjugate, of_matrix, product
from polhode.closed_forms.attitude.settled import Repeating, Settled
from polhode.closed_forms.attitude.winding import coarse_parameters, fine_parameters, growth
from polhode.closed_forms.euler.motion import EulerMotion, PermanentRotation, Polhode
from polhode.closed_forms.euler.turns import PolhodeTurns
from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions, numpy_functions
from polhode.numbers.private import mpf, mpmath


@dataclass(frozen=True)
class EulerAttitude:
    """The quaternion body -> space as a function of time."""

    motion: EulerMotion
    axes: MotionAxes
    start: Quaternion

    def at(self, t: Any, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        c, x, y, z = self.motion.state(t, fn)[1]
        return self.after((c, x, y, z))

    def floats(self, speed: Any) -> EulerAttitude:
        """The same in doubles, time in units of 1/speed."""
        a, b, c, d = (float(x) for x in self.start)
        return EulerAttitude(self.motion.floats(speed), self.axes.mapped(float), (a, b, c, d))

    @property
    def speed(self) -> Any:
        """An upper bound of |w| over all time."""
        if isinstance(self.motion, PermanentRotation):
            return 2 * self.motion.half
        return speed_bound(self.motion)

    @property
    def fastest(self) -> Any:
        """An upper bound of the rates that the motion is made of."""
        if isinstance(self.motion, PermanentRotation):
            return 2 * self.motion.half
        return max(self.speed, self.motion.rate, abs(self.motion.precession))

    @property
    def bend(self) -> None:
        """No bound of the quaternion's second derivative is known here."""

    def arguments(self, t: Any) -> tuple[Any, Any] | None:
        """The growth of arg al and arg bt from time 0 to t, where it is closed; else None.

        None for an argument whose parameter is always 0.
        """
        if isinstance(self.motion, PermanentRotation):
            one = self.start
            other = self.after((0, *self.motion.axis))
            x = self.motion.half * t
            return (
                _along_ellipse(mpmath.mpc(one[0], one[3]), mpmath.mpc(other[0], other[3]), x),
                _along_ellipse(mpmath.mpc(one[1], one[2]), mpmath.mpc(other[1], other[2]), x),
            )
        if mpmath.isfinite(self.motion.elliptic.K):
            return self._turned(t)
        terms = self._terms(self.motion)
        grown = [_dominated(row, self.motion, t) for row in terms]
        if grown[0] is None or grown[1] is None:
            return self._beyond(t)
        return grown[0], grown[1]

    def _turned(self, t: Any) -> tuple[Any, Any] | None:
        """The growth of both arguments where the polhode is closed; None: it is to be counted."""
        begin = mpf(0)
        if not all(fine_parameters(self.start)):  # from a pole on, arguments begin with their limits
            begin = mpmath.sign(t) * mpmath.ldexp(1, -mpmath.prec // 4) / self.speed
        try:
            return self._turns.growth(begin, t)
        except ArithmeticError:
            return None

    @cached_property
    def _turns(self) -> PolhodeTurns:
        assert isinstance(self.motion, Polhode)
        columns = [self.axes.scene(unit) for unit in _AXES]
        turn = of_matrix(list(zip(*columns, strict=True)))
        left = product(product(self.start, turn), self.motion.start)
        return PolhodeTurns(self.motion, left, conjugate(turn))

    def _beyond(self, t: Any) -> tuple[Any, Any] | None:
        """The growth on a separatrix, where the rotation that it tends to has been reached.

        That is one about the middle axis, which then lies along G: the period is its turn.
        """
        motion = self.motion
        assert isinstance(motion, Polhode)
        edge = (_SURE * mpmath.ln2 + abs(motion.v0)) / motion.rate
        settled = Settled(edge, 2 * mpmath.pi / abs(motion.omega[1]), mpmath.mpf(0))
        if not settled.reached(t):
            return None
        return Repeating(self._counted, settled).growth(t)

    def _counted(self, t: Any) -> tuple[float, float]:
        """The growth of both arguments from 0 to t, counted along the motion."""
        speed, fn = self.speed, numpy_functions()
        coarse = self.floats(speed)
        (found,) = growth(
            lambda s: fine_parameters(self.at(s / speed, MP)),
            lambda s: coarse_parameters(coarse.at(s, fn)),
            [t * speed],
        )
        return found

    def after(self, turn: Quaternion) -> Quaternion:
        """The attitude after a turn from the start; linear in the turn."""
        c, *axis = turn
        x, y, z = self.axes.scene(axis)
        return product(self.start, (c, x, y, z))

    def _terms(self, motion: Polhode) -> tuple[list[Any], list[Any]]:
        """al and bt as x1 al' + x2 conj al' + x3 bt' + x4 conj bt', seen from G; the rows x."""
        images = [self.after(product(motion.start, unit)) for unit in _UNITS]
        rows = []
        for re, im in ((0, 3), (1, 2)):
            r, i, j, k = (mpmath.mpc(image[re], image[im]) for image in images)
            rows.append([(r - 1j * k) / 2, (r + 1j * k) / 2, (i - 1j * j) / 2, (i + 1j * j) / 2])
        return rows[0], rows[1]


_SURE = 48  # bits to which a separatrix has come to its limit where its turns repeat
_AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
_UNITS: tuple[Quaternion, ...] = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))


def speed_bound(motion: Polhode) -> Any:
    """An upper bound of |w| over all time.

    The middle axis has the larger amplitude of the two across: no moment exceeds the others' sum.
    """
    return mpmath.hypot(*motion.omega[1:])


def _dominated(row: list[Any], motion: Polhode, t: Any) -> Any:
    """The growth of the argument of a sum, from time 0 to t, while one term outweighs the rest."""
    sizes = [abs(x) for x in row]
    # th, from G to the axis circled, stays on its side of pi/2; sin th at both ends of its range.
    ends = [abs(motion.momentum[0])]
    if mpmath.isfinite(motion.elliptic.K):
        ends.append(abs(motion.momentum[1]))
    else:
        ends += [_sine(motion, time) for time in (mpmath.mpf(0), t)]
    ratio = [(1 + mpmath.sqrt(max(0, 1 - x * x))) / x for x in ends]  # |al'/bt'|, or its inverse
    if motion.momentum[2] < 0:
        ratio = [1 / x for x in ratio]
    # Equality is enough: it is met at most in the limit of a separatrix.
    slack = 1 - mpmath.ldexp(1, -mpmath.prec // 2)
    if all((sizes[0] - sizes[1]) * x > (sizes[2] + sizes[3]) * slack for x in ratio):
        lead = 0
    elif all((sizes[1] - sizes[0]) * x > (sizes[2] + sizes[3]) * slack for x in ratio):
        lead = 1
    elif all((sizes[2] - sizes[3]) > (sizes[0] + sizes[1]) * slack * x for x in ratio):
        lead = 2
    elif all((sizes[3] - sizes[2]) > (sizes[0] + sizes[1]) * slack * x for x in ratio):
        lead = 3
    else:
        return None

    def argument(time: Any) -> Any:
        q0, q1, q2, q3 = motion.place(time, MP)[1]
        al, bt = mpmath.mpc(q0, q3), mpmath.mpc(q1, q2)
        parts = (al, al.conjugate(), bt, bt.conjugate())
        whole = sum(x * part for x, part in zip(row, parts, strict=True))
        psi, phi = motion.angles(time)
        half = (psi + phi if lead < 2 else psi - phi) / 2
        return (-half if lead % 2 else half) + mpmath.arg(whole / (row[lead] * parts[lead]))

    return argument(t) - argument(mpmath.mpf(0))


def _sine(motion: Polhode, t: Any) -> Any:
    waves = motion.elliptic.waves(motion.v0 + motion.rate * t, MP)
    sn, cn, _ = motion.elliptic.functions(waves)
    return mpmath.hypot(motion.momentum[0] * cn, motion.momentum[1] * sn)


def _along_ellipse(one: Any, other: Any, x: Any) -> Any:
    """The growth of arg(one cos x + other sin x) from 0 to x; None where that is always 0.

    Through 0 itself the argument jumps by pi, counted upwards away from the start.
    """
    zero = mpmath.ldexp(1, -mpmath.prec // 2)
    if abs(one) < zero and abs(other) < zero:
        return None
    n = int(mpmath.nint(x / mpmath.pi))
    rest = x - n * mpmath.pi
    sense = (one.conjugate() * other).imag
    if abs(sense) > zero:
        c, s = mpmath.cos_sin(rest)
        return (n if sense > 0 else -n) * mpmath.pi + mpmath.arg((one * c + other * s) / one)
    if abs(one) < zero:
        return abs(int(x / mpmath.pi)) * mpmath.pi
    beta = mpmath.atan((other / one).real)
    return abs(int(mpmath.nint((x - beta) / mpmath.pi))) * mpmath.pi
