"""Integrals of even periodic functions by their Fourier series, to the precision in force."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from polhode.numbers.mpmath_context import mpc, mpf, mpmath

_MOST = 2048  # samples of a period


class PeriodicIntegral:
    """The integral from 0 of an even function of period 2 pi, analytic where |Im x| < ``strip``.

    The trapezoidal sums for Fourier's coefficients converge like exp(-n strip).  Raises ValueError
    where they take too many samples.
    """

    def __init__(self, function: Callable[[mpf], mpc], strip: mpf) -> None:
        terms = int(mpmath.prec * mpmath.ln2 / strip) + 1
        if 2 * terms > _MOST:
            raise ValueError("branch points are too near each other")
        count = 2 ** (2 * terms - 1).bit_length()
        half = [function(2 * mpmath.pi * k / count) for k in range(count // 2 + 1)]
        quarter = [mpmath.expjpi(mpmath.mpf(-2 * k) / count) for k in range(max(1, count // 4))]
        roots = [*quarter, *(mpc(z.imag, -z.real) for z in quarter)]  # the other half: -1 of them
        sums = _fourier([*half, *half[-2:0:-1]], roots)
        #: The mean of the function.
        self.mean: mpc = sums[0] / count
        self._waves = [sums[k] / (k * count) for k in range(terms, 0, -1)]

    def at(self, x: mpf) -> mpc:
        """The integral from 0 to x, the sines by Clenshaw's recurrence."""
        cos, sin = mpmath.cos_sin(x)
        twice, here, above = 2 * cos, mpc(0), mpc(0)
        for wave in self._waves:
            here, above = wave + twice * here - above, here
        return self.mean * x + 2 * sin * here


def _fourier(values: Sequence[mpc], roots: Sequence[mpc]) -> list[mpc]:
    """The sums of the values times powers of each root of 1 (Cooley and Tukey 1965).

    ``roots``: the first half of them.
    """
    if len(values) == 1:
        return [*values]
    even, odd = (_fourier(values[k::2], roots[::2]) for k in (0, 1))
    turned = [x * root for x, root in zip(odd, roots, strict=False)]
    return [x + side * y for side in (1, -1) for x, y in zip(even, turned, strict=True)]
