"""The axes in which a case has its normal form, and the conditions that it asks of a scene.

A signed permutation P of the principal axes takes the moments to their permutation, polar vectors
(Mg r0, gamma) v to P v, and the angular velocity, an axial vector, to det(P) P w: reflections are
allowed.  A case fits a scene if one of the 48 brings the scene to where all its conditions hold.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from polhode.closed_forms.membership.misfit import Misfit
from polhode.closed_forms.membership.principal_scene import PrincipalScene
from polhode.numbers.exact import ONE, ZERO, Exact, exact, log10, sign, sqrt
from polhode.numbers.scalars import Scalar
from polhode.numbers.vectors import Vector, cross, dot, is_zero, minus, momentum

_ORDERS = 3  # of magnitude by which conditions that fail together may differ
_EVEN = ((0, 1, 2), (1, 2, 0), (2, 0, 1))


@dataclass(frozen=True)
class NormalAxes:
    """Axis n of the normal form is ``signs[n]`` times principal axis ``order[n]``."""

    order: tuple[int, int, int]
    signs: tuple[int, int, int]

    @property
    def determinant(self) -> int:
        """1, or -1 for a reflection."""
        x, y, z = self.signs
        return x * y * z * (1 if self.order in _EVEN else -1)

    def polar(self, v: Sequence[Scalar]) -> tuple[Scalar, Scalar, Scalar]:
        """A polar vector, from principal axes to the normal ones; any scalars."""
        x, y, z = (s * v[i] for s, i in zip(self.signs, self.order, strict=True))
        return x, y, z

    def axial(self, v: Sequence[Scalar]) -> tuple[Scalar, Scalar, Scalar]:
        """An axial vector, from principal axes to the normal ones."""
        x, y, z = (self.determinant * u for u in self.polar(v))
        return x, y, z

    def placed(self, moments: Vector, torque: Vector, omega: Vector, gamma: Vector) -> Placed:
        """A scene, given in principal axes, in these."""
        a, b, c = (moments[i] for i in self.order)
        return Placed((a, b, c), self.polar(torque), self.axial(omega), self.polar(gamma))


#: All 48, the scene's own axes first.
ALL_AXES = tuple(
    NormalAxes(order, (x, y, z))
    for order in (*_EVEN, (1, 0, 2), (0, 2, 1), (2, 1, 0))
    for x, y, z in itertools.product((1, -1), repeat=3)
)


@dataclass(frozen=True)
class Placed:
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


@dataclass(frozen=True)
class Condition:
    """One condition of a case: what it says, and by how much a scene is off.

    ``off`` is relative to the size of what is compared; 0 where the condition holds, 1 where an
    ungraded one, with nothing between, does not.
    """

    text: str
    off: Exact
    graded: bool = True

    @property
    def holds(self) -> bool:
        """Whether it holds, by the rule for *equal*."""
        return sign(self.off) == 0


_NOT_REAL = Condition("real constants of the motion", ONE, graded=False)


def equal(text: str, left: Exact | int, right: Exact | int, size: Exact | None = None) -> Condition:
    """left = right; ``size`` in place of |left| + |right|."""
    left, right = exact(left), exact(right)
    difference = left - right
    if sign(difference) == 0:
        return Condition(text, ZERO)
    return Condition(text, abs(difference) / (abs(left) + abs(right) if size is None else size))


def positive(text: str, value: Exact) -> Condition:
    """value > 0: it holds or it does not, since nothing near its edge need fit."""
    return Condition(text, ZERO if sign(value) > 0 else ONE, graded=False)


def exclusion(text: str, applies: bool) -> Condition:
    """What a case is not: it is told in words, with nothing between."""
    return Condition(text, ONE if applies else ZERO, graded=False)


def moving(scene: Placed) -> Condition:
    """Not all six right-hand sides vanish."""
    moment = minus(cross(scene.gamma, scene.torque), cross(scene.omega, scene.momentum))
    still = is_zero(moment) and is_zero(cross(scene.gamma, scene.omega))
    return exclusion("no permanent rotation", still)


def matching(
    scene: Placed, gamma: Sequence[Exact], squares: Sequence[Exact] | None = None
) -> Iterator[Condition]:
    """The start's gamma is that of the formulas; so are q^2 and r^2, if they are given."""
    if squares is not None:
        size = scene.speed * scene.speed
        for name, w, square in zip("qr", scene.omega[1:], squares, strict=True):
            yield equal(f"{name}^2 as p requires", w * w, square, size)
    for i, (one, other) in enumerate(zip(scene.gamma, gamma, strict=True)):
        yield equal(f"gamma{i + 1} as w requires", one, other, ONE)


def on_axis_1(scene: Placed) -> Iterator[Condition]:
    """The centre of mass is on the positive axis 1."""
    yield equal("y0 = 0", scene.torque[1], ZERO, scene.weight)
    yield equal("z0 = 0", scene.torque[2], ZERO, scene.weight)
    yield positive("x0 > 0", scene.torque[0])


#: The conditions of a case, in the order in which they are tested.
Conditions = Callable[[Placed], Iterator[Condition]]


def placed_in(conditions: Conditions, scene: PrincipalScene) -> tuple[NormalAxes, Placed] | None:
    """The first axes in which all conditions hold, and the scene in them; None where none do."""
    if scene.gamma is None or is_zero(scene.torque):
        return None
    for axes in ALL_AXES:
        placed = axes.placed(scene.moments, scene.torque, scene.omega, scene.gamma)
        if all(condition.holds for condition in conditions(placed)):
            return axes, placed
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
        placed = axes.placed(scene.moments, scene.torque, scene.omega, scene.gamma)
        failing = _failing(conditions, placed, least)
        if not failing:
            return None
        sizes = [log10(condition.off) for condition in failing]
        if max(sizes) < least:
            least = max(sizes)
            first = next(n for n, size in enumerate(sizes) if size > least - _ORDERS)
            text, off, graded = failing[first].text, failing[first].off, failing[first].graded
            worst = failing[sizes.index(least)].off
            best = Misfit(text, off, axes.order, worst) if graded else Misfit(text)
    return best


def _failing(conditions: Conditions, placed: Placed, least: float) -> list[Condition]:
    """The conditions that fail, up to one that is off by more than 10^least."""
    failing: list[Condition] = []
    try:
        for condition in conditions(placed):
            if not condition.holds:
                failing.append(condition)
                if log10(condition.off) >= least:
                    break
    except (ZeroDivisionError, ValueError):  # constants that are not real
        failing.append(_NOT_REAL)
    return failing
