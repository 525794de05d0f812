"""Lagrange's equations in the Euler angles psi theta phi of the principal axes (3.43–3.46).

L = ½ (A p² + B q² + C r²) - Mg r0·gamma in angles and rates.  Its equations
d/dt dL/dpsi' - dL/dpsi = 0 (theta, phi) are Euler's along the line of nodes, across it and along
the third axis; with p' q' r' from these the mass matrix is solved in closed form:

    psi'' sin theta = p' sin phi + q' cos phi + theta' (phi' - psi' cos theta),
    theta'' = p' cos phi - q' sin phi - psi' phi' sin theta,
    phi'' = r' - psi'' cos theta + psi' theta' sin theta.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from polhode.equations.form import Coefficients, FormValues, OmegaAndGamma
from polhode.equations.forms import angles, principal
from polhode.equations.forms.angles import Angles, InAngles
from polhode.equations.forms.natural_units import own_units, present
from polhode.numbers.number_types import Functions, Scalar
from polhode.scenes.scene import Scene

NAME = "lagrangian"
SOURCE = "3.43–3.46"
VARIABLES = (*angles.ANGLES, *angles.RATES)


def accelerations(
    turn: Angles, rates: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions
) -> tuple[Scalar, Scalar, Scalar]:
    """psi'' theta'' phi'' from the angles and their rates."""
    s, c, sf, cf = turn
    psi1, theta1, phi1 = rates
    p1, q1, r1 = principal.field([*turn.omega(*rates), *turn.gamma], k, fn)[:3]
    psi2 = (p1 * sf + q1 * cf + theta1 * (phi1 - psi1 * c)) / s
    lifted = psi1 * s
    return psi2, p1 * cf - q1 * sf - lifted * phi1, r1 - psi2 * c + lifted * theta1


class Lagrangian(InAngles):
    """The form for one scene; see :mod:`polhode.equations.forms`."""

    def field(self, values: FormValues, k: Coefficients, fn: Functions) -> list[Scalar]:
        """The rates of psi theta phi psi' theta' phi'."""
        turn = Angles.of(values[1], values[2], fn)
        return [*values[3:], *accelerations(turn, values[3:], k, fn)]

    def state(self, values: FormValues, k: Coefficients, fn: Functions) -> OmegaAndGamma:
        """Components of w and of gamma."""
        turn = Angles.of(values[1], values[2], fn)
        return turn.omega(*values[3:]), turn.gamma


def for_scene(scene: Scene) -> Lagrangian:
    """The form; raises BadInput at sin theta = 0."""
    own = own_units(scene, NAME)
    start = angles.start(scene, own, NAME)
    k = principal.coefficients(scene.body) | present(own.coefficients())
    return Lagrangian(scene, VARIABLES, k, (*start.angles, *start.rates))
