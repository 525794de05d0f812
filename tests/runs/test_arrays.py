"""Arrays in, arrays out: rows that depend on nothing beside them; what is no array of starts."""

import signal
import time
from fractions import Fraction
from functools import partial

import numpy as np
import pytest

import polhode
from shared.motions import TURNED, rows_in_quad
from shared.tools import change_memory, change_policy, tiers

EPS = 2.0**-52
BODY = {"moments": [3, 2, 1.5], "centre": [0.25, 0.125, 0.5], "weight": 4}
BODIES = {
    "plain": {},
    "slow": {"weight": 2.0**-20, "omega": [1e-3, 0, 2e-3]},
    "fast": {"weight": 2.0**20, "omega": [1e3, 0, 2e3]},
    "turned": {"moments": None, "inertia": TURNED},
    "symmetric": {"moments": [2, 2, 1], "centre": [0, 0, 1]},
    "free": {"weight": 0, "gamma": None},
    "sphere": {"moments": [1, 1, 1]},
    "free sphere": {"moments": [1, 1, 1], "weight": 0, "gamma": None},
}


def scene(**more):
    start = {"omega": [0.5, -0.25, 2], "gamma": [0, 0, 1]}
    return polhode.top(**BODY | start | {"end": 1} | more, name="top")


def starts(count: int, width: int = 6, size: float = 1.0, seed: int = 1, kind=np.float64):
    rng = np.random.default_rng(seed)
    omega, gamma = (rng.normal(size=(count, 3)).astype(kind) for _ in range(2))
    gamma /= np.sqrt((gamma * gamma).sum(axis=1))[:, None]
    return np.hstack([omega * kind(size), gamma])[:, :width]


def of(name: str, count: int = 45):
    """A propagator of a body, starts, and times that are not too many steps."""
    go = polhode.propagator(scene(**BODIES[name]))
    unit = 2.0**go.scene.time_unit
    rows = starts(count, len(go.scene.columns), 2 / unit)
    rows[3] = rows[4]
    return go, rows, unit


@pytest.mark.parametrize(
    ("way", "name"),
    tiers([(1, "plain"), (-1, "fast"), (1, "free")], [(-1, "plain"), (1, "turned"), (-1, "free")]),
)
def test_a_row_depends_neither_on_its_neighbours_nor_on_threads_nor_on_other_times(
    name, way, monkeypatch
):
    go, rows, unit = of(name)
    times = way * unit * np.array([0, 0.5, 3, 20])
    found = go(rows, t=times)
    assert (go.steps, go.outcome) == (None, polhode.Outcome.REACHED_END)
    assert go.outcomes == (polhode.Outcome.REACHED_END,) * len(rows)
    assert found.shape == (len(rows), 4, len(go.scene.columns))
    assert np.array_equal(found[3], found[4])
    for k in (0, 7, 44):
        assert np.array_equal(go(rows[k : k + 1], t=times)[0], found[k])
    order = np.random.default_rng(2).permutation(len(rows))
    assert np.array_equal(go(rows[order], t=times), found[order])
    assert np.array_equal(go(rows, t=times.tolist()), found)
    end = go(rows, t=float(times[-1]))
    assert np.array_equal(end, found[:, -1])
    assert np.array_equal(go(rows, t=times[[0, -1]]), found[:, [0, -1]])
    near = [*np.abs(found[:, 0] - rows).max(axis=0)]
    assert max(near) <= (4 * EPS * np.abs(rows).max() if name == "turned" else 0)
    monkeypatch.setattr("polhode.taylor.lanes._SHARED", 0.0)
    monkeypatch.setattr("polhode.taylor.lanes._ALONE", 2)
    for workers in (None, 1, 2, 3):
        assert np.array_equal(go(rows, t=times, workers=workers), found)
        assert np.array_equal(go(rows, t=float(times[-1]), workers=workers), end)
    monkeypatch.setattr("polhode.taylor.lanes._SURE", 0.0)  # the careful way
    assert np.array_equal(go(rows, t=times), found)
    assert np.array_equal(go(rows, t=float(times[-1])), end)


