"""The kinds of motion of the Kovalevskaya top, told by exact arithmetic.

Symbols as in :mod:`polhode.closed_forms.kovalevskaya.axes`.  One-frequency motions (Gashenenko et
al., Rigid Body Dynamics, 2012; Kharlamov 1965): both pendulums, Delaunay's k = 0, Bobylev and
Steklov's q = 0, G3 = p r, and the special motions of Appelrot's second and third class.  A curve is
degenerate where two of the points e1, e2, e3, k, -k are equal:

    (H a^2 - 2m^2)^2 = k^2 a^4  (an e is k or -k),    disc S = 0  (two e's are equal).

The first kind has a formula where an e is -k (:mod:`.degenerate`).
"""

from __future__ import annotations

from collections.abc import Iterator

from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart, top_start
from polhode.closed_forms.kovalevskaya.branch_points import discriminant, kind
from polhode.closed_forms.kovalevskaya.node import is_node
from polhode.closed_forms.membership import (
    Condition,
    Misfit,
    Placed,
    PrincipalScene,
    equal,
    shortfall,
)
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.scenes.body import KOVALEVSKAYA, classical_top

HANGING, UPRIGHT = "rest, hanging", "rest, upright"
ROTATION = "permanent rotation"
PENDULUM_Z = "pendulum about the axis of symmetry"
PENDULUM_Y = "pendulum about an equatorial axis"
BOBYLEV, DELAUNAY, APPELROT = "Bobylev-Steklov", "Delaunay", "Appelrot, special motion"
ASYMPTOTIC, QUASI_PERIODIC = "degenerate curve, asymptotic", "degenerate curve, quasi-periodic"
OTHER = "degenerate curve, no formula"

STEADY = (HANGING, UPRIGHT, ROTATION)
ONE_FREQUENCY = (PENDULUM_Z, PENDULUM_Y, BOBYLEV, DELAUNAY, APPELROT)
DEGENERATE = (ASYMPTOTIC, QUASI_PERIODIC)


def _is_top(scene: PrincipalScene) -> bool:
    return classical_top(scene.moments, scene.torque).kind == KOVALEVSKAYA


def fits(scene: PrincipalScene) -> bool:
    """Whether the body is a Kovalevskaya top, and the motion has a formula."""
    return _is_top(scene) and has_formula(top_start(scene, None)[1])


def misfit(scene: PrincipalScene) -> Misfit | None:
    """Why a scene is not one's, or its motion has no formula."""
    if not _is_top(scene):
        return shortfall(conditions, scene)
    return None if fits(scene) else Misfit("a motion that has a formula on its degenerate curve")


def conditions(scene: Placed) -> Iterator[Condition]:
    """Those of the body, its axes in the top's order."""
    A, B, C = scene.moments
    yield equal("A = B", A, B)
    yield equal("A = 2C", A, 2 * C)
    yield equal("z0 = 0", scene.torque[2], ZERO, scene.weight)


def regime(start: KovalevskayaStart) -> str:
    """The name of the motion; of a generic one the type of its curve."""
    return _one_frequency(start) or _degenerate(start) or kind(start)


def _one_frequency(start: KovalevskayaStart) -> str | None:
    (p, q, r), (G1, G2, G3) = start.omega, start.G
    if sign(q) == 0 and sign(G3 - p * r) == 0:
        if sign(G2) == 0 and sign(r * (G1 - p * p)) == 0:
            if sign(p) == 0 == sign(r):
                return UPRIGHT if sign(G1) > 0 else HANGING
            return ROTATION
        return PENDULUM_Z if sign(p) == 0 else BOBYLEV
    if sign(p) == 0 and sign(r) == 0 and sign(G2) == 0:
        return PENDULUM_Y
    if sign(start.k2) == 0:
        return DELAUNAY
    if centre(start) is not None:
        return APPELROT
    return None


def centre(start: KovalevskayaStart) -> Exact | None:
    """The constant xh = G3/r of Appelrot's special motion; None for any other.

    There G1 + iG2 = 2 xh (1 + xh (p - xh)/ro^2)(p - xh + iq) with ro^2 = (p - xh)^2 + q^2.
    """
    (p, q, r), (G1, G2, G3) = start.omega, start.G
    if sign(r) != 0:
        xh = G3 / r
    elif sign(G3) == 0 and sign(G2) != 0:
        xh = p - G1 * q / G2
    else:
        return None
    x = p - xh
    ro2 = x * x + q * q
    if sign(ro2) == 0:
        return None
    factor = 2 * xh * (ro2 + xh * x)
    if sign(G1 * ro2 - factor * x) == 0 and sign(G2 * ro2 - factor * q) == 0:
        return xh
    return None


def passes_the_vertical(start: KovalevskayaStart, name: str) -> bool:
    """Whether the third axis of a motion of one frequency is exactly vertical, G1 + iG2 = 0.

    A pendulum about y has G1 = H - q^2; Appelrot's motion passes ro + xh cos ps = 0, as its r^2/4
    is E + ro^2 - (ro + xh cos ps)^2, wherever |ro| <= |xh|.
    """
    if name == PENDULUM_Y:
        return sign(start.H) >= 0
    xh = centre(start) if name == APPELROT else None
    if xh is None:
        return False
    p, q, _ = start.omega
    return sign(p * p - 2 * p * xh + q * q) <= 0  # ro^2 - xh^2


def has_formula(start: KovalevskayaStart) -> bool:
    """Whether the motion has one here: on other degenerate curves it is left to the enclosure."""
    return _one_frequency(start) is not None or _degenerate(start) != OTHER


def _degenerate(start: KovalevskayaStart) -> str | None:
    """The name of a motion on a degenerate curve, k > 0; None where the curve is none.

    Where an e is -k alone, w^2 = -2 (s + k)^2 c(s): with c(-k) > 0 the node is a point alone, with
    c(-k) < 0 the motion tends to the one-frequency motion that sits there.
    """
    at_k, twice = is_node(start), sign(discriminant(start)) == 0
    if not at_k:
        return OTHER if twice else None
    side = 2 * start.m2 - start.H * start.a2  # S(k) = k a^2 - side, S(-k) = -k a^2 - side
    if twice or sign(side) > 0:
        return OTHER
    # c = (s - k)(s - e1)(s - e2), (s - e1)(s - e2) = S/(s + k); at -k it is S'(-k).
    # -2k S'(-k), S'(-k) = 3k^2 - 2Hk + b; k = -side/a^2.
    k = -side / start.a2
    value = sign(3 * k * k - 2 * start.H * k + start.b)
    if value == 0:
        return OTHER
    return QUASI_PERIODIC if value < 0 else ASYMPTOTIC
