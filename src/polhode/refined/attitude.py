"""The attitude along a refined run: the turns of its intervals, one after the other.

In principal axes Q(t) is the product of the turns; with q(0) the attitude at the start and the
turn from principal axes to the scene's, the attitude of these is a linear function of it, exact
as the scene is. For psi and phi, which are continuous, the windings of

    q0 + i q3 = cos(theta/2) exp(i (psi + phi)/2),   q1 + i q2 = sin(theta/2) exp(i (psi - phi)/2)

about zero are counted in double, from node to node, with more points where the path comes near
it.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.equations import kinematics
from polhode.numbers.number_types import Booleans, Complexes, Doubles, GivenRow, Integers, Scalar
from polhode.numbers.polynomials import fraction_near
from polhode.numbers.vectors import quaternion_product
from polhode.refined import compiled_field
from polhode.refined.collocation_tables import Tables
from polhode.refined.compiled_field import CannotRefine, Limbs, LimbSums, over_intervals, product
from polhode.refined.deferred_correction import BlockConstants, iterated
from polhode.scenes.scene import Scene

# --- attitude correction --------------------------------------------------------------------------
#
# How the body turns over each interval: the attitude quaternion's equation, solved as the state's.
#
# Along an interval T' = ½ T ⊗ (0, w), T = 1 at its start, w the refined stages: a linear equation,
# whose collocation solution is found as that of the state is
# (:mod:`polhode.refined.deferred_correction`), from exact defects
#
#     r = 1 + ½ A H (T ⊗ w) - T
#
# and corrections in double.  All intervals are independent.  The ends are good to the square of
# what the stages neglect, and Gauss collocation keeps |T| = 1.  With a correction E of the stages
# that is not made any more, the end's is r_end + ½ sum_j b_j H (r_j ⊗ w_j) ⊗ T_j^-1 ⊗ T_end.


QUATERNION = 4
_GUESS = 1e-14  # to which the first T is iterated
_STAGES = 1e-11  # to which a correction is, relative
_ENDS = 1e-12  # relative error of the ends' last correction, at most


class BlockTurns(NamedTuple):
    """T of N intervals.  ``ends``: four integers times 2**-finest each; ``path``: T at the nodes,
    in double, (4, M, N)."""

    ends: list[list[int]]
    path: Doubles


def turns(
    constants: BlockConstants, stages: Doubles, lengths: Doubles, largest_tail: float
) -> BlockTurns:
    """T along N intervals: stages (6, L, M, N) and lengths (L, N) in limbs.

    Raises TooLong for intervals with too few nodes for it, or CannotRefine.
    """
    limbs, tables = constants.limbs, constants.tables
    nodes, n = stages.shape[2:]
    omega = stages[:3].sum(axis=1) * (0.5 * lengths.sum(axis=0))
    t = np.zeros((QUATERNION, nodes, n))
    t[0] = 1.0

    def turn() -> None:
        np.matmul(tables.integrals, spun(t, omega), out=t)
        t[0] += 1.0

    iterated(turn, t[:, -2:], _GUESS)
    end = tables.weights @ spun(t, omega)
    end[0] += 1.0
    split = limbs.split_doubles(t).swapaxes(0, 1).copy()
    ends = limbs.split_doubles(end).swapaxes(0, 1).copy()
    for count in range(constants.sweeps):
        r, r_end, tails = _defects(limbs, tables, split, ends, stages[:3], lengths)
        forced = spun(r, omega)
        delta = r_end + times(tables.weights @ times(forced, conjugate(t)), end)
        limbs.adjust(ends.swapaxes(0, 1), delta)
        size = float(np.abs(r).max())
        if count and size * _ENDS < constants.target:
            if (tails > largest_tail).any():  # told by the last sweep, which no guess disturbs
                raise compiled_field.IntervalsTooLong(tails > largest_tail)
            whole = ends.transpose(2, 0, 1).tolist()
            return BlockTurns([[limbs.integer(x) for x in row] for row in whole], t)
        rest = np.zeros_like(t)

        def correct(r: Doubles = r, rest: Doubles = rest) -> None:
            np.matmul(tables.integrals, spun(r + rest, omega), out=rest)

        iterated(correct, rest[:, -2:], _STAGES * size)
        limbs.adjust(split.swapaxes(0, 1), r + rest)
    raise CannotRefine("the attitude does not converge")


def _defects(
    limbs: Limbs, tables: Tables, t: Doubles, end: Doubles, omega: Doubles, lengths: Doubles
) -> tuple[Doubles, Doubles, Doubles]:
    """r at the nodes (4, M, N) and at the ends (4, N), and the last Legendre coefficients (N,)."""
    levels = tables.integrated(_field(limbs, t, omega, lengths))
    nodes = t.shape[2]
    r, r_end = -t[:, 0], -end[:, 0]
    r[0] += 1.0
    r_end[0] += 1.0
    for i, level in enumerate(levels):
        if i:
            r -= t[:, i]
            r_end -= end[:, i]
        r += 0.5 * level[:, :nodes]  # half of a double is exact
        r_end += 0.5 * level[:, nodes]
    return r, r_end, tables.last_coefficients(levels)


def _field(kind: Limbs, t: Doubles, omega: Doubles, lengths: Doubles) -> Doubles:
    """H T ⊗ w in limbs (4, L, M, N); |T|, |w| <= 1 and H |w| <= 4, as the kernels' field has it."""
    q, w = ([list(x) for x in part] for part in (t, omega))
    minus = [-x for x in q[1]], [-x for x in q[2]], [-x for x in q[3]]
    rates: list[LimbSums] = [
        product(minus[0], w[0]) + product(minus[1], w[1]) + product(minus[2], w[2]),
        product(q[0], w[0]) + product(q[2], w[2]) + product(minus[2], w[1]),
        product(q[0], w[1]) + product(q[3], w[0]) + product(minus[0], w[2]),
        product(q[0], w[2]) + product(q[1], w[1]) + product(minus[1], w[0]),
    ]
    return np.array(over_intervals(rates, list(lengths), kind))


