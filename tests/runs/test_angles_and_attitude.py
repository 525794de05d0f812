"""Angles and attitude of runs: as good as the state, whole turns counted, whatever the times."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import Outcome
from shared.tools import change_policy, exactly, tiers

BOTH = ("angles", "attitude")


def scene(name, at, outputs=BOTH, events=(), **changes):
    return replace(polhode.load(name), events=events, outputs=outputs, **changes).at(at)


def error(mine, exact, relative=False) -> float:
    """The largest difference, or by a number's own size beyond 1; gaps are gaps on both sides."""
    worst = 0.0
    for row, true in zip(mine, exact, strict=True):
        for x, y in zip(row, true, strict=True):
            assert (x is None) == (y is None)
            if x is not None:
                size = max(1.0, abs(float(y))) if relative else 1.0
                worst = max(worst, abs(float(exactly(x) - exactly(y))) / size)
    return worst


UNEVEN = [0, "0.1", "0.2", "0.2000001", 3, 50, "50.01", 70]
#: gamma circles near the third axis, and the pole lies between the path and its chords.
CIRCLING = polhode.top(
    moments=["1", "1.05", "0.9"],
    omega=["0.5", "0", "0.9"],
    gamma=["0.8", "0.3", "0.6"],
    normalise=True,
    outputs=BOTH,
    at=[300, 500],
)


@pytest.mark.usefixtures("compiled_as_for_users")
@pytest.mark.parametrize(
    ("number", "case"),
    tiers(
        [
            ("double", scene("euler/turned-axes", [*UNEVEN, 200])),
            ("extended", scene("lagrange/looping", [5, 40])),
        ],
        [
            ("double", scene("kovalevskaya/generic", [-1, -33, -90])),
            ("extended", CIRCLING),
            ("quad", scene("euler/backward", [-1, -12])),
            ("mp", scene("lagrange/looping", [-3, -6], psi=Fraction(22, 7))),
        ],
    ),
    ids=lambda x: getattr(x, "name", x),
)
def test_attitude_and_angles_are_as_good_as_the_state(number, case):
    """And the state as that of a run without them; the attitude is of length 1 and has gamma."""
    wider = {"double": "extended", "extended": "quad", "quad": "mp"}  # by other ways, too
    run, alone = (polhode.integrate(s, number) for s in (case, replace(case, outputs=())))
    fine = polhode.integrate(case, wider.get(number), digits=None if number != "mp" else 60)
    eps, state = float(run.number.eps), error(run.states, fine.states, True)
    assert 0 < state < 3e4 * eps * (100 if case.name.startswith(("hard", "general")) else 1)
    plain = error(alone.states, fine.states, True)
    assert plain / 16 < state < 4 * plain
    assert eps / 40 < error(run.attitude, fine.attitude) < 5 * state + 64 * eps
    assert eps / 40 < error(run.angles, fine.angles, True) < 20 * state + 64 * eps
    kind = float if number == "double" else type(run.states[0][0])
    assert {type(x) for row in run.angles for x in row} == {kind}
    lengths = (run.attitude**2).sum(axis=1)
    assert max(abs(x - 1) for x in lengths) < (8 if run.number.flat else 64) * eps
    a, x, y, z = run.attitude.T
    vertical = [2 * (x * z - a * y), 2 * (y * z + a * x), a * a - x * x - y * y + z * z]
    assert abs(np.array(vertical) - run.gamma.T).max() < 300 * eps
    middle = run.times[-1] * Fraction(2, 3)
    assert error([run(middle)], [alone(middle)], True) <= 4 * (state + plain)
    there, true = ([each.angles_at(middle)] for each in (run, fine))
    assert error(there, true, True) < 20 * state + 64 * eps
    for word, absent in zip(BOTH, ("attitude", "angles"), strict=True):
        each = polhode.integrate(replace(case, outputs=(word,)), number)
        assert getattr(each, absent) is None
        assert len(getattr(each, word)) == len(run.times)


