"""Which scenes are a Kovalevskaya top's, and the kinds of motion, told by exact arithmetic.

Symbols as in :mod:`polhode.closed_forms.kovalevskaya.axes`.  One-frequency motions (Gashenenko et
al., Rigid Body Dynamics, 2012; Kharlamov 1965): Delaunay's k = 0 and the special motions of
Appelrot's second and third class; both pendulums and Bobylev and Steklov's q = 0, G3 = p r are
motions of other bodies too, and left to them.  A curve is degenerate where two of the points e1,
e2, e3, k, -k are equal:

    (H a^2 - 2m^2)^2 = k^2 a^4  (an e is k or -k),    disc S = 0  (two e's are equal).

The first kind has a formula where an e is -k (:mod:`.degenerate`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from fractions import Fraction

from polhode.closed_forms.balls.periodic_attitude import Strip
from polhode.closed_forms.balls.weierstrass import Quartic
from polhode.closed_forms.family import ENCLOSED_ATTITUDE, Placement
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart, is_node, top_start
from polhode.closed_forms.kovalevskaya.branch_points import discriminant, kind
from polhode.closed_forms.membership import (
    Condition,
    Misfit,
    NormalScene,
    PrincipalScene,
    equal,
    shortfall,
)
from polhode.numbers.exact import ZERO, Exact, exact, sign, sqrt
from polhode.numbers.mpmath_context import mpc, mpf
from polhode.numbers.number_types import Scalar
from polhode.scenes.body import KOVALEVSKAYA, classical_top

_CHECKED = "states are proven; of the attitude the formula is checked, the arithmetic proven"


class Regime(StrEnum):
    """The kinds of motion that are not generic; a generic one is named by the type of its curve."""

    DELAUNAY = "Delaunay"
    APPELROT = "Appelrot, special motion"
    ASYMPTOTIC = "degenerate curve, asymptotic"
    QUASI_PERIODIC = "degenerate curve, quasi-periodic"
    OTHER = "degenerate curve, no formula"


ONE_FREQUENCY = (Regime.DELAUNAY, Regime.APPELROT)
DEGENERATE = (Regime.ASYMPTOTIC, Regime.QUASI_PERIODIC)


@dataclass(kw_only=True)
class KovalevskayaPlacement(Placement):
    """The start in the top's axes and units; ``disc``: the discriminant of S."""

    start: KovalevskayaStart
    disc: Exact
    strip: Strip | None = field(default=None)

    def most_bits(self, digits: int) -> int:
        """Ever more bits would take minutes: near some motions no number of them is enough."""
        return 20 * digits + 3_000

    def curve_of(self, numbers: Mapping[str, mpf]) -> dict[str, object]:
        """H, K^2 = k^2, the points e1, e2, e3 and the period matrix tau, in time units of 1/n.

        n is rounded to a power of two, 2^exponent.  tau is None on a degenerate curve.
        """
        pair = sign(self.disc) < 0

        def row(name: str) -> list[Scalar] | None:
            if f"{name}0 real" not in numbers:
                return None
            both = [(numbers[f"{name}{n} real"], numbers[f"{name}{n} imag"]) for n in range(3)]
            real = [name == "e" and not (pair and n) for n in range(3)]
            return [x if plain else mpc(x, y) for (x, y), plain in zip(both, real, strict=True)]

        shown: dict[str, object] = {"exponent": self.start.exponent}
        shown |= {"H": numbers["H"], "K2": numbers["K2"], "e": row("e"), "tau": row("tau")}
        return shown


def place(scene: PrincipalScene) -> KovalevskayaPlacement | None:
    """A Kovalevskaya top's motion that has a formula."""
    top = top_start(scene)
    if top is None:
        return None
    frame, start = top
    if is_simpler(start):
        return None
    kind = regime(start)
    if kind == Regime.OTHER:
        return None
    has_attitude = True
    proven: bool | str = True
    if kind in ONE_FREQUENCY:
        has_attitude = quartic(start, kind).has_period
    elif kind in DEGENERATE:
        has_attitude = False
    else:
        proven = _CHECKED
    return KovalevskayaPlacement(
        regime=kind,
        frame=frame,
        unit=Fraction(2) ** start.exponent,
        vertical=start.weight,
        proven=proven if has_attitude else ENCLOSED_ATTITUDE,
        has_attitude=has_attitude,
        is_dear=True,
        start=start,
        disc=discriminant(start),
    )