@pytest.mark.parametrize("way", [1, -1])
def test_a_long_way_in_stretches_is_that_in_one(way, monkeypatch):
    """Whichever times are asked for on it; the time begins again at each stretch."""
    go, rows, unit = of("free", 9)
    times, rows = way * unit * np.array([30, 100, 249, 250, 333]), rows / 8
    whole = go(rows, t=times)
    change_policy(monkeypatch, chunk=400)  # 100 units each
    found = go(rows, t=times)
    assert 0 < np.abs(found - whole).max() < 1e-10
    assert np.array_equal(go(rows, t=times[[0, -1]]), found[:, [0, -1]])
    assert np.array_equal(go(rows[::-1], t=times[2:])[::-1], found[:, 2:])
    assert np.array_equal(go(rows, t=float(times[-1])), found[:, -1])
    many = polhode.integrate_many(go.scene, starts=rows, at=times[[1, -1]])
    assert np.abs(many.states - found[:, [1, -1]]).max() < 1e-10
    assert many.reached == (Fraction(times[-1]),) * 9


@pytest.mark.usefixtures("compiled_as_for_users")
@pytest.mark.parametrize(
    "name", tiers(["plain", "slow", "turned", "free"], ["fast", "symmetric", "sphere"])
)
def test_rows_are_as_right_as_starts_alone(name):
    """Errors against 113 bits, after 8 units of time, are those of a start alone."""
    go, rows, unit = of(name, 5)
    found = go(rows, t=8 * unit)
    true = rows_in_quad(go.scene, rows, 8 * unit)
    size = np.array([1 / unit] * 3 + [1] * (rows.shape[1] - 3))
    alone = np.array([go(row, t=8 * unit) for row in rows])
    errors, others = (np.abs((x - true) / size).max(axis=1) for x in (found, alone))
    assert EPS / 4 < np.median(errors) < 24 * EPS
    assert np.median(errors) < 2 * np.median(others) + EPS
    assert errors.max() < 2000 * EPS


@pytest.mark.parametrize(
    ("number", "project"), [("extended", False), ("extended", 16), ("double", 16)]
)
def test_what_does_not_go_in_lanes_goes_row_by_row(number, project):
    go = polhode.propagator(scene(), number=number, project=project)
    kind = np.longdouble if number == "extended" else np.float64
    rows = starts(5, kind=kind)
    many = go(rows, t=[1, 3])
    assert (many.dtype, many.shape, go.steps) == (kind, (5, 2, 6), None)
    for k, row in enumerate(rows):
        assert np.array_equal(go(row, t=[1, 3]), many[k])
        assert go.outcomes == (go.outcome,)
    assert np.array_equal(go(rows, t=3.0), many[:, 1])


def test_rows_of_narrower_numbers_lists_and_none_at_all():
    go = polhode.propagator(scene())
    rows = [[1, 0, k, 0, 0, 1] for k in range(9)]
    found = go(np.array(rows, float), t=1.0)
    for given in (rows, np.array(rows), np.array(rows, np.float32), tuple(map(tuple, rows))):
        assert np.array_equal(go(given, t=1.0), found)
    assert go(np.empty((0, 6)), t=1.0).shape == (0, 6)
    assert go(np.empty((0, 6)), t=[1, 2]).shape == (0, 2, 6)
    assert (go.outcomes, go.outcome.done) == ((), True)
    again = found.copy()
    go(np.array(rows, float), t=1.0)[:] = 7
    assert np.array_equal(go(rows, t=1.0), again)


def test_a_row_that_does_not_arrive_is_nan_and_harms_no_other():
    go, rows, _ = of("plain", 21)
    right = go(rows, t=[1, 4])
    go._most = 900
    rows[[5, 13], :3] = 3e3, 0, 2e3
    found = go(rows, t=[1, 4])
    lost = np.isin(np.arange(21), [5, 13])
    assert np.isnan(found[lost, 1]).all()
    assert np.array_equal(found[~lost], right[~lost])
    ended = [polhode.Outcome.STEP_LIMIT if k else polhode.Outcome.REACHED_END for k in lost]
    assert list(go.outcomes) == ended
    assert go.outcome is polhode.Outcome.STEP_LIMIT
    assert np.array_equal(go(rows[~lost], t=4.0), right[~lost, 1])
    assert go.outcome.done


