"""Omega and the attitude's quaternion in principal axes; gamma is derived (3.12, remark).

    w' as in (3.29),    q' = ½ q ⊗ (0, w),    gamma = third row of R(q),

with R formed from q as it is, not normalised: |gamma| = |q|², and a norm that drifts shows.  The
norm is an integral of these equations; the run holds it by a projection that it reports.
Variables: p q r q0 q1 q2 q3, in principal axes.
"""

from __future__ import annotations

from polhode.common.errors import BadInput
from polhode.equations import kinematics
from polhode.equations.form import Coefficients, Form, FormValues, OmegaAndGamma
from polhode.equations.forms import principal
from polhode.numbers.number_types import Functions, Scalar
from polhode.numbers.vectors import vertical
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE

NAME = "quaternion"
SOURCE = "3.12, remark"


class QuaternionForm(Form):
    """The equations of one scene; ``unit``: which variables form a vector of length one."""

    unit = slice(3, 7)

    def field(self, values: FormValues, k: Coefficients, fn: Functions) -> list[Scalar]:
        """The rates of p q r q0 q1 q2 q3."""
        omega, gamma = self.state(values, k, fn)
        rates = principal.field([*omega, *gamma], k, fn)[:3]
        return rates + kinematics.attitude_rates(values[self.unit], omega)

    def state(self, values: FormValues, k: Coefficients, fn: Functions) -> OmegaAndGamma:
        """omega, and gamma from the quaternion as it is."""
        return list(values[:3]), list(vertical(values[self.unit]))


def for_scene(scene: Scene) -> QuaternionForm:
    """The equations of a scene; it must have gamma, which says where the attitude begins."""
    if scene.gamma is None:
        expected = "another form, or a start.gamma: the attitude begins from it"
        raise BadInput(scene.name, "form", NAME, expected)
    start = (*scene.omega, *kinematics.starting_attitude(scene.gamma, scene.psi))
    k = principal.coefficients(scene.body)
    return QuaternionForm(scene, (*scene.columns[:3], *_NAMES), k, start)


#: Apart from the names of the attitude's own variables, which an output may add.
_NAMES = tuple(f"unit_{name}" for name in ATTITUDE)
