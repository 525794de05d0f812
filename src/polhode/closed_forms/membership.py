"""What a family of closed forms is, which scenes belong to one, and why others do not."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from fractions import Fraction
from typing import NamedTuple, TypeAlias

from flint import arb

from polhode.closed_forms.balls.frames import MotionAxes, SolvedMotion
from polhode.numbers.decimals import decimal_string
from polhode.numbers.exact import ONE, ZERO, Exact, exact, log10, nearest, rounded, sign, sqrt
from polhode.numbers.mpmath_context import mpf
from polhode.numbers.number_types import Scalar
from polhode.numbers.vectors import Vector, cross, dot, is_zero, minus, momentum, scaled
from polhode.scenes.scene import Scene

# --- misfit ---------------------------------------------------------------------------------------
#
# Why a scene does not belong to a family of closed forms.


class Misfit(NamedTuple):
    """Why a scene does not belong to a family: the condition that fails, and by how much.

    ``condition``: as in "A = 2C".  ``off``: by how much its two sides differ, relative to the
    size of what is compared; None for a condition that holds or does not, with nothing between.
    ``order``: which principal axes (0, 1, 2) are the family's axes 1, 2, 3, where they have other
    names there.  ``worst``: by how much the condition that is off most is, where that is another.
    """

    condition: str
    off: Exact | None = None
    order: tuple[int, int, int] = (0, 1, 2)
    worst: Exact | None = None

    def within(self, share: Fraction) -> bool:
        """Whether all conditions hold up to that share of what is compared."""
        worst = self.off if self.worst is None else self.worst
        return worst is not None and worst <= share

    def __str__(self) -> str:
        if self.off is None:
            return self.condition
        off = decimal_string(nearest(self.off, 60), 3)
        names = ""
        if self.order != (0, 1, 2):
            names = f" (its axes 1, 2, 3 are here {', '.join(str(i + 1) for i in self.order)})"
        return f"{self.condition}{names}, off by {off}"


# --- principal scene ------------------------------------------------------------------------------
#
# A body and its start in principal axes, exact: what decides which closed form fits.


_USUAL = 256  # bits: numbers whose binary exponents are within are products of few doubles


class PrincipalScene(NamedTuple):
    """A body and its start in principal axes, every number exact.

    ``moments``: the principal moments A, B, C.  ``torque``: Mg r0.  ``omega`` and ``gamma``: the
    angular velocity and the upward vertical at t = 0; ``gamma`` is None where a torque-free body
    was given without it, never for a heavy one.
    """

    moments: Vector
    torque: Vector
    omega: Vector
    gamma: Vector | None


def in_principal_axes(scene: Scene) -> PrincipalScene:
    """The body and the start of a scene in the body's principal axes."""
    body = scene.body
    along = body.axes.components
    gamma = None if scene.gamma is None else along(scene.gamma)
    return PrincipalScene(body.moments, along(body.torque), along(scene.omega), gamma)


def in_usual_units(scene: PrincipalScene) -> tuple[PrincipalScene, Fraction]:
    """A heavy body in units where doubles hold its numbers, and the unit of its rates."""
    mass = log2(max(scene.moments))
    fastest = [log2(x) for x in scene.omega if sign(x)]
    fastest += [(log2(x) - mass) / 2 for x in scene.torque if sign(x)]
    inertia, rate = _unit(mass), _unit(max(fastest, default=0.0))
    moments, torque = scaled(1 / inertia, scene.moments), scaled(1 / inertia, scene.torque)
    torque, omega = scaled(1 / (rate * rate), torque), scaled(1 / rate, scene.omega)
    return PrincipalScene(moments, torque, omega, scene.gamma), rate


def log2(x: Exact) -> float:
    """log2 |x|, to a bit; -inf at 0."""
    mantissa, exponent = rounded(x, 8)
    return math.log2(abs(mantissa)) + exponent if mantissa else -math.inf


def _unit(log2_size: float) -> Fraction:
    """1, or a power of two of such a size."""
    return Fraction(2) ** round(log2_size) if abs(log2_size) > _USUAL else Fraction(1)


# --- family ---------------------------------------------------------------------------------------
#
# How a family places a scene in axes of its own, with what solves it there.


#: What :attr:`Placement.proven` says where the attitude has no formula.
ENCLOSED_ATTITUDE = "states are proven by the closed form, the attitude by an enclosure"

#: Numbers of balls of a motion, by name, to the digits asked for.
Sure: TypeAlias = Callable[[Callable[[SolvedMotion], Mapping[str, arb | None]]], Mapping[str, mpf]]