def spun(q: Doubles, omega: Doubles) -> Doubles:
    """q ⊗ (0, w)."""
    return np.array(kinematics.quaternion_spin(q, omega))


def times(a: GivenRow, b: GivenRow) -> Scalar:
    """The product of quaternions, of arrays of them, or of lists of integers."""
    row = quaternion_product(a, b)
    return np.array(row) if isinstance(a, np.ndarray) else row


def conjugate(q: Doubles) -> Doubles:
    """The inverse of a unit quaternion."""
    return np.concatenate([q[:1], -q[1:]])


# --- attitude -------------------------------------------------------------------------------------


_GUARD = 40  # bits of Q beyond the turns'
_BENDING = 0.3  # of a path between two points, over the time between squared; |q''| <= 1.75
_NEAREST = 1e-12  # to a pole, where psi and phi cannot be told in double any more
_PARTS = 8  # of a piece of path that comes near


class RefinedAttitude(NamedTuple):
    """At an output: the quaternion, rationals, and by how much (psi + phi)/2 and (psi - phi)/2 have
    grown since the start, in double."""

    quaternion: tuple[Fraction, ...]
    windings: tuple[float, float]


class Following:
    """The attitude at the edge that a run has come to."""

    def __init__(self, scene: Scene, bits: int, angles: bool) -> None:
        self._bits, self._ends, self._angles = bits + _GUARD, bits, angles
        self._frame = frame(scene, bits + 64)
        self._double = np.array([[float(x) for x in row] for row in self._frame])
        self._now = [1 << self._bits, 0, 0, 0]
        self._windings = np.zeros(2)

    def advance(
        self,
        block_turns: BlockTurns,
        chain: int,
        starts: Integers,
        nodes: Doubles,
        lengths: Doubles,
    ) -> list[RefinedAttitude]:
        """Go on over a block's chain; the attitudes at its outputs.

        ``starts``: of the intervals, counted in edges; ``nodes``: c_j; ``lengths``: (N,).
        Raises CannotRefine where angles are wanted and the motion passes a pole too closely.
        """
        edges = [self._now]
        for turn in block_turns.ends[:chain]:
            edges.append(self._after(edges[-1], turn))
        wound = np.zeros((2, len(block_turns.ends)))
        if self._angles:
            begin = np.array([[x * 2.0**-self._bits for x in edges[i]] for i in starts])
            ends = np.array([[x * 2.0**-self._ends for x in row] for row in block_turns.ends])
            wound = windings(self._double, begin, block_turns.path, ends, nodes, lengths)
        before = np.concatenate([np.zeros((2, 1)), np.cumsum(wound[:, :chain], axis=1)], axis=1)
        before += self._windings[:, None]
        outputs = []
        for i in range(chain, len(block_turns.ends)):
            whole = self._after(edges[starts[i]], block_turns.ends[i])
            unit = 1 << self._bits
            quaternion = tuple(
                sum((x * Fraction(y, unit) for x, y in zip(row, whole, strict=True)), Fraction(0))
                for row in self._frame
            )
            sums = before[:, starts[i]] + wound[:, i]
            outputs.append(RefinedAttitude(quaternion, (float(sums[0]), float(sums[1]))))
        self._now, self._windings = edges[chain], before[:, chain]
        return outputs

    def _after(self, q: list[int], turn: list[int]) -> list[int]:
        """q ⊗ T, T in units of the state's last bit."""
        return [x >> self._ends for x in times(q, turn)]


