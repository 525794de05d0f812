"""A sweep planned in columns is the sweep planned member by member, to the bit."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import polhode
from polhode.equations import integrals
from polhode.numbers.conversion import exactly, to_mpf
from polhode.runs.sweep import lanes, turned_columns
from polhode.runs.sweep import plan as sweep_plan
from polhode.scenes import scene_file
from polhode.scenes.variation import sweep_columns
from shared.motions import heavy, heavy_file


def planned(scene, vary, number=None):
    return sweep_plan.planned(scene, vary, number, None, None, None)


def same_plan(a, b) -> bool:
    tables = zip((*a.lanes, a.time_units), (*b.lanes, b.time_units), strict=True)
    return a.names == b.names and all(np.array_equal(x, y) for x, y in tables)


SWEEPS = [
    {"start.omega[3]": "0.1:37:101"},
    {"start.omega[1]": ["1/3", "-1e-3", 0], "body.weight": "-2:2:7"},
    {"body.moments[2]": "2:6:11", "body.centre[1]": ["0", "1/7"]},
    {"body.weight": [10, 100, 10000]},  # faster than the start
    {"start.omega[2]": ["sqrt(2)", "1/3"], "body.weight": [1, "pi", 0]},
    [{"start.omega[1]": k, "body.weight": f"1/{k}"} for k in (1, 2, 3)],
    {"start.gamma[1]": ["2/7"], "start.gamma[3]": ["6/7", "-6/7"]},
]


@pytest.mark.parametrize("number", ["double", "extended", "quad"])
@pytest.mark.parametrize("vary", SWEEPS)
def test_columns_plan_what_members_plan(vary, number, monkeypatch):
    scene = heavy()
    quick = planned(scene, vary, number)
    asked = []
    monkeypatch.setattr(sweep_columns.Columns, "readable", False)
    one = lanes._Made.one
    monkeypatch.setattr(lanes._Made, "one", lambda made, k: asked.append(k) or one(made, k))
    assert same_plan(quick, planned(scene, vary, number))
    assert len(asked) == len(quick.members)


TILTED = {"inertia": [[3, "1/4", 0], ["1/4", 2.5, "1/8"], [0, "1/8", 1.5]]}
TURNED = {  # about axis 3, rational; about another one
    "irrational": TILTED,
    "rational": {"inertia": [[3, 0, 0], [0, "5/2", "1/2"], [0, "1/2", "5/2"]]},
    "exchanged": {"inertia": [[2, 1, 0], [1, 2, 0], [0, 0, 3]]},
}
TURNED_SWEEPS = [
    {"start.omega[3]": "0.1:37:101"},
    {"start.omega[1]": ["1/3", "-1e-3", 0, "1e-200", "1e60"], "body.weight": "-2:2:7"},
    {"body.centre[1]": ["0", "1/7", -1], "start.omega[2]": ["sqrt(2)", "1/3", "-1/10"]},
    {"start.omega[1]": ["1/10"], "start.omega[2]": ["-1/10"], "start.omega[3]": [0, 1]},
    {"start.gamma[1]": ["2/7"], "start.gamma[3]": ["6/7", "-6/7"]},
]


@pytest.mark.parametrize("vary", TURNED_SWEEPS, ids=range(len(TURNED_SWEEPS)))
@pytest.mark.parametrize("body", TURNED)
def test_a_turned_body_is_planned_in_columns_to_the_bit_of_its_members(body, vary, monkeypatch):
    scene = polhode.top(
        **TURNED[body],
        **{"centre": ["1/3", "1/5", "1/2"], "weight": 2, "omega": ["3/10", "2/5", "11/10"]},
        **{"gamma": ["2/7", "3/7", "6/7"], "end": 3, "samples": 3},
    )
    asked, one = [], lanes._Made.one
    monkeypatch.setattr(lanes._Made, "one", lambda made, k: asked.append(k) or one(made, k))
    quick = planned(scene, vary)
    singly = len(asked)
    monkeypatch.setattr(sweep_columns.Columns, "readable", False)
    assert same_plan(quick, planned(scene, vary))
    assert len(asked) - singly == len(quick.members)
    if vary is TURNED_SWEEPS[0]:
        assert singly < 3


def test_a_component_next_to_a_tie_is_left_to_its_member():
    from polhode.numbers.double_double import Pairs

    near = np.array([1.5, 1.5, 1.5, -1.5, 1.0, 1e-300, 1.5])
    rest = np.array([2.0**-53, 2.0**-54, 0, -(2.0**-53), 0, 0, 2.0**-53 - 2.0**-90])
    error = np.array([2.0**-98] * 6 + [2.0**-88])
    unsure = turned_columns.Turned(Pairs(near, rest), error).unsure
    assert unsure.tolist() == [True, False, False, True, True, True, True]


@pytest.mark.parametrize("number", ["double", "extended"])
def test_states_of_a_turned_body_are_those_of_its_members_to_the_bit(number):
    scene = polhode.top(
        **TILTED,
        **{"centre": ["1/3", "1/5", "1/2"], "weight": 2, "omega": ["3/10", "2/5", "11/10"]},
        **{"gamma": ["2/7", "3/7", "6/7"], "end": 3, "samples": 3},
    )
    vary = {"start.omega[1]": ["1/10", 1, 400, "1e-7"], "body.weight": [1, 1000]}
    many = polhode.integrate_many(scene, vary, number=number, workers=1)
    for states, member in zip(many.states, many.members, strict=True):
        alone = polhode.integrate(member.at(scene.times), number, project=False).states
        error = np.abs(states - alone).max() / np.abs(alone).max()
        assert error < 2**-36  # some hundred turns
        assert states[0].tolist() == alone[0].tolist()  # nothing but turned there and back


HIDDEN = {
    "about the centre": (
        {"inertia": [[2, 0.5, 0], [0.5, 2.5, 0], [0, 0, 2]], "about": "centre", "mass": 1, "g": 3},
        "body.centre[1]",
    ),
    "two equal moments": ({**TURNED["exchanged"], "weight": 2}, "body.centre[1]"),
    "a mass": (
        {"inertia": [[2, 0.5, 0], [0.5, 2.5, 0], [0, 0, 2]], "about": "centre", "mass": 1, "g": 3},
        "body.mass",
    ),
}


@pytest.mark.parametrize("body", HIDDEN)
def test_axes_that_turn_though_no_inertia_is_varied(body):
    given, key = HIDDEN[body]
    scene = polhode.top(
        **given,
        **{"centre": ["1/3", "1/5", "1/2"], "omega": ["3/10", "2/5", "11/10"]},
        **{"gamma": ["2/7", "3/7", "6/7"], "end": 3, "samples": 3},
    )
    vary = {key: ["1/7", 1, 2]}
    found = polhode.integrate_many(scene, vary, workers=1)
    kept = polhode.reduce_many(scene, vary, keep=["final", "first equator"])
    met = []
    for k, member in enumerate(found.members):
        alone = polhode.integrate(member.at(scene.times), project=False).states
        assert np.abs(found.states[k] - alone).max() < 2**-40
        final = [kept[f"final {name}"][k] for name in scene.columns]
        assert np.abs(np.array(final) - alone[-1]).max() < 2**-40
        own = polhode.reduce_many(member.at(scene.times), {"start.psi": [0]}, keep="first equator")
        for name in own.names:  # both nan where it does not come
            assert np.allclose(kept[name][k], own[name][0], rtol=0, atol=2**-40, equal_nan=True)
            met.append(own[name][0])
    assert np.isfinite(met).sum() > 6


TABLES = {
    "angles and omega": 'angles = [0, "pi/3", "1/5"]\nomega = [0.3, 0.4, 1.1]',
    "angles and rates": 'angles = [0, "pi/3", "1/5"]\nrates = [0, 1, 5]',
    "quaternion": "quaternion = [1, 0.1, 0.2, 0.3]\nomega = [0.3, 0.4, 1.1]\nnormalise = true",
    "level": 'gamma = ["2/7", "3/7", "6/7"]\nh = 3\nf = 2\nsign = "+"',
}


@pytest.mark.parametrize(
    ("start", "key", "values"),
    [
        ("angles and omega", "start.angles[2]", ["1", "1/2"]),
        ("angles and rates", "start.rates[3]", [5, 6]),
        ("quaternion", "start.quaternion[2]", ["1/10", "1/5"]),
        ("level", "start.h", [3, 4]),
        ("level", "body.weight", [1, 2]),
    ],
)
def test_a_start_of_another_kind_is_left_to_its_scenes(start, key, values):
    text = (
        "schema = 1\n[body]\nmoments = [2, 3, 4]\ncentre = [0.3, 0.2, 0.5]\nweight = 1\n"
        f"[start]\n{TABLES[start]}\n[run]\nend = 1\n"
    )
    found = polhode.integrate_many(scene_file.parse(text), {key: values}, at=[0])
    for k, member in enumerate(found.members):
        assert np.allclose(found.states[k, 0], [float(x) for x in member.start], rtol=2**-52)
    assert not np.allclose(found.states[0], found.states[1], rtol=1e-3)


def test_axes_that_turn_from_member_to_member():
    """A diagonal inertia matrix, of which an entry off the diagonal is varied."""
    scene = scene_file.parse(
        heavy_file().replace("moments = [2, 3, 4]", "inertia = [[2, 0, 0], [0, 3, 0], [0, 0, 4]]")
    )
    found = polhode.integrate_many(scene, {"body.inertia[1][2]": [0, "0.5"]}, at=[1])
    for member in found:
        single = polhode.integrate(member.scene)
        assert np.allclose(member.states, single.states, rtol=0, atol=64 * 2.0**-52)
    assert not np.allclose(found.states[0], found.states[1], rtol=0, atol=1e-3)


def test_most_members_need_no_scene(monkeypatch):
    asked = []
    one = lanes._Made.one
    monkeypatch.setattr(lanes._Made, "one", lambda made, k: asked.append(k) or one(made, k))
    planned(heavy(), {"start.omega[3]": "0.5:1.5:1000", "body.weight": [1, "sqrt(2)", 0]})
    assert 1000 <= len(asked) < 1020  # those of the irrational weight


def test_the_unit_of_time_next_to_a_power_of_two():
    """Where eight bits round to the next power of two the exponent is the scene's own."""
    fourth_root = "0.99951135943"  # of 1 - 1/512
    rates = [f"{fourth_root} + {k}e-10" for k in (-9, -1, 0, 1, 9)] + ["0.999", "1", "1.001"]
    scene = scene_file.parse(
        "schema = 1\n[body]\nmoments = [1, 2, 3]\n[start]\nomega = [1, 0, 0]\n[run]\nend = 1\n"
    )
    plan = planned(scene, {"start.omega[1]": rates})
    assert plan.time_units.tolist() == [m.time_unit for m in plan.members]
    assert len(set(plan.time_units.tolist())) == 2


