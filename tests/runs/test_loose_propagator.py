"""A propagator of a tolerance above eps: rows by other ways than a run's, as accurate as told."""

import copy
import pickle
import threading
from fractions import Fraction

import numpy as np
import pytest

import polhode
from shared.motions import TURNED

EPS = 2.0**-52
CENTRE = [0.25, 0.125, 0.5]
#: Most have the same coefficients that are zero, none, and share compiled code.
MOTIONS = {
    "chaotic": {"moments": [3, 2, 1], "centre": CENTRE, "weight": 4},
    "fast": {"moments": [3, 2, 1], "centre": CENTRE, "weight": 4, "omega": [0, 3, 100]},
    "slow unit": {
        **{"moments": [3, 2, 1.5], "centre": CENTRE, "weight": Fraction(1, 2**40)},
        "omega": [Fraction(1, 2**20), 0, Fraction(1, 2**19)],
    },
    "slender": {"moments": [1, 1.0078125, 0.015625], "centre": CENTRE, "weight": 0.25},
    "separatrix": {"moments": [3, 2, 1], "weight": 0, "omega": [0, 1, Fraction(1, 2**20)]},
    "symmetric": {"moments": [2, 2, 1], "centre": [0, 0, 1], "weight": 1},
    "no gamma": {"moments": [3, 2, 1], "weight": 0, "gamma": None},
    "turned": {"inertia": TURNED, "centre": CENTRE, "weight": 4},
    "unit": {"moments": [3, 2, 1], "centre": CENTRE, "weight": 2**20, "omega": [1e3, 0, 2e3]},
}


def top(name):
    keys = {"omega": [0.5, -0.25, 1], "gamma": ["0.6", 0, "0.8"], "end": 1} | MOTIONS[name]
    return polhode.top(**keys)


def fastest(scene):
    """A rate of the motion: of its start, or of a pendulum of its weight."""
    a = min(map(float, scene.body.moments))
    pull = np.linalg.norm([*map(float, scene.body.torque)])
    return max(np.linalg.norm([*map(float, scene.omega)]), float(np.sqrt(pull / a)))


GRIDS = {
    "one": [1.0],
    "two": [0.0, 1.0],
    "unequal": [0.0, 1e-3, *np.linspace(0.6, 0.7, 120), 1.0],
    "backward": -np.linspace(0, 1, 101),
    "backward in many": -np.linspace(0, 1, 1501)[1:],
    "dense near 0": [0.0, 1e-17, *np.geomspace(1e-9, 1, 200)],
    "even": np.linspace(0, 1, 101),
    "many": np.linspace(0, 1, 2001),
}


def errors(scene, go, times):
    """Of some rows, beside a run in quad: of gamma, and of omega over the fastest rate."""
    rows = go(t=np.array(times))
    picked = np.unique(np.linspace(len(times) == 1, len(times) - 1, 9).astype(int) % len(times))
    picked = picked[np.array(times)[picked] != 0]
    exact = scene.at([Fraction(float(times[k])) for k in picked])
    true = np.array([[float(x) for x in row] for row in polhode.integrate(exact, "quad").states])
    off = np.abs(rows[picked] - true)
    off[:, :3] /= fastest(scene)
    assert rows.flags.c_contiguous
    return off.max()


#: Each motion on three of the grids, each grid with three motions or more.
PAIRS = [(name, [*GRIDS][(k + i) % 8]) for k, name in enumerate(MOTIONS) for i in (0, 3, 6)]


@pytest.mark.parametrize(("name", "grid"), PAIRS)
def test_no_row_is_off_by_more_than_the_tolerance(name, grid):
    """Over ways of about 1 and 15 radians: by long steps, by heyoka's own and by a higher order."""
    scene = top(name)
    for tol, radians in ((1e-4, 1.0), (1e-7, 15.0), (1e-11, 1.0)):
        go = polhode.propagator(scene, tol=tol)
        times = np.array(GRIDS[grid]) * radians / fastest(scene)
        assert errors(scene, go, times) < tol + 64 * EPS


