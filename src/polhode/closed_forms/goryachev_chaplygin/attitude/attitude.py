"""The attitude of a Goryachev-Chaplygin motion from its halves: no sign or branch is chosen.

Angular momentum over |Iw| and gamma are two unit vectors at right angles, as f = 0.  The quaternion
that takes the first to the third axis and gamma to the second has the parameters

    al = sqrt(u/(u + v)) e^{-i (xi/2 + pi/4)},    bt = sg sqrt(v/(u + v)) e^{-i (et/2 + pi/4)},

smooth in time.  The axes are then renamed, and turned about the vertical by chi.
"""

from __future__ import annotations

from dataclasses import dataclass

from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, product
from polhode.closed_forms.goryachev_chaplygin.abel_integrals import Clock
from polhode.closed_forms.goryachev_chaplygin.double_root import Tending
from polhode.closed_forms.goryachev_chaplygin.explicit import (
    HalvesPoint,
    Libration,
    Rotation,
    Separatrix,
)
from polhode.closed_forms.goryachev_chaplygin.motion import GoryachevMotion, Path, Separated, joined
from polhode.closed_forms.goryachev_chaplygin.torus_quadrature import Torus
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.rows import Doubles
from polhode.numbers.scalars import Scalar

#: Takes the third axis to the first, the first to the second, the second to the third.
_RENAMED = (0.5, 0.5, 0.5, 0.5)


@dataclass(frozen=True)
class HalvesFrame:
    """The frame of the angular momentum and gamma in the motion's own axes, time as the scene's."""

    path: Path
    sg: int
    unit: Scalar  # the motion's time over the scene's; negative where time is reversed

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The quaternion at t, continuous in t."""
        return placed(self.path.at(t * self.unit, fn), self.sg, fn)

    def floats(self, speed: Scalar) -> HalvesFrame:
        """The same in doubles for arrays, time in units of 1/speed."""
        path = self.path
        small: Path
        if isinstance(path, Separated):
            small = DoublePath(path)
        else:
            assert isinstance(path, (Libration, Rotation, Separatrix))
            small = path.floats()
        return HalvesFrame(small, self.sg, float(self.unit / speed))


class DoublePath:
    """A motion with G > 0 in doubles, for arrays of times."""

    def __init__(self, path: Separated) -> None:
        torus = path.torus
        self._torus = torus.doubles
        self._a = float(path.a)
        begin, later = torus.mean(mpf(0)), torus.mean(mpf(1))
        self._mean = [(float(x), float(y - x)) for x, y in zip(begin, later, strict=True)]

    def at(self, t: Doubles, fn: SeriesFunctions) -> HalvesPoint:
        """The points at an array of times."""
        (x, dx), (y, dy) = self._mean
        mean_x, mean_y = x + dx * t, y + dy * t
        more_x, more_y = self._torus.corrections(mean_x, mean_y)
        one, other = self._torus.u.at(mean_x + more_x, fn), self._torus.v.at(mean_y + more_y, fn)
        return joined(one, other, self._a, fn)


def placed(point: HalvesPoint, sg: int, fn: SeriesFunctions) -> Quaternion:
    """The quaternion of the frame at a point."""
    (sx, cx), (se, ce) = point.xi, point.et
    one, two, _ = point.shares
    root = fn.sqrt(one / 2), sg * fn.sqrt(two / 2)
    # e^{-i (f + pi/4)} = ((c - s) - i (c + s))/sqrt 2
    frame = (root[0] * (cx - sx), root[1] * (ce - se), -root[1] * (ce + se), -root[0] * (cx + sx))
    return product(_RENAMED, frame)


def bounds(found: GoryachevMotion, H: Scalar, a: Scalar) -> tuple[Scalar, Scalar]:
    """Bounds of |w| and of the frame's rate |w| + |chi'|, in the motion's units.

    |w|^2 <= 4(p^2 + q^2) + r^2 <= H + 2a.  As 4|p| <= u + v, |chi'| <= a/(u + v); the others follow
    from the formulas of chi' with each factor at its worst.
    """
    path, fast = found.path, mpmath.sqrt(H + 2 * a)
    if isinstance(path, Separated):
        turning = a / (_least(path.torus, 0) + _least(path.torus, 1))
    elif isinstance(path, Rotation):
        turning = a / (2 * path.size)
    elif isinstance(path, Separatrix):
        turning = mpmath.sqrt(a) * abs(path.dl) / 2
    else:
        assert isinstance(path, Libration)
        across = mpmath.sqrt(1 - path.l * path.l)
        turning = mpmath.sqrt(a) * abs(path.l) / (2 * path.m1 * mpmath.sqrt(path.m1) * across)
    return fast, fast + turning


def _least(torus: Torus, which: int) -> Scalar:
    clock: Clock = (torus.u, torus.v)[which]
    if isinstance(clock, Tending):
        return min(clock.w, clock.ve)
    variable = getattr(clock, "variable", None)
    return clock.z if variable is None else variable.low  # type: ignore[attr-defined]
