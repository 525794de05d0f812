"""What a page says of a motion: every regime has its words, and what they claim is so."""

from __future__ import annotations

import numpy as np
import pytest

import polhode
from polhode.figures.explanations import EXPLANATIONS, explained
from polhode.judging.references.reference import reference
from polhode.scenes import library


def said(name):
    scene = polhode.load(name)
    known = reference(scene)
    return explained(known.kind, known.regime, scene)


def test_every_case_of_the_library_has_words_of_its_own_kind_and_all_words_are_used():
    used = set()
    for name in library.names():
        text = said(name)
        assert not text.startswith("A motion with a closed form"), name
        assert 30 < len(text) < 310
        used.add(text)
    for body, omega in (([1, 1, 2], [1, 0, 0]), ([1, 1, 2], [0, 0, 1])):
        scene = polhode.top(moments=body, weight=0, omega=omega, gamma=[0, 0, 1], end=1)
        used.add(explained("euler", reference(scene).regime, scene))
    unused = {(kind, begins) for kind, begins, text in EXPLANATIONS if text not in used}
    no_case = {("lagrange", "spherical pendulum, conical"), ("staude", "")}
    assert unused == no_case


def test_a_free_body_next_to_its_middle_axis_is_a_tennis_racket():
    assert "tennis racket" in said("euler/dzhanibekov")
    assert "tennis racket" not in said("euler/largest-axis")
    text = polhode.view("euler/dzhanibekov", end=30).text
    assert "axis of the middle moment" in text  # whose path is drawn


def test_a_weight_that_pulls_upward_turns_high_and_low():
    body = {"moments": [2, 2, 1], "centre": [0, 0, 1], "weight": -1}
    hanging = polhode.top(**body, omega=[0, 0, 1], gamma=[0, 0, 1], end=1)
    assert reference(hanging).regime == "hanging"
    assert "opposite to the centre of mass" in explained("lagrange", "hanging", hanging)


def test_nothing_is_said_of_a_stability_that_is_not_decided():
    body = {"moments": [2, "5/2", 3], "centre": [0, 0, 1], "weight": "1/2"}
    top = polhode.top(**body, omega=[0, 0, 1], gamma=[0, 0, 1], end=1)
    assert reference(top).regime == "permanent rotation, stability undecided"
    assert "push" not in explained("staude", reference(top).regime, top)


def test_a_closed_form_that_somebody_adds_is_called_by_its_name():
    scene = polhode.load("lagrange/looping")
    assert explained("mine", "slow", scene) == "A motion with a closed form (mine): slow."


def angles(name, end):
    """theta, and psi' from the closed form, at even times."""
    times = [end * k / 400 for k in range(401)]
    rows = polhode.reference(name).angles(times, 15)
    psi, theta, _ = np.array([[float(x) for x in row] for row in rows]).T
    return theta, np.gradient(psi, times[1])


@pytest.mark.parametrize(
    ("name", "words", "same_way"),
    [
        ("lagrange/looping", "makes loops", False),
        ("lagrange/nutation", "never changes its sense", True),
        ("lagrange/spherical-pendulum", "always in the same sense", True),
    ],
)
def test_precession_goes_the_way_that_is_said(name, words, same_way):
    assert words in said(name)
    theta, rate = angles(name, 10)
    highest, lowest = np.argmin(theta[5:-5]) + 5, np.argmax(theta[5:-5]) + 5
    assert (rate[highest] * rate[lowest] > 0) == same_way
    assert (np.min(rate) * np.max(rate) > 0) == same_way
    assert theta[lowest] - theta[highest] > 0.1


def test_a_cusp_is_a_standstill_at_the_highest_point():
    assert "stands still for a moment" in said("lagrange/cusped")
    theta, rate = angles("lagrange/cusped", 10)
    highest = np.argmin(theta[5:-5]) + 5
    assert abs(rate[highest]) < 0.02 * np.max(np.abs(rate))


@pytest.mark.parametrize("name", ["lagrange/steady-slow", "lagrange/steady-fast"])
def test_steady_precession_has_no_nutation(name):
    assert "without nutation" in said(name)
    theta, rate = angles(name, 10)
    assert np.ptp(theta) < 1e-12
    assert np.ptp(rate) < 1e-9 * abs(rate[0])


def test_grioli_turns_as_fast_about_its_axis_as_that_goes_round():
    assert "same constant rate" in said("grioli/precession")
    period = float(polhode.reference("grioli/precession").period)
    attitude = polhode.reference("grioli/precession").attitude([0, period], 15)
    first, back = np.array([[float(x) for x in row] for row in attitude])
    assert abs(abs(first @ back) - 1) < 1e-12  # so the body is back when omega is


def test_hess_keeps_the_momentum_across_the_centre():
    assert "stays perpendicular" in said("hess/general")
    scene = polhode.load("hess/general")
    inertia = np.array([[float(x) for x in row] for row in scene.body.inertia])
    centre = np.array([float(x) for x in scene.body.centre])
    rows = np.array([[float(x) for x in row] for row in polhode.reference(scene).at([0, 1, 5], 15)])
    assert np.max(np.abs(rows[:, :3] @ inertia @ centre)) < 1e-14


def test_a_closed_form_is_not_denied_where_a_scene_asks_for_an_enclosure():
    from dataclasses import replace

    scene = replace(polhode.load("lagrange/looping"), reference="certified")
    text = polhode.view(scene, end=4).text
    assert "makes loops" in text
    assert "No closed form" not in text
