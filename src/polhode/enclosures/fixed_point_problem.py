"""Exact data to integers: the constants, the start and the times of one proof.

Trusted.  The equations are those of :mod:`polhode.equations.terms`, with time in a unit 2**n of the
scene in which |w| and sqrt(Mg|r0|/smallest moment) are at most about 1.  Their coefficients are
kept where they are fractions of a small denominator, and else rounded to 2**-Q, the start to 2**-S,
each with a proven radius (zero for numbers that are exact there).  Every small quantity of the
proof is a double in units of 2**-P, P the noise level.  A run to negative times is one of the start
-w, since t -> -t, w -> -w leaves the equations as they are.

With radii of the start, the set at t = 0 holds every start of the box: a proof is one for each.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb

from polhode.enclosures.polynomial import Polynomial, ball, total, variable
from polhode.equations.terms import (
    PRODUCTS,
    ROWS,
    coefficients_of,
    numbers_of,
    product,
)
from polhode.motion.frame import Frame
from polhode.numbers import exact
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.flint_context import ctx
from polhode.numbers.polynomials import middle
from polhode.numbers.vectors import Vector, dot
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene

CLOCK = 14  # times of the grid are integers times 2**-CLOCK
LEAST_NOISE, MOST_NOISE = 36, 1000  # P: small quantities in units of 2**-P stay within doubles
LEAST_FINE = 60  # S: never coarser than the polynomials, or the first jump is lost
TIME_BITS = 4096  # of a time asked for: on the right side of a step's boundary
UP = 1.0 + 1e-9  # covers fewer than 1e5 roundings of nonnegative doubles
_SMALL = 1 << 40  # a denominator that is shorter than a rounded constant
_FINER = 24  # Q - P: the radii of the constants, times exp(alpha), stay below the noise
_SLOW, _LEAST_WEIGHT = 1.0 / 64.0, 1e-12  # of a pull, and of a moment, for the weights
_SHARPER = 20  # bits behind 2**-S to which every constant must be known
_MOST_BITS = 1 << 15
_WIDEST = 1e100  # in units of 2**-P: whose square is a double


class TooImprecise(ArithmeticError):
    """No proof at this precision; the message says which test failed.

    ``reached``: how far the proof had come, as a part of its way; ``grown``: log2 of what the
    radius was there, in units of 2**-noise.
    """

    def __init__(self, message: str, reached: float = 0.0, grown: float = 0.0) -> None:
        super().__init__(message)
        self.reached, self.grown = reached, grown


@dataclass(frozen=True)
class Problem:
    """One motion as integers with radii; see the module for symbols.

    ``constants``: the coefficients in the order of ``terms.NAMES`` as integers over
    ``denominators``, one for each of the three rows of w; ``slack``: their radii, in units of
    2**-noise.  ``factors``: the same constants as doubles; ``factor_slack``: their radii, absolute.
    ``start``: six integers times 2**-fine; ``spread``: their radii in units of 2**-noise.
    ``weights``: positive, of a norm in which the motion hardly stretches; any would do.
    ``is_box``: whether the start is more than one point.
    """

    noise: int
    fine: int
    constants: tuple[int, ...]
    denominators: tuple[int, ...]
    slack: tuple[float, ...]
    factors: tuple[float, ...]
    factor_slack: tuple[float, ...]
    start: tuple[int, ...]
    spread: tuple[float, ...]
    weights: tuple[float, ...] = (1.0,) * 6
    is_box: bool = False

    @property
    def beta(self) -> float:
        """A bound of |B(e, e)|/|e|²: of each row the sum of what products of two are times."""
        sizes = [abs(x) + r for x, r in zip(self.factors, self.factor_slack, strict=True)]
        rows = (sum(abs(term.of(sizes)) for term in row if term in PRODUCTS) for row in ROWS)
        return UP * float(max(rows))


@dataclass(frozen=True)
class ExactMotion:
    """The exact motion of a scene in principal axes and its proof's unit of time, forward.

    ``frame``: these axes and that unit; ``inside``: the scene in them, in its own sense of time;
    ``backward``: t and w changed sign.
    ``constants``: the coefficients, exact, in the order of ``terms.NAMES``; ``start``: the six,
    exact, gamma zero where there is none.
    ``radii``: of the start, six numbers from 0 on, empty where it is one point.
    """

    scene: Scene
    frame: Frame
    inside: Scene
    backward: bool
    constants: tuple[Exact, ...]
    start: tuple[Exact, ...]
    radii: tuple[Exact, ...] = ()

    @property
    def unit(self) -> int:
        """Time is measured in 2**unit of the scene's."""
        return self.frame.exponent

    @property
    def unit_outside(self) -> Fraction:
        """The unit of time in the scene's, negative for a motion backward."""
        return -self.frame.unit if self.backward else self.frame.unit

    def starts(self, bits: int) -> list[arb]:
        """Balls that hold every start, their middles that of the scene."""
        balls = [ball(x, bits) for x in self.start]
        if not self.radii:
            return balls
        with ctx.workprec(bits):
            return [x + arb(0, 1) * ball(r, bits) for x, r in zip(balls, self.radii, strict=True)]

    @property
    def field(self) -> list[Polynomial]:
        """The right-hand sides as polynomials."""
        x = [variable(i) for i in range(6)]
        return [
            total([product(x, term.factors) * term.of(self.constants) for term in row])
            for row in ROWS
        ]


