"""The attitude of a Kovalevskaya top at a cost that does not grow with time.

Generic motion: Cayley-Klein parameters in theta functions, each answer with its certificate; turns
of psi and phi from those over the two cycles L1, L2 of u (both parameters gain constant phases over
2 L1 and 2 L2, and vanish nowhere on the torus) and a short way tracked.  One frequency: the panels
over one period, and a turn about the vertical for every other one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

from polhode.closed_forms.attitude.quaternion import Quaternion, conjugate, product
from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quadrature import TooManyNodes
from polhode.closed_forms.functions.riemann_periods import Pair, solved
from polhode.closed_forms.kovalevskaya.attitude import KovalevskayaAttitude
from polhode.closed_forms.kovalevskaya.cayley_klein import CayleyKlein, quaternion
from polhode.closed_forms.kovalevskaya.counting import Counted
from polhode.numbers.private import mpc, mpf, mpmath

_TRIALS = 6
_MORE = 64  # bits more at each trial
_SLACK = 24  # bits that an answer may miss its certificate by
TRACKING = 128  # bits of the way that is tracked
_FINEST = -60  # a piece of it, as a power of two


class Formula(Protocol):
    """The constants of a motion with some bits more."""

    def __call__(self, more: int) -> CayleyKlein:
        """The formula, its constants made once a precision."""
        ...


@dataclass(eq=False)
class ThetaAttitude:
    """The quaternion body -> space of generic motion as a function of time."""

    formula: Formula
    bits: int  # of the answers
    start: Quaternion
    turn: Quaternion  # from the scene's axes to the top's
    exponent: int  # the top's unit of time is 2^-exponent
    speed: Any  # a bound of |w|
    third: int  # 1, -1: the scene's third axis is the top's, or its reverse; 0: neither
    coarse: Callable[[], CayleyKlein]  # at ``tracking`` bits
    tracking: int = TRACKING
    _cycles: dict[int, tuple[float, float]] = field(default_factory=dict)

    def at(self, t: Any, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t; ArithmeticError where it has no certificate."""
        del fn
        if not t:
            return self.start
        for trial in range(_TRIALS):
            made = self.formula(trial * _MORE)
            with mpmath.workprec(self.bits + trial * _MORE + _SLACK):
                xi, eta, miss = made.certified(mpmath.ldexp(t, self.exponent))
                if miss < mpmath.ldexp(1, _SLACK - self.bits):
                    return product(quaternion(xi, eta), self.turn)
        raise ArithmeticError("the attitude does not pass its certificate")

    def arguments(self, t: Any) -> tuple[Any, Any]:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t."""
        if not t:
            return mpf(0), mpf(0)
        if not self.third:
            return self._counted(t)
        try:
            return self._closed(t)
        except (TooManyNodes, ArithmeticError):  # a pinched cycle: next to a separatrix
            return self._counted(t)

    def _closed(self, t: Any) -> tuple[Any, Any]:
        """The growth by the turns over both cycles and a short way between."""
        L1, L2 = self.formula(0).motion.curve.cycles
        time = mpmath.ldexp(t, self.exponent)
        x1, x2 = solved((L1, L2), (mpf(0), time))
        n1, n2 = int(mpmath.nint(x1 / 2)), int(mpmath.nint(x2 / 2))
        rest = -2 * (n1 * L1[0] + n2 * L2[0]), time - 2 * (n1 * L1[1] + n2 * L2[1])
        around = [(2 * cycle[0], 2 * cycle[1]) for n, cycle in ((n1, L1), (n2, L2)) if n]
        if self._far((mpf(0), time)) <= sum(map(self._far, [rest, *around])):
            n1, n2, rest = 0, 0, (mpf(0), time)  # next to a separatrix cycles are long
        grown = list(self._tracked(rest))
        for n, cycle in ((n1, L1), (n2, L2)):
            if n:
                once = self._over(0 if cycle is L1 else 1, cycle)
                grown = [a + n * b for a, b in zip(grown, once, strict=True)]
        # eta has the turns of al, xi those of bt; the other way round for the reversed axis.
        xi, eta = grown
        return (eta, xi) if self.third > 0 else (xi, eta)

    def _counted(self, t: Any) -> tuple[Any, Any]:
        """The growth counted along the motion, about the scene's own third axis."""
        with mpmath.workprec(self.tracking):
            return self._pieces.arguments(t)

    @cached_property
    def _pieces(self) -> Counted:
        made = self.coarse()

        def at(t: Any) -> Quaternion:
            if not t:
                return self.start
            xi, eta = made.at(mpmath.ldexp(t, self.exponent))
            return product(quaternion(xi, eta), self.turn)

        return Counted(at, self.speed)

    def _far(self, way: Pair) -> Any:
        """How much tracking a straight way in u takes."""
        return abs(way[1]) + self._second * abs(way[0])

    def _over(self, which: int, cycle: Pair) -> tuple[float, float]:
        if which not in self._cycles:
            self._cycles[which] = self._tracked((2 * cycle[0], 2 * cycle[1]))
        return self._cycles[which]

    def _tracked(self, way: Pair) -> tuple[float, float]:
        """Growth of arg xi and arg eta along the straight way in u from 0.

        A piece no longer than |xi_a| + |xi_b| does not go around 0.
        """
        with mpmath.workprec(self.tracking):
            made = self.coarse()
            wide = mpmath.ldexp(self.speed, -self.exponent)
            bound = wide * self._far(way) / 2
            known: dict[Any, tuple[Any, Any]] = {}

            def ends(x: Any) -> tuple[Any, Any]:
                if x not in known:
                    known[x] = made.at(x * way[1], x * way[0])
                return known[x]

            total = [0.0, 0.0]
            for which in (0, 1):
                pending = [(mpf(0), mpf(1))]
                while pending:
                    a, b = pending.pop()
                    one, other = ends(a)[which], ends(b)[which]
                    if abs(one) + abs(other) > bound * (b - a):
                        total[which] += float(mpmath.arg(other / one))
                        continue
                    if b - a < mpmath.ldexp(1, _FINEST):
                        raise ArithmeticError("a parameter of the attitude comes too near 0")
                    middle = (a + b) / 2
                    pending += [(middle, b), (a, middle)]
        return total[0], total[1]

    @cached_property
    def _second(self) -> Any:
        """k: the second flow's rate over that of time is at most k."""
        p, q, _, G1, G2, _ = self.coarse().motion.at(mpf(0))[0]
        x = mpc(p, q)
        return abs(x * x - mpc(G1, G2)) * mpf("1.001")


