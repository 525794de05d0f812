"""chi, the angle of the angular momentum in space, which is horizontal where f = 0.

    chi' = T.Iw/|Iw|^2 = 2a sg sqrt(uv) sin((et - xi)/2)/(u + v)^2,

from d(Iw)/dt = gamma x T.  In the time sigma, dsigma = dt/(u + v), both phases of two frequencies
move uniformly: chi is a double Fourier series.  A motion of one frequency has a simple series, one
that tends to it a series in what is left (:mod:`.approach`).
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np

from polhode.closed_forms._winding.torus_line_integral import plane
from polhode.closed_forms.functions.fourier import (
    WaveSeries,
    cosines,
    fixed,
    waves,
)
from polhode.closed_forms.functions.jacobi import MP
from polhode.closed_forms.goryachev_chaplygin.abel_integrals import (
    Halves,
    InverseS,
    Oscillating,
    Standing,
)
from polhode.closed_forms.goryachev_chaplygin.attitude.asymptotic_series import approach
from polhode.closed_forms.goryachev_chaplygin.attitude.taylor_pieces import Pieces
from polhode.closed_forms.goryachev_chaplygin.double_root import Tending
from polhode.closed_forms.goryachev_chaplygin.explicit import Libration, Rotation, Separatrix
from polhode.closed_forms.goryachev_chaplygin.motion import GoryachevMotion, Separated
from polhode.closed_forms.goryachev_chaplygin.torus_quadrature import Torus
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.rows import Objects
from polhode.numbers.scalars import Scalar

#: chi(t) - chi(0), t in the motion's units.
Turning = Callable[[Scalar], Scalar]


def turning(found: GoryachevMotion) -> Turning:
    """chi(t) - chi(0) at the precision in force, to be asked at that precision.

    Raises TooManyTerms where a series would be too long.
    """
    path, sg = found.path, found.sg
    if isinstance(path, Separatrix):
        return _of_separatrix(path, sg)
    if isinstance(path, (Libration, Rotation)):
        return _of_period(path, sg)
    assert isinstance(path, Separated)
    if isinstance(path.torus.v, Standing):
        return _of_one(path, sg)
    return _of_tending(found) if isinstance(path.torus.v, Tending) else _of_torus(path, sg)


def _of_separatrix(path: Separatrix, sg: int) -> Turning:
    """dchi/dps = dl sqrt(1 + dl^2 c^4)/(1 + dl^2 c^2), c = cos ps = sech y."""
    d2 = path.dl * path.dl

    def rate(x: Any) -> Any:
        c2 = (1 + mpmath.cos(x)) / 2
        return [mpmath.sqrt(1 + d2 * c2 * c2) / (1 + d2 * c2)]

    (series,) = cosines(rate)

    def angle(t: Any) -> Any:
        x = 2 * mpmath.atan(mpmath.sinh(path.y0 + path.rate * t))
        return (series.mean * x + series.bounded(x)) / 2

    begin = angle(mpf(0))
    return lambda t: sg * path.dl * (angle(t) - begin)


def _of_period(path: Libration | Rotation, sg: int) -> Turning:
    """One series over the period."""
    share = path.period / (2 * mpmath.pi)
    series = waves(lambda x: path.at(x * share, MP).turning * share)
    begin = series.at(mpf(0))
    return lambda t: sg * (series.at(t / share) - begin)


def _flow(path: Separated, one: Halves, other: Halves) -> Scalar:
    """chi' (u + v): the rate in sigma."""
    point = path.joined(one, other, MP)
    return point.turning * (point.u + point.v)


def _series_beside(path: Separated, other: Any) -> WaveSeries:
    """chi along half the phase of u, while v stays as it is: the period is 4 pi."""
    u = path.torus.u

    def rate(x: Any) -> Any:
        one = u.at(2 * x, MP)
        return 2 * _flow(path, one, other) * one.slope

    return waves(rate)


def _of_one(path: Separated, sg: int) -> Turning:
    """v constant: one series in the phase of u."""
    torus = path.torus
    series = _series_beside(path, torus.v.at(mpf(0), MP))
    begin = series.at(torus.start[0] / 2)
    return lambda t: sg * (series.at(torus.phases(t)[0] / 2) - begin)


def _reach() -> Scalar:
    """|y| from which on v is its limit: it differs by sech^2 y."""
    return mpmath.prec * mpmath.ln2 / 2 + 4


