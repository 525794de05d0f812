"""Goryachev and Chaplygin's motions with G > 0: the separation variables u and v at any time.

    u = (r + S)/2,  v = (S - r)/2,  S^2 = r^2 + 16(p^2 + q^2),    dt = (u + v) ds,

    4u_s^2 = -P+(u) P-(u),    4v_s^2 = -P+(-v) P-(-v),    P+-(z) = z^3 - (H +- 2a) z - 4G,

u- <= u <= u+ between the positive roots of P- and P+; the other roots of P+ are -v1, -v2, those of
P- are -w1, -w2, and v moves between two of v1, w1, w2, v2 or tends to w1 = w2.  With

    cos xi = (u^2 - H - 4G/u)/2a,    cos et = (v^2 - H + 4G/v)/2a

the squares of the sine and the cosine of xi/2 are -P+(u)/4au and P-(u)/4au, those of et/2 are
P+(-v)/4av and -P-(-v)/4av: products over roots, in which an end of the interval is the square of
the sine or cosine of half the phase.  So the halves have no branches.

S(x) - S~(y) is constant and U(x) + V(y) = t + constant.  Newton's iteration on middles proves
nothing, and need not: t grows with s, so that there is one solution, and an interval step of
Newton's that stays within its box encloses it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from flint import arb

from polhode.closed_forms.balls.clocks import Factors, Oscillating, Place, Standing, Tending
from polhode.closed_forms.balls.core import TooFewBits, ball, square
from polhode.closed_forms.goryachev_chaplygin.place import Regime, Start, discriminants
from polhode.numbers.exact import Exact, sign
from polhode.numbers.flint_context import ctx

Clock: TypeAlias = Standing | Oscillating | Tending

_STEPS = 400
_HALVINGS = 80
_NEAR, _ROUGH = 1e-12, 1e-8  # steps that end the rough searches, over the size


class SeparatedPoint(NamedTuple):
    """Everything that the state is made of, at one time; u, v and root may be negative together."""

    u: arb
    v: arb
    root: arb  # sqrt(uv)
    shares: tuple[arb, arb, arb]  # u, v and root over u + v, which may be 0
    xi: tuple[arb, arb]  # sin and cos of xi/2
    et: tuple[arb, arb]


def positive(u: arb, v: arb, xi: tuple[arb, arb], et: tuple[arb, arb]) -> SeparatedPoint:
    """A point with u, v > 0."""
    root, total = (u * v).sqrt(), u + v
    return SeparatedPoint(u, v, root, (u / total, v / total, root / total), xi, et)


@dataclass(frozen=True)
class CubicRoots:
    """The positive root of z^3 - c z - 4G, and the other two: -low, -high, or a complex pair."""

    positive: arb
    low: arb
    high: arb
    pairs: Sequence[tuple[arb, arb]] = ()  # of -z: real part, and square of the imaginary one


def cubic_roots(c: Exact, G: Exact, discriminant: Exact) -> CubicRoots:
    """By sines or by Cardano's formula, as c^3 - 108 G^2 says; no differences."""
    kind, area = sign(discriminant), (abs(ball(discriminant)) / 27).sqrt()
    third, twice = arb.pi() / 3, 2 * ball(G)
    if kind >= 0:
        size, angle = 2 * (ball(c) / 3).sqrt(), arb.atan2(twice, area) / 3
        low, high, top = (size * x.sin() for x in (angle, third - angle, third + angle))
        return CubicRoots(top, low, low if kind == 0 else high)
    u = (twice + area).root(3)
    v = ball(c) / (3 * u)
    if sign(c) > 0:
        top = u + v
        gap = 2 * area / (u * u + u * v + v * v)
    else:
        top, gap = (2 * twice / (u * u - u * v + v * v), u - v)
    return CubicRoots(top, arb.nan(), arb.nan(), [(top / 2, 3 * gap * gap / 4)])


@dataclass(frozen=True)
class Variable:
    """u or v: its integrals, and the halves of its angle.

    ``shares``: of the ends of its interval in the sine and in the cosine; the rest are roots.
    """

    clock: Clock
    shares: Callable[[arb], tuple[arb, arb]]
    sine: Factors
    cosine: Factors

    def halves(self, x: arb, a: arb) -> tuple[arb, tuple[arb, arb]]:
        """z, and sin and cos of half its angle."""
        z = self.clock.slope(x)[1]
        sine, cosine = self.shares(x)
        over = (4 * a * z).rsqrt()
        return z, (
            sine * self.sine.product(z).sqrt() * over,
            cosine * self.cosine.product(z).sqrt() * over,
        )


def _between(
    low: arb, high: arb, sine: Factors, cosine: Factors, ends: tuple[bool, bool]
) -> Variable:
    """Of a variable that oscillates; ``ends``: whether the lower, the upper one is in the sine."""
    both = Factors((*sine.roots, *cosine.roots), (*sine.pairs, *cosine.pairs), 2)
    clock, root = Oscillating(low, high, both), (high - low).sqrt()

    def shares(x: arb) -> tuple[arb, arb]:
        products = [arb(1), arb(1)]
        for inside, share in zip(ends, (x / 2).sin_cos(), strict=True):
            products[0 if inside else 1] *= root * share
        return products[0], products[1]

    return Variable(clock, shares, sine, cosine)


