"""Figure of frequencies: the lines of each signal, over its amplitude spectrum."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.dynamics.frequencies import Frequencies
from polhode.dynamics.naff import POWER
from polhode.figures import canvas
from polhode.figures.canvas import series
from polhode.figures.results import numbers, told
from polhode.results.result import Storable
from polhode.scenes.vocabulary import STATE


def draw(plt: Any, found: Storable, axes: Any = None) -> Any:
    """|F| over frequency by a window of (1 + cos)^5, and a circle on each line.

    Of a file, which has no samples, the lines alone.
    """
    known = told(found)
    signal = np.array(known.column("signal"), dtype=np.str_)
    frequency, amplitude = (numbers(known, name) for name in ("frequency", "amplitude"))
    samples = found.signals if isinstance(found, Frequencies) else {}
    names = [*(samples or dict.fromkeys(signal.tolist()))] or ["no signal"]
    size = (6.4, 0.6 + 1.9 * len(names))
    figure, panels = canvas.panels(plt, axes, len(names), figsize=size, sharex=True)
    span = 1.6 * float(np.abs(frequency).max(initial=0.0)) or 1.0
    curve, mark = series(2)
    for panel, name in zip(panels[:, 0], names, strict=True):
        own = signal == name
        top = float(amplitude[own].max(initial=0.0)) or 1.0
        if isinstance(found, Frequencies):
            at, power = spectrum(samples[name], found.step)
            shown = np.abs(at) <= span
            panel.semilogy(at[shown], power[shown], color=curve, lw=0.6, gid=f"spectrum {name}")
        else:
            panel.vlines(frequency[own], top * 1e-14, amplitude[own], color=curve, lw=0.6)
            panel.set_yscale("log")
        panel.plot(frequency[own], amplitude[own], "o", color=mark, ms=3.5, mfc="none", gid=name)
        panel.set(ylim=(top * 1e-14, top * 5), ylabel=f"|F| of {name}")
    real = all(name in STATE for name in names)
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
