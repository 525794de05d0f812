"""The table of faults: what once was wrong, silent, dead or slow, a row each, by users' doors.

Rooms test the kinds of these faults with many values; here is what was reported.
"""

from __future__ import annotations

import math
import time
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.cli import main

NUMBERS = ("double", "extended", "quad", "mp")
SECONDS = 2.0  # of processor time, for a refusal that once took minutes


def top_of(zero: str, end: float, **more: object) -> polhode.Scene:
    """A pendulum of period 6.743..., or what is given, with one event."""
    given = {"moments": [1, 1, 1], "centre": [0, 0, 1], "weight": -1, "gamma": [0, 0, 1]}
    event = polhode.Event("zero", zero, stop=bool(more.pop("stop", False)))
    return polhode.top(**(given | more), end=end, events=[event])


# -- events ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", NUMBERS[:3])
@pytest.mark.parametrize("amplitude", ["1e-6", "1e-8", "1e-10", "1e-13"])
def test_a_small_pendulum_has_six_zeros(amplitude, number):
    run = polhode.integrate(top_of("gamma2", 20, omega=[amplitude, 0, 0]), number)
    (zeros,) = run.events
    first = zeros.signs[0]
    assert zeros.signs == (first, -first) * 3
    assert not any(zeros.grazing)
    assert zeros.complete


def test_a_small_pendulum_stops():
    run = polhode.integrate(top_of("gamma2", 20, omega=["1e-8", 0, 0], stop=True))
    assert float(run.reached) == pytest.approx(math.pi, abs=1e-6)


@pytest.mark.parametrize("apart", ["1e-4", "1e-9", "1e-13"])
def test_a_level_next_to_a_maximum(apart):
    """p is 1 at the start, its largest value, and again after a period."""
    below = polhode.integrate(top_of(f"p - 1 + {apart}", 10, omega=[1, 0, 0])).events[0]
    above = polhode.integrate(top_of(f"p - 1 - {apart}", 10, omega=[1, 0, 0])).events[0]
    assert below.signs == (-1, 1, -1)
    assert above.signs == ()


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize(
    ("zero", "end", "times"),
    [
        ("q*(p-0.28)", 2, [0.36744943]),
        ("q**3*(p-0.28)", 2, [0.36744943]),
        ("t*(t-1/10)", 2, [0.1]),
        ("t**4*(t-1/7)", 2, [1 / 7]),
        ("q*cos(6*t)", 2, [math.pi / 12 * k for k in (1, 3, 5, 7)]),
    ],
)
def test_what_is_zero_at_the_start_keeps_its_next_zeros(zero, end, times, number):
    free = {"moments": [1, 2, 3], "omega": ["0.3", 0, 1], "weight": 0}
    (event,) = polhode.integrate(top_of(zero, end, **free), number).events
    assert [float(t) for t in event.times] == pytest.approx(times, abs=1e-7)
    assert event.complete


# -- numbers and texts that people give ------------------------------------------------------------


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: polhode.top(moments=[1, 1, 1], omega=[0, 0, Decimal("1e999999")]), "exponent"),
        (lambda: polhode.integrate("euler/sphere", at=[Decimal("1e999999")]), "exponent"),
        (lambda: polhode.top(moments=[1, 1, 1], omega=[0, 0, Decimal("1e5000")]), "exponent"),
        (lambda: polhode.load_run(1.5), "path"),
        (lambda: polhode.load("x" * 5000), "name of a case"),
        (lambda: polhode.integrate("euler/sphere", rtol=1e-9), "tol"),
        (lambda: polhode.compare("x.csv", "euler/sphere", at_least=9), "assert_digits"),
        (
            lambda: polhode.top(
                moments=[1, 1, 1], omega=[0, 0, 1], events=[polhode.Event("a\nb", "p")]
            ),
            "one line",
        ),
        (lambda: polhode.top(moments=[1, 2, 3, 1, 2, 3], omega=[0, 0, 1]), "3 numbers"),
        (lambda: polhode.top(inertia=[[2, 0, 0], [1, 2, 0], [0, 0, 2]]), "symmetric"),
    ],
)
def test_it_is_refused_in_one_line_at_once(call, words):
    begin = time.process_time()
    with pytest.raises(polhode.BadInput, match=words) as refusal:
        call()
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 1000
    assert time.process_time() - begin < SECONDS


