"""The surface of one level on which orbits close: h, f and |gamma|^2, their gradients, the rates.

In principal axes and the run's unit of time, moments and Mg r0 divided by the largest moment, so
that everything is of order one:

    h = ½ w·I w + Mg r0·gamma,  f = I w·gamma,  n = |gamma|²
    grad h = (I w, Mg r0),  grad f = (I gamma, I w),  grad n = (0, 2 gamma)
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from polhode.common.values import ByValue, cached_property
from polhode.equations.forms import principal
from polhode.motion.frame import Frame
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles, GivenRow
from polhode.numbers.scalars import FLOATS, Scalar
from polhode.numbers.vectors import dot
from polhode.scenes.scene import Scene
from polhode.taylor.heyoka import OutOfRange
from polhode.taylor.variations import Flow


@dataclass(frozen=True, eq=False)
class Surface(ByValue):
    """The level (h, f) of a scene's body; ``h`` and ``f`` exact, in the scene's units."""

    scene: Scene
    h: Exact
    f: Exact

    @cached_property
    def inside(self) -> Scene:
        """The scene inside its frame."""
        return Frame.of(self.scene).inside(self.scene)

    @cached_property
    def unit(self) -> Fraction:
        """The run's unit of time in the scene's."""
        return Frame.of(self.scene).unit

    @cached_property
    def exact_moments(self) -> tuple[Exact, ...]:
        """A, B, C over the largest."""
        largest = max(self.scene.body.moments)
        return tuple(a / largest for a in self.scene.body.moments)

    @cached_property
    def exact_torque(self) -> tuple[Exact, ...]:
        """Mg r0 over the largest moment."""
        body = self.inside.body
        return tuple(x / max(body.moments) for x in body.torque)

    @cached_property
    def exact_level(self) -> tuple[Exact, Exact]:
        """h and f."""
        largest = max(self.scene.body.moments)
        return self.h * self.unit * self.unit / largest, self.f * self.unit / largest

    @cached_property
    def exact_start(self) -> tuple[Exact, ...]:
        """The scene's own start."""
        return self.inside.start

    @cached_property
    def coefficients(self) -> dict[str, Exact]:
        """Of the equations."""
        return principal.coefficients(self.inside.body)

    @cached_property
    def moments(self) -> Doubles:
        """A, B, C over the largest."""
        return np.array([to_double(a) for a in self.exact_moments])

    @cached_property
    def torque(self) -> Doubles:
        """Mg r0 over the largest moment."""
        return np.array([to_double(x) for x in self.exact_torque])

    @cached_property
    def level(self) -> Doubles:
        """h, f and 1."""
        return np.array([*(to_double(x) for x in self.exact_level), 1.0])

    @cached_property
    def shortest(self) -> float:
        """No orbit on the level closes in less, by 2 pi over a Lipschitz constant of the rates.

        (J. A. Yorke, Proc. Amer. Math. Soc. 22 (1969) 509.)  With W above every |w| and
        W^2 >= 2|T|/C, T = Mg r0 and C the least moment, the Jacobian of the rates of (w/W, gamma)
        has four blocks no larger than sqrt(2) W, W/2, W and W: L < 2.07 W.
        """
        least, torque = float(self.moments.min()), float(np.linalg.norm(self.torque))
        fastest = (2 * (max(0.0, float(self.level[0])) + torque) / least) ** 0.5
        return 2 * np.pi / (2.07 * fastest) if fastest else np.inf

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
        try:
            return Flow(self.coefficients, DOUBLE, derivative)
        except OutOfRange as fault:
            raise fault.refusal(self.scene.name, DOUBLE) from None

    def rates(self, state: Doubles) -> Doubles:
        """The time derivative of a state."""
        return np.array(principal.field([*state], self._numbers, FLOATS))

    @cached_property
    def _numbers(self) -> dict[str, float]:
        return {name: to_double(x) for name, x in self.coefficients.items()}

    def integrals(self, state: Doubles) -> Doubles:
        """h, f and |gamma|^2 of a state."""
        return np.array(integrals(self.moments, self.torque, state))

    def gradients(self, state: Doubles) -> Doubles:
        """Their gradients, three rows of six."""
        return np.array(gradients(self.moments, self.torque, state))

    def scale(self, state: Doubles) -> Doubles:
        """What an error of each component is measured by: the rates' scale, and 1."""
        fastest = max(float(np.linalg.norm(state[:3])), float(np.linalg.norm(self.torque)) ** 0.5)
        return np.array([fastest] * 3 + [1.0] * 3)


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
