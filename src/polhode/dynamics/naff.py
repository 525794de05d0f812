"""The lines of a quasi-periodic signal, by J. Laskar's method (Icarus 88 (1990) 266).

With the window chi_n(t) = c_n (1 + cos pi tau)^n, tau from -1 to 1 over the samples and mean 1,

    F(om) = mean of z(t) chi_n(t) exp(-i om t)

has its largest modulus next to the strongest line: the nearest point of a fast Fourier
transform, padded, is refined by Newton's method on |F|^2. The line is subtracted, then the next
is looked for. A line at a distance d leaks by (d T)^-(2n + 1).

A real signal is m + sum of 2 Re a exp(i om t), om > 0: +om and -om are one line, looked for
among om > 0 and subtracted together with its mirror image; the constant m is no line. A
constant part of a complex signal is a line at 0.

The error of a frequency is judged by what did not make it (:func:`_errors`): a second window,
and what the lines leave of the signal.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.numbers.number_types import Complexes, Doubles

# --- leakage --------------------------------------------------------------------------------------
#
# How far a line shifts the maximum that another makes, under the window (1 + cos)^n.
#
# The window's transform at x bins of 2 pi/T is
#
#     W(x) = sin(pi x)/(pi x) prod_{k=1..n} k^2/(k^2 - x^2),   W''(0) = -2 sum_{k > n} 1/k^2
#
# (DLMF 5.12.5 for (1 + cos pi tau)^n = 2^n cos^2n(pi tau/2); by the product of the sine, DLMF
# 4.22.1, W is that of 1 - x^2/k^2 over k > n). So the maximum of a line of amplitude 1 shifts by up
# to |b W'(x)/W''(0)| bins for another one of amplitude b at x bins; here an upper envelope of that
# over all that lie as far or farther.


_FINE, _PAST = 100, 2  # points a bin; bins past the main lobe from which on the tail's law holds


def leak(bins: Doubles, power: int) -> Doubles:
    """The largest shift, in bins, by a line of equal amplitude so many bins away or farther."""
    at, table = _table(power)
    x = np.maximum(np.abs(bins), at[-1])
    tail = np.ones_like(x)
    for k in range(1, power + 1):
        tail = tail * (at[-1] ** 2 - k * k) / (x * x - k * k)
    shift: Doubles = np.interp(np.abs(bins), at, table) * tail * at[-1] / x
    return shift


@lru_cache(maxsize=4)
def _table(power: int) -> tuple[Doubles, Doubles]:
    """The envelope where the window's transform has its main lobe, and a little beyond."""
    last = power + 1 + _PAST
    at = (np.arange((last + 1) * _FINE) + 0.5) / _FINE  # no whole number: W is a limit there
    w = np.sinc(at)
    for k in range(1, power + 1):
        w = w * k * k / (k * k - at * at)
    slope = np.abs(np.gradient(w, at))
    curve = math.pi**2 / 3 - 2 * sum(1 / k**2 for k in range(1, power + 1))
    envelope = np.maximum.accumulate(slope[::-1])[::-1] / curve
    main = at <= last
    return at[main], envelope[main]


# --- naff -----------------------------------------------------------------------------------------


POWER = 5  # of the window
_NEWTON, _AGAIN = 12, 2  # steps: from a grid's point, and from where a line was found
_SEPARATE = 1.0  # of 2 pi/T: a peak that near to a line found before is what is left of it
_SMALLEST = 1e-14  # of the signal: a line below is rounding
_PADDED, _SECOND_PADDED = 8, 5  # the two windows share no point of their grids
_SECOND_LEFT_OUT = 8  # the second window is without the first of so many parts
_SECOND_MORE = 2  # lines looked for there: weak ones of equal size come in any order
_MORE, _SWEEPS = 4, 2  # weaker lines taken away too; sweeps, each line anew beside all others
_SURE = 2.0  # times what the second window and the rest say
_ROUNDING, _WANDER = 32.0, 512.0  # half ulps: of a frequency; of the phase of a run in double
_REST_NEAR, _LINE_NEAR = 2.0, 4.0  # of 2 pi/T: what is left, and other lines, so near to a line
_UNRESOLVED = 1e-10  # of its amplitude are neighbours that are not told from it


_Wave: TypeAlias = tuple[float, complex]  # frequency and amplitude


class SpectralLine(NamedTuple):
    """One line: amplitude·exp(i frequency t), t from the first sample on.

    Of a real signal also its mirror image, which makes both 2 |amplitude| cos(frequency t + phase).

    ``error``: an estimate of the frequency's, see :func:`_errors`.
    ``half``: what half the samples give less what all give: of a chaotic signal it is no smaller.
    """

    frequency: float
    amplitude: complex
    error: float
    half: float


