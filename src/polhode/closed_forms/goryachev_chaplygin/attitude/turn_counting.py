"""The turns of psi and phi of two frequencies, at a cost that does not grow with time.

al and bt are functions on the torus, smooth in the phases x and y.  From one time to another their
arguments grow as along x and then along y, whole circuits counted once, but for 2 pi around each
place between that way and the motion's where al (bt) is 0.  In the mean phases the motion is a
straight line, so that these places are counted by sums of integer parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from polhode.closed_forms._winding.floor_sums import floors
from polhode.closed_forms._winding.winding_number import growth
from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions, numpy_functions
from polhode.closed_forms.functions.quaternion import Quaternion, product
from polhode.closed_forms.goryachev_chaplygin.abel_integrals import Clock
from polhode.closed_forms.goryachev_chaplygin.attitude.attitude import placed
from polhode.closed_forms.goryachev_chaplygin.attitude.poles import Pole, poles
from polhode.closed_forms.goryachev_chaplygin.motion import Separated, joined
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.rows import Doubles
from polhode.numbers.scalars import Scalar

_SAMPLES = 4096  # of a circuit, for the bound of a rate
_MARGIN = 1.25
_LOST = 32  # bits that phases of zeros and of the motion may have lost

Pair = tuple[Scalar, Scalar]


class TorusTurns:
    """Growth of the arguments along one motion, at the precision in force when it is asked.

    ``right`` is the turn from the scene's axes to the motion's, ``axis`` the scene's third axis in
    the latter; ``constants`` are H and G.
    """

    def __init__(
        self,
        path: Separated,
        sg: int,
        right: Quaternion,
        axis: Sequence[Scalar],
        constants: tuple[Scalar, Scalar],
    ) -> None:
        self._path, self._sg, self._right = path, sg, right
        self._axis, self._constants = axis, constants
        self._begun: dict[Any, Pair] = {}

    def growth(self, first: Scalar, last: Scalar) -> Pair:
        """Of arg al and arg bt between two times in the motion's units.

        Raises ArithmeticError where the motion passes too near a zero of al or bt to be counted.
        """
        if first not in self._begun:
            self._begun[first] = self._path.torus.phases(first)
        begin, end = self._begun[first], self._path.torus.phases(last)
        turn = 4 * mpmath.pi
        (x0, rest_x), (y0, rest_y) = (
            _circuits(a, b, turn) for a, b in zip(begin, end, strict=True)
        )
        x, y = (z - turn * mpmath.floor(z / turn) for z in begin)
        x1 = x + rest_x
        ways = [self._along(0, (x, y), rest_x), self._along(1, (x1, y), rest_y)]
        rounds = [(x0, self._loop(0, (x, y))), (y0, self._loop(1, (x1, y)) if y0 else (0, 0))]
        found = []
        for which in (0, 1):
            whole = sum(n * loop[which] for n, loop in rounds)
            whole -= sum(
                self._between(pole, first, last, begin, end) for pole in self._poles[which]
            )
            found.append(sum(mpf(way[which]) for way in ways) + 2 * mpmath.pi * whole)
        return found[0], found[1]

    def _between(self, pole: Pole, first: Any, last: Any, begin: Pair, end: Pair) -> int:
        """Turns around the copies of a zero between the motion and the way along x, then y."""
        torus, turn = self._path.torus, 4 * mpmath.pi
        X, Y = self._mean(pole)
        X0, Y0 = torus.mean(first)
        rates = torus.rates
        slope = rates[1] / rates[0]
        low, high = sorted((begin[0], end[0]))
        k = int(mpmath.floor((low - pole.x) / turn)) + 1
        count = int(mpmath.floor((high - pole.x) / turn)) - k + 1
        base = (Y0 - Y + slope * (X + turn * k - X0)) / turn
        error = mpmath.ldexp(1 + abs(base) + slope * count, _LOST - mpmath.prec)
        found = floors(count, slope, base, error)
        found -= count * int(mpmath.floor((begin[1] - pole.y) / turn))
        return pole.charge * (found if last > first else -found)

    def _mean(self, pole: Pole) -> Pair:
        """The mean phases of a place on the torus."""
        torus = self._path.torus
        (s0, u0), (t0, v0) = torus.u.means, torus.v.means
        (s, u), (t, v) = torus.u.bounded(pole.x), torus.v.bounded(pole.y)
        delta = u0 * t0 + v0 * s0
        one, other = s - t, u + v
        return pole.x + (v0 * one + t0 * other) / delta, pole.y + (s0 * other - u0 * one) / delta

    @cached_property
    def _poles(self) -> tuple[list[Pole], list[Pole]]:
        return poles(self._path, self._sg, self._constants, self._axis, self._parameters)

    def _parameters(self, x: Scalar, y: Scalar) -> Pair:
        """al and bt at the phases, but for constant factors of modulus 1."""
        torus = self._path.torus
        point = self._path.joined(torus.u.at(x, MP), torus.v.at(y, MP), MP)
        q0, q1, q2, q3 = product(placed(point, self._sg, MP), self._right)
        return mpmath.mpc(q0, q3), mpmath.mpc(q1, q2)

    def _doubles(self, x: Doubles, y: Doubles, fn: SeriesFunctions) -> Pair:
        torus = self._path.torus.doubles
        one, other = torus.u.at(x, fn), torus.v.at(y, fn)
        point = joined(one, other, float(self._path.a), fn)
        a, b, c, d = (float(z) for z in self._right)
        q0, q1, q2, q3 = product(placed(point, self._sg, fn), (a, b, c, d))
        return q0 + 1j * q3, q1 + 1j * q2

    @cached_property
    def _speeds(self) -> tuple[float, float]:
        """Bounds of twice the rates of al and bt by x and by y."""
        torus = self._path.torus.doubles
        return 2 * _bound(torus.u), 2 * _bound(torus.v)

    def _loop(self, which: int, begin: Pair) -> tuple[int, int]:
        """Turns of al and bt along a whole circuit of x or y."""
        one, other = self._along(which, begin, 4 * mpmath.pi)
        turns = tuple(round(z / (2 * np.pi)) for z in (one, other))
        return turns[0], turns[1]

    def _along(self, which: int, begin: Pair, way: Scalar) -> tuple[float, float]:
        """Growth of both arguments while one phase moves and the other stays."""
        if not way:
            return 0.0, 0.0
        speed, fn = self._speeds[which], numpy_functions()

        def fine(s: Scalar) -> Pair:
            x, y = begin
            return (
                self._parameters(x, y + s / speed) if which else self._parameters(x + s / speed, y)
            )

        def coarse(s: Doubles) -> Pair:
            x, y = (float(z) + 0 * s for z in begin)
            return (
                self._doubles(x, y + s / speed, fn)
                if which
                else self._doubles(x + s / speed, y, fn)
            )

        (found,) = growth(fine, coarse, [way * speed])
        return found


def _circuits(begin: Scalar, end: Scalar, turn: Scalar) -> tuple[int, Scalar]:
    """Whole circuits from one phase to another, towards 0, and what is left."""
    way = end - begin
    count = int(way / turn)
    return count, way - count * turn


def _bound(clock: Clock) -> float:
    """Of the frame's rate by one phase: |d ln z|/4 and |d angle|/2, as two legs."""
    phase = np.linspace(0, 4 * np.pi, _SAMPLES + 1)
    halves = clock.at(phase, numpy_functions())
    logs = np.log(halves.z) / 4
    angle = np.unwrap(np.arctan2(halves.sine, halves.cosine))
    return float(_MARGIN * np.hypot(np.diff(logs), np.diff(angle)).max() / phase[1])
