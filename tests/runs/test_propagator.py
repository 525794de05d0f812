"""A prepared propagator gives what a run gives, from any start, and refuses what is none."""

import copy
import math
import pickle
import signal
import threading
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from shared.motions import TURNED

BODY = {"moments": [3, 2, 1], "centre": [0.25, 0.125, 0.5], "weight": 4}
START = [0.5, -0.25, 2.0, 0.6, 0.0, 0.8]  # 0.36 + 0.64 is 1 to an ulp


def scene(**more):
    given = {**BODY, "omega": START[:3], "gamma": ["0.6", 0, "0.8"], "end": 1} | more
    return polhode.top(**given)


ROTATED = {"moments": None, "inertia": TURNED}
CASES = {
    "plain": ({}, [0.5, -0.25, 2.0, 0, -1, 0]),
    "slow": ({"weight": Fraction(1, 2**21), "omega": [1e-3, 0, 2e-3]}, [1e-3, 0, 2e-3, 1, 0, 0]),
    "fast": ({"weight": 2.0**20, "omega": [1e3, 0, 2e3]}, [900.0, 7.0, 2e3, 0, 1, 0]),
    "rotated": (ROTATED, [0.5, -0.25, 2.0, 0, -1, 0]),
    "symmetric": ({"moments": [2, 2, 1], "centre": [0, 0, 1]}, [0.5, 0.25, 2.5, 0, 0, 1]),
    "free": ({"weight": 0, "gamma": None}, [0.5, 0.25, 2.0]),
}


@pytest.mark.parametrize("number", ["double", "extended"])
@pytest.mark.parametrize("name", CASES)
def test_it_gives_what_a_run_from_that_start_gives(name, number):
    more, start = CASES[name]
    go = polhode.propagator(scene(**more), number=number)
    unit = 2.0**go.scene.time_unit
    moved = dict(zip(("omega", "gamma"), (start[:3], start[3:] or None), strict=True))
    own = scene(**more | moved)
    assert own.time_unit == go.scene.time_unit
    times = [0.5 * unit, 3 * unit, 20 * unit]
    run = polhode.integrate(own, number, at=times, project=False)
    for k, t in enumerate(times):
        found = go(np.array(start), t=t)
        assert (go.outcome, go.steps) == (polhode.Outcome.REACHED_END, go.steps)
        if name == "rotated":  # the start's components in principal axes are rounded once more
            assert np.abs(found - run.states[k]).max() < 300 * float(run.number.eps)
            assert found.dtype == run.states.dtype
        else:
            there = polhode.integrate(own, number, at=[t], project=False)
            assert found.tolist() == there.states[0].tolist()
            assert go.steps == there.steps
    if name != "rotated":
        assert go(start, t=times).tolist() == run.states.tolist()
        assert go(start, t=-times[0]).tolist() == go(start, t=[-times[0]])[0].tolist()
        assert np.abs(go(go(start, t=times[0]), t=-times[0]) - start).max() < 1e-12 * max(start)
        assert go(t=times[0]).tolist() == go(go(t=0.0), t=times[0]).tolist()


@pytest.mark.parametrize("number", ["double", "extended"])
def test_projected_it_stays_on_the_integrals_of_its_own_start(number):
    plain, held = (polhode.propagator(scene(), number=number, project=p) for p in (False, 16))
    start = np.array([1.0, 0.5, -2.0, 0, 0.6, 0.8], np.longdouble)
    start[5] = np.sqrt(1 - start[4] ** 2)
    start = start.astype(plain(t=0.0).dtype)
    own = scene(omega=start[:3], gamma=start[3:], normalise=True)
    end = 300.0
    assert held(start, t=1.0) is not None
    eps = float(plain.number.eps)

    def drift(state):
        body = own.body
        momentum = [float(m) * w for m, w in zip(body.moments, state[:3], strict=True)]
        energy = np.dot(momentum, state[:3]) / 2 + np.dot([1.0, 0.5, 2.0], state[3:])
        return np.array([energy, np.dot(momentum, state[3:]), np.dot(state[3:], state[3:])])

    off = np.abs(drift(held(start, t=end)) - drift(start)).max()
    assert off < 16 * max(eps, 2.0**-52)
    assert plain(start, t=end).shape == (6,)
    # the motion is chaotic: one ulp of the start moves its steps by 80 of 2100 until t = 300
    there, steps = plain(start, t=30.0), plain.steps
    assert np.abs(held(start, t=30.0) - there).max() < 1e5 * eps
    assert abs(held.steps - steps) <= 1
    true = np.array([float(x) for x in polhode.integrate(own, "quad", at=[20]).states[0]])
    assert np.abs(held(start, t=20.0) - true).max() < 1e-12


