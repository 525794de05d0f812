"""Many tops at once: every member is its own run, whatever is varied and however it is planned."""

import ctypes
import pickle
import platform
import time
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.runs import integrate_many as sweep_plan
from polhode.scenes.vary import grid as members_of_grid
from shared.motions import TURNED, free_file, heavy, heavy_file, scene_of
from shared.tools import exactly, tiers


def worst(one, other) -> float:
    """The largest difference of two tables, by the size of each column of the second."""
    one, other = (np.array([[exactly(x) for x in row] for row in rows]) for rows in (one, other))
    sizes = np.maximum(np.abs(other).max(axis=0), Fraction(1, 10**9))
    return float((np.abs(one - other).max(axis=0) / sizes).max())


def assert_own_runs(many: polhode.Ensemble, turned: bool = False) -> None:
    """Each member is the run of its scene: start, times, steps and states within rounding.

    Two starts that differ by one rounding part by some tens of eps on these motions.
    """
    assert many.complete
    assert many.states.shape == (len(many), len(many.times), len(many.columns))
    eps = float(many.number.eps)
    for k, member in enumerate(many):
        scene = replace(member.scene, form="principal")  # as members are, whatever they ask for
        alone = polhode.integrate(scene, many.number, project=False, method="taylor")
        assert member.times == alone.times == many.times
        assert worst(member.states[:1], alone.states[:1]) <= (2 * eps if turned else 0), k
        assert abs(member.steps - alone.steps) <= 5
        assert worst(member.states, alone.states) < (200 + 8 * alone.steps) * eps, k


#: Body, start and run of a scene; a full matrix is about principal axes that are irrational,
#: rational about one axis, or two of which are exchanged.
START = {"omega": ["3/10", "2/5", "11/10"], "gamma": ["2/7", "3/7", "6/7"], "at": [0, 1, 3]}
LEVER = {"centre": ["1/3", "1/5", "1/2"], "weight": 2}
INERTIA = {
    "irrational": TURNED,
    "rational": [[3, 0, 0], [0, "5/2", "1/2"], [0, "1/2", "5/2"]],
    "exchanged": [[2, 1, 0], [1, 2, 0], [0, 0, 3]],
    "own": [[2, 0, 0], [0, 3, 0], [0, 0, 4]],
}
ABOUT = {"inertia": [[2, 0.5, 0], [0.5, 2.5, 0], [0, 0, 2]], "about": "centre", "mass": 1, "g": 3}
MATRIX = {name: polhode.top(inertia=x, **LEVER, **START) for name, x in INERTIA.items()}
BODY = {"moments": [2, 3, 4], "centre": [0.3, 0.2, 0.5], "weight": 1, "at": [0, 1, 3]}
OMEGA = {"omega": [0.3, 0.4, 1.1]}
LAGRANGE = polhode.load("lagrange/nutation").at([0, 1, 3])
MOMENTUM = heavy_file().replace("[run]", '[run]\nform = "momentum"')


def starting(**start) -> polhode.Scene:
    return polhode.top(**BODY, **start)


