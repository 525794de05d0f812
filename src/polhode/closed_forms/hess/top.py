"""Hess and Appelrot's case in closed form: every motion on the surface Iw.r0 = 0, at any time.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w

(Hess, Math. Ann. 37 (1890) 153; Appelrot, Mat. Sb. 16 (1893); Nekrasov 1896).  w = (p, q, r) and
the upward vertical gamma in body axes.  Units: any consistent set.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from polhode.closed_forms._engine.body_frame_motion import Between, Moving, moving
from polhode.closed_forms._engine.from_attitude import FromAttitude
from polhode.closed_forms._winding.asymptotic_period import Settled
from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, of_matrix
from polhode.closed_forms.functions.rounding import log2, number, rounded_up, shortened
from polhode.closed_forms.hess import axes as surface
from polhode.closed_forms.hess.doubles import DoubleGeneral
from polhode.closed_forms.hess.explicit import Cone, PlaneMotion, cone, plane
from polhode.closed_forms.hess.general import GeneralMotion, general
from polhode.closed_forms.hess.turns import PeriodicTurns
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Vector

_ZERO = Fraction(0)
_GUARD = 64  # bits beyond the digits asked for and the growth of phases
_SURE = 32  # bits of the way to a periodic motion after which turns repeat

Path = PlaneMotion | Cone | GeneralMotion


class HessTop(FromAttitude):
    """One motion on Hess's surface from one start.

    ``moments`` are the principal moments and ``torque`` = Mg r0 in principal axes; ``axes[i]`` is
    the unit vector of principal axis i in the scene's body axes (right-handed; None for the same
    axes).  ``omega`` and ``gamma`` are given at t = 0 in the scene's axes, where all answers are
    too.  Raises ValueError with the condition that fails.

    ``regime`` names the kind of motion; it is decided once, by exact arithmetic.  ``held`` are the
    conditions that body and start meet.
    """

    held = ("r0 at right angles to the middle axis", "(B/C - 1) T1^2 = (1 - B/A) T3^2", "Iw.r0 = 0")

    def __init__(
        self,
        *,
        moments: Vector,
        torque: Vector,
        omega: Vector,
        gamma: Vector,
        psi: Exact = _ZERO,
        axes: tuple[tuple[Exact, ...], ...] | None = None,
    ) -> None:
        super().__init__(gamma, psi)
        self._start = surface.start(moments, torque, omega, gamma, axes)
        self.regime = surface.regime(self._start)
        self._paths: dict[int, Path] = {}
        self._attitudes: dict[int, Moving] = {}
        self._rows: dict[int, list[list[Any]]] = {}

    def at(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Rows p, q, r, gamma1, gamma2, gamma3, one a time.

        The error is below 10^-digits, of w relative to its largest modulus.
        """
        bits = self._bits(times, digits)
        path, rows = self._path(bits), []
        with mpmath.workprec(bits):
            for t in times:
                point = path.at(self._moment(t, bits), MP)
                a12 = number(self._start.a12, bits)
                scale = mpmath.ldexp(1, self._start.exponent)
                w = [scale * x for x in (a12 * point.Z[0], *point.Z)]
                gamma = [point.u, *point.g]
                rows.append(self._placed(w, bits) + self._placed(gamma, bits))
        return [shortened(row, digits) for row in rows]

    def period(self, digits: int) -> mpf | None:
        """The period of the state; None where it does not repeat."""
        bits = self._bits((), digits)
        with mpmath.workprec(bits):
            found = self._path(bits).period
            if found is None:
                return None
            found = mpmath.ldexp(found, -self._start.exponent)
        return shortened([found], digits)[0]

    def frequencies(self, digits: int) -> dict[str, mpf]:
        """The motion's frequencies, radians a unit of time.

        Of a periodic motion "body".  Of the general one "nutation", of the angle between r0 and the
        vertical, and where it does not tend to a periodic motion "turning", of the second phase,
        known modulo the first.
        """
        period = self.period(digits + 5)
        bits = self._bits((), digits)
        with mpmath.workprec(bits):
            if period is not None:
                return {"body": shortened([2 * mpmath.pi / period], digits)[0]}
            path = self._path(bits)
            if not isinstance(path, GeneralMotion):
                return {}
            scale = mpmath.ldexp(1, self._start.exponent)
            both = [None if x is None else x * scale for x in path.frequencies]
        names = ("nutation", "turning")
        found = dict(zip(names, shortened(both, digits), strict=True))
        return {name: x for name, x in found.items() if x is not None}

    def approach(self, digits: int) -> mpf | None:
        """The rate at which the motion tends to a periodic one; None where it does not.

        Differences fall as exp(-rate t); of a plane rotation and of a cone that tends to a
        permanent rotation the rate is the mean one of the formula's exponents.
        """
        bits = self._bits((), digits)
        with mpmath.workprec(bits):
            path = self._path(bits)
            rate: Any = None
            if isinstance(path, GeneralMotion):
                rate = path.rate
            elif isinstance(path, Cone) and self.regime == surface.CONE_TENDING:
                rate = 2 * path.rate
            elif isinstance(path, PlaneMotion) and self.regime == surface.ROTATION:
                assert path.elliptic is not None
                # X grows by a12 pi a turn of r0, which takes 2K/rate; al/be as e^{2X}.
                rate = abs(path.a12) * mpmath.pi * path.rate / path.elliptic.K
            if rate is None:
                return None
            rate = mpmath.ldexp(rate, self._start.exponent)
        return shortened([rate], digits)[0]

    def _path(self, bits: int) -> Path:
        """The constants at a precision, made once."""
        if bits not in self._paths:
            with mpmath.workprec(bits):
                if self.regime in surface.PLANE:
                    self._paths[bits] = plane(self._start, self.regime, bits)
                elif self.regime in surface.CONES:
                    self._paths[bits] = cone(self._start, self.regime, bits)
                else:
                    self._paths[bits] = general(self._start, bits)
        return self._paths[bits]

    def _attitude(self, bits: int) -> Moving:
        """The attitude as a function of time, its constants made once a precision."""
        if bits not in self._attitudes:
            path = self._path(bits)
            with mpmath.workprec(bits):
                unit = mpmath.ldexp(1, self._start.exponent)
                begin = self._first_quaternion(bits)
                chi: Callable[[Scalar], Scalar] | None = None
                if isinstance(path, Cone):
                    turning = path.turning * unit
                    chi = lambda t: turning * t  # noqa: E731
                wide, quick = self._speeds(path, bits)
                frame = SurfaceFrame(path, unit)
                rows = self._matrix(bits)
                self._attitudes[bits] = moving(
                    frame,
                    chi,
                    begin,
                    rows,
                    (wide, quick),
                    path.period and path.period / unit,
                    between=self._between(path, rows, unit, wide),
                    settled=self._settled(path, unit),
                )
        return self._attitudes[bits]

    def _between(
        self, path: Path, rows: Sequence[Sequence[Scalar]], unit: Scalar, wide: Scalar
    ) -> Between | None:
        """The growth of the frame's arguments between two times, of two frequencies."""
        if not isinstance(path, GeneralMotion) or abs(path.trace) >= 2:
            return None
        axis = [row[2] for row in rows]
        turns = PeriodicTurns(path, of_matrix(rows), axis, wide / unit)

        def between(first: Any, last: Any) -> tuple[Any, Any]:
            one, other = turns.growth(first * unit), turns.growth(last * unit)
            return other[0] - one[0], other[1] - one[1]

        return between

    def _settled(self, path: Path, unit: Scalar) -> Settled | None:
        """When a motion that tends to a periodic one is that, and its period.

        What is left of the way falls by 2^-_SURE before: where the vertical is passed ever nearer,
        it is on one and the same side, so that turns repeat long before the digits do.
        """
        ways = _SURE * mpmath.ln2
        if isinstance(path, GeneralMotion):
            rate, period, advance = path.rate, path.period_of_u, path.space
            if rate:
                ways = _SURE * mpmath.ln2 + path.apart
        elif isinstance(path, Cone) and self.regime == surface.CONE_TENDING:
            rate, period, advance = 2 * path.rate, 1 / path.rate, mpf(0)
        elif isinstance(path, PlaneMotion) and self.regime == surface.ROTATION:
            assert path.elliptic is not None
            period, advance = 2 * path.elliptic.K / path.rate, mpf(0)
            rate = 2 * abs(path.a12) * mpmath.pi / period
            c0, s0 = path.half
            ways = _SURE * mpmath.ln2 + abs(mpmath.log(abs((c0 - s0) / (c0 + s0))))
        else:
            return None
        if not rate:
            return None
        return Settled(ways / rate / unit, period / unit, advance)

    def _speeds(self, path: Path, bits: int) -> tuple[Scalar, Scalar]:
        """Bounds of |w| and of the frame's rate: |Z|^2 <= 2(h + P), w = (a12 M2, M2, M3)."""
        start = self._start
        h, P, a12 = (number(x, bits) for x in (start.h, start.P, start.a12))
        wide = mpmath.sqrt(2 * (h + P) * (1 + a12 * a12))
        quick = wide + abs(path.turning) if isinstance(path, Cone) else wide
        return mpmath.ldexp(wide, start.exponent), mpmath.ldexp(quick, start.exponent)

    def _moment(self, t: Exact, bits: int) -> mpf:
        """A time in the motion's units."""
        return mpmath.ldexp(number(t, bits), self._start.exponent)

    def _matrix(self, bits: int) -> list[list[Scalar]]:
        """The motion's axes in the scene's."""
        if bits not in self._rows:
            self._rows[bits] = [[number(x, bits) for x in row] for row in self._start.rows]
        return self._rows[bits]

    def _placed(self, v: Sequence[Scalar], bits: int) -> list[mpf]:
        """A vector in the scene's axes."""
        rows = self._matrix(bits)
        return [sum(row[j] * x for row, x in zip(rows, v, strict=True)) for j in range(3)]

    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        """Working precision: the digits, what the phases cost, a guard."""
        last = max((log2(t) for t in times), default=-math.inf)
        phase = max(0.0, last + self._start.exponent) if last > -math.inf else 0.0
        return rounded_up(digits * math.log2(10) + phase + _GUARD)


@dataclass(frozen=True)
class SurfaceFrame:
    """The frame of a motion, time as the scene's."""

    path: PlaneMotion | Cone | GeneralMotion | DoubleGeneral
    unit: Scalar

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The quaternion at t, continuous in t."""
        return self.path.at(t * self.unit, fn).frame

    def floats(self, speed: Scalar) -> SurfaceFrame:
        """The same in doubles for arrays, time in units of 1/speed."""
        path = self.path
        assert not isinstance(path, DoubleGeneral)
        small = DoubleGeneral(path) if isinstance(path, GeneralMotion) else path.floats()
        return SurfaceFrame(small, float(self.unit / speed))
