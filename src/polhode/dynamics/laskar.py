"""The lines of a quasi-periodic signal, by J. Laskar's method (Icarus 88 (1990) 266).

With the window chi_n(t) = c_n (1 + cos pi tau)^n, tau from -1 to 1 over the samples and mean 1,

    F(om) = mean of z(t) chi_n(t) exp(-i om t)

has its largest modulus next to the strongest line: the nearest point of a fast Fourier transform,
padded eightfold, is refined by Newton's method on |F|^2.  The line is subtracted, then the next is
looked for.  A line at a distance d leaks by (d T)^-(2n + 1).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

POWER = 5  # of the window
LOWER = (3, 4)  # of those that its error is estimated by
PADDED = 8
_NEWTON = 12
_SEPARATE = 1.0  # of 2 pi/T: a peak that near to a line found before is what is left of it


class Line(NamedTuple):
    """One line: amplitude·exp(i frequency t), t from the first sample on.

    ``error``: an estimate of the frequency's, twice what windows of lower power are off.
    ``half``: what half the samples give less what all give: of a chaotic signal it is no smaller.
    """

    frequency: float
    amplitude: complex
    error: float
    half: float


def lines(samples: Any, step: float, count: int) -> list[Line]:
    """The strongest lines of equally spaced complex samples, strongest first; fewer if they end.

    ``step``: the time between two, pi/step more than twice the fastest line's frequency.
    """
    z = np.asarray(samples, dtype=complex)
    whole = _frequencies(z, step, count, POWER)
    lower = [_frequencies(z, step, count, power) for power in LOWER]
    half = _frequencies(z[: (len(z) + 1) // 2], step, count, POWER)
    length = step * (len(z) - 1)
    found = []
    for frequency, amplitude in whole:
        floor = 2.0**-52 * (abs(frequency) + 1 / length)
        apart = [_off(frequency, others, 2 * math.pi / length) for others in lower]
        error = max(floor, 2 * max(apart))
        found.append(Line(frequency, amplitude, error, _off(frequency, half, 4 * math.pi / length)))
    return found


def _off(frequency: float, others: list[tuple[float, complex]], most: float) -> float:
    """How far the nearest of some lines is, at most so far."""
    return min([abs(frequency - other) for other, _ in others] + [most])


def _frequencies(z: Any, step: float, count: int, power: int) -> list[tuple[float, complex]]:
    n = len(z)
    tau = np.linspace(-1, 1, n)
    window = (1 + np.cos(np.pi * tau)) ** power
    weight = np.ones(n)
    weight[[0, -1]] = 0.5
    window = window * weight
    window = window / window.sum()
    time = step * np.arange(n)
    rest, found = z.copy(), list[tuple[float, complex]]()
    size = math.sqrt(float(np.mean(np.abs(z) ** 2)))
    padded = PADDED * 2 ** math.ceil(math.log2(n))
    grid = 2 * np.pi * np.fft.fftfreq(padded, step)
    near = _SEPARATE * 2 * math.pi / time[-1]
    for _ in range(count):
        power_at = np.abs(np.fft.fft(rest * window, padded))
        for other, _amplitude in found:
            power_at[np.abs(grid - other) < near] = 0
        k = int(np.argmax(power_at))
        if power_at[k] <= 1e-14 * size:
            break
        frequency = _refined(rest * window, time, float(grid[k]), float(grid[1]))
        amplitude = complex((rest * window) @ np.exp(-1j * frequency * time))
        rest = rest - amplitude * np.exp(1j * frequency * time)
        found.append((frequency, amplitude))
    return found


def _refined(weighted: Any, time: Any, start: float, cell: float) -> float:
    """The maximum of |F|^2 nearest to a point of the grid."""
    frequency, centred = start, time - time[-1] / 2  # the phase turns least about the middle
    for _ in range(_NEWTON):
        turned = weighted * np.exp(-1j * frequency * centred)
        f, f1, f2 = turned.sum(), (-1j * centred) @ turned, -(centred**2) @ turned
        slope = 2 * (f.conjugate() * f1).real
        curve = 2 * (f.conjugate() * f2).real + 2 * abs(f1) ** 2
        step = -slope / curve if curve < 0 else math.copysign(cell / 2, slope)
        frequency += max(-cell, min(cell, step))
        if abs(step) < 1e-16 * abs(frequency) + 1e-300:
            break
    return float(frequency)