HUGE = polhode.top(**BODY | {"moments": ["2e200", "3e200", "4e200"]}, gamma=[0, 0, 1], **OMEGA)
#: Whose gamma is of length 1 to rounding.
ARRAYS = {
    "start.omega": np.array([[0.5, -0.25, 2], [0.3, 0.4, 1.1]]),
    "start.gamma": np.array([[1, -2, 2], [2, 3, 6]]) / [[3], [7]],
}
FLAT = {"gamma": ["3/5", "4/5", 0]}
AREAS = [("4/3", -1), ("44/21", "-11/7"), ("4/3", "-3/2")]
SWEEPS = [
    # principal axes: numbers in columns, some of them left to their scenes
    (heavy("9"), {"start.omega[3]": "0.5:9:11", "body.moments[2]": [3, 4]}),
    (heavy("-9"), {"body.moments[2]": "2:6:3", "body.centre[1]": ["0", "1/7"]}),
    (heavy("9"), {"start.omega[2]": ["sqrt(2)", "1/3"], "body.weight": [1, "pi", 0]}),
    (heavy("9"), {"start.gamma[1]": ["2/7"], "start.gamma[3]": ["6/7", "-6/7"]}),
    (polhode.top(moments=[1, 2, 3], **OMEGA, at=[0, 1, 3]), {"start.omega[1]": [0, "0.1"]}),
    # turned axes: in columns, or from member to member
    (MATRIX["irrational"], {"start.omega[3]": "0.1:7:5"}),
    (MATRIX["exchanged"], {"start.omega[3]": "0.1:7:5"}),
    (MATRIX["irrational"], {"start.omega[1]": ["1/3", -3, 0], "body.weight": "-2:2:3"}),
    (MATRIX["exchanged"], {"body.centre[1]": ["1/7", 1, 2]}),  # of two equal moments
    (MATRIX["own"], {"body.inertia[1][2]": [0, "0.5"]}),
    (polhode.top(**ABOUT, centre=LEVER["centre"], **START), {"body.centre[1]": ["1/7", 2]}),
    # starts of other kinds
    (starting(angles=[0, "pi/3", "1/5"], **OMEGA), {"start.angles[2]": ["1", "pi/2"]}),
    (
        starting(quaternion=[1, 0.1, 0.2, 0.3], **OMEGA, normalise=True),
        {"start.quaternion[2]": ["1/10", "1/5"]},
    ),
    (starting(gamma=START["gamma"], h=3, f=2, sign="+"), {"body.weight": [1, 2]}),
]
MORE_SWEEPS = [
    (heavy("9"), {"start.omega[1]": ["1/3", "-1e-3", 0], "body.weight": "-2:2:3"}),
    (heavy("9"), [{"start.omega[1]": k, "body.weight": f"1/{k}"} for k in (1, 2, 3)]),
    (scene_of(MOMENTUM), {"start.omega[3]": [1, 3]}),  # members take the principal form
    (MATRIX["rational"], {"body.centre[1]": ["0", -1], "start.omega[2]": ["sqrt(2)", "-1/10"]}),
    (MATRIX["irrational"], {"start.omega[1]": [1, 100], "body.inertia[1][2]": ["0.5", 0]}),
    (starting(angles=[0, "pi/3", "1/5"], rates=[0, 1, 5]), {"start.rates[3]": [5, 6]}),
]


@pytest.mark.parametrize(("scene", "given"), tiers(SWEEPS, MORE_SWEEPS))
def test_members_are_the_runs_of_their_scenes(scene, given):
    many = polhode.integrate_many(scene, given, workers=1)
    assert_own_runs(many, turned="inertia" in scene.source or not scene.body.axes.trivial)
    assert len({states.tobytes() for states in many.states}) == len(many)


@pytest.mark.parametrize("number", ["double", "extended"])
def test_members_that_no_type_of_theirs_refines_are_refused_as_runs_are(number):
    with pytest.raises(polhode.BadInput) as many:
        polhode.integrate_many(LAGRANGE, {"body.weight": [1]}, number=number, method="refined")
    with pytest.raises(polhode.BadInput) as one:
        polhode.integrate(LAGRANGE, number, method="refined")
    assert str(many.value) == str(one.value)


LONG = [0, "1/3", 20]


@pytest.mark.parametrize(
    ("at", "number", "tol", "method"),
    tiers(
        [([3], "extended", None, "auto"), (LONG, "extended", "1e-15", "auto")],
        [
            ([3], "quad", None, "auto"),
            (LONG, "quad", None, "auto"),
            (LONG, "quad", "1e-25", "auto"),
            ([3], "quad", None, "taylor"),
        ],
    ),
)
def test_members_of_wider_types_are_their_runs_to_the_bit(number, tol, method, at):
    """Also one about turned axes, and one that stands still."""
    cases = [
        (LAGRANGE, {"start.omega[3]": [3, "4.1"]}),
        (MATRIX["rational"], [{"start.omega[1]": "1/3"}, {"start.omega[1]": 2}]),
    ]
    if number != "extended":  # where what stands still is integrated as all others are
        cases.append(("staude/stable", {"start.psi": [0]}))
    methods = set()
    for scene, varied in cases:
        many = polhode.integrate_many(scene, varied, at=at, number=number, tol=tol, method=method)
        for k, member in enumerate(many.members):
            told = {"tol": tol, "method": many[k].method, "project": False}
            alone = polhode.integrate(replace(member, form="principal").at(at), number, **told)
            assert np.array_equal(alone.states, many.states[k])
            assert (alone.outcome, alone.reached) == (many.outcomes[k], many.reached[k])
            assert alone.steps == many.steps[k]
            methods.add(many[k].method)
    long = at[-1] == 20  # units of 20 radians and more: refinement pays
    assert ("refined" in methods) == ((number, tol, method) == ("quad", None, "auto") and long)
    assert "taylor" in methods