def test_a_bad_member_is_named_among_many():
    with pytest.raises(polhode.BadInput, match=r"member 5 \(body.moments\[3\] = 6\): body.moments"):
        planned(heavy(), {"body.moments[3]": [2, 3, 4, 5, 6, 7]})


def test_members_of_one_unit_of_time_go_together():
    plan = planned(heavy(), {"start.omega[3]": "0.1:37:200"})
    groups = list(plan.groups(8, 1000))
    assert sorted(np.concatenate(groups).tolist()) == [*range(200)]
    for group in groups:
        assert len(set(plan.time_units[group].tolist())) == 1
        assert (np.diff(plan.rates[group]) <= 0).all()


def test_neighbours_of_another_unit_change_no_bit(monkeypatch):
    """Where a run is cut into stretches depended on the fastest lane beside it."""
    monkeypatch.setattr("polhode.taylor.batches.time_slices._UNITS_PER_STEP", 1)
    from shared.policies import change_policy

    change_policy(monkeypatch, chunk=12)
    alone = polhode.integrate_many(heavy(), {"start.omega[3]": [1]})
    both = polhode.integrate_many(heavy(), {"start.omega[3]": [1, 90]})
    assert np.array_equal(alone.states[0], both.states[0])


def test_the_scene_s_form_does_not_turn_states():
    """States were read out by the scene's form, though all members take the principal one."""
    scene = heavy_file().replace("[run]", '[run]\nform = "momentum"')
    inertia = scene.replace("moments = [2, 3, 4]", "inertia = [[2,0.1,0],[0.1,3,0],[0,0,4]]")
    for text in (scene, inertia):
        many_ = polhode.integrate_many(scene_file.parse(text), {"start.omega[3]": [1]}, at=[0])
        assert np.allclose(many_.states[0, 0, :3], [0.3, 0.4, 1], rtol=2**-50, atol=0)


