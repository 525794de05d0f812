"""Figure of frequencies: the amplitude spectrum of each signal, its lines marked."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.dynamics.frequencies.frequencies import Frequencies
from polhode.dynamics.frequencies.naff import POWER
from polhode.figures.canvas import canvas
from polhode.figures.canvas.canvas import BODY, SPACE


def draw(plt: Any, found: Frequencies, axes: Any = None) -> Any:
    """|F| over frequency by a window of (1 + cos)^5, and a circle on each line."""
    count = len(found.lines)
    size = (6.4, 0.6 + 1.9 * count)
    figure, panels = canvas.panels(plt, axes, count, figsize=size, sharex=True)
    every = [line for lines in found.lines.values() for line in lines]
    fastest = max((abs(line.frequency) for line in every), default=0.0)
    span = 1.6 * fastest or 1.0
    for panel, (name, lines) in zip(panels[:, 0], found.lines.items(), strict=True):
        frequency, power = spectrum(found.signals[name], found.step)
        shown = np.abs(frequency) <= span
        panel.semilogy(frequency[shown], power[shown], color=BODY, lw=0.6, gid=f"spectrum {name}")
        for line in lines:
            panel.plot(line.frequency, abs(line.amplitude), "o", color=SPACE, ms=3.5, mfc="none")
        top = max(abs(line.amplitude) for line in lines) if lines else 1.0
        panel.set(ylim=(top * 1e-14, top * 5), ylabel=f"|F| of {name}")
    real = not any(np.any(np.imag(signal)) for signal in found.signals.values())
    panels[-1, 0].set(xlim=(0 if real else -span, span), xlabel="frequency (rad / unit of time)")
    return figure


def spectrum(samples: Any, step: float) -> tuple[Any, Any]:
    """Frequencies and moduli of the windowed transform, ascending."""
    n = len(samples)
    if step < 0:  # as time rises
        samples, step = np.conj(samples), -step
    window = (1 + np.cos(np.pi * np.linspace(-1, 1, n))) ** POWER
    centred = samples - (samples @ window) / window.sum() if not np.any(samples.imag) else samples
    padded = 4 * 2 ** int(np.ceil(np.log2(n)))
    power = np.abs(np.fft.fft(centred * window / window.sum(), padded))
    frequency = 2 * np.pi * np.fft.fftfreq(padded, step)
    return np.fft.fftshift(frequency), np.maximum(np.fft.fftshift(power), 1e-300)