class _Window:
    """Samples under the window of power POWER: their transform, and its maxima.

    ``real``: whether a line is one with its mirror image, and a constant is none.
    """

    def __init__(self, n: int, step: float, padded: int, real: bool = False) -> None:
        window = (1 + np.cos(np.pi * np.linspace(-1, 1, n))) ** POWER
        weight = np.ones(n)
        weight[[0, -1]] = 0.5
        window = window * weight
        self.weights = window / window.sum()
        self.time = (step * np.arange(n)).astype(np.float64, copy=False)
        self.padded = padded * 2 ** math.ceil(math.log2(n))
        self.grid = 2 * np.pi * np.fft.fftfreq(self.padded, step)
        self.bin = 2 * math.pi / float(self.time[-1])
        self.real = real

    def moduli(self, z: Complexes) -> Doubles:
        """|F| at the points of the grid."""
        return np.abs(np.fft.fft(z * self.weights, self.padded))

    def line(self, z: Complexes, start: float, most: int = _NEWTON) -> _Wave:
        """The maximum of |F|^2 nearest to ``start``, and F there."""
        weighted, cell = z * self.weights, float(self.grid[1])
        frequency = _refined(weighted, self.time, start, cell, most)
        return frequency, complex(weighted @ np.exp(-1j * frequency * self.time))

    def wave(self, line: _Wave) -> Complexes:
        """A line's part of the signal, without its mirror image."""
        wave: Complexes = line[1] * np.exp(1j * line[0] * self.time)
        return wave

    def without(self, rest: Complexes, wave: Complexes) -> Complexes:
        """What is left where a line's wave is taken away; of a real signal no constant, either."""
        if not self.real:
            return rest - wave
        left = rest - 2 * wave.real
        without_constant: Complexes = left - self.weights @ left
        return without_constant

    def again(self, line: _Wave, rest: Complexes) -> tuple[_Wave, Complexes]:
        """A line anew, with all others and its mirror image taken away; and what is then left."""
        wave = self.wave(line)
        anew = self.line(rest + wave, line[0], _AGAIN)
        return anew, self.without(self.without(rest, -wave), self.wave(anew))

    def beside_each_other(
        self, first: list[_Wave], rest: Complexes
    ) -> tuple[list[_Wave], Complexes]:
        """Each line again with all others taken away; and what is then left."""
        lines = list(first)
        for _ in range(_SWEEPS):
            for k, line in enumerate(lines):
                lines[k], rest = self.again(line, rest)
        return lines, rest

    def lines(self, z: Complexes, count: int, least: float) -> tuple[list[_Wave], Complexes]:
        """The strongest lines, none below ``least``, and what they leave of z."""
        rest, waves = self.without(z, 0 * z), list[_Wave]()
        for _ in range(count):
            moduli = self.moduli(rest)
            for frequency, _amplitude in waves:
                moduli[np.abs(self.grid - frequency) < _SEPARATE * self.bin] = 0
            if self.real:
                moduli[self.grid < _SEPARATE * self.bin] = 0
            k = int(np.argmax(moduli))
            if moduli[k] <= least:
                break
            line = self.line(rest, float(self.grid[k]))
            rest = self.without(rest, self.wave(line))
            for _ in range(_SWEEPS if self.real else 0):
                line, rest = self.again(line, rest)
            waves.append(line)
        return waves, rest