@dataclass(frozen=True, kw_only=True)
class Placement:
    """A body and its start in the axes and units of a family, with the kind of motion.

    ``solve``: the motion at the precision in force, from exact numbers that the placing found.
    """

    regime: StrEnum | str
    solve: Callable[[], SolvedMotion]
    #: The family's axes within the principal ones, which they are unless given.
    frame: MotionAxes = field(default_factory=MotionAxes)
    #: So many of the family's units of rates make one of the scene's; negative: time runs back.
    unit: Fraction = Fraction(1)
    #: The length of the family's vertical, negative in axes that are the opposites of the frame's.
    vertical: Exact = ONE
    #: The conditions that body and start meet, where the family names them.
    held: tuple[str, ...] = ()
    #: Whether theorems and balls prove every digit, or a text that says what else they rest on;
    #: False: the digits are only reproduced, with more bits.
    proven: bool | str = True
    #: Whether it has the attitude too; else a reference encloses it.
    has_attitude: bool = True
    #: Whether a row costs so much that of a table of very many only some are judged.
    is_dear: bool = False
    #: Of which axis about which a frequency is, by its name, where the name leaves it open.
    rates_of: Mapping[str, str] = field(default_factory=dict)
    #: A cap on the bits, in place of the usual one: so many for each digit, and so many more.
    cap: tuple[int, int] | None = None
    #: The algebraic curve on which the motion is linear, where the family tells it.
    curve: Callable[[Sure], dict[str, object]] | None = None


@dataclass(frozen=True)
class Family:
    """One family of closed forms.

    ``name``: the word of ``reference.kind`` in a scene file.  ``place``: a scene in the family's
    axes, found by exact arithmetic alone; None of one that does not belong.  ``misfit``: why one
    does not; None of one that belongs.
    """

    name: str
    place: Callable[[PrincipalScene], Placement | None]
    misfit: Callable[[PrincipalScene], Misfit | None]


# --- normal form ----------------------------------------------------------------------------------
#
# The axes in which a case has its normal form, and the conditions that it asks of a scene.
#
# A signed permutation P of the principal axes takes the moments to their permutation, polar
# vectors (Mg r0, gamma) v to P v, and the angular velocity, an axial vector, to det(P) P w:
# reflections are allowed. A case fits a scene if one of the 48 brings the scene to where all its
# conditions hold.


_ORDERS = 3  # of magnitude by which conditions that fail together may differ
_EVEN = ((0, 1, 2), (1, 2, 0), (2, 0, 1))


class NormalAxes(NamedTuple):
    """Axis n of the normal form is ``signs[n]`` times principal axis ``order[n]``."""

    order: tuple[int, int, int]
    signs: tuple[int, int, int]

    @property
    def determinant(self) -> int:
        """1, or -1 for a reflection."""
        x, y, z = self.signs
        return x * y * z * (1 if self.order in _EVEN else -1)

    def axial(self, v: Sequence[Scalar]) -> tuple[Scalar, Scalar, Scalar]:
        """An axial vector, from principal axes to the normal ones."""
        return self.polar(v, self.determinant)

    def polar(self, v: Sequence[Scalar], side: int = 1) -> tuple[Scalar, Scalar, Scalar]:
        """A polar vector likewise, times ``side``; any scalars."""
        (i, j, k), (x, y, z) = self.order, self.signs
        return (
            v[i] if side * x > 0 else -v[i],
            v[j] if side * y > 0 else -v[j],
            v[k] if side * z > 0 else -v[k],
        )

    def placed(self, moments: Vector, torque: Vector, omega: Vector, gamma: Vector) -> NormalScene:
        """A scene, given in principal axes, in these."""
        a, b, c = (moments[i] for i in self.order)
        return NormalScene((a, b, c), self.polar(torque), self.axial(omega), self.polar(gamma))


#: All 48, the scene's own axes first.
ALL_AXES = tuple(
    NormalAxes(order, (x, y, z))
    for order in (*_EVEN, (1, 0, 2), (0, 2, 1), (2, 1, 0))
    for x, y, z in itertools.product((1, -1), repeat=3)
)


class NormalScene(NamedTuple):
    """A body and its start in some axes, exactly; ``torque`` is Mg r0."""

    moments: Vector
    torque: Vector
    omega: Vector
    gamma: Vector

    @property
    def speed(self) -> Exact:
        """A size of w: the largest of |w| and sqrt(P/A), P = |Mg r0| and A the largest moment."""
        fourth = dot(self.torque, self.torque) / max(self.moments) ** 2
        return sqrt(max(dot(self.omega, self.omega), sqrt(fourth)))

    @property
    def weight(self) -> Exact:
        """P."""
        return sqrt(dot(self.torque, self.torque))

    @property
    def momentum(self) -> Vector:
        """Iw."""
        return momentum(self.moments, self.omega)

    @property
    def impulse(self) -> Exact:
        """A size of Iw: the largest of |Iw| and sqrt(A P), what the weight makes of rest."""
        return sqrt(max(dot(self.momentum, self.momentum), max(self.moments) * self.weight))

    @property
    def energy(self) -> Exact:
        """H = w.Iw/2 + T.gamma."""
        return dot(self.momentum, self.omega) / 2 + dot(self.torque, self.gamma)

    @property
    def area(self) -> Exact:
        """F = Iw.gamma."""
        return dot(self.momentum, self.gamma)

    @property
    def moment(self) -> Vector:
        """I w' = gamma x T - w x Iw."""
        return minus(cross(self.gamma, self.torque), cross(self.omega, self.momentum))

    def centred_on_axis_1(self) -> Iterator[Condition]:
        """The centre of mass is on the positive axis 1."""
        yield equal("y0 = 0", self.torque[1], ZERO, lambda: self.weight)
        yield equal("z0 = 0", self.torque[2], ZERO, lambda: self.weight)
        yield positive("x0 > 0", self.torque[0])

    def matching(
        self, gamma: Sequence[Exact], squares: Sequence[Exact] | None = None
    ) -> Iterator[Condition]:
        """Its gamma is that of the formulas; so are q^2 and r^2, if they are given."""
        if squares is not None:
            for name, w, square in zip("qr", self.omega[1:], squares, strict=True):
                yield equal(f"{name}^2 as p requires", w * w, square, lambda: self.speed**2)
        for i, (own, required) in enumerate(zip(self.gamma, gamma, strict=True)):
            yield equal(f"gamma{i + 1} as w requires", own, required, ONE)


