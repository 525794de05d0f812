"""Routh's equations in theta and phi of the principal axes, psi ignored, f given (3.54–3.59).

The Routhian is R = L - f psi' with psi' eliminated by f = dL/dpsi':

    psi' = (f - (A - B) sin theta sin phi cos phi theta' - C cos theta phi')/M,
    M = (A sin² phi + B cos² phi) sin² theta + C cos² theta.

d/dt dR/dtheta' - dR/dtheta = 0 (phi) are Lagrange's equations with this psi'.  Terms linear in f
are odd in the rates: the motion reverses only under t, f -> -t, -f.  Symmetric and spherical bodies
have reduced equations of their own, written at each of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from polhode.equations.form import Coefficients, FormValues, OmegaAndGamma
from polhode.equations.forms import angles, principal
from polhode.equations.forms.angles import Angles, InAngles
from polhode.equations.forms.lagrangian import accelerations
from polhode.equations.forms.natural_units import own_units, present
from polhode.numbers.number_types import Functions, Scalar, combination
from polhode.scenes.scene import Scene

NAME = "routhian"
SOURCE = "3.54–3.59"
VARIABLES = (*angles.ANGLES[1:], *angles.RATES[1:])


def precession(turn: Angles, rates: Sequence[Scalar], k: Coefficients, fn: Functions) -> Scalar:
    """psi' from f (3.54)."""
    s, c, sf, cf = turn
    theta1, phi1 = rates
    rest = combination(k, fn.zero, ("f", 1), ("B-A", s * sf * cf * theta1), ("C", -(c * phi1)))
    M = (k["A"] * (sf * sf) + k["B"] * (cf * cf)) * (s * s) + k["C"] * (c * c)
    return rest / M


def general(
    turn: Angles, rates: Sequence[Scalar], k: Coefficients, fn: Functions
) -> tuple[Scalar, Scalar]:
    """theta'' and phi'' of a body with any moments (3.56)."""
    psi1 = precession(turn, rates, k, fn)
    _, theta2, phi2 = accelerations(turn, (psi1, *rates), k, fn)
    return theta2, phi2


def symmetric(
    turn: Angles, rates: Sequence[Scalar], k: Coefficients, fn: Functions
) -> tuple[Scalar, Scalar]:
    """theta'' and phi'' for A = B (3.58).

    With l = C/A, n = 1 - l, g = f/A, M = 1 - n cos² theta, N = 1 + n cos² theta:
    R/A = ½ theta'² + ½ l sin² theta phi'²/M + g l cos theta phi'/M - ½ g²/M - V/A,

        theta'' = sin theta (l² cos theta phi'² - l g N phi' + n g² cos theta)/M² - V_theta/A,
        phi'' = theta' (g N - 2 l cos theta phi')/(M sin theta) - M V_phi/(C sin² theta).
    """
    s, c = turn.s, turn.c
    theta1, phi1 = rates
    lift = k["n"] * (c * c)
    M, spin = 1 - lift, k["l"] * phi1
    gN = combination(k, fn.zero, ("g", 1 + lift))
    across = spin * spin * c - spin * gN + combination(k, fn.zero, ("n.g2", c))
    by_theta, by_phi = turn.slopes(k, fn.zero)
    theta2 = s * across / (M * M) - k["1/A"] * by_theta
    return theta2, theta1 * (gN - 2 * (c * spin)) / (s * M) - k["1/C"] * M * by_phi / (s * s)


def spherical(
    turn: Angles, rates: Sequence[Scalar], k: Coefficients, fn: Functions
) -> tuple[Scalar, Scalar]:
    """theta'' and phi'' for A = B = C, with g = f/A:

    theta'' = sin theta phi' (cos theta phi' - g) - V_theta/A,
    phi'' = theta' (g - 2 cos theta phi')/sin theta - V_phi/(A sin² theta).
    """
    s, c = turn.s, turn.c
    theta1, phi1 = rates
    lean, g = c * phi1, combination(k, fn.zero, ("g", 1))
    by_theta, by_phi = turn.slopes(k, fn.zero)
    theta2 = s * phi1 * (lean - g) - k["1/A"] * by_theta
    return theta2, theta1 * (g - 2 * lean) / s - k["1/A"] * by_phi / (s * s)