@pytest.mark.parametrize("t", [3.0, [1, 3]], ids=["one time", "times"])
def test_a_row_that_is_far_too_fast_is_given_up_within_its_stretch(t, monkeypatch):
    """It would have taken the whole limit, twice: minutes."""
    monkeypatch.setattr("polhode.taylor.batches.BLOCK", 500)
    change_policy(monkeypatch, chunk=500)
    go, rows, _ = of("plain", 21)
    go._most = 5 * 10**6  # steps; some 10^10 would be needed
    right, begin = go(rows, t=t), time.process_time()
    rows[9, :3] = 1e9
    found, others = go(rows, t=t), np.arange(21) != 9
    assert np.array_equal(found[others], right[others])
    assert np.isnan(found[9]).all()
    assert time.process_time() - begin < 5
    assert go.outcomes[9] is go.outcome is polhode.Outcome.STEP_LIMIT
    many = polhode.integrate_many(go.scene, starts=rows, at=[1, 3])
    assert many.outcomes[9] is polhode.Outcome.STEP_LIMIT
    assert many.steps[9] <= 2000


@pytest.mark.parametrize("number", ["double", "extended"])
def test_a_bound_of_steps_that_is_too_low_breaks_no_limit(number, monkeypatch):
    go, rows, _ = of("plain", 11)
    rows[3, :3] *= 30
    asked = {"starts": rows, "at": [1, 4], "max_steps": 40, "number": number}
    if number == "extended":
        asked["starts"] = np.full((1, 6), [30, 0, 20, 0, 0, 1], dtype=np.longdouble)
    careful = polhode.integrate_many(go.scene, **asked)
    monkeypatch.setattr("polhode.taylor.lanes.STEPS", 0.0)
    quick = polhode.integrate_many(go.scene, **asked)
    assert polhode.Outcome.STEP_LIMIT in quick.outcomes
    for what in ("outcomes", "steps", "reached"):
        assert getattr(quick, what) == getattr(careful, what)
    assert np.array_equal(quick.states, careful.states, equal_nan=True)


@pytest.mark.parametrize("rate", [1e9, 1], ids=["expected", "not expected"])
def test_a_row_that_is_not_finite_stops_no_other(rate, monkeypatch):
    """heyoka stops all lanes with the first that is not finite, and says success of the others."""
    go, rows, _ = of("plain", 21)
    right = go(rows, t=[1, 4])
    monkeypatch.setattr("polhode.taylor.lanes.rates", lambda x, *_: 0 * x[:, 0] + rate)
    rows[9, :3] = 1e160, 1e150, -1e155
    for t, part in (([1, 4], slice(None)), (4.0, 1)):
        found = go(rows, t=t)
        others = np.arange(21) != 9
        assert np.array_equal(found[others], right[others, part])
        assert np.isnan(found[9]).all()
        assert go.outcomes[9] is go.outcome is polhode.Outcome.NON_FINITE
        assert sum(x.done for x in go.outcomes) == 20


def interrupt_in(function):
    """A signal's handler: Ctrl-C in a function; a signal before or after it comes once more."""

    def handler(_, frame):
        while frame is not None:
            if frame.f_code is function.__code__:
                raise KeyboardInterrupt
            frame = frame.f_back
        signal.setitimer(signal.ITIMER_REAL, 0.003)

    return handler


def again_and_again(call):
    for _ in range(1000):
        call()


@pytest.mark.parametrize(("end", "count"), tiers([(400.0, 20)], [(60.0, 3000), (1e7, 40)]))
def test_ctrl_c_ends_many_rows_and_leaves_the_propagator_usable(end, count):
    go, rows, _ = of("plain", count)
    right = go(rows[:9], t=3.0)
    before = signal.signal(signal.SIGALRM, interrupt_in(type(go)._many))
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.02)
        with pytest.raises(KeyboardInterrupt):
            again_and_again(lambda: go(rows, t=end))
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert (go.outcome, go.outcomes) == (go.outcome.INTERRUPTED, (go.outcome.INTERRUPTED,))
    assert np.array_equal(go(rows[:9], t=3.0), right)