class Condition(NamedTuple):
    """One condition of a case: what it says, and by how much a scene is off.

    ``holds``: whether it does, by the rule for *equal*.  ``measure``: how far apart its two sides
    are, relative to the size of what is compared; it is dear, and asked where the condition does
    not hold.  Not ``graded``: there is nothing between holding and not.
    """

    text: str
    holds: bool
    measure: Callable[[], Exact] = lambda: ONE
    graded: bool = True

    @property
    def off(self) -> Exact:
        """0 where the condition holds."""
        return ZERO if self.holds else self.measure()


_NOT_REAL = Condition("real constants of the motion", holds=False, graded=False)

#: A size with which something is compared, or what finds it when it is needed.
Size: TypeAlias = "Exact | Callable[[], Exact]"


def equal(text: str, left: Exact | int, right: Exact | int, size: Size | None = None) -> Condition:
    """left = right; ``size`` in place of |left| + |right|."""
    left, right = exact(left), exact(right)
    difference = left - right

    def measure() -> Exact:
        if size is None:
            return abs(difference) / (abs(left) + abs(right))
        return abs(difference) / (size() if callable(size) else size)

    return Condition(text, sign(difference) == 0, measure)


def vanishing(text: str, vector: Vector, size: Callable[[], Exact]) -> Condition:
    """A vector is 0."""
    return Condition(text, is_zero(vector), lambda: sqrt(dot(vector, vector)) / size())


def positive(text: str, value: Exact) -> Condition:
    """value > 0: it holds or it does not, since nothing near its edge need fit."""
    return Condition(text, sign(value) > 0, graded=False)


def exclusion(text: str, applies: bool) -> Condition:
    """What a case is not: it is told in words, with nothing between."""
    return Condition(text, not applies, graded=False)


#: The conditions of a case, in the order in which they are tested.
Conditions = Callable[[NormalScene], Iterator[Condition]]


def placed_in(
    conditions: Conditions, scene: PrincipalScene, candidates: Sequence[NormalAxes] = ALL_AXES
) -> tuple[NormalAxes, NormalScene] | None:
    """The first axes in which all conditions hold, and the scene in them; None where none do."""
    if scene.gamma is None or is_zero(scene.torque):
        return None
    for axes in candidates:
        normal = axes.placed(scene.moments, scene.torque, scene.omega, scene.gamma)
        if all(condition.holds for condition in conditions(normal)):
            return axes, normal
    return None


def shortfall(conditions: Conditions, scene: PrincipalScene) -> Misfit | None:
    """In the axes that come nearest, the condition that fails; None where all hold.

    Of several, the first that is off by about as much as the worst: those that follow from it fail
    too.
    """
    if scene.gamma is None or is_zero(scene.torque):
        return Misfit("a body on which the weight has a moment")
    best, least = Misfit(_NOT_REAL.text), math.inf
    for axes in ALL_AXES:
        normal = axes.placed(scene.moments, scene.torque, scene.omega, scene.gamma)
        failing = _failing(conditions, normal, least)
        if not failing:
            return None
        worst = max(size for size, _ in failing)
        if worst < least:
            least = worst
            first = next(condition for size, condition in failing if size > least - _ORDERS)
            farthest = next(condition for size, condition in failing if size == worst)
            best = Misfit(first.text)
            if first.graded:
                best = Misfit(first.text, first.off, axes.order, farthest.off)
    return best


def _failing(
    conditions: Conditions, normal: NormalScene, least: float
) -> list[tuple[float, Condition]]:
    """The conditions that fail and log10 of how far, up to one that is off by over 10^least."""
    failing: list[tuple[float, Condition]] = []
    try:
        for condition in conditions(normal):
            if not condition.holds:
                failing.append((log10(condition.off), condition))
                if failing[-1][0] >= least:
                    break
    except (ZeroDivisionError, ValueError):  # constants that are not real
        failing.append((log10(_NOT_REAL.off), _NOT_REAL))
    return failing