def about_second_axis(
    turn: Angles, rates: Sequence[Scalar], k: Coefficients, fn: Functions
) -> tuple[Scalar, Scalar]:
    """theta'' and phi'' for A = C (3.59), the second axis one of symmetry.

    With e = (B - A)/A, g = f/A, gamma2 = sin theta cos phi and N = e q, N' = e q' known from
    B q' = (Mg gamma × r0)_2:

        psi' = (g + e gamma2 sin phi theta' - cos theta phi')/(1 + e gamma2²),
        theta'' = N' sin phi + N cos phi (phi' + psi' cos theta) - psi' phi' sin theta - V_theta/A,
        sin² theta phi'' = theta' (sin theta (psi' - cos theta phi') + N cos² theta cos phi) - N p
            + cos theta (N' gamma2 - N gamma1 phi') - V_phi/A.
    """
    s, c, sf, cf = turn
    theta1, phi1 = rates
    g1, g2, g3 = turn.gamma
    e_g2 = k["e"] * g2
    psi1 = combination(k, fn.zero, ("g", 1)) + e_g2 * sf * theta1 - c * phi1
    psi1 = psi1 / (1 + e_g2 * g2)
    p, q, r = turn.omega(psi1, theta1, phi1)
    N = k["e"] * q
    N1 = combination(k, fn.zero, ("e.x/B", g3), ("e.z/B", -g1))
    by_theta, by_phi = turn.slopes(k, fn.zero)
    theta2 = N1 * sf + N * cf * r - psi1 * phi1 * s - k["1/A"] * by_theta
    above = theta1 * (s * (psi1 - c * phi1) + N * (c * c) * cf) - N * p
    above = above + c * (N1 * g2 - N * g1 * phi1) - k["1/A"] * by_phi
    return theta2, above / (s * s)


@dataclass(frozen=True)
class Routhian(InAngles):
    """The form for one scene; ``reduced``: its body's equations for theta'' and phi''."""

    theta = 0
    reduced: Callable[[Angles, Sequence[Scalar], Coefficients, Functions], tuple[Scalar, Scalar]]

    def field(self, values: FormValues, k: Coefficients, fn: Functions) -> list[Scalar]:
        """The rates of theta phi theta' phi'."""
        turn = Angles.of(values[0], values[1], fn)
        return [*values[2:], *self.reduced(turn, values[2:], k, fn)]

    def state(self, values: FormValues, k: Coefficients, fn: Functions) -> OmegaAndGamma:
        """Components of w and of gamma."""
        turn = Angles.of(values[0], values[1], fn)
        return turn.omega(precession(turn, values[2:], k, fn), *values[2:]), turn.gamma


def for_scene(scene: Scene) -> Routhian:
    """The form, reduced as its body allows; raises BadInput at sin theta = 0."""
    own = own_units(scene, NAME)
    start = angles.start(scene, own, NAME)
    A, B, C = own.moments
    f, g = own.area, own.area / A
    k = own.coefficients() | {"f": f, "B-A": B - A, "g": g, "1/A": 1 / A, "1/C": 1 / C}
    if A == B == C:
        reduced = spherical
    elif A == B:
        reduced = symmetric
        k |= {"l": C / A, "n": (A - C) / A, "n.g2": (A - C) / A * g * g}
    elif A == C:
        reduced = about_second_axis
        x, _, z = own.torque
        e = (B - A) / A
        k |= {"e": e, "e.x/B": e * x / B, "e.z/B": e * z / B}
    else:
        reduced = general
        k |= principal.coefficients(scene.body)
    first = (*start.angles[1:], *start.rates[1:])
    return Routhian(scene, VARIABLES, present(k), first, reduced)