@pytest.mark.parametrize("first", [1, 2])
def test_ctrl_c_is_told_wherever_a_call_is(first):
    """While the start is read, too; of one start and of many."""
    go, rows, _ = of("plain", 9)
    go(rows, t=3.0)

    class Rows:
        shape, ndim = rows.shape, first

        def __array__(self, *_, **__):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        go(Rows(), t=3.0)
    assert (go.outcome, go.outcomes) == (go.outcome.INTERRUPTED, (go.outcome.INTERRUPTED,))


# -- sweeps ---------------------------------------------------------------------------------------

UNITS = np.array([[0, 0, 1.0], [0, -1, 0], [1, 0, 0]])  # of length 1 exactly


def listed(columns, count: int):
    """The same members one by one, by exact values."""
    return [
        {
            (f"{key}[{i + 1}]" if rows.shape[1] > 1 else key): x
            for key, rows in columns.items()
            for i, x in enumerate(rows[k].tolist())
        }
        for k in range(count)
    ]


COUNT = 150  # of more than a batch in each job


def columns_of(*keys: str, count: int = COUNT):
    rng = np.random.default_rng(5)
    scale = np.exp(2 * rng.normal(size=(count, 1)))
    every = {
        "start.omega": rng.normal(size=(count, 3)) * scale,
        "start.gamma": UNITS[rng.integers(0, 3, count)],
        "body.moments": 0.2 * np.abs(rng.normal(size=(count, 3))) + [2, 2.2, 2.4],
        "body.centre": rng.normal(size=(count, 3)),
        "body.weight": rng.normal(size=(count, 1)) * scale,
    }
    return {key: every[key] for key in keys}


