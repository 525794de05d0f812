"""The integrals S of dz/x_s and U of z dz/x_s along one separation variable.

S and U are a linear part and a bounded odd one in the variable's own phase: a Fourier series in the
angle theta of its chart where it oscillates, an integral over tanh y where it tends to a double
root.  Both kinds answer the same questions, so the motion is solved in one place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from polhode.closed_forms.functions.fourier import Cosines, Doubles, cosines
from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions
from polhode.closed_forms.goryachev_chaplygin.local_coordinates import Chart, chart
from polhode.closed_forms.goryachev_chaplygin.separation_variables import Variable
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

_PLAIN = 512  # samples of a turn up to which x itself is the angle
_PLACES = 1 << 12  # of a turn, in a table in doubles
_STEPS = 20


@dataclass(frozen=True)
class Halves:
    """A separation variable with sin and cos of half its angle, and dS/dphase."""

    z: Scalar
    sine: Scalar
    cosine: Scalar
    slope: Scalar


class Clock(Protocol):
    """S and U of one variable as functions of its phase."""

    @property
    def periodic(self) -> bool:
        """Whether the variable comes back after two turns of its phase, 4 pi."""
        ...

    @property
    def means(self) -> tuple[Scalar, Scalar]:
        """The linear parts of S and U."""
        ...

    def bounded(self, phase: Scalar) -> tuple[Scalar, Scalar]:
        """S and U without their linear parts."""
        ...

    def at(self, phase: Scalar, fn: SeriesFunctions) -> Halves:
        """The variable at a phase."""
        ...

    def floats(self) -> Clock:
        """The same in doubles, for arrays."""
        ...


@dataclass(frozen=True)
class Oscillating:
    """A variable that goes to and fro on its interval."""

    variable: Variable
    chart: Chart
    S: Cosines | Doubles
    U: Cosines | Doubles

    @property
    def periodic(self) -> bool:
        """Yes."""
        return True

    @property
    def means(self) -> tuple[Scalar, Scalar]:
        """S_0 and U_0."""
        return self.S.mean, self.U.mean

    def bounded(self, phase: Scalar) -> tuple[Scalar, Scalar]:
        """The sums of sines in S and U."""
        return self.S.bounded(phase), self.U.bounded(phase)

    def at(self, phase: Scalar, fn: SeriesFunctions) -> Halves:
        """The variable at theta = ``phase``."""
        c, s, rate = self.chart.at(phase, fn)
        z, sine, cosine = self.variable.halves(c, s, fn.sqrt)
        return Halves(z, sine, cosine, rate / self.variable.rate(z, fn.sqrt))

    def floats(self) -> Oscillating:
        """The same in doubles, for arrays."""
        assert isinstance(self.S, Cosines)
        assert isinstance(self.U, Cosines)
        rows = self.S.doubles(), self.U.doubles()
        return Oscillating(self.variable.floats(), self.chart.floats(), *rows)


def oscillating(variable: Variable, spoiled: int = 0) -> Oscillating:
    """The series of one variable, at the precision in force.

    ``spoiled``: the bits that roots near each other cost the radicand between them.
    """
    made, first = chart(variable, _PLAIN)

    def integrands(theta: Scalar) -> Sequence[Scalar]:
        c, s, rate = made.at(theta, MP)
        z = variable.at(c, s)
        slope = rate / variable.rate(z, mpmath.sqrt)
        return slope, z * slope

    S, U = cosines(integrands, first, spoiled=spoiled)
    return Oscillating(variable, made, S, U)


class InverseS:
    """The phase of a variable where S/S_0 is given: Newton's method from a table in doubles."""

    def __init__(self, clock: Oscillating) -> None:
        import numpy as np

        small = clock.floats()
        self._clock, self._phases = clock, np.linspace(0, 2 * np.pi, _PLACES + 1)
        self._shares = self._phases + small.bounded(self._phases)[0] / float(clock.S.mean)

    def at(self, al: Scalar) -> Scalar:
        """The phase at S/S_0 = ``al``, at the precision in force."""
        import numpy as np

        clock, turn = self._clock, 2 * mpmath.pi
        around = turn * mpmath.floor(al / turn)
        phase = around + mpf(float(np.interp(float(al - around), self._shares, self._phases)))
        for _ in range(_STEPS):
            miss = (phase - al) * clock.S.mean + clock.bounded(phase)[0]
            step = miss / clock.at(phase, MP).slope
            phase -= step
            if abs(step) < mpmath.ldexp(1, -mpmath.prec // 2 - 8):
                return phase
        raise ArithmeticError("a phase was not found")


@dataclass(frozen=True)
class Standing:
    """A variable that is constant; its phase is S itself."""

    z: Scalar
    sine: int
    cosine: int
    periodic = False

    @property
    def means(self) -> tuple[Scalar, Scalar]:
        """1 and z."""
        return 1, self.z

    def bounded(self, phase: Scalar) -> tuple[Scalar, Scalar]:
        """Nothing."""
        return 0 * phase, 0 * phase

    def at(self, phase: Scalar, fn: SeriesFunctions) -> Halves:
        """The variable, whatever the phase."""
        return Halves(self.z, self.sine, self.cosine, 1)

    def floats(self) -> Standing:
        """The same in doubles."""
        return Standing(float(self.z), self.sine, self.cosine)
