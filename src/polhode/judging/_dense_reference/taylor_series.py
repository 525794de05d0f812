"""Taylor series of the motion about given states, from the equations of motion alone.

    L' = L × w + gamma × Mg r0,    L = I w,    gamma' = gamma × w,    q' = ½ q ⊗ (0, w)

give each coefficient from those before it, such as (k + 1) gamma_{k+1} = sum gamma_j × w_{k-j}.
Many states at once, in numpy: the first coefficients in pairs of doubles, later ones, which are
small where the series are summed, in doubles.  Nothing here is the integrator's, so that what a
closed form tells at one time is carried a little further by the equations and nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from polhode.numbers.double_double import Pairs, of_exact
from polhode.numbers.rows import Doubles
from polhode.scenes.body import Vector, cross, dot, scaled
from polhode.scenes.scene import Scene

ORDER = 64
FINE = 32  # coefficients in pairs
_BLOCK = 64  # series that are made together: what stays in the processor's cache


# q ⊗ (0, w): four components, each a sum of three terms q_i w_j, and their signs.
_QUATERNION = (
    ((1, 0), (0, 0), (0, 1), (0, 2)),
    ((2, 1), (2, 2), (3, 0), (1, 1)),
    ((3, 2), (3, 1), (1, 2), (2, 0)),
)
_SIGNS = np.array([[-1.0, 1, 1, 1], [-1, 1, 1, 1], [-1, -1, -1, -1]])[:, :, None]
_NEXT, _OTHER = [1, 2, 0], [2, 0, 1]  # (a × b)_i = a_next b_other - a_other b_next


class Equations:
    """The equations of a scene for w, gamma where it has one, and if ``turning`` the turn."""

    def __init__(self, scene: Scene, turning: bool) -> None:
        body, self._unit = scene.body, Fraction(2) ** scene.time_unit
        largest = max(body.moments)
        a, b, c = (scaled(1 / largest, row) for row in body.inertia)
        volume, rows = dot(a, cross(b, c)), (cross(b, c), cross(c, a), cross(a, b))
        self._inertia = _matrix((a, b, c))
        self._inverse = _matrix([scaled(1 / volume, row) for row in rows])
        self._torque = None
        if scene.gamma is not None:
            rate = self._unit * self._unit / largest
            self._torque = stacked([of_exact(x) for x in scaled(rate, body.torque)])[:, None]
        self._vectors = 1 if self._torque is None else 2
        self._left, self._right = _products(self._vectors, turning)
        self._turning = turning

    def series(self, starts: Pairs, spans: Doubles) -> Doubles:
        """Coefficients about starts, shape (2, ORDER + 1, columns, starts): both doubles.

        ``starts``: w and gamma, shape (columns, starts), in the scene's units; ``spans``: the unit
        of time of each series, in the scene's.  The turn, a quaternion, begins at 1.
        """
        inside = spans / float(self._unit)
        blocks = [slice(k, k + _BLOCK) for k in range(0, len(spans), _BLOCK)]
        with np.errstate(all="ignore"):
            found = [self._block(starts[:, block], inside[block]) for block in blocks]
        return np.concatenate(found, axis=3)

    def _block(self, starts: Pairs, spans: Doubles) -> Doubles:
        unit = float(self._unit)  # a power of two
        width = len(starts.hi)
        found = np.zeros((2, ORDER + 1, width + 4 * self._turning, len(spans)))  # L gamma q
        rates = np.zeros((2, ORDER + 1, 3, len(spans)))  # w
        _put(found[:, :, :width], 0, starts)
        found[0, 0, width : width + 1] = 1.0
        _put(rates, 0, Pairs(starts.hi[:3] * unit, starts.lo[:3] * unit))
        _put(found[:, :, :3], 0, _times(self._inertia, Pairs(*rates[:, 0])))
        for k in range(ORDER):
            made = self._rates(found, rates, k) * Pairs(spans) / float(k + 1)
            _put(found, k + 1, made)
            _put(rates, k + 1, _times(self._inverse, made[:3]))
        found[:, :, :3] = rates / unit
        return found

    def _rates(self, found: Doubles, rates: Doubles, k: int) -> Pairs:
        """The k-th coefficients of L', gamma' and q'."""
        a, b = found[:, : k + 1, self._left], rates[:, k::-1, self._right]
        if k < FINE:
            terms = _summed(Pairs(*a) * Pairs(*b))
        else:
            rough = (a[0] * b[0]).sum(axis=0)
            terms = Pairs(rough, np.zeros_like(rough))
        width = 3 * self._vectors
        turning = terms[:width] - terms[width : 2 * width]
        parts = [turning]
        if self._torque is not None:
            gamma = Pairs(*found[:, k, 3:6])
            heavy = gamma[_NEXT] * self._torque[_OTHER] - gamma[_OTHER] * self._torque[_NEXT]
            parts = [turning[:3] + heavy, turning[3:]]
        if len(terms.hi) > 2 * width:
            one, two, three = (terms[n : n + 4] for n in range(2 * width, 2 * width + 12, 4))
            one, two, three = (x * y for x, y in zip((one, two, three), _SIGNS / 2, strict=True))
            parts.append(one + two + three)
        return _joined(parts)


def _products(vectors: int, turning: bool) -> tuple[list[int], list[int]]:
    """Which components of L, gamma and q are multiplied with which of w."""
    left = [3 * v + i for way in (_NEXT, _OTHER) for v in range(vectors) for i in way]
    right = [i for way in (_OTHER, _NEXT) for _ in range(vectors) for i in way]
    if turning:
        left += [3 * vectors + i for row in _QUATERNION for i, _ in row]
        right += [j for row in _QUATERNION for _, j in row]
    return left, right


def _put(target: Doubles, k: int, x: Pairs) -> None:
    target[0, k], target[1, k] = x.hi, x.lo


def _summed(x: Pairs) -> Pairs:
    """The sum over the first axis, by halves."""
    while (count := len(x.hi)) > 1:
        half = count // 2
        total = x[:half] + x[half : 2 * half]
        x = total if count % 2 == 0 else _joined([total, x[2 * half :]])
    return x[0]


def _times(matrix: Pairs, vectors: Pairs) -> Pairs:
    """A matrix times vectors, shape (3, count)."""
    one, two, three = (matrix[:, i, None] * vectors[i] for i in range(3))
    return one + two + three


def _matrix(rows: Sequence[Vector]) -> Pairs:
    return stacked([stacked([of_exact(x) for x in row]) for row in rows])


def stacked(parts: Sequence[Pairs]) -> Pairs:
    """Arrays of pairs as the rows of one."""
    return Pairs(np.stack([x.hi for x in parts]), np.stack([x.lo for x in parts]))


def _joined(parts: Sequence[Pairs]) -> Pairs:
    return Pairs(np.concatenate([x.hi for x in parts]), np.concatenate([x.lo for x in parts]))