@pytest.mark.parametrize(
    ("scene", "given"),
    [
        (MATRIX["irrational"], {"start.omega[1]": ["1e-200", "1e60"], "body.weight": "-2:2:3"}),
        (MATRIX["rational"], {"start.omega[1]": ["1e-200", "1e60"], "body.weight": [0, 1]}),
        (MATRIX["irrational"], {"body.inertia[1][1]": ["3"], "start.omega[1]": [1, 5]}),
        (starting(gamma=[0, 0, 1], **OMEGA), {"start.omega[1]": ["1", "1e80"]}),
        (HUGE, {"body.weight": ["1e-9", "1e210"]}),
    ],
)
def test_numbers_of_any_size_begin_where_they_should(scene, given):
    """Beyond doubles on the way: 0/0 was computed of members that are left to their scenes."""
    many = polhode.integrate_many(scene, given, at=[0])
    for states, member in zip(many.states, many.members, strict=True):
        start = np.array([[float(x) for x in member.start]])
        for part in (slice(0, 3), slice(3, 6)):
            near = 2.0**-51 * np.abs(start[:, part]).max()
            assert np.allclose(states[:, part], start[:, part], rtol=0, atol=near)


@pytest.mark.parametrize("end", ["1000", "1e250"])
def test_members_by_their_scenes_have_the_bound_of_their_energy(end):
    """The rate at the start is none where the least moment is small: no limit ended such a one."""
    own = 1000 / Fraction(end)
    start = {"omega": [own, 0, 0], "gamma": [0, "3/5", "4/5"], "end": 1}
    scene = polhode.top(moments=[1, 1, "1e-12"], centre=[1, 0, 0], weight=own**2, **start)
    given = {"body.weight": [f"sqrt(2)*{own**2}"]}
    begun = time.process_time()
    many = polhode.integrate_many(scene, given, at=[end], max_steps=5000)
    assert many.outcomes == (polhode.Outcome.STEP_LIMIT,)
    assert many.steps[0] <= 5000
    assert time.process_time() - begun < 5


def test_times_below_the_type_in_a_members_own_unit_are_refused():
    """Their states were whatever the memory held, or not a number, and all had arrived."""
    start = {"omega": ["1e-9", 0, 0], "gamma": [0, 0, 1], "end": 1}
    scene = polhode.top(moments=[3, 2, 1.5], centre=[0.5, 0, 1], weight=2.0**-40, **start)
    for at in (["5e-324", "1e-323", 1], [0, "-5e-324", -1]):
        with pytest.raises(polhode.BadInput, match="a type of wider range"):
            polhode.integrate_many(scene, {"start.omega[1]": ["1e-9"]}, at=at)
    assert polhode.integrate_many(scene, {"start.omega[1]": ["1e-9"]}, at=[0, "1e-300"]).complete


def test_the_unit_of_time_next_to_a_power_of_two():
    """Where eight bits round to the next power of two the exponent is the scene's own."""
    fourth_root = "0.9995113607141298"  # of 1 - 1/512
    rates = [f"{fourth_root} + {k}e-10" for k in (-9, -1, 0, 1, 9)] + ["0.999", "1", "1.001"]
    scene = polhode.top(moments=[1, 2, 3], omega=[1, 0, 0], end=1)
    many = polhode.integrate_many(scene, {"start.omega[1]": rates})
    assert len({member.time_unit for member in many.members}) == 2
    assert_own_runs(many)


@pytest.mark.parametrize("key", ["start.omega[2]", "body.weight"])
def test_members_are_the_same_in_however_many_blocks_they_are_read(monkeypatch, key):
    """One in a later block is put in by its scene, after others of the same body and none."""
    given = {"start.omega[1]": ["1/3", 8], key: [1, 3, 5, "sqrt(2)", 7]}
    whole = polhode.integrate_many(heavy("9"), given, at=[1])
    monkeypatch.setattr("polhode.runs.members.BLOCK", 2)
    parts = polhode.integrate_many(heavy("9"), given, at=[1])
    assert parts.states.tobytes() == whole.states.tobytes()
    assert parts.steps == whole.steps
    assert len({member.time_unit for member in whole.members}) > 1


