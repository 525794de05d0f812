"""What a page says of a motion: every regime has its words, and what they claim is so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import polhode
from polhode.figures.motion_page import EXPLANATIONS, explained
from polhode.judging.reference import reference
from shared.tools import case_names


def said(name, kind=None):
    scene = polhode.load(name) if isinstance(name, str) else name
    top = reference(scene)
    return explained(kind or top.kind, top.regime, scene)


@pytest.mark.slow
def test_every_case_of_the_library_has_words_of_its_own_kind_and_all_words_are_used():
    used = set()
    for name in case_names():
        text = said(name)
        assert not text.startswith("A motion with a closed form"), name
        used.add(text)
    for body, omega in (([1, 1, 2], [1, 0, 0]), ([1, 1, 2], [0, 0, 1])):
        free = polhode.top(moments=body, weight=0, omega=omega, gamma=[0, 0, 1], end=1)
        used.add(said(free, "euler"))
    unused = {(kind, begins) for kind, begins, text in EXPLANATIONS if text not in used}
    assert unused == {("lagrange", "spherical pendulum, conical"), ("staude", "")}


def upward(**changes):
    """A top whose weight pulls upward, or another one."""
    options = {"moments": [2, 2, 1], "centre": [0, 0, 1], "weight": -1, "omega": [0, 0, 1]}
    return polhode.top(**options | changes, gamma=[0, 0, 1], end=1)


@pytest.mark.parametrize(
    ("scene", "kind", "words", "absent"),
    [
        ("euler/dzhanibekov", None, "tennis racket", "\n"),
        ("euler/largest-axis", None, "", "tennis racket"),
        ("grioli/precession", None, "same constant rate", "\n"),
        ("hess/general", None, "stays perpendicular", "\n"),
        (upward(), "lagrange", "opposite to the centre of mass", "\n"),
        (upward(moments=[2, "5/2", 3], weight="1/2"), "staude", "", "push"),  # undecided
        ("lagrange/looping", "mine", "a closed form (mine): looping", "loops"),  # added by a user
    ],
)
def test_words_fit_the_scene(scene, kind, words, absent):
    text = said(scene, kind)
    assert words in text
    assert absent not in text


def angles(name, end):
    """theta, and psi' from the closed form, at even times."""
    times = [end * k / 100 for k in range(101)]
    rows = polhode.reference(name).angles(times, 15)
    psi, theta, _ = np.array([[float(x) for x in row] for row in rows]).T
    return theta, np.gradient(psi, times[1])


@pytest.mark.parametrize(
    ("name", "words", "rates"),
    [
        ("lagrange/looping", "makes loops", (-1, -1)),
        ("lagrange/nutation", "never changes its sense", (1, 1)),
        ("lagrange/spherical-pendulum", "always in the same sense", (1, 1)),
        ("lagrange/cusped", "stands still for a moment", (0, None)),
        ("lagrange/steady-slow", "without nutation", (None, 1)),
        ("lagrange/steady-fast", "without nutation", (None, 1)),
    ],
)
def test_precession_goes_the_way_that_is_said(name, words, rates):
    """The signs of psi' at the highest point by that at the lowest, and of its bounds."""
    assert words in said(name)
    theta, rate = angles(name, 10)
    highest, lowest = (int(of(theta[5:-5])) + 5 for of in (np.argmin, np.argmax))
    at_ends, bounds = rates
    if at_ends is None:
        assert np.ptp(theta) < 1e-12
        assert np.ptp(rate) < 1e-9 * abs(rate[0])
        return
    assert theta[lowest] - theta[highest] > 0.1
    if at_ends == 0:
        assert abs(rate[highest]) < 0.05 * np.max(np.abs(rate))
        return
    assert np.sign(rate[highest] * rate[lowest]) == at_ends
    assert np.sign(np.min(rate) * np.max(rate)) == bounds


def test_a_page_says_it_and_does_not_deny_a_closed_form_where_an_enclosure_is_asked_for():
    assert "axis of the middle moment" in polhode.view("euler/dzhanibekov", end=30).text
    text = polhode.view(
        replace(polhode.load("lagrange/looping"), reference="certified"), end=4
    ).text
    assert "makes loops" in text
    assert "No closed form" not in text