@pytest.mark.parametrize(
    ("body", "keys", "at"),
    tiers(
        [
            ("plain", ["start.omega", "start.gamma"], [2]),
            ("turned", ["start.omega", "start.gamma"], [2]),
            ("plain", ["start.omega", "start.gamma", "body.moments", "body.weight"], [0, -1, -5]),
        ],
        [
            ("plain", ["start.omega"], [2]),
            ("symmetric", ["start.gamma", "start.omega"], [2]),
            ("plain", ["body.moments", "body.centre", "body.weight"], [0, -1, -5]),
        ],
    ),
)
def test_members_of_arrays_are_those_of_exact_values_to_the_bit(body, keys, at):
    """Coefficients are rounded once, units are each member's own."""
    columns = columns_of(*keys)
    if body == "free":
        columns.pop("start.gamma", None)
    told = scene(**BODIES[body])
    one, many = (polhode.integrate_many(told, x, at=at) for x in (listed(columns, COUNT), columns))
    assert np.array_equal(one.states, many.states)
    assert np.array_equal(one.counts, many.counts)
    assert [*map(tuple, one.varied.rows)] == [*map(tuple, many.varied.rows)]
    assert (many.complete, many.reached) == (True, one.reached)
    for k in (0, COUNT // 2, COUNT - 1):
        alone = {key: rows[k : k + 1] for key, rows in columns.items()}
        assert np.array_equal(polhode.integrate_many(told, alone, at=at).states[0], many.states[k])
        assert many[k].scene.body == one[k].scene.body
        assert many[k].scene.omega == one[k].scene.omega


def test_starts_are_arrays_of_omega_and_gamma_in_any_order_and_number(tmp_path):
    rows = starts(50)
    many = polhode.integrate_many(scene(), starts=rows, at=[0, 1, 3])
    same = {"start.omega": rows[:, :3], "start.gamma": rows[:, 3:]}
    assert many == polhode.integrate_many(scene(), same, at=[0, 1, 3], workers=1)
    assert np.array_equal(many.states[:, 0], rows)
    back = polhode.integrate_many(scene(), starts=rows[::-1], at=[0, 1, 3])
    assert np.array_equal(back.states[::-1], many.states)
    few = polhode.integrate_many(scene(), starts=rows[7:9].tolist(), at=[0, 1, 3])
    assert np.array_equal(few.states, many.states[7:9])
    other = scene(gamma=None, angles=[0, 0.5, 1])  # whatever its own start is
    angles = polhode.integrate_many(other, starts=rows, at=[3])
    assert np.array_equal(angles.states[:, 0], many.states[:, 2])
    bodies = polhode.integrate_many(
        scene(), {"body.weight": np.full((50, 1), 4.0)}, starts=rows, at=[0, 1, 3]
    )
    assert np.array_equal(bodies.states, many.states)
    none = polhode.integrate_many(scene(), starts=np.empty((0, 6)), at=[1, 2])
    assert (len(none), none.states.shape, none.complete, list(none)) == (0, (0, 2, 6), True, [])
    assert none.drift.shape == (0, 4)
    none.save(tmp_path / "none.npz")
    assert polhode.load_result(tmp_path / "none.npz").column("start.omega[1]").shape == (0,)


@pytest.mark.parametrize("centre", [["pi/4", 0, 1], [0.25, 0, 1]], ids=["irrational", "rational"])
def test_members_begin_at_the_floats_of_an_array_also_where_they_are_read_as_scenes(centre):
    above = float(np.nextafter(np.nextafter(0.8, 1), 1))  # |gamma|² is 1 to 2 eps
    rows = np.array([[1, 0, 2, 0.6, above, 0], [0.5, 1, 2, -above, 0, 0.6]])
    moments = np.array([[2, 1.5, 1], [2, 1.75, 1]])
    many = polhode.integrate_many(
        scene(centre=centre), {"body.moments": moments}, starts=rows, at=[0]
    )
    assert (many.states[:, 0] == rows).all()


def test_a_unit_of_time_next_to_a_power_of_two_is_the_exact_one_for_rows_too():
    root = float(Fraction("0.99951136071412980"))  # the fourth one of 1 - 1/512
    rates = root + np.array([-9e-10, -1e-10, 0, 1e-10, 9e-10])
    rows = np.zeros((5, 3))
    rows[:, 0] = rates
    told = scene(weight=0, gamma=None, omega=[1, 0, 0])
    exact = listed({"start.omega": rows}, 5)
    one, many = (polhode.integrate_many(told, x, at=[9]) for x in (exact, {"start.omega": rows}))
    assert np.array_equal(one.states, many.states)


@pytest.mark.parametrize("body", ["plain", "turned", "symmetric"])
def test_a_member_of_an_array_is_an_exact_scene_when_asked_for(body):
    rows = starts(20)
    many = polhode.integrate_many(scene(**BODIES[body]), starts=rows, at=[0, 1, 3])
    assert many.provenance.get("notes") is None
    for k in (0, 19):
        member = many[k].scene
        assert member.omega == tuple(map(Fraction, rows[k, :3]))
        assert sum(x * x for x in member.gamma) == 1
        assert np.abs(np.array([float(x) for x in member.gamma]) - rows[k, 3:]).max() <= EPS
        alone = polhode.integrate(member, project=False)
        assert np.abs(alone.states - many[k].states).max() < 40 * EPS


@pytest.mark.parametrize("body", [BODIES["turned"], {"moments": ["sqrt(10)", 2, "sqrt(2)"]}])
@pytest.mark.parametrize("column", [{"start.omega[1]": ["1/3"]}, {"start.omega": np.eye(3)}])
def test_the_drift_of_members_with_irrational_moments_is_told(body, column):
    """It gave a traceback: of irrational moments times columns of rationals."""
    many = polhode.integrate_many(scene(**body), column, at=[1])
    assert 0 < many.drift[0, 0] < 8 * EPS


# -- what is no array of starts -------------------------------------------------------------------


def changed(row: int, column: int, x: float):
    found = starts(9)
    found[row, column] = x
    return found


LONG, LONGER = 2**53 + 1, 2**63 + 1
MASKED = np.ma.array([1.0, 0, 0, 0, 0, 1], mask=[0, 1, 0, 0, 0, 0])
ROWS = [
    (changed(3, 1, np.nan), "row 4 = .*: expected finite numbers"),
    (changed(8, 5, np.inf), "row 9 = .*: expected finite numbers"),
    (changed(2, 4, 0.5), r"row 3 = .*: expected gamma of length 1, to 8 eps"),
    (starts(9) * [1, 1, 1, 1 + 2e-15, 1 + 2e-15, 1 + 2e-15], r"row 1 = .*: expected gamma of le"),
    (starts(9).astype(np.longdouble), "numbers of (float128|longdouble): expected float64"),
    (starts(9).astype(complex), "numbers of complex128: expected float64 or narrower"),
    (starts(9).astype(str), "numbers of <U32: expected float64 or narrower"),
    (starts(9).astype(object), "numbers of object: expected float64 or narrower"),
    ([[LONG, 0, 0, 0, 0, 1]], f"row 1 = .{LONG}, .*: expected finite numbers that float64 holds"),
    ([[1, 0.5, 0, 0, 0, 1], [LONG, 0.5, 0, 0, 0, 1]], f"row 2 = .{LONG}, 0.5, .*: expected fin"),
    ([[LONGER, 0, 0, 0, 0, 1]], f"row 1 = .{LONGER}, 0, .*: expected finite numbers that float64"),
    ([[2**52, -(2**53), 0, 0, 0, 1], [LONGER, -1, 0, 0, 0, 1]], f"row 2 = .{LONGER}, -1, .*: exp"),
    ([MASKED.data, MASKED], r"row 2 = .1.0, None, .*: expected finite numbers that float64 h"),
    (starts(9)[:, :5], r"shape \(9, 5\): expected shape \(N, 6\)"),
    (starts(9)[:, :3], r"shape \(9, 3\): expected shape \(N, 6\)"),
    (starts(9)[None], r"shape \(1, 9, 6\): expected shape \(N, 6\)"),
    (np.ma.array(starts(2), mask=[[0] * 6, [0, 1, 0, 0, 0, 0]]), "row 2 = .*: expected finite"),
]


@pytest.mark.parametrize(("rows", "said"), ROWS, ids=range(len(ROWS)))
def test_what_is_no_array_of_starts_is_refused_in_one_line_by_both_doors(rows, said):
    go, t = polhode.propagator(scene()), 2.0**-60
    right = go(starts(3), t=1.0)
    asked = [lambda: go(rows, t=t), lambda: polhode.integrate_many(scene(), starts=rows, at=[t])]
    for call in asked:
        with pytest.raises(polhode.BadInput, match=said) as fault:
            call()
        assert "\n" not in str(fault.value)
        assert str(fault.value).startswith("top: start")
    assert np.array_equal(go(starts(3), t=1.0), right)


def test_gamma_is_of_length_1_to_8_eps_exactly():
    """On both sides of the bound, where rounding hides which."""
    go = polhode.propagator(scene())
    for ulps in range(20):
        length = 1 + ulps * EPS / 2
        rows = np.array([[1, 0, 0, 0, 0, length]])
        square = Fraction(length) ** 2 - 1
        if square <= 8 * Fraction(EPS):
            many = polhode.integrate_many(scene(), starts=rows, at=[0])
            assert many.states[0, 0, 5] == go(rows, t=0.0)[0, 5] == length
            assert go(rows[0], t=0.0)[5] == length
            assert many[0].scene.gamma == (0, 0, 1)
        else:
            for call in (
                partial(go, rows, t=0.0),
                partial(go, rows[0], t=0.0),
                partial(polhode.integrate_many, scene(), starts=rows, at=[0.0]),
            ):
                with pytest.raises(polhode.BadInput, match="gamma of length 1, to 8 eps"):
                    call()


TWO = np.linspace(0, 1, 5)
MANY = np.arange(80)[:, None] // 79.0
OMEGA = {"start.omega": np.zeros((5, 3))}
VARIED = [
    ({"start.omega[1]": TWO, "start.omega[2]": TWO}, r"\[:, None\] on both for member by member"),
    ({"start.omega[1]": TWO, "body.weight": TWO}, r"or .tolist\(\) on both for every combination"),
    ({"start.omega[1]": TWO, "body.weight": TWO}, r"body.weight = two arrays of 5 numbers \(start"),
    ({"start.omega": TWO[:3]}, "vary = start.omega: expected a number of the scene"),
    ({"start.omega": np.zeros((5, 2))}, r"start.omega = .*\(5, 2\): expected shape \(N, 3\)"),
    ({"start.omega[1]": np.zeros((5, 2))}, r"start.omega\[1\] = .*expected shape \(N, 1\)"),
    (OMEGA | {"body.weight": [1, 2]}, r"body.weight = \[1, 2\]: expected an array with a row for "),
    (OMEGA | {"body.weight": "0:1:5"}, "body.weight = 0:1:5: .* never every combination"),
    (OMEGA | {"start.omega[2]": np.ones(5)}, r"start.omega\[2\], given twice: expected each"),
    (OMEGA | {"body.weight": np.ones(4)}, "4 rows: expected 5 rows, as many as start.omega has"),
    (OMEGA | {"start.omga": np.ones((5, 1))}, "vary = start.omga: expected a number of the scene"),
    (OMEGA | {"body.weight": np.full((5, 1), np.nan)}, "body.weight, row 1 = .nan.: expected fin"),
    ({"body.moments": [2, 3, 4] + MANY * [0, 0, 2]}, r"member 80 .*body.moments = \[2, 3, 6\]"),
    ({"body.moments": [2, 3, 4] - MANY * [0, 0, 8]}, "member 80 .*body.moments"),
    ({"start.omega": np.full((2, 3), 1e-320)}, "member 1 .*expected a type of wider range"),
]


@pytest.mark.parametrize(("given", "said"), VARIED, ids=range(len(VARIED)))
def test_arrays_that_cannot_be_varied_are_refused_in_one_line(given, said):
    with pytest.raises(polhode.BadInput, match=said) as fault:
        polhode.integrate_many(scene(), given, at=[1])
    assert "\n" not in str(fault.value)


def test_an_array_of_numbers_beside_rows_is_one_of_rows():
    rows = np.ones((5, 3))
    given = [{"start.omega": rows, "body.weight": x} for x in (TWO, TWO[:, None])]
    one, other = (polhode.integrate_many(scene(), x, at=[1]) for x in given)
    assert one == other
    assert len(one) == 5
    product = {"start.omega[1]": TWO.tolist(), "body.weight": TWO.tolist()}
    assert len(polhode.integrate_many(scene(), product, at=[1])) == 25
    other = {"start.omega[1]": TWO, "body.weight": TWO[:3]}  # cannot be meant row by row
    assert len(polhode.integrate_many(scene(), other, at=[1])) == 15


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"number": "quad"}, "number = quad: expected double or extended with arrays"),
        ({"number": "extended"}, "expected gamma of length 1, to 8 eps"),  # of extended
        ({"digits": 30}, "number = quad: expected double or extended with arrays"),
        ({"vary": [{"body.weight": 1}]}, "vary = a list: expected arrays of the body's numbers"),
        (
            {"vary": {"start.omega[1]": TWO}},
            r"vary = start.omega\[1\]: expected numbers of the bod",
        ),
        ({"vary": {"body.weight": [1, 2]}}, "never every combination"),
        ({"starts": None}, "vary: expected numbers to vary, or starts"),
    ],
)
def test_options_that_arrays_do_not_go_with(options, said):
    with pytest.raises(polhode.BadInput, match=said):
        polhode.integrate_many(scene(), **{"starts": starts(3), "at": [1]} | options)


