"""The kinds of motion of the Kovalevskaya top, told by exact arithmetic.

Symbols as in :mod:`polhode.closed_forms.kovalevskaya.axes`.  One-frequency motions (Gashenenko et
al., Rigid Body Dynamics, 2012; Kharlamov 1965): both pendulums, Delaunay's k = 0, Bobylev and
Steklov's q = 0, G3 = p r, and the special motions of Appelrot's second and third class.  A curve is
degenerate where two of the points e1, e2, e3, k, -k are equal:

    (H a^2 - 2m^2)^2 = k^2 a^4  (an e is k or -k),    disc S = 0  (two e's are equal).
"""

from __future__ import annotations

from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.branch_points import discriminant, kind
from polhode.numbers.exact import Exact, sign

HANGING, UPRIGHT = "rest, hanging", "rest, upright"
ROTATION = "permanent rotation"
PENDULUM_Z = "pendulum about the axis of symmetry"
PENDULUM_Y = "pendulum about an equatorial axis"
BOBYLEV, DELAUNAY, APPELROT = "Bobylev-Steklov", "Delaunay", "Appelrot, special motion"
ASYMPTOTIC, QUASI_PERIODIC = "degenerate curve, asymptotic", "degenerate curve, quasi-periodic"
MULTIPLE = "multiply degenerate curve"

STEADY = (HANGING, UPRIGHT, ROTATION)
ONE_FREQUENCY = (PENDULUM_Z, PENDULUM_Y, BOBYLEV, DELAUNAY, APPELROT)
DEGENERATE = (ASYMPTOTIC, QUASI_PERIODIC, MULTIPLE)


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


def passes_poles(start: KovalevskayaStart) -> bool:
    """Whether an e is k or -k: elsewhere the top's third axis is never vertical.

    There it is vertical along curves on the torus, which a motion crosses again and again.
    """
    lever = 2 * start.m2 - start.H * start.a2
    return sign(lever * lever - start.k2 * start.a2 * start.a2) == 0


def _degenerate(start: KovalevskayaStart) -> str | None:
    """The name of a motion on a degenerate curve, k > 0; None where the curve is none.

    With K the double root, w^2 = -2 (s - K)^2 c(s): where c(K) > 0 the node is a point alone, where
    c(K) < 0 the motion tends to the one-frequency motion that sits there.
    """
    H, b, m2, a2, k2 = start.H, start.b, start.m2, start.a2, start.k2
    side = 2 * m2 - H * a2  # S(k) = k a^2 - side, S(-k) = -k a^2 - side
    at_k = passes_poles(start)
    c, d = b, H * b - 2 * m2  # s^3 + H s^2 + c s + d
    twice = sign(discriminant(start)) == 0
    if not at_k and not twice:
        return None
    if at_k and twice:
        return MULTIPLE
    if twice:
        spread = H * H - 3 * c
        if sign(spread) == 0:
            return MULTIPLE
        K = (9 * d - H * c) / (2 * spread)
        third = -H - 2 * K
        value = sign((K - third) * (K * K - k2))
    elif sign(side) > 0:
        return MULTIPLE  # e = k without the special motion: none is known
    else:
        # K = -k: c = (s - k)(s - e1)(s - e2), (s - e1)(s - e2) = S/(s + k); at -k it is S'(-k).
        # -2k S'(-k), S'(-k) = 3k^2 - 2Hk + b; k = -side/a^2.
        k = -side / a2
        value = -sign(3 * k * k - 2 * H * k + b)
    if value == 0:
        return MULTIPLE
    return QUASI_PERIODIC if value > 0 else ASYMPTOTIC