FREE = polhode.top(moments=[2, 3, 4], omega=["0.3", "0.4", "1.1"], end=1)


@pytest.mark.parametrize(
    ("scene", "vary", "fourth"),
    [
        (heavy(), {"start.omega[3]": ["0.5", 1], "body.weight": ["0", "1/3"]}, [1, 0, 1, 0]),
        ("lagrange/nutation", {"body.weight": [1, 2, 0]}, [1, 1, 1]),
        ("kovalevskaya/generic", {"body.moments[3]": [1, "0.5"]}, [1, 0]),
        ("goryachev-chaplygin/inner-band", {"body.weight": [1, 3]}, [1, 1]),
        ("lagrange/turned-axes", {"body.weight": [1]}, [1]),
        (FREE, {"start.omega[2]": [1, "1/3", "7/5"]}, [1, 1, 1]),  # of omega alone
        (heavy(), {"body.moments[3]": ["3.25"], "body.moments[1]": ["3.5"]}, [0]),  # A the largest
    ],
)
def test_drift_of_all_members_is_the_drift_of_each(scene, vary, fourth):
    """Against 117 bits, one member after the other: to 1e-9 of a drift of a few eps.

    Turned axes are left to each member's own drift, in 64 bits.
    """
    near = 1e-3 if scene == "lagrange/turned-axes" else 1e-9
    found = polhode.integrate_many(scene, vary, at=[0, 3, 7])
    assert (~np.isnan(found.drift[:, 3])).tolist() == [bool(x) for x in fourth]
    for k in range(len(found)):
        rows = [[to_mpf(exactly(x), 53) for x in row] for row in found.states[k]]
        true = integrals.drift(found[k].scene, rows, 53)
        assert [x == x for x in found.drift[k]] == [x is not None for x in true]
        for x, y in zip(found.drift[k], true, strict=True):
            if y is not None:
                assert abs(x - y) <= near * y + 1e-25
    assert 1e-17 < np.nanmax(found.drift) < 1e-14