def _tending(limit: arb, last: arb, sine: Factors, cosine: Factors, side: int) -> Variable:
    """Of v < limit, side 1, or v > limit, side -1."""
    far = abs(limit - last)
    clock = Tending(limit, last, Factors((*sine.roots, *cosine.roots), (), 4 / far.sqrt()))

    def shares(x: arb) -> tuple[arb, arb]:
        return side * far.sqrt() * x.tanh(), far * square(x.sech())

    return Variable(clock, shares, sine, cosine)


class Separated:
    """A motion with G > 0, at the precision in force."""

    def __init__(self, start: Start, regime: Regime) -> None:
        a, H, G = start.a, start.H, start.G
        plus, minus = discriminants(start)
        of_plus = cubic_roots(H + 2 * a, G, plus)
        of_minus = cubic_roots(H - 2 * a, G, minus)
        self._a = ball(a)
        sine = Factors(((1, -of_plus.low), (1, -of_plus.high)))
        real = () if of_minus.pairs else ((1, -of_minus.low), (1, -of_minus.high))
        cosine = Factors(real, [(-middle, height) for middle, height in of_minus.pairs])
        self._u = _between(of_minus.positive, of_plus.positive, sine, cosine, (False, True))
        self._v = _second(regime, of_plus, of_minus, self._a)
        first, second = (
            variable.clock.at(_phase(variable.clock, z, 2 * self._a * z * sin))
            for variable, (z, sin) in zip((self._u, self._v), sines(start), strict=True)
        )
        self._constants = first.S - second.S, first.U + second.U

    @property
    def means(self) -> tuple[arb, arb] | None:
        """The mean rates of the phases of two variables that oscillate; else None."""
        u, v = self._u.clock, self._v.clock
        if not (isinstance(u, Oscillating) and isinstance(v, Oscillating)):
            return None
        across = (u.S[-1] * v.U[-1] + v.S[-1] * u.U[-1]) / arb.pi()
        return v.S[-1] / across, u.S[-1] / across

    @property
    def period(self) -> arb | None:
        """Of the state where v is constant; else None."""
        u, v = self._u.clock, self._v.clock
        if not (isinstance(u, Oscillating) and isinstance(v, Standing)):
            return None
        return 4 * (u.U[-1] + v.z * u.S[-1])

    def at(self, t: arb) -> SeparatedPoint:
        """The point at a time."""
        x, y = self._phases(t)
        u, xi = self._u.halves(x, self._a)
        v, et = self._v.halves(y, self._a)
        return positive(u, v, xi, et)

    def _phases(self, t: arb) -> tuple[arb, arb]:
        """The phases of u and v at a time."""
        c, now = self._constants[0], self._constants[1] + t
        x, y = self._guess(c, now)
        u_clock, v_clock = self._u.clock, self._v.clock
        small, rough = arb(2) ** -(ctx.prec // 2), True
        for _ in range(_STEPS):
            first, second = u_clock.at(x, rough=rough), v_clock.at(y, rough=rough)
            miss, late = first.S - second.S - c, first.U + second.U - now
            dx, dy = _step(first, second, miss, late)
            (along, size), (across, other_size) = (
                _moved(clock, z, place.f, step)
                for clock, z, place, step in ((u_clock, x, first, dx), (v_clock, y, second, dy))
            )
            size = max(size, other_size)
            if not size.is_finite():
                raise TooFewBits
            if not rough and size < small:
                return self._proven((x, y), (first, second), (dx, dy), (miss, late))
            rough = rough and size > _ROUGH
            x, y = (x - along).mid(), (y - across).mid()
        raise TooFewBits

    def _proven(
        self,
        place: tuple[arb, arb],
        points: tuple[Place, Place],
        steps: tuple[arb, arb],
        misses: tuple[arb, arb],
    ) -> tuple[arb, arb]:
        """Balls around the phases at a time, from a place near them."""
        boxes = [x + arb(0, (3 * step).abs_upper()) for x, step in zip(place, steps, strict=True)]
        slopes = [
            variable.clock.slope(box)
            for variable, box in zip((self._u, self._v), boxes, strict=True)
        ]
        wide = [Place(point.S, point.U, f, z) for point, (f, z) in zip(points, slopes, strict=True)]
        moved = _step(wide[0], wide[1], *misses)
        phases = [x - step for x, step in zip(place, moved, strict=True)]
        for box, x in zip(boxes, phases, strict=True):
            if not (x.is_finite() and box.contains_interior(x)):
                raise TooFewBits
        return phases[0], phases[1]

    def _guess(self, c: arb, now: arb) -> tuple[arb, arb]:
        """The phases by doubles, from tables of both variables."""
        clocks = self._u.clock, self._v.clock
        sigma = (now / (clocks[0].mean + clocks[1].mean)).mid()
        parts = clocks[0].split(sigma), clocks[1].split((sigma - c).mid())
        target = float((now - parts[0].U - parts[1].U).mid())

        def at(moved: float) -> tuple[float, float, tuple[arb, arb]]:
            (u, z, x), (v, w, y) = (
                clock.near(part.rest + moved) for clock, part in zip(clocks, parts, strict=True)
            )
            return u + v - target, z + w, (parts[0].phase + x, parts[1].phase + y)

        high = float((1 / self._a).mid())
        while at(high)[0] < 0 < high or at(-high)[0] > 0:
            high *= 2
        low, moved = -high, 0.0
        for _ in range(_HALVINGS):
            miss, speed, _ = at(moved)
            low, high = (low, moved) if miss > 0 else (moved, high)
            new = moved - miss / speed
            if not low < new < high:
                new = (low + high) / 2
            if abs(new - moved) < _NEAR * abs(moved):
                break
            moved = new
        x, y = at(moved)[2]
        return x.mid(), y.mid()


def _moved(clock: Clock, x: arb, f: arb, step: arb) -> tuple[arb, arb]:
    """A step that leads not farther than f is known, whole turns apart, and its size by that."""
    if isinstance(clock, Standing):
        return step.mid(), arb(0)
    part = clock.split((f * step).mid())
    rest, scale = (step - part.S / f).mid(), clock.scale(x)
    size = abs(rest) / scale
    if size > 1:
        rest = rest / size
    return part.phase + rest, size if part.phase.is_zero() else size.max(arb(1))


def _step(u: Place, v: Place, miss: arb, late: arb) -> tuple[arb, arb]:
    """Newton's step of both phases: the inverse of [[f, -g], [z f, w g]] on what is missed."""
    f, g = u.f, v.f
    zf, wg = u.z * f, v.z * g
    across = f * wg + g * zf
    return (wg * miss + g * late) / across, (f * late - zf * miss) / across


def sines(start: Start) -> tuple[tuple[arb, arb], tuple[arb, arb]]:
    """u and sin xi, v and sin et at a start that is not at rest: sin xi = 2q g3/u - g2."""
    p, q, r = start.omega
    flat = 4 * (p * p + q * q)
    larger = (abs(ball(r)) + ball(r * r + 4 * flat).sqrt()) / 2
    smaller = ball(flat) / larger
    u, v = (larger, smaller) if sign(r) >= 0 else (smaller, larger)
    across, level = 2 * ball(q * start.gamma[2]), ball(start.gamma[1])
    return (u, across / u - level), (v, across / v + level)


def _second(regime: Regime, of_plus: CubicRoots, of_minus: CubicRoots, a: arb) -> Variable:
    """v of a kind of motion, from the roots of P+ and P-."""
    v1, v2, w1, w2 = of_plus.low, of_plus.high, of_minus.low, of_minus.high
    plus, minus = (1, -of_plus.positive), (1, -of_minus.positive)
    if regime == Regime.CONSTANT_ZERO:
        return _standing(v1, a, sine=False)
    if regime == Regime.CONSTANT_PI:
        return _standing(w1, a, sine=True)
    if regime == Regime.GENERIC_WHOLE:
        return _between(v1, v2, Factors((plus,)), Factors((minus,), of_minus.pairs), (True, True))
    if regime == Regime.GENERIC_LOW:
        return _between(
            v1, w1, Factors(((-1, v2), plus)), Factors(((-1, w2), minus)), (True, False)
        )
    if regime == Regime.GENERIC_HIGH:
        return _between(w2, v2, Factors(((1, v1), plus)), Factors(((1, w1), minus)), (False, True))
    if regime == Regime.ASYMPTOTIC_LOW:
        return _tending(w1, v1, Factors(((-1, v2), plus)), Factors((minus,)), 1)
    return _tending(w1, v2, Factors(((1, v1), plus)), Factors((minus,)), -1)


def _standing(z: arb, a: arb, *, sine: bool) -> Variable:
    """Of v constant, where the sine or the cosine of et/2 is 1."""
    nothing, root = Factors(()), (4 * a * z).sqrt()
    halves = (root, arb(0)) if sine else (arb(0), root)
    return Variable(Standing(z), lambda _: halves, nothing, nothing)


def _phase(clock: Clock, z: arb, twice: arb) -> arb:
    """The phase at the start; ``twice``: 2 z_s."""
    if isinstance(clock, Standing):
        return arb(0)
    f = clock.integrand.value(z)
    if isinstance(clock, Tending):
        share = (z - clock.limit) / clock.width
        return (-twice * f / (4 * (z - clock.limit)) / share.sqrt()).asinh()
    sin, cos = twice * f / clock.width, 1 - 2 * (z - clock.low) / clock.width
    # Away from the cut of the argument: any phase that differs by 2 pi does.
    return arb.atan2(sin, cos) if cos.mid() > 0 else arb.pi() - arb.atan2(sin, -cos)