GOOD = np.array(START)
WRONG = [
    ([1, 2, 3], "the 6 numbers"),
    ([[[*START]]], "the 6 numbers"),
    (GOOD.astype(np.longdouble), "double or narrower"),
    (GOOD.astype(complex), "double or narrower"),
    (["1", "2", "3", "1", "0", "0"], "double or narrower"),
    ([Fraction(1)] * 3 + [1, 0, 0], "double or narrower"),
    ([2**53 + 1, 0, 0, 0, 0, 1], "double or narrower"),
    ([np.nan, *START[1:]], "finite"),
    ([*START[:2], np.inf, *START[3:]], "finite"),
    ([*START[:3], np.nan, 0, 1], "length 1"),
    ([*START[:3], 0.6, 0, 0.8 + 1e-14], "length 1"),
    ([*START[:3], 0.6, 0, 0.8 + 1.5e-15], "length 1"),  # its square is off by 11 eps
    ([*START[:3], 0, 0, 0], "length 1"),
    ([[0.5], 1, 2, 0, 0, 1], "expected the 6 numbers"),
    (np.ma.array(START, mask=[1, 0, 0, 0, 0, 0]), "expected the 6 numbers"),
]


@pytest.mark.parametrize(("start", "said"), WRONG, ids=range(len(WRONG)))
def test_what_is_no_start_is_refused_and_the_next_call_is_right(start, said):
    go = polhode.propagator(scene())
    before = go(GOOD, t=3.0).tolist()
    with pytest.raises(polhode.BadInput, match=said) as fault:
        go(start, t=3.0)
    assert fault.value.key == "start"
    assert "\n" not in str(fault.value)
    assert go(GOOD, t=3.0).tolist() == before


@pytest.mark.parametrize(
    ("key", "of_scene", "options"),
    [
        ("number", {}, {"number": "quad"}),
        ("number", {}, {"number": "mp"}),
        ("number", {"weight": "1e-700"}, {}),
        ("events", {"events": [polhode.Event("nutation")]}, {}),
        ("run.form", {"form": "momentum"}, {}),
        ("tol", {}, {"tol": 0}),
        ("project", {}, {"project": 0}),
        ("project", {}, {"project": None}),
    ],
)
def test_what_it_does_not_do_is_refused_when_it_is_made(key, of_scene, options):
    with pytest.raises(polhode.BadInput) as fault:
        polhode.propagator(scene(**of_scene), **options)
    assert fault.value.key == key


def test_another_thread_has_to_take_a_copy():
    go = polhode.propagator(scene())
    right, found = go(t=5.0).tolist(), {}

    def elsewhere():
        try:
            go(t=5.0)
        except polhode.BadInput as fault:
            found["refused"] = str(fault)
        found["copied"] = copy.copy(go)(t=5.0).tolist()

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert "copy.copy" in found["refused"]
    assert found["copied"] == right == pickle.loads(pickle.dumps(go))(t=5.0).tolist()