def lines(samples: Doubles | Complexes, step: float, count: int) -> list[SpectralLine]:
    """The strongest lines of equally spaced samples, strongest first; fewer if they end.

    Samples without any imaginary part are a real signal's.  ``step``: the time between two,
    negative where time falls; pi/step more than twice the fastest line's frequency.
    """
    z = np.asarray(samples, dtype=complex)
    real = not z.imag.any()
    size = size_of(z)
    if size == 0:
        return []
    # powers of two: numbers of order one, and no bit of an answer depends on the units
    unit, large = math.frexp(step)[1], math.frexp(size)[1]
    z = np.ldexp(z.real, -large) + 1j * np.ldexp(z.imag, -large)
    size, pace = math.ldexp(size, -large), abs(math.ldexp(step, -unit))
    window = _Window(len(z), pace, _PADDED, real)
    whole, rest = window.lines(z, count, _SMALLEST * size)
    errors = _errors(window, z, whole, rest, size)
    middle = z[: (len(z) + 1) // 2]
    half, _ = _Window(len(middle), pace, _PADDED, real).lines(middle, count, _SMALLEST * size)
    result = []
    for (frequency, amplitude), error in zip(whole, errors, strict=True):
        numbers = [frequency, error, _off(frequency, half, 2 * window.bin)]
        numbers = [math.ldexp(x, -unit) for x in numbers]
        amplitude = complex(math.ldexp(amplitude.real, large), math.ldexp(amplitude.imag, large))
        if step < 0:  # the samples as time rises have each line's mirror image
            numbers[0] = -numbers[0]
        if real and numbers[0] < 0:  # of both images the one above 0
            numbers[0], amplitude = -numbers[0], amplitude.conjugate()
        result.append(SpectralLine(numbers[0], amplitude, numbers[1], numbers[2]))
    return result


def size_of(samples: Doubles | Complexes) -> float:
    """The root of the mean square, without overflow."""
    largest = float(np.max(np.abs(samples), initial=0.0))
    if not largest:
        return 0.0
    return largest * math.sqrt(float(np.mean(np.abs(samples / largest) ** 2)))


def _errors(
    window: _Window, z: Complexes, waves: list[_Wave], rest: Complexes, size: float
) -> list[float]:
    """What each frequency may be off, by three things that a wrong one does not pass together.

    A second window, shorter, later and on another grid, is searched anew.  Each line is refined
    again beside all others, which takes their leakage away, and what is then left of the signal
    leaks as the window does.  Where a rest or a line stays as near as the window sees, a neighbour
    is not resolved: two lines d bins apart (d < 1) leave d^2, so the line may be off by the root.
    Two that leave less than _UNRESOLVED count as one.  Of a real signal the mirror images are such
    neighbours, and what is not resolved within the window's main lobe about 0 may be constant.
    """
    n, step = len(z), float(window.time[1])
    second = _Window(n - n // _SECOND_LEFT_OUT, step, _SECOND_PADDED, window.real)
    later = z[n - len(second.time) :]
    others, _ = second.lines(later, len(waves) + _SECOND_MORE, _SMALLEST * size)
    beside, rest = window.beside_each_other(list(waves), rest)
    for _ in range(_MORE):  # one by one: strong ones hide each other's neighbours
        more, rest = window.lines(rest, 1, _SMALLEST * size)
        beside, rest = window.beside_each_other(beside + more, rest)
    left = window.moduli(rest)
    images = [(-place, height) for place, height in beside] if window.real else []
    errors = []
    for k, (frequency, amplitude) in enumerate(waves):
        refined = beside[k][0]
        away = np.abs(window.grid - refined) / window.bin
        relative = left / abs(amplitude)
        leaked = float(np.max(relative * leak(away, POWER))) * window.bin
        near = max(
            [float(np.max(relative[away < _REST_NEAR]))]
            + [
                abs(height / amplitude)
                for j, (place, height) in enumerate(beside + images)
                if j != k and abs(place - refined) < _LINE_NEAR * window.bin
            ]
        )
        again = _off(frequency, others, window.bin)
        error = _SURE * max(again, abs(frequency - refined) + leaked)
        if near > _UNRESOLVED:
            slow = window.real and abs(frequency) < (POWER + 1) * window.bin
            reach = max(window.bin, abs(frequency) / _SURE) if slow else window.bin
            error += _SURE * math.sqrt(min(near, 1.0)) * reach
        rounding = _ROUNDING * abs(frequency) + (_WANDER + size / abs(amplitude)) * window.bin
        errors.append(max(error, 2.0**-53 * rounding))
    return errors


def _off(frequency: float, others: list[_Wave], most: float) -> float:
    """How far the nearest of some lines is, at most so far."""
    return min([abs(frequency - line) for line, _ in others] + [most])


def _refined(weighted: Complexes, time: Doubles, start: float, cell: float, most: int) -> float:
    """The maximum of |F|^2 nearest to a point of the grid."""
    frequency, centred = start, time - time[-1] / 2  # the phase turns least about the middle
    for _ in range(most):
        rotated = weighted * np.exp(-1j * frequency * centred)
        f, f1, f2 = rotated.sum(), (-1j * centred) @ rotated, -(centred**2) @ rotated
        slope = 2 * (f.conjugate() * f1).real
        curve = 2 * (f.conjugate() * f2).real + 2 * abs(f1) ** 2
        step = -slope / curve if curve < 0 else math.copysign(cell / 2, slope)
        frequency += max(-cell, min(cell, step))
        if abs(step) < 1e-16 * abs(frequency) + 1e-300:
            break
    return float(frequency)