def frame(scene: Scene, bits: int) -> list[list[Fraction]]:
    """The matrix that takes Q in principal axes to the attitude of the scene's."""
    assert scene.gamma is not None
    attitude = kinematics.starting_attitude(scene.gamma, scene.psi)
    start = [fraction_near(x, bits)[0] for x in attitude]
    rows = [[fraction_near(x, bits)[0] for x in row] for row in scene.body.axes.rows]
    columns = [times(start, [Fraction(1), *[Fraction(0)] * 3])]
    columns += [times(start, [Fraction(0), *row]) for row in rows]
    return [[columns[j][i] for j in range(QUATERNION)] for i in range(QUATERNION)]


def windings(
    matrix: Doubles,
    begin: Doubles,
    inside: Doubles,
    ends: Doubles,
    nodes: Doubles,
    lengths: Doubles,
) -> Doubles:
    """By how much the arguments of q0 + i q3 and q1 + i q2 grow over each interval, (2, N).

    ``begin``: Q at the starts (N, 4); ``inside``, ``ends``: T at the nodes (4, M, N) and at the
    ends (N, 4).  Raises CannotRefine.
    """
    path = np.zeros((QUATERNION, len(nodes) + 2, len(begin)))
    path[0, 0] = 1.0
    path[:, 1:-1] = inside
    path[:, -1] = ends.T
    at = np.concatenate([[0.0], nodes, [1.0]])
    frames = np.einsum("ij,njk->nik", matrix, _left(begin))  # T -> attitude, interval by interval
    z = _pair(np.einsum("nij,jmn->imn", frames, path))
    wound = np.angle(z[:, 1:] * z[:, :-1].conj())
    near = ~_clear(z[:, :-1], z[:, 1:], np.diff(at)[:, None] * lengths)
    for c, gap, i in np.argwhere(near).tolist():
        piece = _OnePath(frames[i], at[:-1], path[:, :-1, i], float(lengths[i]), c)
        wound[c, gap, i] = piece.winding(at[gap], at[gap + 1])
    growth: Doubles = wound.sum(axis=1)
    return growth


class _OnePath:
    """q0 + i q3 or q1 + i q2 along one interval, at any of its times, from the nodes."""

    def __init__(
        self, matrix: Doubles, at: Doubles, path: Doubles, length: float, which: int
    ) -> None:
        self._matrix, self._at, self._path = matrix, at, path
        self._length, self._which = length, which
        differences = at[:, None] - at
        np.fill_diagonal(differences, 1.0)
        self._weights = 1 / (4 * differences).prod(axis=1)

    def winding(self, begin: float, end: float) -> float:
        """How much the argument grows between two times, fractions of the interval."""
        at = np.linspace(begin, end, _PARTS + 1)
        z = self._points(at)
        total = 0.0
        clear = _clear(z[:-1], z[1:], np.diff(at) * self._length)
        for i, sure in enumerate(clear.tolist()):
            if sure:
                total += float(np.angle(z[i + 1] * z[i].conj()))
            elif min(abs(z[i]), abs(z[i + 1])) < _NEAREST or at[i + 1] - at[i] < _NEAREST:
                raise CannotRefine("a pole is passed too closely for psi and phi")
            else:
                total += self.winding(at[i], at[i + 1])
        return total

    def _points(self, at: Doubles) -> Complexes:
        """By the barycentric formula."""
        off = at[:, None] - self._at
        hit = off == 0
        off[hit] = 1.0
        shares = self._weights / off
        shares[hit.any(axis=1)] = 0.0
        shares[hit] = 1.0
        t = (self._path @ shares.T) / shares.sum(axis=1)
        points: Complexes = _pair(self._matrix @ t)[self._which]
        return points


def _clear(a: Complexes, b: Complexes, apart: Doubles) -> Booleans:
    """Whether zero is away from the path between points, as their straight line is: then the
    angle between them is how far the path winds."""
    step = b - a
    with np.errstate(all="ignore"):
        along = np.clip(-(a * step.conj()).real / np.abs(step) ** 2, 0.0, 1.0)
    along = np.where(np.abs(step) > 0, along, 0.0)
    return np.abs(a + along * step) > _BENDING * apart**2 + _NEAREST


def _pair(q: Doubles) -> Complexes:
    """q0 + i q3 and q1 + i q2."""
    return np.stack([q[0] + 1j * q[3], q[1] + 1j * q[2]])


def _left(q: Doubles) -> Doubles:
    """The matrices of T -> q ⊗ T, (N, 4, 4)."""
    a, b, c, d = q.T
    rows = [[a, -b, -c, -d], [b, a, -d, c], [c, d, a, -b], [d, -c, b, a]]
    return np.array(rows).transpose(2, 0, 1)
