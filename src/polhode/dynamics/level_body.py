"""A body on one of its levels (h, f), in numbers: of sections, maps, orbits and frequencies.

In the body's principal axes and the run's unit of time:

    h = ½ w·I w + Mg r0·gamma,  f = I w·gamma,  n = |gamma|²
    grad h = (I w, Mg r0),  grad f = (I gamma, I w),  grad n = (0, 2 gamma)
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from polhode.common.arguments import each
from polhode.common.errors import BadInput
from polhode.common.values import ByValue, cached_property
from polhode.equations.forms import principal
from polhode.motion.frame import Frame
from polhode.numbers import exact
from polhode.numbers.conversion import AREA, ENERGY, reader, to_double
from polhode.numbers.decimals import shown
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.number_types import DOUBLE, FLOATS, AnyNumber, Doubles, GivenRow, Scalar
from polhode.numbers.polynomials import fraction_near
from polhode.numbers.vectors import dot
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    from polhode.taylor.variations import Flow

_NEAR_BITS, _SHORT_BITS = 1024, 256  # of a level's rational number; of its denominator
SEED = 18  # of random tangents
_LARGEST = 1e50  # of |G|, and 1 over its least: sixth powers stay in the range of doubles
_FASTEST = 1e15  # |w|, and 1 over its least: so do those of 20th order in a Taylor step
_ALIKE = 4  # powers of two by which a level's fastest rate may differ from 1
_SEEDS, _DESCENT = 200, 60  # on the sphere, from which the least energy is looked for; steps


@dataclass(frozen=True, eq=False)
class LevelBody(ByValue):
    """A scene's body on the level (h, f), exactly and in doubles; its level need not exist.

    ``h``, ``f``: exact, in the scene's units.  ``slower``: the power of two by which the unit of
    time is longer than that of the scene's frame.
    """

    scene: Scene
    h: Exact
    f: Exact
    slower: int = 0

    @classmethod
    def of(cls, scene: Scene) -> LevelBody:
        """A scene's body on its own level; f = 0 where it has no gamma."""
        energy, area, *_ = scene.integrals
        return cls(scene, simplest(energy), ZERO if area is None else simplest(area))

    def at(self, by: str, value: Exact) -> LevelBody:
        """The same body at another h, or another f; ``by``: which."""
        return replace(self, h=value) if by == "h" else replace(self, f=value)

    # -- exactly

    @cached_property
    def frame(self) -> Frame:
        """Its axes and unit of time in the scene's."""
        return Frame.of(self.scene).slower(self.slower)

    @cached_property
    def inside(self) -> Scene:
        """The scene inside this frame."""
        return self.frame.inside(self.scene)

    @cached_property
    def unit(self) -> Fraction:
        """The unit of time in the scene's."""
        return self.frame.unit

    @cached_property
    def mass(self) -> Fraction:
        """The scene's unit of mass in that of the doubles: a power of 2**64.

        1 unless the scene's is far from the body's: products of several doubles stay in range.
        """
        exponent = exact.exponent_above(max(self.scene.body.moments))
        return Fraction(2) ** -(64 * round(exponent / 64))

    @cached_property
    def units(self) -> tuple[Fraction, Fraction]:
        """Those of h and f in the scene's."""
        momentum = 1 / (self.mass * self.unit)
        return momentum / self.unit, momentum

    @cached_property
    def exact_moments(self) -> tuple[Exact, ...]:
        """A, B, C over the largest."""
        return tuple(a / max(self.scene.body.moments) for a in self.scene.body.moments)

    @cached_property
    def exact_torque(self) -> tuple[Exact, ...]:
        """Mg r0 over the largest moment."""
        return tuple(x / max(self.scene.body.moments) for x in self.inside.body.torque)

    @cached_property
    def exact_level(self) -> tuple[Exact, Exact]:
        """h and f over the largest moment."""
        largest = max(self.scene.body.moments)
        return self.h * self.unit * self.unit / largest, self.f * self.unit / largest

    @property
    def exact_start(self) -> tuple[Exact, ...]:
        """The scene's own start."""
        return self.inside.start

    @cached_property
    def coefficients(self) -> dict[str, Exact]:
        """Of the equations."""
        return principal.coefficients(self.inside.body)

    # -- in doubles

    @cached_property
    def numbers(self) -> dict[str, float]:
        """The coefficients of the equations."""
        return {name: to_double(x) for name, x in self.coefficients.items()}

    @cached_property
    def moments(self) -> Doubles:
        """A, B, C."""
        return np.array([to_double(self.mass * a) for a in self.scene.body.moments])

    @cached_property
    def torque(self) -> Doubles:
        """Mg r0."""
        return np.array([to_double(self.mass * x) for x in self.inside.body.torque])

    @cached_property
    def level(self) -> Doubles:
        """h and f."""
        energy, area = self.units
        return np.array([to_double(self.h / energy), to_double(self.f / area)])

    @cached_property
    def relative(self) -> tuple[Doubles, Doubles, Doubles]:
        """Moments, Mg r0 and the level (h, f, 1), all but 1 over the largest moment."""
        exact_numbers = self.exact_moments, self.exact_torque, (*self.exact_level, Fraction(1))
        moments, torque, level = (np.array([to_double(x) for x in v]) for v in exact_numbers)
        return moments, torque, level

    @cached_property
    def start(self) -> Doubles:
        """The scene's own start."""
        return np.array([to_double(x) for x in self.exact_start])

    @cached_property
    def axes(self) -> Doubles:
        """The principal axes along the scene's, a row each."""
        return np.asarray(self.frame.matrix(DOUBLE), dtype=np.float64)

    @cached_property
    def weight(self) -> float:
        """Mg|r0|, its sign that of Mg; 0 without a moment."""
        body = self.scene.body
        if body.torque_free:
            return 0.0
        size = exact.sqrt(dot(body.centre, body.centre))
        return to_double(body.weight * size / self.units[0])

    @cached_property
    def arm_axes(self) -> Doubles:
        """Rows e1, e2, e3, of which e3 is along r0; without weight it is the third principal axis.

        e1 and e2 are principal axes in cyclic order where e3 is one, else e1 lies across the axis
        that e3 is least along.
        """
        body, e3 = self.scene.body, np.array([0.0, 0.0, 1.0])
        if not body.torque_free:
            arm = body.axes.components(body.centre)
            size = exact.sqrt(dot(arm, arm))
            e3 = np.array([to_double(x / size) for x in arm])
        along = np.flatnonzero(e3)
        if len(along) == 1:
            k = int(along[0])
            e1, e2 = np.eye(3)[(k + 1) % 3], np.eye(3)[(k + 2) % 3]
            return np.array([e1, e2 if e3[k] > 0 else -e2, e3])
        e1 = np.cross(np.eye(3)[int(np.argmin(np.abs(e3)))], e3)
        e1 = e1 / np.linalg.norm(e1)
        return np.array([e1, np.cross(e3, e1), e3])

    # -- bounds

    @cached_property
    def largest_momentum(self) -> float:
        """A bound of |G| on the level."""
        return float(np.sqrt(2 * self.moments.max() * self._kinetic))

    @cached_property
    def fastest(self) -> float:
        """A bound of |w| on the level."""
        return float(np.sqrt(2 * self._kinetic / self.moments.min()))

    @cached_property
    def swing(self) -> float:
        """The rate of a pendulum's swing."""
        return math.sqrt(float(np.linalg.norm(self.relative[1])))

    @cached_property
    def shortest(self) -> float:
        """No orbit on the level closes in less, by 2 pi over a Lipschitz constant of the rates.

        (J. A. Yorke, Proc. Amer. Math. Soc. 22 (1969) 509.)  With W above every |w| and
        W^2 >= 2|T|/C, T = Mg r0 and C the least moment, the Jacobian of the rates of (w/W, gamma)
        has four blocks no larger than sqrt(2) W, W/2, W and W: L < 2.07 W.
        """
        moments, torque, level = self.relative
        size, least = float(np.linalg.norm(torque)), float(moments.min())
        fastest = (2 * (max(0.0, float(level[0])) + size) / least) ** 0.5
        return 2 * math.pi / (2.07 * fastest) if fastest else math.inf

    @cached_property
    def least(self) -> float:
        """The least h at this f over the largest moment, to within rounding; nan out of range.

        It is that of W = f^2/(2 gamma.I gamma) + Mg r0.gamma on the sphere, by Newton's method for
        minima from points all over it.
        """
        moments, torque, level = self.relative
        with np.errstate(over="ignore"):
            square = float(level[1] * level[1])
        scale = square + float(np.linalg.norm(torque))
        if not 0 < scale < np.inf:
            return 0.0 if scale == 0 else np.nan
        square, torque = square / scale, torque / scale
        turns = np.arange(_SEEDS) * np.pi * (3 - 5**0.5)
        u = (2 * np.arange(_SEEDS) + 1) / _SEEDS - 1
        across = np.sqrt(1 - u * u)
        gamma = np.stack([across * np.cos(turns), across * np.sin(turns), u], axis=1)
        reach = np.full(_SEEDS, 0.3)
        energy = _reduced_energy(moments, square, torque, gamma)
        for _ in range(_DESCENT):
            ahead = gamma + _descent(moments, square, torque, gamma, reach)
            ahead /= np.linalg.norm(ahead, axis=1)[:, None]
            lower = _reduced_energy(moments, square, torque, ahead)
            falls = lower < energy
            gamma = np.where(falls[:, None], ahead, gamma)
            energy = np.where(falls, lower, energy)
            reach = np.where(falls, np.minimum(2 * reach, 0.3), reach / 4)
        return float(energy.min()) * scale

    @property
    def _kinetic(self) -> float:
        return max(0.0, float(self.level[0]) + abs(self.weight))

    @property
    def in_own_time(self) -> LevelBody:
        """The same in a unit of time near the level's own, where that is far from the run's.

        The run's unit is that of the scene's start, which may be on another level.
        """
        exponent = int(np.frexp(self.fastest)[1]) - 1
        return replace(self, slower=-exponent) if abs(exponent) > _ALIKE else self

    def check(self) -> None:
        """Raise BadInput for an h below all motions, or one that doubles have no room for."""
        name = self.scene.name
        moments, torque, (h, f, _) = self.relative
        with np.errstate(over="ignore"):  # about a principal axis that is vertical there is motion
            reached = float((f * f / (2 * moments) - np.abs(torque)).min())
        if not h > reached and (bound := self._bound()):
            raise BadInput(name, "h", shown(self.h), f"above {bound} at f = {shown(self.f)}")
        momentum, speed = self.largest_momentum, self.fastest
        if not (1 / _LARGEST < momentum < _LARGEST and 1 / _FASTEST < speed < _FASTEST):
            bounds = (
                (_LARGEST, 1 / Fraction(self.moments.max())),
                (_FASTEST, Fraction(self.moments.min())),
            )
            half = self.units[0] / 2
            most = to_double(half * min(Fraction(top) ** 2 * a for top, a in bounds))
            least = to_double(half * max(a / Fraction(top) ** 2 for top, a in bounds))
            expected = f"of a size that doubles have room for: from {least:.3g} to {most:.3g}"
            raise BadInput(name, "h", shown(self.h), expected)

    def _bound(self) -> str:
        """What h is to be above, in words; empty where it is."""
        body = self.scene.body
        if np.isfinite(self.least):
            least = to_double(Fraction(self.least) * self.units[0] * Fraction(self.moments.max()))
            exists = self.relative[2][0] > self.least
            return "" if exists else f"{least:.12g}, the least energy"
        # f^2/2A - |T| at least, A the largest moment
        low = self.f * self.f / (2 * max(body.moments)) - exact.sqrt(dot(body.torque, body.torque))
        return "" if sign(self.h - low) > 0 else f"{shown(low)}, below which there is no motion"

    # -- of states

    @cached_property
    def flow(self) -> Flow:
        """The flow with its derivative, in double."""
        return self._flow(derivative=True)

    @cached_property
    def plain_flow(self) -> Flow:
        """The flow alone, in double."""
        return self._flow(derivative=False)

    def _flow(self, derivative: bool) -> Flow:
        """The flow in double; raises BadInput for a body whose numbers doubles do not hold."""
        from polhode.taylor.heyoka import OutOfRange
        from polhode.taylor.variations import Flow

        try:
            return Flow(self.coefficients, DOUBLE, derivative)
        except OutOfRange as fault:
            raise fault.refusal(self.scene.name, DOUBLE) from None

    def rates(self, state: Doubles) -> Doubles:
        """The time derivative of a state."""
        return np.array(principal.field([*state], self.numbers, FLOATS))

    def integrals(self, state: Doubles) -> Doubles:
        """h and f of a state over the largest moment, and |gamma|^2."""
        return np.array(integrals(*self.relative[:2], state))

    def gradients(self, state: Doubles) -> Doubles:
        """Their gradients, three rows of six."""
        return np.array(gradients(*self.relative[:2], state))

    def scale(self, state: Doubles) -> Doubles:
        """What an error of each component is measured by: the rates' scale, and 1."""
        return np.array([max(float(np.linalg.norm(state[:3])), self.swing)] * 3 + [1.0] * 3)

    def is_still(self, state: Doubles, within: float) -> bool:
        """Whether a state is a permanent rotation: no rate but zero."""
        scale = self.scale(state)
        with np.errstate(all="ignore"):  # a body at rest has no scale of omega: nan, no rotation
            rate = np.max(np.abs(self.rates(state) / scale))
        return bool(rate < within * max(1e-300, float(scale[0])))

    def outside(self, states: Doubles) -> Doubles:
        """States (..., 6) in the scene's axes and units."""
        return _rotated(states, self.axes, float(self.unit))

    def within(self, states: Doubles) -> Doubles:
        """States (..., 6) of the scene's axes and units in these."""
        return _rotated(states, self.axes.T, 1 / float(self.unit))


