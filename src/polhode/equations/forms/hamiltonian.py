"""Hamilton's equations in the Euler angles of the principal axes and their momenta (3.47–3.53).

The momenta dL/dpsi' = f, dL/dtheta', dL/dphi' give I w: n = (p_psi - p_phi cos theta)/sin theta,

    A p = n sin phi + p_theta cos phi,    B q = n cos phi - p_theta sin phi,    C r = p_phi,

H = ½ (A p² + B q² + C r²) + V, V = Mg r0·gamma, and

    psi' = (p sin phi + q cos phi)/sin theta,    theta' = p cos phi - q sin phi,
    phi' = r - psi' cos theta,    p_psi' = 0,
    p_theta' = psi' (p_psi cos theta - p_phi)/sin theta - dV/dtheta,
    p_phi' = (1/B - 1/A) (A p) (B q) - dV/dphi.
"""

from __future__ import annotations

from collections.abc import Sequence

from polhode.equations.form import Coefficients, FormValues, OmegaAndGamma
from polhode.equations.forms import angles as euler_angles
from polhode.equations.forms.angles import Angles, InAngles
from polhode.equations.forms.natural_units import own_units, present
from polhode.numbers import exact
from polhode.numbers.number_types import Functions, Scalar, combination
from polhode.scenes.scene import Scene

NAME = "hamiltonian"
SOURCE = "3.47–3.53"
VARIABLES = (*euler_angles.ANGLES, "p_psi", "p_theta", "p_phi")


def _momentum(turn: Angles, momenta: Sequence[Scalar]) -> list[Scalar]:
    """A p, B q, C r."""
    p_psi, p_theta, p_phi = momenta
    n = (p_psi - p_phi * turn.c) / turn.s
    return [n * turn.sf + p_theta * turn.cf, n * turn.cf - p_theta * turn.sf, p_phi]


class Hamiltonian(InAngles):
    """The form for one scene; momenta in its own unit of mass."""

    def field(self, values: FormValues, k: Coefficients, fn: Functions) -> list[Scalar]:
        """The rates of the angles and of their momenta."""
        turn = Angles.of(values[1], values[2], fn)
        s, c, sf, cf = turn
        p_psi, _, p_phi = values[3:]
        G1, G2, G3 = _momentum(turn, values[3:])
        p, q, r = k["1/A"] * G1, k["1/B"] * G2, k["1/C"] * G3
        psi1 = (p * sf + q * cf) / s
        by_theta, by_phi = turn.slopes(k, fn.zero)
        return [
            psi1,
            p * cf - q * sf,
            r - psi1 * c,
            fn.zero,
            psi1 * (p_psi * c - p_phi) / s - by_theta,
            combination(k, fn.zero, ("1/B-1/A", G1 * G2)) - by_phi,
        ]

    def state(self, values: FormValues, k: Coefficients, fn: Functions) -> OmegaAndGamma:
        """Components of w and of gamma."""
        turn = Angles.of(values[1], values[2], fn)
        names = ("1/A", "1/B", "1/C")
        momentum = _momentum(turn, values[3:])
        return [k[name] * G for name, G in zip(names, momentum, strict=True)], turn.gamma


def for_scene(scene: Scene) -> Hamiltonian:
    """The form; raises BadInput at sin theta = 0."""
    own = own_units(scene, NAME)
    angles = euler_angles.start(scene, own, NAME).angles
    (A, B, C), (G1, G2, G3) = own.moments, own.momentum
    g1, g2, _ = own.gamma
    p_theta = (G1 * g2 - G2 * g1) / exact.sqrt(g1 * g1 + g2 * g2)
    k = own.coefficients() | {"1/A": 1 / A, "1/B": 1 / B, "1/C": 1 / C, "1/B-1/A": 1 / B - 1 / A}
    start = (*angles, own.area, p_theta, G3)
    return Hamiltonian(scene, VARIABLES, present(k), start)