@dataclass(eq=False)
class PeriodicAttitude:
    """The quaternion of a motion of one frequency: the panels over one period."""

    panels: KovalevskayaAttitude
    period: Any

    @property
    def start(self) -> Quaternion:
        """The attitude at t = 0."""
        return self.panels.start

    @property
    def speed(self) -> Any:
        """An upper bound of |w|."""
        return self.panels.speed

    def at(self, t: Any, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        n, rest = self._parts(t)
        found = self.panels.at(rest, fn)
        if not n:
            return found
        c, s = mpmath.cos_sin(n * self._half(fn))
        return product((c, mpf(0), mpf(0), s), found)

    def _half(self, fn: SeriesFunctions) -> Any:
        """Half the turn about the vertical over a period."""
        end = self.panels.at(self.period, fn)
        whole = product(end, conjugate(self.start))
        return mpmath.atan2(whole[3], whole[0])

    def _parts(self, t: Any) -> tuple[int, Any]:
        n = int(mpmath.floor(t / self.period))
        return n, t - n * self.period

    def arguments(self, t: Any) -> tuple[Any, Any]:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t."""
        q0, q1, q2, q3 = self.start
        n, rest = self._parts(t)
        if n in (0, -1) or not mpc(q0, q3) or not mpc(q1, q2):
            return self.panels.arguments(t)
        once, more = self.panels.arguments(self.period), self.panels.arguments(rest)
        return n * once[0] + more[0], n * once[1] + more[1]