def test_jobs_travel_as_bytes():
    sent = []

    class Noting:
        def submit(self, fn, /, *arguments):
            from concurrent.futures import Future

            sent.append(arguments)
            future = Future()
            future.set_result(fn(*arguments))
            return future

    many_ = polhode.integrate_many(heavy(), {"start.omega[3]": [1, 2]}, executor=Noting())
    assert many_.done
    assert all([type(x) for x in arguments] == [bytes] for arguments in sent)
    assert pickle.loads(sent[0][0])[0].__name__ == "solve"


def test_an_ensemble_can_be_pickled_and_compared():
    found = polhode.integrate_many(heavy(), {"start.omega[3]": "1:2:3"}, at=[1])
    again = pickle.loads(pickle.dumps(found))
    assert again == found
    assert again[1] == found[1]
    assert found != polhode.integrate_many(heavy(), {"start.omega[3]": "1:3:3"}, at=[1])


@pytest.mark.parametrize(
    ("body", "vary"),
    [
        (TILTED, {"body.inertia[1][1]": ["3"], "start.omega[1]": [1, 5]}),  # not in columns
        ({"moments": [2, 3, 4]}, {"start.omega[1]": ["1", "1e80"]}),  # beyond doubles on the way
        ({"moments": ["2e200", "3e200", "4e200"]}, {"body.weight": ["1e210", "1e-9"]}),
    ],
)
def test_the_fastest_member_is_found_without_a_warning(body, vary):
    """0/0 was computed of members that are left to their scenes."""
    start = {"omega": [1, 1, 1], "gamma": [0, 0, 1]}
    scene = polhode.top(**body, centre=[1, 0, 0], weight=1, **start, end=1)
    members = planned(scene, vary).members
    rates = [member.log10_rate for member in members]
    assert lanes.Fastest(members).scene.log10_rate == max(rates)
    assert len({*rates}) == 2