@pytest.mark.parametrize(
    ("project", "number"),
    tiers([(False, "double")], [(None, "extended")]),
)
def test_angles_that_grow_loosen_no_step(number, project, monkeypatch):
    """phi of a fast top grows to thousands of radians, and steps are as accurate as the largest
    variable asks: its state would lose as many digits.  Chunks end between two set-backs."""
    change_policy(monkeypatch, chunk=1000)
    top = polhode.load("hard/fast-top").at((Fraction(1, 2), Fraction(1)))
    along, alone = (
        polhode.integrate(s, number, project=project) for s in (top, replace(top, outputs=()))
    )
    assert along.steps >= alone.steps > 5000
    truth, eps = polhode.reference(top), float(along.number.eps)
    digits = [min(polhode.compare(run, truth).digits) for run in (along, alone)]
    assert digits[0] > digits[1] - 0.5
    assert abs(along(along.times)[1] - along.states[1])[3:].max() < 1e4 * eps
    exact = truth.angles(along.times, 40)
    if project is False:  # psi is 1e-4, and what the quaternion tells of it is off by many eps
        assert error([row[:1] for row in along.angles], [row[:1] for row in exact]) < eps / 10
    assert error(along.angles, exact, True) < 100 * eps
    assert error([row[2:] for row in along.angles], [row[2:] for row in exact], True) < 4 * eps


@pytest.mark.parametrize(
    ("distance", "number"),
    tiers([("1e-3", "double"), ("-1e-9", "double")], [("-1e-9", "extended")]),
)
def test_psi_and_phi_past_near_poles(distance, number):
    """Some dozens of passages of the lower pole, at distances of that order: no turn is missed
    between two steps, and psi has no error by their number, as its integral would.
    """
    omega = [Fraction(5, 2), (Fraction(distance) - Fraction(27, 25)) / Fraction(3, 5), "1.2"]
    body = {"moments": [1, 1, "0.5"], "centre": [0, 0, 1], "weight": 1, "gamma": [0, "0.6", "0.8"]}
    top = polhode.top(**body, omega=omega, outputs=["angles"], at=[10, 30, 60])
    run, fine = polhode.integrate(top, number), polhode.integrate(top, "quad")
    eps = float(run.number.eps)
    assert 4 * eps < error(run.angles, fine.angles) < 600 * eps
    both = polhode.integrate(replace(top, outputs=BOTH), number)
    assert both.angles == run.angles


def test_a_pole_on_the_way_is_passed_and_turns_alone_are_in_doubt():
    """Where a motion goes through it exactly.  In double the run ends there, as the guide says."""
    body = {"moments": [1, 1, "1/2"], "centre": [0, 0, 1], "weight": 1, "outputs": ["angles"]}
    top = polhode.top(**body, angles=["0.3", 0, "0.2"], rates=[0, "0.8", 3])
    run = polhode.integrate(top, "extended", at=[5])
    assert run.outcome.done
    ((psi, theta, phi),) = run.angles
    ((true_psi, true_theta, true_phi),) = polhode.reference(top).angles([5], 25)
    assert abs(theta - true_theta) < 1e-14
    for angle, true in ((psi, true_psi), (phi, true_phi)):
        turns = float(angle - true) / (2 * math.pi)
        assert abs(turns - round(turns)) < 1e-14


# -- poles and zeros at the start -----------------------------------------------------------------


@pytest.mark.parametrize("end", [3, -3])
@pytest.mark.parametrize(
    ("number", "up"), tiers([("double", 1)], [("extended", 1), ("double", -1)])
)
def test_angles_of_a_start_at_a_pole_begin_at_their_one_sided_limits(number, up, end):
    """psi and phi are undefined at t = 0, then the closed form's; psi ± phi is continuous."""
    top = scene("euler/attitude", [0, Fraction(end, 100), end], gamma=(0, 0, Fraction(up)))
    run = polhode.integrate(top, number)
    assert run.angles[0][0] is run.angles[0][2] is None
    exact = polhode.reference(top).angles(run.times, 60)
    assert error(run.angles, exact) < 2000 * float(run.number.eps)
    psi, _, phi = run.angles[1]
    assert abs(float(psi + up * phi) - float(top.psi)) < 0.1


def test_a_refined_run_from_a_pole_on_tells_its_angles():
    """They were refused, for a method that nobody had named."""
    top = scene("lagrange/from-the-pole", [1], ())
    run = polhode.integrate(top, "quad", method="refined")
    steps = polhode.integrate(replace(top, outputs=("angles",)), "quad")
    assert (run.method, steps.method) == ("refined", "taylor")
    assert error([run.angles_at("1/2")], [steps.angles_at("1/2")]) < 1e-31


def test_a_body_that_stays_at_the_pole_has_no_psi_and_phi():
    top = scene("euler/largest-axis", [0, 1, 2], omega=(0, 0, Fraction(2)), gamma=(0, 0, 1))
    run = polhode.integrate(top)
    assert [[*row] for row in run.angles] == [[None, 0.0, None]] * 3
    assert run.attitude.shape == (3, 4)