def level_of(scene: Scene, h: AnyNumber | None = None, f: AnyNumber | None = None) -> LevelBody:
    """A scene's body on a level that exists: its own, but for an h or f; raises BadInput."""
    if scene.gamma is None:
        raise BadInput(scene.name, "start.gamma", None, "a unit vector, since a level has h and f")
    on = LevelBody.of(scene)
    for key, value, unit in (("h", h, ENERGY), ("f", f, AREA)):
        if value is not None:
            (number,) = each(scene.name, key, (value,), reader(scene.units, unit), "a number")
            on = on.at(key, number)
    on.check()
    return on


def _rotated(states: Doubles, rows: Doubles, unit: float) -> Doubles:
    return np.concatenate([states[..., :3] @ rows / unit, states[..., 3:] @ rows], axis=-1)


def simplest(x: Exact) -> Exact:
    """A rational number that x is by the rule for *equal*, if it is a short one; else x.

    A start on a rational level has an irrational omega, from which h and f are computed.
    """
    if isinstance(x, Fraction):
        return x
    near = fraction_near(x, _NEAR_BITS)[0].limit_denominator(2**_SHORT_BITS)
    return near if x == near else x


def _reduced_energy(moments: Doubles, square: float, torque: Doubles, gamma: Doubles) -> Doubles:
    """W at points of the sphere, a row each; ``square``: f^2."""
    return square / (2 * (gamma * gamma @ moments)) + gamma @ torque


