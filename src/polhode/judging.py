"""A trajectory judged against a reference: correct digits over time, drift, what limits them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from polhode.correct_digits import digits_of, errors, rate_scale
from polhode.integrals import Drift
from polhode.integration import integrate
from polhode.precision import EXTENDED, QUAD, NumberType, decimal_string, exactly
from polhode.trajectory import Trajectory
from polhode.truth import Reference, Remembered, TwoPrecisions, reference

SPARE_DIGITS = 6  # of the reference beyond what the trajectory's type holds


@dataclass(frozen=True)
class Judgement:
    """Correct digits of a trajectory at each of its times, and what they say.

    ``digits[k]`` belongs to ``times[k]``; errors of w are relative to the largest |w| of the
    reference over all times.  ``pointwise`` relates them to |w| at the same time instead.
    """

    run: Trajectory
    reference: Reference | TwoPrecisions | Remembered
    digits: tuple[float, ...]
    pointwise: tuple[float, ...]

    @property
    def times(self) -> tuple[Fraction, ...]:
        """The times judged."""
        return self.run.times

    @property
    def worst(self) -> float:
        """The fewest correct digits."""
        return min(self.digits)

    @property
    def worst_time(self) -> Fraction:
        """The first time at which the digits are fewest."""
        return self.times[self.digits.index(self.worst)]

    @property
    def drift(self) -> Drift:
        """Drift of the integrals over the run."""
        return self.run.drift

    @cached_property
    def input_rounding(self) -> float:
        """Correct digits of the exact motion of the rounded inputs: what rounding them once costs.

        The same rounded start and coefficients, integrated in a wider type.
        """
        run = self.run
        replay = integrate(run.scene.at(run.times), wider(run.number), inputs=run.number)
        judged = _digits(replay.states, run, self.reference, run.number.most_digits)
        return min(judged[0])

    @property
    def limit(self) -> str:
        """What limits the digits: the type, the rounding of the inputs, or the steps."""
        if self.worst >= self.run.number.most_digits - 0.7:
            return "the number type"
        if self.input_rounding < self.worst + 0.5:
            return "rounding of the inputs"
        return "rounding in the steps" if self.run.at_full_tolerance else "the tolerance"

    def __str__(self) -> str:
        run, truth = self.run, self.reference
        shown = few(len(self.times), 9)
        lines = [
            f"{run.scene.name}: {run.number.name} ({run.number.bits} bits) against {truth.kind}"
            + ("" if truth.is_closed_form else f" (agree to {truth.agreement:.1f} digits)"),
            f"  {'t':>14}  correct digits",
            *(f"  {_short(self.times[k]):>14}  {self.digits[k]:.1f}" for k in shown),
            f"  worst {self.worst:.1f} at t = {_short(self.worst_time)};"
            f" inputs rounded alone {self.input_rounding:.1f}; limited by {self.limit}",
        ]
        lines.append("  drift " + drift_line(self.drift))
        return "\n".join(lines)


def compare(
    run: Trajectory, exact: Reference | TwoPrecisions | Remembered | None = None
) -> Judgement:
    """Judge a trajectory against a reference (the scene's own unless one is given)."""
    truth = exact if exact is not None else reference(run.scene)
    digits, pointwise = _digits(run.states, run, truth, run.number.most_digits)
    return Judgement(run, truth, digits, pointwise)


def _digits(
    states: Any, run: Trajectory, truth: Reference | TwoPrecisions | Remembered, cap: float
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    wanted = math.ceil(cap) + SPARE_DIGITS
    bits = math.ceil(wanted * math.log2(10)) + 32
    rows = truth.at(run.times, wanted)
    scale = rate_scale(rows, run.scene, bits)
    digits = tuple(digits_of(e, cap) for e in errors(states, rows, scale, bits))
    pointwise = []
    for row, true in zip(states, rows, strict=True):
        here = rate_scale([true], run.scene, bits)
        pointwise.append(digits_of(errors([row], [true], here, bits)[0], cap))
    return digits, tuple(pointwise)


def wider(number: NumberType) -> NumberType:
    """The next wider number type, for replaying a run's rounded inputs."""
    nexts = {"double": EXTENDED, "extended": QUAD, "quad": NumberType("mp", QUAD.bits + 40)}
    return nexts.get(number.name) or NumberType("mp", number.bits + 40)


def drift_line(drift: Drift) -> str:
    """Drift in one line."""
    names = ("h", "f", "|gamma|^2")
    shown = zip(names, drift, strict=True)
    return ", ".join(f"{name} {value:.1e}" for name, value in shown if value is not None)


def _short(t: Fraction) -> str:
    return f"{float(t):g}" if abs(t) < 10**300 else decimal_string(exactly(t), 6)


def few(count: int, most: int) -> list[int]:
    """At most ``most`` of the indices below ``count``, evenly spread, first and last among them."""
    if count <= most:
        return list(range(count))
    return sorted({round(k * (count - 1) / (most - 1)) for k in range(most)})
