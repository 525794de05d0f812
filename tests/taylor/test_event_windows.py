"""Random motions, expressions and levels: every crossing once, and nothing where there is none.

Between neighbouring extrema an expression crosses zero once or not at all: what those are is told
by heyoka in quad along other equations (tests/shared/event_windows.py).
"""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from functools import cache

import mpmath
import numpy as np
import pytest

import polhode
from polhode import Outcome
from shared.event_windows import NAMES, TEXTS, Sized, Truth, Window, rates, value, windows
from shared.tools import DOUBLE, tiers

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

    def run(self, *directions: tuple[str, bool]) -> polhode.Trajectory:
        events = [
            polhode.Event(direction, self.zero, direction, stop) for direction, stop in directions
        ]
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
        counts["wrong direction"] += (
            len(crossings) == abs(crossings_expected) and net != crossings_expected
        )
    return counts


def checked(case: Case) -> Counter[str]:
    """The same of all that a run tells: events by direction, and where it stops."""
    run = case.run(("any", False), ("rising", False), ("falling", False))
    every, rising, falling = run.events
    signed_times = [
        (abs(float(t)), s * case.way) for t, s in zip(every.times, every.signs, strict=True)
    ]
    counts = judged(case, signed_times)
    counts["incomplete"] += not every.complete
    for event, sign in ((rising, 1), (falling, -1)):
        parts = [t for t, s in zip(every.times, every.signs, strict=True) if s in (0, sign)]
        counts["parted"] += list(event.times) != parts
    stops: list[Window] = []
    for window in case.windows:
        if window.unsure:
            break
        if window.before > window.after:
            stops.append(window)
            break
    else:
        window = None
    if window is None or stops:
        sign = "falling" if case.way > 0 else "rising"
        stopped = case.run((sign, True))
        reached = abs(float(stopped.reached))
        right = stopped.outcome is Outcome.REACHED_END
        if stops:
            right = stopped.outcome is Outcome.STOPPED_AT_EVENT
            right = right and stops[0].begin < reached <= stops[0].end
        counts["stops"] += 1
        counts["wrong stops"] += not right and bool(case.windows) and case.windows[0].begin == 0
    return counts


def total(cases: list[Case]) -> Counter[str]:
    counts: Counter[str] = Counter()
    for case in cases:
        counts += checked(case)
    return counts


def assert_right(counts: Counter[str], windows: int) -> None:
    right = {"windows", "open", "stops"}
    assert {name: n for name, n in counts.items() if n and name not in right} == {}
    assert counts["windows"] >= windows
    assert counts["open"] <= counts["windows"] / 2


@pytest.mark.parametrize("seed", tiers([4, 5], [10]))
def test_crossings_of_a_random_expression(seed):
    assert_right(total([Case(seed, "double", ("q - gamma2",))]), 1)


@pytest.mark.slow
@pytest.mark.parametrize(("number", "count", "windows"), [("double", 8, 15)])
def test_crossings_of_random_expressions(number, count, windows):
    assert_right(total([Case(100 + k, number) for k in range(count)]), windows)


def crossings_of_very_many_expressions(part):
    assert_right(total([Case(1000 + 100 * part + k, "double") for k in range(100)]), 350)


@pytest.mark.parametrize("text", ["p*q*r", "gamma1 + t/10", "p/(2 + gamma3)"])
def test_rounding_errors_are_those_of_an_evaluation_written_down_here(text):
    """A second pass over the rates makes some larger; signs of what is added up make none less."""
    import heyoka as hy

    from polhode.equations.forms import principal
    from polhode.taylor.event_batches import Watched
    from polhode.taylor.event_functions import jet_of, marks_at, typed_constant

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