def _descent(
    moments: Doubles, square: float, torque: Doubles, gamma: Doubles, reach: Doubles
) -> Doubles:
    """Steps along the sphere down W: Newton's, uphill curvatures turned over, cut at a reach."""
    inertial = gamma * moments
    q = (gamma * inertial).sum(axis=1)[:, None]
    slope = torque - square / q**2 * inertial
    radial = (slope * gamma).sum(axis=1)[:, None]
    slope = slope - radial * gamma
    eye = np.eye(3)
    plane = eye - gamma[:, :, None] * gamma[:, None, :]
    bend = 4 * (square / q**3)[:, :, None] * inertial[:, :, None] * inertial[:, None, :]
    bend = bend - (square / q**2)[:, :, None] * np.diag(moments) - radial[:, :, None] * eye
    sizes, axes = np.linalg.eigh(plane @ bend @ plane + (eye - plane))
    along = (slope[:, None, :] @ axes)[:, 0]
    step = -(axes @ (along / np.maximum(np.abs(sizes), 1e-100))[:, :, None])[:, :, 0]
    step = step - (step * gamma).sum(axis=1)[:, None] * gamma
    length = np.linalg.norm(step, axis=1)
    cut: Doubles = step * np.minimum(1.0, reach / np.maximum(length, 1e-100))[:, None]
    return cut


