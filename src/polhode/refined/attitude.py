"""The attitude along a refined run: the turns of its intervals, one after the other.

In principal axes Q(t) is the product of the turns; with q(0) the attitude at the start and the turn
from principal axes to the scene's, the attitude of these is a linear function of it, exact as the
scene is.  For psi and phi, which are continuous, the windings of

    q0 + i q3 = cos(theta/2) exp(i (psi + phi)/2),   q1 + i q2 = sin(theta/2) exp(i (psi - phi)/2)

about zero are counted in double, from node to node, with more points where the path comes near it.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.equations.kinematics import starting_attitude
from polhode.numbers.rows import Booleans, Complexes, Doubles, Integers
from polhode.refined.attitude_correction import QUATERNION, Turns, times
from polhode.refined.errors import CannotRefine
from polhode.refined.scaled_problem import rational
from polhode.scenes.scene import Scene

_GUARD = 40  # bits of Q beyond the turns'
_BENDING = 0.3  # of a path between two points, over the time between squared; |q''| <= 1.75
_NEAREST = 1e-12  # to a pole, where psi and phi cannot be told in double any more
_PARTS = 8  # of a piece of path that comes near


class Attitude(NamedTuple):
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
        self, found: Turns, chain: int, starts: Integers, nodes: Doubles, lengths: Doubles
    ) -> list[Attitude]:
        """Go on over a block's chain; the attitudes at its outputs.

        ``starts``: of the intervals, counted in edges; ``nodes``: c_j; ``lengths``: (N,).
        Raises CannotRefine where angles are wanted and the motion passes a pole too closely.
        """
        edges = [self._now]
        for turn in found.ends[:chain]:
            edges.append(self._after(edges[-1], turn))
        wound = np.zeros((2, len(found.ends)))
        if self._angles:
            begin = np.array([[x * 2.0**-self._bits for x in edges[i]] for i in starts])
            ends = np.array([[x * 2.0**-self._ends for x in row] for row in found.ends])
            wound = windings(self._double, begin, found.path, ends, nodes, lengths)
        before = np.concatenate([np.zeros((2, 1)), np.cumsum(wound[:, :chain], axis=1)], axis=1)
        before += self._windings[:, None]
        outputs = []
        for i in range(chain, len(found.ends)):
            whole = self._after(edges[starts[i]], found.ends[i])
            one = 1 << self._bits
            quaternion = tuple(
                sum((x * Fraction(y, one) for x, y in zip(row, whole, strict=True)), Fraction(0))
                for row in self._frame
            )
            sums = before[:, starts[i]] + wound[:, i]
            outputs.append(Attitude(quaternion, (float(sums[0]), float(sums[1]))))
        self._now, self._windings = edges[chain], before[:, chain]
        return outputs

    def _after(self, q: list[int], turn: list[int]) -> list[int]:
        """q ⊗ T, T in units of the state's last bit."""
        return [x >> self._ends for x in times(q, turn)]


def frame(scene: Scene, bits: int) -> list[list[Fraction]]:
    """The matrix that takes Q in principal axes to the attitude of the scene's."""
    assert scene.gamma is not None
    start = [rational(x, bits) for x in starting_attitude(scene.gamma, scene.psi)]
    rows = [[rational(x, bits) for x in row] for row in scene.body.axes.rows]
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
        one = _OnePath(frames[i], at[:-1], path[:, :-1, i], float(lengths[i]), c)
        wound[c, gap, i] = one.winding(at[gap], at[gap + 1])
    found: Doubles = wound.sum(axis=1)
    return found


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
        found: Complexes = _pair(self._matrix @ t)[self._which]
        return found


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