def rows_of_random_times_are_within_the_tolerance(count):
    """Of a random motion, tolerance and way: one row or thousands, wherever they lie."""
    dice = np.random.default_rng(count)
    for _ in range(count):
        scene, tol = top(str(dice.choice([*MOTIONS]))), 10 ** dice.uniform(-12, -2)
        way = float(dice.choice([1, -1])) * 10 ** dice.uniform(-2, 1.2) / fastest(scene)
        times = np.unique(dice.random(int(dice.choice([1, 3, 60, 500, 3000])))) * way
        assert errors(scene, polhode.propagator(scene, tol=tol), times) < tol + 64 * EPS


@pytest.mark.parametrize("fast", [10, 1000])
def test_of_a_start_faster_than_the_scene_gamma_is_off_by_that_many_tolerances(fast):
    """The unit of time is the scene's, and heyoka's error that of the largest variable."""
    tol, moments = 1e-7, [1.5, 1.5 + 2**-10, 1]
    body = {"moments": moments, "centre": [0.25, 0.125, 0.5], "weight": 1, "end": 1}
    go = polhode.propagator(polhode.top(**body, omega=[0, 0, 1], gamma=["3/5", 0, "4/5"]), tol=tol)
    start = np.array([1e-3 * fast, 0, fast, 0.6, 0, 0.8])
    t = 10 / fast
    own = polhode.top(**body, omega=start[:3].tolist(), gamma=["3/5", 0, "4/5"])
    true = polhode.propagator(own)(start, t=t)
    off = np.abs(go(start, t=t) - true)
    assert off[:3].max() < tol * fast
    assert 1e-3 * tol * fast < off[3:].max() < tol * fast
    assert np.abs(polhode.propagator(own, tol=tol)(start, t=t) - true)[3:].max() < tol


@pytest.mark.parametrize("tol", [1e-3, 1e-9])
def test_heyoka_decides_how_long_a_step_may_be(tol, monkeypatch):
    """However much longer steps are tried."""
    monkeypatch.setattr("polhode.taylor.defaults.LONG_REACH", 40.0)
    monkeypatch.setattr("polhode.taylor.defaults.LONG_TRIED", 40.0)
    for name in ("chaotic", "symmetric", "unit"):
        scene = top(name)
        go = polhode.propagator(scene, tol=tol)
        for radians in (1.0, 3.0, 8.0):
            for size in (101, 4001):
                times = np.linspace(0, radians / fastest(scene), size)
                assert errors(scene, go, times) < tol


def test_few_outputs_take_few_steps_and_a_long_way_fewer_than_a_run():
    scene = top("chaotic")
    go = polhode.propagator(scene, tol=1e-7)
    run = polhode.integrate(scene.at([0.5, 12]), tol=1e-7)
    rows = go(t=np.linspace(0, 0.5, 101))
    assert go.steps <= 2 < polhode.integrate(scene.at([0.5]), tol=1e-7).steps
    assert np.abs(rows[-1] - run.states[0]).max() < 1e-7
    go, run = polhode.propagator(scene, tol=1e-4), polhode.integrate(scene.at([12]), tol=1e-4)
    state = go(t=12.0)
    assert go.steps < 0.8 * run.steps
    assert np.abs(state - run.states[0]).max() < 1e-3  # a chaotic motion
    assert go.outcome.done


def test_steps_of_a_higher_order_lose_no_digits():
    """They were allowed a whole tolerance, and their errors were two to three times a run's."""
    ratios = []
    for name in MOTIONS:
        scene = top(name)
        end = [30 / fastest(scene)]
        for tol in (1e-3, 1e-4):
            run = polhode.integrate(scene.at([Fraction(end[0])]), tol=tol, project=False)
            higher = errors(scene, polhode.propagator(scene, tol=tol), end)
            ratios.append(higher / errors(scene, lambda t, run=run: run.states, end))
    assert 0.5 < np.median(ratios) < 1.5


