"""Closed forms between Chebyshev's points: as right as asked, and asked at few points."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.judging import many_rows, panels
from polhode.judging.reference import rows
from polhode.numbers.number_types import DOUBLE

COLUMNS = ("p", "q", "r", "gamma1", "gamma2", "gamma3", "q0", "q1", "q2", "q3")
BOTH = ("at", "attitude")

PERIODIC = [
    "bobylev-steklov/cn",
    "goryachev-chaplygin/rotating",
    "chaplygin/motion",
    "steklov/lower",
]
OTHERS = ["staude/unstable", "bobylev-steklov/asymptotic", "hess/loxodrome", "grioli/irrational"]


def between(name: str, first: Fraction, last: Fraction, count: int, asked=BOTH, digits=19):
    """A reference, times, what panels tell, and how often they asked."""
    reference = polhode.reference(name)
    times = [first + (last - first) * k / (count - 1) for k in range(count)]
    counted = [0]
    with pytest.MonkeyPatch.context() as patch:
        plain = panels.asked_by

        def counting(known, question, workers, tell):
            ask = plain(known, question, workers, tell)

            def asking(some, digits):
                counted[0] += len(some)
                return ask(some, digits)

            return asking

        patch.setattr(panels, "asked_by", counting)
        found = panels.in_panels(reference, times, digits, asked, 1)
    return reference, times, found, counted[0] / len(asked)


def worst(reference, times, found, digits: int) -> float:
    """The largest error of w over its largest value and of the rest, at some of the times."""
    some = [0, len(times) - 1, *np.random.default_rng(3).integers(0, len(times), 12)]
    errors = []
    for question, columns in zip(BOTH, found, strict=True):
        if columns is None:
            continue
        true = rows(getattr(reference, question), [times[k] for k in some], digits + 6)
        speed = max(abs(float(x)) for row in true for x in row[:3]) or 1.0
        scales = [speed] * 3 + [1.0] * 3 if question == "at" else [1.0] * 4
        for k, row in zip(some, true, strict=True):
            errors += [
                abs(float((x[k] - y).hi)) / s for x, y, s in zip(columns, row, scales, strict=True)
            ]
    return max(errors)


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", PERIODIC)
def test_panels_of_one_period_tell_all_the_others(name):
    end = 40 * Fraction(float(polhode.reference(name).period))
    reference, times, found, asked = between(name, -end / 3, end, 2500)
    assert worst(reference, times, found, 19) < 1e-19
    assert asked <= 800, "one period was asked for, not forty"


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", OTHERS)
def test_panels_without_a_period(name):
    reference, times, found, asked = between(name, Fraction(-3), Fraction(9), 3000)
    assert worst(reference, times, found, 19) < 1e-19
    assert asked * panels._PAYS <= len(times)


@pytest.mark.slow
def test_more_digits_take_shorter_panels():
    """A table of 17 digits and two more asks for 22."""
    few = between("steklov/lower", Fraction(0), Fraction(50), 4000, digits=12)
    many = between("steklov/lower", Fraction(0), Fraction(50), 4000, digits=22)
    assert worst(*many[:3], 22) < 1e-22
    assert worst(*few[:3], 22) < 1e-12
    assert many[3] > few[3]


def test_one_question_alone():
    for name in BOTH:
        reference, times, found, _ = between("steklov/lower", 0, Fraction(60), 2000, asked=(name,))
        assert [part is not None for part in found] == [name == question for question in BOTH]
        assert worst(reference, times, found, 19) < 1e-19


def test_few_rows_are_asked_for_one_by_one():
    _, _, found, asked = between("steklov/lower", Fraction(0), Fraction(900), 130)
    assert found is None
    assert asked == 0


@pytest.mark.sample(1)
@pytest.mark.parametrize("off", [Fraction(999, 1000), Fraction(1, 2)])
def test_what_is_no_period_is_not_taken_for_one(off, monkeypatch):
    """Half a period brings p and gamma back up to their signs."""
    true = polhode.reference("steklov/lower").period
    monkeypatch.setattr(
        type(polhode.reference("steklov/lower")),
        "period",
        property(lambda self: true * off.numerator / off.denominator),
    )
    reference, times, found, asked = between("steklov/lower", Fraction(0), Fraction(20), 3000)
    assert worst(reference, times, found, 19) < 1e-19
    assert asked > 300, "all the time was asked for"


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("name", "error"),
    [("grioli/precession", 1e-13), ("chaplygin/motion", 0.0), ("hess/general", 0.0)],
)
def test_the_same_digits_as_one_by_one(name, error, monkeypatch):
    scene = polhode.load(name).at([Fraction(k, 200) for k in range(600)])
    _, _, told, _ = between(name, Fraction(0), scene.times[-1], 600)
    table = np.array([x.hi for part in told for x in part])
    table = (table + np.random.default_rng(7).uniform(-error, error, table.shape)).T

    def judged():
        return polhode.compare(table, scene, at=scene.times, columns=COLUMNS, number=DOUBLE)

    quick = judged()
    assert quick._held.many is not None
    assert quick.worst > 15 if error == 0 else 12.5 < quick.worst < 14
    monkeypatch.setattr(many_rows, "FEWEST", 10**9)
    slow = judged()
    assert slow._held.many is None
    assert np.allclose(quick.digits, slow.digits, rtol=0, atol=0.005)
    assert abs(quick.parts["attitude"] - slow.parts["attitude"]) < 0.005