@pytest.mark.parametrize("number", ["double", "extended", "quad"])
@pytest.mark.parametrize("up", [1, -1])
def test_at_a_pole_where_a_turned_body_starts_there_are_no_psi_and_phi(number, up):
    """Its gamma has gone through the principal axes: it is beside the pole by rounding."""
    top = polhode.top(
        inertia=[[2, 0, 0], [0, "3/2", "1/2"], [0, "1/2", "3/2"]],
        **{"centre": ["1/10", "1/5", "1/2"], "weight": 2, "omega": ["3/10", "-1/5", 2]},
        **{"gamma": [0, 0, up], "psi": "7/10", "outputs": BOTH, "at": [0, 1]},
    )
    run = polhode.integrate(top, number)
    assert [x is None for x in run.angles[0]] == [True, False, True]
    assert [x is None for x in run.angles_at(0)] == [True, False, True]
    true = polhode.reference(top).angles([1], 20)
    assert error(run.angles[1:], true) < 1e-14


@pytest.mark.parametrize("output", tiers([{"number": "quad"}], [{"digits": 50}]))
def test_what_is_zero_at_the_start_of_a_turned_body_is_zero(output):
    """Through the principal axes and back it would be 1e-35, or 1e-56."""
    top = polhode.top(
        inertia=[[2, "1/3", "1/7"], ["1/3", 3, "1/5"], ["1/7", "1/5", 2]],
        centre=[0, 0, 1],
        weight=1,
        angles=[0, "pi/6", 0],
        rates=[0, 0, 3],
        outputs=["angles"],
        at=[0, 1],
    )
    run = polhode.integrate(top, **output)
    assert run.states[0].tolist()[:4] == [0, 0, 3, 0]
    assert run["phi"][0] == run["psi"][0] == 0
    assert (run(0) == run.states[0]).all()
    assert 0 < abs(run.states[1, 0]) < 1
    many = polhode.integrate_many(top, {"start.rates[3]": [3, 4]}, **output)
    for k, spin in enumerate((3, 4)):
        assert many.states[k, 0].tolist()[:4] == [0, 0, spin, 0]


# -- other times, and runs that end early ---------------------------------------------------------


def test_a_scene_asked_at_other_times_is_read_at_those():
    """What a scene's runs begin with is shared by scenes that differ in their times alone."""
    level = (polhode.Event("level", "gamma3", "rising"),)
    for changes in ({"outputs": BOTH}, {"outputs": (), "events": level}):
        base = replace(polhode.load("kovalevskaya/generic"), **changes)
        for at in ([100, 400], [150, 300], [50, 100, 400], [-200], [3], [-3]):
            again = polhode.integrate(base.at(at))
            alone = polhode.integrate(scene("kovalevskaya/generic", at, **changes))
            assert (again.times, again.reached) == (tuple(at), at[-1])
            assert again == alone


def ends_early(times, **options):
    """A run with rows as far as it came, the first ones of the whole run."""
    nutation = scene("lagrange/nutation", times)
    whole = polhode.integrate(nutation, options["number"])
    run = polhode.integrate(nutation, **options)
    count = len(run.times)
    assert 1 < count < len(whole.times)
    assert run.times[-1] <= run.reached < whole.times[count]
    assert np.array_equal(run.states, whole.states[:count])
    assert np.array_equal(run.attitude, whole.attitude[:count])
    assert run.angles == whole.angles[:count]
    return run


@pytest.mark.parametrize(("number", "end"), [("double", 1000), ("extended", 300)])
@pytest.mark.parametrize("fraction", [0.2, 0.75])
def test_a_run_that_is_interrupted_has_whole_rows_as_far_as_it_came(
    number, end, fraction, monkeypatch
):
    """Progress only grows."""
    change_policy(monkeypatch, chunk=400)
    calls = []

    def pressed(share, steps):
        calls.append(share)
        if share > fraction:
            raise KeyboardInterrupt

    run = ends_early(range(0, end, 10), number=number, progress=pressed)
    assert run.outcome is Outcome.INTERRUPTED
    assert calls == sorted(calls)


@pytest.mark.parametrize(("number", "steps"), [("double", 1000), ("extended", 100)])
def test_a_run_of_too_many_steps_has_rows_as_far_as_it_came(number, steps):
    times = [Fraction(k, 3) for k in range(2000)]
    run = ends_early(times, number=number, max_steps=steps)
    assert (run.outcome, run.steps) == (Outcome.STEP_LIMIT, steps)
    none = polhode.integrate(scene("lagrange/nutation", times), number, max_steps=1)
    assert len(none.angles) == len(none.times) == 1