@pytest.mark.slow
@pytest.mark.parametrize("project", [False, True])
def test_an_interrupted_call_leaves_it_usable(project):
    go = polhode.propagator(scene(), project=project)
    right = go(t=5.0).tolist()

    def interrupt(*_):
        raise KeyboardInterrupt

    def interrupted_after(delay):
        signal.setitimer(signal.ITIMER_REAL, delay)
        go(t=1e7)

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        for delay in (0.001, 0.02, 0.3):
            with pytest.raises(KeyboardInterrupt):
                interrupted_after(delay)
            assert go(t=5.0).tolist() == right
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.slow
def test_what_was_not_reached_is_nan_and_said():
    go = polhode.propagator(scene())
    near = go(t=0.125).tolist()
    assert np.isnan(go(t=1e300)).all()
    assert go.outcome is polhode.Outcome.STEP_LIMIT
    assert go.steps <= 200_000  # it is told early that the limit will not do
    rows = go(t=np.array([0.125, 1e300]))
    assert rows[0].tolist() == near
    assert np.isnan(rows[1]).all()
    assert go.outcome is polhode.Outcome.STEP_LIMIT


def test_a_motion_that_overflows_on_a_short_way_keeps_what_it_had():
    go = polhode.propagator(scene())
    start = np.array([1e100, 1e100, 0, 0, 0, 1])
    for times in ([0, 1e-97], np.array([0, 1e-97])):  # few radians; their powers are no doubles
        rows = go(start, t=times)
        assert rows[0].tolist() == start.tolist()
        assert np.isnan(rows[1]).all()
        assert not go.outcome.done
    assert np.isnan(go(start, t=1e-97)).all()
    assert go.outcomes == (go.outcome,)


@pytest.mark.parametrize("where", range(3))
@pytest.mark.parametrize(
    ("number", "size"),
    [("double", 1e154), ("double", 1e308), ("extended", 1e308), ("extended", "1e4000")],
)
def test_a_start_that_is_far_too_fast_is_given_up_and_the_next_is_right(number, where, size):
    go = polhode.propagator(scene(), number=number)
    start = np.array([0, 0, 0, 0, 0, 1], go(t=0.0).dtype)
    start[where] = np.longdouble(size)
    right = go(t=1.0).tolist()
    for given in (start, [*start]):
        for t in (1.0, [1.0], np.array([0.5, 1.0])):
            assert np.isnan(go(given, t=t)).any()
            assert not go.outcome.done
    assert go(t=1.0).tolist() == right


def test_an_array_of_times_gives_the_states_of_a_list_to_the_bit():
    """An array of the propagator's own type goes to heyoka at once, a list by exact times."""
    go = polhode.propagator("euler/largest-axis")
    for end in (3, -3, 30_000):  # the last one in several chunks
        times = np.linspace(0, end, 7)
        for given in (times, times[1:]):
            rows, steps, outcome = go(t=given), go.steps, go.outcome
            assert np.array_equal(rows, go(t=[*given]))
            assert (steps, outcome) == (go.steps, go.outcome)
            assert np.array_equal(rows[-1], go(t=given[-1]))


@pytest.mark.parametrize("start", [None, [START] * 3])
@pytest.mark.parametrize(
    "times",
    [
        *([1, 2, 1], [1, 1], [0, 0], [-1, 1], [1, math.nan], [math.inf], [1, -2, 3], [0, 1, 1, 2]),
        *([1, math.nan, 2], [-1, 2, -3], [-1, -2, -2], [-1, -3, -2, -4]),
        *(math.nan, math.inf, "x", None, [[1.0]], [], np.array([]), {1, 2}, {1: 2}, {1: 2}.keys()),
    ],
)
def test_times_that_lead_nowhere_are_refused(times, start):
    go = polhode.propagator("general/asymmetric-regular")
    flat = isinstance(times, list) and np.ndim(times) == 1
    for written in (times, np.array(times, float) if flat else times):
        with pytest.raises(polhode.BadInput, match=r"^[^\n]*$"):
            go(start, t=written)
    assert go(t=np.array([1.0])).shape == (1, 6)  # and it is usable


