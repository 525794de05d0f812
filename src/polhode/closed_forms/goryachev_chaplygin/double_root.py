"""v that tends to a double root w: its integrals along y, v = w + (ve - w) sech^2 y.

Where D- = 0 the cubic N has the double root w = sqrt((H - 2a)/3).  With ve the end of v's interval,
vo the other root of the cubic of v1, v2, k = 1 if v < w, else -1, dl = |w - ve| and

    L(v) = k (vo - v)(v + 2w)(v + v1 + v2),    g^2 = dl L,    y_s = g/4,

S~ = 4y/g_w plus what is bounded, an integral over tanh y of a function without singularities:
with tanh y = sin ps it is a sum of sines of odd multiples of ps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from polhode.closed_forms.functions.fourier import OddSines, cosines
from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions
from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.goryachev_chaplygin.abel_integrals import Halves
from polhode.closed_forms.goryachev_chaplygin.axes import GoryachevStart
from polhode.closed_forms.goryachev_chaplygin.separation_variables import v_roots
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.rows import Doubles
from polhode.numbers.scalars import Scalar

_SAMPLES = 64  # tried first
_STEPS = 30
_WIDE, _PLACES = 20.0, 1 << 15  # |y| up to which S~ is bent in doubles, and places of its table


@dataclass(frozen=True)
class Tending:
    """The variable v on its way from w to its turning point ve (at y = 0) and back to w."""

    w: Scalar
    ve: Scalar
    vo: Scalar
    a: Scalar
    k: int
    gw: Scalar
    S: OddSines
    U: OddSines
    periodic = False

    @property
    def means(self) -> tuple[Scalar, Scalar]:
        """The linear parts of S~ and V."""
        return 4 / self.gw, 4 * self.w / self.gw

    def bounded(self, phase: Scalar) -> tuple[Scalar, Scalar]:
        """The bounded parts of S~ and V at y = ``phase``."""
        cos, sin = self._turned(phase)
        s = self.S.at(cos, sin)
        return s, self.w * s + self.U.at(cos, sin)

    def _turned(self, y: Scalar) -> tuple[Scalar, Scalar]:
        """sech y and tanh y, in doubles or at the precision in force."""
        if self.S.bits is None:
            import numpy as np

            return 1 / np.cosh(np.clip(y, -300, 300)), np.tanh(y)
        return mpmath.sech(y), mpmath.tanh(y)

    def at(self, phase: Scalar, fn: SeriesFunctions) -> Halves:
        """The variable at y = ``phase``."""
        sech, tanh = self._turned(phase)
        sech2, dl, total = sech * sech, abs(self.w - self.ve), self.ve + self.vo
        v = self.w + (self.ve - self.w) * sech2
        e, rest = v + total, self.k * (self.vo - v)
        g = fn.sqrt(dl * rest * (v + 2 * self.w) * e)
        sine = self.k * tanh * fn.sqrt(dl * rest * e / (4 * self.a * v))
        cosine = dl * sech2 * fn.sqrt((v + 2 * self.w) / (4 * self.a * v))
        return Halves(v, sine, cosine, 4 / g)

    def started(self, v: Scalar, sine: Scalar) -> Scalar:
        """y at the start, from v and sin et."""
        sech = mpmath.sqrt((v - self.w) / (self.ve - self.w))
        dl = abs(self.w - self.ve)
        L = self.k * (self.vo - v) * (v + 2 * self.w) * (v + self.ve + self.vo)
        tanh = 2 * self.k * self.a * v * sine / (abs(v - self.w) * mpmath.sqrt(dl * L))
        return mpmath.asinh(tanh / sech)

    def phase(self, total: Scalar) -> Scalar:
        """y where S~ with its linear part is ``total``: it grows with y."""
        found, mean = mpf(self._guess(float(total))), self.means[0]
        for _ in range(_STEPS):
            step = (mean * found + self.bounded(found)[0] - total) / self.at(found, MP).slope
            found -= step
            if abs(step) < mpmath.ldexp(1, -mpmath.prec // 2 - 8):
                return found
        raise ArithmeticError("a phase was not found")

    def _guess(self, total: float) -> float:
        """The same in doubles, nearly: from a table, outside of which S~ is linear."""
        import numpy as np

        places, values = self._table
        slope = 4 / float(self.gw)
        if not values[0] < total < values[-1]:
            end = 0 if total <= values[0] else -1
            return float(places[end] + (total - values[end]) / slope)
        return float(np.interp(total, values, places))

    @cached_property
    def _table(self) -> tuple[Doubles, Doubles]:
        import numpy as np

        small, places = self.floats(), np.linspace(-_WIDE, _WIDE, _PLACES)
        return places, small.means[0] * places + small.bounded(places)[0]

    def floats(self) -> Tending:
        """The same in doubles, for arrays."""
        numbers: dict[str, Any] = {
            name: float(getattr(self, name)) for name in ("w", "ve", "vo", "a", "gw")
        }
        return replace(self, **numbers, S=self.S.doubles(), U=self.U.doubles())


def tending(start: GoryachevStart, bits: int, *, low: bool) -> Tending:
    """The constants at the precision in force; ``low``: v < w."""
    a, H = number(start.a, bits), number(start.H, bits)
    v1, v2 = v_roots(start, bits)
    w = mpmath.sqrt((H - 2 * a) / 3)
    ve, vo, k = (v1, v2, 1) if low else (v2, v1, -1)
    total, dl = v1 + v2, abs(w - ve)
    # L = c3 v^3 + c2 v^2 + c1 v + ...
    c3, c2, c1 = -k, k * (vo - 2 * w - total), k * (vo * (2 * w + total) - 2 * w * total)
    gw = mpmath.sqrt(dl * k * (vo - w) * 3 * w * (w + total))

    def integrands(x: Scalar) -> Sequence[Scalar]:
        v = w + (ve - w) * (1 + mpmath.cos(x)) / 2
        g = mpmath.sqrt(dl * k * (vo - v) * (v + 2 * w) * (v + total))
        divided = c3 * (v * v + v * w + w * w) + c2 * (v + w) + c1
        return -4 * dl * (ve - w) * divided / (g * gw * (g + gw)), 4 * (ve - w) / g

    S, U = (series.times_cosine() for series in cosines(integrands, _SAMPLES))
    return Tending(w, ve, vo, a, k, gw, S, U)
