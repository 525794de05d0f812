"""Where an expression crosses zero along a motion: from its extrema in quad, without polhode.

Between two neighbouring extrema an expression is monotone: its signs there say whether it crosses
zero once or not at all.  heyoka finds the extrema, in quad and along equations written down here.
Extrema too near to zero for a run of fewer digits leave their windows open.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

NAMES = ("p", "q", "r", "gamma1", "gamma2", "gamma3")
TEXTS = (
    *("p", "q", "gamma3", "q - gamma2", "p*gamma2 - q*gamma1", "gamma3**2", "p*q*r", "p**3"),
    *("p**2 + q**2", "(2*p**2 + 3*q**2 + r**2)/2", "p*gamma1 + q*gamma2 + r*gamma3"),
    *("sin(3*q)", "gamma1 + t/10", "t*q", "p/(2 + gamma3)", "cos(2*t)*gamma2 - p"),
)
QUAD = hy.real128


class Window(NamedTuple):
    """From one extremum to another, the signs there, and how many between them are too near zero.

    Times are counted along the run.
    """

    begin: float
    end: float
    before: int
    after: int
    unsure: int


@dataclass
class Sized:
    """A float and the sum of the roundings of all that it was made of, in units u."""

    value: float
    error: float = 0.0

    def _with(self, term: object, value: float, error: float) -> Sized:
        return Sized(value, error + abs(value))

    def __add__(self, other: Any) -> Sized:
        b = _sized(other)
        return self._with(b, self.value + b.value, self.error + b.error)

    def __sub__(self, other: Any) -> Sized:
        b = _sized(other)
        return self._with(b, self.value - b.value, self.error + b.error)

    def __mul__(self, other: Any) -> Sized:
        b = _sized(other)
        second = 32 * 2.0**-53 * self.error * b.error
        error = self.error * abs(b.value) + abs(self.value) * b.error + second
        return self._with(b, self.value * b.value, error)

    def __truediv__(self, other: Any) -> Sized:
        b = _sized(other)
        value = self.value / b.value
        return self._with(b, value, (self.error + abs(value) * b.error) / abs(b.value))

    def __pow__(self, n: int) -> Sized:
        return self if n == 1 else self * self ** (n - 1)

    def __neg__(self) -> Sized:
        return Sized(-self.value, self.error)

    __radd__ = __add__
    __rmul__ = __mul__

    def __rsub__(self, other: Any) -> Sized:
        return _sized(other) - self


def _sized(x: Any) -> Sized:
    return x if isinstance(x, Sized) else Sized(float(x))


def _sine(x: Any) -> Any:
    return Sized(np.sin(x.value), x.error + 1) if isinstance(x, Sized) else hy.sin(x)


def _cosine(x: Any) -> Any:
    return Sized(np.cos(x.value), x.error + 1) if isinstance(x, Sized) else hy.cos(x)


def rates(x: Sequence[Any], k: Sequence[Any]) -> list[Any]:
    """A p' = (B - C) q r + gamma2 c - gamma3 b and so on; ``k``: A B C, weight times centre."""
    p, q, r, g1, g2, g3 = x
    big_a, big_b, big_c, a, b, c = k
    return [
        ((big_b - big_c) * (q * r) + (g2 * c - g3 * b)) / big_a,
        ((big_c - big_a) * (r * p) + (g3 * a - g1 * c)) / big_b,
        ((big_a - big_b) * (p * q) + (g1 * b - g2 * a)) / big_c,
        r * g2 - q * g3,
        p * g3 - r * g1,
        q * g1 - p * g2,
    ]


def value(text: str, x: Sequence[Any], t: Any) -> Any:
    """One of TEXTS at a state and a time, of any numbers."""
    return eval(
        text, {"sin": _sine, "cos": _cosine}, dict(zip((*NAMES, "t"), (*x, t), strict=True))
    )


@dataclass
class Truth:
    """The extrema of scale * (text + shift - level) along motions, in quad: one text, any body."""

    text: str
    met: list[tuple[float, np.ndarray]] = field(default_factory=list)

    def __post_init__(self) -> None:
        variables, t = hy.make_vars(*NAMES), hy.make_vars("t")
        field_ = rates(variables, [hy.par[i] for i in range(6)])
        # the scale and the level change no extremum
        plain = value(self.text, variables, t)
        rate = hy.diff(plain, t) + sum(
            hy.diff(plain, v) * f for v, f in zip(variables, field_, strict=True)
        )
        options = {"fp_type": QUAD, "compact_mode": True}
        self.plain = hy.cfunc([plain], vars=[*variables, t], **options)
        height = hy.subs(rate, {t: hy.time}) * hy.expression(QUAD(2.0**-56)) + hy.par[6]
        event = hy.nt_event(height, _Note(self.met), fp_type=QUAD)
        state, pars = np.array([QUAD(0)] * 6), np.array([QUAD(1)] * 7)
        equations = [*zip(variables, field_, strict=True)]
        self.heyoka = hy.taylor_adaptive(equations, state, pars=pars, nt_events=[event], **options)

    def extrema(
        self, k: Sequence[float], start: Sequence[float | str], end: float
    ) -> list[tuple[float, Any, np.ndarray]]:
        """Time, value and state at the start, at each extremum, and at the end."""
        ta = self.heyoka
        self.met.clear()
        ta.time = QUAD(0)
        ta.state[:] = first = np.array([QUAD(x) for x in start])
        # heyoka loses a zero behind an exact one at the beginning of a step
        ta.pars[:] = np.array([QUAD(x) for x in (*k, 2.0**-210)])
        ta.propagate_until(QUAD(end), max_steps=1)
        ta.pars[6] = QUAD(0)
        ta.propagate_until(QUAD(end))
        inner = sorted(self.met, key=lambda place: abs(place[0]))
        rows = [(QUAD(0), first), *((t, row) for t, row in inner if t != QUAD(0))]
        rows.append((QUAD(end), ta.state.copy()))
        return [(t, self.plain(np.append(row, t))[0], row) for t, row in rows]


class _Note:
    def __init__(self, met: list[tuple[float, np.ndarray]]) -> None:
        self.met = met

    def __call__(self, ta: Any, t: Any, _: int) -> None:
        self.met.append((t, ta.update_d_output(t).copy()))

    def __deepcopy__(self, _: object) -> _Note:
        return self


def windows(
    truth: Truth,
    places: Sequence[tuple[float, Any, np.ndarray]],
    k: Sequence[float],
    function: Callable[[Any], Any],
    off: float,
    u: float,
) -> list[Window]:
    """The windows of ``made`` of the text; ``off``: how far the run's state may be off."""
    between: list[Window] = []
    last: tuple[float, int] | None = None
    unsure = 0
    for i, (t, plain, row) in enumerate(places):
        x = [float(v) for v in row]
        leaves = [
            Sized(v, abs(v) + rate.error / 2)
            for v, rate in zip(x, rates([Sized(v, abs(v)) for v in x], k), strict=True)
        ]
        clock = Sized(float(t), abs(float(t)))
        error = function(value(truth.text, leaves, clock)).error
        moved = [Sized(v, max(1.0, np.max(np.abs(x)))) for v in x]
        reach = function(value(truth.text, moved, Sized(float(t)))).error
        height = float(function(plain))
        exact = i == 0 and height != 0 and abs(height) > 64 * u * error
        if not exact and abs(height) <= 64 * u * error + 4 * off * reach:
            unsure += 1
            continue
        side = 1 if height > 0 else -1
        if last is not None:
            between.append(Window(last[0], abs(float(t)), last[1], side, unsure))
        last, unsure = (abs(float(t)), side), 0
    return between