def misfit(scene: PrincipalScene) -> Misfit | None:
    """Why a scene is not one's, or its motion has no formula."""
    if classical_top(scene.moments, scene.torque).kind != KOVALEVSKAYA:
        return shortfall(conditions, scene)
    if place(scene) is not None:
        return None
    top = top_start(scene)
    if top is not None and is_simpler(top[1]):
        return Misfit("a motion that is not one of other bodies too")
    return Misfit("a motion that has a formula on its degenerate curve")


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, its axes in the top's order."""
    A, B, C = scene.moments
    yield equal("A = B", A, B)
    yield equal("A = 2C", A, 2 * C)
    yield equal("z0 = 0", scene.torque[2], ZERO, lambda: scene.weight)


def regime(start: KovalevskayaStart) -> Regime | str:
    """The name of the motion; of a generic one the type of its curve."""
    return _one_frequency(start) or _degenerate(start) or kind(start)


def is_simpler(start: KovalevskayaStart) -> bool:
    """Whether the motion is one of any body: a permanent rotation, or of a pendulum, or at rest.

    Motions of Bobylev and Steklov, of any B, are among these: q = 0 and G3 = p r.
    """
    (p, q, r), (_, G2, G3) = start.omega, start.G
    if sign(q) == 0 and sign(G3 - p * r) == 0:
        return True
    return sign(p) == 0 and sign(r) == 0 and sign(G2) == 0


def _one_frequency(start: KovalevskayaStart) -> Regime | None:
    if sign(start.k2) == 0:
        return Regime.DELAUNAY
    return Regime.APPELROT if centre(start) is not None else None


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


def _degenerate(start: KovalevskayaStart) -> Regime | None:
    """The name of a motion on a degenerate curve, k > 0; None where the curve is none.

    Where an e is -k alone, w^2 = -2 (s + k)^2 c(s): with c(-k) > 0 the node is a point alone, with
    c(-k) < 0 the motion tends to the one-frequency motion that sits there.
    """
    at_k, twice = is_node(start), sign(discriminant(start)) == 0
    if not at_k:
        return Regime.OTHER if twice else None
    side = 2 * start.m2 - start.H * start.a2  # S(k) = k a^2 - side, S(-k) = -k a^2 - side
    if twice or sign(side) > 0:
        return Regime.OTHER
    # c = (s - k)(s - e1)(s - e2), (s - e1)(s - e2) = S/(s + k); at -k it is S'(-k).
    # -2k S'(-k), S'(-k) = 3k^2 - 2Hk + b; k = -side/a^2.
    k = -side / start.a2
    value = sign(3 * k * k - 2 * start.H * k + start.b)
    if value == 0:
        return Regime.OTHER
    return Regime.QUASI_PERIODIC if value < 0 else Regime.ASYMPTOTIC


def quartic(start: KovalevskayaStart, kind: Regime | str) -> Quartic:
    """The f of a motion of one frequency, exact."""
    if kind == Regime.DELAUNAY:
        return Quartic((exact(1) / 4, ZERO, -start.H / 12, start.m / 4, -start.a2 / 4))
    r = start.omega[2]
    xh, ro, x = appelrot_numbers(start)
    # E = r^2/4 + 2 xh (p - xh) + xh^2 cos^2 ps, the cosine (p - xh)/ro
    E = r * r / 4 + 2 * xh * x + xh * xh * x * x / (ro * ro)
    ends = (E + 2 * xh * ro - xh * xh) / 4, (E - 2 * xh * ro - xh * xh) / 4
    return Quartic((ends[0], ZERO, (E + xh * xh) / 12, ZERO, ends[1]))


def appelrot_numbers(start: KovalevskayaStart) -> tuple[Exact, Exact, Exact]:
    """xh, ro (of the sign of p - xh) and p - xh."""
    xh = centre(start)
    assert xh is not None
    p, q, _ = start.omega
    x = p - xh
    ro = sqrt(x * x + q * q)
    return xh, (-ro if sign(x) < 0 else ro), x
