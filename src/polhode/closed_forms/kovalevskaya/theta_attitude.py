"""The attitude of the Kovalevskaya top's generic motion in balls: theta quotients times exp(c t).

With R = Rz(psi) Rx(theta) Rz(phi), xi = q1 + i q2 and eta = q3 - i q0,

    xi' = (i/2)(x eta - r xi),    eta' = (i/2)(r eta + conj(x) xi),    x = p + i q;
    xi = e^(c t) (A.Th)(z + h + e)/(B.Th)(z + h),    eta = e^(c t) (A'.Th)(z + h + e)/(B'.Th)(z + h)

at z = z0 + t V, with Th_a(z) = th[a, 0](z | 2 tau).  E+-, the images of s = +-sqrt(-b) with the
same w = 2 i m a, give e = -(E+ + E-) and c = sum over both of d_V log th[del + eta_i](E)/2; the
half period h is that of eta_k + eta_(-k), and B, A lie in eigenspaces of the shift by it.

*What is proven.*  The form of xi and eta is a theorem (``polhode guide kovalevskaya-attitude``).
That this e, c and h and one of the four choices of eigenspaces are the right ones is checked, not
proved: balls enclose the value of the formula.  A choice is dropped where it is proven to miss
|xi|^2 or |eta|^2 at one of three times, and every answer must have the state's gamma.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple, TypeAlias

from flint import acb, acb_mat, arb

from polhode.closed_forms.balls.clocks import Pair
from polhode.closed_forms.balls.core import TooFewBits, ball, certainly, either_root
from polhode.closed_forms.balls.frames import Turn, conjugate, halves, quaternion
from polhode.closed_forms.balls.theta2 import Theta2, added
from polhode.closed_forms.kovalevskaya.theta_state import ThetaState, Values, dot
from polhode.common.values import cached_property
from polhode.numbers.exact import ZERO
from polhode.numbers.vectors import quaternion_product, vertical

_HALVES = ((0, 0), (0, 1), (1, 0), (1, 1))
_TIMES = (Fraction(0), Fraction(7, 10), Fraction(19, 10), Fraction(31, 10))  # |w| t, at most

_I = acb(0, 1)

#: Coefficients of the four Th_a.
Vector: TypeAlias = Sequence[acb]
#: Two vectors that span an eigenspace.
Space: TypeAlias = Sequence[Vector]


class Moment(NamedTuple):
    """The state and the functions Th at a time: below at z + h, above at z + h + e.

    The functions are over the exponentials of their logarithms.
    """

    state: Sequence[arb]
    below: Values
    above: Values
    log: acb  # of the factor above over the one below, with c t


class EigenspaceChoice(NamedTuple):
    """A, A' and B, B' of one choice of eigenspaces."""

    tops: Sequence[Vector]
    bottoms: Sequence[Vector]

    def at(self, moment: Moment) -> Pair:
        """xi and eta."""
        factor = moment.log.exp()
        xi, eta = (
            factor * dot(top, moment.above, 0) / dot(bottom, moment.below, 0)
            for top, bottom in zip(self.tops, self.bottoms, strict=True)
        )
        return xi, eta


class ThetaMotion(ThetaState):
    """The generic motion; its attitude is made when it is first asked for."""

    def turn(self, t: arb) -> Turn:
        """The turn since t = 0."""
        return self.attitude.turn(t, self.at(t))

    @cached_property
    def attitude(self) -> ThetaAttitude:
        """Its attitude at this precision."""
        return ThetaAttitude(self)


class ThetaAttitude:
    """The turn of the top's axes since t = 0, at the precision in force.

    Raises TooFewBits where more than one motion fits the start.
    """

    def __init__(self, motion: ThetaState) -> None:
        certainly(len(motion.choices) == 1)
        self.motion, start = motion, motion.start
        a, b, c = (x / start.weight for x in start.G)
        self._first = quaternion(*halves((a, b, c), ZERO))  # one that has the right gamma
        self.e, self.rate = self._third_kind()
        tau = motion.jacobian.lattice.tau
        doubled = 2 * tau[0], 2 * tau[1], 2 * tau[2]
        self.functions = Theta2(doubled, [(*half, 0, 0) for half in _HALVES])
        *_, plus, minus = motion.jacobian.characteristics
        k1, k2, l1, l2 = added(plus, minus)
        k, l = (k1, k2), (l1, l2)
        along = motion.jacobian.lattice.times(k)
        self.h = (l[0] + along[0]) / 2, (l[1] + along[1]) / 2
        self.choices = self._fitting(k, l)

    def turn(self, t: arb, state: Sequence[arb]) -> Turn:
        """The turn until t; ArithmeticError where it has not the gamma of the state then."""
        moment = self._moment(t, state)
        turns = [_turn(choice.at(moment)) for choice in self.choices]
        q = turns[0]
        for turn in turns[1:]:
            a, b, c, d = (x.union(y) for x, y in zip(q, turn, strict=True))
            q = a, b, c, d
        certainly(all(x.is_finite() for x in q))
        self._check(q, state)
        return quaternion_product(conjugate(self._first), q)

    def _check(self, q: Turn, state: Sequence[arb]) -> None:
        """|q| = 1 and gamma against the state, which knows nothing of the attitude."""
        a, b, c, d = q
        size = self.motion.weight
        norm = a * a + b * b + c * c + d * d
        gamma = zip(vertical(q), state[3:], strict=True)
        if not (norm.overlaps(arb(1)) and all(x.overlaps(y / size) for x, y in gamma)):
            raise ArithmeticError("the attitude has not the gamma of the state: a fault")

    def _third_kind(self) -> tuple[Pair, acb]:
        """e and c."""
        motion, jacobian = self.motion, self.motion.jacobian
        w = 2 * _I * motion.m * motion.weight
        root = either_root(acb(-motion.b))
        ends = [jacobian.reduced(jacobian.image(s, w)) for s in (root, -root)]
        characteristics = [added(jacobian.delta, eta) for eta in jacobian.characteristics]
        functions = Theta2(jacobian.lattice.tau, characteristics)
        rows = [functions.at(z).along(motion.velocity) for z in ends]
        sizes = [abs(rows[0][i][0]).min(abs(rows[1][i][0])).mid() for i in range(5)]
        i = max(range(5), key=lambda n: sizes[n])
        rate = sum((row[i][1] / row[i][0] for row in rows), acb(0)) / 2
        (a, b), (c, d) = ends
        return (-a - c, -b - d), rate

    def _moment(self, t: arb, state: Sequence[arb]) -> Moment:
        """The functions at z0 + t V, which is z + 2(l + tau k)."""
        z, k = self.motion.place(t)
        h, e, V = self.h, self.e, self.motion.velocity
        low = z[0] + h[0], z[1] + h[1]
        below = self.functions.at(low)
        above = self.functions.at((low[0] + e[0], low[1] + e[1]))
        moved = 2 * _I * arb.pi() * (k[0] * e[0] + k[1] * e[1])
        log = self.rate * t - moved + above.log - below.log
        return Moment(state, below.along(V), above.along(V), log)

    def _fitting(self, k: tuple[int, int], l: tuple[int, int]) -> list[EigenspaceChoice]:
        """The choices that are not proven wrong."""
        motion, first = self.motion, self._first
        unit = _I if (k[0] * l[0] + k[1] * l[1]) % 2 else acb(1)
        spaces = {n: _eigenspace(k, l, n * unit) for n in (1, -1)}
        times = [ball(x) / motion.speed for x in _TIMES]
        moments = [self._moment(t, motion.at(t)) for t in times]
        begin = acb(first[1], first[2]), acb(first[3], -first[0])
        choices = []
        for n, m in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            bottoms = [_denominator(spaces[side * n], moments, side) for side in (1, -1)]
            tops = self._numerators((spaces[m], spaces[-m]), bottoms, moments, begin)
            if tops is None:
                continue
            choice = EigenspaceChoice(tops, bottoms)
            if not any(self._misses(choice, moment) for moment in moments[1:]):
                choices.append(choice)
        if not choices:
            raise ArithmeticError("no choice of the attitude's constants fits: a fault")
        certainly(len(choices) <= 2)
        return choices

    def _misses(self, choice: EigenspaceChoice, moment: Moment) -> bool:
        """Whether |xi|^2 or |eta|^2 is proven to be another than gamma3 says."""
        height = moment.state[5] / self.motion.weight
        for value, side in zip(choice.at(moment), (-1, 1), strict=True):
            square = value.real * value.real + value.imag * value.imag
            certainly(square.is_finite())
            if not square.overlaps((1 + side * height) / 2):
                return True
        return False

    def _numerators(
        self,
        spaces: Sequence[Space],
        bottoms: Sequence[Vector],
        moments: Sequence[Moment],
        begin: Pair,
    ) -> list[Vector] | None:
        """A and A' from the values at 0 and both equations at the time that tells most.

        None of a choice that is proven to miss the equations at another time.
        """
        now = moments[0]
        over = (-now.log).exp()
        nil = [acb(0)] * 2
        rows, right = [], []
        for j in (0, 1):
            own = [dot(v, now.above, 0) for v in spaces[j]]
            rows.append([*nil, *own] if j else [*own, *nil])
            right.append([over * begin[j] * dot(bottoms[j], now.below, 0)])
        equations = [self._equations(spaces, bottoms, moment) for moment in moments]
        best = max(([*rows, *pair] for pair in equations), key=_share)
        certainly(_share(best) > 0)
        try:
            A = acb_mat(best).solve(acb_mat([*right, [acb(0)], [acb(0)]]))
        except ZeroDivisionError:
            raise TooFewBits from None
        for row in (row for pair in equations for row in pair):
            rest = sum((x * A[i, 0] for i, x in enumerate(row)), acb(0))
            if rest.is_finite() and not rest.contains(0):
                return None
        return [
            [A[2 * j, 0] * x + A[2 * j + 1, 0] * y for x, y in zip(*spaces[j], strict=True)]
            for j in (0, 1)
        ]

    def _equations(
        self, spaces: Sequence[Space], bottoms: Sequence[Vector], moment: Moment
    ) -> list[list[acb]]:
        """xi' and eta' as equations for A and A', times all denominators.

        With N = A.Th, N' = A'.Th, d = B.Th, d' = B'.Th and derivatives along V,

            d' ((c + i r/2) d - d_V) N + d d' N_V - (i/2) x d^2 N' = 0,

        and the same for N' with d and d' exchanged, -r and conj(x).
        """
        p, q, r = moment.state[:3]
        d = [dot(b, moment.below, 0) for b in bottoms]
        slopes = [dot(b, moment.below, 1) for b in bottoms]
        rows = []
        for j, (x, turn) in enumerate(((acb(p, q), r), (acb(p, -q), -r))):
            factor = (self.rate + _I * turn / 2) * d[j] - slopes[j]
            own = [
                d[1 - j] * (factor * dot(v, moment.above, 0) + d[j] * dot(v, moment.above, 1))
                for v in spaces[j]
            ]
            across = [-_I / 2 * x * d[j] * d[j] * dot(v, moment.above, 0) for v in spaces[1 - j]]
            rows.append([*across, *own] if j else [*own, *across])
        return rows


def _share(rows: Sequence[Sequence[acb]]) -> arb:
    """A lower bound of the determinant beside the size of the last two rows."""
    size = arb(0)
    for row in rows[2:]:
        for x in row:
            size = size.max(abs(x).mid())
    # At rest these rows are 0 but for their radii, and tell nothing.
    return (abs(acb_mat(rows).det()).lower() / (size * size)).mid()


def _turn(pair: Pair) -> Turn:
    """The quaternion of xi and eta."""
    xi, eta = pair
    return -eta.imag, xi.real, xi.imag, eta.real


def _eigenspace(k: tuple[int, int], l: tuple[int, int], factor: acb) -> list[list[acb]]:
    """A basis of the B with ``factor`` B_(a+k) = (-1)^(a.l) B_a."""
    basis, rest = [], set(range(4))
    for i, half in enumerate(_HALVES):
        if i not in rest:
            continue
        partner = _HALVES.index(((half[0] + k[0]) % 2, (half[1] + k[1]) % 2))
        side = -1 if (half[0] * l[0] + half[1] * l[1]) % 2 else 1
        rest -= {i, partner}
        row = [acb(0)] * 4
        row[i] = acb(1)
        if partner != i:
            row[partner] = side / factor
        elif not (factor - side).contains(0):
            continue
        basis.append(row)
    return basis


def _denominator(space: Space, moments: Sequence[Moment], side: int) -> list[acb]:
    """B with x (B.Th) = (C.Th) at three times, B and C in the space; side = -1: of conj(x)."""
    rows = []
    for moment in moments[1:]:
        x = acb(moment.state[0], side * moment.state[1])
        first, second = (dot(v, moment.below, 0) for v in space)
        rows.append([x * first, x * second, -first, -second])
    minors = [
        (-1) ** j * acb_mat([[row[i] for i in range(4) if i != j] for row in rows]).det()
        for j in range(4)
    ]
    largest = max(minors, key=lambda z: abs(z).mid())
    u, v = minors[0] / largest, minors[1] / largest
    return [u * x + v * y for x, y in zip(*space, strict=True)]
