"""Attitude and angles in extended by quadrature: a plain run's bits, accuracy, poles, endings."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.equations import attitude_phase, quaternion_products
from polhode.judging.adaptive_precision import integrate
from polhode.motion.outcomes import Outcome
from polhode.numbers import number_types
from polhode.numbers.conversion import exactly
from polhode.numbers.gauss_lobatto import enough
from polhode.numbers.number_types import EXTENDED
from polhode.runs._observers import attitude_quadrature, panel_splitting
from polhode.runs.plan import plans
from polhode.runs.problem.problem import problem
from shared.policies import change_policy

pytestmark = pytest.mark.skipif(
    not number_types.extended_here(), reason="no 80-bit long double here"
)

EPS = float(EXTENDED.eps)
BOTH = ("angles", "attitude")

TIMES = {
    "few": [1, 60],
    "uneven": [0, "0.1", "0.2", "0.2000001", 3, 50, "50.01", 70],
    "backward": [-1, -33, -65],
    "grid": [Fraction(k) for k in range(61)],
}


def planned(scene, number, **options):
    ready = problem(scene, number, **options)
    beside, way = plans(ready, scene, ready.schedule(scene))[:-1], attitude_quadrature.Quadrature
    return next((plan for plan in beside if isinstance(plan.way, way)), None)


def scene(name, at, outputs=BOTH):
    return replace(polhode.load(name), events=(), outputs=outputs).at(at)


def together(monkeypatch, what, *more, **options):
    """The same run with all of it integrated as one system; plans are kept with their scene."""
    with monkeypatch.context() as patch:
        patch.setattr(attitude_quadrature, "fits", lambda *_: False)
        return integrate(replace(what), *more, **options)


def worst(run, other, column):
    """The largest difference; psi and phi by their own size."""
    pairs = zip(getattr(run, column), getattr(other, column), strict=True)
    return max(
        abs(float(exactly(x) - exactly(y))) / max(1, abs(float(y)))
        for a, b in pairs
        for x, y in zip(a, b, strict=True)
    )


def settled(what):
    """The run, which was not left to one system: its states are those of a plain one."""
    observe, found = attitude_quadrature.Quadrature.observe, []

    def noted(*arguments):
        found.append(observe(*arguments))
        return found[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(attitude_quadrature.Quadrature, "observe", noted)
        run = integrate(what, "extended")
    assert len(found) == 1
    assert found[0] is not None
    assert np.array_equal(run.states, integrate(replace(what, outputs=()), "extended").states)
    return run


@pytest.mark.sample(3)
@pytest.mark.parametrize("times", TIMES)
@pytest.mark.parametrize("name", ["kovalevskaya/generic", "lagrange/turned-axes"])
def test_states_are_those_of_a_plain_run_to_the_bit(name, times):
    what = scene(name, TIMES[times])
    assert planned(what, EXTENDED) is not None
    along = integrate(what, "extended")
    alone = integrate(scene(name, TIMES[times], ()), "extended")
    assert np.array_equal(along.states, alone.states)
    assert (along.steps, along.reached, along.times) == (alone.steps, alone.reached, alone.times)
    assert along.projection == alone.projection
    middle = along.times[-1] * Fraction(2, 3)
    assert np.array_equal(along(middle), alone(middle))
    for wanted in BOTH:
        one = integrate(scene(name, TIMES[times], (wanted,)), "extended")
        assert {"angles": one.attitude, "attitude": one.angles}[wanted] is None
        assert len(getattr(one, wanted)) == len(alone.states)


@pytest.mark.sample(2, slow=4)
@pytest.mark.parametrize("times", TIMES)
@pytest.mark.parametrize("name", ["euler/largest-axis", "lagrange/turned-axes", "goryachev/motion"])
def test_attitude_and_angles_are_as_good_as_those_of_one_system(name, times, monkeypatch):
    """Against a run in quad; the attitude agrees with gamma."""
    what = scene(name, TIMES[times])
    fine = integrate(what, "quad")
    mine, theirs = settled(what), together(monkeypatch, what, "extended")
    assert not np.array_equal(mine.states, theirs.states)
    assert mine.attitude.dtype == np.longdouble
    assert {type(x) for row in mine.angles for x in row} == {np.longdouble}
    for column in ("attitude", "angles"):
        # errors of rounding: of two such runs one may well be a few times the other
        assert 0 < worst(mine, fine, column) < 4 * worst(theirs, fine, column) + 64 * EPS
    assert np.abs((mine.attitude**2).sum(axis=1) - 1).max() <= 8 * EPS
    vertical = np.array(quaternion_products.vertical(mine.attitude.T)).T
    assert np.abs(vertical - mine.states[:, 3:]).max() <= 256 * EPS


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("name", "end"),
    [
        ("hard/near-pole", 240),
        ("pendulum/rotating", 40),
        ("lagrange/looping", 40),
        ("general/asymmetric-chaotic", 40),
    ],
)
def test_turns_past_a_pole_are_those_of_one_system(name, end, monkeypatch):
    what = scene(name, [Fraction(k * end, 8) for k in range(9)])
    mine, theirs = settled(what), together(monkeypatch, what, "extended")
    for a, b in zip(mine.angles, theirs.angles, strict=True):
        for x, y in zip(a, b, strict=True):
            assert (x is None) is (y is None)
            assert x is None or abs(x - y) < 1e-9
    assert np.abs(mine.attitude - theirs.attitude).max() < 1e-12


def test_turns_of_a_path_that_passes_a_pole_on_another_side_than_its_chord(monkeypatch):
    """gamma circles near the third axis, by few nodes: the pole lies between arc and chord."""
    what = polhode.top(
        moments=["1", "1.05", "0.9"],
        omega=["0.5", "0", "0.9"],
        gamma=["0.8", "0.3", "0.6"],
        normalise=True,
        outputs=["angles"],
        at=[300, 600, 900, 1200],
    )
    mine, theirs = settled(what), together(monkeypatch, what, "extended")
    assert worst(mine, theirs, "angles") <= 256 * EPS
    monkeypatch.setattr(attitude_phase, "_doubtful", lambda omega, *_: np.zeros(omega.shape[1]))
    off = np.array(settled(what).angles[-1]) - np.array(mine.angles[-1])
    assert off[0] == pytest.approx(-off[2], abs=1e-9)
    assert abs(off[0]) > 6


def test_panels_with_too_few_nodes_are_split(monkeypatch):
    name = "euler/largest-axis"
    at = [Fraction(k) for k in range(0, 61, 20)]
    whole, fewer = settled(scene(name, at)), []
    split = panel_splitting.Halves._halves

    def noted(self, panels, rule, where):
        fewer.append(np.count_nonzero(where))
        return split(self, panels, rule, where)

    monkeypatch.setattr(panel_splitting.Halves, "_halves", noted)
    monkeypatch.setattr(attitude_quadrature, "enough", lambda *_: enough(*_) - 7)
    monkeypatch.setattr(attitude_quadrature, "STEPS", (8.0,))
    run = settled(scene(name, at))
    assert sum(fewer) > 5
    assert worst(run, whole, "attitude") <= 32 * EPS
    assert worst(run, whole, "angles") <= 32 * EPS


def test_what_is_integrated_as_one_system():
    def fits(what, number=EXTENDED, **options):
        return planned(what, number, **options) is not None

    name = "kovalevskaya/generic"
    assert fits(scene(name, [100]))
    assert not fits(scene(name, [1]))
    assert not fits(scene(name, [100], ()))
    assert not fits(scene(name, [100]), number_types.DOUBLE)
    assert not fits(scene(name, [100]), number_types.QUAD)
    assert not fits(scene(name, [100]), tolerance=Fraction(1, 10**9))
    assert not fits(scene(name, [100]), inputs=number_types.DOUBLE)
    assert not fits(replace(scene(name, [100]), events=(polhode.Event("equator"),)))
    assert not fits(scene("euler/attitude", [100], ("angles",)))
    assert fits(scene("euler/attitude", [100], ("attitude",)))
    close, closer = ([Fraction(100 * k, n) for k in range(n + 1)] for n in (500, 4000))
    assert fits(scene(name, close, ("angles",)))  # beside which one system is slower by more
    assert not fits(scene(name, close, ("attitude",)))
    assert not fits(scene(name, closer))


def test_what_cannot_be_settled_is_left_to_one_system(monkeypatch):
    what = scene("hard/near-pole", [5, 60])
    expected = together(monkeypatch, what, "extended")
    whole = integrate(what, "extended")
    assert whole.angles != expected.angles
    monkeypatch.setattr(panel_splitting, "_DEEPEST", 0)
    run = integrate(what, "extended")
    assert run.angles == expected.angles
    assert np.array_equal(run.attitude, expected.attitude)


def test_chunks_that_begin_between_representable_times_lose_no_digits(monkeypatch):
    """The nodes' times are rounded anew in each chunk: by that much their states are late.

    Both are 3e4 eps off, and differ by some tens: a hundredth of that would be a digit lost.
    """
    what = scene("euler/largest-axis", [3000])
    whole = integrate(what, "extended", project=False)
    change_policy(monkeypatch, chunk=1500)
    parts = integrate(what, "extended", project=False)
    assert worst(parts, whole, "attitude") <= 256 * EPS
    assert worst(parts, whole, "angles") <= 256 * EPS


def test_interrupted_it_holds_what_is_whole(monkeypatch):
    what = scene("lagrange/nutation", [Fraction(k) for k in range(0, 300, 10)])
    whole = integrate(what, "extended")
    monkeypatch.setattr(attitude_quadrature, "_TOGETHER", 64)
    what = scene("lagrange/nutation", [Fraction(k) for k in range(0, 300, 10)])
    settled, calls = panel_splitting.Halves.settled, []

    def pressed(self, panels, rule, depth=0):
        calls.append(depth)
        if calls.count(0) == 2:
            raise KeyboardInterrupt
        return settled(self, panels, rule, depth)

    monkeypatch.setattr(panel_splitting.Halves, "settled", pressed)
    run = integrate(what, "extended")
    assert run.outcome is Outcome.INTERRUPTED
    count = len(run.times)
    assert 1 < count < len(whole.times)
    assert run.times[-1] <= run.reached < whole.times[count]
    assert np.array_equal(run.states, whole.states[:count])
    assert np.array_equal(run.attitude, whole.attitude[:count])
    assert run.angles == whole.angles[:count]


def test_a_run_that_ends_early_has_rows_as_far_as_it_came():
    times = [Fraction(k) for k in range(100)]
    name = "kovalevskaya/generic"
    run = integrate(scene(name, times), "extended", max_steps=100)
    alone = integrate(scene(name, times, ()), "extended", max_steps=100)
    assert run.outcome is alone.outcome is Outcome.STEP_LIMIT
    assert np.array_equal(run.states, alone.states)
    assert len(run.angles) == len(run.attitude) == len(run.times) == len(alone.times) > 20
    assert len(run.times) < len(times)
    none = integrate(scene(name, times), "extended", max_steps=1)
    assert len(none.angles) == len(none.times) == 1


def test_progress_grows_from_the_plain_run_to_its_end(monkeypatch):
    change_policy(monkeypatch, chunk=100)
    seen: list[float] = []
    what = scene("lagrange/nutation", [300], ("angles",))
    integrate(what, "extended", progress=lambda done, steps: seen.append(done))
    assert len(seen) > 10
    assert seen == sorted(seen)
    assert 0 < seen[0] < 0.9 < seen[-1]
    assert seen[-1] == pytest.approx(1)