def test_rows_differ_by_which_others_are_asked_for_within_the_tolerance():
    times = np.linspace(0, 2, 101)
    for name in ("chaotic", "separatrix"):
        go = polhode.propagator(top(name), tol=1e-7)
        rows = go(t=times)
        for part in (times[:51], times[50:], times[::25], np.linspace(0, 2, 2001)):
            shared, mine = np.nonzero(np.isclose(times[:, None], part, rtol=1e-14, atol=0))
            assert len(shared) > 2
            assert np.abs(go(t=part)[mine] - rows[shared]).max() < 1e-7
        assert np.abs(go(t=2.0) - rows[-1]).max() < 1e-7
        assert go(t=times).tolist() == rows.tolist()  # the same question, the same bits


@pytest.mark.parametrize("name", MOTIONS)
def test_at_time_0_it_stands_at_its_start(name):
    """The polynomial of a later step, by which the rows near 0 are made, leaves it."""
    scene = top(name)
    go = polhode.propagator(scene, tol=1e-3)
    times = np.linspace(0, 4 / fastest(scene), 2001)
    rows = go(t=times)
    assert 1 < go.steps < 12
    assert rows[0].tolist() == go(t=[0.0])[0].tolist()
    assert 0 < np.abs(rows[1] - rows[0]).max() < 0.01 * np.abs(rows[0]).max()


def test_projected_or_extended_it_goes_as_a_run_does():
    scene = top("chaotic").at([0.5, 1, 30])
    for number, project in (("double", True), ("extended", False)):
        go = polhode.propagator(scene, number=number, project=project, tol=1e-7)
        run = polhode.integrate(scene, number, tol=1e-7, project=project)
        assert go(t=[0.5, 1, 30]).tolist() == run.states.tolist()


def test_after_a_motion_that_overflows_the_next_one_is_right():
    go, times = polhode.propagator(top("chaotic"), tol=1e-7), np.linspace(0, 0.5, 101)
    right, far = go(t=times).tolist(), go(t=30.0).tolist()
    for size in (1e100, 1e150, 1e155):  # whose powers are no doubles, of the last squares neither
        start = np.array([size, size, 0, 0, 0, 1])
        assert not np.isfinite(go(start, t=times / size)).all()
        assert not go.outcome.done
        assert go(t=times).tolist() == right
        assert go(t=30.0).tolist() == far


def test_threads_with_copies_have_the_same_bits():
    go = polhode.propagator(top("chaotic"), tol=1e-7)
    grids = [np.linspace(0, end, size) for end, size in ((0.5, 101), (1, 2001), (9, 101))]
    right, same = [go(t=times).tolist() for times in grids], []

    def elsewhere(own):
        for _ in range(5):
            same.append([own(t=times).tolist() for times in grids] == right)

    def copied():
        elsewhere(copy.copy(go))

    threads = [threading.Thread(target=copied) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert same == [True] * 20


def test_another_process_and_other_kinds_of_numbers_have_the_same_bits():
    """Both went heyoka's own way, and of a chaotic motion to t = 30 nothing was the same."""
    for name in ("chaotic", "slow unit", "turned"):
        scene = top(name)
        go = polhode.propagator(scene, tol=1e-7)
        elsewhere = pickle.loads(pickle.dumps(go))
        end = 30 / fastest(scene)
        for times in (np.linspace(0, end / 30, 101), np.linspace(0, end, 7)):
            rows = go(t=times)
            assert elsewhere(t=times).tolist() == rows.tolist()
            assert elsewhere.steps == go.steps
            assert go(t=[Fraction(t) for t in times.tolist()]).tolist() == rows.tolist()
            assert go(t=times.astype(np.longdouble)).tolist() == rows.tolist()
        row = go(t=end)
        for t in (np.float64(end), Fraction(end), np.array(end), np.longdouble(end)):
            assert go(t=t).tolist() == row.tolist()
        assert elsewhere(t=end).tolist() == row.tolist()


def test_a_motion_at_rest_and_outputs_that_hardly_move():
    still = polhode.top(moments=[3, 2, 1], weight=0, omega=[0, 0, 0], gamma=[0, 0, 1], end=1)
    go = polhode.propagator(still, tol=1e-7)
    for times in (np.linspace(0, 1e-300, 101), np.linspace(0, 1, 101), np.linspace(0, 1e100, 101)):
        assert go(t=times).tolist() == [[0, 0, 0, 0, 0, 1]] * 101