@pytest.mark.parametrize("number", ["double", "extended"])
def test_what_cancels_along_turned_axes_is_exactly_nothing(number):
    """In pairs of doubles 3/5 of -20/51 and 4/5 of 5/17 leave 3e-33."""
    inertia = [["66/25", "-12/25", 0], ["-12/25", "59/25", 0], [0, 0, 4]]
    scene = polhode.top(inertia=inertia, omega=[1, "5/17", 1], end=1)
    given = {"start.omega[1]": ["-20/51", "4/3"]}
    plan = sweep_plan.planned(scene, members_of_grid(given, scene.name), number, None, None, None)
    exact = [member.body.axes.components(member.omega) for member in plan.members]
    assert [[x == 0 for x in row] for row in exact] == (plan.numbers.starts == 0).tolist()
    assert (plan.numbers.starts[0] == 0).any()
    units = [Fraction(2) ** int(n) for n in plan.numbers.exponents]
    near = [[float(x * unit) for x in row] for row, unit in zip(exact, units, strict=True)]
    assert np.array_equal(plan.numbers.starts.astype(float), near)


@pytest.mark.parametrize("end", tiers(["600"], ["-600"]))
def test_long_sweeps_of_slow_and_fast_members_in_any_order(end):
    """Neighbours of another speed or unit, and members cut into chunks, change no bit."""
    spins = [2 + (37 * k % 61) / 61 for k in range(61)]
    many, back, few = (
        polhode.integrate_many(heavy(end, samples=3), {"start.omega[3]": some}, workers=workers)
        for some, workers in ((spins, 1), (spins[::-1], 3), ([spins[5], 90, spins[6]], None))
    )
    assert np.array_equal(many.states, back.states[::-1])
    assert many.counts.tolist() == back.counts[::-1].tolist()
    assert np.array_equal(few.states[[0, 2]], many.states[5:7])


@pytest.mark.parametrize(
    ("scene", "given", "fourth"),
    [
        (heavy(), {"start.omega[3]": ["0.5", 1], "body.weight": ["0", "1/3"]}, [1, 0, 1, 0]),
        ("lagrange/nutation", {"body.weight": [1, 2, 0]}, [1, 1, 1]),
        ("kovalevskaya/generic", {"body.moments[3]": [1, "0.5"]}, [1, 0]),
        ("goryachev-chaplygin/inner-band", {"body.weight": [1, 3]}, [1, 1]),
        # f is exactly 0 of two members, which pairs of doubles do not tell
        (
            polhode.top(
                moments=[4, 4, 1], centre=[1, 0, 0], weight=1, omega=[0, 0, "1/2"], **FLAT, at=[1]
            ),
            [{"start.omega[1]": p, "start.omega[2]": q} for p, q in AREAS],
            [1, 1, 0],
        ),
        ("lagrange/turned-axes", {"body.weight": [1]}, [1]),
        (
            replace(heavy(), gamma=None, body=polhode.Body.of_moments((2, 3, 4))),
            {"start.omega[2]": [1, "7/5"]},
            [1, 1],
        ),
        (heavy(), {"body.moments[3]": ["3.25"], "body.moments[1]": ["3.5"]}, [0]),  # A the largest
        (heavy(), ARRAYS, [0, 0]),
        (MATRIX["irrational"], ARRAYS, [0, 0]),
        ("lagrange/nutation", ARRAYS, [1, 1]),
    ],
)
def test_drift_of_all_members_is_the_drift_of_each(scene, given, fourth):
    """Against 117 bits, one member after the other: to 1e-9 of a drift of a few eps.

    Turned axes, and an f that may be 0, are left to each member's own drift, in 64 bits.
    """
    many = polhode.integrate_many(scene, given, at=[0, 3, 7])
    alone = isinstance(given, list) or not many[0].scene.body.axes.trivial
    near = 1e-3 if alone else 1e-9
    assert (~np.isnan(many.drift[:, 3])).tolist() == [bool(x) for x in fourth]
    for k in range(len(many)):
        rows = [[exactly(x) for x in row] for row in many.states[k]]
        departures = polhode.departures(many[k].scene, rows, 53).values()
        true = [float(np.abs(column).max()) for column in departures]
        if many[k].scene.gamma is None:
            true[1:1] = [None, None]
        true += [None] * (4 - len(true))
        assert [x == x for x in many.drift[k]] == [x is not None for x in true]
        for x, y in zip(many.drift[k], true, strict=True):
            if y is not None:
                assert abs(x - y) <= near * y + 1e-25
    assert 1e-17 < np.nanmax(many.drift) < 1e-14


