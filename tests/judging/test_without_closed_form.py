"""Every case without a closed form against an integrator that shares nothing with polhode."""

from __future__ import annotations

import ast
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

import polhode
from polhode.enclosures.certify import certify
from polhode.judging.adaptive_precision import integrate
from polhode.numbers.conversion import exactly, to_mpf
from polhode.scenes import catalogue, library
from shared import plain_taylor

DIGITS = 40
BITS = 240  # of the scene's numbers where they are irrational
ANGLE = 16  # how far each motion is followed, in radians
#: What each case is judged against stands in the catalogue, which ``verbs/test_list.py`` holds to.
CASES = [name for name, case in catalogue.known().items() if case.reference == "certified"]
QUICK = ("general/asymmetric-chaotic",)


def followed(name: str):
    """A case at two times within the angle, and its motion by the plain series, twice."""
    scene = replace(library.load(name), outputs=(), events=(), published=())
    end = scene.end * min(Fraction(1), Fraction(round(ANGLE * 100 / 10**scene.log10_angle), 100))
    times = (end / 3, end)
    scene = replace(scene, times=times)
    parts = (scene.body.moments, scene.body.torque, scene.omega, scene.gamma)
    numbers = [[exactly(to_mpf(x, BITS)) for x in part] for part in parts]
    rows = plain_taylor.integrate(*numbers, times, DIGITS)
    finer = plain_taylor.integrate(*numbers, times, DIGITS + 10)
    assert off(rows, finer) < Fraction(1, 10 ** (DIGITS - 4))
    return scene, finer


def off(rows, true) -> Fraction:
    return max(
        abs(exactly(x) - y)
        for row, wanted in zip(rows, true, strict=True)
        for x, y in zip(row, wanted, strict=True)
    )


def check(name: str) -> None:
    """The enclosure holds the motion, and runs in quad are right as far as quad goes."""
    scene, true = followed(name)
    found = certify(scene, scene.times, digits=20)
    for row, middles, radii in zip(true, found.centres, found.radii, strict=True):
        for x, middle, radius in zip(row, middles, radii, strict=True):
            assert abs(x - middle) <= Fraction(radius)
    for method, least in (("refined", 31.0), ("taylor", 29.0)):
        run = integrate(scene, "quad", method=method)
        assert Fraction(1, 10**37) < off(run.states, true) < Fraction(10) ** -int(least)


@pytest.mark.slow
@pytest.mark.parametrize("name", QUICK)
def test_motions_without_a_closed_form_are_those_of_the_plain_series(name):
    assert name in CASES
    check(name)


@pytest.mark.slow
@pytest.mark.sample(5, rest="campaign")
@pytest.mark.parametrize("name", [name for name in CASES if name not in QUICK])
def test_every_other_motion_without_a_closed_form(name):
    check(name)


def test_the_plain_series_imports_nothing_of_polhode_and_is_short():
    text = Path(plain_taylor.__file__).read_text()
    assert len(text.splitlines()) < 100
    names = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module)
    assert names == {"__future__", "collections.abc", "fractions", "functools", "typing", "mpmath"}


def test_the_plain_series_is_exact_on_a_motion_that_is_known():
    """A symmetric free body: p + iq turns with (C - A)/A r."""
    import mpmath

    t = Fraction(7)
    row = plain_taylor.integrate(
        *((Fraction(2), Fraction(2), Fraction(1)), (Fraction(0),) * 3),
        *((Fraction(1), Fraction(0), Fraction(3)), (Fraction(0), Fraction(0), Fraction(1))),
        *((t,), DIGITS),
    )[0]
    with mpmath.workdps(60):
        angle = mpmath.mpf(-3) / 2 * 7
        wanted = (mpmath.cos(angle), mpmath.sin(angle), 3)
        for x, y in zip(row[:3], wanted, strict=True):
            assert abs(mpmath.mpf(x.numerator) / x.denominator - y) < mpmath.mpf(10) ** -DIGITS


def test_a_forecast_of_a_proof_that_a_look_at_the_times_asks_for():
    """It asked for the unit of a judgement that was not made yet."""
    scene = "general/asymmetric-regular"
    run = polhode.integrate(scene, at=[0, 1, 2, 5])
    rows = [[float(x) for x in row] for row in run.states]
    told = []
    found = polhode.compare(
        rows,
        polhode.load(scene),
        at=[1234, 1235, 1236, 1239],
        forecast=lambda *what: told.append(what),
    )
    assert found.worst > 14.5
    assert "from its first row on" in str(found)
    assert told
    assert all(seconds < 60 for seconds, _ in told)
