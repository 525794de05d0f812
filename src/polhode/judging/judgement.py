"""A trajectory judged against a reference: correct digits over time, drift, what limits them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from polhode.equations.integrals import Drift
from polhode.judging.conditioning import Conditioning, conditioning
from polhode.judging.digits import digits_of, errors, rate_scale
from polhode.judging.limits import Attribution, is_lost, limit, shown_digits, shown_possible
from polhode.judging.lyapunov import Lyapunov, lyapunov
from polhode.judging.reference import Reference, Remembered, TwoPrecisions, reference
from polhode.numbers.convert import exactly, to_mpf
from polhode.numbers.decimals import decimal_string
from polhode.numbers.number_types import wider
from polhode.runs.integrate import integrate
from polhode.runs.trajectory import Trajectory

SPARE_DIGITS = 6  # of the reference beyond what the trajectory's type holds


@dataclass(frozen=True)
class Judgement:
    """Correct digits of a trajectory at each of its times, and what they say.

    ``digits[k]`` belongs to ``times[k]``; errors of w are relative to the largest |w| of the
    reference over all times.  ``pointwise`` relates them to |w| at the same time instead.
    ``known``: kappa at the scene's times, where it is known already.
    """

    run: Trajectory
    reference: Reference | TwoPrecisions | Remembered
    digits: tuple[float, ...]
    pointwise: tuple[float, ...]
    known: Conditioning | None = None

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
    def conditioning(self) -> Conditioning:
        """Kappa at the run's times."""
        if self.known is not None:
            return self.known
        return conditioning(self.run.scene.at(self.run.times), number=self.run.number)

    @cached_property
    def digits_possible(self) -> tuple[float | None, ...]:
        """The digits that kappa leaves at each time; None where it was not computed."""
        return self.conditioning.digits_possible(self.run.number)[: len(self.times)]

    @cached_property
    def motion(self) -> Lyapunov:
        """Whether the scene's motion is regular or chaotic, and its Lyapunov exponent."""
        return lyapunov(self.run.scene)

    @property
    def lost(self) -> str:
        """That no digits are left, and after which time; empty where some are left throughout."""
        gone = any(map(is_lost, self.digits, self.digits_possible))
        return self.conditioning.lost if gone else ""

    @cached_property
    def input_rounding(self) -> float:
        """Correct digits of the exact motion of the rounded inputs: what rounding them once costs.

        The same rounded start and coefficients, integrated in a wider type.
        """
        judged = _digits(self._replay, self.run, self.reference, self.run.number.most_digits)
        return min(judged[0])

    @cached_property
    def _replay(self) -> Any:
        run = self.run
        return integrate(run.scene.at(run.times), wider(run.number), inputs=run.number).states

    @cached_property
    def limit(self) -> str:
        """What limits the digits: rounding, conditioning, method or reference, and why."""
        run, truth, held = self.run, self.reference, self.run.number.most_digits
        steps = "rounding in the steps"
        if not run.at_full_tolerance:
            steps = f"tolerance {run.tolerance:.1e}"
        if limit(self.worst, held, None, truth.agreement, steps) in ("rounding", "reference"):
            return limit(self.worst, held, None, truth.agreement, steps)  # needs no kappa
        possible = self._possible
        if possible is None:
            possible, steps = self.input_rounding, f"{steps}; kappa not computed"
        return limit(self.worst, held, possible, truth.agreement, steps)

    @cached_property
    def attribution(self) -> Attribution:
        """What the problem allows, what the method added, and what the reference is good for.

        The method's share is the run's distance from the motion of its rounded inputs.
        """
        run, at = self.run, self.times.index(self.worst_time)
        held = run.number.most_digits
        bits = wider(run.number).bits + 32
        rows = [[to_mpf(exactly(x), bits) for x in row] for row in self._replay]
        scale = rate_scale(rows, run.scene, bits)
        method = digits_of(errors([run.states[at]], [rows[at]], scale, bits)[0], held)
        return Attribution(self.worst, held, self._possible, method, self.reference.agreement)

    @property
    def _possible(self) -> float | None:
        return self.digits_possible[self.digits.index(self.worst)]

    def __str__(self) -> str:
        run, truth = self.run, self.reference
        shown, possible = few(len(self.times), 9), self.digits_possible
        lines = [
            f"{run.scene.name}: {run.number.name} ({run.number.bits} bits) against {truth.kind}"
            + ("" if truth.is_closed_form else f" (agree to {truth.agreement:.1f} digits)"),
            f"  {'t':>14}  correct digits  possible",
            *(
                f"  {_short(self.times[k]):>14}  {shown_digits(self.digits[k], possible[k]):<14}"
                f"  {shown_possible(possible[k])}"
                for k in shown
            ),
            f"  {self.lost or f'worst {self.worst:.1f} at t = {_short(self.worst_time)}'};"
            f" limited by {self.limit}",
        ]
        projected = f"projected {run.projection}" if run.projected else ""
        lines.append("  " + (projected or "drift " + drift_line(self.drift)))
        return "\n".join(lines)


def compare(
    run: Trajectory,
    exact: Reference | TwoPrecisions | Remembered | None = None,
    known: Conditioning | None = None,
) -> Judgement:
    """Judge a trajectory against a reference (the scene's own unless one is given).

    ``known``: the scene's conditioning, to spare its computation.
    """
    truth = exact if exact is not None else reference(run.scene)
    digits, pointwise = _digits(run.states, run, truth, run.number.most_digits)
    return Judgement(run, truth, digits, pointwise, known)


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


def drift_line(drift: Drift) -> str:
    """Drift in one line."""
    names = ("h", "f", "|gamma|^2", "fourth integral")
    shown = zip(names, drift, strict=True)
    return ", ".join(f"{name} {value:.1e}" for name, value in shown if value is not None)


def _short(t: Fraction) -> str:
    return f"{float(t):g}" if abs(t) < 10**300 else decimal_string(exactly(t), 6)


def few(count: int, most: int) -> list[int]:
    """At most ``most`` of the indices below ``count``, evenly spread, first and last among them."""
    if count <= most:
        return list(range(count))
    return sorted({round(k * (count - 1) / (most - 1)) for k in range(most)})