def test_reductions_of_members_whose_axes_turn_are_those_of_each():
    scene, given = MATRIX["irrational"].at([0, 3]), {"body.centre[1]": ["1/7", 1, 2]}
    found = polhode.integrate_many(scene, given, workers=1)
    kept = polhode.reduce_many(scene, given, keep=["final", "first equator"])
    met = []
    for k, member in enumerate(found.members):
        final = [kept[f"final {name}"][k] for name in scene.columns]
        assert np.abs(np.array(final) - found.states[k, -1]).max() < 2**-40
        own = polhode.reduce_many(member.at(scene.times), {"start.psi": [0]}, keep="first equator")
        for name in own.names:  # both nan where it does not come
            assert np.allclose(kept[name][k], own[name][0], rtol=0, atol=2**-40, equal_nan=True)
            met.append(own[name][0])
    assert np.isfinite(met).sum() > 6


# -- what is varied -------------------------------------------------------------------------------


def test_a_scene_changed_in_python_is_varied_as_it_is():
    scene = replace(heavy(), omega=(9, 9, 9))
    many = polhode.integrate_many(scene, {"start.omega[1]": [1]}, at=[1])
    assert (many.members[0].omega, many.members[0].gamma) == ((1, 9, 9), scene.gamma)
    made = polhode.Scene(
        polhode.Body.of_moments((2, 3, 4), (0.5, 0, 0), 1), (1, 0, 0), (1, 0, 0), times=(1,)
    )
    many = polhode.integrate_many(made, {"body.moments[3]": [4, 4.5], "start.omega[2]": [0, 1]})
    assert [m.body.moments[2] for m in many.members] == [4, 4, 4.5, 4.5]


BOTH_HALVES = {"body.inertia[1][2]": [0], "body.inertia[2][1]": [1]}
FINE = {"start.omega[1]": "0:1:10000", "start.omega[2]": "0:1:1001"}
#: What is varied of the heavy body, and the refusal.
REFUSED = [
    ({}, "vary: expected at least one number of the scene file to vary"),
    ({"start.omga[1]": [1]}, r"start.omga\[1\]: .*did you mean 'start.omega\[1\]'"),
    ({"start.omega[4]": [1]}, r"vary = start.omega\[4\]: expected a number of the scene"),
    ({"run.end": [1]}, "vary = run.end: expected a number of the scene"),
    ({"start.omega[1]": []}, r"start.omega\[1\] = nothing: expected at least one value"),
    ({"start.omega[1]": 1}, r"start.omega\[1\] = 1: expected a sequence of numbers"),
    *(({"start.omega[1]": f"1:2{x}"}, "expected FROM:TO:N") for x in (":0", ":-3", ":2.5", "")),
    ({"start.omega[1]": "1:x:3"}, "expected numbers"),
    ({"start.omega[1]": [float("nan")]}, "= nan: expected a number"),
    (FINE, "10010000 members: .*10000000;"),
    (
        {"body.moments[3]": [5, 6]},
        r"member 2 \(body.moments\[3\] = 6\): body.moments = \[2, 3, 6\]:",
    ),
    ({"body.moments[3]": [2, 3, 4, 5, 6, 7]}, r"member 5 \(body.moments\[3\] = 6\): body.moments"),
    ({"start.gamma[1]": [0]}, r"member 1 .*: expected length exactly 1, or normalise"),
    ([{"body.weight": 1}, {"start.psi": 1}], "member 2 = start.psi: expected the keys body.w"),
    ({"start.omega[1]": [1, "1e250"]}, r"member 2 .*: number = double: expected a type"),
]
EQUATOR = heavy("1", more='[[events]]\nname = "equator"\n')


@pytest.mark.parametrize(
    ("scene", "given", "message"),
    [
        *((heavy(), *row) for row in REFUSED),
        (MATRIX["own"], BOTH_HALVES, "they are one number"),
        (EQUATOR, {"body.weight": [1]}, "events = equator: expected none in a sweep"),
    ],
)
def test_what_cannot_be_varied_is_refused_in_one_line(scene, given, message):
    with pytest.raises(polhode.BadInput, match=message) as fault:
        polhode.integrate_many(scene, given)
    assert "\n" not in str(fault.value)


