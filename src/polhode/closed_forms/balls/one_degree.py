"""Motion z'^2 = f(z) between two neighbouring simple zeros of f, in balls.

    z = z1 + (z2 - z1) y,    y = (1 - cos x)/2,    x' = product of (first + slope y)^(1/2),

the linear functions (:class:`.quadrature.Linear`) positive or in conjugate pairs: f without its
zeros z1 and z2.  The time, the integral of 1/x' over x, is a mean times x and a series of sines; so
is the moment, that of y/x'.  With |1/x'| <= M in the strip |Im x| <= eta, 1/x' is the sum of
c_k exp(ikx), |c_k| <= M exp(-|k| eta).  2n samples give c_k + the sum of c_(k+2nj), j not 0.  So
the sum of 2 c_k sin(kx)/k over 0 < k < n differs from the whole series by at most

    2 M exp(-n eta)/(1 - exp(-eta)) [1/n + exp(-eta)/(1 - exp(-n eta))]

(what is left out, and what the samples cannot tell from it), and c_0 from the mean by at most
2 M exp(-2n eta)/(1 - exp(-2n eta)).

x at a time t: Newton's iteration on middles of balls proves nothing, and need not: since t(x) is
increasing, the true x is within max(x') |t(x) - t| of any x, and one step of Newton's from there,
with x' of that whole interval, encloses it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from flint import acb, arb

from polhode.closed_forms.balls.core import Refused, nearest_integer
from polhode.closed_forms.balls.power_sum import PowerSum
from polhode.closed_forms.balls.quadrature import (
    InverseRoots,
    Linear,
    around,
    bound,
    square,
    strip,
)
from polhode.common.cached_property import cached_property
from polhode.numbers.flint_context import ctx

_MOST_TERMS = 1 << 15
_SPARE = 10  # nats beyond the bits in force
_ROUGH_BITS, _ROUGH_STEPS = 64, 100
_ROUGH = 25  # bits of x after the rough steps


@dataclass(frozen=True)
class SineSeries:
    """``mean`` x + the sum of ``terms`` sin(kx), k from 1, off by ``error`` at most (a ball)."""

    mean: arb
    terms: Sequence[arb]
    error: arb

    def at(self, x: arb) -> arb:
        """The value."""
        return self.mean * x + self._sum.at(acb(0, x).exp()).imag + self.error

    @cached_property
    def _sum(self) -> PowerSum:
        return PowerSum([acb(0), *map(acb, self.terms)])


class OneDegree:
    """The motion at the precision in force; ``factors`` are those of x'^2.

    ``time`` and ``moment`` are functions of x, ``period`` the time in which x grows by 2 pi.
    """

    def __init__(self, factors: Sequence[Linear]) -> None:
        self._inverse = InverseRoots(factors)
        eta = strip(factors)
        wide = arb(eta)
        most = bound(factors, wide)  # first: it proves that eta is about what it should be
        n = 8 * math.ceil((ctx.prec * math.log(2) + _SPARE) / (8 * eta))
        if n > _MOST_TERMS:
            raise Refused(f"too near a degenerate motion: a series of {n} terms")
        self.time, self.moment = self._series(n, wide, most)
        self.period = 2 * arb.pi() * self.time.mean
        self._fastest = arb(1)
        for factor in factors:
            self._fastest *= abs(factor.first).max(abs(factor.last)).sqrt()

    def rate(self, x: arb) -> arb:
        """x' at a real x."""
        return 1 / self._inverse(square((x / 2).sin())).real

    def phase(self, t: arb) -> arb:
        """x at a time, continuous; 0 at t = 0."""
        n = nearest_integer(t / self.period)
        rest = t - n * self.period
        x = self._near(rest.mid())
        miss = self.time.at(x) - rest
        near = x + around(self._fastest * abs(miss)).real
        return 2 * n * arb.pi() + x - miss * self.rate(near)

    def _series(self, n: int, eta: arb, most: arb) -> tuple[SineSeries, SineSeries]:
        """Time and moment from 2n samples; ``most`` bounds 1/x' in the strip."""
        rows: tuple[list[acb], list[acb]] = [], []
        for k in range(n + 1):
            y = square(arb.sin_pi(arb(k) / (2 * n)))
            value = self._inverse(y)
            rows[0].append(value)
            rows[1].append(value * y)
        one, two = (
            _sines(row, eta, high)
            for row, high in zip(rows, (most, most * square((eta / 2).cosh())), strict=True)
        )
        return one, two

    def _near(self, t: arb) -> arb:
        """A number near x at a time of at most half a period, by Newton's iteration."""
        x = low = high = arb(0)
        with ctx.workprec(_ROUGH_BITS):
            low, high = arb(-4), arb(4)
            x = (t / self.time.mean).mid()
            for _ in range(_ROUGH_STEPS):
                miss = self.time.at(x) - t
                if miss > 0:
                    high = x
                else:
                    low = x
                new = (x - miss * self.rate(x)).mid()
                if not low < new < high:
                    new = (low + high) / 2
                step, x = abs(new - x), new
                if step < arb(2) ** -_ROUGH:
                    break
        right = _ROUGH
        while right < ctx.prec:
            x = (x - (self.time.at(x) - t) * self.rate(x)).mid()
            right *= 2
        return x


def _sines(samples: Sequence[acb], eta: arb, most: arb) -> SineSeries:
    """The integral of an even function from its samples on half a turn."""
    n = len(samples) - 1
    found = acb.dft([*samples, *samples[-2:0:-1]])
    last, ratio = (-n * eta).exp(), (-eta).exp()
    alias = 2 * most * last * last / (1 - last * last)
    error = 2 * most * last / (1 - ratio) * (arb(1) / n + ratio / (1 - last))
    return SineSeries(
        found[0].real / (2 * n) + around(alias).real,
        [x.real / (n * k) for k, x in enumerate(found[1:n], 1)],
        around(error).real,
    )
