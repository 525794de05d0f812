"""The system that a run integrates: a form of the equations and what its outputs add."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from polhode.equations import kinematics
from polhode.equations.form import Form, equations
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Functions, Scalar
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ANGLE_VARIABLES, ATTITUDE


@dataclass(frozen=True)
class System:
    """Variables, exact coefficients and exact start of what is integrated: a form and outputs.

    All of it is inside the form's frame, but that quaternion and angles are those of the scene's
    axes; the quaternion is there for the angles, too.
    """

    form: Form
    names: tuple[str, ...]
    outputs: tuple[str, ...]
    coefficients: Mapping[str, Exact]
    start: tuple[Exact, ...]
    still: bool = False  # a relative equilibrium: no rate but zero

    def rounded(self, number: NumberType) -> System:
        """The same with coefficients and start rounded to a number type."""
        return replace(
            self,
            coefficients={name: number.rounded(x) for name, x in self.coefficients.items()},
            start=tuple(number.rounded(x) for x in self.start),
        )

    def field(
        self, state: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions
    ) -> list[Scalar]:
        """Rates of the state and of what the outputs ask for."""
        n = len(self.form.variables)
        if self.still:
            return [fn.zero] * n
        rates = self.form.field(state[:n], k, fn)
        if not self.outputs:
            return rates
        vectors = self.form.state(state[:n], k, fn)
        omega, gamma = (kinematics.in_scene_axes(vector, k, fn.zero) for vector in vectors)
        rates += kinematics.attitude_rates(state[n : n + 4], omega)
        if "angles" in self.outputs:
            rates += kinematics.angle_rates(omega, gamma)
        return rates


def system(scene: Scene, outputs: Sequence[str]) -> System:
    """The equations of a scene with these outputs and nothing else."""
    form = equations(scene)
    names, start, k = [*form.variables], [*form.start], dict(form.coefficients)
    if scene.gamma is not None:
        if outputs:
            k |= form.frame.turn
            names += ATTITUDE
            start += kinematics.starting_attitude(scene.gamma, scene.psi)
        if "angles" in outputs:
            names += ANGLE_VARIABLES
            start += [scene.psi, kinematics.starting_phi(scene.gamma)]
    return System(form, tuple(names), tuple(outputs), k, tuple(start))