def settling(torus: Torus) -> Scalar:
    """A time from which on, and before minus which, v is its limit at the precision in force."""
    assert isinstance(torus.u, Oscillating)
    ends = []
    for y in (_reach(), -_reach()):
        total = torus.v.means[0] * y + torus.v.bounded(y)[0] + torus.constants[0]
        ends.append(torus.moment(InverseS(torus.u).at(total / torus.u.S.mean), y))
    return max(abs(t) for t in ends)


def _of_tending(found: GoryachevMotion) -> Turning:
    """Pieces about the turning point of v, a series in what v lacks of its limit beyond them."""
    path, sg = found.path, found.sg
    assert isinstance(path, Separated)
    torus, v = path.torus, path.torus.v
    assert isinstance(torus.u, Oscillating)
    assert isinstance(v, Tending)
    u, inverse, mean = torus.u, InverseS(torus.u), torus.u.S.mean
    far = approach(torus, v, path.a, inverse.at)
    origin = torus.constants[0] / mean

    def moment(Y: Scalar) -> tuple[Scalar, Scalar]:
        """The time at which v has come to Y, and al."""
        total = 4 * Y / v.gw
        al = total / mean + origin
        return torus.moment(inverse.at(al), v.phase(total)), al

    pieces = Pieces(lambda t: found.at(t, MP)[1], path.a, moment(mpf(0))[0])
    ends = {}
    for side in (1, -1):
        time, al = moment(side * far.edge)
        ends[side] = pieces.at(time) - 2 * sg * path.a * side * far.at(side * al, far.edge)

    def angle(t: Scalar) -> Scalar:
        x, y = torus.phases(t)
        Y = y + v.gw / 4 * v.bounded(y)[0]
        if abs(Y) <= far.edge:
            return pieces.at(t)
        side, al = (1 if Y > 0 else -1), x + u.bounded(x)[0] / mean
        return ends[side] + 2 * sg * path.a * side * far.at(side * al, side * Y)

    begin = angle(mpf(0))
    return lambda t: angle(t) - begin


def _of_torus(path: Separated, sg: int) -> Turning:
    """Two frequencies: a double series in al = S/S_0 and be = S~/S~_0."""
    torus = path.torus
    one, other = torus.u, torus.v
    assert isinstance(one, Oscillating)
    assert isinstance(other, Oscillating)
    # v's halves change sign with a turn of y but where v moves between the roots of one cubic.
    odd = other.variable.cosine[0] != "one"
    shift = Fraction(1, 2), Fraction(1, 2) if odd else Fraction(0)
    inverse = {True: InverseS(one), False: InverseS(other)}
    tables: dict[tuple[bool, Any], list[Any]] = {}

    def row(which: bool, share: Scalar, bits: int) -> list[int]:
        if (which, share) not in tables:
            clock = one if which else other
            point = clock.at(inverse[which].at(mpmath.pi * share), MP)
            root = mpmath.sqrt(point.z)
            tables[which, share] = [root * point.sine, root * point.cosine, point.z]
        return [fixed(x, bits) for x in tables[which, share]]

    def grid(n: int, m: int, bits: int) -> Objects:
        u = np.array([row(True, mpf(2 * j) / n, bits) for j in range(n)], dtype=object)
        v = np.array([row(False, mpf(2 * k) / m, bits) for k in range(m)], dtype=object)
        (sx, cx, z), (se, ce, y) = u.T[:, :, None], v.T[:, None, :]
        across = se * cx - ce * sx  # in units of 2^-2 bits
        found: Objects = across * twice(bits) // ((z + y) << bits)
        return found

    def twice(bits: int) -> int:
        return fixed(2 * sg * path.a, bits)

    scale = one.S.mean, other.S.mean
    made = plane(grid, (1 / scale[0], 1 / scale[1]), shift)

    def phases(t: Scalar) -> tuple[Scalar, Scalar]:
        x, y = torus.phases(t)
        return x + one.bounded(x)[0] / scale[0], y + other.bounded(y)[0] / scale[1]

    start = phases(mpf(0))
    begin = made.at(*start)

    def angle(t: Scalar) -> Scalar:
        now = phases(t)
        sigma = (now[0] - start[0]) * scale[0]
        return made.at(*now) - begin + made.slowly(start, sigma)

    return angle