def test_what_has_no_order_is_no_sequence_of_numbers():
    for call in (
        lambda: polhode.integrate_many(scene(), starts=starts(3), at={1, 2}),
        lambda: polhode.integrate_many(scene(), {"body.weight": {1, 2}}, at=[1]),
        lambda: scene(end=None, at=frozenset({1, 2})),
        lambda: polhode.integrate(scene())({1: 2}.keys()),
    ):
        with pytest.raises(polhode.BadInput, match=r"^[^\n]*$"):
            call()


def test_too_many_numbers_are_refused_before_anything_is_integrated(monkeypatch):
    go = polhode.propagator(scene())
    change_memory(monkeypatch, 10_000)
    with pytest.raises(polhode.BadInput, match="9 starts at 40 times: expected at most"):
        go(starts(9), t=np.linspace(1, 2, 40))
    with pytest.raises(polhode.BadInput, match="9 members at 40 times: expected at most"):
        polhode.integrate_many(scene(), starts=starts(9), at=np.linspace(1, 2, 40))


@pytest.mark.parametrize("workers", [0, -1, 1.5, "2"])
def test_what_is_no_number_of_threads(workers):
    with pytest.raises(polhode.BadInput, match="workers"):
        polhode.propagator(scene())(starts(3), t=1.0, workers=workers)
