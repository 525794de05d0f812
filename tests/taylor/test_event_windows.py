"""Random motions, expressions and levels: every crossing once, and nothing where there is none.

Between neighbouring extrema an expression crosses zero once or not at all: what those are is told
by heyoka in quad along other equations, which stand here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

import heyoka as hy
import mpmath
import numpy as np
import pytest

import polhode
from polhode.equations.forms import principal
from polhode.taylor.event_batches import Watched
from polhode.taylor.event_functions import jet_of, marks_at, typed_constant
from shared.tools import DOUBLE, tiers

# -- Where an expression crosses zero along a motion: from its extrema in quad, without polhode ----
# Between two neighbouring extrema an expression is monotone: its signs there say whether it crosses
# zero once or not at all.  heyoka finds the extrema, in quad and along equations written down here.
# Extrema too near to zero for a run of fewer digits leave their windows open.

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


# -- cases and what is told of them ------------------------------------------------------------

U = {"double": 2.0**-53, "extended": 2.0**-64, "quad": 2.0**-113}


@cache
def truth_of(text: str) -> Truth:
    return Truth(text)


def motion(draw: np.random.Generator) -> tuple[str, list[float], list[float]]:
    """A body's moments and weight times centre, a start: free, Lagrange's, general, small."""
    while True:
        moments = draw.uniform(0.5, 2, 3)
        if 2 * max(moments) < sum(moments):
            break
    kind = draw.choice(["free", "lagrange", "general", "wobble", "pendulum"])
    arm, omega, gamma = draw.uniform(-1, 1, 3), draw.uniform(-2, 2, 3), draw.normal(size=3)
    if kind in ("free", "wobble"):
        arm[:] = 0
    if kind == "lagrange":
        moments[1] = moments[0]
        moments[2] = min(moments[2], 2 * moments[0])
        arm[:2] = 0
    if kind == "wobble":
        size = 10.0 ** draw.uniform(-14, -3)
        omega = np.array([size, size * draw.uniform(-1, 1), draw.uniform(0.7, 2)])
        gamma = np.array([size * draw.uniform(-1, 1), size, 1.0])
    if kind == "pendulum":
        size = 10.0 ** draw.uniform(-12, -2)
        arm = np.array([0.0, 0.0, -draw.uniform(0.3, 1)])
        omega = size * draw.uniform(-1, 1, 3)
        gamma = np.array([size * draw.uniform(-1, 1), size, 1.0])
    gamma /= np.linalg.norm(gamma)
    return kind, [*moments.tolist(), *arm.tolist()], [*omega.tolist(), *gamma.tolist()]


def unit(gamma: list[float]) -> list[str]:
    """As polhode takes it: doubles of length 1 but for rounding are of length 1."""
    with mpmath.workdps(50):
        length = mpmath.sqrt(sum(mpmath.mpf(x) ** 2 for x in gamma))
        return [str(x / length) for x in gamma]


class Case:
    """A motion, an expression, and the windows in which it crosses zero or does not."""

    def __init__(self, seed: int, number: str, texts: tuple[str, ...] = TEXTS) -> None:
        draw = np.random.default_rng(seed)
        self.text, self.number = str(draw.choice(texts)), number
        kind, k, start = motion(draw)
        end = float(draw.choice([6.0, 10.0, -8.0]))
        self.way = 1 if end > 0 else -1
        self.scale = float(10.0 ** -draw.integers(0, 15)) if draw.random() < 0.5 else 1.0
        self.shift = float(draw.choice([0, 0, 0, 1e3, 1e6]))
        truth = truth_of(self.text)
        places = truth.extrema(k, [*start[:3], *unit(start[3:])], end)
        inner = places[1:-1]
        self.level = self.shift
        if inner and draw.random() < 0.75:
            plain = inner[draw.integers(len(inner))][1]
            apart = 10.0 ** -draw.uniform(3, 17)
            if kind in ("wobble", "pendulum") and draw.random() < 0.7:
                apart *= max(abs(float(value - plain)) for _, value, _ in places)
            self.level = float(plain + self.shift) - float(draw.choice([-1, 1])) * apart
        text = f"{Fraction(self.scale)}*(({self.text}) + {Fraction(self.shift)}"
        self.zero = text + f" - ({Fraction(self.level)}))"
        self.given = {"moments": k[:3], "centre": k[3:], "weight": 1, "at": [end]}
        self.given |= {"omega": start[:3], "gamma": start[3:]}
        bare = polhode.integrate(polhode.top(**self.given), number, method="taylor")
        last = [float(x) for x in places[-1][2]]
        off = max(abs(float(x) - y) for x, y in zip(bare.states[-1], last, strict=True))
        self.windows = windows(truth, places, k, self._watched, off + 2 * U[number], U[number])

    def _watched(self, plain):
        return ((plain + self.shift) - self.level) * self.scale

    def run(self, *directions: str) -> polhode.Trajectory:
        events = [polhode.Event(direction, self.zero, direction) for direction in directions]
        scene = polhode.top(**self.given, events=events)
        return polhode.integrate(scene, self.number, method="taylor")


def judged(case: Case, events: list[tuple[float, int]]) -> Counter[str]:
    """What is wrong with events, times and signs along the run, window by window."""
    counts: Counter[str] = Counter()
    for begin, end, before, after, unsure in case.windows:
        inside = [sign for time, sign in events if begin < time <= end]
        crossings = [sign for sign in inside if sign]
        counts["windows"] += not unsure
        counts["open"] += bool(unsure)
        net, crossings_expected = sum(crossings), (after - before) // 2
        if unsure:
            counts["wrong sum"] += net != crossings_expected
            continue
        counts["contacts"] += len(inside) - len(crossings)
        counts["missed"] += len(crossings) < abs(crossings_expected)
        counts["extra"] += len(crossings) > abs(crossings_expected)
        counts["wrong direction"] += net != crossings_expected
    return counts


def checked(case: Case) -> Counter[str]:
    """The same of all that a run tells: events by direction."""
    every, rising, falling = case.run("any", "rising", "falling").events
    signed_times = [
        (abs(float(t)), s * case.way) for t, s in zip(every.times, every.signs, strict=True)
    ]
    counts = judged(case, signed_times)
    counts["incomplete"] += not every.complete
    for event, sign in ((rising, 1), (falling, -1)):
        parts = [t for t, s in zip(every.times, every.signs, strict=True) if s in (0, sign)]
        counts["parted"] += list(event.times) != parts
    return counts


def assert_right(cases: list[Case], windows: int) -> None:
    counts = sum(map(checked, cases), Counter())
    assert {name for name, n in counts.items() if n} <= {"windows", "open"}, counts
    assert counts["windows"] >= windows
    assert counts["open"] <= counts["windows"] / 2


@pytest.mark.parametrize("seed", tiers([4, 5], [10]))
def test_crossings_of_a_random_expression(seed):
    assert_right([Case(seed, "double", ("q - gamma2",))], 1)


@pytest.mark.slow
def test_crossings_of_random_expressions():
    assert_right([Case(100 + k, "double") for k in range(8)], 15)


def crossings_of_very_many_expressions(part):
    assert_right([Case(1000 + 100 * part + k, "double") for k in range(100)], 350)


@pytest.mark.parametrize("text", ["p*q*r", "gamma1 + t/10", "p/(2 + gamma3)"])
def test_rounding_errors_are_those_of_an_evaluation_written_down_here(text):
    """A second pass over the rates makes some larger; signs of what is added up make none less."""
    keys = {"moments": [1, "1.5", 2], "centre": ["0.3", "-0.4", "0.5"], "weight": 1}
    body = polhode.top(**keys, omega=[1, 0, 0], gamma=[0, 0, 1], at=[1]).body
    coefficients = {name: float(x) for name, x in principal.coefficients(body).items()}
    formulas = Watched((*coefficients,), NAMES, text).formulas
    band, constant = Fraction(16) * DOUBLE.eps, typed_constant(DOUBLE)
    jet = jet_of(formulas, hy.make_vars(*NAMES), DOUBLE, band, constant)
    states, times = np.random.default_rng(7).normal(size=(6, 40)), np.linspace(-2, 2, 40)
    parameters = np.array([0, 0, 1, 1, *coefficients.values()])
    errors = jet.noise(marks_at(times, states, parameters))
    k = [1, 1.5, 2, 0.3, -0.4, 0.5]
    for error, row, t in zip(errors, states.T, times, strict=True):
        leaves = [
            Sized(x, abs(x) + rate.error / 2)
            for x, rate in zip(row, rates([Sized(x, abs(x)) for x in row], k), strict=True)
        ]
        assert 0.9 < error / value(text, leaves, Sized(t, abs(t))).error < 4