def integrals(moments: GivenRow, torque: GivenRow, state: GivenRow) -> list[Scalar]:
    """h, f and |gamma|^2 of one state, for any scalars."""
    w, g = state[:3], state[3:]
    momentum = [a * x for a, x in zip(moments, w, strict=True)]
    return [dot(momentum, w) / 2 + dot(torque, g), dot(momentum, g), dot(g, g)]


def gradients(moments: GivenRow, torque: GivenRow, state: GivenRow) -> list[list[Scalar]]:
    """Their gradients, for any scalars."""
    w, g = state[:3], state[3:]
    momentum, inertial = ([a * x for a, x in zip(moments, v, strict=True)] for v in (w, g))
    return [
        [*momentum, *torque],
        [*inertial, *momentum],
        [*(0 * x for x in g), *(2 * x for x in g)],
    ]


def tangents_of(
    starts: Doubles, moments: Doubles, torques: Doubles, alike: bool = False
) -> Doubles:
    """Unit tangents of motions across the flow and the gradients of h, f and n, else at random.

    ``alike``: the random part is the same for all, so that none depends on the others.
    """
    shape = starts.shape[1:] if alike else starts.shape
    tangents = np.random.default_rng(SEED).normal(size=shape) + 0 * starts
    w, g = starts[:, :3], starts[:, 3:]
    G = w * moments
    flow = np.concatenate(
        [(np.cross(g, torques) - np.cross(w, G)) / moments, np.cross(g, w)], axis=1
    )
    across = [
        np.concatenate([G, torques + 0 * G], axis=1),
        np.concatenate([g * moments, G], axis=1),
        np.concatenate([np.zeros_like(g), g], axis=1),
        flow,
    ]
    basis: list[Doubles] = []
    for vector in across:  # Gram and Schmidt, twice
        vector = _across(vector, basis)
        size = np.sqrt((vector * vector).sum(axis=1))[:, None]
        basis.append(np.where(size > 1e-12, vector / np.maximum(size, 1e-300), 0.0))
    tangents = _across(tangents, basis)
    unit: Doubles = tangents / np.sqrt((tangents * tangents).sum(axis=1))[:, None]
    return unit


def _across(vectors: Doubles, basis: list[Doubles]) -> Doubles:
    for _ in range(2):
        for direction in basis:
            vectors = vectors - (vectors * direction).sum(axis=1)[:, None] * direction
    return vectors
