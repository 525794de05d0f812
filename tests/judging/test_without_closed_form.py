"""Every case without a closed form against an integrator that shares nothing with polhode."""

from __future__ import annotations

import ast
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import mpmath
import pytest

import polhode
from polhode.numbers.conversion import exactly, to_mpf
from polhode.scenes import library
from shared import plain_taylor

DIGITS = 40
BITS = 240  # of the scene's numbers where they are irrational
ANGLE = 16  # how far each motion is followed, in radians
#: What each case is judged against stands in the catalogue, which ``verbs/test_list.py`` holds to.
CASES = [name for name, case in library.entries().items() if case.reference == "certified"]


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


@pytest.mark.sample(0, slow=1)
@pytest.mark.parametrize("name", CASES)
def test_a_motion_without_a_closed_form_is_that_of_the_plain_series(name: str) -> None:
    """The enclosure holds the motion, and runs in quad are right as far as quad goes."""
    scene, true = followed(name)
    found = polhode.certify(scene, at=scene.times, digits=20)
    for row, middles, radii in zip(true, found.centres, found.radii, strict=True):
        for x, middle, radius in zip(row, middles, radii, strict=True):
            assert abs(x - middle) <= Fraction(radius)
    for method, least in (("refined", 31), ("taylor", 29)):
        run = polhode.integrate(scene, "quad", method=method)
        assert Fraction(1, 10**37) < off(run.states, true) < Fraction(1, 10**least)


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
    body, start = ([2, 2, 1], [0, 0, 0]), ([1, 0, 3], [0, 0, 1])
    given = [[Fraction(x) for x in part] for part in (*body, *start)]
    (row,) = plain_taylor.integrate(*given, [Fraction(7)], DIGITS)
    with mpmath.workdps(60):
        angle = mpmath.mpf(-3) / 2 * 7
        for x, y in zip(row[:3], (mpmath.cos(angle), mpmath.sin(angle), 3), strict=True):
            assert abs(mpmath.mpf(x.numerator) / x.denominator - y) < mpmath.mpf(10) ** -DIGITS