@pytest.mark.parametrize("number", ["double", "extended"])
def test_numbers_of_any_plain_kind_go_the_quick_way_to_the_same_bits(number, monkeypatch):
    """A loop over np.linspace gives np.float64, a user types 1 for 1.0 and a list for a start."""
    go = polhode.propagator("general/asymmetric-regular", number=number)
    plain = [0.5, -0.25, 2.0, 0.0, 0.0, 1.0]
    usual = go(np.array(plain, go(t=0.0).dtype), t=2.0)
    monkeypatch.setattr(type(go), "_at_times", None)
    for t in (2, 2.0, np.float64(2)):
        for start in (plain, tuple(plain), [np.float64(x) for x in plain]):
            assert np.array_equal(go(start, t=t), usual)
    assert np.array_equal(go([0, 1, 0, 0, 0, 1], t=1), go([0.0, 1.0, 0.0, 0.0, 0.0, 1.0], t=1.0))
    for start in ([2**53 + 1, 0, 0, 0, 0, 1], [True] * 6):  # not as they are in doubles
        if number == "double":
            with pytest.raises(polhode.BadInput):
                go(start, t=1.0)


GRIDS = {
    "one": [2.0],
    "one after 0": [0.0, 2.0],
    "two": [1.0, 2.0],
    "unequal": [0.0, 1e-3, 0.5, 0.5000001, 7.0],
    "backward": [0.0, -1e-3, -0.5, -7.0],
    "backward, not from 0": [-0.5, -7.0],
    "dense near 0": [1e-300, 1e-17, 1e-9, 2e-9, 0.125, 0.125 + 2.0**-55, 1.0],
    "whole": [1, 2, 5],
    "from a negative 0": [-0.0, 1.0],
}
UNITS = {"plain": (1.0, {}), "unit": (2.0**-11, CASES["fast"][0]), "axes": (1.0, ROTATED)}


@pytest.mark.parametrize("case", UNITS)
@pytest.mark.parametrize("grid", GRIDS)
def test_rows_are_those_of_the_careful_way(grid, case, monkeypatch):
    unit, more = UNITS[case]
    go = polhode.propagator(scene(**more))
    start = None if case != "plain" else START
    times = [t * unit for t in GRIDS[grid]]
    rows = go(start, t=[*map(Fraction, times)])
    outcome, steps = go.outcome, go.steps
    monkeypatch.setattr(type(go), "_at_times", None)  # the quick way alone from now on
    for given in (np.array(times), times, tuple(times), [*np.array(times)]):
        found = go(start, t=given)
        assert (go.outcome, go.steps) == (outcome, steps)
        assert found.tolist() == rows.tolist()
        assert found[-1].tolist() == go(start, t=times[-1]).tolist()
        assert found.flags.writeable


def test_times_count_by_value_not_by_the_object_that_holds_them():
    go = polhode.propagator(scene())
    for times in (np.linspace(0, 1, 5), np.linspace(0, 1, 5).tolist()):
        first = go(t=times)
        kept = first.copy()
        times[2] = 0.625
        second = go(t=times)
        assert second.tolist() == polhode.propagator(scene())(t=[0, 0.25, 0.625, 0.75, 1]).tolist()
        times[2] = 0.5
        again = go(t=times)
        again[:] = 7  # rows are the caller's own
        assert first.tolist() == kept.tolist() == go(t=times).tolist()
        times[2] = 0.125  # no longer in order
        with pytest.raises(polhode.BadInput, match="monotone"):
            go(t=times)
        times[2] = 0.5
        assert first.tolist() == go(t=times).tolist()
    wide = np.array([[0.0, 9], [0.5, 9], [1, 9]])
    column = wide[:, 0]  # not contiguous
    assert go(t=column).tolist() == go(t=[0, 0.5, 1]).tolist()
    wide[1, 0] = 0.25
    assert go(t=column).tolist() == go(t=[0, 0.25, 1]).tolist()


