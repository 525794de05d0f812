"""Hess and Appelrot's case in closed form: every motion on the surface Iw.r0 = 0, at any time.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w

(Hess, Math. Ann. 37 (1890) 153; Appelrot, Mat. Sb. 16 (1893); Nekrasov 1896).  w = (p, q, r) and
the upward vertical gamma in body axes.  Units: any consistent set.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from polhode.closed_forms._engine.body_frame_motion import Between, Moving, moving
from polhode.closed_forms._engine.closed_form import Rows
from polhode.closed_forms._engine.from_attitude import FromMotion
from polhode.closed_forms._engine.precision import AtPrecision, phase_bits
from polhode.closed_forms._winding.asymptotic_period import Settled
from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, of_matrix
from polhode.closed_forms.functions.rounding import number, rounded_up, shortened
from polhode.closed_forms.hess import axes as surface
from polhode.closed_forms.hess.doubles import DoubleGeneral
from polhode.closed_forms.hess.explicit import Cone, PlaneMotion, cone, plane
from polhode.closed_forms.hess.general import GeneralMotion, general
from polhode.closed_forms.hess.turns import PeriodicTurns
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Vector

HELD = ("r0 at right angles to the middle axis", "(B/C - 1) T1^2 = (1 - B/A) T3^2", "Iw.r0 = 0")
_GUARD = 64  # bits beyond the digits asked for and the growth of phases
_SURE = 32  # bits of the way to a periodic motion after which turns repeat

Path = PlaneMotion | Cone | GeneralMotion


class HessTop(FromMotion):
    """One motion on Hess's surface from one start."""

    is_dear = True

    def _set_up(self, moments: Vector, torque: Vector, omega: Vector, axes: Rows | None) -> None:
        self._start = surface.start(moments, torque, omega, self._gamma, axes)
        self.regime = surface.regime(self._start)
        self._path = AtPrecision(self._solved)
        self._matrix = AtPrecision(
            lambda bits: [[number(x, bits) for x in row] for row in self._start.rows]
        )

    @property
    def held(self) -> tuple[str, ...]:
        """The conditions that body and start meet."""
        return HELD

    def _state(self, t: Scalar, bits: int) -> list[Scalar]:
        exponent = self._start.exponent
        point = self._path(bits).at(mpmath.ldexp(t, exponent), MP)
        a12 = number(self._start.a12, bits)
        scale = mpmath.ldexp(1, exponent)
        w = [scale * x for x in (a12 * point.Z[0], *point.Z)]
        return self._placed(w, bits) + self._placed([point.u, *point.g], bits)

    def _period(self, bits: int) -> Scalar | None:
        found = self._path(bits).period
        return None if found is None else mpmath.ldexp(found, -self._start.exponent)

    def _rates(self, bits: int) -> dict[str, Scalar]:
        """Of the general motion "nutation", of the angle between r0 and the vertical.

        Where it does not tend to a periodic motion also "turning", of the second phase, known
        modulo the first.
        """
        path = self._path(bits)
        if not isinstance(path, GeneralMotion):
            return {}
        scale = mpmath.ldexp(1, self._start.exponent)
        both = zip(("nutation", "turning"), path.frequencies, strict=True)
        return {name: x * scale for name, x in both if x is not None}

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

    def _solved(self, bits: int) -> Path:
        if self.regime in surface.PLANE:
            return plane(self._start, self.regime, bits)
        if self.regime in surface.CONES:
            return cone(self._start, self.regime, bits)
        return general(self._start, bits)

    def _turning(self, bits: int) -> Moving:
        path, unit = self._path(bits), mpmath.ldexp(1, self._start.exponent)
        chi: Callable[[Scalar], Scalar] | None = None
        if isinstance(path, Cone):
            turning = path.turning * unit
            chi = lambda t: turning * t  # noqa: E731
        wide, quick = self._speeds(path, bits)
        rows = self._matrix(bits)
        return moving(
            SurfaceFrame(path, unit),
            chi,
            self._first_quaternion(bits),
            rows,
            (wide, quick),
            path.period and path.period / unit,
            between=self._between(path, rows, unit, wide),
            settled=self._settled(path, unit),
        )

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

    def _placed(self, v: Sequence[Scalar], bits: int) -> list[mpf]:
        """A vector in the scene's axes."""
        rows = self._matrix(bits)
        return [sum(row[j] * x for row, x in zip(rows, v, strict=True)) for j in range(3)]

    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        phase = phase_bits(times, self._start.exponent)
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
