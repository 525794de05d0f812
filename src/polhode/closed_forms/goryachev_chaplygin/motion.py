"""Goryachev and Chaplygin's case in closed form: every motion with f = 0, at any time.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w,    I = diag(4C, 4C, C), r0 = (x0, y0, 0)

and Iw.gamma = 0 (Goryachev, Mat. Sb. 21 (1900) 431; Chaplygin, Trudy Otd. Fiz. Nauk 10 (1901)).
w = (p, q, r) and the upward vertical gamma in body axes.  In the halves of the angles xi and et,

    p = sg sqrt(uv)/2 sin((et - xi)/2),   q = sg sqrt(uv)/2 cos((et - xi)/2),   r = u - v,
    g1 = -(u cos xi + v cos et)/(u + v),  g2 = -(u sin xi - v sin et)/(u + v),
    g3 = sg 2 sqrt(uv) sin((xi + et)/2)/(u + v),   sg = +1 or -1 throughout.

With G = 0, every release from rest among them, u and v are explicit (Goryachev 1900); else they are
inverted from two integrals (:mod:`.separated`).  The state has any number of digits, each of them
proven; the attitude has no formula here.  Units: any consistent set.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flint import arb

from polhode.closed_forms.balls.core import TooFewBits, ball, root, square
from polhode.closed_forms.balls.frames import StateAndTurning, no_attitude
from polhode.closed_forms.balls.jacobi import Jacobi, carlson_rf
from polhode.closed_forms.goryachev_chaplygin.place import (
    EXPLICIT,
    GoryachevPlacement,
    Regime,
    Start,
)
from polhode.closed_forms.goryachev_chaplygin.separated import (
    Separated,
    SeparatedPoint,
    positive,
    sines,
)
from polhode.numbers.exact import Exact
from polhode.numbers.vectors import is_zero


class GoryachevState:
    """The state in the motion's axes and units, at the precision in force."""

    def __init__(self, start: Start, regime: Regime) -> None:
        self.path = explicit(start, regime) if regime in EXPLICIT else Separated(start, regime)
        self._side = 1
        right, row = [ball(x) for x in (*start.omega, *start.gamma)], self.at(arb(0))
        lead = max((0, 1, 5), key=lambda i: abs(right[i].mid()))
        if not abs(row[lead]) > 0:
            raise TooFewBits
        self._side = 1 if (row[lead] > 0) == (right[lead] > 0) else -1

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, g1, g2, g3."""
        point: SeparatedPoint = self.path.at(t)
        (sx, cx), (se, ce) = point.xi, point.et
        u_share, v_share, both = point.shares
        half = self._side * point.root / 2
        return [
            half * (se * cx - ce * sx),
            half * (cx * ce + sx * se),
            point.u - point.v,
            u_share * (square(sx) - square(cx)) + v_share * (square(se) - square(ce)),
            2 * (v_share * se * ce - u_share * sx * cx),
            2 * self._side * both * (sx * ce + cx * se),
        ]


class GoryachevMotion(StateAndTurning):
    """The motion at the precision in force."""

    def __init__(self, place: GoryachevPlacement) -> None:
        start = place.start
        self._state = GoryachevState(start, place.regime)
        speed = root(start.H + 2 * start.a)  # w^2 <= H - 2a gamma1
        super().__init__(self._state, no_attitude, speed, self._state.path.period)

    def rates(self) -> Mapping[str, arb]:
        """Of two frequencies "u" and "v", the mean rates of the phases of u and v.

        u and v repeat with 2 pi of them, p, q and gamma3 with twice that.
        """
        path = self._state.path
        if isinstance(path, Separated) and (means := path.means) is not None:
            return dict(zip("uv", means, strict=True))
        return super().rates()


# --- explicit -------------------------------------------------------------------------------------
#
# Goryachev and Chaplygin's motions with G = 0, every release from rest among them: explicit.
#
# Goryachev 1900.  With su = SF CP + CF SP, cu = CF CP - SF SP, sv = SF CP - CF SP,
# cv = CF CP + SF SP, and Du^2 = m1 + m cu^2, Dv^2 = m1 + m cv^2, the variables are elliptic
# functions of y = y0 + rate t:
#
#     |H| < 2a: u = 2 sqrt(a m m1) su/Du, v likewise with sv (both may pass through 0, at rest);
#     H > 2a:   u = sqrt(H - 2a)/Du, v likewise, SP and CP constant;
#     H = 2a:   u = 2 sqrt(a) sech(y + b), v = 2 sqrt(a) sech(y - b).


class Swinging:
    """What |H| < 2a and H > 2a have in common: the modulus, and y from the angles fu and fv.

    F(fu|m) and F(fv|m) grow evenly, both by ``rate``; y is their mean.
    """

    def __init__(self, m: Exact, m1: Exact, rate: arb) -> None:
        self._m, self._m1, self._rate = ball(m), ball(m1), rate
        self._elliptic, self._y0 = Jacobi(self._m, self._m1), arb(0)

    def _begin(self, fu: arb, fv: arb) -> None:
        """y from the angles at t = 0."""
        self._y0 = (self._first(fu) + self._first(fv)) / 2

    def _first(self, f: arb) -> arb:
        """F(f|m), -pi/2 < f < pi (DLMF 19.25(i))."""
        sin, cos = f.sin_cos()
        value = sin * carlson_rf(square(cos), self._depth(cos))
        return value if cos.mid() >= 0 else 2 * self._elliptic.K - value

    def _depth(self, cos: arb) -> arb:
        """m1 + m cos^2."""
        return self._m1 + self._m * square(cos)

    def _functions(self, t: arb) -> tuple[arb, arb, arb]:
        """sn, cn and dn of y at a time."""
        place = self._elliptic.at(self._y0 + self._rate * t)
        return place.side * place.sn, place.side * place.cn, place.dn


class Libration(Swinging):
    """|H| < 2a: the body swings; from rest it comes back to rest on the same path."""

    def __init__(self, start: Start) -> None:
        a, H = start.a, start.H
        super().__init__((2 * a + H) / (4 * a), (2 * a - H) / (4 * a), root(a) / 2)
        self._a = ball(a)
        self.period: arb = 4 * self._elliptic.K / self._rate
        if is_zero(start.omega):
            _, g2, g3 = start.gamma
            size = root(g2 * g2 + g3 * g3)
            # l and sqrt(1 - l^2); y0 = 0
            self._l, self._across = -ball(g2) / size, abs(ball(g3)) / size
            return
        angles = []
        for z, sin in sines(start):
            cosine = (self._m1 + z * z / (4 * self._a)).sqrt()
            angles.append(arb.atan2(z / (2 * (self._a * self._m1).sqrt()), sin / (2 * cosine)))
        fu, fv = angles
        mean = ((fu + fv) / 2).sin()
        self._l, self._across = ((fu - fv) / 2).sin() / mean, (fu.sin() * fv.sin()).sqrt() / mean
        self._begin(fu, fv)

    def at(self, t: arb) -> SeparatedPoint:
        """The point at a time."""
        m, m1, l, across = self._m, self._m1, self._l, self._across
        sn, cn, dn = self._functions(t)
        swing = square(dn) + m * square(l * sn)
        n = (square(dn) + m * square(l * sn * cn)).sqrt()
        SF, CF = sn * dn / n, cn * swing.sqrt() / n
        SP = l * SF
        CP = (swing * square(cn) + square(dn * across * sn)).sqrt() / n
        su, cu, sv, cv = _sums(SF, CF, SP, CP)
        Du, Dv = self._depth(cu).sqrt(), self._depth(cv).sqrt()
        size = 2 * (self._a * m * m1).sqrt()
        u_part, v_part, both = (CP + l * CF) / Du, (CP - l * CF) / Dv, across / (Du * Dv).sqrt()
        total = u_part + v_part
        return SeparatedPoint(
            size * su / Du,
            size * sv / Dv,
            size * SF * both,
            (u_part / total, v_part / total, both / total),
            (m.sqrt() * cu / Du, m1.sqrt() / Du),
            (m.sqrt() * cv / Dv, m1.sqrt() / Dv),
        )


class Rotation(Swinging):
    """H > 2a: u and v never vanish."""

    def __init__(self, start: Start) -> None:
        a, H = start.a, start.H
        super().__init__(4 * a / (H + 2 * a), (H - 2 * a) / (H + 2 * a), root(H + 2 * a) / 4)
        self.period: arb = 2 * self._elliptic.K / self._rate
        self._size = root(H - 2 * a)
        angles = []
        for z, sin in sines(start):
            cos = (z * z - ball(H)) / (2 * ball(a))
            # Of either sign: where the larger half is positive no angle is near the cut.
            larger = ((1 + abs(cos)) / 2).sqrt()
            smaller = sin / (2 * larger)
            s, c = (larger, smaller) if cos.mid() < 0 else (smaller, larger)
            angles.append(arb.atan2(c / self._m1.sqrt(), s))
        fu, fv = angles
        self._sin, self._cos = ((fu - fv) / 2).sin_cos()
        self._begin(fu, fv)

    def at(self, t: arb) -> SeparatedPoint:
        """The point at a time."""
        m, m1, SP, CP = self._m, self._m1, self._sin, self._cos
        sn, cn, dn = self._functions(t)
        SF = sn * (m1 + m * square(CP * cn)).sqrt() / dn
        CF = cn * (square(dn) + m * square(SP * sn)).sqrt() / dn
        su, cu, sv, cv = _sums(SF, CF, SP, CP)
        Du, Dv = self._depth(cu).sqrt(), self._depth(cv).sqrt()
        xi, et = (cu / Du, m1.sqrt() * su / Du), (cv / Dv, m1.sqrt() * sv / Dv)
        return positive(self._size / Du, self._size / Dv, xi, et)


class Separatrix:
    """H = 2a: the body tends to rest upright, before and after."""

    period = None

    def __init__(self, start: Start) -> None:
        self._a, self._rate = ball(start.a), root(start.a) / 2
        # cos^2(xi/2) = u^2/4a, and -tan(xi/2) is sinh of y0 + b0; with v, of y0 - b0
        first, second = (-2 * self._a * sin / (z * z) for z, sin in sines(start))
        self._y0 = (first.asinh() + second.asinh()) / 2
        self._apart = (first - second) / 2

    def at(self, t: arb) -> SeparatedPoint:
        """The point at a time: sinh b = apart/cosh y."""
        sinh, cosh = (self._y0 + self._rate * t).sinh_cosh()
        sb = self._apart / cosh
        cb = (1 + square(sb)).sqrt()
        halves = []
        for side in (1, -1):
            up = cosh * cb + side * sinh * sb
            halves.append((-(sinh * cb + side * cosh * sb) / up, 1 / up))
        xi, et = halves
        size = 2 * self._a.sqrt()
        return positive(size * xi[1], size * et[1], xi, et)


def explicit(start: Start, regime: Regime) -> Libration | Rotation | Separatrix:
    """The motion of a start with G = 0, at the precision in force."""
    if regime == Regime.LIBRATING:
        return Libration(start)
    return Rotation(start) if regime == Regime.ROTATING else Separatrix(start)


def _sums(SF: arb, CF: arb, SP: arb, CP: arb) -> tuple[arb, arb, arb, arb]:
    """su, cu, sv and cv: sines and cosines of a sum and of a difference."""
    return SF * CP + CF * SP, CF * CP - SF * SP, SF * CP - CF * SP, CF * CP + SF * SP