@pytest.mark.parametrize("kind", [np.float32, np.int64, np.int32, np.float64])
def test_arrays_of_narrower_numbers_are_times_exactly(kind):
    go = polhode.propagator(scene())
    times = np.array([1, 2, 5], kind)
    assert go(t=times).tolist() == go(t=[1, 2, 5]).tolist()
    assert go(t=times[1]).tolist() == go(t=2.0).tolist() == go(t=times[1:2])[0].tolist()
    tenth = go(t=np.float32(0.1))
    assert tenth.tolist() == go(t=float(np.float32(0.1))).tolist() != go(t=0.1).tolist()
    for zero in ([0], [0.0], np.array([0.0], kind), np.array([-0.0])):
        assert go(t=zero).tolist() == [go(t=0.0).tolist()] == [go(t=0).tolist()]


@pytest.mark.parametrize("number", ["double", "extended"])
@pytest.mark.parametrize("several", [list, np.array])
def test_integers_beyond_2_53_are_no_other_times(number, several):
    """As a double 2**53 + 1 would be 2**53: that time twice."""
    go = polhode.propagator(scene(omega=["1e-17", 0, 0], weight=0), number=number)
    times = several([2**53, 2**53 + 1])
    if number == "double":
        with pytest.raises(polhode.BadInput, match="differ when rounded to double"):
            go(t=times)
    else:
        assert np.isfinite(go(t=times)).all()
    with pytest.raises(polhode.BadInput, match=r"at\[1\] = True"):
        go(t=[True, 2])


@pytest.mark.parametrize("number", ["double", "extended"])
def test_times_may_be_an_iterator(number):
    """With an array of starts it was read twice, and empty the second time."""
    go = polhode.propagator(scene(), number=number)
    starts = [[*START[:3], 0, 0, 1]] * 2
    assert go(starts, t=iter([1.0, 2.0])).tolist() == go(starts, t=[1.0, 2.0]).tolist()


def test_a_million_outputs_are_those_of_few():
    go = polhode.propagator(scene(**CASES["fast"][0]))  # its unit is not the scene's
    times = np.linspace(0, 2.0**-10, 1_000_001)
    rows = go(t=times)
    some = [0, 1, 1023, 1024, 1025, 333_333, 999_999, 1_000_000]
    assert rows[some].tolist() == go(t=times[some]).tolist()
    assert np.abs(np.vecdot(rows[:, 3:], rows[:, 3:]) - 1).max() < 64 * 2.0**-52


SLOW = {"weight": 2.0**-40, "omega": [1e-6, 0, 2e-6]}
BEYOND = [(CASES["fast"][0], t) for t in (1e308, [1e308], -1e308)]
BEYOND += [(SLOW, t) for t in ([5e-324, 1.0], np.array([5e-324, 1.0]), [1.01e-315, 1.0])]


@pytest.mark.parametrize(("more", "t"), BEYOND)
def test_times_that_the_unit_makes_too_large_or_too_small_are_refused(more, t, recwarn):
    """Inside, 5e-324 would be 0, and 1.01e-315 another number."""
    go = polhode.propagator(scene(**more))
    for start in (None, [START]):
        with pytest.raises(polhode.BadInput, match="number = double: expected a type of wider ran"):
            go(start, t=t)
    assert not recwarn.list
    assert np.isfinite(go(t=[1e-300, 2.0**-10])).all()
    rows = polhode.propagator(scene())(t=[5e-324, 1e-310, 1.0])  # taken where the unit is 1
    assert np.abs(rows[:2] - START).max() < 1e-300


def test_a_scenes_outputs_are_left_out():
    case = polhode.load("lagrange/nutation")
    assert case.outputs
    go = polhode.propagator(case)
    assert np.array_equal(go(t=1.0), polhode.propagator(replace(case, outputs=()))(t=1.0))