def motion(scene: Scene, backward: bool = False, radii: Vector | None = None) -> ExactMotion:
    """The exact motion of a scene, to positive or to negative times.

    ``radii``: how far each component of omega may be from the scene's, in its axes; a box in the
    principal axes then holds them all.
    """
    frame = Frame.of(scene).slower(-1)  # in whose unit rates are at most about 1
    inside, unit, rows = frame.inside(scene), frame.unit, frame.axes.rows
    constants = tuple(coefficients_of(numbers_of(inside.body)))
    omega = [-w for w in inside.omega] if backward else [*inside.omega]
    gamma = [exact.ZERO] * 3 if inside.gamma is None else [*inside.gamma]
    box: list[Exact] = []
    if radii is not None:
        around = [[unit * r * abs(x) for x, r in zip(row, radii, strict=True)] for row in rows]
        box = [*(a + b + c for a, b, c in around), *[exact.ZERO] * 3]
    start = (*omega, *gamma)
    return ExactMotion(scene, frame, inside, backward, constants, start, tuple(box))


def problem(of: ExactMotion, noise: int, constant_bits: int | None = None) -> Problem:
    """A motion's data as integers with radii for the noise level 2**-noise.

    ``constant_bits``: the constants are rounded to 2**-that; by default they stay as they are where
    they are fractions of a small denominator, and are rounded to 2**-(noise + 24) elsewhere.
    Raises TooImprecise where a constant cannot be known sharply enough.
    """
    if not LEAST_NOISE <= noise <= MOST_NOISE:
        raise TooImprecise(f"a noise level of 2**-{noise} is outside {LEAST_NOISE} to {MOST_NOISE}")
    fine = max(noise + 12, LEAST_FINE)
    balls = [sharp(x, fine + _SHARPER) for x in of.constants]
    with ctx.workprec(4 * fine + 200):
        whole = _whole(of, balls, noise, constant_bits)
        factors = tuple(float(x.mid()) for x in balls)
        slack = tuple(upper(x - arb(factor)) for x, factor in zip(balls, factors, strict=True))
        start, radii = zip(*(_nearest(x, fine) for x in of.starts(2 * fine + 100)), strict=True)
        spread = tuple(upper(radius * arb((1, noise))) for radius in radii)
    if of.radii and not max(spread) < _WIDEST:
        raise TooImprecise("the start's intervals are too wide")
    weights = _weights(of.inside.body)
    return Problem(noise, fine, *whole, factors, slack, start, spread, weights, bool(of.radii))


def _weights(body: Body) -> tuple[float, ...]:
    """c m_i**(1/2), and 1 for gamma; doubles near them, m_i parts of the largest moment."""
    largest = max(body.moments)
    moments = [max(to_double(m / largest), _LEAST_WEIGHT) for m in body.moments]
    pull = math.hypot(*(to_double(k / largest) for k in body.torque))
    c = 1.0 / math.sqrt(max(pull, _SLOW))
    return (*(c * math.sqrt(m) for m in moments), 1.0, 1.0, 1.0)


def _whole(
    of: ExactMotion, balls: Sequence[Any], noise: int, bits: int | None
) -> tuple[tuple[int, ...], tuple[int, ...], tuple[float, ...]]:
    """The constants as integers over a denominator a row, these, and the radii."""
    count, below = len(of.constants), []
    numerators, slack = [0] * count, [0.0] * count
    for row in ROWS[:3]:
        places = [term.coefficient for term in row if term.coefficient is not None]
        exactly = [x for k in places if isinstance(x := of.constants[k], Fraction)]
        whole = len(exactly) == len(places)
        least = math.lcm(*(x.denominator for x in exactly)) if whole else 0
        if bits is None and 0 < least < _SMALL:
            below.append(least)
            for k, x in zip(places, exactly, strict=True):
                numerators[k] = int(x * least)
            continue
        coarse = noise + _FINER if bits is None else bits
        below.append(1 << coarse)
        for k in places:
            numerators[k], radius = _nearest(balls[k], coarse)
            slack[k] = upper(radius * arb((1, noise)))
    return tuple(numerators), tuple(below), tuple(slack)


def upper(x: Any) -> float:
    """A double not below |x| for every x of a ball; infinite where it is."""
    size = x.abs_upper()
    if not size.is_finite():
        return float("inf")
    return UP * float(size) + (0.0 if size.is_zero() else 1e-300)


def sharp(x: Exact, bits: int) -> arb:
    """The first ball around a number of radius below 2**-bits, as its precision is raised.

    Raises TooImprecise where none is found.
    """
    working = bits + 64
    while working <= _MOST_BITS:
        value: arb = ball(x, working)
        with ctx.workprec(64):
            if value.rad() < arb((1, -bits)):
                return value
        working *= 2
    raise TooImprecise("a constant of the body is not known sharply enough")


def _nearest(value: Any, bits: int) -> tuple[int, Any]:
    """The integer n for which n·2**-bits is near a ball's midpoint, and |ball - n·2**-bits|."""
    near = round(middle(value) * 2**bits) if value.is_finite() else 0
    return near, abs(value - arb((near, -bits)))


def times(of: ExactMotion, instants: Sequence[Exact], bits: int = TIME_BITS) -> list[Any]:
    """Balls around times of the scene, in the proof's unit and forward."""
    return [ball(t / of.unit_outside, bits) for t in instants]


def in_scene_axes(of: ExactMotion, row: Sequence[arb], bits: int) -> list[arb]:
    """A state in principal axes and the proof's unit as balls in the scene's axes and unit."""
    scene = of.scene
    with ctx.workprec(bits):
        by = arb((-1 if of.backward else 1, -of.unit))
        vectors = [[by * x for x in row[:3]]]
        if scene.gamma is not None:
            vectors.append(list(row[3:]))
        if of.frame.axes.trivial:
            return [x for vector in vectors for x in vector]
        turn = [[ball(x, bits) for x in unit] for unit in of.frame.axes.rows]
        return [dot(column, v) for v in vectors for column in zip(*turn, strict=True)]