def test_nothing_is_written_into_a_sweep():
    """Members, tables and files told what was."""
    scene = replace(polhode.load("lagrange/nutation"), outputs=("integrals",))
    many = polhode.integrate_many(scene, {"start.omega[3]": [4, 5]}, at=[1])
    for each in (many, pickle.loads(pickle.dumps(many))):
        arrays = (each.states, each.endings, each.counts, each.arrived, each.drift)
        for array in (*arrays, each.outputs["integrals"], each.attitude):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 0


def test_a_long_sweep_is_printed_by_its_ends():
    many = polhode.integrate_many("lagrange/nutation", {"start.omega[3]": "2:4:3000"}, at=["0.1"])
    rows = str(many).splitlines()
    assert len(rows) == 42
    assert [rows[k].split()[0] for k in (1, 20, 21, 22, -1)] == ["1", "20", "...", "2981", "3000"]
    assert "2960 more of 3000 members" in rows[21]
    few = polhode.integrate_many("lagrange/nutation", {"start.omega[3]": "2:4:60"}, at=["0.1"])
    assert len(str(few).splitlines()) == 61


def test_parts_are_kept_in_a_folder_named_by_text(tmp_path):
    folder = tmp_path / "parts"
    again = [
        polhode.integrate_many("lagrange/nutation", {"body.weight": [1, 2]}, at=[1], parts=parts)
        for parts in (str(folder), folder)
    ]
    assert np.array_equal(again[0].states, again[1].states)
    assert again[0].kept.folder == again[1].kept.folder == folder
    with pytest.raises(polhode.BadInput, match="parts"):
        polhode.reduce_many("lagrange/nutation", {"body.weight": [1]}, "final", parts=3)


@pytest.mark.parametrize("mode", [0x400, 0x800, 0xC00])
def test_a_rounding_mode_that_a_library_left_is_refused(mode):
    libm = ctypes.CDLL(None)
    if not hasattr(libm, "fesetround") or platform.machine() != "x86_64":
        pytest.skip("no rounding mode to set")
    case, vary_one = polhode.load("lagrange/nutation"), {"body.weight": [1, 2]}
    for way in (
        lambda: polhode.integrate(case),
        lambda: polhode.propagator(case),
        lambda: polhode.integrate_many(case, vary_one),
        lambda: polhode.reduce_many(case, vary_one, "final"),
        lambda: polhode.section(case, starts=[[1, 0.2]], crossings=1),
    ):
        libm.fesetround(mode)
        try:
            with pytest.raises(polhode.BadInput, match="rounding mode"):
                way()
        finally:
            libm.fesetround(0)


@pytest.mark.parametrize("number", ["double", "extended"])
def test_the_attitude_of_members_is_that_of_their_own_runs(number):
    """It was not to be had of a sweep."""
    vary = {"start.omega[3]": [2, "5/2"]}
    many = polhode.integrate_many("lagrange/nutation", vary, at=[0, "1/2", 2], number=number)
    assert many.attitude.shape == (2, 3, 4)
    for k, member in enumerate(many.members):
        scene = replace(member, times=many.scene.times, outputs=("attitude",))
        run = polhode.integrate(scene, number=number, method="taylor", project=False)
        assert np.array_equal(many.attitude[k], run.attitude)
        assert 14.9 < min(polhode.compare(run).part_digits["attitude"]) < 20


def test_no_attitude_is_made_up_where_a_member_did_not_come_or_has_no_vertical():
    vary = {"start.omega[3]": [2, 300]}
    many = polhode.integrate_many("lagrange/nutation", vary, at=[0, 1, 100], max_steps=150)
    there = np.isfinite(many.attitude[:, :, 0])
    assert there.tolist() == np.isfinite(many.states[:, :, 0]).tolist()
    assert there.sum() == 3
    free = scene_of(free_file("at = [0, 1]"), "top.toml")
    with pytest.raises(polhode.BadInput, match="attitude: expected a start with gamma"):
        _ = polhode.integrate_many(replace(free, gamma=None), {"start.omega[3]": [1]}).attitude