def test_what_numpy_rounds_is_taken():
    draw = np.random.default_rng(7)
    for _ in range(20):
        turn = np.linalg.qr(draw.normal(size=(3, 3)))[0]
        body = polhode.top(inertia=turn @ np.diag([1, 2, 2.5]) @ turn.T, omega=[0, 0, 1]).body
        assert max(map(float, body.moments)) == pytest.approx(2.5, rel=1e-14)
    plate = polhode.top(moments=[0.1, 0.2, 0.1 + 0.2], omega=[0, 0, 1])
    a, b, c = plate.body.moments
    assert a + b == c
    assert plate.notes


@pytest.mark.parametrize(
    ("typed", "exact"),
    [("25°", "5*pi/36"), ("30 deg", "pi/6"), ("90 degrees", "pi/2")],
)
def test_angles_as_they_are_typed(typed, exact):
    given = {"moments": [1, 1, 1], "rates": [0, 0, 1]}
    one = polhode.top(**given, angles=[0, typed, 0])
    two = polhode.top(**given, angles=[0, exact, 0])
    assert [float(x) for x in one.gamma] == [float(x) for x in two.gamma]


# -- verdicts --------------------------------------------------------------------------------------


def table(offset: float = 0.0) -> dict[str, np.ndarray]:
    """A right run, with the times of another clock."""
    scene = polhode.load("lagrange/nutation").at([Fraction(k, 7) for k in range(21)])
    run = polhode.integrate(scene)
    columns = dict(zip(("p", "q", "r", "gamma1", "gamma2", "gamma3"), run.states.T, strict=True))
    return {"t": np.array([float(t) for t in run.times]) + offset, **columns}


def test_times_of_a_clock_carry_their_rounding_into_the_verdict():
    verdict = str(polhode.compare(table(1e6), "lagrange/nutation"))
    assert "rounding (of the times" in verdict
    assert "read as t from its first row on (1e+06)" in verdict


@pytest.mark.parametrize("form", ["%.18e", "%.17e", "%.20g", "%.25g"])
def test_a_table_by_savetxt_is_one_of_doubles(tmp_path, form):
    columns = table()
    file = tmp_path / "table.csv"
    rows = np.column_stack([*columns.values()])
    np.savetxt(file, rows, fmt=form, delimiter=",", header=",".join(columns), comments="")
    verdict = polhode.compare(file, "lagrange/nutation")
    assert verdict.worst > 14
    assert "expected in double" in str(verdict)


def test_a_drifting_program_in_degrees_is_told_so():
    columns = table()
    drift = 1 + columns["t"] / 100
    for name in "pqr":
        columns[name] = np.degrees(columns[name]) * drift
    verdict = str(polhode.compare(columns, "lagrange/nutation"))
    assert "degrees" in verdict
    assert "exact at t = 0" in verdict


# -- the period of omega, and messages of the command line -----------------------------------------


def test_a_period_is_that_of_omega():
    assert polhode.reference("lagrange/nutation").period is None
    exact = polhode.reference("lagrange/planar-librating")
    start, half, whole = exact.at([0, exact.period / 2, exact.period], 20)
    assert max(abs(float(x - y)) for x, y in zip(start[:3], whole[:3], strict=True)) < 1e-15
    assert max(abs(float(x - y)) for x, y in zip(start[:3], half[:3], strict=True)) > 0.1


@pytest.mark.parametrize(
    ("words", "answer"),
    [
        (["new", "cone"], "polhode new cone.toml"),
        (["view", "euler/sphere", "-o", "x.gif"], "polhode plot euler/sphere --what motion"),
        (["compare", "mine.csv", "ref.csv"], "a table is judged by a motion"),
        (["study", "needs"], "accuracy"),
        (["run", "euler/spere"], "did you mean 'euler/sphere'"),
    ],
)
def test_a_message_names_what_is_meant(tmp_path, monkeypatch, capsys, words, answer):
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert answer in err
    assert [*tmp_path.iterdir()] == []
